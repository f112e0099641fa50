//! A solitary wave that runs into beads whose masses are drawn at random.
//!
//! | symbol | meaning |
//! |---|---|
//! | `eps` | strength: masses are uniform in `[1 - eps, 1 + eps]` |
//! | `E_n` | energy of the pulse when its crest is at bond `n`, over that at the start |
//! | rate | `-d <ln E_n>/dn`, mean over seeds, by a straight line from bond 10 on |
//!
//! Below a level of disorder the amplitude of a pulse decays exponentially with distance, above it
//! like a power (L. Ponson, N. Boechler, Y. M. Lai, M. A. Porter, P. G. Kevrekidis & C. Daraio
//! 2010, Phys. Rev. E 82, 021301, for beads of two masses). A sequence of collisions of two beads
//! passes on `4 m m'/(m + m')^2` of the energy each time, whose mean logarithm is `-eps^2/6` to
//! leading order. The wave is wider than a bead and loses less.

use super::{CREST, Crests, LEAD, METHOD, STEP, follow, plain, pulse_energy, solitary_wave};
use crate::{
    error::Result,
    random::uniform,
    report::{
        Band,
        Digits::{Fixed, Hidden, Json, Power},
        Kind, Line, Panel, Panels, Report, Table, rows,
    },
    study::{Progress, Study, Work, fit_line, options::options},
    sweep::{Engine, Grid},
};
use serde_json::json;

/// Number of first bonds that the line fit of the rate leaves out.
const FIRST: usize = 10;
/// Beads after the last that is measured, so that the free end is not felt.
const BEYOND: usize = 8;
/// End of a run, in units of the time that the solitary wave takes.
const END: f64 = 6.0;

options! {
    /// The study of pulses in disordered chains.
    pub struct DisorderOptions {
        /// Strengths of the disorder, separated by commas.
        ///
        /// With the strength E, masses are drawn evenly from 1 - E to 1 + E.
        strengths: Vec<f64> = vec![0.1, 0.2, 0.4, 0.8], "E,..", (0 to 0.9);
        /// Number of chains for each strength.
        ///
        /// Their seeds are 1, 2, 3, and so on.
        chains: u64 = 100, "K", (2 to 100_000);
        /// Number of beads whose masses are drawn.
        drawn: usize = 100, "N", (20 to 2000);
    }
}

rows! {
    /// Pulses in chains with disorder of one strength.
    #[derive(Clone, Debug, PartialEq)]
    pub struct DisorderRow {
        /// Strength `eps`: masses are drawn from 1 - eps to 1 + eps.
        strength: f64 => Fixed(3),
        /// Rate of decay of the energy of the pulse from bead to bead, mean of all chains.
        rate: f64 => Power(3),
        /// Its standard error, from the spread of the rates of single chains.
        error: f64 => Power(3),
        /// `eps^2/6`, the rate of a sequence of collisions of two beads.
        binary: f64 => Power(3),
        /// Mean of `ln E_n` over seeds, from the first disordered bond on.
        log_energy: Vec<f64> => Json,
        /// Standard deviation of `ln E_n` over seeds.
        spread: Vec<f64> => Json,
    }
}

/// The outcome of the study.
#[derive(Clone, Debug)]
pub struct DisorderStudy {
    /// Number of seeds.
    pub seeds: u64,
    /// A row a strength.
    pub rows: Vec<DisorderRow>,
}

impl Study for DisorderOptions {
    const STORE: &'static str = "disorder.store";

    fn outline() -> Option<Report> {
        Some(DisorderStudy { seeds: 0, rows: Vec::new() }.report())
    }

    fn begin(&self) -> Result<Work<'_>> {
        self.within_ranges()?;
        Ok(Box::new(|engine, progress| Ok(disorder(self, engine, progress)?.report())))
    }
}

