//! Travelling waves: ansatz and chain in both directions, frequencies, perturbed waves, and the
//! command `wave`.

use crate::numbers::largest;
use hertzchain::{
    chain::{Boundary, Chain, Params, Site, State},
    dps::{Ansatz, Averages, Constraint, Dps, Ends, Envelope, Form, Layout, project},
    integrators::{Collocation, Dop853, Stepper, collocation::StepControl, dop853::Options},
    run::Records,
    run::method::{Method, Setting},
    scene::Scene,
    study::{Adaptive, WaveOptions, WaveStudy, wave},
    sweep::Engine,
    waves::{PerturbedWave, Shape, Size, TravellingWave},
};
use std::f64::consts::PI;

const UNIT: Shape = Shape { q: 0.2 * PI, a: 1.0, b: 1.0, phi: 0.0 };

fn of_size(params: Params, shape: Shape, epsilon: f64) -> TravellingWave {
    TravellingWave::new(params, shape, Size::Epsilon(epsilon)).unwrap()
}

/// The state of a run at `t`; times increase from call to call.
fn at(run: &mut impl Stepper<f64>, t: f64) -> Vec<f64> {
    while run.time() < t && !run.done() {
        run.step().unwrap();
    }
    let mut y = vec![0.0; run.dim()];
    run.sample(t.min(run.time()), &mut y);
    y
}

/// The flow from `z`, for slow times up to `end`.
fn flowing(dps: Dps, z: &[f64], end: f64) -> Dop853<f64, Dps> {
    Dop853::new(dps, z, (0.0, end), Options::new(1e-13)).unwrap()
}

fn numbers(site: &Site<f64>) -> [f64; 4] {
    [site.u, site.v, site.u_dot, site.v_dot]
}

fn rings(sites: usize, form: Form) -> Layout {
    Layout { sites, ends: Ends::Ring, form }
}

// --- Ansatz: envelope to chain ---

#[test]
fn the_ansatz_of_an_exact_envelope_is_the_travelling_wave() {
    // (eq:An_tw) in (eq:xy_app) and (eq:xy_v_app) gives (eq:xytw_app) and its rates: a closed form,
    // at kappa != 1 and with a phase.
    for (alpha, kappa, rho) in [(1.5, 0.7, 2.5), (2.0, 3.0, 0.2), (1.5, 1.0, 1.0 / 3.0)] {
        let params = Params::new(alpha, kappa, rho).unwrap();
        let wave = of_size(params, Shape { q: 0.4 * PI, a: 0.8, b: -0.3, phi: 0.4 }, 0.05);
        let Shape { q, a, b, phi } = wave.shape();
        let force = Averages::new(alpha, kappa).unwrap().g(b, a);
        for constraint in [Constraint::Force(force), Constraint::MeanStrain(b)] {
            let mut ansatz = Ansatz::generalised(params, constraint, rings(10, Form::Strains), wave.epsilon()).unwrap();
            for t in [0.0, 1.3, 400.0] {
                let phase = |n: usize| (wave.omega_tw() - params.omega()) * t - q * n as f64 - phi;
                let parts: [fn(f64) -> f64; 2] = [f64::cos, f64::sin];
                let z: Vec<f64> = parts.iter().flat_map(|part| (0..10).map(|n| a * part(phase(n)))).collect();
                for (n, site) in ansatz.sites(t, &z).iter().enumerate() {
                    for (one, other) in numbers(site).iter().zip(numbers(&wave.site(n, t))) {
                        // Measured: 5e-14 at t = 400, the rounding error of omega t.
                        assert!((one - other).abs() < 1e-13 * wave.amplitude() * (1.0 + rho.recip()) * params.omega());
                    }
                }
            }
        }
    }
}

