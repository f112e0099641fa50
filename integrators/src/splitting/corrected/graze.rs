//! Contacts and gaps of a few steps, seen by the kicks or not.
//!
//! | symbol | meaning |
//! |---|---|
//! | `t0, b, a` | a turning point of the overlap: its time, the overlap there, its second derivative |
//! | `s` | acceleration of the overlap by the forces of the kick |
//! | `F` | force of a kick: `f(g) + (h^2/12) s f'(g)` at the kernel's overlap `g` |
//!
//! The two terms of `W` for an event are the beginning of a series in `a h/c`, the curvature of the
//! path over a step against its speed. Where the overlap turns within a few steps of its zero they
//! do not suffice, and a contact or a gap between two kicks has no event at all. There the overlap
//! is a parabola,
//!
//! ```text
//! g(t) = b + a (t - t0)^2/2,
//! ```
//!
//! but for `O(h)` of it, and the error of the quadrature is known without a series. For a short
//! contact (`a < 0`) it is the sum over its few kicks minus
//!
//! ```text
//! int (b - |a| t^2/2)_+^alpha dt = b^{alpha+1/2} (2/|a|)^{1/2} B(1/2, alpha + 1);
//! ```
//!
//! for a gap, or an overlap that nearly opens (`a > 0`), it is the same over some kicks on either
//! side, minus the terms of Euler and Maclaurin at the last of these. Impulse and displacement are
//! the error of the force and that of its first moment: again the two derivatives of one function
//! of overlap and rate, `h sum V(g_k) + .. - int V dt`. The bond gets them minus those of its onset
//! and release, which it gets at these events if the kicks see them.
//!
//! The error of a grazing event that remains is of order `a^alpha h^{2 alpha + 2}`. The parabola
//! leaves the bond's own force out: a share `(a h^2)^alpha/a` of its acceleration.

use super::{
    bonds::{BondView, Correction},
    event::Corrector,
    path::{BondPath, Jet},
    zeta::chebyshev,
};
use crate::collocation::Rule;

/// Largest overlap, in absolute value and in units of `abs(a) h^2`, of a turning point that is
/// corrected: farther ones leave less than the terms that `W` neglects.
pub(super) const REACH: f64 = 3.0;
/// Number of kicks that count on either side of the middle one: as many as a contact within reach
/// has. Beyond them the terms of Euler and Maclaurin are good to 1e-5.
const KICKS: i32 = 5;
/// Largest `omega h`: up to here a bond's path is close to a parabola over the `(2 REACH)^{1/2}`
/// steps to either side of a contact within reach. Beyond, most overlaps turn within reach.
const TURN: f64 = 0.6;
/// Number of Gauss nodes of an integral.
const NODES: usize = 12;
/// Number of Chebyshev coefficients of a table.
const TERMS: usize = 16;
/// Largest `xi` of a table, a little above `(2 REACH)^{1/2}/(KICKS - 1)`: a turning point lies
/// within a step of the kick in the middle, hence at least `KICKS - 1` steps from the last ones.
const MOST: f64 = 0.62;

/// An overlap that has turned near zero: the view of its bond from the kick after, and whether the
/// bond was closed at the kick nearest to the turning point.
#[derive(Clone, Copy, Debug)]
pub struct Extremum {
    /// The bond, seen from the kick after the one next to the turning point.
    pub view: BondView,
    /// Whether it is closed at the kick next to the turning point.
    pub closed: bool,
}

/// The correction of a turning point.
#[derive(Clone, Copy, Debug)]
pub struct Graze {
    pub correction: Correction,
    /// A contact between two kicks: half its duration, its largest overlap, and its impulse.
    pub(super) hidden: Option<[f64; 3]>,
}

/// Corrections at turning points, for one exponent.
#[derive(Clone, Debug)]
pub struct Extrema {
    alpha: f64,
    /// `B(1/2, alpha + 1)`.
    bump: f64,
    /// `Phi(-xi^2)` and `Phi(xi^2)` over `xi` in `[0, MOST]` as series of Chebyshev polynomials,
    /// `Phi(x) = int_0^1 (s^2 + x)_+^alpha ds`.
    gap: [[f64; TERMS]; 2],
}

/// A parabola and the kicks on it.
struct Parabola<'a> {
    turns: &'a Extrema,
    h: f64,
    t0: f64,
    b: f64,
    a: f64,
    /// `(h^2/12) s`.
    shift: f64,
}

