//! Studies by their command lines, through `hertzchain::cli::study`; and what reports do not have.

use crate::{
    error::OrRaise,
    scene::{Scene, masses},
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
    study::{branch_from_archive, study as analysed},
    sweep::Engine,
};
use numpy::{PyArray1, PyArray2, prelude::*};
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
    finished(py, None, |_| analysed(Branch::load(&path)?, &Engine::threads(), &|_, _| ())?.report()).map(Report)
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

/// The tangent map of a chain over a time, from the state at the start of the scene.
#[pyfunction]
pub(crate) fn monodromy<'py>(py: Python<'py>, scene: &Scene, tol: f64) -> PyResult<Bound<'py, PyArray2<f64>>> {
    use hertzchain::integrators::collocation::StepControl;
    let scene = &scene.0;
    let start = scene.initial().as_slice();
    let span = (0.0, scene.end());
    let map = finished(py, None, |_| Ok(scene.chain().monodromy(start, span, StepControl::Tolerance(tol))?))?;
    // It comes column by column; the ledger of work, behind the state, is left out.
    let dim = 2 * scene.chain().layout().half();
    let mut state: Vec<f64> = map.chunks(start.len()).take(dim).flat_map(|column| &column[..dim]).copied().collect();
    if let Some(units) = scene.units() {
        // Velocities by displacements are per second, displacements by velocities in seconds.
        for (k, entry) in state.iter_mut().enumerate() {
            match (k / dim < dim / 2, k % dim < dim / 2) {
                (true, false) => *entry /= units.time_s,
                (false, true) => *entry *= units.time_s,
                _ => {}
            }
        }
    }
    PyArray1::from_vec(py, state).reshape([dim, dim])?.transpose()
}

/// The derivatives of the state at a time by numbers of a scene's chain, or by the factor of its
/// initial state, at fixed momenta of that state: positions and momenta, a row for each of `u, v`,
/// `pu, pv`.
#[pyfunction]
pub(crate) fn derivatives<'py>(
    py: Python<'py>,
    scene: &Scene,
    names: Vec<String>,
    end: f64,
    tol: f64,
) -> PyResult<Vec<Vec<Bound<'py, PyArray1<f64>>>>> {
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
    let known = ["alpha", "kappa", "rho", "amplitude"];
    let named = |name: &String| {
        let site = || name.strip_prefix("mass[")?.strip_suffix(']')?.parse().ok().map(Parameter::Mass);
        match name.as_str() {
            "alpha" => Ok(Some(Parameter::Alpha)),
            "kappa" => Ok(Some(Parameter::Kappa)),
            "rho" => Ok(Some(Parameter::Rho)),
            "amplitude" => Ok(None),
            _ => {
                site().map(Some).ok_or_else(|| Error::unknown("derivative", name, known.into_iter().chain(["mass[0]"])))
            }
        }
    };
    let by = names.iter().map(named).collect::<hertzchain::Result<Vec<_>>>().or_raise(py)?;
    // Those by the amplitude have no source, and come last.
    let mut order: Vec<usize> = (0..by.len()).collect();
    order.sort_by_key(|&j| by[j].is_none());
    let sources: Vec<Parameter> = order.iter().filter_map(|&j| by[j]).collect();
    let (n, half, [beads, resonators]) = (chain.sites(), chain.layout().half(), masses(chain));
    let (rows, k, rho) = (2 * half, by.len(), chain.params().rho);
    // Mass of an entry, and what share of it changes with the number.
    let mass = |i: usize| if i % half < n { beads[i % half] } else { resonators[i % half - n] };
    let change = |by: Option<Parameter>, i: usize| match by {
        Some(Parameter::Rho) if i % half >= n => 1.0 / rho,
        Some(Parameter::Mass(site)) if i % half % n == site => 1.0 / beads[site],
        _ => 0.0,
    };
    let moved = |i: usize| {
        i % half < n
            && chain.details().is_some_and(|details| {
                details.drives.iter().any(|drive| drive.kind == DriveKind::Displacement && drive.site == i % half)
            })
    };
    let mut columns = vec![0.0; rows * k];
    for (place, &j) in order.iter().enumerate() {
        for i in (0..rows).filter(|&i| !moved(i)) {
            let share = if i < half { 0.0 } else { -change(by[j], i) };
            columns[i * k + place] = y[i] * by[j].map_or(1.0, |_| share);
        }
    }
    let end = finished(py, None, |_| Variations::flow_by(chain, y, span, (&columns, &sources), tol))?;
    let column = |j: usize| {
        let place = order.iter().position(|&other| other == j).unwrap_or(0);
        let row = |i: usize| {
            let own = end.columns[i * k + place];
            if i < half { own } else { mass(i) * (own + change(by[j], i) * end.state[i]) }
        };
        (0..rows / n).map(|array| PyArray1::from_vec(py, (array * n..(array + 1) * n).map(row).collect())).collect()
    };
    Ok((0..k).map(column).collect())
}
