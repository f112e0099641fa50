//! Intervals hold exact results.

use hertzchain_proofs::{exact::Exact, interval::*};
use std::collections::BTreeMap;

/// Numbers of all sizes and signs, from a seed (Marsaglia's xorshift).
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        for shift in [13, -7, 17] {
            self.0 ^= if shift > 0 { self.0 << shift } else { self.0 >> -shift };
        }
        self.0
    }

    fn number(&mut self) -> f64 {
        let fraction = (self.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        let size = 2_f64.powi((self.bits() % 81) as i32 - 40);
        if self.bits().is_multiple_of(2) { fraction * size } else { -fraction * size }
    }

    /// An interval and a number in it.
    fn interval(&mut self) -> (Interval, f64) {
        let x = self.number();
        let by = if self.bits().is_multiple_of(2) { 0.0 } else { x.abs() * 2_f64.powi(-((self.bits() % 60) as i32)) };
        (Interval::new(x - by, x + by), x)
    }
}

/// Operations whose exact result is checked. Truth: errors of rounded sums, products, quotients and
/// roots are doubles, which two more operations give exactly (Dekker 1971, Knuth 1969).
fn random_operations(count: usize, seed: u64) {
    let mut random = Random(seed);
    for _ in 0..count {
        let ((a, x), (b, y)) = (random.interval(), random.interval());
        let sum = x + y;
        let from_y = sum - x;
        let error = (x - (sum - from_y)) + (y - from_y);
        let found = a + b;
        assert!(found.lo() - sum <= error && error <= found.hi() - sum, "{x:e} + {y:e}: {found:?}");
        let found = a * b;
        assert!((-x).mul_add(y, found.lo()) <= 0.0 && 0.0 <= (-x).mul_add(y, found.hi()), "{x:e} * {y:e}: {found:?}");
        let found = a.square();
        assert!((-x).mul_add(x, found.lo()) <= 0.0 && 0.0 <= (-x).mul_add(x, found.hi()), "{x:e}^2: {found:?}");
        let found = a / b;
        if b.holds(0.0) {
            assert!(found.is_nan());
        } else {
            let side = |bound: f64| bound.mul_add(y, -x) * y.signum();
            assert!(side(found.lo()) <= 0.0 && 0.0 <= side(found.hi()), "{x:e}/{y:e}: {found:?}");
        }
        let found = a.abs().sqrt();
        let side = |bound: f64| bound.mul_add(bound, -x.abs());
        assert!(side(found.lo()) <= 0.0 && 0.0 <= side(found.hi()), "sqrt {x:e}: {found:?}");
        assert!((-a).holds(-x) && a.abs().holds(x.abs()) && a.positive_part().holds(x.max(0.0)));
        assert!(a.max(b).holds(x.max(y)) && a.min(b).holds(x.min(y)) && a.holds(a.mid()));
    }
}

#[test]
fn random_operations_are_enclosed() {
    random_operations(100_000, 0x2545_F491_4F6C_DD1D);
}

#[test]
#[ignore = "nightly: ten million operations"]
fn ten_million_random_operations_are_enclosed() {
    random_operations(10_000_000 / 5, 0x9E37_79B9_7F4A_7C15);
}

