//! The stepper of a method for a run.

use super::{
    Method, Run, Setting,
    method::{Contacts, NO_TOLERANCE, Split},
    tolerance,
    within::{AnyStepper, within},
};
use crate::{
    chain::{
        Chain, CorrectedSplit, Field, HeterogeneousChain, KineticFlow, LinearFlow, Overlaps, SitewiseBonds,
        SitewiseFlow,
    },
    error::{Error, Result},
    parts::Parted,
};
use hertzchain_integrators::{
    Collocation, Dop853, Regularised, Scheme, SplitFlow, Splitting,
    collocation::{ContactChain, ContactStepper, StepControl},
    conserving::DiscreteGradient,
    dop853::Options,
    splitting::{self, Corrected, First, corrected::BondFlow},
};

/// The stepper of a method that can log its contacts.
type LoggingStepper = Box<dyn ContactStepper + Send>;

impl Run {
    /// The stepper of the method, for callers that take the steps themselves.
    ///
    /// # Errors
    /// No end; a state of another chain; a setting of the wrong kind or outside the range that the
    /// method accepts.
    pub fn stepper(&self) -> Result<AnyStepper> {
        let (span, (method, setting)) = (self.span()?, self.choice()?);
        method.start(self, self.initial().as_slice(), span, setting)
    }
}

impl Method {
    /// The stepper for a leg of a run: from the state `y` at time `span.0` to time `span.1`. The
    /// setting is that of the leg.
    ///
    /// # Errors
    /// A setting of the wrong kind or outside the range that the method accepts; a chain that it
    /// cannot run.
    pub fn start(&self, run: &Run, y: &[f64], span: (f64, f64), setting: Setting) -> Result<AnyStepper> {
        self.takes(run.threads, run.chain())?;
        self.runs(run.chain())?;
        run.chain().magnets_apart(y)?;
        within(self.unwatched(run, y, span, setting)?, run)
    }

    fn unwatched(&self, run: &Run, y: &[f64], span: (f64, f64), setting: Setting) -> Result<AnyStepper> {
        let chain = run.chain().clone();
        match (self, setting) {
            (&Self::Splitting(scheme, split), Setting::Steps(steps)) => {
                splitting((scheme, split), chain, run.threads, (y, span, steps))
            }
            (&Self::Corrected(parts), Setting::Steps(_))
            | (&Self::Corrected(parts @ splitting::Parts { corrected: true, .. }), Setting::Tolerance(_)) => {
                Ok(corrected(run, y, span, setting, parts, false)?)
            }
            (Self::Conserving, Setting::Steps(steps)) => Ok(Box::new(DiscreteGradient::new(chain, y, span, steps)?)),
            (&Self::Dop853(contacts), Setting::Tolerance(tol)) => dop853(run, contacts, y, span, tol),
            (Self::Collocation, Setting::Tolerance(_) | Setting::Windows(..)) => {
                Ok(collocated(run, y, span, setting, false)?)
            }
            (_, Setting::Windows(windows, _)) => {
                Err(Error::parameter("windows-per-period", windows, "only collocation takes windows"))
            }
            (Self::Splitting(..) | Self::Corrected(..) | Self::Conserving, Setting::Tolerance(tol)) => {
                Err(Error::parameter("tol", tol, NO_TOLERANCE))
            }
            (Self::Dop853(_) | Self::Collocation, Setting::Steps(steps)) => {
                Err(Error::parameter("steps", steps, "an adaptive method chooses its steps: give it --tol"))
            }
        }
    }
}

/// The stepper for a leg of a run, for methods that log their contacts themselves. `None` for
/// methods whose contacts must be found by [`Watch`](hertzchain_integrators::Watch).
///
/// # Errors
/// As [`Method::start`].
pub(super) fn start_logged(
    method: Method,
    run: &Run,
    y: &[f64],
    span: (f64, f64),
    setting: Setting,
) -> Result<Option<LoggingStepper>> {
    method.takes(run.threads, run.chain())?;
    method.runs(run.chain())?;
    match (method, setting) {
        (Method::Collocation, _) => Ok(Some(collocated(run, y, span, setting, true)?)),
        (
            Method::Corrected(parts @ splitting::Parts { corrected: true, .. }),
            Setting::Steps(_) | Setting::Tolerance(_),
        ) => Ok(Some(corrected(run, y, span, setting, parts, true)?)),
        _ => Ok(None),
    }
}

/// Contact collocation of a run, with or without a log.
fn collocated(run: &Run, y: &[f64], span: (f64, f64), setting: Setting, log: bool) -> Result<LoggingStepper> {
    fn boxed<C: ContactChain<S> + 'static, const S: usize>(run: Collocation<C, S>, log: bool) -> LoggingStepper {
        Box::new(if log { run.logged() } else { run })
    }
    let (chain, threads, control) = (run.chain(), run.threads, control(setting)?);
    Ok(if chain.details().is_some() {
        boxed(Collocation::on_threads(HeterogeneousChain::new(chain.clone())?, y, span, control, threads)?, log)
    } else {
        boxed(Collocation::on_threads(chain.clone(), y, span, control, threads)?, log)
    })
}

