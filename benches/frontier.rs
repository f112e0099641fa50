//! Error against run time beside the loops that anybody would write: for each decade of error the
//! fastest plain loop, the fastest method of hertzchain, and the ratio of their times.
//!
//! Plain loops are velocity Verlet, and the exact rotation of resonators with kicks of the
//! contacts, each as Strang's scheme and as Yoshida's of order four: a loop over bonds, loops over
//! sites, compiled for the same vector instructions as the library. DOP853 across contacts stands for the
//! solver that anybody would call; it is ours, as the published crates bring another `nalgebra`.
//!
//! Steps go in factors of two, tolerances in factors of ten. Errors are those of `compare`: strains
//! at the end, over the amplitude. All times are medians from one process; start-up is in them.
//! `cargo bench --bench frontier -- points` prints every run.

use hertzchain::{
    Boundary, Chain, Method, Run, Scene,
    integrators::{Kernel, Real},
    run::Setting,
};
use std::time::Instant;

/// Kicks a period on the coarsest rung; each has twice those of the one before.
const COARSEST: f64 = 8.0;
const RUNGS: i32 = 14;
/// Longest run of a ladder, in seconds, and the error below which it ends.
const LONGEST: f64 = 0.4;
const FINE: f64 = 3e-12;
const DECADES: std::ops::RangeInclusive<i32> = 1..=10;

/// Sites with contacts and resonators in plain arrays.
#[derive(Clone)]
struct Plain {
    boundary: Boundary,
    kappa: f64,
    rho: f64,
    u: Vec<f64>,
    v: Vec<f64>,
    u_dot: Vec<f64>,
    v_dot: Vec<f64>,
    /// Forces of bonds, with one more on either side.
    force: Vec<f64>,
}

impl Plain {
    fn new(chain: &Chain<f64>, y: &[f64]) -> Self {
        let (layout, n, params) = (chain.layout(), chain.sites(), chain.params());
        let of = |array: Option<&[f64]>| array.map_or_else(|| vec![0.0; n], <[f64]>::to_vec);
        Self {
            boundary: chain.boundary(),
            kappa: params.kappa,
            rho: params.rho,
            u: layout.u(y).to_vec(),
            v: of(layout.v(y)),
            u_dot: layout.u_dot(y).to_vec(),
            v_dot: of(layout.v_dot(y)),
            force: vec![0.0; n + 3],
        }
    }

    /// `force[1 + b]` of the bond to the left of bead `b`.
    #[inline(always)]
    fn forces(&mut self) {
        let n = self.u.len();
        let law = |g: f64| g * g.max(0.0).sqrt();
        let (u, f) = (&self.u[..n], &mut self.force[1..n + 2]);
        if self.boundary == Boundary::StrainRing {
            for i in 0..n {
                f[i] = law(-u[i]);
            }
            (f[n], self.force[0]) = (f[0], f[n - 1]);
            return;
        }
        for i in 1..n {
            f[i] = law(u[i - 1] - u[i]);
        }
        (f[0], f[n]) = match self.boundary {
            Boundary::Fixed => (law(-u[0]), law(u[n - 1])),
            _ => (0.0, 0.0),
        };
    }

    #[inline(always)]
    fn kick(&mut self, h: f64, springs: bool) {
        self.forces();
        if self.boundary == Boundary::StrainRing {
            self.pushed::<true>(h, springs);
        } else {
            self.pushed::<false>(h, springs);
        }
    }

    #[inline(always)]
    fn pushed<const STRAIN: bool>(&mut self, h: f64, springs: bool) {
        let n = self.u.len();
        let (u_dot, v_dot) = (&mut self.u_dot[..n], &mut self.v_dot[..n]);
        let (f0, f1, f2) = (&self.force[..n], &self.force[1..n + 1], &self.force[2..n + 2]);
        for i in 0..n {
            u_dot[i] += h * if STRAIN { (f1[i] - f0[i]) - (f2[i] - f1[i]) } else { f1[i] - f2[i] };
        }
        if springs && self.kappa > 0.0 {
            let (kick, kick_v) = (h * self.kappa, h * self.kappa / self.rho);
            let (u, v) = (&self.u[..n], &self.v[..n]);
            for i in 0..n {
                let d = u[i] - v[i];
                u_dot[i] -= kick * d;
                v_dot[i] += kick_v * d;
            }
        }
    }

