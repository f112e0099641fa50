//! The order of every method through contacts, and the modes that keep it.
//!
//! | symbol | meaning |
//! |---|---|
//! | `p` | order of a method on smooth problems |
//! | `alpha` | exponent of the contact force |
//! | `T` | end of the runs |
//!
//! A step that crosses the beginning or the end of a contact errs by `O(h^{alpha+1})` in the state
//! and by `O(h^alpha)` in its derivative by the initial state, the tangent, whatever `p` is.
//! Landing on the event leaves the force `(t - t_e)^alpha` just beside it: a smaller constant and
//! the same order, unless `alpha` is an integer. Contact-corrected splitting takes the error of an
//! event back: `min(4, alpha + 3, 2 alpha + 2)` in the state, which is 4 for its exponents, and one
//! less than the terms of events in the tangent.

mod report;

use crate::study::{Progress, Study, Work, fit_line, methods, options::options};
use crate::{
    chain::{Boundary, Chain, Field, Overlaps, Params, Site, State, max_norm},
    error::{Error, Result, refuse},
    named::named,
    report::{Report, WorkPrecision},
    run::{
        Run, Setting,
        method::{Contacts, Method, Split},
    },
    sweep::{Engine, Grid},
};
use hertzchain_integrators::{
    Dop853, Event, Regularised, Silent, Stepper,
    dop853::Options,
    drive,
    regularised::{Division, Itinerary, common_power, equal_steps},
    splitting::{Parts, tables},
};
use serde_json::json;

/// End of the runs.
const END: f64 = 12.0;
/// Spring constant and mass ratio.
const KAPPA: f64 = 1.0;
const RHO: f64 = 1.0 / 3.0;
/// Force evaluations on the levels of the ladder, over the whole run.
const EVALUATIONS: [f64; 8] = [480.0, 960.0, 1920.0, 3840.0, 7680.0, 15_360.0, 30_720.0, 61_440.0];
/// The same for corrected kicks, which reach the floor of the tangent with fewer evaluations than
/// other methods.
const CORRECTED_EVALUATIONS: [f64; 8] = [60.0, 120.0, 240.0, 480.0, 960.0, 1920.0, 3840.0, 7680.0];
/// Factors of the number of steps of a level. Its error is the root mean square over these runs, so
/// that a slope does not depend on where in a step events happen to lie. For corrected kicks it is
/// the median.
const NEIGHBOURS: [f64; 7] = [1.0, 1.015, 1.031, 1.046, 1.062, 1.079, 1.095];
/// Steps a leg, from event to event, on the levels of the regularised mode.
const STEPS_A_LEG: [u64; 11] = [2, 3, 4, 6, 8, 11, 16, 22, 32, 45, 64];
/// Steps a leg of the reference, and of the run from which its error is estimated.
const REFERENCE_STEPS: [u64; 2] = [120, 90];
/// Errors above this many times that of the reference are fitted.
const RESOLVED: f64 = 20.0;
/// Levels that a slope is fitted to: the finest, where the order has set in.
const LEVELS_FITTED: usize = 6;
/// Half the distance of initial states whose difference gives the tangent.
const TANGENT_STEP: f64 = 1e-5;

named! {
    /// How a method meets contacts.
    pub enum Mode {
        /// Steps across events.
        Plain = "plain",
        /// Steps end on events.
        Landed = "landed",
        /// Kicks sample the contact force, and their error at events is corrected.
        Corrected = "corrected",
        /// Steps start anew at events, in a variable in which the solution is smooth.
        Regularised = "regularised",
    }
}

named! {
    /// The quantity whose error is measured.
    pub enum Quantity {
        /// The state at the end.
        State = "state",
        /// Its derivative by the initial state, in one direction.
        Tangent = "tangent",
    }
}

