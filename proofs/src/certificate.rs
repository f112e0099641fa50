//! Certificates: what is to be proved, with a cosine sum near the solution.

use crate::{exact::Exact, interval::Interval};
use std::{fmt, str::FromStr};

const HEAD: &str = "hertzchain certificate 1";
/// Keys of its lines, but for the coefficients.
const KEYS: &str =
    "kind alpha kappa rho omega mean to first block enclosed q_over_pi sites center multiplier decay band background";
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
    /// Sites of the finite section from which all constants of the proof follow.
    pub(crate) fn section(&self) -> usize {
        self.a.len() + 2 * self.band + 4
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
        let rule = |holds: bool, words: &str| if holds { Ok(()) } else { Err(words.to_owned()) };
        rule(alpha.num() > alpha.den(), "alpha must be above 1")?;
        rule(kappa.num() > 0, "kappa must be above 0")?;
        rule(rho.is_none_or(|rho| rho.num() >= 0), "rho must be at least 0")?;
        let positive = omega.num() > 0 && to.is_none_or(|[omega, _]| omega.num() > 0);
        rule(positive, "omega must be above 0")?;
        let h = self.harmonics();
        rule(1 <= *block && *block <= h, "block must be from 1 to the number of harmonics")?;
        rule(h <= *enclosed && 4 * block <= *enclosed, "enclosed must be at least the harmonics and 4 block")?;
        rule(*enclosed <= MOST, "at most 4096 harmonics")?;
        let piece = to.is_some() && matches!(self.orbit, Orbit::Wave(_));
        rule(first.is_none() || piece, "first harmonics are those at the ends of a piece of a branch of waves")?;
        let finite = |a: &[f64]| a.iter().all(|a| a.is_finite());
        let of_breather = |center: Center, a: &[Vec<f64>], sites: usize| {
            let odd = |a: &Vec<f64>| a.iter().skip(1).step_by(2).any(|a| *a != 0.0);
            let words = "the centre of a site-centred breather has even harmonics only";
            rule(center == Center::Bond || !a.first().is_some_and(odd), words)?;
            rule(rho.is_some(), "the resonators of a breather move: rho must be finite")?;
            rule(sites.saturating_mul(block + 1) < LARGEST_BLOCK, "the block has at most 2500 unknowns")?;
            rule(a.iter().all(|a| a.len() == h + 1 && finite(a)), "rows of as many finite coefficients")
        };
        let below = |a: Interval, b: Exact| (b.enclosed() - a).is_positive();
        match &self.orbit {
            Orbit::Wave(wave) => {
                rule(*block <= LARGEST_BLOCK, "the block has at most 2500 unknowns")?;
                let short = |it: Exact| it.num().abs() < 1 << 40 && it.den() < 1 << 40;
                rule(short(wave.q_over_pi), "q_over_pi has at most 12 digits")?;
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
                rule(fits, words)?;
                rule(finite(&wave.a), "coefficients must be finite")
            }
            Orbit::Breather(Breather { sites, center, a }) => {
                rule(sites % 2 == 1 && (3..=MOST_SITES).contains(sites), "sites must be odd, from 3 to 401")?;
                of_breather(*center, a, a.len())?;
                rule(a.len() == sites / 2 + 1, "a row of coefficients for each site from the centre to the far end")?;
                let fits = multiplier.is_none_or(|it| match it {
                    Multiplier::Growing([from, last]) => to.is_none() && from.num() > 0 && below(from.enclosed(), last),
                    Multiplier::Doubling { .. } => to.is_some() && *center == Center::Bond,
                    Multiplier::Bloch { .. } => false,
                });
                let words = "a multiplier is growing, of one breather, at growth rates above 0, the larger one last; \
                             or -1, of a piece of a branch of bond-centred ones";
                rule(fits, words)
            }
            Orbit::Infinite(infinite) => {
                let Infinite { center, decay, band, background, a } = infinite;
                rule(multiplier.is_none(), "a multiplier is that of a wave or of a breather of a ring")?;
                rule(to.is_none(), "a breather of the infinite chain is no piece of a branch")?;
                rule(decay.num() > 0, "decay must be above 0")?;
                rule(*band >= 1 && *band <= MOST_SITES, "band must be from 1 to 401")?;
                rule(!a.is_empty(), "a row of coefficients for one site at least")?;
                rule(finite(background), "coefficients must be finite")?;
                rule(
                    (h..=MOST).contains(&background.len()),
                    "the background has at least the harmonics of the sites, at most 4096",
                )?;
                of_breather(*center, a, infinite.section())?;
                let reach = decay.enclosed() * Interval::exact(infinite.section() as f64);
                rule((Interval::exact(500.0) - reach).is_positive(), "decay times the sites must be below 500")
            }
        }
    }
}

