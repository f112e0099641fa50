//! A chain and an initial state of your own, states at given times, and a comparison of two
//! methods.
//!
//! `cargo run --release --example own_chain`

use hertzchain::{Boundary, Chain, Method, Params, Result, Run, State, chain::Site};

pub(crate) fn main() -> Result<()> {
    // alpha = 3/2 (spheres), springs kappa = 1, resonators of a third of a bead's mass; walls at
    // both ends.
    let params = Params::new(1.5, 1.0, 1.0 / 3.0)?;
    let chain = Chain::new(params, Boundary::Fixed, 12)?;
    // One bead and its resonator are displaced together, towards their right neighbour.
    let at = |n: usize| if n == 3 { 0.2 } else { 0.0 };
    let state = State::from_fn(&chain, |n| Site { u: at(n), v: at(n), u_dot: 0.0, v_dot: 0.0 })?;

    let run = Run::new(chain.clone(), state).until(20.0)?;
    // `collocation` keeps a tolerance over the whole run; `corrected` needs one force sweep a step.
    let exact = run.clone().method(Method::Collocation).tolerance(1e-11)?;
    let fast = run.method(Method::CORRECTED).step(20.0 / 1280.0)?;
    let times = [5.0, 10.0, 20.0];
    for ((t, exact), fast) in times.iter().zip(exact.at(&times)?).zip(fast.at(&times)?) {
        let (exact, fast) = (exact?, fast?);
        let gap = exact.u().iter().zip(fast.u()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let energy = chain.energy(exact.as_slice()).total();
        println!("t = {t:4}: energy {energy:.12}, the methods differ by {gap:.1e}");
        assert!(gap < 1e-6);
    }
    Ok(())
}
