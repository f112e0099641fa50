//! The report of the study of Theorem 1.

use super::{Bound, Errors, Norm, TheoremRun, TheoremSlope, TheoremStudy};
use crate::report::{Fixed, Hidden, Json, Kind, Line, Panel, Panels, Power, Report, Short, Table, fields};
use serde_json::{Value, json};

/// The three errors, as JSON names them.
const QUANTITIES: [&str; 3] = ["u", "v", "vdot"];

impl TheoremStudy {
    /// A row for each size and norm: the suprema over time, and the same over the powers of
    /// `epsilon`.
    fn table(&self) -> Table {
        let rows: Vec<(&TheoremRun, Norm)> =
            self.runs.iter().flat_map(|run| Norm::ALL.map(|norm| (run, norm))).collect();
        let [first, _, second] = self.powers();
        let mut table = Table::of("theorem", &rows)
            .col("epsilon", Short, "", |row| row.0.epsilon)
            .col("rho", Power(3), "", |row| row.0.rho)
            .col("norm", Short, "", |row| row.1.name());
        for (k, name) in QUANTITIES.iter().enumerate() {
            let about = format!("supremum of the error of {name} over 0 <= t <= T epsilon^(1-alpha)");
            table = table.col(format!("{name}_error"), Hidden, about, |row| row.0.suprema[row.1.index()].0[k]);
        }
        for (k, name) in QUANTITIES.iter().enumerate() {
            let power = if k == 2 { second } else { first };
            let about =
                format!("supremum over 0 <= t <= T epsilon^(1-alpha) of the error of {name}, over epsilon^{power}");
            table = table.col(format!("{name}_scaled"), Power(4), about, |row| {
                let Errors(scaled) = self.scaled(row.0, row.1);
                scaled[k]
            });
        }
        table
            .col("sampling_error", Power(1), "largest share of a supremum that samples may miss", |row| {
                row.0.sampling_error(row.1)
            })
            .col("t", Hidden, "end of the run", |row| row.0.end)
            .col("samples", Hidden, "number of samples", |row| row.0.samples)
            .col("windows", Hidden, "windows of the integrator", |row| row.0.windows)
            .done()
    }

    /// The local slopes between neighbouring sizes, and their limits with the verdict.
    fn slope_tables(&self) -> [Table; 2] {
        let pairs: Vec<(usize, &[TheoremRun])> = self.runs.windows(2).enumerate().collect();
        let mut local = Table::of("slopes", &pairs).key("").col("from", Short, "", |pair| pair.1[0].epsilon).col(
            "to",
            Short,
            "local slope between two sizes",
            |pair| pair.1[1].epsilon,
        );
        for (quantity, name) in QUANTITIES.iter().enumerate() {
            for norm in Norm::ALL {
                let is = |slope: &&TheoremSlope| slope.norm == norm && slope.quantity == quantity;
                let slope = self.slopes.iter().find(is);
                let of = |pair: &(usize, &[TheoremRun])| slope.map(|slope| slope.local[pair.0]);
                local = local.col(format!("{name}_{}", norm.name()), Fixed(4), "", of);
            }
        }
        let limits = Table::of("limits", &self.slopes)
            .key("slopes")
            .col("norm", Short, "", |slope| slope.norm.name())
            .col("quantity", Short, "", |slope| QUANTITIES[slope.quantity])
            .col("local", Json, "", |slope| slope.local.clone())
            .col("theory", Fixed(4), "power of the theorem", |slope| slope.power)
            .col("expected", Fixed(4), "power of its proof at this law of rho", |slope| slope.expected)
            .col("limit", Fixed(4), "limit of the local slopes", |slope| slope.limit.map(|limit| limit.0))
            .col("limit_uncertainty", Fixed(4), "its uncertainty", |slope| slope.limit.map(|limit| limit.1))
            .col("verdict", Short, "", |slope| slope.bound.name());
        [local.done(), limits.done()]
    }

