//! Files that are not what they should be, and numbers that are none: always an error with the
//! file, the key and the rule; never a panic, a hang or a demand for memory.
//!
//! Branch files, stores and unfinished runs have tests of their own kind beside what they keep. The
//! fuzz targets in `fuzz/` try what nobody thought of.

use super::program::hertzchain;
use hertzchain::{
    orbits::Branch,
    output::{Archive, Array, npz},
    scene::{Initial, Scene, SceneFile},
    study::{LongRun, Plan},
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

/// A built-in scene with a part of its text replaced, the key that the message names, and the rule.
type Case = (&'static str, &'static str, &'static str, &'static str, &'static str);

#[test]
fn what_no_scene_can_say_is_refused_with_file_key_and_rule() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bad.toml");
    let name = file.display().to_string();
    let cases: &[Case] = &[
        ("tw-q15", "sites = 50", "sites = 1000000000000000000", "sites", "at most 10^8"),
        ("tw-q15", "sites = 50", "sites = 4294967296", "sites", "at most 10^8"),
        ("tw-q15", "sites = 50", "sites = 1e18", "line 5: `chain.sites`", "0.0`, expected a whole number"),
        ("tw-q15", "sites = 50", "sites = -1", "line 5: `chain.sites`", "number `-1`, expected a whole number"),
        ("tw-q15", "sites = 50", "sites = 0", "sites = 0", "at least one bead"),
        ("tw-q15", "sites = 50", "sites = -0", "sites = 0", "at least one bead"),
        ("tw-q15", "sites = 50", "sites = 50.0", "line 5: `chain.sites`", "number `50.0`, expected a whole number"),
        ("tw-q15", "sites = 50", "sites = \"50\"", "line 5: `chain.sites`", "string \"50\", expected a whole number"),
        ("tw-q15", "sites = 50", "sites = [50]", "line 5: `chain.sites`", "sequence, expected a whole number"),
        ("tw-q15", "sites = 50", "sites = true", "line 5: `chain.sites`", "boolean `true`, expected a whole number"),
        ("tw-q15", "sites = 50", "sites = 2024-01-01", "line 5: `chain.sites`", "expected a whole number"),
        ("tw-q15", "sites = 50", "sites =", "line 5: ", "expected"),
        ("tw-q15", "sites = 50", "sites = 50 50", "line 5: ", "expected"),
        ("tw-q15", "sites = 50", "sites = 0x1_0000_0000_0000_0000", "line 5: `chain.sites`", "expected"),
        ("tw-q15", "sites = 50", "", "line 4: `[chain]`", "missing field `sites`"),
        ("tw-q15", "sites = 50", "sites = 50\nsites = 50", "line 6: `sites = 50`", "duplicate key"),
        ("tw-q15", "[span]", "[chain]\n[span]", "line 19: `[chain]`", "duplicate key"),
        ("tw-q15", "alpha = 1.5", "alpha = 1e400", "line 6: `chain.alpha`", "1e400: larger than any double"),
        ("tw-q15", "alpha = 1.5", "alpha = -1e400", "line 6: `chain.alpha`", "-1e400: larger than any double"),
        ("tw-q15", "alpha = 1.5", "alpha = 1e-400", "line 6: `chain.alpha`", "1e-400: smaller than any double"),
        ("tw-q15", "alpha = 1.5", "alpha = nan", "alpha = NaN", "the exponent is finite and positive"),
        ("tw-q15", "alpha = 1.5", "alpha = -inf", "alpha = -inf", "the exponent is finite and positive"),
        ("tw-q15", "alpha = 1.5", "alpha = -0.0", "alpha = -0", "the exponent is finite and positive"),
        ("tw-q15", "alpha = 1.5", "alpha = \"1.5\"", "line 6: `chain.alpha`", "string \"1.5\", expected a number"),
        ("tw-q15", "kappa = 1.0", "kappa = -0.0", "kappa = -0", "at least zero"),
        ("tw-q15", "rho = 0.3333333333333333", "rho = -0.0", "rho = -0", "at least zero"),
        ("tw-q15", "rho = 0.3333333333333333", "rho = nan", "rho = NaN", "the mass ratio is in [0, inf]"),
        ("tw-q15", "boundary = \"strain-ring\"", "boundary = 3", "line 9: `chain.boundary`", "wanted string"),
        ("tw-q15", "\"strain-ring\"", "\"rings\"", "line 9: `chain.boundary`", "did you mean `ring`?"),
        ("tw-q15", "q_over_pi = 0.2", "q_over_pi = \"x\"", "line 13: `initial.q_over_pi`", "expected a number"),
        ("tw-q15", "q_over_pi = 0.2", "q_over_pi = nan", "q_over_pi = NaN", "the wave number is from -pi to pi"),
        ("tw-q15", "q_over_pi = 0.2", "q_over_pi = 1e300", "q_over_pi = 1e300", "the wave number is from -pi to pi"),
        ("tw-q15", "phi = 0.0", "phi = inf", "phi = inf", "a finite number"),
        ("tw-q15", "phi = 0.0", "phi = 1e400", "line 16: `initial.phi`", "1e400: larger than any double"),
        ("tw-q15", "phi = 0.0", "phj = 0.0", "line 16: ", "unknown field `phj`"),
        (
            "tw-q15",
            "phi = 0.0",
            "phi = 0.0\nseed = -1\nzeta = 0.1",
            "line 17: `initial.seed`",
            "`-1`, expected a whole number",
        ),
        (
            "tw-q15",
            "\"travelling-wave\"",
            "\"traveling-wave\"",
            "line 12: `initial.kind`",
            "did you mean `travelling-wave`?",
        ),
        ("tw-q15", "kind = \"travelling-wave\"", "kind = 7", "line 12: `initial.kind`", "expected"),
        ("tw-q15", "kind = \"travelling-wave\"", "", "line 11: `[initial]`", "missing field `kind`"),
        ("tw-q15", "detuning = 0.001", "detuning = -0.0", "detuning = -0", "finite and positive"),
        ("tw-q15", "detuning = 0.001", "detuning = 1e300", "epsilon", "a normal number"),
        ("tw-q15", "periods = 100", "periods = -0.0", "periods = -0", "finite and positive"),
        ("tw-q15", "periods = 100", "periods = 1e400", "line 20: `span.periods`", "1e400: larger than any double"),
        ("tw-q15", "periods = 100", "until = nan", "until = NaN", "the end of a run is from 1e-100 to 1e100"),
        ("tw-q15", "periods = 100", "periods = 1.7e308", "periods = 1.7e308", "is from 1e-100 to 1e100"),
        ("tw-q15", "samples = 400", "samples = 1000001", "samples = 1000001", "at most 10^6"),
        ("tw-q15", "samples = 400", "samples = 9223372036854775807", "samples", "at most 10^6"),
        ("tw-q15", "samples = 400", "samples = -1", "line 23: `record.samples`", "`-1`, expected a whole number"),
        ("tw-q15", "samples = 400", "sample = 400", "line 23: ", "did you mean `samples`?"),
        ("tw-q15", "[record]", "[recorded]", "line 22: ", "did you mean `record`?"),
        ("tw-q15", "\"tw-q15\"", "\"\\u001b[31m\\u0007\"", "line 1: `name`: \"\\u{1b}[31m\\u{7}\"", "no control"),
        ("tw-q15", "name = \"tw-q15\"", "name = \"a\\tb\"", "line 1: `name`: \"a\\tb\"", "no control"),
        ("tw-q15", "name = \"tw-q15\"", "\"\\u009b\" = 1", "`\u{fffd}`: \"\\u{9b}\"", "no control"),
        ("end-driven", "amplitude = 0.2", "amplitude = 1e400", "`drive.0.amplitude`: 1e400", "larger than any double"),
        ("tw-q15", "name = \"tw-q15\"", "name = 7", "line 1: `name`", "number `7`, expected a string"),
        ("precompressed", "precompression = ", "precompression = -", "precompression = -", "at least zero"),
        ("precompressed", "precompression = ", "precompression = nan #", "precompression = NaN", "at least zero"),
        ("precompressed", "precompression = ", "precompression = -0.0 #", "precompression = -0", "at least zero"),
        ("trivial-breather", "decay = 4.0", "decay = \"4\"", "line 15: `initial.decay`", "expected a number"),
        ("trivial-breather", "decay = 4.0", "decay = -0.0", "decay = -0", "finite and positive"),
        (
            "trivial-breather",
            "amplitude = 0.1",
            "amplitude = 1e400",
            "line 14: `initial.amplitude`",
            "larger than any double",
        ),
        ("trivial-breather", "gap = 1e-3", "gap = -0.0", "gap = -0", "finite and at least zero"),
        ("trivial-breather", "gap = 1e-3", "gap = 1e308", "b", "finite"),
        ("trivial-breather", "gap = 1e-3", "d = [0.1, nan]", "d = 2 numbers", "as many offsets as amplitudes"),
        ("bright-breather", "epsilon = ", "epsilon = -", "epsilon = -", "finite and positive"),
        ("bright-breather", "center = \"bond\"", "center = \"bead\"", "`initial.center`", "unknown variant `bead`"),
        ("bright-breather", "center = \"bond\"", "center = 1\ncenter = 1", "`center = 1`", "duplicate key"),
        ("bright-envelope", "band = 2", "band = 3", "band = 3", "two with moving resonators"),
        ("bright-envelope", "amplitude = 0.1", "amplitude = 1e300", "amplitude = 1e300", "from one site"),
        ("bright-envelope", "band = 2", "band = 2\ncenter = 400", "center = 400", "a place in the chain"),
        ("bright-envelope", "amplitude = 0.1", "amplitude = -0.1", "amplitude = -0.1", "finite and positive"),
        ("bright-envelope", "q_over_pi = 0.3", "q_over_pi = 0.301", "q_over_pi = 0.301", "a whole number of waves"),
        ("bright-envelope", "q_over_pi = 0.3", "q_over_pi = 0.7", "q_over_pi = 0.7", "waves and a half"),
        (
            "bright-envelope",
            "precompression = 1.0",
            "precompression = 0.0",
            "initial.kind = envelope",
            "contacts under a static load",
        ),
        ("impact", "site = ", "site = 1000000000000000000 #", "site = 1000000000000000000", "a site of the chain"),
        ("impact", "velocity = ", "velocity = nan #", "velocity = NaN", "a finite number"),
        ("dimer", "[1.0, 0.3428]", "[1.0, -0.3428]", "beads.mass = -0.3428", "finite and positive"),
        (
            "dimer",
            "{ pattern = [1.0, 0.3428], repeat = true }",
            "[1.0, 2.0]",
            "line 10: `beads.mass`",
            "one number for each site",
        ),
        ("taper", "taper = 0.97", "tapered = 0.97", "`tapered`", "did you mean `taper`?"),
        ("taper", "taper = 0.97", "taper = 0.97, value = 1.0", "beads.mass", "exactly one of"),
        ("disorder", "\"uniform\"", "\"gauss\"", "beads.mass = gauss", "`random` is \"uniform\""),
        ("impurity", "[30, 0.1]", "[61, 0.1]", "beads.mass = 61 of 61", "within the list"),
        ("end-driven", "ramp = 20.0", "ramp = 200.0", "drive.ramp = until t = 200", "within the scene"),
        ("end-driven", "site = 21", "site = 22", "drive.site = 22", "a site of the chain"),
        ("end-driven", "amplitude = 0.2", "amplitude = inf", "drive.amplitude = inf", "a finite number"),
        ("end-driven", "kind = \"moved\"", "kind = \"pulled\"", "`pulled`", "`moved`"),
        ("granular-crystal", "poisson = 0.3", "poisson = 0.7", "units.poisson = 0.7", "at most 1/2"),
        ("granular-crystal", "radius = 9.525e-3", "radius = 0.0", "units.radius = 0", "positive; inf for a flat body"),
        ("tw-q15", "sites = 50", "sites = 51", "q_over_pi = 0.2", "a whole number of waves fits the ring"),
        ("tw-q15", "rho = 0.3333333333333333", "rho = inf", "rho = inf", "travelling waves need resonators"),
        ("tw-q15", "rho = 0.3333333333333333", "rho = 1e-310", "rho = 1e-310", "rho = 0 leaves the resonators out"),
        ("tw-q15", "b = 1.0", "b = 2.5", "b = 2.5", "below 2 kappa a"),
        ("tw-q15", "\"strain-ring\"", "\"ring\"", "`chain.boundary`", "lives on a strain-ring"),
        (
            "tw-q15",
            "detuning = 0.001",
            "detuning = 0.001\nepsilon = 0.1",
            "",
            "exactly one of `epsilon` and `detuning`",
        ),
        ("tw-q15", "periods = 100", "periods = 100\nuntil = 3.0", "", "exactly one of `periods` and `until`"),
        ("tw-q15", "periods = 100", "periods = 100\nperiod = 2.0", "", "a frequency of its own"),
    ];
    for (scene, from, to, key, rule) in cases {
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
        (text.replace("400", &"4".repeat(100_000)).into_bytes(), "line 23: `record.samples`"),
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
        at_once("a device", || LongRun::load(path)).map(|_| ()),
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

#[test]
fn numbers_that_no_flag_can_take_are_refused_by_every_command_at_once() {
    let orbit = "tests/golden/orbit.npz";
    let commands: &[(&[&str], &[&str], &[&str])] = &[
        // The command; flags that take a finite positive number; flags that take a count.
        (&["run", "tw-q15"], &["--until", "--step", "--steps-per-period", "--tol", "--windows-per-period"], &[]),
        (&["compare", "tw-q15"], &["--max-time"], &[]),
        (&["study", "order"], &["--alpha"], &["--beads"]),
        (&["study", "drift"], &["--periods"], &["--samples"]),
        (&["wave", "tw-q15"], &["--until", "--tol"], &["--samples-per-period", "--seeds"]),
        (
            &["breather", "bright"],
            &["--until", "--tol", "--epsilon", "--alpha", "--kappa", "--rho"],
            &["--sites", "--samples-per-period"],
        ),
        (&["study", "theorem"], &["--alpha", "--horizon", "--epsilons"], &["--sites"]),
        (&["study", "lifetimes"], &["--until", "--alpha", "--epsilons", "--rhos"], &["--sites"]),
        (&["breather", "dark"], &["--omega-b", "--alpha", "--kappa", "--rho", "--tol"], &["--sites"]),
        (
            &["breather", "continue"],
            &["--from", "--to", "--step", "--alpha", "--kappa", "--rho", "--tol"],
            &["--sites"],
        ),
        (
            &["breather", "doubled"],
            &["--omega-b", "--most", "--step", "--alpha", "--kappa", "--rho", "--tol"],
            &["--sites"],
        ),
        (&["breather", "evolve", orbit], &["--until", "--tol"], &[]),
        (&["orbit", "driven"], &["--omega"], &["--turns"]),
        (&["orbit", "mode", "--to", "0.1"], &["--step"], &["--linear-mode"]),
        (&["orbit", "continue", "granular-crystal", "--to", "1e-7"], &["--step"], &["--turns", "--settle"]),
        (&["dps", "integrals", "--b", "0", "--r", "1"], &["--alpha", "--kappa"], &[]),
        (&["dps", "homoclinic"], &["--alpha"], &[]),
        (&["dps", "dark"], &["--alpha", "--kappa", "--rho", "--omega-b"], &["--sites"]),
        (&["wave", "modulation"], &["--alpha", "--kappa", "--rho", "--a", "--epsilon"], &["--sites"]),
    ];
    let mut bad = Vec::new();
    for (command, numbers, counts) in commands {
        for (flags, values) in [
            (numbers, &["1e400", "1e-400", "nan", "-0", "-1", "one"][..]),
            (counts, &["1e18", "1000000000000000000", "4294967296", "-1", "-0", "nan"]),
        ] {
            for flag in *flags {
                for value in values {
                    let line = [*command, &[*flag, *value]].concat();
                    let output = at_once(&line.join(" "), || hertzchain(&line));
                    let text = String::from_utf8(output.stderr).unwrap();
                    // A panic has the exit code 101, a killed process has none.
                    assert!(matches!(output.status.code(), Some(1 | 2)), "{line:?}: {:?}\n{text}", output.status);
                    assert!(output.stdout.is_empty() && text.starts_with("error: "), "{line:?}: {text}");
                    let name = flag.trim_start_matches('-');
                    // In messages of the library a flag is a key, of many values one is named, and
                    // a branch begins at an omega_b.
                    let names = [
                        name,
                        &name.replace('-', "_"),
                        name.trim_end_matches('s'),
                        if name == "from" { "omega_b" } else { name },
                    ];
                    if !names.iter().any(|name| text.contains(name)) {
                        bad.push(format!("{command:?} {flag} {value}: {text}"));
                    }
                }
            }
        }
    }
    assert!(bad.is_empty(), "{}", bad.concat());
}

/// The keys or values that the reader of scenes lists when it refuses `zzz` in a text.
fn known(text: &str) -> Vec<String> {
    listed(text, &SceneFile::parse(text, "scene.toml").unwrap_err().to_string())
}

/// The same of the reader of plans.
fn known_of_plans(text: &str) -> Vec<String> {
    listed(text, &Plan::parse(text, Path::new("plan.toml")).unwrap_err().to_string())
}

fn listed(text: &str, message: &str) -> Vec<String> {
    let (found, listed) = message.split_once("`zzz`, expected ").unwrap_or_else(|| panic!("{text}: {message}"));
    assert!(found.ends_with("unknown field ") || found.ends_with("unknown variant "), "{text}: {message}");
    listed.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

#[test]
fn the_dictionary_of_the_fuzz_target_has_every_key_of_a_scene() {
    // Truth: what the reader says that it knows. A key of one letter needs no dictionary.
    let dictionary = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/scene.dict")).unwrap();
    let has = |word: &str| dictionary.lines().any(|line| line == format!("\"{word}\""));
    let sections = known("zzz = 1");
    assert!(sections.len() > 8, "{sections:?}");
    let mut keys = Vec::new();
    for section in &sections {
        let head = if section == "drive" { format!("[[{section}]]") } else { format!("[{section}]") };
        match section.as_str() {
            "name" | "summary" => keys.push(section.clone()),
            "initial" => {
                for kind in known("[initial]\nkind = \"zzz\"") {
                    keys.extend(known(&format!("[initial]\nkind = \"{kind}\"\nzzz = 1")));
                    assert!(has(&format!("\\\"{kind}\\\"")), "fuzz/scene.dict lacks the kind {kind}");
                }
            }
            _ => keys.extend(known(&format!("{head}\nzzz = 1"))),
        }
        assert!(section == "name" || section == "summary" || has(&head), "fuzz/scene.dict lacks {head}");
    }
    keys.extend(known("[beads]\nmass = { zzz = 1 }"));
    for (key, values) in
        [("boundary", known("[chain]\nboundary = \"zzz\"")), ("kind", known("[[drive]]\nkind = \"zzz\""))]
    {
        keys.push(key.to_owned());
        for value in values {
            assert!(has(&format!("\\\"{value}\\\"")), "fuzz/scene.dict lacks the value {value}");
        }
    }
    assert!(keys.len() > 50, "{keys:?}");
    for key in keys.iter().filter(|key| key.len() > 1) {
        assert!(has(key), "fuzz/scene.dict lacks the key {key}");
    }
    let dictionary = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/plan.dict")).unwrap();
    let axis = known_of_plans("scene = \"impact\"\n[[axis]]\nzzz = 1");
    assert!(axis.len() > 7, "{axis:?}");
    for key in known_of_plans("zzz = 1").into_iter().chain(axis) {
        assert!(dictionary.lines().any(|line| line == format!("\"{key}\"")), "fuzz/plan.dict lacks the key {key}");
    }
}
