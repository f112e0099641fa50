//! The tangent map of contact collocation.

use crate::{
    common::regularised,
    numbers::{direction, error},
};
use hertzchain::{
    chain::{Boundary, Chain, Params},
    integrators::{
        Real, Stepper,
        collocation::{StepControl, Tangent},
        dop853::Options,
    },
    study::generic_state,
};
use nalgebra::DMatrix;
use std::thread;
use twofloat::TwoFloat;

fn chain<R: Real>(alpha: f64, rho: f64, boundary: Boundary, beads: usize) -> Chain<R> {
    Chain::new(Params::new(alpha, 1.0, rho).unwrap(), boundary, beads).unwrap()
}

/// Beads that fly at each other. With walls or on a ring, some contacts are closed at the start.
fn start(chain: &Chain<f64>) -> Vec<f64> {
    match chain.boundary() {
        Boundary::Free => generic_state(chain).unwrap().as_slice().to_vec(),
        _ => direction(chain.layout().dim(), 5).iter().map(|y| 0.3 * y).collect(),
    }
}

fn fine(windows: u64) -> StepControl {
    StepControl::Windows { windows, nodes: 12, neighbours: true }
}

/// `alpha`, `rho`, boundary and number of beads, for either scalar.
type Case = (f64, f64, Boundary, usize);

fn matrix((alpha, rho, boundary, beads): Case, t: f64, control: StepControl) -> DMatrix<f64> {
    let chain = chain(alpha, rho, boundary, beads);
    let y0 = start(&chain);
    let columns = chain.monodromy(&y0, (0.0, t), control).unwrap();
    DMatrix::from_vec(y0.len(), y0.len(), columns)
}

/// `(y(t; y0 + size w) - y(t; y0 - size w))/(2 size)`.
fn difference<R: Real>(case: Case, w: &[f64], t: f64, size: f64, tol: f64) -> Vec<f64> {
    let y0 = start(&chain(case.0, case.1, case.2, case.3));
    let ends: Vec<Vec<R>> = thread::scope(|scope| {
        let run = |size: f64| {
            let y: Vec<R> = y0.iter().zip(w).map(|(&y, &w)| R::of(y) + R::of(w) * R::of(size)).collect();
            let chain = chain(case.0, case.1, case.2, case.3);
            scope.spawn(move || regularised(chain, &y, t, Options::new(R::of(tol))))
        };
        [run(size), run(-size)].map(|run| run.join().unwrap()).into()
    });
    ends[0].iter().zip(&ends[1]).map(|(&a, &b)| (a - b).f64() / (2.0 * size)).collect()
}

fn times(m: &DMatrix<f64>, w: &[f64]) -> Vec<f64> {
    (m * DMatrix::from_column_slice(w.len(), 1, w)).as_slice().to_vec()
}

/// `|M^T J M - J| / |M|^2` in `q, p`, with `p_u = u'`, `p_v = rho v'`.
fn symplectic_defect(case: Case, m: &DMatrix<f64>) -> f64 {
    let (dim, rho, n) = (m.nrows(), case.1, case.3);
    let weight = |i: usize| if dim == 4 * n && i >= 3 * n { rho } else { 1.0 };
    let m = DMatrix::from_fn(dim, dim, |i, j| weight(i) * m[(i, j)] / weight(j));
    let half = dim / 2;
    let j = DMatrix::from_fn(dim, dim, |a, b| f64::from(u8::from(b == a + half)) - f64::from(u8::from(a == b + half)));
    (m.transpose() * &j * &m - j).norm() / m.norm_squared()
}

const THIRD: f64 = 1.0 / 3.0;
/// Ten periods `2 pi/omega` of `kappa = 1`, `rho = 1/3`.
const TEN_PERIODS: f64 = 10.0 * std::f64::consts::PI;

#[test]
fn ten_periods_agree_with_differences_in_double_double() {
    // Truth: central differences of runs by regularised DOP853 in 32 digits. Measured with runs at
    // 1e-20: the error of differences goes with the square of their step from 4e-5 (2.8e-6) to 1e-6
    // (1.7e-9), and varies irregularly below 1e-7 (2e-11 to 2e-12). Hence a step of 1e-9, and runs
    // at 1e-23. Measured: 6.8e-13.
    let case: Case = (1.5, THIRD, Boundary::Free, 21);
    let m = matrix(case, TEN_PERIODS, fine(400));
    let w = direction(m.ncols(), 0);
    let truth = difference::<TwoFloat>(case, &w, TEN_PERIODS, 1e-9, 1e-23);
    let error = error(&times(&m, &w), &truth);
    assert!(error < 1.4e-12, "{error:e}");
}

#[test]
fn it_is_symplectic() {
    // Truth: Hamiltonian flows are symplectic. Measured: 1.8e-16.
    for case in [
        (1.5, THIRD, Boundary::Free, 21),
        (1.5, THIRD, Boundary::Ring, 12),
        (1.5, THIRD, Boundary::Fixed, 12),
        (1.5, 0.0, Boundary::Fixed, 12),
        (1.5, 0.0, Boundary::Ring, 12),
        (1.5, f64::INFINITY, Boundary::Free, 12),
        (2.0, THIRD, Boundary::Fixed, 7),
        (1.2, THIRD, Boundary::Ring, 2),
    ] {
        let m = matrix(case, 12.0, fine(400));
        let defect = symplectic_defect(case, &m);
        println!("{case:?}: {defect:e}, norm {:e}", m.norm());
        assert!(defect < 4e-16, "{case:?}: {defect:e}");
    }
}

