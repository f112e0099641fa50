//! Damped resonant chains driven at both ends: are there dark breathers (Sec. 8)?
//!
//! | symbol | meaning |
//! |---|---|
//! | `a, omega_d` | amplitude and frequency of the end beads: `a cos(omega_d t)`, and plus or minus that |
//! | `c_b` | first harmonic of the strain of bond `b`, a complex amplitude |
//! | `L, R` | means of `(-1)^b c_b` over the bonds of the left and of the right half |
//! | `B` | background, the smaller of the moduli of `L` and `R` |
//! | `C` | modulus of the mean of `(-1)^b c_b` over the one or two bonds in the middle |
//! | `K_x` | background amplitude of the conservative dark breather of frequency `omega_d` |
//!
//! The background of a dark breather alternates from bond to bond, with opposite signs on the two
//! sides of its kink. `L` and `R` leave out two bonds at each end and the three or four in the
//! middle. An orbit counts as a dark breather if `L` and `R` have opposite phases (cosine below
//! -0.9), `C <= B/10` and `B >= K_x/2`.
//!
//! The reflection of the chain maps a strain to that of the mirrored bond. With ends in antiphase
//! it is a symmetry: the strains of an odd number of bonds have no kink, those of an even number
//! have one about the bead in the middle. With ends in phase it is one together with half a period:
//! an odd number of bonds has a kink about the bond in the middle, an even number has none.

use super::{Progress, Study, Work, branches::stability_lines, format_short, multipliers_panel, options::options};
use crate::{
    breathers::DarkBreather,
    chain::{Boundary, Chain, Details, Drive, DriveKind, Envelope, Harmonic, Params, Signal, State, max_norm},
    dps::Center,
    error::{Error, Result, refuse, require},
    named::named,
    numerics::{largest_by, least_by},
    orbits::{
        BifurcationKind, DriveParameter, DrivenContinuation, DrivenMultiplier, DrivenOrbit, DrivenPoint, DrivenSetting,
        DrivenShooting, DrivenSpectrum, End, Shooting,
    },
    report::{
        Column,
        Digits::{Fixed, Hidden, Json, Short},
        Kind, Line, Panel, Panels, Report, Table, fields,
    },
    sweep::{Engine, Grid},
};
use nalgebra::Complex;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::f64::consts::{FRAC_PI_2, PI};

/// Bonds at each end that are left out of the background.
const ENDS: usize = 2;
/// Sites of the ring of the conservative breather that gives `K_x`.
const RING: usize = 21;
/// Periods that the chain runs before its first orbit is sought.
const SETTLE: u32 = 400;
/// Ramps of runs from rest, in periods, and the periods that a run takes after its ramp.
const RAMPS: [u32; 2] = [20, 800];
const AFTER_RAMP: u32 = 4000;
/// Largest number of orbits of a branch for which runs from rest are made: those with the strongest
/// background.
const MOST_TRIED: usize = 4;
/// Distance from an orbit, in units of its largest unknown, at which a run has reached it.
const REACHED: f64 = 1e-3;

options! {
    /// Damped resonant chains driven at both ends.
    pub struct EndDriven {
        /// Numbers of sites, ends included.
        ///
        /// Separated by commas. A chain with an even number has a kink about a bond
        /// if its ends move in phase; one with an odd number has a kink about a bead if they move
        /// in antiphase.
        lengths: Vec<usize> = vec![10, 11], "N,..", (10 to 60);
        /// Drive frequencies.
        ///
        /// Separated by commas, in radians per unit of time; above omega = sqrt(1 + 1/rho).
        omegas: Vec<f64> = vec![2.03, 2.05], "W,..";
        /// Mass ratio resonator to bead.
        rho: f64 = 1.0 / 3.0, "R", (positive);
        /// Drag on beads: force per velocity of a bead.
        drag: f64 = 0.01, "C", (from 0);
        /// Dashpots beside the springs of resonators: force per relative velocity.
        dashpot: f64 = 0.001, "D", (from 0);
        /// Largest drive amplitude.
        ///
        /// The displacement amplitude of the end beads at which a branch ends.
        to: f64 = 0.2, "A", (positive);
        /// Largest change of the drive amplitude from point to point.
        step: f64 = 0.01, "DA", (positive);
        /// Points of the branch at most.
        max_points: usize = 30, "N", (2 to 10_000);
    }
}

