//! Numbers of published papers, by scenes, plans and commands: the rows of docs/published.md.

use super::program::json;
use serde_json::Value;
use std::fs;

fn number(value: &Value, path: &str) -> f64 {
    value.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}"))
}

/// What a sweep keeps of a scene, a column for each name, over an axis.
fn swept<const K: usize>(scene: &str, keep: [&str; K], key: &str, values: &str) -> [Vec<f64>; K] {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.toml");
    let plan = format!("scene = \"{scene}\"\nkeep = {keep:?}\n[[axis]]\nkey = \"{key}\"\nvalues = {values}\n");
    fs::write(&path, plan).unwrap();
    let table = json(&["sweep", &path.display().to_string()]);
    keep.map(|name| {
        let column = table["columns"][name].as_array().unwrap_or_else(|| panic!("{name}"));
        column.iter().map(|value| value.as_f64().unwrap()).collect()
    })
}

#[test]
fn a_solitary_wave_in_steel_has_nesterenkos_speed() {
    // Truth: V = c (2 E/(a rho^(3/2) (1 - nu^2)))^(1/3) F^(1/6) of spheres of diameter a, with c =
    // 0.905515776 2^(7/6) 3^(-1/3) (4 pi/3)^(-1/2) of the exact wave. Published, in the long-wave
    // limit: c = 0.6802.
    let keep = ["bonds.peak_force[40]", "speed[40..50]"];
    let [force, speed] = swept("daraio-2006", keep, "initial.velocity", "[0.01, 0.1, 1.0, 10.0]");
    let (e, nu, a, rho) = (193e9f64, 0.3f64, 4.76e-3, 8000f64);
    let k = (2.0 * e / (a * rho.powf(1.5) * (1.0 - nu * nu))).cbrt();
    let volume: f64 = 4.0 / 3.0 * std::f64::consts::PI;
    let exact = 0.905_515_776 * 2f64.powf(7.0 / 6.0) / (3f64.cbrt() * volume.sqrt());
    assert!((exact - 0.68867).abs() < 5e-6 && (exact / 0.6802 - 1.0).abs() < 0.013);
    for (force, speed) in force.into_iter().zip(speed) {
        let c = speed / (k * force.powf(1.0 / 6.0));
        assert!((c / exact - 1.0).abs() < 1e-6, "{force}: {c}");
    }
}

#[test]
fn a_solitary_wave_under_load_has_the_speed_of_long_waves_nearly() {
    // Published: the speed of long waves with the largest force F under the load F0, f = F/F0.
    let keep = ["bonds.peak_force[30]", "speed[25..35]"];
    let [force, speed] = swept("daraio-2006-loaded", keep, "initial.velocity", "[0.06, 0.16, 0.5, 3.0]");
    let (e, nu, a, rho, load) = (193e9f64, 0.3f64, 4.76e-3, 8000f64, 2.38f64);
    let k = (2.0 * e / (a * rho.powf(1.5) * (1.0 - nu * nu))).cbrt();
    for (force, speed) in force.into_iter().zip(speed) {
        let f = force / load;
        let square = 4.0 / 15.0 * (3.0 + 2.0 * f.powf(5.0 / 3.0) - 5.0 * f.cbrt().powi(2));
        let long = 0.9314 * k * load.powf(1.0 / 6.0) / (f.cbrt().powi(2) - 1.0) * square.sqrt();
        println!("{force} N: {speed}, long waves {long}");
        assert!((speed / long - 1.0).abs() < 0.02, "{force}: {speed} {long}");
    }
}

