//! The guide: links lead somewhere, commands do what they are shown for, every chapter is in the
//! book.

use super::program::{command, printed};
use std::{
    env,
    ffi::OsString,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// The texts that people read: those beside the program, and the chapters.
fn texts() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let beside = "README ARCHITECTURE CONTRIBUTING SECURITY figures/README python/README proofs/README";
    let mut all: Vec<PathBuf> = beside.split(' ').map(|name| root.join(name).with_extension("md")).collect();
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

/// The commands of a text: its lines for the shell that begin with the program. A command goes on
/// after a backslash.
fn commands(text: &str) -> Vec<String> {
    let shell = lines(text, Some("sh")).join("\n").replace("\\\n", " ");
    shell.lines().filter(|line| line.split(' ').next() == Some("hertzchain")).map(str::to_owned).collect()
}

#[test]
fn every_command_of_the_guide_is_understood() {
    let mut count = 0;
    for path in texts() {
        for line in commands(&fs::read_to_string(&path).unwrap()) {
            // What follows a sign of the shell is not ours.
            let ours = line.split(['#', '>', '|', '&', ';']).next().unwrap();
            // Variables of the shell stand for numbers.
            let words = words(ours).into_iter().map(|word| OsString::from(word.replace("$k", "1").replace("$K", "1")));
            // Without a command the program says where to begin.
            if words.len() == 1 {
                continue;
            }
            if let Err(why) = hertzchain::cli::command().try_get_matches_from(words)
                && why.use_stderr()
            {
                panic!("{}: {line}\n{why}", path.display());
            }
            count += 1;
        }
    }
    assert!(count > 60, "{count} commands: they are looked for in vain");
}

/// The words of a command; quotation marks hold words together.
fn words(line: &str) -> Vec<String> {
    let (mut all, mut word, mut quote) = (Vec::new(), String::new(), None);
    for c in line.chars().chain([' ']) {
        match quote {
            Some(mark) if c == mark => quote = None,
            None if c == '"' || c == '\'' => quote = Some(c),
            None if c == ' ' => all.extend(Some(std::mem::take(&mut word)).filter(|word| !word.is_empty())),
            _ => word.push(c),
        }
    }
    all
}

/// Files that a text has its reader save: a block of TOML after the words "as `NAME.toml`".
fn files(text: &str) -> Vec<(&str, &str)> {
    let blocks = text.match_indices("```toml\n").filter_map(|(at, mark)| {
        let name = text[..at].rsplit_once("as `").max(text[..at].rsplit_once("as\n`"))?.1.split_once('`')?.0;
        Some((name, text[at + mark.len()..].split_once("```")?.0)).filter(|_| name.ends_with(".toml"))
    });
    blocks.collect()
}

/// Commands that take more than half a second of CPU time, or go on with what such a command wrote.
const LONG: &str = "\
    breather barrier; breather bright; breather continue; \
    breather dark --center bond; breather doubled; breather evolve; breather moving; \
    compare; orbit continue; orbit driven; orbit mode boechler-2010; \
    orbit mode defect --to 1.5; paper; run impact --set chain.sites=2000000; study; sweep dimer; \
    sweep disorder; sweep impurity; sweep plan.toml --out out/masses; sweep taper; wave continue; \
    wave modulation --q-over-pi; wave solitary; wave tw-q15; wave tw-rho3";

/// Runs the commands of every text, in its order and in a folder of its own; those of `LONG` only
/// if asked for.
fn run_the_guide(long: bool) {
    let program = Path::new(env!("CARGO_BIN_EXE_hertzchain"));
    let path = format!("{}:{}", program.parent().unwrap().display(), env::var("PATH").unwrap_or_default());
    let starts: Vec<&str> = LONG.split("; ").collect();
    let (mut met, mut ran) = (vec![false; starts.len()], 0);
    for text in texts() {
        let name = text.strip_prefix(env!("CARGO_MANIFEST_DIR")).unwrap().to_string_lossy().replace('/', "-");
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("guide-{long}")).join(name);
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        let said = fs::read_to_string(&text).unwrap();
        for (name, content) in files(&said) {
            fs::write(folder.join(name), content).unwrap();
        }
        for line in commands(&said) {
            let known = starts.iter().position(|start| line["hertzchain".len()..].trim_start().starts_with(start));
            known.into_iter().for_each(|at| met[at] = true);
            if known.is_some() && !long {
                continue;
            }
            let done = Command::new("sh").args(["-c", &line]).current_dir(&folder).env("PATH", &path).output().unwrap();
            let why = String::from_utf8_lossy(&done.stderr);
            assert!(done.status.success(), "{}: {line}\n{}\n{why}", text.display(), done.status);
            ran += 1;
        }
        fs::remove_dir_all(&folder).unwrap();
    }
    assert!(ran > 30, "{ran} commands: they are looked for in vain");
    let gone: Vec<_> = starts.iter().zip(&met).filter(|(_, met)| !**met).collect();
    assert!(gone.is_empty(), "not in the guide: {gone:?}");
}

