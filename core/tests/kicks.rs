//! Kicks by all ways to make them: one at a time, in rows, one after the other through a long chain,
//! with modified forces, and of those sites only that may be pushed; on every instruction set.

use super::{both_ways, on_every_set};
use hertzchain_core::{
    Boundary, Chain, Params,
    chain::{CorrectedSplit, Field, KineticFlow, LinearFlow},
    internals::sites_awake,
};
use hertzchain_integrators::{
    DoubleDouble, SplitFlow, Stepper, VectorField,
    splitting::corrected::{BondFlow, Corrected, Parts},
};

/// Least number of sites of a chain whose kicks follow each other.
const LONG: usize = 1 << 16;

/// The bonds that have changed their sides, and those that have turned near zero.
fn told(flow: &mut CorrectedSplit) -> [Vec<(usize, bool)>; 2] {
    let mut told = [Vec::new(), Vec::new()];
    flow.changed(&mut told[0]);
    flow.turned(&mut told[1]);
    told
}

#[test]
fn a_pass_is_the_topology_site_by_site() {
    // Truth: overlaps and pushes as `topology` has them, one number at a time, to the bit; all
    // lengths around one register and two, all boundaries, and every way to compute a power.
    for boundary in Boundary::ALL {
        for (n, alpha) in (1..20).flat_map(|n| [0.5, 1.2, 1.5, 2.0, 3.5, 5.0].map(|alpha| (n, alpha))) {
            let Ok(chain) = Chain::<f64>::new(Params::new(alpha, 0.0, 0.0).unwrap(), boundary, n) else { continue };
            let chain = chain.clone().precompressed(0.1).unwrap_or(chain);
            let y: Vec<f64> = (0..chain.layout().dim()).map(|i| (0.7 * (i * i) as f64).sin()).collect();
            let (topology, law, delta) = (chain.topology(), chain.law(), chain.precompression());
            let force = |b| [law.force(delta + topology.across(b, |i| [y[i]])[0])];
            let want: Vec<f64> = (0..n).map(|i| topology.push(i, force)[0]).collect();
            on_every_set(|set| {
                let mut dy = y.clone();
                Field::new(chain.clone()).eval(0.0, &y, &mut dy);
                assert_eq!(dy[n..], want, "{boundary:?} {n} {alpha} {set}");
            });
        }
    }
}

#[test]
fn kicks_that_follow_each_other_have_the_bits_of_one_after_the_other() {
    // Truth: one kick at a time; a chain that ends within a register and within a piece, more
    // kicks than follow each other or than there are between two anchors.
    let pairs: Vec<_> = (0..150).map(|k| (0.01 + 1e-4 * f64::from(k % 3), DoubleDouble::new(0.02))).collect();
    on_every_set(|set| {
        for boundary in Boundary::ALL {
            for (rho, n) in [(0.0, LONG), (1.0 / 3.0, LONG + 13), (f64::INFINITY, LONG + 8192)] {
                let chain = Chain::<f64>::new(Params::new(1.5, 1.0, rho).unwrap(), boundary, n).unwrap();
                let y: Vec<f64> = (0..chain.layout().dim()).map(|i| (0.7 * (i * i) as f64).sin()).collect();
                let start: Vec<u64> = y.iter().map(|x| x.to_bits()).collect();
                let [got, want] = both_ways(KineticFlow::new(chain.clone()), &y, &pairs, pairs.len());
                assert!(got == want && want != start, "kinetic {boundary:?} {rho} {set}");
                let [got, want] = both_ways(LinearFlow::new(chain), &y, &pairs, pairs.len());
                assert!(got == want && want != start, "linear {boundary:?} {rho} {set}");
            }
        }
    });
}

