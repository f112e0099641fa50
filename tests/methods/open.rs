//! Contact collocation of chains that are damped and driven.

use crate::{
    common::distance,
    details::{run, stored},
    heterogeneous::{
        BOUNDARIES, balance, collocation, contacts_are_found, errors_in_tolerances, list, lively, of, order, random,
        same_for_every_set,
    },
    windows,
};
use hertzchain::{
    chain::{Boundary, Chain, Details, Drive, DriveKind, Envelope, Harmonic, Params, Signal},
    integrators::{Silent, collocation::StepControl, drive},
    run::{Method, Setting},
};
use std::f64::consts::TAU;

fn harmonic(amplitude: f64, omega: f64, phase: f64) -> Harmonic {
    Harmonic { amplitude, omega, phase }
}

/// A chain in which everything differs, with drag, dashpots, a bead that is moved, and beads that
/// are pushed under a ramp and by a burst; and a state in which beads meet and part.
fn varied(seed: u64, boundary: Boundary, sites: usize) -> (Chain<f64>, Vec<f64>) {
    let mut next = random(seed);
    let mut within = |from: f64, to: f64| from + (to - from) * next();
    let uniform = Chain::<f64>::new(Params::new(1.5, 1.0, 1.0).unwrap(), boundary, sites).unwrap();
    let bonds = uniform.touching().len();
    let exponents = [1.5, 1.5, 1.5, 2.0, 2.5];
    let held = if boundary == Boundary::Free { 0.0 } else { 0.2 };
    let mut list = |count: usize, from: f64, to: f64| list(&mut within, count, from, to);
    let of_resonator = |rho: f64| {
        if rho > 2.2 {
            f64::INFINITY
        } else if rho < 0.3 {
            0.0
        } else {
            rho
        }
    };
    let mut rho: Vec<f64> = list(sites, -0.5, 2.5).into_iter().map(of_resonator).collect();
    let (mut kappa, mut drag) = (list(sites, 0.5, 2.0), list(sites, -0.1, 0.3));
    (rho[0], kappa[0], drag[0]) = (0.0, 0.0, 0.0);
    let damped = |(dashpot, rho): (f64, &f64)| if *rho == 0.0 { 0.0 } else { dashpot.max(0.0) };
    let dashpot = list(sites, -0.1, 0.4).into_iter().zip(&rho).map(damped);
    let drive = |site, kind, harmonics, envelope| Drive { site, kind, signal: Signal::new(harmonics, envelope) };
    let details = Details {
        dashpot: dashpot.collect(),
        drag: drag.into_iter().map(|drag| drag.max(0.0)).collect(),
        mass: list(sites, 0.5, 2.0),
        contact: list(bonds, 0.5, 2.0),
        alpha: list(bonds, 0.0, 5.0).into_iter().map(|k| exponents[k as usize]).collect(),
        overlap: list(bonds, -0.2, held),
        drives: vec![
            drive(0, DriveKind::Displacement, vec![harmonic(0.2, 1.7, 0.3), harmonic(0.1, 0.9, 1.0)], Envelope::None),
            drive(sites - 3, DriveKind::Force, vec![harmonic(0.5, 2.5, 0.0)], Envelope::Ramp(3.3)),
            drive(2, DriveKind::Force, vec![harmonic(0.8, 1.1, 0.5)], Envelope::Burst { start: 1.3, length: 4.0 }),
            drive(2, DriveKind::Force, vec![harmonic(0.1, 0.0, TAU / 4.0)], Envelope::None),
        ],
        rho,
        kappa,
        ..Details::default()
    };
    let chain = uniform.with(&details).unwrap();
    let y0 = lively(&chain, &mut within);
    (chain, y0)
}

