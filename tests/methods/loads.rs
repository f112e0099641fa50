//! Walls, weights and pushes: one wall, gravity, pistons, half-sines, chirps, tables, equilibria.

use crate::numbers::{distance, largest, runge_kutta};
use hertzchain::{
    chain::{
        Boundary, Chain, Course, Details, Dissipation, Drive, DriveKind, Envelope, Kind, Params, Signal, Spline, State,
    },
    run::{Method, Run, Setting},
    scene::Scene,
};
use std::{f64::consts::PI, sync::Arc};

const PLAIN: Params = Params { alpha: 1.5, kappa: 0.0, rho: 0.0 };

fn chain(params: Params, boundary: Boundary, sites: usize, details: &Details) -> Chain<f64> {
    Chain::new(params, boundary, sites).unwrap().with(details).unwrap()
}

fn end(chain: &Chain<f64>, start: &State<f64>, method: Method, end: f64, steps: u64) -> Vec<f64> {
    let setting = if method.adaptive() { Setting::Tolerance(1e-12) } else { Setting::Steps(steps) };
    let run =
        Run::new(chain.clone(), start.clone()).until(end).unwrap().method(method).setting(setting).start().unwrap();
    assert!(run.failure.is_none(), "{}: {:?}", method.name(), run.failure);
    run.state
}

fn methods(chain: &Chain<f64>) -> impl Iterator<Item = Method> + '_ {
    Method::all().into_iter().filter(|method| method.unsupported_reason(chain).is_none())
}

fn signal(course: Course) -> Signal {
    Signal { course: Some(course), ..Signal::new(vec![], Envelope::None) }
}

#[test]
fn a_bead_that_is_held_in_its_neighbour_throws_it_off() {
    // Truth: the energy of the contact, A g^(alpha+1)/(alpha+1) = m v^2/2. Nothing else moves: the
    // held bead alone has to give the unit of tolerances.
    for (overlap, table) in [(0.1, false), (1e-6, false), (0.1, true)] {
        let constant = signal(Course::Table(Arc::new(Spline::new(vec![0.0, 1e9], vec![overlap; 2]).unwrap())));
        let signal = if table { constant } else { Signal::constant(overlap) };
        let held = Drive { site: 0, kind: DriveKind::Displacement, signal };
        let details = Details { mass: vec![1.0, 0.5], drives: vec![held], ..Details::default() };
        let chain = chain(PLAIN, Boundary::Free, 2, &details);
        let speed = (2.0 * overlap.powf(2.5) / 2.5 / 0.5).sqrt();
        let time = 40.0 * overlap / speed;
        // DOP853 has the tolerance for each step, and the unit of the overlap, not of the speed.
        for (method, bound) in [(Method::Collocation, 2e-15), (Method::named("dop853-regularised").unwrap(), 1.2e-10)] {
            let state = end(&chain, &State::rest(&chain).driven(&chain), method, time, 0);
            let off = (state[3] / speed - 1.0).abs();
            println!("{overlap} {table} {}: {off:.1e}", method.name());
            assert!(off < bound, "{overlap} {}: {off:e}", method.name());
        }
    }
}

#[test]
fn a_wall_is_a_mirror() {
    // Truth: the chain and its mirror image, without a wall. The contact of bead 0 with its image
    // overlaps twice as much as that with the wall, so its constant is 2^-alpha. Steps err by some
    // 1e-4 at contacts, the same on both sides; tolerances by 1e-9.
    for (params, n) in [(PLAIN, 3), (Params { alpha: 2.0, kappa: 1.0, rho: 0.5 }, 2)] {
        let mut contact = vec![1.0; 2 * n - 1];
        contact[n - 1] = 2f64.powf(-params.alpha);
        let whole = chain(params, Boundary::Free, 2 * n, &Details { contact, ..Details::default() });
        let right = Chain::new(params, Boundary::LeftWall, n).unwrap();
        let left = Chain::new(params, Boundary::RightWall, n).unwrap();
        let mut start = [State::rest(&right), State::rest(&left), State::rest(&whole)];
        for i in 0..n {
            let (u, u_dot) = (0.1 * (3.0 * i as f64).cos(), -0.5 * (1.0 + i as f64).sin());
            for (k, site, sign) in [(0, i, 1.0), (1, n - 1 - i, -1.0), (2, n + i, 1.0), (2, n - 1 - i, -1.0)] {
                (start[k].u_mut()[site], start[k].u_dot_mut()[site]) = (sign * u, sign * u_dot);
            }
        }
        for method in methods(&whole) {
            let [a, b, both] =
                [(&right, 0), (&left, 1), (&whole, 2)].map(|(c, k)| end(c, &start[k], method, 8.0, 4000));
            let [a, b, both] = [(&right, &a), (&left, &b), (&whole, &both)].map(|(c, y)| c.layout().u(y).to_vec());
            let mirrored: Vec<f64> = b.iter().rev().map(|u| -u).collect();
            assert!(largest(both.iter().copied()) > 0.2);
            assert!(distance(&a, &both[n..]) < 1e-8, "{}: {:e}", method.name(), distance(&a, &both[n..]));
            assert!(distance(&mirrored, &both[n..]) < 1e-8, "{}", method.name());
        }
        for method in methods(&right) {
            let [a, b] =
                [(&right, 0), (&left, 1)].map(|(c, k)| c.layout().u(&end(c, &start[k], method, 8.0, 4000)).to_vec());
            let mirrored: Vec<f64> = b.iter().rev().map(|u| -u).collect();
            assert!(distance(&a, &mirrored) < 1e-10, "{}: {:e}", method.name(), distance(&a, &mirrored));
        }
    }
}

