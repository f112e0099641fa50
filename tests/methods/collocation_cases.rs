//! Contact collocation in hard cases (ties, grazing, very short contacts, starts on the surface,
//! contacts that never open, chains at rest) and in cases with a closed form.

use crate::{
    common::{collocated, distance, largest, truth},
    numbers::error,
    windows,
};
use hertzchain::{
    chain::{Boundary, Chain, Params, Site, State},
    integrators::{Stepper, collocation::StepControl},
};

pub(crate) fn chain(alpha: f64, (kappa, rho): (f64, f64), boundary: Boundary, sites: usize) -> Chain<f64> {
    Chain::new(Params::new(alpha, kappa, rho).unwrap(), boundary, sites).unwrap()
}

/// A plain free chain.
fn plain(alpha: f64, sites: usize) -> Chain<f64> {
    chain(alpha, (0.0, 0.0), Boundary::Free, sites)
}

/// The state with the given displacements and velocities of beads. Resonators have the
/// displacements of their beads and rest.
pub(crate) fn state(chain: &Chain<f64>, u: &[f64], u_dot: &[f64]) -> Vec<f64> {
    let site = |n| Site { u: u[n], v: u[n], u_dot: u_dot[n], v_dot: 0.0 };
    State::from_fn(chain, site).unwrap().as_slice().to_vec()
}

/// A chain, its initial state, and the end time.
type Motion<'a> = (&'a Chain<f64>, &'a [f64], f64);

/// Compares runs at three tolerances with a reference; the error may be `most` times the tolerance.
fn tolerances_are_kept(name: &str, (chain, y0, end): Motion, reference: &[f64], most: f64) {
    for tol in [1e-6, 1e-9, 1e-12] {
        let (y, stats) = collocated(chain, y0, end, StepControl::Tolerance(tol));
        let error = error(&y, reference);
        println!("{name}, tol {tol:e}: {error:.1e}, {:.3} of it, {} windows", error / tol, stats.steps);
        assert!(error < most * tol, "{name}, tol {tol:e}: {error:e}");
    }
}

/// Compares a run in `count` equal windows of 12 nodes with a reference.
fn windows_resolve(name: &str, (chain, y0, end): Motion, reference: &[f64], (count, bound): (u64, f64)) {
    let (y, _) = collocated(chain, y0, end, windows(count, 12));
    let error = error(&y, reference);
    println!("{name}, {count} windows: {error:.1e} ({bound:.1e})");
    assert!(error < bound, "{name}, {count} windows: {error:e}");
}

fn agree(name: &str, motion: Motion, reference: &[f64], most: f64, windows: (u64, f64)) {
    tolerances_are_kept(name, motion, reference, most);
    windows_resolve(name, motion, reference, windows);
}

#[test]
fn ties() {
    // Truth: the regularised run, which keeps ties exactly, and the mirror image. Measured: 0.1 of
    // the tolerance, 9e-14 with alpha = 1.2, otherwise 1.1e-14.
    let hit_from_both_sides = |alpha| (plain(alpha, 3), vec![-0.5, 0.0, 0.5, 0.8, 0.0, -0.8], 4.0);
    let ring = chain(1.5, (0.0, 0.0), Boundary::Ring, 6);
    let alternate = state(&ring, &[-0.1, 0.1, -0.1, 0.1, -0.1, 0.1], &[0.5, -0.5, 0.5, -0.5, 0.5, -0.5]);
    let resonant = chain(1.5, (1.0, 1.0 / 3.0), Boundary::Free, 5);
    let inwards = state(&resonant, &[-0.8, -0.4, 0.0, 0.4, 0.8], &[1.0, 0.5, 0.0, -0.5, -1.0]);
    let walls = chain(1.5, (1.0, 1.0), Boundary::Fixed, 2);
    let outwards = state(&walls, &[0.2, -0.2], &[-1.0, 1.0]);
    let cases = [
        ("three beads, alpha 1.2", hit_from_both_sides(1.2), 2e-13),
        ("three beads, alpha 1.5", hit_from_both_sides(1.5), 2.5e-14),
        ("three beads, alpha 2", hit_from_both_sides(2.0), 2.5e-14),
        ("six on a ring", (ring, alternate, 6.0), 2.5e-14),
        ("five, resonant", (resonant, inwards, 6.0), 2.5e-14),
        ("two and their walls", (walls, outwards, 10.0), 2.5e-14),
    ];
    for (name, (chain, y0, end), bound) in &cases {
        let reference = truth(chain, y0, *end, 1e-15);
        agree(name, (chain, y0, *end), &reference, 0.3, (100, *bound));
        let (y, _) = collocated(chain, y0, *end, windows(100, 12));
        let u = chain.layout().u(&y);
        let skew = largest(u.iter().zip(u.iter().rev()).map(|(a, b)| a + b));
        assert!(skew < 4.5e-16, "{name}: {skew:e}");
        let drift = (chain.energy(&y).total() / chain.energy(y0).total() - 1.0).abs();
        assert!(drift < 3.5e-15, "{name}: {drift:e}");
    }
}

