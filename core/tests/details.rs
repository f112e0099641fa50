//! Beads that differ: signals of drives, the motion of damped sites, the loops over sites.

use super::on_every_set;
use hertzchain_core::{
    Boundary, Chain, Params, State,
    chain::{Course, Details, Drive, DriveKind, Envelope, Harmonic, Signal, SitewiseFlow, Spline, Split},
};
use hertzchain_integrators::{DoubleDouble, SplitFlow};
use std::sync::Arc;

fn signals() -> Vec<Signal> {
    let harmonics = vec![
        Harmonic { amplitude: 0.7, omega: 1.3, phase: 0.4 },
        Harmonic { amplitude: -0.2, omega: 3.1, phase: 2.0 },
        Harmonic { amplitude: 0.5, omega: 0.0, phase: 1.0 },
    ];
    let envelopes = [Envelope::None, Envelope::Ramp(2.0), Envelope::Burst { start: 0.5, length: 3.0 }];
    envelopes.map(|envelope| Signal::new(harmonics.clone(), envelope)).to_vec()
}

fn courses() -> [Signal; 4] {
    let chirp = Course::Chirp { amplitude: -0.4, omega: [3.0, 0.5], phase: 0.7, start: 0.8, length: 1.7 };
    let values = (0..20).map(|k| (0.31 * f64::from(k)).sin()).collect();
    let spline = Spline::new((0..20).map(|k| 0.21 * f64::from(k) + 1e-3 * f64::from(k * k)).collect(), values);
    let [none, ramp, burst] = signals().try_into().unwrap();
    [
        Signal { course: Some(Course::Steady { velocity: -0.3 }), ..ramp },
        Signal { course: Some(chirp), ..none },
        Signal { course: Some(Course::Table(Arc::new(spline.unwrap()))), ..burst },
        Signal { envelope: Envelope::HalfSine { start: 0.5, length: 3.0 }, ..Signal::constant(2.0) },
    ]
}

#[test]
fn a_chirp_passes_through_its_frequencies() {
    // Truth: the integral of the frequency by hand. From 0 to 0.8 it is 3; then it falls to 0.5
    // over 1.7, mean 1.75; then it is 0.5.
    let [_, chirp, ..] = courses();
    let chirp = Signal { harmonics: vec![], ..chirp };
    for (t, theta) in [(0.4, 0.7 + 1.2_f64), (0.8, 0.7 + 2.4), (2.5, 3.1 + 1.7 * 1.75), (4.5, 3.1 + 1.7 * 1.75 + 1.0)] {
        assert!((chirp.at(t)[0] + 0.4 * theta.sin()).abs() < 1e-15, "{t}");
    }
    assert!((chirp.at(1.65)[1] + 0.4 * 1.75 * (3.1f64 + 0.85 * (3.0 + 1.75) / 2.0).cos()).abs() < 1e-15);
}

#[test]
fn derivatives_are_those_of_the_signal() {
    // Truth: central differences, whose error is h^2/6 times a derivative of size 10.
    for signal in signals().into_iter().chain(courses()) {
        for k in 0..80 {
            let (t, h) = (0.05 * f64::from(k) + 0.013, 1e-5);
            let [_, first, second] = signal.at(t);
            let ([s0, d0, _], [s1, d1, _]) = (signal.at(t - h), signal.at(t + h));
            assert!((first - (s1 - s0) / (2.0 * h)).abs() < 1e-8, "{:?} {t}", signal.envelope);
            assert!((second - (d1 - d0) / (2.0 * h)).abs() < 1e-7, "{:?} {t}", signal.envelope);
            assert!(signal.at(t)[0].abs() <= signal.size());
        }
    }
}

