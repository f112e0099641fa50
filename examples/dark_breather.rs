//! A numerically exact dark breather: a periodic orbit by Newton's method, and its Floquet
//! multipliers.
//!
//! `cargo run --release --example dark_breather`

use hertzchain::{Params, Result, breathers::DarkBreather, dps::Center, orbits::Shooting, study::orbit_study};

pub(crate) fn main() -> Result<()> {
    let params = Params::new(1.5, 1.0, 1.0 / 3.0)?;
    let breather = DarkBreather { params, center: Center::Site, sites: 41, omega_b: 2.05, c_x: 0.0 };
    let shooting = Shooting::default();
    // The seed is the dark profile of the DpS equation.
    let study = orbit_study(breather.orbit(&shooting)?, &shooting)?;

    println!("residual {:.1e}, return error E_b {:.1e}", study.orbit.residual, study.e_b);
    println!("largest multiplier {:.9}", study.spectrum.largest());
    println!("symplectic defect {:.1e}", study.spectrum.quality.symplectic_defect);
    assert!(study.orbit.residual < 1e-12 && study.spectrum.largest() > 1.0);
    Ok(())
}
