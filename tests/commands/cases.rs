//! Scenes that showed faults of this program, with what is right. Truths are closed forms, quadruple
//! precision, or other methods; each row says which. Those of dashpots are in `methods/lossy.rs`.

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
    // Quadruple precision.
    let largest = contacts("run @largest-driven.toml --integrator dop853-regularised --tol 1e-12", "largest_overlap");
    let right = [
        0.282_522_349_294_320_5,
        0.358_461_629_423_011_3,
        0.141_309_244_506_618_55,
        0.278_047_489_560_389_66,
        0.268_587_195_795_719_66,
    ];
    for (bond, right) in right.iter().enumerate() {
        let got = largest.iter().filter(|row| row.0 == bond).map(|row| row.1).fold(0.0, f64::max);
        assert!((got - right).abs() < 2e-12, "bond {bond}: {got:?}, right {right:?}");
    }
    let split = contacts("run @contact-split.toml --integrator dop853-regularised --tol 1e-13", "largest_overlap");
    let third: Vec<_> = split.iter().filter(|row| row.0 == 3).collect();
    assert!(third.len() == 1 && (third[0].1 - 0.322_303_405_198_970_44).abs() < 1e-12, "{third:?}");
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
fn chaotic_scenes_that_showed_faults_say_so() {
    let chaos = hertzchain(&line("run @eight-beads.toml --tol 1e-10 --until 320"));
    assert!(!String::from_utf8_lossy(&chaos.stderr).contains("at all times"));
    assert!(value(&result("run @chaotic-ring.toml --tol 1e-10 --amplification"), "/amplification") > 1e4);
}
