//! A panel: a part of one contact on which the force is smooth in the panel's own variable.
//!
//! | symbol | meaning |
//! |---|---|
//! | `t` | time since the start of the window |
//! | `sigma` | `|t - t_o|^{1/q}`, with an origin `t_o` at or beyond an end of the panel |
//! | `x` | `sigma` scaled to `[-1, 1]`, ascending in time |
//! | `A + B t + C cos(omega t) + D sin(omega t)` | path: the displacement after a force has ended |

use super::{
    chain::Path,
    flow::Flow,
    goal::Cuts,
    kernels::apart,
    link::{Link, Links},
    rule::Rule,
    series::{dot, product, sin_cos, times, value},
};
use crate::{events::Curve, kernel};

/// The shortest chord for a slope, as a share of the panel's length: rounding spoils the slope of a
/// shorter one, curvature that of a longer one. Chosen; `methods
/// short_contacts_are_found_in_few_sweeps` counts the sweeps that it takes.
const CHORD: f64 = 1e-3;
/// Ratio of the smallest to the largest overlap on a panel below which the force counts as nearly
/// going out. Chosen; held by `methods contacts_that_nearly_open_or_do_for_a_moment`.
const FADING: f64 = 0.15;

/// The parameters of a window, for all bonds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frames<'a, const M: usize, const S: usize> {
    pub(crate) rule: &'a Rule<M>,
    pub(crate) links: &'a Links<S>,
    pub(crate) cuts: &'a Cuts,
    /// Length of the window.
    pub(crate) h: f64,
}

/// The parameters of a window, for one bond.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame<'a, const M: usize, const S: usize> {
    pub(crate) rule: &'a Rule<M>,
    pub(crate) link: &'a Link<S>,
    pub(crate) cuts: &'a Cuts,
    /// Length of the window.
    pub(crate) h: f64,
}

impl<'a, const M: usize, const S: usize> Frames<'a, M, S> {
    /// For bond `b` of the chain.
    #[inline(always)]
    pub(crate) fn of(&self, b: usize) -> Frame<'a, M, S> {
        let Self { rule, links, cuts, h } = *self;
        Frame { rule, link: links.link(b), cuts, h }
    }
}

/// Where a panel's variable has its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Origin {
    /// Nowhere: the variable is time.
    None,
    /// At an onset at or before the start.
    Before(f64),
    /// At a release at or after the end.
    After(f64),
}

impl Origin {
    /// The time between `from` and `to` that is `share` of the way in the panel's variable.
    pub(crate) fn between(self, q: u32, from: f64, to: f64, share: f64) -> f64 {
        let (o, sign) = match self {
            Self::None => return from + share * (to - from),
            Self::Before(o) => (o, 1.0),
            Self::After(o) => (o, -1.0),
        };
        let [a, b] = root([sign * (from - o), sign * (to - o)], q);
        o + sign * (a + share * (b - a)).powi(q as i32)
    }
}

