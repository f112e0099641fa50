//! Branches as files: read back to the bit, continued after any stop, and refused if they are not
//! as they were written.

#[cfg(feature = "cli")]
use crate::program::{refused as not_run, stdout};
use hertzchain::{
    Error,
    breathers::DarkBreather,
    chain::Params,
    dps::Center,
    orbits::{
        Bifurcation, Branch, Continuation, DriveParameter, DrivenBranch, DrivenContinuation, DrivenSetting,
        DrivenShooting, End, Formulation, ModeContinuation, NormalModes, Orbit, Parameter, Pick, Problem, Shooting,
    },
    output::{Archive, Array, npz, npz_with},
    scene::Scene,
    study::{BranchOptions, ContinueWave, FollowCommand, Kept, Wanted, branch_npz, branch_report, load_branch, study},
    sweep::Engine,
};
use serde_json::{Value, json};
use std::{
    fs,
    path::{Path, PathBuf},
};

fn breather() -> DarkBreather {
    let params = Params::new(1.5, 1.0, 1.0 / 3.0).unwrap();
    DarkBreather { params, center: Center::Bond, sites: 11, omega_b: 2.03, c_x: 0.0 }
}

fn continuation(parameter: Parameter, to: f64, step: f64) -> Continuation {
    Continuation { parameter, to, step, most_points: 1000, shooting: Shooting::default() }
}

fn trail(continuation: Continuation) -> Branch {
    let mut trail =
        Branch::new(continuation, breather().setting(), breather().orbit(&continuation.shooting).unwrap()).unwrap();
    trail.extend(|_| {}).unwrap();
    Branch { weak: Some(0.01), ..trail }
}

fn saved<P: Kept>(folder: &Path, about: &P::About, branch: &Branch<P>) -> PathBuf {
    let path = folder.join("branch.npz");
    fs::write(&path, branch_npz(about, branch).unwrap()).unwrap();
    path
}

/// All numbers of a branch, to the bit.
fn text<P: Problem>(branch: &Branch<P>) -> String {
    format!("{branch:?}")
}

/// The branch without the Newton steps, which files leave out.
fn bare(mut trail: Branch) -> Branch {
    trail.orbits.iter_mut().for_each(|orbit| orbit.newton.clear());
    trail
}

/// A bead that rests on a wall and is shaken.
const SHAKEN: &str = include_str!("../reference/pushed-bead.toml");

fn shaken(scene: &Scene, most_points: usize) -> DrivenBranch {
    let (shooting, setting) = (DrivenShooting::default(), DrivenSetting::new(scene.chain(), 1).unwrap());
    let start = shooting.solve(&setting, &vec![0.0; setting.unknowns()]).unwrap();
    let parameter = DriveParameter::Amplitude;
    let continuation = DrivenContinuation { parameter, to: 1.95, step: 0.3, most_points, shooting };
    let mut branch = Branch::new(continuation, setting, start).unwrap();
    branch.extend(|_| {}).unwrap();
    branch
}

fn bits(orbit: &Orbit) -> Vec<u64> {
    let setting = orbit.setting;
    let numbers = Parameter::ALL.map(|parameter| setting.get(parameter));
    numbers.iter().chain(&orbit.z).map(|value| value.to_bits()).collect()
}

#[test]
fn branches_and_orbits_are_read_back_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let full = Shooting { formulation: Formulation::FullPeriod, ..Shooting::default() };
    for (parameter, to, step, shooting) in [
        (Parameter::OmegaB, 2.05, 6e-3, Shooting::default()),
        (Parameter::Rho, 0.335, 1e-3, Shooting::default()),
        (Parameter::Cx, 0.01, 4e-3, full),
    ] {
        let trail = trail(Continuation { shooting, ..continuation(parameter, to, step) });
        assert!(trail.end == Some(End::Reached) && trail.orbits.len() >= 3, "{parameter:?}");
        let path = saved(folder.path(), &(), &trail);
        let read = Branch::load(&path).unwrap();
        assert_eq!(text(&read), text(&bare(trail.clone())));
        for (k, orbit) in trail.orbits.iter().enumerate() {
            let at = Pick::At(orbit.setting.get(parameter) * (1.0 + 1e-12 * if k == 0 { 1.0 } else { -1.0 }));
            let back = Pick::Point(k as i64 - trail.orbits.len() as i64);
            for pick in [Pick::Point(k as i64), back, at] {
                assert_eq!(bits(&Orbit::load(&path, Some(pick)).unwrap()), bits(orbit), "{pick:?}");
            }
        }
    }
}

