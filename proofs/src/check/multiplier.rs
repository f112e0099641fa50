//! Chapter: a real Floquet multiplier of a dark breather, above 1 or -1, where `g` of the
//! linearised equations is 0.

use super::{
    Refused, System, of,
    perturbed::{Equations, Terms},
};
use crate::{
    certificate::{Center, Certificate, Orbit},
    exact::Exact,
    interval::Interval,
    untrusted::choices,
};
use std::fmt::{self, Display, Formatter};

/// `K` of this proof, at most that of the certificate: this, or a share of `K'`.
const BLOCK: [usize; 2] = [8, 32];

/// A Floquet multiplier: a real one of a dark breather, of a perturbation that the reflection maps
/// to its negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Multiplier {
    /// `e^{lambda T}` with a growth rate `lambda` between these two.
    Growing([Exact; 2]),
    /// -1, of a piece of a branch.
    Doubling {
        /// Whether the perturbation is a sum of sines, and not of cosines.
        sine: bool,
    },
}

impl Display for Multiplier {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Growing([from, to]) => writeln!(f, "multiplier growing {from} {to}"),
            Self::Doubling { sine } => writeln!(f, "multiplier -1 {}", if *sine { "sine" } else { "cosine" }),
        }
    }
}

/// The rule of its line.
pub(crate) fn rule(Certificate { multiplier, to, orbit, .. }: &Certificate) -> bool {
    match (multiplier, orbit) {
        (None, _) => true,
        (Some(Multiplier::Growing([from, last])), Orbit::Breather { .. }) => {
            to.is_none() && from.num() > 0 && (last.enclosed() - from.enclosed()).is_positive()
        }
        (Some(Multiplier::Doubling { .. }), Orbit::Breather { center: Center::Bond, .. }) => {
            to.is_some_and(|[omega, _]| omega.num() > 0)
        }
        _ => false,
    }
}

/// Bounds of `|e^{lambda T}|` of a multiplier that grows, and of `g` for -1, where the strains of
/// the orbit differ by at most `changes` from the cosine sums.
pub fn check(
    certificate: &Certificate,
    multiplier: &Multiplier,
    (system, changes): (&System, &[Interval]),
    go_on: &dyn Fn() -> Result<(), Refused>,
) -> Result<[f64; 2], Refused> {
    let (Certificate { block, enclosed, .. }, system) = (certificate, system.perturbed());
    let sizes = [(*block).min(BLOCK[0].max(enclosed / BLOCK[1])), *enclosed];
    let rates = match multiplier {
        Multiplier::Growing(rates) => rates.map(Exact::enclosed),
        Multiplier::Doubling { .. } => [Interval::ZERO; 2],
    };
    let equations = Equations::new(certificate, &system, sizes, Some(multiplier));
    let l = equations.factors(rates[0].hull(rates[1]));
    let terms = Terms::new(equations, l, None, changes);
    let mut derivative = terms.derivative(&terms.block.further_columns(), go_on)?;
    derivative.weights.push(choices::lightest(&derivative.within(&terms.changed)));
    let z1 = derivative.norm(&derivative.within(&terms.changed));
    let refused = |g| Err(Refused::Multiplier { z1: z1.hi(), g });
    if !(Interval::ONE - z1).is_positive() {
        return refused(None);
    }
    let g = |re: Interval| terms.g(re, &derivative)[0];
    let bounds = match multiplier {
        Multiplier::Growing(_) => rates.map(g),
        Multiplier::Doubling { .. } => [g(rates[0]); 2],
    };
    let ends = match multiplier {
        Multiplier::Doubling { .. } => bounds,
        Multiplier::Growing(_) if (-(bounds[0] * bounds[1])).is_positive() => {
            rates.map(|rate| (rate * of(2) * Interval::PI / system.omega()).exp())
        }
        Multiplier::Growing(_) => [Interval::exact(f64::NAN); 2],
    };
    let [from, to] = [ends[0].lo(), ends[1].hi()];
    if from <= to { Ok([from, to]) } else { refused(Some(bounds.map(|g| [g.lo(), g.hi()]))) }
}