#[test]
fn kicks_in_rows_have_the_bits_of_one_after_the_other() {
    // Truth: one kick at a time; all lengths around a few registers, and more kicks than there
    // are between two anchors.
    let pairs: Vec<_> = (0..70).map(|k| (0.01 + 1e-4 * f64::from(k % 3), DoubleDouble::new(0.02))).collect();
    on_every_set(|set| {
        for boundary in Boundary::ALL {
            for (n, rho) in (1..36).flat_map(|n| [0.0, 1.0 / 3.0, f64::INFINITY].map(|rho| (n, rho))) {
                let params = Params::new([1.2, 1.5, 2.0, 2.5][n % 4], 1.0, rho).unwrap();
                let Ok(chain) = Chain::<f64>::new(params, boundary, n) else { continue };
                let chain = chain.clone().precompressed(0.1).unwrap_or(chain);
                let y: Vec<f64> = (0..chain.layout().dim()).map(|i| (0.7 * (i * i) as f64 + 0.3).sin()).collect();
                let [got, want] = both_ways(KineticFlow::new(chain.clone()), &y, &pairs, 40);
                assert!(got == want, "kinetic {boundary:?} {n} {rho} {set}");
                let [got, want] = both_ways(LinearFlow::new(chain), &y, &pairs, 40);
                assert!(got == want, "linear {boundary:?} {n} {rho} {set}");
            }
        }
    });
}

/// What bonds tell after each of some steps, and the final state; each step in one fused pass, or as
/// kick, drift and evaluation. Equal texts are equal numbers.
fn steps(flow: LinearFlow<f64>, y: &[f64], fused: bool) -> Vec<String> {
    let (mut flow, mut out) = (CorrectedSplit::new(flow), Vec::new());
    flow.load(y);
    flow.prepare(0.02, 3.0);
    flow.evaluate();
    for k in 0..70 {
        let (kick, c, drift) = (0.01 + 1e-4 * f64::from(k % 3), 1e-3, DoubleDouble::new(0.02));
        if fused {
            flow.kicks_and_evaluations(&[(kick, drift)], c, false);
        } else {
            flow.kick(kick, c);
            flow.drift(drift);
            flow.evaluate();
        }
        out.extend(told(&mut flow).map(|bonds| format!("{bonds:?}")));
        out.extend((0..flow.bonds()).map(|b| format!("{:?} {:?}", flow.force(b), flow.path(b))));
    }
    let mut end = y.to_vec();
    flow.store(&mut end);
    out.push(format!("{end:?}"));
    out
}

#[test]
fn a_kick_that_evaluates_has_the_bits_of_one_thing_after_the_other() {
    // Truth: kick, drift and evaluation, each in a pass of its own.
    on_every_set(|set| {
        for boundary in Boundary::ALL {
            for (n, rho) in (1..36).chain([63, 64, 65, 130]).flat_map(|n| [0.0, 1.0 / 3.0].map(|rho| (n, rho))) {
                let params = Params::new([1.2, 1.5, 2.0, 2.5][n % 4], 1.0, rho).unwrap();
                let Ok(chain) = Chain::<f64>::new(params, boundary, n) else { continue };
                let y: Vec<f64> = (0..chain.layout().dim()).map(|i| (0.7 * (i * i) as f64 + 0.3).sin()).collect();
                let of = |fused| steps(LinearFlow::new(chain.clone()), &y, fused);
                assert!(of(true) == of(false), "linear {boundary:?} {n} {rho} {set}");
            }
        }
    });
}

/// A ring of beads in motion whose contacts open and close, on the linear split.
fn ring(n: usize, alpha: f64, boundary: Boundary) -> (Chain<f64>, Vec<f64>) {
    let chain = Chain::<f64>::new(Params::new(alpha, 1.0, 1.0 / 3.0).unwrap(), boundary, n).unwrap();
    let y = (0..chain.layout().dim()).map(|i| 0.3 * (0.7 * (i * i) as f64 + 0.3).sin()).collect();
    (chain, y)
}

