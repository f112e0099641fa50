//! Both splits of a chain with details: sites move on their own, by the exact flow of each, and
//! contacts and drives kick.
//!
//! On the linear split springs are part of the motion of a site, on the kinetic one they kick. Drag
//! and dashpots are part of the motion on both, so that it is exact with them, and what they
//! dissipate is, too. The clock is part of the drift.
//!
//! What drives put in is kept as `p`, which kicks change by what depends on positions only:
//! `p' = -F' u` for a bead that is pushed, `p' = -f s'` with its contact force `f` for one that is
//! moved. Then `driven = p + F u + m s'^2/2`, and schemes made for such kicks keep their order.

use super::{
    super::{Chain, Resonators},
    Ledger, Means, Parts, SiteParts,
    propagator::{Class, Propagator},
};
use crate::run::method::Split;
use hertzchain_integrators::{Real, SplitFlow, Twofold, system::ContactFlow};
use std::{collections::HashMap, sync::Arc};

/// Drifts whose propagators are kept: those that a scheme repeats.
const KEPT: usize = 16;

/// A time, and what each class of sites does over it.
type Kept<R> = (Twofold<R>, Arc<Vec<Propagator<R>>>);

/// A chain with details, split into the motion of its sites and the kicks of contacts and drives.
///
/// Contacts that dissipate are no kicks, since their forces depend on velocities: a chain with
/// these has no such split.
pub struct SitewiseFlow<R> {
    chain: Chain<R>,
    split: Split,
    classes: Arc<Vec<Class<R>>>,
    /// The class of each site.
    class: Arc<Vec<u32>>,
    /// The sites, in the variables of their classes.
    z: Vec<[R; 4]>,
    ledger: Ledger<R>,
    start: Twofold<R>,
    time: Twofold<R>,
    kept: Vec<Kept<R>>,
    /// Positions of beads, and forces on them.
    u: Vec<R>,
    force: Vec<R>,
}

impl<R: Real> SitewiseFlow<R> {
    /// The chain at rest at time `start`; load a state into it. Without details it is the uniform
    /// chain, slower than by the flows made for it.
    ///
    /// # Panics
    /// A chain whose contacts dissipate.
    pub fn new(chain: Chain<R>, split: Split, start: R) -> Self {
        assert!(!chain.dissipative_contacts(), "contacts that dissipate are no kicks");
        let chain = match chain.parts() {
            Some(_) => chain,
            None => chain.with(&super::Details::default()).expect("a chain of displacements"),
        };
        let (mut classes, mut class) = (Vec::new(), Vec::new());
        // Kinds of sites with their classes, by what they round to: all sites may differ.
        let mut known: HashMap<[u64; 5], Vec<(SiteParts<R>, u32)>> = HashMap::new();
        for site in &parts(&chain).sites {
            let rounded = [site.mass, site.kappa, site.rho, site.drag, site.dashpot].map(|x| x.f64().to_bits());
            let alike = known.entry(rounded).or_default();
            let found = alike.iter().find(|(kind, _)| kind == site).map(|&(_, index)| index);
            class.push(found.unwrap_or_else(|| {
                let index = classes.len() as u32;
                classes.push(Class::new(site, split));
                alike.push((*site, index));
                index
            }));
        }
        let (n, zero) = (chain.sites(), R::zero());
        Self {
            split,
            classes: Arc::new(classes),
            class: Arc::new(class),
            z: vec![[zero; 4]; n],
            ledger: Ledger::of(&[zero; super::LEDGER]),
            start: Twofold::new(start),
            time: Twofold::new(start),
            kept: Vec::new(),
            u: vec![zero; n],
            force: vec![zero; n],
            chain,
        }
    }

    fn class(&self, i: usize) -> &Class<R> {
        &self.classes[self.class[i] as usize]
    }

    /// Position and velocity of a bead.
    fn bead(&self, i: usize) -> [R; 2] {
        self.class(i).bead(&self.z[i])
    }

    /// `F u + m s'^2/2` of all drives, now.
    fn held_by_drives(&self) -> R {
        let parts = parts(&self.chain);
        parts.drives().iter().fold(R::zero(), |sum, drive| {
            let [value, first, _] = drive.signal.at(self.time.value());
            sum + match drive.means {
                Means::Pushed => value * self.bead(drive.site)[0],
                Means::Moved => R::of(0.5) * parts.sites[drive.site].mass * first * first,
            }
        })
    }

    /// Puts beads that are moved where they are now.
    fn follow(&mut self) {
        let t = self.time.value();
        let Self { chain, z, .. } = self;
        for drive in parts(chain).drives().iter().filter(|drive| drive.means == Means::Moved) {
            let [s, s_dot, _] = drive.signal.at(t);
            z[drive.site] = [s, R::zero(), s_dot, R::zero()];
        }
    }

    /// The motion of all classes over a time.
    fn propagators(&mut self, dt: Twofold<R>) -> Arc<Vec<Propagator<R>>> {
        if let Some((_, kept)) = self.kept.iter().find(|(time, _)| *time == dt) {
            return Arc::clone(kept);
        }
        let made = Arc::new(self.classes.iter().map(|class| class.over(dt)).collect());
        if self.kept.len() < KEPT {
            self.kept.push((dt, Arc::clone(&made)));
        }
        made
    }

