//! An a-posteriori bound for solutions of shooting equations, after Newton and Kantorovich.
//!
//! | symbol | meaning |
//! |---|---|
//! | `F(z) = P Phi_t(z) + linear` | shooting equations; `P` picks entries of the state at `t` |
//! | `M(s)` | derivative of the state at `s` by that at 0; `M_x` its rows of strains of contacts |
//! | `V` | orthonormal basis of the left null space of `F'(z)` |
//! | `A` | inverse of `[F'(z), V]`, as computed |
//! | `d` | `|1 - A [F'(z), V]|`, the defect of the computed inverse |
//! | `p` | `min(alpha - 1, 1)`: the tangent map is Hölder continuous with this exponent |
//!
//! All norms are largest entries, with strains in units of the amplitude and velocities in units of
//! the amplitude times the frequency.
//!
//! # The theorem
//!
//! `F` has more equations than unknowns, since conservation laws make some depend on the others.
//! The square system `G(z, a) = F(z) + V a = 0` has as many unknowns as equations; the same
//! conservation laws say that `a = 0` at its solution. Let `eta = |A F(z)|`, and let
//! `|A (F'(w) - F'(z))| <= kappa |w - z|^p` near `z`. The map `w -> w - A G(w)` takes the ball of
//! radius `r` about `z` into itself and contracts there if
//!
//! `eta + d r + kappa r^{1+p}/(1+p) <= r`, `d + kappa r^p < 1`;
//!
//! then the ball holds exactly one solution (Keller 1970 has the theorem for `p < 1`, with `d =
//! 0`).
//!
//! # The constant
//!
//! By the equation of the tangent map, `F'(w) - F'(z) = P int M(t, s) (J_w - J_z) M_w(s) ds`. The
//! coefficient `alpha (-x)_+^{alpha-1}` of a contact changes by at most `alpha |dx|^p` for `alpha
//! <= 2`, and by the mean value theorem beyond. With the columns `c_j = (2 at j, -1 at j - 1, j +
//! 1)` of the contact forces in the rates,
//!
//! `kappa = max_i alpha int sum_j |(A P M(t, s) c)_{ij}| (sum_k |M_x(s)|_{jk})^{1+p} ds`.
//!
//! # What is rigorous
//!
//! The theorem is rigorous, and so is the step from its numbers to the radii. For given `F(z)`,
//! `F'(z)` and `kappa`, the norm of `A`, `eta` and `d` are upper bounds: their sums are rounded up,
//! and the rounding errors of each product are bounded. Both inequalities are checked with results
//! that are rounded up. (For `p` other than 1/2 and 1 the power is taken to be right to 4
//! roundings.) So `A` need not be the inverse.
//!
//! Not rigorous are the three numbers that come from the flow. The error of `F(z)` is taken to be
//! the tolerance, that of `F'(z)` to be zero. `kappa` uses `M` of the computed solution, where the
//! theorem needs the largest in the ball, and its integral is an upper sum over windows. A proof
//! would take interval arithmetic for these.

use crate::{chain::Params, numerics::largest_by};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Largest number of steps of the iteration for the radius.
const MOST_STEPS: usize = 200;
/// Relative margin of the radii for rounding errors.
const SLACK: f64 = 1e-12;

/// The numbers of the theorem.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kantorovich {
    /// `|F(z)|`, with the tolerance of the flow.
    pub residual: f64,
    /// `|A|`.
    pub inverse: f64,
    /// `eta`: `|A F(z)|`, with the tolerance of the flow times `|A|`.
    pub correction: f64,
    /// `p`.
    pub exponent: f64,
    /// `kappa`.
    pub hoelder: f64,
    /// `d`.
    pub defect: f64,
    /// The least `r`, in units of the amplitude: the ball of this radius about `z` holds a
    /// solution. `None` where no `r` is found that satisfies both inequalities.
    pub radius: Option<f64>,
    /// There is no other solution within this distance: `d + kappa r^p < 1`.
    pub unique_within: Option<f64>,
}

