//! The program, run as people and machines run it.
#![allow(dead_code, reason = "each binary of tests uses some of it")]

use serde_json::Value;
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
    process::{Child, Command, Output},
    thread::sleep,
    time::Duration,
};

pub(crate) const PROGRAM: &str = env!("CARGO_BIN_EXE_hertzchain");

/// A command line: its words, or a text with single spaces between them.
pub(crate) trait Line {
    fn words(&self) -> Vec<&str>;
}

impl Line for str {
    fn words(&self) -> Vec<&str> {
        self.split(' ').collect()
    }
}

impl Line for String {
    fn words(&self) -> Vec<&str> {
        self.as_str().words()
    }
}

impl Line for [&str] {
    fn words(&self) -> Vec<&str> {
        self.to_vec()
    }
}

impl<const N: usize> Line for [&str; N] {
    fn words(&self) -> Vec<&str> {
        self.to_vec()
    }
}

impl Line for Vec<&str> {
    fn words(&self) -> Vec<&str> {
        self.clone()
    }
}

pub(crate) fn command(line: &(impl Line + ?Sized)) -> Command {
    let mut command = Command::new(PROGRAM);
    command.args(line.words());
    command
}

pub(crate) fn hertzchain(line: &(impl Line + ?Sized)) -> Output {
    command(line).output().unwrap()
}

/// What a process that succeeded has printed.
pub(crate) fn printed(output: Output) -> String {
    assert!(output.status.success(), "{:?}: {}", output.status, String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// What the program prints, which must succeed.
pub(crate) fn stdout(line: &(impl Line + ?Sized)) -> String {
    let output = hertzchain(line);
    assert!(output.status.success(), "{:?}: {}", line.words(), String::from_utf8_lossy(&output.stderr));
    printed(output)
}

/// Its result, with `--json` or without it in the line.
pub(crate) fn json(line: &(impl Line + ?Sized)) -> Value {
    let mut words = line.words();
    if !words.contains(&"--json") {
        words.push("--json");
    }
    serde_json::from_str(&stdout(&words)).unwrap()
}

/// What it says where it ends with this exit code and without a result. A panic has the code 101,
/// a killed process has none.
pub(crate) fn refused(line: &(impl Line + ?Sized), code: i32) -> String {
    let output = hertzchain(line);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{:?}: {said}", line.words());
    // That of a command line that cannot be read goes on with its usage.
    let short = said.lines().count() == 1 || said.contains("--help");
    assert!(output.stdout.is_empty() && said.starts_with("error: ") && short, "{:?}: {said}", line.words());
    said
}

/// A file of JSON.
pub(crate) fn read_json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// The head and the rows of a table of numbers.
pub(crate) fn table(path: &Path) -> (String, Vec<Vec<f64>>) {
    let text = fs::read_to_string(path).unwrap();
    let (head, rows) = text.split_once('\n').unwrap();
    let row = |line: &str| line.split(',').map(|cell| cell.parse().unwrap()).collect();
    (head.to_owned(), rows.lines().map(row).collect())
}

/// The number at a place of a result, as in `/points/0/omega`.
pub(crate) fn number(value: &Value, place: &str) -> f64 {
    value.pointer(place).and_then(Value::as_f64).unwrap_or_else(|| panic!("{place}"))
}

pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

/// The names in a folder.
pub(crate) fn names(folder: &Path) -> BTreeSet<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

/// Number of lines of a store that may be written at the same time.
pub(crate) fn lines(store: &Path) -> usize {
    fs::read(store).map_or(0, |text| text.iter().filter(|byte| **byte == b'\n').count())
}

/// Waits until a process has kept so many lines, or has ended.
pub(crate) fn wait(process: &mut Child, store: &Path, count: usize) {
    while lines(store) < count && process.try_wait().unwrap().is_none() {
        sleep(Duration::from_millis(1));
    }
}

/// Asks a process to end.
pub(crate) fn terminate(process: &Child) {
    assert!(Command::new("kill").args(["-TERM", &process.id().to_string()]).status().unwrap().success());
}

/// A command under limits of the shell.
pub(crate) fn limited(limit: &str, line: &str) -> Output {
    let script = format!("{limit}; exec \"$0\" \"$@\"");
    Command::new("sh").args(["-c", &script, PROGRAM]).args(line.split(' ')).output().unwrap()
}

/// The files of a folder, not of those in it, but for how long things took, and for Newton's steps,
/// which the file of a branch leaves out. A checkpoint holds times too: it is compared by what
/// comes of it.
pub(crate) fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let timed = |line: &&str| ["\"wall_s\"", "\"sampling_s\"", "\"newton\""].iter().any(|key| line.contains(key));
    let names = names(folder).into_iter().filter(|name| folder.join(name).is_file() && name != "checkpoint.npz");
    let content = |name: String| match fs::read(folder.join(&name)).unwrap() {
        json if name.ends_with(".json") => {
            let text = String::from_utf8(json).unwrap();
            (name, text.lines().filter(|line| !timed(line)).collect::<String>().into_bytes())
        }
        bytes => (name, bytes),
    };
    names.map(content).collect()
}
