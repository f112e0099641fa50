//! The paper: what it says, what we compute for it, and reports of both.
//!
//! | part | what it holds |
//! |---|---|
//! | `claims.toml`, [`claims`] | what the paper says in Sec. 3 to 7: a row for each claim |
//! | `quantities/` | for each claim, by its id, the value that decides it |
//! | [`verify`] | claims and values side by side, with a verdict each |
//! | `verdicts.rs` | these as text, CSV and JSON |
//! | `figures/` | [`FIGURES`], a row each; data, captions, tables and pictures |

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
