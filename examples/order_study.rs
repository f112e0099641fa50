//! A small order study: errors of four methods against the number of steps, with contacts.
//!
//! `cargo run --release --example order_study`

use hertzchain::{Boundary, Chain, Method, Params, Result, Run, State, chain::Site};

pub(crate) fn main() -> Result<()> {
    let chain = Chain::new(Params::new(1.5, 1.0, 1.0 / 3.0)?, Boundary::Free, 5)?;
    // Beads that fly towards each other, with irregular velocities.
    let state = State::from_fn(&chain, |n| {
        let n = n as f64;
        Site { u: 0.1 * (3.0 * n).sin(), v: 0.0, u_dot: 0.5 * (7.0 * n + 1.0).sin(), v_dot: 0.0 }
    })?;
    let run = Run::new(chain, state).until(10.0)?.samples(0)?;
    let truth = run.clone().tolerance(1e-13)?.start()?.complete()?.state;

    let names = ["verlet", "strang-linear", "yoshida4-linear", "corrected"];
    println!("{:>7}  {}", "steps", names.map(|name| format!("{name:>16}")).join(""));
    let mut last = [0.0; 4];
    for steps in [320u32, 640, 1280, 2560] {
        for (error, name) in last.iter_mut().zip(names) {
            let run = run.clone().method(Method::named(name)?).step(10.0 / f64::from(steps))?;
            let end = run.start()?.complete()?.state;
            *error = end.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        }
        println!("{steps:7}  {}", last.map(|error| format!("{error:16.1e}")).join(""));
    }
    // Contacts reduce the order of `yoshida4-linear`; `corrected` keeps order four.
    assert!(last[3] < 1e-3 * last[2]);
    Ok(())
}
