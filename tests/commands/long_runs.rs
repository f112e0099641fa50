//! Long runs: legs and checkpoints, the same bits after an interruption, real kills, signals, disks
//! that are full, and what stops a run.

use hertzchain::{
    Error,
    chain::Contact,
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

/// Of each family one, with 8 legs of the scene below.
const METHODS: [(&str, Setting); 6] = [
    ("strang-linear", Setting::Steps(3000)),
    ("aba1064-linear-landed", Setting::Steps(800)),
    ("dop853", Setting::Tolerance(1e-9)),
    ("dop853-regularised", Setting::Tolerance(1e-9)),
    ("collocation", Setting::Tolerance(1e-9)),
    ("collocation", Setting::Windows(200, 8)),
];

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

#[test]
fn a_run_that_is_interrupted_has_the_bits_of_one_that_is_not() {
    for (name, setting) in METHODS {
        let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
        let [whole, broken] = folders.each_ref().map(|folder| Folder::create(folder.path()).unwrap());
        // The last leg is shorter than the others.
        let outcome = long(name, setting, 2.1).with_contacts().run(&whole, &mut |_| ()).unwrap();
        assert!(outcome.failure.is_none() && outcome.t == 16.0 && outcome.samples.len() > 20, "{name}");
        for limit in [5.0, 11.0] {
            let begun = LongRun::load(broken.path()).unwrap_or_else(|_| long(name, setting, 2.1).with_contacts());
            let breaks = catch_unwind(AssertUnwindSafe(|| begun.run(&broken, &mut |t| assert!(t < limit, "enough"))));
            assert!(breaks.is_err());
            let kept = LongRun::load(broken.path()).unwrap().time();
            assert!(kept <= limit && limit - kept < 2.1 + 0.2, "{name}: kept up to {kept} of {limit}");
        }
        let resumed = LongRun::load(broken.path()).unwrap().run(&broken, &mut |_| ()).unwrap();
        assert!(same(&outcome, &resumed), "{name}");
        let again = LongRun::load(broken.path()).unwrap().run(&broken, &mut |_| panic!("nothing is left to run"));
        assert!(same(&outcome, &again.unwrap()), "{name}");
    }
}

/// Truth: the run that nobody stops. What the first leg leaves is written, read and gone on from.
#[test]
fn scenes_go_on_from_their_checkpoints_by_every_method() {
    goes_on(&["tw-q15", "taper"]);
}

#[test]
#[ignore = "nightly: minutes"]
fn every_scene_goes_on_from_its_checkpoint_by_every_method() {
    goes_on(&Scene::list().into_iter().map(|(name, _)| name).collect::<Vec<_>>());
}

fn goes_on(scenes: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let folder = Folder::create(folder.path()).unwrap();
    let all = "record.quantities=[\"u\",\"u_dot\",\"momentum\",\"energy\",\"sensor\",\"force\",\"overlap\"]";
    let (mut runs, mut logged) = (0, 0);
    for name in scenes {
        let plain = Scene::load(name).unwrap();
        let until = plain.end().min(3.0 * plain.run().fast_period());
        let changes = ["record.samples=5", "record.single=true", "record.compress=true", all].map(str::to_owned);
        let named = Scene::load_with(name, &changes).ok();
        for method in Method::all().into_iter().filter(|method| method.runs(plain.chain()).is_ok()) {
            let asked = MethodRequest { integrator: Some(method.name()), ..MethodRequest::default() };
            for scene in [Some(&plain), named.as_ref()].into_iter().flatten() {
                // A ramp must have ended.
                let cut = |times: f64| scene.clone().until(times * until).ok();
                let scene = [1.0, 4.0].into_iter().find_map(cut).unwrap();
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
                let resumed = LongRun::load(folder.path()).and_then(|kept| kept.run(&folder, &mut |_| ()));
                let resumed = resumed.unwrap_or_else(|why| panic!("{name} {}: {why}", method.name()));
                assert!(same(&whole, &resumed) && whole.extremes == resumed.extremes, "{name} {}", method.name());
                runs += 1;
                logged += whole.contacts.map_or(0, |contacts| contacts.len());
            }
        }
    }
    println!("{runs} runs, {logged} contacts");
    assert!(runs > 30 * scenes.len() && logged > 30 * scenes.len());
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
            let resumed = LongRun::load(folder.path()).unwrap();
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
    let kept = LongRun::load(&path).unwrap();
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
        let message = LongRun::load(&path).map(|_| ()).unwrap_err().to_string();
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
    // Every byte of a member counts: none can be changed unseen.
    for k in (0..written.len()).step_by(written.len() / 300) {
        let mut altered = written.clone();
        altered[k] ^= 1 << (k % 8);
        fs::write(&path, &altered).unwrap();
        if let Ok(read) = LongRun::load(&path) {
            assert!(read.npz().unwrap() == kept.npz().unwrap(), "byte {k}");
        }
    }
    for cut in [0, 3, written.len() / 2, written.len() - 1] {
        fs::write(&path, &written[..cut]).unwrap();
        assert!(refusal(LongRun::load(&path).map(|_| ()).unwrap_err()).contains("archive: not an NPZ file"));
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
        LongRun::load(&path).map(|_| ()).map_err(|error| error.to_string())
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
    use crate::program::{PROGRAM, command, hertzchain, lines, read_json, refusals, refused, stdout};
    use serde_json::Value;
    use std::{
        collections::BTreeMap,
        path::Path,
        process::{Child, Command, Output, Stdio},
        thread::sleep,
        time::{Duration, Instant},
    };

    fn quiet(args: &[&str]) -> Command {
        let mut command = command(args);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command
    }

    /// The files of a folder, but for how long things took. Checkpoints are compared by what comes
    /// of them.
    fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
        let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
        let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let content = |path: &Path| {
            let bytes = fs::read(path).unwrap();
            match path.extension() {
                Some(json) if json == "json" => String::from_utf8(bytes)
                    .unwrap()
                    .lines()
                    .filter(|line| !line.contains("\"wall_s\"") && !line.contains("\"sampling_s\""))
                    .collect::<String>()
                    .into(),
                _ if name(path) == "checkpoint.npz" => Vec::new(),
                _ => bytes,
            }
        };
        paths.map(|path| (name(&path), content(&path))).collect()
    }

    /// A command with a folder that takes `--out`; how to go on, and whether there is something to
    /// go on from.
    struct Study<'a> {
        args: &'a [&'a str],
        resume: Option<(&'a [&'a str], &'a str)>,
        /// Where it keeps what is done, and how much that is.
        kept: &'a dyn Fn(&Path) -> Option<f64>,
        kills: usize,
        /// Number of intervals after which something is kept, all of the same work.
        intervals: Option<f64>,
    }

    /// Waits for a process: whether it succeeded, and its CPU time in seconds, where the system has
    /// Linux' table of processes.
    fn ended(mut process: Child) -> (bool, Option<f64>) {
        let cpu = loop {
            let Ok(table) = fs::read_to_string(format!("/proc/{}/stat", process.id())) else { break None };
            let fields: Vec<&str> = table.rsplit_once(") ").unwrap().1.split(' ').collect();
            // A process that ended stays in the table until it is waited for.
            if fields[0] == "Z" {
                let hundredths = |field: usize| fields[field].parse::<f64>().unwrap();
                break Some(0.01 * (hundredths(11) + hundredths(12)));
            }
            sleep(Duration::from_millis(1));
        };
        (process.wait().unwrap().success(), cpu)
    }

    impl Study<'_> {
        fn begin(&self, out: &Path) -> Command {
            quiet(&[self.args, &["--out", out.to_str().unwrap()]].concat())
        }

        fn go_on(&self, out: &Path) -> Command {
            match self.resume {
                Some((command, name)) if (self.kept)(out).is_some() => {
                    quiet(&[command, &["--resume", out.join(name).to_str().unwrap()]].concat())
                }
                _ => self.begin(out),
            }
        }

        /// Waits until a process keeps so much or ends.
        fn wait(&self, process: &mut Child, out: &Path, target: f64) {
            let kept = || if out.exists() { (self.kept)(out).unwrap_or(0.0) } else { 0.0 };
            while kept() < target && process.try_wait().unwrap().is_none() {
                sleep(Duration::from_millis(3));
            }
        }

        /// Kills it at random moments, as often as that hits, and lets it come to its end at last:
        /// nothing that was kept is lost.
        ///
        /// What a process did after it last kept something is lost, and costs CPU time again: half
        /// an interval a kill in the mean, and the time of a start. The end of a run, with its
        /// pictures, is no part of an interval; a process that finds all done has nothing else.
        fn survives(&self, random: &mut impl FnMut() -> f64) {
            let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
            let [whole, killed] = folders.each_ref().map(|folder| folder.path());
            let clock = Instant::now();
            let (done, whole_cpu) = ended(self.begin(whole).spawn().unwrap());
            assert!(done);
            let (span, end) = (clock.elapsed(), (self.kept)(whole).unwrap());
            let add = |to: &mut Option<f64>, more: Option<f64>| *to = to.zip(more).map(|(to, more)| to + more);
            let (mut hits, mut begun, mut kept, mut cpu) = (0, 1, None, Some(0.0));
            while hits < self.kills {
                let mut process = self.go_on(killed).spawn().unwrap();
                // The last one well before the end.
                self.wait(&mut process, killed, 0.8 * end * (hits as f64 + random()) / self.kills as f64);
                sleep(span.mul_f64(0.1 * random()));
                let _ = process.kill();
                let (done, more) = ended(process);
                add(&mut cpu, more);
                if done {
                    assert!(files(whole) == files(killed), "{:?}", self.args);
                    // Killed too late: once more from the start.
                    fs::remove_dir_all(killed).unwrap();
                    (begun, kept) = (begun + 1, None);
                    continue;
                }
                hits += 1;
                let now = if killed.exists() { (self.kept)(killed) } else { None };
                assert!(now >= kept, "{:?}: {now:?} after {kept:?}", self.args);
                kept = now;
            }
            let (done, more) = ended(self.go_on(killed).spawn().unwrap());
            add(&mut cpu, more);
            assert!(done && files(whole) == files(killed), "{:?}", self.args);
            println!("{:?}: {hits} kills in {begun} runs of {span:?}, the last at {kept:?} of {end}", &self.args[..2]);
            let Some(intervals) = self.intervals else { return };
            let (_, last) = ended(self.go_on(killed).spawn().unwrap());
            if let (Some(whole), Some(last), Some(cpu)) = (whole_cpu, last, cpu) {
                let lost = (cpu - begun as f64 * whole) / hits as f64 * intervals / (whole - last);
                println!(
                    "{whole} s of CPU in one go, {last} s for its end, {cpu} s in all: {lost:.2} intervals a kill"
                );
                assert!(lost > 0.1 && lost < 1.0, "{:?}: {lost} intervals lost a kill", self.args);
            }
        }
    }

    fn time(out: &Path) -> Option<f64> {
        let path = out.join("checkpoint.npz");
        path.exists().then(|| LongRun::load(&path).expect("a checkpoint is whole at any moment").time())
    }

    fn kept_lines(store: &Path) -> Option<f64> {
        store.exists().then(|| lines(store) as f64)
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

    /// Kills a run of six intervals of the same work twelve times.
    fn killed_in_six_intervals(intervals: Option<f64>, random: &mut impl FnMut() -> f64) {
        let line = "run tw-q15 --until 12 --checkpoint 2 --integrator strang-linear --steps-per-period 2400000";
        let args: Vec<&str> = line.split(' ').collect();
        let resume = Some((&["run"][..], "checkpoint.npz"));
        Study { args: &args, resume, kept: &time, kills: 12, intervals }.survives(random);
    }

    // Truth: half an interval in the mean. Beside other tests processes take more CPU time than
    // alone.
    #[test]
    #[ignore = "nightly: it compares CPU times, alone"]
    fn a_kill_costs_less_than_an_interval() {
        killed_in_six_intervals(Some(6.0), &mut random(1));
    }

    #[test]
    fn more_than_fifty_kills_at_random_moments_lose_nothing_that_was_kept() {
        let mut random = random(1);
        killed_in_six_intervals(None, &mut random);
        for line in ["--integrator dop853 --tol 1e-11", "--tol 1e-9"] {
            let args = ["run", "tw-q15", "--until", "12", "--checkpoint", "0.75"];
            let args: Vec<&str> = args.into_iter().chain(line.split(' ')).collect();
            let resume = Some((&["run"][..], "checkpoint.npz"));
            Study { args: &args, resume, kept: &time, kills: 9, intervals: None }.survives(&mut random);
        }
        let sizes = "0.2,0.1,0.05,0.02,0.01,0.005,0.002,0.001,0.0005,0.0002";
        let args = ["study", "theorem", "--epsilons", sizes, "--horizon", "0.5"];
        let kept = |out: &Path| kept_lines(&out.join("theorem.store"));
        Study { args: &args, resume: None, kept: &kept, kills: 14, intervals: None }.survives(&mut random);
        let args =
            ["study", "lifetimes", "--epsilons", "0.2,0.3,0.4", "--rhos", "5,10,20", "--sites", "20", "--until", "12"];
        let kept = |out: &Path| kept_lines(&out.join("lifetimes.store"));
        Study { args: &args, resume: None, kept: &kept, kills: 6, intervals: None }.survives(&mut random);
        let line =
            "breather continue --center bond --sites 5 --from 2.01 --to 2.02 --step 2.5e-4 --bifurcations --weak 1";
        let args: Vec<&str> = line.split(' ').collect();
        let resume = Some((&["breather", "continue", "--bifurcations"][..], "branch.npz"));
        Study { args: &args, resume, kept: &points, kills: 6, intervals: None }.survives(&mut random);
        let four = "--set chain.sites=4 --set initial.site=1";
        let line = format!("orbit continue granular-crystal {four} --settle 20 --to 2e-8 --step 2e-10");
        let args: Vec<&str> = line.split(' ').collect();
        let resume = Some((&["orbit", "continue"][..], "driven-branch.npz"));
        Study { args: &args, resume, kept: &driven_points, kills: 4, intervals: None }.survives(&mut random);
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
        let clock = Instant::now();
        let after = || clock.elapsed() > Duration::from_secs(6);
        let (_, said) = asked("run impact --integrator strang-linear --until 4e9 --samples 0", "TERM", &after);
        assert!(said.contains("this run makes about 6.2e11 steps and takes about"), "{said}");
    }

    /// Commands that compute nothing long.
    const SHORT: &[&str] = &[
        "scenes",
        "scenes show",
        "scenes template",
        "integrators",
        "study bands",
        "study modes",
        "study response",
        "prove",
        "dps integrals",
        "shell completions",
        "shell man",
    ];

    /// Commands with arguments that make them long; OUT is a folder with a plan.
    const LONG: &[&str] = &[
        "run tw-q15 --integrator strang-linear --until 1e7",
        "run tw-q15 --tol 1e-12 --until 1e6 --events",
        "compare tw-q15 --max-time 600",
        "sweep OUT/plan.toml",
        "study order --beads 300 --integrators all",
        "study drift tw-q15 --periods 1000000",
        "study stability --work 1e9",
        "study theorem --epsilons 0.0001,0.00001",
        "study lifetimes --epsilons 0.2,0.3 --rhos 50,60 --until 1000",
        "sweep dimer",
        "wave tw-q15 --zeta 0.1 --seeds 500",
        "wave modulation --measure --chart",
        "wave exact --sites 200 --q-over-pi 0.01",
        "wave solitary --sites 60",
        "wave continue --to 3 --step 1e-4 --max-points 2000",
        "breather bright --until 1e6",
        "breather dark --sites 201",
        "breather continue --center bond --sites 41 --from 2.01 --to 2.06 --step 2e-4",
        "breather doubled",
        "breather evolve tests/golden/orbit.npz --until 1e6",
        "breather barrier --frequencies 500",
        "breather moving",
        "orbit driven end-driven --turns 64",
        "orbit continue granular-crystal --settle 20 --to 2e-8 --step 2e-10",
        "orbit mode precompressed --to 1",
        "dps homoclinic --alpha 1.01",
        "dps dark --sites 100001",
        "paper figures --out OUT/figures",
        "paper verify",
        "paper report --out OUT/report",
    ];

    #[test]
    fn every_command_is_known_as_long_or_as_short() {
        let all = commands();
        // Those that only have commands below them have a usage that ends so.
        let group = |help: String| help.lines().any(|line| line.starts_with("Usage: ") && line.ends_with("<COMMAND>"));
        let alone = |path: &&Vec<String>| !group(help(path, "-h"));
        let own: Vec<String> = all[1..].iter().filter(alone).map(|path| path.join(" ")).collect();
        let of = |line: &&str| own.iter().filter(|name| format!("{line} ").starts_with(&format!("{name} "))).max();
        let mut known: Vec<&String> = LONG.iter().chain(SHORT).filter_map(of).collect();
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
        end_soon(LONG, &[40, 300]);
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
        let folder = tempfile::tempdir().unwrap();
        for (contact, method, step) in [("1e8", "verlet", "0.01"), ("1e4", "yoshida4", "0.1")] {
            let scene = folder.path().join(format!("{method}.toml"));
            let text = format!(
                "name = \"blow-up\"\nchain = {{sites = 1, alpha = 1.5, boundary = \"fixed\"}}\n\
                 bonds = {{overlap = -0.5, contact = {contact}}}\ninitial = {{kind = \"state\", u_dot = [1.0]}}\n\
                 span = {{until = 20.0}}\nrecord = {{samples = 40}}\n"
            );
            fs::write(&scene, text).unwrap();
            let args = ["run", scene.to_str().unwrap(), "--integrator", method, "--step", step];
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
                stdout(&["run", "--resume", out]);
                let whole = tempfile::tempdir().unwrap();
                stdout(&format!("{run} {}", whole.path().display()));
                assert!(files(folder.path()) == files(whole.path()));
            }
        }
    }

    // Truth: the run that nobody stops. Checkpoints are dimensionless; results are not.
    #[test]
    fn a_run_in_si_units_goes_on_in_si_units() {
        let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
        let [out, whole] = folders.each_ref().map(|folder| folder.path().to_str().unwrap());
        let run = "run granular-crystal --until 0.11 --checkpoint 1.1e-3 --out";
        let kept = || time(folders[0].path()).is_some_and(|t| t >= 400.0);
        assert_eq!(asked(&format!("{run} {out}"), "TERM", &kept).0, Some(143));
        stdout(&["run", "--resume", out]);
        stdout(&format!("{run} {whole}"));
        assert!(files(folders[0].path()) == files(folders[1].path()));
    }

    #[test]
    fn a_signal_ends_studies_with_what_was_done() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let text = |name: &str| at(name).display().to_string();
        let all = "0.1,0.05,0.02,0.01,0.005,0.002,0.001,0.0005,0.0002,0.0001,0.00005";
        let store = || lines(&at("t/theorem.store")) >= 2;
        let line = format!("study theorem --epsilons {all} --horizon 0.5 --out {}", text("t"));
        let (code, said) = asked(&line, "INT", &store);
        assert!(code == Some(130) && said.contains("stopped by a signal: "), "{code:?} {said}");
        let study = read_json(&at("t/theorem.json"));
        let (rows, kept) = (study["rows"].as_array().unwrap().len(), lines(&at("t/theorem.store")) - 1);
        assert!(rows == 3 * kept && kept < 11, "{rows} rows, {kept} kept");

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

    /// Lets files grow to this many blocks and no further: writing fails in the middle, as on a
    /// full disk.
    fn limited(blocks: u32, line: &str) -> Output {
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
        Command::new("sh").args(["-c", &script, PROGRAM]).args(line.split(' ')).output().unwrap()
    }

    #[test]
    fn a_full_disk_costs_an_interval_and_says_so() {
        let (full, whole) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let line = "run tw-q15 --integrator strang-linear --until 40 --checkpoint 4 --out";
        let run = |out: &Path| format!("{line} {}", out.display());
        let refused = limited(400, &run(full.path()));
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
        let refused = limited(2, &run(full.path()));
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
        // Soft contacts of small overlaps are stiff: alpha = 1/2, frequencies of 10^15.
        let folder = tempfile::tempdir().unwrap();
        let [scene, out] = ["scene.toml", "out"].map(|name| folder.path().join(name).display().to_string());
        fs::write(&scene, SCENE.replace("1.0\n[span]", "1e-60\n[span]").replace("alpha = 1.5", "alpha = 0.5")).unwrap();
        let ended = hertzchain(&["run", &scene, "--integrator", "dop853", "--tol", "1e-12", "--out", &out]);
        let said = String::from_utf8(ended.stderr).unwrap();
        assert!(ended.status.code() == Some(1) && said.contains("the step size underflowed at t = 1.6"), "{said}");
        let failure = read_json(&Path::new(&out).join("summary.json"))["failure"].to_string();
        assert!(said.contains("e-15 (h = 2.") && failure.contains("the step size underflowed"), "{said} {failure}");
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

    #[test]
    fn what_checkpoints_cannot_do_is_refused_with_the_reason() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().to_str().unwrap();
        let begun = tempfile::tempdir().unwrap();
        let begun = begun.path().to_str().unwrap();
        stdout(&format!("run cradle --until 2 --tol 1e-6 --checkpoint 1 --out {begun}"));
        refusals(
            2,
            &[
                (
                    &["run", "--resume", begun, "--events"][..],
                    "begun without --events: its first contacts are not known",
                ),
                (&["run", "cradle", "--checkpoint", "0", "--out", out], "checkpoint = 0 is not valid"),
                (&["run", "cradle", "--checkpoint", "1e-9", "--out", out], "at most 10^6 intervals"),
                (
                    &["run", "trivial-breather", "--checkpoint", "1", "--out", out],
                    "an exact solution is evaluated at once",
                ),
                (&["run", "--resume", out, "--until", "9"], "cannot be used with"),
            ],
        );
        assert!(refused(&["run", "--resume", out], 1).contains("checkpoint.npz: No such file"));
    }
}