/// A splitting of a chain, or of chains abreast, on this number of threads.
pub(super) fn splitting(
    by: (&'static Scheme, Split),
    chain: Chain<f64>,
    threads: Option<usize>,
    leg @ (_, (start, _), _): (&[f64], (f64, f64), u64),
) -> Result<AnyStepper> {
    fn boxed<F: SplitFlow<f64> + Send + 'static>(
        (scheme, split): (&Scheme, Split),
        flow: F,
        (y, span, steps): (&[f64], (f64, f64), u64),
    ) -> Result<AnyStepper> {
        Ok(Box::new(Splitting::new(scheme, split.first(), loaded(flow, y), span, steps)?))
    }
    match (by.1, threads.filter(|&count| count > 1)) {
        _ if chain.details().is_some() => boxed(by, SitewiseFlow::new(chain, by.1, start), leg),
        (Split::Kinetic, None) => boxed(by, KineticFlow::new(chain), leg),
        (Split::Linear, None) => boxed(by, LinearFlow::new(chain), leg),
        (Split::Kinetic, Some(count)) => boxed(by, Parted::<KineticFlow<f64>>::new(&chain, count), leg),
        (Split::Linear, Some(count)) => boxed(by, Parted::<LinearFlow<f64>>::new(&chain, count), leg),
    }
}

/// DOP853 of a run, across its contacts or from event to event.
fn dop853(run: &Run, contacts: Contacts, y: &[f64], span: (f64, f64), tol: f64) -> Result<AnyStepper> {
    let chain = run.chain().clone();
    // The absolute tolerance belongs to the size of the motion, so that waves of small amplitude
    // are integrated with the same relative accuracy, down to a twentieth of the rounding of static
    // overlaps: their forces have it.
    let natural = chain.natural(run.initial().as_slice());
    let (units, time) = (natural.of_state(&chain), natural.time);
    let (alpha, power) = chain.powers_at_events(Method::Dop853(contacts).info().order);
    let scale = natural.of_overlaps(alpha);
    let rounding = 0.05 * f64::EPSILON * chain.largest_rest() / scale.0;
    let options = Options { atol: rounding.max(tol * natural.size), ..Options::new(tol) };
    let q = match contacts {
        Contacts::Crossed => {
            return Ok(Box::new(Dop853::new(Field::new(chain), y, span, options)?.in_units(&units, time)));
        }
        Contacts::Landed => 1,
        Contacts::Regularised => power,
    };
    let field = Field::new(chain.clone());
    let overlaps = Overlaps::with_pushes(chain, &natural, false);
    let run = Regularised::new(field, overlaps, (alpha, q), y, span, options)?;
    Ok(Box::new(run.in_units(&units, time, scale)))
}

/// Contact-corrected splitting of a run, with or without a log.
fn corrected(
    run: &Run,
    y: &[f64],
    span: (f64, f64),
    setting: Setting,
    parts: splitting::Parts,
    log: bool,
) -> Result<LoggingStepper> {
    fn boxed<S: BondFlow + Send + 'static>(run: Corrected<S>, log: bool) -> LoggingStepper {
        Box::new(if log { run.logged() } else { run })
    }
    let steps = match setting {
        Setting::Tolerance(tol) => {
            let method = Method::Corrected(parts);
            let start = |y: &[f64], steps| method.start(run, y, span, Setting::Steps(steps));
            tolerance::steps(run, y, span, method.tolerances().check(tol)?, &start)?
        }
        Setting::Steps(steps) | Setting::Windows(steps, _) => steps,
    };
    let chain = run.chain().clone();
    if chain.details().is_some() {
        let flow = SitewiseBonds::new(loaded(SitewiseFlow::new(chain, Split::Linear, span.0), y));
        return Ok(boxed(Corrected::new(flow, span, steps, parts)?, log));
    }
    let flow = CorrectedSplit::new(loaded(LinearFlow::new(chain), y));
    Ok(boxed(Corrected::new(flow, span, steps, parts)?, log))
}

/// How finely collocation works under a setting.
///
/// # Errors
/// A setting in steps.
fn control(setting: Setting) -> Result<StepControl> {
    match setting {
        Setting::Tolerance(tol) => Ok(StepControl::Tolerance(tol)),
        Setting::Windows(windows, nodes) => Ok(StepControl::Windows { windows, nodes, neighbours: true }),
        Setting::Steps(steps) => {
            let rule = "collocation takes --tol, or --windows-per-period and --nodes";
            Err(Error::parameter("steps", steps, rule))
        }
    }
}

/// A flow that holds the state `y`.
pub(super) fn loaded<S: SplitFlow<f64>>(mut flow: S, y: &[f64]) -> S {
    flow.load(y);
    flow
}

impl Split {
    /// The flow with which compositions begin on this split.
    pub(super) fn first(self) -> First {
        match self {
            Self::Kinetic => First::Kick,
            Self::Linear => First::Drift,
        }
    }
}
