//! The modulation equations: averages of the contact force, homoclinic solutions, standing waves
//! with a kink.

use crate::study::{ChainParams, Study, Work, center_word, format_short, options::options, params_words};
use crate::{
    dps::{Averages, Center, DarkProfile, Homoclinic, Values},
    error::{Error, Result},
    report::{Column, Fixed, Kind, Line, Panel, Panels, Power, Report, Short, Table, fields, number},
};
use serde_json::json;

/// Default frequency of a dark breather, in units of `omega`.
const FREQUENCY: f64 = 1.005;

options! {
    /// The averaged contact force, its harmonic, and their derivatives.
    pub struct Integrals {
        /// Exponent of the contact force; 1.5 for spheres.
        alpha: f64 = 1.5, "A", (above 0 to 10);
        /// Spring constant of the resonators.
        kappa: f64 = 1.0, "K", (positive);
        /// Mean strain.
        ///
        /// The overlap of the bond is -b + 2 kappa r cos t; all values are zero for b >= 2 kappa r.
        b: f64 = f64::NAN, "B", (finite);
        /// Amplitude r of the oscillation.
        r: f64 = f64::NAN, "R", (from 0);
    }
}

impl Study for Integrals {
    const FILES: &'static str = "";

    fn begin(&self) -> Result<Work<'_>> {
        self.within_ranges()?;
        let (averages, b, r) = (Averages::new(self.alpha, self.kappa)?, self.b, self.r);
        let values = averages.checked(b, r)?;
        // Slopes may be infinite where the averages begin; an average never is.
        let lost =
            |(name, _, value): &(&str, &str, f64)| value.is_nan() || value.is_infinite() && !name.starts_with('d');
        if let Some((name, ..)) = rows(&values).into_iter().find(lost) {
            let why = format!("{name} is no number that a double holds");
            return Err(Error::Point { point: format!("b = {b:e}, r = {r:e}"), why });
        }
        let rows = rows(&values);
        let table = Table::of("integrals", &rows)
            .key("")
            .col("quantity", Short, "", |row| row.0)
            .col("value", Short, "", |row| format!("{:e}", row.2))
            .col("what_it_is", Short, "", |row| row.1);
        let report = Report::new("integrals")
            .facts(fields!(averages => alpha(), kappa()))
            .fact("b", b)
            .fact("r", r)
            .table(table);
        // Infinite slopes, which JSON has no number for, are `"inf"` and `"-inf"`.
        let report = rows.iter().fold(report, |report, row| report.fact(row.0, number(row.2)));
        Ok(Box::new(move |_, _| Ok(report)))
    }
}

fn rows(values: &Values) -> [(&'static str, &'static str, f64); 8] {
    [
        ("g", "mean contact force", values.g),
        ("h", "first harmonic of the contact force over r", values.h),
        ("dg_db", "d g / d b", values.dg_db),
        ("dg_dr", "d g / d r", values.dg_dr),
        ("dh_db", "d h / d b", values.dh_db),
        ("dh_dr", "d h / d r", values.dh_dr),
        ("drh_db", "d (r h) / d b", values.drh_db),
        ("drh_dr", "d (r h) / d r", values.drh_dr),
    ]
}

options! {
    /// Homoclinic solutions: profiles of bright breathers.
    pub struct Homoclinics {
        /// Exponent of the contact force; 1.5 for spheres.
        alpha: f64 = 1.5, "A", (1.01 to 10);
        /// What the profile is symmetric about.
        center: Center = Center::Site, "C";
    }
}

impl Study for Homoclinics {
    fn outline() -> Option<Report> {
        Some(Report::new("homoclinic").table(profile(&[])))
    }

    fn begin(&self) -> Result<Work<'_>> {
        let report = self.report()?;
        Ok(Box::new(move |_, _| Ok(report)))
    }
}

/// The profile of a homoclinic solution, by sites.
fn profile(sites: &[(i64, f64)]) -> Table {
    Table::of("homoclinic", sites)
        .key("")
        .col("n", Fixed(0), "", |site| site.0 as f64)
        .col("a", Power(16), "", |site| site.1)
        .col("ln_ln", Fixed(6), "ln|ln|a||: a line of slope ln alpha in the tails", |site| site.1.abs().ln().abs().ln())
        .done()
}

