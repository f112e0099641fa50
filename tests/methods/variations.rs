//! The tangent map of chains whose beads differ, are damped and driven.

use crate::numbers::{direction, error};
use hertzchain::chain::{
    Boundary, Chain, Details, Dissipation, Drive, DriveKind, Envelope, Harmonic, Kind, Parameter, Params, Signal, Site,
    State, Variations,
};
use hertzchain::integrators::{Real, collocation::StepControl};
use hertzchain::run::Run;
use nalgebra::DMatrix;
use std::sync::LazyLock;
use twofloat::TwoFloat;

/// Six beads between walls that differ in everything, with drag, dashpots, a bead that is moved and
/// one that is pushed; contacts open and close.
pub(crate) fn chain<R: Real>() -> Chain<R> {
    let drive = |site, kind, amplitude, omega| {
        let harmonics = vec![Harmonic { amplitude, omega, phase: 0.4 }];
        Drive { site, kind, signal: Signal::new(harmonics, Envelope::None) }
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
        drives: vec![drive(0, DriveKind::Displacement, 0.3, 1.3), drive(3, DriveKind::Force, 0.4, 0.7)],
        ..Details::default()
    };
    Chain::new(Params::new(1.5, 1.0, 1.0).unwrap(), Boundary::Fixed, 6).unwrap().with(&details).unwrap()
}

pub(crate) fn start<R: Real>(chain: &Chain<R>) -> Vec<R> {
    let of = |x: f64| R::of(x);
    let site = |i: usize| {
        let x = i as f64;
        let (u, v) = (0.2 * (1.7 * x).sin(), 0.1 * (2.3 * x).cos());
        Site { u: of(u), v: of(v), u_dot: of(0.5 * (3.1 * x).sin()), v_dot: of(0.2 * (0.7 * x).cos()) }
    };
    State::from_fn(chain, site).unwrap().driven(chain).as_slice().to_vec()
}

/// The same with other details.
pub(crate) fn altered<R: Real>(chain: &Chain<R>, change: impl FnOnce(&mut Details)) -> Chain<R> {
    let mut details = chain.details().cloned().unwrap_or_default();
    change(&mut details);
    Chain::new(chain.params(), chain.boundary(), chain.sites()).unwrap().with(&details).unwrap()
}

/// A law of dissipation: its kind, `beta` of a dashpot, and whether beads may pull.
pub(crate) type Law = (Kind, f64, bool);

pub(crate) const LAWS: [Law; 8] = [
    (Kind::Viscoelastic, 0.0, false),
    (Kind::Dashpot, 0.0, false),
    (Kind::HuntCrossley, 0.0, false),
    (Kind::Dashpot, 0.25, false),
    (Kind::Viscoelastic, 0.0, true),
    (Kind::Dashpot, 0.0, true),
    (Kind::HuntCrossley, 0.0, true),
    (Kind::Dashpot, 0.25, true),
];

/// The same chain with contacts that dissipate, all but one.
pub(crate) fn lossy<R: Real>((kind, beta, pull): Law) -> Chain<R> {
    let strength = vec![0.1, 0.3, 0.05, 0.2, 0.0, 0.4, 0.15];
    altered(&chain(), |details| {
        (details.dissipation, details.beta, details.pull) = (Some(Dissipation { kind, strength }), beta, pull);
    })
}

/// Entries of a state that are free: positions, then velocities.
pub(crate) fn free(chain: &Chain<f64>) -> Vec<usize> {
    let (n, half) = (chain.sites(), chain.layout().half());
    let q: Vec<usize> = (1..n).chain((0..n).filter(|&i| chain.resonator_moves(i)).map(|i| n + i)).collect();
    q.iter().copied().chain(q.iter().map(|i| half + i)).collect()
}

