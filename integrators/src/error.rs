//! What can go wrong while integrating. Why a run *ended well* is a [`Stop`](crate::Stop), not an error.

/// An integration that could not go on. Numbers are `f64` whatever the scalar of the run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An argument outside its rule.
    #[error("{name} = {value:?} is not valid: {rule}")]
    Argument {
        /// Which argument.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The rule it broke.
        rule: &'static str,
    },
    /// The state stopped being a number.
    #[error("the state is not finite at t = {} (step {step}, component {index})", brief(.t))]
    NotFinite {
        /// Time.
        t: f64,
        /// Accepted steps so far.
        step: u64,
        /// First component that is not finite.
        index: usize,
    },
    /// A conserved quantity left every bound that an accurate run could explain.
    #[error("unstable: {quantity} went from {initial:e} to {value:e} by t = {} (step {step}); take a smaller step", brief(.t))]
    Unstable {
        /// Which quantity.
        quantity: &'static str,
        /// Its value at the start.
        initial: f64,
        /// Its value now.
        value: f64,
        /// Time.
        t: f64,
        /// Accepted steps so far.
        step: u64,
    },
    /// The step-size control asked for a step that no longer changes the time.
    #[error("the step size underflowed at t = {} (h = {h:e})", brief(.t))]
    StepUnderflow {
        /// Time.
        t: f64,
        /// The step that was asked for.
        h: f64,
    },
    /// The allowed number of steps is used up.
    #[error("{steps} steps were not enough: stopped at t = {}", brief(.t))]
    TooManySteps {
        /// Time.
        t: f64,
        /// Steps taken.
        steps: u64,
    },
    /// The sweeps of contact collocation did not settle in any window, however short.
    #[error("contact collocation did not settle at t = {}: bond {bond}, window {h:e}, change of impulse {residual:e}", brief(.t))]
    NoContraction {
        /// Time.
        t: f64,
        /// Shortest window that was tried.
        h: f64,
        /// Bond with the largest change, counted from the first that can touch.
        bond: usize,
        /// That change.
        residual: f64,
    },
    /// Somebody outside asked it to end.
    #[error("stopped by a signal at t = {}", brief(.t))]
    Stopped {
        /// Time.
        t: f64,
    },
    /// The stages of an implicit step did not settle.
    #[error(
        "the stages of the step did not settle at t = {}: step {h:e}, last change {residual:e}; take a smaller step", brief(.t)
    )]
    NotSettled {
        /// Time.
        t: f64,
        /// The step.
        h: f64,
        /// The last change of a stage that was a number.
        residual: f64,
    },
}

/// A time that is not told with a hundred zeros.
fn brief(t: &f64) -> String {
    if *t == 0.0 || (1e-5..1e16).contains(&t.abs()) { t.to_string() } else { format!("{t:e}") }
}
