//! The sides of event functions, and the search of one step for changes of side.

use super::bernstein::{Interpolation, NODES, Polynomial, SHARES};
use crate::real::Real;

/// Relative accuracy of the polynomial over a step, in units of the largest value.
const POLYNOMIAL_ROUNDING: f64 = 1e-14;

/// Number of steps within which a function must reach the side that its event put it on.
const PATIENCE: u8 = 32;

/// A change of side inside a step; times are shares of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    pub(crate) index: usize,
    /// Whether the function changes from negative to positive.
    pub(crate) rising: bool,
    /// Time of the last zero before the band is left.
    pub(crate) zero: f64,
    /// Time at which the band is left.
    left: f64,
}

/// The sides of all functions, and their values at the nodes of the present step.
pub(crate) struct Sides {
    positive: Vec<bool>,
    /// Functions whose event was fired early: number of steps left to reach the new side. Zero for
    /// the others.
    late: Vec<u8>,
    values: Vec<[f64; NODES]>,
    band: f64,
    interpolation: Interpolation,
}

impl Sides {
    pub(crate) fn new(count: usize) -> Self {
        Self {
            positive: vec![false; count],
            late: vec![0; count],
            values: vec![[0.0; NODES]; count],
            band: 0.0,
            interpolation: Interpolation::new(),
        }
    }

    /// Stores the values at node `k`.
    pub(crate) fn put<R: Real>(&mut self, k: usize, values: &[R]) {
        for (nodes, value) in self.values.iter_mut().zip(values) {
            nodes[k] = value.f64();
        }
    }

    /// Copies the values at the end of the last step to the start of the next.
    pub(crate) fn carry(&mut self) {
        for nodes in &mut self.values {
            nodes[0] = nodes[NODES - 1];
        }
    }

    /// Raises the band. It belongs to the largest state so far, as rounding errors stay when a
    /// state passes through zero.
    pub(crate) fn set_band(&mut self, band: f64) {
        self.band = self.band.max(band);
    }

    /// The band of a function in the present step.
    pub(crate) fn band(&self, index: usize) -> f64 {
        let largest = self.values[index].iter().fold(0.0f64, |largest, v| largest.max(v.abs()));
        self.band.max(POLYNOMIAL_ROUNDING * largest)
    }

    /// Sets the sides at the start of a run from the values at node 0. Values inside the band count
    /// as not positive.
    pub(crate) fn begin(&mut self) {
        for (positive, nodes) in self.positive.iter_mut().zip(&self.values) {
            *positive = nodes[0] > self.band;
        }
    }

    pub(crate) fn positive(&self, index: usize) -> bool {
        self.positive[index]
    }

    /// Whether the event of a function was fired early and the function has not reached its side.
    pub(crate) fn late(&self, index: usize) -> bool {
        self.late[index] > 0
    }

    /// The polynomial of a function over the step.
    pub(crate) fn polynomial(&self, index: usize) -> Polynomial {
        self.interpolation.through(&self.values[index])
    }

    /// The values of the polynomial of a function at the nodes of a part of the step.
    pub(crate) fn over(&self, index: usize, (start, end): (f64, f64)) -> [f64; NODES] {
        if (start, end) == (0.0, 1.0) {
            return self.values[index];
        }
        let polynomial = self.polynomial(index);
        SHARES.map(|share| polynomial.at(start + (end - start) * share))
    }

    /// Changes the side of a function before its values do.
    pub(crate) fn fire(&mut self, index: usize) {
        self.positive[index] = !self.positive[index];
        self.late[index] = PATIENCE;
    }

    /// The first change of side of each function that has one, in the order of indices.
    pub(crate) fn first_crossings(&self, found: &mut Vec<Crossing>) {
        found.clear();
        for index in 0..self.values.len() {
            let (positive, late, band) = (self.positive[index], self.late(index), self.band(index));
            if late || !self.interpolation.stays(&self.values[index], positive, band) {
                let crossing = self.polynomial(index).first_crossing(positive, late, band);
                found.extend(crossing.map(|(zero, left)| Crossing { index, rising: !positive, zero, left }));
            }
        }
    }

    /// All changes of side in the step, in the order of time, then of indices. The sides become
    /// those at the end of the step.
    pub(crate) fn all_crossings(&mut self, found: &mut Vec<Crossing>) {
        self.first_crossings(found);
        for first in 0..found.len() {
            let mut last = found[first];
            let polynomial = self.polynomial(last.index);
            let band = self.band(last.index);
            loop {
                self.positive[last.index] = last.rising;
                let rest = polynomial.split(last.left).1;
                let Some((zero, left)) = rest.first_crossing(last.rising, false, band) else { break };
                let whole = |s: f64| last.left + (1.0 - last.left) * s;
                last = Crossing { rising: !last.rising, zero: whole(zero), left: whole(left), ..last };
                found.push(last);
            }
        }
        found.sort_by(|x, y| x.zero.total_cmp(&y.zero).then(x.index.cmp(&y.index)));
    }

    /// At the end of a step: marks late functions that have reached their side. One that does not
    /// reach it in time gets the side of its value. Returns those whose side has changed by this;
    /// mostly there are none, and nothing is allocated.
    pub(crate) fn settle(&mut self) -> Vec<usize> {
        let mut turned = Vec::new();
        for index in 0..self.values.len() {
            if self.late(index) {
                let arrived = self.polynomial(index).visits(self.positive[index], self.band);
                self.late[index] = if arrived { 0 } else { self.late[index] - 1 };
                if self.late[index] == 0 && !arrived {
                    let positive = self.values[index][NODES - 1] > self.band;
                    if self.positive[index] != positive {
                        turned.push(index);
                    }
                    self.positive[index] = positive;
                }
            }
        }
        turned
    }
}
