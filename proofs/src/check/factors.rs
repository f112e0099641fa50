//! Chapter: the factors `l_k` of perturbations ("Multipliers" in `README.md`).
//!
//! What depends on the parameter `s` of a piece, `-1 <= s <= 1`, is `u_0 + u_1 s` and a rest.

use super::{
    System, of,
    perturbed::Perturbations,
    system::{half_angle, poles},
};
use crate::{
    certificate::{Bloch, Certificate, Orbit},
    interval::Interval,
};

/// Real and imaginary part.
type Complex = [Interval; 2];
/// By harmonic real parts of `a` and `b`, and their imaginary parts: `l` takes cosines and sines
/// `c`, `s` to `a c - b s`, `b c + a s`.
pub(crate) type Factors = [Vec<Interval>; 4];

/// `2 a = l_k + l_{-k}` and `2 b = i (l_k - l_{-k})`, from pairs of these by harmonic.
fn parts(pairs: impl Iterator<Item = [Complex; 2]>) -> Factors {
    let mut parts = [const { Vec::new() }; 4];
    for [[re, im], [other_re, other_im]] in pairs {
        let twice = [re + other_re, other_im - im, im + other_im, re - other_re];
        parts.iter_mut().zip(twice).for_each(|(part, twice)| part.push(twice / of(2)));
    }
    parts
}

const ZERO: Complex = [Interval::ZERO; 2];

/// A multiple.
fn scaled(by: Interval, of: Complex) -> Complex {
    of.map(|it| by * it)
}

/// Their sum.
fn plus([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a + c, b + d]
}

/// Their product.
fn times([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a * c - b * d, a * d + b * c]
}

/// `1/z`.
fn inverse([a, b]: Complex) -> Complex {
    let size = a.square() + b.square();
    [a / size, -b / size]
}

/// `[u_0, u_1, rest]`.
type Linear = [Complex; 3];

/// All values along a piece.
fn along(u: Linear) -> Complex {
    plus(plus(u[0], scaled(Interval::ONE.ball(), u[1])), u[2])
}

fn product(u: Linear, v: Linear) -> Linear {
    let square = scaled(Interval::new(0.0, 1.0), times(u[1], v[1]));
    let rest = plus(times(along([u[0], u[1], ZERO]), v[2]), times(u[2], along(v)));
    [times(u[0], v[0]), plus(times(u[0], v[1]), times(u[1], v[0])), plus(square, rest)]
}

/// `1/u = v + (1 - u v)/u` for the linear part `v`.
fn reciprocal(u: Linear) -> Linear {
    let value = inverse(u[0]);
    let slope = scaled(-Interval::ONE, times(u[1], times(value, value)));
    let left = plus([Interval::ONE, Interval::ZERO], scaled(-Interval::ONE, along(product(u, [value, slope, ZERO]))));
    [value, slope, times(left, inverse(along(u)))]
}

/// `1/L(s)`.
fn law(poles: &[[Interval; 3]], s: Linear) -> Linear {
    poles.iter().fold([ZERO; 3], |sum, &[c, p, r]| {
        let [first, second, rest] = product(s, s).map(|it| scaled(r, it));
        let term = reciprocal([plus(first, [p, Interval::ZERO]), second, rest]);
        [0, 1, 2].map(|i| plus(sum[i], scaled(c, term[i])))
    })
}

/// `l_k` up to `K'`, for these growth rates.
pub fn rated(certificate: &Certificate, it: &Perturbations, rate: Interval) -> Factors {
    let poles = poles(&certificate.model);
    let pair = |k: usize| {
        let s = [rate, of(2 * k + it.odd) / of(2) * it.system.omega()];
        let [re, im] = law(&poles, [s, ZERO, ZERO])[0];
        [[re, im], [re, -im]]
    };
    parts((0..it.system.factors.len()).map(pair))
}

/// Factors at `lambda_0 + lambda_1 s`: `u_0`, `u_1` and the rest; their derivatives by `lambda`,
/// and all values, where `lambda` is at most the radius of the piece away in real and imaginary
/// part.
///
/// `4 sin^2` of half of `a + h s` is `4 sin^2(a/2) + h s 2 sin a`, and a rest of at most `h^2`.
pub fn modulated(certificate: &Certificate, system: &System, piece: &Bloch, rate: [Complex; 2]) -> [Factors; 5] {
    let (poles, [from, to]) = (poles(&certificate.model), piece.p_over_pi.map(|p| p.enclosed() * Interval::PI));
    let (quarter, half, near) = ((from + to) / of(4), (to - from) / of(2), [piece.radius.enclosed().ball(); 2]);
    let factor = |k: usize, sign: i128| {
        let turn = Interval::exact(sign as f64) * of(k) * system.omega();
        let Orbit::Wave { q_over_pi } = certificate.orbit else { return [[Interval::exact(f64::NAN); 2]; 5] };
        let [sin, cos] = (quarter + half_angle(q_over_pi, -sign * k as i128)).sin_cos();
        let lattice = [of(4) * sin.square(), of(4) * half * sin * cos, half.square().ball()];
        let lattice = lattice.map(|it| [it, Interval::ZERO]);
        let s = [plus(rate[0], [Interval::ZERO, turn]), rate[1], ZERO];
        let value = product(lattice, law(&poles, s));
        // The slope of what is linear with the slope 1, for all values.
        let [_, slope, _] = law(&poles, [plus(along(s), near), [Interval::ONE, Interval::ZERO], ZERO]);
        let slope = times(along(lattice), slope);
        [value[0], value[1], value[2], slope, plus(along(value), times(slope, near))]
    };
    // Two more than K': by Cauchy's bound in a disc of radius omega derivatives beyond have the
    // tail of l over omega.
    let all: Vec<_> = (0..=system.factors.len() + 1).map(|k| [1, -1].map(|sign| factor(k, sign))).collect();
    [0, 1, 2, 3, 4].map(|i| parts(all.iter().map(|both| both.map(|one| one[i]))))
}
