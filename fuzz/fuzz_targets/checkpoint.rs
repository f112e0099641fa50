//! Checkpoints: any bytes give a run that can continue, or an error that names file, member and
//! rule.
//!
//! A zip archive with an altered byte fails a checksum, and the code after that check would not be
//! reached. Therefore the first byte determines how the others are read: as an archive, or as the
//! settings of an archive, a zero byte, and its doubles.

#![no_main]

use hertzchain::{
    Error,
    output::{Archive, Array, npz_with},
    scene::{Initial, SceneFile},
    study::LongRun,
};
use libfuzzer_sys::{Corpus, fuzz_target};
use serde_json::Value;
use std::path::Path;

/// Largest number of sites, samples and profiles; longer chains take more time and test nothing
/// else.
const MOST: usize = 50;
/// Largest count of numbers per site: position and velocity of the bead and of its resonator.
const NUMBERS: u64 = 4;

/// Count of numbers per contact.
const CONTACT: u64 = 13;

/// Largest count of numbers of contacts that have not ended.
const MOST_OPEN: u64 = 1000;

fn settings(bytes: &[u8]) -> (String, &[u8]) {
    let cut = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    (String::from_utf8_lossy(&bytes[..cut]).into_owned(), bytes[cut..].get(1..).unwrap_or_default())
}

fn scene(json: &Value) -> Option<SceneFile> {
    SceneFile::parse(json.pointer("/scene")?.as_str()?, "fuzz").ok()
}

fn archive(settings: &str, json: &Value, doubles: &[u8]) -> Vec<u8> {
    let length = |pointer: &str| json.pointer(pointer).and_then(Value::as_u64).unwrap_or(1).min(MOST as u64);
    let (samples, profiles, contacts) = (length("/samples"), length("/profiles"), length("/contacts"));
    let open = json.pointer("/open_contacts").and_then(Value::as_u64).unwrap_or(0).min(MOST_OPEN);
    // The state has the length that the scene needs, if known, so that the code after the check of
    // lengths is reached.
    let (sites, light) = scene(json).map_or((1, false), |file| {
        let rho = file.chain.rho;
        (file.chain.sites as u64, rho == 0.0 || rho.is_infinite() || file.chain.kappa == 0.0)
    });
    let dim = sites.min(MOST as u64) * if light { NUMBERS / 2 } else { NUMBERS };
    let mut doubles = doubles.chunks_exact(8).map(|chunk| f64::from_le_bytes(chunk.try_into().expect("eight bytes")));
    let mut array = |name: &'static str, shape: &[u64]| {
        let values = (0..shape.iter().product()).map(|_| doubles.next().unwrap_or(0.1)).collect();
        Array { name, shape: shape.to_vec(), values }
    };
    let arrays = [
        array("state", &[dim]),
        array("largest", &[1]),
        array("sample_t", &[samples]),
        array("energies", &[4 * samples]),
        array("profile_t", &[profiles]),
        array("profiles", &[profiles, dim]),
        array("contacts", &[contacts, CONTACT]),
        array("open_contacts", &[open]),
        array("extremes", &[0, 2]),
    ];
    npz_with("settings.json", settings, &arrays).expect("an archive in memory")
}

fuzz_target!(|bytes: &[u8]| -> Corpus {
    let made;
    let bytes = match bytes.split_first() {
        Some((b'P', _)) | None => bytes,
        Some((_, rest)) => {
            let (settings, doubles) = settings(rest);
            let json: Value = serde_json::from_str(&settings).unwrap_or_default();
            // Profiles of breathers are computed with many digits, which takes long.
            if scene(&json).is_some_and(|file| {
                file.chain.sites > MOST && file.chain.sites < 100_000_000
                    || matches!(file.initial, Initial::BrightBreather { .. })
            }) {
                return Corpus::Reject;
            }
            made = archive(&settings, &json, doubles);
            &made
        }
    };
    let path = Path::new("fuzz.npz");
    match Archive::from_bytes(path, bytes).and_then(|archive| LongRun::from_archive(&archive, None)) {
        Ok(run) => {
            assert!(run.time() > 0.0 && run.time() <= run.scene().end());
            // The run, written and read again, is the same.
            let again = run.npz().expect("what was read can be written");
            let again = Archive::from_bytes(path, &again).and_then(|archive| LongRun::from_archive(&archive, None));
            assert_eq!(format!("{run:?}"), format!("{:?}", again.expect("a run")));
        }
        Err(error) => {
            let message = error.to_string();
            if matches!(error, Error::File { .. }) {
                // What parts have written is in files beside it, which are not there.
                assert!(message.contains("parts"), "{message}");
                return Corpus::Keep;
            }
            assert!(matches!(error, Error::Content { .. }), "{message}");
            assert!(message.starts_with("fuzz.npz, ") && message.lines().count() == 1, "{message}");
        }
    }
    Corpus::Keep
});
