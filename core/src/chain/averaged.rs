//! Kicks averaged over a window of time, along the exact linear flow.
//!
//! | symbol | meaning |
//! |---|---|
//! | `M_b` | moments of the force of bond `b` over the window: `int f (1, t, cos(omega t), sin(omega t)) dt` |
//! | `J_i` | moments of the force on bead `i`: `M_i - M_{i+1}` (on a strain, the difference of two such) |
//! | `D_b` | `J_{b-1} - J_b`: change of an overlap's path by the kick, but for the masses |
//!
//! In the variables that the linear flow does not change, a force at the time `t` adds `m f` to
//! `V`, `-m f t` to `R0`, `-mu f sin(omega t)/omega` to `C` and `mu f cos(omega t)/omega` to `S`.
//! The kick adds these changes for the whole window at once, with `f` along the path of the mean of
//! the states before and after: the implicit midpoint rule for the Hamiltonian `int V dt`. The rule
//! is iterated until the moments no longer change.

use super::{
    ContactLaw, LinearFlow,
    gauss::{self, gauss},
};
use hertzchain_integrators::{
    Real, SplitFlow, Twofold,
    events::LinearPath,
    regularised::power,
    system::{ContactFlow, PathFlow},
};

/// Largest number of iterations; each reduces the error by a factor of the size of `f' h^2`.
/// Chosen, not measured.
const ITERATIONS: usize = 20;

/// `int f (1, t, cos(omega t), sin(omega t)) dt`.
type Moments<R> = [R; 4];

/// Buffers of an averaged kick.
pub(super) struct Bonds<R> {
    /// Paths of the bonds that can touch, from the state before the kick.
    paths: Vec<LinearPath<R>>,
    /// `M_b` of all bonds.
    moments: Vec<Moments<R>>,
    /// The `D_b` that `M_b` was computed with, of the bonds that can touch.
    shifts: Vec<Moments<R>>,
    roots: Vec<R>,
}

impl<R: Real> Bonds<R> {
    pub(super) fn new() -> Self {
        Self { paths: Vec::new(), moments: Vec::new(), shifts: Vec::new(), roots: Vec::new() }
    }
}

impl<R: Real> LinearFlow<R> {
    /// The path of an overlap from the present state on, without kicks.
    fn path(&self, bond: usize, phase: (R, R)) -> LinearPath<R> {
        let omega = self.omega();
        let [r, r_dot, p, p_dot] = self.chain.topology().across(bond, |i| self.motions(i, phase));
        LinearPath {
            a: self.chain.precompression() + r,
            b: r_dot,
            c: p,
            d: if omega > R::zero() { p_dot / omega } else { p_dot },
            omega,
        }
    }

    /// The path that belongs to the mean of the states before and after a kick; `shift` is `D_b`.
    fn midway(&self, path: &LinearPath<R>, shift: Moments<R>) -> LinearPath<R> {
        let (m, mu) = (R::of(0.5) * self.m(), R::of(0.5) * self.mu_over_omega);
        LinearPath {
            a: path.a - m * shift[1],
            b: path.b + m * shift[0],
            c: path.c - mu * shift[3],
            d: path.d + mu * shift[2],
            omega: path.omega,
        }
    }

    /// The moments of all bonds; `false` if nothing touches in the window.
    fn solve(&self, bonds: &mut Bonds<R>, window: (R, R)) -> bool {
        let (chain, law, phase) = (&self.chain, self.chain.law(), self.phase.sin_cos());
        let Bonds { paths, moments, shifts, roots } = bonds;
        let (topology, touching) = (chain.topology(), chain.touching());
        paths.clear();
        paths.extend(touching.clone().map(|bond| self.path(bond, phase)));
        moments.clear();
        moments.resize(chain.sites() + 1, [R::zero(); 4]);
        shifts.clear();
        shifts.resize(paths.len(), [R::nan(); 4]);
        let mut any = false;
        for _ in 0..ITERATIONS {
            let mut settled = true;
            for (k, bond) in touching.clone().enumerate() {
                let shift = topology.across(bond, |site| topology.push(site, |b| moments[b]));
                if shift == shifts[k] {
                    continue;
                }
                shifts[k] = shift;
                let new = over_window(&law, &self.midway(&paths[k], shift), window, roots);
                any |= new[0] != R::zero();
                settled &= new == moments[bond];
                moments[bond] = new;
            }
            if settled {
                break;
            }
        }
        any
    }

