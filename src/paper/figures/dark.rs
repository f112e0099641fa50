//! Dark profiles of the modulation equations.

use crate::{
    chain::Params,
    dps::{Center, DarkProfile},
    error::Result,
    output::csv,
    study::{center_word, of_sites, shown},
};

/// Profiles with the kink on a site and on a bond.
pub(super) fn profiles(sites: usize, c: f64) -> Result<Vec<DarkProfile>> {
    // The profile does not depend on rho.
    let params = Params { alpha: 1.5, kappa: 1.0, rho: 1.0 / 3.0 };
    [Center::Site, Center::Bond].map(|center| DarkProfile::new(params, center, sites, c)).into_iter().collect()
}

pub(super) fn dark_csv(profile: &DarkProfile) -> (&'static str, Vec<u8>) {
    ("profile.csv", csv(&["n", "a", "b"], profile.sites().map(|n| vec![n as f64, profile.a(n), profile.b(n)])))
}

pub(super) fn dark_caption(profiles: &[DarkProfile]) -> String {
    let words = |profile: &DarkProfile| {
        let least = of_sites(profile, |n| profile.b(n)).into_iter().fold(f64::INFINITY, f64::min);
        format!(
            "{}-centred: δ⁻a₁ = {}, least δ⁻bₙ = {}; Newton's method from (eq:an_ini) times the amplitude of the background, {} steps, residual {:.0e}. ",
            center_word(profile.center()),
            shown(profile.a(1)),
            shown(least),
            profile.newton().len() - 1,
            profile.residual(),
        )
    };
    let Some(one) = profiles.first() else { return String::new() };
    let (params, (a, c)) = (one.params(), one.background());
    format!(
        "Solutions of (eq:DpSsw2), renormalised to μ = 1, on a ring of {} sites; a breather of frequency ω_b has the strains μ^(1/(α−1)) (δ⁻bₙ + 2κ δ⁻aₙ cos ω_b t), \
         μ = 2ω³(ω_b − ω). α = {}, κ = {}, δ⁻b_(−N) = c = {c}; background δ⁻a = ±{}. {}hertzchain {}.",
        one.sites().count(),
        params.alpha,
        params.kappa,
        shown(a),
        profiles.iter().map(words).collect::<String>(),
        env!("CARGO_PKG_VERSION")
    )
    .replace("= -", "= −")
}

/// The panels of dark profiles, one column each.
#[cfg(feature = "plot")]
pub(super) fn dark_panels(title: &str, profiles: &[DarkProfile], caption: String) -> crate::figures::Panels {
    crate::figures::Panels { title: title.to_owned(), columns: profiles.iter().map(dark_column).collect(), caption }
}

/// Amplitudes and mean strains of a dark profile.
#[cfg(feature = "plot")]
fn dark_column(profile: &DarkProfile) -> crate::figures::Column {
    use crate::figures::{Column, Line, Panel};
    let line = |name: &str, values: Vec<f64>| Line {
        name: name.to_owned(),
        points: profile.sites().map(|n| n as f64).zip(values).collect(),
    };
    let lines = vec![
        line("amplitude δ⁻aₙ", of_sites(profile, |n| profile.a(n))),
        line("mean δ⁻bₙ", of_sites(profile, |n| profile.b(n))),
    ];
    let panel =
        Panel { x_label: "site n".to_owned(), y_label: "strain at μ = 1".to_owned(), lines, ..Panel::default() };
    Column::new(format!("{}-centred", center_word(profile.center())), [panel])
}
