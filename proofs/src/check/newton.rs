//! The one argument of Newton and Kantorovich, on the series of finitely many sites.
//!
//! `T(u) = u - A G(u)` with any matrix `A` on the harmonics of a block and a few further unknowns,
//! and the identity beyond. `DG = P + B D`: `D` multiplies each site by its stiffness, `B` takes
//! harmonics of this to equations, and `P` is the identity beyond the block. The norm is the
//! largest over the sites of `sum_k |u_nk|/W_n`, and over the further unknowns `|g|/W`. Vectors
//! "by row" have an entry for each site, and a last one for the further unknowns.

use super::{Refused, of};
use crate::{
    interval::{Interval, norm},
    untrusted::choices,
};

/// Site and harmonic.
pub type Place = (usize, usize);
/// The rows of `B`: columns and entries; or the columns of `P`: rows and entries.
pub(crate) type Lines = Vec<Vec<(usize, Interval)>>;

/// The unknown of a harmonic of strains over its coefficient: `sqrt 2` for the mean, so that the
/// functions of the unknowns, `1/sqrt 2`, `cos theta`, ... have the same mean square.
pub fn weight(k: usize) -> Interval {
    if k == 0 { of(2).sqrt() } else { Interval::ONE }
}

/// The entry of `D` in the row and the column of these harmonics of strains.
pub fn cosines(d: &[Interval], k: usize, j: usize) -> Interval {
    match (k, j) {
        (0, 0) => d[0],
        (0, l) | (l, 0) => d[l] / weight(0),
        _ => (d[k.abs_diff(j)] * of(if k == j { 2 } else { 1 }) + d[k + j]) / of(2),
    }
}

/// The product of two vectors, from the end, where series are small: so sums lose fewer digits.
pub fn dot(a: &[Interval], b: &[Interval]) -> Interval {
    a.iter().zip(b).rev().map(|(a, b)| *a * *b).sum()
}

pub(super) fn kronecker(equal: bool) -> Interval {
    if equal { Interval::ONE } else { Interval::ZERO }
}

/// The largest of numbers that are not negative.
pub(super) fn largest(all: impl IntoIterator<Item = Interval>) -> Interval {
    all.into_iter().fold(Interval::ZERO, Interval::max)
}

/// The unknowns and the matrices.
pub struct Block {
    /// The unknowns but for the further ones.
    pub all: Vec<Place>,
    /// Number of sites.
    pub sites: usize,
    /// The entry of `D` of a site, by row and column.
    pub entry: Box<dyn Fn(usize, usize, usize) -> Interval>,
    /// The columns of `P`.
    pub plain: Lines,
    /// `A`.
    pub inverse: Vec<Vec<Interval>>,
    /// `A B`.
    pub product: Vec<Vec<Interval>>,
    /// `R`, by row and by site of the column.
    pub reach: Vec<Vec<Interval>>,
}

impl Block {
    /// The number of an unknown.
    pub fn index(&self, place: Place) -> Option<usize> {
        self.all.iter().position(|other| *other == place)
    }

    /// The unknowns of a site.
    pub fn at(&self, n: usize) -> impl Iterator<Item = (usize, &Place)> {
        self.all.iter().enumerate().filter(move |(_, it)| it.0 == n)
    }

    /// Sums over the rows of each site, and over the further rows.
    pub fn by_site(&self, of_row: &dyn Fn(usize) -> Interval) -> Vec<Interval> {
        let mut sums = vec![Interval::ZERO; self.sites + 1];
        for i in 0..self.plain.len() {
            let n = self.all.get(i).map_or(self.sites, |it| it.0);
            sums[n] = sums[n] + of_row(i);
        }
        sums
    }

    /// `|A g|` by row, of a vector with these entries in the block and these norms `beyond` it.
    pub fn image(&self, g: &[Interval], beyond: impl Fn(usize) -> Interval) -> Vec<Interval> {
        let head = self.by_site(&|i| dot(&self.inverse[i], g).abs());
        head.into_iter().enumerate().map(|(n, head)| head + beyond(n)).collect()
    }

    /// Rows of a matrix from what it has by place.
    pub fn rows(&self, of: impl Fn(Place) -> Vec<(Place, Interval)>) -> Lines {
        let entry = |(place, factor): (Place, Interval)| Some((self.index(place)?, factor));
        self.all.iter().map(|place| of(*place).into_iter().filter_map(entry).collect()).collect()
    }