#[test]
fn a_piston_is_a_wall_in_a_moving_frame() {
    // Truth: Galileo. Beads that meet a piston of velocity v move as beads of velocity -v that meet
    // a wall.
    let (v, n, time) = (0.3, 4, 12.0);
    let wall = Chain::new(PLAIN, Boundary::LeftWall, n).unwrap();
    let mut from = State::rest(&wall);
    from.u_dot_mut().fill(-v);
    let drives = |parts: &[f64]| -> Vec<Drive> {
        let of = |&velocity: &f64| Drive {
            site: 0,
            kind: DriveKind::Displacement,
            signal: signal(Course::Steady { velocity }),
        };
        parts.iter().map(of).collect()
    };
    // Also as the sum of two drives of one bead.
    for parts in [&[v][..], &[0.7, v - 0.7]] {
        let piston = chain(PLAIN, Boundary::Free, n + 1, &Details { drives: drives(parts), ..Details::default() });
        for method in methods(&piston) {
            let want = end(&wall, &from, method, time, 6000);
            let got = end(&piston, &State::rest(&piston).driven(&piston), method, time, 6000);
            let moving: Vec<f64> = got[1..=n].iter().map(|u| u - v * time).collect();
            assert!(distance(&moving, &want[..n]) < 1e-8, "{}: {:e}", method.name(), distance(&moving, &want[..n]));
            assert!((got[0] - v * time).abs() < 1e-14);
        }
    }
}

#[test]
fn gravity_is_free_fall_and_a_bead_on_a_wall_oscillates_about_its_overlap() {
    // Truth: a t^2/2, exact for every method; for one bead on a wall, energy less the work of its
    // weight, which is reported as driven.
    let details = Details { gravity: -0.7, mass: vec![1.0, 2.0], overlap: vec![-90.0], ..Details::default() };
    let falling = chain(PLAIN, Boundary::Free, 2, &details);
    let lonely = chain(PLAIN, Boundary::LeftWall, 1, &Details { gravity: -0.7, ..Details::default() });
    for method in methods(&falling) {
        let y = end(&falling, &State::rest(&falling), method, 10.0, 100);
        for i in 0..2 {
            assert!((y[i] + 35.0).abs() < 1e-12 && (y[2 + i] + 7.0).abs() < 1e-12, "{}: {y:?}", method.name());
        }
        let driven = falling.energy(&y).driven;
        assert!((driven - 3.0 * 0.7 * 35.0).abs() < 1e-11, "{}: {driven}", method.name());
        let mut from = State::rest(&lonely);
        from.u_mut()[0] = 1.0;
        let y = end(&lonely, &from, method, 5.0, 2000);
        let energy = lonely.energy(&y);
        assert!((energy.driven + 0.7 * (y[0] - 1.0)).abs() < 1e-9, "{}: {:e}", method.name(), energy.driven);
        let bound = if method.adaptive() { 1e-9 } else { 1e-4 };
        assert!((energy.total() - energy.driven).abs() < bound, "{}: {energy:?}", method.name());
    }
}

