//! Springs of beads beside those of resonators: on-site, and between beads; magnets.

use crate::{
    details::{methods_agree, refuses, run},
    numbers::{direction, distance, error, random},
    terms::summed,
    variations::{altered, applied, chain, difference, free, monodromy, start},
};
use hertzchain::{
    chain::{Boundary, Chain, Details, Params, Site, State, Variations},
    integrators::Real,
    orbits::{Bands, NormalModes},
    run::{Method, Run, Setting},
    scene::Scene,
};
use nalgebra::{DMatrix, DVector};

/// The chain of the tangent maps with on-site springs, beside resonators of all kinds, and with
/// springs between beads; its first bead, which a drive moves, has none.
fn springs<R: Real>() -> Chain<R> {
    altered(&chain(), |details| {
        details.onsite = vec![0.0, 0.4, 0.2, 0.3, 0.6, 0.5];
        details.spring = vec![0.0, 0.3, 0.0, 0.2, 0.5, 0.0, 0.4];
    })
}

/// The same with magnets, too.
fn magnets() -> Chain<f64> {
    altered(&springs(), |details| {
        details.magnet = vec![0.3, 0.0, 0.2, 0.5, 0.1, 0.4, 0.3];
        (details.distance, details.decay) = (vec![1.2, 1.0, 0.9, 1.5, 1.3, 1.1, 1.0], 3.7);
    })
}

fn bare(boundary: Boundary, sites: usize, details: &Details) -> Chain<f64> {
    Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), boundary, sites).unwrap().with(details).unwrap()
}

/// Positions and velocities of `m q'' = -K q` at a time, beads before resonators.
fn oscillated(mass: &[f64], k: &DMatrix<f64>, [q, q_dot]: [&[f64]; 2], t: f64) -> Vec<f64> {
    let n = mass.len();
    let root: Vec<f64> = mass.iter().map(|m| m.sqrt()).collect();
    let eigen = DMatrix::from_fn(n, n, |i, j| k[(i, j)] / (root[i] * root[j])).symmetric_eigen();
    let part = |of: &[f64]| eigen.eigenvectors.transpose() * DVector::from_fn(n, |i, _| root[i] * of[i]);
    let (a, b, omega) = (part(q), part(q_dot), eigen.eigenvalues.map(f64::sqrt));
    let moved = [
        DVector::from_fn(n, |j, _| a[j] * (omega[j] * t).cos() + b[j] * (omega[j] * t).sin() / omega[j]),
        DVector::from_fn(n, |j, _| b[j] * (omega[j] * t).cos() - a[j] * (omega[j] * t).sin() * omega[j]),
    ];
    moved
        .iter()
        .flat_map(|y| (&eigen.eigenvectors * y).iter().zip(&root).map(|(y, r)| y / r).collect::<Vec<_>>())
        .collect()
}

#[test]
fn linear_chains_are_their_closed_form() {
    // Truth: eigenvectors of the stiffness. Two beads that never touch, each with an on-site spring
    // and a resonator; the same joined by a spring and to walls.
    let (mass, kappa, rho, onsite) = ([1.7, 0.8], [2.3, 1.1], [0.4, 3.0], [0.9, 0.2]);
    let all = [mass[0], mass[1], rho[0] * mass[0], rho[1] * mass[1]];
    let [q, q_dot] = [[0.3, -0.2, 0.1, 0.05], [0.4, -0.7, 0.2, -0.1]];
    for spring in [0.0, 0.6] {
        let details = Details {
            mass: mass.to_vec(),
            kappa: kappa.to_vec(),
            rho: rho.to_vec(),
            onsite: onsite.to_vec(),
            spring: vec![0.5 * spring, spring, 2.0 * spring],
            overlap: vec![-9.0; 3],
            ..Details::default()
        };
        let chain = bare(Boundary::Fixed, 2, &details);
        let mut k = DMatrix::zeros(4, 4);
        for i in 0..2 {
            k[(i, i)] = kappa[i] + onsite[i] + [1.5, 3.0][i] * spring;
            (k[(i, i + 2)], k[(i + 2, i)], k[(i + 2, i + 2)]) = (-kappa[i], -kappa[i], kappa[i]);
        }
        (k[(0, 1)], k[(1, 0)]) = (-spring, -spring);
        let state = State::from_fn(&chain, |i| Site { u: q[i], v: q[i + 2], u_dot: q_dot[i], v_dot: q_dot[i + 2] });
        let state = state.unwrap();
        let want = oscillated(&all, &k, [&q, &q_dot], 30.0);
        let energy = 0.5
            * ((0..4).map(|i| all[i] * q_dot[i] * q_dot[i]).sum::<f64>() + {
                let q = DVector::from_column_slice(&q);
                q.dot(&(&k * &q))
            });
        assert!((chain.energy(state.as_slice()).total() - energy).abs() < 1e-15);
        assert!((chain.site_energies(state.as_slice()).iter().sum::<f64>() - energy).abs() < 1e-15);
        // Without springs between beads one step of the linear split is the whole motion.
        let steps = if spring == 0.0 { [1, 7] } else { [40_000; 2] };
        for (method, setting, bound) in [
            ("dop853-regularised", Setting::Tolerance(1e-14), 3e-12),
            ("dop853", Setting::Tolerance(1e-14), 3e-12),
            ("strang-linear", Setting::Steps(steps[0]), if spring == 0.0 { 1e-13 } else { 1e-6 }),
            ("srkn14-6", Setting::Steps(40_000), 1e-11),
        ] {
            let end = run(&chain, &state, 30.0, method, setting);
            let (off, balance) = (distance(&end.state, &want), end.energy_error.unwrap());
            println!("{spring} {method}: {off:e}, energy {balance:e}");
            assert!(off < bound && balance < bound, "{spring} {method}: {off:e} {balance:e}");
        }
        let squares: Vec<f64> =
            NormalModes::new(&chain).unwrap().linear().iter().map(|mode| mode.omega.powi(2)).collect();
        let mut truth: Vec<f64> = DMatrix::from_fn(4, 4, |i, j| k[(i, j)] / (all[i] * all[j]).sqrt())
            .symmetric_eigenvalues()
            .as_slice()
            .to_vec();
        truth.sort_by(f64::total_cmp);
        assert!(distance(&squares, &truth) < 1e-13, "{squares:?} {truth:?}");
    }
}

