//! The one argument of Newton and Kantorovich, on the series of finitely many functions.
//!
//! `T(u) = u - A G(u)` with any matrix `A` on the harmonics of a block and a few further unknowns,
//! and the identity beyond. `DG = P + B D`: `D` multiplies each function by its stiffness, `B`
//! takes harmonics of this to equations, and `P` is the identity beyond the block. The norm is the
//! largest over the functions of `sum_k |u_nk|/W_n`, and over the further unknowns `|g|/W`. Vectors
//! "by row" have an entry for each function, and a last one for the further unknowns.

use super::{Refused, of};
use crate::{
    interval::{Interval, norm},
    untrusted::choices,
};
use std::{ops::Range, rc::Rc};

/// A function, that of a site or a part of it, and a harmonic.
pub(crate) type Place = (usize, usize);
/// Entries by row, or coefficients by function.
pub(crate) type Matrix = Vec<Vec<Interval>>;

/// The unknown of a harmonic of strains over its coefficient: `sqrt 2` for the mean, so that the
/// functions of all unknowns, `1/sqrt 2`, `cos theta`, ... have the same mean square.
pub(crate) fn weight(k: usize) -> Interval {
    if k == 0 { of(2).sqrt() } else { Interval::ONE }
}

/// The entry of `D` in the row and the column of these harmonics of cosines; or for harmonics
/// `k + odd/2`, or of sines.
pub(crate) fn entry(d: &[Interval], [k, j]: [usize; 2], (odd, sine): (usize, bool)) -> Interval {
    let twice = |l: usize| if l == 0 { d[0] + d[0] } else { d[l] };
    let (near, far) = (twice(k.abs_diff(j)), twice(k + j + odd));
    (if sine { near - far } else { near + far }) / (of(2) * weight(k + odd) * weight(j + odd))
}

/// The product of two vectors, from the end, where series are small: so sums lose fewer digits.
pub(crate) fn dot(a: &[Interval], b: &[Interval]) -> Interval {
    a.iter().zip(b).rev().map(|(a, b)| *a * *b).sum()
}

pub(super) fn kronecker(equal: bool) -> Interval {
    if equal { Interval::ONE } else { Interval::ZERO }
}

/// The largest of numbers that are not negative.
pub(super) fn largest(all: impl IntoIterator<Item = Interval>) -> Interval {
    all.into_iter().fold(Interval::ZERO, Interval::max)
}

/// The sum of two matrices.
pub(super) fn sums(a: &Matrix, b: &Matrix) -> Matrix {
    a.iter().zip(b).map(|(a, b)| a.iter().zip(b).map(|(a, b)| *a + *b).collect()).collect()
}

/// Linear equations: harmonic `k` of function `n` has `sum e l_ik (D u)_mk`. There is one `l_k`,
/// but for perturbations.
pub trait Equations {
    /// Number of functions.
    fn functions(&self) -> usize;
    /// Whether this is an unknown.
    fn has(&self, place: Place) -> bool;
    /// Coefficient `k` of `D` times the function of the unknown `(m, j)`.
    fn entry(&self, m: usize, k: usize, j: usize) -> Interval;
    /// `m`, `i` and `e` in the equation of a place; the sums of moduli are the same for `k >= 1`.
    fn coupled(&self, place: Place) -> Vec<(usize, usize, f64)>;

    /// The unknowns of these functions with these harmonics.
    fn places(&self, functions: Range<usize>, harmonics: Range<usize>) -> Vec<Place> {
        let all = functions.flat_map(|n| harmonics.clone().map(move |k| (n, k)));
        all.filter(|place| place.0 < self.functions() && self.has(*place)).collect()
    }

    /// `sum e l_ik g_mk` at a place.
    fn applied(&self, l: &[Vec<Interval>], g: &[Vec<Interval>], (n, k): Place) -> Interval {
        self.coupled((n, k)).into_iter().map(|(m, i, e)| Interval::exact(e) * l[i][k] * g[m][k]).sum()
    }

    /// `t |e|` by row: `t^2` is the sum of the squares of factors beyond a harmonic, with a bound
    /// `tail` of the root for those that are not computed.
    fn far(&self, l: &[Vec<Interval>], last: usize, tail: Interval) -> Matrix {
        let t: Vec<Interval> = l.iter().map(|l| norm(l[last + 1..].iter().copied().chain([tail]))).collect();
        let of_row = |n: usize| {
            let mut row = vec![Interval::ZERO; self.functions()];
            // Harmonic 1, or 2 at a centre that has even ones only.
            let any = self.places(n..n + 1, 1..3).into_iter().take(1).flat_map(|place| self.coupled(place));
            any.for_each(|(m, i, e)| row[m] = row[m] + Interval::exact(e.abs()) * t[i]);
            row
        };
        (0..=self.functions()).map(of_row).collect()
    }
}

