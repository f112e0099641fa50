//! Run time of a step per site, compared with a bare loop that computes the contact force only:
//! `x sqrt(max(x, 0))`.
//!
//! Prints a table of medians, measured in one run, from which ratios are quoted elsewhere.

use hertzchain::chain::{Boundary, Chain, ContactLog, KineticFlow, LinearFlow, Overlaps, Params};
use hertzchain::integrators::{
    Real, SplitFlow, Splitting, Stepper, Watch, kernel,
    splitting::{First, tables::STRANG},
};
use hertzchain::{Method, Run, Scene, run::Setting};
use std::{hint::black_box, time::Instant};

const SIZES: [usize; 5] = [50, 1_000, 10_000, 100_000, 1_000_000];
const STEP: f64 = 0.01;

/// A timed operation, which makes `steps` steps of a chain of `sites` sites, and a check of its
/// result.
struct Work {
    name: String,
    sites: usize,
    steps: usize,
    once: Box<dyn FnMut()>,
    check: Box<dyn Fn()>,
}

/// Numbers in (-1/2, 1/2) without a visible pattern.
fn noise(len: usize) -> Vec<f64> {
    (0..len).map(|i| (0.618_033_988_749_894_9 * i as f64 + 0.3 * (i as f64).sin()).fract() - 0.5).collect()
}

fn bare(sites: usize) -> Work {
    let x = noise(sites);
    let mut f = vec![0.0; sites];
    let once = move || {
        // The bare loop, compiled with the same vector instructions as the sweeps.
        let (x, out) = (black_box(&x), &mut f[..]);
        f64::run(kernel!(for (f, &x) in out.iter_mut().zip(x) {
            *f = x * x.max(0.0).sqrt();
        }));
        let (i, force) = (sites / 3, black_box(&f)[sites / 3]);
        assert_eq!(force, x[i] * x[i].max(0.0).sqrt());
    };
    Work { name: "bare loop".into(), sites, steps: 1, once: Box::new(once), check: Box::new(|| ()) }
}

/// Steps of Strang's scheme without end; the check is that energy is conserved.
fn steps<S: SplitFlow<f64> + 'static>(name: String, chain: Chain<f64>, flow: S, first: First, y: &[f64]) -> Work {
    repeat(name, chain, endless(flow, first, y), y)
}

fn endless<S: SplitFlow<f64> + 'static>(mut flow: S, first: First, y: &[f64]) -> Splitting<f64, S> {
    flow.load(y);
    let count = 1_000_000_000;
    Splitting::new(&STRANG, first, flow, (0.0, STEP * count as f64), count).unwrap()
}

fn repeat(name: String, chain: Chain<f64>, run: impl Stepper<f64> + 'static, y: &[f64]) -> Work {
    use std::{cell::RefCell, rc::Rc};
    let run = Rc::new(RefCell::new(run));
    let (running, sites, initial, dim) = (run.clone(), chain.sites(), chain.energy(y).total(), y.len());
    // Each call makes as many steps in a row as a run without samples does.
    let once = move || running.borrow_mut().steps(None).unwrap();
    once();
    let before = run.borrow().stats().steps;
    once();
    let steps = (run.borrow().stats().steps - before) as usize;
    let check = move || {
        let mut y = vec![0.0; dim];
        let mut run = run.borrow_mut();
        let now = run.time();
        run.sample(now, &mut y);
        let error = (chain.energy(&y).total() / initial - 1.0).abs();
        assert!(error < 1e-3, "the energy is off by {error:e} at t = {now}");
    };
    Work { name, sites, steps, once: Box::new(once), check: Box::new(check) }
}

fn verlet(name: &str, chain: &Chain<f64>, y: &[f64]) -> Work {
    steps(format!("verlet, {name}"), chain.clone(), KineticFlow::new(chain.clone()), First::Kick, y)
}

fn strang(name: &str, chain: &Chain<f64>, y: &[f64]) -> Work {
    steps(format!("strang-linear, {name}"), chain.clone(), LinearFlow::new(chain.clone()), First::Drift, y)
}

fn ring(rho: f64, sites: usize) -> Chain<f64> {
    Chain::new(Params::new(1.5, 1.0, rho).unwrap(), Boundary::Ring, sites).unwrap()
}

/// The bare loop, then both splittings of three chains; about half of the contacts are closed.
fn kernels(sites: usize) -> Vec<Work> {
    let mut works = vec![bare(sites)];
    for (name, rho) in [("resonant", 1.0 / 3.0), ("plain", 0.0), ("cradle", f64::INFINITY)] {
        let chain = ring(rho, sites);
        let y = noise(chain.layout().dim());
        works.push(verlet(name, &chain, &y));
        works.push(strang(name, &chain, &y));
    }
    works
}

/// A long plain chain at rest except its first bead, and the same chain with all beads moving.
fn subnormals() -> Vec<Work> {
    let chain = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 100_000).unwrap();
    let mut struck = vec![0.0; chain.layout().dim()];
    struck[chain.sites()] = 1.0;
    let moving = noise(chain.layout().dim());
    [("struck", struck), ("moving", moving)]
        .iter()
        .flat_map(|(name, y)| [verlet(name, &chain, y), strang(name, &chain, y)])
        .collect()
}

