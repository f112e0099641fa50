//! End states with errors below 1e-20, computed by the same code in double-double, and the errors
//! of `f64` runs.
//!
//! `cargo test --release --test model references -- --ignored` writes `tests/reference/*.json`. For
//! alpha = 2 and 3 these states agree to 7e-25 with Taylor series of order 45 in 45 digits, stopped
//! at every event, by a separate program.

use hertzchain::{
    chain::{Boundary, Chain, Field, Overlaps, Params},
    integrators::{Real, Regularised, Stepper, dop853::Options, regularised::power},
    study::generic_state,
};
use serde_json::{Value, json};
use std::{fs, path::PathBuf};
use twofloat::TwoFloat;

/// Exponents whose force needs only products and square roots, which double-double computes to its
/// last digits.
const ALPHAS: [f64; 4] = [1.5, 2.0, 2.5, 3.0];
const END: f64 = 12.0;
const BEADS: usize = 6;

fn path(alpha: f64) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("tests/reference/chain-{BEADS}-alpha-{alpha}.json"))
}

fn chain<R: Real>(alpha: f64) -> Chain<R> {
    Chain::new(Params::new(alpha, 1.0, 1.0 / 3.0).unwrap(), Boundary::Free, BEADS).unwrap()
}

/// The state of the order study at its end, by a regularised run.
fn end<R: Real>(alpha: f64, q: u32, tol: f64) -> Vec<R> {
    let start = generic_state(&chain::<f64>(alpha)).unwrap();
    let y0: Vec<R> = start.as_slice().iter().map(|&y| R::of(y)).collect();
    let (field, overlaps) = (Field::new(chain(alpha)), Overlaps::new(chain(alpha)));
    let span = (R::zero(), R::of(END));
    let mut run = Regularised::new(field, overlaps, (alpha, q), &y0, span, Options::new(R::of(tol))).unwrap();
    while !run.done() {
        run.step().unwrap();
    }
    let mut y = y0;
    run.sample(span.1, &mut y);
    y
}

fn distance(a: &[TwoFloat], b: &[TwoFloat]) -> f64 {
    a.iter().zip(b).map(|(a, b)| Real::f64(*a - *b).abs()).fold(0.0, f64::max)
}

fn energy_error(alpha: f64, y: &[TwoFloat]) -> f64 {
    let chain = chain::<TwoFloat>(alpha);
    let start: Vec<TwoFloat> =
        generic_state(&self::chain::<f64>(alpha)).unwrap().as_slice().iter().map(|&y| TwoFloat::from(y)).collect();
    Real::f64(chain.energy(y).total() - chain.energy(&start).total()).abs()
}

/// The stored end state, and its error.
fn stored(alpha: f64) -> (Vec<TwoFloat>, f64) {
    let text = fs::read_to_string(path(alpha)).unwrap();
    let value: Value = serde_json::from_str(&text).unwrap();
    // Numbers are stored as texts, because not every JSON reader is exact to the last bit.
    let part = |part: &Value| part.as_str().unwrap().parse::<f64>().unwrap();
    let number = |pair: &Value| TwoFloat::new_add(part(&pair[0]), part(&pair[1]));
    let state = value["state"].as_array().unwrap().iter().map(number).collect();
    (state, value["error"].as_f64().unwrap())
}

#[test]
#[ignore = "writes tests/reference: run it when the reference itself should change"]
fn regenerate() {
    for alpha in ALPHAS {
        // Two powers of the map and two tolerances: digits in which they agree depend on neither.
        let q = power(alpha, 8);
        let (fine, other) = (end::<TwoFloat>(alpha, q, 1e-25), end::<TwoFloat>(alpha, q + 2, 1e-24));
        let error = distance(&fine, &other);
        println!("alpha = {alpha}: {error:e}, energy {:e}", energy_error(alpha, &fine));
        let state: Vec<_> = fine.iter().map(|y| [format!("{:e}", y.hi()), format!("{:e}", y.lo())]).collect();
        let value = json!({
            "what": "u, v, u', v' as unevaluated sums of two doubles",
            "start": "hertzchain::study::generic_state",
            "alpha": alpha, "kappa": 1.0, "rho": 1.0 / 3.0, "boundary": "free", "beads": BEADS, "t": END,
            "error": error,
            "state": state,
        });
        fs::create_dir_all(path(alpha).parent().unwrap()).unwrap();
        fs::write(path(alpha), serde_json::to_string_pretty(&value).unwrap() + "\n").unwrap();
    }
}

#[test]
fn the_stored_states_conserve_energy_to_twenty_digits() {
    // The energy is an invariant that the method does not enforce.
    for alpha in ALPHAS {
        let (state, error) = stored(alpha);
        assert!(error < 1e-20, "alpha = {alpha}: {error:e}");
        let energy = energy_error(alpha, &state);
        assert!(energy < 1e-20, "alpha = {alpha}: {energy:e}");
        // An error of 1e-19 in the state is seen.
        let mut wrong = state.clone();
        wrong[2 * BEADS] += TwoFloat::from(1e-19);
        assert!(energy_error(alpha, &wrong) > 1e-20);
    }
}

#[test]
fn double_precision_reaches_them_to_its_rounding() {
    for alpha in ALPHAS {
        let (truth, _) = stored(alpha);
        // With landing only, the singular starts after events of a half-integer exponent are left
        // to the error control.
        for (q, bound) in [(1, 1.5e-13), (power(alpha, 8), 1.2e-14)] {
            let y: Vec<TwoFloat> = end::<f64>(alpha, q, 1e-16).into_iter().map(TwoFloat::from).collect();
            let error = distance(&y, &truth);
            println!("alpha = {alpha}, q = {q}: {error:e}");
            assert!(error < bound, "alpha = {alpha}, q = {q}: {error:e}");
        }
    }
}
