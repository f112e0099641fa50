//! Contact collocation of chains whose beads and bonds differ.

use crate::{
    common::{collocated, distance, largest},
    details::{run, stored},
    windows,
};
use hertzchain::{
    chain::{Boundary, Chain, Contact, Details, Params, Site, State, Variations},
    integrators::{
        Instructions, Silent, Stepper,
        collocation::{StepControl, Tangent},
        drive,
    },
    run::{Method, Records, Run, Setting},
    scene::Scene,
};
use std::sync::{Mutex, PoisonError};

/// Numbers from 0 to 1, the same in every run.
pub(crate) fn random(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// So many numbers of `within`, a random number between two others.
pub(crate) fn list(within: &mut dyn FnMut(f64, f64) -> f64, count: usize, from: f64, to: f64) -> Vec<f64> {
    (0..count).map(|_| within(from, to)).collect()
}

/// Details in which everything differs from bead to bead and from bond to bond: walls and gaps,
/// exponents 3/2, 2 and 5/2, sites without resonators and with ones that stay at rest.
pub(crate) fn unequal(uniform: &Chain<f64>, within: &mut dyn FnMut(f64, f64) -> f64) -> Details {
    let (sites, bonds) = (uniform.sites(), uniform.touching().len());
    let exponents = [1.5, 1.5, 1.5, 2.0, 2.5];
    let held = if uniform.boundary() == Boundary::Free { 0.0 } else { 0.2 };
    let mut list = |count: usize, from: f64, to: f64| list(within, count, from, to);
    let rho = list(sites, -0.5, 2.5).into_iter().map(|rho| if rho > 2.2 { f64::INFINITY } else { rho.max(0.0) });
    Details {
        rho: rho.collect(),
        mass: list(sites, 0.5, 2.0),
        kappa: list(sites, 0.5, 2.0),
        contact: list(bonds, 0.5, 2.0),
        alpha: list(bonds, 0.0, 5.0).into_iter().map(|k| exponents[k as usize]).collect(),
        overlap: list(bonds, -0.2, held),
        ..Details::default()
    }
}

/// A state in which beads meet and part; a bead that is moved is where its drive has it.
pub(crate) fn lively(chain: &Chain<f64>, within: &mut dyn FnMut(f64, f64) -> f64) -> Vec<f64> {
    let state = State::from_fn(chain, |_| {
        let [u, v, u_dot, v_dot] = [0.2, 0.2, 0.6, 0.3].map(|size| within(-size, size));
        Site { u, v, u_dot, v_dot }
    });
    state.unwrap().driven(chain).as_slice().to_vec()
}

/// A chain with such details, and such a state.
fn varied(seed: u64, boundary: Boundary, sites: usize) -> (Chain<f64>, Vec<f64>) {
    let mut next = random(seed);
    let mut within = |from: f64, to: f64| from + (to - from) * next();
    let uniform = Chain::<f64>::new(Params::new(1.5, 1.0, 1.0).unwrap(), boundary, sites).unwrap();
    let details = unequal(&uniform, &mut within);
    let chain = uniform.with(&details).unwrap();
    let y0 = lively(&chain, &mut within);
    (chain, y0)
}

/// Energy + dissipated - driven.
pub(crate) fn balance(chain: &Chain<f64>, y: &[f64]) -> f64 {
    let ledger = chain.layout().ledger(y).unwrap();
    chain.energy(y).total() + ledger.dissipated() - ledger.driven
}

/// The order in the length of windows, of which there are `least` and three times as many, of a part
/// of the state at t = 8, against the finest run: of means of the error over nearby numbers of
/// windows.
pub(crate) fn order(chain: &Chain<f64>, y0: &[f64], part: std::ops::Range<usize>, (least, nodes): (u64, usize)) -> f64 {
    let want = collocation(chain, y0, 8.0, StepControl::Tolerance(1e-14));
    let mean = |count: u64| {
        let error = |k: u64| {
            let got = collocation(chain, y0, 8.0, windows(count + count * k / 24, nodes));
            distance(&got[part.clone()], &want[part.clone()]).ln()
        };
        ((0..12).map(error).sum::<f64>() / 12.0).exp()
    };
    let (coarse, fine) = (mean(least), mean(3 * least));
    println!("{coarse:e} {fine:e}");
    (coarse / fine).ln() / 3f64.ln()
}

pub(crate) fn collocation(chain: &Chain<f64>, y0: &[f64], end: f64, control: StepControl) -> Vec<f64> {
    let mut run = chain.heterogeneous_collocation(y0, (0.0, end), control).unwrap();
    let mut y = y0.to_vec();
    drive(&mut run, &mut Silent, &mut y).unwrap();
    y
}

pub(crate) fn of(chain: &Chain<f64>, y0: &[f64], end: f64) -> Run {
    let mut state = State::rest(chain);
    state.as_mut_slice().copy_from_slice(y0);
    Run::new(chain.clone(), state).until(end).unwrap()
}

pub(crate) fn regularised(chain: &Chain<f64>, y0: &[f64], end: f64) -> Vec<f64> {
    let run = of(chain, y0, end).method(Method::named("dop853-regularised").unwrap()).records(Records::End);
    run.setting(Setting::Tolerance(3e-15)).start().unwrap().complete().unwrap().state
}

pub(crate) const BOUNDARIES: [Boundary; 3] = [Boundary::Free, Boundary::Fixed, Boundary::Ring];

#[test]
fn twelve_beads_and_two_hundred_contacts_are_those_of_another_program() {
    // Truth: `tests/reference/details.py` and `quad.c`, with 34 and 33 digits, whose own errors are
    // below 1e-17 and 1e-14. Measured: 5.6e-16 and 5.3e-13; DOP853, whose tolerance is that of a
    // step, 6.2e-12 on the second, which enlarges a change of a velocity up to 600 times.
    for (name, bound, least) in [("conservative", 2e-15, 5), ("twelve", 1.1e-12, 200)] {
        let (chain, state, end, want) = stored(name);
        let here = of(&chain, state.as_slice(), end).tolerance(1e-14).unwrap().contacts();
        let outcome = here.start().unwrap().complete().unwrap();
        let (error, energy) = (distance(&outcome.state, &want), outcome.energy_error.unwrap());
        let contacts = outcome.contacts.unwrap().len();
        let other = run(&chain, &state, end, "dop853-regularised", Setting::Tolerance(1e-15)).state;
        println!("{name}: {error:e}, energy {energy:e}, {contacts} contacts, dop853 {:e}", distance(&other, &want));
        assert!(distance(&other, &want) < 1e-11, "{name}: {:e}", distance(&other, &want));
        assert!(error < bound && energy < 1e-14 && contacts >= least, "{name}: {error:e} {energy:e} {contacts}");
    }
}

/// The largest errors of six chains, in tolerances of so many decades from 1e-4 on.
///
/// Truth: regularised DOP853 at 3e-15 a step. The tolerance is relative to the size of velocities,
/// at the start or of the drives. What is dissipated and driven is held to it too.
pub(crate) fn errors_in_tolerances(of: impl Fn(u64, Boundary) -> (Chain<f64>, Vec<f64>), decades: usize) -> Vec<f64> {
    let mut worst = vec![0.0f64; decades];
    for seed in 0..6 {
        let (chain, y0) = of(seed, BOUNDARIES[seed as usize % 3]);
        let want = regularised(&chain, &y0, 8.0);
        let half = chain.layout().half();
        let size = largest(y0[half..2 * half].iter().copied());
        for (k, worst) in worst.iter_mut().enumerate() {
            let tol = 10f64.powi(-4 - k as i32);
            let error = distance(&collocation(&chain, &y0, 8.0, StepControl::Tolerance(tol)), &want);
            *worst = largest([*worst, error / (tol * size)]);
        }
    }
    println!("{worst:?}");
    worst
}

#[test]
fn tolerances_are_kept_over_eight_decades() {
    let errors = errors_in_tolerances(|seed, boundary| varied(seed, boundary, 12), 9);
    assert!(errors.iter().all(|error| *error < 3.0), "{errors:?}");
}

#[test]
fn struck_chains_keep_tolerances_times_what_the_motion_makes_of_a_perturbation() {
    // Truth: the finest run, which the test above holds against others; and the tangent map, whose
    // largest entry from a velocity says what becomes of a perturbation.
    for name in ["dimer", "disorder"] {
        let scene = Scene::load(name).unwrap();
        let (chain, y0, end) = (scene.chain(), scene.initial().as_slice(), scene.end());
        let want = collocation(chain, y0, end, StepControl::Tolerance(1e-15));
        let columns = chain.monodromy(y0, (0.0, end), StepControl::Tolerance(1e-12)).unwrap();
        let amplification = largest(columns[columns.len() / 2..].iter().copied());
        let errors: Vec<f64> = (3..13)
            .map(|k| {
                let tol = 10f64.powi(-k);
                distance(&collocation(chain, y0, end, StepControl::Tolerance(tol)), &want) / (tol * amplification)
            })
            .collect();
        println!("{name} {amplification:.1}: {errors:.2?}");
        assert!(errors.iter().all(|error| *error < 3.0), "{name}: {errors:?}");
    }
}

#[test]
fn beads_that_are_all_equal_are_the_uniform_chain() {
    // Truth: the chain without details, in the same windows; roundings, which contacts enlarge. A
    // ring of one bead has a bond that no force moves, one of two beads two bonds between the same
    // sites.
    for (rho, boundary, n) in [
        (0.0, Boundary::Free, 10),
        (0.4, Boundary::Fixed, 10),
        (f64::INFINITY, Boundary::Ring, 10),
        (0.4, Boundary::Ring, 9),
        (0.4, Boundary::Ring, 1),
        (0.4, Boundary::Ring, 2),
        (0.4, Boundary::Fixed, 1),
        (0.0, Boundary::Free, 1),
    ] {
        let uniform = Chain::<f64>::new(Params::new(1.5, 1.3, rho).unwrap(), boundary, n).unwrap();
        let (_, y) = varied(5, boundary, n);
        let state = State::from_fn(&uniform, |i| {
            let v = if rho == 0.4 { y[i] } else { 0.0 };
            Site { u: y[i], v, u_dot: y[y.len() / 2 + i], v_dot: v }
        });
        let y0 = state.unwrap().as_slice().to_vec();
        let chain = uniform.clone().with(&Details::default()).unwrap();
        let control = windows(80, 12);
        let gap = distance(&collocation(&chain, &y0, 8.0, control), &collocated(&uniform, &y0, 8.0, control).0);
        println!("{rho} {boundary:?} {n}: {gap:e}");
        assert!(gap < 2e-13, "{rho} {boundary:?} {n}: {gap:e}");
    }
}

#[test]
fn panels_cut_at_events_of_neighbours_keep_the_order_where_beads_differ() {
    // Truth: the finest run. Mean of errors over nearby numbers of windows. Measured: 6.82.
    let (chain, y0) = varied(1, Boundary::Fixed, 8);
    let want = collocation(&chain, &y0, 8.0, StepControl::Tolerance(1e-14));
    let mean = |count: u64| {
        let error = |k: u64| {
            let control = StepControl::Windows { windows: count + count * k / 24, nodes: 8, neighbours: true };
            distance(&collocation(&chain, &y0, 8.0, control), &want).ln()
        };
        ((0..12).map(error).sum::<f64>() / 12.0).exp()
    };
    let (coarse, fine) = (mean(12), mean(32));
    let slope = (coarse / fine).ln() / (32.0f64 / 12.0).ln();
    println!("{coarse:e} {fine:e}: {slope:.2}");
    assert!(slope > 6.0, "{slope}");
}

/// The largest differences of two logs: of onsets, of releases, of impulses and of speeds.
pub(crate) fn apart(found: &[Contact], expected: &[Contact]) -> [f64; 4] {
    let off = |a: Option<f64>, b: Option<f64>| match (a, b) {
        (Some(a), Some(b)) => (a - b).abs(),
        (a, b) => f64::from(u8::from(a != b)) * 1e300,
    };
    assert_eq!(found.len(), expected.len());
    found.iter().zip(expected).fold([0.0; 4], |worst: [f64; 4], (a, b)| {
        assert_eq!(a.bond, b.bond);
        let speeds = off(a.approach, b.approach).max(off(a.separation, b.separation));
        let here = [off(a.onset, b.onset), off(a.release, b.release), (a.impulse - b.impulse).abs(), speeds];
        std::array::from_fn(|k| largest([worst[k], here[k]]))
    })
}

/// Holds the contacts of a run, more than so many, against those that a search of every step of the
/// regularised run finds, in the order of [`apart`].
pub(crate) fn contacts_are_found((chain, y0): (Chain<f64>, Vec<f64>), count: usize, bounds: [f64; 4]) {
    let log = |method: &str, tol: f64| {
        let run = of(&chain, &y0, 24.0).method(Method::named(method).unwrap()).setting(Setting::Tolerance(tol));
        run.records(Records::End).contacts().start().unwrap().contacts.unwrap()
    };
    let (found, expected) = (log("collocation", 1e-12), log("dop853-regularised", 1e-14));
    let worst = apart(&found, &expected);
    println!("{} contacts; onsets, releases, impulses, speeds: {worst:?}", found.len());
    assert!(found.len() > count, "{}", found.len());
    assert!(worst.iter().zip(bounds).all(|(off, bound)| *off < bound), "{worst:?}");
}

#[test]
fn contacts_are_those_that_a_search_of_every_step_finds() {
    // Measured: 9.8e-12, 1.3e-12, and speeds 5.1e-9. A bond with the constant zero is no contact,
    // whatever its overlap.
    contacts_are_found(varied(4, Boundary::Fixed, 12), 40, [2e-11, 2e-11, 3e-12, 1e-8]);
    let free = Details { contact: vec![1.0, 0.0, 1.0], overlap: vec![0.0; 3], ..Details::default() };
    let chain = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 4).unwrap().with(&free).unwrap();
    let end = collocation(&chain, &[0.0, 0.5, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0], 3.0, StepControl::Tolerance(1e-10));
    assert_eq!(end, [0.0, 3.5, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0], "a bead passes through where no contact is");
}

