//! Eigenvalues of a real matrix by the real Schur form `A = Q S Q^T`; eigenvectors by inverse
//! iteration on `S`.

use nalgebra::{Complex, DMatrix, DVector, Dyn, Schur};

/// Relative sizes below which an entry under the diagonal counts as zero; tried one after the
/// other.
const ZERO: [f64; 3] = [f64::EPSILON, 4.0 * f64::EPSILON, 32.0 * f64::EPSILON];
/// Largest number of iterations for an eigenvalue; two or three are usual.
const MOST: usize = 60;

/// The Schur form.
///
/// The library's iteration has no exceptional shifts and, rarely, cycles; then it is started again
/// with a looser tolerance.
pub(super) fn schur(a: &DMatrix<f64>) -> Option<Schur<f64, Dyn>> {
    ZERO.into_iter().find_map(|zero| Schur::try_new(a.clone(), zero, MOST * a.nrows()))
}

/// An eigenvalue and its eigenvector.
pub(super) type Eigenpair = (Complex<f64>, DVector<Complex<f64>>);

/// Eigenvalues and unit eigenvectors; conjugate pairs are next to each other. `None` if the
/// iteration did not converge.
pub(super) fn eigen(a: &DMatrix<f64>) -> Option<Vec<Eigenpair>> {
    let schur = schur(a)?;
    let values = schur.complex_eigenvalues();
    let (q, s) = schur.unpack();
    let (q, least) = (q.map(Complex::from), f64::EPSILON * s.norm());
    let pairs = values.iter().map(|&value| {
        // One step suffices: the shift is an eigenvalue to rounding, so the solution is the
        // eigenvector to rounding.
        let vector = &q * solve_quasi_triangular(&s, value, least);
        (value, vector.unscale(vector.norm()))
    });
    Some(pairs.collect())
}

/// Solves `(S - shift) x = (1, .., 1)` with `S` upper triangular up to blocks of two; pivots are at
/// least `least`.
fn solve_quasi_triangular(s: &DMatrix<f64>, shift: Complex<f64>, least: f64) -> DVector<Complex<f64>> {
    let floor = |pivot: Complex<f64>| if pivot.norm() < least { Complex::from(least) } else { pivot };
    let mut x = DVector::from_element(s.nrows(), Complex::from(1.0));
    let mut i = s.nrows();
    while i > 0 {
        let pair = i > 1 && s[(i - 1, i - 2)] != 0.0;
        let first = if pair { i - 2 } else { i - 1 };
        let last = s[(i - 1, i - 1)] - shift;
        if pair {
            // Elimination: where the block is nearly a multiple of 1, both pivots are roundings,
            // and a determinant would lose them.
            let corner = s[(first, first)] - shift;
            let mut upper = [corner, Complex::from(s[(first, i - 1)]), x[first]];
            let mut lower = [Complex::from(s[(i - 1, first)]), last, x[i - 1]];
            if lower[0].norm() > upper[0].norm() {
                std::mem::swap(&mut upper, &mut lower);
            }
            let pivot = floor(upper[0]);
            let factor = lower[0] / pivot;
            x[i - 1] = (lower[2] - factor * upper[2]) / floor(lower[1] - factor * upper[1]);
            x[first] = (upper[2] - upper[1] * x[i - 1]) / pivot;
        } else {
            x[i - 1] /= floor(last);
        }
        for j in first..i {
            for k in 0..first {
                let by = x[j] * s[(k, j)];
                x[k] -= by;
            }
        }
        i = first;
        // The vector may grow without bound; only its direction matters.
        let size = x.iter().map(|x| x.norm()).fold(0.0, f64::max);
        if size > 1e100 {
            x.unscale_mut(size);
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