#[test]
fn it_agrees_with_differences_for_every_exponent_and_boundary() {
    // Truth: central differences of runs by regularised DOP853, whose error is the square of the
    // step plus the rounding over the step. Measured: at most 1.4e-8.
    let exponents = [1.0, 1.2, 1.5, 2.0, 2.5, 3.0].map(|alpha| (alpha, THIRD, Boundary::Free, 6));
    let boundaries = [
        (1.5, THIRD, Boundary::Fixed, 5),
        (1.5, THIRD, Boundary::Fixed, 1),
        (1.5, THIRD, Boundary::Ring, 5),
        (1.5, THIRD, Boundary::Ring, 2),
        (1.5, THIRD, Boundary::Ring, 1),
        (1.5, THIRD, Boundary::StrainRing, 5),
        (1.5, THIRD, Boundary::StrainRing, 2),
        (1.5, THIRD, Boundary::Free, 2),
        (1.5, THIRD, Boundary::Free, 1),
        (2.0, 0.0, Boundary::Fixed, 4),
        (1.5, f64::INFINITY, Boundary::Ring, 4),
    ];
    for case in exponents.into_iter().chain(boundaries) {
        let m = matrix(case, 6.0, fine(200));
        let w = direction(m.ncols(), 1);
        let error = error(&times(&m, &w), &difference::<f64>(case, &w, 6.0, 1e-5, 1e-15));
        println!("{case:?}: {error:e}");
        assert!(error < 3e-8, "{case:?}: {error:e}");
    }
}

#[test]
fn a_map_that_begins_inside_a_run_is_the_rest_of_the_whole() {
    // Truth: the chain rule. Measured: 2.6e-15.
    let chain = chain::<f64>(1.5, THIRD, Boundary::Fixed, 5);
    let y0 = start(&chain);
    let (mut run, dim) = (chain.collocation(&y0, (0.0, 9.0), fine(300)).unwrap(), y0.len());
    let square = |tangent: &Tangent, run: &_| DMatrix::from_vec(dim, dim, tangent.matrix(run).unwrap());
    let (mut whole, mut halves) = (Tangent::identity(&run).unwrap(), None);
    while !run.done() {
        run.step().unwrap();
        whole.follow(&run).unwrap();
        if let Some((_, rest)) = &mut halves {
            Tangent::follow(rest, &run).unwrap();
        } else if run.stats().steps == 137 {
            halves = Some((square(&whole, &run), Tangent::identity(&run).unwrap()));
        }
    }
    let (first, rest) = halves.unwrap();
    let (rest, whole) = (square(&rest, &run), square(&whole, &run));
    let error = (rest * first - &whole).norm() / whole.norm();
    assert!(error < 6e-15, "{error:e}");
}

#[test]
fn under_a_tolerance_it_errs_by_some_tolerances() {
    // Truth: equal windows; twice as many give the same map. Measured, relative to the map: up to
    // 12 times the tolerance. Most of that is the flow's: the map of a true run that ends elsewhere
    // differs 13 times as much as the run. The rest is the map's own, whose forces have a
    // derivative less.
    let case: Case = (1.5, THIRD, Boundary::Free, 21);
    let truth = matrix(case, TEN_PERIODS, fine(800));
    for tol in [1e-6, 1e-8, 1e-10, 1e-12] {
        let off = (matrix(case, TEN_PERIODS, StepControl::Tolerance(tol)) - &truth).norm() / truth.norm();
        println!("{tol:e}: {off:e}");
        assert!(off < 25.0 * tol, "{tol:e}: {off:e}");
    }
}

#[test]
fn what_cannot_be_followed_is_refused() {
    let chain = |beads| chain::<f64>(1.5, THIRD, Boundary::Free, beads);
    let long = chain(258);
    let run = long.collocation(&vec![0.0; long.layout().dim()], (0.0, 1.0), fine(1)).unwrap();
    assert!(Tangent::identity(&run).unwrap_err().to_string().contains("256 bonds"));
    let y0 = start(&chain(3));
    let mut run = chain(3).collocation(&y0, (0.0, 1.0), fine(10)).unwrap();
    assert!(Tangent::new(&run, &[0.0; 13]).is_err());
    assert!(Tangent::new(&run, &[f64::NAN; 12]).is_err());
    let mut none = Tangent::new(&run, &[]).unwrap();
    let mut tangent = Tangent::identity(&run).unwrap();
    assert!(tangent.follow(&run).is_err(), "nothing done yet");
    run.step().unwrap();
    tangent.follow(&run).unwrap();
    none.follow(&run).unwrap();
    assert!(tangent.follow(&run).is_err(), "twice");
    run.step().unwrap();
    run.step().unwrap();
    assert!(tangent.follow(&run).is_err(), "one left out");
    let y0 = start(&chain(4));
    let other = chain(4).collocation(&y0, (0.0, 1.0), fine(10)).unwrap();
    assert!(tangent.matrix(&other).is_err());
}
