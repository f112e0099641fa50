//! Error against run time beside the loops that anybody would write: for each decade of error the
//! fastest plain loop, the fastest method of hertzchain, and the ratio of their times.
//!
//! Plain loops are those of `hertzchain::plain`: velocity Verlet, and the exact rotation of
//! resonators with kicks of the contacts, each as Strang's scheme and as Yoshida's of order four.
//! DOP853 across contacts stands for a general-purpose solver. It is the one of hertzchain, since
//! the published crates bring another `nalgebra`.
//!
//! Every instruction set of the machine is timed, plain loops and methods with the same one.
//!
//! Steps go in factors of two, tolerances in factors of ten. Errors are those of strains at the
//! end, over the amplitude of the scene or else the largest strain. Times are medians of three runs
//! in one process and include the set-up of a run. The last ratio of a set is that of a member of
//! [`MEMBERS`] runs by splittings on one core, of short chains side by side.
//! `cargo bench --bench frontier -- points` prints every run.

use hertzchain::{
    Method, Run, Scene,
    integrators::instructions::Instructions,
    plain::{Loop, Sites},
    run::{Setting, start_all},
};
use std::time::Instant;

/// Kicks a period on the coarsest rung of a ladder; each rung has twice those of the one before.
const COARSEST: f64 = 8.0;
const RUNGS: i32 = 14;
/// A ladder ends with the first run that takes more than `LONGEST` seconds, but for its coarsest
/// rung, or has an error below `FINE`.
const LONGEST: f64 = 0.4;
const FINE: f64 = 3e-12;
/// Runs of a batch.
const MEMBERS: usize = 64;
const DECADES: std::ops::RangeInclusive<i32> = 1..=10;

/// Error and median time of one setting.
struct Point {
    name: String,
    error: f64,
    seconds: f64,
}

/// A scene, its strains at the end as the reference, and the amplitude that errors are divided by.
struct Problem {
    scene: Scene,
    reference: Vec<f64>,
    amplitude: f64,
}

impl Problem {
    fn new(scene: Scene) -> Self {
        let end = |tol: f64| scene.run().method(Method::Collocation).tolerance(tol).unwrap().start().unwrap().state;
        let (reference, other) = (scene.strains(&end(1e-14)), scene.strains(&end(1e-12)));
        let largest = reference.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        let problem = Self { amplitude: scene.amplitude().unwrap_or(largest), scene, reference };
        assert!(problem.error(&other) < 1e-11, "references differ by {:e}", problem.error(&other));
        problem
    }

    fn error(&self, strains: &[f64]) -> f64 {
        let gaps = strains.iter().zip(&self.reference).map(|(a, b)| (a - b).abs());
        // A run that blew up has no error that could be compared.
        gaps.fold(0.0, |most: f64, gap| if gap.is_nan() { f64::INFINITY } else { most.max(gap) }) / self.amplitude
    }

    /// Runs finer and finer settings, each of which makes so many members at once, up to the first
    /// that takes longer than [`LONGEST`] or has an error below [`FINE`]. Times are those a member.
    fn ladder<S: Copy>(
        &self,
        name: &str,
        settings: impl Iterator<Item = S>,
        members: usize,
        run: impl Fn(S) -> Option<Vec<f64>>,
    ) -> Vec<Point> {
        let mut points = Vec::new();
        for setting in settings {
            let mut times = [0.0; 3];
            let mut end = None;
            for time in &mut times {
                let clock = Instant::now();
                end = run(setting);
                *time = clock.elapsed().as_secs_f64() / members as f64;
            }
            times.sort_by(f64::total_cmp);
            let Some(end) = end else { continue };
            let error = self.error(&self.scene.strains(&end));
            points.push(Point { name: name.to_owned(), error, seconds: times[1] });
            if points.len() > 1 && times[1] * members as f64 > LONGEST || error < FINE {
                break;
            }
        }
        points
    }

