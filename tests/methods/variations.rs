//! The tangent map of chains whose beads differ, are damped and driven.

use hertzchain::chain::{
    Boundary, Chain, Details, Dissipation, Drive, Envelope, Harmonic, Kind, Means, Params, Signal, Site, State,
    Variations,
};
use hertzchain::integrators::{Real, collocation::Pace};
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

/// `dy(t)/dy(0) w` by central differences in 32 digits.
fn difference(w: &[f64], t: f64) -> Vec<f64> {
    let (chain, entries) = (chain::<TwoFloat>(), free(&chain::<f64>()));
    let size = 1e-9;
    let end = |sign: f64| {
        let mut y = start(&chain);
        for (&i, w) in entries.iter().zip(w) {
            y[i] += <TwoFloat as Real>::of(sign * size) * <TwoFloat as Real>::of(*w);
        }
        Variations::flow(&chain, &y, (Real::of(0.0), Real::of(t)), &[], Real::of(1e-23)).unwrap().state
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
    let truth = difference(&w, t);
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
    let (other, truth) = (monodromy(&chain, &y, t, 1e-14), difference(&w, t));
    let (off, apart) = (error(&applied(&got, &w), &truth), (&got - &other).amax() / other.amax());
    println!("differences {off:e}, DOP853 {apart:e}");
    // Measured: 1.2e-14, 1.0e-13.
    assert!(off < 3e-14 && apart < 2e-13, "{off:e} {apart:e}");
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
fn what_has_no_tangent_map_is_refused() {
    let bare = |alpha| Chain::<f64>::new(Params::new(alpha, 0.0, 0.0).unwrap(), Boundary::Free, 2).unwrap();
    let lossy = Dissipation { kind: Kind::Viscoelastic, strength: vec![0.1] };
    let lossy = bare(1.5).with(&Details { dissipation: Some(lossy), ..Details::default() }).unwrap();
    let said = |chain: &Chain<f64>| Variations::new(chain, 1).err().unwrap().to_string();
    assert!(said(&lossy).contains("contacts that do not dissipate"), "{}", said(&lossy));
    assert!(said(&bare(1.0)).contains("alpha = 1") && said(&bare(1.0)).contains("alpha > 1"), "{}", said(&bare(1.0)));
    let chain = bare(1.5);
    let flow = |columns: &[f64]| Variations::flow(&chain, &[0.0; 4], (0.0, 1.0), columns, 1e-9);
    assert!(flow(&[1.0; 3]).unwrap_err().to_string().contains("3 entries for 4 rows"));
    assert!(Variations::flow(&chain, &[0.0; 3], (0.0, 1.0), &[], 1e-9).is_err());
}
