//! Files of driven branches: any bytes give a scene and a branch whose numbers are all within their
//! rules, or an error that names file, member and rule.
//!
//! A zip archive with an altered byte fails a checksum, and the code after that check would not be
//! reached. Therefore the first byte determines how the others are read: as an archive, or as the
//! settings of an archive, a zero byte, and its doubles.

#![no_main]

use hertzchain::{
    Error,
    orbits::{DrivenContinuation, DrivenSetting},
    output::{Archive, Array, npz_with},
    scene::{Initial, Scene, SceneFile},
    study::{branch_from_archive, branch_npz},
};
use libfuzzer_sys::{Corpus, fuzz_target};
use serde_json::Value;
use std::path::Path;

/// Largest number of sites; longer chains take more time and test nothing else.
const MOST_SITES: usize = 20;

fn settings(bytes: &[u8]) -> (String, &[u8]) {
    let cut = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    (String::from_utf8_lossy(&bytes[..cut]).into_owned(), bytes[cut..].get(1..).unwrap_or_default())
}

/// The number of unknowns that the scene needs, if known, so that the code after the check of
/// shapes is reached.
fn unknowns(json: &Value, file: SceneFile) -> Option<usize> {
    let turns = json.pointer("/setting/turns")?.as_u64()?;
    let scene = Scene::build(file).ok()?;
    Some(DrivenSetting::new(scene.chain(), u32::try_from(turns).ok()?).ok()?.unknowns())
}

fn archive(settings: &str, json: &Value, file: Option<SceneFile>, doubles: &[u8]) -> Vec<u8> {
    let points = json.pointer("/points").and_then(Value::as_u64).unwrap_or(1).min(9);
    let unknowns = file.and_then(|file| unknowns(json, file)).unwrap_or(1) as u64;
    let mut doubles = doubles.chunks_exact(8).map(|chunk| f64::from_le_bytes(chunk.try_into().expect("eight bytes")));
    let mut array = |name: &'static str, shape: &[u64]| {
        let values = (0..shape.iter().product()).map(|_| doubles.next().unwrap_or(0.1)).collect();
        Array { name, shape: shape.to_vec(), values }
    };
    let arrays = [array("parameter", &[points]), array("residual", &[points]), array("z", &[points, unknowns])];
    npz_with("settings.json", settings, &arrays).expect("an archive in memory")
}

fuzz_target!(|bytes: &[u8]| -> Corpus {
    let made;
    let bytes = match bytes.split_first() {
        Some((b'P', _)) | None => bytes,
        Some((_, rest)) => {
            let (settings, doubles) = settings(rest);
            let json: Value = serde_json::from_str(&settings).unwrap_or_default();
            let scene = json.pointer("/setting/scene").and_then(Value::as_str);
            let scene = scene.and_then(|text| SceneFile::parse(text, "fuzz").ok());
            // Absurd sizes are refused before memory is allocated; large but allowed sizes are left
            // out here. Profiles of breathers are computed with many digits, which takes long.
            if scene.as_ref().is_some_and(|file| {
                (MOST_SITES..=100_000_000).contains(&file.chain.sites)
                    || matches!(file.initial, Initial::BrightBreather { .. })
            }) {
                return Corpus::Reject;
            }
            made = archive(&settings, &json, scene, doubles);
            &made
        }
    };
    let path = Path::new("fuzz.npz");
    match Archive::from_bytes(path, bytes).and_then(|archive| branch_from_archive::<DrivenContinuation>(&archive)) {
        Ok((scene, trail)) => {
            assert!(!trail.orbits.is_empty() && trail.ds.is_finite() && trail.ds > 0.0);
            for orbit in &trail.orbits {
                orbit.setting.chain().expect("a setting within its rules");
                assert!(orbit.z.len() == orbit.setting.unknowns() && orbit.z.iter().all(|z| z.is_finite()));
                assert!(orbit.setting.period().is_finite() && orbit.setting.period() > 0.0);
            }
            // The branch, written and read again, is the same.
            let again = branch_npz(&scene, &trail).expect("what was read can be written");
            let again = Archive::from_bytes(path, &again).and_then(|archive| branch_from_archive::<DrivenContinuation>(&archive));
            let (scene_again, trail_again) = again.expect("a branch");
            assert_eq!(scene_again.file(), scene.file());
            assert_eq!(format!("{trail:?}"), format!("{trail_again:?}"));
        }
        Err(error) => {
            let message = error.to_string();
            assert!(matches!(error, Error::Content { .. }), "{message}");
            assert!(message.starts_with("fuzz.npz, ") && message.lines().count() == 1, "{message}");
        }
    }
    Corpus::Keep
});
