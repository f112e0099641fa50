//! Scenes that showed faults of this program, with what is right. Truths are closed forms, quadruple
//! precision, or other methods; each row says which. Those of dashpots are in `methods/lossy.rs`.

use crate::program::{hertzchain, json, refused, table};
use serde_json::Value;
use std::fs;

/// A command line with the path of its scene, which is written `@name`.
fn line(words: &str) -> String {
    words.replace('@', concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/cases/"))
}

fn result(words: &str) -> Value {
    json(&line(words))
}

/// Values of a command: a place in its JSON, what is right, and how far it may be off.
type Right<'a> = (&'a str, f64, f64);

#[rustfmt::skip]
const VALUES: &[(&str, &[Right<'_>])] = &[
    // Three other methods.
    ("run @burst-at-rest.toml --integrator dop853-regularised", &[("/u/2", 11.92579, 1e-5), ("/driven", 0.034_469_93, 1e-8)]),
    ("run @burst-at-rest.toml --integrator dop853-landed", &[("/u/2", 11.92579, 1e-5), ("/driven", 0.034_469_93, 1e-8)]),
    ("run @burst-at-rest.toml --integrator dop853", &[("/u/2", 11.92579, 1e-5), ("/driven", 0.034_469_93, 1e-8)]),
    // The prescribed motion, 0.7 sin(16.6).
    ("run @short-ramp.toml --integrator dop853-regularised", &[("/u/0", -0.544_846_454_974_008_9, 1e-13)]),
    ("run @short-ramp.toml --integrator dop853-landed", &[("/u/0", -0.544_846_454_974_008_9, 1e-13)]),
    ("run @short-ramp.toml --integrator dop853", &[("/u/0", -0.544_846_454_974_008_9, 1e-13)]),
    // Two beads without load: the contact lasts a beta function of 1/(alpha + 1).
    ("run @release-alpha20.toml --events", &[("/bonds/duration/1", 2.303_975_151_183_305, 1e-12)]),
    // Every method at 1e-12, and a wave that has reached so many bonds.
    ("run @phantom-contacts.toml --events --tol 1e-6", &[("/contacts/contacts", 59.0, 0.0)]),
    ("run @phantom-contacts.toml --events --tol 1e-8", &[("/contacts/contacts", 59.0, 0.0)]),
    ("run @phantom-contacts.toml --events --tol 1e-10", &[("/contacts/contacts", 59.0, 0.0)]),
    ("run @phantom-contacts.toml --events --tol 1e-12", &[("/contacts/contacts", 59.0, 0.0)]),
    ("run impact --events", &[("/contacts/contacts", 88.0, 0.0)]),
    // A loaded bead is an oscillator: exp((-c/2 + i sqrt(3 - c^2/4)) 128 pi), c = 0.01.
    ("orbit driven @long-orbit.toml --turns 64", &[("/drive/leading/0/re", 0.079_244_432_3, 1e-10), ("/drive/leading/0/im", 0.107_940_086_0, 1e-10)]),
    // The quasi-static response of the contacts of precompression 1, to first order in the drive.
    ("orbit driven @slow-drive.toml", &[("/response", 0.1 / 3.0, 3e-6)]),
    // Steps of 1e-7 to 7e-7.
    ("orbit mode @gap-mode.toml --linear-mode 17 --to 1.5e-6 --step 2.5e-7", &[("/points/-/frequency", 8_040.034_008_0, 1e-5)]),
    // Without springs.
    ("run @weak-springs.toml --tol 1e-8", &[("/u/1", 7.876_868_584_257_691, 1e-9), ("/energy_error", 0.0, 1e-9)]),
    ("run @weak-springs.toml --tol 1e-8 --set chain.kappa=0", &[("/u/1", 7.876_868_584_257_691, 1e-9)]),
    // 1 / |1 - 0.49 + 0.07 i|.
    ("orbit driven @orbit-response.toml", &[("/response", 1.942_571_724_714_528, 1e-12), ("/bead_ranges/0", 1.942_571_724_714_528, 1e-12)]),
    // The same chain in three units of time.
    ("run @small-time-unit-1.toml --integrator aba1064-linear --step 0.01", &[("/u/0", 0.060_216_985_2, 1e-8)]),
    ("run @small-time-unit-1e-06.toml --integrator aba1064-linear --step 1e-8", &[("/u/0", 0.060_216_985_2, 1e-8)]),
    ("run @small-time-unit-1e-12.toml --integrator aba1064-linear --step 1e-14", &[("/u/0", 0.060_216_985_2, 1e-8)]),
    // Quadruple precision.
    ("run @contact-split.toml --integrator dop853-regularised --tol 1e-13 --events", &[("/contacts/contacts", 11.0, 0.0), ("/bonds/onset/3", 8.141_600_014_006_23, 1e-11)]),
    // The final value of the parameter.
    ("orbit continue @branch-past-to.toml --vary omega --to 1.23", &[("/points/-/omega", 1.23, 0.0)]),
    ("orbit continue @amplitude-through-zero.toml --to -1", &[("/points/-/amplitude", -1.0, 0.0)]),
    // u = -sin(2 t)/3.
    ("orbit driven @orbit-root-of-unity.toml", &[("/u_dot/0", -2.0 / 3.0, 1e-11), ("/response", 1.0 / 3.0, 1e-11)]),
    // The force of the dashpot at the onset is its constant times the speed.
    ("run @dashpot-peak.toml --events --tol 1e-6", &[("/largest_force", 1.0, 2e-7), ("/bonds/peak_force/1", 1.0, 2e-7)]),
    ("run @dashpot-peak.toml --events --tol 1e-10", &[("/largest_force", 1.0, 1e-10), ("/bonds/peak_force/1", 1.0, 1e-10)]),
    ("run @dashpot-peak.toml --events --tol 1e-12", &[("/largest_force", 1.0, 1e-12), ("/bonds/peak_force/1", 1.0, 1e-12)]),
];

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
    for (words, rights) in VALUES {
        let json = result(words);
        for (place, right, within) in *rights {
            let got = value(&json, place);
            assert!((got - right).abs() <= *within, "{words}: {place} = {got:?}, right {right:?}");
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
fn scenes_that_showed_faults_end_and_say_why() {
    let folder = tempfile::tempdir().unwrap();
    for (text, code, rule) in [
        ("sweep @plan-huge-count.toml", 2, "at most 2^22 values"),
        ("sweep @plan-huge-seeds.toml", 2, "at most 2^22 values"),
        ("run @terminal-escape.toml", 2, "no control characters"),
    ] {
        assert!(refused(&line(text), code).contains(rule), "{text}");
    }
    for text in [
        "run @blow-up-verlet.toml --integrator verlet --step 0.01 --events",
        "run @blow-up-yoshida4.toml --integrator yoshida4 --step 0.1 --events",
    ] {
        let output = hertzchain(&line(text));
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert!(String::from_utf8_lossy(&output.stderr).contains("not finite at t = 1"), "{text}");
    }
    let ends = hertzchain("run impact --until 1e-310");
    assert!(matches!(ends.status.code(), Some(0 | 2)));
    let chaos = hertzchain(&line("run @eight-beads.toml --tol 1e-10 --until 320"));
    assert!(!String::from_utf8_lossy(&chaos.stderr).contains("at all times"));
    assert!(value(&result("run @chaotic-ring.toml --tol 1e-10 --amplification"), "/amplification") > 1e4);
    let picture = folder.path().join("picture");
    result(&format!("run @no-glyph.toml --out {}", picture.display()));
    assert!(fs::read_dir(picture).unwrap().count() > 3);
}
