//! Section 4: travelling waves, their seven runs, and the growth of perturbations.
//!
//! | word | meaning |
//! |---|---|
//! | growth up to `t` | median of `tilde E_x`: largest up to `t` over largest in the first period |
//! | distortion | quadratic mean of a profile minus its sinusoid, divided by that of the sinusoid |

use super::{
    Group, Quantity, Run, Runs,
    measure::{distortion, measured_slow_frequency, small_wave, started},
    section3::c_alpha,
};
use crate::{
    chain::{Boundary, Params, Site, max_norm},
    dps::Averages,
    error::Result,
    run::state_at,
    study::WaveStudy,
    waves::{Modulation, PerturbedWave, Shape, Size, TravellingWave},
};
use std::f64::consts::PI;

const FIRST: Run = Run::of("tw-q15", 0.01);
const SHORT: Run = Run::of("tw-q45", 0.1);
const BROKEN_LONG: Run = Run::of("tw-breakdown-q15", 0.0);
const BROKEN_SHORT: Run = Run::of("tw-breakdown-q45", 0.0);
const RHO_3: Run = Run::of("tw-rho3", 0.01);
const RHO_10: Run = Run::of("tw-rho10", 0.0);
const RHO_1000: Run = Run::of("tw-rho1000", 0.0);
const NO_MEAN_STRAIN: Run = Run { mean_strain: Some(0.0), ..RHO_1000 };
/// The runs of the paper's figures.
const SEVEN: [Run; 7] = [FIRST, SHORT, BROKEN_LONG, BROKEN_SHORT, RHO_3, RHO_10, RHO_1000];

pub(super) const GROUPS: &[Group] = &[
    Group::of(dispersion),
    Group::of(mean_force),
    Group::on(&SEVEN, ansatz),
    Group::on(&[FIRST], first_run),
    Group::on(&[FIRST], first_run_perturbed),
    Group::on(&[SHORT], short_wave),
    Group::on(&[FIRST, BROKEN_LONG, BROKEN_SHORT], breakdown),
    Group::on(&[RHO_3], rho_3),
    Group::on(&[RHO_10], rho_10),
    Group::on(&[RHO_1000], rho_1000),
    Group::on(&[NO_MEAN_STRAIN], no_mean_strain),
    Group::on(&[RHO_3, RHO_10, RHO_1000], mass_ratio),
];

fn max_percent(errors: &[f64]) -> f64 {
    100.0 * errors.iter().copied().fold(0.0, f64::max)
}

fn final_percent(errors: &[f64]) -> f64 {
    100.0 * errors.last().copied().unwrap_or(f64::NAN)
}

/// Largest value for `from <= t <= to`.
fn largest(study: &WaveStudy, values: impl Iterator<Item = f64>, from: f64, to: f64) -> f64 {
    let inside = study.t.iter().zip(values).filter(|(t, _)| (from..=to).contains(*t));
    inside.map(|(_, value)| value).fold(0.0, f64::max)
}

/// Growth of a perturbation up to `t`; `None` for the end of the run.
fn growth(study: &WaveStudy, until: Option<f64>) -> f64 {
    let Some(ensemble) = &study.ensemble else { return f64::NAN };
    let medians = |from, to| largest(study, ensemble.difference_x.iter().map(|spread| spread.median), from, to);
    medians(0.0, until.unwrap_or(study.scene.end())) / medians(0.0, study.scene.period())
}

/// Largest error in the last `tenths` tenths of the run divided by that in the first ones.
fn trend(study: &WaveStudy, errors: &[f64], tenths: f64) -> f64 {
    let (end, part) = (study.scene.end(), 0.1 * tenths * study.scene.end());
    let within = |from, to| largest(study, errors.iter().copied(), from, to);
    within(end - part, end) / within(0.0, part)
}

/// Distortions of beads and resonators at the end, in percent.
fn distortions(study: &WaveStudy) -> [f64; 2] {
    let waves = study.wave.shape().q * study.strains.x.len() as f64 / (2.0 * PI);
    [&study.strains.x, &study.strains.y].map(|profile| 100.0 * distortion(profile, waves))
}

