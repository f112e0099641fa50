//! The linear equations `M` of a proof on the harmonics of a block, and an approximate inverse `A`.
//!
//! `M = P + B D`. `D` multiplies each site by its stiffness, and `B` takes harmonics of this to
//! equations. `P` is the identity beyond the block, as `A` is. A few further unknowns come after the
//! harmonics. Vectors "by site" have an entry for each site, and one for the further unknowns.

use super::{Moments, Refused, of};
use crate::interval::{Interval, norm};

/// Site, harmonic, and whether it is the coefficient of a sine.
pub type Place = (usize, usize, bool);
/// The rows of `B`: columns and entries; or the columns of `P`: rows and entries.
pub(super) type Lines = Vec<Vec<(usize, Interval)>>;

/// The weight of a harmonic in the norm: `sqrt 2` for the mean.
pub fn weight(k: usize) -> Interval {
    if k == 0 { of(2).sqrt() } else { Interval::ONE }
}

/// The coefficient of `cos (k + odd/2) theta` in `D cos (j + odd/2) theta`; or that of the sines.
pub fn product(d: &[Interval], k: usize, j: usize, (odd, sine): (usize, bool)) -> Interval {
    let h = |l: usize| d[l] / of(if l == 0 { 1 } else { 2 });
    let (near, far) = (h(k.abs_diff(j)), h(k + j + odd));
    let both = if sine { near - far } else { near + far };
    if k + odd == 0 { both / of(2) } else { both }
}

/// The product of two vectors.
pub fn dot(a: &[Interval], b: &[Interval]) -> Interval {
    a.iter().zip(b).map(|(a, b)| *a * *b).sum()
}