impl fmt::Display for Certificate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { model: Model { alpha, kappa, rho, omega }, mean, to, first, block, enclosed, orbit, multiplier } =
            self;
        let kind = match orbit {
            Orbit::Wave(_) => "wave",
            Orbit::Breather(_) => "breather",
            Orbit::Infinite(_) => "infinite",
        };
        let row = |row: &[f64]| row.iter().map(|x| hexadecimal(*x)).collect::<Vec<String>>().join(" ");
        let rho = rho.map_or("inf".to_owned(), |rho| rho.to_string());
        writeln!(f, "{HEAD}\nkind {kind}\nalpha {alpha}\nkappa {kappa}\nrho {rho}\nomega {omega}\nmean {mean}")?;
        if let Some([omega, mean]) = to {
            writeln!(f, "to {omega} {mean}")?;
        }
        if let Some([from, to]) = first {
            writeln!(f, "first {from} {to}")?;
        }
        writeln!(f, "block {block}\nenclosed {enclosed}")?;
        match multiplier {
            Some(Multiplier::Growing([from, to])) => writeln!(f, "multiplier growing {from} {to}")?,
            Some(Multiplier::Doubling { sine }) => {
                writeln!(f, "multiplier -1 {}", if *sine { "sine" } else { "cosine" })?
            }
            Some(Multiplier::Bloch { p_over_pi, rate: [growth, frequency], radius }) => {
                writeln!(f, "multiplier bloch {p_over_pi} {growth} {frequency} {radius}")?
            }
            None => {}
        }
        match orbit {
            Orbit::Wave(wave) => writeln!(f, "q_over_pi {}", wave.q_over_pi)?,
            Orbit::Breather(Breather { sites, center, .. }) => writeln!(f, "sites {sites}\ncenter {}", center.name())?,
            Orbit::Infinite(Infinite { center, decay, band, background, .. }) => {
                writeln!(f, "center {}\ndecay {decay}\nband {band}\nbackground {}", center.name(), row(background))?
            }
        }
        orbit.rows().iter().try_for_each(|one| writeln!(f, "a {}", row(one)))
    }
}

