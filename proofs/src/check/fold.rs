//! Chapter: pieces of branches of waves that have `a_1` as their parameter, and the frequency as
//! one more unknown `sigma`, and where this turns back ("Folds" in `README.md`).

use super::{
    System,
    branch::{Pieces, connected},
    existence::Terms,
    of,
};
use crate::{certificate::Certificate, exact::Exact, interval::Interval};

/// Largest radius of a ball over `Y0` of the wave.
const WIDEST: usize = 5;

/// The rule of the line `first`.
pub(crate) fn rule(it: &Certificate) -> bool {
    it.first.is_none() || it.is_wave() && it.to.is_some() && !it.is_to_zero()
}

/// The norm of an unknown frequency.
pub(super) struct Fold {
    /// `W` with `|omega - omega_m|/W` in the norm, exact; none if the frequency is known.
    pub turn: Option<Interval>,
    /// `eta = omega'/W`, or 1.
    pub eta: Interval,
    /// The largest radius of a ball.
    pub widest: f64,
}

impl Fold {
    /// That of a certificate, by `Y0` of its wave.
    pub(super) fn new(terms: &Terms, y0: Interval) -> Self {
        let half = terms.system.middle[1];
        let turn = terms.system.first.map(|_| Interval::exact((half / (of(WIDEST) * y0)).mid()));
        let eta = turn.map_or(Interval::ONE, |turn| half / turn);
        Self { turn, eta, widest: turn.map_or(f64::INFINITY, |_| eta.lo()) }
    }

    /// The frequencies of the solution, for a bound of `|sigma|`; of a piece whose frequency is
    /// known all of them.
    pub(super) fn frequency(&self, system: &System, sigma: Interval) -> Interval {
        self.turn.map_or(system.omega(), |_| system.middle[0] + (system.middle[1] * sigma).ball())
    }
}

impl Terms<'_> {
    /// The column of an unknown frequency of `1 - A DG`, by row, along all of the piece.
    pub fn column_of_last(&self) -> Vec<Interval> {
        let beyond = |n: usize| self.system.first.map_or(Interval::ZERO, |_| self.turned_beyond(n));
        self.block.further_columns().into_iter().enumerate().map(|(n, column)| column + beyond(n)).collect()
    }

    /// A bound of the change of a row of this column in the ball of radius `r`, that of the force:
    /// `(R' + t') alpha (M + r)^{alpha-1} r`.
    pub fn change_of_last(&self, n: usize, r: Interval) -> Interval {
        let force = || self.system.known[0].force_change(self.certificate.model.alpha, r);
        self.system.first.map_or(Interval::ZERO, |_| self.beyond[1][n][0] * force())
    }
}

/// Bounds of the least and of the largest frequency along pieces, of each that is not at an end of
/// the curve: there the frequency turns back. None of pieces that are not connected, are at several
/// mean strains, or along which the first harmonic goes back.
pub fn turns(pieces: Pieces) -> Vec<[f64; 2]> {
    let ends: Vec<[[Exact; 2]; 2]> = pieces.iter().map(|(piece, _)| piece.ends()).collect();
    let steps: Vec<Interval> = ends.iter().map(|[start, end]| end[0].enclosed() - start[0].enclosed()).collect();
    let one_way = steps.iter().all(|it| it.is_positive()) || steps.iter().all(|it| (-*it).is_positive());
    let one_mean = ends.iter().flatten().all(|end| end[1] == ends[0][0][1]);
    let unknown = pieces.iter().all(|(piece, _)| piece.first.is_some());
    if !(one_way && one_mean && unknown && connected(pieces).0 == pieces.len()) {
        return Vec::new();
    }
    let all: Vec<[f64; 2]> = pieces.iter().filter_map(|(_, proof)| Some(proof.as_ref().ok()?.frequency)).collect();
    let turn = |of: fn(Interval) -> Interval| {
        let all: Vec<Interval> = all.iter().map(|[lo, hi]| of(Interval::new(*lo, *hi))).collect();
        let (least, ends) = (all.iter().copied().reduce(Interval::min)?, all[0].min(all[all.len() - 1]));
        (ends - least).is_positive().then(|| [of(least).lo(), of(least).hi()])
    };
    [turn(|it| it), turn(|it| -it)].into_iter().flatten().collect()
}
