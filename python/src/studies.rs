//! Studies by their options, with their results as JSON, as `--json` prints them.

use crate::{scene::Scene, work::finished};
use hertzchain::{
    Result,
    dps::Center,
    figures::Format,
    orbits::{Branch, DriveParameter, Formulation},
    output::Folder,
    report::Report,
    study::{
        BifurcationOptions, BranchOptions, ChainParams, CompareOptions, Continue, Dark, DrivenSearch, DrivenWay, InSi,
        ModeWay, NumberColumn, Plan, Ring, Study, compare, driven_branch, driven_orbit, follow_mode, planned,
        study as branch_study,
    },
    sweep::{Engine, Progress, Shard},
};
use numpy::{PyArray1, PyArray2, prelude::*};
use pyo3::{
    exceptions::PyValueError,
    prelude::*,
    types::{PyBytes, PyDict},
};
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

/// What a study does, once its options are read.
type Work = Box<dyn FnOnce(Progress<'_>) -> Result<Report> + Send>;

/// The study of this name of a scene, a dark breather or a file, with its options by keyword.
/// Returns its JSON and, of a branch of dark breathers, the bytes of `branch.npz`.
#[pyfunction]
#[pyo3(signature = (name, of, progress, **options))]
pub(crate) fn study<'py>(
    py: Python<'py>,
    name: &str,
    of: &Bound<'py, PyAny>,
    progress: Option<Bound<'py, PyAny>>,
    options: Option<Bound<'py, PyDict>>,
) -> PyResult<(String, Bound<'py, PyBytes>)> {
    let work = begun(name, of, &options.unwrap_or_else(|| PyDict::new(py)))?;
    let (json, npz) = finished(py, progress.as_ref(), |watched| {
        let report = work(&|share, _| watched.tell(share))?;
        let files = if ["dark-branch", "dark-file"].contains(&name) { report.files()? } else { Vec::new() };
        let npz = files.into_iter().find(|(name, _)| name == "branch.npz");
        Ok((text(&report.json()), npz.map(|(_, bytes)| bytes).unwrap_or_default()))
    })?;
    Ok((json, PyBytes::new(py, &npz)))
}

/// Reads the options of a study.
fn begun(name: &str, of: &Bound<'_, PyAny>, options: &Bound<'_, PyDict>) -> PyResult<Work> {
    macro_rules! given {
        ($key:literal) => {
            options.as_any().get_item($key)?.extract()?
        };
    }
    let scene = || PyResult::Ok(of.extract::<PyRef<'_, Scene>>()?.0.clone());
    let search = || PyResult::Ok(DrivenSearch { turns: given!("turns"), settle: given!("settle") });
    let branch = || {
        let default = BranchOptions::default();
        let (to, step, max_points): (_, _, Option<usize>) = (given!("to"), given!("step"), given!("max_points"));
        PyResult::Ok(BranchOptions { to, step, max_points: max_points.unwrap_or(default.max_points), ..default })
    };
    let more = || PyResult::Ok(BifurcationOptions { switch: given!("switch"), bifurcations: Some(true) });
    Ok(match name {
        "compare" => {
            let (scene, integrators, max_time) = (scene()?, given!("integrators"), given!("max_time"));
            Box::new(move |tell| Ok(compare(&scene, &CompareOptions { integrators, max_time }, tell)?.report()))
        }
        "driven-orbit" => {
            let (scene, search, si) = (scene()?, search()?, InSi { si: given!("si") });
            Box::new(move |tell| Ok(driven_orbit(scene, &search, si, tell)?.report()))
        }
        "driven-branch" => {
            let (scene, search, si, branch) = (scene()?, search()?, InSi { si: given!("si") }, branch()?);
            let (vary, more): (String, _) = (given!("vary"), more()?);
            Box::new(move |tell| {
                let way = DrivenWay { vary: DriveParameter::named(&vary)?, branch, more };
                driven_branch(scene, &search, &way, si, &Engine::threads(), tell)?.report()
            })
        }
        "normal-mode" => {
            let (scene, si) = (scene()?, InSi { si: given!("si") });
            let way = ModeWay { linear_mode: given!("mode"), branch: branch()?, more: more()? };
            Box::new(move |tell| follow_mode(scene, &way, si, &Engine::threads(), tell)?.report())
        }
        "dark-file" => {
            let path: PathBuf = of.extract()?;
            Box::new(move |tell| branch_study(Branch::load(&path)?, &Engine::threads(), tell)?.report())
        }
        "dark-branch" => {
            let (breather, vary): (Breather, String) = (of.extract()?, given!("vary"));
            let (from, natural, branch) = (given!("from_"), given!("natural"), branch()?);
            let (weak, bound) = (given!("weak"), given!("bound"));
            Box::new(move |tell| {
                let (center, ring) = (center(&breather.center)?, breather.ring());
                let omega_b = if vary == "omega_b" { None } else { breather.omega_b };
                let study = Continue {
                    center,
                    omega_b,
                    vary,
                    from,
                    branch,
                    bifurcations: Some(true),
                    natural,
                    weak,
                    bound,
                    ring,
                };
                study.begin()?(&Engine::threads(), tell)
            })
        }
        _ => return Err(PyValueError::new_err(format!("study = {name}: there is none of this name"))),
    })
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
    let work = |watched: &crate::work::Watched| {
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
    let column = |column: NumberColumn| (column.name, PyArray1::from_vec(py, column.numbers), column.width);
    Ok((json, columns.into_iter().map(column).collect(), failed))
}
