//! Chains with heavy resonators, Sec. 3.2 and 5: Theorem 1, homoclinic solutions, bright breathers.

use super::{INTEGRATOR, Tables};
use crate::{
    dps::{Center, Homoclinic},
    error::Result,
    output::csv,
    run::method::Method,
    scene::Scene,
    study::{
        Adaptive, BrightHistory, BrightSample, BrightStudy, Criterion, LifetimeOptions, LifetimeStudy, Norm, RhoLaw,
        TheoremOptions, TheoremStudy, bright_breather, bright_history, center_word, lifetimes, shown, theorem,
    },
    sweep::Engine,
};

/// Tolerance of the runs of the breather of Sec. 5, and samples per period.
const TOLERANCE: f64 = 1e-12;
const SAMPLES_PER_PERIOD: u32 = 20;
/// Tolerance of the runs of a map of lifetimes.
const LIFETIME_TOLERANCE: f64 = 1e-9;
const LAWS: [RhoLaw; 2] = [RhoLaw::Heavy, RhoLaw::Light];
/// Names of the laws of the mass ratio in legends.
const HEAVY: &str = "ρ = ε^(−2(α−1))";
const LIGHT: &str = "ρ = ε^(−(α−1))";

/// Suprema of Theorem 1: for each exponent, a study for each law of the mass ratio.
pub(super) fn bounds(cases: &[(f64, &[f64])], progress: &(dyn Fn(f64) + Sync)) -> Result<Vec<[TheoremStudy; 2]>> {
    let study = |k: usize, alpha: f64, epsilons: &[f64], rho_law: RhoLaw| {
        let tell = |share: f64, _: &str| progress((k as f64 + share) / (LAWS.len() * cases.len()) as f64);
        theorem(
            &TheoremOptions { alpha, rho_law, epsilons: epsilons.to_vec(), ..Default::default() },
            &Engine::threads(),
            &tell,
        )
    };
    let pair = |(k, (alpha, epsilons)): (usize, &(f64, &[f64]))| {
        let [heavy, light] = LAWS;
        Ok([study(2 * k, *alpha, epsilons, heavy)?, study(2 * k + 1, *alpha, epsilons, light)?])
    };
    cases.iter().enumerate().map(pair).collect()
}

pub(super) fn homoclinics(alpha: f64) -> Result<[Homoclinic; 2]> {
    Ok([Homoclinic::new(alpha, Center::Site)?, Homoclinic::new(alpha, Center::Bond)?])
}

/// The breather of Sec. 5 compared with its ansatz.
pub(super) fn bright(progress: &(dyn Fn(f64) + Sync)) -> Result<BrightStudy> {
    let (scene, options) = bright_run()?;
    bright_breather(&scene, &options, SAMPLES_PER_PERIOD, &mut |share| progress(share))
}

/// The breather of Sec. 5 against site and time.
pub(super) fn history(progress: &(dyn Fn(f64) + Sync)) -> Result<BrightHistory> {
    let (scene, options) = bright_run()?;
    bright_history(&scene, &options, &mut |share| progress(share))
}

/// The scene of the breather of Sec. 5, and the options of its run.
fn bright_run() -> Result<(Scene, Adaptive)> {
    let options = Adaptive { method: Method::named(INTEGRATOR)?, tol: TOLERANCE };
    Ok((Scene::load("bright-breather")?, options))
}

/// Lifetimes by the energy criterion, about a bond, at `alpha = 3/2`.
pub(super) fn lifetime_map(
    epsilons: &[f64],
    rhos: &[f64],
    until: f64,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<LifetimeStudy> {
    let options = LifetimeOptions {
        alpha: 1.5,
        center: Center::Bond,
        criterion: Criterion::Energy,
        epsilons: epsilons.to_vec(),
        rhos: rhos.to_vec(),
        sites: None,
        until: Some(until),
        solver: Adaptive { method: Method::named(INTEGRATOR)?, tol: LIFETIME_TOLERANCE },
    };
    lifetimes(&options, &Engine::threads(), &|share, _| progress(share))
}

pub(super) fn version() -> &'static str {
    concat!("hertzchain ", env!("CARGO_PKG_VERSION"))
}

