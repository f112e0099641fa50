//! Hurwitz' zeta function `zeta(-z, theta)` for `z >= 0`, and tables of it for one exponent.

use super::pack::Pack;
use crate::real::Vector;

/// `B_2, B_4, ..` over `2!, 4!, ..`: the coefficients of the formula of Euler and Maclaurin.
const BERNOULLI: [f64; 12] = [
    1.0 / 12.0,
    -1.0 / 720.0,
    1.0 / 30_240.0,
    -1.0 / 1_209_600.0,
    1.0 / 47_900_160.0,
    -691.0 / 1_307_674_368_000.0,
    1.0 / 74_724_249_600.0,
    -3617.0 / 10_670_622_842_880_000.0,
    43_867.0 / 5_109_094_217_170_944_000.0,
    -174_611.0 / 802_857_662_698_291_200_000.0,
    77_683.0 / 14_101_100_039_391_805_440_000.0,
    -236_364_091.0 / 1_693_824_136_731_743_669_452_800_000.0,
];

/// The argument from which the asymptotic series is exact to rounding.
const FAR: f64 = 7.0;

/// Hurwitz' zeta function `zeta(-z, a)` for `z > -1` and `a > 0`: the finite part of `sum_{k >= 0}
/// (a + k)^z`.
///
/// Terms up to `a + k >= 7` are summed, the rest is the series of Euler and Maclaurin, whose first
/// omitted term is there below `1e-16` of the first. The absolute error is a rounding of `7^{z+1}`:
/// 3e-14 at `z = 3/2`, 2e-12 at `z = 9/2`.
///
/// ```
/// use hertzchain_integrators::splitting::hurwitz;
/// // Riemann's zeta(-3/2), and the polynomial of Bernoulli -B_3(x)/3 with B_3 = x^3 - 3 x^2/2 + x/2.
/// assert!((hurwitz(1.5, 1.0) + 0.025_485_201_889_833_035).abs() < 1e-13);
/// assert!((hurwitz(2.0, 0.25) + (0.015_625 - 0.093_75 + 0.125) / 3.0).abs() < 1e-13);
/// ```
///
/// Source: NIST Digital Library of Mathematical Functions, 25.11.
pub fn hurwitz(z: f64, a: f64) -> f64 {
    zetas::<1>(z, a)[0]
}

/// The same for `z, z + 1, ..`, from the same powers.
fn zetas<const COUNT: usize>(z: f64, mut x: f64) -> [f64; COUNT] {
    let (mut sums, mut far) = ([0.0; COUNT], false);
    while !far {
        far = x >= FAR;
        let mut power = x.powf(z);
        for (k, sum) in sums.iter_mut().enumerate() {
            *sum += if far { tail(z + k as f64, x, power) } else { power };
            power *= x;
        }
        x += 1.0;
    }
    sums
}

/// The series of Euler and Maclaurin, where `power` is `x^z`.
fn tail(z: f64, x: f64, power: f64) -> f64 {
    let mut tail = -x * power / (z + 1.0) + 0.5 * power;
    // z (z-1) .. (z-2j+2) x^{z-2j+1}
    let mut derivative = z * power / x;
    for (j, coefficient) in BERNOULLI.iter().enumerate() {
        tail -= coefficient * derivative;
        let m = z - (2 * j) as f64;
        derivative *= (m - 1.0) * (m - 2.0) / (x * x);
    }
    tail
}

/// Nodes of a table: the singularity of `zeta(-z, 1 + theta)` nearest to `[0, 1]` lies at -1, so
/// that coefficients fall by 5.8 a degree: to 3e-12 of the first.
const DEGREE: usize = 15;

/// Zeta functions of one exponent, `zeta(-alpha - k, 1 + theta)` for `k = -1 .. 2`, as polynomials
/// on `[0, 1]`.
#[derive(Clone, Debug)]
pub(super) struct ZetaTable {
    /// Coefficients of the powers of `2 theta - 1`, by power.
    powers: [[f64; ZetaTable::COUNT]; DEGREE + 1],
}

impl ZetaTable {
    /// Number of functions.
    pub(super) const COUNT: usize = 4;

    /// The table of an exponent.
    pub(super) fn new(alpha: f64) -> Self {
        let series = chebyshev::<{ Self::COUNT }, _>(|x| zetas(alpha - 1.0, 1.5 + 0.5 * x)).map(to_powers);
        Self { powers: std::array::from_fn(|power| series.map(|series| series[power])) }
    }

    /// `zeta(-alpha - k, 1 + theta)` for `k = -1 .. 2`, `theta` in `[0, 1]`.
    #[inline(always)]
    pub(super) fn beyond<V: Vector<f64>>(&self, theta: Pack<V>) -> [Pack<V>; Self::COUNT] {
        let x = theta * 2.0 - 1.0;
        let square = x * x;
        let fourth = square * square;
        let (quads, _) = self.powers.as_chunks::<4>();
        let (last, others) = quads.split_last().expect("powers");
        let mut zeta = [Pack::all(0.0); Self::COUNT];
        for k in 0..Self::COUNT {
            // Four sums over every fourth power, of which none waits for another. They are no
            // array, and there is no closure: so they stay in the registers of the kernel.
            let (mut s0, mut s1) = (Pack::all(last[0][k]), Pack::all(last[1][k]));
            let (mut s2, mut s3) = (Pack::all(last[2][k]), Pack::all(last[3][k]));
            for quad in others.iter().rev() {
                (s0, s1) = (s0 * fourth + quad[0][k], s1 * fourth + quad[1][k]);
                (s2, s3) = (s2 * fourth + quad[2][k], s3 * fourth + quad[3][k]);
            }
            zeta[k] = (s0 + x * s1) + square * (s2 + x * s3);
        }
        zeta
    }
}

/// The coefficients of the interpolants of some functions in the polynomials of Chebyshev.
pub(super) fn chebyshev<const K: usize, const N: usize>(f: impl Fn(f64) -> [f64; K]) -> [[f64; N]; K] {
    let mut series = [[0.0; N]; K];
    for j in 0..N {
        let x = (std::f64::consts::PI * (j as f64 + 0.5) / N as f64).cos();
        // T_0 and T_1, then T_{k+1} = 2 x T_k - T_{k-1}.
        let (values, mut now, mut next) = (f(x), 1.0, x);
        for k in 0..N {
            let share = if k == 0 { 1.0 } else { 2.0 * now } / N as f64;
            series.iter_mut().zip(values).for_each(|(series, value)| series[k] += share * value);
            (now, next) = (next, 2.0 * x * next - now);
        }
    }
    series
}

/// The coefficients of the same polynomial in powers of its argument: those of the series fall
/// faster than the change of basis grows.
fn to_powers(series: [f64; DEGREE + 1]) -> [f64; DEGREE + 1] {
    // T_0 and T_1, then T_{k+1} = 2 x T_k - T_{k-1}.
    let (mut now, mut next) = ([0.0; DEGREE + 1], [0.0; DEGREE + 1]);
    (now[0], next[1]) = (1.0, 1.0);
    let mut sum = [0.0; DEGREE + 1];
    for coefficient in series {
        (0..=DEGREE).for_each(|j| sum[j] += coefficient * now[j]);
        let after = std::array::from_fn(|j| if j > 0 { 2.0 * next[j - 1] } else { 0.0 } - now[j]);
        (now, next) = (next, after);
    }
    sum
}
