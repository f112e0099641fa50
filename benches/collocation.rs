//! Run times of contact collocation on one thread: for chains of several lengths, and for the
//! tangent map (`frontier.rs` compares methods at equal error). Before these, a table of what the
//! parts of a window cost, the least of several runs.
//!
//! Each benchmark checks its result before it is timed, and prints the error.

use criterion::{Criterion, Throughput};
use hertzchain::{
    chain::{Boundary, Chain, Params},
    integrators::{Silent, Stepper, collocation::StepControl, drive},
    run::method::{Method, Setting},
    scene::{Initial, Scene, SceneFile},
    study::generic_state,
};
use std::{
    f64::consts::PI,
    hint::black_box,
    time::{Duration, Instant},
};

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |a, b| b.abs().max(a))
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    largest(a.iter().zip(b).map(|(a, b)| a - b))
}

/// The state at the end of a run.
fn end(mut run: impl Stepper<f64>) -> Vec<f64> {
    let mut y = vec![0.0; run.dim()];
    drive(&mut run, &mut Silent, &mut y).unwrap();
    y
}

/// Numbers in (-1, 1) without a visible pattern.
fn noise(i: usize) -> f64 {
    2.0 * (0.618_033_988_749_894_9 * i as f64 + 0.3 * (i as f64).sin()).fract().abs() - 1.0
}

/// The wave on a ring of `sites` sites for three periods. Each entry is perturbed by up to a tenth
/// of the largest entry of its kind.
fn perturbed(sites: usize) -> Scene {
    let mut file = SceneFile::parse(&Scene::source("tw-q15").unwrap(), "tw-q15").unwrap();
    file.chain.sites = sites;
    let wave = Scene::build(file.clone()).unwrap();
    let mut arrays = wave.initial().as_slice().chunks(sites).enumerate().map(|(k, array)| {
        let size = 0.1 * largest(array.iter().copied());
        let shifts: Vec<f64> = (0..sites).map(|n| size * noise(k * sites + n)).collect();
        // The means do not change, so that the strain ring keeps its energy.
        let mean = shifts.iter().sum::<f64>() / sites as f64;
        array.iter().zip(shifts).map(|(value, shift)| value + (shift - mean)).collect::<Vec<f64>>()
    });
    let mut next = || arrays.next().unwrap();
    file.initial = Initial::State { u: next(), v: next(), u_dot: next(), v_dot: next() };
    Scene::build(file).unwrap().until(3.0 * wave.period()).unwrap()
}

/// Throughput in bonds times periods.
fn against_length(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("three periods at 1e-9");
    for sites in [50, 500, 5000] {
        let scene = perturbed(sites);
        let (chain, y0) = (scene.chain(), scene.initial().as_slice());
        let run = || end(chain.collocation(y0, (0.0, scene.end()), StepControl::Tolerance(1e-9)).unwrap());
        let drift = (chain.energy(&run()).total() / chain.energy(y0).total() - 1.0).abs();
        println!("{sites} sites: energy off by {drift:.1e}");
        assert!(drift < 2.5e-14, "{sites} sites: {drift:e}");
        group.throughput(Throughput::Elements(3 * sites as u64));
        group.bench_function(format!("{sites} sites"), |bencher| bencher.iter(run));
    }
    group.finish();
}

/// Tangent map of 21 colliding beads, with 84 columns, and the run without it.
fn tangent_map(criterion: &mut Criterion) {
    let chain: Chain<f64> = Chain::new(Params::new(1.5, 1.0, 1.0 / 3.0).unwrap(), Boundary::Free, 21).unwrap();
    let start = generic_state(&chain).unwrap();
    let (y0, span) = (start.as_slice(), (0.0, PI));
    let control = StepControl::Windows { windows: 40, nodes: 12, neighbours: true };
    let run = |y: &[f64]| end(chain.collocation(y, span, control).unwrap());
    let monodromy = || chain.monodromy(y0, span, control).unwrap();

    // Reference: central differences in one direction.
    let direction: Vec<f64> = (0..y0.len()).map(noise).collect();
    let size = 1e-5;
    let [ahead, behind] = [size, -size].map(|size| {
        let y: Vec<f64> = y0.iter().zip(&direction).map(|(y, w)| y + size * w).collect();
        run(&y)
    });
    let difference: Vec<f64> = ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * size)).collect();
    let mut image = vec![0.0; y0.len()];
    for (column, w) in monodromy().chunks(y0.len()).zip(&direction) {
        image.iter_mut().zip(column).for_each(|(image, entry)| *image += w * entry);
    }
    let error = distance(&image, &difference) / largest(difference);
    println!("monodromy: off differences by {error:.1e}");
    assert!(error < 4e-9, "{error:e}");

    let mut group = criterion.benchmark_group("20 bonds, one period");
    group.bench_function("run", |bencher| bencher.iter(|| run(black_box(y0))));
    group.bench_function("monodromy", |bencher| bencher.iter(monodromy));
    group.finish();
}

