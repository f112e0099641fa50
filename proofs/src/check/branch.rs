//! Whether the pieces of a branch are proved of one curve of solutions, and where its period
//! doubles.

use super::{Proof, Refused, of};
use crate::{
    certificate::{Certificate, Multiplier, Orbit},
    exact::Exact,
    interval::Interval,
};
use std::fmt;

/// Why a piece does not continue the one before it.
#[derive(Clone, Debug, PartialEq)]
pub enum Gap {
    /// It is not proved.
    Refused(Refused),
    /// It is no piece: it has no end.
    Point,
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
            Self::Point => f.write_str("it has no line \"to\", so it is no piece of a branch"),
            Self::Other => f.write_str("it is of another chain or kind of orbit than the piece before it"),
            Self::Nodes => f.write_str("it does not begin where the piece before it ends"),
            Self::Apart(needed, unique) => write!(
                f,
                "the ball of the piece before it needs a radius of uniqueness of {needed:.2e} here, not {unique:.2e}"
            ),
        }
    }
}

/// The part of a certificate that all pieces share.
fn frame(certificate: &Certificate) -> Certificate {
    let mut frame = certificate.clone();
    (frame.model.omega, frame.mean, frame.to) = (Exact::ONE, Exact::ONE, None);
    (frame.block, frame.enclosed, frame.multiplier) = (0, 0, None);
    match &mut frame.orbit {
        Orbit::Wave(wave) => wave.a.clear(),
        Orbit::Breather(breather) => breather.a.clear(),
        Orbit::Infinite(infinite) => infinite.a.clear(),
    }
    frame
}

/// The radius about the cosine sum of `to` that holds the ball of `from`, in the norm of `to`. The
/// mean of a wave is no unknown, and `c_0` free: T contracts whatever it is.
fn needed((from, ball): (&Certificate, &Proof), (to, other): (&Certificate, &Proof)) -> f64 {
    let rows = |certificate: &Certificate| match &certificate.orbit {
        Orbit::Wave(wave) => vec![[&[0.0], wave.a.as_slice()].concat()],
        Orbit::Breather(breather) => breather.a.clone(),
        // No piece of a branch.
        Orbit::Infinite(infinite) => infinite.a.clone(),
    };
    let (from, to) = (rows(from), rows(to));
    let of_site = |n: usize| {
        let at = |a: &[f64], k: usize| Interval::exact(a.get(k).copied().unwrap_or(0.0));
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
            _ if piece.to.is_none() => Err(Gap::Point),
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
/// back and forth.
pub fn doublings(pieces: &[(Certificate, Result<Proof, Refused>)]) -> Vec<[f64; 2]> {
    let mut found = Vec::new();
    let both = |a: Interval, b: Interval| Interval::new(a.lo().min(b.lo()), a.hi().max(b.hi()));
    // The kind, the sign of g on the last piece where it has one, and the frequencies since this
    // ends.
    let mut before: Option<(Multiplier, bool, Interval)> = None;
    for (piece, proof) in pieces {
        let g = proof.as_ref().ok().and_then(|proof| proof.multiplier);
        let (Some(kind @ Multiplier::Doubling { .. }), Some([lo, hi]), Some([end, _])) =
            (piece.multiplier, g, piece.to)
        else {
            before = None;
            continue;
        };
        let [start, end] = [piece.model.omega, end].map(Exact::enclosed);
        before = before.filter(|it| it.0 == kind).map(|(kind, sign, since)| (kind, sign, both(since, start)));
        if lo > 0.0 || hi < 0.0 {
            found.extend(before.filter(|it| it.1 != (lo > 0.0)).map(|it| [it.2.lo(), it.2.hi()]));
            before = Some((kind, lo > 0.0, end));
        } else {
            before = before.map(|(kind, sign, since)| (kind, sign, both(since, end)));
        }
    }
    found
}

/// Whether a piece continues the one before it: the solutions of both at their common parameters
/// are the same, since one of the balls lies in the other's ball of uniqueness. Both are proved.
fn joined(before: (&Certificate, &Proof), piece: (&Certificate, &Proof)) -> Result<(), Gap> {
    if frame(before.0) != frame(piece.0) {
        return Err(Gap::Other);
    }
    let (Some(end), Some(_)) = (before.0.to, piece.0.to) else { return Err(Gap::Point) };
    if end != [piece.0.model.omega, piece.0.mean] {
        return Err(Gap::Nodes);
    }
    let forward = (needed(before, piece), piece.1.uniqueness_radius);
    let backward = (needed(piece, before), before.1.uniqueness_radius);
    let fits = |(needed, unique): (f64, f64)| needed <= unique;
    if fits(forward) || fits(backward) { Ok(()) } else { Err(Gap::Apart(forward.0, forward.1)) }
}
