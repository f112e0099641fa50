//! What breathers report.

use super::{BrightHistory, BrightSample, BrightStudy, Kink, Shown};
use crate::{
    breathers::Norms,
    chain::{MeanForces, max_norm},
    report::{Column, Fixed, Hidden, Kind, Line, Panel, Panels, Report, Rows, SpaceTime, Table, fields, number},
    study::{format_short, scene_caption, scene_json},
};
use serde_json::{Value, json};

/// Approximate number of rows of the text table at multiples of the period.
const ROWS: usize = 12;

fn norms_json(norms: &Norms) -> Value {
    json!({"e_u": norms.u, "e_udot": norms.u_dot, "e_v": norms.v, "e_vdot": norms.v_dot})
}

fn sample_json(sample: Option<&BrightSample>) -> Value {
    sample.map_or(Value::Null, |sample| {
        let mut value = norms_json(&sample.norms);
        value["t"] = json!(sample.t);
        value["participation"] = json!(sample.participation);
        value["core_share"] = json!(sample.share);
        value
    })
}

fn forces_json(forces: &MeanForces) -> Value {
    json!({"first_bond": forces.first_bond, "mean": forces.mean(), "spread": forces.spread(), "forces": forces.forces})
}

/// A table of samples and, in each row, the largest norms since the row before.
fn samples<'a>(name: &str, rows: &'a [(&BrightSample, Norms)]) -> Rows<'a, (&'a BrightSample, Norms)> {
    Table::of(name, rows)
        .key("")
        .col("t", Fixed(4), "time", |row| row.0.t)
        .col("e_u", Fixed(8), "l_1 distances from the ansatz (diff_u_l1norm), (diff_v_l1norm), rescaled", |row| {
            row.0.norms.u
        })
        .col("e_udot", Fixed(8), "", |row| row.0.norms.u_dot)
        .col("e_v", Fixed(8), "", |row| row.0.norms.v)
        .col("e_vdot", Fixed(8), "", |row| row.0.norms.v_dot)
        .col(
            "participation",
            Fixed(4),
            "(sum e_n)^2 / sum e_n^2 of site energies, half of a contact's at either bead",
            |row| row.0.participation,
        )
        .col("core_share", Fixed(6), "share of the energy in the core", |row| row.0.share)
        .col("energy", Hidden, "of the chain", |row| row.0.energy)
}

/// All samples, and those at multiples of the period; states; mean contact forces of bonds.
pub(super) fn tables(
    all: &[(&BrightSample, Norms)],
    periods: &[(&BrightSample, Norms)],
    states: &[(f64, usize, [f64; 3])],
    forces: &[(usize, [f64; 2])],
) -> [Table; 4] {
    let periods = samples("periods", periods)
        .few(ROWS)
        .col("e_u_max", Hidden, "largest since the row before", |row| row.1.u)
        .col("e_udot_max", Hidden, "", |row| row.1.u_dot)
        .col("e_v_max", Hidden, "", |row| row.1.v)
        .col("e_vdot_max", Hidden, "", |row| row.1.v_dot);
    let states = Table::of("profiles", states)
        .key("")
        .col("t", Hidden, "0, 30 T_b and the end", |row| row.0)
        .col("n", Hidden, "site", |row| row.1)
        .col("u", Hidden, "position of the bead", |row| row.2[0])
        .col("v", Hidden, "and of its resonator", |row| row.2[1])
        .col("u_ansatz", Hidden, "by the ansatz", |row| row.2[2]);
    let forces = Table::of("forces", forces)
        .key("")
        .col("bond", Hidden, "", |row| row.0)
        .col("first_period", Hidden, "mean contact force over the first period", |row| row.1[0])
        .col("after_end", Hidden, "and over a period that begins at the end", |row| row.1[1]);
    [samples("norms", all).in_text([]).done(), periods.done(), states.done(), forces.done()]
}