impl Kantorovich {
    /// The radii of the theorem.
    ///
    /// ```
    /// // r = 1e-6 + kappa r^{3/2}/(3/2) with kappa = 1: r is about eta + (2/3) eta^{3/2}.
    /// use hertzchain::orbits::Kantorovich;
    /// let found = Kantorovich::new([1e-7, 10.0, 1e-6, 0.0], 0.5, 1.0);
    /// assert!((found.radius.unwrap() - 1e-6 - 2.0 / 3.0 * 1e-9).abs() < 1e-11);
    /// assert_eq!(Kantorovich::new([0.1, 10.0, 1.0, 0.0], 0.5, 1.0).radius, None);
    /// // An inverse that leaves 1 or more says nothing.
    /// assert_eq!(Kantorovich::new([1e-7, 10.0, 1e-6, 1.0], 0.5, 1.0).radius, None);
    /// ```
    pub fn new([residual, inverse, correction, defect]: [f64; 4], exponent: f64, hoelder: f64) -> Self {
        // Upper bounds.
        let moved = |r: f64| (hoelder * power(r, exponent)).next_up();
        let contracts = |r: f64| (defect + moved(r)).next_up() < 1.0;
        let image = |r: f64| {
            let bent = ((moved(r) * r).next_up() / (1.0 + exponent).next_down()).next_up();
            ((correction + (defect * r).next_up()).next_up() + bent).next_up()
        };
        let mut radius = correction;
        for _ in 0..MOST_STEPS {
            radius = image(radius);
            if !contracts(radius) {
                break;
            }
        }
        radius *= 1.0 + SLACK;
        let holds = contracts(radius) && image(radius) <= radius;
        let widest = ((1.0 - defect) / hoelder).powf(exponent.recip()) * (1.0 - SLACK);
        Self {
            residual,
            inverse,
            correction,
            exponent,
            hoelder,
            defect,
            radius: holds.then_some(radius),
            unique_within: (holds && contracts(widest)).then_some(widest),
        }
    }
}

/// Shooting equations at a solution, in the units of the theorem.
pub(crate) struct Shot {
    /// Exponent of the contacts.
    pub(crate) params: Params,
    /// Unit of strains.
    pub(crate) size: f64,
    /// Unit of rates over that of strains.
    pub(crate) omega: f64,
    /// Number of contacts. Their strains are the first entries of a state, their rates the first of
    /// its second half.
    pub(crate) sites: usize,
    /// Largest overlap.
    pub(crate) overlap: f64,
    /// `s` and `M(s)` at 0, at the ends of windows and at `t`, in units of the state; square.
    pub(crate) history: Vec<(f64, DMatrix<f64>)>,
    /// `P`, in units of the theorem.
    pub(crate) pick: DMatrix<f64>,
    /// `F(z)` in units of the theorem.
    pub(crate) residual: DVector<f64>,
    /// `F'(z)` in units of the theorem.
    pub(crate) jacobian: DMatrix<f64>,
    /// The states that are varied, as columns; `None` where they are the first entries of the
    /// state.
    pub(crate) varied: Option<DMatrix<f64>>,
    /// Tolerance of the flow.
    pub(crate) tol: f64,
}

impl Shot {
    /// The numbers of the theorem; `None` where the equations are not independent.
    pub(crate) fn kantorovich(&self) -> Option<Kantorovich> {
        let square = bordered(&self.jacobian);
        let inverse = square.clone().try_inverse()?;
        let norm = row_sums(&inverse).max();
        let residual = (self.residual.amax() + self.tol).next_up();
        let moved = row_sums(&product(
            &inverse,
            &DMatrix::from_column_slice(square.nrows(), 1, self.residual.as_slice()),
            false,
        ));
        let correction = (moved.max() + (norm * self.tol).next_up()).next_up();
        let defect = row_sums(&product(&inverse, &square, true)).max();
        let exponent = (self.params.alpha - 1.0).min(1.0);
        let hoelder = self.hoelder(&inverse, exponent)?;
        let numbers = Kantorovich::new([residual, norm, correction, defect], exponent, hoelder);
        [norm, correction, hoelder, defect].iter().all(|number| number.is_finite()).then_some(numbers)
    }

