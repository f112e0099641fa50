//! Kernels of orbits, waves and breathers: eigenvalues, transforms, continuation, the centre of a
//! dip.

use hertzchain_orbits::{
    Error, Result,
    internals::{
        BranchState, FARTHEST, Family, centre, complex_eigen, eigenvalues, follow, solve_quasi_triangular, strays,
    },
    orbits::{End, Equations, NewtonStep, Range, Solution},
};
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;

/// `p = z^3/3 - z`, whose fold at `p = 2/3`, `z = -1` has another sheet above, `z > 2`.
/// `turning`: whether only what would be a jump with the shortest step strays.
struct Sheets {
    turning: bool,
}

impl Family for Sheets {
    fn equations(&self, z: &[f64], p: f64, derivative: bool) -> Result<Equations> {
        let jacobian = DMatrix::from_element(1, usize::from(derivative), z[0] * z[0] - 1.0);
        Ok(Equations { residual: DVector::from_element(1, z[0].powi(3) / 3.0 - z[0] - p), jacobian })
    }

    fn solve(&self, seed: &[f64], p: f64) -> Result<Solution> {
        let (mut z, mut newton) = (seed[0], Vec::new());
        while newton.len() < 30 {
            let Equations { residual, jacobian } = self.equations(&[z], p, true)?;
            let (residual, step) = (residual[0], residual[0] / jacobian[0]);
            newton.push(NewtonStep { residual: residual.abs(), step: step.abs() });
            z -= step;
            if step.abs() < 1e-12 {
                return Ok(Solution { z: vec![z], p, residual: 0.0, newton });
            }
        }
        Err(Error::Stalled { steps: newton.len(), best: None })
    }

    fn strays(&self, chord: f64, predictor: f64, newton: &[NewtonStep]) -> bool {
        if self.turning { chord > FARTHEST * predictor } else { strays(chord, predictor, newton) }
    }

    fn solved(&self, _z: &[f64], _p: f64) -> f64 {
        1e-12
    }
}

#[test]
fn a_branch_passes_its_folds_and_does_not_jump_to_another_sheet() {
    // Truth: the closed form; z grows along the branch. The sheets are 3 apart at a fold.
    for turning in [false, true] {
        let start = (vec![-2.5], (-2.5f64).powi(3) / 3.0 + 2.5);
        let state = BranchState { back: start.1, previous: None, last: start, ds: 0.2, points: 1 };
        let range = Range { to: 2.0, step: 0.3, most_points: 2000 };
        let (mut last, mut between) = (-2.5, 0);
        let end = follow(&Sheets { turning }, state, range, 1.0, &mut |found, _, _| {
            let z = found.z[0];
            assert!(z > last && z < last + 1.5 && (z.powi(3) / 3.0 - z - found.p).abs() < 1e-11, "{found:?}");
            (last, between) = (z, between + usize::from(z.abs() < 1.0));
            Ok(None)
        });
        assert!(matches!(end, Ok(End::Reached)) && between > 2, "{end:?} {between}");
    }
}

/// The largest distance of an entry of `truth` from the nearest eigenvalue; each counts once.
fn apart(mut found: Vec<Complex<f64>>, truth: &[Complex<f64>]) -> f64 {
    assert_eq!(found.len(), truth.len());
    let nearest = |value: &Complex<f64>| {
        let order = |a: &usize, b: &usize| (found[*a] - value).norm().total_cmp(&(found[*b] - value).norm());
        let nearest = (0..found.len()).min_by(order).unwrap();
        (found.swap_remove(nearest) - value).norm()
    };
    truth.iter().map(nearest).fold(0.0, f64::max)
}

// Truth: the roots of unity. Without exceptional shifts all shifts are 0, and each step returns
// the same matrix.
#[test]
fn a_cycle_of_the_iteration_is_broken_by_exceptional_shifts() {
    for n in [3, 4, 8, 41] {
        let turn = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == (j + 1) % n)));
        let roots: Vec<_> = (0..n).map(|k| Complex::from_polar(1.0, TAU * k as f64 / n as f64)).collect();
        let off = apart(eigenvalues(&turn).unwrap(), &roots);
        assert!(off < 1e-14, "{n}: {off:e}");
    }
}

