//! A finished picture, and the formats of its file.

use super::canvas::Shape;
use super::{Error, bitmap, svg};
use std::str::FromStr;

/// A finished picture: shapes in their order, title and caption.
///
/// ```
/// use hertzchain_report::figures::{Format, Kind, Line, Panel, Panels, panels};
/// let line = Line::new("sin", (0..100).map(|k| (0.1 * f64::from(k), (0.1 * f64::from(k)).sin())));
/// let panel = Panel::new(Kind::Time, ["time t", "sin t"], vec![line]);
/// let picture = panels(&Panels::column("A sine", vec![panel], "It is drawn over time."))?;
/// assert!(picture.file(Format::Png)?.starts_with(b"\x89PNG"));
/// let svg = String::from_utf8(picture.file(Format::Svg)?).unwrap();
/// assert!(svg.contains("<title>A sine</title>"));
/// # Ok::<(), hertzchain_report::figures::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub(super) size: (u32, u32),
    /// What the picture shows, in a few words.
    pub title: String,
    /// What can be seen, and how it was made.
    pub caption: String,
    pub(super) shapes: Vec<Shape>,
}

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
