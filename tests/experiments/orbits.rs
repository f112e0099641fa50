//! Periodic orbits: dark breathers, their multipliers, branches and bifurcations.

use crate::{common::regularised, numbers::rk4};
use hertzchain::{
    Error,
    breathers::DarkBreather,
    chain::{Boundary, Chain, Params},
    dps::Center,
    integrators::{Real, collocation::StepControl, dop853::Options},
    orbits::{
        Bifurcation, BifurcationKind, Branch, Continuation, End, Formulation, Kind, Orbit, OrbitPoint, Parameter,
        Shooting,
    },
    run::state_at,
    study::{Kick, evolve, study},
    waves::{Given, MeanStrain, Nls, Search, WaveNumber, WaveSetting},
};
use nalgebra::{Complex, DMatrix, DVector};
use twofloat::TwoFloat;

const THIRD: f64 = 1.0 / 3.0;

fn breather(center: Center, omega_b: f64) -> DarkBreather {
    DarkBreather { params: Params::new(1.5, 1.0, THIRD).unwrap(), center, sites: 41, omega_b, c_x: 0.0 }
}

fn of_mass(rho: f64, center: Center, omega_b: f64) -> DarkBreather {
    DarkBreather { params: Params::new(1.5, 1.0, rho).unwrap(), ..breather(center, omega_b) }
}

fn orbit(center: Center, omega_b: f64) -> Orbit {
    breather(center, omega_b).orbit(&Shooting::default()).unwrap()
}

/// The state at `t` by DOP853, which shares no code with collocation.
fn by_dop853<R: Real>(orbit: &Orbit, t: f64, tol: f64) -> Vec<f64> {
    let chain = Chain::new(orbit.setting.params, Boundary::StrainRing, orbit.setting.sites).unwrap();
    let start: Vec<R> = orbit.start().into_iter().map(R::of).collect();
    regularised(chain, &start, t, Options::new(R::of(tol))).into_iter().map(R::f64).collect()
}

/// Largest change of the state, strains and velocities, over a period by DOP853, divided by the
/// amplitude.
fn defect_by_dop853(orbit: &Orbit) -> f64 {
    let (start, end) = (orbit.start(), by_dop853::<f64>(orbit, orbit.setting.period(), 1e-14));
    start.iter().zip(&end).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / orbit.amplitude()
}

/// Truth: the branch followed in other steps from an orbit that is found from its seed, and DOP853.
#[test]
fn an_orbit_that_its_seed_does_not_lead_to_is_found_along_the_branch() {
    let shooting = Shooting::default();
    let short = |omega_b: f64| DarkBreather { sites: 7, ..breather(Center::Bond, omega_b) };
    let far = short(2.7);
    let alone = shooting.solve(&far.setting(), &far.seed().unwrap());
    assert!(matches!(alone, Err(Error::Stalled { .. })), "Newton's method from the seed");
    let found = far.orbit(&shooting).unwrap();
    let near = short(2.3);
    let start = shooting.solve(&near.setting(), &near.seed().unwrap()).unwrap();
    let along = Continuation { parameter: Parameter::OmegaB, to: 2.7, step: 0.02, most_points: 100, shooting };
    let (orbits, _) = along.follow(start, |_| {}).unwrap();
    let last = orbits.last().unwrap();
    let apart = found.z.iter().zip(&last.z).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(last.setting.omega_b == 2.7 && apart < 1e-15 * found.amplitude(), "{apart:e}");
    // Measured: 4e-16, 1.6e-16 and 7e-14.
    assert!(found.residual < 3.5e-16 && defect_by_dop853(&found) < 1.5e-13, "{:e}", defect_by_dop853(&found));
}

#[test]
fn another_integrator_finds_the_same_orbit() {
    // Z'(T/2) = 0 and C_x = 0, solved again on the flow of DOP853 with an approximate tangent map.
    // Truth: in double-double arithmetic the error of this flow is below that of a double.
    // Measured: 2e-13; in double precision 1.1e-11, from the error of that flow.
    for center in [Center::Site, Center::Bond] {
        let ours = orbit(center, 2.05);
        let (n, half) = (ours.z.len(), 0.5 * ours.setting.period());
        let control = StepControl::Windows { windows: 30, nodes: 12, neighbours: true };
        let columns = ours.setting.chain().unwrap().monodromy(&ours.start(), (0.0, half), control).unwrap();
        let tangent = DMatrix::from_vec(2 * n, 2 * n, columns);
        let mut equations = tangent.view((n, 0), (n, n)).insert_row(n, 0.0);
        for j in 0..n {
            equations[(n, j)] = 0.5 * (tangent[(0, j)] + f64::from(u8::from(j == 0)));
        }
        let inverse = equations.svd(true, true);
        let mut theirs = ours.clone();
        let steps: Vec<f64> = (0..3)
            .map(|_| {
                let end = by_dop853::<TwoFloat>(&theirs, half, 1e-17);
                let residual = DVector::from_column_slice(&end[n..]).push(0.5 * (theirs.z[0] + end[0]));
                let by = inverse.solve(&residual, 0.0).unwrap();
                theirs.z.iter_mut().zip(&by).for_each(|(z, by)| *z -= by);
                by.amax() / ours.amplitude()
            })
            .collect();
        let apart = ours.z.iter().zip(&theirs.z).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / ours.amplitude();
        println!("{center:?}: {apart:e}, steps {steps:?}, singular values down to {:e}", inverse.singular_values.min());
        assert!(apart <= 4e-13);
    }
}

