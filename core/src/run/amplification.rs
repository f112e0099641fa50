//! How much a small change of the initial state has grown at the end of a run.

use super::{Records, Run, Setting, regime::TOLERANCE};
use crate::{
    chain::{Details, State, max_norm},
    error::Result,
};

/// Least change, relative to the size of the state: rounding errors of the two runs must not matter.
const LEAST: f64 = 1e-12;
/// Smaller entries than this share of the largest one of their kind are not changed, so that beads
/// at rest stay at rest.
const SMALL: f64 = 1e-3;

/// The distance of a state from a reference: the larger of the largest error of a position relative
/// to the largest position, and that of a velocity relative to the largest velocity.
pub fn deviation(y: &[f64], reference: &[f64]) -> f64 {
    let half = y.len() / 2;
    let part = |a: &[f64], b: &[f64]| match max_norm(a.iter().zip(b).map(|(a, b)| a - b)) {
        0.0 => 0.0,
        gap => gap / max_norm(b.iter().copied()),
    };
    part(&y[..half], &reference[..half]).max(part(&y[half..], &reference[half..]))
}

/// Adds a change to those entries that are not small, with signs that depend on their index.
pub fn perturb(entries: &mut [f64], change: f64) {
    let size = max_norm(entries.iter().copied());
    for (i, entry) in entries.iter_mut().enumerate().filter(|(_, entry)| entry.abs() >= SMALL * size) {
        *entry += if (i * i + 3 * i) % 7 < 3 { change } else { -change };
    }
}

impl Run {
    /// The factor by which a small change of the initial state has grown at the end, where the
    /// state of this run is `end`.
    ///
    /// A second run begins from a state in which positions and velocities that are not small are
    /// changed by the tolerance (1e-10 without one, at least 1e-12) times the largest of their
    /// kind. The factor is the distance of the ends over this share, both as in [`deviation`]. A
    /// change that has grown to the size of the state grows no more: the factor is then a lower
    /// bound.
    ///
    /// ```
    /// # use hertzchain_core::{Boundary, Chain, Params, Run, State};
    /// // Two beads that fly apart: at the end all numbers have changed by the same share.
    /// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Free, 2)?;
    /// let mut state = State::rest(&chain);
    /// state.u_dot_mut().copy_from_slice(&[-1.0, 1.0]);
    /// let run = Run::new(chain, state).until(10.0)?;
    /// let end = run.start()?;
    /// assert!((run.amplification(&end.state)? - 1.0).abs() < 1e-4);
    /// # Ok::<(), hertzchain_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// No end; a second run that fails.
    pub fn amplification(&self, end: &[f64]) -> Result<f64> {
        let share = match self.choice()?.1 {
            Setting::Tolerance(tol) => tol.max(LEAST),
            Setting::Steps(_) | Setting::Windows(..) => TOLERANCE,
        };
        let arrays = 2 * self.chain.layout().half();
        let again = Self { initial: self.changed(share).into(), contacts: false, ..self.clone() };
        let other = again.records(Records::End).start()?.complete()?.state;
        Ok(deviation(&other[..arrays], &end[..arrays]) / share)
    }

    /// The initial state, changed by this share of its size; at rest, of the size of its drives. On
    /// a strain ring the means stay. A bead that a drive moves begins with its drive.
    fn changed(&self, share: f64) -> State<f64> {
        let (initial, layout) = (self.initial(), self.chain.layout());
        let rest = max_norm(initial.as_slice().iter().copied()) == 0.0;
        let mut state = initial.clone();
        for column in state.as_mut_slice()[..2 * layout.half()].chunks_mut(layout.half()) {
            let size = max_norm(column.iter().copied());
            perturb(column, share * if rest { self.chain.details().map_or(1.0, Details::scale) } else { size });
        }
        if self.chain.topology().strains() {
            let n = layout.sites();
            for (column, before) in state.as_mut_slice().chunks_mut(n).zip(initial.as_slice().chunks(n)) {
                let mean = column.iter().zip(before).map(|(new, old)| new - old).sum::<f64>() / n as f64;
                column.iter_mut().for_each(|entry| *entry -= mean);
            }
        }
        state.driven(&self.chain)
    }
}
