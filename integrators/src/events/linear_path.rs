//! An overlap along the exact linear flow, and its zeros.

use super::root::bracketed;
use crate::real::Real;

/// Bound of the rounding error of a value, relative to the sum of its terms.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// The path `g(t) = a + b t + c cos(omega t) + d sin(omega t)` of an overlap between two kicks;
/// `a + b t` for `omega = 0`.
///
/// Its turning points are known in closed form, and between them it is monotone. Therefore every
/// zero can be isolated, for any number of periods in an interval. Coefficients must be finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearPath<R> {
    /// Overlap of the uniform motion, at `t = 0`.
    pub a: R,
    /// Rate of the uniform motion.
    pub b: R,
    /// Cosine amplitude; not used for `omega = 0`.
    pub c: R,
    /// Sine amplitude; not used for `omega = 0`.
    pub d: R,
    /// Frequency, at least zero.
    pub omega: R,
}

impl<R: Real> LinearPath<R> {
    /// `g` and `g'` at `t`.
    fn value_and_rate(&self, t: R) -> (R, R) {
        let line = self.a + self.b * t;
        if self.omega == R::zero() {
            return (line, self.b);
        }
        let (sin, cos) = (self.omega * t).sin_cos();
        (line + (self.c * cos + self.d * sin), self.b + self.omega * (self.d * cos - self.c * sin))
    }

    /// `g(t)`.
    pub fn at(&self, t: R) -> R {
        self.value_and_rate(t).0
    }

    /// `g'(t) = b + omega (d cos(omega t) - c sin(omega t))`.
    pub fn rate(&self, t: R) -> R {
        self.value_and_rate(t).1
    }

    /// `sqrt(c^2 + d^2)`.
    fn amplitude(&self) -> R {
        if self.omega == R::zero() { R::zero() } else { self.c.hypot(self.d) }
    }

    /// A generous bound of the rounding error of a value for `|t| <= reach`.
    fn rounding(&self, reach: R) -> R {
        let phase = R::one() + self.omega * reach;
        R::of(ROUNDING) * (self.a.abs() + self.b.abs() * reach + self.amplitude() * phase)
    }

    /// Bounds `(lo, hi)` with `lo <= g <= hi` on the interval between `t0` and `t1`, at the cost of
    /// one sine.
    ///
    /// On either side the tighter of two bounds: the line at the ends plus or minus the amplitude
    /// `A`; and, with the middle `m` and the half-length `l` of the interval,
    /// `g(m) +- (|g'(m)| l + A (omega l)^2 / 2)`.
    pub fn bounds(&self, t0: R, t1: R) -> (R, R) {
        let half = R::of(0.5);
        let (m, l, amplitude) = (half * (t0 + t1), half * (t1 - t0).abs(), self.amplitude());
        let rounding = self.rounding(t0.abs().max(t1.abs()));
        let (line, slope) = (self.a + self.b * m, self.b.abs() * l);
        let turn = self.omega * l;
        let (value, rate) = self.value_and_rate(m);
        let spread = rate.abs() * l + half * amplitude * turn * turn;
        let lo = (line - slope - amplitude).max(value - spread);
        let hi = (line + slope + amplitude).min(value + spread);
        (lo - rounding, hi + rounding)
    }

    /// Whether `g` certainly does not take the value `level` between `t0` and `t1`. `false` is no
    /// statement.
    pub fn misses(&self, t0: R, t1: R, level: R) -> bool {
        let (lo, hi) = self.bounds(t0, t1);
        lo > level || hi < level
    }

