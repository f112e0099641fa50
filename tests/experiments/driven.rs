//! Periodic orbits of driven, damped chains.

use crate::{
    common::at_end,
    switching::{along, branch},
};
use hertzchain::{
    chain::{
        Boundary, Chain, Details, Dissipation, Drive, DriveKind, Envelope, Harmonic, Kind, Params, Signal, State,
        Variations,
    },
    orbits::{
        BifurcationKind, DriveParameter, DrivenOrbit, DrivenPoint, DrivenSetting, DrivenShooting, End, NormalModes,
        Response,
    },
    run::{Method, Run, Setting},
    scene::Scene,
};
use nalgebra::Complex;
use std::f64::consts::PI;

fn sine(site: usize, kind: DriveKind, amplitude: f64, omega: f64) -> Drive {
    Drive { site, kind, signal: Signal::sine(amplitude, omega, 0.0) }
}

/// A bead between two walls with static overlaps 1, with drag, pushed by `amplitude sin(omega t)`.
/// Its restoring force is `(1 + u)^{3/2} - (1 - u)^{3/2} = 3 u - u^3/8 + ..`, its linear response
/// `u = Im [amplitude e^{i omega t}/(3 - omega^2 + i drag omega)]`.
fn bead(drag: f64, amplitude: f64, omega: f64) -> Chain<f64> {
    bead_with(drag, None, amplitude, omega)
}

/// The same bead, whose contacts may dissipate.
fn bead_with(drag: f64, dissipation: Option<Dissipation>, amplitude: f64, omega: f64) -> Chain<f64> {
    let details = Details {
        drag: vec![drag],
        dissipation,
        overlap: vec![1.0; 2],
        drives: vec![sine(0, DriveKind::Force, amplitude, omega)],
        ..Details::default()
    };
    Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Fixed, 1).unwrap().with(&details).unwrap()
}

fn orbit(chain: &Chain<f64>, turns: u32) -> DrivenOrbit {
    let (shooting, setting) = (DrivenShooting::default(), DrivenSetting::new(chain, turns).unwrap());
    shooting.solve(&setting, &vec![0.0; setting.unknowns()]).unwrap()
}

#[test]
fn multipliers_of_a_linear_bead_are_within_their_error_over_up_to_64_periods() {
    // Truth: e^{mu T} with mu^2 + c mu + 3 = 0. At the amplitude 1e-7 the stiffness differs from 3
    // by a rounding. With fewer nodes for the derivative than for a state of the size of the
    // overlap, 64 periods err by 4e-6.
    for drag in [1e-3, 0.01, 0.1, 1.0] {
        for turns in [1, 2, 4, 16, 64] {
            let spectrum = orbit(&bead(drag, 1e-7, 1.0), turns).spectrum(&DrivenShooting::default()).unwrap();
            let mu = Complex::new(-0.5 * drag, (3.0 - 0.25 * drag * drag).sqrt());
            let want = (mu * (2.0 * PI * f64::from(turns))).exp();
            let got = spectrum.multipliers[0];
            let off = (got.re - want.re).hypot(got.im.abs() - want.im.abs());
            println!("{drag} {turns}: {off:e} of {:e}, bound {:e}", want.norm(), got.error);
            assert!(off <= got.error && got.error < 1e-10, "{drag} {turns}: {off:e} {got:?} {want}");
        }
    }
}

/// Trace and determinant of the derivative of the stroboscopic map of one bead, by [`Variations`]
/// at its finest tolerance.
fn trace_and_determinant(orbit: &DrivenOrbit) -> [f64; 2] {
    let (chain, start) = (orbit.setting.chain().unwrap(), orbit.start().unwrap());
    let span = (0.0, orbit.setting.period());
    let w = Variations::flow(&chain, start.as_slice(), span, &[1.0, 0.0, 0.0, 1.0], 1e-14).unwrap().columns;
    [w[0] + w[3], w[0] * w[3] - w[1] * w[2]]
}