/// The nodes of a panel, its kernels, and the overlaps and forces at the nodes. Times count from
/// the start of the window.
#[derive(Clone, Debug)]
pub(crate) struct Panel<const M: usize, const S: usize> {
    pub(crate) start: f64,
    pub(crate) end: f64,
    /// `t = origin + sign sigma^q`.
    origin: f64,
    sign: f64,
    q: u32,
    /// `sigma = middle + half x`.
    middle: f64,
    half: f64,
    per_half: f64,
    /// Times of the nodes; and for each side of the bond `lag`, `cos` and `sin` at these times: 0,
    /// `cos(omega t)` and `sin(omega t)`, or the functions of [`Flow`](super::flow::Flow) where the
    /// site is damped.
    pub(crate) tau: [f64; M],
    pub(crate) lag: [[f64; M]; S],
    /// Whether `lag` was ever set for a damped site, and must be cleared for another one.
    lags: bool,
    pub(crate) cos: [[f64; M]; S],
    pub(crate) sin: [[f64; M]; S],
    /// `dt/dx` at the nodes.
    pub(crate) rate: [f64; M],
    /// `reaction[side][k][j]`: displacement at node `j` by a unit force at node `k`, on each side.
    pub(super) reaction: [[[f64; M]; M]; S],
    /// The paths by a unit force at each node, after the panel.
    pub(crate) left: [[Path; S]; M],
    /// The part of the overlap at the nodes that drives prescribe.
    pub(crate) known: [f64; M],
    /// Overlap at the nodes.
    pub(crate) overlap: [f64; M],
    /// Force at the nodes.
    pub(crate) force: [f64; M],
    /// Displacement by the force of this panel at its own nodes: `int K(t - s) f(s) ds` from its
    /// start.
    pub(crate) local: [[f64; M]; S],
    /// [`local`](Self::local) as a series in `x`, see [`Rule::series`].
    pub(crate) series: [[f64; M]; S],
    /// The paths by all earlier panels of the bond in this window.
    pub(crate) before: [Path; S],
    /// Where the nodes lie among the panels of the two neighbours.
    pub(crate) views: [View<M>; 2],
    /// Rates of the overlap, where the contact of the bond or of a neighbour dissipates.
    pub(crate) rates: Option<Box<Rates<M, S>>>,
}

/// Rates of overlaps at the nodes of a panel, where the bond or one beside it dissipates.
#[derive(Clone, Debug)]
pub(crate) struct Rates<const M: usize, const S: usize> {
    /// The factors of `v`, `c` and `s` of a path in the velocity of the site, on each side.
    pub(super) velocity: [[[f64; M]; 3]; S],
    /// The part of the rate of the overlap that drives prescribe.
    pub(super) known: [f64; M],
    /// `reaction[side][k][j]`: the velocity at node `j` by a unit force at node `k`.
    pub(super) reaction: [[[f64; M]; M]; S],
    /// The velocities by the force of the panel, as series in `x`.
    pub(super) series: [[f64; M]; S],
    /// The rate `g'` of the overlap.
    pub(crate) overlap: [f64; M],
    /// The dissipative part `f - F` of the force.
    pub(crate) lost: [f64; M],
}

impl<const M: usize, const S: usize> Rates<M, S> {
    pub(super) fn new() -> Self {
        let zeros = [0.0; M];
        Self {
            velocity: [[zeros; 3]; S],
            known: zeros,
            reaction: [[zeros; M]; S],
            series: [zeros; S],
            overlap: zeros,
            lost: zeros,
        }
    }

    /// The velocity along a path of one side at a node.
    #[inline(always)]
    pub(super) fn along_side(&self, path: &Path, side: usize, j: usize) -> f64 {
        let velocity = &self.velocity[side];
        path[1] * velocity[0][j] + (path[2] * velocity[1][j] + path[3] * velocity[2][j])
    }

    /// The rate of the overlap without contact forces.
    pub(super) fn along(&self, path: &[Path; S]) -> [f64; M] {
        let mut rate = self.known;
        for side in 0..S {
            for j in 0..M {
                rate[j] += self.along_side(&path[side], side, j);
            }
        }
        rate
    }
}

/// Where the nodes of a panel lie among the panels of a neighbour. This changes only when panels
/// are laid out anew, not from sweep to sweep.
///
/// A node inside panel `k` of the neighbour has the place `2 k`, one after it and before the next
/// panel `2 k + 1`, one before all panels -1. Places ascend with the nodes.
#[derive(Clone, Debug)]
pub(crate) struct View<const M: usize> {
    /// Version of the neighbour's panels that this view was made for; zero for none.
    pub(crate) version: u64,
    /// Places of the first and of the last node.
    pub(crate) span: (i32, i32),
    /// Place of each node; set only if the nodes differ in it.
    pub(crate) place: [f64; M],
    /// For each node inside a panel of the neighbour, its value of that panel's variable `x`.
    pub(crate) x: [f64; M],
}

