//! The interface of a chain with details to contact collocation: every bond is between two sites
//! with kernels of their own.

use super::{
    super::{Chain, Layout, Ledger, Modes, Params, Resonators},
    CheckedDetails, Course, Envelope, Signal, SiteData,
};
use hertzchain_integrators::{
    DoubleDouble, Error,
    collocation::{self, ContactChain, Path, Response},
    law::BondLaw,
};

/// Overlap at the origin of a bond whose contact constant is zero, so that it never closes.
const APART: f64 = -1e100;

/// A chain with [`Details`](super::Details).
#[derive(Clone, Debug)]
pub struct HeterogeneousChain {
    chain: Chain<f64>,
    sites: Vec<Motion>,
    /// Weights of beads along the chain; empty without gravity.
    weights: Vec<f64>,
}

/// The free motion and the oscillation of a site.
#[derive(Clone, Copy, Debug)]
struct Motion {
    modes: Modes<f64>,
    /// Whether it has a resonator that moves.
    moving: bool,
    response: Response,
    /// Drag and slip, see [`ContactChain::damping`].
    damping: [f64; 2],
    /// Whether a drive prescribes its position.
    moved: bool,
}

impl Motion {
    fn new(site: &SiteData<f64>) -> Self {
        let modes = Modes::new(Params { alpha: 1.0, kappa: site.kappa / site.mass, rho: site.rho });
        let (mut response, mut damping) = (Response { m: 0.0, mu: 0.0, omega: DoubleDouble::zero() }, [0.0; 2]);
        if !site.moved {
            let (m, mu) = (modes.m / site.mass, modes.mu / site.mass);
            response = Response { m, mu, omega: modes.omega };
            // P'' = -(d/m) ((1 + rho)/rho) P' under the dashpot alone.
            let slip = if mu > 0.0 { site.dashpot / (mu * site.mass * site.mass) } else { 0.0 };
            damping = [site.drag, slip];
        }
        let moving = site.resonators == Resonators::Moving;
        Self { modes, moving, response, damping, moved: site.moved }
    }
}

impl HeterogeneousChain {
    /// The interface to a chain.
    ///
    /// # Errors
    /// A chain without details, or [beyond collocation](Chain::beyond_collocation).
    pub fn new(chain: Chain<f64>) -> Result<Self, Error> {
        let Some(parts) = chain.parts() else {
            let rule = "a chain with details";
            return Err(Error::Argument { name: "sites", value: chain.sites() as f64, rule });
        };
        if let Some(rule) = chain.beyond_collocation() {
            return Err(Error::Argument { name: "sites", value: chain.sites() as f64, rule });
        }
        let sites = parts.sites.iter().map(Motion::new).collect();
        let weights = parts.weights().map(|(_, weight)| weight).collect();
        Ok(Self { chain, sites, weights })
    }

    fn parts(&self) -> &CheckedDetails<f64> {
        self.chain.parts().expect("a chain with details")
    }

    /// The signals of the drives of a site.
    fn signals_of(&self, site: usize) -> impl Iterator<Item = &Signal> {
        let acting = self.parts().acting().iter().filter(move |acting| acting.site == site);
        acting.flat_map(|acting| &acting.signals)
    }

    /// The weight of a site along the chain, for which there is a drive like for a constant force.
    fn weight(&self, site: usize) -> f64 {
        self.weights.get(site).copied().unwrap_or(0.0)
    }

