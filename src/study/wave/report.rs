//! Travelling waves as text, JSON, CSV and a picture.

use super::{Ensemble, Envelopes, Member, PerturbedRun, Spread, WaveStudy};
use crate::{
    error::Result,
    output::csv,
    present::table,
    study::{File, Report, scene_json},
};
use serde_json::{Value, json};

impl Report for WaveStudy {
    /// `e_x_*` and `e_y_*` are those of the unperturbed wave (eq:relerr_tw); `growth` is null
    /// without perturbation, and in runs shorter than two periods.
    fn json(&self) -> Value {
        let WaveStudy { scene, wave, errors, ensemble, .. } = self;
        let of_all = |quantity: fn(&Member) -> Option<f64>| {
            spread_json(ensemble.as_ref().and_then(|ensemble| ensemble.spread(quantity)))
        };
        let perturbed = self.perturbed.as_ref().map(|run| {
            json!({
                "zeta": run.wave.zeta(),
                "seed": run.wave.seed(),
                "e_x_final": last(&run.errors.x),
                "e_y_final": last(&run.errors.y),
                "e_x_max": largest(&run.errors.x),
                "e_y_max": largest(&run.errors.y),
                "tilde_e_x_start": run.difference.x[0],
                "tilde_e_y_start": run.difference.y[0],
                "tilde_e_x_final": last(&run.difference.x),
                "tilde_e_y_final": last(&run.difference.y),
                "tilde_e_x_max": largest(&run.difference.x),
                "tilde_e_y_max": largest(&run.difference.y),
                "flow_energy_change": run.flow_energy_change,
            })
        });
        let members = ensemble.as_ref().map_or(&[][..], |ensemble| &ensemble.members[..]);
        json!({
            "scene": scene.name(),
            "setting": self.setting,
            "epsilon": wave.epsilon(),
            "omega": wave.params().omega(),
            "omega_tw": wave.omega_tw(),
            "period": scene.period(),
            "t": scene.end(),
            "samples": self.t.len(),
            "e_x_final": last(&errors.x),
            "e_y_final": last(&errors.y),
            "e_x_max": largest(&errors.x),
            "e_y_max": largest(&errors.y),
            "growth": of_all(|member| member.growth_x),
            "growth_y": of_all(|member| member.growth_y),
            "rate": of_all(|member| member.rate),
            "seeds": members.iter().map(|member| member.seed).collect::<Vec<_>>(),
            "growth_of_seed": members.iter().map(|member| member.growth_x).collect::<Vec<_>>(),
            "rate_of_seed": members.iter().map(|member| member.rate).collect::<Vec<_>>(),
            "rate_residual_of_seed": members.iter().map(|member| member.rate_residual).collect::<Vec<_>>(),
            "missing": ensemble.as_ref().map_or(0, |ensemble| ensemble.missing),
            "perturbed": perturbed,
            "force_evaluations": self.stats.force_evaluations,
            "wall_s": self.wall.as_secs_f64(),
            "scene_file": scene_json(scene),
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self) -> String {
        let WaveStudy { scene, wave, errors, t, .. } = self;
        let percent = |value: f64| format!("{:.10}", 100.0 * value);
        let row = |name: &str, values: &[f64]| vec![name.to_owned(), percent(last(values)), percent(largest(values))];
        let mut text = format!(
            "scene {}: {}\n{}\nepsilon = {:.16e}, omega = {:.16}, omega_tw = {:.16}, period = {:.16}\n\n",
            scene.name(),
            scene.file().summary,
            self.setting,
            wave.epsilon(),
            wave.params().omega(),
            wave.omega_tw(),
            scene.period()
        );
        let mut rows = vec![row("E_x", &errors.x), row("E_y", &errors.y)];
        if let Some(PerturbedRun { errors, difference, .. }) = &self.perturbed {
            rows.push(row("E_x, perturbed", &errors.x));
            rows.push(row("E_y, perturbed", &errors.y));
            rows.push(row("tilde E_x", &difference.x));
            rows.push(row("tilde E_y", &difference.y));
        }
        text += &table(&["in percent of the amplitude", "at the end", "largest"], &rows);
        text += &format!(
            "\nat the end, t = {}, and the largest of {} samples from 0 to there.\nE: chain against ansatz (eq:relerr_tw)",
            scene.end(),
            t.len()
        );
        if let Some(run) = &self.perturbed {
            text += &format!(
                "; perturbed by zeta = {}, seed {}, against its own ansatz (eq:xy_app).\ntilde E: perturbed against unperturbed wave (eq:relerr_twPtd).\nThe \
             modulation equations conserve their energy; its relative change was {:.1e}",
                run.wave.zeta(),
                run.wave.seed(),
                run.flow_energy_change
            );
        }
        text += ".\n";
        if let Some(ensemble) = &self.ensemble {
            text += &ensemble_table(ensemble);
        }
        text
    }

    /// `errors.csv` (in time), `profile.csv` (strains at the end); with a perturbation
    /// `envelope.csv`, `ensemble.csv` (a line a seed) and `spread.csv` (tilde E_x and tilde E_y
    /// over the seeds, in time).
    fn files(&self, json: &str) -> Result<Vec<File>> {
        let mut files = vec![("wave.json".to_owned(), json.into())];
        files.extend(tables(self).into_iter().map(|(name, csv)| (name.to_owned(), csv)));
        Ok(files)
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(crate::study::named([("wave.png", picture(self)?)]))
    }

    fn remark(&self) -> Option<String> {
        let Ensemble { members, missing, .. } = self.ensemble.as_ref()?;
        let all = members.len() + missing;
        (*missing > 0).then(|| format!("stopped by a signal: {missing} seeds of {all} were not run"))
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

fn last(values: &[f64]) -> f64 {
    values.last().copied().unwrap_or(f64::NAN)
}

fn spread_json(spread: Option<Spread>) -> Value {
    spread.map_or(Value::Null, |Spread { low, lower, median, upper, high }| {
        json!({"median": median, "low": low, "high": high, "lower_quartile": lower, "upper_quartile": upper})
    })
}

fn ensemble_table(ensemble: &Ensemble) -> String {
    let row = |name: &str, quantity: fn(&Member) -> Option<f64>| {
        let cells = match ensemble.spread(quantity) {
            Some(Spread { low, lower, median, upper, high }) => {
                [low, lower, median, upper, high].map(|value| format!("{value:.6e}"))
            }
            None => std::array::from_fn(|_| "–".to_owned()),
        };
        [name.to_owned()].into_iter().chain(cells).collect::<Vec<_>>()
    };
    let rows = [
        row("growth of tilde E_x", |member| member.growth_x),
        row("growth of tilde E_y", |member| member.growth_y),
        row("rate of tilde E_x", |member| member.rate),
        row("misfit of the rate", |member| member.rate_residual),
    ];
    format!(
        "\n{}\nover {} seeds from {}. Growth: largest of the last period over largest of the first. Rate: slope of ln(largest of each period) over \
         the second half, per unit of time; misfit: its largest distance from the line.\n",
        table(&["", "lowest", "quartile", "median", "quartile", "highest"], &rows),
        ensemble.members.len(),
        ensemble.members.first().map_or(0, |member| member.seed),
    )
}

/// All tables as `(file name, CSV)`.
pub(crate) fn tables(study: &WaveStudy) -> Vec<(&'static str, Vec<u8>)> {
    let mut tables = vec![("errors.csv", errors_csv(study)), ("profile.csv", profile_csv(study))];
    if let Some(Envelopes { chain, flow, .. }) = study.perturbed.as_ref().and_then(|run| run.envelopes.as_ref()) {
        let sites = chain.means.len();
        let rows = (0..sites).map(|n| {
            let of = |z: &[f64]| [z[n], z[sites + n]];
            let ([re, im], [re_flow, im_flow]) = (of(&chain.amplitudes), of(&flow.amplitudes));
            vec![n as f64, re, im, chain.means[n], re_flow, im_flow, flow.means[n]]
        });
        let names = ["n", "re_chain", "im_chain", "b_chain", "re_flow", "im_flow", "b_flow"];
        tables.push(("envelope.csv", csv(&names, rows)));
    }
    if let Some(ensemble) = &study.ensemble {
        tables.push(("ensemble.csv", members_csv(ensemble)));
        tables.push(("spread.csv", spread_csv(study, ensemble)));
    }
    tables
}

/// Errors in time: `t, e_x, e_y`, and of the perturbed wave `e_x_perturbed, e_y_perturbed,
/// tilde_e_x, tilde_e_y`.
fn errors_csv(study: &WaveStudy) -> Vec<u8> {
    let mut columns = vec![("t", &study.t), ("e_x", &study.errors.x), ("e_y", &study.errors.y)];
    if let Some(PerturbedRun { errors, difference, .. }) = &study.perturbed {
        columns.extend([("e_x_perturbed", &errors.x), ("e_y_perturbed", &errors.y)]);
        columns.extend([("tilde_e_x", &difference.x), ("tilde_e_y", &difference.y)]);
    }
    columns_csv(&columns)
}

/// Strains at the end by site: `n, x, y, x_ansatz, y_ansatz`, and those of the perturbed wave.
fn profile_csv(study: &WaveStudy) -> Vec<u8> {
    let sites: Vec<f64> = (0..study.strains.x.len()).map(|n| n as f64).collect();
    let mut columns = vec![("n", &sites)];
    columns.extend([("x", &study.strains.x), ("y", &study.strains.y)]);
    columns.extend([("x_ansatz", &study.ansatz.x), ("y_ansatz", &study.ansatz.y)]);
    if let Some(PerturbedRun { strains, ansatz, .. }) = &study.perturbed {
        columns.extend([("x_perturbed", &strains.x), ("y_perturbed", &strains.y)]);
        columns.extend([("x_perturbed_ansatz", &ansatz.x), ("y_perturbed_ansatz", &ansatz.y)]);
    }
    columns_csv(&columns)
}

fn columns_csv(columns: &[(&str, &Vec<f64>)]) -> Vec<u8> {
    let names: Vec<&str> = columns.iter().map(|column| column.0).collect();
    let rows = columns.first().map_or(0, |column| column.1.len());
    csv(&names, (0..rows).map(|k| columns.iter().map(|column| column.1[k]).collect()))
}

fn members_csv(ensemble: &Ensemble) -> Vec<u8> {
    let number = |value: Option<f64>| value.map(|value| format!("{value:e}")).unwrap_or_default();
    let mut text = String::from("seed,growth_x,growth_y,rate,rate_residual\n");
    for &Member { seed, growth_x, growth_y, rate, rate_residual } in &ensemble.members {
        let cells = [growth_x, growth_y, rate, rate_residual].map(number).join(",");
        text += &format!("{seed},{cells}\n");
    }
    text.into_bytes()
}

fn spread_csv(study: &WaveStudy, ensemble: &Ensemble) -> Vec<u8> {
    let numbers = |spread: &Spread| {
        let Spread { low, lower, median, upper, high } = *spread;
        [low, lower, median, upper, high]
    };
    let rows = study.t.iter().zip(ensemble.difference_x.iter().zip(&ensemble.difference_y));
    let rows = rows.map(|(&t, (x, y))| [t].into_iter().chain(numbers(x)).chain(numbers(y)).collect());
    let names =
        ["t", "x_low", "x_lower", "x_median", "x_upper", "x_high", "y_low", "y_lower", "y_median", "y_upper", "y_high"];
    csv(&names, rows)
}

/// Strains at the end beside the ansatz, and errors in time.
#[cfg(feature = "plot")]
fn picture(study: &WaveStudy) -> Result<crate::figures::Picture> {
    use super::Errors;
    use crate::figures::{Column, Kind, Line, Panel, Panels, panels};
    let over = |x: &mut dyn Iterator<Item = f64>, y: &[f64]| x.zip(y.iter().copied()).collect::<Vec<_>>();
    let profile = |name: &str, values: &[f64]| Line::new(name, over(&mut (0..).map(f64::from), values));
    let in_time = |name: &str, values: &[f64]| Line::new(name, over(&mut study.t.iter().copied(), values));
    let strains = |label: &str, chain: &[f64], ansatz: &[f64]| {
        Panel::new(Kind::Sites, ["site n", label], vec![profile("chain", chain), profile("ansatz", ansatz)])
    };
    let errors_of = |kind, label: &str, names: [&str; 2], Errors { x, y }: &Errors| {
        Panel::new(kind, ["time t", label], vec![in_time(names[0], x), in_time(names[1], y)])
    };
    let (chain, ansatz) = (&study.strains, &study.ansatz);
    let profiles = [strains("strain xₙ", &chain.x, &ansatz.x), strains("strain yₙ", &chain.y, &ansatz.y)];
    let mut errors = vec![errors_of(Kind::Time, "error over amplitude", ["E_x", "E_y"], &study.errors)];
    errors.extend(study.perturbed.as_ref().map(|PerturbedRun { difference, .. }| {
        errors_of(Kind::LogTime, "perturbed − unperturbed", ["Ẽ_x", "Ẽ_y"], difference)
    }));
    let how = format!(
        "Unperturbed wave at t = {:.6} beside its first-order ansatz (eq:xytw_app), and largest distances from it in time (eq:relerr_tw). {}.",
        study.scene.end(),
        study.setting
    );
    let columns = vec![Column::new("", profiles), Column::new("", errors)];
    let title = format!("{}: chain and ansatz", study.scene.name());
    Ok(panels(&Panels { title, columns, caption: crate::study::provenance(&study.scene, &how) })?)
}
