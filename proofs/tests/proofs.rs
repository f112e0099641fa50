//! What is proved, and what is refused.

use super::{bounds::bounds, check, check_text, double, exact, kink, model, single};
use hertzchain_proofs::{
    certificate::{Bloch, Center, Certificate, Model, Multiplier, Orbit},
    check::{Bounds, Gap, Proof, Refused, check_until, connected, doublings},
    exact::Exact,
    untrusted::{
        modulations,
        solve::{self, Sizes},
    },
};
use std::{f64::consts::PI, sync::LazyLock};

/// The amplitude of the wave of one harmonic, `a = C_1 n_1(a)`, by bisection.
fn amplitude(model: &Model, q: f64, mean: f64) -> f64 {
    let (alpha, square) = (double(model.alpha), double(model.omega).powi(2));
    let lattice = 2.0 - 2.0 * q.cos();
    let c = match model.rho.map(double) {
        None => lattice / (1.0 - square),
        Some(rho) => -lattice / (square * (1.0 + rho / (1.0 - rho * square))),
    };
    let force = |a: f64| {
        let term = |j: usize| {
            let cos = (PI * (j as f64 + 0.5) / 1024.0).cos();
            (-mean - a * cos).max(0.0).powf(alpha) * cos / 512.0
        };
        (0..1024).map(term).sum::<f64>()
    };
    let (mut low, mut high) = (1e-9, 1e3);
    for _ in 0..200 {
        let middle = f64::sqrt(low * high);
        if c * force(middle) < middle { low = middle } else { high = middle }
    }
    low
}

fn wave(parameters: [&str; 3], [q_over_pi, mean]: [&str; 2], sizes: Sizes) -> Certificate {
    let model = model(parameters);
    let guess = amplitude(&model, PI * double(exact(q_over_pi)), double(exact(mean)));
    solve::near(&super::wave(model, [q_over_pi, mean], [1, 4], &[guess]), sizes).expect("a wave")
}

/// The wave of the scene tw-q15, at mean strain 0.
fn tw_q15(sizes: Sizes) -> Certificate {
    wave(["3/2", "1/3", "2.001"], ["1/5", "0"], sizes)
}

/// A breather of mean strain 0 on a ring of 41, from the profile of a kink.
fn breather(parameters: [&str; 3], center: Center, sizes: Sizes) -> Certificate {
    let model = model(parameters);
    let a = amplitude(&model, PI, 0.0);
    solve::near(&kink(model, 41, center, a), sizes).expect("a breather")
}

#[test]
fn waves_are_proved() {
    let cases = [
        (["3/2", "1/3", "2.001"], ["1/5", "0"]),
        (["3/2", "1/3", "2.001"], ["1/5", "0.0571131129999555"]),
        (["3/2", "1/3", "2.001"], ["4/5", "0"]),
        (["3/2", "1/3", "2.009"], ["4/5", "0"]),
        (["3/2", "3", "1.15687"], ["1/5", "0"]),
        (["3/2", "10", "1.05"], ["1/5", "0"]),
        (["3/2", "inf", "1.003"], ["1/5", "0"]),
        (["6/5", "1/3", "2.001"], ["1/5", "0"]),
        (["2", "1/3", "2.001"], ["1/5", "0"]),
        (["5/2", "1/3", "2.001"], ["1/5", "0"]),
    ];
    for (parameters, [q, mean]) in cases {
        let certificate = wave(parameters, [q, mean], Sizes::WAVE);
        let proof = check(&certificate).unwrap_or_else(|why| panic!("{parameters:?} {q} {mean}: {why}"));
        assert!(proof.radius < 1e-10 * proof.amplitude, "{parameters:?} {q} {mean}: {proof:?}");
        assert!(proof.uniqueness_radius > 1e4 * proof.radius, "{parameters:?} {q} {mean}: {proof:?}");
        // The state at rest is a solution, too.
        assert!(proof.uniqueness_radius < proof.amplitude, "{parameters:?} {q} {mean}: {proof:?}");
        // The text is the certificate.
        assert_eq!(certificate.to_string().parse(), Ok(certificate));
    }
    // Without resonators; and with an antiresonance, k^2 rho omega^2 = kappa for k = 2, which is no
    // obstacle. Their forces are large, so more harmonics are needed.
    for parameters in [["3/2", "0", "0.5"], ["3/2", "1/4", "1"]] {
        let proof = check(&wave(parameters, ["1/2", "0"], Sizes::WAVE.times(4))).unwrap();
        assert!(proof.radius < 1e-10 * proof.amplitude, "{parameters:?}: {proof:?}");
        // At the antiresonance `b_2` is not a multiple of `a_2`.
        let known = [proof.radius_y, proof.radius_velocity_y].map(f64::is_finite);
        assert_eq!(known, [parameters[1] == "0"; 2], "{parameters:?}: {proof:?}");
    }
}

