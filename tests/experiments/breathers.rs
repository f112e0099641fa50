//! Breathers: the numbers of Sec. 5, its long run by two methods and with three boundaries, exact
//! solutions without contact force, and mean contact forces.

use hertzchain::{
    breathers::{BrightBreather, ClosedForm, TrivialBreather},
    chain::{Boundary, Chain, Field, Params, Site, State},
    dps::Center,
    integrators::{Stepper, VectorField, collocation::StepControl},
    run::Records,
    run::method::{Method, Setting},
    scene::{Initial, Scene, Theory},
    study::{Adaptive, BrightStudy, bright_breather},
};
use proptest::prelude::*;
use std::f64::consts::PI;

#[allow(dead_code, reason = "other tests use the rest of it")]
use crate::common::{collocated, distance, largest, truth};
use crate::properties::properties;

const CLOSE: StepControl = StepControl::Tolerance(1e-12);

fn params(alpha: f64, kappa: f64, rho: f64) -> Params {
    Params::new(alpha, kappa, rho).unwrap()
}

fn paper() -> BrightBreather {
    BrightBreather::new(params(1.5, 1.0, 1000.0), Center::Bond, 0.01, 40).unwrap()
}

fn study(scene: &Scene, method: &str, tolerance: f64) -> BrightStudy {
    let options = Adaptive { method: Method::named(method).unwrap(), tol: tolerance };
    bright_breather(scene, &options, 1, &|_, _| ()).unwrap()
}

// Truth: Sec. 5, all digits that it quotes; omega_0 from (eq:defom0) with Gamma(7/4) and Gamma(9/4)
// from tables.
#[test]
fn times_and_frequencies_are_those_of_the_paper() {
    let breather = paper();
    let (gamma_7_4, gamma_9_4) = (0.919_062_526_848_883_3, 1.133_003_096_319_347_1);
    let omega_0 = 0.5f64.sqrt() / PI.sqrt() * gamma_7_4 / gamma_9_4;
    assert!((breather.omega_0() / omega_0 - 1.0).abs() < 1e-14, "{} {omega_0}", breather.omega_0());
    assert_eq!(format!("{:.4}", breather.slow_period()), "19.4158");
    assert_eq!(format!("{:.3}", breather.horizon()), "194.158");
    assert_eq!(format!("{:.4}", breather.period()), "6.0862");
    assert!((breather.omega_b() - (1.0 + omega_0 * 0.1)).abs() < 1e-14);
    // The assumption of the theorem, with C_r = 1.
    assert!((breather.mass_condition() - 0.1).abs() < 1e-14);
    let scene = Scene::load("bright-breather").unwrap();
    assert!((scene.end() / (80.0 * breather.slow_period()) - 1.0).abs() < 1e-14);
    assert_eq!(scene.period(), breather.period());
}

// Truth: the definitions, on a state made for them: each bead of the ansatz is shifted by d, each
// resonator displaced by d, and so on.
#[test]
fn norms_are_what_the_definitions_say() {
    for (alpha, kappa) in [(1.5, 1.0), (2.0, 3.0)] {
        let breather = BrightBreather::new(params(alpha, kappa, 50.0), Center::Site, 0.02, 31).unwrap();
        let chain = Chain::<f64>::new(breather.params(), Boundary::Free, 31).unwrap();
        let (t, d) = (1.7, [1e-3, 2e-3, -3e-3, 4e-3]);
        let shifted = State::from_fn(&chain, |i| {
            let Site { u, v, u_dot, v_dot } = breather.site(i, t);
            Site { u: u + d[0], v: v + d[2], u_dot: u_dot + d[1], v_dot: v_dot + d[3] }
        });
        let norms = breather.norms(t, chain.layout(), shifted.unwrap().as_slice());
        // In the chain's own units; these factors turn kappa into 1: displacements
        // kappa^{1/(alpha-1)}, time kappa^{-1/2}.
        let (length, rate) = (kappa.powf(1.0 / (alpha - 1.0)), kappa.sqrt());
        let epsilon = 0.02 / length;
        let first = 31.0 / (length * epsilon.powf(alpha));
        let expected = [
            d[0] * first,
            d[1] * first / rate,
            -d[2] * first,
            d[3] * 31.0 / (length * rate * epsilon.powf(2.0 * alpha - 1.0)),
        ];
        for (norm, expected) in norms.all().into_iter().zip(expected) {
            assert!((norm / expected - 1.0).abs() < 1e-11, "{norms:?} {expected}");
        }
    }
}

