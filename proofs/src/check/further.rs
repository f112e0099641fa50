//! Chapter: Newton's argument for perturbations, with further unknowns ("Multipliers" in
//! `README.md`).

use super::{
    Refused,
    factors::Factors,
    newton::{Block, Derivative, Equations, Matrix, Place, dot},
    perturbed::{Perturbations, SHARE},
};
use crate::{interval::Interval, untrusted::choices};
use std::rc::Rc;

/// What the bounds are made of, for all values of the factors.
pub struct Terms {
    /// The equations.
    pub it: Rc<Perturbations>,
    /// Their factors.
    pub l: Factors,
    /// `M` and `A`.
    pub block: Block,
    /// Bounds of the change of `D` in the ball.
    pub changed: Vec<Interval>,
    /// `sqrt 2 |D h|_{L2}` is at most this for `|h| <= 1`.
    pub steepest: Vec<Interval>,
}

impl Terms {
    /// Those of these factors and of these columns of further unknowns, where strains differ by at
    /// most these changes.
    pub fn new(
        it: &Rc<Perturbations>,
        l: Factors,
        column: &dyn Fn(usize, Place) -> Interval,
        changes: &[Interval],
    ) -> Self {
        let mut block = Block::new(it.clone(), it.functions(), it.sizes[0]);
        let (all, count) = (&block.all, block.all.len());
        let own = |(i, place): (usize, &Place)| {
            let given = it.pinned.iter().zip(count..).filter(|(pinned, _)| *pinned == place).map(|(_, i)| i);
            std::iter::once(i).chain(given).map(|i| (i, Interval::ONE)).collect()
        };
        let further = |which: usize| all.iter().map(|place| column(which, *place)).enumerate().collect();
        block.plain = all.iter().enumerate().map(own).chain((0..it.pinned.len()).map(further)).collect();
        block.inverse = choices::inverse(&choices::matrix(&block, &l));
        let changed = |n: usize| it.known(n).change(it.alpha, changes[n % changes.len()]);
        let changed = (0..it.functions()).map(changed).collect();
        let steepest = (0..it.functions()).map(|n| it.known(n).steepest(it.alpha)).collect();
        Self { it: it.clone(), l, block, changed, steepest }
    }

    /// The derivative of `T`, `1 - A M`, but for the further unknowns.
    pub fn derivative(&self, go_on: &dyn Fn() -> Result<(), Refused>) -> Result<Derivative, Refused> {
        let Self { it, l, block, steepest, .. } = self;
        let ([last, enclosed], tail) = (it.sizes, it.system.tails()[0]);
        let (last, tails) = (enclosed / SHARE + last, it.tails(enclosed / SHARE));
        block.derivative((l, tail), (last, &tails, steepest), go_on)
    }

    /// These rows with what is beyond the block of something linear in an approximate solution: for
    /// these factors, with a bound of those that are not computed, where `contacts` is what one
    /// unit of `sqrt 2 |g|_{L2}` does in the rows.
    pub fn with(
        &self,
        (rows, g, p): (Vec<Interval>, &dyn Fn(Place) -> Interval, &Matrix),
        (l, tail, contacts): (&Factors, Interval, &Matrix),
    ) -> Vec<Interval> {
        let (it, [harmonics, last]) = (&self.it, self.it.counts());
        let sizes: Vec<Interval> = p.iter().map(|p| p.iter().map(|p| p.abs()).sum()).collect();
        let by = |all: &[Interval]| sizes.iter().zip(all).map(|(size, one)| *size * *one).collect::<Vec<_>>();
        let ([tails, changes], far) = ([by(&it.tails(last - harmonics)), by(&self.changed)], it.far(l, last, tail));
        let of_row = |(far, contacts): (&Vec<_>, &Vec<_>)| dot(far, &tails) + dot(contacts, &changes);
        self.block.with(rows, g, (last, &far.iter().zip(contacts).map(of_row).collect::<Vec<_>>()))
    }

    /// `Y0` by row, of an approximate solution with these defects.
    pub fn y0(&self, defect: &dyn Fn(Place) -> Interval, p: &Matrix, contacts: &Matrix) -> Vec<Interval> {
        let rows = self.block.image(defect, self.it.given(p));
        self.with((rows, defect, p), (&self.l, self.it.system.tails()[0], contacts))
    }
}
