//! Bands of periodic chains against closed forms.

use hertzchain::{
    chain::{Boundary, Chain, Details, Params},
    orbits::Bands,
};
use std::f64::consts::PI;

/// The largest error of squares of frequencies over 40 phases, as a share of the largest square.
fn error(bands: &Bands, squares: impl Fn(f64) -> Vec<f64>) -> f64 {
    let mut worst = [0.0_f64; 2];
    for theta in (0..=40).map(|k| PI * f64::from(k) / 40.0) {
        let (got, mut want) = (bands.at(theta), squares(theta));
        want.sort_by(f64::total_cmp);
        assert_eq!(got.len(), want.len());
        for (got, want) in got.into_iter().zip(want) {
            worst = [worst[0].max((got * got - want).abs()), worst[1].max(want)];
        }
    }
    worst[0] / worst[1]
}

#[test]
fn bands_of_chains_with_resonators_are_the_closed_form() {
    // Truth: rho w^4 - (rho (K s + kappa) + kappa) w^2 + kappa K s = 0, with w the frequency, s = 4
    // sin(theta/2)^2 and K = alpha d^(alpha - 1); without resonators w^2 = K s, between fixed ones w^2
    // = K s + kappa.
    for (alpha, kappa, rho, boundary) in [
        (1.5, 0.7, 2.3, Boundary::Fixed),
        (3.0, 1.9, 0.04, Boundary::Ring),
        (2.0, 0.0, 0.0, Boundary::Fixed),
        (1.2, 0.5, f64::INFINITY, Boundary::Fixed),
    ] {
        let chain = Chain::new(Params::new(alpha, kappa, rho).unwrap(), boundary, 12).unwrap();
        let chain = chain.precompressed(0.3).unwrap();
        let bands = Bands::new(&chain).unwrap_or_else(|why| panic!("{alpha} {rho}: {why}"));
        assert_eq!(bands.cell(), 1);
        // Where the closed form is zero, so are the bands, and not the root of a rounding error.
        assert!(rho == f64::INFINITY || bands.at(0.0)[0] == 0.0, "{}", bands.at(0.0)[0]);
        let off = error(&bands, |theta| {
            let contact = alpha * 0.3_f64.powf(alpha - 1.0) * 4.0 * (0.5 * theta).sin().powi(2);
            if rho == 0.0 || rho.is_infinite() {
                return vec![contact + if rho == 0.0 { 0.0 } else { kappa }];
            }
            let half = 0.5 * (contact + kappa + kappa / rho);
            let root = (half * half - kappa * contact / rho).sqrt();
            vec![half + root, kappa * contact / rho / (half + root)]
        });
        assert!(off < 1e-13, "{alpha} {rho} {boundary:?}: {off:e}");
    }
}

#[test]
fn bands_of_dimers_are_the_closed_form_wherever_the_cell_begins() {
    // Truth: with contacts k_1 and k_2 in turn and masses m and M, w^2 = a -+ (a^2 - 4 k_1 k_2
    // sin(theta/2)^2/(m M))^(1/2), a = (k_1 + k_2)(1/m + 1/M)/2.
    let (m, big, [k1, k2]) = (0.4, 1.3, [1.5 * 0.8_f64, 1.5 * 2.5]);
    for (boundary, skip) in [(Boundary::Fixed, 0), (Boundary::Fixed, 1), (Boundary::Ring, 0), (Boundary::Ring, 1)] {
        let chain = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), boundary, 10).unwrap();
        let bonds = chain.touching();
        let turn = |n: usize| (n + skip).is_multiple_of(2);
        let mass = (0..10).map(|n| if turn(n) { m } else { big }).collect();
        // Overlaps of one force, F = A d^(3/2) = 1; stiffness 3/2 A d^(1/2).
        let a = |k: f64| (k / 1.5).powf(1.5);
        let contact: Vec<f64> = bonds.map(|n| a(if turn(n) { k1 } else { k2 })).collect();
        let overlap = contact.iter().map(|a| a.powf(-2.0 / 3.0)).collect();
        let chain = chain.with(&Details { mass, contact, overlap, ..Details::default() }).unwrap();
        let bands = Bands::new(&chain).unwrap();
        assert_eq!(bands.cell(), 2);
        let off = error(&bands, |theta| {
            let half = 0.5 * (k1 + k2) * (1.0 / m + 1.0 / big);
            let root = (half * half - 4.0 * k1 * k2 * (0.5 * theta).sin().powi(2) / (m * big)).sqrt();
            vec![half + root, half - root]
        });
        assert!(off < 1e-13, "{boundary:?} {skip}: {off:e}");
        let [acoustic, optical] = bands.edges()[..] else { panic!() };
        assert!(acoustic[0] == 0.0 && acoustic[1] < optical[0] && optical[0] < optical[1]);
    }
}

#[test]
fn a_load_of_the_whole_chain_holds_beads_that_differ() {
    // Truth: the edges of a dimer with one kind of contacts, w^2 = 0, 2 k/M, 2 k/m, 2 k (1/m + 1/M).
    let chain =
        Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Fixed, 9).unwrap().precompressed(0.5).unwrap();
    let mass = (0..9).map(|n| [1.0, 0.3][n % 2]).collect();
    let bands = Bands::new(&chain.with(&Details { mass, ..Details::default() }).unwrap()).unwrap();
    let k = 1.5 * 0.5_f64.sqrt();
    let want = [[0.0, 2.0 * k], [2.0 * k / 0.3, 2.0 * k * (1.0 + 1.0 / 0.3)]];
    for (got, want) in bands.edges().into_iter().zip(want) {
        assert!((0..2).all(|i| (got[i] * got[i] - want[i]).abs() < 1e-13 * want[1]), "{got:?} {want:?}");
    }
}

#[test]
fn chains_without_a_cell_or_without_forces_are_refused() {
    let chain = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Fixed, 9).unwrap();
    assert!(Bands::new(&chain).unwrap_err().to_string().contains("not held"));
    let mut mass = vec![1.0; 9];
    mass[4] = 0.5;
    let defect = chain.precompressed(0.1).unwrap().with(&Details { mass, ..Details::default() }).unwrap();
    assert!(Bands::new(&defect).unwrap_err().to_string().contains("a cell of at most 85 beads repeats"));
}
