//! The plain loops: they are the methods that they stand beside.

use hertzchain::{
    Boundary, Chain, Method, Params, Run, Setting, State,
    plain::{Loop, Sites},
};

/// Truth: the same schemes in the library, on every boundary and model, through contacts. A step
/// rounds differently, and 200 steps carry that along: measured at most 4e-14.
#[test]
fn a_plain_loop_is_the_scheme_it_stands_beside() {
    let boundaries = Boundary::ALL;
    for boundary in boundaries {
        for (alpha, kappa, rho) in [(1.5, 1.0, 0.5), (1.5, 0.0, 0.0), (1.5, 2.0, f64::INFINITY), (2.0, 1.0, 3.0)] {
            let chain = Chain::new(Params::new(alpha, kappa, rho).unwrap(), boundary, 7).unwrap();
            let held = [Boundary::Fixed, Boundary::Ring].contains(&boundary);
            let chain = if held { chain.precompressed(0.1).unwrap() } else { chain };
            let mut state = State::rest(&chain);
            state.u_mut().iter_mut().enumerate().for_each(|(i, u)| *u = 0.4 * (7.0 * i as f64 + 1.0).sin());
            let names = ["verlet", "strang-linear", "yoshida4", "yoshida4-linear"];
            for (plain, name) in Loop::ALL.into_iter().zip(names) {
                let (end, steps) = (10.0, 200);
                let method = Method::named(name).unwrap();
                let run = Run::new(chain.clone(), state.clone()).until(end).unwrap().method(method);
                let ours = run.setting(Setting::Steps(steps)).start().unwrap().state;
                let mut sites = Sites::new(&chain, state.as_slice());
                plain.run(&mut sites, end / steps as f64, steps);
                let gaps = sites.state().iter().zip(&ours).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(gaps < 1e-13, "{boundary:?}, alpha {alpha}, rho {rho}, {name}: {gaps:e}");
            }
        }
    }
}
