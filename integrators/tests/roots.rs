//! Zeros, polynomials through samples, sides of event functions, and overlaps as functions of time.

use hertzchain_integrators::{
    Real,
    events::{Curve, NODES, SHARES, bracketed},
    internals::{Interpolation, Polynomial, Sides},
};
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

fn through(f: impl Fn(f64) -> f64) -> Polynomial {
    let interpolation = Interpolation::default();
    interpolation.through(&SHARES.map(f))
}

#[test]
fn the_zero_is_the_last_before_the_band_is_left() {
    // Zeros at 0.2, 0.4 and 0.6; between the first two it stays inside the band.
    let p = through(|s| 1e-3 * (s - 0.2) * (s - 0.4) * (s - 0.6));
    let (zero, left) = p.first_crossing(false, false, 2e-5).unwrap();
    assert!((zero - 0.6).abs() < 1e-12 && left > 0.6);
    // A polynomial that starts inside the band and leaves it: the zero is the start.
    let p = through(|s| 1e-12 + s);
    assert_eq!(p.first_crossing(false, false, 1e-9).unwrap().0, 0.0);
}

#[test]
fn a_late_function_is_waited_for() {
    let p = through(|s| s - 0.25);
    assert!(p.first_crossing(true, true, 1e-12).is_none());
    let p = through(|s| (s - 0.25) * (0.75 - s));
    assert!((p.first_crossing(true, true, 1e-12).unwrap().0 - 0.75).abs() < 1e-12);
    assert_eq!(p.first_crossing(true, false, 1e-12).unwrap().0, 0.0);
}

#[test]
fn the_certificate_never_lies() {
    let interpolation = Interpolation::default();
    let mut seed = 1u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let mut certified = 0;
    for _ in 0..2000 {
        let offset = 200.0 * random();
        let values: [f64; NODES] = std::array::from_fn(|_| offset + random());
        let positive = offset > 0.0;
        if interpolation.stays(&values, positive, 0.0) {
            certified += 1;
            assert!(interpolation.through(&values).first_crossing(positive, false, 0.0).is_none());
        }
    }
    assert!((200..1900).contains(&certified), "{certified}");
}

/// Values of a function at the nodes of a step.
fn step(sides: &mut Sides, f: impl Fn(f64) -> f64) {
    for (k, share) in SHARES.into_iter().enumerate() {
        sides.put(k, &[f(share)]);
    }
}

/// Sides of one function that is zero at the start, where errors of steps are 1e-8.
fn doubtful() -> Sides {
    let mut sides = Sides::new(1);
    sides.put(0, &[0.0]);
    sides.set_band(1e-14);
    sides.begin(true);
    sides.set_noise(1e-8, 0.5);
    sides
}

fn crossings(sides: &Sides) -> usize {
    let mut found = Vec::new();
    sides.first_crossings(&mut found);
    found.len()
}

#[test]
fn a_doubtful_function_is_positive_until_it_is_below_the_error_of_a_step() {
    let mut sides = doubtful();
    assert!(sides.positive(0));
    step(&mut sides, |s| -9e-9 * s);
    assert_eq!(crossings(&sides), 0);
    step(&mut sides, |s| -2e-8 * s);
    assert_eq!(crossings(&sides), 1);
    // A trial that errs more says less.
    sides.set_noise(1e-8, 3.0);
    assert_eq!(crossings(&sides), 0);
    // Once it has been above, the band counts again.
    step(&mut sides, |s| 4e-8 * s);
    assert!(sides.settle().is_empty());
    step(&mut sides, |s| 4e-8 - 4.1e-8 * s);
    assert_eq!(crossings(&sides), 1);
}

#[test]
fn an_event_is_taken_back_if_its_function_goes_away_once_at_a_place() {
    let mut sides = doubtful();
    let mut found = Vec::new();
    sides.fire(0);
    // It comes to its new side late, or later.
    for f in [|s: f64| 1e-9 - 1e-6 * s, |s: f64| 1e-9 - 5e-10 * s, |s: f64| 1e-6 * s * (s - 0.5)] {
        step(&mut sides, f);
        sides.taken_back(&mut found);
        assert!(found.is_empty());
    }
    step(&mut sides, |s| 1e-9 + 1e-6 * s);
    sides.taken_back(&mut found);
    assert_eq!(found, [0]);
    sides.fire(0);
    step(&mut sides, |s| -1e-6 * s);
    sides.taken_back(&mut found);
    assert!(found.is_empty());
}

/// `g(t)` on `[from, to]` at Chebyshev points of `sigma`, `t = sigma^q`.
fn curve(g: impl Fn(f64) -> f64, (from, to): (f64, f64), q: u32, count: usize) -> Curve {
    let root = |t: f64| t.powf(1.0 / f64::from(q));
    let [a, b] = [root(from), root(to)];
    let x = |k: usize| (std::f64::consts::FRAC_PI_2 * k as f64 / (count - 1) as f64).sin().powi(2);
    let points = (0..count).map(|k| (x(k), g((a + (b - a) * x(k)).powi(q as i32))));
    Curve::new((0.0, 1.0, q), [a, b], (from, to), points)
}

#[test]
fn ends_count_as_they_are() {
    // A function that only falls, and one that only rises.
    let falls = curve(|t| 2.0 - t, (0.0, 1.0), 1, 6);
    assert_eq!(falls.largest(), (0.0, 2.0));
    assert_eq!(falls.rises_to(1.5, 0.0).unwrap().0, 0.0);
    assert!(falls.rises_to(1.5, 0.5).is_none() && falls.least() == (1.0, 1.0));
    let rises = curve(|t| t * t, (0.0, 1.0), 1, 6);
    assert_eq!(rises.largest(), (1.0, 1.0));
    assert!(rises.falls_to(0.5).is_none());
    // At the origin of a map time does not move, and the rate is that of a chord.
    let root = curve(|t| t, (0.0, 1.0), 2, 6);
    assert!((root.rises_to(0.0, 0.0).unwrap().1 - 1.0).abs() < 1e-15);
}

#[test]
fn numbers_of_no_curve_are_refused() {
    let good = curve(|t| t, (0.0, 1.0), 1, 4).numbers();
    for (k, value) in [(0, f64::NAN), (1, 0.5), (2, 0.0), (2, 1.5), (4, 0.0), (5, 2.0), (7, 1.0), (7, 15.0), (9, -1.0)]
    {
        let mut bad = good;
        bad[k] = value;
        assert!(Curve::of_numbers(&bad).is_none(), "{k} {value}");
    }
}
