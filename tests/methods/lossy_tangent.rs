//! The tangent map of contact collocation where contacts dissipate.

use crate::{
    lossy::held,
    numbers::{direction, error},
    variations::{DIFFERENCES, LAWS, STRENGTHS, applied, free, lossy, monodromy, start, struck},
};
use hertzchain::{
    chain::{Boundary, Chain, Details, Dissipation, Kind, Params, Variations},
    integrators::{
        Stepper,
        collocation::{Collocation, ContactChain, StepControl, Tangent},
    },
};
use nalgebra::DMatrix;

const KINDS: [Kind; 3] = [Kind::Viscoelastic, Kind::Dashpot, Kind::HuntCrossley];
/// What is asked of the map, relative to its largest entry; fixed before it was measured.
const ASKED: f64 = 1e-9;

/// Columns at the end of a run, and the part of contacts in `-ln det`.
fn followed(chain: &Chain<f64>, y: &[f64], t: f64, control: StepControl, columns: &[f64]) -> (Vec<f64>, f64) {
    let mut run = chain.heterogeneous_collocation(y, (0.0, t), control).unwrap();
    let mut tangent = Tangent::new(&run, columns).unwrap();
    while !run.done() {
        run.step().unwrap();
        tangent.follow(&run).unwrap();
    }
    (tangent.matrix(&run).unwrap(), tangent.contraction())
}

/// Columns of the unit matrix, one after the other.
fn units(dim: usize, entries: &[usize]) -> Vec<f64> {
    entries.iter().flat_map(|&j| (0..dim).map(move |i| f64::from(i == j))).collect()
}

/// The derivative by some entries of the state, as in [`monodromy`]; and the part of contacts.
fn collocated(chain: &Chain<f64>, y: &[f64], t: f64, control: StepControl, entries: &[usize]) -> (DMatrix<f64>, f64) {
    let (columns, contraction) = followed(chain, y, t, control, &units(y.len(), entries));
    let of = |i: usize, j: usize| columns[j * y.len() + entries[i]];
    (DMatrix::from_fn(entries.len(), entries.len(), of), contraction)
}

fn apart(a: &DMatrix<f64>, b: &DMatrix<f64>) -> f64 {
    (a - b).amax() / b.amax()
}

#[test]
fn it_agrees_with_differences_in_double_double_as_the_variational_map_does() {
    // Truth: the differences of `variations.rs`, of the order 1e-12 by the step, 1e-11 by a
    // division, 4e-10 by the power 1/4 of an overlap; and the matrix by DOP853. Asked: 1e-9; beside
    // DOP853 a hundred tolerances of a step, and a hundredth of what is asked. Long windows miss
    // this without cuts at events of second neighbours, few nodes without halvings.
    for (kind, truth) in LAWS.into_iter().zip(&*DIFFERENCES) {
        let (chain, t) = (lossy::<f64>(kind), 9.0);
        let (y, entries) = (start(&chain), free(&chain));
        let w = direction(entries.len(), 0);
        let others = [1e-6, 1e-8, 1e-10, 1e-11, 1e-12, 1e-13].map(|tol| (tol, monodromy(&chain, &y, t, tol)));
        let errors = [0, 1, 2, 4].map(|k| error(&applied(&others[k].1, &w), truth));
        assert!(errors[3] < ASKED, "{kind:?} {errors:?}");
        for pair in errors.windows(2) {
            assert!(pair[1] < (0.1 * pair[0]).max(4e-10), "{kind:?} {errors:?}");
        }
        // Forces that begin with the power 1/4 of time take more of both: 90 windows have 2e-10,
        // eight nodes 2.6e-8.
        let grids: &[(u64, usize)] =
            if kind.1 == 0.0 { &[(90, 12), (180, 12), (720, 12), (360, 8)] } else { &[(360, 12), (720, 12)] };
        for &(windows, nodes) in grids {
            let got = collocated(&chain, &y, t, crate::windows(windows, nodes), &entries).0;
            let off = error(&applied(&got, &w), truth);
            println!("{kind:?}, {windows} windows: differences {off:e}");
            assert!(off < ASKED, "{kind:?} {windows}: {off:e}");
            for (tol, other) in &others[3..] {
                let off = apart(&got, other);
                println!("{kind:?}, {windows} windows: DOP853 {tol:e} {off:e}");
                assert!(off < 100.0 * tol + 0.01 * ASKED, "{kind:?} {windows} {tol:e}: {off:e}");
            }
        }
    }
}

#[test]
fn under_a_tolerance_it_errs_by_a_few_hundred_tolerances() {
    // Truth: equal windows. The factor is what `Tangent` says.
    for kind in LAWS {
        let (chain, t) = (lossy::<f64>(kind), 9.0);
        let (y, entries) = (start(&chain), free(&chain));
        let of = |control| collocated(&chain, &y, t, control, &entries).0;
        let truth = of(crate::windows(720, 12));
        for tol in [1e-6, 1e-8, 1e-10] {
            let off = apart(&of(StepControl::Tolerance(tol)), &truth);
            println!("{kind:?} {tol:e}: {off:e}");
            assert!(off < 300.0 * tol, "{kind:?} {tol:e}: {off:e}");
        }
    }
}

