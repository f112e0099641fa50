//! Linear modes and linear response of finite chains against closed forms and runs.

use hertzchain::{
    chain::{Boundary, Chain, Details, Dissipation, DriveKind, Kind, Params},
    orbits::{NormalModes, Response},
};
use nalgebra::Complex;
use std::f64::consts::PI;

fn walls(alpha: f64, sites: usize, overlap: f64, details: &Details) -> Chain<f64> {
    let chain = Chain::new(Params::new(alpha, 0.0, 0.0).unwrap(), Boundary::Fixed, sites).unwrap();
    chain.precompressed(overlap).unwrap().with(details).unwrap()
}

fn near(got: Complex<f64>, want: Complex<f64>, within: f64) {
    assert!((got - want).norm() < within * want.norm(), "{got} {want}");
}

#[test]
fn modes_of_a_damped_chain_with_a_moved_bead_are_those_of_the_held_chain() {
    // Truth: n equal springs and masses between walls, omega = 2 sqrt(k) sin(pi j/(2 (n + 1))); the
    // bead that is moved is a wall for the others, and damping counts for nothing.
    let k = 1.5 * 0.4_f64.sqrt();
    let drag = Details { drag: vec![0.1; 9], ..Details::default() };
    let modes = NormalModes::held(&walls(1.5, 9, 0.4, &drag), &[4]).unwrap();
    assert_eq!((modes.coordinates(), modes.linear().len()), (8, 8));
    // Two halves of four beads each: every frequency twice.
    for (j, pair) in modes.linear().chunks(2).enumerate() {
        let want = 2.0 * k.sqrt() * (PI * (j + 1) as f64 / 10.0).sin();
        assert!(pair.iter().all(|mode| (mode.omega / want - 1.0).abs() < 1e-13), "{j}");
    }
}

#[test]
fn two_beads_with_drag_are_the_closed_form() {
    // Truth: sum and difference of two beads between walls are oscillators with k and 3 k: u_0 =
    // (1/(k - w^2 + i w c) + 1/(3 k - w^2 + i w c))/2 over the force on bead 0, u_1 the same with
    // the minus sign. With bead 0 moved, u_1 = k/(2 k - w^2 + i w c).
    let (k, c) = (1.4_f64, 0.2);
    let drag = Details { drag: vec![c; 2], ..Details::default() };
    let chain = walls(2.0, 2, 0.7, &drag);
    let [pushed, moved] =
        [DriveKind::Force, DriveKind::Displacement].map(|kind| Response::new(&chain, 0, kind).unwrap());
    for omega in [0.0, 0.3, k.sqrt(), 1.9, (3.0 * k).sqrt(), 5.0] {
        let of = |k: f64| Complex::new(k - omega * omega, omega * c).inv();
        let [got0, got1] = pushed.at(omega)[..] else { panic!() };
        near(got0, (of(k) + of(3.0 * k)) * 0.5, 1e-13);
        near(got1, (of(k) - of(3.0 * k)) * 0.5, 1e-13);
        let [s, u] = moved.at(omega)[..] else { panic!() };
        assert_eq!(s, Complex::new(1.0, 0.0));
        near(u, of(2.0 * k) * k, 1e-13);
    }
}

#[test]
fn dissipative_contacts_and_resonators_respond_as_their_equations_say() {
    // Truth: for two beads and their contacts of stiffness K = k + i w r, r = gamma k for
    // viscoelastic contacts and gamma for dashpots; a resonator of mass mu with spring q and
    // dashpot d adds -w^2 mu Q/(Q - w^2 mu), Q = q + i w d, to the stiffness of its bead.
    let (overlap, gamma, q, d, mu) = (0.3_f64, 0.15, 0.8, 0.05, 0.6);
    let k = 1.5 * overlap.sqrt();
    for kind in [Kind::Viscoelastic, Kind::Dashpot] {
        let details = Details {
            kappa: vec![q; 2],
            rho: vec![mu; 2],
            dashpot: vec![d; 2],
            dissipation: Some(Dissipation { kind, strength: vec![gamma; 3] }),
            ..Details::default()
        };
        let response = Response::new(&walls(1.5, 2, overlap, &details), 1, DriveKind::Force).unwrap();
        for omega in [0.2, 0.9, 1.3, 2.5] {
            let i = Complex::new(0.0, omega);
            let contact = i * (if kind == Kind::Dashpot { gamma } else { gamma * k }) + k;
            let spring = i * d + q;
            let own = spring * (-omega * omega * mu) / (spring - omega * omega * mu) - omega * omega;
            let of = |k: Complex<f64>| (k + own).inv();
            let [u0, u1] = response.at(omega)[..] else { panic!() };
            near(u1, (of(contact) + of(contact * 3.0)) * 0.5, 1e-12);
            near(u0, (of(contact) - of(contact * 3.0)) * 0.5, 1e-12);
        }
    }
}

#[test]
fn resonances_are_at_the_modes_and_what_does_not_respond_is_refused() {
    let weak = Details { drag: vec![1e-4; 6], ..Details::default() };
    let chain = walls(1.5, 6, 0.4, &weak);
    let response = Response::new(&chain, 0, DriveKind::Force).unwrap();
    for mode in response.modes().linear() {
        let gain = |omega: f64| response.at(omega)[5].norm();
        // Truth: the gain of one mode is s_0 s_5/(sum s^2 omega c) at its peak.
        let shape = &mode.shape;
        let share = (shape[0] * shape[5]).abs() / shape.iter().map(|s| s * s).sum::<f64>();
        assert!((gain(mode.omega) * mode.omega * 1e-4 / share - 1.0).abs() < 1e-3, "{}", mode.omega);
    }
    let plain = walls(1.5, 6, 0.4, &Details::default());
    let refused = |chain: &Chain<f64>, site, kind| Response::new(chain, site, kind).unwrap_err().to_string();
    assert!(refused(&plain, 6, DriveKind::Force).contains("site = 6 is not valid"));
    assert!(refused(&walls(1.5, 6, 0.0, &weak), 0, DriveKind::Force).contains("not held"));
}
