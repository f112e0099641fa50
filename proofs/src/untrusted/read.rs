//! Certificates read from texts, and limits of what is checked. The checker writes what was read
//! and compares, and refuses what is beyond the limits.

use crate::{
    certificate::{Bloch, Center, Certificate, HEAD, Model, Multiplier, Orbit, pieces},
    check::infinite,
    exact::Exact,
};
use std::str::FromStr;

/// Largest number of harmonics.
const MOST: usize = 4096;
/// Largest block of Newton's method, in unknowns.
const LARGEST_BLOCK: usize = 2500;
/// Largest number of sites of a ring.
const MOST_SITES: usize = 401;
/// What texts of fractions are.
const FRACTION: &str = "fraction of two integers of 64 bits with a denominator but 0";

impl Exact {
    /// `num/den` in lowest terms; `None` if `den` is zero, or one of them the least integer, which
    /// has no modulus.
    pub fn new(num: i64, den: i64) -> Option<Self> {
        let gcd = |mut a: i64, mut b: i64| {
            while b != 0 {
                (a, b) = (b, a % b);
            }
            a
        };
        let common = gcd(num.checked_abs()?, den.checked_abs()?) * den.signum();
        (den != 0).then(|| Self::of(num / common, den / common)).flatten()
    }
}

impl FromStr for Exact {
    type Err = String;

    /// Reads `-3` or `1/3`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (num, den) = text.split_once('/').unwrap_or((text, "1"));
        let of = || Self::new(num.parse().ok()?, den.parse().ok()?);
        of().ok_or_else(|| format!("\"{text}\" is no {FRACTION}"))
    }
}

/// The rules that the checker relies on.
pub(crate) const RULES: [&str; 16] = [
    "q_over_pi has at most 12 digits",
    "sites must be odd, from 3 to 401",
    "a breather of the infinite chain is no piece of a branch",
    "decay must be above 0, and the background has at least the harmonics of the sites",
    "a row of coefficients for each site, with as many of them",
    "alpha must be above 1",
    "kappa must be above 0",
    "rho must be at least 0",
    "the resonators of a breather move: rho must be finite",
    "omega must be above 0",
    "block must be from 1 to the number of harmonics",
    "enclosed must be at least the harmonics and 4 block",
    "first harmonics are those at the ends of a piece of a branch of waves",
    "the centre of a site-centred breather has even harmonics only",
    "a multiplier is growing, of one breather of a ring, at growth rates above 0, the larger one last; or -1, of a piece \
     of a branch of bond-centred ones",
    "lines bloch are of one wave: each begins where the one before it ends; of p/pi the larger one is last, and radius, \
     growth rate - |change| - radius, and omega - |frequency| - |change| - radius are above 0",
];

/// Rules without which a check would take too long, or only fail later.
pub(crate) fn limits(it: &Certificate) -> Result<(), String> {
    let finite = |row: &Vec<f64>| row.iter().all(|a| a.is_finite());
    let (sites, band, decay, background) = match &it.orbit {
        Orbit::Infinite { decay, band, background, .. } => {
            (infinite::sites(it.a.len(), *band), *band, decay.num() as f64 / decay.den() as f64, Some(background))
        }
        _ => (it.a.len(), 1, 0.0, None),
    };
    let rules = [
        (it.a.len() <= MOST_SITES.div_ceil(2) || background.is_some(), "sites must be odd, from 3 to 401"),
        ((1..=MOST_SITES).contains(&band), "band must be from 1 to 401"),
        (!it.is_to_zero() || it.model.rho != Some(Exact::ZERO), "to zero needs resonators: rho must be above 0"),
        (it.enclosed <= MOST, "at most 4096 harmonics"),
        (sites.saturating_mul(it.block.saturating_add(1)) < LARGEST_BLOCK, "the block has at most 2500 unknowns"),
        (it.a.iter().chain(background).all(finite), "coefficients must be finite"),
        (background.is_none_or(|far| far.len() <= MOST + 1), "the background has at most 4096 harmonics"),
        (decay * (sites as f64) < 500.0, "decay times the sites must be below 500"),
    ];
    let broken = rules.into_iter().find(|(holds, _)| !holds);
    broken.map_or(Ok(()), |(_, words)| Err(words.to_owned()))
}

/// Why a text is not that of the certificate that was read from it, which is written as this one.
pub(crate) fn unlike(text: &str, written: &str) -> String {
    let apart = text.lines().zip(written.lines()).find(|(own, other)| own != other);
    apart.map_or("it has lines after its end".to_owned(), |(own, other)| {
        format!("the line \"{}\" is to be written as \"{}\"", shown(own), shown(other))
    })
}

/// What is after the key of a line, in words, and how it is read.
type Kind<T> = (&'static str, fn(&str) -> Option<T>);

/// The lines of a certificate, one after the other.
struct Lines<'a>(std::iter::Peekable<std::str::Lines<'a>>);

impl Lines<'_> {
    /// What is after this key, if the next line begins with it.
    fn given<T>(&mut self, key: &str, (what, of): Kind<T>) -> Result<Option<T>, String> {
        let Some(text) = self.0.peek().and_then(|line| line.strip_prefix(key)?.strip_prefix(' ')) else {
            return Ok(None);
        };
        self.0.next();
        of(text).map(Some).ok_or_else(|| format!("\"{}\" is no {what}", shown(text)))
    }

    /// The same, of a line that must be there.
    fn needed<T>(&mut self, key: &str, what: Kind<T>) -> Result<T, String> {
        let found = self.0.peek().map_or("the end".to_owned(), |line| format!("\"{}\"", shown(line)));
        self.given(key, what)?.ok_or_else(|| format!("the line {key} is missing, before {found}"))
    }
}

