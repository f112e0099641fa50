//! Every splitting table has its order and not the next, in double-double.
//!
//! The references do not use the tables: the exponential of `A + B` in the free associative
//! algebra, and the Taylor series of a generic mechanical system. All schemes are symmetric. A
//! symmetric scheme has an even order, so that the condition of the next order must fail.

use hertzchain_integrators::{
    DoubleDouble, Scheme,
    splitting::{First, tables},
};
use tables::{
    ABA864, ABA1064, ALL, KAHAN_LI6, KAHAN_LI8, SRKN6_4, SRKN11_6, SRKN14_6, STRANG, SUZUKI4, YOSHIDA4, YOSHIDA6,
    YOSHIDA8,
};

/// A double-double number, the type in which the stepper holds shares of a step.
type Q = DoubleDouble<f64>;

/// Bound of the rounding error of a condition that holds; measured: 2e-29.
const ZERO: f64 = 1e-27;

fn q(value: f64) -> Q {
    Q::new(value)
}

/// Schemes whose order needs `[B, [B, [B, A]]] = 0`.
fn needs_quadratic_kinetic_energy(scheme: &Scheme) -> bool {
    [SRKN11_6.name, SRKN14_6.name].contains(&scheme.name)
}

/// One step as factors in the order in which they act: letter 0 is a drift, letter 1 a kick.
fn factors(scheme: &Scheme, first: First) -> Vec<(usize, Q)> {
    let (first, drifts, kicks) = scheme.flows(first);
    let (outer, inner, letter) = match first {
        First::Drift => (drifts, kicks, 0),
        First::Kick => (kicks, drifts, 1),
    };
    let mut factors = vec![(letter, outer[0])];
    for (&within, &without) in inner.iter().zip(&outer[1..]) {
        factors.extend([(1 - letter, within), (letter, without)]);
    }
    factors
}

/// Coefficients of the product of `exp(a_i A)` and `exp(b_i B)`: `[length][word]`, where a word is
/// a binary number.
fn words(scheme: &Scheme, first: First, degree: usize) -> Vec<Vec<Q>> {
    let mut series: Vec<Vec<Q>> = (0..=degree).map(|length| vec![q(0.0); 1 << length]).collect();
    series[0][0] = q(1.0);
    for (letter, share) in factors(scheme, first) {
        for length in (1..=degree).rev() {
            for word in 0..1 << length {
                let (mut stem, mut power) = (word, q(1.0));
                for taken in 1..=length {
                    if stem & 1 != letter {
                        break;
                    }
                    stem >>= 1;
                    power = power * share.over(q(taken as f64));
                    series[length][word] = series[length][word] + power * series[length - taken][stem];
                }
            }
        }
    }
    series
}

/// Largest distance from `exp(A + B)`, in which every word has the coefficient `1 / length!`. Words
/// are chosen by length and number of kicks.
fn distance_from_exponential(series: &[Vec<Q>], chosen: impl Fn(usize, usize) -> bool) -> f64 {
    let mut largest = 0f64;
    let mut expected = q(1.0);
    for (length, words) in series.iter().enumerate() {
        expected = expected.over(q(length.max(1) as f64));
        for (word, &coefficient) in words.iter().enumerate() {
            if chosen(length, word.count_ones() as usize) {
                largest = largest.max((coefficient - expected).value().abs());
            }
        }
    }
    largest
}

#[test]
fn every_scheme_but_the_nystrom_ones_of_order_six_has_its_order_for_any_two_flows() {
    // Truth: the exponential series. What holds for all words of two letters holds for any two
    // vector fields. The bracket [B, [B, [B, A]]], which vanishes for the Nyström schemes, has
    // three kicks: conditions for words with fewer kicks hold for them too.
    for scheme in ALL {
        let order = scheme.order as usize;
        for first in [First::Drift, First::Kick] {
            let series = words(scheme, first, order + 1);
            let within = distance_from_exponential(&series, |length, _| length <= order);
            let beyond = distance_from_exponential(&series, |length, _| length > order);
            let few_kicks = distance_from_exponential(&series, |length, kicks| length <= order && kicks < 3);
            assert!(few_kicks < ZERO, "{}: {few_kicks:e}", scheme.name);
            if needs_quadratic_kinetic_energy(scheme) {
                assert!(within > 1e-6, "{}: {within:e}", scheme.name);
            } else {
                assert!(within < ZERO, "{}: {within:e}", scheme.name);
                assert!(beyond > 1e-6, "{}: {beyond:e}", scheme.name);
            }
        }
    }
}

