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
    /// An acceleration.
    Acceleration,
    /// A force.
    Force,
    /// A displacement over a force, or the inverse of a stiffness.
    Compliance,
    /// A momentum.
    Momentum,
    /// An energy or work.
    Energy,
    /// A mass.
    Mass,
    /// A spring constant.
    Stiffness,
    /// The constant of a drag or a dashpot, force over velocity.
    Damping,
    /// A time over a length, the inverse of a velocity.
    Slowness,
    /// An angular frequency `omega`, in radians a second.
    Omega,
    /// The frequency `omega/(2 pi)`, in hertz, of an angular frequency `omega` of the chain.
    Frequency,
    /// A number over a time.
    Rate,
}

impl Quantity {
    /// The symbol of the SI unit, empty without a unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Number => "",
            Self::Length => "m",
            Self::Time => "s",
            Self::Velocity => "m/s",
            Self::Acceleration => "m/s^2",
            Self::Force => "N",
            Self::Compliance => "m/N",
            Self::Momentum => "kg m/s",
            Self::Energy => "J",
            Self::Mass => "kg",
            Self::Stiffness => "N/m",
            Self::Damping => "kg/s",
            Self::Slowness => "s/m",
            Self::Omega => "rad/s",
            Self::Frequency => "Hz",
            Self::Rate => "1/s",
        }
    }
}

impl Units {
    /// The units of a chain with these units of length and mass, from the constant and exponent of
    /// its contacts, which is 1 in these units.
    pub fn new(length: f64, mass: f64, (constant, alpha): (f64, f64)) -> Self {
        let time = (mass / (constant * length.powf(alpha - 1.0))).sqrt();
        Self {
            length_m: length,
            mass_kg: mass,
            time_s: time,
            velocity_m_per_s: length / time,
            force_n: constant * length.powf(alpha),
            energy_j: mass * (length / time).powi(2),
        }
    }

    /// Units of length and velocity in the constant of a dashpot with these powers of overlap and
    /// rate, besides those of a linear one.
    pub fn powers(&self, overlap: f64, rate: f64) -> f64 {
        self.length_m.powf(overlap) * self.velocity_m_per_s.powf(rate - 1.0)
    }

    /// A dimensionless number of the chain in SI units.
    ///
    /// ```
    /// use hertzchain_report::report::{Quantity, Units};
    /// let units = Units::new(9.525e-3, 0.0286, (1.4e10, 1.5)); // m, kg, N/m^1.5
    /// assert_eq!(units.to_si(Quantity::Length, 1.0), 9.525e-3);
    /// let omega = units.from_si(Quantity::Omega, 3.0e4);
    /// assert!((units.to_si(Quantity::Frequency, omega) - 4774.648).abs() < 1e-3);
    /// ```
    pub fn to_si(&self, quantity: Quantity, value: f64) -> f64 {
        match quantity {
            Quantity::Omega => value / self.time_s,
            Quantity::Frequency => value / self.time_s / (2.0 * PI),
            _ => value * self.unit(quantity),
        }
    }

    /// The dimensionless number of the chain for a number in SI units: the inverse of
    /// [`to_si`](Self::to_si), which gives the number back where any double does. The numbers of a
    /// scene are read with the same roundings.
    pub fn from_si(&self, quantity: Quantity, value: f64) -> f64 {
        let near = match quantity {
            Quantity::Omega => value * self.time_s,
            Quantity::Frequency => value * (2.0 * PI) * self.time_s,
            _ => value / self.unit(quantity),
        };
        let back = |x: &f64| self.to_si(quantity, *x) == value;
        [near, near.next_up(), near.next_down()].into_iter().find(back).unwrap_or(near)
    }

    /// The unit of a quantity in SI units.
    fn unit(&self, quantity: Quantity) -> f64 {
        match quantity {
            Quantity::Number => 1.0,
            Quantity::Length => self.length_m,
            Quantity::Time => self.time_s,
            Quantity::Velocity => self.velocity_m_per_s,
            Quantity::Acceleration => self.velocity_m_per_s / self.time_s,
            Quantity::Force => self.force_n,
            Quantity::Compliance => self.length_m / self.force_n,
            Quantity::Momentum => self.mass_kg * self.velocity_m_per_s,
            Quantity::Energy => self.energy_j,
            Quantity::Mass => self.mass_kg,
            Quantity::Stiffness => self.force_n / self.length_m,
            Quantity::Damping => self.mass_kg / self.time_s,
            Quantity::Slowness => self.velocity_m_per_s.recip(),
            Quantity::Omega | Quantity::Frequency | Quantity::Rate => self.time_s.recip(),
        }
    }

    /// The value of each unit, for what people read.
    pub fn words(&self) -> String {
        let Self { length_m, mass_kg, time_s, velocity_m_per_s, force_n, energy_j } = self;
        format!(
            "{length_m:.6e} m, {mass_kg:.6e} kg, {time_s:.6e} s; \
             {velocity_m_per_s:.6e} m/s, {force_n:.6e} N, {energy_j:.6e} J"
        )
    }
}