impl BrightStudy {
    /// The report. `at_30_periods`, `at_horizon` and `largest_to_horizon` are null for runs that
    /// end before; `tenth_left` where the core keeps its energy.
    pub fn report(&self) -> Report {
        let Self { scene, breather, kink, profiles, .. } = self;
        let (params, core, end, horizon) = (breather.params(), breather.core(), scene.end(), breather.horizon());
        let layout = scene.chain().layout();
        let profiles = profiles
            .iter()
            .map(|one| json!({"t": one.t, "u": layout.u(&one.state), "v": layout.v(&one.state).unwrap_or_default()}));
        let [norms, periods, states, forces] = self.tables();
        let picture = self.picture(&norms, &periods);
        let rows = periods.json();
        let columns = ["t", "e_u", "e_udot", "e_v", "e_vdot", "participation", "core_share"].into_iter();
        let columns = columns.map(|name| (name, rows.iter().map(|row| row[name].clone()).collect::<Value>()));
        Report::new("breather")
            .fact("scene", scene.name())
            .facts(fields!(self => setting; breather.profile() => center(); params => alpha, kappa))
            .fact("rho", number(params.rho))
            .fact("epsilon", breather.epsilon())
            .fact("sites", breather.sites())
            .fact("boundary", scene.chain().boundary())
            .fact("omega_0", breather.omega_0())
            .fact("slow_period", breather.slow_period())
            .fact("horizon", horizon)
            .facts(fields!(breather => omega_b(), period(), mass_condition()))
            .fact("t", end)
            .fact("samples", self.samples.len())
            .fact("core", json!({"first": core.start, "last": core.end - 1, "sites": core.len()}))
            .fact("at_30_periods", sample_json(self.at(self.shown_time())))
            .fact("at_horizon", sample_json(self.at(horizon)))
            .fact("final", sample_json(self.samples.last()))
            .fact("largest_to_horizon", (horizon <= end).then(|| norms_json(&self.largest(0.0, horizon))))
            .fact("largest", norms_json(&self.largest(0.0, end)))
            .fact("periods", columns.collect::<Value>())
            .fact("tenth_left", self.tenth_left)
            .fact("kink", kink)
            .fact("profiles", profiles.collect::<Vec<_>>())
            .fact("mean_forces_first_period", forces_json(&self.first_forces))
            .fact("mean_forces_after_end", forces_json(&self.last_forces))
            .facts(fields!(self => energy_error; self.stats => force_evaluations))
            .fact("wall_s", self.wall.as_secs_f64())
            .fact("scene_file", scene_json(scene))
            .words(self.words())
            .table(norms)
            .table(periods)
            .words(self.marks())
            .words(self.fate())
            .table(states)
            .table(forces)
            .picture(picture)
    }

    /// All samples, and those at multiples of the period; states; mean contact forces of bonds.
    fn tables(&self) -> [Table; 4] {
        let all: Vec<_> = self.samples.iter().map(|sample| (sample, sample.norms)).collect();
        let mut before = 0.0;
        let largest = |sample: &BrightSample| self.largest(std::mem::replace(&mut before, sample.t), sample.t);
        let largest: Vec<_> = self.periods().map(largest).collect();
        let periods: Vec<_> = self.periods().zip(largest).collect();
        let layout = self.scene.chain().layout();
        let at = |t: f64, state: &[f64], n: usize| {
            let v = layout.v(state).map_or(0.0, |v| v[n]);
            (t, n, [layout.u(state)[n], v, self.breather.site(n, t).u])
        };
        let rows = self.profiles.iter().flat_map(|one| (0..layout.sites()).map(move |n| at(one.t, &one.state, n)));
        let (first, last) = (&self.first_forces, &self.last_forces);
        let forces = first.forces.iter().zip(&last.forces).zip(first.first_bond..);
        let forces: Vec<_> = forces.map(|((first, last), bond)| (bond, [*first, *last])).collect();
        tables(&all, &periods, &rows.collect::<Vec<_>>(), &forces)
    }

