//! An overlap over a stretch of time, kept after the step that it comes from.

use super::root::bracketed;

/// Most nodes of a curve: those of a panel of contact collocation, and its two ends.
const MOST: usize = 14;
/// Number of equal parts for an integral. Chosen.
const PARTS: usize = 64;
/// A minimum between nodes is below them by at most this share of the range of their values:
/// 1/9 with four nodes, by a parabola about the middle. Chosen.
const FLAT: f64 = 0.25;

/// A function of time on a stretch: the polynomial in `x`, from 0 at its start to 1 at its end,
/// through its values at some nodes. Time is `t = origin + sign sigma^q`, with a `sigma` that is
/// linear in `x`; rounded, it is from the start of the stretch to its end.
///
/// The first node is the start, the last one the end. Crossings of a level are found by the values
/// at neighbouring nodes: two crossings between the same two nodes are not seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    origin: f64,
    sign: f64,
    q: u32,
    /// `sigma` at the start, and its change to the end.
    sigma: [f64; 2],
    /// Start and end.
    span: (f64, f64),
    count: usize,
    x: [f64; MOST],
    values: [f64; MOST],
}

impl Curve {
    /// Length of the array of [`numbers`](Self::numbers).
    pub const NUMBERS: usize = 8 + 2 * MOST;

    /// The curve over a stretch of time through points `(x, value)`, `x` ascending from 0 to 1, with
    /// the map of time `(origin, sign, q)` and `sigma` at both ends.
    ///
    /// # Panics
    /// Fewer than two points, or more than 14.
    pub fn new(
        (origin, sign, q): (f64, f64, u32),
        [from, to]: [f64; 2],
        span: (f64, f64),
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let (mut x, mut values, mut count) = ([0.0; MOST], [0.0; MOST], 0);
        for point in points {
            (x[count], values[count]) = point;
            count += 1;
        }
        assert!(count > 1, "a curve has a start and an end");
        Self { origin, sign, q, sigma: [from, to - from], span, count, x, values }
    }

    /// The curve over a stretch of time itself, through points `(x, value)`.
    pub fn over(span: (f64, f64), points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self::new((span.0, 1.0, 1), [0.0, span.1 - span.0], span, points)
    }

    /// The same curve, shifted by `by` to later times, within those given.
    #[must_use]
    pub fn later(mut self, by: f64, (first, last): (f64, f64)) -> Self {
        self.origin += by;
        self.span = ((self.span.0 + by).max(first), (self.span.1 + by).min(last));
        self
    }

    fn x(&self) -> &[f64] {
        &self.x[..self.count]
    }

    /// The values at the nodes.
    pub fn values(&self) -> &[f64] {
        &self.values[..self.count]
    }

