//! Solitary waves: the Hertz pulse, and its tails as resonators are switched on.

use crate::study::{Progress, Study, Work, fit_line, options::options};
use crate::{
    chain::Params,
    error::Result,
    number::format_short,
    report::{Column, Fixed, Hidden, Kind, Line, Panel, Panels, Power, Report, Short, Table, fields, rows},
    sweep::{Engine, Grid},
    waves::{LinePulse, Search, SolitaryWave, best_ring, wake_of_line},
};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::f64::consts::PI;

/// Phases `k/(2 pi)` of resonators from site to site of the default mass ratios. At whole ones
/// there is no wake, and every ring is in resonance: its wave is not unique.
const PHASES: [f64; 25] = [
    0.75, 0.8, 0.85, 0.9, 0.94, 0.96, 0.98, 0.99, 1.01, 1.02, 1.04, 1.06, 1.1, 1.15, 1.2, 1.25, 1.3, 1.35, 1.4, 1.45,
    1.5, 1.55, 1.6, 1.7, 1.8,
];
/// Wakes of the fit, in units of the crest: smaller ones are near rounding; with larger ones the
/// pulse is no longer that of the plain chain.
const FITTED: std::ops::RangeInclusive<f64> = 1e-12..=1e-3;
/// Least `|sin(k/2)|` of the fit.
const OFF_RESONANCE: f64 = 0.1;

options! {
    /// Solitary waves and their tails.
    pub struct Solitary {
        /// Exponent of the contact force; 1.5 for spheres.
        alpha: f64 = 1.5, "A", (1.2 to 5);
        /// Spring constant of the resonators.
        kappa: f64 = 1.0, "K", (end);
        /// Speed of the pulses, in sites per unit of time [default: that of the pulse of overlap 1
        /// without resonators].
        speed: Option<f64> = None, "C", (1e-3 to 1e3);
        /// Mass ratios resonator to bead, separated by commas [default: ratios with omega/speed
        /// from 1.5 pi to 3.6 pi].
        rhos: Vec<f64> = vec![], "A,B,..", (1e-6 to 100);
        /// Number of sites.
        ///
        /// Length of the ring. A pulse with tails is computed on a ring that is up to
        /// three sites longer, the one that is farthest from resonance with the tails.
        sites: usize = 20, "N", (8 to 60);
        /// Tolerance.
        tol: f64 = 1e-14, "T", (WAVE), [long_help = crate::study::OF_WAVE];
    }
}

impl Study for Solitary {
    const STORE: &'static str = "solitary.store";

    fn outline() -> Option<Report> {
        let [pulse, tails] = tables(&[], &[]);
        Some(Report::new("solitary").table(pulse).table(tails))
    }

    fn begin(&self) -> Result<Work<'_>> {
        self.within_ranges()?;
        Ok(Box::new(|engine, progress| Ok(self.study(engine, progress)?.report())))
    }
}

rows! {
    /// A pulse where resonators move; of the exact wave of the ring there is nothing if Newton's
    /// method has not found it.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    pub struct Tail {
        /// Mass ratio.
        rho: f64 => Power(6),
        /// Phase of a resonator from site to site, k = omega/c.
        k_over_2pi: f64 => Fixed(4),
        /// `k = omega/c`.
        k: f64,
        /// Length of the ring.
        sites: Option<usize> => Short,
        /// Largest overlap g.
        crest: Option<f64> => Fixed(8),
        /// Of the search.
        residual: Option<f64> => Power(1),
        /// Amplitude of the tail.
        tail: Option<f64> => Power(4),
        /// Amplitude W that a passage leaves behind.
        wake: Option<f64> => Power(4),
        /// The same of the pulse whose resonators follow their beads.
        wake_of_line: f64 => Power(4),
    }
}

impl Tail {
    /// `W/g`.
    pub fn share(&self) -> Option<f64> {
        Some(self.wake? / self.crest?)
    }
}

/// A fit `ln(W k/(4 sin^2(k/2) g)) = constant - width k`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TailFit {
    /// Pulses of the fit.
    pub points: usize,
    /// The constant.
    pub constant: f64,
    /// The decay, in sites.
    pub width: f64,
    /// Largest residual of the logarithm.
    pub residual: f64,
}

/// The Hertz pulse, and pulses with tails.
#[derive(Clone, Debug)]
pub struct SolitaryStudy {
    /// The options.
    pub options: Solitary,
    /// The pulse of the line.
    pub line: LinePulse,
    /// `G` at sites from the crest on, in units of the crest.
    pub decay: Vec<f64>,
    /// The exact wave of the ring without resonators.
    pub hertz: SolitaryWave,
    /// Pulses where resonators move, by mass ratio.
    pub tails: Vec<Tail>,
    /// Fit of the wakes against `k`; `None` with fewer than three that can be fitted.
    pub fit: Option<TailFit>,
}

