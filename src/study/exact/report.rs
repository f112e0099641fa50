//! Exact waves and their branches as text, JSON, files and pictures.

#[cfg(feature = "plot")]
use super::BlochGrowth;
use super::{BranchWave, ExactStudy, WaveBranchStudy};
use crate::{
    error::Result,
    number::{of_pi, shown},
    orbits::Kantorovich,
    output::{Array, csv, npz_with, to_json},
    present::table,
    study::{File, Report, named, params_words},
    waves::{ExactWave, WaveEnd, WaveMultiplier},
};
use serde_json::{Value, json};
use std::f64::consts::PI;

/// States of a cell along a branch.
pub(super) const STATES: &str = "states.npz";

/// A mass ratio; JSON has no number for infinite ones.
fn rho_json(rho: f64) -> Value {
    if rho.is_finite() { json!(rho) } else { json!("inf") }
}

/// What determines a wave, and how well it is solved.
fn wave_json(wave: &ExactWave) -> Value {
    let setting = &wave.setting;
    json!({
        "q_over_pi": setting.q.q() / PI,
        "alpha": setting.params.alpha,
        "kappa": setting.params.kappa,
        "rho": rho_json(setting.params.rho),
        "omega_tw": setting.omega_tw,
        "period": setting.period(),
        "amplitude": wave.amplitude(),
        "mean_strain": wave.mean(),
        "residual": wave.residual,
    })
}

impl ExactStudy {
    /// The ansatz, in words.
    fn beside(&self) -> String {
        match (self.ansatz, self.errors) {
            (Some(ansatz), Some([e_x, e_y])) => format!(
                "ansatz {:.12e}, {:.12e}: E_x = {e_x:.4e}, E_y = {e_y:.4e}",
                ansatz.amplitude(),
                ansatz.epsilon() * ansatz.shape().b
            ),
            _ => "no first-order ansatz".to_owned(),
        }
    }
}

impl Report for ExactStudy {
    fn json(&self) -> Value {
        let wave = &self.wave;
        let [x, y, vx, vy] = wave.on_ring(self.spectrum.sites);
        let mut value = wave_json(wave);
        let fastest = self.spectrum.fastest();
        let more = json!({
            "scene": self.scene,
            "sites": self.spectrum.sites,
            "cell": wave.setting.q.cell(),
            "x": x, "y": y, "vx": vx, "vy": vy,
            "newton": wave.newton,
            "fourier": self.fourier[0],
            "fourier_y": self.fourier[1],
            "odd": self.odd,
            "closed": self.profile.closed(),
            "multipliers": self.spectrum.multipliers,
            "quality": self.spectrum.quality,
            "growing": self.spectrum.growing(),
            "fastest": fastest,
            "growth": self.growth,
            "kantorovich": self.kantorovich,
            "e_x_ansatz": self.errors.map(|errors| errors[0]),
            "e_y_ansatz": self.errors.map(|errors| errors[1]),
            "ansatz": self.ansatz.map(|ansatz| json!({
                "epsilon": ansatz.epsilon(),
                "amplitude": ansatz.amplitude(),
                "omega_tw": ansatz.omega_tw(),
                "mean_strain": ansatz.epsilon() * ansatz.shape().b,
            })),
            "version": env!("CARGO_PKG_VERSION"),
        });
        if let (Some(value), Value::Object(more)) = (value.as_object_mut(), more) {
            value.extend(more);
        }
        value
    }

