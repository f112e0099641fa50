//! Scenes in SI units: runs, sweeps, and `orbit driven`, `orbit continue` and `orbit mode`.
//!
//! | symbol | meaning |
//! |---|---|
//! | `R, m` | radius and mass of a steel sphere |
//! | `A` | Hertz's constant of two spheres, `E (2 R)^{1/2}/(3 (1 - nu^2))` |
//! | `F0` | static load; a contact has the stiffness `k = 3/2 A^{2/3} F0^{1/3}` |
//! | `f_q` | `(k/m)^{1/2} sin(theta/2)/pi`, the dispersion of linear waves of wave number `theta` |
//!
//! `A` and its load: K. L. Johnson, *Contact Mechanics*, Cambridge University Press 1985, section
//! 4.2. Waves of equal masses and springs: L. Brillouin, *Wave Propagation in Periodic Structures*,
//! 2nd ed., Dover 1953.

use super::numbers::rk4;
use super::program::{hertzchain, json, number, stdout, table};
use serde_json::Value;
use std::{f64::consts::PI, fs};

const RADIUS: f64 = 9.525e-3;
const LOAD: f64 = 20.0;

fn mass() -> f64 {
    4.0 / 3.0 * PI * RADIUS.powi(3) * 8027.0
}

fn hertz() -> f64 {
    193e9 * (2.0 * RADIUS).sqrt() / (3.0 * (1.0 - 0.09))
}

/// `(k/m)^{1/2}`.
fn rate() -> f64 {
    (1.5 * hertz().powf(2.0 / 3.0) * LOAD.cbrt() / mass()).sqrt()
}

/// The unit of time, `(m/(A R^{1/2}))^{1/2}`.
fn time() -> f64 {
    (mass() / (hertz() * RADIUS.sqrt())).sqrt()
}

/// The unit of force, `A R^{3/2}`.
fn newton() -> f64 {
    hertz() * RADIUS.powf(1.5)
}

/// A scene of steel spheres under the load.
fn spheres(sites: usize, boundary: &str, more: &str) -> String {
    format!(
        "name = \"spheres\"\n[chain]\nsites = {sites}\nalpha = 1.5\nboundary = \"{boundary}\"\n[initial]\n\
         kind = \"single-bead\"\nsite = 0\nvelocity = 0.0\n[span]\nuntil = 5e-5\n[units]\nsystem = \"SI\"\nradius = {RADIUS}\n\
         density = 8027.0\nyoung = 193e9\npoisson = 0.3\nstatic_load = {LOAD}\n{more}"
    )
}

/// Four spheres, the first of which a drive moves; the wall is as stiff as a contact of two
/// spheres, so that the chain of the other three is that of equal springs between two walls.
///
/// With `c = (1 - nu^2)/E` two spheres have `(R/2)^{1/2}/(2 c)`, a sphere and a wall
/// `R^{1/2}/(c + c_w)`: so `c_w = (8^{1/2} - 1) c`.
fn driven_spheres(loss: f64, amplitude: f64, omega: f64) -> String {
    let wall = 193e9 / (8f64.sqrt() - 1.0);
    let drive = format!(
        "[[drive]]\nsite = 0\nkind = \"moved\"\namplitude = {amplitude}\nomega = {omega}\nphase = {}\n",
        PI / 2.0
    );
    let beads = format!("[beads]\ntau = {{ value = {}, except = [[0, inf]] }}\n", loss.recip());
    spheres(4, "fixed", &format!("wall_young = {wall}\nwall_poisson = 0.3\n{beads}{drive}"))
}

/// Real and imaginary parts of the displacements, over that of the first sphere, of the other three
/// if the first moves by `cos(omega t)`: a sum over the modes `sin(pi q n/4)` of three masses
/// between walls.
fn linear_response(loss: f64, omega: f64) -> Vec<[f64; 2]> {
    let of = |n: u32, q: u32| {
        let angle = |k: u32| PI * f64::from(q * k) / 4.0;
        let frequency = 2.0 * rate() * (0.5 * angle(1)).sin();
        // What drives the mode, over frequency^2 - omega^2 + i loss omega.
        let (re, im) = (frequency * frequency - omega * omega, loss * omega);
        let size = 0.5 * angle(1).sin() * angle(n).sin() * rate() * rate() / (re * re + im * im);
        [size * re, -size * im]
    };
    let sum = |n| (1..=3).map(|q| of(n, q)).fold([0.0; 2], |[a, b], [re, im]| [a + re, b + im]);
    (1..=3).map(sum).collect()
}

