//! Bifurcations between the points of a branch of reversible orbits.
//!
//! | symbol | meaning |
//! |---|---|
//! | `X(s)` | branch between two points, over their chord from `s = 0` to `s = 1` |
//! | `psi(s)` | test function, zero at the bifurcation |
//!
//! - `tau` crosses -1: `psi = tau + 1`, a period doubling. `tau` crosses 1: `psi = 1 - tau`.
//! - Two real `tau` meet and become complex: `psi = (tau_1 - tau_2)^2/4`, which has a simple zero
//!   where `tau` has a square root. If they meet on the circle, their signatures differ. Collisions
//!   that lead to no modulus above `1 + weak` are left out: in the bands of a long ring there are
//!   many of them.
//! - A fold: `psi` is the component of the tangent along the parameter.

use super::{
    branch::{At, BifurcationKind, Branch, Located, Problem},
    chord::Chord,
    floquet::Spectrum,
};
use crate::numerics::least_by;
use nalgebra::Complex;
use serde::{Deserialize, Serialize};

/// The multipliers that meet at a bifurcation of reversible orbits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CriticalPair {
    /// `tau = (lambda + 1/lambda)/2`; 1 at a fold.
    pub tau: f64,
    /// Strains `z` of the eigenvector of `tau`, scaled to 1 at the first of its largest entries;
    /// empty at a fold or collision.
    pub mode: Vec<f64>,
}

/// Largest number of times that an interval between two points is halved, until each part has one
/// bifurcation.
const MOST_CUTS: u32 = 5;
/// Error of a located bifurcation, as a share of the interval.
const LOCATED: f64 = 1e-10;
/// A quartet at one end of an interval is taken to exist at the other end as well if there is one
/// there whose `Re tau` differs by at most `NEAR` and whose `Im tau` is at least `ALIKE` times as
/// large.
const NEAR: f64 = 0.05;
const ALIKE: f64 = 0.3;
/// Values of `tau` that differ by at most this count as equal by a symmetry; they cross together,
/// as one bifurcation. Chosen larger than errors of `tau`, and smaller than differences between
/// values that no symmetry relates.
const EQUAL: f64 = 1e-8;
/// Largest value of `weak` in the parts of an interval that is halved to separate its bifurcations.
const WEAK_INSIDE: f64 = 1e-4;

#[derive(Clone, Copy, Debug)]
enum Test {
    /// The `k`-th smallest real `tau`, from `k = 0`, crosses -1.
    MinusOne(usize),
    /// The `k`-th largest real `tau`, from `k = 0`, crosses 1.
    PlusOne(usize),
    /// Two `tau` meet near this value.
    Collision(f64),
    /// The component of the tangent along the parameter changes its sign.
    Fold,
}

/// Problems with reversible orbits.
pub(super) trait Reversible: Problem<Spectrum = Spectrum, Critical = CriticalPair> {}

impl<P: Problem<Spectrum = Spectrum, Critical = CriticalPair>> Reversible for P {}