// Truth: `bounds.py` in this folder, which computes the formulas of proofs/README.md in another
// language and by another quadrature, for few harmonics, so that every term matters.
#[test]
fn bounds_are_those_of_the_formulas() {
    let near = |found: Bounds, truth: [f64; 2], what: &str| {
        for (found, truth) in [found.y0, found.z1].into_iter().zip(truth) {
            // The largest overlap of a piece is bounded from above. With few harmonics this
            // changes Z1 of breathers a little.
            let over = if what == "breather" { 3e-4 } else { 1e-7 };
            assert!(found / truth > 1.0 - 1e-7 && found / truth < 1.0 + over, "{what}: {found:e}, not {truth:e}");
        }
    };
    let a = [0.0083, -1.7e-5, 3e-6, 1e-6];
    for (parameters, kappa, [q, mean], scale, [block, enclosed], truth) in [
        (["3/2", "1/3", "2.001"], "1", ["1/5", "0"], 1.0, [2, 8], [4.757030721e-6, 3.554479118e-1]),
        (["5/2", "inf", "1.9"], "2", ["4/5", "-0.001"], 100.0, [2, 8], [3.656007448e-1, 8.057757847e-1]),
        (["6/5", "3", "1.2"], "1", ["1/2", "0.002"], 1.0, [1, 6], [3.698456998e-3, 1.097390712]),
    ] {
        let model = Model { kappa: exact(kappa), ..model(parameters) };
        near(bounds(&super::wave(model, [q, mean], [block, enclosed], &a.map(|a| scale * a))), truth, q);
    }
    let site = [[-0.04, 0.0, 0.006, 0.0], [0.002, -0.15, 0.001, 0.002], [-0.003, 0.16, -0.002, 0.001]];
    let bond = [[-0.03, 0.08, 0.003, 0.001], [0.01, -0.15, 0.004, 0.002], [-0.02, 0.16, -0.002, 0.001]];
    // An orbit of doubled period, from its far site on: the program has it about a bond.
    let doubled = [[-0.02, 0.0, -0.16, 0.0], [0.01, -0.03, 0.15, 0.002], [-0.03, 0.08, -0.1, 0.004]];
    for (center, omega, a, truth) in [
        (Center::Site, "2.05", site, [6.263903224e-1, 1.612900840]),
        (Center::Bond, "2.05", bond, [5.478740539e-1, 1.507840582]),
        (Center::Site, "1.033", doubled, [3.215930658, 2.335394644e1]),
    ] {
        let (orbit, a) = (Orbit::Breather { sites: 5, center }, a.map(|row| row.to_vec()).to_vec());
        near(bounds(&single(model(["3/2", "1/3", omega]), "0.01", [2, 8], orbit, a)), truth, "breather");
    }
}

/// Whether a solution of more harmonics lies in all balls; `rho = 1/3`.
fn within([coarse, fine]: [&[Vec<f64>]; 2], omega: f64, proof: &Proof) {
    let of_site = |(coarse, fine): (&Vec<f64>, &Vec<f64>)| -> Vec<f64> {
        (1..fine.len()).map(|k| (coarse.get(k).unwrap_or(&0.0) - fine[k]).abs()).collect()
    };
    let apart: Vec<Vec<f64>> = coarse.iter().zip(fine).map(of_site).collect();
    let resonators = |k: f64| 1.0 / ((omega * k).powi(2) / 3.0 - 1.0);
    let cases: [(f64, &dyn Fn(f64) -> f64); 4] = [
        (proof.radius, &|_| 1.0),
        (proof.radius_y, &resonators),
        (proof.radius_velocity, &|k| omega * k),
        (proof.radius_velocity_y, &|k| omega * k * resonators(k)),
    ];
    for (i, (radius, factor)) in cases.into_iter().enumerate() {
        let of_site = |apart: &Vec<f64>| apart.iter().zip(1..).map(|(apart, k)| factor(f64::from(k)) * apart).sum();
        let distance = apart.iter().map(of_site).fold(0.0, f64::max);
        assert!(distance < radius, "{i}: {distance:e}, {proof:?}");
        // Measured for x: 1.01 to 3.2. That of y is mostly in high harmonics, where y is smaller.
        assert!(i % 2 == 1 || radius < 7.0 * distance, "{i}: {distance:e}, {proof:?}");
    }
    // The factor of the first harmonic is 2.2 to 3.
    assert!(proof.radius_y < 3.0 * proof.radius && proof.radius_velocity_y < 0.5 * proof.radius_velocity, "{proof:?}");
}

// Truth: solutions with four to 128 times as many harmonics.
#[test]
fn better_solutions_lie_in_the_ball() {
    let better = tw_q15(Sizes { harmonics: 2048, ..Sizes::WAVE });
    for harmonics in [16, 64, 256] {
        let certificate = tw_q15(Sizes { harmonics, enclosed: 256, ..Sizes::WAVE });
        within([&certificate.a, &better.a], 2.001, &check(&certificate).unwrap());
    }
    let sizes = Sizes { block: 8, harmonics: 32, enclosed: 64 };
    let both = [sizes, Sizes { harmonics: 128, enclosed: 128, ..sizes }];
    for center in [Center::Site, Center::Bond] {
        let [certificate, better] = both.map(|sizes| breather(["3/2", "1/3", "2.09"], center, sizes));
        within([&certificate.a, &better.a], 2.09, &check(&certificate).unwrap());
        if center == Center::Bond {
            let [mut certificate, mut better] = both.map(|sizes| solve::unrolled(&better, sizes).unwrap());
            let proof = check(&certificate).unwrap();
            let all = [&mut certificate, &mut better].map(|it| [it.a.clone(), vec![background(it).clone()]].concat());
            within([&all[0], &all[1]], 2.09, &proof);
        }
    }
}

