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
/// A quartet is the same on both sides if `Re tau` differs by at most `NEAR` and `Im tau` there is
/// at least `ALIKE` of that here.
const NEAR: f64 = 0.05;
const ALIKE: f64 = 0.3;
/// The value of `weak` inside a stretch, where bifurcations are separated.
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

/// An orbit with its multipliers.
struct Known {
    orbit: Orbit,
    spectrum: Spectrum,
}

/// A part of a branch, over the chord of its ends.
struct Stretch<'a> {
    continuation: &'a Continuation,
    place: Place,
    scales: Scales,
    length: f64,
}

impl<'a> Stretch<'a> {
    fn new(continuation: &'a Continuation, a: &Orbit, b: &Orbit) -> Self {
        let p = |orbit: &Orbit| orbit.setting.get(continuation.parameter);
        let mut scales = continuation.scales(a, p(a));
        scales.parameter = (p(b) - p(a)).abs().max(1e-3 * scales.parameter);
        let chord = continuation.chord(a, b, scales);
        let length = chord.norm();
        Self { continuation, place: Place { orbit: a.clone(), tangent: chord / length }, scales, length }
    }

    fn orbit(&self, s: f64) -> Result<Orbit> {
        self.continuation.step(&self.place, self.scales, s * self.length)
    }

    fn known(&self, s: f64) -> Result<Known> {
        let orbit = self.orbit(s)?;
        let spectrum = orbit.spectrum(&self.continuation.shooting)?;
        Ok(Known { orbit, spectrum })
    }

    /// The value of `psi`, and its `tau`.
    fn test(&self, test: Test, at: &Known) -> Option<(f64, f64)> {
        match test {
            Test::MinusOne(k) => reals(&at.spectrum).get(k).map(|&tau| (tau + 1.0, tau)),
            Test::PlusOne(k) => reals(&at.spectrum).iter().rev().nth(k).map(|&tau| (1.0 - tau, tau)),
            Test::Collision(near) => pair_near(&at.spectrum, near).map(|(mean, discriminant)| (discriminant, mean)),
            Test::Fold => {
                let tangent = self.continuation.tangent(&at.orbit, self.scales, &self.place.tangent).ok()?;
                Some((tangent[tangent.len() - 1], 1.0))
            }
        }
    }

    /// The zero of `psi` by the rule of false position (Illinois variant), with the values at both
    /// ends known.
    fn locate(&self, mut test: Test, a: &Known, b: &Known) -> Option<Bifurcation> {
        let (mut left, mut right) = ((0.0, self.test(test, a)?.0), (1.0, self.test(test, b)?.0));
        if left.1 * right.1 > 0.0 {
            return None;
        }
        let mut last: Option<(Known, f64)> = None;
        for _ in 0..MOST_TRIALS {
            let s = (left.0 * right.1 - right.0 * left.1) / (right.1 - left.1);
            let known = self.known(s).ok()?;
            let (psi, tau) = self.test(test, &known)?;
            if let Test::Collision(near) = &mut test {
                *near = tau;
            }
            last = Some((known, tau));
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
        let (Known { orbit, spectrum }, tau) = last?;
        let kind = match test {
            Test::MinusOne(_) => BifurcationKind::PeriodDoubling,
            Test::PlusOne(_) => BifurcationKind::PlusOne,
            Test::Collision(_) if tau.abs() <= 1.0 => BifurcationKind::KreinCollision,
            Test::Collision(_) => BifurcationKind::RealCollision,
            Test::Fold => BifurcationKind::Fold,
        };
        let single = matches!(test, Test::MinusOne(_) | Test::PlusOne(_));
        let mode = if single { spectrum.strains_of(tau) } else { Vec::new() };
        Some(Bifurcation { kind, parameter: orbit.setting.get(self.continuation.parameter), tau, orbit, mode })
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
                found.push(Test::Collision(tau.re));
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
        match change.abs() {
            0 => {}
            1 => found.push(if side == 0 { Test::MinusOne(k) } else { Test::PlusOne(k) }),
            _ => whole = false,
        }
    }
    (found, whole)
}

impl Continuation {
    /// The bifurcations between the points of a branch, in the order of the points, with the folds
    /// last.
    ///
    /// Quartets with a modulus up to `1 + weak` are left out. A stretch with several bifurcations
    /// is halved up to 5 times; those that are not separated then are left out.
    pub fn bifurcations(&self, orbits: &[Orbit], spectra: &[Spectrum], weak: f64) -> Vec<Bifurcation> {
        let known: Vec<Known> = orbits
            .iter()
            .zip(spectra)
            .map(|(orbit, spectrum)| Known { orbit: orbit.clone(), spectrum: spectrum.clone() })
            .collect();
        let mut out = Vec::new();
        for pair in known.windows(2) {
            self.between(&pair[0], &pair[1], &Quartets { weak, near: None }, MOST_CUTS, &mut out);
        }
        let p = |known: &Known| known.orbit.setting.get(self.parameter);
        for three in known.windows(3) {
            if (p(&three[1]) - p(&three[0])) * (p(&three[2]) - p(&three[1])) < 0.0 {
                let stretch = Stretch::new(self, &three[0].orbit, &three[2].orbit);
                out.extend(stretch.locate(Test::Fold, &three[0], &three[2]));
            }
        }
        out
    }

    fn between(&self, a: &Known, b: &Known, wanted: &Quartets, cuts: u32, out: &mut Vec<Bifurcation>) {
        let (found, whole) = tests(&a.spectrum, &b.spectrum, wanted);
        if found.is_empty() && whole {
            return;
        }
        let stretch = Stretch::new(self, &a.orbit, &b.orbit);
        if let ([test], true) = (&found[..], whole)
            && let Some(bifurcation) = stretch.locate(*test, a, b)
        {
            return out.push(bifurcation);
        }
        if let (1.., Ok(middle)) = (cuts, stretch.known(0.5)) {
            let wanted = wanted.among(&found);
            self.between(a, &middle, &wanted, cuts - 1, out);
            self.between(&middle, b, &wanted, cuts - 1, out);
        }
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
