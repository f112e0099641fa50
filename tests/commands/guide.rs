//! The guide: links lead somewhere, commands are understood, every chapter is in the book.
#![cfg(feature = "cli")]

use std::{
    ffi::OsString,
    fs,
    path::{Path, PathBuf},
};

/// The texts that people read: those beside the program, and the chapters.
fn texts() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let beside =
        ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md", "figures/README.md", "python/README.md"];
    let mut all: Vec<PathBuf> = beside.iter().map(|name| root.join(name)).filter(|path| path.exists()).collect();
    let chapters = fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path());
    all.extend(chapters.filter(|path| path.extension().is_some_and(|end| end == "md")));
    all
}

/// The lines of a text outside blocks of code, or inside blocks of one language.
fn lines<'a>(text: &'a str, language: Option<&str>) -> Vec<&'a str> {
    let (mut block, mut found) = (None, Vec::new());
    for line in text.lines() {
        match (line.strip_prefix("```"), block) {
            (Some(name), None) => block = Some(name),
            (Some(_), Some(_)) => block = None,
            (None, within) => {
                if within == language {
                    found.push(line);
                }
            }
        }
    }
    found
}

/// The targets of the links of a text.
fn links(text: &str) -> Vec<String> {
    let text = lines(text, None).join("\n");
    text.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0.to_owned())).collect()
}

/// The name that a heading has in links: letters, digits, `-` and `_`; spaces become `-`.
fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase().replace(' ', "-");
    kept.chars().filter(|c| c.is_alphanumeric() || *c == '-' || *c == '_').collect()
}

#[test]
fn every_link_leads_to_a_file_and_a_heading() {
    let mut count = 0;
    for path in texts() {
        let text = fs::read_to_string(&path).unwrap();
        for link in links(&text).iter().filter(|link| !link.contains("://")) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { path.clone() } else { path.parent().unwrap().join(file) };
            assert!(target.exists(), "{}: {link}", path.display());
            if !heading.is_empty() {
                let text = fs::read_to_string(&target).unwrap();
                let headings = lines(&text, None).into_iter().filter(|line| line.starts_with('#'));
                let known: Vec<String> = headings.map(|line| anchor(line.trim_start_matches('#').trim())).collect();
                assert!(known.iter().any(|one| one == heading), "{}: {link} of {known:?}", path.display());
            }
            count += 1;
        }
    }
    assert!(count > 100, "{count} links: they are looked for in vain");
}

#[test]
fn every_command_of_the_guide_is_understood() {
    let mut count = 0;
    for path in texts() {
        let text = fs::read_to_string(&path).unwrap();
        // A command goes on after a backslash; what follows a sign of the shell is not ours.
        let shell = lines(&text, Some("sh")).join("\n").replace("\\\n", " ");
        for line in shell.lines().filter_map(|line| line.strip_prefix("hertzchain ")) {
            let ours = line.split(['#', '>', '|', '&', ';']).next().unwrap();
            let words = ["hertzchain"].into_iter().chain(ours.split_whitespace());
            // Variables of the shell stand for numbers.
            let words =
                words.map(|word| OsString::from(word.replace("$k", "1").replace("$K", "1").trim_matches(['"', '\''])));
            if let Err(why) = hertzchain::cli::understood(words) {
                panic!("{}: hertzchain {line}\n{why}", path.display());
            }
            count += 1;
        }
    }
    assert!(count > 30, "{count} commands: they are looked for in vain");
}

#[test]
fn every_chapter_is_in_the_book() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let summary = fs::read_to_string(docs.join("SUMMARY.md")).unwrap();
    let listed = links(&summary);
    for entry in fs::read_dir(&docs).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        assert!(!name.ends_with(".md") || name == "SUMMARY.md" || listed.contains(&name), "{name}");
    }
}