/// Largest growth rate of modulations, per unit of `t`.
fn modulation_rate(wave: &TravellingWave) -> Result<f64> {
    let fastest = Modulation::new(wave.params(), wave.shape())?.fastest();
    Ok(fastest.map_or(0.0, |(_, rate)| rate * wave.slow_time(1.0)))
}

/// The dispersion relation at a `kappa` other than 1.
fn dispersion(_: &Runs) -> Result<Vec<Quantity>> {
    const KAPPA: f64 = 0.4;
    let averages = Averages::new(1.5, KAPPA)?;
    // (disp) and the relation below it, as printed, for q = 4 pi/5, a = 1.
    let printed = |wave: &TravellingWave, b: f64| {
        2.0 / (KAPPA * wave.params().omega().powi(3)) * (0.4 * PI).sin().powi(2) * averages.h(b, 1.0)
    };
    let closed = |wave: &TravellingWave| {
        c_alpha(1.5) * 2f64.powf(1.5) * KAPPA.sqrt() / wave.params().omega().powi(3) * (0.4 * PI).sin().powi(2)
    };
    let (strained, unstrained) = (small_wave(KAPPA, 0.3)?, small_wave(KAPPA, 0.0)?);
    let closed_h =
        |alpha: f64, r: f64| 2f64.powf(alpha - 1.0) * c_alpha(alpha) * KAPPA.powf(alpha) * r.powf(alpha - 1.0);
    Ok(vec![
        ("s4-disp", measured_slow_frequency(&strained)? / printed(&strained, 0.3)),
        ("s4-h-closed", averages.h(0.0, 0.7) / closed_h(1.5, 0.7)),
        ("s4-Omega0", measured_slow_frequency(&unstrained)? / closed(&unstrained)),
        ("s4-kappa", rescaling()?),
    ])
}

/// Distance of the first run on a ring of ten sites, after ten periods, from a run with
/// `kappa = 2.5`, in units of the largest strain. Times of the latter are multiplied by
/// `kappa^{1/2}`, its lengths divided by `kappa^{1/(alpha-1)}`.
fn rescaling() -> Result<f64> {
    const SITES: usize = 10;
    let shape = Shape { q: 0.2 * PI, a: 1.0, b: 1.0, phi: 0.0 };
    let wave = TravellingWave::new(Params::new(1.5, 1.0, 1.0 / 3.0)?, shape, Size::Epsilon(0.057))?;
    let strains = |kappa: f64| -> Result<Vec<f64>> {
        let (length, rate) = (kappa * kappa, kappa.sqrt());
        let site = |n| {
            let Site { u, v, u_dot, v_dot } = wave.site(n, 0.0);
            let [u, v, u_dot, v_dot] = [u, v, rate * u_dot, rate * v_dot].map(|value| length * value);
            Site { u, v, u_dot, v_dot }
        };
        let (params, end) = (Params { kappa, ..wave.params() }, 20.0 * PI / wave.omega_tw() / rate);
        let mut run = started(params, (Boundary::StrainRing, SITES), &site, (end, 1e-12))?;
        Ok(state_at(&mut run, end)?[..2 * SITES].iter().map(|x| x / length).collect())
    };
    let (one, other) = (strains(1.0)?, strains(2.5)?);
    Ok(max_norm(one.iter().zip(&other).map(|(a, b)| a - b)) / max_norm(one.iter().copied()))
}

/// The statements on `b -> g_alpha(b, r)` below (eq:g_alpha).
fn mean_force(_: &Runs) -> Result<Vec<Quantity>> {
    let averages = Averages::new(1.5, 1.0)?;
    let radii = [0.3, 1.0, 4.0];
    // b / (2 r) from -10^4 to just below 1.
    let shares = || (0..200).map(|k| 1.0 - 10f64.powf(-3.0 + 7.0 * f64::from(k) / 199.0));
    let over = |of: &dyn Fn(f64, f64) -> f64| {
        radii.iter().flat_map(|&r| shares().map(move |share| of(2.0 * r * share, r))).fold(f64::NEG_INFINITY, f64::max)
    };
    Ok(vec![
        ("s4-g-decreasing", over(&|b, r| averages.values(b, r).dg_db / (2.0 * r).sqrt())),
        ("s4-g-infinity", averages.g(-1e8, 1.0)),
        (
            "s4-g-zero",
            radii.iter().flat_map(|&r| [2.0 * r, 2.1 * r, 1e3 * r].map(|b| averages.g(b, r))).fold(0.0, f64::max),
        ),
        (
            "s4-g-unique",
            over(&|b, r| {
                let c = averages.g(b, r);
                (averages.g(averages.mean_strain(c, r), r) / c - 1.0).abs()
            }),
        ),
    ])
}

