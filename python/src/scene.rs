//! Scenes.

use crate::error::OrRaise;
use hertzchain::{
    Boundary, Chain, Error, Params,
    chain::{Details, Term},
    scene::{ChainSection, Initial, Quantity, Record, SceneFile, Span},
};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::{
    prelude::*,
    types::{PyDict, PyList},
};
use std::collections::BTreeMap;

/// A scene that has been checked and can be run.
#[pyclass(frozen, module = "hertzchain._native")]
pub(crate) struct Scene(pub(crate) hertzchain::Scene);

/// The numbers of an array, copied where they are not in one piece.
fn numbers(array: Option<&PyReadonlyArray1<'_, f64>>) -> Vec<f64> {
    array.map(|array| array.as_array().to_vec()).unwrap_or_default()
}

/// The end of a scene that stands for a chain.
const FOREVER: f64 = 1e80;

/// The numbers of a chain: sites, exponent, spring constant, mass ratio, boundary, static overlap,
/// what differs from bead to bead as tables of a scene in TOML, and gravity with its tilt.
#[derive(FromPyObject)]
pub(crate) struct Numbers(usize, f64, f64, f64, String, f64, String, [f64; 2]);

impl Numbers {
    /// The file of a scene of this chain.
    fn file(&self, py: Python<'_>, initial: Initial, until: f64) -> PyResult<SceneFile> {
        let &Self(sites, alpha, kappa, rho, ref boundary, precompression, ref tables, [gravity, tilt]) = self;
        let boundary = boundary_named(py, boundary)?;
        let (gravity, tilt) = ((gravity != 0.0).then_some(gravity), (tilt != 90.0).then_some(tilt));
        let chain = ChainSection { sites, alpha, kappa, rho, boundary, precompression, gravity, tilt };
        // The chain of this text stands for any: only its tables are read.
        let text = format!(
            "chain = {{ sites = 1, alpha = 1.5, boundary = \"free\" }}\n\
             initial = {{ kind = \"state\" }}\nspan = {{ until = 1.0 }}\n{tables}"
        );
        let read = SceneFile::parse(&text, "chain").or_raise(py)?;
        // A chain without an end runs as long as its drives have values.
        let ends = read.drives.iter().filter_map(|drive| drive.times.as_ref()?.last().copied());
        let until = if until == FOREVER { ends.fold(until, f64::min) } else { until };
        let span = Span { periods: None, until: Some(until), period: None };
        let name = "chain".to_owned();
        Ok(SceneFile { name, summary: String::new(), chain, initial, span, record: Record::default(), ..read })
    }
}

/// Arrays `u, v, u', v'` of a state; one that is left out is zero.
pub(crate) type Arrays<'py> = [Option<PyReadonlyArray1<'py, f64>>; 4];

#[pymethods]
impl Scene {
    #[staticmethod]
    fn load(py: Python<'_>, name: &str, changes: Vec<String>) -> PyResult<Self> {
        hertzchain::Scene::load_with(name, &changes).or_raise(py).map(Self)
    }

    #[staticmethod]
    fn parse(py: Python<'_>, text: &str, name: &str, changes: Vec<String>) -> PyResult<Self> {
        hertzchain::Scene::parse_with(text, name, &changes).or_raise(py).map(Self)
    }

    /// A chain from a state up to a time.
    #[staticmethod]
    fn of_chain(py: Python<'_>, chain: Numbers, state: Arrays<'_>, until: f64) -> PyResult<Self> {
        let [u, v, u_dot, v_dot] = state.each_ref().map(|array| numbers(array.as_ref()));
        let file = chain.file(py, Initial::State { u, v, u_dot, v_dot }, until)?;
        hertzchain::Scene::build(file).or_raise(py).map(Self)
    }

    /// The scene from another state.
    fn from_state(&self, py: Python<'_>, state: Arrays<'_>) -> PyResult<Self> {
        let [u, v, u_dot, v_dot] = state.each_ref().map(|array| numbers(array.as_ref()));
        self.0.from_state(u, v, u_dot, v_dot).or_raise(py).map(Self)
    }

    /// A part of a longer run, from a state at one time to another time.
    fn part(&self, py: Python<'_>, start: f64, end: f64, state: Arrays<'_>) -> PyResult<Self> {
        let state = state.each_ref().map(|array| numbers(array.as_ref()));
        self.0.part([start, end], state).or_raise(py).map(Self)
    }

    /// The scene with another end.
    fn until(&self, py: Python<'_>, end: f64) -> PyResult<Self> {
        self.0.clone().until_in_file(end).or_raise(py).map(Self)
    }

    fn to_toml(&self) -> String {
        self.0.file().to_toml()
    }

    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    /// Sites, exponent, spring constant, mass ratio, boundary, precompression, gravity, tilt.
    #[getter]
    fn chain(&self) -> (usize, f64, f64, f64, String, f64, f64, f64) {
        let &ChainSection { sites, alpha, kappa, rho, boundary, precompression, gravity, tilt } = &self.0.file().chain;
        (sites, alpha, kappa, rho, boundary.to_string(), precompression, gravity.unwrap_or(0.0), tilt.unwrap_or(90.0))
    }