/// Ascending times, with `lag`, `cos` and `sin` at them for each side, see [`Panel::tau`].
#[derive(Clone, Copy)]
pub(crate) struct Times<'a, const L: usize, const S: usize> {
    pub(crate) tau: &'a [f64; L],
    pub(crate) lag: &'a [[f64; L]; S],
    pub(crate) cos: &'a [[f64; L]; S],
    pub(crate) sin: &'a [[f64; L]; S],
}

impl<const L: usize, const S: usize> Times<'_, L, S> {
    /// The sum of the paths of all sides at time `j`, without [`lagging`](Self::lagging).
    #[inline(always)]
    pub(crate) fn along(&self, path: &[Path; S], j: usize) -> f64 {
        let ([mut r, mut v, ..], mut swing) = (path[0], self.swing(&path[0], 0, j));
        for side in 1..S {
            r += path[side][0];
            v += path[side][1];
            swing += self.swing(&path[side], side, j);
        }
        (r + v * self.tau[j]) + swing
    }

    /// The part `v lag(t)` of the paths of all sides, which drag causes, at time `j`.
    #[inline(always)]
    pub(crate) fn lagging(&self, path: &[Path; S], j: usize) -> f64 {
        (1..S).fold(path[0][1] * self.lag[0][j], |sum, side| sum + path[side][1] * self.lag[side][j])
    }

    /// The path of one side at time `j`.
    #[inline(always)]
    pub(crate) fn along_side(&self, path: &Path, side: usize, j: usize) -> f64 {
        let free = (path[0] + path[1] * self.tau[j]) + self.swing(path, side, j);
        if S == 1 { free } else { free + path[1] * self.lag[side][j] }
    }

    #[inline(always)]
    fn swing(&self, path: &Path, side: usize, j: usize) -> f64 {
        path[2] * self.cos[side][j] + path[3] * self.sin[side][j]
    }
}

/// `distance^{1/q}`.
#[inline(always)]
fn root<const L: usize>(distance: [f64; L], q: u32) -> [f64; L] {
    match q {
        1 => distance,
        2 => {
            let mut out = distance;
            for j in 0..L {
                out[j] = out[j].sqrt();
            }
            out
        }
        _ => any_root(distance, q),
    }
}

#[inline(never)]
fn any_root<const L: usize>(distance: [f64; L], q: u32) -> [f64; L] {
    if q == 4 { distance.map(|d| d.sqrt().sqrt()) } else { distance.map(|d| d.powf(1.0 / f64::from(q))) }
}

impl<const M: usize, const S: usize> Panel<M, S> {
    pub(crate) fn new() -> Self {
        let zeros = [0.0; M];
        Self {
            start: 0.0,
            end: 0.0,
            origin: 0.0,
            sign: 1.0,
            q: 1,
            middle: 0.0,
            half: 0.0,
            per_half: 0.0,
            tau: zeros,
            lag: [zeros; S],
            lags: false,
            cos: [zeros; S],
            sin: [zeros; S],
            rate: zeros,
            reaction: [[zeros; M]; S],
            left: [[[0.0; 4]; S]; M],
            known: zeros,
            overlap: zeros,
            force: zeros,
            local: [zeros; S],
            series: [zeros; S],
            before: [[0.0; 4]; S],
            views: std::array::from_fn(|_| View { version: 0, span: (-1, -1), place: zeros, x: zeros }),
            rates: None,
        }
    }

    /// Makes this the panel over `[start, end]`, of a variable with this origin and power. Its
    /// nodes are placed later, by [`place`](Self::place).
    pub(crate) fn span(&mut self, start: f64, end: f64, origin: Origin, q: u32) {
        (self.start, self.end) = (start, end);
        (self.origin, self.sign, self.q) = match origin {
            Origin::None => (start, 1.0, 1),
            Origin::Before(o) => (o, 1.0, q),
            Origin::After(o) => (o, -1.0, q),
        };
        for view in &mut self.views {
            view.version = 0;
        }
    }

    /// Whether the variable of the panel is not the time itself.
    pub(crate) fn singular(&self) -> bool {
        self.q > 1
    }

    /// Origin, sign and power of its variable.
    pub(crate) fn map(&self) -> (f64, f64, u32) {
        (self.origin, self.sign, self.q)
    }

