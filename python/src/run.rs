//! Runs: states at the sample times go straight into the arrays that Python gets.

use crate::{
    error::OrRaise,
    scene::Scene,
    work::{Watched, brief, watched},
};
use hertzchain::{
    Run, Setting, Trajectory,
    chain::{Contact, Energy, Layout},
    cli::in_python,
    run::Records,
    scene::{Quantity, Units},
    study::{
        Condition, MethodChoice, MethodRequest, ResultUnits, contact_in_si, in_units, state_in_si, with_conditions,
    },
    sweep::start_all,
};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, prelude::*};
use pyo3::{prelude::*, types::PyDict};
use std::sync::{
    Arc, Mutex, PoisonError,
    atomic::{AtomicUsize, Ordering},
};

/// Steps times sites of a run that takes less than a millisecond.
const SHORT: u64 = 10_000;

/// The exception that a function of Python has thrown; once there is one, no other is called.
#[derive(Clone, Default)]
struct Thrown(Arc<Mutex<Option<PyErr>>>);

impl Thrown {
    /// The value of a call, unless it or an earlier one has thrown.
    fn call<T>(&self, function: impl FnOnce(Python<'_>) -> PyResult<T>) -> Option<T> {
        let mut thrown = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if thrown.is_some() {
            return None;
        }
        Python::attach(function).map_err(|error| *thrown = Some(error)).ok()
    }

    fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// Rows of states, array by array: `u`, `v` and their rates; `u` and its rate if no resonator moves.
struct Rows {
    layout: Layout,
    /// Whether states are kept.
    states: bool,
    t: Vec<f64>,
    arrays: Vec<Vec<f64>>,
}

impl Rows {
    /// Room for states at some times.
    fn new(layout: Layout, times: usize, states: bool) -> Self {
        let (parts, numbers) = (2 * layout.half() / layout.sites(), if states { times * layout.sites() } else { 0 });
        let arrays = (0..parts).map(|_| Vec::with_capacity(numbers)).collect();
        Self { layout, states, t: Vec::with_capacity(times), arrays }
    }

    /// Takes a sample, and hands it on in the units of the result.
    fn take(&mut self, t: f64, y: &[f64], units: Option<&Units>, then: &mut dyn FnMut(f64, &[f64])) {
        let converted = units.map(|units| {
            let mut y = y.to_vec();
            state_in_si(&mut y, self.layout, units);
            (t * units.time_s, y)
        });
        let (t, y) = converted.as_ref().map_or((t, y), |(t, y)| (*t, &y[..]));
        self.t.push(t);
        if self.states {
            self.add(y);
        }
        then(t, y);
    }

    fn add(&mut self, y: &[f64]) {
        for (array, part) in self.arrays.iter_mut().zip(y.chunks(self.layout.sites())) {
            array.extend_from_slice(part);
        }
    }

    /// The arrays for Python, `rows x sites`.
    fn arrays(self, py: Python<'_>, rows: usize) -> PyResult<Vec<Bound<'_, PyArray2<f64>>>> {
        let sites = self.layout.sites();
        self.arrays.into_iter().map(|values| PyArray1::from_vec(py, values).reshape([rows, sites])).collect()
    }
}

/// Runs a scene. The result is what was recorded, and the exception that stopped the run, if one
/// did.
#[pyfunction]
#[pyo3(signature = (
    scene, *, method, tol, step, steps_per_period, times, states, events, crossings, stop, dimensionless, progress,
    seen, told, crossed
))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn run<'py>(
    py: Python<'py>,
    scene: &Scene,
    method: Option<String>,
    tol: Option<f64>,
    step: Option<f64>,
    steps_per_period: Option<f64>,
    times: Option<PyReadonlyArray1<'py, f64>>,
    states: bool,
    events: bool,
    crossings: Vec<String>,
    stop: Vec<String>,
    dimensionless: bool,
    progress: Option<Bound<'py, PyAny>>,
    seen: Option<Py<PyAny>>,
    told: Option<Py<PyAny>>,
    crossed: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyDict>, Option<PyErr>)> {
    let scene = &scene.0;
    let asked = MethodRequest { integrator: method, tol, step, steps_per_period, ..MethodRequest::default() };
    let Prepared { how, run, units, mut rows } = prepared(py, scene, &asked, times.as_ref(), (states, dimensionless))?;
    let run = if events { run.contacts() } else { run };
    let conditions = crossings.iter().map(|text| (text, false)).chain(stop.iter().map(|text| (text, true)));
    let conditions: hertzchain::Result<Vec<_>> =
        conditions.map(|(text, ends)| Condition::read(text, scene, 0, ends)).collect();
    let conditions = conditions.or_raise(py)?;
    conditions.iter().try_for_each(|condition| condition.found_by(&how)).or_raise(py)?;
    let (start, end, layout) = (scene.start_time(), scene.end(), scene.chain().layout());
    let work = |watched: &Watched| {
        let thrown = Thrown::default();
        let call = |function: &Option<Py<PyAny>>, (t, numbers): (f64, &[f64])| {
            let Some(function) = function else { return };
            let called = thrown.call(|py| function.call1(py, (t, PyArray1::from_slice(py, numbers))).map(|_| ()));
            if called.is_none() {
                watched.ask();
            }
        };
        let also = thrown.clone();
        let run = with_conditions(run, &conditions, move |event, y| {
            let Some(function) = &crossed else { return false };
            let (mut t, mut y) = (event.t, y.to_vec());
            if let Some(units) = units {
                t *= units.time_s;
                state_in_si(&mut y, layout, &units);
            }
            let (index, rising) = (event.index, event.rising);
            let called = also.call(|py| {
                let state = PyArray1::from_slice(py, &y[..2 * layout.half()]);
                function.call1(py, (t, index, rising, state))?.is_truthy(py)
            });
            called.unwrap_or(true)
        });
        let mut seen = |t: f64, y: &[f64]| {
            watched.tell((t - start) / (end - start));
            rows.take(t, y, units.as_ref(), &mut |t, y| call(&seen, (t, &y[..2 * layout.half()])));
        };
        let mut told = |contact: &Contact| {
            let contact = units.map_or(*contact, |units| contact_in_si(contact, &units));
            call(&told, (contact.release.unwrap_or(f64::NAN), &contact.numbers()));
        };
        let outcome = how.observe(run, &mut seen, &mut told);
        (outcome, thrown.take(), rows)
    };
    let short = matches!(how, MethodChoice::Integrated(_, Setting::Steps(steps), ..) if steps * scene.chain().sites() as u64 <= SHORT);
    let ((outcome, thrown, rows), raised) =
        if short { (brief(py, work)?, None) } else { watched(py, progress.as_ref(), work)? };
    let (result, raised) = (record(py, outcome.or_raise(py)?, rows, (scene, &how, units))?, thrown.or(raised));
    if raised.is_some() {
        // It was no condition that has ended the run.
        result.set_item("ended_by", py.None())?;
    }
    Ok((result, raised))
}

