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
//! Tapia & F. Melo 2009, Phys. Rev. E 80, 025602). As long as `G` hardly changes in a period, and the
//! contacts on the other sides of the neighbours are soft, `w'' = -2 f'(G/2) (1/M + 1/2) w` for small
//! `w`, so that `Omega = (f'(G/2) (2/M + 1))^{1/2}`. A heavy bead is a wall that throws the wave back,
//! takes up twice its momentum `p`, and passes its energy on: `T = 2 p^2/(M E)`. If the wave were a
//! sequence of collisions of two beads, `T` would be `(4 M/(1 + M)^2)^2`.
//!
//! A run ends at `t = 200 + 20 (M - 1)_+`. Beads still touch each other then, gently; each row also
//! has the largest change of a share in the last quarter of the run.

use super::{ALPHA, LEAD, METHOD, STEP, check_count, check_range, follow, geometric, plain, solitary_wave};
use crate::{
    error::{Error, Result},
    output::csv,
    present::table,
    study::{File, Progress, Report, Study, Work, named},
    sweep::map,
    waves::LinePulse,
};
use serde::Serialize;
use serde_json::{Value, json};

const RATIOS: std::ops::RangeInclusive<f64> = 1e-3..=20.0;
const POINTS: std::ops::RangeInclusive<usize> = 3..=10_000;
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

/// The study of a solitary wave at an impurity.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct ImpurityOptions {
    /// Smallest mass ratio.
    ///
    /// Mass of the impurity over that of the other beads, from 0.001 to 20.
    #[cfg_attr(feature = "cli", arg(long, value_name = "M", default_value = "0.01"))]
    pub from: f64,
    /// Largest mass ratio.
    ///
    /// Mass of the impurity over that of the other beads, from 0.001 to 20.
    #[cfg_attr(feature = "cli", arg(long, value_name = "M", default_value = "20"))]
    pub to: f64,
    /// Number of mass ratios, evenly spaced in their logarithm.
    ///
    /// From 3 to 10000.
    #[cfg_attr(feature = "cli", arg(long = "ratios", value_name = "K", default_value_t = 67))]
    pub points: usize,
}

impl Default for ImpurityOptions {
    fn default() -> Self {
        Self { from: 0.01, to: 20.0, points: 67 }
    }
}

/// A solitary wave that has met an impurity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ImpurityRow {
    /// Mass ratio `M`.
    pub ratio: f64,
    /// Share `T` of the energy behind the impurity.
    pub transmitted: f64,
    /// Share `R` of the energy before the impurity.
    pub reflected: f64,
    /// Share `L` of the energy of the impurity itself.
    pub localised: f64,
    /// The most by which one of these shares changed in the last quarter of the run.
    pub late_change: f64,
    /// `(4 M/(1 + M)^2)^2`, the share `T` of two collisions, one after the other.
    pub binary: f64,
    /// `2 p^2/(M E)`, the share `T` of a heavy bead.
    pub heavy: f64,
    /// Sign changes of `w''` until a contact of the impurity first opens.
    pub changes: usize,
    /// `Omega` from the times between them, if there are at least four.
    pub frequency: Option<f64>,
    /// The mean of `(f'(G/2) (2/M + 1))^{1/2}` over the same time.
    pub frequency_law: Option<f64>,
}

/// The outcome of the study.
#[derive(Clone, Debug)]
pub struct ImpurityStudy {
    /// A row a mass ratio, ascending.
    pub rows: Vec<ImpurityRow>,
}

impl ImpurityOptions {
    fn check(&self) -> Result<()> {
        check_range(self.from, self.to, &RATIOS, "a mass ratio from 0.001 to 20")?;
        check_count("ratios", self.points, &POINTS, "from 3 to 10000")
    }
}

impl Study for ImpurityOptions {
    const FILES: &'static str = "Files: impurity.csv, impurity.json and impurity.png.";

    fn begin(&self) -> Result<Work<'_>> {
        self.check()?;
        Ok(Box::new(|_, progress| Ok(Box::new(impurity(self, progress)?))))
    }
}

/// The scattering at every mass ratio, on all cores. `progress` is told the share done.
///
/// # Errors
/// An option outside its rule; a run that fails; a signal.
pub fn impurity(options: &ImpurityOptions, progress: Progress<'_>) -> Result<ImpurityStudy> {
    options.check()?;
    let line = LinePulse::new(ALPHA);
    let ratios = geometric(options.from, options.to, options.points);
    let rows = map(&ratios, |&ratio| {
        let share = ratios.partition_point(|&below| below < ratio) as f64 / ratios.len() as f64;
        progress(share, &format!("M = {ratio:.4}"));
        scattered(ratio, &line)
    });
    Ok(ImpurityStudy { rows: rows.into_iter().collect::<Result<_>>()? })
}