    /// Smallest and largest value at a node.
    pub fn range(&self) -> (f64, f64) {
        self.values().iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v)))
    }

    /// The last value.
    pub fn last(&self) -> f64 {
        self.values[self.count - 1]
    }

    fn time(&self, x: f64) -> f64 {
        let sigma = self.sigma[0] + self.sigma[1] * x;
        (self.origin + self.sign * sigma.powi(self.q as i32)).max(self.span.0).min(self.span.1)
    }

    /// `dt/dx`.
    fn speed(&self, x: f64) -> f64 {
        let sigma = self.sigma[0] + self.sigma[1] * x;
        self.sign * f64::from(self.q) * sigma.powi(self.q as i32 - 1) * self.sigma[1]
    }

    /// The integral of a function of the value over the time, to some 1e-5 of it.
    pub fn integral(&self, of: impl Fn(f64) -> f64) -> f64 {
        let (rule, step) = (Barycentric::new(self.x()), 1.0 / PARTS as f64);
        let middles = (0..PARTS).map(|k| step * (k as f64 + 0.5));
        middles.map(|x| step * of(rule.at(self.values(), x)) * self.speed(x)).sum()
    }

    /// `d/dt` from `d/dx` at `x`. At the origin of a map, where time does not change with `x`, the
    /// rate of the chord from the node nearest to it.
    fn per_time(&self, by_x: f64, x: f64) -> f64 {
        let speed = self.speed(x);
        if speed > 0.0 {
            return by_x / speed;
        }
        let near = if x < 0.5 { 1 } else { self.count - 2 };
        let here = if x < 0.5 { 0 } else { self.count - 1 };
        (self.values[near] - self.values[here]) / (self.time(self.x[near]) - self.time(self.x[here]))
    }

    /// Whether the values rise from node to node and still rise at the end, by the parabola through
    /// the last three nodes. The margin of a quarter keeps a maximum between the last two nodes
    /// from being missed.
    fn climbs(&self) -> bool {
        let values = self.values();
        let Some([(a, ga), (b, gb), (c, gc)]) =
            (self.count > 2).then(|| [3, 2, 1].map(|back| (self.x[self.count - back], values[self.count - back])))
        else {
            return false;
        };
        let [before, last] = [(gb - ga) / (b - a), (gc - gb) / (c - b)];
        let end = last + (last - before) * (c - b) / (c - a);
        end > 0.25 * last && values.windows(2).all(|pair| pair[0] < pair[1])
    }

    /// Time and value of the maximum.
    pub fn largest(&self) -> (f64, f64) {
        if self.climbs() {
            return (self.time(1.0), self.last());
        }
        let values = self.values();
        let k = (0..values.len()).max_by(|&i, &j| values[i].total_cmp(&values[j])).unwrap_or(0);
        let here = (self.time(self.x[k]), values[k]);
        let rule = Barycentric::new(self.x());
        let slopes = rule.slopes(values);
        let next = if slopes[k] > 0.0 { k + 1 } else { k.wrapping_sub(1) };
        if next >= values.len() || slopes[next] * slopes[k] >= 0.0 {
            return here;
        }
        let x = self.turn(&rule, &slopes, k.min(next));
        (self.time(x), rule.at(values, x).max(here.1))
    }

    /// The `x` between node `k` and the next one at which the slope is zero.
    fn turn(&self, rule: &Barycentric<'_>, slopes: &[f64; MOST], k: usize) -> f64 {
        let [a, b] = [k, k + 1].map(|i| (self.x[i], slopes[i]));
        bracketed(|x| rule.at(&slopes[..self.count], x), a, b)
    }

    /// The curve in two, cut where it has a minimum between its ends, the least one, if that is
    /// below `level`.
    pub fn cut_below(&self, level: f64) -> Option<[Self; 2]> {
        let (values, (low, high)) = (self.values(), self.range());
        if low > level + FLAT * (high - low) {
            return None;
        }
        let rule = Barycentric::new(self.x());
        let slopes = rule.slopes(values);
        let least = |k: usize| self.turn(&rule, &slopes, k);
        let turns = (0..self.count - 1).filter(|&k| slopes[k] < 0.0 && slopes[k + 1] > 0.0).map(least);
        let x = turns.min_by(|&a, &b| rule.at(values, a).total_cmp(&rule.at(values, b)))?;
        let least = rule.at(values, x);
        let most = |here: &dyn Fn(f64) -> bool| {
            let values = self.x().iter().zip(values).filter(|(x, _)| here(**x)).map(|(_, value)| *value);
            values.fold(0.0, f64::max)
        };
        // Values below zero are errors. The least value of a half is at its end, but for roundings.
        let inside = (0.0..level).contains(&least) && 2.0 * least < most(&|y| y < x).min(most(&|y| y > x));
        inside.then(|| [self.between(&rule, 0.0, x), self.between(&rule, x, 1.0)])
    }

    /// The curve from one `x` to another.
    fn between(&self, rule: &Barycentric<'_>, from: f64, to: f64) -> Self {
        let mut part = *self;
        part.sigma = [self.sigma[0] + self.sigma[1] * from, self.sigma[1] * (to - from)];
        for (value, x) in part.values[..self.count].iter_mut().zip(self.x) {
            *value = rule.at(self.values(), from + (to - from) * x);
        }
        part
    }

    /// Time at which the curve first rises through `level`, not before the time `from`, and its
    /// rate there. Without such a crossing: the start if it is not before `from` and the first
    /// value is at least `level`, else `None`.
    pub fn rises_to(&self, level: f64, from: f64) -> Option<(f64, f64)> {
        let values = self.values();
        let rises = |k: &usize| self.time(self.x[k + 1]) > from && values[*k] < level && values[k + 1] >= level;
        if let Some(k) = (0..self.count - 1).find(rises) {
            return Some(self.crossing(level, k, k + 1));
        }
        // The start may be before `from` by a rounding.
        let whole = from <= 0.5 * (self.start() + self.time(self.x[1]));
        (whole && values[0] >= level).then(|| self.crossing(level, 0, 0))
    }

    /// Time at which the curve last falls below `level`, and its rate there; `None` if it does not
    /// end below, or is below at every node.
    pub fn falls_to(&self, level: f64) -> Option<(f64, f64)> {
        let values = self.values();
        if self.last() >= level {
            return None;
        }
        let k = values.windows(2).rposition(|pair| pair[0] >= level && pair[1] < level)?;
        Some(self.crossing(level, k, k + 1))
    }

    /// Time and value at the node with the least value.
    pub fn least(&self) -> (f64, f64) {
        let values = self.values();
        let k = (0..values.len()).min_by(|&i, &j| values[i].total_cmp(&values[j])).unwrap_or(0);
        (self.time(self.x[k]), values[k])
    }

    /// Time, value and rate at `x`.
    pub fn at(&self, x: f64) -> [f64; 3] {
        let (values, rule) = (self.values(), Barycentric::new(self.x()));
        let slopes = rule.slopes(values);
        [self.time(x), rule.at(values, x), self.per_time(rule.at(&slopes[..values.len()], x), x)]
    }

    /// Time of the start.
    pub fn start(&self) -> f64 {
        self.time(0.0)
    }

    /// Time, value and rate at the end; the rate is that of the chord from the node before.
    pub fn end(&self) -> [f64; 3] {
        let [(x, value), (_, last)] = [self.count - 2, self.count - 1].map(|k| (self.x[k], self.values[k]));
        let t = self.time(1.0);
        [t, last, (last - value) / (t - self.time(x))]
    }

    /// Time and rate at the crossing of `level` between two nodes; at the node itself if both are
    /// one.
    fn crossing(&self, level: f64, from: usize, to: usize) -> (f64, f64) {
        let (values, rule) = (self.values(), Barycentric::new(self.x()));
        let value = |x: f64| rule.at(values, x) - level;
        let ends = [from, to].map(|k| (self.x[k], values[k] - level));
        let x = if from == to { self.x[from] } else { bracketed(value, ends[0], ends[1]) };
        let [t, _, rate] = self.at(x);
        (t, rate)
    }

    /// The curve as plain numbers, for [`of_numbers`](Self::of_numbers).
    pub fn numbers(&self) -> [f64; Self::NUMBERS] {
        let mut numbers = [0.0; Self::NUMBERS];
        let Self { origin, sign, q, sigma: [from, by], span, count, .. } = *self;
        let head = [origin, sign, f64::from(q), from, by, span.0, span.1, count as f64];
        let (start, rest) = numbers.split_at_mut(head.len());
        start.copy_from_slice(&head);
        rest[..MOST].copy_from_slice(&self.x);
        rest[MOST..].copy_from_slice(&self.values);
        numbers
    }

    /// The curve with these [`numbers`](Self::numbers); `None` if they are not those of a curve.
    pub fn of_numbers(numbers: &[f64; Self::NUMBERS]) -> Option<Self> {
        let [origin, sign, q, from, by, start, end, count, rest @ ..] = *numbers;
        let sound = numbers.iter().all(|number| number.is_finite())
            && sign.abs() == 1.0
            && q.fract() == 0.0
            && (1.0..=64.0).contains(&q)
            && count.fract() == 0.0
            && (2.0..=MOST as f64).contains(&count)
            && by != 0.0
            && start <= end;
        let (mut x, mut values) = ([0.0; MOST], [0.0; MOST]);
        x.copy_from_slice(&rest[..MOST]);
        values.copy_from_slice(&rest[MOST..]);
        let (sigma, span) = ([from, by], (start, end));
        let curve = Self { origin, sign, q: q as u32, sigma, span, count: count as usize, x, values };
        (sound && curve.x().windows(2).all(|pair| pair[0] < pair[1])).then_some(curve)
    }
}

