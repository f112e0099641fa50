//! Springs that are weak for the time of a run, and resonators that are very light or very heavy:
//! every method and every tangent map goes over into what it is without them.

use crate::numbers::distance;
use hertzchain::{
    Run,
    chain::{Boundary, Chain, Details, Drive, DriveKind, Params, Signal, Site, State},
    integrators::collocation::StepControl,
    run::{
        Records,
        method::{Method, Setting},
    },
};

/// Two spheres that meet with the speed 1 each, from a distance of 1, are in contact from 0.5 on
/// for this time, `(a + 1)^{1/(a+1) - 1} B(1/(a+1), 1/2)` with `a = 3/2`.
const CONTACT: f64 = 2.123_131_415_742_144_6;
const END: f64 = 4.0;
/// No event meets a kick.
const STEPS: Setting = Setting::Steps(401);

/// Spring constants down to the smallest number, for which nothing is seen of the springs.
fn weak() -> Vec<f64> {
    let decades = (12..=40).map(|decade| 10f64.powi(-decade));
    decades.chain([1e-60, 1e-100, 1e-154, 1e-200, 1e-290, 1e-300, 5e-324]).collect()
}

fn params(kappa: f64, rho: f64) -> Params {
    Params::new(1.5, kappa, rho).unwrap()
}

fn chain(params: Params) -> Chain<f64> {
    Chain::new(params, Boundary::Free, 2).unwrap()
}

/// The two spheres, with lengths and times in other units. Light resonators fly with the spheres,
/// heavy ones rest at the origin.
fn meeting(chain: &Chain<f64>, [length, time]: [f64; 2]) -> State<f64> {
    let site = |n| {
        let side = if n == 0 { 1.0 } else { -1.0 };
        let [u, u_dot] = [-0.5 * side * length, side * (length / time)];
        let light = if chain.params().rho < 1.0 { 1.0 } else { 0.0 };
        Site { u, v: light * u, u_dot, v_dot: light * u_dot }
    };
    State::from_fn(chain, site).unwrap()
}

/// Positions and velocities of the beads at the end, in these units.
fn end(chain: &Chain<f64>, units: [f64; 2], method: Method, setting: Setting) -> [f64; 4] {
    let run = Run::new(chain.clone(), meeting(chain, units)).until(END * units[1]).unwrap().method(method);
    let y = run.setting(setting).records(Records::End).start().and_then(|run| run.complete()).unwrap().state;
    let (u, u_dot) = (chain.layout().u(&y), chain.layout().u_dot(&y));
    let [length, time] = units;
    [u[0] / length, u[1] / length, u_dot[0] / (length / time), u_dot[1] / (length / time)]
}

fn gap(a: [f64; 4], b: [f64; 4]) -> f64 {
    distance(&a, &b)
}

/// The beads have exchanged their velocities, and fly on from where they met.
fn parted() -> [f64; 4] {
    let far = END - 0.5 - CONTACT;
    [-far, far, -1.0, 1.0]
}

#[test]
fn springs_go_over_into_the_free_flight() {
    // Truth: the closed form without springs, whose forces change it by kappa t^2 at most. With the
    // phasors v/omega as a measure of rounding, 1e-28 lost the contact.
    for rho in [1e-12, 1e-6, 1.0, 1e6, 1e12, f64::INFINITY] {
        for kappa in weak() {
            if params(kappa, rho).validate().is_err() {
                continue;
            }
            let uniform = chain(params(kappa, rho));
            for chain in [&uniform, &differing(&uniform)] {
                let got = end(chain, [1.0; 2], Method::Collocation, Setting::Tolerance(1e-12));
                let off = gap(got, parted());
                assert!(off < 1e-11 + 2.0 * kappa * END * END, "{kappa:e} {rho:e}: {off:e}");
            }
        }
    }
}

#[test]
fn springs_are_weak_for_every_exponent() {
    // Truth: the same without springs. The stiffness at an overlap v/omega would have no bound.
    for alpha in [0.5, 1.0, 3.0, 20.0] {
        let of = |kappa| {
            let chain = chain(Params::new(alpha, kappa, 1.0).unwrap());
            end(&chain, [1.0; 2], Method::Collocation, Setting::Tolerance(1e-12))
        };
        let free = of(0.0);
        for kappa in weak() {
            let off = gap(of(kappa), free);
            assert!(off < 1e-10 + 4.0 * kappa * END * END, "{alpha} {kappa:e}: {off:e}");
        }
    }
}

/// The chain as one whose beads may differ.
fn differing(chain: &Chain<f64>) -> Chain<f64> {
    chain.clone().with(&Details { mass: vec![1.0; 2], ..Details::default() }).unwrap()
}

#[test]
fn every_method_does_without_springs_that_are_too_weak() {
    // Truth: the same method without springs.
    for method in Method::all() {
        let setting = if method.adaptive() { Setting::Tolerance(1e-13) } else { STEPS };
        for of in [Chain::clone, differing] {
            let free = of(&chain(params(0.0, 0.0)));
            if method.runs(&free).is_err() {
                continue;
            }
            let free = end(&free, [1.0; 2], method, setting);
            for kappa in weak().into_iter().step_by(3) {
                let off = gap(end(&of(&chain(params(kappa, 1.0))), [1.0; 2], method, setting), free);
                let bound = 4.0 * kappa * END * END + if method.adaptive() { 1e-9 } else { 1e-12 };
                assert!(off < bound, "{} {kappa:e}: {off:e}", method.name());
            }
        }
    }
}

