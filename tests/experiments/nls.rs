//! The nonlinear Schrodinger equation of loaded chains, against exact waves and runs.

use hertzchain::{
    Boundary, Chain, Run,
    chain::{Params, State},
    run::method::Method,
    waves::{Given, MeanStrain, Nls, Search, Shape, Size, TravellingWave, WaveNumber, WaveSetting},
};
use std::f64::consts::PI;

#[test]
fn the_shift_of_the_frequency_is_that_of_exact_waves() {
    // Truth: waves by Newton's method at a mean strain of -d, whose frequency is
    // omega - beta_0 |A|^2 + O(|A|^4); errors of fourth and sixth order are extrapolated away.
    for (alpha, kappa, rho, overlap) in [(1.5, 0.0, 0.0, 1.0), (1.5, 1.0, 1.0 / 3.0, 1.0), (2.5, 0.4, 3.0, 0.7)] {
        let params = Params::new(alpha, kappa, rho).unwrap();
        for turns in [3, 5, 8, 10] {
            let theta = 2.0 * PI * f64::from(turns) / 20.0;
            let q = WaveNumber::on_ring(theta / PI, 20).unwrap();
            for (band, nls) in Nls::new(params, [1.0, overlap], theta).unwrap().into_iter().enumerate() {
                let of = |share: f64| {
                    let setting = WaveSetting { params, q, omega_tw: nls.omega, mean: MeanStrain::Value(-overlap) };
                    // From the linear wave.
                    let height = share * overlap;
                    let resonator = kappa / (kappa - rho * nls.omega * nls.omega);
                    let of_cell = |f: &dyn Fn(f64) -> f64| (0..q.cell()).map(|n| f(theta * n as f64)).collect();
                    let array = |ratio: f64| -> [Vec<f64>; 2] {
                        let rate = nls.omega * ratio * height;
                        [of_cell(&|x| ratio * height * x.cos() - overlap), of_cell(&|x| rate * x.sin())]
                    };
                    let [[x, vx], [y, vy]] = [1.0, resonator].map(array);
                    let seed = if rho > 0.0 { [x, y, vx, vy].concat() } else { [x, vx].concat() };
                    let wave = Search::default().solve(&setting, Given::Amplitude(height), &seed).unwrap();
                    let [x, ..] = wave.on_ring(20);
                    let first = x.iter().enumerate().map(|(n, x)| x * (theta * n as f64).cos()).sum::<f64>();
                    // At pi all cosines are 1 or -1: the sum of their squares is 20, not 10.
                    let first = first / if turns == 10 { 20.0 } else { 10.0 };
                    let square = (first / 2.0).powi(2) / (4.0 * (theta / 2.0).sin().powi(2));
                    (nls.omega - wave.setting.omega_tw) / square
                };
                let [a, b, c] = [0.04, 0.02, 0.01].map(of);
                let [ab, bc] = [(4.0 * b - a) / 3.0, (4.0 * c - b) / 3.0];
                let measured = (16.0 * bc - ab) / 15.0;
                // Without resonators beta_0 is zero at pi/2 for spheres.
                let size = nls.at_mean_strain.abs().max(nls.nonlinearity.abs());
                let off = (measured - nls.at_mean_strain).abs() / size;
                println!("{alpha} {rho} {turns} {band}: {measured} {} {off:.1e}", nls.at_mean_strain);
                assert!(off < 5.6e-7, "{alpha} {rho} {turns} {band}: {measured} {}", nls.at_mean_strain);
            }
        }
    }
}

#[test]
fn group_velocity_and_dispersion_are_derivatives_of_the_frequency() {
    let params = Params::new(1.5, 1.0, 1.0 / 3.0).unwrap();
    let h = 1e-3;
    for theta in [0.3, 1.0, 2.0, 3.0] {
        let [before, here, after] = [-h, 0.0, h].map(|by| Nls::new(params, [1.0, 1.0], theta + by).unwrap());
        for k in 0..2 {
            let first = (after[k].omega - before[k].omega) / (2.0 * h);
            let second = (after[k].omega - 2.0 * here[k].omega + before[k].omega) / (h * h);
            let off = [first - here[k].group_velocity, second - here[k].dispersion].map(f64::abs);
            println!("{theta} {k}: {off:?}");
            assert!(off[0] < 2.2e-7 && off[1] < 1.8e-7, "{theta} {k}: {off:?}");
        }
    }
}

