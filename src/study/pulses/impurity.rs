//! A solitary wave that meets one bead of another mass.
//!
//! | symbol | meaning |
//! |---|---|
//! | `M` | mass of the bead over that of the others |
//! | `T, R, L` | shares of the energy behind the bead, before it, and its own, at the end of the run |
//! | `w` | `u - (u_- + u_+)/2`, the place of the bead between its neighbours |
//! | `G` | `u_- - u_+`, the overlap that its two contacts share |
//! | `Omega` | frequency of `w''` while both contacts are closed |
//!
//! A light bead lets the wave through and rings between its neighbours (S. Job, F. Santibanez, F.
//! Tapia & F. Melo 2009, Phys. Rev. E 80, 025602). As long as `G` hardly changes in a period, and
//! the contacts on the other sides of the neighbours are soft, `w'' = -2 f'(G/2) (1/M + 1/2) w` for
//! small `w`, so that `Omega = (f'(G/2) (2/M + 1))^{1/2}`. A heavy bead is a wall that throws the
//! wave back, takes up twice its momentum `p`, and passes its energy on: `T = 2 p^2/(M E)`. If the
//! wave were a sequence of collisions of two beads, `T` would be `(4 M/(1 + M)^2)^2`.
//!
//! A run ends at `t = 200 + 20 (M - 1)_+`. Beads still touch each other then, gently; each row also
//! has the largest change of a share in the last quarter of the run.

use super::{ALPHA, LEAD, METHOD, STEP, ascending, follow, geometric, plain, solitary_wave};
use crate::{
    error::{Result, require},
    report::{
        Digits::{Fixed, Power, Short},
        Kind, Line, Panels, Report, rows,
    },
    study::{Progress, Study, Work, options::options},
    sweep::{Engine, Grid},
};
use serde::{Deserialize, Serialize};
use serde_json::json;

/// Number of beads behind the impurity: a fixed one, and more for each unit of its mass, as a heavy
/// bead drives a train of pulses.
const BEYOND: f64 = 16.0;
const BEYOND_A_MASS: f64 = 8.0;
/// Length of a run, and what each unit of mass adds.
const END: f64 = 200.0;
const END_A_MASS: f64 = 20.0;
/// Share of the run after which shares of the energy are first taken.
const LATE: f64 = 0.75;
/// Least number of sign changes of `w''` from which a frequency is taken.
const CHANGES: usize = 4;

options! {
    /// The study of a solitary wave at an impurity.
    pub struct ImpurityOptions {
        /// Smallest mass ratio.
        ///
        /// Mass of the impurity over that of the other beads.
        from: f64 = 0.01, "M", (1e-3 to 20);
        /// Largest mass ratio.
        ///
        /// Mass of the impurity over that of the other beads.
        to: f64 = 20.0, "M", (1e-3 to 20);
        /// Number of points.
        ///
        /// Mass ratios, evenly spaced in their logarithm.
        points: usize = 67, "K", (3 to 10_000);
    }
}

rows! {
    /// A solitary wave that has met an impurity.
    #[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
    pub struct ImpurityRow {
        /// Mass ratio `M`.
        ratio: f64 => Fixed(4),
        /// Share `T` of the energy behind the impurity at the end of the run, `t = 200 + 20 (M -
        /// 1)_+`.
        transmitted: f64 => Fixed(6),
        /// Share `R` of the energy before the impurity.
        reflected: f64 => Fixed(6),
        /// Share `L` of the energy of the impurity itself.
        localised: f64 => Fixed(6),
        /// The most by which one of these shares changed in the last quarter of the run.
        late_change: f64 => Power(0),
        /// `(4 M/(1 + M)^2)^2`, the share `T` of two collisions, one after the other.
        binary: f64,
        /// `2 p^2/(M E)`, the share `T` of a heavy bead.
        heavy: f64,
        /// Changes of the sign of `w''` until a contact of the impurity first opens.
        changes: usize => Short,
        /// `Omega` from the times between them, if there are at least four.
        frequency: Option<f64> => Fixed(4),
        /// The mean of `(f'(G/2) (2/M + 1))^{1/2}` over the same time.
        frequency_law: Option<f64> => Fixed(4),
    }
}