// Truth: dop853-regularised, which shares neither the variables nor the steps of collocation.
// Measured: 2.9e-9 at 80 T, 2e-11 at the horizon; with tolerances ten times as large 2.2e-8, all of
// it from dop853-regularised. Truth for the bound on the energy: its conservation.
#[test]
fn two_methods_agree_on_the_long_run_of_the_paper() {
    let scene = Scene::load("bright-breather").unwrap();
    let one = study(&scene, "collocation", 1e-13);
    let other = study(&scene, "dop853-regularised", 1e-14);
    let times = [one.shown_time(), one.breather.horizon(), scene.end()];
    for (t, bound) in times.into_iter().zip([2e-10, 1e-10, 6e-9]) {
        let gap = distance(&one.at(t).unwrap().norms.all(), &other.at(t).unwrap().norms.all());
        assert!(gap < bound, "t = {t}: {gap:e}");
    }
    assert!(one.energy_error < 1e-13, "{:e}", one.energy_error);
    // Regression: the norms, and the final state of the breather.
    let rounded = |t: f64| one.at(t).unwrap().norms.all().map(|norm| format!("{norm:.8}"));
    assert_eq!(rounded(times[0]), ["1.02785521", "0.89666508", "0.69036562", "0.07529224"]);
    assert_eq!(rounded(times[1]), ["1.52438331", "0.69014190", "0.77445554", "0.08306244"]);
    assert_eq!(rounded(times[2]), ["15.54741894", "7.32107808", "14.26589204", "0.12558191"]);
    assert!((one.kink.height_v - 1.613_139e-3).abs() < 1e-9 && one.kink.between_ends_v.abs() < 1e-15);
    assert!(one.at(times[1]).unwrap().share > 0.998 && one.samples.last().unwrap().share < 0.04);
    assert!(one.tenth_left.is_some_and(|t| (330.0..350.0).contains(&t)));
}

// Truth: the symmetry u_n -> -u_{-n} of the chain. Measured: 1.8e-15 of the amplitude, at the end
// of every step up to 80 T. The breather about a site must fail the test.
#[test]
fn the_breather_about_a_bond_stays_odd_about_its_centre() {
    let defect = |name: &str| {
        let scene = Scene::load(name).unwrap();
        let n = scene.chain().sites();
        let mut run = scene.run().method(Method::Collocation).setting(Setting::Tolerance(1e-12)).stepper().unwrap();
        let mut y = vec![0.0; run.dim()];
        let mut worst: f64 = 0.0;
        while !run.done() {
            run.step().unwrap();
            run.sample(run.time(), &mut y);
            let odd = y.chunks(n).map(|x| largest((0..n).map(|i| x[i] + x[n - 1 - i])));
            worst = worst.max(largest(odd));
        }
        worst / scene.amplitude().unwrap()
    };
    let odd = defect("bright-breather");
    assert!(odd < 4e-15, "{odd:e}");
    assert!(defect("bright-breather-site") > 0.5);
}

// Truth: u(t) = kappa^{1/(alpha-1)} U(sqrt(kappa) t) solves (eq:Hertz) with kappa if U solves it
// with 1. Two runs, one at kappa = 0.3, alpha = 2. Measured: 3.4e-12.
#[test]
fn another_spring_constant_is_another_unit() {
    let run = |kappa: f64| {
        let mut file = Scene::load("bright-breather").unwrap().file().clone();
        (file.chain.alpha, file.chain.kappa) = (2.0, kappa);
        let Initial::BrightBreather { epsilon, .. } = &mut file.initial else { panic!("a bright breather") };
        *epsilon = 0.02 * kappa;
        let scene = Scene::build(file).unwrap();
        let Some(Theory::Bright(breather)) = scene.theory() else { panic!("a bright breather") };
        let until = breather.horizon();
        study(&scene.until(until).unwrap(), "collocation", 1e-12)
    };
    let (one, other) = (run(1.0), run(0.3));
    assert!((other.scene.end() * 0.3f64.sqrt() / one.scene.end() - 1.0).abs() < 1e-14);
    let norms = |study: &BrightStudy| study.samples.last().unwrap().norms.all();
    let gap = distance(&norms(&one), &norms(&other));
    assert!(gap < 7e-12 && norms(&one)[0] > 0.1, "{gap:e} {:?}", norms(&one));
}

