//! Options of studies, each told once: field, flag, default and range in [`options!`].

#[cfg(feature = "cli")]
mod flags;
#[cfg(feature = "cli")]
pub(crate) use flags::*;

use crate::{
    chain::Params,
    error::{Error, Result, require},
    run::{Method, Run},
    scene::Scene,
};
use std::{fmt::Debug, ops::RangeInclusive, slice::from_ref};

/// A value of an option that has a range: a number, one that may be left out, or a list.
pub(crate) trait Value {
    /// The type of a number.
    type Number: PartialOrd + Debug;

    /// The numbers.
    fn numbers(&self) -> &[Self::Number];
}

macro_rules! value {
    ($($type:ty $(, $any:ident)?: $number:ty => $numbers:expr;)*) => {$(
        impl$(<$any: PartialOrd + Debug>)? Value for $type {
            type Number = $number;

            fn numbers(&self) -> &[$number] {
                $numbers(self)
            }
        }
    )*};
}
value! {
    Vec<T>, T: T => Vec::as_slice;
    Option<T>, T: T => Option::as_slice;
    f64: f64 => from_ref;
    usize: usize => from_ref;
    u64: u64 => from_ref;
    u32: u32 => from_ref;
}

/// A number or name as it is written on the command line, from its `Debug`: with an exponent if
/// that is shorter.
fn written(item: &str) -> String {
    let whole = item.strip_suffix(".0").unwrap_or(item.trim_matches('"'));
    match item.parse::<f64>().map(|number| format!("{number:e}")) {
        Ok(short) if short.len() + 1 < whole.len() && item.contains('.') => short,
        _ => whole.to_owned(),
    }
}

