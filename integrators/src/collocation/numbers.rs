//! The messages between the parts of a long chain: windows, verdicts, results and pieces as arrays
//! of `f64`.

use super::{
    bond::Contact,
    goal::{Cuts, Goal},
    window::{Left, Piece, Window, WindowOutcome},
};
use crate::events::Curve;

impl Window {
    /// Length of the array.
    pub const NUMBERS: usize = 15;

    /// The window as an array.
    pub fn numbers(&self) -> [f64; Self::NUMBERS] {
        let Self { h, nodes, log, goal } = *self;
        let Goal { change, rounded, tail, slow, least_impulse, stiffest, cuts } = goal;
        let Cuts { neighbours, merge, near, event_impulse, least_overlap, least_move_beside } = cuts;
        let [nodes, log, neighbours] = [nodes as f64, f64::from(u8::from(log)), f64::from(u8::from(neighbours))];
        let goal = [change, rounded, tail, slow, least_impulse, stiffest];
        let cuts = [neighbours, merge, near, event_impulse, least_overlap, least_move_beside];
        let mut numbers = [h; Self::NUMBERS];
        let all = [nodes, log].into_iter().chain(goal).chain(cuts);
        numbers[1..].iter_mut().zip(all).for_each(|(number, value)| *number = value);
        numbers
    }

    /// The window of an array.
    pub fn of_numbers(numbers: &[f64; Self::NUMBERS]) -> Self {
        let [h, nodes, log, change, rounded, tail, slow, least_impulse, stiffest, cuts @ ..] = *numbers;
        let [neighbours, merge, near, event_impulse, least_overlap, least_move_beside] = cuts;
        let neighbours = neighbours != 0.0;
        let cuts = Cuts { neighbours, merge, near, event_impulse, least_overlap, least_move_beside };
        let goal = Goal { change, rounded, tail, slow, least_impulse, stiffest, cuts };
        Self { h, nodes: nodes as usize, log: log != 0.0, goal }
    }
}

impl WindowOutcome {
    /// Length of the array.
    pub const NUMBERS: usize = 8;

    /// The outcome as an array; counts are exact up to 2^53.
    pub fn numbers(&self) -> [f64; Self::NUMBERS] {
        let Self { sweeps, work, stiffness, tail, touching, halved, failure } = *self;
        let (bond, residual) = failure.map_or((f64::NAN, 0.0), |(bond, residual)| (bond as f64, residual));
        [sweeps as f64, work as f64, stiffness, tail, touching as f64, halved as f64, bond, residual]
    }

    /// The outcome of an array.
    pub fn of_numbers(numbers: &[f64; Self::NUMBERS]) -> Self {
        let [sweeps, work, stiffness, tail, touching, halved, bond, residual] = *numbers;
        let (sweeps, work) = (sweeps as u64, work as u64);
        let failure = (!bond.is_nan()).then_some((bond as usize, residual));
        Self { sweeps, work, stiffness, tail, touching: touching as usize, halved: halved as usize, failure }
    }
}

impl<const S: usize> Left<S> {
    /// Number of values for one bond: its paths; onset and slopes of its contact.
    pub(crate) const NUMBERS: usize = 4 * S + 3;

    /// Appends these values. The ledger is not among them, and of the contact not
    /// `overlaps_at_onset`.
    pub(crate) fn write(&self, numbers: &mut Vec<f64>) {
        let contact = |ongoing: Contact| [ongoing.onset, ongoing.slopes[0], ongoing.slopes[1]];
        numbers.extend(self.path.as_flattened());
        numbers.extend(self.ongoing.map_or([f64::NAN; 3], contact));
    }

    /// The result of these values, with a ledger of zero.
    pub(crate) fn of_numbers(numbers: &[f64]) -> Self {
        let (paths, contact) = numbers.split_at(4 * S);
        let mut left = Self::NONE;
        left.path.as_flattened_mut().copy_from_slice(paths);
        if let [onset, a, b] = *contact
            && !onset.is_nan()
        {
            left.ongoing = Some(Contact::new(onset, f64::INFINITY, [a, b]));
        }
        left
    }
}

impl Piece {
    /// Length of the array.
    pub const NUMBERS: usize = 6 + Curve::NUMBERS;

    /// The piece as an array.
    pub fn numbers(&self) -> [f64; Self::NUMBERS] {
        let Self { bond, onset, release, impulse, curve } = *self;
        let event = |event: Option<(f64, f64)>| event.unwrap_or((f64::NAN, f64::NAN));
        let (onset, release) = (event(onset), event(release));
        let head = [bond as f64, onset.0, onset.1, release.0, release.1, impulse];
        let mut numbers = [0.0; Self::NUMBERS];
        let (start, rest) = numbers.split_at_mut(head.len());
        start.copy_from_slice(&head);
        rest.copy_from_slice(&curve.map_or([0.0; Curve::NUMBERS], |curve| curve.numbers()));
        numbers
    }

    /// The piece of an array.
    pub fn of_numbers(numbers: &[f64; Self::NUMBERS]) -> Self {
        let [bond, onset, onset_rate, release, release_rate, impulse, ref curve @ ..] = *numbers;
        let event = |t: f64, rate| (!t.is_nan()).then_some((t, rate));
        let (onset, release) = (event(onset, onset_rate), event(release, release_rate));
        Self { bond: bond as usize, onset, release, impulse, curve: Curve::of_numbers(curve) }
    }
}