    /// Adds the kick with these moments to the sites.
    fn push(&mut self, moments: &[Moments<R>]) {
        self.count_kick();
        let ((sin, cos), tau, m, mu) = (self.phase.sin_cos(), self.tau, self.m(), self.mu_over_omega);
        for i in 0..self.chain.sites() {
            let [j, j_t, j_cos, j_sin] = self.chain.topology().push(i, |bond| moments[bond]);
            if let [r0, v] = &mut self.centre
                && !v.is_empty()
            {
                r0[i] -= m * (j * tau + j_t);
                v[i] += m * j;
            }
            if let [c, s] = &mut self.oscillation
                && !s.is_empty()
            {
                c[i] -= mu * (j_cos * sin + j_sin * cos);
                s[i] += mu * (j_cos * cos - j_sin * sin);
            }
        }
    }
}

impl<R: Real> ContactFlow<R> for LinearFlow<R> {
    fn bonds(&self) -> usize {
        self.chain.touching().len()
    }

    fn overlaps(&self, overlaps: &mut [R], rates: &mut [R]) -> R {
        let phase = self.phase.sin_cos();
        let position = |i| {
            let [r, _, p, _] = self.motions(i, phase);
            r + p
        };
        let velocity = |i| {
            let [_, r_dot, _, p_dot] = self.motions(i, phase);
            r_dot + p_dot
        };
        self.chain.across_bonds(self.chain.precompression(), position, overlaps);
        self.chain.across_bonds(R::zero(), velocity, rates);
        self.chain.dead_band((0..self.chain.sites()).map(position))
    }
}

impl<R: Real> PathFlow<R> for LinearFlow<R> {
    fn averaged_kick_drift(&mut self, window: (R, R), drift: Twofold<R>) {
        let mut bonds = std::mem::replace(&mut self.bonds, Bonds::new());
        if self.solve(&mut bonds, window) {
            self.push(&bonds.moments);
        }
        self.bonds = bonds;
        self.drift(drift);
    }
}

/// The moments of `f = (g)_+^alpha` over the window; negative where it runs backwards.
fn over_window<R: Real>(law: &ContactLaw<R>, path: &LinearPath<R>, window: (R, R), roots: &mut Vec<R>) -> Moments<R> {
    let (start, end) = (window.0.min(window.1), window.0.max(window.1));
    let (lo, hi) = path.bounds(start, end);
    if hi <= R::zero() {
        return [R::zero(); 4];
    }
    roots.clear();
    if lo <= R::zero() {
        path.roots(start, end, roots);
    }
    // The nearest zero of the path then lies so far outside the window that one Gauss rule
    // suffices.
    let smooth = lo * R::of(1.2) > hi;
    let (mut sum, mut from) = ([R::zero(); 4], (start, false));
    for to in roots.iter().map(|&t| (t, true)).chain([(end, false)]) {
        if path.at(R::of(0.5) * (from.0 + to.0)) > R::zero() {
            sum = add(sum, part(law, path, from, to, smooth));
        }
        from = to;
    }
    if window.0 <= window.1 { sum } else { sum.map(|moment| -moment) }
}

/// The moments over a part in which `g > 0`. `from` and `to` are times, each with whether it is a
/// zero of `g`.
fn part<R: Real>(
    law: &ContactLaw<R>,
    path: &LinearPath<R>,
    from: (R, bool),
    to: (R, bool),
    smooth: bool,
) -> Moments<R> {
    let middle = (R::of(0.5) * (from.0 + to.0), false);
    match (from.1, to.1) {
        (true, true) => add(part(law, path, from, middle, false), part(law, path, middle, to, false)),
        (false, true) => Part::new(law, path, to.0, from.0, true).moments(false).map(|moment| -moment),
        (zero, false) => Part::new(law, path, from.0, to.0, zero).moments(smooth),
    }
}

/// The integrand over a part, as a function of `s` in `[0, 1]` with `t = start + length s^q`.
///
/// If `g` is zero at the start, `f` goes like `s^(q alpha)`, which is smooth if `q alpha` is an
/// integer.
struct Part<'a, R> {
    law: &'a ContactLaw<R>,
    path: &'a LinearPath<R>,
    start: R,
    length: R,
    q: i32,
}

