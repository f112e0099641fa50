//! The page of a report, and the machine it was made on. Knows no physics.

mod machine;
#[cfg(feature = "cli")]
pub(crate) mod page;

pub use machine::{date, machine, machine_json, timed};
#[cfg(feature = "cli")]
pub use page::{Page, Section, Shown};