#[test]
fn envelopes_join_what_is_around_them() {
    // Truth: the values at the joints; three derivatives vanish there, so that a distance x
    // away they differ by 35 x^4, and a burst by 256 x^4.
    let [_, ramp, burst] = signals().try_into().unwrap();
    let bare = Signal { envelope: Envelope::None, ..ramp.clone() };
    assert_eq!(ramp.at(0.0), [0.0; 3]);
    assert_eq!(ramp.at(2.0), bare.at(2.0));
    let difference = (ramp.at(2.0 - 1e-3)[0] - bare.at(2.0 - 1e-3)[0]).abs();
    assert!(difference <= 35.0 * 5e-4f64.powi(4) * bare.size(), "{difference:e}");
    assert_eq!((burst.at(0.5), burst.at(3.5), burst.at(9.0)), ([0.0; 3], [0.0; 3], [0.0; 3]));
    assert!((burst.at(2.0)[0] - bare.at(2.0)[0]).abs() < 1e-15);
    assert!(burst.at(0.5 + 3e-3)[0].abs() <= 256.0 * 1e-12 * bare.size());
}

#[test]
fn it_errs_by_the_fourth_power_of_the_intervals() {
    // Truth: the sine, also at uneven times.
    let off = |n: u32, uneven: f64| {
        let t: Vec<f64> = (0..=n).map(|k| 3.0 * f64::from(k) / f64::from(n)).collect();
        let t: Vec<f64> = t.iter().map(|t| t + uneven * (5.0 * t).sin() / f64::from(n)).collect();
        let spline = Spline::new(t.clone(), t.iter().map(|t| t.sin()).collect()).unwrap();
        let all = (0..1000).map(|k| t[0] + (t[n as usize] - t[0]) * f64::from(k) / 999.0);
        all.map(|t| (spline.at(t)[0] - t.sin()).abs()).fold(0.0, f64::max)
    };
    for uneven in [0.0, 0.4] {
        let order = (off(128, uneven) / off(256, uneven)).log2();
        assert!((order - 4.0).abs() < 0.25, "{uneven} {order}");
    }
}

#[test]
fn it_is_zero_where_values_are_zero_for_long() {
    // Truth: the values; without the cut it falls to 1e-170 there, and states to subnormal
    // numbers.
    let value = |k: i32| if (300..350).contains(&k) { f64::from(k - 300).sin() } else { 0.0 };
    let spline = Spline::new((0..1000).map(f64::from).collect(), (0..1000).map(value).collect()).unwrap();
    assert_eq!([0.5, 100.3, 260.7, 600.1, 998.5].map(|t| spline.at(t)), [[0.0; 3]; 5]);
    assert!(spline.at(298.5)[0].abs() > 1e-3);
}

#[test]
fn few_values_are_met_by_a_line_a_parabola_and_a_cubic() {
    // Truth: the polynomials themselves.
    let t = [0.0, 0.4, 1.0, 1.1];
    for n in 2..=4 {
        let of = |t: f64| (0..n as i32).map(|k| t.powi(k) / f64::from(k + 1)).sum::<f64>();
        let spline = Spline::new(t[..n].to_vec(), t[..n].iter().map(|&t| of(t)).collect()).unwrap();
        for x in [-0.1, 0.2, 0.9] {
            assert!((spline.at(x)[0] - of(x)).abs() < 1e-14, "{n} {x}");
        }
    }
}

/// A bead of mass 1.7 with a spring of 2.3 to a resonator, and what damps them.
struct Site {
    drag: f64,
    dashpot: f64,
    rho: f64,
}

impl Site {
    /// The flow of this site alone between kicks.
    fn flow(&self) -> SitewiseFlow<f64> {
        let chain = Chain::new(Params::new(1.5, 1.0, self.rho).unwrap(), Boundary::Free, 1).unwrap();
        let Self { drag, dashpot, rho } = *self;
        let of = |number| vec![number];
        let details = Details { mass: of(1.7), kappa: of(2.3), rho: of(rho), ..Details::default() };
        let details = Details { drag: of(drag), dashpot: of(if rho == 0.0 { 0.0 } else { dashpot }), ..details };
        SitewiseFlow::new(chain.with(&details).unwrap(), Split::Linear, 0.0)
    }

    fn energy(&self, [u, v, u_dot, v_dot]: [f64; 4]) -> f64 {
        let resonator = if self.rho.is_finite() { 1.7 * self.rho } else { 0.0 };
        0.5 * (1.7 * u_dot * u_dot + resonator * v_dot * v_dot + 2.3 * (u - v) * (u - v))
    }

