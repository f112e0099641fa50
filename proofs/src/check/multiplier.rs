//! Chapter: a real Floquet multiplier of a dark breather, above 1 or -1, where `g` of the
//! linearised equations is 0.

use super::{
    Refused, System,
    factors::{Factors, rated},
    further::Terms,
    newton::{Derivative, Equations},
    of,
    perturbed::{Perturbations, own},
};
use crate::{
    certificate::{Center, Certificate, Orbit},
    exact::Exact,
    interval::Interval,
    untrusted::choices,
};
use std::fmt::{self, Display, Formatter};

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

/// `g` for these factors: near that of an approximate solution `(p, g)`, by the row of `g`.
pub fn g(terms: &Terms, l: &Factors, derivative: &Derivative) -> Interval {
    let (it, (p, g)) = (&terms.it, choices::perturbation(terms, l, None));
    let p = it.series(&p);
    let forces = it.forces(&p, it.counts()[1]);
    let value = |place| own(&p, place) + it.applied(l, &forces, place) + g[0] * it.column(0, place);
    let (y0, rows) = (terms.y0(&value, &p, &derivative.contacts), derivative.within(&terms.changed));
    let radius = derivative.norm(&y0) / (Interval::ONE - derivative.norm(&rows));
    g[0] + (y0[it.functions()] + rows[it.functions()] * radius).ball()
}

/// Bounds of `|e^{lambda T}|` of a multiplier that grows, and of `g` for -1, where the strains of
/// the orbit differ by at most `changes` from the cosine sums.
pub fn check(
    certificate: &Certificate,
    multiplier: &Multiplier,
    (system, changes): (&System, &[Interval]),
    go_on: &dyn Fn() -> Result<(), Refused>,
) -> Result<[f64; 2], Refused> {
    let (rates, doubled) = match multiplier {
        Multiplier::Growing(rates) => (rates.map(Exact::enclosed), None),
        Multiplier::Doubling { sine } => ([Interval::ZERO; 2], Some(*sine)),
    };
    let it = Perturbations::new(certificate, &system.perturbed(), doubled, None);
    let rated = |rate: Interval| rated(certificate, &it, rate);
    let terms = Terms::new(&it, rated(rates[0].hull(rates[1])), &|i, place| it.column(i, place), changes);
    let mut derivative = terms.derivative(go_on)?;
    derivative.push(terms.block.column(0), choices::lightest(&derivative.within(&terms.changed)));
    let z1 = derivative.norm(&derivative.within(&terms.changed));
    let refused = |g| Err(Refused::Multiplier { z1: z1.hi(), g });
    if !(Interval::ONE - z1).is_positive() {
        return refused(None);
    }
    let g = |rate: Interval| g(&terms, &rated(rate), &derivative);
    let size = |rate: Interval| (rate * of(2) * Interval::PI / system.omega()).exp();
    let (bounds, ends) = match doubled {
        None => (rates.map(g), rates.map(size)),
        Some(_) => {
            let g = g(rates[0]);
            ([g; 2], [g; 2])
        }
    };
    let changes_sign = doubled.is_some() || (-(bounds[0] * bounds[1])).is_positive();
    let [from, to] = [ends[0].lo(), ends[1].hi()];
    if changes_sign && from <= to { Ok([from, to]) } else { refused(Some(bounds.map(|g| [g.lo(), g.hi()]))) }
}
