//! Spectra of recorded signals, in time, and in space and time.
//!
//! | symbol | meaning |
//! |---|---|
//! | `x_j` | a signal less its mean, at `j dt`, `j = 0 .. n-1`; at places `p = 0 .. N-1` |
//! | `w_j` | window: `sin^2(pi j/n)` (Hann), or 1 |
//! | `S_k` | power spectral density at the frequency `f_k = k/(n dt)`, one-sided |
//! | `P_mk` | power of waves with the wave number `2 pi m/(N d)` at `f_k`, places `d` sites apart |
//!
//! ```text
//! X_k = sum_j w_j x_j e^{-2 pi i j k/n},     S_k = c_k dt |X_k|^2 / sum_j w_j^2
//! P_mk = c_k |sum_jp w_j w_p x_jp e^{-2 pi i (m p/N - j k/n)}|^2 / (N n sum_jp w_j^2 w_p^2)
//! ```
//!
//! `c_k` is 2, and 1 at `k = 0` and `k = n/2`. So `sum_k S_k/(n dt)` and `sum_mk P_mk` are the mean
//! of `w^2 x^2` over that of `w^2`: the mean square of the signal, without a window exactly. F. J.
//! Harris 1978, Proc. IEEE 66, 51.

use crate::study::{
    Changes, ResultUnits, Signals, Study, Work,
    options::options,
    run::{Signal, error_in_file},
    scene_caption, scene_json,
    si::Scale,
};
use crate::{
    error::{Result, require},
    fourier::fourier,
    interrupt,
    orbits::Bands,
    report::{
        Digits::{Hidden, Power, Short},
        Growth, GrowthMap, Kind, Line, Panel, Panels, Report, Table,
    },
    run::Records,
    scene::{Quantity, Scene},
};
use nalgebra::Complex;
use std::f64::consts::PI;

/// Least number of samples, and of places of a spectrum of waves.
const FEWEST: usize = 16;
const FEWEST_PLACES: usize = 8;
/// Most lines of the picture.
const LINES: usize = 8;
/// Decades of power that the map shows.
const DECADES: f64 = 6.0;
/// Frequencies that the map shows, in units of the highest edge of a band.
const BEYOND: f64 = 1.25;
/// What is recorded if the scene names nothing.
const VELOCITIES: &str = "record.quantities=[\"u_dot\"]";

options! {
    /// Spectra of what a scene records.
    pub struct Spectrum {
        /// Name of a built-in scene, or a TOML file.
        ///
        /// Signals are what its `[record]` names, such as forces of chosen bonds; the velocities of
        /// all beads if it names nothing.
        scene: String = "granular-crystal".to_owned();
        /// Changes to the scene.
        changes: Changes = Changes::default(), [command(flatten)];
        /// Time from which signals count.
        ///
        /// In seconds for scenes with `[units]`.
        from: f64 = 0.0, "T", (from 0);
        /// Window in time, and in space on chains that are no rings: hann or none.
        window: String = "hann".to_owned(), "W", [arg(value_parser = ["hann", "none"])];
        /// The units of options and results.
        results: ResultUnits = ResultUnits::default(), [command(flatten)];
    }
}

#[derive(Clone, Debug, Default)]
struct Density {
    name: String,
    mean: f64,
    mean_square: f64,
    /// Without a window it sums to the mean square.
    density: Vec<f64>,
    integral: f64,
    /// Frequency of the largest density, and the amplitude of a sine with the power about it.
    strongest: (f64, f64),
}

/// The power of waves at evenly spaced places.
struct Waves {
    words: &'static str,
    /// Sites from place to place, and places.
    every: usize,
    places: usize,
    /// Frequency by frequency, wave numbers in ascending order.
    power: Vec<f64>,
}

impl Study for Spectrum {
    fn outline() -> Option<Report> {
        let one = Density { name: "force_20".to_owned(), ..Density::default() };
        let waves = Waves { words: "", every: 1, places: 1, power: Vec::new() };
        let report = Report::new("spectrum").table(signals(&[])).table(densities(&[one], &[]));
        Some(report.table(wave_table(&waves, &[])))
    }

    fn optional_files() -> Vec<String> {
        ["spectrum.png", "spectrum-waves.png", "waves.csv"].map(str::to_owned).to_vec()
    }

