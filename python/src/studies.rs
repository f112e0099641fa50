//! Studies by their command lines, through `hertzchain::cli::study`; and what reports do not have.

use crate::{
    error::OrRaise,
    scene::Scene,
    work::{finished, watched},
};
use hertzchain::{
    Boundary, Error,
    chain::{DriveKind, Parameter, Variations},
    cli,
    figures::Format,
    orbits::{Branch, Continuation},
    output::{Archive, to_json},
    report::{self, Cell},
    study::{branch_from_archive, branch_report, study as analysed},
    sweep::Engine,
};
use numpy::{PyArray1, PyArray2, PyReadonlyArray2, prelude::*};
use pyo3::{IntoPyObjectExt, prelude::*, types::PyBytes};
use std::{ffi::OsString, path::PathBuf};

/// The report of a study.
#[pyclass(frozen, module = "hertzchain._native")]
pub(crate) struct Report(report::Report);

/// The columns of a table by name, each a list.
type Columns<'py> = Vec<(String, Vec<Bound<'py, PyAny>>)>;

#[pymethods]
impl Report {
    /// The JSON, as `--json` prints it.
    #[getter]
    fn json(&self) -> String {
        to_json(&self.0.json())
    }

    #[getter]
    fn text(&self) -> String {
        self.0.text()
    }

    /// Why the study has not done what it was asked for.
    #[getter]
    fn failure(&self) -> Option<&str> {
        self.0.error()
    }

    /// What is remarkable.
    #[getter]
    fn remark(&self) -> Option<&str> {
        self.0.remarks()
    }

    /// The columns of all tables, by name.
    fn tables<'py>(&self, py: Python<'py>) -> PyResult<Vec<(String, Columns<'py>)>> {
        let value = |cell| match cell {
            Cell::Number(x) => x.into_bound_py_any(py),
            Cell::Count(n) => n.into_bound_py_any(py),
            Cell::Flag(holds) => holds.into_bound_py_any(py),
            Cell::Word(word) => word.unwrap_or_default().into_bound_py_any(py),
            Cell::Nested(_) => f64::NAN.into_bound_py_any(py),
        };
        let column =
            |(name, cells): (String, Vec<Cell>)| Ok((name, cells.into_iter().map(value).collect::<PyResult<_>>()?));
        self.0
            .tables()
            .map(|table| Ok((table.name().to_owned(), table.values().map(column).collect::<PyResult<_>>()?)))
            .collect()
    }

    /// Names and bytes of all files, with pictures in some formats.
    fn files<'py>(&self, py: Python<'py>, formats: Vec<String>) -> PyResult<Vec<(String, Bound<'py, PyBytes>)>> {
        let files = finished(py, None, |_| {
            let formats = formats.iter().map(|name| name.parse()).collect::<hertzchain::Result<Vec<Format>>>()?;
            let (mut files, pictures) =
                (self.0.files()?, if formats.is_empty() { Vec::new() } else { self.0.drawn()? });
            for (name, picture) in pictures {
                for format in &formats {
                    files.push((format.name(&name), picture.file(*format)?));
                }
            }
            Ok(files)
        })?;
        Ok(files.into_iter().map(|(name, bytes)| (name, PyBytes::new(py, &bytes))).collect())
    }
}

/// The study of a command line, the name of the program first. After an exception, such as that of
/// Ctrl-C, the report is of what was done before, if the study has such a report.
#[pyfunction]
pub(crate) fn study(
    py: Python<'_>,
    line: Vec<OsString>,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(Option<Report>, Option<PyErr>)> {
    let work = |watched: &crate::work::Watched| cli::study(line, &|share, _| watched.tell(share));
    match watched(py, progress.as_ref(), work)? {
        (report, Some(raised)) => Ok((report.ok().map(Report), Some(raised))),
        (report, None) => Ok((Some(Report(report.or_raise(py)?)), None)),
    }
}

/// The report of a branch of dark breathers in a file, which is followed no further.
#[pyfunction]
pub(crate) fn load_branch(py: Python<'_>, path: PathBuf) -> PyResult<Report> {
    finished(py, None, |_| branch_report(&analysed(Branch::load(&path)?, &Engine::threads(), &|_, _| ())?)).map(Report)
}

/// A direction for each multiplier of a dark breather in a file, a row each.
#[pyfunction]
pub(crate) fn modes<'py>(py: Python<'py>, npz: &[u8]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (directions, count) = finished(py, None, |_| {
        let (_, branch) =
            branch_from_archive::<Continuation>(&Archive::from_bytes("dark-breather.npz".as_ref(), npz)?)?;
        let spectrum = branch.orbits[0].spectrum(&branch.continuation.shooting)?;
        let count = spectrum.multipliers.len();
        Ok(((0..count).flat_map(|k| spectrum.direction(k)).collect(), count))
    })?;
    let directions: Vec<f64> = directions;
    let length = directions.len() / count;
    PyArray1::from_vec(py, directions).reshape([count, length])
}