#[test]
fn a_driven_chain_resonates_in_hertz_where_the_dispersion_says() {
    // Truth: the linear response of three masses between walls, whose resonances have the published
    // frequencies. What contacts add is of the relative order strain/overlap, here up to 3e-5.
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (loss, amplitude) = (360.0, 1e-12);
    let lowest = rate() * (PI / 8.0).sin() / PI;
    assert!((lowest - 3081.0).abs() < 1.0, "{lowest} Hz");
    let from = 2.0 * PI * 0.98 * lowest;
    fs::write(path("scene.toml"), driven_spheres(loss, amplitude, from)).unwrap();

    let orbit = json(&["orbit", "driven", &path("scene.toml")]);
    assert!((number(&orbit, "/drive/amplitude") / amplitude - 1.0).abs() < 1e-14);
    assert!((number(&orbit, "/drive/omega") / from - 1.0).abs() < 1e-14);
    assert!((number(&orbit, "/drive/frequency") / (0.98 * lowest) - 1.0).abs() < 1e-13);
    assert!((number(&orbit, "/drive/period") * 0.98 * lowest - 1.0).abs() < 1e-13);
    let truth = linear_response(loss, from);
    let size = truth.iter().map(|[re, im]| re.hypot(*im)).fold(0.0, f64::max);
    for (n, [re, im]) in (1..).zip(&truth) {
        // u = a Re(h e^{i omega t}), so that u'(0) = -a omega Im h.
        let [u, u_dot] = ["u", "u_dot"].map(|name| number(&orbit, &format!("/{name}/{n}")) / amplitude);
        assert!((u - re).hypot(u_dot / from + im) < 2e-5 * size, "{n}: {u} {re}, {} {}", u_dot / from, -im);
    }
    // Work against the drag: half of its constant (loss times the mass) times (a omega |h|)^2, over
    // a period.
    let speeds: f64 = truth.iter().map(|[re, im]| (re.hypot(*im) * amplitude * from).powi(2)).sum();
    let lost = 0.5 * loss * mass() * speeds * 2.0 * PI / from;
    for name in ["/dissipated", "/driven"] {
        assert!((number(&orbit, name) / lost - 1.0).abs() < 1e-4, "{name} {} {lost}", number(&orbit, name));
    }

    let to = format!("{}", 2.0 * PI * 1.02 * lowest);
    let step = format!("{}", 2.0 * PI * 0.002 * lowest);
    let args = ["orbit", "continue", &path("scene.toml"), "--vary", "omega", "--to", &to, "--step", &step];
    let text = stdout(&[&args[..], &["--out", &path("out")]].concat());
    assert!(text.ends_with("all numbers here are in SI units\n"), "{text}");
    let (names, rows) = table(&folder.path().join("out/driven-branch.csv"));
    assert_eq!(names, "omega,response,max_modulus,unstable,frequency");
    assert!((rows[rows.len() - 1][4] / (1.02 * lowest) - 1.0).abs() < 1e-12);
    for row in &rows {
        let (omega, frequency) = (row[0], row[4]);
        assert!((frequency * 2.0 * PI / omega - 1.0).abs() < 1e-15);
        let largest = linear_response(loss, omega).iter().map(|[re, im]| re.hypot(*im)).fold(0.0, f64::max);
        // The largest of 64 samples a period misses the crest by at most 1 - cos(pi/64).
        let missed = 1.0 - row[1] / (amplitude * largest);
        assert!((-2e-5..1.0 - (PI / 64.0).cos() + 2e-5).contains(&missed), "{frequency} Hz: {missed:e}");
    }
    let peak = rows.iter().max_by(|a, b| a[1].total_cmp(&b[1])).unwrap()[4];
    // Half of the width of the resonance.
    assert!((peak - lowest).abs() < 0.25 * loss / PI, "{peak} {lowest}");
}

#[test]
fn modes_of_a_ring_of_spheres_have_the_published_frequencies_in_hertz() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    fs::write(path("ring.toml"), spheres(6, "ring", "")).unwrap();
    let args = ["orbit", "mode", &path("ring.toml"), "--linear-mode", "5", "--to", "1e-6", "--step", "2e-7"];
    let mode = json(&args);
    let truth: Vec<f64> = [1, 1, 2, 2, 3].iter().map(|q| rate() * (PI * f64::from(*q) / 6.0).sin() / PI).collect();
    for (one, truth) in mode["linear"].as_array().unwrap().iter().zip(&truth) {
        assert!((number(one, "/frequency") / truth - 1.0).abs() < 1e-13, "{one} {truth}");
        assert!((number(one, "/omega") / (2.0 * PI * truth) - 1.0).abs() < 1e-13);
    }
    // In the highest mode neighbours move against each other by `a`: the strains are 2 a and -2 a,
    // the least overlap is delta - 2 a, and contacts open. The energy of a contact beside that at
    // rest is 2/5 A (g^{5/2} - delta^{5/2}).
    let rest = (LOAD / hertz()).powf(2.0 / 3.0);
    let points = mode["points"].as_array().unwrap();
    assert_eq!(points.len(), 5);
    for point in points {
        let a = number(point, "/amplitude");
        let [closer, apart] = [rest + 2.0 * a, rest - 2.0 * a];
        assert!((number(point, "/least_overlap") - apart).abs() < 1e-12 * rest);
        let stored = |g: f64| 0.4 * hertz() * (g.max(0.0).powf(2.5) - rest.powf(2.5));
        let energy = 3.0 * (stored(closer) + stored(apart));
        assert!((number(point, "/energy") / energy - 1.0).abs() < 1e-10, "{point} {energy}");
    }
    assert!((number(&points[0], "/amplitude") / 2e-7 - 1.0).abs() < 1e-14);
    assert!((number(&points[4], "/amplitude") / 1e-6 - 1.0).abs() < 1e-14);
    assert!((number(&mode, "/last/u/0").abs() / 1e-6 - 1.0).abs() < 1e-12);
    assert_eq!(mode.pointer("/last/u"), mode.pointer("/last/start/u"));

    stdout(&[&args[..], &["--out", &path("out")]].concat());
    let (_, rows) = table(&folder.path().join("out/mode-branch.csv"));
    let fields =
        ["amplitude", "omega", "energy", "participation", "least_overlap", "max_modulus", "unstable", "frequency"];
    for (row, point) in rows.iter().zip(points) {
        assert_eq!(*row, fields.map(|field| point[field].as_f64().unwrap()));
    }
    let (_, rows) = table(&folder.path().join("out/linear-modes.csv"));
    assert!((rows[4][5] / truth[4] - 1.0).abs() < 1e-13);
}

