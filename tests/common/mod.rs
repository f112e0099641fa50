//! Shared by the tests of contact collocation: the run under test, and a reference run by another
//! method.
#![allow(dead_code, reason = "each binary of tests uses some of it")]

pub(crate) use crate::numbers::{distance, largest};
use hertzchain::{
    Method, Run,
    chain::{Chain, Field, Overlaps, State},
    integrators::{
        Real, Regularised, Silent, Stats, Stepper, collocation::StepControl, dop853::Options, drive,
        regularised::common_power,
    },
};

/// The state at the end of a regularised run, whose variables and steps differ from those of
/// collocation.
pub(crate) fn truth(chain: &Chain<f64>, y0: &[f64], end: f64, tol: f64) -> Vec<f64> {
    let size = largest(y0.iter().copied()).max(1e-300);
    regularised(chain.clone(), y0, end, Options { atol: tol * size, ..Options::new(tol) })
}

/// The same, in any precision.
pub(crate) fn regularised<R: Real>(chain: Chain<R>, y0: &[R], end: f64, options: Options<R>) -> Vec<R> {
    let (alpha, span) = (chain.params().alpha, (R::zero(), R::of(end)));
    let (field, overlaps) = (Field::new(chain.clone()), Overlaps::new(chain));
    let mut run = Regularised::new(field, overlaps, (alpha, common_power(&[alpha], 8)), y0, span, options).unwrap();
    let mut y = y0.to_vec();
    drive(&mut run, &mut Silent, &mut y).unwrap();
    y
}

pub(crate) fn collocated(chain: &Chain<f64>, y0: &[f64], end: f64, control: StepControl) -> (Vec<f64>, Stats) {
    let mut run = chain.collocation(y0, (0.0, end), control).unwrap();
    let mut y = y0.to_vec();
    drive(&mut run, &mut Silent, &mut y).unwrap();
    (y, run.stats())
}

/// The state at the end of a run by contact collocation.
pub(crate) fn at_end(chain: &Chain<f64>, start: &State<f64>, end: f64, tol: f64) -> Vec<f64> {
    let run = Run::new(chain.clone(), start.clone()).until(end).unwrap().method(Method::Collocation);
    run.tolerance(tol).unwrap().start().unwrap().complete().unwrap().state
}

/// The order in the length of windows, from a number of windows to another: of the means of an
/// error over nearby numbers, because single errors jump with the position of events in a window.
pub(crate) fn slope_of_windows(counts: [u64; 2], error: impl Fn(u64) -> f64) -> f64 {
    let mean = |count: u64| ((0..12).map(|k| error(count + count * k / 24).ln()).sum::<f64>() / 12.0).exp();
    let [coarse, fine] = counts.map(mean);
    let slope = (coarse / fine).ln() / (counts[1] as f64 / counts[0] as f64).ln();
    println!("{coarse:.2e} to {fine:.2e}, slope {slope:.2}");
    slope
}
