//! The program as people and machines use it: what it prints, writes and refuses. Names and formats
//! of all results are those of the golden net.

use super::program::{json, names, read_json, refused, stdout, table};
use hertzchain::output::Archive;
use serde_json::Value;
use std::fs;

#[test]
fn a_strain_ring_without_balance_has_no_energy() {
    let folder = tempfile::tempdir().unwrap();
    let initial = "[initial]\nkind = \"state\"\nu = [-0.1, 0.2, 0.3]\n[span]\nuntil = 2.0\n";
    let chain = "name = \"odd\"\n[chain]\nsites = 3\nalpha = 1.5\nkappa = 1.0\nrho = 1.0\nboundary = \"strain-ring\"\n";
    let path = folder.path().join("odd.toml");
    fs::write(&path, format!("{chain}{initial}")).unwrap();
    let run = json(&["run", path.to_str().unwrap()]);
    assert!(run["energy"].is_null() && run["energy_error"].is_null());
    assert!(run["x"][0].is_f64());
    let drift = refused(&["study", "drift", path.to_str().unwrap()], 2);
    assert!(drift.contains("a state with an energy"), "{drift}");
}

#[test]
fn crossings_are_written_and_a_condition_ends_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let line = format!(
        "run impact --until 30 --tol 1e-10 --stop u[5]>0.5 --crossings overlap[3]=0.1 --crossings u_dot[0]<0.2 --out {out}"
    );
    let value = json(&line);
    let (head, rows) = table(&folder.path().join("crossings.csv"));
    assert_eq!(head, "condition,t,rising");
    // An overlap rises and falls; the last row is the end of the run.
    assert_eq!(rows.iter().filter(|row| row[0] == 0.0).map(|row| row[2]).collect::<Vec<_>>(), [1.0, 0.0]);
    let last = rows.last().unwrap();
    assert!(last[0] == 2.0 && last[1] == value["t"].as_f64().unwrap() && last[2] == 1.0);
    assert!((value["u"][5].as_f64().unwrap() - 0.5).abs() < 1e-14 && value["ended_by"] == "u[5]>0.5");
    assert_eq!(value["crossings"][0]["count"], 2);
    // Truth: a run with samples.
    let before = json(&format!("run impact --until {:?} --tol 1e-10", last[1] - 1e-6));
    assert!((before["u"][5].as_f64().unwrap() - 0.5 + 1e-6 * value["pu"][5].as_f64().unwrap()).abs() < 1e-9);
    // What an earlier run has left is removed.
    json(&format!("run impact --until 3 --out {out}"));
    assert!(!folder.path().join("crossings.csv").exists());
    // In SI units: the driven bead moves by 10 nm.
    let si = json("run granular-crystal --until 7e-4 --tol 1e-8 --stop u[0]>5e-9");
    assert!((si["u"][0].as_f64().unwrap() - 5e-9).abs() < 1e-20 && si["t"].as_f64().unwrap() < 7e-4);
    let text = stdout("run impact --until 30 --tol 1e-10 --stop u[5]>0.5");
    assert!(text.contains("ended       by u[5]>0.5"), "{text}");
    let plan = stdout("run impact --plan --stop u[5]>0.5");
    assert!(plan.ends_with("crossings: looked for at 32 times in a period of the fastest motion\n"), "{plan}");
}

// Truth: the pulse of a long chain, whose end it has not reached; the wall's own force rises slower.
#[test]
fn the_speed_of_a_pulse_is_that_between_beads() {
    let speed = |sites: u32, until: u32| {
        let line =
            format!("run impact --set chain.sites={sites} --set chain.boundary=right-wall --until {until} --events");
        let text = stdout(&line);
        let pulse = text.lines().find(|line| line.starts_with("pulse")).unwrap();
        pulse.split_whitespace().nth(1).unwrap().parse::<f64>().unwrap()
    };
    let (end, long) = (speed(30, 50), speed(200, 30));
    assert!((end / long - 1.0).abs() < 1e-3, "{end} {long}");
}

