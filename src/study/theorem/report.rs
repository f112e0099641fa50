//! The study of Theorem 1 as text, JSON, CSV and a picture.

use super::{Bound, Errors, Norm, TheoremRun, TheoremSlope, TheoremStudy};
use crate::{
    error::Result,
    output::csv as numbers_csv,
    present::table,
    study::{File, Report, named as files},
};
use serde_json::{Value, json};

/// The three errors, as JSON names them.
const QUANTITIES: [&str; 3] = ["u", "v", "vdot"];

impl Report for TheoremStudy {
    /// `rows` with `*_error` the suprema over time, `*_scaled` the same over `epsilon^alpha,
    /// epsilon^alpha, epsilon^{2 alpha-1}`; `slopes` with `local` from large to small `epsilon`,
    /// `theory` the power of the theorem, `expected` that of its proof at this law of `rho`;
    /// `bounded` is null where it is undecided.
    fn json(&self) -> Value {
        let options = &self.options;
        let row = |(run, norm): (&TheoremRun, Norm)| {
            let (Errors([u, v, v_dot]), Errors(scaled)) = (run.suprema[norm.index()], self.scaled(run, norm));
            json!({
                "epsilon": run.epsilon,
                "rho": number(run.rho),
                "norm": norm.name(),
                "u_error": u,
                "v_error": v,
                "vdot_error": v_dot,
                "u_scaled": scaled[0],
                "v_scaled": scaled[1],
                "vdot_scaled": scaled[2],
                "sampling_error": run.sampling_error(norm),
                "t": run.end,
                "samples": run.samples,
                "windows": run.windows,
            })
        };
        let slope = |slope: &TheoremSlope| {
            json!({
                "norm": slope.norm.name(),
                "quantity": QUANTITIES[slope.quantity],
                "local": slope.local,
                "theory": slope.power,
                "expected": slope.expected,
                "limit": slope.limit.map(|limit| limit.0),
                "limit_uncertainty": slope.limit.map(|limit| limit.1),
                "verdict": slope.bound.word(),
            })
        };
        let bounded = |bound: Bound| match bound {
            Bound::Bounded => json!(true),
            Bound::Violated => json!(false),
            Bound::Undecided => Value::Null,
        };
        json!({
            "alpha": options.alpha,
            "horizon": options.horizon,
            "rho_law": options.rho_law.name(),
            "rho_allowed": options.rho_law.allowed(),
            "initial": options.initial.name(),
            "c_i": options.c_i,
            "seed": options.seed(),
            "sites": self.sites,
            "rows": rows(self).map(row).collect::<Vec<_>>(),
            "slopes": self.slopes.iter().map(slope).collect::<Vec<_>>(),
            "bounded": {
                "u": bounded(self.bound(0)),
                "v": bounded(self.bound(1)),
                "vdot": bounded(self.bound(2)),
            },
            "verdict": self.verdict().word(),
            "rule": Bound::RULE,
            "integrator": "collocation",
            "accuracy": options.accuracy,
            "samples_per_period": options.sampling.points,
            "wall_s": self.wall.as_secs_f64(),
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self) -> String {
        let options = &self.options;
        let mut text = format!(
            "alpha = {}, T = {}, rho = {}, A(0): {}{}, C_i = {}, {} sites\n\n",
            options.alpha,
            options.horizon,
            options.rho_law.name(),
            options.initial.name(),
            if options.random() { format!(" (seed {})", options.seed()) } else { String::new() },
            options.c_i,
            self.sites,
        );
        let of_all = |quantity: &str| Norm::ALL.map(|norm| format!("{quantity}, l_{}", norm.name()));
        let columns: Vec<String> = ["u", "v", "v'"].map(of_all).concat();
        let head = |first: &[&'static str], last: &[&'static str]| -> Vec<String> {
            first
                .iter()
                .map(|name| (*name).to_owned())
                .chain(columns.clone())
                .chain(last.iter().map(|name| (*name).to_owned()))
                .collect()
        };
        let sizes: Vec<Vec<String>> = self.runs.iter().map(|run| size_row(self, run)).collect();
        text += &named(&head(&["epsilon", "rho"], &["missed"]), &sizes);
        let [first, _, second] = self.powers();
        text += &format!(
            "\nsuprema over 0 <= t <= T epsilon^(1-alpha) of the errors (estimu), (estimv), divided by epsilon^{first} (u with u', v) and epsilon^{second} (v').\n\
         missed: the largest share of a supremum that samples may miss, estimated from the curvature at the largest sample.\n\n"
        );
        let slopes = slope_rows(self);
        text += &named(&head(&["local slope from", "to"], &[]), &slopes);
        text += "\ntheory: the power of the theorem. expected: that of its proof at this law of rho.\n";
        text += &format!("\n{}: {}\n{}\n", self.verdict().word(), conclusion(self), Bound::RULE.replace(". ", ".\n"));
        text
    }

    fn files(&self, json: &str) -> Result<Vec<File>> {
        Ok(files([
            ("theorem.json", json.into()),
            ("theorem.csv", csv(self)),
            ("slopes.csv", slopes_csv(self)),
            ("theorem.txt", self.text().into()),
        ]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(files([("theorem.png", picture(self)?)]))
    }

    fn remark(&self) -> Option<String> {
        let all = self.missing + self.runs.len();
        (self.missing > 0).then(|| format!("stopped by a signal: {} sizes of {all} were not run", self.missing))
    }

    fn succeeded(&self) -> bool {
        !self.contradicts()
    }
}

/// A row for each size and norm.
fn rows(study: &TheoremStudy) -> impl Iterator<Item = (&TheoremRun, Norm)> {
    study.runs.iter().flat_map(|run| Norm::ALL.map(|norm| (run, norm)))
}

/// A number; as text if it is not finite, since JSON has no number for it.
fn number(x: f64) -> Value {
    if x.is_finite() { json!(x) } else { json!(x.to_string()) }
}

fn named(head: &[String], rows: &[Vec<String>]) -> String {
    table(&head.iter().map(String::as_str).collect::<Vec<_>>(), rows)
}

/// In the order of the columns: norms of `u`, of `v`, of `v'`.
fn by_column<T>(of: impl Fn(Norm, usize) -> T) -> Vec<T> {
    (0..3).flat_map(|quantity| Norm::ALL.map(|norm| of(norm, quantity))).collect()
}

fn size_row(study: &TheoremStudy, run: &TheoremRun) -> Vec<String> {
    let missed = Norm::ALL.map(|norm| run.sampling_error(norm)).into_iter().fold(0.0, f64::max);
    let scaled = by_column(|norm, quantity| five_digits(study.scaled(run, norm).0[quantity]));
    let ends = [format!("{:e}", run.epsilon), format!("{:.3e}", run.rho)];
    ends.into_iter().chain(scaled).chain([format!("{missed:.1e}")]).collect()
}

/// A number with five decimals; with an exponent if it is very small or very large.
fn five_digits(x: f64) -> String {
    if x == 0.0 || (1e-3..1e4).contains(&x) { format!("{x:.5}") } else { format!("{x:.4e}") }
}

fn slope_rows(study: &TheoremStudy) -> Vec<Vec<String>> {
    let all =
        by_column(|norm, quantity| study.slopes.iter().find(|slope| slope.norm == norm && slope.quantity == quantity));
    let cells = |of: &dyn Fn(&TheoremSlope) -> String| -> Vec<String> {
        all.iter().map(|slope| slope.map(of).unwrap_or_default()).collect()
    };
    let fixed = |value: f64| if value.is_finite() { format!("{value:.4}") } else { "–".to_owned() };
    let row = |from: String, to: String, cells: Vec<String>| [from, to].into_iter().chain(cells).collect::<Vec<_>>();
    let local = study.runs.windows(2).enumerate().map(|(k, pair)| {
        row(format!("{:e}", pair[0].epsilon), format!("{:e}", pair[1].epsilon), cells(&|slope| fixed(slope.local[k])))
    });
    let line = |name: &str, of: &dyn Fn(&TheoremSlope) -> String| row(name.to_owned(), String::new(), cells(of));
    let last = [
        line("limit", &|slope| slope.limit.map_or("–".to_owned(), |limit| fixed(limit.0))),
        line("uncertainty", &|slope| slope.limit.map_or("–".to_owned(), |limit| format!("{:.4}", limit.1))),
        line("theory", &|slope| fixed(slope.power)),
        line("expected", &|slope| slope.expected.map_or("–".to_owned(), fixed)),
        line("verdict", &|slope| slope.bound.word().to_owned()),
    ];
    local.chain(last).collect()
}

fn conclusion(study: &TheoremStudy) -> &'static str {
    match (study.verdict(), study.options.rho_law.allowed()) {
        (Bound::Bounded, true) => "as Theorem 1 says.",
        (Bound::Bounded, false) => {
            "Theorem 1 does not promise this, since it asks for 1/rho <= C_r epsilon^(2(alpha-1))."
        }
        (Bound::Violated, true) => "this contradicts Theorem 1.",
        (Bound::Violated, false) => {
            "Theorem 1 does not apply, since it asks for 1/rho <= C_r epsilon^(2(alpha-1)), and its bounds do not hold."
        }
        (Bound::Undecided, _) => "the sizes given do not tell.",
    }
}

/// The rows as CSV; `norm` is 1, 2 or `inf`.
pub(crate) fn csv(study: &TheoremStudy) -> Vec<u8> {
    let names = [
        "epsilon",
        "rho",
        "norm",
        "u_error",
        "v_error",
        "vdot_error",
        "u_scaled",
        "v_scaled",
        "vdot_scaled",
        "sampling_error",
        "t",
        "samples",
        "windows",
    ];
    let numbers = [1.0, 2.0, f64::INFINITY];
    numbers_csv(
        &names,
        rows(study).map(|(run, norm)| {
            let (Errors(errors), Errors(scaled)) = (run.suprema[norm.index()], study.scaled(run, norm));
            let first = [run.epsilon, run.rho, numbers[norm.index()]];
            let last = [run.sampling_error(norm), run.end, run.samples as f64, run.windows as f64];
            first.into_iter().chain(errors).chain(scaled).chain(last).collect()
        }),
    )
}

/// Local slopes as CSV: `from, to` are sizes, then `u_1, u_2, u_inf, v_1, ..`.
fn slopes_csv(study: &TheoremStudy) -> Vec<u8> {
    let columns = by_column(|norm, quantity| format!("{}_{}", QUANTITIES[quantity], norm.name()));
    let names: Vec<&str> = ["from", "to"].into_iter().chain(columns.iter().map(String::as_str)).collect();
    let of = |norm: Norm, quantity: usize| {
        study.slopes.iter().find(move |slope| slope.norm == norm && slope.quantity == quantity)
    };
    numbers_csv(
        &names,
        study.runs.windows(2).enumerate().map(|(k, pair)| {
            let slopes = by_column(|norm, quantity| of(norm, quantity).map_or(f64::NAN, |slope| slope.local[k]));
            [pair[0].epsilon, pair[1].epsilon].into_iter().chain(slopes).collect()
        }),
    )
}

/// Suprema over their powers of `epsilon` against `epsilon`, a panel for each error that there is:
/// bounded as the theorem says where they do not grow to the left.
#[cfg(feature = "plot")]
fn picture(study: &TheoremStudy) -> Result<crate::figures::Picture> {
    use crate::figures::{Kind, Line, Panel, Panels, panels};
    let options = &study.options;
    let line = |quantity: usize, norm: Norm| {
        let points = study.runs.iter().map(|run| (run.epsilon, study.scaled(run, norm).0[quantity]));
        Line::new(&format!("l_{}", norm.name()), points)
    };
    let labels = ["u over ε^α", "v over ε^α", "v′ over ε^(2α−1)"];
    let panel = |quantity: usize| {
        let lines = Norm::ALL.map(|norm| line(quantity, norm)).into();
        Panel::new(Kind::LogLog, ["size ε", labels[quantity]], lines)
    };
    // Where resonators do not move, their errors are zero and have no panel.
    let seen = |panel: &Panel| panel.lines.iter().flat_map(|line| &line.points).any(|point| point.1 > 0.0);
    let all = (0..3).map(panel).filter(seen).collect();
    let caption = format!(
        "Suprema over 0 ≤ t ≤ Tε^(1−α) of the errors (estimu), (estimv), over the powers of ε that bound them. α = {}, T = {}, ρ: {}, A(0): {}, C_i = {}, {} sites. {}. hertzchain {}.",
        options.alpha,
        options.horizon,
        options.rho_law.name(),
        options.initial.name(),
        options.c_i,
        study.sites,
        study.verdict().word(),
        env!("CARGO_PKG_VERSION")
    );
    Ok(panels(&Panels::column("Theorem 1: errors of the DpS equation", all, caption))?)
}
