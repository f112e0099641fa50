//! Counts of work.

/// Work done by a stepper so far, as counts, which are the same on every machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Accepted steps.
    pub steps: u64,
    /// Rejected trial steps (adaptive methods).
    pub rejected: u64,
    /// Evaluations of the contact force or of the vector field. Those for samples are counted by
    /// DOP853 and by splitting schemes without corrections only.
    pub force_evaluations: u64,
}

impl std::ops::Add for Stats {
    type Output = Self;

    /// Sums the counts.
    fn add(self, other: Self) -> Self {
        Self {
            steps: self.steps + other.steps,
            rejected: self.rejected + other.rejected,
            force_evaluations: self.force_evaluations + other.force_evaluations,
        }
    }
}
