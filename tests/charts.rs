//! Charts of stability, against closed forms: limits of steps, resonances, and collocation at the corners.

use hertzchain::{
    experiments::{
        Chart, ChartOptions, ChartPoint, ChartStudy, ChartVerdict, Problem, Resonance, Variant, charts, kick_sum,
        regime,
    },
    integrators::splitting::First,
    method::{Method, Split},
    scene::{Scene, SceneFile},
};
use std::f64::consts::PI;

fn named(names: &[&str]) -> Vec<Method> {
    names.iter().map(|name| Method::named(name).unwrap()).collect()
}

/// Quick charts of some methods on the built-in problem.
fn study(charted: &[Chart], methods: Vec<Method>) -> ChartStudy {
    let options =
        ChartOptions { charts: charted.to_vec(), methods, sites: 1000, periods: 100.0, work: 1e6, quick: true };
    charts(&Problem::built_in(), &options, None, &|_, _| ()).unwrap()
}

/// The matrix of a step of `h omega = z` of a scheme on the kinetic split, kicks and drifts one after the other, on one oscillator: its trace.
fn trace(method: &Method, z: f64) -> f64 {
    let Method::Splitting(scheme, Split::Kinetic) = method else { panic!("a kinetic split") };
    let (first, drifts, kicks) = scheme.flows::<f64>(First::Kick);
    let mut m = [[1.0, 0.0], [0.0, 1.0]];
    let drift = |m: &mut [[f64; 2]; 2], a: f64| (0..2).for_each(|j| m[0][j] += a * m[1][j]);
    let kick = |m: &mut [[f64; 2]; 2], b: f64| (0..2).for_each(|j| m[1][j] -= b * z * z * m[0][j]);
    for k in 0..kicks.len().max(drifts.len()) {
        let both = (drifts.get(k).map(|a| a.value()), kicks.get(k).map(|b| b.value()));
        if first == First::Drift {
            drift(&mut m, both.0.unwrap_or(0.0));
        }
        kick(&mut m, both.1.unwrap_or(0.0));
        if first == First::Kick {
            drift(&mut m, both.0.unwrap_or(0.0));
        }
    }
    m[0][0] + m[1][1]
}

/// Where `|trace|` first passes 2.
fn limit(method: &Method) -> f64 {
    let mut z = 1e-3;
    while trace(method, z).abs() <= 2.0 + 1e-9 {
        z += 1e-4;
    }
    z
}

// Measured: 2e-4 off for verlet, 4e-4 at most; the bisection ends at a factor of 1.0004.
#[test]
fn kinetic_splits_lose_stability_where_the_oscillator_says() {
    let methods = named(&["verlet", "yoshida4", "suzuki4", "yoshida6"]);
    assert!((limit(&methods[0]) - 2.0).abs() < 2e-4);
    let study = study(&[Chart::Light], methods.clone());
    let light = Variant { rho: Some(1e-4), ..Variant::default() };
    for method in &methods {
        let measured = study.point(Chart::Light, &light, method).unwrap().measured.clone().unwrap();
        let (found, truth) = (measured.stability.unwrap(), limit(method));
        assert!((found / truth - 1.0).abs() < 1e-3, "{}: {found} for {truth}", method.name());
        // Far above it the run is lost, far below it is not.
        assert_eq!(measured.ladder[0].verdict, ChartVerdict::Lost);
        assert_ne!(measured.usual.verdict, ChartVerdict::Lost);
    }
}

fn with_rho(rho: &str) -> Problem {
    let text = format!(
        "name = \"two\"\n[chain]\nsites = 2\nalpha = 1.5\nkappa = 1.0\nrho = {rho}\nboundary = \"fixed\"\n\
         [initial]\nkind = \"single-bead\"\nsite = 0\ndisplacement = 1.0\n[span]\nperiods = 1\n"
    );
    Problem::of(&Scene::build(SceneFile::parse(&text, "two").unwrap()).unwrap()).unwrap()
}