#[test]
fn ties_broken_by_a_rounding() {
    // Truth: the regularised run. Measured: 1.4 of the tolerance, 3.8e-14.
    let chain = plain(1.5, 3);
    for shift in [1e-15, 1e-12, 1e-9, 1e-7, 1e-5, 1e-3] {
        let y0 = [-0.5, 0.0, 0.5 + shift, 0.8, 0.0, -0.8];
        let reference = truth(&chain, &y0, 4.0, 1e-15);
        agree(&format!("shift {shift:e}"), (&chain, &y0, 4.0), &reference, 4.0, (100, 7.6e-14));
    }
}

/// Two resonant beads whose overlap, without a contact force, is `(1 + excess) sin(omega t) - 1`.
fn grazing(alpha: f64, excess: f64) -> (Chain<f64>, Vec<f64>) {
    let chain = chain(alpha, (1.0, 1.0), Boundary::Free, 2);
    let speed = 0.5 * (1.0 + excess) * chain.params().omega();
    let y0 = vec![-0.5, 0.5, -0.5, 0.5, speed, -speed, -speed, speed];
    (chain, y0)
}

#[test]
fn short_contacts_are_found_in_few_sweeps() {
    // Onset and release lie within one window, where a chord of the overlap differs much from its
    // tangent. Newton's method with the slope of a chord oscillates. Measured: 9, 7, 7, 3
    // sweeps.
    for excess in [1e-2, 1e-3, 1e-4, 1e-5] {
        let (chain, y0) = grazing(1.5, excess);
        let most = (5..25).map(|count| {
            let (_, stats) = collocated(&chain, &y0, 2.0, windows(count, 12));
            assert_eq!(stats.rejected, 0, "{count} windows");
            stats.force_evaluations / 12
        });
        let most = most.max().unwrap();
        assert!(most <= 9, "excess {excess:e}: {most} sweeps");
    }
}

