//! Studies by their options, with their results as JSON, as `--json` prints them.

use crate::{
    scene::Scene,
    work::{Watched, finished},
};
use hertzchain::{
    Result,
    dps::Center,
    figures::Format,
    orbits::{Branch, DriveParameter, Formulation},
    output::Folder,
    report::Report,
    study::{
        self, BranchOptions, ChainParams, CompareOptions, Continue, Dark, DrivenSearch, DrivenWay, InSi, ModeWay, Plan,
        Ring, Study, compare, planned,
    },
    sweep::{Engine, Shard},
};
use numpy::{PyArray1, PyArray2, prelude::*};
use pyo3::{prelude::*, types::PyBytes};
use serde_json::Value;
use std::path::PathBuf;

/// A dark breather on a ring, as Python describes it.
#[derive(FromPyObject)]
pub(crate) struct Breather {
    center: String,
    omega_b: Option<f64>,
    sites: usize,
    alpha: f64,
    kappa: f64,
    rho: f64,
    c_x: f64,
    tol: f64,
}

impl Breather {
    fn ring(&self) -> Ring {
        let &Self { sites, alpha, kappa, rho, c_x, tol, .. } = self;
        let params = ChainParams { alpha, kappa, rho };
        Ring { sites, params, c_x, formulation: Formulation::HalfPeriod, tol }
    }
}

/// The symmetry with this name.
pub(crate) fn center(name: &str) -> Result<Center> {
    match name {
        "site" => Ok(Center::Site),
        "bond" => Ok(Center::Bond),
        _ => Err(hertzchain::Error::unknown("center", name, ["site", "bond"])),
    }
}

fn done(study: &impl Study, watched: &Watched) -> Result<Report> {
    study.begin()?(&Engine::threads(), &|share, _| watched.tell(share))
}

fn text(value: &Value) -> String {
    value.to_string()
}

/// The orbit of a dark breather, with its multipliers, and the direction of each of them, a row
/// each.
#[pyfunction]
pub(crate) fn dark(py: Python<'_>, breather: Breather) -> PyResult<(String, Bound<'_, PyArray2<f64>>)> {
    let (json, directions, count) = finished(py, None, |_| {
        let study = Dark { center: center(&breather.center)?, omega_b: breather.omega_b, ring: breather.ring() };
        let found = study.study(&study.breather()?)?;
        let spectrum = &found.study.spectrum;
        let count = spectrum.multipliers.len();
        let directions: Vec<f64> = (0..count).flat_map(|k| spectrum.direction(k)).collect();
        Ok((text(&found.report().json()), directions, count))
    })?;
    let length = directions.len() / count.max(1);
    Ok((json, PyArray1::from_vec(py, directions).reshape([count, length])?))
}

/// A branch: as JSON, and the bytes of `branch.npz`.
type BranchBytes<'py> = (String, Bound<'py, PyBytes>);

fn branch_bytes<'py>(py: Python<'py>, (json, npz): (String, Vec<u8>)) -> BranchBytes<'py> {
    (json, PyBytes::new(py, &npz))
}

fn of_branch(report: &Report) -> Result<(String, Vec<u8>)> {
    let json = text(&report.json());
    let npz = report.files()?.into_iter().find(|(name, _)| name == "branch.npz");
    Ok((json, npz.map(|(_, bytes)| bytes).unwrap_or_default()))
}

/// A branch of dark breathers in a parameter.
#[pyfunction]
#[pyo3(signature = (breather, *, parameter, from_, to, step, points, natural, weak, bound, progress))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn continue_branch<'py>(
    py: Python<'py>,
    breather: Breather,
    parameter: String,
    from_: f64,
    to: f64,
    step: Option<f64>,
    points: usize,
    natural: bool,
    weak: f64,
    bound: bool,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<BranchBytes<'py>> {
    let work = |watched: &Watched| {
        let study = Continue {
            center: center(&breather.center)?,
            omega_b: if parameter == "omega_b" { None } else { breather.omega_b },
            parameter,
            from: Some(from_),
            to: Some(to),
            step,
            points,
            natural,
            weak,
            bound,
            resume: None,
            ring: breather.ring(),
        };
        of_branch(&done(&study, watched)?)
    };
    finished(py, progress.as_ref(), work).map(|branch| branch_bytes(py, branch))
}