    #[inline(always)]
    fn straight(&mut self, h: f64) {
        for (u, u_dot) in self.u.iter_mut().zip(&self.u_dot) {
            *u += h * u_dot;
        }
        if self.kappa > 0.0 {
            for (v, v_dot) in self.v.iter_mut().zip(&self.v_dot) {
                *v += h * v_dot;
            }
        }
    }

    /// The exact motion of beads with resonators: the centre of mass is free, the stretch turns.
    #[inline(always)]
    fn turn(&mut self, h: f64, (sin, cos): (f64, f64), omega: f64) {
        let n = self.u.len();
        let (of_u, of_v) = (self.rho / (1.0 + self.rho), 1.0 / (1.0 + self.rho));
        let (slow, fast) = (sin / omega, omega * sin);
        let (u, v) = (&mut self.u[..n], &mut self.v[..n]);
        let (u_dot, v_dot) = (&mut self.u_dot[..n], &mut self.v_dot[..n]);
        for i in 0..n {
            let (r, r_dot) = (of_v * u[i] + of_u * v[i], of_v * u_dot[i] + of_u * v_dot[i]);
            let (d, d_dot) = (u[i] - v[i], u_dot[i] - v_dot[i]);
            let (d, d_dot, r) = (d * cos + d_dot * slow, d_dot * cos - d * fast, r + h * r_dot);
            (u[i], v[i]) = (r + of_u * d, r - of_v * d);
            (u_dot[i], v_dot[i]) = (r_dot + of_u * d_dot, r_dot - of_v * d_dot);
        }
    }
}

/// A plain loop: a composition of Strang steps, on one of both splits.
#[derive(Clone, Copy)]
struct Loop {
    name: &'static str,
    turns: bool,
    shares: &'static [f64],
}

/// `1/(2 - 2^{1/3})` and `1 - 2/(2 - 2^{1/3})`.
const YOSHIDA: [f64; 3] = [1.351_207_191_959_657_6, -1.702_414_383_919_315_3, 1.351_207_191_959_657_6];

const LOOPS: [Loop; 4] = [
    Loop { name: "Verlet", turns: false, shares: &[1.0] },
    Loop { name: "rotation + kick", turns: true, shares: &[1.0] },
    Loop { name: "Yoshida 4", turns: false, shares: &YOSHIDA },
    Loop { name: "rotation, Yoshida 4", turns: true, shares: &YOSHIDA },
];

struct Steps<'a> {
    of: Loop,
    sites: &'a mut Plain,
    h: f64,
    steps: u64,
}

impl Kernel for Steps<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { of: Loop { turns, shares, .. }, sites, h, steps } = self;
        let omega = (sites.kappa * (1.0 + 1.0 / sites.rho)).sqrt();
        let turns = turns && sites.kappa > 0.0;
        // Drifts of half a share each, of which two meet between kicks.
        let mut drifts: Vec<f64> = shares.windows(2).map(|pair| 0.5 * h * (pair[0] + pair[1])).collect();
        drifts.push(h * 0.5 * (shares[0] + shares[shares.len() - 1]));
        let angles: Vec<(f64, f64)> = drifts.iter().map(|dt| (omega * dt).sin_cos()).collect();
        let half = 0.5 * h * shares[0];
        let ends = (omega * half).sin_cos();
        macro_rules! drift {
            ($dt:expr, $angle:expr) => {
                if turns { sites.turn($dt, $angle, omega) } else { sites.straight($dt) }
            };
        }
        drift!(half, ends);
        for step in 0..steps {
            for (k, share) in shares.iter().enumerate() {
                sites.kick(h * share, !turns);
                if step + 1 < steps || k + 1 < shares.len() {
                    drift!(drifts[k], angles[k]);
                }
            }
        }
        drift!(half, ends);
    }
}