/// Errors of one method over a ladder of steps.
#[derive(Clone, Debug)]
pub struct OrderRow {
    /// The method.
    pub method: Method,
    /// How it meets contacts.
    pub mode: Mode,
    /// The quantity whose errors these are.
    pub quantity: Quantity,
    /// The order it shows, if its errors lie on a line somewhere.
    pub slope: Option<f64>,
    /// The order that theory gives it.
    pub theory: f64,
    /// Largest error of a component at the end, coarse to fine; infinite where a run failed.
    pub errors: Vec<f64>,
    /// Steps of the run.
    pub steps: Vec<u64>,
}

/// The outcome of the study.
#[derive(Clone, Debug)]
pub struct OrderStudy {
    /// Exponent.
    pub alpha: f64,
    /// Number of beads.
    pub beads: usize,
    /// Exponent, spring constant and mass ratio.
    pub params: Params,
    /// End of the runs.
    pub end: f64,
    /// Power of the map of the regularised mode.
    pub q: u32,
    /// Onsets and releases of the reference run, in order of time.
    pub events: Vec<Event<f64>>,
    /// Estimated errors of the reference: of the state, and of the tangent.
    pub floor: (f64, f64),
    /// All rows.
    pub rows: Vec<OrderRow>,
}

/// The order that theory gives a method, of order `p` where nothing limits it.
///
/// `min(p, alpha + 1)` for the state and `min(p, alpha)` for the tangent when events are crossed;
/// the same when they are landed on, unless `alpha` is an integer and the force analytic on either
/// side; one more for discrete gradients, which average the force over a step; two more when kicks
/// are corrected, or `alpha + 1` if that is less; `p` when regularised.
pub fn theory(method: Method, alpha: f64, mode: Mode, quantity: Quantity) -> f64 {
    let p = f64::from(method.info().order);
    let lost = if quantity == Quantity::State { 0.0 } else { 1.0 };
    let limit = alpha + 1.0 - lost;
    match mode {
        _ if method == Method::Conserving => p.min(limit + 1.0),
        Mode::Regularised => p,
        Mode::Landed if alpha.fract() == 0.0 => p,
        // The next terms of an event are of order alpha + 3 and 2 alpha + 2.
        Mode::Corrected => p.min(limit + 2.0).min(limit + alpha + 1.0),
        Mode::Plain | Mode::Landed => p.min(limit),
    }
}

options! {
    /// The order study.
    pub struct OrderOptions {
        /// Exponent of the contact force; 1.5 for spheres.
        alpha: f64 = 1.5, "A", (0.5 to 10);
        /// Number of beads of the chain.
        beads: usize = 6, "N", (2 to 1000);
        /// Integrators, separated by commas, or all [default: all].
        ///
        /// Each is run in all modes that it has.
        integrators: Vec<String> = vec![], "A,B,..";
    }
}

impl OrderOptions {
    /// Methods and modes of the study, for the integrators that are asked for.
    fn cases(&self) -> Result<Vec<(Method, Mode)>> {
        self.within_ranges()?;
        let (mut cases, wanted) = (cases(self.alpha), methods(&self.integrators, Method::all)?);
        let all = wanted.len() > self.integrators.len();
        let missing = wanted.iter().find(|method| !all && !cases.iter().any(|(one, _)| one == *method));
        let rule = "the order study has splitting schemes and dop853, and corrected kicks for alpha from 1";
        refuse("integrators", missing.map(Method::name), rule)?;
        cases.retain(|(method, _)| wanted.contains(method));
        Ok(cases)
    }
}

impl Study for OrderOptions {
    const FILES: &'static str = "The pictures are order-state.png and order-tangent.png.";
    const STORE: &'static str = "order.store";

    fn outline() -> Option<Report> {
        let report = Report::new("order").table(report::orders(&[])).table(report::runs(&[]));
        let picture = |report: Report, name| report.picture_named(name, WorkPrecision::default());
        Some(["order-state", "order-tangent"].into_iter().fold(report, picture))
    }

    fn begin(&self) -> Result<Work<'_>> {
        self.cases()?;
        Ok(Box::new(|engine, progress| Ok(order(self, engine, progress)?.report())))
    }
}