#[test]
fn what_is_no_solution_is_refused() {
    let wave = tw_q15(Sizes::WAVE);
    // The first harmonic moved by 5 percent.
    for factor in [0.95, 1.05] {
        assert!(refused(&wave, |it| it.a[0][1] *= factor).y0 > 1e-4, "{factor}");
    }
    assert_eq!(check_until(&wave, &|| true), Err(Refused::Stopped));
    // A block of one harmonic: Z1 is 1.6.
    assert!((1.0..2.0).contains(&refused(&wave, |it| it.block = 1).z1));
    // Exact resonances k omega = sqrt(kappa (1 + 1/rho)) = 2 for k = 1, 2, 512, and with fixed
    // resonators.
    // All enclosed harmonics of 1/300 are below the resonance.
    for (omega, rho, k) in
        [("2", "1/3", 1), ("1", "1/3", 2), ("1/256", "1/3", 512), ("1/300", "1/3", 513), ("1/3", "inf", 3)]
    {
        let resonant = changed(&wave, |it| it.model = model(["3/2", rho, omega]));
        assert_eq!(resonant, Err(Refused::Resonance(k)));
    }
    // The state at rest, unloaded, and under load, where it is a zero of G.
    let rest = |mean: &str, first: f64| {
        changed(&wave, |it| {
            it.a[0].fill(0.0);
            (it.mean, it.a[0][1]) = (exact(mean), first);
        })
    };
    assert_eq!(rest("0", 0.0), Err(Refused::Moments));
    assert!(matches!(rest("-0.1", 0.0), Err(Refused::Rest(radius, _)) if radius < 1e-11));
    assert!(matches!(rest("-0.1", 1e-18), Err(Refused::Rest(..))));
    // Numbers that are none.
    let broken = changed(&wave, |it| it.a[0][4] = f64::NAN);
    assert!(matches!(broken, Err(Refused::Certificate(why)) if why.contains("finite")));
}

/// The words with which changes of a text are refused.
fn broken(text: &str, cases: &[(&str, &str, &str)]) {
    assert!(text.parse::<Certificate>().is_ok());
    for (from, to, words) in cases {
        assert!(text.contains(from), "{from}");
        let why = check_text(&text.replacen(from, to, 1)).unwrap_err();
        assert!(matches!(&why, Refused::Certificate(rule) if rule.contains(words)), "{from} -> {to}: {why}");
    }
}

#[test]
fn certificates_that_break_a_rule_are_refused() {
    let text = tw_q15(Sizes { block: 2, harmonics: 4, enclosed: 8 }).to_string();
    broken(
        &text,
        &[
            ("certificate 2", "certificate 1", "first line"),
            ("alpha 3/2", "alpha 1", "alpha must be above 1"),
            ("alpha 3/2", "alpha 1.5", "\"1.5\" is no fraction"),
            ("kappa 1", "kappa 0", "kappa must be above 0"),
            ("rho 1/3", "rho -1", "rho must be at least 0"),
            ("rho 1/3", "rho 2/6", "the line \"rho 2/6\" is to be written as \"rho 1/3\""),
            ("omega 2001/1000", "omega 0", "omega must be above 0"),
            ("mean 0", "mean", "the line mean is missing"),
            ("mean 0\n", "", "the line mean is missing, before \"block 2\""),
            ("mean 0", "mean 0\nmean 1", "the line block is missing"),
            ("kappa 1\nrho 1/3", "rho 1/3\nkappa 1", "the line kappa is missing"),
            ("q_over_pi 1/5", "q_over_pi 1/5\nsites 41", "the line \"sites 41\" is not expected here"),
            ("q_over_pi 1/5", "q_over_pi -9223372036854775808/3", "64 bits"),
            // Its products would overflow.
            ("q_over_pi 1/5", "q_over_pi 9223372036854775807/3", "at most 12 digits"),
            ("block 2", "block 5", "number of harmonics"),
            ("block 2", "block 0", "number of harmonics"),
            ("block 2", "block 18446744073709551615", "number of harmonics"),
            ("enclosed 8", "enclosed 7", "4 block"),
            ("enclosed 8", "enclosed 5000", "4096"),
            ("enclosed 8", "enclosed -8", "whole number"),
            ("kind wave", "kind ring", "neither wave, breather nor infinite"),
            ("kind wave", "kind breather", "sites is missing"),
            ("\na 3", "\na +", "16 hexadecimal digits"),
            ("\na 3", "\na 03", "16 hexadecimal digits"),
            ("\na 3", "\na ", "16 hexadecimal digits"),
            ("\na 3f", "\na 7ff0000000000000 3f", "finite"),
            ("\na 3", "\na 3ff0000000000000\na 3", "a row of coefficients for each site"),
        ],
    );
    let few = Sizes { block: 2, harmonics: 8, enclosed: 8 };
    broken(
        &breather(["3/2", "1/3", "2.05"], Center::Site, few).to_string(),
        &[
            ("rho 1/3", "rho inf", "rho must be finite"),
            ("sites 41", "sites 42", "odd"),
            ("sites 41", "sites 43", "a row of coefficients for each site"),
            ("center site", "center edge", "is no centre, site or bond"),
            (" 0000000000000000", " 3fc0000000000000", "even harmonics only"),
        ],
    );
}

