//! Every scheme on both flows of the chain: structure, order with and without events, exactness,
//! counts.

use crate::numbers::{assert_below, distance, random_signed};
use hertzchain::chain::{Boundary, Chain, Field, KineticFlow, LinearFlow, Params, Site, State};
use hertzchain::integrators::{
    Dop853, DoubleDouble, Error, Observer, Scheme, Silent, SplitFlow, Splitting, Stats, Stepper, Stop, VectorField,
    dop853::Options,
    drive,
    splitting::{First, tables},
};
use nalgebra::DMatrix;
use std::{f64::consts::PI, ops::ControlFlow};
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
    let options = Options { atol: 1e-15, max_step: Some(1e-3), ..Options::new(1e-14) };
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

/// Beads in two groups, for at least a unit of time: contacts inside a group stay closed, the one
/// between the groups stays open.
fn two_clusters() -> (Chain<f64>, Vec<f64>) {
    let chain = Chain::new(Params::new(1.5, 1.0, 0.5).unwrap(), Boundary::Free, 5).unwrap();
    let at = [0.0, -1.0, 4.0, 3.1, 2.0];
    let speed = [0.1, -0.2, 0.05, 0.1, -0.1];
    let site = |i: usize| Site { u: at[i], v: at[i] + speed[4 - i], u_dot: speed[i], v_dot: -speed[i] };
    let y = State::from_fn(&chain, site).unwrap().as_slice().to_vec();
    (chain, y)
}

fn closed_and_open(chain: &Chain<f64>, y: &[f64]) -> Vec<bool> {
    chain.overlaps(chain.layout().u(y)).into_iter().map(|g| g > 0.0).collect()
}

/// The Jacobian of a map by central differences of fourth order, with errors d^4 and eps/d.
fn jacobian(y: &[f64], map: impl Fn(&[f64]) -> Vec<f64>) -> DMatrix<f64> {
    let d = 1e-3;
    let column = |j: usize| {
        let at = |by: f64| {
            let mut y = y.to_vec();
            y[j] += by;
            map(&y)
        };
        let (far, near) = ((at(2.0 * d), at(-2.0 * d)), (at(d), at(-d)));
        (0..y.len()).map(move |i| (8.0 * (near.0[i] - near.1[i]) - (far.0[i] - far.1[i])) / (12.0 * d))
    };
    DMatrix::from_iterator(y.len(), y.len(), (0..y.len()).flat_map(column))
}

/// `max |J^T W J - W|` for `W = sum m dq ^ dq'`, the symplectic form in velocities.
fn symplectic_defect(chain: &Chain<f64>, jacobian: &DMatrix<f64>) -> f64 {
    let (n, half) = (chain.sites(), chain.layout().dim() / 2);
    let form = DMatrix::from_fn(2 * half, 2 * half, |i, j| {
        let mass = if i.min(j) < n { 1.0 } else { chain.params().rho };
        if j == i + half {
            mass
        } else if i == j + half {
            -mass
        } else {
            0.0
        }
    });
    (jacobian.transpose() * &form * jacobian - form).amax()
}

#[test]
fn every_step_is_symplectic() {
    // Truth: J^T W J = W. The differences give J to 1e-11 on a step that meets no kink of the
    // force.
    let (chain, y) = two_clusters();
    let mut worst = 0.0_f64;
    for flow in FLOWS {
        for scheme in ALL {
            for first in [First::Drift, First::Kick] {
                let step = |y: &[f64]| finish(&mut *stepper(&chain, flow, scheme, first, y, 0.2, 1));
                assert_eq!(closed_and_open(&chain, &step(&y)), closed_and_open(&chain, &y));
                worst = worst.max(symplectic_defect(&chain, &jacobian(&y, step)));
            }
        }
    }
    assert_below(worst, 6e-12, "J^T W J - W");
    // The check can fail: Euler's step violates it by h^2 f'.
    let euler = |y: &[f64]| {
        let mut dy = vec![0.0; y.len()];
        Field::new(chain.clone()).eval(0.0, y, &mut dy);
        y.iter().zip(dy).map(|(y, dy)| y + 0.2 * dy).collect()
    };
    let defect = symplectic_defect(&chain, &jacobian(&y, euler));
    assert!(defect > 0.01, "Euler: {defect}");
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

/// An observer that keeps the states at the given times.
struct Looks {
    times: Vec<f64>,
    seen: Vec<Vec<f64>>,
}

impl Observer<f64> for Looks {
    fn next(&self) -> Option<f64> {
        self.times.get(self.seen.len()).copied()
    }
    fn observe(&mut self, _: f64, y: &[f64], _: Stats) -> Result<ControlFlow<()>, Error> {
        self.seen.push(y.to_vec());
        Ok(ControlFlow::Continue(()))
    }
}

#[test]
fn looking_at_a_run_does_not_change_it() {
    // Truth: the run without samples, bit for bit. Samples lie inside steps, at their ends, and
    // twice at one time.
    let chain = walled(1.5, 0.5, 6);
    let y = random_state(&chain, 4, 1.0);
    for flow in FLOWS {
        for scheme in ALL {
            for first in [First::Drift, First::Kick] {
                let unseen = finish(&mut *stepper(&chain, flow, scheme, first, &y, 10.0, 200));
                let times = [0.0, 0.01, 0.05, 0.05, 1.234, 3.0, 3.03, 9.99, 10.0].to_vec();
                let mut looks = Looks { times, seen: Vec::new() };
                let mut run = stepper(&chain, flow, scheme, first, &y, 10.0, 200);
                let mut end = y.clone();
                drive(&mut *run, &mut looks, &mut end).unwrap();
                assert_eq!(end, unseen, "{} {flow:?} {first:?}", scheme.name);
                assert_eq!((looks.seen.len(), &looks.seen[8]), (9, &end));
                assert_eq!(looks.seen[2], looks.seen[3]);
                assert!(distance(&looks.seen[0], &y) < 4.0 * EPS);
            }
        }
    }
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
                let mut looks = Looks { times: vec![t], seen: Vec::new() };
                let mut run = stepper(&chain, flow, scheme, natural(flow), &y, 4.0, steps);
                drive(&mut *run, &mut looks, &mut y.clone()).unwrap();
                distance(&looks.seen[0], &truth)
            });
            assert_near(order, f64::from(scheme.order), 0.5, &format!("look, {} {flow:?}", scheme.name));
        }
    }
}