    fn text(&self) -> String {
        let (wave, quality) = (&self.wave, &self.spectrum.quality);
        let setting = &wave.setting;
        let rows: Vec<Vec<String>> = self
            .growth
            .iter()
            .filter(|row| row.exact > 0.0 || row.modulation.is_some_and(|growth| growth > 0.0))
            .map(|row| {
                let per_period = (row.exact * setting.period()).exp();
                let numbers = [Some(row.exact), row.modulation];
                let mut cells = vec![format!("{:.4}", row.bloch / PI)];
                cells.extend(numbers.map(|growth| growth.map_or("-".to_owned(), |growth| format!("{growth:.6e}"))));
                cells.push(format!("{per_period:.6}"));
                cells
            })
            .collect();
        let head = ["p/pi", "growth per t", "by the DpS equations", "factor a period"];
        let spectrum =
            if rows.is_empty() { "No multiplier lies off the unit circle.\n".to_owned() } else { table(&head, &rows) };
        format!(
            "x_n(t) = X(q n - omega_tw t), q = {}, omega_tw = {}, {}\n\
             amplitude {:.12e}, mean strain {:.12e}; {}\n\
             residual {:.1e} of the amplitude after {} steps of Newton's method; contacts closed for {:.4} of the period\n{}\n\n\
             Relative multipliers on {} sites, by Bloch wave number:\n{spectrum}\n\
             {} of {} multipliers grow. Checks: symplectic defect {:.1e}, eigenvectors {:.1e}, phase shift {:.1e}, linear {:.1e}, pairs {:.1e}.\n",
            of_pi(setting.q.q()),
            setting.omega_tw,
            params_words(setting.params),
            wave.amplitude(),
            wave.mean(),
            self.beside(),
            wave.residual,
            wave.newton.len(),
            self.profile.closed(),
            nearness(self.kantorovich),
            self.spectrum.sites,
            self.spectrum.growing(),
            self.spectrum.multipliers.len(),
            quality.symplectic_defect,
            quality.eigen_residual,
            quality.phase_shift,
            quality.linear,
            quality.pairing,
        )
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let mut files = named([("exact.json", json.into())]);
        files.extend(tables(self).into_iter().map(|(name, bytes)| (name.to_owned(), bytes)));
        Ok(files)
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        use crate::figures::{Panels, panels};
        let caption = format!("{} {}", exact_caption(self), program());
        let title = format!("Exact travelling wave, q = {}", of_pi(self.wave.setting.q.q()));
        Ok(named([("exact.png", panels(&Panels { title, columns: exact_columns(self), caption })?)]))
    }
}

/// `profile.csv`, `fourier.csv` and `multipliers.csv`.
pub(crate) fn tables(study: &ExactStudy) -> Vec<(&'static str, Vec<u8>)> {
    let profile = &study.profile;
    // Without moving resonators there is no y.
    let at = |values: &[f64], k: usize| values.get(k).copied().unwrap_or(f64::NAN);
    let rows = profile.phases().enumerate().map(|(k, phi)| vec![phi, profile.x[k], at(&profile.y, k)]);
    let [fx, fy] = &study.fourier;
    let harmonics = fx.iter().enumerate().map(|(k, x)| vec![k as f64, *x, at(fy, k)]);
    let multiplier =
        |m: &WaveMultiplier| vec![m.bloch, m.re, m.im, m.modulus, m.error, f64::from(m.krein), m.growth, m.frequency];
    let names = ["bloch", "re", "im", "modulus", "error", "krein", "growth", "frequency"];
    vec![
        ("profile.csv", csv(&["phi", "x", "y"], rows)),
        ("fourier.csv", csv(&["k", "x", "y"], harmonics)),
        ("multipliers.csv", csv(&names, study.spectrum.multipliers.iter().map(multiplier))),
    ]
}

/// What the theorem of Newton and Kantorovich says, in a line.
pub(crate) fn nearness(found: Option<Kantorovich>) -> String {
    match found {
        Some(Kantorovich { radius: Some(radius), inverse, hoelder, exponent, .. }) => format!(
            "Newton-Kantorovich: a solution within {radius:.1e} of the amplitude (|A| = {inverse:.1e}, kappa = {hoelder:.1e}, p = {exponent})"
        ),
        Some(Kantorovich { correction, inverse, hoelder, exponent, .. }) => format!(
            "Newton-Kantorovich: no bound (|A F| = {correction:.1e}, |A| = {inverse:.1e}, kappa = {hoelder:.1e}, p = {exponent})"
        ),
        None => "Newton-Kantorovich: no bound, the equations are not independent".to_owned(),
    }
}

