//! The step control that a user asks for.

/// How the lengths of windows are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepControl {
    /// Windows of equal length, without control of the error.
    Windows {
        /// Number of windows in the span, at least 1.
        windows: u64,
        /// Nodes a panel: 4, 8 or 12.
        nodes: usize,
        /// Whether panels are also cut where a contact of a neighbour begins or ends; the full
        /// order needs these cuts.
        neighbours: bool,
    },
    /// Adaptive windows: a bound for the sum of local errors over the run, relative to the size of
    /// the state; from 1e-15 to 0.1.
    Tolerance(f64),
}
