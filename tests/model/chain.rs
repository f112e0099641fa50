//! The chain: forces against the energy, sweeps against naive loops, the linear flow against its
//! closed form.

use crate::numbers::{assert_below, distance, largest, random_signed};
use hertzchain::chain::{Boundary, Chain, Field, KineticFlow, LinearFlow, Params, Resonators};
use hertzchain::integrators::{
    DoubleDouble, SplitFlow, Splitting, Stepper, VectorField,
    splitting::{First, tables},
};
use std::{f64::consts::SQRT_2, num::FpCategory};

const EPS: f64 = f64::EPSILON;
/// A law by `sqrt`, two by few multiplications, one by a longer product, one by `powf`.
const ALPHAS: [f64; 5] = [1.5, 2.0, 3.0, 5.0, 1.2];
/// No resonators, moving ones, fixed ones.
const RHOS: [f64; 3] = [0.0, 0.5, f64::INFINITY];
/// Around one, two and three times the block of 128 sites of a sweep, and the shortest chains.
const SIZES: [usize; 12] = [1, 2, 3, 4, 127, 128, 129, 255, 256, 257, 300, 385];

/// A chain, precompressed where its boundary allows it.
fn chain(alpha: f64, rho: f64, boundary: Boundary, sites: usize) -> Chain<f64> {
    let chain = Chain::new(Params::new(alpha, 0.7, rho).unwrap(), boundary, sites).unwrap();
    match boundary {
        Boundary::Fixed | Boundary::Ring => chain.precompressed(0.3).unwrap(),
        _ => chain,
    }
}

fn every_chain(sizes: &[usize]) -> Vec<Chain<f64>> {
    let mut chains = Vec::new();
    for &sites in sizes {
        for boundary in Boundary::ALL {
            for rho in RHOS {
                chains.extend(ALPHAS.map(|alpha| chain(alpha, rho, boundary, sites)));
            }
        }
    }
    chains
}

/// A random state. On a strain ring it has an energy: the mean strain is at rest, and equal for
/// beads and resonators.
fn state(chain: &Chain<f64>) -> Vec<f64> {
    let n = chain.sites();
    let mut next = random_signed(n as u64);
    let mut y: Vec<f64> = (0..chain.layout().dim()).map(|_| next()).collect();
    if chain.boundary() == Boundary::StrainRing {
        for array in y.chunks_mut(n) {
            let old = array.to_vec();
            (0..n).for_each(|i| array[i] = old[i] - old[(i + n - 1) % n]);
        }
    }
    y
}

/// A random state without overlaps near zero, where the force has a kink.
fn state_off_the_kinks(chain: &Chain<f64>) -> Vec<f64> {
    let (mut y, mut next) = (state(chain), random_signed(0));
    while let Some(bond) = chain.overlaps(chain.layout().u(&y)).iter().position(|g| g.abs() < 0.02) {
        y[bond % chain.sites()] = next();
    }
    y
}

fn power(alpha: f64, g: f64) -> f64 {
    if alpha == 1.5 {
        g * g.sqrt()
    } else if alpha.fract() != 0.0 {
        g.powf(alpha)
    } else if alpha <= 3.0 {
        (1..alpha as u32).fold(g, |power, _| power * g)
    } else {
        num_traits::pow(g, alpha as usize)
    }
}

/// The contact force on every site, bond by bond.
fn naive_forces(chain: &Chain<f64>, q: &[f64]) -> Vec<f64> {
    let n = chain.sites() as isize;
    let around = |i: isize| q[i.rem_euclid(n) as usize];
    let position = |i: isize| match chain.boundary() {
        Boundary::Ring | Boundary::StrainRing => Some(around(i)),
        _ if (0..n).contains(&i) => Some(around(i)),
        Boundary::Fixed => Some(0.0),
        Boundary::LeftWall => (i < 0).then_some(0.0),
        Boundary::RightWall => (i >= n).then_some(0.0),
        Boundary::Free => None,
    };
    let law = |g: f64| if g > 0.0 { power(chain.params().alpha, g) } else { 0.0 };
    let bond = |i: isize| match (position(i - 1), position(i)) {
        (_, Some(x)) if chain.boundary() == Boundary::StrainRing => law(-x),
        (Some(left), Some(right)) => law(chain.precompression() + (left - right)),
        _ => 0.0,
    };
    let force = |i: isize| match chain.boundary() {
        Boundary::StrainRing => (bond(i) - bond(i - 1)) - (bond(i + 1) - bond(i)),
        _ => bond(i) - bond(i + 1),
    };
    (0..n).map(force).collect()
}

