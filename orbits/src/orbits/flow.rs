//! The flow of a chain and its tangent map over a given time.

use crate::{chain::Chain, error::Result};
use hertzchain_integrators::{
    Stepper,
    collocation::{StepControl, Tangent},
};
use nalgebra::DMatrix;

/// A state of the flow, and its derivative applied to the initial columns.
#[derive(Clone, Debug)]
pub struct Moment {
    pub t: f64,
    pub state: Vec<f64>,
    pub columns: DMatrix<f64>,
}

/// The state at `t`, and the derivative of the flow applied to `columns`. Each column has the
/// entries of a state. `seen` is called at 0 and at the end of each window.
pub fn flow(
    chain: &Chain<f64>,
    start: &[f64],
    t: f64,
    columns: DMatrix<f64>,
    tol: f64,
    mut seen: impl FnMut(&Moment),
) -> Result<Moment> {
    let mut run = chain.collocation(start, (0.0, t), StepControl::Tolerance(tol))?;
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