#[test]
fn contacts_far_shorter_than_a_period_are_contacts() {
    // Truth: the closed form; with a unit of time t the unit of lengths is t^-4. The springs are
    // those of every run, and the impacts are at speeds up to 1e75.
    for time in [1e-3, 1e-6, 1e-9, 1e-12, 1e-15] {
        for (kappa, rho) in [(1.0, 1e-4), (1.0, 1.0), (1.0, f64::INFINITY), (1e-300, 1.0), (5e-324, 1.0)] {
            let units = [f64::powi(time, -4), time];
            let off =
                gap(end(&chain(params(kappa, rho)), units, Method::Collocation, Setting::Tolerance(1e-12)), parted());
            assert!(off < 1e-11 + 2.0 * (END * time).powi(2), "{time:e} {kappa:e} {rho:e}: {off:e}");
        }
    }
}

#[test]
fn damped_and_pushed_sites_go_over_into_sites_without_springs() {
    // Truth: the regularised run without springs.
    let with = |kappa: f64, drag: f64, push: f64| {
        let drive = Drive { site: 0, kind: DriveKind::Force, signal: Signal::sine(push, 0.9, 0.0) };
        let drives = if push > 0.0 { vec![drive] } else { Vec::new() };
        let details = Details { drag: vec![drag, 0.5 * drag], drives, ..Details::default() };
        chain(params(kappa, 1.0)).with(&details).unwrap()
    };
    let tolerance = Setting::Tolerance(1e-12);
    for (drag, push) in [(1e-30, 0.0), (1e-9, 0.0), (0.1, 0.0), (0.0, 0.3), (0.1, 0.3)] {
        let regularised = Method::named("dop853-regularised").unwrap();
        let free = end(&with(0.0, drag, push), [1.0; 2], regularised, tolerance);
        for kappa in weak() {
            let off = gap(end(&with(kappa, drag, push), [1.0; 2], Method::Collocation, tolerance), free);
            assert!(off < 1e-9 + 2.0 * kappa * END * END, "{kappa:e} {drag} {push}: {off:e}");
        }
    }
}

#[test]
fn resonators_go_over_into_none_and_into_fixed_ones() {
    // Truth: the same method with rho = 0 and rho = inf. A light resonator is carried along, with
    // oscillations of a size of rho.
    for method in ["collocation", "strang-linear", "aba1064-linear", "corrected"] {
        let method = Method::named(method).unwrap();
        let setting = if method.adaptive() { Setting::Tolerance(1e-12) } else { STEPS };
        let of = |kappa: f64, rho: f64| end(&chain(params(kappa, rho)), [1.0; 2], method, setting);
        let [none, fixed] = [of(0.0, 0.0), of(1.0, f64::INFINITY)];
        for decade in 1..=12 {
            let (light, heavy) = (10f64.powi(-decade), 10f64.powi(decade));
            let off = [gap(of((1e4 * light).min(1.0), light), none), gap(of(1.0, heavy), fixed)];
            assert!(off.iter().all(|off| *off < 20.0 * light + 1e-10), "{} {light:e}: {off:?}", method.name());
        }
    }
}

/// The derivatives of positions and velocities of the beads at the end by those at the start.
fn parting() -> [[f64; 4]; 4] {
    // The distance at the end is `w (t - c w^{-1/5}) + g` for an approach with speed `w`.
    let (mine, other) = (0.4 * CONTACT, END - 0.4 * CONTACT);
    [[0.0, 1.0, mine, other], [1.0, 0.0, other, mine], [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 0.0]]
}

/// The largest error of the entries of beads in a matrix of derivatives, column by column.
fn off(chain: &Chain<f64>, columns: &[f64]) -> f64 {
    let (dim, half) = (chain.layout().dim(), chain.layout().half());
    let of = [0, 1, half, half + 1];
    let errors = (0..4).map(|i| std::array::from_fn(|j| columns[of[j] * dim + of[i]]));
    errors.zip(parting()).fold(0.0, |most, (got, want)| gap(got, want).max(most))
}

#[test]
fn tangent_maps_go_over_into_those_of_the_free_flight() {
    // Truth: the closed form.
    for rho in [1e-6, 1.0, 1e6, f64::INFINITY] {
        for kappa in weak() {
            if params(kappa, rho).validate().is_err() {
                continue;
            }
            let (chain, by_springs) = (chain(params(kappa, rho)), 4.0 * kappa * END.powi(3));
            let columns = chain
                .monodromy(meeting(&chain, [1.0; 2]).as_slice(), (0.0, END), StepControl::Tolerance(1e-12))
                .unwrap();
            let by_collocation = off(&chain, &columns);
            assert!(by_collocation < 1e-9 + by_springs, "{kappa:e} {rho:e}: {by_collocation:e}");
        }
    }
}

#[test]
fn a_tolerance_of_corrected_splitting_is_met_where_resonators_hardly_move() {
    // Truth: the closed form. Resonators whose spring hardly moves them are the difference of two
    // larger numbers, so that an error relative to their own motion never became small.
    for kappa in [1e-28, 1e-20] {
        let chain = chain(params(kappa, 1.0));
        for (method, tol) in [(Method::CORRECTED, 1e-8), (Method::CORRECTED, 1e-11)] {
            let off = gap(end(&chain, [1.0; 2], method, Setting::Tolerance(tol)), parted());
            assert!(off < 2.0 * tol, "{kappa:e} {tol:e}: {off:e}");
        }
    }
}
