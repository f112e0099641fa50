//! Certificates: what is to be proved, with a cosine sum near the solution.

use crate::{exact::Exact, interval::Interval, untrusted::read};
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

    /// Whether in a strain shifted by half a period a site harmonic `k` has the opposite sign.
    /// Sites are counted from the centre.
    pub(crate) fn turns(self, n: usize, k: usize) -> bool {
        (n + usize::from(self == Self::Bond)) * k % 2 == 1
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
    Doubling {
        /// Whether the perturbation is a sum of sines, and not of cosines.
        sine: bool,
    },
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

    /// What all pieces of a branch share: the chain and the kind of orbit.
    pub fn frame(&self) -> Self {
        let (first, orbit) = (self.first.map(|_| [Exact::ONE; 2]), self.orbit.clone());
        let (model, mean) = (Model { omega: Exact::ONE, ..self.model }, Exact::ONE);
        Self {
            model,
            mean,
            to: None,
            first,
            block: 0,
            enclosed: 0,
            orbit,
            a: Vec::new(),
            multiplier: None,
            bloch: Vec::new(),
        }
    }

    /// The rules that the checker relies on, in words if one is broken.
    pub(crate) fn valid(&self) -> Result<(), String> {
        let Self { model: Model { alpha, kappa, rho, omega }, to, first, block, enclosed, orbit, a, .. } = self;
        let (h, zero) = (self.harmonics(), self.is_to_zero());
        let below = |a: Interval, b: Exact| (b.enclosed() - a).is_positive();
        let short = |it: Exact| it.num().abs() < 1 << 40 && it.den() < 1 << 40;
        let odd = |row: &Vec<f64>| row.iter().skip(1).step_by(2).any(|a| *a != 0.0);
        let multiplies = match (self.multiplier, orbit) {
            (None, _) => true,
            (Some(Multiplier::Growing([from, last])), Orbit::Breather { .. }) => {
                to.is_none() && from.num() > 0 && below(from.enclosed(), last)
            }
            (Some(Multiplier::Doubling { .. }), Orbit::Breather { center: Center::Bond, .. }) => to.is_some() && !zero,
            _ => false,
        };
        let grows = |it: &Bloch| {
            let [[re, im], [by_re, by_im]] = [it.rate, it.change].map(|it| it.map(Exact::enclosed));
            let [[from, to], radius] = [it.p_over_pi.map(Exact::enclosed), [it.radius.enclosed(); 2]];
            let ordered = it.p_over_pi[0] == it.p_over_pi[1] || (to - from).is_positive();
            let growing = (re - by_re.abs() - radius[0]).is_positive() && it.radius.num() > 0;
            ordered && growing && below(im.abs() + by_im.abs() + radius[1], *omega)
        };
        let joined = self.bloch.windows(2).all(|two| two[0].p_over_pi[1] == two[1].p_over_pi[0]);
        let modulated = self.bloch.is_empty() || joined && to.is_none() && self.is_wave();
        let (rows, site, own) = match orbit {
            Orbit::Wave { q_over_pi } => (1, false, [(short(*q_over_pi), "q_over_pi has at most 12 digits"); 2]),
            Orbit::Breather { sites, center } => (
                sites / 2 + 1,
                *center == Center::Site,
                [(sites % 2 == 1 && *sites > 1, "sites must be odd, from 3 to 401"); 2],
            ),
            Orbit::Infinite { center, decay, background, .. } => (
                a.len(),
                *center == Center::Site,
                [
                    (to.is_none(), "a breather of the infinite chain is no piece of a branch"),
                    (
                        decay.num() > 0 && background.len() > h,
                        "decay must be above 0, and the background has at least the harmonics of the sites",
                    ),
                ],
            ),
        };
        let common = [
            (
                a.len() == rows && rows > 0 && a.iter().all(|row| row.len() == h + 1),
                "a row of coefficients for each site, with as many of them",
            ),
            (alpha.num() > alpha.den(), "alpha must be above 1"),
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
            (!(site && a.first().is_some_and(odd)), "the centre of a site-centred breather has even harmonics only"),
            (
                multiplies,
                "a multiplier is growing, of one breather of a ring, at growth rates above 0, the larger one last; or -1, \
                 of a piece of a branch of bond-centred ones",
            ),
            (
                modulated && self.bloch.iter().all(grows),
                "lines bloch are of one wave: each begins where the one before it ends; of p/pi the larger one is last, and \
                 radius, growth rate - |change| - radius, and omega - |frequency| - |change| - radius are above 0",
            ),
        ];
        let broken = own.into_iter().chain(common).find(|(holds, _)| !holds);
        broken.map_or(Ok(()), |(_, words)| Err(words.to_owned()))
    }
}

/// The format.
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
        writeln!(f, "{HEAD}\nkind {kind}\nalpha {alpha}\nkappa {kappa}\nrho {rho}\nomega {omega}\nmean {mean}")?;
        match self.to {
            Some(_) if self.is_to_zero() => writeln!(f, "to zero")?,
            to => to.iter().try_for_each(|[omega, mean]| writeln!(f, "to {omega} {mean}"))?,
        }
        self.first.iter().try_for_each(|[start, end]| writeln!(f, "first {start} {end}"))?;
        writeln!(f, "block {block}\nenclosed {enclosed}")?;
        match &self.multiplier {
            Some(Multiplier::Growing([from, to])) => writeln!(f, "multiplier growing {from} {to}")?,
            Some(Multiplier::Doubling { sine }) => {
                writeln!(f, "multiplier -1 {}", if *sine { "sine" } else { "cosine" })?
            }
            None => {}
        }
        for Bloch { p_over_pi: [from, to], rate: [re, im], change: [by_re, by_im], radius } in &self.bloch {
            match from == to {
                true => writeln!(f, "multiplier bloch {from} {re} {im} {radius}")?,
                false => writeln!(f, "multiplier bloch {from} {to} {re} {im} {by_re} {by_im} {radius}")?,
            }
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
