//! Several runs, those of equal chains side by side in the lanes of a register.

use super::{
    Method, Recorder, Run, Setting, Snapshot, Trajectory,
    method::{Split, loaded},
};
use crate::{
    chain::{Batch, Divisible, KineticFlow, LinearFlow},
    error::Result,
};
use hertzchain_integrators::{
    Error as Failure, Observer, SplitFlow, Splitting, Stats, Stepper, drive,
    splitting::{Scheme, tables},
};
use std::{ops::ControlFlow, time::Instant};

/// Starts runs; each result is that of [`Run::start`], with the same bits. `seen` is called with
/// the number of a run, the time of each of its samples, and the state there.
///
/// Runs that follow each other, differ in their initial states only and are by a splitting with a
/// given number of equal steps, are made together, as many as a register has lanes, if their beads
/// are equal, at most a few thousand, and neither contacts, observables nor crossings are asked
/// for. Their wall time is shared equally.
///
/// ```
/// # use hertzchain_core::{Boundary, Chain, Method, Params, Run, Setting, State, run::start_all};
/// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Free, 10)?;
/// let runs = [0.5, 1.0, 2.0].map(|speed| {
///     let mut state = State::rest(&chain);
///     state.u_dot_mut()[0] = speed;
///     let run = Run::new(chain.clone(), state).until(5.0).unwrap();
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
        let most = most.min(Batch::<LinearFlow<f64>>::most(&first.chain));
        let alike = rest.iter().take(most).take_while(|run| first.alike(run)).count();
        let (group, others) = rest.split_at(alike.max(1));
        groups.push(group);
        rest = others;
    }
    groups
}

impl Run {
    /// Scheme, split and steps of a run that can be made together with others.
    fn split(&self) -> Option<(&'static Scheme, Split, u64)> {
        let plain = self.chain.details().is_none() && self.parts.whole() && !self.contacts;
        let (scheme, split) = match self.method? {
            Method::Splitting(scheme, split) => (scheme, split),
            Method::SingleRoots(split) if self.method?.runs(&self.chain).is_ok() => (&tables::STRANG, split),
            _ => return None,
        };
        match self.setting {
            Some(Setting::Steps(steps)) if plain && self.observables.is_none() && self.crossings.is_none() => {
                Some((scheme, split, steps))
            }
            _ => None,
        }
    }

    /// Whether another run differs in its initial state only, and can be made together with this
    /// one.
    fn alike(&self, other: &Self) -> bool {
        let chain = |run: &Self| (run.chain.params(), run.chain.topology(), run.chain.precompression());
        self.split().is_some()
            && (self.method, self.setting) == (other.method, other.setting)
            && other.split().is_some()
            && chain(self) == chain(other)
            && (self.start, self.end, self.period, self.records)
                == (other.start, other.end, other.period, other.records)
            && self.sampling == other.sampling
    }
}

