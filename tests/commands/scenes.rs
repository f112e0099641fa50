//! Scenes as people write them: the template, what may be left out, and keys changed on the command
//! line.

use super::program::{json, number, stdout};
use hertzchain::scene::{Initial, Record, Scene, SceneFile};
use hertzchain::study::Plan;
use serde_json::Value;

/// The tables `[initial]` of the template: that in use, then those in comments.
fn kinds(template: &str) -> Vec<String> {
    let lines = template.lines().skip_while(|line| !line.contains("[initial]"));
    let mut blocks: Vec<String> = Vec::new();
    for line in lines.take_while(|line| !line.starts_with("# How long")) {
        let bare = line.strip_prefix("# ").unwrap_or(line);
        let code = bare == "[initial]" || bare.split_once(" = ").is_some_and(|(key, _)| !key.contains(' '));
        let line = if code { bare } else { line };
        if line == "[initial]" {
            blocks.push(String::new());
        }
        if let Some(block) = blocks.last_mut() {
            *block += &format!("{line}\n");
        }
    }
    blocks
}

#[test]
fn the_template_is_a_scene_that_runs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, stdout("scenes template")).unwrap();
    let run = json(&["run", path.to_str().unwrap(), "--until", "5"]);
    assert_eq!((run["scene"].as_str(), run["t"].as_f64()), (Some("my-scene"), Some(5.0)));
    assert_eq!(json("scenes template")["name"], "my-scene");
}

/// What the reader of scenes lists where it does not know `zzz`: the keys of a table, or values.
fn known(text: &str) -> Vec<String> {
    listed(toml::from_str::<SceneFile>(text).unwrap_err().message())
}