/// The resonance of a scheme near `k pi` at a static overlap.
fn resonance(problem: &Problem, method: &Method, k: u32, amplitude: f64) -> Option<Resonance> {
    let options = ChartOptions {
        charts: vec![Chart::Resonances],
        methods: vec![*method],
        sites: 1,
        periods: 1.0,
        work: 1e5,
        quick: true,
    };
    let study = charts(problem, &options, None, &|_, _| ()).unwrap();
    let point = study.resonances.into_iter().find(|point| point.k == k && point.amplitude == amplitude).unwrap();
    point.resonance.unwrap()
}

// For the cradle: k pi - 2 arctan(K h/(2 omega)) < h omega < k pi, the trace being 2 cos(h omega) - (K h/omega) sin(h omega).
#[test]
fn resonances_of_strang_on_the_cradle_have_the_edges_of_the_closed_form() {
    let (cradle, strang) = (with_rho("inf"), named(&["strang-linear"])[0]);
    let options = ChartOptions {
        charts: vec![Chart::Resonances],
        methods: vec![strang],
        sites: 1,
        periods: 1.0,
        work: 1e5,
        quick: true,
    };
    let study = charts(&cradle, &options, None, &|_, _| ()).unwrap();
    let mut resolved = 0;
    for point in study.resonances.iter().filter(|point| point.amplitude < 1.0) {
        let Some(found) = point.resonance.clone().unwrap() else { continue };
        let (near, stiffness) = (f64::from(point.k) * PI, 3.0 * point.amplitude.sqrt());
        let mut lower = near;
        for _ in 0..200 {
            lower = near - 2.0 * (0.5 * stiffness * lower).atan();
        }
        let width = near - lower;
        let off = (found.edges[0] - lower).abs().max((found.edges[1] - near).abs());
        assert!(off < 1e-3 * width, "k = {}, A = {}: {off:e} of {width:e}", point.k, point.amplitude);
        // Strength: cosh of the growth is half the trace in the middle.
        let trace = |x: f64| 2.0 * x.cos() - stiffness * x * x.sin();
        let growth = (0.5 * trace(found.centre).abs()).acosh();
        assert!((found.growth / growth - 1.0).abs() < 1e-3, "{} for {growth}", found.growth);
        // The unpressed chain feels it as well.
        let (inside, beside) = (found.inside.unwrap_or(f64::INFINITY), found.beside.unwrap());
        assert!(inside > 20.0 * beside, "k = {}, A = {}: {inside:e}, {beside:e}", point.k, point.amplitude);
        resolved += 1;
    }
    assert!(resolved >= 12, "{resolved} resonances");
}

// First order: widths and growth of the fast motion with itself (odd k) and with the slow one (even k).
#[test]
fn resonances_with_moving_resonators_are_those_of_first_order() {
    let (rho, alpha, amplitude) = (1.0f64 / 3.0, 1.5f64, 1e-6f64);
    let problem = Problem::built_in();
    let (omega, stiffness) = ((1.0 + 1.0 / rho).sqrt(), 2.0 * alpha * amplitude.powf(alpha - 1.0));
    for name in ["strang-linear", "yoshida4-linear", "kahan-li6-linear"] {
        let method = named(&[name])[0];
        for k in [1, 3, 4] {
            let h = f64::from(k) * PI / omega;
            let slow = (stiffness / (1.0 + rho)).sqrt();
            let (growth, width) = if k % 2 == 1 {
                let s = kick_sum(&method, k).unwrap() * stiffness * rho / (1.0 + rho) * h / (2.0 * omega);
                (s, 2.0 * s)
            } else {
                let g = kick_sum(&method, k / 2).unwrap() * 0.5 * h * slow.powf(1.5) * (rho / omega).sqrt();
                (g, 4.0 * g)
            };
            let found = resonance(&problem, &method, k, amplitude).unwrap();
            let (off, wide) =
                ((found.growth / growth - 1.0).abs(), ((found.edges[1] - found.edges[0]) / width - 1.0).abs());
            assert!(off < 0.1 && wide < 0.1, "{name}, k = {k}: growth {off:.1e}, width {wide:.1e} off");
        }
    }
}

/// Every point of a chart, by collocation.
fn worst(study: &ChartStudy) -> (&ChartPoint, f64) {
    let error = |point: &ChartPoint| point.measured.as_ref().unwrap().usual.error.unwrap_or(f64::INFINITY);
    let all = study.points.iter().map(|point| (point, error(point)));
    all.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
}