    /// `[u, v, u', v']` after the time `dt`, and what is dissipated; if `repeated`, by the motion
    /// that a flow keeps for a time that comes again.
    fn moved(&self, [u, v, u_dot, v_dot]: [f64; 4], dt: f64, repeated: bool) -> ([f64; 4], f64) {
        let (mut flow, moves, dt) = (self.flow(), self.rho > 0.0 && self.rho.is_finite(), DoubleDouble::new(dt));
        let mut y = if moves { vec![u, v, u_dot, v_dot] } else { vec![u, u_dot] };
        y.resize(flow.dim(), 0.0);
        if repeated {
            flow.load(&y);
            (0..2).for_each(|_| flow.drift(dt));
        }
        flow.load(&y);
        flow.drift(dt);
        flow.store(&mut y);
        let (at, rest) = if moves { y.split_at(4) } else { y.split_at(2) };
        (if moves { [at[0], at[1], at[2], at[3]] } else { [at[0], 0.0, at[1], 0.0] }, rest.iter().sum())
    }
}

#[test]
fn a_bead_without_a_resonator_feels_no_spring() {
    // Truth: u' = u0' e^{-c t/m}, whatever its spring constant.
    let bead = Site { drag: 0.9, dashpot: 0.0, rho: 0.0 };
    let (after, _) = bead.moved([0.3, 0.0, -0.8, 0.0], 1.3, true);
    assert!((after[2] + 0.8 * (-0.9f64 * 1.3 / 1.7).exp()).abs() < 1e-15, "{after:?}");
}

#[test]
fn what_is_dissipated_is_what_the_energy_lacks() {
    // Truth: the balance of energy; forwards and backwards, short and long.
    let z = [0.3, -0.4, 0.7, 1.1];
    for (drag, dashpot) in [(0.9, 0.0), (0.0, 0.6), (0.5, 0.2)] {
        for rho in [0.4, 1e-3] {
            let own = Site { drag, dashpot, rho };
            for dt in [0.01, 1.3, -0.2] {
                let (after, lost) = own.moved(z, dt, true);
                let balance = own.energy(after) + lost - own.energy(z);
                let scale = own.energy(after).max(own.energy(z));
                // Each doubling of times of half the inverse of the largest rate may double a
                // rounding; a light resonator needs 13 of them.
                let norm = 2.0 * 2.3 / (1.7 * rho) + 2.0 * dashpot / (1.7 * rho);
                let doublings = (norm * dt.abs() / 0.5).log2().ceil().max(0.0);
                let bound = 1.1e-16 * (500.0 + 2f64.powf(doublings)) * scale;
                assert!(balance.abs() < bound, "{drag} {dashpot} {rho} {dt}: {balance:e}");
                assert!(lost * dt > 0.0);
            }
        }
    }
}

#[test]
fn a_motion_that_is_not_repeated_is_that_of_the_matrices() {
    // Truth: another method. Of matrices each doubling may double a rounding, of 2^k short times
    // each adds one.
    let z = [0.3, -0.4, 0.7, 1.1];
    for (drag, dashpot) in [(0.0, 0.0), (0.9, 0.0), (0.0, 0.6), (0.5, 0.2), (1e-6, 30.0)] {
        for rho in [0.4, 0.01, 1e-3, f64::INFINITY, 0.0] {
            let own = Site { drag, dashpot, rho };
            // Backwards, strong damping is growth beyond any number.
            let back = if dashpot > 1.0 { 1e-2 } else { -0.2 };
            for dt in [1e-3, 0.2, 1.3, back, 20.0] {
                let [(by_series, lost), (by_matrix, want)] = [false, true].map(|repeated| own.moved(z, dt, repeated));
                let rate = 2.0 * (2.3 + dashpot) / 1.7 * (1.0 + if rho.is_normal() { 1.0 / rho } else { 0.0 });
                let parts = (1.0 + (rate + drag) * dt.abs()) / 0.5;
                let size = by_matrix.iter().fold(1.0, |most: f64, z| most.max(z.abs()));
                let bound = 4.0 * f64::EPSILON * (1.0 + parts) * size * size;
                for (got, want) in by_series.into_iter().zip(by_matrix).chain([(lost, want)]) {
                    assert!((got - want).abs() < bound, "{drag} {dashpot} {rho} {dt}: {:e} of {bound:e}", got - want);
                }
            }
        }
    }
}

