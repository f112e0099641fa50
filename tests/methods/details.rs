//! Chains whose beads differ, are damped and driven: against the uniform chain, a program of its
//! own with 34 digits (`tests/reference/details.py`), closed forms and balances.

use crate::{numbers::distance, variations::start};
use hertzchain::{
    chain::{
        Boundary, Chain, Details, Dissipation, Drive, DriveKind, Envelope, Harmonic, Kind, Params, Signal, Site, State,
    },
    run::{Method, Run, Setting, Trajectory},
    scene::Scene,
};
use serde_json::Value;
use std::{fs, path::PathBuf};

fn params(alpha: f64, kappa: f64, rho: f64) -> Params {
    Params::new(alpha, kappa, rho).unwrap()
}

pub(crate) fn run(chain: &Chain<f64>, state: &State<f64>, end: f64, method: &str, setting: Setting) -> Trajectory {
    let run = Run::new(chain.clone(), state.clone()).until(end).unwrap();
    let run = run.method(Method::named(method).unwrap()).setting(setting);
    run.start().unwrap().complete().unwrap()
}

/// Holds ends of runs of a chain of `variations.rs`, and their balances, against regularised DOP853
/// at 1e-14, whose own balance has the bound `most` a step: everything differs, beads are damped
/// and driven, contacts open and close. The states of other methods have the bounds of their rows.
pub(crate) fn methods_agree(what: &str, chain: &Chain<f64>, most: f64, rows: &[(&str, Setting, f64)]) {
    let mut state = State::rest(chain);
    state.as_mut_slice().copy_from_slice(&start(chain));
    let want = run(chain, &state, 9.0, "dop853-regularised", Setting::Tolerance(1e-14));
    let balance = want.energy_error.unwrap();
    assert!(balance < most * want.stats.steps as f64, "{what}: {balance:e}");
    for &(method, setting, bound) in rows {
        let end = run(chain, &state, 9.0, method, setting);
        let (off, balance) = (distance(&end.state, &want.state), end.energy_error.unwrap());
        assert!(off < bound && balance < bound, "{what}, {method}: {off:e} {balance:e}");
    }
}

/// Holds the refusals of a scene in which a text is replaced: the text, what stands in its place,
/// and the words.
pub(crate) fn refuses(scene: &str, cases: &[(&str, &str, &str)]) {
    for (from, to, said) in cases {
        assert!(scene.contains(from), "{from}");
        let message = Scene::parse(&scene.replace(from, to), "it").unwrap_err().to_string();
        assert!(message.contains(said), "{message}");
    }
}

/// Ten beads that meet and part.
fn lively(chain: &Chain<f64>) -> State<f64> {
    let site = |i: usize| Site {
        u: 0.3 * (1.7 * i as f64).sin(),
        v: 0.1 * (2.3 * i as f64).cos(),
        u_dot: 0.5 * (3.1 * i as f64).sin(),
        v_dot: 0.2 * (0.7 * i as f64).cos(),
    };
    State::from_fn(chain, site).unwrap().driven(chain)
}

