//! Several runs side by side.

use super::on_every_set;
use hertzchain_core::{
    Boundary, Chain, Method, Params, Run, Setting, State, Trajectory,
    chain::{Details, Drive, DriveKind, Signal, Term},
    run::{Records, groups, start_all},
};

/// Runs by a splitting from states of sizes 1, 2, .., each of a chain for this size.
fn runs(chain: impl Fn(u32) -> Chain<f64>, method: &str, sizes: std::ops::Range<u32>, steps: u64) -> Vec<Run> {
    let run = |size: u32| {
        let chain = chain(size);
        let mut state = State::rest(&chain);
        let numbers = state.as_mut_slice().iter_mut().enumerate();
        numbers.for_each(|(i, x)| *x = 0.01 * f64::from(size) * (0.7 * (i * i) as f64 + 0.3).sin());
        let details = chain.details().cloned().unwrap_or_default();
        for drive in details.drives.iter().filter(|drive| drive.kind == DriveKind::Displacement) {
            let ([s, s_dot, _], half) = (drive.signal.at(0.0), chain.layout().half());
            let y = state.as_mut_slice();
            (y[drive.site], y[half + drive.site]) = (s, s_dot);
        }
        let run = Run::new(chain, state).until(7.0).unwrap().samples(3).unwrap().records(Records::Energy);
        run.method(Method::named(method).unwrap()).setting(Setting::Steps(steps))
    };
    sizes.map(run).collect()
}

/// Seven runs that are made together have the bits of each alone, at all samples.
fn each_as_alone(runs: &[Run], told: &str) {
    assert!(groups(runs, 7)[0].len() > 1, "{told}");
    let (mut seen, mut want) = (vec![Vec::new(); 7], vec![Vec::new(); 7]);
    let ends = start_all(runs, &mut |k, t, y| seen[k].push((t, y.to_vec())));
    for ((run, end), want) in runs.iter().zip(ends).zip(&mut want) {
        let alone = run.observe(&mut |t, y| want.push((t, y.to_vec())), &mut |_| ()).unwrap();
        let end = end.unwrap();
        assert!(end.state == alone.state && end.samples == alone.samples, "{told}");
        assert_eq!((end.energy_error, end.stats, end.t), (alone.energy_error, alone.stats, alone.t));
    }
    assert!(seen == want && seen[0].len() == 4 && seen[0] != seen[1], "{told}");
}

/// A uniform chain; or one with details of its own: masses, springs, resonators and contacts that
/// differ; then also joints, on-site springs and further powers; or dampers, drives and gravity.
fn made(boundary: Boundary, n: usize, kind: &str, size: u32) -> Chain<f64> {
    let (size, uniform) = (f64::from(size), kind == "uniform");
    let rho = if uniform { [0.4, 0.0, f64::INFINITY][n % 3] } else { 0.4 };
    let chain = Chain::new(Params::new(1.5, 1.0, rho).unwrap(), boundary, n).unwrap();
    if uniform {
        return chain.clone().precompressed(0.1).unwrap_or(chain);
    }
    let of = |count: usize, f: &dyn Fn(f64) -> f64| (0..count).map(|i| f(i as f64 + size)).collect::<Vec<_>>();
    let (bonds, last) = (chain.touching().len(), n - 1);
    let plain = Details {
        mass: of(n, &|x| 1.0 + 0.4 * x.sin()),
        kappa: of(n, &|x| 1.0 + 0.5 * (2.0 * x).sin()),
        rho: (0..n).map(|i| [0.0, 0.4, 0.1 * size, f64::INFINITY][i * i % 4]).collect(),
        contact: of(bonds, &|x| 1.5 + (3.0 * x).sin()),
        overlap: of(bonds, &|x| 0.01 * x.sin()),
        ..Details::default()
    };
    let signal = |size| Signal::sine(size, 1.3, 0.0);
    let details = match kind {
        "held" => Details {
            alpha: of(bonds, &|x| 1.5 + 0.5 * x.sin()),
            terms: vec![Term { contact: vec![0.5; bonds], alpha: 2.5 }],
            onsite: of(n, &|x| (2.0 + x.sin()) / 10.0),
            spring: of(bonds, &|x| (1.5 + x.sin()) / 10.0),
            magnet: of(bonds, &|x| (1.5 + x.sin()) / 100.0),
            distance: vec![2.0; bonds],
            decay: 4.0,
            ..plain
        },
        "open" => Details {
            rho: (0..n).map(|i| if i == 0 { 0.0 } else { 0.1 * size }).collect(),
            drag: (0..n).map(|i| if i == 0 { 0.0 } else { 0.01 * size }).collect(),
            dashpot: (0..n).map(|i| if i == 0 || i % 3 == 1 { 0.0 } else { 0.02 * size }).collect(),
            drives: [(0, DriveKind::Displacement), (last, DriveKind::Force)][..n.min(2)]
                .iter()
                .map(|&(site, kind)| Drive { site, kind, signal: signal(0.01 * size) })
                .collect(),
            gravity: 0.01,
            ..plain
        },
        _ => plain,
    };
    chain.with(&details).unwrap()
}