#[test]
fn two_hundred_contacts_of_damped_and_driven_beads_are_those_of_another_program() {
    // Truth: `tests/reference/quad.c`, with 33 digits: state, what is dissipated and driven.
    // Measured at tolerances from 1e-14 to 2e-14: at most 1.2e-12, balance 1.2e-14 to 7.2e-14,
    // which is rounding; DOP853 7.0e-12.
    let (chain, state, end, want) = stored("driven");
    let asked = of(&chain, state.as_slice(), end).method(Method::Collocation).tolerance(1e-14).unwrap().contacts();
    let got = asked.start().unwrap().complete().unwrap();
    let contacts = got.contacts.unwrap().len();
    let (error, off) = (distance(&got.state, &want), got.energy_error.unwrap());
    // Its tolerance is that of a step, and the map from velocities at the start has entries of
    // 1000: at 3e-15 it errs by 1.5e-11, in 32 digits by 1.3e-11.
    let other = run(&chain, &state, end, "dop853-regularised", Setting::Tolerance(1e-15)).state;
    println!("{error:e}, balance {off:e}, {contacts} contacts, dop853 {:e}", distance(&other, &want));
    assert!(error < 2e-12 && off < 1.5e-13 && contacts >= 200, "{error:e} {off:e} {contacts}");
    assert!(distance(&other, &want) < 1e-11);
    let ledger = chain.layout().ledger(&want).unwrap();
    assert!(ledger.drag > 0.1 && ledger.dashpots > 0.1 && ledger.driven > 0.1);
}

#[test]
fn tolerances_are_kept_over_seven_decades() {
    let errors = errors_in_tolerances(|seed, boundary| varied(seed, boundary, 12), 8);
    assert!(errors.iter().all(|error| *error < 1.0), "{errors:?}");
}

#[test]
fn energy_dissipated_and_driven_balance() {
    // Truth: energy + dissipated - driven is constant. Every part is measured on its own. Measured
    // at tolerances from 1e-13 to 1.9e-13: 2e-16 to 1.4e-14, and up to 2.3e-14 with another order
    // of the sums; this is rounding.
    for (seed, boundary) in BOUNDARIES.into_iter().enumerate() {
        let (chain, y0) = varied(10 + seed as u64, boundary, 12);
        let end = collocation(&chain, &y0, 40.0, StepControl::Tolerance(1e-13));
        let ledger = chain.layout().ledger(&end).unwrap();
        let off = (balance(&chain, &end) - balance(&chain, &y0)).abs();
        println!("{boundary:?}: {off:e}, {ledger:?}");
        assert!(off < 3e-14 && ledger.drag > 0.01 && ledger.dashpots > 0.01 && ledger.driven.abs() > 0.01);
    }
}

#[test]
fn the_order_of_windows_is_that_of_closed_chains() {
    // Truth: the finest run; and the order of the same chain without damping and drives, in the
    // same windows. Mean of errors over nearby numbers of windows, of the state and of the ledger.
    for seed in 0..2 {
        let (open, y0) = varied(seed, Boundary::Fixed, 8);
        let closed = Details { drag: vec![], dashpot: vec![], drives: vec![], ..open.details().unwrap().clone() };
        let uniform = Chain::<f64>::new(Params::new(1.5, 1.0, 1.0).unwrap(), Boundary::Fixed, 8).unwrap();
        let closed = uniform.with(&closed).unwrap();
        let split = 2 * open.layout().half();
        let slope = |chain: &Chain<f64>, part| order(chain, &y0[..chain.layout().dim()], part, (40, 4));
        let [state, ledger] = [0..split, split..split + 4].map(|part| slope(&open, part));
        let reference = slope(&closed, 0..split);
        println!("{seed}: {state:.2} {ledger:.2}, closed {reference:.2}");
        assert!(state > reference - 0.5 && ledger > reference - 0.5 && state > 3.5, "{state} {ledger} {reference}");
    }
}

