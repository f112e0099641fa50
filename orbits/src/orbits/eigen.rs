//! Eigenvalues of a real matrix by the real Schur form `A = Q S Q^T`; eigenvectors by inverse
//! iteration on `S`.
//!
//! The iteration is Francis' double shift on the Hessenberg form (EISPACK `hqr2`, Peters and
//! Wilkinson 1970). Its first column `(S - a)(S - b) e_1`, with shifts `a` and `b`, is formed from
//! differences of entries. `nalgebra`, whose iteration was used here before, forms it from products
//! of entries; where all eigenvalues are close to each other that loses every digit of it, and the
//! iteration does not end. Orbits of small amplitude have such matrices: all `tau` are near 1.

use crate::interrupt;
use nalgebra::{Complex, ComplexField, DMatrix, DVector, Hessenberg};
/// Largest number of iterations for an eigenvalue; two or three are usual.
const MOST: usize = 60;
/// Every so many iterations without an eigenvalue the shifts are exceptional.
const CYCLE: usize = 10;

/// Rows of matrices whose decompositions take so long that a signal must not wait for them.
const LARGE: usize = 256;

/// The result of `work` on matrices of so many rows; `None` as [`interrupt::unless_asked`].
pub(super) fn unless_asked<T: Send + 'static>(rows: usize, work: impl FnOnce() -> T + Send + 'static) -> Option<T> {
    if rows <= LARGE { Some(work()) } else { interrupt::unless_asked(work) }
}

/// Unitary `Q` and the Hessenberg form `H` with `A = Q H Q^*`; `None` as `unless_asked`.
pub fn hessenberg<T: ComplexField>(a: &DMatrix<T>) -> Option<(DMatrix<T>, DMatrix<T>)> {
    let (rows, a) = (a.nrows(), a.clone());
    match rows {
        0..=2 => Some((DMatrix::identity(rows, rows), a)),
        _ => unless_asked(rows, || Hessenberg::new(a).unpack()),
    }
}

/// `Q` and `S` of the Schur form: `S` is upper triangular up to blocks of two, which have complex
/// eigenvalues. `None` if the iteration did not converge, or the process was asked to end.
fn schur(a: &DMatrix<f64>) -> Option<[DMatrix<f64>; 2]> {
    let (mut q, mut s) = hessenberg(a)?;
    let (mut last, mut since) = (a.nrows(), 0);
    while last > 0 {
        let bottom = last - 1;
        let top = top_of_block(&mut s, bottom);
        match bottom - top {
            0 => (last, since) = (last - 1, 0),
            1 => {
                split(&mut s, &mut q, bottom);
                (last, since) = (last - 2, 0);
            }
            _ if since == MOST || interrupt::asked() => return None,
            _ => {
                since += 1;
                sweep(&mut s, &mut q, (top, bottom), since % CYCLE == 0);
            }
        }
    }
    Some([q, s])
}

/// First row of the block without zeros below the diagonal that ends in row `bottom`; the entry
/// before it, which is a rounding, becomes zero.
fn top_of_block(s: &mut DMatrix<f64>, bottom: usize) -> usize {
    let mut top = bottom;
    while top > 0 {
        let beside = s[(top - 1, top - 1)].abs() + s[(top, top)].abs();
        let size = if beside == 0.0 { s.amax() } else { beside };
        if s[(top, top - 1)].abs() <= f64::EPSILON * size {
            s[(top, top - 1)] = 0.0;
            break;
        }
        top -= 1;
    }
    top
}

/// Half the difference of the diagonal entries of the block of two that ends in row `n`, and the
/// square of half the difference of its eigenvalues.
fn halves(s: &DMatrix<f64>, n: usize) -> (f64, f64) {
    let half = 0.5 * (s[(n - 1, n - 1)] - s[(n, n)]);
    (half, half * half + s[(n, n - 1)] * s[(n - 1, n)])
}

/// Makes a block of two with real eigenvalues triangular.
fn split(s: &mut DMatrix<f64>, q: &mut DMatrix<f64>, n: usize) {
    let (half, square) = halves(s, n);
    if square < 0.0 {
        return;
    }
    // The eigenvalue farther from the last entry, minus that entry: no cancellation.
    let far = half + square.sqrt().copysign(half);
    let vector = [far, s[(n, n - 1)]];
    let norm = vector[0].hypot(vector[1]);
    let [cos, sin] = vector.map(|entry| entry / norm);
    for j in n - 1..s.ncols() {
        let (a, b) = (s[(n - 1, j)], s[(n, j)]);
        (s[(n - 1, j)], s[(n, j)]) = (cos * a + sin * b, cos * b - sin * a);
    }
    let columns = |matrix: &mut DMatrix<f64>, rows: usize| {
        for i in 0..rows {
            let (a, b) = (matrix[(i, n - 1)], matrix[(i, n)]);
            (matrix[(i, n - 1)], matrix[(i, n)]) = (cos * a + sin * b, cos * b - sin * a);
        }
    };
    columns(s, n + 1);
    columns(q, s.nrows());
    s[(n, n - 1)] = 0.0;
}

