//! The tangent map of chains whose beads differ, are damped and driven.

use hertzchain::chain::{
    Boundary, Chain, Details, Dissipation, Drive, Envelope, Harmonic, Kind, Means, Params, Signal, Site, State,
    Variations,
};
use hertzchain::integrators::{Real, collocation::Pace};
use hertzchain::run::Run;
use nalgebra::DMatrix;
use twofloat::TwoFloat;

/// Six beads between walls that differ in everything, with drag, dashpots, a bead that is moved and
/// one that is pushed; contacts open and close.
fn chain<R: Real>() -> Chain<R> {
    let drive = |site, means, amplitude, omega| {
        let harmonics = vec![Harmonic { amplitude, omega, phase: 0.4 }];
        Drive { site, means, signal: Signal { harmonics, envelope: Envelope::None } }
    };
    let details = Details {
        mass: vec![1.0, 0.5, 2.0, 1.5, 0.7, 1.0],
        kappa: vec![1.0, 1.2, 0.8, 1.0, 1.5, 1.0],
        rho: vec![0.0, 0.5, f64::INFINITY, 0.0, 2.0, 0.3],
        drag: vec![0.0, 0.1, 0.0, 0.05, 0.2, 0.02],
        dashpot: vec![0.0, 0.1, 0.2, 0.0, 0.0, 0.05],
        contact: vec![1.0, 2.0, 1.5, 1.0, 0.8, 1.2, 1.0],
        alpha: vec![1.5, 1.5, 1.5, 2.5, 1.5, 1.5, 1.5],
        overlap: vec![0.1, 0.05, -0.02, 0.1, 0.0, 0.1, 0.05],
        drives: vec![drive(0, Means::Moved, 0.3, 1.3), drive(3, Means::Pushed, 0.4, 0.7)],
        ..Details::default()
    };
    Chain::new(Params::new(1.5, 1.0, 1.0).unwrap(), Boundary::Fixed, 6).unwrap().with(&details).unwrap()
}

fn start<R: Real>(chain: &Chain<R>) -> Vec<R> {
    let of = |x: f64| R::of(x);
    let site = |i: usize| {
        let x = i as f64;
        let (u, v) = (0.2 * (1.7 * x).sin(), 0.1 * (2.3 * x).cos());
        Site { u: of(u), v: of(v), u_dot: of(0.5 * (3.1 * x).sin()), v_dot: of(0.2 * (0.7 * x).cos()) }
    };
    State::from_fn(chain, site).unwrap().driven(chain).as_slice().to_vec()
}

/// The same with contacts that dissipate, all but one.
fn lossy<R: Real>(kind: Kind) -> Chain<R> {
    let strength = vec![0.1, 0.3, 0.05, 0.2, 0.0, 0.4, 0.15];
    let details = chain::<R>().details().unwrap().clone();
    let details = Details { dissipation: Some(Dissipation { kind, strength }), ..details };
    Chain::new(Params::new(1.5, 1.0, 1.0).unwrap(), Boundary::Fixed, 6).unwrap().with(&details).unwrap()
}

/// Entries of a state that are free: positions, then velocities.
fn free(chain: &Chain<f64>) -> Vec<usize> {
    let (n, half) = (chain.sites(), chain.layout().half());
    let q: Vec<usize> = (1..n).chain((0..n).filter(|&i| chain.resonator_moves(i)).map(|i| n + i)).collect();
    q.iter().copied().chain(q.iter().map(|i| half + i)).collect()
}

/// The derivative by the free entries of the state, by rows.
fn monodromy(chain: &Chain<f64>, y: &[f64], t: f64, tol: f64) -> DMatrix<f64> {
    let (free, rows) = (free(chain), 2 * chain.layout().half());
    let mut columns = vec![0.0; rows * free.len()];
    for (j, &i) in free.iter().enumerate() {
        columns[i * free.len() + j] = 1.0;
    }
    let end = Variations::flow(chain, y, (0.0, t), &columns, tol).unwrap().columns;
    DMatrix::from_fn(free.len(), free.len(), |i, j| end[free[i] * free.len() + j])
}

