//! The Peierls-Nabarro barrier of dark breathers (Sec. 8): energies of the two kinds against their
//! common background.
//!
//! | symbol | meaning |
//! |---|---|
//! | `E, J` | energy; action `(1/2 pi) oint sum p dq = (1/pi) int K dt` of the kinetic energy `K` |
//! | `X, F` | length `sum x_n`, 0 for beads that just touch, conserved; mean contact force |
//! | `e, j, l` | energy, action and length of the background, for each site |
//!
//! The energy of a kink is that of the ring less `N e`; action and length likewise. Along each
//! family `dE = omega_b dJ - F dX`, since `F` is the force with which contacts push against the
//! length. If a kink is exchanged for one of the other kind at the same action and length, a long
//! background takes up the differences `dJ` and `dX` of the kinks, with the same `omega_b` and `F`
//! for both kinks. So in the limit of a long ring the energies at the same action and length differ
//! by the difference of `E - omega_b J + F X` at the same frequency.

use crate::study::{
    ChainParams, Progress, Study, Work,
    options::options,
    orbits::conservative::{ONE, Ring},
    params_words,
};
use crate::{
    chain::{Energy, Params},
    dps::Center,
    error::{Error, NOTHING, Result, require},
    number::{format_parameter, format_short},
    orbits::{Orbit, Setting, Shooting},
    report::{self, Column, Fixed, Hidden, Json, Line, Panel, Panels, Power, Report, Table, fields},
    sweep::{Engine, Grid},
};
use hertzchain_integrators::{Tolerance, collocation::StepControl};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::f64::consts::PI;

/// Default range of frequencies, in units of `omega`.
const RANGE: [f64; 2] = [1.005, 1.05];
/// Intervals of half a period in the trapezoidal sum for the action. The kinetic energy has the
/// period of the orbit, so the sum converges like a power of their number; at 256 they change no
/// digit beyond 1e-12.
const PARTS: usize = 256;
/// Sites of a ring of pure background.
const BACKGROUND: usize = 4;

options! {
    /// The energy barrier between site- and bond-centred dark breathers.
    pub struct Barrier {
        /// Smallest frequency of the breathers [default: 1.005 omega].
        ///
        /// In radians per unit of time, above omega = sqrt(kappa (1 + 1/rho)).
        from: Option<f64> = None, "P";
        /// Largest frequency of the breathers [default: 1.05 omega].
        ///
        /// In radians per unit of time, above --from.
        to: Option<f64> = None, "P";
        /// Number of frequencies, equally spaced.
        frequencies: usize = 19, "N", (2 or more);
        /// The ring.
        ring: Ring = Ring::default();
    }
}

/// A kink about a site or about a bond.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CenteredKink {
    /// The orbit.
    pub orbit: Orbit,
    /// Energy of the ring.
    pub energy: f64,
    /// Action of the ring.
    pub action: f64,
    /// Length of the ring.
    pub length: f64,
    /// Energy less that of the background.
    pub kink_energy: f64,
    /// Action less that of the background.
    pub kink_action: f64,
    /// Length less that of the background.
    pub kink_length: f64,
    /// Largest real multiplier above 1; 1 if there is none.
    pub real: f64,
    /// Largest modulus of any multiplier.
    pub largest: f64,
}

/// The kinks of both kinds at one frequency.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BarrierPoint {
    /// Frequency.
    pub omega_b: f64,
    /// Energy, action and length of the background per site, and its mean contact force.
    pub background: Invariants,
    /// The kink about a site, then the one about a bond.
    pub kinks: [CenteredKink; 2],
}

impl BarrierPoint {
    /// Energy about a bond less that about a site, at the same frequency.
    pub fn at_frequency(&self) -> f64 {
        let [site, bond] = &self.kinks;
        bond.energy - site.energy
    }

    /// Energy about a bond less that about a site, at the same action and length, in the limit of a
    /// long ring.
    pub fn barrier(&self) -> f64 {
        let [site, bond] = &self.kinks;
        let (action, length) = (bond.action - site.action, bond.length - site.length);
        self.at_frequency() - self.omega_b * action + self.background.force * length
    }
}

/// The barrier over frequencies.
#[derive(Clone, Debug)]
pub struct BarrierStudy {
    /// The options.
    pub options: Barrier,
    /// The points at which both orbits were found, by increasing frequency.
    pub points: Vec<BarrierPoint>,
    /// Frequencies at which an orbit was not found.
    pub missing: Vec<f64>,
}

