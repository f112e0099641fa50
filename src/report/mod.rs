//! From outcomes to what people and machines read: tables, JSON, CSV, NPZ, and the input of figures.

mod breather;
mod charts;
mod compare;
mod contacts;
mod dps;
mod drift;
mod evolve;
mod lifetimes;
mod machine;
mod orbits;
mod order;
#[cfg(feature = "cli")]
mod page;
mod run;
mod scaling;
mod stability;
mod table;
mod theorem;
mod wave;

pub use breather::{
    bright_files, bright_forces_csv, bright_json, bright_norms_csv, bright_periods_csv, bright_profiles_csv,
    bright_table, bright_tables, trivial_files, trivial_json, trivial_table,
};
pub use charts::{charts_csv, charts_json, charts_table};
pub use compare::{comparison_csv, comparison_json, comparison_table};
pub use contacts::{ContactTotals, contact_lines, contact_totals, contacts_csv, contacts_npz};
pub use dps::{averages_json, averages_table, homoclinic_json, homoclinic_table};
pub(crate) use dps::{center_word, of_sites};
pub use dps::{dark_csv, dark_json, dark_table};
pub use drift::{drift_csv, drift_json, drift_table};
#[cfg(feature = "plot")]
pub use evolve::evolution_png;
#[cfg(feature = "plot")]
pub(crate) use evolve::swing_maps;
pub use evolve::{evolution_csv, evolution_json, evolution_table, swing_csv};
pub use lifetimes::{lifetimes_csv, lifetimes_files, lifetimes_json, lifetimes_json_with_work, lifetimes_table};
pub use orbits::{branch_csv, branch_json, branch_npz, branch_table, dark_breather_json, dark_breather_table};
pub use orbits::{doubled_json, doubled_table};
pub use order::{order_csv, order_json, order_table};
#[cfg(feature = "cli")]
pub use page::{Block, Page, Section};
pub use run::{run_files, run_json, run_summary};
pub use scaling::{scaling_csv, scaling_json, scaling_table};
#[cfg(feature = "plot")]
pub(crate) use stability::figure as stability_figure;
pub(crate) use stability::{caption as stability_caption, shown};
pub use stability::{stability_csv, stability_json, stability_table, stability_tables};
pub use table::table;
pub use theorem::{theorem_csv, theorem_files, theorem_json, theorem_slopes_csv, theorem_table};
pub use wave::{wave_errors_csv, wave_files, wave_json, wave_profile_csv, wave_table, wave_tables};

#[cfg(feature = "plot")]
pub use charts::charts_pictures;
#[cfg(feature = "plot")]
pub use compare::comparison_png;
#[cfg(feature = "plot")]
pub use contacts::contacts_png;
#[cfg(feature = "plot")]
pub use drift::drift_png;
#[cfg(feature = "plot")]
pub use order::order_pictures;
#[cfg(feature = "plot")]
pub use run::run_pictures;
#[cfg(feature = "plot")]
pub use scaling::scaling_png;
#[cfg(feature = "plot")]
pub use stability::stability_png;

/// All of a scene as it runs, with the seed of what it draws, as JSON; an infinite mass ratio, which JSON has no number for, as `"inf"`.
pub fn scene_json(scene: &crate::scene::Scene) -> serde_json::Value {
    let mut value = serde_json::json!(scene.file());
    if scene.chain().params().rho.is_infinite() {
        value["chain"]["rho"] = serde_json::json!("inf");
    }
    value
}

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

/// The families of some methods, each once, and the index of that of each method: colours and headings of a legend.
#[cfg(feature = "plot")]
fn families(methods: &[crate::run::method::Method]) -> (Vec<String>, Vec<usize>) {
    let mut names: Vec<String> = Vec::new();
    let index = |method: &crate::run::method::Method| {
        names.iter().position(|name| name == method.family()).unwrap_or_else(|| {
            names.push(method.family().to_owned());
            names.len() - 1
        })
    };
    let indices = methods.iter().map(index).collect();
    (names, indices)
}
