//! Contact collocation of chains that are damped and driven.

use crate::{
    common::distance,
    details::run,
    heterogeneous::{self, BOUNDARIES, balance, collocation, lively, of, random},
    variations::altered,
    windows,
};
use hertzchain::{
    chain::{Boundary, Chain, Details, Drive, DriveKind, Params, Signal},
    integrators::collocation::StepControl,
    run::Setting,
};

/// A chain of `heterogeneous.rs` whose resonators have at least 0.3 of the masses of beads, and a
/// state in which beads meet and part.
pub(crate) fn varied(seed: u64) -> (Chain<f64>, Vec<f64>) {
    let mut next = random(seed);
    let mut within = |from: f64, to: f64| from + (to - from) * next();
    let (chain, _) = heterogeneous::varied(seed, Boundary::Fixed, 8, (None, true));
    let chain = altered(&chain, |details| {
        let mut list =
            |count: usize, from: f64, to: f64| -> Vec<f64> { (0..count).map(|_| within(from, to)).collect() };
        let of_resonator = |rho: f64| match rho {
            2.2.. => f64::INFINITY,
            0.3.. => rho,
            _ => 0.0,
        };
        details.rho = list(8, -0.5, 2.5).into_iter().map(of_resonator).collect();
        (details.kappa, details.drag) = (list(8, 0.5, 2.0), list(8, -0.1, 0.3));
        (details.rho[0], details.kappa[0], details.drag[0]) = (0.0, 0.0, 0.0);
        let damped = |(dashpot, rho): (f64, &f64)| if *rho == 0.0 { 0.0 } else { dashpot.max(0.0) };
        details.dashpot = list(8, -0.1, 0.4).into_iter().zip(&details.rho).map(damped).collect();
        details.drag.iter_mut().for_each(|drag| *drag = drag.max(0.0));
        (details.mass, details.contact) = (list(8, 0.5, 2.0), list(9, 0.5, 2.0));
        details.alpha = list(9, 0.0, 5.0).into_iter().map(|k| [1.5, 1.5, 1.5, 2.0, 2.5][k as usize]).collect();
        details.overlap = list(9, -0.2, 0.2);
    });
    let y0 = lively(&chain, &mut within);
    (chain, y0)
}