/// The decay at every strength; each chain is a point of a grid. `progress` is told the share done.
///
/// # Errors
/// An option outside its rule; a run that fails; a signal.
pub fn disorder(options: &DisorderOptions, engine: &Engine, progress: Progress<'_>) -> Result<DisorderStudy> {
    options.within_ranges()?;
    let DisorderOptions { strengths, chains: seeds, drawn: beads } = options;
    let chains: Vec<(f64, u64)> =
        strengths.iter().flat_map(|&strength| (1..=*seeds).map(move |seed| (strength, seed))).collect();
    let grid =
        Grid { store: DisorderOptions::STORE, study: "disorder", settings: json!({"beads": beads, "step": STEP}) };
    let swept = engine.sweep(&grid, &chains, progress, |&(strength, seed)| decay(strength, *beads, seed))?;
    let energies = swept.all(&chains, |(strength, seed)| format!("strength {strength}, seed {seed}"))?;
    let rows = strengths.iter().zip(energies.chunks(*seeds as usize));
    Ok(DisorderStudy { seeds: *seeds, rows: rows.map(|(&strength, energies)| row_of(strength, energies)).collect() })
}

/// Energies `E_n` of the solitary wave of speed 1 in `beads` beads with masses drawn from `1 -
/// strength` to `1 + strength`, at all their bonds.
///
/// ```
/// use hertzchain::study::decay;
/// // Without disorder the pulse keeps its energy; with it, it loses some.
/// assert!(decay(0.0, 20, 1)?.iter().all(|energy| (energy - 1.0).abs() < 1e-5));
/// assert!(decay(0.8, 20, 1)?[19] < 0.9);
/// # Ok::<(), hertzchain::Error>(())
/// ```
///
/// # Errors
/// A strength that makes a mass negative; a run that fails; a signal.
pub fn decay(strength: f64, beads: usize, seed: u64) -> Result<Vec<f64>> {
    let mut draw = uniform(seed);
    let mut mass = vec![1.0; LEAD];
    mass.extend((0..beads).map(|_| 1.0 + strength * draw()));
    mass.extend([1.0; BEYOND]);
    let least = mass.iter().copied().fold(1.0, f64::min);
    let chain = plain(mass, Vec::new())?;
    let start = solitary_wave(&chain);
    let whole = pulse_energy(&chain, start.as_slice(), CREST);
    let mut crests = Crests::new(beads);
    let mut energies = vec![0.0; beads];
    let end = END * (LEAD + beads + BEYOND) as f64;
    follow(&chain, start, (STEP * least.sqrt(), end), &mut |_, y| {
        let overlaps = chain.overlaps(chain.layout().u(y));
        crests.look(overlaps[LEAD..LEAD + beads].iter().copied(), |k| {
            energies[k] = pulse_energy(&chain, y, LEAD + k) / whole;
        });
        crests.all_passed()
    })?;
    Ok(energies)
}

fn row_of(strength: f64, energies: &[Vec<f64>]) -> DisorderRow {
    let logs: Vec<Vec<f64>> = energies.iter().map(|chain| chain.iter().map(|energy| energy.ln()).collect()).collect();
    let rates: Vec<f64> = logs.iter().map(|logs| rate(logs)).collect();
    let bonds = 0..logs.first().map_or(0, Vec::len);
    let (log_energy, spread) = bonds.map(|n| mean(logs.iter().map(|chain| chain[n]))).unzip();
    let (rate, deviation) = mean(rates.iter().copied());
    let error = deviation / (rates.len() as f64).sqrt();
    DisorderRow { strength, rate, error, binary: strength * strength / 6.0, log_energy, spread }
}

fn rate(logs: &[f64]) -> f64 {
    let points: Vec<(f64, f64)> = logs.iter().enumerate().skip(FIRST).map(|(n, log)| (n as f64, *log)).collect();
    fit_line(&points).map_or(f64::NAN, |(slope, _)| -slope)
}