#[test]
fn contacts_that_graze_pass_on_the_impulse_of_a_parabola() {
    // Truth: the force of g = e - c t^2/2, c = (1 + e) omega^2, has the impulse
    // `e^{alpha+1/2} sqrt(2/c) int_{-1}^1 (1 - x^2)^alpha dx`, up to a relative error measured to
    // be 1.2 e. The impulse stays with the centres of mass.
    let third = 1.0 / 3.0;
    for (alpha, integral) in [(1.0, 4.0 * third), (1.5, 0.375 * std::f64::consts::PI), (2.0, 3.2 * third)] {
        for excess in [1e-2, 1e-4, 1e-6, 1e-10, 0.0, -1e-10, -1e-6] {
            let (chain, y0) = grazing(alpha, excess);
            let omega = chain.params().omega();
            let touches = excess > 0.0;
            let height = if touches { excess } else { 0.0 };
            let expected = height.powf(alpha + 0.5) * (2.0 / (1.0 + excess)).sqrt() / omega * integral;
            for control in
                [windows(7, 12), windows(50, 12), StepControl::Tolerance(1e-6), StepControl::Tolerance(1e-13)]
            {
                let (y, _) = collocated(&chain, &y0, 2.0 * std::f64::consts::PI / omega, control);
                let impulse = y[5] + y[7];
                assert!(touches || impulse == 0.0, "alpha {alpha}, excess {excess:e}, {control:?}: {impulse:e}");
                // A tolerance allows impulses far below it to be left out, and velocities are
                // rounded.
                let unasked = if let StepControl::Tolerance(tol) = control { 1e-8 * tol } else { 0.0 };
                let error = (impulse - expected).abs();
                println!("alpha {alpha}, excess {excess:e}, {control:?}: {expected:e}, off by {error:.1e}");
                let bound = 2.4 * height * expected + unasked + f64::EPSILON;
                assert!(error < bound, "alpha {alpha}, excess {excess:e}, {control:?}: {error:e}");
            }
        }
    }
}

#[test]
fn contacts_that_graze_agree() {
    // Truth: the regularised run. Measured: 0.2 of the tolerance, 1.8e-13 with alpha = 1, else
    // 1.5e-14.
    for (alpha, bound) in [(1.0, 4e-13), (1.5, 3e-14), (3.0, 3e-14)] {
        for excess in [1e-2, 1e-6, 1e-10, 0.0, -1e-10, -1e-6] {
            let (chain, y0) = grazing(alpha, excess);
            let reference = truth(&chain, &y0, 10.0, 1e-15);
            agree(&format!("alpha {alpha}, excess {excess:e}"), (&chain, &y0, 10.0), &reference, 0.6, (40, bound));
        }
    }
}

#[test]
fn contacts_that_nearly_open_or_do_for_a_moment() {
    // One bead between walls, each pressed by `delta`. It leaves a wall if
    // `v^2/2 + 2 delta^{5/2}/(5/2) > (2 delta)^{5/2}/(5/2)`; its speed differs from the critical
    // one by the given share. Truth: the regularised run. An overlap with its minimum just above
    // zero has a force like |t|^3 without an event: equal windows have only order four there.
    let delta = 0.3f64;
    let chain = chain(1.5, (0.0, 0.0), Boundary::Fixed, 1).precompressed(delta).unwrap();
    let critical = (2.0 / 2.5 * ((2.0 * delta).powf(2.5) - 2.0 * delta.powf(2.5))).sqrt();
    for (share, bound) in
        [(-1e-3, 1e-13), (-1e-6, 2e-10), (-1e-10, 2e-10), (0.0, 2e-10), (1e-10, 5e-14), (1e-6, 8e-13), (1e-3, 1.3e-13)]
    {
        let y0 = [0.0, critical * (1.0 + share)];
        let reference = truth(&chain, &y0, 20.0, 1e-15);
        agree(&format!("share {share:e}"), (&chain, &y0, 20.0), &reference, 10.0, (200, bound));
    }
}

#[test]
fn a_contact_with_a_small_exponent_keeps_its_tolerance() {
    // Truth: the regularised run. With the last terms of analytic forces errors were 5, 11, 6 and 17
    // tolerances at 1e-12; measured: 1.8.
    for (alpha, sites) in [(1.01, 5), (1.05, 12), (1.1, 12), (1.2, 12)] {
        let (chain, mut y0, end) = (plain(alpha, sites), vec![0.0; 2 * sites], if sites == 5 { 4.0 } else { 12.0 });
        y0[sites] = 1.0;
        let reference = truth(&chain, &y0, end, 1e-15);
        tolerances_are_kept(&format!("alpha {alpha}"), (&chain, &y0, end), &reference, 3.0);
    }
}

