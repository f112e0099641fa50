//! The one argument of Newton and Kantorovich, on the series of finitely many sites.
//!
//! `T(u) = u - A G(u)` with any matrix `A` on the harmonics of a block and a few further unknowns,
//! and the identity beyond. `DG = P + B D`: `D` multiplies each site by its stiffness, `B` takes
//! harmonics of this to equations, and `P` is the identity beyond the block. The norm is the
//! largest over the sites of `sum_k w_k |u_nk|/W_n`, and over the further unknowns `|g|/W`. Vectors
//! "by row" have an entry for each site, and a last one for the further unknowns.

use super::{Refused, of};
use crate::interval::{Interval, norm};

/// Ratio of two radii that are tried, and their largest number.
pub const RUNG: f64 = 1.2;
const RUNGS: usize = 200;

/// Site, harmonic, and whether it is the coefficient of a sine.
pub type Place = (usize, usize, bool);
/// The rows of `B`: columns and entries; or the columns of `P`: rows and entries.
pub(crate) type Lines = Vec<Vec<(usize, Interval)>>;

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
#[derive(Default)]
pub struct Block {
    /// The unknowns but for the further ones.
    pub all: Vec<Place>,
    /// Number of sites.
    pub sites: usize,
    /// 1 for harmonics `k + 1/2`.
    pub odd: usize,
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

    /// The unknowns of a site, or of one part of it.
    pub fn at(&self, n: usize, part: Option<bool>) -> impl Iterator<Item = (usize, &Place)> {
        self.all.iter().enumerate().filter(move |(_, it)| it.0 == n && part.is_none_or(|part| it.2 == part))
    }

    /// Sums over the rows of each site with the weights of the norm, and over the further rows.
    pub fn by_site(&self, of_row: &dyn Fn(usize) -> Interval) -> Vec<Interval> {
        let mut sums = vec![Interval::ZERO; self.sites + 1];
        for i in 0..self.plain.len() {
            let (n, weight) = self.all.get(i).map_or((self.sites, Interval::ONE), |it| (it.0, weight(it.1 + self.odd)));
            sums[n] = sums[n] + weight * of_row(i);
        }
        sums
    }

    /// `|A g|` by row, of a vector with these entries in the block and these norms `beyond` it.
    pub fn image(&self, g: &[Interval], beyond: impl Fn(usize) -> Interval) -> Vec<Interval> {
        let head = self.by_site(&|i| dot(&self.inverse[i], g).abs());
        head.into_iter().enumerate().map(|(n, head)| head + beyond(n)).collect()
    }

    /// Rows of `B` from what it has by place.
    pub fn rows(&self, of: impl Fn(Place) -> Vec<(Place, Interval)>) -> Lines {
        let entry = |(place, factor): (Place, Interval)| Some((self.index(place)?, factor));
        self.all.iter().map(|place| of(*place).into_iter().filter_map(entry).collect()).collect()
    }

    /// `A B`, and the norms of its rows for harmonics with `2 g_0^2 + sum g_k^2 = 1`, by row and by
    /// site of the column.
    pub fn times(&self, b: &Lines) -> [Vec<Vec<Interval>>; 2] {
        let of_row = |row: &Vec<Interval>| {
            let mut product = vec![Interval::ZERO; b.len()];
            for (entries, a) in b.iter().zip(row) {
                entries.iter().for_each(|(j, b)| product[*j] = product[*j] + *a * *b);
            }
            product
        };
        let product: Vec<Vec<Interval>> = self.inverse.iter().map(of_row).collect();
        let of_site =
            |m: usize| self.by_site(&|i| norm(self.at(m, None).map(|(j, it)| product[i][j] / weight(it.1 + self.odd))));
        let sites: Vec<Vec<Interval>> = (0..self.sites).map(of_site).collect();
        let reach = (0..=self.sites).map(|n| sites.iter().map(|site| site[n]).collect()).collect();
        [product, reach]
    }

