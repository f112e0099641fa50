//! Scenes that showed faults of this program, with what is right. Truths are closed forms, quadruple
//! precision, or other methods; each row says which. Those of dashpots are in `methods/lossy.rs`, the
//! ring with a drive and beads that nearly part in `methods/contact_times.rs`, drives at times that
//! nearly coincide in `methods/signals.rs`, and what `compare` names in `methods/main_job.rs`.

use crate::{
    program::{hertzchain, json, table},
    refusals::rows,
};
use serde_json::Value;

/// A command line with the path of its scene, which is written `@name`.
fn line(words: &str) -> String {
    words.replace('@', concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/cases/"))
}

fn result(words: &str) -> Value {
    json(&line(words))
}

/// A value of JSON; `-` is the last entry of a list.
fn value(json: &Value, place: &str) -> f64 {
    let found = place.split('/').skip(1).fold(json, |at, name| match at.as_array() {
        Some(list) if name == "-" => list.last().unwrap(),
        Some(list) => &list[name.parse::<usize>().unwrap()],
        None => &at[name],
    });
    found.as_f64().unwrap_or_else(|| panic!("{place}: {found}"))
}

#[test]
#[ignore = "at night, with all scenes that showed faults"]
fn scenes_that_showed_faults_have_the_right_values() {
    for row in rows(include_str!("../reference/cases/values.txt")) {
        let (words, rights) = row.split_once(" => ").unwrap();
        let json = result(words);
        for right in rights.split("; ") {
            let fields: Vec<&str> = right.split(' ').collect();
            let [got, right, within] =
                [value(&json, fields[0]), fields[1].parse().unwrap(), fields[2].parse().unwrap()];
            assert!((got - right).abs() <= within, "{words}: {} = {got:?}, right {right:?}", fields[0]);
        }
    }
}

/// The rows of a contact log, and a column of it.
fn contacts(words: &str, column: &str) -> Vec<(usize, f64)> {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    result(&format!("{words} --events --out {}", out.display()));
    let (head, rows) = table(&out.join("contacts.csv"));
    let place = |name| head.split(',').position(|one| one == name).unwrap();
    rows.iter().map(|row| (row[place("bond")] as usize, row[place(column)])).collect()
}

#[test]
#[ignore = "at night, with all scenes that showed faults"]
fn scenes_that_showed_faults_have_the_right_contacts() {
    // Beads that touch and close at a speed of 0.3.
    let onsets = contacts("run @onset-alpha20.toml", "onset_overlap");
    assert!(onsets.iter().all(|&(_, overlap)| overlap == 0.0), "{onsets:?}");
    // The rule of onsets does not depend on the tolerance.
    let onset = |tol| {
        let words = format!("run impact --set chain.alpha=2.5 --set chain.sites=30 --until 16 --tol {tol}");
        contacts(&words, "onset").into_iter().find(|row| row.0 == 9).unwrap().1
    };
    let [rough, fine] = ["1e-6", "1e-9"].map(onset);
    assert!((rough - fine).abs() < 0.02, "{rough} and {fine}");
}

#[test]
#[ignore = "at night, with all scenes that showed faults"]
fn scenes_that_showed_faults_end_as_they_should() {
    let folder = tempfile::tempdir().unwrap();
    for (words, code, said) in [
        ("run @blow-up-verlet.toml --integrator verlet --step 0.01 --events", 1, "not finite at t = 1"),
        ("run @blow-up-yoshida4.toml --integrator yoshida4 --step 0.1 --events", 1, "not finite at t = 1"),
        ("run @no-glyph.toml --out OUT", 0, "written to"),
        (
            r#"run impact --until 1 --set drive=[{site=0,kind="pushed",file="@header-with-units.csv"}]"#,
            2,
            "csv, line 1: `time (s),force (N)`: ",
        ),
    ] {
        let ended = hertzchain(&line(words).replace("OUT", folder.path().to_str().unwrap()));
        let text = String::from_utf8(ended.stderr).unwrap();
        assert!(ended.status.code() == Some(code) && text.contains(said), "{words}: {text}");
    }
}

#[test]
#[ignore = "at night, with all scenes that showed faults"]
fn chaotic_scenes_that_showed_faults_say_so() {
    let chaos = hertzchain(&line("run @eight-beads.toml --tol 1e-10 --until 320"));
    assert!(!String::from_utf8_lossy(&chaos.stderr).contains("at all times"));
    assert!(value(&result("run @chaotic-ring.toml --tol 1e-10 --amplification"), "/amplification") > 1e4);
}