#[test]
fn multipliers_of_a_rattling_bead_are_within_their_error() {
    // Truth: the quadratic equation of a derivative by another method. The contact opens.
    let (shooting, branch) = (DrivenShooting::default(), branch(&shaken(0.1), 1.8, 0.2));
    let last = &branch.points.last().unwrap().orbit;
    let four = DrivenSetting::new(&shaken(1.8), 4).unwrap();
    let four = shooting.solve(&four, &last.z).unwrap();
    for orbit in branch.points.iter().map(|point| &point.orbit).chain([&four]) {
        let [trace, determinant] = trace_and_determinant(orbit);
        for one in orbit.spectrum(&shooting).unwrap().multipliers {
            let at = Complex::new(one.re, one.im);
            // The residual over the distance to the other multiplier.
            let off = (at * at - at * trace + determinant).norm() / (at * 2.0 - trace).norm();
            assert!(off <= one.error && one.error < 1e-7, "{off:e} {one:?}");
        }
    }
}

#[test]
fn a_slow_drive_moves_a_bead_through_its_equilibria() {
    // Truth: 3 u = a sin(omega t) at small u, so u'/omega = a/3 at t = 0, up to omega^2. The
    // residual, of velocities over omega, is above 1e-11 by roundings.
    let orbit = orbit(&bead(0.01, 0.1, 1e-3), 1);
    assert!((orbit.z[1] - 0.1 / 3.0).abs() < 1e-6, "{:?}", orbit.z);
    assert!(orbit.residual < 1e-9, "{:e}", orbit.residual);
    // The flow errs by more than a rounding a step: no seed must be refused for it.
    let (shooting, chain) = (DrivenShooting::default(), bead(0.01, 0.1, 1e-2));
    let setting = DrivenSetting::new(&chain, 1).unwrap();
    for periods in [1, 3, 8] {
        let seed = shooting.settle(&setting, &chain, &State::rest(&chain), periods, |_| ()).unwrap();
        let residual = shooting.solve(&setting, &seed).unwrap().residual;
        assert!(residual < 1e-10, "{residual:e}");
    }
}

#[test]
fn an_orbit_of_four_periods_tells_its_least_period() {
    let least = |orbit: DrivenOrbit| DrivenPoint::new(orbit, &DrivenShooting::default()).unwrap().measures.least_turns;
    assert_eq!([1, 2, 4].map(|turns| least(orbit(&bead(0.2, 0.1, 1.1), turns))), [1; 3]);
}

#[test]
fn ranges_are_those_of_the_solution_between_samples() {
    // Truth: two beads that do not meet, each with a spring to the ground, drag c and harmonics of
    // a force: u = sum_j Im [a_j e^{i omega_j t}/(1 - omega_j^2 + i c omega_j)]. Its extremes by
    // Newton's method from a hundred thousand times. In lengths of 2^-40 they were off by 2.8e-6.
    let (c, omega) = (0.1, 0.7);
    let forces = [[(1.0, 1.0), (0.3, 7.0)], [(0.4, 2.0), (1e-9, 3.0)]];
    let chain = |unit: f64| {
        let drive = |(site, forces): (usize, &[(f64, f64); 2])| {
            let harmonic = |(a, k)| Harmonic { amplitude: a * unit, omega: k * omega, phase: 0.0 };
            let signal = Signal::new(forces.map(harmonic).to_vec(), Envelope::None);
            Drive { site, kind: DriveKind::Force, signal }
        };
        let drives = forces.iter().enumerate().map(drive).collect();
        let (drag, onsite, overlap) = (vec![c; 2], vec![1.0; 2], vec![-20.0 * unit]);
        let details = Details { drag, onsite, overlap, drives, ..Details::default() };
        Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 2).unwrap().with(&details).unwrap()
    };
    // A derivative of the response to the forces at a site.
    let at = |site: usize, t: f64, order: i32| -> f64 {
        let term = |(a, k): (f64, f64)| {
            let i_omega = Complex::new(0.0, k * omega);
            (i_omega.powi(order) * a * (i_omega * t).exp() / (i_omega * i_omega + i_omega * c + 1.0)).im
        };
        forces[site].map(term).iter().sum()
    };
    let half_range = |of: &dyn Fn(f64, i32) -> f64| {
        let times = || (0..100_000).map(|k| 2.0 * PI / omega * f64::from(k) / 1e5);
        let top = |sign: f64| {
            let first = times().max_by(|s, t| (sign * of(*s, 0)).total_cmp(&(sign * of(*t, 0)))).unwrap();
            of((0..5).fold(first, |t, _| t - of(t, 1) / of(t, 2)), 0)
        };
        0.5 * (top(1.0) - top(-1.0))
    };
    let truth = [half_range(&|t, k| at(0, t, k)), half_range(&|t, k| at(1, t, k))];
    let strain = half_range(&|t, k| at(1, t, k) - at(0, t, k));
    for unit in [-40, 0, 40].map(|k| 2f64.powi(k)) {
        let (orbit, shooting) = (orbit(&chain(unit), 1), DrivenShooting::default());
        let [beads, strains] = orbit.ranges(&orbit.samples(&shooting).unwrap(), &shooting).unwrap();
        let off = |got: f64, want: f64| (got / unit / want - 1.0).abs();
        let errors = [off(beads[0], truth[0]), off(beads[1], truth[1]), off(strains[0], strain)];
        assert!(errors.iter().all(|off| *off < 1e-12), "{unit:e}: {errors:?}");
    }
}

