//! End states with errors below 1e-30 by a program of its own, `tests/reference/chain.py`, which
//! has the equations of motion written out and shares no code with this library, and the errors of
//! runs in double-double and in `f64`.

use hertzchain::{
    chain::{Boundary, Chain, Field, Overlaps, Params},
    integrators::{Real, Regularised, Stepper, dop853::Options, regularised::common_power},
    study::generic_state,
};
use serde_json::Value;
use std::{fs, path::PathBuf};
use twofloat::TwoFloat;

/// Exponents whose force needs only products and square roots, which integers and double-double
/// compute to their last digits.
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
fn the_stored_states_conserve_energy_to_thirty_digits() {
    // The energy is an invariant that the program does not enforce. Measured: 3.1e-33, which is
    // rounding.
    for alpha in ALPHAS {
        let (state, error) = stored(alpha);
        assert!(error < 1e-30, "alpha = {alpha}: {error:e}");
        let energy = energy_error(alpha, &state);
        println!("alpha = {alpha}: {energy:e}");
        assert!(energy < 1e-32, "alpha = {alpha}: {energy:e}");
        // An error of 1e-30 in the state is seen.
        let mut wrong = state.clone();
        wrong[2 * BEADS] += TwoFloat::from(1e-30);
        assert!(energy_error(alpha, &wrong) > 1e-32);
    }
}

#[test]
fn double_double_reaches_them_to_twenty_digits() {
    for alpha in ALPHAS {
        let error = distance(&end::<TwoFloat>(alpha, common_power(&[alpha], 8), 1e-22), &stored(alpha).0);
        println!("alpha = {alpha}: {error:e}");
        // Measured: 2.4e-20.
        assert!(error < 5e-20, "alpha = {alpha}: {error:e}");
    }
}

#[test]
fn double_precision_reaches_them_to_its_rounding() {
    for alpha in ALPHAS {
        let (truth, _) = stored(alpha);
        // With landing only, the singular starts after events of a half-integer exponent are left
        // to the error control.
        for (q, bound) in [(1, 1.5e-13), (common_power(&[alpha], 8), 1.2e-14)] {
            let y: Vec<TwoFloat> = end::<f64>(alpha, q, 1e-16).into_iter().map(TwoFloat::from).collect();
            let error = distance(&y, &truth);
            println!("alpha = {alpha}, q = {q}: {error:e}");
            assert!(error < bound, "alpha = {alpha}, q = {q}: {error:e}");
        }
    }
}