/// What all of them have.
macro_rules! reversible {
    () => {
        type Spectrum = Spectrum;
        type Critical = bifurcation::CriticalPair;

        fn multipliers(spectrum: &Spectrum) -> Vec<[f64; 3]> {
            spectrum.numbers()
        }

        fn between(branch: &Branch<Self>, ends: [At<'_, Self>; 2]) -> (Vec<Located<Self>>, usize) {
            bifurcation::between(branch, ends)
        }

        fn fold(branch: &Branch<Self>, three: [At<'_, Self>; 3]) -> Option<Located<Self>> {
            bifurcation::fold(branch, three)
        }
    };
}
pub(super) use reversible;

impl<P: Reversible> Chord<'_, P> {
    /// The value of `psi` at an orbit, and the `tau` that it belongs to.
    fn test(&self, test: Test, (orbit, spectrum): At<'_, P>) -> Option<(f64, f64)> {
        match test {
            Test::MinusOne(k) => reals(spectrum).get(k).map(|&tau| (tau + 1.0, tau)),
            Test::PlusOne(k) => reals(spectrum).iter().rev().nth(k).map(|&tau| (1.0 - tau, tau)),
            Test::Collision(near) => pair_near(spectrum, near).map(|(mean, discriminant)| (discriminant, mean)),
            Test::Fold => Some((self.slope(orbit).ok()?, 1.0)),
        }
    }

    /// The bifurcation at the zero of `psi`, with its values at both ends known.
    fn locate(&self, mut test: Test, a: At<'_, P>, b: At<'_, P>) -> Option<Located<P>> {
        let ends = [self.test(test, a)?.0, self.test(test, b)?.0];
        if ends[0] * ends[1] > 0.0 {
            return None;
        }
        let mut last = f64::NAN;
        let psi = |at: At<'_, P>| {
            let (psi, tau) = self.test(test, at)?;
            if let Test::Collision(near) = &mut test {
                *near = tau;
            }
            last = tau;
            Some(psi)
        };
        let ((orbit, spectrum), _) = self.zero(ends, (0.0, LOCATED), psi)?;
        let tau = last;
        let kind = match test {
            Test::MinusOne(_) => BifurcationKind::PeriodDoubling,
            Test::PlusOne(_) => BifurcationKind::PlusOne,
            Test::Collision(_) if tau.abs() <= 1.0 => BifurcationKind::KreinCollision,
            Test::Collision(_) => BifurcationKind::RealCollision,
            Test::Fold => BifurcationKind::Fold,
        };
        let single = matches!(kind, BifurcationKind::PeriodDoubling | BifurcationKind::PlusOne);
        let mode = if single { spectrum.strains_of(tau) } else { Vec::new() };
        Some(self.located(kind, CriticalPair { tau, mode }, &orbit))
    }
}

/// The real `tau` that are not exactly known, in increasing order.
fn reals(spectrum: &Spectrum) -> Vec<f64> {
    let mut reals: Vec<f64> = spectrum.free().filter(|(tau, _)| tau.im == 0.0).map(|(tau, _)| tau.re).collect();
    reals.sort_by(f64::total_cmp);
    reals
}

/// The selection of quartets that count.
#[derive(Clone, Debug)]
struct Quartets {
    /// Only those with a modulus above `1 + weak`.
    weak: f64,
    /// If given: only those with `Re tau` near one of these values.
    near: Option<Vec<f64>>,
}

impl Quartets {
    /// The `tau` of the selected quartets in the upper half plane.
    fn of(&self, spectrum: &Spectrum) -> Vec<Complex<f64>> {
        let strong = |tau: &Complex<f64>| (tau + (tau * tau - 1.0).sqrt()).norm().ln().abs() > self.weak.ln_1p();
        let near = |tau: &Complex<f64>| {
            self.near.as_ref().is_none_or(|near| near.iter().any(|value| (tau.re - value).abs() <= NEAR))
        };
        let upper = spectrum.free().map(|(tau, _)| tau).filter(|tau| tau.im > 0.0);
        upper.filter(|tau| strong(tau) && near(tau)).collect()
    }

    /// The selection that separates the collisions just found.
    fn among(&self, found: &[Test]) -> Self {
        let near = found.iter().filter_map(|test| if let Test::Collision(near) = test { Some(*near) } else { None });
        Self { weak: self.weak.min(WEAK_INSIDE), near: Some(near.collect()) }
    }
}

/// Mean and `(tau_1 - tau_2)^2/4` of the two `tau` that are nearest to a collision at the given
/// value.
///
/// They are conjugates, or real neighbours that may leave the axis: their signatures differ, or are
/// zero as after a collision.
fn pair_near(spectrum: &Spectrum, near: f64) -> Option<(f64, f64)> {
    let mut axis: Vec<(f64, i8)> =
        spectrum.free().filter(|(tau, _)| tau.im == 0.0).map(|(tau, krein)| (tau.re, krein)).collect();
    axis.sort_by(|a, b| a.0.total_cmp(&b.0));
    let real = axis.windows(2).filter(|w| w[0].1 != w[1].1 || w[0].1 == 0).map(|w| {
        let half = 0.5 * (w[1].0 - w[0].0);
        (0.5 * (w[0].0 + w[1].0), half * half)
    });
    let complex = spectrum.free().filter(|(tau, _)| tau.im > 0.0).map(|(tau, _)| (tau.re, -tau.im * tau.im));
    // The distance of the value from the mean, plus half the distance of the two.
    least_by(real.chain(complex), |&(mean, square)| (mean - near).abs() + square.abs().sqrt())
}

