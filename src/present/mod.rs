//! Numbers and words as text: tables, rows, the page of a report, and the machine they were made
//! on. Knows no physics.

mod machine;
#[cfg(feature = "cli")]
mod page;
mod rows;
mod table;

#[cfg(feature = "cli")]
pub(crate) use machine::machine;
pub(crate) use machine::machine_json;
#[cfg(feature = "cli")]
pub use page::{Page, Section, Shown};
pub(crate) use rows::cell;
pub use table::table;
