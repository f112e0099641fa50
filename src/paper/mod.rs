//! The paper: its claims, our values and figures for them, and reports.
//!
//! | part | contents |
//! |---|---|
//! | `claims.toml`, [`claims`] | the claims of the paper in Sec. 2 to 8, one row each |
//! | `quantities/` | for each claim, by its id, the value that decides it |
//! | [`verify`] | claims and values side by side, with a verdict each |
//! | `verdicts.rs` | the verdicts as text, CSV and JSON |
//! | `figures/` | [`FIGURES`], one row each: studies, and what of their pictures is drawn |

pub(crate) mod claims;
mod figures;
pub(crate) mod quantities;
mod rule;
mod verdicts;
pub(crate) mod verify;

pub use claims::{Claim, Kind, claims};
pub use figures::{FIGURES, Figure, orbits};
pub use rule::Rule;
pub use verdicts::{Verify, verify_report};
pub use verify::{Item, Verdict, Verification, verify};