impl Extrema {
    /// For forces with the exponent `alpha`.
    pub fn new(alpha: f64) -> Self {
        let gap = chebyshev(|x| [-1.0, 1.0].map(|sign| gap_integral(alpha, sign * (0.5 * MOST * (x + 1.0)).powi(2))));
        // y = 1 - w^4, in which the force is smooth.
        let bump = integral(0.0, 1.0, |w: f64| (w.powi(4) * (2.0 - w.powi(4))).powf(alpha) * 4.0 * w.powi(3));
        Self { alpha, bump: 2.0 * bump, gap }
    }

    /// The correction at a turning point, in addition to those at its events; `None` where the
    /// overlap does not turn near zero, or springs are too fast for a parabola.
    pub fn correction(&self, turn: &Extremum, corrector: &Corrector) -> Option<Graze> {
        let (h, path) = (corrector.step(), &turn.view.path);
        if path.omega * h > TURN {
            return None;
        }
        let (t0, Jet { value: b, acceleration: a, .. }) = turning_point(path, -h)?;
        if (t0 + h).abs() > h || b.abs() > REACH * h * h * a.abs() {
            return None;
        }
        let parabola = Parabola { turns: self, h, t0, b, a, shift: h * h / 12.0 * turn.view.pull[0] };
        let [error, mut displacement] = if a < 0.0 { parabola.contact() } else { parabola.gap() };
        let mut impulse = -error;
        // The kicks see a contact if the bond is closed at the middle one, a gap if it is open
        // there.
        let seen = turn.closed == (a < 0.0);
        if seen {
            for (at, given) in parabola.events(corrector) {
                impulse -= given[0];
                displacement -= given[1] - given[0] * (at - t0);
            }
        }
        let hidden = (a < 0.0 && b > 0.0 && !seen).then(|| [(-2.0 * b / a).sqrt(), b, impulse]);
        let correction = Correction { impulse, displacement, at: t0, rate: 0.0, turn: path.turn(t0) };
        (impulse.is_finite() && displacement.is_finite()).then_some(Graze { correction, hidden })
    }

    /// `int_0^t (b + a s^2/2)_+^alpha ds` for `a > 0`.
    fn gap_integral(&self, b: f64, a: f64, t: f64) -> f64 {
        let x = 2.0 * b / (a * t * t);
        let at = 2.0 / MOST * x.abs().sqrt() - 1.0;
        let series = &self.gap[usize::from(x > 0.0)];
        let (mut next, mut sum) = (0.0, 0.0);
        for coefficient in series[1..].iter().rev() {
            (sum, next) = (2.0 * at * sum - next + coefficient, sum);
        }
        t * force(self.alpha, 0.5 * a * t * t) * (at * sum - next + series[0])
    }
}

/// `f` at an overlap.
fn force(alpha: f64, g: f64) -> f64 {
    if alpha == 1.5 { g * g.sqrt() } else { g.powf(alpha) }
}

/// Where the rate of a path is zero, near `t`, by Newton's method.
fn turning_point(path: &BondPath, t: f64) -> Option<(f64, Jet)> {
    let next = |t: f64| {
        let jet = path.at(t);
        t - jet.rate / jet.acceleration
    };
    let t = next(next(next(t)));
    t.is_finite().then(|| (t, path.at(t)))
}

