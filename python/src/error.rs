//! Errors as Python exceptions: the classes of `hertzchain._errors`, with the text of the program.

use hertzchain::{Error, integrators};
use pyo3::{prelude::*, types::PyType};
use std::any::Any;

/// The exception for an error.
pub(crate) fn exception(py: Python<'_>, error: &Error) -> PyErr {
    let class = match error {
        Error::Parameter { .. } | Error::Options(_) | Error::Integration(integrators::Error::Argument { .. }) => {
            "ParameterError"
        }
        Error::Unknown { .. } => "UnknownNameError",
        Error::Scene { .. } => "SceneError",
        Error::Integration(_) | Error::Run(_) | Error::Doubtful(_) | Error::Point { .. } => "RunError",
        Error::Stalled { .. } => "ConvergenceError",
        Error::File { .. } | Error::Content { .. } => "FileError",
        _ => "Error",
    };
    named(py, class, &hertzchain::cli::in_python(&error.to_string()))
}

/// The exception of a panic: no input may lead to one.
pub(crate) fn panicked(py: Python<'_>, panic: &(dyn Any + Send)) -> PyErr {
    let said = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
    let said = said.unwrap_or("no message");
    named(py, "InternalError", &format!("this is a bug of hertzchain, please report it: {said}"))
}

fn named(py: Python<'_>, class: &str, message: &str) -> PyErr {
    let class = py.import("hertzchain._errors").and_then(|module| module.getattr(class));
    match class.and_then(|class| Ok(class.cast_into::<PyType>()?)) {
        Ok(class) => PyErr::from_type(class, message.to_owned()),
        Err(error) => error,
    }
}

/// A result whose error becomes an exception.
pub(crate) trait OrRaise<T> {
    fn or_raise(self, py: Python<'_>) -> PyResult<T>;
}

impl<T> OrRaise<T> for hertzchain::Result<T> {
    fn or_raise(self, py: Python<'_>) -> PyResult<T> {
        self.map_err(|error| exception(py, &error))
    }
}
