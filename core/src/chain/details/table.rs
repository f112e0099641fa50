//! A contact force through the rows of a table.

use super::Spline;
use crate::error::{Error, Result, require};
use hertzchain_integrators::Real;

/// The force of a contact through given overlaps and forces, both of which increase from zero.
///
/// Between two rows it is a cubic, and its slope is continuous. Slopes at rows are those of the
/// [`Spline`], limited to at most three times the slope of the lines to the rows beside, and at
/// least zero, so that the force never falls: J. M. Hyman 1983, SIAM J. Sci. Stat. Comput. 4, 645;
/// C. de Boor & B. Swartz 1977, J. Approx. Theory 21, 411. Where no slope is limited the second
/// derivative is continuous, too, and the error is the fourth power of the distances of rows. After
/// the last row the force goes on with the slope there; a [`Run`](crate::Run) in which an overlap
/// gets that far fails.
///
/// ```
/// use hertzchain_core::{Boundary, Chain, Params, chain::{Details, Table}};
/// // Four rows of f = g^2 + g^3, which is a cubic; a bead pressed by 0.5 into a wall.
/// let g = vec![0.0, 0.25, 0.75, 1.0];
/// let table = Table::new(g.clone(), g.iter().map(|g| g * g * (1.0 + g)).collect())?;
/// let details = Details { table: Some(table.into()), ..Details::default() };
/// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::RightWall, 1)?.with(&details)?;
/// assert!((chain.bond_force(1, 0.5, 0.0) - 0.375).abs() < 1e-15);
/// // The energy is g^3/3 + g^4/4.
/// assert!((chain.energy(&[0.5, 0.0]).contacts - (0.125 / 3.0 + 0.0625 / 4.0)).abs() < 1e-15);
/// # Ok::<(), hertzchain_core::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Limited, and with one more cubic for overlaps after the last row.
    force: Spline,
    /// The energy at each row.
    energy: Vec<f64>,
}

impl Table {
    /// The force through these rows.
    ///
    /// # Errors
    /// Fewer than two rows, or not as many overlaps as forces; numbers that are not finite, do not
    /// begin at zero or do not increase; slopes that overflow.
    pub fn new(overlap: Vec<f64>, force: Vec<f64>) -> Result<Self> {
        let n = overlap.len();
        let value = format!("{n} overlaps, {} forces", force.len());
        require(n > 1 && force.len() == n, "bonds.table", value, "at least two rows, each an overlap and a force")?;
        for (name, list) in [("bonds.table.overlap", &overlap), ("bonds.table.force", &force)] {
            let good = |k: usize| list[k].is_finite() && if k == 0 { list[0] == 0.0 } else { list[k] > list[k - 1] };
            if let Some(k) = (0..n).find(|&k| !good(k)) {
                let rule = "overlaps and forces of a table are finite, the first is 0, and each is larger than the one \
                            before";
                return Err(Error::parameter(name, format!("{} (entry {k})", list[k]), rule));
            }
        }
        let chord = |k: usize| (force[k + 1] - force[k]) / (overlap[k + 1] - overlap[k]);
        let mut spline = Spline::new(overlap.clone(), force.clone())?;
        let slope = |k: usize| {
            let least = chord(k.saturating_sub(1)).min(chord(k.min(n - 2)));
            spline.at(overlap[k])[1].clamp(0.0, 3.0 * least)
        };
        let cubic = |k: usize| {
            let (h, s, [a, b]) = (overlap[k + 1] - overlap[k], chord(k), [slope(k), slope(k + 1)]);
            [force[k], a, (3.0 * s - 2.0 * a - b) / h, (a + b - 2.0 * s) / h / h]
        };
        let cubics: Vec<[f64; 4]> = (0..n - 1).map(cubic).chain([[force[n - 1], slope(n - 1), 0.0, 0.0]]).collect();
        let finite = cubics.iter().flatten().all(|one| one.is_finite());
        require(finite, "bonds.table", "rows too near or too far apart", "cubics between them are finite")?;
        spline.cubics = cubics;
        let mut table = Self { force: spline, energy: vec![0.0] };
        for &end in &overlap[1..] {
            // The energy at a row is that of the cubic before it, of which this is the end.
            table.energy.push(table.work(table.energy.len() - 1, end));
        }
        Ok(table)
    }

    /// Overlaps of the rows.
    pub fn overlap(&self) -> &[f64] {
        self.force.times()
    }

    /// Forces of the rows.
    pub fn force(&self) -> &[f64] {
        self.force.values()
    }

    /// The last overlap.
    pub fn end(&self) -> f64 {
        self.overlap()[self.energy.len() - 1]
    }

    /// A bound of the slope of the force.
    pub(super) fn steepest(&self) -> f64 {
        self.force.speed()
    }

    /// Force, its slope and the energy at an overlap.
    pub(super) fn at<R: Real>(&self, g: R) -> [R; 3] {
        if g <= R::zero() {
            return [R::zero(); 3];
        }
        let [force, slope, _] = self.force.at(g);
        [force, slope, self.work(self.force.interval(g), g)]
    }

    /// The energy at an overlap, by the cubic `k`.
    fn work<R: Real>(&self, k: usize, g: R) -> R {
        let x = g - R::of(self.overlap()[k]);
        let [a, b, c, d] = self.force.cubics[k].map(R::of);
        let part = |by: R, n: f64| by / R::of(n);
        R::of(self.energy[k]) + x * (a + x * (part(b, 2.0) + x * (part(c, 3.0) + x * part(d, 4.0))))
    }
}
