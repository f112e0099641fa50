//! Branches that cross others: of doubled period, and at branch points.

use crate::{common::at_end, numbers::distance as apart};
use hertzchain::{
    chain::{Boundary, Chain, Details, Drive, DriveKind, Params, Signal, Variations},
    orbits::{
        BifurcationKind, Branch, DriveParameter, DrivenBranch, DrivenContinuation, DrivenOrbit, DrivenSetting,
        DrivenShooting, End, ModeBranch, ModeContinuation, NormalModes, Point, Problem,
    },
    run::{Method, Run, Setting},
    scene::Scene,
    study::{BifurcationOptions, BranchOptions, Driven, DrivenContinue, FollowCommand, FollowMode},
    sweep::Engine,
};
use std::f64::consts::PI;

/// A bead that rests on a wall under its weight 1, and is shaken.
fn shaken() -> Chain<f64> {
    let amplitude = "drive.0.amplitude=[0.1, -1.0]".to_owned();
    Scene::load_with(include_str!("../reference/pushed-bead.toml"), &[amplitude]).unwrap().chain().clone()
}

/// A bead between two walls, shaken: it moves as its mirror image does half a period later, up to
/// a = 2.38.
fn symmetric() -> Chain<f64> {
    let details = Details {
        drag: vec![0.02],
        overlap: vec![1.0; 2],
        drives: vec![Drive { site: 0, kind: DriveKind::Force, signal: Signal::sine(2.0, 0.8, 0.0) }],
        ..Details::default()
    };
    Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Fixed, 1).unwrap().with(&details).unwrap()
}

/// The branch of driven orbits in a parameter, from one of them.
pub(crate) fn along(parameter: DriveParameter, to: f64, step: f64, start: DrivenOrbit) -> DrivenBranch {
    let shooting = DrivenShooting::default();
    let continuation = DrivenContinuation { parameter, to, step, most_points: 1000, shooting };
    followed(Branch::new(continuation, start.setting.clone(), start).unwrap())
}

pub(crate) fn branch(chain: &Chain<f64>, to: f64, step: f64) -> DrivenBranch {
    let setting = DrivenSetting::new(chain, 1).unwrap();
    let start = DrivenShooting::default().solve(&setting, &vec![0.0; setting.unknowns()]).unwrap();
    along(DriveParameter::Amplitude, to, step, start)
}

/// The number of the first bifurcation of a kind.
fn number(branch: &DrivenBranch, kind: BifurcationKind) -> usize {
    branch.bifurcations.iter().position(|one| one.kind == kind).unwrap()
}

pub(crate) fn followed<P: Problem>(mut branch: Branch<P>) -> Branch<P> {
    branch.extend(|_| {}).unwrap();
    branch.analysed()
}

fn amplitude(orbit: &DrivenOrbit) -> f64 {
    orbit.setting.get(DriveParameter::Amplitude)
}

/// The orbit of the doubled branch near the crossing, with `a` at this distance beyond it.
fn at(branch: &DrivenBranch, distance: f64) -> DrivenOrbit {
    let crossing = amplitude(&branch.points[0].orbit);
    let near = &branch.points[1].orbit;
    let scale = (distance / (amplitude(near) - crossing)).sqrt();
    let start = &branch.points[0].orbit.z;
    let seed: Vec<f64> = start.iter().zip(&near.z).map(|(z, w)| z + scale * (w - z)).collect();
    let setting = near.setting.with(DriveParameter::Amplitude, crossing + distance);
    DrivenShooting::default().solve(&setting, &seed).unwrap()
}

/// The state of an orbit after so many periods of its drive, by a splitting scheme, which shares no
/// code with the search.
fn after(orbit: &DrivenOrbit, periods: f64) -> [Vec<f64>; 2] {
    let (chain, start) = (orbit.setting.chain().unwrap(), orbit.start().unwrap());
    let half = chain.layout().half();
    let run = Run::new(chain, start.clone()).until(periods * 2.0 * PI / orbit.setting.omega()).unwrap();
    let run = run.method(Method::named("aba1064-linear").unwrap());
    let end = run.setting(Setting::Steps(100_000)).start().unwrap().complete().unwrap().state;
    [start.as_slice()[..2 * half].to_vec(), end[..2 * half].to_vec()]
}

