//! The surface of a figure: lines, polygons and text in an RGB buffer, and the PNG file made from
//! it.
//!
//! All lengths are pixels of the finished picture. The buffer is [`FINE`] times finer and is
//! averaged at the end, which smooths every edge. Shapes are rasterised by `plotters`. Glyphs are
//! placed here, with their side bearings and kerning, because the text of `plotters` ignores the
//! bearings.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, Glyph, ScaleFont, point};
use plotters::backend::{BitMapBackend, DrawingBackend};
use plotters::style::{Color, RGBColor};

use super::Error;
use super::palette::Rgb;
use super::text::runs;

/// Size of the title, in pixels per em.
pub(super) const TITLE: f64 = 20.0;
/// Size of the labels of axes, in pixels per em.
pub(super) const LABEL: f64 = 17.0;
/// Size of ticks' numbers and of legends, in pixels per em.
pub(super) const SMALL: f64 = 15.0;
/// Size of the caption, in pixels per em.
pub(super) const CAPTION: f64 = 13.5;

/// Pixels of the buffer per pixel of the picture, along one side.
pub(super) const FINE: u32 = 3;

static FONT: LazyLock<FontRef<'static>> =
    LazyLock::new(|| FontRef::try_from_slice(dejavu::sans::regular()).expect("the embedded font is a valid font"));