#[test]
fn a_heavy_striker_makes_a_train_whose_forces_fall_nearly_exponentially() {
    // Truth: the classical method of Runge and Kutta for the same chain, maxima of the force by
    // parabolas. Published: a nearly exponential fall.
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("job").display().to_string();
    json(&["run", "job-2007", "--out", &out]);
    let rows = fs::read_to_string(folder.path().join("job/peaks.csv")).unwrap();
    let of = |row: &str| row.split(',').nth(3).unwrap().parse::<f64>().unwrap();
    let peaks: Vec<f64> = rows.lines().skip(1).map(of).collect();
    assert!(
        peaks.len() >= 6 && peaks[..6].windows(2).all(|two| (0.58..0.67).contains(&(two[1] / two[0]))),
        "{peaks:?}"
    );
    let n = 120;
    let force = |y: &[f64], bond: usize| (y[bond - 1] - y[bond]).max(0.0).powf(1.5);
    let rates = |y: &[f64]| -> Vec<f64> {
        let f: Vec<f64> = (0..=n).map(|b| if b == 0 || b == n { 0.0 } else { force(y, b) }).collect();
        let mass = |i: usize| if i == 0 { 8.0 } else { 1.0 };
        y[n..].iter().copied().chain((0..n).map(|i| (f[i] - f[i + 1]) / mass(i))).collect()
    };
    let mut y = vec![0.0; 2 * n];
    y[n] = 1.0;
    let (h, mut forces) = (0.02, Vec::new());
    for _ in 0..6500 {
        forces.push(force(&y, 80));
        let along = |k: &[f64], h: f64| y.iter().zip(k).map(|(y, k)| y + h * k).collect::<Vec<_>>();
        let k1 = rates(&y);
        let k2 = rates(&along(&k1, h / 2.0));
        let k3 = rates(&along(&k2, h / 2.0));
        let k4 = rates(&along(&k3, h));
        (0..2 * n).for_each(|i| y[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }
    let maxima = forces.windows(3).filter(|f| f[1] > f[0] && f[1] >= f[2] && f[1] > 0.1).map(|f| {
        let (slope, bend) = (0.5 * (f[2] - f[0]), f[2] - 2.0 * f[1] + f[0]);
        f[1] - 0.5 * slope * slope / bend
    });
    for (got, want) in peaks.iter().zip(maxima.take(5)) {
        assert!((got / want - 1.0).abs() < 1e-5, "{got} {want}");
    }
}

#[test]
fn a_weak_pulse_in_a_column_slows_and_speeds_as_published() {
    // Published, for large depths: velocities like depth^(-1/4), speeds like depth^(1/6).
    let run = json("run hong-1999");
    let of = |name: &str| -> Vec<f64> {
        run["recorded"]["u_dot"][name].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let (largest, t) = (of("largest"), of("t_largest"));
    let slope = |from: usize, to: usize, of: &dyn Fn(usize) -> f64| {
        let points: Vec<(f64, f64)> = (from..to).map(|k| (((k + 1) as f64).ln(), of(k).ln())).collect();
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
        let (x, y) = (mean(|p| p.0), mean(|p| p.1));
        points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>()
            / points.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
    };
    for (of, published, near) in [
        (&(|k: usize| largest[k].abs()) as &dyn Fn(usize) -> f64, -0.25, 0.014),
        (&|k: usize| 2.0 / (t[k + 1] - t[k - 1]), 1.0 / 6.0, 0.007),
    ] {
        let [early, late] = [(20, 100), (40, 160)].map(|(from, to)| slope(from, to, of) - published);
        println!("{early} {late}");
        assert!(late.abs() < near && late.abs() < early.abs(), "{published}: {early} {late}");
    }
}

#[test]
fn a_dimer_has_its_published_bands() {
    // Published: 4698, 8086 and 9352 Hz.
    let bands = json("study bands boechler-2010");
    let hertz = ["/bands/0/frequency_to", "/bands/1/frequency_from", "/bands/1/frequency_to"];
    for (path, published) in hertz.into_iter().zip([4698.0, 8086.0, 9352.0]) {
        assert!((number(&bands, path) / published - 1.0).abs() < 2e-3, "{path}");
    }
}

#[test]
fn a_tapered_chain_leaves_its_share_in_the_last_sphere() {
    // Truth: an independent program (scipy) has 0.274078549 of the energy; hard spheres, by the
    // published approximation, have 0.623. The share does not depend on the speed.
    for velocity in ["0.1", "3.0"] {
        let set = format!("initial.velocity={velocity}");
        let run = json(&["run", "doney-2006", "--set", &set, "--tol", "1e-12"]);
        let momentum: Vec<f64> = run["pu"].as_array().unwrap().iter().map(|p| p.as_f64().unwrap()).collect();
        let mass = 4.0 / 3.0 * std::f64::consts::PI * 5e-3f64.powi(3) * 7780.0;
        let (last, first) = (momentum[19].powi(2) / 0.9f64.powi(57), (mass * velocity.parse::<f64>().unwrap()).powi(2));
        assert!((last / first - 0.274_078_55).abs() < 2e-8, "{velocity}: {}", last / first);
    }
}

#[test]
fn a_pulse_decays_in_proportion_to_weak_dashpots() {
    // Published: the rate of decay is linear in gamma. Here: the logarithm of the loss of force in
    // ten beads, over gamma, which falls by 4 % from 0.005 to 0.02.
    let keep = ["bonds.peak_force[20]", "bonds.peak_force[30]"];
    let [before, after] = swept("rosas-2007", keep, "bonds.dashpot", "[0.005, 0.01, 0.02]");
    let loss = |k: usize| (before[k] / after[k]).ln();
    for (k, (gamma, noted)) in [(0.005, 0.0340), (0.01, 0.0671), (0.02, 0.1306)].into_iter().enumerate() {
        assert!((loss(k) - noted).abs() < 6e-5, "{gamma}: {}", loss(k));
    }
    let slopes = [loss(0) / 0.005, loss(1) / 0.01, loss(2) / 0.02];
    assert!((slopes[1] / slopes[0] - 1.0).abs() < 0.02 && (slopes[2] / slopes[1] - 1.0).abs() < 0.04, "{slopes:?}");
}
