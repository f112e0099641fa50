//! Long runs: legs and checkpoints, the same bits after an interruption, real kills, signals, disks
//! that are full, and what stops a run.

use hertzchain::{
    Error,
    chain::{Contact, Envelope},
    interrupt::Token,
    orbits::DrivenContinuation,
    output::{Archive, Array, Folder, npz_with},
    run::method::{Method, Setting},
    run::{Records, Trajectory},
    scene::{Quantity, Scene},
    study::{LongRun, MethodChoice, MethodRequest, load_branch},
};
use std::{
    fs,
    panic::{AssertUnwindSafe, catch_unwind},
};

fn cradle() -> Scene {
    Scene::load("cradle").unwrap().until(16.0).unwrap()
}

fn long(method: &str, setting: Setting, interval: f64) -> LongRun {
    LongRun::new(cradle(), Method::named(method).unwrap(), setting, "words".to_owned(), interval, None).unwrap()
}

fn same(a: &Trajectory, b: &Trajectory) -> bool {
    (a.t, &a.state, &a.samples, &a.profiles, &a.contacts) == (b.t, &b.state, &b.samples, &b.profiles, &b.contacts)
        && (a.energy_error, a.stats) == (b.energy_error, b.stats)
}

/// Truth: the run that nobody stops. What the first leg leaves is written, read and gone on from.
#[test]
fn scenes_go_on_from_their_checkpoints_by_every_method() {
    goes_on(&["tw-q15", "taper"], 1);
}

#[test]
#[ignore = "nightly: minutes"]
fn every_scene_goes_on_from_its_checkpoint_by_every_method() {
    goes_on(&Scene::list().into_iter().map(|(name, _)| name).collect::<Vec<_>>(), 3);
}

/// One of `every` runs.
fn goes_on(scenes: &[&str], every: usize) {
    let folder = tempfile::tempdir().unwrap();
    let folder = Folder::create(folder.path()).unwrap();
    let all = "record.quantities=[\"u\",\"u_dot\",\"momentum\",\"energy\",\"sensor\",\"force\",\"overlap\"]";
    let (mut runs, mut logged) = (0, 0);
    for (s, name) in scenes.iter().enumerate() {
        let plain = Scene::load(name).unwrap();
        let until = plain.end().min(3.0 * plain.run().fast_period());
        // A ramp must have ended.
        let drives = plain.chain().details().map(|details| details.drives.clone()).unwrap_or_default();
        let ramps = drives.iter().enumerate().filter(|(_, drive)| matches!(drive.signal.envelope, Envelope::Ramp(_)));
        let short = plain.in_file(Quantity::Time, 0.5 * until);
        let ramps: Vec<_> = ramps.map(|(k, _)| format!("drive.{k}.ramp={short:?}")).collect();
        let plain = Scene::load_with(name, &ramps).unwrap();
        let changes = ["record.samples=5", all].map(str::to_owned);
        let named = Scene::load_with(name, &[&ramps[..], &changes].concat()).ok();
        let methods = Method::all().into_iter().filter(|method| method.runs(plain.chain()).is_ok());
        for (m, method) in methods.enumerate() {
            let asked = MethodRequest { integrator: Some(method.name()), ..MethodRequest::default() };
            let windows = MethodRequest { windows_per_period: Some(60.0), nodes: Some(8), ..asked.clone() };
            let windows = (method == Method::Collocation).then_some((windows, &plain));
            let both = [Some(&plain), named.as_ref()].into_iter().flatten().map(|scene| (asked.clone(), scene));
            for (_, (asked, scene)) in both.chain(windows).enumerate().filter(|(k, _)| (s + m + k) % every == 0) {
                let scene = scene.clone().until(until).unwrap();
                let how = MethodChoice::new(&asked, &scene).unwrap();
                let interval = scene.in_file(Quantity::Time, 0.4 * scene.end());
                let begun = how.in_legs(scene, true, interval, None).unwrap();
                let whole = begun.clone().run(&folder, &mut |_| ()).unwrap();
                let token = Token::new();
                let after = |t: f64| {
                    if t > 0.5 * whole.t {
                        token.ask()
                    }
                };
                let stopped = token.within(|| begun.run(&folder, &mut |t| after(t)).unwrap());
                assert!(stopped.failure.is_some(), "{name} {method:?}");
                let resumed = LongRun::load(folder.path(), None).and_then(|kept| kept.run(&folder, &mut |_| ()));
                let resumed = resumed.unwrap_or_else(|why| panic!("{name} {}: {why}", method.name()));
                assert!(same(&whole, &resumed) && whole.extremes == resumed.extremes, "{name} {}", method.name());
                let again =
                    LongRun::load(folder.path(), None).unwrap().run(&folder, &mut |_| panic!("nothing is left to run"));
                assert!(same(&whole, &again.unwrap()), "{name} {}", method.name());
                runs += 1;
                logged += whole.contacts.map_or(0, |contacts| contacts.len());
            }
        }
    }
    println!("{runs} runs, {logged} contacts");
    assert!(every * runs > 30 * scenes.len() && logged > 30 * scenes.len());
}