/// What is said of a changed certificate.
fn changed(certificate: &Certificate, change: impl Fn(&mut Certificate)) -> Result<Proof, Refused> {
    let mut changed = certificate.clone();
    change(&mut changed);
    check(&changed)
}

/// The bounds for which a changed certificate is refused.
fn refused(certificate: &Certificate, change: impl Fn(&mut Certificate)) -> Bounds {
    match changed(certificate, change) {
        Err(Refused::Bounds(bounds)) => bounds,
        other => panic!("{other:?}"),
    }
}

fn proved(parameters: [&str; 3], center: Center) -> (Certificate, Proof) {
    let certificate = breather(parameters, center, Sizes::BREATHER);
    let proof = check(&certificate).unwrap_or_else(|why| panic!("{parameters:?} {center:?}: {why}"));
    assert!(proof.radius < 1e-9 * proof.amplitude, "{parameters:?} {center:?}: {proof:?}");
    (certificate, proof)
}

#[test]
fn a_breather_about_a_site_is_proved() {
    let (certificate, _) = proved(["3/2", "1/3", "2.05"], Center::Site);
    assert_eq!(certificate.to_string().parse(), Ok(certificate));
    // What is refused needs few harmonics.
    let few = breather(["3/2", "1/3", "2.05"], Center::Site, Sizes { block: 6, harmonics: 32, enclosed: 32 });
    assert!(check(&few).is_ok() && refused(&few, |it| it.block = 1).z1 > 1.0);
    assert!(refused(&few, |it| it.a[1][1] *= 1.05).y0 > 1e-4);
    // Another mean strain than that of the coefficients: the equation of the mean sees it.
    assert!(refused(&few, |it| it.mean = exact("0.01")).y0 > 1e-4);
}

/// Two periods of a breather of the mean strain 0, from half of its period on, as one of doubled
/// period, with a push at its kink.
fn twice(omega: &str, push: f64, sizes: Sizes) -> Certificate {
    let near = breather(["3/2", "1/3", omega], Center::Bond, sizes);
    let row = |(n, a): (i32, &Vec<f64>)| {
        let mut row: Vec<f64> = a.iter().zip(0..).flat_map(|(a, k)| [if k % 2 == 0 { *a } else { -a }, 0.0]).collect();
        row[1] = push * f64::from(-2 * n).exp();
        row
    };
    let mut a: Vec<Vec<f64>> = (0..).zip(&near.a).map(row).collect();
    // Seen from the far site.
    a.reverse();
    let half = Exact::of_double(0.5 * double(exact(omega))).unwrap();
    Certificate {
        model: Model { omega: half, ..near.model },
        block: 2 * near.block,
        enclosed: 2 * near.enclosed + 1,
        orbit: Orbit::Breather { sites: 41, center: Center::Site },
        a,
        ..near
    }
}

/// The orbit of doubled period at half of this frequency.
fn doubled(omega: &str, sizes: Sizes) -> Certificate {
    solve::near(&twice(omega, 0.1, Sizes::BREATHER_PIECE), sizes).expect("an orbit")
}

#[test]
fn a_breather_of_doubled_period_is_proved() {
    let sizes = Sizes { block: 24, harmonics: 64, enclosed: 96 };
    let certificate = doubled("2.066", sizes);
    let proof = check(&certificate).unwrap();
    // The first harmonic is of the doubled period: half of it is no period.
    assert!(proof.amplitude > 0.08 && proof.radius < 2e-5 * proof.amplitude, "{proof:?}");
    assert_eq!(certificate.to_string().parse().as_ref(), Ok(&certificate));
    // Truth: the solution with four times as many harmonics.
    let better = doubled("2.066", sizes.times(4));
    within([&certificate.a, &better.a], 1.033, &proof);
    // Half a period later it is another orbit, its reflection, beyond the radius of uniqueness.
    let odd =
        |it: &mut Certificate| it.a.iter_mut().flat_map(|a| a.iter_mut().skip(1).step_by(2)).for_each(|a| *a = -*a);
    let turned = changed(&certificate, odd).unwrap();
    assert!(2.0 * proof.amplitude > proof.uniqueness_radius && turned.radius < 1.01 * proof.radius, "{turned:?}");
    // The breather of half the period is a solution, but not of this period.
    let once = check(&twice("2.066", 0.0, Sizes { block: 8, harmonics: 32, enclosed: 48 }));
    assert!(matches!(once, Err(Refused::Rest(radius, first)) if radius < 1e-4 && first == 0.0), "{once:?}");
    // The site that is its own image has even harmonics only; and another reflection is no symmetry
    // of this orbit.
    let odd = changed(&certificate, |it| it.a[0][1] = 1e-9);
    assert!(matches!(odd, Err(Refused::Certificate(rule)) if rule.contains("even harmonics only")));
    let bond = Orbit::Breather { sites: 41, center: Center::Bond };
    assert!(refused(&certificate, |it| it.orbit = bond.clone()).y0 > 1e-3);
}