/// A run, how it is computed, the units of its results, and room for these.
struct Prepared {
    how: MethodChoice,
    run: Run,
    units: Option<Units>,
    rows: Rows,
}

fn prepared(
    py: Python<'_>,
    scene: &hertzchain::Scene,
    asked: &MethodRequest,
    times: Option<&PyReadonlyArray1<'_, f64>>,
    (states, dimensionless): (bool, bool),
) -> PyResult<Prepared> {
    let how = MethodChoice::new(asked, scene).or_raise(py)?;
    let run = scene.run().records(Records::Energy);
    let (run, count) = match times {
        Some(times) => {
            // The end in the units of the scene is that of the run, whatever the rounding.
            let (end, own) = (scene.end(), scene.in_file(Quantity::Time, scene.end()));
            let of = |t: &f64| if *t == own { end } else { scene.of_file(Quantity::Time, *t) };
            let times: Vec<f64> = times.as_array().iter().map(of).collect();
            (run.samples_at(&times).or_raise(py)?, times.len())
        }
        None => (run, scene.samples() + 1),
    };
    let units = ResultUnits { dimensionless }.of(scene);
    let rows = Rows::new(scene.chain().layout(), count, states);
    Ok(Prepared { how, run, units, rows })
}

/// Runs scenes, each as by [`run`] with the same bits, on all cores; those that are alike and by a
/// splitting with equal steps are made side by side, see [`start_all`]. The result is
/// what was recorded of each, and the exception that stopped them, if one did.
#[pyfunction]
#[pyo3(signature = (scenes, *, method, tol, step, steps_per_period, times, states, dimensionless, progress))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn run_many<'py>(
    py: Python<'py>,
    scenes: Vec<PyRef<'py, Scene>>,
    method: Option<String>,
    tol: Option<f64>,
    step: Option<f64>,
    steps_per_period: Option<f64>,
    times: Option<PyReadonlyArray1<'py, f64>>,
    states: bool,
    dimensionless: bool,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<(Vec<Bound<'py, PyDict>>, Option<PyErr>)> {
    let asked = MethodRequest { integrator: method, tol, step, steps_per_period, ..MethodRequest::default() };
    let (mut runs, mut closed, mut rows, mut hows, mut total) = (Vec::new(), Vec::new(), Vec::new(), Vec::new(), 0);
    for (k, scene) in scenes.iter().enumerate() {
        let Prepared { how, run, units, rows: room } =
            prepared(py, &scene.0, &asked, times.as_ref(), (states, dimensionless))?;
        match how {
            MethodChoice::Integrated(method, setting, ..) => runs.push((k, run.method(method).setting(setting))),
            MethodChoice::ClosedForm(_) => closed.push((k, run)),
        }
        total += room.t.capacity();
        rows.push(Mutex::new(room));
        hows.push((how, units));
    }
    let (numbers, runs): (Vec<usize>, Vec<Run>) = runs.into_iter().unzip();
    let done = AtomicUsize::new(0);
    let work = |watched: &Watched| {
        let take = |k: usize, t: f64, y: &[f64]| {
            watched.tell(done.fetch_add(1, Ordering::Relaxed) as f64 / total as f64);
            let mut rows = rows[k].lock().unwrap_or_else(PoisonError::into_inner);
            rows.take(t, y, hows[k].1.as_ref(), &mut |_, _| ());
        };
        let ends = start_all(&runs, &|j, t, y| take(numbers[j], t, y));
        // Exact solutions are evaluated.
        let closed =
            closed.into_iter().map(|(k, run)| (k, hows[k].0.observe(run, &mut |t, y| take(k, t, y), &mut |_| ())));
        let mut ends: Vec<_> = numbers.iter().copied().zip(ends).chain(closed).collect();
        ends.sort_by_key(|(k, _)| *k);
        ends
    };
    let (ends, raised) = watched(py, progress.as_ref(), work)?;
    let rows = rows.into_iter().map(|rows| rows.into_inner().unwrap_or_else(PoisonError::into_inner));
    let records =
        ends.into_iter().zip(rows).zip(hows.iter().zip(&scenes)).map(|(((_, end), rows), ((how, units), scene))| {
            record(py, end.or_raise(py)?, rows, (&scene.0, how, *units))
        });
    Ok((records.collect::<PyResult<_>>()?, raised))
}

