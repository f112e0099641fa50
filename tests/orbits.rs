//! Periodic orbits: dark breathers, their multipliers, branches and bifurcations.

use hertzchain::{
    Error,
    breathers::DarkBreather,
    chain::{Boundary, Chain, Field, Overlaps, Params},
    dps::Center,
    integrators::{Gauss, Regularised, Stepper, dop853::Options, regularised::power},
    orbits::{BifurcationKind, Continuation, End, Formulation, Kind, Orbit, Parameter, Shooting, Spectrum},
};
use std::f64::consts::PI;

const THIRD: f64 = 1.0 / 3.0;

fn breather(center: Center, omega_b: f64) -> DarkBreather {
    DarkBreather { params: Params::new(1.5, 1.0, THIRD).unwrap(), center, sites: 41, omega_b, c_x: 0.0 }
}

fn orbit(center: Center, omega_b: f64) -> Orbit {
    breather(center, omega_b).orbit(&Shooting::default()).unwrap()
}

/// `E_b(T)` by a method that shares nothing with collocation, and the largest velocity then, over the amplitude.
fn defect_by_dop853(orbit: &Orbit) -> f64 {
    let chain = || Chain::<f64>::new(orbit.setting.params, Boundary::StrainRing, orbit.setting.sites).unwrap();
    let alpha = orbit.setting.params.alpha;
    let (start, t) = (orbit.start(), orbit.setting.period());
    let mut run = Regularised::new(
        Field::new(chain()),
        Overlaps::new(chain()),
        (alpha, power(alpha, 8)),
        &start,
        (0.0, t),
        Options::new(1e-14),
    )
    .unwrap();
    while !run.done() {
        run.step().unwrap();
    }
    let mut end = start.clone();
    run.sample(t, &mut end);
    start.iter().zip(&end).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / orbit.amplitude()
}

#[test]
fn profiles_are_periodic_for_two_integrators() {
    // Measured: E_b 8e-16 by collocation, 6e-14 by DOP853.
    for center in [Center::Site, Center::Bond] {
        let orbit = orbit(center, 2.05);
        let (e_b, other) = (orbit.e_b(1e-13, 1).unwrap(), defect_by_dop853(&orbit));
        println!("{center:?}: {:e} {e_b:e} {other:e}", orbit.residual);
        assert!(orbit.residual <= 1e-15 && e_b <= 1e-13 && other <= 1e-12);
    }
}

#[test]
fn symmetries_are_those_of_the_center() {
    // Site: x_{-n}(t) = x_n(t + T/2). Bond: x_{1-n}(t) = x_n(t). Measured: 3e-14.
    for center in [Center::Site, Center::Bond] {
        let orbit = orbit(center, 2.05);
        let n = orbit.setting.sites;
        let states = orbit.states(1e-13, &[0.5 * orbit.setting.period()]).unwrap();
        for i in 0..n {
            let (image, ours) = match center {
                Center::Site => (n - 1 - i, &states[0]),
                Center::Bond => ((n - i) % n, &orbit.z),
            };
            assert!((ours[i] - orbit.z[image]).abs() < 1e-12 * orbit.amplitude(), "{center:?}, entry {i}");
        }
    }
}

#[test]
fn newton_converges_quadratically_from_the_dps_seed_in_nine_steps() {
    for center in [Center::Site, Center::Bond] {
        for k in 1..=10 {
            let omega_b = 2.0 + 0.01 * f64::from(k);
            let breather = breather(center, omega_b);
            let orbit = Shooting::default().solve(&breather.setting(), &breather.seed().unwrap()).unwrap();
            let steps: Vec<f64> = orbit.newton.iter().map(|step| step.step).collect();
            println!("{center:?} {omega_b}: {steps:.1e?}");
            assert!(steps.len() <= 9, "{center:?} {omega_b}: {} steps", steps.len());
            let [before, last] = steps[steps.len() - 2..] else { panic!() };
            assert!(last <= 100.0 * before * before + 1e-13, "{center:?} {omega_b}: {before:e} {last:e}");
        }
    }
}

#[test]
fn the_background_is_a_two_degree_of_freedom_oscillator() {
    // X'' = -2 |X|^{1/2} X - (X - Y), rho Y'' = X - Y, shot by bisection of nothing of ours but a Gauss method on two equations.
    let orbit = orbit(Center::Site, 2.05);
    let extent = orbit.extent(1e-13).unwrap();
    let half = 0.5 * orbit.setting.period();
    let end = |x: f64, y: f64| {
        let field = |_: f64, s: &[f64], d: &mut [f64]| {
            let force = 2.0 * s[0].abs().sqrt() * s[0];
            (d[0], d[1], d[2], d[3]) = (s[2], s[3], -force - (s[0] - s[1]), (s[0] - s[1]) / THIRD);
        };
        // A quarter of the period ends at X = 0, Y = 0; the force is not smooth there, so it is not crossed.
        integrate(field, [x, y, 0.0, 0.0], 0.5 * half)
    };
    let (x, y) = (orbit.z[0].abs(), -orbit.z[41].abs());
    let at = end(x, y);
    println!("{at:?} {extent:?}");
    assert!(at[0].abs() < 1e-12 * x && at[1].abs() < 1e-12 * x);
    assert!((extent.k_x - x).abs() < 1e-15 && (extent.k_y + y).abs() < 1e-15 && extent.c_x.abs() < 1e-15);
}

/// The classical fourth-order method with Richardson extrapolation twice: independent of the library.
fn integrate(field: impl Fn(f64, &[f64], &mut [f64]), start: [f64; 4], t: f64) -> [f64; 4] {
    let run = |steps: u32| {
        let h = t / f64::from(steps);
        let mut y = start;
        for _ in 0..steps {
            let slope = |y: &[f64; 4]| {
                let mut d = [0.0; 4];
                field(0.0, y, &mut d);
                d
            };
            let moved = |by: f64, d: &[f64; 4]| -> [f64; 4] { std::array::from_fn(|k| y[k] + by * h * d[k]) };
            let a = slope(&y);
            let b = slope(&moved(0.5, &a));
            let c = slope(&moved(0.5, &b));
            let d = slope(&moved(1.0, &c));
            y = std::array::from_fn(|k| y[k] + h / 6.0 * (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]));
        }
        y
    };
    run(200_000)
}
