//! Existence of exact waves and dark breathers, proved by `hertzchain-proofs`.

use crate::study::{Progress, Study, Work, options::options};
use crate::{
    chain::Params,
    dps,
    error::{Error, Result},
    interrupt,
    number::counted,
    numerics::least_by,
    orbits::Orbit,
    output::{Folder, read},
    report::Report,
    sweep::{self, Engine, Grid, locked},
    waves::{ExactWave, MeanStrain, WaveKind, WaveMultiplier, WaveSpectrum},
};
use hertzchain_proofs::{
    certificate::{self, Bloch, Center, Certificate, Model, Multiplier},
    check::{Bounds, Gap, Proof, Refused, Zero, check_until, connected, doublings, turns},
    exact::Exact,
    untrusted::{
        modulations,
        solve::{self, Sizes, Strip},
    },
};
use serde_json::{Value, json};
use std::{
    collections::BTreeMap,
    f64::consts::PI,
    path::{Path, PathBuf},
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering::Relaxed},
    },
};

/// What the checker says.
type Checked = std::result::Result<Proof, Refused>;

/// What is told of the proof of a piece: radius, radius of uniqueness, amplitude, bounds of the
/// frequency and of the multiplier, weights.
type Told = (f64, f64, f64, [f64; 2], Option<[f64; 2]>, Vec<f64>);

/// Largest certificate that is read, in bytes.
const LONGEST: u64 = 1 << 26;
/// Harmonics of an orbit from which the search for those of the certificate starts.
const HARMONICS: usize = 128;
/// Radii over amplitudes that ask for more harmonics, and for how many times as many.
pub(crate) const WAVE: (f64, usize) = (1e-10, 6);
pub(crate) const BREATHER: (f64, usize) = (1e-9, 4);
pub(crate) const DOUBLED: (f64, usize) = (1e-8, 2);
/// Half of the width of the interval of a multiplier that is to be proved, and of the frequency at
/// which one is -1.
const WIDTH: f64 = 4e-7;
/// Radii that are tried for the growth rate of a wave.
const RADII: [f64; 4] = [5e-9, 1.5e-8, 5e-8, 5e-7];
/// Why there is no certificate.
const NO_SUM: &str = "no cosine sum near the solution is found";
/// Samples of half a period from which they are computed.
const SAMPLES: u32 = 512;

options! {
    /// Whether existence is proved.
    pub struct Proving {
        /// Prove that the solution exists, by interval arithmetic.
        ///
        /// It is proved for the exact decimals and fractions of the parameters (1/3 for the double
        /// nearest to it), about a cosine sum near the computed solution. Of a branch in its
        /// frequency one curve of solutions is proved, piece by piece; the mean strain is linear
        /// between its points, and proof.store has the pieces as they are proved, from which the
        /// same command goes on; without multipliers they are the points of --shard and --engine.
        /// Where it can, `wave exact` also encloses the rate of the perturbation that grows
        /// fastest, `breather dark` and `breather doubled`, which proves its last orbit, a real
        /// Floquet multiplier above 1, and `breather continue --center bond` with --bifurcations
        /// the frequencies at which the period doubles. Exit code 1 if existence is not proved, or
        /// not of the whole branch.
        prove: bool = false;
        /// Write the certificate of the proof to this file.
        ///
        /// `hertzchain prove` checks it again. Folders that are missing are made.
        certificate: Option<PathBuf> = None, "FILE", [requires = "prove"];
        /// Prove the branch down to amplitude zero, where it has the limit of the DpS equation.
        ///
        /// From the wave or the breather, or from the end of the branch with the lower frequency.
        /// The mean strain is in proportion to the amplitude. Proved are eps_0 and C: for 0 < eps
        /// <= eps_0 there is a solution within C eps^alpha of the one of the DpS equation with the
        /// first harmonic eps.
        to_zero: bool = false, [requires = "prove", hide_short_help = true];
    }
}

impl Proving {
    /// Adds the proof, if it is asked for, to a report; see [`searched`]. `why` says what else may
    /// be the reason where there is no certificate; perturbations are asked for at all Bloch wave
    /// numbers over pi between those of `modulation`, if there are some.
    ///
    /// # Errors
    /// Those of `certificate`; [`Error::Stopped`].
    pub(crate) fn added(
        &self,
        report: Report,
        more: (f64, usize),
        why: &str,
        modulation: &[f64],
        certificate: impl Fn(usize) -> Result<Option<Certificate>>,
    ) -> Result<Report> {
        if !self.prove {
            return Ok(report);
        }
        if self.to_zero {
            let found = certificate(1)?.map(|it| down(&it)).transpose()?;
            let why = found.is_none().then(|| NO_SUM.to_owned());
            return Ok(self.told(report, found.into_iter().collect(), None, why));
        }
        let Some((certificate, proof)) = searched(more, certificate)? else {
            let why = format!("not proved: {NO_SUM}{why}");
            let report = report.fact("proof", json!({ "proved": false, "reason": why })).failure(Some(why));
            return Ok(self.written(None, report));
        };
        let short = !reaches(&certificate, modulation);
        let words = || {
            let [from, to] = [modulation[0], modulation[1]];
            format!("that a perturbation grows is not proved for every Bloch wave number from {from} pi to {to} pi")
        };
        let report = proved(report, &certificate, proof, short.then(words));
        Ok(self.written(Some(&certificate.to_string()), report))
    }