#[test]
fn motions_without_contacts_are_their_closed_forms() {
    // Truth: u = e^{-n t} (u0 cos w t + (u0' + n u0)/w sin w t) of a bead on a spring to a
    // resonator at rest, w^2 = kappa/m - n^2, n = c/2m, by drag or by a dashpot, weak or strong.
    // What it dissipates is the energy that it lacks.
    let params = Params::new(1.5, 1.0, f64::INFINITY).unwrap();
    let alone = Chain::<f64>::new(params, Boundary::Free, 1).unwrap();
    for (drag, dashpot) in [(0.3, 0.0), (0.0, 0.3), (0.5, 0.6), (2.0, 0.0), (0.0, 7.0)] {
        let one = |x: f64| vec![x];
        let details =
            Details { mass: one(1.5), kappa: one(2.0), drag: one(drag), dashpot: one(dashpot), ..Details::default() };
        let chain = alone.clone().with(&details).unwrap();
        let (n, t, u0, v0) = ((drag + dashpot) / 3.0, 9.0, 0.4f64, -0.7f64);
        let square: f64 = 2.0 / 1.5 - n * n;
        let w = square.abs().sqrt();
        let (sin, cos) = if square > 0.0 { (w * t).sin_cos() } else { ((w * t).sinh(), (w * t).cosh()) };
        let want = (-n * t).exp() * (u0 * cos + (v0 + n * u0) / w * sin);
        let got = collocation(&chain, &[u0, v0, 0.0, 0.0, 0.0, 0.0], t, StepControl::Tolerance(1e-12));
        let off = (balance(&chain, &got) - balance(&chain, &[u0, v0, 0.0, 0.0, 0.0, 0.0])).abs();
        println!("{drag} {dashpot}: {:e}, balance {off:e}", got[0] - want);
        assert!((got[0] - want).abs() < 4e-16 && off < 7e-16, "{drag} {dashpot}: {:e} {off:e}", got[0] - want);
    }
    // Truth: a bead under F sin(w t) with drag, m u'' = F sin(w t) - c u', from rest; and what the
    // force has done is energy and dissipated.
    let (m, c, force, w, t) = (1.5, 0.4, 0.8, 1.9, 12.0f64);
    let drives = vec![Drive { site: 0, kind: DriveKind::Force, signal: Signal::sine(force, w, 0.0) }];
    let details = Details { mass: vec![m], drag: vec![c], drives, ..Details::default() };
    let plain = Chain::<f64>::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 1).unwrap();
    let chain = plain.with(&details).unwrap();
    let got = collocation(&chain, &[0.0; 6], t, StepControl::Tolerance(1e-12));
    let k = c / m;
    let speed = force / m * (w * (-k * t).exp() + k * (w * t).sin() - w * (w * t).cos()) / (k * k + w * w);
    println!("pushed: {:e}, balance {:e}", got[1] - speed, balance(&chain, &got));
    assert!((got[1] - speed).abs() < 5e-16 && balance(&chain, &got).abs() < 3e-16);
}

#[test]
fn damping_that_is_next_to_none_changes_nothing() {
    // Truth: the chain without it, whose paths are sines and cosines: two ways to the same motion.
    // Roundings, which contacts enlarge.
    for (seed, boundary) in BOUNDARIES.into_iter().enumerate() {
        let (open, y0) = varied(20 + seed as u64, boundary, 10);
        let closed = Details { drag: vec![], dashpot: vec![], drives: vec![], ..open.details().unwrap().clone() };
        let bare = Chain::<f64>::new(Params::new(1.5, 1.0, 1.0).unwrap(), boundary, 10).unwrap();
        let almost = Details { drag: vec![1e-300; 10], ..closed.clone() };
        let (closed, almost) = (bare.clone().with(&closed).unwrap(), bare.with(&almost).unwrap());
        let control = windows(80, 12);
        let want = collocation(&closed, &y0[..y0.len() - 4], 8.0, control);
        let got = collocation(&almost, &y0, 8.0, control);
        let gap = distance(&got[..want.len()], &want);
        println!("{boundary:?}: {gap:e}");
        assert!(gap < 1e-15, "{gap:e}");
    }
}

#[test]
fn strong_damping_is_resolved() {
    // Truth: plain DOP853 at 1e-14; rates of damping up to 300 times those of contacts, and
    // resonators of a hundredth of the mass.
    let n = 5;
    let details = Details {
        rho: vec![0.01, 1.0, f64::INFINITY, 0.0, 0.01],
        drag: vec![0.0, 0.0, 90.0, 4.0, 0.5],
        dashpot: vec![1.5, 40.0, 0.0, 0.0, 0.0],
        ..Details::default()
    };
    let uniform = Chain::<f64>::new(Params::new(1.5, 1.0, 1.0).unwrap(), Boundary::Free, n).unwrap();
    let chain = uniform.with(&details).unwrap();
    let mut y0 = vec![0.0; 4 * n + 4];
    (y0[2 * n], y0[2 * n + 4]) = (1.0, -0.7);
    let want = run(&chain, of(&chain, &y0, 4.0).initial(), 4.0, "dop853", Setting::Tolerance(1e-14)).state;
    for tol in [1e-6, 1e-10] {
        let got = collocation(&chain, &y0, 4.0, StepControl::Tolerance(tol));
        println!("{tol:e}: {:e}", distance(&got, &want));
        assert!(distance(&got, &want) < tol);
    }
}

#[test]
fn contacts_are_those_that_a_search_of_every_step_finds() {
    contacts_are_found(varied(4, Boundary::Fixed, 12), 30, [5e-11, 5e-11, 5e-12, f64::INFINITY]);
}

