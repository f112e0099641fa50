//! What a picture shows: numbers, names and labels. `figures` draws it.

/// A named line through points, joined in the given order.
///
/// A point that cannot be drawn (not finite, or not positive on a logarithmic axis) leaves a gap in
/// the line.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Name in the legend.
    pub name: String,
    /// The points (abscissa, ordinate).
    pub points: Vec<(f64, f64)>,
    /// Whether it is a law with which values are compared: it is joined and has no markers.
    pub law: bool,
}

impl Line {
    /// A line through some points.
    pub fn new(name: &str, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { name: name.to_owned(), points: points.into_iter().collect(), law: false }
    }

    /// The law through some points.
    pub fn law(name: &str, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { law: true, ..Self::new(name, points) }
    }

    /// The line over sites with the sign of odd sites changed, `(-1)^n x_n`: what alternates from
    /// site to site becomes its envelope.
    pub fn staggered(mut self) -> Self {
        self.points.iter_mut().filter(|(n, _)| n.rem_euclid(2.0) == 1.0).for_each(|(_, x)| *x = -*x);
        self
    }
}

/// Columns of panels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panels {
    /// Title at the top.
    pub title: String,
    /// The columns, of equal width.
    pub columns: Vec<Column>,
    /// Caption, enough to make the figure again.
    pub caption: String,
}

impl Panels {
    /// A figure of one column without heading.
    pub fn column<P: Into<Plot>>(title: impl Into<String>, panels: Vec<P>, caption: impl Into<String>) -> Self {
        Self { title: title.into(), columns: vec![Column::new("", panels)], caption: caption.into() }
    }
}

/// Panels and maps one above the other.
///
/// All have the same height, except that panels with a cloud of points are higher.
/// Panels with the same kind and the same label of the abscissa share its range.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Column {
    /// Heading of the column; may be empty.
    pub heading: String,
    /// The plots, from the top.
    pub panels: Vec<Plot>,
}

impl Column {
    /// A column of plots of one type.
    pub fn new<P: Into<Plot>>(heading: impl Into<String>, plots: impl IntoIterator<Item = P>) -> Self {
        Self { heading: heading.into(), panels: plots.into_iter().map(Into::into).collect() }
    }
}

/// One plot of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Plot {
    /// A panel: a pair of axes.
    Panel(Panel),
    /// A map over space and time.
    SpaceTime(SpaceTime),
    /// Positive numbers against two parameters.
    CellMap(CellMap),
    /// A map of growth rates.
    GrowthMap(GrowthMap),
}

/// A pair of axes, with its title and the legend above it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// Title above the legend; may be empty.
    pub title: String,
    /// The kind of the axes.
    pub kind: Kind,
    /// Label of the abscissa, such as “site n”.
    pub x_label: String,
    /// Label of the ordinate, such as “strain xₙ”.
    pub y_label: String,
    /// The lines.
    pub lines: Vec<Line>,
    /// Abscissas that are marked by upright lines, with their name in the legend.
    pub mark: Option<(String, Vec<f64>)>,
}

impl Panel {
    /// Lines on axes of a kind, with the labels of abscissa and ordinate.
    pub fn new(kind: Kind, [x_label, y_label]: [&str; 2], lines: Vec<Line>) -> Self {
        Self { kind, x_label: x_label.to_owned(), y_label: y_label.to_owned(), lines, ..Self::default() }
    }
}

/// The kind of the axes and of the points in a panel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// Values against sites, which are whole numbers. Lines of at most 200 points have markers:
    /// squares first, for computed values, then stars and crosses.
    #[default]
    Sites,
    /// Values against time.
    Time,
    /// Values against time on a logarithmic ordinate; zeros and negative values leave a gap.
    LogTime,
    /// Both axes logarithmic, each point with a marker; values that are not positive leave a gap.
    LogLog,
    /// Values against a parameter, each point with a marker.
    Parameter,
    /// `Parameter` with a logarithmic ordinate.
    LogParameter,
    /// Points that are not joined, against a parameter.
    Cloud,
    /// `Cloud` with a logarithmic abscissa.
    LogCloud,
    /// Points of the complex plane, not joined, with the unit circle; the axes have the same scale.
    Plane,
}

/// A work-precision diagram.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorkPrecision {
    /// Title above the axes.
    pub title: String,
    /// Label of the abscissa, with its unit.
    pub work_label: String,
    /// Label of the ordinate.
    pub error_label: String,
    /// The methods.
    pub curves: Vec<Curve>,
    /// The error of the reference, drawn as a grey line; smaller errors are not resolved.
    pub floor: Option<f64>,
    /// Caption, enough to make the figure again.
    pub caption: String,
}

/// A method and its measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Name in the legend; an integrator has the same colour and marker in all pictures.
    pub name: String,
    /// What the legend says after the name.
    pub note: String,
    /// Heading in the legend, above all curves of the group.
    pub group: String,
    /// The measurements, joined in this order.
    pub points: Vec<Point>,
}

/// One measurement of a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// The cost: seconds, or evaluations of the force.
    pub work: f64,
    /// The relative error.
    pub error: f64,
    /// Whether the error is too small to be resolved by the reference; such a point is drawn
    /// hollow.
    pub below_reference: bool,
}

