//! The energy error of three splittings on a strongly nonlinear random ring, over many periods.
//!
//! `cargo run --release --example long_energy -- 1e6` runs 10^6 periods of the resonators; without
//! an argument there are 1000.

use hertzchain::{Boundary, Chain, Method, Params, Result, Run, State, chain::Site};
use std::f64::consts::PI;

pub(crate) fn main() -> Result<()> {
    let periods = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(1000.0);
    // omega = (kappa (1 + 1/rho))^{1/2} = 2: a period is pi.
    let chain = Chain::new(Params::new(1.5, 1.0, 1.0 / 3.0)?, Boundary::Ring, 20)?;
    // Numbers in (-1, 1) without a pattern.
    let noise = |k: usize| 2.0 * (0.710_550_39 * k as f64 + 0.092_516_4).fract() - 1.0;
    let site = |n: usize| Site { u: noise(3 * n), v: noise(3 * n + 1), u_dot: noise(3 * n + 2), v_dot: 0.0 };
    let start = State::from_fn(&chain, site)?;
    let energy = |state: &State<f64>| chain.energy(state.as_slice()).total();

    // The energy is compared at a thousand times.
    let times: Vec<f64> = (0..1000).map(|k| periods * PI * f64::from(k + 1) / 1000.0).collect();
    let mut largest = Vec::new();
    for name in ["corrected", "takahashi-imada-linear", "strang-linear"] {
        let run = Run::new(chain.clone(), start.clone()).until(periods * PI)?;
        let run = run.method(Method::named(name)?).step(PI / 64.0)?;
        let mut worst = 0.0f64;
        print!("{name:22}");
        for (k, state) in (1..).zip(run.at(&times)?) {
            worst = worst.max((energy(&state?) / energy(&start) - 1.0).abs());
            if [1, 10, 100, 1000].contains(&k) {
                print!("  {worst:.1e}");
            }
        }
        println!();
        largest.push(worst);
    }
    println!("largest |E/E_0 - 1| up to 1/1000, 1/100, 1/10 and all of {periods:e} periods, 64 kicks a period");
    assert!(largest[0] < 1e-2 * largest[1].min(largest[2]));
    Ok(())
}
