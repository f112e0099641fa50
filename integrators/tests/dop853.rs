//! DOP853 against the authors' code, closed forms, and the order conditions.
//!
//! Reference numbers come from `dop853.f` of E. Hairer and G. Wanner, version of October 11, 2009
//! (<https://www.unige.ch/~hairer/software.html>), compiled without contraction and run with its
//! default parameters except those that a test names: NFCN, NSTEP, NACCPT, NREJCT and the final
//! state to 17 digits. Problems: the authors' driver `dr_dop853.f` (van der Pol) and the Arenstorf
//! orbit of Hairer, Norsett & Wanner, *Solving ODEs I*, section II.0.

// The numbers stand as printed.
#![allow(clippy::excessive_precision)]

use hertzchain_integrators::{
    Dop853, DoubleDouble, Error, Observer, Real, Silent, Stats, Stepper, Stop, VectorField,
    dop853::{Options, tableau},
    drive,
};
use std::ops::ControlFlow;
use twofloat::TwoFloat;

/// A right-hand side given as a closure.
struct Field<F>(usize, F);

impl<R: Real, F: FnMut(R, &[R], &mut [R])> VectorField<R> for Field<F> {
    fn dim(&self) -> usize {
        self.0
    }
    fn eval(&mut self, t: R, y: &[R], dy: &mut [R]) {
        (self.1)(t, y, dy);
    }
}

fn field<R: Real, F: FnMut(R, &[R], &mut [R])>(dim: usize, f: F) -> Field<F> {
    Field(dim, f)
}

/// The counts that the Fortran prints: NFCN, NSTEP, NACCPT, NREJCT.
fn counts<F: VectorField<f64>>(run: &Dop853<f64, F>) -> [u64; 4] {
    let Stats { steps, rejected, force_evaluations } = run.stats();
    [force_evaluations, run.trials(), steps, rejected]
}

fn finish<R: Real, F: VectorField<R>>(run: &mut Dop853<R, F>) -> Vec<R> {
    let mut y = vec![R::zero(); run.dim()];
    assert_eq!(drive(run, &mut Silent, &mut y), Ok(Stop::End));
    y
}

fn assert_near(got: &[f64], want: &[f64], tolerance: f64) {
    for (i, (g, w)) in got.iter().zip(want).enumerate() {
        assert!((g - w).abs() <= tolerance * w.abs().max(1.0), "component {i}: {g:.17e}, not {w:.17e}");
    }
}

const VAN_DER_POL: ([f64; 2], (f64, f64)) = ([2.0, 0.0], (0.0, 2.0));

fn van_der_pol(options: Options<f64>) -> Dop853<f64, impl VectorField<f64>> {
    let f = |_, y: &[f64], dy: &mut [f64]| {
        dy[0] = y[1];
        dy[1] = ((1.0 - y[0] * y[0]) * y[1] - y[0]) / 1e-3;
    };
    Dop853::new(field(2, f), &VAN_DER_POL.0, VAN_DER_POL.1, options).unwrap()
}

fn arenstorf(options: Options<f64>) -> Dop853<f64, impl VectorField<f64>> {
    let f = |_, y: &[f64], dy: &mut [f64]| {
        let mu = 0.012277471;
        let nu = 1.0 - mu;
        let [x, z] = [y[0], y[1]];
        let cube = |square: f64| square * square.sqrt();
        let earth = cube((x + mu) * (x + mu) + z * z);
        let moon = cube((x - nu) * (x - nu) + z * z);
        dy[0] = y[2];
        dy[1] = y[3];
        dy[2] = x + 2.0 * y[3] - nu * (x + mu) / earth - mu * (x - nu) / moon;
        dy[3] = z - 2.0 * y[2] - nu * z / earth - mu * z / moon;
    };
    let start = [0.994, 0.0, 0.0, -2.001_585_106_379_082_5];
    Dop853::new(field(4, f), &start, (0.0, 17.065_216_560_157_964), options).unwrap()
}

