//! Travelling waves launched into a chain from one end.

use hertzchain::study::{BoundaryWave, LaunchedWave, Study};

/// Excess of the frequency that the first-order wave of this wave number would have, over that of
/// the drive, in units of the detuning.
fn excess(wave: &LaunchedWave) -> f64 {
    let [measured, theory] = [wave.q, wave.q_theory.unwrap()].map(|q| (0.5 * q).sin().powi(2));
    measured / theory - 1.0
}

#[test]
fn weak_waves_have_the_wave_number_of_the_linear_chain() {
    // Truth: 2 k (1 - cos q) = omega^2 + kappa rho omega^2/(kappa - rho omega^2) of beads on
    // springs k = alpha g_0^{alpha-1}, with resonators.
    let study = BoundaryWave { drive: 1e-4, ..BoundaryWave::default() };
    let (k, rho): (f64, f64) = (1.5 * 0.05_f64.sqrt(), 1.0 / 3.0);
    for omega in [2.006_f64, 2.02] {
        let square = omega * omega;
        let want = (1.0 - (square + rho * square / (1.0 - rho * square)) / (2.0 * k)).acos();
        let (wave, _) = study.wave(omega).unwrap();
        println!("{omega}: {} {want}, {:e}, spread {:e}", wave.q, wave.q / want - 1.0, wave.spread);
        assert!((wave.q / want - 1.0).abs() < 1e-3, "{} {want}", wave.q);
        assert!(!wave.opens && (wave.mean_strain + 0.05).abs() < 1e-5);
    }
}

#[test]
#[ignore = "nightly: eighteen seconds"]
fn the_first_order_wave_errs_by_the_square_root_of_its_size() {
    // Overlaps and amplitudes to a quarter, detunings to half: theory errs by epsilon^(alpha - 1).
    let excess = |size: f64| {
        let options = BoundaryWave { drive: 0.05 * size, overlap: 0.05 * size, ..BoundaryWave::default() };
        let (wave, _) = options.wave(2.0 + 0.008 * size.sqrt()).unwrap();
        println!("{size}: q = {}, {:e}, spread {}", wave.q, excess(&wave), wave.spread);
        excess(&wave)
    };
    let (coarse, fine) = (excess(1.0), excess(0.25));
    assert!((coarse / fine / 2.0 - 1.0).abs() < 0.15, "{coarse} {fine}");
}

#[test]
fn numbers_outside_their_rules_are_refused() {
    let default = BoundaryWave::default;
    for (study, omega, rule) in [
        (BoundaryWave { sites: 79, ..default() }, 2.01, "sites = 79 is not valid"),
        (BoundaryWave { overlap: 0.0, ..default() }, 2.01, "overlap = 0 is not valid"),
        (BoundaryWave { drive: f64::NAN, ..default() }, 2.01, "drive = NaN is not valid"),
        (default(), 2.0, "omegas = 2 is not valid"),
        (default(), 2.1, "omegas = 2.1 is not valid"),
        (default(), 2.0 + 1e-7, "omegas = 2.0000001 is not valid: the wave is so slow"),
        (BoundaryWave { overlap: 1e300, ..default() }, 2.01, "overlap = 1e300 is not valid: contacts are at most 100"),
        (BoundaryWave { drive: 1e200, ..default() }, 2.01, "drive = 1e200 is not valid: from 1e-10 to 100"),
        (BoundaryWave { drive: f64::MAX, ..default() }, 2.01, "drive = 1.797"),
    ] {
        let study = BoundaryWave { omegas: vec![omega], ..study };
        assert!(study.begin().is_err(), "refused before a folder is made");
        let message = study.wave(omega).unwrap_err().to_string();
        assert!(message.starts_with(rule), "{message}");
    }
}