/// The unit of the number with this name, in the JSON of an orbit. `parameter` is the unit of the
/// parameter of a branch.
fn unit(name: &str, parameter: f64) -> f64 {
    let velocity = RADIUS / time();
    match name {
        // The amplitude of a drive that pushes is the parameter of its branch.
        "amplitude" if parameter == newton() => parameter,
        "amplitude" | "u" | "v" | "response" | "bead_ranges" | "strain_ranges" | "least_overlap" => RADIUS,
        "u_dot" | "v_dot" => velocity,
        "omega" => time().recip(),
        "period" => time(),
        "energy" | "driven" | "dissipated" => mass() * velocity * velocity,
        "parameter" => parameter,
        _ => 1.0,
    }
}

/// Holds the JSON in SI units against the dimensionless one; returns the number of numbers.
fn compare(name: &str, si: &Value, plain: &Value, parameter: f64) -> usize {
    match (si, plain) {
        (Value::Object(si), Value::Object(plain)) => {
            for name in si.keys().filter(|name| !plain.contains_key(*name)) {
                assert!(["frequency", "units", "si"].contains(&name.as_str()), "{name}");
            }
            if let (Some(omega), Some(frequency)) = (si.get("omega"), si.get("frequency")) {
                assert!((frequency.as_f64().unwrap() * 2.0 * PI / omega.as_f64().unwrap() - 1.0).abs() < 1e-15);
            }
            let same = plain.iter().filter(|(name, _)| *name != "scene_file");
            same.map(|(name, value)| compare(name, &si[name], value, parameter)).sum()
        }
        (Value::Array(si), Value::Array(plain)) => {
            assert_eq!(si.len(), plain.len(), "{name}");
            si.iter().zip(plain).map(|(si, plain)| compare(name, si, plain, parameter)).sum()
        }
        (Value::Number(si), Value::Number(plain)) => {
            let [si, plain] = [si, plain].map(|number| number.as_f64().unwrap());
            let by = unit(name, parameter);
            assert!((si - plain * by).abs() <= 1e-14 * (plain * by).abs(), "{name}: {si} {plain} {by}");
            assert!(by != 1.0 || si == plain, "{name}");
            1
        }
        _ => {
            assert_eq!(si, plain, "{name}");
            0
        }
    }
}

#[test]
fn every_number_in_si_units_is_the_dimensionless_one_times_its_unit() {
    // Truth: the units by Hertz's formula.
    let folder = tempfile::tempdir().unwrap();
    let ring = folder.path().join("ring.toml").display().to_string();
    fs::write(&ring, spheres(6, "ring", "")).unwrap();
    let pushed = folder.path().join("pushed.toml").display().to_string();
    let drive = "[beads]\ntau = 5.5e-4\n[[drive]]\nsite = 0\nkind = \"pushed\"\namplitude = 50.0\nomega = 3e4\n";
    fs::write(&pushed, spheres(2, "fixed", drive)).unwrap();
    let driven: &[&str] = &["continue", "granular-crystal", "--settle", "20"];
    let cases = [
        (&["driven", "granular-crystal", "--settle", "20"][..], None, 1.0),
        (driven, Some(["4e-8", "1e-8"]), RADIUS),
        (&[driven, &["--vary", "omega"]].concat(), Some(["3.2e4", "5e2"]), time().recip()),
        (&[driven, &["--vary", "damping"]].concat(), Some(["1.2", "0.1"]), 1.0),
        (&["mode", &ring], Some(["1e-6", "2e-7"]), 1.0),
        // With the branch that crosses.
        (&["continue", &pushed, "--switch", "1"], Some(["60", "2"]), newton()),
    ];
    for (command, way, parameter) in cases {
        let [si, plain] = [0, 1].map(|which| {
            let way = way.map_or(Vec::new(), |[to, step]| vec!["--to", to, "--step", step]);
            let plain: &[&str] = if which == 1 { &["--dimensionless"] } else { &[] };
            json(&[&["orbit"], command, &way, plain].concat())
        });
        assert!(plain.get("units").is_none() && plain.get("si").is_none() && si["si"] == true, "{command:?}");
        assert!((number(&si, "/units/time_s") / time() - 1.0).abs() < 1e-14);
        assert_eq!(si["scene_file"], plain["scene_file"]);
        let count = compare("", &si, &plain, parameter);
        assert!(count > 60, "{command:?}: {count} numbers");
    }
    let text = stdout(&["orbit", "continue", &pushed, "--to", "60", "--step", "2", "--switch", "1"]);
    assert!(text.matches("amplitude (N)  response (m)").count() == 2, "{text}");
}

#[test]
fn the_file_of_a_branch_does_not_depend_on_the_units_of_results() {
    // Truth: the bytes of the other order of units.
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let begin = ["orbit", "continue", "granular-crystal", "--settle", "20"];
    let begin = [&begin[..], &["--set", "chain.sites=3", "--set", "initial.site=1", "--out"]].concat();
    stdout(&[&begin[..], &[&path("a"), "--to", "2e-8"]].concat());
    stdout(&[&begin[..], &[&path("b"), "--to", "2e-8", "--dimensionless"]].concat());
    let kept = |name: &str| fs::read(folder.path().join(name).join("driven-branch.npz")).unwrap();
    assert!(kept("a") == kept("b"));
    stdout(&["orbit", "continue", "--resume", &path("a"), "--to", "3e-8", "--dimensionless"]);
    stdout(&["orbit", "continue", "--resume", &path("b"), "--to", "3e-8"]);
    assert!(kept("a") == kept("b"));
    let [(names, plain), (others, si)] =
        ["a", "b"].map(|name| table(&folder.path().join(name).join("driven-branch.csv")));
    assert!(names == others && names == "amplitude,response,max_modulus,unstable" && plain.len() == si.len());
    for (plain, si) in plain.iter().zip(&si) {
        assert!(si[..2].iter().zip(plain).all(|(si, plain)| (si / (plain * RADIUS) - 1.0).abs() < 1e-15), "{si:?}");
        assert_eq!(si[2..], plain[2..]);
    }
    assert!((si[si.len() - 1][0] / 3e-8 - 1.0).abs() < 1e-15);
    // A whole branch is told in either units without being followed again.
    let before = kept("a");
    let text = stdout(&["orbit", "continue", "--resume", &path("a")]);
    assert!(text.contains("amplitude (m)") && kept("a") == before, "{text}");
}

