//! Numbers of studies in SI units: read from options, and of reports.
//!
//! What is computed and what a file keeps for `--resume` stays dimensionless.

use crate::{
    error::{Error, Result},
    scene::{Quantity, Scene, Units},
};

/// What a report in SI units says of itself.
pub(super) const ALL_IN_SI: &str = "all numbers here are in SI units";

/// Whether options and results are in SI units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
pub struct InSi {
    /// Results in SI units, for scenes with a table `[units]`.
    ///
    /// Results are in metres, seconds, newtons and joules, except files for --resume and messages
    /// of failures. A branch takes --to and --step in these units, too. The amplitude of a drive is
    /// in m if it moves a bead, in N if it pushes one. `omega` is in rad/s, as in the scene;
    /// `frequency`, in Hz, stands beside it. Names of fields and columns do not change.
    #[cfg_attr(feature = "cli", arg(long, hide_short_help = true))]
    pub si: bool,
}

impl InSi {
    /// The units of the scene, if SI units are asked for.
    ///
    /// # Errors
    /// SI units of a scene without `[units]`.
    pub(super) fn units(self, scene: &Scene) -> Result<Option<Units>> {
        scene.units_if(self.si).map(Option::<&Units>::copied)
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