#[test]
fn beads_that_are_all_equal_are_the_uniform_chain() {
    // Truth: the chain without details, by the same methods with the same steps. Sums have another
    // order: roundings, which contacts enlarge. A ring of one bead has a bond that no force moves,
    // one of two beads two bonds between the same sites.
    for (rho, boundary, n) in [
        (0.0, Boundary::Free, 10),
        (0.4, Boundary::Fixed, 10),
        (f64::INFINITY, Boundary::Ring, 10),
        (0.4, Boundary::Ring, 10),
        (0.4, Boundary::Ring, 1),
        (0.4, Boundary::Ring, 2),
        (0.4, Boundary::Fixed, 1),
        (0.0, Boundary::Free, 1),
    ] {
        let uniform = Chain::<f64>::new(params(1.5, 1.3, rho), boundary, n).unwrap();
        let bonds = uniform.touching().len();
        let details = Details {
            mass: vec![1.0; n],
            kappa: vec![1.3; n],
            rho: vec![rho; n],
            contact: vec![1.0; bonds],
            alpha: vec![1.5; bonds],
            overlap: vec![0.0; bonds],
            ..Details::default()
        };
        let chain = uniform.clone().with(&details).unwrap();
        let state = lively(&uniform);
        assert_eq!(lively(&chain).as_slice(), state.as_slice());
        let gap = |k: fn(&Chain<f64>, &[f64]) -> Vec<f64>| {
            distance(&k(&chain, state.as_slice()), &k(&uniform, state.as_slice()))
        };
        assert!(gap(|chain, y| chain.site_energies(y)) < 1e-15 && gap(|chain, y| vec![chain.momentum(y)]) < 1e-15);
        // Steps that cross contacts hang on roundings: as far apart as their errors.
        let steps = ["verlet", "strang-linear", "yoshida4", "aba1064-linear"]
            .map(|method| (method, Setting::Steps(400), 1e-12));
        let others = [("dop853", 1e-9), ("dop853-landed", 2e-11), ("dop853-regularised", 1e-11)]
            .map(|(method, bound)| (method, Setting::Tolerance(1e-12), bound));
        let windows = ("collocation", Setting::Windows(80, 12), 2e-13);
        for (method, setting, bound) in steps.into_iter().chain(others).chain([windows]) {
            let [a, b] = [&chain, &uniform].map(|chain| run(chain, &state, 8.0, method, setting));
            let gap = distance(&a.state, &b.state);
            assert!(gap < bound, "{method} {rho} {boundary:?} {n}: {gap:e}");
        }
    }
}

/// A stored case: chain, initial state, end time, end state with its ledger.
pub(crate) fn stored(name: &str) -> (Chain<f64>, State<f64>, f64, Vec<f64>) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("tests/reference/details-{name}.json"));
    let value: Value = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    let case = &value["case"];
    let numbers = |value: &Value| -> Vec<f64> {
        let number = |x: &Value| if x == "inf" { f64::INFINITY } else { x.as_f64().unwrap() };
        value.as_array().map(|list| list.iter().map(number).collect()).unwrap_or_default()
    };
    let list = |key: &str| numbers(&case[key]);
    let drive = |key: &str, kind| {
        let numbers = list(key);
        let &[site, amplitude, omega, phase] = numbers.first_chunk()?;
        let harmonics = vec![Harmonic { amplitude, omega, phase }];
        Some(Drive { site: site as usize, kind, signal: Signal::new(harmonics, Envelope::None) })
    };
    let strength = list("viscoelastic");
    let details = Details {
        mass: list("mass"),
        kappa: list("kappa"),
        rho: list("rho"),
        drag: list("drag"),
        dashpot: list("dashpot"),
        contact: list("contact"),
        alpha: list("alpha"),
        overlap: list("overlap"),
        dissipation: (!strength.is_empty()).then_some(Dissipation { kind: Kind::Viscoelastic, strength }),
        drives: [drive("moved", DriveKind::Displacement), drive("pushed", DriveKind::Force)]
            .into_iter()
            .flatten()
            .collect(),
        ..Details::default()
    };
    let n = details.mass.len();
    let chain = Chain::new(params(1.5, 1.0, 1.0), Boundary::Fixed, n).unwrap().with(&details).unwrap();
    let [u, v, u_dot, v_dot] = ["u", "v", "u_dot", "v_dot"].map(|key| numbers(&value["start"][key]));
    let site = |i: usize| Site { u: u[i], v: v[i], u_dot: u_dot[i], v_dot: v_dot[i] };
    let state = State::from_fn(&chain, site).unwrap().driven(&chain);
    let end: Vec<f64> = value["state"]
        .as_array()
        .unwrap()
        .iter()
        .map(|pair| {
            let part = |k: usize| pair[k].as_str().unwrap().parse::<f64>().unwrap();
            part(0) + part(1)
        })
        .collect();
    // A conservative chain keeps no ledger.
    let end = end[..state.as_slice().len()].to_vec();
    (chain, state, case["end"].as_f64().unwrap(), end)
}

