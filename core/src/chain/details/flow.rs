//! Both splits of a chain with details: sites move on their own, by the exact flow of each, and
//! contacts and drives kick.
//!
//! In the linear split springs are part of the drift of a site, in the kinetic split of the kick.
//! Drag and dashpots are part of the drift in both, so that the motion with them is exact, and so
//! are the energies that they dissipate. Time advances in the drift.
//!
//! The work of drives is kept as a quantity `p`, whose rate depends on positions and time only, so
//! that kicks can change it: `p' = -F' u` for a bead that is pushed by a force `F`, `p' = -f s'`
//! with its contact force `f` for one that is moved. The work is then `p + F u + m s'^2/2`, and
//! schemes made for such kicks keep their order.

mod bonds;

pub use bonds::SitewiseBonds;

use super::{
    super::{Chain, Ledger, Resonators, Split, layout::LEDGER},
    CheckedDetails, DriveKind, SiteData,
    loops::{Drift, Loops},
    propagator::Class,
};
use hertzchain_integrators::{DoubleDouble, Real, SplitFlow};
use std::{collections::HashMap, sync::Arc};

/// Largest number of times of drifts that are kept: enough for those that a scheme repeats.
const MEMOS: usize = 16;

/// The time of a drift, and the motion of each site over it if there was more than one such drift.
type Memo<R> = (DoubleDouble<R>, Option<Arc<Drift<R>>>);

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
    loops: Arc<Loops<R>>,
    /// The sites, in the variables of their classes.
    z: [Vec<R>; 4],
    /// The ledger of each member.
    ledgers: Vec<Ledger<R>>,
    start: DoubleDouble<R>,
    time: DoubleDouble<R>,
    /// Whether this is a copy, which moves to samples or to trial times. It keeps the motion over
    /// its first drift only, which for samples is the last drift of a step: so its bits do not
    /// depend on how often it was used before.
    copy: bool,
    kept: Vec<Memo<R>>,
    /// Positions of beads, see [`Loops::forces`], forces in bonds, and forces on beads.
    u: Vec<R>,
    push: Vec<R>,
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
        // Classes of sites by their rounded parameters, for a fast search: all sites may differ.
        let mut known: HashMap<[u64; 6], Vec<(SiteData<R>, u32)>> = HashMap::new();
        for site in &parts(&chain).sites {
            let rounded = [site.mass, site.kappa, site.rho, site.onsite, site.drag, site.dashpot];
            let rounded = rounded.map(|x| x.f64().to_bits());
            let alike = known.entry(rounded).or_default();
            let found = alike.iter().find(|(kind, _)| kind == site).map(|&(_, index)| index);
            class.push(found.unwrap_or_else(|| {
                let index = classes.len() as u32;
                classes.push(Class::new(site, split));
                alike.push((*site, index));
                index
            }));
        }
        let (n, members, zero) = (chain.sites(), chain.count(), R::zero());
        Self {
            split,
            loops: Arc::new(Loops::new(&chain, parts(&chain), &classes, &class)),
            classes: Arc::new(classes),
            class: Arc::new(class),
            z: std::array::from_fn(|_| vec![zero; n]),
            ledgers: vec![Ledger::of(&[zero; LEDGER]); members],
            start: DoubleDouble::new(start),
            time: DoubleDouble::new(start),
            copy: false,
            kept: Vec::new(),
            u: vec![zero; n + 2 * members],
            push: vec![zero; n + members],
            force: vec![zero; n],
            chain,
        }
    }

    fn class(&self, i: usize) -> &Class<R> {
        &self.classes[self.class[i] as usize]
    }

    fn site(&self, i: usize) -> [R; 4] {
        self.z.each_ref().map(|z| z[i])
    }

    /// Position and velocity of a bead.
    fn bead(&self, i: usize) -> [R; 2] {
        self.class(i).bead(&self.site(i))
    }

    /// The sum of `F u` and `m s'^2/2` of all drives, and of gravity, at the present time, of a
    /// member.
    fn held_by_drives(&self, member: usize) -> R {
        let (parts, own) = (parts(&self.chain), |site: usize| site % self.chain.count() == member);
        let weights = parts.weights().filter(|&(i, _)| own(i));
        let by_gravity = weights.fold(R::zero(), |sum, (i, weight)| sum + weight * self.bead(i)[0]);
        parts.acting().iter().filter(|drive| own(drive.site)).fold(by_gravity, |sum, drive| {
            let [value, first, _] = drive.at(self.time.value());
            sum + match drive.kind {
                DriveKind::Force => value * self.bead(drive.site)[0],
                DriveKind::Displacement => R::of(0.5) * parts.sites[drive.site].mass * first * first,
            }
        })
    }

    /// Sets beads that are moved to their prescribed positions and velocities at the present time.
    fn follow(&mut self) {
        let t = self.time.value();
        let Self { chain, z, .. } = self;
        for drive in chain.movers() {
            let [s, s_dot, _] = drive.at(t);
            z.iter_mut().zip([s, R::zero(), s_dot, R::zero()]).for_each(|(z, value)| z[drive.site] = value);
        }
    }

    /// The motion of all sites over a time that is repeated, as far as it is kept: from the second
    /// drift over this time on, as a motion costs many drifts. A copy keeps that of its first
    /// drift.
    fn repeated(&mut self, dt: DoubleDouble<R>) -> Option<Arc<Drift<R>>> {
        let Self { kept, loops, classes, class, .. } = self;
        if let Some((_, motion)) = kept.iter_mut().find(|(time, _)| *time == dt) {
            let motion = motion.get_or_insert_with(|| Arc::new(loops.over(dt, classes, class)));
            return Some(Arc::clone(motion));
        }
        if self.copy && kept.is_empty() {
            let motion = Arc::new(loops.over(dt, classes, class));
            kept.push((dt, Some(Arc::clone(&motion))));
            return Some(motion);
        }
        if !self.copy && kept.len() < MEMOS {
            kept.push((dt, None));
        }
        None
    }

    fn drives(&mut self, kick: R) {
        let t = self.time.value();
        let Self { chain, u, force, ledgers, .. } = self;
        let members = ledgers.len();
        parts(chain).weights().for_each(|(i, weight)| force[i] += weight);
        for drive in parts(chain).acting() {
            let ([value, first, _], i) = (drive.at(t), drive.site);
            let driven = &mut ledgers[i % members].driven;
            match drive.kind {
                DriveKind::Force => {
                    force[i] += value;
                    *driven -= kick * (first * u[members + i]);
                }
                DriveKind::Displacement => *driven -= kick * (force[i] * first),
            }
        }
    }
}

