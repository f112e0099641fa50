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

pub use crate::report::{
    Bar, CellMap, Column, Curve, Figure, GrowthMap, Kind, Line, Matrix, Panel, Panels, Plot, Point, Raster, SpaceTime,
    WorkPrecision,
};
pub use canvas::{Error, Picture, SIZE, missing_glyphs};
pub use matrix::matrix;
pub use panels::panels;
pub use picture::Format;
pub use raster::raster;
pub use work_precision::work_precision;

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
