//! Every scheme on both flows of the chain: structure, order, exactness, counts.

use crate::numbers::{assert_below, distance, random_signed};
use hertzchain::chain::{Boundary, Chain, Field, KineticFlow, LinearFlow, Params};
use hertzchain::integrators::{
    Dop853, Error, Scheme, Silent, SplitFlow, Splitting, Stats, Stepper, Stop,
    dop853::Options,
    drive,
    splitting::{First, tables},
};
use std::f64::consts::PI;
use tables::{ALL, STRANG, YOSHIDA4};

const EPS: f64 = f64::EPSILON;
const FLOWS: [Flow; 2] = [Flow::Kinetic, Flow::Linear];

/// One of the two ways to split a chain.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Flow {
    Kinetic,
    Linear,
}

fn assert_near(value: f64, want: f64, tolerance: f64, what: &str) {
    println!("{what}: {value:.3}, want {want} +- {tolerance}");
    assert!((value - want).abs() <= tolerance, "{what}: {value}, not {want} +- {tolerance}");
}

fn random_state(chain: &Chain<f64>, seed: u64, size: f64) -> Vec<f64> {
    let mut next = random_signed(seed);
    (0..chain.layout().dim()).map(|_| size * next()).collect()
}

fn walled(alpha: f64, rho: f64, sites: usize) -> Chain<f64> {
    Chain::new(Params::new(alpha, 1.0, rho).unwrap(), Boundary::Fixed, sites).unwrap()
}

/// The flow with which compositions begin by default: it suits the split.
fn natural(flow: Flow) -> First {
    match flow {
        Flow::Kinetic => First::Kick,
        Flow::Linear => First::Drift,
    }
}

fn start<S: SplitFlow<f64> + 'static>(
    scheme: &Scheme,
    first: First,
    mut flow: S,
    y: &[f64],
    end: f64,
    steps: u64,
) -> Box<dyn Stepper<f64>> {
    flow.load(y);
    Box::new(Splitting::new(scheme, first, flow, (0.0, end), steps).unwrap())
}

fn stepper(
    chain: &Chain<f64>,
    flow: Flow,
    scheme: &Scheme,
    first: First,
    y: &[f64],
    end: f64,
    steps: u64,
) -> Box<dyn Stepper<f64>> {
    match flow {
        Flow::Kinetic => start(scheme, first, KineticFlow::new(chain.clone()), y, end, steps),
        Flow::Linear => start(scheme, first, LinearFlow::new(chain.clone()), y, end, steps),
    }
}

fn finish(run: &mut dyn Stepper<f64>) -> Vec<f64> {
    let mut y = vec![f64::NAN; run.dim()];
    assert_eq!(drive(run, &mut Silent, &mut y), Ok(Stop::End));
    y
}

fn integrate(chain: &Chain<f64>, flow: Flow, scheme: &Scheme, y: &[f64], end: f64, steps: u64) -> Vec<f64> {
    finish(&mut *stepper(chain, flow, scheme, natural(flow), y, end, steps))
}

/// The state at the end by an independent method.
fn by_dop853(chain: &Chain<f64>, y: &[f64], end: f64) -> Vec<f64> {
    let options = Options { atol: 1e-15, ..Options::new(1e-14) };
    finish(&mut Dop853::new(Field::new(chain.clone()), y, (0.0, end), options).unwrap())
}

/// `-d log(errors) / d log(steps)` by least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|&(steps, error)| (steps.ln(), error.ln())).collect();
    -line(&logs).0
}

/// Slope and intercept of the least-squares line.
fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let mean = |f: fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let covariance: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    let variance: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    (covariance / variance, y - covariance / variance * x)
}

fn backwards(mut y: Vec<f64>) -> Vec<f64> {
    let half = y.len() / 2;
    y[half..].iter_mut().for_each(|q_dot| *q_dot = -*q_dot);
    y
}

#[test]
fn a_run_with_reversed_velocities_leads_back_to_its_start() {
    // Truth: every scheme is a palindrome of reversible flows. The remainder is rounding, amplified
    // by the motion.
    let mut worst = 0.0_f64;
    for (rho, seed) in [(0.5, 1), (0.0, 2), (f64::INFINITY, 3)] {
        let chain = walled(1.5, rho, 6);
        let y = random_state(&chain, seed, 1.0);
        for flow in FLOWS {
            for scheme in ALL {
                let there = integrate(&chain, flow, scheme, &y, 6.0, 120);
                assert!(distance(&there, &y) > 0.1);
                let back = backwards(integrate(&chain, flow, scheme, &backwards(there), 6.0, 120));
                worst = worst.max(distance(&back, &y) / EPS);
            }
        }
    }
    assert_below(worst, 80.0, "way back, in eps");
}

