//! Contacts of chains: those that a run in small steps shows are found, none is spurious, and their
//! logged data are correct.

use crate::{
    collocation_cases::{chain, state},
    common::{collocated, distance, largest},
    properties::properties,
};
use approx::assert_relative_eq;
use hertzchain::{
    chain::{Boundary, Chain, Contact, ContactLog, Field, Overlaps, Site, State},
    integrators::{
        Dop853, Event, EventFunctions, Regularised, Silent, Stepper, Watch, collocation::StepControl, dop853::Options,
        drive, regularised::common_power,
    },
    run::method::{Method, Setting},
    run::{Records, Run},
    scene::Scene,
};
use proptest::{
    prelude::*,
    test_runner::{TestError, TestRunner},
};
use std::cell::RefCell;

/// A regularised run: the state at its end, its events, and its number of steps.
fn run(chain: &Chain<f64>, y0: &[f64], end: f64, tol: f64) -> (Vec<f64>, Vec<Event<f64>>, u64) {
    let alpha = chain.params().alpha;
    let (field, overlaps) = (Field::new(chain.clone()), Overlaps::new(chain.clone()));
    let mut run =
        Regularised::new(field, overlaps, (alpha, common_power(&[alpha], 8)), y0, (0.0, end), Options::new(tol))
            .unwrap();
    let mut events = Vec::new();
    while !run.done() {
        run.step().unwrap();
        events.extend_from_slice(run.events());
    }
    let mut y = y0.to_vec();
    run.sample(end, &mut y);
    (y, events, run.stats().steps)
}

/// The contacts of a run of DOP853 under [`Watch`].
fn watched(chain: &Chain<f64>, y0: &[f64], end: f64, tol: f64) -> Vec<Contact> {
    let run = Dop853::new(Field::new(chain.clone()), y0, (0.0, end), Options::new(tol)).unwrap();
    let mut watch = Watch::new(run, Overlaps::new(chain.clone()), ContactLog::new(chain.clone()));
    drive(&mut watch, &mut Silent, &mut y0.to_vec()).unwrap();
    watch.into_listener().into_contacts().list()
}

/// The state at the end by DOP853 without treatment of events.
fn plain(chain: &Chain<f64>, y0: &[f64], end: f64) -> Vec<f64> {
    let mut y = y0.to_vec();
    let mut run = Dop853::new(Field::new(chain.clone()), y0, (0.0, end), Options::new(2.5e-15)).unwrap();
    drive(&mut run, &mut Silent, &mut y).unwrap();
    y
}

fn kinds(events: &[Event<f64>]) -> Vec<(usize, bool)> {
    events.iter().map(|event| (event.index, event.rising)).collect()
}

#[test]
fn impulses_add_up_to_the_change_of_momentum() {
    // Truth: u_n'(end) - u_n'(0) = J_n - J_{n+1} on a plain chain, for every bead, by every kind of
    // method.
    let scene = Scene::load("impact").unwrap().until(20.0).unwrap();
    for (name, setting, bound) in [
        ("dop853-regularised", Setting::Tolerance(1e-11), 4e-10),
        // Kicks are samples of the force and give its integral to order two.
        ("strang-linear", Setting::Steps(4000), 1e-5),
        ("verlet", Setting::Steps(4000), 4e-6),
        ("aba1064", Setting::Steps(1000), 5e-9),
    ] {
        let outcome = scene
            .run()
            .method(Method::named(name).unwrap())
            .setting(setting)
            .records(Records::End)
            .contacts()
            .start()
            .unwrap();
        let layout = scene.chain().layout();
        let mut impulses = vec![0.0; layout.sites() + 1];
        for contact in outcome.contacts.unwrap() {
            impulses[contact.bond] += contact.impulse;
        }
        let (before, after) = (layout.u_dot(scene.initial().as_slice()), layout.u_dot(&outcome.state));
        for n in 0..layout.sites() {
            let change = after[n] - before[n];
            assert!((change - (impulses[n] - impulses[n + 1])).abs() < bound, "{name}, bead {n}: {change}");
        }
    }
}

