//! A matrix of cells: a positive number for each named row and each named column, with logarithmic
//! colours.

use super::Matrix;
use super::axes::Axis;
use super::canvas::{Canvas, Error, LABEL, Picture, Rect, SIZE, SMALL, page, text_width};
use super::colour_bar::{ColourBar, positive_range};
use super::maps::legible;
use super::palette::{self, INK};

/// Height of a row, and height of everything besides rows, in pixels.
const ROW: f64 = 23.0;
const AROUND: f64 = 280.0;
/// Size of the notes in cells, in pixels per em.
const NOTE: f64 = 13.0;

/// Draws a matrix; the number of rows determines the height of the page.
///
/// # Errors
///
/// No cell, another number of values or notes than cells, or more text than fits.
pub fn matrix(figure: &Matrix) -> Result<Picture, Error> {
    let Matrix { title, rows, columns, labels: [column_label, value_label], values, notes, caption } = figure;
    let cells = rows.len() * columns.len();
    if cells == 0 || values.len() != cells || notes.len() != cells {
        return Err(Error(format!("{} values and {} notes for {cells} cells", values.len(), notes.len())));
    }
    let widest = |names: &[String]| names.iter().map(|name| text_width(name, SMALL)).fold(0.0, f64::max);
    let height = (AROUND + widest(columns) + ROW * rows.len() as f64).max(0.6 * f64::from(SIZE.1));
    let (mut canvas, body) = page((SIZE.0, height as u32), title, caption)?;

    let (lo, hi) = positive_range(values.iter().copied());
    let shades = Axis::exact_log(lo, hi);
    let colour = |value: f64| shades.place(value).map_or(palette::ABSENT, palette::magnitude);

    let bar = ColourBar::along(Axis::exact_log(lo, hi), value_label, body.height());
    let Rect { x0, x1, y0, y1 } = bar.beside(body);
    let below = widest(columns) + 1.6 * LABEL + 20.0;
    let frame = Rect { x0: x0 + widest(rows) + 10.0, x1, y0, y1: y1 - below };
    let (wide, high) = (frame.width() / columns.len() as f64, frame.height() / rows.len() as f64);
    for (k, (&value, note)) in values.iter().zip(notes).enumerate() {
        let (left, top) = (frame.x0 + (k % columns.len()) as f64 * wide, frame.y0 + (k / columns.len()) as f64 * high);
        canvas.rect(&Rect { x0: left, x1: left + wide, y0: top, y1: top + high }, colour(value));
        let middle = (left + 0.5 * wide, top + 0.5 * high);
        canvas.text(note, middle, NOTE, legible(colour(value)), (0.5, 0.5));
    }
    name(&mut canvas, &frame, rows, columns);
    let middle = 0.5 * (frame.x0 + frame.x1);
    canvas.text(column_label, (middle, y1 - 0.4 * LABEL), LABEL, INK, (0.5, 1.0));
    canvas.border(&frame, INK);
    bar.draw(&mut canvas, frame, body.x1, colour);
    Ok(canvas.picture(caption))
}

fn name(canvas: &mut Canvas, frame: &Rect, rows: &[String], columns: &[String]) {
    let (wide, high) = (frame.width() / columns.len() as f64, frame.height() / rows.len() as f64);
    for (k, row) in rows.iter().enumerate() {
        let at = (frame.x0 - 8.0, frame.y0 + (k as f64 + 0.5) * high);
        canvas.text(row, at, SMALL, INK, (1.0, 0.5));
    }
    for (k, column) in columns.iter().enumerate() {
        let at = (frame.x0 + (k as f64 + 0.5) * wide, frame.y1 + 8.0);
        canvas.text_upwards(column, at, SMALL, INK, (1.0, 0.5));
    }
}
