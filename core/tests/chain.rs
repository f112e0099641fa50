//! The chain: its topology, the modes of a site, the phase of resonators, quadrature.

use hertzchain_core::{
    Boundary, Params,
    chain::{Modes, Resonators, Topology},
    internals::{Phase, gauss},
};
use hertzchain_integrators::DoubleDouble;

fn chains() -> impl Iterator<Item = Topology> {
    Boundary::ALL.into_iter().flat_map(|boundary| (1..6).map(move |sites| Topology::new(boundary, sites)))
}

fn number(n: usize) -> f64 {
    (1.0 + n as f64).sin()
}

#[test]
fn what_a_force_pushes_is_what_pushes_sites() {
    // Truth: one is a column of a matrix, the other its rows. On rings of one or two a site may
    // be pushed twice.
    for topology in chains() {
        for bond in topology.touching() {
            let mut pushed = vec![0.0; topology.sites()];
            topology.pushed(bond).iter().for_each(|&(site, weight)| pushed[site] += weight);
            for (site, pushed) in pushed.into_iter().enumerate() {
                let [push] = topology.push(site, |b| [f64::from(u8::from(b == bond))]);
                assert_eq!(push, pushed, "{topology:?} {bond} {site}");
            }
        }
    }
}

#[test]
fn a_push_is_a_difference_transposed() {
    // Truth: the work of forces at sites is minus that in bonds, sum q_i push_i = -sum f_b
    // across_b; on a strain ring a force in a bond does `mobility` to its own strain.
    for topology in chains() {
        let across = |b| topology.across(b, |i| [number(i)])[0];
        let force = |b: usize| number(b + 7);
        let at_sites: f64 = (0..topology.sites()).map(|i| number(i) * topology.push(i, |b| [force(b)])[0]).sum();
        let in_bonds: f64 = topology.touching().map(|b| force(b) * across(b)).sum();
        if !topology.strains() {
            assert!((at_sites + in_bonds).abs() < 1e-14, "{topology:?}");
        }
        for bond in topology.touching().filter(|_| topology.sites() > 2) {
            let push = |i| topology.push(i, |b| [f64::from(u8::from(b == bond))]);
            assert_eq!(topology.across(bond, push), [-topology.mobility(bond)], "{topology:?} {bond}");
            // Bonds beside are those that the force acts on, but itself.
            let moved = |b: &usize| *b != bond && topology.across(*b, push) != [0.0];
            let mut beside: Vec<usize> = topology.beside(bond).into_iter().flatten().collect();
            beside.sort_unstable();
            assert_eq!(topology.touching().filter(moved).collect::<Vec<_>>(), beside, "{topology:?} {bond}");
        }
    }
}

#[test]
fn positions_beyond_the_ends_say_the_same() {
    for topology in chains().filter(|topology| !topology.strains()) {
        let n = topology.sites();
        let q: Vec<f64> = (0..n).map(number).collect();
        let (left, right) = topology.ghosts(q[0], q[n - 1]);
        let padded: Vec<f64> = [left].into_iter().chain(q.iter().copied()).chain([right]).collect();
        for bond in topology.touching() {
            assert_eq!(topology.across(bond, |i| [q[i]]), [padded[bond] - padded[bond + 1]], "{topology:?} {bond}");
        }
    }
}

#[test]
fn parted_and_joined_it_is_the_same_site() {
    for (kappa, rho) in [(1.0, 1.0 / 3.0), (2.0, 10.0), (1.0, 0.0), (0.0, 2.0), (3.0, f64::INFINITY)] {
        let params = Params::new(1.5, kappa, rho).unwrap();
        let modes: Modes<f64> = Modes::new(params);
        let moving = params.resonators() == Resonators::Moving;
        let site = [0.3, 0.7, -0.2, 0.5];
        let back = modes.join(modes.split(site));
        for (k, (a, b)) in site.into_iter().zip(back).enumerate() {
            assert!((a - b).abs() < 1e-15 || k % 2 == 1 && !moving, "{rho} {k}");
        }
        assert!((modes.m + modes.mu - 1.0).abs() < 1e-15);
        if moving {
            // Truth: the definitions.
            let [r, _, p, p_dot] = modes.split(site);
            assert!((r - (0.3 + rho * 0.7) / (1.0 + rho)).abs() < 1e-15);
            assert!((p - rho * (0.3 - 0.7) / (1.0 + rho)).abs() < 1e-15);
            assert!((p_dot - rho * (-0.2 - 0.5) / (1.0 + rho)).abs() < 1e-15);
        }
    }
}

#[test]
fn a_million_rotations_are_one() {
    // Truth: the phase itself to twice the precision, and its sine and cosine.
    let omega = DoubleDouble::<f64>::new(1.3).sqrt();
    let mut phase = Phase::new(omega);
    let drifts = [0.0123, -0.004, 0.02].map(|dt| DoubleDouble::new(dt).over(DoubleDouble::new(3.0)));
    for k in 0..1_000_000 {
        phase.advance(drifts[k % 3]);
    }
    let count = |k: usize| DoubleDouble::new(((1_000_000 + 2 - k) / 3) as f64);
    let time = (0..3).fold(DoubleDouble::zero(), |sum, k| sum + drifts[k] * count(k));
    let theta = (omega * time).reduced(DoubleDouble::two_pi());
    let (sin, cos) = theta.sin_cos();
    let (s, c) = phase.sin_cos();
    assert!((s - sin).abs() < 2e-16 && (c - cos).abs() < 2e-16, "{:e} {:e}", s - sin, c - cos);
    // Measured: 1.3e-28.
    assert!((phase.theta() - theta).hi.abs() < 3e-28);
    // Its copy, and drifts that are not kept, go on from there.
    let mut copy = Phase::new(omega);
    copy.copy_from(&phase);
    for k in 0..40 {
        copy.advance(DoubleDouble::new(0.001 * f64::from(k)));
    }
    let theta = (theta + omega * DoubleDouble::new(0.78)).reduced(DoubleDouble::two_pi());
    let ((sin, cos), (s, c)) = (theta.sin_cos(), copy.sin_cos());
    assert!((s - sin).abs() < 2e-16 && (c - cos).abs() < 2e-16, "{:e} {:e}", s - sin, c - cos);
}

#[test]
fn it_is_exact_up_to_degree_twenty_three() {
    for degree in 0..24 {
        let [integral] = gauss(|s: f64| [s.powi(degree)], 0.0, 1.0);
        assert!((integral * f64::from(degree + 1) - 1.0).abs() < 1e-14, "{degree}");
    }
    let [integral] = gauss(|s: f64| [s.powi(24)], -1.0, 1.0);
    assert!((integral * 12.5 - 1.0).abs() > 1e-14);
}
