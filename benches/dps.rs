//! Run times of the averages of the modulation equations, for random inputs in all regimes.

use criterion::{Criterion, Throughput};
use hertzchain::dps::Averages;
use std::hint::black_box;

const COUNT: usize = 4096;

/// Reproducible pseudo-random numbers in (0, 1).
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 11) as f64 + 0.5) / 2f64.powi(53)
    }
}

/// Pairs `(b, r)` with `s = b / (2 kappa r)` between `low` and `high`.
fn bonds(kappa: f64, (low, high): (f64, f64)) -> Vec<(f64, f64)> {
    let mut next = noise(1);
    (0..COUNT)
        .map(|_| {
            let r = (4.0 * next() - 2.0).exp();
            ((low + (high - low) * next()) * 2.0 * kappa * r, r)
        })
        .collect()
}

fn averages(c: &mut Criterion) {
    let mut group = c.benchmark_group("averages");
    group.throughput(Throughput::Elements(COUNT as u64));
    for alpha in [1.5, 1.7] {
        let averages = Averages::new(alpha, 0.7).unwrap();
        for (regime, ends) in
            [("all", (-3.0, 1.0)), ("opens", (-0.5, 1.0)), ("near", (-1.1, -0.9)), ("closed", (-5.0, -2.5))]
        {
            let bonds = bonds(0.7, ends);
            // Checks one bond by Euler's identity, b dg/db + r dg/dr = alpha g.
            let (b, r) = bonds[COUNT / 3];
            let v = averages.values(b, r);
            assert!(((b * v.dg_db + r * v.dg_dr) / (alpha * v.g) - 1.0).abs() < 1e-13);
            group.bench_function(format!("g and r h, alpha = {alpha}, {regime}"), |bench| {
                bench.iter(|| {
                    bonds.iter().map(|&(b, r)| averages.force(black_box(b), r)).fold(0.0, |sum, (g, rh)| sum + g + rh)
                });
            });
            group.bench_function(format!("values, alpha = {alpha}, {regime}"), |bench| {
                bench.iter(|| {
                    bonds.iter().map(|&(b, r)| averages.values(black_box(b), r)).fold(0.0, |sum, v| sum + v.g + v.dh_dr)
                });
            });
            group.bench_function(format!("mean strain, alpha = {alpha}, {regime}"), |bench| {
                let targets: Vec<_> = bonds.iter().map(|&(b, r)| (averages.g(b, r), r)).collect();
                bench.iter(|| targets.iter().map(|&(g, r)| averages.mean_strain(black_box(g), r)).sum::<f64>());
            });
        }
    }
    group.bench_function("tables", |bench| bench.iter(|| Averages::new(black_box(1.5), 0.7).unwrap()));
    group.finish();
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    averages(&mut criterion);
    criterion.final_summary();
}
