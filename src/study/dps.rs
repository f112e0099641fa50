//! The modulation equations: averages of the contact force, homoclinic solutions, standing waves
//! with a kink.

use super::{File, Report, Study, Work, named};
use crate::{
    chain::Params,
    dps::{Averages, Center, DarkProfile, Homoclinic, Values},
    error::{Error, Result},
    output::csv,
    present::table,
};
use serde_json::{Value, json};

/// Default frequency of a dark breather, in units of `omega`.
const FREQUENCY: f64 = 1.005;

/// The averaged contact force, its harmonic, and their derivatives.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct Integrals {
    /// Exponent of the contact force; 1.5 for spheres.
    ///
    /// Above 0 and at most 10.
    #[cfg_attr(feature = "cli", arg(long, value_name = "A", default_value = "1.5"))]
    pub alpha: f64,
    /// Spring constant of the resonators, positive.
    #[cfg_attr(feature = "cli", arg(long, value_name = "K", default_value = "1"))]
    pub kappa: f64,
    /// Mean strain.
    ///
    /// The overlap of the bond is -b + 2 kappa r cos t; all values are zero for b >= 2 kappa r.
    #[cfg_attr(feature = "cli", arg(long, value_name = "B"))]
    pub b: f64,
    /// Amplitude r of the oscillation, at least zero.
    #[cfg_attr(feature = "cli", arg(long, value_name = "R"))]
    pub r: f64,
}

/// The averages and their derivatives at one pair `(b, r)`.
struct Integrated {
    averages: Averages,
    b: f64,
    r: f64,
    values: Values,
}

impl Study for Integrals {
    const FILES: &'static str = "";

    fn begin(&self) -> Result<Work<'_>> {
        let (averages, b, r) = (Averages::new(self.alpha, self.kappa)?, self.b, self.r);
        let values = averages.checked(b, r)?;
        // Slopes may be infinite where the averages begin; an average never is.
        let lost =
            |(name, _, value): &(&str, &str, f64)| value.is_nan() || value.is_infinite() && !name.starts_with('d');
        if let Some((name, ..)) = rows(&values).into_iter().find(lost) {
            let why = format!("{name} is no number that a double holds");
            return Err(Error::Point { point: format!("b = {b:e}, r = {r:e}"), why });
        }
        Ok(Box::new(move |_, _| Ok(Box::new(Integrated { averages, b, r, values }))))
    }
}

impl Report for Integrated {
    /// Infinite slopes, which JSON has no number for, are `"inf"` and `"-inf"`.
    fn json(&self) -> Value {
        let number = |x: f64| if x.is_finite() { json!(x) } else { json!(x.to_string()) };
        let mut fields: serde_json::Map<String, Value> =
            rows(&self.values).map(|(name, _, value)| (name.to_owned(), number(value))).into_iter().collect();
        for (name, value) in
            [("alpha", self.averages.alpha()), ("kappa", self.averages.kappa()), ("b", self.b), ("r", self.r)]
        {
            fields.insert(name.to_owned(), json!(value));
        }
        fields.insert("version".to_owned(), json!(env!("CARGO_PKG_VERSION")));
        Value::Object(fields)
    }

    /// All digits.
    fn text(&self) -> String {
        let rows = rows(&self.values)
            .map(|(name, meaning, value)| vec![name.to_owned(), format!("{value:e}"), meaning.to_owned()]);
        table(&["quantity", "value", "what it is"], &rows)
    }

    fn files(&self, _: &str) -> Result<Vec<File>> {
        Ok(Vec::new())
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(Vec::new())
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

/// Homoclinic solutions: profiles of bright breathers.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct Homoclinics {
    /// Exponent of the contact force; 1.5 for spheres.
    ///
    /// From 1.01 to 10.
    #[cfg_attr(feature = "cli", arg(long, value_name = "A", default_value = "1.5"))]
    pub alpha: f64,
    /// What the profile is symmetric about.
    #[cfg_attr(feature = "cli", arg(long, value_name = "C", value_enum, default_value_t = Center::Site))]
    pub center: Center,
}

impl Study for Homoclinics {
    const FILES: &'static str = "";

