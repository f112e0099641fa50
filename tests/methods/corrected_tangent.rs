//! The tangent map of contact-corrected splitting, against differences of runs and collocation's.

use hertzchain::{
    breathers::DarkBreather,
    chain::{Boundary, Chain, CorrectedSplit, LinearFlow, Params, Site, State, TangentFlow},
    dps::Center,
    integrators::{
        SplitFlow, Stepper,
        collocation::Pace,
        splitting::{Corrected, Parts},
    },
    orbits::Shooting,
    scene::Scene,
    study::generic_state,
};

/// Strang's splitting by the same steps.
const STRANG: Parts = Parts { processed: false, corrected: false };

/// Numbers in (-1, 1) that look random: splitmix64.
fn random(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (seed ^ (seed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn random_state(chain: &Chain<f64>, seed: u64) -> Vec<f64> {
    let mut next = random(seed);
    let site = |_| Site { u: next(), v: next(), u_dot: next(), v_dot: next() };
    State::from_fn(chain, site).unwrap().as_slice().to_vec()
}

fn identity(dim: usize) -> Vec<f64> {
    (0..dim * dim).map(|k| f64::from(u8::from(k / dim == k % dim))).collect()
}

/// State and columns at `end`, from columns at the start.
fn carried(chain: &Chain<f64>, y: &[f64], columns: &[f64], run: (f64, u64), parts: Parts) -> (Vec<f64>, Vec<f64>) {
    let (end, steps) = run;
    let mut run = Corrected::new(TangentFlow::new(chain.clone(), y, columns), (0.0, end), steps, parts).unwrap();
    while !run.done() {
        run.step().unwrap();
    }
    let mut y = y.to_vec();
    run.sample(end, &mut y);
    (y, run.solution().columns())
}

fn tangent(chain: &Chain<f64>, y: &[f64], run: (f64, u64), parts: Parts) -> Vec<f64> {
    carried(chain, y, &identity(y.len()), run, parts).1
}

fn alone(chain: &Chain<f64>, y: &[f64], (end, steps): (f64, u64)) -> Vec<f64> {
    let mut flow = LinearFlow::new(chain.clone());
    flow.load(y);
    let mut run = Corrected::new(CorrectedSplit::new(flow), (0.0, end), steps, Parts::ALL).unwrap();
    while !run.done() {
        run.step().unwrap();
    }
    let mut y = y.to_vec();
    run.sample(end, &mut y);
    y
}

fn gap(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |max, (a, b)| if (a - b).is_nan() { f64::INFINITY } else { (a - b).abs().max(max) })
}

/// The largest entry of `M^T J M - J` in `q, p`, with `p_u = u'`, `p_v = rho v'`.
fn symplectic_defect(chain: &Chain<f64>, m: &[f64]) -> f64 {
    let (dim, n, rho) = (chain.layout().dim(), chain.sites(), chain.params().rho);
    let weight = |i: usize| if dim == 4 * n && i >= 3 * n { rho } else { 1.0 };
    let at = |i: usize, j: usize| weight(i) * m[j * dim + i] / weight(j);
    let half = dim / 2;
    let entry = |a: usize, b: usize| {
        let product: f64 = (0..half).map(|i| at(i, a) * at(half + i, b) - at(half + i, a) * at(i, b)).sum();
        product - f64::from(u8::from(b == a + half))
    };
    (0..dim).flat_map(|b| (0..b).map(move |a| (a, b))).fold(0.0, |max, (a, b)| entry(a, b).abs().max(max))
}

fn slope(errors: &[(u64, f64)]) -> f64 {
    let ((n, first), (m, last)) = (errors[0], errors[errors.len() - 1]);
    (first / last).ln() / (m as f64 / n as f64).ln()
}

fn list(errors: &[(u64, f64)]) -> String {
    errors.iter().map(|(steps, error)| format!("{steps}: {error:.1e}")).collect::<Vec<_>>().join(", ")
}

#[test]
fn columns_are_the_derivative_of_the_run() {
    // Truth: central differences of runs without columns. A difference is good to 1e-9 or so;
    // across an event that passes a kick it is none, and the median passes over it. Measured:
    // 4.6e-10 at most, and 2.5e-9 for the largest.
    for (boundary, alpha, kappa, rho, sites) in [
        (Boundary::Free, 1.5, 1.0, 1.0 / 3.0, 6),
        (Boundary::Free, 1.1, 1.0, 1.0 / 3.0, 5),
        (Boundary::Free, 1.5, 0.0, 0.0, 4),
        (Boundary::Fixed, 1.5, 1.0, 1.0 / 3.0, 5),
        (Boundary::Fixed, 1.2, 1.0, f64::INFINITY, 4),
        (Boundary::Fixed, 1.5, 1.0, 0.5, 1),
        (Boundary::Ring, 2.0, 1.0, 1.0 / 3.0, 5),
        (Boundary::Ring, 1.5, 1.0, 0.5, 2),
        (Boundary::StrainRing, 1.5, 1.0, 1.0 / 3.0, 5),
        (Boundary::StrainRing, 1.5, 1.0, 0.5, 2),
    ] {
        let chain = Chain::new(Params::new(alpha, kappa, rho).unwrap(), boundary, sites).unwrap();
        let y = random_state(&chain, 5);
        // A start with a few steps, some of them near events; and a longer run.
        for run in [(0.3, 6), (6.0, 150)] {
            let (end, columns) = carried(&chain, &y, &identity(y.len()), run, Parts::ALL);
            assert_eq!(end, alone(&chain, &y, run), "columns leave the bits of the state alone");
            let size = 1e-5;
            let mut errors: Vec<f64> = (0..y.len())
                .map(|k| {
                    let shifted = |by: f64| {
                        let mut y = y.clone();
                        y[k] += by;
                        alone(&chain, &y, run)
                    };
                    let (ahead, behind) = (shifted(size), shifted(-size));
                    let difference: Vec<f64> = ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * size)).collect();
                    gap(&difference, &columns[k * y.len()..][..y.len()])
                })
                .collect();
            errors.sort_by(f64::total_cmp);
            let (median, largest) = (errors[errors.len() / 2], errors[errors.len() - 1]);
            println!("{boundary:?} {alpha} {rho} {run:?}: {median:.1e}, {largest:.1e}");
            assert!(median < 1e-9 && largest < 5e-9, "{boundary:?} {alpha} {rho} {run:?}: {median:e} {largest:e}");
        }
    }
}

