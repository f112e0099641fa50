//! Changes of sign of functions of the state, which are kept and may end a run.

use super::Observables;
use crate::chain::max_norm;
use hertzchain_integrators::{
    Error as Failure, Event, Stepper,
    events::{Search, Searched, bracketed},
};
use std::{fmt, mem::take, sync::Arc};

/// What a run does at a change of sign of a function of [`Run::crossings`](super::Run::crossings).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crossed {
    /// It goes on, and does not keep the change.
    Passed,
    /// It keeps the change in [`Trajectory::crossings`](super::Trajectory::crossings) and goes on.
    Kept,
    /// It keeps the change and ends there.
    Ends,
}

type Then = dyn Fn(&Event<f64>, &[f64]) -> Crossed + Send + Sync;

/// The functions, and what follows a change of sign. Clones share them.
#[derive(Clone)]
pub(super) struct Crossings {
    pub(super) functions: Observables,
    pub(super) then: Arc<Then>,
}

impl fmt::Debug for Crossings {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("Crossings")
    }
}

impl Crossings {
    /// Searches the steps of a run with `half` positions, by parts of the given length, and adds
    /// the changes that are kept to `kept`.
    pub(super) fn watch<'a>(
        &'a self,
        (half, part): (usize, f64),
        mut stepper: Inner<'a>,
        kept: &'a mut Vec<Event<f64>>,
    ) -> Box<dyn Stepper<f64> + 'a> {
        let (y, start) = (vec![0.0; stepper.dim()], stepper.time());
        let mut changes =
            Changes { of: self, half, kept, start, sides: Vec::new(), last: Vec::new(), y, bands: [0.0; 2] };
        changes.last = changes.at(&mut stepper, start);
        changes.sides = vec![None; changes.last.len()];
        Box::new(Searched::by(changes, stepper).in_parts(part))
    }
}

/// A time and the value of a function there.
type Point = (f64, f64);

type Inner<'a> = Box<dyn Stepper<f64> + 'a>;

/// The search of the steps of a run.
struct Changes<'a> {
    of: &'a Crossings,
    /// Number of positions, and of velocities.
    half: usize,
    kept: &'a mut Vec<Event<f64>>,
    start: f64,
    /// Whether each function was positive when it was last outside the band.
    sides: Vec<Option<bool>>,
    /// Values at the end of the last part.
    last: Vec<f64>,
    y: Vec<f64>,
    /// The bands of positions and of velocities.
    bands: [f64; 2],
}

impl<'a> Search<f64, Inner<'a>> for Changes<'_> {
    fn part(&mut self, stepper: &mut Inner<'a>, (from, to): (f64, f64)) -> Result<Option<f64>, Failure> {
        let middle = from + 0.5 * (to - from);
        let (first, inner, end) = (take(&mut self.last), self.at(stepper, middle), self.at(stepper, to));
        let mut found: Vec<Event<f64>> = Vec::new();
        for index in 0..end.len() {
            let (points, band) = ([(from, first[index]), (middle, inner[index]), (to, end[index])], self.band(index));
            // A state that is lost has no changes; the observer of the run ends it.
            if points.iter().any(|point| !point.1.is_finite()) {
                continue;
            }
            if from == self.start {
                // A zero is known as exactly as its time.
                let slope = (inner[index] - first[index]).abs() / (middle - from);
                let near = band + 8.0 * f64::EPSILON * from.abs() * slope;
                self.sides[index] = Some(first[index] > 0.0).filter(|_| first[index].abs() > near);
            }
            let mut points = points.to_vec();
            points.extend(self.beyond(stepper, index, [points[0], points[1], points[2]]));
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            for pair in points.windows(2) {
                let (before, after, rising) = (pair[0], pair[1], pair[1].1 > 0.0);
                if after.1.abs() <= band {
                    continue;
                }
                if self.sides[index].replace(rising).is_some_and(|side| side != rising) {
                    let left = (before.1 > 0.0) == rising && before.1 != 0.0;
                    let t = if left { before.0 } else { bracketed(|t| self.at(stepper, t)[index], before, after) };
                    found.push(Event { index, rising, t });
                }
            }
        }
        found.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.index.cmp(&b.index)));
        for event in found {
            stepper.sample(event.t, &mut self.y);
            let crossed = (self.of.then)(&event, &self.y);
            if crossed != Crossed::Passed {
                self.kept.push(event);
            }
            if crossed == Crossed::Ends {
                return Ok(Some(event.t));
            }
        }
        self.last = end;
        Ok(None)
    }
}

impl Changes<'_> {
    fn at(&mut self, stepper: &mut Inner<'_>, t: f64) -> Vec<f64> {
        stepper.sample(t, &mut self.y);
        // The ledger is no motion. Rounding errors stay when a state passes through zero.
        for (band, motion) in self.bands.iter_mut().zip(self.y.chunks(self.half)) {
            *band = band.max(64.0 * f64::EPSILON * max_norm(motion.iter().copied()));
        }
        self.of.functions.at(&self.y)
    }

    fn band(&self, index: usize) -> f64 {
        let [positions, velocities] = self.bands;
        self.of.functions.kind(index).map_or(positions.max(velocities), |kind| self.bands[kind.min(1)])
    }

    /// A point on the other side of zero between three on one side: the minimum of the modulus, by
    /// parabolas through the three lowest points.
    fn beyond(&mut self, stepper: &mut Inner<'_>, index: usize, points: [Point; 3]) -> Option<Point> {
        let sign = points[1].1.signum();
        let (mut points, band) = (points.to_vec(), self.band(index));
        points.iter_mut().for_each(|point| point.1 *= sign);
        if points.iter().any(|point| point.1 <= band) {
            return None;
        }
        for _ in 0..8 {
            let [a, b, c] = [points[0], points[1], points[2]];
            let slope = (b.1 - a.1) / (b.0 - a.0);
            let curvature = ((c.1 - b.1) / (c.0 - b.0) - slope) / (c.0 - a.0);
            let lowest = 0.5 * (a.0 + b.0) - 0.5 * slope / curvature;
            let (width, t) = (c.0 - a.0, lowest.clamp(a.0, c.0));
            let least = a.1 + (t - a.0) * (slope + curvature * (t - b.0));
            let (low, high) = (a.1.min(b.1).min(c.1), a.1.max(b.1).max(c.1));
            // The error of the parabola is a part of its range.
            let near = curvature > 0.0 && (lowest - t).abs() < 0.1 * width && least < 0.25 * (high - low);
            if !near || [a.0, b.0, c.0].contains(&t) {
                return None;
            }
            let value = self.at(stepper, t)[index];
            if sign * value < -band {
                return Some((t, value));
            }
            points.push((t, sign * value));
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            // The lowest and its neighbours.
            let last = points[0].1.min(points[1].1) > points[2].1.min(points[3].1);
            points.remove(if last { 0 } else { 3 });
        }
        None
    }
}
