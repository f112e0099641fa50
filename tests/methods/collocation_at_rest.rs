//! Contact collocation on long chains at rest that are struck: nothing but contacts that are yet to
//! come limits its windows.

use crate::{common::truth, properties::properties};
use hertzchain::{
    chain::{Boundary, Chain, Params, State},
    integrators::{Stepper, collocation::StepControl},
    run::{deviation, perturb},
    scene::Scene,
};
use proptest::{
    prelude::*,
    test_runner::{Config, TestError, TestRunner},
};
use std::cell::RefCell;

const TOLERANCES: [f64; 8] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8];
/// The tolerance of the runs that others are held against; other tests hold it against another
/// method.
const FINE: f64 = 1e-12;
/// Windows after which a run is given up: twenty times as many as any needs.
const MOST_WINDOWS: u64 = 20_000;

/// A chain at rest with some beads struck.
#[derive(Clone, Debug)]
struct Struck {
    chain: Chain<f64>,
    y0: Vec<f64>,
    end: f64,
}

/// What a run came to.
struct Outcome {
    y: Vec<f64>,
    evaluations: u64,
    /// The largest `f'(g) h^2` of a window, by overlaps at its ends.
    stiffness: f64,
}

/// A run by collocation; `None` if it failed or did not end.
fn run(chain: &Chain<f64>, y0: &[f64], end: f64, tol: f64) -> Option<Outcome> {
    let mut run = chain.collocation(y0, (0.0, end), StepControl::Tolerance(tol)).unwrap();
    let (law, mut y) = (chain.law(), y0.to_vec());
    let overlap = |y: &[f64]| chain.overlaps(chain.layout().u(y)).into_iter().fold(0.0, f64::max);
    let (mut t, mut g, mut stiffness) = (0.0, overlap(y0), 0.0_f64);
    while !run.done() {
        run.step().ok()?;
        let stats = run.stats();
        if stats.steps + stats.rejected > MOST_WINDOWS {
            return None;
        }
        let (now, before) = (run.time(), g);
        run.sample(now, &mut y);
        g = overlap(&y);
        stiffness = stiffness.max(law.stiffness(g.max(before)) * (now - t).powi(2));
        t = now;
    }
    Some(Outcome { y, evaluations: run.stats().force_evaluations, stiffness })
}

/// How many times larger the motion makes errors of velocities, made at the start or half way,
/// until the end; at least 1.
fn amplification(Struck { chain, y0, end }: &Struck) -> f64 {
    const CHANGE: f64 = 1e-7;
    let fine = |y: &[f64], time: f64| run(chain, y, time, FINE).expect("fine runs end").y;
    let half = fine(y0, 0.5 * end);
    let last = fine(&half, 0.5 * end);
    let grown = |from: &[f64], time: f64| {
        let mut y = from.to_vec();
        let velocities = &mut y[from.len() / 2..];
        let size = velocities.iter().fold(0.0, |most: f64, velocity| most.max(velocity.abs()));
        perturb(velocities, CHANGE * size, 1e-3 * size);
        deviation(&fine(&y, time), &last) / CHANGE
    };
    grown(y0, *end).max(grown(&half, 0.5 * end)).max(1.0)
}

fn struck() -> impl Strategy<Value = Struck> {
    let alpha = prop::sample::select(vec![1.2, 1.5, 2.5]);
    let rho = prop_oneof![Just(0.0), Just(f64::INFINITY), (-1.0..1.0_f64).prop_map(|x| 10_f64.powf(x))];
    let boundary = prop::sample::select(Boundary::ALL.to_vec());
    let pressed = prop::bool::weighted(0.2);
    let velocities =
        prop_oneof![Just(vec![1.0]), Just(vec![-1.0]), prop::collection::vec(prop_oneof![-1.0..-0.1, 0.1..1.0], 5)];
    let sites = (5.5..7.6_f64).prop_map(|x| x.exp() as usize);
    let span = (3.0..6.0_f64).prop_map(f64::exp);
    (alpha, rho, boundary, pressed, velocities, sites, 0.0..1.0_f64, span).prop_map(
        |(alpha, rho, boundary, pressed, velocities, sites, place, span)| {
            let holds = matches!(boundary, Boundary::Fixed | Boundary::Ring);
            let chain = Chain::new(Params::new(alpha, 1.0, rho).unwrap(), boundary, sites).unwrap();
            let chain = chain.precompressed(if pressed && holds { 0.01 } else { 0.0 }).unwrap();
            let mut state = State::rest(&chain);
            let first = (place * (sites - 20) as f64) as usize;
            let u_dot = state.u_dot_mut();
            for (k, v) in velocities.into_iter().enumerate() {
                let bead = first + 3 * k;
                u_dot[bead] += v;
                if boundary == Boundary::StrainRing {
                    u_dot[bead + 1] -= v;
                }
            }
            // A plain chain has no time of its own, so that nothing but the span gives the first
            // window a length.
            let end = if rho == 0.0 { span } else { span.min(150.0) };
            Struck { y0: state.as_slice().to_vec(), chain, end }
        },
    )
}