#[test]
fn the_tangent_has_its_order_through_contacts() {
    // Truth: collocation at 1e-14. Theory: min(4, alpha + 2), and alpha without corrections. Each
    // error is the median of five runs, since where events fall in a step is chance.
    for alpha in [1.1, 1.2, 1.5, 2.0, 2.5] {
        let chain = Chain::new(Params::new(alpha, 1.0, 1.0 / 3.0).unwrap(), Boundary::Free, 6).unwrap();
        let y = generic_state(&chain).unwrap().as_slice().to_vec();
        let truth = chain.monodromy(&y, (0.0, 12.0), Pace::Tolerance(1e-14)).unwrap();
        let errors = |parts: Parts| -> Vec<(u64, f64)> {
            let error = |n: u64| {
                let shares = [1.0, 1.021, 1.043, 1.064, 1.087].map(|share| (n as f64 * share).round() as u64);
                let mut errors = shares.map(|n| gap(&tangent(&chain, &y, (12.0, n), parts), &truth));
                errors.sort_by(f64::total_cmp);
                errors[2]
            };
            [240, 480, 960, 1920, 3840].map(|n| (n, error(n))).to_vec()
        };
        let (corrected, processed) = (errors(Parts::ALL), errors(Parts::PROCESSED));
        println!("{alpha}: {:.2} {}", slope(&corrected), list(&corrected));
        println!("    without corrections {:.2} {}", slope(&processed), list(&processed));
        assert!(slope(&corrected) > f64::min(4.0, alpha + 2.0) - 0.1, "{alpha}: {corrected:?}");
        assert!((slope(&processed) - alpha).abs() < 0.4, "{alpha}: {processed:?}");
    }
}

/// Chains for the table of symplectic defects: with a state, and a time.
fn cases() -> Vec<(&'static str, Chain<f64>, Vec<f64>, f64)> {
    let mut cases = Vec::new();
    for name in ["bright-breather-16", "precompressed"] {
        let scene = Scene::load(name).unwrap();
        cases.push((name, scene.chain().clone(), scene.initial().as_slice().to_vec(), 12.0));
    }
    let ring = Chain::new(Params::new(1.5, 1.0, 1.0 / 3.0).unwrap(), Boundary::Ring, 20).unwrap();
    let y = random_state(&ring, 7);
    cases.push(("a random ring", ring, y, 12.0));
    cases
}

