//! Theorem 1 (th:dps): its suprema by other integrators, slopes compared with the theorem and its
//! proof, and options that are refused.

use crate::numbers::largest;
use hertzchain::{
    chain::{Boundary, Chain, Field, Overlaps, Params, Site, State},
    dps::{Center, Dps, Ends, Form, Homoclinic, Layout},
    integrators::{Dop853, Regularised, Stepper, dop853::Options, regularised::common_power},
    study::{Bound, Initial, Norm, RhoLaw, Sampling, TheoremOptions, TheoremStudy, theorem},
    sweep::Engine,
};

fn study(options: &TheoremOptions) -> TheoremStudy {
    theorem(options, &Engine::threads(), &|_, _| {}).unwrap()
}

fn options(alpha: f64, initial: Initial, rho_law: RhoLaw, epsilons: &[f64]) -> TheoremOptions {
    TheoremOptions { alpha, initial, rho_law, epsilons: epsilons.to_vec(), ..TheoremOptions::default() }
}

/// Options of a short study: sizes from which on slopes are nearly settled, and a quarter of the
/// samples.
fn short(alpha: f64, initial: Initial, rho_law: RhoLaw) -> TheoremOptions {
    let epsilons: &[f64] =
        if alpha == 1.5 { &[3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6] } else { &[1e-2, 3e-3, 1e-3, 3e-4, 1e-4] };
    let sampling = Sampling { points: 64, periods: 32, ..Sampling::default() };
    TheoremOptions { sampling, ..options(alpha, initial, rho_law, epsilons) }
}

/// Size below which slopes are within 0.03 of the theorem; measured, and in agreement with the
/// sizes of the two parts of `v = R - Q/rho`: for a breather with `alpha = 3/2` the second part is
/// `17 epsilon^{1/2}` times the first.
fn settled(alpha: f64) -> f64 {
    if alpha == 1.5 { 3e-5 } else { 1e-3 }
}

/// Suprema of the three errors in `l_1, l_2, l_inf`, from DOP853 between contacts and the DpS
/// equation solved for `A`, at 400 samples per period. It uses the mathematics of the study and
/// none of its code.
fn independent(alpha: f64, center: Center, epsilon: f64, rho: f64) -> [[f64; 3]; 3] {
    let (breather, sites, slowness) = (Homoclinic::new(alpha, center).unwrap(), 21, epsilon.powf(alpha - 1.0));
    let a: Vec<f64> = (-10..=10).map(|n| breather.a(n)).collect();
    let layout = Layout { sites, ends: Ends::Free, form: Form::Displacements };
    let z: Vec<f64> = a.iter().copied().chain(vec![0.0; sites]).collect();
    let mut flow = Dop853::new(Dps::plain(alpha, 1.0, layout).unwrap(), &z, (0.0, 1.0), Options::new(1e-12)).unwrap();
    let chain = Chain::new(Params::new(alpha, 1.0, rho).unwrap(), Boundary::Free, sites).unwrap();
    let start = State::from_fn(&chain, |n| Site { u: 2.0 * epsilon * a[n], v: 0.0, u_dot: 0.0, v_dot: 0.0 }).unwrap();
    let (end, tol) = (1.0 / slowness, 1e-12);
    let options = Options { atol: tol * epsilon, ..Options::new(tol) };
    let (field, overlaps) = (Field::new(chain.clone()), Overlaps::new(chain.clone()));
    let mut run =
        Regularised::new(field, overlaps, (alpha, common_power(&[alpha], 8)), start.as_slice(), (0.0, end), options)
            .unwrap();
    let mut most = [[0f64; 3]; 3];
    let (mut y, mut z) = (vec![0.0; 4 * sites], vec![0.0; 2 * sites]);
    let count = (400.0 * end / 6.0) as u32;
    for k in 0..=count {
        let t = end * f64::from(k) / f64::from(count);
        while run.time() < t && !run.done() {
            run.step().unwrap();
        }
        run.sample(t.min(run.time()), &mut y);
        let tau = slowness * t;
        while flow.time() < tau && !flow.done() {
            flow.step().unwrap();
        }
        flow.sample(tau.min(flow.time()), &mut z);
        let (sin, cos) = t.sin_cos();
        let real = |n: usize| 2.0 * epsilon * (z[n] * cos - z[sites + n] * sin);
        let imaginary = |n: usize| 2.0 * epsilon * (z[n] * sin + z[sites + n] * cos);
        let parts: [Vec<f64>; 4] = [
            (0..sites).map(|n| y[n] - real(n)).collect(),
            (0..sites).map(|n| y[2 * sites + n] + imaginary(n)).collect(),
            y[sites..2 * sites].to_vec(),
            y[3 * sites..].to_vec(),
        ];
        let norms = |x: &Vec<f64>| {
            let squares: f64 = x.iter().map(|x| (x / epsilon).powi(2)).sum();
            [x.iter().map(|x| x.abs()).sum(), epsilon * squares.sqrt(), largest(x.iter().copied())]
        };
        let [u, u_dot, v, v_dot] = [0, 1, 2, 3].map(|k| norms(&parts[k]));
        for p in 0..3 {
            for (most, now) in most[p].iter_mut().zip([u[p] + u_dot[p], v[p], v_dot[p]]) {
                *most = most.max(now);
            }
        }
    }
    most
}