    fn begin(&self) -> Result<Work<'_>> {
        let one = Homoclinic::new(self.alpha, self.center)?;
        Ok(Box::new(move |_, _| Ok(Box::new(one))))
    }
}

impl Report for Homoclinic {
    fn json(&self) -> Value {
        json!({
            "alpha": self.alpha(),
            "omega_0": self.omega_0(),
            "n": self.sites().collect::<Vec<_>>(),
            "a": self.sites().map(|n| self.a(n)).collect::<Vec<_>>(),
            "residual": self.residual(),
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    /// All digits.
    fn text(&self) -> String {
        let rows: Vec<_> = self.sites().map(|n| vec![n.to_string(), format!("{:e}", self.a(n))]).collect();
        table(&["n", "a_n"], &rows)
            + &format!(
                "\nalpha = {}, omega_0 = {}; largest relative residual of (dpsstat) {:.1e}\n",
                self.alpha(),
                self.omega_0(),
                self.residual()
            )
    }

    fn files(&self, _: &str) -> Result<Vec<File>> {
        Ok(Vec::new())
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(Vec::new())
    }
}

/// The centre of a kink, as a word.
pub(crate) fn center_word(center: Center) -> &'static str {
    match center {
        Center::Site => "site",
        Center::Bond => "bond",
    }
}

/// `a_n` or `b_n` of all sites.
pub(crate) fn of_sites(profile: &DarkProfile, value: impl Fn(i64) -> f64) -> Vec<f64> {
    profile.sites().map(value).collect()
}

/// Standing waves with a kink: profiles of dark breathers.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct DarkProfiles {
    /// What the profile is symmetric about.
    ///
    /// The kink is on the site 0, or on the bond between the sites 0 and 1.
    #[cfg_attr(feature = "cli", arg(long, value_name = "C", value_enum, default_value_t = Center::Site))]
    pub center: Center,
    /// Number of sites.
    ///
    /// Length of the ring, an odd number from 3 to 100001.
    #[cfg_attr(feature = "cli", arg(long, value_name = "N", default_value_t = 41))]
    pub sites: usize,
    /// Exponent of the contact force; 1.5 for spheres.
    ///
    /// From 1.01 to 10.
    #[cfg_attr(feature = "cli", arg(long, value_name = "A", default_value = "1.5"))]
    pub alpha: f64,
    /// Spring constant of the resonators, positive.
    #[cfg_attr(feature = "cli", arg(long, value_name = "K", default_value = "1"))]
    pub kappa: f64,
    /// Mass ratio resonator to bead, positive.
    ///
    /// Finite.
    #[cfg_attr(feature = "cli", arg(long, value_name = "R", default_value_t = 1.0 / 3.0))]
    pub rho: f64,
    /// Mean strain of the background at mu = 1.
    #[cfg_attr(feature = "cli", arg(long, value_name = "C", default_value = "0"))]
    pub c: f64,
    /// Frequency of the breather, in radians per unit of time.
    ///
    /// Above omega = sqrt(kappa (1 + 1/rho)) [default: 1.005 omega].
    #[cfg_attr(feature = "cli", arg(long, value_name = "W"))]
    pub omega_b: Option<f64>,
}

/// A dark profile and the strains of the breather of a frequency.
struct Profiled {
    profile: DarkProfile,
    omega_b: f64,
    mu: f64,
    x: Vec<f64>,
    y: Vec<f64>,
}

impl Study for DarkProfiles {
    const FILES: &'static str = "Files: dark.csv, dark.json and dark.png.";

    fn begin(&self) -> Result<Work<'_>> {
        let &Self { sites, alpha, kappa, rho, c, .. } = self;
        let profile = DarkProfile::new(Params { alpha, kappa, rho }, self.center, sites, c)?;
        let omega_b = self.omega_b.unwrap_or(FREQUENCY * profile.params().omega());
        let (mu, (x, y)) = (profile.mu(omega_b)?, profile.seed(omega_b)?);
        Ok(Box::new(move |_, _| Ok(Box::new(Profiled { profile, omega_b, mu, x, y }))))
    }
}