#[test]
fn participation_counts_sites() {
    let chain = Chain::<f64>::new(params(1.5, 1.0, 2.0), Boundary::Free, 5).unwrap();
    let moving = |speeds: [f64; 5]| {
        let site = |i: usize| Site { u: 0.0, v: 0.0, u_dot: speeds[i], v_dot: 0.0 };
        chain.participation(State::from_fn(&chain, site).unwrap().as_slice())
    };
    assert_eq!(moving([0.0, 0.0, 3.0, 0.0, 0.0]), 1.0);
    assert_eq!(moving([2.0; 5]), 5.0);
    // The energies of the two beads are 1 and 4: (1 + 4)^2 / (1 + 16) = 25/17.
    assert!((moving([0.0, 1.0, 0.0, 2.0, 0.0]) - 25.0 / 17.0).abs() < 1e-15);
}

/// Amplitudes, phases and offsets of trivial breathers.
fn breathers() -> impl Strategy<Value = (Vec<f64>, Vec<f64>, Vec<f64>)> {
    (2usize..8).prop_flat_map(|n| {
        let rises = prop::collection::vec(prop_oneof![Just(0.0), 0.0..0.3], n);
        (prop::collection::vec(0.0..0.2, n), prop::collection::vec(-4.0..4.0, n), rises).prop_map(|(a, phi, rises)| {
            let d = rises.iter().scan(-0.5, |d, rise| {
                *d += rise;
                Some(*d)
            });
            (a, phi, d.collect())
        })
    })
}

/// The largest overlap of bond `n` in a period, from the closed form at many times.
fn overlap(breather: &TrivialBreather, n: usize) -> f64 {
    let period = 2.0 * PI / breather.params().omega();
    let times = (0..4000).map(|k| period * f64::from(k) / 4000.0);
    times.map(|t| breather.site(n - 1, t).u - breather.site(n, t).u).fold(f64::NEG_INFINITY, f64::max)
}

proptest! {
    #![proptest_config(properties(40))]

    // Truth: the closed form itself, bead by bead. 4000 samples per period miss the maximum by less
    // than 3e-7 of the amplitude.
    #[test]
    fn gaps_are_as_small_as_contacts_allow_and_no_smaller((a, phi, d) in breathers()) {
        let params = params(1.5, 1.3, 0.7);
        let breather = TrivialBreather::new(params, a.clone(), phi.clone(), &d).unwrap();
        for n in 1..a.len() {
            let rise = d[n] - d[n - 1];
            prop_assert!((breather.slack(n) - rise).abs() < 1e-15);
            let overlap = overlap(&breather, n);
            prop_assert!((overlap + rise).abs() < 3e-7 * 0.4 && overlap + rise < 1e-15, "{overlap:e} {rise:e}");
        }
    }

    // Truth: (constraint2) and the closed form: means are refused if and only if beads press, and
    // the message names the bond.
    #[test]
    fn means_that_press_are_refused_by_bond((a, phi, d) in breathers(), pick in 0.0..1.0f64, less in -0.05..0.05f64) {
        let params = params(2.0, 1.0, 3.0);
        let free = TrivialBreather::new(params, a.clone(), phi.clone(), &d).unwrap();
        let bond = 1 + ((a.len() - 1) as f64 * pick) as usize;
        // The gap of one bond becomes the least one minus `less`.
        let mut b = free.means().to_vec();
        let change = free.slack(bond) + less;
        b[bond..].iter_mut().for_each(|b| *b -= change);
        // Rounding errors of this must not make the beads of another bond press.
        for n in (1..b.len()).filter(|&n| n != bond) {
            b[n..].iter_mut().for_each(|b| *b += 1e-12);
        }
        let outcome = TrivialBreather::with_means(params, a, phi, b);
        if less > 1e-14 {
            let message = outcome.unwrap_err().to_string();
            let said = format!("at bond {bond}, where at least {:e} is needed", free.least_gap(bond));
            prop_assert!(message.contains(&said) && message.contains("(constraint2)"), "{message}");
        } else if less < -1e-14 {
            prop_assert!(overlap(&outcome.unwrap(), bond) < 0.0);
        }
    }
}

