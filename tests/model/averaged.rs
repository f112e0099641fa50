//! Splitting with treatment of events: averaged kicks, and steps that end on contacts.

use hertzchain::{
    chain::{Boundary, Chain, Field, LinearFlow, Overlaps, Params, Site, State},
    integrators::{
        Regularised, Scheme, Silent, SplitFlow, Splitting, Stepper,
        dop853::Options,
        drive,
        splitting::{Averaged, First, Landed, tables::*},
    },
    study::generic_state,
};

fn chain((kappa, rho): (f64, f64), boundary: Boundary, sites: usize) -> Chain<f64> {
    Chain::new(Params::new(1.5, kappa, rho).unwrap(), boundary, sites).unwrap()
}

fn averaged(chain: &Chain<f64>, scheme: &Scheme, y0: &[f64], end: f64, steps: u64) -> Vec<f64> {
    let mut flow = Averaged::new(LinearFlow::new(chain.clone()));
    flow.load(y0);
    finish(&mut Splitting::new(scheme, First::Drift, flow, (0.0, end), steps).unwrap(), y0)
}

fn landed(chain: &Chain<f64>, scheme: &Scheme, y0: &[f64], end: f64, steps: u64) -> Vec<f64> {
    finish(&mut landed_run(chain, scheme, y0, end, steps), y0)
}

fn landed_run(chain: &Chain<f64>, scheme: &Scheme, y0: &[f64], end: f64, steps: u64) -> Landed<f64, LinearFlow<f64>> {
    let mut flow = LinearFlow::new(chain.clone());
    flow.load(y0);
    Landed::new(scheme, First::Drift, flow, (0.0, end), steps).unwrap()
}

