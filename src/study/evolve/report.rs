//! The evolution of an orbit as text, JSON, CSV and a picture.

use super::Evolution;
use crate::{
    error::Result,
    output::csv,
    present::table,
    study::{File, Report, named},
};
use serde_json::{Value, json};

/// Rows of the table, besides the last.
const ROWS: usize = 20;

impl Report for Evolution {
    /// Times, return errors and positions are lists with one number a period.
    fn json(&self) -> Value {
        let setting = self.orbit.setting;
        let motion = self.motion.iter().map(
            |one| json!({ "from": one.window.0, "to": one.window.1, "velocity": one.velocity, "misfit": one.misfit }),
        );
        json!({
            "alpha": setting.params.alpha,
            "kappa": setting.params.kappa,
            "omega_b": setting.omega_b,
            "rho": setting.params.rho,
            "sites": setting.sites,
            "period": setting.period(),
            "kick": self.kick.map(|(kick, lambda)| json!({ "size": kick.size, "mode": kick.mode, "re": lambda.re, "im": lambda.im })),
            "t": self.times,
            "e_b": self.e_b,
            "position": self.position,
            "motion": motion.collect::<Vec<_>>(),
            "amplification": self.amplification,
            "failure": self.failure,
            "integrator": "collocation",
            "tol": self.tol,
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self) -> String {
        let count = self.times.len();
        let shown = (0..count).filter(|m| m % count.div_ceil(ROWS).max(1) == 0 || m + 1 == count);
        let rows: Vec<Vec<String>> = shown
            .map(|m| {
                let (t, e_b, position) = (self.times[m], self.e_b[m], self.position[m]);
                vec![m.to_string(), format!("{t:.4}"), format!("{e_b:.6e}"), format!("{position:.6}")]
            })
            .collect();
        let kick = self.kick.map_or("not kicked".to_owned(), |(kick, lambda)| {
            format!("kicked by {:e} of its amplitude along multiplier {} = {lambda:.9}", kick.size, kick.mode)
        });
        let motion: String = self
            .motion
            .iter()
            .map(|one| {
                let (from, to) = one.window;
                format!(
                    "velocity from t = {from:.1} to {to:.1}: {:.6e} sites per unit of time, positions within {:.1e}\n",
                    one.velocity, one.misfit
                )
            })
            .collect();
        let failure = self.failure.as_ref().map_or(String::new(), |why| format!("the run ended early: {why}\n"));
        table(&["period", "t", "E_b", "kink at n"], &rows)
            + &format!(
                "\n{kick}\n{motion}small perturbations, also rounding errors, grow by a factor of at least {:.1e} in this run\n{failure}",
                self.amplification
            )
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let json = format!("{json}\n").into();
        let mut files = named([("evolution.json", json), ("evolution.csv", evolution_csv(self))]);
        files.extend(swing_csv(self).into_iter().map(|(name, table)| (format!("evolution-{name}"), table)));
        Ok(files)
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(named([("evolution.png", picture(self)?)]))
    }

    fn succeeded(&self) -> bool {
        self.failure.is_none()
    }
}

/// `evolution.csv`: time, `E_b` and position, a line a period.
pub(crate) fn evolution_csv(study: &Evolution) -> Vec<u8> {
    let rows = study.times.iter().zip(&study.e_b).zip(&study.position);
    csv(&["t", "e_b", "position"], rows.map(|((&t, &e_b), &position)| vec![t, e_b, position]))
}

/// Largest strains in time, `evolution-x.csv` and `evolution-y.csv` without their first word: the
/// middle of the time that a row covers, then a column a site.
pub(crate) fn swing_csv(study: &Evolution) -> Vec<(&'static str, Vec<u8>)> {
    let sites = study.orbit.setting.sites;
    let half = (sites / 2) as i64;
    let matrix = |symbol: &str, values: &[f64]| {
        let names = (-half..=half).map(|n| format!("{symbol}_{n}"));
        let names: Vec<String> = std::iter::once("t".to_owned()).chain(names).collect();
        let rows = (0..).zip(values.chunks(sites)).map(|(k, row)| {
            let middle = (f64::from(k) + 0.5) * study.swing.span;
            std::iter::once(middle).chain(row.iter().copied()).collect()
        });
        csv(&names.iter().map(String::as_str).collect::<Vec<_>>(), rows)
    };
    vec![("x.csv", matrix("x", &study.swing.x)), ("y.csv", matrix("y", &study.swing.y))]
}

/// Largest strains over space and time, beads and resonators; the scale of colours ends at twice
/// the largest of the first row, so that the motion before a break-up stays visible.
#[cfg(feature = "plot")]
pub(crate) fn swing_maps(study: &Evolution) -> [crate::figures::SpaceTime; 2] {
    let sites = study.orbit.setting.sites;
    let span = study.swing.span;
    let map = |symbol: &str, values: &[f64]| {
        let most = 2.0 * crate::chain::max_norm(values[..sites].iter().copied());
        crate::figures::SpaceTime {
            site_label: "site n".into(),
            time_label: "time t".into(),
            value_label: format!("largest |{symbol}|"),
            values: values.to_vec(),
            most: Some(most),
            sites,
            first_site: -((sites / 2) as f64),
            times: (0.5 * span, ((values.len() / sites) as f64 - 0.5) * span),
            ..Default::default()
        }
    };
    [map("xₙ", &study.swing.x), map("yₙ", &study.swing.y)]
}

/// `evolution.png`: largest strains over space and time, return error and position of the kink in
/// time.
#[cfg(feature = "plot")]
fn picture(study: &Evolution) -> Result<crate::figures::Picture> {
    use crate::figures::{Column, Kind, Line, Panel, Panels, panels};
    let setting = study.orbit.setting;
    let time = |kind: Kind, label: &str, values: &[f64]| {
        let points = study.times.iter().copied().zip(values.iter().copied());
        Panel::new(kind, ["time t", label], vec![Line::new(label, points)])
    };
    // A zero has no place on a logarithmic axis: it is drawn below every rounding.
    let e_b: Vec<f64> = study.e_b.iter().map(|e_b| e_b.max(1e-17)).collect();
    let lines = [time(Kind::LogTime, "return error E_b", &e_b), time(Kind::Time, "kink at n", &study.position)];
    let kick = study.kick.map_or(String::new(), |(kick, lambda)| {
        format!(", kicked by {} of its amplitude along the mode of λ = {lambda:.6}", kick.size)
    });
    let caption = format!(
        "Orbit of ω_b = {}, {}, {} sites{kick}. Colours: largest strain of each period, up to twice that of the orbit; magenta: above. While rounding errors are small, they grow \
         by a factor of {:.1e} in this run. hertzchain {}.",
        setting.omega_b,
        crate::study::params_words(setting.params),
        setting.sites,
        study.amplification,
        env!("CARGO_PKG_VERSION")
    );
    let columns = vec![Column::new("", swing_maps(study)), Column::new("", lines)];
    Ok(panels(&Panels { title: "Run from a periodic orbit".into(), columns, caption })?)
}