/// A range of numbers, and its rule in words.
type Range<V> = (RangeInclusive<<V as Value>::Number>, &'static str);

/// Refuses a value outside its range, and an empty list unless the default is one.
pub(crate) fn within<V: Value>(field: &str, value: &V, default: &V, (range, rule): Range<V>) -> Result<()> {
    // The name of the flag.
    let name = || &*field.replace('_', "-").leak();
    if value.numbers().is_empty() && !default.numbers().is_empty() {
        return Err(Error::parameter(name(), "\"\"", "name at least one value"));
    }
    match value.numbers().iter().find(|number| !range.contains(number)) {
        Some(number) => Err(Error::parameter(name(), written(&format!("{number:?}")), rule)),
        None => Ok(()),
    }
}

/// Types of options, with what reads them if clap does not know it.
macro_rules! one {
    ($($type:ty $(: $parser:expr)?),+) => {$(
        #[cfg(feature = "cli")]
        impl $crate::study::options::One for $type {
            fn parser() -> clap::builder::ValueParser {
                $crate::study::options::one!(@$type $(, $parser)?)
            }
        }
    )+};
    (@$type:ty) => { clap::value_parser!($type).into() };
    (@$type:ty, $parser:expr) => { clap::builder::ValueParser::new($parser) };
}
pub(crate) use one;
/// A range and its words.
macro_rules! range {
    (positive) => {
        (0.0_f64.next_up()..=f64::MAX, "finite and positive")
    };
    (end) => {
        (1e-100..=1e100, "from 1e-100 to 1e100")
    };
    (finite) => {
        (f64::MIN..=f64::MAX, "a finite number")
    };
    (ratio) => {
        (0.0..=f64::MAX, "finite and at least 0: no dark breather has resonators at rest (inf)")
    };
    ($tolerance:ident) => {{
        let kind = hertzchain_integrators::Tolerance::$tolerance;
        (kind.least..=kind.most, kind.rule)
    }};
    ($least:literal or more) => {
        ($least..=usize::MAX, concat!("at least ", $least))
    };
    ($least:literal to $most:literal) => {
        ($least as _..=$most as _, concat!("from ", $least, " to ", $most))
    };
    (from $least:literal) => {
        ($least.into()..=f64::MAX, concat!("finite and at least ", $least))
    };
    (above $least:literal to $most:literal) => {
        (f64::from($least).next_up()..=$most.into(), concat!("above ", $least, " and at most ", $most))
    };
    (above 0 below $most:literal) => {
        // Subnormal numbers have fewer digits.
        (f64::MIN_POSITIVE..=f64::from($most).next_down(), concat!("above 0 and below ", $most))
    };
}
pub(crate) use range;

/// A type of options, with `Default`.
///
/// `field: type = default, "VALUE", (least to most), [method of clap's Arg = argument];` is a field
/// and its flag `--field VALUE`: help, default and range are told here only. All but the first may
/// be left out: without `"VALUE"` it is an argument without a flag, a switch or a group of flags;
/// without a range other code checks the value. Fields after `with` have no flags; a function after
/// `command` changes the flags of groups. `within_ranges` refuses numbers outside their ranges.
macro_rules! options {
    ($(#[$attribute:meta])* $visible:vis struct $name:ident {
        $($(#[doc = $doc:literal])* $field:ident: $type:ty = $default:expr
            $(, $value:literal)? $(, ($($range:tt)*))? $(, [$($set:ident = $to:expr),*])?;)*
    } $(with { $($(#[doc = $about:literal])* $kept:ident: $kind:ty = $own:expr;)* })? $(command $change:expr)?) => {
        #[derive(Clone, Debug)]
        $(#[$attribute])*
        $visible struct $name {
            $($(#[doc = $doc])* pub $field: $type,)*
            $($($(#[doc = $about])* pub $kept: $kind,)*)?
        }

        #[cfg(feature = "cli")]
        impl $crate::study::options::Field for $name {
            fn add(&self, command: clap::Command, _: &$crate::study::options::Flag) -> clap::Command {
                use $crate::study::options::*;
                $(let command = self.$field.add(command, &Flag {
                    id: stringify!($field),
                    docs: &[$($doc),*],
                    more: |arg| arg$($(.$set($to))*)?,
                    value: [$($value)?].first().copied(),
                    rule: [$(rule(&self.$field, range!($($range)*)))?].first().copied(),
                });)*
                $(let change: fn(clap::Command) -> clap::Command = $change;
                let command = change(command);)?
                command
            }

            fn read(&self, matches: &clap::ArgMatches, _: &str) -> Self {
                Self {
                    $($field: self.$field.read(matches, stringify!($field)),)*
                    $($($kept: self.$kept.clone(),)*)?
                }
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)* $($($kept: $own,)*)? }
            }
        }

        impl $name {
            /// Refuses the first number outside its range.
            #[allow(dead_code, unused, reason = "a type may have no ranges")]
            pub(crate) fn within_ranges(&self) -> $crate::error::Result<()> {
                use $crate::study::options::*;
                let default = Self::default();
                $($(within(stringify!($field), &self.$field, &default.$field, range!($($range)*))?;)?)*
                Ok(())
            }
        }
    };
}
pub(crate) use options;

options! {
    /// How a scene is run: by an adaptive method.
    #[derive(Copy, PartialEq)]
    pub struct Adaptive {
        /// Integrator; `hertzchain integrators` lists all.
        ///
        /// Only integrators that take a tolerance.
        method: Method = Method::Collocation, "NAME", [long = "integrator"];
        /// Tolerance.
        tol: f64 = 1e-10, "T", (RUN), [long_help = crate::study::tolerance_help("")];
    }
}

impl Adaptive {
    pub(super) fn check(&self) -> Result<()> {
        let rule = "an adaptive method: collocation or a dop853";
        require(self.method.adaptive(), "integrator", self.method.name(), rule)
    }

    pub(super) fn run(&self, scene: &Scene) -> Result<Run> {
        self.check()?;
        scene.run().method(self.method).tolerance(self.tol)
    }

    /// Method and tolerance, in words.
    pub(super) fn words(&self) -> String {
        format!("{}, tol {:e}", self.method.name(), self.tol)
    }
}

options! {
    /// The parameters of a chain whose beads are alike and whose resonators move.
    #[derive(Copy, PartialEq)]
    pub struct ChainParams {
        /// Exponent of the contact force; 1.5 for spheres.
        alpha: f64 = 1.5, "A", (1.01 to 10);
        /// Spring constant of the resonators.
        kappa: f64 = 1.0, "K", (positive);
        /// Mass ratio resonator to bead.
        rho: f64 = 1.0 / 3.0, "R", (ratio);
    }
}

impl From<ChainParams> for Params {
    fn from(ChainParams { alpha, kappa, rho }: ChainParams) -> Self {
        Self { alpha, kappa, rho }
    }
}

impl ChainParams {
    /// The parameters, if they keep the rules of every chain.
    pub(super) fn checked(&self) -> Result<Params> {
        self.within_ranges()?;
        Params::new(self.alpha, self.kappa, self.rho)
    }
}
