//! Options of studies, each told once: field, default, range and meaning.

use crate::error::{Error, Result};
#[cfg(feature = "cli")]
use std::fmt::Display;
use std::ops::RangeInclusive;

/// A value of an option: a number or a list of numbers, which has a range.
#[cfg_attr(not(feature = "cli"), allow(dead_code, reason = "flags need all of it, checks only the numbers"))]
pub(crate) trait Value<T>: Sized {
    /// The numbers.
    fn numbers(&self) -> &[T];
    /// The value with these numbers.
    fn of(numbers: Vec<T>) -> Self;
    /// Whether it is a list, separated by commas.
    const LIST: bool;
}

impl<T: Copy> Value<T> for Vec<T> {
    fn numbers(&self) -> &[T] {
        self
    }

    fn of(numbers: Vec<T>) -> Self {
        numbers
    }

    const LIST: bool = true;
}

macro_rules! single {
    ($($number:ty),*) => {$(
        impl Value<$number> for $number {
            fn numbers(&self) -> &[$number] {
                std::slice::from_ref(self)
            }

            fn of(numbers: Vec<$number>) -> Self {
                numbers[0]
            }

            const LIST: bool = false;
        }
    )*};
}
single!(f64, usize, u64, u32);

/// Refuses a value outside its range, which is `rule` in words, and an empty list.
pub(crate) fn within<T: PartialOrd + ToString, V: Value<T>>(
    name: &'static str,
    value: &V,
    range: &RangeInclusive<T>,
    rule: &'static str,
) -> Result<()> {
    if value.numbers().is_empty() {
        return Err(Error::parameter(name, "", "at least one"));
    }
    match value.numbers().iter().find(|number| !range.contains(number)) {
        Some(number) => Err(Error::parameter(name, number.to_string(), rule)),
        None => Ok(()),
    }
}

/// The flag of an option. The first paragraph of `doc` is its short help.
#[cfg(feature = "cli")]
pub(crate) fn flag<T: Display, V: Value<T>>(
    name: &'static str,
    doc: &str,
    value_name: &'static str,
    default: &V,
    range: &str,
    parser: impl clap::builder::IntoResettable<clap::builder::ValueParser>,
) -> clap::Arg {
    let lines: Vec<&str> = doc.lines().map(str::trim).collect();
    let mut paragraphs = lines.split(|line| line.is_empty()).map(|lines| lines.join(" "));
    let short = paragraphs.next().unwrap_or_default();
    let rule = format!("{} {range}.", if V::LIST { "Each is from" } else { "From" });
    let long: Vec<String> = [short.clone()].into_iter().chain(paragraphs).chain([rule]).collect();
    // Defaults live as long as the command line: for the whole program.
    let defaults = default.numbers().iter().map(|number| &*String::leak(number.to_string()));
    let arg = clap::Arg::new(name).long(name).value_name(value_name).value_parser(parser);
    let arg = arg.help(short.trim_end_matches('.').to_owned()).long_help(long.join("\n\n")).default_values(defaults);
    if V::LIST { arg.value_delimiter(',') } else { arg }
}

/// A type of options of a study.
///
/// `field: type = default, least to most, "VALUE", number;` is a field and its flag `--field
/// VALUE`: help, default and range are told here only. The type has `Default`, and `within_ranges`
/// refuses values outside them.
macro_rules! options {
    ($(#[$attribute:meta])* pub struct $name:ident {
        $($(#[doc = $doc:literal])* $field:ident: $type:ty = $default:expr, $least:literal to $most:literal, $value:literal, $number:ty;)*
    }) => {
        $(#[$attribute])*
        #[derive(Clone, Debug)]
        pub struct $name {
            $($(#[doc = $doc])* pub $field: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default.into(),)* }
            }
        }

        impl $name {
            /// Refuses the first value outside its range.
            fn within_ranges(&self) -> $crate::error::Result<()> {
                $($crate::study::options::within::<$number, $type>(
                    stringify!($field),
                    &self.$field,
                    &($least..=$most),
                    concat!("from ", $least, " to ", $most),
                )?;)*
                Ok(())
            }
        }

        #[cfg(feature = "cli")]
        impl clap::Args for $name {
            fn augment_args(command: clap::Command) -> clap::Command {
                let default = Self::default();
                command.args([$($crate::study::options::flag::<$number, $type>(
                    stringify!($field),
                    concat!($($doc, "\n"),*),
                    $value,
                    &default.$field,
                    concat!($least, " to ", $most),
                    clap::value_parser!($number),
                ),)*])
            }

            fn augment_args_for_update(command: clap::Command) -> clap::Command {
                Self::augment_args(command)
            }
        }

        #[cfg(feature = "cli")]
        impl clap::FromArgMatches for $name {
            fn from_arg_matches(matches: &clap::ArgMatches) -> std::result::Result<Self, clap::Error> {
                $(let $field = matches.get_many::<$number>(stringify!($field)).into_iter().flatten().copied();)*
                Ok(Self { $($field: <$type as $crate::study::options::Value<$number>>::of($field.collect()),)* })
            }

            fn update_from_arg_matches(&mut self, matches: &clap::ArgMatches) -> std::result::Result<(), clap::Error> {
                Self::from_arg_matches(matches).map(|told| *self = told)
            }
        }
    };
}
pub(crate) use options;