impl Homoclinics {
    /// The report of the solution.
    ///
    /// # Errors
    /// As of [`Homoclinic::new`].
    pub fn report(&self) -> Result<Report> {
        self.within_ranges()?;
        let one = Homoclinic::new(self.alpha, self.center)?;
        let sites: Vec<i64> = one.sites().collect();
        let table = profile(&sites.iter().map(|&n| (n, one.a(n))).collect::<Vec<_>>());
        let panel = |label: &str, column| table.panel(Kind::Sites, ["site n", label], "n", &[(label, column)]);
        let (mut decay, mut law) = (panel("ln|ln|aₙ||", "ln_ln"), Vec::new());
        decay.lines[0].points.retain(|point| point.0 > 0.0);
        // A panel with the same label would get the range of the panel above.
        decay.x_label = "site n > 0".to_owned();
        if let Some((last, end)) = decay.lines[0].points.last() {
            // Half a unit below the tail, along its outer half.
            law.extend([0.5, 1.0].map(|share| (share * last, end - 0.5 - (1.0 - share) * last * self.alpha.ln())));
        }
        decay.lines.push(Line::law("slope ln α", law));
        let ends = [2, 1].map(|from_end| sites.len().checked_sub(from_end).map_or(f64::NAN, |k| one.a(sites[k])));
        let [before, last] = ends.map(|a| a.abs().ln().abs().ln());
        let caption = format!(
            "Solution of aₙ = −δ⁺(δ⁻aₙ |δ⁻aₙ|^(α−1)) about a {}, α = {}: a₁ = {}, {} sites, slope of the last two {:.6}, \
             ln α = {:.6}, residual {:.0e}.",
            center_word(self.center),
            one.alpha(),
            format_short(one.a(1)).replace('-', "−"),
            sites.len(),
            last - before,
            one.alpha().ln(),
            one.residual()
        );
        let columns = vec![Column::new("", [panel("aₙ", "a")]), Column::new("", [decay])];
        Ok(Report::new("homoclinic")
            .facts(fields!(one => alpha(), omega_0()))
            .fact("n", &sites)
            .fact("a", sites.iter().map(|n| one.a(*n)).collect::<Vec<_>>())
            .fact("residual", one.residual())
            .table(table)
            .words(format!(
                "alpha = {}, omega_0 = {}; largest relative residual of (dpsstat) {:.1e}",
                one.alpha(),
                one.omega_0(),
                one.residual()
            ))
            .picture(Panels { title: "Homoclinic solution: profile of a bright breather".into(), columns, caption }))
    }
}

fn of_sites(profile: &DarkProfile, value: impl Fn(i64) -> f64) -> Vec<f64> {
    profile.sites().map(value).collect()
}

options! {
    /// Standing waves with a kink: profiles of dark breathers.
    pub struct DarkProfiles {
        /// What the profile is symmetric about.
        ///
        /// The kink is on the site 0, or on the bond between the sites 0 and 1.
        center: Center = Center::Site, "C";
        /// Number of sites.
        ///
        /// Length of the ring, an odd number from 3 to 100001.
        sites: usize = 41, "N";
        /// The chain.
        params: ChainParams = ChainParams::default();
        /// Mean strain of the background at mu = 1.
        c: f64 = 0.0, "C", (finite);
        /// Frequency of the breather, in radians per unit of time [default: 1.005 omega].
        ///
        /// Above omega = sqrt(kappa (1 + 1/rho)).
        omega_b: Option<f64> = None, "W";
    }
}

/// The row of a site: its number, `a` and `b` at `mu = 1`, strains of the breather at rest.
type Site = (i64, [f64; 4]);

fn dark_table(sites: &[Site]) -> Table {
    Table::of("dark", sites)
        .key("")
        .col("n", Fixed(0), "", |site| site.0 as f64)
        .col("a", Power(9), "delta^- of the standing wave (eq:DpSsw2) at mu = 1", |site| site.1[0])
        .col("b", Power(9), "the same of its mean", |site| site.1[1])
        .col("x", Power(9), "strains of the breather at rest (eq:xy_sw)", |site| site.1[2])
        .col("y", Power(9), "", |site| site.1[3])
        .done()
}

