//! What `[record]` names: forces, sensors and motions in time, their maxima, and their files.

use super::program::{json, number, stdout, table};
use hertzchain::waves::LinePulse;
use std::{
    f64::consts::PI,
    fs,
    path::{Path, PathBuf},
};

/// The scene in a file, and its path.
fn scene(folder: &Path, name: &str, text: &str) -> String {
    fs::write(folder.join(name), text).unwrap();
    folder.join(name).display().to_string()
}

/// The columns of a CSV file by name.
fn columns(folder: &Path, name: &str) -> impl Fn(&str) -> Vec<f64> + use<> {
    let (head, rows) = table(&folder.join(name));
    move |name| {
        let column = head.split(',').position(|one| one == name).unwrap_or_else(|| panic!("{name} in {head}"));
        rows.iter().map(|row| row[column]).collect()
    }
}

/// A bead between two walls whose contacts are springs with the constant 1, struck to the right.
fn bouncing(folder: &Path, more: &str) -> String {
    let text = format!(
        "[chain]\nsites = 1\nalpha = 1.0\nboundary = \"fixed\"\n[initial]\nkind = \"single-bead\"\nsite = 0\nvelocity = 0.5\n\
         [span]\nuntil = 20.0\n[record]\nsamples = 4000\n{more}"
    );
    scene(folder, "bouncing.toml", &text)
}

#[test]
fn maxima_widths_and_peak_velocities_of_a_bead_between_springs_are_the_closed_form() {
    // Truth: u = v sin t. The force on the right wall is v sin t where this is positive: maxima v
    // at pi/2 + 2 pi k, above v/2 from pi/6 to 5 pi/6. The sensor is half of |v sin t|.
    let folder = tempfile::tempdir().unwrap();
    let file =
        bouncing(folder.path(), "bonds = [0, 1]\nsites = [0]\nquantities = [\"force\", \"sensor\", \"u_dot\"]\n");
    let out = folder.path().join("out");
    let run = json(&["run", &file, "--out", out.to_str().unwrap()]);
    let number = |place: &str| number(&run, place);
    let near = |got: f64, want: f64, within: f64| assert!((got - want).abs() < within, "{got} {want}");
    assert_eq!(run["recorded"]["force"]["places"], serde_json::json!([0, 1]));
    near(number("/recorded/force/largest/1"), 0.5, 1e-9);
    near(number("/recorded/force/width/1"), 2.0 * PI / 3.0, 1e-5);
    near(number("/recorded/u_dot/largest/0").abs(), 0.5, 1e-9);
    let rows = fs::read_to_string(out.join("peaks.csv")).unwrap();
    let of = |name: &str| -> Vec<Vec<f64>> {
        let cells =
            rows.lines().map(|line| line.split(',').collect::<Vec<_>>()).filter(|cells| cells[..2].join(" ") == name);
        cells.map(|cells| cells[2..].iter().map(|cell| cell.parse().unwrap()).collect()).collect()
    };
    for (name, first, every, value) in
        [("force 1", 0.5 * PI, 2.0 * PI, 0.5), ("force 0", 1.5 * PI, 2.0 * PI, 0.5), ("sensor 0", 0.5 * PI, PI, 0.25)]
    {
        let found = of(name);
        assert_eq!(found.len() as f64, ((20.0 - first) / every).floor() + 1.0, "{name}");
        for (k, row) in found.iter().enumerate() {
            near(row[0], first + every * k as f64, 1e-6);
            near(row[1], value, 1e-9);
            near(row[2], 2.0 * PI / 3.0, 1e-5);
        }
    }
    // The same numbers in a sweep.
    let axis = "[[axis]]\nkey = \"initial.velocity\"\nvalues = [0.5, 0.25]\n";
    let keep = "keep = [\"recorded.force.largest[1]\", \"recorded.u_dot.largest[0]\"]";
    let plan = scene(folder.path(), "plan.toml", &format!("scene = \"{file}\"\n{keep}\n{axis}"));
    let sweep = json(&format!("sweep {plan}"));
    let kept = |k: usize| sweep["columns"]["recorded.force.largest[1]"][k].as_f64().unwrap();
    assert_eq!(kept(0), number("/recorded/force/largest/1"));
    near(kept(1), 0.25, 1e-9);
}

