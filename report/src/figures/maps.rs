//! Maps of cells: a positive number for each pair of two positive parameters, with logarithmic axes
//! and colours.

use super::CellMap;
use super::axes::{Axes, Axis};
use super::canvas::{Canvas, Error, Rect, SMALL, text_width, usable};
use super::colour_bar::{ColourBar, positive_range};
use super::legend::{self, Entry};
use super::palette::{self, INK, PAPER, Rgb, Style};

/// Position of the note in a cell, as a share of its height from the top: lines often run through
/// the middle of a cell, or through its corners.
const NOTE: f64 = 0.75;
/// Least brightness of a colour on which letters are dark.
const BRIGHT: f64 = 130.0;

/// Draws a map with its colour bar; refuses another number of values or notes than cells, and
/// parameters that are not positive and increasing.
pub(super) fn draw(canvas: &mut Canvas, area: Rect, map: &CellMap) -> Result<(), Error> {
    let cells = map.x.len() * map.y.len();
    if map.values.len() != cells || map.notes.len() != cells {
        return Err(Error(format!("{} values and {} notes for {cells} cells", map.values.len(), map.notes.len())));
    }
    let (x_edges, y_edges) = (edges(&map.x)?, edges(&map.y)?);
    let kind = |k: usize| map.apart.iter().position(|(_, cells)| cells.contains(&k));
    let on_scale = (0..cells).filter(|&k| kind(k).is_none()).map(|k| map.values[k]);
    let (lo, hi) = positive_range(on_scale);
    let shades = Axis::exact_log(lo, hi);
    let colour = |value: f64| shades.place(value).map_or(palette::ABSENT, palette::magnitude);
    let of_kind = |nth: usize| palette::APART[nth % palette::APART.len()];

    let style = |nth: usize| Style { colour: INK, ..Style::plain(nth) };
    let lines = map.lines.iter().enumerate().map(|(nth, line)| Entry::line(&line.name, style(nth)));
    let kinds = map.apart.iter().enumerate().filter(|(_, (_, cells))| !cells.is_empty());
    let kinds = kinds.map(|(nth, (name, _))| Entry::band(name, of_kind(nth)));
    let entries: Vec<_> = lines.chain(kinds).collect();
    let area = legend::above(canvas, area, &entries)?;
    let [x_label, y_label, value_label] = &map.labels;
    let bar = ColourBar::along(Axis::exact_log(lo, hi), value_label, area.height());
    let axis = |edges: &[f64], values: &[f64]| Axis::of_cells(edges[0], edges[edges.len() - 1], values);
    let (x, y) = (axis(&x_edges, &map.x), axis(&y_edges, &map.y));
    let axes = Axes::draw(canvas, bar.beside(area), (x, x_label), (y, y_label), false)?;
    // Lines pass through the middle of cells.
    let note_at = if map.lines.is_empty() { 0.5 } else { NOTE };
    let mut places = Vec::with_capacity(cells);
    for (k, (&value, note)) in map.values.iter().zip(&map.notes).enumerate() {
        let (column, row) = (k % map.x.len(), k / map.x.len());
        let corners =
            axes.place((x_edges[column], y_edges[row])).zip(axes.place((x_edges[column + 1], y_edges[row + 1])));
        let Some(((x0, y1), (x1, y0))) = corners else { continue };
        let colour = kind(k).map_or_else(|| colour(value), of_kind);
        canvas.rect(&Rect { x0, x1, y0, y1 }, colour);
        places.push(((0.5 * (x0 + x1), y0 + note_at * (y1 - y0)), colour, note));
    }
    for (nth, line) in map.lines.iter().enumerate() {
        axes.join_over(canvas, &line.points, style(nth).dash);
    }
    // Notes are drawn over the lines.
    for ((x, y), colour, note) in places.into_iter().filter(|place| !place.2.is_empty()) {
        let (wide, high) = (0.5 * text_width(note, SMALL) + 1.0, 0.6 * SMALL);
        canvas.rect(&Rect { x0: x - wide, x1: x + wide, y0: y - high, y1: y + high }, colour);
        canvas.text(note, (x, y), SMALL, legible(colour), (0.5, 0.5));
    }
    axes.close(canvas);
    bar.draw(canvas, axes.frame, area.x1, colour);
    Ok(())
}

/// The edges of cells around values.
pub fn edges(values: &[f64]) -> Result<Vec<f64>, Error> {
    let ascending = values.windows(2).all(|two| two[0] < two[1]);
    let (Some(&first), Some(&last)) = (values.first(), values.last()) else {
        return Err(Error("a map needs a cell".into()));
    };
    if !(ascending && first > 0.0 && usable(last)) {
        return Err(Error("the parameters of a map are positive and ascending".into()));
    }
    let ratio = |k: usize| if values.len() > 1 { (values[k + 1] / values[k]).sqrt() } else { 10_f64.sqrt() };
    let between = values.windows(2).map(|two| two[0].sqrt() * two[1].sqrt());
    let end = last * ratio(values.len().saturating_sub(2));
    Ok(std::iter::once(first / ratio(0)).chain(between).chain([end]).collect())
}

/// The colour of letters that can be read on a given colour.
pub(super) fn legible((r, g, b): Rgb) -> Rgb {
    let brightness = 0.299 * f64::from(r) + 0.587 * f64::from(g) + 0.114 * f64::from(b);
    if brightness > BRIGHT { INK } else { PAPER }
}