/// Truth: the same run in one leg. Contacts at the front of the wave, whose overlaps are roundings
/// of the others, count as none.
#[test]
fn contacts_are_joined_over_legs() {
    let scene = cradle();
    // Measured: half of this; times of contacts that are 1e-7 and smaller.
    for (name, setting, bound) in [
        ("strang-linear", Setting::Steps(3200), 6e-12),
        ("dop853-regularised", Setting::Tolerance(1e-12), 8e-9),
        ("collocation", Setting::Tolerance(1e-12), 3e-8),
    ] {
        let felt = |contacts: Option<Vec<Contact>>| {
            contacts.unwrap().into_iter().filter(|contact| contact.largest_overlap > 1e-9).collect::<Vec<_>>()
        };
        let method = Method::named(name).unwrap();
        let whole = felt(
            scene.run().method(method).setting(setting).records(Records::End).contacts().start().unwrap().contacts,
        );
        let mut worst = 0.0_f64;
        let over = |t: f64| whole.iter().any(|contact| contact.onset < Some(t) && contact.release > Some(t));
        assert!(over(8.0) && whole.len() > 12, "contacts go on over the end of a leg");
        for interval in [2.0, 0.1] {
            let folder = tempfile::tempdir().unwrap();
            let folder = Folder::create(folder.path()).unwrap();
            let begun = long(name, setting, interval).with_contacts();
            let broken = AssertUnwindSafe(|| begun.run(&folder, &mut |t| assert!(t < 7.0, "enough")));
            assert!(catch_unwind(broken).is_err());
            let resumed = LongRun::load(folder.path(), None).unwrap();
            assert!(resumed.has_contacts());
            let contacts = felt(resumed.run(&folder, &mut |_| ()).unwrap().contacts);
            assert_eq!(contacts.len(), whole.len(), "{name}, legs of {interval}");
            for (a, b) in whole.iter().zip(&contacts) {
                assert_eq!((a.bond, a.release.is_some()), (b.bond, b.release.is_some()));
                let (numbers, others) = (a.numbers(), b.numbers());
                let error = numbers.iter().zip(others).filter(|(x, _)| !x.is_nan()).map(|(x, y)| (x - y).abs());
                let error = error.fold(0.0, f64::max);
                worst = worst.max(error);
                assert!(error < bound, "{name}, legs of {interval}: {a:?} {b:?}");
            }
        }
        println!("{name}: {worst:.1e}");
    }
}

/// Truth: the same scene without legs, by another method.
#[test]
fn legs_cost_no_accuracy() {
    let scene = cradle();
    let reference = scene
        .run()
        .method(Method::named("dop853-regularised").unwrap())
        .setting(Setting::Tolerance(1e-13))
        .records(Records::End)
        .start();
    let reference = reference.unwrap().state;
    let folder = tempfile::tempdir().unwrap();
    let folder = Folder::create(folder.path()).unwrap();
    // Measured: 1.4e-13 and 2.3e-12, with one leg as with 54.
    for (name, setting, bound) in
        [("collocation", Setting::Tolerance(1e-10), 3e-13), ("dop853-regularised", Setting::Tolerance(1e-12), 5e-12)]
    {
        let end = |interval: f64| long(name, setting, interval).run(&folder, &mut |_| ()).unwrap().state;
        let error = |y: Vec<f64>| y.iter().zip(&reference).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let errors = [16.0, 2.1, 0.3].map(|interval| error(end(interval)));
        println!("{name}: {errors:?}");
        assert!(errors.iter().all(|error| *error < bound), "{name}: {errors:?}");
    }
}