/// Interpolation of values at given nodes, in barycentric form.
struct Barycentric<'a> {
    nodes: &'a [f64],
    weights: [f64; MOST],
}

impl<'a> Barycentric<'a> {
    fn new(nodes: &'a [f64]) -> Self {
        let mut weights = [1.0; MOST];
        for (j, weight) in weights.iter_mut().enumerate().take(nodes.len()) {
            for (_, node) in nodes.iter().enumerate().filter(|(k, _)| *k != j) {
                *weight /= nodes[j] - node;
            }
        }
        Self { nodes, weights }
    }

    /// The interpolant of `values` at `x`.
    fn at(&self, values: &[f64], x: f64) -> f64 {
        let (mut above, mut below) = (0.0, 0.0);
        for ((node, weight), value) in self.nodes.iter().zip(self.weights).zip(values) {
            if x == *node {
                return *value;
            }
            let share = weight / (x - node);
            above += share * value;
            below += share;
        }
        above / below
    }

    /// The derivative of the interpolant of `values` at the nodes.
    fn slopes(&self, values: &[f64]) -> [f64; MOST] {
        let mut slopes = [0.0; MOST];
        for i in 0..self.nodes.len() {
            for j in (0..self.nodes.len()).filter(|&j| j != i) {
                let chord = (values[j] - values[i]) / (self.nodes[j] - self.nodes[i]);
                slopes[i] -= self.weights[j] / self.weights[i] * chord;
            }
        }
        slopes
    }
}