#[test]
fn determinants_are_liouvilles() {
    // Truth: det = exp(int div dt), for both methods: that of drag and dashpots of resonators is
    // constant, that of contacts an integral along the run. Measured by DOP853: 7.9e-11, where ln
    // det is -16.
    let resonators = 0.2 / 0.5 + 0.2 / 2.0 + 0.05 / 1.5 + 0.2 / 0.7 + 0.07 + 0.1 / (0.5 * 0.5) + 0.05 / 0.3;
    for kind in LAWS {
        let (chain, t) = (lossy::<f64>(kind), 9.0);
        let y = start(&chain);
        let (m, contraction) = collocated(&chain, &y, t, crate::windows(360, 12), &free(&chain));
        let other = Variations::flow(&chain, &y, (0.0, t), &[], 1e-13).unwrap().contraction;
        let of = |m: &DMatrix<f64>, contraction: f64| m.determinant().ln() + t * resonators + contraction;
        let off = [of(&m, contraction), contraction - other];
        println!("{kind:?}: {off:?}");
        assert!(off.iter().all(|off| off.abs() < ASKED) && contraction > 0.5, "{kind:?}: {off:?}");
        let off = of(&monodromy(&chain, &y, t, 1e-12), other);
        assert!(off.abs() < 2e-10, "{kind:?}: {off:e}");
    }
}

/// The maps of a run by the given entries: the whole, the rest of it after 137 windows, and the
/// part before.
pub(crate) fn parted<C: ContactChain<S>, const S: usize>(
    mut run: Collocation<C, S>,
    entries: &[usize],
) -> [DMatrix<f64>; 3] {
    let dim = run.dim();
    let square = |tangent: &Tangent<S>, run: &Collocation<C, S>| {
        let columns = tangent.matrix(run).unwrap();
        DMatrix::from_fn(entries.len(), entries.len(), |i, j| columns[j * dim + entries[i]])
    };
    let columns = units(dim, entries);
    let (mut whole, mut halves) = (Tangent::new(&run, &columns).unwrap(), None);
    for window in 1.. {
        run.step().unwrap();
        whole.follow(&run).unwrap();
        if let Some((_, rest)) = &mut halves {
            Tangent::follow(rest, &run).unwrap();
        }
        if window == 137 {
            halves = Some((square(&whole, &run), Tangent::new(&run, &columns).unwrap()));
        }
        if run.done() {
            break;
        }
    }
    let (first, rest) = halves.unwrap();
    [square(&whole, &run), square(&rest, &run), first]
}

#[test]
fn a_map_that_begins_inside_a_run_is_the_rest_of_the_whole() {
    // Truth: the chain rule. Columns between windows are those of velocities, also while contacts
    // push, so that parts differ from the whole by roundings: 1e-16 in each of 360 windows, times
    // the condition of the first part, about 1e2.
    for kind in LAWS {
        let chain = lossy::<f64>(kind);
        let run = chain.heterogeneous_collocation(&start(&chain), (0.0, 9.0), crate::windows(360, 12)).unwrap();
        let [whole, rest, first] = parted(run, &free(&chain));
        let off = apart(&(rest * first), &whole);
        println!("{kind:?}: {off:e}");
        assert!(off < 1e-11, "{kind:?}: {off:e}");
    }
}

#[test]
fn a_collision_has_the_tangent_map_of_its_restitution() {
    // Truth: after a collision r(t) = r_0 - e v (t - t_0) with t_0 before by dr/v, so that dr_0
    // becomes -e dr_0, and no velocity. By Liouville the determinant is exp(-contraction). Relative
    // displacements and velocities leave the centre of mass where it is. Measured by DOP853:
    // 5.9e-12. The power 1/4 of time takes shorter windows.
    for (kind, beta, pull) in LAWS {
        for gamma in [1e-3, 0.02, 0.2] {
            let details = Details {
                mass: vec![2.0, 0.5],
                overlap: vec![-0.125],
                dissipation: Some(Dissipation { kind, strength: vec![gamma] }),
                beta,
                pull,
                ..Details::default()
            };
            let bare = Chain::<f64>::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 2).unwrap();
            let (chain, speed) = (bare.with(&details).unwrap(), 0.3);
            let mut y = vec![0.0; chain.layout().dim()];
            y[2] = speed;
            let holds = |name: &str, m: DMatrix<f64>, contraction: f64, bound: f64| {
                let state = Variations::flow(&chain, &y, (0.0, 40.0), &[], 1e-13).unwrap().state;
                let e = (state[3] - state[2]) / speed;
                let off = [m[(0, 0)] + e, m[(1, 0)], m.determinant() / (-contraction).exp() - 1.0];
                println!("{name} {kind:?} {beta} {pull} {gamma}: e {e}, {off:?}");
                assert!(off.iter().all(|off| off.abs() < bound), "{name} {kind:?} {gamma}: {off:?}");
            };
            let mut columns = vec![0.0; 2 * y.len()];
            (columns[0], columns[1]) = (0.2, -0.8);
            (columns[y.len() + 2], columns[y.len() + 3]) = (0.2, -0.8);
            let windows = crate::windows(if beta > 0.0 { 1600 } else { 400 }, 12);
            let (w, contraction) = followed(&chain, &y, 40.0, windows, &columns);
            let (by_place, by_speed) = (&w[..4], &w[y.len()..][..4]);
            let m = [by_place, by_speed].map(|w| [w[0] - w[1], w[2] - w[3]]).concat();
            holds("collocation", DMatrix::from_vec(2, 2, m), contraction, ASKED);
            let rows = [0.2, 0.0, -0.8, 0.0, 0.0, 0.2, 0.0, -0.8];
            let end = Variations::flow(&chain, &y, (0.0, 40.0), &rows, 1e-13).unwrap();
            let w = &end.columns;
            let m = DMatrix::from_row_slice(2, 2, &[w[0] - w[2], w[1] - w[3], w[4] - w[6], w[5] - w[7]]);
            holds("DOP853", m, end.contraction, 1.2e-11);
        }
    }
}