#[test]
fn kicks_in_a_row_end_at_the_first_evaluation_that_has_something_to_tell() {
    // Truth: one kick at a time, and what it tells of bonds; the state at the end of each row.
    on_every_set(|set| {
        for boundary in Boundary::ALL {
            for (n, alpha) in [(5, 1.5), (16, 2.0), (23, 1.5), (50, 1.2), (64, 1.5), (67, 2.5)] {
                let (chain, y) = ring(n, alpha, boundary);
                let run = || {
                    let mut flow = CorrectedSplit::new(LinearFlow::new(chain.clone()));
                    flow.load(&y);
                    flow.prepare(0.02, 3.0);
                    flow.evaluate();
                    flow.changed(&mut Vec::new());
                    flow
                };
                let (mut row, mut one) = (run(), run());
                let pairs = vec![(0.02, DoubleDouble::new(0.02)); 40];
                let (mut taken, mut ends) = (0, 0);
                while taken < 400 {
                    let made = row.kicks_and_evaluations(&pairs, 1e-4, true);
                    for k in 0..made {
                        one.kick(0.02, 1e-4);
                        one.drift(DoubleDouble::new(0.02));
                        one.evaluate();
                        if k + 1 < made {
                            let quiet = told(&mut one);
                            assert!(quiet.iter().all(Vec::is_empty), "{boundary:?} {n} {set} {quiet:?}");
                        }
                    }
                    let news = told(&mut row);
                    assert_eq!(news, told(&mut one), "{boundary:?} {n} {set}");
                    let bond = |flow: &CorrectedSplit, b| (flow.path(b).overlap, flow.force(b));
                    assert!((0..row.bonds()).all(|b| bond(&row, b) == bond(&one, b)));
                    ends += usize::from(!news[0].is_empty());
                    taken += made;
                }
                assert!(ends > 3, "{boundary:?} {n}: {ends} steps with events");
            }
        }
    });
}

#[test]
fn corrected_steps_in_a_row_are_steps_on_every_instruction_set() {
    // Truth: one step at a time, to the bit; with wanted times, and without.
    for (n, boundary, parts) in [
        (50, Boundary::StrainRing, Parts::ALL),
        (23, Boundary::Ring, Parts::ALL),
        (13, Boundary::Free, Parts::PROCESSED),
        (9, Boundary::Fixed, Parts::CORRECTED),
    ] {
        let (chain, y) = ring(n, 1.5, boundary);
        let run = |in_rows: bool| {
            let mut flow = LinearFlow::new(chain.clone());
            flow.load(&y);
            let mut run = Corrected::new(CorrectedSplit::new(flow), (0.0, 12.0), 300, parts).unwrap();
            let mut states = Vec::new();
            for wanted in [Some(0.01), Some(1.0), Some(1.02), None] {
                let until = wanted.unwrap_or(12.0);
                while run.time() < until - 1e-9 {
                    let before = run.time();
                    if in_rows {
                        run.steps(wanted).unwrap()
                    } else {
                        run.step().unwrap()
                    }
                    assert!(before < until && (run.time() < until + 0.04 || wanted.is_none()));
                }
                let mut state = y.clone();
                run.sample(run.time(), &mut state);
                states.extend(state.into_iter().map(f64::to_bits));
            }
            assert!(run.done());
            states
        };
        let want = run(false);
        on_every_set(|set| assert!(run(true) == want, "{boundary:?} {set}"));
    }
}

/// A chain in which two beads near the ends move towards them, so that pulses reach the ends,
/// or pass them on a ring. For `alpha = 2` all beads fly apart as well.
fn struck(n: usize, boundary: Boundary, rho: f64, alpha: f64) -> (Chain<f64>, Vec<f64>) {
    let chain = Chain::<f64>::new(Params::new(alpha, 1.0, rho).unwrap(), boundary, n).unwrap();
    let mut y = vec![0.0; chain.layout().dim()];
    let velocities = y.len() / 2;
    (y[velocities + n - 12], y[velocities + 5]) = (0.9, -0.4);
    if alpha == 2.0 {
        // A velocity that grows along the chain.
        (0..n).for_each(|i| y[velocities + i] += 1e-3 * i as f64);
    }
    (chain, y)
}

/// The chain of [`struck`] with gaps, in which each bead swings against its resonator with a
/// phase of its own.
fn swinging(n: usize, boundary: Boundary) -> (Chain<f64>, Vec<f64>) {
    let rho = 1.0 / 3.0;
    let (chain, mut y) = struck(n, boundary, rho, 1.5);
    for i in 0..n {
        let phase = (i * i) as f64;
        let centre = if boundary == Boundary::StrainRing { 0.02 } else { 0.02 * i as f64 };
        let (p, p_dot) = (0.004 * phase.sin(), 0.008 * phase.cos());
        (y[i], y[n + i]) = (centre + p, centre - p / rho);
        y[2 * n + i] += p_dot;
        y[3 * n + i] -= p_dot / rho;
    }
    (chain, y)
}