impl ImpurityOptions {
    fn check(&self) -> Result<()> {
        self.within_ranges()?;
        ascending(self.from, self.to)
    }
}

impl Study for ImpurityOptions {
    const STORE: &'static str = "impurity.store";

    fn outline() -> Option<Report> {
        Some(report(&[]))
    }

    fn begin(&self) -> Result<Work<'_>> {
        self.check()?;
        Ok(Box::new(|engine, progress| Ok(report(&impurity(self, engine, progress)?))))
    }
}

/// The scattering at every mass ratio, on all cores. `progress` is told the share done.
///
/// # Errors
/// An option outside its rule; a run that fails; a signal.
pub fn impurity(options: &ImpurityOptions, engine: &Engine, progress: Progress<'_>) -> Result<Vec<ImpurityRow>> {
    options.check()?;
    let ratios = geometric(options.from, options.to, options.points);
    let grid = Grid { store: ImpurityOptions::STORE, study: "impurity", settings: json!({"step": STEP}) };
    let swept = engine.sweep(&grid, &ratios, progress, |&ratio| scattered(ratio))?;
    swept.all(&ratios, |ratio| format!("mass ratio {ratio}"))
}

/// The solitary wave of speed 1 at a bead of this mass amid beads of mass 1.
///
/// The run ends at `t = 200 + 20 (M - 1)_+`; see `late_change`.
///
/// ```
/// use hertzchain::study::scattered;
/// assert!(scattered(1.0)?.transmitted > 0.999_99);
/// assert!(scattered(20.0)?.reflected > 0.5);
/// # Ok::<(), hertzchain::Error>(())
/// ```
///
/// # Errors
/// A mass ratio that is not finite and positive; a run that fails; a signal.
pub fn scattered(ratio: f64) -> Result<ImpurityRow> {
    require(ratio.is_finite() && ratio > 0.0, "ratio", ratio, "a mass ratio is finite and positive")?;
    let heavier = ratio.max(1.0) - 1.0;
    let sites = LEAD + 1 + (BEYOND + BEYOND_A_MASS * heavier) as usize;
    let chain = plain((0..sites).map(|i| if i == LEAD { ratio } else { 1.0 }).collect(), Vec::new())?;
    let start = solitary_wave(&chain);
    let layout = chain.layout();
    let momentum: f64 = layout.u_dot(start.as_slice()).iter().sum();
    let energy: f64 = chain.site_energies(start.as_slice()).iter().sum();
    let mut ringing = Ringing::new(ratio);
    let end = END + END_A_MASS * heavier;
    let mut shares: Vec<[f64; 3]> = Vec::new();
    let mut look = |t: f64, y: &[f64]| {
        ringing.look(t, &layout.u(y)[LEAD - 2..=LEAD + 2]);
        if t >= [LATE * end, end][shares.len()] {
            let energies = chain.site_energies(y);
            let parts = [&energies[LEAD + 1..], &energies[..LEAD], &energies[LEAD..=LEAD]];
            shares.push(parts.map(|sites| sites.iter().sum::<f64>() / energy));
        }
        shares.len() == 2
    };
    follow(&chain, start, (STEP * ratio.min(1.0).sqrt(), end + 1.0), &mut look)?;
    let [transmitted, reflected, localised] = shares[1];
    let (frequency, frequency_law) = ringing.frequencies().unzip();
    Ok(ImpurityRow {
        ratio,
        transmitted,
        reflected,
        localised,
        late_change: (0..3).map(|part| (shares[1][part] - shares[0][part]).abs()).fold(0.0, f64::max),
        binary: (4.0 * ratio / (1.0 + ratio).powi(2)).powi(2),
        heavy: 2.0 * momentum * momentum / (ratio * energy),
        changes: ringing.changes,
        frequency,
        frequency_law,
    })
}