    /// The folder and the name of the certificate, before any work.
    ///
    /// # Errors
    /// A path that is no file; a folder that cannot be made.
    pub(crate) fn file(&self) -> Result<Option<(Folder, &str)>> {
        let Some(path) = &self.certificate else { return Ok(None) };
        let name = path.file_name().and_then(|name| name.to_str()).filter(|_| path.is_file() || !path.exists());
        let missing = || Error::parameter("certificate", path.display().to_string(), "the name of a file");
        let name = name.ok_or_else(missing)?;
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        Ok(Some((Folder::create(folder.unwrap_or(Path::new(".")))?, name)))
    }

    /// Writes the certificate, or removes an earlier one if there is none, and says in the report
    /// if that fails.
    fn written(&self, certificate: Option<&str>, report: Report) -> Report {
        let written = self.file().and_then(|file| match (file, certificate) {
            (Some((folder, name)), Some(text)) => folder.write(name, text.as_bytes()).map(drop),
            (Some((folder, name)), None) => folder.remove([name]),
            (None, _) => Ok(()),
        });
        match written {
            Ok(()) => report,
            Err(why) => report.failure(Some(format!("the certificate is not written: {why}"))),
        }
    }

    /// Refuses a proof of a branch in another parameter than its frequency.
    ///
    /// # Errors
    /// [`Error::Parameter`].
    pub(crate) fn of_branch(&self, parameter: &str, frequency: &str) -> Result<()> {
        let rule = "a branch is proved in its frequency only: without --prove";
        if self.prove && parameter != frequency { Err(Error::parameter("vary", parameter, rule)) } else { Ok(()) }
    }

    /// Adds the proof of a branch to a report: of the curve through solutions near these
    /// certificates. Its strips are points of a sweep, kept in a store. What was there before, and
    /// is not from this job, is checked again. If the process is asked to end, it is that of the
    /// pieces so far.
    ///
    /// # Errors
    /// As [`Engine::sweep`].
    pub(crate) fn added_of_branch(
        &self,
        report: Report,
        near: &[Certificate],
        engine: &Engine,
        progress: Progress<'_>,
    ) -> Result<Report> {
        // Whether a strip is needed depends on those before it: so does its key.
        let mut digest = String::new();
        let key = |(k, ends): (usize, &[Certificate])| {
            digest = sweep::digest(&format!("{digest} {} {}", ends[0], ends[1]));
            (k, digest.clone())
        };
        let mut near = past_folds(near)?;
        if self.to_zero && near.windows(2).any(|two| nearest(two[0].model.omega) < nearest(two[1].model.omega)) {
            near.reverse();
        }
        let strips: Vec<(usize, String)> = near.windows(2).enumerate().map(key).collect();
        let (done, proved, last) = (AtomicUsize::new(0), AtomicUsize::new(0), AtomicUsize::new(strips.len()));
        let check = |piece: &Certificate| {
            let proof = check_until(piece, &interrupt::asked);
            let count = proved.fetch_add(usize::from(proof.is_ok()), Relaxed);
            progress(
                done.load(Relaxed) as f64 / strips.len() as f64,
                &format!("proved so far: {}", counted(count, "piece")),
            );
            proof
        };
        let searched = |k: usize| -> Result<Strip> {
            if k > last.load(Relaxed) {
                return Err(Error::Point { point: format!("strip {k}"), why: "after the end of the proof".to_owned() });
            }
            let ends = [&near[k], &near[k + 1]];
            let strip = solve::strip(ends, sizes(ends), &check).map_err(|_| stopped())?;
            done.fetch_add(1, Relaxed);
            if strip.stop.is_some() {
                last.fetch_min(k, Relaxed);
            }
            Ok(strip)
        };
        let own = Mutex::new(BTreeMap::new());
        let strip = |(k, _): &(usize, String)| -> Result<(String, Vec<Told>)> {
            let strip = searched(*k)?;
            let text = strip.pieces.iter().map(|(piece, _)| piece.to_string()).collect();
            let told = strip.pieces.iter().map(|(_, proof)| told(proof)).collect();
            locked(&own).insert(*k, strip);
            Ok((text, told))
        };
        let grid = Grid { store: "proof.store", study: "proof", settings: json!({}) };
        let swept = engine.sweep(&grid, &strips, &|_, _| (), strip)?;
        let again = |(k, row): &(usize, sweep::Row<(String, Vec<Told>)>)| -> sweep::Row<Strip> {
            let known = locked(&own).remove(k);
            match (known, row) {
                (Some(strip), _) => Ok(strip),
                (None, Err(why)) => Err(why.clone()),
                (None, Ok((text, told))) => match checked_again([&near[*k], &near[k + 1]], text, &|i, it| {
                    let told = told.get(i).filter(|_| swept.fresh.binary_search(k).is_ok());
                    told.map_or_else(|| check(it), |told| Ok(proof_of(told.clone())))
                }) {
                    Some(strip) => {
                        done.fetch_add(1, Relaxed);
                        Ok(strip)
                    }
                    None => searched(*k).map_err(|why| why.to_string()),
                },
            }
        };
        let rows: Vec<_> = swept.rows.into_iter().enumerate().collect();
        let (mut pieces, mut stop) = (Vec::new(), None);
        for strip in sweep::map(&rows, again) {
            let none = |why| Strip { pieces: Vec::new(), stop: Some((Exact::ONE, why)) };
            let strip = strip.unwrap_or_else(none);
            pieces.extend(strip.pieces.into_iter().map(|(piece, proof)| (piece, Ok(proof))));
            stop = strip.stop.map(|(_, why)| why);
            if stop.is_some() {
                break;
            }
        }
        let report = match swept.resumed {
            0 => report,
            kept => {
                report.words(format!("{kept} of {} strips were in proof.store, and are checked again.", rows.len()))
            }
        };
        if near.len() < 2 {
            stop = Some("a branch of one point has no pieces".to_owned());
        }
        if let Some(last) = near.last().filter(|_| self.to_zero && stop.is_none()) {
            match last.first {
                Some(_) => stop = Some("it turns back before amplitude zero".to_owned()),
                None => pieces.push(down(last)?),
            }
        }
        let end = near.last().map(|last| nearest(last.ends()[1][0])).filter(|_| !self.to_zero);
        Ok(self.told(report, pieces, end, stop))
    }