/// `alpha`, and the contact time of two plain beads that meet with relative speed `w`:
/// `2 (g/w) int_0^1 ds/sqrt(1 - s^{alpha+1})` with the largest overlap
/// `g = (w^2 (alpha+1)/4)^{1/(alpha+1)}`; integrals by the gamma function.
fn durations(w: f64) -> [(f64, f64); 6] {
    [
        (1.0, std::f64::consts::FRAC_PI_2),
        (1.2, 1.526_424_067_651_674_6),
        (1.5, 1.471_637_592_162_352_3),
        (2.0, 1.402_182_105_325_454_3),
        (3.0, 1.311_028_777_146_059_9),
        (5.0, 1.214_325_323_943_790_8),
    ]
    .map(|(alpha, integral)| (alpha, 2.0 * (w * w * (alpha + 1.0) / 4.0).powf(1.0 / (alpha + 1.0)) / w * integral))
}

#[test]
fn two_beads_swap_velocities_after_the_time_of_the_closed_form() {
    // The first bead flies at the second, which rests. The centre of mass moves on and the relative
    // velocity is reversed: restitution one. Measured: 0.06 of the tolerance, 2.5e-15; events to
    // 4.4e-16, energy to 2.9e-14.
    let (w, end) = (0.7, 9.0);
    for (alpha, duration) in durations(w) {
        let chain = plain(alpha, 2);
        let onset = 0.5 / w;
        let y0 = [-0.5, 0.0, w, 0.0];
        // At the release both beads are at the same place.
        let meeting = 0.5 * w * duration;
        let reference = [meeting, meeting + w * (end - onset - duration), 0.0, w];
        agree(&format!("alpha {alpha}"), (&chain, &y0, end), &reference, 0.2, (30, 5e-15));

        let mut run = chain.collocation(&y0, (0.0, end), windows(30, 12)).unwrap().logged();
        let (mut onsets, mut releases, mut impulse) = (Vec::new(), Vec::new(), 0.0);
        while !run.done() {
            run.step().unwrap();
            let (begin, pieces) = run.pieces();
            for piece in pieces {
                onsets.extend(piece.onset.map(|(t, _)| begin + t));
                releases.extend(piece.release.map(|(t, _)| begin + t));
                impulse += piece.impulse;
            }
        }
        let ([began], [ended]) = (&onsets[..], &releases[..]) else { panic!("{onsets:?} {releases:?}") };
        let errors = [began - onset, ended - onset - duration, impulse - w];
        assert!(largest(errors) < 1e-15, "alpha {alpha}: {errors:?}");

        let (y, _) = collocated(&chain, &y0, end, windows(30, 12));
        let (momentum, energy) = (chain.momentum(&y) / w - 1.0, chain.energy(&y).total() / (0.5 * w * w) - 1.0);
        assert!(momentum.abs() < 5e-16 && energy.abs() < 6e-14, "{momentum:e} {energy:e}");
    }
}

#[test]
fn samples_next_to_a_release_are_those_of_the_closed_form() {
    // Truth: free motion after the release. At `s` before it the overlap is `w s`, so that its
    // force still has to change the velocities by `w^alpha s^{alpha+1}/(alpha+1)`. Windows for such
    // states end at the release; `orbits an_orbit_has_its_state_..` holds those with many at once.
    let w = 0.7;
    for (alpha, duration) in durations(w).into_iter().skip(1) {
        let (chain, y0, release) = (plain(alpha, 2), [-0.5, 0.0, w, 0.0], 0.5 / w + duration);
        let mut run = chain.collocation(&y0, (0.0, 9.0), StepControl::Tolerance(1e-13)).unwrap();
        let apart = [0.0].into_iter().chain((5..17).map(|k| 10f64.powi(-k)));
        let mut times: Vec<f64> = apart.flat_map(|d| [release - d, release + d]).collect();
        times.sort_by(f64::total_cmp);
        let mut worst = 0.0f64;
        for t in times {
            while run.time() < t {
                run.step().unwrap();
            }
            let mut y = [0.0; 4];
            run.sample(t, &mut y);
            let meeting = 0.5 * w * duration;
            let s = (release - t).max(0.0);
            let v = w.powf(alpha) * s.powf(alpha + 1.0) / (alpha + 1.0);
            let x = v * s / (alpha + 2.0);
            let want = [meeting - x, meeting + w * (t - release) + x, v, w - v];
            let error = distance(&y, &want);
            assert!(error < 2e-15, "alpha {alpha}, {:e} after the release: {error:e}", t - release);
            worst = worst.max(error);
        }
    }
}