#[test]
fn symmetries_are_those_of_the_center() {
    // Site: x_{-n}(t) = x_n(t + T/2). Bond: x_{1-n}(t) = x_n(t). Measured: 9e-16.
    for center in [Center::Site, Center::Bond] {
        let orbit = orbit(center, 2.05);
        let n = orbit.setting.sites;
        let states = orbit.states(1e-13, &[0.5 * orbit.setting.period()]).unwrap();
        let mut worst = 0f64;
        for i in 0..n {
            let (image, ours) = match center {
                Center::Site => (n - 1 - i, &states[0]),
                Center::Bond => ((n - i) % n, &orbit.z),
            };
            worst = worst.max((ours[i] - orbit.z[image]).abs() / orbit.amplitude());
        }
        assert!(worst < 2e-15, "{center:?}: {worst:e}");
    }
}

#[test]
fn newton_converges_quadratically_from_the_dps_seed_in_nine_steps() {
    for center in [Center::Site, Center::Bond] {
        for k in 1..=10 {
            let omega_b = 2.0 + 0.01 * f64::from(k);
            let breather = breather(center, omega_b);
            let orbit = Shooting::default().solve(&breather.setting(), &breather.seed().unwrap()).unwrap();
            let steps: Vec<f64> = orbit.newton.iter().map(|step| step.step).collect();
            assert!(steps.len() <= 9, "{center:?} {omega_b}: {} steps", steps.len());
            let [before, last] = steps[steps.len() - 2..] else { panic!() };
            assert!(last <= 6.5 * before * before + 6e-15, "{center:?} {omega_b}: {before:e} {last:e}");
        }
    }
}

/// X and Y of the background, `X'' = -2 |X|^{1/2} X - (X - Y), rho Y'' = X - Y`, a quarter of a
/// period after the start from the first site, divided by its strain. A Runge-Kutta method on two
/// equations computes them, without any code of the library.
fn background_defect(orbit: &Orbit) -> f64 {
    let rho = orbit.setting.params.rho;
    let field = |s: &[f64]| {
        let force = 2.0 * s[0].abs().sqrt() * s[0];
        vec![s[2], s[3], -force - (s[0] - s[1]), (s[0] - s[1]) / rho]
    };
    let (x, y) = (orbit.x()[0].abs(), -orbit.y()[0].abs());
    // The quarter period ends at X = 0, Y = 0. The force is not smooth there, and the run does not
    // cross that point.
    let (steps, quarter) = (200_000, 0.25 * orbit.setting.period());
    let at = (0..steps).fold(vec![x, y, 0.0, 0.0], |s, _| rk4(&field, &s, quarter / f64::from(steps)));
    at[0].abs().max(at[1].abs()) / x
}

#[test]
fn the_background_is_a_two_degree_of_freedom_oscillator() {
    let orbit = orbit(Center::Site, 2.05);
    let (extent, defect) = (orbit.extent(1e-13).unwrap(), background_defect(&orbit));
    assert!(defect < 1e-12);
    let (x, y) = (orbit.x()[0].abs(), orbit.y()[0].abs());
    assert!((extent.k_x - x).abs() < 1e-15 && (extent.k_y - y).abs() < 1e-15 && extent.c_x.abs() < 1e-15);
    // The number of the guide, and that of the breather centred on a bond.
    assert!((extent.k_x - 0.149_644_582_321).abs() < 1e-12);
    let bond = breather(Center::Bond, 2.05).orbit(&Shooting::default()).unwrap();
    assert!((bond.spectrum(&Shooting::default()).unwrap().largest() - 1.075_209_459_199).abs() < 1e-9);
}

