//! Panels: pairs of axes in columns, for whatever stands against sites or against time.

use super::axes::{Axes, Axis, LEFT, mark};
use super::canvas::{Canvas, LABEL, Rect};
use super::legend::{self, Entry};
use super::palette::{self, INK, PAPER, Style};
use super::{Error, Line, SIZE, page_of, usable};

/// Points above which markers would only blacken the line.
const MARKED: usize = 200;
/// Points above which dashes would not show.
const DENSE: usize = 1000;
/// Height of a panel with an inset, relative to others.
const WITH_INSET: f64 = 1.7;
/// Pixels by which the page grows for each row of panels above two.
const ROW: f64 = 230.0;
/// The part of its axes that an inset takes, from the left and from above, with its labels.
const INSET: (f64, f64) = (0.62, 0.46);

/// Columns of panels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panels {
    /// Title above all.
    pub title: String,
    /// The columns, of equal width.
    pub columns: Vec<Column>,
    /// What a reader needs to make the figure again.
    pub caption: String,
}

/// Panels one above the other, of equal height but for those with an inset, which are higher. Those of one kind and one label share the range of their abscissas.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Column {
    /// What the column shows, or nothing.
    pub heading: String,
    /// From above.
    pub panels: Vec<Panel>,
}

/// One pair of axes, with its legend above.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// What the axes are of.
    pub kind: Kind,
    /// Label of the abscissa, such as “site n”.
    pub x_label: String,
    /// Label of the ordinate, such as “strain xₙ”.
    pub y_label: String,
    /// The lines.
    pub lines: Vec<Line>,
    /// Ranges beneath the lines, the n-th in the colour of the n-th line.
    pub bands: Vec<Band>,
    /// A smaller pair of axes in the upper left corner; the ordinate goes on above the data to make room for it.
    pub inset: Option<Inset>,
}

/// What the axes of a panel are of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// Values over sites, whole numbers. Lines of at most 200 points have markers: squares, for what was computed, then stars and crosses.
    #[default]
    Sites,
    /// Values over time.
    Time,
    /// Values over time on a logarithmic ordinate; zeros and negative values leave a gap.
    LogTime,
    /// Both axes logarithmic, each point with a marker; what is not positive leaves a gap.
    LogLog,
}

impl Kind {
    fn log_ordinate(self) -> bool {
        matches!(self, Self::LogTime | Self::LogLog)
    }
}

/// A range at each abscissa.
#[derive(Clone, Debug, PartialEq)]
pub struct Band {
    /// Name in the legend.
    pub name: String,
    /// Abscissa, and the lower and upper end of the range there.
    pub points: Vec<(f64, f64, f64)>,
}

/// An enlargement of one line.
#[derive(Clone, Debug, PartialEq)]
pub struct Inset {
    /// Label of its ordinate.
    pub label: String,
    /// Which line of the panel, counted from 0.
    pub line: usize,
}

impl Panels {
    /// A figure of one column without heading.
    pub fn column(title: impl Into<String>, panels: Vec<Panel>, caption: impl Into<String>) -> Self {
        let column = Column { heading: String::new(), panels };
        Self { title: title.into(), columns: vec![column], caption: caption.into() }
    }
}

impl Column {
    fn height(&self) -> f64 {
        self.panels.iter().map(Panel::height).sum()
    }
}

impl Panel {
    /// All points that the axes can show, ends of ranges included.
    fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        let lines = self.lines.iter().flat_map(|line| &line.points).copied();
        let bands = self.bands.iter().flat_map(|band| &band.points).flat_map(|&(x, low, high)| [(x, low), (x, high)]);
        let shown = |&(x, y): &(f64, f64)| {
            let places = (x > 0.0 || self.kind != Kind::LogLog) && (y > 0.0 || !self.kind.log_ordinate());
            usable(x) && usable(y) && places
        };
        lines.chain(bands).filter(shown)
    }

    fn style(&self, nth: usize) -> Style {
        match self.lines.get(nth).map_or(0, |line| line.points.len()) {
            ..=MARKED if self.kind == Kind::Sites => Style::of_profile(nth),
            ..=MARKED if self.kind == Kind::LogLog => Style::of_family(nth, nth),
            ..=DENSE => Style::plain(nth),
            _ => Style::dense(nth),
        }
    }

    /// In rows of panels.
    fn height(&self) -> f64 {
        if self.inset.is_some() { WITH_INSET } else { 1.0 }
    }

    fn abscissa(&self, points: impl Iterator<Item = (f64, f64)>) -> Axis {
        let values = points.map(|point| point.0);
        match self.kind {
            Kind::Sites => Axis::whole(values),
            Kind::Time | Kind::LogTime => Axis::linear(values, 0.0),
            Kind::LogLog => Axis::log(values),
        }
    }

    /// The ordinate; above an inset's corner it is high enough for the data to pass below it.
    fn ordinate(&self) -> Axis {
        let values = || self.points().map(|point| point.1);
        if self.kind.log_ordinate() {
            return Axis::log(values());
        }
        let Some(_) = self.inset else { return Axis::linear(values(), 0.06) };
        let (low, high) = range(values());
        let (from, to) = range(self.points().map(|point| point.0));
        let corner = self.points().filter(|point| point.0 <= from + INSET.0 * (to - from)).map(|point| point.1);
        let room = (range(corner).1 - low) / (1.0 - INSET.1 - 0.04);
        let top = (low + room).max(high + 0.06 * (high - low));
        Axis::exact(low - 0.02 * (top - low), top, false)
    }
}

