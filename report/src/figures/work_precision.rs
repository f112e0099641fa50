//! Work-precision diagrams: the error of each method against its cost.

use super::axes::{Axes, Axis, mark, short};
use super::canvas::{Error, Picture, SIZE, page, usable};
use super::legend::{self, Entry};
use super::palette::{self, Style};
use super::{Curve, Point, WorkPrecision};

impl Point {
    /// Whether both numbers can be shown on logarithmic axes.
    fn drawable(&self) -> bool {
        usable(self.work) && usable(self.error) && self.work > 0.0 && self.error > 0.0
    }
}

/// Draws a work-precision diagram with logarithmic axes and the legend at the right.
///
/// Points that are not finite or not positive are left out; the legend says which curves have no
/// other points.
///
/// # Errors
///
/// No point that can be drawn, or more text than fits.
pub fn work_precision(figure: &WorkPrecision) -> Result<Picture, Error> {
    let drawable = || figure.curves.iter().flat_map(|curve| &curve.points).filter(|point| point.drawable());
    if drawable().next().is_none() {
        return Err(Error("a work-precision diagram needs a point with positive finite work and error".into()));
    }
    let floor = figure.floor.filter(|&floor| usable(floor) && floor > 0.0);

    let style = |(nth, curve): (usize, &Curve)| Style::of_method(&curve.name).unwrap_or(Style::of_family(nth, nth));
    let styled: Vec<(&Curve, Style)> = figure.curves.iter().zip(figure.curves.iter().enumerate().map(style)).collect();
    let mut entries = Vec::new();
    for group in styled.chunk_by(|one, next| one.0.group == next.0.group) {
        // The heading has the colour of its curves, if it is one.
        let alike = group.iter().all(|(_, style)| style.colour == group[0].1.colour);
        entries.push(Entry::heading(&group[0].0.group, if alike { group[0].1.colour } else { palette::GREY }));
        for (curve, style) in group {
            let drawn = if curve.points.iter().any(Point::drawable) { "" } else { ", no point" };
            entries.push(Entry::line(&format!("{}{}{drawn}", curve.name, curve.note), *style));
        }
    }
    if floor.is_some() || drawable().any(|point| point.below_reference) {
        entries.push(Entry::heading("Reference", palette::GREY));
    }
    let grey = Style { colour: palette::GREY, dash: &[], marker: None };
    if let Some(floor) = floor {
        entries.push(Entry::line(&format!("its own error, {}", short(floor)), grey));
    }
    if drawable().any(|point| point.below_reference) {
        let hollow = Style { marker: Some(palette::Marker::Circle), ..grey };
        entries.push(Entry::hollow("hollow: not resolved by it", hollow));
    }

    let (mut canvas, body) = page(SIZE, &figure.title, &figure.caption)?;
    let body = legend::beside(&mut canvas, body, &entries)?;
    let x = Axis::log(drawable().map(|point| point.work));
    let y = Axis::log(drawable().map(|point| point.error).chain(floor));
    let axes = Axes::draw(&mut canvas, body, (x, &figure.work_label), (y, &figure.error_label), true)?;
    if let Some((_, at)) = floor.zip(drawable().next()).and_then(|(floor, point)| axes.place((point.work, floor))) {
        canvas.line(&[(axes.frame.x0, at), (axes.frame.x1, at)], palette::GREY, 1.6, &[]);
    }
    for (curve, style) in styled {
        let points: Vec<_> = curve.points.iter().filter(|point| point.drawable()).collect();
        let line: Vec<_> = points.iter().map(|point| (point.work, point.error)).collect();
        axes.join(&mut canvas, &line, &style);
        for (point, at) in points.iter().zip(&line) {
            if let Some(at) = axes.place(*at) {
                mark(&mut canvas, &style, at, point.below_reference);
            }
        }
    }
    Ok(canvas.picture(&figure.caption))
}
