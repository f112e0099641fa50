//! Contacts: when each bond closes and opens, and the speed of a solitary wave.
//!
//! `cargo run --release --example contacts`

use hertzchain::{Boundary, Chain, Params, Result, Run, State};

pub(crate) fn main() -> Result<()> {
    // Spheres that touch at rest, without resonators (kappa = rho = 0): Nesterenko's wave.
    let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Free, 60)?;
    let mut state = State::rest(&chain);
    state.u_dot_mut()[0] = 1.0;
    let end = Run::new(chain, state).until(60.0)?.tolerance(1e-10)?.contacts().start()?.complete()?;

    let contacts = end.contacts.unwrap_or_default();
    println!("bond    onset   release  duration  largest overlap  impulse");
    for contact in contacts.iter().step_by(8) {
        let (Some(onset), Some(release)) = (contact.onset, contact.release) else { continue };
        let (bond, overlap, impulse) = (contact.bond, contact.largest_overlap, contact.impulse);
        println!("{bond:4} {onset:8.3}  {release:8.3}  {:8.4}  {overlap:15.6}  {impulse:.6}", release - onset);
    }
    // The front goes from bond 30 to bond 50 at a steady speed.
    let onset = |bond: usize| contacts.iter().find(|contact| contact.bond == bond).and_then(|contact| contact.onset);
    let (Some(first), Some(last)) = (onset(30), onset(50)) else { panic!("the pulse has passed both bonds") };
    let speed = 20.0 / (last - first);
    println!("speed {speed:.4} beads a unit of time");
    // The speed of the pulse grows with the fifth root of the bead velocity, so it is of the order
    // of one bead a unit of time here.
    assert!((0.7..1.1).contains(&speed), "{speed}");
    Ok(())
}
