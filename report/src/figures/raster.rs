//! Rasters: contacts as bars over time, with one row for each bond.

use std::ops::Range;

use super::axes::{Axes, Axis};
use super::canvas::{Error, LABEL, Picture, SIZE, page, usable};
use super::colour_bar::{ColourBar, range_with_zero};
use super::palette::{self, Rgb};
use super::{Bar, Raster};

/// The share of a row that stays free between the bars of neighbours, if it is at least a pixel.
const GAP: f64 = 0.2;

impl Raster {
    /// Whether a part of the bar lies inside the axes.
    fn shows(&self, bar: &Bar) -> bool {
        let ((first, last), (start, end)) = (self.bonds, self.times);
        (first..=last).contains(&bar.bond) && bar.start <= end && bar.end >= start
    }
}

/// Draws contacts as bars over time, the larger the darker, with a colour bar; or the note that
/// there was no contact.
///
/// A bar shorter or lower than a pixel is drawn one pixel wide or high, and of several bars that
/// share a pixel the one with the largest magnitude is shown. So each contact is visible, but a gap
/// shorter than a pixel may be invisible. Bars end at the edges of the axes.
///
/// # Errors
///
/// Bonds, times or a bar that are not finite or decrease, or more text than fits.
pub fn raster(figure: &Raster) -> Result<Picture, Error> {
    let ((first, last), (start, end)) = (figure.bonds, figure.times);
    let forward = |lo: f64, hi: f64| usable(lo) && usable(hi) && lo <= hi;
    if !(forward(first, last) && forward(start, end)) {
        return Err(Error(format!("a raster cannot run from bond {first} to {last} and from time {start} to {end}")));
    }
    if let Some(bar) = figure.bars.iter().find(|bar| !(usable(bar.bond) && forward(bar.start, bar.end))) {
        return Err(Error(format!(
            "a contact of bond {} cannot last from time {} to {}",
            bar.bond, bar.start, bar.end
        )));
    }
    let bars: Vec<&Bar> = figure.bars.iter().filter(|bar| figure.shows(bar)).collect();
    let (lo, hi) = range_with_zero(bars.iter().map(|bar| bar.shade));
    // Dark colours are large magnitudes; the lightest tenth of the colours is too faint on paper.
    let colour = |shade: f64| match shade {
        _ if !usable(shade) => palette::ABSENT,
        _ => palette::magnitude(0.9 * (hi - shade) / (hi - lo)),
    };

    let (mut canvas, body) = page(SIZE, &figure.title, &figure.caption)?;
    let key = (!bars.is_empty()).then(|| ColourBar::new((lo, hi), &figure.shade_label, body.height()));
    let area = key.as_ref().map_or(body, |key| key.beside(body));
    let t = Axis::exact(start, end, false);
    let n = Axis::exact(first - 0.5, last + 0.5, true);
    let axes = Axes::draw(&mut canvas, area, (t, &figure.time_label), (n, &figure.bond_label), false)?;
    let frame = axes.frame;
    let pixels: Vec<Rgb> =
        largest(&axes, figure.bonds, &bars).into_iter().map(|shade| shade.map_or(palette::PAPER, colour)).collect();
    axes.image(&mut canvas, pixels);
    axes.close(&mut canvas);
    match key {
        Some(key) => key.draw(&mut canvas, frame, body.x1, colour),
        None => {
            let middle = ((frame.x0 + frame.x1) / 2.0, (frame.y0 + frame.y1) / 2.0);
            canvas.text("no contact", middle, LABEL, palette::GREY, (0.5, 0.5));
        }
    }
    Ok(canvas.picture(&figure.caption))
}

/// The largest magnitude at each pixel between the axes, row by row from the top; `None` where
/// there is no bar.
fn largest(axes: &Axes, bonds: (f64, f64), bars: &[&Bar]) -> Vec<Option<f64>> {
    let frame = axes.frame;
    let (wide, high) = (frame.width() as usize, frame.height() as usize);
    let row = high as f64 / (bonds.1 - bonds.0 + 1.0);
    // A gap of less than a pixel would appear between some bars and not between others.
    let half = if GAP * row >= 1.0 { 0.5 - 0.5 * GAP } else { 0.5 };
    let mut picture = vec![None; wide * high];
    for bar in bars {
        let corners = (axes.place((bar.start, bar.bond + half)), axes.place((bar.end, bar.bond - half)));
        let (Some((left, top)), Some((right, bottom))) = corners else { continue };
        let columns = pixels(left - frame.x0, right - frame.x0, wide);
        // f64::max ignores NaN, so a magnitude is never hidden by a missing one.
        let shade = if usable(bar.shade) { bar.shade } else { f64::NAN };
        for row in pixels(top - frame.y0, bottom - frame.y0, high) {
            for pixel in &mut picture[row * wide..][columns.clone()] {
                *pixel = Some(pixel.map_or(shade, |other: f64| other.max(shade)));
            }
        }
    }
    picture
}

/// The pixels between two positions, out of `count`; at least the pixel at the middle.
fn pixels(lo: f64, hi: f64, count: usize) -> Range<usize> {
    let [lo, hi] = [lo, hi].map(|edge| edge.clamp(0.0, count as f64));
    let (first, last) = (lo.round() as usize, hi.round() as usize);
    let middle = ((0.5 * (lo + hi)) as usize).min(count - 1);
    if first < last { first..last } else { middle..middle + 1 }
}
