//! Legends, each in a space of its own beside or above the curves.

use super::axes::{LEFT, mark};
use super::canvas::{Canvas, Error, Rect, SMALL, text_width, wrap};
use super::palette::{INK, Rgb, Style};

/// Width of the sample of a line, in pixels.
const SAMPLE: f64 = 38.0;
/// Space between a sample and its text, and half the space between two entries of a row, in pixels.
const GAP: f64 = 8.0;
/// Least size of letters in a legend, in pixels per em.
const SMALLEST: f64 = 9.0;

pub(super) struct Entry {
    pub(super) text: String,
    /// Colour of the text.
    colour: Rgb,
    /// Style of the sample, and whether its marker is hollow; a heading has no sample.
    sample: Option<(Style, bool)>,
    /// Width of the line in the sample; 0 for a marker alone.
    width: f64,
}

impl Entry {
    pub(super) fn heading(text: &str, colour: Rgb) -> Self {
        Self { text: text.into(), colour, sample: None, width: 0.0 }
    }

    pub(super) fn line(text: &str, style: Style) -> Self {
        Self { text: text.into(), colour: INK, sample: Some((style, false)), width: 1.6 }
    }

    /// A hollow marker on a line.
    pub(super) fn hollow(text: &str, style: Style) -> Self {
        Self { sample: Some((style, true)), ..Self::line(text, style) }
    }

    /// A full marker without a line.
    pub(super) fn mark(text: &str, style: Style) -> Self {
        Self { width: 0.0, ..Self::line(text, style) }
    }

    /// A hollow marker without a line.
    pub(super) fn point(text: &str, style: Style) -> Self {
        Self { sample: Some((style, true)), ..Self::mark(text, style) }
    }

    /// A band of colour, for a range.
    pub(super) fn band(text: &str, colour: Rgb) -> Self {
        let style = Style { colour, dash: &[], marker: None };
        Self { width: 0.8 * SMALL, ..Self::line(text, style) }
    }

    fn indent(&self) -> f64 {
        if self.sample.is_some() { SAMPLE + GAP } else { 0.0 }
    }

    /// Draws the entry with its first line centred on `y`.
    fn draw(&self, canvas: &mut Canvas, x: f64, y: f64, size: f64, lines: &[String]) {
        if let Some((style, hollow)) = self.sample {
            if self.width > 0.0 {
                canvas.line(&[(x, y), (x + SAMPLE, y)], style.colour, self.width, style.dash);
            }
            mark(canvas, &style, (x + SAMPLE / 2.0, y), hollow);
        }
        for (k, line) in lines.iter().enumerate() {
            let at = (x + self.indent(), y + k as f64 * 1.3 * size);
            canvas.text(line, at, size, self.colour, (0.0, 0.5));
        }
    }
}

/// Draws a legend in a column at the right of an area, and returns the rest of the area.
///
/// The column is as wide as its entries need, up to a third of the area. Wider entries are broken
/// into lines, and if the column is higher than the area the letters shrink.
pub(super) fn beside(canvas: &mut Canvas, area: Rect, entries: &[Entry]) -> Result<Rect, Error> {
    let mut size = SMALL;
    loop {
        let needed = entries.iter().map(|e| e.indent() + text_width(&e.text, size)).fold(0.0, f64::max);
        let width = (needed + 1.0).min(area.width() / 3.0);
        let blocks: Vec<_> = entries.iter().map(|e| wrap(&e.text, size, width - e.indent())).collect();
        let heights: Vec<f64> = blocks.iter().map(|lines| (lines.len().max(1) as f64 * 1.3 + 0.1) * size).collect();
        let gaps: Vec<f64> = entries.iter().map(|e| if e.sample.is_none() { 0.55 * size } else { 0.0 }).collect();
        if heights.iter().chain(gaps.iter().skip(1)).sum::<f64>() > area.height() {
            size -= 0.5;
            if size < SMALLEST {
                return Err(Error(format!("a legend of {} entries does not fit the figure", entries.len())));
            }
            continue;
        }
        let (left, mut y) = (area.x1 - width, area.y0);
        for (k, entry) in entries.iter().enumerate() {
            y += if k > 0 { gaps[k] } else { 0.0 };
            entry.draw(canvas, left, y + 0.65 * size, size, &blocks[k]);
            y += heights[k];
        }
        return Ok(Rect { x1: left - 12.0, ..area });
    }
}

/// Draws a legend in rows at the top of an area, aligned with the axes below, and returns the rest
/// of the area.
pub(super) fn above(canvas: &mut Canvas, area: Rect, entries: &[Entry]) -> Result<Rect, Error> {
    let start = area.x0 + LEFT;
    let (mut x, mut y, mut row) = (start, area.y0, 0.0_f64);
    for entry in entries {
        let lines = wrap(&entry.text, SMALL, area.x1 - start - entry.indent());
        let text = lines.iter().map(|line| text_width(line, SMALL)).fold(0.0, f64::max);
        let width = entry.indent() + text + 2.0 * GAP;
        if x > start && x + width > area.x1 {
            (x, y, row) = (start, y + row, 0.0);
        }
        entry.draw(canvas, x, y + 0.7 * SMALL, SMALL, &lines);
        x += width;
        row = row.max((lines.len().max(1) as f64 * 1.3 + 0.2) * SMALL);
    }
    let rest = Rect { y0: y + row + 4.0, ..area };
    if rest.height() < 120.0 {
        return Err(Error(format!("a legend of {} entries does not fit the figure", entries.len())));
    }
    Ok(rest)
}
