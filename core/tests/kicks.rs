//! Kicks by all ways to make them: one at a time, in rows, one after the other through a long
//! chain, with modified forces, and of those sites only that may be pushed; on every instruction
//! set.

use super::{bits, both_ways, on_every_set};
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

/// Kicks of both flows in rows of so many have the bits of one kick at a time.
fn rows_are_kicks(chain: Chain<f64>, kicks: u32, row: usize, told: &str) {
    let pairs: Vec<_> = (0..kicks).map(|k| (0.01 + 1e-4 * f64::from(k % 3), DoubleDouble::new(0.02))).collect();
    let y: Vec<f64> = (0..chain.layout().dim()).map(|i| (0.7 * (i * i) as f64 + 0.3).sin()).collect();
    let start: Vec<u64> = y.iter().map(|x| x.to_bits()).collect();
    let [got, want] = both_ways(KineticFlow::new(chain.clone()), &y, &pairs, row);
    assert!(got == want && want != start, "kinetic {told}");
    let [got, want] = both_ways(LinearFlow::new(chain), &y, &pairs, row);
    assert!(got == want && want != start, "linear {told}");
}

#[test]
fn kicks_in_rows_have_the_bits_of_one_after_the_other() {
    // Truth: one kick at a time; all lengths around a few registers, and more kicks than there are
    // between two anchors. Of a long chain kicks follow each other: it ends within a register and
    // within a piece, and there are more kicks than follow each other.
    on_every_set(|set| {
        for boundary in Boundary::ALL {
            for (rho, n) in [(0.0, LONG), (1.0 / 3.0, LONG + 13), (f64::INFINITY, LONG + 8192)] {
                let chain = Chain::<f64>::new(Params::new(1.5, 1.0, rho).unwrap(), boundary, n).unwrap();
                rows_are_kicks(chain, 150, 150, &format!("{boundary:?} {rho} {set}"));
            }
            for (n, rho) in (1..36).flat_map(|n| [0.0, 1.0 / 3.0, f64::INFINITY].map(|rho| (n, rho))) {
                let params = Params::new([1.2, 1.5, 2.0, 2.5][n % 4], 1.0, rho).unwrap();
                let Ok(chain) = Chain::<f64>::new(params, boundary, n) else { continue };
                let chain = chain.clone().precompressed(0.1).unwrap_or(chain);
                rows_are_kicks(chain, 70, 40, &format!("{boundary:?} {n} {rho} {set}"));
            }
        }
    });
}

/// What bonds tell after each of some steps, and the final state; each step in one fused pass, or
/// as kick, drift and evaluation. Equal texts are equal numbers.
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

/// Kicks with evaluations in a row, which ends at the first evaluation that has something to tell,
/// against one kick at a time: what it tells of bonds, and the final state. The least number of
/// sites that were awake, and the number of rows that ended with an event.
fn rows_end_with_news(
    (chain, y): &(Chain<f64>, Vec<f64>),
    (step, c, most): (f64, f64, usize),
    told_of: &str,
) -> [usize; 2] {
    let run = || {
        let mut flow = CorrectedSplit::new(LinearFlow::new(chain.clone()));
        flow.load(y);
        flow.prepare(step, 3.0);
        // Until no evaluation has zeros before it.
        (0..3).for_each(|_| flow.evaluate());
        flow.changed(&mut Vec::new());
        flow
    };
    let (mut row, mut one, pairs) = (run(), run(), [(step, DoubleDouble::new(step)); 64]);
    let (mut taken, mut least, mut ends) = (0, chain.sites(), 0);
    while taken < most {
        let made = row.kicks_and_evaluations(&pairs, c, true);
        for k in 0..made {
            one.kick(step, c);
            one.drift(pairs[0].1);
            one.evaluate();
            if k + 1 < made {
                let quiet = told(&mut one);
                assert!(quiet.iter().all(Vec::is_empty), "{told_of}: {quiet:?}");
            }
        }
        (taken, least) = (taken + made, least.min(sites_awake(&row)));
        let news = told(&mut row);
        assert_eq!(news, told(&mut one), "{told_of}");
        ends += usize::from(!news[0].is_empty());
    }
    assert!(bits(&row, y) == bits(&one, y), "{told_of}");
    [least, ends]
}