    /// Contact forces on all beads at the present positions.
    fn contacts(&mut self) {
        for i in 0..self.z.len() {
            self.u[i] = self.bead(i)[0];
        }
        let Self { chain, u, force, .. } = self;
        force.fill(R::zero());
        let parts = parts(chain);
        for bond in chain.touching() {
            let contact = &parts.bonds[bond];
            let g = contact.rest + chain.across(bond, |i| u[i]);
            if g <= R::zero() {
                continue;
            }
            let f = contact.elastic(g);
            for &(site, weight) in chain.topology().pushed(bond).iter() {
                force[site] += R::of(weight) * f;
            }
        }
    }

    /// The springs of the kinetic split.
    fn springs(&mut self, kick: R) {
        for i in 0..self.z.len() {
            let site = parts(&self.chain).sites[i];
            let pull = match site.resonators {
                Resonators::None => continue,
                Resonators::Fixed => site.kappa * self.z[i][0],
                Resonators::Moving => site.kappa * (self.z[i][0] - self.z[i][1]),
            };
            self.force[i] -= pull;
            if site.resonators == Resonators::Moving {
                self.z[i][3] += kick * (pull / site.resonator());
            }
        }
    }

    fn drives(&mut self, kick: R) {
        let t = self.time.value();
        let Self { chain, u, force, ledger, .. } = self;
        for drive in parts(chain).drives() {
            let ([value, first, _], i) = (drive.signal.at(t), drive.site);
            match drive.means {
                Means::Pushed => {
                    force[i] += value;
                    ledger.driven -= kick * (first * u[i]);
                }
                Means::Moved => ledger.driven -= kick * (force[i] * first),
            }
        }
    }
}

fn parts<R: Real>(chain: &Chain<R>) -> &Parts<R> {
    chain.parts().expect("a flow site by site has details")
}

impl<R: Real> SplitFlow<R> for SitewiseFlow<R> {
    fn dim(&self) -> usize {
        self.chain.layout().dim()
    }

    fn load(&mut self, y: &[R]) {
        let layout = self.chain.layout();
        let (u, v, u_dot, v_dot) = (layout.u(y), layout.v(y), layout.u_dot(y), layout.v_dot(y));
        for i in 0..u.len() {
            let of = |array: Option<&[R]>| array.map_or(R::zero(), |array| array[i]);
            self.z[i] = self.class(i).split([u[i], of(v), u_dot[i], of(v_dot)]);
        }
        self.time = self.start;
        self.follow();
        if let Some(ledger) = layout.ledger(y) {
            self.ledger = ledger;
            self.ledger.driven -= self.held_by_drives();
        }
    }

    fn store(&self, y: &mut [R]) {
        let (layout, n) = (self.chain.layout(), self.z.len());
        let half = layout.half();
        for (i, site) in parts(&self.chain).sites.iter().enumerate() {
            let [u, v, u_dot, v_dot] = self.class(i).join(self.z[i], site.resonators);
            (y[i], y[half + i]) = (u, u_dot);
            if layout.resonators() {
                (y[n + i], y[half + n + i]) = (v, v_dot);
            }
        }
        if layout.has_ledger() {
            let driven = self.ledger.driven + self.held_by_drives();
            y[2 * half..].copy_from_slice(&Ledger { driven, ..self.ledger }.entries());
        }
    }

    fn duplicate(&self) -> Self {
        Self {
            chain: self.chain.clone(),
            split: self.split,
            classes: Arc::clone(&self.classes),
            class: Arc::clone(&self.class),
            z: self.z.clone(),
            ledger: self.ledger,
            start: self.start,
            time: self.time,
            kept: self.kept.clone(),
            u: self.u.clone(),
            force: self.force.clone(),
        }
    }

    fn copy_from(&mut self, other: &Self) {
        self.z.copy_from_slice(&other.z);
        (self.ledger, self.time) = (other.ledger, other.time);
    }

    fn drift(&mut self, dt: Twofold<R>) {
        let propagators = self.propagators(dt);
        for (z, &class) in self.z.iter_mut().zip(self.class.iter()) {
            let [drag, dashpot] = propagators[class as usize].apply(z);
            self.ledger.drag += drag;
            self.ledger.dashpots += dashpot;
        }
        self.time = self.time + dt;
        self.follow();
    }

    fn kick_drift(&mut self, kick: R, drift: Twofold<R>) {
        self.contacts();
        // Beads that are pushed may have springs, those that are moved have none.
        if self.split == Split::Kinetic {
            self.springs(kick);
        }
        self.drives(kick);
        let parts = parts(&self.chain);
        for (i, site) in parts.sites.iter().enumerate().filter(|(_, site)| !site.moved) {
            let class = &self.classes[self.class[i] as usize];
            class.kick(&mut self.z[i], kick * (self.force[i] / site.mass));
        }
        self.drift(drift);
    }
}

impl<R: Real> ContactFlow<R> for SitewiseFlow<R> {
    fn bonds(&self) -> usize {
        self.chain.touching().len()
    }

    fn overlaps(&self, overlaps: &mut [R], rates: &mut [R]) -> R {
        let parts = parts(&self.chain);
        self.chain.across_bonds(R::zero(), |i| self.bead(i)[0], overlaps);
        self.chain.across_bonds(R::zero(), |i| self.bead(i)[1], rates);
        for (overlap, bond) in overlaps.iter_mut().zip(self.chain.touching()) {
            *overlap += parts.bonds[bond].rest;
        }
        self.chain.dead_band((0..self.z.len()).map(|i| self.bead(i)[0]))
    }
}