#[test]
fn an_on_site_spring_where_no_resonator_moves_is_one_to_a_resonator_at_rest() {
    // Truth: the same scene by `kappa` and `rho`, to the bit.
    let (mass, alpha) = (vec![1.0, 2.0, 0.5, 1.0], vec![1.5; 3]);
    let given = Details { mass, alpha, onsite: vec![0.7, 0.0, 1.3, 0.4], ..Details::default() };
    let kappa = given.onsite.clone();
    let by_kappa = Details { onsite: Vec::new(), rho: vec![f64::INFINITY; 4], kappa, ..given.clone() };
    let [a, b] = [&given, &by_kappa].map(|details| bare(Boundary::Free, 4, details));
    for (method, setting) in [
        ("collocation", Setting::Tolerance(1e-12)),
        ("dop853-regularised", Setting::Tolerance(1e-12)),
        ("strang-linear", Setting::Steps(300)),
        ("verlet", Setting::Steps(300)),
    ] {
        let [a, b] = [&a, &b].map(|chain| {
            let site = |i: usize| Site { u: 0.1 * i as f64, v: 0.0, u_dot: (2.0 * i as f64).cos(), v_dot: 0.0 };
            run(chain, &State::from_fn(chain, site).unwrap(), 20.0, method, setting).state
        });
        assert_eq!(a, b, "{method}");
    }
}

#[test]
fn methods_agree_where_springs_are_beside_contacts() {
    // Truth: each other.
    let by_chance = |seed: u64| {
        let mut next = random(seed);
        let mut list = |count: usize| (0..count).map(|_| (1.5 * next() - 0.3).max(0.0)).collect::<Vec<f64>>();
        altered(&chain(), |details| {
            (details.onsite, details.spring) = (list(6), list(7));
            details.onsite[0] = 0.0;
        })
    };
    let rows = [
        ("dop853-landed", Setting::Tolerance(1e-13), 1e-10),
        ("strang-linear", Setting::Steps(100_000), 1e-7),
        ("verlet", Setting::Steps(100_000), 1e-7),
    ];
    let chains = [springs::<f64>(), magnets()].into_iter().chain((0..8).map(by_chance));
    chains.enumerate().for_each(|(k, chain)| methods_agree(&format!("springs {k}"), &chain, 1e-14, &rows));
}

// Truth: beads without a contact never touch; the energy that a struck bead brings in is 1/2.
#[test]
fn magnets_alone_make_no_contacts_and_their_energy_at_rest_is_no_unit() {
    let text = "chain = { sites = 6, alpha = 1.5, boundary = 'ring' }\n\
                bonds = { contact = 0.0, magnet = 1e6, distance = 100.0, decay = 2.0 }\n\
                initial = { kind = 'single-bead', site = 2, velocity = 1.0 }\nspan = { until = 2.0 }\n";
    let run = Scene::parse(text, "magnets").unwrap().run().contacts();
    let run = run.method(Method::named("verlet").unwrap()).setting(Setting::Steps(400));
    let mut largest = 0.0_f64;
    let mut seen = |_, y: &[f64]| largest = largest.max((run.chain().energy(y).total() - 6e8 - 0.5).abs() / 0.5);
    let outcome = run.observe(&mut seen, &mut |_| ()).unwrap();
    assert_eq!(outcome.contacts.unwrap(), []);
    let error = outcome.energy_error.unwrap();
    assert!((error / largest - 1.0).abs() < 1e-3 && error > 1e-7, "{error:e} {largest:e}");
}