/// Errors of the strains of a ring at the time `1/epsilon^2`, over `epsilon`, for amplitudes of
/// `2 epsilon`, and their orders. Truth: runs of the chain from the same state.
fn errors(nls: &Nls, params: Params, epsilons: &[f64], sites: impl Fn(f64) -> usize) -> (Vec<f64>, Vec<f64>) {
    let error = |&epsilon: &f64| {
        let sites = sites(epsilon);
        let chain = Chain::new(params, Boundary::Ring, sites).unwrap().precompressed(1.0).unwrap();
        let soliton = nls.soliton(2.0 * epsilon).unwrap();
        let wave = |n: usize, t: f64| {
            let (moved, sites) = (nls.group_velocity * t, sites as f64);
            soliton
                .site((n as f64 - 0.5 * (sites - 1.0) - moved + 0.5 * sites).rem_euclid(sites) - 0.5 * sites + moved, t)
        };
        let state = State::from_fn(&chain, |n| wave(n, 0.0)).unwrap();
        let time = 1.0 / (epsilon * epsilon);
        let run = Run::new(chain, state).until(time).unwrap().method(Method::named("aba1064-linear").unwrap());
        let end = run.step(0.1).unwrap().start().unwrap().state;
        let strain = |n: usize, u: &dyn Fn(usize) -> f64| u(n) - u((n + sites - 1) % sites);
        let gap = |n| (strain(n, &|n| end[n]) - strain(n, &|n| wave(n, time).u)).abs() / epsilon;
        (0..sites).map(gap).fold(0.0, f64::max)
    };
    let errors: Vec<f64> = epsilons.iter().map(error).collect();
    let orders: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    println!("{errors:?} {orders:?}");
    (errors, orders)
}

#[test]
fn bright_envelopes_of_the_optical_band_travel_as_the_equation_says() {
    // Strains are off by O(epsilon) of their size, since the start is right to first order.
    let (params, theta) = (Params::new(1.5, 1.0, 1.0 / 3.0).unwrap(), 0.3 * PI);
    let nls = Nls::new(params, [1.0, 1.0], theta).unwrap()[1];
    assert!(nls.focusing());
    let width = (nls.dispersion / nls.nonlinearity).sqrt();
    let sites = |epsilon: f64| (40.0 * width / epsilon) as usize / 20 * 20;
    let (errors, orders) = errors(&nls, params, &[0.08, 0.04, 0.02], sites);
    assert!(errors[2] < 0.03 && orders.iter().all(|order| (0.8..1.3).contains(order)), "{errors:?} {orders:?}");
}

#[test]
fn dark_envelopes_of_both_bands_travel_as_the_equation_says() {
    // With resonators, and the band without any, for which the order is the truth: nothing says
    // how large the error of first order is.
    let [some, none] = [(1.0, 1.0 / 3.0), (0.0, 0.0)].map(|(kappa, rho)| Params::new(1.5, kappa, rho).unwrap());
    for (params, band) in [(some, 0), (some, 1), (none, 0)] {
        let nls = Nls::new(params, [1.0, 1.0], 0.7 * PI).unwrap()[band];
        assert!(!nls.focusing());
        let width = (-nls.dispersion / nls.nonlinearity).sqrt();
        // A whole number of waves and a half, on a ring so long that the kink takes a part of
        // order epsilon of its mean strain.
        let sites = |epsilon: f64| (3.0 * width / (epsilon * epsilon)) as usize / 20 * 20 + 10;
        let (errors, orders) = errors(&nls, params, &[0.04, 0.02], sites);
        assert!(params.rho == 0.0 || errors[1] < 0.12, "{errors:?}");
        assert!(orders.iter().all(|order| (0.8..1.3).contains(order)), "{errors:?} {orders:?}");
    }
}

#[test]
fn under_weak_loads_it_meets_the_discrete_p_schrodinger_equation() {
    // Waves of equal amplitude over the precompression d: the shift of the frequency from that of
    // free oscillations by the DpS equation at the mean strain -d, and by the NLS equation at the
    // optical band, without amplitude and with. The first are of order d^{alpha-1} and differ by
    // its square, since DpS is of first order in the contacts; the second by a share of that order.
    let (theta, share) = (0.6 * PI, 0.04);
    for alpha in [1.5, 2.5] {
        let params = Params::new(alpha, 1.0, 1.0 / 3.0).unwrap();
        let off = [1e-2, 1e-3, 1e-4].map(|weak: f64| {
            let d = weak.powf((alpha - 1.0).recip());
            let nls = Nls::new(params, [1.0, d], theta).unwrap()[1];
            let wave = |strain: f64| {
                let shape = Shape { q: theta, a: 0.5 * strain / params.kappa, b: -d, phi: 0.0 };
                TravellingWave::new(params, shape, Size::Epsilon(1.0)).unwrap().omega_tw()
            };
            // The shift is c h^2 + O(h^4).
            let h = share * d;
            let square = (0.5 * h / (2.0 * (0.5 * theta).sin())).powi(2);
            let [all, half] = [h, 0.5 * h].map(|h| wave(h) - wave(1e-3 * h));
            let [dps, limit] = [(16.0 * half - all) / 3.0, -nls.at_mean_strain * square];
            let linear = (wave(1e-3 * h) - params.omega()) / (nls.omega - params.omega()) - 1.0;
            println!("{alpha} {weak}: {linear:e} {:e}", dps / limit - 1.0);
            [linear.abs(), (dps / limit - 1.0).abs()]
        });
        for k in [0, 1] {
            let order = (off[0][k] / off[2][k]).log10() / 2.0;
            assert!((order - 1.0).abs() < 0.05, "{alpha} {k}: {off:?}");
        }
    }
}
