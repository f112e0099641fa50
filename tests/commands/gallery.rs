//! The gallery: each stored picture is what its command draws.
//!
//! figures/README.md has the commands. `HERTZCHAIN_GOLDEN=update` stores the pictures that differ
//! anew; `HERTZCHAIN_GALLERY` names some of them. `figures/redraw` sets both.
#![cfg(all(feature = "plot", target_os = "linux", target_arch = "x86_64"))]

use super::{
    golden::{difference, picture},
    program::{command, printed},
};
use hertzchain::paper::FIGURES;
use std::{
    collections::BTreeSet,
    env, fs,
    path::{Path, PathBuf},
};

/// Pictures that take at most a second of CPU time.
const QUICK: &[&str] = &[
    "bright-breather-spacetime",
    "contacts-cradle",
    "dark-profiles",
    "exact-limits",
    "exact-wave",
    "homoclinics",
    "long-lived-breather",
    "spacetime-cradle",
    "spacetime-impact",
    "tw-breakdown",
    "tw-q15",
    "tw-rho10-1000",
];

/// Pictures of run times: only their titles are compared.
const TIMED: &[&str] = &["compare-tw-q15", "compare-four", "compare-precompressed"];

/// A command of the gallery: its line without the folder, and for each picture the name of the file
/// that it writes and that of the gallery, without extension.
struct Drawn {
    line: String,
    pictures: Vec<(String, String)>,
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("figures")
}

/// The commands of the gallery. A command stands in a heading, or before an arrow and the names of
/// its pictures; the pictures follow.
fn gallery() -> Vec<Drawn> {
    let page = fs::read_to_string(folder().join("README.md")).unwrap();
    let mut all = Vec::new();
    for part in page.split("`hertzchain ").skip(1) {
        let (line, rest) = part.split_once('`').unwrap();
        let line = line.split_whitespace().collect::<Vec<_>>().join(" ");
        let links = rest.split("](").skip(1).filter_map(|link| link.split_once(')'));
        let stored: Vec<&str> = links.filter_map(|(link, _)| link.strip_suffix(".png")).collect();
        let names: Vec<&str> = match line.strip_suffix(" --out DIR") {
            Some(_) => {
                let words = rest.split("\n\n").next().unwrap().split('`');
                words.filter_map(|word| word.strip_suffix(".png")).collect()
            }
            None => line.split_once("--only ").into_iter().map(|(_, name)| name).collect(),
        };
        assert!(stored.len() == names.len() || names.is_empty(), "{line}: {names:?} are {stored:?}");
        let pictures = names.into_iter().zip(stored).map(|(drawn, stored)| (drawn.to_owned(), stored.to_owned()));
        all.push(Drawn { line: line.trim_end_matches(" --out DIR").to_owned(), pictures: pictures.collect() });
    }
    all.retain(|one| !one.pictures.is_empty());
    all
}

/// The title and the description of a PNG file.
fn words(bytes: &[u8]) -> String {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    reader.finish().unwrap();
    let chunks = &reader.info().utf8_text;
    let of =
        |keyword: &str| chunks.iter().find(|chunk| chunk.keyword == keyword).map(|chunk| chunk.get_text().unwrap());
    ["Title", "Description"].map(|keyword| of(keyword).unwrap_or_default()).join("\n")
}

/// What of a stored picture is not what the program draws now.
fn differs(name: &str, old: &[u8], new: &[u8]) -> Option<String> {
    let [mut before, mut now] = [old, new].map(words);
    if TIMED.contains(&name) {
        [&mut before, &mut now].into_iter().for_each(|words| words.truncate(words.find('\n').unwrap_or(0)));
        return difference(&before, &now);
    }
    difference(&before, &now).or_else(|| (picture(old) != picture(new)).then(|| "its pixels".to_owned()))
}