#[test]
fn heavier_resonators_have_orbits_and_multipliers_as_good() {
    // At rho = 1.2 rounding turns the double tau = 1 into a complex pair.
    for (rho, omega_b) in [(3.0, 1.2547), (10.0, 1.2), (1.2, 1.75)] {
        for center in [Center::Site, Center::Bond] {
            let orbit = of_mass(rho, center, omega_b).orbit(&Shooting::default()).unwrap();
            let (e_b, other) = (orbit.e_b(1e-13, 1).unwrap(), defect_by_dop853(&orbit));
            let quality = orbit.spectrum(&Shooting::default()).unwrap().quality;
            let (fine, coarse) = (unstable(&orbit, 1e-13), unstable(&orbit, 1e-9));
            let nearest =
                |one: &Complex<f64>| coarse.iter().map(|other| (other - one).norm()).fold(f64::INFINITY, f64::min);
            // Multipliers just off the circle have just met; there they change like the square root
            // of any perturbation.
            let apart = fine.iter().filter(|one| one.norm() > 1.01).map(nearest).fold(0.0, f64::max);
            let background = background_defect(&orbit);
            println!(
                "{rho} {center:?}: {:e} {e_b:e} {other:e} {background:e} {quality:?} {} off the circle, {apart:e}, {:?}",
                orbit.residual,
                fine.len(),
                fine.first(),
            );
            // Measured: 2.6e-16, 6e-15, 7.4e-12 (the error of DOP853); 3.3e-14, 2e-14, 5.5e-14.
            assert!(orbit.residual <= 5e-16 && e_b <= 1.2e-14 && other <= 1.5e-11);
            assert!(quality.symplectic_defect <= 6.5e-14 && background < 4e-14 && apart < 1.1e-13);
            // Measured: 5.6e-13, 5.4e-13.
            assert!(quality.eigen_residual < 1.2e-12 && quality.pairing < 1.1e-12 && !fine.is_empty());
        }
    }
}

// The first points of the branch of figure `rho10-floquet`: all tau are near 1. The eigenvalues of
// the fifth did not converge as long as they were those of `nalgebra`.
#[test]
fn orbits_of_small_amplitude_have_multipliers() {
    let shooting = Shooting::default();
    let omega = 1.1_f64.sqrt();
    let (from, to) = (omega + 0.001, omega + 0.2);
    let start = of_mass(10.0, Center::Bond, from).orbit(&shooting).unwrap();
    let (parameter, step) = (Parameter::OmegaB, (to - from) / 100.0);
    let continuation = Continuation { parameter, to, step, most_points: 6, shooting };
    let mut trail = Branch::new(continuation, start.setting, start).unwrap();
    trail.extend(|_| {}).unwrap();
    let branch = study(trail, &hertzchain::sweep::Engine::threads(), &|_, _| {}).unwrap();
    assert_eq!((branch.points.len(), branch.gaps.len()), (6, 0));
    for OrbitPoint { spectrum, .. } in &branch.points {
        // Measured: 3.1e-12 at one orbit, where a step of inverse iteration starts almost
        // orthogonal to an eigenvector, 4.4e-14 at the others; and 6.3e-12.
        let (residual, pairing) = (spectrum.quality.eigen_residual, spectrum.quality.pairing);
        println!("{residual:e} {pairing:e}");
        assert!(residual < 6.2e-12 && pairing < 1.3e-11, "{residual:e} {pairing:e}");
        assert_eq!(spectrum.multipliers.iter().filter(|one| one.kind == Kind::Real && one.modulus > 1.0).count(), 1);
    }
}

fn follow_in_mass(omega_b: f64, from: f64, to: f64) {
    for center in [Center::Site, Center::Bond] {
        let start = of_mass(from, center, omega_b).orbit(&Shooting::default()).unwrap();
        let shooting = Shooting::default();
        let continuation = Continuation { parameter: Parameter::Rho, to, step: to - from, most_points: 99, shooting };
        let (orbits, end) = continuation.follow(start, |_| {}).unwrap();
        let last = &orbits[orbits.len() - 1];
        assert!(end == End::Reached && last.setting.params.rho == to && last.setting.omega_b == omega_b);
        let residual = orbits.iter().map(|orbit| orbit.residual).fold(0.0, f64::max);
        let (e_b, background) = (last.e_b(1e-13, 1).unwrap(), background_defect(last));
        println!("{omega_b} {center:?}: {} points, {residual:e} {e_b:e} {background:e}", orbits.len());
        // Measured: 6e-16, 8.3e-15, 4.2e-14.
        assert!(residual <= 1.2e-15 && e_b <= 1.7e-14 && background < 8.5e-14);
    }
}

