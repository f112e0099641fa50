//! Crossings of values by functions of the state: their times against closed forms, by every
//! method.

use hertzchain::{
    Boundary, Chain, Method, Params, Run, Setting, State, Trajectory,
    integrators::Event,
    run::{Crossed, Observables},
};
use std::f64::consts::{PI, SQRT_2};

/// A run by every method that can: to a tolerance where it chooses its steps, else with equal
/// steps.
fn by_every_method(run: &Run, tol: f64, steps: u64) -> Vec<(String, Run)> {
    let with = |method: Method| {
        let setting = if method.adaptive() { Setting::Tolerance(tol) } else { Setting::Steps(steps) };
        (method.name(), run.clone().method(method).setting(setting))
    };
    Method::all().into_iter().filter(|method| method.runs(run.chain()).is_ok()).map(with).collect()
}

/// A run that keeps every crossing of functions of the state.
fn kept(run: &Run, functions: impl Fn(&[f64], &mut Vec<f64>) + Send + Sync + 'static) -> Trajectory {
    run.clone().crossings(Observables::new(functions), |_, _| Crossed::Kept).start().unwrap().complete().unwrap()
}

/// A bead on a spring to a fixed mass, `u = sin t`, and a resonator that is not there.
fn oscillator(until: f64) -> Run {
    let chain = Chain::new(Params::new(1.5, 1.0, f64::INFINITY).unwrap(), Boundary::Free, 1).unwrap();
    let mut state = State::rest(&chain);
    state.u_dot_mut()[0] = 1.0;
    Run::new(chain, state).until(until).unwrap()
}

#[test]
fn a_bead_on_a_spring_crosses_values_at_the_times_of_the_sine() {
    // Truth: u = sin t crosses 1/2 at arcsin(1/2) and pi - arcsin(1/2), u' = cos t crosses 0 at
    // pi/2, each modulo the period; and u crosses 0.9999, 0.03 apart, at which a step without parts
    // would see two crossings or none. At the start u is 0: to leave it is no crossing.
    let (values, near) = ([0.5, 0.0, 0.9999], |y: &[f64]| [y[0], y[1], y[0]]);
    let low = |value: f64| value.asin();
    let mut want: Vec<(usize, bool, f64)> = Vec::new();
    for turn in 0..4 {
        let t = 2.0 * PI * f64::from(turn);
        want.extend(
            [0, 2].into_iter().flat_map(|k| [(k, true, t + low(values[k])), (k, false, t + PI - low(values[k]))]),
        );
        want.extend([(1, false, t + 0.5 * PI), (1, true, t + 1.5 * PI)]);
    }
    want.retain(|one| one.2 < 20.0);
    want.sort_by(|a, b| a.2.total_cmp(&b.2));
    for (name, run) in by_every_method(&oscillator(20.0), 1e-13, 4000) {
        // Without contacts the linear flow is exact, also in steps longer than a part.
        let exact = name.ends_with("-linear");
        let run = if exact { run.setting(Setting::Steps(30)) } else { run };
        let functions = move |y: &[f64], to: &mut Vec<f64>| {
            to.extend(near(y).iter().zip(values).map(|(x, value)| x - value));
        };
        let got = kept(&run, functions).crossings;
        assert_eq!(got.len(), want.len(), "{name}");
        let exact = exact || run.choice().unwrap().0.adaptive();
        for (Event { index, rising, t }, &(k, up, at)) in got.iter().zip(&want) {
            // Near its maximum a sine is at a value sqrt(2 (1 - value)) away per unit of error.
            let tolerance = if exact { 1e-11 } else { 5e-5 } / if k == 2 { 0.014 } else { 0.8 };
            assert!((*index, *rising) == (k, up) && (t - at).abs() < tolerance, "{name}: {index} {t} {at}");
        }
    }
}

/// Two beads with a linear contact, the first at speed 1 and a gap of 1 before the second.
fn linear_collision() -> Run {
    let chain = Chain::new(Params::new(1.0, 0.0, 0.0).unwrap(), Boundary::Free, 2).unwrap();
    let mut state = State::rest(&chain);
    state.u_mut()[1] = 1.0;
    state.u_dot_mut()[0] = 1.0;
    Run::new(chain, state).until(5.0).unwrap()
}