#[test]
fn energy_is_kept_over_a_long_time() {
    // Truth: the invariant. Measured: 3e-14.
    let (chain, y0) = varied(2, Boundary::Ring, 12);
    let run = of(&chain, &y0, 1000.0).tolerance(1e-12).unwrap().records(Records::Energy);
    let error = run.start().unwrap().complete().unwrap().energy_error.unwrap();
    println!("{error:e}");
    assert!(error < 7e-14, "{error:e}");
}

/// The runs of a chain at three tolerances, which have the same bits for every instruction set;
/// with samples too, which are as accurate as the end: the balance is checked at each of them.
pub(crate) fn same_for_every_set(chain: &Chain<f64>, y0: &[f64], end: f64) {
    // Instruction sets are those of all threads: one test at a time chooses them.
    static SETS: Mutex<()> = Mutex::new(());
    let _alone = SETS.lock().unwrap_or_else(PoisonError::into_inner);
    let (widest, ends) = (Instructions::used(), |set: Instructions| {
        assert!(set.select());
        [1e-5, 1e-8, 1e-12].map(|tol| collocation(chain, y0, end, StepControl::Tolerance(tol)))
    });
    let all: Vec<_> = Instructions::ALL.into_iter().filter(|set| set.available()).map(ends).collect();
    assert!(widest.select());
    for other in &all[1..] {
        assert_eq!(&all[0], other);
    }
    let run = of(chain, y0, end).method(Method::Collocation).tolerance(1e-8).unwrap();
    let sampled = run.samples(100).unwrap().start().unwrap().complete().unwrap();
    let error = sampled.energy_error.unwrap();
    assert!(sampled.state == all[0][1] && error < 1e-8, "{error:e}");
}

