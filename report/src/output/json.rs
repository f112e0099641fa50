//! JSON with 17 significant digits.

use serde::Serialize;
use serde_json::ser::{Formatter, PrettyFormatter, Serializer};
use std::io::{self, Write};

/// JSON text of a value: numbers with 17 significant digits, not-a-number and infinities as `null`.
///
/// ```
/// let text = hertzchain_report::output::to_json(&[0.1]);
/// assert_eq!(text.replace(char::is_whitespace, ""), "[1.0000000000000001e-1]");
/// ```
pub fn to_json(value: &impl Serialize) -> String {
    let mut text = Vec::new();
    // Values here have string keys and are written to memory: serialisation cannot fail.
    let _ = write_json(&mut text, value);
    String::from_utf8(text).unwrap_or_default()
}

/// Writes the text of [`to_json`] without holding it in memory.
pub fn write_json(to: impl Write, value: &impl Serialize) -> io::Result<()> {
    let mut to = io::BufWriter::new(to);
    value.serialize(&mut Serializer::with_formatter(&mut to, Digits::default()))?;
    to.flush()
}

/// Layout: objects over several lines, and arrays with all they contain on one line.
#[derive(Default)]
struct Digits {
    pretty: PrettyFormatter<'static>,
    depth: usize,
}

impl Formatter for Digits {
    fn write_f64<W: ?Sized + Write>(&mut self, writer: &mut W, value: f64) -> io::Result<()> {
        write!(writer, "{value:.16e}")
    }

    fn begin_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        writer.write_all(b"[")
    }

    fn end_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth -= 1;
        writer.write_all(b"]")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        writer.write_all(if first { b"" } else { b", " })
    }

    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        if self.depth > 0 { writer.write_all(b"{") } else { self.pretty.begin_object(writer) }
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        if self.depth > 0 { writer.write_all(b"}") } else { self.pretty.end_object(writer) }
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        if self.depth == 0 {
            return self.pretty.begin_object_key(writer, first);
        }
        writer.write_all(if first { b"" } else { b", " })
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }

    fn end_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        if self.depth > 0 { Ok(()) } else { self.pretty.end_object_value(writer) }
    }
}
