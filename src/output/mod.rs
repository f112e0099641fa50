//! Files and text: JSON with 17 significant digits, CSV, NPZ, and folders whose files are written whole or not at all.

mod folder;
mod json;
mod npz;

pub use folder::Folder;
pub use json::to_json;
pub use npz::{Archive, Array, SETTINGS, npz, npz_with};

/// Rows of numbers as CSV with a line of names; every number so that it reads back exactly.
pub fn csv(names: &[&str], rows: impl IntoIterator<Item = Vec<f64>>) -> Vec<u8> {
    let mut text = names.join(",");
    text.push('\n');
    for row in rows {
        let cells: Vec<String> = row.iter().map(|value| format!("{value:e}")).collect();
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    text.into_bytes()
}