#[test]
fn a_branch_stopped_anywhere_and_gone_on_with_has_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    for (parameter, to, step) in [(Parameter::OmegaB, 2.08, 4e-3), (Parameter::Kappa, 0.99, 2e-3)] {
        let continuation = continuation(parameter, to, step);
        let stopped = trail(Continuation { most_points: 2, ..continuation });
        assert_eq!(stopped.end, Some(End::MostPoints));
        goes_on(folder.path(), &(), trail(continuation), stopped, bare);
    }
    let scene = Scene::load(SHAKEN).unwrap();
    let main = shaken(&scene, 200);
    let mut doubled = main.clone().analysed().switched(0).unwrap();
    let crossing = doubled.clone();
    doubled.continuation.most_points = 12;
    doubled.extend(|_| {}).unwrap();
    for (whole, stopped) in [(main, shaken(&scene, 2)), (doubled, crossing)] {
        goes_on(folder.path(), &scene, whole, stopped, |mut branch| {
            branch.orbits.iter_mut().for_each(|orbit| orbit.newton.clear());
            branch
        });
    }
}

/// Keeps a branch in a file after every further point, goes on with the file, and compares all with
/// the whole branch. `bare`: without the Newton steps.
fn goes_on<P: Kept>(
    folder: &Path,
    about: &P::About,
    whole: Branch<P>,
    mut stopped: Branch<P>,
    bare: fn(Branch<P>) -> Branch<P>,
) {
    let count = whole.orbits.len();
    assert!(count >= 5, "{count}");
    for points in stopped.orbits.len() + 1..=count {
        let (_, read) = load_branch::<P>(&saved(folder, about, &stopped)).unwrap();
        assert_eq!(text(&read), text(&bare(stopped)));
        stopped = read.onward(None, None, points).unwrap();
        stopped.extend(|_| {}).unwrap();
    }
    stopped.continuation = whole.continuation;
    assert_eq!(text(&bare(stopped)), text(&bare(whole)));
}

#[test]
fn a_branch_goes_on_beyond_its_end_and_not_back() {
    let folder = tempfile::tempdir().unwrap();
    let read = Branch::load(&saved(folder.path(), &(), &trail(continuation(Parameter::OmegaB, 2.04, 4e-3)))).unwrap();
    let mut further = read.clone().onward(Some(2.05), Some(2e-3), 100).unwrap();
    assert_eq!(further.extend(|_| {}).unwrap(), End::Reached);
    assert_eq!(further.orbits[..read.orbits.len()], read.orbits);
    let steps = further.orbits[read.orbits.len() - 1..].windows(2).map(|w| w[1].setting.omega_b - w[0].setting.omega_b);
    assert!(steps.clone().count() >= 4 && steps.fold(0.0, f64::max) < 2.01e-3);
    // Truth: the orbit at the same frequency, found from its seed. Measured: 3e-16.
    let truth = DarkBreather { omega_b: 2.05, ..breather() }.orbit(&Shooting::default()).unwrap();
    let last = further.orbits.last().unwrap();
    let apart = truth.z.iter().zip(&last.z).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("{apart:e}");
    assert!(last.setting == truth.setting && apart < 6e-16);
    for to in [2.04, 2.035, 2.03, 2.02, f64::NAN, f64::INFINITY] {
        let refused = read.clone().onward(Some(to), None, 100).unwrap_err().to_string();
        assert!(refused.starts_with("to = "), "{to}: {refused}");
    }
    assert_eq!(read.clone().onward(None, None, 100).unwrap().end, Some(End::Reached), "there is nothing to follow");
    assert!(read.clone().onward(Some(2.05), Some(-1.0), 100).unwrap_err().to_string().contains("step = -1"));
    assert!(read.onward(Some(2.05), None, 1).unwrap_err().to_string().contains("points = 1"));
}

