//! Several runs, those of chains alike side by side in the lanes of a register.

use super::{
    Method, Recorder, Records, Run, Sampling, Setting, Snapshot, Trajectory,
    method::{Split, loaded},
};
use crate::{
    chain::{Chain, Divisible, KineticFlow, LinearFlow},
    error::Result,
};
use hertzchain_integrators::{
    Error as Failure, Observer, Splitting, Stats, Stepper, drive,
    lanes::Each,
    splitting::{Scheme, tables},
};
use std::{ops::ControlFlow, time::Instant};

/// Starts runs; each result is that of [`Run::start`], with the same bits. `seen` is called with
/// the number of a run, the time of each of its samples, and the state there.
///
/// Runs that follow each other are made together, as many as a register has lanes, if they are by a
/// splitting with the same number of equal steps and differ in nothing but their initial states,
/// the parameters kappa and rho, the precompression and, if samples are equally spaced and taken at
/// ends of steps, the span. Beads of a chain must be equal, at most a few thousand; all chains of
/// one group are plain, or all have fixed resonators, or all moving ones; and neither contacts,
/// observables nor crossings are asked for. Their wall time is shared equally.
///
/// ```
/// # use hertzchain_core::{Boundary, Chain, Method, Params, Run, Setting, State, run::start_all};
/// let runs = [0.5, 1.0, 2.0].map(|speed| {
///     let chain = Chain::new(Params::new(1.5, speed, 0.3).unwrap(), Boundary::Free, 10).unwrap();
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
        let most = most.min(first.chain.most_abreast());
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

    /// Whether another run can be made together with this one.
    fn alike(&self, other: &Self) -> bool {
        let chain = |run: &Self| (run.chain.params().alpha, run.chain.params().resonators(), run.chain.topology());
        self.split().is_some()
            && (self.method, self.setting) == (other.method, other.setting)
            && other.split().is_some()
            && chain(self) == chain(other)
            && (self.records, &self.sampling) == (other.records, &other.sampling)
            && ((self.start, self.end) == (other.start, other.end) || self.sampled_at_steps())
    }

    /// Whether all samples of a run by equal steps are at ends of steps.
    fn sampled_at_steps(&self) -> bool {
        match (&self.sampling, self.setting) {
            (Sampling::Equal(samples), Some(Setting::Steps(steps))) => {
                self.records == Records::End || steps.is_multiple_of((*samples).max(1) as u64)
            }
            _ => false,
        }
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
    let forces = |run: &Run| match run.method {
        Some(Method::SingleRoots(_)) => run.chain.clone().with_single_roots(),
        _ => run.chain.clone(),
    };
    let (chain, first) = (Chain::abreast(runs.iter().map(forces).collect()), split.first());
    let mut stepper: Box<dyn Stepper<f64>> = match split {
        Split::Kinetic => {
            let flow = loaded(KineticFlow::<f64, Each<f64>>::rest(chain), &y);
            Box::new(Splitting::abreast(scheme, first, flow, &spans, steps)?)
        }
        Split::Linear => {
            let flow = loaded(LinearFlow::<f64, Each<f64>>::rest(chain), &y);
            Box::new(Splitting::abreast(scheme, first, flow, &spans, steps)?)
        }
    };
    let mut silent = vec![|_: f64, _: &[f64]| (); runs.len()];
    let members = runs.iter().zip(&mut silent).map(|(run, silent)| Recorder::new(run, Snapshot::new(run), silent));
    let mut members = Members { first: &runs[0], recorders: members.map(Some).collect(), seen };
    let driven = drive(&mut stepper, &mut members, &mut y).map(|_| ());
    let (stats, wall) = (stepper.stats(), clock.elapsed() / runs.len() as u32);
    let (start, end) = spans[0];
    // The share of its span that a run has made.
    let made = if stepper.done() { 1.0 } else { (stepper.time() - start) / (end - start) };
    let dim = y.len() / runs.len();
    let ends = members.recorders.into_iter().zip(runs).zip(y.chunks(dim)).map(|((recorder, run), y)| {
        // One that failed is made alone: its failure names the step.
        let Some(mut recorder) = recorder else { return run.start() };
        recorder.kept.wall = wall;
        let t = if made == 1.0 { run.end } else { run.start + made * (run.end - run.start) };
        let failure = recorder.close(driven.clone(), t, y.to_vec(), stats).err();
        Ok(recorder.trajectory(failure))
    });
    ends.collect()
}

/// The observers of runs that are alike, of those that have not failed. Times are those of the
/// first run.
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
        let dim = y.len() / self.recorders.len();
        for (k, (slot, y)) in self.recorders.iter_mut().zip(y.chunks(dim)).enumerate() {
            let Some(recorder) = slot else { continue };
            // Its own time.
            let t = recorder.next().unwrap_or(t);
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
    use crate::chain::{Boundary, Params, State};

    /// Runs by a splitting from states of sizes 1, 2, .., each of a chain for this size.
    fn runs(chain: impl Fn(u32) -> Chain<f64>, method: &str, sizes: std::ops::Range<u32>, steps: u64) -> Vec<Run> {
        let run = |size: u32| {
            let chain = chain(size);
            let mut state = State::rest(&chain);
            let numbers = state.as_mut_slice().iter_mut().enumerate();
            numbers.for_each(|(i, x)| *x = 0.01 * f64::from(size) * (0.7 * (i * i) as f64 + 0.3).sin());
            // Samples of other spans than the first one's are at ends of steps only.
            let end = if steps.is_multiple_of(3) { 7.0 + 0.3 * f64::from(size) } else { 7.0 };
            let run = Run::new(chain, state).until(end).unwrap().samples(3).unwrap().records(Records::Energy);
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
                    // Each has springs, resonators and a precompression of its own.
                    let chain = |size: u32| {
                        let (alpha, size) = ([1.2, 1.5, 2.0, 2.5][(n + k) % 4], f64::from(size));
                        let params = Params::new(alpha, 0.7 + 0.1 * size, size * rho).unwrap();
                        let chain = Chain::new(params, boundary, n).unwrap();
                        chain.clone().precompressed(0.01 * size).unwrap_or(chain)
                    };
                    // By 90 steps over spans of their own, by 91 with samples inside steps.
                    let ways = ["verlet", "strang-linear", "aba864"].map(|method| (method, 90));
                    let single = ["verlet-single", "strang-linear-single"].map(|method| (method, 90));
                    let single = single.into_iter().filter(|_| (n + k) % 4 == 1);
                    let inside = [("verlet", 91), ("strang-linear", 91)];
                    for (method, steps) in ways.into_iter().chain(inside).chain(single) {
                        let runs = runs(chain, method, 1..8, steps);
                        assert_eq!(groups(&runs, 7)[0].len(), runs[0].chain.most_abreast().min(7));
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
        let chain = |_| chain.clone();
        let mut all = runs(chain, "verlet", 1..4, 10);
        all[1] = runs(chain, "verlet", 100_000..100_001, 10).remove(0);
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