/// The unknowns and the matrices.
pub struct Block {
    pub(crate) it: Rc<dyn Equations>,
    last: usize,
    /// The unknowns but for the further ones.
    pub all: Vec<Place>,
    /// The columns of `P`: rows and entries.
    pub plain: Vec<Vec<(usize, Interval)>>,
    /// `A`.
    pub inverse: Matrix,
}

impl Block {
    /// The unknowns of the first functions up to a harmonic.
    pub fn new(it: Rc<dyn Equations>, functions: usize, last: usize) -> Self {
        Self { last, all: it.places(0..functions, 0..last + 1), it, plain: Vec::new(), inverse: Vec::new() }
    }

    /// The number of an unknown.
    pub fn index(&self, place: Place) -> Option<usize> {
        self.all.iter().position(|other| *other == place)
    }

    /// The unknowns of a function.
    pub fn at(&self, n: usize) -> impl Iterator<Item = (usize, &Place)> {
        self.all.iter().enumerate().filter(move |(_, it)| it.0 == n)
    }

    /// The rows of `B`: columns, `i` and `e`.
    pub(crate) fn rows(&self) -> Vec<Vec<(usize, usize, Interval)>> {
        let entry = |k: usize, (m, i, e): (usize, usize, f64)| Some((self.index((m, k))?, i, Interval::exact(e)));
        let row = |place: &Place| self.it.coupled(*place).into_iter().filter_map(|it| entry(place.1, it)).collect();
        self.all.iter().map(row).collect()
    }

    /// Sums over the rows of each function, and over the further rows.
    fn by_row(&self, of_row: &dyn Fn(usize) -> Interval) -> Vec<Interval> {
        let mut sums = vec![Interval::ZERO; self.it.functions() + 1];
        for i in 0..self.plain.len() {
            let n = self.all.get(i).map_or(self.it.functions(), |it| it.0);
            sums[n] = sums[n] + of_row(i);
        }
        sums
    }

    /// `|A g|` by row in the block, with these entries in the further rows.
    pub fn image(&self, g: &dyn Fn(Place) -> Interval, further: impl IntoIterator<Item = Interval>) -> Vec<Interval> {
        let g: Vec<Interval> = self.all.iter().map(|place| g(*place)).chain(further).collect();
        self.by_row(&|i| dot(&self.inverse[i], &g).abs())
    }

    /// The column of a further unknown in `1 - A DG`, by row in the block.
    pub fn column(&self, further: usize) -> Vec<Interval> {
        self.by_row(&|i| self.kept(i, self.all.len() + further).abs())
    }

    /// These rows with what `g` has beyond the block up to a harmonic, and bounds by row of the
    /// rest.
    pub fn with(
        &self,
        rows: Vec<Interval>,
        g: &dyn Fn(Place) -> Interval,
        (last, rest): (usize, &[Interval]),
    ) -> Vec<Interval> {
        let far = |n: usize| self.it.places(n..n + 1, self.last + 1..last + 1).into_iter().map(|place| g(place).abs());
        rows.into_iter().enumerate().map(|(n, row)| far(n).sum::<Interval>() + rest[n] + row).collect()
    }

    /// `A B` for these factors; and `R`, the norms of its rows for coefficients whose squares have
    /// the sum 1, by row and by function of the column.
    fn times(&self, l: &[Vec<Interval>]) -> [Matrix; 2] {
        let rows = self.rows();
        let of_row = |row: &Vec<Interval>| -> Vec<Interval> {
            let mut sums = vec![vec![Interval::ZERO; self.all.len()]; l.len()];
            for (entries, a) in rows.iter().zip(row) {
                entries.iter().for_each(|&(j, i, e)| sums[i][j] = sums[i][j] + *a * e);
            }
            let of_column = |(j, place): (usize, &Place)| sums.iter().zip(l).map(|(sum, l)| sum[j] * l[place.1]).sum();
            self.all.iter().enumerate().map(of_column).collect()
        };
        let product: Matrix = self.inverse.iter().map(of_row).collect();
        let of = |m: usize| self.by_row(&|i| norm(self.at(m).map(|(j, _)| product[i][j])));
        let columns: Matrix = (0..self.it.functions()).map(of).collect();
        let reach = (0..=columns.len()).map(|n| columns.iter().map(|column| column[n]).collect()).collect();
        [product, reach]
    }

    /// `R + t |e|` for these factors: what one unit of `sqrt 2 |g|_{L2}` at each function does in
    /// the rows.
    pub fn contacts(&self, l: &[Vec<Interval>], tail: Interval) -> Matrix {
        sums(&self.times(l)[1], &self.it.far(l, self.last, tail))
    }

    /// An entry of `1 - A P`.
    fn kept(&self, i: usize, own: usize) -> Interval {
        let image: Interval = self.plain[own].iter().map(|(row, entry)| self.inverse[i][*row] * *entry).sum();
        kronecker(own == i) - image
    }