/// The derivative by the free entries of the state, by rows.
pub(crate) fn monodromy(chain: &Chain<f64>, y: &[f64], t: f64, tol: f64) -> DMatrix<f64> {
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

/// `dy(t)/dy(0) w` by central differences of this step in 32 digits, from runs under a tolerance.
pub(crate) fn difference(chain: &Chain<TwoFloat>, w: &[f64], t: f64, (size, tol): (f64, f64)) -> Vec<f64> {
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

pub(crate) fn applied(m: &DMatrix<f64>, w: &[f64]) -> Vec<f64> {
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
        let control = StepControl::Windows { windows: 200, nodes: 12, neighbours: true };
        let want = DMatrix::from_vec(dim, dim, chain.monodromy(&y, (0.0, t), control).unwrap());
        let identity: Vec<f64> = DMatrix::<f64>::identity(dim, dim).as_slice().to_vec();
        let end = Variations::flow(&chain, &y, (0.0, t), &identity, 1e-13).unwrap();
        let got = DMatrix::from_row_slice(dim, dim, &end.columns);
        let off = (&got - &want).amax() / want.amax();
        println!("{rho} {boundary:?}: {off:e}");
        assert!(off < 1e-11, "{rho} {boundary:?}: {off:e}");
    }
}

/// Differences of each of the laws up to `t = 9`, for this test and that of collocation.
pub(crate) static DIFFERENCES: LazyLock<Vec<Vec<f64>>> = LazyLock::new(|| {
    let of = |law| difference(&lossy(law), &direction(free(&lossy::<f64>(law)).len(), 0), 9.0, (1e-6, 1e-18));
    LAWS.map(of).to_vec()
});

#[test]
fn with_contacts_that_dissipate_it_agrees_with_differences_in_double_double() {
    // Truth: the same differences, with a longer step and a looser tolerance: the resistance of
    // viscoelastic contacts is computed by a division, which has 17 digits in double-double. Errors
    // of differences are of the order 1e-12 by the step, 1e-11 by the division, 4e-10 by the power
    // 1/4 of an overlap. Asked: 1e-9.
    for (kind, truth) in LAWS.into_iter().zip(&*DIFFERENCES) {
        let (chain, t) = (lossy::<f64>(kind), 9.0);
        let w = direction(free(&chain).len(), 0);
        let errors = [1e-6, 1e-8, 1e-10, 1e-12, 1e-14]
            .map(|tol| error(&applied(&monodromy(&chain, &start(&chain), t, tol), &w), truth));
        println!("{kind:?} {errors:?}");
        assert!(errors[3] < 1e-9, "{:e}", errors[3]);
        for pair in errors[..4].windows(2) {
            assert!(pair[1] < (0.1 * pair[0]).max(4e-10), "{errors:?}");
        }
    }
}

#[test]
fn with_contacts_that_dissipate_its_determinant_is_liouvilles() {
    // Truth: det = exp(int div dt). That of drag and dashpots of resonators is constant, see above;
    // that of contacts is an integral along the run, here also by the trapezoidal rule over states
    // of contact collocation.
    let resonators = 0.2 / 0.5 + 0.2 / 2.0 + 0.05 / 1.5 + 0.2 / 0.7 + 0.07 + 0.1 / (0.5 * 0.5) + 0.05 / 0.3;
    for kind in LAWS {
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
                Kind::Dashpot => loss.strength[b] * g.powf(details.beta),
                Kind::HuntCrossley => loss.strength[b] * details.contact[b] * g.powf(a),
            };
            let pushes = details.pull || details.contact[b] * g.powf(a) + c * rate > 0.0;
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
fn collision((kind, beta, pull): Law, gamma: f64, speed: f64, tol: f64) -> (f64, DMatrix<f64>, f64) {
    let details = Details {
        mass: vec![2.0, 0.5],
        overlap: vec![-0.125],
        dissipation: Some(Dissipation { kind, strength: vec![gamma] }),
        beta,
        pull,
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
    for kind in LAWS {
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
        let (_, m, _) = collision((Kind::Viscoelastic, 0.0, false), gamma, speed, 1e-13);
        let rest = -m[(1, 1)] - (1.0 - 1.2 * c1 * x + 1.4 * c2 * x * x);
        assert!(rest.abs() < x.powf(2.5), "{gamma}: {rest:e}");
        rest
    });
    let slope = (rests[1] / rests[2]).log2();
    println!("{rests:?} {slope}");
    assert!((2.2..2.8).contains(&slope), "{slope}");
}

/// Beads of mass 1 that just touch, of which the first is struck, with contacts that dissipate
/// equally, or not at all for `gamma = 0`.
pub(crate) fn struck<R: Real>(sites: usize, kind: Kind, gamma: f64) -> (Chain<R>, Vec<R>) {
    let dissipation = (gamma > 0.0).then(|| Dissipation { kind, strength: vec![gamma; sites - 1] });
    let bare = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, sites).unwrap();
    let chain = bare.with(&Details { dissipation, ..Details::default() }).unwrap();
    let mut y = vec![R::of(0.0); chain.layout().dim()];
    y[sites] = R::of(1.0);
    (chain, y)
}

pub(crate) const STRENGTHS: [f64; 6] = [1e-6, 1e-3, 0.02, 0.1, 0.3, 1.0];

/// Rows of the unit matrix, without the columns of the first `skipped` entries.
fn unit(rows: usize, skipped: usize) -> Vec<f64> {
    (0..rows * (rows - skipped)).map(|k| f64::from(k / (rows - skipped) == k % (rows - skipped) + skipped)).collect()
}

/// The end of a flow over time `t` of struck beads none of which lets go, and its derivatives row
/// by row, by the classical Runge-Kutta method in the variables `u` and
/// `p_n = u_n' - sum_b w_nb C(g_b)`, `C' = c`. In these all contacts are one smooth law, without
/// events. Steps are equal in `t^{1/4}`, with Richardson's extrapolation.
fn by_smooth_variables(n: usize, (kind, gamma): (Kind, f64), t: f64) -> (Vec<f64>, Vec<f64>) {
    let (k, dim) = (2 * n, 2 * n + 4 * n * n);
    // The force of a contact and its derivative, C and its derivative.
    let law = |g: f64| {
        let (f, stiffness) = (g.max(0.0).powf(1.5), 1.5 * g.max(0.0).sqrt());
        let (c, by_overlap) = if kind == Kind::Dashpot { (gamma * g, gamma) } else { (gamma * f, gamma * stiffness) };
        [[f, stiffness], [c, by_overlap]]
    };
    // Adds the force or C of all contacts, and its change in all columns, from `z` to rows of
    // `out`.
    let add = |z: &[f64], which: usize, sign: f64, out: &mut [f64], row: usize| {
        for b in 1..n {
            let [value, slope] = law(z[b - 1] - z[b])[which];
            for (site, weight) in [(b - 1, -sign), (b, sign)] {
                out[row + site] += weight * value;
                for j in 0..k {
                    let change = z[k + (b - 1) * k + j] - z[k + b * k + j];
                    out[k + (row + site) * k + j] += weight * slope * change;
                }
            }
        }
    };
    let rates = |z: &[f64], factor: f64| {
        let mut out = vec![0.0; dim];
        out[..n].copy_from_slice(&z[n..k]);
        out[k..k + n * k].copy_from_slice(&z[k + n * k..]);
        add(z, 1, 1.0, &mut out, 0);
        add(z, 0, 1.0, &mut out, n);
        out.iter().map(|x| factor * x).collect::<Vec<f64>>()
    };
    let end = |steps: usize| {
        let mut z = vec![0.0; k];
        z[n] = 1.0;
        z.extend(unit(k, 0));
        let start = z.clone();
        add(&start, 1, -1.0, &mut z, n);
        let h = 1.0 / steps as f64;
        for i in 0..steps {
            let at = |share: f64| t * 4.0 * h * (h * (i as f64 + share)).powi(3);
            let moved =
                |by: &[f64], share: f64| -> Vec<f64> { z.iter().zip(by).map(|(z, by)| z + share * by).collect() };
            let a = rates(&z, at(0.0));
            let b = rates(&moved(&a, 0.5), at(0.5));
            let c = rates(&moved(&b, 0.5), at(0.5));
            let d = rates(&moved(&c, 1.0), at(1.0));
            for i in 0..dim {
                z[i] += (a[i] + 2.0 * (b[i] + c[i]) + d[i]) / 6.0;
            }
        }
        let last = z.clone();
        add(&last, 1, 1.0, &mut z, n);
        z
    };
    let (coarse, fine) = (end(600), end(1200));
    let mut state: Vec<f64> = fine.iter().zip(&coarse).map(|(fine, coarse)| fine + (fine - coarse) / 15.0).collect();
    let columns = state.split_off(k);
    (state, columns)
}

#[test]
fn beads_that_just_touch_have_the_tangent_map_of_their_smooth_variables() {
    // Truth: variables in which onsets are smooth, and another method. Columns: all of viscoelastic
    // contacts and of those that do not dissipate; velocities of dashpots, which have no derivative
    // by the overlaps of touching beads. Measured: 53 tolerances. Before, columns of contacts that
    // do not dissipate were off by 9e-3.
    for kind in [Kind::Viscoelastic, Kind::Dashpot] {
        let mut worst = 0.0f64;
        let elastic = (kind == Kind::Viscoelastic).then_some(0.0);
        for gamma in elastic.into_iter().chain(STRENGTHS) {
            for (n, t) in [(3, 1.0), (8, 0.1), (8, 1.0)] {
                let (chain, y) = struck::<f64>(n, kind, gamma);
                let (state, truth) = by_smooth_variables(n, (kind, gamma), t);
                let skipped = if kind == Kind::Dashpot { n } else { 0 };
                let truth: Vec<f64> =
                    truth.chunks_exact(2 * n).flat_map(|row| row[skipped..].iter().copied()).collect();
                for tol in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
                    let end = Variations::flow(&chain, &y, (0.0, t), &unit(2 * n, skipped), tol).unwrap();
                    let off = error(&end.columns, &truth).max(error(&end.state[..2 * n], &state));
                    worst = worst.max(off / (tol + 1e-12));
                    assert!(off < 100.0 * tol + 3e-11, "{kind:?} {gamma} {n} {t} {tol:e}: {off:e}");
                }
            }
        }
        println!("{kind:?}: {worst} tolerances");
    }
}