#[test]
fn a_piston_that_comes_to_slow_beads_sets_the_size_of_the_motion() {
    // Truth: contact collocation at 1e-12. With the size of the slow beads alone the steps of
    // dop853 underflowed. Measured: 118 and 122 steps, 2.2 tolerances.
    let ramped = Signal { envelope: Envelope::Ramp(1.0), ..signal(Course::Steady { velocity: 0.5 }) };
    let drives = vec![Drive { site: 0, kind: DriveKind::Displacement, signal: ramped }];
    let dissipation = Some(Dissipation { kind: Kind::Dashpot, strength: vec![3.0; 3] });
    let details = Details { drives, dissipation, overlap: vec![-0.1; 3], ..Details::default() };
    let chain = chain(PLAIN, Boundary::RightWall, 3, &details);
    let mut start = State::rest(&chain);
    start.u_dot_mut().copy_from_slice(&[0.0, -3e-5, 3e-5]);
    let want = end(&chain, &start, Method::Collocation, 2.0, 0);
    for name in ["dop853", "dop853-regularised"] {
        let run = Run::new(chain.clone(), start.clone()).until(2.0).unwrap().method(Method::named(name).unwrap());
        let got = run.tolerance(1e-10).unwrap().start().unwrap();
        let (off, steps) = (distance(&got.state[..6], &want[..6]), got.stats.steps);
        assert!(got.failure.is_none() && off < 1e-9 && steps < 150, "{name}: {off:e}, {steps} {:?}", got.failure);
    }
}

/// Overlaps of the bonds that can touch, in the equilibrium.
fn overlaps(chain: &Chain<f64>) -> Vec<f64> {
    chain.overlaps(&chain.equilibrium().unwrap())[chain.touching()].to_vec()
}

#[test]
fn a_column_stands_on_the_weight_above_it() {
    // Truth: overlap_k = (weight above / A_k)^(1/alpha), with every bead, gap and constant of its
    // own; standing on either wall.
    let n = 40;
    let mass: Vec<f64> = (0..n).map(|i| 1.0 + 0.5 * (i as f64).sin()).collect();
    let list = |f: fn(f64) -> f64| -> Vec<f64> { (0..n).map(|k| f(k as f64)).collect() };
    let (contact, alpha) = (list(|k| 2.0 + k.cos()), list(|k| 1.5 + 0.5 * (0.3 * k).sin()));
    let overlap = list(|k| -0.1 * (1.0 + (2.0 * k).sin()));
    for (boundary, gravity) in [(Boundary::RightWall, 0.01), (Boundary::LeftWall, -0.01)] {
        let (mass, contact, alpha, overlap) = (mass.clone(), contact.clone(), alpha.clone(), overlap.clone());
        let details = Details {
            mass: mass.clone(),
            contact: contact.clone(),
            alpha: alpha.clone(),
            overlap,
            gravity,
            ..Details::default()
        };
        let column = chain(PLAIN, boundary, n, &details);
        for (k, overlap) in overlaps(&column).into_iter().enumerate() {
            let above: f64 = if gravity > 0.0 { mass[..=k].iter().sum() } else { mass[k..].iter().sum() };
            let want = (0.01 * above / contact[k]).powf(1.0 / alpha[k]);
            assert!((overlap - want).abs() < 1e-13, "{boundary} {k}: {overlap} for {want}");
        }
        // At rest it stays at rest.
        let start = State::equilibrium(&column).unwrap();
        for name in ["collocation", "strang-linear"] {
            let y = end(&column, &start, Method::named(name).unwrap(), 10.0, 2000);
            let moved = distance(&y[..2 * n], &start.as_slice()[..2 * n]);
            assert!(moved < 1e-12, "{boundary} {name}: {moved:e}");
        }
    }
}

#[test]
fn between_two_walls_forces_balance_and_overlaps_fill_the_room() {
    // Truth: the two conditions themselves: f_k + F_k = f_{k+1}, and the sum of overlaps is that of
    // the static ones. With more room than the load closes the upper wall is left.
    for (rest, closed) in [(0.1, true), (0.0, false), (-0.01, false), (-1.0, false)] {
        let push = Drive { site: 2, kind: DriveKind::Force, signal: Signal::constant(-0.02) };
        let details = Details { gravity: 0.01, overlap: vec![rest; 8], drives: vec![push], ..Details::default() };
        let chain = chain(PLAIN, Boundary::Fixed, 7, &details);
        let all = overlaps(&chain);
        let force: Vec<f64> = all.iter().map(|g| g.max(0.0).powf(1.5)).collect();
        for k in 0..7 {
            let load = 0.01 - if k == 2 { 0.02 } else { 0.0 };
            assert!((force[k] + load - force[k + 1]).abs() < 1e-14, "{rest} {k}: {force:?}");
        }
        assert!((all.iter().sum::<f64>() - 8.0 * rest).abs() < 1e-13, "{rest}: {all:?}");
        assert_eq!(all.iter().all(|g| *g > 0.0), closed, "{rest}: {all:?}");
    }
}