/// A walled chain with a precompression so large that no contact opens, and a motion in it.
fn smooth_motion() -> (Chain<f64>, Vec<f64>) {
    let chain = walled(1.5, 0.5, 6).precompressed(1.0).unwrap();
    let y = random_state(&chain, 5, 0.4);
    (chain, y)
}

/// Calls `look` with the state after every step of a fine run.
fn watch(chain: &Chain<f64>, y: &[f64], end: f64, mut look: impl FnMut(&[f64])) {
    let mut run = stepper(chain, Flow::Linear, &STRANG, First::Drift, y, end, 4000);
    let mut y = y.to_vec();
    while !run.done() {
        run.step().unwrap();
        run.sample(run.time(), &mut y);
        look(&y);
    }
}

/// The order on the four finest of a ladder of numbers of steps, each sqrt 2 times the last, for
/// errors well above round-off.
fn measured_order(error: impl Fn(u64) -> f64) -> f64 {
    let steps = (4..=22).map(|k| 2_f64.powf(0.5 * f64::from(k)).round() as u64);
    let errors: Vec<(f64, f64)> =
        steps.map(|steps| (steps as f64, error(steps))).filter(|&(_, error)| error > 1e-13).collect();
    slope(&errors[errors.len() - 4..])
}

#[test]
fn every_scheme_has_its_order_and_no_more_while_no_contact_opens() {
    // Truth: the order conditions. Errors are measured against DOP853, which is independent of
    // splitting. Round-off: 5e-15.
    let (chain, y) = smooth_motion();
    let end = 12.0;
    let mut least = f64::INFINITY;
    watch(&chain, &y, end, |y| {
        least = chain.overlaps(chain.layout().u(y)).into_iter().fold(least, f64::min);
    });
    assert!(least > 0.4, "a contact all but opened: {least}");
    let truth = by_dop853(&chain, &y, end);
    for flow in FLOWS {
        for scheme in ALL {
            for first in [First::Drift, First::Kick] {
                let order = measured_order(|steps| {
                    distance(&finish(&mut *stepper(&chain, flow, scheme, first, &y, end, steps)), &truth)
                });
                assert_near(order, f64::from(scheme.order), 0.25, &format!("{} {flow:?} {first:?}", scheme.name));
            }
        }
    }
}

#[test]
fn a_look_inside_a_step_is_as_accurate_as_the_run() {
    // Truth: DOP853. The position of the time in its step differs on each level of the ladder.
    let (chain, y) = smooth_motion();
    let t = 2.7;
    let truth = by_dop853(&chain, &y, t);
    for flow in FLOWS {
        for scheme in ALL {
            let order = measured_order(|steps| {
                let mut run = stepper(&chain, flow, scheme, natural(flow), &y, 4.0, steps);
                while run.time() < t {
                    run.step().unwrap();
                }
                let mut seen = y.clone();
                run.sample(t, &mut seen);
                distance(&seen, &truth)
            });
            assert_near(order, f64::from(scheme.order), 0.5, &format!("look, {} {flow:?}", scheme.name));
        }
    }
}

#[test]
fn a_million_steps_of_free_flight_end_where_one_does() {
    // Truth: u + u' t. The centre of mass is advanced every 64 kicks, each time with the same
    // rounding. At half a unit each, the sum is 7800 eps. Measured: 1160.
    let chain = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 3).unwrap();
    let y = [0.0, 1.0, 2.0, 0.3, 0.4, 0.5];
    for (end, steps) in [(1e5, 1_000_000), (12_345.678, 1_000_000), (1e5, 999_983)] {
        let got = integrate(&chain, Flow::Linear, &STRANG, &y, end, steps);
        let want: Vec<f64> = (0..6).map(|i| if i < 3 { y[i] + y[i + 3] * end } else { y[i] }).collect();
        assert_below(distance(&got, &want) / (0.5 * end) / EPS, 2400.0, "free flight, in eps of the way");
    }
}

/// Relative errors of the energy over time, every 331 steps (not a multiple of a period).
fn energy_errors(chain: &Chain<f64>, run: &mut dyn Stepper<f64>, y: &[f64]) -> Vec<(f64, f64)> {
    let initial = chain.energy(y).total();
    let (mut y, mut errors) = (y.to_vec(), Vec::new());
    while !run.done() {
        run.step().unwrap();
        if run.stats().steps % 331 == 0 {
            run.sample(run.time(), &mut y);
            errors.push((run.time(), chain.energy(&y).total() / initial - 1.0));
        }
    }
    errors
}