#[test]
fn methods_reach_the_stored_states_of_another_program() {
    // Truth: `tests/reference/details.py` and `quad.c`, which share no code with this library, with
    // 34 and 33 digits: the motion, and what is dissipated and driven. Beads that differ; with
    // drag, dashpots, a bead that is moved and one that is pushed ("driven"), and contacts that
    // dissipate ("open", and "dissipating", whose ledger has entries of 70). Three have 200
    // contacts, which enlarge a change of a velocity up to 1000 times; the tolerance of DOP853 is
    // that of a step. Bounds of motion, ledger and balance: about twice what was measured.
    let tol = Setting::Tolerance;
    for (name, method, setting, bounds) in [
        ("conservative", "collocation", tol(1e-14), [2e-15, 0.0, 1e-14]),
        ("conservative", "dop853-regularised", tol(1e-14), [8e-14, 0.0, 1.0]),
        ("conservative", "dop853-landed", tol(1e-13), [5e-12, 0.0, 1.0]),
        ("conservative", "dop853", tol(1e-13), [1.1e-10, 0.0, 1.0]),
        ("conservative", "verlet", Setting::Steps(200_000), [3e-8, 0.0, 1.0]),
        ("conservative", "strang-linear", Setting::Steps(200_000), [3e-8, 0.0, 1.0]),
        ("open", "collocation", tol(1e-14), [2.4e-13; 3]),
        ("open", "dop853-regularised", tol(1e-14), [2.4e-13; 3]),
        ("open", "dop853-landed", tol(1e-13), [5e-12; 3]),
        ("open", "dop853", tol(1e-12), [1.3e-9; 3]),
        ("twelve", "collocation", tol(1e-14), [1.1e-12, 0.0, 1e-14]),
        ("twelve", "dop853-regularised", tol(1e-15), [1e-11, 0.0, 1.0]),
        ("driven", "collocation", tol(1e-14), [2e-12, 2e-12, 1.5e-13]),
        ("driven", "dop853-regularised", tol(1e-15), [1e-11, 1e-11, 1.0]),
        ("dissipating", "collocation", tol(1e-14), [4e-12, 1.1e-11, 1e-12]),
        ("dissipating", "dop853-regularised", tol(1e-15), [7e-11, 1.0, 1.0]),
    ] {
        let (chain, state, end, want) = stored(name);
        let run = Run::new(chain.clone(), state).until(end).unwrap().method(Method::named(method).unwrap());
        let got = run.setting(setting).contacts().start().unwrap().complete().unwrap();
        let split = 2 * chain.layout().half();
        let ledger = distance(&got.state[split..], &want[split..]);
        let off = [distance(&got.state[..split], &want[..split]), ledger, got.energy_error.unwrap()];
        let contacts = got.contacts.unwrap().len();
        println!("{name} {method}: {off:?}, {contacts} contacts");
        assert!(off.iter().zip(bounds).all(|(off, bound)| *off <= bound), "{name} {method}: {off:?}");
        assert!(contacts >= if ["conservative", "open"].contains(&name) { 5 } else { 200 }, "{name}: {contacts}");
        if let Some(ledger) = chain.layout().ledger(&want) {
            assert!([ledger.drag, ledger.dashpots, ledger.driven.abs()].iter().all(|part| *part > 0.01), "{name}");
            assert!(name == "driven" || ledger.contacts > 0.01, "{name}");
        }
    }
}

/// Beads that differ, with springs of all kinds, drag, dashpots and drives, so pressed that no
/// contact opens.
fn smooth() -> (Chain<f64>, State<f64>) {
    let details = Details {
        mass: vec![1.0, 0.5, 2.0, 1.5, 0.7, 1.0],
        rho: vec![0.0, 0.5, f64::INFINITY, 0.0, 2.0, 0.3],
        onsite: vec![0.0, 0.4, 0.2, 0.3, 0.0, 0.5],
        spring: vec![0.0, 0.3, 0.0, 0.2, 0.1, 0.0, 0.4],
        drag: vec![0.0, 0.1, 0.0, 0.05, 0.2, 0.0],
        dashpot: vec![0.0, 0.1, 0.2, 0.0, 0.0, 0.05],
        contact: vec![1.0, 2.0, 1.5, 1.0, 0.8, 1.2, 1.0],
        overlap: vec![1.0; 7],
        drives: vec![
            Drive { site: 0, kind: DriveKind::Displacement, signal: Signal::sine(0.1, 1.3, 3.0) },
            Drive { site: 3, kind: DriveKind::Force, signal: Signal::sine(0.2, 0.7, 0.0) },
        ],
        ..Details::default()
    };
    let chain = Chain::new(params(1.5, 1.0, 1.0), Boundary::Fixed, 6).unwrap().with(&details).unwrap();
    let site =
        |i: usize| Site { u: 0.05 * (i as f64).sin(), v: 0.1, u_dot: 0.1 * (2.0 * i as f64).cos(), v_dot: -0.05 };
    let state = State::from_fn(&chain, site).unwrap().driven(&chain);
    (chain, state)
}

