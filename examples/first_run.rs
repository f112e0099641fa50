//! A first run: a chain of beads is struck at one end, and a pulse runs along it.
//!
//! `cargo run --release --example first_run`

use hertzchain::{Result, Run, Scene};

pub(crate) fn main() -> Result<()> {
    // A built-in scene consists of chain, initial state and span. Its run chooses the method by
    // default.
    let scene = Scene::load("impact")?;
    let run: Run = scene.run();
    let (method, setting) = run.choice()?;
    println!("{} by {}, {setting:?}", scene.name(), method.name());

    let end = run.start()?.complete()?;
    println!("t = {}, largest relative error of the energy {:.1e}", end.t, end.energy_error.unwrap_or_default());
    assert!(end.energy_error.is_some_and(|error| error < 1e-9));

    // The beads that have moved so far.
    let moved = scene.chain().layout().u(&end.state).iter().filter(|u| u.abs() > 1e-9).count();
    println!("{moved} of {} beads have moved", scene.chain().sites());
    assert!(moved > scene.chain().sites() / 2);
    Ok(())
}
