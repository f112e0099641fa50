//! The tangent map of chains whose beads differ, are damped and driven.

use crate::numbers::{direction, error, runge_kutta};
use hertzchain::chain::{
    Boundary, Chain, Details, Dissipation, Drive, DriveKind, Envelope, Harmonic, Kind, Parameter, Params, Signal, Site,
    State, Variations,
};
use hertzchain::integrators::{Real, collocation::StepControl};
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
fn it_agrees_with_differences_in_double_double_as_that_of_collocation_does() {
    // Truth: central differences of runs in 32 digits, whose error is of the order of the square of
    // their step, 1e-9 (and of its 3/2 power at contacts that begin within it). Asked: 1e-9.
    let (chain, t) = (chain::<f64>(), 9.0);
    let (y, w) = (start(&chain), direction(free(&chain).len(), 0));
    let truth = difference(&self::chain(), &w, t, (1e-9, 1e-23));
    let by_collocation = collocated(&chain, &y, t, 720);
    let off = error(&applied(&by_collocation, &w), &truth);
    println!("differences {off:e}");
    // Measured: 1.2e-14.
    assert!(off < 3e-14, "{off:e}");
    let mut last = f64::INFINITY;
    for tol in [1e-6, 1e-8, 1e-10, 1e-12, 1e-13, 1e-14, 1e-15] {
        let got = monodromy(&chain, &y, t, tol);
        let (off, apart) = (error(&applied(&got, &w), &truth), (&got - &by_collocation).amax() / got.amax());
        println!("DOP853 {tol:e}: {off:e}, {apart:e}");
        if tol >= 1e-12 {
            assert!(off < (0.1 * last).min(1.0) && (off < 1e-9 || tol > 1e-12), "{tol:e}: {off:e} after {last:e}");
            last = off;
        }
        // Measured: 5.8e-12, 7.6e-13, 1.2e-13 and 2.5e-14. With the stiffness of an overlap that is
        // a rounding after a release: up to 2.5e-11 with each of them.
        assert!(tol > 1e-12 || apart < 15.0 * tol + 5e-14, "{tol:e}: {apart:e}");
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
    let of = |law| difference(&lossy(law), &direction(free(&lossy::<f64>(law)).len(), 0), 9.0, (1e-6, 1e-20));
    LAWS.map(of).to_vec()
});

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

const STRENGTHS: [f64; 6] = [1e-6, 1e-3, 0.02, 0.1, 0.3, 1.0];

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
            runge_kutta(&mut z, 1.0, |share, z| rates(z, at(share)));
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
