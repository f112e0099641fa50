//! A splitting scheme as data, and the (kick, drift) pairs of its steps.

use crate::{clock::DoubleDouble, real::Real};

/// The flow with which a symmetric composition starts and ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum First {
    /// Drift, kick, drift.
    Drift,
    /// Kick, drift, kick (velocity Verlet, when the drift is the kinetic energy).
    Kick,
}

/// The first half of a palindrome of coefficients, without the innermost entries, which follow
/// because each sum is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coefficients {
    /// `gamma_1, gamma_2, ..`: a symmetric composition of an odd number of Strang steps, without
    /// the middle one.
    Composition(&'static [&'static str]),
    /// Drifts `a_1, ..` and kicks `b_1, ..` of a scheme that begins and ends with a drift.
    DriftFirst {
        /// `a_1, a_2, ..` without the innermost.
        drifts: &'static [&'static str],
        /// `b_1, b_2, ..` without the innermost.
        kicks: &'static [&'static str],
    },
    /// Drifts `a_1, ..` and kicks `b_1, ..` of a scheme that begins and ends with a kick.
    KickFirst {
        /// `a_1, a_2, ..` without the innermost.
        drifts: &'static [&'static str],
        /// `b_1, b_2, ..` without the innermost.
        kicks: &'static [&'static str],
    },
}

/// A symmetric splitting scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    /// Short name for users.
    pub name: &'static str,
    /// Order on smooth problems with forces that depend on positions only.
    pub order: u32,
    /// Where the coefficients come from.
    pub source: &'static str,
    /// The coefficients.
    pub coefficients: Coefficients,
}

/// One (kick, drift) pair, as shares of the step.
pub(crate) type Pair<R> = (DoubleDouble<R>, DoubleDouble<R>);

impl Scheme {
    /// Number of kicks, and so of force evaluations, per step, once neighbouring steps are merged.
    pub fn stages(&self) -> usize {
        match self.coefficients {
            Coefficients::Composition(gammas) => 2 * gammas.len() + 1,
            Coefficients::DriftFirst { drifts, kicks } => sizes(drifts.len(), kicks.len()).1,
            Coefficients::KickFirst { drifts, kicks } => sizes(kicks.len(), drifts.len()).1,
        }
    }

    /// The drifts `a_i` and the kicks `b_i` of one step, in the order in which they act, and which
    /// acts first.
    ///
    /// `first` applies to compositions; other tables determine it themselves.
    pub fn flows<R: Real>(&self, first: First) -> (First, Vec<DoubleDouble<R>>, Vec<DoubleDouble<R>>) {
        match self.coefficients {
            Coefficients::Composition(gammas) => {
                let inner = palindrome(gammas, 2 * gammas.len() + 1);
                let half = DoubleDouble::decimal("0.5");
                let mut outer = vec![inner[0] * half];
                outer.extend(inner.windows(2).map(|pair| (pair[0] + pair[1]) * half));
                outer.push(inner[inner.len() - 1] * half);
                match first {
                    First::Drift => (first, outer, inner),
                    First::Kick => (first, inner, outer),
                }
            }
            Coefficients::DriftFirst { drifts, kicks } => {
                let (outer, inner) = sizes(drifts.len(), kicks.len());
                (First::Drift, palindrome(drifts, outer), palindrome(kicks, inner))
            }
            Coefficients::KickFirst { drifts, kicks } => {
                let (outer, inner) = sizes(kicks.len(), drifts.len());
                (First::Kick, palindrome(drifts, inner), palindrome(kicks, outer))
            }
        }
    }

    /// One step as (kick, drift) pairs; a missing kick at the start or drift at the end is zero.
    pub(crate) fn pairs<R: Real>(&self, first: First) -> Vec<Pair<R>> {
        let (first, mut drifts, mut kicks) = self.flows(first);
        match first {
            First::Drift => kicks.insert(0, DoubleDouble::zero()),
            First::Kick => drifts.push(DoubleDouble::zero()),
        }
        kicks.into_iter().zip(drifts).collect()
    }
}

/// Number of outer flows (those at both ends) and of inner flows, from the numbers of given
/// entries.
const fn sizes(outer: usize, inner: usize) -> (usize, usize) {
    let total = if outer == inner { 2 * outer + 2 } else { 2 * outer + 1 };
    (total, total - 1)
}

/// The palindrome of length `total` and sum one that begins with the given entries.
fn palindrome<R: Real>(given: &[&str], total: usize) -> Vec<DoubleDouble<R>> {
    let mut half: Vec<DoubleDouble<R>> = given.iter().map(|text| DoubleDouble::decimal(text)).collect();
    let one = DoubleDouble::new(R::one());
    let rest = half.iter().fold(one, |rest, &entry| rest - entry - entry);
    let odd = total % 2 == 1;
    half.push(if odd { rest } else { rest * DoubleDouble::decimal("0.5") });
    debug_assert_eq!(half.len(), total.div_ceil(2));
    let mirrored: Vec<_> = half.iter().rev().skip(usize::from(odd)).copied().collect();
    half.extend(mirrored);
    half
}