#[test]
fn the_authors_driver_is_repeated_step_by_step() {
    let mut run = van_der_pol(Options::new(1e-9));
    let y = finish(&mut run);
    assert_eq!(counts(&run), [17495, 1468, 1345, 122]);
    assert_near(&y, &[1.763_234_540_188_910_2, -0.835_688_681_914_662_06], 1e-13);
    assert_eq!(run.time(), 2.0);
}

#[test]
fn dense_output_is_that_of_the_driver_and_costs_three_evaluations_a_step_looked_into() {
    struct Grid {
        next: f64,
        at_one: [f64; 2],
    }
    impl Observer<f64> for Grid {
        fn next(&self) -> Option<f64> {
            Some(self.next)
        }
        fn observe(&mut self, t: f64, y: &[f64], _: Stats) -> Result<ControlFlow<()>, Error> {
            if (t - 1.0).abs() < 0.05 {
                self.at_one = [y[0], y[1]];
            }
            self.next += 0.1;
            Ok(ControlFlow::Continue(()))
        }
    }
    // The driver prints at 0.1, 0.2, ... with IOUT = 3: 19 points inside a step (the 20th misses 2
    // by a round-off).
    let mut grid = Grid { next: 0.1, at_one: [0.0; 2] };
    let mut run = van_der_pol(Options::new(1e-9));
    let mut y = [0.0; 2];
    assert_eq!(drive(&mut run, &mut grid, &mut y), Ok(Stop::End));
    assert_eq!(counts(&run), [17552, 1468, 1345, 122]);
    assert_near(&grid.at_one, &[-1.888_370_653_022_574_8, 0.735_737_500_804_723_78], 1e-13);

    // IOUT = 2 prepares every step. A second sample in a step and samples at its ends cost nothing.
    let mut run = van_der_pol(Options::new(1e-9));
    let mut start = run.time();
    while !run.done() {
        run.step().unwrap();
        for share in [0.0, 0.25, 0.75, 1.0] {
            run.sample(start + share * (run.time() - start), &mut y);
        }
        start = run.time();
    }
    assert_eq!(counts(&run), [21530, 1468, 1345, 122]);
}

#[test]
fn the_arenstorf_orbit_is_repeated_at_every_tolerance() {
    // At 1e-11 the first step is rejected twice, which NREJCT does not count: 229 + 67 + 2 = 298.
    // The Fortran rounds the time after every step, so its last step differs in the last digit.
    // Near the moon, where the orbit ends, this changes the velocity by 10^-12.
    for line in include_str!("arenstorf.csv").lines().skip(1) {
        let row: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let mut run = arenstorf(Options::new(row[0]));
        let y = finish(&mut run);
        assert_eq!(counts(&run).map(|count| count as f64), row[1..5], "tolerance {:e}", row[0]);
        assert_near(&y, &row[5..], 2e-11);
    }
}

/// A nonlinear system with the solution `x = 1 / (1 + t)`, `y = 1 / (1 + t^2)`.
fn rational() -> Field<impl FnMut(TwoFloat, &[TwoFloat], &mut [TwoFloat])> {
    field(2, |t: TwoFloat, y: &[TwoFloat], dy: &mut [TwoFloat]| {
        dy[0] = -y[0] * y[0] * y[1] * (t * t + 1.0);
        dy[1] = -y[1] * y[1] * t * 2.0;
    })
}

fn rational_error(t: TwoFloat, y: &[TwoFloat]) -> f64 {
    let truth = [t + 1.0, t * t + 1.0]
        .map(|below| DoubleDouble::new(TwoFloat::from(1.0)).over(DoubleDouble::new(below)).value());
    (0..2).map(|i| f64::from((y[i] - truth[i]).abs())).fold(0.0, f64::max)
}

const ONES: [f64; 2] = [1.0, 1.0];

fn double_double(y: [f64; 2]) -> [TwoFloat; 2] {
    y.map(TwoFloat::from)
}

fn slopes(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect()
}