#[test]
fn chains_at_rest_keep_loose_tolerances() {
    // No run may fail; errors are at most three times the tolerance, times what the dynamics makes
    // of an error; a looser tolerance costs no more, but for a fifth; no window is longer than the
    // contacts at its ends allow. Truth: collocation at 1e-12, itself held against
    // regularised runs in collocation.rs and contact_times.rs. Measured over 24 cases: 0.26 of the
    // tolerance, 1.02 of the cost, f'(g) h^2 = 1.33.
    let worst = RefCell::new([0.0_f64; 3]);
    let config = Config { max_shrink_iters: 0, ..properties(6) };
    let outcome = TestRunner::new(config).run(&struck(), |case| {
        let Struck { chain, y0, end } = &case;
        let reference = run(chain, y0, *end, FINE).expect("a fine run ends");
        let amplification = amplification(&case);
        let mut finer = reference.evaluations;
        for tol in TOLERANCES.into_iter().rev() {
            let outcome = run(chain, y0, *end, tol);
            prop_assert!(outcome.is_some(), "tol {tol:e} fails");
            let Outcome { y, evaluations, stiffness } = outcome.unwrap();
            let ratio = deviation(&y, &reference.y) / (tol * amplification);
            let cost = evaluations as f64 / finer as f64;
            let worst = &mut worst.borrow_mut();
            **worst = [worst[0].max(ratio), worst[1].max(cost), worst[2].max(stiffness)];
            prop_assert!(ratio < 3.0, "tol {tol:e}: {ratio} times what was asked for");
            prop_assert!(cost < 1.2, "tol {tol:e}: {cost} times the cost of the next finer one");
            prop_assert!(stiffness < 1.5, "tol {tol:e}: a window of f'(g) h^2 = {stiffness}");
            finer = evaluations;
        }
        Ok(())
    });
    println!("worst: error, cost, stiffness {:?}", worst.borrow());
    if let Err(TestError::Fail(why, Struck { chain, y0, end })) = outcome {
        let struck: Vec<_> = y0.iter().enumerate().filter(|(_, v)| **v != 0.0).collect();
        panic!("{why}: {:?}, {:?}, {} sites, end {end}, {struck:?}", chain.params(), chain.boundary(), chain.sites());
    }
}

#[test]
fn a_chain_that_stays_closed_takes_fewer_nodes() {
    // Truth: the regularised run. Measured: errors of 4e-9 and 7e-12, and 1620 and 8412 evaluations
    // of forces; with the first number of nodes to the end 3544 and 11460.
    let scene = Scene::load("precompressed").unwrap();
    let (chain, y0, end) = (scene.chain(), scene.initial().as_slice(), scene.end());
    let want = truth(chain, y0, end, 1e-14);
    for (tol, most) in [(1e-5, 2500), (1e-9, 10_000)] {
        let Outcome { y, evaluations, .. } = run(chain, y0, end, tol).unwrap();
        let error = deviation(&y, &want);
        println!("{tol:e}: {error:e}, {evaluations}");
        assert!(error < tol && evaluations < most, "{tol:e}: {error:e}, {evaluations}");
    }
}

#[test]
fn an_impact_on_a_thousand_beads_keeps_its_energy() {
    // Before anything touches nothing is known but the span: a first window of 0.3 of it held the
    // whole impact, and made an energy of 10^6. Measured: 2.8e-4, 2.9e-4, 2.4e-4, 3.1e-7.
    let scene = Scene::load_with("impact", &["chain.sites=1000".into(), "span.until=1000".into()]).unwrap();
    let (chain, y0) = (scene.chain(), scene.initial().as_slice());
    for (tol, bound) in [(1e-1, 1e-3), (1e-2, 1e-3), (1e-3, 1e-3), (1e-4, 1e-6)] {
        let Some(Outcome { y, .. }) = run(chain, y0, scene.end(), tol) else { panic!("tol {tol:e} does not end") };
        let drift = (chain.energy(&y).total() / chain.energy(y0).total() - 1.0).abs();
        println!("{tol:e}: energy off by {drift:.1e}");
        assert!(drift < bound, "{tol:e}: {drift:e}");
    }
}

#[test]
fn a_contact_that_fades_ends() {
    // Beads part so slowly that the overlap is within what a loose tolerance counts as none, and is
    // far below zero when it no longer is: the contact is then over before the window begins. Its
    // end was moved back and forth for ever. Truth: the run at 1e-12.
    let chain = Chain::<f64>::new(Params::new(2.5, 1.0, 0.0).unwrap(), Boundary::StrainRing, 250).unwrap();
    let mut state = State::rest(&chain);
    for (bead, v) in [
        (51, -0.2633938444774664),
        (54, 0.8321860892316184),
        (57, -0.035636726394083995),
        (60, 0.16350737675156535),
        (63, 0.7851647680504585),
    ] {
        (state.u_dot_mut()[bead], state.u_dot_mut()[bead + 1]) = (v, -v);
    }
    let y0 = state.as_slice().to_vec();
    let case = Struck { chain, y0, end: 194.98736358715203 };
    let reference = run(&case.chain, &case.y0, case.end, FINE).unwrap().y;
    let amplification = amplification(&case);
    for tol in (0..17).map(|k| 10_f64.powf(-1.0 - f64::from(k) / 8.0)) {
        let Some(outcome) = run(&case.chain, &case.y0, case.end, tol) else { panic!("tol {tol:e} does not end") };
        let ratio = deviation(&outcome.y, &reference) / (tol * amplification);
        assert!(ratio < 3.0, "tol {tol:e}: {ratio} times what was asked for");
    }
}
