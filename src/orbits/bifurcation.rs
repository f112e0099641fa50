//! Bifurcations between the points of a branch, and the branch of doubled period.
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
    arclength::Scales,
    continuation::{Continuation, Place},
    floquet::Spectrum,
    setting::Setting,
    shooting::{Orbit, Shooting},
};
use crate::error::{Error, Result};
use nalgebra::{Complex, DVector};
use serde::{Deserialize, Serialize};

/// The kinds of bifurcation that are located.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BifurcationKind {
    /// A pair of multipliers crosses -1; of driven orbits, one multiplier.
    PeriodDoubling,
    /// A pair crosses 1; of driven orbits, one multiplier, and the branch does not turn.
    PlusOne,
    /// Two pairs meet on the circle and leave it, or the other way round.
    KreinCollision,
    /// Two pairs meet on the real axis and leave it, or the other way round.
    RealCollision,
    /// The branch turns back.
    Fold,
    /// A pair leaves the circle elsewhere than at 1 and -1, or enters it: Neimark-Sacker, of driven
    /// orbits only.
    Torus,
}

impl BifurcationKind {
    /// The kind in words.
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::PeriodDoubling => "a period doubling",
            Self::PlusOne => "a branch point",
            Self::KreinCollision => "a Krein collision",
            Self::RealCollision => "a collision on the real axis",
            Self::Fold => "a fold",
            Self::Torus => "a torus bifurcation",
        }
    }
}

/// A bifurcation point of a branch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bifurcation {
    /// The kind of bifurcation.
    pub kind: BifurcationKind,
    /// Value of the parameter.
    pub parameter: f64,
    /// `tau` at the bifurcation; 1 at a fold.
    pub tau: f64,
    /// The orbit.
    pub orbit: Orbit,
    /// Strains `z` of the eigenvector of `tau`, scaled to the largest entry 1; empty at a fold or
    /// collision.
    pub mode: Vec<f64>,
}

/// Largest number of times that a stretch between two points is halved, until each part has one
/// bifurcation.
const MOST_CUTS: u32 = 5;
/// Largest number of evaluations of a test function.
const MOST_TRIALS: u32 = 60;
/// Error of a located bifurcation, as a share of the stretch.
const LOCATED: f64 = 1e-10;
/// A quartet at one end of a stretch is taken to exist at the other end as well if there is one
/// there whose `Re tau` differs by at most `NEAR` and whose `Im tau` is at least `ALIKE` times as
/// large.
const NEAR: f64 = 0.05;
const ALIKE: f64 = 0.3;
/// Values of `tau` that differ by at most this count as equal by a symmetry; they cross together,
/// as one bifurcation. Chosen larger than errors of `tau`, and smaller than differences between
/// values that no symmetry relates.
const EQUAL: f64 = 1e-8;
/// Largest value of `weak` in the parts of a stretch that is halved to separate its bifurcations.
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

/// A branch of reversible orbits with their multipliers, between whose points bifurcations are
/// sought.
pub(super) trait Branch {
    /// An orbit with its multipliers.
    type Point;
    /// If the corrector fails during the search for the zero of `psi`, the last point counts as the
    /// bifurcation if its `|psi|` is at most this: the corrector is singular where another branch
    /// crosses.
    const NEAR: f64;
    /// The multipliers of a point.
    fn spectrum<'a>(&self, point: &'a Self::Point) -> &'a Spectrum;
    /// Unknowns and parameter of a point.
    fn place(&self, point: &Self::Point) -> (Vec<f64>, f64);
    /// Units of the unknowns and of the parameter for a stretch that begins at `from`, and over
    /// which the parameter changes by `change`.
    fn scales(&self, from: (&[f64], f64), change: f64) -> Scales;
    /// The point that the corrector finds at a distance along the unit chord from a point.
    fn step(&self, from: &Self::Point, chord: &DVector<f64>, scales: Scales, ds: f64) -> Result<Self::Point>;
    /// The unit tangent at a point, with a positive product with `before`.
    fn tangent(&self, at: &Self::Point, scales: Scales, before: &DVector<f64>) -> Result<DVector<f64>>;
}