/// The least and the largest of usable values.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

/// Draws panels; a page of more than two rows is higher than [`SIZE`].
///
/// # Errors
///
/// No column, a column without panels, a panel without a point that its axes can show, an inset of a line that is not there or on a logarithmic ordinate, a letter
/// the font lacks, or more text than fits.
pub fn panels(figure: &Panels) -> Result<Vec<u8>, Error> {
    let rows = figure.columns.iter().map(Column::height).fold(2.0, f64::max);
    if figure.columns.is_empty() || figure.columns.iter().any(|column| column.panels.is_empty()) {
        return Err(Error("a figure of panels has a column, and each column a panel".into()));
    }
    let all = || figure.columns.iter().flat_map(|column| &column.panels);
    if all().any(|panel| panel.points().next().is_none()) {
        return Err(Error("each panel needs a point that its axes can show".into()));
    }

    let size = (SIZE.0, SIZE.1 + ((rows - 2.0) * ROW) as u32);
    let (mut canvas, mut body) = page_of(size, &figure.title, &figure.caption)?;
    let width = body.width() / figure.columns.len() as f64;
    let headed = figure.columns.iter().any(|column| !column.heading.is_empty());
    let headings = body.y0 + 4.0;
    body.y0 += if headed { 1.8 * LABEL } else { 0.0 };
    for (k, column) in figure.columns.iter().enumerate() {
        let left = body.x0 + k as f64 * width;
        let area = Rect { x0: left, x1: left + width, ..body };
        let middle = 0.5 * (area.x0 + LEFT + area.x1);
        canvas.text(&column.heading, (middle, headings), LABEL, INK, (0.5, 0.0))?;
        let mut top = area.y0;
        for panel in &column.panels {
            let height = area.height() * panel.height() / column.height();
            let same =
                column.panels.iter().filter(|other| (other.kind, &other.x_label) == (panel.kind, &panel.x_label));
            let x = panel.abscissa(same.flat_map(Panel::points));
            draw(&mut canvas, Rect { y0: top, y1: top + height - 6.0, ..area }, panel, x)?;
            top += height;
        }
    }
    canvas.png(&figure.caption)
}

fn draw(canvas: &mut Canvas, area: Rect, panel: &Panel, x: Axis) -> Result<(), Error> {
    let lines = panel.lines.iter().enumerate().map(|(nth, line)| (line, panel.style(nth)));
    let bands = panel.bands.iter().enumerate().map(|(nth, band)| (band, palette::pale(panel.style(nth).colour)));
    let mut entries: Vec<_> = lines.clone().map(|(line, style)| Entry::line(&line.name, style)).collect();
    entries.extend(bands.clone().map(|(band, colour)| Entry::band(&band.name, colour)));
    let area = legend::above(canvas, area, &entries)?;
    let axes = Axes::draw(canvas, area, (x, &panel.x_label), (panel.ordinate(), &panel.y_label), true)?;
    for (band, colour) in bands {
        axes.fill(canvas, &band.points, colour);
    }
    for (line, style) in lines {
        axes.join(canvas, &line.points, &style)?;
        for at in line.points.iter().filter_map(|&point| axes.place(point)) {
            mark(canvas, &style, at, false)?;
        }
    }
    axes.close(canvas)?;
    panel.inset.as_ref().map_or(Ok(()), |inset| draw_inset(canvas, &axes.frame, panel, inset))
}

fn draw_inset(canvas: &mut Canvas, frame: &Rect, panel: &Panel, inset: &Inset) -> Result<(), Error> {
    let Some(line) = panel.lines.get(inset.line).filter(|_| !panel.kind.log_ordinate()) else {
        return Err(Error(format!("no line {} on linear axes for an inset", inset.line)));
    };
    let area = Rect {
        x0: frame.x0 + 6.0,
        x1: frame.x0 + INSET.0 * frame.width(),
        y0: frame.y0 + 6.0,
        y1: frame.y0 + INSET.1 * frame.height(),
    };
    let Rect { x0, x1, y0, y1 } = area;
    canvas.polygon(&[(x0, y0), (x1, y0), (x1, y1), (x0, y1)], PAPER)?;
    let enlarged = Panel { kind: panel.kind, lines: vec![line.clone()], ..Panel::default() };
    let x = (enlarged.abscissa(panel.points()), "");
    let axes = Axes::draw_bare(canvas, area, x, (enlarged.ordinate(), &inset.label))?;
    axes.join(canvas, &line.points, &panel.style(inset.line))?;
    axes.close(canvas)
}