/// Mean and standard deviation of a sample.
fn mean(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    let squares: f64 = values.map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (count - 1.0)).sqrt())
}

impl DisorderStudy {
    /// The exponent `b` of `rate = a eps^b` over the strengths whose rate is positive, by a
    /// straight line; `None` with fewer than two of them.
    pub fn exponent(&self) -> Option<f64> {
        let good = self.rows.iter().filter(|row| row.strength > 0.0 && row.rate > 0.0);
        let points: Vec<(f64, f64)> = good.map(|row| (row.strength.ln(), row.rate.ln())).collect();
        fit_line(&points).map(|(slope, _)| slope)
    }
}

impl DisorderStudy {
    /// The report.
    pub fn report(&self) -> Report {
        let per_square = |row: &DisorderRow| (row.strength > 0.0).then(|| row.rate / (row.strength * row.strength));
        let table = DisorderRow::table("disorder", &self.rows).col("rate/eps^2", Fixed(4), "", per_square).done();
        let all = |row: &DisorderRow| {
            let bonds = row.log_energy.iter().zip(&row.spread).enumerate();
            bonds.map(|(n, (log, spread))| (row.strength, n, *log, *spread)).collect::<Vec<_>>()
        };
        let energies = Table::of("energies", &self.rows.iter().flat_map(all).collect::<Vec<_>>())
            .key("")
            .col("strength", Hidden, "masses are drawn from 1 - eps to 1 + eps", |row| row.0)
            .col("bond", Hidden, "number of the bead, from 0", |row| row.1)
            .col("log_energy", Hidden, "mean of the logarithm of the energy of the pulse there", |row| row.2)
            .col("spread", Hidden, "its standard deviation", |row| row.3)
            .done();
        let decays = self.rows.iter().map(|row| {
            let points = row.log_energy.iter().enumerate().map(|(n, log)| (n as f64, log.exp()));
            Line::new(&format!("ε = {}", row.strength), points)
        });
        let band = |row: &DisorderRow| {
            let bonds = row.log_energy.iter().zip(&row.spread).enumerate();
            let points = bonds.map(|(n, (log, spread))| (n as f64, (log - spread).exp(), (log + spread).exp()));
            Band { name: "± σ".to_owned(), points: points.collect() }
        };
        let mut energy = Panel::new(Kind::LogTime, ["bead n", "energy of the pulse"], decays.collect());
        energy.bands = self.rows.iter().map(band).collect();
        let positive = || self.rows.iter().filter(|row| row.strength > 0.0 && row.rate > 0.0);
        let rates = vec![
            Line::new("computed", positive().map(|row| (row.strength, row.rate))),
            Line::new("ε²/6", positive().map(|row| (row.strength, row.binary))),
        ];
        let mut plots = vec![energy];
        if positive().count() > 1 {
            plots.push(Panel::new(Kind::LogLog, ["strength ε", "rate of decay a bead"], rates));
        }
        let caption = format!(
            "A solitary wave of the uniform chain, α = 3/2, without precompression, runs into beads with masses drawn evenly \
             from 1 − ε to 1 + ε. Above: geometric mean over {} chains of the energy in {} sites about the crest, and its \
             standard deviation σ. Below: rate of the exponential decay; ε²/6 if two beads collide at a time. Seeds from 1 \
             on. Integrator {METHOD}, steps of {STEP}, shorter for light beads.",
            self.seeds,
            2 * super::HALF_PULSE,
        );
        let fit = self.exponent().map_or_else(String::new, |slope| {
            format!("rate ~ strength^{slope:.2}, over {} chains a strength.", self.seeds)
        });
        Report::new("disorder")
            .fact("seeds", self.seeds)
            .fact("integrator", METHOD)
            .fact("step", STEP)
            .fact("exponent", self.exponent())
            .table(table)
            .table(energies)
            .words(fit)
            .picture(Panels::column("A pulse in disordered chains", plots, caption))
    }
}
