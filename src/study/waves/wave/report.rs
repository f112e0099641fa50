//! The report of travelling waves.

use super::{Ensemble, Envelopes, Member, Spread, WaveStudy, XAndY};
use crate::{
    number::{format_short, of_pi},
    report::{Column, Fixed, Hidden, Kind, Line, Panel, Panels, Power, Report, Short, Table},
    study::{scene_caption, scene_json},
};
use serde_json::{Value, json};

impl WaveStudy {
    /// The report. `e_x_*` and `e_y_*` are those of the unperturbed wave (eq:relerr_tw); `growth`
    /// is null without perturbation, and in runs shorter than two periods.
    pub fn report(&self) -> Report {
        let Self { scene, wave, errors, ensemble, .. } = self;
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
        let of_each = |of: fn(&Member) -> Option<f64>| members.iter().map(of).collect::<Vec<_>>();
        let missing = ensemble.as_ref().map_or(0, |ensemble| ensemble.missing);
        let all = members.len() + missing;
        let stopped = (missing > 0).then(|| format!("stopped by a signal: {missing} seeds of {all} were not run"));
        let report = Report::new("wave")
            .fact("scene", scene.name())
            .fact("setting", &self.setting)
            .fact("epsilon", wave.epsilon())
            .fact("omega", wave.params().omega())
            .fact("omega_tw", wave.omega_tw())
            .fact("period", scene.period())
            .fact("t", scene.end())
            .fact("samples", self.t.len())
            .fact("e_x_final", last(&errors.x))
            .fact("e_y_final", last(&errors.y))
            .fact("e_x_max", largest(&errors.x))
            .fact("e_y_max", largest(&errors.y))
            .fact("growth", of_all(|member| member.growth_x))
            .fact("growth_y", of_all(|member| member.growth_y))
            .fact("rate", of_all(|member| member.rate))
            .fact("seeds", members.iter().map(|member| member.seed).collect::<Vec<_>>())
            .fact("growth_of_seed", of_each(|member| member.growth_x))
            .fact("rate_of_seed", of_each(|member| member.rate))
            .fact("rate_residual_of_seed", of_each(|member| member.rate_residual))
            .fact("missing", missing)
            .fact("perturbed", perturbed)
            .fact("force_evaluations", self.stats.force_evaluations)
            .fact("wall_s", self.wall.as_secs_f64())
            .fact("scene_file", scene_json(scene))
            .words(format!("scene {}", scene.title()))
            .words(format!(
                "{}; epsilon = {:.16e}, omega = {:.16}, omega_tw = {:.16}, period = {:.16}",
                self.setting,
                wave.epsilon(),
                wave.params().omega(),
                wave.omega_tw(),
                scene.period()
            ))
            .table(summary(&self.errors, self.perturbed.as_ref().map(|run| [&run.errors, &run.difference])))
            .words(self.about())
            .picture(self.picture())
            .remark(stopped);
        self.tables()
            .into_iter()
            .chain(ensemble.as_ref().map(|ensemble| growth(Some(ensemble))))
            .fold(report, Report::table)
    }

    fn about(&self) -> String {
        let perturbed = self.perturbed.as_ref().map_or(String::new(), |run| {
            format!(
                "; perturbed by zeta = {}, seed {}, against its own ansatz (eq:xy_app). tilde E: perturbed against \
                 unperturbed wave (eq:relerr_twPtd). The modulation equations conserve their energy; its relative change \
                 was {:.1e}",
                run.wave.zeta(),
                run.wave.seed(),
                run.flow_energy_change
            )
        });
        let seeds = self.ensemble.as_ref().map_or(String::new(), |ensemble| {
            let first = ensemble.members.first().map_or(0, |member| member.seed);
            format!(" Growth and rates over {} seeds from {first}.", ensemble.members.len())
        });
        format!(
            "{} samples from 0 to the end, t = {}. E: chain against ansatz (eq:relerr_tw){perturbed}.{seeds}",
            self.t.len(),
            self.scene.end()
        )
    }