/// A bifurcation of a branch, with the point there.
pub(super) struct Located<P> {
    pub(super) kind: BifurcationKind,
    pub(super) tau: f64,
    pub(super) point: P,
    /// Number of the point of the branch before it.
    pub(super) after: usize,
}

/// An orbit with its multipliers.
pub(super) struct Known {
    orbit: Orbit,
    spectrum: Spectrum,
}

impl Known {
    fn of((orbit, spectrum): (&Orbit, &Spectrum)) -> Self {
        Self { orbit: orbit.clone(), spectrum: spectrum.clone() }
    }
}

impl Branch for Continuation {
    type Point = Known;
    const NEAR: f64 = 0.0;

    fn spectrum<'a>(&self, point: &'a Known) -> &'a Spectrum {
        &point.spectrum
    }

    fn place(&self, Known { orbit, .. }: &Known) -> (Vec<f64>, f64) {
        (orbit.z.clone(), orbit.setting.get(self.parameter))
    }

    fn scales(&self, (z, p): (&[f64], f64), change: f64) -> Scales {
        let range = (self.to - p).abs();
        Scales::new(z, change.abs().max(1e-3 * range))
    }

    fn step(&self, from: &Known, chord: &DVector<f64>, scales: Scales, ds: f64) -> Result<Known> {
        let place = Place { orbit: from.orbit.clone(), tangent: chord.clone() };
        let orbit = Continuation::step(self, &place, scales, ds)?;
        let spectrum = orbit.spectrum(&self.shooting)?;
        Ok(Known { orbit, spectrum })
    }

    fn tangent(&self, at: &Known, scales: Scales, before: &DVector<f64>) -> Result<DVector<f64>> {
        Continuation::tangent(self, &at.orbit, scales, before)
    }
}

/// The part of a branch between two points, parametrised by their chord.
struct Stretch<'a, B: Branch> {
    branch: &'a B,
    from: &'a B::Point,
    chord: DVector<f64>,
    scales: Scales,
    length: f64,
}

impl<'a, B: Branch> Stretch<'a, B> {
    fn new(branch: &'a B, a: &'a B::Point, b: &B::Point) -> Self {
        let ((z, p), (w, q)) = (branch.place(a), branch.place(b));
        let scales = branch.scales((&z, p), q - p);
        let chord = scales.chord((&z, p), (&w, q));
        let length = chord.norm();
        Self { branch, from: a, chord: chord / length, scales, length }
    }

    fn point(&self, s: f64) -> Result<B::Point> {
        self.branch.step(self.from, &self.chord, self.scales, s * self.length)
    }

    /// The value of `psi` at a point, and the `tau` that it belongs to.
    fn test(&self, test: Test, at: &B::Point) -> Option<(f64, f64)> {
        let spectrum = self.branch.spectrum(at);
        match test {
            Test::MinusOne(k) => reals(spectrum).get(k).map(|&tau| (tau + 1.0, tau)),
            Test::PlusOne(k) => reals(spectrum).iter().rev().nth(k).map(|&tau| (1.0 - tau, tau)),
            Test::Collision(near) => pair_near(spectrum, near).map(|(mean, discriminant)| (discriminant, mean)),
            Test::Fold => {
                let tangent = self.branch.tangent(at, self.scales, &self.chord).ok()?;
                Some((tangent[tangent.len() - 1], 1.0))
            }
        }
    }

