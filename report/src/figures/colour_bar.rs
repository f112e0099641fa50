//! Colour bars: the scale of the colours of a figure.

use super::axes::{Axis, LINE};
use super::canvas::{Canvas, LABEL, Rect, SMALL, usable, wrap};
use super::palette::{INK, Rgb};

/// Width of the bar, in pixels.
const WIDTH: usize = 22;
/// Height of the tip for values beyond the bar, in pixels.
const TIP: f64 = 13.0;

/// A colour bar to the right of the axes.
pub(super) struct ColourBar {
    axis: Axis,
    label: Vec<String>,
    /// The colour of values beyond the upper end, if there are some.
    pub(super) beyond: Option<Rgb>,
}

impl ColourBar {
    /// A bar over a range, in a figure of height `height`.
    pub(super) fn new((lo, hi): (f64, f64), label: &str, height: f64) -> Self {
        Self::along(Axis::exact(lo, hi, false), label, height)
    }

    pub(super) fn along(mut axis: Axis, label: &str, height: f64) -> Self {
        axis.tick(height - 80.0, true);
        Self { axis, label: wrap(label, LABEL, height - 120.0), beyond: None }
    }

    /// The rest of an area beside the bar; at the top it leaves room for the factor of the ticks.
    pub(super) fn beside(&self, area: Rect) -> Rect {
        let aside = WIDTH as f64 + 27.0 + self.axis.label_width() + LINE * self.label.len() as f64;
        Rect { x1: area.x1 - aside, y0: area.y0 + 1.2 * SMALL, ..area }
    }

    /// Draws the bar, with its ticks and its label, between the frame of the axes and the right
    /// edge of the figure.
    pub(super) fn draw(&self, canvas: &mut Canvas, frame: Rect, edge: f64, colour: impl Fn(f64) -> Rgb) {
        let x0 = frame.x1 + 16.0;
        let strip = Rect { x0, x1: x0 + WIDTH as f64, ..frame };
        let high = frame.height() as usize;
        let column = (0..high).map(|k| self.axis.value(1.0 - (k as f64 + 0.5) / high as f64));
        let pixels: Vec<Rgb> = column.flat_map(|value| [colour(value); WIDTH]).collect();
        canvas.image((strip.x0 as u32, strip.y0 as u32), WIDTH, pixels);
        canvas.border(&strip, INK);
        if let Some(beyond) = self.beyond {
            let [left, right] = [strip.x0, strip.x1].map(|x| (x, strip.y0 - 1.0));
            let top = (x0 + 0.5 * WIDTH as f64, strip.y0 - TIP);
            canvas.polygon(&[left, right, top], beyond);
            canvas.line(&[left, top, right], INK, 1.0, &[]);
        }
        for (place, label) in &self.axis.ticks {
            let y = strip.y1 - place * strip.height();
            canvas.line(&[(strip.x1, y), (strip.x1 + 5.0, y)], INK, 1.0, &[]);
            canvas.text(label, (strip.x1 + 9.0, y), SMALL, INK, (0.0, 0.5));
        }
        canvas.text(&self.axis.factor, (edge, strip.y0 - 0.6 * SMALL), SMALL, INK, (1.0, 1.0));
        let middle = (strip.y0 + strip.y1) / 2.0;
        for (k, line) in self.label.iter().enumerate() {
            let at = strip.x1 + 16.0 + self.axis.label_width() + LINE * k as f64;
            canvas.text_upwards(line, (at, middle), LABEL, INK, (0.5, 0.0));
        }
    }
}

/// The range of the positive values, from 1 to 10 if there are none.
pub(super) fn positive_range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let positive = values.filter(|&value| usable(value) && value > 0.0);
    let (lo, hi) = positive.fold((f64::INFINITY, 0.0_f64), |(lo, hi), value| (lo.min(value), hi.max(value)));
    if lo <= hi { (lo, hi) } else { (1.0, 10.0) }
}

/// The smallest range that holds 0 and all usable values; from 0 to 1 if that range has no width.
pub(super) fn range_with_zero(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let values = values.filter(|&value| usable(value));
    let (lo, hi) = values.fold((0.0_f64, 0.0_f64), |(lo, hi), value| (lo.min(value), hi.max(value)));
    (lo, if hi - lo < 1e-290 { lo + 1.0 } else { hi })
}
