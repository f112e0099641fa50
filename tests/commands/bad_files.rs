//! Files that are not what they should be, and numbers that are none: always an error with the
//! file, the key and the rule; never a panic, a hang or a demand for memory.
//!
//! Branch files, stores and unfinished runs have tests of their own kind beside what they keep. The
//! fuzz targets in `fuzz/` try what nobody thought of.

use super::refusals::rows;
use hertzchain::{
    orbits::{Branch, DrivenContinuation},
    output::{Archive, Array, npz, npz_with},
    scene::{Initial, Scene, SceneFile},
    study::{LongRun, Plan, load_branch},
};
use std::{
    fs,
    path::Path,
    time::{Duration, Instant},
};

/// Reading integrates nothing: a case takes well below a millisecond. A hang takes longer than
/// this, whatever else the machine does.
const AT_ONCE: Duration = Duration::from_secs(5);

fn at_once<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    assert!(start.elapsed() < AT_ONCE, "{what}: {:?}", start.elapsed());
    result
}

/// The scene in a text, as `Scene::load` reads it, or the message. Profiles of bright breathers are
/// not solved for: that takes a twentieth of a second each.
fn read(text: &str) -> Result<Option<Scene>, String> {
    let bright = |file: &SceneFile| matches!(file.initial, Initial::BrightBreather { .. });
    let scene = SceneFile::parse(text, "x.toml")
        .and_then(|file| if bright(&file) { Ok(None) } else { Scene::build(file).map(Some) });
    scene.map_err(|error| {
        let message = error.to_string();
        assert!(!message.chars().any(char::is_control), "{message:?}");
        message
    })
}

/// Truth: fuzzing begins with what readers take.
#[test]
fn seeds_of_fuzzing_are_read() {
    let seeds = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds");
    let paths = |kind: &str| fs::read_dir(seeds.join(kind)).unwrap().map(|file| file.unwrap().path());
    paths("scene").for_each(|path| drop(Scene::load(path.to_str().unwrap()).unwrap()));
    for plan in paths("plan").map(|path| Plan::load(&path).unwrap()) {
        (0..plan.points()).for_each(|k| drop(plan.scene(&plan.point(k)).unwrap()));
    }
    let folder = tempfile::tempdir().unwrap();
    for path in ["branch", "driven", "checkpoint"].into_iter().flat_map(paths) {
        let (bytes, copy) = (fs::read(&path).unwrap(), folder.path().join("seed.npz"));
        // Settings in plain text, from which the fuzz target makes an archive: their arrays are
        // next.
        let settings =
            bytes.strip_prefix(b"~").and_then(|made| std::str::from_utf8(made.split(|x| *x == 0).next()?).ok());
        fs::write(&copy, settings.map_or(bytes.clone(), |text| npz_with("settings.json", text, &[]).unwrap())).unwrap();
        let read = match path.parent().unwrap().file_name().unwrap().to_str().unwrap() {
            "branch" => Branch::load(&copy).map(drop),
            "driven" => load_branch::<DrivenContinuation>(&copy).map(drop),
            _ => LongRun::load(&copy, None).map(drop),
        };
        let why = read.err().map(|why| why.to_string());
        let good = why.as_ref().is_none_or(|why| settings.is_some() && why.ends_with("it is missing"));
        assert!(good && why.is_none_or(|why| !why.contains("settings.json")), "{}", path.display());
    }
}

#[test]
fn a_scene_cut_or_altered_anywhere_is_a_scene_or_an_error() {
    for (name, _) in Scene::list() {
        let text = Scene::source(name).unwrap();
        for k in 0..text.len() {
            let _ = at_once(name, || read(&text[..k]));
            let mut altered = text.clone().into_bytes();
            // Within ASCII: files that are no text are another test's.
            altered[k] ^= 1 << (k % 7);
            let altered = String::from_utf8(altered).unwrap();
            if let Ok(Some(scene)) = at_once(name, || read(&altered)) {
                assert!(scene.initial().as_slice().iter().all(|value| value.is_finite()), "{name}, byte {k}");
                assert!(scene.end().is_finite() && scene.end() > 0.0, "{name}, byte {k}");
            }
        }
    }
}

#[test]
fn a_plan_cut_or_altered_anywhere_is_a_plan_or_an_error() {
    let text: String =
        Plan::TEMPLATE.lines().filter(|line| !line.starts_with('#')).map(|line| format!("{line}\n")).collect();
    let read = |text: &str| {
        at_once(text, || Plan::parse(text, Path::new("x.toml"))).map_err(|error| {
            let message = error.to_string();
            assert!(message.contains("x.toml") && !message.contains(char::is_control), "{message:?}");
        })
    };
    assert!(read(&text).is_ok_and(|plan| plan.points() == 15));
    for k in 0..text.len() {
        let _ = read(&text[..k]);
        let mut altered = text.clone().into_bytes();
        altered[k] ^= 1 << (k % 7);
        let _ = read(&String::from_utf8(altered).unwrap());
    }
}

