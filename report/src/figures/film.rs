//! Films: a chain as beads that move, with its contacts lit and a curve below, as an animated GIF,
//! which browsers, slides and chats play alike.

use super::axes::{Axes, Axis};
use super::bitmap::Bitmap;
use super::canvas::{Canvas, Rect, SMALL};
use super::palette::{GREY, INK, Rgb, Style};
use super::{Error, page_of};
use crate::numerics::extremes;
use gif::{AnyExtension, Encoder, Extension, Frame, Repeat};

/// Width and height of a film in pixels.
pub const FILM_SIZE: (u32, u32) = (1000, 460);
/// The colours of a frame, by number.
type Drawn = Result<Vec<u8>, Error>;

/// The colour of a lit contact, one of the 216 of the file, as are those below.
pub const LIT: Rgb = (204, 102, 0);
/// Of beads, resonators and the curve.
const BLUES: [Rgb; 3] = [(153, 204, 255), (0, 51, 102), (0, 102, 153)];
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
    /// Centres of beads, whose diameter is 1, and of resonators inside them, which may be none.
    pub centres: [Vec<f64>; 2],
    /// Lit contacts: place, and size from 0 to 1.
    pub contacts: Vec<(f64, f64)>,
    /// The curve.
    pub line: Vec<(f64, f64)>,
}

/// Draws a film, at 25 frames a second, as the bytes of a GIF file that repeats. Its comment has
/// title and caption.
///
/// # Errors
/// No beads, a curve that cannot be drawn, or more text than fits.
pub fn film(film: &Film) -> Result<Vec<u8>, Error> {
    let (mut canvas, body) = page_of(FILM_SIZE, &film.title, &film.caption)?;
    // Beads are circles: the abscissa is so long that they fit into their row.
    let seen = |one: &Moment| one.line.iter().map(|point| point.0).chain(one.centres[0].clone()).collect::<Vec<_>>();
    let (left, right) = extremes(film.frames.iter().flat_map(seen));
    let (middle, half) = (0.5 * (left + right), (0.5 * (right - left) + 1.0).max(body.width() / LARGEST));
    let heights = film.frames.iter().flat_map(|moment| &moment.line).map(|point| point.1);
    let (x, y) = (Axis::exact(middle - half, middle + half, true), Axis::linear(heights.chain([0.0]), 0.06));
    let below = Rect { y0: body.y0 + ROW, ..body };
    let axes = Axes::draw(&mut canvas, below, (x, &film.labels[0]), (y, &film.labels[1]), false)?;
    for (x, _) in film.walls.iter().filter_map(|&wall| axes.place((wall, 0.0))) {
        canvas.line(&[(x, body.y0), (x, below.y0)], INK, 3.0, &[]);
    }
    let mut base = Bitmap::new(FILM_SIZE);
    base.draw_all(&canvas.picture(""))?;
    let draw = |moment: &Moment| -> Drawn {
        let mut bitmap = base.clone();
        bitmap.draw_all(&shapes(&axes, body.y0 + 0.5 * ROW, moment).picture(""))?;
        // The nearest of six levels of each colour.
        let index = |pixel: &[u8]| pixel.iter().fold(0, |index, &c| 6 * index + ((u16::from(c) + 25) / 51) as u8);
        Ok(bitmap.averaged().chunks_exact(3).map(index).collect())
    };
    let encoding = |error: gif::EncodingError| Error(format!("writing the GIF failed: {error}"));
    let palette: Vec<u8> = (0..216u8).flat_map(|k| [k / 36, k / 6 % 6, k % 6]).map(|level| 51 * level).collect();
    let (mut bytes, [width, height]) = (Vec::new(), [FILM_SIZE.0, FILM_SIZE.1].map(|pixels| pixels as u16));
    let mut encoder = Encoder::new(&mut bytes, width, height, &palette).map_err(encoding)?;
    encoder.set_repeat(Repeat::Infinite).map_err(encoding)?;
    let comment = format!("{}\n{}\n{}", film.title, film.caption, crate::output::PROGRAM);
    let blocks: Vec<&[u8]> = comment.as_bytes().chunks(255).collect();
    encoder.write_raw_extension(AnyExtension::from(Extension::Comment), &blocks).map_err(encoding)?;
    let mut before = Vec::new();
    for now in film.frames.chunks(TOGETHER).flat_map(|moments| side_by_side(moments, &draw)) {
        let now = now?;
        let same = |k: usize| before.get(k) == Some(&now[k]);
        let buffer = (0..now.len()).map(|k| if same(k) { UNCHANGED } else { now[k] }).collect();
        let frame = Frame { width, height, delay: 4, transparent: Some(UNCHANGED), buffer, ..Frame::default() };
        encoder.write_frame(&frame).map_err(encoding)?;
        before = now;
    }
    drop(encoder);
    Ok(bytes)
}

/// The pictures of some moments, on all cores.
fn side_by_side(moments: &[Moment], draw: &(dyn Fn(&Moment) -> Drawn + Sync)) -> Vec<Drawn> {
    #[cfg(feature = "parallel")]
    return rayon::iter::ParallelIterator::collect(rayon::iter::ParallelIterator::map(
        rayon::iter::IntoParallelRefIterator::par_iter(moments),
        draw,
    ));
    #[cfg(not(feature = "parallel"))]
    moments.iter().map(draw).collect()
}

/// What moves: beads at a height, and the curve.
fn shapes(axes: &Axes, level: f64, moment: &Moment) -> Canvas {
    let mut canvas = Canvas::new(FILM_SIZE, "");
    let across = |x: f64| axes.place((x, 0.0)).map_or(f64::NAN, |at| at.0);
    let radius = 0.5 * (across(1.0) - across(0.0));
    let mut oval = |x: f64, [wide, high]: [f64; 2], colour: Rgb| {
        let angles = (0..40).map(|k| std::f64::consts::TAU * f64::from(k) / 40.0);
        let corners = angles.map(|angle| (across(x) + wide * angle.cos(), level + high * angle.sin()));
        canvas.polygon(&corners.collect::<Vec<_>>(), colour);
    };
    for &x in &moment.centres[0] {
        oval(x, [radius; 2], INK);
        oval(x, [radius - (0.1 * radius).clamp(0.7, 1.5); 2], BLUES[0]);
    }
    moment.centres[1].iter().for_each(|&x| oval(x, [0.36 * radius; 2], BLUES[1]));
    for &(x, size) in &moment.contacts {
        oval(x, [(0.12 * radius).max(1.6), (0.4 + size) * radius], LIT);
    }
    canvas.text(&moment.time, (axes.frame.x1, level - 0.5 * ROW), SMALL, INK, (1.0, 0.0));
    let zero = Style { colour: GREY, dash: &[], marker: None };
    let ends = [moment.line.first(), moment.line.last()].into_iter().flatten().map(|point| (point.0, 0.0));
    axes.join(&mut canvas, &ends.collect::<Vec<_>>(), &zero);
    axes.join(&mut canvas, &moment.line, &Style { colour: BLUES[2], ..zero });
    canvas
}