#[test]
fn weak_kicks_are_cheap_for_the_generalised_orders() {
    // Truth: the exponential series, word by word. A word with n kicks scales with the n-th power
    // of their strength.
    for (scheme, orders) in [(ABA864, [8, 6, 4]), (ABA1064, [10, 6, 4])] {
        let series = words(&scheme, First::Drift, orders[0] + 1);
        let order = |kicks: usize| orders[kicks.clamp(1, 3) - 1];
        let within = distance_from_exponential(&series, |length, kicks| length <= order(kicks));
        assert!(within < ZERO, "{}: {within:e}", scheme.name);
        for kicks in 1..=3 {
            let beyond = distance_from_exponential(&series, |length, n| n == kicks && length == order(kicks) + 1);
            assert!(beyond > 1e-12, "{} with {kicks} kicks: {beyond:e}", scheme.name);
        }
    }
}

/// A power series in the step `h`, from the constant term up.
type Jet = Vec<Q>;

fn product(x: &Jet, y: &Jet) -> Jet {
    (0..x.len()).map(|n| (0..=n).fold(q(0.0), |sum, k| sum + x[k] * y[n - k])).collect()
}

/// A particle in three dimensions: `p^2/2 + V(q)` with `V(q) = f_1(n_1 . q) + .. + f_7(n_7 . q)`
/// and polynomials `f_j`.
///
/// There are more directions than coordinates, so that the motion does not separate. All numbers
/// are dyadic, hence exact.
struct Particle {
    directions: Vec<[Q; 3]>,
    /// Coefficients of `-f_j'`, from the constant term up.
    forces: Vec<Vec<Q>>,
    start: [[Q; 3]; 2],
}

impl Particle {
    /// Numbers in (-1, 1) from the powers of the primitive root 75 modulo 65537, for a potential of
    /// the given degree.
    fn generic(degree: usize) -> Self {
        let mut power = 1u32;
        let mut next = || {
            power = power * 75 % 65537;
            q(f64::from(power) / 32768.0 - 1.0)
        };
        let mut vector = || [next(), next(), next()];
        let (start, directions) = ([vector(), vector()], (0..7).map(|_| vector()).collect());
        let forces = (0..7).map(|_| (0..degree).map(|_| next()).collect()).collect();
        Self { directions, forces, start }
    }

    /// Position and momentum at the start: constant jets.
    fn jets(&self, degree: usize) -> [Vec<Jet>; 2] {
        self.start.map(|vector| {
            let constant = |value| std::iter::once(value).chain(std::iter::repeat_n(q(0.0), degree)).collect();
            vector.into_iter().map(constant).collect()
        })
    }

    fn force(&self, position: &[Jet]) -> Vec<Jet> {
        let len = position[0].len();
        let mut total = vec![vec![q(0.0); len]; 3];
        for (direction, coefficients) in self.directions.iter().zip(&self.forces) {
            let along: Jet =
                (0..len).map(|n| (0..3).fold(q(0.0), |sum, i| sum + direction[i] * position[i][n])).collect();
            let strength = coefficients.iter().rev().fold(vec![q(0.0); len], |sum, &coefficient| {
                let mut sum = product(&sum, &along);
                sum[0] = sum[0] + coefficient;
                sum
            });
            for (component, &cosine) in total.iter_mut().zip(direction) {
                component.iter_mut().zip(&strength).for_each(|(f, &s)| *f = *f + cosine * s);
            }
        }
        total
    }

    /// One step of length `h`.
    fn step(&self, scheme: &Scheme, first: First, degree: usize) -> [Vec<Jet>; 2] {
        let [mut position, mut momentum] = self.jets(degree);
        let advance = |x: &mut [Jet], rate: &[Jet], share: Q| {
            for (x, rate) in x.iter_mut().zip(rate) {
                x[1..].iter_mut().zip(rate).for_each(|(x, &rate)| *x = *x + share * rate);
            }
        };
        for (letter, share) in factors(scheme, first) {
            match letter {
                0 => advance(&mut position, &momentum, share),
                _ => advance(&mut momentum, &self.force(&position), share),
            }
        }
        [position, momentum]
    }