#[test]
fn splittings_keep_their_order_with_damping_and_drives() {
    // Truth: DOP853 at a tolerance of 1e-13; the error divided by that of twice as many steps is
    // 2^p. States, what is dissipated and what is driven alike.
    let (chain, state) = smooth();
    let truth = run(&chain, &state, 12.0, "dop853", Setting::Tolerance(1e-14));
    let half = chain.layout().half();
    for (method, order, steps) in [
        ("verlet", 2, 400),
        ("strang-linear", 2, 400),
        ("yoshida4", 4, 400),
        ("yoshida4-linear", 4, 400),
        ("srkn14-6", 6, 60),
    ] {
        let errors = [steps, 2 * steps].map(|steps| {
            let end = run(&chain, &state, 12.0, method, Setting::Steps(steps));
            let (motion, ledger) = end.state.split_at(2 * half);
            [
                distance(motion, &truth.state[..2 * half]),
                distance(ledger, &truth.state[2 * half..]),
                end.energy_error.unwrap(),
            ]
        });
        for (k, (coarse, fine)) in errors[0].into_iter().zip(errors[1]).enumerate() {
            let slope = (coarse / fine).log2();
            println!("{method} {k}: {coarse:.1e} {fine:.1e} {slope:.3}");
            assert!((slope - f64::from(order)).abs() < 0.3, "{method} {k}: {slope}");
        }
    }
}

/// Methods that take contacts that dissipate.
const METHODS: [&str; 2] = ["dop853-regularised", "collocation"];

/// The coefficient of restitution of two beads that meet with a relative speed, by a method.
fn restitution(method: &str, alpha: f64, law: (Kind, f64), speed: f64, mass: [f64; 2]) -> (f64, Trajectory) {
    rebound(method, alpha, law, speed, mass, (0.0, false))
}

/// The same with `beta` of dashpots, and contacts that may pull.
fn rebound(
    method: &str,
    alpha: f64,
    (kind, gamma): (Kind, f64),
    speed: f64,
    mass: [f64; 2],
    (beta, pull): (f64, bool),
) -> (f64, Trajectory) {
    let details = Details {
        mass: mass.to_vec(),
        overlap: vec![-0.125],
        dissipation: Some(Dissipation { kind, strength: vec![gamma] }),
        beta,
        pull,
        ..Details::default()
    };
    let chain = Chain::new(params(alpha, 0.0, 0.0), Boundary::Free, 2).unwrap().with(&details).unwrap();
    let mut state = State::rest(&chain);
    state.u_dot_mut().copy_from_slice(&[speed, 0.0]);
    let run = Run::new(chain, state).until(60.0).unwrap().method(Method::named(method).unwrap());
    let end = run.tolerance(1e-13).unwrap().contacts().start().unwrap().complete().unwrap();
    ((end.state[3] - end.state[2]) / speed, end)
}

