//! Every scheme on both flows of the chain: structure, order with and without contacts that open, exactness, counts.

use hertzchain::chain::{Boundary, Chain, Field, KineticFlow, LinearFlow, Params, Resonators, Site, State};
use hertzchain::integrators::{
    Dop853, Error, Observer, Scheme, Silent, SplitFlow, Splitting, Stats, Stepper, Stop, Twofold, VectorField,
    dop853::Options,
    drive,
    splitting::{First, tables},
};
use nalgebra::DMatrix;
use std::{f64::consts::PI, ops::ControlFlow};
use tables::{ABA864, ALL, KAHAN_LI8, SRKN6_4, STRANG, YOSHIDA4, YOSHIDA6, YOSHIDA8};

const EPS: f64 = f64::EPSILON;
const FLOWS: [Flow; 2] = [Flow::Kinetic, Flow::Linear];

/// One of the two ways to split a chain.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Flow {
    Kinetic,
    Linear,
}

fn assert_below(value: f64, bound: f64, what: &str) {
    println!("{what}: {value:.2e}, bound {bound:.1e}");
    assert!(value <= bound, "{what}: {value:e} > {bound:e}");
}

fn assert_near(value: f64, want: f64, tolerance: f64, what: &str) {
    println!("{what}: {value:.3}, want {want} +- {tolerance}");
    assert!((value - want).abs() <= tolerance, "{what}: {value}, not {want} +- {tolerance}");
}

/// Numbers in (-1, 1) that look random: splitmix64.
fn random(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (seed ^ (seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn random_state(chain: &Chain<f64>, seed: u64, size: f64) -> Vec<f64> {
    let mut next = random(seed);
    (0..chain.layout().dim()).map(|_| size * next()).collect()
}

fn walled(alpha: f64, rho: f64, sites: usize) -> Chain<f64> {
    Chain::new(Params::new(alpha, 1.0, rho).unwrap(), Boundary::Fixed, sites).unwrap()
}

/// What compositions begin with when nothing else is asked for: what suits the flow.
fn natural(flow: Flow) -> First {
    match flow {
        Flow::Kinetic => First::Kick,
        Flow::Linear => First::Drift,
    }
}

fn start<S: SplitFlow<f64>>(
    scheme: &Scheme,
    first: First,
    mut flow: S,
    y: &[f64],
    end: f64,
    steps: u64,
) -> Box<dyn Stepper<f64>>
where
    S: 'static,
{
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

/// The end of a run by an independent method.
fn by_dop853(chain: &Chain<f64>, y: &[f64], end: f64) -> Vec<f64> {
    let options = Options { atol: 1e-15, ..Options::new(1e-14) };
    finish(&mut Dop853::new(Field::new(chain.clone()), y, (0.0, end), options).unwrap())
}

fn gap(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |max, (a, b)| if (a - b).is_nan() { f64::NAN } else { (a - b).abs().max(max) })
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

/// Beads in two groups: inside them contacts stay closed, between them one stays open, for a unit of time at least.
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

/// The Jacobian of a map by central differences of fourth order: error d^4 and eps/d.
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
    // Truth: J^T W J = W; J by differences good to 1e-11 on a step that meets no kink of the force.
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
    assert_below(worst, 1e-10, "J^T W J - W");
    // A check that lets everything pass is none: Euler's step is off by h^2 f'.
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
    // Truth: every scheme is a palindrome of reversible flows. What is left is rounding, amplified by the motion.
    let mut worst = 0.0_f64;
    for (rho, seed) in [(0.5, 1), (0.0, 2), (f64::INFINITY, 3)] {
        let chain = walled(1.5, rho, 6);
        let y = random_state(&chain, seed, 1.0);
        for flow in FLOWS {
            for scheme in ALL {
                let there = integrate(&chain, flow, scheme, &y, 6.0, 120);
                assert!(gap(&there, &y) > 0.1);
                let back = backwards(integrate(&chain, flow, scheme, &backwards(there), 6.0, 120));
                worst = worst.max(gap(&back, &y) / EPS);
            }
        }
    }
    assert_below(worst, 300.0, "way back, in eps");
}

/// Looks at the given times and keeps what it sees.
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
    // Truth: the run nobody looks at, bit for bit; some looks inside steps, some at their ends, two at once.
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
                assert!(gap(&looks.seen[0], &y) < 4.0 * EPS);
            }
        }
    }
}

