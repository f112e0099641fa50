//! Certificates: what is to be proved, with a cosine sum near the solution.

use crate::{
    check::{bloch, fold, infinite, multiplier},
    exact::Exact,
    untrusted::read::{self, RULES},
};
use std::fmt::{self, Display, Formatter};

pub use crate::check::{bloch::Bloch, multiplier::Multiplier};

pub(crate) const HEAD: &str = "hertzchain certificate 2";

/// The parameters of chain and orbit, exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// Exponent of contacts, above 1.
    pub alpha: Exact,
    /// Spring constant of resonators, above 0.
    pub kappa: Exact,
    /// Mass ratio resonator to bead, at least 0; `None` for infinity, resonators that do not move.
    pub rho: Option<Exact>,
    /// Frequency of the orbit; of a piece of a branch that of its start.
    pub omega: Exact,
}

/// The symmetry of a dark breather under reflection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Center {
    /// `x_{-n}(t) = x_n(t + T/2)`.
    Site,
    /// `x_{1-n}(t) = x_n(t)`.
    Bond,
}

impl Center {
    /// Its name in certificates.
    pub fn name(self) -> &'static str {
        if self == Self::Site { "site" } else { "bond" }
    }
}

/// What a certificate is about.
#[derive(Clone, Debug, PartialEq)]
pub enum Orbit {
    /// A periodic travelling wave `x_n = X(q n - omega t)`, `X = mean + sum a_k cos k theta`.
    Wave {
        /// `q/pi`.
        q_over_pi: Exact,
    },
    /// A dark breather of a ring, `x_n = sum_k a_nk cos k omega t`, with rows of the sites from 0
    /// (site-centred) or 1 (bond-centred) to the far end. The reflection maps them to all others.
    Breather {
        /// Length of the ring, odd.
        sites: usize,
        /// Reflection.
        center: Center,
    },
    /// A dark breather of the infinite chain. Rows are those of the sites up to the last one that
    /// differs from a standing wave, `x_n = X(omega t + pi n)`.
    Infinite {
        /// Reflection.
        center: Center,
        /// `eta`: the distance from the standing wave decays as `e^{-eta n}`.
        decay: Exact,
        /// `J`: an entry of the approximate inverse couples sites at most this far apart.
        band: usize,
        /// `0, a_1, a_2, ...` of the standing wave, whose mean is exact.
        background: Vec<f64>,
    },
}

/// All that the checker gets.
#[derive(Clone, Debug, PartialEq)]
pub struct Certificate {
    /// Chain and frequency.
    pub model: Model,
    /// Mean strain; of a piece of a branch that of its start.
    pub mean: Exact,
    /// Frequency and mean strain at the end of a piece of a branch, along which both are linear;
    /// both 0 of a piece down to amplitude zero.
    pub to: Option<[Exact; 2]>,
    /// `a_1` at the start and at the end of a piece of a branch of waves whose frequency is not
    /// known, but between those of start and end. Such pieces pass folds.
    pub first: Option<[Exact; 2]>,
    /// `K`: harmonics in the block of Newton's method.
    pub block: usize,
    /// `K'`: harmonics of the force that are enclosed.
    pub enclosed: usize,
    /// The orbit.
    pub orbit: Orbit,
    /// `a_nk` of each row, `k = 0, 1, ...`; 0 as the first one of a wave, whose mean is exact.
    pub a: Vec<Vec<f64>>,
    /// A multiplier of the orbit that is to be proved.
    pub multiplier: Option<Multiplier>,
    /// Perturbations of a wave, piece by piece.
    pub bloch: Vec<Bloch>,
}

impl Certificate {
    /// `H`: harmonics of the cosine sum.
    pub fn harmonics(&self) -> usize {
        self.a.first().map_or(0, |row| row.len().saturating_sub(1))
    }

    /// Whether it is of a wave.
    pub fn is_wave(&self) -> bool {
        matches!(self.orbit, Orbit::Wave { .. })
    }

