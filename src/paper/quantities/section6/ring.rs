//! Newton's iteration of Sec. 6 as the paper has it: all unknowns of the ring, no symmetries.

use super::{SITES, fluxes};
use crate::{
    dps::{Averages, DarkProfile},
    error::{Error, Result},
};
use nalgebra::{DMatrix, DVector};

/// Largest number of steps of the iteration, and its tolerance.
const MOST: u32 = 100;
const TOLERANCE: f64 = 1e-8;

/// The unknowns `delta^- a_n, delta^- b_n`, `n = -N .. N`, with `b_{-N} = 0`.
pub(super) struct Ring<'a> {
    averages: &'a Averages,
    /// The sign of `mu` in (eq:DpSsw1).
    sign: f64,
    /// `a_n` and `b_n`, `n = -N .. N`.
    strains: [Vec<f64>; 2],
}

impl<'a> Ring<'a> {
    /// (eq:an_ini), and the `b_n` that follow with `b_{-N} = 0`.
    pub(super) fn guess(averages: &'a Averages, n_0: f64, sign: f64) -> Self {
        let half = (SITES / 2) as i32;
        let a: Vec<f64> = (-half..=half).map(|n| f64::from(1 - 2 * (n & 1)) * (f64::from(n) - n_0).tanh()).collect();
        let force = averages.g(0.0, a[0].abs());
        let mut b: Vec<f64> = a.iter().map(|a| averages.mean_strain(force, a.abs())).collect();
        b[0] = 0.0;
        Self { averages, sign, strains: [a, b] }
    }

    /// (eq:DpSsw2): the first equation of each site, then the second one.
    fn defects(&self) -> DVector<f64> {
        let ([a, _], [flux, g]) = (&self.strains, fluxes(self.averages, &self.strains));
        let count = a.len();
        DVector::from_fn(2 * count, |i, _| {
            let (n, after, before) = (i % count, (i + 1) % count, (i + count - 1) % count);
            if i < count { self.sign * a[n] + flux[after] - 2.0 * flux[n] + flux[before] } else { g[after] - g[n] }
        })
    }

    /// Their derivatives with respect to all `a_n`, then all `b_n`.
    pub(super) fn jacobian(&self) -> DMatrix<f64> {
        let [a, b] = &self.strains;
        let count = a.len();
        let mut matrix = DMatrix::zeros(2 * count, 2 * count);
        for k in 0..count {
            let (after, before, sign) = ((k + 1) % count, (k + count - 1) % count, a[k].signum());
            let bond = self.averages.values(b[k], a[k].abs());
            matrix[(k, k)] += self.sign;
            for (column, flux, force) in
                [(k, bond.drh_dr, sign * bond.dg_dr), (count + k, sign * bond.drh_db, bond.dg_db)]
            {
                for (row, share) in [(before, 1.0), (k, -2.0), (after, 1.0)] {
                    matrix[(row, column)] += share * flux;
                }
                matrix[(count + before, column)] += force;
                matrix[(count + k, column)] -= force;
            }
        }
        matrix
    }

    /// The Jacobian with `b_{-N}` fixed, of all equations but the last, which the others imply.
    pub(super) fn reduced(&self) -> DMatrix<f64> {
        let count = self.strains[0].len();
        self.jacobian().remove_column(count).remove_row(2 * count - 1)
    }

    /// Newton's iteration until a step is below the tolerance, relative to the largest `a_n`; false
    /// if none is.
    pub(super) fn iterate(&mut self) -> bool {
        let count = self.strains[0].len();
        for _ in 0..MOST {
            let right = self.defects().remove_row(2 * count - 1);
            let Some(step) = self.reduced().lu().solve(&right) else { return false };
            let [a, b] = &mut self.strains;
            a.iter_mut().zip(step.iter()).for_each(|(a, step)| *a -= step);
            b[1..].iter_mut().zip(step.iter().skip(count)).for_each(|(b, step)| *b -= step);
            let size = self.size();
            if step.amax() <= TOLERANCE * size || !size.is_normal() {
                return size.is_normal();
            }
        }
        false
    }

    /// The largest `abs(a_n)`.
    pub(super) fn size(&self) -> f64 {
        self.strains[0].iter().fold(0.0, |most: f64, a| most.max(a.abs()))
    }

    /// The profile that the iteration from (eq:an_ini) leads to with `mu = 1`.
    ///
    /// # Errors
    /// It does not converge.
    pub(super) fn settled(averages: &'a Averages, n_0: f64) -> Result<Self> {
        let mut ring = Self::guess(averages, n_0, 1.0);
        if ring.iterate() {
            Ok(ring)
        } else {
            Err(Error::parameter("n_0", n_0, "a guess from which Newton's method converges"))
        }
    }

    /// The largest distance of this profile from another that is moved by `by` sites, relative to
    /// the largest `a_n`; of the two signs of the `a_n` the nearer one.
    pub(super) fn apart(&self, other: &DarkProfile, by: i64) -> f64 {
        let [a, b] = &self.strains;
        let most = |sign: f64| {
            let off = |(k, n): (usize, i64)| (a[k] - sign * other.a(n - by)).abs().max((b[k] - other.b(n - by)).abs());
            (0..).zip(other.sites()).map(off).fold(0.0, f64::max)
        };
        most(1.0).min(most(-1.0)) / self.size()
    }
}