#[test]
fn without_damping_matrix_and_modes_agree_and_go_back() {
    // Truth: two ways to the same motion; the motion reversed. Each of the five doublings may
    // double the rounding of the matrix, 2^5 1.1e-16 of entries up to 2.
    for rho in [0.4, f64::INFINITY] {
        let [own, almost] = [0.0, 1e-300].map(|drag| Site { drag, dashpot: 0.0, rho });
        let z = if rho.is_finite() { [0.3, -0.4, 0.7, 1.1] } else { [0.3, 0.0, 0.7, 0.0] };
        let [(by_modes, _), (by_matrix, _)] = [own.moved(z, 1.9, true), almost.moved(z, 1.9, true)];
        let back = own.moved(by_modes, -1.9, true).0;
        for k in 0..4 {
            assert!((by_modes[k] - by_matrix[k]).abs() < 8e-15 && (back[k] - z[k]).abs() < 1e-15, "{rho} {k}");
        }
    }
}
/// Beads of all kinds of motion, in ranges of lengths that no register divides.
fn mixed(boundary: Boundary, alpha: Vec<f64>) -> Chain<f64> {
    let n = 29;
    let of = |f: &dyn Fn(usize) -> f64| (0..n).map(f).collect::<Vec<f64>>();
    let signal = Signal::sine(0.1, 1.3, 0.0);
    let details = Details {
        mass: of(&|i| 0.5 + (i * 7 % 5) as f64 / 4.0),
        rho: of(&|i| {
            if i == 0 || i % 9 == 4 {
                0.0
            } else if i % 11 == 5 {
                f64::INFINITY
            } else {
                0.4
            }
        }),
        dashpot: of(&|i| if (14..17).contains(&i) { 0.1 } else { 0.0 }),
        alpha,
        drives: vec![Drive { site: 0, kind: DriveKind::Displacement, signal }],
        ..Details::default()
    };
    Chain::new(Params::new(1.5, 1.0, 0.4).unwrap(), boundary, n).unwrap().with(&details).unwrap()
}

fn after(chain: &Chain<f64>, split: Split) -> Vec<u64> {
    let mut state = State::rest(chain);
    (0..29).for_each(|i| state.u_dot_mut()[i] = ((i * i) as f64 * 0.7).sin());
    let mut flow = SitewiseFlow::new(chain.clone(), split, 0.0);
    flow.load(state.as_slice());
    (0..200).for_each(|_| flow.kick_drift(0.05, DoubleDouble::new(0.05)));
    let mut y = vec![0.0; flow.dim()];
    flow.store(&mut y);
    y.into_iter().map(f64::to_bits).collect()
}

#[test]
fn all_instruction_sets_and_single_laws_give_the_same_bits() {
    for boundary in Boundary::ALL.into_iter().filter(|&boundary| boundary != Boundary::StrainRing) {
        let chain = mixed(boundary, Vec::new());
        let bonds = chain.touching().len();
        for split in [Split::Linear, Split::Kinetic] {
            let mut first = None;
            on_every_set(|set| {
                let got = after(&chain, split);
                assert_eq!(first.get_or_insert_with(|| got.clone()), &got, "{boundary:?} {split:?} {set:?}");
            });
            // One contact that never closes has another exponent: no contact is computed beside
            // others then.
            let mut apart = vec![1.5; bonds];
            apart[bonds - 1] = 2.0;
            let mut details = chain.details().unwrap().clone();
            details.alpha = apart;
            details.overlap = vec![0.0; bonds];
            details.overlap[bonds - 1] = -1e3;
            let plain = Details { alpha: Vec::new(), ..details.clone() };
            let base = Chain::new(Params::new(1.5, 1.0, 0.4).unwrap(), boundary, 29).unwrap();
            let [one, other] = [plain, details].map(|details| after(&base.clone().with(&details).unwrap(), split));
            assert_eq!(one, other, "{boundary:?} {split:?}");
        }
    }
}