impl Solitary {
    /// Computes the pulses.
    ///
    /// # Errors
    /// Numbers outside their rules; [`Stalled`](crate::Error::Stalled) where there is no pulse
    /// without resonators; a signal before the first tail, where a later one leaves the other tails
    /// out; errors of the store.
    pub fn study(&self, engine: &Engine, progress: Progress<'_>) -> Result<SolitaryStudy> {
        self.within_ranges()?;
        let (line, search) = (LinePulse::new(self.alpha), Search { tol: self.tol, ..Search::default() });
        let speed = self.speed.unwrap_or(line.coefficient());
        // Before the tails, which a signal ends.
        let plain = Params { alpha: self.alpha, kappa: 0.0, rho: 0.0 };
        let hertz = SolitaryWave::new(plain, speed, self.sites, &line, &search)?;
        let rhos = if self.rhos.is_empty() { self.default_rhos(speed) } else { self.rhos.clone() };
        let tail = |&rho: &f64| {
            let params = Params { alpha: self.alpha, kappa: self.kappa, rho };
            let wave = SolitaryWave::new(params, speed, best_ring(params, speed, self.sites), &line, &search).ok();
            let (k, of) = (params.omega() / speed, |of: fn(&SolitaryWave) -> f64| wave.as_ref().map(of));
            Ok(Tail {
                rho,
                k_over_2pi: k / (2.0 * PI),
                k,
                sites: wave.as_ref().map(|wave| wave.wave.setting.q.cell()),
                crest: of(SolitaryWave::crest),
                residual: of(|wave| wave.wave.residual),
                tail: of(SolitaryWave::tail),
                wake: of(SolitaryWave::wake),
                wake_of_line: wake_of_line(params, speed, &line),
            })
        };
        let settings =
            json!({"alpha": self.alpha, "kappa": self.kappa, "speed": speed, "sites": self.sites, "tol": self.tol});
        let grid = Grid { store: Self::STORE, study: "solitary", settings };
        let swept =
            engine.sweep(&grid, &rhos, progress, tail)?.values(&rhos, |rho| format!("rho = {}", format_short(*rho)))?;
        let tails: Vec<Tail> = swept.into_iter().map(|(_, tail)| tail).collect();
        let sites = line.at_sites();
        let decay = sites.iter().map(|g| g / sites[0]).collect();
        Ok(SolitaryStudy { options: self.clone(), line, decay, hertz, fit: fit(&tails), tails })
    }

    /// Mass ratios of [`PHASES`], `rho = kappa/((k c)^2 - kappa)`; those that exist.
    fn default_rhos(&self, speed: f64) -> Vec<f64> {
        let stiffness = |phase: &f64| (2.0 * PI * phase * speed).powi(2) - self.kappa;
        PHASES.iter().map(stiffness).filter(|above| *above > 0.0).map(|above| self.kappa / above).collect()
    }
}

fn fit(tails: &[Tail]) -> Option<TailFit> {
    let point = |tail: &Tail| {
        let (share, sin) = (tail.share()?, (0.5 * tail.k).sin());
        let used = FITTED.contains(&share) && sin.abs() >= OFF_RESONANCE;
        used.then(|| (tail.k, (share * tail.k / (4.0 * sin * sin)).ln()))
    };
    let points: Vec<(f64, f64)> = tails.iter().filter_map(point).collect();
    let (slope, residual) = fit_line(&points).filter(|_| points.len() >= 3)?;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
    let constant = mean(|point| point.1) - slope * mean(|point| point.0);
    Some(TailFit { points: points.len(), constant, width: -slope, residual })
}

impl SolitaryStudy {
    /// `ln|ln(g_{n+1}/g_0)| - ln|ln(g_n/g_0)|` between the last two sites; `ln alpha` in the limit.
    pub fn decay_slope(&self) -> f64 {
        let double_log = |g: &f64| g.ln().abs().ln();
        match self.decay.as_slice() {
            [.., before, last] if *before < 1.0 => double_log(last) - double_log(before),
            _ => f64::NAN,
        }
    }

    /// Largest distance of the exact wave from the pulse of the line, over all sites, in units of
    /// the crest.
    pub fn apart(&self) -> f64 {
        let (z, sites) = (&self.hertz.wave.z, self.options.sites);
        let scale = self.hertz.speed.powf(2.0 / (self.options.alpha - 1.0));
        let off = |n: usize| (-z[n] - scale * self.line.at(n.min(sites - n) as f64)[0]).abs();
        (0..sites).map(off).fold(0.0, f64::max) / self.hertz.crest()
    }

    /// The report.
    pub fn report(&self) -> Report {
        let [pulse, tails] = tables(&self.decay, &self.tails);
        let hertz = &self.hertz;
        let lost: Vec<String> =
            self.tails.iter().filter(|tail| tail.wake.is_none()).map(|t| format_short(t.rho)).collect();
        let start = hertz.wave.on_ring(self.options.sites);
        Report::new("solitary")
            .facts(fields!(self.options => alpha, kappa, sites; hertz => speed, crest(), coefficient()))
            .fact("coefficient_of_line", self.line.coefficient())
            .facts(fields!(hertz.wave => residual; self => apart()))
            .fact("x", &start[0])
            .fact("vx", &start[2])
            .fact("pulse", &self.decay)
            .fact("decay_slope", self.decay_slope())
            .fact("ln_alpha", self.options.alpha.ln())
            .words(self.caption())
            .table(pulse)
            .table(tails)
            .fact("fit", self.fit)
            .picture(Panels { title: "Solitary waves".to_owned(), columns: self.columns(), caption: self.caption() })
            .failure((!lost.is_empty()).then(|| format!("no wave was found at rho = {}", lost.join(", "))))
    }

