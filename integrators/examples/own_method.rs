//! A method of your own: the explicit midpoint rule, for any first-order system.
//!
//! `cargo run --release -p hertzchain-integrators --example own_method`

use hertzchain_integrators::{Error, Silent, Stats, Stepper, VectorField, drive};

/// An oscillator, `x'' = -x`.
struct Oscillator;

impl VectorField<f64> for Oscillator {
    fn dim(&self) -> usize {
        2
    }

    fn eval(&mut self, _t: f64, y: &[f64], dy: &mut [f64]) {
        dy.copy_from_slice(&[y[1], -y[0]]);
    }
}

/// `y1 = y0 + h f(t + h/2, y0 + h/2 f(t, y0))`, with steps of equal length.
struct Midpoint<F> {
    field: F,
    h: f64,
    steps: u64,
    done: u64,
    before: Vec<f64>,
    y: Vec<f64>,
    slope: Vec<f64>,
}

impl<F: VectorField<f64>> Midpoint<F> {
    fn new(field: F, y: &[f64], end: f64, steps: u64) -> Self {
        let [before, y, slope] = [y, y, y].map(<[f64]>::to_vec);
        Self { field, h: end / steps as f64, steps, done: 0, before, y, slope }
    }

    /// `y = before + h slope`.
    fn go(&mut self, h: f64) {
        let known = self.before.iter().zip(&self.slope);
        self.y.iter_mut().zip(known).for_each(|(y, (before, slope))| *y = before + h * slope);
    }
}

impl<F: VectorField<f64>> Stepper<f64> for Midpoint<F> {
    fn dim(&self) -> usize {
        self.y.len()
    }

    fn time(&self) -> f64 {
        self.h * self.done as f64
    }

    fn done(&self) -> bool {
        self.done == self.steps
    }

    fn step(&mut self) -> Result<(), Error> {
        let t = self.time();
        self.before.copy_from_slice(&self.y);
        self.field.eval(t, &self.before, &mut self.slope);
        self.go(0.5 * self.h);
        self.field.eval(t + 0.5 * self.h, &self.y, &mut self.slope);
        self.go(self.h);
        self.done += 1;
        match self.y.iter().position(|y| !y.is_finite()) {
            Some(index) => Err(Error::NotFinite { t: self.time(), step: self.done, index }),
            None => Ok(()),
        }
    }

    /// Between the ends of the last step, of order two as well.
    fn sample(&mut self, t: f64, y: &mut [f64]) {
        let left = self.time() - t;
        let states = self.y.iter().zip(&self.slope);
        y.iter_mut().zip(states).for_each(|(y, (end, slope))| *y = end - left * slope);
    }

    fn stats(&self) -> Stats {
        Stats { steps: self.done, rejected: 0, force_evaluations: 2 * self.done }
    }
}

pub(crate) fn main() -> Result<(), Error> {
    let error = |steps: u64| -> Result<f64, Error> {
        let mut y = [1.0, 0.0];
        drive(&mut Midpoint::new(Oscillator, &y, 10.0, steps), &mut Silent, &mut y)?;
        Ok((y[0] - 10f64.cos()).hypot(y[1] + 10f64.sin()))
    };
    let [coarse, fine] = [error(1000)?, error(2000)?];
    println!("errors {coarse:.2e} and {fine:.2e} with half the step");
    // Order two.
    assert!((coarse / fine - 4.0).abs() < 0.1);
    Ok(())
}
