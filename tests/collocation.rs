//! Contact collocation against independent runs, closed forms and its own orders.

use hertzchain::{
    chain::{Boundary, Chain, Field, Overlaps, Params, Site, State},
    experiments::{Records, generic_state, run, run_with_contacts},
    integrators::{
        Error, Observer, Regularised, Silent, Stats, Stepper, collocation::Pace, dop853::Options, drive,
        regularised::power,
    },
    method::{Method, Setting},
    scene::{Scene, SceneFile},
};
use std::ops::ControlFlow;

fn random(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (seed ^ (seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |a, b| b.abs().max(a))
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    largest(a.iter().zip(b).map(|(a, b)| a - b))
}

/// The end of a regularised run: shares neither variable nor step with collocation.
fn truth(chain: &Chain<f64>, y0: &[f64], end: f64, tol: f64) -> Vec<f64> {
    let alpha = chain.params().alpha;
    let (field, overlaps) = (Field::new(chain.clone()), Overlaps::new(chain.clone()));
    let size = largest(y0.iter().copied()).max(1e-300);
    let options = Options { atol: tol * size, ..Options::new(tol) };
    let mut run = Regularised::new(field, overlaps, (alpha, power(alpha, 8)), y0, (0.0, end), options).unwrap();
    let mut y = y0.to_vec();
    drive(&mut run, &mut Silent, &mut y).unwrap();
    y
}

fn collocated(chain: &Chain<f64>, y0: &[f64], end: f64, pace: Pace) -> (Vec<f64>, Stats) {
    let mut run = chain.collocation(y0, (0.0, end), pace).unwrap();
    let mut y = y0.to_vec();
    drive(&mut run, &mut Silent, &mut y).unwrap();
    (y, run.stats())
}

fn windows(windows: u64, nodes: usize) -> Pace {
    Pace::Windows { windows, nodes, neighbours: true }
}

/// Errors of a scene at its end, relative to the largest strain or the amplitude that theory gives, by tolerance.
fn errors(scene: &Scene, tolerances: &[f64]) -> Vec<f64> {
    let y0 = scene.initial().as_slice();
    let reference = scene.strains(&truth(scene.chain(), y0, scene.end(), 1e-16));
    let scale = scene.amplitude().unwrap_or(largest(reference.iter().copied()));
    let error = |&tol: &f64| {
        let (y, _) = collocated(scene.chain(), y0, scene.end(), Pace::Tolerance(tol));
        distance(&scene.strains(&y), &reference) / scale
    };
    tolerances.iter().map(error).collect()
}

fn generic_scene(name: &str, rho: f64, boundary: &str, end: f64) -> Scene {
    let mut next = random(7);
    let mut array = || (0..12).map(|_| format!("{:.4}", 2.0 * next() - 1.0)).collect::<Vec<_>>().join(", ");
    let text = format!(
        "name = \"{name}\"\nsummary = \"random\"\n[chain]\nsites = 12\nalpha = 1.5\nkappa = 1.0\nrho = {rho}\n\
         boundary = \"{boundary}\"\n[initial]\nkind = \"state\"\nu = [{}]\nv = [{}]\nu_dot = [{}]\nv_dot = [{}]\n\
         [span]\nuntil = {end:?}\n[record]\nsamples = 10\n",
        array(),
        array(),
        array(),
        array()
    );
    Scene::build(SceneFile::parse(&text, name).unwrap()).unwrap()
}

#[test]
fn the_error_is_what_was_asked_for_over_six_decades() {
    // Truth: regularised DOP853 at a tenth of a rounding a step.
    let scenes = [
        Scene::load("tw-q15").unwrap(),
        Scene::load("impact").unwrap(),
        Scene::load("cradle").unwrap(),
        generic_scene("random", 0.5, "ring", 20.0),
    ];
    let tolerances = [1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11];
    for scene in &scenes {
        for (error, tol) in errors(scene, &tolerances).into_iter().zip(tolerances) {
            println!("{} tol {tol:e}: {error:.2e}, {:.2}", scene.name(), error / tol);
            assert!(error < 10.0 * tol, "{} at {tol:e}: {error:e}", scene.name());
        }
    }
}

#[test]
fn ten_periods_of_a_wave_are_exact_to_a_thousand_roundings() {
    let wave = Scene::load("tw-q15").unwrap();
    let scene = wave.clone().until(10.0 * wave.period()).unwrap();
    let error = errors(&scene, &[1e-13])[0];
    println!("{error:e}");
    assert!(error < 2e-13, "{error:e}");
}

#[test]
fn panels_cut_at_events_of_neighbours_restore_the_order() {
    // The chain of the order study. Truth: the regularised run, good to 3e-15. Averages over nearby numbers of windows, since where
    // a window ends against the events makes single errors jump.
    let chain = Chain::<f64>::new(Params::new(1.5, 1.0, 1.0 / 3.0).unwrap(), Boundary::Free, 6).unwrap();
    let start = generic_state(&chain).unwrap();
    let y0 = start.as_slice();
    let reference = truth(&chain, y0, 12.0, 1e-16);
    let mean = |count: u64, nodes: usize, neighbours: bool| {
        let runs: Vec<f64> = (0..12)
            .map(|k| {
                let pace = Pace::Windows { windows: count + count * k / 24, nodes, neighbours };
                distance(&collocated(&chain, y0, 12.0, pace).0, &reference).ln()
            })
            .collect();
        (runs.iter().sum::<f64>() / runs.len() as f64).exp()
    };
    // As many nodes as leave the singularities of neighbours, and the rounding, to be seen.
    for (nodes, neighbours, counts, least) in [(12, false, (15, 120), 4.3), (10, true, (15, 40), 6.0)] {
        let errors = (mean(counts.0, nodes, neighbours), mean(counts.1, nodes, neighbours));
        let slope = (errors.0 / errors.1).log2() / (counts.1 as f64 / counts.0 as f64).log2();
        println!("cut at neighbours {neighbours}: {:.2e} to {:.2e}, slope {slope:.2}", errors.0, errors.1);
        assert!(slope >= least, "{slope}");
    }
}

#[test]
fn every_exponent_and_mass_ratio_is_resolved_in_equal_windows() {
    // Truth: the regularised run. Bounds at 60, 120, 240 windows of 10 nodes, twice what was measured. At rho = 1e-6 a window holds 32
    // turns of a resonator at least, which equal windows do not resolve: those that follow a tolerance do, see below.
    let third = 1.0 / 3.0;
    let cases: [(f64, f64, [f64; 3]); 13] = [
        (0.7, third, [1.2e-10, 2.4e-11, 2.4e-11]),
        (1.05, third, [1.2e-11, 4.4e-12, 7e-13]),
        (1.2, third, [1.4e-10, 1.8e-11, 3.5e-13]),
        (1.5, third, [2.5e-13; 3]),
        (2.0, third, [2.5e-14; 3]),
        (2.5, third, [2e-13; 3]),
        (3.0, third, [2.5e-14; 3]),
        (5.0, third, [2.5e-14; 3]),
        (1.5, 1e-6, [4e-8; 3]),
        (1.5, 1e-4, [2.5e-8, 1.8e-12, 6e-13]),
        (1.5, 1e-2, [1.8e-12; 3]),
        (1.5, 1e2, [1.1e-13; 3]),
        (1.5, 1e6, [1e-13; 3]),
    ];
    for (alpha, rho, bounds) in cases {
        let chain = Chain::<f64>::new(Params::new(alpha, 1.0, rho).unwrap(), Boundary::Free, 6).unwrap();
        let start = generic_state(&chain).unwrap();
        let reference = truth(&chain, start.as_slice(), 12.0, 1e-14);
        for (count, bound) in [60, 120, 240].into_iter().zip(bounds) {
            let (y, _) = collocated(&chain, start.as_slice(), 12.0, windows(count, 10));
            let error = distance(chain.layout().u(&y), chain.layout().u(&reference));
            println!("alpha {alpha}, rho {rho:e}, {count} windows: {error:.1e} ({bound:.1e})");
            assert!(error < bound, "alpha {alpha}, rho {rho:e}, {count} windows: {error:e}");
        }
        if rho == 1e-6 {
            let (y, _) = collocated(&chain, start.as_slice(), 12.0, Pace::Tolerance(1e-10));
            let error = distance(&y[..12], &reference[..12]);
            println!("alpha {alpha}, rho {rho:e}, tol 1e-10: {error:.1e}");
            assert!(error < 1e-9, "{error:e}");
        }
    }
}

#[test]
fn random_chains_agree_with_the_regularised_run() {
    // Every exponent, mass ratio and boundary, from 1 to 9 beads, amplitudes from 1e-3 to 1. No run may fail, and errors stay near what
    // was asked for. Truth: the regularised run.
    let tol = 1e-7;
    let mut ratios = Vec::new();
    for case in 0..300u64 {
        let mut next = random(case.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 12345);
        let alphas = [1.5, 1.5, 0.7, 1.05, 1.2, 2.0, 2.5, 3.0, 5.0, 1.0 + 3.0 * next()];
        let alpha = alphas[(next() * 10.0) as usize];
        let rhos = [0.0, f64::INFINITY, 1e-6, 1e-4, 1e-2, 1.0 / 3.0, 3.0, 1e2, 1e4, 1e6];
        let rho = rhos[(next() * 10.0) as usize];
        let sites = 1 + (next() * 9.0) as usize;
        let boundary = [Boundary::Free, Boundary::Fixed, Boundary::Ring, Boundary::StrainRing][(next() * 4.0) as usize];
        let amplitude = 10f64.powf(-3.0 * next());
        let chain = Chain::<f64>::new(Params::new(alpha, 1.0, rho).unwrap(), boundary, sites).unwrap();
        // Some start with beads that just touch, at rest.
        let sparse = next() < 0.2;
        let state = State::from_fn(&chain, |_| {
            let mut draw = || {
                let value = amplitude * (2.0 * next() - 1.0);
                if sparse && next() < 0.5 { 0.0 } else { value }
            };
            let (u, v, u_dot, v_dot) = (draw(), draw(), draw(), draw());
            // Light resonators follow their beads.
            if rho < 0.1 { Site { u, v: u, u_dot, v_dot: u_dot } } else { Site { u, v, u_dot, v_dot } }
        })
        .unwrap();
        let y0 = state.as_slice();
        let reference = truth(&chain, y0, 8.0, 1e-13);
        let (y, _) = collocated(&chain, y0, 8.0, Pace::Tolerance(tol));
        let half = y.len() / 2;
        let size = largest(reference[..half].iter().copied());
        let ratio = distance(&y[..half], &reference[..half]) / (tol * size.max(1e-300));
        assert!(ratio < 200.0, "case {case}, alpha {alpha}, rho {rho}, {sites} {boundary:?}: {ratio}");
        ratios.push(ratio);
    }
    ratios.sort_by(f64::total_cmp);
    println!("median {:.1e}, 90 % {:.1e}, worst {:.1e}", ratios[150], ratios[270], ratios[299]);
    assert!(ratios[270] < 1.0);
}

struct At<'a> {
    times: &'a [f64],
    states: Vec<Vec<f64>>,
}