#[test]
fn largest_values_are_those_between_samples_and_steps() {
    // Truth: the energy of a bead between two contacts with the static overlap 1 that is let go
    // from u = a. Its speed is largest in the middle, v^2/2 = V(a) - V(0) with
    // V(u) = 2/5 ((1 + u)^(5/2) + (1 - u)^(5/2)). Its force on a wall is largest at u = -a and a,
    // (1 + a)^(3/2). With two samples, neither is at one.
    let folder = tempfile::tempdir().unwrap();
    let text = "[chain]\nsites = 1\nalpha = 1.5\nboundary = \"fixed\"\nprecompression = 1.0\n[initial]\n\
                kind = \"single-bead\"\nsite = 0\ndisplacement = 0.6\nvelocity = 0.0\n[span]\nuntil = 7.0\n[record]\n\
                samples = 2\nquantities = [\"u_dot\", \"force\", \"u\"]\n";
    let file = scene(folder.path(), "pressed.toml", text);
    let stored = |u: f64| 0.4 * ((1.0 + u).powf(2.5) + (1.0 - u).powf(2.5));
    let (speed, force) = ((2.0 * (stored(0.6) - stored(0.0))).sqrt(), 1.6_f64.powf(1.5));
    let found = |args: &str, name: &str, k: usize| {
        let run = json(&format!("run {file} {args}"));
        run["recorded"][name]["largest"][k].as_f64().unwrap().abs()
    };
    let fine = [
        ("--integrator collocation --tol 1e-13", 1e-12),
        ("--integrator dop853 --tol 1e-13", 1e-11),
        ("--integrator dop853-regularised --tol 1e-13", 1e-11),
        ("--integrator srkn14-6 --steps-per-period 128", 1e-11),
        ("--integrator corrected --steps-per-period 512", 1e-9),
        ("--integrator verlet --steps-per-period 512", 1e-4),
    ];
    for (args, within) in fine {
        let [v, left, right] = [("u_dot", 0), ("force", 0), ("force", 1)].map(|(name, k)| found(args, name, k));
        assert!((v / speed - 1.0).abs() < within, "{args}: {v} {speed}");
        assert!((left / force - 1.0).abs() < within && (right / force - 1.0).abs() < within, "{args}: {left} {right}");
        assert!((found(args, "u", 0) - 0.6).abs() < within.max(1e-15), "{args}");
    }
    // In legs.
    let out = folder.path().join("legs");
    let legs = format!("--integrator collocation --tol 1e-13 --checkpoint 0.8 --out {}", out.display());
    assert!((found(&legs, "u_dot", 0) / speed - 1.0).abs() < 1e-12);
}

#[test]
fn forces_of_contacts_that_dissipate_are_the_same_by_log_pulse_and_sweep() {
    // Truth: plain DOP853 at 1e-13, which knows no contacts, and the search of all its steps; of the
    // first, 0.10966 at bond 9 by quadruple precision. By logs of tiny steps it was 2.33.
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    for law in [["bonds.dashpot=1.0", "bonds.overlap=-0.1"], ["bonds.viscoelastic=0.05", "bonds.overlap=0.0"]] {
        let sets = ["chain.sites=12", law[0], law[1], "span.until=40.0"];
        let line: Vec<&str> = ["run", "impact"].into_iter().chain(sets.iter().flat_map(|set| ["--set", set])).collect();
        let searched =
            "--integrator dop853 --tol 1e-13 --set record.bonds=[6,9,11] --set record.quantities=[\"force\"]";
        let searched: Vec<&str> = line.iter().copied().chain(searched.split(' ')).chain(["--json"]).collect();
        let run = json(&searched[..]);
        let of = |name: &str, k: usize| run["recorded"]["force"][name][k].as_f64().unwrap();
        let speed = 5.0 / (of("t_largest", 2) - of("t_largest", 0));
        let force = [0, 1, 2].map(|k| of("largest", k));
        assert!(law[0] != "bonds.dashpot=1.0" || (force[1] - 0.10966).abs() < 1e-5, "{force:?}");

        let text = stdout(&[&line[..], &["--events", "--out", out.to_str().unwrap()]].concat()[..]);
        let pulse = text.lines().find(|line| line.starts_with("pulse")).unwrap();
        let words: Vec<&str> = pulse.split_whitespace().collect();
        let said = [1, 15, 19].map(|k| words[k].parse::<f64>().unwrap());
        let keep = "keep = [\"bonds.peak_force[9]\", \"speed[6..11]\"]\n[[axis]]\nkey = \"initial.velocity\"\nvalues = [1.0]\n";
        let plan = scene(folder.path(), "plan.toml", &format!("scene = \"impact\"\nset = {sets:?}\n{keep}"));
        let sweep = json(&format!("sweep {plan}"));
        let kept = |name: &str| sweep["columns"][name][0].as_f64().unwrap();
        let rows = columns(&out, "bonds.csv")("peak_force");
        println!("{pulse} {force:?} {speed}");
        for (got, want) in [
            (said[0], speed),
            (said[1], force[0]),
            (said[2], force[2]),
            (kept("speed[6..11]"), speed),
            (kept("bonds.peak_force[9]"), force[1]),
            (rows[9], force[1]),
        ] {
            // The line has seven digits.
            assert!((got / want - 1.0).abs() < 3e-7, "{law:?}: {got} {want}");
        }
    }
}