#[test]
fn motions_without_contacts_are_their_closed_forms() {
    // Truth: u = e^{-n t} (u0 cos w t + (u0' + n u0)/w sin w t) of a bead on a spring to a
    // resonator at rest, w^2 = kappa/m - n^2, n = c/2m, by drag or by a dashpot, weak or strong.
    // What it dissipates is the energy that it lacks; the tangent map is exp(A t).
    let params = Params::new(1.5, 1.0, f64::INFINITY).unwrap();
    let alone = Chain::<f64>::new(params, Boundary::Free, 1).unwrap();
    for (drag, dashpot) in [(0.3, 0.0), (0.0, 0.3), (0.5, 0.6), (2.0, 0.0), (0.0, 7.0)] {
        let one = |x: f64| vec![x];
        let details =
            Details { mass: one(1.5), kappa: one(2.0), drag: one(drag), dashpot: one(dashpot), ..Details::default() };
        let chain = alone.clone().with(&details).unwrap();
        let (n, t, u0, v0) = ((drag + dashpot) / 3.0, 9.0, 0.4f64, -0.7f64);
        let square: f64 = 2.0 / 1.5 - n * n;
        let w = square.abs().sqrt();
        let (sin, cos) = if square > 0.0 { (w * t).sin_cos() } else { ((w * t).sinh(), (w * t).cosh()) };
        let want = (-n * t).exp() * (u0 * cos + (v0 + n * u0) / w * sin);
        let start = [u0, v0, 0.0, 0.0, 0.0, 0.0];
        let got = collocation(&chain, &start, t, StepControl::Tolerance(1e-12));
        let off = (balance(&chain, &got) - balance(&chain, &start)).abs();
        println!("{drag} {dashpot}: {:e}, balance {off:e}", got[0] - want);
        assert!((got[0] - want).abs() < 4e-16 && off < 7e-16, "{drag} {dashpot}: {:e} {off:e}", got[0] - want);
        let columns = [cos + n / w * sin, -2.0 / 1.5 / w * sin, sin / w, cos - n / w * sin].map(|x| (-n * t).exp() * x);
        let got = chain.monodromy(&start, (0.0, t), StepControl::Tolerance(1e-12)).unwrap();
        let off = distance(&[got[0], got[1], got[6], got[7]], &columns);
        assert!(off < 1e-15, "{drag} {dashpot}: {off:e}");
    }
    // Truth: a bead under F sin(w t) with drag, m u'' = F sin(w t) - c u', from rest; and what the
    // force has done is energy and dissipated.
    let (m, c, force, w, t) = (1.5, 0.4, 0.8, 1.9, 12.0f64);
    let drives = vec![Drive { site: 0, kind: DriveKind::Force, signal: Signal::sine(force, w, 0.0) }];
    let details = Details { mass: vec![m], drag: vec![c], drives, ..Details::default() };
    let plain = Chain::<f64>::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 1).unwrap();
    let chain = plain.with(&details).unwrap();
    let got = collocation(&chain, &[0.0; 6], t, StepControl::Tolerance(1e-12));
    let k = c / m;
    let speed = force / m * (w * (-k * t).exp() + k * (w * t).sin() - w * (w * t).cos()) / (k * k + w * w);
    println!("pushed: {:e}, balance {:e}", got[1] - speed, balance(&chain, &got));
    assert!((got[1] - speed).abs() < 5e-16 && balance(&chain, &got).abs() < 3e-16);
}

#[test]
fn damping_that_is_next_to_none_changes_nothing() {
    // Truth: the chain without it, whose paths are sines and cosines: two ways to the same motion.
    // Roundings, which contacts enlarge.
    for (seed, boundary) in BOUNDARIES.into_iter().enumerate() {
        let (open, y0) = heterogeneous::varied(20 + seed as u64, boundary, 10, (None, true));
        let closed = altered(&open, |details| {
            (details.drag, details.dashpot, details.drives) = (vec![], vec![], vec![]);
        });
        let almost = altered(&closed, |details| details.drag = vec![1e-300; 10]);
        let control = windows(80, 12);
        let want = collocation(&closed, &y0[..y0.len() - 4], 8.0, control);
        let got = collocation(&almost, &y0, 8.0, control);
        let gap = distance(&got[..want.len()], &want);
        println!("{boundary:?}: {gap:e}");
        assert!(gap < 1e-15, "{gap:e}");
    }
}

#[test]
fn strong_damping_is_resolved() {
    // Truth: plain DOP853 at 1e-14; rates of damping up to 300 times those of contacts, and
    // resonators of a hundredth of the mass.
    let n = 5;
    let details = Details {
        rho: vec![0.01, 1.0, f64::INFINITY, 0.0, 0.01],
        drag: vec![0.0, 0.0, 90.0, 4.0, 0.5],
        dashpot: vec![1.5, 40.0, 0.0, 0.0, 0.0],
        ..Details::default()
    };
    let uniform = Chain::<f64>::new(Params::new(1.5, 1.0, 1.0).unwrap(), Boundary::Free, n).unwrap();
    let chain = uniform.with(&details).unwrap();
    let mut y0 = vec![0.0; 4 * n + 4];
    (y0[2 * n], y0[2 * n + 4]) = (1.0, -0.7);
    let want = run(&chain, of(&chain, &y0, 4.0).initial(), 4.0, "dop853", Setting::Tolerance(1e-14)).state;
    for tol in [1e-6, 1e-10] {
        let got = collocation(&chain, &y0, 4.0, StepControl::Tolerance(tol));
        println!("{tol:e}: {:e}", distance(&got, &want));
        assert!(distance(&got, &want) < tol);
    }
}
