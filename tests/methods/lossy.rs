//! Contact collocation of chains whose contacts dissipate.

use crate::{
    common::{distance, largest},
    differing::{BOUNDARIES, collocation, of, random, regularised},
    windows,
};
use hertzchain::{
    chain::{Boundary, Chain, Details, Dissipation, Drive, Kind, Means, Params, Signal, Site, State},
    integrators::collocation::Pace,
};

/// A chain in which everything differs, with contacts that dissipate, and a state in which beads
/// meet and part; and the same with drag, dashpots and drives.
fn varied(
    seed: u64,
    boundary: Boundary,
    sites: usize,
    (kind, most): (Kind, f64),
    driven: bool,
) -> (Chain<f64>, Vec<f64>) {
    let mut next = random(seed);
    let mut within = |from: f64, to: f64| from + (to - from) * next();
    let uniform = Chain::<f64>::new(Params::new(1.5, 1.0, 1.0).unwrap(), boundary, sites).unwrap();
    let bonds = uniform.touching().len();
    let exponents = [1.5, 1.5, 1.5, 2.0, 2.5];
    let held = if boundary == Boundary::Free { 0.0 } else { 0.2 };
    let mut list = |count: usize, from: f64, to: f64| (0..count).map(|_| within(from, to)).collect::<Vec<f64>>();
    let rho = list(sites, -0.5, 2.5).into_iter().map(|rho| if rho > 2.2 { f64::INFINITY } else { rho.max(0.0) });
    let mut details = Details {
        rho: rho.collect(),
        mass: list(sites, 0.5, 2.0),
        kappa: list(sites, 0.5, 2.0),
        contact: list(bonds, 0.5, 2.0),
        alpha: list(bonds, 0.0, 5.0).into_iter().map(|k| exponents[k as usize]).collect(),
        overlap: list(bonds, -0.2, held),
        // Two of ten do not.
        dissipation: Some(Dissipation {
            kind,
            strength: list(bonds, -0.25 * most, most).into_iter().map(|gamma| gamma.max(0.0)).collect(),
        }),
        ..Details::default()
    };
    if driven {
        let damped = |(dashpot, rho): (f64, &f64)| if *rho == 0.0 { 0.0 } else { dashpot.max(0.0) };
        (details.rho[0], details.kappa[0]) = (0.0, 0.0);
        details.dashpot = list(sites, -0.1, 0.4).into_iter().zip(&details.rho).map(damped).collect();
        details.drag = list(sites, -0.1, 0.3).into_iter().map(|drag| drag.max(0.0)).collect();
        details.drag[0] = 0.0;
        details.drives = vec![
            Drive { site: 0, means: Means::Moved, signal: Signal::sine(0.25, 1.7, 0.3) },
            Drive { site: sites - 3, means: Means::Pushed, signal: Signal::sine(0.5, 2.5, 0.0) },
        ];
    }
    let chain = uniform.with(&details).unwrap();
    let state = State::from_fn(&chain, |_| {
        let [u, v, u_dot, v_dot] = [0.2, 0.2, 0.6, 0.3].map(|size| within(-size, size));
        Site { u, v, u_dot, v_dot }
    });
    let state = state.unwrap().driven(&chain);
    (chain, state.as_slice().to_vec())
}

/// Energy + dissipated - driven.
fn balance(chain: &Chain<f64>, y: &[f64]) -> f64 {
    let ledger = chain.layout().ledger(y).unwrap();
    chain.energy(y).total() + ledger.dissipated() - ledger.driven
}

#[test]
fn probe() {
    for (kind, most) in [(Kind::Viscoelastic, 0.3), (Kind::Viscoelastic, 2.0), (Kind::Dashpot, 0.4)] {
        for seed in 0..3 {
            let (chain, y0) = varied(seed, BOUNDARIES[seed as usize % 3], 12, (kind, most), false);
            let want = regularised(&chain, &y0, 8.0);
            for tol in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
                let run = of(&chain, &y0, 8.0).method(hertzchain::run::Method::Collocation).tolerance(tol).unwrap();
                let clock = std::time::Instant::now();
                let out = run.start().unwrap();
                let time = clock.elapsed();
                if let Some(f) = &out.failure { println!("{kind:?} {most} {seed} {tol:e}: {f}"); continue; }
                println!("{kind:?} {most} {seed} {tol:e}: {:e} in units of tol {:.2}, balance {:e}, {:?} {} windows {} rejected {} evals; lost {:e}",
                    distance(&out.state, &want), distance(&out.state, &want)/tol, balance(&chain, &out.state) - balance(&chain, &y0), time, out.stats.steps, out.stats.rejected, out.stats.force_evaluations,
                    chain.layout().ledger(&out.state).unwrap().contacts);
            }
        }
    }
    let _ = (windows(1, 4), Boundary::Free, Pace::Tolerance(1e-3), largest([1.0]), collocation);
}
