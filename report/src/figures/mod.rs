//! Figures as PNG and SVG files; all pictures of this crate are drawn here.
//!
//! Every function takes numbers and words and returns a [`Picture`], which becomes a file of either
//! [`Format`]. This module computes no physics and reads no file: the font is part of the program,
//! so that a figure needs no display and no installed files, and the same input gives the same
//! bytes.
//!
//! | figure | function |
//! | --- | --- |
//! | error against work, on logarithmic axes | [`work_precision()`] |
//! | columns of panels, quantities against site, time or a parameter, and of maps | [`panels()`] |
//! | contacts against time and bond, as bars | [`raster()`] |
//! | positive numbers for named rows and columns, in cells | [`matrix()`] |
//!
//! Texts are set with subscripts, superscripts and powers of ten: `ω_b`, `ε^(1−α)`, `1e-9`.
//!
//! The caption is drawn below the axes. The file also holds title and whole caption, as the text
//! chunks `Title` and `Description` of PNG or the elements `title` and `desc` of SVG, so that a
//! picture without its page says how it was made.

pub(crate) mod axes;
mod bitmap;
pub(crate) mod canvas;
mod colour_bar;
mod growth;
mod legend;
pub mod maps;
pub mod matrix;
pub mod palette;
pub mod panels;
mod picture;
pub mod raster;
mod space_time;
pub(crate) mod svg;
pub mod work_precision;

use canvas::{Canvas, Rect};

pub use crate::report::{
    Bar, CellMap, Column, Curve, Figure, GrowthMap, Kind, Line, Matrix, Panel, Panels, Plot, Point, Raster, SpaceTime,
    WorkPrecision,
};
pub use canvas::missing_glyphs;
pub use matrix::matrix;
pub use panels::panels;
pub use picture::{Format, Picture};
pub use raster::raster;
pub use work_precision::work_precision;

/// Width and height of most figures in pixels. Panels of more than two rows and matrices have
/// another height.
pub const SIZE: (u32, u32) = (1200, 800);

/// Lines of a caption for which a page has room; with more it is higher.
const CAPTION_LINES: usize = 7;

/// The reason why a figure could not be drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error(pub String);

impl std::fmt::Display for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Error {}

impl Figure {
    /// The picture.
    ///
    /// # Errors
    /// As of the function that draws its kind.
    pub fn draw(&self) -> Result<Picture, Error> {
        match self {
            Self::Panels(figure) => panels(figure),
            Self::WorkPrecision(figure) => work_precision(figure),
            Self::Matrix(figure) => matrix(figure),
            Self::Raster(figure) => raster(figure),
        }
    }
}

impl crate::report::Report {
    /// The pictures as they are drawn, by the name of their PNG file.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    pub fn drawn(&self) -> crate::error::Result<Vec<(String, Picture)>> {
        self.pictures().iter().map(|(name, figure)| Ok((name.clone(), figure.draw()?))).collect()
    }
}

/// Whether a value can be drawn on an axis; the bound keeps the width of every range finite.
fn usable(value: f64) -> bool {
    value.abs() <= 1e300
}

/// An empty figure of the usual size with its title and caption, and the space between them.
fn page(title: &str, caption: &str) -> Result<(Canvas, Rect), Error> {
    page_of(SIZE, title, caption)
}

/// A [`page`] of another size.
fn page_of(size: (u32, u32), title: &str, caption: &str) -> Result<(Canvas, Rect), Error> {
    let lines = canvas::wrap(caption, canvas::CAPTION, f64::from(size.0) - 40.0);
    let more = 1.35 * canvas::CAPTION * lines.len().saturating_sub(CAPTION_LINES) as f64;
    let size = (size.0, size.1 + more as u32);
    let mut canvas = Canvas::new(size, title);
    let (width, height) = (f64::from(size.0), f64::from(size.1));
    let mut body = Rect { x0: 20.0, y0: 18.0, x1: width - 20.0, y1: height - 14.0 };

    for line in canvas::wrap(title, canvas::TITLE, body.width()) {
        canvas.text(&line, (width / 2.0, body.y0), canvas::TITLE, palette::INK, (0.5, 0.0));
        body.y0 += 1.35 * canvas::TITLE;
    }
    for line in lines.iter().rev() {
        canvas.text(line, (body.x0, body.y1 - 0.25 * canvas::CAPTION), canvas::CAPTION, palette::GREY, (0.0, 1.0));
        body.y1 -= 1.35 * canvas::CAPTION;
    }
    body.y1 -= 8.0;
    Ok((canvas, body))
}

impl From<Error> for crate::error::Error {
    fn from(error: Error) -> Self {
        Self::Figure(Box::new(error))
    }
}