#[test]
fn a_checkpoint_that_is_not_its_own_is_refused_with_file_key_and_rule() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("checkpoint.npz");
    let setting = Setting::Tolerance(1e-6);
    long("dop853", setting, 4.0).run(&Folder::create(folder.path()).unwrap(), &mut |_| ()).unwrap();
    let written = fs::read(&path).unwrap();
    let kept = LongRun::load(&path, None).unwrap();
    let text = Archive::read(&path).unwrap().text("settings.json").unwrap().to_owned();
    let refusal = |error: Error| {
        assert!(matches!(error, Error::Content { .. }), "{error}");
        error.to_string()
    };
    let other = Scene::load("impact").unwrap();
    assert!(kept.is(&path, Some(&Scene::load("cradle").unwrap()), Some(Method::named("dop853").unwrap())).is_ok());
    assert!(
        refusal(kept.is(&path, Some(&other), None).unwrap_err())
            .contains("settings.json, scene: cradle there and impact here")
    );
    let method = Method::named("verlet").unwrap();
    assert!(
        refusal(kept.is(&path, None, Some(method)).unwrap_err()).contains("integrator: dop853 there and verlet here")
    );
    for (from, to, key, rule) in [
        ("\"version\": 6", "\"version\": 3", "", "read is hertzchain checkpoint, version 6"),
        ("hertzchain checkpoint", "hertzchain branch", "", "hertzchain branch, version 6"),
        ("\"hertzchain 0", "\"hertzchain 99", "program", "only the same program"),
        // Found by fuzzing: lines that a file brings along are not those of a message.
        ("\"hertzchain 0", "\"two\\nlines 0", "program", "only the same program"),
        ("\"dop853\"", "\"dop854\"", "integrator", "unknown integrator"),
        ("\"legs\": 4", "\"legs\": 5", "legs", "5 of 4"),
        ("\"legs\": 4", "\"legs\": 0", "legs", "0 of 4"),
        ("\"legs\": 4", "\"legs\": 3", "t", "16 after 3 legs"),
        ("\"interval\": 4", "\"interval\": -4", "setting", "checkpoint = -4"),
        ("\"interval\": 4", "\"more\": 1, \"interval\": 4", "", "unknown field `more`"),
        ("\"taken\": ", "\"taken\": 1", "samples", "kept"),
        ("sites = 20", "sites = 0", "scene", "sites = 0"),
    ] {
        assert!(text.contains(from), "{from}: {text}");
        fs::write(&path, npz_with("settings.json", &text.replace(from, to), &[]).unwrap()).unwrap();
        let message = LongRun::load(&path, None).map(|_| ()).unwrap_err().to_string();
        assert_eq!(message.lines().count(), 1, "{message}");
        let key_of_settings = if key.is_empty() { String::new() } else { format!(", {key}") };
        let place = format!("{}, settings.json{key_of_settings}: ", path.display());
        // Without arrays what comes after the settings is missing.
        let arrays = ["samples", "legs", "t"].contains(&key);
        assert!(
            message.starts_with(&place) && message.contains(rule) || arrays && message.contains("missing"),
            "{message}"
        );
    }
    for cut in [0, 3, written.len() / 2, written.len() - 1] {
        fs::write(&path, &written[..cut]).unwrap();
        assert!(refusal(LongRun::load(&path, None).map(|_| ()).unwrap_err()).contains("archive: not an NPZ file"));
    }
    for interval in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9] {
        let new = LongRun::new(cradle(), Method::named("dop853").unwrap(), setting, String::new(), interval, None);
        assert!(new.unwrap_err().to_string().starts_with("checkpoint = "));
    }
}

#[test]
fn a_record_that_no_run_has_is_refused_also_at_the_end_of_a_run() {
    // Truth: what each array is: times of samples, energies of states, times of contacts.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("checkpoint.npz");
    let run = long("collocation", Setting::Tolerance(1e-6), 4.0).with_contacts();
    let outcome = run.run(&Folder::create(folder.path()).unwrap(), &mut |_| ()).unwrap();
    let file = Archive::read(&path).unwrap();
    let text = file.text("settings.json").unwrap().to_owned();
    let settings: serde_json::Value = serde_json::from_str(&text).unwrap();
    let count = |name: &str| settings[name].as_u64().unwrap();
    let dim = outcome.state.len() as u64;
    let shapes: [(&str, Vec<u64>); 9] = [
        ("state", vec![dim]),
        ("largest", vec![1]),
        ("sample_t", vec![count("samples")]),
        ("energies", vec![4 * count("samples")]),
        ("profile_t", vec![count("profiles")]),
        ("profiles", vec![count("profiles"), dim]),
        ("contacts", vec![count("contacts"), Contact::NUMBERS as u64]),
        ("open_contacts", vec![count("open_contacts")]),
        ("extremes", vec![0, 2]),
    ];
    let altered = |which: &str, k: usize, value: f64| {
        let array = |(name, shape): &(&'static str, Vec<u64>)| {
            let mut values = file.array(name, shape).unwrap();
            if *name == which {
                values[k] = value;
            }
            Array { name, shape: shape.clone(), values }
        };
        let arrays: Vec<_> = shapes.iter().map(array).collect();
        fs::write(&path, npz_with("settings.json", &text, &arrays).unwrap()).unwrap();
        LongRun::load(&path, None).map(|_| ()).map_err(|error| error.to_string())
    };
    assert!(count("contacts") > 3 && altered("", 0, 0.0).is_ok());
    for (name, k, value, place, rule) in [
        ("state", 0, 1e9, "largest", "an energy is off by"),
        ("largest", 0, -1.0, "largest", "-1: an energy is off by"),
        ("sample_t", 3, 1e9, "sample_t", "at entry 3: that sample is at"),
        ("sample_t", 0, -1.0, "sample_t", "-1 at entry 0: that sample is at 0"),
        ("energies", 5, 1e9, "energies", "row 1: not the energy of the state at"),
        ("profile_t", 2, 0.0, "profile_t", "0 at entry 2: each is the time of a sample"),
        ("profiles", 7, 1e9, "energies", "row 0: not the energy of the state at 0"),
        ("contacts", 1, 1e9, "contacts", "row 0: times are from 0 to that of the checkpoint"),
        ("contacts", Contact::NUMBERS + 7, -1.0, "contacts", "row 1: times are from 0"),
    ] {
        let message = altered(name, k, value).expect_err(name);
        assert!(message.contains(&format!(", {place}: ")) && message.contains(rule), "{name}: {message}");
    }
}

#[cfg(unix)]
mod processes {
    use super::*;
    use crate::help::{commands, help};
    use crate::numbers::random;
    use crate::program::{PROGRAM, command, files, hertzchain, limited, lines, read_json, refused, stdout};
    use serde_json::Value;
    use std::{
        io::{BufRead, BufReader},
        path::Path,
        process::{Child, Command, Stdio},
        thread::sleep,
        time::{Duration, Instant},
    };