/// Sites of the ring on which [`parts`] times windows, and windows of each of its runs.
const RING: usize = 200;
const WINDOWS: u64 = 200;

/// Least time per bond and window in nanoseconds, and sweeps a window, for windows of length `h`
/// with `nodes` nodes a panel. The beads of the ring oscillate, but all bonds stay closed
/// (`closed`) or open.
fn window(closed: bool, h: f64, nodes: usize) -> (f64, f64) {
    let chain = Chain::new(Params::new(1.5, 1.0, 1.0 / 3.0).unwrap(), Boundary::StrainRing, RING).unwrap();
    let strain = if closed { -1.0 } else { 1.0 };
    let mut y0 = vec![strain; 2 * RING];
    y0.extend((0..2 * RING).map(|i| 0.05 * (2.0 * PI * (i % RING) as f64 / 10.0).sin()));
    let control = StepControl::Windows { windows: WINDOWS, nodes, neighbours: true };
    let mut best = (f64::INFINITY, 0.0);
    for _ in 0..5 {
        let mut run = chain.collocation(&y0, (0.0, WINDOWS as f64 * h), control).unwrap();
        let start = Instant::now();
        while !run.done() {
            run.step().unwrap();
        }
        let time = 1e9 * start.elapsed().as_secs_f64() / (WINDOWS as usize * RING) as f64;
        let stats = run.stats();
        assert_eq!((stats.steps, stats.rejected), (WINDOWS, 0));
        best = (best.0.min(time), stats.force_evaluations as f64 / (nodes as u64 * WINDOWS) as f64);
    }
    best
}

/// Prints the time per bond of each part of a window. It follows from two differences: between an
/// open bond and a closed one, and between windows of two lengths, where only the number of sweeps
/// differs.
fn parts() {
    println!("ns a bond and window      4 nodes   8 nodes  12 nodes");
    let mut table = [[0.0; 3]; 3];
    for (column, nodes) in [4, 8, 12].into_iter().enumerate() {
        let (open, none) = window(false, 0.1, nodes);
        let ((short, few), (long, many)) = (window(true, 0.03, nodes), window(true, 0.3, nodes));
        assert!(none == 0.0 && many > few && few >= 1.0, "{none} {few} {many}");
        let sweep = (long - short) / (many - few);
        for (row, part) in [open, short - few * sweep - open, sweep].into_iter().enumerate() {
            table[row][column] = part;
        }
    }
    for (name, row) in ["begin, predict, advance", "lay out, first forces", "a sweep"].into_iter().zip(table) {
        println!("{name:24} {:8.0}  {:8.0}  {:8.0}", row[0], row[1], row[2]);
    }
    let scene = Scene::load("tw-q15").unwrap();
    let bonds = scene.chain().touching().len();
    for tol in [1e-4, 1e-7, 1e-10] {
        let best = (0..5).map(|_| {
            let mut run = scene.run().method(Method::Collocation).setting(Setting::Tolerance(tol)).stepper().unwrap();
            let start = Instant::now();
            while !run.done() {
                run.step().unwrap();
            }
            let windows = run.stats().steps as usize;
            1e9 * start.elapsed().as_secs_f64() / (windows * bonds) as f64
        });
        println!("tw-q15 at {tol:e}, with contacts that begin and end: {:.0}", best.fold(f64::INFINITY, f64::min));
    }
}

fn main() {
    let mut criterion = Criterion::default()
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .sample_size(10)
        .configure_from_args();
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().unwrap();
    parts();
    against_length(&mut criterion);
    tangent_map(&mut criterion);
    criterion.final_summary();
}
