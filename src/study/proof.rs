//! Existence of exact waves and dark breathers, proved by `hertzchain-proofs`.

use super::{Study, Work, options::options};
use crate::{
    breathers::DarkBreather,
    chain::Params,
    dps,
    error::{Error, Result},
    interrupt,
    orbits::Orbit,
    output::{Folder, read},
    report::Report,
    waves::{ExactWave, MeanStrain},
};
use hertzchain_proofs::{
    certificate::{self, Center, Certificate, Model},
    check::{Proof, Refused, check_until},
    exact::Exact,
    solve::{self, Sizes},
};
use serde_json::{Value, json};
use std::{
    f64::consts::PI,
    path::{Path, PathBuf},
};

/// What the checker says.
type Checked = std::result::Result<Proof, Refused>;

/// Largest certificate that is read, in bytes.
const LONGEST: u64 = 1 << 26;
/// Harmonics of an orbit from which the search for those of the certificate starts.
const HARMONICS: usize = 128;
/// Radii over amplitudes that ask for more harmonics.
pub(super) const WAVE: f64 = 1e-10;
pub(super) const BREATHER: f64 = 1e-9;
/// Samples of half a period from which they are computed.
const SAMPLES: u32 = 512;

options! {
    /// Whether existence is proved.
    pub struct Proving {
        /// Prove that the solution exists, by interval arithmetic.
        ///
        /// It is proved for the exact decimals and fractions of the parameters (1/3 for the double
        /// nearest to it), about a cosine sum near the computed solution. Exit code 1 if nothing is
        /// proved.
        prove: bool = false, [arg(long)];
        /// Write the certificate of the proof to this file.
        ///
        /// `hertzchain prove` checks it again.
        certificate: Option<PathBuf> = None, "FILE", [arg(requires = "prove")];
    }
}

impl Proving {
    /// Adds the proof, if it is asked for, to a report; see [`searched`].
    ///
    /// # Errors
    /// A certificate that cannot be written.
    pub(super) fn added(
        &self,
        report: Report,
        share: f64,
        certificate: impl Fn(usize) -> Result<Option<Certificate>>,
    ) -> Result<Report> {
        if !self.prove {
            return Ok(report);
        }
        let Some((certificate, proof)) = searched(share, certificate)? else {
            let why = "not proved: no cosine sum near the solution is found";
            return Ok(report.fact("proof", json!({ "proved": false, "reason": why })).failure(Some(why.to_owned())));
        };
        if let Some(path) = &self.certificate {
            let missing = || Error::parameter("certificate", path.display().to_string(), "the name of a file");
            let name = path.file_name().and_then(|name| name.to_str()).ok_or_else(missing)?;
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
            Folder::create(folder.unwrap_or(Path::new(".")))?.write(name, certificate.to_string().as_bytes())?;
        }
        Ok(proved(report, &certificate, proof))
    }
}

/// What the checker says, unless the process is asked to end.
fn checked(certificate: &Certificate) -> Result<Checked> {
    match check_until(certificate, &interrupt::asked) {
        Err(Refused::Stopped) => Err(Error::Stopped { kept: "nothing of the proof".to_owned() }),
        proof => Ok(proof),
    }
}

/// A certificate, checked. The closure makes one of some times as many harmonics as usual; there
/// are four times as many if the radius is otherwise above a share of the amplitude.
fn searched(
    share: f64,
    certificate: impl Fn(usize) -> Result<Option<Certificate>>,
) -> Result<Option<(Certificate, Checked)>> {
    let of = |more: usize| {
        certificate(more)?.map(|certificate| checked(&certificate).map(|proof| (certificate, proof))).transpose()
    };
    let usual = of(1)?;
    let near = |(_, proof): &(_, Checked)| matches!(proof, Ok(it) if it.radius <= share * it.amplitude);
    let more = if usual.as_ref().is_none_or(near) { None } else { of(4)? };
    Ok(more.or(usual))
}

/// The radius that is proved, over the amplitude; infinite if nothing is.
fn radius(share: f64, certificate: impl Fn(usize) -> Result<Option<Certificate>>) -> Result<f64> {
    Ok(match searched(share, certificate)? {
        Some((_, Ok(proof))) => proof.radius / proof.amplitude,
        _ => f64::INFINITY,
    })
}

