//! Changes of sign of functions of the state, which are kept and may end a run.

use super::{Observables, Run, extremes::PART};
use crate::chain::max_norm;
use hertzchain_integrators::{Event, EventFunctions, Stepper, Watch, events::Listener};
use std::{fmt, ops::ControlFlow, sync::Arc};

/// What a run does at a change of sign of a function of [`Run::crossings`].
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
    functions: Observables,
    then: Arc<Then>,
}

impl fmt::Debug for Crossings {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("Crossings")
    }
}

impl Run {
    /// Looks for changes of sign of functions of the state, and calls `then` with each and the state
    /// there. One that [`Ends`](Crossed::Ends) the run is its last time.
    ///
    /// The time is a zero of the function along the states that the method has between steps: its
    /// dense output; for splittings, a shorter step. They are looked for in the polynomials through
    /// eight samples of parts of steps, as those of [`observables`](Self::observables). A change
    /// leaves a band of 64 roundings of the largest entry of the state about zero on the other side.
    /// A function that begins in this band has no change when it leaves it, so that a run which goes
    /// on from its last change does not find it again. Contacts, if they are
    /// [logged](Self::contacts), are looked for in the same parts, with any method. The state at the
    /// end has the bits of the run without functions.
    ///
    /// ```
    /// # use hertzchain_core::{Boundary, Chain, Params, Run, State, run::{Crossed, Observables}};
    /// // A bead that is free moves with speed 2 and is at 3 at time 1.5.
    /// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Free, 1)?;
    /// let mut state = State::rest(&chain);
    /// state.u_dot_mut()[0] = 2.0;
    /// let at_three = Observables::new(|y, to| to.push(y[0] - 3.0));
    /// let run = Run::new(chain, state).until(5.0)?.crossings(at_three, |_, _| Crossed::Ends);
    /// let end = run.start()?;
    /// assert!((end.t - 1.5).abs() < 1e-15 && end.crossings[0].rising);
    /// # Ok::<(), hertzchain_core::Error>(())
    /// ```
    #[must_use]
    pub fn crossings(
        mut self,
        functions: Observables,
        then: impl Fn(&Event<f64>, &[f64]) -> Crossed + Send + Sync + 'static,
    ) -> Self {
        self.crossings = Some(Crossings { functions, then: Arc::new(then) });
        self
    }

    /// The longest parts of steps that are searched.
    pub(super) fn part(&self) -> f64 {
        PART * self.fast_period()
    }
}

impl Crossings {
    /// Searches the steps of a run, and adds the changes that are kept to `kept`.
    pub(super) fn watch<'a>(
        &'a self,
        run: &'a Run,
        stepper: Box<dyn Stepper<f64> + 'a>,
        kept: &'a mut Vec<Event<f64>>,
    ) -> Box<dyn Stepper<f64> + 'a> {
        let functions =
            Functions { of: &self.functions, count: self.functions.at(run.initial().as_slice()).len(), run };
        Box::new(Watch::of_crossings(stepper, functions, run.part(), Keeper { then: &*self.then, kept }))
    }
}

/// The functions as event functions.
struct Functions<'a> {
    of: &'a Observables,
    count: usize,
    run: &'a Run,
}

impl EventFunctions<f64> for Functions<'_> {
    fn count(&self) -> usize {
        self.count
    }

    fn values(&self, _t: f64, y: &[f64], g: &mut [f64]) {
        g.copy_from_slice(&self.of.at(y));
    }

    fn rates(&self, _t: f64, _y: &[f64], _dy: &[f64], _rates: &mut [f64]) {
        unreachable!("only methods that stop at events ask for rates");
    }

    fn band(&self, y: &[f64]) -> f64 {
        // The ledger is no motion.
        let motion = &y[..2 * self.run.chain.layout().half()];
        64.0 * f64::EPSILON * max_norm(motion.iter().copied())
    }
}

/// The listener that keeps changes.
struct Keeper<'a> {
    then: &'a Then,
    kept: &'a mut Vec<Event<f64>>,
}

impl Listener<f64> for Keeper<'_> {
    fn event(&mut self, event: Event<f64>, y: &[f64]) -> ControlFlow<()> {
        let crossed = (self.then)(&event, y);
        if crossed != Crossed::Passed {
            self.kept.push(event);
        }
        if crossed == Crossed::Ends { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