/// A short chain, stepped in three ways: with a scheme known at compile time, as `run` steps it,
/// and as `run --events` does.
fn contact_logs() -> Vec<Work> {
    let chain = ring(1.0 / 3.0, 50);
    let y: Vec<f64> = noise(chain.layout().dim()).iter().map(|y| 0.1 * y).collect();
    let run = || endless(LinearFlow::new(chain.clone()), First::Drift, &y);
    let boxed = || -> Box<dyn Stepper<f64>> { Box::new(run()) };
    let watch = Watch::new(boxed(), Overlaps::new(chain.clone()), ContactLog::new(chain.clone()));
    vec![
        repeat("strang-linear".into(), chain.clone(), run(), &y),
        repeat("the same in `run`".into(), chain.clone(), boxed(), &y),
        repeat("in `run --events`".into(), chain.clone(), watch, &y),
    ]
}

/// Periods of `tw-q15` that are run, and kicks a period.
const PERIODS: usize = 100;
const KICKS: usize = 64;

/// Whole runs of `tw-q15` by three methods: plain kicks, the modified kicks of corrected splitting
/// alone, and corrected splitting with its corrections at events.
fn corrected() -> Vec<Work> {
    let steps = PERIODS * KICKS;
    let work = |name: &str| {
        let scene = Scene::load("tw-q15").expect("a built-in scene");
        let (sites, method) = (scene.chain().sites(), Method::named(name).expect("a method"));
        let run = move || {
            let run: Run = scene.run().method(method).setting(Setting::Steps(steps as u64)).samples(0).unwrap();
            run.start().unwrap().complete().unwrap().energy_error.unwrap()
        };
        let again = run.clone();
        let check = move || assert!(again() < 1e-3, "the energy is off by {:e}", again());
        let once = move || {
            black_box(run());
        };
        Work { name: name.into(), sites, steps, once: Box::new(once), check: Box::new(check) }
    };
    ["strang-linear", "takahashi-imada-linear", "corrected"].map(work).into()
}

/// Prints the time of a corrected step without events, and of an event: each bond closes and opens
/// once a period. Takes the least of the samples, since these runs are so long that other processes
/// interrupt many of them.
fn print_corrected() {
    let mut works = corrected();
    let times = sampled(&mut works, |_| 0);
    let sites = works[0].sites as f64;
    for (work, &time) in works.iter().zip(&times) {
        let (step, ratio) = (sites * time, time / times[0]);
        println!("{:>9}  {:24} {step:>10.1} ns a step   x plain kicks {ratio:.2}", work.sites, work.name);
    }
    let event = (times[2] - times[1]) * KICKS as f64 / 2.0;
    println!("{:>9}  {:24} {event:>10.1} ns", works[0].sites, "an event");
}

/// Median nanoseconds per site and step of each operation. Operations take turns, so that the load
/// of the machine affects all of them equally.
fn medians(works: &mut [Work]) -> Vec<f64> {
    sampled(works, |count| count / 2)
}

/// Nanoseconds per site and step of each operation: the sample with index `rank(number of samples)`
/// among its samples in increasing order.
fn sampled(works: &mut [Work], rank: impl Fn(usize) -> usize) -> Vec<f64> {
    let mut samples = vec![Vec::new(); works.len()];
    for round in 0..31 {
        for (work, samples) in works.iter_mut().zip(&mut samples) {
            let repeats = (200_000 / (work.sites * work.steps)).max(2);
            let start = Instant::now();
            (0..repeats).for_each(|_| (work.once)());
            let time = start.elapsed().as_secs_f64();
            if round > 0 {
                samples.push(1e9 * time / (repeats * work.sites * work.steps) as f64);
            }
        }
    }
    works.iter().for_each(|work| (work.check)());
    let ranked = |samples: &mut Vec<f64>| {
        samples.sort_by(f64::total_cmp);
        samples[rank(samples.len())]
    };
    samples.iter_mut().map(ranked).collect()
}

fn table() {
    println!("{:>9}  {:24} {:>10} {:>8} {:>11}", "sites", "step", "ns/site", "x bare", "x resonant");
    for sites in SIZES {
        let mut works = kernels(sites);
        let times = medians(&mut works);
        for (i, (work, &time)) in works.iter().zip(&times).enumerate() {
            let resonant = if i == 0 { String::new() } else { format!("{:.2}", time / times[2 - i % 2]) };
            println!("{sites:>9}  {:24} {time:>10.3} {:>8.2} {resonant:>11}", work.name, time / times[0]);
        }
    }
    let mut works = contact_logs();
    let times = medians(&mut works);
    for (work, &time) in works.iter().zip(&times) {
        println!("{:>9}  {:24} {time:>10.3}   x the first {:.2}", work.sites, work.name, time / times[0]);
    }
    print_corrected();
    let mut works = subnormals();
    let times = medians(&mut works);
    for (i, (work, &time)) in works.iter().zip(&times).enumerate() {
        println!("{:>9}  {:24} {time:>10.3}   x moving {:.2}", work.sites, work.name, time / times[2 + i % 2]);
    }
    for (struck, moving) in times[..2].iter().zip(&times[2..]) {
        assert!(struck < &(1.25 * moving), "a wave into a chain at rest is slow: {struck} ns, not {moving} ns");
    }
}

fn main() {
    if !std::env::args().any(|argument| ["--test", "--list"].contains(&argument.as_str())) {
        table();
    }
}
