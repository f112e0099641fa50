//! Splitting of a user's Hamiltonian: a pendulum, `H = p^2/2 - cos q`, with schemes of order 2, 4
//! and 8.
//!
//! `cargo run --release -p hertzchain-integrators --example own_hamiltonian`

use hertzchain_integrators::{
    DoubleDouble, Error, Scheme, Silent, SplitFlow, Splitting, drive,
    splitting::{First, tables},
};

/// Angle `q` and momentum `p`.
pub(crate) struct Pendulum(pub(crate) [f64; 2]);

impl SplitFlow<f64> for Pendulum {
    fn dim(&self) -> usize {
        2
    }

    fn load(&mut self, y: &[f64]) {
        self.0.copy_from_slice(y);
    }

    fn store(&self, y: &mut [f64]) {
        y.copy_from_slice(&self.0);
    }

    fn duplicate(&self) -> Self {
        Self(self.0)
    }

    fn copy_from(&mut self, other: &Self) {
        self.0 = other.0;
    }

    fn drift(&mut self, dt: DoubleDouble<f64>) {
        self.0[0] += dt.value() * self.0[1];
    }

    fn kick_drift(&mut self, kick: f64, drift: DoubleDouble<f64>) {
        self.0[1] -= kick * self.0[0].sin();
        self.drift(drift);
    }
}

/// Change of the energy between the start and the end of a run of length 50.
fn energy_error(scheme: &'static Scheme, steps: u64) -> Result<f64, Error> {
    let energy = |y: &[f64]| 0.5 * y[1] * y[1] - y[0].cos();
    let start = [1.0, 0.5];
    let mut y = start;
    let mut run = Splitting::new(scheme, First::Drift, Pendulum(start), (0.0, 50.0), steps)?;
    drive(&mut run, &mut Silent, &mut y)?;
    Ok((energy(&y) - energy(&start)).abs())
}

pub(crate) fn main() -> Result<(), Error> {
    for (scheme, bound) in [(&tables::STRANG, 1e-3), (&tables::YOSHIDA4, 1e-5), (&tables::KAHAN_LI8, 1e-10)] {
        let error = energy_error(scheme, 1000)?;
        println!("{:12} order {}: energy error {error:.1e}", scheme.name, scheme.order);
        assert!(error < bound);
    }
    Ok(())
}