/// What the theorem says of a branch, in a line.
pub(crate) fn bounds(found: impl Iterator<Item = Option<Kantorovich>>) -> String {
    let radii: Vec<Option<f64>> = found.map(|one| one?.radius).collect();
    let known = radii.iter().flatten().count();
    let largest = radii.iter().flatten().fold(0.0, |most: f64, radius| most.max(*radius));
    let within = if known > 0 { format!(", within {largest:.1e} of the amplitude") } else { String::new() };
    format!("Newton-Kantorovich: a solution is near {known} of {} points{within}.", radii.len())
}

#[cfg(feature = "plot")]
fn program() -> String {
    format!("hertzchain {}.", env!("CARGO_PKG_VERSION"))
}

/// What a picture of a wave shows, with all numbers.
pub(crate) fn exact_caption(study: &ExactStudy) -> String {
    let wave = &study.wave;
    let fastest = study.spectrum.fastest().map_or("no multiplier grows".to_owned(), |fastest| {
        format!(
            "the fastest multiplier grows by {} a unit of time at p = {} π",
            shown(fastest.growth),
            shown(fastest.bloch / PI)
        )
    });
    let beside = match (study.ansatz, study.errors) {
        (Some(ansatz), Some([e_x, e_y])) => {
            let [amplitude, e_x, e_y] = [ansatz.amplitude(), e_x, e_y].map(shown);
            format!(", that of the ansatz {amplitude}, E_x = {e_x}, E_y = {e_y}")
        }
        _ => String::new(),
    };
    format!(
        "{}, q = {}, ω_tw = {}, mean strain {}, N = {}: amplitude {}{beside}, residual {:.0e}; {fastest}.",
        params_words(wave.setting.params),
        of_pi(wave.setting.q.q()),
        wave.setting.omega_tw,
        shown(wave.mean()),
        study.spectrum.sites,
        shown(wave.amplitude()),
        wave.residual,
    )
}

/// Profiles, and their differences from the ansatz; Fourier coefficients and growth.
#[cfg(feature = "plot")]
pub(crate) fn exact_columns(study: &ExactStudy) -> Vec<crate::figures::Column> {
    use crate::figures::{Column, Kind, Line, Panel};
    let over = |values: Vec<f64>| study.profile.phases().map(|phi| phi / PI).zip(values).collect::<Vec<_>>();
    let (x, y) = (&study.profile.x, &study.profile.y);
    let phase = "phase φ/π";
    let lines = |names: [&str; 2], x: Vec<f64>, y: Vec<f64>| -> Vec<Line> {
        let both = names.into_iter().zip([x, y]).filter(|(_, values)| !values.is_empty());
        both.map(|(name, values)| Line::new(name, over(values))).collect()
    };
    let mut profiles =
        vec![Panel::new(Kind::Time, [phase, "strain"], lines(["X exact", "Y exact"], x.clone(), y.clone()))];
    if let Some(ansatz) = study.ansatz {
        let (mean, height) = (ansatz.epsilon() * ansatz.shape().b, ansatz.amplitude());
        let first = |height: f64| study.profile.phases().map(move |phi| mean + height * phi.cos());
        let apart = |values: &[f64], height: f64| -> Vec<f64> {
            values.iter().zip(first(height)).map(|(exact, first)| 100.0 * (exact - first) / height.abs()).collect()
        };
        let differences = lines(["X", "Y"], apart(x, height), apart(y, -height / ansatz.params().rho));
        profiles.push(Panel::new(Kind::Time, [phase, "exact − ansatz, % of amplitude"], differences));
    }
    vec![Column::new("", profiles), Column::new("", [fourier_panel(study), growth_panel(&study.growth)])]
}

/// `|f_k|/f_1` of `X`, beside the power that a jump of the contact force's derivatives makes.
#[cfg(feature = "plot")]
fn fourier_panel(study: &ExactStudy) -> crate::figures::Panel {
    use crate::figures::{Kind, Line, Panel};
    let (fourier, alpha) = (&study.fourier[0], study.wave.setting.params.alpha);
    // Harmonics that are a multiple of the cell vanish, up to roundings.
    let seen = (1..fourier.len()).filter(|k| !k.is_multiple_of(study.wave.setting.q.cell()));
    let of = |k: usize| (k as f64, (fourier[k] / fourier[1]).abs());
    let law = (1..fourier.len()).map(|k| (k as f64, (k as f64).powf(-alpha - 3.0)));
    let lines = vec![Line::new("|f_k|/f₁ of X", seen.map(of)), Line::new(&format!("k^−{}", alpha + 3.0), law)];
    Panel::new(Kind::LogLog, ["harmonic k", "coefficient"], lines)
}