/// The second half of the vector field: `u''`, and `v''` where resonators move.
fn accelerations(chain: &Chain<f64>, y: &[f64]) -> Vec<f64> {
    let mut dy = vec![0.0; y.len()];
    Field::new(chain.clone()).eval(0.0, y, &mut dy);
    assert_eq!(dy[..y.len() / 2], y[y.len() / 2..], "q' is the velocity");
    dy.split_off(y.len() / 2)
}

fn largest_gap(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    distance(a, b)
}

#[test]
fn forces_are_minus_the_gradient_of_the_energy() {
    // Truth: central differences of the energy. Their error is d^2 E'''/6 + eps E/d.
    let d = 1e-5;
    let mut worst = 0.0_f64;
    for chain in every_chain(&[1, 2, 3, 127, 128, 129, 300]) {
        if chain.boundary() == Boundary::StrainRing {
            continue;
        }
        let mut y = state_off_the_kinks(&chain);
        let mut energy = |i: usize, by: f64| {
            let old = y[i];
            y[i] += by;
            let energy = chain.energy(&y).total();
            y[i] = old;
            energy
        };
        let gradient: Vec<f64> =
            (0..chain.layout().dim() / 2).map(|i| (energy(i, d) - energy(i, -d)) / (2.0 * d)).collect();
        let n = chain.sites();
        for (i, a) in accelerations(&chain, &y).into_iter().enumerate() {
            let mass = if i < n { 1.0 } else { chain.params().rho };
            worst = worst.max((mass * a + gradient[i]).abs());
        }
    }
    assert_below(worst, 1e-8, "force + dE/du");
}

#[test]
fn a_strain_ring_has_an_energy_only_where_its_mean_strain_rests() {
    // Truth: for the means x'' - y'' = -omega^2 (x - y), which is Hamiltonian in displacements only
    // if it is zero.
    for rho in RHOS {
        let chain = chain(1.5, rho, Boundary::StrainRing, 5);
        let half = chain.layout().dim() / 2;
        let y = state(&chain);
        let shifted = |i: usize| {
            let mut y = y.clone();
            y[i] += 1e-3;
            chain.has_energy(&y)
        };
        assert!(chain.has_energy(&y));
        assert_eq!(shifted(0), chain.params().resonators() == Resonators::None, "strain, rho = {rho}");
        assert!(!shifted(half), "its velocity, rho = {rho}");
    }
}

#[test]
fn a_strain_ring_moves_as_the_differences_of_a_ring() {
    // Truth: the displacement chain, an independent formula. Both agree up to the rounding of sums
    // of a few forces.
    let (mut worst, mut worst_energy) = (0.0_f64, 0.0_f64);
    for ring in every_chain(&[1, 2, 3, 128, 129]) {
        if ring.boundary() != Boundary::Ring {
            continue;
        }
        let ring = ring.precompressed(0.0).unwrap();
        let strains = Chain::new(ring.params(), Boundary::StrainRing, ring.sites()).unwrap();
        let n = ring.sites();
        let differences =
            |y: &[f64]| -> Vec<f64> { y.chunks(n).flat_map(|q| (0..n).map(|i| q[i] - q[(i + n - 1) % n])).collect() };
        let mut y = state(&ring);
        let want = differences(&accelerations(&ring, &y));
        let got = accelerations(&strains, &differences(&y));
        let scale = 1.0 + largest(want.iter().copied());
        worst = worst.max(largest_gap(&got, &want) / scale);
        // Their energies agree where the mean displacement of the ring is zero and at rest.
        for q in y.chunks_mut(n) {
            let mean = q.iter().sum::<f64>() / n as f64;
            q.iter_mut().for_each(|q| *q -= mean);
        }
        let energies = (strains.energy(&differences(&y)).total(), ring.energy(&y).total());
        worst_energy = worst_energy.max((energies.0 - energies.1).abs() / (1.0 + energies.1));
    }
    assert_below(worst, 2.0 * EPS, "accelerations");
    assert_below(worst_energy, 16.0 * EPS, "energies");
}

