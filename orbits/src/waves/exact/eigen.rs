//! Eigenvalues and eigenvectors of a complex matrix, by single-shift QR iteration on the Hessenberg
//! form (EISPACK `comqr2`; Peters and Wilkinson 1970).

use crate::{
    interrupt,
    orbits::{Eigenpair, hessenberg},
};
use nalgebra::{Complex, DMatrix, DVector};

type Matrix = DMatrix<Complex<f64>>;

/// Largest number of iterations for an eigenvalue; two or three are usual.
const MOST: usize = 60;
/// Each time that this many iterations have not found an eigenvalue, the shift is exceptional.
const CYCLE: usize = 10;

/// Eigenvalues and unit eigenvectors. `None` if the iteration did not converge.
pub fn eigen(a: &Matrix) -> Option<Vec<Eigenpair>> {
    let (q, t) = schur(a)?;
    let least = f64::EPSILON * t.norm();
    let vector = |k: usize| {
        let mut x = DVector::zeros(t.nrows());
        x[k] = Complex::ONE;
        for i in (0..k).rev() {
            let sum: Complex<f64> = (i + 1..=k).map(|j| t[(i, j)] * x[j]).sum();
            let pivot = t[(k, k)] - t[(i, i)];
            x[i] = sum / if pivot.norm() < least { Complex::from(least) } else { pivot };
        }
        let x = &q * x;
        (t[(k, k)], x.unscale(x.norm()))
    };
    Some((0..t.nrows()).map(vector).collect())
}

/// Unitary `Q` and triangular `T` with `A = Q T Q^*`. `None` also if the process was asked to end.
fn schur(a: &Matrix) -> Option<(Matrix, Matrix)> {
    let (mut q, mut t) = hessenberg(a)?;
    let (mut bottom, mut since) = (a.nrows().saturating_sub(1), 0);
    while bottom > 0 {
        let top = (1..=bottom).rev().find(|&k| negligible(&mut t, k)).unwrap_or(0);
        if top == bottom {
            (bottom, since) = (bottom - 1, 0);
            continue;
        }
        if since == MOST || interrupt::asked() {
            return None;
        }
        since += 1;
        let shift = match since % CYCLE {
            0 => t[(bottom, bottom)] + t[(bottom, bottom - 1)].norm(),
            _ => nearest_root(&t, bottom),
        };
        sweep(&mut t, &mut q, (top, bottom), shift);
    }
    Some((q, t))
}

/// Whether the entry before the diagonal in row `k` is as small as a rounding error; if so, it is
/// set to zero.
fn negligible(t: &mut Matrix, k: usize) -> bool {
    let beside = t[(k - 1, k - 1)].norm() + t[(k, k)].norm();
    let small = t[(k, k - 1)].norm() <= f64::EPSILON * beside;
    if small {
        t[(k, k - 1)] = Complex::ZERO;
    }
    small
}

/// The eigenvalue of the block of two that ends in row `n` nearer to its last entry.
fn nearest_root(t: &Matrix, n: usize) -> Complex<f64> {
    let half = (t[(n - 1, n - 1)] - t[(n, n)]) * 0.5;
    let product = t[(n, n - 1)] * t[(n - 1, n)];
    let root = (half * half + product).sqrt();
    let far = if (half + root).norm() >= (half - root).norm() { half + root } else { half - root };
    if far == Complex::ZERO { t[(n, n)] } else { t[(n, n)] - product / far }
}

/// One step `T - shift = Q R`, `R Q + shift` on the rows `top..=bottom`.
fn sweep(t: &mut Matrix, q: &mut Matrix, (top, bottom): (usize, usize), shift: Complex<f64>) {
    (top..=bottom).for_each(|k| t[(k, k)] -= shift);
    let turns: Vec<_> = (top..bottom)
        .map(|k| {
            let (a, b) = (t[(k, k)], t[(k + 1, k)]);
            let length = a.norm().hypot(b.norm());
            let (c, s) = if length == 0.0 { (Complex::ONE, Complex::ZERO) } else { (a / length, b / length) };
            for j in k..t.ncols() {
                let (a, b) = (t[(k, j)], t[(k + 1, j)]);
                (t[(k, j)], t[(k + 1, j)]) = (c.conj() * a + s.conj() * b, c * b - s * a);
            }
            (c, s)
        })
        .collect();
    let columns = |matrix: &mut Matrix, k: usize, rows: usize, (c, s): (Complex<f64>, Complex<f64>)| {
        for i in 0..rows {
            let (a, b) = (matrix[(i, k)], matrix[(i, k + 1)]);
            (matrix[(i, k)], matrix[(i, k + 1)]) = (a * c + b * s, b * c.conj() - a * s.conj());
        }
    };
    for (k, &turn) in (top..bottom).zip(&turns) {
        columns(t, k, k + 2, turn);
        columns(q, k, q.nrows(), turn);
    }
    (top..=bottom).for_each(|k| t[(k, k)] += shift);
}