impl Observer<f64> for At<'_> {
    fn next(&self) -> Option<f64> {
        self.times.get(self.states.len()).copied()
    }

    fn observe(&mut self, _: f64, y: &[f64], _: Stats) -> Result<ControlFlow<()>, Error> {
        self.states.push(y.to_vec());
        Ok(ControlFlow::Continue(()))
    }
}

#[test]
fn states_inside_a_window_are_as_accurate_as_at_its_end_and_change_nothing() {
    let chain = Chain::<f64>::new(Params::new(1.5, 1.0, 1.0 / 3.0).unwrap(), Boundary::Ring, 7).unwrap();
    let start = generic_state(&chain).unwrap();
    let y0 = start.as_slice();
    let times: Vec<f64> = (1..40).map(|k| 0.137 * f64::from(k)).collect();
    let pace = Pace::Tolerance(1e-12);
    let mut observer = At { times: &times, states: Vec::new() };
    let mut watched = chain.collocation(y0, (0.0, 6.0), pace).unwrap();
    let mut y = y0.to_vec();
    drive(&mut watched, &mut observer, &mut y).unwrap();

    assert_eq!(y, collocated(&chain, y0, 6.0, pace).0, "looking changes no bit");
    let error = |(&t, state): (&f64, &Vec<f64>)| distance(state, &truth(&chain, y0, t, 1e-15));
    let worst = largest(times.iter().zip(&observer.states).map(error));
    println!("{worst:e}");
    assert!(worst < 1e-12, "{worst:e}");
}

