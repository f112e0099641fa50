//! Strain profiles: the chain at one moment.

use super::axes::{Axes, Axis, mark};
use super::canvas::Rect;
use super::legend::{self, Entry};
use super::palette::Style;
use super::{Error, Line, page, usable};

/// Points above which markers would only blacken the line.
const MARKED: usize = 200;

/// One pair of axes of a strain profile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// Label of the ordinate, such as “strain xₙ”.
    pub label: String,
    /// Up to three lines over the sites: the first, squares, for what was computed; then stars and crosses.
    pub lines: Vec<Line>,
}

/// A strain profile of one panel or two, one above the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Profile {
    /// Title above the axes.
    pub title: String,
    /// Label of the abscissa, such as “site n”.
    pub site_label: String,
    /// One panel, or two.
    pub panels: Vec<Panel>,
    /// What a reader needs to make the figure again.
    pub caption: String,
}

/// Draws a strain profile; all panels share the range of the sites.
///
/// Lines of more than 200 points are drawn without markers.
///
/// # Errors
///
/// No panel or more than two, a panel without lines or with more than three, no point that can be drawn, a letter the
/// font lacks, or more text than fits.
pub fn profile(figure: &Profile) -> Result<Vec<u8>, Error> {
    if !(1..=2).contains(&figure.panels.len()) || figure.panels.iter().any(|p| !(1..=3).contains(&p.lines.len())) {
        return Err(Error("a strain profile has one or two panels of one to three lines".into()));
    }
    let points = |panel: &Panel| {
        let all: Vec<_> = panel.lines.iter().flat_map(|line| &line.points).copied().collect();
        all.into_iter().filter(|point| usable(point.0) && usable(point.1))
    };
    if figure.panels.iter().any(|panel| points(panel).next().is_none()) {
        return Err(Error("each panel of a strain profile needs a finite point".into()));
    }

    let (mut canvas, body) = page(&figure.title, &figure.caption)?;
    let height = body.height() / figure.panels.len() as f64;
    for (k, panel) in figure.panels.iter().enumerate() {
        let top = body.y0 + k as f64 * height;
        let area = Rect { y0: top, y1: top + height - 6.0, ..body };
        let styled: Vec<_> =
            panel.lines.iter().enumerate().map(|(nth, line)| (line, style(nth, line.points.len()))).collect();
        let entries: Vec<_> = styled.iter().map(|(line, style)| Entry::line(&line.name, *style)).collect();
        let area = legend::above(&mut canvas, area, &entries)?;

        let x = Axis::whole(figure.panels.iter().flat_map(points).map(|point| point.0));
        let y = Axis::linear(points(panel).map(|point| point.1), 0.06);
        let axes = Axes::draw(&mut canvas, area, (x, &figure.site_label), (y, &panel.label), true)?;
        for (line, style) in &styled {
            axes.join(&mut canvas, &line.points, style)?;
            for at in line.points.iter().filter_map(|&point| axes.place(point)) {
                mark(&mut canvas, style, at, false)?;
            }
        }
    }
    canvas.png(&figure.caption)
}

fn style(nth: usize, points: usize) -> Style {
    let marked = Style::of_profile(nth);
    if points > MARKED { Style { marker: None, ..marked } } else { marked }
}
