//! Axes: ranges, ticks and labels of all figures.

use super::canvas::{Canvas, Error, LABEL, Rect, SMALL, text_width, usable, wrap};
use super::palette::{GRID, INK, PAPER, Rgb, Style};

/// Radius of a marker, in pixels.
pub(super) const MARKER: f64 = 4.6;
/// Length of a tick, in pixels.
const TICK: f64 = 5.0;
/// Least space to the left of the axes, in pixels, so that stacked panels align.
pub(super) const LEFT: f64 = 100.0;
/// Height of a line of a label, in pixels.
pub(super) const LINE: f64 = 1.3 * LABEL;

/// Ten to an integer power in superscript digits: 10⁻⁶.
pub(super) fn power_of_ten(exponent: i32) -> String {
    let digits = exponent.to_string();
    let raised = digits.chars().map(|c| match c.to_digit(10) {
        Some(d) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][d as usize],
        None => '⁻',
    });
    format!("10{}", raised.collect::<String>())
}

/// A number with `decimals` decimals and a typographic minus sign; zero has no sign.
fn fixed(value: f64, decimals: i32) -> String {
    crate::number::format_fixed(value, decimals.max(0) as usize).replace('-', "−")
}

/// A number with two digits, as a multiple of a power of ten.
pub(super) fn short(value: f64) -> String {
    let text = format!("{value:.1e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    format!("{}·{}", mantissa.replace('-', "−"), power_of_ten(exponent.parse().unwrap_or(0)))
}

/// A digit times a power of ten.
fn decimal(digit: i32, exponent: i32) -> String {
    match exponent {
        -3..=3 => fixed(f64::from(digit) * 10_f64.powi(exponent), -exponent),
        _ if digit == 1 => power_of_ten(exponent),
        _ => format!("{digit}·{}", power_of_ten(exponent)),
    }
}

/// A positive number that is short: of one digit, such as 0.03 or 10⁻⁸, or whole and of up to four.
fn short_number(value: f64) -> Option<String> {
    if value.fract() == 0.0 && (1.0..1e4).contains(&value) {
        return Some(value.to_string());
    }
    let exponent = value.log10().floor() as i32;
    let digit = (value / 10_f64.powi(exponent)).round();
    let exact = (value / (digit * 10_f64.powi(exponent)) - 1.0).abs() < 1e-9;
    exact.then(|| decimal(digit as i32, exponent))
}

fn decade(value: f64) -> i32 {
    value.abs().log10().floor() as i32
}

/// One axis: its range, linear or logarithmic, and its ticks.
pub struct Axis {
    log: bool,
    whole: bool,
    /// The ends of the range; on a logarithmic axis their decimal logarithms.
    lo: f64,
    hi: f64,
    /// Positions, from 0 to 1 along the axis, and their labels.
    pub ticks: Vec<(f64, String)>,
    minor: Vec<f64>,
    /// Values with ticks, on a logarithmic axis of cells; otherwise empty.
    cells: Vec<f64>,
    /// Factor and offset of the labels, as text: the value is label times factor plus offset.
    pub factor: String,
}

impl Axis {
    /// An axis over a range. A range of no more than a rounding becomes one of a tenth of its size.
    fn new(log: bool, whole: bool, lo: f64, hi: f64) -> Self {
        let size = lo.abs().max(hi.abs());
        let pad = match () {
            () if size < 1e-290 => 1.0,
            () if hi - lo <= 1e-12 * size => 0.05 * size,
            () => 0.0,
        };
        let (lo, hi) = (lo - pad, hi + pad);
        Self { log, whole, lo, hi, ticks: Vec::new(), minor: Vec::new(), cells: Vec::new(), factor: String::new() }
    }

    /// A linear axis over all usable values, with a margin at both ends as a share of their range.
    pub fn linear(values: impl Iterator<Item = f64>, margin: f64) -> Self {
        let (lo, hi) = bounds(values).unwrap_or((0.0, 1.0));
        Self::new(false, false, lo - margin * (hi - lo), hi + margin * (hi - lo))
    }

    /// A linear axis with ticks at whole numbers and a margin of at least half a number at both
    /// ends.
    pub fn whole(values: impl Iterator<Item = f64>) -> Self {
        let (lo, hi) = bounds(values).unwrap_or((0.0, 1.0));
        let pad = 0.5_f64.max(0.01 * (hi - lo));
        Self::new(false, true, lo - pad, hi + pad)
    }

    /// A linear axis with the given ends.
    pub(super) fn exact(lo: f64, hi: f64, whole: bool) -> Self {
        Self::new(false, whole, lo, hi)
    }

    /// A logarithmic axis with the given ends.
    pub(super) fn exact_log(lo: f64, hi: f64) -> Self {
        Self::new(true, false, lo.log10(), hi.log10())
    }

    /// A logarithmic axis with the given ends, over cells around some values: ticks are at these
    /// values if all of them are short numbers, else as on any axis.
    pub(super) fn of_cells(lo: f64, hi: f64, values: &[f64]) -> Self {
        let all_short = values.iter().all(|&value| short_number(value).is_some());
        Self { cells: if all_short { values.to_vec() } else { Vec::new() }, ..Self::exact_log(lo, hi) }
    }

    /// A logarithmic axis over all usable positive values, extended to the next 1, 2 or 5 of a
    /// decade.
    pub fn log(values: impl Iterator<Item = f64>) -> Self {
        let (lo, hi) = bounds(values.filter(|&v| v > 0.0)).unwrap_or((1.0, 10.0));
        let (lo, hi) = (lo.log10(), hi.log10());
        let pad = 0.05_f64.max(0.02 * (hi - lo));
        let steps = [0.0, 2_f64.log10(), 5_f64.log10(), 1.0];
        let (lo, hi) = (lo - pad, hi + pad);
        let below = steps.iter().rev().find(|&&s| lo.floor() + s <= lo).unwrap_or(&0.0);
        let above = steps.iter().find(|&&s| hi.floor() + s >= hi).unwrap_or(&1.0);
        Self::new(true, false, lo.floor() + below, hi.floor() + above)
    }

    /// The position of a value, from 0 to 1 along the axis; `None` if the axis cannot show it.
    pub(super) fn place(&self, value: f64) -> Option<f64> {
        if !usable(value) || (self.log && value <= 0.0) {
            return None;
        }
        Some(self.fraction(if self.log { value.log10() } else { value }))
    }

    /// The value at a position from 0 to 1 along the axis.
    pub(super) fn value(&self, place: f64) -> f64 {
        let position = self.lo + place * (self.hi - self.lo);
        if self.log { 10_f64.powf(position) } else { position }
    }

    /// Changes the width of the range; its middle stays.
    fn widen(&mut self, width: f64) {
        let middle = 0.5 * (self.lo + self.hi);
        (self.lo, self.hi) = (middle - 0.5 * width, middle + 0.5 * width);
    }

    fn fraction(&self, position: f64) -> f64 {
        (position - self.lo) / (self.hi - self.lo)
    }

    /// Sets as many ticks as fit on an axis of `pixels` pixels without touching labels.
    pub fn tick(&mut self, pixels: f64, upright: bool) {
        let most = ((pixels / if upright { 48.0 } else { 95.0 }) as usize).clamp(5, 12);
        for count in (1..=most).rev() {
            if self.log {
                self.log_ticks(count)
            } else {
                self.linear_ticks(count)
            }
            let size = |label: &String| if upright { 1.2 * SMALL } else { text_width(label, SMALL) + 12.0 };
            let crowded = self
                .ticks
                .windows(2)
                .any(|two| pixels * (two[1].0 - two[0].0) < 0.5 * (size(&two[0].1) + size(&two[1].1)));
            if !crowded {
                break;
            }
        }
    }

    fn linear_ticks(&mut self, count: usize) {
        let raw = (self.hi - self.lo) / count as f64;
        let mut power = decade(raw);
        let unit = 10_f64.powi(power);
        let mut nice = [1.0, 2.0, 5.0, 10.0].into_iter().find(|n| n * unit >= raw).unwrap_or(10.0);
        if nice == 10.0 {
            (nice, power) = (1.0, power + 1);
        }
        if self.whole && power < 0 {
            (nice, power) = (1.0, 0);
        }
        let step = nice * 10_f64.powi(power);
        let (first, last) = ((self.lo / step).ceil(), (self.hi / step).floor());
        let steps: Vec<f64> = (0..=(last - first).max(0.0) as usize).map(|k| first + k as f64).collect();
        let places = steps.iter().map(|k| self.fraction(k * step));

        let size = first.abs().max(last.abs());
        let top = if size == 0.0 { 0 } else { decade(size * step) };
        // If more than six digits are needed to distinguish two ticks, labels are differences from
        // a tick in the middle.
        let origin = if top - power > 5 { steps[steps.len() / 2] } else { 0.0 };
        let plain = -3..=if self.whole { 6 } else { 4 };
        let scale = match top {
            _ if origin != 0.0 => power,
            top if plain.contains(&top) => 0,
            top => top,
        };
        let labels = steps.iter().map(|k| fixed((k - origin) * nice * 10_f64.powi(power - scale), scale - power));
        self.ticks = places.zip(labels).filter(|(place, _)| (-1e-9..=1.0 + 1e-9).contains(place)).collect();
        self.factor = if scale == 0 { String::new() } else { format!("×{}", power_of_ten(scale)) };
        if origin != 0.0 {
            let sum = if origin < 0.0 { "−" } else { "+" };
            let size = (origin * step).abs();
            let trim = |text: String| match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
                false => text,
            };
            let whole = if plain.contains(&top) {
                trim(fixed(size, -power))
            } else {
                format!("{}·{}", trim(fixed(size / 10_f64.powi(top), top - power)), power_of_ten(top))
            };
            self.factor = format!("{} {sum} {whole}", self.factor).trim_start().into();
        }
    }

    fn log_ticks(&mut self, count: usize) {
        if !self.cells.is_empty() {
            let every = self.cells.len().div_ceil(count);
            let tick = |&value: &f64| Some((self.place(value)?, short_number(value)?));
            self.ticks = self.cells.iter().step_by(every).filter_map(tick).collect();
            return;
        }
        let near = 1e-9;
        let decades = (self.lo - near).ceil() as i32..=(self.hi + near).floor() as i32;
        let number = decades.clone().count();
        let strides = [1, 2, 3, 5, 10, 20, 50, 100, 200];
        let stride = strides.into_iter().find(|&s| number <= s as usize * count).unwrap_or(500);
        let inside = |place: &f64| (-near..=1.0 + near).contains(place);
        let within: Vec<i32> = (self.lo.floor() as i32..=self.hi.floor() as i32).collect();
        // Few decades have ticks at 2 and 5 as well, if there is room.
        if number < 2 || (number == 2 && count > 3) {
            let steps: &[i32] = if count > 4 && self.hi - self.lo < 0.75 { &[1, 2, 3, 4, 5, 6, 8] } else { &[1, 2, 5] };
            self.ticks = within
                .iter()
                .flat_map(|&d| steps.iter().map(move |&m| (d, m)))
                .map(|(d, m)| (self.fraction(f64::from(d) + f64::from(m).log10()), decimal(m, d)))
                .filter(|(place, _)| inside(place))
                .collect();
        } else {
            self.ticks = decades
                .clone()
                .filter(|d| d.rem_euclid(stride) == 0)
                .map(|d| (self.fraction(f64::from(d)), power_of_ten(d)))
                .collect();
        }
        self.minor = match number {
            0..=16 if stride <= 2 => within
                .iter()
                .flat_map(|&d| (2..10).map(move |m| f64::from(d) + f64::from(m).log10()))
                .map(|position| self.fraction(position))
                .filter(inside)
                .collect(),
            _ if stride <= 10 => decades.map(|d| self.fraction(f64::from(d))).collect(),
            _ => Vec::new(),
        };
    }

    /// The width of the widest label.
    pub(super) fn label_width(&self) -> f64 {
        self.ticks.iter().map(|(_, label)| text_width(label, SMALL)).fold(0.0, f64::max)
    }
}