/// The same by contact collocation, in so many windows.
fn collocated(chain: &Chain<f64>, y: &[f64], t: f64, windows: u64) -> DMatrix<f64> {
    let (free, dim) = (free(chain), y.len());
    let columns = chain.monodromy(y, (0.0, t), crate::windows(windows, 12)).unwrap();
    DMatrix::from_fn(free.len(), free.len(), |i, j| columns[free[j] * dim + free[i]])
}

fn direction(dim: usize, k: usize) -> Vec<f64> {
    (0..dim).map(|i| ((2.399_963 + 0.618 * k as f64) * i as f64 + 1.0).sin()).collect()
}

/// `dy(t)/dy(0) w` by central differences of this step in 32 digits, from runs under a tolerance.
fn difference(chain: &Chain<TwoFloat>, w: &[f64], t: f64, (size, tol): (f64, f64)) -> Vec<f64> {
    let entries = free(&self::chain::<f64>());
    let end = |sign: f64| {
        let mut y = start(chain);
        for (&i, w) in entries.iter().zip(w) {
            y[i] += <TwoFloat as Real>::of(sign * size) * <TwoFloat as Real>::of(*w);
        }
        Variations::flow(chain, &y, (Real::of(0.0), Real::of(t)), &[], Real::of(tol)).unwrap().state
    };
    let (plus, minus) = (end(1.0), end(-1.0));
    entries.iter().map(|&i| Real::f64(plus[i] - minus[i]) / (2.0 * size)).collect()
}

fn error(a: &[f64], b: &[f64]) -> f64 {
    let size = b.iter().fold(0.0, |size: f64, b| size.max(b.abs()));
    a.iter().zip(b).fold(0.0, |largest: f64, (a, b)| largest.max((a - b).abs())) / size
}

fn applied(m: &DMatrix<f64>, w: &[f64]) -> Vec<f64> {
    (m * DMatrix::from_column_slice(w.len(), 1, w)).as_slice().to_vec()
}

#[test]
fn it_agrees_with_differences_in_double_double_and_follows_its_tolerance() {
    // Truth: central differences of runs in 32 digits, whose error is of the order of the square of
    // their step, 1e-9 (and of its 3/2 power at contacts that begin within it). Asked: 1e-9.
    let (chain, t) = (chain::<f64>(), 9.0);
    let w = direction(free(&chain).len(), 0);
    let truth = difference(&self::chain(), &w, t, (1e-9, 1e-23));
    let errors =
        [1e-6, 1e-8, 1e-10, 1e-12].map(|tol| error(&applied(&monodromy(&chain, &start(&chain), t, tol), &w), &truth));
    println!("{errors:?}");
    assert!(errors[3] < 1e-9, "{:e}", errors[3]);
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.1 * pair[0], "{errors:?}");
    }
}

#[test]
fn that_of_collocation_agrees_with_both() {
    // Truth: the same differences, and the matrix by DOP853.
    let (chain, t) = (chain::<f64>(), 9.0);
    let (y, w) = (start(&chain), direction(free(&chain).len(), 0));
    let got = collocated(&chain, &y, t, 720);
    let off = error(&applied(&got, &w), &difference(&self::chain(), &w, t, (1e-9, 1e-23)));
    println!("differences {off:e}");
    // Measured: 1.2e-14.
    assert!(off < 3e-14, "{off:e}");
    for tol in [1e-12, 1e-13, 1e-14, 1e-15] {
        let other = monodromy(&chain, &y, t, tol);
        let apart = (&got - &other).amax() / other.amax();
        println!("DOP853 {tol:e}: {apart:e}");
        // Measured: 5.8e-12, 7.6e-13, 1.2e-13 and 2.5e-14. With the stiffness of an overlap that is
        // a rounding after a release: up to 2.5e-11 with each of them.
        assert!(apart < 15.0 * tol + 5e-14, "{tol:e}: {apart:e}");
    }
}

