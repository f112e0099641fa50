//! Panels: pairs of axes in columns, with values against site, time or a parameter; a column may
//! also hold maps.

use super::axes::{Axes, Axis, LEFT, MARKER, mark_of};
use super::canvas::{Canvas, Error, LABEL, Picture, Rect, SIZE, SMALL, page, usable};
use super::legend::{self, Entry};
use super::palette::{GREY, INK, Style};
use super::{Column, Kind, Line, Panel, Panels, Plot, growth, maps, space_time};
use crate::numerics::extremes;
use std::f64::consts::TAU;

/// Largest number of points of a line with markers.
const MARKED: usize = 200;
/// Largest number of points of a dashed line.
const DENSE: usize = 500;
/// Height of a panel with a cloud of points, in rows.
const HIGH: f64 = 1.7;
/// Radii of the markers of a cloud, and of one of so many points that larger ones would cover it,
/// in pixels.
const CLOUD: [f64; 2] = [2.4, 1.5];
/// Most points of a cloud with larger markers, in the complex plane and elsewhere.
const FEW: [usize; 2] = [5, 12];
/// Least half width of the part of the complex plane that is shown, about the unit circle.
const PLANE: f64 = 1.15;
/// Height in pixels that the page gains for each row of panels above two.
const ROW: f64 = 230.0;

impl Kind {
    fn log_abscissa(self) -> bool {
        matches!(self, Self::LogLog | Self::LogCloud)
    }

    fn log_ordinate(self) -> bool {
        matches!(self, Self::LogTime | Self::LogLog | Self::LogParameter)
    }

    fn cloud(self) -> bool {
        matches!(self, Self::Cloud | Self::LogCloud | Self::Plane)
    }
}

impl Column {
    fn height(&self) -> f64 {
        self.panels.iter().map(Plot::height).sum()
    }
}

impl Plot {
    /// Height in rows of panels.
    fn height(&self) -> f64 {
        match self {
            Self::Panel(panel) if panel.kind.cloud() => HIGH,
            _ => 1.0,
        }
    }

    fn panel(&self) -> Option<&Panel> {
        if let Self::Panel(panel) = self { Some(panel) } else { None }
    }
}

impl Panel {
    /// All points that the axes can show.
    fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        let lines = self.lines.iter().flat_map(|line| &line.points).copied();
        let shown = |&(x, y): &(f64, f64)| {
            let places = (x > 0.0 || !self.kind.log_abscissa()) && (y > 0.0 || !self.kind.log_ordinate());
            usable(x) && usable(y) && places
        };
        lines.filter(shown)
    }

    /// The styles of the lines: dense ones look alike in all panels that have lines of these names.
    fn styles<'a>(&self, all: impl Iterator<Item = &'a Panel>) -> Vec<Style> {
        let names = |panel: &Panel| panel.lines.iter().map(|line| line.name.clone()).collect::<Vec<_>>();
        let like: Vec<&Panel> = all.filter(|other| names(other) == names(self)).collect();
        let most = |nth: usize| like.iter().filter_map(|panel| Some(panel.lines.get(nth)?.points.len())).max();
        let named = |nth: usize| self.lines.get(nth).and_then(|line| Style::of_method(&line.name));
        let style = |nth| {
            let most = most(nth).unwrap_or(0);
            let style = named(nth).unwrap_or_else(|| self.style(nth, most));
            let law = self.lines.get(nth).is_some_and(|line| line.law);
            let marked = !law && (most <= MARKED || self.kind.cloud());
            Style { marker: style.marker.filter(|_| marked), ..style }
        };
        (0..self.lines.len()).map(style).collect()
    }

    fn style(&self, nth: usize, most: usize) -> Style {
        match most {
            _ if self.kind.cloud() => Style::of_family(nth, nth),
            ..=MARKED if self.kind == Kind::Sites => Style::of_profile(nth),
            ..=MARKED if matches!(self.kind, Kind::LogLog | Kind::Parameter | Kind::LogParameter) => {
                Style::of_family(nth, nth)
            }
            ..=DENSE => Style::plain(nth),
            _ => Style::dense(nth),
        }
    }

    fn abscissa(&self, points: impl Iterator<Item = (f64, f64)>) -> Axis {
        let values = points.map(|point| point.0);
        match self.kind {
            Kind::Sites => Axis::whole(values),
            Kind::Time | Kind::LogTime => Axis::linear(values, 0.0),
            Kind::Parameter | Kind::LogParameter | Kind::Cloud => Axis::linear(values, 0.02),
            Kind::LogLog => Axis::log(values),
            Kind::LogCloud => {
                let (low, high) = extremes(values);
                Axis::exact_log(low / 1.05, high * 1.05)
            }
            Kind::Plane => Axis::linear(values.chain([-PLANE, PLANE]), 0.03),
        }
    }

    fn ordinate(&self) -> Axis {
        let values = self.points().map(|point| point.1);
        match self.kind {
            kind if kind.log_ordinate() => Axis::log(values),
            Kind::Plane => Axis::linear(values.chain([-PLANE, PLANE]), 0.03),
            _ => Axis::linear(values, 0.06),
        }
    }
}

