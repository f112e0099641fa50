//! Scenes.

use crate::error::OrRaise;
use hertzchain::{
    Boundary, Chain, Error, Params,
    scene::{ChainSection, Initial, Record, SceneFile, Span},
};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

/// A scene that has been checked and can be run.
#[pyclass(frozen, module = "hertzchain._native")]
pub(crate) struct Scene(pub(crate) hertzchain::Scene);

/// The numbers of an array, copied where they are not in one piece.
fn numbers(array: Option<&PyReadonlyArray1<'_, f64>>) -> Vec<f64> {
    array.map(|array| array.as_array().to_vec()).unwrap_or_default()
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

    /// A scene from its numbers.
    #[staticmethod]
    #[allow(clippy::too_many_arguments)]
    fn of_chain(
        py: Python<'_>,
        sites: usize,
        alpha: f64,
        kappa: f64,
        rho: f64,
        boundary: &str,
        precompression: f64,
        state: Arrays<'_>,
        until: f64,
    ) -> PyResult<Self> {
        let boundary = boundary_named(py, boundary)?;
        let [u, v, u_dot, v_dot] = state.each_ref().map(|array| numbers(array.as_ref()));
        let file = SceneFile {
            name: "chain".to_owned(),
            summary: String::new(),
            chain: ChainSection { sites, alpha, kappa, rho, boundary, precompression },
            beads: None,
            bonds: None,
            drives: Vec::new(),
            units: None,
            initial: Initial::State { u, v, u_dot, v_dot },
            span: Span { periods: None, until: Some(until), period: None },
            record: Record::default(),
            method: None,
        };
        hertzchain::Scene::build(file).or_raise(py).map(Self)
    }

    /// The scene from another state.
    fn from_state(&self, py: Python<'_>, state: Arrays<'_>) -> PyResult<Self> {
        let [u, v, u_dot, v_dot] = state.each_ref().map(|array| numbers(array.as_ref()));
        self.0.from_state(u, v, u_dot, v_dot).or_raise(py).map(Self)
    }

    /// The scene with another end.
    fn until(&self, py: Python<'_>, end: f64) -> PyResult<Self> {
        self.0.clone().until(end).or_raise(py).map(Self)
    }

    fn to_toml(&self) -> String {
        self.0.file().to_toml()
    }

    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    /// Sites, exponent, spring constant, mass ratio, boundary, precompression.
    #[getter]
    fn chain(&self) -> (usize, f64, f64, f64, String, f64) {
        let chain = self.0.chain();
        let Params { alpha, kappa, rho } = chain.params();
        let boundary = serde_json::to_value(chain.boundary()).ok().and_then(|name| name.as_str().map(str::to_owned));
        (chain.sites(), alpha, kappa, rho, boundary.unwrap_or_default(), chain.precompression())
    }

    #[getter]
    fn period(&self) -> f64 {
        self.0.period()
    }

    #[getter]
    fn end(&self) -> f64 {
        self.0.end()
    }

    #[getter]
    fn samples(&self) -> usize {
        self.0.samples()
    }

    /// `u, v, u', v'` at the start; `v` and `v'` only if resonators move.
    fn initial<'py>(&self, py: Python<'py>) -> [Option<Bound<'py, PyArray1<f64>>>; 4] {
        let state = self.0.initial();
        let arrays = [Some(state.u()), state.v(), Some(state.u_dot()), state.v_dot()];
        arrays.map(|array| array.map(|array| PyArray1::from_slice(py, array)))
    }

    /// What a run computes and what it leaves out.
    fn plan(&self, events: bool) -> Vec<String> {
        self.0.plan(events)
    }
}

fn boundary_named(py: Python<'_>, name: &str) -> PyResult<Boundary> {
    let known = ["free", "fixed", "ring", "strain-ring"];
    serde_json::from_value(name.into()).map_err(|_| Error::unknown("boundary", name, known)).or_raise(py)
}

/// Refuses numbers of a chain that are outside their rules.
#[pyfunction]
pub(crate) fn check_chain(
    py: Python<'_>,
    sites: usize,
    params: [f64; 3],
    boundary: &str,
    precompression: f64,
) -> PyResult<()> {
    let (boundary, [alpha, kappa, rho]) = (boundary_named(py, boundary)?, params);
    let chain = Params::new(alpha, kappa, rho).and_then(|params| Chain::<f64>::new(params, boundary, sites));
    chain.and_then(|chain| chain.precompressed(precompression)).map(|_| ()).or_raise(py)
}

/// Names and summaries of the built-in scenes.
#[pyfunction]
pub(crate) fn scenes() -> Vec<(&'static str, String)> {
    hertzchain::Scene::list()
}
