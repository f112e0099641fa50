//! A step as a polynomial in the Bernstein basis, whose coefficients bound its values.

use super::root::bracketed;

/// Number of values; they define a polynomial of degree 7, the degree of the dense output of
/// DOP853.
pub const NODES: usize = 8;

/// Where the values are, as shares of an interval: Chebyshev-Lobatto points, `sin^2(k pi/14)`.
pub const SHARES: [f64; NODES] = [
    0.0,
    0.049_515_566_048_790_434,
    0.188_255_099_070_633_23,
    0.388_739_533_021_842_7,
    0.611_260_466_978_157_2,
    0.811_744_900_929_366_8,
    0.950_484_433_951_209_6,
    1.0,
];

/// A polynomial of degree 7 on `[0, 1]` in the Bernstein basis: `sum c_j C(7, j) s^j (1-s)^{7-j}`.
///
/// Its values lie between its smallest and its largest coefficient. Halving the interval tightens
/// these bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polynomial([f64; NODES]);

impl Polynomial {
    /// The value at `s` (de Casteljau).
    pub fn at(&self, s: f64) -> f64 {
        let mut c = self.0;
        for last in (0..NODES - 1).rev() {
            for j in 0..=last {
                c[j] += s * (c[j + 1] - c[j]);
            }
        }
        c[0]
    }

    /// The parts on `[0, s]` and `[s, 1]`, each rescaled to `[0, 1]` (de Casteljau).
    pub(crate) fn split(&self, s: f64) -> (Self, Self) {
        let (mut left, mut right) = (self.0, self.0);
        for (level, left) in left.iter_mut().enumerate() {
            *left = right[0];
            for j in 0..NODES - 1 - level {
                right[j] += s * (right[j + 1] - right[j]);
            }
        }
        (Self(left), Self(right))
    }

    /// The polynomial `p(1 - s)`.
    fn reversed(&self) -> Self {
        let mut c = self.0;
        c.reverse();
        Self(c)
    }

    fn times(&self, sign: f64) -> Self {
        Self(self.0.map(|c| sign * c))
    }

    /// The first `s` at which the polynomial exceeds `level`.
    fn first_above(&self, level: f64) -> Option<f64> {
        self.first_above_in((0.0, 1.0), level)
    }

    /// As [`first_above`](Self::first_above), for a polynomial on an interval given by its start
    /// and its length.
    fn first_above_in(&self, (start, length): (f64, f64), level: f64) -> Option<f64> {
        if self.0.iter().all(|&c| c <= level) || !self.0.iter().all(|c| c.is_finite()) {
            return None;
        }
        if self.0[0] > level || length < f64::EPSILON {
            return Some(start);
        }
        // One change of sign of the coefficients means one root (Descartes).
        let changes = self.0.windows(2).filter(|pair| (pair[0] > level) != (pair[1] > level)).count();
        if changes == 1 {
            let ends = ((0.0, self.0[0] - level), (1.0, self.0[NODES - 1] - level));
            return Some(start + length * bracketed(|s| self.at(s) - level, ends.0, ends.1));
        }
        let (left, right) = self.split(0.5);
        let half = 0.5 * length;
        left.first_above_in((start, half), level).or_else(|| right.first_above_in((start + half, half), level))
    }

    /// Whether the polynomial leaves the band on this side.
    pub(crate) fn visits(&self, positive: bool, band: f64) -> bool {
        self.times(if positive { 1.0 } else { -1.0 }).first_above(band).is_some()
    }

    /// Whether the polynomial exceeds a level on this side before it leaves the band on the other
    /// one.
    pub(crate) fn leaves_first(&self, positive: bool, level: f64, band: f64) -> bool {
        let sign = if positive { 1.0 } else { -1.0 };
        let Some(left) = self.times(sign).first_above(level) else { return false };
        self.times(-sign).first_above(band).is_none_or(|other| left < other)
    }

    /// The first change of side, as shares `(zero, left)` of the step: the band is left at `left`;
    /// `zero` is the last zero before it. `positive` is the side before. With `late`, the search
    /// begins where the polynomial first leaves the band on that side.
    pub fn first_crossing(&self, positive: bool, late: bool, band: f64) -> Option<(f64, f64)> {
        let to_far_side = self.times(if positive { -1.0 } else { 1.0 });
        let from = if late { to_far_side.times(-1.0).first_above(band)? } else { 0.0 };
        let rest = to_far_side.split(from).1;
        let left = rest.first_above(band)?;
        let back = rest.split(left).0.reversed().times(-1.0);
        let zero = back.first_above(0.0).map_or(0.0, |share| left * (1.0 - share));
        let whole = |s: f64| from + (1.0 - from) * s;
        Some((whole(zero), whole(left)))
    }
}

/// Computes polynomials from values at fixed nodes.
#[derive(Clone, Debug)]
pub struct Interpolation {
    coefficients: [[f64; NODES]; NODES],
    /// Coefficients differ from the middle of the values by at most this many times half their
    /// range.
    stretch: f64,
}

impl Default for Interpolation {
    fn default() -> Self {
        let basis = SHARES.map(|s| {
            std::array::from_fn(|j| {
                let mut unit = Polynomial([0.0; NODES]);
                unit.0[j] = 1.0;
                unit.at(s)
            })
        });
        let coefficients = inverse(basis);
        let stretch = coefficients.iter().map(|row| row.iter().map(|c| c.abs()).sum()).fold(1.0, f64::max);
        Self { coefficients, stretch }
    }
}

impl Interpolation {
    /// The polynomial with these values at the nodes.
    pub fn through(&self, values: &[f64; NODES]) -> Polynomial {
        let mut c: [f64; NODES] =
            std::array::from_fn(|j| self.coefficients[j].iter().zip(values).map(|(m, value)| m * value).sum());
        (c[0], c[NODES - 1]) = (values[0], values[NODES - 1]);
        Polynomial(c)
    }

    /// Whether the polynomial through these values certainly does not leave the band on the other
    /// side. This test saves most searches.
    pub fn stays(&self, values: &[f64; NODES], positive: bool, band: f64) -> bool {
        let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(low, high), &v| (low.min(v), high.max(v)));
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let nearest = if positive { -middle } else { middle } + self.stretch * half;
        nearest <= band
    }
}

/// The inverse of a small matrix (Gauss and Jordan, largest pivot).
fn inverse(mut a: [[f64; NODES]; NODES]) -> [[f64; NODES]; NODES] {
    let mut b: [[f64; NODES]; NODES] = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
    for column in 0..NODES {
        let pivot = (column..NODES).max_by(|&i, &j| a[i][column].abs().total_cmp(&a[j][column].abs()));
        let pivot = pivot.unwrap_or(column);
        a.swap(column, pivot);
        b.swap(column, pivot);
        let scale = 1.0 / a[column][column];
        for j in 0..NODES {
            a[column][j] *= scale;
            b[column][j] *= scale;
        }
        for i in (0..NODES).filter(|&i| i != column) {
            let factor = a[i][column];
            for j in 0..NODES {
                a[i][j] -= factor * a[column][j];
                b[i][j] -= factor * b[column][j];
            }
        }
    }
    b
}