#[test]
fn a_chain_at_rest_that_is_struck_has_its_tangent_map_until_the_end() {
    // Truth: contact collocation for the state; the flow in two parts (semigroup); Liouville's
    // formula, where the determinant is not all rounding. Before, the search for events gave up
    // onsets in 132 of 288 of such runs.
    let (n, split) = (12, 7.3);
    let mut worst = [0.0f64; 3];
    for kind in [Kind::Viscoelastic, Kind::Dashpot] {
        for gamma in STRENGTHS {
            let (chain, y) = struck::<f64>(n, kind, gamma);
            // Of dashpots the derivative by the strike only: the last beads all but touch at the
            // start of the second part.
            let all = kind == Kind::Viscoelastic;
            let columns = if all { unit(2 * n, 0) } else { (0..2 * n).map(|i| f64::from(i == n)).collect() };
            for end in [3.0, 10.0, 20.0] {
                let mut state = State::rest(&chain);
                state.as_mut_slice().copy_from_slice(&y);
                let run = Run::new(chain.clone(), state).until(end).unwrap().tolerance(1e-8).unwrap();
                let truth = run.start().unwrap().complete().unwrap().state;
                for tol in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14] {
                    let flow = |y: &[f64], span, columns: &[f64]| Variations::flow(&chain, y, span, columns, tol);
                    let whole = flow(&y, (0.0, end), &columns).unwrap();
                    let off = error(&whole.state[..2 * n], &truth[..2 * n]);
                    worst[0] = worst[0].max(off / (tol + 1e-8));
                    assert!(off < 300.0 * tol + 1e-7, "{kind:?} {gamma} {end} {tol:e}: state {off:e}");
                    if all && whole.contraction < 8.0 {
                        let m = DMatrix::from_row_slice(2 * n, 2 * n, &whole.columns);
                        let off = (m.determinant().ln() + whole.contraction).abs();
                        worst[1] = worst[1].max(off / (tol + 1e-13));
                        assert!(off < 600.0 * tol + 1e-11, "{kind:?} {gamma} {end} {tol:e}: determinant {off:e}");
                    }
                    if end > split {
                        let first = flow(&y, (0.0, split), &columns).unwrap();
                        let second = flow(&first.state, (split, end), &first.columns).unwrap();
                        let off = error(&second.columns, &whole.columns);
                        worst[2] = worst[2].max(off / (tol + 1e-13));
                        assert!(off < 1e3 * tol + 1e-11, "{kind:?} {gamma} {end} {tol:e}: parts {off:e}");
                    }
                }
            }
        }
    }
    println!("state, determinant, two parts: {worst:.1?} tolerances");
}