#[test]
fn magnets_repel_along_their_closed_form() {
    // Truth: for p = 3 the distance y of two beads of the reduced mass m has y'' = k/y^3, k = F
    // d^3/m, so that y^2 = k/(2 E) + 2 E (t - t_0)^2 with E = (y'^2 + k/y^2)/2.
    let details = Details {
        mass: vec![2.0, 0.5],
        contact: vec![0.0],
        magnet: vec![0.7],
        distance: vec![3.0],
        decay: 3.0,
        ..Details::default()
    };
    let chain = bare(Boundary::Free, 2, &details);
    let state = State::from_fn(&chain, |i| Site { u: [-2.0, 0.0][i], v: 0.0, u_dot: [1.5, 0.0][i], v_dot: 0.0 });
    let state = state.unwrap();
    let k: f64 = 0.7 * 27.0 / 0.4;
    let energy = 0.5 * (1.5 * 1.5 + k / 25.0);
    let (t, since) = (9.0, 9.0 - 5.0 * 1.5 / (2.0 * energy));
    let y = (k / (2.0 * energy) + 2.0 * energy * since * since).sqrt();
    let (middle, rate) = (-1.6 + 1.2 * t, 2.0 * energy * since / y);
    let want = [middle + 0.2 * (3.0 - y), middle - 0.8 * (3.0 - y), 1.2 - 0.2 * rate, 1.2 + 0.8 * rate];
    let mut met = state.clone();
    met.u_mut()[0] = 3.5;
    let said = Run::new(chain.clone(), met).until(1.0).unwrap().start().err().unwrap().to_string();
    assert!(said.contains("x = 3.5e0 at bond") && said.contains("distance"), "{said}");
    for (method, setting, bound) in [
        ("dop853-regularised", Setting::Tolerance(1e-14), 1e-12),
        ("dop853", Setting::Tolerance(1e-14), 1e-12),
        ("srkn14-6", Setting::Steps(3000), 1e-12),
        ("strang-linear", Setting::Steps(30_000), 1e-6),
    ] {
        let end = run(&chain, &state, t, method, setting);
        let (off, balance) = (distance(&end.state[..4], &want), end.energy_error.unwrap());
        println!("{method}: {off:e}, energy {balance:e}");
        assert!(off < bound && balance < bound, "{method}: {off:e} {balance:e}");
    }
}

#[test]
fn the_tangent_map_agrees_with_differences_in_double_double() {
    // Truth: as in `variations.rs`.
    let (t, w) = (9.0, direction(free(&springs()).len(), 0));
    for (what, chain, finer) in [("springs", springs(), springs()), ("powers", summed(), summed())] {
        let truth = difference(&finer, &w, t, (1e-9, 1e-23));
        let off = error(&applied(&monodromy(&chain, &start(&chain), t, 1e-12), &w), &truth);
        println!("{what}: {off:e}");
        assert!(off < 1e-9, "{what}: {off:e}");
    }
    // With magnets by differences in double.
    let (chain, rows) = (magnets(), free(&springs()));
    let end = |sign: f64| {
        let mut y = start(&chain);
        rows.iter().zip(&w).for_each(|(&i, w)| y[i] += sign * 1e-5 * w);
        Variations::flow(&chain, &y, (0.0, t), &[], 1e-13).unwrap().state
    };
    let (plus, minus) = (end(1.0), end(-1.0));
    let truth: Vec<f64> = rows.iter().map(|&i| (plus[i] - minus[i]) / 2e-5).collect();
    let off = error(&applied(&monodromy(&chain, &start(&chain), t, 1e-12), &w), &truth);
    println!("magnets: {off:e}");
    assert!(off < 1e-7, "{off:e}");
}