/// A bead with a spring of constant 1 to the ground and drag `c`, pushed by `sin(omega t)`. It has
/// the orbit `u = Im (e^{i omega t}/(1 - omega^2 + i c omega))`.
fn linear(c: f64, omega: f64) -> Chain<f64> {
    let drives = vec![sine(0, DriveKind::Force, 1.0, omega)];
    let details = Details { drag: vec![c], onsite: vec![1.0], drives, ..Details::default() };
    Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 1).unwrap().with(&details).unwrap()
}

/// Value and rate over omega, at `t = 0`, of its orbit times an amplitude.
fn linear_orbit(c: f64, omega: f64, a: f64) -> [f64; 2] {
    let response = Complex::new(a, 0.0) / Complex::new(1.0 - omega * omega, c * omega);
    [response.im, response.re]
}

#[test]
fn a_branch_ends_at_its_final_value_also_beyond_a_peak_and_through_zero() {
    // Truth: the linear orbit. Steps of a twentieth of the range; near the peak the parameter of
    // the corrected point is beyond that of the predictor.
    let (c, omega) = (0.1, 0.7);
    for (parameter, from, to) in [(DriveParameter::Omega, omega, 1.23), (DriveParameter::Amplitude, 1.0, -1.0)] {
        let branch = along(parameter, to, f64::abs(to - from) / 20.0, orbit(&linear(c, omega), 1));
        assert_eq!(branch.ended(), End::Reached, "{parameter:?}");
        assert_eq!(branch.orbits.last().unwrap().setting.get(parameter), to);
        for DrivenOrbit { setting, z, .. } in &branch.orbits {
            let [omega, a] = [DriveParameter::Omega, DriveParameter::Amplitude].map(|one| setting.get(one));
            let off = z.iter().zip(linear_orbit(c, omega, a)).map(|(z, want)| (z - want).abs());
            assert!(off.fold(0.0, f64::max) < 1e-10, "{omega} {a}: {z:?}");
        }
    }
}

#[test]
fn a_state_that_is_nearly_zero_is_no_bound_for_newtons_steps() {
    // Truth: the linear orbit, unique as 1 is no multiplier. After 300 periods from rest the free
    // oscillation of period 2 pi has brought the bead back to rest, up to rounding.
    for (c, omega) in
        [2.0, 3.0, 4.0, 0.4, 2.0 / 3.0, 0.8, 1.2].map(|omega| (0.0, omega)).into_iter().chain([(1e-9, 0.8)])
    {
        let (shooting, chain) = (DrivenShooting::default(), linear(c, omega));
        let setting = DrivenSetting::new(&chain, 1).unwrap();
        let seed = shooting.settle(&setting, &chain, &State::rest(&chain), 300, |_| ()).unwrap();
        let z = shooting.solve(&setting, &seed).unwrap().z;
        let off = z.iter().zip(linear_orbit(c, omega, 1.0)).fold(0.0, |off: f64, (z, want)| off.max((z - want).abs()));
        assert!(off < 1e-11, "{omega}: {z:?}");
    }
}

