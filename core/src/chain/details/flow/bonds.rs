//! The kicks of contact-corrected splitting on the motion of sites that differ.
//!
//! | symbol | meaning |
//! |---|---|
//! | `w` | `A^{1/alpha}` of a contact: its force is `(w g)_+^alpha`, so that the formulas for `A = 1` hold for the overlap `w g` |
//! | `a` | accelerations of beads by the forces of the kick: contacts and constant forces |
//!
//! With overlaps `w g` a unit force has the mobility `w (1/m + 1/m')`. The potential of a contact
//! is `(w g)_+^{alpha+1}/((alpha+1) w)`, so that impulses and displacements are those of `A = 1`.
//!
//! Frequencies of resonators may differ over a bond. The path of its overlap is therefore a cubic:
//! right to `O(h^4)`, as events need it, where `omega h` is small.

use super::{super::super::Chain, Class, SitewiseFlow, parts};
use hertzchain_integrators::{
    DoubleDouble, SplitFlow,
    splitting::corrected::{BondFlow, BondPath, BondView, Correction, Side},
};
use std::sync::Arc;

/// What does not change during a run.
struct Constants {
    /// `w`, from bond 0 on.
    unit: Vec<f64>,
    /// Constant forces on beads.
    steady: Vec<f64>,
}

/// A [`SitewiseFlow`] with the kicks of contact-corrected splitting, for chains that conserve
/// energy.
pub struct SitewiseBonds {
    flow: SitewiseFlow<f64>,
    constants: Arc<Constants>,
    reach: f64,
    /// Positions of beads at the last evaluation.
    u: Vec<f64>,
    /// `w g` of bonds at the last three evaluations, latest first.
    overlap: [Vec<f64>; 3],
    /// Forces of bonds at the last two evaluations.
    force: [Vec<f64>; 2],
    /// Derivatives of forces by `w g`.
    slope: Vec<f64>,
    /// A bit for each bond: whether it was closed at the last call of
    /// [`changed`](BondFlow::changed).
    told: Vec<u64>,
    /// Buffers of a kick: `a`, modified forces of bonds, forces on beads.
    a: Vec<f64>,
    modified: Vec<f64>,
    push: Vec<f64>,
}

impl SitewiseBonds {
    /// Adds the kicks to `flow`, which holds a state.
    ///
    /// # Panics
    /// A chain that [`Method::runs`](crate::run::method::Method::runs) refuses for the method.
    pub fn new(flow: SitewiseFlow<f64>) -> Self {
        let parts = parts(&flow.chain);
        assert!(parts.corrects(), "a chain that conserves energy, whose beads only contacts and resonators hold");
        let alpha = flow.loops.one_law().alpha();
        let mut steady: Vec<f64> = vec![0.0; flow.chain.sites()];
        parts.weights().for_each(|(i, weight)| steady[i] += weight);
        parts.acting().iter().for_each(|drive| steady[drive.site] += drive.at::<f64>(0.0)[0]);
        let unit = parts.bonds.iter().map(|bond| bond.constant.powf(alpha.recip())).collect();
        Self::with(flow, Arc::new(Constants { unit, steady }))
    }

    fn with(flow: SitewiseFlow<f64>, constants: Arc<Constants>) -> Self {
        let n = flow.chain.sites();
        let (sites, bonds) = (|| vec![0.0; n], || vec![0.0; n + 1]);
        Self {
            reach: 0.0,
            u: sites(),
            overlap: [bonds(), bonds(), bonds()],
            force: [bonds(), bonds()],
            slope: bonds(),
            told: vec![0; n / 64 + 1],
            a: sites(),
            modified: bonds(),
            push: sites(),
            constants,
            flow,
        }
    }

    fn chain(&self) -> &Chain<f64> {
        &self.flow.chain
    }

    fn bond(&self, index: usize) -> usize {
        self.chain().touching().start + index
    }

    /// The difference of a quantity of beads over a bond, times `w`.
    fn across(&self, bond: usize, quantity: impl Fn(usize) -> f64) -> f64 {
        self.constants.unit[bond] * self.chain().across(bond, quantity)
    }

    /// The acceleration of a bead by the forces of the kick at the evaluation `before` the last.
    fn acceleration(&self, i: usize, before: usize) -> f64 {
        let force = &self.force[before];
        let contacts = self.chain().topology().push(i, |b| [force[b]])[0];
        (contacts + self.constants.steady[i]) / self.flow.loops.mass[i]
    }

