//! Every folder of results says what made them: program and version, scene or parameters,
//! integrator and settings, seed.

use super::program::{command, printed, read_json};
use hertzchain::output::Archive;
use serde_json::Value;
use std::{
    fs,
    path::{Path, PathBuf},
};

const VERSION: &str = env!("CARGO_PKG_VERSION");

fn hertzchain(args: &[&str], out: &Path) {
    printed(command(args).arg("--out").arg(out).output().unwrap());
}

fn of_kind(folder: &Path, kind: &str) -> Vec<PathBuf> {
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    paths.filter(|path| path.extension().is_some_and(|extension| extension == kind)).collect()
}

fn contains(bytes: &[u8], text: &str) -> bool {
    bytes.windows(text.len()).any(|window| window == text.as_bytes())
}

/// The one JSON of a folder, after looks at all that lies beside it.
fn checked(folder: &Path) -> Value {
    let [path] = &of_kind(folder, "json")[..] else { panic!("a JSON in {}", folder.display()) };
    let json = read_json(path);
    assert_eq!(json["version"], VERSION, "{}", path.display());
    // Arrays of a run lie beside its summary; a branch, which is gone on with, says it itself.
    for path in of_kind(folder, "npz") {
        let archive = Archive::read(&path).unwrap();
        let Ok(settings) = archive.text("settings.json") else {
            assert!(path.ends_with("profiles.npz") || path.ends_with("contacts.npz"), "{}", path.display());
            assert!(json["setting"].is_string() && json["integrator"].is_string(), "{}", path.display());
            continue;
        };
        let settings: Value = serde_json::from_str(settings).unwrap();
        assert_eq!(settings["program"], format!("hertzchain {VERSION}"), "{}: {settings}", path.display());
    }
    for path in of_kind(folder, "png") {
        let bytes = fs::read(&path).unwrap();
        let program = format!("hertzchain {VERSION}");
        assert!(contains(&bytes, &format!("tEXtSoftware\0{program}")), "{}", path.display());
        assert!(
            contains(&bytes, "iTXtDescription\0") && contains(&bytes, &format!("{program}.")),
            "{}",
            path.display()
        );
    }
    json
}

#[test]
fn results_of_scenes_hold_the_whole_scene_the_integrator_its_setting_and_the_seed() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("own.toml").display().to_string();
    let text = hertzchain::scene::Scene::source("tw-q15").unwrap();
    fs::write(&scene, text.replace("detuning", "zeta = 0.01\ndetuning").replace("tw-q15", "own")).unwrap();
    let wave = ["--until", "3"];
    for (name, args) in [
        ("run", &["run", &scene, "--events", "--tol", "1e-8"][..]),
        ("wave", &["wave", &scene, "--tol", "1e-8"]),
        ("bright", &["breather", "bright", "--tol", "1e-8"]),
    ] {
        let out = folder.path().join(name);
        hertzchain(&[args, &wave].concat(), &out);
        let json = checked(&out);
        let file = &json["scene_file"];
        assert!(
            file["name"] == json["scene"] && file["span"]["until"] == 3.0 && file["chain"]["alpha"] == 1.5,
            "{name}"
        );
        let setting = json["setting"].as_str().unwrap();
        assert!(setting.contains("1e-8"), "{name}: {setting}");
        let integrator = json["integrator"].as_str().unwrap_or(setting);
        assert!(integrator.contains("collocation"), "{name}: {integrator}");
        // A seed that is left out is one all the same.
        assert!(file["name"] != "own" || file["initial"]["seed"] == 1, "{name}: {file}");
    }
    let out = folder.path().join("drift");
    hertzchain(&["study", "drift", "cradle", "--periods", "5", "--samples", "3"], &out);
    let json = checked(&out);
    assert_eq!((&json["scene_file"]["chain"]["rho"], &json["scene_file"]["name"]), (&"inf".into(), &"cradle".into()));
}

// Their keys are those of the golden net.
#[test]
fn results_without_a_scene_hold_their_program() {
    let folder = tempfile::tempdir().unwrap();
    for (name, line) in [
        ("dark", "breather dark --omega-b 2.03 --center bond --sites 5"),
        ("evolve", "breather evolve tests/golden/orbit.npz --until 10"),
        ("continue", "breather continue --from 2.03 --to 2.04 --step 5e-3 --center bond --sites 5"),
        ("profile", "dps dark --sites 5"),
        ("stability", "wave modulation"),
    ] {
        let out = folder.path().join(name);
        hertzchain(&line.split(' ').collect::<Vec<_>>(), &out);
        checked(&out);
    }
}
