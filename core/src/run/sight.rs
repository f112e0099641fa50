//! Checks of a state of a run, its energy and profile: of a state in memory, or of one that the
//! parts of the run keep.

use super::{Profile, Run};
use crate::{
    chain::{Blocks, Chain, Energy, max_norm},
    parts::Apart,
};

/// Length of the blocks in which a state is searched for values that are not finite.
const BLOCK: usize = 512;

/// A state of a run, in memory or in its parts.
pub(super) struct Sight<'a> {
    chain: &'a Chain<f64>,
    /// The state; empty if the parts keep it.
    y: &'a [f64],
    apart: Option<&'a Apart>,
}

impl Run {
    /// The state `y`, or the one that the parts of the run keep.
    pub(super) fn sight<'a>(&'a self, y: &'a [f64]) -> Sight<'a> {
        Sight { chain: &self.chain, y, apart: self.parts.apart().map(|apart| &**apart) }
    }
}

impl Sight<'_> {
    /// Calls `see` with slices of the state, each with the index of its first entry.
    fn each(&self, see: &mut dyn FnMut(usize, &[f64])) {
        let Some(apart) = self.apart else { return see(0, self.y) };
        let layout = self.chain.layout();
        apart.each(&mut |site, arrays| (0..4).for_each(|array| see(layout.entry(array, site), arrays[array])));
    }

    /// The energy.
    pub(super) fn energy(&self) -> Energy<f64> {
        self.apart.map_or_else(|| self.chain.energy(self.y), |apart| self.chain.energy_in(apart))
    }

    /// Index of the first entry that is not finite.
    pub(super) fn lost(&self) -> Option<usize> {
        let mut first = None;
        self.each(&mut |start, values| {
            // No branch inside a block, so that the compiler can vectorise the loop.
            let lost = |block: &[f64]| block.iter().fold(false, |lost, value| lost | !value.is_finite());
            if values.chunks(BLOCK).any(lost) {
                let at = start + values.iter().position(|value| !value.is_finite()).unwrap_or_default();
                first = Some(first.map_or(at, |first: usize| first.min(at)));
            }
        });
        first
    }

    /// The largest absolute value of an entry.
    pub(super) fn size(&self) -> f64 {
        let mut size = 0.0f64;
        self.each(&mut |_, values| size = size.max(max_norm(values.iter().copied())));
        size
    }

    /// Index and value of the entry with the largest absolute value, the last one of several.
    pub(super) fn largest(&self) -> (usize, f64) {
        let mut largest = (0, 0.0f64);
        self.each(&mut |start, values| {
            for (i, &value) in values.iter().enumerate() {
                if value.abs().total_cmp(&largest.1.abs()).then((start + i).cmp(&largest.0)).is_gt() {
                    largest = (start + i, value);
                }
            }
        });
        largest
    }

    /// Strains and state at time `t`. If the parts keep the state, both are empty, and each part
    /// keeps a profile of its own.
    pub(super) fn profile(&self, t: f64) -> Profile {
        if let Some(apart) = self.apart {
            apart.profile();
            return Profile { t, x: Vec::new(), state: Vec::new() };
        }
        Profile { t, x: self.chain.strains(self.y), state: self.y.to_vec() }
    }
}

#[cfg(test)]
mod tests {
    use crate::{
        Boundary, Chain, Method, Params, Run, State,
        parts::{Apart, Files, Own, Parts},
        run::Initial,
    };
    use std::{path::Path, sync::Arc};

    /// Files that nobody writes.
    #[derive(Debug)]
    struct Nothing;

    impl Files for Nothing {
        fn write(&self, _: &Path, _: u64, _: &Own) -> Result<(), String> {
            Ok(())
        }
    }

    /// The states of a chain in which some entries are changed: in memory, and in three parts.
    fn both(changes: &[(usize, f64)]) -> [Run; 2] {
        let chain = Chain::new(Params::new(1.5, 1.0, 1.0).unwrap(), Boundary::Ring, 30).unwrap();
        let mut state = State::rest(&chain);
        state.as_mut_slice().iter_mut().enumerate().for_each(|(i, y)| *y = 0.1 * (i as f64).sin());
        changes.iter().for_each(|&(i, value)| state.as_mut_slice()[i] = value);
        let motion = Method::named("verlet").unwrap().motion().unwrap();
        let initial: Initial = state.clone().into();
        let apart = Apart::new(&chain, motion, &Parts::Threads(3), Arc::new(Nothing), &initial).unwrap();
        let run = Run::new(chain, state).until(1.0).unwrap().method(Method::named("verlet").unwrap());
        [run.clone(), run.in_parts(Parts::Apart(Arc::new(apart))).unwrap()]
    }

    #[test]
    fn parts_see_what_one_process_sees() {
        // Truth: the entry that was changed. Entries are those of the whole state [u, v, u', v'] of
        // 30 sites, so that the first one may be of a later part than others.
        for run in both(&[(70, f64::INFINITY), (25, f64::NAN), (115, f64::NAN)]) {
            assert_eq!(run.sight(run.initial().as_slice()).lost(), Some(25));
        }
        for run in both(&[(3, -7.0), (59, 7.0), (100, 0.5)]) {
            let sight = run.sight(run.initial().as_slice());
            assert_eq!((sight.lost(), sight.size(), sight.largest()), (None, 7.0, (59, 7.0)));
        }
        let [whole, parts] = both(&[]).map(|run| run.sight(run.initial().as_slice()).energy());
        assert!(whole == parts && whole.total() > 0.0, "{whole:?} {parts:?}");
    }
}