fn assert_slopes(errors: &[f64], order: f64) {
    for slope in slopes(errors) {
        assert!((slope - order).abs() < 0.2, "slope {slope}, not {order}: errors {errors:?}");
    }
}

/// One fixed step of length `h` from 1, where all derivatives contribute.
fn one_step(h: TwoFloat) -> Dop853<TwoFloat, impl VectorField<TwoFloat>> {
    let start = TwoFloat::from(1.0);
    let mut run = Dop853::fixed(rational(), &double_double([0.5, 0.5]), (start, start + h), 1).unwrap();
    run.step().unwrap();
    run
}

#[test]
fn in_one_step_the_result_is_of_order_8_and_dense_output_of_order_7() {
    let at = |share: f64| {
        [4, 5, 6].map(|power| {
            let h = TwoFloat::from(0.5f64.powi(power));
            let mut run = one_step(h);
            let t = TwoFloat::from(1.0) + h * share;
            let mut y = double_double(ONES);
            run.sample(t, &mut y);
            rational_error(t, &y)
        })
    };
    assert_slopes(&at(1.0), 9.0);
    for share in [0.2, 0.5, 0.7] {
        assert_slopes(&at(share), 8.0);
    }
}

#[test]
fn a_double_double_run_reaches_a_tolerance_that_f64_is_refused() {
    let span = (TwoFloat::from(0.0), TwoFloat::from(2.0));
    let options = Options::new(TwoFloat::from(1e-22));
    let mut run = Dop853::new(rational(), &double_double(ONES), span, options).unwrap();
    let y = finish(&mut run);
    let error = rational_error(span.1, &y);
    assert!(error > 0.0 && error < 1e-21, "{error:e}");
}

fn sum(weights: &tableau::Weights, term: impl Fn(usize) -> TwoFloat) -> TwoFloat {
    let terms = weights.iter().map(|&(stage, weight)| TwoFloat::decimal(weight) * term(stage));
    terms.fold(TwoFloat::from(0.0), |sum, term| sum + term)
}

fn node(stage: usize) -> TwoFloat {
    match stage {
        1 => TwoFloat::from(0.0),
        13 => TwoFloat::from(1.0),
        2..=12 => TwoFloat::decimal(tableau::STAGES[stage - 2].0),
        _ => TwoFloat::decimal(tableau::DENSE_STAGES[stage - 14].0),
    }
}

#[test]
fn the_rows_of_the_table_add_up_to_its_nodes() {
    for (c, a) in tableau::STAGES.iter().chain(&tableau::DENSE_STAGES) {
        let gap = f64::from((sum(a, |_| TwoFloat::from(1.0)) - TwoFloat::decimal(c)).abs());
        assert!(gap < 1e-28, "c = {c}: {gap:e}");
    }
}

/// The error of the weights as a quadrature of `int_0^1 s^k ds`.
fn defect(weights: &tableau::Weights, k: i32) -> f64 {
    let power = |stage| (0..k).fold(TwoFloat::from(1.0), |power, _| power * node(stage));
    f64::from((sum(weights, power) - TwoFloat::from(1.0) / f64::from(k + 1)).abs())
}

#[test]
fn the_weights_are_quadratures_of_their_orders_and_no_higher() {
    for (weights, order, least) in [(tableau::B, 8, 1e-5), (tableau::BHH, 3, 1e-3)] {
        for k in 0..order {
            assert!(defect(weights, k) < 1e-28, "k = {k}: {:e}", defect(weights, k));
        }
        assert!(defect(weights, order) > least);
    }
    // The estimator of order 5 gives zero below degree 5, and not zero for degree 5.
    let seen = |k: i32| {
        let power = |stage| (0..k).fold(TwoFloat::from(1.0), |power, _| power * node(stage));
        f64::from(sum(tableau::ERROR_5, power).abs())
    };
    assert!((0..5).all(|k| seen(k) < 1e-27) && seen(5) > 1e-4);
}