/// The dimensionless tangent map of a chain over a time, from the state at the start of the scene.
#[pyfunction]
pub(crate) fn monodromy<'py>(py: Python<'py>, scene: &Scene, tol: f64) -> PyResult<Bound<'py, PyArray2<f64>>> {
    use hertzchain::integrators::collocation::StepControl;
    let scene = &scene.0;
    let start = scene.initial().as_slice();
    let span = (0.0, scene.end());
    let map = finished(py, None, |_| Ok(scene.chain().monodromy(start, span, StepControl::Tolerance(tol))?))?;
    // It comes column by column; the ledger of work, behind the state, is left out.
    let dim = 2 * scene.chain().layout().half();
    let state = map.chunks(start.len()).take(dim).flat_map(|column| &column[..dim]).copied().collect();
    PyArray1::from_vec(py, state).reshape([dim, dim])?.transpose()
}

/// The state at a time and its derivatives by numbers of a scene's chain, a column each, from those
/// of the initial state in `columns`; the last columns may be by the factor of that state.
#[pyfunction]
pub(crate) fn derivatives<'py>(
    py: Python<'py>,
    scene: &Scene,
    names: Vec<String>,
    columns: PyReadonlyArray2<'py, f64>,
    end: f64,
    tol: f64,
) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>)> {
    let scene = &scene.0;
    let (chain, y, span) = (scene.chain(), scene.initial().as_slice(), (scene.start_time(), end));
    if scene.units().is_some() {
        let rule = "of scenes and chains without units: give dimensionless numbers";
        return Err(Error::parameter("derivatives", "in SI units", rule)).or_raise(py);
    }
    if chain.boundary() == Boundary::StrainRing {
        return Err(Error::parameter("derivatives", "of strains", "of displacements: take the boundary ring"))
            .or_raise(py);
    }
    let site = |name: &str| name.strip_prefix("mass[")?.strip_suffix(']')?.parse().ok().map(Parameter::Mass);
    let named = |name: &String| match name.as_str() {
        "alpha" => Ok(Parameter::Alpha),
        "kappa" => Ok(Parameter::Kappa),
        "rho" => Ok(Parameter::Rho),
        name => site(name)
            .ok_or_else(|| Error::unknown("derivative", name, ["alpha", "kappa", "rho", "amplitude", "mass[0]"])),
    };
    // The factor of the initial state is no source.
    let by = names.iter().filter(|name| *name != "amplitude").map(named);
    let by = by.collect::<hertzchain::Result<Vec<_>>>().or_raise(py)?;
    let (half, k) = (chain.layout().half(), names.len());
    let mut columns = columns.as_array().iter().copied().collect::<Vec<_>>();
    // A bead that a drive moves is where its drive is.
    let moved = chain.details().into_iter().flat_map(|details| &details.drives);
    for drive in moved.filter(|drive| drive.kind == DriveKind::Displacement) {
        for row in [drive.site, half + drive.site] {
            columns[row * k..(row + 1) * k].fill(0.0);
        }
    }
    let end = finished(py, None, |_| Variations::flow_by(chain, y, span, (&columns, &by), tol))?;
    let state = PyArray1::from_slice(py, &end.state[..2 * half]);
    Ok((state, PyArray1::from_slice(py, &end.columns[..2 * half * k]).reshape([2 * half, k])?))
}