// Truth: closed form compared with collocation, for beads of any phase that just touch, 1000
// periods. Measured: 3.2e-14 of the amplitude.
#[test]
fn gaps_that_just_close_are_no_contact_for_the_chain_either() {
    let (n, params) = (12, params(1.5, 1.0, 0.5));
    let amplitudes: Vec<f64> = (0..n).map(|i| 0.1 * (-(i as f64 - 5.3).abs() / 2.0).exp()).collect();
    let phases = (0..n).map(|i| (7.0 * i as f64).sin() * 3.0).collect();
    let breather = TrivialBreather::new(params, amplitudes, phases, &vec![0.0; n]).unwrap().centred();
    let chain = Chain::new(params, Boundary::Free, n).unwrap();
    let state = |t| State::from_fn(&chain, |i| breather.site(i, t)).unwrap();
    let end = 1000.3 * 2.0 * PI / params.omega();
    let (y, _) = collocated(&chain, state(0.0).as_slice(), end, CLOSE);
    let gap = distance(&y, state(end).as_slice()) / 0.1;
    assert!(gap < 7e-14, "{gap:e}");
    let forces = chain.mean_contact_forces(state(0.3).as_slice(), 2.0 * PI / params.omega(), CLOSE).unwrap();
    assert!(forces.range().1 < 1e-20, "{forces:?}");
}

// Truth: the equations of motion, by the vector field, at a time at which the phases are accurate.
#[test]
fn the_closed_form_solves_the_equations() {
    let params = params(1.5, 1.7, 0.4);
    let breather = TrivialBreather::new(params, vec![0.1, 0.3, 0.2], vec![0.3, 1.9, -2.0], &[0.0, 0.0, 0.2]).unwrap();
    let chain = Chain::new(params, Boundary::Free, 3).unwrap();
    let at = |t| State::from_fn(&chain, |i| breather.site(i, t)).unwrap().as_slice().to_vec();
    let (t, h) = (2.7, 1e-5);
    let mut rate = vec![0.0; 12];
    Field::new(chain.clone()).eval(t, &at(t), &mut rate);
    let quotient: Vec<f64> = at(t + h).iter().zip(at(t - h)).map(|(a, b)| (a - b) / (2.0 * h)).collect();
    assert!(distance(&rate, &quotient) < 1e-10, "{:e}", distance(&rate, &quotient));
}

fn trivial_scene(initial: &str) -> hertzchain::Result<Scene> {
    let text = format!(
        "name = \"own\"\n[chain]\nsites = 3\nalpha = 1.5\nkappa = 1.0\nrho = 1.0\nboundary = \"free\"\n[initial]\n{initial}\n[span]\nperiods = 1000\n\
         [record]\nsamples = 50\n"
    );
    Scene::build(hertzchain::scene::SceneFile::parse(&text, "own")?)
}

#[test]
fn a_scene_file_says_amplitudes_phases_and_positions_in_any_way() {
    let kind = "kind = \"trivial-breather\"\n";
    let breather = |text: &str| trivial_scene(&format!("{kind}{text}")).unwrap().exact().unwrap().clone();
    let arrays = breather("amplitudes = [0.1, 0.3, 0.2]\nphases = [0.0, 1.0, -1.0]\nd = [0.0, 0.1, 0.1]");
    assert_eq!((arrays.amplitudes(), arrays.phases()), (&[0.1, 0.3, 0.2][..], &[0.0, 1.0, -1.0][..]));
    assert!((arrays.slack(1) - 0.1).abs() < 1e-15 && arrays.slack(2).abs() < 1e-15);
    let means = breather("amplitudes = [0.1, 0.3, 0.2]\nphase_step_over_pi = 0.5\nb = [0.0, 1.0, 2.0]");
    assert_eq!((means.means(), means.phases()[2]), (&[0.0, 1.0, 2.0][..], PI));
    let bell = breather("center = 1.0\namplitude = 0.2\ndecay = 1.0\ngap = 0.25");
    assert!((bell.slack(1) - 0.25).abs() < 1e-15 && bell.means().iter().sum::<f64>().abs() < 1e-15);
    for (text, rule) in [
        ("amplitudes = [0.1, 0.3]", "amplitudes = 2 numbers for 3 sites is not valid: one number a site"),
        ("amplitudes = [0.1, 0.3, 0.2]\nphases = [0.0]", "phases = 1 numbers"),
        ("amplitudes = [0.1, 0.3, 0.2]\ncenter = 1.0", "give `amplitudes`, or"),
        ("center = 1.0\namplitude = 0.1", "give `amplitudes`, or"),
        ("amplitudes = [0.1, -0.3, 0.2]", "amplitude = -0.3"),
        ("amplitudes = [0.1, 0.3, 0.2]\nd = [0.0, 0.1, 0.0]", "d = 0 after 0.1 at site 2 is not valid"),
        (
            "amplitudes = [0.1, 0.3, 0.2]\nb = [0.0, 0.1, 0.5]",
            "at bond 1, where at least 1.9999999999999998e-1 is needed",
        ),
        ("amplitudes = [0.1, 0.3, 0.2]\nb = [0.0, 1.0, 2.0]\ngap = 0.1", "at most one of `b`, `d` and `gap`"),
        ("amplitudes = [0.1, 0.3, 0.2]\ngap = -0.1", "gap = -0.1"),
        ("amplitudes = [0.1, 0.3, 0.2]\nphases = [0.0, 1.0, 2.0]\nphase_step_over_pi = 1.0", "at most one of `phases`"),
        ("amplitude = [0.1, 0.3, 0.2]", "invalid type: sequence, expected a number"),
        ("amplitudes = [0.1, 0.3, 0.2]\nphase = 1.0", "unknown field `phase`"),
    ] {
        let message = trivial_scene(&format!("{kind}{text}")).unwrap_err().to_string();
        assert!(message.contains(rule), "{text}: {message}");
    }
}

