//! Branches of normal modes with their multipliers, before their bifurcations are located.

use super::{
    arclength::End,
    bifurcation::{self, Located},
    normal_modes::{ModeBifurcation, ModeBranch, ModeContinuation, ModeFamily, ModePoint, NormalModes, WEAK},
};
use serde::{Deserialize, Serialize};

/// A branch of normal modes without its bifurcations.
#[derive(Clone, Debug)]
pub(crate) struct ModeTrail {
    /// How it was followed.
    pub(crate) continuation: ModeContinuation,
    /// Its points, at least one.
    pub(crate) points: Vec<ModePoint>,
    /// Why it ended.
    pub(crate) end: End,
    /// Number of the first point of the search for bifurcations: 1 if the first point is that at
    /// which this branch crosses another one, whose multiplier 1 is no bifurcation of this branch.
    pub(crate) first: usize,
}

/// What was found about a point of a branch.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct SpecialPoints {
    /// The bifurcations between the point before and this one.
    pub(crate) between: Vec<ModeBifurcation>,
    /// The fold, if the branch turns back at the point before.
    pub(crate) fold: Option<ModeBifurcation>,
    /// Number of stretches before this point with several bifurcations that were not separated.
    pub(crate) unresolved: usize,
}

impl ModeTrail {
    /// The branch with its bifurcations; without them, if the process was asked to end.
    pub(super) fn located(self, modes: &NormalModes) -> ModeBranch {
        if self.end == End::Stopped {
            return self.with(Vec::new(), 0);
        }
        let family = ModeFamily::new(modes, &self.continuation);
        let (found, unresolved) = bifurcation::located(&family, &self.points[self.first..], WEAK);
        let found = found.into_iter().map(|one| told(one, self.first)).collect();
        self.with(found, unresolved)
    }

    /// The bifurcations between points `k - 1` and `k`, and the fold at point `k - 1`.
    pub(crate) fn around(&self, modes: &NormalModes, k: usize) -> SpecialPoints {
        let (family, before) = (ModeFamily::new(modes, &self.continuation), k - self.first.min(k));
        let mut around = SpecialPoints::default();
        if before >= 1 {
            let mut found = Vec::new();
            let ends = [&self.points[k - 1], &self.points[k]];
            around.unresolved = bifurcation::in_stretch(&family, ends, WEAK, &mut found);
            around.between = found.into_iter().map(|one| told(one, k - 1)).collect();
        }
        if before >= 2 {
            let three = [&self.points[k - 2], &self.points[k - 1], &self.points[k]];
            around.fold = bifurcation::fold(&family, three).map(|fold| told(fold, k - 2));
        }
        around
    }

    /// The branch with all that was found between its points.
    pub(crate) fn with(self, bifurcations: Vec<ModeBifurcation>, unresolved: usize) -> ModeBranch {
        let Self { continuation, points, end, .. } = self;
        ModeBranch { continuation, points, bifurcations, unresolved, end }
    }
}

/// A bifurcation of a part of a branch that begins at point `first`.
fn told(Located { kind, tau, point, after }: Located<ModePoint>, first: usize) -> ModeBifurcation {
    ModeBifurcation { kind, tau, point, after: first + after }
}