fn finish(run: &mut impl Stepper<f64>, y0: &[f64]) -> Vec<f64> {
    let mut y = y0.to_vec();
    drive(run, &mut Silent, &mut y).unwrap();
    y
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn reversed(mut y: Vec<f64>) -> Vec<f64> {
    let half = y.len() / 2;
    y[half..].iter_mut().for_each(|velocity| *velocity = -*velocity);
    y
}

#[test]
fn averaged_kicks_run_back_to_where_they_came_from() {
    // Several models and boundaries, with about ten contacts each.
    for (springs, boundary) in [
        ((1.0, 1.0 / 3.0), Boundary::Free),
        ((1.0, 1.0 / 3.0), Boundary::Fixed),
        ((0.0, 0.0), Boundary::Ring),
        ((1.0, f64::INFINITY), Boundary::Free),
        ((1.0, 2.0), Boundary::StrainRing),
    ] {
        let chain = chain(springs, boundary, 5);
        let site = |n: usize| {
            let x = n as f64;
            Site { u: 0.2 * (2.0 * x).sin(), v: 0.0, u_dot: (5.0 * x + 1.0).sin(), v_dot: 0.0 }
        };
        let y0 = State::from_fn(&chain, site).unwrap().as_slice().to_vec();
        for scheme in [&STRANG, &YOSHIDA4] {
            let there = averaged(&chain, scheme, &y0, 5.0, 100);
            let back = reversed(averaged(&chain, scheme, &reversed(there), 5.0, 100));
            assert!(distance(&back, &y0) < 5e-15, "{} {boundary:?}: {:e}", scheme.name, distance(&back, &y0));
        }
    }
}

/// `max |J^T Omega J - Omega|` of a map of the plain chain, by central differences.
fn symplectic_defect(map: impl Fn(&[f64]) -> Vec<f64>, y0: &[f64]) -> f64 {
    let (n, d) = (y0.len(), 1e-5);
    let column = |j: usize| -> Vec<f64> {
        let shifted = |by: f64| {
            let mut y = y0.to_vec();
            y[j] += by;
            map(&y)
        };
        shifted(d).iter().zip(shifted(-d)).map(|(a, b)| (a - b) / (2.0 * d)).collect()
    };
    let jacobian: Vec<Vec<f64>> = (0..n).map(column).collect();
    let form = |a: &[f64], b: &[f64]| -> f64 { (0..n / 2).map(|i| a[i] * b[n / 2 + i] - a[n / 2 + i] * b[i]).sum() };
    let unit = |i: usize| -> Vec<f64> { (0..n).map(|k| f64::from(u8::from(k == i))).collect() };
    let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    pairs.map(|(i, j)| (form(&jacobian[i], &jacobian[j]) - form(&unit(i), &unit(j))).abs()).fold(0.0, f64::max)
}

#[test]
fn averaged_kicks_are_symplectic_and_landed_steps_are_not() {
    // Truth: the definition. The remainder is the rounding of the differences.
    let chain = chain((0.0, 0.0), Boundary::Free, 3);
    let y0 = [-0.3, 0.0, 0.4, 1.0, -0.1, -0.7];
    let one_contact = |steps| averaged(&chain, &YOSHIDA4, &y0, 0.5, steps);
    assert!(distance(&one_contact(5), &y0) > 0.1);
    for steps in [1, 5, 20] {
        let defect = symplectic_defect(|y| averaged(&chain, &YOSHIDA4, y, 0.5, steps), &y0);
        assert!(defect < 5e-11, "{steps} steps: {defect:e}");
    }
    let defect = symplectic_defect(|y| landed(&chain, &STRANG, y, 0.5, 5), &y0);
    assert!(defect > 1e-4, "{defect:e}");
}

#[test]
fn an_averaged_kick_is_the_integral_of_the_force() {
    // A plain pair and one Strang step in which it closes: J = w^alpha tau^{alpha+1}/(alpha+1) with
    // the time in contact tau, up to the effect of the impulse itself (of relative size tau^{5/2}).
    let chain = chain((0.0, 0.0), Boundary::Free, 2);
    let (w, h) = (1.0, 1e-3);
    for gap in [0.2e-3, 0.5e-3, 0.9e-3] {
        let y = averaged(&chain, &STRANG, &[-gap, 0.0, w, 0.0], h, 1);
        let tau = h - gap / w;
        let impulse = tau.powf(2.5) / 2.5;
        assert!((y[3] / impulse - 1.0).abs() < 5e-9, "{:e} {impulse:e}", y[3]);
        // The sampled kick is zero unless the contact is closed at half the step.
        let mut flow = LinearFlow::new(chain.clone());
        flow.load(&[-gap, 0.0, w, 0.0]);
        let sampled = finish(&mut Splitting::new(&STRANG, First::Drift, flow, (0.0, h), 1).unwrap(), &[0.0; 4]);
        assert!((sampled[3] / impulse - 1.0).abs() > 0.1);
    }
}

#[test]
fn landed_steps_end_on_the_events_and_on_the_end() {
    // Truth: the events of the regularised method.
    let chain = chain((1.0, 1.0 / 3.0), Boundary::Free, 6);
    let y0 = generic_state(&chain).unwrap().as_slice().to_vec();
    let (field, overlaps) = (Field::new(chain.clone()), Overlaps::new(chain.clone()));
    let mut truth = Regularised::new(field, overlaps, (1.5, 2), &y0, (0.0, 12.0), Options::new(1e-12)).unwrap();
    let mut times = Vec::new();
    while !truth.done() {
        truth.step().unwrap();
        times.extend(truth.events().iter().map(|event| event.t));
    }
    assert_eq!(times.len(), 12);
    let mut run = landed_run(&chain, &ABA1064, &y0, 12.0, 1000);
    let mut ends = Vec::new();
    while !run.done() {
        run.step().unwrap();
        ends.push(run.time());
    }
    assert_eq!(*ends.last().unwrap(), 12.0);
    assert!((1000..=1013).contains(&ends.len()), "{}", ends.len());
    for t in times {
        assert!(ends.iter().any(|end| (end - t).abs() < 3e-9), "no step ends at {t}");
    }
    // A sample inside a step does not change the run and is as accurate as the run.
    let mut y = y0.clone();
    truth.sample(12.0, &mut y);
    assert!(distance(&landed(&chain, &ABA1064, &y0, 12.0, 1000), &y) < 4e-10);
}

#[test]
fn averaged_kicks_keep_the_order_of_a_composition_where_nothing_opens() {
    // Slope 4 on a precompressed chain, against itself on a finer ladder.
    let chain = chain((0.0, 0.0), Boundary::Fixed, 4).precompressed(0.5).unwrap();
    let y0 = [0.02, -0.03, 0.01, 0.04, 0.1, -0.05, 0.07, 0.02];
    let end = |steps| averaged(&chain, &YOSHIDA4, &y0, 3.0, steps);
    let truth = end(1600);
    let (coarse, fine) = (distance(&end(50), &truth), distance(&end(100), &truth));
    let slope = (coarse / fine).log2();
    assert!((slope - 4.0).abs() < 0.2, "{slope}");
}