/// The tests whose functions change sign between two points, and whether these tests explain all
/// changes.
fn tests(a: &Spectrum, b: &Spectrum, wanted: &Quartets) -> (Vec<Test>, bool) {
    let any = Quartets { weak: 0.0, near: None };
    let (mut found, mut real_pairs) = (Vec::new(), [0i64; 2]);
    for (ours, theirs, sign) in [(b, a, 1), (a, b, -1)] {
        for tau in wanted.of(ours) {
            let same = |other: &Complex<f64>| (other.re - tau.re).abs() <= NEAR && other.im >= ALIKE * tau.im;
            if !any.of(theirs).iter().any(same) {
                let again = |test: &Test| matches!(test, Test::Collision(near) if (near - tau.re).abs() <= EQUAL);
                if !found.iter().any(again) {
                    found.push(Test::Collision(tau.re));
                }
                // Each collision takes two tau from the real axis.
                real_pairs[0] -= 2 * sign * i64::from(tau.re < -1.0);
                real_pairs[1] -= 2 * sign * i64::from(tau.re > 1.0);
            }
        }
    }
    let beyond = |spectrum: &Spectrum| {
        let reals = reals(spectrum);
        [reals.iter().filter(|&&tau| tau < -1.0).count(), reals.iter().filter(|&&tau| tau > 1.0).count()]
    };
    let (before, after) = (beyond(a), beyond(b));
    let mut whole = true;
    for side in 0..2 {
        let change = after[side] as i64 - before[side] as i64 - real_pairs[side];
        let k = before[side].min(after[side]);
        if change == 0 {
            continue;
        }
        let crossing = k..k + change.unsigned_abs() as usize;
        let together = [a, b].into_iter().all(|spectrum| {
            let mut reals = reals(spectrum);
            if side == 1 {
                reals.reverse();
            }
            reals.get(crossing.clone()).is_some_and(|tau| (tau[tau.len() - 1] - tau[0]).abs() <= EQUAL)
        });
        if together {
            found.push(if side == 0 { Test::MinusOne(k) } else { Test::PlusOne(k) });
        } else {
            whole = false;
        }
    }
    (found, whole)
}

/// The bifurcations between two neighbours, and the number of parts whose bifurcations are not
/// separated. Quartets with a modulus up to `1 + weak` are left out.
pub(super) fn between<P: Reversible>(branch: &Branch<P>, ends: [At<'_, P>; 2]) -> (Vec<Located<P>>, usize) {
    let (mut found, wanted) = (Vec::new(), Quartets { weak: branch.weak.unwrap_or(0.0), near: None });
    let unresolved = search(branch, ends, &wanted, MOST_CUTS, &mut found);
    (found, unresolved)
}

/// The fold between the first and the last of three neighbours, if the branch turns there.
pub(super) fn fold<P: Reversible>(branch: &Branch<P>, three: [At<'_, P>; 3]) -> Option<Located<P>> {
    let [a, b, c] = three.map(|(orbit, _)| branch.parameter(orbit));
    let [first, _, last] = three;
    let turns = (b - a) * (c - b) < 0.0;
    turns.then(|| Chord::new(branch, first.0, last.0).locate(Test::Fold, first, last))?
}

/// Appends the bifurcations between two points to `out`, after up to `cuts` halvings. Returns the
/// number of parts whose bifurcations are not separated.
fn search<P: Reversible>(
    branch: &Branch<P>,
    [a, b]: [At<'_, P>; 2],
    wanted: &Quartets,
    cuts: u32,
    out: &mut Vec<Located<P>>,
) -> usize {
    let (found, whole) = tests(a.1, b.1, wanted);
    if found.is_empty() && whole {
        return 0;
    }
    let chord = Chord::new(branch, a.0, b.0);
    if let ([test], true) = (&found[..], whole)
        && let Some(bifurcation) = chord.locate(*test, a, b)
    {
        out.push(bifurcation);
        return 0;
    }
    let (1.., Ok((orbit, spectrum))) = (cuts, chord.point(0.5)) else { return 1 };
    let (wanted, middle) = (wanted.among(&found), (&orbit, &spectrum));
    search(branch, [a, middle], &wanted, cuts - 1, out) + search(branch, [middle, b], &wanted, cuts - 1, out)
}