#[test]
fn bars_have_their_published_modes_and_bands() {
    // Truth: omega_j = 2 (K/m)^(1/2) sin(j pi/(2 (n + 1))) between walls; on a ring of beads with
    // on-site springs k, contacts of stiffness a and magnets beside, omega^2 = k + 4 (K + a + p
    // F/d) sin(theta/2)^2.
    let n = 7;
    let details = Details { contact: vec![0.0; n + 1], spring: vec![1.7; n + 1], ..Details::default() };
    for (j, mode) in NormalModes::new(&bare(Boundary::Fixed, n, &details)).unwrap().linear().iter().enumerate() {
        let angle = std::f64::consts::PI * (j + 1) as f64 / (2 * (n + 1)) as f64;
        let want = 2.0 * 1.7f64.sqrt() * angle.sin();
        assert!((mode.omega - want).abs() < 1e-14, "{j}: {} {want}", mode.omega);
    }
    let details = Details {
        onsite: vec![0.3; n],
        spring: vec![0.8; n],
        overlap: vec![0.25; n],
        magnet: vec![0.6; n],
        distance: vec![1.5; n],
        decay: 2.5,
        ..Details::default()
    };
    let bands = Bands::new(&bare(Boundary::Ring, n, &details)).unwrap();
    for theta in [0.0, 0.4, 1.9, 3.0f64] {
        let want = (0.3 + 4.0 * (0.8 + 1.5 * 0.5 + 2.5 * 0.6 / 1.5) * (0.5 * theta).sin().powi(2)).sqrt();
        assert!((bands.at(theta)[0] - want).abs() < 1e-13, "{theta}: {:?} {want}", bands.at(theta));
    }
}

#[test]
fn what_cannot_follow_springs_names_what_can() {
    let on_site = Details { kappa: vec![1.0; 2], rho: vec![1.0; 2], onsite: vec![0.5; 2], ..Details::default() };
    for (details, words) in [
        (on_site, "one frequency"),
        (Details { spring: vec![0.5], ..Details::default() }, "springs or magnets join beads"),
    ] {
        let chain = bare(Boundary::Free, 2, &details);
        let mut state = State::rest(&chain);
        state.u_dot_mut()[0] = 1.0;
        let said = Method::Collocation.runs(&chain).unwrap_err().to_string();
        assert!(said.contains(words) && said.contains("take dop853-regularised"), "{said}");
        assert!(chain.monodromy(state.as_slice(), (0.0, 1.0), crate::windows(4, 8)).is_err());
        let run = Run::new(chain.clone(), state).until(2.0).unwrap();
        for run in [run.clone(), run.clone().tolerance(1e-9).unwrap()] {
            assert_eq!(run.choice().unwrap().0.name(), "dop853-regularised");
            let off = run.start().unwrap().complete().unwrap().energy_error.unwrap();
            assert!(off < 1e-7, "{words}: {off:e}");
        }
        let said = chain.equilibrium().unwrap_err().to_string();
        assert!(said.contains("springs"), "{said}");
    }
}

#[test]
fn scenes_have_springs_and_their_equilibrium() {
    // Truth: a bar that hangs from a wall, u_n = (m g/K) sum_j (N - j), and its bead at the end
    // tied to its place.
    let text = "[chain]\nsites = 3\nalpha = 1.5\nboundary = \"left-wall\"\ngravity = 0.2\n\
                [bonds]\ncontact = 0.0\nspring = 2.0\n\
                [initial]\nkind = \"equilibrium\"\n[span]\nuntil = 5.0\n";
    let scene = Scene::parse(text, "bar").unwrap();
    let state = scene.initial().as_slice();
    assert!(distance(&state[..3], &[0.3, 0.5, 0.6]) < 1e-13, "{state:?}");
    let tied = text.replace("[bonds]", "[beads]\nonsite = [0.0, 0.0, 1.0]\n[bonds]");
    let scene = Scene::parse(&tied, "bar").unwrap();
    let state = scene.initial().as_slice();
    // K (u_3 - u_2) + k u_3 = m g, and so on.
    let k = DMatrix::from_row_slice(3, 3, &[4.0, -2.0, 0.0, -2.0, 4.0, -2.0, 0.0, -2.0, 3.0]);
    let want = k.lu().solve(&DVector::from_element(3, 0.2)).unwrap();
    assert!(distance(&state[..3], want.as_slice()) < 1e-13, "{state:?}");
    let cases = [
        ("spring = 2.0", "spring = -2.0", "bonds.spring = -2"),
        ("[bonds]", "[beads]\nonsite = -1.0\n[bonds]", "beads.onsite = -1"),
        ("spring = 2.0", "beta = 0.5", "bonds.beta = 0.5"),
        ("spring = 2.0", "pull = true", "bonds.pull = true"),
        ("contact = 0.0", "dashpot = 0.1\nbeta = 0.75", "bonds.beta = 0.75"),
        ("spring = 2.0", "magnet = 0.1", "bonds.distance is missing"),
        ("spring = 2.0", "magnet = 0.1\ndistance = 2.0", "bonds.decay = 0"),
        ("spring = 2.0", "magnet = -0.1\ndistance = 2.0\ndecay = 3.0", "bonds.magnet = -0.1"),
        ("spring = 2.0", "distance = 2.0", "bonds.magnet is missing"),
    ];
    refuses(text, &cases);
    let pulls = text.replace("contact = 0.0", "dashpot = 0.1\nbeta = 0.75\npull = true");
    assert!(Scene::parse(&pulls, "bar").is_ok());
}