    /// Adds to a report what is proved of pieces, the first ones of which are connected, up to the
    /// value `end` of the parameter unless they stop before.
    fn told(
        &self,
        report: Report,
        mut pieces: Vec<(Certificate, Checked)>,
        end: Option<f64>,
        stop: Option<String>,
    ) -> Report {
        let (count, gap) = connected(&pieces);
        pieces.truncate(count);
        let report = proved_branch(report, &pieces, end, gap.map(|gap| gap.to_string()).or(stop));
        let text: String = pieces.iter().map(|(piece, _)| piece.to_string()).collect();
        self.written(Some(&*text).filter(|_| count > 0), report)
    }
}

/// Certificates near the waves of a branch, with their first harmonics as the parameter of the
/// branch if its frequency turns back and they do not.
fn past_folds(near: &[Certificate]) -> Result<Vec<Certificate>> {
    let turns = |of: fn(&Certificate) -> f64| {
        let values: Vec<f64> = near.iter().map(of).collect();
        values.windows(3).any(|three| (three[1] - three[0]) * (three[2] - three[1]) < 0.0)
    };
    let by_first = turns(|it| nearest(it.model.omega)) && !turns(|it| it.a[0][1]);
    let of = |it: &Certificate| {
        let first = || exact("first harmonic", rounded(it.a[0][1])).map(|a| [a; 2]);
        let first = (by_first && it.is_wave()).then(first).transpose()?;
        Ok(Certificate { first, ..it.clone() })
    };
    near.iter().map(of).collect()
}

/// The sizes of the pieces of a strip.
fn sizes([from, to]: [&Certificate; 2]) -> Sizes {
    match () {
        () if from.is_wave() => Sizes::WAVE_PIECE,
        () if from.background() == 2 => Sizes::DOUBLED_PIECE,
        () if from.multiplier.is_some() && to.multiplier.is_some() => Sizes::BREATHER,
        () => Sizes::BREATHER_PIECE,
    }
}

fn told(proof: &Proof) -> Told {
    let Proof { radius, uniqueness_radius, amplitude, frequency, multiplier, weights, .. } = proof.clone();
    (radius, uniqueness_radius, amplitude, frequency, multiplier, weights)
}

/// The proof of a piece from what is told of it; no other bounds are known.
fn proof_of((radius, uniqueness_radius, amplitude, frequency, multiplier, weights): Told) -> Proof {
    let unknown = f64::INFINITY;
    Proof {
        radius,
        radius_y: unknown,
        radius_velocity: unknown,
        radius_velocity_y: unknown,
        uniqueness_radius,
        frequency,
        amplitude,
        bounds: Bounds { y0: unknown, z1: unknown },
        contraction: unknown,
        weights,
        multiplier,
        growth: None,
        decay: None,
        zero: None,
    }
}

/// The strip of a branch between two certificates near solutions, from the text of its pieces, and
/// what `check` says of each, by its number. `None` if that is not the whole strip, or not proved.
fn checked_again(near: [&Certificate; 2], text: &str, check: &dyn Fn(usize, &Certificate) -> Checked) -> Option<Strip> {
    let pieces = certificate::pieces(text).ok()?;
    let [from, to] = near.map(|it| it.ends()[0]);
    let multiplier = near[0].multiplier.filter(|it| near[1].multiplier == Some(*it));
    // Mean strain and parameter are linear, up to the rounding of nodes.
    let [from_near, to_near] = [from, to].map(|ends| ends.map(nearest));
    let linear = |[parameter, mean]: [f64; 2]| {
        let [along, across] = [0, 1].map(|i| to_near[i] - from_near[i]);
        ((mean - from_near[1]) * along - (parameter - from_near[0]) * across).abs() <= 1e-12 * along.abs()
    };
    let fits = |piece: &Certificate| {
        let same = piece.is_alike(near[0]) && piece.multiplier == multiplier;
        same && piece.to.is_some() && linear(piece.ends()[1].map(nearest))
    };
    let whole =
        pieces.first().is_some_and(|it| it.ends()[0] == from) && pieces.last().is_some_and(|it| it.ends()[1] == to);
    if !whole || !pieces.iter().all(fits) {
        return None;
    }
    let pieces: Vec<(Certificate, Checked)> =
        pieces.into_iter().enumerate().map(|(i, it)| (it.clone(), check(i, &it))).collect();
    if connected(&pieces).1.is_some() {
        return None;
    }
    let pieces = pieces.into_iter().filter_map(|(piece, proof)| Some((piece, proof.ok()?))).collect();
    Some(Strip { pieces, stop: None })
}