#[test]
fn beads_that_collide_cross_positions_velocities_and_overlaps_at_the_times_of_the_closed_form() {
    // Truth: free flight up to t = 1; in contact the overlap is sin(sqrt(2) s)/sqrt(2), s = t - 1,
    // and the second bead has the speed (1 - cos(sqrt(2) s))/2; after s = pi/sqrt(2) the speed 1.
    let functions = |y: &[f64], to: &mut Vec<f64>| to.extend([y[0] - 0.75, y[3] - 0.25, y[0] - y[1] - 0.3, y[1] - 2.5]);
    let s = (0.3 * SQRT_2).asin() / SQRT_2;
    // The center has the speed 1/2: both beads are at (1 + t)/2 where they part.
    let touch = 1.0 + PI / SQRT_2;
    let want = [0.75, 1.0 + PI / (3.0 * SQRT_2), 1.0 + s, touch - s, touch + 2.5 - 0.5 * (1.0 + touch)];
    for (name, run) in by_every_method(&linear_collision(), 1e-13, 4000) {
        let end = kept(&run.contacts(), functions);
        let mut got: Vec<(usize, f64)> = end.crossings.iter().map(|one| (one.index, one.t)).collect();
        got.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        assert_eq!(got.iter().map(|one| one.0).collect::<Vec<_>>(), [0, 1, 2, 2, 3], "{name}");
        let adaptive = name.contains("dop853") || name == "collocation";
        for ((_, t), want) in got.iter().zip(want) {
            assert!((t - want).abs() < if adaptive { 1e-10 } else { 3e-6 }, "{name}: {t} {want}");
        }
        let contact = end.contacts.unwrap()[0];
        assert!((contact.onset.unwrap() - 1.0).abs() < 1e-9, "{name}");
    }
}

#[test]
fn a_run_ends_at_a_crossing_with_the_state_and_the_contacts_up_to_there() {
    // Truth: as above, the overlap 0.3 at s; the impulse is (1 - cos(sqrt(2) s))/2.
    let s = (0.3 * SQRT_2).asin() / SQRT_2;
    for (name, run) in by_every_method(&linear_collision(), 1e-13, 4000) {
        let run = run.contacts().crossings(Observables::new(|y, to| to.push(y[0] - y[1] - 0.3)), |one, y| {
            assert!((y[0] - y[1] - 0.3).abs() < 1e-14 && one.rising);
            Crossed::Ends
        });
        let end = run.start().unwrap().complete().unwrap();
        let off = if name.contains("dop853") || name == "collocation" { 1e-10 } else { 3e-6 };
        assert!((end.t - 1.0 - s).abs() < off && end.crossings.last().unwrap().t == end.t, "{name}: {}", end.t);
        assert!((end.state[0] - end.state[1] - 0.3).abs() < 1e-14 && end.samples.last().unwrap().t <= end.t);
        let contacts = end.contacts.unwrap();
        assert!(contacts.len() == 1 && contacts[0].release.is_none(), "{name}: {contacts:?}");
        let impulse = 0.5 * (1.0 - (SQRT_2 * s).cos());
        // In a step across the onset the overlap is a polynomial through its kink.
        assert!((contacts[0].impulse - impulse).abs() < 3e-8 + 10.0 * off, "{name}: {}", contacts[0].impulse - impulse);
    }
}

#[test]
fn what_is_looked_for_changes_no_bit_of_a_run() {
    let chain = Chain::new(Params::new(1.5, 1.0, 1.0 / 3.0).unwrap(), Boundary::Free, 6).unwrap();
    let mut state = State::rest(&chain);
    state.u_dot_mut()[0] = 1.0;
    let run = Run::new(chain, state).until(9.0).unwrap();
    for (name, run) in by_every_method(&run, 1e-8, 900) {
        let (bare, end) = (run.start().unwrap(), kept(&run, |y, to| to.extend([y[3] - 0.1, y[14]])));
        assert!(bare.state == end.state && bare.stats.steps == end.stats.steps, "{name}");
        assert!(bare.crossings.is_empty() && end.crossings.iter().any(|one| one.index == 0 && one.rising), "{name}");
    }
}

