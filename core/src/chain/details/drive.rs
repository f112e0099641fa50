//! Drives, which move or push a bead by a signal: a sum of harmonics times an envelope.

use crate::error::{Error, Result, finite, positive, require};
use hertzchain_integrators::Real;
use serde::{Deserialize, Serialize};

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

/// The factor of the sum of harmonics, from 0 to 1. All envelopes have three continuous
/// derivatives.
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
}

/// A sum of harmonics times an envelope.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// The harmonics.
    pub harmonics: Vec<Harmonic>,
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
    /// The harmonic `amplitude sin(omega t)` from time 0 on, switched on by a ramp; by a jump for
    /// `ramp = 0`.
    pub fn sine(amplitude: f64, omega: f64, ramp: f64) -> Self {
        let envelope = if ramp > 0.0 { Envelope::Ramp(ramp) } else { Envelope::None };
        Self { harmonics: vec![Harmonic { amplitude, omega, phase: 0.0 }], envelope }
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
        let [e, e1, e2] = self.envelope.at(t);
        [e * sum[0], e1 * sum[0] + e * sum[1], e2 * sum[0] + R::of(2.0) * e1 * sum[1] + e * sum[2]]
    }

    /// A bound of the absolute value of the signal: the sum of the amplitudes.
    pub fn size(&self) -> f64 {
        self.harmonics.iter().map(|harmonic| harmonic.amplitude.abs()).sum()
    }

    /// The scale of the time derivative of the signal; positive.
    pub(crate) fn speed(&self) -> f64 {
        let own: f64 = self.harmonics.iter().map(|harmonic| harmonic.amplitude.abs() * harmonic.omega).sum();
        own.max(f64::MIN_POSITIVE) + self.size() * self.envelope.per_time()
    }

    /// Times at which the envelope is not smooth.
    pub(crate) fn breaks(&self) -> Vec<f64> {
        match self.envelope {
            Envelope::None => vec![],
            Envelope::Ramp(ramp) => vec![0.0, ramp],
            Envelope::Burst { start, length } => vec![start, start + length],
        }
    }

    /// The time from which the envelope is constant: the end of a ramp or of a burst.
    pub fn settled(&self) -> f64 {
        match self.envelope {
            Envelope::None => 0.0,
            Envelope::Ramp(ramp) => ramp,
            Envelope::Burst { start, length } => start + length,
        }
    }

    pub(super) fn check(&self) -> Result<()> {
        require(!self.harmonics.is_empty(), "drive.amplitude", "[]", "a drive has at least one harmonic")?;
        for &Harmonic { amplitude, omega, phase } in &self.harmonics {
            finite("drive.amplitude", amplitude)?;
            let rule = "a frequency is finite and at least zero";
            require(omega.is_finite() && omega >= 0.0, "drive.omega", omega, rule)?;
            finite("drive.phase", phase)?;
        }
        match self.envelope {
            Envelope::None => Ok(()),
            Envelope::Ramp(ramp) => positive("drive.ramp", ramp).map(drop),
            Envelope::Burst { start, length } => {
                require(start.is_finite() && start >= 0.0, "drive.start", start, "finite and at least zero")?;
                if start + length <= start * (1.0 + LEAST_BURST) {
                    let rule = "a burst is longer than 1e-11 of its start: times have sixteen digits";
                    return Err(Error::parameter("drive.length", length, rule));
                }
                positive("drive.length", length).map(drop)
            }
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
        }
    }

    /// The scale of the time derivative of the envelope.
    fn per_time(self) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Ramp(length) | Self::Burst { length, .. } => length.recip(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn signals() -> Vec<Signal> {
        let harmonics = vec![
            Harmonic { amplitude: 0.7, omega: 1.3, phase: 0.4 },
            Harmonic { amplitude: -0.2, omega: 3.1, phase: 2.0 },
            Harmonic { amplitude: 0.5, omega: 0.0, phase: 1.0 },
        ];
        let envelopes = [Envelope::None, Envelope::Ramp(2.0), Envelope::Burst { start: 0.5, length: 3.0 }];
        envelopes.map(|envelope| Signal { harmonics: harmonics.clone(), envelope }).to_vec()
    }

    #[test]
    fn derivatives_are_those_of_the_signal() {
        // Truth: central differences, whose error is h^2/6 times a derivative of size 10.
        for signal in signals() {
            for k in 0..80 {
                let (t, h) = (0.05 * f64::from(k) + 0.013, 1e-5);
                let [_, first, second] = signal.at(t);
                let ([s0, d0, _], [s1, d1, _]) = (signal.at(t - h), signal.at(t + h));
                assert!((first - (s1 - s0) / (2.0 * h)).abs() < 1e-8, "{:?} {t}", signal.envelope);
                assert!((second - (d1 - d0) / (2.0 * h)).abs() < 1e-7, "{:?} {t}", signal.envelope);
                assert!(signal.at(t)[0].abs() <= signal.size());
            }
        }
    }

    #[test]
    fn envelopes_join_what_is_around_them() {
        // Truth: the values at the joints; three derivatives vanish there, so that a distance x
        // away they differ by 35 x^4, and a burst by 256 x^4.
        let [_, ramp, burst] = signals().try_into().unwrap();
        let bare = Signal { envelope: Envelope::None, ..ramp.clone() };
        assert_eq!(ramp.at(0.0), [0.0; 3]);
        assert_eq!(ramp.at(2.0), bare.at(2.0));
        let difference = (ramp.at(2.0 - 1e-3)[0] - bare.at(2.0 - 1e-3)[0]).abs();
        assert!(difference <= 35.0 * 5e-4f64.powi(4) * bare.size(), "{difference:e}");
        assert_eq!((burst.at(0.5), burst.at(3.5), burst.at(9.0)), ([0.0; 3], [0.0; 3], [0.0; 3]));
        assert!((burst.at(2.0)[0] - bare.at(2.0)[0]).abs() < 1e-15);
        assert!(burst.at(0.5 + 3e-3)[0].abs() <= 256.0 * 1e-12 * bare.size());
    }
}
