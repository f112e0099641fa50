//! The loop over steps, and landings.

use hertzchain_integrators::{
    Splitting, Stepper,
    splitting::{First, tables},
};
use own_hamiltonian::Pendulum;

#[allow(dead_code, reason = "its main is an example")]
#[path = "../examples/own_hamiltonian.rs"]
mod own_hamiltonian;

#[test]
fn steps_in_a_row_are_steps_and_none_leads_beyond_what_is_wanted() {
    // Truth: one step at a time, to the bit; times between steps, at their ends, and none.
    for (scheme, first) in
        [(tables::STRANG, First::Kick), (tables::STRANG, First::Drift), (tables::ABA864, First::Drift)]
    {
        let run = || Splitting::new(&scheme, first, Pendulum([1.0, 0.3]), (0.5, 7.5), 700).unwrap();
        let (mut row, mut one) = (run(), run());
        for wanted in [Some(0.52), Some(0.525), Some(1.5), Some(2.0), Some(2.003), None, None, Some(7.5)] {
            loop {
                row.steps(wanted).unwrap();
                let before = 0.5 + (row.stats().steps - 1) as f64 * 0.01;
                assert!(wanted.is_none_or(|t| before < t - 1e-12), "{wanted:?} {before}");
                if wanted.is_none_or(|t| row.time() > t - 1e-12) {
                    break;
                }
            }
            while one.stats().steps < row.stats().steps {
                one.step().unwrap();
            }
            let state = |run: &mut Splitting<f64, Pendulum>| {
                let mut y = [0.0; 2];
                run.sample(run.time(), &mut y);
                y
            };
            assert_eq!(state(&mut row), state(&mut one));
            assert_eq!((row.time(), row.stats()), (one.time(), one.stats()));
        }
        assert!(row.done() && row.stats().force_evaluations >= 699);
    }
}