#[test]
fn a_pulse_has_the_length_of_the_exact_solitary_wave() {
    // Truth: the pulse of the infinite line, by its series of cosines. Its force is half of the
    // largest where the overlap is (1/2)^(2/3) of the largest.
    let pulse = LinePulse::new(1.5);
    let (mut low, mut high) = (0.0, 2.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let above = pulse.at(middle)[0] > pulse.at(0.0)[0] * 0.5_f64.powf(2.0 / 3.0);
        *(if above { &mut low } else { &mut high }) = middle;
    }
    let run = json("run impact --until 60 --samples 6000 --set record.bonds=[38,40,42]");
    let length = run["recorded"]["force"]["length"][1].as_f64().unwrap();
    assert!((length / (2.0 * low) - 1.0).abs() < 2e-5, "{length} {}", 2.0 * low);
}

#[test]
fn forces_dissipation_included_are_those_of_newtons_law_in_si_units() {
    // Truth: m u_n' is the integral of f_n - f_(n+1) from the start, by the trapezoidal rule, and
    // the impulse of the wall at the right is that of the log of contacts.
    let folder = tempfile::tempdir().unwrap();
    let (radius, density, dt) = (5e-3_f64, 8000.0, 1e-4 / 20_000.0);
    let mass = 4.0 / 3.0 * PI * radius.powi(3) * density;
    let text = format!(
        "[chain]\nsites = 4\nalpha = 1.5\nboundary = \"fixed\"\n[bonds]\nviscoelastic = 2e-6\n[initial]\nkind = \"single-bead\"\n\
         site = 0\nvelocity = 0.3\n[span]\nuntil = 1e-4\n[units]\nsystem = \"SI\"\nradius = {radius}\ndensity = {density}\n\
         young = 200e9\npoisson = 0.3\n[record]\nsamples = 20000\nsites = {{ from = 1, to = 3 }}\n\
         bonds = {{ from = 0, to = 4 }}\nquantities = [\"force\", \"sensor\", \"u_dot\", \"u\", \"momentum\"]\n"
    );
    let file = scene(folder.path(), "steel.toml", &text);
    let out = folder.path().join("out");
    json(&["run", &file, "--tol", "1e-11", "--out", out.to_str().unwrap()]);
    let of = columns(&out, "signals.csv");
    let largest = of("force_2").into_iter().fold(0.0, f64::max);
    assert!(largest > 10.0);
    for n in 1..4 {
        let [left, right] = [n, n + 1].map(|bond| of(&format!("force_{bond}")));
        let [speed, sensor] = ["u_dot", "sensor"].map(|name| of(&format!("{name}_{n}")));
        let mut impulse = 0.0;
        for k in 1..left.len() {
            impulse += 0.5 * dt * (left[k] + left[k - 1] - right[k] - right[k - 1]);
            assert!((impulse - mass * speed[k]).abs() < 1e-5 * mass * 0.3, "{n} {k}: {impulse} {}", mass * speed[k]);
            assert!((sensor[k] - 0.5 * (left[k] + right[k])).abs() < 1e-13 * largest);
        }
        let momentum = of(&format!("momentum_{n}"));
        assert!(momentum.iter().zip(&speed).all(|(p, v)| (p - mass * v).abs() <= 1e-15 * p.abs()));
    }
    let run = json(&["run", &file, "--tol", "1e-11", "--events"]);
    let impulse: f64 = of("force_4").windows(2).map(|pair| 0.5 * dt * (pair[0] + pair[1])).sum();
    let logged = run["bonds"]["impulse"][4].as_f64().unwrap();
    assert!((impulse / logged - 1.0).abs() < 1e-5, "{impulse} {logged}");
}