/// Forty steel spheres in free flight that touch, the first struck at 0.5 m/s.
const STRUCK: &str = include_str!("../refusals/struck.toml");

/// Displacements and velocities at the end, and the largest force, of spheres of one mass in a row
/// with the contact constant `A`, by the classical Runge-Kutta method in SI units: the first has
/// the speed `strike`, all lose speed with the time `tau`.
fn struck(sites: usize, strike: f64, tau: f64, until: f64, steps: usize) -> ([Vec<f64>; 2], f64) {
    let force = |u: &[f64], k: usize| hertz() * (u[k] - u[k + 1]).max(0.0).powf(1.5);
    let rates = |y: &[f64]| -> Vec<f64> {
        let push = |k: usize| {
            let behind = if k > 0 { force(y, k - 1) } else { 0.0 };
            let ahead = if k + 1 < sites { force(y, k) } else { 0.0 };
            (behind - ahead) / mass() - y[sites + k] / tau
        };
        y[sites..].iter().copied().chain((0..sites).map(push)).collect()
    };
    let (mut y, mut largest) = (vec![0.0; 2 * sites], 0.0f64);
    y[sites] = strike;
    for _ in 0..steps {
        y = rk4(&rates, &y, until / steps as f64);
        largest = (0..sites - 1).map(|k| force(&y, k)).fold(largest, f64::max);
    }
    let y = [y[..sites].to_vec(), y[sites..].to_vec()];
    (y, largest)
}

#[test]
fn struck_spheres_have_the_speeds_and_forces_of_newtons_equations_in_si_units() {
    // Truth: a Runge-Kutta method in SI units, here. Its error is that of the starts of contacts,
    // h^{5/2}; the largest force is that of a step, off by up to the second order.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("struck.toml").display().to_string();
    for (more, tau) in [("", f64::INFINITY), ("[beads]\ntau = 4e-4\n", 4e-4)] {
        fs::write(&path, format!("{STRUCK}{more}")).unwrap();
        let run = json(&["run", &path, "--events"]);
        let ([u, v], force) = struck(40, 0.5, tau, 6e-4, 6000);
        for i in 0..40 {
            assert!((number(&run, &format!("/u/{i}")) - u[i]).abs() < 1e-6 * u[1].abs(), "{i}");
            let speed = number(&run, &format!("/pu/{i}")) / mass();
            assert!((speed - v[i]).abs() < 1e-6, "{i}: {speed} {}", v[i]);
        }
        let fastest = v.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        assert!((number(&run, "/largest_speed") / fastest - 1.0).abs() < 1e-5);
        assert!((number(&run, "/largest_force") / force - 1.0).abs() < 1e-5, "{} {force}", run["largest_force"]);
        // What was struck was m v^2/2, in joules.
        let kept =
            number(&run, "/energy") + run.pointer("/dissipated/total").map_or(0.0, |lost| lost.as_f64().unwrap());
        assert!((kept / (0.5 * mass() * 0.25) - 1.0).abs() < 1e-9, "{kept}");
        let text = stdout(&["run", &path, "--events"]);
        let told = [format!("force of a contact {force:.6e}"), format!("fastest     {fastest:.6e}")];
        for (told, unit) in told.iter().zip([" N", " m/s at the end, bead"]) {
            assert!(text.contains(&told[..told.len() - 6]) && text.contains(unit), "{told}: {text}");
        }
    }
    // Equal spheres are the chain of equal beads, with its fast loops.
    fs::write(&path, STRUCK).unwrap();
    assert!(stdout(&["run", &path, "--plan"]).contains("contact force as g sqrt(g), vectorised"));
}

#[test]
fn two_spheres_touch_for_the_time_of_hertz() {
    // Truth: with k = 4 A/(5 m'), m' = m/2, the largest overlap is (v^2/k)^{2/5}, and the contact
    // lasts 2.9432751 times this over v (Johnson 1985, section 11.4: 2.94).
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.toml").display().to_string();
    fs::write(&path, STRUCK.replace("sites = 40", "sites = 2").replace("until = 6e-4", "until = 1.5e-4")).unwrap();
    let run = json(&["run", &path, "--events"]);
    let overlap = (0.25 / (0.8 * hertz() / (0.5 * mass()))).powf(0.4);
    assert!((number(&run, "/contacts/largest_overlap") / overlap - 1.0).abs() < 1e-8);
    assert!((number(&run, "/contacts/longest") / (2.943_275_1 * overlap / 0.5) - 1.0).abs() < 1e-7);
    assert!((number(&run, "/largest_force") / (hertz() * overlap.powf(1.5)) - 1.0).abs() < 1e-8);
    assert!((number(&run, "/contacts/impulse") / (mass() * 0.5) - 1.0).abs() < 1e-8);
    // Equal spheres exchange their speeds.
    assert!((number(&run, "/pu/1") / mass() - 0.5).abs() < 1e-9);
    assert_eq!(number(&run, "/t"), 1.5e-4);
}

