//! Chapter: whether the pieces of a branch are proved of one curve of solutions, and where its
//! period doubles.

use super::{
    Gap, Proof, Refused, System,
    newton::{largest, weight},
};
use crate::{
    certificate::{Certificate, Model, Multiplier},
    exact::Exact,
    interval::Interval,
};
use std::ops::Range;

/// Pieces of a branch, and what the checker says of each.
pub type Pieces<'a> = &'a [(Certificate, Result<Proof, Refused>)];

impl Certificate {
    /// Parameter and mean strain at the start and at the end; of a single orbit twice the same. The
    /// parameter is the frequency or, where this is unknown, `a_1`.
    pub fn ends(&self) -> [[Exact; 2]; 2] {
        let start = [self.model.omega, self.mean];
        let ends = [start, self.to.unwrap_or(start)];
        [0, 1].map(|i| [self.first.map_or(ends[i][0], |first| first[i]), ends[i][1]])
    }

    /// Whether both are of the same chain and kind of orbit.
    pub fn is_alike(&self, other: &Self) -> bool {
        let model = Model { omega: other.model.omega, ..self.model };
        let shape = |it: &Self| (it.orbit.clone(), it.first.is_some(), it.a.len());
        (model, shape(self)) == (other.model, shape(other))
    }
}

/// The cosine sum in the middle of a piece. An unknown frequency has a row of its own.
fn rows(piece: &Certificate) -> Result<Vec<Vec<Interval>>, Gap> {
    let System { mut a, first, middle, .. } = System::new(piece).map_err(Gap::Refused)?;
    a.extend(first.map(|_| vec![Interval::ZERO, middle[0]]));
    Ok(a)
}

/// Whether a piece continues the one before it: the solutions of both at their common parameters
/// are the same, since one of the balls lies in the other's ball of uniqueness. Both are proved.
fn joined((before, one): (&Certificate, &Proof), (piece, other): (&Certificate, &Proof)) -> Result<(), Gap> {
    if !before.is_alike(piece) {
        return Err(Gap::Other);
    }
    if before.ends()[1] != piece.ends()[0] {
        return Err(Gap::Nodes);
    }
    let (from, to) = (rows(before)?, rows(piece)?);
    let apart = |n: usize| -> Interval {
        let at = |rows: &[Vec<Interval>], k: usize| rows[n].get(k).copied().unwrap_or(Interval::ZERO);
        let of = |k: usize| weight(k) * (at(&from, k) - at(&to, k)).abs();
        (0..from[n].len().max(to[n].len())).map(of).sum()
    };
    // The radius about the cosine sum of a piece that holds the ball of the other one.
    let needed = |ball: &Proof, about: &Proof| {
        let w = |it: &Proof, n: usize| Interval::exact(it.weights[n]);
        let of_site = |n: usize| (apart(n) + w(ball, n) * Interval::exact(ball.radius)) / w(about, n);
        largest((0..from.len()).map(of_site)).hi()
    };
    let forward = needed(one, other);
    let fits = forward <= other.uniqueness_radius || needed(other, one) <= one.uniqueness_radius;
    if fits { Ok(()) } else { Err(Gap::Apart(forward, other.uniqueness_radius)) }
}

/// How many pieces, from the first one on, are proved and make one curve, and why the next one does
/// not continue it.
pub fn connected(pieces: Pieces) -> (usize, Option<Gap>) {
    let proved = |i: usize| match &pieces[i] {
        (piece, Ok(proof)) => Ok((piece, proof)),
        (_, Err(why)) => Err(Gap::Refused(why.clone())),
    };
    let continues = |i: usize| proved(i).and_then(|piece| if i > 0 { joined(proved(i - 1)?, piece) } else { Ok(()) });
    let gap = (0..pieces.len()).find_map(|i| Some((i, continues(i).err()?)));
    gap.map_or((pieces.len(), None), |(i, gap)| (i, Some(gap)))
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
    let sign = |i: usize| {
        let [lo, hi] = pieces[i].1.as_ref().ok()?.multiplier?;
        (lo > 0.0 || hi < 0.0).then_some((i, lo > 0.0))
    };
    let (mut found, mut end) = (Vec::new(), 0);
    for run in pieces.chunk_by(|a, b| kind(a) == kind(b)) {
        let run = end..end + run.len();
        end = run.end;
        if kind(&pieces[run.start]).is_none() {
            continue;
        }
        let signs: Vec<(usize, bool)> = run.clone().filter_map(sign).collect();
        let changes: Vec<_> = signs.windows(2).filter(|pair| pair[0].1 != pair[1].1).collect();
        found.extend(changes.is_empty().then_some(Err(run)));
        for pair in changes {
            let nodes = pieces[pair[0].0..pair[1].0].iter().map(|(piece, _)| piece.ends()[1][0].enclosed());
            found.extend(nodes.reduce(Interval::hull).map(|all| Ok([all.lo(), all.hi()])));
        }
    }
    found
}