#[test]
fn a_struck_chain_agrees_with_differences_in_double_double() {
    // Truth: central differences by the speed of the strike in 32 digits, past releases. The
    // division in the resistance of viscoelastic contacts has 17 digits.
    let n = 6;
    for kind in [Kind::Viscoelastic, Kind::Dashpot] {
        for (gamma, t) in [(1e-3, 6.0), (0.1, 6.0), (0.3, 4.0)] {
            let (chain, y) = struck::<f64>(n, kind, gamma);
            let (finer, start) = struck::<TwoFloat>(n, kind, gamma);
            let end = |sign: f64| {
                let mut y = start.clone();
                y[n] += <TwoFloat as Real>::of(sign * 1e-7);
                let span = (Real::of(0.0), Real::of(t));
                Variations::flow(&finer, &y, span, &[], Real::of(1e-17)).unwrap().state
            };
            let (plus, minus) = (end(1.0), end(-1.0));
            let truth: Vec<f64> = (0..2 * n).map(|i| Real::f64(plus[i] - minus[i]) / 2e-7).collect();
            let column: Vec<f64> = (0..2 * n).map(|i| f64::from(i == n)).collect();
            let got = Variations::flow(&chain, &y, (0.0, t), &column, 1e-13).unwrap().columns;
            let off = error(&got, &truth);
            println!("{kind:?} {gamma}: {off:e}");
            assert!(off < 1e-9, "{kind:?} {gamma}: {off:e}");
        }
    }
}

