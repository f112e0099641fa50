//! Certificates: what is to be proved, with a cosine sum near the solution.

use crate::{check::bloch, exact::Exact, untrusted::read};
use std::{
    fmt::{self, Display, Formatter},
    str::FromStr,
};

pub(crate) const HEAD: &str = "hertzchain certificate 2";

/// The parameters of chain and orbit, exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// Exponent of contacts, above 1.
    pub alpha: Exact,
    /// Spring constant of resonators, at least 0.
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
    /// A dark breather of a ring, `x_n = sum_k a_nk cos k omega t`. Rows are those of the sites
    /// from 0 (site-centred) or 1 (bond-centred) to the far end; the reflection maps them to all
    /// others.
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

/// A Floquet multiplier: a real one of a dark breather, of a perturbation that the reflection maps
/// to its negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Multiplier {
    /// `e^{lambda T}` with a growth rate `lambda` between these two.
    Growing([Exact; 2]),
    /// -1, of a piece of a branch.
    Doubling,
}

/// A perturbation `e^{i p n + lambda t} W(q n - omega t)` of a wave, for each `p` of an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bloch {
    /// The Bloch wave numbers at its ends, as `p/pi`.
    pub p_over_pi: [Exact; 2],
    /// Growth rate and frequency, real and imaginary part of a number near `lambda` in the middle.
    pub rate: [Exact; 2],
    /// By how much this changes from the middle to the end; it is linear in `p`.
    pub change: [Exact; 2],
    /// `lambda` is at most this far from it.
    pub radius: Exact,
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
    /// `a_1` at the start and at the end of a piece of a branch of waves whose frequency is
    /// unknown, between that of the start and that of the end. Such pieces pass folds.
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

    /// Sites of the equations; of the infinite chain those from which all constants follow.
    pub(crate) fn sites(&self) -> usize {
        match self.orbit {
            Orbit::Wave { .. } => 1,
            Orbit::Breather { sites, .. } => sites / 2 + 1,
            Orbit::Infinite { band, .. } => band.saturating_mul(2).saturating_add(self.a.len() + 4),
        }
    }

    /// Parameter and mean strain at the start and at the end; of a single orbit twice the same. The
    /// parameter is the frequency or, where this is unknown, `a_1`.
    pub fn ends(&self) -> [[Exact; 2]; 2] {
        let start = [self.model.omega, self.mean];
        let ends = [start, self.to.unwrap_or(start)];
        [0, 1].map(|i| [self.first.map_or(ends[i][0], |first| first[i]), ends[i][1]])
    }

    /// Whether it is a piece of a branch down to amplitude zero.
    pub fn is_to_zero(&self) -> bool {
        self.to == Some([Exact::ZERO; 2])
    }

    /// The rules that the checker relies on, in words if one is broken.
    pub(crate) fn valid(&self) -> Result<(), String> {
        let Self { model: Model { kappa, rho, omega, .. }, to, first, block, enclosed, orbit, a, .. } = self;
        let (h, zero) = (self.harmonics(), self.is_to_zero());
        let short = |it: Exact| it.num().abs() < 1 << 40 && it.den() < 1 << 40;
        let odd = |row: &Vec<f64>| row.iter().skip(1).step_by(2).any(|a| *a != 0.0);
        let (rows, center, holds, words) = match orbit {
            Orbit::Wave { q_over_pi } => (1, Center::Bond, short(*q_over_pi), "q_over_pi has at most 12 digits"),
            Orbit::Breather { sites, center } => {
                (sites / 2 + 1, *center, sites % 2 == 1 && *sites > 1, "sites must be odd, from 3 to 401")
            }
            Orbit::Infinite { center, decay, background, .. } => (
                a.len(),
                *center,
                decay.num() > 0 && background.len() > h && to.is_none(),
                "decay must be above 0, the background has at least the harmonics of the sites, and a breather of the \
                 infinite chain is no piece of a branch",
            ),
        };
        let rules = [
            (holds, words),
            (
                a.len() == rows && rows > 0 && a.iter().all(|row| row.len() == h + 1),
                "a row of coefficients for each site, with as many of them",
            ),
            (kappa.num() > 0, "kappa must be above 0"),
            (rho.is_none_or(|rho| rho.num() >= 0), "rho must be at least 0"),
            (self.is_wave() || rho.is_some(), "the resonators of a breather move: rho must be finite"),
            (omega.num() > 0 && to.is_none_or(|[omega, _]| omega.num() > 0 || zero), "omega must be above 0"),
            (1 <= *block && *block <= h, "block must be from 1 to the number of harmonics"),
            (h.max(block.saturating_mul(4)) <= *enclosed, "enclosed must be at least the harmonics and 4 block"),
            (
                first.is_none() || to.is_some() && self.is_wave() && !zero,
                "first harmonics are those at the ends of a piece of a branch of waves",
            ),
            (
                !(center == Center::Site && a.first().is_some_and(odd)),
                "the centre of a site-centred breather has even harmonics only",
            ),
        ];
        let broken = rules.into_iter().chain(bloch::rules(self)).find(|(holds, _)| !holds);
        broken.map_or(Ok(()), |(_, words)| Err(words.to_owned()))
    }
}