#[test]
fn instruction_sets_and_samples_do_not_change_bits() {
    let (chain, y0) = varied(3, Boundary::Ring, 12);
    same_for_every_set(&chain, &y0, 6.0);
}

/// The end of a run, which has the same bits on one, two and three threads.
#[cfg(feature = "parallel")]
pub(crate) fn same_on_any_threads(chain: &Chain<f64>, y0: &[f64], end: f64, tol: f64) -> Vec<f64> {
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| collocation(chain, y0, end, StepControl::Tolerance(tol)))
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(3));
    one
}

#[cfg(feature = "parallel")]
#[test]
fn any_number_of_threads_gives_the_same_bits() {
    // Three blocks, and one in which nothing happens.
    let (chain, mut y0) = varied(6, Boundary::Free, 1000);
    for part in y0.chunks_mut(1000) {
        part[600..].fill(0.0);
    }
    let one = same_on_any_threads(&chain, &y0, 2.0, 1e-9);
    // Blocks are solved separately and fit together.
    let drift = (chain.energy(&one).total() / chain.energy(&y0).total() - 1.0).abs();
    println!("energy {drift:e}");
    // Measured: 1.6e-14.
    assert!(drift < 4e-14, "{drift:e}");
}

/// `dz(t)/dz(0)` of positions and velocities by regularised DOP853 of the variations, by columns.
fn variations(chain: &Chain<f64>, y0: &[f64], t: f64) -> Vec<f64> {
    let rows = 2 * chain.layout().half();
    let unit: Vec<f64> = (0..rows * rows).map(|k| f64::from(u8::from(k % (rows + 1) == 0))).collect();
    let by_rows = Variations::flow(chain, y0, (0.0, t), &unit, 1e-14).unwrap().columns;
    (0..rows * rows).map(|k| by_rows[k % rows * rows + k / rows]).collect()
}

