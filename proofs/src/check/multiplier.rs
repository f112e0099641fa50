//! Chapter: Floquet multipliers. A real one of a dark breather, above 1 or -1, and one of a wave,
//! outside the unit circle, where `g` of the linearised equations is 0.

use super::{
    Refused, System, of,
    perturbed::{Equations, Terms},
};
use crate::{
    certificate::{Certificate, Multiplier, WIDER},
    exact::Exact,
    interval::{Interval, norm},
};

/// `K` of this proof, at most that of the certificate: this, or a share of `K'`.
const BLOCK: [usize; 2] = [8, 32];
/// `K` and `K'` of this proof for a wave, at most an eighth of that of the certificate, and that.
const OF_WAVE: [usize; 2] = [32, 512];

/// Bounds of `|e^{lambda T}|` of a multiplier that grows, and of `g` for -1, where the strains of
/// the orbit differ by at most `changes` from the cosine sums.
pub fn check(
    certificate: &Certificate,
    multiplier: &Multiplier,
    (system, changes): (&System, &[Interval]),
    go_on: &dyn Fn() -> Result<(), Refused>,
) -> Result<[f64; 2], Refused> {
    let (Certificate { block, enclosed, .. }, system) = (certificate, system.perturbed());
    let real = [(*block).min(BLOCK[0].max(enclosed / BLOCK[1])), *enclosed];
    let (rates, im, wide, sizes) = match multiplier {
        Multiplier::Growing(rates) => (rates.map(Exact::enclosed), Interval::ZERO, Interval::ZERO, real),
        Multiplier::Doubling { .. } => ([Interval::ZERO; 2], Interval::ZERO, Interval::ZERO, real),
        Multiplier::Bloch { rate, radius, .. } => {
            let [re, im, radius] = [rate[0], rate[1], *radius].map(Exact::enclosed);
            let sizes = [OF_WAVE[0].min(enclosed / 8), OF_WAVE[1].min(*enclosed)];
            ([re - radius, re + radius], im, (of(WIDER) * radius).ball(), sizes)
        }
    };
    let equations = Equations::new(certificate, &system, sizes, multiplier);
    let all = [rates[0].hull(rates[1]) + wide, im + wide];
    let terms = Terms::new(equations, all, changes);
    let derivative = terms.derivative(go_on)?;
    let z1 = derivative.norm(&derivative.within(&terms.changed));
    let refused = |g| Err(Refused::Multiplier { z1: z1.hi(), g });
    if !(Interval::ONE - z1).is_positive() {
        return refused(None);
    }
    let g = |re: Interval| terms.g([re, im], &derivative);
    let (bounds, vanishes) = match multiplier {
        Multiplier::Growing(_) => {
            let bounds = rates.map(|rate| g(rate)[0]);
            (bounds, (-(bounds[0] * bounds[1])).is_positive())
        }
        Multiplier::Doubling { .. } => ([g(rates[0])[0]; 2], true),
        Multiplier::Bloch { rate, .. } => {
            let [own, beside] = [rate[0].enclosed(), rates[1]].map(g);
            let change = norm(beside.iter().zip(&own).map(|(a, b)| *a - *b));
            // Terms of Taylor's series from the second one on, by Cauchy's bounds.
            let rest = norm(terms.g(all, &derivative)) / of(WIDER * (WIDER - 1));
            let bounds = [norm(own), change - of(2) * rest];
            (bounds, (bounds[1] - bounds[0]).is_positive())
        }
    };
    let ends = match multiplier {
        Multiplier::Doubling { .. } => bounds,
        _ if vanishes => rates.map(|rate| (rate * of(2) * Interval::PI / system.omega()).exp()),
        _ => [Interval::exact(f64::NAN); 2],
    };
    let [from, to] = [ends[0].lo(), ends[1].hi()];
    if from <= to { Ok([from, to]) } else { refused(Some(bounds.map(|g| [g.lo(), g.hi()]))) }
}