/// Of a breather of the infinite chain.
fn background(certificate: &mut Certificate) -> &mut Vec<f64> {
    let Orbit::Infinite { background, .. } = &mut certificate.orbit else { panic!() };
    background
}

// Truth: the breather of a ring of 41, where the equations have an end, and its distance from the
// far site, which falls by a factor of 25 to 30 a site.
fn infinite_breathers_are_proved(cases: &[(&str, Center)]) {
    for &(omega, center) in cases {
        let ring = breather(["3/2", "1/3", omega], center, Sizes::BREATHER);
        let mut certificate = solve::unrolled(&ring, Sizes::BREATHER).unwrap();
        let proof = check(&certificate).unwrap_or_else(|why| panic!("{omega} {center:?}: {why}"));
        assert!(proof.radius < 1e-9 * proof.amplitude, "{omega} {center:?}: {proof:?}");
        assert!(proof.uniqueness_radius > 1e6 * proof.radius, "{omega} {center:?}: {proof:?}");
        assert_eq!(certificate.to_string().parse().as_ref(), Ok(&certificate));
        // The strains beyond are as near to those of the certificate as the background is.
        let a = background(&mut certificate).clone();
        let wave = Certificate {
            enclosed: a.len() - 1,
            orbit: Orbit::Wave { q_over_pi: exact("1") },
            a: vec![a],
            ..certificate.clone()
        };
        let far = check(&wave).unwrap();
        let ball = proof.bounds.y0 / (1.0 - proof.contraction);
        let share = (proof.radius - ball) / far.radius;
        assert!((share - 1.0).abs() < 1e-2, "{omega} {center:?}: {share} {proof:?} {far:?}");
        // The ends of the ring change less than the rounding errors.
        let apart = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum();
        let most = certificate.a.iter().zip(&ring.a).map(apart).fold(0.0, f64::max);
        assert!(most < proof.radius, "{omega} {center:?}: {most:e} {proof:?}");
        // The distance from the background: that of a far site an even number of sites away.
        let first = usize::from(center == Center::Bond);
        let far = |n: usize| apart((&ring.a[n], &ring.a[20 - n % 2]));
        let [decay, constant] = proof.decay.unwrap();
        for n in 0..12 {
            let bound = constant * (-decay * (n + first) as f64).exp();
            assert!(far(n) < bound, "{omega} {center:?} {n}: {:e} {bound:e}", far(n));
        }
        let rate = (far(4) / far(8)).ln() / 4.0;
        // Half of it, with two digits.
        assert!(decay < rate && decay > 0.49 * rate, "{omega} {center:?}: {decay} {rate}");
    }
}

#[test]
fn breathers_of_the_infinite_chain_are_proved() {
    infinite_breathers_are_proved(&[("2.05", Center::Site)]);
}

#[test]
#[ignore = "nightly: other frequencies and the other centre"]
fn other_breathers_of_the_infinite_chain_are_proved() {
    infinite_breathers_are_proved(&[("2.05", Center::Bond), ("2.09", Center::Site), ("2.09", Center::Bond)]);
}

#[test]
fn what_is_no_breather_of_the_infinite_chain_is_refused() {
    let sizes = Sizes { block: 6, harmonics: 32, enclosed: 32 };
    let certificate = solve::unrolled(&breather(["3/2", "1/3", "2.09"], Center::Site, sizes), sizes).unwrap();
    assert!(check(&certificate).is_ok());
    // Coefficients of the background, and of a site, moved by 5 percent.
    let why = changed(&certificate, |it| background(it)[1] *= 1.05).unwrap_err();
    assert!(matches!(&why, Refused::Background(why) if matches!(**why, Refused::Bounds(it) if it.y0 > 1e-3)), "{why}");
    assert!(why.to_string().starts_with("the standing wave far from the centre: Y0 = "), "{why}");
    assert!(refused(&certificate, |it| it.a[5][1] *= 1.05).y0 > 1e-3);
    // Sites that still differ from the background are left out.
    assert!(refused(&certificate, |it| it.a.truncate(2)).y0 > 1e-3);
    // Faster than it decays, 3.4; the inverse couples neighbours only.
    let of = |rate: Option<&str>, to: usize| {
        changed(&certificate, |it| {
            let Orbit::Infinite { decay, band, .. } = &mut it.orbit else { panic!() };
            (*decay, *band) = (rate.map_or(*decay, exact), to);
        })
    };
    let Orbit::Infinite { band, .. } = certificate.orbit else { panic!() };
    assert!(matches!(of(Some("4"), band), Err(Refused::Bounds(bounds)) if bounds.z1 > 1.0));
    let why = of(None, 1).unwrap_err();
    assert!(matches!(why, Refused::Kernel(..)) || matches!(why, Refused::Bounds(it) if it.z1 > 1.0), "{why}");
    // The opposite phase of the background, which no breather of this centre has.
    assert!(refused(&certificate, |it| background(it).iter_mut().for_each(|a| *a = -*a)).y0 > 1e-3);
    let why = changed(&certificate, |it| it.a[0][1] = 0.1).unwrap_err();
    assert!(matches!(&why, Refused::Certificate(rule) if rule.contains("even harmonics only")), "{why}");
    broken(
        &certificate.to_string(),
        &[
            ("rho 1/3", "rho inf", "rho must be finite"),
            ("decay ", "decay -", "decay must be above 0"),
            ("decay ", "decay 9", "decay times the sites must be below 500"),
            ("band ", "band 1000000000000", "band must be from 1 to 401"),
            ("band ", "band 1844674407370955161", "band must be from 1 to 401"),
            ("band ", "band 30", "at most 2500 unknowns"),
            ("block ", "to 2 0\nblock ", "no piece of a branch"),
            ("background ", "ground ", "background is missing"),
            ("background ", "background 0000000000000000\nbackground ", "is not expected here"),
        ],
    );
}

