//! Drives, which move or push a bead by a signal: a sum of harmonics, and of a [`Course`], times an
//! envelope.

use super::Spline;
use crate::error::{Error, Result, finite, positive, require};
use hertzchain_integrators::Real;
use serde::{Deserialize, Serialize};
use std::{
    f64::consts::{FRAC_PI_2, PI},
    sync::Arc,
};

/// Least length of a burst, relative to its start. Methods take times as the same that are nearer
/// than a tenth of this.
const LEAST_BURST: f64 = 1e-11;

/// `amplitude sin(omega t + phase)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic {
    /// Amplitude.
    pub amplitude: f64,
    /// Angular frequency, at least zero.
    pub omega: f64,
    /// Phase, in radians.
    pub phase: f64,
}

/// A function of time that is no harmonic.
#[derive(Clone, Debug, PartialEq)]
pub enum Course {
    /// `velocity t`, the motion of a piston.
    Steady {
        /// Velocity.
        velocity: f64,
    },
    /// `amplitude sin(theta)` with `theta = phase` at time 0. The frequency `theta'` is `omega[0]`
    /// up to `start`, rises or falls linearly over `length` to `omega[1]`, and stays there.
    Chirp {
        /// Amplitude.
        amplitude: f64,
        /// First and last angular frequency, at least zero.
        omega: [f64; 2],
        /// Phase at time 0, in radians.
        phase: f64,
        /// Time at which the frequency begins to change, at least zero.
        start: f64,
        /// Duration of the change, positive.
        length: f64,
    },
    /// Values at given times, with a cubic spline between them.
    Table(Arc<Spline>),
}

/// The factor of the sum, from 0 to 1. All envelopes but [`HalfSine`](Self::HalfSine) have three
/// continuous derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Envelope {
    /// 1 at all times.
    None,
    /// From 0 at time 0 to 1 at this time: `x^4 (35 - 84 x + 70 x^2 - 20 x^3)`, `x = t/ramp`.
    Ramp(f64),
    /// `(4 x (1 - x))^4`, `x = (t - start)/length`, for `x` from 0 to 1, and zero elsewhere.
    Burst {
        /// Time at which it begins, at least zero.
        start: f64,
        /// Duration, positive.
        length: f64,
    },
    /// `sin(pi x)`, `x = (t - start)/length`, for `x` from 0 to 1, and zero elsewhere. Its slope
    /// jumps at both ends.
    HalfSine {
        /// Time at which it begins, at least zero.
        start: f64,
        /// Duration, positive.
        length: f64,
    },
}

/// A sum of harmonics, and of a course if there is one, times an envelope.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// The harmonics.
    pub harmonics: Vec<Harmonic>,
    /// What is added to them.
    pub course: Option<Course>,
    /// The envelope.
    pub envelope: Envelope,
}

/// How a drive acts on its bead.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DriveKind {
    /// The signal is the displacement of the bead.
    #[serde(rename = "moved")]
    Displacement,
    /// The signal is a force on the bead.
    #[serde(rename = "pushed")]
    Force,
}

/// A drive of one bead.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// The bead, counted from 0.
    pub site: usize,
    /// Whether it is moved or pushed.
    pub kind: DriveKind,
    /// The displacement of the bead, or the force on it.
    pub signal: Signal,
}

impl Signal {
    /// A sum of harmonics times an envelope.
    pub fn new(harmonics: Vec<Harmonic>, envelope: Envelope) -> Self {
        Self { harmonics, course: None, envelope }
    }

    /// A constant: a harmonic of frequency zero.
    pub fn constant(value: f64) -> Self {
        Self::new(vec![Harmonic { amplitude: value, omega: 0.0, phase: FRAC_PI_2 }], Envelope::None)
    }

    /// Whether the signal is the same at all times.
    pub fn is_constant(&self) -> bool {
        let still = self.harmonics.iter().all(|harmonic| harmonic.omega == 0.0);
        still && self.course.is_none() && self.envelope == Envelope::None
    }

    /// The harmonic `amplitude sin(omega t)` from time 0 on, switched on by a ramp; by a jump for
    /// `ramp = 0`.
    pub fn sine(amplitude: f64, omega: f64, ramp: f64) -> Self {
        let envelope = if ramp > 0.0 { Envelope::Ramp(ramp) } else { Envelope::None };
        Self::new(vec![Harmonic { amplitude, omega, phase: 0.0 }], envelope)
    }

