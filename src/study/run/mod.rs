//! One run as people and machines read it, and long runs in legs that are kept.

mod checkpoint;
mod contacts;
mod report;

pub use checkpoint::LongRun;
#[cfg(feature = "plot")]
pub use contacts::contacts_png;
pub use contacts::{ContactTotals, contact_lines, contact_totals, contacts_csv, contacts_npz};
#[cfg(feature = "plot")]
pub use report::run_pictures;
pub use report::{RUN_FILES, run_files, run_json, run_summary};