#[test]
fn every_component_is_treated_alike() {
    // Copies of one oscillator, for every remainder of the vector length: the mean square norm is
    // the same for any number of copies.
    let run = |copies: usize| {
        let f = move |_, y: &[f64], dy: &mut [f64]| {
            for (y, dy) in y.chunks(2).zip(dy.chunks_mut(2)) {
                (dy[0], dy[1]) = (y[1], -y[0].sin());
            }
        };
        // The estimate of the first step depends on the number of components, so the step is given.
        let options = Options { first_step: Some(0.1), ..Options::new(1e-8) };
        let start = [1.0, 0.5].repeat(copies);
        let mut run = Dop853::new(field(2 * copies, f), &start, (0.0, 20.0), options).unwrap();
        (finish(&mut run), counts(&run))
    };
    let (one, work) = run(1);
    for copies in 2..=20 {
        let (many, same) = run(copies);
        assert_eq!(same, work);
        for pair in many.chunks(2) {
            assert_eq!(pair, &many[..2]);
            assert_near(pair, &one, 1e-12);
        }
    }
}

#[test]
fn an_empty_span_is_done_at_once() {
    let nothing = || field(1, |_, _: &[f64], _: &mut [f64]| unreachable!("nothing is to be evaluated"));
    for mut run in [
        Dop853::new(nothing(), &[3.0], (1.0, 1.0), Options::new(1e-9)).unwrap(),
        Dop853::fixed(nothing(), &[3.0], (1.0, 1.0), 0).unwrap(),
    ] {
        assert!(run.done());
        assert_eq!(finish(&mut run), [3.0]);
        assert_eq!(run.stats(), Stats::default());
    }
}

fn decay() -> Field<impl FnMut(f64, &[f64], &mut [f64])> {
    field(1, |_, y: &[f64], dy: &mut [f64]| dy[0] = -y[0])
}

#[test]
fn bad_arguments_are_refused_with_their_value_and_rule() {
    let good = Options::new(1e-9);
    let options = |options| Dop853::new(decay(), &[1.0], (0.0, 1.0), options).err();
    let span = |start, end| Dop853::new(decay(), &[1.0], (start, end), good).err();
    let state = |y: &[f64]| Dop853::new(decay(), y, (0.0, 1.0), good).err();
    let step = "a step is finite and above zero";
    let relative = "a relative tolerance is finite and above 10 unit round-offs";
    for (error, name, value, rule) in [
        (options(Options { rtol: 1e-15, ..good }), "rtol", 1e-15, relative),
        (options(Options { rtol: f64::INFINITY, ..good }), "rtol", f64::INFINITY, relative),
        (options(Options { atol: 0.0, ..good }), "atol", 0.0, "an absolute tolerance is finite and above zero"),
        (options(Options { first_step: Some(-1.0), ..good }), "first_step", -1.0, step),
        (options(Options { max_steps: 0, ..good }), "max_steps", 0.0, "at least one step"),
        (span(f64::INFINITY, 1.0), "start", f64::INFINITY, "a time is finite"),
        (span(2.0, 1.0), "end", 1.0, "the end is finite and not before the start"),
        (span(0.0, f64::INFINITY), "end", f64::INFINITY, "the end is finite and not before the start"),
        (state(&[1.0, 2.0]), "y0", 2.0, "as many components as the field, at least one"),
        (state(&[f64::INFINITY]), "y0", f64::INFINITY, "every component of the state is finite"),
        (Dop853::fixed(decay(), &[1.0], (0.0, 1.0), 0).err(), "steps", 0.0, "at least one step"),
    ] {
        assert_eq!(error, Some(Error::Argument { name, value, rule }));
    }
    for nan in [Options { rtol: f64::NAN, ..good }, Options { atol: f64::NAN, ..good }] {
        assert!(matches!(options(nan), Some(Error::Argument { value, .. }) if value.is_nan()));
    }
}