/// Runs that are alike, side by side.
fn together(
    runs: &[Run],
    (scheme, split, steps): (&'static Scheme, Split, u64),
    seen: &mut dyn FnMut(usize, f64, &[f64]),
) -> Result<Vec<Trajectory>> {
    let clock = Instant::now();
    let spans = runs.iter().map(Run::span).collect::<Result<Vec<_>>>()?;
    let mut y: Vec<f64> = runs.iter().flat_map(|run| run.initial().as_slice()).copied().collect();
    let mut stepper: Box<dyn Stepper<f64>> = match split {
        Split::Kinetic => started::<KineticFlow<f64>>(runs, &y, (scheme, split, steps), spans[0])?,
        Split::Linear => started::<LinearFlow<f64>>(runs, &y, (scheme, split, steps), spans[0])?,
    };
    let mut silent = vec![|_: f64, _: &[f64]| (); runs.len()];
    let members = runs.iter().zip(&mut silent).map(|(run, silent)| Recorder::new(run, Snapshot::new(run), silent));
    let mut members = Members { recorders: members.map(Some).collect(), seen };
    let driven = drive(&mut stepper, &mut members, &mut y).map(|_| ());
    let (t, stats, wall) = (stepper.time(), stepper.stats(), clock.elapsed() / runs.len() as u32);
    let dim = y.len() / runs.len();
    let ends = members.recorders.into_iter().zip(runs).zip(y.chunks(dim)).map(|((recorder, run), y)| {
        // One that failed is made alone: its failure names the step.
        let Some(mut recorder) = recorder else { return run.start() };
        recorder.kept.wall = wall;
        let failure = recorder.close(driven.clone(), t, y.to_vec(), stats).err();
        Ok(recorder.trajectory(failure))
    });
    ends.collect()
}

/// The stepper of runs that are alike.
fn started<F>(
    runs: &[Run],
    y: &[f64],
    (scheme, split, steps): (&'static Scheme, Split, u64),
    span: (f64, f64),
) -> Result<Box<dyn Stepper<f64>>>
where
    F: Divisible<f64> + 'static,
    Batch<F>: SplitFlow<f64>,
{
    let chain = runs[0].chain.clone();
    let single = matches!(runs[0].method, Some(Method::SingleRoots(_)));
    let flow = loaded(Batch::<F>::new(if single { chain.with_single_roots() } else { chain }, runs.len()), y);
    Ok(Box::new(Splitting::new(scheme, split.first(), flow, span, steps)?))
}

/// The observers of runs that are alike, of those that have not failed.
struct Members<'a, 'b> {
    recorders: Vec<Option<Recorder<'a>>>,
    seen: &'b mut dyn FnMut(usize, f64, &[f64]),
}

impl Observer<f64> for Members<'_, '_> {
    fn next(&self) -> Option<f64> {
        self.recorders.iter().flatten().next()?.next()
    }

    fn observe(&mut self, t: f64, y: &[f64], stats: Stats) -> std::result::Result<ControlFlow<()>, Failure> {
        let dim = y.len() / self.recorders.len();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        chain::{Boundary, Chain, Params, State},
        run::Records,
    };

    /// Runs of a chain by a splitting from states of sizes 1, 2, ..
    fn runs(chain: &Chain<f64>, method: &str, sizes: std::ops::Range<u32>, steps: u64) -> Vec<Run> {
        let run = |size: u32| {
            let mut state = State::rest(chain);
            let numbers = state.as_mut_slice().iter_mut().enumerate();
            numbers.for_each(|(i, x)| *x = 0.01 * f64::from(size) * (0.7 * (i * i) as f64 + 0.3).sin());
            let run = Run::new(chain.clone(), state).until(7.0).unwrap().samples(3).unwrap().records(Records::Energy);
            run.method(Method::named(method).unwrap()).setting(Setting::Steps(steps))
        };
        sizes.map(run).collect()
    }

    #[test]
    fn runs_that_are_made_together_have_the_bits_of_each_alone() {
        // Truth: each run alone, with the states at all samples; numbers of runs around that of
        // lanes, lengths around a register, more kicks than there are between two anchors.
        crate::chain::on_every_set(|set| {
            for (k, boundary) in Boundary::ALL.into_iter().enumerate() {
                for (n, rho) in
                    [1, 2, 3, 9].into_iter().flat_map(|n| [0.0, 1.0 / 3.0, f64::INFINITY].map(|rho| (n, rho)))
                {
                    let params = Params::new([1.2, 1.5, 2.0, 2.5][(n + k) % 4], 1.0, rho).unwrap();
                    let chain = Chain::new(params, boundary, n).unwrap();
                    let chain = chain.clone().precompressed(0.01).unwrap_or(chain);
                    let single = (params.alpha == 1.5).then_some(["verlet-single", "strang-linear-single"]);
                    let single = single.into_iter().flatten();
                    for method in ["verlet", "strang-linear", "aba864"].into_iter().chain(single) {
                        let runs = runs(&chain, method, 1..8, 90);
                        let (mut seen, mut want) = (vec![Vec::new(); 7], vec![Vec::new(); 7]);
                        let ends = start_all(&runs, &mut |k, t, y| seen[k].push((t, y.to_vec())));
                        for ((run, end), want) in runs.iter().zip(ends).zip(&mut want) {
                            let alone = run.observe(&mut |t, y| want.push((t, y.to_vec())), &mut |_| ()).unwrap();
                            let end = end.unwrap();
                            assert!(
                                end.state == alone.state && end.samples == alone.samples,
                                "{set} {boundary:?} {n} {rho}"
                            );
                            assert_eq!(
                                (end.energy_error, end.stats, end.t),
                                (alone.energy_error, alone.stats, alone.t)
                            );
                        }
                        assert!(
                            seen == want && seen[0].len() == 4 && seen[0] != seen[1],
                            "{set} {boundary:?} {n} {rho}"
                        );
                    }
                }
            }
        });
    }

    #[test]
    fn a_run_that_fails_leaves_the_others_alone_and_others_are_refused_one_by_one() {
        // Truth: each alone. Steps of 0.7 are unstable for Verlet where beads are pressed hard.
        let chain = Chain::new(Params::new(2.5, 4.0, f64::INFINITY).unwrap(), Boundary::Ring, 9).unwrap();
        let mut all = runs(&chain, "verlet", 1..4, 10);
        all[1] = runs(&chain, "verlet", 100_000..100_001, 10).remove(0);
        all.push(all[0].clone().setting(Setting::Tolerance(1e-3)));
        let mut ends = start_all(&all, &mut |_, _, _| ());
        assert!(matches!(ends.pop(), Some(Err(_))), "verlet takes no tolerance");
        let failed: Vec<bool> = ends.iter().map(|end| end.as_ref().unwrap().failure.is_some()).collect();
        assert_eq!(failed, [false, true, false]);
        for (run, end) in all.iter().zip(ends) {
            let (alone, end) = (run.start().unwrap(), end.unwrap());
            // As text, in which NaN is itself.
            let told = |end: &Trajectory| format!("{:?}", (&end.state, end.t, &end.failure));
            assert_eq!(told(&end), told(&alone));
        }
    }
}
