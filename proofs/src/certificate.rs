//! Certificates: what is to be proved, with a cosine sum near the solution.

use crate::{exact::Exact, interval::Interval};
use std::str::FromStr;

pub(crate) const HEAD: &str = "hertzchain certificate 2";
/// Largest number of harmonics.
const MOST: usize = 4096;
/// Largest block of Newton's method, in unknowns.
const LARGEST_BLOCK: usize = 2500;
/// Disc in which a multiplier of a wave needs bounds, over the disc in which it is.
pub(crate) const WIDER: usize = 256;
/// Largest number of sites of a ring.
const MOST_SITES: usize = 401;

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

/// A periodic travelling wave `x_n = X(q n - omega t)`, `X = mean + sum a_k cos k theta`.
#[derive(Clone, Debug, PartialEq)]
pub struct Wave {
    /// `q/pi`.
    pub q_over_pi: Exact,
    /// `a_1, a_2, ...`.
    pub a: Vec<f64>,
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
        match self {
            Self::Site => "site",
            Self::Bond => "bond",
        }
    }
}

/// A dark breather of a ring of `sites` strains, `x_n = sum_k a_{nk} cos(k omega t)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Breather {
    /// Length of the ring, odd.
    pub sites: usize,
    /// Reflection.
    pub center: Center,
    /// `a_{nk}` of the sites from 0 (site-centred) or 1 (bond-centred) to the far end, which the
    /// reflection maps to all others; `k = 0, 1, ...`.
    pub a: Vec<Vec<f64>>,
}

impl Breather {
    /// The harmonic of the background: 2 if the period is doubled.
    pub fn background(&self) -> usize {
        let most = |k: usize| self.a.iter().filter_map(|a| a.get(k)).fold(0.0, |most: f64, a| most.max(a.abs()));
        1 + usize::from(most(2) > most(1))
    }
}

/// A dark breather of the infinite chain. Far from its centre it is a standing wave,
/// `x_n = X(omega t + pi n)`, `X = mean + sum a_k cos k theta`.
#[derive(Clone, Debug, PartialEq)]
pub struct Infinite {
    /// Reflection.
    pub center: Center,
    /// `eta`: the distance from the standing wave decays as `e^{-eta n}`.
    pub decay: Exact,
    /// `J`: an entry of the approximate inverse couples sites at most this far apart.
    pub band: usize,
    /// `a_1, a_2, ...` of the standing wave.
    pub background: Vec<f64>,
    /// `a_{nk}` of the sites from 0 (site-centred) or 1 (bond-centred) to the last one that differs
    /// from the standing wave; `k = 0, 1, ...`.
    pub a: Vec<Vec<f64>>,
}

impl Infinite {
    /// Whether the strains of a site shifted by half a period a site have the negative of harmonic
    /// `k`.
    pub(crate) fn is_turned(&self, n: usize, k: usize) -> bool {
        (n + usize::from(self.center == Center::Bond)) * k % 2 == 1
    }

    /// Sites of the finite section from which all constants of the proof follow.
    pub(crate) fn section(&self) -> usize {
        self.band.saturating_mul(2).saturating_add(self.a.len() + 4)
    }
}

/// What a certificate is about.
#[derive(Clone, Debug, PartialEq)]
pub enum Orbit {
    /// A travelling wave.
    Wave(Wave),
    /// A dark breather of a ring.
    Breather(Breather),
    /// A dark breather of the infinite chain.
    Infinite(Infinite),
}

impl Orbit {
    /// The coefficients of the sites that have some; of a wave from `a_1` on, else from `a_{n0}`
    /// on.
    pub fn rows(&self) -> &[Vec<f64>] {
        match self {
            Self::Wave(wave) => std::slice::from_ref(&wave.a),
            Self::Breather(breather) => &breather.a,
            Self::Infinite(infinite) => &infinite.a,
        }
    }
}

