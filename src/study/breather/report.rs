//! Breathers as text, JSON, tables and pictures.

use super::{BrightSample, BrightStudy, Kink, TrivialStudy};
use crate::{
    breathers::Norms,
    chain::MeanForces,
    error::Result,
    output::csv,
    present::table,
    study::{File, Report, named, scene_json},
};
use serde_json::{Value, json};

impl Report for BrightStudy {
    /// `at_30_periods`, `at_horizon` and `largest_to_horizon` are null for runs that end before;
    /// `tenth_left` where the core keeps its energy.
    fn json(&self) -> Value {
        let BrightStudy { scene, breather, samples, kink, .. } = self;
        let (params, core, end) = (breather.params(), breather.core(), scene.end());
        let column = |of: fn(&BrightSample) -> f64| self.periods().map(of).collect::<Vec<_>>();
        let reached = breather.horizon() <= end;
        let profiles: Vec<Value> = self
        .profiles
        .iter()
        .map(|profile| {
            let layout = scene.chain().layout();
            json!({"t": profile.t, "u": layout.u(&profile.state), "v": layout.v(&profile.state).unwrap_or_default()})
        })
        .collect();
        json!({
            "scene": scene.name(),
            "setting": self.setting,
            "center": breather.profile().center(),
            "alpha": params.alpha,
            "kappa": params.kappa,
            "rho": if params.rho.is_finite() { json!(params.rho) } else { json!("inf") },
            "epsilon": breather.epsilon(),
            "sites": breather.sites(),
            "boundary": scene.chain().boundary(),
            "omega_0": breather.omega_0(),
            "slow_period": breather.slow_period(),
            "horizon": breather.horizon(),
            "omega_b": breather.omega_b(),
            "period": breather.period(),
            "mass_condition": breather.mass_condition(),
            "t": end,
            "samples": samples.len(),
            "core": {"first": core.start, "last": core.end - 1, "sites": core.len()},
            "at_30_periods": sample_json(self.at(self.shown_time())),
            "at_horizon": sample_json(self.at(breather.horizon())),
            "final": sample_json(samples.last()),
            "largest_to_horizon": if reached { norms_json(&self.largest(0.0, breather.horizon())) } else { Value::Null },
            "largest": norms_json(&self.largest(0.0, end)),
            "periods": {
                "t": column(|sample| sample.t),
                "e_u": column(|sample| sample.norms.u),
                "e_udot": column(|sample| sample.norms.u_dot),
                "e_v": column(|sample| sample.norms.v),
                "e_vdot": column(|sample| sample.norms.v_dot),
                "participation": column(|sample| sample.participation),
                "core_share": column(|sample| sample.share),
            },
            "tenth_left": self.tenth_left,
            "kink": {
                "height_u": kink.height_u,
                "height_v": kink.height_v,
                "jump_v": kink.jump_v,
                "between_ends_u": kink.between_ends_u,
                "between_ends_v": kink.between_ends_v,
            },
            "profiles": profiles,
            "mean_forces_first_period": forces_json(&self.first_forces),
            "mean_forces_after_end": forces_json(&self.last_forces),
            "energy_error": self.energy_error,
            "force_evaluations": self.stats.force_evaluations,
            "wall_s": self.wall.as_secs_f64(),
            "scene_file": scene_json(scene),
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self) -> String {
        let BrightStudy { scene, breather, samples, .. } = self;
        let (core, end) = (breather.core(), scene.end());
        let mut text = format!(
            "scene {}: {}\n{}\nomega_0 = {:.16}, T = {:.6}, horizon = {:.4}, Omega_b = {:.16}, T_b = {:.6}\nC_r of the theorem: at least \
         1/(rho mu^2) = {:.6e}, mu = epsilon^(alpha-1)/kappa\n\n",
            scene.name(),
            scene.file().summary,
            self.setting,
            breather.omega_0(),
            breather.slow_period(),
            breather.horizon(),
            breather.omega_b(),
            breather.period(),
            breather.mass_condition()
        );
        let count = self.periods().count();
        let every = count.div_ceil(ROWS).max(1);
        let mut shown: Vec<&BrightSample> = self.periods().step_by(every).collect();
        shown.extend([self.shown_time(), breather.horizon(), end].into_iter().filter_map(|t| self.at(t)));
        shown.sort_by(|a, b| a.t.total_cmp(&b.t));
        shown.dedup_by(|a, b| a.t == b.t);
        let period = breather.period();
        let rows: Vec<_> = shown.iter().map(|sample| sample_row(sample, period)).collect();
        let share = format!("share of {} sites", core.len());
        text += &table(&["t", "t / T_b", "E_u", "E_u'", "E_v", "E_v'", "participation", &share], &rows);
        let line = |words: &str, to: f64| {
            let [u, u_dot, v, v_dot] = self.largest(0.0, to).all();
            format!("largest up to {words} t = {to:.4}: E_u {u:.6}, E_u' {u_dot:.6}, E_v {v:.6}, E_v' {v_dot:.6}\n")
        };
        text += "\n";
        if breather.horizon() <= end {
            text += &line("the horizon,", breather.horizon());
        }
        text += &line("the end,", end);
        text += &format!(
            "of {} samples. E: l_1 distances from the ansatz (diff_u_l1norm), (diff_v_l1norm). Participation: (sum e_n)^2 / sum e_n^2 of site energies;\n\
         share: of the energy, in sites {} to {}, which hold at least 0.999 of sum a_n^2. Half of a contact's energy counts for either bead.\n\n",
            samples.len(),
            core.start,
            core.end - 1
        );
        text + &fate(self)
    }

    /// `norms.csv` (all samples), `periods.csv` (at multiples of `T_b`, with the largest since the
    /// one before), `profiles.csv`, `forces.csv`.
    fn files(&self, json: &str) -> Result<Vec<File>> {
        let mut files = named([("breather.json", json.into())]);
        files.extend(bright_tables(self).into_iter().map(|(name, csv)| (name.to_owned(), csv)));
        Ok(files)
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(named([("breather.png", bright_picture(self)?)]))
    }
}

/// Approximate number of rows of the table at multiples of the period.
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

fn sample_row(sample: &BrightSample, period: f64) -> Vec<String> {
    let [u, u_dot, v, v_dot] = sample.norms.all().map(|norm| format!("{norm:.8}"));
    let numbers = [format!("{:.4}", sample.t), format!("{:.3}", sample.t / period), u, u_dot, v, v_dot];
    numbers.into_iter().chain([format!("{:.4}", sample.participation), format!("{:.6}", sample.share)]).collect()
}

/// What becomes of the breather, in words: lost energy, kink, mean contact forces.
fn fate(study: &BrightStudy) -> String {
    let Kink { height_u, height_v, jump_v, between_ends_u, between_ends_v } = study.kink;
    let epsilon = study.breather.epsilon();
    let left = match study.tenth_left {
        Some(t) => {
            format!("10 % of the energy has left the core at t = {t:.4} = {:.3} horizons", t / study.breather.horizon())
        }
        None => "less than 10 % of the energy has left the core".to_owned(),
    };
    let forces = |forces: &MeanForces| {
        let (low, high) = forces.range();
        format!("{low:.3e} to {high:.3e}, spread {:.3e}", forces.spread())
    };
    format!(
        "{left}.\nkink at the end: u rises by {height_u:.6e} from its lowest to its highest, v by {height_v:.6e} = {:.3} epsilon, \
         by {jump_v:.6e} across the centre;\nbetween the last bead and the first u by {between_ends_u:.3e}, v by {between_ends_v:.3e}.\n\
         mean contact forces over T_b from 0: {}; from the end: {}\n(the same in all bonds for a periodic motion, zero for a localised one: Theorem nobreath).\n\
         largest relative change of the energy: {:.1e}.\n",
        height_v / epsilon,
        forces(&study.first_forces),
        forces(&study.last_forces),
        study.energy_error
    )
}

/// All tables as `(file name, CSV)`.
pub(crate) fn bright_tables(study: &BrightStudy) -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("norms.csv", norms_csv(study)),
        ("periods.csv", periods_csv(study)),
        ("profiles.csv", profiles_csv(study)),
        ("forces.csv", forces_csv(study)),
    ]
}

