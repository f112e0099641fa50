//! Colours, markers and dashes of lines.
//!
//! The colours of lines are those of Okabe and Ito, which people with the common kinds of colour
//! blindness can distinguish. Lines differ not in hue alone: they also differ in marker, in dash
//! or, for lines too dense for these, in lightness.

use std::f64::consts::TAU;

/// Red, green and blue, 0 to 255.
pub type Rgb = (u8, u8, u8);

/// The background.
pub const PAPER: Rgb = (255, 255, 255);
/// Text and axes.
pub const INK: Rgb = (30, 30, 30);
/// Captions and reference lines.
pub const GREY: Rgb = (95, 95, 95);
/// The grid.
pub const GRID: Rgb = (226, 226, 226);
/// Cells and pixels without a value.
pub const ABSENT: Rgb = (160, 160, 160);
/// Values beyond the end of a scale without and with signs; on neither scale of colours. The first
/// is lighter than all of [`magnitude`], as those who confuse hues see.
pub const BEYOND: [Rgb; 2] = [PAPER, (214, 0, 147)];
/// Kinds of cells that have no place on the scale of colours.
pub const APART: [Rgb; 2] = [(222, 222, 222), (246, 196, 206)];

/// The colours of Okabe and Ito without yellow, which is hard to see on white.
const FAMILIES: [Rgb; 7] =
    [(0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (0, 0, 0), (230, 159, 0), (86, 180, 233)];

/// The integrators: of each group its colour, the number of its first marker, and its names. The
/// n-th name has the n-th marker and the n-th dash, in all pictures.
const METHODS: [(Rgb, usize, &str); 7] = [
    (
        FAMILIES[0],
        0,
        "verlet|yoshida4|aba864|srkn14-6|suzuki4|srkn6-4|aba1064|yoshida6|kahan-li6|srkn11-6|yoshida8|kahan-li8",
    ),
    (
        FAMILIES[1],
        1,
        "strang-linear|yoshida4-linear|aba1064-linear|srkn14-6-linear|kahan-li8-linear|suzuki4-linear|srkn6-4-linear|\
         aba864-linear|yoshida6-linear|kahan-li6-linear|srkn11-6-linear|yoshida8-linear",
    ),
    (FAMILIES[2], 3, "corrected|takahashi-imada-linear"),
    (FAMILIES[3], 5, "collocation"),
    (FAMILIES[4], 2, "dop853|dop853-landed|dop853-regularised"),
    (FAMILIES[6], 8, "discrete-gradient"),
    (GREY, 0, "plain Verlet|plain rotation + kick|plain Yoshida 4|plain rotation, Yoshida 4"),
];

/// The patterns of dashes in pixels, strokes and gaps in turn; the first is a solid line.
const DASHES: [&[f64]; 4] = [&[], &[9.0, 4.0], &[2.5, 3.5], &[9.0, 3.5, 2.5, 3.5]];

/// The colour of a family, or of the n-th line of a figure; colours repeat after seven.
pub fn family(index: usize) -> Rgb {
    FAMILIES[index % FAMILIES.len()]
}

/// The colour of a signed value between −1 (blue) and 1 (red); that of 0 is almost white.
pub fn signed(value: f64) -> Rgb {
    colorous::RED_BLUE.eval_continuous((0.5 - 0.5 * value).clamp(0.0, 1.0)).as_tuple()
}

/// The colour of a value between 0 (dark) and 1 (light).
pub fn magnitude(value: f64) -> Rgb {
    colorous::VIRIDIS.eval_continuous(value.clamp(0.0, 1.0)).as_tuple()
}

/// The sign drawn at a point of a line.
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
    /// The markers with an interior, which can be drawn full or hollow.
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

    /// The outline around the origin; empty for a marker made of strokes.
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

    /// The strokes around the origin of a marker without an interior.
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

/// The look of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// Colour of line and markers.
    pub colour: Rgb,
    /// Lengths of strokes and gaps in pixels; empty for a solid line.
    pub dash: &'static [f64],
    /// The sign at each point, if any.
    pub marker: Option<Marker>,
}

impl Style {
    /// The style of the n-th curve of a family: the family determines the colour, and `nth` the
    /// marker and the dash.
    ///
    /// Within a family the pairs of marker and dash repeat after 36 curves.
    pub fn of_family(index: usize, nth: usize) -> Self {
        let nth = nth + 3 * (index / FAMILIES.len());
        let marker = Marker::CLOSED[nth % Marker::CLOSED.len()];
        Self { colour: family(index), dash: DASHES[nth % DASHES.len()], marker: Some(marker) }
    }

    /// The style of an integrator or plain loop, by its name.
    pub fn of_method(name: &str) -> Option<Self> {
        METHODS.iter().find_map(|(colour, first, names)| {
            let nth = names.split('|').position(|known| known == name)?;
            let marker = Marker::CLOSED[(first + nth) % Marker::CLOSED.len()];
            Some(Self { colour: *colour, dash: DASHES[nth % DASHES.len()], marker: Some(marker) })
        })
    }

    /// The style of the n-th line of a figure without markers.
    pub fn plain(nth: usize) -> Self {
        Self { colour: family(nth), dash: DASHES[(nth + nth / FAMILIES.len()) % DASHES.len()], marker: None }
    }

    /// The style of the n-th line if lines are too dense for dashes: solid, with four colours of
    /// different lightness.
    pub fn dense(nth: usize) -> Self {
        Self { colour: family([0, 5, 4, 2][nth % 4]), dash: &[], marker: None }
    }

    /// The style of a strain profile: squares for computed values, then stars and crosses for
    /// approximations.
    pub fn of_profile(nth: usize) -> Self {
        let marker = [Marker::Square, Marker::Asterisk, Marker::Cross][nth % 3];
        Self { marker: Some(marker), ..Self::plain(nth) }
    }
}