#[test]
fn contacts_are_those_that_a_search_of_every_step_finds() {
    // Truth: the regularised run, sampled and searched.
    let scene = generic_scene("random", 0.5, "fixed", 20.0);
    let log = |method, tol| {
        let setting = Setting::Tolerance(tol);
        run_with_contacts(&scene, method, setting, Records::End, &mut |_| ()).unwrap().contacts.unwrap()
    };
    let found = log(Method::Collocation, 1e-12);
    let expected = log(Method::named("dop853-regularised").unwrap(), 1e-14);
    assert_eq!(found.len(), expected.len());
    assert!(found.len() > 40);
    // Speeds come from a quotient extrapolated to its end: twice what was measured.
    let close = |a: Option<f64>, b: Option<f64>, bound: f64| match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() < bound,
        (a, b) => a == b,
    };
    for (a, b) in found.iter().zip(&expected) {
        assert_eq!(a.bond, b.bond);
        assert!(close(a.onset, b.onset, 1e-9) && close(a.release, b.release, 1e-9), "{a:?} {b:?}");
        assert!(close(a.approach, b.approach, 3e-6) && close(a.separation, b.separation, 3e-6), "{a:#?} {b:#?}");
        assert!((a.impulse - b.impulse).abs() < 1e-9, "{a:#?} {b:#?}");
        assert!((a.largest_overlap - b.largest_overlap).abs() < 1e-9, "{a:#?} {b:#?}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let chain = Chain::<f64>::new(Params::new(1.5, 1.0, 1.0 / 3.0).unwrap(), Boundary::Ring, 700).unwrap();
    let mut next = random(3);
    let mut draw = || 0.1 * (2.0 * next() - 1.0);
    let state = State::from_fn(&chain, |_| Site { u: draw(), v: draw(), u_dot: draw(), v_dot: draw() }).unwrap();
    let y0 = state.as_slice();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| collocated(&chain, y0, 3.0, Pace::Tolerance(1e-10)).0)
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(3));
    // Blocks that are solved apart fit together: the whole conserves momentum and energy.
    let energy = |y: &[f64]| chain.energy(y).total();
    let drift = (energy(&one) / energy(y0) - 1.0).abs();
    let momentum = (chain.momentum(&one) - chain.momentum(y0)).abs();
    println!("energy {drift:e}, momentum {momentum:e}");
    assert!(drift < 1e-12 && momentum < 1e-12);
}