impl FromStr for Certificate {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut lines = text.lines();
        if lines.next() != Some(HEAD) {
            return Err(format!("its first line is not \"{HEAD}\""));
        }
        let (mut keys, mut rows) = (Vec::new(), Vec::new());
        let numbers = |row: &str| row.split(' ').map(from_hexadecimal).collect::<Result<Vec<f64>, _>>();
        let center = |name: &str| {
            let named = [Center::Site, Center::Bond].into_iter().find(|one| one.name() == name);
            named.ok_or_else(|| format!("center {name} is neither site nor bond"))
        };
        for line in lines.filter(|line| !line.is_empty()) {
            match line.split_once(' ') {
                Some(("a", row)) => rows.push(numbers(row)?),
                Some((key, _)) if !KEYS.split(' ').any(|known| known == key) => {
                    return Err(format!("the key {key} is not known"));
                }
                Some(entry) if keys.iter().all(|(key, _)| *key != entry.0) => keys.push(entry),
                _ => return Err(format!("the line \"{line}\" has no key, or one that was there before")),
            }
        }
        let mut given = |key: &str| {
            let place = keys.iter().position(|(name, _)| *name == key);
            place.map(|place| keys.swap_remove(place).1)
        };
        let mut two = |key: &str, what: &str| {
            let pair = |text: &str| {
                let (one, other) = text.split_once(' ').ok_or_else(|| format!("the line {key} has {what}"))?;
                Ok::<_, String>([one.parse()?, other.parse()?])
            };
            given(key).map(pair).transpose()
        };
        let to = two("to", "a frequency and a mean strain")?;
        let first = two("first", "two first harmonics")?;
        let multiplier = given("multiplier").map(|text| match text.split(' ').collect::<Vec<_>>()[..] {
            ["growing", from, to] => Ok(Multiplier::Growing([from.parse()?, to.parse()?])),
            ["-1", part @ ("cosine" | "sine")] => Ok(Multiplier::Doubling { sine: part == "sine" }),
            ["bloch", p, growth, frequency, radius] => Ok(Multiplier::Bloch {
                p_over_pi: p.parse()?,
                rate: [growth.parse()?, frequency.parse()?],
                radius: radius.parse()?,
            }),
            _ => Err(format!(
                "multiplier {text} is neither growing with two rates, nor -1 with cosine or sine, nor bloch with \
                 p/pi, a growth rate, a frequency and a radius"
            )),
        });
        let multiplier = multiplier.transpose()?;
        let mut take = |key: &str| given(key).ok_or_else(|| format!("the line {key} is missing"));
        let rho = take("rho")?;
        let model = Model {
            alpha: take("alpha")?.parse()?,
            kappa: take("kappa")?.parse()?,
            rho: if rho == "inf" { None } else { Some(rho.parse()?) },
            omega: take("omega")?.parse()?,
        };
        let whole = |text: &str| text.parse::<usize>().map_err(|_| format!("\"{text}\" is no whole number"));
        let (mean, block, enclosed) = (take("mean")?.parse()?, whole(take("block")?)?, whole(take("enclosed")?)?);
        let orbit = match take("kind")? {
            "wave" => {
                let [a] = <[_; 1]>::try_from(rows).map_err(|_| "a wave has one line a")?;
                Orbit::Wave(Wave { q_over_pi: take("q_over_pi")?.parse()?, a })
            }
            "breather" => {
                Orbit::Breather(Breather { center: center(take("center")?)?, sites: whole(take("sites")?)?, a: rows })
            }
            "infinite" => Orbit::Infinite(Infinite {
                center: center(take("center")?)?,
                decay: take("decay")?.parse()?,
                band: whole(take("band")?)?,
                background: numbers(take("background")?)?,
                a: rows,
            }),
            other => return Err(format!("kind {other} is neither wave, breather nor infinite")),
        };
        match keys.first() {
            Some((key, _)) => Err(format!("the key {key} is not known")),
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

/// A finite double as C99 writes it: `-0x1.8p-3`; subnormals as `0x0.8p-1022`.
fn hexadecimal(x: f64) -> String {
    let (bits, sign) = (x.abs().to_bits(), if x.is_sign_negative() { "-" } else { "" });
    let (exponent, fraction) = ((bits >> 52) as i64, format!("{:013x}", bits & ((1 << 52) - 1)));
    let fraction = fraction.trim_end_matches('0');
    let (lead, exponent) = if exponent == 0 { (0, -1022) } else { (1, exponent - 1023) };
    if x == 0.0 { format!("{sign}0x0p+0") } else { format!("{sign}0x{lead}.{fraction}p{exponent}") }
}

/// A double that [`hexadecimal`] has written.
fn from_hexadecimal(text: &str) -> Result<f64, String> {
    let of = || {
        let (sign, digits) = text.strip_prefix('-').map_or((0, text), |rest| (1_u64 << 63, rest));
        let (mantissa, exponent) = digits.strip_prefix("0x")?.split_once('p')?;
        let (lead, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let exponent: i64 = exponent.parse().ok()?;
        let digits = fraction.len() <= 13 && fraction.bytes().all(|digit| digit.is_ascii_hexdigit());
        let fraction = u64::from_str_radix(&format!("{fraction:0<13}"), 16).ok().filter(|_| digits)?;
        let biased = match (lead, exponent) {
            ("1", -1022..=1023) => (exponent + 1023) as u64,
            ("0", -1022) => 0,
            ("0", 0) if fraction == 0 => 0,
            _ => return None,
        };
        Some(f64::from_bits(sign | biased << 52 | fraction))
    };
    of().ok_or_else(|| format!("\"{text}\" is no hexadecimal double"))
}