/// Runs every method over its ladder on a chain of beads that fly at each other. `progress` is told
/// the share done.
///
/// # Errors
/// An option outside its rule, or a reference that cannot be computed.
pub fn order(options: &OrderOptions, engine: &Engine, progress: Progress<'_>) -> Result<OrderStudy> {
    let &OrderOptions { alpha, beads, .. } = options;
    let cases = options.cases()?;
    let problem = Problem::new(alpha, beads)?;
    let reference = problem.reference()?;
    let grid = Grid { store: OrderOptions::STORE, study: "order", settings: json!({"alpha": alpha, "beads": beads}) };
    let swept = engine.sweep(&grid, &cases, progress, |&case| Ok(problem.ladder(case, &reference)))?;
    let ladders = swept.all(&cases, |case| case.0.name())?;
    let rows = cases.iter().zip(ladders).flat_map(|(&case, ladder)| problem.rows(case, &ladder, &reference)).collect();
    Ok(OrderStudy {
        alpha,
        beads,
        params: Params { alpha, kappa: KAPPA, rho: RHO },
        end: END,
        q: common_power(&[alpha], 8),
        floor: reference.floor,
        rows,
        events: reference.events,
    })
}

/// The methods and the modes each can be run in, mode by mode.
fn cases(alpha: f64) -> Vec<(Method, Mode)> {
    let dop853 = Method::Dop853(Contacts::Crossed);
    let all = Method::all().into_iter().filter(|method| matches!(method, Method::Splitting(..)));
    let plain = all.chain([Method::Conserving, dop853]).map(|method| (method, Mode::Plain));
    // Either part of contact-corrected splitting alone, then both. They are for exponents from 1.
    let corrected = [
        (Method::TAKAHASHI_IMADA, Mode::Plain),
        (Method::Splitting(&tables::STRANG, Split::Linear), Mode::Corrected),
        (Method::CORRECTED, Mode::Corrected),
    ];
    let corrected = corrected.into_iter().filter(|_| alpha >= 1.0);
    plain.chain([(dop853, Mode::Landed)]).chain(corrected).chain([(dop853, Mode::Regularised)]).collect()
}

/// Errors of the state and of the tangent, none where a run failed, and steps.
type Errors = ([Option<f64>; 2], u64);

/// A chain with generic contacts, its initial state, and a direction in the space of those.
struct Problem {
    chain: Chain<f64>,
    alpha: f64,
    /// The initial state, and those a little ahead of it and behind it in the direction of the
    /// tangent.
    starts: [Vec<f64>; 3],
}

/// The reference run, with estimates of its errors.
struct Reference {
    events: Vec<Event<f64>>,
    /// Of the run from each start.
    itineraries: [Itinerary<f64>; 3],
    state: Vec<f64>,
    tangent: Vec<f64>,
    floor: (f64, f64),
}

/// The study's initial state: beads apart, flying at each other, with positions and velocities
/// without a pattern.
///
/// # Errors
/// None for a valid chain.
pub fn generic_state(chain: &Chain<f64>) -> Result<State<f64>> {
    let middle = 0.5 * (chain.sites() as f64 - 1.0);
    let noise = |k: usize| (0.710_550_39 * k as f64 + 0.092_516_4).fract() - 0.5;
    State::from_fn(chain, |n| {
        let x = n as f64 - middle;
        let u = (x + 0.3 * noise(2 * n)) / 7.0;
        Site { u, v: x / 7.0, u_dot: 0.6 * noise(2 * n + 1) - 0.2 * x, v_dot: 0.0 }
    })
}

impl Problem {
    fn new(alpha: f64, beads: usize) -> Result<Self> {
        let chain = Chain::new(Params::new(alpha, KAPPA, RHO)?, Boundary::Free, beads)?;
        let start = generic_state(&chain)?.as_slice().to_vec();
        let shifted = |size: f64| -> Vec<f64> {
            let direction = |i: usize| (2.399_963 * i as f64 + 1.0).sin();
            start.iter().enumerate().map(|(i, y)| y + size * direction(i)).collect()
        };
        let starts = [start.clone(), shifted(TANGENT_STEP), shifted(-TANGENT_STEP)];
        Ok(Self { chain, alpha, starts })
    }