#[test]
fn a_tie_broken_by_a_rounding_costs_no_storm_of_steps() {
    // Two beads hit a third from both sides. Truth: the mirror image, if at once; DOP853.
    let chain = chain(1.5, (0.0, 0.0), Boundary::Free, 3);
    let steps_with = |shift: f64| {
        let y0 = state(&chain, &[-0.5, 0.0, 0.5 + shift], &[0.8, 0.0, -0.8]);
        let (y, events, steps) = run(&chain, &y0, 4.0, 1e-12);
        assert_eq!(events.len(), 4, "shift {shift:e}: {events:?}");
        if shift == 0.0 {
            assert!((events[0].t - 0.625).abs() < 2e-15 && events[1].t == events[0].t);
            assert!(events[3].t == events[2].t && y[1] == 0.0 && y[0] + y[2] == 0.0, "{y:?}");
        }
        assert!(distance(&y, &plain(&chain, &y0, 4.0)) < 4e-11, "shift {shift:e}");
        steps
    };
    let tie = steps_with(0.0);
    for shift in [1e-15, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3] {
        let steps = steps_with(shift);
        assert!(tie < 80 && steps < 2 * tie, "shift {shift:e}: {steps} steps instead of {tie}");
    }
}

#[test]
fn a_contact_that_nearly_opens_opens_only_if_it_has_the_energy() {
    // One bead between walls, each pressed by delta. It leaves a wall if it reaches u = delta, so
    // if v^2/2 + 2 delta^{5/2}/(5/2) > (2 delta)^{5/2}/(5/2).
    let delta = 0.3f64;
    let chain = chain(1.5, (0.0, 0.0), Boundary::Fixed, 1).precompressed(delta).unwrap();
    let critical = (2.0 / 2.5 * ((2.0 * delta).powf(2.5) - 2.0 * delta.powf(2.5))).sqrt();
    let swing = |v: f64| run(&chain, &[0.0, v], 4.0, 1e-13).1;
    for near in [1e-3, 1e-6, 1e-9] {
        assert!(swing(critical * (1.0 - near)).is_empty(), "{near:e}");
        let events = swing(critical * (1.0 + near));
        let turns = kinds(&events);
        assert!(turns.len() >= 2 && turns[..2] == [(0, false), (0, true)], "{near:e}: {events:?}");
        // In the gap only the other wall acts: the gap lasts about 2 v/f, with the speed v at the
        // release and the force f of that wall.
        let left = critical * (2.0 * near).sqrt();
        let force = (2.0 * delta).powf(1.5);
        assert_relative_eq!(events[1].t - events[0].t, 2.0 * left / force, max_relative = 0.5 * near + 4e-6);
    }
}

#[test]
fn a_contact_shorter_than_a_step_is_found() {
    // Stiff contacts between fast beads last 1e-4 of the run. Truth: the beads swap velocities.
    let chain = chain(3.0, (0.0, 0.0), Boundary::Free, 3);
    let y0 = state(&chain, &[-1000.0, 0.0, 1000.0], &[300.0, 0.0, -100.0]);
    for (tol, bound) in [(1e-4, 5e-2), (1e-8, 5e-7), (1e-12, 3e-11)] {
        let (y, events, _) = run(&chain, &y0, 60.0, tol);
        assert_eq!(
            kinds(&events),
            [(0, true), (0, false), (1, true), (1, false), (0, true), (0, false)],
            "tol {tol:e}"
        );
        let speeds = [-100.0, 0.0, 300.0];
        assert!(distance(&y[3..], &speeds) < bound, "tol {tol:e}: {:?}", &y[3..]);
    }
}

#[test]
fn a_start_on_the_surface_at_rest_is_left_by_a_resonator() {
    // The bead leaves the surface like t^3, below the smallest double at first. Truth: collocation.
    let chain = chain(1.854_387_304_186_515_8, (1.0, 170.159_267_162_093_16), Boundary::Fixed, 1);
    let y0 = [0.0, 0.0, 0.0, -0.044_240_388_319_732_35];
    let (y, _, steps) = run(&chain, &y0, 8.0, 1e-13);
    let (reference, _) = collocated(&chain, &y0, 8.0, StepControl::Tolerance(1e-13));
    let error = distance(&y, &reference) / largest(reference.iter().copied());
    assert!(error < 5e-13 && steps < 100, "{error:e}, {steps} steps");
}

