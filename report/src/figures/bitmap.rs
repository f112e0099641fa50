//! A picture as a PNG file.
//!
//! The buffer is [`FINE`] times finer than the picture and is averaged at the end, which smooths
//! every edge. Shapes are rasterised by `plotters`. Glyphs are placed here, with their side
//! bearings and kerning, because the text of `plotters` ignores the bearings.

use ab_glyph::Font;
use plotters::backend::{BitMapBackend, DrawingBackend};
use plotters::style::{Color, RGBColor};

use super::canvas::{CAPITALS, Error, FINE, FONT, Label, Picture, Shape, layout};
use super::palette::Rgb;

/// The PNG file, with title and caption as text chunks.
pub(super) fn png(picture: &Picture) -> Result<Vec<u8>, Error> {
    let mut bitmap = Bitmap::new(picture.size);
    picture.shapes.iter().try_for_each(|shape| bitmap.draw(shape))?;
    encoded(picture.size, &bitmap.averaged(), Some([&picture.title, &picture.caption]))
}

/// Pixels as a PNG file, with title and caption.
pub(super) fn encoded((width, height): (u32, u32), pixels: &[u8], words: Option<[&str; 2]>) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    // Without a filter flat colours repeat, which compresses best.
    encoder.set_filter(png::Filter::NoFilter);
    if let Some([title, caption]) = words {
        encoder.add_text_chunk("Software".into(), crate::output::PROGRAM.into()).map_err(encoding)?;
        encoder.add_itxt_chunk("Title".into(), title.into()).map_err(encoding)?;
        encoder.add_itxt_chunk("Description".into(), caption.into()).map_err(encoding)?;
    }
    let mut writer = encoder.write_header().map_err(encoding)?;
    writer.write_image_data(pixels).map_err(encoding)?;
    writer.finish().map_err(encoding)?;
    Ok(bytes)
}

/// The nearest corner of a fine pixel. A text that started between two rows would be rounded
/// unevenly and look faint.
fn snapped((x, y): (f64, f64)) -> (f64, f64) {
    let snap = |value: f64| (value * f64::from(FINE)).round() / f64::from(FINE);
    (snap(x), snap(y))
}

/// The fine pixels of a picture.
#[derive(Clone)]
pub(super) struct Bitmap {
    size: (u32, u32),
    fine: Vec<u8>,
}

impl Bitmap {
    /// A white bitmap.
    pub(super) fn new(size: (u32, u32)) -> Self {
        Self { size, fine: vec![255; (size.0 * size.1 * FINE * FINE * 3) as usize] }
    }

    fn backend(&mut self) -> BitMapBackend<'_> {
        BitMapBackend::with_buffer(&mut self.fine, (self.size.0 * FINE, self.size.1 * FINE))
    }

    fn draw(&mut self, shape: &Shape) -> Result<(), Error> {
        match shape {
            Shape::Line { points, colour, width, dash } if dash.is_empty() => self.line(points, *colour, *width),
            Shape::Line { points, colour, width, dash } => {
                dashes(points, dash).iter().try_for_each(|stroke| self.line(stroke, *colour, *width))
            }
            Shape::Polygon { points, colour } => self.polygon(points, *colour),
            Shape::Image { corner, width, pixels } => self.image(*corner, *width, pixels),
            Shape::Text(label) => self.text(label),
        }
    }

    fn line(&mut self, points: &[(f64, f64)], colour: Rgb, width: f64) -> Result<(), Error> {
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

    fn polygon(&mut self, points: &[(f64, f64)], colour: Rgb) -> Result<(), Error> {
        self.backend().fill_polygon(points.iter().copied().map(fine), &solid(colour)).map_err(drawing)
    }

    fn image(&mut self, corner: (u32, u32), width: usize, pixels: &[Rgb]) -> Result<(), Error> {
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

    fn text(&mut self, label: &Label) -> Result<(), Error> {
        let (x, y) = snapped(label.at);
        if label.upwards {
            self.glyphs(label, |u, v| (x + v, y - u))
        } else {
            self.glyphs(label, |u, v| (x + u, y + v))
        }
    }

    fn glyphs(&mut self, label: &Label, place: impl Fn(f64, f64) -> (f64, f64)) -> Result<(), Error> {
        let &Label { size, colour, anchor, .. } = label;
        let (glyphs, width) = layout(&label.text, size);
        let scale = f64::from(FINE);
        let (du, dv) = ((-anchor.0 * f64::from(width)).round(), (CAPITALS * (1.0 - anchor.1) * size * scale).round());
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

    /// The picture in its final size: each pixel is the mean of its fine pixels.
    pub(super) fn averaged(&self) -> Vec<u8> {
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
