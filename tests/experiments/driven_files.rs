//! Branches of driven orbits as files: read back to the bit, continued after any stop, and refused
//! if they are not as they were written.

use hertzchain::{
    Error,
    orbits::{Branch, DriveParameter, DrivenBranch, DrivenContinuation, DrivenSetting, DrivenShooting, End},
    output::{Archive, Array, npz_with},
    scene::Scene,
    study::{DrivenBranchStudy, load_branch},
};
use serde_json::{Value, json};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// A bead that rests on a wall and is shaken.
const SHAKEN: &str = "
    name = 'shaken'
    [chain]
    sites = 1
    alpha = 1.5
    kappa = 0.0
    rho = 0.0
    boundary = 'fixed'
    [beads]
    drag = 0.15
    [bonds]
    overlap = [1.0, 0.0]
    contact = [1.0, 0.0]
    [[drive]]
    site = 0
    kind = 'pushed'
    amplitude = 0.1
    omega = 1.8
    [[drive]]
    site = 0
    kind = 'pushed'
    amplitude = -1.0
    omega = 0.0
    phase = 1.5707963267948966
    [initial]
    kind = 'single-bead'
    site = 0
    velocity = 0.0
    [span]
    until = 10.0
";

fn scene(folder: &Path) -> Scene {
    let path = folder.join("shaken.toml");
    fs::write(&path, SHAKEN).unwrap();
    Scene::load_with(path.to_str().unwrap(), &[]).unwrap()
}

fn begun(scene: &Scene, most_points: usize) -> DrivenBranch {
    let (shooting, setting) = (DrivenShooting::default(), DrivenSetting::new(scene.chain(), 1).unwrap());
    let start = shooting.solve(&setting, &setting.rest()).unwrap();
    let parameter = DriveParameter::Amplitude;
    let continuation = DrivenContinuation { parameter, to: 1.95, step: 0.3, most_points, shooting };
    let mut trail = Branch::new(continuation, setting, start).unwrap();
    trail.extend(|_| {}).unwrap();
    trail
}

fn saved(folder: &Path, scene: &Scene, trail: &DrivenBranch) -> PathBuf {
    let mut branch = trail.clone();
    branch.points.push(branch.point(&branch.orbits[0]).unwrap());
    let study = DrivenBranchStudy { scene: scene.clone(), branch, switched: None, si: None };
    let (name, bytes) =
        study.report().unwrap().files().unwrap().into_iter().find(|(name, _)| name == "driven-branch.npz").unwrap();
    let path = folder.join(name);
    fs::write(&path, bytes).unwrap();
    path
}

/// All numbers of a branch.
fn bits(trail: &DrivenBranch) -> (Vec<u64>, Option<End>) {
    let orbits = trail.orbits.iter().flat_map(|orbit| {
        let parameters = [DriveParameter::Amplitude, DriveParameter::Omega, DriveParameter::Damping];
        let numbers = parameters.map(|parameter| orbit.setting.get(parameter));
        numbers.into_iter().chain(orbit.z.clone()).chain([orbit.residual, f64::from(orbit.setting.turns())])
    });
    (orbits.chain([trail.ds, trail.back]).map(f64::to_bits).collect(), trail.end)
}

#[test]
fn a_driven_branch_stopped_anywhere_and_gone_on_with_has_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path());
    let main = begun(&scene, 200);
    let mut doubled = main.clone().analysed().switched(0).unwrap();
    let crossing = doubled.clone();
    doubled.continuation.most_points = 12;
    doubled.extend(|_| {}).unwrap();
    for (whole, mut stopped) in [(main.clone(), begun(&scene, 2)), (doubled, crossing)] {
        let count = whole.orbits.len();
        assert!(count >= 5, "{count}");
        for points in stopped.orbits.len() + 1..=count {
            let path = saved(folder.path(), &scene, &stopped);
            let (again, read): (Scene, DrivenBranch) = load_branch(&path).unwrap();
            assert_eq!((again.file(), bits(&read)), (scene.file(), bits(&stopped)));
            stopped = read.onward(None, None, points).unwrap();
            stopped.extend(|_| {}).unwrap();
        }
        assert_eq!(bits(&stopped), bits(&whole));
    }
}