/// Draws pictures of the gallery and compares them with those that are stored.
fn compare(chosen: impl Fn(&str) -> bool) {
    let update = env::var("HERTZCHAIN_GOLDEN").is_ok_and(|mode| mode == "update");
    let only = env::var("HERTZCHAIN_GALLERY").unwrap_or_default();
    let named = |name: &str| only.is_empty() || only.split_whitespace().any(|one| one == name);
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR")).join("gallery");
    let mut wrong = Vec::new();
    for Drawn { line, pictures } in gallery() {
        let wanted: Vec<_> = pictures.iter().filter(|(_, stored)| chosen(stored) && named(stored)).collect();
        if wanted.is_empty() {
            continue;
        }
        let _ = fs::remove_dir_all(&scratch);
        fs::create_dir_all(&scratch).unwrap();
        printed(command(&format!("{line} --out OUT")).current_dir(&scratch).output().unwrap());
        for (drawn, stored) in wanted {
            let [new, kept] =
                [scratch.join("OUT").join(format!("{drawn}.png")), folder().join(format!("{stored}.png"))];
            let new = fs::read(new).unwrap();
            let how = match fs::read(&kept) {
                Ok(old) => differs(stored, &old, &new),
                Err(_) => Some("it is not there".to_owned()),
            };
            let Some(how) = how.or_else(|| (update && !only.is_empty()).then(String::new)) else { continue };
            if update {
                fs::write(&kept, new).unwrap();
                println!("{stored}: {how}");
            } else {
                wrong.push(format!("{stored}: {how}"));
            }
        }
    }
    assert!(wrong.is_empty(), "figures/redraw draws them anew:\n{}", wrong.join("\n"));
}

// Truth: what the commands draw.
#[test]
fn quick_pictures_of_the_gallery_are_what_the_program_draws() {
    compare(|name| QUICK.contains(&name));
}

#[test]
#[ignore = "nightly: the other pictures take an hour"]
fn pictures_of_the_gallery_are_what_the_program_draws() {
    compare(|name| !QUICK.contains(&name));
}

/// The numbers of a text, with the place of the last digit of each; powers of ten may be raised.
fn numbers(text: &str) -> Vec<(f64, f64)> {
    let raised = "⁰¹²³⁴⁵⁶⁷⁸⁹".chars();
    let text = raised.zip('0'..).fold(text.replace('−', "-").replace("10⁻", "1e-"), |text, (raised, digit)| {
        text.replace(&format!("10{raised}"), &format!("1e{digit}")).replace(raised, &digit.to_string())
    });
    let number = |word: &str| {
        let word = word.trim_matches(|c: char| !c.is_ascii_digit());
        let (mantissa, power) = word.split_once('e').unwrap_or((word, "0"));
        let digits = mantissa.split_once('.').map_or(0, |(_, digits)| digits.len() as i32);
        Some((word.parse().ok()?, 10f64.powi(power.parse::<i32>().ok()? - digits)))
    };
    text.split(|c: char| !(c.is_ascii_digit() || ".e-".contains(c))).filter_map(number).collect()
}

// Truth: captions without their own claims, so that all their numbers are those of the rows.
#[test]
fn numbers_of_claims_stand_in_the_captions_of_their_pictures() {
    let page = fs::read_to_string(folder().join("README.md")).unwrap();
    for part in page.split("`hertzchain ").skip(1) {
        let Some((_, claim)) = part.split_once("Claim: ") else { continue };
        let claim = claim.split("\n\n").next().unwrap().split("Parameters:").next().unwrap();
        let links = part.split("](").skip(1).filter_map(|link| Some(link.split_once(".png)")?.0));
        let names: Vec<&str> = links.collect();
        // Those of times change from machine to machine; the mass ratios of solitary waves are published.
        if names.iter().any(|name| TIMED.contains(name) || *name == "dimer") {
            continue;
        }
        let captions: String =
            names.iter().map(|name| words(&fs::read(folder().join(format!("{name}.png"))).unwrap())).collect();
        let own = FIGURES.iter().find(|figure| names[0] == figure.name).map_or("", |figure| figure.claim);
        assert!(captions.contains(own), "{names:?} has another claim");
        let told = numbers(&captions.replace(own, ""));
        for (number, place) in [numbers(claim), numbers(own)].concat() {
            let same =
                |(other, _): &(f64, f64)| [*other, 100.0 * other].iter().any(|x| (x - number).abs() <= 0.5001 * place);
            assert!(told.iter().any(same), "{names:?}: {number} is not in the caption");
        }
    }
}

#[test]
fn every_picture_of_the_folder_has_its_command() {
    let known: BTreeSet<String> =
        gallery().into_iter().flat_map(|one| one.pictures).map(|(_, stored)| stored).collect();
    let there: BTreeSet<String> = fs::read_dir(folder())
        .unwrap()
        .filter_map(|entry| Some(entry.unwrap().file_name().to_str()?.strip_suffix(".png")?.to_owned()))
        .filter(|name| !name.starts_with("python-"))
        .collect();
    assert_eq!(known, there);
    assert!(QUICK.iter().chain(TIMED).all(|name| known.contains(*name)));
}