named! {
    /// How the ends move.
    pub enum Ends {
        /// Both `a cos(omega_d t)`.
        InPhase = "in-phase", "in phase";
        /// `a cos(omega_d t)` and `-a cos(omega_d t)`.
        Antiphase = "antiphase", "antiphase";
    }
    /// In words.
    pub fn words
}

/// A point of a branch, with the background and the kink of its strains.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EndDrivenPoint {
    /// Drive amplitude.
    pub amplitude: f64,
    /// Multipliers of the orbit.
    pub spectrum: DrivenSpectrum,
    /// Residual of the orbit.
    pub residual: f64,
    /// Displacements of the beads at the start of a period.
    pub u: Vec<f64>,
    /// Background amplitude `B`.
    pub background: f64,
    /// Cosine of the angle between `L` and `R`.
    pub cosine: f64,
    /// Amplitude `C` in the middle.
    pub centre: f64,
    /// Real and imaginary part of `c_b`, bond by bond, from the left, turned by the phase of `L`: a
    /// bond is in phase with the left half if `(-1)^b c_b` is real and positive.
    pub harmonics: Vec<[f64; 2]>,
}

/// A bifurcation of a branch: its kind, the drive amplitude, and the multiplier that crosses the
/// unit circle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EndDrivenBifurcation {
    kind: BifurcationKind,
    parameter: f64,
    multiplier: DrivenMultiplier,
}

/// A branch of orbits in the drive amplitude, for one length, one motion of the ends and one
/// frequency.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EndDrivenCase {
    /// Number of sites.
    pub sites: usize,
    /// How the ends move.
    pub ends: Ends,
    /// Frequency of the drive.
    pub omega: f64,
    /// `K_x` of the conservative dark breather of this frequency.
    pub free: f64,
    /// The points, in their order along the branch.
    pub points: Vec<EndDrivenPoint>,
    /// Bifurcations between them.
    pub bifurcations: Vec<EndDrivenBifurcation>,
    /// Why the branch ended; `None` if the chain did not settle to a first orbit.
    pub end: Option<End>,
    /// Index of the stable dark breather with the strongest background.
    pub best: Option<usize>,
    /// Runs from rest to stable dark breathers, the strongest background first.
    pub from_rest: Vec<FromRest>,
}

/// Whether a chain at rest comes to an orbit when its drive is switched on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FromRest {
    /// Drive amplitude.
    pub amplitude: f64,
    /// The ramp that leads to the orbit, in periods; the shortest of 20 and 800. `None`: neither.
    pub ramp: Option<u32>,
}

/// The outcome of the study.
#[derive(Clone, Debug)]
pub struct EndDrivenStudy {
    /// The options.
    pub options: EndDriven,
    /// The branches, ordered by length, then by the motion of the ends, then by frequency.
    pub cases: Vec<EndDrivenCase>,
}

impl Study for EndDriven {
    const STORE: &'static str = "end-driven.store";

    fn outline() -> Option<Report> {
        let [branches, points] = tables(&[]);
        Some(Report::new("end-driven").table(branches).table(points))
    }

    fn begin(&self) -> Result<Work<'_>> {
        self.check()?;
        Ok(Box::new(|engine, progress| Ok(self.study(engine, progress)?.report())))
    }
}

impl Ends {
    /// The sign of the right end.
    fn sign(self) -> f64 {
        if self == Self::InPhase { 1.0 } else { -1.0 }
    }
}

impl EndDrivenPoint {
    /// Whether the background alternates, with a kink in the middle.
    pub fn kinked(&self) -> bool {
        self.cosine <= -0.9 && self.centre <= 0.1 * self.background
    }

    /// Whether it counts as a dark breather, where `free` is the background amplitude `K_x` of the
    /// conservative one.
    pub fn dark(&self, free: f64) -> bool {
        self.kinked() && self.background >= 0.5 * free
    }

