//! Kernels of contact-corrected splitting against sums, integrals and formulas.

use hertzchain_integrators::{
    Instructions,
    internals::{Corrector, Extrema, Extremum, Pack, SERIES, end_terms, nearest_zeros, oscillation},
    splitting::{
        corrected::{BondPath, BondView, Correction},
        hurwitz,
    },
};

#[test]
fn integers_give_the_polynomials_of_bernoulli() {
    // zeta(-m, a) = -B_{m+1}(a)/(m+1).
    let bernoulli: [fn(f64) -> f64; 3] =
        [|a| a - 0.5, |a| a * a - a + 1.0 / 6.0, |a| a * a * a - 1.5 * a * a + 0.5 * a];
    for (m, b) in bernoulli.iter().enumerate() {
        for a in [0.01, 0.3, 0.5, 1.0, 1.7, 6.99, 7.0, 9.0] {
            let want = -b(a) / (m as f64 + 1.0);
            assert!((hurwitz(m as f64, a) - want).abs() < f64::EPSILON * 8f64.powi(m as i32 + 1), "{m} {a}");
        }
    }
}

#[test]
fn the_distribution_relation_holds() {
    // sum_{j<m} zeta(-z, (a + j)/m) = m^{-z} zeta(-z, a), for any z: a truth without integers.
    for z in [0.1, 0.5, 1.5, 2.2, 3.7, 4.5] {
        for a in [0.2, 0.9, 1.6] {
            let m = 3.0f64;
            let sum: f64 = (0..3).map(|j| hurwitz(z, (a + f64::from(j)) / m)).sum();
            let want = m.powf(-z) * hurwitz(z, a);
            assert!((sum - want).abs() < 1e-15 * 8f64.powf(z + 1.0), "{z} {a}: {:e}", sum - want);
        }
    }
}

fn event(corrector: &Corrector, view: &BondView, onset: bool) -> Option<Correction> {
    let mut out = Vec::new();
    corrector.corrections(&[(*view, onset)], &mut out);
    out[0]
}

fn view(rate: f64, acceleration: f64, overlap: f64) -> BondView {
    let path = BondPath { overlap, rate, acceleration: [acceleration, 0.0], jerk: [0.0; 2], omega: 0.0 };
    // Without mobility, so that the midpoint rule is Euler's: the error of the quadrature
    // itself.
    BondView { path, mobility: 0.0, pull: [0.0; 2] }
}

#[test]
fn impulse_and_displacement_are_derivatives_of_one_function() {
    // Mixed derivatives of W agree: -d(impulse)/dg' = d(displacement)/dg.
    let corrector = Corrector::new(1.5, 0.2);
    for (rate, acceleration, theta) in [(1.0, 0.5, 0.3), (0.4, -0.9, 0.8), (0.1, 2.0, 0.5)] {
        let by = |overlap, change| {
            let z = &mut corrector.zeta(Pack(theta));
            let moved = Some((Pack(overlap), Pack(change)));
            let (by_overlap, by_rate) = corrector.gradient((Pack(rate), Pack(acceleration)), moved, z);
            (by_overlap.0, by_rate.0)
        };
        let d = 1e-6;
        let mixed = (by(0.0, d).0 - by(0.0, -d).0) / (2.0 * d);
        let other = (by(d, 0.0).1 - by(-d, 0.0).1) / (2.0 * d);
        assert!((mixed - other).abs() < 1e-10, "{mixed} {other}");
    }
}

#[test]
fn events_have_the_same_bits_alone_and_among_others() {
    let corrector = Corrector::new(1.5, 0.1);
    let views =
        [view(1.3, -0.4, 0.05), view(0.2, 3.0, 1e-3), view(1.0, 0.0, 0.0), view(0.0, 0.0, 1e-3), view(0.7, 0.1, 0.01)];
    let alone = views.map(|view| event(&corrector, &view, true));
    let used = Instructions::used();
    for set in Instructions::ALL.into_iter().filter(|set| set.select()) {
        let mut among = Vec::new();
        corrector.corrections(&views.map(|view| (view, true)), &mut among);
        assert_eq!(among, alone, "{set}");
    }
    assert!(used.select());
    assert!(alone[3].is_none() && alone[4].is_some());
}