    fn begin(&self) -> Result<Work<'_>> {
        self.within_ranges()?;
        let mut changes = self.changes.set.clone();
        let mut scene = Scene::load_with(&self.scene, &changes)?;
        if scene.selection().is_none() {
            changes.push(VELOCITIES.to_owned());
            scene = Scene::load_with(&self.scene, &changes)?;
        }
        let from = Scale(scene.units()).read(Quantity::Time, self.from);
        let samples = ((1.0 - from / scene.end()) * scene.samples() as f64) as usize;
        let rule = "at least 16 samples after it: take more --set record.samples";
        require(from < scene.end() && samples >= FEWEST, "from", self.from, rule)?;
        let si = self.results.of(&scene);
        Ok(Box::new(move |_, progress| {
            let Some(mut signals) = Signals::new(&scene) else { return Ok(Report::new("spectrum")) };
            let mut seen = |t: f64, y: &[f64]| {
                progress(t / scene.end(), "the run");
                if t >= from {
                    signals.take(&scene, t, y);
                }
            };
            let outcome = scene.run().records(Records::Energy).observe(&mut seen, &mut |_| ())?;
            outcome.complete().map_err(|error| error_in_file(error, &scene))?;
            self.told(&scene, &signals.in_units(si.as_ref()))
        }))
    }
}

impl Spectrum {
    /// The window of a stretch of some numbers.
    fn window(&self, count: usize) -> Vec<f64> {
        let hann = |j: usize| (PI * j as f64 / count as f64).sin().powi(2);
        (0..count).map(|j| if self.window == "hann" { hann(j) } else { 1.0 }).collect()
    }

    /// The report of signals, which are in its units.
    fn told(&self, scene: &Scene, recorded: &Signals) -> Result<Report> {
        let si = self.results.of(scene);
        let scale = Scale(si.as_ref());
        let times = recorded.times();
        // The last time would be the first of the next period.
        let n = times.len() - 1;
        let dt = (times[n] - times[0]) / n as f64;
        let window = self.window(n);
        let frequencies: Vec<f64> = (0..=n / 2).map(|k| k as f64 / (n as f64 * dt)).collect();
        let mut all = Vec::new();
        for signal in recorded.all() {
            interrupt::check(0.0)?;
            all.push(spectrum(&signal, &window, dt, &frequencies));
        }
        let waves = self.waves(scene, recorded, &window)?;
        let (time, density) = match si {
            None => ("frequency f = ω/2π", "power spectral density"),
            Some(_) => ("frequency f (Hz)", "power spectral density per Hz"),
        };
        // A signal at rest has nothing on a logarithmic axis.
        let moving: Vec<&Density> = all.iter().filter(|one| one.integral > 0.0).collect();
        let every = moving.len().div_ceil(LINES).max(1);
        let line = |one: &Density| Line::new(&one.name, frequencies.iter().copied().zip(one.density.iter().copied()));
        let panel = Panel::new(Kind::LogTime, [time, density], moving.into_iter().step_by(every).map(line).collect());
        let (from, seconds) = (times[0], if si.is_some() { " s" } else { "" });
        let how = format!("{n} samples from t = {from}{seconds} on, {dt:.6e}{seconds} apart; window: {}.", self.window);
        let title = format!("Spectra of {}", scene.name());
        let drawn = !panel.lines.is_empty();
        let mut report = Report::new("spectrum")
            .si(si.as_ref())
            .fact("scene", scene.name())
            .fact("window", &self.window)
            .fact("samples", n)
            .fact("step", dt)
            .words(&how)
            .table(signals(&all))
            .table(densities(&all, &frequencies))
            .fact("scene_file", scene_json(scene))
            .warnings(scene.doubts());
        if drawn {
            report = report.picture(Panels::column(title, vec![panel], scene_caption(scene, &how)));
        }
        let Some(waves) = waves else { return Ok(report) };
        let bands = Bands::new(scene.chain()).ok();
        let top = bands.as_ref().and_then(|bands| bands.edges().last().copied()).map(|edge| BEYOND * edge[1]);
        let cycles = |omega: f64| match si {
            None => omega / (2.0 * PI),
            Some(_) => scale.reported(Quantity::Frequency, omega),
        };
        let top = top.map(cycles);
        let shown = frequencies.iter().filter(|f| top.is_none_or(|top| **f <= top)).count().max(2);
        let figure = waves.figure(scene, &how, (time, &frequencies[..shown]), |cell| {
            let Some(bands) = &bands else { return Vec::new() };
            let omegas = bands.at(cell * bands.cell() as f64);
            omegas.into_iter().map(cycles).collect()
        });
        Ok(report.table(wave_table(&waves, &frequencies)).picture_named("spectrum-waves", figure))
    }