#[test]
fn a_ring_a_moved_bead_and_an_unloaded_chain_have_equilibria_too() {
    let push = |site, force| Drive { site, kind: DriveKind::Force, signal: Signal::constant(force) };
    // Truth: balance on a ring, whose centre of mass stays.
    let details = Details { overlap: vec![0.2; 6], drives: vec![push(1, 0.1), push(4, -0.1)], ..Details::default() };
    let ring = chain(PLAIN, Boundary::Ring, 6, &details);
    let (u, all) = (ring.equilibrium().unwrap(), overlaps(&ring));
    let force: Vec<f64> = all.iter().map(|g| g.powf(1.5)).collect();
    for k in 0..6 {
        let load = [0.0, 0.1, 0.0, 0.0, -0.1, 0.0][k];
        assert!((force[k] + load - force[(k + 1) % 6]).abs() < 1e-15, "{force:?}");
    }
    assert!(u.iter().sum::<f64>().abs() < 1e-15 && (all.iter().sum::<f64>() - 1.2).abs() < 1e-14);
    // Truth: a bead that is moved holds what presses against it.
    let moved = Drive { site: 1, kind: DriveKind::Displacement, signal: Signal::constant(0.05) };
    let held = chain(PLAIN, Boundary::Free, 3, &Details { drives: vec![moved, push(0, 0.008)], ..Details::default() });
    let u = held.equilibrium().unwrap();
    assert!((u[0] - 0.05 - 0.008f64.powf(2.0 / 3.0)).abs() < 1e-15 && u[1..] == [0.05, 0.05], "{u:?}");
    // Truth: nothing moves without loads, whatever the gaps are.
    for boundary in [Boundary::Free, Boundary::Fixed, Boundary::Ring, Boundary::LeftWall, Boundary::RightWall] {
        let apart = Chain::new(PLAIN, boundary, 3).unwrap();
        let overlap = [-0.1, -0.2, 0.0, -0.3][..apart.touching().len()].to_vec();
        let u = apart.with(&Details { overlap, ..Details::default() }).unwrap().equilibrium().unwrap();
        assert!(u.iter().all(|u| u.abs() < 1e-16), "{boundary}: {u:?}");
    }
}

#[test]
fn a_load_that_nothing_holds_is_refused_with_its_beads() {
    let push = |site, force| Drive { site, kind: DriveKind::Force, signal: Signal::constant(force) };
    let refused = |boundary, gravity, drives| {
        let details = Details { gravity, drives, ..Details::default() };
        chain(PLAIN, boundary, 4, &details).equilibrium().unwrap_err().to_string()
    };
    for (boundary, gravity, drives, words) in [
        (Boundary::LeftWall, 0.5, vec![], "load = 2e0 on beads 0 to 3"),
        (Boundary::RightWall, -0.5, vec![], "load = -2e0 on beads 0 to 3"),
        (Boundary::Free, 0.5, vec![], "load = 2e0 on beads 0 to 3"),
        (Boundary::Ring, 0.5, vec![], "on a ring nothing holds"),
        (Boundary::LeftWall, -0.5, vec![push(3, 0.75)], "load = 2.5e-1 on bead 3"),
        (Boundary::RightWall, 0.5, vec![push(0, -0.75)], "load = -2.5e-1 on bead 0"),
    ] {
        let message = refused(boundary, gravity, drives);
        assert!(message.contains(words), "{boundary}: {message}");
    }
}

