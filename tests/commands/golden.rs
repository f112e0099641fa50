//! The golden net: every command, small, against stored answers.
//!
//! `tests/golden/commands.txt` has the command lines. An answer is what the command prints, its
//! exit code, and a line for each file that it writes: for text the hash of its words and two
//! weighted sums of its numbers, for pictures their size and a coarse image. Run times and the
//! machine are masked.
//!
//! `HERTZCHAIN_GOLDEN=update` writes the answers anew: the difference of `tests/golden` then shows
//! what a change has changed. `HERTZCHAIN_GOLDEN=bytes` compares every digit, as one does on one
//! machine before and after a change that must change nothing. By default numbers may differ by
//! 1e-6, since the last bits depend on the system's library of functions.
#![cfg(all(feature = "plot", target_os = "linux", target_arch = "x86_64"))]

use super::help::help;
use hertzchain::output::Archive;
use std::{
    collections::BTreeMap,
    env, fs,
    path::{Path, PathBuf},
    process::Command,
    sync::atomic::{AtomicUsize, Ordering},
    thread,
};

/// Keys of JSON and columns of CSV that a second run changes, or another machine.
const MASKED: &[&str] = &[
    "wall",
    "wall_s",
    "sampling_s",
    "step_cost",
    "runs",
    "fastest",
    "date",
    "system",
    "cores",
    "instructions",
    "processor",
];

/// Largest relative difference of two numbers, and the size below which numbers are rounding
/// errors.
const TOLERANCE: f64 = 1e-6;
const ROUNDING: f64 = 1e-9;

/// A text cut into numbers and what stands between them. White space counts as one space.
#[derive(Debug)]
enum Token<'a> {
    Number(f64),
    Words(&'a str),
}

fn tokens(text: &str) -> Vec<Token<'_>> {
    let bytes = text.as_bytes();
    let (mut all, mut from, mut at) = (Vec::new(), 0, 0);
    while at < bytes.len() {
        let before = if at == 0 { b' ' } else { bytes[at - 1] };
        let begins =
            bytes[at].is_ascii_digit() || (bytes[at] == b'-' && bytes.get(at + 1).is_some_and(u8::is_ascii_digit));
        if !begins || before.is_ascii_alphanumeric() || before == b'_' {
            at += 1;
            continue;
        }
        let mut end = at + 1;
        while end < bytes.len()
            && (bytes[end].is_ascii_digit()
                || (bytes[end] == b'.' && bytes.get(end + 1).is_some_and(u8::is_ascii_digit)))
        {
            end += 1;
        }
        if bytes.get(end) == Some(&b'e') {
            let digits = end + 1 + usize::from(bytes.get(end + 1) == Some(&b'-'));
            let stop = digits + bytes[digits..].iter().take_while(|byte| byte.is_ascii_digit()).count();
            end = if stop > digits { stop } else { end };
        }
        match text[at..end].parse() {
            Ok(number) if !bytes.get(end).is_some_and(u8::is_ascii_alphabetic) => {
                all.extend([Token::Words(&text[from..at]), Token::Number(number)]);
                (from, at) = (end, end);
            }
            _ => at = end,
        }
    }
    all.push(Token::Words(&text[from..]));
    all
}

/// The text without run times, the machine and the names of temporary folders.
pub(super) fn masked(text: &str, folder: &Path) -> String {
    let text = text.replace(&*folder.to_string_lossy(), "OUT").replace(env!("CARGO_MANIFEST_DIR"), "ROOT");
    let mut out = String::new();
    let mut rest = &text[..];
    // `"key": value`, up to the next comma or the end of the line, lists up to that.
    while let Some(at) = MASKED.iter().filter_map(|key| rest.find(&format!("\"{key}\": "))).min() {
        let value = at + rest[at..].find(": ").unwrap() + 2;
        let ends: &[char] = if rest[value..].starts_with('[') { &['\n'] } else { &[',', '\n', '}'] };
        let end = value + rest[value..].find(ends).unwrap_or(rest.len() - value);
        out.push_str(&rest[..value]);
        out.push('~');
        rest = &rest[end..];
    }
    out.push_str(rest);
    // `0.12 s`, and times of day.
    let mut words: Vec<&str> = out.split(' ').collect();
    for at in 1..words.len() {
        let unit = words[at].trim_start_matches("s<").trim_end_matches(|c: char| !c.is_alphanumeric());
        let begins = ["s,", "s\n", "s.<"].iter().any(|start| words[at].starts_with(start));
        let times = matches!(unit, "s" | "ms" | "us" | "ns") || begins;
        let number = words[at - 1].rsplit('>').next().unwrap_or_default();
        if times && number.parse::<f64>().is_ok() {
            words[at - 1] = "~";
        }
    }
    words.join(" ")
}

