//! Contact collocation of chains whose beads and bonds differ, are damped and driven, and
//! dissipate.

use crate::{
    collocation::generic,
    common::{distance, largest, slope_of_windows},
    open,
    variations::altered,
    windows,
};
use hertzchain::{
    chain::{
        Boundary, Chain, Contact, Details, Dissipation, Drive, DriveKind, Envelope, Harmonic, Kind, Params, Signal,
        Site, State, Variations,
    },
    integrators::{
        Instructions, Silent, Stepper,
        collocation::{StepControl, Tangent},
        drive,
    },
    run::{Method, Records, Run, Setting},
    scene::Scene,
};
use std::{
    f64::consts::TAU,
    sync::{Mutex, PoisonError},
};

/// Numbers from 0 to 1, the same in every run.
pub(crate) fn random(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Details in which everything differs from bead to bead and from bond to bond: walls and gaps,
/// exponents 3/2, 2 and 5/2, sites without resonators and with ones that stay at rest.
fn unequal(uniform: &Chain<f64>, within: &mut dyn FnMut(f64, f64) -> f64) -> Details {
    let (sites, bonds) = (uniform.sites(), uniform.touching().len());
    let exponents = [1.5, 1.5, 1.5, 2.0, 2.5];
    let held = if uniform.boundary() == Boundary::Free { 0.0 } else { 0.2 };
    let mut list = |count: usize, from: f64, to: f64| (0..count).map(|_| within(from, to)).collect::<Vec<f64>>();
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

/// A law of dissipation and its largest constant, if contacts dissipate, and whether the chain is
/// damped and driven.
pub(crate) type Kinds = (Option<(Kind, f64)>, bool);

/// A chain with such details, and such a state. If it is driven, it has drag and dashpots, a bead
/// that is moved, and beads that are pushed, under a ramp and by a burst.
pub(crate) fn varied(seed: u64, boundary: Boundary, sites: usize, (law, driven): Kinds) -> (Chain<f64>, Vec<f64>) {
    let mut next = random(seed);
    let mut within = |from: f64, to: f64| from + (to - from) * next();
    let uniform = Chain::<f64>::new(Params::new(1.5, 1.0, 1.0).unwrap(), boundary, sites).unwrap();
    let mut details = unequal(&uniform, &mut within);
    let mut list =
        |count: usize, from: f64, to: f64| -> Vec<f64> { (0..count).map(|_| within(from, to).max(0.0)).collect() };
    // Two contacts of ten do not dissipate.
    details.dissipation = law.map(|(kind, most)| {
        let strength = list(uniform.touching().len(), -0.25 * most, most);
        Dissipation { kind, strength }
    });
    if driven {
        (details.rho[0], details.kappa[0]) = (0.0, 0.0);
        let damped = |(dashpot, rho): (f64, &f64)| if *rho == 0.0 { 0.0 } else { dashpot };
        details.dashpot = list(sites, -0.1, 0.4).into_iter().zip(&details.rho).map(damped).collect();
        details.drag = list(sites, -0.1, 0.3);
        details.drag[0] = 0.0;
        let harmonics = |list: &[[f64; 3]]| {
            list.iter().map(|&[amplitude, omega, phase]| Harmonic { amplitude, omega, phase }).collect()
        };
        let drive = |site, kind, list: &[[f64; 3]], envelope| {
            let signal = Signal::new(harmonics(list), envelope);
            Drive { site, kind, signal }
        };
        let burst = Envelope::Burst { start: 1.3, length: 4.0 };
        details.drives = vec![
            drive(0, DriveKind::Displacement, &[[0.2, 1.7, 0.3], [0.1, 0.9, 1.0]], Envelope::None),
            drive(sites - 3, DriveKind::Force, &[[0.5, 2.5, 0.0]], Envelope::Ramp(3.3)),
            drive(2, DriveKind::Force, &[[0.8, 1.1, 0.5]], burst),
            drive(2, DriveKind::Force, &[[0.1, 0.0, TAU / 4.0]], Envelope::None),
        ];
    }
    let chain = uniform.with(&details).unwrap();
    let y0 = lively(&chain, &mut within);
    (chain, y0)
}

/// Energy + dissipated - driven.
pub(crate) fn balance(chain: &Chain<f64>, y: &[f64]) -> f64 {
    let ledger = chain.layout().ledger(y).unwrap();
    chain.energy(y).total() + ledger.dissipated() - ledger.driven
}

/// The order in the length of windows, of which there are `least` and three times as many, of a
/// part of the state at t = 8, against the finest run.
fn order(chain: &Chain<f64>, y0: &[f64], part: std::ops::Range<usize>, (least, nodes): (u64, usize)) -> f64 {
    let want = collocation(chain, y0, 8.0, StepControl::Tolerance(1e-14));
    let error =
        |count| distance(&collocation(chain, y0, 8.0, windows(count, nodes))[part.clone()], &want[part.clone()]);
    slope_of_windows([least, 3 * least], error)
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

/// The largest errors of six chains, in tolerances of so many decades from 1e-4 on.
///
/// Truth: regularised DOP853 at 3e-15 a step. The tolerance is relative to the size of velocities,
/// at the start or of the drives. What is dissipated and driven is held to it too.
fn errors_in_tolerances(kinds: Kinds, decades: usize) -> Vec<f64> {
    let mut worst = vec![0.0f64; decades];
    for seed in 0..6 {
        let (chain, y0) = varied(seed, BOUNDARIES[seed as usize % 3], 12, kinds);
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
fn tolerances_are_kept_over_many_decades() {
    // Conservative chains; damped and driven ones; with contacts that dissipate, also by dashpots,
    // whose forces jump.
    for (kinds, decades, bound) in [
        ((None, false), 9, 3.0),
        ((None, true), 8, 1.0),
        ((Some((Kind::Viscoelastic, 0.3)), false), 7, 1.0),
        ((Some((Kind::Viscoelastic, 1.0)), true), 7, 1.0),
        ((Some((Kind::Dashpot, 0.4)), false), 7, 1.0),
        ((Some((Kind::HuntCrossley, 0.8)), true), 7, 1.0),
    ] {
        let errors = errors_in_tolerances(kinds, decades);
        assert!(errors.iter().all(|error| *error < bound), "{kinds:?}: {errors:?}");
    }
}

#[test]
fn energy_dissipated_and_driven_balance() {
    // Truth: energy + dissipated - driven is constant. Every part is measured on its own. Measured:
    // 2.3e-14 where contacts do not dissipate, and 6.3e-14.
    let laws = [(Kind::Viscoelastic, 0.3), (Kind::Dashpot, 0.4), (Kind::HuntCrossley, 0.8)].map(Some);
    for law in [None].into_iter().chain(laws) {
        let (bound, powers) = match law {
            None => (3e-14, &[(0.0, false)][..]),
            Some(_) => (1e-13, &[(0.0, false), (0.0, true), (0.25, true)][..]),
        };
        for (seed, boundary) in BOUNDARIES.into_iter().enumerate() {
            for driven in [false, true].into_iter().filter(|driven| *driven || law.is_some()) {
                let (chain, y0) = varied(10 + seed as u64, boundary, 12, (law, driven));
                for &(beta, pull) in powers {
                    let chain = altered(&chain, |details| (details.beta, details.pull) = (beta, pull));
                    let end = collocation(&chain, &y0, 40.0, StepControl::Tolerance(5e-14));
                    let ledger = chain.layout().ledger(&end).unwrap();
                    let off = (balance(&chain, &end) - balance(&chain, &y0)).abs();
                    let words = format!("{law:?} {boundary:?} {driven} {beta} {pull}");
                    println!("{words}: {off:e}, {ledger:?}");
                    assert!(off < bound && (law.is_none() || ledger.contacts > 0.01), "{words}: {off:e} {ledger:?}");
                    let open = [ledger.drag, ledger.dashpots, ledger.driven.abs()].iter().all(|part| *part > 0.01);
                    assert!(open || !driven, "{words}: {ledger:?}");
                }
            }
        }
    }
}

#[test]
fn the_order_of_windows_is_that_of_conservative_chains() {
    // Truth: the finest run; and the order of the same chain without what dissipates and drives, in
    // the same windows; of the state and of the ledger.
    let lossy = varied(0, Boundary::Fixed, 8, (Some((Kind::Viscoelastic, 0.3)), false));
    for (what, (open, y0), least, nodes) in
        [("0", open::varied(0), 40, 4), ("1", open::varied(1), 40, 4), ("viscoelastic", lossy, 12, 8)]
    {
        let closed = altered(&open, |details| {
            (details.drag, details.dashpot, details.drives, details.dissipation) = (vec![], vec![], vec![], None);
        });
        let split = 2 * open.layout().half();
        let slope = |chain: &Chain<f64>, part| order(chain, &y0[..chain.layout().dim()], part, (least, nodes));
        let [state, ledger] = [0..split, split..split + 4].map(|part| slope(&open, part));
        let reference = slope(&closed, 0..split);
        println!("{what}: {state:.2} {ledger:.2}, conservative {reference:.2}");
        assert!(state > reference - 0.5 && ledger > reference - 0.5 && state > 3.5, "{state} {ledger} {reference}");
    }
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
fn panels_cut_at_events_of_neighbours_keep_the_order_where_beads_differ() {
    // Truth: the finest run. Measured: 6.82.
    let (chain, y0) = varied(1, Boundary::Fixed, 8, (None, false));
    let slope = order(&chain, &y0, 0..y0.len(), (12, 8));
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
/// regularised run finds, in the order of [`apart`], then largest overlaps.
fn contacts_are_found((chain, y0, end): (&Chain<f64>, &[f64], f64), count: usize, bounds: [f64; 5]) {
    let log = |method: &str, tol: f64| {
        let run = of(chain, y0, end).method(Method::named(method).unwrap()).setting(Setting::Tolerance(tol));
        run.records(Records::End).contacts().start().unwrap().contacts.unwrap()
    };
    let (found, expected) = (log("collocation", 1e-12), log("dop853-regularised", 1e-14));
    let [onsets, releases, impulses, speeds] = apart(&found, &expected);
    let overlaps = largest(found.iter().zip(&expected).map(|(a, b)| a.largest_overlap - b.largest_overlap));
    let worst = [onsets, releases, impulses, speeds, overlaps];
    println!("{} contacts; onsets, releases, impulses, speeds, overlaps: {worst:?}", found.len());
    assert!(found.len() > count, "{}", found.len());
    assert!(worst.iter().zip(bounds).all(|(off, bound)| *off < bound), "{worst:?}");
}

#[test]
fn contacts_are_those_that_a_search_of_every_step_finds() {
    // From overlap to overlap, also while beads do not push. Measured: 9.8e-12, 1.3e-12, and speeds
    // 5.1e-9; where contacts dissipate 5.0e-11, 3.3e-11 and 2.9e-12; of equal beads 2.3e-11, 5.7e-12,
    // speeds, from a quotient extrapolated to its end, 1.3e-7, and overlaps 1.9e-11. A bond with the
    // constant zero is no contact, whatever its overlap.
    let (chain, y0) = generic(Boundary::Fixed);
    contacts_are_found((&chain, &y0, 20.0), 40, [7e-11, 7e-11, 1.8e-11, 4e-7, 5e-11]);
    let (all, lossy) = (f64::INFINITY, Some((Kind::Viscoelastic, 0.3)));
    for (seed, boundary, kinds, count, bounds) in [
        (4, Boundary::Fixed, (None, false), 40, [2e-11, 2e-11, 3e-12, 1e-8, all]),
        (4, Boundary::Fixed, (None, true), 30, [5e-11, 5e-11, 5e-12, all, all]),
        (2, Boundary::Ring, (lossy, true), 30, [1e-10, 1e-10, 6e-12, all, all]),
    ] {
        let (chain, y0) = varied(seed, boundary, 12, kinds);
        contacts_are_found((&chain, &y0, 24.0), count, bounds);
    }
    let free = Details { contact: vec![1.0, 0.0, 1.0], overlap: vec![0.0; 3], ..Details::default() };
    let chain = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 4).unwrap().with(&free).unwrap();
    let end = collocation(&chain, &[0.0, 0.5, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0], 3.0, StepControl::Tolerance(1e-10));
    assert_eq!(end, [0.0, 3.5, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0], "a bead passes through where no contact is");
}

#[test]
fn energy_is_kept_over_a_long_time() {
    // Truth: the invariant. Measured: 3e-14, and 2.7e-13 of a hundred and more periods of equal
    // beads.
    for (bound, (chain, y0)) in
        [(7e-14, varied(2, Boundary::Ring, 12, (None, false))), (6e-13, generic(Boundary::Ring))]
    {
        let run = of(&chain, &y0, 1000.0).tolerance(1e-12).unwrap().records(Records::Energy);
        let error = run.start().unwrap().complete().unwrap().energy_error.unwrap();
        println!("{error:e}");
        assert!(error < bound, "{error:e}");
    }
}

#[test]
fn instruction_sets_and_samples_do_not_change_bits() {
    // Runs at three tolerances; samples are as accurate as the end: the balance is checked at each
    // of them. Instruction sets are those of all threads: one test at a time chooses them.
    static SETS: Mutex<()> = Mutex::new(());
    let _alone = SETS.lock().unwrap_or_else(PoisonError::into_inner);
    for kinds in [(None, false), (None, true), (Some((Kind::Viscoelastic, 0.3)), true)] {
        let (chain, y0) = varied(3, Boundary::Ring, 12, kinds);
        let (widest, ends) = (Instructions::used(), |set: Instructions| {
            assert!(set.select());
            [1e-5, 1e-8, 1e-12].map(|tol| collocation(&chain, &y0, 6.0, StepControl::Tolerance(tol)))
        });
        let all: Vec<_> = Instructions::ALL.into_iter().filter(|set| set.available()).map(ends).collect();
        assert!(widest.select());
        for other in &all[1..] {
            assert_eq!(&all[0], other);
        }
        let run = of(&chain, &y0, 6.0).method(Method::Collocation).tolerance(1e-8).unwrap();
        let sampled = run.samples(100).unwrap().start().unwrap().complete().unwrap();
        let error = sampled.energy_error.unwrap();
        assert!(sampled.state == all[0][1] && error < 1e-8, "{error:e}");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    // Three blocks, and one in which nothing happens.
    let (chain, mut y0) = varied(6, Boundary::Free, 1000, (None, true));
    let chain = altered(&chain, |details| details.drives.truncate(1));
    for part in y0[..4000].chunks_mut(1000) {
        part[600..].fill(0.0);
    }
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| collocation(&chain, &y0, 2.0, StepControl::Tolerance(1e-12)))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(3));
    // Blocks are solved separately and fit together, also in the ledger.
    let off = (balance(&chain, &one) / balance(&chain, &y0) - 1.0).abs();
    println!("balance {off:e}");
    assert!(off < 3e-15, "{off:e}");
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
    // Truth: the variational equation by regularised DOP853, of beads and resonators that are free.
    for (seed, driven) in [7, 8, 9].into_iter().flat_map(|seed| [(seed, false), (seed, true)]) {
        let (chain, y0) = varied(seed, BOUNDARIES[seed as usize % 3], 6, (None, driven));
        let gap = off_variations(&chain, &y0, 5.0, |i| i != 0 || !driven);
        println!("{seed} {driven}: {gap:e}");
        assert!(gap < 1e-11, "{seed} {driven}: {gap:e}");
        if driven {
            continue;
        }
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