/// The ansatz and the initial data that follow from it.
fn ansatz(runs: &Runs) -> Result<Vec<Quantity>> {
    let first = runs.of(FIRST);
    let (wave, sites) = (&first.wave, first.strains.x.len());
    let rho = wave.params().rho;
    let mean = first.strains.x.iter().zip(&first.strains.y).map(|(x, y)| (x + rho * y) / (1.0 + rho)).sum::<f64>();
    // The perturbed initial data, with a perturbation so small that rounding removes it.
    let quiet = PerturbedWave::new(*wave, sites, f64::MIN_POSITIVE, 1)?;
    let initial = quiet.initial(quiet.constraint())?;
    let apart = initial.iter().enumerate().map(|(n, site)| {
        let plain = wave.site(n, 0.0);
        let differences = [site.u - plain.u, site.v - plain.v, site.u_dot - plain.u_dot, site.v_dot - plain.v_dot];
        max_norm(differences)
    });
    let slow_share = |study: &WaveStudy| study.wave.omega_tw() / study.wave.params().omega() - 1.0;
    Ok(vec![
        ("s4-cc", mean / (sites as f64 * wave.epsilon() * wave.shape().b)),
        ("s4-ini", apart.fold(0.0, f64::max)),
        ("s4-slow-terms", 100.0 * SEVEN.iter().map(|&run| slow_share(runs.of(run))).fold(0.0, f64::max)),
    ])
}

fn first_run(runs: &Runs) -> Result<Vec<Quantity>> {
    let study = runs.of(FIRST);
    let (wave, errors, period) = (&study.wave, &study.errors, study.scene.period());
    Ok(vec![
        ("s4.1-omega", wave.params().omega()),
        ("s4.1-epsilon", wave.epsilon()),
        ("s4.1-amplitude", wave.amplitude()),
        ("s4.1-period", period),
        ("s4.1-end", 100.0 * period),
        ("s4.1-Ex-end", final_percent(&errors.x)),
        ("s4.1-Ey-end", final_percent(&errors.y)),
        ("s4.1-Ex-max", max_percent(&errors.x)),
        ("s4.1-Ey-max", max_percent(&errors.y)),
        ("s4.1-bounded", trend(study, &errors.x, 5.0)),
    ])
}

fn first_run_perturbed(runs: &Runs) -> Result<Vec<Quantity>> {
    let study = runs.of(FIRST);
    let errors = study.perturbed.as_ref().map_or(&[][..], |run| &run.errors.x);
    Ok(vec![
        ("s4.1-perturbed", max_percent(errors)),
        ("s4.1-early", 50.0 / study.scene.period()),
        ("s4.1-not-amplified", growth(study, Some(50.0))),
        ("s4.1-growth", growth(study, None)),
        ("s4.1-unstable", modulation_rate(&study.wave)?),
    ])
}

fn short_wave(runs: &Runs) -> Result<Vec<Quantity>> {
    let study = runs.of(SHORT);
    let perturbed = study.perturbed.as_ref().map_or(&[][..], |run| &run.errors.x);
    Ok(vec![
        ("s4.1-q45-epsilon", study.wave.epsilon()),
        ("s4.1-q45-amplitude", study.wave.amplitude()),
        ("s4.1-q45-end", 200.0 * study.scene.period()),
        ("s4.1-q45-Ex", max_percent(&study.errors.x)),
        ("s4.1-q45-Ey", max_percent(&study.errors.y)),
        ("s4.1-q45-perturbed", max_percent(perturbed)),
        ("s4.1-q45-stable", growth(study, Some(600.0))),
        ("s4.1-q45-later", modulation_rate(&study.wave)?),
    ])
}