impl Study for DarkProfiles {
    fn outline() -> Option<Report> {
        Some(Report::new("dark").table(dark_table(&[])))
    }

    fn begin(&self) -> Result<Work<'_>> {
        let report = self.report()?;
        Ok(Box::new(move |_, _| Ok(report)))
    }
}

impl DarkProfiles {
    /// The report of the profile.
    ///
    /// # Errors
    /// As of [`DarkProfile::new`] and [`DarkProfile::mu`].
    pub fn report(&self) -> Result<Report> {
        self.within_ranges()?;
        let profile = DarkProfile::new(self.params.checked()?, self.center, self.sites, self.c)?;
        let omega_b = self.omega_b.unwrap_or(FREQUENCY * profile.params().omega());
        let (mu, (x, y)) = (profile.mu(omega_b)?, profile.seed(omega_b)?);
        Ok(dark_report(&profile, omega_b, mu, [x, y]))
    }
}

/// The report of a dark profile and the strains of the breather of a frequency: `a` and `b` are
/// those of `mu = 1`, `x` and `y` those of the `mu` given.
fn dark_report(profile: &DarkProfile, omega_b: f64, mu: f64, [x, y]: [Vec<f64>; 2]) -> Report {
    let (params, background) = (profile.params(), profile.background());
    let strains = x.iter().zip(&y);
    let sites = profile.sites().zip(strains).map(|(n, (x, y))| (n, [profile.a(n), profile.b(n), *x, *y]));
    let table = dark_table(&sites.collect::<Vec<Site>>());
    let panel = |label: &str, line| Panel::new(Kind::Sites, ["site n", label], vec![line]);
    let line = |label: &str, column| table.line(label, ["n", column]);
    let staggered = |label: &str, column| {
        let label = format!("(−1)ⁿ {label}");
        panel(&label, line(&label, column).staggered())
    };
    let columns = vec![
        Column::new("standing wave at μ = 1", [staggered("aₙ", "a"), panel("bₙ", line("bₙ", "b"))]),
        Column::new("breather at rest", [staggered("strain xₙ", "x"), staggered("strain yₙ", "y")]),
    ];
    let center = center_word(profile.center());
    let caption = format!(
        "Standing wave with a kink about a {center}, and the strains that start the breather. \
         N = {}, {}. ω_b = {omega_b}, μ = {}; at μ = 1 the background is ±{} and {}, a₁ = {}, {} steps of \
         Newton's method, residual {:.0e}.",
        x.len(),
        params_words(params),
        format_short(mu),
        format_short(background.0),
        format_short(background.1),
        format_short(profile.a(1)).replace('-', "−"),
        profile.newton().len() - 1,
        profile.residual(),
    );
    let newton: Vec<String> = profile.newton().iter().map(|residual| format!("{residual:.1e}")).collect();
    let words = format!(
        "alpha = {}, kappa = {}, rho = {}; omega = {}, omega_b = {omega_b}, mu = {mu:e}; background: a = {:e}, b = {:e}; \
         residual at each step of Newton's method: {}",
        params.alpha,
        params.kappa,
        params.rho,
        params.omega(),
        background.0,
        background.1,
        newton.join(", "),
    );
    Report::new("dark")
        .facts(fields!(params => alpha, kappa, rho))
        .fact("center", center)
        .fact("sites", x.len())
        .fact("c", profile.c())
        .fact("mu", mu)
        .fact("omega", params.omega())
        .fact("omega_b", omega_b)
        .fact("n", profile.sites().collect::<Vec<_>>())
        .fact("a", of_sites(profile, |n| profile.a(n)))
        .fact("b", of_sites(profile, |n| profile.b(n)))
        .facts(fields!(profile => residual(), newton()))
        .fact("background", json!({ "a": background.0, "b": background.1 }))
        .fact("x", x)
        .fact("y", y)
        .table(table)
        .words(words)
        .picture(Panels { title: "Profile of a dark breather".into(), columns, caption })
}
