//! Space-time maps: the values of a chain against site and time, in colour.

use super::SpaceTime;
use super::axes::{Axes, Axis};
use super::canvas::{Canvas, Error, Rect, usable};
use super::colour_bar::{ColourBar, range_with_zero};
use super::palette::{self, Rgb};

/// Draws a space-time map with its colour bar.
///
/// Of several entries that share a pixel the one with the largest modulus is shown: a wave narrower
/// than a pixel is drawn too wide, and not lost. Entries that are not finite are grey.
///
/// Refuses a matrix without entries or with an incomplete row, and times that are not finite or
/// decrease.
pub(super) fn draw(canvas: &mut Canvas, area: Rect, figure: &SpaceTime) -> Result<(), Error> {
    let (sites, (start, end)) = (figure.sites, figure.times);
    if sites == 0 || figure.values.is_empty() || !figure.values.len().is_multiple_of(sites) {
        return Err(Error(format!("{} values are no matrix with rows of {sites} sites", figure.values.len())));
    }
    if !(usable(start) && usable(end) && start <= end && usable(figure.first_site)) {
        return Err(Error(format!("a space-time map cannot run from time {start} to {end}")));
    }
    let rows = figure.values.len() / sites;
    let (lo, hi) = range(figure);
    let colour = |value: f64| match () {
        () if !usable(value) => palette::ABSENT,
        () if value > hi => palette::BEYOND[usize::from(figure.signed)],
        () if figure.signed => palette::signed(value / hi),
        () => palette::magnitude((value - lo) / (hi - lo)),
    };

    let beyond = figure.values.iter().any(|&value| value > hi);
    let mut bar = ColourBar::new((lo, hi), &figure.value_label, area.height());
    bar.beyond = beyond.then_some(palette::BEYOND[usize::from(figure.signed)]);

    // A row covers the time from half a step before it to half a step after it.
    let half = if end > start { 0.5 * (end - start) / (rows - 1).max(1) as f64 } else { 0.5 };
    let t = Axis::exact(start - half, end + half, false);
    let n = Axis::exact(figure.first_site - 0.5, figure.first_site + sites as f64 - 0.5, true);
    let axes = Axes::draw(canvas, bar.beside(area), (n, &figure.site_label), (t, &figure.time_label), false)?;
    let (wide, high) = (axes.frame.width() as usize, axes.frame.height() as usize);
    let pixels: Vec<Rgb> = largest(&figure.values, sites, (wide, high)).into_iter().map(colour).collect();
    axes.image(canvas, pixels);
    axes.close(canvas);
    bar.draw(canvas, axes.frame, area.x1, colour);
    Ok(())
}

/// The values at the ends of the colour bar.
fn range(figure: &SpaceTime) -> (f64, f64) {
    let most = figure.most.unwrap_or(f64::INFINITY);
    let within = figure.values.iter().copied().filter(|&value| usable(value) && value <= most);
    let (lo, hi) = range_with_zero(within.chain(figure.most));
    if figure.signed {
        let most = hi.max(-lo);
        (-most, most)
    } else {
        (lo, hi)
    }
}

/// Converts a matrix to a size in pixels, the last row on top; each pixel shows the largest of its
/// entries by modulus.
pub(super) fn largest(values: &[f64], sites: usize, (wide, high): (usize, usize)) -> Vec<f64> {
    let rows = values.len() / sites;
    // If cells are wider than pixels, a pixel shows the cell at its middle.
    let cover = |pixel: usize, pixels: usize, cells: usize| match (2 * pixel + 1) * cells / (2 * pixels) {
        middle if cells < pixels => middle..middle + 1,
        _ => pixel * cells / pixels..((pixel + 1) * cells).div_ceil(pixels),
    };
    let larger = |a: f64, b: f64| if usable(b) && (!usable(a) || b.abs() > a.abs()) { b } else { a };
    let mut picture = Vec::with_capacity(wide * high);
    let mut line = vec![f64::NAN; sites];
    for y in 0..high {
        line.fill(f64::NAN);
        for row in cover(high - 1 - y, high, rows) {
            let entries = &values[row * sites..(row + 1) * sites];
            line.iter_mut().zip(entries).for_each(|(best, &value)| *best = larger(*best, value));
        }
        picture.extend((0..wide).map(|x| line[cover(x, wide, sites)].iter().copied().fold(f64::NAN, larger)));
    }
    picture
}