#[test]
#[ignore = "nightly: eight breathers take half a minute"]
fn breathers_are_proved() {
    for center in [Center::Site, Center::Bond] {
        for (rho, omega) in [("1/3", "2.02"), ("1/3", "2.05"), ("1/3", "2.09"), ("3", "1.2547")] {
            proved(["3/2", rho, omega], center);
        }
    }
}

/// A breather of this mean strain.
fn dark([rho, omega, mean]: [&str; 3], center: Center, sizes: Sizes) -> Certificate {
    let near = Certificate { mean: exact(mean), ..breather(["3/2", rho, omega], center, sizes) };
    solve::near(&near, sizes).expect("a breather")
}

/// With the line of a multiplier within `width` of this one.
fn growing(certificate: &Certificate, multiplier: f64, width: f64) -> Certificate {
    let rate = |to: f64| (multiplier + to).ln() * double(certificate.model.omega) / (2.0 * PI);
    let rates = [-width, width].map(|to| Exact::of_double((rate(to) * 1e18).round() / 1e18).unwrap());
    Certificate { multiplier: Some(Multiplier::Growing(rates)), ..certificate.clone() }
}

// Truth: the largest real multipliers of `breather dark`, from tangent maps, with these mean
// strains.
#[test]
fn bond_centred_breathers_are_unstable() {
    let cases = [
        (["1/3", "2.05", "-0.002840489907983833"], 1.075_209_459_199_120_1),
        (["3", "1.2547", "-0.00052942931659183"], 1.213_989_977_830_170_6),
    ];
    for (parameters, truth) in cases {
        let certificate = dark(parameters, Center::Bond, Sizes::BREATHER);
        let near = growing(&certificate, truth, 4e-7);
        let proof = check(&near).unwrap_or_else(|why| panic!("{parameters:?}: {why}"));
        let [from, to] = proof.multiplier.unwrap();
        assert!(1.0 < from && from < truth && truth < to && to - from < 1e-6, "{parameters:?}: {proof:?}");
        // Resonators have the mean of their beads, even where they move less.
        assert!(proof.radius_y >= proof.radius, "{parameters:?}: {proof:?}");
        assert_eq!(near.to_string().parse(), Ok(near));
        // Nothing is proved of an interval beside it: g has one sign.
        if truth < 1.1 {
            let beside = check(&growing(&certificate, truth - 1e-6, 4e-7));
            let Err(Refused::Multiplier { g: Some([[a, b], [c, d]]), .. }) = beside else { panic!("{beside:?}") };
            assert!(a * b > 0.0 && c * d > 0.0 && a * c > 0.0, "{parameters:?}: {beside:?}");
        }
    }
}