/// Growth against the Bloch wave number, exact and by the modulation equations.
#[cfg(feature = "plot")]
fn growth_panel(growth: &[BlochGrowth]) -> crate::figures::Panel {
    use crate::figures::{Kind, Line, Panel};
    let line = |name: &str, of: fn(&BlochGrowth) -> Option<f64>| {
        Line::new(name, growth.iter().filter_map(|row| Some((row.bloch / PI, of(row)?))))
    };
    let lines = vec![line("exact", |row| Some(row.exact)), line("DpS", |row| row.modulation)];
    let lines = lines.into_iter().filter(|line| !line.points.is_empty()).collect();
    Panel::new(Kind::Parameter, ["Bloch wave number p/π", "growth per unit of time"], lines)
}

impl WaveBranchStudy {
    /// Value of the parameter.
    fn at(&self, one: &BranchWave) -> f64 {
        self.continuation.parameter.of(&one.wave)
    }

    /// The number of waves, and why the branch ended, in words.
    fn words(&self) -> String {
        format!("{} waves; the branch ends because {}.", self.waves.len(), self.end.words())
    }
}

impl Report for WaveBranchStudy {
    fn json(&self) -> Value {
        let row = |one: &BranchWave| {
            let mut value = wave_json(&one.wave);
            let fastest = one.spectrum.fastest();
            value["growth"] = json!(fastest.map_or(0.0, |fastest| fastest.growth));
            value["bloch"] = json!(fastest.map(|fastest| fastest.bloch));
            value["growing"] = json!(one.spectrum.growing());
            value["modulation"] = json!(one.modulation);
            value["e_x_ansatz"] = json!(one.errors.map(|errors| errors[0]));
            value["e_y_ansatz"] = json!(one.errors.map(|errors| errors[1]));
            value["closed"] = json!(one.closed);
            value["quality"] = json!(one.spectrum.quality);
            value["kantorovich"] = json!(one.kantorovich);
            value
        };
        json!({
            "scene": self.scene,
            "parameter": self.continuation.parameter,
            "to": self.continuation.to,
            "sites": self.sites,
            "waves": self.waves.iter().map(row).collect::<Vec<_>>(),
            "end": self.end,
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self) -> String {
        let symbol = serde_json::to_value(self.continuation.parameter).ok();
        let name = symbol.as_ref().and_then(Value::as_str).unwrap_or_default().to_owned();
        let rows: Vec<Vec<String>> = self
            .waves
            .iter()
            .map(|one| {
                let growth = one.spectrum.fastest().map_or(0.0, |fastest| fastest.growth);
                let optional = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.3e}"));
                vec![
                    format!("{:.9}", self.at(one)),
                    format!("{:.9}", one.wave.setting.omega_tw),
                    format!("{:.6e}", one.wave.amplitude()),
                    format!("{:.6e}", one.wave.mean()),
                    format!("{growth:.4e}"),
                    optional(one.modulation),
                    optional(one.errors.map(|errors| errors[0])),
                    format!("{:.4}", one.closed),
                ]
            })
            .collect();
        let head = [name.as_str(), "omega_tw", "amplitude", "mean", "growth", "DpS", "E_x", "closed"];
        format!("{}\n{}\n{}\n", table(&head, &rows), self.words(), bounds(self.waves.iter().map(|one| one.kantorovich)))
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let waves: Vec<&ExactWave> = self.waves.iter().map(|one| &one.wave).collect();
        Ok(named([("waves.json", json.into()), ("waves.csv", branch_csv(self)), (STATES, states_npz(&waves)?)]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        use crate::figures::{Panels, panels};
        let symbol = self.continuation.parameter.symbol();
        let params = self.waves.first().map_or(String::new(), |one| params_words(one.wave.setting.params));
        let caption = format!("{params} at the first wave, N = {}. {} {}", self.sites, self.words(), program());
        let title = format!("Branch of exact travelling waves in {symbol}");
        Ok(named([("waves.png", panels(&Panels::column(title, branch_plots(self), caption))?)]))
    }

    fn succeeded(&self) -> bool {
        !matches!(self.end, WaveEnd::Lost | WaveEnd::Jumped)
    }
}

/// Amplitude, and largest growth beside that of the modulation equations.
#[cfg(feature = "plot")]
pub(crate) fn branch_plots(study: &WaveBranchStudy) -> Vec<crate::figures::Panel> {
    use crate::figures::{Kind, Line, Panel};
    let symbol = study.continuation.parameter.symbol();
    let line = |name: &str, of: &dyn Fn(&BranchWave) -> Option<f64>| {
        Line::new(name, study.waves.iter().filter_map(|one| Some((study.at(one), of(one)?))))
    };
    let growth = |one: &BranchWave| one.spectrum.fastest().map(|fastest| fastest.growth);
    let panel = |kind, label: &str, lines| Panel::new(kind, [symbol, label], lines);
    let grows = [line("exact", &growth), line("DpS", &|one| one.modulation.filter(|growth| *growth > 0.0))];
    let errors = vec![
        line("E_x", &|one| one.errors.map(|errors| errors[0])),
        line("E_y", &|one| one.errors.map(|errors| errors[1])),
    ];
    vec![
        panel(Kind::Parameter, "amplitude", vec![line("amplitude", &|one| Some(one.wave.amplitude()))]),
        panel(Kind::LogParameter, "largest growth", grows.into_iter().filter(|line| !line.points.is_empty()).collect()),
        panel(Kind::LogParameter, "error of the ansatz", errors),
    ]
}

/// `waves.csv`: a row for each wave.
pub(crate) fn branch_csv(study: &WaveBranchStudy) -> Vec<u8> {
    let names = [
        "parameter",
        "omega_tw",
        "amplitude",
        "mean_strain",
        "residual",
        "growth",
        "bloch",
        "growing",
        "modulation",
        "e_x_ansatz",
        "e_y_ansatz",
        "closed",
        "radius",
    ];
    let row = |one: &BranchWave| {
        let fastest = one.spectrum.fastest();
        let [e_x, e_y] = one.errors.unwrap_or([f64::NAN; 2]);
        vec![
            study.at(one),
            one.wave.setting.omega_tw,
            one.wave.amplitude(),
            one.wave.mean(),
            one.wave.residual,
            fastest.map_or(0.0, |fastest| fastest.growth),
            fastest.map_or(f64::NAN, |fastest| fastest.bloch),
            one.spectrum.growing() as f64,
            one.modulation.unwrap_or(f64::NAN),
            e_x,
            e_y,
            one.closed,
            one.kantorovich.and_then(|found| found.radius).unwrap_or(f64::NAN),
        ]
    };
    csv(&names, study.waves.iter().map(row))
}

/// `states.npz`: settings and states of a cell, a row for each wave.
pub(super) fn states_npz(waves: &[&ExactWave]) -> Result<Vec<u8>> {
    let of = |value: fn(&ExactWave) -> f64| waves.iter().map(|wave| value(wave)).collect::<Vec<f64>>();
    let arrays = [
        Array::vector("omega_tw", of(|wave| wave.setting.omega_tw)),
        Array::vector("alpha", of(|wave| wave.setting.params.alpha)),
        Array::vector("kappa", of(|wave| wave.setting.params.kappa)),
        Array::vector("rho", of(|wave| wave.setting.params.rho)),
        Array::vector("residual", of(|wave| wave.residual)),
        Array::matrix("z", waves.iter().map(|wave| wave.z.as_slice())),
    ];
    let cell = waves.first().map_or(0, |wave| wave.setting.q.cell());
    let turns = waves.first().map_or(0, |wave| wave.setting.q.turns());
    let moving = waves.first().is_none_or(|wave| wave.z.len() == 4 * cell);
    let order = if moving { "x, y, vx, vy" } else { "x, vx" };
    let what = json!({ "format": "hertzchain waves", "version": 1, "cell": cell, "turns": turns, "z": order });
    npz_with(crate::output::SETTINGS, &to_json(&what), &arrays)
}