    /// Measures the background and the kink in the strains of an orbit.
    ///
    /// # Errors
    /// An integration that fails.
    pub fn measured(DrivenPoint { orbit, spectrum, .. }: &DrivenPoint) -> Result<Self> {
        let samples = orbit.samples(&DrivenShooting::default())?;
        let n = samples.first().map_or(0, |_| orbit.setting.sites());
        let staggered: Vec<Complex<f64>> = (1..n)
            .map(|b| {
                let sign = if b % 2 == 0 { 1.0 } else { -1.0 };
                first_harmonic(samples[1..].iter().map(|state| state[b] - state[b - 1])) * sign
            })
            .collect();
        let bonds = staggered.len();
        let mean = |range: std::ops::Range<usize>| {
            let count = range.len() as f64;
            staggered[range].iter().sum::<Complex<f64>>() / count
        };
        // The middle is one bond of an odd number, or two of an even one. `L` and `R` also leave
        // out the bond on either side of it.
        let (low, high) = ((bonds - 1) / 2, bonds / 2 + 1);
        let (left, right) = (mean(ENDS..low - 1), mean(high + 1..bonds - ENDS));
        let cosine = (left * right.conj()).re / (left.norm() * right.norm()).max(f64::MIN_POSITIVE);
        let turn = (left / left.norm().max(f64::MIN_POSITIVE)).conj();
        let sign = |b: usize| if b.is_multiple_of(2) { -1.0 } else { 1.0 };
        let turned = staggered.iter().enumerate().map(|(b, c)| c * turn * sign(b));
        Ok(Self {
            amplitude: orbit.setting.get(DriveParameter::Amplitude),
            spectrum: spectrum.clone(),
            residual: orbit.residual,
            u: orbit.start()?.u().to_vec(),
            background: left.norm().min(right.norm()),
            cosine,
            centre: mean(low..high).norm(),
            harmonics: turned.map(|c| [c.re, c.im]).collect(),
        })
    }

    /// Whether no multiplier is outside the unit circle.
    pub fn stable(&self) -> bool {
        self.spectrum.unstable() == 0
    }
}

/// The amplitude of the first harmonic of equal samples of a period.
fn first_harmonic(samples: impl ExactSizeIterator<Item = f64>) -> Complex<f64> {
    let count = samples.len() as f64;
    let turned = samples.enumerate().map(|(k, x)| Complex::from_polar(x, -2.0 * PI * (k + 1) as f64 / count));
    turned.sum::<Complex<f64>>() * (2.0 / count)
}

impl EndDriven {
    fn check(&self) -> Result<()> {
        self.within_ranges()?;
        let least = Params::new(1.5, 1.0, self.rho)?.omega();
        let odd = self.omegas.iter().find(|omega| !(omega.is_finite() && **omega > least));
        refuse("omegas", odd, "finite, and above sqrt(1 + 1/rho)")?;
        require(self.drag + self.dashpot > 0.0, "drag", 0, "a chain without drag has a dashpot")?;
        require(self.step < self.to, "step", self.step, "below the largest amplitude, --to")
    }

    /// The chain.
    ///
    /// # Errors
    /// Numbers outside their rules.
    pub fn chain(&self, sites: usize, ends: Ends, omega: f64, amplitude: f64, ramp: f64) -> Result<Chain<f64>> {
        let inner = |value: f64| (0..sites).map(|i| if i == 0 || i + 1 == sites { 0.0 } else { value }).collect();
        let envelope = if ramp > 0.0 { Envelope::Ramp(ramp) } else { Envelope::None };
        let drive = |site: usize, amplitude: f64| Drive {
            site,
            kind: DriveKind::Displacement,
            signal: Signal::new(vec![Harmonic { amplitude, omega, phase: FRAC_PI_2 }], envelope),
        };
        let details = Details {
            rho: inner(self.rho),
            drag: inner(self.drag),
            dashpot: inner(self.dashpot),
            drives: vec![drive(0, amplitude), drive(sites - 1, ends.sign() * amplitude)],
            ..Details::default()
        };
        Chain::new(Params::new(1.5, 1.0, self.rho)?, Boundary::Free, sites)?.with(&details)
    }

    fn study(&self, engine: &Engine, progress: Progress<'_>) -> Result<EndDrivenStudy> {
        let mut cases = Vec::new();
        for &sites in &self.lengths {
            for ends in [Ends::InPhase, Ends::Antiphase] {
                cases.extend(self.omegas.iter().map(|&omega| (sites, ends, omega)));
            }
        }
        let settings = fields!(self => rho, drag, dashpot, to, step, max_points);
        let grid = Grid { store: Self::STORE, study: "end-driven", settings };
        let swept = engine.sweep(&grid, &cases, progress, |&(sites, ends, omega)| self.case(sites, ends, omega))?;
        let found =
            swept.values(&cases, |(sites, ends, omega)| format!("N = {sites}, {}, omega = {omega}", ends.words()))?;
        Ok(EndDrivenStudy { options: self.clone(), cases: found.into_iter().map(|(_, case)| case).collect() })
    }

