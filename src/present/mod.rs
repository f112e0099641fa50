//! The page of a report, and the machine it was made on. Knows no physics.

mod machine;
#[cfg(feature = "cli")]
mod page;

#[cfg(feature = "cli")]
pub(crate) use machine::machine;
pub(crate) use machine::machine_json;
#[cfg(feature = "cli")]
pub use page::{Page, Section, Shown};
