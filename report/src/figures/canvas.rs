//! The surface of a figure: a list of shapes, drawn in their order.
//!
//! All lengths are pixels of the finished picture; `y` increases downwards. Widths of texts are
//! those of the font that is part of the program.

use std::{io::Read, sync::LazyLock};

use ab_glyph::{Font, FontRef, Glyph, ScaleFont, point};
use flate2::read::GzDecoder;

use super::palette::{GREY, INK, Rgb};
use crate::letters::runs;

/// Size of the title, in pixels per em.
pub(super) const TITLE: f64 = 20.0;
/// Size of the labels of axes, in pixels per em.
pub(super) const LABEL: f64 = 17.0;
/// Size of ticks' numbers and of legends, in pixels per em.
pub const SMALL: f64 = 15.0;
/// Size of the caption, in pixels per em.
pub(super) const CAPTION: f64 = 13.5;

/// Width and height of most figures in pixels. Panels of more than two rows and matrices have
/// another height.
pub const SIZE: (u32, u32) = (1200, 800);

/// Lines of a caption for which a page has room; with more it is higher.
const CAPTION_LINES: usize = 7;

/// Pixels of a bitmap per pixel of the picture, along one side. Widths of texts are rounded to
/// them.
pub(super) const FINE: u32 = 3;

/// DejaVu Sans 2.37 with all its characters, outlines and kerning. Hints and the tables `GPOS`,
/// `GSUB`, `GDEF`, `MATH`, `FFTM`, which nothing here reads, are left out; packed, it is a third as
/// large.
pub(super) static FONT: LazyLock<FontRef<'static>> = LazyLock::new(|| {
    let mut font = Vec::new();
    let read = GzDecoder::new(&include_bytes!("font/DejaVuSans.ttf.gz")[..]).read_to_end(&mut font);
    read.ok().and_then(|_| FontRef::try_from_slice(font.leak()).ok()).expect("the embedded font is a valid font")
});

/// The characters of a text that the font of the figures cannot draw, each once, in increasing
/// order.
///
/// A figure has the sign for an unknown character, U+FFFD, in their place.
pub fn missing_glyphs(text: &str) -> Vec<char> {
    let mut missing: Vec<char> = text.chars().filter(|&c| c != '\n' && drawn(c) != c).collect();
    missing.sort_unstable();
    missing.dedup();
    missing
}

/// The character that is drawn for `c`.
fn drawn(c: char) -> char {
    if c.is_control() || FONT.glyph_id(c).0 == 0 { char::REPLACEMENT_CHARACTER } else { c }
}

/// The reason why a figure could not be drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error(pub String);

impl std::fmt::Display for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Error {}

impl From<Error> for crate::error::Error {
    fn from(error: Error) -> Self {
        Self::Figure(Box::new(error))
    }
}

/// A rectangle in pixels; `y` increases downwards.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rect {
    pub(super) x0: f64,
    pub(super) y0: f64,
    pub(super) x1: f64,
    pub(super) y1: f64,
}

impl Rect {
    pub(super) fn width(&self) -> f64 {
        self.x1 - self.x0
    }

    pub(super) fn height(&self) -> f64 {
        self.y1 - self.y0
    }
}

/// The glyphs of a text on a baseline from the origin, and the width of the text, in fine
/// pixels.
pub(super) fn layout(text: &str, size: f64) -> (Vec<Glyph>, f32) {
    let em = size as f32 * FINE as f32;
    let (mut glyphs, mut x) = (Vec::<Glyph>::new(), 0.0);
    for (level, run) in runs(text) {
        let (scale, drop) = level.scale_and_drop();
        let font = FONT.as_scaled(em * scale as f32 * FONT.height_unscaled() / FONT.units_per_em().unwrap_or(2048.0));
        let mut before = None;
        for c in run.chars().map(drawn) {
            let mut glyph = font.scaled_glyph(c);
            x += before.map_or(0.0, |before| font.kern(before, glyph.id));
            before = Some(glyph.id);
            glyph.position = point(x, drop as f32 * em);
            x += font.h_advance(glyph.id);
            glyphs.push(glyph);
        }
    }
    (glyphs, x)
}

/// Width of a text in pixels.
pub fn text_width(text: &str, size: f64) -> f64 {
    f64::from(layout(text, size).1) / f64::from(FINE)
}

/// Signs that join two words of a formula.
const JOINTS: [&str; 12] = ["=", "+", "−", "±", "·", "×", "/", "<", ">", "≤", "≥", "→"];

/// The words of a paragraph; a formula that is no wider than a line is one.
fn words(paragraph: &str, size: f64, width: f64) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut open = false;
    for word in paragraph.split_whitespace() {
        let joins = JOINTS.contains(&word);
        match words.last_mut() {
            Some(last)
                if (open || joins || word.contains('^')) && text_width(&format!("{last} {word}"), size) <= width =>
            {
                *last += " ";
                *last += word;
            }
            _ => words.push(word.to_owned()),
        }
        open = joins;
    }
    words
}

/// Breaks a text into lines no wider than `width`: between words, not within formulas, and within a
/// word that is wider than a line.
pub(super) fn wrap(text: &str, size: f64, width: f64) -> Vec<String> {
    let mut lines = Vec::new();
    for paragraph in text.lines() {
        let mut line = String::new();
        for word in &words(paragraph, size, width) {
            let joined = if line.is_empty() { word.clone() } else { format!("{line} {word}") };
            if text_width(&joined, size) <= width {
                line = joined;
                continue;
            }
            if !line.is_empty() {
                lines.push(std::mem::take(&mut line));
            }
            for c in word.chars() {
                if !line.is_empty() && text_width(&format!("{line}{c}"), size) > width {
                    lines.push(std::mem::take(&mut line));
                }
                line.push(c);
            }
        }
        if !line.is_empty() {
            lines.push(line);
        }
    }
    lines
}

