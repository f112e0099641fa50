//! Flags of options, made and read in one way.

use super::{Range, Value, one, written};
use crate::{
    chain::Boundary,
    dps::Center,
    number,
    orbits::{DriveParameter, Formulation},
    run::Method,
    waves::WaveParameter,
};
use clap::{Arg, ArgAction, ArgMatches, Command, builder::ValueParser};
use std::fmt::Debug;

/// A type of which an option has one value.
pub(crate) trait One: Clone + Debug + Send + Sync + 'static {
    /// Whether the flag takes a value.
    const ACTION: ArgAction = ArgAction::Set;
    /// Whether a value may begin with a minus sign.
    const NUMBER: bool = false;

    /// What reads it.
    fn parser() -> ValueParser;
}

/// Numbers, each with what reads it and refuses what the type cannot hold.
macro_rules! numbers {
    ($($type:ty: $parser:expr;)*) => {$(
        impl One for $type {
            const NUMBER: bool = true;

            fn parser() -> ValueParser {
                ValueParser::new($parser)
            }
        }
    )*};
}
numbers! {
    f64: number::double;
    usize: number::whole::<usize>;
    u64: number::whole::<u64>;
    u32: number::whole::<u32>;
    i64: number::signed;
}
one!(String, std::path::PathBuf);
one!(Boundary, Center, Formulation, DriveParameter, WaveParameter);
one!(Method: Method::named);

impl One for bool {
    const ACTION: ArgAction = ArgAction::SetTrue;

    fn parser() -> ValueParser {
        ValueParser::bool()
    }
}

/// A field of options: a flag, or a group of flags. `self` is its default.
pub(crate) trait Field {
    /// The command with it; a group has flags of its own.
    fn add(&self, command: Command, flag: &Flag) -> Command;

    /// What the command line says, otherwise the default.
    fn read(&self, matches: &ArgMatches, id: &str) -> Self;
}

/// The values that the command line gives; none also where the command has no such flag.
fn given<'a, T: One>(matches: &'a ArgMatches, id: &str) -> impl Iterator<Item = &'a T> {
    let known = matches.try_contains_id(id).unwrap_or(false);
    known.then(|| matches.get_many(id)).flatten().into_iter().flatten()
}

impl<T: One> Field for T {
    fn add(&self, command: Command, flag: &Flag) -> Command {
        let arg = flag.arg::<T>(self, T::ACTION);
        let required = arg.get_action().takes_values() && arg.get_default_values().is_empty();
        command.arg(arg.required(required))
    }

    fn read(&self, matches: &ArgMatches, id: &str) -> Self {
        given(matches, id).next().unwrap_or(self).clone()
    }
}

impl<T: One> Field for Option<T> {
    /// A switch that may be given a value: `--name`, `--name=true`, `--name=false`.
    fn add(&self, command: Command, flag: &Flag) -> Command {
        let arg = flag.arg::<T>(self, ArgAction::Set);
        let switch = |arg: Arg| arg.require_equals(true).num_args(0..=1).default_missing_value("true");
        command.arg(if T::ACTION.takes_values() { arg } else { switch(arg).hide_possible_values(true) })
    }

    fn read(&self, matches: &ArgMatches, id: &str) -> Self {
        given(matches, id).next().or(self.as_ref()).cloned()
    }
}

impl<T: One> Field for Vec<T> {
    fn add(&self, command: Command, flag: &Flag) -> Command {
        command.arg(flag.arg::<T>(self, ArgAction::Append))
    }

    fn read(&self, matches: &ArgMatches, id: &str) -> Self {
        let all: Self = given(matches, id).cloned().collect();
        if all.is_empty() { self.clone() } else { all }
    }
}

/// What [`options!`] tells of a field.
pub(crate) struct Flag {
    pub(crate) id: &'static str,
    /// The lines of its help.
    pub(crate) docs: &'static [&'static str],
    /// The name of its value in help; an argument without a flag has none, nor has a switch.
    pub(crate) value: Option<&'static str>,
    /// What else is said to clap.
    pub(crate) more: fn(Arg) -> Arg,
    /// The rule of its range.
    pub(crate) rule: Option<&'static str>,
}

impl Flag {
    /// A group of flags, which tell their own.
    pub(crate) const GROUP: Self = Self { id: "", docs: &[], value: None, more: |arg| arg, rule: None };

    /// The flag with its default: none for `None`, NaN and an empty list. Values of lists are
    /// separated by commas. Help ends with the range.
    fn arg<T: One>(&self, default: &dyn Debug, action: ArgAction) -> Arg {
        // Negative numbers as clap knows them have no sign in the exponent and stand in no list.
        let arg = Arg::new(self.id).value_parser(T::parser()).allow_hyphen_values(T::NUMBER);
        self.told(arg, default, action)
    }

    /// The same for all types.
    fn told(&self, arg: Arg, default: &dyn Debug, action: ArgAction) -> Arg {
        let (short, long) = paragraphs(self.docs);
        let (list, switch) = (matches!(action, ArgAction::Append), !action.takes_values());
        let arg = arg.help(short).action(action);
        let arg = arg.value_name(self.value.map_or_else(|| self.id.to_uppercase(), str::to_owned).leak() as &str);
        let arg = if let Some(long) = long { arg.long_help(long) } else { arg };
        let arg = if list { arg.value_delimiter(',') } else { arg };
        let named = self.value.is_some() || switch;
        let arg = if named { arg.long(self.id.replace('_', "-").leak() as &str) } else { arg };
        let arg = (self.more)(arg);
        let arg = match (self.rule, arg.get_long_help()) {
            (None, _) => arg,
            (Some(rule), long) => {
                let long = long.map_or_else(|| format!("{}.", arg.get_help().unwrap_or_default()), ToString::to_string);
                let first = if list { format!("Each is {}", &rule[..1]) } else { rule[..1].to_uppercase() };
                arg.long_help(format!("{long}\n\n{first}{}.", &rule[1..]))
            }
        };
        if !arg.get_default_values().is_empty() || !arg.get_action().takes_values() {
            return arg;
        }
        let text = format!("{default:?}").to_lowercase();
        let items = text.trim_start_matches("some(").trim_matches(['[', ']', ')']).split(", ").map(written);
        let told = items.filter(|item| !["", "none", "nan"].contains(&&**item));
        // Defaults live as long as the command line: for the whole program. Help breaks lines
        // between values only, so that a long list is several.
        let told: Vec<&str> = told.map(|item| &*item.leak()).collect();
        match told.join(",") {
            none if none.is_empty() => arg,
            list if list.len() <= 40 => arg.default_value(&*list.leak()),
            _ => arg.default_values(told),
        }
    }
}

/// Short and long help from the lines of a comment: its first paragraph without the full stop, and
/// all paragraphs, if it has several.
pub(crate) fn paragraphs(docs: &[&str]) -> (String, Option<String>) {
    let lines = |lines: &[&str]| lines.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ");
    let all: Vec<String> = docs.split(|line| line.trim().is_empty()).map(lines).collect();
    (all[0].trim_end_matches('.').to_owned(), (all.len() > 1).then(|| all.join("\n\n")))
}

/// The words of a range.
pub(crate) fn rule<V: Value>(_: &V, (_, rule): Range<V>) -> &'static str {
    rule
}