/// The largest difference between the tangent maps of collocation and of the variational equation,
/// as a share of their largest entry. Resonators that are not there, those at rest, and sites that
/// are not `free`, have no variations.
pub(crate) fn off_variations(chain: &Chain<f64>, y0: &[f64], t: f64, free: impl Fn(usize) -> bool) -> f64 {
    let (dim, rows, n) = (y0.len(), 2 * chain.layout().half(), chain.sites());
    let want = variations(chain, y0, t);
    let got = chain.monodromy(y0, (0.0, t), windows(400, 12)).unwrap();
    let moves = |k: usize| free(k % n) && ((k / n).is_multiple_of(2) || chain.resonator_moves(k % n));
    let counts: Vec<usize> = (0..rows).filter(|&k| moves(k)).collect();
    let off = |(i, j): (usize, usize)| (got[j * dim + i] - want[j * rows + i]).abs();
    let size = largest(counts.iter().flat_map(|&j| counts.iter().map(move |&i| j * rows + i)).map(|k| want[k]));
    counts.iter().flat_map(|&j| counts.iter().map(move |&i| (i, j))).map(off).fold(0.0, f64::max) / size
}

#[test]
fn the_tangent_map_is_that_of_the_variational_equation() {
    // Truth: the variational equation by regularised DOP853.
    for seed in [7, 8, 9] {
        let (chain, y0) = varied(seed, BOUNDARIES[seed as usize % 3], 6);
        let gap = off_variations(&chain, &y0, 5.0, |_| true);
        println!("{seed}: {gap:e}");
        assert!(gap < 1e-11, "{seed}: {gap:e}");
        // A column that is followed alone is that of the matrix.
        let (dim, got) = (y0.len(), chain.monodromy(&y0, (0.0, 5.0), windows(400, 12)).unwrap());
        let mut run = chain.heterogeneous_collocation(&y0, (0.0, 5.0), windows(400, 12)).unwrap();
        let mut tangent = Tangent::new(&run, &[vec![1.0], vec![0.0; dim - 1]].concat()).unwrap();
        while !run.done() {
            run.step().unwrap();
            tangent.follow(&run).unwrap();
        }
        assert!(distance(&tangent.matrix(&run).unwrap(), &got[..dim]) < 1e-13 * largest(got.iter().copied()));
    }
}
