//! The errors of an integration. The reasons for which a run ends without one are
//! [`Stop`](crate::Stop).

/// An integration that could not go on. Numbers are converted to `f64` for any scalar of the run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An argument outside its range.
    #[error("{name} = {} is not valid: {rule}", brief(.value))]
    Argument {
        /// Name of the argument.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The rule it broke.
        rule: &'static str,
    },
    /// A component of the state, or of its slope, is not finite.
    #[error("the state is not finite at t = {} (step {step}, component {index})", brief(.t))]
    NotFinite {
        /// Time.
        t: f64,
        /// Accepted steps so far.
        step: u64,
        /// First component that is not finite.
        index: usize,
    },
    /// The energy or the size of the state exceeds its initial value by far more than an accurate
    /// run allows.
    #[error("unstable: {quantity} went from {initial:e} to {value:e} by t = {} (step {step}); take a smaller step", brief(.t))]
    Unstable {
        /// Name of the quantity.
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
    /// The step-size control asked for a step that does not change the time.
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
        /// Accepted steps; with [`Dop853`](crate::Dop853), all trial steps.
        steps: u64,
    },
    /// The sweeps of contact collocation did not converge in the shortest window.
    #[error("contact collocation did not settle at t = {}: bond {bond}, window {h:e}, change of impulse {residual:e}", brief(.t))]
    NoContraction {
        /// Time.
        t: f64,
        /// Shortest window that was tried.
        h: f64,
        /// Bond with the largest change of impulse; bonds that can touch are counted from the left.
        bond: usize,
        /// The change of its impulse.
        residual: f64,
    },
    /// An overlap is beyond those for which the contact law is known.
    #[error("bond {bond} overlaps by {overlap:e} at t = {}: the table of its contact law ends at {last:e}", brief(.t))]
    BeyondLaw {
        /// Time.
        t: f64,
        /// The bond, to the left of the site of this number.
        bond: usize,
        /// Its overlap.
        overlap: f64,
        /// The last overlap of the table.
        last: f64,
    },
    /// The work was [asked](crate::interrupt) to end.
    #[error("stopped by a signal at t = {}", brief(.t))]
    Stopped {
        /// Time.
        t: f64,
    },
    /// The stages of an implicit step did not converge.
    #[error(
        "the stages of the step did not settle at t = {}: step {h:e}, last change of a force {residual:e}; take a smaller step", brief(.t)
    )]
    NotSettled {
        /// Time.
        t: f64,
        /// The step.
        h: f64,
        /// The last change of a force; NaN if a slope is NaN.
        residual: f64,
    },
}

/// A number in decimal or, if very small or very large, exponential notation.
fn brief(t: &f64) -> String {
    if *t == 0.0 || (1e-5..1e16).contains(&t.abs()) { t.to_string() } else { format!("{t:e}") }
}