    fn plain(&self) -> Vec<Point> {
        let (scene, chain) = (&self.scene, self.scene.chain());
        let mut points = self.method("dop853", 1);
        for of in Loop::ALL {
            points.extend(self.ladder(of.name, (0..RUNGS).map(|k| COARSEST * 2f64.powi(k)), 1, |kicks| {
                let steps = (kicks * scene.end() / scene.period() / of.kicks() as f64).round().max(1.0) as u64;
                let mut sites = Sites::new(chain, scene.initial().as_slice());
                of.run(&mut sites, scene.end() / steps as f64, steps);
                Some(sites.state())
            }));
        }
        points
    }

    fn method(&self, name: &str, members: usize) -> Vec<Point> {
        let (scene, method) = (&self.scene, Method::named(name).unwrap());
        let run = |setting: Setting| {
            let run: Run = scene.run().method(method).setting(setting).samples(0).ok()?;
            let ends = start_all(&vec![run; members], &mut |_, _, _| ());
            ends.into_iter().next()?.ok()?.complete().ok().map(|end| end.state)
        };
        if method.adaptive() {
            return self.ladder(name, (1..=14).map(|k| Setting::Tolerance(10f64.powi(-k))), members, run);
        }
        let steps = |k: i32| COARSEST * 2f64.powi(k) * scene.end() / scene.period() / method.info().stages as f64;
        self.ladder(name, (0..RUNGS).map(|k| Setting::Steps(steps(k).round().max(1.0) as u64)), members, run)
    }

    /// Our methods, by one run or by several, of which only splittings are made side by side.
    fn ours(&self, members: usize) -> Vec<Point> {
        let methods = Method::default_comparison_set().into_iter();
        let methods = methods.filter(|method| members == 1 || matches!(method, Method::Splitting(..)));
        let names = methods.map(|method| method.name()).filter(|name| name != "dop853");
        names.flat_map(|name| self.method(&name, members)).collect()
    }
}

/// The fastest point whose error is at most `error`.
fn fastest(points: &[Point], error: f64) -> Option<&Point> {
    points.iter().filter(|point| point.error <= error).min_by(|a, b| a.seconds.total_cmp(&b.seconds))
}

fn main() {
    if std::env::args().any(|argument| ["--test", "--list"].contains(&argument.as_str())) {
        return;
    }
    let scenes = [
        Scene::load("tw-q15"),
        Scene::load_with("impact", &["chain.sites=1000".into(), "span.until=300".into()]),
        Scene::load("bright-breather-16"),
    ];
    let sets = || Instructions::ALL.into_iter().filter(|set| set.available());
    for scene in scenes {
        let problem = Problem::new(scene.expect("a built-in scene"));
        let of = |set: Instructions| {
            assert!(set.select(), "a set of this machine");
            (problem.plain(), problem.ours(1), problem.ours(MEMBERS))
        };
        let timed: Vec<_> = sets().map(|set| (set, of(set))).collect();
        if std::env::args().any(|argument| argument == "points") {
            for (set, (plain, ours, batch)) in &timed {
                for Point { name, error, seconds } in plain.iter().chain(ours).chain(batch) {
                    println!("{set:8} {name:26} {error:9.1e} {:10.3} ms", 1e3 * seconds);
                }
            }
        }
        println!("{} ({} sites)", problem.scene.name(), problem.scene.chain().sites());
        print!("{:>6}", "error");
        timed.iter().for_each(|(set, _)| {
            print!("  {:24} {:>9} {:>9} {:>6} {:>6}", set.to_string(), "plain ms", "ms", "ratio", "of 64")
        });
        for decade in DECADES {
            let error = 10f64.powi(-decade);
            print!("\n{error:6.0e}");
            for (_, (plain, ours, batch)) in &timed {
                let ms = |of: Option<&Point>| of.map_or(f64::NAN, |point| 1e3 * point.seconds);
                let (theirs, best) = (ms(fastest(plain, error)), fastest(ours, error));
                let (name, ms) = (best.map_or("-", |point| &point.name), ms(best));
                let of_batch = theirs / 1e3 / fastest(batch, error).map_or(f64::NAN, |point| point.seconds);
                print!("  {name:24} {theirs:9.3} {ms:9.3} {:6.2} {of_batch:6.2}", theirs / ms);
            }
        }
        println!();
    }
}