#[test]
fn its_determinant_is_liouvilles() {
    // Truth: det = exp(t div), and the divergence is minus the sum of drag and dashpots over
    // masses.
    let (chain, t) = (chain::<f64>(), 9.0);
    let beads = 0.2 / 0.5 + 0.2 / 2.0 + 0.05 / 1.5 + 0.2 / 0.7 + 0.07;
    let resonators = 0.1 / (0.5 * 0.5) + 0.05 / 0.3;
    let y = start(&chain);
    // Measured: 1.6e-11, and 1.5e-13: a rounding in each of 720 windows.
    for (m, bound) in [(monodromy(&chain, &y, t, 1e-12), 4e-11), (collocated(&chain, &y, t, 720), 3e-13)] {
        let off = m.determinant().ln() + t * (beads + resonators);
        println!("{off:e}");
        assert!(off.abs() < bound, "{off:e}");
    }
}

#[test]
fn on_a_uniform_chain_it_is_that_of_collocation() {
    // Truth: the tangent map of contact collocation, on chains that open and close. Between walls,
    // without resonators, a contact of this start all but grazes; collocation itself then changes
    // by 1e-8 with its windows.
    for (rho, boundary) in [(1.0 / 3.0, Boundary::Free), (2.0, Boundary::Ring)] {
        let chain = Chain::<f64>::new(Params::new(1.5, 1.0, rho).unwrap(), boundary, 8).unwrap();
        let y = start(&chain);
        let (dim, t) = (y.len(), 7.0);
        let pace = Pace::Windows { windows: 200, nodes: 12, neighbours: true };
        let want = DMatrix::from_vec(dim, dim, chain.monodromy(&y, (0.0, t), pace).unwrap());
        let identity: Vec<f64> = DMatrix::<f64>::identity(dim, dim).as_slice().to_vec();
        let end = Variations::flow(&chain, &y, (0.0, t), &identity, 1e-13).unwrap();
        let got = DMatrix::from_row_slice(dim, dim, &end.columns);
        let off = (&got - &want).amax() / want.amax();
        println!("{rho} {boundary:?}: {off:e}");
        assert!(off < 1e-11, "{rho} {boundary:?}: {off:e}");
    }
}

#[test]
fn with_contacts_that_dissipate_it_agrees_with_differences_in_double_double() {
    // Truth: the same differences, with a longer step and a looser tolerance: the resistance of
    // viscoelastic contacts is computed by a division, which has 17 digits in double-double. Errors
    // of differences are of the order 1e-12 by the step, 1e-11 by the division. Asked: 1e-9.
    for kind in [Kind::Viscoelastic, Kind::Dashpot] {
        let (chain, t) = (lossy::<f64>(kind), 9.0);
        let w = direction(free(&chain).len(), 0);
        let truth = difference(&lossy(kind), &w, t, (1e-6, 1e-18));
        let errors = [1e-6, 1e-8, 1e-10, 1e-12, 1e-14]
            .map(|tol| error(&applied(&monodromy(&chain, &start(&chain), t, tol), &w), &truth));
        println!("{kind:?} {errors:?}");
        assert!(errors[3] < 1e-9, "{:e}", errors[3]);
        for pair in errors[..4].windows(2) {
            assert!(pair[1] < 0.1 * pair[0], "{errors:?}");
        }
    }
}

#[test]
fn with_contacts_that_dissipate_its_determinant_is_liouvilles() {
    // Truth: det = exp(int div dt). That of drag and dashpots of resonators is constant, see above;
    // that of contacts is an integral along the run, here also by the trapezoidal rule over states
    // of contact collocation.
    let resonators = 0.2 / 0.5 + 0.2 / 2.0 + 0.05 / 1.5 + 0.2 / 0.7 + 0.07 + 0.1 / (0.5 * 0.5) + 0.05 / 0.3;
    for kind in [Kind::Viscoelastic, Kind::Dashpot] {
        let (chain, t) = (lossy::<f64>(kind), 9.0);
        let y = start(&chain);
        let contraction = Variations::flow(&chain, &y, (0.0, t), &[], 1e-12).unwrap().contraction;
        let off = monodromy(&chain, &y, t, 1e-12).determinant().ln() + t * resonators + contraction;
        let samples = 20_000;
        let sampled = resistance_sampled(&chain, &y, t, samples);
        println!("{kind:?}: {off:e}, contraction {contraction}, sampled {sampled}");
        // Measured: 7.9e-11, 1.0e-10, where ln det is -16.
        assert!(contraction > 0.5 && off.abs() < 2e-10, "{off:e}");
        // The integrand has roots of time (viscoelastic) or jumps (dashpots) at some 40 events.
        // Each makes an error of at most its height times the step.
        assert!((contraction - sampled).abs() < 40.0 * 2.0 * t / f64::from(samples), "{contraction} {sampled}");
    }
}

