//! Colours, markers and dashes: what tells one line from another.
//!
//! The colours of lines are those of Okabe and Ito, which the common kinds of colour blindness keep apart; no figure
//! relies on hue alone: a marker, a dash or, for lines too dense for those, lightness goes with it.

use std::f64::consts::TAU;

/// Red, green and blue, 0 to 255.
pub type Rgb = (u8, u8, u8);

/// The background.
pub const PAPER: Rgb = (255, 255, 255);
/// Text and axes.
pub const INK: Rgb = (30, 30, 30);
/// Captions and lines of reference.
pub const GREY: Rgb = (95, 95, 95);
/// The grid.
pub const GRID: Rgb = (226, 226, 226);
/// What has no value.
pub const ABSENT: Rgb = (160, 160, 160);

/// The colours of Okabe and Ito, without the yellow that vanishes on white.
const FAMILIES: [Rgb; 7] =
    [(0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (0, 0, 0), (230, 159, 0), (86, 180, 233)];

/// The patterns of dashes in pixels, strokes and gaps in turn; the first is a whole line.
const DASHES: [&[f64]; 4] = [&[], &[9.0, 4.0], &[2.5, 3.5], &[9.0, 3.5, 2.5, 3.5]];

/// The colour of a family, or of the n-th line of a figure; they repeat after seven.
pub fn family(index: usize) -> Rgb {
    FAMILIES[index % FAMILIES.len()]
}

/// A colour mixed with much white, for what lies beneath a line of that colour.
pub fn pale((r, g, b): Rgb) -> Rgb {
    let mixed = |c: u8| (0.3 * f64::from(c) + 0.7 * 255.0).round() as u8;
    (mixed(r), mixed(g), mixed(b))
}

/// The colour of a signed value between −1 (blue) and 1 (red); 0 is almost white.
pub fn signed(value: f64) -> Rgb {
    colorous::RED_BLUE.eval_continuous((0.5 - 0.5 * value).clamp(0.0, 1.0)).as_tuple()
}

/// The colour of a value between 0 (dark) and 1 (light).
pub fn magnitude(value: f64) -> Rgb {
    colorous::VIRIDIS.eval_continuous(value.clamp(0.0, 1.0)).as_tuple()
}

/// The sign drawn at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Marker {
    Circle,
    Square,
    Up,
    Diamond,
    Down,
    Pentagon,
    Star,
    Left,
    Right,
    Asterisk,
    Cross,
}

impl Marker {
    /// The markers with an inside, which can be drawn full or hollow.
    pub const CLOSED: [Marker; 9] = [
        Marker::Circle,
        Marker::Square,
        Marker::Up,
        Marker::Diamond,
        Marker::Down,
        Marker::Star,
        Marker::Left,
        Marker::Pentagon,
        Marker::Right,
    ];

    /// The outline around the origin, or nothing for a marker made of strokes.
    pub(super) fn outline(self, radius: f64) -> Vec<(f64, f64)> {
        let (corners, first, scale, inner) = match self {
            Marker::Circle => (24, 0.0, 0.95, 1.0),
            Marker::Square => (4, 0.125, 1.2, 1.0),
            Marker::Up => (3, 0.75, 1.25, 1.0),
            Marker::Diamond => (4, 0.0, 1.25, 1.0),
            Marker::Down => (3, 0.25, 1.25, 1.0),
            Marker::Pentagon => (5, 0.75, 1.1, 1.0),
            Marker::Star => (10, 0.75, 1.45, 0.45),
            Marker::Left => (3, 0.5, 1.25, 1.0),
            Marker::Right => (3, 0.0, 1.25, 1.0),
            Marker::Asterisk | Marker::Cross => return Vec::new(),
        };
        (0..corners)
            .map(|k| {
                let r = radius * scale * if k % 2 == 1 { inner } else { 1.0 };
                let (sin, cos) = (TAU * (first + f64::from(k) / f64::from(corners))).sin_cos();
                (r * cos, r * sin)
            })
            .collect()
    }

    /// The strokes around the origin of a marker without an inside.
    pub(super) fn strokes(self, radius: f64) -> Vec<[(f64, f64); 2]> {
        let angles: &[f64] = match self {
            Marker::Asterisk => &[0.0, 60.0, 120.0],
            Marker::Cross => &[45.0, 135.0],
            _ => &[],
        };
        angles
            .iter()
            .map(|angle| {
                let (sin, cos) = (angle + 90.0).to_radians().sin_cos();
                let (x, y) = (1.2 * radius * cos, 1.2 * radius * sin);
                [(-x, -y), (x, y)]
            })
            .collect()
    }
}

/// How a line looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// Its colour.
    pub colour: Rgb,
    /// Strokes and gaps in pixels; empty for a whole line.
    pub dash: &'static [f64],
    /// The sign at each point, if any.
    pub marker: Option<Marker>,
}

impl Style {
    /// The style of the n-th curve of a family: colour by family, marker and dash by the place in it.
    ///
    /// Within a family the pair of marker and dash repeats after 36 curves only.
    pub fn of_family(index: usize, nth: usize) -> Self {
        let nth = nth + 3 * (index / FAMILIES.len());
        let marker = Marker::CLOSED[nth % Marker::CLOSED.len()];
        Self { colour: family(index), dash: DASHES[nth % DASHES.len()], marker: Some(marker) }
    }

    /// The style of the n-th line of a figure without markers.
    pub fn plain(nth: usize) -> Self {
        Self { colour: family(nth), dash: DASHES[(nth + nth / FAMILIES.len()) % DASHES.len()], marker: None }
    }

    /// The style of the n-th of a few lines so dense that dashes would not show: whole, and told apart by lightness.
    pub fn dense(nth: usize) -> Self {
        Self { colour: family([0, 5, 4, 2][nth % 4]), dash: &[], marker: None }
    }

    /// The style of a strain profile: squares for what was computed, then stars and crosses for approximations.
    pub fn of_profile(nth: usize) -> Self {
        let marker = [Marker::Square, Marker::Asterisk, Marker::Cross][nth % 3];
        Self { marker: Some(marker), ..Self::plain(nth) }
    }
}