    /// Value, first and second derivative at a time.
    ///
    /// ```
    /// use hertzchain_core::chain::Signal;
    /// let [s, s_dot, _] = Signal::sine(2.0, 3.0, 0.0).at(0.5);
    /// assert!((s - 2.0 * 1.5f64.sin()).abs() < 1e-15);
    /// assert!((s_dot - 6.0 * 1.5f64.cos()).abs() < 1e-14);
    /// ```
    pub fn at<R: Real>(&self, t: R) -> [R; 3] {
        let mut sum = [R::zero(); 3];
        for &Harmonic { amplitude, omega, phase } in &self.harmonics {
            let [amplitude, omega, phase] = [amplitude, omega, phase].map(R::of);
            let (sin, cos) = (omega * t + phase).sin_cos();
            sum[0] += amplitude * sin;
            sum[1] += amplitude * omega * cos;
            sum[2] -= amplitude * omega * omega * sin;
        }
        if let Some(course) = &self.course {
            sum.iter_mut().zip(course.at(t)).for_each(|(sum, by)| *sum += by);
        }
        let [e, e1, e2] = self.envelope.at(t);
        [e * sum[0], e1 * sum[0] + e * sum[1], e2 * sum[0] + R::of(2.0) * e1 * sum[1] + e * sum[2]]
    }

    /// A bound of the absolute value of the signal: the sum of the amplitudes; of a steady motion,
    /// its path in the ramp.
    pub fn size(&self) -> f64 {
        self.reach(self.settled())
    }

    /// A bound of the absolute value up to a time.
    pub(crate) fn reach(&self, time: f64) -> f64 {
        let own: f64 = self.harmonics.iter().map(|harmonic| harmonic.amplitude.abs()).sum();
        own + match &self.course {
            Some(Course::Steady { velocity }) => velocity.abs() * time,
            Some(Course::Chirp { amplitude, .. }) => amplitude.abs(),
            Some(Course::Table(spline)) => spline.size(),
            None => 0.0,
        }
    }

    /// The largest angular frequency; of a table, its largest slope over its largest value.
    pub(crate) fn frequency(&self) -> f64 {
        let own = self.harmonics.iter().map(|harmonic| harmonic.omega).fold(0.0, f64::max);
        match &self.course {
            Some(Course::Chirp { omega: [first, last], .. }) => own.max(*first).max(*last),
            Some(Course::Table(spline)) if spline.size() > 0.0 => own.max(spline.speed() / spline.size()),
            _ => own,
        }
    }

    /// The scale of the time derivative, of harmonics without a common phase; zero of a constant.
    pub(crate) fn speed(&self) -> f64 {
        let own = self.harmonics.iter().map(|harmonic| harmonic.amplitude * harmonic.omega).fold(0.0, f64::hypot);
        self.course.as_ref().map_or(own, |course| own + course.speed()) + self.size() * self.envelope.per_time()
    }

    /// Times at which the signal is not smooth.
    pub(crate) fn breaks(&self) -> Vec<f64> {
        let mut breaks = self.envelope.span().map_or(vec![], |span| span.to_vec());
        match &self.course {
            Some(Course::Chirp { start, length, .. }) => breaks.extend([*start, start + length]),
            Some(Course::Table(spline)) => breaks.extend(spline.times()),
            Some(Course::Steady { .. }) | None => {}
        }
        breaks
    }

    /// The time from which the envelope is constant: the end of a ramp or of a burst.
    pub fn settled(&self) -> f64 {
        self.envelope.span().map_or(0.0, |[_, end]| end)
    }

    pub(super) fn check(&self, kind: DriveKind) -> Result<()> {
        let moves = !self.harmonics.is_empty() || self.course.is_some();
        require(moves, "drive.amplitude", "[]", "a drive has at least one harmonic")?;
        let frequency = |name, omega: f64| {
            require(omega.is_finite() && omega >= 0.0, name, omega, "a frequency is finite and at least zero")
        };
        match (&self.course, kind) {
            (&Some(Course::Steady { velocity }), DriveKind::Displacement) => {
                finite("drive.velocity", velocity)?;
            }
            (&Some(Course::Steady { velocity }), DriveKind::Force) => {
                return Err(Error::parameter("drive.velocity", velocity, "only a bead that is moved has a velocity"));
            }
            (&Some(Course::Chirp { amplitude, omega, phase, start, length }), _) => {
                finite("drive.amplitude", amplitude)?;
                frequency("drive.omega", omega[0])?;
                frequency("drive.omega_end", omega[1])?;
                finite("drive.phase", phase)?;
                interval(start, length)?;
            }
            (Some(Course::Table(_)) | None, _) => {}
        }
        for &Harmonic { amplitude, omega, phase } in &self.harmonics {
            finite("drive.amplitude", amplitude)?;
            frequency("drive.omega", omega)?;
            finite("drive.phase", phase)?;
        }
        match self.envelope {
            Envelope::None => Ok(()),
            Envelope::Ramp(ramp) => positive("drive.ramp", ramp).map(drop),
            Envelope::Burst { start, length } => interval(start, length),
            Envelope::HalfSine { start, length } if kind == DriveKind::Force => interval(start, length),
            Envelope::HalfSine { .. } => {
                let rule = "the velocity of a bead that is moved would jump: push it, or take a burst";
                Err(Error::parameter("drive.shape", "half-sine", rule))
            }
        }
    }
}