    /// `sigma` at the start and at the end.
    pub(crate) fn sigmas(&self) -> [f64; 2] {
        [self.middle - self.half, self.middle + self.half]
    }

    /// Distance in time from the origin of the panel's variable; infinite if the variable is time.
    pub(crate) fn far(&self, t: f64) -> f64 {
        if self.singular() { (t - self.origin).abs() } else { f64::INFINITY }
    }

    /// The times of the nodes.
    #[inline(always)]
    pub(crate) fn times(&self) -> Times<'_, M, S> {
        Times { tau: &self.tau, lag: &self.lag, cos: &self.cos, sin: &self.sin }
    }

    /// Adds to overlaps at the nodes the parts that [`Times::along`] lacks: that of drag, and, if
    /// `known`, that of drives. Not inlined, and by value, so that bonds without these parts keep
    /// their overlaps in registers.
    #[inline(never)]
    pub(super) fn besides(&self, known: bool, path: [Path; S], mut overlap: [f64; M]) -> [f64; M] {
        for j in 0..M {
            overlap[j] += self.times().lagging(&path, j);
        }
        if known {
            for j in 0..M {
                overlap[j] += self.known[j];
            }
        }
        overlap
    }

    /// Places the nodes, and computes the kernels between them.
    #[inline(always)]
    pub(super) fn place(&mut self, frame: &Frame<'_, M, S>) {
        let Self { start, end, origin, sign, q, .. } = *self;
        let [from, to] = root([sign * (start - origin), sign * (end - origin)], q);
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        (self.middle, self.half, self.per_half) = (middle, half, 1.0 / half);
        let mut sigma = [0.0; M];
        for j in 0..M {
            sigma[j] = middle + half * frame.rule.nodes[j];
        }
        let scale = sign * half * f64::from(q);
        self.rate = [scale; M];
        let mut tau = sigma;
        for _ in 1..q {
            for j in 0..M {
                tau[j] *= sigma[j];
                self.rate[j] *= sigma[j];
            }
        }
        for j in 0..M {
            self.tau[j] = origin + sign * tau[j];
        }
        if frame.link.wholly_damped() {
            return self.place_damped(frame);
        }
        for side in 0..S {
            let omega = frame.link.sides[side].omega;
            if S != 1 && self.lags {
                self.lag[side] = [0.0; M];
            }
            if omega != 0.0 {
                for j in 0..M {
                    let (sin, cos) = sin_cos(omega * self.tau[j]);
                    self.sin[side][j] = sin;
                    self.cos[side][j] = cos;
                }
            }
        }
        for side in 0..S {
            self.weigh(frame, side);
        }
        if frame.link.damped() {
            self.place_damped(frame);
        }
    }

    /// Makes [`reaction`](Self::reaction) and [`left`](Self::left): `K(t - s)` at the nodes, times
    /// the weights of the integrals over `s`.
    #[inline(always)]
    fn weigh(&mut self, frame: &Frame<'_, M, S>, side: usize) {
        let Self { tau, rate, left, .. } = self;
        let (cos, sin, reaction) = (&self.cos[side], &self.sin[side], &mut self.reaction[side]);
        let rule = frame.rule;
        let (m, mu) = (frame.link.sides[side].m, frame.link.sides[side].mu_per_omega);
        for k in 0..M {
            let rate = rate[k];
            let [free, moved, c, s] = [m * rate, m * rate * tau[k], mu * rate * cos[k], mu * rate * sin[k]];
            left[k][side] = [-moved, free, -s, c].map(|part| rule.weights[k] * part);
            let mut kernel = [0.0; M];
            for j in 0..M {
                kernel[j] = free.mul_add(tau[j], -moved);
            }
            if mu != 0.0 {
                for j in 0..M {
                    kernel[j] = c.mul_add(sin[j], (-s).mul_add(cos[j], kernel[j]));
                }
            }
            reaction[k] = times(&rule.integral[k], &kernel);
        }
    }

    /// Replaces the results of [`place`](Self::place) and [`weigh`](Self::weigh) on sides whose
    /// sites are damped.
    fn place_damped(&mut self, frame: &Frame<'_, M, S>) {
        apart(kernel!(for side in 0..S {
            if let Some(flow) = frame.link.flow(side) {
                self.place_damped_side(frame.rule, flow, side);
            }
        }));
    }

    #[inline(always)]
    fn place_damped_side(&mut self, rule: &Rule<M>, flow: &Flow, side: usize) {
        let ([lag, cos, sin], answer) = flow.position_and_answer(&self.tau);
        let mut free = self.tau;
        for j in 0..M {
            free[j] += lag[j];
        }
        for k in 0..M {
            let [r, v, c, s] = answer.map(|part| self.rate[k] * part[k]);
            self.left[k][side] = [r, v, c, s].map(|part| rule.weights[k] * part);
            let mut kernel = [0.0; M];
            for j in 0..M {
                kernel[j] = s.mul_add(sin[j], c.mul_add(cos[j], v.mul_add(free[j], r)));
            }
            self.reaction[side][k] = times(&rule.integral[k], &kernel);
        }
        (self.lag[side], self.cos[side], self.sin[side], self.lags) = (lag, cos, sin, true);
    }

    /// The slope of the chord from a node to the first of `others` that is far enough from it. A
    /// chord is used because values at nodes are exact even where the interpolant between few nodes
    /// is poor.
    #[inline(always)]
    pub(crate) fn chord(&self, values: &[f64; M], node: usize, mut others: impl Iterator<Item = usize>) -> f64 {
        let least = CHORD * (self.end - self.start);
        let k = others.find(|&k| (self.tau[k] - self.tau[node]).abs() > least).unwrap_or(M / 2);
        (values[k] - values[node]) / (self.tau[k] - self.tau[node])
    }

    /// The variable `x` at times inside the panel.
    #[inline(always)]
    pub(crate) fn variable<const L: usize>(&self, t: &[f64; L]) -> [f64; L] {
        let mut distance = [0.0; L];
        for j in 0..L {
            let d = self.sign * (t[j] - self.origin);
            distance[j] = if d > 0.0 { d } else { 0.0 };
        }
        let mut x = root(distance, self.q);
        for j in 0..L {
            x[j] = (x[j] - self.middle) * self.per_half;
        }
        x
    }

    /// Displacement on a side by the force of this panel, at times inside the panel.
    #[inline(always)]
    pub(crate) fn moved<const L: usize>(&self, side: usize, t: &[f64; L]) -> [f64; L] {
        self.moved_at(side, &self.variable(t))
    }

    /// As [`moved`](Self::moved), at values of the variable `x`.
    #[inline(always)]
    pub(crate) fn moved_at<const L: usize>(&self, side: usize, x: &[f64; L]) -> [f64; L] {
        value(&self.series[side], x)
    }

    /// The force at times inside the panel, and its dissipative part `f - F`.
    #[inline(always)]
    pub(crate) fn forces_at<const L: usize>(&self, rule: &Rule<M>, t: &[f64; L]) -> [[f64; L]; 2] {
        let x = self.variable(t);
        let lost = self.lost().map_or([0.0; L], |lost| value(&product(&rule.series, lost), &x));
        [value(&product(&rule.series, &self.force), &x), lost]
    }

    /// The dissipative part `f - F` of the force at the nodes, where panels have rates.
    #[inline(always)]
    fn lost(&self) -> Option<&[f64; M]> {
        self.rates.as_ref().map(|rates| &rates.lost)
    }

    /// `int f v dt` with a smooth function `v` of the time, and the same integral of `f - F`.
    pub(crate) fn work(&self, rule: &Rule<M>, v: impl Fn(f64) -> f64) -> [f64; 2] {
        let by =
            |force: &[f64; M]| (0..M).map(|j| rule.weights[j] * self.rate[j] * force[j] * v(self.tau[j])).sum::<f64>();
        [by(&self.force), self.lost().map_or(0.0, by)]
    }

    /// `int f dt`.
    pub(crate) fn impulse(&self, rule: &Rule<M>) -> f64 {
        dot(&rule.weights, &times(&self.force, &self.rate))
    }

    /// The function on this panel that has these values at its nodes, for the log; `None` for a
    /// panel of no length.
    pub(crate) fn curve(&self, rule: &Rule<M>, values: &[f64; M]) -> Option<Curve> {
        let [start, end] = rule.ends.map(|row| dot(&row, values));
        let inner = rule.nodes.iter().zip(values).map(|(x, value)| (0.5 * (1.0 + x), *value));
        let points = std::iter::once((0.0, start)).chain(inner).chain([(1.0, end)]);
        (self.half != 0.0).then(|| Curve::new(self.map(), self.sigmas(), (self.start, self.end), points))
    }

    /// Two changes of velocity. First the last terms of the series of `f`, `f cos` and `f sin`, the
    /// impulses on the free and on the oscillating part of a site: they measure how well the nodes
    /// resolve the force and the oscillation. They are multiplied by `slow` where the overlap falls
    /// to almost nothing, or below zero, without an event at an end, since the terms then fall
    /// slowly. Second the largest value of `f dt/dx` at a node. Third half of the angle of the
    /// fastest oscillation on the panel over the number of nodes: above 1 the nodes are too few for
    /// it, and last terms say nothing.
    #[inline(always)]
    pub(crate) fn tail(&self, frame: &Frame<'_, M, S>, slow: f64) -> [f64; 3] {
        let w = times(&self.force, &self.rate);
        let (mut tail, mut fastest) = (last_terms(frame.rule, &w), 0.0f64);
        for side in 0..S {
            fastest = fastest.max(frame.link.sides[side].omega);
            if frame.link.sides[side].mu != 0.0 {
                let cos = last_terms(frame.rule, &times(&w, &self.cos[side]));
                let sin = last_terms(frame.rule, &times(&w, &self.sin[side]));
                tail = if cos > tail { cos } else { tail };
                tail = if sin > tail { sin } else { tail };
            }
        }
        let (mut least, mut most, mut largest) = (self.overlap[0], self.overlap[0], 0.0);
        for j in 0..M {
            let (g, w) = (self.overlap[j], w[j].abs());
            least = if g < least { g } else { least };
            most = if g > most { g } else { most };
            largest = if w > largest { w } else { largest };
        }
        let lightest = frame.link.lightest();
        let tail = if self.q < frame.link.q && least < FADING * most { slow * tail } else { tail };
        [tail * lightest, largest * lightest, fastest * (self.end - self.start) / (2 * M) as f64]
    }

    /// Computes the displacements by the force at the nodes: [`local`](Self::local) and
    /// [`series`](Self::series). Returns the paths after this panel, by all panels so far.
    #[inline(always)]
    pub(crate) fn integrate(&mut self, frame: &Frame<'_, M, S>) -> [Path; S] {
        let (mut even, mut odd) = (self.before, [[0.0; 4]; S]);
        for side in 0..S {
            self.local[side] = product(&self.reaction[side], &self.force);
            self.series[side] = product(&frame.rule.series, &self.local[side]);
        }
        for k in (0..M).step_by(2) {
            for side in 0..S {
                for i in 0..4 {
                    even[side][i] = self.left[k][side][i].mul_add(self.force[k], even[side][i]);
                    odd[side][i] = self.left[k + 1][side][i].mul_add(self.force[k + 1], odd[side][i]);
                }
            }
        }
        for side in 0..S {
            for i in 0..4 {
                even[side][i] += odd[side][i];
            }
        }
        if S != 1 && frame.link.rated {
            self.integrate_rates(frame.rule);
        }
        even
    }
}

/// The larger of the last two terms of a series with these values.
#[inline(always)]
fn last_terms<const M: usize>(rule: &Rule<M>, values: &[f64; M]) -> f64 {
    let (a, b) = (dot(&rule.tail[0], values).abs(), dot(&rule.tail[1], values).abs());
    if a > b { a } else { b }
}
