//! One number for each site or bond: as a number, a list, or a rule.

use super::Quantity;
use crate::{
    error::{Error, Result, require},
    random::uniform,
};
use serde::{
    Deserialize, Deserializer, Serialize,
    de::{MapAccess, SeqAccess, Visitor, value},
};
use std::fmt;

/// The numbers of all sites or bonds, as a scene gives them.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Values {
    /// One number for all.
    Number(f64),
    /// One for each.
    List(Vec<f64>),
    /// By a rule.
    Rule(Box<Rule>),
}

sections! {
    /// A rule from which a list of numbers follows: exactly one of `value`, `pattern`, `taper` and
    /// `random`.
    #[derive(Default)]
    pub struct Rule {
        /// One number for all.
        value?: f64,
        /// The first numbers of the list.
        pattern?: Vec<f64>,
        /// Whether the pattern repeats; otherwise its last number fills the rest of the list.
        repeat?: bool,
        /// Ratio of each number to the one before it; the first number is `from` (1 if left out).
        taper?: f64,
        /// Law of random numbers: `"uniform"`, between `from` and `to`.
        random?: String,
        /// First number of a taper, or lower end of random numbers.
        from?: f64,
        /// Upper end of random numbers.
        to?: f64,
        /// Seed of random numbers (1 if left out).
        seed?: u64,
        /// Exceptions `[index, value]` that replace single numbers; indices are counted from 0.
        except?: Vec<(usize, f64)>,
    }
}