#[test]
fn rates_of_the_ansatz_are_derivatives_of_its_positions() {
    // Along the flow, at an epsilon at which slow and fast terms have the same size. Truth:
    // sixth-order differences of the positions alone.
    let params = Params::new(1.5, 1.3, 0.6).unwrap();
    let (epsilon, h, centre) = (0.5, 0.02, 2.0);
    let z: Vec<f64> = (0..12).map(|k| 0.7 + 0.5 * f64::from(k * k % 7) - 0.9 * f64::from(k % 3)).collect();
    let free = Layout { sites: 6, ends: Ends::Free, form: Form::Displacements };
    let cases = [
        (Constraint::Force(1.2), rings(6, Form::Strains)),
        (Constraint::MeanStrain(0.4), rings(6, Form::Strains)),
        (Constraint::MeanStrain(0.0), rings(6, Form::Displacements)),
        (Constraint::Force(0.8), free),
    ];
    let check = |mut ansatz: Ansatz, dps: Dps| {
        let mut run = flowing(dps, &z, 2.0);
        let path: Vec<Vec<Site<f64>>> = (-3..=3)
            .map(|k| {
                let t = centre + h * f64::from(k);
                let z = at(&mut run, ansatz.slow_time(t));
                ansatz.sites(t, &z)
            })
            .collect();
        let mut slow = 0.0f64;
        for (n, site) in path[3].iter().enumerate() {
            let slope = |of: fn(&Site<f64>) -> f64| {
                let pair = |k: usize| of(&path[3 + k][n]) - of(&path[3 - k][n]);
                (45.0 * pair(1) - 9.0 * pair(2) + pair(3)) / (60.0 * h)
            };
            let &Site { u_dot, v_dot, .. } = site;
            // Measured: 3e-9 of rates of size 1.
            assert!((slope(|site| site.u) - u_dot).abs() < 1e-8, "{n}: {} {u_dot}", slope(|site| site.u));
            assert!((slope(|site| site.v) - v_dot).abs() < 1e-8, "{n}: {} {v_dot}", slope(|site| site.v));
            slow = slow.max((u_dot + params.rho * v_dot).abs());
        }
        slow
    };
    for (constraint, layout) in cases {
        let ansatz = Ansatz::generalised(params, constraint, layout, epsilon).unwrap();
        let slow = check(ansatz, Dps::generalised(params, constraint, layout).unwrap());
        assert!(slow > 1e-2, "the mean strains move, or nothing was tested: {slow}");
    }
    let cradle = Ansatz::plain(1.5, 1.3, free, epsilon).unwrap();
    check(cradle, Dps::plain(1.5, 1.3, free).unwrap());
}

#[test]
fn displacements_have_the_strains_of_the_strain_form() {
    // Two forms of the same envelope: strains, and displacements by summation.
    let params = Params::new(1.5, 1.0, 2.0).unwrap();
    let a: Vec<f64> = (0..10).map(|k| (f64::from(k) * 1.7).sin()).collect();
    let strains = |a: &[f64]| (0..a.len()).map(|n| a[n] - a[(n + a.len() - 1) % a.len()]).collect::<Vec<_>>();
    let d: Vec<f64> = a.chunks(5).flat_map(strains).collect();
    let of = |form, z: &[f64]| {
        let ansatz = Ansatz::generalised(params, Constraint::MeanStrain(0.0), rings(5, form), 0.1);
        ansatz.unwrap().sites(0.7, z)
    };
    let (u, x) = (of(Form::Displacements, &a), of(Form::Strains, &d));
    for n in 0..5 {
        let before = numbers(&u[(n + 4) % 5]);
        for (k, value) in numbers(&x[n]).iter().enumerate() {
            assert!((numbers(&u[n])[k] - before[k] - value).abs() < 1e-14);
        }
    }
}

// --- Chain to envelope ---