    fn words(&self) -> String {
        let Self { scene, breather, .. } = self;
        format!(
            "scene {}; {}; omega_0 = {:.16}, T = {:.6}, horizon = {:.4}, Omega_b = {:.16}, T_b = {:.6}; C_r of the theorem: \
             at least 1/(rho mu^2) = {:.6e}, mu = epsilon^(alpha-1)/kappa",
            scene.title(),
            self.setting,
            breather.omega_0(),
            breather.slow_period(),
            breather.horizon(),
            breather.omega_b(),
            breather.period(),
            breather.mass_condition()
        )
    }

    /// Norms at the times that the theorem and the paper name, and the largest up to these.
    fn marks(&self) -> String {
        let core = self.breather.core();
        let line = |(name, t): (&str, f64)| {
            let sample = self.at(t)?;
            let words = |norms: Norms| {
                let [u, u_dot, v, v_dot] = norms.all();
                format!("e_u {u:.6}, e_udot {u_dot:.6}, e_v {v:.6}, e_vdot {v_dot:.6}")
            };
            let (now, most) = (words(sample.norms), words(self.largest(0.0, t)));
            Some(format!("At {name}, t = {t:.4}: {now}, core share {:.6}; largest up to there: {most}.", sample.share))
        };
        let marks =
            [("30 T_b", self.shown_time()), ("the horizon", self.breather.horizon()), ("the end", self.scene.end())];
        let marks: Vec<_> = marks.into_iter().filter_map(line).collect();
        format!(
            "{} Of {} samples. The core: sites {} to {}, which hold at least 0.999 of sum a_n^2.",
            marks.join(" "),
            self.samples.len(),
            core.start,
            core.end - 1
        )
    }

    /// What becomes of the breather: lost energy, kink, mean contact forces.
    fn fate(&self) -> String {
        let Kink { height_u, height_v, jump_v, between_ends_u, between_ends_v } = self.kink;
        let left = match self.tenth_left {
            Some(t) => {
                let horizons = t / self.breather.horizon();
                format!("10 % of the energy has left the core at t = {t:.4} = {horizons:.3} horizons")
            }
            None => "less than 10 % of the energy has left the core".to_owned(),
        };
        let forces = |forces: &MeanForces| {
            let (low, high) = forces.range();
            format!("{low:.3e} to {high:.3e}, spread {:.3e}", forces.spread())
        };
        format!(
            "{left}. Kink at the end: u rises by {height_u:.6e} from its lowest to its highest, v by {height_v:.6e} = {:.3} epsilon, \
             by {jump_v:.6e} across the centre; between the last bead and the first u by {between_ends_u:.3e}, v by {between_ends_v:.3e}. \
             Mean contact forces over T_b from 0: {}; from the end: {} (the same in all bonds for a periodic motion, zero for a \
             localised one: Theorem nobreath). Largest relative change of the energy: {:.1e}.",
            height_v / self.breather.epsilon(),
            forces(&self.first_forces),
            forces(&self.last_forces),
            self.energy_error
        )
    }

