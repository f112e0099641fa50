//! Closed forms and modulation theory.

use crate::{error::OrRaise, scene::Scene, work::finished};
use hertzchain::{
    Params, breathers,
    chain::Site,
    dps::{Averages, Center, Constraint, Dps, Ends, Form, Layout},
    integrators::{Dop853, Tolerance, dop853::Options},
    run::state_at,
    waves::{self, Shape, Size},
};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, prelude::*};
use pyo3::prelude::*;

/// `u, v, u', v'` of sites in that order, a row each.
fn table(py: Python<'_>, sites: impl Iterator<Item = Site<f64>>) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let rows: Vec<f64> = sites.flat_map(|site| [site.u, site.v, site.u_dot, site.v_dot]).collect();
    let count = rows.len() / 4;
    PyArray1::from_vec(py, rows).reshape([count, 4])
}

fn params(py: Python<'_>, [alpha, kappa, rho]: [f64; 3]) -> PyResult<Params> {
    Params::new(alpha, kappa, rho).or_raise(py)
}

/// The first-order travelling wave.
#[pyclass(frozen, module = "hertzchain._native")]
pub(crate) struct Wave(waves::TravellingWave);

#[pymethods]
impl Wave {
    #[new]
    fn new(
        py: Python<'_>,
        chain: [f64; 3],
        shape: [f64; 4],
        epsilon: Option<f64>,
        detuning: Option<f64>,
    ) -> PyResult<Self> {
        let [q, a, b, phi] = shape;
        let size = match (epsilon, detuning) {
            (Some(epsilon), None) => Ok(Size::Epsilon(epsilon)),
            (None, Some(detuning)) => Ok(Size::Detuning(detuning)),
            _ => Err(hertzchain::Error::parameter(
                "epsilon",
                hertzchain::error::NOTHING,
                "give one of epsilon and detuning",
            )),
        };
        let size = size.or_raise(py)?;
        waves::TravellingWave::new(params(py, chain)?, Shape { q, a, b, phi }, size).or_raise(py).map(Self)
    }

    #[getter]
    fn omega_tw(&self) -> f64 {
        self.0.omega_tw()
    }

    #[getter]
    fn epsilon(&self) -> f64 {
        self.0.epsilon()
    }

    /// Strains and their rates at a time.
    fn sites<'py>(&self, py: Python<'py>, sites: usize, t: f64) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(py, (0..sites).map(|n| self.0.site(n, t)))
    }
}

/// The wave of a scene.
#[pyfunction]
pub(crate) fn wave_of(py: Python<'_>, scene: &Scene) -> PyResult<Wave> {
    scene.0.wave().or_raise(py).map(|wave| Wave(*wave))
}

/// The long-lived bright breather.
#[pyclass(frozen, module = "hertzchain._native")]
pub(crate) struct Bright(breathers::BrightBreather);

#[pymethods]
impl Bright {
    #[new]
    fn new(py: Python<'_>, chain: [f64; 3], about: &str, epsilon: f64, sites: usize) -> PyResult<Self> {
        let about = match about {
            "site" => Center::Site,
            "bond" => Center::Bond,
            _ => return Err(hertzchain::Error::unknown("center", about, ["site", "bond"])).or_raise(py),
        };
        breathers::BrightBreather::new(params(py, chain)?, about, epsilon, sites).or_raise(py).map(Self)
    }

    #[getter]
    fn omega_b(&self) -> f64 {
        self.0.omega_b()
    }

    #[getter]
    fn period(&self) -> f64 {
        self.0.period()
    }

    #[getter]
    fn horizon(&self) -> f64 {
        self.0.horizon()
    }

    fn sites<'py>(&self, py: Python<'py>, t: f64) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(py, (0..self.0.sites()).map(|n| self.0.site(n, t)))
    }
}

/// `g_alpha` and `h_alpha` at pairs `(b, r)`.
#[pyfunction]
pub(crate) fn averages<'py>(
    py: Python<'py>,
    alpha: f64,
    kappa: f64,
    b: PyReadonlyArray1<'py, f64>,
    r: PyReadonlyArray1<'py, f64>,
) -> PyResult<[Bound<'py, PyArray1<f64>>; 2]> {
    let averages = Averages::new(alpha, kappa).or_raise(py)?;
    let pairs = b.as_array().into_iter().zip(r.as_array());
    let values: hertzchain::Result<Vec<_>> = pairs.map(|(&b, &r)| averages.checked(b, r)).collect();
    let values = values.or_raise(py)?;
    let column = |of: fn(&hertzchain::dps::Values) -> f64| PyArray1::from_vec(py, values.iter().map(of).collect());
    Ok([column(|values| values.g), column(|values| values.h)])
}

/// The flow of a modulation equation: the `M` complex amplitudes, as real and imaginary parts in
/// one row, at the given slow times.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub(crate) fn flow<'py>(
    py: Python<'py>,
    chain: [f64; 3],
    start: PyReadonlyArray1<'py, f64>,
    times: PyReadonlyArray1<'py, f64>,
    force: Option<f64>,
    mean_strain: Option<f64>,
    ring: bool,
    strains: bool,
    tol: f64,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let refused = |name, value: f64, rule| Err(hertzchain::Error::parameter(name, value, rule)).or_raise(py);
    let constraint = match (force, mean_strain) {
        (Some(force), None) => Constraint::Force(force),
        (None, Some(mean)) => Constraint::MeanStrain(mean),
        _ => return refused("force", f64::NAN, "give one of force and mean_strain"),
    };
    let (start, times) = (start.as_array().to_vec(), times.as_array().to_vec());
    let ends = if ring { Ends::Ring } else { Ends::Free };
    let form = if strains { Form::Strains } else { Form::Displacements };
    let sites = start.len() / 2 + usize::from(strains && !ring);
    let field = Dps::generalised(params(py, chain)?, constraint, Layout { sites, ends, form }).or_raise(py)?;
    if let Some(&wrong) = start.iter().find(|number| !number.is_finite()) {
        return refused("start", wrong, "amplitudes are finite");
    }
    let ascending = times.first().is_none_or(|&first| first >= 0.0) && times.is_sorted();
    let (true, Some(&end)) = (ascending, times.last().filter(|end| end.is_finite())) else {
        return refused("times", times.len() as f64, "one time at least, from 0 on and in ascending order");
    };
    let dim = start.len();
    let rows = finished(py, None, |_| {
        let tol = Tolerance::CROSSED.check(tol)?;
        let mut rows = Vec::with_capacity(times.len() * dim);
        let mut row = start.clone();
        // Amplitudes have no unit: A(t) and c A(t c^(1-alpha)) are found with the same digits.
        let size = start.iter().fold(0.0, |size: f64, a| size.max(a.abs()));
        let options = Options { atol: if size > 0.0 { tol * size } else { tol }, ..Options::new(tol) };
        let mut run = (end > 0.0).then(|| Dop853::new(field, &start, (0.0, end), options)).transpose()?;
        for &t in &times {
            if let Some(run) = run.as_mut() {
                row = state_at(run, t)?;
            }
            rows.extend_from_slice(&row);
        }
        Ok(rows)
    })?;
    PyArray1::from_vec(py, rows).reshape([times.len(), dim])
}