// Truth: the same breather, given by its kind and by its state at a time.
#[test]
fn a_state_that_is_a_trivial_breather_is_known_as_one() {
    let kind = "kind = \"trivial-breather\"\namplitudes = [0.1, 0.3, 0.2]\nphases = [0.4, 1.0, -1.0]\ngap = 0.01";
    let scene = trivial_scene(kind).unwrap();
    let breather = scene.exact().unwrap();
    let state =
        |of: fn(Site<f64>) -> f64| format!("{:?}", (0..3).map(|n| of(breather.site(n, 1.7))).collect::<Vec<_>>());
    let text = |change: f64| {
        let u_dot: Vec<f64> = (0..3).map(|n| breather.site(n, 1.7).u_dot + change).collect();
        let [u, v, v_dot] = [state(|site| site.u), state(|site| site.v), state(|site| site.v_dot)];
        format!("kind = \"state\"\nu = {u}\nv = {v}\nu_dot = {u_dot:?}\nv_dot = {v_dot}")
    };
    let again = trivial_scene(&text(0.0)).unwrap();
    let (end, exact) = (again.end(), again.exact().unwrap());
    for n in 0..3 {
        let gap = (exact.site(n, end).u - breather.site(n, 1.7 + end).u).abs();
        // Rounding errors of a phase of 1e4. Measured: 2.6e-14.
        assert!(gap < 6e-14, "{gap:e}");
    }
    // States of other kinds: with a common velocity, and with a contact force.
    assert!(trivial_scene(&text(1e-9)).unwrap().exact().is_none());
    assert!(trivial_scene("kind = \"state\"\nu = [0.1, 0.0, 0.0]").unwrap().exact().is_none());
    assert!(Scene::load("bright-breather").unwrap().exact().is_none());
}

// Truth: the closed form, the energy of the chain, and an integrator on the same scene.
#[test]
fn a_scene_in_closed_form_needs_no_steps() {
    let scene = Scene::load("trivial-breather").unwrap().until(1e9).unwrap();
    let outcome = {
        let mut exact = ClosedForm::new(scene.exact().unwrap(), scene.end());
        scene.run().records(Records::Profiles).observe_by(&mut exact, &mut |_, _| ()).unwrap()
    };
    assert_eq!((outcome.t, outcome.failure.clone()), (1e9, None));
    assert_eq!((outcome.stats.steps, outcome.stats.force_evaluations), (0, 0));
    assert_eq!((outcome.profiles.len(), outcome.samples.len()), (10_001, 10_001));
    assert!(outcome.energy_error.is_some_and(|error| error < 2e-15), "{:?}", outcome.energy_error);
    let (breather, layout) = (scene.exact().unwrap(), scene.chain().layout());
    for n in 0..40 {
        let site = breather.site(n, 1e9);
        let state = &outcome.state;
        let all =
            [layout.u(state)[n], layout.v(state).unwrap()[n], layout.u_dot(state)[n], layout.v_dot(state).unwrap()[n]];
        assert_eq!(all, [site.u, site.v, site.u_dot, site.v_dot]);
    }
    let integrated = scene
        .run()
        .method(Method::named("strang-linear").unwrap())
        .setting(Setting::Steps(1000))
        .records(Records::End)
        .start()
        .unwrap();
    assert!(distance(&integrated.state, &outcome.state) < 1e-15);
    assert!(scene.plan_in_closed_form().iter().any(|line| line.contains("no integrator")));
    let bright = Scene::load("bright-breather").unwrap();
    assert!(bright.exact().is_none());
}

