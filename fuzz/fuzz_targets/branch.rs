//! Branch files: any bytes give a branch whose numbers are all within their rules, or an error that
//! names file, member and rule.
//!
//! A zip archive with an altered byte fails a checksum, and the code after that check would not be
//! reached. Therefore the first byte determines how the others are read: as an archive, or as the
//! settings of an archive, a zero byte, and its doubles.

#![no_main]

use hertzchain::{
    Error,
    orbits::Continuation,
    output::{Archive, Array, npz_with},
    study::{branch_from_archive, branch_npz},
};
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fn archive(bytes: &[u8]) -> Vec<u8> {
    let cut = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    let settings = String::from_utf8_lossy(&bytes[..cut]);
    let json: serde_json::Value = serde_json::from_str(&settings).unwrap_or_default();
    let length = |pointer: &str| json.pointer(pointer).and_then(serde_json::Value::as_u64).unwrap_or(1).min(9);
    let (points, sites) = (length("/points"), length("/setting/sites"));
    let mut doubles = bytes[cut..]
        .get(1..)
        .unwrap_or_default()
        .chunks_exact(8)
        .map(|chunk| f64::from_le_bytes(chunk.try_into().expect("eight bytes")));
    let mut array = |name: &'static str, shape: &[u64]| {
        let values = (0..shape.iter().product()).map(|_| doubles.next().unwrap_or(0.1)).collect();
        Array { name, shape: shape.to_vec(), values }
    };
    let arrays = [
        array("parameter", &[points]),
        array("residual", &[points]),
        array("x", &[points, sites]),
        array("y", &[points, sites]),
    ];
    npz_with("settings.json", &settings, &arrays).expect("an archive in memory")
}

fuzz_target!(|bytes: &[u8]| {
    let made;
    let bytes = match bytes.split_first() {
        Some((b'P', _)) | None => bytes,
        Some((_, rest)) => {
            made = archive(rest);
            &made
        }
    };
    let path = Path::new("fuzz.npz");
    match Archive::from_bytes(path, bytes).and_then(|archive| branch_from_archive::<Continuation>(&archive)) {
        Ok(((), trail)) => {
            assert!(!trail.orbits.is_empty() && trail.ds.is_finite() && trail.ds > 0.0);
            for orbit in &trail.orbits {
                orbit.setting.chain().expect("a setting within its rules");
                assert!(orbit.z.len() == 2 * orbit.setting.sites && orbit.z.iter().all(|z| z.is_finite()));
            }
            // The branch, written and read again, is the same.
            let again = branch_npz(&(), &trail).expect("what was read can be written");
            let again = Archive::from_bytes(path, &again).and_then(|archive| branch_from_archive::<Continuation>(&archive));
            let ((), again) = again.expect("a branch");
            assert_eq!(format!("{trail:?}"), format!("{again:?}"));
        }
        Err(error) => {
            assert!(matches!(error, Error::Content { .. }) && error.to_string().starts_with("fuzz.npz, "), "{error}");
        }
    }
});
