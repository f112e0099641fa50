//! Several runs, those of chains alike side by side in the lanes of a register.

use super::{
    Method, Recorder, Records, Run, Sampling, Setting, Snapshot, Trajectory,
    method::{Split, loaded},
};
use crate::{
    chain::{Chain, CorrectedSplit, Divisible, FEW, KineticFlow, LinearFlow, SitewiseFlow},
    error::Result,
};
use hertzchain_integrators::{
    Error as Failure, Observer, Splitting, Stats, Stepper, drive,
    lanes::Each,
    splitting::{Corrected, tables},
};
use std::{ops::ControlFlow, time::Instant};

/// Starts runs; each result is that of [`Run::start`], with the same bits. `seen` is called with
/// the number of a run, the time of each of its samples, and the state there.
///
/// Runs that follow each other are made together, as many as a register has lanes, if they are by a
/// splitting with the same number of equal steps, on chains of the same length, at most a few
/// hundred beads, and boundary, and neither contacts, observables nor crossings are asked for.
///
/// Chains of equal beads may differ in their initial states, in kappa, rho and precompression and,
/// if samples are equally spaced and taken at ends of steps, in the span; all are plain, or all
/// have fixed resonators, or all moving ones. By contact-corrected splitting on the linear split
/// they have fewer than 64 beads, and differ in their initial states only; by that on the kinetic
/// split, and by either on chains with details, runs are made one by one. Chains with details may
/// differ in their initial states and in all details but gravity and further powers of contacts,
/// and none has a table; moving resonators, springs or magnets between beads, and the ledger of
/// energies are in all of them or in none. Their wall time is shared equally.
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
    /// Split and steps of a run that can be made together with others.
    fn split(&self) -> Option<(Split, u64)> {
        let runs = self.method?.runs(&self.chain).and(self.chain.magnets_apart(self.initial().as_slice()));
        // A run with a table is watched for overlaps beyond its last row.
        let table = self.chain.details().is_some_and(|details| details.table.is_some());
        let plain = runs.is_ok() && self.threads.is_none_or(|count| count == 1) && !self.contacts && !table;
        let (split, corrected) = (self.method?.split()?, matches!(self.method?, Method::Corrected(..)));
        let few = split == Split::Linear && self.chain.details().is_none() && self.chain.sites() < FEW;
        let plain = plain && (few || !corrected) && self.observables.is_none() && self.crossings.is_none();
        match self.setting {
            Some(Setting::Steps(steps)) if plain => Some((split, steps)),
            _ => None,
        }
    }

    /// Whether another run can be made together with this one.
    fn alike(&self, other: &Self) -> bool {
        let same = (self.start, self.end) == (other.start, other.end);
        let (own, others) = (&self.chain, &other.chain);
        let fits = match self.method {
            Some(Method::Corrected(..)) => {
                same && (own.params(), own.precompression()) == (others.params(), others.precompression())
            }
            _ => same || own.details().is_none() && self.sampled_at_steps(),
        };
        fits && self.split().is_some()
            && (self.method, self.setting) == (other.method, other.setting)
            && other.split().is_some()
            && own.kind() == others.kind()
            && (self.records, &self.sampling) == (other.records, &other.sampling)
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
    (split, steps): (Split, u64),
    seen: &mut dyn FnMut(usize, f64, &[f64]),
) -> Result<Vec<Trajectory>> {
    let clock = Instant::now();
    let spans = runs.iter().map(Run::span).collect::<Result<Vec<_>>>()?;
    let mut y: Vec<f64> = runs.iter().flat_map(|run| run.initial().as_slice()).copied().collect();
    let (chain, first) = (Chain::abreast(runs.iter().map(|run| run.chain.clone()).collect()), split.first());
    let scheme = if let Some(Method::Splitting(scheme, _)) = runs[0].method { scheme } else { &tables::STRANG };
    let mut stepper: Box<dyn Stepper<f64>> = match (runs[0].method, split) {
        (Some(Method::Corrected(parts, _)), _) => {
            let flow = loaded(LinearFlow::<f64, Each<f64>>::rest(chain), &y);
            Box::new(Corrected::new(CorrectedSplit::new(flow), spans[0], steps, parts)?)
        }
        _ if chain.details().is_some() => {
            let flow = loaded(SitewiseFlow::new(chain, split, spans[0].0), &y);
            Box::new(Splitting::new(scheme, first, flow, spans[0], steps)?)
        }
        (_, Split::Kinetic) => {
            let flow = loaded(KineticFlow::<f64, Each<f64>>::rest(chain), &y);
            Box::new(Splitting::abreast(scheme, first, flow, &spans, steps)?)
        }
        (_, Split::Linear) => {
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
    use crate::chain::{Boundary, Details, Drive, DriveKind, Params, Signal, State, Term};

    /// Runs by a splitting from states of sizes 1, 2, .., each of a chain for this size.
    fn runs(chain: impl Fn(u32) -> Chain<f64>, method: &str, sizes: std::ops::Range<u32>, steps: u64) -> Vec<Run> {
        let run = |size: u32| {
            let chain = chain(size);
            let mut state = State::rest(&chain);
            let numbers = state.as_mut_slice().iter_mut().enumerate();
            numbers.for_each(|(i, x)| *x = 0.01 * f64::from(size) * (0.7 * (i * i) as f64 + 0.3).sin());
            chain.follow(0.0, state.as_mut_slice());
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
                    let inside = [("verlet", 91), ("strang-linear", 91)];
                    for (method, steps) in ways.into_iter().chain(inside) {
                        let runs = runs(chain, method, 1..8, steps);
                        each_as_alone(&runs, &format!("{set} {boundary:?} {n} {rho}"));
                    }
                }
            }
        });
    }

    #[test]
    fn corrected_runs_that_are_made_together_have_the_bits_of_each_alone() {
        // Truth: each run alone; samples at ends of steps and inside, each of which searches for
        // events near it; numbers of sites around those of a register, walls that hold a
        // precompression, and both parts of the method.
        crate::chain::on_every_set(|set| {
            for (k, boundary) in Boundary::ALL.into_iter().enumerate() {
                for (n, rho) in [1, 2, 3, 9, 17].into_iter().flat_map(|n| [0.0, 0.4, f64::INFINITY].map(|rho| (n, rho)))
                {
                    let chain = Chain::new(Params::new([1.2, 1.5, 2.0][(n + k) % 3], 1.0, rho).unwrap(), boundary, n);
                    let chain = chain.unwrap();
                    let chain = chain.clone().precompressed([0.0, 0.02][n % 2]).unwrap_or(chain);
                    for (method, steps) in [("corrected", 90), ("corrected", 101), ("takahashi-imada-linear", 91)] {
                        let runs = runs(|_| chain.clone(), method, 1..8, steps);
                        let runs: Vec<_> = runs.into_iter().map(|run| run.until(12.0).unwrap()).collect();
                        each_as_alone(&runs, &format!("{set} {boundary:?} {n} {rho} {method} {steps}"));
                    }
                }
            }
        });
        // What cannot be made together: parameters and spans of their own, the kinetic split.
        let chain = |size: u32| Chain::new(Params::new(1.5, f64::from(size), 0.4).unwrap(), Boundary::Free, 9).unwrap();
        let alone = |runs: &[Run]| assert_eq!(groups(runs, 7)[0].len(), 1);
        alone(&runs(chain, "corrected", 1..8, 91));
        alone(&runs(|_| chain(1), "corrected", 1..8, 90));
        alone(&runs(|_| chain(1), "corrected-kinetic", 1..8, 91));
    }

    /// Seven runs that are made together have the bits of each alone, at all samples.
    fn each_as_alone(runs: &[Run], told: &str) {
        assert_eq!(groups(runs, 7)[0].len(), runs[0].chain.most_abreast().min(7), "{told}");
        let (mut seen, mut want) = (vec![Vec::new(); 7], vec![Vec::new(); 7]);
        let ends = start_all(runs, &mut |k, t, y| seen[k].push((t, y.to_vec())));
        for ((run, end), want) in runs.iter().zip(ends).zip(&mut want) {
            let alone = run.observe(&mut |t, y| want.push((t, y.to_vec())), &mut |_| ()).unwrap();
            let end = end.unwrap();
            assert!(end.state == alone.state && end.samples == alone.samples, "{told}");
            assert_eq!((end.energy_error, end.stats, end.t), (alone.energy_error, alone.stats, alone.t));
        }
        assert!(seen == want && seen[0].len() == 4 && seen[0] != seen[1], "{told}");
    }

    /// A chain with details of its own: masses, springs, resonators and contacts that differ; then
    /// also joints, on-site springs and further powers; or dampers, drives and gravity.
    fn detailed(boundary: Boundary, n: usize, kind: &str, size: u32) -> Chain<f64> {
        let size = f64::from(size);
        let chain = Chain::new(Params::new(1.5, 1.0, 0.4).unwrap(), boundary, n).unwrap();
        let of = |count: usize, f: &dyn Fn(f64) -> f64| (0..count).map(|i| f(i as f64 + size)).collect::<Vec<_>>();
        let (bonds, last) = (chain.touching().len(), n - 1);
        let plain = Details {
            mass: of(n, &|x| 1.0 + 0.4 * x.sin()),
            kappa: of(n, &|x| 1.0 + 0.5 * (2.0 * x).sin()),
            rho: (0..n).map(|i| [0.0, 0.4, 0.1 * size, f64::INFINITY][i * i % 4]).collect(),
            contact: of(bonds, &|x| 1.5 + (3.0 * x).sin()),
            overlap: of(bonds, &|x| 0.01 * x.sin()),
            ..Details::default()
        };
        let signal = |size| Signal::sine(size, 1.3, 0.0);
        let details = match kind {
            "held" => Details {
                alpha: of(bonds, &|x| 1.5 + 0.5 * x.sin()),
                terms: vec![Term { contact: vec![0.5; bonds], alpha: 2.5 }],
                onsite: of(n, &|x| (2.0 + x.sin()) / 10.0),
                spring: of(bonds, &|x| (1.5 + x.sin()) / 10.0),
                magnet: of(bonds, &|x| (1.5 + x.sin()) / 100.0),
                distance: vec![2.0; bonds],
                decay: 4.0,
                ..plain
            },
            "open" => Details {
                rho: (0..n).map(|i| if i == 0 { 0.0 } else { 0.1 * size }).collect(),
                drag: (0..n).map(|i| if i == 0 { 0.0 } else { 0.01 * size }).collect(),
                dashpot: (0..n).map(|i| if i == 0 || i % 3 == 1 { 0.0 } else { 0.02 * size }).collect(),
                drives: [(0, DriveKind::Displacement), (last, DriveKind::Force)][..n.min(2)]
                    .iter()
                    .map(|&(site, kind)| Drive { site, kind, signal: signal(0.01 * size) })
                    .collect(),
                gravity: 0.01,
                ..plain
            },
            _ => plain,
        };
        chain.with(&details).unwrap()
    }

    #[test]
    fn beads_that_differ_are_made_together_with_the_bits_of_each_alone() {
        // Truth: each run alone; samples at ends of steps and inside.
        crate::chain::on_every_set(|set| {
            for boundary in Boundary::ALL.into_iter().filter(|&boundary| boundary != Boundary::StrainRing) {
                for (n, kind) in [1, 2, 3, 9].into_iter().flat_map(|n| ["plain", "held", "open"].map(|kind| (n, kind)))
                {
                    for (method, steps) in [("verlet", 91), ("strang-linear", 91), ("aba864", 88)] {
                        let runs = runs(|size| detailed(boundary, n, kind, size), method, 1..8, steps);
                        each_as_alone(&runs, &format!("{set} {boundary:?} {n} {kind} {method}"));
                    }
                }
            }
        });
        // What cannot be made together: spans of their own, other gravity, uniform chains.
        let alone = |runs: &[Run]| assert_eq!(groups(runs, 7)[0].len(), 1);
        alone(&runs(|size| detailed(Boundary::Free, 9, "plain", size), "verlet", 1..8, 90));
        let heavy = |size| Details { gravity: f64::from(size), ..Details::default() };
        let bare = |_| Chain::new(Params::new(1.5, 1.0, 0.4).unwrap(), Boundary::Fixed, 9).unwrap();
        alone(&runs(|size| bare(size).with(&heavy(size)).unwrap(), "verlet", 1..8, 91));
        let one = |size| if size == 1 { bare(size) } else { bare(size).with(&Details::default()).unwrap() };
        alone(&runs(one, "verlet", 1..8, 91));
    }

    #[test]
    fn a_run_that_fails_leaves_the_others_alone_and_others_are_refused_one_by_one() {
        // Truth: each alone. Steps of 0.7 are unstable for Verlet where beads are pressed hard.
        let chain = Chain::new(Params::new(2.5, 4.0, f64::INFINITY).unwrap(), Boundary::Ring, 9).unwrap();
        let chain = |_| chain.clone();
        for method in ["verlet", "corrected"] {
            let mut all = runs(chain, method, 1..4, 10);
            all[1] = runs(chain, method, 100_000..100_001, 10).remove(0);
            let verlet = Method::named("verlet").unwrap();
            all.push(all[0].clone().method(verlet).setting(Setting::Tolerance(1e-3)));
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
}