#[test]
fn multipliers_that_are_not_there_are_refused() {
    // A site-centred breather has no real multiplier but 1.
    let site = dark(["1/3", "2.05", "-0.003065491333325929"], Center::Site, Sizes::BREATHER);
    for (truth, width) in [(1.075_209, 4e-7), (1.01, 1e-3)] {
        let refused = check(&growing(&site, truth, width));
        assert!(matches!(refused, Err(Refused::Multiplier { .. })), "{truth}: {refused:?}");
    }
    // A breather that is none.
    let mut moved = growing(&dark(["1/3", "2.05", "0"], Center::Bond, Sizes::BREATHER), 1.075, 1e-2);
    moved.a[1][1] *= 1.05;
    assert!(matches!(check(&moved), Err(Refused::Bounds(_))));
    // Rules.
    let small = Sizes { block: 1, harmonics: 4, enclosed: 4 };
    let lines = |certificate: &Certificate, cases: &[(&str, &str)]| {
        let lines: Vec<String> =
            cases.iter().map(|(line, _)| format!("block 1\nenclosed 4\nmultiplier {line}")).collect();
        let cases: Vec<_> =
            lines.iter().zip(cases).map(|(to, (_, words))| ("block 1\nenclosed 4", &**to, *words)).collect();
        broken(&certificate.to_string(), &cases);
    };
    lines(
        &dark(["1/3", "2.05", "0"], Center::Bond, small),
        &[
            ("growing 1/50 1/100", "the larger one last"),
            ("growing 0 1/100", "growth rates above 0"),
            ("growing 1/100", "is no multiplier: growing with two growth rates"),
            ("-1 sine", "of a piece of a branch"),
            ("-1 sines", "-1 with cosine or sine"),
        ],
    );
    lines(
        &tw_q15(small),
        &[
            ("growing 1/100 1/50", "of one breather of a ring"),
            ("bloch 1/25 2e-3 0 1/1000", "is no bloch"),
            ("bloch 1/25 1/500 0 0", "radius, growth rate"),
            ("bloch 1/25 1/500 0 1/500", "radius, growth rate"),
            ("bloch 1/25 1/20 1/500 0 1/500 0 1/100000", "radius, growth rate"),
            ("bloch 1/25 1/500 2 1/100", "omega - |frequency|"),
            ("bloch 1/25 1/50 1/500 0 0 0 1/1000", "the larger one is last"),
            ("bloch 1/25 1/500 0", "bloch: p/pi, a growth rate, a frequency and a radius"),
            (
                "bloch 1/25 2/25 1/500 0 0 0 1/1000\nmultiplier bloch 3/25 4/25 1/500 0 0 0 1/1000",
                "each begins where the one before it ends",
            ),
        ],
    );
}

/// With the line of a perturbation of the Bloch wave number `p`, and of a `lambda` within `radius`
/// of this one.
fn bloch(certificate: &Certificate, p_over_pi: &str, rate: [f64; 2], radius: f64) -> Certificate {
    let decimal = |x: f64| Exact::of_double((x * 1e18).round() / 1e18).unwrap();
    let (rate, change) = (rate.map(decimal), [Exact::ZERO; 2]);
    let bloch = vec![Bloch { p_over_pi: [exact(p_over_pi); 2], rate, change, radius: decimal(radius) }];
    Certificate { bloch, ..certificate.clone() }
}

/// A piece of the branch of bond-centred breathers, with a mean strain near that of its period
/// doubling.
fn piece([from, to]: [&str; 2], sine: bool, sizes: Sizes) -> Certificate {
    static NEAR: LazyLock<Certificate> =
        LazyLock::new(|| dark(["1/3", "2.0632584520", "-0.004294689811108139"], Center::Bond, Sizes::BREATHER));
    let omega = Exact::of_double(0.5 * (double(exact(from)) + double(exact(to)))).unwrap();
    let near = Certificate { model: Model { omega, ..NEAR.model }, ..NEAR.clone() };
    let found = solve::near(&near, sizes).expect("a breather");
    let (model, to) = (Model { omega: exact(from), ..near.model }, Some([exact(to), near.mean]));
    Certificate { model, to, multiplier: Some(Multiplier::Doubling { sine }), ..found }
}

// Truth: the frequency at which `breather continue --bifurcations` finds the period doubling,
// 2.0632584520.
#[test]
fn the_period_doubles_where_the_multipliers_say() {
    let [from, to] = ["2.0632583", "2.0632586"];
    let ends = [[from, from], [from, to], [to, to]];
    let proved = |sine: bool, ends: &[[&str; 2]]| {
        let checked = |ends: &[&str; 2]| {
            let piece = piece(*ends, sine, Sizes::BREATHER);
            let proof = check(&piece);
            (piece, proof)
        };
        ends.iter().map(checked).collect::<Vec<_>>()
    };
    let mut pieces = proved(true, &ends);
    assert_eq!(connected(&pieces), (3, None));
    let holds = |found: Vec<Result<[f64; 2], _>>, [from, to]: [f64; 2]| matches!(found[..], [Ok([a, b])] if a <= from && to <= b && b - a < to - from + 1e-14);
    assert!(holds(doublings(&pieces), [double(exact(from)), double(exact(to))]));
    // The bounds hold frequencies that a curve goes to and comes back from.
    let detour = proved(true, &[[from, from], [from, "2.063259"], ["2.063259", to], [to, to]]);
    assert_eq!(connected(&detour), (4, None));
    assert!(holds(doublings(&detour), [double(exact(from)), 2.063259]));
    // The text of a piece has its line.
    assert_eq!(pieces[1].0.to_string().parse().as_ref(), Ok(&pieces[1].0));
    // The bounds of g hold for a whole piece.
    let g = |at: usize| pieces[at].1.as_ref().unwrap().multiplier.unwrap();
    assert!(g(1)[0] < g(2)[0] && g(2)[1] < 0.0 && 0.0 < g(0)[0] && g(0)[1] < g(1)[1], "{pieces:?}");
    // Without the piece between them the ends show nothing, and perturbations by cosines do not
    // double there: what their lines claim is refused.
    drop(pieces.remove(1));
    assert_eq!((connected(&pieces), doublings(&pieces)), ((1, Some(Gap::Nodes)), vec![Err(0..1)]));
    let pieces = proved(false, &ends[1..]);
    assert!(connected(&pieces) == (2, None) && doublings(&pieces) == [Err(0..2)], "{pieces:?}");
}