/// Runs to an error; returns it with the state that [`drive`] left.
fn failure<F: VectorField<f64>>(run: &mut Dop853<f64, F>) -> (Error, Vec<f64>) {
    let mut y = vec![f64::NAN; run.dim()];
    (drive(run, &mut Silent, &mut y).unwrap_err(), y)
}

#[test]
fn a_field_that_stops_being_a_number_ends_the_run_with_the_last_good_state() {
    let f = |t: f64, y: &[f64], dy: &mut [f64]| {
        dy[0] = -y[0];
        dy[1] = if t > 0.5 { f64::NAN } else { -y[1] };
    };
    let mut adaptive = Dop853::new(field(2, f), &[1.0, 2.0], (0.0, 1.0), Options::new(1e-9)).unwrap();
    let mut fixed = Dop853::fixed(field(2, f), &[1.0, 2.0], (0.0, 1.0), 10).unwrap();
    for run in [&mut adaptive, &mut fixed] {
        let (error, y) = failure(run);
        let (t, step) = (run.time(), run.stats().steps);
        assert_eq!(error, Error::NotFinite { t, step, index: 1 });
        assert!(step > 0 && t > 0.0 && t <= 0.5, "{t}");
        assert_near(&y, &[(-t).exp(), 2.0 * (-t).exp()], 1e-8);
        // A second call fails in the same way.
        assert_eq!(run.step(), Err(Error::NotFinite { t, step, index: 1 }));
    }
    assert_eq!(fixed.stats().steps, 5);
}

#[test]
fn no_stage_hides_a_nan() {
    // The result has no weights for stages 2 to 5, and this field discards its argument.
    for stage in 1..=13 {
        let mut calls = 0;
        let f = move |_, _: &[f64], dy: &mut [f64]| {
            calls += 1;
            dy.fill(1.0);
            if calls == stage {
                dy[2] = f64::NAN;
            }
        };
        let mut run = Dop853::fixed(field(3, f), &[0.0, 1.0, 2.0], (0.0, 1.0), 2).unwrap();
        let (error, y) = failure(&mut run);
        assert_eq!(error, Error::NotFinite { t: 0.0, step: 0, index: 2 }, "stage {stage}");
        assert_eq!(y, [0.0, 1.0, 2.0]);
    }
}

#[test]
fn a_solution_that_blows_up_ends_with_an_error_near_its_pole() {
    // y = 1 / (1 - t).
    let f = field(1, |_, y: &[f64], dy: &mut [f64]| dy[0] = y[0] * y[0]);
    let options = Options { max_steps: 2000, ..Options::new(1e-9) };
    let mut run = Dop853::new(f, &[1.0], (0.0, 2.0), options).unwrap();
    let (error, y) = failure(&mut run);
    assert!(matches!(error, Error::StepUnderflow { .. }), "{error:?}");
    assert!((run.time() - 1.0).abs() < 1e-8 && y[0].is_finite() && y[0] > 1e6, "{} {y:?}", run.time());
}

#[test]
fn a_step_that_no_longer_moves_the_time_is_an_error() {
    let options = Options { first_step: Some(1e-15), ..Options::new(1e-9) };
    let mut run = Dop853::new(decay(), &[1.0], (1.0, 2.0), options).unwrap();
    assert_eq!(failure(&mut run), (Error::StepUnderflow { t: 1.0, h: 1e-15 }, vec![1.0]));
    let mut run = Dop853::fixed(decay(), &[1.0], (1.0, 1.0 + 1e-12), 10_000).unwrap();
    assert!(matches!(failure(&mut run).0, Error::StepUnderflow { t: 1.0, .. }));
}

#[test]
fn the_number_of_trials_is_limited() {
    let mut run = van_der_pol(Options { max_steps: 100, ..Options::new(1e-9) });
    let (error, y) = failure(&mut run);
    assert_eq!(error, Error::TooManySteps { t: run.time(), steps: 100 });
    assert_eq!(run.trials(), 100);
    assert!(y.iter().all(|y| y.is_finite()));
}