#[test]
fn a_doubled_branch_begins_as_the_normal_form_of_a_period_doubling_does() {
    // Truth: the normal form x -> -(1 + mu) x + c x^3, mu proportional to the distance beyond the
    // bifurcation. Twice applied it has fixed points with x^2 proportional to mu, and with the
    // multiplier 1 - 4 mu; what is left out is of the relative order of the distance.
    let main = branch(&shaken(), 2.0, 0.1);
    let birth = number(&main, BifurcationKind::PeriodDoubling);
    let doubled = followed(main.switched(birth).unwrap());
    let shooting = DrivenShooting::default();
    let crossing = main.bifurcations[birth].parameter;
    let distances = [1e-3, 2.5e-4];
    let errors = distances.map(|distance| {
        let orbit = at(&doubled, distance);
        let setting = main.bifurcations[birth].orbit.setting.with(DriveParameter::Amplitude, crossing + distance);
        let once = shooting.solve(&setting, &main.bifurcations[birth].orbit.z).unwrap();
        let mu = -1.0 - once.spectrum(&shooting).unwrap().multipliers[0].re;
        let largest = orbit.spectrum(&shooting).unwrap().multipliers[0].re;
        ((1.0 - largest) / (4.0 * mu) - 1.0, apart(&orbit.z, &once.z) / distance.sqrt())
    });
    println!("{errors:?}");
    let [(far, wide), (near, narrow)] = errors;
    assert!(near.abs() < 0.01 && (3.5..4.5).contains(&(far / near)), "{errors:?}");
    // Errors of the root in turn are of the order of the root of the distance: the two halves of an
    // orbit differ from the orbit of half the period by more and by less.
    assert!((wide / narrow - 1.0).abs() < 0.1, "{errors:?}");
}

#[test]
fn orbits_of_doubled_period_return_after_two_periods_by_another_method_and_not_after_one() {
    let main = branch(&shaken(), 2.0, 0.1);
    let doubled = followed(main.switched(number(&main, BifurcationKind::PeriodDoubling)).unwrap());
    assert_eq!((doubled.ended(), doubled.unresolved), (End::Reached, 0));
    let kinds: Vec<BifurcationKind> = doubled.bifurcations.iter().map(|one| one.kind).collect();
    assert_eq!(kinds, [BifurcationKind::Fold, BifurcationKind::Fold, BifurcationKind::PeriodDoubling]);
    for point in doubled.points[1..].iter().step_by(6) {
        assert_eq!((point.orbit.setting.turns(), point.measures.least_turns), (2, 2));
        let [start, end] = after(&point.orbit, 2.0);
        let [_, middle] = after(&point.orbit, 1.0);
        println!("{} {:e} {:e}", amplitude(&point.orbit), apart(&start, &end), apart(&start, &middle));
        assert!(apart(&start, &end) < 1e-9 && apart(&start, &middle) > 1e-2);
    }
}

#[test]
fn a_run_settles_onto_the_orbit_of_doubled_period_where_that_is_stable() {
    // Truth: a run from beside the unstable orbit of half the period.
    let main = branch(&shaken(), 2.0, 0.1);
    let birth = number(&main, BifurcationKind::PeriodDoubling);
    let doubled = followed(main.switched(birth).unwrap());
    let point = doubled.points.iter().find(|point| point.spectrum.largest() < 0.8).unwrap();
    assert!(point.stable());
    let orbit = &point.orbit;
    let chain = orbit.setting.chain().unwrap();
    let mut state = main.bifurcations[birth].orbit.start().unwrap().as_slice().to_vec();
    state[0] += 1e-3;
    let flow = |y: &[f64], period: f64| Variations::flow(&chain, y, (0.0, period), &[], 1e-14).unwrap().state;
    for _ in 0..200 {
        state = flow(&state, orbit.setting.period());
    }
    let later = flow(&state, 0.5 * orbit.setting.period());
    // Which half of the orbit a run is in depends on where it began.
    let start = orbit.start().unwrap();
    let off = [&state, &later].map(|state| apart(&state[..2], &start.as_slice()[..2]));
    println!("{off:?}");
    assert!(off[0].min(off[1]) < 1e-9 && off[0].max(off[1]) > 1e-2, "{off:?}");
}