/// Numbers of a text that share two sums of a fingerprint.
const TOGETHER: u32 = 64;

/// Words and two weighted sums of each `TOGETHER` numbers of a text, without the masked columns of
/// a CSV file.
fn fingerprint(name: &str, text: &str) -> String {
    if name.ends_with(".store") {
        return format!("{} lines", text.lines().count());
    }
    let mut kept = text.to_owned();
    if name.ends_with(".csv") {
        let heads: Vec<&str> = text.lines().next().unwrap_or_default().split(',').collect();
        let keep = |line: &str| -> String {
            let cells = line.split(',').zip(&heads).filter(|(_, head)| !MASKED.contains(head));
            cells.map(|(cell, _)| cell).collect::<Vec<_>>().join(",")
        };
        kept = text.lines().map(keep).collect::<Vec<_>>().join("\n");
    }
    // Fowler, Noll & Vo's hash.
    let (mut words, mut sums, mut count) = (0xcbf2_9ce4_8422_2325_u64, Vec::new(), 0u32);
    for token in tokens(&kept) {
        match token {
            Token::Words(text) => {
                // Embedded pictures are long words.
                let letters = text.split_whitespace().filter(|word| word.len() < 200).flat_map(str::bytes);
                words = letters.fold(words, |hash, letter| (hash ^ u64::from(letter)).wrapping_mul(0x100_0000_01b3));
            }
            // Pages have a date.
            Token::Number(x) if !name.ends_with(".html") => {
                if count.is_multiple_of(TOGETHER) {
                    sums.push([0.0; 2]);
                }
                count += 1;
                let y = (1.0 + x.abs() / ROUNDING).ln().copysign(x);
                let weight = (f64::from(count) * 0.618_033_988_749_894_9).fract();
                let last = sums.last_mut().unwrap();
                (last[0], last[1]) = (last[0] + y.abs(), last[1] + (1.0 + weight) * y);
            }
            Token::Number(_) => {}
        }
    }
    sums.iter().fold(format!("{words:x} {count}"), |text, [a, b]| text + &format!(" {a:e} {b:e}"))
}

/// Size and a coarse image of a picture: mean brightness of eight by eight fields, from 0 to 15.
pub(super) fn picture(bytes: &[u8]) -> String {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    let (width, height, samples) = (info.width as usize, info.height as usize, info.color_type.samples());
    let field = |k: usize| {
        let (x, y) = (k % 8, k / 8);
        let rows = y * height / 8..(y + 1) * height / 8;
        let of = |row: usize| {
            &pixels[(row * width + x * width / 8) * samples..(row * width + (x + 1) * width / 8) * samples]
        };
        let (sum, n) = rows.flat_map(of).fold((0u64, 0u64), |(sum, n), &value| (sum + u64::from(value), n + 1));
        char::from_digit((sum / (16 * n.max(1))).min(15) as u32, 16).unwrap()
    };
    format!("{width}x{height} {}", (0..64).map(field).collect::<String>())
}

/// The names of the files in an archive.
fn members(path: &Path) -> Vec<String> {
    let archive = zip::ZipArchive::new(fs::File::open(path).unwrap()).unwrap();
    archive.file_names().map(|name| name.unwrap().into_owned()).collect()
}