    fn quiet(line: &str) -> Command {
        let mut command = command(line);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command
    }

    /// Kills a command at random moments, as often as that hits, and goes on, by its end with the
    /// files of one that nobody kills: nothing that was kept is lost. `kept`: how much of its work
    /// is in the file from which another command resumes.
    fn survives(
        line: &str,
        (resume, file): (&str, &str),
        kept: &dyn Fn(&Path) -> Option<f64>,
        kills: usize,
        random: &mut impl FnMut() -> f64,
    ) {
        let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
        let [whole, killed] = folders.each_ref().map(|folder| folder.path());
        let begin = |out: &Path| quiet(&format!("{line} --out {}", out.display()));
        let go_on = |out: &Path| match kept(out) {
            Some(_) => quiet(&format!("{resume} --resume {}", out.join(file).display())),
            None => begin(out),
        };
        let clock = Instant::now();
        assert!(begin(whole).status().unwrap().success());
        let (span, end) = (clock.elapsed(), kept(whole).unwrap());
        let (mut hits, mut before) = (0, None);
        while hits < kills {
            let mut process = go_on(killed).spawn().unwrap();
            // The last one well before the end.
            let target = 0.8 * end * (hits as f64 + random()) / kills as f64;
            while kept(killed).unwrap_or(0.0) < target && process.try_wait().unwrap().is_none() {
                sleep(Duration::from_millis(3));
            }
            sleep(span.mul_f64(0.1 * random()));
            let _ = process.kill();
            if process.wait().unwrap().success() {
                assert!(files(whole) == files(killed), "{line}");
                // Killed too late: once more from the start.
                fs::remove_dir_all(killed).unwrap();
                before = None;
                continue;
            }
            hits += 1;
            let now = kept(killed);
            assert!(now >= before, "{line}: {now:?} after {before:?}");
            before = now;
        }
        assert!(go_on(killed).status().unwrap().success() && files(whole) == files(killed), "{line}");
    }

    fn time(out: &Path) -> Option<f64> {
        let path = out.join("checkpoint.npz");
        path.exists().then(|| LongRun::load(&path, None).expect("a checkpoint is whole at any moment").time())
    }

    fn points(out: &Path) -> Option<f64> {
        let path = out.join("branch.npz");
        path.exists().then(|| {
            hertzchain::orbits::Branch::load(&path).expect("a branch is whole at any moment").orbits.len() as f64
        })
    }

    fn driven_points(out: &Path) -> Option<f64> {
        let path = out.join("driven-branch.npz");
        path.exists().then(|| {
            let (_, trail) = load_branch::<DrivenContinuation>(&path).expect("a branch is whole at any moment");
            trail.orbits.len() as f64
        })
    }

    #[test]
    fn kills_at_random_moments_lose_nothing_that_was_kept() {
        let mut random = random(1);
        let line = "run tw-q15 --until 12 --checkpoint 0.75 --tol 1e-9";
        survives(line, ("run", "checkpoint.npz"), &time, 9, &mut random);
        let line =
            "breather continue --center bond --sites 5 --from 2.01 --to 2.02 --step 2.5e-4 --bifurcations --weak 1";
        survives(line, ("breather continue --bifurcations", "branch.npz"), &points, 6, &mut random);
        let four = "--set chain.sites=4 --set initial.site=1";
        let line = format!("orbit continue granular-crystal {four} --settle 20 --to 2e-8 --step 2e-10");
        survives(&line, ("orbit continue", "driven-branch.npz"), &driven_points, 4, &mut random);
    }

    fn signal(process: &Child, name: &str) {
        let kill = format!("kill -{name} {}", process.id());
        assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    }

    /// Asks a command to end as soon as it has kept something: exit code and what it said.
    fn asked(line: &str, name: &str, kept: &dyn Fn() -> bool) -> (Option<i32>, String) {
        let (code, _, said) = asked_and_heard(line, name, kept);
        (code, said)
    }

    /// The same, with what it printed in between.
    fn asked_and_heard(line: &str, name: &str, kept: &dyn Fn() -> bool) -> (Option<i32>, String, String) {
        let mut command = command(line);
        // One thread: not all points are done at once.
        command.env("RAYON_NUM_THREADS", "1");
        let process = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let clock = Instant::now();
        while !kept() {
            assert!(clock.elapsed() < Duration::from_secs(60), "{line}");
            sleep(Duration::from_millis(2));
        }
        signal(&process, name);
        let output = process.wait_with_output().unwrap();
        let [printed, said] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        (output.status.code(), printed, said)
    }

    /// Truth: 4e9 units of time are 6e11 steps of the default length.
    #[test]
    fn a_run_of_days_says_so_before_its_first_step() {
        let line = "run impact --integrator strang-linear --until 4e9 --samples 0";
        let mut process = command(line).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let mut said = BufReader::new(process.stderr.take().unwrap()).lines().map(Result::unwrap).take(3);
        let told = said.any(|line| line.contains("this run makes about 6.2e11 steps and takes about"));
        process.kill().unwrap();
        process.wait().unwrap();
        assert!(told);
    }