    /// What differs from bead to bead and from bond to bond, with one number for each; `None` for a
    /// chain without tables and for one in SI units.
    #[getter]
    fn tables<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let details = self.0.chain().details().filter(|_| self.0.units().is_none());
        details.map(|details| tables(py, details)).transpose()
    }

    /// The tables as the file of the scene has them, in JSON; infinity is `null`.
    #[getter]
    fn sections(&self) -> String {
        let SceneFile { beads, bonds, drives, units, .. } = self.0.file();
        serde_json::json!({"beads": beads, "bonds": bonds, "drive": drives, "units": units}).to_string()
    }

    /// Masses of beads and of resonators, zero where none moves; in the units of the scene, or
    /// dimensionless.
    fn masses<'py>(&self, py: Python<'py>, si: bool) -> [Bound<'py, PyArray1<f64>>; 2] {
        let (chain, unit) = (self.0.chain(), self.0.units().filter(|_| si).map_or(1.0, |units| units.mass_kg));
        [0, 1].map(|k| PyArray1::from_iter(py, (0..chain.sites()).map(|site| chain.masses(site)[k] * unit)))
    }

    /// What one of each quantity is in SI units, of a scene with `[units]`.
    #[getter]
    fn units(&self) -> Option<BTreeMap<String, f64>> {
        self.0.units().and_then(|units| serde_json::from_value(serde_json::to_value(units).ok()?).ok())
    }

    #[getter]
    fn period(&self) -> f64 {
        self.0.in_file(Quantity::Time, self.0.period())
    }

    #[getter]
    fn end(&self) -> f64 {
        self.0.in_file(Quantity::Time, self.0.end())
    }

    /// `u, v, u', v'` at the start, in the units of the scene; `v` and `v'` only if resonators
    /// move.
    fn initial<'py>(&self, py: Python<'py>) -> [Option<Bound<'py, PyArray1<f64>>>; 4] {
        let state = self.0.initial();
        let arrays = [Some(state.u()), state.v(), Some(state.u_dot()), state.v_dot()];
        let quantities = [Quantity::Length, Quantity::Length, Quantity::Velocity, Quantity::Velocity];
        let of = |(k, array): (usize, &[f64])| array.iter().map(|x| self.0.in_file(quantities[k], *x)).collect();
        [0, 1, 2, 3].map(|k| arrays[k].map(|array| PyArray1::from_vec(py, of((k, array)))))
    }

    /// What a run computes and what it leaves out.
    fn plan(&self, events: bool) -> Vec<String> {
        self.0.plan(events)
    }
}

fn boundary_named(py: Python<'_>, name: &str) -> PyResult<Boundary> {
    let known = Boundary::ALL.map(|boundary| boundary.to_string());
    serde_json::from_value(name.into())
        .map_err(|_| Error::unknown("boundary", name, known.iter().map(String::as_str)))
        .or_raise(py)
}

/// A table of the lists that are not empty.
fn table<'py>(py: Python<'py>, lists: &[(&str, &Vec<f64>)]) -> PyResult<Bound<'py, PyDict>> {
    let table = PyDict::new(py);
    for (key, list) in lists.iter().filter(|(_, list)| !list.is_empty()) {
        table.set_item(key, PyArray1::from_slice(py, list))?;
    }
    Ok(table)
}

/// The tables of beads and bonds that say the same as details.
fn tables<'py>(py: Python<'py>, details: &Details) -> PyResult<Bound<'py, PyDict>> {
    let [beads, bonds] = details.lists();
    let losses = details.dissipation.iter().map(|loss| (loss.kind.name(), &loss.strength));
    let beads = table(py, &beads)?;
    let bonds = table(py, &bonds.into_iter().chain(losses).collect::<Vec<_>>())?;
    let numbers = [("beta", details.beta), ("rate_power", details.rate_power.unwrap_or(0.0)), ("decay", details.decay)];
    for (key, number) in numbers.into_iter().filter(|one| one.1 != 0.0) {
        bonds.set_item(key, number)?;
    }
    if details.pull {
        bonds.set_item("pull", true)?;
    }
    if !details.terms.is_empty() {
        let terms = PyList::empty(py);
        for Term { contact, alpha } in &details.terms {
            let term = table(py, &[("contact", contact)])?;
            term.set_item("alpha", alpha)?;
            terms.append(term)?;
        }
        bonds.set_item("terms", terms)?;
    }
    if let Some(rows) = &details.table {
        let [overlap, force] = [rows.overlap(), rows.force()].map(<[f64]>::to_vec);
        bonds.set_item("table", table(py, &[("overlap", &overlap), ("force", &force)])?)?;
    }
    let all = PyDict::new(py);
    all.set_item("beads", beads)?;
    all.set_item("bonds", bonds)?;
    Ok(all)
}

/// Refuses numbers of a chain that are outside their rules.
#[pyfunction]
pub(crate) fn check_chain(py: Python<'_>, chain: Numbers) -> PyResult<()> {
    let &Numbers(sites, alpha, kappa, rho, ref boundary, precompression, ref tables, weight) = &chain;
    if tables.is_empty() && weight == [0.0, 90.0] {
        let boundary = boundary_named(py, boundary)?;
        let chain = Params::new(alpha, kappa, rho).and_then(|params| Chain::<f64>::new(params, boundary, sites));
        return chain.and_then(|chain| chain.precompressed(precompression)).map(|_| ()).or_raise(py);
    }
    // At rest, and long enough for every drive.
    let rest = Initial::State { u: Vec::new(), v: Vec::new(), u_dot: Vec::new(), v_dot: Vec::new() };
    hertzchain::Scene::build(chain.file(py, rest, FOREVER)?).map(|_| ()).or_raise(py)
}

/// Names and summaries of the built-in scenes.
#[pyfunction]
pub(crate) fn scenes() -> Vec<(&'static str, String)> {
    hertzchain::Scene::list()
}