fn has(bytes: &[u8], text: &str) -> bool {
    bytes.windows(text.len()).any(|window| window == text.as_bytes())
}

/// The files below a folder, by name, each told in one line. Pictures and archives of settings name
/// the program that made them.
fn files(folder: &Path, timed: bool) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in fs::read_dir(&next).into_iter().flatten() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
                continue;
            }
            let (name, bytes) =
                (path.strip_prefix(folder).unwrap().to_string_lossy().into_owned(), fs::read(&path).unwrap());
            let made = format!("hertzchain {}", env!("CARGO_PKG_VERSION"));
            let told = match std::str::from_utf8(&bytes) {
                Ok(text) if timed && name.ends_with(".csv") => {
                    format!("timed, {}", text.lines().next().unwrap_or_default())
                }
                Ok(_) if timed && !name.ends_with(".json") => "timed".to_owned(),
                Ok(text) => fingerprint(&name, &masked(text, folder)),
                Err(_) if timed => "timed".to_owned(),
                Err(_) if name.ends_with(".png") => {
                    assert!(
                        has(&bytes, &format!("tEXtSoftware\0{made}")) && has(&bytes, &format!("{made}.")),
                        "{name}"
                    );
                    picture(&bytes)
                }
                // How well numbers deflate depends on their last digits.
                Err(_) if name.ends_with(".zip") => members(&path).join(" "),
                // Arrays of a run lie beside its summary; what is gone on with says it itself.
                Err(_) => {
                    let settings =
                        Archive::read(&path).ok().and_then(|npz| npz.text("settings.json").ok()?.parse().ok());
                    let program = settings.map(|settings: serde_json::Value| settings["program"] == made.as_str());
                    assert!(program != Some(false), "{name}");
                    format!("{} bytes", bytes.len())
                }
            };
            found.insert(name, told);
        }
    }
    found
}

/// What a command answers.
fn answer(line: &str, folder: &Path) -> String {
    let _ = fs::remove_dir_all(folder);
    fs::create_dir_all(folder).unwrap();
    let out = folder.join("out");
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let words = line.split(' ').map(|word| match word {
        "OUT" => out.clone(),
        file if file.starts_with('@') => golden.join(&file[1..]),
        word => PathBuf::from(word),
    });
    let done = Command::new(env!("CARGO_BIN_EXE_hertzchain")).args(words).current_dir(folder).output().unwrap();
    let [printed, said] = [&done.stdout, &done.stderr].map(|bytes| masked(std::str::from_utf8(bytes).unwrap(), &out));
    let mut text = format!(
        "$ {line}\nexit {}\n--- stdout\n{printed}\n--- stderr\n{said}\n--- files\n",
        done.status.code().unwrap()
    );
    // Its pictures and tables are of run times.
    let timed = line.starts_with("compare");
    for (name, told) in files(&out, timed) {
        text.push_str(&format!("{name}: {told}\n"));
    }
    fs::remove_dir_all(folder).unwrap();
    text
}