#[test]
fn branches_in_the_mass_ratio_keep_their_frequency_and_their_background() {
    for (omega_b, from, to) in [(1.5, 1.0, 1.3), (1.75, 0.6, 0.7), (2.05, THIRD, 0.36)] {
        follow_in_mass(omega_b, from, to);
    }
}

/// Multipliers outside the unit circle, the largest first.
fn unstable(orbit: &Orbit, tol: f64) -> Vec<Complex<f64>> {
    let spectrum = orbit.spectrum(&Shooting { tol, ..Shooting::default() }).unwrap();
    let off = spectrum.multipliers.iter().filter(|one| one.modulus > 1.0);
    off.map(|one| Complex::new(one.re, one.im)).collect()
}

#[test]
fn multipliers_are_those_of_the_whole_period_at_any_tolerance() {
    // Truth: the eigenvalues of the tangent map over the whole period, computed without the
    // symmetry. Measured: 1.9e-13, and 5.5e-14 between tolerances.
    for center in [Center::Site, Center::Bond] {
        let orbit = orbit(center, 2.09);
        let quality = orbit.spectrum(&Shooting::default()).unwrap().quality;
        println!("{center:?}: {quality:?}");
        assert!(
            quality.symplectic_defect <= 1.2e-14 && quality.eigen_residual <= 1.2e-12 && quality.pairing <= 2.5e-12
        );
        assert!(quality.trivial.iter().all(|by| *by <= 8e-14) && quality.linear <= 1.5e-14);
        let chain = orbit.setting.chain().unwrap();
        let control = StepControl::Windows { windows: 60, nodes: 12, neighbours: true };
        let columns = chain.monodromy(&orbit.start(), (0.0, orbit.setting.period()), control).unwrap();
        let whole = DMatrix::from_vec(164, 164, columns).complex_eigenvalues();
        let coarse = unstable(&orbit, 1e-9);
        for (k, ours) in unstable(&orbit, 1e-13).into_iter().enumerate() {
            let nearest = whole.iter().map(|other| (other - ours).norm()).fold(f64::INFINITY, f64::min);
            println!("{ours}: {nearest:e} {:e}", (coarse[k] - ours).norm());
            assert!(nearest < 4e-13 && (coarse[k] - ours).norm() < 1.2e-13, "{ours}");
        }
    }
}

#[test]
fn kinds_of_multipliers_are_those_of_the_paper_at_209() {
    let strong = |center| {
        let mut all = orbit(center, 2.09).spectrum(&Shooting::default()).unwrap().multipliers;
        all.retain(|one| one.modulus > 1.05);
        all
    };
    let [negative, real] = strong(Center::Bond)[..] else { panic!() };
    assert!(negative.kind == Kind::Negative && (negative.re + 1.296_362).abs() < 1e-6);
    assert!(real.kind == Kind::Real && (real.re - 1.145_560).abs() < 1e-6);
    let [one, other] = strong(Center::Site)[..] else { panic!() };
    assert!(one.kind == Kind::Quartet && one.re < 0.0 && (one.im + other.im).abs() < 1e-12);
    assert!((one.modulus - 1.198_027).abs() < 1e-6);
}

#[test]
fn the_papers_formulation_finds_the_same_orbit() {
    // By symmetry the time average of x_1 is zero as well. Measured: 3.9e-15.
    for center in [Center::Site, Center::Bond] {
        let (ours, breather) = (orbit(center, 2.05), breather(center, 2.05));
        let shooting = Shooting { formulation: Formulation::FullPeriod, ..Shooting::default() };
        let theirs = shooting.solve(&breather.setting(), &breather.seed().unwrap()).unwrap();
        let apart = ours.z.iter().zip(&theirs.z).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{center:?}: {apart:e}");
        assert!(apart < 8e-15);
    }
}

fn bifurcations(center: Center, sites: usize, (from, to): (f64, f64)) -> Vec<Bifurcation> {
    let breather = DarkBreather { sites, ..breather(center, from) };
    let shooting = Shooting::default();
    let continuation = Continuation { parameter: Parameter::OmegaB, to, step: 2e-3, most_points: 100, shooting };
    let branch = Branch::new(continuation, breather.setting(), breather.orbit(&shooting).unwrap()).unwrap();
    let mut branch = Branch { weak: Some(0.01), ..branch };
    assert_eq!(branch.extend(|_| {}).unwrap(), End::Reached);
    branch.analysed().bifurcations
}