fn bounds(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|&v| usable(v)).fold(None, |range, v| {
        let (lo, hi) = range.unwrap_or((v, v));
        Some((v.min(lo), v.max(hi)))
    })
}

/// A pair of axes drawn on a canvas.
pub(super) struct Axes {
    /// The area between the axes.
    pub(super) frame: Rect,
    x: Axis,
    y: Axis,
}

impl Axes {
    /// Draws axes, labels and, if wanted, a grid inside an area.
    pub(super) fn draw(
        canvas: &mut Canvas,
        area: Rect,
        x: (Axis, &str),
        y: (Axis, &str),
        grid: bool,
    ) -> Result<Self, Error> {
        Self::draw_from(canvas, area, x, y, grid, false)
    }

    /// The same; if `equal`, the ranges are widened until a unit has the same length on both axes.
    pub(super) fn draw_from(
        canvas: &mut Canvas,
        area: Rect,
        (mut x, x_label): (Axis, &str),
        (mut y, y_label): (Axis, &str),
        grid: bool,
        equal: bool,
    ) -> Result<Self, Error> {
        let x_lines = wrap(x_label, LABEL, 0.6 * area.width());
        let bottom = TICK + 1.5 * SMALL + LINE * x_lines.len() as f64 + 4.0;
        y.tick(area.height() - bottom, true);
        let top = if y.factor.is_empty() { 0.5 * SMALL } else { 1.7 * SMALL };
        let mut frame = Rect { y0: (area.y0 + top).round(), y1: (area.y1 - bottom).round(), ..area };
        y.tick(frame.height(), true);
        let y_lines = wrap(y_label, LABEL, frame.height());
        let left = TICK + 8.0 + y.label_width() + LINE * y_lines.len() as f64;
        frame.x0 = (area.x0 + left.max(LEFT)).round();
        x.tick(area.x1 - frame.x0, false);
        frame.x1 = (area.x1 - (0.5 * x.label_width()).max(10.0)).round();
        x.tick(frame.width(), false);
        if frame.width() < 60.0 || frame.height() < 60.0 {
            return Err(Error("labels and captions leave no room for the axes".into()));
        }
        if equal {
            let unit = ((x.hi - x.lo) / frame.width()).max((y.hi - y.lo) / frame.height());
            x.widen(unit * frame.width());
            y.widen(unit * frame.height());
            x.tick(frame.width(), false);
            y.tick(frame.height(), true);
        }

        let axes = Self { frame, x, y };
        let Self { frame, x, y } = &axes;
        let (across, up) = (|p: f64| frame.x0 + p * frame.width(), |p: f64| frame.y1 - p * frame.height());
        if grid {
            for (p, _) in &x.ticks {
                canvas.line(&[(across(*p), frame.y0), (across(*p), frame.y1)], GRID, 1.0, &[]);
            }
            for (p, _) in &y.ticks {
                canvas.line(&[(frame.x0, up(*p)), (frame.x1, up(*p))], GRID, 1.0, &[]);
            }
        }
        for (place, label) in &x.ticks {
            let at = across(*place);
            canvas.line(&[(at, frame.y1), (at, frame.y1 + TICK)], INK, 1.0, &[]);
            canvas.text(label, (at, frame.y1 + TICK + 5.0), SMALL, INK, (0.5, 0.0));
        }
        for (place, label) in &y.ticks {
            let at = up(*place);
            canvas.line(&[(frame.x0 - TICK, at), (frame.x0, at)], INK, 1.0, &[]);
            canvas.text(label, (frame.x0 - TICK - 4.0, at), SMALL, INK, (1.0, 0.5));
        }
        for &place in &x.minor {
            canvas.line(&[(across(place), frame.y1), (across(place), frame.y1 + 0.5 * TICK)], INK, 0.7, &[]);
        }
        for &place in &y.minor {
            canvas.line(&[(frame.x0 - 0.5 * TICK, up(place)), (frame.x0, up(place))], INK, 0.7, &[]);
        }
        let label_top = frame.y1 + TICK + 1.5 * SMALL + 2.0;
        canvas.text(&x.factor, (frame.x1, label_top), SMALL, INK, (1.0, 0.0));
        canvas.text(&y.factor, (frame.x0 - TICK, frame.y0 - 0.6 * SMALL), SMALL, INK, (0.0, 1.0));
        let (middle_x, middle_y) = ((frame.x0 + frame.x1) / 2.0, (frame.y0 + frame.y1) / 2.0);
        for (k, line) in x_lines.iter().enumerate() {
            canvas.text(line, (middle_x, label_top + LINE * k as f64), LABEL, INK, (0.5, 0.0));
        }
        for (k, line) in y_lines.iter().enumerate() {
            let at = frame.x0 - left + LINE * k as f64;
            canvas.text_upwards(line, (at, middle_y), LABEL, INK, (0.5, 0.0));
        }
        axes.close(canvas);
        Ok(axes)
    }