#[test]
fn whatever_byte_is_cut_or_altered_there_is_an_error_or_the_same_branch() {
    let folder = tempfile::tempdir().unwrap();
    let branch = trail(continuation(Parameter::OmegaB, 2.04, 8e-3));
    let path = saved(folder.path(), &(), &branch);
    let (written, branch) = (fs::read(&path).unwrap(), bare(branch));
    let name = path.display().to_string();
    let read = |bytes: &[u8]| {
        // Some file systems wait for the disk when a file is overwritten.
        fs::remove_file(&path).unwrap();
        fs::write(&path, bytes).unwrap();
        Branch::load(&path).map_err(|error| {
            assert!(matches!(&error, Error::Content { .. }) && error.to_string().contains(&name), "{error}");
        })
    };
    for length in (0..written.len()).step_by(7).chain(written.len() - 60..written.len()) {
        assert!(read(&written[..length]).is_err(), "{length} of {} bytes", written.len());
    }
    // Of the bytes that zip adds to the members, some are there twice and some are not read: dates,
    // versions, attributes.
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(&written)).unwrap();
    let members = (0..archive.len()).map(|k| {
        let member = archive.by_index(k).unwrap();
        let start = member.data_start().unwrap() as usize;
        start..start + member.size() as usize
    });
    let members: Vec<_> = members.collect();
    assert!(members.len() == 7 && members.iter().map(|range| range.len()).sum::<usize>() > 2000);
    for k in 0..written.len() {
        let mut altered = written.clone();
        altered[k] ^= 1 << (k % 8);
        if let Ok(read) = read(&altered) {
            assert_eq!(text(&read), text(&branch), "byte {k}");
            assert!(!members.iter().any(|range| range.contains(&k)), "byte {k} of a member");
        }
    }
}

#[test]
fn orbits_without_multipliers_are_gaps() {
    let mut broken = trail(continuation(Parameter::OmegaB, 2.04, 8e-3));
    let count = broken.orbits.len();
    // An orbit in the middle that no chain has: its flow fails.
    broken.orbits[2].setting.turns = 7;
    let gap = broken.orbits[2].setting.omega_b;
    let branch = study(broken.clone(), &Engine::threads(), &|_, _| {}).unwrap();
    assert_eq!((branch.points.len(), branch.ended(), branch.orbits.len()), (count - 1, End::Reached, count));
    assert_eq!(branch.gaps, [gap]);
    let report = branch_report(&branch).unwrap();
    let text = report.text().replace('\n', " ");
    assert!(text.contains(&format!("Orbits without multipliers at omega_b = {gap:.8}")) && report.error().is_none());
    broken.orbits[count - 1].setting.turns = 7;
    let branch = study(broken.clone(), &Engine::threads(), &|_, _| {}).unwrap();
    assert_eq!((branch.points.len(), branch.ended()), (count - 2, End::NoMultipliers));
    assert!(branch_report(&branch).unwrap().error().is_some());
    let why = branch.reached().unwrap_err().to_string();
    assert!(why.contains("is at omega_b = 2.04, but") && why.contains("the multipliers of its last orbit"), "{why}");
    broken.orbits.iter_mut().for_each(|orbit| orbit.setting.turns = 7);
    // Without any multipliers there is the table of the orbits, and the error.
    let report = branch_report(&study(broken, &Engine::threads(), &|_, _| {}).unwrap()).unwrap();
    assert_eq!((report.json()["points"].as_array().unwrap().len(), report.error().is_some()), (count, true));
}