#[test]
fn the_sweep_equals_a_naive_loop_bit_for_bit_at_every_length() {
    // Truth: one scalar loop without blocks, compiled for the baseline instructions.
    for chain in every_chain(&SIZES) {
        let y = state(&chain);
        let (n, u) = (chain.sites(), chain.layout().u(&y));
        let forces = naive_forces(&chain, u);
        let kappa = chain.params().kappa;
        let want: Vec<f64> = match chain.params().resonators() {
            Resonators::None => forces,
            Resonators::Fixed => (0..n).map(|i| forces[i] - kappa * y[i]).collect(),
            Resonators::Moving => {
                let beads = (0..n).map(|i| forces[i] - kappa * (y[i] - y[n + i]));
                let per_rho = kappa / chain.params().rho;
                beads.chain((0..n).map(|i| per_rho * (y[i] - y[n + i]))).collect()
            }
        };
        assert_eq!(accelerations(&chain, &y), want, "{chain:?}");
    }
}

fn stored(flow: &impl SplitFlow<f64>) -> Vec<f64> {
    let mut y = vec![f64::NAN; flow.dim()];
    flow.store(&mut y);
    y
}

#[test]
fn a_kick_of_either_flow_adds_the_force_to_the_velocity_and_moves_nothing() {
    // Truth: u' + j f, and for the kinetic flow the springs as well, up to the rounding of the
    // change of variables.
    let mut worst = 0.0_f64;
    for chain in every_chain(&SIZES) {
        let (n, half) = (chain.sites(), chain.layout().dim() / 2);
        let y = state(&chain);
        let mut flow = LinearFlow::new(chain.clone());
        flow.load(&y);
        flow.drift(DoubleDouble::new(0.4));
        let before = stored(&flow);
        flow.kick_drift(0.1, DoubleDouble::zero());
        let mut want = before.clone();
        let forces = naive_forces(&chain, &before[..n]);
        (0..n).for_each(|i| want[half + i] += 0.1 * forces[i]);
        let scale = 1.0 + largest(want.iter().copied());
        worst = worst.max(largest_gap(&stored(&flow), &want) / scale);

        let mut flow = KineticFlow::new(chain.clone());
        flow.load(&y);
        flow.kick_drift(0.1, DoubleDouble::zero());
        let mut want = y.clone();
        accelerations(&chain, &y).iter().zip(&mut want[half..]).for_each(|(a, q_dot)| *q_dot += 0.1 * a);
        let scale = 1.0 + largest(want.iter().copied());
        worst = worst.max(largest_gap(&stored(&flow), &want) / scale);
    }
    assert_below(worst, 2.0 * EPS, "kick");
}