#[test]
fn what_is_left_out_is_said() {
    // 64 modes.
    assert!(stdout("study modes precompressed").replace('\n', " ").contains("The table shows the first 20."));
}

#[test]
fn run_writes_files_that_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let run = json("run impact --until 5");
    let [wall, sampling] = ["wall_s", "sampling_s"].map(|key| run[key].as_f64().unwrap());
    assert!(0.0 < sampling && sampling < wall, "{sampling} of {wall}");
    stdout(&["run", "impact", "--until", "5", "--out", folder.path().to_str().unwrap()]);
    // CSV: what was printed, to the last digit.
    let (_, rows) = table(&folder.path().join("final.csv"));
    assert_eq!((rows[0][1], rows[0][2]), (run["u"][0].as_f64().unwrap(), run["pu"][0].as_f64().unwrap()));
    // NPZ: the last profile is the final state.
    let archive = Archive::read(&folder.path().join("profiles.npz")).unwrap();
    let u = archive.array("u", &[401, 100]).unwrap();
    assert_eq!(u[400 * 100], rows[0][1]);
    // The scene that was written is the scene that ran.
    let again = folder.path().join("scene.toml");
    assert_eq!(json(&["run", again.to_str().unwrap()])["u"], run["u"]);
}

#[test]
fn every_scene_is_shown_and_planned() {
    let scenes = json("scenes");
    for scene in scenes["scenes"].as_array().unwrap() {
        let name = scene["name"].as_str().unwrap();
        assert_eq!(json(&["scenes", "show", name])["name"], name);
        assert!(stdout(&["run", name, "--plan"]).contains("left out"));
    }
}

#[cfg(feature = "plot")]
#[test]
fn pictures_are_written_in_the_formats_that_are_asked_for_and_in_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let run = |formats: &str| {
        stdout(&format!("run impact --until 5 --out {out} --format {formats}"));
        let mut pictures: Vec<String> = names(folder.path()).into_iter().filter(|name| name.ends_with("g")).collect();
        let summary = read_json(&folder.path().join("summary.json"));
        let told: Vec<&str> = summary["files"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        assert!(pictures.iter().all(|name| told.contains(&name.as_str())), "{told:?}");
        assert_eq!(told.iter().filter(|name| name.ends_with("g")).count(), pictures.len());
        pictures.sort_unstable();
        pictures
    };
    let named = |end: &str| ["energy", "profile", "spacetime"].map(|stem| format!("{stem}.{end}"));
    assert_eq!(run("png"), named("png"));
    let mut both = [named("png"), named("svg")].concat();
    both.sort_unstable();
    assert_eq!(run("svg,png"), both);
    assert_eq!(run("svg"), named("svg"));
    let why = refused(&format!("dps dark --out {out} --format jpg"), 2);
    assert!(why.contains("jpg") && why.contains("svg"), "{why}");
}

// Truth: the solitary wave has run over 17 bonds; among 20000 it is a column of pixels.
#[cfg(feature = "plot")]
#[test]
fn a_short_wave_on_a_long_chain_fills_the_picture_over_space_and_time() {
    let folder = tempfile::tempdir().unwrap();
    let line = "run impact --set chain.sites=20000 --until 20 --samples 40 --integrator verlet --steps-per-period 40";
    stdout(&format!("{line} --format svg,png --out {}", folder.path().display()));
    let svg = fs::read_to_string(folder.path().join("spacetime.svg")).unwrap();
    assert!(svg.contains("The other bonds of 19999 move by less than 0.001 of the largest strain."), "{svg:.999}");
    let file = fs::File::open(folder.path().join("spacetime.png")).unwrap();
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    // The blue of contacts left of the colour bar.
    let blue = |(k, p): &(usize, &[u8])| k % 1200 < 1000 && p[2] > 120 && p[0] < 80;
    assert!(pixels.chunks(3).enumerate().filter(blue).count() > 5000);
}