/// The motion of a bead between its neighbours while both contacts are closed for the first time.
struct Ringing {
    ratio: f64,
    /// Time, `w''` and the law after the last step; none before the contacts close.
    last: Option<[f64; 3]>,
    opened: bool,
    changes: usize,
    /// Times of the first and the last sign change.
    times: [f64; 2],
    /// The integral of the law up to the last step, and at these times.
    phase: f64,
    phases: [f64; 2],
}

impl Ringing {
    fn new(ratio: f64) -> Self {
        Self { ratio, last: None, opened: false, changes: 0, times: [0.0; 2], phase: 0.0, phases: [0.0; 2] }
    }

    /// Takes the positions of the bead and of two neighbours on either side after a step.
    fn look(&mut self, t: f64, u: &[f64]) {
        let force = |bond: usize| (u[bond] - u[bond + 1]).max(0.0).powf(ALPHA);
        let closed = u[1] > u[2] && u[2] > u[3];
        self.opened |= self.last.is_some() && !closed;
        if self.opened || !closed {
            return;
        }
        let [before, left, right, behind] = [0, 1, 2, 3].map(force);
        let w = (left - right) / self.ratio - 0.5 * (before - left + right - behind);
        let stiffness = ALPHA * (0.5 * (u[1] - u[3])).powf(ALPHA - 1.0);
        let law = (stiffness * (2.0 / self.ratio + 1.0)).sqrt();
        if let Some([before, w_before, law_before]) = self.last {
            let part = w_before / (w_before - w);
            if w_before * w < 0.0 {
                let which = usize::from(self.changes > 0);
                self.changes += 1;
                self.times[which] = before + part * (t - before);
                self.phases[which] = self.phase + part * (t - before) * law_before;
            }
            self.phase += 0.5 * (t - before) * (law + law_before);
        }
        self.last = Some([t, w, law]);
    }

    /// The frequency from the times between sign changes, and by the law.
    fn frequencies(&self) -> Option<(f64, f64)> {
        let span = self.times[1] - self.times[0];
        let turns = std::f64::consts::PI * (self.changes.max(1) - 1) as f64;
        (self.changes >= CHANGES).then(|| (turns / span, (self.phases[1] - self.phases[0]) / span))
    }
}

fn report(rows: &[ImpurityRow]) -> Report {
    let table = ImpurityRow::table("impurity", rows).done();
    let label = "mass ratio M";
    let lines = [
        ("transmitted", "transmitted"),
        ("reflected", "reflected"),
        ("localised", "localised"),
        ("two collisions", "binary"),
    ];
    let mut shares = table.panel(Kind::LogCloud, [label, "share of the energy"], "ratio", &lines);
    let heavy = rows.iter().filter(|row| row.heavy < 1.0).map(|row| (row.ratio, row.heavy));
    shares.lines.push(Line::new("2p²/(ME)", heavy));
    let lines = [("computed", "frequency"), ("(f′(G/2)(2/M + 1))^(1/2)", "frequency_law")];
    let frequencies = table.panel(Kind::LogLog, [label, "frequency Ω"], "ratio", &lines);
    let measured = frequencies.lines.iter().all(|line| !line.points.is_empty());
    let late = rows.iter().map(|row| row.late_change).fold(0.0, f64::max);
    let caption = format!(
        "A solitary wave of speed 1 of the plain chain, α = 3/2, without precompression, meets one bead of mass M amid \
             beads of mass 1. Above: energy behind the bead, before it and its own at t = 200 + 20 (M − 1)₊, \
             where none of them changed by more than {late:.0e} in the last quarter of the run; what two collisions of hard beads would pass on; what a heavy bead passes on that was thrown forward with \
             twice the momentum p of the wave of energy E. Below: frequency of the bead between its neighbours until a \
             contact opens, where it has at least {CHANGES} changes of sign of the acceleration, and that of small swings. Integrator {METHOD}, steps of {STEP}, shorter for light beads."
    );
    let plots = [shares].into_iter().chain(measured.then_some(frequencies)).collect();
    Report::new("impurity").fact("integrator", METHOD).fact("step", STEP).table(table).picture(Panels::column(
        "A solitary wave at an impurity",
        plots,
        caption,
    ))
}