/// Refuses an interval of time that is too short, or begins before the run.
fn interval(start: f64, length: f64) -> Result<()> {
    require(start.is_finite() && start >= 0.0, "drive.start", start, "finite and at least zero")?;
    if start + length <= start * (1.0 + LEAST_BURST) {
        let rule = "a burst is longer than 1e-11 of its start: times have sixteen digits";
        return Err(Error::parameter("drive.length", length, rule));
    }
    positive("drive.length", length).map(drop)
}

impl Course {
    /// Value, first and second derivative.
    fn at<R: Real>(&self, t: R) -> [R; 3] {
        match self {
            &Self::Steady { velocity } => [R::of(velocity) * t, R::of(velocity), R::zero()],
            &Self::Chirp { amplitude, omega: [first, last], phase, start, length } => {
                let [amplitude, first, phase, start, length, last] =
                    [amplitude, first, phase, start, length, last].map(R::of);
                let (since, rise) = (t - start, (last - first) / length);
                let within = since.max(R::zero()).min(length);
                let theta = phase + first * t + rise * within * (R::of(0.5) * within + (since - within).max(R::zero()));
                let rate = first + rise * within;
                let bend = if within > R::zero() && within < length { rise } else { R::zero() };
                let (sin, cos) = theta.sin_cos();
                [amplitude * sin, amplitude * rate * cos, amplitude * (bend * cos - rate * rate * sin)]
            }
            Self::Table(spline) => spline.at(t),
        }
    }

    /// A bound of the first derivative.
    fn speed(&self) -> f64 {
        match self {
            Self::Steady { velocity } => velocity.abs(),
            Self::Chirp { amplitude, omega: [first, last], .. } => amplitude.abs() * first.max(*last),
            Self::Table(spline) => spline.speed(),
        }
    }
}

impl Envelope {
    /// Value, first and second derivative.
    fn at<R: Real>(self, t: R) -> [R; 3] {
        let (zero, one) = (R::zero(), R::one());
        match self {
            Self::None => [one, zero, zero],
            Self::Ramp(ramp) if t >= R::of(ramp) => [one, zero, zero],
            Self::Ramp(_) if t <= zero => [zero; 3],
            Self::Ramp(ramp) => {
                let (per, x) = (R::of(ramp).recip(), t / R::of(ramp));
                let (rest, cube) = (one - x, x * x * x);
                let value = cube * x * (R::of(35.0) + x * (R::of(-84.0) + x * (R::of(70.0) - R::of(20.0) * x)));
                let first = R::of(140.0) * cube * rest * rest * rest;
                let second = R::of(420.0) * x * x * rest * rest * (one - R::of(2.0) * x);
                [value, first * per, second * per * per]
            }
            Self::Burst { start, length } => {
                let (per, x) = (R::of(length).recip(), (t - R::of(start)) / R::of(length));
                if x <= zero || x >= one {
                    return [zero; 3];
                }
                // w^4 with w = 4 x (1 - x), w' = 4 - 8 x, w'' = -8.
                let (w, w1) = (R::of(4.0) * x * (one - x), R::of(4.0) - R::of(8.0) * x);
                let square = w * w;
                let first = R::of(4.0) * square * w * w1;
                let second = R::of(12.0) * square * w1 * w1 - R::of(32.0) * square * w;
                [square * square, first * per, second * per * per]
            }
            Self::HalfSine { start, length } => {
                let (per, x) = (R::of(PI) / R::of(length), (t - R::of(start)) / R::of(length));
                if x < zero || x > one {
                    return [zero; 3];
                }
                let (sin, cos) = (R::of(PI) * x).sin_cos();
                // At an end: the mean of the slopes on both sides.
                if x == zero || x == one {
                    return [zero, R::of(0.5) * per * cos, zero];
                }
                [sin, per * cos, -per * per * sin]
            }
        }
    }

    /// The times between which it varies.
    pub(super) fn span(self) -> Option<[f64; 2]> {
        match self {
            Self::None => None,
            Self::Ramp(ramp) => Some([0.0, ramp]),
            Self::Burst { start, length } | Self::HalfSine { start, length } => Some([start, start + length]),
        }
    }

    /// The scale of the time derivative of the envelope.
    fn per_time(self) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Ramp(length) | Self::Burst { length, .. } | Self::HalfSine { length, .. } => length.recip(),
        }
    }
}
