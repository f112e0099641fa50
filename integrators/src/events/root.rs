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

#[cfg(test)]
mod tests {
    use super::*;
    use twofloat::TwoFloat;

    /// The zero and the number of evaluations; asserts that no point outside the bracket is
    /// evaluated.
    fn counted<R: Real>(f: impl Fn(R) -> R, a: R, b: R) -> (R, usize) {
        let mut count = 0;
        let g = |x: R| {
            assert!(a < x && x < b, "{x} is outside");
            count += 1;
            f(x)
        };
        (bracketed(g, (a, f(a)), (b, f(b))), count)
    }

    /// A function, the bracket and the zero.
    type Case = (fn(f64) -> f64, f64, f64, f64);

    #[test]
    fn smooth_zeros_are_found_to_the_last_bit_in_a_dozen_evaluations() {
        let cases: [Case; 6] = [
            (|x| x.cos() - x, 0.0, 1.0, 0.739_085_133_215_160_6),
            (|x| x.exp() - 2.0, -3.0, 4.0, 2f64.ln()),
            (|x| 2.0 - x * x, 0.0, 2.0, 2f64.sqrt()),
            (|x| x - 0.3, -1.0, 5.0, 0.3),
            (|x| (x - 1e-3).sin(), -1.0, 1.0, 1e-3),
            (|x| 1.0 - 1.0 / x, 0.01, 50.0, 1.0),
        ];
        for (f, a, b, want) in cases {
            let (x, count) = counted(f, a, b);

            assert!((x - want).abs() <= 2.0 * f64::EPSILON * want, "{x} for {want}");
            assert!(count <= 20, "{count} evaluations for {want}");
        }
    }

    #[test]
    fn hard_zeros_cost_at_most_four_bisections() {
        let cases: [Case; 4] = [
            (|x| (x - 0.1).powi(9), -1.0, 1.0, 0.1),
            (|x| if x < 0.7 { -1e-300 } else { 1e300 }, 0.0, 1.0, 0.7),
            (|x| if x < 0.7 { f64::NEG_INFINITY } else { 1.0 }, 0.0, 1.0, 0.7),
            (|x| (x - 1e-9).cbrt(), -1.0, 8.0, 1e-9),
        ];
        for (f, a, b, want) in cases {
            let (x, count) = counted(f, a, b);

            assert!((x - want).abs() <= 1e-15, "{x} for {want}");
            assert!(count <= 4 * 58, "{count}");
        }
    }

    #[test]
    fn zeros_on_the_ends_are_taken() {
        assert_eq!(bracketed(|x: f64| x, (0.0, 0.0), (1.0, 1.0)), 0.0);
        assert_eq!(bracketed(|x: f64| x, (-1.0, -1.0), (0.0, 0.0)), 0.0);
    }

    #[test]
    fn double_double_keeps_its_digits() {
        let two = TwoFloat::from(2.0);
        let (x, count) = counted(|x| x * x - two, TwoFloat::from(1.0), TwoFloat::from(2.0));
        let gap = (x * x - two).hi().abs();

        assert!(gap < 1e-30, "{gap:e}");
        assert!(count <= 4 * 58, "{count}");
    }
}