    /// The waves of the first quantity that is recorded at evenly spaced places, if they are
    /// enough.
    fn waves(&self, scene: &Scene, recorded: &Signals, window: &[f64]) -> Result<Option<Waves>> {
        let mut quantities: Vec<_> = recorded.all().map(|signal| signal.quantity).collect();
        quantities.dedup();
        for quantity in quantities {
            let signals: Vec<Signal<'_>> = recorded.all().filter(|signal| signal.quantity == quantity).collect();
            let every = signals.get(1).map_or(1, |second| second.place - signals[0].place);
            let even = signals.windows(2).all(|two| two[1].place - two[0].place == every);
            if signals.len() < FEWEST_PLACES || !even {
                continue;
            }
            let places = signals.len();
            let chain = scene.chain();
            let ring = chain.topology().ring() && places * every == chain.sites();
            let across = if ring { vec![1.0; places] } else { self.window(places) };
            let (half, n) = (window.len() / 2 + 1, window.len());
            let mut in_time = Vec::with_capacity(places * half);
            for (signal, across) in signals.iter().zip(&across) {
                interrupt::check(0.0)?;
                let (_, values) = centred(signal, n);
                let windowed: Vec<_> = values.iter().zip(window).map(|(x, w)| Complex::from(x * w * across)).collect();
                in_time.extend(fourier(&windowed)[..half].iter().map(Complex::conj));
            }
            let squares = |of: &[f64]| of.iter().map(|w| w * w).sum::<f64>();
            let unit = (places * n) as f64 * squares(window) * squares(&across);
            let mut power = Vec::with_capacity(places * half);
            for k in 0..half {
                interrupt::check(0.0)?;
                let row: Vec<_> = (0..places).map(|p| in_time[p * half + k]).collect();
                let row = fourier(&row);
                power.extend(
                    wave_indices(places)
                        .map(|m| sides(k, n) * row[m.rem_euclid(places as i64) as usize].norm_sqr() / unit),
                );
            }
            let some = power.iter().any(|power| *power > 0.0);
            return Ok(some.then_some(Waves { words: quantity.words(), every, places, power }));
        }
        Ok(None)
    }
}

/// 2 for a frequency that stands for its negative as well.
fn sides(k: usize, n: usize) -> f64 {
    if k == 0 || 2 * k == n { 1.0 } else { 2.0 }
}

/// Numbers of waves on so many places, from the negative ones on.
fn wave_indices(places: usize) -> impl Iterator<Item = i64> + Clone {
    let least = -((places as i64 - 1) / 2);
    (0..places as i64).map(move |m| least + m)
}

/// The mean of the first `n` values of a signal, and the values less it.
fn centred(signal: &Signal<'_>, n: usize) -> (f64, Vec<f64>) {
    let mean = signal.values().take(n).sum::<f64>() / n as f64;
    (mean, signal.values().take(n).map(|x| x - mean).collect())
}

fn spectrum(signal: &Signal<'_>, window: &[f64], dt: f64, frequencies: &[f64]) -> Density {
    let n = window.len();
    let (mean, values) = centred(signal, n);
    let windowed: Vec<_> = values.iter().zip(window).map(|(x, w)| Complex::from(x * w)).collect();
    let unit = dt / window.iter().map(|w| w * w).sum::<f64>();
    let transform = fourier(&windowed);
    let density: Vec<f64> = (0..frequencies.len()).map(|k| sides(k, n) * transform[k].norm_sqr() * unit).collect();
    let step = (n as f64 * dt).recip();
    let largest = (1..density.len()).reduce(|a, b| if density[b] > density[a] { b } else { a }).unwrap_or(0);
    // The line of a sine is five frequencies wide with the window of Hann.
    let about: f64 = density[largest.saturating_sub(2)..(largest + 3).min(density.len())].iter().sum();
    Density {
        name: signal.name(),
        mean,
        mean_square: values.iter().map(|x| x * x).sum::<f64>() / n as f64,
        integral: density.iter().sum::<f64>() * step,
        density,
        strongest: (frequencies[largest], (2.0 * about * step).sqrt()),
    }
}