    /// The zero of `psi` by the rule of false position (Illinois variant), with the values at both
    /// ends known.
    fn locate(&self, mut test: Test, a: &B::Point, b: &B::Point) -> Option<Located<B::Point>> {
        let (mut left, mut right) = ((0.0, self.test(test, a)?.0), (1.0, self.test(test, b)?.0));
        if left.1 * right.1 > 0.0 {
            return None;
        }
        let mut last: Option<(B::Point, f64)> = None;
        for _ in 0..MOST_TRIALS {
            let s = (left.0 * right.1 - right.0 * left.1) / (right.1 - left.1);
            let Ok(point) = self.point(s) else {
                last = last.filter(|_| right.1.abs() <= B::NEAR);
                break;
            };
            let (psi, tau) = self.test(test, &point)?;
            if let Test::Collision(near) = &mut test {
                *near = tau;
            }
            last = Some((point, tau));
            if psi * right.1 < 0.0 {
                left = right;
            } else {
                left.1 *= 0.5;
            }
            let by = (s - right.0).abs();
            right = (s, psi);
            if psi == 0.0 || by <= LOCATED || (left.0 - right.0).abs() <= LOCATED {
                break;
            }
        }
        let (point, tau) = last?;
        let kind = match test {
            Test::MinusOne(_) => BifurcationKind::PeriodDoubling,
            Test::PlusOne(_) => BifurcationKind::PlusOne,
            Test::Collision(_) if tau.abs() <= 1.0 => BifurcationKind::KreinCollision,
            Test::Collision(_) => BifurcationKind::RealCollision,
            Test::Fold => BifurcationKind::Fold,
        };
        Some(Located { kind, tau, point, after: 0 })
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
    let apart = |&(mean, square): &(f64, f64)| (mean - near).abs() + square.abs().sqrt();
    real.chain(complex).min_by(|a, b| apart(a).total_cmp(&apart(b)))
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

/// The bifurcations between the points of a branch, in the order of the points, with the folds
/// last.
///
/// Quartets with a modulus up to `1 + weak` are left out. A stretch with several bifurcations is
/// halved up to 5 times. Also returned is the number of stretches whose bifurcations are not
/// separated then; these are left out.
pub(super) fn located<B: Branch>(branch: &B, points: &[B::Point], weak: f64) -> (Vec<Located<B::Point>>, usize) {
    let (mut out, mut left_out) = (Vec::new(), 0);
    for (after, pair) in points.windows(2).enumerate() {
        let before = out.len();
        left_out += in_stretch(branch, [&pair[0], &pair[1]], weak, &mut out);
        out[before..].iter_mut().for_each(|one: &mut Located<B::Point>| one.after = after);
    }
    for (after, three) in points.windows(3).enumerate() {
        out.extend(fold(branch, [&three[0], &three[1], &three[2]]).map(|fold| Located { after, ..fold }));
    }
    (out, left_out)
}

/// Appends the bifurcations between two neighbours to `out`. Returns the number of parts whose
/// bifurcations are not separated.
pub(super) fn in_stretch<B: Branch>(
    branch: &B,
    ends: [&B::Point; 2],
    weak: f64,
    out: &mut Vec<Located<B::Point>>,
) -> usize {
    between(branch, ends, &Quartets { weak, near: None }, MOST_CUTS, out)
}

/// The fold between the first and the last of three neighbours, if the branch turns there.
pub(super) fn fold<B: Branch>(branch: &B, three: [&B::Point; 3]) -> Option<Located<B::Point>> {
    if !turns(three.map(|point| branch.place(point).1)) {
        return None;
    }
    let [first, _, last] = three;
    Stretch::new(branch, first, last).locate(Test::Fold, first, last)
}

/// Whether the middle one of three values of the parameter is the largest or the smallest.
fn turns(p: [f64; 3]) -> bool {
    (p[1] - p[0]) * (p[2] - p[1]) < 0.0
}

/// Appends the bifurcations between two points to `out`, after up to `cuts` halvings. Returns the
/// number of parts whose bifurcations are not separated.
fn between<B: Branch>(
    branch: &B,
    [a, b]: [&B::Point; 2],
    wanted: &Quartets,
    cuts: u32,
    out: &mut Vec<Located<B::Point>>,
) -> usize {
    let (found, whole) = tests(branch.spectrum(a), branch.spectrum(b), wanted);
    if found.is_empty() && whole {
        return 0;
    }
    let stretch = Stretch::new(branch, a, b);
    if let ([test], true) = (&found[..], whole)
        && let Some(bifurcation) = stretch.locate(*test, a, b)
    {
        out.push(bifurcation);
        return 0;
    }
    let (1.., Ok(middle)) = (cuts, stretch.point(0.5)) else { return 1 };
    let wanted = wanted.among(&found);
    between(branch, [a, &middle], &wanted, cuts - 1, out) + between(branch, [&middle, b], &wanted, cuts - 1, out)
}

impl Continuation {
    /// The bifurcations between the points of a branch, in the order of the points, with the folds
    /// last.
    ///
    /// Quartets with a modulus up to `1 + weak` are left out. A stretch with several bifurcations
    /// is halved up to 5 times; those that are not separated then are left out.
    pub fn bifurcations(&self, orbits: &[Orbit], spectra: &[Spectrum], weak: f64) -> Vec<Bifurcation> {
        let known: Vec<Known> = orbits.iter().zip(spectra).map(Known::of).collect();
        located(self, &known, weak).0.into_iter().map(|one| self.bifurcation(one)).collect()
    }

    /// Those of [`bifurcations`](Self::bifurcations) that are between two neighbours, without
    /// folds.
    pub(crate) fn bifurcations_between(&self, ends: [(&Orbit, &Spectrum); 2], weak: f64) -> Vec<Bifurcation> {
        let ([a, b], mut found) = (ends.map(Known::of), Vec::new());
        in_stretch(self, [&a, &b], weak, &mut found);
        found.into_iter().map(|one| self.bifurcation(one)).collect()
    }

    /// The one of [`bifurcations`](Self::bifurcations) that is a fold of the branch at the middle
    /// one of three neighbours.
    pub(crate) fn fold_at(&self, three: [(&Orbit, &Spectrum); 3]) -> Option<Bifurcation> {
        let [a, b, c] = three.map(Known::of);
        fold(self, [&a, &b, &c]).map(|fold| self.bifurcation(fold))
    }

    /// Whether a branch through these orbits turns back somewhere.
    pub(crate) fn turns(&self, orbits: &[Orbit]) -> bool {
        let p = |k: usize| orbits[k].setting.get(self.parameter);
        (2..orbits.len()).any(|k| turns([p(k - 2), p(k - 1), p(k)]))
    }

    fn bifurcation(&self, Located { kind, tau, point: Known { orbit, spectrum }, .. }: Located<Known>) -> Bifurcation {
        let single = matches!(kind, BifurcationKind::PeriodDoubling | BifurcationKind::PlusOne);
        let mode = if single { spectrum.strains_of(tau) } else { Vec::new() };
        Bifurcation { kind, parameter: orbit.setting.get(self.parameter), tau, orbit, mode }
    }
}

impl Bifurcation {
    /// The first orbit of doubled period after a period doubling.
    ///
    /// The guess is `Z + size max|Z| z`; it is corrected at fixed distance along `z`.
    ///
    /// # Errors
    /// A bifurcation of another kind, a size that is not in `(0, 1]`, or no convergence.
    pub fn doubled(&self, shooting: &Shooting, size: f64) -> Result<Orbit> {
        if self.kind != BifurcationKind::PeriodDoubling {
            return Err(Error::parameter(
                "kind",
                format!("{:?}", self.kind),
                "the period doubles at a period doubling only",
            ));
        }
        if !(size > 0.0 && size <= 1.0) {
            return Err(Error::parameter("size", size, "a share of the amplitude in (0, 1]"));
        }
        let omega_b = 0.5 * self.orbit.setting.omega_b;
        let orbit = Orbit { setting: Setting { omega_b, turns: 2, ..self.orbit.setting }, ..self.orbit.clone() };
        // Near a pitchfork the frequency changes with the square of the amplitude, so the scale of
        // the parameter does not matter.
        let continuation = Continuation {
            parameter: super::Parameter::OmegaB,
            to: 1.01 * omega_b,
            step: 0.01,
            most_points: 2,
            natural: false,
            shooting: *shooting,
        };
        let scales = continuation.scales(&orbit, omega_b);
        let mode = DVector::from_iterator(self.mode.len() + 1, self.mode.iter().copied().chain([0.0]));
        let ds = size * orbit.amplitude() * mode.norm() / scales.state;
        continuation.step(&Place { orbit, tangent: mode.normalize() }, scales, ds)
    }
}