    /// Errors in time and strains at the end by site; with a perturbation also envelopes, a row for
    /// each seed, and the spread over them in time.
    fn tables(&self) -> Vec<Table> {
        let run = self.perturbed.as_ref();
        let errors = errors(&self.t, &self.errors, run.map(|run| [&run.errors, &run.difference]));
        let profile = profile(&self.strains, &self.ansatz, run.map(|run| [&run.strains, &run.ansatz]));
        let envelope = run.and_then(|run| run.envelopes.as_ref()).map(envelope);
        let ensemble = self.ensemble.iter().flat_map(|ensemble| {
            let pairs = ensemble.difference_x.iter().zip(&ensemble.difference_y);
            let rows: Vec<_> = self.t.iter().zip(pairs).map(|(&t, (&x, &y))| (t, [x, y])).collect();
            [Member::table("ensemble", &ensemble.members).key("").done(), spread(&rows)]
        });
        [errors, profile].into_iter().chain(envelope).chain(ensemble).collect()
    }

    /// Strains at the end beside the ansatz, and errors in time: of the wave; of the perturbed one;
    /// and of several seeds.
    fn picture(&self) -> Panels {
        let tables = self.tables();
        let profiles = |[x, x_ansatz, y, y_ansatz]: [&str; 4]| {
            [("strain xₙ", x, x_ansatz), ("strain yₙ", y, y_ansatz)].map(|(label, strain, ansatz)| {
                tables[1].panel(Kind::Sites, ["site n", label], "n", &[("chain", strain), ("ansatz", ansatz)])
            })
        };
        let in_time = |kind, label, lines: &[(&str, &str)]| tables[0].panel(kind, ["time t", label], "t", lines);
        let own = profiles(["x", "x_ansatz", "y", "y_ansatz"]);
        // Both are seen, also where one is small.
        let apart = 5.0 * largest(&self.errors.x) < largest(&self.errors.y);
        let kind = if apart { Kind::LogTime } else { Kind::Time };
        let mut errors = in_time(kind, "error over amplitude", &[("E_x", "e_x"), ("E_y", "e_y")]);
        if apart {
            // The rise from rounding would take most of a logarithmic axis.
            errors.lines.iter_mut().for_each(|line| line.points.retain(|point| point.0 > 0.01 * self.scene.end()));
        }
        let columns = match &self.perturbed {
            None => vec![Column::new("", own), Column::new("", [errors])],
            Some(run) => {
                let lines = [("Ẽ_x", "tilde_e_x"), ("Ẽ_y", "tilde_e_y")];
                let difference = in_time(Kind::LogTime, "difference over amplitude", &lines);
                let perturbed = profiles(["x_perturbed", "x_perturbed_ansatz", "y_perturbed", "y_perturbed_ansatz"]);
                let name = format!("perturbed, ζ = {}, seed {}", run.wave.zeta(), run.wave.seed());
                let several = self.ensemble.iter().map(|all| all.members.len()).filter(|seeds| *seeds > 1);
                let several = several.map(|seeds| {
                    let own = format!("seed {}", run.wave.seed());
                    Column::new("", ["x", "y"].map(|symbol| self.over_seeds(&tables, symbol, &own, seeds)))
                });
                let own = Column::new("unperturbed", own.into_iter().chain([errors]));
                let perturbed = Column::new(name, perturbed.into_iter().chain([difference]));
                [own, perturbed].into_iter().chain(several).collect()
            }
        };
        let title = format!("{}: chain and ansatz", self.scene.name());
        Panels { title, columns, caption: scene_caption(&self.scene, &self.caption()) }
    }

    /// `tilde E` of the wave that is shown, with median and range over the seeds: the largest of
    /// each period, in which they oscillate.
    fn over_seeds(&self, tables: &[Table], symbol: &str, own: &str, seeds: usize) -> Panel {
        let period = self.scene.period();
        let line = |table: &Table, name: &str, column: &str| {
            let end = |point: &(f64, f64)| period * (point.0 / period - 1e-6).ceil().max(1.0);
            let largest = |one: &[(f64, f64)]| (end(&one[0]), one.iter().fold(0.0f64, |most, point| most.max(point.1)));
            Line::new(name, table.line("", ["t", column]).points.chunk_by(|a, b| end(a) == end(b)).map(largest))
        };
        let spread = |name: &str, column: &str| {
            line(&tables[tables.len() - 1], &format!("{name} of {seeds} seeds"), &format!("{symbol}_{column}"))
        };
        let own = line(&tables[0], own, &format!("tilde_e_{symbol}"));
        let lines = vec![own, spread("median", "median"), spread("least", "low"), spread("largest", "high")];
        Panel::new(Kind::Time, ["time t", &format!("largest Ẽ_{symbol} in each period")], lines)
    }

