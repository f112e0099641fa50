//! Nonlinear normal modes of conservative chains.

use crate::{common::at_end, numbers::rk4, switching::followed};
use hertzchain::{
    chain::{Boundary, Chain, Details, Params},
    dps::{Center, Homoclinic},
    integrators::collocation::StepControl,
    orbits::{BifurcationKind, End, ModeBranch, ModeContinuation, ModeOrbit, NormalModes},
    scene::Scene,
};
use std::f64::consts::PI;

/// A plain chain of power 3/2 with the overlap 1 at every contact.
fn chain(boundary: Boundary, sites: usize, details: &Details) -> Chain<f64> {
    let plain = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), boundary, sites).unwrap();
    plain.precompressed(1.0).unwrap().with(details).unwrap()
}

fn branch(modes: &NormalModes, mode: usize, step: f64, to: f64) -> ModeBranch {
    followed(ModeContinuation { mode, to, step, most_points: 100 }.begin(modes).unwrap())
}

/// The integral from 0 to 1, by 200 panels of five Gauss nodes.
fn integral(f: impl Fn(f64) -> f64) -> f64 {
    let root = (10.0f64 / 7.0).sqrt();
    let nodes = [(5.0 - 2.0 * root).sqrt() / 3.0, (5.0 + 2.0 * root).sqrt() / 3.0];
    let weights = [322.0 + 13.0 * 70f64.sqrt(), 322.0 - 13.0 * 70f64.sqrt()].map(|w| w / 900.0);
    let h = 1.0 / 200.0;
    let panel = |k: i32| {
        let (middle, half) = ((f64::from(k) + 0.5) * h, 0.5 * h);
        let pair = |i: usize| weights[i] * (f(middle - half * nodes[i]) + f(middle + half * nodes[i]));
        half * (128.0 / 225.0 * f(middle) + pair(0) + pair(1))
    };
    (0..200).map(panel).sum()
}

#[test]
fn a_mode_that_begins_with_a_long_step_is_that_of_short_steps() {
    // From the linear mode at a = 1.2 Newton's method leads to another family, with omega = 1.53495
    // at a = 1.3.
    let four = ["chain.boundary=fixed", "chain.sites=4", "chain.precompression=1"].map(str::to_owned);
    let modes = NormalModes::new(Scene::load_with("dimer", &four).unwrap().chain()).unwrap();
    let [short, long] = [0.05, 1.2].map(|step| branch(&modes, 1, step, 1.3));
    let [want, got] = [&short, &long].map(|branch| &branch.points.last().unwrap().orbit);
    assert_eq!([short.ended(), long.ended()], [End::Reached; 2]);
    assert!(long.points[0].orbit.amplitude < 1.2);
    assert!((want.omega / got.omega - 1.0).abs() < 1e-9, "{} {}", want.omega, got.omega);
}

#[test]
fn one_bead_between_walls_has_the_period_of_its_potential() {
    let modes = NormalModes::new(&chain(Boundary::Fixed, 1, &Details::default())).unwrap();
    assert!((modes.linear()[0].omega - 3f64.sqrt()).abs() < 1e-15);
    // Contacts are apart for a part of the time where a > 1.
    let branch = branch(&modes, 0, 0.5, 4.0);
    assert_eq!(branch.ended(), End::Reached);
    for point in &branch.points {
        let a = point.orbit.amplitude;
        let energy = |x: f64| 0.4 * ((1.0 + x).max(0.0).powf(2.5) + (1.0 - x).max(0.0).powf(2.5));
        // x = a sin(theta); at x = 1 a contact opens.
        let rate = |theta: f64| a * theta.cos() / (2.0 * (energy(a) - energy(a * theta.sin()))).sqrt();
        let quarter = if a < 1.0 {
            integral(|s| 0.5 * PI * rate(0.5 * PI * s))
        } else {
            let (opens, rest) = ((1.0 / a).asin(), 0.5 * PI - (1.0 / a).asin());
            // The power 5/2 of 1 - x is analytic in s.
            integral(|s| 2.0 * s * opens * rate(opens * (1.0 - s * s))) + integral(|s| rest * rate(opens + s * rest))
        };
        let omega = 0.5 * PI / quarter;
        // Measured: 4.3e-12, 2.6e-16, 4.2e-14.
        assert!((point.orbit.omega / omega - 1.0).abs() < 9e-12, "a = {a}: {} {omega}", point.orbit.omega);
        assert!((point.measures.energy - (energy(a) - energy(0.0))).abs() < 6e-16 * energy(a));
        assert!((point.measures.least_overlap - (1.0 - a)).abs() < 1e-13);
    }
    assert!(branch.points.iter().filter(|point| point.orbit.amplitude > 1.0).count() > 3);
}