/// The parameters of the scenes of Sec. 5 in one sentence.
fn chain_words(scene: &Scene, epsilon: f64) -> String {
    let params = scene.chain().params();
    format!("N = {}, free ends, {}, ε = {epsilon}", scene.chain().sites(), crate::study::params_words(params))
}

pub(super) fn bright_caption(study: &BrightStudy) -> String {
    let breather = &study.breather;
    let four = |norms: [f64; 4]| norms.map(shown).join(", ");
    let at = |sample: Option<&BrightSample>| sample.map_or_else(|| "–".to_owned(), |sample| four(sample.norms.all()));
    let left = study.tenth_left.map_or_else(
        || "Less than a tenth of the energy leaves the core".to_owned(),
        |t| format!("A tenth of the energy has left the core at t = {t:.1}"),
    );
    format!(
        "u(0) = 2ε a², v(0) = 0, at rest (ini_num); {}. T = 2π/ω₀ = {:.4}, T ε^(1−α) = {:.3}, T_b = {:.4}. Squares, stars, crosses: t = 0, 30 T_b = {:.2}, 80 T = {:.1}. \
         Norms E_u, E_u′, E_v, E_v′ of (diff_u_l1norm), (diff_v_l1norm) at multiples of T_b. At 30 T_b: {}. Where the curves end, at {:.1}: {}. Other times are other phases: at most {} up to T ε^(1−α); at 80 T {}. {left}. \
         Integrator {}. {}.",
        chain_words(&study.scene, breather.epsilon()),
        breather.slow_period(),
        breather.horizon(),
        breather.period(),
        study.shown_time(),
        study.scene.end(),
        at(study.at(study.shown_time())),
        study.periods().last().map_or(f64::NAN, |sample| sample.t),
        at(study.periods().last()),
        four(study.largest(0.0, breather.horizon()).all()),
        at(study.samples.last()),
        study.setting,
        version()
    )
}

pub(super) fn history_caption(history: &BrightHistory) -> String {
    let breather = &history.breather;
    let sites = breather.sites();
    let largest = |from: usize, to: usize| history.v[from..to].iter().map(|v| v.abs()).fold(0.0, f64::max);
    format!(
        "u(0) = 2ε a² about the bond between sites {} and {}, v(0) = 0, at rest; {}. A row a period T_b = {:.4}: left half of max uₙ − min uₙ of 32 times in it, right the mean of vₙ. \
         Theorem: t ≤ T ε^(1−α) = {:.3}. Largest mean vₙ of the last period: {}. Integrator {}. {}.",
        breather.origin(),
        breather.origin() + 1,
        chain_words(&history.scene, breather.epsilon()),
        breather.period(),
        breather.horizon(),
        shown(largest(history.v.len() - sites, history.v.len())),
        history.setting,
        version()
    )
}

/// A table with `t` and a column for each site.
pub(super) fn history_csv(history: &BrightHistory) -> Tables {
    let sites = history.breather.sites();
    let matrix = |symbol: &str, values: &[f64]| {
        let names: Vec<String> =
            std::iter::once("t".to_owned()).chain((0..sites).map(|n| format!("{symbol}_{n}"))).collect();
        let rows = history.t.iter().zip(values.chunks(sites));
        let rows = rows.map(|(&t, row)| std::iter::once(t).chain(row.iter().copied()).collect());
        csv(&names.iter().map(String::as_str).collect::<Vec<_>>(), rows)
    };
    vec![("swing.csv", matrix("swing", &history.swing)), ("v.csv", matrix("v", &history.v))]
}

/// The exponent and the law in file names: `alpha1.5-heavy`.
pub(super) fn bounds_tag(study: &TheoremStudy) -> String {
    let law = if study.options.rho_law == RhoLaw::Heavy { "heavy" } else { "light" };
    format!("alpha{}-{law}", study.options.alpha)
}

pub(super) fn bounds_csv(study: &TheoremStudy) -> Tables {
    vec![("suprema.csv", study.table().csv().into_bytes())]
}