fn stopped() -> Error {
    Error::Stopped { kept: "nothing of the proof".to_owned() }
}

/// The piece from this solution down to amplitude zero, checked. If Newton's method finds no cosine
/// sum, the checker says why this one is none.
fn down(near: &Certificate) -> Result<(Certificate, Checked)> {
    let to_zero = Certificate { to: Some([Exact::ZERO; 2]), multiplier: None, bloch: Vec::new(), ..near.clone() };
    let found = solve::near(&to_zero, sizes([&to_zero, &to_zero])).unwrap_or(to_zero);
    checked(&found).map(|proof| (found, proof))
}

/// What the checker says, unless the process is asked to end.
fn checked(certificate: &Certificate) -> Result<Checked> {
    match check_until(certificate, &interrupt::asked) {
        Err(Refused::Stopped) => Err(stopped()),
        proof => Ok(proof),
    }
}

/// A certificate and what the checker says of it; without its multiplier if that is not proved, and
/// why it is not.
fn alone(certificate: Certificate, proof: Checked) -> Result<(Certificate, Checked, Option<Refused>)> {
    match proof {
        Err(why @ (Refused::Multiplier { .. } | Refused::Bloch { .. })) => {
            let without = Certificate { multiplier: None, bloch: Vec::new(), ..certificate };
            checked(&without).map(|proof| (without, proof, Some(why)))
        }
        proof => Ok((certificate, proof, None)),
    }
}

/// The double nearest to an exact number, or one beside it.
fn nearest(x: Exact) -> f64 {
    x.enclosed().mid()
}

/// A certificate, checked. The closure makes one of some times as many harmonics as usual; there
/// are more of them if the radius is otherwise above a share of the amplitude. The least one
/// counts.
fn searched(
    (share, times): (f64, usize),
    certificate: impl Fn(usize) -> Result<Option<Certificate>>,
) -> Result<Option<(Certificate, Checked)>> {
    let of = |more: usize| -> Result<Option<(Certificate, Checked)>> {
        let Some(certificate) = certificate(more)? else { return Ok(None) };
        let proof = checked(&certificate)?;
        alone(certificate, proof).map(|(certificate, proof, _)| Some((certificate, proof)))
    };
    let usual = of(1)?;
    let radius = |(_, proof): &(_, Checked)| proof.as_ref().map_or(f64::INFINITY, |it| it.radius / it.amplitude);
    let more = if usual.as_ref().is_none_or(|usual| radius(usual) <= share) { None } else { of(times)? };
    Ok(least_by(usual.into_iter().chain(more), radius))
}

/// The radius within which a solution is proved to exist, over its amplitude; infinite if it is
/// not.
pub(crate) fn radius(more: (f64, usize), certificate: impl Fn(usize) -> Result<Option<Certificate>>) -> Result<f64> {
    Ok(match searched(more, certificate)? {
        Some((_, Ok(proof))) => proof.radius / proof.amplitude,
        _ => f64::INFINITY,
    })
}

/// A positive bound with two digits, rounded up.
fn up(bound: f64) -> String {
    let nearest = format!("{bound:.1e}");
    if nearest.parse::<f64>().is_ok_and(|printed| printed >= bound) {
        return nearest;
    }
    format!("{:.1e}", bound + 0.05 * 10_f64.powf(bound.log10().floor()))
}

/// The norm of a proof.
fn norm(certificate: &Certificate) -> &'static str {
    match certificate.orbit {
        certificate::Orbit::Wave { .. } if certificate.first.is_some() => {
            "largest of sqrt(2) |a_0| + sum of |a_k| over k >= 1, and of |omega - omega_m|/W, omega_m in the middle of a \
             piece"
        }
        certificate::Orbit::Wave { .. } => "sqrt(2) |a_0| + sum of |a_k| over k >= 1",
        certificate::Orbit::Breather { .. } => {
            "largest over n of (sqrt(2) |a_n0| + sum of |a_nk| over k >= 1)/W_n, W_n <= 1"
        }
        certificate::Orbit::Infinite { .. } => {
            "largest over n of (sqrt(2) |a_n0| + sum of |a_nk| over k >= 1)/W_n, W_n = 1 near the centre, \
             a constant times e^{-decay |n|} beyond"
        }
    }
}

/// The parameter of a branch in words.
fn parameter(piece: &Certificate) -> &'static str {
    if piece.first.is_some() { "first harmonic" } else { "frequency" }
}

