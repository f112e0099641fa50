//! Growth rates: curves with measured points, and a map beside them.

use super::Picture;
use super::axes::{Axes, Axis, mark};
use super::canvas::{Canvas, Rect};
use super::colour_bar::{ColourBar, range_with_zero};
use super::legend::{self, Entry};
use super::palette::{self, Marker, Rgb, Style};
use super::space_time::largest;
use super::{Error, Growth, GrowthMap, page, usable};

/// Draws the curve at the left and the map, if there is one, at the right, with a legend above
/// each.
///
/// # Errors
///
/// No point of the theory that can be drawn, a map without cells or with an incomplete row, or
/// more text than fits.
pub fn growth(figure: &Growth) -> Result<Picture, Error> {
    let (mut canvas, body) = page(&figure.title, &figure.caption)?;
    let middle = 0.5 * (body.x0 + body.x1);
    let left = if figure.map.is_some() { Rect { x1: middle - 24.0, ..body } } else { body };
    curves(&mut canvas, left, figure)?;
    if let Some(map) = &figure.map {
        draw_map(&mut canvas, Rect { x0: middle, ..body }, map)?;
    }
    Ok(canvas.picture(&figure.caption))
}

fn curves(canvas: &mut Canvas, area: Rect, figure: &Growth) -> Result<(), Error> {
    let lines = || std::iter::once(&figure.theory).chain(&figure.measured);
    let points = || lines().flat_map(|line| &line.points).filter(|point| usable(point.0) && usable(point.1));
    if !figure.theory.points.iter().any(|point| usable(point.0) && usable(point.1)) {
        return Err(Error("a figure of growth needs a point of theory that its axes can show".into()));
    }
    let theory = Style { colour: palette::INK, dash: &[], marker: None };
    let styles = (0..figure.measured.len()).map(|nth| Style::of_family(nth, nth)).collect::<Vec<_>>();
    let measured = figure.measured.iter().zip(&styles);
    let mut entries = vec![Entry::line(&figure.theory.name, theory)];
    entries.extend(measured.clone().map(|(line, style)| Entry::point(&line.name, *style)));
    let area = legend::above(canvas, area, &entries)?;
    let x = Axis::linear(points().map(|point| point.0), 0.0);
    let y = Axis::linear(points().map(|point| point.1).chain([0.0]), 0.06);
    let axes = Axes::draw(canvas, area, (x, &figure.wave_label), (y, &figure.growth_label), true)?;
    axes.join(canvas, &figure.theory.points, &theory);
    for (line, style) in measured {
        for at in line.points.iter().filter_map(|&point| axes.place(point)) {
            mark(canvas, style, at, true);
        }
    }
    Ok(())
}

fn draw_map(canvas: &mut Canvas, area: Rect, map: &GrowthMap) -> Result<(), Error> {
    if map.columns == 0 || map.values.is_empty() || !map.values.len().is_multiple_of(map.columns) {
        return Err(Error(format!("{} values are no map with rows of {} cells", map.values.len(), map.columns)));
    }
    let (lo, hi) = range_with_zero(map.values.iter().copied());
    let colour = |value: f64| -> Rgb {
        if usable(value) { palette::magnitude((value - lo) / (hi - lo)) } else { palette::ABSENT }
    };
    let over = |nth: usize| Style { colour: palette::INK, ..Style::plain(nth) };
    let dots = Style { colour: palette::family(1), dash: &[], marker: Some(Marker::Circle) };
    let lines = map.lines.iter().enumerate();
    let mut entries: Vec<_> = lines.clone().map(|(nth, line)| Entry::line(&line.name, over(nth))).collect();
    if !map.points.points.is_empty() {
        entries.push(Entry::point(&map.points.name, dots));
    }
    let area = legend::above(canvas, area, &entries)?;
    let [x_label, y_label, value_label] = &map.labels;
    let bar = ColourBar::new((lo, hi), value_label, area.height());
    let x = Axis::exact(map.x.0, map.x.1, false);
    let y = Axis::exact(map.y.0, map.y.1, false);
    let axes = Axes::draw(canvas, bar.beside(area), (x, x_label), (y, y_label), false)?;
    let (wide, high) = (axes.frame.width() as usize, axes.frame.height() as usize);
    let pixels: Vec<Rgb> = largest(&map.values, map.columns, (wide, high)).into_iter().map(colour).collect();
    axes.image(canvas, pixels);
    for (nth, line) in lines {
        axes.join_over(canvas, &line.points, over(nth).dash);
    }
    for at in map.points.points.iter().filter_map(|&point| axes.place(point)) {
        mark(canvas, &dots, at, true);
    }
    axes.close(canvas);
    bar.draw(canvas, axes.frame, area.x1, colour);
    Ok(())
}
