//! Continuation: a branch of dark breathers in the frequency, with its bifurcations.
//!
//! `cargo run --release --example continuation`

use hertzchain::{
    Params, Result,
    breathers::DarkBreather,
    dps::Center,
    orbits::{Continuation, Parameter, Shooting},
    study::branch,
};

pub(crate) fn main() -> Result<()> {
    let params = Params::new(1.5, 1.0, 1.0 / 3.0)?;
    let breather = DarkBreather { params, center: Center::Bond, sites: 20 + 1, omega_b: 2.02, c_x: 0.0 };
    let continuation = Continuation {
        parameter: Parameter::OmegaB,
        to: 2.08,
        step: 0.01,
        most_points: 50,
        natural: false,
        shooting: Shooting::default(),
    };
    let branch = branch(&breather, &continuation, 1e-3, &|_, _| ())?;
    println!("omega_b   amplitude  largest multiplier");
    for point in &branch.points {
        let omega_b = point.orbit.setting.omega_b;
        println!("{omega_b:.5}  {:9.6}  {:.9}", point.orbit.amplitude(), point.spectrum.largest());
    }
    println!("{} bifurcations; the branch ended: {:?}", branch.bifurcations.len(), branch.ended());
    // The amplitude of breathers grows with their frequency.
    let amplitudes: Vec<f64> = branch.points.iter().map(|point| point.orbit.amplitude()).collect();
    assert!(amplitudes.len() > 5 && amplitudes.windows(2).all(|pair| pair[0] < pair[1]));
    Ok(())
}