    /// Minus the acceleration of `w g` by a unit force.
    fn mobility(&self, bond: usize) -> f64 {
        let pushed = self.chain().topology().pushed(bond);
        self.constants.unit[bond] * pushed.iter().map(|&(i, _)| 1.0 / self.flow.loops.mass[i]).sum::<f64>()
    }

    /// The acceleration of `w g` by all other forces.
    fn pull(&self, bond: usize, before: usize) -> f64 {
        self.across(bond, |i| self.acceleration(i, before)) + self.mobility(bond) * self.force[before][bond]
    }

    /// Accelerations and their rates by springs that are part of the drift.
    fn drifting(&self, i: usize) -> [f64; 2] {
        match self.flow.class(i) {
            Class::Modes(modes) => {
                let ([_, p, _, s], omega) = (self.flow.site(i), modes.omega.value());
                [-omega * omega * p, -omega * omega * (s * omega)]
            }
            _ => [0.0; 2],
        }
    }

    /// The path of a bond under two pulls, one a step `h` ago and one now, see
    /// [`BondFlow::view`].
    fn path_of(&self, bond: usize, [before, now]: [f64; 2], h: f64) -> BondPath {
        let change = if h > 0.0 { (now - before) / h } else { 0.0 };
        let share = h * h / 12.0;
        BondPath {
            overlap: self.overlap[0][bond] + share * now,
            rate: self.across(bond, |i| self.flow.bead(i)[1]) + (0.25 * h * (before + now) + 2.0 * share * change),
            acceleration: [now + self.across(bond, |i| self.drifting(i)[0]), 0.0],
            jerk: [change + self.across(bond, |i| self.drifting(i)[1]), 0.0],
            omega: 0.0,
        }
    }

    /// Changes a bead by an impulse over its mass, and by a displacement, at the time `at`.
    fn give(&mut self, i: usize, [impulse, displacement]: [f64; 2], at: f64) {
        let SitewiseFlow { z, classes, class, .. } = &mut self.flow;
        let [r, p, r_dot, s] = z.each_mut().map(|z| &mut z[i]);
        let (m, mu, omega) = match &classes[class[i] as usize] {
            Class::Modes(modes) => (modes.m, modes.mu, modes.omega.value()),
            _ => (1.0, 0.0, 0.0),
        };
        *r += m * (displacement - impulse * at);
        *r_dot += m * impulse;
        if mu > 0.0 {
            let (sin, cos) = (omega * at).sin_cos();
            *p += mu * (displacement * cos - impulse / omega * sin);
            *s += mu * (displacement * sin + impulse / omega * cos);
        }
    }

    /// Computes overlap, force and its derivative of a bond anew.
    fn refresh(&mut self, bond: usize) {
        let contact = &parts(&self.flow.chain).bonds[bond];
        let g = self.constants.unit[bond] * (contact.rest + self.chain().across(bond, |i| self.u[i]));
        self.overlap[0][bond] = g;
        (self.force[0][bond], self.slope[bond]) = contact.power.force_with_slope(g);
    }
}

impl SplitFlow<f64> for SitewiseBonds {
    fn dim(&self) -> usize {
        self.flow.dim()
    }

    fn load(&mut self, y: &[f64]) {
        self.flow.load(y);
    }

    fn store(&self, y: &mut [f64]) {
        self.flow.store(y);
    }

    fn duplicate(&self) -> Self {
        let mut copy = Self::with(self.flow.duplicate(), Arc::clone(&self.constants));
        copy.copy_from(self);
        copy
    }

    fn copy_from(&mut self, other: &Self) {
        self.flow.copy_from(&other.flow);
        self.reach = other.reach;
        let pairs = [(&mut self.u, &other.u), (&mut self.slope, &other.slope)].into_iter();
        let pairs = pairs.chain(self.overlap.iter_mut().zip(&other.overlap));
        pairs.chain(self.force.iter_mut().zip(&other.force)).for_each(|(to, from)| to.copy_from_slice(from));
        self.told.copy_from_slice(&other.told);
    }

    fn drift(&mut self, dt: DoubleDouble<f64>) {
        self.flow.drift(dt);
    }

    fn kick_drift(&mut self, kick: f64, drift: DoubleDouble<f64>) {
        self.evaluate();
        self.kick(kick, 0.0);
        self.drift(drift);
    }
}

impl BondFlow for SitewiseBonds {
    fn exponent(&self) -> f64 {
        self.flow.loops.one_law().alpha()
    }