/// `-sum_{k < n} (p_k(T) - p_k(0)) / T`: the mean force of bond `n` of a free chain, from a run by
/// dop853-regularised.
fn by_momenta(chain: &Chain<f64>, y: &[f64], time: f64) -> Vec<f64> {
    let (layout, rho) = (chain.layout(), chain.params().rho);
    let end = truth(chain, y, time, 1e-13);
    let momentum = |y: &[f64], n: usize| layout.u_dot(y)[n] + layout.v_dot(y).map_or(0.0, |v_dot| rho * v_dot[n]);
    let mut sum = 0.0;
    (0..chain.sites() - 1)
        .map(|n| {
            sum += momentum(y, n) - momentum(&end, n);
            sum / time
        })
        .collect()
}

// Truth: momenta at both ends of the time, by another method. The motion is not periodic: forces
// differ from bond to bond. Measured: 1.2e-12 of the largest.
#[test]
fn mean_forces_of_a_free_chain_are_what_momenta_say() {
    for rho in [0.0, 0.3, 10.0] {
        let chain = Chain::new(params(1.5, 1.0, rho), Boundary::Free, 7).unwrap();
        let site = |i: usize| {
            let u = 0.1 * (3.0 * i as f64).sin();
            Site { u, v: -0.2 * u, u_dot: 0.1 * (2.0 * i as f64).cos(), v_dot: 0.0 }
        };
        let y = State::from_fn(&chain, site).unwrap();
        let forces = chain.mean_contact_forces(y.as_slice(), 5.0, CLOSE).unwrap();
        let expected = by_momenta(&chain, y.as_slice(), 5.0);
        assert_eq!(forces.first_bond, 1);
        let gap = distance(&forces.forces, &expected) / largest(expected.iter().copied());
        assert!(gap < 3e-12, "rho = {rho}: {gap:e}");
        assert!(forces.spread() > 0.1 * forces.mean(), "not constant: {forces:?}");
    }
}

// Truth: on a strain ring the momenta of strains, by dop853-regularised: x_n' + rho y_n' changes by
// T (2 Fbar_n - Fbar_{n-1} - Fbar_{n+1}). Measured: 1.8e-11 of the mean.
#[test]
fn mean_forces_of_a_strain_ring_are_what_momenta_say() {
    let scene = Scene::load("tw-q15").unwrap();
    let (chain, y, period) = (scene.chain(), scene.initial().as_slice(), scene.period());
    let forces = chain.mean_contact_forces(y, period, CLOSE).unwrap();
    let (layout, n) = (chain.layout(), chain.sites());
    let end = truth(chain, y, period, 1e-14);
    let rho = chain.params().rho;
    let momentum = |y: &[f64], i: usize| layout.u_dot(y)[i] + rho * layout.v_dot(y).unwrap()[i];
    let f = &forces.forces;
    let change = |i: usize| (momentum(&end, i) - momentum(y, i)) / period;
    let gap = largest((0..n).map(|i| change(i) - 2.0 * f[i] + f[(i + n - 1) % n] + f[(i + 1) % n])) / forces.mean();
    assert!(gap < 4e-11, "{gap:e}");
}

// Truth: squares of the profiles, added by hand. About a bond: 0.99994 with a_{-2}, .., a_3
// and 0.99050 without the outer two. About a site: 0.999998 with a_{-3}, .., a_3 and 0.998975
// without the outer two.
#[test]
fn the_core_of_a_breather_of_spheres_is_six_beads_or_seven() {
    let params = Params::new(1.5, 1.0, 1000.0).unwrap();
    let core = |center, sites| BrightBreather::new(params, center, 0.01, sites).unwrap().core();
    assert_eq!((core(Center::Bond, 40), core(Center::Site, 41)), (17..23, 17..24));
}
