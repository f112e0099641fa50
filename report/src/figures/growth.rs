//! Maps of growth rates, with lines and points.

use super::GrowthMap;
use super::axes::{Axes, Axis, mark};
use super::canvas::{Canvas, Error, Rect, usable};
use super::colour_bar::{ColourBar, range_with_zero};
use super::legend::{self, Entry};
use super::palette::{self, Marker, Rgb, Style};
use super::space_time::largest;

/// Draws a map with its colour bar and a legend above it; refuses one without cells or with an
/// incomplete row.
pub(super) fn draw(canvas: &mut Canvas, area: Rect, map: &GrowthMap) -> Result<(), Error> {
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
