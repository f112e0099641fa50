//! Several runs, those of chains alike side by side in the lanes of a register.

use super::{Method, Recorder, Run, Setting, Snapshot, Trajectory, method::Split, start::splitting};
use crate::{chain::Chain, error::Result};
use hertzchain_integrators::{Error as Failure, Observer, Scheme, Stats, Stepper, drive};
use std::{ops::ControlFlow, time::Instant};

/// Starts runs; each result is that of [`Run::start`], with the same bits. `seen` is called with
/// the number of a run, the time of each of its samples, and the state there.
///
/// Runs that follow each other are made together, as many as a register has lanes, if they are by a
/// splitting scheme with the same number of equal steps over the same span, of chains of the same
/// length, at most a few hundred beads, and boundary, and neither contacts, observables nor
/// crossings are asked for.
///
/// Uniform chains have the exponent 3/2, differ in their initial states only, and fill more than
/// half of the lanes. Chains with [`Details`](crate::chain::Details) may also differ in all details
/// but gravity and further powers of contacts, and none has a table; moving resonators, springs or
/// magnets between beads, and the ledger of energies are in all of them or in none. Their wall time
/// is shared equally.
///
/// ```
/// # use hertzchain_core::{Boundary, Chain, Method, Params, Run, Setting, State, run::start_all};
/// let runs = [0.5, 0.6, 0.7, 0.8, 1.0, 1.4, 1.6, 2.0].map(|speed| {
///     let chain = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 10).unwrap();
///     let mut state = State::rest(&chain);
///     state.u_dot_mut()[0] = speed;
///     let run = Run::new(chain, state).until(5.0).unwrap();
///     run.method(Method::named("verlet").unwrap()).setting(Setting::Steps(1000))
/// });
/// let ends = start_all(&runs, &mut |_, _, _| ());
/// for (run, end) in runs.iter().zip(ends) {
///     assert_eq!(end?.state, run.start()?.state);
/// }
/// # Ok::<(), hertzchain_core::Error>(())
/// ```
pub fn start_all(runs: &[Run], seen: &mut dyn FnMut(usize, f64, &[f64])) -> Vec<Result<Trajectory>> {
    let mut ends = Vec::with_capacity(runs.len());
    for group in groups(runs, runs.len()) {
        let from = ends.len();
        let mut seen = |k: usize, t: f64, y: &[f64]| seen(from + k, t, y);
        match group[0].split().filter(|_| group.len() > 1).map(|split| together(group, split, &mut seen)) {
            Some(Ok(together)) => ends.extend(together.into_iter().map(Ok)),
            // What is refused is refused run by run.
            _ => ends
                .extend((group.iter().enumerate()).map(|(k, run)| run.observe(&mut |t, y| seen(k, t, y), &mut |_| ()))),
        }
    }
    ends
}

/// Runs that [`start_all`] makes together, at most `most` of them; others alone.
pub fn groups(runs: &[Run], most: usize) -> Vec<&[Run]> {
    let (mut groups, mut rest) = (Vec::new(), runs);
    while let Some(first) = rest.first() {
        let at_once = first.chain.abreast_at_once();
        let alike = rest.iter().take(most.min(*at_once.end())).take_while(|run| first.alike(run)).count();
        let (group, others) = rest.split_at(if at_once.contains(&alike) { alike } else { 1 });
        groups.push(group);
        rest = others;
    }
    groups
}

impl Run {
    /// Scheme, split and steps of a run that can be made together with others.
    fn split(&self) -> Option<(&'static Scheme, Split, u64)> {
        let Method::Splitting(scheme, split) = self.method? else { return None };
        let runs = self.method?.runs(&self.chain).and(self.chain.magnets_apart(self.initial().as_slice()));
        // A run with a table is watched for overlaps beyond its last row.
        let table = self.chain.details().is_some_and(|details| details.table.is_some());
        let plain = runs.is_ok() && !table && self.threads.is_none_or(|count| count == 1);
        let plain = plain && !self.contacts && self.observables.is_none() && self.crossings.is_none();
        match self.setting {
            Some(Setting::Steps(steps)) if plain => Some((scheme, split, steps)),
            _ => None,
        }
    }

    /// Whether another run can be made together with this one.
    fn alike(&self, other: &Self) -> bool {
        (self.start, self.end) == (other.start, other.end)
            && self.split().is_some()
            && (self.method, self.setting) == (other.method, other.setting)
            && other.split().is_some()
            && self.chain.kind() == other.chain.kind()
            && (self.records, &self.sampling) == (other.records, &other.sampling)
    }
}

/// Runs that are alike, side by side.
fn together(
    runs: &[Run],
    (scheme, split, steps): (&'static Scheme, Split, u64),
    seen: &mut dyn FnMut(usize, f64, &[f64]),
) -> Result<Vec<Trajectory>> {
    let (clock, (start, end)) = (Instant::now(), runs[0].span()?);
    let mut y: Vec<f64> = runs.iter().flat_map(|run| run.initial().as_slice()).copied().collect();
    let dim = y.len() / runs.len();
    let chain = Chain::abreast(runs.iter().map(|run| run.chain.clone()).collect());
    y.resize(chain.full_dim(), 0.0);
    let mut stepper = splitting((scheme, split), chain, None, (&y, (start, end), steps))?;
    let mut silent = vec![|_: f64, _: &[f64]| (); runs.len()];
    let members = runs.iter().zip(&mut silent).map(|(run, silent)| Recorder::new(run, Snapshot::new(run), silent));
    let mut members = Members { first: &runs[0], recorders: members.map(Some).collect(), seen };
    let driven = drive(&mut stepper, &mut members, &mut y).map(|_| ());
    let (stats, wall) = (stepper.stats(), clock.elapsed() / runs.len() as u32);
    let t = if stepper.done() { end } else { stepper.time() };
    let ends = members.recorders.into_iter().zip(runs).zip(y.chunks(dim)).map(|((recorder, run), y)| {
        // One that failed is made alone: its failure names the step.
        let Some(mut recorder) = recorder else { return run.start() };
        recorder.kept.wall = wall;
        let failure = recorder.close(driven.clone(), t, y.to_vec(), stats).err();
        Ok(recorder.trajectory(failure))
    });
    ends.collect()
}

/// The observers of runs that are alike, of those that have not failed.
struct Members<'a, 'b> {
    first: &'a Run,
    recorders: Vec<Option<Recorder<'a>>>,
    seen: &'b mut dyn FnMut(usize, f64, &[f64]),
}

impl Observer<f64> for Members<'_, '_> {
    fn next(&self) -> Option<f64> {
        self.first.sample_time(self.recorders.iter().flatten().next()?.kept.taken)
    }

    fn observe(&mut self, t: f64, y: &[f64], stats: Stats) -> std::result::Result<ControlFlow<()>, Failure> {
        let dim = self.first.chain.layout().dim();
        for (k, (slot, y)) in self.recorders.iter_mut().zip(y.chunks(dim)).enumerate() {
            let Some(recorder) = slot else { continue };
            match recorder.observe(t, y, stats) {
                Ok(_) => (self.seen)(k, t, y),
                Err(_) => *slot = None,
            }
        }
        let all_failed = self.recorders.iter().all(Option::is_none);
        Ok(if all_failed { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    }
}
