//! One run: choice of its method, reports and files, and long runs in legs with checkpoints.

mod checkpoint;
mod choice;
pub(crate) mod contacts;
mod crossings;
mod report;
mod si;
mod signals;

pub use checkpoint::LongRun;
pub use choice::{MethodChoice, MethodRequest};
pub use contacts::{CONTACT_COLUMNS, ContactTotals, contact_lines, contact_totals, contacts_csv, contacts_npz};
pub use crossings::{Condition, with_conditions};
pub(super) use report::state_arrays;
pub use report::{RUN_FILES, RunView, run_files, run_pictures, run_summary};
pub use si::{contact_in_si, in_units, state_in_si};
pub(super) use si::{error_in, error_in_file};
pub use signals::Signals;