impl Study for Barrier {
    const STORE: &'static str = "barrier.store";

    fn outline() -> Option<Report> {
        Some(Report::new("barrier").table(table(&[])))
    }

    fn begin(&self) -> Result<Work<'_>> {
        self.frequencies()?;
        Ok(Box::new(|engine, progress| Ok(self.study(engine, progress)?.report())))
    }
}

impl Barrier {
    /// The barrier with the defaults of the command, at another mass ratio.
    pub fn of(rho: f64, [from, to]: [f64; 2], frequencies: usize) -> Self {
        let params = ChainParams { rho, ..ChainParams::default() };
        Self { from: Some(from), to: Some(to), frequencies, ring: Ring { params, ..Ring::default() } }
    }

    fn frequencies(&self) -> Result<Vec<f64>> {
        let omega = self.ring.breather(Center::Site, None, ONE)?.params.omega();
        let ChainParams { rho, .. } = self.ring.params;
        require(rho > 0.0, "rho", rho, "the barrier is that of chains with resonators")?;
        let given = self.from.is_some() && self.to.is_some();
        require(
            self.ring.precompression <= 0.0 || given,
            "--from",
            NOTHING,
            "under a precompression a range needs --from and --to",
        )?;
        let [from, to] = [self.from.unwrap_or(RANGE[0] * omega), self.to.unwrap_or(RANGE[1] * omega)];
        self.within_ranges()?;
        for (name, value) in [("from", from), ("to", to)] {
            let told = format!("{value}, where omega = {omega}");
            let above = value.is_finite() && value > omega;
            require(above, name, told, "a dark breather has a finite frequency above omega")?;
        }
        require(from < to, "to", to, "above --from")?;
        Tolerance::RUN.check(self.ring.tol)?;
        // The seed of the first breather checks the parameters of the ring.
        self.ring.breather(Center::Site, Some(from), ONE)?.seed()?;
        let step = (to - from) / (self.frequencies - 1) as f64;
        Ok((0..self.frequencies).map(|k| from + step * k as f64).collect())
    }

    /// The barrier; after a signal, at the frequencies that were computed.
    ///
    /// # Errors
    /// Numbers outside their rules; an integration that fails; errors of the store.
    pub fn study(&self, engine: &Engine, progress: Progress<'_>) -> Result<BarrierStudy> {
        let (frequencies, shooting) = (self.frequencies()?, self.ring.shooting());
        let Ring { sites, params: ChainParams { alpha, kappa, rho }, .. } = self.ring;
        let settings = json!({"sites": sites, "alpha": alpha, "kappa": kappa, "rho": rho, "c_x": self.ring.c_x(),
            "search": shooting});
        let grid = Grid { store: Self::STORE, study: "barrier", settings };
        let point = |&omega_b: &f64| match self.point(omega_b, &shooting) {
            Err(Error::Stalled { .. }) => Ok(None),
            found => found.map(Some),
        };
        let swept = engine.sweep(&grid, &frequencies, progress, point)?;
        let (mut points, mut missing) = (Vec::new(), Vec::new());
        for (omega_b, found) in swept.values(&frequencies, |omega_b| format!("omega_b = {omega_b}"))? {
            match found {
                Some(point) => points.push(point),
                None => missing.push(*omega_b),
            }
        }
        Ok(BarrierStudy { options: self.clone(), points, missing })
    }

    fn point(&self, omega_b: f64, shooting: &Shooting) -> Result<BarrierPoint> {
        let orbit = |center| self.ring.breather(center, Some(omega_b), ONE)?.orbit(shooting);
        let [site, bond] = [orbit(Center::Site)?, orbit(Center::Bond)?];
        let background = background(&site, shooting)?;
        let kink = |orbit: Orbit| -> Result<CenteredKink> {
            let Invariants { energy, action, length, .. } = Invariants::of(&orbit, shooting)?;
            let spectrum = orbit.spectrum(shooting)?;
            let sites = orbit.setting.sites as f64;
            Ok(CenteredKink {
                kink_energy: energy - sites * background.energy,
                kink_action: action - sites * background.action,
                kink_length: length - sites * background.length,
                real: spectrum.largest_real(),
                largest: spectrum.largest(),
                energy,
                action,
                length,
                orbit,
            })
        };
        Ok(BarrierPoint { omega_b, background, kinks: [kink(site)?, kink(bond)?] })
    }
}