/// All samples: `t, e_u, e_udot, e_v, e_vdot, participation, core_share, energy`.
fn norms_csv(study: &BrightStudy) -> Vec<u8> {
    let row = |sample: &BrightSample| {
        let rest = [sample.participation, sample.share, sample.energy];
        [sample.t].into_iter().chain(sample.norms.all()).chain(rest).collect()
    };
    let names = ["t", "e_u", "e_udot", "e_v", "e_vdot", "participation", "core_share", "energy"];
    csv(&names, study.samples.iter().map(row))
}

/// At multiples of `T_b`: `t`, norms, and the largest of each since the row before.
fn periods_csv(study: &BrightStudy) -> Vec<u8> {
    let mut before = 0.0;
    let rows = study.periods().map(|sample| {
        let largest = study.largest(before, sample.t);
        before = sample.t;
        [sample.t].into_iter().chain(sample.norms.all()).chain(largest.all()).collect()
    });
    let names = ["t", "e_u", "e_udot", "e_v", "e_vdot", "e_u_max", "e_udot_max", "e_v_max", "e_vdot_max"];
    csv(&names, rows)
}

/// Displacements at 0, at 30 `T_b` and at the end, with the ansatz there: `t, n, u, v, u_ansatz`.
fn profiles_csv(study: &BrightStudy) -> Vec<u8> {
    let layout = study.scene.chain().layout();
    let rows = study.profiles.iter().flat_map(|profile| {
        let (u, v) = (layout.u(&profile.state), layout.v(&profile.state));
        (0..u.len()).map(move |n| {
            let resonator = v.map_or(0.0, |v| v[n]);
            vec![profile.t, n as f64, u[n], resonator, study.breather.site(n, profile.t).u]
        })
    });
    csv(&["t", "n", "u", "v", "u_ansatz"], rows)
}

