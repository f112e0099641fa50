//! Bindings of hertzchain for Python: what cannot be said in Python. The package in `hertzchain/`
//! makes the interface of it.

mod error;
mod run;
mod scene;
mod studies;
mod theory;
mod work;

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

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("CONTACT_COLUMNS", hertzchain::study::CONTACT_COLUMNS.to_vec())?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<theory::Wave>()?;
    module.add_class::<theory::Bright>()?;
    module.add_function(wrap_pyfunction!(program, module)?)?;
    module.add_function(wrap_pyfunction!(integrators, module)?)?;
    module.add_function(wrap_pyfunction!(scene::scenes, module)?)?;
    module.add_function(wrap_pyfunction!(scene::check_chain, module)?)?;
    module.add_function(wrap_pyfunction!(run::run, module)?)?;
    module.add_function(wrap_pyfunction!(studies::dark, module)?)?;
    module.add_function(wrap_pyfunction!(studies::continue_branch, module)?)?;
    module.add_function(wrap_pyfunction!(studies::load_branch, module)?)?;
    module.add_function(wrap_pyfunction!(studies::driven_orbit, module)?)?;
    module.add_function(wrap_pyfunction!(studies::driven_branch, module)?)?;
    module.add_function(wrap_pyfunction!(studies::normal_mode, module)?)?;
    module.add_function(wrap_pyfunction!(studies::compare_json, module)?)?;
    module.add_function(wrap_pyfunction!(studies::sweep_plan, module)?)?;
    module.add_function(wrap_pyfunction!(studies::monodromy, module)?)?;
    module.add_function(wrap_pyfunction!(theory::wave_of, module)?)?;
    module.add_function(wrap_pyfunction!(theory::averages, module)?)?;
    module.add_function(wrap_pyfunction!(theory::homoclinic, module)?)?;
    module.add_function(wrap_pyfunction!(theory::dark_profile, module)?)?;
    module.add_function(wrap_pyfunction!(theory::flow, module)?)?;
    Ok(())
}
