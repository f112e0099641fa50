//! Claims of the paper: how they are read, and what decides them.

use hertzchain::{
    internals::{distortion, pair, read_claims},
    paper::{Claim, Item, Kind, Rule, Verdict, claims},
};
use std::{collections::HashSet, f64::consts::PI};

#[test]
fn claims_are_named_once_in_the_order_of_the_paper_and_differences_have_reasons() {
    let names: HashSet<&str> = claims().iter().map(|claim| claim.id.as_str()).collect();
    assert_eq!(names.len(), claims().len());
    assert!(claims().is_sorted_by_key(|claim| claim.section));
    for claim @ Claim { id, label, quantity, paper, instead, same, why, .. } in claims() {
        assert!(![label, quantity, paper].into_iter().any(String::is_empty), "{id}");
        assert!(instead.is_none() || !why.is_empty(), "{id} differs without a reason");
        // A repeated misprint names a claim that differs and does not itself repeat one.
        let first = same.as_ref().map(|same| claims().iter().find(|claim| claim.id == *same).unwrap());
        let wrong = |claim: &Claim| claim.instead.is_some() && claim.open.is_none();
        assert!(first.is_none_or(|first| wrong(claim) && wrong(first) && first.same.is_none()), "{id}");
    }
}

#[test]
fn a_rule_is_written_as_it_is_read() {
    for rule in claims().iter().flat_map(|claim| [Some(&claim.rule), claim.instead.as_ref()]).flatten() {
        assert_eq!(rule.words().parse().as_ref(), Ok(rule));
    }
}

#[test]
fn a_row_that_says_too_little_or_too_much_is_refused() {
    let table =
        |row: &str| read_claims(&format!("[rules]\nsmall = \"<= 2\"\n[[claim]]\nlabel = \"\"\nquantity = \"\"\n{row}"));
    let ours = table("id = \"s3-x\"\nstatement = \"small\"\nrule = \"small\"").unwrap();
    assert_eq!((ours[0].section, &ours[0].rule), (3, &Rule::AtMost(2.0)));
    for row in [
        "id = \"x\"\nnumber = \"2\"",
        "id = \"s3-x\"",
        "id = \"s3-x\"\nnumber = \"2\"\nformula = \"1 + 1\"\nrule = \"= 2 to 1e-9\"",
        "id = \"s3-x\"\nnumber = \"2\"\nrule = \"rounds to 2\"",
        "id = \"s3-x\"\nnumber = \"about 2\"",
        "id = \"s3-x\"\nstatement = \"small\"",
        "id = \"s3-x\"\nstatement = \"small\"\nrule = \"tiny\"",
        "id = \"s3-x\"\nnumber = \"2\"\ninstead = \"tiny\"",
        "id = \"s3-x\"\nnumber = \"2\"\nopen = \"the range\"",
        "id = \"s3-x\"\nnumber = \"2\"\nremark = \"\"",
    ] {
        assert!(table(row).is_err(), "{row}");
    }
}

fn claim(kind: Kind, paper: &str, rule: &str) -> Claim {
    let [id, label, quantity, why] = ["s3-x", "", "", ""].map(String::from);
    let rule = rule.parse().unwrap();
    let (instead, open, same) = (None, None, None);
    Claim { id, section: 3, label, quantity, kind, paper: paper.to_owned(), rule, instead, open, same, why }
}

#[test]
fn a_known_difference_is_expected_and_a_changed_number_is_not() {
    let printed = claim(Kind::Number, "3.126", "rounds to 3.126");
    let misprint = Claim { instead: Some(Rule::Digits("3.140".to_owned())), ..printed.clone() };
    let item = |value| Item { claim: &printed, value };
    let period = |value| Item { claim: &misprint, value };
    assert_eq!((period(3.14002).verdict(), period(3.14002).expected()), (Verdict::Differs, Verdict::Differs));
    assert!(period(3.14002).as_expected());
    // In turn: another value of ours, the paper's value, an unknown difference, none.
    assert!(!period(3.2).as_expected() && !period(3.126).as_expected());
    assert!(!item(3.12).as_expected() && item(3.126).as_expected());
    // Without a verdict, only a changed number is unexpected.
    let open = Claim { open: Some("the range".to_owned()), ..misprint.clone() };
    let undecided = |value| Item { claim: &open, value };
    assert!([3.126, 3.14002].into_iter().all(|value| undecided(value).verdict() == Verdict::NotDecidable));
    assert!(undecided(3.14002).as_expected() && !undecided(3.126).as_expected());
    let bound = claim(Kind::Statement, "", "<= 8");
    let bounded = |value| Item { claim: &bound, value };
    assert_eq!((bounded(7.0).verdict(), bounded(9.0).verdict()), (Verdict::Holds, Verdict::Fails));
    assert!(bounded(7.0).as_expected() && !bounded(9.0).as_expected());
}

