//! Values of Rust types from TOML by one path: `toml` has five, and each is compiled for each type.

use serde::de::{DeserializeOwned, Deserializer, Error as _, IntoDeserializer, Unexpected, Visitor, value};
use std::{cell::Cell, iter::from_fn, ops::Range};
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use value::{Error, MapDeserializer, SeqDeserializer};

/// Reads a table. An error is its message and the bytes that cause it.
pub(crate) fn read_table<T: DeserializeOwned>(table: &Spanned<DeTable>) -> Result<T, (String, Range<usize>)> {
    let (table, at) = (Spanned::new(table.span(), DeValue::Table(table.get_ref().clone())), Cell::default());
    T::deserialize(Reader(&table, &at)).map_err(|error| (error.to_string(), at.take()))
}

/// A value, and the bytes of the key or value that was read last.
#[derive(Clone, Copy)]
struct Reader<'a>(&'a Spanned<DeValue<'a>>, &'a Cell<Range<usize>>);

impl<'a> Reader<'a> {
    /// The entries of a table; a key that is missing at the end is missing in the whole table.
    fn map(self, table: &'a DeTable) -> MapDeserializer<'a, impl Iterator<Item = (&'a str, Self)>, Error> {
        let Self(whole, at) = self;
        let entries = table.iter().inspect(|(key, _)| at.set(key.span()));
        let end = from_fn(|| (at.set(whole.span()), None).1);
        MapDeserializer::new(entries.map(move |(key, value)| (&**key.get_ref(), Self(value, at))).chain(end))
    }
}

impl<'de> IntoDeserializer<'de, Error> for Reader<'de> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self.1.set(self.0.span());
        self
    }
}

impl<'de> Deserializer<'de> for Reader<'de> {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self.0.get_ref() {
            DeValue::Array(list) => visitor.visit_seq(SeqDeserializer::new(list.iter().map(|one| Self(one, self.1)))),
            _ => self.deserialize_struct("", &[], visitor),
        }
    }

    fn deserialize_struct<V: Visitor<'de>>(self, _: &str, _: &[&str], visitor: V) -> Result<V::Value, Error> {
        match self.0.get_ref() {
            DeValue::String(text) => visitor.visit_str(text),
            DeValue::Integer(whole) => {
                let (text, radix) = (whole.as_str(), whole.radix());
                match (i64::from_str_radix(text, radix), u64::from_str_radix(text, radix)) {
                    (Ok(whole), _) => visitor.visit_i64(whole),
                    (_, Ok(whole)) => visitor.visit_u64(whole),
                    _ => Err(Error::invalid_type(Unexpected::Other(&format!("integer `{whole}`")), &visitor)),
                }
            }
            DeValue::Float(number) => visitor.visit_f64(number.as_str().parse().map_err(Error::custom)?),
            DeValue::Boolean(yes) => visitor.visit_bool(*yes),
            DeValue::Datetime(_) => Err(Error::invalid_type(Unexpected::Other("date or time"), &visitor)),
            DeValue::Array(_) => Err(Error::invalid_type(Unexpected::Seq, &visitor)),
            DeValue::Table(table) => visitor.visit_map(self.map(table)),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_some(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(self, _: &str, _: &[&str], visitor: V) -> Result<V::Value, Error> {
        let name = self.0.get_ref().as_str().ok_or_else(|| Error::custom("wanted string"))?;
        visitor.visit_enum(name.into_deserializer())
    }

    serde::forward_to_deserialize_any! {
        bool u8 u16 u32 u64 i8 i16 i32 i64 f32 f64 char str string seq bytes byte_buf map unit ignored_any
        unit_struct newtype_struct tuple_struct tuple identifier
    }
}