/// `int sum_b c(g_b) (1/m + 1/m') dt` of contacts with a positive force, by the trapezoidal rule.
fn resistance_sampled(chain: &Chain<f64>, y: &[f64], t: f64, samples: u32) -> f64 {
    let details = chain.details().unwrap().clone();
    let loss = details.dissipation.clone().unwrap();
    let (n, half) = (chain.sites(), chain.layout().half());
    let per_mass = |i: usize| if i == 0 || i >= n { 0.0 } else { 1.0 / details.mass[i] };
    let of = |state: &[f64]| -> f64 {
        let bond = |b: usize| {
            let u = |i: usize| if i < n { [state[i], state[half + i]] } else { [0.0; 2] };
            let ([u1, v1], [u2, v2]) = (if b == 0 { [0.0; 2] } else { u(b - 1) }, u(b));
            let (g, rate, a) = (details.overlap[b] + u1 - u2, v1 - v2, details.alpha[b]);
            if g <= 0.0 {
                return 0.0;
            }
            let c = match loss.kind {
                Kind::Viscoelastic => loss.strength[b] * details.contact[b] * a * g.powf(a - 1.0),
                Kind::Dashpot => loss.strength[b],
            };
            let pushes = details.contact[b] * g.powf(a) + c * rate > 0.0;
            let before = if b == 0 { 0.0 } else { per_mass(b - 1) };
            if pushes { c * (before + per_mass(b)) } else { 0.0 }
        };
        (0..=n).map(bond).sum()
    };
    let mut state = State::rest(chain);
    state.as_mut_slice().copy_from_slice(y);
    let run = Run::new(chain.clone(), state).until(t).unwrap().tolerance(1e-10).unwrap();
    let times: Vec<f64> = (0..=samples).map(|k| t * f64::from(k) / f64::from(samples)).collect();
    let mut values = Vec::new();
    for at in run.at(&times).unwrap() {
        values.push(of(at.unwrap().as_slice()));
    }
    let sum: f64 = values.iter().sum::<f64>() - 0.5 * (values[0] + values[values.len() - 1]);
    sum * t / f64::from(samples)
}

/// Two beads that fly, collide and fly on, in relative displacement and velocity: the coefficient
/// of restitution, and the tangent map.
fn collision(kind: Kind, gamma: f64, speed: f64, tol: f64) -> (f64, DMatrix<f64>, f64) {
    let details = Details {
        mass: vec![2.0, 0.5],
        overlap: vec![-0.125],
        dissipation: Some(Dissipation { kind, strength: vec![gamma] }),
        ..Details::default()
    };
    let bare = Chain::<f64>::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 2).unwrap();
    let chain = bare.with(&details).unwrap();
    let mut y = vec![0.0; chain.layout().dim()];
    y[2] = speed;
    // A relative displacement and a relative velocity that leave the centre of mass where it is.
    let columns = [0.2, 0.0, -0.8, 0.0, 0.0, 0.2, 0.0, -0.8];
    let end = Variations::flow(&chain, &y, (0.0, 40.0), &columns, tol).unwrap();
    let w = &end.columns;
    let relative = DMatrix::from_row_slice(2, 2, &[w[0] - w[2], w[1] - w[3], w[4] - w[6], w[5] - w[7]]);
    ((end.state[3] - end.state[2]) / speed, relative, end.contraction)
}

#[test]
fn a_collision_has_the_tangent_map_of_its_restitution() {
    // Truth: after a collision r(t) = r_0 - e v (t - t_0) with t_0 before by dr/v, so that dr_0
    // becomes -e dr_0, and no velocity. By Liouville the determinant is exp(-contraction).
    for kind in [Kind::Viscoelastic, Kind::Dashpot] {
        for gamma in [0.02, 0.2] {
            let (e, m, contraction) = collision(kind, gamma, 0.3, 1e-13);
            let off = [m[(0, 0)] + e, m[(1, 0)], m.determinant() / (-contraction).exp() - 1.0];
            println!("{kind:?} {gamma}: e {e}, {off:?}");
            // Measured: 5.9e-12.
            assert!(off.iter().all(|off| off.abs() < 1.2e-11), "{kind:?} {gamma}: {off:?}");
        }
    }
}