/// A ring without resonators: the 20 bonds after site `first` are closed, the others are open,
/// and all beads have the same velocity.
fn cluster(n: usize, first: usize) -> (Chain<f64>, Vec<f64>) {
    let chain = Chain::<f64>::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Ring, n).unwrap();
    let (mut y, mut u) = (vec![-0.3; 2 * n], 0.0);
    for i in first..first + n {
        y[i % n] = u;
        u += if i < first + 20 { -0.03 } else { 0.6 / (n as f64 - 20.0) };
    }
    (chain, y)
}

const STEP: f64 = 0.05;

#[test]
fn what_sleeps_changes_no_bit_and_hides_nothing() {
    // Truth: kick, drift and evaluation of all sites, one after the other.
    on_every_set(|set| {
        for boundary in Boundary::ALL {
            let mut chains = [(150, 0.0, 1.5), (128, 1.0 / 3.0, 1.5), (161, 0.0, 2.0), (136, 1000.0, 1.2)]
                .map(|(n, rho, alpha)| struck(n, boundary, rho, alpha))
                .to_vec();
            if matches!(boundary, Boundary::Free | Boundary::StrainRing) {
                chains.push(swinging(160, boundary));
            }
            for (k, (chain, y)) in chains.into_iter().enumerate() {
                let n = chain.sites();
                let run = || {
                    let mut flow = CorrectedSplit::new(LinearFlow::new(chain.clone()));
                    flow.load(&y);
                    flow.prepare(STEP, 3.0);
                    // Until no evaluation has zeros before it.
                    (0..3).for_each(|_| flow.evaluate());
                    flow.changed(&mut Vec::new());
                    flow
                };
                let (mut row, mut one, pairs) = (run(), run(), [(STEP, DoubleDouble::new(STEP)); 64]);
                let (mut taken, mut least) = (0, n);
                while taken < 1200 {
                    let made = row.kicks_and_evaluations(&pairs, 1e-4, true);
                    for _ in 0..made {
                        one.kick(STEP, 1e-4);
                        one.drift(pairs[0].1);
                        one.evaluate();
                    }
                    (taken, least) = (taken + made, least.min(sites_awake(&row)));
                    let [mut told, mut want] = [vec![], vec![]];
                    row.changed(&mut told);
                    one.changed(&mut want);
                    assert_eq!(told, want, "{boundary:?} {k} {set}");
                    let [mut told, mut want] = [vec![], vec![]];
                    row.turned(&mut told);
                    one.turned(&mut want);
                    assert_eq!(told, want, "{boundary:?} {k} {set}: turns");
                }
                let [got, want] = [&row, &one].map(|flow| {
                    let mut state = y.clone();
                    flow.store(&mut state);
                    state.into_iter().map(f64::to_bits).collect::<Vec<_>>()
                });
                assert!(got == want, "{boundary:?} {k} {set}");
                assert!(2 * least < n, "{boundary:?} {k}: {least} are awake at least");
            }
        }
    });
}

#[test]
fn corrected_runs_have_the_bits_of_steps_that_keep_all_awake() {
    // Truth: one step at a time, which wakes all sites.
    let chains = [
        struck(150, Boundary::Free, 0.0, 1.5),
        struck(128, Boundary::Ring, 1.0 / 3.0, 1.5),
        struck(161, Boundary::StrainRing, 0.0, 1.5),
        cluster(129, 3),
        cluster(128, 1),
        cluster(130, 126),
    ];
    for (k, (chain, y)) in chains.into_iter().enumerate() {
        let run = |in_rows: bool| {
            let mut flow = LinearFlow::new(chain.clone());
            flow.load(&y);
            let mut run = Corrected::new(CorrectedSplit::new(flow), (0.0, 80.0), 1600, Parts::ALL).unwrap();
            let mut states = Vec::new();
            for wanted in [20.0, 41.3, 80.0] {
                while run.time() < wanted - 1e-9 {
                    // Between steps in rows one by itself.
                    if in_rows && run.stats().steps % 1000 != 700 {
                        run.steps(Some(wanted)).unwrap();
                    } else {
                        run.step().unwrap();
                    }
                }
                let mut state = y.clone();
                run.sample(run.time(), &mut state);
                states.extend(state.into_iter().map(f64::to_bits));
            }
            states
        };
        let want = run(false);
        on_every_set(|set| assert!(run(true) == want, "{k} {set}"));
    }
}
