//! Kernels of contact collocation: damped motions, and the system of a dissipative force.

use hertzchain_integrators::{
    DoubleDouble,
    collocation::{Path, Response},
    internals::{Flow, solve},
};

fn flow(m: f64, mu: f64, omega: f64, damping: [f64; 2]) -> Flow {
    Flow::new(Response { m, mu, omega: DoubleDouble::new(omega) }, damping)
}

/// Position and velocity of the oscillating part, and of all, along `y` at `t`.
fn at(flow: &Flow, y: Path, t: f64) -> [f64; 2] {
    let ([lag, cos, sin], [v, c, s]) = (flow.position(&[t]), flow.swing(&[t]));
    let position = (y[0] + y[1] * t) + (y[1] * lag[0] + y[2] * cos[0] + y[3] * sin[0]);
    [position, y[1] * v[0] + y[2] * c[0] + y[3] * s[0]]
}

#[test]
fn answers_and_motions_belong_together() {
    // Truth: K(t - s) = e exp(A t) exp(-A s) b; motions over two times are those over their
    // sum; integrals of K by the rule of Gauss.
    let site = flow(0.6, 0.5, 1.7, [0.8, 0.3]);
    let (t, s) = (0.45, 0.17);
    let answer = site.position_and_answer(&[s]).1.map(|x| x[0]);
    // Terms are below 1; each of some ten sums and products rounds by half of 2.2e-16 of its
    // size.
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15 * a.abs().max(b.abs()).max(0.5), "{a:e} {b:e}");
    near(at(&site, answer, t)[0], site.ahead(t - s).ramps[0]);
    let y = [0.3, -0.4, 0.2, 0.7];
    let add = |y: Path, by: Path| std::array::from_fn(|i| y[i] + by[i]);
    let once = add(y, site.moved(&y, t));
    let part: Path = add(y, site.moved(&y, s));
    let twice: Path = add(part, site.moved(&part, t - s));
    for i in 0..4 {
        assert!((once[i] - twice[i]).abs() < 3e-16);
    }
    let [position, swing] = at(&site, y, t);
    let [v, c, s] = site.velocity(&[t]).map(|x| x[0]);
    let velocity = y[1] * v + y[2] * c + y[3] * s;
    assert!((velocity - once[1] - 1.7 * once[3]).abs() < 3e-16);
    assert!((position - once[0] - once[2]).abs() < 2e-16 && (swing - 1.7 * once[3]).abs() < 3e-16);
    let [_, k2, k3] = site.ahead(t).ramps;
    // Three nodes on each of 50 parts err by less than 1e-18.
    let integral = |of: &dyn Fn(f64) -> f64| -> f64 {
        let nodes = [(-1.0, 5.0), (0.0, 8.0), (1.0, 5.0)];
        let points =
            (0..50).flat_map(|k| nodes.map(|(side, weight)| (f64::from(2 * k + 1) + side * 0.6f64.sqrt(), weight)));
        points
            .map(|(x, weight)| (0.01 * t * x, weight / 18.0 * 0.02 * t))
            .map(|(s, w)| w * of(s) * site.ahead(t - s).ramps[0])
            .sum()
    };
    near(k2, integral(&|_| 1.0));
    near(k3, integral(&|s| s));
    // Truth: the integrals themselves, up to the next power.
    let (h, [a, b, c]) = (1e-3, site.ramped([2.0, 3.0, 0.0]));
    let [_, k2, k3] = site.ahead(h).ramps;
    assert!((2.0 * k2 + 3.0 * k3 - h * h * (a + h * (b + h * c))).abs() < 1e-15);
}

#[test]
fn bends_bound_second_derivatives() {
    // Truth: q'' = e A^2 exp(A t) y along the way.
    for (m, mu, damping) in [(0.6, 0.5, [0.8, 0.3]), (0.0, 1.0, [0.0, 4.0]), (1.0, 0.0, [2.0, 0.0])] {
        let site = flow(m, mu, 1.7, damping);
        let y = [0.3, -0.4, if mu > 0.0 { 0.2 } else { 0.0 }, if mu > 0.0 { 0.7 } else { 0.0 }];
        let bound = site.curvature_bound(&y, 1.0);
        for k in 0..=20 {
            let by = site.moved(&y, 0.05 * f64::from(k));
            let now: Path = std::array::from_fn(|i| y[i] + by[i]);
            let curvature = site.rates(&site.rates(&now));
            assert!((curvature[0] + curvature[2]).abs() <= bound * (1.0 + 1e-14));
            assert!(bound < 30.0);
        }
    }
}

#[test]
fn a_system_with_a_small_rest_is_solved() {
    // Truth: the product of the matrix with the solution.
    let mut columns: [[f64; 6]; 6] =
        std::array::from_fn(|k| std::array::from_fn(|j| 0.3 * ((7 * k + 3 * j) as f64).sin()));
    (0..6).for_each(|k| columns[k][k] += 1.0);
    let want: [f64; 6] = std::array::from_fn(|k| (k as f64 - 2.3) * 0.7);
    let product = |j: usize| (0..6).map(|k| columns[k][j] * want[k]).sum();
    let (mut matrix, mut x) = (columns, std::array::from_fn(product));
    solve(&mut matrix, &mut x);
    for k in 0..6 {
        assert!((x[k] - want[k]).abs() < 4e-15, "{:e}", x[k] - want[k]);
    }
}
