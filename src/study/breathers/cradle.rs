//! Bright breathers of the cradle, beads on springs that just touch, as exact orbits: about a site
//! and about a bond, and the barrier between them.
//!
//! | symbol | meaning |
//! |---|---|
//! | `E, J` | energy; action `(1/pi) int K dt` over a period, with the kinetic energy `K` |
//! | `epsilon, a_n` | size and profile of the breather of the DpS equation, `u_n = 2 epsilon a_n` |
//!
//! Along a family `dE = omega_b dJ`. The action is an adiabatic invariant: for a breather that
//! moves slowly the barrier is the difference of energies at the same action, to first order that
//! of `E - omega_b J` at the same frequency. To leading order the DpS equation has
//! `J = 2 epsilon^2 sum a_n^2` at `omega_b = 1 + omega_0 epsilon^{alpha-1}`, and
//! `E - omega_b J = (1 - omega_b) J (alpha - 1)/(alpha + 1)`.

use crate::study::{Progress, Study, Work, options::options};
use crate::{
    chain::{Boundary, Chain, Params},
    dps::{Center, Homoclinic},
    error::{Result, require},
    orbits::{ModeContinuation, NormalModes, Problem},
    report::{
        Digits::{Fixed, Power},
        Kind, Panels, Report, rows,
    },
    sweep::{Engine, Grid, Missing},
};
use serde::{Deserialize, Serialize};
use serde_json::json;

options! {
    /// Bright breathers of the cradle over their frequency.
    pub struct Cradle {
        /// Exponent of the contact force; 1.5 for spheres.
        alpha: f64 = 1.5, "A", (1.15 to 10);
        /// Number of sites.
        ///
        /// About a site an odd number, about a bond the even one above it.
        sites: usize = 21, "N", (5 to 254);
        /// Smallest frequency of the breathers, whose springs have kappa = 1.
        from: f64 = 1.01, "P", (above 1 to 10);
        /// Largest frequency of the breathers.
        to: f64 = 1.2, "P", (above 1 to 10);
        /// Number of frequencies, equally spaced.
        frequencies: usize = 20, "N", (2 to 1000);
    }
}

rows! {
    /// The breathers of one frequency.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    pub struct CradleRow {
        /// Frequency.
        omega_b: f64 => Fixed(6),
        /// Largest displacement of the breather about a site.
        site_amplitude: f64 => Power(6),
        /// Energy.
        site_energy: f64 => Power(6),
        /// Largest modulus of a multiplier.
        site_largest: f64 => Fixed(6),
        /// Largest displacement of the breather about a bond.
        bond_amplitude: f64 => Power(6),
        /// Energy.
        bond_energy: f64 => Power(6),
        /// Largest modulus of a multiplier.
        bond_largest: f64 => Fixed(6),
        /// Energy about a bond less that about a site, at the same frequency.
        at_frequency: f64 => Power(6),
        /// The same at the same action, to first order.
        at_action: f64 => Power(6),
        /// `at_action` by the DpS equation.
        dps_at_action: f64 => Power(6),
    }
}

impl Cradle {
    fn check(&self) -> Result<Vec<f64>> {
        self.within_ranges()?;
        require(self.to > self.from, "to", self.to, "above --from")?;
        let step = (self.to - self.from) / (self.frequencies - 1) as f64;
        Ok((0..self.frequencies).map(|k| self.from + step * k as f64).collect())
    }

    /// The number of beads about a site.
    fn odd(&self) -> usize {
        self.sites - (self.sites + 1) % 2
    }

