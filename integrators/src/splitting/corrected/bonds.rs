//! What contact-corrected splitting asks of a problem.

use super::{ends::Side, path::BondPath};
use crate::{clock::Twofold, system::SplitFlow};

/// A bond between two kicks, seen without its own force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BondView {
    /// The overlap near the second kick.
    pub path: BondPath,
    /// The acceleration of the overlap by a unit of its own force, reversed in sign: 2 between
    /// beads, 1 at a wall.
    pub mobility: f64,
    /// The acceleration of the overlap by all other forces of the kick, at the first kick and the
    /// second.
    pub pull: [f64; 2],
}

/// What a bond is given at an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction {
    /// Impulse: a contact force times time.
    pub impulse: f64,
    /// Displacement in the direction of the force.
    pub displacement: f64,
    /// When, relative to the kick.
    pub at: f64,
    /// Rate of the overlap there.
    pub rate: f64,
    /// Sine and cosine of `omega` times `at`.
    pub turn: [f64; 2],
}

/// Corrections of views, appended.
type Corrections<'a> = dyn Fn(&[BondView], &mut Vec<Option<Correction>>) + 'a;

/// How a correction depends on what its bond does: for flows that carry derivatives.
#[derive(Clone, Copy)]
pub struct Dependence<'a> {
    /// Duration of the view: a step, or 0 where a run begins, ends or is looked at.
    pub h: f64,
    /// Relative change of a view, in which the correction is smooth.
    pub change: f64,
    /// Whether the kicks at both ends of the view are also made worth the force of the processed
    /// path, `f(g + e)` in place of `f(g) + f'(g) e` with `e = (h^2/12) s`.
    pub kicks: bool,
    /// Appends the corrections of views near that of the bond; `None` where a view has none.
    pub of: &'a Corrections<'a>,
}

/// A split system whose kicks come from bonds `f_n = (g_n)_+^alpha` between sites that the drift
/// moves exactly.
pub trait BondFlow: SplitFlow<f64> {
    /// Whether the flow carries derivatives, and must be told what corrections depend on.
    const CARRIES: bool = false;
    /// The exponent `alpha`.
    fn exponent(&self) -> f64;
    /// Told the step before the first survey, and how near to zero turns are asked for.
    fn prepare(&mut self, _h: f64, _reach: f64) {}
    /// Number of bonds that can ever touch.
    fn bonds(&self) -> usize;
    /// Computes overlaps and forces of now; those of the survey before are kept as well.
    fn survey(&mut self);
    /// Appends the bonds whose side is not that of the last call, and whether they are closed now.
    /// A bond with overlap zero is open.
    fn changed(&mut self, out: &mut Vec<(usize, bool)>);
    /// Appends the bonds whose overlap at the survey before is larger or smaller than at those
    /// around it, and below so many times its second difference as [`prepare`](Self::prepare) was
    /// told; and whether they were closed then.
    fn turned(&self, out: &mut Vec<(usize, bool)>);
    /// The contact force of a bond, and the acceleration of its overlap by all forces of the kick.
    fn force(&self, bond: usize) -> (f64, f64);
    /// The overlap from the surveyed state on, under the forces of all other bonds as they are now.
    fn path(&self, bond: usize) -> BondPath;
    /// The bond between the surveys before and now, a step `h` apart, before the kick of now.
    ///
    /// Its path is that of the processed solution, `g + (h^2/12) s`, where `s` is linear between
    /// what all other forces of the kick do at both.
    fn view(&self, bond: usize, h: f64) -> BondView;
    /// Told how a correction depends on the view of its bond, before any correction that is given
    /// together with it moves anything; [`correct`](Self::correct) follows once for each, in the
    /// same order.
    fn depends(&mut self, _bond: usize, _dependence: Dependence<'_>) {}
    /// Gives bonds their corrections, and surveys again what these move.
    fn correct<'a>(&mut self, given: impl Iterator<Item = (usize, &'a Correction)>);
    /// Kicks over `kick` with the forces `F + c F' a` as surveyed; `a` are the accelerations by
    /// `F`.
    fn kick(&mut self, kick: f64, c: f64);
    /// [`kick`](Self::kick), drift and [`survey`](Self::survey), the same bits, for some kicks and
    /// drifts one after the other, at least one. If surveys are `watched`, none follows one at
    /// which [`changed`](Self::changed) or [`turned`](Self::turned) have something to tell. Returns
    /// how many were made.
    fn kicks_and_surveys(&mut self, pairs: &[(f64, Twofold<f64>)], c: f64, _watched: bool) -> usize {
        let (kick, drift) = pairs[0];
        self.kick(kick, c);
        self.drift(drift);
        self.survey();
        1
    }
    /// The flow of the processor: positions move by `share` times their accelerations by the forces
    /// of the kick, velocities by `-share` times the rates of these; the rates of the forces of
    /// bonds that are [`Near`](Side::Near) count as none.
    fn process(&mut self, share: f64, sides: &[Side]);
    /// Leads the solution `y` back in time by `by`, a part of a step, as exactly as the method or
    /// better.
    fn back(&self, y: &mut [f64], by: f64);
}
