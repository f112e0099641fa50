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
    pub(crate) fn new(count: usize) -> Self {
        Self {
            positive: vec![false; count],
            late: vec![0; count],
            values: vec![[0.0; NODES]; count],
            band: 0.0,
            doubtful: vec![false; count],
            noise: [0.0; 2],
            returned: vec![false; count],
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
        let noise = if self.doubtful[index] { self.noise[0] } else { 0.0 };
        self.band.max(POLYNOMIAL_ROUNDING * largest).max(noise)
    }

    /// Sets the sides at the start of a run from the values at node 0. Values inside the band count
    /// as not positive; or, if they are `doubtful`, as positive until they are seen to be negative.
    pub(crate) fn begin(&mut self, doubtful: bool) {
        for (index, nodes) in self.values.iter().enumerate() {
            self.doubtful[index] = doubtful && nodes[0].abs() <= self.band;
            self.positive[index] = nodes[0] > self.band || self.doubtful[index];
        }
    }

    /// Sets the error of values in the present step, from that of a step whose error is as large as
    /// allowed, and the share of it.
    pub(crate) fn set_noise(&mut self, allowed: f64, share: f64) {
        self.noise = [allowed * share.max(1.0), allowed * share];
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
        self.doubtful[index] = false;
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

    /// The functions whose event was fired early, but which go away from zero on the side on which
    /// they were, before they come to the new one: their events are false.
    pub(crate) fn taken_back(&mut self, found: &mut Vec<usize>) {
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
    pub(crate) fn all_crossings(&mut self, found: &mut Vec<Crossing>) {
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
    pub(crate) fn settle(&mut self) -> Vec<usize> {
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of a function at the nodes of a step.
    fn step(sides: &mut Sides, f: impl Fn(f64) -> f64) {
        for (k, share) in SHARES.into_iter().enumerate() {
            sides.put(k, &[f(share)]);
        }
    }

    /// Sides of one function that is zero at the start, where errors of steps are 1e-8.
    fn doubtful() -> Sides {
        let mut sides = Sides::new(1);
        sides.put(0, &[0.0]);
        sides.set_band(1e-14);
        sides.begin(true);
        sides.set_noise(1e-8, 0.5);
        sides
    }

    fn crossings(sides: &Sides) -> usize {
        let mut found = Vec::new();
        sides.first_crossings(&mut found);
        found.len()
    }

    #[test]
    fn a_doubtful_function_is_positive_until_it_is_below_the_error_of_a_step() {
        let mut sides = doubtful();
        assert!(sides.positive(0));
        step(&mut sides, |s| -9e-9 * s);
        assert_eq!(crossings(&sides), 0);
        step(&mut sides, |s| -2e-8 * s);
        assert_eq!(crossings(&sides), 1);
        // A trial that errs more says less.
        sides.set_noise(1e-8, 3.0);
        assert_eq!(crossings(&sides), 0);
        // Once it has been above, the band counts again.
        step(&mut sides, |s| 4e-8 * s);
        assert!(sides.settle().is_empty());
        step(&mut sides, |s| 4e-8 - 4.1e-8 * s);
        assert_eq!(crossings(&sides), 1);
    }

    #[test]
    fn an_event_is_taken_back_if_its_function_goes_away_once_at_a_place() {
        let mut sides = doubtful();
        let mut found = Vec::new();
        sides.fire(0);
        // It comes to its new side late, or later.
        for f in [|s: f64| 1e-9 - 1e-6 * s, |s: f64| 1e-9 - 5e-10 * s, |s: f64| 1e-6 * s * (s - 0.5)] {
            step(&mut sides, f);
            sides.taken_back(&mut found);
            assert!(found.is_empty());
        }
        step(&mut sides, |s| 1e-9 + 1e-6 * s);
        sides.taken_back(&mut found);
        assert_eq!(found, [0]);
        sides.fire(0);
        step(&mut sides, |s| -1e-6 * s);
        sides.taken_back(&mut found);
        assert!(found.is_empty());
    }
}
