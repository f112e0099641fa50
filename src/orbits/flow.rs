//! The flow of a chain and its tangent map over a given time.

use crate::{chain::Chain, error::Result};
use hertzchain_integrators::{
    Stepper,
    collocation::{Pace, Tangent},
};
use nalgebra::DMatrix;

/// A state and its derivatives by the first entries of the state at 0, one column for each of these
/// entries.
#[derive(Clone, Debug)]
pub(super) struct Moment {
    pub(super) t: f64,
    pub(super) state: Vec<f64>,
    pub(super) columns: DMatrix<f64>,
}

/// The state at `t`, and its derivatives by the first `columns` entries of `start`. `seen` is
/// called at 0 and at the end of each window.
pub(super) fn flow(
    chain: &Chain<f64>,
    start: &[f64],
    t: f64,
    columns: usize,
    tol: f64,
    mut seen: impl FnMut(&Moment),
) -> Result<Moment> {
    let mut run = chain.collocation(start, (0.0, t), Pace::Tolerance(tol))?;
    let columns = DMatrix::identity(start.len(), columns);
    let mut tangent = Tangent::new(&run, columns.as_slice())?;
    let mut moment = Moment { t: 0.0, state: start.to_vec(), columns };
    while !run.done() {
        seen(&moment);
        run.step()?;
        moment.t = run.time();
        run.sample(moment.t, &mut moment.state);
        if moment.columns.ncols() > 0 {
            tangent.follow(&run)?;
            moment.columns.copy_from_slice(&tangent.matrix(&run)?);
        }
    }
    seen(&moment);
    Ok(moment)
}
