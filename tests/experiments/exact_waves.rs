//! Exact travelling waves: against another integrator, closed forms, the whole monodromy matrix, and
//! the modulation equations. `commands exact_waves_are_proved_and_lie_in_the_ball` holds them against
//! the Fourier series of their equation.

use crate::numbers::largest;
use hertzchain::{
    Run, State,
    chain::{Chain, Params, Site},
    integrators::collocation::{StepControl, monodromy},
    orbits::End,
    run::Method,
    study::{BranchOptions, ContinueWave, ExactStudy, FollowCommand, Wanted, WaveBranchStudy},
    sweep::Engine,
    waves::{Given, MeanStrain, Search, WaveKind, WaveNumber, WaveParameter, WaveSetting},
};
use nalgebra::{Complex, DMatrix};
use std::{f64::consts::PI, sync::OnceLock};

/// The companions of the first two scenes of Sec. 4.1.
fn companions() -> &'static [ExactStudy; 2] {
    static BOTH: OnceLock<[ExactStudy; 2]> = OnceLock::new();
    BOTH.get_or_init(|| ["tw-q15", "tw-q45"].map(|scene| Wanted::of(scene).study().unwrap()))
}

fn setting(rho: f64, q_over_pi: f64, sites: usize, omega_tw: f64, mean: MeanStrain) -> WaveSetting {
    let params = Params::new(1.5, 1.0, rho).unwrap();
    WaveSetting { params, q: WaveNumber::on_ring(q_over_pi, sites).unwrap(), omega_tw, mean }
}

fn branch(wanted: Wanted, vary: WaveParameter, to: f64) -> WaveBranchStudy {
    let wanted = Wanted { sites: Some(10), ..wanted };
    let branch = BranchOptions { to: Some(to), ..BranchOptions::default() };
    ContinueWave { wanted, vary, branch, ..ContinueWave::default() }.follow().unwrap()(&Engine::threads(), &|_, _| {})
        .unwrap()
}

// Truth: the definition, x_{n+1}(t + q/omega_tw) = x_n(t), by an integrator that shares no code
// with the one that found the wave, and by the same. Measured: 2.5e-12, the error of its steps, and
// below 1e-13.
#[test]
fn an_exact_wave_moves_on_by_a_site_in_the_time_q_over_omega_and_is_back_after_a_period() {
    for study in companions() {
        let wave = &study.wave;
        assert!(wave.residual < 1e-13, "{:e}", wave.residual);
        let chain = Chain::new(wave.setting.params, hertzchain::Boundary::StrainRing, 10).unwrap();
        let [x, y, vx, vy] = wave.on_ring(10);
        let state = State::from_fn(&chain, |n| Site { u: x[n], v: y[n], u_dot: vx[n], v_dot: vy[n] }).unwrap();
        let times = [wave.setting.q.q() / wave.setting.omega_tw, wave.setting.period()];
        for (method, within) in [("dop853-regularised", 1e-11), ("collocation", 1e-13)] {
            let run = Run::new(chain.clone(), state.clone()).until(times[1]).unwrap();
            let run = run.method(Method::named(method).unwrap()).tolerance(1e-14).unwrap();
            let states: Vec<_> = run.at(&times).unwrap().map(Result::unwrap).collect();
            let off = |state: &[f64], shift: usize| {
                let of = |n: usize, k: usize| state[10 * k + (n + shift) % 10];
                let entry = |n: usize| [of(n, 0) - x[n], of(n, 1) - y[n], of(n, 2) - vx[n], of(n, 3) - vy[n]];
                largest((0..10).flat_map(entry)) / wave.amplitude()
            };
            let apart = [off(states[0].as_slice(), 1), off(states[1].as_slice(), 0)];
            assert!(apart[0] < within && apart[1] < within, "{method}: {apart:?}");
        }
    }
}

// Truth: the next order of the expansion is epsilon^{alpha-1} smaller. Measured: 0.499 to 0.500 for
// E_x, 0.5 to 1e-3 for the growth.
#[test]
fn the_ansatz_and_its_growth_become_exact_like_the_root_of_the_size() {
    for rho in ["0.3333333333333333", "3"] {
        let of = |epsilon: &str| {
            let mut wanted = Wanted { sites: Some(10), ..Wanted::of("tw-rho3") };
            wanted.set.set = vec![format!("chain.rho={rho}"), format!("initial.epsilon={epsilon}")];
            let study = wanted.study().unwrap();
            let last = study.growth.last().unwrap();
            let errors = study.errors.unwrap();
            [errors[0], errors[1], last.exact / last.modulation.unwrap() - 1.0]
        };
        let [small, large] = ["1e-6", "1e-4"].map(of);
        for (small, large) in small.iter().zip(large) {
            let slope = (large / small).ln() / 100_f64.ln();
            assert!((slope - 0.5).abs() < 5e-3, "rho = {rho}: {slope}");
        }
    }
}