    /// `K_x` of the conservative breather of this frequency.
    fn free(&self, omega: f64) -> Result<f64> {
        let params = Params::new(1.5, 1.0, self.rho)?;
        let breather = DarkBreather { params, center: Center::Site, sites: RING, omega_b: omega, c_x: 0.0 };
        let shooting = Shooting::default();
        Ok(breather.orbit(&shooting)?.extent(shooting.tol)?.k_x)
    }

    /// The branch of one case.
    ///
    /// # Errors
    /// Numbers outside their rules; an integration that fails; a signal.
    pub fn case(&self, sites: usize, ends: Ends, omega: f64) -> Result<EndDrivenCase> {
        let (shooting, free) = (DrivenShooting::default(), self.free(omega)?);
        let chain = self.chain(sites, ends, omega, self.step, 0.0)?;
        let setting = DrivenSetting::new(&chain, 1)?;
        let mut case = EndDrivenCase {
            sites,
            ends,
            omega,
            free,
            points: Vec::new(),
            bifurcations: Vec::new(),
            end: None,
            best: None,
            from_rest: Vec::new(),
        };
        let rest = State::rest(&chain).driven(&chain);
        let seed = shooting.settle(&setting, &chain, &rest, SETTLE, |_| {})?;
        let start = match shooting.solve(&setting, &seed) {
            Ok(orbit) => orbit,
            Err(Error::Stalled { .. }) => return Ok(case),
            Err(error) => return Err(error),
        };
        let continuation = DrivenContinuation {
            parameter: DriveParameter::Amplitude,
            to: self.to,
            step: self.step,
            most_points: self.max_points,
            shooting,
        };
        let branch = continuation.follow(start, |_| {})?;
        case.end = Some(branch.ended());
        case.points = branch.points.iter().map(EndDrivenPoint::measured).collect::<Result<_>>()?;
        let told = branch.bifurcations.iter().map(|one| EndDrivenBifurcation {
            kind: one.kind,
            parameter: one.parameter,
            multiplier: one.critical.multiplier,
        });
        case.bifurcations = told.collect();
        let stable = |k: &usize| case.points[*k].dark(free) && case.points[*k].stable();
        let mut candidates: Vec<usize> = (0..case.points.len()).filter(stable).collect();
        candidates.sort_by(|&a, &b| case.points[b].background.total_cmp(&case.points[a].background));
        case.best = candidates.first().copied();
        let tried = candidates.iter().take(MOST_TRIED);
        case.from_rest =
            tried.map(|&k| self.reached_from_rest(&case, &branch.points[k].orbit)).collect::<Result<_>>()?;
        Ok(case)
    }

    /// Whether a chain at rest comes to an orbit.
    fn reached_from_rest(&self, case: &EndDrivenCase, orbit: &DrivenOrbit) -> Result<FromRest> {
        let amplitude = orbit.setting.get(DriveParameter::Amplitude);
        let size = max_norm(orbit.z.iter().copied());
        let reaches = |ramp: u32| -> Result<bool> {
            let length = f64::from(ramp) * orbit.setting.period();
            let chain = self.chain(case.sites, case.ends, case.omega, amplitude, length)?;
            let state = State::rest(&chain).driven(&chain);
            let z = DrivenShooting::default().settle(&orbit.setting, &chain, &state, AFTER_RAMP, |_| {})?;
            Ok(z.iter().zip(&orbit.z).all(|(a, b)| (a - b).abs() <= REACHED * size))
        };
        for ramp in RAMPS {
            if reaches(ramp)? {
                return Ok(FromRest { amplitude, ramp: Some(ramp) });
            }
        }
        Ok(FromRest { amplitude, ramp: None })
    }
}

impl EndDrivenCase {
    /// The points at which orbits begin to be dark breathers: the first, and the first stable one.
    pub fn first(&self) -> [Option<&EndDrivenPoint>; 2] {
        let dark = |one: &&EndDrivenPoint| one.dark(self.free);
        [self.points.iter().find(dark), self.points.iter().find(|one| dark(one) && one.stable())]
    }

    /// Of its stable dark breathers, the one with the strongest background.
    fn best(&self) -> Option<&EndDrivenPoint> {
        Some(&self.points[self.best?])
    }
}