#[test]
fn projection_inverts_the_ansatz_to_second_order_of_the_slowness() {
    // Theory: the remainder is the curvature of the envelope, epsilon^{2 (alpha-1)} T^2/12
    // d^2/dtau^2 of Z and M, minus 3/(4 pi^2) of that of conj(Z) e^{-2 i omega t}. Truth: second
    // differences of the flow.
    let params = Params::new(1.5, 0.8, 1.5).unwrap();
    let (sites, tau, apart) = (8, 0.5, 0.003);
    let wave = of_size(params, Shape { q: 0.5 * PI, b: 0.4, ..UNIT }, 0.1);
    let perturbed = PerturbedWave::new(wave, sites, 0.5, 1).unwrap();
    let (z, layout) = (perturbed.amplitudes().to_vec(), rings(sites, Form::Strains));
    for constraint in [perturbed.constraint(), Constraint::MeanStrain(0.4)] {
        let dps = || Dps::generalised(params, constraint, layout).unwrap();
        let mut run = flowing(dps(), &z, 1.0);
        let [before, now, after] = [tau - apart, tau, tau + apart].map(|tau| {
            let z = at(&mut run, tau);
            let means = dps().mean_strains(&z).to_vec();
            [z, means].concat()
        });
        let curvature = |k: usize| (before[k] - 2.0 * now[k] + after[k]) / (apart * apart);
        let misfit = |epsilon: f64| -> Vec<f64> {
            let mut ansatz = Ansatz::generalised(params, constraint, layout, epsilon).unwrap();
            let mut run = flowing(dps(), &z, 1.0);
            let state = |t: f64| {
                let sites = ansatz.sites(t, &at(&mut run, ansatz.slow_time(t)));
                let parts: [fn(&Site<f64>) -> f64; 4] = [|s| s.u, |s| s.v, |s| s.u_dot, |s| s.v_dot];
                Ok(parts.iter().flat_map(|part| sites.iter().map(part)).collect())
            };
            let t = tau / epsilon.powf(params.alpha - 1.0);
            let Envelope { amplitudes, means } = project(params, epsilon, t, state).unwrap();
            let period = 2.0 * PI / params.omega();
            [amplitudes, means]
                .concat()
                .iter()
                .zip(&now)
                .map(|(a, b)| (a - b) / (epsilon * period * period / 12.0))
                .collect()
        };
        for epsilon in [1e-4, 1e-5, 1e-6] {
            let (misfit, phase) = (misfit(epsilon), 2.0 * params.omega() * tau / epsilon.sqrt());
            let conjugate = |k: usize| {
                let (re, im) = (curvature(k % sites), curvature(sites + k % sites));
                if k < sites { re * phase.cos() - im * phase.sin() } else { -re * phase.sin() - im * phase.cos() }
            };
            let share = |k: usize| if k < 2 * sites { 0.75 / (PI * PI) * conjugate(k) } else { 0.0 };
            let off = largest((0..24).map(|k| misfit[k] - curvature(k) + share(k))) / largest((0..24).map(curvature));
            // The bound covers higher derivatives of the envelope and the error of second
            // differences.
            assert!(off < 5e-3, "epsilon = {epsilon:e}: {off}");
        }
    }
}

// --- The chain against the ansatz ---

fn ring(params: Params, sites: usize) -> Chain<f64> {
    Chain::new(params, Boundary::StrainRing, sites).unwrap()
}

fn run_of(chain: &Chain<f64>, site: impl FnMut(usize) -> Site<f64>, end: f64) -> Collocation<Chain<f64>> {
    let start = State::from_fn(chain, site).unwrap();
    chain.collocation(start.as_slice(), (0.0, end), StepControl::Tolerance(1e-10)).unwrap()
}

/// The mean over a period of the velocity that the contacts give `(x_n + rho y_n) / (1 + rho)` of
/// (eq:xytw_app) from `t = 0` on.
///
/// The force of bond `n` is `f(theta_n - omega t)`. Its impulse since `t = 0`, minus that of its
/// mean, is `(F(theta_n) - F(theta_n - omega t)) / omega` with `F' = f - mean` and the mean of `F`
/// zero. The mean of the impulse is therefore `F(theta_n) / omega`.
fn drift(wave: &TravellingWave, n: usize) -> f64 {
    let (Params { alpha, kappa, rho }, Shape { q, a, b, phi }) = (wave.params(), wave.shape());
    let force = |theta: f64| (wave.epsilon() * (-b - 2.0 * kappa * a * theta.cos())).max(0.0).powf(alpha);
    // F(theta) = 1/(2 pi) int_0^{2 pi} (s - pi) f(theta + s) ds, by the midpoint rule.
    const K: i32 = 4000;
    let integral = |theta: f64| {
        let nodes = (0..K).map(|k| 2.0 * PI * (f64::from(k) + 0.5) / f64::from(K));
        nodes.map(|s| force(theta + s) * (s - PI)).sum::<f64>() / f64::from(K)
    };
    let theta = n as f64 * q + phi;
    (2.0 * integral(theta) - integral(theta + q) - integral(theta - q)) / ((1.0 + rho) * wave.params().omega())
}