/// The order of every scheme on both flows with some twenty events: typical errors over eight
/// motions, because a single error depends on the position of each event in its step.
fn orders_with_events(alpha: f64, schemes: &[Scheme], steps: &[u64], want: impl Fn(&Scheme) -> (f64, f64)) {
    let end = 12.0;
    let chain = walled(alpha, 0.5, 6);
    let motions: Vec<_> = (0..8).map(|seed| random_state(&chain, 100 + seed, 1.0)).collect();
    let motions: Vec<_> = motions.into_iter().map(|y| (by_dop853(&chain, &y, end), y)).collect();
    for (_, y) in &motions {
        let (mut events, mut old) = (0, closed_and_open(&chain, y));
        watch(&chain, y, end, |y| {
            let new = closed_and_open(&chain, y);
            events += new.iter().zip(&old).filter(|(new, old)| new != old).count();
            old = new;
        });
        assert!((15..50).contains(&events), "{events} events");
    }
    let typical = |flow, scheme, steps| {
        let error =
            |(truth, y): &(Vec<f64>, Vec<f64>)| distance(&integrate(&chain, flow, scheme, y, end, steps), truth);
        let mut errors: Vec<f64> = motions.iter().map(error).collect();
        errors.sort_by(f64::total_cmp);
        (errors[3] * errors[4]).sqrt()
    };
    for flow in FLOWS {
        for scheme in schemes {
            let errors: Vec<_> = steps.iter().map(|&steps| (steps as f64, typical(flow, scheme, steps))).collect();
            let (order, tolerance) = want(scheme);
            assert_near(slope(&errors), order, tolerance, &format!("events, {alpha}, {} {flow:?}", scheme.name));
        }
    }
}

#[test]
fn events_bring_every_order_down_to_alpha_plus_one() {
    // Truth: a step with an event errs by h^(alpha+1), and the number of events does not depend on
    // h.
    let steps = [256, 512, 1024, 2048, 4096, 8192];
    orders_with_events(1.5, ALL, &steps, |scheme| if scheme.order == 2 { (2.0, 0.15) } else { (2.5, 0.3) });
}

#[test]
fn events_of_a_smooth_enough_law_leave_order_four() {
    // Truth: min(p, alpha + 1), as above.
    let low: Vec<Scheme> = ALL.iter().copied().filter(|scheme| scheme.order <= 4).collect();
    let want = |scheme: &Scheme| (f64::from(scheme.order), 0.3);
    orders_with_events(3.0, &low, &[256, 362, 512, 724, 1024], want);
}

/// Beads that never touch, each oscillating against its resonator with its own amplitude and phase.
struct Breather {
    chain: Chain<f64>,
    sites: Vec<(f64, f64)>,
    omega: DoubleDouble<f64>,
}

impl Breather {
    fn new() -> Self {
        let chain = Chain::new(Params::new(1.5, 1.0, 0.25).unwrap(), Boundary::Free, 5).unwrap();
        let mut next = random_signed(6);
        // omega = sqrt 5.
        let omega = DoubleDouble::decimal("2.236067977499789696409173668731276235441");
        Self { chain, sites: (0..5).map(|_| (0.6 + 0.4 * next(), 3.0 * next())).collect(), omega }
    }

    fn period(&self) -> f64 {
        2.0 * PI / self.omega.value()
    }