/// Mean contact forces by bond: `bond, first_period, after_end`.
fn forces_csv(study: &BrightStudy) -> Vec<u8> {
    let (first, last) = (&study.first_forces, &study.last_forces);
    let bonds = first.forces.iter().zip(&last.forces).enumerate();
    csv(&["bond", "first_period", "after_end"], bonds.map(|(k, (a, b))| vec![(first.first_bond + k) as f64, *a, *b]))
}

impl Report for TrivialStudy {
    /// `least_slack` is null for a single bead.
    fn json(&self) -> Value {
        let TrivialStudy { scene, breather, .. } = self;
        let params = breather.params();
        json!({
            "scene": scene.name(),
            "setting": self.setting,
            "alpha": params.alpha,
            "kappa": params.kappa,
            "rho": params.rho,
            "sites": breather.means().len(),
            "omega": params.omega(),
            "period": scene.period(),
            "t": scene.end(),
            "samples": self.t.len(),
            "amplitudes": breather.amplitudes(),
            "phases": breather.phases(),
            "means": breather.means(),
            "kink_height": kink_height(self),
            "least_slack": self.least_slack.map(|(bond, slack)| json!({"bond": bond, "slack": slack})),
            "deviation_final": self.deviation.last(),
            "deviation_max": largest(&self.deviation),
            "energy_error": self.energy_error,
            "mean_forces": forces_json(&self.forces),
            "force_evaluations": self.stats.force_evaluations,
            "wall_s": self.wall.as_secs_f64(),
            "scene_file": scene_json(scene),
            "version": env!("CARGO_PKG_VERSION"),
        })
    }

    fn text(&self) -> String {
        let TrivialStudy { scene, breather, .. } = self;
        let slack = match self.least_slack {
            Some((bond, slack)) => format!("least gap beyond (constraint2): {slack:.3e}, at bond {bond}\n"),
            None => String::new(),
        };
        let (low, high) = self.forces.range();
        format!(
            "scene {}: {}\nomega = {:.16}, period = {:.16}, {} sites\nb rises by {:.6e} from the first site to the last; {slack}closed form (uncpl) against {}: \
         {:.3e} of the amplitude at t = {}, at most {:.3e} on the way\nmean contact forces over a period: {low:.3e} to {high:.3e} (zero: Theorem nobreath)\n\
         energy of the closed form constant to {:.1e} of itself\n",
            scene.name(),
            scene.file().summary,
            breather.params().omega(),
            scene.period(),
            breather.means().len(),
            kink_height(self),
            self.setting,
            self.deviation.last().copied().unwrap_or_default(),
            scene.end(),
            largest(&self.deviation),
            self.energy_error
        )
    }