    /// Command lines that take long, where OUT is a folder with a plan; names of those that do not.
    fn long_and_short() -> [Vec<&'static str>; 2] {
        let (long, short) = include_str!("../golden/long.txt").split_once("# short\n").unwrap();
        [long, short].map(|part| part.lines().filter(|line| !line.is_empty() && !line.starts_with('#')).collect())
    }

    #[test]
    fn every_command_is_known_as_long_or_as_short() {
        let all = commands();
        // Those that only have commands below them have a usage that ends so.
        let group = |help: String| help.lines().any(|line| line.starts_with("Usage: ") && line.ends_with("<COMMAND>"));
        let alone = |path: &&Vec<String>| !group(help(path, "-h"));
        let own: Vec<String> = all[1..].iter().filter(alone).map(|path| path.join(" ")).collect();
        let of = |line: &&str| own.iter().filter(|name| format!("{line} ").starts_with(&format!("{name} "))).max();
        let mut known: Vec<&String> = long_and_short().concat().iter().filter_map(of).collect();
        let mut own: Vec<&String> = own.iter().collect();
        own.sort();
        known.sort();
        known.dedup();
        assert_eq!(own, known);
    }

    /// CPU time of a process, in ticks of a hundredth of a second; `None` once it has ended.
    #[cfg(target_os = "linux")]
    fn ticks(id: u32) -> Option<u64> {
        let text = fs::read_to_string(format!("/proc/{id}/stat")).ok()?;
        let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
        (fields[0] != "Z").then_some(fields[11].parse::<u64>().ok()? + fields[12].parse::<u64>().ok()?)
    }

    /// The CPU time from SIGINT, after `first` ticks, to the end, and the exit code; `None` if the
    /// command ends by itself before the signal.
    #[cfg(target_os = "linux")]
    fn ticks_to_end(line: &str, out: &str, first: u64) -> Option<(u64, Option<i32>)> {
        let args = line.split(' ').map(|word| word.replace("OUT", out));
        let mut command = Command::new(PROGRAM);
        command.env("RAYON_NUM_THREADS", "1").args(args).stdout(Stdio::null()).stderr(Stdio::null());
        let mut process = command.spawn().unwrap();
        let before = loop {
            match ticks(process.id()) {
                None => {
                    process.wait().unwrap();
                    return None;
                }
                Some(now) if now >= first => break now,
                Some(_) => sleep(Duration::from_millis(10)),
            }
        };
        let clock = Instant::now();
        signal(&process, "INT");
        let mut last = before;
        while let Some(now) = ticks(process.id()) {
            last = now;
            if clock.elapsed() > Duration::from_secs(60) {
                process.kill().unwrap();
            }
            sleep(Duration::from_millis(5));
        }
        Some((last - before, process.wait().unwrap().code()))
    }