/// The bifurcation near a value, found in another way: from all eigenvalues of the tangent map over
/// the whole period, on a ring of 31 sites, at another tolerance. With `s = lambda + 1/lambda`, a
/// multiplier passes -1 where `s + 2` changes its sign, and two pairs meet where `(s_1 - s_2)^2`
/// does; both are smooth there.
fn by_whole_period(center: Center, near: &Bifurcation) -> f64 {
    const SITES: usize = 31;
    let root = Complex::new(near.critical.tau * near.critical.tau - 1.0, 0.0).sqrt();
    let doubles = near.kind == BifurcationKind::PeriodDoubling;
    let meeting = if doubles { Complex::new(-1.0, 0.0) } else { near.critical.tau - root };
    let signed = |omega_b: f64| {
        let shooting = Shooting { tol: 1e-11, ..Shooting::default() };
        let orbit = DarkBreather { sites: SITES, ..breather(center, omega_b) }.orbit(&shooting).unwrap();
        let control = StepControl::Windows { windows: 50, nodes: 12, neighbours: true };
        let span = (0.0, orbit.setting.period());
        let columns = orbit.setting.chain().unwrap().monodromy(&orbit.start(), span, control).unwrap();
        let map = DMatrix::from_vec(4 * SITES, 4 * SITES, columns);
        let mut all: Vec<Complex<f64>> = map.complex_eigenvalues().iter().copied().collect();
        all.sort_by(|a, b| (a - meeting).norm().total_cmp(&(b - meeting).norm()));
        let [one, other] = [all[0], all[1]].map(|lambda| lambda + lambda.inv());
        if doubles { one.re + 2.0 } else { ((one - other) * (one - other)).re }
    };
    // Inverse interpolation.
    let places = [-4e-6, 1e-6, 4e-6].map(|by| near.parameter + by);
    let values = places.map(signed);
    println!("{:?}: {values:?}", near.kind);
    assert!(values[0] * values[2] < 0.0, "{values:?}");
    let weight =
        |i: usize| -> f64 { (0..3).filter(|&j| j != i).map(|j| values[j] / (values[j] - values[i])).product() };
    near.parameter + (0..3).map(|i| (places[i] - near.parameter) * weight(i)).sum::<f64>()
}

#[test]
fn the_period_doubles_where_the_tangent_map_has_the_eigenvalue_minus_one() {
    let found = bifurcations(Center::Bond, 41, (2.062, 2.066));
    let again = by_whole_period(Center::Bond, &found[0]) - found[0].parameter;
    println!("by all eigenvalues: {again:e}");
    assert!(again.abs() < 1e-11);
    let [Bifurcation { kind: BifurcationKind::PeriodDoubling, parameter, ref orbit, ref critical, .. }] = found[..]
    else {
        panic!("{found:?}")
    };
    let mode = &critical.mode;
    // The value does not depend on the length of the ring. Measured: 3e-15 between 31 and 41 sites.
    let smaller = bifurcations(Center::Bond, 31, (2.062, 2.066));
    println!("{parameter:.13} {:e}", parameter - smaller[0].parameter);
    assert!((parameter - 2.063_258_452_043_5).abs() < 1e-12 && (parameter - smaller[0].parameter).abs() < 1e-14);
    // Truth: M (z, 0) = -(z, 0), by the tangent map over the whole period.
    let chain = orbit.setting.chain().unwrap();
    let control = StepControl::Windows { windows: 60, nodes: 12, neighbours: true };
    let columns = chain.monodromy(&orbit.start(), (0.0, orbit.setting.period()), control).unwrap();
    let start: Vec<f64> = mode.iter().copied().chain(vec![0.0; mode.len()]).collect();
    let image = DMatrix::from_vec(164, 164, columns) * DMatrix::from_column_slice(164, 1, &start);
    let apart = image.iter().zip(&start).map(|(image, start)| (image + start).abs()).fold(0.0, f64::max);
    println!("{apart:e}");
    assert!(apart < 1.2e-13);
    // The mode is antisymmetric under n -> 1 - n and localised at the kink.
    assert!((0..41).all(|i| (mode[i] + mode[(41 - i) % 41]).abs() < 1e-7));
    assert!(mode[0].abs() < 1e-6);
}

