//! Moving dark breathers as relative periodic orbits.

use hertzchain::{
    Chain, Method, Run, State,
    breathers::{Band, Envelope, LinearWaves, MovingBreather, MovingOrbit},
    chain::{Params, Site},
    integrators::{
        Stepper,
        collocation::{StepControl, Tangent},
    },
    orbits::Kind,
    study::Barrier,
    sweep::Engine,
};
use nalgebra::{Complex, DMatrix};
use std::sync::OnceLock;

const TOL: f64 = 1e-14;

fn breather(sites: usize, omega_b: f64, turns: u32) -> MovingBreather {
    MovingBreather { params: Params::new(1.5, 1.0, 1.0 / 3.0).unwrap(), sites, omega_b, turns }
}

/// One of 21 sites, computed once.
fn orbit() -> &'static MovingOrbit {
    static ORBIT: OnceLock<MovingOrbit> = OnceLock::new();
    ORBIT.get_or_init(|| breather(21, 2.094, 11).orbit(TOL).unwrap())
}

/// `max |S^{-1} end - z|` over the strains, in units of the largest.
fn returned(orbit: &MovingOrbit, end: &[f64]) -> f64 {
    let n = orbit.setting.sites;
    let size = orbit.z[..n].iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    (0..n).map(|i| (end[(i + 1) % n] - orbit.z[i]).abs() / size).fold(0.0, f64::max)
}

/// The strains at `t` by a method.
fn strains_at(chain: &Chain<f64>, z: &[f64], t: f64, method: &str, tol: f64) -> Vec<f64> {
    let n = chain.sites();
    let site = |i: usize| Site { u: z[i], v: z[n + i], u_dot: z[2 * n + i], v_dot: z[3 * n + i] };
    let run = Run::new(chain.clone(), State::from_fn(chain, site).unwrap()).until(t).unwrap();
    let run = run.method(Method::named(method).unwrap()).tolerance(tol).unwrap();
    let end = run.at(&[t]).unwrap().next().unwrap().unwrap();
    end.u().to_vec()
}

// Truth: the definition, x_{n+1}(t + T_m) = x_n(t), by a method of another family, which knows no
// reversal. The kink of a breather at rest would be 1 off.
#[test]
fn a_moving_breather_comes_back_a_site_further_by_another_method() {
    let orbit = orbit();
    assert!(orbit.residual < 1e-12 && orbit.return_error(TOL).unwrap() < 1e-11);
    let chain = orbit.setting.chain().unwrap();
    let end = strains_at(&chain, &orbit.z, orbit.setting.passage(), "dop853-regularised", 1e-14);
    let end = returned(orbit, &end);
    println!("{end:e}");
    assert!(end < 1e-10, "{end:e}");
}

// Truth: the eigenvalues of S^{-1} M(T_m), with the tangent map over the whole time, by another
// eigensolver.
#[test]
fn relative_multipliers_are_those_of_the_whole_passage() {
    let orbit = orbit();
    let (n, size) = (orbit.setting.sites, orbit.z.len());
    let spectrum = orbit.spectrum(TOL).unwrap();
    let chain = orbit.setting.chain().unwrap();
    let mut run = chain.collocation(&orbit.z, (0.0, orbit.setting.passage()), StepControl::Tolerance(TOL)).unwrap();
    let mut tangent = Tangent::identity(&run).unwrap();
    while !run.done() {
        run.step().unwrap();
        tangent.follow(&run).unwrap();
    }
    let whole = DMatrix::from_column_slice(size, size, &tangent.matrix(&run).unwrap());
    let relative = DMatrix::from_fn(size, size, |i, j| whole[(i / n * n + (i % n + 1) % n, j)]);
    let eigenvalues = relative.complex_eigenvalues();
    for one in spectrum.multipliers.iter().filter(|one| one.kind != Kind::Trivial) {
        let apart = eigenvalues.iter().map(|other| (other.re - one.re).hypot(other.im - one.im));
        let apart = apart.fold(f64::INFINITY, f64::min) / one.modulus.max(1.0);
        assert!(apart < 1e-6, "{one:?}: {apart:e}");
    }
    // Four trivial ones, and products of pairs that are 1.
    let logs: f64 = spectrum.multipliers.iter().map(|one| one.modulus.ln()).sum();
    assert!(logs.abs() < 1e-9 && spectrum.quality.symplectic_defect < 1e-10);
    let trivial = spectrum.multipliers.iter().filter(|one| one.kind == Kind::Trivial).count();
    assert_eq!(trivial, 4);
}

// Truth: another seed, and the way of the kink: the local amplitudes are least at the middle bond,
// and a passage later a site to the right of it.
#[test]
fn seeds_of_other_velocities_lead_to_the_same_orbit_which_moves_to_the_right() {
    let breather = breather(21, 2.094, 11);
    let rest = breather.at_rest().orbit(&Default::default()).unwrap();
    let found: Vec<MovingOrbit> =
        [0.1, 0.15, 0.21].iter().filter_map(|&twist| breather.solve(&breather.seed(&rest, twist), TOL).ok()).collect();
    assert!(found.len() > 1, "{}", found.len());
    let best = orbit();
    let same = |orbit: &&MovingOrbit| orbit.z.iter().zip(&best.z).all(|(a, b)| (a - b).abs() < 1e-8);
    assert!(found.iter().filter(same).count() > 1);
    let envelope = best.envelope(1e-12).unwrap();
    let order: Vec<usize> = (0..21).filter(|&i| envelope.amplitude[i] < 0.8 * envelope.background).collect();
    assert!(order.contains(&10) && order.contains(&11) && order.len() <= 4, "{order:?}");
    assert!(envelope.tail < 0.02 && (0.3..0.7).contains(&envelope.depth), "{envelope:?}");
}