/// The format.
impl Display for Certificate {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { model: Model { alpha, kappa, rho, omega }, mean, block, enclosed, .. } = self;
        let row = |row: &[f64]| row.iter().map(|x| format!(" {:016x}", x.to_bits())).collect::<String>();
        let all = |all: &[Exact]| all.iter().map(|x| format!(" {x}")).collect::<String>();
        let (kind, orbit) = match &self.orbit {
            Orbit::Wave { q_over_pi } => ("wave", format!("q_over_pi {q_over_pi}")),
            Orbit::Breather { sites, center } => ("breather", format!("sites {sites}\ncenter {}", center.name())),
            Orbit::Infinite { center, decay, band, background } => {
                let far = row(&background[1..]);
                ("infinite", format!("center {}\ndecay {decay}\nband {band}\nbackground{far}", center.name()))
            }
        };
        let rho = rho.map_or("inf".to_owned(), |rho| rho.to_string());
        writeln!(f, "{HEAD}\nkind {kind}\nalpha {alpha}\nkappa {kappa}\nrho {rho}\nomega {omega}\nmean {mean}")?;
        let to = |it: &[Exact; 2]| if self.is_to_zero() { " zero".to_owned() } else { all(it) };
        self.to.iter().try_for_each(|it| writeln!(f, "to{}", to(it)))?;
        self.first.iter().try_for_each(|it| writeln!(f, "first{}", all(it)))?;
        writeln!(f, "block {block}\nenclosed {enclosed}")?;
        match &self.multiplier {
            Some(Multiplier::Growing(rates)) => writeln!(f, "multiplier growing{}", all(rates))?,
            Some(Multiplier::Doubling) => writeln!(f, "multiplier -1")?,
            None => {}
        }
        for Bloch { p_over_pi, rate, change, radius } in &self.bloch {
            let single = p_over_pi[0] == p_over_pi[1];
            let (p, change) = if single { (&p_over_pi[..1], &[][..]) } else { (&p_over_pi[..], &change[..]) };
            writeln!(f, "multiplier bloch{}{}{} {radius}", all(p), all(rate), all(change))?;
        }
        writeln!(f, "{orbit}")?;
        self.a.iter().try_for_each(|a| writeln!(f, "a{}", row(&a[usize::from(self.is_wave())..])))
    }
}

impl FromStr for Certificate {
    type Err = String;

    /// Reads a certificate. The text must be what this is written as: no proof rests on the reader.
    fn from_str(text: &str) -> Result<Self, String> {
        let read = read::certificate(text)?;
        let written = read.to_string();
        if text.lines().eq(written.lines()) { Ok(read) } else { Err(read::unlike(text, &written)) }
    }
}

/// The pieces of a text: one certificate after the other.
///
/// # Errors
/// The rule that a piece breaks.
pub fn pieces(text: &str) -> Result<Vec<Certificate>, String> {
    let later = text.match_indices(HEAD).map(|(at, _)| at).filter(|at| text[..*at].ends_with('\n'));
    let ends: Vec<usize> = std::iter::once(0).chain(later).chain([text.len()]).collect();
    ends.windows(2).map(|ends| text[ends[0]..ends[1]].parse()).collect()
}