#[test]
fn what_sleeps_changes_no_bit_and_hides_nothing() {
    // Truth: kick, drift and evaluation of all sites, one after the other.
    on_every_set(|set| {
        for boundary in Boundary::ALL {
            for (n, alpha) in [(5, 1.5), (16, 2.0), (23, 1.5), (50, 1.2), (64, 1.5), (67, 2.5)] {
                let told = format!("{boundary:?} {n} {set}");
                let [_, ends] = rows_end_with_news(&ring(n, alpha, boundary), (0.02, 1e-4, 400), &told);
                assert!(ends > 3, "{told}: {ends} steps with events");
            }
            let mut chains = [(150, 0.0, 1.5), (128, 1.0 / 3.0, 1.5), (161, 0.0, 2.0), (136, 1000.0, 1.2)]
                .map(|(n, rho, alpha)| struck(n, boundary, rho, alpha))
                .to_vec();
            if matches!(boundary, Boundary::Free | Boundary::StrainRing) {
                chains.push(swinging(160, boundary));
            }
            for (k, case) in chains.iter().enumerate() {
                let told = format!("{boundary:?} {k} {set}");
                let [least, _] = rows_end_with_news(case, (STEP, 1e-4, 1200), &told);
                assert!(2 * least < case.0.sites(), "{told}: {least} are awake at least");
            }
        }
    });
}

#[test]
fn corrected_steps_in_rows_are_steps_on_every_instruction_set() {
    // Truth: one step at a time, which wakes all sites, to the bit; with wanted times, and without.
    let moving = |n, boundary, parts| (ring(n, 1.5, boundary), parts, 300, 12.0, vec![0.01, 1.0, 1.02]);
    let asleep = |chain| (chain, Parts::ALL, 1600, 80.0, vec![20.0, 41.3, 80.0]);
    for (k, ((chain, y), parts, steps, end, wanted)) in [
        moving(50, Boundary::StrainRing, Parts::ALL),
        moving(23, Boundary::Ring, Parts::ALL),
        moving(13, Boundary::Free, Parts::PROCESSED),
        moving(9, Boundary::Fixed, Parts::CORRECTED),
        asleep(struck(150, Boundary::Free, 0.0, 1.5)),
        asleep(struck(128, Boundary::Ring, 1.0 / 3.0, 1.5)),
        asleep(struck(161, Boundary::StrainRing, 0.0, 1.5)),
        asleep(cluster(129, 3)),
        asleep(cluster(128, 1)),
        asleep(cluster(130, 126)),
    ]
    .into_iter()
    .enumerate()
    {
        let run = |in_rows: bool| {
            let mut flow = LinearFlow::new(chain.clone());
            flow.load(&y);
            let mut run = Corrected::new(CorrectedSplit::new(flow), (0.0, end), steps, parts).unwrap();
            let mut states = Vec::new();
            for wanted in wanted.iter().copied().map(Some).chain([None]) {
                let until = wanted.unwrap_or(end);
                while run.time() < until - 1e-9 {
                    let before = run.time();
                    // Between steps in rows one by itself.
                    if in_rows && run.stats().steps % 1000 != 700 {
                        run.steps(wanted).unwrap();
                    } else {
                        run.step().unwrap();
                    }
                    assert!(before < until && (run.time() < until + end / steps as f64 || wanted.is_none()));
                }
                let mut state = y.clone();
                run.sample(run.time(), &mut state);
                states.extend(state.into_iter().map(f64::to_bits));
            }
            assert!(run.done());
            states
        };
        let want = run(false);
        on_every_set(|set| assert!(run(true) == want, "{k} {set}"));
    }
}