/// The solitary wave of speed 1 at a bead of this mass amid beads of mass 1.
///
/// The run ends at `t = 200 + 20 (M - 1)_+`; see `late_change`.
///
/// ```
/// use hertzchain::{study::scattered, waves::LinePulse};
/// let line = LinePulse::new(1.5);
/// assert!(scattered(1.0, &line)?.transmitted > 0.999_99);
/// assert!(scattered(20.0, &line)?.reflected > 0.5);
/// # Ok::<(), hertzchain::Error>(())
/// ```
///
/// # Errors
/// A mass ratio that is not finite and positive; a run that fails; a signal.
pub fn scattered(ratio: f64, line: &LinePulse) -> Result<ImpurityRow> {
    if !(ratio.is_finite() && ratio > 0.0) {
        return Err(Error::parameter("ratio", ratio, "a mass ratio is finite and positive"));
    }
    let heavier = ratio.max(1.0) - 1.0;
    let sites = LEAD + 1 + (BEYOND + BEYOND_A_MASS * heavier) as usize;
    let chain = plain((0..sites).map(|i| if i == LEAD { ratio } else { 1.0 }).collect(), Vec::new())?;
    let start = solitary_wave(&chain, line);
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

impl Report for ImpurityStudy {
    fn json(&self) -> Value {
        json!({
            "integrator": METHOD,
            "step": STEP,
            "rows": self.rows,
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self) -> String {
        let number = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| format!("{value:.4}"));
        let cells = |row: &ImpurityRow| {
            let shares = [row.transmitted, row.reflected, row.localised].map(|share| format!("{share:.6}"));
            let late = format!("{:.0e}", row.late_change);
            let rest = [late, row.changes.to_string(), number(row.frequency), number(row.frequency_law)];
            [format!("{:.4}", row.ratio)].into_iter().chain(shares).chain(rest).collect()
        };
        let rows: Vec<_> = self.rows.iter().map(cells).collect();
        let head =
            ["mass ratio", "transmitted", "reflected", "localised", "late change", "changes", "frequency", "law"];
        format!(
            "{}\nShares of the energy of a solitary wave behind an impurity (transmitted), before it (reflected) and in it (localised), at t = 200 + 20 (M - 1)_+; \
             late change: the largest change of a share in the last quarter of the run.\nchanges: number of changes of the sign of the acceleration of the impurity between its neighbours, until one \
             of its contacts opens; law: (f'(G/2) (2/M + 1))^(1/2).\n",
            table(&head, &rows)
        )
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let names = [
            "ratio",
            "transmitted",
            "reflected",
            "localised",
            "late_change",
            "binary",
            "heavy",
            "changes",
            "frequency",
            "frequency_law",
        ];
        let rows = self.rows.iter().map(|row| {
            let [frequency, law] = [row.frequency, row.frequency_law].map(|value| value.unwrap_or(f64::NAN));
            let changes = row.changes as f64;
            let ImpurityRow { ratio, transmitted, reflected, localised, late_change, binary, heavy, .. } = *row;
            vec![ratio, transmitted, reflected, localised, late_change, binary, heavy, changes, frequency, law]
        });
        Ok(named([("impurity.csv", csv(&names, rows)), ("impurity.json", json.into())]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(named([("impurity.png", self.picture()?)]))
    }
}

impl ImpurityStudy {
    /// Shares of the energy, and the frequency, against the mass ratio.
    #[cfg(feature = "plot")]
    fn picture(&self) -> Result<crate::figures::Picture> {
        use crate::figures::{Kind, Line, Panel, Panels, panels};
        let rows = &self.rows;
        let of = |value: &dyn Fn(&ImpurityRow) -> Option<f64>| -> Vec<(f64, f64)> {
            rows.iter().filter_map(|row| Some((row.ratio, value(row)?))).collect()
        };
        let shares = vec![
            Line::new("transmitted", of(&|row| Some(row.transmitted))),
            Line::new("reflected", of(&|row| Some(row.reflected))),
            Line::new("localised", of(&|row| Some(row.localised))),
            Line::new("two collisions", of(&|row| Some(row.binary))),
            Line::new("2p²/(ME)", of(&|row| (row.heavy < 1.0).then_some(row.heavy))),
        ];
        let frequencies = vec![
            Line::new("computed", of(&|row| row.frequency)),
            Line::new("(f′(G/2)(2/M + 1))^(1/2)", of(&|row| row.frequency_law)),
        ];
        let label = "mass ratio M";
        let mut plots = vec![Panel::new(Kind::LogCloud, [label, "share of the energy"], shares)];
        if frequencies.iter().all(|line| !line.points.is_empty()) {
            plots.push(Panel::new(Kind::LogLog, [label, "frequency Ω"], frequencies));
        }
        let late = rows.iter().map(|row| row.late_change).fold(0.0, f64::max);
        let caption = format!(
            "A solitary wave of speed 1 of the plain chain, α = 3/2, without precompression, meets one bead of mass M amid \
             beads of mass 1. Above: energy behind the bead, before it and its own at t = 200 + 20 (M − 1)₊, \
             where none of them changed by more than {late:.0e} in the last quarter of the run; what two collisions of hard beads would pass on; what a heavy bead passes on that was thrown forward with \
             twice the momentum p of the wave of energy E. Below: frequency of the bead between its neighbours until a \
             contact opens, where it has at least {CHANGES} changes of sign of the acceleration, and that of small swings. Integrator {METHOD}, steps of {STEP}, shorter for light beads. hertzchain {}.",
            env!("CARGO_PKG_VERSION")
        );
        Ok(panels(&Panels::column("A solitary wave at an impurity".to_owned(), plots, caption))?)
    }
}
