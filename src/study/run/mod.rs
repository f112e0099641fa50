//! One run: choice of its method, reports and files, and long runs in legs with checkpoints.

mod checkpoint;
mod contacts;
mod how;
mod parts;
mod report;
mod si;

pub use checkpoint::LongRun;
#[cfg(feature = "plot")]
pub use contacts::contacts_picture;
pub use contacts::{CONTACT_COLUMNS, ContactTotals, contact_lines, contact_totals, contacts_csv, contacts_npz};
pub use how::{MethodChoice, MethodRequest};
pub use parts::parts_plan;
#[cfg(feature = "plot")]
pub use report::run_pictures;
pub use report::{RUN_FILES, RunView, run_files, run_json, run_summary};
pub use si::in_si;