#[test]
fn contacts_shorter_than_a_window() {
    // Contacts that last 2.2 to 3 in windows of 60. The windows are shortened until sweeps settle;
    // the error is that of ten nodes for a whole contact. Truth: the regularised run.
    for (alpha, bound) in [(1.0, 6e-12), (1.5, 1.2e-9), (3.0, 2e-9)] {
        let chain = plain(alpha, 2);
        let (y0, end) = ([-10.0, 0.0, 1.0, 0.0], 60.0);
        let reference = truth(&chain, &y0, end, 1e-15);
        windows_resolve(&format!("alpha {alpha}"), (&chain, &y0, end), &reference, (1, bound));
    }
}

#[test]
fn contacts_far_shorter_than_a_window() {
    // Two beads meet after a long free flight. Truth: they swap velocities.
    for alpha in [1.0, 1.5, 3.0] {
        for gap in [30.0, 1000.0] {
            let chain = plain(alpha, 2);
            let y0 = [-gap, 0.0, 1.0, 0.0];
            for control in [StepControl::Tolerance(1e-6), windows(1, 12), windows(10, 12)] {
                let (y, _) = collocated(&chain, &y0, 3.0 * gap, control);
                let off = distance(&y[2..], &[0.0, 1.0]);
                assert!(off < 1e-5, "alpha {alpha}, gap {gap}, {control:?}: {:?}", &y[2..]);
            }
        }
    }
}

#[test]
fn several_contacts_of_one_bond_in_a_window() {
    // Two beads that oscillate at omega = 40 and touch in every period: up to thirteen contacts,
    // each on one or two panels. Truth: the regularised run, with an error of 1.9e-12. In the
    // window from 0.5 to 0.75, of eight, a contact ends and another one begins.
    let chain = chain(1.5, (800.0, 1.0), Boundary::Free, 2);
    let y0 = [-0.01, 0.01, -0.01, 0.01, 0.6, -0.6, -0.6, 0.6];
    let reference = truth(&chain, &y0, 2.0, 1e-15);
    for count in [1, 2, 4, 8, 16, 32, 64] {
        windows_resolve("shaking", (&chain, &y0, 2.0), &reference, (count, 4e-12));
    }
    tolerances_are_kept("shaking", (&chain, &y0, 2.0), &reference, 4.0);
}

#[test]
fn a_contact_that_opens_for_a_moment_is_solved_from_any_state_nearby() {
    // In this window the first contact opens for a sixth of the window, by 6e-5 of an overlap of
    // 5e-3: the predicted gap has another width, and Newton's method for its end starts where the
    // overlap hardly rises. Once it led out of the window and back to its start: with 12 nodes 23
    // of these 400 states then gained 1e-5 of their energy. Truth: 16 windows with 12 nodes.
    let start = [0.6959312, 0.6907767, 0.363553, 0.7262917, 0.6503999, 0.424209];
    let rates = [-0.0597519, -0.0119848, 0.1579327, -0.1364245, 0.2297488, 0.2738515];
    let (chain, end) = (chain(1.5, (1.0, 1.0 / 3.0), Boundary::Free, 3), 0.379_557_54);
    for k in -200..200 {
        let mut y0 = [start, rates].concat();
        y0[7] += 1e-7 * f64::from(k);
        let (want, _) = collocated(&chain, &y0, end, windows(16, 12));
        for (nodes, bound) in [(8, 1.6e-11), (12, 6e-14)] {
            let (y, _) = collocated(&chain, &y0, end, windows(1, nodes));
            let error = distance(&y, &want);
            assert!(error < bound, "{k}, {nodes} nodes: {error:e}");
        }
    }
}

