//! The linear equations `M` of a proof on the harmonics of a block, and an approximate inverse `A`.
//!
//! `M = P + B D`. `D` multiplies each site by its stiffness, and `B` takes harmonics of this to
//! equations. `P` is the identity on harmonics from `own` on, and the rows and columns of a few
//! further unknowns. `A` is the identity beyond the block. Vectors "by site" have an entry for each
//! site, and one for the further unknowns.

use super::{Moments, System, of};
use crate::interval::{Interval, norm};

/// Site, harmonic, and whether it is the coefficient of a sine.
pub(super) type Place = (usize, usize, bool);
/// The rows of `B`: columns and entries.
pub(super) type Rows = Vec<Vec<(usize, Interval)>>;

/// The weight of a harmonic in the norm: `sqrt 2` for the mean.
pub(super) fn weight(k: usize) -> Interval {
    if k == 0 { of(2).sqrt() } else { Interval::ONE }
}

/// The coefficient of `cos (k + odd/2) theta` in `D cos (j + odd/2) theta`; or that of the sines.
pub(super) fn product(d: &[Interval], k: usize, j: usize, (odd, sine): (usize, bool)) -> Interval {
    let h = |l: usize| d[l] / of(if l == 0 { 1 } else { 2 });
    let (near, far) = (h(k.abs_diff(j)), h(k + j + odd));
    let both = if sine { near - far } else { near + far };
    if k + odd == 0 { both / of(2) } else { both }
}

pub(super) fn dot(a: &[Interval], b: &[Interval]) -> Interval {
    a.iter().zip(b).map(|(a, b)| *a * *b).sum()
}

pub(super) fn kronecker(equal: bool) -> Interval {
    if equal { Interval::ONE } else { Interval::ZERO }
}

/// The largest of the first sums by site over their weights, and the entry after all sites.
pub(super) fn split(all: &[Interval], weights: &[Interval], rows: usize) -> [Interval; 2] {
    let most = all.iter().zip(weights).take(rows).map(|(one, w)| *one / *w).fold(Interval::ZERO, Interval::max);
    [most, all[weights.len()]]
}

/// A positive vector, at most 1, near the eigenvector of the largest eigenvalue.
pub(super) fn perron(rows: &[Vec<Interval>]) -> Vec<Interval> {
    let mut vector = vec![1.0; rows.len()];
    for _ in 0..50 {
        let next: Vec<f64> = rows.iter().map(|row| row.iter().zip(&vector).map(|(a, b)| a.mid() * b).sum()).collect();
        let most = next.iter().copied().fold(0.0, f64::max);
        vector = next.into_iter().map(|x| (x / most).clamp(0.01, 1.0)).collect();
    }
    vector.into_iter().map(Interval::exact).collect()
}

/// A floating-point inverse, which need not be accurate: Gauss-Jordan elimination with pivots.
fn approximate_inverse(mut rows: Vec<Vec<f64>>) -> Vec<Vec<Interval>> {
    let n = rows.len();
    for (i, row) in rows.iter_mut().enumerate() {
        row.resize(2 * n, 0.0);
        row[n + i] = 1.0;
    }
    for step in 0..n {
        let pivot = (step..n).max_by(|&i, &j| rows[i][step].abs().total_cmp(&rows[j][step].abs())).unwrap_or(step);
        rows.swap(step, pivot);
        let scale = rows[step][step];
        let row: Vec<f64> = rows[step].iter().map(|x| x / scale).collect();
        rows[step].clone_from(&row);
        for (_, other) in rows.iter_mut().enumerate().filter(|(i, other)| *i != step && other[step] != 0.0) {
            let factor = other[step];
            other[step..].iter_mut().zip(&row[step..]).for_each(|(x, y)| *x -= factor * y);
        }
    }
    rows.into_iter().map(|row| row[n..].iter().map(|x| Interval::exact(*x)).collect()).collect()
}

/// The unknowns and the matrices.
pub(super) struct Block {
    /// The unknowns but for the further ones.
    pub(super) all: Vec<Place>,
    sites: usize,
    /// First harmonic whose equations have the identity, and 1 for harmonics `k + 1/2`.
    own: usize,
    odd: usize,
    /// Row and column of `M` of each further unknown.
    more: Vec<[Vec<Interval>; 2]>,
    /// Largest distance of sites that `A M` couples.
    pub(super) coupled: usize,
    /// `A`, and `A B`.
    pub(super) inverse: Vec<Vec<Interval>>,
    pub(super) product: Vec<Vec<Interval>>,
    /// `R`, by site of the column.
    reach: Vec<Vec<Interval>>,
}

impl Block {
    /// The unknowns, without matrices.
    pub(super) fn new(all: Vec<Place>, sites: usize, [own, odd]: [usize; 2], more: Vec<[Vec<Interval>; 2]>) -> Self {
        let coupled = usize::MAX;
        Self { all, sites, own, odd, more, coupled, inverse: Vec::new(), product: Vec::new(), reach: Vec::new() }
    }

    pub(super) fn index(&self, place: Place) -> Option<usize> {
        self.all.iter().position(|other| *other == place)
    }

    /// The unknowns of a site.
    fn at(&self, n: usize) -> impl Iterator<Item = (usize, &Place)> {
        self.all.iter().enumerate().filter(move |(_, place)| place.0 == n)
    }

    /// The weight of a harmonic in the norm.
    pub(super) fn weight(&self, k: usize) -> Interval {
        weight(k + self.odd)
    }

    /// Sums over the rows of each site with the weights of the norm, and over the further rows.
    pub(super) fn by_site(&self, of_row: &dyn Fn(usize) -> Interval) -> Vec<Interval> {
        let mut sums = vec![Interval::ZERO; self.sites + 1];
        for i in 0..self.all.len() + self.more.len() {
            let (n, weight) = self.all.get(i).map_or((self.sites, Interval::ONE), |it| (it.0, self.weight(it.1)));
            sums[n] = sums[n] + weight * of_row(i);
        }
        sums
    }