// Truth: an orthogonal similarity of `1 + delta B` with the eigenvalues of `B` given. Measured:
// 9e-15. The iteration of `nalgebra` does not end for the last two.
#[test]
fn eigenvalues_that_differ_little_from_each_other_are_found() {
    let n = 40;
    let axis = DVector::from_fn(n, |i, _| (1.0 + 2.4 * i as f64).cos()).normalize();
    let turn = DMatrix::identity(n, n) - &axis * axis.transpose() * 2.0;
    for delta in [1.0, 1e-3, 1e-6, 1e-9, 1e-12] {
        let mut b = DMatrix::identity(n, n);
        let mut truth = Vec::new();
        for k in (0..n).step_by(2) {
            let (re, im) = ((0.3 * k as f64).sin(), if k % 4 == 0 { 0.0 } else { 0.01 * k as f64 });
            let spread = if im == 0.0 { 0.5 } else { 0.0 };
            b[(k, k)] += delta * (re + spread);
            b[(k + 1, k + 1)] += delta * (re - spread);
            (b[(k, k + 1)], b[(k + 1, k)]) = (delta * im, -delta * im);
            truth.extend([1.0, -1.0].map(|sign| Complex::new(1.0 + delta * (re + sign * spread), delta * sign * im)));
        }
        let a = &turn * b * &turn;
        let off = apart(eigenvalues(&a).unwrap(), &truth);
        assert!(off < 2e-14, "{delta}: {off:e}");
    }
}

#[test]
fn two_eigenvalues_that_roundings_made_complex_have_eigenvectors() {
    // A multiple of 1 up to roundings of three sizes, between other eigenvalues.
    for delta in [1e-14, 1e-15, 1e-18] {
        #[rustfmt::skip]
        let s = DMatrix::from_row_slice(5, 5, &[
            -2.0, 0.6, 0.1, 0.3, 0.2,
            0.0, 1.0, delta, 0.3, 0.2,
            0.0, -delta, 1.0, 0.5, 0.7,
            0.0, 0.0, 0.0, 2.0, 0.4,
            0.0, 0.0, 0.0, 0.0, 3.0,
        ]);
        let value = Complex::new(1.0, delta);
        let vector = solve_quasi_triangular(&s, value, f64::EPSILON * s.norm());
        let off = s.map(Complex::from) * &vector - &vector * value;
        assert!(off.norm() < 1e-13 * vector.norm(), "{delta}: {:e}", off.norm() / vector.norm());
    }
}

// Truth: a unitary similarity of a triangular matrix, whose eigenvalues are its diagonal; and
// the residuals. Measured: 2e-15 and 7e-15 where eigenvalues are apart, residuals below 3e-15
// in all.
#[test]
fn eigenvalues_of_a_turned_triangular_matrix_are_its_diagonal() {
    let n = 30;
    let wave = |k: usize, f: f64| Complex::from_polar(1.0, f * k as f64);
    let axis = DVector::from_fn(n, |i, _| wave(i * i, 0.7)).normalize();
    let turn = DMatrix::<Complex<f64>>::identity(n, n) - &axis * axis.adjoint() * Complex::from(2.0);
    for cluster in [1.0, 1e-4, 1e-8] {
        // Clusters of four: the multipliers of a small wave.
        let value = |k: usize| wave(k / 4, 0.8) * (1.0 + cluster * wave(k, 1.9));
        let t = DMatrix::<Complex<f64>>::from_fn(n, n, |i, j| if i == j { value(i) } else { Complex::ZERO });
        let a = &turn * t * &turn;
        let mut pairs = complex_eigen(&a).unwrap();
        let residual = pairs.iter().map(|(value, z)| (&a * z - z * *value).norm()).fold(0.0, f64::max);
        let mut off = 0.0_f64;
        for k in 0..n {
            let apart = |i: &usize| (pairs[*i].0 - value(k)).norm();
            let nearest = (0..pairs.len()).min_by(|i, j| apart(i).total_cmp(&apart(j))).unwrap();
            off = off.max(apart(&nearest));
            pairs.swap_remove(nearest);
        }
        assert!(residual < 2e-14 && off < 2e-14, "{cluster}: {residual:e} {off:e}");
    }
}

// Truth: the roots of unity; without exceptional shifts the iteration repeats itself.
#[test]
fn a_cycle_of_the_complex_iteration_is_broken_by_exceptional_shifts() {
    for n in [2, 3, 8, 41] {
        let turn = DMatrix::<Complex<f64>>::from_fn(n, n, |i, j| Complex::from(f64::from(u8::from(i == (j + 1) % n))));
        for (value, _) in complex_eigen(&turn).unwrap() {
            assert!((value.powu(n as u32) - 1.0).norm() < 1e-12, "{n}: {value}");
        }
    }
}

#[test]
fn a_gap_is_found_and_followed_round_the_ring() {
    let gap = |at: usize| -> Vec<f64> { (0..41).map(|i| if i == at { 0.0 } else { 1.0 }).collect() };
    assert!((centre(&gap(20), 1.0, 20.0) - 20.0).abs() < 1e-12);
    assert!((centre(&gap(40), 1.0, 39.0) - 40.0).abs() < 1e-12);
    // One further is the first site again.
    assert!((centre(&gap(0), 1.0, 40.0) - 41.0).abs() < 1e-12);
}
