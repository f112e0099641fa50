//! One long chain on several threads.

use super::bits;
use hertzchain_core::{
    Boundary, Chain, Method, Params, Run, Setting, State,
    chain::KineticFlow,
    parts::{GHOSTS, Parted},
    run::Records,
};
use hertzchain_integrators::{DoubleDouble, SplitFlow};

/// The entries of a state that moves everywhere.
fn moving(chain: &Chain<f64>) -> State<f64> {
    let mut state = State::rest(chain);
    state.as_mut_slice().iter_mut().enumerate().for_each(|(i, y)| *y = 0.3 * (0.7 * (i * i) as f64).sin());
    state
}

/// A run that is sampled between its steps, of a chain that moves everywhere.
fn run(boundary: Boundary, (alpha, rho): (f64, f64), sites: usize, name: &str) -> Run {
    let chain = Chain::new(Params::new(alpha, 1.0, rho).unwrap(), boundary, sites).unwrap();
    let chain = chain.clone().precompressed(0.05).unwrap_or(chain);
    let state = moving(&chain);
    let run = Run::new(chain, state).until(5.0).unwrap().method(Method::named(name).unwrap());
    run.setting(Setting::Steps(70)).records(Records::Profiles).samples_at(&[0.0, 0.1, 2.003, 2.01, 5.0]).unwrap()
}

/// What must not depend on the number of threads.
fn outcome(run: &Run) -> (Vec<f64>, Vec<Vec<f64>>, String) {
    let end = run.start().unwrap();
    assert!(end.failure.is_none(), "{:?}", end.failure);
    let states = end.profiles.into_iter().map(|profile| profile.state).collect();
    (end.state, states, format!("{:?} {:?} {:?} {:?}", end.samples, end.energy_error, end.stats, end.contacts))
}

fn holds(run: &Run, counts: &[usize]) {
    let whole = outcome(run);
    for &count in counts {
        let chain = run.chain();
        let told = format!("{:?} {:?} {} {count}", chain.boundary(), chain.params(), chain.sites());
        assert!(outcome(&run.clone().threads(count)) == whole, "{told}");
    }
}

#[test]
fn threads_have_the_bits_of_one() {
    // Truth: the same run on one thread, to the bit, with samples inside steps and energies. Parts
    // longer than two zones of ghosts, shorter ones, and those of one or two sites.
    for boundary in Boundary::ALL {
        for model in [(1.5, 1.0 / 3.0), (1.5, 0.0), (2.0, f64::INFINITY)] {
            for name in ["verlet", "strang-linear", "aba864-linear", "yoshida4"] {
                holds(&run(boundary, model, 3 * GHOSTS + 41, name), &[1, 2, 3, 7]);
                holds(&run(boundary, model, 9, name), &[2, 3, 7, 9]);
            }
        }
    }
    holds(&run(Boundary::Ring, (1.5, 1.0), 2, "verlet"), &[1, 2]);
    holds(&run(Boundary::Free, (1.5, 1.0), 1, "strang-linear"), &[1]);
    holds(&run(Boundary::Fixed, (1.5, 1.0), 20, "strang-linear").contacts(), &[3]);
}

/// The bits of a state after 150 kicks.
fn kicked(mut flow: impl SplitFlow<f64>, y: &[f64]) -> Vec<u64> {
    flow.load(y);
    flow.kick_drifts(&[(0.01, DoubleDouble::new(0.02)); 150]);
    bits(&flow, y)
}

#[test]
fn a_chain_that_is_long_enough_for_threads_has_the_bits_of_one() {
    // Truth: the flow of the whole chain. Kicks of fewer sites are made without threads.
    let chain = Chain::new(Params::new(1.5, 1.0, 0.4).unwrap(), Boundary::Ring, 20_000).unwrap();
    let y = moving(&chain);
    let whole = kicked(KineticFlow::new(chain.clone()), y.as_slice());
    assert!(kicked(Parted::<KineticFlow<f64>>::new(&chain, 2), y.as_slice()) == whole);
    assert!(y.as_slice().iter().map(|x| x.to_bits()).ne(whole));
}

#[test]
fn only_splitting_schemes_and_collocation_run_on_several_threads() {
    for method in Method::all() {
        let name = method.name();
        let run = run(Boundary::Ring, (1.5, 1.0), 40, &name);
        let run = if method.tolerant() { run.tolerance(1e-6).unwrap() } else { run };
        if matches!(method, Method::Splitting(..) | Method::Collocation) {
            holds(&run, &[3]);
            continue;
        }
        for run in [run.clone(), run.contacts()] {
            let refused = run.threads(3).start().unwrap_err().to_string();
            assert!(refused.contains("only splitting schemes"), "{name}: {refused}");
        }
    }
    let refused = |count| run(Boundary::Free, (1.5, 0.0), 5, "verlet").threads(count).start().unwrap_err().to_string();
    assert_eq!(refused(0), "threads = 0 is not valid: from 1 to 1024 threads");
    assert!(refused(6).contains("at most as many threads as sites") && refused(1025).contains("1024"));
}
