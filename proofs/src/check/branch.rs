//! Chapter: pieces of a branch, and whether they are proved of one curve of solutions ("Branches"
//! in `README.md`).

use super::{
    Gap, Proof, Refused, System,
    newton::{Place, largest, weight},
};
use crate::{
    certificate::{Certificate, Model},
    exact::Exact,
    interval::Interval,
};

/// Pieces of a branch, and what the checker says of each.
pub type Pieces<'a> = &'a [(Certificate, Result<Proof, Refused>)];

impl System {
    /// The change of `l_k sum_m e_nm n_mk` along one half of a piece.
    pub fn turn(&self, n: usize, k: usize) -> Interval {
        self.slopes[k] * self.force(n, k)
    }

    /// The change of `G` along one half of a piece; where the frequency is unknown that of the mean
    /// strain and of `a_1`.
    pub(super) fn rates(&self, all: &[Place]) -> Vec<Interval> {
        let rate = |&(n, k): &Place| match k {
            0 if self.closes(n) => -self.mean[1],
            _ if self.first.is_some() => Interval::ZERO,
            _ => -self.turn(n, k),
        };
        all.iter().map(rate).chain(self.first.map(|it| -it[1])).collect()
    }
}

impl Certificate {
    /// What all pieces of a branch share: the chain and the kind of orbit.
    pub fn frame(&self) -> Self {
        let (to, first, mean) = (None, self.first.map(|_| [Exact::ONE; 2]), Exact::ONE);
        let (model, multiplier, orbit) = (Model { omega: Exact::ONE, ..self.model }, None, self.orbit.clone());
        Self { model, mean, to, first, block: 0, enclosed: 0, orbit, a: Vec::new(), multiplier, bloch: Vec::new() }
    }
}

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