    /// Which of the rules hold that the checker relies on; `read::RULES` has their words.
    pub(crate) fn rules(&self) -> [bool; RULES.len()] {
        let Self { model: Model { alpha, kappa, rho, omega }, to, block, enclosed, orbit, a, .. } = self;
        let h = self.harmonics();
        let (rows, [short, odd], center) = match orbit {
            Orbit::Wave { q_over_pi: q } => (1, [q.num().abs().max(q.den()) < 1 << 40, true], Center::Bond),
            Orbit::Breather { sites, center } => (sites / 2 + 1, [true, sites % 2 == 1 && *sites > 1], *center),
            Orbit::Infinite { center, .. } => (a.len(), [true; 2], *center),
        };
        let [alone, far] = infinite::rules(self);
        let even = |row: &Vec<f64>| row.iter().skip(1).step_by(2).all(|a| *a == 0.0);
        [
            short,
            odd,
            alone,
            far,
            a.len() == rows && rows > 0 && a.iter().all(|row| row.len() == h + 1),
            alpha.num() > alpha.den(),
            kappa.num() > 0,
            rho.is_none_or(|rho| rho.num() >= 0),
            rho.is_some() || self.is_wave(),
            omega.num() > 0 && to.is_none_or(|[omega, _]| omega.num() > 0 || self.is_to_zero()),
            1 <= *block && *block <= h,
            h.max(block.saturating_mul(4)) <= *enclosed,
            fold::rule(self),
            center == Center::Bond || a.first().is_none_or(even),
            multiplier::rule(self),
            bloch::rule(self),
        ]
    }
}

impl Display for Certificate {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { model: Model { alpha, kappa, rho, omega }, mean, block, enclosed, .. } = self;
        let row = |row: &[f64]| row.iter().map(|x| format!(" {:016x}", x.to_bits())).collect::<String>();
        let (kind, orbit) = match &self.orbit {
            Orbit::Wave { q_over_pi } => ("wave", format!("q_over_pi {q_over_pi}")),
            Orbit::Breather { sites, center } => ("breather", format!("sites {sites}\ncenter {}", center.name())),
            Orbit::Infinite { center, decay, band, background } => {
                let far = row(&background[1..]);
                ("infinite", format!("center {}\ndecay {decay}\nband {band}\nbackground{far}", center.name()))
            }
        };
        let rho = rho.map_or("inf".to_owned(), |rho| rho.to_string());
        let to = |[omega, mean]: [Exact; 2]| format!("to {omega} {mean}\n");
        let to = if self.is_to_zero() { "to zero\n".to_owned() } else { self.to.map_or(String::new(), to) };
        let first = self.first.map_or(String::new(), |[start, end]| format!("first {start} {end}\n"));
        let bloch = self.bloch.iter().map(Bloch::to_string);
        let multipliers: String = self.multiplier.iter().map(Multiplier::to_string).chain(bloch).collect();
        let rows: String = self.a.iter().map(|a| format!("a{}\n", row(&a[usize::from(self.is_wave())..]))).collect();
        write!(
            f,
            "{HEAD}\nkind {kind}\nalpha {alpha}\nkappa {kappa}\nrho {rho}\nomega {omega}\nmean {mean}\n{to}{first}"
        )?;
        write!(f, "block {block}\nenclosed {enclosed}\n{multipliers}{orbit}\n{rows}")
    }
}

/// The certificates of a text, one after the other. The text must be what they are written as: no
/// proof rests on the reader.
///
/// # Errors
/// The rule that the text breaks.
pub fn pieces(text: &str) -> Result<Vec<Certificate>, String> {
    let read = read::certificates(text)?;
    let written: String = read.iter().map(Certificate::to_string).collect();
    if text.lines().eq(written.lines()) { Ok(read) } else { Err(read::unlike(text, &written)) }
}
