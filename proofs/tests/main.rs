//! The tests of the package, in one binary.

mod bounds;
mod branches;
mod interval;
mod moments;
mod multipliers;
mod proofs;

use hertzchain_proofs::{
    certificate::{Certificate, Model, Orbit},
    check::{Proof, Refused, check},
    exact::Exact,
};

/// A fraction, or a decimal.
fn exact(text: &str) -> Exact {
    text.parse().ok().or_else(|| Exact::of_double(text.parse().ok()?)).unwrap_or_else(|| panic!("{text}"))
}

fn double(x: Exact) -> f64 {
    x.num() as f64 / x.den() as f64
}

fn model([alpha, rho, omega]: [&str; 3]) -> Model {
    let rho = (rho != "inf").then(|| exact(rho));
    Model { alpha: exact(alpha), kappa: Exact::ONE, rho, omega: exact(omega) }
}

/// A single orbit.
fn single(model: Model, mean: &str, [block, enclosed]: [usize; 2], orbit: Orbit) -> Certificate {
    Certificate { model, mean: exact(mean), to: None, first: None, block, enclosed, orbit, multiplier: None }
}

/// What the checker says of a text.
fn check_text(text: &str) -> Result<Proof, Refused> {
    text.parse().map_err(Refused::Certificate).and_then(|certificate| check(&certificate))
}
