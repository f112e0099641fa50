//! Reports of the modulation equations.

use super::table;
use crate::{
    dps::{Homoclinic, Values},
    output::to_json,
};
use serde_json::{Value, json};

/// The averages as JSON; infinite slopes, which JSON has no number for, as `"inf"` and `"-inf"`.
pub fn averages_json(values: &Values) -> String {
    let number = |x: f64| if x.is_finite() { json!(x) } else { json!(x.to_string()) };
    let fields = rows(values).map(|(name, _, value)| (name.to_owned(), number(value)));
    to_json(&Value::Object(fields.into_iter().collect()))
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