pub(super) fn kronecker(equal: bool) -> Interval {
    if equal { Interval::ONE } else { Interval::ZERO }
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

/// The largest of numbers that are not negative.
pub(super) fn largest(all: &[Interval]) -> Interval {
    all.iter().copied().fold(Interval::ZERO, Interval::max)
}

/// The solutions of linear systems in floating point, which need not be accurate: Gauss-Jordan
/// elimination with pivots. Rows end with the right-hand sides, rows of the result have solutions.
pub(crate) fn solved(mut rows: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let n = rows.len();
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
    rows.into_iter().map(|row| row[n..].to_vec()).collect()
}

/// The unknowns and the matrices.
pub struct Block {
    /// The unknowns but for the further ones.
    pub all: Vec<Place>,
    sites: usize,
    /// 1 for harmonics `k + 1/2`.
    odd: usize,
    /// The columns of `P`.
    plain: Lines,
    /// Largest distance of sites that `A M` couples.
    pub coupled: usize,
    /// `A`.
    pub inverse: Vec<Vec<Interval>>,
    /// `A B`.
    pub product: Vec<Vec<Interval>>,
    /// `R`, by site of the column.
    reach: Vec<Vec<Interval>>,
}

impl Block {
    /// The unknowns, without matrices.
    pub fn new(all: Vec<Place>, sites: usize, odd: usize, plain: Lines) -> Self {
        let coupled = usize::MAX;
        Self { all, sites, odd, plain, coupled, inverse: Vec::new(), product: Vec::new(), reach: Vec::new() }
    }

    /// The number of an unknown.
    pub fn index(&self, place: Place) -> Option<usize> {
        self.all.iter().position(|other| *other == place)
    }

    /// The unknowns of a site.
    fn at(&self, n: usize) -> impl Iterator<Item = (usize, &Place)> {
        self.all.iter().enumerate().filter(move |(_, place)| place.0 == n)
    }

    /// The weight of a harmonic in the norm.
    pub fn weight(&self, k: usize) -> Interval {
        weight(k + self.odd)
    }

    /// Sums over the rows of each site with the weights of the norm, and over the further rows.
    pub fn by_site(&self, of_row: &dyn Fn(usize) -> Interval) -> Vec<Interval> {
        let mut sums = vec![Interval::ZERO; self.sites + 1];
        for i in 0..self.plain.len() {
            let (n, weight) = self.all.get(i).map_or((self.sites, Interval::ONE), |it| (it.0, self.weight(it.1)));
            sums[n] = sums[n] + weight * of_row(i);
        }
        sums
    }

    /// Rows of `B` from what it has by place.
    pub fn rows(&self, of: impl Fn(Place) -> Vec<(Place, Interval)>) -> Lines {
        let entry = |(place, factor): (Place, Interval)| Some((self.index(place)?, factor));
        self.all.iter().map(|place| of(*place).into_iter().filter_map(entry).collect()).collect()
    }

    /// `M`, rounded to nearest: `A` may be any matrix.
    pub fn matrix(&self, b: &Lines, known: &[Moments]) -> Vec<Vec<f64>> {
        let size = self.plain.len();
        let mut matrix = vec![vec![0.0; size]; size];
        for (i, entries) in b.iter().enumerate() {
            for &(column, factor) in entries {
                let (m, k, part) = self.all[column];
                for (j, place) in self.at(m).filter(|(_, place)| place.2 == part) {
                    matrix[i][j] += (factor * product(&known[m].stiffness, k, place.1, (self.odd, part))).mid();
                }
            }
        }
        for (j, column) in self.plain.iter().enumerate() {
            column.iter().for_each(|(i, entry)| matrix[*i][j] += entry.mid());
        }
        matrix
    }

    /// Makes `A`.
    pub fn invert(&mut self, b: &Lines, known: &[Moments]) {
        let identity = |i: usize| (0..self.plain.len()).map(move |j| f64::from(u8::from(i == j)));
        let rows = self.matrix(b, known).into_iter().enumerate();
        let inverse = solved(rows.map(|(i, row)| row.into_iter().chain(identity(i)).collect()).collect());
        self.inverse = inverse.iter().map(|row| row.iter().copied().map(Interval::exact).collect()).collect();
    }

    /// Makes what follows from `A`.
    pub fn multiply(&mut self, b: &Lines) {
        self.product = self.times(b);
        self.reach = self.reach_of(&self.product);
    }

    /// `A B`.
    pub fn times(&self, b: &Lines) -> Vec<Vec<Interval>> {
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
    pub fn reach_of(&self, product: &[Vec<Interval>]) -> Vec<Vec<Interval>> {
        let of_site = |m: usize| {
            let own: Vec<(usize, Interval)> = self.at(m).map(|(j, place)| (j, self.weight(place.1))).collect();
            self.by_site(&|i| norm(own.iter().map(|(j, weight)| product[i][*j] / *weight)))
        };
        (0..self.sites).map(of_site).collect()
    }

    /// `R`, and what is beyond the block, by row.
    pub fn contacts(&self, far: &[Vec<Interval>]) -> Vec<Vec<Interval>> {
        let of_row = |(n, far): (usize, &Vec<Interval>)| {
            self.reach.iter().zip(far).map(|(reach, far)| reach[n] + *far).collect()
        };
        far.iter().enumerate().map(of_row).collect()
    }

    /// Bounds of `(1 - A M) h` by site for `|h| <= 1`, from the columns of each site in the rows of
    /// the block, and from `far` beyond.
    pub fn z1(
        &self,
        far: &[Vec<Interval>],
        steepest: &[Interval],
        columns: impl Fn(usize) -> Result<Vec<Interval>, Refused>,
    ) -> Result<Vec<Interval>, Refused> {
        let columns = (0..self.sites).map(columns).collect::<Result<Vec<_>, _>>()?;
        let near = |n: usize| columns.iter().map(|column| column[n]).sum::<Interval>();
        Ok(far.iter().enumerate().map(|(n, far)| near(n) + dot(far, steepest)).collect())
    }

    /// The largest columns of `1 - A M` of a site with the stiffness `d`, by site: of these places,
    /// and of those beyond, of which the rows see a tail of `d` only.
    pub fn columns(&self, m: usize, places: Vec<Place>, d: &[Interval], tail: Interval) -> Vec<Interval> {
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
                let stiff = entries.iter().map(|(column, d)| self.product[i][*column] * *d).sum();
                (own.map_or(Interval::ZERO, |own| self.kept(i, own)) - stiff).abs()
            });
            most.iter_mut().zip(sums).for_each(|(most, sum)| *most = most.max(sum / self.weight(j)));
        }
        most
    }

    /// An entry of `1 - A P`.
    fn kept(&self, i: usize, own: usize) -> Interval {
        let image: Interval = self.plain[own].iter().map(|(row, entry)| self.inverse[i][*row] * *entry).sum();
        kronecker(own == i) - image
    }

    /// The same of the further unknowns, in the rows of the block.
    pub fn further_columns(&self) -> Vec<Interval> {
        let mut most = vec![Interval::ZERO; self.sites + 1];
        for own in self.all.len()..self.plain.len() {
            let sums = self.by_site(&|i| self.kept(i, own).abs());
            most.iter_mut().zip(sums).for_each(|(most, sum)| *most = most.max(sum));
        }
        most
    }
}
