//! Kinds of numbers, and their SI units.

use serde::Serialize;
use std::f64::consts::PI;

/// The unit of each dimensionless quantity, in SI units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Units {
    /// Unit of length, in metres.
    pub length_m: f64,
    /// Unit of mass, in kilograms.
    pub mass_kg: f64,
    /// Unit of time, in seconds.
    pub time_s: f64,
    /// Unit of velocity, in metres per second.
    pub velocity_m_per_s: f64,
    /// Unit of force, in newtons.
    pub force_n: f64,
    /// Unit of energy, in joules.
    pub energy_j: f64,
}

/// The kind of a number, which decides its SI unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A number without a unit: a multiplier, a factor, a phase.
    Number,
    /// A displacement, an amplitude or an overlap.
    Length,
    /// A time or a period.
    Time,
    /// A velocity.
    Velocity,
    /// A force.
    Force,
    /// An energy or work.
    Energy,
    /// An angular frequency `omega`, in radians a second.
    Omega,
    /// The frequency `omega/(2 pi)`, in hertz, of an angular frequency `omega` of the chain.
    Frequency,
}

impl Quantity {
    /// The symbol of the SI unit, empty without a unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Number => "",
            Self::Length => "m",
            Self::Time => "s",
            Self::Velocity => "m/s",
            Self::Force => "N",
            Self::Energy => "J",
            Self::Omega => "rad/s",
            Self::Frequency => "Hz",
        }
    }
}

impl Units {
    /// A dimensionless number of the chain in SI units.
    ///
    /// ```
    /// use hertzchain::scene::{Quantity, Scene};
    /// let scene = Scene::load("granular-crystal")?;
    /// let units = scene.units().expect("a scene with [units]");
    /// assert_eq!(units.to_si(Quantity::Length, 1.0), 9.525e-3);
    /// let omega = units.from_si(Quantity::Omega, 3.0e4);
    /// assert!((units.to_si(Quantity::Frequency, omega) - 4774.648).abs() < 1e-3);
    /// # Ok::<(), hertzchain::Error>(())
    /// ```
    pub fn to_si(&self, quantity: Quantity, value: f64) -> f64 {
        match quantity {
            Quantity::Omega => value / self.time_s,
            Quantity::Frequency => value / self.time_s / (2.0 * PI),
            _ => value * self.unit(quantity),
        }
    }

    /// The dimensionless number of the chain for a number in SI units: the inverse of
    /// [`to_si`](Self::to_si), up to rounding. The drives of a scene are read with the same
    /// roundings.
    pub fn from_si(&self, quantity: Quantity, value: f64) -> f64 {
        match quantity {
            Quantity::Omega => value * self.time_s,
            Quantity::Frequency => value * (2.0 * PI) * self.time_s,
            _ => value / self.unit(quantity),
        }
    }

    /// The unit of a quantity in SI units.
    fn unit(&self, quantity: Quantity) -> f64 {
        match quantity {
            Quantity::Number => 1.0,
            Quantity::Length => self.length_m,
            Quantity::Time => self.time_s,
            Quantity::Velocity => self.velocity_m_per_s,
            Quantity::Force => self.force_n,
            Quantity::Energy => self.energy_j,
            Quantity::Omega | Quantity::Frequency => self.time_s.recip(),
        }
    }

    /// The value of each unit, for what people read.
    pub(crate) fn words(&self) -> String {
        let Self { length_m, mass_kg, time_s, velocity_m_per_s, force_n, energy_j } = self;
        format!(
            "{length_m:.6e} m, {mass_kg:.6e} kg, {time_s:.6e} s; \
             {velocity_m_per_s:.6e} m/s, {force_n:.6e} N, {energy_j:.6e} J"
        )
    }
}