#[test]
fn viscoelastic_spheres_rebound_with_the_published_derivative() {
    // Truth: Ramirez, Poeschel, Brilliantov & Schwager 1999, as in details.rs: e = 1 - C_1 x + C_2
    // x^2 + O(x^{5/2}) with x ~ v^{1/5}, so that d(e v)/dv = 1 - 6/5 C_1 x + 7/5 C_2 x^2 + ...
    // C_1 = Gamma(3/5) sqrt(pi)/(2^{1/5} 5^{2/5} Gamma(21/10)), with more digits than in the paper.
    // The next terms, of the order x^3, lower the slope, by less where gamma is smaller.
    let (c1, speed) = (1.153_448_858_095_288_4, 0.3f64);
    let c2 = 0.6 * c1 * c1;
    let rests = [0.01, 0.005, 0.0025].map(|gamma| {
        let x = 1.5 * gamma * (1.0f64 / 0.4).powf(0.4) * speed.powf(0.2);
        let (_, m, _) = collision(Kind::Viscoelastic, gamma, speed, 1e-13);
        let rest = -m[(1, 1)] - (1.0 - 1.2 * c1 * x + 1.4 * c2 * x * x);
        assert!(rest.abs() < x.powf(2.5), "{gamma}: {rest:e}");
        rest
    });
    let slope = (rests[1] / rests[2]).log2();
    println!("{rests:?} {slope}");
    assert!((2.2..2.8).contains(&slope), "{slope}");
}

#[test]
fn a_chain_at_rest_that_is_struck_is_right_or_fails() {
    // Truth: contact collocation. Where beads at rest just touch, the search for events may give up
    // an onset; the flow must then fail, and not return a state in which beads overlap freely.
    for kind in [Kind::Viscoelastic, Kind::Dashpot] {
        let details =
            Details { dissipation: Some(Dissipation { kind, strength: vec![0.1; 11] }), ..Details::default() };
        let bare = Chain::<f64>::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 12).unwrap();
        let chain = bare.with(&details).unwrap();
        let mut start = State::rest(&chain);
        start.u_dot_mut()[0] = 1.0;
        let run = Run::new(chain.clone(), start.clone()).until(10.0).unwrap().tolerance(1e-8).unwrap();
        let truth = run.start().unwrap().complete().unwrap().state;
        for tol in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
            match Variations::flow(&chain, start.as_slice(), (0.0, 10.0), &[], tol) {
                Ok(end) => {
                    let off = error(&end.state[..24], &truth[..24]);
                    println!("{kind:?} {tol:e}: {off:e}");
                    assert!(off < 1e-2, "{kind:?} {tol:e}: {off:e}");
                }
                Err(why) => {
                    println!("{kind:?} {tol:e}: {why}");
                    assert!(why.to_string().contains("was not found"), "{why}");
                }
            }
        }
    }
}

#[test]
fn what_has_no_tangent_map_is_refused() {
    let bare = |alpha| Chain::<f64>::new(Params::new(alpha, 0.0, 0.0).unwrap(), Boundary::Free, 2).unwrap();
    let said = |chain: &Chain<f64>| Variations::new(chain, 1).err().unwrap().to_string();
    assert!(said(&bare(1.0)).contains("alpha = 1") && said(&bare(1.0)).contains("alpha > 1"), "{}", said(&bare(1.0)));
    let chain = bare(1.5);
    let flow = |columns: &[f64]| Variations::flow(&chain, &[0.0; 4], (0.0, 1.0), columns, 1e-9);
    assert!(flow(&[1.0; 3]).unwrap_err().to_string().contains("3 entries for 4 rows"));
    assert!(Variations::flow(&chain, &[0.0; 3], (0.0, 1.0), &[], 1e-9).is_err());
}