/// A matrix of values at times and sites.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpaceTime {
    /// Label of the abscissa, such as “bond n”.
    pub site_label: String,
    /// Label of the ordinate, such as “time t”; time increases upwards.
    pub time_label: String,
    /// Label of the colour bar, such as “strain xₙ”.
    pub value_label: String,
    /// The values by rows: all sites at the first time, then at the next.
    pub values: Vec<f64>,
    /// Number of sites, the length of a row.
    pub sites: usize,
    /// Number of the first site.
    pub first_site: f64,
    /// Times of the first and of the last row; the others are evenly spaced between them.
    pub times: (f64, f64),
    /// Upper end of the scale of colours, if it is given; larger values have one colour, that of
    /// the tip above the colour bar.
    pub most: Option<f64>,
    /// Whether the range is symmetric, with colours from blue over white at 0 to red; otherwise
    /// colours run from dark to light.
    pub signed: bool,
}

/// A cell for each pair of parameters; neighbours meet at the geometric mean of their parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellMap {
    /// Labels of abscissa, ordinate and colour bar.
    pub labels: [String; 3],
    /// Abscissas of the columns, increasing.
    pub x: Vec<f64>,
    /// Ordinates of the rows, increasing.
    pub y: Vec<f64>,
    /// The values row by row, the lowest row first; a value that is not positive is grey.
    pub values: Vec<f64>,
    /// A note in each cell, in the order of the values; may be empty.
    pub notes: Vec<String>,
    /// Lines over the map, each with its own dashes.
    pub lines: Vec<Line>,
    /// Kinds of cells off the scale of colours, at most two: name in the legend, and the indices of
    /// the cells.
    pub apart: Vec<(String, Vec<usize>)>,
}

impl CellMap {
    /// A map by its labels, its abscissas and ordinates, and the value and the note of each cell.
    pub fn new(labels: [&str; 3], [x, y]: [Vec<f64>; 2], cell: impl Fn(f64, f64) -> (f64, String)) -> Self {
        let (cell, x_of) = (&cell, &x);
        let cells = y.iter().flat_map(|&y| x_of.iter().map(move |&x| cell(x, y)));
        let (values, notes) = cells.unzip();
        Self { labels: labels.map(str::to_owned), values, notes, x, y, ..Self::default() }
    }
}

/// A matrix with a cell for each row and column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Matrix {
    /// Title at the top.
    pub title: String,
    /// Names of the rows, from the top.
    pub rows: Vec<String>,
    /// Names of the columns, from the left; drawn upwards.
    pub columns: Vec<String>,
    /// Label of the columns, and label of the colour bar.
    pub labels: [String; 2],
    /// The values row by row; a value that is not positive is grey.
    pub values: Vec<f64>,
    /// A note in each cell, in the order of the values.
    pub notes: Vec<String>,
    /// Caption, enough to make the figure again.
    pub caption: String,
}

/// Contacts over time and bonds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Raster {
    /// Title above the axes.
    pub title: String,
    /// Label of the ordinate, such as “bond n”.
    pub bond_label: String,
    /// Label of the abscissa, such as “time t”.
    pub time_label: String,
    /// The contacts, in any order.
    pub bars: Vec<Bar>,
    /// Label of the colour bar, such as “largest overlap”.
    pub shade_label: String,
    /// The first and the last bond on the axis.
    pub bonds: (f64, f64),
    /// The first and the last time on the axis.
    pub times: (f64, f64),
    /// Caption, enough to make the figure again.
    pub caption: String,
}

/// One contact as a bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bar {
    /// Number of the bond.
    pub bond: f64,
    /// Time at which the contact began.
    pub start: f64,
    /// Time at which the contact ended.
    pub end: f64,
    /// Magnitude of the contact, shown by the colour; grey if it is not finite.
    pub shade: f64,
}

/// A map of cells, with lines and points on it.
#[derive(Clone, Debug, PartialEq)]
pub struct GrowthMap {
    /// Labels of abscissa, ordinate and colour bar.
    pub labels: [String; 3],
    /// Range of the abscissa; the columns divide it evenly.
    pub x: (f64, f64),
    /// The same for the ordinate and rows.
    pub y: (f64, f64),
    /// The values row by row, the lowest row first.
    pub values: Vec<f64>,
    /// Number of columns, the length of a row.
    pub columns: usize,
    /// Lines over the map, each with its own dashes.
    pub lines: Vec<Line>,
    /// Points over the map.
    pub points: Line,
}

/// What a picture shows; `draw` (feature `plot`) makes the picture.
#[derive(Clone, Debug, PartialEq)]
pub enum Figure {
    /// Columns of panels.
    Panels(Panels),
    /// Error against work.
    WorkPrecision(WorkPrecision),
    /// Positive numbers for named rows and columns.
    Matrix(Matrix),
    /// Contacts as bars.
    Raster(Raster),
}

macro_rules! figures {
    ($($kind:ident),*; $($plot:ident),*) => {
        impl Figure {
            /// Its title, and its caption, enough to make the figure again.
            pub fn words(&mut self) -> [&mut String; 2] {
                match self {
                    $(Self::$kind(figure) => [&mut figure.title, &mut figure.caption],)*
                }
            }
        }

        $(
        impl From<$kind> for Figure {
            fn from(figure: $kind) -> Self {
                Self::$kind(figure)
            }
        })*

        $(
        impl From<$plot> for Plot {
            fn from(plot: $plot) -> Self {
                Self::$plot(plot)
            }
        })*
    };
}
figures!(Panels, WorkPrecision, Matrix, Raster; Panel, SpaceTime, CellMap, GrowthMap);