#[test]
fn at_a_branch_point_the_symmetry_is_broken_as_by_a_pitchfork() {
    // Truth: the normal form x -> (1 + mu) x - x^3 has fixed points with the multiplier 1 - 2 mu.
    // The mirror image of an orbit, half a period later, is another one.
    let main = branch(&symmetric(), 2.45, 0.05);
    let birth = number(&main, BifurcationKind::PlusOne);
    let shooting = DrivenShooting::default();
    let broken = followed(main.switched(birth).unwrap());
    let ratio = |distance: f64| {
        let one = at(&broken, distance);
        let setting = one.setting.clone();
        let symmetric = shooting.solve(&setting, &main.bifurcations[birth].orbit.z).unwrap();
        let mu = symmetric.spectrum(&shooting).unwrap().multipliers[0].re - 1.0;
        (1.0 - one.spectrum(&shooting).unwrap().multipliers[0].re) / (2.0 * mu) - 1.0
    };
    let errors = [2e-3, 5e-4].map(ratio);
    println!("{errors:?}");
    assert!(errors[1].abs() < 0.05 && (3.0..5.0).contains(&(errors[0] / errors[1])), "{errors:?}");
    let orbit = &broken.points.last().unwrap().orbit;
    let [start, end] = after(orbit, 1.0);
    let [_, middle] = after(orbit, 0.5);
    let mirrored: Vec<f64> = middle.iter().map(|q| -q).collect();
    assert!(apart(&start, &end) < 1e-9 && apart(&start, &mirrored) > 1e-2);
}

#[test]
fn a_branch_of_doubled_period_ends_where_it_comes_back() {
    // Truth: beyond the crossing a branch has the same orbits again, begun at the other half.
    let main = branch(&shaken(), 2.0, 0.1);
    let birth = number(&main, BifurcationKind::PeriodDoubling);
    let mut trail = main.switched(birth).unwrap();
    trail.continuation.most_points = 4;
    trail.extend(|_| {}).unwrap();
    // Turned round, the branch goes back through the crossing.
    trail.orbits.reverse();
    trail.orbits.pop();
    trail.continuation.most_points = 50;
    assert_eq!(trail.extend(|_| {}).unwrap(), End::Rejoined);
    let crossing = main.bifurcations[birth].parameter;
    let last = amplitude(trail.orbits.last().unwrap()) - crossing;
    assert!(last > 0.0 && last < 1.2e-3, "{last:e}");
}

#[test]
fn where_no_periodic_branch_crosses_there_is_nothing_to_switch_to() {
    let main = branch(&shaken(), 2.0, 0.1);
    let doubled = followed(main.switched(number(&main, BifurcationKind::PeriodDoubling)).unwrap());
    let refused = |k: usize| doubled.switched(k).unwrap_err().to_string();
    assert!(refused(0).contains("switch = 1, a fold"), "{}", refused(0));
    assert!(refused(3).contains("switch = 4 of 3"), "{}", refused(3));
    assert_eq!(doubled.switched(2).unwrap().orbits[0].setting.turns(), 4);
}

// Truth: the search over all points at once.
#[test]
fn bifurcations_of_driven_branches_in_segments_are_those_of_the_whole_branch() {
    let parameter = DriveParameter::Amplitude;
    let scene = include_str!("../reference/pushed-bead.toml").to_owned();
    let command = DrivenContinue {
        driven: Driven { scene, ..Driven::default() },
        vary: parameter,
        branch: BranchOptions { to: Some(2.0), step: Some(0.1), ..BranchOptions::default() },
        more: BifurcationOptions { switch: Some(1), ..BifurcationOptions::default() },
    };
    let found = command.follow().unwrap()(&Engine::threads(), &|_, _| {}).unwrap();
    let switched = found.switched.unwrap().1.unwrap();
    for (divided, count) in [(found.branch, 1), (switched, 3)] {
        let whole = divided.clone().analysed();
        assert_eq!(whole.bifurcations.len(), count);
        same(&whole, &divided);
    }
}

/// Holds the points and bifurcations of a branch in segments against those of the whole branch.
fn same<P: Problem>(whole: &Branch<P>, divided: &Branch<P>) {
    assert_eq!((whole.end, whole.unresolved), (divided.end, divided.unresolved));
    assert_eq!(format!("{:?}", whole.bifurcations), format!("{:?}", divided.bifurcations));
    assert_eq!(whole.points.len(), divided.points.len());
    for (one, other) in whole.points.iter().zip(&divided.points) {
        assert_eq!(format!("{:?} {:?}", one.orbit, one.measures), format!("{:?} {:?}", other.orbit, other.measures));
        let spectra = [one, other].map(|point| serde_json::to_string(&point.spectrum).unwrap());
        assert_eq!(spectra[0], spectra[1]);
    }
}

