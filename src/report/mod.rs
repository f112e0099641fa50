//! From outcomes to what people and machines read: tables, JSON, CSV, NPZ, and the input of figures.

mod compare;
mod contacts;
mod order;
mod run;
mod table;

pub use compare::{comparison_csv, comparison_json, comparison_table};
pub use contacts::{ContactTotals, contact_lines, contact_totals, contacts_csv, contacts_npz};
pub use order::{order_csv, order_json, order_table};
pub use run::{run_files, run_json, run_summary};
pub use table::table;

#[cfg(feature = "plot")]
pub use compare::comparison_png;
#[cfg(feature = "plot")]
pub use contacts::contacts_png;
#[cfg(feature = "plot")]
pub use order::order_pictures;
#[cfg(feature = "plot")]
pub use run::run_pictures;

/// The end of every caption: the scene with its parameters, and the program.
#[cfg(feature = "plot")]
fn provenance(scene: &crate::scene::Scene, how: &str) -> String {
    let params = scene.chain().params();
    format!(
        "Scene {}: {}. N = {}, α = {}, κ = {}, ρ = {}. {how} hertzchain {}.",
        scene.name(),
        scene.file().summary,
        scene.chain().sites(),
        params.alpha,
        params.kappa,
        params.rho,
        env!("CARGO_PKG_VERSION")
    )
}
