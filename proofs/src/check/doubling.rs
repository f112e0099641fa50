//! Chapter: where the period of breathers doubles along a branch: a Floquet multiplier is -1, where
//! `g` of the linearised equations is 0 ("Period doubling" in `README.md`).

use super::{
    Proof, Refused, System,
    bloch::sizes,
    branch::{Pieces, connected},
    of,
    perturbed::{Bent, Equations, Factors, MIDDLE, Terms},
    system::{inverse, poles},
};
use crate::{
    certificate::{Certificate, Multiplier},
    interval::Interval,
    untrusted::choices,
};
use std::ops::Range;

/// Bounds of `g` along a piece, where the strains of the orbit differ by at most `changes` from the
/// cosine sums. Harmonics are `k + 1/2`.
pub fn check(
    certificate: &Certificate,
    (system, changes): (&System, &[Interval]),
    go_on: &dyn Fn() -> Result<(), Refused>,
) -> Result<[f64; 2], Refused> {
    let (system, poles, last) = (system.perturbed(), poles(&certificate.model), certificate.enclosed as i64 + 2);
    let square = (system.omega() / of(2)).square();
    let factor = |k: i64| [inverse(&poles, square, (2 * k + 1).unsigned_abs() as usize)[0], Interval::ZERO];
    let l: Factors = (-last..=last).map(factor).collect();
    let pinned = (false, vec![vec![(0, MIDDLE)]]);
    let equations = Equations::new(&system, certificate.model.alpha, sizes(certificate, false), pinned);
    let terms = Terms::new(equations, l, None, changes);
    let (p, g) = choices::perturbation(&terms, &terms.l, None);
    let (it, l) = (&terms.it, &terms.l);
    let straight = Bent { value: &|_, _| Interval::ZERO, contacts: Vec::new(), late: Interval::ZERO };
    let value = |place| it.defect(l, (&p, &g), place);
    let [radius, q] = terms.solved((&p, &value, &it.given(&p)), (&straight, Interval::ZERO), go_on)?;
    let found = g[0] + radius.ball();
    let proved = (Interval::ONE - q).is_positive() && !found.is_nan();
    let refused = Refused::Perturbation { p_over_pi: None, radius: radius.hi(), q: q.hi() };
    if proved { Ok([found.lo(), found.hi()]) } else { Err(refused) }
}

/// Bounds of frequencies at which a Floquet multiplier is -1, of the first pieces, which are
/// connected: `g` is continuous along pieces for which the bound of it is proved, and changes its
/// sign. The bounds hold all frequencies of the pieces between two signs, which may go back and
/// forth. Pieces along which `g` does not change its sign are an error, with their numbers from 0
/// on: their certificates have a line for -1, which is not proved.
pub fn doublings(pieces: Pieces) -> Vec<Result<[f64; 2], Range<usize>>> {
    let pieces = &pieces[..connected(pieces).0];
    let kind = |it: &(Certificate, _)| it.0.multiplier == Some(Multiplier::Doubling);
    let sign = |(_, proof): &(Certificate, Result<Proof, Refused>)| {
        let [lo, hi] = proof.as_ref().ok()?.multiplier?;
        (lo > 0.0 || hi < 0.0).then_some(lo > 0.0)
    };
    let (mut found, mut end) = (Vec::new(), 0);
    for run in pieces.chunk_by(|a, b| kind(a) == kind(b)) {
        end += run.len();
        if !kind(&run[0]) {
            continue;
        }
        let signs: Vec<(usize, bool)> = run.iter().enumerate().filter_map(|(i, it)| Some((i, sign(it)?))).collect();
        for pair in signs.windows(2).filter(|pair| pair[0].1 != pair[1].1) {
            let nodes = run[pair[0].0..pair[1].0].iter().filter_map(|(piece, _)| Some(piece.to?[0].enclosed()));
            found.extend(nodes.reduce(Interval::hull).map(|all| Ok([all.lo(), all.hi()])));
        }
        if signs.windows(2).all(|pair| pair[0].1 == pair[1].1) {
            found.push(Err(end - run.len()..end));
        }
    }
    found
}