// Truth: the search over all points at once.
#[test]
fn bifurcations_of_modes_in_segments_are_those_of_the_whole_branch() {
    for (scene, mode, to, step, switch) in
        [(include_str!("../reference/two-beads.toml"), 2, 0.32, 0.02, Some(1)), ("defect", 21, 0.5, 0.05, None)]
    {
        let modes = NormalModes::new(Scene::load(scene).unwrap().chain()).unwrap();
        let whole = ModeContinuation { mode: mode - 1, to, step, most_points: 200 };
        let whole = followed(whole.begin(&modes).unwrap());
        let crossed = switch.map(|number| followed(whole.switched(number - 1).unwrap()));
        let command = FollowMode {
            scene: scene.to_owned(),
            linear_mode: Some(mode),
            branch: BranchOptions { to: Some(to), step: Some(step), ..BranchOptions::default() },
            more: BifurcationOptions { switch, bifurcations: Some(true) },
            ..FollowMode::default()
        };
        let found = command.follow().unwrap()(&Engine::threads(), &|_, _| {}).unwrap();
        assert!(!whole.bifurcations.is_empty());
        let switched = found.switched.map(|(_, branch)| branch.unwrap());
        for (whole, divided) in std::iter::once((whole, found.branch)).chain(crossed.into_iter().zip(switched)) {
            same(&whole, &divided);
        }
    }
}

/// The antiphase mode of two beads between walls, as in the test against Hill's equation.
fn antiphase() -> (Chain<f64>, NormalModes, ModeBranch) {
    let chain = Scene::load(include_str!("../reference/two-beads.toml")).unwrap().chain().clone();
    let modes = NormalModes::new(&chain).unwrap();
    let way = ModeContinuation { mode: 1, to: 0.32, step: 0.02, most_points: 200 };
    let branch = followed(way.begin(&modes).unwrap());
    (chain, modes, branch)
}

#[test]
fn modes_of_doubled_period_begin_as_a_hamiltonian_pitchfork_does() {
    // Truth: at fixed energy the map over two periods has a fixed point with tau - 1 = mu that
    // loses its stability to two with tau - 1 = -2 mu, as the minima of -mu x^2/2 + x^4/4 have it.
    let (_, modes, main) = antiphase();
    let birth = &main.bifurcations[0];
    let (a, energy) = (birth.orbit.amplitude, main.continuation.measures(&modes, &birth.orbit).unwrap().energy);
    // Two orbits of the mode beside the crossing. Over two periods tau becomes 2 tau^2 - 1, which
    // changes by -4 times as much where tau is -1.
    let way = ModeContinuation { mode: 1, step: a - 1e-4, to: a + 1e-4, most_points: 2 };
    let beside = followed(way.begin(&modes).unwrap()).points;
    let free =
        |point: &Point<ModeContinuation>| point.spectrum.tau.iter().map(|tau| tau.re).fold(f64::INFINITY, f64::min);
    let slope = -4.0 * (free(&beside[1]) - free(&beside[0])) / (beside[1].measures.energy - beside[0].measures.energy);
    let doubled = followed(main.switched(0).unwrap());
    let errors = [1, 2].map(|k| {
        let point = &doubled.points[k];
        (1.0 - free(point)) / (2.0 * slope * (point.measures.energy - energy)) - 1.0
    });
    println!("{errors:?}");
    // The slope is that of a chord 1e-3 as long as the amplitude.
    assert!(errors.iter().all(|error| error.abs() < 1e-3), "{errors:?}");
}

#[test]
fn modes_of_doubled_period_come_back_after_two_periods_and_not_after_one() {
    let (chain, modes, main) = antiphase();
    for k in 0..2 {
        let doubled = followed(main.switched(k).unwrap());
        println!("{:?}, {} points", doubled.ended(), doubled.points.len());
        assert!(doubled.ended().is_complete() && doubled.points.len() > 3);
        let crossing = main.bifurcations[k].orbit.omega;
        assert!((2.0 * doubled.points[0].orbit.omega / crossing - 1.0).abs() < 1e-15);
        for point in doubled.points[1..].iter().step_by(4) {
            let start = modes.state(&point.orbit);
            let [end, middle] = [2.0, 1.0].map(|k| at_end(&chain, &start, k * PI / point.orbit.omega, 1e-13));
            let start = start.as_slice();
            println!("{} {:e} {:e}", point.orbit.amplitude, apart(start, &end), apart(start, &middle));
            assert!(apart(start, &end) < 1e-10 && apart(start, &middle) > 1e-3);
        }
    }
}
