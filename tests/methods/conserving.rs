//! Schemes that conserve an energy: what they conserve, their order, what they err.

use crate::numbers::distance;
use hertzchain::chain::{Boundary, Chain, Params};
use hertzchain::integrators::{Silent, Stepper, collocation::StepControl, conserving::DiscreteGradient, drive};

const END: f64 = 20.0;

/// A chain between walls whose beads fly about: contacts begin and end all the time.
fn chain(alpha: f64, rho: f64) -> (Chain<f64>, Vec<f64>) {
    let chain = Chain::new(Params::new(alpha, 1.0, rho).unwrap(), Boundary::Fixed, 5).unwrap();
    let y = (0..chain.layout().dim()).map(|i| 0.4 * (7.0 * i as f64 + 1.0).sin()).collect();
    (chain, y)
}

fn end(mut run: impl Stepper<f64>) -> Vec<f64> {
    let mut y = vec![0.0; run.dim()];
    drive(&mut run, &mut Silent, &mut y).unwrap();
    y
}

#[test]
fn energies_stay_at_rounding_through_a_hundred_thousand_steps() {
    // Truth: the invariants themselves, up to a random walk of two roundings a step. Measured: at
    // most 1.9e-14.
    let steps = 100_000;
    for (alpha, rho) in [(1.5, 0.5), (1.5, 0.0), (2.5, f64::INFINITY), (1.0, 2.0)] {
        let (chain, y0) = chain(alpha, rho);
        let energy = |y: &[f64]| chain.energy(y).total();
        let span = (0.0, 0.02 * steps as f64);
        let mut gradient = DiscreteGradient::new(chain.clone(), &y0, span, steps).unwrap();
        let (start, mut y, mut worst) = (energy(&y0), y0.clone(), 0.0f64);
        for step in 0..steps {
            gradient.step().unwrap();
            if step % 100 == 0 {
                gradient.sample(gradient.time(), &mut y);
                worst = worst.max((energy(&y) / start - 1.0).abs());
            }
        }
        println!("alpha {alpha}, rho {rho}: {worst:e}");
        let rounding = f64::EPSILON * (steps as f64).sqrt();
        assert!(worst < rounding, "alpha {alpha}, rho {rho}: {worst:e}");
    }
}

#[test]
fn it_has_order_two_through_contacts() {
    // Truth: collocation at 1e-12. Contacts do not lower an order of two for alpha > 1. On a ring
    // of strains sites have no momenta of their own; the mean strain keeps some contact closed. Two
    // beads that fly at each other touch once.
    let ring = Chain::new(Params::new(1.5, 1.0, 0.5).unwrap(), Boundary::StrainRing, 5).unwrap();
    let (walls, y0) = chain(1.5, 0.5);
    let pressed = y0.iter().enumerate().map(|(i, y)| if i < 10 { y - 0.3 } else { *y }).collect();
    let pair = Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 2).unwrap();
    for (chain, y0) in [(walls, y0), (ring, pressed), (pair, vec![0.0, 0.5, 0.6, -0.4])] {
        let truth = end(chain.collocation(&y0, (0.0, END), StepControl::Tolerance(1e-12)).unwrap());
        let run = |steps| DiscreteGradient::new(chain.clone(), &y0, (0.0, END), steps).unwrap();
        let [coarse, fine] = [4_000, 64_000].map(|steps| distance(&end(run(steps)), &truth));
        let order = (coarse / fine).log2() / 4.0;
        println!("{:?}: {coarse:e} -> {fine:e}: {order}", chain.boundary());
        assert!((1.8..2.2).contains(&order), "{coarse:e} -> {fine:e}: {order}");
    }
}

#[test]
fn a_sample_inside_a_step_is_as_good_as_the_run() {
    // Truth: collocation. Samples at thirds of steps err as the ends do.
    let (chain, y0) = chain(1.5, 0.5);
    let (steps, t) = (4_000, END - END / 12_000.0);
    let truth = end(chain.collocation(&y0, (0.0, t), StepControl::Tolerance(1e-12)).unwrap());
    let mut run = DiscreteGradient::new(chain.clone(), &y0, (0.0, END), steps).unwrap();
    let at_end = end(chain.collocation(&y0, (0.0, END), StepControl::Tolerance(1e-12)).unwrap());
    while !run.done() {
        run.step().unwrap();
    }
    let mut y = y0.clone();
    run.sample(END, &mut y);
    let error = distance(&y, &at_end);
    run.sample(t, &mut y);
    assert!(distance(&y, &truth) < 1.5 * error, "{:e}, at the end {error:e}", distance(&y, &truth));
}

#[test]
fn steps_that_do_not_resolve_contacts_are_refused() {
    // Sweeps over bonds converge where a step resolves the stiffness of contacts.
    let (chain, y0) = chain(1.5, 0.5);
    let y0: Vec<f64> = y0.iter().map(|y| 1e6 * y).collect();
    let mut run = DiscreteGradient::new(chain, &y0, (0.0, END), 2).unwrap();
    let why = (0..2).find_map(|_| run.step().err()).map(|error| error.to_string());
    assert!(why.is_some_and(|why| why.contains("did not settle")), "an error says why");
}