#[test]
fn a_column_oscillates_about_its_overlaps() {
    // Truth: two beads on the right wall under gravity 0.1. Contacts have the forces 0.1 and 0.2
    // and the stiffness 3/2 f^{1/3}; then the eigenvalues of [[a, -a], [-a, a + b]] by hand.
    let details = Details { gravity: 0.1, ..Details::default() };
    let column = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::RightWall, 2).unwrap();
    let modes = NormalModes::new(&column.with(&details).unwrap()).unwrap();
    let [a, b] = [0.1f64, 0.2].map(|force| 1.5 * force.cbrt());
    let root = (a * a + 0.25 * b * b).sqrt();
    for (mode, square) in modes.linear().iter().zip([a + 0.5 * b - root, a + 0.5 * b + root]) {
        assert!((mode.omega * mode.omega / square - 1.0).abs() < 1e-13, "{} {square}", mode.omega);
    }
    // The energy of small orbits, a^2 omega^2 sum m s^2/2: weights have done their work.
    let branch = branch(&modes, 0, 1e-4, 2e-4);
    let (linear, point) = (&modes.linear()[0], &branch.points[0]);
    let shape: f64 = linear.shape.iter().map(|s| s * s).sum();
    let want = 0.5 * shape * (point.orbit.amplitude * linear.omega).powi(2);
    assert!((point.measures.energy / want - 1.0).abs() < 1e-3, "{} {want}", point.measures.energy);
}

#[test]
fn a_light_bead_rings_above_the_band_and_softens_with_the_square_of_the_amplitude() {
    let mu = 1.0 / 3.0;
    let mut mass = vec![1.0; 41];
    mass[20] = mu;
    let modes = NormalModes::new(&chain(Boundary::Fixed, 41, &Details { mass, ..Details::default() })).unwrap();
    let mode = modes.most_localised();
    let linear = &modes.linear()[mode];
    assert_eq!((mode, modes.place(linear.leading)), (40, (20, false)));
    // In the infinite chain of springs k: omega^2 = 4 k/(mu (2 - mu)), and 4 k ends the band.
    let omega = (6.0 / (mu * (2.0 - mu))).sqrt();
    // Measured here: half a rounding, and 0 below. Products of matrices round as the machine has
    // them, so that bounds of linear algebra in this file leave room for some ten roundings.
    assert!((linear.omega / omega - 1.0).abs() < 3e-15);
    assert!(modes.linear()[39].omega < 6f64.sqrt());
    // Neighbours fall off by the root of z + 1/z = 2 - omega^2/k.
    let c = 2.0 - omega * omega / 1.5;
    let z = 0.5 * (c + (c * c - 4.0).sqrt());
    assert!((linear.shape[25] / linear.shape[24] - z).abs() < 3e-15);

    let shift = |a: f64| branch(&modes, mode, a, 2.0 * a).points.iter().map(|p| p.orbit.omega - omega).collect();
    let shifts: Vec<f64> = shift(0.01);
    let slope = (shifts.last().unwrap() / shifts[0]).log2();
    assert!((slope - 2.0).abs() < 3e-4 && shifts[0] < 0.0, "{slope}");
}