/// Is told the key, the quantity and each number of it.
pub(crate) type Seen<'a> = &'a mut dyn FnMut(&'static str, Quantity, &mut f64);

/// A part of a scene that has numbers with units.
pub(crate) trait Measured {
    /// Shows all of them.
    fn measured(&mut self, seen: Seen<'_>);
}

/// One number or several of the same quantity.
pub(crate) trait Numbers {
    /// Shows each.
    fn each(&mut self, seen: &mut dyn FnMut(&mut f64));
}

impl Numbers for f64 {
    fn each(&mut self, seen: &mut dyn FnMut(&mut f64)) {
        seen(self);
    }
}

impl<T: Numbers> Numbers for Option<T> {
    fn each(&mut self, seen: &mut dyn FnMut(&mut f64)) {
        self.iter_mut().for_each(|one| one.each(seen));
    }
}

impl Numbers for Vec<f64> {
    fn each(&mut self, seen: &mut dyn FnMut(&mut f64)) {
        self.iter_mut().for_each(seen);
    }
}

impl Numbers for [f64; 2] {
    fn each(&mut self, seen: &mut dyn FnMut(&mut f64)) {
        self.iter_mut().for_each(seen);
    }
}

impl Numbers for Values {
    fn each(&mut self, seen: &mut dyn FnMut(&mut f64)) {
        match self {
            Self::Number(number) => seen(number),
            Self::List(list) => list.each(seen),
            Self::Rule(rule) => {
                let Rule { value, pattern, taper, from, to, except, .. } = &mut **rule;
                // The first number of a taper is 1 if it is left out.
                *from = from.or(taper.map(|_| 1.0));
                [value, from, to].into_iter().for_each(|one| one.each(seen));
                pattern.each(seen);
                except.iter_mut().flatten().for_each(|(_, value)| seen(value));
            }
        }
    }
}

impl<'de> Deserialize<'de> for Values {
    fn deserialize<D: Deserializer<'de>>(from: D) -> std::result::Result<Self, D::Error> {
        struct Any;
        impl<'de> Visitor<'de> for Any {
            type Value = Values;

            fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
                out.write_str("a number, a list of numbers or a rule such as { pattern = [1.0, 0.5], repeat = true }")
            }

            fn visit_f64<E>(self, value: f64) -> std::result::Result<Values, E> {
                Ok(Values::Number(value))
            }

            fn visit_i64<E>(self, value: i64) -> std::result::Result<Values, E> {
                Ok(Values::Number(value as f64))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> std::result::Result<Values, A::Error> {
                Vec::deserialize(value::SeqAccessDeserializer::new(list)).map(Values::List)
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> std::result::Result<Values, A::Error> {
                Rule::deserialize(value::MapAccessDeserializer::new(map)).map(|rule| Values::Rule(Box::new(rule)))
            }
        }
        from.deserialize_any(Any)
    }
}

impl Values {
    /// One number for each of `count` sites or bonds; `name` is the key, for messages.
    ///
    /// # Errors
    /// A list of another length, or a rule that says too much, too little or something unknown.
    pub(crate) fn of(&self, name: &'static str, count: usize) -> Result<Vec<f64>> {
        match self {
            Self::Number(value) => Ok(vec![*value; count]),
            Self::List(values) if values.len() == count => Ok(values.clone()),
            Self::List(values) => {
                let rule = "a list has one number for each site, or for each bond that can touch";
                Err(Error::parameter(name, format!("{} numbers for {count}", values.len()), rule))
            }
            Self::Rule(rule) => rule.of(name, count),
        }
    }

    /// The same; a rule that has only exceptions changes the numbers of `base`.
    pub(super) fn over(&self, name: &'static str, base: Vec<f64>) -> Result<Vec<f64>> {
        match self {
            Self::Rule(rule) if **rule == (Rule { except: rule.except.clone(), ..Rule::default() }) => {
                rule.with(name, base)
            }
            _ => self.of(name, base.len()),
        }
    }

    /// The numbers of a list; one number is a list of one.
    ///
    /// # Errors
    /// A rule.
    pub(super) fn list(&self, name: &'static str) -> Result<Vec<f64>> {
        match self {
            Self::Number(value) => Ok(vec![*value]),
            Self::List(values) => Ok(values.clone()),
            Self::Rule(_) => Err(Error::parameter(name, "a rule", "a number or a list, one number a harmonic")),
        }
    }
}

impl Rule {
    fn of(&self, name: &'static str, count: usize) -> Result<Vec<f64>> {
        let refused = |value: String, rule| Err(Error::parameter(name, value, rule));
        let Self { value, pattern, repeat, taper, random, from, to, seed, .. } = self;
        let whole = repeat.is_none() || pattern.is_some();
        require(whole, name, "repeat", "`repeat` belongs to a `pattern`")?;
        let whole = from.is_none() || taper.is_some() || random.is_some();
        require(whole, name, "from", "`from` belongs to a `taper` or to `random`")?;
        let whole = to.is_none() && seed.is_none() || random.is_some();
        require(whole, name, "to, seed", "`to` and `seed` belong to `random`")?;
        let values = match (value, pattern, taper, random) {
            (Some(value), None, None, None) => vec![*value; count],
            (None, Some(pattern), None, None) => repeated(name, pattern, *repeat, count)?,
            (None, None, Some(taper), None) => {
                require(taper.is_finite() && *taper > 0.0, name, taper, "a taper is finite and positive")?;
                let first = from.unwrap_or(1.0);
                (0..count).map(|i| first * taper.powf(i as f64)).collect()
            }
            (None, None, None, Some(law)) => match (law.as_str(), from, to) {
                ("uniform", Some(from), Some(to)) if from <= to => {
                    let mut draw = uniform(seed.unwrap_or(1));
                    (0..count).map(|_| from + 0.5 * (to - from) * (1.0 + draw())).collect()
                }
                ("uniform", ..) => return refused("random".into(), "`uniform` draws from `from` to `to`, from <= to"),
                _ => return refused(law.clone(), "`random` is \"uniform\""),
            },
            _ => return refused("a rule".into(), "exactly one of `value`, `pattern`, `taper` and `random`"),
        };
        self.with(name, values)
    }

    /// The values with the exceptions in place.
    fn with(&self, name: &'static str, mut values: Vec<f64>) -> Result<Vec<f64>> {
        let count = values.len();
        for &(i, value) in self.except.iter().flatten() {
            let rule = "an exception is counted from 0, within the list";
            let place = values.get_mut(i).ok_or_else(|| Error::parameter(name, format!("{i} of {count}"), rule))?;
            *place = value;
        }
        Ok(values)
    }
}

/// The list of `count` numbers that a pattern makes.
fn repeated(name: &'static str, pattern: &[f64], repeat: Option<bool>, count: usize) -> Result<Vec<f64>> {
    let Some(&last) = pattern.last() else {
        return Err(Error::parameter(name, "[]", "a pattern has at least one number"));
    };
    let value = format!("{} numbers for {count}", pattern.len());
    require(pattern.len() <= count, name, value, "a pattern is not longer than what it is for")?;
    let at =
        |i: usize| if repeat == Some(true) { pattern[i % pattern.len()] } else { *pattern.get(i).unwrap_or(&last) };
    Ok((0..count).map(at).collect())
}
