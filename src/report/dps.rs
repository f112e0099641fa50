//! Reports of the modulation equations.

use super::table;
use crate::{
    dps::{Averages, Center, DarkProfile, Homoclinic, Values},
    error::Result,
    output::{csv, to_json},
};
use serde_json::{Value, json};

/// The averages at `(b, r)` as JSON; infinite slopes, which JSON has no number for, as `"inf"` and `"-inf"`.
pub fn averages_json(averages: &Averages, (b, r): (f64, f64), values: &Values) -> String {
    let number = |x: f64| if x.is_finite() { json!(x) } else { json!(x.to_string()) };
    let mut fields: serde_json::Map<String, Value> =
        rows(values).map(|(name, _, value)| (name.to_owned(), number(value))).into_iter().collect();
    for (name, value) in [("alpha", averages.alpha()), ("kappa", averages.kappa()), ("b", b), ("r", r)] {
        fields.insert(name.to_owned(), json!(value));
    }
    fields.insert("version".to_owned(), json!(env!("CARGO_PKG_VERSION")));
    to_json(&Value::Object(fields))
}

/// The averages as a table, all digits.
pub fn averages_table(values: &Values) -> String {
    let rows =
        rows(values).map(|(name, meaning, value)| vec![name.to_owned(), format!("{value:e}"), meaning.to_owned()]);
    table(&["quantity", "value", "what it is"], &rows)
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

/// A homoclinic solution as JSON.
pub fn homoclinic_json(one: &Homoclinic) -> String {
    to_json(&json!({
        "alpha": one.alpha(),
        "omega_0": one.omega_0(),
        "n": one.sites().collect::<Vec<_>>(),
        "a": one.sites().map(|n| one.a(n)).collect::<Vec<_>>(),
        "residual": one.residual(),
        "version": env!("CARGO_PKG_VERSION"),
    }))
}

/// A homoclinic solution as a table, all digits.
pub fn homoclinic_table(one: &Homoclinic) -> String {
    let rows: Vec<_> = one.sites().map(|n| vec![n.to_string(), format!("{:e}", one.a(n))]).collect();
    table(&["n", "a_n"], &rows)
        + &format!(
            "\nalpha = {}, omega_0 = {}; largest relative residual of (dpsstat) {:.1e}\n",
            one.alpha(),
            one.omega_0(),
            one.residual()
        )
}

/// Where a kink is, as a word.
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

/// A dark profile and the strains of the breather of frequency `omega_b` as JSON. `a` and `b` are those of `mu = 1`, `x` and `y` those of the `mu` given.
///
/// # Errors
/// An `omega_b` that is not above `omega`.
pub fn dark_json(profile: &DarkProfile, omega_b: f64) -> Result<String> {
    let (params, (a, b)) = (profile.params(), profile.background());
    let (x, y) = profile.seed(omega_b)?;
    Ok(to_json(&json!({
        "alpha": params.alpha,
        "kappa": params.kappa,
        "rho": params.rho,
        "center": center_word(profile.center()),
        "sites": x.len(),
        "c": profile.c(),
        "mu": profile.mu(omega_b)?,
        "omega": params.omega(),
        "omega_b": omega_b,
        "n": profile.sites().collect::<Vec<_>>(),
        "a": of_sites(profile, |n| profile.a(n)),
        "b": of_sites(profile, |n| profile.b(n)),
        "residual": profile.residual(),
        "newton": profile.newton(),
        "background": { "a": a, "b": b },
        "x": x,
        "y": y,
        "version": env!("CARGO_PKG_VERSION"),
    })))
}

/// A dark profile and the strains of the breather as CSV, a line a site.
///
/// # Errors
/// An `omega_b` that is not above `omega`.
pub fn dark_csv(profile: &DarkProfile, omega_b: f64) -> Result<Vec<u8>> {
    let (x, y) = profile.seed(omega_b)?;
    let rows = profile.sites().zip(x.iter().zip(&y));
    Ok(csv(&["n", "a", "b", "x", "y"], rows.map(|(n, (&x, &y))| vec![n as f64, profile.a(n), profile.b(n), x, y])))
}

/// A dark profile and the strains of the breather as a table.
///
/// # Errors
/// An `omega_b` that is not above `omega`.
pub fn dark_table(profile: &DarkProfile, omega_b: f64) -> Result<String> {
    let (params, (a, b)) = (profile.params(), profile.background());
    let (x, y) = profile.seed(omega_b)?;
    let row = |(n, (x, y)): (i64, (&f64, &f64))| {
        let numbers = [profile.a(n), profile.b(n), *x, *y].map(|value| format!("{value:.9e}"));
        [vec![n.to_string()], numbers.to_vec()].concat()
    };
    let rows: Vec<_> = profile.sites().zip(x.iter().zip(&y)).map(row).collect();
    let newton: Vec<String> = profile.newton().iter().map(|residual| format!("{residual:.1e}")).collect();
    Ok(table(&["n", "a_n", "b_n", "x_n(0)", "y_n(0)"], &rows)
        + &format!(
            "\na_n, b_n: delta^- of the standing wave (eq:DpSsw2) at mu = 1; x, y: strains of the breather at rest (eq:xy_sw)\n\
             alpha = {}, kappa = {}, rho = {}; omega = {}, omega_b = {omega_b}, mu = {:e}\n\
             background: a = {a:e}, b = {b:e}\nresidual at each step of Newton's method: {}\n",
            params.alpha,
            params.kappa,
            params.rho,
            params.omega(),
            profile.mu(omega_b)?,
            newton.join(", "),
        ))
}