/// Adds to a report what is proved of the pieces of a branch, which are connected, up to the value
/// `end` of the parameter unless they stop before.
fn proved_branch(report: Report, pieces: &[(Certificate, Checked)], end: Option<f64>, stop: Option<String>) -> Report {
    let end_of = |piece: Option<&(Certificate, Checked)>, i: usize| piece.map(|(it, _)| nearest(it.ends()[i][0]));
    let zero = pieces.last().and_then(|(_, proof)| proof.as_ref().ok()?.zero.as_ref());
    let (from, to) = (end_of(pieces.first(), 0), end_of(pieces.last(), 1).filter(|_| zero.is_none()));
    let name = pieces.first().map_or("frequency", |(piece, _)| parameter(piece));
    let proofs = || pieces.iter().filter_map(|(_, proof)| proof.as_ref().ok());
    let radius = proofs().map(|proof| proof.radius).reduce(f64::max);
    let share = proofs().map(|proof| proof.radius / proof.amplitude).reduce(f64::max);
    let unique = proofs().map(|proof| proof.uniqueness_radius).reduce(f64::min);
    let (doublings, turns) = (doublings(pieces), turns(pieces));
    let refused = doublings.iter().filter_map(|one| one.as_ref().err()).map(|run| {
        let (first, last) = (run.start + 1, run.end);
        format!("not proved: pieces {first} to {last} have a line for -1, along which g does not change its sign")
    });
    let doublings: Vec<&[f64; 2]> = doublings.iter().flatten().collect();
    let stop = stop.map(|why| match (to, end) {
        (Some(to), Some(end)) => format!("proved up to the {name} {to}, not {end}: {why}"),
        (Some(to), None) => format!("proved up to the {name} {to}: {why}"),
        (None, _) => format!("not proved: {why}"),
    });
    let failure = stop.into_iter().chain(refused).reduce(|all, one| format!("{all}; {one}"));
    let mut value = json!({
        "proved": failure.is_none(), "pieces": pieces.len(), "from": from, "to": to, "radius": radius,
        "uniqueness_radius": unique, "norm": pieces.first().map(|(piece, _)| norm(piece)), "rounding": "outward",
        "parameter": name, "period_doublings": doublings, "turns_back": turns,
        "zero": zero.map(|it| json!({ "epsilon": it.epsilon, "constant": it.constant, "mu": it.coefficient })),
    });
    let words = match (from, share) {
        (Some(from), Some(share)) => format!(
            "Proved: one curve of solutions from the {name} {from} to {}, in {}; within {} of their \
             cosine sums, {} of the amplitude.",
            to.map_or("amplitude zero".to_owned(), |to| to.to_string()),
            counted(pieces.len(), "piece"),
            up(radius.unwrap_or(f64::NAN)),
            up(share)
        ),
        _ => String::new(),
    };
    if let Some(failure) = &failure {
        value["reason"] = Value::from(failure.as_str());
    }
    let doubling =
        |[from, to]: &&[f64; 2]| format!("Proved: a Floquet multiplier is -1 at a frequency between {from} and {to}.");
    let turn = |[from, to]: &[f64; 2]| format!("Proved: the frequency turns back between {from} and {to}.");
    let limit = |Zero { epsilon, constant, coefficient: [from, to] }: &Zero| {
        format!(
            "Proved: down to amplitude zero, for 0 < eps <= eps_0 = {epsilon:e} there is a solution with omega^2 = \
             kappa (1 + 1/rho) + mu eps^(alpha - 1), mu from {from} to {to}, within C eps^alpha of the solution of \
             the DpS equation with the first harmonic eps, C = {}.",
            up(*constant)
        )
    };
    let found = doublings.iter().map(doubling).chain(turns.iter().map(turn)).chain(zero.map(limit));
    let found: Vec<String> = found.collect();
    report.fact("proof", value).words(words).words(found.join(" ")).failure(failure)
}

/// Adds to a report what is proved of a certificate, and why its multiplier is not.
fn proved(report: Report, certificate: &Certificate, proof: Checked, refused: Option<String>) -> Report {
    let refused = proof.as_ref().err().map(|why| format!("not proved: {why}")).or(refused);
    let (harmonics, block, norm) = (certificate.harmonics(), certificate.block, norm(certificate));
    let bounds = match &proof {
        Ok(Proof { bounds, .. }) | Err(Refused::Bounds(bounds)) => Some(*bounds),
        Err(_) => None,
    };
    let finite = |x: f64| Some(x).filter(|x| x.is_finite());
    let radius = |of: fn(&Proof) -> f64| proof.as_ref().ok().map(of).and_then(finite);
    let bound = |of: fn(Bounds) -> f64| bounds.map(of).and_then(finite);
    let mut value = json!({
        "proved": refused.is_none(), "radius": radius(|it| it.radius), "radius_y": radius(|it| it.radius_y),
        "radius_velocity": radius(|it| it.radius_velocity), "radius_velocity_y": radius(|it| it.radius_velocity_y),
        "uniqueness_radius": radius(|it| it.uniqueness_radius), "y0": bound(|it| it.y0), "z1": bound(|it| it.z1),
        "q": radius(|it| it.contraction),
        "harmonics": harmonics, "block": block, "norm": norm, "rounding": "outward",
        "multiplier": proof.as_ref().ok().and_then(|it| it.multiplier),
    });
    if let Some(words) = &refused {
        value["reason"] = Value::from(words.as_str());
    }
    match proof {
        Ok(proof) => {
            let bounds = proof.bounds;
            let mut far = String::new();
            if let (certificate::Orbit::Infinite { decay: rate, .. }, Some([decay, constant])) =
                (&certificate.orbit, proof.decay)
            {
                (value["decay"], value["decay_constant"]) = (json!(decay), json!(constant));
                far = format!(
                    " It is within {} e^(-{} |n|) of a standing wave for n > 0, and of the one of opposite phase \
                     for n < 0.",
                    up(constant),
                    rate
                );
            }
            let words = format!(
                "Proved: a solution is within {} of the sum of {harmonics} harmonics, {} of the amplitude. It is the \
                 only one of its symmetry and mean strain in the ball of the proof (Y0 = {}, Z1 = {}).{far}",
                up(proof.radius),
                up(proof.radius / proof.amplitude),
                up(bounds.y0),
                up(bounds.z1)
            );
            let unstable = match (proof.growth, proof.multiplier) {
                (Some(growth), _) => {
                    let (told, words) = unstable(&certificate.bloch, growth);
                    value["bloch"] = told;
                    words
                }
                (None, Some([from, to])) => {
                    format!("Proved: linearly unstable, with a real Floquet multiplier between {from} and {to}.")
                }
                (None, None) => String::new(),
            };
            report.fact("proof", value).words(words).words(unstable).failure(refused)
        }
        Err(_) => report.fact("proof", value).failure(refused),
    }
}

