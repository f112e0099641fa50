//! A contact law of one's own: beads that push with the force `f(g) = g^{3/2} + c g^{5/2}` of their
//! overlap `g`, by DOP853 from contact to contact.
//!
//! `cargo run --release -p hertzchain-integrators --example own_law`

use hertzchain_integrators::{
    Error, EventFunctions, Regularised, Stepper, VectorField, dop853::Options, regularised::common_power,
};

const BEADS: usize = 5;
const C: f64 = 0.5;

fn force(g: f64) -> f64 {
    let g = g.max(0.0);
    g * g.sqrt() * (1.0 + C * g)
}

/// The integral of the force.
fn potential(g: f64) -> f64 {
    let g = g.max(0.0);
    g * g * g.sqrt() * (2.0 / 5.0 + C * g * (2.0 / 7.0))
}

/// The overlaps of the bonds at displacements `u`.
fn overlaps(u: &[f64]) -> impl Iterator<Item = f64> + '_ {
    u.windows(2).map(|pair| pair[0] - pair[1])
}

/// Displacements, then velocities, of beads of mass 1.
struct Beads;

impl VectorField<f64> for Beads {
    fn dim(&self) -> usize {
        2 * BEADS
    }

    fn eval(&mut self, _t: f64, y: &[f64], dy: &mut [f64]) {
        let (u, v) = y[..2 * BEADS].split_at(BEADS);
        dy[..BEADS].copy_from_slice(v);
        dy[BEADS..2 * BEADS].fill(0.0);
        for (i, g) in overlaps(u).enumerate() {
            dy[BEADS + i] -= force(g);
            dy[BEADS + i + 1] += force(g);
        }
    }
}

/// A contact opens or closes where its overlap is zero: the force is not smooth there.
impl EventFunctions<f64> for Beads {
    fn count(&self) -> usize {
        BEADS - 1
    }

    fn values(&self, _t: f64, y: &[f64], g: &mut [f64]) {
        g.iter_mut().zip(overlaps(&y[..BEADS])).for_each(|(g, overlap)| *g = overlap);
    }

    fn rates(&self, _t: f64, _y: &[f64], dy: &[f64], rates: &mut [f64]) {
        rates.iter_mut().zip(overlaps(&dy[..BEADS])).for_each(|(rate, overlap)| *rate = overlap);
    }

    fn band(&self, y: &[f64]) -> f64 {
        64.0 * f64::EPSILON * y[..BEADS].iter().fold(0.0f64, |most, u| most.max(u.abs()))
    }
}

fn energy(y: &[f64]) -> f64 {
    let (u, v) = y.split_at(BEADS);
    v.iter().map(|v| 0.5 * v * v).sum::<f64>() + overlaps(u).map(potential).sum::<f64>()
}

pub(crate) fn main() -> Result<(), Error> {
    // The first bead meets the others, which are 0.1 apart, with speed 1.
    let mut y: Vec<f64> = (0..BEADS).map(|i| 0.1 * i as f64).chain([1.0]).collect();
    y.resize(2 * BEADS, 0.0);
    let start = energy(&y);
    // Near a contact's ends the force is of the powers 3/2 and 5/2 of time: smooth in its root.
    let powers = (1.5, common_power(&[1.5, 2.5], 8));
    let mut run = Regularised::new(Beads, Beads, powers, &y, (0.0, 20.0), Options::new(1e-12))?;
    while !run.done() {
        run.step()?;
    }
    run.sample(20.0, &mut y);
    let (error, momentum) = ((energy(&y) / start - 1.0).abs(), y[BEADS..].iter().sum::<f64>());
    println!("{} steps, energy error {error:.1e}, last bead at speed {:.9}", run.stats().steps, y[2 * BEADS - 1]);
    assert!(error < 1e-11 && (momentum - 1.0).abs() < 1e-12 && y[2 * BEADS - 1] > 0.9);
    Ok(())
}