    /// The scale of the velocities that a drive of a site causes. If it moves its bead: the speed
    /// of the bead, or of its neighbours if it pushes them from a place at which it stays. If it is
    /// a force, that of harmonics without a common phase: the speed amplitude of the free bead; for
    /// a constant force, the speed from its work up to the overlap at which a contact balances it.
    /// Other functions count as harmonics of their greatest frequency.
    fn speed(&self, site: usize, signal: &Signal) -> f64 {
        let (parts, topology) = (self.parts(), self.chain.topology());
        if self.sites[site].moved {
            let thrown = |bond: usize| {
                let law = &parts.bonds[bond];
                let free = topology.ends(bond).into_iter().flatten().filter(|&i| !self.sites[i].moved);
                let overlap = law.rest.max(0.0) + signal.size();
                let mass = free.map(|i| parts.sites[i].mass).fold(f64::INFINITY, f64::min);
                (2.0 * law.elastic(overlap) * overlap / mass).sqrt()
            };
            let speed = signal.speed();
            let still = topology.bonds(site).into_iter().flatten().map(thrown);
            return if speed > 0.0 { speed } else { still.fold(0.0, f64::max) };
        }
        let mass = parts.sites[site].mass;
        let contacts = topology.bonds(site).into_iter().flatten().map(|bond| &self.parts().bonds[bond]);
        let stiff = contacts.filter(|contact| contact.constant > 0.0);
        let depths = |force: f64| stiff.clone().map(move |c| (force / c.constant).powf(1.0 / c.alpha()));
        let of = |force: f64, omega: f64| {
            if omega > 0.0 {
                return force / (mass * omega);
            }
            let depth = depths(force).fold(f64::INFINITY, f64::min);
            if depth.is_finite() { (2.0 * force * depth / mass).sqrt() } else { force / mass }
        };
        let harmonics = signal.harmonics.iter().map(|one| of(one.amplitude.abs(), one.omega)).fold(0.0, f64::hypot);
        let other = Signal { harmonics: Vec::new(), ..signal.clone() };
        if signal.course.is_some() { harmonics + of(other.size(), other.frequency()) } else { harmonics }
    }

    /// The time from which a site is moved steadily; infinity if it never is.
    fn linear_from(&self, site: usize) -> f64 {
        let steady = |signal: &Signal| matches!(signal.course, Some(Course::Steady { .. }));
        let linear = |signal: &Signal| {
            let settles = matches!(signal.envelope, Envelope::None | Envelope::Ramp(_));
            settles
                && (steady(signal) || signal.course.is_none())
                && signal.harmonics.iter().all(|one| one.omega == 0.0)
        };
        match self.sites[site].moved && self.signals_of(site).any(steady) && self.signals_of(site).all(linear) {
            true => self.signals_of(site).map(Signal::settled).fold(0.0, f64::max),
            false => f64::INFINITY,
        }
    }

    fn layout(&self) -> Layout {
        self.chain.layout()
    }
}

impl ContactChain<2> for HeterogeneousChain {
    fn dim(&self) -> usize {
        self.layout().dim()
    }

    fn sites(&self) -> usize {
        self.sites.len()
    }

    fn bonds(&self) -> usize {
        self.chain.touching().len()
    }

    fn ring(&self) -> bool {
        self.chain.topology().ring()
    }

    #[inline(always)]
    fn bond(&self, bond: usize) -> BondLaw<f64> {
        let law = *self.parts().bonds[self.chain.topology().first() + bond];
        BondLaw { rest: if law.constant > 0.0 { law.rest } else { APART }, ..law }
    }

    fn response(&self, site: usize) -> Response {
        self.sites[site].response
    }

    #[inline(always)]
    fn ends(&self, bond: usize) -> [Option<usize>; 2] {
        let topology = self.chain.topology();
        match topology.ends(topology.first() + bond) {
            // A ring of one site, which no force moves.
            [Some(before), Some(behind)] if before == behind => [None, None],
            ends => ends,
        }
    }

    #[inline(always)]
    fn across(&self, bond: usize, quantity: impl Fn(usize) -> Path) -> [Path; 2] {
        let [before, behind] = self.ends(bond);
        let mut sides = [[0.0; 4]; 2];
        if let Some(site) = before {
            sides[0] = quantity(site);
        }
        if let Some(site) = behind {
            let path = quantity(site);
            for k in 0..4 {
                sides[1][k] = -path[k];
            }
        }
        sides
    }

