//! Pieces down to amplitude zero.

use super::{
    branches::{breather, wave},
    check, check_text, double, exact, model,
};
use hertzchain_proofs::{
    certificate::{Center, Certificate, Model, Multiplier, Orbit},
    check::{Gap, Proof, Refused, connected},
    exact::Exact,
    internals::System,
    interval::Interval,
    untrusted::solve::{self, Sizes},
};
use std::f64::consts::PI;

fn other_wave([q, rho, omega, mean]: [&str; 4]) -> Certificate {
    super::wave(model(["3/2", rho, omega]), [q, mean], [1, 4], &[0.002])
}

fn to_zero(near: &Certificate) -> (Certificate, Result<Proof, Refused>) {
    let sizes = if near.is_wave() { Sizes::WAVE_PIECE } else { Sizes::BREATHER_PIECE };
    let piece = solve::near(&Certificate { to: Some([Exact::ZERO; 2]), ..near.clone() }, sizes).unwrap();
    (piece.clone(), check_text(&piece.to_string()))
}

// Truth: the nonlinear dispersion relation of the paper for waves of mean strain 0, where c_alpha =
// Gamma(1/2) Gamma(7/4)/(pi Gamma(9/4)).
#[test]
fn the_frequency_has_the_dispersion_of_the_dps_equation() {
    for (q, rho, omega, square) in [("1/5", "1/3", "2.0005", 4.0), ("4/5", "3", "1.1556", 4.0 / 3.0)] {
        let mu = 4.0 * 0.457_654 * (0.5 * PI * double(exact(q))).sin().powi(2) / square;
        let [from, to] = to_zero(&other_wave([q, rho, omega, "0"])).1.unwrap().zero.unwrap().coefficient;
        assert!(from < mu && mu < to && to - from < 0.02 * mu, "{q}: {from} {mu} {to}");
    }
}

// Truth: the factors in doubles.
#[test]
fn the_factors_down_to_amplitude_zero_are_enclosed() {
    let waves = [wave(["2.001", "0"], 0.0083), other_wave(["4/5", "inf", "1.003", "0.01"])];
    for (node, free) in waves.into_iter().chain([breather("2.005", Center::Site, 0.002)]).zip([2.0, 1.0, 2.0]) {
        let (system, end) = (System::new(&to_zero(&node).0).unwrap(), double(node.model.omega));
        let one = |omega: f64, k: usize| {
            let square = (omega * k as f64).powi(2);
            let rho = node.model.rho.map(double);
            let den = |rho: f64| square * (1.0 + rho - rho * square) / (rho * square - 1.0);
            1.0 / rho.map_or(1.0 - square, den)
        };
        let four = |k: usize| match &node.orbit {
            Orbit::Wave { q_over_pi } => 4.0 * (0.5 * k as f64 * PI * double(*q_over_pi)).sin().powi(2),
            _ => 1.0,
        };
        let [most, slope] = system.decay.map(Interval::hi);
        for omega in [1.0, 0.7, 0.2, 1e-3].map(|share| free + share * (end - free)) {
            let lambda = one(end, 1) / one(omega, 1);
            for k in 1..system.factors.len() {
                let (own, size) = (lambda * one(omega, k) * four(k), one(omega, k).abs());
                let known = system.factors[k] + system.slopes[k] * Interval::exact(2.0 * lambda - 1.0);
                let room = 1e-12 * lambda * size;
                assert!(known.lo() < own + room && known.hi() > own - room, "{k} {lambda}: {own:e} {known:?}");
                assert!(known.hi() - known.lo() < 0.08 * size, "{k}: {own:e} {known:?}");
                let (slope, mean) = (system.slopes[k], 0.5 * (one(end, k) * four(k) - own) / (1.0 - lambda));
                let holds = slope.lo() < mean + 1e-12 * size && slope.hi() > mean - 1e-12 * size;
                assert!(lambda > 0.99 || holds, "mean of the derivative, {k} {lambda}: {mean:e} {slope:?}");
            }
            for k in [0, 1, 50].map(|more| system.factors.len() + more) {
                let own = one(omega, k).abs() * four(k) * (k * k) as f64;
                assert!(lambda * own < most && 0.5 * own < slope, "{k}: {own:e} {most:e} {slope:e}");
            }
        }
    }
}

#[test]
fn what_is_false_down_to_amplitude_zero_is_refused() {
    let node = wave(["2.001", "0"], 0.0083);
    let (piece, proof) = to_zero(&node);
    let refused = |change: &dyn Fn(&mut Certificate)| {
        let mut other = piece.clone();
        change(&mut other);
        check_text(&other.to_string()).unwrap_err()
    };
    // Another amplitude, frequency or mean strain at the end; frequencies from the free one down.
    assert!(matches!(refused(&|it| it.a[0][1] *= 1.05), Refused::Bounds(_)));
    assert!(matches!(refused(&|it| it.model.omega = exact("2.0011")), Refused::Bounds(_)));
    assert!(matches!(refused(&|it| it.mean = exact("0.001")), Refused::Bounds(_)));
    assert!(matches!(refused(&|it| it.model.omega = exact("2")), Refused::Resonance(1)));
    assert!(matches!(refused(&|it| it.model.omega = exact("1.999")), Refused::Resonance(1)));
    let words = |change: &dyn Fn(&mut Certificate)| refused(change).to_string();
    assert!(words(&|it| it.model.rho = Some(Exact::ZERO)).contains("rho must be above 0"));
    assert!(words(&|it| it.first = Some([exact("0.0083"); 2])).contains("first harmonics"));
    assert!(words(&|it| it.multiplier = Some(Multiplier::Doubling { sine: true })).contains("a multiplier is"));
    let text = |to: &str| check_text(&piece.to_string().replace("to zero", to)).unwrap_err().to_string();
    assert!(text("to 0 1").contains("omega must be above 0") && text("to nothing").contains("\"nothing\" is n"));
    // It joins pieces that end where it begins; none begins at amplitude zero.
    let before = |mean: &str| {
        let (model, to) = (Model { omega: exact("2.001001"), ..node.model }, Some([node.model.omega, exact(mean)]));
        let piece = Certificate { model, to, ..solve::near(&node, Sizes::WAVE_PIECE).unwrap() };
        (piece.clone(), check(&piece))
    };
    let zero = (piece.clone(), proof);
    assert_eq!(connected(&[before("0"), zero.clone()]), (2, None));
    assert_eq!(connected(&[before("1e-9"), zero.clone()]), (1, Some(Gap::Nodes)));
    assert_eq!(connected(&[zero, before("0")]), (1, Some(Gap::Nodes)));
    assert_eq!(connected(&[before("0"), to_zero(&breather("2.005", Center::Bond, 0.002))]), (1, Some(Gap::Other)));
}