    fn prepare(&mut self, _h: f64, reach: f64) {
        self.reach = reach;
    }

    fn bonds(&self) -> usize {
        self.chain().touching().len()
    }

    fn evaluate(&mut self) {
        self.overlap.rotate_right(1);
        self.force.swap(0, 1);
        let Self { flow, constants, u, overlap: [overlap, ..], force: [force, _], slope, .. } = self;
        flow.loops.positions(&flow.z, u);
        flow.loops.bonds((&flow.chain, parts(&flow.chain)), &constants.unit, u, [overlap, force, slope]);
    }

    fn changed(&mut self, out: &mut Vec<(usize, bool)>) {
        let touching = self.chain().touching();
        let Self { flow, overlap, told, .. } = self;
        // Bonds before the first that can touch have the overlap zero.
        flow.loops.sides(&overlap[0][..touching.end], told, |b, closed| out.push((b - touching.start, closed)));
    }

    fn turned(&self, out: &mut Vec<(usize, bool)>) {
        let touching = self.chain().touching();
        let overlaps = self.overlap.each_ref().map(|overlap| &overlap[..touching.end]);
        self.flow.loops.turns(self.reach, overlaps, |b| out.push((b - touching.start, overlaps[1][b] > 0.0)));
    }

    fn force(&self, bond: usize) -> (f64, f64) {
        let b = self.bond(bond);
        (self.force[0][b], self.across(b, |i| self.acceleration(i, 0)))
    }

    fn unit(&self, bond: usize) -> f64 {
        self.constants.unit[self.bond(bond)]
    }

    fn path(&self, bond: usize) -> BondPath {
        let b = self.bond(bond);
        self.path_of(b, [self.pull(b, 0); 2], 0.0)
    }

    fn view(&self, bond: usize, h: f64) -> BondView {
        let b = self.bond(bond);
        let pull = [1, 0].map(|before| self.pull(b, before));
        BondView { path: self.path_of(b, pull, h), mobility: self.mobility(b), pull }
    }

    fn correct<'a>(&mut self, given: impl Iterator<Item = (usize, &'a Correction)>) {
        for (bond, &Correction { impulse, displacement, at, .. }) in given {
            let pushed = self.chain().topology().pushed(self.bond(bond));
            for &(i, weight) in pushed.iter() {
                let share = weight / self.flow.loops.mass[i];
                self.give(i, [share * impulse, share * displacement], at);
                self.u[i] = self.flow.bead(i)[0];
            }
            for &(i, _) in pushed.iter() {
                self.chain().topology().bonds(i).into_iter().flatten().for_each(|b| self.refresh(b));
            }
        }
    }

    fn kick(&mut self, kick: f64, c: f64) {
        let Self { flow, constants, force: [force, _], slope, a, modified, push, .. } = self;
        let Constants { unit, steady } = &**constants;
        flow.loops.modified(&flow.chain, (unit, c), [force, slope, steady], [a, modified, push]);
        push.iter_mut().zip(steady).for_each(|(push, steady)| *push += steady);
        flow.loops.kick(&mut flow.z, push, kick);
    }

    fn kicks_and_evaluations(&mut self, pairs: &[(f64, DoubleDouble<f64>)], c: f64, _watched: bool) -> usize {
        let (kick, drift) = pairs[0];
        self.kick(kick, c);
        self.drift(drift);
        self.evaluate();
        1
    }

    fn jet(&mut self, sides: &[Side]) -> Vec<[f64; 2]> {
        self.evaluate();
        let first = self.chain().touching().start;
        let mut rates = vec![0.0; self.slope.len()];
        for (index, side) in sides.iter().enumerate() {
            let b = first + index;
            if *side != Side::Near {
                rates[b] = self.slope[b] * self.across(b, |i| self.flow.bead(i)[1]);
            }
        }
        let (topology, mass) = (self.chain().topology(), &self.flow.loops.mass);
        let site = |i: usize| [self.acceleration(i, 0), topology.push(i, |b| [rates[b]])[0] / mass[i]];
        (0..mass.len()).map(site).collect()
    }

    fn shift(&mut self, share: f64, jet: &[[f64; 2]]) {
        for (i, &[a, rate]) in jet.iter().enumerate() {
            self.give(i, [-share * rate, share * a], 0.0);
        }
    }

    fn back(&self, y: &mut [f64], by: f64) {
        self.chain().back(y, by);
    }
}