#[test]
fn viscoelastic_spheres_rebound_as_published() {
    // Truth: Ramirez, Poeschel, Brilliantov & Schwager 1999, Phys. Rev. E 60, 4465: e = 1 - C_1 x +
    // C_2 x^2 with x = 3/2 gamma k^{2/5} v^{1/5}, k = A/m_eff, C_2 = 3/5 C_1^2. What follows is of
    // the order x^{5/2} if the beads part where the force vanishes, and x^3 if they may pull and
    // part where the overlap is zero.
    let (c1, speed) = (1.153_448_858_095_288_4, 0.3_f64);
    let cases = [([1.0, 1.0], false, 2.2..2.8), ([2.0, 0.5], false, 2.2..2.8), ([2.0, 0.5], true, 2.97..3.03)];
    for (method, (mass, pull, slopes)) in
        METHODS.into_iter().flat_map(|method| cases.clone().map(|case| (method, case)))
    {
        let effective = mass[0] * mass[1] / (mass[0] + mass[1]);
        let rests = [0.04, 0.02, 0.01, 0.005].map(|gamma| {
            let x = 1.5 * gamma * (1.0f64 / effective).powf(0.4) * speed.powf(0.2);
            let (e, end) = rebound(method, 1.5, (Kind::Viscoelastic, gamma), speed, mass, (0.0, pull));
            let rest = e - (1.0 - c1 * x + 0.6 * c1 * c1 * x * x);
            assert!(rest.abs() < 0.5 * x.powf(2.5), "{gamma}: {rest:e}");
            // What the energy lacks was dissipated, and the impulse is the change of momentum.
            assert!(end.energy_error.unwrap() < 6e-12, "{:e}", end.energy_error.unwrap());
            let [contact] = end.contacts.as_deref().unwrap() else { panic!("{:?}", end.contacts) };
            let momentum = mass[1] * end.state[3];
            assert!((contact.impulse - momentum).abs() < 1e-10, "{} {momentum}", contact.impulse);
            rest
        });
        let slope = (rests[2] / rests[3]).log2();
        println!("{method} {mass:?} {pull}: {rests:?} {slope}");
        assert!(slopes.contains(&slope), "{method} {mass:?} {pull}: {slope}");
    }
}

#[test]
fn dashpots_rebound_as_a_damped_oscillator_at_every_exponent() {
    // Truth: with beta = (alpha - 1)/2 and s = g^{beta+1}/(beta+1) the motion v dv/dg = -(F + gamma
    // g^beta v)/m_eff is v dv/ds = -(gamma v + A (beta+1) s)/m_eff, a damped oscillator (Antypov &
    // Elliott 2011, EPL 94, 50004). With nu = gamma/(2 m_eff) and omega beads that may pull have e
    // = exp(-pi nu/omega), and others, at every speed, that of linear dashpots (Schwager & Poeschel
    // 2007, Granular Matter 9, 465): exp(-nu/omega (pi - arctan(2 nu omega/(omega^2 - nu^2)))).
    let mass = [2.0, 0.5];
    for (method, bounds) in METHODS.into_iter().zip([[2e-10; 2], [1e-15, 1e-13]]) {
        for (alpha, gamma) in [1.0f64, 1.5, 2.0, 3.0].into_iter().flat_map(|a| [0.05, 0.4].map(|gamma| (a, gamma))) {
            let (beta, nu, bound) = (0.5 * (alpha - 1.0), gamma / 0.8, bounds[usize::from(alpha > 1.0)]);
            let omega = ((beta + 1.0) / 0.4 - nu * nu).sqrt();
            for pull in [false, true] {
                let lasts = if pull { 0.0 } else { (2.0 * nu * omega / (omega * omega - nu * nu)).atan() };
                let want = (-nu / omega * (std::f64::consts::PI - lasts)).exp();
                for speed in [0.3, 2.0] {
                    let (e, end) = rebound(method, alpha, (Kind::Dashpot, gamma), speed, mass, (beta, pull));
                    let (off, balance) = (e - want, end.energy_error.unwrap());
                    let contact = end.contacts.unwrap()[0];
                    let early = contact.release.unwrap() - contact.force_end.unwrap();
                    assert!(
                        off.abs() < bound && balance < bound,
                        "{method} {alpha} {gamma} {pull}: {off:e} {balance:e}"
                    );
                    let late = if pull { early.abs() < 1e-9 } else { early > 1e-3 };
                    assert!(late, "{method} {alpha} {gamma} {pull}: {early:e}");
                    let impulse = mass[1] * end.state[3] - contact.impulse;
                    assert!(impulse.abs() < 10.0 * bounds[1], "{method} {alpha} {gamma} {pull}: {impulse:e}");
                }
            }
        }
    }
}

