//! Counted work.

/// Work done by a stepper so far. Counts, not times: the same on every machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps (adaptive methods).
    pub rejected: u64,
    /// Evaluations of the contact force or of the vector field, those of samples included.
    pub force_evaluations: u64,
}

impl std::ops::Add for Stats {
    type Output = Self;

    /// The work of both.
    fn add(self, other: Self) -> Self {
        Self {
            steps: self.steps + other.steps,
            rejected: self.rejected + other.rejected,
            force_evaluations: self.force_evaluations + other.force_evaluations,
        }
    }
}