    /// Appends all zeros in `[t0, t1]`, `t0 <= t1`, in ascending order.
    ///
    /// The signs of the computed values at the ends and at the turning points decide: between two
    /// values of different sign there is one zero, and a value that is zero is a zero. A double
    /// zero is therefore found once, twice or not at all, depending on rounding. A path that is
    /// identically zero has none.
    pub fn roots(&self, t0: R, t1: R, out: &mut Vec<R>) {
        let amplitude = self.amplitude();
        if self.a == R::zero() && self.b == R::zero() && amplitude == R::zero() {
            return;
        }
        let Some((t0, t1)) = self.within_reach(t0, t1, amplitude) else { return };
        let mut from = (t0, self.at(t0));
        self.turning_points(t0, t1, amplitude, |t| self.monotone(&mut from, t, out));
        self.monotone(&mut from, t1, out);
        if from.1 == R::zero() {
            out.push(from.0);
        }
    }

    /// The part of `[t0, t1]` on which the line lies within the amplitude of zero.
    fn within_reach(&self, t0: R, t1: R, amplitude: R) -> Option<(R, R)> {
        if self.b == R::zero() {
            return Some((t0, t1));
        }
        let reach = amplitude + R::of(4.0) * self.rounding(t0.abs().max(t1.abs()));
        let (x, y) = ((-reach - self.a) / self.b, (reach - self.a) / self.b);
        let (t0, t1) = (t0.max(x.min(y)), t1.min(x.max(y)));
        (t0 <= t1).then_some((t0, t1))
    }

    /// Calls `visit` with every zero of `g'` inside `(t0, t1)`, in ascending order.
    ///
    /// With `c + i d = A e^{i phi}`, `g' = b - A omega sin(omega t - phi)`. It vanishes where
    /// `omega t = phi + k pi + (-1)^k sigma`, `sin sigma = b / (A omega)`.
    fn turning_points(&self, mut t0: R, t1: R, amplitude: R, mut visit: impl FnMut(R)) {
        let steepest = amplitude * self.omega;
        if steepest <= self.b.abs() {
            return;
        }
        let (phi, sigma) = (self.d.atan2(self.c), (self.b / steepest).asin());
        let half_turns = |t: R| ((self.omega * t - phi) / R::PI()).f64().floor() as i64;
        for k in half_turns(t0) - 1..=half_turns(t1) + 1 {
            let sigma = if k % 2 == 0 { sigma } else { -sigma };
            let t = (phi + R::of(k as f64) * R::PI() + sigma) / self.omega;
            if t0 < t && t < t1 {
                visit(t);
                t0 = t;
            }
        }
    }