    /// `sites.csv`: amplitude, phase and mean position by site, and the gap to the site before
    /// beyond what is needed; `deviation.csv`: in time.
    fn files(&self, json: &str) -> Result<Vec<File>> {
        let breather = &self.breather;
        let site = |n: usize| {
            let slack = if n == 0 { f64::INFINITY } else { breather.slack(n) };
            vec![n as f64, breather.amplitudes()[n], breather.phases()[n], breather.means()[n], slack]
        };
        let sites = csv(&["n", "a", "phi", "b", "slack"], (0..breather.means().len()).map(site));
        let rows = self.t.iter().zip(&self.deviation).map(|(&t, &deviation)| vec![t, deviation]);
        let deviation = csv(&["t", "deviation"], rows);
        Ok(named([("breather.json", json.into()), ("sites.csv", sites), ("deviation.csv", deviation)]))
    }

    #[cfg(feature = "plot")]
    fn pictures(&self) -> Result<Vec<crate::study::Drawing>> {
        Ok(named([("breather.png", trivial_picture(self)?)]))
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// `b` of the last site less that of the first.
fn kink_height(study: &TrivialStudy) -> f64 {
    let means = study.breather.means();
    means.last().copied().unwrap_or_default() - means.first().copied().unwrap_or_default()
}

/// Beads and resonators at the end beside the ansatz; distances from it, and the share of the core,
/// in time.
#[cfg(feature = "plot")]
fn bright_picture(study: &BrightStudy) -> Result<crate::figures::Picture> {
    use crate::figures::{Column, Kind, Line, Panel, Panels, panels};
    let BrightStudy { scene, breather, samples, profiles, .. } = study;
    let (layout, last) = (scene.chain().layout(), &profiles[profiles.len() - 1]);
    let sites = |name: &str, values: Vec<f64>| Line::new(name, (0..).map(f64::from).zip(values));
    let ansatz = (0..layout.sites()).map(|n| breather.site(n, last.t).u).collect();
    let beads = vec![sites("chain", layout.u(&last.state).to_vec()), sites("ansatz", ansatz)];
    let resonators = layout.v(&last.state).map(|v| vec![sites("resonators", v.to_vec())]);
    let mut left = vec![Panel::new(Kind::Sites, ["site n", "position uₙ"], beads)];
    left.extend(resonators.map(|lines| Panel::new(Kind::Sites, ["site n", "position vₙ"], lines)));
    let time =
        |name: &str, of: &dyn Fn(&BrightSample) -> f64| Line::new(name, samples.iter().map(|one| (one.t, of(one))));
    let norms = vec![time("E_u", &|one| one.norms.u), time("E_v", &|one| one.norms.v)];
    let share = vec![time("share of the core", &|one| one.share)];
    let right = vec![
        Panel::new(Kind::Time, ["time t", "distance from the ansatz"], norms),
        Panel::new(Kind::Time, ["time t", "share of the energy"], share),
    ];
    let how = format!(
        "Beads and resonators at t = {:.6}; l₁ distances from the ansatz; share of the energy in the core. {}.",
        last.t, study.setting
    );
    let figure = Panels {
        title: format!("Bright breather, ε = {}", breather.epsilon()),
        columns: vec![Column::new("", left), Column::new("", right)],
        caption: crate::study::provenance(scene, &how),
    };
    Ok(panels(&figure)?)
}

/// Amplitudes and mean positions by site; the distance of the integrator from the closed form in
/// time.
#[cfg(feature = "plot")]
fn trivial_picture(study: &TrivialStudy) -> Result<crate::figures::Picture> {
    use crate::figures::{Kind, Line, Panel, Panels, panels};
    let breather = &study.breather;
    let sites = |label: &str, values: &[f64]| {
        let line = Line::new(label, (0..).map(f64::from).zip(values.iter().copied()));
        Panel::new(Kind::Sites, ["site n", label], vec![line])
    };
    // A zero has no place on a logarithmic axis: it is drawn below every rounding.
    let distances = study.deviation.iter().map(|deviation| deviation.max(1e-17));
    let line = Line::new("integrator against closed form", study.t.iter().copied().zip(distances));
    let deviation = Panel::new(Kind::LogTime, ["time t", "distance over amplitude"], vec![line]);
    let panels_of =
        vec![sites("amplitude aₙ", breather.amplitudes()), sites("mean position bₙ", breather.means()), deviation];
    let how = format!("Closed form (uncpl) against {}.", study.setting);
    let caption = crate::study::provenance(&study.scene, &how);
    Ok(panels(&Panels::column("Trivial breather", panels_of, caption))?)
}