#[test]
fn chains_that_touch_in_any_pattern_have_a_tangent_map() {
    // Truth: the finest run. Walls, rings and gaps, strikes to both sides; contacts that dissipate
    // from 1e-6 to 1, or not at all. Columns: velocities of the beads that are struck.
    let mut worst = 0.0f64;
    for seed in 0..24 {
        let mut next = crate::heterogeneous::random(seed);
        (0..5).for_each(|_| {
            next();
        });
        let sites = (2 + (next() * 20.0) as usize).max(3);
        let kind = if next() < 0.5 { Kind::Viscoelastic } else { Kind::Dashpot };
        let boundary = crate::heterogeneous::BOUNDARIES[(next() * 3.0) as usize];
        let bare = Chain::<f64>::new(Params::new(1.5, 0.0, 0.0).unwrap(), boundary, sites).unwrap();
        let bonds = bare.touching().len();
        let strength = (0..bonds).map(|_| if next() < 0.1 { 0.0 } else { 10f64.powf(-6.0 + 6.0 * next()) }).collect();
        let gaps = next() < 0.4;
        let overlap = (0..bonds).map(|_| if gaps && next() < 0.4 { -0.2 * next() } else { 0.0 }).collect();
        let dissipation = Some(Dissipation { kind, strength });
        let chain = bare.with(&Details { overlap, dissipation, ..Details::default() }).unwrap();
        let mut state = State::rest(&chain);
        for _ in 0..1 + (next() * 3.0) as usize {
            let i = (next() * sites as f64) as usize;
            state.u_dot_mut()[i] = 2.0 * next() - 1.0;
        }
        let (y, rows) = (state.as_slice(), 2 * sites);
        let struck: Vec<usize> = (sites..rows).filter(|&i| y[i] != 0.0).collect();
        let columns: Vec<f64> =
            (0..rows).flat_map(|i| struck.iter().map(move |&j| f64::from(i == j)).collect::<Vec<_>>()).collect();
        let flow = |tol: f64| Variations::flow(&chain, y, (0.0, 10.0), &columns, tol).unwrap();
        let want = flow(1e-13);
        for tol in [1e-4, 1e-6, 1e-7, 1e-9, 1e-11] {
            let got = flow(tol);
            let off = error(&got.state[..rows], &want.state[..rows]).max(error(&got.columns, &want.columns));
            worst = worst.max(off / tol);
            assert!(off < 3e3 * tol, "{seed} {kind:?} {boundary:?} {sites} {tol:e}: {off:e}");
        }
    }
    println!("{worst} tolerances");
}