// Truth: another integrator of the chain, the DpS equation instead of the closed form, three times
// as many samples, more sites.
#[test]
fn suprema_are_those_of_another_program() {
    for (alpha, initial, center, epsilon) in [
        (1.5, Initial::Site, Center::Site, 1e-3),
        (1.5, Initial::Bond, Center::Bond, 0.1),
        (2.0, Initial::Bond, Center::Bond, 1e-2),
    ] {
        for law in [RhoLaw::Heavy, RhoLaw::Light] {
            let study = study(&options(alpha, initial, law, &[epsilon]));
            let truth = independent(alpha, center, epsilon, law.rho(alpha, epsilon));
            for norm in Norm::ALL {
                let found = study.runs[0].suprema[norm.index()].0;
                for k in 0..3 {
                    let apart = found[k] / truth[norm.index()][k] - 1.0;
                    println!("{alpha} {initial:?} {law:?} {norm:?} {k}: {apart:e}");
                    // Measured: at most 2.1e-4; the study states that its samples miss up
                    // to 3.6e-4.
                    assert!(apart.abs() < 4e-4, "{alpha} {initial:?} {law:?} {norm:?} {k}: {apart:e}");
                }
            }
        }
    }
}

// Truth: the theorem. Measured: at most 0.026 and 0.016; the last scaled supremum changes by 0.017.
#[test]
fn suprema_level_off_and_slopes_are_those_of_the_theorem() {
    for alpha in [1.5, 2.0] {
        for initial in [Initial::Bond, Initial::Site, Initial::Generic] {
            let study = study(&short(alpha, initial, RhoLaw::Heavy));
            assert_eq!(study.verdict(), Bound::Bounded);
            for slope in &study.slopes {
                assert_eq!(slope.power, [alpha, alpha, 2.0 * alpha - 1.0][slope.quantity]);
                let (limit, _) = slope.limit.unwrap();
                let settled = study.runs.iter().zip(&slope.local).filter(|(run, _)| run.epsilon <= settled(alpha));
                let off = settled.map(|(_, local)| (local - slope.power).abs()).fold(0.0, f64::max);
                println!("{alpha} {initial:?} {:?} {}: {off:e}, {limit}", slope.norm, slope.quantity);
                assert!(off < 0.03, "{alpha} {initial:?} {:?} {}: {off}", slope.norm, slope.quantity);
                assert!((limit - slope.power).abs() < 0.03, "{alpha} {initial:?}: {limit} for {}", slope.power);
            }
            for norm in Norm::ALL {
                let [.., before, last] = &study.runs[..] else { panic!("two runs") };
                let (before, last) = (study.scaled(before, norm).0, study.scaled(last, norm).0);
                for k in 0..3 {
                    assert!((last[k] / before[k] - 1.0).abs() < 0.03, "{alpha} {initial:?} {norm:?} {k}");
                }
            }
        }
    }
}

// Truth: the proof of the theorem, whose estimates (estimr1) and (estimrp) then have the orders 1,
// 1 and alpha. Measured: at most 0.016.
#[test]
fn lighter_resonators_violate_the_bound_with_slopes_one_one_alpha() {
    for alpha in [1.5, 2.0] {
        let study = study(&short(alpha, Initial::Bond, RhoLaw::Light));
        assert!(study.verdict() == Bound::Violated && !study.contradicts());
        for slope in &study.slopes {
            let truth = [1.0, 1.0, alpha][slope.quantity];
            assert_eq!((slope.bound, slope.expected), (Bound::Violated, Some(truth)));
            let (limit, d) = slope.limit.unwrap();
            println!("{alpha} {:?} {}: {limit} {d}", slope.norm, slope.quantity);
            assert!((limit - truth).abs() < 0.03, "{alpha} {:?} {}: {limit}", slope.norm, slope.quantity);
        }
    }
}