fn record<'py>(
    py: Python<'py>,
    outcome: Trajectory,
    mut rows: Rows,
    (scene, how, units): (&hertzchain::Scene, &MethodChoice, Option<Units>),
) -> PyResult<Bound<'py, PyDict>> {
    let short = outcome.failure.is_none() && outcome.t < scene.end();
    let outcome = in_units(outcome, rows.layout, units.as_ref());
    let (result, mut warnings) = (PyDict::new(py), scene.doubts());
    let (name, setting) = how.words();
    result.set_item("integrator", name)?;
    result.set_item("setting", setting)?;
    result.set_item("reason", how.reason().map(in_python))?;
    let kinds = |energy: Energy<f64>| [energy.beads, energy.resonators, energy.springs, energy.contacts];
    let energies: Option<Vec<[f64; 4]>> = outcome.samples.iter().map(|sample| sample.energy.map(kinds)).collect();
    if let Some(energies) = energies {
        let count = energies.len();
        result.set_item("energies", PyArray1::from_vec(py, energies.into_flattened()).reshape([count, 4])?)?;
    }
    if let Some(contacts) = &outcome.contacts {
        let numbers: Vec<f64> = contacts.iter().flat_map(Contact::numbers).collect();
        let shape = [contacts.len(), Contact::NUMBERS];
        result.set_item("contacts", PyArray1::from_vec(py, numbers).reshape(shape)?)?;
    }
    let crossings: Vec<_> = outcome.crossings.iter().map(|one| (one.index, one.t, one.rising)).collect();
    result.set_item("ended_by", crossings.last().filter(|_| short).map(|one| one.0))?;
    result.set_item("crossings", crossings)?;
    let stats = outcome.stats;
    result.set_item("steps", stats.steps)?;
    result.set_item("rejected", stats.rejected)?;
    result.set_item("force_evaluations", stats.force_evaluations)?;
    result.set_item("wall_s", outcome.wall.as_secs_f64())?;
    result.set_item("energy_error", outcome.energy_error)?;
    warnings.extend(outcome.warnings.iter().map(|warning| in_python(&warning.to_string())));
    result.set_item("warnings", warnings)?;
    result.set_item("failure", outcome.failure.map(|failure| in_python(&failure.to_string())))?;
    result.set_item("t_end", outcome.t)?;
    if let Some(ledger) = rows.layout.ledger(&outcome.state) {
        let dissipated = [ledger.drag, ledger.dashpots, ledger.contacts, ledger.dissipated()];
        result.set_item("dissipated", dissipated)?;
        result.set_item("driven", ledger.driven)?;
    }
    let count = rows.t.len();
    let mut last = Rows::new(rows.layout, 1, true);
    last.add(&outcome.state);
    result.set_item("end", last.arrays(py, 1)?)?;
    result.set_item("t", PyArray1::from_vec(py, std::mem::take(&mut rows.t)))?;
    if rows.states {
        result.set_item("states", rows.arrays(py, count)?)?;
    }
    Ok(result)
}