/// A text with its place, size, colour and direction.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Label {
    pub(super) text: String,
    /// The point of the picture where the anchor lies.
    pub(super) at: (f64, f64),
    /// Pixels per em.
    pub(super) size: f64,
    pub(super) colour: Rgb,
    /// The point of the text that lies there. Along the text 0 is its start and 1 its end; across
    /// it 0 is the top of the capitals and 1 the baseline.
    pub(super) anchor: (f64, f64),
    /// Whether the text runs upwards instead of to the right.
    pub(super) upwards: bool,
}

/// Height of capitals, in units of the size.
pub(super) const CAPITALS: f64 = 0.73;

/// One element of a picture.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Shape {
    /// A line through points; `dash` holds the lengths of strokes and gaps in turn, and is empty
    /// for a solid line.
    Line { points: Vec<(f64, f64)>, colour: Rgb, width: f64, dash: Vec<f64> },
    /// A filled polygon.
    Polygon { points: Vec<(f64, f64)>, colour: Rgb },
    /// Pixels, row by row from the top.
    Image { corner: (u32, u32), width: usize, pixels: Vec<Rgb> },
    /// A text.
    Text(Label),
}

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

/// A picture that is being drawn.
pub struct Canvas {
    size: (u32, u32),
    title: String,
    shapes: Vec<Shape>,
}

impl Canvas {
    /// A white canvas, for a picture of this title.
    pub fn new(size: (u32, u32), title: &str) -> Self {
        Self { size, title: title.to_owned(), shapes: Vec::new() }
    }

    /// Draws a line through points; `dash` holds the lengths of strokes and gaps in turn, and is
    /// empty for a solid line.
    pub fn line(&mut self, points: &[(f64, f64)], colour: Rgb, width: f64, dash: &[f64]) {
        self.shapes.push(Shape::Line { points: points.to_vec(), colour, width, dash: dash.to_vec() });
    }

    pub(super) fn polygon(&mut self, points: &[(f64, f64)], colour: Rgb) {
        self.shapes.push(Shape::Polygon { points: points.to_vec(), colour });
    }

    pub(super) fn rect(&mut self, &Rect { x0, y0, x1, y1 }: &Rect, colour: Rgb) {
        self.polygon(&[(x0, y0), (x1, y0), (x1, y1), (x0, y1)], colour);
    }

    pub(super) fn border(&mut self, area: &Rect, colour: Rgb) {
        let Rect { x0, y0, x1, y1 } = *area;
        let (left, right) = (x0 - 0.5, x1 + 0.5);
        for side in [[(left, y0), (right, y0)], [(left, y1), (right, y1)], [(x0, y0), (x0, y1)], [(x1, y0), (x1, y1)]] {
            self.line(&side, colour, 1.0, &[]);
        }
    }

    /// Draws a picture of `width` columns, given row by row from the top, with its corner at a
    /// whole pixel.
    pub fn image(&mut self, corner: (u32, u32), width: usize, pixels: Vec<Rgb>) {
        self.shapes.push(Shape::Image { corner, width, pixels });
    }

    /// Draws a text with its [`anchor`](Label::anchor) at a point.
    pub fn text(&mut self, text: &str, at: (f64, f64), size: f64, colour: Rgb, anchor: (f64, f64)) {
        self.shapes.push(Shape::Text(Label { text: text.to_owned(), at, size, colour, anchor, upwards: false }));
    }

    /// Draws a text that runs upwards.
    pub(super) fn text_upwards(&mut self, text: &str, at: (f64, f64), size: f64, colour: Rgb, anchor: (f64, f64)) {
        self.shapes.push(Shape::Text(Label { text: text.to_owned(), at, size, colour, anchor, upwards: true }));
    }

    /// The finished picture.
    pub fn picture(self, caption: &str) -> Picture {
        Picture { size: self.size, title: self.title, caption: caption.to_owned(), shapes: self.shapes }
    }
}

/// Whether a value can be drawn on an axis; the bound keeps the width of every range finite.
pub(super) fn usable(value: f64) -> bool {
    value.abs() <= 1e300
}

/// An empty figure with its title and caption, and the space between them.
pub(super) fn page(size: (u32, u32), title: &str, caption: &str) -> Result<(Canvas, Rect), Error> {
    let lines = wrap(caption, CAPTION, f64::from(size.0) - 40.0);
    let more = 1.35 * CAPTION * lines.len().saturating_sub(CAPTION_LINES) as f64;
    let size = (size.0, size.1 + more as u32);
    let mut canvas = Canvas::new(size, title);
    let (width, height) = (f64::from(size.0), f64::from(size.1));
    let mut body = Rect { x0: 20.0, y0: 18.0, x1: width - 20.0, y1: height - 14.0 };

    for line in wrap(title, TITLE, body.width()) {
        canvas.text(&line, (width / 2.0, body.y0), TITLE, INK, (0.5, 0.0));
        body.y0 += 1.35 * TITLE;
    }
    for line in lines.iter().rev() {
        canvas.text(line, (body.x0, body.y1 - 0.25 * CAPTION), CAPTION, GREY, (0.0, 1.0));
        body.y1 -= 1.35 * CAPTION;
    }
    body.y1 -= 8.0;
    Ok((canvas, body))
}