fn parts<R: Real>(chain: &Chain<R>) -> &CheckedDetails<R> {
    chain.parts().expect("a flow site by site has details")
}

impl<R: Real> SplitFlow<R> for SitewiseFlow<R> {
    fn dim(&self) -> usize {
        self.chain.full_dim()
    }

    fn load(&mut self, y: &[R]) {
        let (layout, members) = (self.chain.member(0).layout(), self.chain.count());
        for (m, y) in y.chunks(layout.dim()).enumerate() {
            let (u, v, u_dot, v_dot) = (layout.u(y), layout.v(y), layout.u_dot(y), layout.v_dot(y));
            for i in 0..u.len() {
                let at = i * members + m;
                let moves = parts(&self.chain).sites[at].resonators == Resonators::Moving;
                let of = |array: Option<&[R]>| array.filter(|_| moves).map_or(R::zero(), |array| array[i]);
                let site = self.class(at).split([u[i], of(v), u_dot[i], of(v_dot)]);
                self.z.iter_mut().zip(site).for_each(|(z, value)| z[at] = value);
            }
        }
        self.time = self.start;
        self.follow();
        for (m, y) in y.chunks(layout.dim()).enumerate() {
            if let Some(ledger) = layout.ledger(y) {
                self.ledgers[m] = Ledger { driven: ledger.driven - self.held_by_drives(m), ..ledger };
            }
        }
    }

    fn store(&self, y: &mut [R]) {
        let (layout, members) = (self.chain.member(0).layout(), self.chain.count());
        let (n, half) = (layout.sites(), layout.half());
        for (m, (y, ledger)) in y.chunks_mut(layout.dim()).zip(&self.ledgers).enumerate() {
            for i in 0..n {
                let at = i * members + m;
                let resonators = parts(&self.chain).sites[at].resonators;
                let [u, v, u_dot, v_dot] = self.class(at).join(self.site(at), resonators);
                (y[i], y[half + i]) = (u, u_dot);
                if layout.resonators() {
                    (y[n + i], y[half + n + i]) = (v, v_dot);
                }
            }
            if layout.has_ledger() {
                let driven = ledger.driven + self.held_by_drives(m);
                y[2 * half..].copy_from_slice(&Ledger { driven, ..*ledger }.entries());
            }
        }
    }

    fn duplicate(&self) -> Self {
        Self {
            chain: self.chain.clone(),
            split: self.split,
            classes: Arc::clone(&self.classes),
            class: Arc::clone(&self.class),
            loops: Arc::clone(&self.loops),
            z: self.z.clone(),
            ledgers: self.ledgers.clone(),
            start: self.start,
            time: self.time,
            copy: true,
            kept: Vec::new(),
            u: self.u.clone(),
            push: self.push.clone(),
            force: self.force.clone(),
        }
    }

    fn copy_from(&mut self, other: &Self) {
        self.z.iter_mut().zip(&other.z).for_each(|(z, other)| z.copy_from_slice(other));
        self.ledgers.copy_from_slice(&other.ledgers);
        self.time = other.time;
    }

    fn drift(&mut self, dt: DoubleDouble<R>) {
        // The last drift of a step may be none.
        if dt != DoubleDouble::zero() {
            let drift = self.repeated(dt);
            let classes = (&self.classes[..], &self.class[..]);
            self.loops.drift(&mut self.z, (dt, drift.as_deref()), classes, &mut self.ledgers);
        }
        self.time = self.time + dt;
        self.follow();
    }

    fn kick_drift(&mut self, kick: R, drift: DoubleDouble<R>) {
        let Self { chain, loops, z, u, push, force, .. } = self;
        loops.positions(z, &mut u[chain.count()..][..force.len()]);
        loops.forces(chain, parts(chain), u, push, force);
        // Beads that are pushed may have springs, those that are moved have none.
        if self.split == Split::Kinetic {
            loops.springs(z, force, kick);
        }
        self.drives(kick);
        self.loops.kick(&mut self.z, &self.force, kick);
        self.drift(drift);
    }
}