    /// Draws the frame; called again after a picture has covered the edge.
    pub(super) fn close(&self, canvas: &mut Canvas) {
        canvas.border(&self.frame, INK);
    }

    /// Fills the axes with pixels, given row by row from the top.
    pub(super) fn image(&self, canvas: &mut Canvas, pixels: Vec<Rgb>) {
        canvas.image((self.frame.x0 as u32, self.frame.y0 as u32), self.frame.width() as usize, pixels);
    }

    /// The value in the middle of the ordinate.
    pub(super) fn middle(&self) -> f64 {
        self.y.value(0.5)
    }

    /// The position of a point on the canvas; `None` if an axis cannot show it.
    pub(super) fn place(&self, (x, y): (f64, f64)) -> Option<(f64, f64)> {
        let (x, y) = (self.x.place(x)?, self.y.place(y)?);
        Some((self.frame.x0 + x * self.frame.width(), self.frame.y1 - y * self.frame.height()))
    }

    /// Joins points, with a gap at each point that cannot be shown; a point between two gaps
    /// becomes a dot.
    pub(super) fn join(&self, canvas: &mut Canvas, points: &[(f64, f64)], style: &Style) {
        let places: Vec<_> = points.iter().map(|&point| self.place(point)).collect();
        for run in places.split(Option::is_none) {
            let run = thin(run.iter().flatten().copied());
            match run.as_slice() {
                [] => {}
                &[(x, y)] => canvas.line(&[(x - 2.5, y), (x + 2.5, y)], style.colour, 5.0, &[]),
                run => canvas.line(run, style.colour, 1.6, style.dash),
            }
        }
    }