fn listed(message: &str) -> Vec<String> {
    let (_, listed) = message.split_once("`zzz`, expected ").unwrap_or_else(|| panic!("{message}"));
    listed.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// Whether a dictionary of a fuzz target has a word.
fn defines(dictionary: &str, word: &str) -> bool {
    dictionary.lines().any(|line| line == format!("\"{word}\""))
}

#[test]
fn the_template_has_every_key_and_the_dictionary_of_plans_too() {
    // Truth: what the readers say that they know.
    let template = stdout("scenes template");
    let shows = |text: &str, key: &str| {
        text.lines().any(|line| line.trim_start_matches(['#', ' ']).starts_with(&format!("{key} = ")))
    };
    let mut count = 0;
    let mut all = |text: &str, keys: Vec<String>| {
        for key in keys {
            assert!(shows(text, &key), "{key}: {text}");
            count += 1;
        }
    };
    let blocks = kinds(&template);
    for section in known("zzz = 1") {
        let head = if section == "drive" { "[[drive]]".to_owned() } else { format!("[{section}]") };
        match section.as_str() {
            "name" | "summary" => {
                all(&template, vec![section]);
                continue;
            }
            "initial" => {
                let known_kinds = known("[initial]\nkind = \"zzz\"");
                assert_eq!((blocks.len(), known_kinds.len()), (8, 8), "{blocks:?}");
                for kind in known_kinds {
                    let block = blocks.iter().find(|block| block.contains(&format!("kind = \"{kind}\""))).unwrap();
                    all(block, known(&format!("[initial]\nkind = \"{kind}\"\nzzz = 1")));
                }
            }
            _ => all(&template, known(&format!("{head}\nzzz = 1"))),
        }
        assert!(template.contains(&format!("\n{head}\n")) || template.contains(&format!("\n# {head}\n")), "{head}");
    }
    assert!(count > 70, "{count}");
    let plan = |text: &str| listed(&Plan::parse(text, "plan.toml".as_ref()).unwrap_err().to_string());
    let keys = [plan("zzz = 1"), plan("scene = \"impact\"\n[[axis]]\nzzz = 1")].concat();
    assert!(keys.len() > 10 && keys.iter().all(|key| defines(include_str!("../../fuzz/plan.dict"), key)), "{keys:?}");
}

#[test]
fn every_kind_of_the_template_builds() {
    let chain = |block: &str| {
        let ring = block.contains("travelling-wave");
        let sites = if block.contains("\"state\"") { 3 } else { 20 };
        let boundary = match block {
            _ if ring => "strain-ring",
            block if block.contains("\"envelope\"") => "fixed\"\nprecompression = 1.0 # \"",
            _ => "free",
        };
        format!("[chain]\nsites = {sites}\nalpha = 1.5\nkappa = 1.0\nrho = 2.0\nboundary = \"{boundary}\"\n")
    };
    for block in kinds(&stdout("scenes template")) {
        // What is said in another way stands in a comment.
        let scene = Scene::parse(&format!("{}{block}[span]\nuntil = 1.0\n", chain(&block)), "template");
        assert!(scene.is_ok(), "{}\n{block}", scene.unwrap_err());
    }
}

const BARE: &str = "[chain]\nsites = 3\nalpha = 1.5\nboundary = \"free\"\n[initial]\nkind = \"single-bead\"\nsite = 0\n\
                    velocity = 1.0\n[span]\nuntil = 10.0\n";

#[test]
fn name_springs_masses_and_samples_may_be_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("three-beads.toml");
    std::fs::write(&path, BARE).unwrap();
    let run = json(&["run", path.to_str().unwrap()]);
    let file = &run["scene_file"];
    assert_eq!((run["scene"].as_str(), file["name"].as_str()), (Some("three-beads"), Some("three-beads")));
    assert_eq!((file["chain"]["kappa"].as_f64(), file["chain"]["rho"].as_f64()), (Some(0.0), Some(0.0)));
    // No resonators and no period: 400.
    assert_eq!(file["record"]["samples"], 400);
    assert_eq!(SceneFile::parse(BARE, "").unwrap().name, "scene");
    let samples = |chain: &str, span: &str| {
        let text = BARE.replace("alpha = 1.5\n", &format!("alpha = 1.5\n{chain}")).replace("until = 10.0\n", span);
        Scene::parse(&text, "a.toml").unwrap().samples()
    };
    // A period by the frequency of the resonators, or one that is said: 16 a period, from 400 to
    // 10^4.
    assert_eq!(samples("kappa = 1.0\nrho = 1.0\n", "periods = 100\n"), 1600);
    assert_eq!(samples("kappa = 1.0\nrho = 1.0\n", "periods = 3\n"), 400);
    assert_eq!(samples("kappa = 1.0\nrho = 1.0\n", "periods = 1e6\n"), Record::MOST_SAMPLES);
    assert_eq!(samples("", "periods = 50\nperiod = 3.0\n"), 800);
    assert_eq!(samples("", "until = 1e6\n"), 400);
    // A number that is said is kept, also when the span changes.
    let said = Scene::parse(&(BARE.to_owned() + "[record]\nsamples = 7\n"), "a.toml").unwrap();
    assert_eq!((said.samples(), said.clone().until(1e4).unwrap().samples()), (7, 7));
    let unsaid =
        Scene::parse(&BARE.replace("alpha = 1.5\n", "alpha = 1.5\nkappa = 1.0\nrho = inf\n"), "a.toml").unwrap();
    let period = unsaid.period();
    assert_eq!(unsaid.until(1000.0 * period).unwrap().samples(), Record::MOST_SAMPLES);
    // Only these are left out: the others are asked for.
    for key in ["sites = 3\n", "alpha = 1.5\n", "boundary = \"free\"\n", "until = 10.0\n"] {
        assert!(Scene::parse(&BARE.replace(key, ""), "a.toml").is_err(), "{key}");
    }
}