    /// `kappa`.
    fn hoelder(&self, inverse: &DMatrix<f64>, exponent: f64) -> Option<f64> {
        let (_, end) = self.history.last()?;
        let unit = self.units(end.nrows());
        let scaled = |m: &DMatrix<f64>| DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * unit[j] / unit[i]);
        let (contacts, to_end) = (self.contacts(end.nrows()), inverse * &self.pick * scaled(end));
        let unknowns = self.jacobian.ncols();
        let mut rates = Vec::with_capacity(self.history.len());
        for (s, m) in &self.history {
            let m = scaled(m);
            let strains = match &self.varied {
                Some(varied) => row_sums(&(m.rows(0, self.sites) * varied)),
                None => row_sums(&m.view((0, 0), (self.sites, unknowns)).into_owned()),
            };
            let felt = &to_end * m.lu().solve(&contacts)?;
            let sum = |row: usize| {
                (0..self.sites).map(|j| felt[(row, j)].abs() * strains[j].powf(1.0 + exponent)).sum::<f64>()
            };
            rates.push((*s, DVector::from_fn(felt.nrows(), |i, _| sum(i))));
        }
        let upper = rates.windows(2).map(|pair| {
            let ((from, a), (to, b)) = (&pair[0], &pair[1]);
            a.zip_map(b, f64::max) * (to - from)
        });
        let total = upper.fold(DVector::zeros(inverse.nrows()), |sum, part| sum + part);
        Some(self.stiffness(exponent) * total.max())
    }

    /// The Hölder constant of `alpha (-x)_+^{alpha-1}` in the units of the theorem, over the unit
    /// of rates: the coefficient is in the equations for the rates.
    fn stiffness(&self, exponent: f64) -> f64 {
        let alpha = self.params.alpha;
        let constant = if alpha <= 2.0 { alpha } else { alpha * (alpha - 1.0) * self.overlap.powf(alpha - 2.0) };
        constant * self.size.powf(exponent) / self.omega
    }

    fn units(&self, state: usize) -> Vec<f64> {
        (0..state).map(|i| if 2 * i < state { self.size } else { self.size * self.omega }).collect()
    }

    /// The columns `c_j`.
    fn contacts(&self, state: usize) -> DMatrix<f64> {
        let (half, n) = (state / 2, self.sites);
        let mut columns = DMatrix::zeros(state, n);
        for j in 0..n {
            for (i, weight) in [(j, 2.0), ((j + 1) % n, -1.0), ((j + n - 1) % n, -1.0)] {
                columns[(half + i, j)] += weight;
            }
        }
        columns
    }
}

/// `[J, V]` with an orthonormal basis `V` of the left null space of `J`.
fn bordered(jacobian: &DMatrix<f64>) -> DMatrix<f64> {
    let (rows, columns) = jacobian.shape();
    let q = jacobian.clone().qr().q();
    let mut square = jacobian.clone().resize(rows, rows, 0.0);
    let mut null: Vec<DVector<f64>> = Vec::new();
    while columns + null.len() < rows {
        // The unit vector that has the smallest part in the range so far, made orthogonal to that
        // range twice.
        let outside = |i: usize| 1.0 - q.row(i).norm_squared() - null.iter().map(|v| v[i] * v[i]).sum::<f64>();
        let Some(i) = largest_by(0..rows, |&i| outside(i)) else { break };
        let mut v = DVector::zeros(rows);
        v[i] = 1.0;
        for _ in 0..2 {
            v -= &q * q.tr_mul(&v);
            null.iter().for_each(|other| v -= other * other.dot(&v));
        }
        null.push(v.normalize());
    }
    for (k, v) in null.iter().enumerate() {
        square.set_column(columns + k, v);
    }
    square
}

/// Sums of the moduli of rows, rounded up.
fn row_sums(matrix: &DMatrix<f64>) -> DVector<f64> {
    let sum = |sum: f64, entry: &f64| if *entry == 0.0 { sum } else { (sum + entry.abs()).next_up() };
    DVector::from_iterator(matrix.nrows(), matrix.row_iter().map(|row| row.iter().fold(0.0, sum)))
}