    /// Reports the zero of the monotone part from `from` up to but not including `t`, if there is
    /// one. Then moves `from` to `t`.
    fn monotone(&self, from: &mut (R, R), t: R, out: &mut Vec<R>) {
        let (start, end) = (*from, (t, self.at(t)));
        if start.1 == R::zero() && start.0 < t {
            out.push(start.0);
        } else if start.1 != R::zero() && end.1 != R::zero() && (start.1 > R::zero()) != (end.1 > R::zero()) {
            out.push(bracketed(|t| self.at(t), start, end));
        }
        *from = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twofloat::TwoFloat;

    /// Pseudo-random numbers in (-1, 1).
    fn random(mut seed: u64) -> impl FnMut() -> f64 {
        move || {
            seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let z = (seed ^ (seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }
    }

    /// A random path and a random interval, of a thousandth of a period to forty periods.
    fn random_case(next: &mut impl FnMut() -> f64) -> (LinearPath<f64>, f64, f64) {
        let omega = if next() > 0.8 { 0.0 } else { 10f64.powf(next()) };
        let slope = 10f64.powf(-2.0 * next().abs());
        let path = LinearPath { a: next(), b: slope * next(), c: next(), d: next(), omega };
        let t0 = 3.0 * next();
        (path, t0, t0 + 10f64.powf(0.2 + 1.2 * next()))
    }

    fn roots(path: &LinearPath<f64>, t0: f64, t1: f64) -> Vec<f64> {
        let mut out = Vec::new();
        path.roots(t0, t1, &mut out);
        out
    }

    fn scale(path: &LinearPath<f64>, t: f64) -> f64 {
        path.a.abs() + path.b.abs() * t.abs() + (1.0 + path.omega * t.abs()) * path.amplitude()
    }

    /// Changes of sign on a fine grid.
    fn changes(path: &LinearPath<f64>, t0: f64, t1: f64, points: usize) -> Vec<f64> {
        let at = |i: usize| t0 + (t1 - t0) * i as f64 / points as f64;
        (0..points).filter(|&i| path.at(at(i)) * path.at(at(i + 1)) < 0.0).map(at).collect()
    }

    #[test]
    fn the_zeros_are_those_that_a_fine_grid_sees() {
        let mut next = random(1);
        let (mut found, mut unseen) = (0, 0);
        for case in 0..4000 {
            let (path, t0, t1) = random_case(&mut next);
            let (exact, grid) = (roots(&path, t0, t1), changes(&path, t0, t1, 1000));
            let width = (t1 - t0) / 1000.0;
            assert!(exact.windows(2).all(|pair| pair[0] <= pair[1]) && exact.iter().all(|&t| t0 <= t && t <= t1));
            for &t in &exact {
                assert!(path.at(t).abs() <= 4.0 * f64::EPSILON * scale(&path, t), "case {case}: {}", path.at(t));
            }
            for &t in &grid {
                assert!(exact.iter().any(|&r| t <= r && r <= t + width), "case {case}: no zero near {t}");
            }
            // Zeros that the grid misses come in pairs closer than the grid.
            let hidden: Vec<f64> =
                exact.iter().copied().filter(|r| !grid.iter().any(|t| t <= r && *r <= t + width)).collect();
            assert!(hidden.chunks(2).all(|pair| pair.len() == 2 && pair[1] - pair[0] <= 2.0 * width), "case {case}");
            found += exact.len();
            unseen += hidden.len();
        }
        println!("{found} zeros, {unseen} unseen by the grid");
        assert!(found > 4000);
    }

    #[test]
    fn the_bounds_hold_and_the_certificate_never_lies() {
        let mut next = random(2);
        let (mut certified, mut missed) = (0, 0);
        for case in 0..4000 {
            let (path, t0, t1) = random_case(&mut next);
            let (lo, hi) = path.bounds(t0, t1);
            for i in 0..=500 {
                let g = path.at(t0 + (t1 - t0) * f64::from(i) / 500.0);
                assert!(lo <= g && g <= hi, "case {case}: {g} not in [{lo}, {hi}]");
            }
            assert_eq!((lo, hi), path.bounds(t1, t0));
            let none = roots(&path, t0, t1).is_empty();
            assert!(none || !path.misses(t0, t1, 0.0), "case {case}");
            missed += usize::from(none);
            certified += usize::from(path.misses(t0, t1, 0.0));
        }
        println!("{certified} of {missed} certified");
        assert!(certified > missed / 2);
        let path = LinearPath { a: 1.0, b: 0.3, c: -0.4, d: 0.2, omega: 3.0 };
        let (lo, hi) = path.bounds(-1e-6, 1e-6);
        assert!(hi - lo < 2.1e-6 * path.rate(0.0).abs(), "a short interval has a tight bound");
        assert!(path.misses(-0.1, 0.1, 0.0) && path.misses(-0.1, 0.1, 2.0) && !path.misses(-0.1, 0.1, path.at(0.05)));
    }

    #[test]
    fn a_straight_path_does_not_look_at_its_amplitudes() {
        let path = LinearPath { a: 1.0, b: -4.0, c: f64::NAN, d: f64::NAN, omega: 0.0 };
        assert_eq!(roots(&path, -1.0, 1.0), [0.25]);
        assert_eq!((path.at(1.0), path.rate(1.0)), (-3.0, -4.0));
        assert!(path.misses(-1.0, 0.2, 0.0) && !path.misses(-1.0, 0.3, 0.0));
    }

    #[test]
    fn thousands_of_periods_lose_no_zero() {
        // cos(omega t) = 0 at (k + 1/2) pi / omega.
        let path = LinearPath { a: 0.0, b: 0.0, c: 1.0, d: 0.0, omega: 1e5 };
        let found = roots(&path, 0.0, 1.0);
        assert_eq!(found.len(), 31831);
        for (k, t) in found.iter().enumerate() {
            assert!((t - (k as f64 + 0.5) * std::f64::consts::PI / 1e5).abs() < 1e-15);
        }
        // With a slope, zeros exist only where the line is within the amplitude: 2 a period, and
        // one at either end.
        let path = LinearPath { a: -1e3, b: 1.0, ..path };
        let found = roots(&path, 0.0, 2e3);
        assert!(found.len().abs_diff(63662) <= 2 && found.len() % 2 == 1, "{}", found.len());
        assert!(found.iter().all(|&t| path.at(t).abs() < 1e-7));
    }

    #[test]
    fn close_zeros_are_told_apart() {
        // -cos t + cos s: zeros at -s and s, however small s.
        for s in [1e-2, 1e-4, 1e-6] {
            let path = LinearPath { a: f64::cos(s), b: 0.0, c: -1.0, d: 0.0, omega: 1.0 };
            let found = roots(&path, -1.0, 1.0);
            assert_eq!(found.len(), 2, "{s}");
            assert!((found[1] - s).abs() < 1e-16 / s && (found[0] + s).abs() < 1e-16 / s, "{s}: {found:?}");
        }
        // The computed value at the turning point decides: just above zero, zero, just below.
        let touching = |a| LinearPath { a, b: 0.0, c: -1.0, d: 0.0, omega: 1.0 };
        assert_eq!(roots(&touching(1.0 + f64::EPSILON), -1.0, 1.0).len(), 0);
        assert_eq!(roots(&touching(1.0), -1.0, 1.0), [0.0]);
        assert_eq!(roots(&touching(1.0 - f64::EPSILON), -1.0, 1.0).len(), 2);
    }

    #[test]
    fn zeros_on_the_ends_count_once() {
        let line = LinearPath { a: 0.0, b: 1.0, c: 0.0, d: 0.0, omega: 0.0 };
        assert_eq!(roots(&line, 0.0, 1.0), [0.0]);
        assert_eq!(roots(&line, -1.0, 0.0), [0.0]);
        assert_eq!(roots(&line, 0.0, 0.0), [0.0]);
        assert!(roots(&line, 0.5, 1.0).is_empty());
        let wave = LinearPath { a: -1.0, b: 0.0, c: 1.0, d: 0.0, omega: 1.0 };
        assert_eq!(roots(&wave, 0.0, 1.0), [0.0]);
    }

    #[test]
    fn nothing_at_all_has_no_zeros() {
        let nothing = LinearPath { a: 0.0, b: 0.0, c: 0.0, d: 0.0, omega: 2.0 };
        assert!(roots(&nothing, -1.0, 1.0).is_empty() && !nothing.misses(-1.0, 1.0, 0.0));
        assert!(roots(&LinearPath { c: 5.0, omega: 0.0, ..nothing }, -1.0, 1.0).is_empty());
        // Tiny coefficients are not zero.
        let tiny = LinearPath { a: -1e-250, b: 2e-250, ..nothing };
        assert_eq!(roots(&tiny, 0.0, 1.0), [0.5]);
    }

    #[test]
    fn double_double_paths_have_double_double_zeros() {
        let of = TwoFloat::from;
        let path = LinearPath { a: of(0.1), b: of(0.3), c: of(-0.7), d: of(0.2), omega: of(2.0) };
        let mut out = Vec::new();
        path.roots(of(-4.0), of(4.0), &mut out);
        let rough = LinearPath { a: 0.1, b: 0.3, c: -0.7, d: 0.2, omega: 2.0 };
        assert_eq!(out.len(), roots(&rough, -4.0, 4.0).len());
        assert!(!out.is_empty() && out.iter().all(|&t| path.at(t).hi().abs() < 1e-29), "{out:?}");
    }
}