#[test]
fn every_crossing_in_steps_of_a_hundred_periods_is_found() {
    // Truth: u = sin t crosses 0.9999999 twice a period, 9e-4 apart.
    let first = 0.999_999_9f64.asin();
    let want = (0..).flat_map(|k| [first, PI - first].map(|t| t + 2.0 * PI * f64::from(k)));
    let want: Vec<f64> = want.take_while(|t| *t < 2000.0).collect();
    for (name, setting) in [("collocation", Setting::Tolerance(1e-12)), ("strang-linear", Setting::Steps(3))] {
        let run = oscillator(2000.0).method(Method::named(name).unwrap()).setting(setting);
        let end = kept(&run, |y, to| to.push(y[0] - 0.999_999_9));
        assert!(end.stats.steps < 20, "{name}");
        assert_eq!(end.crossings.len(), want.len(), "{name}");
        let off = end.crossings.iter().zip(&want).map(|(one, t)| (one.t - t).abs()).fold(0.0, f64::max);
        assert!(off < 1e-10, "{name}: {off:e}");
    }
}

#[test]
fn motion_that_is_not_smooth_has_no_crossing_before_it() {
    // Truth: the first bead has the speed 1 until it touches the second, and less from then on; the
    // second one never moves back, and has half that speed once.
    let chain = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 2).unwrap();
    let mut state = State::rest(&chain);
    (state.u_mut()[1], state.u_dot_mut()[0]) = (1.0, 1.0);
    let run = Run::new(chain, state).until(6.0).unwrap();
    let (tol, steps) = (Setting::Tolerance(1e-10), Setting::Steps(400));
    for (name, setting) in [("collocation", tol), ("dop853-regularised", tol), ("corrected", steps), ("verlet", steps)]
    {
        let run = run.clone().method(Method::named(name).unwrap()).setting(setting);
        let end = kept(&run, |y, to| to.extend([y[2] - 1.0, y[3], y[3] - 0.5]));
        assert!(end.crossings.len() == 1 && end.crossings[0].index == 2, "{name}: {:?}", end.crossings);
        // The largest speed of the first bead is that of the start.
        let end = run.observables(Observables::new(|y, to| to.push(y[2]))).start().unwrap();
        assert_eq!(end.extremes, [(0.0, 1.0)], "{name}");
    }
}

#[test]
fn a_run_that_goes_on_from_a_crossing_does_not_find_it_again() {
    // Truth: u = sin t rises through 1/2 once a period; at 10^6 a time is known to 1e-10.
    let late = |run: (String, Run)| (run.0, run.1.starting_at(1e6).unwrap().until(1e6 + 50.0).unwrap());
    let all = by_every_method(&oscillator(50.0), 1e-12, 5000);
    let late: Vec<_> = by_every_method(&oscillator(2e6), 1e-12, 5000).into_iter().map(late).collect();
    for (from, (name, run)) in all.into_iter().map(|run| (0.0, run)).chain(late.into_iter().map(|run| (1e6, run))) {
        let rises = |run: Run| {
            let functions = Observables::new(|y, to| to.push(y[0] - 0.5));
            let then = |one: &Event<f64>, _: &[f64]| if one.rising { Crossed::Ends } else { Crossed::Passed };
            run.crossings(functions, then).start().unwrap()
        };
        let mut end = rises(run.clone());
        for turn in 1..4 {
            let mut state = State::rest(run.chain());
            state.as_mut_slice().copy_from_slice(&end.state);
            let (method, setting) = run.choice().unwrap();
            let again = Run::new(run.chain().clone(), state).until(from + 50.0).unwrap().starting_at(end.t).unwrap();
            end = rises(again.method(method).setting(setting));
            let want = from + 0.5f64.asin() + 2.0 * PI * f64::from(turn);
            assert!((end.t - want).abs() < 1e-3 && end.crossings.len() == 1, "{name}: {} {want}", end.t);
        }
    }
}