/// Holds the refusals of the files of altered branches, which have these arrays of unknowns.
fn refused<P: Kept>(about: &P::About, branch: &Branch<P>, arrays: &[(&'static str, u64)], cases: &[Case]) {
    let folder = tempfile::tempdir().unwrap();
    let path = saved(folder.path(), about, branch);
    let written = Forgery::new(&path, arrays);
    for (alter, place, rule) in cases {
        let mut forgery = written.clone();
        alter(&mut forgery);
        fs::write(&path, forgery.bytes()).unwrap();
        let Err(error) = load_branch::<P>(&path) else { panic!("{rule}: read") };
        let text = error.to_string();
        println!("{text}");
        assert!(matches!(error, Error::Content { .. }), "{text}");
        assert!(text.starts_with(&format!("{}, {place}: ", path.display())) && text.contains(rule), "{rule}: {text}");
    }
}

/// Gives the drive another frequency.
fn slowed(settings: &mut Value, omega: f64) {
    let scene = &mut settings["setting"]["scene"];
    *scene = json!(scene.as_str().unwrap().replace("omega = [1.8", &format!("omega = [{omega}")));
}

#[test]
fn what_cannot_be_a_driven_branch_is_refused_with_file_place_and_rule() {
    let scene = Scene::load(SHAKEN).unwrap();
    let cases: &[Case] = &[
        (|f| f.settings["points"] = json!(0), "settings.json", "points = 0 is not valid: at least one"),
        (|f| f.settings["ds"] = json!(0.0), "settings.json", "ds = 0 is not valid: finite and positive"),
        (|f| f.settings["continuation"]["step"] = json!(-1.0), "settings.json", "step = -1"),
        (|f| f.settings["setting"]["turns"] = json!(65), "settings.json", "from 1 to 64"),
        (|f| f.settings["birth"] = json!("period-doubling"), "settings.json", "even after a period doubling"),
        (|f| f.settings["more"] = json!(1), "settings.json", "unknown field `more`"),
        (|f| f.settings["setting"]["scene"] = json!("[chain]"), "settings.json", "missing field"),
        (|f| f.array("parameter").2[1] = 0.0, "parameter", "point 1: amplitude = 0"),
        (|f| f.array("parameter").2[2] = f64::NAN, "parameter", "point 2: amplitude = NaN"),
        (|f| f.array("z").2[3] = f64::NAN, "z", "NaN at point 1, entry 1: numbers of an orbit are finite"),
        (|f| f.array("z").2[3] += 1e-6, "z", "is not valid: an orbit returns to 1e-8"),
        (|f| f.array("z").2[0] = 1e300, "z", "point 0: "),
        // The flow over a period of these would take hours.
        (|f| slowed(&mut f.settings, 1.8e-7), "z", "rates = up to 1.5e7 is not valid: contacts, resonators, damping"),
        (|f| f.array("z").2[1] = 1e24, "z", "point 0: rates = up to"),
    ];
    refused(&scene, &shaken(&scene, 4), &[("z", 2)], cases);
}

#[test]
fn what_cannot_be_a_branch_of_a_mode_or_of_waves_is_refused_with_file_place_and_rule() {
    let scene = Scene::load("defect").unwrap();
    let modes = NormalModes::new(scene.chain()).unwrap();
    let way = ModeContinuation { mode: 20, to: 0.02, step: 0.01, most_points: 10 };
    let mut mode = way.begin(&modes).unwrap();
    mode.extend(|_| {}).unwrap();
    let unknowns = modes.linear().len() as u64;
    refused(
        &scene,
        &mode,
        &[("z", unknowns)],
        &[
            (
                |f| f.settings["format"] = json!("hertzchain branch"),
                "settings.json",
                "read is hertzchain mode branch, version 1",
            ),
            (|f| f.settings["continuation"]["mode"] = json!(99), "parameter", "point 0: linear_mode = 100 of 21"),
            (|f| f.settings["continuation"]["to"] = json!(0.0), "settings.json", "to = 0"),
            (|f| f.array("z").2[0] = f64::NAN, "z", "NaN at point 0, entry 0: numbers of an orbit are finite"),
            (|f| f.array("z").2[0] += 1e-3, "z", "point 0: residual = "),
            // The flow over a period of these would take hours.
            (|f| f.array("z").2[20] = -30.0, "z", "point 0: rates = up to"),
            (|f| f.array("z").2[0] = 1e30, "z", "point 0: rates = up to"),
        ],
    );
    let wanted = Wanted { sites: Some(10), ..Wanted::of("tw-q15") };
    let branch = BranchOptions { to: Some(2.002), ..BranchOptions::default() };
    let waves = ContinueWave { wanted, branch, ..ContinueWave::default() };
    let waves = waves.follow().unwrap()(&Engine::threads(), &|_, _| {}).unwrap();
    let arrays = [("x", 10), ("y", 10), ("vx", 10), ("vy", 10), ("setting", 1)];
    refused(
        &waves.scene,
        &waves.branch,
        &arrays,
        &[
            (
                |f| f.settings["setting"]["wave"]["setting"]["q"]["turns"] = json!(0),
                "settings.json",
                "above 0 and at most 1",
            ),
            (|f| f.settings["setting"]["wave"]["sites"] = json!(300), "settings.json", "sites = 300"),
            (|f| f.settings["setting"]["wave"]["size"] = json!(0.0), "settings.json", "size = 0"),
            (|f| f.settings["setting"]["wave"]["setting"]["params"]["rho"] = json!(-1.0), "settings.json", "rho = -1"),
            (|f| f.array("x").2[1] = f64::INFINITY, "x", "inf at point 0, entry 1: numbers of an orbit are finite"),
            (|f| f.array("x").2[1] += 1e-4, "x", "point 0: residual = "),
            (|f| f.array("x").2[1] = 1e30, "x", "point 0: rates = up to"),
        ],
    );
}

// Truth: the search over all points at once, with spectra computed here. A gap at the end of a
// segment, or wider than one, is passed over by the next segment.
#[test]
fn bifurcations_of_a_branch_in_segments_are_those_of_the_whole_branch() {
    let whole = trail(continuation(Parameter::OmegaB, 2.1, 8e-3));
    let count = whole.orbits.len();
    assert!(count > 10, "{count}");
    for gaps in [&[][..], &[3], &[4], &[0, 2, 3, 4], &[1, 2, 3, 4, 5, 6, 7, 8]] {
        let mut broken = whole.clone();
        gaps.iter().for_each(|&gap: &usize| broken.orbits[gap].setting.turns = 7);
        let branch = study(broken.clone(), &Engine::threads(), &|_, _| {}).unwrap();
        broken.orbits.retain(|orbit| orbit.setting.turns == 1);
        let spectra: Vec<_> = broken.orbits.iter().map(|orbit| orbit.spectrum(&Shooting::default()).unwrap()).collect();
        let want = broken.analysed().bifurcations;
        // Numbers of orbits differ by the gaps.
        assert_eq!(branch.bifurcations.len(), want.len());
        let found =
            branch.bifurcations.into_iter().zip(&want).map(|(one, want)| Bifurcation { after: want.after, ..one });
        assert!(want.len() > 1 && found.collect::<Vec<_>>() == want, "{gaps:?}: {want:?}");
        assert_eq!((branch.points.len(), branch.gaps.len()), (count - gaps.len(), gaps.len()));
        for (point, spectrum) in branch.points.iter().zip(&spectra) {
            assert!(point.spectrum.multipliers == spectrum.multipliers && point.spectrum.tau == spectrum.tau);
            assert_eq!(point.spectrum.quality, spectrum.quality);
            assert!(point.spectrum.direction(0).is_empty() && !spectrum.direction(0).is_empty());
        }
    }
}

/// A branch file whose settings and arrays are replaced; all its checksums fit.
#[derive(Clone)]
struct Forgery {
    settings: Value,
    arrays: Vec<(&'static str, Vec<u64>, Vec<f64>)>,
}

impl Forgery {
    fn new(path: &Path, unknowns: &[(&'static str, u64)]) -> Self {
        let file = Archive::read(path).unwrap();
        let settings: Value = serde_json::from_str(file.text("settings.json").unwrap()).unwrap();
        let points = settings["points"].as_u64().unwrap();
        let array = |name, shape: &[u64]| (name, shape.to_vec(), file.array(name, shape).unwrap());
        let one = ["parameter", "residual"].map(|name| array(name, &[points]));
        let more = unknowns.iter().map(|(name, width)| array(name, &[points, *width]));
        Self { settings, arrays: one.into_iter().chain(more).collect() }
    }

    fn array(&mut self, name: &str) -> &mut (&'static str, Vec<u64>, Vec<f64>) {
        self.arrays.iter_mut().find(|array| array.0 == name).unwrap()
    }

    fn bytes(&self) -> Vec<u8> {
        let arrays = self.arrays.iter().map(|(name, shape, values)| Array {
            name,
            shape: shape.clone(),
            values: values.clone(),
        });
        npz_with("settings.json", &self.settings.to_string(), &arrays.collect::<Vec<_>>()).unwrap()
    }
}

/// An alteration, the place where it is found, and the violated rule.
type Case = (fn(&mut Forgery), &'static str, &'static str);

#[test]
fn what_cannot_be_a_branch_is_refused_with_file_key_and_rule() {
    let folder = tempfile::tempdir().unwrap();
    let branch = trail(continuation(Parameter::OmegaB, 2.04, 8e-3));
    let path = saved(folder.path(), &(), &branch);
    let (written, name) = (fs::read(&path).unwrap(), path.display().to_string());
    let unknowns = [("x", 11), ("y", 11)];
    let cases: &[Case] = &[
        (|f| f.settings["version"] = json!(2), "settings.json", "version 2; read is hertzchain branch, version 1"),
        (|f| f.settings["format"] = json!("other"), "settings.json", "other, version 1"),
        (|f| f.settings["points"] = json!(0), "settings.json", "points = 0 is not valid: at least one"),
        (|f| f.settings["points"] = json!(u64::MAX), "parameter", "[18446744073709551615] doubles"),
        (|f| f.settings["points"] = json!(2), "parameter", "[2] doubles"),
        (|f| f.settings["setting"]["sites"] = json!(10), "settings.json", "sites = 10 is not valid: an odd number"),
        (|f| f.settings["setting"]["sites"] = json!(u64::MAX), "settings.json", "from 3 to 256 sites"),
        (|f| f.settings["setting"]["omega_b"] = json!(-2.0), "settings.json", "omega_b = -2"),
        (|f| f.settings["setting"]["turns"] = json!(3), "settings.json", "turns = 3"),
        (|f| f.settings["setting"]["params"]["rho"] = json!(-1.0), "settings.json", "rho = -1"),
        (|f| f.settings["setting"]["params"]["rho"] = json!(0.34), "x", "this is none"),
        (|f| f.settings["setting"]["params"]["alpha"] = Value::Null, "settings.json", "invalid type: null"),
        (|f| f.settings["ds"] = json!(0.0), "settings.json", "ds = 0 is not valid: finite and positive"),
        (|f| f.settings["weak"] = json!(-1.0), "settings.json", "weak = -1"),
        (|f| f.settings["end"] = json!("never"), "settings.json", "unknown variant `never`"),
        (|f| f.settings["more"] = json!(1), "settings.json", "unknown field `more`"),
        (|f| f.settings["continuation"]["step"] = json!(0.0), "settings.json", "step = 0"),
        (|f| f.settings["continuation"]["to"] = json!(2.03), "settings.json", "to = 2.03"),
        (|f| f.settings["continuation"]["parameter"] = json!("omega"), "settings.json", "unknown variant `omega`"),
        (|f| f.settings["continuation"]["shooting"]["tol"] = json!(7.0), "x", "tol = 7"),
        (|f| f.array("x").2[12] = f64::NAN, "x", "NaN at point 1, entry 1: numbers of an orbit are finite"),
        (|f| f.array("y").2[10] = f64::INFINITY, "y", "inf at point 0, entry 10: numbers of an orbit are finite"),
        (|f| f.array("x").2[0] = 1e300, "x", "point 0: strains = 1e300"),
        (|f| f.array("parameter").2[1] = 1e-9, "x", "point 1: strains = "),
        (|f| f.settings["setting"]["params"]["kappa"] = json!(1e100), "x", "at most 1000 times as fast"),
        (|f| f.array("x").2[0] += 1e-6, "x", "point 0: residual"),
        (|f| f.arrays[2..].iter_mut().for_each(|array| array.2.fill(0.0)), "x", "point 0: "),
        (|f| f.array("parameter").2[1] = f64::NAN, "parameter", "point 1: omega_b = NaN"),
        (|f| f.array("residual").1.push(1), "residual", "doubles"),
        (|f| drop(f.arrays.pop()), "y", "it is missing"),
        (|f| f.array("x").0 = "z", "x", "it is missing"),
    ];
    refused(&(), &branch, &unknowns, cases);
    let refused = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        let error = Branch::load(&path).unwrap_err();
        assert!(matches!(error, Error::Content { .. }), "{error}");
        error.to_string()
    };
    // Each key left out in turn.
    let whole = Forgery::new(&path, &unknowns);
    for inside in ["", "/setting", "/setting/params", "/continuation", "/continuation/shooting"] {
        for key in whole.settings.pointer(inside).unwrap().as_object().unwrap().keys() {
            let mut forgery = whole.clone();
            forgery.settings.pointer_mut(inside).unwrap().as_object_mut().unwrap().remove(key);
            let text = refused(&forgery.bytes());
            assert!(text.contains(&format!("settings.json: missing field `{key}`")), "{text}");
        }
    }
    fs::write(&path, &written).unwrap();
    let settings = Archive::read(&path).unwrap().text("settings.json").unwrap().to_owned();
    let with = |from, to| npz_with("settings.json", &settings.replacen(from, to, 1), &[]).unwrap();
    for (bytes, place, rule) in [
        (Vec::new(), "archive", "not an NPZ file"),
        (npz(&[Array::vector("x", vec![1.0])]).unwrap(), "settings.json", "it is missing"),
        (with(r#""sites": 11"#, r#""sites": 11, "sites": 13"#), "settings.json", "duplicate field `sites` at line"),
        (
            npz_with("settings.json", &(r#"{"a":"#.to_owned() + &"[".repeat(100_000)), &[]).unwrap(),
            "settings.json",
            "EOF while parsing a list",
        ),
    ] {
        let text = refused(&bytes);
        assert!(text.starts_with(&format!("{name}, {place}: ")) && text.contains(rule), "{text}");
    }
    let fails = |path: &Path| Branch::load(path).unwrap_err().to_string();
    assert!(fails(folder.path()).contains("not an NPZ file"));
    assert!(fails(&path.join("below")).contains("branch.npz/below: "));
    assert!(fails(&folder.path().join("none.npz")).contains("none.npz: No such file"));
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::write(&path, &written).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o000)).unwrap();
        // The superuser can read every file.
        assert!(fs::File::open(&path).is_ok() || fails(&path).contains("branch.npz: Permission denied"));
    }
}

#[cfg(feature = "cli")]
#[test]
fn commands_take_branches_and_refuse_what_is_none() {
    let folder = tempfile::tempdir().unwrap();
    let [main, twice] = ["main", "twice"].map(|name| folder.path().join(name).display().to_string());
    let [branch, doubled] = [&main, &twice].map(|folder| format!("{folder}/branch.npz"));
    let [branch, doubled] = [branch.as_str(), doubled.as_str()];
    let sites = ["--center", "bond", "--sites", "21", "--from", "2.06", "--to", "2.065", "--step", "1e-3"];
    let run = |args: &[&str]| drop(stdout(args));
    run(&[&["breather", "continue"], &sites[..], &["--out", &main]].concat());
    run(&["breather", "doubled", "--branch", branch, "--omega-b", "1.033", "--out", &twice]);
    for pick in [["--point", "0"], ["--point", "-1"], ["--at", "2.0605"]] {
        run(&[&["breather", "evolve", branch, "--until", "10"][..], &pick].concat());
    }
    // Orbits of doubled period, whose centre is not the one measured over the whole period.
    let last = Branch::load(Path::new(doubled)).unwrap();
    assert!(last.orbits.iter().all(|orbit| orbit.setting.turns == 2) && last.weak.is_none());
    let file = folder.path().join("evolution.json");
    run(&["breather", "evolve", doubled, "--at", "1.033", "--until", "25", "--out", folder.path().to_str().unwrap()]);
    let study: Value = serde_json::from_slice(&fs::read(file).unwrap()).unwrap();
    assert!(study["omega_b"] == 1.033 && study["e_b"][4].as_f64().unwrap() < 1e-11, "{}", study["e_b"]);
    run(&["breather", "continue", "--resume", doubled, "--to", "1.0335"]);
    assert_eq!(Branch::load(Path::new(doubled)).unwrap().pick(Pick::Point(-1)).unwrap().setting.omega_b, 1.0335);

    let json = format!("{main}/branch.json");
    for (args, rule) in [
        (&["breather", "evolve", branch][..], "branch.npz, orbit: it is a branch: say which of its orbits"),
        (&["breather", "evolve", branch, "--point", "999"], "point = 999 of "),
        (&["breather", "evolve", branch, "--point=-9223372036854775808"], "point = -9223372036854775808 of "),
        (&["breather", "evolve", branch, "--at", "2.07"], "at = 2.07, of 2.06 .. 2.065"),
        (&["breather", "evolve", branch, "--at", "nan"], "at = NaN"),
        (&["breather", "evolve", branch, "--at", "2.06", "--point", "1"], "cannot be used with"),
        (&["breather", "evolve", &json], "branch.json, archive: not an NPZ file"),
        (&["breather", "doubled", "--branch", doubled], "turns = 2"),
        (&["breather", "doubled", "--branch", branch, "--rho", "1"], "cannot be used with"),
        (&["breather", "continue", "--resume", branch, "--to", "2.063"], "to = 2.063"),
        (&["breather", "continue", "--resume", branch, "--to", "1.9"], "to = 1.9"),
        (&["breather", "continue", "--resume", branch, "--from", "2.06"], "cannot be used with"),
    ] {
        let text = not_run(args, 2);
        assert!(text.contains(rule), "{args:?}: {text}");
    }
}
