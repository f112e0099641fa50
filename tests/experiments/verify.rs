//! The paper's numbers against ours: the table, its contract, and that it notices a number that has
//! changed.

use hertzchain::{
    paper::{Item, Kind, Rule, Verdict, Verification, claims, verify},
    sweep::Engine,
};
use std::{collections::BTreeMap, sync::OnceLock};

/// The verification of all sections, computed once.
fn all() -> &'static Verification {
    static ALL: OnceLock<Verification> = OnceLock::new();
    ALL.get_or_init(|| verify(None, &Engine::threads(), &|_, _| {}).unwrap())
}

#[test]
fn every_verdict_is_the_one_that_is_known() {
    let unexpected: Vec<_> = all().unexpected().map(|item| (&item.claim.id, item.value)).collect();
    assert!(unexpected.is_empty(), "{unexpected:?}");
}

#[test]
fn each_claim_has_its_quantity_in_the_order_of_the_table() {
    let claimed: Vec<&str> = claims().iter().map(|claim| claim.id.as_str()).collect();
    let computed: Vec<&str> = all().items.iter().map(|item| item.claim.id.as_str()).collect();
    assert_eq!(claimed, computed);
    for item in &all().items {
        let good = matches!(item.verdict(), Verdict::Agrees | Verdict::Holds);
        assert!(good || item.claim.instead.is_some(), "{} differs without a reason", item.claim.id);
    }
}

// Truth: the program; the guide repeats its counts.
#[test]
fn the_guide_has_the_counts_of_the_verdicts() {
    let guide = include_str!("../../docs/paper.md");
    let count = |kind, verdict| all().count(kind, verdict);
    let rows = [
        ("numbers", Kind::Number, Verdict::Agrees, Verdict::Differs),
        ("formulas", Kind::Formula, Verdict::Agrees, Verdict::Differs),
        ("statements", Kind::Statement, Verdict::Holds, Verdict::Fails),
    ];
    let rows = rows.map(|(name, kind, good, bad)| {
        format!("| {name} | {} | {} | {} |", count(kind, good), count(kind, bad), count(kind, Verdict::NotDecidable))
    });
    let words = [format!("holds {} items", all().items.len()), format!("are {} differences", all().misprints())];
    for text in rows.iter().chain(&words) {
        assert!(guide.contains(text), "{text}");
    }
}

/// The page of the guide with the claims that differ or are open.
fn page() -> String {
    let cell = |words: &str| words.replace('|', "\\|");
    let guide = include_str!("../../docs/claims.md");
    let (head, _) = guide.split_once("| claim |").expect("a head");
    let mut page = format!("{head}| claim | where | the paper says | verdict | why |\n|---|---|---|---|---|\n");
    for item in all().items.iter().filter(|item| item.claim.instead.is_some()) {
        let claim = item.claim;
        let words = [&claim.label, &claim.paper].map(|words| cell(words)).join(" | ");
        let open = claim.open.as_ref().map(|what| format!("The paper does not give {what}. "));
        let why = cell(format!("{}{}", open.unwrap_or_default(), claim.why).trim());
        page += &format!("| `{}` | {words} | {} | {why} |\n", claim.id, item.verdict().name());
    }
    page
}

// Truth: the program.
#[test]
fn the_guide_has_every_difference_with_its_verdict() {
    let page = page();
    if include_str!("../../docs/claims.md") != page {
        let file = concat!(env!("CARGO_TARGET_TMPDIR"), "/claims.md");
        std::fs::write(file, page).unwrap();
        panic!("docs/claims.md does not say what the program does: {file} does");
    }
}

#[test]
fn a_changed_number_is_noticed() {
    for item in &all().items {
        // Three times a value violates all printed digits. A bound may be far from the value, and
        // the value is then moved beyond the bound.
        let moved = match item.claim.instead.as_ref().unwrap_or(&item.claim.rule) {
            Rule::AtMost(bound) => bound.abs().max(1e-300) * 2.0,
            Rule::AtLeast(bound) => bound / 2.0 - f64::MIN_POSITIVE,
            _ => item.value * 3.0,
        };
        for value in [moved, f64::NAN] {
            let changed = Item { value, ..*item };
            assert!(!changed.as_expected(), "{}: {value} for {} passes", item.claim.id, item.value);
        }
    }
}

/// Items that do not notice a value larger or smaller by a tenth; and items whose values are
/// roundings that grew, or motions that are chaotic. The file has the reasons.
fn unnoticed_and_chaotic() -> [Vec<&'static str>; 2] {
    let ids = |part: &'static str| -> Vec<&str> {
        part.lines().filter(|line| !line.starts_with('#')).flat_map(str::split_whitespace).collect()
    };
    let (unnoticed, chaotic) = include_str!("../reference/unnoticed.txt").split_once("# chaotic").unwrap();
    [unnoticed, chaotic].map(ids)
}

/// Values agree with those that are stored up to this relative error, or both are below the second
/// number.
const SAME: [f64; 2] = [5e-2, 1e-9];

/// The stored value of each item.
///
/// They are made again by `HERTZCHAIN_STORE=1 cargo test --release --test experiments verify`.
fn stored() -> BTreeMap<String, f64> {
    serde_json::from_str(include_str!("../reference/verify.json")).unwrap()
}

// Truth: the stored values, none of which is computed here. A verdict must change with its number,
// or the table says why it cannot.
#[test]
fn a_tenth_more_or_less_is_noticed_or_the_reason_is_known() {
    let stored = stored();
    let unnoticed = claims().iter().filter(|claim| {
        let passes = |by: f64| Item { claim, value: by * stored[&claim.id] }.as_expected();
        assert!(passes(1.0), "{}: {}", claim.id, stored[&claim.id]);
        passes(1.1) && passes(1.0 / 1.1)
    });
    let mut unnoticed: Vec<&str> = unnoticed.map(|claim| claim.id.as_str()).collect();
    let [mut known, _] = unnoticed_and_chaotic();
    unnoticed.sort_unstable();
    known.sort_unstable();
    assert_eq!(unnoticed, known);
}

// Truth: regression. What a verdict does not notice is noticed here.
#[test]
fn values_are_those_that_are_stored() {
    if std::env::var_os("HERTZCHAIN_STORE").is_some() {
        let values: BTreeMap<&str, f64> = all().items.iter().map(|item| (item.claim.id.as_str(), item.value)).collect();
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/verify.json");
        std::fs::write(path, serde_json::to_string_pretty(&values).unwrap() + "\n").unwrap();
        return;
    }
    let stored = stored();
    assert_eq!(stored.len(), all().items.len());
    let [_, chaotic] = unnoticed_and_chaotic();
    for item in all().items.iter().filter(|item| !chaotic.contains(&item.claim.id.as_str())) {
        let (value, before) = (item.value, stored[&item.claim.id]);
        let same = (value - before).abs() <= (SAME[0] * before.abs()).max(SAME[1]);
        assert!(same, "{}: {before} was stored, now {value}", item.claim.id);
    }
}