    /// Rows of `B` from what it has by place.
    pub(super) fn rows(&self, of: impl Fn(Place) -> Vec<(Place, Interval)>) -> Rows {
        let entry = |(place, factor): (Place, Interval)| Some((self.index(place)?, factor));
        self.all.iter().map(|place| of(*place).into_iter().filter_map(entry).collect()).collect()
    }

    /// `M`, rounded to nearest: `A` may be any matrix.
    pub(super) fn matrix(&self, b: &Rows, known: &[Moments]) -> Vec<Vec<f64>> {
        let last = self.all.len();
        let mut matrix = vec![vec![0.0; last + self.more.len()]; last + self.more.len()];
        for (i, entries) in b.iter().enumerate() {
            for &(column, factor) in entries {
                let (m, k, part) = self.all[column];
                for (j, place) in self.at(m).filter(|(_, place)| place.2 == part) {
                    matrix[i][j] += (factor * product(&known[m].stiffness, k, place.1, (self.odd, part))).mid();
                }
            }
            if self.all[i].1 >= self.own {
                matrix[i][i] += 1.0;
            }
            for (further, [row, column]) in (last..).zip(&self.more) {
                (matrix[further][i], matrix[i][further]) = (row[i].mid(), column[i].mid());
            }
        }
        matrix
    }

    /// Makes `A`.
    pub(super) fn invert(&mut self, b: &Rows, known: &[Moments]) {
        self.inverse = approximate_inverse(self.matrix(b, known));
    }

    /// Makes what follows from `A`.
    pub(super) fn multiply(&mut self, b: &Rows) {
        self.product = self.times(b);
        self.reach = self.reach_of(&self.product);
    }

    /// `A B`.
    fn times(&self, b: &Rows) -> Vec<Vec<Interval>> {
        let of_row = |row: &Vec<Interval>| {
            let mut product = vec![Interval::ZERO; b.len()];
            for (entries, a) in b.iter().zip(row) {
                entries.iter().for_each(|(j, b)| product[*j] = product[*j] + *a * *b);
            }
            product
        };
        self.inverse.iter().map(of_row).collect()
    }

    /// Norms of the rows of `A B` for harmonics with `2 g_0^2 + sum g_k^2 = 1`, by site of the
    /// column.
    fn reach_of(&self, product: &[Vec<Interval>]) -> Vec<Vec<Interval>> {
        let of_site = |m: usize| {
            let own: Vec<(usize, Interval)> = self.at(m).map(|(j, place)| (j, self.weight(place.1))).collect();
            self.by_site(&|i| norm(own.iter().map(|(j, weight)| product[i][*j] / *weight)))
        };
        (0..self.sites).map(of_site).collect()
    }

    /// Adds `R` of the changes of `B` along a piece, and returns it.
    pub(super) fn turned(&mut self, b: &Rows) -> Vec<Vec<Interval>> {
        let turned = self.reach_of(&self.times(b));
        let all = self.reach.iter_mut().flatten().zip(turned.iter().flatten());
        all.for_each(|(sum, turned)| *sum = *sum + *turned);
        turned
    }

    /// `R + t |e|`, by row.
    pub(super) fn contacts(&self, system: &System, t: Interval) -> Vec<Vec<Interval>> {
        let of_row = |n: usize| self.reach.iter().zip(system.moduli(n)).map(|(reach, e)| reach[n] + t * e).collect();
        (0..=self.sites).map(of_row).collect()
    }

    /// The largest columns of `1 - A M` of a site with the stiffness `d`, by site: of these places,
    /// and of those beyond, of which the rows see a tail of `d` only.
    pub(super) fn columns(&self, m: usize, places: Vec<Place>, d: &[Interval], tail: Interval) -> Vec<Interval> {
        let beyond = tail / of(2).sqrt();
        let mut most: Vec<Interval> = self.reach[m].iter().map(|reach| *reach * beyond).collect();
        for (_, j, part) in places {
            let own = self.index((m, j, part));
            let entries = self.at(m).filter(|(_, place)| place.2 == part);
            let entries: Vec<_> = entries.map(|(i, it)| (i, product(d, it.1, j, (self.odd, part)))).collect();
            let sums = self.by_site(&|i| {
                if self.all.get(i).is_some_and(|it| it.0.abs_diff(m) > self.coupled) {
                    return Interval::ZERO;
                }
                let (row, further) = self.inverse[i].split_at(self.all.len());
                let plain = |own: usize| -> Interval {
                    let more = self.more.iter().zip(further).map(|([row, _], a)| *a * row[own]).sum();
                    if j >= self.own { row[own] + more } else { more }
                };
                let stiff = entries.iter().map(|(column, d)| self.product[i][*column] * *d).sum();
                (kronecker(own == Some(i)) - own.map_or(Interval::ZERO, plain) - stiff).abs()
            });
            most.iter_mut().zip(sums).for_each(|(most, sum)| *most = most.max(sum / self.weight(j)));
        }
        most
    }

    /// The same of the further unknowns, in the rows of the block.
    pub(super) fn further_columns(&self) -> Vec<Interval> {
        let mut most = vec![Interval::ZERO; self.sites + 1];
        for (own, [_, column]) in (self.all.len()..).zip(&self.more) {
            let sums = self.by_site(&|i| (kronecker(i == own) - dot(&self.inverse[i][..column.len()], column)).abs());
            most.iter_mut().zip(sums).for_each(|(most, sum)| *most = most.max(sum));
        }
        most
    }
}