#[test]
fn two_real_pairs_collide_where_the_paper_has_them_return() {
    use BifurcationKind::{PeriodDoubling, RealCollision};
    // Two bifurcations in one step of the branch, and the same ones on a branch that begins
    // elsewhere.
    for from in [2.0948, 2.0935] {
        let found = bifurcations(Center::Bond, 41, (from, 2.0958));
        if from == 2.0948 {
            for one in &found {
                let again = by_whole_period(Center::Bond, one) - one.parameter;
                println!("{:?} by all eigenvalues: {again:e}", one.kind);
                assert!(again.abs() < 1e-11);
            }
        }
        let found: Vec<_> = found.iter().map(|one| (one.kind, one.parameter, one.critical.tau)).collect();
        println!("{found:?}");
        let [(PeriodDoubling, second, _), (RealCollision, collision, tau)] = found[..] else { panic!() };
        assert!((second - 2.095_169_779_159_2).abs() < 1e-12 && (collision - 2.095_541_921_391_5).abs() < 1e-12);
        assert!((tau + 1.005_907).abs() < 1e-5);
    }
}

#[test]
fn the_strong_instability_of_the_site_centred_breather_begins_in_a_collision() {
    // Truth: after a collision |lambda| - 1 increases like the square root of the distance.
    let found = bifurcations(Center::Site, 41, (2.076, 2.079));
    let again = by_whole_period(Center::Site, &found[0]) - found[0].parameter;
    println!("by all eigenvalues: {again:e}");
    // Measured: 7e-11, the same with points of interpolation 2.5 times as far apart.
    assert!(again.abs() < 1.4e-10);
    let [Bifurcation { kind: BifurcationKind::KreinCollision, parameter, ref critical, .. }] = found[..] else {
        panic!("{found:?}")
    };
    let tau = critical.tau;
    println!("{parameter:.12} {tau}");
    assert!(2.077 < parameter && parameter < 2.078 && (-1.0..-0.95).contains(&tau));
    let growth = |by: f64| {
        let all = unstable(&orbit(Center::Site, parameter + by), 1e-13);
        all.iter().find(|lambda| lambda.re < 0.0).unwrap().norm().ln()
    };
    let (near, far) = (growth(1e-6), growth(4e-6));
    println!("{near:e} {far:e}");
    assert!((far / near - 2.0).abs() < 2.5e-4);
}

/// The doubled branch from its beginning to a frequency, with the distances of `Z(T/2)` from
/// the reflection of `Z(0)` and from `Z(0)` itself.
fn doubled_branch(to: f64, step: f64) -> (Bifurcation, Vec<(Orbit, [f64; 2])>) {
    let birth = bifurcations(Center::Bond, 41, (2.062, 2.066)).remove(0);
    let shooting = Shooting::default();
    let way = Continuation { parameter: Parameter::OmegaB, to, step, most_points: 50, shooting };
    let (orbits, end) = way.follow(birth.doubled(&shooting, 0.02).unwrap(), |_| {}).unwrap();
    assert_eq!(end, End::Reached);
    let half_way = |orbit: Orbit| {
        let states = orbit.states(1e-13, &[0.5 * orbit.setting.period()]).unwrap();
        let apart = |image: &dyn Fn(usize) -> usize| {
            (0..41).map(|i| (states[0][i] - orbit.z[image(i)]).abs()).fold(0.0, f64::max) / orbit.amplitude()
        };
        let apart = [apart(&|i| (41 - i) % 41), apart(&|i| i)];
        println!("{:.6} {:e} {apart:?} {:e}", orbit.setting.omega_b, orbit.residual, orbit.e_b(1e-13, 1).unwrap());
        (orbit, apart)
    };
    (birth, orbits.into_iter().map(half_way).collect())
}

#[test]
fn orbits_of_doubled_period_come_back_reflected() {
    let (birth, points) = doubled_branch(1.034, 1e-3);
    let mut squares = Vec::new();
    for (orbit, [reflected, same]) in &points {
        assert!(*reflected < 1.5e-14 && *same > 0.01 && orbit.e_b(1e-13, 1).unwrap() < 1e-12);
        squares.push((orbit.setting.omega_b - 0.5 * birth.parameter) / (same * same));
    }
    // Near the bifurcation the amplitude increases like the square root of the distance.
    assert!((squares[1] / squares[0] - 1.0).abs() < 0.3, "{squares:?}");
}

#[test]
fn what_cannot_be_is_refused_and_what_was_found_is_kept() {
    let message = |breather: DarkBreather| breather.orbit(&Shooting::default()).unwrap_err().to_string();
    let good = breather(Center::Site, 2.05);
    assert!(message(DarkBreather { sites: 40, ..good }).contains("odd"));
    assert!(message(DarkBreather { omega_b: 2.0, ..good }).contains("omega_b > omega"));
    assert!(message(DarkBreather { sites: 401, ..good }).contains("256"));
    assert!(message(DarkBreather { c_x: f64::NAN, ..good }).contains("finite"));
    let few = Shooting { most_steps: 3, ..Shooting::default() };
    let Err(Error::Stalled { steps: 3, best: Some(best) }) = few.solve(&good.setting(), &good.seed().unwrap()) else {
        panic!()
    };
    assert!(best.residual < 1e-2 && best.z.len() == 82);
    assert!(Shooting::default().solve(&good.setting(), &[0.0; 82]).is_err());
    assert!(Shooting::default().solve(&good.setting(), &[1.0; 3]).is_err());
}