impl<'a, R: Real> Part<'a, R> {
    fn new(law: &'a ContactLaw<R>, path: &'a LinearPath<R>, start: R, end: R, zero: bool) -> Self {
        Self {
            law,
            path,
            start,
            length: end - start,
            q: if zero { power(law.alpha().f64(), gauss::ORDER) as i32 } else { 1 },
        }
    }

    /// `f dt/ds (1, t, cos(omega t), sin(omega t))`.
    fn at(&self, s: R) -> Moments<R> {
        let lower = s.powi(self.q - 1);
        let (LinearPath { a, b, c, d, omega }, t) = (*self.path, self.start + self.length * lower * s);
        let (sin, cos) = (omega * t).sin_cos();
        let g = (a + b * t) + (c * cos + d * sin);
        let f = self.law.force(g) * (self.length * R::of(f64::from(self.q)) * lower);
        [f, f * t, f * cos, f * sin]
    }

    /// The moments over the part; checked and refined unless the integrand is known to be smooth.
    fn moments(&self, smooth: bool) -> Moments<R> {
        let (zero, one) = (R::zero(), R::one());
        let whole = gauss(|s| self.at(s), zero, one);
        if smooth {
            return whole;
        }
        // Refinement reduces the error only down to the effect of rounding errors of the overlaps.
        let path = self.path;
        let size = path.a.abs() + path.c.abs() + path.d.abs() + (path.b * self.length).abs();
        let largest = path.at(self.start).max(path.at(self.start + self.length));
        let noise = self.law.stiffness(largest) * self.length.abs() * size;
        let tolerance = R::of(4.0 * f64::EPSILON) * (whole[0].abs() + noise);
        let mut left = HALVINGS;
        self.halved((zero, one), whole, tolerance, &mut left)
    }

    /// The moments over an interval of `s` for which one Gauss rule gives `whole`. The interval is
    /// halved until the rule agrees with the sum over its halves; `left` is the number of halvings
    /// that remain.
    fn halved(&self, (a, b): (R, R), whole: Moments<R>, tolerance: R, left: &mut u32) -> Moments<R> {
        let middle = R::of(0.5) * (a + b);
        let (lower, upper) = (gauss(|s| self.at(s), a, middle), gauss(|s| self.at(s), middle, b));
        let sum = add(lower, upper);
        if *left == 0 || (sum[0] - whole[0]).abs() <= tolerance {
            return sum;
        }
        *left -= 1;
        add(self.halved((a, middle), lower, tolerance, left), self.halved((middle, b), upper, tolerance, left))
    }
}

/// Largest number of halvings of a part; the half next to a zero comes first. For a zero just
/// outside, 24 halvings lead so near to it that the force on the rest is below rounding
/// (`curved_contacts_are_integrated_to_rounding`). It bounds the number and not the depth: where
/// only rounding errors keep halves from agreeing, each half would be halved again.
const HALVINGS: u32 = 32;