#[test]
fn keys_of_a_scene_are_changed_on_the_command_line() {
    let set = |changes: &[&str]| {
        let flags = changes.iter().flat_map(|change| ["--set", change]);
        let args: Vec<&str> = ["run", "tw-q15", "--until", "3", "--json"].into_iter().chain(flags).collect();
        json(&args)["scene_file"].clone()
    };
    let file = set(&["chain.rho=3", "name=heavy", "initial.detuning = 2e-3"]);
    assert_eq!((file["chain"]["rho"].as_f64(), file["name"].as_str()), (Some(3.0), Some("heavy")));
    assert_eq!(file["initial"]["detuning"], 2e-3);
    // What a file would say of the same.
    let text = Scene::source("tw-q15").unwrap().replace("rho = 0.3333333333333333", "rho = 3");
    let written = Scene::parse(&text, "written").unwrap();
    let changed = Scene::load_with("tw-q15", &["chain.rho=3".to_owned()]).unwrap();
    assert_eq!((written.file(), written.initial()), (changed.file(), changed.initial()));
    // The last of two wins; a key that the file has not; a table that it has not.
    assert_eq!(set(&["chain.rho=3", "chain.rho=5"])["chain"]["rho"], 5.0);
    assert_eq!(set(&["initial.zeta=0.1"])["initial"]["seed"], 1);
    assert_eq!(Scene::load_with("tw-q15", &["record.samples=9".to_owned()]).unwrap().samples(), 9);
    let quoted = Scene::load_with("cradle", &["chain.boundary=fixed".to_owned()]).unwrap();
    assert!(matches!(quoted.file().initial, Initial::SingleBead { .. }));
    // A table of a list has its number, from 0 on; the other drive keeps its amplitude.
    let inphase = Scene::load_with("chong-2014", &["drive.1.amplitude=1e-8".to_owned()]).unwrap();
    let amplitudes = |scene: &Scene| -> Vec<f64> {
        let drives = &scene.chain().details().unwrap().drives;
        drives.iter().map(|drive| drive.signal.harmonics[0].amplitude).collect()
    };
    let [own, changed] = [amplitudes(&Scene::load("chong-2014").unwrap()), amplitudes(&inphase)];
    assert!(own[0] > 0.0 && own[1] == -own[0] && changed == [own[0]; 2], "{own:?} {changed:?}");
    for (change, rule) in [
        ("drive.2.amplitude=1e-8", "2 is no entry of this list: it has 2, counted from 0"),
        ("drive.0=5", "invalid type"),
        ("drive.\"+0\".amplitude=1e-8", "expected"),
        ("drive={}", "expected"),
    ] {
        let refused = Scene::load_with("chong-2014", &[change.to_owned()]).unwrap_err().to_string();
        assert!(refused.contains(&format!("--set {change}")) && refused.contains(rule), "{refused}");
    }
    // A number of a list, alone.
    let changes = ["record.sites=[1, 2, 3]", "record.sites.2=7"].map(str::to_owned);
    let file = serde_json::to_value(Scene::load_with("impact", &changes).unwrap().file()).unwrap();
    assert_eq!(file["record"]["sites"], serde_json::json!([1, 2, 7]));
    // Everywhere a scene is taken.
    let out = json("study drift cradle --periods 3 --samples 2 --set chain.sites=5");
    assert_eq!(out["scene_file"]["chain"]["sites"], 5);
    let wave = json("wave tw-q15 --until 3 --set chain.rho=2");
    assert_eq!(wave["scene_file"]["chain"]["rho"], 2.0);
    let growth = json("wave modulation tw-q15 --set chain.rho=2");
    assert_eq!(growth["params"]["rho"], 2.0);
}

#[test]
fn a_comparison_takes_the_telling_integrators_unless_all_are_asked_for() {
    let names = |flags: &[&str]| {
        let args =
            [&["compare", "impact", "--max-time", "1", "--set", "chain.sites=5", "--set", "span.until=2"][..], flags]
                .concat();
        let rows = json(&args)["rows"].as_array().unwrap().clone();
        let mut names: Vec<String> = rows.iter().map(|row| row["integrator"].as_str().unwrap().to_owned()).collect();
        names.dedup();
        names
    };
    let (chosen, all) = (names(&[]), names(&["--integrators", "all"]));
    // A chain without resonators has one plain loop beside them.
    assert_eq!((chosen.len(), all.len()), (11 + 1, 31 + 1));
    assert!(chosen.iter().all(|name| all.contains(name)));
    for name in ["verlet", "strang-linear", "corrected", "dop853", "collocation"] {
        assert!(chosen.iter().any(|one| one == name), "{name}");
    }
    // In a pipe lines are short, and a reason why ladders ended is told once.
    let text = stdout("compare impact --max-time 1 --set chain.sites=5 --set span.until=2");
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    assert!(["leaves no time", "beaten by corrected"].iter().all(|why| text.matches(why).count() <= 1), "{text}");
}