#[test]
fn the_linear_flow_is_the_closed_form_at_any_time() {
    // Truth: R0 + R0' t and D0 cos(omega t) + D0' sin(omega t)/omega, with omega to 32 digits and
    // times that are powers of two, so that the phase is exact. Bound: a few roundings of each
    // term.
    let root_2 = (SQRT_2, -9.667_293_313_452_913e-17);
    let root_3 = (1.732_050_807_568_877_2, 1.003_508_422_180_691_7e-16);
    let cases = [(3.0, 0.5, (3.0, 0.0)), (1.0, 0.5, root_3), (2.0, f64::INFINITY, root_2), (1.0, 0.0, (1.0, 0.0))];
    let mut worst = 0.0_f64;
    for (kappa, rho, (omega, omega_low)) in cases {
        let chain = Chain::new(Params::new(1.5, kappa, rho).unwrap(), Boundary::Free, 1).unwrap();
        for t in [0.125, 1.0, 64.0, 16_384.0, 1_048_576.0, 1_073_741_824.0_f64] {
            let y = state(&chain);
            let mut flow = LinearFlow::new(chain.clone());
            flow.load(&y);
            flow.drift(DoubleDouble::new(t));
            let ((s, c), low) = ((omega * t).sin_cos(), omega_low * t);
            let (s, c) = (s + c * low - s * low * low / 2.0, c - s * low - c * low * low / 2.0);
            let turn = |d: f64, d_dot: f64| (d * c + d_dot * s / omega, d_dot * c - d * s * omega);
            let (want, terms) = match chain.params().resonators() {
                Resonators::None => (vec![y[0] + y[1] * t, y[1]], 1.0 + t),
                Resonators::Fixed => {
                    let (u, u_dot) = turn(y[0], y[1]);
                    (vec![u, u_dot], 1.0 + omega)
                }
                Resonators::Moving => {
                    let [u, v, u_dot, v_dot] = [y[0], y[1], y[2], y[3]];
                    let (r, r_dot) = ((u + rho * v) / (1.0 + rho), (u_dot + rho * v_dot) / (1.0 + rho));
                    let (d, d_dot) = turn(u - v, u_dot - v_dot);
                    let (bead, resonator) = (rho / (1.0 + rho), -1.0 / (1.0 + rho));
                    let r = r + r_dot * t;
                    let at = |weight: f64| (r + weight * d, r_dot + weight * d_dot);
                    let ((u, u_dot), (v, v_dot)) = (at(bead), at(resonator));
                    (vec![u, v, u_dot, v_dot], 1.0 + omega + t)
                }
            };
            worst = worst.max(largest_gap(&stored(&flow), &want) / terms);
        }
    }
    assert_below(worst, 2.0 * EPS, "drift over the size of its terms");
}

#[test]
fn a_state_survives_loading_and_storing() {
    // Truth: the state itself, exactly for the kinetic flow, up to the rounding of a change of
    // variables for the linear flow.
    let mut worst = 0.0_f64;
    for chain in every_chain(&[1, 3, 129]) {
        let y = state(&chain);
        let mut kinetic = KineticFlow::new(chain.clone());
        kinetic.load(&y);
        assert_eq!(stored(&kinetic), y);
        assert_eq!(stored(&kinetic.duplicate()), y);
        let mut linear = LinearFlow::new(chain.clone());
        linear.kick_drift(0.3, DoubleDouble::new(0.7));
        linear.load(&y);
        worst = worst.max(largest_gap(&stored(&linear), &y));
        linear.kick_drift(0.3, DoubleDouble::new(0.7));
        assert_eq!(stored(&linear.duplicate()), stored(&linear));
    }
    assert_below(worst, 4.0 * EPS, "round trip");
}

#[test]
fn site_energies_sum_to_the_energy() {
    // Truth: two different sums of the same terms; bound: the rounding of a sum of N positive
    // numbers.
    let mut worst = 0.0_f64;
    for chain in every_chain(&SIZES) {
        let y = state(&chain);
        let total = chain.energy(&y).total();
        let sites = chain.site_energies(&y);
        assert!(sites.len() == chain.sites() && sites.iter().all(|&energy| energy >= 0.0));
        worst = worst.max((sites.iter().sum::<f64>() / total - 1.0).abs());
    }
    assert_below(worst, 16.0 * EPS, "sum over sites");
}