impl Parabola<'_> {
    /// Numbers of the kicks that count, and their times since the turning point. Kick 0 is now,
    /// kick -1 the middle one.
    fn kicks(&self) -> impl Iterator<Item = (i32, f64)> {
        let Self { h, t0, .. } = *self;
        (-1 - KICKS..=KICKS - 1).map(move |k| (k, f64::from(k) * h - t0))
    }

    /// The overlap of the kernel's state, `t` after the turning point.
    fn overlap(&self, t: f64) -> f64 {
        self.b + 0.5 * self.a * t * t - self.shift
    }

    /// The force `F` of a kick.
    fn worth(&self, t: f64) -> f64 {
        let (g, turns) = (self.overlap(t), self.turns);
        if g <= 0.0 {
            return 0.0;
        }
        let force = force(turns.alpha, g);
        force + self.shift * turns.alpha * (force / g)
    }

    /// `h sum F - int f` and the same of the first moments about the turning point, of a contact.
    fn contact(&self) -> [f64; 2] {
        let Self { turns, h, b, a, .. } = *self;
        let [sum, moment] = self.kicks().fold([0.0; 2], |[sum, moment], (_, t)| {
            let worth = h * self.worth(t);
            [sum + worth, moment + worth * t]
        });
        let integral = if b > 0.0 { force(turns.alpha, b) * (-2.0 * b / a).sqrt() * turns.bump } else { 0.0 };
        [sum - integral, moment]
    }

    /// The same of a gap, or of an overlap that nearly opens: the finite part of sums that continue
    /// beyond these kicks.
    fn gap(&self) -> [f64; 2] {
        let Self { turns, h, b, a, .. } = *self;
        let [mut error, mut moment] = [0.0; 2];
        for (k, t) in self.kicks() {
            let last = k == -1 - KICKS || k == KICKS - 1;
            let worth = h * self.worth(t) * if last { 0.5 } else { 1.0 };
            error += worth;
            moment += worth * t;
            if last {
                let outward = t.signum();
                let integral = turns.gap_integral(b, a, t.abs());
                let g = (b + 0.5 * a * t * t).max(0.0);
                let potential = g * force(turns.alpha, g) / ((turns.alpha + 1.0) * a);
                let [f, f1, f2, f3] = self.derivatives(t);
                let (first, third) = (h * h / 12.0, h.powi(4) / 720.0);
                error -= integral + outward * (first * f1 - third * f3);
                moment -= outward * (potential + first * (f + t * f1) - third * (3.0 * f2 + t * f3));
            }
        }
        [error, moment]
    }

    /// The force of a kick as a function of time, and its first three derivatives; for the last
    /// kicks, where `f` is smooth.
    fn derivatives(&self, t: f64) -> [f64; 4] {
        let Self { turns, a, shift, .. } = *self;
        let (g, g1, alpha) = (self.overlap(t), a * t, turns.alpha);
        // The derivatives of f by g, then of f + shift f'.
        let d0 = force(turns.alpha, g);
        let d1 = alpha * d0 / g;
        let d2 = (alpha - 1.0) * d1 / g;
        let d3 = (alpha - 2.0) * d2 / g;
        let d4 = (alpha - 3.0) * d3 / g;
        let [d0, d1, d2, d3] = [d0 + shift * d1, d1 + shift * d2, d2 + shift * d3, d3 + shift * d4];
        [d0, d1 * g1, d2 * g1 * g1 + d1 * a, d3 * g1 * g1 * g1 + 3.0 * d2 * g1 * a]
    }

    /// The corrections that onset and release get on this parabola: their times relative to now,
    /// impulses and displacements.
    fn events(&self, corrector: &Corrector) -> impl Iterator<Item = (f64, [f64; 2])> {
        let Self { h, t0, b, a, .. } = *self;
        let half = (-2.0 * b / a).max(0.0).sqrt();
        let contact = a < 0.0;
        // Kicks of the contact, or of the gap, by the kernel's overlaps.
        let inside = |&(k, t): &(i32, f64)| k == -1 || (self.overlap(t) > 0.0) == contact;
        let (first, last) =
            self.kicks().filter(inside).fold((-1, -1), |(first, last), (k, _)| (k.min(first), k.max(last)));
        let one = move |side: f64, onset: bool, kick: i32| {
            // Seen from the kick after the event.
            let (at, now) = (side * half, f64::from(kick) * h - t0);
            let path = BondPath {
                overlap: b + 0.5 * a * now * now,
                rate: a * now,
                acceleration: [a, 0.0],
                jerk: [0.0; 2],
                omega: 0.0,
            };
            let pull = [self.shift * 12.0 / (h * h); 2];
            let given = corrector.given(&BondView { path, mobility: 0.0, pull }, (at - now, a * at, a), onset);
            (t0 + at, given)
        };
        [one(-1.0, contact, first), one(1.0, !contact, last + 1)].into_iter().filter(move |_| half > 0.0)
    }
}

/// `int_0^1 (s^2 + x)_+^alpha ds`.
fn gap_integral(alpha: f64, x: f64) -> f64 {
    // s = from + z.
    let from = (-x).max(0.0).sqrt();
    let f = |z: f64| force(alpha, x.max(0.0) + z * (z + 2.0 * from));
    // The integrand is singular at z = 0, and nearly so at a distance of this size: panels grow
    // from there.
    let near = x.abs().sqrt().max(1e-3).min(1.0 - from);
    let mut sum = integral(0.0, 1.0, |w: f64| f(near * w.powi(4)) * near * 4.0 * w.powi(3));
    let mut low = near;
    while low < 1.0 - from {
        let high = (2.0 * low).min(1.0 - from);
        sum += integral(low, high, f);
        low = high;
    }
    sum
}

/// `int_low^high f`, by the rule of Gauss and Legendre.
fn integral(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let rule = Rule::<NODES>::shared();
    rule.nodes.iter().zip(&rule.weights).map(|(x, weight)| half * weight * f(middle + half * x)).sum()
}