// Truth: the dispersion relation of the chain about a precompression, where each contact is a
// spring of stiffness alpha |mean|^{alpha-1}. The frequency differs by the square of the amplitude.
#[test]
fn small_waves_under_precompression_are_those_of_the_linear_chain() {
    let (mean, rho) = (-0.05_f64, 1.0 / 3.0);
    let stiffness = 1.5 * (-mean).sqrt() * 4.0 * (0.1 * PI).sin().powi(2);
    // rho w^4 - (rho stiffness + 1 + rho) w^2 + stiffness = 0, the optical branch.
    let half = 0.5 * (rho * stiffness + 1.0 + rho);
    let omega = ((half + (half * half - rho * stiffness).sqrt()) / rho).sqrt();
    let start = Wanted { mean: Some(mean), amplitude: Some(0.55), ..Wanted::of("tw-q15") };
    let study = branch(start, WaveParameter::Amplitude, 1e-3);
    let last = study.branch.points.last().unwrap();
    assert_eq!((study.branch.ended(), last.measures.closed), (End::Reached, 1.0));
    assert!((last.orbit.setting.omega_tw / omega - 1.0).abs() < 1e-6, "{} {omega}", last.orbit.setting.omega_tw);
    assert!((last.orbit.amplitude() - 1e-3).abs() < 1e-15);
    // On the way the contacts open, and the frequency has its least value above omega: a fold.
    let lowest = study.branch.points.iter().map(|one| one.orbit.setting.omega_tw).fold(f64::INFINITY, f64::min);
    assert!((2.0071..2.0073).contains(&lowest) && lowest < omega, "{lowest}");
    assert!(study.branch.points.iter().all(|one| one.orbit.residual < 1e-13), "all of the branch is solved");
}

// Truth: multipliers of the whole period are eigenvalues of the monodromy matrix of the ring, so
// M - e^{lambda T} is singular. Measured: 5e-13 and 1e-13.
#[test]
fn relative_multipliers_are_eigenvalues_of_the_monodromy_matrix() {
    for study in companions() {
        let wave = &study.wave;
        let chain = wave.setting.chain(10 / wave.setting.q.cell()).unwrap();
        let z: Vec<f64> = wave.on_ring(10).concat();
        let whole = monodromy(chain, &z, (0.0, wave.setting.period()), StepControl::Tolerance(1e-14)).unwrap();
        let matrix = DMatrix::from_column_slice(40, 40, &whole).map(Complex::from);
        let spectrum = wave.spectrum(10, &Search::default()).unwrap();
        assert_eq!(spectrum.multipliers.len(), 40);
        let mut product = Complex::from(1.0);
        for m in &spectrum.multipliers {
            let whole = (Complex::new(m.growth, m.frequency) * wave.setting.period()).exp();
            product *= whole;
            let shifted = &matrix - DMatrix::identity(40, 40) * whole;
            let least = shifted.singular_values().min();
            assert!(least < 2e-12, "{m:?}: {least:e}");
            let mu = Complex::from_polar(1.0, m.bloch)
                * (Complex::new(m.growth, m.frequency) * wave.setting.q.q() / wave.setting.omega_tw).exp();
            assert!((mu - Complex::new(m.re, m.im)).norm() < 1e-13, "{m:?}");
        }
        assert!((product - 1.0).norm() < 1e-11, "volume is conserved: {product}");
        let count = |kind| spectrum.multipliers.iter().filter(|m| m.kind == kind).count();
        assert_eq!([count(WaveKind::Trivial), count(WaveKind::Linear)], [4, 2]);
        let quality = spectrum.quality;
        let errors = [quality.symplectic_defect, quality.eigen_residual, quality.phase_shift, quality.trivial];
        assert!(largest(errors) < 2e-14 && quality.linear.max(quality.pairing) < 5e-13, "{quality:?}");
    }
}

// Truth: the paper has q = pi/5 unstable and q = 4 pi/5 neutral; the modulation equations have the
// band of growing wave numbers, and its edge is that of the exact wave to a wave number of the
// ring.
#[test]
fn modulations_grow_where_the_modulation_equations_say() {
    let [long, short] = companions();
    assert!(short.spectrum.fastest().is_none());
    let fastest = long.spectrum.fastest().unwrap();
    assert!(fastest.bloch == PI && fastest.frequency.abs() < 1e-13, "{fastest:?}");
    for row in &long.growth {
        let modulation = row.modulation.unwrap();
        assert_eq!(row.exact > 0.0, modulation > 0.0, "{row:?}");
        assert!((row.exact - modulation).abs() < 0.08 * row.exact.max(1e-300), "{row:?}");
    }
}