/// The change of the fitted line over the run, and the root mean square of the residuals.
fn drift_and_scatter(errors: &[(f64, f64)]) -> (f64, f64) {
    let (slope, at_zero) = line(errors);
    let rest: f64 = errors.iter().map(|(t, error)| (error - at_zero - slope * t).powi(2)).sum();
    (slope * errors[errors.len() - 1].0, (rest / errors.len() as f64).sqrt())
}

#[test]
fn the_energy_does_not_drift_over_a_hundred_thousand_periods() {
    // Truth: a symplectic scheme nearly conserves a modified energy of a smooth system. Contacts
    // that never open are smooth enough, and contacts of alpha = 3 that open (at alpha = 3/2 chaos
    // and kinks make a random walk). Measured: 0.06 of the scatter, and 0.07 (up to 0.28
    // over six motions); the largest error is 3.5 and 10.4 times the scatter.
    let pressed = smooth_motion();
    let opening = walled(3.0, 1.0 / 3.0, 6);
    let opening = (opening.clone(), random_state(&opening, 7, 0.3));
    for ((chain, y), name) in [(&pressed, "pressed"), (&opening, "opening")] {
        let period = 2.0 * PI / chain.params().omega();
        let mut run = stepper(chain, Flow::Linear, &STRANG, First::Drift, y, 1e5 * period, 3_200_000);
        let errors = energy_errors(chain, &mut *run, y);
        let (drift, scatter) = drift_and_scatter(&errors);
        let largest = errors.iter().fold(0.0, |max: f64, (_, error)| max.max(error.abs()));
        println!("{name}: drift {drift:.2e}, scatter {scatter:.2e}, largest {largest:.2e}");
        assert_below(drift.abs() / scatter, 0.5, "drift over scatter");
        assert_below(largest, 17.0 * scatter, "largest error");
    }
}

#[test]
fn counts_are_the_stages_of_the_scheme() {
    // Truth: s kicks a step after merging; for a kick-first scheme each sample costs one more.
    let chain = walled(1.5, 0.5, 3);
    let y = random_state(&chain, 8, 1.0);
    for flow in FLOWS {
        for scheme in ALL {
            for first in [First::Drift, First::Kick] {
                let stages = scheme.stages() as u64;
                let owed = u64::from(scheme.flows::<f64>(first).0 == First::Kick);
                let mut run = stepper(&chain, flow, scheme, first, &y, 1.0, 10);
                let mut out = y.clone();
                run.sample(0.0, &mut out);
                assert_eq!(run.stats(), Stats::default());
                (0..4).for_each(|_| run.step().unwrap());
                let mut want = Stats { steps: 4, rejected: 0, force_evaluations: 4 * stages + owed - 1 };
                assert_eq!(run.stats(), want, "{} {flow:?} {first:?}", scheme.name);
                run.sample(run.time(), &mut out);
                want.force_evaluations += 1;
                assert_eq!(run.stats(), want, "a look at the end of a step");
                run.sample(run.time() - 0.05, &mut out);
                want.force_evaluations += 1 + stages + owed;
                assert_eq!(run.stats(), want, "a look inside a step");
                finish(&mut *run);
                want = Stats { steps: 10, force_evaluations: want.force_evaluations + 6 * stages + 1, ..want };
                assert_eq!(run.stats(), want, "the rest, and the end state");
            }
        }
    }
}

#[test]
fn a_run_that_cannot_be_is_refused() {
    // Truth: the rules of the documentation. An empty span needs no step and changes nothing.
    let chain = walled(1.5, 0.5, 3);
    let new = |span, steps| Splitting::new(&STRANG, First::Drift, LinearFlow::new(chain.clone()), span, steps);
    for (span, steps) in [((0.0, -1.0), 5), ((f64::NAN, 1.0), 5), ((0.0, f64::INFINITY), 5), ((0.0, 1.0), 0)] {
        assert!(matches!(new(span, steps), Err(Error::Argument { .. })), "{span:?} {steps}");
    }
    let y = random_state(&chain, 9, 1.0);
    let mut flow = KineticFlow::new(chain.clone());
    flow.load(&y);
    let mut run = Splitting::new(&YOSHIDA4, First::Kick, flow, (1.0, 1.0), 0).unwrap();
    assert_eq!((finish(&mut run), run.stats().steps), (y, 0));
}
