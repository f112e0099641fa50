//! Chapter: whether the pieces of a branch are proved of one curve of solutions, and where its
//! period doubles.

use super::{
    Gap, Proof, Refused, System,
    newton::{largest, weight},
};
use crate::{
    certificate::{Certificate, Multiplier},
    interval::Interval,
};
use std::ops::Range;

/// Pieces of a branch, and what the checker says of each.
pub type Pieces<'a> = &'a [(Certificate, Result<Proof, Refused>)];

/// The radius about the cosine sum of a piece that holds the ball of another one, in the norm of
/// the former, and its radius of uniqueness.
fn needed((from, ball): (&System, &Proof), (to, other): (&System, &Proof)) -> [f64; 2] {
    // An unknown frequency has a row of its own.
    let rows = |it: &System| {
        [it.a.clone(), it.first.map(|_| vec![Interval::ZERO, it.middle[0]]).into_iter().collect()].concat()
    };
    let (from, to) = (rows(from), rows(to));
    let of_site = |n: usize| {
        let at = |a: &[Interval], k: usize| a.get(k).copied().unwrap_or(Interval::ZERO);
        let apart = |k: usize| weight(k) * (at(&from[n], k) - at(&to[n], k)).abs();
        let distance: Interval = (0..from[n].len().max(to[n].len())).map(apart).sum();
        let [w, v] = [ball, other].map(|one| Interval::exact(one.weights[n]));
        (distance + w * Interval::exact(ball.radius)) / v
    };
    [largest((0..from.len()).map(of_site)).hi(), other.uniqueness_radius]
}

/// Whether a piece continues the one before it: the solutions of both at their common parameters
/// are the same, since one of the balls lies in the other's ball of uniqueness. Both are proved.
fn joined(before: (&Certificate, &Proof), piece: (&Certificate, &Proof)) -> Result<(), Gap> {
    if before.0.frame() != piece.0.frame() {
        return Err(Gap::Other);
    }
    if before.0.ends()[1] != piece.0.ends()[0] {
        return Err(Gap::Nodes);
    }
    let of = |(it, proof): (&Certificate, _)| System::new(it).map(|system| (system, proof)).map_err(Gap::Refused);
    let [(first, one), (second, other)] = [of(before)?, of(piece)?];
    let [forward, backward] = [needed((&first, one), (&second, other)), needed((&second, other), (&first, one))];
    let fits = [forward, backward].iter().any(|[needed, unique]| needed <= unique);
    if fits { Ok(()) } else { Err(Gap::Apart(forward[0], forward[1])) }
}

/// How many pieces, from the first one on, are proved and make one curve, and why the next one does
/// not continue it.
pub fn connected(pieces: Pieces) -> (usize, Option<Gap>) {
    let mut before = None;
    for (i, (piece, proof)) in pieces.iter().enumerate() {
        let proved = proof.as_ref().map_err(|why| Gap::Refused(why.clone()));
        let continues = |proof| before.map_or(Ok(()), |before| joined(before, (piece, proof))).map(|()| proof);
        match proved.and_then(continues) {
            Ok(proof) => before = Some((piece, proof)),
            Err(gap) => return (i, Some(gap)),
        }
    }
    (pieces.len(), None)
}

/// Bounds of frequencies at which a Floquet multiplier is -1, of the first pieces, which are
/// connected: `g` is continuous along pieces for which the bound of it is proved, of one kind of
/// perturbation, and changes its sign. The bounds hold all frequencies of the pieces between two
/// signs, which may go back and forth. Pieces of one kind along which `g` does not change its sign
/// are an error, with their numbers from 0 on: their certificates have a line for -1, which is not
/// proved.
pub fn doublings(pieces: Pieces) -> Vec<Result<[f64; 2], Range<usize>>> {
    let pieces = &pieces[..connected(pieces).0];
    let kind = |it: &(Certificate, _)| it.0.multiplier.filter(|it| matches!(it, Multiplier::Doubling { .. }));
    let sign = |(_, proof): &(Certificate, Result<Proof, Refused>)| {
        let [lo, hi] = proof.as_ref().ok()?.multiplier?;
        (lo > 0.0 || hi < 0.0).then_some(lo > 0.0)
    };
    let (mut found, mut end) = (Vec::new(), 0);
    for run in pieces.chunk_by(|a, b| kind(a) == kind(b)) {
        end += run.len();
        if kind(&run[0]).is_none() {
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