#[test]
fn rest_and_permanent_contact_have_no_events_and_take_long_steps() {
    let rest = chain(1.5, (1.0, 0.5), Boundary::Ring, 8);
    let (y, events, steps) = run(&rest, &vec![0.0; 32], 1000.0, 1e-10);
    assert!(events.is_empty() && steps < 30 && y.iter().all(|&y| y == 0.0), "{steps}");
    let pressed = chain(1.5, (0.0, 0.0), Boundary::Fixed, 6).precompressed(0.3).unwrap();
    let u: Vec<f64> = (0..6).map(|n| 0.02 * (n as f64).sin()).collect();
    let y0 = state(&pressed, &u, &[0.0; 6]);
    let (y, events, _) = run(&pressed, &y0, 50.0, 1e-12);
    assert!(events.is_empty());
    assert!(distance(&y, &plain(&pressed, &y0, 50.0)) < 3e-11);
}

#[test]
fn the_tail_of_a_breather_makes_no_events() {
    let scene = Scene::load("trivial-breather").unwrap();
    for name in ["dop853-landed", "dop853-regularised", "strang-linear"] {
        let method = Method::named(name).unwrap();
        let setting = if method.adaptive() { Setting::Tolerance(1e-10) } else { Setting::Steps(1000) };
        let outcome = scene.run().method(method).setting(setting).records(Records::End).contacts().start().unwrap();
        assert_eq!(outcome.contacts, Some(Vec::new()), "{name}");
    }
    // One bead is displaced among forty that just touch. Overlaps fall doubly exponentially: 1e-1,
    // 1e-3, .., 1e-300.
    let cradle = chain(1.5, (1.0, f64::INFINITY), Boundary::Free, 40);
    let u: Vec<f64> = (0..40).map(|n| if n == 20 { 0.1 } else { 0.0 }).collect();
    let y0 = state(&cradle, &u, &[0.0; 40]);
    let (y, events, steps) = run(&cradle, &y0, 20.0, 1e-11);
    let contacts = watched(&cradle, &y0, 20.0, 1e-12);
    assert!(contacts.iter().all(|contact| contact.largest_overlap > 3e-13), "{contacts:?}");
    assert!(events.len() < 110 && steps < 500, "{} events, {steps} steps", events.len());
    assert!(distance(&y, &plain(&cradle, &y0, 20.0)) < 6e-10);
}

/// A bond's overlap changes its sign: the index of the overlap, whether it rises, the time, and the
/// rate of the overlap there.
type Crossing = (usize, bool, f64, f64);

/// The crossings after which `|g|` exceeds `level`, in a run looked at in steps of `1e-3`; times by
/// the chord, so that `g` is within 1e-6 of zero there.
fn brute_force(chain: &Chain<f64>, y0: &[f64], end: f64, level: f64) -> Vec<Crossing> {
    let overlaps = Overlaps::new(chain.clone());
    let mut g = vec![0.0; overlaps.count()];
    let mut y = y0.to_vec();
    let mut run = Dop853::new(Field::new(chain.clone()), y0, (0.0, end), Options::new(1e-13)).unwrap();
    overlaps.values(0.0, y0, &mut g);
    let mut sides: Vec<bool> = g.iter().map(|&g| g > 0.0).collect();
    let mut last = vec![(0.0, 0.0); g.len()];
    let mut before = g.clone();
    let (mut seen, steps) = (Vec::new(), (end / 1e-3) as u64);
    let step = end / steps as f64;
    for k in 1..=steps {
        let t = step * k as f64;
        while run.time() < t {
            run.step().unwrap();
        }
        run.sample(t, &mut y);
        overlaps.values(t, &y, &mut g);
        for i in 0..g.len() {
            if (g[i] > 0.0) != (before[i] > 0.0) {
                let rate = (g[i] - before[i]) / step;
                last[i] = (t - g[i] / rate, rate);
            }
            let far = if sides[i] { g[i] < -level } else { g[i] > level };
            if far {
                sides[i] = !sides[i];
                seen.push((i, sides[i], last[i].0, last[i].1));
            }
        }
        before.copy_from_slice(&g);
    }
    seen
}

