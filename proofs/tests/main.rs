//! The tests of the package, in one binary.

mod bounds;
mod branches;
mod interval;
mod moments;
mod multipliers;
mod proofs;
mod zero;

use hertzchain_proofs::{
    certificate::{Center, Certificate, Model, Orbit},
    check::{Proof, Refused, check_until},
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
fn single(model: Model, mean: &str, [block, enclosed]: [usize; 2], orbit: Orbit, a: Vec<Vec<f64>>) -> Certificate {
    Certificate {
        model,
        mean: exact(mean),
        to: None,
        first: None,
        block,
        enclosed,
        orbit,
        a,
        multiplier: None,
        bloch: Vec::new(),
    }
}

/// A wave of these harmonics.
fn wave(model: Model, [q_over_pi, mean]: [&str; 2], sizes: [usize; 2], a: &[f64]) -> Certificate {
    single(model, mean, sizes, Orbit::Wave { q_over_pi: exact(q_over_pi) }, vec![[&[0.0], a].concat()])
}

/// A breather of mean strain 0, near the profile of a kink.
fn kink(model: Model, sites: usize, center: Center, a: f64) -> Certificate {
    let first = if center == Center::Site { 0.0 } else { 0.5 };
    let row = |i: usize| {
        let n = i as f64 + first;
        vec![if n == 0.0 { -0.2 * a } else { 0.0 }, if i.is_multiple_of(2) { a } else { -a } * n.tanh()]
    };
    single(model, "0", [1, 4], Orbit::Breather { sites, center }, (0..=sites / 2).map(row).collect())
}

/// What the checker says.
fn check(certificate: &Certificate) -> Result<Proof, Refused> {
    check_until(certificate, &|| false)
}

/// What the checker says of a text.
fn check_text(text: &str) -> Result<Proof, Refused> {
    text.parse().map_err(Refused::Certificate).and_then(|certificate| check(&certificate))
}