pub(super) fn bounds_caption(pairs: &[[TheoremStudy; 2]]) -> String {
    // The slopes of the norm that is drawn.
    let slopes = |study: &TheoremStudy| {
        let all = study.slopes.iter().filter(|slope| slope.norm == Norm::One);
        let last = all.map(|slope| slope.local.last().map_or_else(|| "–".to_owned(), |s| format!("{s:.3}")));
        last.collect::<Vec<_>>().join(", ").replace('-', "−")
    };
    let words = |[heavy, light]: &[TheoremStudy; 2]| {
        let [first, second, third] = heavy.powers();
        format!(
            "α = {}: powers {first}, {second}, {third}; slopes of the errors themselves over the last decade {} ({}), with light resonators {} ({}). ",
            heavy.options.alpha,
            slopes(heavy),
            heavy.verdict().word(),
            slopes(light),
            light.verdict().word()
        )
    };
    let Some([one, _]) = pairs.first() else { return String::new() };
    format!(
        "From above: error of u with u′ (estimu), v and v′ (estimv), in l₁. Breather about a bond, A(0) = a², C_i = {}, T = {} of slow time, κ = 1; {HEAVY} is the \
         least that the theorem allows, {LIGHT} is less. {}Tolerance {:e} ε^(α−1), {} samples a period. {}.",
        one.options.c_i,
        one.options.horizon,
        pairs.iter().map(words).collect::<String>(),
        one.options.accuracy,
        one.options.sampling.points,
        version()
    )
}

/// `ln(abs(ln(abs(a))))`.
fn double_log(a: f64) -> f64 {
    a.abs().ln().abs().ln()
}

pub(super) fn homoclinic_csv(one: &Homoclinic) -> (&'static str, Vec<u8>) {
    ("profile.csv", csv(&["n", "a", "ln_ln"], one.sites().map(|n| vec![n as f64, one.a(n), double_log(one.a(n))])))
}

pub(super) fn homoclinics_caption(both: &[Homoclinic; 2]) -> String {
    let words = |one: &Homoclinic| {
        let last = *one.sites().end();
        format!(
            "about a {}: a₁ = {}, {} sites above 2.2·10⁻³⁰⁸, slope of the last two {:.6}, residual {:.0e}; ",
            center_word(one.center()),
            shown(one.a(1)).replace('-', "−"),
            one.sites().count(),
            double_log(one.a(last)) - double_log(one.a(last - 1)),
            one.residual()
        )
    };
    let alpha = both[0].alpha();
    format!(
        "Solutions of aₙ = −δ⁺(δ⁻aₙ |δ⁻aₙ|^(α−1)), α = {alpha}: a¹₋ₙ = a¹ₙ about a site, a²₋ₙ₊₁ = −a²ₙ about a bond; {}ln α = {:.6}. \
         Petviashvili's iteration in the middle, then Newton's method with 128 bits. {}.",
        both.iter().map(words).collect::<String>(),
        alpha.ln(),
        version()
    )
}

pub(super) fn lifetimes_caption(study: &LifetimeStudy) -> String {
    let options = &study.options;
    format!(
        "u(0) = 2ε a² about a bond, at rest; α = {}, κ = 1. Lifetime: until the core has less than 0.9 of the energy; followed to t = {} (the command study lifetimes goes on to 25 T ε^(1−α) \
         and to ρ = 10⁵), and > says that it is more. No breather: gaps have opened between the central sites, and what lives on is not the ansatz but beads that swing alone. \
         Lines: x = ρ ε^(2(α−1)), which the theorem wants bounded from below. Chains so long that nothing comes back from their ends. Integrator {}, tol {:e}. {}.",
        options.alpha,
        options.until.unwrap_or(f64::INFINITY),
        options.solver.method.name(),
        options.solver.tol,
        version()
    )
}

#[cfg(feature = "plot")]
mod pictures {
    use super::*;
    use crate::figures::{CellMap, Column, Kind, Line, Maps, Panel, Panels, SpaceTime};
    use crate::study::{Fate, LifetimePoint};

    fn line(name: impl Into<String>, points: impl Iterator<Item = (f64, f64)>) -> Line {
        Line { name: name.into(), points: points.collect() }
    }

    /// Values of `x = rho epsilon^(2(alpha-1))` with a contour on the map of lifetimes.
    const CONTOURS: [f64; 4] = [0.1, 1.0, 10.0, 100.0];