#[test]
fn resonators_much_faster_than_contacts_keep_loose_tolerances() {
    // Truth: the regularised run. There are thousands of windows, and in each the force moves the
    // beads so little that it seems small beside the tolerance even if it is not resolved. Beads
    // that are pressed at first have windows with many turns of the resonators when they meet
    // again; last terms alone passed errors of 15 to 390 tolerances (at kappa = 200: 220) of
    // velocities there. Their errors are in units of a path, since velocities err for its time.
    let slow = |amplitude: f64, kappa: f64, end: f64| {
        let row = chain(1.5, (kappa, 1.0 / 3.0), Boundary::Fixed, 4);
        let shape = |n: usize, phase: f64| (2.4 * n as f64 + phase).cos();
        let stretch = amplitude * (amplitude.sqrt() / kappa).sqrt();
        let site = |n| {
            let u = amplitude * shape(n, 0.0);
            Site { u, v: u - stretch * shape(n, 1.0), u_dot: 0.0, v_dot: 0.0 }
        };
        let y0 = State::from_fn(&row, site).unwrap().as_slice().to_vec();
        (row, y0, end, 1.0)
    };
    let pressed = |kappa: f64| {
        let row = chain(1.5, (kappa, 0.33), Boundary::Free, 4);
        let y0 = state(&row, &[0.0, 0.0072, -0.0018, 0.0055], &[0.0; 4]);
        (row, y0, 20.0, 20.0 * 4e-3)
    };
    let slow = [slow(1.0, 1e4, 9.0), slow(1e-3, 1e4, 50.0), slow(1.0, 1e8, 0.1)];
    for (row, y0, end, size) in slow.into_iter().chain([200.0, 700.0, 3000.0].map(pressed)) {
        let reference = truth(&row, &y0, end, 1e-12);
        let name = format!("kappa = {}, size {size}", row.params().kappa);
        for tol in [1e-3, 1e-4, 1e-5, 1e-6, 1e-8] {
            let (y, stats) = collocated(&row, &y0, end, StepControl::Tolerance(tol));
            let error = error(&y, &reference) / size;
            println!("{name}, tol {tol:e}: {error:.1e}, {} windows", stats.steps);
            assert!(error < tol, "{name}, tol {tol:e}: {error:e}");
        }
    }
}

#[test]
fn starts_on_the_surface() {
    // Truth: the regularised run, or free flight. Measured: 0.15 of the tolerance, but 15.5 times
    // the tolerance for the row with alpha = 0.7, whose force is smooth only to order 8 in any
    // variable; with windows, half of the bounds below.
    for (alpha, bounds) in
        [(0.7, [6e-11, 2.5e-11]), (1.0, [1.2e-15, 1.2e-13]), (1.5, [3.2e-15, 5e-14]), (2.0, [1e-15, 2.5e-14])]
    {
        let pair = plain(alpha, 2);
        for speed in [0.5, -0.5] {
            let y0 = [0.0, 0.0, speed, 0.0];
            let flight = vec![5.0 * speed, 0.0, speed, 0.0];
            let reference = if speed > 0.0 { truth(&pair, &y0, 5.0, 1e-15) } else { flight };
            agree(&format!("alpha {alpha}, speed {speed}"), (&pair, &y0, 5.0), &reference, 0.5, (20, bounds[0]));
        }
        for control in [StepControl::Tolerance(1e-9), windows(20, 12)] {
            assert_eq!(collocated(&pair, &[0.0; 4], 5.0, control).0, [0.0; 4]);
        }
        let row = chain(alpha, (1.0, 1.0 / 3.0), Boundary::Fixed, 6);
        let mut y0 = vec![0.0; 24];
        y0[12] = 1.0;
        let reference = truth(&row, &y0, 12.0, 1e-15);
        let most = if alpha < 1.0 { 31.0 } else { 1.0 };
        agree(&format!("alpha {alpha}, struck row"), (&row, &y0, 12.0), &reference, most, (120, bounds[1]));
    }
}