/// Collocation shares nothing with the search but the chain.
#[test]
fn orbits_of_the_defect_come_back_also_where_contacts_open() {
    let scene = Scene::load_with("defect", &[]).unwrap();
    let modes = NormalModes::new(scene.chain()).unwrap();
    let branch = branch(&modes, modes.most_localised(), 0.1, 1.2);
    assert_eq!(branch.ended(), End::Reached);
    assert!(branch.points.last().unwrap().measures.least_overlap < -0.5);
    for point in &branch.points {
        let (period, start) = (2.0 * PI / point.orbit.omega, modes.state(&point.orbit));
        let end = at_end(scene.chain(), &start, period, 1e-14);
        let apart = end.iter().zip(start.as_slice()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Measured: 5.0e-13 and 1.5e-15.
        assert!(apart < 1e-12 && point.orbit.residual < 1e-14, "{apart:e} {:e}", point.orbit.residual);
        let quality = point.spectrum.quality;
        // The tolerance of a step is 1e-12; a double multiplier errs by more. Measured: 3.0e-12,
        // and 2.6e-11 at the largest amplitude.
        assert!(quality.symplectic_defect < 6e-12 && quality.trivial[0] < 5e-11, "{quality:?}");
    }
}

#[test]
fn multipliers_of_small_orbits_are_those_of_the_other_linear_modes() {
    let scene = Scene::load_with("defect", &[]).unwrap();
    let modes = NormalModes::new(scene.chain()).unwrap();
    let worst = |a: f64| {
        let branch = branch(&modes, 20, a, 2.0 * a);
        let point = &branch.points[0];
        assert_eq!(point.spectrum.unstable(), 0);
        let cosines: Vec<f64> = point.spectrum.tau.iter().map(|tau| tau.re).collect();
        let nearest = |wanted: f64| cosines.iter().map(|tau| (tau - wanted).abs()).fold(f64::INFINITY, f64::min);
        let others = modes.linear()[..20].iter().map(|mode| (2.0 * PI * mode.omega / point.orbit.omega).cos());
        others.map(nearest).fold(0.0, f64::max)
    };
    let [large, small] = [0.02, 0.01].map(worst);
    // Measured: 2.3e-6, 2.0002.
    assert!(small < 5e-6 && ((large / small).log2() - 2.0).abs() < 4e-4, "{large:e} {small:e}");
}

/// Half the trace of the map over a period that the antiphase motion `q = u_0 = -u_1` of two beads
/// makes of a small motion in phase: `q'' = (1 - q)^2 - C (w + 2 q)^2` with `C w^2 = 1`, and
/// `d'' = -2 (1 - q) d`. By the method of Runge and Kutta, from one time of rest to the next.
fn transverse(a: f64, c: f64) -> f64 {
    let w = c.powf(-0.5);
    let rates = |y: &[f64]| {
        let [q, p, d, e, f, g] = y[..] else { panic!("{y:?}") };
        let k = 2.0 * (1.0 - q);
        vec![p, (1.0 - q).powi(2) - c * (w + 2.0 * q).powi(2), e, -k * d, g, -k * f]
    };
    let step = |y: &[f64], h: f64| rk4(&rates, y, h);
    let (mut y, h) = (vec![a, 0.0, 1.0, 0.0, 0.0, 1.0], 1e-3);
    loop {
        let next = step(&y, h);
        if y[1] < 0.0 && next[1] >= 0.0 {
            break;
        }
        y = next;
    }
    let (mut low, mut high) = (0.0, h);
    while high - low > 1e-16 {
        let middle = 0.5 * (low + high);
        if step(&y, middle)[1] < 0.0 { low = middle } else { high = middle }
    }
    // With a time of rest at both ends the trace of the second half follows from the first.
    let [_, _, d, e, f, g] = step(&y, low)[..] else { panic!() };
    d * g + e * f
}

#[test]
fn period_doublings_of_two_beads_are_where_hills_equation_has_them() {
    // Truth: where the half trace of the equation above is -1, by bisection; no contact opens.
    let c = 2.0;
    let crossing = |mut low: f64, mut high: f64| {
        let sign = transverse(low, c) + 1.0;
        while high - low > 1e-13 {
            let middle = 0.5 * (low + high);
            if (transverse(middle, c) + 1.0) * sign > 0.0 { low = middle } else { high = middle }
        }
        low
    };
    let want = [crossing(0.05, 0.2), crossing(0.2, 0.3)];
    let scene = Scene::load(include_str!("../reference/two-beads.toml")).unwrap();
    let modes = NormalModes::new(scene.chain()).unwrap();
    let branch = branch(&modes, 1, 0.04, 0.32);
    assert_eq!((branch.ended(), branch.unresolved), (End::Reached, 0));
    assert_eq!(branch.bifurcations.len(), 2, "{:?}", branch.bifurcations);
    // Measured: 4e-12.
    for (one, want) in branch.bifurcations.iter().zip(want) {
        let orbit = &one.orbit;
        println!("{:e} {:e} {:e}", orbit.amplitude, orbit.amplitude - want, one.critical.tau + 1.0);
        assert_eq!(one.kind, BifurcationKind::PeriodDoubling);
        assert!((orbit.amplitude - want).abs() < 1e-11 && orbit.residual < 1e-11);
    }
}

/// Number of `tau` within 1e-7 of 1, from the tangent map of contact collocation over a period: of
/// `M(T)` the block of displacements.
fn at_one(scene: &Scene, modes: &NormalModes, orbit: &ModeOrbit) -> usize {
    let (start, period) = (modes.state(orbit), 2.0 * PI / orbit.omega);
    let (n, dim) = (scene.chain().sites(), start.as_slice().len());
    let columns = scene.chain().monodromy(start.as_slice(), (0.0, period), StepControl::Tolerance(1e-13)).unwrap();
    let block = nalgebra::DMatrix::from_fn(n, n, |i, j| columns[j * dim + i]);
    block.complex_eigenvalues().iter().filter(|tau| (*tau - 1.0).norm() < 1e-7).count()
}

#[test]
fn a_mode_of_a_ring_loses_its_stability_where_collocation_has_two_more_multipliers_at_one() {
    // Truth: the tangent map of contact collocation, of which the search knows nothing. On a ring
    // two tau are 1; the two that cross are equal by symmetry.
    let ring = ["chain.boundary=ring", "chain.sites=24", "chain.precompression=1"].map(str::to_owned);
    let scene = Scene::load_with("dimer", &ring).unwrap();
    let modes = NormalModes::new(scene.chain()).unwrap();
    let branch = branch(&modes, 11, 0.05, 0.5);
    assert_eq!((branch.bifurcations.len(), branch.unresolved), (1, 0));
    let one = &branch.bifurcations[0];
    println!("{} {:e}", one.orbit.amplitude, one.critical.tau - 1.0);
    assert_eq!((one.kind, at_one(&scene, &modes, &one.orbit)), (BifurcationKind::PlusOne, 4));
    for point in &branch.points {
        assert_eq!(point.spectrum.unstable() > 0, point.orbit.amplitude > one.orbit.amplitude);
        assert_eq!(at_one(&scene, &modes, &point.orbit), 2, "{}", point.orbit.amplitude);
    }
}

#[test]
fn unequal_contacts_have_their_own_equilibrium_and_resonators_their_springs() {
    let [c1, c2, rho] = [1.0f64, 3.0, 0.5];
    let plain = Chain::new(Params::new(1.5, 2.0, rho).unwrap(), Boundary::Fixed, 1).unwrap();
    let details = Details { contact: vec![c1, c2], ..Details::default() };
    let modes = NormalModes::new(&plain.precompressed(1.0).unwrap().with(&details).unwrap()).unwrap();
    // c_1 (1 - x)^{3/2} = c_2 (1 + x)^{3/2}.
    let ratio = (c1 / c2).powf(2.0 / 3.0);
    let x = (ratio - 1.0) / (ratio + 1.0);
    let k = 1.5 * (c1 * (1.0 - x).sqrt() + c2 * (1.0 + x).sqrt());
    // Eigenvalues of [[k + 2, -2], [-2/rho, 2/rho]].
    let (trace, det) = (k + 2.0 + 2.0 / rho, 2.0 * k / rho);
    let root = (0.25 * trace * trace - det).sqrt();
    for (mode, square) in modes.linear().iter().zip([0.5 * trace - root, 0.5 * trace + root]) {
        assert!((mode.omega - square.sqrt()).abs() < 3e-15, "{} {}", mode.omega, square.sqrt());
    }
    let orbit = &branch(&modes, 0, 1e-3, 2e-3).points[0].orbit;
    assert!((modes.state(orbit).u()[0] - orbit.amplitude * orbit.shape[0] - x).abs() < 1e-15);
}

/// A plain chain between walls whose beads just touch.
fn touching(alpha: f64, sites: usize, details: &Details) -> Chain<f64> {
    let plain = Chain::new(Params::new(alpha, 0.0, 0.0).unwrap(), Boundary::Fixed, sites).unwrap();
    plain.with(details).unwrap()
}

/// The time from rest at `a` to the middle, of `m x'' = -c x^alpha`: `(m/c)^{1/2} a^{(1 -
/// alpha)/2}` times the integral from 0 to 1 of `((alpha + 1)/(2 (1 - s^{alpha+1})))^{1/2}`, which
/// is `B(1/(alpha+1), 1/2) (2 (alpha+1))^{-1/2}`.
fn quarter(alpha: f64, c: f64, a: f64) -> f64 {
    // s = 1 - x^2; the power of s is smooth enough in y, s = y^4, beside s = 0.
    let slow = |s: f64| (0.5 * (alpha + 1.0) / (1.0 - s.powf(alpha + 1.0))).sqrt();
    let half = 0.5f64;
    let (top, low) = (half.sqrt(), half.powf(0.25));
    let near = integral(|x| 2.0 * top * top * x * slow(1.0 - (top * x).powi(2)));
    let far = integral(|y| 4.0 * low.powi(4) * y.powi(3) * slow((low * y).powi(4)));
    (near + far) / c.sqrt() * a.powf(0.5 * (1.0 - alpha))
}

#[test]
fn beads_that_just_touch_have_modes_in_closed_form_and_their_law_of_energy() {
    // Truth: one bead between walls; two in antiphase, which compress their contact, of constant
    // 2^alpha for one of them, to a and the walls to b, with 2^alpha a^{alpha+1} = b^{alpha+1}. The
    // Beta function at alpha = 3/2: B(2/5, 1/2) = 3.6790939804. By scaling omega is proportional to
    // E^{(alpha-1)/(2(alpha+1))} for all modes.
    assert!((quarter(1.5, 1.0, 1.0) * 5f64.sqrt() - 3.679_093_980_4).abs() < 1e-9, "{}", quarter(1.5, 1.0, 1.0));
    for alpha in [1.5, 2.0, 3.0] {
        let one = NormalModes::new(&touching(alpha, 1, &Details::default())).unwrap();
        let two = NormalModes::new(&touching(alpha, 2, &Details::default())).unwrap();
        assert!(one.vacuum() && two.vacuum() && two.linear().len() == 2);
        let law = 0.5 * (alpha - 1.0) / (alpha + 1.0);
        for (modes, mode) in [(&one, 0), (&two, 0), (&two, 1)] {
            let branch = branch(modes, mode, 0.1, 1.0);
            assert_eq!(branch.ended(), End::Reached);
            for point in &branch.points {
                let a = point.orbit.amplitude;
                let scaled = point.orbit.omega * point.measures.energy.powf(-law);
                let first = &branch.points[0];
                let want = first.orbit.omega * first.measures.energy.powf(-law);
                assert!((scaled / want - 1.0).abs() < 1e-9, "{alpha}: {scaled} {want}");
                // All multipliers are 1 or -1: in antiphase a common shift moves freely while the
                // beads press each other, and like u' while they press the walls.
                assert!(mode == 0 || point.spectrum.unstable() == 0, "{alpha}: {:?}", point.spectrum.multipliers);
                let quarters = match (modes.linear().len(), mode) {
                    (1, _) => 4.0 * quarter(alpha, 1.0, a),
                    (_, 1) => {
                        let c = 2f64.powf(alpha);
                        2.0 * (quarter(alpha, c, a) + quarter(alpha, 1.0, a * c.powf(1.0 / (alpha + 1.0))))
                    }
                    _ => continue,
                };
                let omega = 2.0 * PI / quarters;
                assert!((point.orbit.omega / omega - 1.0).abs() < 1e-9, "{alpha}: {} {omega}", point.orbit.omega);
            }
        }
    }
}

#[test]
fn modes_of_beads_that_just_touch_come_back_by_collocation() {
    // Collocation shares nothing with the search but the chain; in phase a bead waits for the
    // other.
    for (sites, mode, mass) in [(2, 0, 1.0), (2, 1, 0.4), (3, 0, 1.0), (3, 2, 1.0), (5, 4, 1.0)] {
        let mut masses = vec![1.0; sites];
        masses[sites - 1] = mass;
        let chain = touching(1.5, sites, &Details { mass: masses, ..Details::default() });
        let modes = NormalModes::new(&chain).unwrap();
        let way = ModeContinuation { mode, to: 2.0, step: 1.0, most_points: 3 };
        let orbit = way.begin(&modes).unwrap().orbits[0].clone();
        let (period, start) = (2.0 * PI / orbit.omega, modes.state(&orbit));
        let end = at_end(&chain, &start, period, 1e-13);
        let off = start.as_slice().iter().zip(&end).fold(0.0, |off: f64, (a, b)| off.max((a - b).abs()));
        println!("{sites} beads, mode {mode}: {off:e}, {:?}", orbit.shape);
        assert!(off < 1e-9, "{sites} {mode}: {off:e}");
    }
}

/// The cradle: beads on springs that just touch.
fn cradle(sites: usize) -> NormalModes {
    let chain = Chain::new(Params::new(1.5, 1.0, f64::INFINITY).unwrap(), Boundary::Free, sites).unwrap();
    NormalModes::new(&chain).unwrap()
}

/// Amplitude of the breather of the DpS equation whose frequency is `1 + shift`.
fn amplitude(profile: &Homoclinic, shift: f64) -> f64 {
    2.0 * (shift / profile.omega_0()).powi(2) * profile.a(0).abs()
}

#[test]
fn breathers_of_the_cradle_tend_to_those_of_the_dps_equation() {
    // Truth: u_n = 2 epsilon a_n with the frequency 1 + omega_0 epsilon^{1/2}; what is left out is
    // of the relative order omega_b - 1, so that errors fall by 2 with it.
    for (center, sites, c) in [(Center::Site, 11, 5), (Center::Bond, 12, 5)] {
        let (modes, profile) = (cradle(sites), Homoclinic::new(1.5, center).unwrap());
        assert_eq!(modes.most_localised(), c);
        let error = |shift: f64| {
            let step = amplitude(&profile, shift);
            let begun = ModeContinuation { mode: c, to: 2.0 * step, step, most_points: 2 }.begin(&modes).unwrap();
            let orbit = &begun.orbits[0];
            assert_eq!(orbit.amplitude, step);
            let frequency = (orbit.omega - 1.0) / shift - 1.0;
            let shape = (orbit.shape[c - 1] - profile.a(-1) / profile.a(0)).abs();
            println!("{center:?} {shift}: frequency {frequency}, shape {shape}");
            [frequency.abs(), shape]
        };
        let [coarse, fine] = [0.004, 0.002].map(error);
        for k in 0..2 {
            let ratio = coarse[k] / fine[k];
            assert!((1.9..2.1).contains(&ratio) && fine[k] < 0.02, "{center:?} {k}: {coarse:?} {fine:?}");
        }
    }
}

#[test]
fn breathers_of_the_cradle_come_back_and_have_their_symmetry() {
    // Truth: collocation over a period; u_n(t) = -u_{-n}(t) about a bond, and half a period later
    // about a site.
    for (center, sites) in [(Center::Site, 11), (Center::Bond, 12)] {
        let (modes, to) = (cradle(sites), amplitude(&Homoclinic::new(1.5, center).unwrap(), 0.1));
        let branch = branch(&modes, 5, 0.2 * to, to);
        let orbit = branch.orbits.last().unwrap();
        assert_eq!((branch.end, orbit.amplitude), (Some(End::Reached), to));
        let (start, period) = (modes.state(orbit).u().to_vec(), 2.0 * PI / orbit.omega);
        let [half, end] = [0.5 * period, period].map(|t| at_end(modes.chain(), &modes.state(orbit), t, 1e-13));
        let mirrored = if sites % 2 == 0 { &start } else { &half };
        let most = |of: &dyn Fn(usize) -> f64| (0..sites).fold(0.0, |most: f64, n| most.max(of(n).abs()));
        let back = most(&|n| end[n] - start[n]) / orbit.amplitude;
        let apart = most(&|n| start[n] + mirrored[sites - 1 - n]) / orbit.amplitude;
        println!("{sites}: back {back:e}, symmetry {apart:e}");
        assert!(back < 1e-10 && apart < 1e-10, "{sites}: {back:e} {apart:e}");
    }
}

#[test]
fn chains_without_normal_modes_are_refused() {
    let refused = |chain: &Chain<f64>| NormalModes::new(chain).unwrap_err().to_string();
    let plain = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 3).unwrap();
    assert!(refused(&plain).contains("closed contacts hold every bead"));
    // One bead, or two that touch, have no other contact.
    for overlap in [vec![1.0, -1.0, -1.0, 1.0], vec![1.0, -1.0, 0.0, -1.0, 1.0]] {
        let chain = chain(Boundary::Fixed, overlap.len() - 1, &Details { overlap, ..Details::default() });
        assert!(refused(&chain).contains("closed contacts hold every bead"));
    }
    let damped = chain(Boundary::Fixed, 3, &Details { drag: vec![0.1; 3], ..Details::default() });
    assert!(refused(&damped).contains("conservative"));
    let modes = NormalModes::new(&chain(Boundary::Fixed, 3, &Details::default())).unwrap();
    let refused = |mode, step, to| {
        let way = ModeContinuation { mode, to, step, most_points: 10 };
        way.begin(&modes).unwrap_err().to_string()
    };
    assert!(refused(3, 0.1, 1.0).contains("linear_mode = 4 of 3"));
    assert!(refused(0, 0.1, f64::NAN).contains("to = NaN"));
    assert!(refused(0, 0.0, 1.0).contains("step = 0"));
    assert!(refused(0, 2.0, 1.0).contains("step = 2"));
}