/// A Floquet multiplier: a real one of a dark breather, of a perturbation that the reflection maps
/// to its negative, or one of a wave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Multiplier {
    /// `e^{lambda T}` with a growth rate `lambda` between these two.
    Growing([Exact; 2]),
    /// -1, of a piece of a branch.
    Doubling {
        /// Whether the perturbation is a sum of sines, and not of cosines.
        sine: bool,
    },
    /// Of a wave, `e^{lambda T}` of a perturbation `e^{i p n + lambda t} W(q n - omega t)`.
    Bloch {
        /// The Bloch wave number, as `p/pi`.
        p_over_pi: Exact,
        /// Growth rate and frequency, real and imaginary part of a number near `lambda`.
        rate: [Exact; 2],
        /// `lambda` is at most this far from it.
        radius: Exact,
    },
}

/// All that the checker gets.
#[derive(Clone, Debug, PartialEq)]
pub struct Certificate {
    /// Chain and frequency.
    pub model: Model,
    /// Mean strain; of a piece of a branch that of its start.
    pub mean: Exact,
    /// Frequency and mean strain at the end of a piece of a branch, along which both are linear.
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
    /// A multiplier of the orbit that is to be proved.
    pub multiplier: Option<Multiplier>,
}

impl Certificate {
    /// `H`: harmonics of the cosine sum.
    pub fn harmonics(&self) -> usize {
        let coefficients = self.orbit.rows().first().map_or(0, Vec::len);
        coefficients.saturating_sub(usize::from(!matches!(self.orbit, Orbit::Wave(_))))
    }

    /// Parameter and mean strain at the start and at the end; of a single orbit twice the same. The
    /// parameter is the frequency or, where this is unknown, `a_1`.
    pub fn ends(&self) -> [[Exact; 2]; 2] {
        let start = [self.model.omega, self.mean];
        let ends = [start, self.to.unwrap_or(start)];
        [0, 1].map(|i| [self.first.map_or(ends[i][0], |first| first[i]), ends[i][1]])
    }

    /// What all pieces of a branch share: the chain and the kind of orbit.
    pub fn frame(&self) -> Self {
        let mut frame = Self { mean: Exact::ONE, to: None, block: 0, enclosed: 0, multiplier: None, ..self.clone() };
        frame.model.omega = Exact::ONE;
        frame.first = self.first.map(|_| [Exact::ONE; 2]);
        match &mut frame.orbit {
            Orbit::Wave(wave) => wave.a.clear(),
            Orbit::Breather(breather) => breather.a.clear(),
            Orbit::Infinite(infinite) => infinite.a.clear(),
        }
        frame
    }