/// What the spectra say in short.
fn signals(all: &[Density]) -> Table {
    Table::of("spectrum-signals", all)
        .key("signals")
        .few(20)
        .col("signal", Short, "quantity and site or bond, in its unit", |one| one.name.clone())
        .col("mean", Power(6), "", |one| one.mean)
        .col("mean_square", Power(6), "about the mean", |one| one.mean_square)
        .col("integral", Power(6), "of the density", |one| one.integral)
        .col("frequency", Power(6), "of the largest density, omega/(2 pi)", |one| one.strongest.0)
        .col("amplitude", Power(6), "of a sine with the power about it", |one| one.strongest.1)
        .done()
}

/// The densities, frequency by frequency.
fn densities(all: &[Density], frequencies: &[f64]) -> Table {
    let rows: Vec<usize> = (0..frequencies.len()).collect();
    let mut table = Table::of("spectrum", &rows).key("").in_text(None);
    table = table.col("frequency", Hidden, "omega/(2 pi)", |k| frequencies[*k]);
    for (i, one) in all.iter().enumerate() {
        let about = "power spectral density of this signal, its unit squared over that of the frequency, and so on";
        table = table.col(one.name.clone(), Hidden, if i == 0 { about } else { "" }, |k| one.density[*k]);
    }
    table.done()
}

/// The power of waves, a row for each frequency and a column for each wave number.
fn wave_table(waves: &Waves, frequencies: &[f64]) -> Table {
    let rows: Vec<usize> = (0..frequencies.len()).collect();
    let mut table = Table::of("waves", &rows).key("").in_text(None);
    table = table.col("frequency", Hidden, "omega/(2 pi)", |k| frequencies[*k]);
    for (i, m) in wave_indices(waves.places).enumerate() {
        let about = "power of waves with the wave number 2 pi m/(N d), N places d sites apart, with m in the name";
        let about = if i == 0 { about } else { "" };
        table = table.col(format!("power_{m}"), Hidden, about, |k| waves.power[*k * waves.places + i]);
    }
    table.done()
}

impl Waves {
    /// The map of power over wave number and frequency, with the bands, whose frequencies are those
    /// at a phase from site to site; beside it the power of all wave numbers.
    fn figure(
        &self,
        scene: &Scene,
        how: &str,
        (label, frequencies): (&str, &[f64]),
        bands: impl Fn(f64) -> Vec<f64>,
    ) -> Growth {
        let rows = || self.power.chunks_exact(self.places).take(frequencies.len());
        let largest = rows().flatten().copied().fold(f64::MIN_POSITIVE, f64::max);
        let decades = |power: f64, of: f64| ((power / of).log10() + DECADES).max(0.0);
        let sums: Vec<f64> = rows().map(|row| row.iter().sum()).collect();
        let most = sums.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let edge = 1.0 / self.every as f64;
        let phases = (-200..=200).map(|i| edge * f64::from(i) / 200.0);
        let count = bands(0.5).len();
        let band = |b: usize| {
            let points = phases.clone().map(|q| (q, bands(PI * q.abs())[b]));
            Line::new(&format!("band {}", b + 1), points)
        };
        let scale = format!("decades above 1e-{DECADES}");
        let step = frequencies[1] - frequencies[0];
        // Wave numbers are in the middle of columns.
        let first = wave_indices(self.places).next().unwrap_or(0) as f64 - 0.5;
        let x = (2.0 * edge * first / self.places as f64, 2.0 * edge * (first / self.places as f64 + 1.0));
        let y = (frequencies[0] - 0.5 * step, frequencies[frequencies.len() - 1] + 0.5 * step);
        Growth {
            title: format!("Waves of {}", scene.name()),
            wave_label: label.to_owned(),
            growth_label: format!("power of all wave numbers, {scale} of the largest"),
            theory: Line::new(self.words, frequencies.iter().copied().zip(sums.iter().map(|sum| decades(*sum, most)))),
            measured: Vec::new(),
            map: Some(GrowthMap {
                labels: ["wave number k/π".to_owned(), label.to_owned(), format!("power, {scale} of the largest")],
                x,
                y,
                values: rows().flatten().map(|power| decades(*power, largest)).collect(),
                columns: self.places,
                lines: (0..count).map(band).collect(),
                points: Line::new("", []),
            }),
            caption: scene_caption(
                scene,
                &format!("Power over wave number and frequency; bands of the infinite chain. {how}"),
            ),
        }
    }
}