    /// The Taylor series of the motion: `n q_n = p_(n-1)` and `n p_n = F_(n-1)`.
    fn motion(&self, degree: usize) -> [Vec<Jet>; 2] {
        let [mut position, mut momentum] = self.jets(degree);
        for n in 1..=degree {
            let force = self.force(&position);
            for i in 0..3 {
                position[i][n] = momentum[i][n - 1].over(q(n as f64));
                momentum[i][n] = force[i][n - 1].over(q(n as f64));
            }
        }
        [position, momentum]
    }
}

/// Largest distance between coefficients of `h^n`, relative to the largest of them.
fn relative_distance(x: &[Vec<Jet>; 2], y: &[Vec<Jet>; 2], n: usize) -> f64 {
    let coefficients = |z: &[Vec<Jet>; 2]| z.iter().flatten().map(|jet| jet[n]).collect::<Vec<_>>();
    let (x, y) = (coefficients(x), coefficients(y));
    let distance = x.iter().zip(&y).map(|(&x, &y)| (x - y).value().abs()).fold(0.0, f64::max);
    distance / y.iter().map(|y| y.value().abs()).fold(0.0, f64::max)
}

#[test]
fn every_scheme_follows_a_particle_to_its_order_and_no_further() {
    // Truth: the recursion of the Taylor series of a generic motion.
    for scheme in ALL {
        let order = scheme.order as usize;
        let particle = Particle::generic(order + 2);
        let motion = particle.motion(order + 1);
        for first in [First::Drift, First::Kick] {
            let step = particle.step(scheme, first, order + 1);
            let within = (0..=order).map(|n| relative_distance(&step, &motion, n)).fold(0.0, f64::max);
            let beyond = relative_distance(&step, &motion, order + 1);
            assert!(within < ZERO, "{}: {within:e}", scheme.name);
            assert!(beyond > 1e-5, "{}: {beyond:e}", scheme.name);
        }
    }
}

#[test]
fn the_fourth_order_compositions_are_their_closed_forms() {
    // Truth: gamma = 1/(m - m^(1/3)) is the real root of (m gamma - 1)^3 = m gamma^3.
    for (scheme, m) in [(YOSHIDA4, 2.0), (SUZUKI4, 4.0)] {
        let (_, _, kicks): (_, _, Vec<Q>) = scheme.flows(First::Drift);
        for &gamma in &kicks[..kicks.len() / 2] {
            let root = q(m) * gamma - q(1.0);
            let gap = (root * root * root - q(m) * gamma * gamma * gamma).value();
            assert!(gap.abs() < 1e-30, "{}: {gap:e}", scheme.name);
        }
    }
}

#[test]
fn every_step_is_a_palindrome_with_sums_one_and_the_stages_of_its_source() {
    // Truth: the numbers of stages given in the articles.
    let stages = [
        (STRANG, 1),
        (YOSHIDA4, 3),
        (SUZUKI4, 5),
        (SRKN6_4, 6),
        (ABA864, 7),
        (ABA1064, 8),
        (YOSHIDA6, 7),
        (KAHAN_LI6, 9),
        (SRKN11_6, 11),
        (SRKN14_6, 14),
        (YOSHIDA8, 15),
        (KAHAN_LI8, 17),
    ];
    assert!(ALL.iter().map(|scheme| scheme.name).eq(stages.map(|(scheme, _)| scheme.name)));
    assert!(ALL.is_sorted_by_key(|scheme| (scheme.order, scheme.stages())));
    for (scheme, expected) in stages {
        assert_eq!(scheme.stages(), expected, "{}", scheme.name);
        for first in [First::Drift, First::Kick] {
            let (begins, drifts, kicks): (_, Vec<Q>, Vec<Q>) = scheme.flows(first);
            let merged = if begins == First::Kick { kicks.len() - 1 } else { kicks.len() };
            assert_eq!(merged, expected, "{}", scheme.name);
            for flows in [drifts, kicks] {
                let sum = flows.iter().fold(q(0.0), |sum, &share| sum + share);
                assert!((sum - q(1.0)).value().abs() < 1e-30, "{}: {sum:?}", scheme.name);
                assert!(flows.iter().eq(flows.iter().rev()), "{}", scheme.name);
            }
        }
    }
}
