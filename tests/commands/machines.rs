//! What another machine changes: vector instructions nothing, the system's `sin`, `cos` and `powf`
//! the last bits.

use super::program::{command, numbers, printed, refused};
use hertzchain::run::method::Method;
use hertzchain_integrators::Instructions;
use serde_json::Value;
use std::{fs, path::Path};

/// Makes the system's library take its code for processors without fused multiplication; systems
/// without GNU's library ignore it.
const NARROW_LIBRARY: (&str, &str) =
    ("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX2_Usable,-FMA_Usable,-FMA4_Usable");

/// Whether [`NARROW_LIBRARY`] has an effect here: GNU's library, and fused multiplication to be
/// done without.
fn narrows() -> bool {
    #[cfg(all(target_os = "linux", target_env = "gnu", target_arch = "x86_64"))]
    return std::is_x86_feature_detected!("fma");
    #[cfg(not(all(target_os = "linux", target_env = "gnu", target_arch = "x86_64")))]
    false
}

/// Every force law has its own kernel: 1.5 is a root, 1.7 is the library's power.
fn scene(alpha: f64, rho: &str) -> String {
    format!(
        "name = \"pulled\"\n[chain]\nsites = 23\nalpha = {alpha}\nkappa = 1.0\nrho = {rho}\nboundary = \"free\"\n\
         [initial]\nkind = \"single-bead\"\nsite = 0\ndisplacement = -0.1\n[span]\nperiods = 8\n[record]\nsamples = 0\n"
    )
}

/// The bits of the final state, which is printed with 17 digits.
fn end(scene: &Path, method: Method, more: &[&str], environment: Option<(&str, &str)>) -> Vec<u64> {
    let accuracy = if method.adaptive() { ["--tol", "1e-10"] } else { ["--steps-per-period", "64"] };
    let mut command = command("run");
    command.arg(scene).args(["--json", "--integrator", &method.name()]).args(accuracy).args(more);
    let run: Value = serde_json::from_str(&printed(command.envs(environment).output().unwrap())).unwrap();
    ["u", "v", "pu", "pv"].into_iter().flat_map(|key| numbers(&run[key])).map(f64::to_bits).collect()
}

#[test]
fn every_set_of_instructions_has_the_same_bits_and_another_library_changes_the_last_ones() {
    let folder = tempfile::tempdir().unwrap();
    let sets: Vec<String> =
        Instructions::ALL.into_iter().filter(|set| set.available()).map(|set| set.to_string()).collect();
    let mut changed = Vec::new();
    for (alpha, rho) in [(1.5, "inf"), (1.7, "3.0")] {
        let path = folder.path().join("scene.toml");
        fs::write(&path, scene(alpha, rho)).unwrap();
        for method in Method::all() {
            let ends: Vec<Vec<u64>> =
                sets.iter().map(|set| end(&path, method, &["--instructions", set], None)).collect();
            for (set, other) in sets.iter().zip(&ends) {
                assert_eq!(*other, ends[0], "{} and {set} differ: {}, alpha = {alpha}", sets[0], method.name());
            }
            if alpha == 1.7 {
                let (here, there) = (&ends[0], end(&path, method, &[], Some(NARROW_LIBRARY)));
                let apart = |(x, y): (&u64, &u64)| (f64::from_bits(*x) - f64::from_bits(*y)).abs();
                let difference = here.iter().zip(&there).map(apart).fold(0.0, f64::max);
                // Beads are at 0.2 at most. Measured: 6e-17 with fixed steps, 1.4e-15 with adaptive
                // ones, which hang on the last bit.
                let bound = if method.adaptive() { 3e-15 } else { 1.5e-16 };
                assert!(difference < bound, "{}: {difference:e}", method.name());
                changed.extend((difference > 0.0).then(|| method.name()));
            }
        }
    }
    println!("the other library changes {changed:?}");
    assert!(!narrows() || !changed.is_empty(), "the other library changes nothing");
}

#[test]
fn a_set_that_is_not_there_is_refused() {
    let message = refused("scenes --instructions sse9", 2);
    assert!(message.contains("sse9") && message.contains("portable, avx2, avx512"), "{message}");
    for set in Instructions::ALL.into_iter().filter(|set| !set.available()) {
        let message = refused(&format!("scenes --instructions {set}"), 2);
        assert!(message.contains("this machine does not have them"), "{message}");
    }
}
