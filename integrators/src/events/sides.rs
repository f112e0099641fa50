//! The sides of event functions, and the search of one step for changes of side.

use super::bernstein::{Interpolation, NODES, Polynomial, SHARES};
use crate::real::Real;

/// Relative accuracy of the polynomial over a step, in units of the largest value.
const POLYNOMIAL_ROUNDING: f64 = 1e-14;

/// Number of steps within which a function must reach the side that its event put it on.
const PATIENCE: u8 = 32;

/// A change of side inside a step; times are shares of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    pub index: usize,
    /// Whether the function changes from negative to positive.
    pub rising: bool,
    /// Time of the last zero before the band is left.
    pub zero: f64,
    /// Time at which the band is left.
    left: f64,
}

/// The sides of all functions, and their values at the nodes of the present step.
pub struct Sides {
    positive: Vec<bool>,
    /// Functions whose event was fired early: number of steps left to reach the new side. Zero for
    /// the others.
    late: Vec<u8>,
    values: Vec<[f64; NODES]>,
    band: f64,
    /// Functions of unknown sign at the start that have not left the noise since.
    doubtful: Vec<bool>,
    /// Values up to this may be errors of the present step: of functions that are doubtful, and of
    /// others.
    noise: [f64; 2],
    /// Functions whose event was taken back at the present place.
    returned: Vec<bool>,
    interpolation: Interpolation,
}

impl Sides {
    /// For this number of event functions.
    pub fn new(count: usize) -> Self {
        Self {
            positive: vec![false; count],
            late: vec![0; count],
            values: vec![[0.0; NODES]; count],
            band: 0.0,
            doubtful: vec![false; count],
            noise: [0.0; 2],
            returned: vec![false; count],
            interpolation: Interpolation::default(),
        }
    }

    /// Stores the values at node `k`.
    pub fn put<R: Real>(&mut self, k: usize, values: &[R]) {
        for (nodes, value) in self.values.iter_mut().zip(values) {
            nodes[k] = value.f64();
        }
    }

    /// Copies the values at the end of the last step to the start of the next.
    pub fn carry(&mut self) {
        for nodes in &mut self.values {
            nodes[0] = nodes[NODES - 1];
        }
    }

    /// Raises the band. It belongs to the largest state so far, as rounding errors stay when a
    /// state passes through zero.
    pub fn set_band(&mut self, band: f64) {
        self.band = self.band.max(band);
    }

    /// The band of a function in the present step.
    pub fn band(&self, index: usize) -> f64 {
        let largest = self.values[index].iter().fold(0.0f64, |largest, v| largest.max(v.abs()));
        let noise = if self.doubtful[index] { self.noise[0] } else { 0.0 };
        self.band.max(POLYNOMIAL_ROUNDING * largest).max(noise)
    }

    /// Sets the sides at the start of a run from the values at node 0. Values inside the band count
    /// as not positive; or, if they are `doubtful`, as positive until they are seen to be negative.
    pub fn begin(&mut self, doubtful: bool) {
        for (index, nodes) in self.values.iter().enumerate() {
            self.doubtful[index] = doubtful && nodes[0].abs() <= self.band;
            self.positive[index] = nodes[0] > self.band || self.doubtful[index];
        }
    }

    /// Sets the error of values in the present step, from that of a step whose error is as large as
    /// allowed, and the share of it.
    pub fn set_noise(&mut self, allowed: f64, share: f64) {
        self.noise = [allowed * share.max(1.0), allowed * share];
    }

    /// Whether the function counts as positive now.
    pub fn positive(&self, index: usize) -> bool {
        self.positive[index]
    }

    /// Whether the event of a function was fired early and the function has not reached its side.
    pub fn late(&self, index: usize) -> bool {
        self.late[index] > 0
    }

    /// The polynomial of a function over the step.
    pub fn polynomial(&self, index: usize) -> Polynomial {
        self.interpolation.through(&self.values[index])
    }

    /// The values of the polynomial of a function at the nodes of a part of the step.
    pub fn over(&self, index: usize, (start, end): (f64, f64)) -> [f64; NODES] {
        if (start, end) == (0.0, 1.0) {
            return self.values[index];
        }
        let polynomial = self.polynomial(index);
        SHARES.map(|share| polynomial.at(start + (end - start) * share))
    }

    /// Changes the side of a function before its values do.
    pub fn fire(&mut self, index: usize) {
        self.positive[index] = !self.positive[index];
        self.late[index] = PATIENCE;
        self.doubtful[index] = false;
    }

    /// The first change of side of each function that has one, in the order of indices.
    pub fn first_crossings(&self, found: &mut Vec<Crossing>) {
        found.clear();
        for index in 0..self.values.len() {
            let (positive, late, band) = (self.positive[index], self.late(index), self.band(index));
            if late || !self.interpolation.stays(&self.values[index], positive, band) {
                let crossing = self.polynomial(index).first_crossing(positive, late, band);
                found.extend(crossing.map(|(zero, left)| Crossing { index, rising: !positive, zero, left }));
            }
        }
    }

    /// The functions whose event was fired early, but which go away from zero on the side on which
    /// they were, before they come to the new one: their events are false.
    pub fn taken_back(&mut self, found: &mut Vec<usize>) {
        found.clear();
        for index in (0..self.values.len()).filter(|&index| self.late(index) && !self.returned[index]) {
            let (new, start) = (self.positive[index], self.values[index][0]);
            let away = if new { -start } else { start };
            let level = (2.0 * away).max(self.band(index)).max(self.noise[1]);
            if self.polynomial(index).leaves_first(!new, level, self.band(index)) {
                found.push(index);
            }
        }
        found.iter().for_each(|&index| self.returned[index] = true);
    }

    /// All changes of side in the step, in the order of time, then of indices. The sides become
    /// those at the end of the step.
    pub fn all_crossings(&mut self, found: &mut Vec<Crossing>) {
        self.first_crossings(found);
        for first in 0..found.len() {
            let mut last = found[first];
            let polynomial = self.polynomial(last.index);
            let band = self.band(last.index);
            // A polynomial of degree seven changes its sign at most seven times.
            for _ in 1..NODES {
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
    pub fn settle(&mut self) -> Vec<usize> {
        let mut turned = Vec::new();
        self.returned.fill(false);
        for index in 0..self.values.len() {
            self.doubtful[index] &= self.values[index][NODES - 1] <= self.noise[0];
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