// Truth: Newton's method from the ansatz at the end of the branch, which has not been there before.
#[test]
fn branches_in_rho_kappa_and_alpha_end_at_the_wave_that_a_search_finds() {
    for (vary, to) in [(WaveParameter::Rho, 0.334), (WaveParameter::Kappa, 0.999), (WaveParameter::Alpha, 1.6)] {
        let wanted = Wanted { omega_tw: Some(2.001), mean: Some(0.02), ..Wanted::of("tw-q15") };
        let study = branch(wanted, vary, to);
        assert_eq!(study.branch.ended(), End::Reached, "{vary:?}");
        let last = &study.branch.points.last().unwrap().orbit;
        assert_eq!(vary.of(last), to);
        assert!(
            study.branch.points.iter().all(|one| one.orbit.residual <= 1e-12 && one.orbit.setting.omega_tw == 2.001)
        );
        let (direct, _) = Search::default().wave(&last.setting, Given::Frequency).unwrap();
        let apart = largest(last.z.iter().zip(&direct.z).map(|(a, b)| a - b)) / last.amplitude();
        println!("{vary:?}: {} waves, amplitude {}, apart {apart:e}", study.branch.points.len(), last.amplitude());
        assert!(apart < 1e-10, "{vary:?}: {apart:e}");
    }
}

// Truth: Newton's method for a wave of this amplitude, with the frequency as an unknown.
#[test]
fn branches_in_the_amplitude_end_at_the_wave_of_this_amplitude() {
    for to in [0.3, 1e-3] {
        let study = branch(Wanted::of("tw-q15"), WaveParameter::Amplitude, to);
        let last = &study.branch.points.last().unwrap().orbit;
        let (direct, _) = Search::default().wave(&last.setting, Given::Amplitude(to)).unwrap();
        let apart = largest(last.z.iter().zip(&direct.z).map(|(a, b)| a - b)) / to;
        let slower = last.setting.omega_tw - direct.setting.omega_tw;
        println!("{to}: {} waves, apart {apart:e}, {slower:e}", study.branch.points.len());
        assert!(study.branch.ended() == End::Reached && (last.amplitude() / to - 1.0).abs() < 1e-12);
        assert!(apart < 1e-10 && slower.abs() < 1e-12, "{to}: {apart:e} {slower:e}");
    }
}

// Truth: contacts of exponent 3/2 raise the frequency by the square root of the amplitude.
#[test]
fn a_branch_towards_the_linear_waves_ends_where_its_waves_vanish() {
    let study = branch(Wanted::of("tw-q15"), WaveParameter::OmegaTw, 1.9);
    assert_eq!(study.branch.ended(), End::Vanished);
    // It does not pass through the amplitude zero.
    let waves = study.branch.orbits.iter();
    assert!(waves.clone().all(|wave| wave.setting.omega_tw > 2.0 - 1e-9 && wave.amplitude() > 0.0));
    let curvature = |k: usize| {
        let wave = &study.branch.orbits[k];
        wave.amplitude() / (wave.setting.omega_tw - 2.0).powi(2)
    };
    let last = study.branch.orbits.len() - 1;
    assert!((curvature(last) / curvature(last - 3) - 1.0).abs() < 1e-3, "{} {}", curvature(last), curvature(last - 3));
}

// Truth: without contacts the frequency is omega, and contacts begin where the crest is as high as
// the mean strain is above zero.
#[test]
fn waves_under_a_gap_end_where_no_contact_closes() {
    let start = Wanted { mean: Some(0.05), ..Wanted::of("tw-q15") };
    let study = branch(start, WaveParameter::OmegaTw, 1.9);
    assert_eq!(study.branch.ended(), End::NoContact);
    let [.., before, last] = &study.branch.points[..] else { panic!("{} waves", study.branch.points.len()) };
    assert!(before.measures.closed > 0.0 && last.measures.closed == 0.0 && last.orbit.setting.omega_tw - 2.0 < 1e-10);
    // From wave to wave the state changes by at most a quarter of its size.
    assert!((1.0..1.25).contains(&(before.orbit.amplitude() / 0.05)), "{}", before.orbit.amplitude());
}

