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
pub(crate) struct Polynomial([f64; NODES]);

impl Polynomial {
    /// The value at `s` (de Casteljau).
    pub(crate) fn at(&self, s: f64) -> f64 {
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
    pub(crate) fn first_crossing(&self, positive: bool, late: bool, band: f64) -> Option<(f64, f64)> {
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
pub(crate) struct Interpolation {
    coefficients: [[f64; NODES]; NODES],
    /// Coefficients differ from the middle of the values by at most this many times half their
    /// range.
    stretch: f64,
}

impl Interpolation {
    pub(crate) fn new() -> Self {
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

    /// The polynomial with these values at the nodes.
    pub(crate) fn through(&self, values: &[f64; NODES]) -> Polynomial {
        let mut c: [f64; NODES] =
            std::array::from_fn(|j| self.coefficients[j].iter().zip(values).map(|(m, value)| m * value).sum());
        (c[0], c[NODES - 1]) = (values[0], values[NODES - 1]);
        Polynomial(c)
    }

    /// Whether the polynomial through these values certainly does not leave the band on the other
    /// side. This test saves most searches.
    pub(crate) fn stays(&self, values: &[f64; NODES], positive: bool, band: f64) -> bool {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn through(f: impl Fn(f64) -> f64) -> Polynomial {
        let interpolation = Interpolation::new();
        interpolation.through(&SHARES.map(f))
    }

    #[test]
    fn values_are_taken_at_chebyshev_lobatto_points() {
        for (k, share) in SHARES.into_iter().enumerate() {
            let angle = std::f64::consts::PI * k as f64 / 14.0;
            assert!((share - angle.sin().powi(2)).abs() < f64::EPSILON);
        }
    }

    #[test]
    fn a_polynomial_of_degree_seven_is_met_everywhere() {
        let f = |s: f64| (s - 0.3) * (s - 0.31) * (s + 1.0) * (s * s + 0.5) * (s - 2.0) * (1.0 - 3.0 * s);
        let p = through(f);
        for k in 0..=100 {
            let s = f64::from(k) / 100.0;
            assert!((p.at(s) - f(s)).abs() < 1e-14, "{s}");
        }
    }

    #[test]
    fn a_short_excursion_inside_a_step_is_seen_and_a_near_miss_is_none() {
        // Above zero only on (0.3, 0.3 + 2e-5): 1e-10 high.
        let f = |shift: f64| move |s: f64| -(s - 0.3) * (s - 0.300_02) - shift;
        let (zero, left) = through(f(0.0)).first_crossing(false, false, 1e-12).unwrap();
        assert!((zero - 0.3).abs() < 1e-10 && left > zero && left < 0.300_01, "{zero} {left}");
        assert!(through(f(2e-10)).first_crossing(false, false, 1e-12).is_none());
        assert!(through(f(0.0)).first_crossing(false, false, 2e-10).is_none());
    }

    #[test]
    fn the_zero_is_the_last_before_the_band_is_left() {
        // Zeros at 0.2, 0.4 and 0.6; between the first two it stays inside the band.
        let p = through(|s| 1e-3 * (s - 0.2) * (s - 0.4) * (s - 0.6));
        let (zero, left) = p.first_crossing(false, false, 2e-5).unwrap();
        assert!((zero - 0.6).abs() < 1e-12 && left > 0.6);
        // A polynomial that starts inside the band and leaves it: the zero is the start.
        let p = through(|s| 1e-12 + s);
        assert_eq!(p.first_crossing(false, false, 1e-9).unwrap().0, 0.0);
    }

    #[test]
    fn a_late_function_is_waited_for() {
        let p = through(|s| s - 0.25);
        assert!(p.first_crossing(true, true, 1e-12).is_none());
        let p = through(|s| (s - 0.25) * (0.75 - s));
        assert!((p.first_crossing(true, true, 1e-12).unwrap().0 - 0.75).abs() < 1e-12);
        assert_eq!(p.first_crossing(true, false, 1e-12).unwrap().0, 0.0);
    }

    #[test]
    fn the_certificate_never_lies() {
        let interpolation = Interpolation::new();
        let mut seed = 1u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let mut certified = 0;
        for _ in 0..2000 {
            let offset = 200.0 * random();
            let values: [f64; NODES] = std::array::from_fn(|_| offset + random());
            let positive = offset > 0.0;
            if interpolation.stays(&values, positive, 0.0) {
                certified += 1;
                assert!(interpolation.through(&values).first_crossing(positive, false, 0.0).is_none());
            }
        }
        assert!((200..1900).contains(&certified), "{certified}");
    }
}