    /// The report; `bounded` is null where it is undecided.
    pub fn report(&self) -> Report {
        let options = &self.options;
        let bounded = |bound: Bound| match bound {
            Bound::Bounded => json!(true),
            Bound::Violated => json!(false),
            Bound::Undecided => Value::Null,
        };
        let seed = if options.random() { format!(" (seed {})", options.seed()) } else { String::new() };
        let [local, limits] = self.slope_tables();
        let all = self.missing + self.runs.len();
        let missing = format!("stopped by a signal: {} sizes of {all} were not run", self.missing);
        let report = Report::new("theorem")
            .words(format!(
                "alpha = {}, T = {}, rho = {}, A(0): {}{seed}, C_i = {}, {} sites",
                options.alpha,
                options.horizon,
                options.rho_law.name(),
                options.initial.name(),
                options.c_i,
                self.sites,
            ))
            .finding()
            .facts(fields!(options => alpha, horizon))
            .fact("rho_law", options.rho_law.name())
            .fact("rho_allowed", options.rho_law.allowed())
            .fact("initial", options.initial.name())
            .facts(fields!(options => c_i, seed(); self => sites))
            .table(self.table())
            .table(local)
            .table(limits)
            .fact(
                "bounded",
                json!({"u": bounded(self.bound(0)), "v": bounded(self.bound(1)), "vdot": bounded(self.bound(2))}),
            )
            .fact("verdict", self.verdict().name())
            .words(format!("{}: {}", self.verdict().name(), self.conclusion()))
            .finding()
            .fact("rule", Bound::RULE)
            .words(Bound::RULE)
            .fact("integrator", "collocation")
            .fact("accuracy", options.accuracy)
            .fact("samples_per_period", options.sampling.points)
            .fact("wall_s", self.wall.as_secs_f64())
            .picture(self.picture())
            .remark((self.missing > 0).then_some(missing))
            .failure(self.contradicts().then(|| self.conclusion().to_owned()));
        let text = report.text();
        report.file("theorem.txt", text.into_bytes())
    }

    fn conclusion(&self) -> &'static str {
        match (self.verdict(), self.options.rho_law.allowed()) {
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

    /// The slopes of the norm that is drawn first, and the verdict.
    pub(crate) fn slopes_in_words(&self) -> String {
        let slopes = self.slopes.iter().filter(|slope| slope.norm == Norm::One);
        let slopes = slopes.filter_map(|slope| slope.local.last()).map(|slope| format!("{slope:.3}"));
        let slopes = slopes.collect::<Vec<_>>().join(", ").replace('-', "−");
        format!("{slopes}, {}.", self.verdict().name())
    }

    /// Suprema over their powers of `epsilon` against `epsilon`, a panel for each error that there
    /// is: bounded as the theorem says where they do not grow to the left.
    fn picture(&self) -> Panels {
        let options = &self.options;
        let line = |quantity: usize, norm: Norm| {
            let points = self.runs.iter().map(|run| (run.epsilon, self.scaled(run, norm).0[quantity]));
            Line::new(&format!("l_{}", norm.name()), points)
        };
        let labels = ["u over ε^α", "v over ε^α", "v′ over ε^(2α−1)"];
        let panel = |quantity: usize| {
            let lines = Norm::ALL.map(|norm| line(quantity, norm)).into();
            Panel::new(Kind::LogLog, ["size ε", labels[quantity]], lines)
        };
        // Where resonators do not move, their errors are zero and have no panel.
        let seen = |panel: &Panel| panel.lines.iter().flat_map(|line| &line.points).any(|point| point.1 > 0.0);
        let caption = format!(
            "Suprema over 0 ≤ t ≤ Tε^(1−α) of errors over the powers of ε that bound them. α = {}, κ = 1, T = {}, ρ: {}, A(0): {}, C_i = {}, \
             {} sites; tolerance {:e} ε^(α−1), {} samples a period. Slopes in l₁ of the errors over the two smallest sizes: {}",
            options.alpha,
            options.horizon,
            options.rho_law.name(),
            options.initial.name(),
            options.c_i,
            self.sites,
            options.accuracy,
            options.sampling.points,
            self.slopes_in_words(),
        );
        Panels::column("Theorem 1: errors of the DpS equation", (0..3).map(panel).filter(seen).collect(), caption)
    }
}