#[test]
fn starts_right_after_an_onset_keep_the_tolerance() {
    // Truth: the regularised run. The force of the first window is singular at the zero of the
    // overlap before the run. Measured: at most 0.013 of the tolerance; with time as the variable
    // up to 0.31 of it.
    for overlap in [1e-6, 1e-5, 1e-4, 1e-3, 1e-2] {
        let chain = chain(1.5, (1.0, 1.0 / 3.0), Boundary::Free, 4);
        let y0 = state(&chain, &[0.3, 0.1, 0.1 - overlap, -0.2], &[-0.1, 0.2, -0.16, 0.1]);
        let reference = truth(&chain, &y0, 1.0, 1e-15);
        tolerances_are_kept(&format!("overlap {overlap:e}"), (&chain, &y0, 1.0), &reference, 0.03);
    }
}

#[test]
fn contacts_that_never_open_have_the_order_of_gauss_nodes() {
    // Truth: the regularised run. Gauss collocation with M nodes has order 2 M: measured 7.9 and
    // 15.7 for M = 4 and 8.
    for boundary in [Boundary::Fixed, Boundary::Ring] {
        let chain = chain(1.5, (1.0, 0.5), boundary, 6).precompressed(0.3).unwrap();
        let u: Vec<f64> = (0..6).map(|n| 0.05 * (1.7 * n as f64).sin()).collect();
        let y0 = state(&chain, &u, &[0.0; 6]);
        let reference = truth(&chain, &y0, 20.0, 1e-15);
        agree(&format!("{boundary:?}"), (&chain, &y0, 20.0), &reference, 0.03, (40, 3.5e-14));
        for (nodes, counts, least) in [(4, [28, 80], 7.6), (8, [20, 28], 15.2)] {
            let errors = counts.map(|count| error(&collocated(&chain, &y0, 20.0, windows(count, nodes)).0, &reference));
            let slope = (errors[0] / errors[1]).ln() / (counts[1] as f64 / counts[0] as f64).ln();
            assert!(slope > least, "{boundary:?}, {nodes} nodes: {errors:?}, slope {slope}");
        }
    }
}

#[test]
fn free_flight_is_exact_and_takes_few_windows() {
    // Truth: straight lines, and for resonators straight lines of the centres of mass with an
    // oscillation about them.
    let free = plain(1.5, 3);
    let y0 = [-1.0, 0.0, 1.0, -0.3, 0.1, 0.7];
    let flight = [-31.0, 10.0, 71.0, -0.3, 0.1, 0.7];
    let (chain, mut shaken) = grazing(1.5, -0.01);
    (shaken[4], shaken[6]) = (shaken[4] - 1e-3, shaken[6] - 1e-3);
    let t = 1000.0;
    let omega = chain.params().omega();
    let (p, p_dot) = (0.495 * (omega * t).sin(), 0.495 * omega * (omega * t).cos());
    let r = -0.5 - 1e-3 * t;
    let oscillation = [r + p, 0.5 - p, r - p, 0.5 + p, p_dot - 1e-3, -p_dot, -p_dot - 1e-3, p_dot];
    for (name, (chain, y0, end), reference, most, bound) in [
        ("straight", (&free, &y0[..], 100.0), &flight[..], 16, 1e-16),
        ("shaken", (&chain, &shaken[..], t), &oscillation[..], 25, 3e-14),
    ] {
        for control in [StepControl::Tolerance(1e-6), StepControl::Tolerance(1e-12), windows(5, 12)] {
            let (y, stats) = collocated(chain, y0, end, control);
            let error = error(&y, reference);
            println!("{name}, {control:?}: {error:e}, {stats:?}");
            assert!(error < bound && stats.steps < most, "{name}, {control:?}: {error:e}, {stats:?}");
        }
    }
}