#[test]
fn spheres_with_dashpots_of_a_power_of_the_overlap_rebound_as_in_si_units() {
    // Truth: e = exp(-pi nu/omega) with nu = gamma/(2 m'), omega^2 = 5/4 A/m' - nu^2 and gamma in
    // kg/(s m^{1/4}), at every speed (Antypov & Elliott 2011). The springs are those given.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.toml").display().to_string();
    let (gamma, reduced) = (600.0, 0.5 * mass());
    let nu = gamma / (2.0 * reduced);
    let truth = (-PI * nu / (1.25 * hertz() / reduced - nu * nu).sqrt()).exp();
    let text = STRUCK.replace("sites = 40", "sites = 2").replace("until = 6e-4", "until = 2e-4");
    fs::write(&path, format!("{text}[bonds]\ndashpot = {gamma}\nbeta = 0.25\npull = true\n")).unwrap();
    for speed in ["0.5", "0.05"] {
        let run = json(&["run", &path, "--tol", "1e-12", "--set", &format!("initial.velocity={speed}")]);
        let e = (number(&run, "/pu/1") - number(&run, "/pu/0")) / (mass() * speed.parse::<f64>().unwrap());
        assert!((e - truth).abs() < 1e-10 && truth < 0.95, "{speed}: {e} {truth}");
    }
    // Of the square of the rate: N s^2/m^(9/4), so that gamma g^beta v^2 is a force in both units.
    let scene = hertzchain::scene::Scene::load_with(&path, &["bonds.rate_power=2".to_owned()]).unwrap();
    let units = scene.units().unwrap();
    let gamma = scene.chain().details().unwrap().dissipation.clone().unwrap().strength[0];
    let (g, v) = (1e-6, 0.3);
    let by = gamma * (g / units.length_m).powf(0.25) * (v / units.velocity_m_per_s).powi(2) * units.force_n;
    assert!((by / (600.0 * g.powf(0.25) * v * v) - 1.0).abs() < 1e-13);
    fs::write(&path, format!("{text}[beads]\nonsite = 3e5\n[bonds]\nspring = 7e4\n")).unwrap();
    let scene = hertzchain::scene::Scene::load(&path).unwrap();
    let (units, details) = (scene.units().unwrap(), scene.chain().details().unwrap());
    let unit = units.force_n / units.length_m;
    for (one, given) in [(details.onsite[1], 3e5), (details.spring[0], 7e4)] {
        assert!((one * unit / given - 1.0).abs() < 1e-14, "{one} {given}");
    }
}

#[test]
fn masses_contacts_springs_and_resonators_are_in_si_units() {
    // Truth: the frequencies of linear oscillators in hertz. A flat bead of 20 g between walls with
    // measured contacts, F = A g^{3/2} each under 20 N, has two stiffnesses 3/2 A^{2/3} F^{1/3};
    // with a spring K to a mass M at rest and in a chain without contacts, (K (1/m + 1/M))^{1/2}.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("one.toml").display().to_string();
    let scene = |boundary: &str, more: &str| {
        format!(
            "[chain]\nsites = 1\nalpha = 1.5\nboundary = \"{boundary}\"\n[initial]\nkind = \"state\"\nu = [1e-9]\n\
             [span]\nuntil = 1e-4\n{more}"
        )
    };
    let flat =
        "[units]\nsystem = \"SI\"\nradius = inf\nstatic_load = 20.0\n[beads]\nmass = 0.02\n[bonds]\ncontact = 8e9\n";
    fs::write(&path, scene("fixed", flat)).unwrap();
    let mode = json(&["orbit", "mode", &path, "--to", "1e-12"]);
    let truth = (2.0 * 1.5 * 8e9f64.powf(2.0 / 3.0) * 20f64.cbrt() / 0.02).sqrt() / (2.0 * PI);
    let found = number(&mode, "/linear/0/frequency");
    assert!((found / truth - 1.0).abs() < 1e-12, "{found} {truth}");

    let (spring, resonator, bead) = (2e6f64, 0.005f64, 0.02f64);
    let omega = (spring * (1.0 / bead + 1.0 / resonator)).sqrt();
    for (springs, at) in [
        ("[beads]\nmass = 0.02\nkappa = 2e6\nresonator = 0.005\n", ""),
        ("[beads]\nmass = 0.02\nkappa = 2e6\nrho = 0.25\n", ""),
        ("[beads]\nmass = 0.02\n", "kappa = 2e6\nrho = 0.25\n"),
    ] {
        let text = scene("free", &format!("[units]\nsystem = \"SI\"\n{springs}"))
            .replace("[initial]", &format!("{at}[initial]"));
        fs::write(&path, text).unwrap();
        let run = json(&["run", &path, "--tol", "1e-12"]);
        // The bead begins at 1 nm, its resonator at 0; the centre of mass stays.
        let share = resonator / (bead + resonator);
        let u = 1e-9 * (1.0 - share + share * (omega * 1e-4).cos());
        assert!((number(&run, "/u/0") - u).abs() < 1e-18, "{springs}{at}: {} {u}", run["u"]);
    }
    // The first sphere is heavier, and the contact of the second bond was measured; all others are
    // those of spheres.
    let changed = "[beads]\nmass = { except = [[0, 0.1]] }\n[bonds]\ncontact = { except = [[1, 1e10]] }\n";
    fs::write(&path, format!("{STRUCK}{changed}").replace("sites = 40", "sites = 4")).unwrap();
    let scene = hertzchain::scene::Scene::load(&path).unwrap();
    let (units, details) = (scene.units().unwrap(), scene.chain().details().unwrap());
    let near = |one: f64, truth: f64| assert!((one / truth - 1.0).abs() < 1e-14, "{one} {truth}");
    near(details.mass[0] * units.mass_kg, 0.1);
    near(details.mass[3] * units.mass_kg, mass());
    let unit = units.force_n / units.length_m.powf(1.5);
    near(details.contact[1] * unit, 1e10);
    near(details.contact[0] * unit, hertz());
    near(details.contact[2] * unit, hertz());
    // The first number of a taper is 1 kg/s if it is left out.
    fs::write(&path, format!("{STRUCK}[beads]\ndrag = {{ taper = 0.5 }}\n")).unwrap();
    let scene = hertzchain::scene::Scene::load(&path).unwrap();
    let drag = &scene.chain().details().unwrap().drag;
    let unit = mass() / time();
    near(drag[0] * unit, 1.0);
    near(drag[2] * unit, 0.25);
}

