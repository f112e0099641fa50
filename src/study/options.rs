//! Options of studies, each told once: field, default, range and meaning.

use crate::error::{Error, Result};
use std::{fmt::Debug, ops::RangeInclusive};

/// A value of an option: a number, one that may be left out, or a list of numbers or names.
pub(crate) trait Value {
    /// The type of a number.
    type Number: PartialOrd + Debug;
    /// Whether it is a list, separated by commas.
    const LIST: bool;

    /// The numbers.
    fn numbers(&self) -> &[Self::Number];
}

impl<T: PartialOrd + Debug> Value for Vec<T> {
    type Number = T;

    const LIST: bool = true;

    fn numbers(&self) -> &[T] {
        self
    }
}

impl<T: PartialOrd + Debug> Value for Option<T> {
    type Number = T;

    const LIST: bool = false;

    fn numbers(&self) -> &[T] {
        self.as_slice()
    }
}

macro_rules! single {
    ($($number:ty),*) => {$(
        impl Value for $number {
            type Number = $number;

            const LIST: bool = false;

            fn numbers(&self) -> &[$number] {
                std::slice::from_ref(self)
            }
        }
    )*};
}
single!(f64, usize, u64, u32);

fn text(number: impl Debug) -> String {
    format!("{number:?}").trim_end_matches(".0").trim_matches('"').to_owned()
}

/// Refuses a value outside its range, which is `rule` in words, and an empty list.
pub(crate) fn within<V: Value>(
    name: &'static str,
    value: &V,
    (range, rule): (RangeInclusive<V::Number>, &'static str),
) -> Result<()> {
    // The name of the flag.
    let named = || &*name.replace('_', "-").leak();
    if V::LIST && value.numbers().is_empty() {
        return Err(Error::parameter(named(), "\"\"", "name at least one value"));
    }
    match value.numbers().iter().find(|number| !range.contains(number)) {
        Some(number) => Err(Error::parameter(named(), text(number), rule)),
        None => Ok(()),
    }
}

/// A default as it is written on the command line, if there is one.
#[cfg(feature = "cli")]
pub(crate) fn default_text<V: Value>(default: &V) -> clap::builder::Resettable<clap::builder::OsStr> {
    let numbers: Vec<String> = default.numbers().iter().map(text).collect();
    // Defaults live as long as the command line: for the whole program.
    (!numbers.is_empty()).then(|| (&*numbers.join(",").leak()).into()).into()
}

/// The flag of an option whose help ends with its range.
#[cfg(feature = "cli")]
pub(crate) fn ranged<V: Value>(arg: clap::Arg, _: &V, rule: &str) -> clap::Arg {
    let short = arg.get_help().map(|help| format!("{help}."));
    let long = arg.get_long_help().map(ToString::to_string).or(short).unwrap_or_default();
    let rule = if V::LIST { format!("Each {rule}") } else { format!("{}{}", rule[..1].to_uppercase(), &rule[1..]) };
    arg.long_help(format!("{long}\n\n{rule}."))
}

/// A range and its words.
macro_rules! range {
    (($least:literal to $most:literal)) => {
        ($least..=$most, concat!("from ", $least, " to ", $most))
    };
    ((from $least:literal)) => {
        (f64::from($least)..=f64::MAX, concat!("finite and at least ", $least))
    };
    ((above $least:literal)) => {
        (f64::from($least).next_up()..=f64::MAX, concat!("finite and above ", $least))
    };
    ((above $least:literal to $most:literal)) => {
        (f64::from($least).next_up()..=f64::from($most), concat!("above ", $least, " and at most ", $most))
    };
    ((above $least:literal below $most:literal)) => {
        (f64::from($least).next_up()..=f64::from($most).next_down(), concat!("above ", $least, " and below ", $most))
    };
}
pub(crate) use range;

/// A type of options of a study.
///
/// `field: type = default, "VALUE", (least to most);` is a field and its flag `--field VALUE`:
/// help, default and range are told here only. Without a range other code checks the number;
/// without `"VALUE"` attributes of `clap` tell the flag. The type has `Default`, and
/// `within_ranges` refuses numbers outside their ranges.
macro_rules! options {
    ($(#[$attribute:meta])* pub struct $name:ident {
        $($(#[$about:meta])* $field:ident: $type:ty = $default:expr $(, $value:literal $(, $range:tt)?)?;)*
    }) => {
        $(#[$attribute])*
        #[derive(Clone, Debug)]
        #[cfg_attr(feature = "cli", derive(clap::Args))]
        $($($(#[cfg_attr(feature = "cli", command(mut_arg(stringify!($field), |arg| {
            $crate::study::options::ranged(arg, &Self::default().$field, $crate::study::options::range!($range).1)
        })))])?)?)*
        pub struct $name {
            $($(#[cfg_attr(feature = "cli", arg(
                long,
                value_name = $value,
                value_delimiter = <$type as $crate::study::options::Value>::LIST.then_some(','),
                default_value = $crate::study::options::default_text(&Self::default().$field),
            ))])? $(#[$about])* pub $field: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default.into(),)* }
            }
        }

        impl $name {
            /// Refuses the first number outside its range.
            #[allow(dead_code, reason = "a type may have no ranges")]
            fn within_ranges(&self) -> $crate::error::Result<()> {
                $($($($crate::study::options::within(
                    stringify!($field),
                    &self.$field,
                    $crate::study::options::range!($range),
                )?;)?)?)*
                Ok(())
            }
        }
    };
}
pub(crate) use options;