/// Onsets (true) and releases by bond and time.
fn turns(contacts: &[Contact]) -> Vec<(usize, bool, f64)> {
    let both = |contact: &Contact| [(true, contact.onset), (false, contact.release)].map(|turn| (contact.bond, turn));
    contacts.iter().flat_map(both).filter_map(|(bond, (rising, t))| Some((bond, rising, t?))).collect()
}

/// Chains of 2 to 5 beads that move at random.
fn moving() -> impl Strategy<Value = (Chain<f64>, State<f64>)> {
    let alpha = prop_oneof![Just(1.2), Just(1.5), Just(2.0), Just(3.0)];
    let springs = prop_oneof![Just((0.0, 0.0)), Just((1.0, 1.0 / 3.0)), Just((1.0, f64::INFINITY)), Just((5.0, 0.05))];
    let boundary = prop_oneof![Just(Boundary::Free), Just(Boundary::Fixed), Just(Boundary::Ring)];
    let beads = prop::collection::vec((-0.2f64..0.2, -1.0f64..1.0), 2..6);
    (alpha, springs, boundary, beads).prop_map(|(alpha, springs, boundary, beads)| {
        let chain = chain(alpha, springs, boundary, beads.len());
        let site = |n: usize| Site { u: beads[n].0, v: beads[n].0, u_dot: beads[n].1, v_dot: 0.0 };
        let state = State::from_fn(&chain, site).unwrap();
        (chain, state)
    })
}

#[test]
fn contacts_of_random_chains_are_where_small_steps_see_them() {
    // Truth: a run looked at in small steps, for all contacts and gaps deeper than 1e-3. A time in
    // a log is off by what the overlap needs to change by the error of the run: a bound for every
    // event, at every tolerance. The chord is off by 1.8e-7. Measured over five seeds, in
    // tolerances: 1153 watched, 102 regularised, 1.4 by collocation.
    let worst = RefCell::new([[0.0_f64; 3]; 3]);
    let outcome = TestRunner::new(properties(64)).run(&moving(), |(chain, state)| {
        let (y0, end) = (state.as_slice(), 6.0);
        let truth = brute_force(&chain, y0, end, 1e-3);
        let overlaps = Overlaps::new(chain.clone());
        for (k, tol) in [1e-5, 1e-8, 1e-11].into_iter().enumerate() {
            let regularised = run(&chain, y0, end, tol).1;
            let collocation = Run::new(chain.clone(), state.clone()).until(end).unwrap().method(Method::Collocation);
            let collocation = collocation.tolerance(tol).unwrap().contacts().start().unwrap().contacts.unwrap();
            let logs = [
                ("watched", turns(&watched(&chain, y0, end, tol))),
                ("regularised", regularised.iter().map(|e| (overlaps.bond(e.index), e.rising, e.t)).collect()),
                ("collocation", turns(&collocation)),
            ];
            for (j, (name, log)) in logs.iter().enumerate() {
                for &(index, rising, t, rate) in &truth {
                    let same = log.iter().filter(|turn| (turn.0, turn.1) == (overlaps.bond(index), rising));
                    let off = same.map(|turn| (turn.2 - t).abs()).fold(f64::INFINITY, f64::min) * rate.abs();
                    let worst = &mut worst.borrow_mut()[j][k];
                    *worst = worst.max(off);
                    let bound = 4e-7 + [2.5e3, 200.0, 3.0][j] * tol;
                    prop_assert!(off < bound, "{name}, tol {tol:e}: {off:e} at t = {t}, overlap {index}: {log:?}");
                }
                // No event is spurious: onsets and releases of a bond alternate.
                for bond in 0..=chain.sites() {
                    let mut turns: Vec<_> = log.iter().filter(|turn| turn.0 == bond).collect();
                    turns.sort_by(|a, b| a.2.total_cmp(&b.2));
                    prop_assert!(turns.windows(2).all(|pair| pair[0].1 != pair[1].1), "{name}, bond {bond}: {turns:?}");
                }
            }
        }
        Ok(())
    });
    println!("off by an overlap of: watched, regularised, collocation at three tolerances {:?}", worst.borrow());
    if let Err(TestError::Fail(why, (chain, state))) = outcome {
        panic!("{why}: {:?} {:?} {:?}", chain.params(), chain.boundary(), state.as_slice());
    }
}
