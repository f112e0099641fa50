//! Every splitting table has its order and not the next, in double-double.
//!
//! The reference does not use the tables: the exponential of `A + B` in the free associative
//! algebra. All schemes are symmetric. A symmetric scheme has an even order, so that the condition
//! of the next order must fail. The order of the Nyström schemes with three kicks and more is
//! measured by `methods every_scheme_has_its_order_and_no_more_while_no_contact_opens`.

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
