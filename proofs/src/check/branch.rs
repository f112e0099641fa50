//! Whether the pieces of a branch are proved of one curve of solutions, where its period doubles,
//! and where its frequency turns back.

use super::{Proof, Refused, of};
use crate::{
    certificate::{Certificate, Multiplier, Orbit},
    exact::Exact,
    interval::Interval,
};
use std::{fmt, ops::Range};

/// Why a piece does not continue the one before it.
#[derive(Clone, Debug, PartialEq)]
pub enum Gap {
    /// It is not proved.
    Refused(Refused),
    /// It is of another chain or kind of orbit.
    Other,
    /// It does not begin where the one before it ends.
    Nodes,
    /// No ball lies within the other's ball of uniqueness: the radius that is needed, and that of
    /// uniqueness.
    Apart(f64, f64),
}

impl fmt::Display for Gap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused(why) => why.fmt(f),
            Self::Other => f.write_str("it is of another chain or kind of orbit than the piece before it"),
            Self::Nodes => f.write_str("it does not begin where the piece before it ends"),
            Self::Apart(needed, unique) => write!(
                f,
                "the ball of the piece before it needs a radius of uniqueness of {needed:.2e} here, not {unique:.2e}"
            ),
        }
    }
}

/// The radius about the cosine sum of `to` that holds the ball of `from`, in the norm of `to`.
fn needed((from, ball): (&Certificate, &Proof), (to, other): (&Certificate, &Proof)) -> f64 {
    let rows = |it: &Certificate| {
        let exact = |a: &Vec<f64>| a.iter().map(|a| Interval::exact(*a)).collect();
        let mut rows: Vec<Vec<Interval>> = it.orbit.rows().iter().map(exact).collect();
        let start = [it.model.omega, it.mean];
        let middle = |i: usize| start[i].enclosed() / of(2) + it.to.unwrap_or(start)[i].enclosed() / of(2);
        if let (Orbit::Wave(_), [row]) = (&it.orbit, &mut rows[..]) {
            row.insert(0, middle(1));
        }
        // An unknown frequency has a row of its own.
        rows.extend(it.first.map(|_| vec![Interval::ZERO, middle(0)]));
        rows
    };
    let (from, to) = (rows(from), rows(to));
    let of_site = |n: usize| {
        let at = |a: &[Interval], k: usize| a.get(k).copied().unwrap_or(Interval::ZERO);
        let apart = |k: usize| (at(&from[n], k) - at(&to[n], k)).abs();
        let means = of(2).sqrt() * apart(0);
        let distance = means + (1..from[n].len().max(to[n].len())).map(apart).sum();
        let [w, v] = [ball, other].map(|one| Interval::exact(one.weights[n]));
        (distance + w * ball.radius.into()) / v
    };
    (0..from.len()).map(of_site).fold(Interval::ZERO, Interval::max).hi()
}

/// How many pieces, from the first one on, are proved and make one curve, and why the next one does
/// not continue it.
pub fn connected(pieces: &[(Certificate, Result<Proof, Refused>)]) -> (usize, Option<Gap>) {
    for (i, (piece, proof)) in pieces.iter().enumerate() {
        let proof = match proof {
            Ok(proof) => proof,
            Err(why) => return (i, Some(Gap::Refused(why.clone()))),
        };
        let continues = match i.checked_sub(1).and_then(|before| pieces.get(before)) {
            Some((before, Ok(ball))) => joined((before, ball), (piece, proof)),
            _ => Ok(()),
        };
        if let Err(gap) = continues {
            return (i, Some(gap));
        }
    }
    (pieces.len(), None)
}

/// Bounds of frequencies at which a Floquet multiplier is -1, of connected pieces: `g` is
/// continuous along pieces for which the bound of it is proved, of one kind of perturbation, and
/// changes its sign. The bounds hold all frequencies of the pieces between two signs, which may go
/// back and forth. Pieces of one kind along which `g` does not change its sign are an error, with
/// their numbers from 0 on: their certificates have a line for -1, which is not proved.
pub fn doublings(pieces: &[(Certificate, Result<Proof, Refused>)]) -> Vec<Result<[f64; 2], Range<usize>>> {
    let kind = |(piece, proof): &(Certificate, Result<Proof, Refused>)| {
        piece.multiplier.filter(|it| proof.is_ok() && matches!(it, Multiplier::Doubling { .. }))
    };
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
            let hull = |all: Interval, one: Interval| Interval::new(all.lo().min(one.lo()), all.hi().max(one.hi()));
            found.extend(nodes.reduce(hull).map(|all| Ok([all.lo(), all.hi()])));
        }
        if signs.windows(2).all(|pair| pair[0].1 == pair[1].1) {
            found.push(Err(end - run.len()..end));
        }
    }
    found
}

/// Bounds of the least and of the largest frequency along connected pieces, of each that is not
/// found at an end of the curve: there the frequency turns back. Of pieces at one mean
/// strain along which the first harmonic goes one way: others may go back themselves.
pub fn turns(pieces: &[(Certificate, Result<Proof, Refused>)]) -> Vec<[f64; 2]> {
    let ends: Vec<[[Exact; 2]; 2]> = pieces.iter().map(|(piece, _)| piece.ends()).collect();
    let rise = |[start, end]: &[[Exact; 2]; 2]| end[0].enclosed() - start[0].enclosed();
    let one_way = ends.iter().all(|it| rise(it).is_positive()) || ends.iter().all(|it| (-rise(it)).is_positive());
    let one_mean = ends.iter().flatten().all(|end| end[1] == ends[0][0][1]);
    if !(one_way && one_mean && pieces.iter().all(|(piece, _)| piece.first.is_some())) {
        return Vec::new();
    }
    let all: Vec<[f64; 2]> = pieces.iter().filter_map(|(_, proof)| Some(proof.as_ref().ok()?.frequency)).collect();
    let least = |all: &[[f64; 2]]| {
        let [lo, hi] = [0, 1].map(|end| all.iter().map(|one| one[end]).fold(f64::INFINITY, f64::min));
        let ends = [all.first()?, all.last()?];
        ends.into_iter().all(|end| hi < end[0]).then_some([lo, hi])
    };
    let turned = |[lo, hi]: [f64; 2]| [-hi, -lo];
    let most = least(&all.iter().copied().map(turned).collect::<Vec<_>>()).map(turned);
    least(&all).into_iter().chain(most).collect()
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
    let forward = (needed(before, piece), piece.1.uniqueness_radius);
    let backward = (needed(piece, before), before.1.uniqueness_radius);
    let fits = |(needed, unique): (f64, f64)| needed <= unique;
    if fits(forward) || fits(backward) { Ok(()) } else { Err(Gap::Apart(forward.0, forward.1)) }
}