#[test]
fn an_orbit_that_passes_through_rest_at_the_start_is_found() {
    // Truth: without damping, u = sum a_k sin(k omega t)/(1 - (k omega)^2), whose rate at t = 0 the
    // second harmonic of the force cancels.
    let (omega, mut chain) = (0.7, linear(0.0, 0.7));
    let second = (4.0 * omega * omega - 1.0) / (2.0 * (1.0 - omega * omega));
    let mut details = chain.details().unwrap().clone();
    details.drives.push(sine(0, DriveKind::Force, second, 2.0 * omega));
    chain = chain.with(&details).unwrap();
    let (shooting, setting) = (DrivenShooting::default(), DrivenSetting::new(&chain, 1).unwrap());
    for seed in [[0.0, 0.0], [0.3, -0.4], [1e-13, 1e-13]] {
        let orbit = shooting.solve(&setting, &seed).unwrap();
        let at = orbit.samples(&shooting).unwrap()[16][0];
        let truth = 1.0 / (1.0 - omega * omega);
        assert!(orbit.z.iter().all(|z| z.abs() < 1e-13) && (at - truth).abs() < 1e-10, "{:?} {at} {truth}", orbit.z);
    }
    // So is the branch that begins there.
    for (parameter, to) in [(DriveParameter::Omega, 0.8), (DriveParameter::Amplitude, 2.0)] {
        let branch = along(parameter, to, 0.05, shooting.solve(&setting, &[0.0, 0.0]).unwrap());
        let DrivenOrbit { setting, z, .. } = branch.orbits.last().unwrap();
        let [omega, a] = [DriveParameter::Omega, DriveParameter::Amplitude].map(|one| setting.get(one));
        let rate = |k: f64, a: f64| a * k / (1.0 - (k * omega).powi(2));
        let truth = rate(1.0, a) + rate(2.0, a * second);
        assert!(branch.ended() == End::Reached && (z[1] - truth).abs() < 1e-10, "{parameter:?} {z:?} {truth}");
    }
}

/// The largest distance of an orbit of [`bead_with`] from the linear response with drag `c`, in
/// units of that.
fn from_linear_response(orbit: &DrivenOrbit, c: f64, a: f64, omega: f64) -> f64 {
    let response = Complex::new(a, 0.0) / Complex::new(3.0 - omega * omega, c * omega);
    let want = [response.im, response.re];
    orbit.z.iter().zip(want).fold(0.0, |off: f64, (z, want)| off.max((z - want).abs())) / response.norm()
}

#[test]
fn a_weak_drive_gives_the_linear_response_in_which_closed_contacts_are_a_drag() {
    // Truth: the linear response; what the cubic term changes is of the relative order a^2, so the
    // error falls by 16 when a falls by 4. Multipliers: e^{mu T} with mu^2 + c mu + 3 = 0; at a =
    // 1e-3 the stiffness is less by 3/8 u^2, 1e-7 of it, and the angle by 2e-7. Contacts of overlap
    // 1 have the resistance 3/2 gamma (viscoelastic) or gamma (dashpots), and there are two.
    let (drag, omega, gamma) = (0.1, 1.1f64, 0.05);
    for (kind, resistance) in [(None, 0.0), (Some(Kind::Viscoelastic), 1.5 * gamma), (Some(Kind::Dashpot), gamma)] {
        let c = drag + 2.0 * resistance;
        let dissipation = || kind.map(|kind| Dissipation { kind, strength: vec![gamma; 2] });
        let chain = |a: f64| bead_with(drag, dissipation(), a, omega);
        let errors = [0.04, 0.01].map(|a| from_linear_response(&orbit(&chain(a), 1), c, a, omega));
        assert!(errors[1] < 1e-5 && (errors[0] / errors[1] - 16.0).abs() < 0.5, "{kind:?} {errors:?}");
        let orbit = orbit(&chain(1e-3), 1);
        let spectrum = orbit.spectrum(&DrivenShooting::default()).unwrap();
        let mu = Complex::new(-0.5 * c, (3.0 - 0.25 * c * c).sqrt());
        let (got, want) = (spectrum.multipliers[0], (mu * (2.0 * PI / omega)).exp());
        assert!((got.re - want.re).hypot(got.im.abs() - want.im.abs()) < 4e-7, "{kind:?} {got:?} {want}");
        assert!(spectrum.liouville < 1e-9 && spectrum.unstable() == 0, "{:e}", spectrum.liouville);
        // A branch in the factor of damping, which contacts share.
        let branch = along(DriveParameter::Damping, 3.0, 0.2, orbit);
        assert_eq!((branch.ended(), branch.bifurcations.len()), (End::Reached, 0));
        for point in &branch.points {
            let factor = point.orbit.setting.get(DriveParameter::Damping);
            let off = from_linear_response(&point.orbit, factor * c, 1e-3, omega);
            assert!(off < 1e-6, "{kind:?} {factor}: {off:e}");
        }
    }
}