    /// Prints the seconds of CPU time to the end, for a signal after each of some ticks.
    #[cfg(target_os = "linux")]
    fn end_soon(lines: &[&str], after: &[u64]) {
        let folder = tempfile::tempdir().unwrap();
        let plan = "scene = \"impact\"\nkeep = [\"energy_error\"]\n\
                    axis = [{ key = \"initial.velocity\", from = 0.5, to = 1.0, count = 9000 }]\n";
        fs::write(folder.path().join("plan.toml"), plan).unwrap();
        let mut late = Vec::new();
        for line in lines {
            let ended: Vec<_> =
                after.iter().map(|&first| ticks_to_end(line, folder.path().to_str().unwrap(), first)).collect();
            let shown = ended.iter().map(|one| {
                one.map_or("ended before".to_owned(), |(ticks, _)| format!("{:.2} s", ticks as f64 / 100.0))
            });
            println!("{line:<80} {}", shown.collect::<Vec<_>>().join("  "));
            let soon =
                |one: &Option<(u64, Option<i32>)>| one.is_none_or(|(ticks, code)| ticks < 100 && code == Some(130));
            if ended[0].is_none() || !ended.iter().all(soon) {
                late.push(*line);
            }
        }
        assert!(late.is_empty(), "{late:?}");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_signal_ends_long_searches_within_a_second_of_cpu_time() {
        let lines = [
            "orbit driven dark-ends --turns 64",
            "study stability --work 1e9",
            "orbit mode precompressed --to 1",
            "paper verify",
        ];
        end_soon(&lines, &[40]);
    }

    #[test]
    #[cfg(target_os = "linux")]
    #[ignore = "nightly: all commands take minutes"]
    fn a_signal_ends_every_command_within_a_second_of_cpu_time() {
        end_soon(&long_and_short()[0], &[40, 300]);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_signal_leaves_the_points_of_a_mode_and_the_periods_of_an_orbit() {
        let told = |line: &str, enough: &dyn Fn() -> bool| {
            let (code, printed, said) = asked_and_heard(line, "INT", enough);
            assert!(code == Some(130), "{code:?} {said}");
            (serde_json::from_str::<Value>(&printed).unwrap_or_else(|why| panic!("{why}: {said}")), said)
        };
        let folder = tempfile::tempdir().unwrap();
        let scene = folder.path().join("modes.toml");
        let text = "name = \"modes\"\nchain = {sites = 8, alpha = 1.5, boundary = \"fixed\", precompression = 0.1}\n\
                    initial = {kind = \"single-bead\", site = 0}\nspan = {until = 1.0}\n";
        fs::write(&scene, text).unwrap();
        let clock = Instant::now();
        let later = || clock.elapsed() > Duration::from_millis(1500);
        let out = folder.path().join("mode");
        let mode = format!(
            "orbit mode {} --to 0.09 --step 1e-6 --max-points 90000 --json --out {}",
            scene.display(),
            out.display()
        );
        let (mode, said) = told(&mode, &later);
        assert!(mode["end"] == "stopped" && !mode["points"].as_array().unwrap().is_empty(), "{mode}");
        assert!(said.contains("the process was asked to end") && out.join("mode-branch.npz").exists(), "{said}");
        let out = folder.path().join("driven");
        let line = "orbit continue granular-crystal --settle 20 --to 2e-8 --step 2e-10 --json --out";
        let (branch, said) = told(&format!("{line} {}", out.display()), &|| out.join("driven-branch.npz").exists());
        assert!(branch["end"] == "stopped" && !branch["points"].as_array().unwrap().is_empty(), "{branch}");
        assert!(said.contains("the same command goes on") && out.join("driven-branch.csv").exists(), "{said}");
        let clock = Instant::now();
        let later = || clock.elapsed() > Duration::from_millis(700);
        let (run, _) = told("breather evolve tests/golden/orbit.npz --until 1e6 --json", &later);
        assert!(run["failure"].as_str().unwrap().starts_with("stopped by a signal at t = "), "{}", run["failure"]);
        assert!(run["e_b"].as_array().unwrap().len() > 2, "{run}");
    }

    #[test]
    fn a_run_that_blows_up_ends_with_events_as_without_them() {
        // Truth: the same run without the search for events.
        let cases = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/cases/blow-up-");
        for (method, step) in [("verlet", "0.01"), ("yoshida4", "0.1")] {
            let args = ["run", &format!("{cases}{method}.toml"), "--integrator", method, "--step", step];
            let [without, with] = [&args[..], &[&args[..], &["--events"]].concat()].map(hertzchain);
            assert!(without.status.code() == Some(1) && with.status.code() == Some(1), "{method}");
            assert!(String::from_utf8_lossy(&with.stderr).contains("not finite at t = 1 "), "{method}");
            assert_eq!(without.stderr, with.stderr, "{method}");
        }
    }

    #[test]
    fn a_signal_ends_a_run_with_what_was_done() {
        for (name, code) in [("INT", 130), ("TERM", 143)] {
            let folder = tempfile::tempdir().unwrap();
            let out = folder.path().to_str().unwrap();
            let run = "run tw-q15 --integrator strang-linear --until 60 --checkpoint 2 --steps-per-period 100000 --out";
            let kept = || time(folder.path()).is_some_and(|t| t >= 4.0);
            let (status, printed, said) = asked_and_heard(&format!("{run} {out}"), name, &kept);
            assert!(status == Some(code) && said.contains("error: stopped by a signal at t = "), "{status:?} {said}");
            assert!(printed.contains("\nstopped     by a signal at t = ") && !printed.contains("FAILED"), "{printed}");
            let summary = read_json(&folder.path().join("summary.json"));
            let (t, t_kept) = (summary["t"].as_f64().unwrap(), time(folder.path()).unwrap());
            // Past the checkpoint, by less than an interval.
            assert!(t >= t_kept && t - t_kept < 2.0 && t < 60.0, "{t} {t_kept}");
            assert!(summary["failure"].as_str().unwrap().contains("stopped by a signal"));
            let samples = fs::read_to_string(folder.path().join("energy.csv")).unwrap().lines().count();
            assert!(samples as f64 > 3.0 * t, "{samples} lines up to {t}");
            if name == "TERM" {
                let events = refused(&["run", "--resume", out, "--events"], 2);
                assert!(events.contains("begun without --events: its first contacts are not known"), "{events}");
                stdout(&["run", "--resume", out]);
                let whole = tempfile::tempdir().unwrap();
                stdout(&format!("{run} {}", whole.path().display()));
                assert!(files(folder.path()) == files(whole.path()));
            }
        }
    }

    #[test]
    fn a_signal_ends_studies_with_what_was_done() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let text = |name: &str| at(name).display().to_string();
        let store = || lines(&at("l/lifetimes.store")) >= 3;
        let line = "study lifetimes --epsilons 0.2,0.3,0.4,0.5 --rhos 5,10,20,30,40,50,60,70 --until 60 --out";
        let (code, said) = asked(&format!("{line} {}", text("l")), "TERM", &store);
        assert!(code == Some(143), "{code:?} {said}");
        let study = read_json(&at("l/lifetimes.json"));
        let rows = study["points"].as_array().unwrap();
        let missing =
            rows.iter().filter(|point| point["failure"].as_str() == Some("not computed: stopped by a signal")).count();
        assert_eq!(missing, rows.iter().filter(|point| point["fate"] == "stopped").count());
        let kept = lines(&at("l/lifetimes.store")) - 1;
        assert!(rows.len() == 32 && missing + kept == 32 && missing > 0, "{missing} missing, {kept} kept");

        let line =
            "breather continue --center bond --sites 5 --from 2.01 --to 2.06 --step 2e-4 --bifurcations --weak 1 --out";
        let (code, said) = asked(&format!("{line} {}", text("b")), "INT", &|| at("b/branch.npz").exists());
        assert!(code == Some(130) && said.contains("the process was asked to end"), "{code:?} {said}");
        // All points are kept and told, not only every twentieth.
        let told = read_json(&at("b/branch.json"));
        let count = told["points"].as_array().unwrap().len();
        assert!(told["end"] == "stopped" && count as f64 == points(&at("b")).unwrap(), "{told}");

        let store = || lines(&at("w/ensemble.store")) >= 3;
        let line = format!("wave tw-q15 --zeta 0.01 --seeds 60 --until 60 --out {}", text("w"));
        let (code, said) = asked(&line, "INT", &store);
        assert_eq!(code, Some(130), "{said}");
        let study = read_json(&at("w/wave.json"));
        let (seeds, missing) = (study["seeds"].as_array().unwrap().len(), study["missing"].as_u64().unwrap() as usize);
        // The first seed is that of the scene and is not kept; the first line of the store is its
        // head.
        assert!(seeds + missing == 60 && missing > 0 && lines(&at("w/ensemble.store")) == seeds, "{seeds}");
        assert!(said.contains(&format!("stopped by a signal: {missing} seeds of 60 were not run")), "{said}");

        // All levels take minutes.
        let line = "compare tw-q15 --integrators strang-linear,verlet --set span.periods=10000 --max-time 600 --out";
        let clock = Instant::now();
        let (code, said) = asked(&format!("{line} {}", text("c")), "INT", &|| clock.elapsed() > Duration::from_secs(1));
        assert!(code == Some(130) && clock.elapsed() < Duration::from_secs(30), "{code:?} {said}");
    }

    #[test]
    fn a_full_disk_costs_an_interval_and_says_so() {
        let (full, whole) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let line = "run tw-q15 --integrator strang-linear --until 40 --checkpoint 4 --out";
        let run = |out: &Path| format!("{line} {}", out.display());
        let refused = limited("trap '' XFSZ; ulimit -f 400", &run(full.path()));
        let said = String::from_utf8(refused.stderr).unwrap();
        assert!(refused.status.code() == Some(1) && said.contains("checkpoint.npz: File too large"), "{said}");
        let kept = time(full.path()).unwrap();
        assert!(kept > 4.0 && kept < 40.0 && fs::read_dir(full.path()).unwrap().count() == 1, "{kept}");
        stdout(&["run", "--resume", full.path().to_str().unwrap()]);
        stdout(&run(whole.path()));
        assert!(files(full.path()) == files(whole.path()));

        // A store drops what of a line found place.
        let (full, whole) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let line = "study theorem --epsilons 0.3,0.25,0.2,0.15,0.1,0.07,0.05,0.03,0.02,0.01 --horizon 0.1 --out";
        let run = |out: &Path| format!("{line} {}", out.display());
        let refused = limited("trap '' XFSZ; ulimit -f 2", &run(full.path()));
        let said = String::from_utf8(refused.stderr).unwrap();
        assert!(refused.status.code() == Some(1) && said.contains("theorem.store: File too large"), "{said}");
        let store = fs::read(full.path().join("theorem.store")).unwrap();
        assert!(store.ends_with(b"\n") && store.len() <= 2048, "{} bytes", store.len());
        stdout(&run(full.path()));
        stdout(&run(whole.path()));
        assert!(files(full.path()) == files(whole.path()));
    }

    #[test]
    fn folders_that_cannot_be_written_are_refused_before_the_work() {
        use std::os::unix::{fs::PermissionsExt, process::CommandExt};
        let folder = tempfile::tempdir().unwrap();
        let closed = folder.path().join("closed");
        fs::create_dir(&closed).unwrap();
        fs::set_permissions(&closed, fs::Permissions::from_mode(0o555)).unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let mut cases = vec![(file.clone(), "file: "), (file.join("below"), "below: ")];
        // Root writes everywhere, but may run the program as somebody who does not.
        let root = fs::write(closed.join("try"), "").is_ok();
        fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).unwrap();
        let somebody = |args: &[&str]| {
            let mut command = command(args);
            if root { command.uid(65534).gid(65534).output() } else { command.output() }
        };
        if somebody(&["--version"]).is_ok() {
            cases.push((closed, "closed: Permission denied"));
        } else {
            println!("SKIPPED: the folder without permission to write, as nobody but root may run {PROGRAM}");
        }
        for (out, what) in cases {
            let out = out.to_str().unwrap();
            for args in [
                &["run", "tw-q15", "--checkpoint", "1", "--integrator", "verlet"][..],
                &["compare", "tw-q15"],
                &["study", "theorem"],
                &["study", "drift"],
                &["breather", "continue"],
            ] {
                let args = [args, &["--out", out]].concat();
                let refused = if what.contains("denied") { somebody(&args).unwrap() } else { hertzchain(&args) };
                let said = String::from_utf8(refused.stderr).unwrap();
                assert!(refused.status.code() == Some(1) && said.contains(what) && refused.stdout.is_empty(), "{said}");
            }
        }
        assert_eq!(fs::read(&file).unwrap(), b"", "what is in the way stays");
        // Leftovers of a killed process go, those of one that lives stay.
        let left = folder.path().join(".hertzchain-left");
        let held = folder.path().join(".hertzchain-held");
        fs::write(&left, "half").unwrap();
        let lock = fs::File::create(&held).unwrap();
        lock.lock().unwrap();
        Folder::create(folder.path()).unwrap();
        assert!(!left.exists() && held.exists());
    }

