//! Orbits in SI units: `orbit driven`, `orbit continue` and `orbit mode` with `--si`.
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

use super::program::{hertzchain, json, refusals, refused, stdout, table};
use serde_json::Value;
use std::{f64::consts::PI, fs, path::Path};

const RADIUS: f64 = 9.525e-3;
const LOAD: f64 = 20.0;

fn number(value: &Value, path: &str) -> f64 {
    value.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}"))
}

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

/// A scene of steel spheres under the load.
fn spheres(sites: usize, boundary: &str, more: &str) -> String {
    format!(
        "name = \"spheres\"\n[chain]\nsites = {sites}\nalpha = 1.5\nboundary = \"{boundary}\"\n[initial]\n\
         kind = \"single-bead\"\nsite = 0\nvelocity = 0.0\n[span]\nuntil = 10.0\n[units]\nradius = {RADIUS}\n\
         density = 8027.0\nyoung = 193e9\npoisson = 0.3\nstatic_load = {LOAD}\n{more}"
    )
}

/// Four spheres, the first of which a drive moves; the wall is as stiff as a contact of two
/// spheres, so that the chain of the other three is that of equal springs between two walls.
///
/// With `c = (1 - nu^2)/E` two spheres have `(R/2)^{1/2}/(2 c)`, a sphere and a wall
/// `R^{1/2}/(c + c_w)`: so `c_w = (8^{1/2} - 1) c`.
fn driven_spheres(drag: f64, amplitude: f64, omega: f64) -> String {
    let wall = 193e9 / (8f64.sqrt() - 1.0);
    let drive = format!(
        "[[drive]]\nsite = 0\nkind = \"moved\"\namplitude = {amplitude}\nomega = {omega}\nphase = {}\n",
        PI / 2.0
    );
    let beads = format!("[beads]\ndrag = {{ value = {drag}, except = [[0, 0.0]] }}\n");
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
    let (drag, amplitude) = (2e-3, 1e-12);
    let lowest = rate() * (PI / 8.0).sin() / PI;
    assert!((lowest - 3081.0).abs() < 1.0, "{lowest} Hz");
    let from = 2.0 * PI * 0.98 * lowest;
    let loss = drag / time();
    fs::write(path("scene.toml"), driven_spheres(drag, amplitude, from)).unwrap();

    let orbit = json(&["orbit", "driven", &path("scene.toml"), "--si"]);
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
    let args = ["orbit", "continue", &path("scene.toml"), "--vary", "omega", "--to", &to, "--step", &step, "--si"];
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
    let args = ["orbit", "mode", &path("ring.toml"), "--linear-mode", "5", "--to", "1e-6", "--step", "2e-7", "--si"];
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
    // A value in SI units, and the number of the chain with the bits that the program reads.
    let metres = |si: f64| [si, si / RADIUS].map(|value| value.to_string());
    let rate = |si: f64| [si, si * time()].map(|value| value.to_string());
    let driven: &[&str] = &["continue", "granular-crystal", "--settle", "20"];
    let cases = [
        (&["driven", "granular-crystal", "--settle", "20"][..], None, 1.0),
        (driven, Some([metres(4e-8), metres(1e-8)]), RADIUS),
        (&[driven, &["--vary", "omega"]].concat(), Some([rate(3.2e4), rate(5e2)]), time().recip()),
        (
            &[driven, &["--vary", "damping"]].concat(),
            Some([[1.2, 1.2], [0.1, 0.1]].map(|two| two.map(|x: f64| x.to_string()))),
            1.0,
        ),
        (&["mode", &ring], Some([metres(1e-6), metres(2e-7)]), 1.0),
    ];
    for (command, way, parameter) in cases {
        let [si, plain] = [0, 1].map(|which| {
            let way: Vec<&str> = match &way {
                Some([to, step]) => vec!["--to", &to[which], "--step", &step[which]],
                None => Vec::new(),
            };
            let si: &[&str] = if which == 0 { &["--si"] } else { &[] };
            json(&[&["orbit"], command, &way, si].concat())
        });
        assert!(plain.get("units").is_none() && plain.get("si").is_none() && si["si"] == true, "{command:?}");
        assert!((number(&si, "/units/time_s") / time() - 1.0).abs() < 1e-14);
        assert_eq!(si["scene_file"], plain["scene_file"]);
        let count = compare("", &si, &plain, parameter);
        assert!(count > 60, "{command:?}: {count} numbers");
    }
    // The force of a drive that pushes is in newtons.
    let pushed = folder.path().join("pushed.toml").display().to_string();
    let drive = "[beads]\ndrag = 0.01\n[[drive]]\nsite = 0\nkind = \"pushed\"\namplitude = 0.03\nomega = 1e4\n";
    fs::write(&pushed, spheres(3, "fixed", drive)).unwrap();
    let branch = json(&["orbit", "continue", &pushed, "--to", "0.05", "--step", "0.01", "--si"]);
    let points = branch["points"].as_array().unwrap();
    assert!((number(&points[0], "/amplitude") / 0.03 - 1.0).abs() < 1e-14);
    assert!((number(&points[points.len() - 1], "/amplitude") / 0.05 - 1.0).abs() < 1e-14);
    let text = stdout(&["orbit", "continue", &pushed, "--to", "0.05", "--step", "0.01", "--si"]);
    assert!(text.starts_with("amplitude (N)  response (m)"), "{text}");
}