#[test]
fn what_no_scene_can_say_is_refused_with_file_key_and_rule() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bad.toml");
    let name = file.display().to_string();
    for row in rows(include_str!("../refusals/scenes.txt")) {
        let fields: Vec<&str> = row.split(" | ").collect();
        let [scene, from, to, key, rule] = fields[..] else { panic!("{row}") };
        let text = Scene::source(scene).unwrap();
        assert!(text.contains(from), "{scene}: {from}");
        fs::write(&file, text.replacen(from, to, 1)).unwrap();
        let error = at_once(to, || Scene::load(&name)).expect_err(to).to_string();
        assert!(error.starts_with(&format!("scene {name}: ")) && error.lines().count() == 1, "{to}: {error}");
        assert!(error.contains(key) && error.contains(rule), "{to}: {error}\n  key {key}, rule {rule}");
    }
}

#[test]
fn what_is_no_text_is_refused_and_line_ends_and_byte_order_marks_are_not() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bad.toml");
    let name = file.display().to_string();
    let text = Scene::source("tw-q15").unwrap();
    let load = |bytes: &[u8]| {
        fs::write(&file, bytes).unwrap();
        at_once("a file", || Scene::load(&name)).map_err(|error| error.to_string())
    };
    for (bytes, rule) in [
        (Vec::new(), "missing field"),
        (b"\n\n".to_vec(), "missing field"),
        (vec![0; 1000], "line 1: "),
        ((0..=255).collect(), "valid UTF-8"),
        (text.replace("tw-q15", "\u{1}").into_bytes(), "line 1: "),
        ([text.as_bytes(), &[0xc3]].concat(), "valid UTF-8"),
        (text.encode_utf16().flat_map(u16::to_le_bytes).collect(), "line 1: "),
        ("[".repeat(100_000).into_bytes(), "line 1: "),
        (("a = ".to_owned() + &"[".repeat(100_000)).into_bytes(), "recurs"),
        (("a".to_owned() + &".a".repeat(100_000) + " = 1").into_bytes(), "recurs"),
        (text.replace("50", &"4".repeat(100_000)).into_bytes(), "line 5: `chain.sites`"),
        (text.replace("1.5", &"9".repeat(100_000)).into_bytes(), "line 6: `chain.alpha`"),
        (text.replace("1.5", &("0.".to_owned() + &"0".repeat(100_000) + "1")).into_bytes(), "smaller than any double"),
    ] {
        let start = String::from_utf8_lossy(&bytes[..bytes.len().min(20)]).into_owned();
        let error = load(&bytes).expect_err(&start);
        assert!(
            error.contains(&name) && error.contains(rule) && error.lines().count() == 1,
            "{start:?}, {rule}: {error:.300}"
        );
    }
    for good in [text.replace('\n', "\r\n"), format!("\u{feff}{text}")] {
        let (read, whole) = (load(good.as_bytes()).unwrap(), Scene::load("tw-q15").unwrap());
        assert!(read.file() == whole.file() && read.initial().as_slice() == whole.initial().as_slice());
    }
    for (path, rule) in [(folder.path().to_path_buf(), "directory"), (folder.path().join("none.toml"), "No such file")]
    {
        let name = path.display().to_string();
        let error = Scene::load(&name).unwrap_err().to_string();
        assert!(error.contains(&name) && error.contains(rule), "{error}");
    }
}

/// A file without an end.
#[cfg(unix)]
#[test]
fn a_device_is_refused_before_it_fills_the_memory() {
    let path = Path::new("/dev/zero");
    let refusals = [
        at_once("a device", || Scene::load("/dev/zero")).map(|_| ()),
        at_once("a device", || Branch::load(path)).map(|_| ()),
        at_once("a device", || LongRun::load(path, None)).map(|_| ()),
    ];
    for (refusal, rule) in refusals.into_iter().zip(["256 MiB", "not an NPZ file", "not an NPZ file"]) {
        let error = refusal.unwrap_err().to_string();
        assert!(error.starts_with("/dev/zero, ") && error.contains(rule), "{error}");
    }
}

#[test]
fn an_archive_with_two_members_of_one_name_is_refused() {
    let path = Path::new("two.npz");
    let [x, y] = ["x", "y"].map(|name| Array::vector(name, vec![1.0]));
    let mut bytes = npz(&[x, y]).unwrap();
    assert!(Archive::from_bytes(path, &bytes).is_ok());
    // Names stand before each member and in the list at the end, in no checksum.
    for k in 0..bytes.len() - 5 {
        if &bytes[k..k + 5] == b"y.npy" {
            bytes[k] = b'x';
        }
    }
    let error = Archive::from_bytes(path, &bytes).unwrap_err().to_string();
    assert_eq!(error, "two.npz, archive: two of its members have the same name");
}