/// A walled chain pressed so hard that no contact opens, and a motion in it.
fn smooth_motion() -> (Chain<f64>, Vec<f64>) {
    let chain = walled(1.5, 0.5, 6).precompressed(1.0).unwrap();
    let y = random_state(&chain, 5, 0.4);
    (chain, y)
}

/// Errors of a ladder of step counts, each twice the last, that lie between round-off and a tenth.
fn ladder(first: u64, rungs: u32, error: impl Fn(u64) -> f64) -> Vec<(f64, f64)> {
    (0..rungs).map(|k| (first << k, error(first << k))).map(|(steps, error)| (steps as f64, error)).collect()
}

#[test]
fn explore_order() {
    let (chain, y) = smooth_motion();
    let end = 4.0;
    let truth = by_dop853(&chain, &y, end);
    println!("kl8 vs dop {:e}", gap(&truth, &integrate(&chain, Flow::Linear, &KAHAN_LI8, &y, end, 4000)));
    println!("y8 kinetic vs dop {:e}", gap(&truth, &integrate(&chain, Flow::Kinetic, &YOSHIDA8, &y, end, 4000)));
    let mut min = f64::MAX;
    let mut run = stepper(&chain, Flow::Linear, &STRANG, First::Drift, &y, end, 4000);
    let mut s = y.clone();
    while !run.done() {
        run.step().unwrap();
        run.sample(run.time(), &mut s);
        min = chain.overlaps(chain.layout().u(&s)).into_iter().fold(min, f64::min);
    }
    println!("min overlap {min}");
    for flow in FLOWS {
        for scheme in ALL {
            let l = ladder(2, 10, |steps| gap(&integrate(&chain, flow, scheme, &y, end, steps), &truth));
            print!("{:10} {flow:?} {}: ", scheme.name, scheme.order);
            for w in l.windows(2) {
                print!("{:.1e} ({:.2}) ", w[1].1, (w[0].1 / w[1].1).log2());
            }
            println!();
        }
    }
}

#[test]
fn explore_kinks() {
    let end = 12.0;
    for alpha in [1.5, 3.0] {
        let chain = walled(alpha, 0.5, 6);
        let starts: Vec<Vec<f64>> = (0..12).map(|seed| random_state(&chain, 100 + seed, 1.0)).collect();
        let truths: Vec<Vec<f64>> = starts.iter().map(|y| by_dop853(&chain, y, end)).collect();
        for (y, t) in starts.iter().zip(&truths) {
            let a = integrate(&chain, Flow::Linear, &YOSHIDA6, y, end, 400_000);
            let mut run = stepper(&chain, Flow::Linear, &STRANG, First::Drift, y, end, 4000);
            let mut s = y.clone();
            let mut events = 0;
            let mut old = closed_and_open(&chain, y);
            while !run.done() {
                run.step().unwrap();
                run.sample(run.time(), &mut s);
                let new = closed_and_open(&chain, &s);
                events += new.iter().zip(&old).filter(|(a, b)| a != b).count();
                old = new;
            }
            println!("ref gap {:e} events {events}", gap(&a, t));
        }
        for flow in FLOWS {
            for scheme in ALL {
                let l = ladder(128, 8, |steps| {
                    let mut e: Vec<f64> = starts
                        .iter()
                        .zip(&truths)
                        .map(|(y, t)| gap(&integrate(&chain, flow, scheme, y, end, steps), t))
                        .collect();
                    e.sort_by(f64::total_cmp);
                    (e[5] * e[6]).sqrt()
                });
                print!("a={alpha} {:10} {flow:?} {}: slope {:.3}: ", scheme.name, scheme.order, slope(&l));
                for w in l.windows(2) {
                    print!("{:.1e} ({:.2}) ", w[1].1, (w[0].1 / w[1].1).log2());
                }
                println!();
            }
        }
    }
}