fn breakdown(runs: &Runs) -> Result<Vec<Quantity>> {
    let (first, long, short) = (runs.of(FIRST), runs.of(BROKEN_LONG), runs.of(BROKEN_SHORT));
    let beyond = long.t.iter().zip(&long.errors.x).find(|(_, error)| **error > 0.08);
    Ok(vec![
        ("s4.1-q15-fast-epsilon", long.wave.epsilon()),
        ("s4.1-q15-fast-amplitude", long.wave.amplitude()),
        ("s4.1-q15-fast-end", 10.0 * long.scene.period()),
        ("s4.1-q15-fast-fails", beyond.map_or(f64::INFINITY, |(t, _)| t / long.scene.period())),
        ("s4.1-q45-fast-epsilon", short.wave.epsilon()),
        ("s4.1-q45-fast-smaller", short.wave.epsilon() / first.wave.epsilon()),
        ("s4.1-q45-fast-fails", max_percent(&short.errors.x)),
    ])
}

fn rho_3(runs: &Runs) -> Result<Vec<Quantity>> {
    let study = runs.of(RHO_3);
    let wave = &study.wave;
    Ok(vec![
        ("s4.2-rho3-omega", wave.params().omega()),
        ("s4.2-rho3-shift", wave.omega_tw() - wave.params().omega()),
        ("s4.2-rho3-Ex", max_percent(&study.errors.x)),
        ("s4.2-rho3-Ey", max_percent(&study.errors.y)),
        ("s4.2-rho3-stable", growth(study, Some(100.0))),
        ("s4.2-rho3-growth", growth(study, None) / growth(study, Some(100.0))),
        ("s4.2-rho3-unstable", modulation_rate(wave)?),
    ])
}

fn rho_10(runs: &Runs) -> Result<Vec<Quantity>> {
    let study = runs.of(RHO_10);
    let (wave, [x, y]) = (&study.wave, distortions(study));
    Ok(vec![
        ("s4.2-rho-c", wave.slow_time(1.0).recip()),
        ("s4.2-rho10-omega", wave.params().omega()),
        ("s4.2-rho10-omega-tw", wave.omega_tw()),
        ("s4.2-rho10-y", y),
        ("s4.2-rho10-x", x),
        ("s4.2-rho10-Ex", max_percent(&study.errors.x)),
        ("s4.2-rho10-trend", trend(study, &study.errors.x, 2.0)),
    ])
}

fn rho_1000(runs: &Runs) -> Result<Vec<Quantity>> {
    let study = runs.of(RHO_1000);
    let (wave, [x, y]) = (&study.wave, distortions(study));
    Ok(vec![
        ("s4.2-rho1000-omega", wave.params().omega()),
        ("s4.2-rho1000-omega-tw", wave.omega_tw()),
        ("s4.2-rho1000-gamma", 1.0 - wave.params().rho.ln() / wave.epsilon().ln()),
        ("s4.2-rho1000-x", x),
        ("s4.2-rho1000-Ex", max_percent(&study.errors.x)),
        ("s4.2-rho1000-y", y),
        ("s4.2-rho1000-Ey", max_percent(&study.errors.y)),
    ])
}

/// The run with `b = 0` that a remark mentions.
fn no_mean_strain(runs: &Runs) -> Result<Vec<Quantity>> {
    let study = runs.of(NO_MEAN_STRAIN);
    let (wave, [x, _]) = (&study.wave, distortions(study));
    let (params, shape) = (wave.params(), wave.shape());
    let cradle = Modulation::new(Params { rho: f64::INFINITY, ..params }, shape)?;
    let own = Modulation::new(params, shape)?;
    Ok(vec![
        ("s4.2-b0-wave", own.slow_frequency() / cradle.slow_frequency()),
        ("s4.2-b0-x", x),
        ("s4.2-b0-Ex", max_percent(&study.errors.x)),
        ("s4.2-b0-Ey", max_percent(&study.errors.y)),
    ])
}

/// The conclusions of the section.
fn mass_ratio(runs: &Runs) -> Result<Vec<Quantity>> {
    let studies = [RHO_3, RHO_10, RHO_1000].map(|run| runs.of(run));
    let [light, critical, heavy] = studies.map(|study| max_percent(&study.errors.y));
    Ok(vec![
        ("s4.2-y-deviates", (critical / light).min(heavy / critical)),
        ("s4.2-x-agrees", studies.map(|study| max_percent(&study.errors.x)).into_iter().fold(0.0, f64::max)),
    ])
}