/// The state (eq:ini_tw), and if `driftless` without the drift that the first order of the theory
/// neglects.
fn start(wave: TravellingWave, driftless: bool) -> impl Fn(usize) -> Site<f64> {
    move |n| {
        let (site, shift) = (wave.site(n, 0.0), if driftless { drift(&wave, n) } else { 0.0 });
        Site { u_dot: site.u_dot - shift, v_dot: site.v_dot - shift, ..site }
    }
}

/// The largest `[E_x, E_y]` of many samples up to `end`.
fn errors(wave: TravellingWave, sites: usize, end: f64, driftless: bool) -> [f64; 2] {
    const SAMPLES: u32 = 4000;
    let mut run = run_of(&ring(wave.params(), sites), start(wave, driftless), end);
    let mut worst = [0.0f64; 2];
    for k in 0..=SAMPLES {
        let t = end * f64::from(k) / f64::from(SAMPLES);
        let y = at(&mut run, t);
        let (e_x, e_y) = wave.errors(t, &y[..sites], &y[sites..2 * sites]);
        worst = [worst[0].max(e_x), worst[1].max(e_y)];
    }
    worst
}

#[test]
fn the_ansatz_is_as_good_as_the_theory_says() {
    // Relative errors over three octaves of epsilon, alpha = 3/2. Theory:
    // - Up to a fixed t, the next term of the expansion, epsilon^{alpha-1}: power 1/2.
    // - Up to a fixed tau, epsilon^{(alpha-1)/2}: power 1/4. The ansatz starts without the velocity
    //   epsilon^{alpha-1} that the mean strains have in the next order (`drift`). Contacts of
    //   stiffness epsilon^{alpha-1} hold the mean strains, so the missing velocity makes them swing
    //   with a frequency of order epsilon^{(alpha-1)/2} and an amplitude of the order of the ratio.
    // - Up to a fixed tau from a start with that velocity: power 1/2 again, which confirms the
    //   cause.
    //
    // Measured: 0.497 (x, y, both rho); 0.253, 0.243 at rho = 1/3 and 0.269, 0.262 at rho = 3; 0.46
    // to 0.48.
    for rho in [1.0 / 3.0, 3.0] {
        let params = Params::new(1.5, 1.0, rho).unwrap();
        let period = 2.0 * PI / params.omega();
        let ladder = |first: f64, end: &dyn Fn(f64) -> f64, driftless: bool| -> Vec<[f64; 2]> {
            let errors = |k| {
                let epsilon = first * 0.5f64.powi(k);
                errors(of_size(params, UNIT, epsilon), 10, end(epsilon), driftless)
            };
            (0..4).map(errors).collect()
        };
        let fixed_t = ladder(1e-5, &|_| 2.0 * period, false);
        let fixed_tau = ladder(1e-3, &|epsilon| 10.0 / epsilon.sqrt(), false);
        let driftless = ladder(1e-3, &|epsilon| 10.0 / epsilon.sqrt(), true);
        for (what, ladder, power, bound) in
            [("t", fixed_t, 0.5, 0.006), ("tau", fixed_tau, 0.25, 0.04), ("tau, driftless", driftless, 0.5, 0.08)]
        {
            for (i, name) in ["x", "y"].iter().enumerate() {
                let over_three = (ladder[0][i] / ladder[3][i]).log2() / 3.0;
                assert!((over_three - power).abs() < bound, "rho = {rho}, fixed {what}, {name}: {over_three}");
            }
        }
    }
}

/// The frequency shift of a wave on the chain, divided by `omega epsilon^{alpha-1}`: from the phase
/// of its Fourier mode in `x - y` up to `tau = 30`.
fn measured_shift(wave: TravellingWave, sites: usize) -> f64 {
    let (params, q, slowness) = (wave.params(), wave.shape().q, wave.slow_time(1.0));
    let (omega, end) = (params.omega(), 30.0 / slowness);
    let mut run = run_of(&ring(params, sites), start(wave, false), end);
    // Samples are not in step with the oscillation, so that its harmonics average out.
    let count = (end * omega / (2.0 * PI) * 1.3).ceil() as usize;
    let mut phase = 0.0f64;
    let (mut xx, mut xp) = (0.0, 0.0);
    for k in 0..=count {
        let t = end * k as f64 / count as f64;
        let y = at(&mut run, t);
        let (mut re, mut im) = (0.0, 0.0);
        for n in 0..sites {
            let (d, v) = (y[n] - y[sites + n], (y[2 * sites + n] - y[3 * sites + n]) / omega);
            let (sin, cos) = (q * n as f64 - omega * t).sin_cos();
            (re, im) = (re + d * cos + v * sin, im + d * sin - v * cos);
        }
        phase += (im.atan2(re) - phase + PI).rem_euclid(2.0 * PI) - PI;
        // The slope of the line fitted to points that are symmetric about the middle.
        let x = k as f64 - 0.5 * count as f64;
        (xx, xp) = (xx + x * x, xp + x * phase);
    }
    xp / xx * count as f64 / end / slowness
}