#[test]
fn symplectic_defects_fall_with_the_order_of_what_is_left_out() {
    // Truth: Hamiltonian flows are symplectic. Strang's splitting is, to rounding. The processor is
    // a midpoint step, with a defect of order h^6. Corrections leave out the neighbours' share of
    // W: impulses of order h^{alpha+3}, derivatives of one order less. The precompressed chain has
    // no events. Bounds: about twice what was measured.
    let bounds = [[1.2e-9, 2e-14, 2e-14], [1e-14, 1e-14, 1e-14], [6e-8, 6e-12, 1e-13]];
    for ((name, chain, y, end), bounds) in cases().into_iter().zip(bounds) {
        println!("{name}, {} sites", chain.sites());
        let methods = [("corrected", Parts::ALL), ("takahashi-imada", Parts::PROCESSED), ("strang", STRANG)];
        let table = methods.map(|(method, parts)| {
            let defect = |n| (n, symplectic_defect(&chain, &tangent(&chain, &y, (end, n), parts)));
            let defects = [150, 300, 600, 1200].map(defect);
            println!("  {method}: {:.1} {}", slope(&defects), list(&defects));
            defects
        });
        for ((method, _), (defects, bound)) in methods.iter().zip(table.iter().zip(bounds)) {
            assert!(defects[3].1 < bound, "{name}, {method}: {defects:?}");
        }
        match name {
            "precompressed" => assert_eq!(table[0], table[1], "without events nothing is corrected"),
            "a random ring" => {
                let [corrected, processed] = [slope(&table[0]), slope(&table[1])];
                assert!(corrected > 3.3 && processed > 5.5, "{corrected} {processed}");
            }
            _ => {}
        }
    }
}

#[test]
fn the_way_back_undoes_the_tangent() {
    // Truth: the flow is reversible. Bounds: about twice what was measured.
    for ((name, chain, y, end), bound) in cases().into_iter().zip([6e-12, 1e-14, 4e-9]) {
        let turned = |y: &[f64]| -> Vec<f64> {
            let dim = chain.layout().dim();
            y.iter().enumerate().map(|(i, &value)| if i % dim < dim / 2 { value } else { -value }).collect()
        };
        let returned = |steps| {
            let (there, columns) = carried(&chain, &y, &identity(y.len()), (end, steps), Parts::ALL);
            let (_, back) = carried(&chain, &turned(&there), &turned(&columns), (end, steps), Parts::ALL);
            (steps, gap(&turned(&back), &identity(y.len())))
        };
        let errors = [150, 300, 600, 1200].map(returned);
        println!("{name}: {:.1} {}", slope(&errors), list(&errors));
        assert!(errors[3].1 < bound, "{name}: {errors:?}");
    }
}

#[test]
fn columns_go_along_with_a_dark_breather() {
    // Truth: collocation at 1e-14. Half a period of an exact dark breather on a strain ring, all of
    // whose contacts open and close at once near a quarter of it. An odd number of steps keeps
    // these events away from kicks. Measured: 1.3e-9, and 7.8e-8 with an even number.
    let params = Params::new(1.5, 1.0, 1.0 / 3.0).unwrap();
    let breather = DarkBreather { params, center: Center::Site, sites: 41, omega_b: 2.02, c_x: 0.0 };
    let orbit = breather.orbit(&Shooting::default()).unwrap();
    let (chain, half) = (orbit.setting.chain().unwrap(), 0.5 * orbit.setting.period());
    let mut y = orbit.z.clone();
    y.resize(chain.layout().dim(), 0.0);
    let truth = chain.monodromy(&y, (0.0, half), Pace::Tolerance(1e-14)).unwrap();
    let [odd, even] = [129, 128].map(|steps| gap(&tangent(&chain, &y, (half, steps), Parts::ALL), &truth));
    println!("{odd:.1e} {even:.1e}");
    assert!(odd < 4e-9 && even < 2.4e-7, "{odd:e} {even:e}");
}