#[test]
fn weakly_driven_beads_with_springs_have_their_linear_response() {
    // Truth: the response of `Response`, a solved linear system, to which the orbit comes with the
    // amplitude; on-site springs beside resonators that move, springs between beads.
    let drives = |a: f64| vec![sine(0, DriveKind::Force, a, 1.1)];
    let details = |a: f64| Details {
        onsite: vec![0.3, 0.5, 0.2],
        spring: vec![0.0, 0.4, 0.7, 0.1],
        drag: vec![0.1; 3],
        overlap: vec![1.0; 4],
        drives: drives(a),
        ..Details::default()
    };
    let chain = |a: f64| {
        Chain::new(Params::new(1.5, 0.8, 0.6).unwrap(), Boundary::Fixed, 3).unwrap().with(&details(a)).unwrap()
    };
    let response = Response::new(&chain(0.0), 0, DriveKind::Force).unwrap().at(1.1);
    let off = |a: f64| {
        let orbit = orbit(&chain(a), 1);
        let spectrum = orbit.spectrum(&DrivenShooting::default()).unwrap();
        assert!(spectrum.liouville < 1e-9 && spectrum.unstable() == 0, "{:e}", spectrum.liouville);
        (0..3).map(|i| (orbit.z[i] / a - response[i].im).abs()).fold(0.0, f64::max)
    };
    let [coarse, fine] = [0.04, 0.01].map(off);
    assert!(fine < 1e-3 && (coarse / fine - 4.0).abs() < 0.5, "{coarse:e} {fine:e}");
}

/// Three beads between walls that differ, with contacts that dissipate and open; the first of four
/// is moved.
fn rattling(kind: Kind, pull: bool) -> Chain<f64> {
    let strength = match kind {
        Kind::Viscoelastic => vec![0.3, 0.2, 0.4, 0.3, 0.3],
        Kind::Dashpot => vec![0.15, 0.1, 0.2, 0.15, 0.15],
        Kind::HuntCrossley => vec![2.7, 1.8, 3.6, 2.7, 2.7],
    };
    let details = Details {
        mass: vec![1.0, 0.7, 1.3, 1.0],
        drag: vec![0.0, 0.02, 0.02, 0.02],
        overlap: vec![0.1; 5],
        dissipation: Some(Dissipation { kind, strength }),
        pull,
        drives: vec![sine(0, DriveKind::Displacement, 0.3, 1.3)],
        ..Details::default()
    };
    Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Fixed, 4).unwrap().with(&details).unwrap()
}

#[test]
fn an_orbit_whose_contacts_dissipate_and_open_is_that_of_another_method() {
    // Truth: contact collocation, for the return and, by differences of the step 1e-5, for the
    // multipliers; sums of powers of the multipliers are compared, which need no order.
    for (kind, pull) in [
        (Kind::Viscoelastic, false),
        (Kind::Dashpot, false),
        (Kind::HuntCrossley, false),
        (Kind::Viscoelastic, true),
        (Kind::Dashpot, true),
    ] {
        let chain = rattling(kind, pull);
        let (shooting, setting) = (DrivenShooting::default(), DrivenSetting::new(&chain, 1).unwrap());
        let rest = State::rest(&chain).driven(&chain);
        let seed = shooting.settle(&setting, &chain, &rest, 200, |_| {}).unwrap();
        let orbit = shooting.solve(&setting, &seed).unwrap();
        let strobe = |z: &[f64]| {
            let mut start = orbit.start().unwrap();
            let (omega, y) = (setting.omega(), start.as_mut_slice());
            for i in 0..3 {
                (y[1 + i], y[5 + i]) = (z[i], omega * z[3 + i]);
            }
            let end = at_end(&chain, &start, setting.period(), 1e-12);
            (0..3).map(|i| end[1 + i]).chain((0..3).map(|i| end[5 + i] / omega)).collect::<Vec<f64>>()
        };
        let back = strobe(&orbit.z).iter().zip(&orbit.z).fold(0.0, |far: f64, (a, b)| far.max((a - b).abs()));
        let by = |j: usize, size: f64| {
            let moved = |sign: f64| {
                let mut z = orbit.z.clone();
                z[j] += sign * size;
                strobe(&z)
            };
            let [ahead, back] = [1.0, -1.0].map(moved);
            ahead.iter().zip(&back).map(|(a, b)| (a - b) / (2.0 * size)).collect::<Vec<_>>()
        };
        let differences = nalgebra::DMatrix::from_fn(6, 6, |i, j| by(j, 1e-5)[i]);
        let spectrum = orbit.spectrum(&shooting).unwrap();
        // The distances of sums of powers of the multipliers from traces of powers of a matrix.
        let apart = |matrix: &nalgebra::DMatrix<f64>| {
            let mut power = nalgebra::DMatrix::identity(6, 6);
            let of = |k: i32| {
                power *= matrix;
                let sum: Complex<f64> =
                    spectrum.multipliers.iter().map(|one| Complex::new(one.re, one.im).powi(k)).sum();
                (sum - power.trace()).norm()
            };
            (1..=6).map(of).collect::<Vec<f64>>()
        };
        let off = apart(&differences);
        let samples = orbit.samples(&shooting).unwrap();
        let open = samples.iter().any(|y| chain.overlaps(y).iter().any(|g| *g < 0.0));
        println!(
            "{kind:?} {pull}: residual {:e}, back {back:e}, open {open}, largest {}, {off:?}, Liouville {:e}",
            orbit.residual,
            spectrum.largest(),
            spectrum.liouville
        );
        assert!(open && back < 1e-11, "{back:e}");
        assert!(off.iter().all(|off| *off < 1e-5) && spectrum.liouville < 1e-8, "{off:?} {:e}", spectrum.liouville);
        let ledger = chain.layout().ledger(samples.last().unwrap()).unwrap();
        assert!(ledger.contacts > 1e-3 && (ledger.driven - ledger.dissipated()).abs() < 1e-9, "{ledger:?}");
    }
}

