//! Numbers of studies in the units of a scene: read from options, and of reports.
//!
//! What is computed and what a file keeps for `--resume` is dimensionless.

use super::options::options;
use crate::{
    error::{Error, Result},
    scene::{Quantity, Scene, Units},
};

/// What a report in SI units says of itself.
pub(super) const ALL_IN_SI: &str = "all numbers here are in SI units";

options! {
    /// The units of results of a scene with a table `[units]`; those of other scenes are
    /// dimensionless.
    #[derive(Copy, PartialEq, Eq)]
    pub struct ResultUnits {
        /// Dimensionless results of a scene with `[units]`.
        ///
        /// A scene with a table `[units]` is in SI units, and so are options and results, except
        /// files for --resume: metres, seconds, kilograms, newtons, joules. With this option
        /// results are dimensionless; what is given stays in SI units.
        dimensionless: bool = false, [hide_short_help = true];
    }
}

impl ResultUnits {
    /// The units of results in SI units.
    pub fn of(self, scene: &Scene) -> Option<Units> {
        scene.units().filter(|_| !self.dimensionless).copied()
    }
}

/// The units in which numbers are read and reported: SI units, or those of the chain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale<'a>(pub(super) Option<&'a Units>);

impl Scale<'_> {
    /// A number of the chain as it is reported.
    pub(super) fn reported(self, quantity: Quantity, value: f64) -> f64 {
        self.0.map_or(value, |units| units.to_si(quantity, value))
    }

    /// Numbers of one kind as they are reported.
    pub(super) fn all(self, quantity: Quantity, values: &[f64]) -> Vec<f64> {
        values.iter().map(|&value| self.reported(quantity, value)).collect()
    }

    /// The number of the chain for one that was given.
    pub(super) fn read(self, quantity: Quantity, value: f64) -> f64 {
        self.0.map_or(value, |units| units.from_si(quantity, value))
    }

    /// A name with the unit of its quantity, in SI units.
    pub(super) fn label(self, name: &str, quantity: Quantity) -> String {
        match self.0 {
            Some(_) if quantity != Quantity::Number => format!("{name} ({})", quantity.unit()),
            _ => name.to_owned(),
        }
    }

    /// The kind of the frequencies that pictures show, and their label.
    pub(super) fn frequency(self) -> (Quantity, String) {
        match self.0 {
            None => (Quantity::Omega, "frequency ω".to_owned()),
            Some(_) => (Quantity::Frequency, self.label("frequency ω/2π", Quantity::Frequency)),
        }
    }

    /// A number with so many decimals; in SI units with an exponent, since it may be tiny.
    pub(super) fn shown(self, quantity: Quantity, value: f64, decimals: usize) -> String {
        let value = self.reported(quantity, value);
        match self.0 {
            Some(_) if quantity != Quantity::Number => format!("{value:.decimals$e}"),
            _ => format!("{value:.decimals$}"),
        }
    }

    /// An error of parameters with the values that were `given` for them, by name, where the error
    /// has those of the chain.
    pub(super) fn given<T>(self, result: Result<T>, given: &[(&str, Option<f64>)]) -> Result<T> {
        let one = |name: &str| given.iter().find(|(of, _)| *of == name).and_then(|(_, value)| *value);
        result.map_err(|error| match error {
            Error::Parameter { name, value, rule } => match one(name).filter(|_| self.0.is_some()) {
                Some(given) => Error::parameter(name, given, rule),
                None => Error::Parameter { name, value, rule },
            },
            other => other,
        })
    }
}