#[test]
fn a_kick_along_a_mode_grows_by_its_multiplier_and_sets_the_kink_in_motion() {
    let (orbit, shooting) = (orbit(Center::Bond, 2.05), Shooting::default());
    let run = |size: f64, periods: f64| {
        evolve(&orbit, periods * orbit.setting.period(), Some(Kick { size, mode: 0 }), &shooting, &|_, _| ()).unwrap()
    };
    // Truth: the multiplier. If the vector is not an eigenvector, the kick also has parts along the
    // decaying mode. Measured: 4e-9.
    let small = run(1e-8, 60.0);
    let lambda = small.kick.unwrap().1.re;
    let growth = (small.e_b[60] / small.e_b[20]).powf(1.0 / 40.0);
    println!("{growth} {lambda}");
    assert!((growth / lambda - 1.0).abs() < 1e-8);
    // The kink leaves the bond between the sites 0 and 1 in either direction; the two motions are
    // images under the symmetry n -> 1 - n.
    let (right, left) = (run(0.01, 100.0), run(-0.01, 100.0));
    let apart = right.position.iter().zip(&left.position).map(|(a, b)| (a + b - 1.0).abs()).fold(0.0, f64::max);
    println!("{:?} {:?} {apart:e}", right.position[100], left.position[100]);
    assert!((right.position[0] - 0.5).abs() < 0.1 && (right.position[100] - 0.5).abs() > 1.0 && apart < 1.2e-12);
    // Without a kick the breather does not move.
    let still = evolve(&orbit, 100.0 * orbit.setting.period(), None, &shooting, &|_, _| ()).unwrap();
    assert!(still.e_b[100] < 3e-13 && (still.position[100] - 0.5).abs() < 1e-11, "{:?}", still.e_b[100]);
}

// Truth: the period. All contacts begin or end at a quarter of it, so that windows for the states
// there end within a rounding of a release of every second bond.
#[test]
fn an_orbit_has_its_state_where_all_its_contacts_begin_or_end() {
    let orbit = of_mass(3.0, Center::Site, 1.2547).orbit(&Shooting::default()).unwrap();
    let (period, chain) = (orbit.setting.period(), orbit.setting.chain().unwrap());
    let control = StepControl::Tolerance(Shooting::default().tol);
    let mut run = chain.collocation(&orbit.start(), (0.0, 299.0 * period), control).unwrap();
    let quarters: Vec<_> = (0..64).map(|k| state_at(&mut run, 0.25 * f64::from(k) * period).unwrap()).collect();
    let pairs = quarters.iter().flatten().zip(quarters[4..].iter().flatten());
    let worst = pairs.map(|(now, later)| (later - now).abs()).fold(0.0, f64::max);
    println!("{worst:e}");
    assert!(worst < 1e-9, "{worst:e}");
}

#[test]
fn loaded_breathers_are_periodic_and_have_the_background_of_exact_waves() {
    // Truths: DOP853 over a period; the symmetry of the kink; the frequency of the exact wave at pi
    // with the amplitude and the mean strain of the background. Of acoustic and optical bands, and
    // without resonators.
    for (rho, c_x, omega_b) in [(0.0, -1.0, 2.43), (THIRD, -1.0, 2.757), (THIRD, -1.0, 1.53), (THIRD, -0.01, 2.0412)] {
        let params = Params::new(1.5, 1.0, rho).unwrap();
        for (center, kink) in [(Center::Site, 0), (Center::Bond, 1)] {
            let breather = DarkBreather { params, center, sites: 61, omega_b, c_x };
            let orbit = breather.orbit(&Shooting::default()).unwrap();
            let defect = defect_by_dop853(&orbit);
            let x = orbit.x();
            // Strains are even about a bond, and of opposite phase about a site.
            let image = |n: usize| x[(60 + kink - n) % 61];
            let odd = (0..61).map(|n| (x[n] - image(n)).abs()).fold(0.0, f64::max);
            let q = WaveNumber::on_ring(1.0, 10).unwrap();
            let setting = WaveSetting { params, q, omega_tw: omega_b, mean: MeanStrain::Value(c_x) };
            // The far end of the ring: a background of this amplitude.
            let height = (x[0] - c_x).abs();
            let ratio = 1.0 / (1.0 - rho * omega_b * omega_b);
            let array = |ratio: f64| [c_x + ratio * height, c_x - ratio * height];
            let seed = match rho > 0.0 {
                true => [array(1.0), array(ratio), [0.0; 2], [0.0; 2]].concat(),
                false => [array(1.0), [0.0; 2]].concat(),
            };
            let wave = Search::default().solve(&setting, Given::Amplitude(height), &seed).unwrap();
            let off = (wave.setting.omega_tw - omega_b).abs();
            println!("{rho} {c_x} {omega_b} {center:?}: {defect:.1e}, height {height}, odd {odd}, {off:.1e}");
            assert!(defect < 9e-13 && height > 0.1 * c_x.abs(), "{rho} {omega_b}: {defect:e}");
            assert!(if kink == 0 { odd > 1.9 * height } else { odd < 1e-14 * height }, "{rho} {omega_b}: {odd}");
            assert!(off < 2.8e-7, "{rho} {omega_b} {center:?}: {off:e}");
        }
    }
}