/// As many fractions as there are.
fn fractions<const N: usize>(text: &str) -> Option<[Exact; N]> {
    let all = text.split(' ').map(|word| word.parse().ok()).collect::<Option<Vec<Exact>>>();
    all?.try_into().ok()
}

/// Doubles by their bits, 16 hexadecimal digits each.
fn numbers(text: &str) -> Option<Vec<f64>> {
    let digits = |word: &str| word.len() == 16 && word.bytes().all(|digit| digit.is_ascii_hexdigit());
    let number = |word: &str| u64::from_str_radix(word, 16).ok().filter(|_| digits(word)).map(f64::from_bits);
    text.split(' ').map(number).collect()
}

fn multiplier(text: &str) -> Option<Multiplier> {
    Some(match text.split_once(' ')? {
        ("growing", rates) => Multiplier::Growing(fractions(rates)?),
        ("-1", part @ ("cosine" | "sine")) => Multiplier::Doubling { sine: part == "sine" },
        _ => return None,
    })
}

/// Of one Bloch wave number, or of an interval.
fn bloch(text: &str) -> Option<Bloch> {
    let single = || fractions(text).map(|[p, re, im, radius]| [p, p, re, im, Exact::ZERO, Exact::ZERO, radius]);
    let [from, to, re, im, by_re, by_im, radius] = fractions(text).or_else(single)?;
    Some(Bloch { p_over_pi: [from, to], rate: [re, im], change: [by_re, by_im], radius })
}

/// The first characters of a text.
fn shown(text: &str) -> String {
    text.chars().take(60).collect()
}

impl FromStr for Certificate {
    type Err = String;

    /// Reads a certificate.
    fn from_str(text: &str) -> Result<Self, String> {
        let one = <[Self; 1]>::try_from(pieces(text)?);
        one.map(|[one]| one).map_err(|_| format!("the line \"{HEAD}\" is not expected here"))
    }
}

/// The certificates of a text, which begin with the same line.
pub(crate) fn certificates(text: &str) -> Result<Vec<Certificate>, String> {
    let later = text.match_indices(HEAD).map(|(at, _)| at).filter(|at| text[..*at].ends_with('\n'));
    let ends: Vec<usize> = std::iter::once(0).chain(later).chain([text.len()]).collect();
    ends.windows(2).map(|ends| certificate(&text[ends[0]..ends[1]])).collect()
}

fn certificate(text: &str) -> Result<Certificate, String> {
    let mut lines = Lines(text.lines().peekable());
    if lines.0.next() != Some(HEAD) {
        return Err(format!("its first line is not \"{HEAD}\""));
    }
    let fraction: Kind<Exact> = (FRACTION, |text| text.parse().ok());
    let whole: Kind<usize> = ("whole number", |text| text.parse().ok());
    let row: Kind<Vec<f64>> = ("row of doubles of 16 hexadecimal digits", numbers);
    let center: Kind<Center> =
        ("centre, site or bond", |name| [Center::Site, Center::Bond].into_iter().find(|one| one.name() == name));
    let kind = lines.needed("kind", ("kind: wave, breather or infinite", |text| Some(text.to_owned())))?;
    let [alpha, kappa] = [lines.needed("alpha", fraction)?, lines.needed("kappa", fraction)?];
    let rho =
        lines.needed("rho", (FRACTION, |text| if text == "inf" { Some(None) } else { text.parse().ok().map(Some) }))?;
    let model = Model { alpha, kappa, rho, omega: lines.needed("omega", fraction)? };
    let mean = lines.needed("mean", fraction)?;
    let to =
        lines.given(
            "to",
            ("frequency and mean strain, nor zero", |text| {
                if text == "zero" { Some([Exact::ZERO; 2]) } else { fractions(text) }
            }),
        )?;
    let first = lines.given("first", ("two first harmonics", fractions))?;
    let (block, enclosed) = (lines.needed("block", whole)?, lines.needed("enclosed", whole)?);
    let what = "bloch: p/pi, a growth rate, a frequency and a radius; of an interval both ends and changes";
    let mut all = Vec::new();
    while let Some(one) = lines.given("multiplier bloch", (what, bloch))? {
        all.push(one);
    }
    let what = "multiplier: growing with two growth rates, or -1 with cosine or sine";
    let multiplier = lines.given("multiplier", (what, multiplier))?;
    // The mean of these sums is exact.
    let with_mean = |row: Vec<f64>| [vec![0.0], row].concat();
    let orbit = match &*kind {
        "wave" => Orbit::Wave { q_over_pi: lines.needed("q_over_pi", fraction)? },
        "breather" => Orbit::Breather { sites: lines.needed("sites", whole)?, center: lines.needed("center", center)? },
        "infinite" => Orbit::Infinite {
            center: lines.needed("center", center)?,
            decay: lines.needed("decay", fraction)?,
            band: lines.needed("band", whole)?,
            background: with_mean(lines.needed("background", row)?),
        },
        _ => return Err(format!("kind {} is neither wave, breather nor infinite", shown(&kind))),
    };
    let mut a = Vec::new();
    while let Some(row) = lines.given("a", row)? {
        a.push(if kind == "wave" { with_mean(row) } else { row });
    }
    match lines.0.next() {
        Some(line) => Err(format!("the line \"{}\" is not expected here", shown(line))),
        None => Ok(Certificate { model, mean, to, first, block, enclosed, orbit, a, multiplier, bloch: all }),
    }
}