/// What is proved of the perturbations of a wave, with bounds of their growth rates, of the largest
/// one, and of their frequencies.
fn unstable(pieces: &[Bloch], [[a, b], largest, [c, d]]: [[f64; 2]; 3]) -> (Value, String) {
    let [from, to] = [pieces[0].p_over_pi[0], pieces[pieces.len() - 1].p_over_pi[1]];
    let mut told = json!({ "growth": [a, b], "frequency": [c, d], "p_over_pi": from.to_string() });
    let (mut numbers, mut most) = (format!("the Bloch wave number {from} pi"), String::new());
    if from != to {
        told["p_over_pi"] = json!([from.to_string(), to.to_string()]);
        (told["pieces"], told["largest_growth"]) = (json!(pieces.len()), json!(largest));
        numbers = format!("all Bloch wave numbers from {from} pi to {to} pi");
        most = format!(" The largest rate of these is between {:e} and {:e}.", largest[0], largest[1]);
    }
    let words = format!(
        "Proved: linearly unstable: perturbations of {numbers} grow at a rate between {a:e} and {b:e}, with a frequency \
         between {c:e} and {d:e}.{most}"
    );
    (told, words)
}

/// A parameter as an exact number.
fn exact(name: &'static str, x: f64) -> Result<Exact> {
    Exact::of_double(x).ok_or_else(|| Error::parameter(name, x, "a fraction of integers of 64 bits, to be proved"))
}

fn model(Params { alpha, kappa, rho }: Params, omega: f64) -> Result<Model> {
    let rho = if rho == f64::INFINITY { None } else { Some(exact("rho", rho)?) };
    Ok(Model { alpha: exact("alpha", alpha)?, kappa: exact("kappa", kappa)?, rho, omega: exact("omega", omega)? })
}

/// A number as one with few decimals, so that it is exact.
fn rounded(x: f64) -> f64 {
    (x * 1e18).round() / 1e18
}

/// The cosine sum near a wave, with these Fourier coefficients of `X`.
pub(crate) fn near_wave(wave: &ExactWave, fourier: &[f64]) -> Result<Certificate> {
    let setting = wave.setting;
    let mean = match setting.mean {
        MeanStrain::Value(mean) => mean,
        _ => rounded(wave.mean()),
    };
    let (model, mean) = (model(setting.params, setting.omega_tw)?, exact("mean", mean)?);
    let turns = || Exact::new(2 * setting.q.turns() as i64, setting.q.cell() as i64);
    let q_over_pi = turns().ok_or_else(|| Error::parameter("q_over_pi", setting.q.q() / PI, "a fraction"))?;
    let a = [&[0.0], &fourier[1..]].concat();
    Ok(near(model, mean, certificate::Orbit::Wave { q_over_pi }, vec![a]))
}

/// The cosine sum near a dark breather, with the mean strain of this orbit.
pub(crate) fn near_breather(orbit: &Orbit, tol: f64) -> Result<Certificate> {
    let setting = orbit.setting;
    let (sites, half) = (setting.sites, setting.sites / 2);
    let share = |j: u32| f64::from(j) / f64::from(SAMPLES);
    let times: Vec<f64> = (0..=SAMPLES).map(|j| 0.5 * setting.period() * share(j)).collect();
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
    let (center, first) = match setting.about {
        Some(dps::Center::Site) if setting.turns == 1 => (Center::Site, half),
        Some(dps::Center::Bond) if setting.turns == 1 => (Center::Bond, half + 1),
        // Its image has its strain half of the doubled period later, about the far site as well.
        Some(dps::Center::Bond) => (Center::Site, 0),
        _ => return Err(Error::parameter("prove", true, "a breather with a centre")),
    };
    let row = |i: usize| (0..=HARMONICS).map(|k| coefficient((first + i) % sites, k)).collect();
    let a = (0..=half).map(row).collect();
    let mean = exact("mean strain", rounded(orbit.x().iter().sum::<f64>() / sites as f64))?;
    Ok(near(model(setting.params, setting.omega_b)?, mean, certificate::Orbit::Breather { sites, center }, a))
}

