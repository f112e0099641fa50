//! DOP853 without a chain: a satellite between earth and moon.
//!
//! `cargo run --release -p hertzchain-integrators --example arenstorf`

use hertzchain_integrators::{Dop853, Error, Silent, Stepper, VectorField, dop853::Options, drive};

/// The restricted three-body problem in rotating coordinates: position, then velocity (Arenstorf;
/// Hairer, Norsett & Wanner, *Solving ODEs I*, Sec. II.0).
struct ThreeBodies;

const MU: f64 = 0.012277471;

impl VectorField<f64> for ThreeBodies {
    fn dim(&self) -> usize {
        4
    }

    fn eval(&mut self, _t: f64, y: &[f64], dy: &mut [f64]) {
        let (nu, x, z) = (1.0 - MU, y[0], y[1]);
        let cubed = |d: f64| (d * d + z * z).powf(1.5);
        let (earth, moon) = (cubed(x + MU), cubed(x - nu));
        dy[0] = y[2];
        dy[1] = y[3];
        dy[2] = x + 2.0 * y[3] - nu * (x + MU) / earth - MU * (x - nu) / moon;
        dy[3] = z - 2.0 * y[2] - nu * z / earth - MU * z / moon;
    }
}

pub(crate) fn main() -> Result<(), Error> {
    let start = [0.994, 0.0, 0.0, -2.001_585_106_379_082_5];
    let period = 17.065_216_560_157_96;
    let mut run = Dop853::new(ThreeBodies, &start, (0.0, period), Options::new(1e-12))?;
    let mut y = start;
    drive(&mut run, &mut Silent, &mut y)?;
    let back = start.iter().zip(&y).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("{} steps; after one period the satellite is back to {back:.1e}", run.stats().steps);
    assert!(back < 1e-5);
    Ok(())
}