    /// The state at `t`, with the phase to 30 digits.
    fn at(&self, t: f64) -> Vec<f64> {
        let (rho, omega) = (self.chain.params().rho, self.omega.value());
        let (s, c) = (self.omega * DoubleDouble::new(t)).reduced(DoubleDouble::two_pi()).sin_cos();
        let site = |i: usize| {
            let ((a, phi), b) = (self.sites[i], 3.0 * i as f64);
            let (cos, sin) = (phi.cos() * c - phi.sin() * s, phi.sin() * c + phi.cos() * s);
            let at = |weight: f64| (weight * a * cos + b, -omega * weight * a * sin);
            let ((u, u_dot), (v, v_dot)) = (at(rho / (1.0 + rho)), at(-1.0 / (1.0 + rho)));
            Site { u, v, u_dot, v_dot }
        };
        State::from_fn(&self.chain, site).unwrap().as_slice().to_vec()
    }
}

#[test]
fn beads_that_never_touch_move_exactly_with_any_step() {
    // Truth: the closed form. Bound: a few roundings of positions up to 12.
    let breather = Breather::new();
    let y = breather.at(0.0);
    let mut worst = 0.0_f64;
    for scheme in ALL {
        for periods in [0.01, 0.3, 1.0, 100.0] {
            for steps in [1, 7, 300] {
                let end = steps as f64 * periods * breather.period();
                let got = integrate(&breather.chain, Flow::Linear, scheme, &y, end, steps);
                worst = worst.max(distance(&got, &breather.at(end)));
            }
        }
    }
    assert_below(worst / EPS, 30.0, "never touching, in eps");
    // The other split has to resolve the oscillation, which this one solves exactly.
    let end = breather.period();
    let verlet = integrate(&breather.chain, Flow::Kinetic, &STRANG, &y, end, 20);
    assert!(distance(&verlet, &breather.at(end)) > 0.01);
}

#[test]
fn a_million_steps_lose_nothing_where_no_contact_acts() {
    // Truth: the closed form. The flow stores no rotated state, so that errors do not accumulate.
    let breather = Breather::new();
    let got = integrate(&breather.chain, Flow::Linear, &STRANG, &breather.at(0.0), 1e5, 1_000_000);
    assert_below(distance(&got, &breather.at(1e5)) / EPS, 16.0, "a million steps, in eps");
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
    // and kinks make a random walk, see below). Measured: 0.06 of the scatter, and 0.07 (up to 0.28
    // over six motions); the largest error is 3.5 and 10.4 times the scatter.
    let pressed = smooth_motion();
    let opening = walled(3.0, 1.0 / 3.0, 6);
    let opening = (opening.clone(), random_state(&opening, 7, 0.3));
    let mut scatter_of_strang = 0.0;
    for ((chain, y), name) in [(&pressed, "pressed"), (&opening, "opening")] {
        let period = 2.0 * PI / chain.params().omega();
        let mut run = stepper(chain, Flow::Linear, &STRANG, First::Drift, y, 1e5 * period, 3_200_000);
        let errors = energy_errors(chain, &mut *run, y);
        let (drift, scatter) = drift_and_scatter(&errors);
        let largest = errors.iter().fold(0.0, |max: f64, (_, error)| max.max(error.abs()));
        println!("{name}: drift {drift:.2e}, scatter {scatter:.2e}, largest {largest:.2e}");
        assert_below(drift.abs() / scatter, 0.5, "drift over scatter");
        assert_below(largest, 17.0 * scatter, "largest error");
        scatter_of_strang = scatter;
    }
    // A method of order eight with more evaluations a period drifts in a fiftieth of the time.
    let (chain, y) = &opening;
    let mut run = Dop853::fixed(Field::new(chain.clone()), y, (0.0, 2000.0 * PI), 8000).unwrap();
    let (drift, _) = drift_and_scatter(&energy_errors(chain, &mut run, y));
    println!("DOP853 {drift:.2e}");
    assert!(drift.abs() > 10.0 * scatter_of_strang, "{drift:e}");
}

#[test]
fn in_chaos_the_kinks_of_the_law_make_the_energy_wander() {
    // Truth: every event leaves an error of h^(alpha+1), whose sign is random because of chaos. The
    // result is a random walk with steps of that size, here h^2.5, in place of the h^2 of the
    // smooth case. Root mean square over 40 motions.
    let chain = walled(1.5, 1.0 / 3.0, 6);
    let wandering = |per_period: u64| {
        let motion = |seed| {
            let y = random_state(&chain, seed, 1.0);
            let steps = 4000 * per_period;
            let mut run = stepper(&chain, Flow::Linear, &STRANG, First::Drift, &y, 4000.0 * PI, steps);
            drift_and_scatter(&energy_errors(&chain, &mut *run, &y)).0.powi(2)
        };
        ((0..40).map(motion).sum::<f64>() / 40.0).sqrt()
    };
    let points = [32, 64, 128].map(|per_period| (per_period as f64, wandering(per_period)));
    println!("{points:?}");
    assert_near(slope(&points), 2.5, 0.4, "order of the wandering");
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