#[test]
fn steps_samples_checkpoints_and_plans_are_in_si_units() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    fs::write(path("struck.toml"), STRUCK).unwrap();
    // Truth: 2e-4 s in steps of 1e-7 s are 2000.
    let run = json(&["run", &path("struck.toml"), "--until", "2e-4", "--step", "1e-7", "--integrator", "verlet"]);
    assert_eq!((number(&run, "/steps"), number(&run, "/t")), (2000.0, 2e-4));
    assert!(run["setting"].as_str().unwrap().starts_with("2000 steps of 0.0000001 s"), "{}", run["setting"]);
    let file = format!("{STRUCK}[method]\nintegrator = \"verlet\"\nstep = 3e-7\n[record]\nsamples = 3\n");
    fs::write(path("method.toml"), file).unwrap();
    let run = json(&["run", &path("method.toml"), "--out", &path("out")]);
    assert_eq!(number(&run, "/steps"), 2000.0);
    let times: Vec<f64> = table(&folder.path().join("out/energy.csv")).1.iter().map(|row| row[0]).collect();
    assert!(times.iter().zip([0.0, 2e-4, 4e-4, 6e-4]).all(|(t, truth)| (t - truth).abs() < 1e-18), "{times:?}");
    // Three legs of 2e-4 s, with the bits of a run in the same legs that does not stop.
    let legs = ["--checkpoint", "2e-4", "--out"];
    let long = ["run", &path("struck.toml"), "--events"];
    stdout(&[&long[..], &legs, &[&path("legs")]].concat());
    let text = stdout(&["run", "--resume", &path("legs")]);
    assert!(text.contains("in legs of 0.0002 s") && text.contains("reached     t = 0.0006\n"), "{text}");
    // A sweep over a speed in m/s: the pulse of n times the strike has n^{6/5} times the force.
    let plan = "scene = \"struck.toml\"\nkeep = [\"largest_force\", \"contacts.largest_overlap\", \"t\", \"u[0]\"]\n\
                set = [\"span.until=3e-4\"]\n[[axis]]\nkey = \"initial.velocity\"\nvalues = [0.25, 0.5]\n";
    fs::write(path("plan.toml"), plan).unwrap();
    let sweep = json(&["sweep", &path("plan.toml")]);
    let of = |name: &str, k: usize| sweep["columns"][name][k].as_f64().unwrap();
    assert!((of("largest_force", 1) / of("largest_force", 0) / 2f64.powf(1.2) - 1.0).abs() < 1e-6);
    assert_eq!((of("initial.velocity", 1), of("t", 0)), (0.5, 3e-4));
    let run = json(&["run", &path("struck.toml"), "--until", "3e-4", "--events"]);
    assert_eq!(number(&run, "/u/0"), of("u[0]", 1));
    assert!((hertz() * of("contacts.largest_overlap", 1).powf(1.5) / of("largest_force", 1) - 1.0).abs() < 1e-12);
}

#[test]
fn sizes_that_are_hardly_meant_are_said_with_what_explains_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    fs::write(path("struck.toml"), STRUCK).unwrap();
    let likely = [
        ("units.radius=9.5", "units.radius = 9.5 m: more than 1 m; if it is in mm, write 9.5e-3"),
        ("units.young=193", "units.young = 193 Pa: softer than solids; if it is in GPa, write 193e9"),
        ("units.young=193e3", "units.young = 193000 Pa: softer than solids; if it is in MPa, write 193000e6"),
        ("beads.tau=2", "beads.tau = 2 s: it damps by less than 1 % in the run; if it is in ms, write 2e-3"),
        ("initial.velocity=440", "velocity = 440 m/s: above 2 % of the speed of sound in the beads"),
        (HERTZ, "drive.omega = 20000 rad/s: 3183 Hz; if it is in Hz, write frequency = 20000"),
        ("chain.kappa=3", "chain.kappa changes nothing in this scene: a resonator needs a spring and a mass"),
        ("units.density=8.027", "if it is in g/cm^3, write 8.027e3"),
        ("initial.velocity=6000", "sound in the beads, (E/density)^(1/2) = 4903 m/s, where contacts yield"),
        (
            "chain={sites=5,alpha=1.5,boundary=\"fixed\",precompression=0.5}",
            "precompression = 0.5 m: more than a radius; a load in N is units.static_load; if it is in mm, write 0.5e-3",
        ),
        ("initial.displacement=-10", "displacement = -10 m: more than a radius; if it is in mm, write -10e-3"),
    ];
    for (change, words) in likely {
        let run = json(&["run", &path("struck.toml"), "--set", change, "--until", "1e-7", "--samples", "0"]);
        let said = run["warnings"].as_array().unwrap();
        assert!(said.len() == 1 && said[0].as_str().unwrap().contains(words), "{change}: {said:?}");
    }
    // Truth: 2 pi times the frequency.
    let hertz = [HERTZ.replace("omega", "frequency"), HERTZ.replace("2e4", &(2e4 * (2.0 * PI)).to_string())]
        .map(|drive| json(&["run", &path("struck.toml"), "--set", &drive, "--until", "1e-6"])["u"].clone());
    assert_eq!(hertz[0], hertz[1]);
    let out = path("out");
    stdout(&["run", &path("struck.toml"), "--until", "1e-6", "--out", &out]);
    assert!(fs::read_to_string(format!("{out}/final.csv")).unwrap().starts_with("n,u (m),pu (kg m/s)\n"));
    let run = json(&["run", &path("struck.toml"), "--until", "1e-7", "--samples", "0"]);
    assert_eq!(run["warnings"], serde_json::json!([]));
}