/// The frequencies of the two folds of the resonance curve.
fn folds(drag: f64, amplitude: f64, from: f64, to: f64) -> Vec<f64> {
    let start = orbit(&bead(drag, amplitude, from), 1);
    let branch = along(DriveParameter::Omega, to, 0.05 * (to - from).abs(), start);
    assert_eq!((branch.ended(), branch.unresolved), (End::Reached, 0));
    let kinds: Vec<BifurcationKind> = branch.bifurcations.iter().map(|one| one.kind).collect();
    assert_eq!(kinds, [BifurcationKind::Fold; 2]);
    // Unstable between the folds, stable before and after.
    let unstable: Vec<usize> = branch.points.iter().map(|point| point.spectrum.unstable()).collect();
    assert_eq!((unstable[0], *unstable.iter().max().unwrap(), *unstable.last().unwrap()), (0, 1, 0));
    branch.bifurcations.iter().map(|one| one.parameter).collect()
}

/// The folds of harmonic balance for `u'' + c u' + 3 u - u^3/8 = a sin(omega t)`: amplitude `A`
/// with `((3 - omega^2 - 3 A^2/32)^2 + c^2 omega^2) A^2 = a^2`, where `d omega/dA = 0`.
fn balance(drag: f64, amplitude: f64) -> [f64; 2] {
    // On the curve omega^2 = s solves s^2 + (c^2 - 2 k) s + k^2 - a^2/A^2 = 0, k = 3 - 3 A^2/32.
    let omega = |size: f64, sign: f64| {
        let k = 3.0 - 3.0 * size * size / 32.0;
        let half = k - 0.5 * drag * drag;
        let root = half * half - k * k + (amplitude / size).powi(2);
        (half + sign * root.sqrt()).sqrt()
    };
    // Both folds are on the left half of the curve: the maximum of omega(A), and the minimum
    // between it and the top. On a grid of 10^6 sizes each is found to the square of its spacing;
    // sizes beyond the top give no number.
    let top = amplitude / (drag * 1.5);
    let values: Vec<f64> = (1..1_000_000).map(|k| omega(top * f64::from(k) * 1e-6, -1.0)).collect();
    let largest = values.iter().copied().fold(0.0, f64::max);
    let from = values.iter().position(|&omega| omega == largest).unwrap();
    [values[from..].iter().copied().fold(f64::INFINITY, f64::min), largest]
}

#[test]
fn the_folds_of_a_softening_resonance_are_those_of_harmonic_balance() {
    // Truth: harmonic balance of the Duffing equation. With c = e and a of the order e^{3/2} it
    // gives the detuning, of the order e, up to e^2: the distance falls by 4 when e is halved.
    let distance = |e: f64| {
        let (drag, amplitude) = (e, 16.0 * e.powf(1.5));
        let [low, high] = balance(drag, amplitude);
        let mut got = folds(drag, amplitude, 3f64.sqrt() + 4.0 * e, 3f64.sqrt() - 6.0 * e);
        got.sort_by(f64::total_cmp);
        [(got[0] - low).abs(), (got[1] - high).abs()]
    };
    let [coarse, fine] = [0.002, 0.001].map(distance);
    for k in 0..2 {
        let slope = (coarse[k] / fine[k]).log2();
        assert!((1.8..2.2).contains(&slope), "fold {k}: {coarse:?} {fine:?}: {slope}");
    }
}