/// The ranges of the search, in words.
fn searched(options: &EndDriven) -> String {
    format!(
        "α = 3/2, κ = 1, ρ = {}, drag {}, dashpot {}; N in {:?}; ω_d in {:?}; a from {} to {}, at most {} points a branch",
        format_short(options.rho),
        options.drag,
        options.dashpot,
        options.lengths,
        options.omegas,
        options.step,
        options.to,
        options.max_points
    )
}

impl EndDrivenStudy {
    /// The answer of the search, in a sentence.
    pub fn answer(&self) -> String {
        let dark = self.cases.iter().filter(|case| case.first()[0].is_some()).count();
        let stable: Vec<&EndDrivenCase> = self.cases.iter().filter(|case| case.best.is_some()).collect();
        let least = stable.iter().filter_map(|case| {
            let one = case.first()[1]?;
            Some((one.amplitude, *case))
        });
        let all = self.cases.len();
        match least_by(least, |one| one.0) {
            Some((a, case)) => format!(
                "Dark breathers on {dark} of {all} branches, stable ones on {}; the least drive amplitude of a stable one is {a:.4} \
                 (N = {}, ends {}, ω_d = {}).",
                stable.len(),
                case.sites,
                case.ends.words(),
                case.omega
            ),
            None if dark > 0 => format!("Dark breathers on {dark} of {all} branches, none of them stable."),
            None => format!("No dark breather on {all} branches."),
        }
    }

    /// The report.
    pub fn report(&self) -> Report {
        let (options, [branches, points]) = (&self.options, tables(&self.cases));
        let about = format!(
            "Searched: {}. Dark: the background alternates with a kink in the middle, and B >= K_x/2.",
            searched(options)
        );
        Report::new("end-driven")
            .fact("alpha", 1.5)
            .fact("kappa", 1.0)
            .facts(fields!(options => rho, drag, dashpot))
            .fact("from", options.step)
            .facts(fields!(options => to, step, max_points))
            .fact("settle", SETTLE)
            .fact("ramps", RAMPS)
            .fact("after_ramp", AFTER_RAMP)
            .fact("ring", RING)
            .fact("integrator", "dop853-regularised")
            .fact("answer", self.answer())
            .table(branches)
            .table(points)
            .words(self.answer())
            .words(about)
            .picture(self.picture())
    }

    /// For each length and way to drive it that has kinks: the background against the drive
    /// amplitude; then the best stable breather, its strains and multipliers.
    fn picture(&self) -> Panels {
        let relative = |case: &EndDrivenCase, one: &EndDrivenPoint| (one.amplitude, one.background / case.free);
        let mut branches = Vec::new();
        for &sites in &self.options.lengths {
            let kinked: Vec<(&EndDrivenCase, &EndDrivenPoint)> = self
                .cases
                .iter()
                .filter(|case| case.sites == sites)
                .flat_map(|case| case.points.iter().filter(|one| one.kinked()).map(move |one| (case, one)))
                .collect();
            if kinked.is_empty() {
                continue;
            }
            let of = |omega: &f64| {
                let its: Vec<_> = kinked.iter().filter(|(case, _)| case.omega == *omega).copied().collect();
                let mut lines = stability_lines(&its, |(case, one)| relative(case, one), |(_, one)| Some(one.stable()));
                lines.iter_mut().for_each(|line| line.name = format!("ω_d = {omega}, {}", line.name));
                lines
            };
            let lines = self.options.omegas.iter().flat_map(of).filter(|line| !line.points.is_empty()).collect();
            let panel = Panel::new(Kind::Cloud, ["drive amplitude a", "background B/Kₓ"], lines);
            branches.push(Panel { title: format!("N = {sites}"), ..panel });
        }
        let strongest = self.cases.iter().filter_map(|case| Some((case, case.best()?)));
        let strongest = largest_by(strongest, |(case, one)| one.background / case.free);
        let mut columns = vec![Column::new("", branches)];
        let mut best = String::new();
        if let Some((case, one)) = strongest {
            let strains = one.harmonics.iter().enumerate().map(|(b, c)| ((b + 1) as f64, c[0]));
            let lines = vec![Line::new("part in phase with the left half", strains)];
            let profile = Panel::new(Kind::Sites, ["bond n", "first harmonic of the strain"], lines);
            columns.push(Column::new("", [profile, multipliers_panel(&one.spectrum)]));
            best = format!(
                " Right: the stable one with the largest B/Kₓ = {:.3}: N = {}, ends {}, ω_d = {}, a = {:.4}.",
                one.background / case.free,
                case.sites,
                case.ends.words(),
                case.omega,
                one.amplitude
            );
        }
        let caption = format!(
            "Left: background B of the orbits with a kink in the middle, over Kₓ of the conservative dark breather of the same \
             frequency.{best} Searched: {}.",
            searched(&self.options)
        );
        Panels { title: "Chains driven at both ends".to_owned(), columns, caption }
    }
}