/// The tables of the template that stand in comments, without what excludes something else.
fn details_of_the_template() -> String {
    let template = stdout("scenes template");
    let code = template
        .lines()
        .filter_map(|line| line.strip_prefix("# "))
        .filter(|line| line.starts_with('[') || line.split_once(" = ").is_some_and(|(key, _)| !key.contains(' ')));
    let ours = code.skip_while(|line| *line != "[beads]").take_while(|line| *line != "[initial]");
    let beside = ["dashpot = 0.01", "hunt_crossley", "band", "seed", "ramp", "start", "length"];
    let kept = ours.filter(|line| !beside.iter().any(|key| line.starts_with(key)));
    kept.map(|line| format!("{line}\n")).collect()
}

// Truth: what each key does. A key that another value would not change does nothing.
#[test]
fn keys_that_change_nothing_are_said() {
    let doubts = |name: &str, changes: &[&str]| {
        let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
        Scene::load_with(name, &changes).unwrap_or_else(|why| panic!("{changes:?}: {why}")).doubts()
    };
    for (name, _) in Scene::list() {
        assert_eq!(doubts(name, &[]), [""; 0], "{name}");
    }
    let masses = "units={system=\"SI\",radius=0.01,density=8e3,young=2e11,poisson=0.3}";
    for (changes, idle) in [
        (&["beads.kappa=1.0"][..], &["beads.kappa"][..]),
        (&["chain.kappa=1.0"], &["chain.kappa"]),
        (&["chain.rho=0.3"], &["chain.rho"]),
        (&["beads.rho=0.3", "beads.drag=0.1"], &["beads.rho"]),
        (&["beads.resonator=0.3"], &["beads.resonator"]),
        (&["chain.kappa=1.0", "beads.kappa=2.0", "beads.rho=0.5"], &[]),
        (&["chain.kappa=1.0", "chain.rho=0.5", "bonds.contact=2.0"], &[]),
        (&["chain.gravity=0.1", "chain.tilt=-20.0"], &[]),
        (&["bonds.magnet=0.0", "bonds.distance=3.0", "bonds.decay=4.0"], &["bonds.decay", "bonds.distance"]),
        (&["bonds.alpha=2.0"], &[]),
        (&["bonds.overlap=-1e-45", "initial.velocity=1e-45"], &[]),
        (&["bonds.overlap=-1e9", "initial.velocity=1e9", "bonds.contact=2.0"], &[]),
        (&["bonds.dashpot=0.0", "bonds.beta=0.2"], &["bonds.beta"]),
        (&["chain.sites=2", "bonds.viscoelastic=1.0"], &[]),
        // A bead that only its walls push, and only while it comes nearer.
        (&["chain.sites=1", "chain.boundary=fixed", "initial.velocity=-0.5", "bonds.dashpot=1.0"], &[]),
        (&[masses, "initial.velocity=0.1", "span.until=1e-3", "beads.mass=0.01"], &["units.density"]),
        (&[masses, "initial.velocity=0.1", "span.until=1e-3", "units.wall_young=1e11"], &["units.wall_young"]),
    ] {
        let said = doubts("impact", changes);
        let named = said.iter().zip(idle).all(|(said, key)| said.starts_with(&format!("{key} changes nothing")));
        assert!(said.len() == idle.len() && named, "{changes:?}: {said:?}");
    }
}

