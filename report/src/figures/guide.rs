//! Guides: straight lines on logarithmic axes with a slope that stands for an order.

use super::Error;
use super::axes::Axes;
use super::canvas::{Canvas, Rect, SMALL, text_width};
use super::palette::{GREY, PAPER};

type Position = (f64, f64);

/// Draws the line `ordinate ~ abscissa^(-order)` through a point, with its label on the line.
///
/// The label is placed farthest from the places in `avoid`, and its place is added to them. Without
/// a place on the axes nothing is drawn. Curves drawn later cover the guide.
pub(super) fn draw(
    canvas: &mut Canvas,
    axes: &Axes,
    (x, y): (f64, f64),
    (order, label): (f64, &str),
    avoid: &mut Vec<Position>,
) -> Result<(), Error> {
    let step = 1.01_f64;
    let (Some(p), Some(q)) = (axes.place((x, y)), axes.place((x * step, y * step.powf(-order)))) else {
        return Ok(());
    };
    let [start, end] = chord(&axes.frame, p, q);
    canvas.line(&[start, end], GREY, 1.0, &[6.0, 4.0]);

    let (width, height) = (text_width(label, SMALL) + 8.0, 1.4 * SMALL);
    let along = |k: u32| f64::from(k) / 40.0;
    let places = (0..=40).map(along).map(|s| (start.0 + s * (end.0 - start.0), start.1 + s * (end.1 - start.1)));
    let around = |(x, y): Position| Rect {
        x0: x - 0.5 * width,
        y0: y - 0.5 * height,
        x1: x + 0.5 * width,
        y1: y + 0.5 * height,
    };
    let inside = |at: &Position| {
        let (label, frame) = (around(*at), &axes.frame);
        label.x0 > frame.x0 && label.x1 < frame.x1 && label.y0 > frame.y0 && label.y1 < frame.y1
    };
    let free = |at: &Position| avoid.iter().map(|&other| distance(&around(*at), other)).fold(f64::INFINITY, f64::min);
    let Some(at) = places.filter(inside).max_by(|a, b| free(a).total_cmp(&free(b))) else {
        return Err(Error(format!("the label {label:?} does not fit the axes")));
    };
    canvas.rect(&around(at), PAPER);
    canvas.text(label, at, SMALL, GREY, (0.5, 0.5));
    avoid.push(at);
    Ok(())
}

/// The part inside a rectangle of the line through `p`, a point inside, and `q`.
fn chord(area: &Rect, p: Position, q: Position) -> [Position; 2] {
    let (dx, dy) = (q.0 - p.0, q.1 - p.1);
    let reach = |d: f64, lo: f64, hi: f64| match d {
        0.0 => (f64::NEG_INFINITY, f64::INFINITY),
        _ => ((lo / d).min(hi / d), (lo / d).max(hi / d)),
    };
    let across = reach(dx, area.x0 - p.0, area.x1 - p.0);
    let up = reach(dy, area.y0 - p.1, area.y1 - p.1);
    [across.0.max(up.0), across.1.min(up.1)].map(|s| (p.0 + s * dx, p.1 + s * dy))
}

/// The distance of a point from a rectangle; 0 inside.
fn distance(area: &Rect, (x, y): Position) -> f64 {
    let outside = |at: f64, lo: f64, hi: f64| (lo - at).max(at - hi).max(0.0);
    outside(x, area.x0, area.x1).hypot(outside(y, area.y0, area.y1))
}