    /// What the picture shows, with all numbers.
    fn caption(&self) -> String {
        let (wave, shape) = (&self.wave, self.wave.shape());
        let ends = |errors: &XAndY| {
            let [x, y, most_x, most_y] =
                [last(&errors.x), last(&errors.y), largest(&errors.x), largest(&errors.y)].map(format_short);
            format!("{x} and {y} at the end, at most {most_x} and {most_y}")
        };
        let perturbed = self.perturbed.as_ref().map_or(String::new(), |run| {
            format!(
                " Perturbed, against its own ansatz: {}; against the unperturbed wave, Ẽ_x and Ẽ_y: {}.",
                ends(&run.errors),
                ends(&run.difference)
            )
        });
        let growth = self.ensemble.as_ref().and_then(|all| Some((all.spread(|one| one.growth_x)?, all.members.len())));
        let growth = growth.map_or(String::new(), |(growth, seeds)| {
            let [median, low, high] = [growth.median, growth.low, growth.high].map(format_short);
            format!(
                " Growth of Ẽ_x, largest of the last period over that of the first: median of {seeds} \
                 seeds {median}, {low} to {high}."
            )
        });
        format!(
            "q = {}, a = {}, b = {}, ε = {}, ω_tw = {}, ω = {}, t = {} = {} T_tw. Chain against ansatz, E_x and \
             E_y over the amplitude: {}.{perturbed}{growth} By {}.",
            of_pi(shape.q),
            shape.a,
            shape.b,
            format_short(wave.epsilon()),
            format_args!("{:.6}", wave.omega_tw()),
            format_args!("{:.6}", wave.params().omega()),
            format_short(self.scene.end()),
            format_short(self.scene.end() / self.scene.period()),
            ends(&self.errors),
            self.setting
        )
    }
}