#[test]
fn a_contact_that_pushes_again_before_beads_part_has_its_tangent_map() {
    // Truth: DOP853, to a hundred tolerances of a step and a hundredth of what is asked. The bead
    // is held against the one that is moved, which withdraws and comes back six times.
    let (chain, state) = held(-0.2, 0.05);
    let (y, entries) = (state.as_slice(), [1, 3]);
    let got = collocated(&chain, y, 10.0, crate::windows(500, 12), &entries).0;
    let columns: Vec<f64> = (0..4).flat_map(|i| entries.map(|j| f64::from(i == j))).collect();
    let end = Variations::flow(&chain, y, (0.0, 10.0), &columns, 1e-13).unwrap().columns;
    let want = DMatrix::from_fn(2, 2, |i, j| end[2 * entries[i] + j]);
    let off = apart(&got, &want);
    println!("{off:e}");
    assert!(off < 100.0 * 1e-13 + 0.01 * ASKED, "{off:e}");
}

#[test]
fn beads_that_touch_at_rest_have_it_where_columns_keep_their_overlaps() {
    // Truth: the variational map, whose test compares it with smooth variables. The strike changes
    // no overlap before the wave comes.
    let n = 8;
    for kind in KINDS {
        for gamma in STRENGTHS {
            let (chain, y) = struck::<f64>(n, kind, gamma);
            for t in [1.0, 3.0, 8.0] {
                let control = crate::windows((100.0 * t) as u64, 12);
                let got = followed(&chain, &y, t, control, &units(y.len(), &[n])).0;
                let column: Vec<f64> = (0..2 * n).map(|i| f64::from(i == n)).collect();
                let want = Variations::flow(&chain, &y, (0.0, t), &column, 1e-13).unwrap().columns;
                let off = error(&got[..2 * n], &want);
                assert!(off < ASKED, "{kind:?} {gamma} {t}: {off:e}");
            }
        }
    }
}

#[test]
fn other_columns_of_beads_that_touch_are_left_to_the_variational_map() {
    // Truth: the last two of three beads touch at rest; the last one alone changes their overlap,
    // or its rate. The first is struck, which changes none.
    let fails = |kind, velocities: [f64; 3], column: &[f64], steps: usize| {
        let (chain, mut y) = struck::<f64>(3, kind, 0.3);
        y[3..6].copy_from_slice(&velocities);
        let mut run = chain.heterogeneous_collocation(&y, (0.0, 1.0), crate::windows(10, 12)).unwrap();
        let mut whole = column.to_vec();
        whole.resize(y.len(), 0.0);
        let mut tangent = Tangent::new(&run, &whole).unwrap();
        let followed = (0..steps).try_for_each(|_| {
            run.step().unwrap();
            tangent.follow(&run)
        });
        followed.err().map(|error| error.to_string())
    };
    let strike = [1.0, 0.0, 0.0];
    for kind in KINDS {
        for column in [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 1.0]] {
            let said = fails(kind, strike, &column, 1).unwrap();
            assert!(said.contains("bond = 1") && said.contains("at rest") && said.contains("`Variations`"), "{said}");
        }
        assert!(fails(kind, strike, &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0], 10).is_none());
        assert!(fails(kind, strike, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0], 10).is_none());
    }
    // Beads that touch and approach: only a dashpot has two derivatives by the overlap.
    let (approach, by_overlap) = ([1.0, 0.0, -1.0], [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let said = fails(Kind::Dashpot, approach, &by_overlap, 1).unwrap();
    assert!(said.contains("bond = 0") && said.contains("gap and overlap"), "{said}");
    assert!(fails(Kind::Viscoelastic, approach, &by_overlap, 10).is_none());
    let (chain, y) = struck::<f64>(3, Kind::Viscoelastic, 0.3);
    assert!(chain.monodromy(&y, (0.0, 1.0), crate::windows(10, 12)).is_err());
}