fn assert_no_subnormal(chain: &Chain<f64>, flow: impl SplitFlow<f64>) {
    let (n, steps) = (chain.sites(), 3000);
    let mut run = Splitting::new(&tables::STRANG, First::Drift, flow, (0.0, 150.0), steps).unwrap();
    let mut y = vec![0.0; chain.layout().dim()];
    let mut reached = 0;
    while !run.done() {
        run.step().unwrap();
        run.sample(run.time(), &mut y);
        let forces = chain.overlaps(chain.layout().u(&y)).into_iter().map(|g| chain.law().force(g));
        let subnormal = y.iter().copied().chain(forces).find(|value| value.classify() == FpCategory::Subnormal);
        assert_eq!(subnormal, None, "t = {}, alpha = {}", run.time(), chain.params().alpha);
        reached = (0..n).rfind(|&i| y[i] != 0.0).unwrap();
    }
    assert!(reached > n / 4 && reached < n - 1, "the wave is on its way: site {reached} of {n}");
}

#[test]
fn no_number_becomes_subnormal_ahead_of_a_wave() {
    // Truth: the classification of all numbers of all states of a run. The front decays doubly
    // exponentially, from one to zero within some ten sites; without the dead band of the contact
    // law it always contains subnormal numbers.
    for alpha in [1.2, 1.5, 3.0] {
        let chain = Chain::new(Params::new(alpha, 0.0, 0.0).unwrap(), Boundary::Free, 400).unwrap();
        let mut y = vec![0.0; chain.layout().dim()];
        y[chain.sites()] = 1.0;
        let (mut kinetic, mut linear) = (KineticFlow::new(chain.clone()), LinearFlow::new(chain.clone()));
        kinetic.load(&y);
        linear.load(&y);
        assert_no_subnormal(&chain, kinetic);
        assert_no_subnormal(&chain, linear);
    }
}

fn message<T>(outcome: hertzchain::Result<T>) -> String {
    outcome.err().map(|error| error.to_string()).unwrap_or_default()
}

#[test]
fn parameters_outside_their_rules_are_refused_by_name() {
    // Truth: the rules of the documentation.
    let (nan, inf) = (f64::NAN, f64::INFINITY);
    for alpha in [nan, inf, -inf, 0.0, -1.5] {
        assert!(message(Params::new(alpha, 1.0, 1.0)).starts_with("alpha = "), "{alpha}");
    }
    for kappa in [nan, inf, -inf, -1e-300] {
        assert!(message(Params::new(1.5, kappa, 1.0)).starts_with("kappa = "), "{kappa}");
    }
    for rho in [nan, -inf, -1.0] {
        assert!(message(Params::new(1.5, 1.0, rho)).starts_with("rho = "), "{rho}");
    }
    for (kappa, rho) in [(0.0, 0.0), (1.0, -0.0), (0.0, inf), (1.0, inf), (1e300, 1e-3)] {
        assert!(Params::new(1.5, kappa, rho).is_ok(), "{kappa} {rho}");
    }
    let (good, bad) = (Params::new(1.5, 1.0, 1.0).unwrap(), Params { alpha: nan, kappa: 1.0, rho: 1.0 });
    assert!(message(Chain::<f64>::new(good, Boundary::Free, 0)).starts_with("sites = 0 "));
    assert!(message(Chain::<f64>::new(bad, Boundary::Free, 1)).starts_with("alpha = NaN "));
}

#[test]
fn only_walls_and_rings_hold_a_precompression() {
    // Truth: the rules of the documentation.
    let chain = |boundary| Chain::<f64>::new(Params::new(1.5, 1.0, 1.0).unwrap(), boundary, 4).unwrap();
    for boundary in Boundary::ALL {
        for delta in [f64::NAN, f64::INFINITY, -0.1] {
            assert!(message(chain(boundary).precompressed(delta)).starts_with("precompression = "), "{delta}");
        }
        assert!(chain(boundary).precompressed(0.0).is_ok());
        let holds = matches!(boundary, Boundary::Fixed | Boundary::Ring);
        assert_eq!(chain(boundary).precompressed(0.5).is_ok(), holds, "{boundary:?}");
    }
    // At rest it presses every bead equally from both sides.
    for boundary in [Boundary::Fixed, Boundary::Ring] {
        let chain = chain(boundary).precompressed(0.5).unwrap();
        assert_eq!(accelerations(&chain, &[0.0; 16]), [0.0; 8]);
    }
}