#[test]
fn paths_without_a_time_of_change_are_left_alone() {
    let corrector = Corrector::new(1.5, 0.1);
    for path in [view(0.0, 0.0, 1e-3), view(f64::NAN, 0.0, 1e-3), view(-1.0, 0.0, 1e-3), view(1e-200, 0.0, 1e-200)] {
        let correction = event(&corrector, &path, true);
        assert!(correction.is_none_or(|c| c.impulse.abs() < 1e-200), "{correction:?}");
    }
    // A grazing path turns back at once: its impulse stays small.
    let grazing = event(&corrector, &view(-1e-6, -1.0, 5e-10), true).unwrap();
    assert!(grazing.impulse.abs() < 1e-6, "{grazing:?}");
}

const H: f64 = 0.1;

/// A bond on a parabola about `t0`, seen from kick `k`, that nothing pulls but springs.
fn parabola(t0: f64, b: f64, a: f64, k: i32) -> BondView {
    let t = f64::from(k) * H - t0;
    let path =
        BondPath { overlap: b + 0.5 * a * t * t, rate: a * t, acceleration: [a, 0.0], jerk: [0.0; 2], omega: 0.0 };
    BondView { path, mobility: 0.0, pull: [0.0; 2] }
}

/// Errors of impulse and of moment about `t0`: the sums of kicks and of corrections at events
/// and at the turning point next to kick 0, minus the integrals of the force. The second pair
/// is without the correction at the turning point.
fn missed(alpha: f64, t0: f64, b: f64, a: f64) -> [[f64; 2]; 2] {
    // Far enough for the formula of Euler and Maclaurin with two terms.
    const FAR: i32 = 40;
    let corrector = Corrector::new(alpha, H);
    let overlap = |t: f64| b + 0.5 * a * t * t;
    let force = |t: f64| overlap(t).max(0.0).powf(alpha);
    let mut sums = [0.0; 2];
    let mut give = |impulse: f64, displacement: f64, t: f64| {
        sums[0] += impulse;
        sums[1] += impulse * t - displacement;
    };
    for k in -FAR..=FAR {
        let t = f64::from(k) * H - t0;
        give(H * force(t) * if k.abs() == FAR { 0.5 } else { 1.0 }, 0.0, t);
        let [before, now] = [t - H, t].map(|t| overlap(t) > 0.0);
        if k > -FAR && before != now {
            let given = event(&corrector, &parabola(t0, b, a, k), now).unwrap();
            give(given.impulse, given.displacement, f64::from(k) * H + given.at - t0);
        }
    }
    let d = 1e-3 * H;
    for end in [-1.0, 1.0] {
        let t = end * f64::from(FAR) * H - t0;
        let derivative = |f: &dyn Fn(f64) -> f64| (f(t + d) - f(t - d)) / (2.0 * d);
        let third = |f: &dyn Fn(f64) -> f64| {
            let d = 0.3 * H;
            (f(t + 2.0 * d) - 2.0 * f(t + d) + 2.0 * f(t - d) - f(t - 2.0 * d)) / (2.0 * d * d * d)
        };
        let moment = |t: f64| t * force(t);
        let terms = |f: &dyn Fn(f64) -> f64| end * (H * H / 12.0 * derivative(f) - H.powi(4) / 720.0 * third(f));
        give(-terms(&force), 0.0, 0.0);
        give(0.0, terms(&moment), 0.0);
    }
    // Integrals from zero to zero of the overlap, in a variable that is smooth at both ends.
    let last = f64::from(FAR) * H;
    let zero = (-2.0 * b / a).max(0.0).sqrt();
    let mut ends = vec![-last - t0, -zero, 0.0, zero, last - t0];
    ends.dedup();
    for pair in ends.windows(2) {
        const PARTS: i32 = 100_000;
        let length = pair[1] - pair[0];
        for i in 0..PARTS {
            let w = (f64::from(i) + 0.5) / f64::from(PARTS);
            // A polynomial that is flat at both ends.
            let s = w * w * w * (10.0 - 15.0 * w + 6.0 * w * w);
            let weight = 30.0 * w * w * (1.0 - w) * (1.0 - w) / f64::from(PARTS) * length;
            give(-weight * force(pair[0] + length * s), 0.0, pair[0] + length * s);
        }
    }
    let without = sums;
    let closed = overlap(-t0) > 0.0;
    let graze = Extremum { view: parabola(t0, b, a, 1), closed };
    let graze = Extrema::new(alpha).correction(&graze, &corrector);
    // Seen from kick 1.
    let given = graze.unwrap().correction;
    [[sums[0] + given.impulse, sums[1] - given.displacement], without]
}