// Tolerance 1e-9. Measured: 5e-10 at A = 1e-12, kappa = 1e8, where a period of the resonator is 1e7 times that of contacts; 1e-10 elsewhere.
#[test]
fn collocation_is_stable_and_accurate_at_the_corners() {
    let study = study(&[Chart::Light, Chart::Stiffness, Chart::Alpha, Chart::Length], named(&["collocation"]));
    assert!(study.points.len() > 20);
    for point in &study.points {
        let measured = point.measured.as_ref().unwrap();
        assert!(matches!(measured.usual.verdict, ChartVerdict::Stable | ChartVerdict::Drifting), "{point:?}");
    }
    let (point, error) = worst(&study);
    assert!(error < 1e-9, "{error:e} at {:?}", point.variant);
}

#[test]
fn a_run_takes_collocation_unless_resonators_are_light() {
    let plain = regime(&Scene::load("tw-q15").unwrap());
    assert_eq!(plain.method, Method::Collocation);
    let mut file = SceneFile::parse(&Scene::source("bright-breather-16").unwrap(), "light").unwrap();
    file.chain.rho = 1e-9;
    let text = file.to_toml().replace("kind = \"bright-breather\"", "kind = \"single-bead\"");
    let text: String =
        text.lines()
            .filter(|line| !line.starts_with("center"))
            .map(|line| {
                if line.starts_with("epsilon") { "site = 3\ndisplacement = 1.0\n".into() } else { format!("{line}\n") }
            })
            .collect();
    let light = Scene::build(SceneFile::parse(&text, "light").unwrap()).unwrap();
    let chosen = regime(&light);
    assert_eq!(chosen.method, named(&["strang-linear"])[0]);
    assert!(chosen.reason.contains("Omega_c") && chosen.wording.contains("h omega"), "{chosen:?}");
}

#[cfg(feature = "cli")]
mod command {
    use std::process::{Command, Output};

    fn hertzchain(args: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_hertzchain")).args(args).output().unwrap()
    }

    #[test]
    fn the_command_writes_charts_resumes_and_refuses() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().to_str().unwrap();
        let args = [
            "stability",
            "--charts",
            "alpha,length",
            "--integrators",
            "strang-linear,collocation",
            "--work",
            "1e5",
            "--sites",
            "10",
            "--quick",
            "--json",
            "--out",
            out,
        ];
        let first: serde_json::Value = serde_json::from_slice(&hertzchain(&args).stdout).unwrap();
        let second: serde_json::Value = serde_json::from_slice(&hertzchain(&args).stdout).unwrap();
        assert_eq!((first["computed"].as_u64(), second["computed"].as_u64()), (Some(10), Some(0)));
        assert_eq!(first["points"], second["points"]);
        for key in ["chart", "integrator", "alpha", "verdict", "energy_error", "limits", "ladder"] {
            assert!(!first["points"][0][key].is_null(), "{key}");
        }
        for file in ["stability.json", "alpha.csv", "alpha-ladder.csv", "length.csv", "charts.store"] {
            assert!(folder.path().join(file).exists(), "{file}");
        }
        if cfg!(feature = "plot") {
            assert!(folder.path().join("alpha.png").exists());
        }
        for (args, message) in [
            (vec!["stability", "--charts", "lihgt"], "did you mean \"light\"?"),
            (vec!["stability", "--sites", "0"], "sites = 0 is not valid"),
            (vec!["stability", "--periods", "1e7"], "from 1 to 10^6 contact periods"),
            (vec!["stability", "--work", "1"], "work = 1 is not valid"),
        ] {
            let output = hertzchain(&args);
            let text = String::from_utf8(output.stderr).unwrap();
            assert!(!output.status.success() && text.contains(message), "{args:?}: {text}");
        }
    }

    #[test]
    fn a_run_says_what_it_chose_and_why() {
        let output = hertzchain(&["run", "impact", "--until", "3"]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success() && said.starts_with("collocation, tol 1e-10: omega"), "{said}");
        let output = hertzchain(&["run", "impact", "--until", "3", "--integrator", "verlet"]);
        assert!(output.status.success() && output.stderr.is_empty());
    }
}