/// Draws panels; the page of more than two rows is higher than [`SIZE`].
///
/// # Errors
///
/// No column, a column without panels, a panel without a point that its axes can show, a map with
/// another number of values than cells, or more text than fits.
pub fn panels(figure: &Panels) -> Result<Picture, Error> {
    let rows = figure.columns.iter().map(Column::height).fold(2.0, f64::max);
    if figure.columns.is_empty() || figure.columns.iter().any(|column| column.panels.is_empty()) {
        return Err(Error("a figure of panels has a column, and each column a panel".into()));
    }
    let all = || figure.columns.iter().flat_map(|column| &column.panels).filter_map(Plot::panel);
    if all().any(|panel| panel.points().next().is_none()) {
        return Err(Error("each panel needs a point that its axes can show".into()));
    }

    let size = (SIZE.0, SIZE.1 + ((rows - 2.0) * ROW) as u32);
    let (mut canvas, mut body) = page(size, &figure.title, &figure.caption)?;
    let width = body.width() / figure.columns.len() as f64;
    let headed = figure.columns.iter().any(|column| !column.heading.is_empty());
    let headings = body.y0 + 4.0;
    body.y0 += if headed { 1.8 * LABEL } else { 0.0 };
    for (k, column) in figure.columns.iter().enumerate() {
        let left = body.x0 + k as f64 * width;
        let area = Rect { x0: left, x1: left + width, ..body };
        let middle = 0.5 * (area.x0 + LEFT + area.x1);
        canvas.text(&column.heading, (middle, headings), LABEL, INK, (0.5, 0.0));
        let mut top = area.y0;
        for plot in &column.panels {
            let height = area.height() * plot.height() / column.height();
            let area = Rect { y0: top, y1: top + height - 6.0, ..area };
            let of_map = Rect { x1: area.x1 - 12.0, ..area };
            match plot {
                Plot::SpaceTime(map) => space_time::draw(&mut canvas, of_map, map)?,
                Plot::CellMap(map) => maps::draw(&mut canvas, of_map, map)?,
                Plot::GrowthMap(map) => growth::draw(&mut canvas, of_map, map)?,
                Plot::Panel(panel) => {
                    let scale = |panel: &Panel| (panel.kind.log_abscissa(), panel.x_label.clone());
                    let like = |other: &&Panel| scale(other) == scale(panel);
                    let same = || column.panels.iter().filter_map(Plot::panel).filter(like);
                    let first = same().next().unwrap_or(panel);
                    let x = first.abscissa(same().flat_map(Panel::points));
                    draw(&mut canvas, area, panel, x, &panel.styles(all()))?;
                }
            }
            top += height;
        }
    }
    Ok(canvas.picture(&figure.caption))
}

fn draw(canvas: &mut Canvas, area: Rect, panel: &Panel, x: Axis, styles: &[Style]) -> Result<(), Error> {
    let cloud = panel.kind.cloud();
    // A cloud of points is not joined, but for laws.
    let lines = panel.lines.iter().zip(styles).map(|(line, &style)| (line, style, cloud && !line.law));
    // Beside a law values are hollow, so that all are seen where they meet.
    let hollow = cloud && panel.lines.iter().any(|line| line.law);
    let entry = |(line, style, apart): (&Line, Style, bool)| match apart {
        true if hollow => Entry::point(&line.name, style),
        true => Entry::mark(&line.name, style),
        false => Entry::line(&line.name, style),
    };
    // A cloud without points has no entry in the legend.
    let named = lines.clone().filter(|(line, _, apart)| !(*apart && line.points.is_empty()));
    let area = titled(canvas, area, &panel.title);
    let mut entries: Vec<_> = named.map(entry).collect();
    let marked = Style { colour: GREY, dash: &[6.0, 4.0], marker: None };
    entries.extend(panel.mark.iter().map(|(name, _)| Entry::line(name, marked)));
    let area = legend::above(canvas, area, &entries)?;
    let (x, y) = ((x, panel.x_label.as_str()), (panel.ordinate(), panel.y_label.as_str()));
    let axes = if panel.kind == Kind::Plane {
        let axes = Axes::draw_from(canvas, area, x, y, true, true)?;
        let circle: Vec<_> = (0..=360).map(|k| (TAU * f64::from(k) / 360.0).sin_cos()).collect();
        axes.join(canvas, &circle, &Style { colour: GREY, dash: &[], marker: None });
        axes
    } else {
        Axes::draw(canvas, area, x, y, true)?
    };
    let places = panel.mark.iter().flat_map(|(_, places)| places).filter_map(|&x| axes.place((x, axes.middle())));
    for (x, _) in places.filter(|(x, _)| (axes.frame.x0..=axes.frame.x1).contains(x)) {
        canvas.line(&[(x, axes.frame.y0), (x, axes.frame.y1)], GREY, 1.4, marked.dash);
    }
    // Outside the plane all markers are small if those of one cloud are many.
    let most = panel.lines.iter().filter(|line| !line.law).map(|line| line.points.len()).max().unwrap_or(0);
    for (line, style, apart) in lines {
        if !apart {
            axes.join(canvas, &line.points, &style);
        }
        let few = if panel.kind == Kind::Plane { line.points.len() <= FEW[0] } else { most <= FEW[1] };
        let radius = if few || !cloud { MARKER } else { CLOUD[usize::from(line.points.len() > DENSE)] };
        for at in line.points.iter().filter_map(|&point| axes.place(point)) {
            mark_of(canvas, &style, at, hollow, radius);
        }
    }
    axes.close(canvas);
    Ok(())
}

/// Draws a title over axes, and returns the rest of the area.
fn titled(canvas: &mut Canvas, area: Rect, title: &str) -> Rect {
    if title.is_empty() {
        return area;
    }
    canvas.text(title, (0.5 * (area.x0 + LEFT + area.x1), area.y0), SMALL, INK, (0.5, 0.0));
    Rect { y0: area.y0 + 1.5 * SMALL, ..area }
}