impl Profiled {
    fn a(&self) -> Vec<f64> {
        of_sites(&self.profile, |n| self.profile.a(n))
    }

    fn b(&self) -> Vec<f64> {
        of_sites(&self.profile, |n| self.profile.b(n))
    }
}

impl Report for Profiled {
    /// `a` and `b` are those of `mu = 1`, `x` and `y` those of the `mu` given.
    fn json(&self) -> Value {
        let (params, (a, b)) = (self.profile.params(), self.profile.background());
        json!({
            "alpha": params.alpha,
            "kappa": params.kappa,
            "rho": params.rho,
            "center": center_word(self.profile.center()),
            "sites": self.x.len(),
            "c": self.profile.c(),
            "mu": self.mu,
            "omega": params.omega(),
            "omega_b": self.omega_b,
            "n": self.profile.sites().collect::<Vec<_>>(),
            "a": self.a(),
            "b": self.b(),
            "residual": self.profile.residual(),
            "newton": self.profile.newton(),
            "background": { "a": a, "b": b },
            "x": self.x,
            "y": self.y,
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self) -> String {
        let (profile, params, (a, b)) = (&self.profile, self.profile.params(), self.profile.background());
        let row = |(n, (x, y)): (i64, (&f64, &f64))| {
            let numbers = [profile.a(n), profile.b(n), *x, *y].map(|value| format!("{value:.9e}"));
            [vec![n.to_string()], numbers.to_vec()].concat()
        };
        let rows: Vec<_> = profile.sites().zip(self.x.iter().zip(&self.y)).map(row).collect();
        let newton: Vec<String> = profile.newton().iter().map(|residual| format!("{residual:.1e}")).collect();
        table(&["n", "a_n", "b_n", "x_n(0)", "y_n(0)"], &rows)
            + &format!(
                "\na_n, b_n: delta^- of the standing wave (eq:DpSsw2) at mu = 1; x, y: strains of the breather at rest (eq:xy_sw)\n\
                 alpha = {}, kappa = {}, rho = {}; omega = {}, omega_b = {}, mu = {:e}\n\
                 background: a = {a:e}, b = {b:e}\nresidual at each step of Newton's method: {}\n",
                params.alpha,
                params.kappa,
                params.rho,
                params.omega(),
                self.omega_b,
                self.mu,
                newton.join(", "),
            )
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let rows = self.profile.sites().zip(self.x.iter().zip(&self.y));
        let row = |(n, (&x, &y)): (i64, (&f64, &f64))| vec![n as f64, self.profile.a(n), self.profile.b(n), x, y];
        Ok(named([("dark.csv", csv(&["n", "a", "b", "x", "y"], rows.map(row))), ("dark.json", json.into())]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        use crate::figures::{Column, Kind, Line, Panel, Panels, panels};
        let panel = |label: &str, values: &[f64]| {
            let points = self.profile.sites().map(|n| n as f64).zip(values.iter().copied());
            Panel::new(Kind::Sites, ["site n", label], vec![Line::new(label, points)])
        };
        let params = self.profile.params();
        let columns = vec![
            Column::new("standing wave at μ = 1", [panel("aₙ", &self.a()), panel("bₙ", &self.b())]),
            Column::new("breather at rest", [panel("strain xₙ", &self.x), panel("strain yₙ", &self.y)]),
        ];
        let caption = format!(
            "Standing wave with a kink (eq:DpSsw2) about a {}, and the strains that start the breather (eq:xy_sw). N = {}, {}, ω_b = {}, μ = {:.6e}. hertzchain {}.",
            center_word(self.profile.center()),
            self.x.len(),
            crate::study::params_words(params),
            self.omega_b,
            self.mu,
            env!("CARGO_PKG_VERSION")
        );
        let figure = Panels { title: "Profile of a dark breather".into(), columns, caption };
        Ok(named([("dark.png", panels(&figure)?)]))
    }
}