// Truth: multipliers of `wave exact`, eigenvalues of the tangent map of a cell, at these mean
// strains.
#[test]
fn waves_are_unstable() {
    let cases = [
        (["3/2", "1/3", "2.001"], ["1/5", "0.05711311299994293"], "1", [0.001_710_320_184_808_556_2, 0.0], 5e-9),
        (
            ["3/2", "3", "1.1568748108437075"],
            ["1/5", "0.009999999999999646"],
            "-24/25",
            [0.003_625_283_448_852_893, 0.000_449_449_422_499_456_96],
            5e-9,
        ),
        (
            ["3/2", "inf", "1.255116002817007"],
            ["4/5", "0"],
            "1/5",
            [0.034_908_513_057_323_384, -0.046_265_366_366_693_83],
            5e-8,
        ),
    ];
    for (parameters, q, p, truth, radius) in cases {
        let certificate = wave(parameters, q, Sizes::WAVE);
        let near = bloch(&certificate, p, truth, radius);
        let proof = check(&near).unwrap_or_else(|why| panic!("{parameters:?} {p}: {why}"));
        let [from, to] = proof.multiplier.unwrap();
        let modulus = |rate: f64| (rate * 2.0 * PI / double(certificate.model.omega)).exp();
        let within = |x: f64, near: f64| (x - near).abs() < 1e-3 * radius;
        assert!(within(from, modulus(truth[0] - radius)) && within(to, modulus(truth[0] + radius)), "{proof:?}");
        assert_eq!(near.to_string().parse(), Ok(near));
        // Nothing is proved beside it, 5 percent away or two radii, nor of another wave number.
        let other = if p == "1" { "24/25" } else { "1" };
        let moved = |by: [f64; 2]| [truth[0] + by[0], truth[1] + by[1]];
        for (p, lambda) in [
            (p, moved([0.05 * truth[0], 0.0])),
            (p, moved([2.0 * radius, 0.0])),
            (p, moved([0.0, -2.0 * radius])),
            (other, truth),
        ] {
            let refused = check(&bloch(&certificate, p, lambda, radius));
            let Err(Refused::Bloch { q, radius: needed, .. }) = refused else { panic!("{refused:?}") };
            assert!(q >= 1.0 || needed > radius, "{parameters:?} {p}: {refused:?}");
        }
    }
}

// Truth: multipliers of `wave exact tw-q15`, eigenvalues of the tangent map of a cell, at these
// p/pi.
#[test]
fn waves_are_unstable_at_all_modulations_of_an_interval() {
    const MULTIPLIERS: [[f64; 3]; 2] = [
        [0.96, 0.001_702_363_815_139_68, -0.000_216_145_992_874_912_33],
        [0.52, 0.000_812_509_427_775_631, -0.001_686_726_073_371_911_1],
    ];
    let certificate = wave(["3/2", "1/3", "2.001"], ["1/5", "0.05711311299994293"], Sizes::WAVE);
    for [p, growth, frequency] in MULTIPLIERS {
        let ends = [p - 1e-3, p + 1e-3];
        let found = modulations::pieces(&certificate, ends, &[[p, growth, frequency]], &|| false).unwrap();
        let whole = Certificate { bloch: found.clone(), ..certificate.clone() };
        let [all, largest, turns] = check(&whole).unwrap().growth.unwrap();
        assert!(all[0] < growth && growth < all[1] && turns[0] < frequency && frequency < turns[1], "{all:?}");
        assert!(all[1] - all[0] < 0.01 * growth && largest[0] > growth && largest[1] == all[1], "{all:?} {largest:?}");
        assert_eq!(whole.to_string().parse().as_ref(), Ok(&whole));
        let reached = [found[0].p_over_pi[0], found[found.len() - 1].p_over_pi[1]].map(double);
        assert!(found.len() > 1 && reached == ends, "{found:?}");
        // Wider pieces, other rates and slopes, and smaller radii.
        let [first, last] = [found[0], found[found.len() - 1]];
        let minus = |it: [Exact; 2]| it.map(|it| Exact::new(-it.num(), it.den()).unwrap());
        let half = |it: Exact| Exact::new(it.num(), 2 * it.den()).unwrap();
        for forged in [
            Bloch { p_over_pi: ends.map(|p| exact(&format!("{p:.3}"))), ..first },
            Bloch { p_over_pi: [first.p_over_pi[0], exact("0.99")], ..first },
            Bloch { rate: last.rate, ..first },
            Bloch { change: minus(first.change), ..first },
            Bloch { rate: [first.rate[0], minus(first.rate)[1]], ..first },
            Bloch { radius: half(first.radius), ..first },
        ] {
            let refused = check(&Certificate { bloch: vec![forged], ..certificate.clone() });
            assert!(matches!(refused, Err(Refused::Bloch { .. })), "{forged:?}: {refused:?}");
        }
    }
}