    /// The largest columns of `1 - A DG` of a site with the stiffness `d`, by row: of these places,
    /// and of those beyond, of which the rows see a tail of `d` only.
    pub fn columns(&self, m: usize, places: Vec<Place>, d: &[Interval], tail: Interval) -> Vec<Interval> {
        let mut most: Vec<Interval> = self.reach.iter().map(|row| row[m] * (tail / of(2).sqrt())).collect();
        for (_, j, part) in places {
            let own = self.index((m, j, part));
            let entries: Vec<_> =
                self.at(m, Some(part)).map(|(i, it)| (i, product(d, it.1, j, (self.odd, part)))).collect();
            let sums = self.by_site(&|i| {
                let stiff = entries.iter().map(|(column, d)| self.product[i][*column] * *d).sum();
                (own.map_or(Interval::ZERO, |own| self.kept(i, own)) - stiff).abs()
            });
            most.iter_mut().zip(sums).for_each(|(most, sum)| *most = most.max(sum / weight(j + self.odd)));
        }
        most
    }

    /// An entry of `1 - A P`.
    fn kept(&self, i: usize, own: usize) -> Interval {
        let image: Interval = self.plain[own].iter().map(|(row, entry)| self.inverse[i][*row] * *entry).sum();
        kronecker(own == i) - image
    }

    /// The largest columns of the further unknowns, in the rows of the block.
    pub fn further_columns(&self) -> Vec<Interval> {
        let columns = (self.all.len()..self.plain.len()).map(|own| self.by_site(&|i| self.kept(i, own).abs()));
        let most =
            |most: Vec<Interval>, column| most.into_iter().zip(column).map(|(a, b): (Interval, _)| a.max(b)).collect();
        columns.fold(vec![Interval::ZERO; self.sites + 1], most)
    }
}

/// Bounds of the derivative of `T`, by row and by site of the column, and last those of the further
/// unknowns.
pub struct Derivative {
    /// Those at the centre.
    pub entries: Vec<Vec<Interval>>,
    /// `R + t |e|`: what one unit of `sqrt 2 |g|_{L2}` at each site does in the rows.
    pub contacts: Vec<Vec<Interval>>,
    /// `W_n`, and that of the further unknowns.
    pub weights: Vec<Interval>,
    /// Sites whose bounds are those of all sites.
    pub rows: usize,
}

impl Derivative {
    /// From the columns of each site in the rows of the block, those of the further unknowns, and
    /// `far`, `t |e|`, beyond: there `sqrt 2 |D h|_{L2}` is at most `steepest`.
    pub fn new(
        block: &Block,
        far: &[Vec<Interval>],
        steepest: &[Interval],
        further: &[Interval],
        columns: impl Fn(usize) -> Result<Vec<Interval>, Refused>,
    ) -> Result<Self, Refused> {
        let columns = (0..block.sites).map(columns).collect::<Result<Vec<_>, _>>()?;
        let of_row = |(n, far): (usize, &Vec<Interval>)| -> Vec<Interval> {
            let sites = columns.iter().zip(far).zip(steepest).map(|((column, far), steep)| column[n] + *far * *steep);
            sites.chain([further[n]]).collect()
        };
        let entries = far.iter().enumerate().map(of_row).collect();
        let contacts = sums(&block.reach, far);
        Ok(Self { entries, contacts, weights: Vec::new(), rows: block.sites })
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

/// The radius `r` of a ball that `T` maps into itself, that of uniqueness, and `q` on the former,
/// where `q(r)` bounds the derivative of `T` on balls: `Y0 + q r' <= r'` with `q` of a ball of
/// radius `r >= r'`, and `q < 1` on that of uniqueness. Both are at most `largest`.
pub fn radii(y0: Interval, largest: f64, q: impl Fn(f64) -> Interval) -> Option<(Interval, f64, Interval)> {
    let (mut ball, mut unique, mut r) = (None, None, y0.hi());
    for _ in 0..RUNGS {
        let q = q(r);
        if !((Interval::ONE - q).is_positive() && r <= largest) {
            break;
        }
        let image = y0 / (Interval::ONE - q);
        if ball.is_none() && image.hi() <= r {
            ball = Some((Interval::exact(image.hi()), q));
        }
        unique = Some(r);
        r *= RUNG;
    }
    ball.zip(unique).map(|((radius, q), unique)| (radius, unique, q))
}
