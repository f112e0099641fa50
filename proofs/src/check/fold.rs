//! Chapter: a piece of a branch of waves that has `a_1` as its parameter, and the frequency as one
//! more unknown `sigma`, and where the frequency of such pieces turns back ("Folds" in
//! `README.md`).

use super::{
    Moments, System,
    branch::{Pieces, connected},
    existence::Terms,
    newton::{Derivative, Lines, Place, dot, sums},
    of,
};
use crate::{exact::Exact, interval::Interval};

/// Largest radius of a ball over `Y0` of the wave.
const WIDEST: usize = 5;

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
        derivative.entries.iter_mut().zip(terms.column_of_last()).for_each(|(row, entry)| row.push(entry));
        derivative.weights.splice(1.., [Interval::ONE / eta]);
        Self { turn, eta, contacts: terms.turned().into_iter().map(|row| row[0] / eta).collect() }
    }

    /// The bounds of the rows with the change of this column in the ball of radius `r`, that of the
    /// force: `(R' + t') alpha (M + r)^{alpha-1} r`.
    pub(super) fn changed(&self, rows: Vec<Interval>, known: &Moments, alpha: Exact, r: Interval) -> Vec<Interval> {
        let force = known.force_change(alpha, r);
        rows.into_iter().zip(&self.contacts).map(|(row, contact)| row + *contact * force).collect()
    }
}

impl System {
    /// Adds the equation of `a_1`, which has the number of `sigma`, and the column `-l'_k n_k` of
    /// `sigma` to the plain part.
    pub(super) fn border(&self, all: &[Place], plain: &mut Lines) {
        if self.first.is_some() {
            plain[1].push((all.len(), Interval::ONE));
            plain.push(all.iter().enumerate().skip(1).map(|(i, &(n, k))| (i, -self.turn(n, k))).collect());
        }
    }
}

impl Terms<'_> {
    /// `R' + t' |e|` by row: what forces do by way of the changes of the factors.
    pub fn turned(&self) -> Vec<Vec<Interval>> {
        let [_, reach] = self.block.times(&self.e, &|k| self.system.slopes[k]);
        sums(&reach, &self.beyond(&|k| self.system.slopes[k], self.system.tails()[1]))
    }

    /// The norm of `l' e n` of a site beyond the block.
    pub fn turned_beyond(&self, n: usize) -> Interval {
        let own: Interval = self.harmonics(n, self.certificate.block).map(|k| self.system.turn(n, k).abs()).sum();
        own + dot(&self.system.moduli(n, self.system.tails()[1]), &self.tails)
    }

    /// The column of `sigma` of `1 - A DG`, by row.
    pub fn column_of_last(&self) -> Vec<Interval> {
        let column = self.block.by_site(&|i| self.block.kept(i, self.block.all.len()).abs());
        column.into_iter().enumerate().map(|(n, column)| column + self.turned_beyond(n)).collect()
    }
}

/// Bounds of the least and of the largest frequency along pieces, of each that is not
/// found at an end of the curve: there the frequency turns back. None of pieces that are not
/// connected, nor of such at several mean strains, or along which the first harmonic goes back.
pub fn turns(pieces: Pieces) -> Vec<[f64; 2]> {
    let ends: Vec<[[Exact; 2]; 2]> = pieces.iter().map(|(piece, _)| piece.ends()).collect();
    let rises = |[start, end]: &[[Exact; 2]; 2]| (end[0].enclosed() - start[0].enclosed()).is_positive();
    let one_way = ends.iter().all(rises) || ends.iter().all(|[start, end]| rises(&[*end, *start]));
    let one_mean = ends.iter().flatten().all(|end| end[1] == ends[0][0][1]);
    let unknown = pieces.iter().all(|(piece, _)| piece.first.is_some());
    if !(one_way && one_mean && unknown && connected(pieces).0 == pieces.len()) {
        return Vec::new();
    }
    let all: Vec<[f64; 2]> = pieces.iter().filter_map(|(_, proof)| Some(proof.as_ref().ok()?.frequency)).collect();
    let negative = |[lo, hi]: [f64; 2]| [-hi, -lo];
    let least = |all: Vec<[f64; 2]>| {
        let [lo, hi] = [0, 1].map(|end| all.iter().map(|one| one[end]).fold(f64::INFINITY, f64::min));
        (hi < all.first()?[0] && hi < all.last()?[0]).then_some([lo, hi])
    };
    let largest = least(all.iter().copied().map(negative).collect()).map(negative);
    least(all).into_iter().chain(largest).collect()
}