/// The ends of the pieces that prove a period doubling, along a branch that comes to this orbit
/// from the frequency `before`; none if these ends are not on both sides of it.
pub(crate) fn near_doubling(orbit: &Orbit, tol: f64, before: f64) -> Result<Vec<Certificate>> {
    let (near, omega) = (near_breather(orbit, tol)?, orbit.setting.omega_b);
    let step = WIDTH.copysign(omega - before);
    for sine in [true, false] {
        let at = |omega: f64| -> Result<(Certificate, f64)> {
            let model = model(orbit.setting.params, rounded(omega))?;
            let (to, multiplier) = (Some([model.omega, near.mean]), Some(Multiplier::Doubling { sine }));
            let end = Certificate { model, to, multiplier, ..near.clone() };
            let found = solve::near(&end, Sizes::BREATHER).map(|found| checked(&Certificate { to, ..found }));
            let g = found.transpose()?.and_then(|proof| proof.ok()?.multiplier);
            let sign = g.filter(|[lo, hi]| lo * hi > 0.0).map_or(f64::NAN, |[lo, _]| lo.signum());
            Ok((Certificate { to: None, ..end }, sign))
        };
        let ((from, g), (to, h)) = (at(omega - step)?, at(omega + step)?);
        if g * h < 0.0 {
            return Ok(vec![from.clone(), from, to.clone(), to]);
        }
    }
    Ok(Vec::new())
}

/// A certificate that only says near what.
fn near(model: Model, mean: Exact, orbit: certificate::Orbit, a: Vec<Vec<f64>>) -> Certificate {
    Certificate {
        model,
        mean,
        to: None,
        first: None,
        block: 1,
        enclosed: HARMONICS,
        orbit,
        a,
        multiplier: None,
        bloch: Vec::new(),
    }
}

/// The certificate of a wave with these Fourier coefficients of `X`, and with its fastest growing
/// multiplier if this is known; or with those between two Bloch wave numbers over pi.
pub(crate) fn of_wave(
    wave: &ExactWave,
    fourier: &[f64],
    spectrum: Option<&WaveSpectrum>,
    modulation: &[f64],
    more: usize,
) -> Result<Option<Certificate>> {
    let Some(found) = solve::near(&near_wave(wave, fourier)?, Sizes::WAVE.times(more)) else { return Ok(None) };
    let Some(spectrum) = spectrum else { return Ok(Some(found)) };
    let sites = spectrum.sites;
    let turns = |it: &WaveMultiplier| (it.bloch * sites as f64 / (2.0 * PI)).round();
    if let [from, to] = *modulation {
        let growing = spectrum.multipliers.iter().filter(|it| it.kind == WaveKind::Off && it.growth > 0.0);
        let near: Vec<modulations::Near> = growing
            .filter(|it| it.bloch > 0.0)
            .map(|it| [2.0 * turns(it) / sites as f64, it.growth, it.frequency])
            .collect();
        let bloch = match modulations::pieces(&found, [from, to], &near, &interrupt::asked) {
            Err(Refused::Stopped) => return Err(stopped()),
            pieces => pieces.unwrap_or_default(),
        };
        return Ok(Some(Certificate { bloch, ..found }));
    }
    let near = |it: &WaveMultiplier, radius: f64| {
        let exact = |x: f64| Exact::of_double(rounded(x));
        let p = Exact::new(2 * turns(it) as i64, sites as i64)?;
        let (rate, radius) = ([exact(it.growth)?, exact(it.frequency)?], exact(radius)?);
        let bloch = vec![Bloch { p_over_pi: [p; 2], rate, change: [Exact::ZERO; 2], radius }];
        Some(Certificate { bloch, ..found.clone() })
    };
    for certificate in RADII.iter().filter_map(|radius| near(spectrum.fastest()?, *radius)) {
        match checked(&certificate)? {
            Ok(_) => return Ok(Some(certificate)),
            Err(Refused::Bloch { q, .. }) if q < 1.0 => {}
            // A wider ball has a larger q.
            Err(_) => break,
        }
    }
    Ok(Some(found))
}

/// Whether perturbations are proved at all Bloch wave numbers over pi between these, if there are
/// some.
fn reaches(certificate: &Certificate, modulation: &[f64]) -> bool {
    let ends = certificate.bloch.first().zip(certificate.bloch.last());
    let ends = ends.map(|(first, last)| [first.p_over_pi[0], last.p_over_pi[1]].map(Some));
    let asked = modulation.iter().map(|end| Exact::of_double(*end));
    modulation.is_empty() || ends.is_some_and(|ends| asked.eq(ends))
}

/// The certificate of a dark breather of the infinite chain: with the mean strain of the far end of
/// this orbit.
pub(crate) fn of_infinite(orbit: &Orbit, tol: f64, more: usize) -> Result<Option<Certificate>> {
    Ok(solve::unrolled(&near_breather(orbit, tol)?, Sizes::BREATHER.times(more)))
}