/// The numbers of an array of an archive.
fn array(folder: &Path, name: &str) -> Vec<f64> {
    let mut archive = zip::ZipArchive::new(fs::File::open(folder.join("signals.npz")).unwrap()).unwrap();
    let mut bytes = Vec::new();
    std::io::Read::read_to_end(&mut archive.by_name(&format!("{name}.npy")).unwrap(), &mut bytes).unwrap();
    let head = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert!(String::from_utf8_lossy(&bytes[..head]).contains("<f8"), "{name}");
    bytes[head..].chunks_exact(8).map(|one| f64::from_le_bytes(one.try_into().unwrap())).collect()
}

#[test]
fn the_archive_has_what_is_named_also_of_runs_in_legs() {
    let folder = tempfile::tempdir().unwrap();
    let named = "bonds = [1]\nquantities = [\"overlap\", \"force\"]\n";
    let out = |name: &str| -> (PathBuf, String) {
        let path = folder.path().join(name);
        (path.clone(), path.display().to_string())
    };
    let (double, legs, all) = (out("double"), out("legs"), out("all"));
    let file = bouncing(folder.path(), named);
    stdout(&format!("run {file} --out {}", double.1));
    stdout(&format!("run {file} --checkpoint 7 --until 20 --out {}", legs.1));
    let [t, force] = ["t", "force"].map(|name| array(&double.0, name));
    assert_eq!((t.len(), force.len(), t[4000]), (4001, 4001, 20.0));
    assert_eq!(array(&double.0, "bonds"), [1.0]);
    let apart = |other: &[f64]| force.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart(&array(&legs.0, "force")) < 1e-8);
    // Truth: the overlap with the right wall is the displacement.
    let plain = bouncing(folder.path(), "");
    stdout(&format!("run {plain} --out {}", all.1));
    let strains = columns(&all.0, "profiles.csv")("x1");
    assert!(array(&double.0, "overlap").iter().zip(&strains).all(|(overlap, x)| *overlap == -x));
    assert!(!all.0.join("signals.npz").exists() && !double.0.join("profiles.npz").exists());
    // A folder that has run without them has no old file.
    stdout(&format!("run {plain} --out {}", double.1));
    assert!(!double.0.join("signals.npz").exists() && !double.0.join("peaks.csv").exists());
}

#[test]
fn modes_and_responses_are_in_si_units() {
    // Truth: the same numbers without units, times the units of the scene.
    let both = |line: &str| [json(line), json(&format!("{line} --dimensionless"))];
    let near = |got: f64, want: f64| assert!((got / want - 1.0).abs() < 1e-9, "{got} {want}");
    let [si, own] = both("study modes granular-crystal");
    let unit = |name: &str| number(&si, &format!("/units/{name}"));
    near(number(&si, "/linear/0/omega"), number(&own, "/linear/0/omega") / unit("time_s"));
    let [si, own] = both("study response granular-crystal --kind pushed --site 2 --at 3 --points 3");
    near(number(&si, "/rows/1/omega"), number(&own, "/rows/1/omega") / unit("time_s"));
    near(number(&si, "/rows/1/gain_3"), number(&own, "/rows/1/gain_3") * unit("length_m") / unit("force_n"));
    near(number(&si, "/rows/1/phase_3"), number(&own, "/rows/1/phase_3"));
}
