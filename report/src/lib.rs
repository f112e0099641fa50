//! Results as values, and what they become: text, JSON, CSV, NPZ, pictures, a page, files. Knows no
//! physics.
//!
//! | module | contents |
//! |---|---|
//! | [`report`] | results: facts, tables, pictures, told once |
//! | `figures` | pictures as PNG and SVG (feature `plot`) |
//! | [`present`] | the HTML page of reports |
//! | [`output`] | files, written whole or not at all; JSON, CSV, NPZ |
//! | [`number`] | numbers read from text, and written for people |
//! | [`named`](mod@named) | enumerations whose variants have names |

#[cfg(feature = "plot")]
pub mod figures;
#[cfg(any(feature = "cli", feature = "plot"))]
mod letters;
pub mod named;
pub mod number;
pub mod output;
pub mod present;
pub mod report;

use hertzchain_core::error;
#[cfg(feature = "plot")]
use hertzchain_core::numerics;

/// Kernels that are private otherwise, for tests: no part of the interface.
#[doc(hidden)]
pub mod internals {
    #[cfg(feature = "plot")]
    pub use crate::figures::{
        axes::{Axis, thin},
        canvas::{Canvas, SMALL, text_width},
        maps::edges,
        svg::svg,
    };
    #[cfg(feature = "plot")]
    pub use crate::letters::{Level, runs};
    pub use crate::output::npz::npy_head;
    #[cfg(feature = "cli")]
    pub use crate::present::{
        date,
        page::{judged, table_html},
    };
}