/// Where two answers differ: the words and numbers there.
pub(super) fn difference(old: &str, new: &str) -> Option<String> {
    let (a, b) = (tokens(old), tokens(new));
    for (at, (old, new)) in a.iter().zip(&b).enumerate() {
        let same = match (old, new) {
            (Token::Words(old), Token::Words(new)) => old.split_whitespace().eq(new.split_whitespace()),
            (Token::Number(old), Token::Number(new)) => {
                (old - new).abs() <= TOLERANCE * old.abs().max(new.abs()) || old.abs().max(new.abs()) < ROUNDING
            }
            _ => false,
        };
        if !same {
            let around = |all: &[Token<'_>]| format!("{:?}", &all[at.saturating_sub(2)..(at + 2).min(all.len())]);
            return Some(format!("{}\n  instead of\n{}", around(&b), around(&a)));
        }
    }
    (a.len() != b.len()).then(|| format!("{} words and numbers instead of {}", b.len(), a.len()))
}

/// The command lines of the net.
fn commands() -> Vec<String> {
    let text = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/commands.txt")).unwrap();
    text.lines().filter(|line| !line.is_empty() && !line.starts_with('#')).map(str::to_owned).collect()
}

/// The file of the answer to a line.
fn stored(line: &str) -> PathBuf {
    let name: String = line.chars().map(|c| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' }).collect();
    let answers = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/answers");
    answers.join(format!("{}-{}.txt", &name[..name.len().min(40)], name.len()))
}

// Truth: regression only; other tests hold the numbers against independent truths.
#[test]
fn every_command_answers_as_stored() {
    let mode = env::var("HERTZCHAIN_GOLDEN").unwrap_or_default();
    let lines = commands();
    let (next, scratch) = (AtomicUsize::new(0), Path::new(env!("CARGO_TARGET_TMPDIR")).join("golden"));
    let check = |k: usize| -> Option<String> {
        let line = &lines[k];
        let stored = stored(line);
        let new = answer(line, &scratch.join(k.to_string()));
        if mode == "update" {
            fs::create_dir_all(stored.parent().unwrap()).unwrap();
            fs::write(&stored, new).unwrap();
            return None;
        }
        let old = fs::read_to_string(&stored).unwrap_or_default();
        let differs = if mode == "bytes" { (old != new).then(String::new) } else { difference(&old, &new) };
        differs.map(|how| {
            let kept = scratch.join(stored.file_name().unwrap());
            fs::write(&kept, new).unwrap();
            format!("hertzchain {line}\n{how}\n  diff {} {}", stored.display(), kept.display())
        })
    };
    let take = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&k| k < lines.len());
    let work = || -> Vec<String> { std::iter::from_fn(take).filter_map(check).collect() };
    let failures: Vec<String> = thread::scope(|scope| {
        let workers: Vec<_> =
            (0..thread::available_parallelism().map_or(1, usize::from)).map(|_| scope.spawn(work)).collect();
        workers.into_iter().flat_map(|worker| worker.join().unwrap()).collect()
    });
    assert!(failures.is_empty(), "{} of {} answers differ:\n\n{}", failures.len(), lines.len(), failures.join("\n\n"));
}

// Truth: the help itself, in its sentence about files.
#[test]
fn studies_write_the_pictures_that_their_help_names() {
    let lines = commands();
    for study in [
        "study theorem",
        "study lifetimes",
        "wave tw-q15",
        "wave modulation",
        "breather bright",
        "breather dark",
        "breather continue",
        "dps dark",
    ] {
        let line = lines.iter().find(|line| line.starts_with(study) && line.ends_with("--out OUT")).unwrap();
        let path: Vec<String> = study.split(' ').filter(|word| *word != "tw-q15").map(str::to_owned).collect();
        let help = help(&path, "--help");
        let files = help.split("Files: ").nth(1).unwrap().split("--json").next().unwrap();
        let names = files.split_whitespace().map(|word| word.trim_matches([',', '.', ';']));
        let pictures: Vec<&str> = names.filter(|name| name.ends_with(".png")).collect();
        let answer = fs::read_to_string(stored(line)).unwrap();
        assert!(!pictures.is_empty(), "{line}: {files}");
        assert!(pictures.iter().all(|name| answer.contains(&format!("\n{name}: "))), "{line}: {pictures:?}");
    }
}

#[test]
fn a_difference_of_a_word_or_a_digit_is_found() {
    assert!(difference("u = 1.0000001e0 of dop853", "u =  1.0000002e0 of dop853").is_none());
    assert!(difference("u = 1.00001", "u = 1.00002").is_some());
    assert!(difference("u = 1", "v = 1").is_some());
    assert!(difference("1 2", "1 2 3").is_some());
    assert!(difference("3e-14", "-2e-13").is_none());
    assert_eq!(
        masked("{\"wall_s\": 3.1, \"u\": 2} in 0.12 s, of", Path::new("/none")),
        "{\"wall_s\": ~, \"u\": 2} in ~ s, of"
    );
}