    /// The events of a run with error control.
    fn events(&self, y0: &[f64]) -> Result<Vec<Event<f64>>> {
        let (field, overlaps) = (Field::new(self.chain.clone()), Overlaps::new(self.chain.clone()));
        let options = Options::new(1e-13);
        let powers = (self.alpha, common_power(&[self.alpha], 8));
        let mut run = Regularised::new(field, overlaps, powers, y0, (0.0, END), options)?;
        let mut events = Vec::new();
        while !run.done() {
            run.step()?;
            events.extend_from_slice(run.events());
        }
        events.sort_by(|x, y| x.t.total_cmp(&y.t));
        Ok(events)
    }

    /// The state at the end from start `k`, by steps from stop to stop, and their number.
    fn divided(&self, k: usize, division: Division<f64>, itinerary: &Itinerary<f64>) -> Result<(Vec<f64>, u64)> {
        let (field, overlaps) = (Field::new(self.chain.clone()), Overlaps::new(self.chain.clone()));
        Ok(equal_steps(field, &overlaps, &self.starts[k], (0.0, END), division, itinerary)?)
    }

    fn reference(&self) -> Result<Reference> {
        let [events, ahead, behind] = [0, 1, 2].map(|k| self.events(&self.starts[k]));
        let events = events?;
        let itineraries = [&events, &ahead?, &behind?].map(|events| Itinerary::new(events, 1e-9));
        let q = common_power(&[self.alpha], 8);
        let ends = |steps: u64| -> Result<[Vec<f64>; 2]> {
            let end = |k: usize| Ok::<_, Error>(self.divided(k, Division::Count { steps, q }, &itineraries[k])?.0);
            Ok([end(0)?, tangent(&end(1)?, &end(2)?)])
        };
        let [[state, tangent], coarse] = [ends(REFERENCE_STEPS[0])?, ends(REFERENCE_STEPS[1])?];
        let rounding = 4.0 * f64::EPSILON * max_norm(state.iter().copied());
        let floor =
            (distance(&state, &coarse[0]).max(rounding), distance(&tangent, &coarse[1]).max(rounding / TANGENT_STEP));
        Ok(Reference { events, itineraries, state, tangent, floor })
    }

    /// The state at the end of a run from start `k`, and its steps.
    fn end(&self, case: (Method, Mode), work: Level, reference: &Reference, k: usize) -> Result<(Vec<f64>, u64)> {
        let (start, span) = (&self.starts[k], (0.0, END));
        let steps = match work {
            Level::Divided(division) => return self.divided(k, division, &reference.itineraries[k]),
            Level::Steps(steps) => steps,
        };
        let method = match case {
            // Corrections without processing.
            (Method::Splitting(..), Mode::Corrected) => Method::Corrected(Parts::CORRECTED),
            (method, _) => method,
        };
        let run = Run::new(self.chain.clone(), State::rest(&self.chain)).until(END)?;
        let mut stepper: Box<dyn Stepper<f64>> = match method {
            Method::Dop853(_) => Box::new(Dop853::fixed(Field::new(self.chain.clone()), start, span, steps)?),
            _ => method.start(&run, start, span, Setting::Steps(steps))?,
        };
        let mut y = start.clone();
        drive(&mut *stepper, &mut Silent, &mut y)?;
        Ok((y, stepper.stats().steps))
    }

    /// Errors of the state and of the tangent, and steps; errors are infinite if a run fails.
    fn errors(&self, case: (Method, Mode), work: Level, reference: &Reference) -> ([f64; 2], u64) {
        match [0, 1, 2].map(|k| self.end(case, work, reference, k)) {
            [Ok((state, steps)), Ok((ahead, _)), Ok((behind, _))] => {
                ([distance(&state, &reference.state), distance(&tangent(&ahead, &behind), &reference.tangent)], steps)
            }
            _ => ([f64::INFINITY; 2], 0),
        }
    }