#[test]
fn the_frequency_has_omega_cubed_and_no_kappa() {
    // (disp): the paper prints 2 / (kappa omega^3). Measured on the chain at epsilon = 1e-5, where
    // the next order, epsilon^{1/2}, is at most 0.36 % (kappa = 0.4, q = 4 pi/5; 1.1 % at 1e-4
    // and 0.11 % at 1e-6).
    for kappa in [0.4, 2.5] {
        for (q, sites) in [(0.2, 10), (0.8, 5)] {
            let params = Params::new(1.5, kappa, 1.0).unwrap();
            let wave = of_size(params, Shape { q: q * PI, b: 0.3, ..UNIT }, 1e-5);
            let corrected = (wave.omega_tw() - params.omega()) / wave.slow_time(1.0);
            let measured = measured_shift(wave, sites);
            assert!((measured / corrected - 1.0).abs() < 5e-3, "kappa = {kappa}: {measured} {corrected}");
            assert!((measured / (corrected / kappa) - 1.0).abs() > 0.5, "the printed factor");
        }
    }
}

fn options(method: &str, tolerance: f64) -> WaveOptions {
    WaveOptions {
        solver: Adaptive { method: Method::named(method).unwrap(), tol: tolerance },
        ..WaveOptions::default()
    }
}

fn study(scene: &Scene, options: &WaveOptions) -> WaveStudy {
    wave(scene, options, &Engine::threads(), &|_, _| {}).unwrap()
}

#[test]
fn two_integrators_agree_on_all_seven_runs_of_the_paper() {
    // Bounds of the paper: at most 8 % for the first run; the ansatz fails in the breakdown runs,
    // and for E_y at rho = 1000.
    for (name, largest_x, largest_y) in [
        ("tw-q15", 0.076_354, 0.028_384),
        ("tw-q45", 0.054_852, 0.022_412),
        ("tw-breakdown-q15", 6.826_076, 2.504_518),
        ("tw-breakdown-q45", 0.474_418, 0.377_379),
        ("tw-rho3", 0.070_108, 0.170_146),
        ("tw-rho10", 0.089_166, 0.488_963),
        ("tw-rho1000", 0.049_734, 4.332_313),
    ] {
        let scene = Scene::load(name).unwrap();
        let one = study(&scene, &options("collocation", 1e-12));
        let other = study(&scene, &options("dop853-regularised", 1e-13));
        assert_eq!(one.t, other.t);
        let pairs = [(&one.errors.x, &other.errors.x, largest_x), (&one.errors.y, &other.errors.y, largest_y)];
        for (one, other, expected) in pairs {
            // The comparison is at every sample, and so at the end and at the maximum. Measured: at
            // most 5e-9.
            let apart = largest(one.iter().zip(other).map(|(a, b)| a - b));
            assert!(apart < 1e-8, "{name}: {apart:e}");
            assert!((largest(one.iter().copied()) - expected).abs() < 1e-5, "{name}");
        }
    }
}

// --- Perturbed waves ---