pub(super) fn outline() -> Report {
    let none = XAndY::default();
    let tables = [
        summary(&none, None),
        errors(&[], &none, Some([&none, &none])),
        profile(&none, &none, Some([&none, &none])),
        Member::table("ensemble", &[]).done(),
        spread(&[]),
        growth(None),
    ];
    tables.into_iter().fold(Report::new("wave"), Report::table)
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

/// Growth and rates over the seeds.
fn growth(ensemble: Option<&Ensemble>) -> Table {
    let spread = |quantity: fn(&Member) -> Option<f64>| ensemble.and_then(|ensemble| ensemble.spread(quantity));
    let rows = [
        ("growth of tilde E_x", spread(|member| member.growth_x)),
        ("growth of tilde E_y", spread(|member| member.growth_y)),
        ("rate of tilde E_x", spread(|member| member.rate)),
        ("misfit of the rate", spread(|member| member.rate_residual)),
    ];
    let of = |of: fn(Spread) -> f64| move |row: &(&str, Option<Spread>)| row.1.map(of);
    let about = "growth: largest of the last period over largest of the first; rate: slope of ln(largest of each period) \
                 over the second half, per unit of time; misfit: its largest distance from the line";
    Table::of("growth", &rows)
        .key("")
        .col("quantity", Short, about, |row| row.0)
        .col("lowest", Power(6), "", of(|spread| spread.low))
        .col("lower_quartile", Power(6), "", of(|spread| spread.lower))
        .col("median", Power(6), "", of(|spread| spread.median))
        .col("upper_quartile", Power(6), "", of(|spread| spread.upper))
        .col("highest", Power(6), "", of(|spread| spread.high))
        .done()
}

/// Errors at the end, and the largest.
fn summary(own: &XAndY, perturbed: Option<[&XAndY; 2]>) -> Table {
    let mut rows = vec![("E_x", &own.x), ("E_y", &own.y)];
    if let Some([errors, difference]) = perturbed {
        rows.extend([("E_x perturbed", &errors.x), ("E_y perturbed", &errors.y)]);
        rows.extend([("tilde E_x", &difference.x), ("tilde E_y", &difference.y)]);
    }
    Table::of("summary", &rows)
        .key("")
        .col("error", Short, "", |row| row.0)
        .col("at_the_end", Fixed(10), "in percent of the amplitude", |row| 100.0 * last(row.1))
        .col("largest", Fixed(10), "of all samples, in percent of the amplitude", |row| 100.0 * largest(row.1))
        .done()
}

/// Columns of equal length, for files.
fn columns(name: &str, columns: &[(&str, &str, &[f64])]) -> Table {
    let rows: Vec<usize> = (0..columns.first().map_or(0, |column| column.2.len())).collect();
    let mut table = Table::of(name, &rows).key("");
    for &(name, about, values) in columns {
        table = table.col(name, Hidden, about, |&k| values[k]);
    }
    table.done()
}

fn errors(t: &[f64], own: &XAndY, perturbed: Option<[&XAndY; 2]>) -> Table {
    let mut all = vec![("t", "", t), ("e_x", "E_x", &own.x[..]), ("e_y", "E_y", &own.y)];
    if let Some([errors, difference]) = perturbed {
        all.extend([
            ("e_x_perturbed", "E_x of the perturbed wave", &errors.x[..]),
            ("e_y_perturbed", "E_y of it", &errors.y),
        ]);
        all.extend([("tilde_e_x", "tilde E_x", &difference.x[..]), ("tilde_e_y", "tilde E_y", &difference.y)]);
    }
    columns("errors", &all)
}

fn profile(strains: &XAndY, ansatz: &XAndY, perturbed: Option<[&XAndY; 2]>) -> Table {
    let sites: Vec<f64> = (0..strains.x.len()).map(|n| n as f64).collect();
    let mut all = vec![("n", "site", &sites[..])];
    all.extend([("x", "strain of the bead at the end", &strains.x[..]), ("y", "of the resonator", &strains.y)]);
    all.extend([
        ("x_ansatz", "strains of beads by the ansatz", &ansatz.x[..]),
        ("y_ansatz", "of resonators", &ansatz.y),
    ]);
    if let Some([strains, ansatz]) = perturbed {
        all.extend([
            ("x_perturbed", "strains of beads of the perturbed wave", &strains.x[..]),
            ("y_perturbed", "of its resonators", &strains.y),
        ]);
        all.extend([
            ("x_perturbed_ansatz", "strains of beads by its ansatz", &ansatz.x[..]),
            ("y_perturbed_ansatz", "of resonators", &ansatz.y),
        ]);
    }
    columns("profile", &all)
}

/// Envelopes of the chain and by the modulation equations.
fn envelope(Envelopes { chain, flow, .. }: &Envelopes) -> Table {
    let sites: Vec<f64> = (0..chain.means.len()).map(|n| n as f64).collect();
    let [(re, im), (re_flow, im_flow)] = [chain, flow].map(|of| of.amplitudes.split_at(sites.len()));
    columns(
        "envelope",
        &[
            ("n", "site", &sites),
            ("re_chain", "envelope of the chain", re),
            ("im_chain", "", im),
            ("b_chain", "its mean strain", &chain.means),
            ("re_flow", "envelope by the modulation equations", re_flow),
            ("im_flow", "", im_flow),
            ("b_flow", "", &flow.means),
        ],
    )
}

/// `tilde E_x` and `tilde E_y` over the seeds, in time.
fn spread(rows: &[(f64, [Spread; 2])]) -> Table {
    let mut table = Table::of("spread", rows).key("").col("t", Hidden, "", |row| row.0);
    for (k, name) in ["x", "y"].into_iter().enumerate() {
        let of = |of: fn(Spread) -> f64| move |row: &(f64, [Spread; 2])| of(row.1[k]);
        table = table
            .col(format!("{name}_low"), Hidden, format!("least tilde E_{name} of the seeds"), of(|spread| spread.low))
            .col(format!("{name}_lower"), Hidden, "quartile", of(|spread| spread.lower))
            .col(format!("{name}_median"), Hidden, "", of(|spread| spread.median))
            .col(format!("{name}_upper"), Hidden, "quartile", of(|spread| spread.upper))
            .col(format!("{name}_high"), Hidden, "largest", of(|spread| spread.high));
    }
    table.done()
}