/// A drive whose frequency is hardly meant.
const HERTZ: &str = "drive=[{site=0,kind=\"pushed\",amplitude=1.0,omega=2e4}]";

#[test]
fn sweeps_orbits_and_studies_say_sizes_that_are_hardly_meant() {
    // Truth: the words of `run`.
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        fs::write(folder.path().join(name), text).unwrap();
        folder.path().join(name).display().to_string()
    };
    let said = |line: &str, words: &str| {
        let output = hertzchain(&format!("{line} --json"));
        let result: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(result["warnings"].to_string().contains(words), "{line}: {}", result["warnings"]);
        assert!(String::from_utf8_lossy(&output.stderr).contains(&format!("WARNING     {words}")), "{line}");
    };
    let scene = file("struck.toml", STRUCK);
    let axis = "[[axis]]\nkey = \"initial.velocity\"\nvalues = [0.5, 6000.0]\n";
    let head = "set = [\"span.until=1e-7\"]\n";
    let plan = file("plan.toml", &format!("scene = \"{scene}\"\n{head}{axis}"));
    said(&format!("sweep {plan}"), "velocity = 6000 m/s: above 2 % of the speed of sound");
    let few = file("few.toml", &format!("scene = \"{scene}\"\n{head}{}", axis.replace("6000.0", "1.0")));
    assert!(json(&format!("sweep {few}")).get("warnings").is_none());
    let soft = "--set units.young=193 --set units.static_load=2e-8 --set chain.sites=3 --set initial.site=1";
    let words = "units.young = 193 Pa: softer than solids; if it is in GPa, write 193e9";
    said(&format!("study bands granular-crystal {soft} --set span.until=1.0"), words);
    let long = "--set drive=[] --set beads.tau=inf --set span.until=1.0";
    said(&format!("orbit mode granular-crystal {soft} {long} --to 1e-7"), words);
    let thick = "units.radius = 9.5 m: more than 1 m; if it is in mm, write 9.5e-3";
    let large = "--set units.radius=9.5 --set chain.sites=3 --set initial.site=1 --settle 3 --set span.until=1.0";
    said(&format!("orbit driven granular-crystal {large}"), thick);
    said(&format!("orbit continue granular-crystal {large} --to 2e-8 --max-points 2"), thick);
}

#[test]
fn a_run_that_fails_says_so_in_the_units_of_its_scene() {
    // Truth: the units by Hertz's formula; the same run in them.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("struck.toml").display().to_string();
    fs::write(&path, STRUCK).unwrap();
    let failed = |more: &str| {
        let line = format!("run {path} --integrator verlet --step 2e-4 --set span.until=2e-2 --json {more}");
        let output = hertzchain(line.trim());
        assert_eq!(output.status.code(), Some(1));
        let result: Value = serde_json::from_slice(&output.stdout).unwrap();
        let (failure, said) =
            (result["failure"].as_str().unwrap().to_owned(), String::from_utf8(output.stderr).unwrap());
        assert!(said.contains(&failure), "{said}");
        failure
    };
    let [si, plain] = ["", "--dimensionless"].map(failed);
    assert!(si.ends_with("; in SI units") && !plain.contains("SI"), "{si} {plain}");
    let after = |text: &str, words: &str| -> f64 {
        let rest = text.split(words).nth(1).unwrap_or_else(|| panic!("{words}: {text}"));
        rest.split([' ', ';', ',']).next().unwrap().parse().unwrap()
    };
    let energy = mass() * (RADIUS / time()).powi(2);
    for (words, by) in [("t = ", time()), ("steps of ", time()), ("energy went from ", energy)] {
        let [si, plain] = [&si, &plain].map(|text| after(text, words));
        assert!((si / (plain * by) - 1.0).abs() < 1e-5, "{words}: {si} {plain}");
    }
    assert!((after(&si, "energy went from ") / (0.125 * mass()) - 1.0).abs() < 1e-9, "{si}");
    let axis = "[[axis]]\nkey = \"span.until\"\nvalues = [2e-2]\n";
    let method = "set = [\"method = { integrator = \\\"verlet\\\", step = 2e-4 }\"]\n";
    fs::write(folder.path().join("plan.toml"), format!("scene = \"{path}\"\n{method}{axis}")).unwrap();
    let swept = hertzchain(&format!("sweep {} --json", folder.path().join("plan.toml").display()));
    // No point has a result.
    assert_eq!(swept.status.code(), Some(1));
    let swept: Value = serde_json::from_slice(&swept.stdout).unwrap();
    assert_eq!(swept["failed"][0]["failure"].as_str().unwrap(), si);
}

#[test]
fn captions_and_plans_name_parameters_in_si_units() {
    // Truth: A delta^(3/2) = F0, m/tau, and the mass of a sphere.
    let plan = stdout("run granular-crystal --plan");
    let overlap = (LOAD / hertz()).powf(2.0 / 3.0);
    let words = format!(" m to {overlap:.3e} m, drag from 0 kg/s to {:.3} kg/s", mass() / 0.011);
    assert!(plan.contains("static overlaps from ") && plan.contains(&words), "{plan}\n{words}");
    let heavy = stdout("run granular-crystal --plan --set chain.gravity=9.81 --set beads.mass={except=[[1,0.1]]}");
    let masses = format!("masses from {:.5} kg to 0.1 kg", mass());
    assert!(heavy.contains(&masses) && heavy.contains("gravity 9.81 m/s^2"), "{heavy}\n{masses}");
    let loss = "run granular-crystal --plan --set bonds.hunt_crossley=0.2 --set drive=[]";
    assert!(stdout(loss).contains(" 0.2 s/m"), "{}", stdout(loss));
}

