//! How much a small change of the initial state has grown at the end of a run.

use super::{Records, Run, Setting, overlap_scale, perturb, regime::TOLERANCE};
use crate::{
    chain::{State, max_norm},
    error::Result,
};

/// Least change, relative to the size of the state: rounding errors of the two runs must not
/// matter.
const LEAST: f64 = 1e-12;
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

impl Run {
    /// The factor by which a small change of the initial state has grown at the end, where the
    /// state of this run is `end`.
    ///
    /// A second run begins from a state in which all positions and velocities are changed by the
    /// tolerance (1e-10 without one, at least 1e-12) times the largest of their kind, positions at
    /// least by that of the [overlaps](super::overlap_scale). The factor is the distance of the
    /// ends over this share, see [`deviation`]. A change that has grown to the size of the state
    /// grows no more: the factor is then a lower bound.
    ///
    /// ```
    /// # use hertzchain_core::{Boundary, Chain, Params, Run, State};
    /// // Two beads that fly apart from -1 and 1: their strain is 2, and they end at -11 and 11.
    /// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Free, 2)?;
    /// let mut state = State::rest(&chain);
    /// state.u_mut().copy_from_slice(&[-1.0, 1.0]);
    /// state.u_dot_mut().copy_from_slice(&[-1.0, 1.0]);
    /// let run = Run::new(chain, state).until(10.0)?;
    /// let end = run.start()?;
    /// assert!((run.amplification(&end.state)? - (2.0 + 10.0) / 11.0).abs() < 1e-4);
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
        let mut state = initial.clone();
        let time = self.chain.natural(initial.as_slice()).time;
        let driven = self.chain.details().map_or(0.0, |details| details.scale(time));
        let rest = max_norm(initial.as_slice().iter().copied()) == 0.0;
        let sizes = [(overlap_scale(&self.chain, initial.as_slice()), driven), (0.0, driven / time)];
        for (column, (size, driven)) in state.as_mut_slice()[..2 * layout.half()].chunks_mut(layout.half()).zip(sizes) {
            let size = max_norm(column.iter().copied()).max(size);
            perturb(column, share * if rest { driven } else { size }, 0.0);
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