/// The radius within which a wave with these Fourier coefficients is proved to exist, over its
/// amplitude; infinite if it is not.
pub(crate) fn radius_of_wave(wave: &ExactWave, fourier: &[f64]) -> Result<f64> {
    radius(WAVE, |more| of_wave(wave, fourier, more))
}

/// The same of a breather.
pub(crate) fn radius_of_breather(breather: &DarkBreather, orbit: &Orbit, tol: f64) -> Result<f64> {
    radius(BREATHER, |more| of_breather(breather, orbit, tol, more))
}

/// A positive bound with two digits, rounded up.
fn up(bound: f64) -> String {
    let nearest = format!("{bound:.1e}");
    if nearest.parse::<f64>().is_ok_and(|printed| printed >= bound) {
        return nearest;
    }
    format!("{:.1e}", bound + 0.05 * 10_f64.powf(bound.log10().floor()))
}

/// Adds to a report what is proved of a certificate.
fn proved(report: Report, certificate: &Certificate, proof: Checked) -> Report {
    let (harmonics, block) = (certificate.harmonics(), certificate.block);
    let norm = match certificate.orbit {
        certificate::Orbit::Wave(_) => "sum of |a_k| over k >= 1",
        certificate::Orbit::Breather(_) => {
            "largest over n of (sqrt(2) |a_n0| + sum of |a_nk| over k >= 1)/W_n, W_n <= 1; and of eta |c_0|"
        }
    };
    let value = |proved: bool, numbers: [Option<f64>; 5], reason: Option<String>| {
        let [radius, uniqueness_radius, y0, z1, z2] = numbers;
        let mut value = json!({
            "proved": proved, "radius": radius, "uniqueness_radius": uniqueness_radius, "y0": y0, "z1": z1, "z2": z2,
            "harmonics": harmonics, "block": block, "norm": norm, "rounding": "outward",
        });
        if let Some(reason) = reason {
            value["reason"] = Value::from(reason);
        }
        value
    };
    match proof {
        Ok(proof) => {
            let bounds = proof.bounds;
            let words = format!(
                "Proved: within {} of the sum of {harmonics} harmonics, {} of the amplitude, there is exactly \
                 one solution (Y0 = {}, Z1 = {}, Z2 = {}).",
                up(proof.radius),
                up(proof.radius / proof.amplitude),
                up(bounds.y0),
                up(bounds.z1),
                up(bounds.z2)
            );
            let numbers = [proof.radius, proof.uniqueness_radius, bounds.y0, bounds.z1, bounds.z2].map(Some);
            report.fact("proof", value(true, numbers, None)).words(words)
        }
        Err(why) => {
            let bounds = match &why {
                Refused::Bounds(bounds) => [bounds.y0, bounds.z1, bounds.z2].map(|x| Some(x).filter(|x| x.is_finite())),
                _ => [None; 3],
            };
            let [y0, z1, z2] = bounds;
            let words = format!("not proved: {why}");
            report.fact("proof", value(false, [None, None, y0, z1, z2], Some(words.clone()))).failure(Some(words))
        }
    }
}

/// A parameter as an exact number.
fn exact(name: &'static str, x: f64) -> Result<Exact> {
    Exact::of_double(x).ok_or_else(|| Error::parameter(name, x, "at most 38 digits, to be proved"))
}

fn model(Params { alpha, kappa, rho }: Params, omega: f64) -> Result<Model> {
    let rho = if rho == f64::INFINITY { None } else { Some(exact("rho", rho)?) };
    Ok(Model { alpha: exact("alpha", alpha)?, kappa: exact("kappa", kappa)?, rho, omega: exact("omega", omega)? })
}

/// The certificate of a wave with these Fourier coefficients of `X`.
pub(super) fn of_wave(wave: &ExactWave, fourier: &[f64], more: usize) -> Result<Option<Certificate>> {
    let setting = wave.setting;
    let mean = match setting.mean {
        MeanStrain::Value(mean) => mean,
        _ => wave.mean(),
    };
    let (model, mean) = (model(setting.params, setting.omega_tw)?, exact("mean", mean)?);
    let q = Exact::new(2 * setting.q.turns() as i64, setting.q.cell() as i64);
    Ok(q.and_then(|q| solve::wave(model, q, mean, &fourier[1..], Sizes::WAVE.times(more))))
}