#[test]
fn beads_by_the_law_of_hunt_and_crossley_rebound_as_their_energy_says() {
    // Truth: with v = g' and f = F(g) (1 + gamma v), v dv/(1 + gamma v) = -F dg/m_eff on both ways,
    // so that H(v) = v/gamma - ln(1 + gamma v)/gamma^2 is the same at both ends of the contact, for
    // every exponent.
    for (method, bound) in METHODS.into_iter().zip([1e-11, 1e-14]) {
        for (alpha, gamma, speed) in [(1.5, 0.05, 1.0), (1.5, 1.5, 0.7), (2.0, 4.0, 1.0), (1.2, 0.6, 0.3)] {
            let h = |v: f64| v / gamma - (gamma * v).ln_1p() / (gamma * gamma);
            let (mut least, mut most) = (0.0, speed);
            for _ in 0..100 {
                let v = 0.5 * (least + most);
                if gamma * v < 1.0 && h(-v) < h(speed) { least = v } else { most = v }
            }
            let (e, end) = restitution(method, alpha, (Kind::HuntCrossley, gamma), speed, [2.0, 0.5]);
            let (off, balance) = (e - least / speed, end.energy_error.unwrap());
            assert!(off.abs() < bound && balance < bound, "{method} {alpha} {gamma}: {e} {off:e} {balance:e}");
        }
    }
}

#[test]
fn dashpots_of_a_power_of_the_rate_take_what_their_equation_says() {
    // Truth: of a bead on a wall with f = A g^alpha + gamma g^beta |g'| g', the equation of v^2 in
    // g is linear: with B = gamma g^(beta + 1)/(beta + 1) and I(+-) = 2 A int_0^g s^alpha
    // e^(+-2 B(s)) ds, v^2 e^(2 B) + I(+) is constant while it is pressed, v^2 e^(-2 B) + I(-)
    // after that. Integrals by Simpson's rule in s^(1/4).
    let (a, gamma, speed) = (1.3, 0.9, 0.7);
    for (beta, pull) in [(0.0, false), (0.25, false), (0.25, true), (1.0, true)] {
        let b = |g: f64| gamma * g.powf(beta + 1.0) / (beta + 1.0);
        let stored = |g: f64, sign: f64| {
            let (parts, root) = (8000, g.powf(0.25));
            let term = |k: i32| {
                let q = root * f64::from(k) / f64::from(parts);
                let weight = if k == 0 || k == parts { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
                weight * 4.0 * q.powi(9) * (sign * 2.0 * b(q.powi(4))).exp()
            };
            2.0 * a * root / f64::from(parts) / 3.0 * (0..=parts).map(term).sum::<f64>()
        };
        let zero = |f: &dyn Fn(f64) -> f64, mut low: f64, mut high: f64| {
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                *(if f(middle) > 0.0 { &mut high } else { &mut low }) = middle;
            }
            low
        };
        let deepest = zero(&|g| stored(g, 1.0) - speed * speed, 0.0, 2.0);
        let left = |g: f64| (stored(deepest, -1.0) - stored(g, -1.0)) * (2.0 * b(g)).exp();
        // The force ends where it would pull.
        let last = if pull { 0.0 } else { zero(&|g| a * g.powf(1.5 - beta) - gamma * left(g), 0.0, deepest) };
        let rebound = left(last).sqrt();
        let details = Details {
            contact: vec![a],
            dissipation: Some(Dissipation { kind: Kind::Dashpot, strength: vec![gamma] }),
            rate_power: Some(2.0),
            beta,
            pull,
            ..Details::default()
        };
        let chain = Chain::new(params(1.5, 0.0, 0.0), Boundary::RightWall, 1).unwrap().with(&details).unwrap();
        let why = Method::Collocation.unsupported_reason(&chain).unwrap();
        assert!(why.contains("take dop853-regularised"), "{why}");
        let mut state = State::rest(&chain);
        (state.u_mut()[0], state.u_dot_mut()[0]) = (-0.25, speed);
        // Events inside its steps cost the first one digits.
        for (method, within) in [("dop853", 1e-9), ("dop853-regularised", if pull { 2e-12 } else { 3e-13 })] {
            let got = run(&chain, &state, 30.0, method, Setting::Tolerance(1e-13)).state;
            assert!((-got[1] - rebound).abs() < within, "{beta} {pull} {method}: {} {rebound}", -got[1]);
            let ledger = chain.layout().ledger(&got).unwrap();
            let lost = 0.5 * (speed * speed - got[1] * got[1]);
            assert!(
                (ledger.contacts - lost).abs() < 1e-12 + 0.1 * within,
                "{beta} {pull} {method}: {} {lost}",
                ledger.contacts
            );
        }
    }
}