    /// `A B` for a `B` of these rows times a factor by harmonic; and the norms of its rows for
    /// coefficients whose squares have the sum 1, by row and by site of the column.
    pub fn times(&self, b: &Lines, l: &dyn Fn(usize) -> Interval) -> [Vec<Vec<Interval>>; 2] {
        let l: Vec<Interval> = self.all.iter().map(|place| l(place.1)).collect();
        let of_row = |row: &Vec<Interval>| -> Vec<Interval> {
            let mut product = vec![Interval::ZERO; b.len()];
            for (entries, a) in b.iter().zip(row) {
                entries.iter().for_each(|(j, b)| product[*j] = product[*j] + *a * *b);
            }
            product.into_iter().zip(&l).map(|(product, l)| product * *l).collect()
        };
        let product: Vec<Vec<Interval>> = self.inverse.iter().map(of_row).collect();
        let of_site = |m: usize| self.by_site(&|i| norm(self.at(m).map(|(j, _)| product[i][j])));
        let sites: Vec<Vec<Interval>> = (0..self.sites).map(of_site).collect();
        let reach = (0..=self.sites).map(|n| sites.iter().map(|site| site[n]).collect()).collect();
        [product, reach]
    }

    /// The largest columns of `1 - A DG` of a site, by row: of these harmonics, and of those
    /// beyond, of which the rows see a tail of `D` only.
    pub fn columns(&self, m: usize, harmonics: Vec<usize>, tail: Interval) -> Vec<Interval> {
        let mut most: Vec<Interval> = self.reach.iter().map(|row| row[m] * (tail / of(2).sqrt())).collect();
        for j in harmonics {
            let own = self.index((m, j));
            let entries: Vec<_> = self.at(m).map(|(i, it)| (i, (self.entry)(m, it.1, j))).collect();
            let sums = self.by_site(&|i| {
                let stiff = entries.iter().map(|(column, d)| self.product[i][*column] * *d).sum();
                (own.map_or(Interval::ZERO, |own| self.kept(i, own)) - stiff).abs()
            });
            most.iter_mut().zip(sums).for_each(|(most, sum)| *most = most.max(sum));
        }
        most
    }

    /// An entry of `1 - A P`.
    pub(super) fn kept(&self, i: usize, own: usize) -> Interval {
        let image: Interval = self.plain[own].iter().map(|(row, entry)| self.inverse[i][*row] * *entry).sum();
        kronecker(own == i) - image
    }
}

/// Bounds of the derivative of `T`, by row and by site of the column, and last those of the further
/// unknowns, if there are some.
pub struct Derivative {
    /// Those at the centre.
    pub entries: Vec<Vec<Interval>>,
    /// `R + t |e|`: what forces of which the squares of the coefficients have the sum 1 do.
    pub contacts: Vec<Vec<Interval>>,
    /// `W_n`, and that of the further unknowns.
    pub weights: Vec<Interval>,
    /// Sites whose bounds are those of all sites.
    pub rows: usize,
}

impl Derivative {
    /// From the columns of each site in the rows of the block, and `far`, `t |e|`, beyond: there
    /// the forces of `D h` are at most `steepest`.
    pub fn new(
        block: &Block,
        far: &[Vec<Interval>],
        steepest: &[Interval],
        columns: impl Fn(usize) -> Result<Vec<Interval>, Refused>,
    ) -> Result<Self, Refused> {
        let columns = (0..block.sites).map(columns).collect::<Result<Vec<_>, _>>()?;
        let of_row = |(n, far): (usize, &Vec<Interval>)| -> Vec<Interval> {
            columns.iter().zip(far).zip(steepest).map(|((column, far), steep)| column[n] + *far * *steep).collect()
        };
        let entries = far.iter().enumerate().map(of_row).collect();
        let weights = vec![Interval::ONE; block.sites + 1];
        Ok(Self { entries, contacts: sums(&block.reach, far), weights, rows: block.sites })
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

/// The sum of two matrices.
pub(super) fn sums(a: &[Vec<Interval>], b: &[Vec<Interval>]) -> Vec<Vec<Interval>> {
    a.iter().zip(b).map(|(a, b)| a.iter().zip(b).map(|(a, b)| *a + *b).collect()).collect()
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