#[test]
fn draws_follow_from_the_seed_and_stay_within_zeta() {
    let wave = *Scene::load("tw-q15").unwrap().wave().unwrap();
    let draw = |zeta, seed| PerturbedWave::new(wave, 50, zeta, seed).unwrap();
    let unperturbed = draw(1e-300, 1);
    let changes = |zeta, seed| -> Vec<f64> {
        let perturbed = draw(zeta, seed);
        let pairs = perturbed.amplitudes().iter().zip(unperturbed.amplitudes());
        pairs.filter(|(_, of_wave)| of_wave.abs() > 1e-3).map(|(value, of_wave)| value / of_wave - 1.0).collect()
    };
    let (first, same, other) = (changes(0.1, 1), changes(0.1, 1), changes(0.1, 2));
    assert_eq!(first, same);
    assert!(first.iter().zip(&other).all(|(a, b)| a != b));
    assert!(largest(first.iter().copied()) < 0.1 + 1e-12 && largest(first.iter().copied()) > 0.09);
    // Real and imaginary parts are drawn independently.
    assert!(first[0] != first[first.len() / 2]);
    // A perturbation that rounds to none gives the wave (eq:ini_tw).
    for (n, site) in unperturbed.initial(unperturbed.constraint()).unwrap().iter().enumerate() {
        let apart = numbers(site).iter().zip(numbers(&wave.site(n, 0.0))).map(|(a, b)| a - b).collect::<Vec<_>>();
        assert!(largest(apart) < 1e-14);
    }
}

// Truth: contact forces cancel in sums over the ring. The sums of x and of y move as one bead and
// its resonator, by the closed form. A perturbed wave has no energy to be kept, since its sums
// differ.
#[test]
fn the_sums_of_a_perturbed_wave_are_those_of_the_closed_form() {
    let scene = Scene::load("tw-q15").unwrap().perturbed(0.01, None).unwrap();
    let (n, t, params) = (scene.chain().sites(), scene.end(), scene.chain().params());
    let (omega, rho) = (params.omega(), params.rho);
    let sums = |y: &[f64]| -> Vec<f64> { y.chunks(n).map(|part| part.iter().sum()).collect() };
    let end = |name: &str, tol: f64| {
        let run = scene.run().method(Method::named(name).unwrap()).setting(Setting::Tolerance(tol));
        let outcome = run.records(Records::Energy).start().unwrap();
        assert!(outcome.energy_error.is_none(), "no energy on a ring whose sums differ");
        outcome.state
    };
    let [x, y, vx, vy] = sums(scene.initial().as_slice())[..] else { panic!() };
    let amplitude = (x - y).hypot((vx - vy) / omega);
    assert!(amplitude > 1e-4, "{amplitude:e}");
    let (sin, cos) = (omega * t).sin_cos();
    let apart = (x - y) * cos + (vx - vy) * sin / omega;
    let centre = x + rho * y + t * (vx + rho * vy);
    let state = end("collocation", 1e-10);
    let [x, y, ..] = sums(&state)[..] else { panic!() };
    let errors = [x - y - apart, x + rho * y - centre].map(f64::abs);
    let other = end("dop853-regularised", 1e-12);
    let methods = largest(state.iter().zip(&other).map(|(a, b)| a - b));
    println!("amplitude {amplitude:e}, off {errors:?}; two methods {methods:e}");
    // Measured: 1.2e-14 and 6.1e-10.
    assert!(errors.iter().all(|error| *error < 2.4e-14) && methods < 1.2e-9, "{errors:?} {methods:e}");
}

#[test]
fn growth_separates_what_is_unstable_from_what_is_not() {
    // Paper, Sec. 4: the perturbation grows for q = pi/5 at rho = 3 and does not for q = 4 pi/5.
    // Medians over 8 seeds; over 40 they are 7.4 and 1.04.
    for (name, zeta, least, most) in [("tw-rho3", 0.01, 5.0, 12.0), ("tw-q45", 0.1, 0.9, 1.2)] {
        let scene = Scene::load(name).unwrap().perturbed(zeta, None).unwrap();
        let study =
            study(&scene, &WaveOptions { seeds: Some(8), samples_per_period: 20, ..options("collocation", 1e-10) });
        let (ensemble, run) = (study.ensemble.as_ref().unwrap(), study.perturbed.as_ref().unwrap());
        let growth = ensemble.spread(|member| member.growth_x).unwrap();
        assert!(growth.low >= least && growth.high <= most, "{name}: {growth:?}");
        assert_eq!(ensemble.members.iter().map(|member| member.seed).collect::<Vec<_>>(), (1..=8).collect::<Vec<_>>());
        // The perturbed wave follows its ansatz about as well as the wave follows its own
        // (measured: 7.6 % and 6.3 %), and so does its envelope (2.5 % and 0.8 % of the amplitude).
        assert!(largest(run.errors.x.iter().copied()) < 0.1);
        let envelopes = run.envelopes.as_ref().unwrap();
        let apart = envelopes.chain.amplitudes.iter().zip(&envelopes.flow.amplitudes).map(|(a, b)| a - b);
        assert!(largest(apart) < 0.05);
    }
}