#[test]
fn a_damped_resonator_is_exact_at_any_step() {
    // Truth: closed form of a damped cradle bead, u = e^{-nu t} (cos w t + nu/w sin w t), and its
    // energy; one step of sixteen periods is as good as short ones.
    let apart = Details { drag: vec![0.02; 3], overlap: vec![-1.0; 2], ..Details::default() };
    let chain = Chain::new(params(1.5, 1.0, f64::INFINITY), Boundary::Free, 3).unwrap().with(&apart).unwrap();
    let mut state = State::rest(&chain);
    state.u_mut().copy_from_slice(&[-0.3, 0.0, 0.3]);
    let (nu, end) = (0.01f64, 100.0f64);
    let w = (1.0 - nu * nu).sqrt();
    let want = -0.3 * (-nu * end).exp() * ((w * end).cos() + nu / w * (w * end).sin());
    for steps in [1, 7, 1000] {
        for method in ["strang-linear", "yoshida4-linear"] {
            let got = run(&chain, &state, end, method, Setting::Steps(steps));
            // A rounding for each of at most four drifts a step; 2^8 in the matrix of the longest.
            let bound = 1.1e-16 * (256.0 + 4.0 * steps as f64);
            assert!((got.state[0] - want).abs() < bound, "{method} {steps}: {:e}", got.state[0] - want);
            let error = got.energy_error.unwrap();
            assert!(error < 2.0 * bound, "{method} {steps}: {error:e}");
        }
    }
}

#[test]
fn a_wall_of_its_own_and_an_impurity_keep_energy_and_momentum() {
    // Truth: invariants. A free chain keeps its momentum whatever the masses.
    let details = Details { mass: vec![1.0, 0.1, 3.0, 0.5], rho: vec![0.5, 0.0, 2.0, 1.0], ..Details::default() };
    let chain = Chain::new(params(1.5, 1.0, 1.0), Boundary::Free, 4).unwrap().with(&details).unwrap();
    let state = lively(&chain);
    let end = run(&chain, &state, 20.0, "dop853-regularised", Setting::Tolerance(1e-13));
    assert!(end.energy_error.unwrap() < 1e-11, "{:e}", end.energy_error.unwrap());
    let drift = chain.momentum(&end.state) - chain.momentum(state.as_slice());
    assert!(drift.abs() < 1e-12, "{drift:e}");
    let sum: f64 = chain.site_energies(&end.state).iter().sum();
    assert!((sum - end.energy.unwrap().total()).abs() < 1e-14);
    assert_eq!(chain.overlaps(&end.state)[0], f64::NEG_INFINITY);
}

#[test]
fn what_cannot_run_such_a_chain_names_one_that_can() {
    let details = Details { mass: vec![1.0, 2.0], ..Details::default() };
    let plain = Chain::<f64>::new(params(1.5, 1.0, 1.0), Boundary::Free, 2).unwrap();
    let chain = plain.clone().with(&details).unwrap();
    let start = |chain: &Chain<f64>, method: Method, setting| {
        let run = Run::new(chain.clone(), lively(chain)).until(1.0).unwrap();
        run.method(method).setting(setting).start().map(|_| ()).map_err(|error| error.to_string())
    };
    let lossy =
        Details { dissipation: Some(Dissipation { kind: Kind::Viscoelastic, strength: vec![0.1] }), ..details.clone() };
    let lossy = plain.clone().with(&lossy).unwrap();
    for method in Method::all() {
        let setting = if method.adaptive() { Setting::Tolerance(1e-8) } else { Setting::Steps(10) };
        for chain in [&chain, &lossy] {
            let outcome = start(chain, method, setting);
            assert_eq!(outcome.is_ok(), method.runs(chain).is_ok(), "{}", method.name());
            if let Err(message) = outcome {
                assert!(message.contains(&method.name()) && message.contains("take dop853-regularised"), "{message}");
            }
        }
    }
    let message = chain.collocation(lively(&chain).as_slice(), (0.0, 1.0), super::windows(4, 8)).err().unwrap();
    assert!(message.to_string().contains("equal beads"), "{message}");
    // What nobody names is a method that can.
    for chain in [&chain, &lossy] {
        let run = Run::new(chain.clone(), lively(chain)).until(1.0).unwrap();
        assert!(run.start().unwrap().failure.is_none());
        assert!(run.clone().tolerance(1e-9).unwrap().start().unwrap().failure.is_none());
    }
    let run = Run::new(chain.clone(), lively(&chain)).until(1.0).unwrap();
    assert!(run.step(0.01).unwrap().start().unwrap().failure.is_none());
}