/// A bead that rests on a wall under its weight 1, and is shaken.
fn shaken(amplitude: f64) -> Chain<f64> {
    let set = ["bonds.overlap=[1, 0]", "bonds.contact=[1, 0]"].map(str::to_owned);
    let set = [&set[..], &[format!("drive.0.amplitude=[{amplitude:?}, -1]")]].concat();
    Scene::load_with(include_str!("../reference/pushed-bead.toml"), &set).unwrap().chain().clone()
}

#[test]
fn a_period_doubling_is_where_another_tangent_map_has_the_multiplier_minus_one() {
    let setting = DrivenSetting::new(&shaken(0.1), 1).unwrap();
    let (shooting, branch) = (DrivenShooting::default(), branch(&shaken(0.1), 2.0, 0.1));
    let found = branch.bifurcations.iter().find(|one| one.kind == BifurcationKind::PeriodDoubling);
    let found = found.unwrap_or_else(|| panic!("{:?}", branch.bifurcations.len()));
    assert!((found.critical.multiplier.re + 1.0).abs() < 1e-6 && found.critical.multiplier.im < 1e-6);
    // Truth: the zero of det (M + I) = 1 + tr M + det M by another method, by the secant method.
    // Where the modulus is 1 + 1e-7 the amplitude is larger by 4e-8.
    let test = |a: f64| {
        let setting = setting.with(DriveParameter::Amplitude, a);
        let orbit = shooting.solve(&setting, &found.orbit.z).unwrap();
        1.0 + trace_and_determinant(&orbit).iter().sum::<f64>()
    };
    let (mut old, mut new) = (found.parameter - 1e-4, found.parameter + 1e-4);
    for _ in 0..4 {
        let [before, now] = [old, new].map(test);
        (old, new) = (new, new - now * (new - old) / (now - before));
    }
    assert!((found.parameter - new).abs() < 1e-10, "{} {new}", found.parameter);
}

/// The chain of the scene `dark-ends`, whose right end moves `sign` times as the left one, without
/// its ramp, and an orbit of it.
fn ends(sign: f64, amplitude: f64) -> (Chain<f64>, DrivenOrbit) {
    let set = [("0", amplitude), ("1", sign * amplitude)].map(|(k, a)| format!("drive.{k}.amplitude={a:?}"));
    let chain = Scene::load_with("dark-ends", &set).unwrap().chain().clone();
    let (shooting, setting) = (DrivenShooting::default(), DrivenSetting::new(&chain, 1).unwrap());
    let rest = State::rest(&chain).driven(&chain);
    let seed = shooting.settle(&setting, &chain, &rest, 300, |_| {}).unwrap();
    let orbit = shooting.solve(&setting, &seed).unwrap();
    (orbit.setting.chain().unwrap(), orbit)
}

#[test]
fn an_orbit_returns_by_another_method_and_has_the_symmetry_of_its_drive() {
    // Truth: a splitting scheme, which shares no code with the flow of the search; the reflection
    // of the chain, with half a period for ends in phase.
    let (chain, orbit) = ends(1.0, 0.12);
    let (start, period) = (orbit.start().unwrap(), orbit.setting.period());
    let run = Run::new(chain.clone(), start.clone()).until(period).unwrap();
    let run = run.method(Method::named("aba1064-linear").unwrap()).setting(Setting::Steps(100_000));
    let end = run.start().unwrap().complete().unwrap().state;
    let half = chain.layout().half();
    let apart = start.as_slice()[..2 * half].iter().zip(&end).fold(0.0, |far: f64, (a, b)| far.max((a - b).abs()));
    assert!(apart < 1e-9, "{apart:e}");
    let samples = orbit.samples(&DrivenShooting::default()).unwrap();
    for k in 0..32 {
        for i in 0..10 {
            // A reflection turns displacements round.
            let off = samples[k][i] + samples[k + 32][9 - i];
            assert!(off.abs() < 1e-9, "{k} {i}: {off:e}");
        }
    }
    let ledger = chain.layout().ledger(&samples[64]).unwrap();
    // Tolerance 1e-11 in units of the drive, for each of some 500 steps of the samples.
    assert!((ledger.driven - ledger.dissipated()).abs() < 500.0 * 1e-11 * 0.12, "{ledger:?}");
    assert!(orbit.spectrum(&DrivenShooting::default()).unwrap().liouville < 1e-8);
}

