//! Series and small vectors over the nodes of a panel: loops that the compiler puts into registers.

/// Up to this number of terms a series is kept in powers of `x`, which is faster; longer ones are
/// kept in Chebyshev polynomials, which lose no digits. Held by `methods
/// the_error_is_no_more_than_was_asked_for_over_six_decades`.
pub(crate) const MONOMIAL: usize = 8;

#[inline(always)]
pub(super) fn times<const M: usize>(a: &[f64; M], b: &[f64; M]) -> [f64; M] {
    let mut out = [0.0; M];
    for j in 0..M {
        out[j] = a[j] * b[j];
    }
    out
}

/// A sum in four parts, the same on every machine.
#[inline(always)]
fn sum<const M: usize>(terms: &[f64; M]) -> f64 {
    let mut part = [0.0; 4];
    for j in 0..M {
        part[j % 4] += terms[j];
    }
    (part[0] + part[2]) + (part[1] + part[3])
}

#[inline(always)]
pub(crate) fn dot<const M: usize>(a: &[f64; M], b: &[f64; M]) -> f64 {
    let mut terms = [0.0; M];
    for j in 0..M {
        terms[j] = a[j] * b[j];
    }
    sum(&terms)
}

/// The value of a series whose coefficients come from [`Rule::series`](super::Rule::series).
#[inline(always)]
pub(super) fn value<const M: usize, const L: usize>(series: &[f64; M], x: &[f64; L]) -> [f64; L] {
    if M <= MONOMIAL { horner(series, x) } else { clenshaw(series, x) }
}

/// `sum_i c_i x^i`.
#[inline(always)]
fn horner<const M: usize, const L: usize>(c: &[f64; M], x: &[f64; L]) -> [f64; L] {
    let mut out = [c[M - 1]; L];
    for i in (0..M - 1).rev() {
        for j in 0..L {
            out[j] = x[j].mul_add(out[j], c[i]);
        }
    }
    out
}

/// `sum_k columns[k] values[k]`.
#[inline(always)]
pub(crate) fn product<const M: usize>(columns: &[[f64; M]; M], values: &[f64; M]) -> [f64; M] {
    let mut out = [0.0; M];
    for k in 0..M {
        for j in 0..M {
            out[j] = columns[k][j].mul_add(values[k], out[j]);
        }
    }
    out
}

/// `sum_i c_i T_i(x)`.
#[inline(always)]
pub(super) fn clenshaw<const M: usize, const L: usize>(c: &[f64; M], x: &[f64; L]) -> [f64; L] {
    let (mut b1, mut b2) = ([0.0; L], [0.0; L]);
    for i in (1..M).rev() {
        for j in 0..L {
            let b = (2.0 * x[j]).mul_add(b1[j], c[i] - b2[j]);
            b2[j] = b1[j];
            b1[j] = b;
        }
    }
    let mut out = [0.0; L];
    for j in 0..L {
        out[j] = x[j].mul_add(b1[j], c[0] - b2[j]);
    }
    out
}

/// Sine and cosine without branches, so that loops over nodes vectorise; to 2 units in the last
/// place for `|x| < 10^6`.
///
/// Reduction by three parts of pi/2 (Cody and Waite), then Taylor polynomials on `[-pi/4, pi/4]`.
#[inline(always)]
pub(crate) fn sin_cos(x: f64) -> (f64, f64) {
    const HALF_PI: [f64; 3] = [std::f64::consts::FRAC_PI_2, 6.123233995736766e-17, -1.4973849048591833e-33];
    let turns = (x * std::f64::consts::FRAC_2_PI).round_ties_even();
    let r = (-turns).mul_add(HALF_PI[0], x);
    let r = (-turns).mul_add(HALF_PI[1], r);
    let r = (-turns).mul_add(HALF_PI[2], r);
    let z = r * r;
    let mut s = -7.647163731819816e-13;
    for c in [
        1.6059043836821613e-10,
        -2.505210838544172e-8,
        2.7557319223985893e-6,
        -1.984126984126984e-4,
        8.333333333333333e-3,
        -1.6666666666666666e-1,
    ] {
        s = z.mul_add(s, c);
    }
    let s = r.mul_add(z * s, r);
    let mut c = 4.779477332387385e-14;
    for k in [
        -1.1470745597729725e-11,
        2.08767569878681e-9,
        -2.755731922398589e-7,
        2.48015873015873e-5,
        -1.388888888888889e-3,
        4.1666666666666664e-2,
        -0.5,
    ] {
        c = z.mul_add(c, k);
    }
    let c = z.mul_add(c, 1.0);
    // Quarter turns: 1 swaps, 2 changes both signs.
    let quarter = turns - 4.0 * (0.25 * turns).floor();
    let swap = quarter == 1.0 || quarter == 3.0;
    let (sin, cos) = if swap { (c, s) } else { (s, c) };
    let sin = if quarter >= 2.0 { -sin } else { sin };
    let cos = if quarter == 1.0 || quarter == 2.0 { -cos } else { cos };
    (sin, cos)
}