#[test]
fn a_thousand_periods_keep_the_energy_to_rounding() {
    let scene = generic_scene("random", 0.5, "ring", 1000.0);
    let outcome = run(&scene, Method::Collocation, Setting::Windows(4000, 12), Records::Energy, &mut |_| ()).unwrap();
    let error = outcome.energy_error.unwrap();
    println!("{error:e}");
    assert!(error < 1e-12, "{error:e}");
}

#[test]
fn paces_outside_their_rules_are_refused() {
    let chain = Chain::<f64>::new(Params::new(1.5, 1.0, 1.0).unwrap(), Boundary::Free, 3).unwrap();
    let y0 = vec![0.0; 12];
    for pace in [
        Pace::Tolerance(0.0),
        Pace::Tolerance(-1.0),
        Pace::Tolerance(f64::NAN),
        Pace::Tolerance(1.0),
        windows(0, 8),
        windows(10, 7),
        windows(10, 2),
        windows(10, 18),
    ] {
        let refused = chain.collocation(&y0, (0.0, 1.0), pace).err();
        assert!(matches!(refused, Some(Error::Argument { .. })), "{pace:?}");
    }
    assert!(chain.collocation(&y0[..3], (0.0, 1.0), windows(1, 8)).is_err());
    assert!(chain.collocation(&y0, (1.0, 0.0), windows(1, 8)).is_err());
}

#[test]
fn a_chain_at_rest_and_a_single_bead_cost_nothing_and_stay() {
    for boundary in [Boundary::Free, Boundary::Fixed, Boundary::Ring, Boundary::StrainRing] {
        for sites in [1, 2, 5] {
            let chain = Chain::<f64>::new(Params::new(1.5, 1.0, 1.0).unwrap(), boundary, sites).unwrap();
            let y0 = vec![0.0; 4 * sites];
            let (y, stats) = collocated(&chain, &y0, 100.0, Pace::Tolerance(1e-10));
            assert_eq!(y, y0);
            assert!(stats.steps < 20, "{}", stats.steps);
        }
    }
}
