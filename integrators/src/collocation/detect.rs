//! The search for the times at which an overlap changes its sign in a window. A bound of its second
//! derivative guarantees that no change beyond a given band is missed.

use crate::events::root::bracketed;

/// A change of the sign of the overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    pub(crate) t: f64,
    pub(crate) rising: bool,
    /// Slope of the chord over the interval in which it was found.
    pub(crate) slope: f64,
}

/// The start of a search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Start {
    /// Overlap at the start of the window.
    pub(crate) value: f64,
    /// Its time derivative there.
    pub(crate) slope: f64,
    /// Values of at most this size count as zero.
    pub(crate) rounding: f64,
    /// Whether the bond is in a contact, as known from the window before.
    pub(crate) positive: bool,
}

/// A search for the crossings of one overlap in one window.
pub(crate) struct Search<'a, G, K> {
    /// The overlap as a function of time.
    g: G,
    /// A bound on `|g''|` from the start up to a time.
    curvature: K,
    /// Values of at most this size have no sign.
    band: f64,
    crossings: &'a mut Vec<Crossing>,
    /// Largest error of `g` that cannot change the crossings found so far.
    margin: f64,
    /// Whether `g` is positive after the crossings found so far.
    side: bool,
    /// Number of intervals that may still be divided.
    left: u32,
}

/// Largest number of successive halvings of a window: a time is then known to a rounding of the
/// window. Chosen.
const DEPTH: u32 = 40;
/// Largest number of intervals that are divided. Chosen, not measured.
const PARTS: u32 = 1000;

impl<'a, G: FnMut(f64) -> f64, K: Fn(f64) -> f64> Search<'a, G, K> {
    pub(crate) fn new(g: G, curvature: K, band: f64, crossings: &'a mut Vec<Crossing>) -> Self {
        crossings.clear();
        Self { g, curvature, band, crossings, margin: f64::INFINITY, side: false, left: PARTS }
    }

    /// Finds all crossings up to `h`. Returns the margin: the largest error of the overlap that
    /// cannot change the crossings. `None` if [`PARTS`] intervals were divided.
    pub(crate) fn run(mut self, start: Start, h: f64) -> Option<f64> {
        self.side = start.positive;
        let mut value = start.value;
        if value.abs() <= start.rounding {
            // The overlap starts at zero: its sign is that of its slope.
            if start.slope.abs() * h > self.band && (start.slope > 0.0) != self.side {
                self.cross(0.0, start.slope);
            }
            value = 0.0;
        } else if value.abs() > self.band && (value > 0.0) != self.side {
            self.cross(0.0, start.slope);
        }
        let end = (self.g)(h);
        // An overlap that leaves zero: g >= g0 + g0' t - G t^2/2, concave, so the ends decide.
        let sign = if self.side { 1.0 } else { -1.0 };
        let least = sign * (value + start.slope * h) - 0.5 * (self.curvature)(h) * h * h;
        if sign * value >= 0.0 && least > 0.0 {
            return Some(least);
        }
        self.part((0.0, value), (h, end), 0);
        (self.left > 0).then_some(self.margin)
    }

    fn cross(&mut self, t: f64, slope: f64) {
        self.side = !self.side;
        self.crossings.push(Crossing { t, rising: self.side, slope });
    }

    fn part(&mut self, a: (f64, f64), b: (f64, f64), depth: u32) {
        let width = b.0 - a.0;
        let sag = (self.curvature)(b.0) * width * width;
        let sign = if self.side { 1.0 } else { -1.0 };
        let (ga, gb) = (sign * a.1, sign * b.1);
        let least = ga.min(gb) - 0.125 * sag + self.band;
        if least > 0.0 {
            self.margin = self.margin.min(least);
            return;
        }
        let last = depth >= DEPTH || self.left == 0;
        // The slope differs from that of the chord by at most G width.
        if gb < -self.band && (ga - gb > sag || last) {
            self.margin = self.margin.min((0.25 * (ga - gb - sag)).max(0.0));
            let t = if ga <= 0.0 { a.0 } else { bracketed(&mut self.g, a, b) };
            self.cross(t, (b.1 - a.1) / width);
            return;
        }
        if last {
            self.margin = 0.0;
            return;
        }
        self.left -= 1;
        let middle = a.0 + 0.5 * width;
        let value = (self.g)(middle);
        self.part(a, (middle, value), depth + 1);
        self.part((middle, value), b, depth + 1);
    }
}

/// Sorts by time. Not inlined, so that it is compiled once for all numbers of nodes.
#[inline(never)]
pub(super) fn sort_by_time<T>(list: &mut [(f64, T)]) {
    list.sort_by(|a, b| a.0.total_cmp(&b.0));
}
