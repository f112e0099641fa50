//! Stores of a sweep: any bytes give lines of this study without an incomplete last line, or an
//! error that names file, line and rule and leaves the file unchanged.
//!
//! Each line has a checksum, and the code after its check would not be reached. Therefore the first
//! byte determines whether the others are a file, or lines without checksums, which are then added.

#![no_main]

use hertzchain::{Error, output::Folder, sweep::Store};
use libfuzzer_sys::fuzz_target;
use std::{cell::LazyCell, fs, path::Path};
use tempfile::TempDir;

const NAME: &str = "fuzz.store";

thread_local! {
    /// A folder in memory, if the system has such a place.
    static FOLDER: LazyCell<(TempDir, Folder)> = LazyCell::new(|| {
        let memory = Path::new("/dev/shm");
        let made = if memory.is_dir() { TempDir::new_in(memory) } else { TempDir::new() }.expect("a folder");
        let folder = Folder::create(made.path()).expect("a folder");
        (made, folder)
    });
}

fn fnv(from: u64, text: &[u8]) -> u64 {
    text.iter().fold(from, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// The lines, each with its checksum.
fn checked(lines: &[u8]) -> Vec<u8> {
    let (basis, mut out) = (0xcbf2_9ce4_8422_2325, Vec::new());
    let mut from = basis;
    for (k, line) in lines.split_inclusive(|&byte| byte == b'\n').enumerate() {
        let json = line.strip_suffix(b"\n").unwrap_or(line);
        let check = fnv(from, json);
        out.extend(format!("{check:016x} ").bytes().chain(line.iter().copied()));
        from = if k == 0 { check } else { from };
    }
    out
}

fuzz_target!(|bytes: &[u8]| {
    let bytes = match bytes.split_first() {
        Some((b'#', lines)) => checked(lines),
        _ => bytes.to_vec(),
    };
    FOLDER.with(|both| {
        let (made, folder) = &**both;
        let path = made.path().join(NAME);
        fs::write(&path, &bytes).expect("a file");
        match Store::open(folder, NAME, "roots", &serde_json::json!({"alpha": 1.5})) {
            Ok(store) => {
                let (lines, left) = (store.len(), fs::read(&path).expect("a file"));
                drop(store);
                assert!(left.ends_with(b"\n") && (left.starts_with(&bytes) || bytes.starts_with(&left)));
                assert_eq!(left.iter().filter(|&&byte| byte == b'\n').count(), lines + 1);
            }
            Err(error) => {
                assert!(
                    matches!(error, Error::Content { .. }) && error.to_string().contains("fuzz.store, line "),
                    "{error}"
                );
                assert_eq!(fs::read(&path).expect("a file"), bytes, "{error}");
            }
        }
    });
});