/// Energy, action, length and mean contact force of an orbit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Invariants {
    /// Energy `E`.
    pub energy: f64,
    /// Action `J`.
    pub action: f64,
    /// Length `X`.
    pub length: f64,
    /// Mean contact force `F`.
    pub force: f64,
}

impl Invariants {
    /// The invariants of an orbit that starts at rest.
    ///
    /// # Errors
    /// An integration that fails.
    pub fn of(orbit: &Orbit, shooting: &Shooting) -> Result<Self> {
        let (chain, period) = (orbit.setting.chain()?, orbit.setting.period());
        let times: Vec<f64> = (0..=PARTS).map(|k| 0.5 * period * k as f64 / PARTS as f64).collect();
        let kinetic = |state: &Vec<f64>| {
            let Energy { beads, resonators, .. } = chain.energy(state);
            beads + resonators
        };
        // The second half of the period repeats the first one backwards; velocities vanish at both
        // ends.
        let sum: f64 = orbit.states(shooting.tol, &times)?.iter().map(kinetic).sum();
        let start = orbit.start();
        Ok(Self {
            energy: chain.energy(&start).total(),
            action: sum * period / (PI * PARTS as f64),
            length: orbit.x().iter().sum(),
            force: chain.mean_contact_forces(&start, period, StepControl::Tolerance(shooting.tol))?.mean(),
        })
    }
}

/// The background of a breather, per site: the orbit of a short ring, sought from the strains of
/// the breather's first site with alternating signs about the centre `c_x`.
fn background(breather: &Orbit, shooting: &Shooting) -> Result<Invariants> {
    let (x, y, c_x) = (breather.x()[0], breather.y()[0], breather.setting.c_x);
    let alternating = |value: f64| (0..BACKGROUND).map(move |n| if n % 2 == 0 { value } else { 2.0 * c_x - value });
    let seed: Vec<f64> = alternating(x).chain(alternating(y)).collect();
    let setting = Setting { sites: BACKGROUND, ..breather.setting };
    let whole = Invariants::of(&shooting.solve(&setting, &seed)?, shooting)?;
    let share = |value: f64| value / BACKGROUND as f64;
    let (energy, action, length) = (share(whole.energy), share(whole.action), share(whole.length));
    Ok(Invariants { energy, action, length, force: whole.force })
}

impl BarrierStudy {
    /// Frequencies at which a difference changes its sign, interpolated linearly between
    /// neighbouring points.
    pub fn zeros(&self, of: fn(&BarrierPoint) -> f64) -> Vec<f64> {
        let change = |pair: &[BarrierPoint]| {
            let [a, b] = [&pair[0], &pair[1]];
            let [left, right] = [of(a), of(b)];
            (left * right < 0.0).then(|| a.omega_b + (b.omega_b - a.omega_b) * left / (left - right))
        };
        self.points.windows(2).filter_map(change).collect()
    }

    fn words(&self) -> String {
        let say = |what: &str, zeros: Vec<f64>| {
            let places: Vec<String> = zeros.iter().map(|zero| format!("ω_b = {zero:.5}")).collect();
            let places = if places.is_empty() { "no frequency".to_owned() } else { places.join(", ") };
            format!("At the same {what} the difference changes its sign at {places}.")
        };
        let [one, other] = [BarrierPoint::at_frequency, BarrierPoint::barrier].map(|of| self.zeros(of));
        format!("{} {}", say("frequency", one), say("action and length", other))
    }

    /// The report.
    pub fn report(&self) -> Report {
        let (ring, params) = (&self.options.ring, self.options.ring.params);
        let lost: Vec<String> = self.missing.iter().map(|omega_b| format_short(*omega_b)).collect();
        let zeros = json!({
            "at_frequency": self.zeros(BarrierPoint::at_frequency),
            "at_action_and_length": self.zeros(BarrierPoint::barrier),
        });
        let title = "Peierls–Nabarro barrier of dark breathers";
        let picture = Panels { title: title.to_owned(), columns: vec![self.column()], caption: self.caption() };
        Report::new("barrier")
            .facts(Params::from(params))
            .facts(fields!(ring => sites, c_x()))
            .table(table(&self.points))
            .words(self.caption())
            .fact("sign_changes", zeros)
            .fact("missing", &self.missing)
            .picture(picture)
            .failure(
                (!lost.is_empty()).then(|| format!("no pair of orbits was found at omega_b = {}", lost.join(", "))),
            )
    }