#[test]
fn a_driven_branch_goes_on_beyond_its_end_and_not_back() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path());
    let path = saved(folder.path(), &scene, &begun(&scene, 200));
    let (_, read): (Scene, DrivenBranch) = load_branch(&path).unwrap();
    assert_eq!(read.end, Some(End::Reached));
    let mut further = read.clone().onward(Some(2.0), None, 200).unwrap();
    assert_eq!(further.extend(|_| {}).unwrap(), End::Reached);
    assert_eq!(further.orbits.last().unwrap().setting.get(DriveParameter::Amplitude), 2.0);
    for to in [1.95, 1.9, 1.2, 0.5, f64::NAN] {
        let refused = read.clone().onward(Some(to), None, 200).unwrap_err().to_string();
        assert!(refused.starts_with("to = "), "{to}: {refused}");
    }
    assert_eq!(read.onward(None, None, 200).unwrap().end, Some(End::Reached), "there is nothing to follow");
}

/// Gives the drive another frequency.
fn slowed(settings: &mut Value, omega: f64) {
    let scene = &mut settings["setting"]["scene"];
    *scene = json!(scene.as_str().unwrap().replace("omega = 1.8", &format!("omega = {omega}")));
}

/// An alteration of the settings, or of the numbers `parameter`, `residual` and `z`.
type Case = (fn(&mut Value, &mut [Vec<f64>; 3]), &'static str, &'static str);

#[test]
fn what_cannot_be_a_driven_branch_is_refused_with_file_place_and_rule() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene(folder.path());
    let path = saved(folder.path(), &scene, &begun(&scene, 4));
    let file = Archive::read(&path).unwrap();
    let settings: Value = serde_json::from_str(file.text("settings.json").unwrap()).unwrap();
    let shapes = [("parameter", vec![4]), ("residual", vec![4]), ("z", vec![4, 2])];
    let arrays = shapes.clone().map(|(name, shape)| file.array(name, &shape).unwrap());
    let cases: &[Case] = &[
        (|s, _| s["version"] = json!(1), "settings.json", "read is hertzchain driven branch, version 2"),
        (|s, _| s["points"] = json!(0), "settings.json", "points = 0 is not valid: at least one"),
        (|s, _| s["points"] = json!(3), "parameter", "[3] doubles"),
        (|s, _| s["ds"] = json!(0.0), "settings.json", "ds = 0 is not valid: finite and positive"),
        (|s, _| s["continuation"]["step"] = json!(-1.0), "settings.json", "step = -1"),
        (|s, _| s["setting"]["turns"] = json!(65), "settings.json", "from 1 to 64"),
        (|s, _| s["birth"] = json!("period-doubling"), "settings.json", "even after a period doubling"),
        (|s, _| s["more"] = json!(1), "settings.json", "unknown field `more`"),
        (|s, _| drop(s.as_object_mut().unwrap().remove("end")), "settings.json", "missing field `end`"),
        (|s, _| s["setting"]["scene"] = json!("[chain]"), "settings.json", "missing field"),
        (|_, a| a[0][1] = 0.0, "parameter", "point 1: amplitude = 0"),
        (|_, a| a[0][2] = f64::NAN, "parameter", "point 2: amplitude = NaN"),
        (|_, a| a[1][2] = f64::INFINITY, "residual", "inf at point 2, entry 0: numbers of an orbit are finite"),
        (|_, a| a[2][3] = f64::NAN, "z", "NaN at point 1, entry 1: numbers of an orbit are finite"),
        (|_, a| a[2][3] += 1e-6, "z", "is not valid: an orbit returns to 1e-8"),
        (|_, a| a[2][0] = 1e300, "z", "point 0: "),
        // The flow over a period of these would take hours.
        (|s, _| slowed(s, 1.8e-7), "z", "rates = up to 1.4e7 is not valid: contacts, resonators, damping"),
        (|_, a| a[2][1] = 1e24, "z", "point 0: rates = up to"),
    ];
    for (alter, place, rule) in cases {
        let (mut settings, mut arrays) = (settings.clone(), arrays.clone());
        alter(&mut settings, &mut arrays);
        let arrays = shapes.iter().zip(arrays);
        let arrays: Vec<Array<'_>> =
            arrays.map(|((name, shape), values)| Array { name, shape: shape.clone(), values }).collect();
        fs::write(&path, npz_with("settings.json", &settings.to_string(), &arrays).unwrap()).unwrap();
        let error = load_branch::<DrivenContinuation>(&path).unwrap_err();
        let text = error.to_string();
        println!("{text}");
        assert!(matches!(error, Error::Content { .. }), "{text}");
        assert!(text.starts_with(&format!("{}, {place}: ", path.display())) && text.contains(rule), "{rule}: {text}");
    }
}
