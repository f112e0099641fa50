//! Bright breathers that travel under a static load, as exact orbits, over their amplitude.

#[cfg(feature = "cli")]
use crate::study::OF_WINDOWS;
use crate::study::{ChainParams, Progress, Study, Work, options::options, params_words};
use crate::{
    breathers::{Relative, Sizes, TravellingBreather},
    chain::Params,
    error::Result,
    report::{
        Digits::{Fixed, Hidden, Json, Power},
        Kind, Panels, Report, fields, rows,
    },
    sweep::{Engine, Grid, Missing},
};
use serde::{Deserialize, Serialize};

options! {
    /// Travelling bright breathers as relative periodic orbits.
    pub struct Travelling {
        /// Amplitudes of the breathers, in displacements of beads.
        ///
        /// Separated by commas: those of the solitons of the nonlinear Schrödinger equation from
        /// which the orbits are sought. Strains stay below the precompression.
        amplitude: Vec<f64> = vec![0.4, 0.5, 0.6, 0.7, 0.8], "A,..", (positive);
        /// Waves that pass the breather as it moves on by a site.
        ///
        /// With the amplitude it gives the wave number and the velocity.
        turns: u32 = 1, "K", (1 to 100);
        /// Number of sites.
        ///
        /// The ring has an odd number of sites, at least six widths of the breather. Tails depend
        /// on it.
        sites: usize = 151, "N", (9 to 255);
        /// The chain.
        params: ChainParams = ChainParams::default(), [command(flatten)];
        /// Static overlap D of the contacts.
        precompression: f64 = 1.0, "D", (positive);
        /// Tolerance.
        tol: f64 = 1e-14, "T", (RUN), [arg(long_help = OF_WINDOWS)];
    }
}

rows! {
    /// A travelling breather.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    pub struct TravellingRow {
        /// Amplitude of the soliton, in displacements.
        soliton: f64 => Fixed(4),
        /// Phase from bead to bead over pi.
        q_over_pi: f64 => Fixed(6),
        /// Sites per unit of time.
        velocity: f64 => Fixed(6),
        /// Frequency at the breather's centre, which is fixed.
        omega_b: f64 => Fixed(6),
        /// Residual of the equations.
        residual: f64 => Power(1),
        /// Distance from the orbit after a passage.
        return_error: f64 => Power(1),
        /// Largest r = ((x - mean)^2 + (x'/omega_b)^2)^(1/2).
        amplitude: f64 => Fixed(6),
        /// That of the soliton.
        soliton_strain: f64 => Hidden,
        /// Width w of sech(n/w), in sites.
        width: f64 => Fixed(4),
        /// That of the soliton.
        soliton_width: f64 => Fixed(4),
        /// Largest r opposite to the breather, over the amplitude.
        tail: f64 => Power(2),
        /// That of the soliton there.
        soliton_tail: f64 => Power(2),
        /// Largest modulus of a multiplier.
        max_modulus: f64 => Fixed(6),
        /// Strains at t = 0.
        x: Vec<f64> => Json,
    }
}

impl Travelling {
    fn breathers(&self) -> Result<Vec<TravellingBreather>> {
        self.within_ranges()?;
        let (params, &Self { sites, turns, precompression, .. }) = (self.params.checked()?, self);
        let of = |&amplitude: &f64| TravellingBreather::new(params, sites, precompression, turns, amplitude);
        self.amplitude.iter().map(of).collect()
    }

    /// The breathers of all amplitudes, on all cores, and those that are not found.
    ///
    /// # Errors
    /// An option outside its rule; no breather is found; a signal.
    pub fn study(&self, engine: &Engine, progress: Progress<'_>) -> Result<(Vec<TravellingRow>, Missing)> {
        self.breathers()?;
        let &Self { params, sites, turns, precompression, tol, .. } = self;
        let settings = fields!(self => sites; params => alpha, kappa, rho; self => turns, precompression, tol);
        let grid = Grid { store: Self::STORE, study: "travelling", settings };
        let swept = engine.sweep(&grid, &self.amplitude, progress, |&amplitude| {
            row(&TravellingBreather::new(params.into(), sites, precompression, turns, amplitude)?, amplitude, tol)
        })?;
        swept.found(&self.amplitude, |amplitude| format!("amplitude {amplitude}"))
    }

    fn report(&self, rows: &[TravellingRow], missing: &[(String, String)]) -> Report {
        let table = TravellingRow::table("travelling", rows).done();
        let panel = |kind, label: &str, lines: &[(&str, &str)]| {
            table.panel(kind, ["amplitude of the soliton", label], "soliton", lines)
        };
        let plots = vec![
            panel(Kind::Parameter, "largest r", &[("orbits", "amplitude"), ("soliton", "soliton_strain")]),
            panel(Kind::Parameter, "width, sites", &[("orbits", "width"), ("soliton", "soliton_width")]),
            panel(Kind::LogParameter, "tail / amplitude", &[("orbits", "tail"), ("soliton", "soliton_tail")]),
            panel(Kind::Parameter, "largest |λ|", &[("orbits", "max_modulus")]),
        ];
        let params = Params::from(self.params);
        let caption = format!(
            "Bright breathers that travel under the precompression {}, {}, N = {}, turns = {}: largest \
             r = ((x − mean)² + (x′/ω_b)²)^½, width, tail opposite to the breather, largest modulus of a multiplier.",
            self.precompression,
            params_words(params),
            self.sites,
            self.turns
        );
        let report = Report::new("travelling").facts(params).fact("sites", self.sites).fact("turns", self.turns);
        let report = report.fact("precompression", self.precompression).fact("tol", self.tol).table(table);
        report.missing(missing).picture(Panels::column("Travelling bright breathers", plots, caption))
    }
}

fn row(breather: &TravellingBreather, soliton: f64, tol: f64) -> Result<TravellingRow> {
    let (orbit, (wave, form)) = (breather.orbit(tol)?, breather.soliton());
    let (Sizes { amplitude, width, tail }, setting) = (orbit.sizes(), breather.setting());
    Ok(TravellingRow {
        soliton,
        q_over_pi: wave.theta / std::f64::consts::PI,
        velocity: breather.velocity(),
        omega_b: setting.omega_b,
        residual: orbit.residual,
        return_error: orbit.return_error(tol)?,
        amplitude,
        soliton_strain: 2.0 * soliton * (0.5 * wave.theta).sin(),
        width,
        soliton_width: form.width(),
        tail,
        soliton_tail: 1.0 / (0.4375 * setting.sites as f64 / form.width()).cosh(),
        max_modulus: orbit.spectrum(tol)?.largest(),
        x: orbit.z[..setting.sites].to_vec(),
    })
}

impl Study for Travelling {
    const STORE: &'static str = "travelling.store";

    fn outline() -> Option<Report> {
        Some(Self::default().report(&[], &[]))
    }

    fn begin(&self) -> Result<Work<'_>> {
        self.breathers()?;
        Ok(Box::new(|engine, progress| {
            let (rows, missing) = self.study(engine, progress)?;
            Ok(self.report(&rows, &missing))
        }))
    }
}