    /// Beads and resonators at the times shown, beside the ansatz at the end; norms over the whole
    /// run and up to the horizon, and the share of the core.
    fn picture(&self, norms: &Table, periods: &Table) -> Panels {
        let Self { scene, breather, .. } = self;
        let (end, horizon) = (scene.end(), breather.horizon());
        // Between multiples of T_b norms oscillate; a short run has few of these.
        let (drawn, when, last) = match self.samples.len() {
            101.. => (periods, "at multiples of T_b, up to T ε^(1−α) at all samples", self.periods().last()),
            _ => (norms, "at all samples", self.samples.last()),
        };
        let four = |norms: Norms| norms.all().map(format_short).join(", ");
        let at = |name: &str, sample: Option<&BrightSample>| {
            sample.map_or(String::new(), |sample| format!("{name}: {}; ", four(sample.norms)))
        };
        let left = self
            .tenth_left
            .map_or(String::new(), |t| format!(" A tenth of the energy has left the core at t = {t:.1}."));
        let share = self.samples.last().map_or(f64::NAN, |one| one.share);
        let how = format!(
            "ε = {}, T = 2π/ω₀ = {:.4}, T ε^(1−α) = {horizon:.3}, T_b = {:.4}. Norms E_u, E_u′, E_v, E_v′ of the \
             distances from the ansatz {when}; {}{}at most {} at any sample up to t = {:.2}.{left} The core has {} of \
             it at the end. By {}.",
            breather.epsilon(),
            breather.slow_period(),
            breather.period(),
            at("at 30 T_b", self.at(self.shown_time())),
            at(&format!("at the last, t = {:.2}", last.map_or(end, |one| one.t)), last),
            four(self.largest(0.0, horizon.min(end))),
            horizon.min(end),
            format_short(share),
            self.setting
        );
        let layout = scene.chain().layout();
        let sites = |name: String, values: &[f64]| Line::new(&name, (0..).map(f64::from).zip(values.iter().copied()));
        let at = |t: f64| format!("t = {t:.2}");
        let mut beads: Vec<Line> = self.profiles.iter().map(|one| sites(at(one.t), layout.u(&one.state))).collect();
        if let Some(last) = self.profiles.last() {
            let ansatz: Vec<f64> = (0..layout.sites()).map(|n| breather.site(n, last.t).u).collect();
            beads.push(sites(format!("ansatz, {}", at(last.t)), &ansatz));
        }
        let moving = |one: &Shown| layout.v(&one.state).map(|v| sites(at(one.t), v));
        let resonators: Vec<Line> = self.profiles.iter().filter_map(moving).collect();
        let mut left = vec![Panel::new(Kind::Sites, ["site n", "position uₙ"], beads)];
        left.extend(
            Some(resonators)
                .filter(|lines| !lines.is_empty())
                .map(|lines| Panel::new(Kind::Sites, ["site n", "position vₙ"], lines)),
        );
        let lines = [("E_u", "e_u"), ("E_u′", "e_udot"), ("E_v", "e_v"), ("E_v′", "e_vdot")];
        let of = |table: &Table, label| table.panel(Kind::Time, [label, "rescaled l₁ norm"], "t", &lines);
        let mut right = vec![of(drawn, "time t")];
        if horizon < end {
            let mut early = of(norms, "time t up to T ε^(1−α)");
            early.lines.iter_mut().for_each(|line| line.points.retain(|point| point.0 <= horizon));
            right.push(early);
        }
        let share = [("share of the core", "core_share")];
        right.push(drawn.panel(Kind::Time, ["time t", "share of the energy"], "t", &share));
        let title = format!("Bright breather, ε = {}", breather.epsilon());
        let columns = vec![Column::new("", left), Column::new("", right)];
        Panels { title, columns, caption: scene_caption(scene, &how) }
    }
}

impl BrightHistory {
    /// The report: half of the swing of beads and the mean of resonators, a row for each period.
    pub fn report(&self) -> Report {
        let Self { scene, breather, t, swing, v, .. } = self;
        let sites = breather.sites();
        let map = |heading: &str, value_label: &str, values: &[f64], signed| {
            let map = SpaceTime {
                site_label: "site n".into(),
                time_label: "time t".into(),
                value_label: value_label.into(),
                values: values.to_vec(),
                sites,
                times: (t[0], t[t.len() - 1]),
                signed,
                ..SpaceTime::default()
            };
            Column::new(heading, [map])
        };
        let columns = vec![
            map("beads: amplitude of uₙ", "amplitude of uₙ in a period", swing, false),
            map("resonators: mean of vₙ", "mean of vₙ in a period", v, true),
        ];
        let how = format!(
            "ε = {}. A row a period T_b = {:.4}: left half of max uₙ − min uₙ of 32 times in it, right the mean of vₙ, at most \
             {} in the last period. Theorem: t ≤ T ε^(1−α) = {:.3}. By {}.",
            breather.epsilon(),
            breather.period(),
            format_short(max_norm(v[v.len() - sites..].iter().copied())),
            breather.horizon(),
            self.setting
        );
        let title = "Bright breather over space and time".to_owned();
        Report::new("history")
            .table(Table::matrix("swing", ("swing", 0), t, swing))
            .table(Table::matrix("v", ("v", 0), t, v))
            .picture(Panels { title, columns, caption: scene_caption(scene, &how) })
    }
}
