//! The formats of the file of a picture.

use super::canvas::{Error, Picture};
use super::{bitmap, svg};
use std::str::FromStr;

/// A format of picture files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Pixels, [`SIZE`](super::SIZE) for most figures.
    Png,
    /// Lines and texts, which stay sharp at any size; texts can be searched and read aloud.
    Svg,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 2] = [Self::Png, Self::Svg];

    /// The extension of its files, without a dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Svg => "svg",
        }
    }

    /// The name of the file of a picture whose PNG file is called `name`.
    ///
    /// ```
    /// assert_eq!(hertzchain_report::figures::Format::Svg.name("wave.png"), "wave.svg");
    /// ```
    pub fn name(self, name: &str) -> String {
        format!("{}.{}", name.trim_end_matches(".png"), self.extension())
    }
}

impl FromStr for Format {
    type Err = crate::error::Error;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let known = Self::ALL.into_iter().find(|format| format.extension() == name);
        known.ok_or_else(|| Self::Err::unknown("format", name, Self::ALL.iter().map(|format| format.extension())))
    }
}

impl Picture {
    /// The bytes of a file.
    ///
    /// # Errors
    /// Errors of drawing the bitmap and of the PNG encoder.
    pub fn file(&self, format: Format) -> Result<Vec<u8>, Error> {
        match format {
            Format::Png => bitmap::png(self),
            Format::Svg => svg::svg(self),
        }
    }
}
