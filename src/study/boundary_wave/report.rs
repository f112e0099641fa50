//! Waves launched from one end as text, JSON, CSV and a picture.

use super::{ALPHA, BoundaryWaveStudy, KAPPA, LaunchedWave, TOLERANCE};
use crate::{
    error::Result,
    output::csv,
    present::table,
    study::{File, Report, named},
};
use serde_json::{Value, json};

const COLUMNS: [&str; 8] = ["omega", "q", "q_theory", "amplitude", "mean_strain", "spread", "opens", "end"];

fn row(wave: &LaunchedWave) -> [f64; 8] {
    let &LaunchedWave { omega, end, mean_strain, amplitude, spread, opens, q, q_theory, .. } = wave;
    let q_theory = q_theory.unwrap_or(f64::NAN);
    [omega, q, q_theory, amplitude, mean_strain, spread, f64::from(u8::from(opens)), end]
}

impl Report for BoundaryWaveStudy {
    fn json(&self) -> Value {
        json!({
            "alpha": ALPHA,
            "kappa": KAPPA,
            "rho": self.options.rho,
            "sites": self.options.sites,
            "drive_amplitude": self.options.drive,
            "overlap": self.options.overlap,
            "integrator": "collocation",
            "tol": TOLERANCE,
            "waves": self.waves,
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self) -> String {
        let cells = |wave: &LaunchedWave| {
            let theory = wave.q_theory.map_or("–".to_owned(), |q| format!("{q:.4}"));
            let opens = if wave.opens { "open" } else { "closed" };
            vec![
                wave.omega.to_string(),
                format!("{:.4}", wave.q),
                theory,
                format!("{:.3e}", wave.amplitude),
                format!("{:.3e}", wave.mean_strain),
                format!("{:.3}", wave.spread),
                opens.to_owned(),
            ]
        };
        let rows: Vec<_> = self.waves.iter().map(cells).collect();
        format!(
            "{}\nq: wave number, measured; theory: of the first-order wave of this frequency, amplitude and mean strain \
             (none beyond its band). Amplitude and mean of the strain, and the spread of the amplitude over the \
             measured bonds: where it is large the wave is not uniform. Contacts: whether measured ones open.\n",
            table(&["omega", "q", "theory", "amplitude", "mean strain", "spread", "contacts"], &rows)
        )
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let strains = self.waves.iter().flat_map(|wave| {
            wave.bonds.iter().map(|one| vec![wave.omega, one.bond as f64, one.mean, one.amplitude, one.angle])
        });
        Ok(named([
            ("boundary-wave.csv", csv(&COLUMNS, self.waves.iter().map(|wave| row(wave).to_vec()))),
            ("strains.csv", csv(&["omega", "bond", "mean", "amplitude", "angle"], strains)),
            ("boundary-wave.json", json.into()),
        ]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(named([("boundary-wave.png", self.picture()?)]))
    }
}

impl BoundaryWaveStudy {
    /// Wave number and mean strain against frequency; amplitude and mean strain along the chain.
    #[cfg(feature = "plot")]
    fn picture(&self) -> Result<crate::figures::Picture> {
        use super::{ABSORBING, PERIODS, RAMP};
        use crate::figures::{Column, Kind, Line, Panel, Panels, panels};
        let q = self.waves.iter().map(|wave| (wave.omega, wave.q));
        let theory = self.waves.iter().filter_map(|wave| Some((wave.omega, wave.q_theory?)));
        let along = |of: fn(&super::BondStrain) -> f64| -> Vec<Line> {
            let line = |wave: &LaunchedWave| {
                Line::new(&format!("ω = {}", wave.omega), wave.bonds.iter().map(move |one| (one.bond as f64, of(one))))
            };
            self.waves.iter().map(line).collect()
        };
        let numbers = vec![Line::new("measured", q), Line::new("first-order wave", theory)];
        let means = self.waves.iter().map(|wave| (wave.omega, wave.mean_strain));
        let left = vec![
            Panel::new(Kind::Parameter, ["drive frequency ω", "wave number q"], numbers),
            Panel::new(Kind::Parameter, ["drive frequency ω", "mean strain"], vec![Line::new("measured", means)]),
        ];
        let right = vec![
            Panel::new(Kind::Parameter, ["bond n", "amplitude of the strain"], along(|one| one.amplitude)),
            Panel::new(Kind::Parameter, ["bond n", "mean strain"], along(|one| one.mean)),
        ];
        let options = &self.options;
        let caption = format!(
            "N = {} sites between walls, α = {ALPHA}, κ = {KAPPA}, ρ = {:.4}, static overlap {}. The first bead has no \
             resonator and is moved with the amplitude {}, after a ramp of {RAMP} periods; dashpots in the last {ABSORBING} \
             sites. Means and first harmonics over the last {PERIODS} periods. Theory: (eq:w_tw) with the measured \
             frequency, amplitude and mean strain. Collocation, tolerance {TOLERANCE:e}. hertzchain {}.",
            options.sites,
            options.rho,
            options.overlap,
            options.drive,
            env!("CARGO_PKG_VERSION")
        );
        let title = "Travelling waves launched from one end".to_owned();
        Ok(panels(&Panels { title, columns: vec![Column::new("", left), Column::new("", right)], caption })?)
    }
}