#[test]
fn charts_of_stability_are_in_the_units_of_the_scene() {
    // Truth: the dimensionless chart times the units by Hertz's formula.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("struck.toml").display().to_string();
    fs::write(&path, STRUCK.replace("sites = 40", "sites = 4")).unwrap();
    let chart = |more: &str| {
        let charts = "--charts light,stiffness,time --quick --periods 1 --work 1e4";
        json(format!("study stability {path} {charts} --integrators verlet {more}").trim())
    };
    let [si, plain] = ["", "--dimensionless"].map(chart);
    assert!(si["si"] == true && plain.get("si").is_none());
    assert!((number(&si, "/amplitude") / (number(&plain, "/amplitude") * RADIUS) - 1.0).abs() < 1e-14);
    let [points, others] = [&si, &plain].map(|chart| chart["points"].as_array().unwrap());
    assert_eq!(points.len(), others.len());
    let units = [("step", time()), ("kappa", hertz() * RADIUS.sqrt()), ("usual/step", time())];
    for (name, by) in
        [&units[..], &[("cost", time().recip()), ("ladder/0/cost", time().recip()), ("rho", 1.0)]].concat()
    {
        let both = |one: &Value| one.pointer(&format!("/{name}")).and_then(Value::as_f64);
        let pairs: Vec<_> = points.iter().zip(others).filter_map(|(si, own)| both(si).zip(both(own))).collect();
        assert!(!pairs.is_empty() && pairs.iter().all(|(si, own)| (si - own * by).abs() <= 1e-13 * si.abs()), "{name}");
    }

    // Runs that fail at a point say so in the step of their row.
    let set = "--set chain.boundary=ring --set chain.rho=0.33 --set chain.kappa=1e9";
    let line = "--charts alpha --quick --work 1e4 --integrators discrete-gradient --json";
    let output = hertzchain(&format!("study stability {path} {set} {line}"));
    let chart: Value = serde_json::from_slice(&output.stdout).unwrap();
    let ladder = chart["points"][0]["ladder"].as_array().unwrap();
    let failed: Vec<_> =
        ladder.iter().filter_map(|row| Some((row["failure"].as_str()?, number(row, "/step")))).collect();
    let told = |said: &str| said.split("step ").last().unwrap().split(',').next().unwrap().parse::<f64>().unwrap();
    assert!(failed.len() > 3 && failed.iter().all(|(said, step)| (told(said) / step - 1.0).abs() < 1e-9), "{failed:?}");
}

#[test]
fn a_wall_that_is_moved_is_a_flat_body_at_the_end() {
    // Truth: Galileo. Spheres that meet a wall of speed v move as spheres of speed -v that meet a
    // wall at rest, of the same material, on either side.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml").display().to_string();
    let run = |sites: usize, boundary: &str, more: &str, initial: &str| {
        let units = "[units]\nsystem = \"SI\"\nradius = 9.525e-3\ndensity = 8027.0\nyoung = 193e9\npoisson = 0.3\n";
        let text = format!(
            "[chain]\nsites = {sites}\nalpha = 1.5\nboundary = \"{boundary}\"\n{units}wall_young = 7e10\n{more}\n\
             [initial]\nkind = \"state\"\n{initial}\n[span]\nuntil = 2e-4\n"
        );
        fs::write(&path, text).unwrap();
        json(&["run", &path, "--tol", "1e-12"])
    };
    let v = 0.3;
    let rest = run(3, "left-wall", "", &format!("u_dot = [-{v}, -{v}, -{v}]"));
    for (wall, sign, at) in [("left-wall", 1.0, [1, 2, 3]), ("right-wall", -1.0, [2, 1, 0])] {
        let drive = format!("[[drive]]\nsite = \"{wall}\"\nkind = \"moved\"\nvelocity = {}\n", sign * v);
        let moved = run(4, "free", &drive, "");
        for (k, at) in at.into_iter().enumerate() {
            let [own, other] =
                [sign * number(&moved, &format!("/u/{at}")) - v * 2e-4, number(&rest, &format!("/u/{k}"))];
            assert!((own - other).abs() < 1e-13, "{wall} {k}: {own} {other}");
        }
    }
}

#[test]
fn tau_is_the_drag_of_each_mass() {
    // Truth: the same chain with drag = mass/tau, bit by bit.
    let run =
        |damped: &str| json(&["run", "impact", "--set", "beads.mass=2", "--set", damped, "--until", "5"])["u"].clone();
    assert_eq!(run("beads.tau=8"), run("beads.drag=0.25"));
    assert_eq!(run("beads.tau=inf"), run("beads.drag=0"));
}

#[test]
fn studies_of_methods_have_the_times_of_the_scene() {
    // Truth: steps of equal length fill the span; periods of a chain of spheres without a period
    // are units of time.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("struck.toml");
    fs::write(&path, STRUCK).unwrap();
    let path = path.display();
    let compared = json(&format!("compare {path} --integrators verlet --max-time 0.1"));
    let row = |name: &str| number(&compared, &format!("/rows/0/{name}"));
    assert!((row("step") * row("steps") / 6e-4 - 1.0).abs() < 1e-12);
    let drift = json(&format!("study drift {path} --integrators verlet --periods 3 --samples 4"));
    assert!((number(&drift, "/rows/0/t/3") / (3.0 * time()) - 1.0).abs() < 1e-12);
    assert!((number(&drift, "/period") / time() - 1.0).abs() < 1e-12);
}