/// The certificate of a dark breather: of the orbit with the mean strain of this one.
pub(crate) fn of_breather(orbit: &Orbit, tol: f64, more: usize) -> Result<Option<Certificate>> {
    let harmonics = more * orbit.setting.turns as usize;
    Ok(solve::near(&near_breather(orbit, tol)?, Sizes::BREATHER.times(harmonics)))
}

/// The same, with the multiplier if it is above 1.
pub(crate) fn of_unstable(orbit: &Orbit, multiplier: f64, tol: f64, more: usize) -> Result<Option<Certificate>> {
    let period = orbit.setting.period();
    let rate = |to: f64| Exact::of_double(rounded((multiplier + to).ln() / period));
    let rates = rate(-WIDTH).zip(rate(WIDTH)).filter(|_| multiplier > 1.0 + WIDTH);
    let multiplier = rates.map(|(from, to)| Multiplier::Growing([from, to]));
    Ok(of_breather(orbit, tol, more)?.map(|it| Certificate { multiplier, ..it }))
}

options! {
    /// A certificate that is checked again.
    pub struct Prove {
        /// File that `--certificate` of a wave, a breather or a branch of them has written.
        certificate: PathBuf = PathBuf::new();
    }
}

impl Study for Prove {
    fn outline() -> Option<Report> {
        Some(Report::new("proof"))
    }

    fn begin(&self) -> Result<Work<'_>> {
        let path = &self.certificate;
        let refused = |rule: String| Error::Content { path: path.clone(), place: "certificate".to_owned(), rule };
        // A pipe without a writer would not even be opened.
        if path.metadata().is_ok_and(|it| !it.is_file() && !it.is_dir()) {
            return Err(refused("it is no file".to_owned()));
        }
        let text = String::from_utf8(read(path, LONGEST)?).map_err(|_| refused("it is no text".to_owned()))?;
        let mut pieces = certificate::pieces(&text).map_err(refused)?;
        if pieces.len() > 1 && pieces.iter().any(|piece| piece.to.is_none()) {
            return Err(refused("of several certificates each is a piece of a branch, with the line to".to_owned()));
        }
        Ok(Box::new(move |_, progress| {
            let certificate = pieces[0].clone();
            let Model { alpha, kappa, rho, .. } = certificate.model;
            let rho = rho.map_or("inf".to_owned(), |rho| rho.to_string());
            let kind = match &certificate.orbit {
                certificate::Orbit::Wave { q_over_pi } => format!("travelling wave, q = {q_over_pi} pi"),
                certificate::Orbit::Breather { sites, center } => {
                    format!("dark breather about a {} on a ring of {sites}", center.name())
                }
                certificate::Orbit::Infinite { center, .. } => {
                    format!("dark breather about a {} on the infinite chain", center.name())
                }
            };
            // Those before the first one of another chain or kind of orbit.
            let alike = pieces.iter().take_while(|piece| piece.is_alike(&certificate)).count();
            let last = pieces[..alike].last().filter(|piece| piece.to.is_some()).map(|piece| piece.ends()[1]);
            let zero = pieces[alike - 1].is_to_zero();
            let end = last.filter(|_| alike == pieces.len() && !zero).map(|to| nearest(to[0]));
            let (name, from) = (parameter(&certificate), certificate.ends()[0]);
            let [value, mean] = [0, 1].map(|i| match last {
                Some(_) if zero => format!("{} down to amplitude zero", from[i]),
                Some(to) => format!("{} to {}", from[i], to[i]),
                None => from[i].to_string(),
            });
            let words = format!(
                "{kind}; alpha = {alpha}, kappa = {kappa}, rho = {rho}, {name} {value}, mean strain {mean}, all exact."
            );
            let report = Report::new("proof")
                .fact("solution", kind)
                .fact("alpha", alpha.to_string())
                .fact("kappa", kappa.to_string())
                .fact("rho", rho)
                .fact(&name.replace(' ', "_"), value)
                .fact("mean_strain", mean)
                .words(words);
            let done = AtomicUsize::new(0);
            let all = sweep::map(&pieces, |piece| {
                let proof = checked(piece);
                let count = done.fetch_add(1, Relaxed) + 1;
                progress(count as f64 / pieces.len() as f64, &format!("{count} certificates are checked"));
                proof
            });
            let mut all = all.into_iter().collect::<Result<Vec<Checked>>>()?;
            let rule = all.iter().find_map(|proof| match proof {
                Err(Refused::Certificate(rule)) => Some(rule.clone()),
                _ => None,
            });
            match (rule, last) {
                (Some(rule), _) => Err(refused(rule)),
                (None, None) if pieces.len() == 1 => {
                    let (certificate, proof, why) = alone(certificate, all.remove(0))?;
                    Ok(proved(report, &certificate, proof, why.map(|why| format!("not proved: {why}"))))
                }
                _ => {
                    let mut all: Vec<_> = pieces.drain(..).zip(all).collect();
                    let (count, gap) = connected(&all);
                    all.truncate(count);
                    let words = |gap: Gap| format!("piece {}: {gap}", count + 1);
                    Ok(proved_branch(report, &all, end, gap.map(words)))
                }
            }
        }))
    }
}