    /// A column of `1 - A DG`, by row in the block, for this `A B`.
    fn column_of(&self, (m, j): Place, product: &Matrix) -> Vec<Interval> {
        let (own, it) = (self.index((m, j)), &self.it);
        let entries: Vec<_> = self.at(m).map(|(column, place)| (column, it.entry(m, place.1, j))).collect();
        self.by_row(&|i| {
            let stiff = entries.iter().map(|(column, d)| product[i][*column] * *d).sum();
            (own.map_or(Interval::ZERO, |own| self.kept(i, own)) - stiff).abs()
        })
    }

    /// The bounds of the derivative for these factors, with weights 1 and without further unknowns.
    /// Columns up to `last` are computed; of those beyond, the block sees `tails` of `D` only;
    /// beyond the block `sqrt 2 |D h|_{L2}` is at most `steepest`.
    pub fn derivative(
        &self,
        (l, tail): (&[Vec<Interval>], Interval),
        (last, tails, steepest): (usize, &[Interval], &[Interval]),
        go_on: &dyn Fn() -> Result<(), Refused>,
    ) -> Result<Derivative, Refused> {
        let ([product, reach], far) = (self.times(l), self.it.far(l, self.last, tail));
        let mut entries = vec![Vec::new(); far.len()];
        for m in 0..self.it.functions() {
            go_on()?;
            let mut most: Vec<Interval> = reach.iter().map(|row| row[m] * (tails[m] / of(2).sqrt())).collect();
            for place in self.it.places(m..m + 1, 0..last + 1) {
                most.iter_mut().zip(self.column_of(place, &product)).for_each(|(most, one)| *most = most.max(one));
            }
            let rows = entries.iter_mut().zip(most).zip(&far);
            rows.for_each(|((row, most), far)| row.push(most + far[m] * steepest[m]));
        }
        let (contacts, weights) = (sums(&reach, &far), vec![Interval::ONE; far.len()]);
        Ok(Derivative { entries, contacts, weights, rows: self.it.functions() })
    }
}

/// Bounds of the derivative of `T`, by row and by function of the column, and last those of the
/// further unknowns, if there are some.
pub struct Derivative {
    /// Those at the centre.
    pub entries: Matrix,
    /// `R + t |e|`.
    pub contacts: Matrix,
    /// `W_n`, and that of the further unknowns.
    pub weights: Vec<Interval>,
    /// Functions whose bounds are those of all.
    pub rows: usize,
}

impl Derivative {
    /// Adds the column of the further unknowns, and their weight.
    pub fn push(&mut self, column: Vec<Interval>, weight: Interval) {
        self.entries.iter_mut().zip(column).for_each(|(row, entry)| row.push(entry));
        self.weights.pop();
        self.weights.push(weight);
    }

    /// Bounds of `|DT h|` for `|h| <= 1`, by row, in a ball where `D` changes by at most `changes`,
    /// `sqrt 2` times the roots of mean squares.
    pub fn within(&self, changes: &[Interval]) -> Vec<Interval> {
        let changes: Vec<Interval> = changes.iter().zip(&self.weights).map(|(change, w)| *change * *w).collect();
        let of_row = |(entries, contacts): (&Vec<_>, &Vec<_>)| dot(entries, &self.weights) + dot(contacts, &changes);
        self.entries.iter().zip(&self.contacts).map(of_row).collect()
    }

    /// The norm of what has these bounds by row; NaN unless each has a weight, which is positive.
    pub fn norm(&self, by_row: &[Interval]) -> Interval {
        let all = by_row.len() == self.weights.len();
        let counted = by_row.iter().zip(&self.weights).enumerate();
        let counted = counted.filter(|(n, _)| *n < self.rows || n + 1 == by_row.len());
        let nan = Interval::exact(f64::NAN);
        largest(counted.map(|(_, (one, w))| if all && w.is_positive() { *one / *w } else { nan }))
    }
}

/// The radius `r'` of a ball that `T` maps into itself, that of uniqueness, and `q` on the former,
/// where `q(r)` bounds the derivative of `T` on balls: `Y0 + q r' <= r'` with `q` of a ball of
/// radius `r >= r'`, and `q < 1` on that of uniqueness. Both are at most `most`.
pub fn radii(y0: Interval, most: f64, q: impl Fn(f64) -> Interval) -> Option<(Interval, f64, Interval)> {
    let [ball, unique] = choices::radii(y0, most, &q)?;
    let contracts = |q: Interval| (Interval::ONE - q).is_positive();
    let own = q(ball);
    let radius = (y0 / (Interval::ONE - own)).hi();
    let proved = contracts(own) && radius <= ball && ball <= unique && unique <= most && contracts(q(unique));
    proved.then_some((Interval::exact(radius), unique, own))
}