    fn law_words(study: &TheoremStudy) -> &'static str {
        if study.options.rho_law == RhoLaw::Heavy { HEAVY } else { LIGHT }
    }

    /// The lifetime, or the end of the run, and whether it is the latter; `None` for a point that
    /// failed.
    fn lifetime(study: &LifetimeStudy, point: &LifetimePoint) -> Option<(f64, bool)> {
        let life = point.life.as_ref().ok()?;
        Some(life.lifetime(study.options.criterion).map_or((life.end, true), |lifetime| (lifetime, false)))
    }

    /// The note in the cell of a point: the value, with `>` if the life is longer.
    fn note(study: &LifetimeStudy, point: &LifetimePoint, scale: f64) -> String {
        let Some((time, open)) = lifetime(study, point) else { return "failed".to_owned() };
        let value = time / scale;
        let digits = if value < 10.0 { 2 } else { usize::from(value < 100.0) };
        format!("{}{value:.digits$}", if open { "> " } else { "" })
    }

    pub(in super::super) fn bright_panels(title: &str, study: &BrightStudy, caption: String) -> Panels {
        let layout = study.scene.chain().layout();
        let words = ["t = 0", "t = 30 T_b", "t = 80 T"];
        let profile = |symbol: &str, of: &dyn Fn(&[f64]) -> Vec<f64>| {
            let lines = study.profiles.iter().zip(words).map(|(shown, name)| {
                line(name, of(&shown.state).into_iter().enumerate().map(|(n, value)| (n as f64, value)))
            });
            Panel { x_label: "site n".into(), y_label: symbol.into(), lines: lines.collect(), ..Panel::default() }
        };
        let u = profile("uₙ", &|y| layout.u(y).to_vec());
        let v = profile("vₙ", &|y| layout.v(y).unwrap_or_default().to_vec());
        let norms = |label: &str, to: f64| {
            let names = ["E_u", "E_u′", "E_v", "E_v′"];
            let samples = || study.periods().filter(move |sample| sample.t <= to);
            let of = |(k, name): (usize, &str)| line(name, samples().map(|sample| (sample.t, sample.norms.all()[k])));
            Panel {
                kind: Kind::Time,
                x_label: label.into(),
                y_label: "rescaled l₁ norm".into(),
                lines: names.into_iter().enumerate().map(of).collect(),
                ..Panel::default()
            }
        };
        let early = norms("time t ≤ T ε^(1−α)", study.breather.horizon());
        let columns =
            vec![Column::new("", [u, v]), Column::new("", [norms("time t ≤ 80 T", study.scene.end()), early])];
        Panels { title: title.into(), columns, caption }
    }

    pub(in super::super) fn history_panels(title: &str, history: &BrightHistory, caption: String) -> Panels {
        let t = &history.t;
        let map = |heading: &str, label: &str, values: &[f64], signed: bool| {
            let map = SpaceTime {
                site_label: "site n".into(),
                time_label: "time t".into(),
                value_label: label.into(),
                values: values.to_vec(),
                sites: history.breather.sites(),
                times: (t[0], t[t.len() - 1]),
                signed,
                ..SpaceTime::default()
            };
            Column::new(heading, [map])
        };
        let columns = vec![
            map("beads: amplitude of uₙ", "amplitude of uₙ in a period", &history.swing, false),
            map("resonators: mean of vₙ", "mean of vₙ in a period", &history.v, true),
        ];
        Panels { title: title.into(), columns, caption }
    }

    pub(in super::super) fn bounds_panels(title: &str, pairs: &[[TheoremStudy; 2]], caption: String) -> Panels {
        let column = |pair: &[TheoremStudy; 2]| {
            let powers = pair[0].powers();
            let panel = |(k, name): (usize, &str)| {
                let scaled = |study: &TheoremStudy| {
                    line(
                        law_words(study),
                        study.runs.iter().map(|run| (run.epsilon, study.scaled(run, Norm::One).0[k])),
                    )
                };
                Panel {
                    kind: Kind::LogLog,
                    x_label: "size ε".into(),
                    y_label: format!("{name} / {}", power(powers[k])),
                    lines: pair.iter().map(scaled).collect(),
                    ..Panel::default()
                }
            };
            let names = ["error of u, u′", "sup ‖v‖₁", "sup ‖v′‖₁"];
            Column::new(format!("α = {}", pair[0].options.alpha), names.into_iter().enumerate().map(panel))
        };
        Panels { title: title.into(), columns: pairs.iter().map(column).collect(), caption }
    }

    /// A power of `ε` as text: `ε²`, `ε^1.5`.
    fn power(exponent: f64) -> String {
        match exponent {
            2.0 => "ε²".to_owned(),
            3.0 => "ε³".to_owned(),
            other => format!("ε^{other}"),
        }
    }

    pub(in super::super) fn homoclinic_panels(title: &str, both: &[Homoclinic; 2], caption: String) -> Panels {
        let names = ["a¹ₙ, about a site", "a²ₙ, about a bond"];
        let lines = |from: i64, of: &dyn Fn(&Homoclinic, i64) -> f64| {
            let one = |(one, name): (&Homoclinic, &str)| {
                line(name, one.sites().filter(|n| *n >= from).map(|n| (n as f64, of(one, n))))
            };
            both.iter().zip(names).map(one).collect::<Vec<_>>()
        };
        // The guide is half a unit below the tails, along their outer half.
        let (alpha, last) = (both[0].alpha(), *both[0].sites().end());
        let end = double_log(both[0].a(last)) - 0.5;
        let guide = (last / 2..=last).map(|n| (n as f64, end + (n - last) as f64 * alpha.ln()));
        let mut decay = lines(1, &|one, n| double_log(one.a(n)));
        decay.push(line("slope ln α", guide));
        let panel = |y_label: &str, lines: Vec<Line>| {
            Column::new("", [Panel { x_label: "site n".into(), y_label: y_label.into(), lines, ..Panel::default() }])
        };
        let profiles = panel("aₙ", lines(i64::MIN, &Homoclinic::a));
        Panels { title: title.into(), columns: vec![profiles, panel("ln |ln |aₙ||", decay)], caption }
    }

    pub(in super::super) fn lifetime_maps(title: &str, study: &LifetimeStudy, caption: String) -> Maps {
        let (x, y) = (&study.options.epsilons, &study.options.rhos);
        // Points are ordered by size and then by mass ratio; the rows of a map hold all sizes of a
        // mass ratio.
        let points: Vec<&LifetimePoint> =
            (0..x.len() * y.len()).map(|k| &study.points[(k % x.len()) * y.len() + k / x.len()]).collect();
        let (first, last) = (x[0] / 3_f64.sqrt(), x[x.len() - 1] * 3_f64.sqrt());
        let contour = |x: f64| {
            let epsilons = (0..=400).map(|k| first * (last / first).powf(f64::from(k) / 400.0));
            line(
                format!("x = {x}"),
                epsilons.map(|epsilon| (epsilon, x * RhoLaw::Heavy.rho(study.options.alpha, epsilon))),
            )
        };
        let fate = |point: &LifetimePoint| point.life.as_ref().ok().map(|life| life.fate);
        let cells =
            |wanted: &dyn Fn(&LifetimePoint) -> bool| (0..points.len()).filter(|&k| wanted(points[k])).collect();
        let decoupled = |point: &LifetimePoint| fate(point) == Some(Fate::Decouples);
        let longer = |point: &LifetimePoint| !decoupled(point) && lifetime(study, point).is_some_and(|(_, open)| open);
        let apart: Vec<(String, Vec<usize>)> = vec![
            ("longer than the run".to_owned(), cells(&longer)),
            ("gaps open: no breather".to_owned(), cells(&decoupled)),
        ];
        let map = |label: &str, scale: &dyn Fn(&LifetimePoint) -> f64| CellMap {
            labels: ["size ε", "mass ratio ρ", label].map(String::from),
            x: x.clone(),
            y: y.clone(),
            values: points
                .iter()
                .map(|point| lifetime(study, point).map_or(f64::NAN, |(t, _)| t / scale(point)))
                .collect(),
            notes: points.iter().map(|point| note(study, point, scale(point))).collect(),
            lines: CONTOURS.map(contour).into(),
            apart: apart.clone(),
        };
        let maps = vec![map("lifetime", &|_| 1.0), map("lifetime / (T ε^(1−α))", &|point| point.horizon)];
        Maps { title: title.into(), maps, caption }
    }
}

#[cfg(feature = "plot")]
pub(super) use pictures::{bounds_panels, bright_panels, history_panels, homoclinic_panels, lifetime_maps};
