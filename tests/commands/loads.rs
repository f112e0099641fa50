//! Walls, weights and pushes in scenes: drives from files, gravity in SI units, equilibria.

use super::program::{json, numbers, refused};
use std::{fs, path::Path};

/// A scene of three beads before a wall, with more lines.
fn scene(chain: &str, rest: &str) -> String {
    format!("[chain]\nsites = 3\nalpha = 1.5\n{chain}\n{rest}\n[span]\nuntil = 8.0\n")
}

const AT_REST: &str = "[initial]\nkind = \"state\"";

fn write(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn a_drive_from_a_file_is_its_signal_and_goes_with_the_scene() {
    // Truth: the sine that the file samples. A cubic spline errs by 5/384 h^4 times its fourth
    // derivative, 1e-7 for h = 0.1 and amplitude 0.1.
    let folder = tempfile::tempdir().unwrap();
    let lines: String = (0..=90).map(|k| 0.1 * f64::from(k)).map(|t| format!("{t}, {}\n", 0.1 * t.sin())).collect();
    write(folder.path(), "drive.csv", &format!("# recorded\ntime, value\n{lines}"));
    for kind in ["moved", "pushed"] {
        let drive = |of: &str| {
            let text = format!("[[drive]]\nsite = 0\nkind = \"{kind}\"\n{of}\n{AT_REST}");
            scene("boundary = \"right-wall\"", &text)
        };
        let from_file = write(folder.path(), "file.toml", &drive("file = \"drive.csv\""));
        let sine = write(folder.path(), "sine.toml", &drive("amplitude = 0.1\nomega = 1.0"));
        let out = folder.path().join(kind);
        let got = json(&["run", &from_file, "--out", out.to_str().unwrap()]);
        let want = json(&["run", &sine]);
        for key in ["u", "pu"] {
            for (got, want) in numbers(&got[key]).iter().zip(numbers(&want[key])) {
                assert!((got - want).abs() < 1e-6, "{kind} {key}: {got} for {want}");
            }
        }
        // The scene that was written has the numbers of the file.
        let again = json(&["run", out.join("scene.toml").to_str().unwrap()]);
        assert_eq!(again["u"], got["u"]);
    }
    let long = refused(&["run", folder.path().join("file.toml").to_str().unwrap(), "--until", "9.5"], 2);
    assert!(long.contains("from 0 to 9 is not valid: the times of a drive cover the run"), "{long}");
}

#[test]
fn a_bad_file_of_a_drive_is_refused_with_scene_drive_key_file_and_line() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!("[[drive]]\nsite = 0\nkind = \"pushed\"\nfile = \"drive.csv\"\n{AT_REST}");
    let path = write(folder.path(), "file.toml", &scene("boundary = \"free\"", &text));
    for (content, words) in [
        ("0, 1\n1, nan\n9, 0\n", "line 2"),
        ("0, 1\n1, 2\n1, 0\n", "line 3"),
        ("0, 1\n5, 2\n\n3, 0\n", "line 4"),
        ("0, 1\n", "at least two lines"),
        ("0, 1, 2\n1, 1, 2\n", "line 1"),
        ("t, F\n0, 1\nx, 2\n", "line 3: `x, 2`: a line is a time and a value"),
        (
            "time (s),force (N)\n0,0\n1,1\n",
            "line 1: `time (s),force (N)`: names of the columns are two words, without units",
        ),
        ("0, 1\n1, 1e999\n", "line 2"),
    ] {
        write(folder.path(), "drive.csv", content);
        let said = refused(&["run", &path], 2);
        let start = format!("error: scene {path}: [[drive]] 1, `file`: {}", folder.path().join("drive.csv").display());
        assert!(said.starts_with(&start) && said.contains(words), "{content:?}: {said}");
    }
    fs::remove_file(folder.path().join("drive.csv")).unwrap();
    let missing = refused(&["run", &path], 2);
    assert!(missing.contains("[[drive]] 1, `file`: ") && missing.contains("drive.csv: No such file"), "{missing}");
}

#[test]
fn steel_spheres_stand_on_a_slope() {
    // Truth: Hertz, in SI units: the force of contact k is (k + 1) m g sin(30 degrees); the wall is
    // of the material of the spheres.
    let folder = tempfile::tempdir().unwrap();
    let (radius, density, young, poisson) = (9.525e-3f64, 8027.0, 193e9, 0.3);
    let text = format!(
        "[chain]\nsites = 3\nalpha = 1.5\nboundary = \"right-wall\"\ngravity = 9.81\ntilt = 30\n[units]\nsystem = \"SI\"\n\
         radius = {radius}\ndensity = {density}\nyoung = {young}\npoisson = {poisson}\n\
         [initial]\nkind = \"equilibrium\"\n[span]\nuntil = 1e-3\n"
    );
    let path = write(folder.path(), "slope.toml", &text);
    let weight = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3) * density * 9.81 * 0.5;
    let modulus = young / (2.0 * (1.0 - poisson * poisson));
    let overlap = |k: usize| {
        let reduced = if k == 3 { radius } else { 0.5 * radius };
        (k as f64 * weight / (4.0 / 3.0 * modulus * reduced.sqrt())).powf(2.0 / 3.0)
    };
    for integrator in ["collocation", "dop853-regularised"] {
        let u = numbers(&json(&["run", &path, "--integrator", integrator])["u"]);
        let got = [u[0] - u[1], u[1] - u[2], u[2]];
        for k in 1..=3 {
            let (got, want) = (got[k - 1], overlap(k));
            assert!((got / want - 1.0).abs() < 1e-10, "{integrator} {k}: {got} for {want}");
        }
    }
}