#[test]
fn turning_points_near_zero_leave_nothing_of_a_parabola() {
    // Truth: sums and integrals of the force itself, and Euler and Maclaurin's formula where it
    // is smooth. By its estimate a turning point may be a little more than half a step away.
    for alpha in [1.1, 1.3, 1.5, 2.0] {
        for a in [-0.8, 1.3f64] {
            let mut worst = [0.0f64; 2];
            let scale = H * (a.abs() * H * H).powf(alpha);
            for sigma in [-5.5, -2.0, -1.0, -0.3, -0.1, -0.01, 0.003, 0.05, 0.2, 0.7, 1.5, 3.0] {
                for t0 in [-0.48, -0.31, 0.02, 0.17, 0.52] {
                    let b = 0.5 * sigma * a.abs() * H * H;
                    let [with, without] = missed(alpha, t0 * H, b, a);
                    for (worst, sums) in worst.iter_mut().zip([with, without]) {
                        *worst = worst.max(sums[0].abs() / scale).max(sums[1].abs() / (scale * H));
                    }
                }
            }
            // Contacts are summed exactly; for gaps the terms of Euler and Maclaurin end at
            // h^4.
            let bound = if a < 0.0 { 1e-9 } else { 4e-5 };
            assert!(worst[0] < bound && worst[1] > 1e-2, "{alpha} {a}: {worst:?}");
        }
    }
}

#[test]
fn the_functions_of_a_path_are_their_formulas_at_all_phases() {
    // Truth: sine and cosine of the library; the formulas lose digits where x is small. Series
    // lack their next term.
    for k in 1..=600 {
        for x in [f64::from(k) * 0.01, -f64::from(k) * 0.01] {
            let y = x * x;
            let got = oscillation(Pack(x));
            let next = if x.abs() > SERIES { 0.0 } else { y.powi(6) / 87_178_291_200.0 };
            let error = (3.0 + y) * f64::EPSILON + next;
            assert!((got.cos.0 - x.cos()).abs() < error && (got.sinc.0 - x.sin() / x).abs() < error, "{x}");
            assert!((got.c2.0 - (1.0 - x.cos()) / y).abs() < error + error / y, "{x}");
            assert!((got.s3.0 - (x - x.sin()) / (x * y)).abs() < error + error / y, "{x}");
        }
    }
}

#[test]
fn end_terms_are_their_formula() {
    // Truth: Hurwitz' function by its series. The error is that of the tables, and roundings of
    // the largest power that is subtracted.
    for alpha in [1.0, 1.2, 1.5, 2.0, 3.0] {
        let corrector = Corrector::new(alpha, 0.1);
        for k in 0..=600 {
            let x = f64::from(k) * 0.01;
            for (k, got) in end_terms(&corrector, Pack(x)).map(|z| z.0).into_iter().enumerate() {
                let z = alpha + k as f64;
                let want = hurwitz(z, 1.0 + x) + 0.5 * x.powf(z) + x.powf(z + 1.0) / (z + 1.0);
                assert!((got - want).abs() < 3e-12 + 2e-15 * 8f64.powf(z + 1.0), "{alpha} {x}: {:e}", got - want);
            }
        }
    }
}

#[test]
fn zeros_around_now_are_those_of_the_parabola() {
    // Truth: the formula of its zeros; a path bends up or down, or not at all.
    let path = |overlap, rate, a| BondPath { overlap, rate, acceleration: [a, 0.0], jerk: [0.0; 2], omega: 0.0 };
    let paths =
        [path(0.1, 1.0, 0.0), path(0.1, -1.0, 0.0), path(0.1, 0.2, -2.0), path(0.1, 1.0, 2.0), path(0.1, 0.1, 3.0)];
    let root = (0.2f64 * 0.2 + 0.4).sqrt();
    let want = [
        [Some(-0.1), None],
        [None, Some(0.1)],
        [Some((0.2 - root) / 2.0), Some((0.2 + root) / 2.0)],
        [Some((-1.0 + 0.6f64.sqrt()) / 2.0), None],
        [None; 2],
    ];
    for (got, want) in nearest_zeros(&paths, 1.0).iter().zip(want) {
        for (got, want) in got.iter().zip(want) {
            assert_eq!(got.is_some(), want.is_some(), "{got:?} {want:?}");
            assert!(got.zip(want).is_none_or(|(got, want)| (got - want).abs() < 1e-15), "{got:?} {want:?}");
        }
    }
    assert_eq!(nearest_zeros(&paths, 0.09), [[None; 2]; 5]);
}
