//! Films: a chain as beads that move, with its contacts lit and a curve below, as an animated GIF,
//! which browsers, slides and chats play alike.

use super::axes::{Axes, Axis};
use super::bitmap::Bitmap;
use super::canvas::{Canvas, Rect, SMALL};
use super::palette::{GREY, INK, Rgb, Style};
use super::{Error, page_of};
use crate::sweep::map;
use gif::{AnyExtension, Encoder, Extension, Frame, Repeat};
use std::f64::consts::TAU;

/// Width and height of a film in pixels.
pub const FILM_SIZE: (u32, u32) = (1000, 460);
/// The colour of a lit contact, one of the 216 of the file, as are those below.
pub const LIT: Rgb = (204, 102, 0);
const BEAD: Rgb = (153, 204, 255);
const RESONATOR: Rgb = (0, 51, 102);
const CURVE: Rgb = (0, 102, 153);
/// Height of the row of beads, and the largest diameter of a bead, in pixels.
const ROW: f64 = 110.0;
const LARGEST: f64 = 80.0;
/// Frames that are drawn at the same time, on all cores.
const TOGETHER: usize = 16;
/// The index of pixels that stay as they are.
const UNCHANGED: u8 = 216;

/// A film of a chain.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Film {
    /// Title at the top.
    pub title: String,
    /// Caption, enough to make the film again.
    pub caption: String,
    /// Labels of the axes of the curve.
    pub labels: [String; 2],
    /// Ends of the abscissa of beads and curve; neighbours that just touch are 1 apart.
    pub x: (f64, f64),
    /// Ends of the ordinate of the curve.
    pub y: (f64, f64),
    /// Places of walls.
    pub walls: Vec<f64>,
    /// The frames.
    pub frames: Vec<Moment>,
}

/// A frame of a film.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moment {
    /// The time, in words.
    pub time: String,
    /// Centres of the beads; their diameter is 1.
    pub beads: Vec<f64>,
    /// Centres of the resonators, drawn inside the beads; may be empty.
    pub resonators: Vec<f64>,
    /// Lit contacts: place, and size from 0 to 1.
    pub contacts: Vec<(f64, f64)>,
    /// The curve.
    pub line: Vec<(f64, f64)>,
}

/// Draws a film, at 25 frames a second, as the bytes of a GIF file that repeats. Its comment has
/// title and caption.
///
/// # Errors
/// Fewer than two frames, ranges without width, or more text than fits.
pub fn film(film: &Film) -> Result<Vec<u8>, Error> {
    if film.frames.len() < 2 {
        return Err(Error(format!("a film needs two frames or more, not {}", film.frames.len())));
    }
    let (mut canvas, body) = page_of(FILM_SIZE, &film.title, &film.caption)?;
    // Beads are circles: the abscissa is so long that they fit into their row.
    let (middle, half) = (0.5 * (film.x.0 + film.x.1), 0.5 * (film.x.1 - film.x.0).max(body.width() / LARGEST));
    let (x, y) = (Axis::exact(middle - half, middle + half, true), Axis::exact(film.y.0, film.y.1, false));
    let [x_label, y_label] = &film.labels;
    let axes = Axes::draw(&mut canvas, Rect { y0: body.y0 + ROW, ..body }, (x, x_label), (y, y_label), false)?;
    let level = body.y0 + 0.5 * ROW;
    for (x, _) in film.walls.iter().filter_map(|&wall| axes.place((wall, 0.0))) {
        canvas.line(&[(x, body.y0), (x, body.y0 + ROW)], INK, 3.0, &[]);
    }
    let mut base = Bitmap::new(FILM_SIZE);
    base.draw_all(&canvas.picture(""))?;
    let draw = |moment: &Moment| -> Result<Vec<u8>, Error> {
        let mut bitmap = base.clone();
        bitmap.draw_all(&shapes(&axes, level, moment).picture(""))?;
        // The nearest of six levels of each colour.
        let index = |pixel: &[u8]| pixel.iter().fold(0, |index, &c| 6 * index + ((u16::from(c) + 25) / 51) as u8);
        Ok(bitmap.averaged().chunks_exact(3).map(index).collect())
    };

    let palette: Vec<u8> = (0..216u8).flat_map(|k| [k / 36, k / 6 % 6, k % 6]).map(|level| 51 * level).collect();
    let (mut bytes, width, height) = (Vec::new(), FILM_SIZE.0 as u16, FILM_SIZE.1 as u16);
    let mut encoder = Encoder::new(&mut bytes, width, height, &palette).map_err(encoding)?;
    encoder.set_repeat(Repeat::Infinite).map_err(encoding)?;
    let comment = format!("{}\n{}\n{}", film.title, film.caption, crate::output::PROGRAM);
    let blocks: Vec<&[u8]> = comment.as_bytes().chunks(255).collect();
    encoder.write_raw_extension(AnyExtension::from(Extension::Comment), &blocks).map_err(encoding)?;
    let mut before = vec![UNCHANGED; (FILM_SIZE.0 * FILM_SIZE.1) as usize];
    for moments in film.frames.chunks(TOGETHER) {
        for now in map(moments, draw) {
            let now = now?;
            let changed = now.iter().zip(&before).map(|(now, before)| if now == before { UNCHANGED } else { *now });
            let (transparent, buffer) = (Some(UNCHANGED), changed.collect::<Vec<u8>>().into());
            let frame = Frame { width, height, delay: 4, transparent, buffer, ..Frame::default() };
            encoder.write_frame(&frame).map_err(encoding)?;
            before = now;
        }
    }
    drop(encoder);
    Ok(bytes)
}

fn encoding(error: gif::EncodingError) -> Error {
    Error(format!("writing the GIF failed: {error}"))
}

/// What moves: beads at a height, and the curve.
fn shapes(axes: &Axes, level: f64, moment: &Moment) -> Canvas {
    let mut canvas = Canvas::new(FILM_SIZE, "");
    let across = |x: f64| axes.place((x, 0.0)).map_or(f64::NAN, |at| at.0);
    let radius = 0.5 * (across(1.0) - across(0.0));
    let mut oval = |x: f64, [wide, high]: [f64; 2], colour: Rgb| {
        let corner = |k: i32| {
            let (sin, cos) = (TAU * f64::from(k) / 40.0).sin_cos();
            (across(x) + wide * cos, level + high * sin)
        };
        canvas.polygon(&(0..40).map(corner).collect::<Vec<_>>(), colour);
    };
    for &x in &moment.beads {
        oval(x, [radius; 2], INK);
        oval(x, [radius - (0.1 * radius).clamp(0.7, 1.5); 2], BEAD);
    }
    moment.resonators.iter().for_each(|&x| oval(x, [0.36 * radius; 2], RESONATOR));
    for &(x, size) in &moment.contacts {
        oval(x, [(0.12 * radius).max(1.6), (0.4 + size) * radius], LIT);
    }
    canvas.text(&moment.time, (axes.frame.x1, level - 0.5 * ROW), SMALL, INK, (1.0, 0.0));
    let zero = Style { colour: GREY, dash: &[], marker: None };
    let ends = [moment.line.first(), moment.line.last()].into_iter().flatten().map(|point| (point.0, 0.0));
    axes.join(&mut canvas, &ends.collect::<Vec<_>>(), &zero);
    axes.join(&mut canvas, &moment.line, &Style { colour: CURVE, ..zero });
    canvas
}