    const SCENE: &str = "name = \"guards\"\n[chain]\nsites = 5\nalpha = 1.5\nkappa = 1.0\nrho = 1.0\nboundary = \"fixed\"\n\
        [initial]\nkind = \"single-bead\"\nsite = 2\ndisplacement = 1.0\n[span]\nuntil = 10.0\n[record]\nsamples = 10\n";

    /// Runs that scene with another displacement: exit code, what it said, and the lines of
    /// energy.csv.
    fn guarded(displacement: &str, how: &[&str]) -> (Option<i32>, String, Option<usize>) {
        let folder = tempfile::tempdir().unwrap();
        let (scene, out) = (folder.path().join("scene.toml"), folder.path().join("out"));
        fs::write(&scene, SCENE.replace("1.0\n[span]", &format!("{displacement}\n[span]"))).unwrap();
        let output = hertzchain(&[&["run", scene.to_str().unwrap(), "--out", out.to_str().unwrap()], how].concat());
        let energies = out.join("energy.csv").exists().then(|| lines(&out.join("energy.csv")) - 1);
        (output.status.code(), String::from_utf8(output.stderr).unwrap(), energies)
    }

    #[test]
    fn guards_stop_a_run_with_time_step_and_site_and_keep_what_there_is() {
        for (displacement, how, words) in [
            (
                "1e100",
                &["--integrator", "verlet", "--steps-per-period", "512"][..],
                &["not finite at t = 1 ", "step 116", "steps of 8.67", "u of site 0"][..],
            ),
            ("1e100", &["--tol", "1e-6"], &["did not settle at t = ", "window ", "the bond to the left of site "]),
            (
                "1.0",
                &["--integrator", "verlet", "--steps-per-period", "1"],
                &["unstable: energy went from 9e-1", "by t = 1 ", "steps of 3.33", "u' of site 2"],
            ),
        ] {
            let (code, said, energies) = guarded(displacement, how);
            assert!(code == Some(1) && words.iter().all(|word| said.contains(word)), "{code:?} {said}");
            assert_eq!(energies, Some(1), "the samples so far: {said}");
        }
        for (displacement, rule) in [
            ("1e-200", "displacement = 1e-200 is not valid: underflow"),
            ("1e200", "displacement = 1e200 is not valid: overflow"),
        ] {
            for how in [
                &["--integrator", "verlet"][..],
                &["--integrator", "strang-linear"],
                &["--integrator", "dop853"],
                &["--tol", "1e-6"],
            ] {
                let (code, said, energies) = guarded(displacement, how);
                assert!(code == Some(2) && said.contains(rule) && energies.is_none(), "{code:?} {said}");
            }
        }
        // Soft contacts of slow beads are stiff: alpha = 1/2, a blow at t = 1 that takes 1e-15.
        let folder = tempfile::tempdir().unwrap();
        let [scene, out] = ["scene.toml", "out"].map(|name| folder.path().join(name).display().to_string());
        let soft = "name = \"soft\"\n[chain]\nsites = 2\nalpha = 0.5\nboundary = \"free\"\n[bonds]\noverlap = -1e-45\n\
            [initial]\nkind = \"single-bead\"\nsite = 0\nvelocity = 1e-45\n[span]\nuntil = 10.0\n";
        fs::write(&scene, soft).unwrap();
        let ended = hertzchain(&["run", &scene, "--integrator", "dop853", "--tol", "1e-12", "--out", &out]);
        let said = String::from_utf8(ended.stderr).unwrap();
        assert!(ended.status.code() == Some(1) && said.contains("the step size underflowed at t = 0.999999"), "{said}");
        let failure = read_json(&Path::new(&out).join("summary.json"))["failure"].to_string();
        assert!(failure.contains("the step size underflowed"), "{failure}");
        // Far from both, scaled as the power law has it, runs end well.
        for displacement in ["1e-100", "0.0"] {
            assert_eq!(guarded(displacement, &["--tol", "1e-6"]).0, Some(0), "{displacement}");
        }
        // A background beyond all that is small is refused at once.
        for rho in ["1e-9", "1e-3"] {
            let clock = Instant::now();
            let said = refused(&["breather", "dark", "--rho", rho], 2);
            assert!(said.contains("at most 10 times as fast") && clock.elapsed() < Duration::from_secs(5), "{said}");
        }
    }
}