// Truth: the theorem, whose constant may depend on C_i; at t = 0 the departure has its given size.
#[test]
fn bounds_hold_for_departures_and_are_no_less_than_these() {
    let epsilons = vec![1e-4, 1e-5, 1e-6];
    let given = |c_i, seed| TheoremOptions {
        c_i,
        seed,
        epsilons: epsilons.clone(),
        ..short(1.5, Initial::Site, RhoLaw::Heavy)
    };
    let [one, other] = [given(2.0, Some(1)), given(2.0, Some(2))].map(|options| study(&options));
    for study in [&one, &other] {
        assert_eq!(study.verdict(), Bound::Bounded);
        for run in &study.runs {
            let scaled = study.scaled(run, Norm::One).0;
            assert!(scaled.iter().all(|size| *size >= 2.0 * (1.0 - 1e-9)), "{scaled:?}");
        }
    }
    assert_ne!(one.runs[0].suprema, other.runs[0].suprema);
    // One is the seed of those that name none; without a departure there is nothing to draw.
    assert_eq!(one.runs, study(&given(2.0, None)).runs);
    let refused = theorem(&given(0.0, Some(2)), &Engine::threads(), &|_, _| ()).unwrap_err().to_string();
    assert!(refused.starts_with("seed = 2 is not valid"), "{refused}");
}

// Truth: three times as many samples per period, in twice as many periods.
#[test]
fn samples_miss_no_more_than_they_say() {
    let sampling = Sampling { points: 384, periods: 127, periods_per_slow_time: 32 };
    for (alpha, initial, epsilon) in
        [(1.5, Initial::Bond, 1e-5), (2.0, Initial::Generic, 1e-3), (1.5, Initial::Site, 0.03)]
    {
        let given = options(alpha, initial, RhoLaw::Heavy, &[epsilon]);
        let [coarse, fine] = [given.sampling, sampling]
            .map(|sampling| study(&TheoremOptions { sampling, ..given.clone() }).runs.remove(0));
        for norm in Norm::ALL.map(Norm::index) {
            for k in 0..3 {
                let missed = 1.0 - coarse.suprema[norm].0[k] / fine.suprema[norm].0[k];
                let said = coarse.sampling_errors[norm].0[k];
                println!("{alpha} {initial:?} {norm} {k}: missed {missed:e}, said {said:e}");
                assert!(
                    missed < 1.1 * said + 1e-6 && said < 4e-3,
                    "{alpha} {initial:?} {norm} {k}: {missed:e} {said:e}"
                );
            }
        }
    }
}

// Truth: |x|_inf <= |x|_2 <= |x|_1; a longer chain has the same breather; the resonators of
// Newton's cradle do not move.
#[test]
fn norms_are_ordered_more_sites_change_nothing_and_a_cradle_has_no_v() {
    let given = options(1.5, Initial::Bond, RhoLaw::Heavy, &[1e-2, 1e-4]);
    let [one, longer] = [None, Some(33)].map(|sites| study(&TheoremOptions { sites, ..given.clone() }));
    assert_eq!((one.sites, longer.sites), (16, 33));
    for (run, other) in one.runs.iter().zip(&longer.runs) {
        for k in 0..3 {
            let [l1, l2, inf] = Norm::ALL.map(|norm| run.suprema[norm.index()].0[k]);
            assert!(inf < l2 && l2 < l1);
            let apart = Norm::ALL.map(|norm| run.suprema[norm.index()].0[k] / other.suprema[norm.index()].0[k] - 1.0);
            println!("{k}: {apart:?}");
            assert!(largest(apart) < 1e-12, "{k}: {apart:?}");
        }
    }
    let cradle = study(&short(2.0, Initial::Bond, RhoLaw::Value(f64::INFINITY)));
    assert_eq!(cradle.verdict(), Bound::Bounded);
    let [u, v, v_dot] = cradle.runs[0].suprema[0].0;
    assert!(u > 0.0 && v == 0.0 && v_dot == 0.0);
}

#[test]
fn what_cannot_be_told_is_undecided() {
    for epsilons in [&[0.1, 0.03, 0.01][..], &[1e-5], &[1e-4, 1e-5]] {
        let study = study(&options(1.5, Initial::Bond, RhoLaw::Heavy, epsilons));
        assert_eq!(study.verdict(), Bound::Undecided);
        assert!(study.slopes.iter().all(|slope| slope.local.len() + 1 == epsilons.len() && slope.limit.is_none()));
    }
    // Slopes below the theory, or not yet settled, would mislead: those of a cradle, and those of a
    // long horizon.
    for (horizon, rho_law) in [(1.0, RhoLaw::Value(f64::INFINITY)), (19.4, RhoLaw::Heavy)] {
        let given = options(1.5, Initial::Site, rho_law, &[1e-1, 1e-2, 1e-3]);
        assert_eq!(study(&TheoremOptions { horizon, ..given }).verdict(), Bound::Undecided);
    }
}