/// The branch in a file, with its multipliers.
#[pyfunction]
pub(crate) fn load_branch(py: Python<'_>, path: PathBuf) -> PyResult<BranchBytes<'_>> {
    let work = |watched: &Watched| {
        let branch = study::study(Branch::load(&path)?, &Engine::threads(), &|share, _| watched.tell(share))?;
        of_branch(&branch.report()?)
    };
    finished(py, None, work).map(|branch| branch_bytes(py, branch))
}

/// The orbit to which a driven scene leads, as JSON.
#[pyfunction]
#[pyo3(signature = (scene, *, turns, settle, si, progress))]
pub(crate) fn driven_orbit<'py>(
    py: Python<'py>,
    scene: &Scene,
    turns: u32,
    settle: u32,
    si: bool,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<String> {
    finished(py, progress.as_ref(), |watched| {
        let search = DrivenSearch { turns, settle };
        let orbit = study::driven_orbit(scene.0.clone(), &search, InSi { si }, &|share, _| watched.tell(share))?;
        Ok(text(&orbit.report().json()))
    })
}

/// The branch of that orbit in a parameter, and the one that crosses it, as JSON.
#[pyfunction]
#[pyo3(signature = (scene, *, turns, settle, parameter, to, step, points, switch, si, progress))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn driven_branch<'py>(
    py: Python<'py>,
    scene: &Scene,
    turns: u32,
    settle: u32,
    parameter: &str,
    to: f64,
    step: Option<f64>,
    points: usize,
    switch: Option<usize>,
    si: bool,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<String> {
    finished(py, progress.as_ref(), |watched| {
        let search = DrivenSearch { turns, settle };
        let vary = DriveParameter::named(parameter)?;
        let way = DrivenWay { vary, to: Some(to), step, branch: BranchOptions { max_points: points, switch } };
        let (scene, engine) = (scene.0.clone(), Engine::threads());
        let branch = study::driven_branch(scene, &search, &way, InSi { si }, &engine, &|share, _| watched.tell(share))?;
        Ok(text(&branch.report()?.json()))
    })
}

/// The branch of a normal mode of a scene, as JSON.
#[pyfunction]
#[pyo3(signature = (scene, *, mode, to, step, points, switch, si, progress))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn normal_mode<'py>(
    py: Python<'py>,
    scene: &Scene,
    mode: Option<usize>,
    to: f64,
    step: Option<f64>,
    points: usize,
    switch: Option<usize>,
    si: bool,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<String> {
    finished(py, progress.as_ref(), |watched| {
        let way = ModeWay { linear_mode: mode, to, step, branch: BranchOptions { max_points: points, switch } };
        let (scene, engine) = (scene.0.clone(), Engine::threads());
        let branch = study::follow_mode(scene, &way, InSi { si }, &engine, &|share, _| watched.tell(share))?;
        Ok(text(&branch.report().json()))
    })
}

/// Integrators on a scene: error against run time.
#[pyfunction]
pub(crate) fn compare_json<'py>(
    py: Python<'py>,
    scene: &Scene,
    integrators: Vec<String>,
    max_time: f64,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<String> {
    let options = CompareOptions { integrators, max_time };
    let work = |watched: &Watched| {
        let comparison = compare(&scene.0, &options, &|share, _| watched.tell(share))?;
        Ok(text(&comparison.report().json()))
    };
    finished(py, progress.as_ref(), work)
}

/// The tangent map of a chain over a time, from the state at the start of the scene.
#[pyfunction]
pub(crate) fn monodromy<'py>(py: Python<'py>, scene: &Scene, tol: f64) -> PyResult<Bound<'py, PyArray2<f64>>> {
    use hertzchain::integrators::collocation::Pace;
    let scene = &scene.0;
    let start = scene.initial().as_slice();
    let span = (0.0, scene.end());
    let map = finished(py, None, |_| Ok(scene.chain().monodromy(start, span, Pace::Tolerance(tol))?))?;
    // It comes column by column; the ledger of work, behind the state, is left out.
    let dim = 2 * scene.chain().layout().half();
    let state = map.chunks(start.len()).take(dim).flat_map(|column| &column[..dim]).copied().collect();
    PyArray1::from_vec(py, state).reshape([dim, dim])?.transpose()
}

/// Name, numbers and how many there are a point, of a column of a sweep.
type Column<'py> = (String, Bound<'py, PyArray1<f64>>, usize);

/// The sweep of a plan: JSON, columns, and the first failures. A shard has only words that say what
/// it has done.
#[pyfunction]
#[allow(clippy::type_complexity)]
pub(crate) fn sweep_plan<'py>(
    py: Python<'py>,
    path: PathBuf,
    out: Option<PathBuf>,
    formats: Vec<String>,
    shard: Option<&str>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<(String, Vec<Column<'py>>, Vec<(usize, String)>)> {
    let work = |watched: &Watched| {
        let plan = Plan::load(&path)?;
        let formats = formats.iter().map(|name| name.parse()).collect::<Result<Vec<Format>>>()?;
        let shard = shard.map(str::parse::<Shard>).transpose()?;
        let part = shard.map(|shard| shard.to_string());
        let folder = out.map(|out| Folder::own(out, part.as_deref())).transpose()?;
        let engine = folder.iter().fold(Engine::threads(), Engine::keeping);
        let engine = shard.into_iter().fold(engine, Engine::shard);
        let swept = planned(&plan, &engine, &|share, _| watched.tell(share));
        if let Some(part) = engine.part().filter(|part| part.kept == part.points) {
            return Ok((part.words(), Vec::new(), Vec::new()));
        }
        let study = swept?;
        let report = study.report()?;
        let json = text(&report.json());
        if let Some(folder) = &folder {
            for (name, bytes) in report.files()? {
                folder.write(&name, &bytes)?;
            }
            let pictures = if formats.is_empty() { Vec::new() } else { report.drawn()? };
            for (name, picture) in pictures {
                for format in &formats {
                    folder.write(&format.name(&name), &picture.file(*format)?)?;
                }
            }
        }
        Ok((json, study.columns, study.failed))
    };
    let (json, columns, failed) = finished(py, progress.as_ref(), work)?;
    let column = |column: study::NumberColumn| (column.name, PyArray1::from_vec(py, column.numbers), column.width);
    Ok((json, columns.into_iter().map(column).collect(), failed))
}