// Truth: the dispersion of linear waves about the background alone, computed on a ring without a
// kink. The number of far sites resolves wave numbers to about 0.1 pi; measured: 0.003 pi apart.
// The resonances of kinks of other velocities are 0.05 pi away.
#[test]
fn the_tail_is_the_modulation_of_the_background_that_has_the_velocity_of_the_kink() {
    let orbit = breather(21, 2.05, 22).orbit(1e-13).unwrap();
    let tail = orbit.envelope(1e-12).unwrap().tail_wave();
    let waves = LinearWaves::new(orbit.setting.params, 2.05 + tail.twist / orbit.setting.passage()).unwrap();
    let at = |turns: u32| {
        let found = waves.resonant(breather(21, 2.05, turns).passage());
        let found: Vec<f64> =
            found.iter().filter(|wave| wave.band == Band::Modulation).map(|wave| wave.wave_number).collect();
        assert_eq!(found.len(), 1, "{found:?}");
        (found[0] - tail.wave_number).abs() / std::f64::consts::PI
    };
    println!("{tail:?} {} {}", at(22), at(24));
    assert!(at(22) < 0.02 && at(24) > 0.04, "{tail:?}: {} {}", at(22), at(24));
    assert!(tail.share > 0.7 && tail.amplitude.abs() > 1e-3, "{tail:?}");
}

// Truth: the breather at rest in the study of the barrier, whose background is an orbit of a ring
// and whose action is an integral over half a period.
#[test]
fn energies_of_a_kink_at_rest_are_those_of_the_barrier() {
    let mut barrier = Barrier::of(1.0 / 3.0, [2.05, 2.06], 2);
    barrier.ring.sites = 15;
    let study = barrier.study(&Engine::threads(), &|_, _| {}).unwrap();
    // About a site: the kinetic energy is then even about a quarter of a period as well.
    let kink = &study.points[0].kinks[0];
    let z = kink.orbit.start();
    let still = MovingOrbit { setting: breather(15, 2.05, 22), z, residual: 0.0, newton: Vec::new() };
    let found = still.kink_energy(0.0, 1e-13).unwrap();
    let free = kink.kink_energy - 2.05 * kink.kink_action;
    println!("{found:?} {} {free}", kink.kink_energy);
    assert!(
        (found.energy / kink.kink_energy - 1.0).abs() < 1e-8 && (found.free / free - 1.0).abs() < 1e-5,
        "{found:?}"
    );
}

// Truth: a tail that is put there, with its twist and the sign of an odd ring.
#[test]
fn a_wave_of_a_known_tail_is_found() {
    for (n, twist, p, height) in [(41, 0.021, 2.47, 0.01), (21, -0.05, 1.9, -0.003), (61, 0.013, 2.83, 0.002)] {
        let a = |i: usize| {
            let s = if 2 * i > n { i as f64 - n as f64 } else { i as f64 };
            let wave = Complex::new(1.0 + height * (p * s).cos(), 0.7 * height * (p * s).sin());
            wave * Complex::from_polar(if s < 0.0 { -0.3 } else { 0.3 }, twist * s)
        };
        let (amplitude, phase) = ((0..n).map(|i| a(i).norm()).collect(), (0..n).map(|i| a(i).arg()).collect());
        let envelope = Envelope { amplitude, phase, mean: vec![0.0; n], background: 0.3, depth: 0.0, tail: 0.0 };
        let tail = envelope.tail_wave();
        assert!((tail.twist - twist).abs() < 1e-6 && (tail.wave_number - p).abs() < 1e-3, "{tail:?}");
        assert!((tail.amplitude / height - 1.0).abs() < 0.05 && tail.share > 0.9999, "{tail:?}");
    }
}

// Truth: the definition.
#[test]
fn resonant_waves_keep_their_phase_in_the_frame() {
    let params = Params::new(1.5, 1.0, 1.0 / 3.0).unwrap();
    let waves = LinearWaves::new(params, 2.05).unwrap();
    let passage = 24.5 * 2.0 * std::f64::consts::PI / 2.05;
    let found = waves.resonant(passage);
    let modulations: Vec<_> = found.iter().filter(|wave| wave.band == Band::Modulation).collect();
    assert_eq!(modulations.len(), 1, "a kink that is slower than long modulations has one");
    for wave in &found {
        let turns = (wave.wave_number + wave.frequency * passage) / (2.0 * std::f64::consts::PI);
        assert!((turns - turns.round()).abs() < 1e-12 && wave.wave_number <= std::f64::consts::PI, "{wave:?}");
    }
}