fn add<R: Real>(x: Moments<R>, y: Moments<R>) -> Moments<R> {
    std::array::from_fn(|k| x[k] + y[k])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moments(alpha: f64, path: LinearPath<f64>, window: (f64, f64)) -> Moments<f64> {
        over_window(&ContactLaw::new(alpha), &path, window, &mut Vec::new())
    }

    /// `int_0^tau (w t)^alpha t^k dt`.
    fn power_law(alpha: f64, w: f64, tau: f64, k: f64) -> f64 {
        w.powf(alpha) * tau.powf(alpha + k + 1.0) / (alpha + k + 1.0)
    }

    #[test]
    fn a_straight_contact_has_the_moments_of_a_power() {
        // Truth: closed forms, for contacts that begin in the window, end in it, or began just
        // before it.
        let (w, h) = (1.3, 1e-2);
        for (alpha, bound) in [(1.5, 2e-14), (2.5, 2e-14), (1.0, 2e-14), (1.2, 2e-14), (1.45, 1e-12), (0.7, 1e-12)] {
            for onset in [-1e-3, -1e-7, -1e-12, 0.0, 1e-3, 5e-3, 9.9e-3] {
                let path = LinearPath { a: -w * onset, b: w, c: 0.0, d: 0.0, omega: 0.0 };
                let want = power_law(alpha, w, h - onset, 0.0) - power_law(alpha, w, f64::max(-onset, 0.0), 0.0);
                let got = moments(alpha, path, (0.0, h));
                assert!((got[0] / want - 1.0).abs() < bound, "{alpha} {onset}: {:e}", got[0] / want - 1.0);
                assert_eq!(got[0], got[2]);
                // Backwards it is its negative; mirrored, a release.
                assert_eq!(moments(alpha, path, (h, 0.0)), got.map(|moment| -moment));
                let mirrored = moments(alpha, LinearPath { b: -w, ..path }, (-h, 0.0));
                assert!((mirrored[0] / want - 1.0).abs() < bound && mirrored[1] < 0.0);
            }
            let got = moments(alpha, LinearPath { a: 0.0, b: w, c: 0.0, d: 0.0, omega: 0.0 }, (-h, h));
            assert!((got[1] / power_law(alpha, w, h, 1.0) - 1.0).abs() < bound, "{alpha}: {:e}", got[1]);
        }
    }

    /// `int_a^b f dt` by the double exponential rule, which singular ends do not harm.
    fn double_exponential(f: impl Fn(f64) -> Moments<f64>, a: f64, b: f64) -> Moments<f64> {
        (-200..=200).fold([0.0; 4], |sum, k| {
            let s = std::f64::consts::FRAC_PI_2 * (f64::from(k) / 50.0).sinh();
            let weight =
                (b - a) * std::f64::consts::FRAC_PI_2 * (f64::from(k) / 50.0).cosh() / s.cosh().powi(2) / 100.0;
            add(sum, f(a + (b - a) / (1.0 + (-2.0 * s).exp())).map(|value| weight * value))
        })
    }

    #[test]
    fn curved_contacts_are_integrated_to_rounding() {
        // Truth: another rule between the zeros. Short contacts, long ones, two in a window, and
        // ones that nearly open.
        let (start, end, omega) = (-0.4, 0.6, 2.0);
        for alpha in [1.5, 1.2, 1.45, 2.5] {
            let law = ContactLaw::new(alpha);
            for (a, b, c, d) in [
                (-0.95, 0.02, 1.0, 0.3),
                (-1.02, 0.4, 1.0, 0.0),
                (-0.9999, 0.0, 1.0, 0.0),
                (1.0001, 0.0, -1.0, 0.0),
                (0.9999, 0.0, -1.0, 0.0),
                (1.0, 0.1, -1.0, 0.1),
                (2.0, 0.3, 1.0, 0.1),
            ] {
                let path = LinearPath { a, b, c, d, omega };
                let f = |t: f64| {
                    let (f, (sin, cos)) = (law.force(path.at(t)), (omega * t).sin_cos());
                    [f, f * t, f * cos, f * sin]
                };
                let mut ends = vec![start];
                path.roots(start, end, &mut ends);
                ends.push(0.0);
                ends.push(end);
                ends.sort_by(f64::total_cmp);
                let want =
                    ends.windows(2).fold([0.0; 4], |sum, part| add(sum, double_exponential(f, part[0], part[1])));
                // Overlaps are rounded to 2e-16, which is more of a small one.
                let largest = (0..=1000).map(|i| path.at(start + f64::from(i) / 1000.0)).fold(0.0, f64::max);
                let bound = (1e-13 + 1e-15 / largest) * want[0];
                for (got, want) in moments(alpha, path, (start, end)).iter().zip(want) {
                    assert!((got - want).abs() < bound, "{alpha} {a}: {got:e} {want:e} {:e}", got / want - 1.0);
                }
            }
        }
    }

    #[test]
    fn what_does_not_touch_has_no_moments() {
        let path = LinearPath { a: -1.0, b: 0.0, c: 0.99, d: 0.0, omega: 1.0 };
        assert_eq!(moments(1.5, path, (-1.0, 1.0)), [0.0; 4]);
        assert_eq!(moments(1.5, LinearPath { a: 0.0, c: 0.0, ..path }, (-1.0, 1.0)), [0.0; 4]);
    }
}