/// The characters of a text that the font of the figures cannot draw, each once, in increasing
/// order.
///
/// A figure with such a character in one of its texts is an error.
pub fn missing_glyphs(text: &str) -> Vec<char> {
    let mut missing: Vec<char> =
        text.chars().filter(|&c| c != '\n' && (c.is_control() || FONT.glyph_id(c).0 == 0)).collect();
    missing.sort_unstable();
    missing.dedup();
    missing
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

/// The glyphs of a text on a baseline from the origin, and the width of the text, in fine pixels.
fn layout(text: &str, size: f64) -> (Vec<Glyph>, f32) {
    let em = size as f32 * FINE as f32;
    let (mut glyphs, mut x) = (Vec::<Glyph>::new(), 0.0);
    for (level, run) in runs(text) {
        let (scale, drop) = level.scale_and_drop();
        let font = FONT.as_scaled(em * scale as f32 * FONT.height_unscaled() / FONT.units_per_em().unwrap_or(2048.0));
        let mut before = None;
        for c in run.chars() {
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
pub(super) fn text_width(text: &str, size: f64) -> f64 {
    f64::from(layout(text, size).1) / f64::from(FINE)
}

/// Breaks a text into lines no wider than `width`: between words, and within a word that is wider
/// than a line.
pub(super) fn wrap(text: &str, size: f64, width: f64) -> Vec<String> {
    let mut lines = Vec::new();
    for paragraph in text.lines() {
        let mut line = String::new();
        for word in paragraph.split_whitespace() {
            let joined = if line.is_empty() { word.to_string() } else { format!("{line} {word}") };
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

/// The nearest corner of a fine pixel. A text that started between two rows would be rounded
/// unevenly and look faint.
fn snapped((x, y): (f64, f64)) -> (f64, f64) {
    let snap = |value: f64| (value * f64::from(FINE)).round() / f64::from(FINE);
    (snap(x), snap(y))
}

/// A picture that is being drawn.
pub(super) struct Canvas {
    size: (u32, u32),
    fine: Vec<u8>,
}

impl Canvas {
    /// A white canvas.
    pub(super) fn new(size: (u32, u32)) -> Self {
        Self { size, fine: vec![255; (size.0 * size.1 * FINE * FINE * 3) as usize] }
    }

    fn backend(&mut self) -> BitMapBackend<'_> {
        BitMapBackend::with_buffer(&mut self.fine, (self.size.0 * FINE, self.size.1 * FINE))
    }

    /// Draws a line through points; `dash` holds the lengths of strokes and gaps in turn, and is
    /// empty for a solid line.
    pub(super) fn line(&mut self, points: &[(f64, f64)], colour: Rgb, width: f64, dash: &[f64]) -> Result<(), Error> {
        if !dash.is_empty() {
            return dashes(points, dash).iter().try_for_each(|stroke| self.line(stroke, colour, width, &[]));
        }
        let half = width / 2.0;
        for pair in points.windows(2) {
            let (dx, dy) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
            let scale = half / dx.hypot(dy);
            if scale.is_finite() {
                let (u, v) = (-dy * scale, dx * scale);
                let sides = [(pair[0], 1.0), (pair[0], -1.0), (pair[1], -1.0), (pair[1], 1.0)];
                self.polygon(&sides.map(|((x, y), side)| (x + side * u, y + side * v)), colour)?;
            }
        }
        // Round joints fill the wedges between the strokes of a bent line.
        let radius = (half * f64::from(FINE)) as u32;
        if radius > 1 {
            for &joint in points.iter().skip(1).rev().skip(1) {
                self.backend().draw_circle(fine(joint), radius, &solid(colour), true).map_err(drawing)?;
            }
        }
        Ok(())
    }

    pub(super) fn polygon(&mut self, points: &[(f64, f64)], colour: Rgb) -> Result<(), Error> {
        self.backend().fill_polygon(points.iter().copied().map(fine), &solid(colour)).map_err(drawing)
    }

    /// Darkens a vertical strip between two straight edges, `top` and `bottom`, to a pale colour.
    ///
    /// Darker pixels stay as they are, and a second tint with the same colour changes nothing. So
    /// neighbouring strips leave no seam, and of two overlapping ranges both are seen.
    pub(super) fn tint(&mut self, x: [f64; 2], top: [f64; 2], bottom: [f64; 2], colour: Rgb) {
        let scale = f64::from(FINE);
        let (wide, high) = (f64::from(self.size.0 * FINE), f64::from(self.size.1 * FINE));
        let whole = |value: f64, most: f64| (value * scale).round().clamp(0.0, most - 1.0) as usize;
        let (from, to) = (whole(x[0].min(x[1]), wide), whole(x[0].max(x[1]), wide));
        for column in from..=to {
            let share =
                if x[0] == x[1] { 0.0 } else { ((column as f64 / scale - x[0]) / (x[1] - x[0])).clamp(0.0, 1.0) };
            let at = |edge: [f64; 2]| whole(edge[0] + share * (edge[1] - edge[0]), high);
            for row in at(top)..=at(bottom) {
                let start = 3 * (row * wide as usize + column);
                for (ink, pale) in self.fine[start..start + 3].iter_mut().zip([colour.0, colour.1, colour.2]) {
                    *ink = (*ink).min(pale);
                }
            }
        }
    }

    pub(super) fn border(&mut self, area: &Rect, colour: Rgb) -> Result<(), Error> {
        let Rect { x0, y0, x1, y1 } = *area;
        let (left, right) = (x0 - 0.5, x1 + 0.5);
        [[(left, y0), (right, y0)], [(left, y1), (right, y1)], [(x0, y0), (x0, y1)], [(x1, y0), (x1, y1)]]
            .iter()
            .try_for_each(|side| self.line(side, colour, 1.0, &[]))
    }

    /// Draws a picture of `width` columns, given row by row from the top, with its corner at a
    /// whole pixel.
    pub(super) fn image(&mut self, corner: (u32, u32), width: usize, pixels: &[Rgb]) -> Result<(), Error> {
        let f = FINE as usize;
        let mut enlarged = Vec::with_capacity(pixels.len() * f * f * 3);
        for row in pixels.chunks(width) {
            let line: Vec<u8> = row.iter().flat_map(|&(r, g, b)| [r, g, b].repeat(f)).collect();
            enlarged.extend(line.repeat(f));
        }
        let corner = ((corner.0 * FINE) as i32, (corner.1 * FINE) as i32);
        let size = (width as u32 * FINE, (pixels.len() / width) as u32 * FINE);
        self.backend().blit_bitmap(corner, size, &enlarged).map_err(drawing)
    }

    /// Draws a text at a point.
    ///
    /// `anchor` is the point of the text that lies there. Along the text 0 is its start and 1 its
    /// end; across it 0 is the top of the capitals and 1 the baseline.
    pub(super) fn text(
        &mut self,
        text: &str,
        at: (f64, f64),
        size: f64,
        colour: Rgb,
        anchor: (f64, f64),
    ) -> Result<(), Error> {
        let (x, y) = snapped(at);
        self.glyphs(text, size, colour, anchor, |u, v| (x + u, y + v))
    }

    /// Draws a text that runs upwards; `anchor` as in [`Canvas::text`].
    pub(super) fn text_upwards(
        &mut self,
        text: &str,
        at: (f64, f64),
        size: f64,
        colour: Rgb,
        anchor: (f64, f64),
    ) -> Result<(), Error> {
        let (x, y) = snapped(at);
        self.glyphs(text, size, colour, anchor, |u, v| (x + v, y - u))
    }

    fn glyphs(
        &mut self,
        text: &str,
        size: f64,
        colour: Rgb,
        anchor: (f64, f64),
        place: impl Fn(f64, f64) -> (f64, f64),
    ) -> Result<(), Error> {
        let missing = missing_glyphs(text);
        if !missing.is_empty() {
            return Err(Error(format!("the font of the figures lacks {missing:?}, needed for {text:?}")));
        }
        let (glyphs, width) = layout(text, size);
        let scale = f64::from(FINE);
        let (du, dv) = ((-anchor.0 * f64::from(width)).round(), (0.73 * (1.0 - anchor.1) * size * scale).round());
        let mut backend = self.backend();
        for outline in glyphs.into_iter().filter_map(|glyph| FONT.outline_glyph(glyph)) {
            let corner = outline.px_bounds().min;
            let mut result = Ok(());
            outline.draw(|x, y, cover| {
                let u = du + f64::from(corner.x) + f64::from(x);
                let v = dv + f64::from(corner.y) + f64::from(y);
                let ink = solid(colour).mix(f64::from(cover.min(1.0))).to_backend_color();
                let drawn = backend.draw_pixel(fine(place(u / scale, v / scale)), ink);
                if let Err(error) = drawn {
                    result = Err(drawing(error));
                }
            });
            result?;
        }
        Ok(())
    }

    /// The finished PNG file, with the caption as a text chunk.
    pub(super) fn png(self, caption: &str) -> Result<Vec<u8>, Error> {
        let missing = missing_glyphs(caption);
        if !missing.is_empty() {
            return Err(Error(format!("the font of the figures lacks {missing:?}, needed for the caption")));
        }
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.size.0, self.size.1);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Balanced);
        // Without a filter flat colours repeat, which compresses best.
        encoder.set_filter(png::Filter::NoFilter);
        let software = concat!("hertzchain ", env!("CARGO_PKG_VERSION")).to_string();
        encoder.add_text_chunk("Software".into(), software).map_err(encoding)?;
        encoder.add_itxt_chunk("Description".into(), caption.into()).map_err(encoding)?;
        let mut writer = encoder.write_header().map_err(encoding)?;
        writer.write_image_data(&self.averaged()).map_err(encoding)?;
        writer.finish().map_err(encoding)?;
        Ok(bytes)
    }

    /// The picture in its final size: each pixel is the mean of its fine pixels.
    fn averaged(&self) -> Vec<u8> {
        let (f, width) = (FINE as usize, self.size.0 as usize);
        let block = 3 * f;
        let mut means = Vec::with_capacity(3 * width * self.size.1 as usize);
        for rows in self.fine.chunks(block * width * f) {
            for at in (0..width).map(|x| x * block) {
                let lines = || rows.chunks(block * width).map(|row| &row[at..at + block]);
                let first = &rows[at..at + block];
                if first[3..] == first[..block - 3] && lines().all(|line| line == first) {
                    means.extend_from_slice(&first[..3]);
                    continue;
                }
                let mut sums = [FINE * FINE / 2; 3];
                for pixel in lines().flat_map(|line| line.chunks(3)) {
                    sums.iter_mut().zip(pixel).for_each(|(sum, &c)| *sum += u32::from(c));
                }
                means.extend(sums.map(|sum| (sum / (FINE * FINE)) as u8));
            }
        }
        means
    }
}

fn solid((r, g, b): Rgb) -> RGBColor {
    RGBColor(r, g, b)
}

fn fine((x, y): (f64, f64)) -> (i32, i32) {
    let scale = f64::from(FINE);
    ((x * scale).round() as i32, (y * scale).round() as i32)
}

fn drawing(error: impl std::fmt::Display) -> Error {
    Error(format!("drawing failed: {error}"))
}

fn encoding(error: png::EncodingError) -> Error {
    Error(format!("writing the PNG failed: {error}"))
}

/// Cuts a line into the strokes of a dash pattern.
fn dashes(points: &[(f64, f64)], dash: &[f64]) -> Vec<Vec<(f64, f64)>> {
    let mut strokes = Vec::new();
    let (mut part, mut left) = (0, dash[0]);
    let mut stroke: Vec<_> = points.first().copied().into_iter().collect();
    for pair in points.windows(2) {
        let (mut at, end) = (pair[0], pair[1]);
        loop {
            let rest = (end.0 - at.0).hypot(end.1 - at.1);
            if rest <= left {
                left -= rest;
                stroke.push(end);
                break;
            }
            at = (at.0 + (end.0 - at.0) * left / rest, at.1 + (end.1 - at.1) * left / rest);
            stroke.push(at);
            if part % 2 == 0 {
                strokes.push(std::mem::take(&mut stroke));
            }
            stroke = vec![at];
            part = (part + 1) % dash.len();
            left = dash[part];
        }
    }
    if part % 2 == 0 {
        strokes.push(stroke);
    }
    strokes
}