    /// Joins points inside the frame by a dark line with a light edge, seen on every colour.
    pub(super) fn join_over(&self, canvas: &mut Canvas, points: &[(f64, f64)], dash: &[f64]) {
        let Rect { x0, x1, y0, y1 } = self.frame;
        let inside = |at: &(f64, f64)| (x0..=x1).contains(&at.0) && (y0..=y1).contains(&at.1);
        let points: Vec<_> = points.iter().map(|&point| self.place(point).filter(inside)).collect();
        for run in points.split(Option::is_none) {
            let run: Vec<_> = run.iter().flatten().copied().collect();
            canvas.line(&run, PAPER, 5.0, &[]);
            canvas.line(&run, INK, 1.6, dash);
        }
    }
}

pub(super) fn mark(canvas: &mut Canvas, style: &Style, at: (f64, f64), hollow: bool) {
    mark_of(canvas, style, at, hollow, MARKER);
}

/// [`mark`] with another radius.
pub(super) fn mark_of(canvas: &mut Canvas, style: &Style, (x, y): (f64, f64), hollow: bool, radius: f64) {
    let Some(marker) = style.marker else { return };
    let mut outline: Vec<_> = marker.outline(radius).into_iter().map(|(u, v)| (x + u, y + v)).collect();
    if !outline.is_empty() {
        canvas.polygon(&outline, if hollow { PAPER } else { style.colour });
        if hollow {
            outline.extend_from_within(..2);
            canvas.line(&outline, style.colour, 1.3, &[]);
        }
    }
    for stroke in marker.strokes(radius) {
        canvas.line(&stroke.map(|(u, v)| (x + u, y + v)), style.colour, 1.4, &[]);
    }
}

/// Leaves out points that do not change the picture: of those in a column of pixels the first, the
/// extremes and the last stay.
pub fn thin(points: impl Iterator<Item = (f64, f64)>) -> Vec<(f64, f64)> {
    let mut kept: Vec<(f64, f64)> = Vec::new();
    let mut column: Vec<(f64, f64)> = Vec::new();
    let flush = |column: &mut Vec<(f64, f64)>, kept: &mut Vec<(f64, f64)>| {
        if column.len() > 4 {
            let by_height = |a: &usize, b: &usize| column[*a].1.total_cmp(&column[*b].1);
            let low = (0..column.len()).min_by(by_height).unwrap_or(0);
            let high = (0..column.len()).max_by(by_height).unwrap_or(0);
            let mut chosen = vec![0, low, high, column.len() - 1];
            chosen.sort_unstable();
            chosen.dedup();
            kept.extend(chosen.into_iter().map(|k| column[k]));
            column.clear();
        }
        kept.append(column);
    };
    for point in points {
        if column.first().is_some_and(|first| first.0.floor() != point.0.floor()) {
            flush(&mut column, &mut kept);
        }
        column.push(point);
    }
    flush(&mut column, &mut kept);
    kept
}
