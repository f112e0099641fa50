//! Events of a system of your own: a ball that bounces on the floor.
//!
//! `cargo run --release -p hertzchain-integrators --example bouncing_ball`

use hertzchain_integrators::{Error, EventFunctions, Regularised, Stepper, VectorField, dop853::Options};

/// Height and velocity; gravity is 1.
struct Ball;

/// Share of the velocity that a bounce leaves.
const KEPT: f64 = 0.8;

impl VectorField<f64> for Ball {
    fn dim(&self) -> usize {
        2
    }

    fn eval(&mut self, _t: f64, y: &[f64], dy: &mut [f64]) {
        dy.copy_from_slice(&[y[1], -1.0]);
    }

    // The height changes its sign: the method stops there, and the state may change.
    fn turn(&mut self, _index: usize, positive: bool, y: &mut [f64]) -> bool {
        if !positive {
            y[1] *= -KEPT;
        }
        !positive
    }
}

/// The event function is the height.
struct Floor;

impl EventFunctions<f64> for Floor {
    fn count(&self) -> usize {
        1
    }

    fn values(&self, _t: f64, y: &[f64], g: &mut [f64]) {
        g[0] = y[0];
    }

    fn rates(&self, _t: f64, _y: &[f64], dy: &[f64], rates: &mut [f64]) {
        rates[0] = dy[0];
    }

    fn band(&self, y: &[f64]) -> f64 {
        1e-15 * y[1].abs()
    }
}

pub(crate) fn main() -> Result<(), Error> {
    let mut run = Regularised::new(Ball, Floor, (1.0, 1), &[1.0, 0.0], (0.0, 9.0), Options::new(1e-12))?;
    let (mut y, mut t, mut speed) = ([0.0; 2], 2f64.sqrt(), KEPT * 2f64.sqrt());
    while !run.done() {
        run.step()?;
        run.sample(run.time(), &mut y);
        for event in run.events().iter().filter(|event| !event.rising) {
            println!("bounce at t = {:.12}", event.t);
            assert!((event.t - t).abs() < 1e-9);
            // Truth: the next parabola.
            t += 2.0 * speed;
            speed *= KEPT;
        }
        assert!(y[0] > -1e-9, "the ball has fallen through the floor");
    }
    Ok(())
}