#[test]
fn what_has_no_periodic_drive_is_refused() {
    let chain = |drives: Vec<Drive>| {
        let bare = Chain::new(Params::new(1.5, 1.0, 1.0).unwrap(), Boundary::Fixed, 3).unwrap();
        bare.with(&Details { drives, ..Details::default() }).unwrap()
    };
    let burst = Envelope::Burst { start: 0.0, length: 3.0 };
    let harmonics = vec![Harmonic { amplitude: 0.1, omega: 1.0, phase: 0.0 }];
    for (drives, words) in [
        (vec![], "drive is missing"),
        (vec![Drive { site: 1, kind: DriveKind::Force, signal: Signal::new(harmonics, burst) }], "burst"),
        (vec![sine(1, DriveKind::Force, 0.1, 1.0), sine(2, DriveKind::Force, 0.1, 2f64.sqrt())], "no multiples of one"),
        (vec![sine(1, DriveKind::Force, 0.0, 1.0)], "amplitude = 0"),
    ] {
        let said = DrivenSetting::new(&chain(drives), 1).unwrap_err().to_string();
        assert!(said.contains(words), "{said}");
    }
    let good = chain(vec![sine(1, DriveKind::Force, 0.1, 3.0), sine(2, DriveKind::Force, 0.1, 2.0)]);
    assert!(DrivenSetting::new(&good, 0).unwrap_err().to_string().contains("turns = 0"));
    // 3 and 2 are multiples of 1.
    assert!((DrivenSetting::new(&good, 2).unwrap().period() - 4.0 * PI).abs() < 1e-12);
}

fn fastest_rate(params: (f64, f64), details: Details, turns: u32, z: f64) -> f64 {
    let harmonics = vec![Harmonic { amplitude: 0.1, omega: 0.5, phase: 0.0 }];
    let signal = Signal::new(harmonics, Envelope::None);
    let details = Details { drives: vec![Drive { site: 0, kind: DriveKind::Force, signal }], ..details };
    let setting = DrivenSetting::new(&four_beads(params, &details), turns).unwrap();
    setting.fastest_rate(&vec![z; setting.unknowns()]).unwrap() * 0.5
}

fn four_beads((kappa, rho): (f64, f64), details: &Details) -> Chain<f64> {
    let params = Params::new(1.5, kappa, rho).unwrap();
    Chain::new(params, Boundary::Fixed, 4).unwrap().precompressed(1.0).unwrap().with(details).unwrap()
}

// Truth: the upper edge of the band of a long chain, 4 k = 6 at the overlap 1; the frequency of
// a bead against its resonator; the largest mode of four beads that differ.
#[test]
fn rates_are_bounded_by_those_of_long_chains() {
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-14;
    let none = Details::default;
    assert!(near(fastest_rate((0.0, 0.0), none(), 1, 0.0), 6f64.sqrt()));
    assert!(near(fastest_rate((0.0, 0.0), none(), 3, 0.0), 3.0 * 6f64.sqrt()));
    assert!(near(fastest_rate((0.0, 0.0), none(), 1, 1.5), 12f64.sqrt()));
    assert!(near(fastest_rate((1.0, 1.0 / 3.0), none(), 1, 0.0), 10f64.sqrt()));
    let damped = |dashpot: f64| Details { drag: vec![0.0, 7.0, 0.0, 0.0], dashpot: vec![dashpot; 4], ..none() };
    assert!(near(fastest_rate((0.0, 0.0), damped(0.0), 1, 0.0), 7.0));
    assert!(near(fastest_rate((1.0, 1.0 / 3.0), damped(2.0), 1, 0.0), 15.0));
    let differing = Details { mass: vec![1.0, 0.2, 3.0, 0.5], contact: vec![1.0, 2.0, 0.3, 4.0, 1.0], ..none() };
    let modes = NormalModes::new(&four_beads((1.0, 0.5), &differing)).unwrap();
    let largest = modes.linear().iter().map(|mode| mode.omega).fold(0.0, f64::max);
    assert!(fastest_rate((1.0, 0.5), differing, 1, 0.0) > largest && largest > 6f64.sqrt());
}