fn tables(cases: &[EndDrivenCase]) -> [Table; 2] {
    let first = |k: usize| move |case: &EndDrivenCase| case.first()[k].map(|one| one.amplitude);
    let rest = |case: &EndDrivenCase| {
        let reached = case.from_rest.iter().filter(|run| run.ramp.is_some()).count();
        (!case.from_rest.is_empty()).then(|| format!("{reached} of {}", case.from_rest.len()))
    };
    let branches = Table::of("end-driven-branches", cases)
        .key("cases")
        .col("sites", Short, "", |case| case.sites)
        .head("N")
        .col("ends", Short, "how they move", |case| case.ends.name())
        .col("omega", Short, "frequency of the drive", |case| case.omega)
        .col("orbits", Short, "points of the branch", |case| case.points.len())
        .col("first_dark", Fixed(4), "least drive amplitude of a dark breather", first(0))
        .col("first_stable_dark", Fixed(4), "of a stable one", first(1))
        .col("best_amplitude", Fixed(4), "of the stable one with the largest background B", |case| {
            case.best().map(|one| one.amplitude)
        })
        .col(
            "best_share",
            Fixed(3),
            "its B over K_x, that of the conservative breather of the same frequency",
            |case| case.best().map(|one| one.background / case.free),
        )
        .head("B/K_x")
        .col(
            "reached",
            Short,
            "stable ones with the strongest background that a chain at rest comes to by a ramp",
            rest,
        )
        .head("from rest")
        .col("k_x", Hidden, "K_x", |case| case.free)
        .col("end", Json, "", |case| json!(case.end))
        .col("best", Json, "", best)
        .col("from_rest", Json, "", |case| json!(case.from_rest))
        .col("points", Json, "", |case| Value::from(points(&of(case)).json()))
        .col("bifurcations", Json, "", |case| json!(case.bifurcations));
    [branches.done(), points(&cases.iter().flat_map(of).collect::<Vec<_>>())]
}

/// A branch beside each of its points.
fn of(case: &EndDrivenCase) -> Vec<(&EndDrivenCase, &EndDrivenPoint)> {
    case.points.iter().map(|one| (case, one)).collect()
}

fn points(rows: &[(&EndDrivenCase, &EndDrivenPoint)]) -> Table {
    Table::of("end-driven", rows)
        .key("")
        .col("sites", Hidden, "", |(case, _)| case.sites)
        .col("ends", Hidden, "1 in phase, -1 in antiphase", |(case, _)| case.ends.sign())
        .col("omega", Hidden, "frequency of the drive", |(case, _)| case.omega)
        .col("amplitude", Hidden, "of the ends", |(_, one)| one.amplitude)
        .col("background", Hidden, "B", |(_, one)| one.background)
        .col("k_x", Hidden, "B of the conservative breather", |(case, _)| case.free)
        .col("cosine", Hidden, "of the angle between the backgrounds of the two halves", |(_, one)| one.cosine)
        .col("centre", Hidden, "amplitude in the middle", |(_, one)| one.centre)
        .col("dark", Hidden, "whether it is a dark breather", |(case, one)| one.dark(case.free))
        .col("max_modulus", Hidden, "largest modulus of a multiplier", |(_, one)| one.spectrum.largest())
        .col("unstable", Hidden, "multipliers outside the unit circle", |(_, one)| one.spectrum.unstable())
        .col("residual", Hidden, "of the orbit", |(_, one)| one.residual)
        .done()
}

/// The stable dark breather with the strongest background, with its state.
fn best(case: &EndDrivenCase) -> Value {
    let Some(one) = case.best() else { return Value::Null };
    let mut value = points(&[(case, one)]).json().remove(0);
    value["u"] = json!(one.u);
    value["harmonics"] = one.harmonics.iter().map(|[re, im]| json!({ "re": re, "im": im })).collect();
    value["multipliers"] = json!(one.spectrum.multipliers);
    value
}