    /// The breathers at every frequency, on all cores, and the frequencies at which one is not
    /// found.
    ///
    /// # Errors
    /// An option outside its rule; no orbit is found; a signal.
    pub fn study(&self, engine: &Engine, progress: Progress<'_>) -> Result<(Vec<CradleRow>, Missing)> {
        let (frequencies, &Self { alpha, sites, .. }) = (self.check()?, self);
        let params = Params::new(alpha, 1.0, f64::INFINITY)?;
        let modes = |n: usize| NormalModes::new(&Chain::new(params, Boundary::Free, n)?);
        let odd = self.odd();
        let modes = [modes(odd)?, modes(odd + 1)?];
        let profiles = [Homoclinic::new(alpha, Center::Site)?, Homoclinic::new(alpha, Center::Bond)?];
        let settings = json!({"alpha": alpha, "sites": sites});
        let grid = Grid { store: Self::STORE, study: "cradle", settings };
        let swept = engine.sweep(&grid, &frequencies, progress, |&omega_b| row(&modes, &profiles, omega_b))?;
        swept.found(&frequencies, |omega_b| format!("omega_b = {omega_b}"))
    }

    fn report(&self, rows: &[CradleRow], missing: &[(String, String)]) -> Report {
        let table = CradleRow::table("cradle", rows).done();
        let panel = |kind, label: &str, lines: &[(&str, &str)]| table.panel(kind, ["ω_b", label], "omega_b", lines);
        let plots = vec![
            panel(Kind::LogParameter, "energy", &[("site", "site_energy"), ("bond", "bond_energy")]),
            panel(Kind::Parameter, "bond − site, same action", &[("orbits", "at_action"), ("DpS", "dps_at_action")]),
            panel(Kind::Parameter, "largest |λ|", &[("site", "site_largest"), ("bond", "bond_largest")]),
        ];
        let (alpha, odd) = (self.alpha, self.odd());
        let caption = format!(
            "Bright breathers of beads on springs that just touch, {odd} about a site and {} about a bond, α = {alpha}, \
             κ = 1: energies; bond-centred less site-centred; largest moduli of multipliers.",
            odd + 1
        );
        Report::new("cradle")
            .fact("alpha", alpha)
            .fact("sites", self.sites)
            .table(table)
            .missing(missing)
            .picture(Panels::column("Bright breathers of the cradle", plots, caption))
    }
}

/// Energy, action, largest displacement and largest modulus of a multiplier of a breather.
fn breather(modes: &NormalModes, omega_b: f64) -> Result<[f64; 4]> {
    let (mode, orbit) = (modes.most_localised(), ModeContinuation::breather(modes, omega_b)?);
    let way = ModeContinuation { mode, to: 2.0 * orbit.amplitude, step: orbit.amplitude, most_points: 2 };
    let energy = way.measures(modes, &orbit)?.energy;
    Ok([energy, modes.action(&orbit)?, orbit.amplitude, way.spectrum(modes, &orbit)?.largest()])
}

fn row([site, bond]: &[NormalModes; 2], profiles: &[Homoclinic; 2], omega_b: f64) -> Result<CradleRow> {
    let [site_energy, site_action, site_amplitude, site_largest] = breather(site, omega_b)?;
    let [bond_energy, bond_action, bond_amplitude, bond_largest] = breather(bond, omega_b)?;
    let (alpha, shift) = (site.chain().params().alpha, omega_b - 1.0);
    let [site, bond] = profiles.each_ref().map(|profile| {
        let epsilon = (shift / profile.omega_0()).powf((alpha - 1.0).recip());
        2.0 * epsilon * epsilon * profile.sites().map(|n| profile.a(n).powi(2)).sum::<f64>()
    });
    let at_frequency = bond_energy - site_energy;
    Ok(CradleRow {
        omega_b,
        site_amplitude,
        site_energy,
        site_largest,
        bond_amplitude,
        bond_energy,
        bond_largest,
        at_frequency,
        at_action: at_frequency - omega_b * (bond_action - site_action),
        dps_at_action: -shift * (bond - site) * (alpha - 1.0) / (alpha + 1.0),
    })
}

impl Study for Cradle {
    const STORE: &'static str = "cradle.store";

    fn outline() -> Option<Report> {
        Some(Self::default().report(&[], &[]))
    }

    fn begin(&self) -> Result<Work<'_>> {
        self.check()?;
        Ok(Box::new(|engine, progress| {
            let (rows, missing) = self.study(engine, progress)?;
            Ok(self.report(&rows, &missing))
        }))
    }
}
