//! From outcomes to what people and machines read: tables, JSON, CSV, NPZ, and the input of figures.

mod compare;
mod run;
mod table;

pub use compare::{comparison_csv, comparison_json, comparison_table};
pub use run::{run_files, run_json, run_summary};
pub use table::table;

#[cfg(feature = "plot")]
pub use compare::comparison_png;
#[cfg(feature = "plot")]
pub use run::run_pictures;

/// What every output says of where it comes from.
fn provenance() -> String {
    format!("hertzchain {}", env!("CARGO_PKG_VERSION"))
}
