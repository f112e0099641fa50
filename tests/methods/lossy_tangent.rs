//! The tangent map where contacts dissipate, by regularised DOP853.

use crate::{
    numbers::{direction, error},
    variations::{DIFFERENCES, LAWS, applied, free, lossy, monodromy, start},
};
use hertzchain::chain::{Boundary, Chain, Details, Dissipation, Params, Variations};
use nalgebra::DMatrix;

#[test]
fn it_agrees_with_differences_in_double_double() {
    // Truth: the differences of `variations.rs`, of the order 1e-12 by the step, 1e-11 by a
    // division.
    for (kind, truth) in LAWS.into_iter().zip(&*DIFFERENCES) {
        let chain = lossy::<f64>(kind);
        let (y, w) = (start(&chain), direction(free(&chain).len(), 0));
        let errors = [1e-6, 1e-8, 1e-10, 1e-12].map(|tol| error(&applied(&monodromy(&chain, &y, 9.0, tol), &w), truth));
        assert!(errors[3] < 1e-9, "{kind:?} {errors:?}");
        for pair in errors.windows(2) {
            assert!(pair[1] < (0.1 * pair[0]).max(1e-10), "{kind:?} {errors:?}");
        }
    }
}

#[test]
fn determinants_are_liouvilles() {
    // Truth: det = exp(int div dt): that of drag and dashpots of resonators is constant, that of
    // contacts an integral along the run. Measured: 7.9e-11, where ln det is -16.
    let resonators = 0.2 / 0.5 + 0.2 / 2.0 + 0.05 / 1.5 + 0.2 / 0.7 + 0.07 + 0.1 / (0.5 * 0.5) + 0.05 / 0.3;
    for kind in LAWS {
        let (chain, t) = (lossy::<f64>(kind), 9.0);
        let y = start(&chain);
        let contraction = Variations::flow(&chain, &y, (0.0, t), &[], 1e-13).unwrap().contraction;
        let off = monodromy(&chain, &y, t, 1e-12).determinant().ln() + t * resonators + contraction;
        assert!(off.abs() < 2e-10 && contraction > 0.5, "{kind:?}: {off:e}");
    }
}

#[test]
fn a_collision_has_the_tangent_map_of_its_restitution() {
    // Truth: after a collision r(t) = r_0 - e v (t - t_0) with t_0 before by dr/v, so that dr_0
    // becomes -e dr_0, and no velocity. By Liouville the determinant is exp(-contraction). Relative
    // displacements and velocities leave the centre of mass where it is. Measured: 5.9e-12.
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
            let rows = [0.2, 0.0, -0.8, 0.0, 0.0, 0.2, 0.0, -0.8];
            let end = Variations::flow(&chain, &y, (0.0, 40.0), &rows, 1e-13).unwrap();
            let (w, e) = (&end.columns, (end.state[3] - end.state[2]) / speed);
            let m = DMatrix::from_row_slice(2, 2, &[w[0] - w[2], w[1] - w[3], w[4] - w[6], w[5] - w[7]]);
            let off = [m[(0, 0)] + e, m[(1, 0)], m.determinant() / (-end.contraction).exp() - 1.0];
            println!("{kind:?} {beta} {pull} {gamma}: e {e}, {off:?}");
            assert!(off.iter().all(|off| off.abs() < 1.2e-11), "{kind:?} {gamma}: {off:?}");
        }
    }
}
