//! Time series: energies, or their relative errors, as a run goes on.

use super::axes::{Axes, Axis};
use super::legend::{self, Entry};
use super::palette::Style;
use super::{Error, Line, page, usable};

/// Quantities against time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimeSeries {
    /// Title above the axes.
    pub title: String,
    /// Label of the abscissa, with its unit.
    pub time_label: String,
    /// Label of the ordinate.
    pub value_label: String,
    /// Whether the ordinate is logarithmic; zeros and negative values then leave a gap.
    pub log: bool,
    /// The quantities.
    pub lines: Vec<Line>,
    /// What a reader needs to make the figure again.
    pub caption: String,
}

/// Draws quantities against time, with the legend above the axes.
///
/// # Errors
///
/// No point that can be drawn, a letter the font lacks, or more text than fits.
pub fn series(figure: &TimeSeries) -> Result<Vec<u8>, Error> {
    let points = || {
        let all = figure.lines.iter().flat_map(|line| &line.points).copied();
        all.filter(|&(t, value)| usable(t) && usable(value) && (value > 0.0 || !figure.log))
    };
    if points().next().is_none() {
        return Err(Error("a time series needs a point that its axes can show".into()));
    }

    let (mut canvas, body) = page(&figure.title, &figure.caption)?;
    let entries: Vec<_> =
        figure.lines.iter().enumerate().map(|(nth, line)| Entry::line(&line.name, Style::plain(nth))).collect();
    let body = legend::above(&mut canvas, body, &entries)?;
    let x = Axis::linear(points().map(|point| point.0), 0.0);
    let values = points().map(|point| point.1);
    let y = if figure.log { Axis::log(values) } else { Axis::linear(values, 0.06) };
    let axes = Axes::draw(&mut canvas, body, (x, &figure.time_label), (y, &figure.value_label), true)?;
    for (nth, line) in figure.lines.iter().enumerate() {
        axes.join(&mut canvas, &line.points, &Style::plain(nth))?;
    }
    canvas.png(&figure.caption)
}