#[test]
fn resonators_hang_in_gravity() {
    // Truth: Newton's equations with a weight on each bead and on each resonator, whose place is
    // counted from where its spring is relaxed, by the classical method of Runge and Kutta. A run
    // counts from where it hangs, rho m a/kappa below.
    let (gravity, mass, kappa, rho) = (0.3, [1.0, 2.0], [1.0, 0.5], [0.5, 1.5]);
    let own = Details { mass: mass.to_vec(), kappa: kappa.to_vec(), rho: rho.to_vec(), gravity, ..Details::default() };
    let column = chain(PLAIN, Boundary::RightWall, 2, &own);
    let hangs = |i: usize| rho[i] * mass[i] * gravity / kappa[i];
    let field = |_: f64, y: &[f64]| {
        let [f1, f2] = [y[0] - y[1], y[1]].map(|g: f64| g.max(0.0).powf(1.5));
        let pull = [0, 1].map(|i| kappa[i] * (y[i] - y[2 + i]));
        let bead = |i: usize, force: f64| (force - pull[i]) / mass[i] + gravity;
        let hung = |i: usize| pull[i] / (rho[i] * mass[i]) + gravity;
        vec![y[4], y[5], y[6], y[7], bead(0, -f1), bead(1, f1 - f2), hung(0), hung(1)]
    };
    let end_time = 4.0;
    let mut y = [-0.1, 0.2, 0.1 + hangs(0), -0.2 + hangs(1), 0.3, -0.1, 0.0, 0.2];
    (0..40_000).for_each(|_| runge_kutta(&mut y, end_time / 40_000.0, field));
    (y[2], y[3]) = (y[2] - hangs(0), y[3] - hangs(1));
    let mut start = State::rest(&column);
    start.as_mut_slice()[..8].copy_from_slice(&[-0.1, 0.2, 0.1, -0.2, 0.3, -0.1, 0.0, 0.2]);
    for method in methods(&column) {
        let got = end(&column, &start, method, end_time, 4000);
        let off = distance(&got[..8], &y);
        let energy = column.energy(&got);
        let before = column.energy(start.as_slice());
        let balance = (energy.total() - energy.driven - before.total()).abs();
        println!("{}: {off:e}, {balance:e}", method.name());
        let bound = if method.adaptive() { 1e-8 } else { 1e-4 };
        assert!(off < bound && balance < bound, "{}: {off:e} {balance:e}", method.name());
    }
    // At rest the spring carries the resonator, and contacts all that is above them.
    let rest = State::equilibrium(&column).unwrap();
    let weights = [0, 1].map(|i| (1.0 + rho[i]) * mass[i] * gravity);
    let [above, all] = [weights[0], weights[0] + weights[1]].map(|load| load.powf(2.0 / 3.0));
    let u = rest.u();
    assert!((u[1] - all).abs() < 1e-15 && (u[0] - u[1] - above).abs() < 1e-15, "{u:?}");
    let still = end(&column, &rest, Method::Collocation, 20.0, 0);
    assert!(distance(&still[..4], &rest.as_slice()[..4]) < 1e-12);
}

#[test]
fn a_table_that_begins_with_rest_leaves_the_chain_at_rest_until_then() {
    // Truth: the same push from time 3 as a half-sine, whose values the table has; another method.
    // With splines that fall to 1e-170 before the push DOP853 went on by steps of 1e-8.
    let t: Vec<f64> = (0..=1000).map(|k| 0.01 * f64::from(k)).collect();
    let push = |t: f64| if (3.0..3.5).contains(&t) { 0.1 * (PI * (t - 3.0) / 0.5).sin().powi(4) } else { 0.0 };
    let table = Course::Table(Arc::new(Spline::new(t.clone(), t.iter().map(|&t| push(t)).collect()).unwrap()));
    let drives = vec![Drive { site: 0, kind: DriveKind::Force, signal: signal(table) }];
    let pushed = chain(PLAIN, Boundary::RightWall, 5, &Details { drives, ..Details::default() });
    let start = State::rest(&pushed);
    let run = |method: &str| end(&pushed, &start, Method::named(method).unwrap(), 10.0, 4000);
    let [one, other] = ["collocation", "dop853-regularised"].map(run);
    assert!(largest(one[..5].iter().copied()) > 1e-3 && distance(&one[..10], &other[..10]) < 1e-9);
}

#[test]
fn springs_and_contacts_hold_a_column_together() {
    // Truth: forces balance, k u_n = f_n - f_{n+1} + g, also for a chain that is damped and driven.
    let params = Params { alpha: 1.5, kappa: 1e-3, rho: f64::INFINITY };
    let scene = "name = 'column'\n[chain]\nsites = 50\nalpha = 1.5\nboundary = 'right-wall'\nkappa = 1e-3\n\
                 rho = inf\ngravity = 1e-3\n[beads]\ndrag = 0.1\n[[drive]]\nsite = 0\nkind = 'pushed'\namplitude = 0.1\n\
                 omega = 1.0\n[initial]\nkind = 'equilibrium'\n[span]\nuntil = 1.0\n";
    let scene = Scene::parse(&scene.replace('\'', "\""), "column").unwrap();
    let (u, n) = (&scene.initial().as_slice()[..50], 50);
    let overlaps = scene.chain().overlaps(u);
    let force = |b: usize| overlaps[b].max(0.0).powf(1.5);
    let off = (0..n).map(|i| force(i) - force(i + 1) + 1e-3 - params.kappa * u[i]);
    assert!(largest(off) < 1e-15 && overlaps[n] > 0.01);
}
