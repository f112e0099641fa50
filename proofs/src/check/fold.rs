//! Chapter: pieces of branches of waves that have `a_1` as their parameter, and the frequency as
//! one more unknown `sigma`, and where this turns back ("Folds" in `README.md`).

use super::{
    branch::{Pieces, connected},
    existence::Terms,
    newton::{Derivative, Equations, Matrix, dot},
    of,
};
use crate::{certificate::Certificate, exact::Exact, interval::Interval};
use std::slice::from_ref;

/// Largest radius of a ball over `Y0` of the wave.
const WIDEST: usize = 5;

/// The rule of the line `first`.
pub(crate) fn rule(it: &Certificate) -> bool {
    it.first.is_none() || it.is_wave() && it.to.is_some() && !it.is_to_zero()
}

/// What an unknown frequency adds to the proof of a wave.
pub(super) struct Fold {
    /// `W` with `|omega - omega_m|/W` in the norm, exact.
    pub turn: Interval,
    /// `eta = omega'/W`, the largest radius of a ball.
    pub eta: Interval,
    /// `R' + t'`, by row, over `eta`.
    contacts: Vec<Interval>,
}

impl Fold {
    /// That of a certificate, by `Y0` of its wave. Adds the column of `sigma` to the derivative,
    /// along all of the piece, and the weight of its row.
    pub(super) fn new(terms: &Terms, y0: Interval, derivative: &mut Derivative) -> Self {
        let half = terms.system.middle[1];
        let turn = Interval::exact((half / (of(WIDEST) * y0)).mid());
        let eta = half / turn;
        let contacts = terms.contacts();
        derivative.push(terms.turned(terms.block.column(0), (&contacts, &[])), Interval::ONE / eta);
        Self { turn, eta, contacts: contacts.into_iter().map(|row| row[0] / eta).collect() }
    }

    /// The bounds of the rows with the change of this column in a ball where the force changes by
    /// `force`: `(R' + t') alpha (M + r)^{alpha-1} r`.
    pub(super) fn changed(&self, rows: Vec<Interval>, force: Interval) -> Vec<Interval> {
        rows.into_iter().zip(&self.contacts).map(|(row, contact)| row + *contact * force).collect()
    }
}

impl Terms<'_> {
    /// `R' + t' |e|` by row: what forces do by way of the changes of the factors.
    pub fn contacts(&self) -> Matrix {
        self.block.contacts(from_ref(&self.system.slopes), self.system.tails()[1])
    }

    /// These rows with `l' e n` beyond the block, and what forces do by these contacts.
    pub fn turned(&self, rows: Vec<Interval>, (contacts, forces): (&Matrix, &[Interval])) -> Vec<Interval> {
        let (system, last) = (&self.system, self.certificate.enclosed);
        let far = system.far(from_ref(&system.slopes), last, system.tails()[1]);
        let of_row = |(far, contacts): (&Vec<_>, &Vec<_>)| dot(far, &self.tails) + dot(contacts, forces);
        let rest: Vec<_> = far.iter().zip(contacts).map(of_row).collect();
        self.block.with(rows, &|place| system.turn(place), (last, &rest))
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