/// Function, argument, and its value in two doubles. Truth: mpmath with 40 digits.
#[rustfmt::skip]
#[allow(clippy::approx_constant, reason = "arguments near multiples of pi/2, and values at them")]
const VALUES: &[(&str, f64, f64, f64)] = &[
    ("sin", 1e-09, 1e-09, -1.6666666666666669e-28), ("cos", 1e-09, 1.0, -5e-19),
    ("sin", 0.3, 0.29552020666133955, 1.8315357276792536e-17), ("cos", 0.3, 0.955336489125606, 4.1935600297907467e-17),
    ("sin", 0.785398163397448, 0.7071067811865472, 2.756767061182876e-17),
    ("cos", 0.785398163397448, 0.7071067811865478, -1.321830128384233e-17),
    ("sin", 1.5707963267948966, 1.0, -1.874699730964804e-33),
    ("cos", 1.5707963267948966, 6.123233995736766e-17, -1.4973849048591698e-33),
    ("sin", 2.0, 0.9092974268256817, -1.4020906557816256e-17), ("cos", 2.0, -0.4161468365471424, 1.990596398957495e-17),
    ("sin", 3.141592653589793, 1.2246467991473532e-16, -2.99476980971834e-33),
    ("cos", 3.141592653589793, -1.0, 7.498798912379778e-33),
    ("sin", 10.0, -0.5440211108893698, -3.8949898668223557e-17),
    ("cos", 10.0, -0.8390715290764524, -1.4147119988953418e-17),
    ("sin", 355.0, -3.014435335948845e-05, 1.3012643991046347e-21),
    ("cos", 355.0, -0.999999999545659, 1.0574612846643521e-17),
    ("sin", -7.25, -0.8230808790115055, 4.782695371371335e-17),
    ("cos", -7.25, 0.5679241732886948, 4.202033681904503e-17), ("exp", -690.5, 1.3172258525345525e-300, 2.579366e-317),
    ("exp", -20.1, 1.865008921902767e-09, 1.0628610813492404e-25),
    ("exp", -1e-08, 0.9999999900000001, -1.077471008511377e-17), ("exp", 0.0, 1.0, 0.0),
    ("exp", 0.3466, 1.4142509118505286, 2.727912318400902e-17), ("exp", 1.0, 2.718281828459045, 1.4456468917292502e-16),
    ("exp", 17.25, 31015573.27448223, -7.551532368086927e-10),
    ("exp", 699.0, 3.7311512151407716e+303, -3.897031647283796e+286),
    ("ln", 1e-300, -690.7755278982137, -2.3670096176709832e-14),
    ("ln", 0.001, -6.907755278982137, -2.1613487097372872e-16), ("ln", 0.7, -0.35667494393873245, 4.82556379937662e-18),
    ("ln", 0.9999999, -1.0000000494736474e-07, -5.529865283193222e-24),
    ("ln", 1.0000001, 9.999999505838704e-08, 1.5249709528441489e-24),
    ("ln", 1.4, 0.3364722366212129, -2.7495119293418212e-17), ("ln", 2.0, 0.6931471805599453, 2.3190468138462996e-17),
    ("ln", 10000000000.0, 23.025850929940457, -3.94399383981999e-16),
    ("6/5", 1e-12, 3.981071705534973e-15, -2.277936287826559e-31),
    ("3/2", 1e-12, 9.999999999999999e-19, 9.088054182798509e-35), ("7/3", 1e-12, 1e-28, -1.8163698993337517e-45),
    ("6/5", 0.3, 0.23580092567898683, -9.707377771056182e-18), ("3/2", 0.3, 0.1643167672515498, 1.369166847292281e-17),
    ("7/3", 0.3, 0.06024896550739525, -5.942777783763512e-19), ("6/5", 1.7, 1.890334696095584, -5.5215084423982116e-17),
    ("3/2", 1.7, 2.2165288177689004, 4.8240222555996434e-17), ("7/3", 1.7, 3.4491664246700036, -6.011676609054894e-18),
    ("6/5", 250.0, 754.2720420681454, -3.850056996201655e-14),
    ("3/2", 250.0, 3952.847075210474, 1.3366154572039495e-13),
    ("7/3", 250.0, 393725.3280921479, -2.322899024792392e-11),
];