#[test]
fn a_branch_in_the_load_goes_from_none_to_the_edge_of_the_band() {
    // At one frequency the load first grows with the amplitude of the background, then, past a
    // fold, falls to that at which linear waves with one kink round the ring have the frequency.
    // Truths: that load, from the closed form of the band; the symmetry; DOP853 over a period.
    let (sites, omega_b) = (21, 2.05);
    for center in [Center::Site, Center::Bond] {
        let first = DarkBreather { sites, ..breather(center, omega_b) };
        let mut start = first.orbit(&Shooting::default()).unwrap();
        let mut points = 0;
        for (step, most) in [(4e-4, 999), (1e-5, 999)] {
            let shooting = Shooting::default();
            let parameter = Parameter::Cx;
            let to = if step > 1e-4 { -0.03 } else { 0.0 };
            let branch = Continuation { parameter, to, step, most_points: most, shooting };
            let (orbits, end) = branch.follow(start.clone(), |_| {}).unwrap();
            println!("{center:?} {}: {end:?}, {} points", step, orbits.len());
            assert!(end == End::AtRest);
            points += orbits.len();
            for orbit in orbits.iter().step_by(10) {
                let (residual, defect) = (orbit.residual, defect_by_dop853(orbit));
                println!("{} {:e} {residual:e} {defect:e}", orbit.setting.c_x, orbit.x()[0] - orbit.setting.c_x);
                assert!(residual < 2.3e-16 && defect < 7e-12, "{residual:e} {defect:e}");
            }
            start = orbits.last().unwrap().clone();
        }
        let (mut low, mut high) = (1e-3, 1e-1);
        let theta = std::f64::consts::PI * (1.0 - 1.0 / sites as f64);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let edge = Nls::new(start.setting.params, [1.0, middle], theta).unwrap()[1].omega;
            *(if edge < omega_b { &mut low } else { &mut high }) = middle;
        }
        let (load, height) = (-start.setting.c_x, (start.x()[0] - start.setting.c_x).abs());
        println!("{center:?}: {points} points, load {load}, edge {low}, height {height}");
        // Measured: 3.5e-3 and 2e-7.
        assert!(height < 0.007 * load && (load / low - 1.0).abs() < 4e-7);
    }
}

#[test]
fn chains_at_rest_and_orbits_with_other_kinks_are_no_loaded_breathers() {
    // Above both bands, in the gap, and so far below an edge that contacts open. Above the upper
    // edge Newton's method finds orbits of several kinks; at alpha = 3 the seed about a site leads
    // to the orbit about a bond.
    for omega_b in [2.6, 1.9, 2.79, 3.0] {
        let breather = DarkBreather { c_x: -1.0, ..breather(Center::Site, omega_b) };
        let why = breather.orbit(&Shooting::default()).unwrap_err().to_string();
        assert!(why.contains("no dark breather of this frequency") && why.contains(&omega_b.to_string()), "{why}");
    }
    let params = Params::new(3.0, 1.0, 0.0).unwrap();
    let mut breather = DarkBreather { params, center: Center::Site, sites: 41, omega_b: 0.0, c_x: -1.0 };
    breather.omega_b = breather.usual_frequency([1.0, 0.5]);
    match breather.orbit(&Shooting::default()) {
        Ok(orbit) => {
            let half = orbit.states(1e-13, &[0.5 * orbit.setting.period()]).unwrap();
            assert!((half[0][20] - orbit.x()[20]).abs() < 1e-2, "{:?}", orbit.x());
        }
        Err(why) => assert!(why.to_string().contains("no dark breather of this frequency"), "{why}"),
    }
}