    #[inline(always)]
    fn push(&self, site: usize, force: impl Fn(usize) -> [Path; 2]) -> Path {
        let topology = self.chain.topology();
        let ([before, behind], first) = (topology.bonds(site), topology.first());
        let mut push = [0.0; 4];
        if let Some(bond) = before {
            push = force(bond - first)[1];
        }
        if let Some(bond) = behind {
            let path = force(bond - first)[0];
            for k in 0..4 {
                push[k] -= path[k];
            }
        }
        push
    }

    fn path(&self, y: &[f64], i: usize) -> Path {
        if self.sites[i].moved {
            return [0.0; 4];
        }
        let layout = self.layout();
        let of = |array: Option<&[f64]>| array.map_or(0.0, |array| array[i]);
        self.sites[i].modes.path([layout.u(y)[i], of(layout.v(y)), layout.u_dot(y)[i], of(layout.v_dot(y))])
    }

    fn place(&self, parts: [f64; 4], i: usize, y: &mut [f64]) {
        let (n, layout) = (self.sites.len(), self.layout());
        let Motion { modes, moving, .. } = &self.sites[i];
        let [u, v, u_dot, v_dot] = modes.join(parts);
        let half = layout.half();
        (y[i], y[half + i]) = (u, u_dot);
        if layout.resonators() {
            (y[n + i], y[half + n + i]) = if *moving { (v, v_dot) } else { (0.0, 0.0) };
        }
    }

    fn dead_band(&self, largest: f64) -> f64 {
        64.0 * f64::EPSILON * largest
    }

    fn damping(&self, site: usize) -> [f64; 2] {
        self.sites[site].damping
    }

    fn drives(&self) -> Vec<collocation::Drive> {
        let mut sites: Vec<usize> = self.parts().acting().iter().map(|acting| acting.site).collect();
        sites.extend((0..self.weights.len()).filter(|&site| self.weights[site] != 0.0));
        sites.sort_unstable();
        sites.dedup();
        let drive = |site: usize| {
            let weight = self.weight(site);
            let sum = |of: &dyn Fn(&Signal) -> f64| self.signals_of(site).map(of).sum::<f64>();
            let by_weight = if weight == 0.0 { 0.0 } else { self.speed(site, &Signal::constant(weight)) };
            collocation::Drive {
                site,
                moved: self.sites[site].moved,
                linear_from: self.linear_from(site),
                varies: self.signals_of(site).filter_map(|signal| signal.envelope.span()).collect(),
                size: sum(&Signal::size) + weight.abs(),
                rate: sum(&Signal::speed).max(f64::MIN_POSITIVE),
                speed: sum(&|signal| self.speed(site, signal)) + by_weight,
            }
        };
        sites.into_iter().map(drive).collect()
    }

    fn signal(&self, site: usize, t: f64) -> [f64; 3] {
        self.signals_of(site).fold([self.weight(site), 0.0, 0.0], |sum, signal| {
            let by = signal.at(t);
            std::array::from_fn(|k| sum[k] + by[k])
        })
    }

    fn breaks(&self) -> Vec<f64> {
        self.chain.breaks()
    }

    fn ledger(&self, y: &[f64], t: f64) -> Path {
        let Some(ledger) = self.layout().ledger(y) else { return [0.0; 4] };
        Ledger { driven: ledger.driven - self.chain.kinetic_of_moved(t), ..ledger }.entries()
    }

    fn complete(&self, ledger: Path, t: f64, y: &mut [f64]) {
        let layout = self.layout();
        if !layout.has_ledger() {
            return;
        }
        let ledger = Ledger::of(&ledger);
        let driven = ledger.driven + self.chain.kinetic_of_moved(t);
        y[2 * layout.half()..].copy_from_slice(&Ledger { driven, ..ledger }.entries());
        self.chain.follow(t, y);
    }
}