/// The certificate of a dark breather: of the orbit with the mean strain of this one.
pub(super) fn of_breather(
    breather: &DarkBreather,
    orbit: &Orbit,
    tol: f64,
    more: usize,
) -> Result<Option<Certificate>> {
    let (sites, half) = (breather.sites, breather.sites / 2);
    let share = |j: u32| f64::from(j) / f64::from(SAMPLES);
    let times: Vec<f64> = (0..=SAMPLES).map(|j| 0.5 * orbit.setting.period() * share(j)).collect();
    let states = orbit.states(tol, &times)?;
    // The strain is even in time: the sum over half a period, with half of both ends.
    let coefficient = |site: usize, k: usize| {
        let term = |(j, state): (u32, &Vec<f64>)| {
            let weight = if j == 0 || j == SAMPLES { 0.5 } else { 1.0 };
            weight * state[site] * (PI * f64::from(j * k as u32 % (2 * SAMPLES)) / f64::from(SAMPLES)).cos()
        };
        (if k == 0 { 1.0 } else { 2.0 }) * (0..).zip(&states).map(term).sum::<f64>() / f64::from(SAMPLES)
    };
    // Site n of the ring, n = -N .. N, is entry N + n.
    let (center, first) = match breather.center {
        dps::Center::Site => (Center::Site, half),
        dps::Center::Bond => (Center::Bond, half + 1),
    };
    let row = |i: usize| (0..=HARMONICS).map(|k| coefficient((first + i) % sites, k)).collect();
    let guess: Vec<Vec<f64>> = (0..=half).map(row).collect();
    let mean = exact("mean strain", orbit.x().iter().sum::<f64>() / sites as f64)?;
    let model = model(breather.params, breather.omega_b)?;
    Ok(solve::breather(model, (mean, sites), center, &guess, Sizes::BREATHER.times(more)))
}

options! {
    /// A certificate that is checked again.
    pub struct Prove {
        /// File that `--certificate` of `wave exact` or `breather dark` has written.
        certificate: PathBuf = PathBuf::new(), [arg(value_name = "CERTIFICATE")];
    }
}

impl Study for Prove {
    fn outline() -> Option<Report> {
        Some(Report::new("proof"))
    }

    fn begin(&self) -> Result<Work<'_>> {
        let path = &self.certificate;
        let refused = |rule: String| Error::Content { path: path.clone(), place: "certificate".to_owned(), rule };
        let text = String::from_utf8(read(path, LONGEST)?).map_err(|_| refused("it is no text".to_owned()))?;
        let certificate: Certificate = text.parse().map_err(refused)?;
        Ok(Box::new(move |_, _| {
            let Certificate { model: Model { alpha, kappa, rho, omega }, mean, .. } = certificate;
            let rho = rho.map_or("inf".to_owned(), |rho| rho.to_string());
            let kind = match &certificate.orbit {
                certificate::Orbit::Wave(wave) => format!("travelling wave, q = {} pi", wave.q_over_pi),
                certificate::Orbit::Breather(breather) => {
                    let center = if breather.center == Center::Site { "site" } else { "bond" };
                    format!("dark breather about a {center} on a ring of {}", breather.sites)
                }
            };
            let words = format!(
                "{kind}; alpha = {alpha}, kappa = {kappa}, rho = {rho}, frequency {omega}, mean strain {mean}, all exact."
            );
            let report = Report::new("proof")
                .fact("solution", kind)
                .fact("alpha", alpha.to_string())
                .fact("kappa", kappa.to_string())
                .fact("rho", rho)
                .fact("frequency", omega.to_string())
                .fact("mean_strain", mean.to_string())
                .words(words);
            match checked(&certificate)? {
                Err(Refused::Certificate(rule)) => Err(refused(rule)),
                proof => Ok(proved(report, &certificate, proof)),
            }
        }))
    }
}
