//! A zero inside a bracket, between two points at which the sign differs.

use crate::real::Real;

/// Largest number of evaluations: four for each halving, and 110 halvings, the bits of
/// double-double.
const EVALUATIONS: usize = 4 * 110;
/// A secant step is shifted towards the middle by this share of the bracket, so that it lands
/// beyond the zero and the other end of the bracket moves too.
const SHIFT: f64 = 1e-6;

/// A zero of `f` in `[a, b]`, where `fa = f(a)` and `fb = f(b)` differ in sign or one of them is
/// zero.
///
/// The secant method of Anderson and Björck (1973), which reduces the stored value at an end that
/// does not move, with a bisection whenever three evaluations have not halved the bracket. The
/// search ends where `f` is zero, where the bracket has no inner point, or after 440 evaluations.
/// There is no tolerance, since the epsilon of double-double is far below its precision.
pub fn bracketed<R: Real>(mut f: impl FnMut(R) -> R, (mut a, mut fa): (R, R), (mut b, mut fb): (R, R)) -> R {
    let (zero, half) = (R::zero(), R::of(0.5));
    let (mut wa, mut wb, mut last) = (fa, fb, None);
    let (mut goal, mut tries) = (half * (b - a), 0);
    for _ in 0..EVALUATIONS {
        let (width, middle) = (b - a, a + half * (b - a));
        if fa == zero || fb == zero || !(a < middle && middle < b) {
            break;
        }
        (goal, tries) = if width <= goal { (half * width, 0) } else { (goal, tries + 1) };
        let per_slope = width / (wb - wa);
        let secant = if wa.abs() < wb.abs() { a - wa * per_slope } else { b - wb * per_slope };
        let x = secant + (R::of(SHIFT) * width).copysign(middle - secant);
        // Rounding may put the secant outside the bracket, and where `f` is infinite there is none.
        let x = if tries <= 3 && a < x && x < b { x } else { middle };
        let fx = f(x);
        let left = (fx > zero) == (fa > zero);
        let weight = if last == Some(left) { lowered(fx, if left { wa } else { wb }) } else { R::one() };
        if left {
            (a, fa, wa, wb) = (x, fx, fx, wb * weight);
        } else {
            (b, fb, wb, wa) = (x, fx, fx, wa * weight);
        }
        last = Some(left);
    }
    if fa.abs() <= fb.abs() { a } else { b }
}

/// The factor of Anderson and Björck for the end that stays, from the new and the old value at the
/// other end.
fn lowered<R: Real>(new: R, old: R) -> R {
    let weight = R::one() - new / old;
    if weight > R::zero() { weight } else { R::of(0.5) }
}