#[test]
fn elementary_functions_are_enclosed() {
    let mut widest = BTreeMap::new();
    for &(name, x, high, low) in VALUES {
        let of = |at: Interval| match name {
            "sin" => at.sin_cos()[0],
            "cos" => at.sin_cos()[1],
            "exp" => at.exp(),
            "ln" => ln(at.lo()).hull(ln(at.hi())),
            power => at.pow(power.parse().unwrap()),
        };
        let found = of(Interval::exact(x));
        assert!(found.lo() - high <= low && low <= found.hi() - high, "{name} {x:e}: {found:?}");
        let size = match name {
            "sin" | "cos" => x.abs().max(1.0),
            "exp" => high * x.abs().max(1.0),
            "ln" => high.abs().max(1.0),
            _ => high.max(f64::MIN_POSITIVE),
        };
        let width = (found.hi() - found.lo()) / (f64::EPSILON * size);
        widest.entry(name).and_modify(|most: &mut f64| *most = most.max(width)).or_insert(width);
        // An interval about the argument holds the value, too, and those at its ends.
        let ends = [-1e-9, 1e-9].map(|by| x + by * x.abs());
        let about = of(Interval::new(ends[0], ends[1]));
        assert!(about.lo() <= found.lo() && found.hi() <= about.hi(), "{name} {x:e}: {about:?}");
        for end in ends.map(|end| of(Interval::exact(end))) {
            assert!(about.lo() <= end.hi() && end.lo() <= about.hi(), "{name} {x:e}: {about:?} {end:?}");
        }
    }
    // In units in the last place, of the argument or of 1 near 0; twice what was measured.
    let most = [("sin", 8.0), ("cos", 8.0), ("exp", 15.0), ("ln", 33.0), ("3/2", 11.0), ("6/5", 400.0), ("7/3", 800.0)];
    assert!(most.iter().all(|(name, most)| widest[name] < *most), "{widest:?}");
}

#[test]
fn what_is_not_known_proves_nothing() {
    let (zero, one) = (Interval::ZERO, Interval::ONE);
    let unknown = [
        one / zero,
        one / Interval::new(-1.0, 1.0),
        (-one).sqrt(),
        Interval::exact(f64::NAN),
        Interval::exact(f64::INFINITY),
        Interval::new(2.0, 1.0),
        Interval::exact(1e308).square() * zero,
        Interval::exact(710.0).exp(),
        ln(0.0),
        (-one).pow(Exact::ONE),
    ];
    for x in unknown {
        assert!(x.is_nan(), "{x:?}");
        let after = [x + one, one - x, x * zero, x / one, x.square(), x.sqrt(), x.abs(), -x, x.max(one), one.min(x)];
        let after =
            after.into_iter().chain(x.sin_cos()).chain([x.exp(), ln(x.lo()), x.positive_part(), x.pow(Exact::ONE)]);
        for y in after {
            assert!(y.is_nan() && !y.is_positive() && !y.holds(0.0), "{y:?} of {x:?}");
        }
    }
    // Angles beyond the reduction.
    assert!([1001.0, -1e300].iter().all(|x| Interval::exact(*x).sin_cos().iter().all(|it| it.is_nan())));
}

#[test]
fn fractions_are_read_exactly() {
    let text = |text: &str| text.parse::<Exact>().map(|x| x.to_string());
    for (from, to) in [("-5/-2", "5/2"), ("6/4", "3/2"), ("3/-9", "-1/3"), ("7", "7"), ("0/5", "0")] {
        assert_eq!(text(from).as_deref(), Ok(to));
    }
    for wrong in
        ["", "1/", "1/0", "2.5", "1e-3", "--1", "1/2/3", "nan", "9223372036854775808", "1/-9223372036854775808"]
    {
        assert!(text(wrong).is_err_and(|why| why.contains(&format!("\"{wrong}\""))), "{wrong}");
    }
    let of = |x: f64| Exact::of_double(x).map(|x| x.to_string());
    for (x, to) in
        [(2.001, Some("2001/1000")), (-1.0 / 3.0, Some("-1/3")), (1e19, None), (1e-19, None), (f64::NAN, None)]
    {
        assert_eq!(of(x).as_deref(), to);
    }
    // Fractions need not be in lowest terms.
    assert!(Interval::exact(3.0).pow(Exact::of(4, 2).unwrap()).holds(9.0));
    // A numerator less than the least one is not read as a positive one.
    let less = |text: &str| text.parse::<Exact>().unwrap().less_one().map(|x| x.to_string());
    assert_eq!([less("7/2").as_deref(), less("-9223372036854775807/2").as_deref()], [Some("5/2"), None]);
    // The nearest double of 2001/1000 is not 2001/1000.
    let x = "2001/1000".parse::<Exact>().unwrap().enclosed();
    assert!(x.holds(2.001) && x.lo() < 2.001 && x.hi() > 2.001);
}
