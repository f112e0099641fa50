//! The constants of a panel with `M` nodes: Gauss nodes, weights, and the matrices that integrate
//! and interpolate between the nodes.

use super::series::MONOMIAL;

use std::{any::Any, sync::OnceLock};

/// Numbers of nodes that a panel may have; all loops over nodes are compiled for each, and run over
/// whole registers of four numbers. Six and ten nodes take about the time of eight and twelve.
/// Shorter windows resolve at less cost what more nodes would; `run --windows-per-period N --nodes
/// M` shows both.
pub(crate) const NODES: [usize; 3] = [4, 8, MOST_NODES];
/// The difference between two of these numbers.
pub(crate) const NODES_APART: usize = 4;
pub(crate) const MOST_NODES: usize = 12;

/// Gauss-Legendre collocation with `M` nodes on `[-1, 1]`; `l_k` are the Lagrange polynomials of
/// the nodes.
///
/// Matrices are kept by columns, so that products run over nodes in vector registers.
#[derive(Clone, Debug)]
pub(crate) struct Rule<const M: usize> {
    /// Nodes, ascending.
    pub(crate) nodes: [f64; M],
    /// Weights: `int_{-1}^{1} l_k`.
    pub(crate) weights: [f64; M],
    /// `integral[k][j] = int_{-1}^{x_j} l_k`.
    pub(crate) integral: [[f64; M]; M],
    /// `series[k][i]`: the coefficient of the Chebyshev polynomial `T_i` in `l_k`, or of `x^i` for
    /// `M` up to [`MONOMIAL`].
    pub(crate) series: [[f64; M]; M],
    /// Rows by which values at the nodes give the last two Chebyshev coefficients.
    pub(crate) tail: [[f64; M]; 2],
    /// `l_k(-1)` and `l_k(1)`.
    pub(crate) ends: [[f64; M]; 2],
}

/// `P_0(x) .. P_{N}(x)` by their recursion.
fn legendre(n: usize, x: f64) -> Vec<f64> {
    let mut p = vec![1.0, x];
    for k in 1..n {
        let k_f = k as f64;
        p.push(((2.0 * k_f + 1.0) * x * p[k] - k_f * p[k - 1]) / (k_f + 1.0));
    }
    p
}

impl<const M: usize> Rule<M> {
    /// The rule, computed at the first call and kept, since programs may do thousands of short
    /// runs.
    pub(crate) fn shared() -> &'static Self {
        // A static cannot be generic: it has one entry for each number of nodes.
        static RULES: [OnceLock<Box<dyn Any + Send + Sync>>; MOST_NODES + 1] =
            [const { OnceLock::new() }; MOST_NODES + 1];
        let rule = RULES[M].get_or_init(|| Box::new(Self::new()));
        rule.downcast_ref().expect("a rule is kept by its number of nodes")
    }

    pub(crate) fn new() -> Self {
        let nodes: [f64; M] = std::array::from_fn(node::<M>);
        // Discrete orthogonality: l_k = sum_i (2 i + 1)/2 w_k P_i(x_k) P_i.
        let p: Vec<Vec<f64>> = nodes.iter().map(|&x| legendre(M + 1, x)).collect();
        let weights: [f64; M] = std::array::from_fn(|k| {
            let slope = M as f64 * p[k][M - 1] / (1.0 - nodes[k] * nodes[k]);
            2.0 / ((1.0 - nodes[k] * nodes[k]) * slope * slope)
        });
        let share = |i: usize, k: usize| (i as f64 + 0.5) * weights[k] * p[k][i];
        let expand = |k: usize, value: &dyn Fn(usize) -> f64| (0..M).map(|i| share(i, k) * value(i)).sum::<f64>();
        // int_{-1}^{x} P_i = (P_{i+1} - P_{i-1}) / (2 i + 1); x + 1 for i = 0.
        let antiderivative = |i: usize, j: usize| match i {
            0 => nodes[j] + 1.0,
            _ => (p[j][i + 1] - p[j][i - 1]) / (2 * i + 1) as f64,
        };
        let integral = std::array::from_fn(|k| std::array::from_fn(|j| expand(k, &|i| antiderivative(i, j))));
        // Chebyshev coefficients from values at Chebyshev points.
        let angle = |n: usize| std::f64::consts::PI * (n as f64 + 0.5) / M as f64;
        let at_points: Vec<Vec<f64>> = (0..M).map(|n| legendre(M + 1, angle(n).cos())).collect();
        let chebyshev = |i: usize, k: usize| {
            let sum: f64 = (0..M).map(|n| expand(k, &|d| at_points[n][d]) * (i as f64 * angle(n)).cos()).sum();
            sum * if i == 0 { 1.0 } else { 2.0 } / M as f64
        };
        let mut series: [[f64; M]; M] = std::array::from_fn(|k| std::array::from_fn(|i| chebyshev(i, k)));
        let tail = [1, 2].map(|i| std::array::from_fn(|k| series[k][M - i]));
        if M <= MONOMIAL {
            for column in &mut series {
                *column = powers(column);
            }
        }
        let sign = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let ends = [std::array::from_fn(|k| expand(k, &sign)), std::array::from_fn(|k| expand(k, &|_| 1.0))];
        Self { nodes, weights, integral, series, tail, ends }
    }
}

/// Converts a series in Chebyshev polynomials into one in powers of `x`.
fn powers<const M: usize>(chebyshev: &[f64; M]) -> [f64; M] {
    let mut out = [0.0; M];
    let (mut t0, mut t1) = ([0.0; M], [0.0; M]);
    t0[0] = 1.0;
    t1[1 % M] = 1.0;
    for &c in chebyshev {
        for j in 0..M {
            out[j] += c * t0[j];
        }
        let next = std::array::from_fn(|j| if j == 0 { 0.0 } else { 2.0 * t1[j - 1] } - t0[j]);
        (t0, t1) = (t1, next);
    }
    out
}

/// The `k`-th zero of `P_M` in ascending order, by Newton's method.
fn node<const M: usize>(k: usize) -> f64 {
    let mut x = -f64::cos(std::f64::consts::PI * (k as f64 + 0.75) / (M as f64 + 0.5));
    for _ in 0..8 {
        let p = legendre(M, x);
        let slope = M as f64 * (p[M - 1] - x * p[M]) / (1.0 - x * x);
        x -= p[M] / slope;
    }
    x
}
