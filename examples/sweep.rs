//! A sweep with a store: each point is stored when it is done, and a second sweep computes nothing.
//!
//! `cargo run --release --example sweep`

use hertzchain::{
    Boundary, Chain, Params, Result, Run, State,
    output::Folder,
    sweep::{Engine, Grid},
};

/// Velocity that a struck bead has at `t = 5`, as a share of its initial velocity, for mass ratio
/// `rho`.
fn kept(rho: &f64) -> Result<f64> {
    let chain = Chain::new(Params::new(1.5, 1.0, *rho)?, Boundary::Free, 10)?;
    let mut state = State::rest(&chain);
    state.u_dot_mut()[0] = 1.0;
    let end = Run::new(chain.clone(), state).until(5.0)?.tolerance(1e-9)?.samples(0)?.start()?.complete()?;
    Ok(chain.layout().u_dot(&end.state)[0])
}

pub(crate) fn main() -> Result<()> {
    let folder = Folder::create(std::env::temp_dir().join(format!("hertzchain-sweep-{}", std::process::id())))?;
    let grid: Vec<f64> = (0..8).map(|k| 0.1 * f64::from(1 << k)).collect();
    // Parameters of all rows. A store with other settings belongs to another study.
    let settings = serde_json::json!({"until": 5.0, "tol": 1e-9});
    let study = Grid { store: "kept.store", study: "momentum kept by a struck bead", settings };
    let engine = Engine::threads().keeping(&folder);
    let run = || engine.sweep(&study, &grid, &|_, _| (), kept);
    let (first, second) = (run()?, run()?);
    for (rho, row) in grid.iter().zip(&first.rows) {
        println!("rho = {rho:5.1}: u_1' = {row:?}");
    }
    println!("computed {} points, then {}", first.computed(), second.computed());
    assert_eq!((first.computed(), second.computed()), (8, 0));
    assert_eq!(first.rows, second.rows);
    std::fs::remove_dir_all(folder.path()).expect("the folder is ours");
    Ok(())
}
