//! Solitary waves as text, JSON, files and pictures.

use super::{SolitaryStudy, Tail};
use crate::{
    error::Result,
    number::shown,
    output::csv,
    present::table,
    study::{File, Report, named},
};
use serde_json::{Value, json};
use std::f64::consts::PI;

impl Report for SolitaryStudy {
    fn json(&self) -> Value {
        let row = |tail: &Tail| {
            let wave = tail.wave.as_ref();
            json!({
                "rho": tail.rho,
                "k_over_2pi": tail.k / (2.0 * PI),
                "sites": wave.map(|wave| wave.wave.setting.q.cell()),
                "crest": wave.map(|wave| wave.crest()),
                "residual": wave.map(|wave| wave.wave.residual),
                "tail": wave.map(|wave| wave.tail()),
                "wake": wave.map(|wave| wave.wake()),
                "wake_of_line": tail.line,
            })
        };
        let hertz = &self.hertz;
        json!({
            "alpha": self.options.alpha,
            "kappa": self.options.kappa,
            "sites": self.options.sites,
            "speed": hertz.speed,
            "crest": hertz.crest(),
            "coefficient": hertz.coefficient(),
            "coefficient_of_line": self.line.coefficient(),
            "residual": hertz.wave.residual,
            "apart": self.apart(),
            "x": hertz.wave.on_ring(self.options.sites)[0],
            "vx": hertz.wave.on_ring(self.options.sites)[2],
            "pulse": self.decay,
            "decay_slope": self.decay_slope(),
            "ln_alpha": self.options.alpha.ln(),
            "tails": self.tails.iter().map(row).collect::<Vec<_>>(),
            "fit": self.fit,
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self) -> String {
        let hertz = &self.hertz;
        let overlaps: Vec<Vec<String>> = self
            .decay
            .iter()
            .enumerate()
            .map(|(n, g)| vec![n.to_string(), format!("{g:.12e}"), format!("{:.6}", g.ln().abs().ln())])
            .collect();
        let rows: Vec<Vec<String>> = self.tails.iter().map(row).collect();
        let head = ["rho", "k/2pi", "N", "crest", "residual", "tail", "wake W", "W of the line"];
        let fit =
            self.fit.map_or("No fit: fewer than three wakes from 1e-12 to 1e-3 of the crest.".to_owned(), |fit| {
                format!(
                    "ln(W k/(4 sin^2(k/2) g)) = {:.4} - {:.4} k to {:.2}, from {} pulses.",
                    fit.constant, fit.width, fit.residual, fit.points
                )
            });
        format!(
            "Without resonators: x_{{n+1}}(t + 1/c) = x_n(t), alpha = {}, c = {}, largest overlap g = {:.12}\n\
             c = C g^((alpha-1)/2), C = {:.12}; on the line {:.12}\n\
             residual {:.1e}, distance from the line {:.1e} of the crest, {} sites\n\n{}\n\
             slope of ln|ln(g_n/g_0)| between the last two {:.6}, ln alpha = {:.6}\n\n\
             With resonators, kappa = {}:\n{}\n{fit}\n",
            self.options.alpha,
            hertz.speed,
            hertz.crest(),
            hertz.coefficient(),
            self.line.coefficient(),
            hertz.wave.residual,
            self.apart(),
            self.options.sites,
            table(&["n", "g_n/g_0", "ln|ln|"], &overlaps),
            self.decay_slope(),
            self.options.alpha.ln(),
            self.options.kappa,
            table(&head, &rows),
        )
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        let mut files = named([("solitary.json", json.into())]);
        files.extend(tables(self).into_iter().map(|(name, bytes)| (name.to_owned(), bytes)));
        Ok(files)
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        use crate::figures::{Panels, panels};
        let caption = format!("{} hertzchain {}.", caption(self), env!("CARGO_PKG_VERSION"));
        let title = "Solitary waves".to_owned();
        Ok(named([("solitary.png", panels(&Panels { title, columns: columns(self), caption })?)]))
    }

    fn remark(&self) -> Option<String> {
        let lost: Vec<String> = self.tails.iter().filter(|tail| tail.wave.is_none()).map(|t| shown(t.rho)).collect();
        (!lost.is_empty()).then(|| format!("error: no wave was found at rho = {}", lost.join(", ")))
    }

    /// The waves that were found are written, but one that was not found is a failure.
    fn succeeded(&self) -> bool {
        self.tails.iter().all(|tail| tail.wave.is_some())
    }
}

fn row(tail: &Tail) -> Vec<String> {
    let mut cells = vec![format!("{:.6e}", tail.rho), format!("{:.4}", tail.k / (2.0 * PI))];
    cells.extend(tail.wave.as_ref().map_or_else(
        || ["", "not found", "", "", ""].map(str::to_owned),
        |wave| {
            [
                wave.wave.setting.q.cell().to_string(),
                format!("{:.8}", wave.crest()),
                format!("{:.1e}", wave.wave.residual),
                format!("{:.4e}", wave.tail()),
                format!("{:.4e}", wave.wake()),
            ]
        },
    ));
    cells.push(format!("{:.4e}", tail.line));
    cells
}

/// `pulse.csv` and `tails.csv`.
pub(crate) fn tables(study: &SolitaryStudy) -> Vec<(&'static str, Vec<u8>)> {
    let pulse = study.decay.iter().enumerate().map(|(n, g)| vec![n as f64, *g]);
    let tail = |tail: &Tail| {
        let of = |of: &dyn Fn(&crate::waves::SolitaryWave) -> f64| tail.wave.as_ref().map_or(f64::NAN, of);
        vec![
            tail.rho,
            tail.k / (2.0 * PI),
            of(&|wave| wave.wave.setting.q.cell() as f64),
            of(&|wave| wave.crest()),
            of(&|wave| wave.tail()),
            of(&|wave| wave.wake()),
            tail.line,
        ]
    };
    let names = ["rho", "k_over_2pi", "sites", "crest", "tail", "wake", "wake_of_line"];
    vec![("pulse.csv", csv(&["n", "g"], pulse)), ("tails.csv", csv(&names, study.tails.iter().map(tail)))]
}

/// What the picture shows, with all numbers.
pub(crate) fn caption(study: &SolitaryStudy) -> String {
    let fit = study.fit.map_or(String::new(), |fit| {
        format!(
            " Fit: ln(W k/(4 sin²(k/2) g)) = {:.3} − {:.4} k to {:.2}, over {} pulses with W from 10⁻¹² to 10⁻³ of the crest g and |sin(k/2)| ≥ 0.1.",
            fit.constant, fit.width, fit.residual, fit.points
        )
    });
    format!(
        "α = {}, κ = {}, speed c = {:.9}, N = {} and up to 3 more. Without resonators c = C g^((α−1)/2) with C = {:.9}; slope of ln|ln(gₙ/g₀)| at the end {:.4}, ln α = {:.4}. \
         W: amplitude of xₙ − yₙ that one passage leaves behind, from the tails of the exact wave of the ring; line: from the Fourier transform of the plain pulse for beads of mass 1 + ρ; k = ω/c.{fit}",
        study.options.alpha,
        study.options.kappa,
        study.hertz.speed,
        study.options.sites,
        study.hertz.coefficient(),
        study.decay_slope(),
        study.options.alpha.ln(),
    )
}

/// The pulse and its decay; the wakes against the phase of a resonator and their fit.
#[cfg(feature = "plot")]
pub(crate) fn columns(study: &SolitaryStudy) -> Vec<crate::figures::Column> {
    use crate::figures::{Column, Kind, Line, Panel};
    let crest = study.line.at(0.0)[0];
    let shape = (0..=400).map(|i| 0.01 * f64::from(i) - 2.0).map(|xi| (1.5 * xi, study.line.at(1.5 * xi)[0] / crest));
    let (z, m) = (&study.hertz.wave.z, study.options.sites);
    let sites = [3, 2, 1].map(|n| (-(n as f64), -z[m - n])).into_iter().chain((0..=3).map(|n| (n as f64, -z[n])));
    let sites = sites.map(|(n, g)| (n, g / study.hertz.crest()));
    let double_log = study.decay.iter().enumerate().skip(1).map(|(n, g)| (n as f64, g.ln().abs().ln()));
    let last = study.decay.len() - 1;
    let end = study.decay[last].ln().abs().ln();
    let law = (1..=last).map(|n| (n as f64, end - (last - n) as f64 * study.options.alpha.ln()));
    let pulse = vec![Line::new("on the line", shape), Line::new("exact wave of the ring", sites)];
    let decay = vec![Line::new("ln|ln(gₙ/g₀)|", double_log), Line::new("slope ln α", law)];
    let place = |tail: &Tail| tail.k / (2.0 * PI);
    let found = || study.tails.iter().filter_map(|tail| Some((tail, tail.wave.as_ref()?)));
    let exact = found().map(|(tail, wave)| (place(tail), wave.wake() / wave.crest()));
    let line = found().map(|(tail, wave)| (place(tail), tail.line / wave.crest()));
    let mut wakes = vec![Line::new("exact", exact), Line::new("line", line)];
    if let Some(fit) = study.fit {
        let of = |k: f64| 4.0 * (0.5 * k).sin().powi(2) / k * (fit.constant - fit.width * k).exp();
        wakes.push(Line::new("fit", study.tails.iter().map(|tail| (place(tail), of(tail.k)))));
    }
    let crests = found().map(|(tail, wave)| (tail.rho, wave.crest()));
    vec![
        Column::new(
            "without resonators",
            [
                Panel::new(Kind::Cloud, ["sites from the crest", "overlap g/g₀"], pulse),
                Panel::new(Kind::Parameter, ["site n", "decay of the overlap"], decay),
            ],
        ),
        Column::new(
            "with resonators",
            [
                Panel::new(Kind::LogParameter, ["phase k/2π of a resonator a site", "wake W/g"], wakes),
                Panel::new(Kind::Parameter, ["mass ratio ρ", "largest overlap g"], vec![Line::new("g", crests)]),
            ],
        ),
    ]
}