/// One step of the double-shift iteration on the rows `top..=bottom`, at least three.
fn sweep(s: &mut DMatrix<f64>, q: &mut DMatrix<f64>, (top, bottom): (usize, usize), exceptional: bool) {
    // Shifts are the eigenvalues of [[a, .], [., b]] with `product` of the other two entries.
    let (a, b, product) = if exceptional {
        let size = s[(bottom, bottom - 1)].abs() + s[(bottom - 1, bottom - 2)].abs();
        let shift = s[(bottom, bottom)] + 0.75 * size;
        (shift, shift, -0.4375 * size * size)
    } else {
        let both = s[(bottom, bottom - 1)] * s[(bottom - 1, bottom)];
        (s[(bottom, bottom)], s[(bottom - 1, bottom - 1)], both)
    };
    let corner = s[(top, top)];
    let (to_a, to_b, below) = (a - corner, b - corner, s[(top + 1, top)]);
    let mut column = [
        (to_a * to_b - product) / below + s[(top, top + 1)],
        s[(top + 1, top + 1)] - corner - to_a - to_b,
        s[(top + 2, top + 1)],
    ];
    for k in top..bottom {
        let rows = if k + 1 == bottom { 2 } else { 3 };
        if k > top {
            column = [s[(k, k - 1)], s[(k + 1, k - 1)], if rows == 3 { s[(k + 2, k - 1)] } else { 0.0 }];
        }
        reflect(s, q, (k, rows), column, k.saturating_sub(1).max(top), bottom);
    }
}

/// The reflection that maps `column` to a multiple of the first unit vector, from both sides on the
/// rows and columns `k..k + rows` of `s`, and on those columns of `q`.
fn reflect(
    s: &mut DMatrix<f64>,
    q: &mut DMatrix<f64>,
    (k, rows): (usize, usize),
    column: [f64; 3],
    first: usize,
    bottom: usize,
) {
    let largest = column.iter().fold(0.0, |size: f64, entry| size.max(entry.abs()));
    if largest == 0.0 {
        return;
    }
    let mut axis = column.map(|entry| entry / largest);
    let norm = axis.iter().map(|entry| entry * entry).sum::<f64>().sqrt().copysign(axis[0]);
    axis[0] += norm;
    // The reflection is 1 - axis axis^T / (norm axis[0]).
    let scale = (norm * axis[0]).recip();
    for j in first..s.ncols() {
        let by = scale * (0..rows).map(|i| axis[i] * s[(k + i, j)]).sum::<f64>();
        (0..rows).for_each(|i| s[(k + i, j)] -= by * axis[i]);
    }
    let columns = |matrix: &mut DMatrix<f64>, height: usize| {
        for i in 0..height {
            let by = scale * (0..rows).map(|j| axis[j] * matrix[(i, k + j)]).sum::<f64>();
            (0..rows).for_each(|j| matrix[(i, k + j)] -= by * axis[j]);
        }
    };
    columns(s, (k + 4).min(bottom + 1));
    columns(q, s.nrows());
    if first < k {
        (1..rows).for_each(|i| s[(k + i, first)] = 0.0);
    }
}

/// An eigenvalue and its eigenvector.
pub type Eigenpair = (Complex<f64>, DVector<Complex<f64>>);

/// Eigenvalues and unit eigenvectors; conjugate pairs are next to each other. `None` if the
/// iteration did not converge.
pub fn eigen(a: &DMatrix<f64>) -> Option<Vec<Eigenpair>> {
    let [q, s] = schur(a)?;
    let (q, least) = (q.map(Complex::from), f64::EPSILON * s.norm());
    let pairs = diagonal(&s).into_iter().map(|value| {
        // One step suffices: the shift is an eigenvalue to rounding, so the solution is the
        // eigenvector to rounding.
        let vector = &q * solve_quasi_triangular(&s, value, least);
        (value, vector.unscale(vector.norm()))
    });
    Some(pairs.collect())
}

/// Eigenvalues; conjugate pairs are next to each other. `None` if the iteration did not converge.
pub fn eigenvalues(a: &DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    schur(a).map(|[_, s]| diagonal(&s))
}

/// Eigenvalues of the Schur form `S`.
fn diagonal(s: &DMatrix<f64>) -> Vec<Complex<f64>> {
    let mut values = Vec::with_capacity(s.nrows());
    while values.len() < s.nrows() {
        let n = values.len() + 1;
        if n < s.nrows() && s[(n, n - 1)] != 0.0 {
            let (half, square) = halves(s, n);
            let value = Complex::new(s[(n, n)] + half, (-square).sqrt());
            values.extend([value, value.conj()]);
        } else {
            values.push(Complex::from(s[(n - 1, n - 1)]));
        }
    }
    values
}

/// Solves `(S - shift) x = (1, .., 1)` with `S` upper triangular up to blocks of two; pivots are at
/// least `least`.
pub fn solve_quasi_triangular(s: &DMatrix<f64>, shift: Complex<f64>, least: f64) -> DVector<Complex<f64>> {
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