// Truth: what the guide shows is what a reader types. The exit code says whether it worked.
#[test]
#[cfg(unix)]
fn cheap_commands_of_the_guide_run() {
    run_the_guide(false);
}

#[test]
#[cfg(unix)]
#[ignore = "nightly: all commands of the guide take a quarter of an hour"]
fn all_commands_of_the_guide_run() {
    run_the_guide(true);
}

// Truth: the help of every command, as the program prints it.
#[test]
fn every_store_has_its_place() {
    let (files, mut stores) = (include_str!("../../docs/files.md"), 0);
    for path in super::help::commands() {
        let help = super::help::help(&path, "--help");
        for store in help.split_whitespace().filter(|word| word.ends_with(".store")) {
            // That of a study NAME is NAME.store, as the page says.
            let of_study = help.contains(&store.replace(".store", ".json"));
            assert!(of_study || files.contains(&format!("`{store}`")), "files.md, {path:?}: {store}");
            stores += 1;
        }
    }
    assert!(stores > 20, "{stores} stores are named");
}

#[test]
fn the_generated_page_is_what_the_help_says() {
    // HERTZCHAIN_GOLDEN=update writes the file anew, as for the golden net.
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("python/hertzchain/studies.py");
    let now = hertzchain::cli::studies();
    if env::var("HERTZCHAIN_GOLDEN").is_ok_and(|mode| mode == "update") {
        fs::write(&path, &now).unwrap();
    }
    assert!(fs::read_to_string(&path).unwrap() == now, "studies.py is not what the program says");
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

#[test]
fn the_table_of_formats_has_the_versions_that_are_written() {
    // Truth: what the program writes.
    use hertzchain::output::{Archive, Folder};
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("guide-formats");
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    let run = |line: &str| printed(command(line).current_dir(&folder).output().unwrap());
    run("run impact --until 2 --checkpoint 1 --out a");
    run("breather continue --from 2.01 --to 2.011 --step 0.001 --sites 5 --out a");
    run("wave continue --sites 10 --to 2.002 --out a");
    run("orbit mode defect --step 0.006 --to 0.01 --out a");
    fs::write(folder.join("plan.toml"), run("sweep --template")).unwrap();
    run("sweep plan.toml --out a");
    let page = include_str!("../../docs/files.md");
    let row = |file: &str, format: &str, version: &serde_json::Value| {
        let found = page.lines().find(|line| line.starts_with(&format!("| {file}")) && line.ends_with(" |")).unwrap();
        assert!(found.ends_with(&format!("| {format} | {version} |")), "{file}: {format}, {version}: {found}");
    };
    let of = Folder::create(folder.join("a")).unwrap();
    for file in ["checkpoint.npz", "branch.npz", "wave-branch.npz", "mode-branch.npz"] {
        let archive = Archive::read(&of.path().join(file)).unwrap();
        let settings: serde_json::Value = serde_json::from_str(archive.text("settings.json").unwrap()).unwrap();
        row(&format!("`{file}`"), &format!("`{}`", settings["format"].as_str().unwrap()), &settings["version"]);
    }
    let read = |file: &str| fs::read_to_string(of.path().join(file)).unwrap();
    let first = read("sweep.store").lines().next().unwrap().split_once(' ').unwrap().1.to_owned();
    row("stores", "", &serde_json::from_str::<serde_json::Value>(&first).unwrap()["sweep"]);
    fs::remove_dir_all(&folder).unwrap();
}

/// An empty folder with the files that a page has its reader save, and the page.
fn saved(page: &str) -> (PathBuf, String) {
    let said = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(page)).unwrap();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(page.replace('/', "-"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    files(&said).into_iter().for_each(|(name, content)| fs::write(folder.join(name), content).unwrap());
    (folder, said)
}

// Truth: what the commands print; run times differ.
#[test]
fn the_first_page_shows_what_its_commands_print() {
    let (folder, said) = saved("docs/start.md");
    let mut shown = 0;
    for part in said.split("```sh\nhertzchain").skip(1) {
        let (line, rest) = part.split_once("\n```\n```text\n").unwrap();
        let now =
            printed(command(&line.split_whitespace().collect::<Vec<_>>()[..]).current_dir(&folder).output().unwrap());
        let [old, now] = [rest.split_once("```").unwrap().0, &now].map(|text| super::golden::masked(text, &folder));
        assert_eq!(super::golden::difference(&old, &now), None, "hertzchain{line}");
        shown += 1;
    }
    assert_eq!(shown, 5);
}

#[test]
#[cfg(unix)]
fn a_page_from_data_to_a_figure_shows_what_its_commands_print() {
    // Truth: the output of the commands above each block of text.
    let (folder, said) = saved("docs/laboratory.md");
    let mut shown = 0;
    for part in said.split("```sh\n").skip(1) {
        let (shell, rest) = part.split_once("```").unwrap();
        let run = |line: &str| {
            printed(command(line.trim_start_matches("hertzchain ")).current_dir(&folder).output().unwrap())
        };
        let output: String = shell.lines().map(run).collect();
        for line in rest.split_once("```text\n").unwrap().1.split_once("```").unwrap().0.lines() {
            assert!(output.contains(line), "{line}\n{output}");
            shown += 1;
        }
        // Another method prints the numbers of the first one.
        if shell.contains("dop853") {
            let digits = ["3.911586e2", "5.684251e2", "3.298592e2", "3.298529e2", "3.408158e-1", "8.596806e-4"];
            let other = run(shell.lines().next().unwrap());
            assert!(digits.iter().all(|digits| said.contains(digits) && other.contains(digits)), "{other}");
        }
    }
    assert_eq!(shown, 9);
    let table = fs::read_to_string(folder.join("out/speeds/sweep.csv")).unwrap();
    let (head, rows) = table.split_once('\n').unwrap();
    let numbers = |row: &str| row.split(',').take(4).map(|cell| cell.parse().unwrap()).collect::<Vec<f64>>();
    let rows: Vec<_> = rows.lines().map(numbers).collect();
    assert!(head.starts_with("initial.velocity,speed[20..30],bonds.peak_force[25]") && rows.len() == 3, "{head}");
    let k = (2.0 * 193e9 / (0.01905 * 8027f64.powf(1.5) * 0.91)).cbrt();
    assert!((k - 314.01).abs() < 0.005);
    for row in rows {
        let constant = row[1] / (k * row[2].powf(1.0 / 6.0));
        assert!((constant - 0.688_673).abs() < 5e-7 && (row[3] / row[0] - 0.6816).abs() < 5e-5, "{row:?}");
    }
}