    /// What the picture shows, with all numbers.
    fn caption(&self) -> String {
        let ring = &self.options.ring;
        let ends = [self.points.first(), self.points.last()].map(|point| {
            point.map_or(String::new(), |point| {
                format!("{} at ω_b = {}", format_short(point.barrier()), format_short(point.omega_b)).replace('-', "−")
            })
        });
        format!(
            "{}, N = {}. Energies of kinks over the energy e of the background per site; differences over the energy of the \
             site-centred kink. Energy of the bond-centred breather minus that of the site-centred one, at the same action and \
             length {} and {}. {}",
            params_words(ring.params.into()),
            ring.sites,
            ends[0],
            ends[1],
            self.words()
        )
    }

    /// Panels against frequency: energies of the kinks over the background's energy per site, their
    /// differences over the energy of the kink about a site, and largest multipliers.
    fn column(&self) -> Column {
        let table = table(&self.points);
        let share = |name: &str, of: fn(&BarrierPoint) -> f64, over: fn(&BarrierPoint) -> f64| {
            Line::new(name, self.points.iter().map(|point| (point.omega_b, of(point) / over(point))))
        };
        let background = |point: &BarrierPoint| point.background.energy;
        let energies = vec![
            share("site", |point| point.kinks[0].kink_energy, background),
            share("bond", |point| point.kinks[1].kink_energy, background),
        ];
        let kink = |point: &BarrierPoint| point.kinks[0].kink_energy.abs();
        let differences = vec![
            share("same frequency", BarrierPoint::at_frequency, kink),
            share("same action and length", BarrierPoint::barrier, kink),
        ];
        let moduli = [
            ("site, any", "site.largest"),
            ("bond, any", "bond.largest"),
            ("site, positive real", "site.real"),
            ("bond, positive real", "bond.real"),
        ];
        let (linear, logarithmic) = (report::Kind::Parameter, report::Kind::LogParameter);
        Column::new(
            format!("ρ = {}", format_parameter(self.options.ring.params.rho)),
            [
                Panel::new(linear, ["ω_b", "kink energy / e"], energies),
                Panel::new(logarithmic, ["ω_b", "(bond − site) / |kink|"], differences),
                table.panel(linear, ["ω_b", "largest |λ|"], "omega_b", &moduli),
            ],
        )
    }
}

/// A row for each frequency.
fn table(points: &[BarrierPoint]) -> Table {
    let mut table = Table::of("barrier", points)
        .key("points")
        .col("omega_b", Fixed(6), "", |point| point.omega_b)
        .col("background.energy", Hidden, "energy of the background, per site", |point| point.background.energy)
        .col("background.action", Hidden, "its action", |point| point.background.action)
        .col("background.length", Hidden, "its length", |point| point.background.length)
        .col("background.force", Hidden, "its mean contact force", |point| point.background.force);
    for (k, at) in ["site", "bond"].into_iter().enumerate() {
        let of = |of: fn(&CenteredKink) -> f64| move |point: &BarrierPoint| of(&point.kinks[k]);
        let name = |name: &str| format!("{at}.{name}");
        table = table
            .col(
                name("energy"),
                Power(6),
                format!("of the kink about a {at}, less the background"),
                of(|x| x.kink_energy),
            )
            .col(name("action"), Hidden, "its action, less that of the background", of(|x| x.kink_action))
            .col(name("length"), Hidden, "its length, less that of the background", of(|x| x.kink_length))
            .col(name("ring_energy"), Hidden, "with the background", of(|x| x.energy))
            .col(name("ring_action"), Hidden, "with the background", of(|x| x.action))
            .col(name("ring_length"), Hidden, "with the background", of(|x| x.length))
            .col(name("real"), Fixed(6), "largest real multiplier; 1 if none is above 1", of(|x| x.real))
            .col(name("largest"), Fixed(6), "largest modulus of a multiplier", of(|x| x.largest))
            .col(name("max_modulus"), Json, "", of(|x| x.largest))
            .col(name("residual"), Hidden, "of the orbit", of(|x| x.orbit.residual));
    }
    table
        .col("at_frequency", Power(6), "energy about a bond less that about a site", BarrierPoint::at_frequency)
        .col("at_action_and_length", Power(6), "the same at the same action and length", BarrierPoint::barrier)
        .done()
}