    /// The rules that the checker relies on, in words if one is broken.
    pub(crate) fn valid(&self) -> Result<(), String> {
        let Self { model: Model { alpha, kappa, rho, omega }, to, first, block, enclosed, multiplier, .. } = self;
        let (h, many) = (self.harmonics(), "the block has at most 2500 unknowns");
        let is_wave = matches!(self.orbit, Orbit::Wave(_));
        let mut rules = vec![
            (alpha.num() > alpha.den(), "alpha must be above 1"),
            (kappa.num() > 0, "kappa must be above 0"),
            (rho.is_none_or(|rho| rho.num() >= 0), "rho must be at least 0"),
            (omega.num() > 0 && to.is_none_or(|[omega, _]| omega.num() > 0), "omega must be above 0"),
            (1 <= *block && *block <= h, "block must be from 1 to the number of harmonics"),
            (
                h <= *enclosed && block.saturating_mul(4) <= *enclosed,
                "enclosed must be at least the harmonics and 4 block",
            ),
            (*enclosed <= MOST, "at most 4096 harmonics"),
            (
                first.is_none() || to.is_some() && is_wave,
                "first harmonics are those at the ends of a piece of a branch of waves",
            ),
            (self.orbit.rows().iter().flatten().all(|a| a.is_finite()), "coefficients must be finite"),
        ];
        let breather = |center: Center, a: &[Vec<f64>], sites: usize| {
            let odd = |a: &Vec<f64>| a.iter().skip(1).step_by(2).any(|a| *a != 0.0);
            let words = "the centre of a site-centred breather has even harmonics only";
            [
                (center == Center::Bond || !a.first().is_some_and(odd), words),
                (rho.is_some(), "the resonators of a breather move: rho must be finite"),
                (sites.saturating_mul(block.saturating_add(1)) < LARGEST_BLOCK, many),
                (a.iter().all(|a| a.len() == h + 1), "rows of as many coefficients"),
            ]
        };
        let below = |a: Interval, b: Exact| (b.enclosed() - a).is_positive();
        match &self.orbit {
            Orbit::Wave(wave) => {
                let short = |it: Exact| it.num().abs() < 1 << 40 && it.den() < 1 << 40;
                let fits = multiplier.is_none_or(|it| match it {
                    Multiplier::Bloch { p_over_pi, rate: [growth, frequency], radius } => {
                        let wide = Interval::exact(WIDER as f64) * radius.enclosed();
                        let growing = radius.num() > 0 && below(wide, growth);
                        to.is_none() && short(p_over_pi) && growing && below(frequency.enclosed().abs() + wide, *omega)
                    }
                    _ => false,
                });
                let words = "a multiplier of a wave is bloch, of one wave, with p/pi of at most 12 digits, a radius \
                             above 0, a growth rate above 256 radius, and |frequency| + 256 radius below omega";
                rules.extend([
                    (*block <= LARGEST_BLOCK, many),
                    (short(wave.q_over_pi), "q_over_pi has at most 12 digits"),
                    (fits, words),
                ]);
            }
            Orbit::Breather(Breather { sites, center, a }) => {
                let fits = multiplier.is_none_or(|it| match it {
                    Multiplier::Growing([from, last]) => to.is_none() && from.num() > 0 && below(from.enclosed(), last),
                    Multiplier::Doubling { .. } => to.is_some() && *center == Center::Bond,
                    Multiplier::Bloch { .. } => false,
                });
                let words = "a multiplier is growing, of one breather, at growth rates above 0, the larger one last; \
                             or -1, of a piece of a branch of bond-centred ones";
                rules.push((sites % 2 == 1 && (3..=MOST_SITES).contains(sites), "sites must be odd, from 3 to 401"));
                rules.extend(breather(*center, a, a.len()));
                let rows = "a row of coefficients for each site from the centre to the far end";
                rules.extend([(a.len() == sites / 2 + 1, rows), (fits, words)]);
            }
            Orbit::Infinite(it @ Infinite { center, decay, band, background, a }) => {
                let reach = decay.enclosed() * Interval::exact(it.section() as f64);
                let near = (Interval::exact(500.0) - reach).is_positive();
                let finer = "the background has at least the harmonics of the sites, at most 4096";
                rules.extend([
                    (multiplier.is_none(), "a multiplier is that of a wave or of a breather of a ring"),
                    (to.is_none(), "a breather of the infinite chain is no piece of a branch"),
                    (decay.num() > 0, "decay must be above 0"),
                    (*band >= 1 && *band <= MOST_SITES, "band must be from 1 to 401"),
                    (!a.is_empty(), "a row of coefficients for one site at least"),
                    (background.iter().all(|a| a.is_finite()), "coefficients must be finite"),
                    ((h..=MOST).contains(&background.len()), finer),
                ]);
                rules.extend(breather(*center, a, it.section()));
                rules.push((near, "decay times the sites must be below 500"));
            }
        }
        rules.into_iter().find(|(holds, _)| !holds).map_or(Ok(()), |(_, words)| Err(words.to_owned()))
    }
}

/// The lines of a certificate, one after the other.
struct Lines<'a>(std::iter::Peekable<std::str::Lines<'a>>);

impl<'a> Lines<'a> {
    /// What is after this key, if the next line begins with it.
    fn given(&mut self, key: &str) -> Option<&'a str> {
        let rest = self.0.peek()?.strip_prefix(key)?.strip_prefix(' ')?;
        self.0.next().map(|_| rest)
    }

    /// The same, of a line that must be there.
    fn needed(&mut self, key: &str) -> Result<&'a str, String> {
        let found = self.0.peek().map_or("the end".to_owned(), |line| format!("\"{}\"", shown(line)));
        self.given(key).ok_or_else(|| format!("the line {key} is missing, before {found}"))
    }

    fn fraction(&mut self, key: &str) -> Result<Exact, String> {
        self.needed(key)?.parse()
    }

    fn whole(&mut self, key: &str) -> Result<usize, String> {
        let text = self.needed(key)?;
        text.parse().map_err(|_| format!("\"{}\" is no whole number", shown(text)))
    }

    fn center(&mut self) -> Result<Center, String> {
        let name = self.needed("center")?;
        let named = [Center::Site, Center::Bond].into_iter().find(|one| one.name() == name);
        named.ok_or_else(|| format!("center {} is neither site nor bond", shown(name)))
    }
}

