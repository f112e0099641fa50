//! Where an overlap changes its side within a window, with a certificate that no change beyond the
//! band was missed.

use crate::events::root::bracketed;

/// A change of side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    pub(crate) t: f64,
    pub(crate) rising: bool,
    /// Secant slope around it.
    pub(crate) slope: f64,
}

/// The start of a search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Start {
    pub(crate) value: f64,
    pub(crate) slope: f64,
    /// Values up to this are none.
    pub(crate) rounding: f64,
    /// The side that the overlap is on, remembered.
    pub(crate) positive: bool,
}

pub(crate) struct Search<'a, G, K> {
    g: G,
    /// A bound on `|g''|` from the start up to a time.
    curvature: K,
    /// Values up to this have no sign.
    band: f64,
    crossings: &'a mut Vec<Crossing>,
    slack: f64,
    side: bool,
    left: u32,
}

/// Halvings of a window, at most: a time is then known to a rounding of the window. Chosen.
const DEPTH: u32 = 40;
/// Parts that are looked at, at most. Chosen, not measured.
const PARTS: u32 = 1000;

impl<'a, G: FnMut(f64) -> f64, K: Fn(f64) -> f64> Search<'a, G, K> {
    pub(crate) fn new(g: G, curvature: K, band: f64, crossings: &'a mut Vec<Crossing>) -> Self {
        crossings.clear();
        Self { g, curvature, band, crossings, slack: f64::INFINITY, side: false, left: PARTS }
    }

    /// Finds all crossings up to `h`. Returns how far the overlap may be off without a change of
    /// what is found; `None` if there is more to look at than anybody could.
    pub(crate) fn run(mut self, start: Start, h: f64) -> Option<f64> {
        self.side = start.positive;
        let mut value = start.value;
        if value.abs() <= start.rounding {
            // On the surface the side is that which it moves to.
            if start.slope.abs() * h > self.band && (start.slope > 0.0) != self.side {
                self.cross(0.0, start.slope);
            }
            value = 0.0;
        } else if value.abs() > self.band && (value > 0.0) != self.side {
            self.cross(0.0, start.slope);
        }
        let end = (self.g)(h);
        // From a surface that it leaves: g >= g0 + g0' t - G t^2/2, concave, so the ends decide.
        let sign = if self.side { 1.0 } else { -1.0 };
        let least = sign * (value + start.slope * h) - 0.5 * (self.curvature)(h) * h * h;
        if sign * value >= 0.0 && least > 0.0 {
            return Some(least);
        }
        self.part((0.0, value), (h, end), 0);
        (self.left > 0).then_some(self.slack)
    }

    fn cross(&mut self, t: f64, slope: f64) {
        self.side = !self.side;
        self.crossings.push(Crossing { t, rising: self.side, slope });
    }

    fn part(&mut self, a: (f64, f64), b: (f64, f64), depth: u32) {
        let width = b.0 - a.0;
        let bend = (self.curvature)(b.0) * width * width;
        let sign = if self.side { 1.0 } else { -1.0 };
        let (ga, gb) = (sign * a.1, sign * b.1);
        let least = ga.min(gb) - 0.125 * bend + self.band;
        if least > 0.0 {
            self.slack = self.slack.min(least);
            return;
        }
        let last = depth >= DEPTH || self.left == 0;
        // The slope differs from that of the chord by at most G width.
        if gb < -self.band && (ga - gb > bend || last) {
            self.slack = self.slack.min((0.25 * (ga - gb - bend)).max(0.0));
            let t = if ga <= 0.0 { a.0 } else { bracketed(&mut self.g, a, b) };
            self.cross(t, (b.1 - a.1) / width);
            return;
        }
        if last {
            self.slack = 0.0;
            return;
        }
        self.left -= 1;
        let middle = a.0 + 0.5 * width;
        let value = (self.g)(middle);
        self.part(a, (middle, value), depth + 1);
        self.part((middle, value), b, depth + 1);
    }
}