#[test]
fn instruction_sets_and_samples_do_not_change_bits() {
    let (chain, y0) = varied(3, Boundary::Ring, 12);
    same_for_every_set(&chain, &y0, 6.0);
}

#[test]
fn legs_continue_each_other() {
    // Truth: the run in one go, to the tolerance. A leg begins at its own time of the drives.
    let (chain, y0) = varied(5, Boundary::Fixed, 12);
    let whole = collocation(&chain, &y0, 6.0, StepControl::Tolerance(1e-12));
    let mut y = y0;
    for (from, to) in [(0.0, 1.1), (1.1, 3.7), (3.7, 6.0)] {
        let mut run = chain.heterogeneous_collocation(&y, (from, to), StepControl::Tolerance(1e-12)).unwrap();
        drive(&mut run, &mut Silent, &mut y).unwrap();
    }
    println!("{:e}", distance(&y, &whole));
    assert!(distance(&y, &whole) < 5e-15);
}

#[cfg(feature = "parallel")]
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    // Three blocks, and one in which nothing happens.
    let (chain, mut y0) = varied(6, Boundary::Free, 1000);
    let details = Details { drives: chain.details().unwrap().drives[..1].to_vec(), ..chain.details().unwrap().clone() };
    let bare = Chain::<f64>::new(Params::new(1.5, 1.0, 1.0).unwrap(), Boundary::Free, 1000).unwrap();
    let chain = bare.with(&details).unwrap();
    for part in y0[..4000].chunks_mut(1000) {
        part[600..].fill(0.0);
    }
    let one = crate::heterogeneous::same_on_any_threads(&chain, &y0, 2.0, 1e-12);
    // Blocks are solved separately and fit together, also in the ledger.
    let off = (balance(&chain, &one) / balance(&chain, &y0) - 1.0).abs();
    println!("balance {off:e}");
    assert!(off < 3e-15, "{off:e}");
}

#[test]
fn the_tangent_map_is_that_of_the_variational_equation() {
    // Truth: the variational equation by regularised DOP853, of beads and resonators that are free.
    for seed in [7, 8, 9] {
        let (chain, y0) = varied(seed, BOUNDARIES[seed as usize % 3], 6);
        let gap = crate::heterogeneous::off_variations(&chain, &y0, 5.0, |i| i != 0);
        println!("{seed}: {gap:e}");
        assert!(gap < 1e-11, "{seed}: {gap:e}");
    }
}

#[test]
fn the_tangent_map_of_one_damped_bead_is_its_closed_form() {
    // Truth: exp(A t) of m u'' = -kappa u - c u', as in the test of motions above, whatever the
    // state and the push; the bead does not touch anything, and the resonator rests.
    let (mass, kappa, t) = (1.5, 2.0, 9.0f64);
    for (drag, dashpot) in [(0.3, 0.0), (0.0, 0.3), (0.5, 0.6), (2.0, 0.0), (0.0, 7.0)] {
        let push = Drive { site: 0, kind: DriveKind::Force, signal: Signal::sine(0.4, 1.3, 0.0) };
        let one = |x: f64| vec![x];
        let details = Details {
            mass: one(mass),
            kappa: one(kappa),
            drag: one(drag),
            dashpot: one(dashpot),
            drives: vec![push],
            ..Details::default()
        };
        let alone = Chain::<f64>::new(Params::new(1.5, 1.0, f64::INFINITY).unwrap(), Boundary::Free, 1).unwrap();
        let chain = alone.with(&details).unwrap();
        let n = (drag + dashpot) / (2.0 * mass);
        let square: f64 = kappa / mass - n * n;
        let w = square.abs().sqrt();
        let (sin, cos) = if square > 0.0 { (w * t).sin_cos() } else { ((w * t).sinh(), (w * t).cosh()) };
        let decay = (-n * t).exp();
        let want = [cos + n / w * sin, -kappa / mass / w * sin, sin / w, cos - n / w * sin].map(|x| decay * x);
        let got = chain.monodromy(&[0.4, -0.7, 0.0, 0.0, 0.0, 0.0], (0.0, t), StepControl::Tolerance(1e-12)).unwrap();
        let off = distance(&[got[0], got[1], got[6], got[7]], &want);
        println!("{drag} {dashpot}: {off:e}");
        assert!(off < 1e-15, "{drag} {dashpot}: {off:e}");
    }
}
