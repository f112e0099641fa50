//! Events: which are found, at what time, and which must not be found.

use hertzchain_integrators::{
    Dop853, Error, Event, EventFunctions, Regularised, Silent, Stepper, Stop, VectorField, Watch,
    dop853::Options,
    drive,
    events::{Listener, Part},
};
use std::ops::ControlFlow;

/// `y' = 1`: the state is the time, so that event functions are arbitrary functions of time.
struct Clock;

impl VectorField<f64> for Clock {
    fn dim(&self) -> usize {
        1
    }
    fn eval(&mut self, _: f64, _: &[f64], dy: &mut [f64]) {
        dy[0] = 1.0;
    }
}

/// Functions of time of size one, with a band of 1e-12.
struct Given<const K: usize>([fn(f64) -> f64; K]);

impl<const K: usize> EventFunctions<f64> for Given<K> {
    fn count(&self) -> usize {
        K
    }
    fn values(&self, _: f64, y: &[f64], g: &mut [f64]) {
        for (g, f) in g.iter_mut().zip(self.0) {
            *g = f(y[0]);
        }
    }
    fn rates(&self, _: f64, _: &[f64], _: &[f64], _: &mut [f64]) {
        unreachable!("nothing here asks for rates")
    }
    fn band(&self, _: &[f64]) -> f64 {
        1e-12
    }
}

/// A listener that records everything and, if asked to, stops at the first falling event.
#[derive(Default)]
struct Diary {
    events: Vec<Event<f64>>,
    positive: f64,
    stop_at_fall: bool,
}

impl Listener<f64> for Diary {
    fn event(&mut self, event: Event<f64>, y: &[f64]) -> ControlFlow<()> {
        assert!((y[0] - event.t).abs() < 1e-12, "the state of an event is that of its time");
        self.events.push(event);
        if self.stop_at_fall && !event.rising { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
    fn positive(&mut self, part: &Part<f64>, _run: &mut dyn Stepper<f64>) {
        self.positive += part.span.1 - part.span.0;
    }
}

/// The events of functions of time on `[0, end]`, in `steps` equal steps.
fn diary<const K: usize>(functions: [fn(f64) -> f64; K], end: f64, steps: u64) -> Diary {
    let run = Dop853::fixed(Clock, &[0.0], (0.0, end), steps).unwrap();
    let mut watch = Watch::new(run, Given(functions), Diary::default());
    assert_eq!(drive(&mut watch, &mut Silent, &mut [0.0]), Ok(Stop::End));
    watch.into_listener()
}

fn found(diary: &Diary) -> Vec<(usize, bool)> {
    diary.events.iter().map(|event| (event.index, event.rising)).collect()
}

#[test]
fn all_roots_inside_one_step_are_found_in_order_of_time() {
    // Truth: the roots of the polynomials.
    let diary = diary([|t| (t - 0.2) * (t - 0.5) * (t - 0.9), |t| -(t - 0.4) * (t - 0.400_01)], 1.0, 1);
    assert_eq!(found(&diary), [(0, true), (1, true), (1, false), (0, false), (0, true)]);
    for (event, t) in diary.events.iter().zip([0.2, 0.4, 0.400_01, 0.5, 0.9]) {
        assert!((event.t - t).abs() < 1e-13, "{event:?}");
    }
    // Positive on (0.2, 0.5), (0.9, 1) and (0.4, 0.40001). Roots 1e-5 apart amplify rounding by
    // 1e5.
    assert!((diary.positive - 0.400_01).abs() < 1e-10, "{}", diary.positive);
}

#[test]
fn a_start_on_the_surface_fires_only_upwards() {
    assert_eq!(found(&diary([|t| t], 1.0, 3)), [(0, true)]);
    assert_eq!(diary([|t| t], 1.0, 3).events[0].t, 0.0);
    assert_eq!(found(&diary([|t| -t], 1.0, 3)), []);
    // At rest initially: the last zero is the start here too.
    let slow = diary([|t| t * t * t], 1.0, 3);
    assert!(found(&slow) == [(0, true)] && slow.events[0].t < 1e-3);
}

#[test]
fn what_is_identically_zero_never_fires() {
    assert_eq!(found(&diary([|_| 0.0, |t| 1e-13 * (50.0 * t).sin()], 1.0, 7)), []);
}

#[test]
fn an_event_on_the_end_of_a_step_fires_once() {
    for steps in [1, 2, 4, 5, 8] {
        let diary = diary([|t| t - 0.5], 1.0, steps);
        assert_eq!(found(&diary), [(0, true)], "{steps} steps");
        assert!((diary.events[0].t - 0.5).abs() < 1e-15);
    }
}

#[test]
fn grazing_fires_twice_or_not_at_all() {
    for steps in [1, 2, 3] {
        // From below: touching is no event; leaving the band above gives an onset and a release.
        assert_eq!(found(&diary([|t| -(t - 0.5).powi(2)], 1.0, steps)), []);
        assert_eq!(found(&diary([|t| 1e-10 - (t - 0.5).powi(2)], 1.0, steps)), [(0, true), (0, false)]);
        // From above.
        assert_eq!(found(&diary([|t| (t - 0.5).powi(2)], 1.0, steps)), []);
        assert_eq!(found(&diary([|t| (t - 0.5).powi(2) - 1e-10], 1.0, steps)), [(0, false), (0, true)]);
    }
}

#[test]
fn ties_fire_together_and_near_ties_in_the_order_of_time() {
    let tie = diary([|t| t - 0.3, |t| 2.0 * (t - 0.3)], 1.0, 2);
    assert_eq!(tie.events.len(), 2);
    assert!((tie.events[0].t - tie.events[1].t).abs() < 1e-15 && tie.events[0].index != tie.events[1].index);
    assert_eq!(found(&diary([|t| t - 0.3 - 1e-12, |t| t - 0.3], 1.0, 2)), [(1, true), (0, true)]);
}

#[test]
fn a_listener_that_breaks_ends_the_run_at_its_event() {
    let run = Dop853::fixed(Clock, &[0.0], (0.0, 9.0), 4).unwrap();
    let listener = Diary { stop_at_fall: true, ..Diary::default() };
    let mut watch = Watch::new(run, Given([|t| t.sin()]), listener);
    let mut y = [0.0];
    drive(&mut watch, &mut Silent, &mut y).unwrap();
    let end = watch.time();
    assert_eq!(found(&watch.into_listener()), [(0, true), (0, false)]);
    assert!((end - std::f64::consts::PI).abs() < 1e-13 && (y[0] - end).abs() < 1e-13);
}

#[test]
fn a_problem_that_cannot_be_run_is_refused() {
    let start = |alpha, q| {
        let run = Regularised::new(Clock, Given([|t| t]), (alpha, q), &[0.0], (0.0, 1.0), Options::new(1e-9));
        run.err().map(|error| match error {
            Error::Argument { name, .. } => name,
            _ => "another error",
        })
    };
    assert_eq!(start(0.0, 2), Some("alpha"));
    assert_eq!(start(f64::NAN, 2), Some("alpha"));
    assert_eq!(start(1.5, 0), Some("q"));
    assert_eq!(start(1.5, 2), None);
}