#[test]
fn chains_alike_are_made_together_with_the_bits_of_each_alone() {
    // Truth: each run alone; samples at ends of steps and inside.
    on_every_set(|set| {
        for boundary in Boundary::ALL {
            let kinds = &["uniform", "plain", "held", "open"][..if boundary == Boundary::StrainRing { 1 } else { 4 }];
            for (n, kind) in [1, 2, 3, 9].into_iter().flat_map(|n| kinds.iter().map(move |kind| (n, kind))) {
                for (method, steps) in [("verlet", 91), ("strang-linear", 91), ("aba864", 88)] {
                    let runs = runs(|size| made(boundary, n, kind, size), method, 1..8, steps);
                    each_as_alone(&runs, &format!("{set} {boundary:?} {n} {kind} {method}"));
                }
            }
        }
    });
    // What cannot be made together: spans of their own, other gravity, uniform chains with others.
    let alone = |runs: &[Run]| assert_eq!(groups(runs, 7)[0].len(), 1);
    let spans = runs(|size| made(Boundary::Free, 9, "plain", size), "verlet", 1..8, 91).into_iter().zip(1..);
    alone(&spans.map(|(run, k)| run.until(7.0 + f64::from(k)).unwrap()).collect::<Vec<_>>());
    let bare = |alpha, kappa| Chain::new(Params::new(alpha, kappa, 0.4).unwrap(), Boundary::Fixed, 9).unwrap();
    let heavy = |size| bare(1.5, 1.0).with(&Details { gravity: f64::from(size), ..Details::default() }).unwrap();
    alone(&runs(heavy, "verlet", 1..8, 91));
    alone(&runs(|size| if size > 1 { heavy(0) } else { bare(1.5, 1.0) }, "verlet", 1..8, 91));
    alone(&runs(|size| bare(1.5, f64::from(size)), "verlet", 1..8, 91));
    alone(&runs(|_| bare(2.0, 1.0), "verlet", 1..8, 91));
}

#[test]
fn a_run_that_fails_leaves_the_others_alone_and_others_are_refused_one_by_one() {
    // Truth: each alone. Steps of 0.7 are unstable for Verlet where beads are pressed hard.
    let chain = Chain::new(Params::new(1.5, 4.0, f64::INFINITY).unwrap(), Boundary::Ring, 9).unwrap();
    let chain = |_| chain.clone();
    let mut all = runs(chain, "verlet", 1..8, 10);
    all[1] = runs(chain, "verlet", 100_000..100_001, 10).remove(0);
    all.push(all[0].clone().setting(Setting::Tolerance(1e-3)));
    let mut ends = start_all(&all, &mut |_, _, _| ());
    assert!(matches!(ends.pop(), Some(Err(_))), "verlet takes no tolerance");
    let failed: Vec<bool> = ends.iter().map(|end| end.as_ref().unwrap().failure.is_some()).collect();
    assert_eq!(failed, [false, true, false, false, false, false, false]);
    for (run, end) in all.iter().zip(ends) {
        // As text, in which NaN is itself.
        let told = |end: &Trajectory| format!("{:?}", (&end.state, end.t, &end.failure));
        assert_eq!(told(&end.unwrap()), told(&run.start().unwrap()));
    }
}
