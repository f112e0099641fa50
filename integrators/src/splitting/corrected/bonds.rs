//! The interface between contact-corrected splitting and a problem.

use super::path::BondPath;
use crate::{clock::DoubleDouble, system::SplitFlow};

/// The motion of a bond between two kicks, without the bond's own force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BondView {
    /// The overlap as a function of the time since the second kick.
    pub path: BondPath,
    /// Minus the acceleration of the overlap by a unit of the bond's own force: 2 between beads, 1
    /// at a wall.
    pub mobility: f64,
    /// The acceleration of the overlap by all other forces of the kick, at the first kick and the
    /// second.
    pub pull: [f64; 2],
}

/// The correction of a bond at an event or a turning point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction {
    /// Impulse: a contact force times time.
    pub impulse: f64,
    /// Displacement in the direction of the force.
    pub displacement: f64,
    /// Time at which it acts, relative to the present kick.
    pub at: f64,
    /// Rate of the overlap at that time.
    pub rate: f64,
    /// Sine and cosine of `omega` times `at`.
    pub turn: [f64; 2],
}

/// How the end terms of a sum of kicks treat one bond.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Open: it has no end terms.
    Open,
    /// Closed, with an event so near that only the closed form corrects its impulse, not the
    /// processor.
    Near,
    /// Closed.
    Closed,
}

/// A split system whose kicks come from bonds `f_n = (g_n)_+^alpha` between sites that the drift
/// moves exactly.
pub trait BondFlow: SplitFlow<f64> {
    /// The exponent `alpha`.
    fn exponent(&self) -> f64;
    /// Called before the first evaluation, with the step and the reach of [`turned`](Self::turned).
    fn prepare(&mut self, h: f64, reach: f64);
    /// Number of bonds that can ever touch.
    fn bonds(&self) -> usize;
    /// Computes overlaps and forces at the present state, and keeps those of the evaluation before.
    fn evaluate(&mut self);
    /// Appends the bonds whose side differs from that at the last call, and whether they are closed
    /// now. A bond with overlap zero is open.
    fn changed(&mut self, out: &mut Vec<(usize, bool)>);
    /// Appends the bonds whose overlap has turned near zero, and whether they were closed at the
    /// evaluation before. At that evaluation the overlap was larger or smaller than at both
    /// evaluations around it, and in absolute value below `reach` times its second difference, see
    /// [`prepare`](Self::prepare).
    fn turned(&self, out: &mut Vec<(usize, bool)>);
    /// The contact force of a bond, and the acceleration of its overlap by all forces of the kick.
    fn force(&self, bond: usize) -> (f64, f64);
    /// Overlaps here over those of the problem, of which the log tells.
    fn unit(&self, _bond: usize) -> f64 {
        1.0
    }
    /// The overlap from the evaluated state on, under the present forces of all other bonds.
    fn path(&self, bond: usize) -> BondPath;
    /// The motion of the bond between the last two evaluations, a step `h` apart, before the kick
    /// at the second.
    ///
    /// Its path is that of the processed solution, `g + (h^2/12) s`, where `s` is linear in time
    /// between the accelerations by all other forces at the two kicks.
    fn view(&self, bond: usize, h: f64) -> BondView;
    /// Applies corrections to bonds, and computes overlaps and forces anew where these move sites.
    fn correct<'a>(&mut self, given: impl Iterator<Item = (usize, &'a Correction)>);
    /// A kick of duration `kick` with the evaluated forces `F + c F' a`; `a` are the accelerations
    /// of the overlaps by `F`.
    fn kick(&mut self, kick: f64, c: f64);
    /// [`kick`](Self::kick), drift and [`evaluate`](Self::evaluate) for the pairs in turn, with the
    /// same bits; at least one pair is made. If evaluations are `watched`, the row ends with the
    /// first one at which [`changed`](Self::changed) or [`turned`](Self::turned) would report a
    /// bond. Returns the number of pairs made.
    fn kicks_and_evaluations(&mut self, pairs: &[(f64, DoubleDouble<f64>)], c: f64, watched: bool) -> usize;
    /// Of each site, after an evaluation: accelerations of its bead by the forces of the kick and
    /// the rates of these, then both of its resonator. Forces of bonds that are
    /// [`Near`](Side::Near) an event count without their rates.
    fn jet(&mut self, sides: &[Side]) -> Vec<[f64; 2]>;
    /// Moves positions by `share` times these accelerations, velocities by `-share` times their
    /// rates.
    fn shift(&mut self, share: f64, jet: &[[f64; 2]]);
    /// The flow of the processor: [`shift`](Self::shift) by the [`jet`](Self::jet), as one explicit
    /// midpoint step.
    fn process(&mut self, share: f64, sides: &[Side]) {
        let start = self.jet(sides);
        self.shift(0.5 * share, &start);
        let middle = self.jet(sides);
        self.shift(share, &middle);
        self.shift(-0.5 * share, &start);
    }
    /// Moves the solution `y` back in time by `by`, a part of a step, at least as accurately as the
    /// method.
    fn back(&self, y: &mut [f64], by: f64);
}