#[test]
fn strains_at_rest_have_no_sign() {
    let chain = Chain::<f64>::new(params(1.5, 1.0, 1.0), Boundary::Free, 3).unwrap();
    let differing = chain.clone().with(&Details { contact: vec![1.0, 2.0], ..Details::default() }).unwrap();
    for chain in [chain, differing] {
        let strains = chain.strains(State::rest(&chain).as_slice());
        assert!(strains.len() == 2 && strains.iter().all(|x| x.to_bits() == 0), "{strains:?}");
    }
}

#[test]
fn wrong_details_are_refused_by_name_and_rule() {
    let chain = |boundary| Chain::<f64>::new(params(1.5, 1.0, 1.0), boundary, 3).unwrap();
    let none = Details::default;
    let drive = |site, kind, signal| Details { drives: vec![Drive { site, kind, signal }], ..none() };
    let loose = Details { kappa: vec![0.0; 3], dashpot: vec![0.1; 3], ..none() };
    let dissipation = Some(Dissipation { kind: Kind::Viscoelastic, strength: vec![0.1; 2] });
    let viscous = Details { dissipation, rate_power: Some(2.0), ..none() };
    let drives = [DriveKind::Displacement, DriveKind::Force];
    let drives = drives.map(|kind| Drive { site: 0, kind, signal: Signal::sine(1.0, 1.0, 0.0) }).to_vec();
    let pushed = Details { drives, rho: vec![0.0, 1.0, 1.0], ..none() };
    let cases: Vec<(Details, &str, &str)> = vec![
        (Details { mass: vec![1.0, 2.0], ..none() }, "mass = 2 numbers for 3 sites", "one number for each site"),
        (Details { rho: vec![1.0, f64::NAN, 1.0], ..none() }, "rho = NaN (entry 1)", "[0, inf]"),
        (Details { contact: vec![1.0; 3], ..none() }, "contact = 3 numbers for 2 bonds", "one number"),
        (Details { contact: vec![1.0, -1.0], ..none() }, "contact = -1", "from 0 to 1e200"),
        (loose, "dashpot = 0.1 at site 0", "beside a spring"),
        (viscous, "rate_power = 2", "of a dashpot"),
        (drive(0, DriveKind::Displacement, Signal::sine(1.0, 1.0, 0.0)), "drive = moves site 0", "no resonator"),
        // What moves a bead takes up what pushes it.
        (pushed, "drive.site = 0", "is not pushed"),
        (drive(0, DriveKind::Force, Signal::sine(1.0, 1.0, f64::INFINITY)), "drive.ramp = inf", "finite and positive"),
    ];
    for (details, value, rule) in cases {
        let message = chain(Boundary::Free).with(&details).unwrap_err().to_string();
        assert!(message.contains(value) && message.contains(rule), "{message}");
    }
    let message = chain(Boundary::StrainRing).with(&none()).unwrap_err().to_string();
    assert!(message.contains("strain-ring"), "{message}");
    // A bead that is moved begins where its drive does.
    let moved = Details { rho: vec![0.0, 1.0, 1.0], ..drive(0, DriveKind::Displacement, Signal::sine(0.1, 1.0, 0.0)) };
    let chain = chain(Boundary::Free).with(&moved).unwrap();
    let run = Run::new(chain.clone(), State::rest(&chain)).until(1.0).unwrap();
    assert!(run.start().unwrap_err().to_string().contains("begins where its drive does"));
    let run = Run::new(chain.clone(), State::rest(&chain).driven(&chain)).until(1.0).unwrap();
    assert!(run.start().unwrap().failure.is_none());
}