    /// Errors and steps of a method in a mode, coarse to fine.
    fn ladder(&self, (method, mode): (Method, Mode), reference: &Reference) -> Vec<Errors> {
        let level = |level: Vec<Level>| {
            let runs: Vec<_> = level.iter().map(|&work| self.errors((method, mode), work, reference)).collect();
            let error = |k: usize| {
                let errors: Vec<f64> = runs.iter().map(|(errors, _)| errors[k]).collect();
                let error = if mode == Mode::Corrected { median(errors) } else { root_mean_square(&errors) };
                error.is_finite().then_some(error)
            };
            ([error(0), error(1)], runs[0].1)
        };
        self.levels(method, mode).into_iter().map(level).collect()
    }

    /// The rows of a method in a mode: of the state and of the tangent.
    fn rows(&self, (method, mode): (Method, Mode), ladder: &[Errors], reference: &Reference) -> [OrderRow; 2] {
        [(Quantity::State, reference.floor.0), (Quantity::Tangent, reference.floor.1)].map(|(quantity, floor)| {
            let error = |(errors, _): &Errors| errors[quantity as usize].unwrap_or(f64::INFINITY);
            let errors = ladder.iter().map(error).collect();
            let steps = ladder.iter().map(|(_, steps)| *steps).collect();
            let theory = theory(method, self.alpha, mode, quantity);
            let row = OrderRow { method, mode, quantity, slope: None, theory, errors, steps };
            OrderRow { slope: slope(&row, floor), ..row }
        })
    }

    /// The ladder of a method in a mode; the runs of a level are averaged.
    fn levels(&self, method: Method, mode: Mode) -> Vec<Vec<Level>> {
        if mode == Mode::Regularised {
            let q = common_power(&[self.alpha], method.info().order);
            return STEPS_A_LEG.iter().map(|&steps| vec![Level::Divided(Division::Count { steps, q })]).collect();
        }
        let steps = |evaluations: f64, share: f64| (evaluations * share / method.info().stages as f64).round().max(1.0);
        let work = |steps: f64| match (method, mode) {
            (Method::Dop853(_), Mode::Landed) => Level::Divided(Division::Length(END / steps)),
            _ => Level::Steps(steps as u64),
        };
        let level = |level: f64| NEIGHBOURS.iter().map(|&share| work(steps(level, share))).collect();
        let ladder = if mode == Mode::Corrected { CORRECTED_EVALUATIONS } else { EVALUATIONS };
        ladder.iter().map(|&evaluations| level(evaluations)).collect()
    }
}

fn root_mean_square(errors: &[f64]) -> f64 {
    (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt()
}

/// The median of errors. Corrected kicks are no continuous function of the start: where an event
/// meets a kick they jump by the remaining error of the correction. A difference across a jump is
/// no derivative, and the median ignores it.
fn median(mut errors: Vec<f64>) -> f64 {
    errors.sort_by(f64::total_cmp);
    errors[errors.len() / 2]
}

/// The division of a run into steps.
#[derive(Clone, Copy)]
enum Level {
    /// This number of equal steps over the whole span.
    Steps(u64),
    /// Steps from event to event.
    Divided(Division<f64>),
}

/// The order that a row shows: the slope over its finest levels whose errors lie well above the
/// floor and below one, at least three and over at least a decade of errors.
fn slope(row: &OrderRow, floor: f64) -> Option<f64> {
    let resolved = |error: f64| error > RESOLVED * floor && error < 0.1;
    let points: Vec<(f64, f64)> = row
        .errors
        .iter()
        .zip(&row.steps)
        .filter(|(error, _)| resolved(**error))
        .map(|(error, &steps)| (-(steps as f64).log10(), error.log10()))
        .collect();
    let points = &points[points.len().saturating_sub(LEVELS_FITTED)..];
    let decades = points.first()?.1 - points.last()?.1;
    let (slope, _) = fit_line(points)?;
    (points.len() >= 3 && decades >= 1.0).then_some(slope)
}

fn tangent(ahead: &[f64], behind: &[f64]) -> Vec<f64> {
    ahead.iter().zip(behind).map(|(a, b)| (a - b) / (2.0 * TANGENT_STEP)).collect()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    max_norm(a.iter().zip(b).map(|(a, b)| a - b))
}
