//! Continuation: a branch of dark breathers in the frequency, with its bifurcations.
//!
//! `cargo run --release --example continuation`

use hertzchain::{
    Result,
    dps::Center,
    study::{BranchOptions, Continue, FollowCommand, Ring},
    sweep::Engine,
};

pub(crate) fn main() -> Result<()> {
    let command = Continue {
        center: Center::Bond,
        from: Some(2.02),
        branch: BranchOptions { to: Some(2.08), step: Some(0.01), max_points: 50, ..BranchOptions::default() },
        bifurcations: Some(true),
        weak: 1e-3,
        ring: Ring { sites: 20 + 1, ..Ring::default() },
        ..Continue::default()
    };
    let branch = command.follow()?(&Engine::threads(), &|_, _| ())?.branch;
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