#[test]
fn bad_waves_are_refused_with_value_and_rule() {
    let params = Params::new(1.5, 1.0, 1.0).unwrap();
    for (shape, size, message) in [
        (Shape { a: -1.0, ..UNIT }, Size::Epsilon(0.01), "a = -1 is not valid: the amplitude is finite and positive"),
        (UNIT, Size::Epsilon(0.0), "epsilon = 0 is not valid: finite and positive"),
        (Shape { q: 0.0, ..UNIT }, Size::Detuning(0.001), "no epsilon has this frequency"),
    ] {
        let text = TravellingWave::new(params, shape, size).unwrap_err().to_string();
        assert!(text.contains(message), "{text}");
    }
    let layout = rings(4, Form::Displacements);
    let text = Ansatz::generalised(params, Constraint::Force(1.0), layout, 0.1).err().unwrap().to_string();
    assert!(text.contains("give the mean strain 0"), "{text}");
    let text = Ansatz::plain(1.5, 1.0, layout, 0.0).err().unwrap().to_string();
    assert!(text.contains("epsilon = 0 is not valid"), "{text}");
    let cradle = Params::new(1.5, 1.0, f64::INFINITY).unwrap();
    assert!(project(cradle, 0.1, 0.0, |_| Ok(vec![0.0; 8])).unwrap_err().to_string().contains("rho = inf"));
}

// --- The command ---

#[cfg(feature = "cli")]
mod command {
    use crate::program::{json, stdout};

    #[test]
    fn a_scene_may_hold_its_perturbation() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.toml");
        let text = stdout("scenes show tw-q15");
        std::fs::write(&path, text.replace("detuning = 0.001", "detuning = 0.001\nzeta = 0.02\nseed = 7")).unwrap();
        let scene = path.to_str().unwrap();
        let by_scene = json(&["wave", scene, "--until", "10"]);
        let by_flags = json("wave tw-q15 --zeta 0.02 --seed 7 --until 10");
        assert_eq!(by_scene["perturbed"], by_flags["perturbed"]);
        assert_eq!(by_scene["perturbed"]["seed"], 7);
        // `run` starts from the same state.
        let run = json(&["run", scene, "--tol", "1e-10", "--until", "10"]);
        assert!(run["e_x_final"].is_null(), "the unperturbed ansatz is not that of a perturbed wave");
        let quiet = json("run tw-q15 --tol 1e-10 --until 10");
        let amplitude = 2.0 * by_flags["epsilon"].as_f64().unwrap();
        let apart = (0..50).map(|n| (run["x"][n].as_f64().unwrap() - quiet["x"][n].as_f64().unwrap()).abs());
        let tilde = by_flags["perturbed"]["tilde_e_x_final"].as_f64().unwrap();
        assert!((apart.fold(0.0, f64::max) / amplitude - tilde).abs() < 1e-8);
        let plan = stdout(&["run", scene, "--plan"]);
        assert!(plan.contains("perturbed by zeta = 0.02, seed 7"), "{plan}");
    }
}

#[test]
fn the_frequency_scales_as_the_model_does() {
    // Times by s and lengths by l: kappa by s^-2, l^{alpha-1} = s^-2. The paper's printed
    // factor fails this at kappa != 1.
    let shape = Shape { q: 0.7, a: 1.0, b: 0.3, phi: 0.0 };
    let at = |kappa: f64, epsilon: f64| {
        // 2 kappa epsilon a and epsilon b are the lengths; keep both proportional.
        let shape = Shape { a: shape.a / kappa, ..shape };
        TravellingWave::new(Params::new(1.5, kappa, 2.0).unwrap(), shape, Size::Epsilon(epsilon)).unwrap().omega_tw()
    };
    let s: f64 = 0.5;
    assert!((at(s.powi(-2), 0.01 * s.powi(-4)) * s / at(1.0, 0.01) - 1.0).abs() < 1e-13);
}