/// Error and median time of one setting.
struct Point {
    name: String,
    error: f64,
    seconds: f64,
}

/// The scene, and what errors are measured against.
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

    /// Runs finer and finer settings until they take too long or are exact.
    fn ladder<S: Copy>(
        &self,
        name: &str,
        settings: impl Iterator<Item = S>,
        run: impl Fn(S) -> Option<Vec<f64>>,
    ) -> Vec<Point> {
        let mut points = Vec::new();
        for setting in settings {
            let mut times = [0.0; 3];
            let mut end = None;
            for time in &mut times {
                let clock = Instant::now();
                end = run(setting);
                *time = clock.elapsed().as_secs_f64();
            }
            times.sort_by(f64::total_cmp);
            let Some(end) = end else { continue };
            let error = self.error(&self.scene.strains(&end));
            points.push(Point { name: name.to_owned(), error, seconds: times[1] });
            if times[1] > LONGEST || error < FINE {
                break;
            }
        }
        points
    }

    fn plain(&self) -> Vec<Point> {
        let (scene, chain) = (&self.scene, self.scene.chain());
        let mut points = self.method("dop853");
        for of in LOOPS {
            points.extend(self.ladder(of.name, (0..RUNGS).map(|k| COARSEST * 2f64.powi(k)), |kicks| {
                let steps = (kicks * scene.end() / scene.period() / of.shares.len() as f64).round().max(1.0) as u64;
                let mut sites = Plain::new(chain, scene.initial().as_slice());
                f64::run(Steps { of, sites: &mut sites, h: scene.end() / steps as f64, steps });
                let Plain { u, v, u_dot, v_dot, .. } = sites;
                let parts = if chain.layout().resonators() { vec![u, v, u_dot, v_dot] } else { vec![u, u_dot] };
                Some(parts.concat())
            }));
        }
        points
    }

    fn method(&self, name: &str) -> Vec<Point> {
        let (scene, method) = (&self.scene, Method::named(name).unwrap());
        let run = |setting: Setting| {
            let run: Run = scene.run().method(method).setting(setting).samples(0).ok()?;
            run.start().ok()?.complete().ok().map(|end| end.state)
        };
        if method.adaptive() {
            return self.ladder(name, (1..=14).map(|k| Setting::Tolerance(10f64.powi(-k))), run);
        }
        let steps = |k: i32| COARSEST * 2f64.powi(k) * scene.end() / scene.period() / method.stages() as f64;
        self.ladder(name, (0..RUNGS).map(|k| Setting::Steps(steps(k).round().max(1.0) as u64)), run)
    }

    fn ours(&self) -> Vec<Point> {
        let names: Vec<String> = Method::telling().iter().map(Method::name).filter(|name| name != "dop853").collect();
        names.iter().flat_map(|name| self.method(name)).collect()
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
    for scene in scenes {
        let problem = Problem::new(scene.expect("a built-in scene"));
        let (plain, ours) = (problem.plain(), problem.ours());
        if std::env::args().any(|argument| argument == "points") {
            for Point { name, error, seconds } in plain.iter().chain(&ours) {
                println!("{name:24} {error:9.1e} {:10.3} ms", 1e3 * seconds);
            }
        }
        println!("{} ({} sites)", problem.scene.name(), problem.scene.chain().sites());
        println!("{:>6}  {:22} {:>10}  {:24} {:>10} {:>7}", "error", "plain loop", "ms", "hertzchain", "ms", "ratio");
        for decade in DECADES {
            let error = 10f64.powi(-decade);
            let (theirs, best) = (fastest(&plain, error), fastest(&ours, error).expect("collocation reaches all"));
            let (name, ms) = theirs.map_or(("-", f64::NAN), |point| (point.name.as_str(), 1e3 * point.seconds));
            let (our_ms, ratio) = (1e3 * best.seconds, ms / (1e3 * best.seconds));
            println!("{error:6.0e}  {name:22} {ms:10.3}  {:24} {our_ms:10.3} {ratio:7.2}", best.name);
        }
    }
}