#[test]
fn a_claim_has_its_own_quantity() {
    let [one, two] = ["s3-one", "s3-two"].map(|id| Claim { id: id.to_owned(), ..claim(Kind::Number, "2", "<= 2") });
    let both = || [&one, &two].into_iter();
    let items = pair(both(), &[("s3-one", 1.0), ("s3-two", 2.0)]);
    assert_eq!(items.iter().map(|item| item.value).collect::<Vec<_>>(), [1.0, 2.0]);
    for quantities in [
        &[("s3-one", 1.0)][..],
        &[("s3-two", 2.0), ("s3-one", 1.0)],
        &[("s3-one", 1.0), ("s3-2", 2.0)],
        &[("s3-one", 1.0), ("s3-two", 2.0), ("s3-three", 3.0)],
    ] {
        assert!(std::panic::catch_unwind(|| pair(both(), quantities).len()).is_err(), "{quantities:?}");
    }
}

fn digits(printed: &str) -> Rule {
    Rule::Digits(printed.to_owned())
}

#[test]
fn a_number_agrees_if_it_rounds_to_the_printed_digits() {
    for (printed, good, bad) in [
        ("0.057", [0.0565, 0.0571, 0.0575], [0.056_499, 0.0576]),
        ("2", [1.5, 2.0, 2.4], [1.4, 2.6]),
        ("314", [313.6, 314.0, 314.4], [313.4, 314.6]),
        ("6.37e-4", [6.366e-4, 6.37e-4, 6.374e-4], [6.364e-4, 6.376e-4]),
        ("-0.830", [-0.8304, -0.83, -0.8296], [-0.8306, 0.83]),
        ("3.140", [3.1396, 3.1399, 3.1404], [3.1394, 3.1406]),
    ] {
        let rule = digits(printed);
        assert!(good.iter().all(|&value| rule.met_by(value)), "{printed}");
        assert!(bad.iter().all(|&value| !rule.met_by(value)), "{printed}");
        assert!(!rule.met_by(f64::NAN) && !rule.met_by(f64::INFINITY), "{printed}");
    }
    assert!(!digits("about 3").met_by(3.0));
}

#[test]
fn other_rules_take_no_number_that_is_none() {
    for rule in [Rule::Equal { to: 1.0, within: 0.1 }, Rule::AtMost(8.0), Rule::AtLeast(0.0)] {
        assert!(!rule.met_by(f64::NAN) && rule.met_by(1.0));
    }
    assert!(!Rule::Equal { to: 1.0, within: 0.1 }.met_by(1.2) && !Rule::Equal { to: 1.0, within: 0.1 }.met_by(-1.0));
    assert!(!Rule::AtMost(8.0).met_by(8.1) && !Rule::AtLeast(2.0).met_by(1.9));
    assert!(Rule::Undefined.met_by(f64::NAN) && !Rule::Undefined.met_by(0.0));
}

#[test]
fn values_are_shown_with_the_digits_that_decide() {
    for (rule, value, text) in [
        ("rounds to 0.057", 0.057_113_1, "0.05711"),
        ("rounds to 6.37e-4", 6.365_609e-4, "6.3656e-4"),
        ("<= 8", 4.938_420_48, "4.9384"),
        ("<= 1e-12", 3.26e-15, "3.26e-15"),
        (">= 1", 0.0, "0"),
        ("<= 8", 0.999_999_99, "1.0000"),
        ("<= 8", 1.0, "1.0000"),
    ] {
        assert_eq!(Item { claim: &claim(Kind::Number, "", rule), value }.shown(), text, "{rule}");
    }
    assert_eq!((Rule::AtMost(1e-7).words(), Rule::AtLeast(1.5).words()), ("<= 1e-7".into(), ">= 1.5".into()));
}

#[test]
fn what_is_no_rule_is_refused() {
    for (text, rule) in [
        ("rounds to 0.057", digits("0.057")),
        ("= 2.5 to 1e-2", Rule::Equal { to: 2.5, within: 0.01 }),
        ("<= -1e-6", Rule::AtMost(-1e-6)),
        (">= 1.3", Rule::AtLeast(1.3)),
        ("undefined", Rule::Undefined),
    ] {
        assert_eq!(text.parse(), Ok(rule));
    }
    for text in ["", "rounds to", "rounds to x", "= 2.5", "= x to 1e-2", "= 1 to y", "<= ", "< 3", ">=3", "undefined 3"]
    {
        assert!(text.parse::<Rule>().is_err(), "{text}");
    }
}

#[test]
fn distortion_is_that_of_two_sinusoids() {
    let phase = |n: usize, waves: f64| 2.0 * PI * waves * n as f64 / 50.0;
    let profile: Vec<f64> =
        (0..50).map(|n| 7.0 + 2.0 * (phase(n, 5.0) + 0.3).cos() + 0.5 * phase(n, 10.0).sin()).collect();
    assert!((distortion(&profile, 5.0) - 0.25).abs() < 1e-14);
    assert!((distortion(&profile, 10.0) - 4.0).abs() < 1e-12);
}