// Truth: scaling. Lengths by l and times by l^{-(alpha-1)/2} are the same chain with another kappa.
#[test]
fn waves_scale_as_the_model_does() {
    let search = Search::default();
    let solve = |kappa: f64, length: f64| {
        let setting = setting(2.0, 0.4, 10, 2.0, MeanStrain::Value(0.02 * length));
        let params = Params { kappa, ..setting.params };
        search.wave(&WaveSetting { params, ..setting }, Given::Amplitude(0.06 * length)).unwrap().0
    };
    let [one, other] = [solve(1.0, 1.0), solve(3.0, 9.0)];
    let off = one.z[..10].iter().zip(&other.z[..10]).map(|(one, other)| other / 9.0 - one);
    assert!(largest(off) < 1e-14, "strains");
    assert!((other.setting.omega_tw / one.setting.omega_tw - 3_f64.sqrt()).abs() < 1e-12);
    // The amplitude is as asked for, and a wave asked for by its frequency is the same.
    assert!((one.amplitude() - 0.06).abs() < 1e-15);
    let same = search.wave(&one.setting, Given::Frequency).unwrap().0;
    assert!((same.amplitude() - 0.06).abs() < 1e-11, "{}", same.amplitude());
}

/// The mean of Gauss of `a` and `b`.
fn agm(mut a: f64, mut b: f64) -> f64 {
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    a
}

// Truth: closed form. With q = pi and no mean strain x'' = -kappa x - 2 |x|^{alpha-1} x; at alpha =
// 3 this is Duffing's equation, omega = (kappa + 2 A^2)^{1/2} agm(1, ((kappa + A^2)/(kappa + 2
// A^2))^{1/2}).
#[test]
fn the_shortest_waves_of_the_plain_chain_and_of_the_cradle_have_their_closed_form() {
    for (rho, kappa, amplitude) in
        [(0.0, 0.0, 1.0), (0.0, 0.0, 0.03), (f64::INFINITY, 1.0, 0.1), (f64::INFINITY, 1.0, 1.0)]
    {
        let mut wanted = Wanted { rho: Some(rho), q_over_pi: Some(1.0), sites: Some(4), ..Wanted::of("tw-q15") };
        wanted.set.set = vec!["chain.alpha=3".to_owned()];
        let study = Wanted { amplitude: Some(amplitude), mean: Some(0.0), ..wanted }.study().unwrap();
        let square = kappa + 2.0 * amplitude * amplitude;
        let omega = square.sqrt() * agm(1.0, ((kappa + amplitude * amplitude) / square).sqrt());
        let found = study.wave.setting.omega_tw;
        assert!((found / omega - 1.0).abs() < 1e-12, "{rho} {amplitude}: {found} {omega}");
        assert!(study.ansatz.is_none() && study.errors.is_none() && study.wave.residual < 1e-13);
        assert!((study.profile.closed() - 0.5).abs() < 1e-12 && study.profile.y.is_empty());
    }
}

// Truth: the limits, which the chain has in code of its own: differences fall like rho and 1/rho.
#[test]
fn waves_of_light_and_of_heavy_resonators_have_the_plain_chain_and_the_cradle_as_limits() {
    let wanted = |rho: f64| Wanted { rho: Some(rho), sites: Some(10), ..Wanted::of("tw-q15") };
    let light = |rho: f64| Wanted { omega_tw: Some(0.2), ..wanted(rho) }.study().unwrap().wave;
    let plain = light(0.0);
    let [a, b, c] = [1e-2, 1e-3, 1e-4].map(|rho| light(rho).amplitude() / plain.amplitude() - 1.0);
    assert!((a / b - 10.0).abs() < 0.2 && (b / c - 10.0).abs() < 0.1 && c < 1e-3, "{a} {b} {c}");
    let heavy = |rho: f64| Wanted { amplitude: Some(0.1), mean: Some(0.0), ..wanted(rho) }.study().unwrap().wave;
    let cradle = heavy(f64::INFINITY);
    let [a, b] = [1e3, 1e4].map(|rho| heavy(rho).setting.omega_tw - cradle.setting.omega_tw);
    assert!((a / b - 10.0).abs() < 0.1 && b.abs() < 1e-3, "{a} {b}");
    // Multipliers: four that are 1 and no linear pair; two and one pair where resonators are at rest.
    for (wave, trivial, linear) in [(plain, 4, 0), (cradle, 2, 2)] {
        let spectrum = wave.spectrum(20, &Search::default()).unwrap();
        let count = |kind| spectrum.multipliers.iter().filter(|one| one.kind == kind).count();
        assert_eq!([count(WaveKind::Trivial), count(WaveKind::Linear)], [trivial, linear]);
        let quality = spectrum.quality;
        assert!(spectrum.multipliers.len() == 40 && quality.symplectic_defect < 1e-12, "{quality:?}");
        assert!(quality.phase_shift < 1e-12 && quality.linear < 1e-12, "{quality:?}");
    }
}