#[test]
fn the_tables_of_beads_bonds_and_drives_in_the_template_build() {
    let chain = "[chain]\nsites = 20\nalpha = 1.5\nboundary = \"fixed\"\n";
    let rest = "[initial]\nkind = \"single-bead\"\nsite = 1\nvelocity = 0.1\n[span]\nuntil = 1.0\n";
    let tables = details_of_the_template();
    // A bead that is moved has no resonator and no drag; units stand in place of other keys.
    let (first, units) = tables.split_at(tables.find("[units]").unwrap());
    let first = first.replace("rho = 0.5", "rho = 0.0").replace("drag = 0.01\n", "");
    for tables in [&*first, units] {
        let scene = Scene::parse(&format!("{chain}{tables}{rest}"), "template");
        assert!(scene.is_ok(), "{}\n{tables}", scene.unwrap_err());
        // Written and read again it is the same scene.
        let scene = scene.unwrap();
        let again = Scene::parse(&scene.file().to_toml(), "template").unwrap();
        assert_eq!(again.chain().details(), scene.chain().details());
    }
    assert!(first.contains("[beads]") && first.contains("[bonds]") && first.contains("[[drive]]"), "{first}");
}

#[test]
fn rules_give_the_numbers_they_say() {
    // Truth: written out by hand.
    let masses = |rule: &str| {
        let beads = format!("{BARE}[beads]\nmass = {rule}\n");
        Scene::parse(&beads, "rule").map(|scene| scene.chain().details().unwrap().mass.clone())
    };
    for (rule, want) in [
        ("2", [2.0, 2.0, 2.0]),
        ("[1.0, 2, 3.0]", [1.0, 2.0, 3.0]),
        ("{ pattern = [1.0, 0.5], repeat = true }", [1.0, 0.5, 1.0]),
        ("{ pattern = [1.0, 0.5] }", [1.0, 0.5, 0.5]),
        ("{ taper = 0.5, from = 4.0 }", [4.0, 2.0, 1.0]),
        ("{ value = 1.0, except = [[1, 0.25]] }", [1.0, 0.25, 1.0]),
        ("{ pattern = [1.0, 0.5], repeat = true, except = [[2, 3.0]] }", [1.0, 0.5, 3.0]),
    ] {
        assert_eq!(masses(rule).unwrap(), want, "{rule}");
    }
    let random = "{ random = \"uniform\", from = 0.5, to = 1.5, seed = 7 }";
    let drawn = masses(random).unwrap();
    assert!(drawn.iter().all(|mass| (0.5..1.5).contains(mass)) && drawn[0] != drawn[1], "{drawn:?}");
    assert_eq!(drawn, masses(random).unwrap());
    assert_ne!(drawn, masses(&random.replace('7', "8")).unwrap());
}

#[test]
fn json_of_a_scene_that_is_damped_and_driven_has_its_balance() {
    let run = json("run end-driven --until 30");
    let of = |place: &str| number(&run, place);
    let kinds = of("/dissipated/drag") + of("/dissipated/dashpots") + of("/dissipated/contacts");
    assert!((kinds - of("/dissipated/total")).abs() < 1e-15 && of("/dissipated/dashpots") > 0.0);
    // From rest: what is left is what was driven, less what was dissipated. The tolerance is 1e-10
    // of the run.
    let balance = of("/energy") + of("/dissipated/total") - of("/driven");
    assert!(balance.abs() < 1e-10 * of("/driven").abs(), "{balance:e} of {:e}", of("/driven"));
    assert!(of("/energy_error") < 1e-10, "{:e}", of("/energy_error"));
    assert_eq!(run["integrator"], "collocation");
    assert_eq!(run.pointer("/scene_file/beads/rho/except/0/1"), Some(&Value::from(0.0)));
    let rows = json("compare end-driven --set bonds.viscoelastic=0.1 --max-time 1");
    assert!(rows.pointer("/left_out/verlet").unwrap().as_str().unwrap().contains("know no velocities"));
    let rows = json("compare end-driven --integrators verlet,collocation --max-time 2");
    assert!(rows["reference"]["error_estimate"].as_f64().unwrap() < 1e-9, "{}", rows["reference"]["error_estimate"]);
}