#[test]
fn a_branch_begun_in_si_units_goes_on_without_them_and_the_other_way_round() {
    // Truth: the bytes of the other order of units.
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let [first, second] = [2e-8, 3e-8].map(|metres| [format!("{metres}"), format!("{}", metres / RADIUS)]);
    let begin = ["orbit", "continue", "granular-crystal", "--settle", "20", "--out"];
    stdout(&[&begin[..], &[&path("a"), "--to", &first[0], "--si"]].concat());
    stdout(&[&begin[..], &[&path("b"), "--to", &first[1]]].concat());
    let kept = |name: &str| fs::read(folder.path().join(name).join("driven-branch.npz")).unwrap();
    assert!(kept("a") == kept("b"));
    stdout(&["orbit", "continue", "--resume", &path("a"), "--to", &second[1]]);
    stdout(&["orbit", "continue", "--resume", &path("b"), "--to", &second[0], "--si"]);
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
    let text = stdout(&["orbit", "continue", "--resume", &path("a"), "--si"]);
    assert!(text.contains("amplitude (m)") && kept("a") == before, "{text}");
}

#[test]
fn a_branch_that_crosses_is_in_si_units_too() {
    // Truth: the dimensionless branch times the units by Hertz's formula; A R^{3/2} is that of
    // force.
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let drive = "[beads]\ndrag = 0.01\n[[drive]]\nsite = 0\nkind = \"pushed\"\namplitude = 50.0\nomega = 3e4\n";
    fs::write(path("pushed.toml"), spheres(2, "fixed", drive)).unwrap();
    let force = hertz() * RADIUS.powf(1.5);
    let continued = |name: &str, [to, step]: [f64; 2], si: &[&str]| {
        let way = [to.to_string(), step.to_string()];
        let args = ["--to", &way[0], "--step", &way[1], "--switch", "1", "--out", &path(name)];
        let text = stdout(&[&["orbit", "continue", &path("pushed.toml")], &args[..], si].concat());
        (text, ["driven-branch.csv", "switched-branch.csv"].map(|file| table(&folder.path().join(name).join(file)).1))
    };
    let (text, si) = continued("si", [60.0, 2.0], &["--si"]);
    let (_, plain) = continued("plain", [60.0, 2.0].map(|newtons| newtons / force), &[]);
    assert!(text.matches("amplitude (N)  response (m)").count() == 2, "{text}");
    // The two ways differ by a rounding of `--to`.
    for (si, plain) in si.iter().flatten().zip(plain.iter().flatten()) {
        for (k, by) in [(0, force), (1, RADIUS)] {
            assert!((si[k] / (plain[k] * by) - 1.0).abs() < 1e-9, "{si:?} {plain:?}");
        }
        assert_eq!(si[3], plain[3]);
    }
    assert!(si.iter().zip(&plain).all(|(si, plain)| si.len() == plain.len() && si.len() > 3));
}

#[test]
fn the_table_of_a_driven_orbit_is_that_of_a_period_in_si_units() {
    // Truth: the first sphere moves by 10 nm sin(3e4 t), and the table ends after a period.
    let folder = tempfile::tempdir().unwrap();
    stdout(&format!("orbit driven granular-crystal --settle 20 --si --out {}", folder.path().display()));
    let (_, rows) = table(&folder.path().join("driven-orbit.csv"));
    assert_eq!(rows.len(), 65);
    assert!((rows[64][0] * 3e4 / (2.0 * PI) - 1.0).abs() < 1e-14);
    for row in &rows {
        assert!((row[1] - 1e-8 * (3e4 * row[0]).sin()).abs() < 1e-20, "{row:?}");
    }
}

#[test]
fn si_units_of_orbits_need_spheres_and_refusals_name_what_was_given() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let rule = "error: --si is not valid: the scene has no table [units]\n";
    let out = path("out");
    for line in
        ["orbit driven end-driven", "orbit continue end-driven --to 1", "orbit mode defect --to 1", "run defect"]
    {
        assert_eq!(refused(&format!("{line} --si --out {out}"), 2), rule, "{line}");
    }
    assert!(!Path::new(&out).exists());
    let two = hertzchain(&format!("orbit continue end-driven --settle 5 --to 1 --max-points 2 --out {out}"));
    assert_eq!(two.status.code(), Some(1));
    assert_eq!(refused(&["orbit", "continue", "--resume", &out, "--si"], 2), rule);

    let ring = path("ring.toml");
    fs::write(&ring, spheres(6, "ring", "")).unwrap();
    let begun = path("begun");
    stdout(&["orbit", "continue", "granular-crystal", "--settle", "20", "--to", "2e-8", "--si", "--out", &begun]);
    refusals(
        2,
        &[
            (
                &["orbit", "continue", "--si", "--to", "1e-8"][..],
                "to = 0.00000001 is not valid: a finite number, not where",
            ),
            (&["orbit", "continue", "--si", "--to", "0"], "to = 0 is not valid"),
            (&["orbit", "continue", "--si", "--to", "-3e4", "--vary", "omega"], "to = -30000 is not valid"),
            (
                &["orbit", "continue", "--si", "--to", "2e-8", "--step=-1e-9"],
                "step = -1e-9 is not valid: finite and positive",
            ),
            (
                &["orbit", "continue", "--si", "--resume", &begun, "--to", "1.5e-8"],
                "to = 0.000000015 is not valid: a bran",
            ),
            (&["orbit", "mode", &ring, "--si", "--to=-1e-6"], "to = -0.000001 is not valid"),
            (
                &["orbit", "mode", &ring, "--si", "--to", "1e-6", "--step=-1e-7"],
                "step = -1e-7 is not valid: finite and positive",
            ),
        ],
    );
}
