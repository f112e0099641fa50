//! The paper: what it says, the numbers and figures that we get for it, and reports of both.
//!
//! | part | what it holds |
//! |---|---|
//! | `claims.toml`, [`claims`] | what the paper says: one row for each number, formula and statement of Sec. 3 to 7 |
//! | `quantities/` | for each claim, by its id, the value that decides it |
//! | [`verify`] | claims and values side by side, with a verdict each |
//! | `verdicts.rs` | these as text, CSV and JSON |
//! | `figures/` | [`FIGURES`]: one row for each figure, its data; its caption, its tables and its picture |

mod claims;
mod figures;
mod quantities;
mod rule;
mod verdicts;
mod verify;

pub use claims::{Claim, Kind, claims};
pub use figures::{
    Data, DoublingData, Drawn, EvolutionRun, FIGURES, Figure, FloquetData, MassRatioData, OrbitData, OrbitRecipe,
    ProfileData, Recipe, WaveColumn, WavePanel, WaveRun, figures_json, figures_table,
};
pub use rule::Rule;
pub use verdicts::{verify_csv, verify_json, verify_table};
pub use verify::{Item, Verdict, Verification, verify};
