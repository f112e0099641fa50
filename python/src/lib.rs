//! Bindings of hertzchain for Python: what cannot be said in Python. The package in `hertzchain/`
//! makes the interface of it.

mod error;
mod run;
mod scene;
mod studies;
mod theory;
mod work;

use hertzchain::figures::palette::{Marker, Style};
use pyo3::prelude::*;
use std::ffi::OsString;

/// The program, with its arguments; the first is its name. Returns the exit code.
#[pyfunction]
fn program(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| hertzchain::cli::main(arguments))
}

/// Names of all integrators.
#[pyfunction]
fn integrators() -> Vec<String> {
    hertzchain::Method::all().iter().map(hertzchain::Method::name).collect()
}

/// Colour, marker and lengths of dashes and gaps of an integrator in all pictures; none of another
/// name.
#[pyfunction]
fn look(name: &str) -> Option<(String, char, Vec<f64>)> {
    let Style { colour: (r, g, b), dash, marker } = Style::of_method(name)?;
    let letters = "os^Dv*<p>".chars();
    let letter =
        Marker::CLOSED.into_iter().zip(letters).find_map(|(one, letter)| (Some(one) == marker).then_some(letter));
    Some((format!("#{r:02x}{g:02x}{b:02x}"), letter?, dash.to_vec()))
}

#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::{
        integrators, look, program,
        run::{run, run_many},
        scene::{Scene, check_chain, scenes},
        studies::{Report, derivatives, load_branch, modes, monodromy, study},
        theory::{Bright, Wave, averages, flow, wave_of},
    };
    use hertzchain::scene::{BeadsSection, BondsSection, DriveSection, TableSection, TermSection, UnitsSection};
    use pyo3::prelude::*;
    use std::collections::HashMap;

    #[pymodule_init]
    fn constants(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        let (beads, bonds, units) = (BeadsSection::KEYS, BondsSection::KEYS, UnitsSection::KEYS);
        let (term, table, drive) = (TermSection::KEYS, TableSection::KEYS, DriveSection::KEYS);
        let keys = [("beads", beads), ("bonds", bonds), ("term", term), ("table", table)];
        let keys = keys.into_iter().chain([("drive", drive), ("units", units)]);
        module.add("KEYS", keys.map(|(table, keys)| (table, keys.to_vec())).collect::<HashMap<_, _>>())?;
        module.add("CONTACT_COLUMNS", hertzchain::study::CONTACT_COLUMNS.map(|(name, _)| name).to_vec())
    }
}