    /// What the picture shows, with all numbers.
    fn caption(&self) -> String {
        let fit = self.fit.map_or("No fit: fewer than three wakes".to_owned(), |fit| {
            format!(
                "Fit: ln(W k/(4 sin²(k/2) g)) = {:.4} − {:.4} k to {:.2}, over {} pulses",
                fit.constant, fit.width, fit.residual, fit.points
            )
        });
        format!(
            "α = {}, κ = {}, speed c = {:.9}, N = {} and up to 3 more. Without resonators c = C g^((α−1)/2) with \
             C = {:.12}, on the infinite chain {:.12}, g = {:.12}, residual {:.1e}, distance from the pulse there {:.1e} of the crest; slope of ln|ln(gₙ/g₀)| at the end {:.6}, ln α = {:.6}. \
             W: amplitude of xₙ − yₙ that one passage leaves behind, from the tails of the exact wave of the ring; infinite chain: \
             from the Fourier transform of the plain pulse for beads of mass 1 + ρ; k = ω/c. {fit} with W from 10⁻¹² to \
             10⁻³ of the crest g and |sin(k/2)| ≥ 0.1.",
            self.options.alpha,
            format_short(self.options.kappa),
            self.hertz.speed,
            self.options.sites,
            self.hertz.coefficient(),
            self.line.coefficient(),
            self.hertz.crest(),
            self.hertz.wave.residual,
            self.apart(),
            self.decay_slope(),
            self.options.alpha.ln(),
        )
    }

    /// The pulse and its decay; the wakes against the phase of a resonator and their fit.
    fn columns(&self) -> Vec<Column> {
        let [decays, tails] = tables(&self.decay, &self.tails);
        let crest = self.line.at(0.0)[0];
        let shape =
            (0..=400).map(|i| 0.01 * f64::from(i) - 2.0).map(|xi| (1.5 * xi, self.line.at(1.5 * xi)[0] / crest));
        let (z, m) = (&self.hertz.wave.z, self.options.sites);
        let sites = [3, 2, 1].map(|n| (-(n as f64), -z[m - n])).into_iter().chain((0..=3).map(|n| (n as f64, -z[n])));
        let sites = sites.map(|(n, g)| (n, g / self.hertz.crest()));
        let decay = decays.line("ln|ln(gₙ/g₀)|", ["n", "double_log"]);
        let last = self.decay.len() - 1;
        let end = decay.points.last().map_or(f64::NAN, |point| point.1);
        let law = (1..=last).map(|n| (n as f64, end - (last - n) as f64 * self.options.alpha.ln()));
        let pulse = vec![Line::new("exact wave of the ring", sites), Line::law("infinite chain", shape)];
        let decay = vec![decay, Line::law("slope ln α", law)];
        let place = "k_over_2pi";
        let labels = ["k/2π, k = ω/c", "wake W/g"];
        let shares = [("exact", "wake_share"), ("infinite chain", "wake_share_of_line")];
        let mut wakes = tails.panel(Kind::LogParameter, labels, place, &shares);
        wakes.lines[1].law = true;
        if let Some(fit) = self.fit {
            let of = |k: f64| 4.0 * (0.5 * k).sin().powi(2) / k * (fit.constant - fit.width * k).exp();
            wakes.lines.push(Line::law("fit", self.tails.iter().map(|tail| (tail.k_over_2pi, of(tail.k)))));
        }
        let crests = tails.panel(Kind::Parameter, ["mass ratio ρ", "largest overlap g"], "rho", &[("g", "crest")]);
        let pulse = Panel::new(Kind::Cloud, ["sites from the crest", "overlap g/g₀"], pulse);
        let decay = Panel::new(Kind::Parameter, ["site n", "decay of the overlap"], decay);
        vec![Column::new("without resonators", [pulse, decay]), Column::new("with resonators", [wakes, crests])]
    }
}

/// The decay of the pulse, and the pulses with tails.
fn tables(decay: &[f64], tails: &[Tail]) -> [Table; 2] {
    let decay: Vec<(usize, f64)> = decay.iter().copied().enumerate().collect();
    let double_log = |g: f64| Some(g.ln().abs().ln()).filter(|log| log.is_finite());
    [
        Table::of("pulse", &decay)
            .key("")
            .col("n", Short, "sites from the crest", |row| row.0)
            .col("g", Power(12), "overlap over that of the crest", |row| row.1)
            .col("double_log", Fixed(6), "ln|ln g|", move |row| double_log(row.1))
            .done(),
        Tail::table("tails", tails)
            .key("tails")
            .col("wake_share", Hidden, "wake over crest", Tail::share)
            .col("wake_share_of_line", Hidden, "wake of the line over crest", |tail| {
                tail.crest.map(|crest| tail.wake_of_line / crest)
            })
            .done(),
    ]
}