/// Upper bounds of the moduli of the entries of `a b`, or of `1 - a b`.
fn product(a: &DMatrix<f64>, b: &DMatrix<f64>, from_one: bool) -> DMatrix<f64> {
    // A sum of n products is off by at most n/(1 - n u) roundings u of the sum of their moduli;
    // half of the factor is for the roundings of that sum. The last term is for products that
    // underflow.
    let share = a.ncols() as f64 * 2.0 * f64::EPSILON;
    let [large, sizes] = [a.abs(), b.abs()];
    let (sum, size) = (a * b, large * sizes);
    DMatrix::from_fn(a.nrows(), b.ncols(), |i, j| {
        let one = if from_one && i == j { 1.0 } else { 0.0 };
        let off = (share * size[(i, j)]).next_up() + f64::MIN_POSITIVE;
        ((one - sum[(i, j)]).abs().next_up() + off.next_up()).next_up()
    })
}

/// An upper bound of `r^p`.
fn power(r: f64, p: f64) -> f64 {
    match p {
        1.0 => r,
        0.5 => r.sqrt().next_up(),
        _ => r.powf(p) * (1.0 + 4.0 * f64::EPSILON),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twofloat::TwoFloat;

    // Truth: sums and products to twice the precision. Rounding to nearest is below in about half
    // of the cases.
    #[test]
    fn norms_and_products_are_bounds_from_above() {
        let wave =
            |i: usize, j: usize| ((1 + 7 * i + 13 * j * j) as f64).sin() * 10_f64.powi((3 * i + j) as i32 % 7 - 3);
        let (a, b) = (DMatrix::from_fn(40, 40, wave), DMatrix::from_fn(40, 40, |i, j| wave(j + 3, i)));
        let (mut nearest_is_below, sums) = (0, row_sums(&a));
        for i in 0..40 {
            let exact = a.row(i).iter().fold(TwoFloat::from(0.0), |sum, entry| sum + entry.abs());
            nearest_is_below +=
                usize::from(TwoFloat::from(a.row(i).iter().map(|entry| entry.abs()).sum::<f64>()) < exact);
            let over = (TwoFloat::from(sums[i]) - exact).hi();
            assert!(over >= 0.0 && over < 1e-13 * sums[i], "{i}: {over:e}");
        }
        assert!(nearest_is_below > 5, "{nearest_is_below}: the test would not see a sum to nearest");
        for from_one in [false, true] {
            let (bound, plain) = (product(&a, &b, from_one), &a * &b);
            for i in 0..40 {
                for j in 0..40 {
                    let one = TwoFloat::from(if from_one && i == j { 1.0 } else { 0.0 });
                    let exact = (0..40).fold(one, |sum, k| sum - TwoFloat::new_mul(a[(i, k)], b[(k, j)])).abs();
                    assert!(TwoFloat::from(bound[(i, j)]) >= exact, "{i} {j}");
                    assert!(
                        bound[(i, j)] < (one.hi() - plain[(i, j)]).abs() + 1e-6,
                        "{i} {j}: the bound says something"
                    );
                }
            }
        }
    }

    // Truth: both inequalities, to twice the precision, at the radius that is returned.
    #[test]
    fn the_radius_satisfies_both_inequalities() {
        for (eta, d, p, kappa) in
            [(1e-11, 1e-10, 0.5, 40.0), (3e-8, 1e-3, 0.5, 1e3), (1e-6, 0.2, 1.0, 1e5), (1e-9, 0.0, 1.0, 3.0)]
        {
            let found = Kantorovich::new([eta, 1.0, eta, d], p, kappa);
            let (radius, widest) = (found.radius.unwrap(), found.unique_within.unwrap());
            let power = |r: f64| if p == 1.0 { TwoFloat::from(r) } else { TwoFloat::from(r).sqrt() };
            let image = power(radius) * kappa * radius / (1.0 + p) + TwoFloat::new_mul(d, radius) + eta;
            assert!(image <= TwoFloat::from(radius) && radius < 4.0 * eta, "{found:?}");
            for r in [radius, widest] {
                assert!(power(r) * kappa + d < TwoFloat::from(1.0), "{found:?}");
            }
            assert!(widest > radius && power(1.001 * widest) * kappa + d > TwoFloat::from(1.0), "{found:?}");
        }
    }
}