#[test]
fn dashpots_of_beads_that_touch_have_no_derivative_by_their_overlap() {
    // Truth: a gap e of beads that touch costs the impulse gamma e, an overlap e gains none: runs
    // from both sides differ by gamma e in the velocity of a bead.
    let (gamma, e) = (0.3, 1e-8);
    let (chain, y) = struck::<f64>(3, Kind::Dashpot, gamma);
    let moved = |by: f64| {
        let mut y = y.clone();
        y[0] += by;
        Variations::flow(&chain, &y, (0.0, 1e-3), &[], 1e-14).unwrap().state
    };
    let [gap, touch, overlap] = [-e, 0.0, e].map(moved);
    let [before, after] = [(touch[4] - gap[4]) / e, (overlap[4] - touch[4]) / e];
    println!("{before} {after}");
    assert!((before - after - gamma).abs() < 2e-3, "{before} {after}");

    let flow = |column: &[f64]| Variations::flow(&chain, &y, (0.0, 1.0), column, 1e-9);
    let said = flow(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]).unwrap_err().to_string();
    assert!(said.contains("bond 1") && said.contains("t = 0") && said.contains("gap and overlap"), "{said}");
    // All beads moved alike, and velocities.
    assert!(flow(&[1.0, 1.0, 1.0, 0.0, 0.0, 0.0]).is_ok() && flow(&[0.0, 0.0, 0.0, 1.0, 2.0, 3.0]).is_ok());

    // Two beads that touch at rest beyond a gap: their velocities, not that of the strike.
    let overlap = vec![0.0, -0.5, 0.0];
    let (_, y) = struck::<f64>(4, Kind::Dashpot, gamma);
    let dissipation = Some(Dissipation { kind: Kind::Dashpot, strength: vec![gamma; 3] });
    let bare = Chain::<f64>::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 4).unwrap();
    let chain = bare.with(&Details { overlap, dissipation, ..Details::default() }).unwrap();
    let by = |site: usize| {
        let column: Vec<f64> = (0..8).map(|i| f64::from(i == 4 + site)).collect();
        Variations::flow(&chain, &y, (0.0, 3.0), &column, 1e-9)
    };
    let said = by(2).unwrap_err().to_string();
    assert!(by(0).is_ok() && said.contains("bond 3") && said.contains("gap and overlap"), "{said}");
}

#[test]
fn what_has_no_tangent_map_is_refused() {
    let bare = |alpha| Chain::<f64>::new(Params::new(alpha, 0.0, 0.0).unwrap(), Boundary::Free, 2).unwrap();
    let said = |chain: &Chain<f64>| Variations::new(chain, 1).err().unwrap().to_string();
    assert!(said(&bare(1.0)).contains("alpha = 1") && said(&bare(1.0)).contains("above 1"), "{}", said(&bare(1.0)));
    let chain = bare(1.5);
    let flow = |columns: &[f64]| Variations::flow(&chain, &[0.0; 4], (0.0, 1.0), columns, 1e-9);
    assert!(flow(&[1.0; 3]).unwrap_err().to_string().contains("3 entries for 4 rows"));
    assert!(Variations::flow(&chain, &[0.0; 3], (0.0, 1.0), &[], 1e-9).is_err());
}