/// As many fractions as there are.
fn fractions<const N: usize>(text: &str, what: &str) -> Result<[Exact; N], String> {
    let all = text.split(' ').map(str::parse).collect::<Result<Vec<Exact>, _>>()?;
    all.try_into().map_err(|_| format!("\"{}\" is not {what}", shown(text)))
}

/// Doubles by their bits, 16 hexadecimal digits each.
fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let number = |text: &str| {
        let bits = u64::from_str_radix(text, 16).ok().filter(|_| text.len() == 16 && !text.starts_with('+'));
        bits.map(f64::from_bits).ok_or_else(|| format!("\"{}\" is no double of 16 hexadecimal digits", shown(text)))
    };
    text.split(' ').map(number).collect()
}

/// The first characters of a text.
fn shown(text: &str) -> String {
    text.chars().take(60).collect()
}

impl FromStr for Certificate {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut lines = Lines(text.lines().peekable());
        if lines.0.next() != Some(HEAD) {
            return Err(format!("its first line is not \"{HEAD}\""));
        }
        let kind = lines.needed("kind")?;
        let [alpha, kappa] = [lines.fraction("alpha")?, lines.fraction("kappa")?];
        let rho = Some(lines.needed("rho")?).filter(|rho| *rho != "inf").map(str::parse).transpose()?;
        let model = Model { alpha, kappa, rho, omega: lines.fraction("omega")? };
        let mean = lines.fraction("mean")?;
        let to = lines.given("to").map(|text| fractions(text, "a frequency and a mean strain")).transpose()?;
        let first = lines.given("first").map(|text| fractions(text, "two first harmonics")).transpose()?;
        let (block, enclosed) = (lines.whole("block")?, lines.whole("enclosed")?);
        let multiplier = lines.given("multiplier").map(|text| match text.split_once(' ') {
            Some(("growing", rates)) => fractions(rates, "two growth rates").map(Multiplier::Growing),
            Some(("-1", part @ ("cosine" | "sine"))) => Ok(Multiplier::Doubling { sine: part == "sine" }),
            Some(("bloch", rest)) => {
                let [p_over_pi, growth, frequency, radius] =
                    fractions(rest, "p/pi, a growth rate, a frequency and a radius")?;
                Ok(Multiplier::Bloch { p_over_pi, rate: [growth, frequency], radius })
            }
            _ => Err(format!("multiplier {} is neither growing, nor -1 with cosine or sine, nor bloch", shown(text))),
        });
        let multiplier = multiplier.transpose()?;
        let mut orbit = match kind {
            "wave" => Orbit::Wave(Wave { q_over_pi: lines.fraction("q_over_pi")?, a: Vec::new() }),
            "breather" => {
                Orbit::Breather(Breather { sites: lines.whole("sites")?, center: lines.center()?, a: Vec::new() })
            }
            "infinite" => Orbit::Infinite(Infinite {
                center: lines.center()?,
                decay: lines.fraction("decay")?,
                band: lines.whole("band")?,
                background: numbers(lines.needed("background")?)?,
                a: Vec::new(),
            }),
            other => return Err(format!("kind {} is neither wave, breather nor infinite", shown(other))),
        };
        match &mut orbit {
            Orbit::Wave(wave) => wave.a = numbers(lines.needed("a")?)?,
            Orbit::Breather(Breather { a, .. }) | Orbit::Infinite(Infinite { a, .. }) => {
                while let Some(row) = lines.given("a") {
                    a.push(numbers(row)?);
                }
            }
        }
        match lines.0.next() {
            Some(line) => Err(format!("the line \"{}\" is not expected here", shown(line))),
            None => Ok(Self { model, mean, to, first, block, enclosed, orbit, multiplier }),
        }
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