#[test]
fn derivatives_by_numbers_of_a_chain_agree_with_differences() {
    // Truth: central differences of runs of chains with other numbers, by steps of 1e-4; the error
    // is of the order of the square, or of its 3/2 power by beads that just open. Beads differ, are
    // damped and pushed; contacts open and close.
    let [alpha, kappa, rho, mass] = [1.7, 1.3, 0.6, 0.8];
    let of = |[alpha, kappa, rho, mass]: [f64; 4]| {
        let push = Signal::new(vec![Harmonic { amplitude: 0.4, omega: 0.7, phase: 0.4 }], Envelope::None);
        let details = Details {
            mass: vec![1.0, mass, 2.0, 1.5],
            drag: vec![0.1, 0.0, 0.05, 0.02],
            dashpot: vec![0.0, 0.1, 0.2, 0.0],
            contact: vec![1.0, 2.0, 1.5, 1.0, 0.8],
            overlap: vec![0.1, 0.05, -0.02, 0.1, 0.0],
            drives: vec![Drive { site: 2, kind: DriveKind::Force, signal: push }],
            ..Details::default()
        };
        Chain::new(Params::new(alpha, kappa, rho).unwrap(), Boundary::Fixed, 4).unwrap().with(&details).unwrap()
    };
    let numbers = [alpha, kappa, rho, mass];
    let chain = of(numbers);
    let (y, span) = (start(&chain), (0.0, 6.0));
    let by = [Parameter::Alpha, Parameter::Kappa, Parameter::Rho, Parameter::Mass(1)];
    let rows = 2 * chain.layout().half();
    let got = Variations::flow_by(&chain, &y, span, (&vec![0.0; 4 * rows], &by), 1e-12).unwrap();
    for j in 0..by.len() {
        let end = |sign: f64| {
            let mut numbers = numbers;
            numbers[j] += sign * 1e-4;
            Variations::flow(&of(numbers), &y, span, &[], 1e-13).unwrap().state
        };
        let (plus, minus) = (end(1.0), end(-1.0));
        let want: Vec<f64> = (0..rows).map(|i| (plus[i] - minus[i]) / 2e-4).collect();
        let column: Vec<f64> = (0..rows).map(|i| got.columns[i * by.len() + j]).collect();
        let size = want.iter().fold(0.0f64, |size, x| size.max(x.abs()));
        let off = want.iter().zip(&column).fold(0.0f64, |off, (a, b)| off.max((a - b).abs()));
        assert!(size > 0.01 && off < 1e-6 * size, "{:?}: {off:e} of {size:e}", by[j]);
    }
    // Springs of sites without resonators are no kappa.
    for own in [vec![], vec![0.0, 0.5], vec![f64::INFINITY, 0.0]] {
        let of = |kappa: f64| {
            let details = Details { onsite: vec![0.5; 2], rho: own.clone(), ..Details::default() };
            Chain::<f64>::new(Params::new(1.5, kappa, 0.0).unwrap(), Boundary::Free, 2).unwrap().with(&details).unwrap()
        };
        let chain = of(1.0);
        let (rows, dim, span) = (2 * chain.layout().half(), chain.layout().dim(), (0.0, 3.0));
        let y: Vec<f64> = (0..dim).map(|i| f64::from(u8::from(i == 0))).collect();
        let got = Variations::flow_by(&chain, &y, span, (&vec![0.0; rows], &[Parameter::Kappa]), 1e-12).unwrap();
        let end = |kappa: f64| Variations::flow(&of(kappa), &y, span, &[], 1e-13).unwrap().state;
        let (plus, minus) = (end(1.0 + 1e-4), end(1.0 - 1e-4));
        for i in 0..rows {
            let want = (plus[i] - minus[i]) / 2e-4;
            assert!((want - got.columns[i]).abs() < 3e-6, "{own:?} {i}: {want} {}", got.columns[i]);
        }
    }
    let refused = |chain: &Chain<f64>, by| {
        let columns = vec![0.0; 2 * chain.layout().half()];
        let y = vec![0.0; chain.layout().dim()];
        Variations::flow_by(chain, &y, span, (&columns, &[by]), 1e-12).unwrap_err().to_string()
    };
    assert!(refused(&self::chain(), Parameter::Kappa).contains("spring constants of their own"));
    assert!(refused(&self::chain(), Parameter::Mass(6)).contains("a site of the chain"));
    assert!(refused(&lossy(LAWS[0]), Parameter::Rho).contains("do not dissipate"));
    let plain = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 2).unwrap();
    let falls = altered(&plain, |details| details.gravity = 0.1);
    assert!(refused(&falls, Parameter::Alpha).contains("without gravity"));
    assert!(refused(&plain, Parameter::Rho).contains("no resonator moves"));
    assert!(refused(&plain, Parameter::Kappa).contains("no springs"));
}
