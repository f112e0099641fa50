//! Signals of drives that are not smooth at some times: all methods see them, wherever they are.

use crate::common::{distance, largest};
use hertzchain::{
    chain::{
        Boundary, Chain, Course, Details, Drive, DriveKind, Envelope, Harmonic, Params, Signal, Spline, State,
        Variations,
    },
    run::{Method, Records, Run, Setting, Trajectory, Warning},
    scene::Scene,
};
use hertzchain_integrators::Stepper;
use std::{
    f64::consts::{FRAC_2_PI, FRAC_PI_2, TAU},
    sync::Arc,
};

fn sine(amplitude: f64, omega: f64, phase: f64) -> Harmonic {
    Harmonic { amplitude, omega, phase }
}

/// Every kind of signal; those with an envelope of no length below 0.1 come first.
fn signals() -> Vec<Signal> {
    let several = vec![sine(0.2, 1.3, 0.4), sine(-0.1, 7.0, 2.0), sine(0.1, 0.0, 1.0)];
    let constant = vec![sine(0.3, 0.0, FRAC_PI_2)];
    // Frequencies and phases that fill a band and a turn evenly.
    let noise = (0..64).map(|k| sine(0.04, 1.0 + f64::from(k) / 8.0, TAU * (0.618_034 * f64::from(k)).fract()));
    let burst = |start, length| Envelope::Burst { start, length };
    let of = |course, envelope| Signal { harmonics: vec![], course: Some(course), envelope };
    let values: Vec<f64> = (0..40).map(|k| 0.2 * (0.7 * f64::from(k)).sin()).collect();
    let table = Spline::new((0..40).map(|k| 0.25 * f64::from(k)).collect(), values).unwrap();
    let chirp = Course::Chirp { amplitude: 0.3, omega: [4.0, 0.5], phase: 0.2, start: 1.0, length: 5.0 };
    vec![
        Signal::new(several.clone(), Envelope::Ramp(0.8)),
        Signal::new(several.clone(), burst(6.0, 0.3)),
        Signal::new(noise.collect(), burst(6.0, 1.5)),
        Signal::new(constant.clone(), burst(6.0, 1.0)),
        Signal::new(constant, Envelope::Ramp(2.0)),
        of(Course::Table(Arc::new(table)), Envelope::Ramp(0.8)),
        of(chirp, Envelope::Ramp(0.8)),
        Signal::new(several.clone(), burst(6.0, 1e-3)),
        Signal::new(several, Envelope::Ramp(1e-3)),
    ]
}

const LONG: usize = 7;
const END: f64 = 9.0;

/// Three beads that touch, those without a drive with resonators, and one drive.
fn chain(boundary: Boundary, kind: DriveKind, signal: Signal) -> Chain<f64> {
    let uniform = Chain::new(Params::new(1.5, 1.0, 0.5).unwrap(), boundary, 3).unwrap();
    let drives = vec![Drive { site: 0, kind, signal }];
    let details = Details { kappa: vec![0.0, 1.0, 1.0], rho: vec![0.0, 0.5, 0.5], drives, ..Details::default() };
    uniform.with(&details).unwrap()
}

fn named(name: &str) -> Method {
    Method::named(name).unwrap()
}

/// A run from rest, up to [`END`].
fn from_rest(chain: &Chain<f64>, method: Method, setting: Setting) -> Run {
    let rest = State::rest(chain).driven(chain);
    Run::new(chain.clone(), rest).until(END).unwrap().method(method).setting(setting)
}

/// The states at some times, one after the other; times are ends of steps and inside steps.
fn states(run: &Run) -> Vec<f64> {
    let times = [0.7, 6.0, 6.0007, 6.21, 7.9, END];
    run.at(&times).unwrap().flat_map(|state| state.unwrap().as_slice().to_vec()).collect()
}

#[test]
fn methods_that_choose_their_steps_see_every_drive_of_a_chain_at_rest() {
    // Truth: collocation at a tolerance of 1e-13, whose drives are series. A signal that is passed
    // over costs all of it, 1e-4 at least. The unit is that of the tolerance, the size of the drive
    // or of the state; the bound is 10^4 times the tolerance of a step. No such bound is known for
    // dop853, which crosses contacts: it must meet the motion to a thousandth. Before, the two that
    // stop at events missed all late bursts, and all three failed on short ramps. The errors of the
    // first steps of the regularised one underflow where an overlap grows like t^6.
    let adaptive = ["dop853", "dop853-landed", "dop853-regularised", "collocation"].map(named);
    for boundary in [Boundary::Free, Boundary::Fixed, Boundary::Ring, Boundary::LeftWall, Boundary::RightWall] {
        for (k, signal) in signals().into_iter().enumerate() {
            // Tables and chirps at one wall only.
            if (5..LONG).contains(&k) && boundary != Boundary::RightWall {
                continue;
            }
            for kind in [DriveKind::Displacement, DriveKind::Force] {
                let chain = chain(boundary, kind, signal.clone());
                let want = states(&from_rest(&chain, Method::Collocation, Setting::Tolerance(1e-13)));
                let moves = largest(want.iter().copied());
                let unit = moves.max(signal.size());
                assert!(moves > 1e-4, "{boundary:?} {k} {kind:?}: nothing moves");
                for method in adaptive {
                    let run = from_rest(&chain, method, Setting::Tolerance(1e-11));
                    let got = states(&run);
                    let off = distance(&got, &want) / unit;
                    println!("{boundary:?} signal {k} {kind:?} {}: {off:e}", method.name());
                    let bound = if method == named("dop853") { 1e-3 * moves / unit } else { 1e-7 };
                    assert!(off < bound, "{boundary:?} signal {k} {kind:?} {}: {off:e}", method.name());
                }
                // So does the field of the tangent map, whose steps cross contacts of moved beads.
                let rest = State::rest(&chain).driven(&chain);
                let got = Variations::flow(&chain, rest.as_slice(), (0.0, END), &[], 1e-11).unwrap().state;
                let off = distance(&got, &want[want.len() - got.len()..]) / moves;
                assert!(off < 1e-5, "{boundary:?} signal {k} {kind:?}: {off:e}");
            }
        }
    }
}

#[test]
fn noise_has_the_size_of_harmonics_without_a_common_phase() {
    // Truth: a tolerance of 1e-13. With the sum of the amplitudes the state was off by 2e-5.
    let changes = [
        "chain.sites=2",
        "chain.boundary=left-wall",
        "bonds={alpha=1.2,contact=[1.5,2.2],overlap=[-0.06,-0.01]}",
        "beads.mass=[0.33,1.2]",
        "initial.velocity=0.0",
        "drive=[{site=0,kind=\"moved\",amplitude=0.105,band=[0.5,3.0],seed=24}]",
    ];
    let scene = Scene::load_with("impact", &changes.map(str::to_owned)).unwrap();
    let run = Run::new(scene.chain().clone(), State::rest(scene.chain()).driven(scene.chain())).until(5.1).unwrap();
    let [loose, want] = [1e-6, 1e-13]
        .map(|tol| run.clone().method(Method::Collocation).setting(Setting::Tolerance(tol)).start().unwrap().state);
    assert!(distance(&loose, &want) < 1e-6, "{:e}", distance(&loose, &want));
}

#[test]
fn equal_steps_see_every_drive_that_they_resolve() {
    // Truth: collocation. Bounds: c (h/L)^2 of order two for bursts of length L = 0.3, and of
    // contacts that begin, h^2.5, for the others, with h = 1e-2.
    let boundaries = [Boundary::Free, Boundary::Fixed, Boundary::Ring];
    let setting = Setting::steps(END / 1e-2).unwrap();
    for (k, signal) in signals().into_iter().take(LONG).enumerate() {
        for (m, kind) in [DriveKind::Displacement, DriveKind::Force].into_iter().enumerate() {
            let chain = chain(boundaries[(k + m) % 3], kind, signal.clone());
            let run = |method, setting| from_rest(&chain, method, setting).records(Records::End).start().unwrap();
            let want = run(Method::Collocation, Setting::Tolerance(1e-12)).state;
            let fixed = Method::all()
                .into_iter()
                .filter(|method| !method.adaptive() && method.unsupported_reason(&chain).is_none());
            for method in fixed {
                let done = run(method, setting);
                let off = distance(&done.state, &want) / largest(want.iter().copied());
                let bound = if method.info().order == 2 { 4e-2 } else { 1e-3 };
                assert!(off < bound, "signal {k} {kind:?} {}: {off:e}", method.name());
                assert!(done.warnings.iter().all(Warning::fatal), "{:?}", done.warnings);
            }
        }
    }
}

/// `int_0^t (t - s) F(s) ds`, the displacement by a force, by Simpson's rule between its breaks.
fn pushed_to(signal: &Signal, t: f64) -> f64 {
    let (from, to) = match signal.envelope {
        Envelope::None => (0.0, t),
        Envelope::Ramp(ramp) => (0.0, ramp.min(t)),
        Envelope::Burst { start, length } | Envelope::HalfSine { start, length } => (start, start + length),
    };
    let simpson = |from: f64, to: f64| {
        let parts = 4000;
        let h = (to - from) / f64::from(parts);
        let term = |k: i32| {
            let (s, weight) =
                (from + h * f64::from(k), if k == 0 || k == parts { 1.0 } else { f64::from(2 + 2 * (k % 2)) });
            weight * (t - s) * signal.at(s)[0]
        };
        h / 3.0 * (0..=parts).map(term).sum::<f64>()
    };
    let rest = if matches!(signal.envelope, Envelope::Ramp(_)) { simpson(to, t) } else { 0.0 };
    simpson(from, to) + rest
}

#[test]
fn a_pushed_bead_moves_by_the_double_integral_of_its_force() {
    // Truth: closed forms of constant forces: a burst (4x(1-x))^4 has the integral 256 B(5, 5) =
    // 128/315 and its centroid in the middle, a half-sine has 2/pi; a ramp has the integrals 1/2
    // and 5/36. For the others the double integral by a quadrature. What the force has done is
    // energy.
    let alone = Chain::<f64>::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 1).unwrap();
    let mut all = signals();
    let half_sine = Envelope::HalfSine { start: 1.1, length: 2.0 };
    all.insert(5, Signal { envelope: half_sine, ..Signal::constant(0.3) });
    for (k, signal) in all.into_iter().enumerate() {
        let want = match (k, signal.envelope) {
            (3, Envelope::Burst { start, length }) => 0.3 * length * (128.0 / 315.0) * (END - start - 0.5 * length),
            (5, Envelope::HalfSine { start, length }) => 0.3 * length * FRAC_2_PI * (END - start - 0.5 * length),
            (4, Envelope::Ramp(ramp)) => {
                let left = END - ramp;
                0.3 * (ramp * ramp * (5.0 / 36.0) + 0.5 * ramp * left + 0.5 * left * left)
            }
            _ => pushed_to(&signal, END),
        };
        let drives = vec![Drive { site: 0, kind: DriveKind::Force, signal }];
        let chain = alone.clone().with(&Details { drives, ..Details::default() }).unwrap();
        for method in Method::all().into_iter().filter(|method| method.unsupported_reason(&chain).is_none()) {
            let (setting, bound) = match method.adaptive() {
                true => (Setting::Tolerance(1e-12), 1e-9),
                false if k > LONG => continue,
                false => (Setting::steps(END / 1e-2).unwrap(), if method.info().order == 2 { 4e-2 } else { 1e-3 }),
            };
            let state = from_rest(&chain, method, setting).records(Records::End).start().unwrap().state;
            let (got, energy) = (state[0], chain.energy(&state));
            let off = (got - want).abs() / want.abs();
            assert!(off < bound, "signal {k} {}: {got} for {want}, {off:e}", method.name());
            let bound = if method.adaptive() { 1e-9 } else { 2e-3 };
            assert!((energy.total() - energy.driven).abs() < bound, "signal {k} {}: {energy:?}", method.name());
        }
    }
}

#[test]
fn steps_end_at_the_knots_of_tables_and_at_starts_and_ends() {
    // Truth: the times given. At this tolerance no step would end there by chance.
    let (knots, start, end) = (vec![0.0, 0.71, 1.93, 3.37, 5.29, 6.13, END], 1.37, 5.53);
    let values = knots.iter().map(|t| 0.1 * (2.0 * t).sin()).collect();
    let table = Course::Table(Arc::new(Spline::new(knots.clone(), values).unwrap()));
    let chirp = Course::Chirp { amplitude: 0.1, omega: [1.0, 2.0], phase: 0.3, start, length: end - start };
    let of = |course| Signal { harmonics: vec![], course: Some(course), envelope: Envelope::None };
    let burst = Envelope::Burst { start, length: end - start };
    let within = Signal { envelope: burst, ..of(table.clone()) };
    for (signal, breaks) in [
        (of(table), knots[1..6].to_vec()),
        (within, [&knots[1..6], &[start, end]].concat()),
        (of(chirp), vec![start, end]),
        (Signal::new(vec![sine(0.1, 1.0, 0.3)], Envelope::Ramp(end)), vec![end]),
    ] {
        for kind in [DriveKind::Displacement, DriveKind::Force] {
            let chain = chain(Boundary::Free, kind, signal.clone());
            let by_tolerance = ["dop853", "dop853-landed", "dop853-regularised", "collocation"];
            let by_tolerance = by_tolerance.map(|name| (name, Setting::Tolerance(1e-4)));
            for (name, setting) in by_tolerance {
                let mut stepper = from_rest(&chain, named(name), setting).stepper().unwrap();
                let mut ends = Vec::new();
                while !stepper.done() {
                    stepper.step().unwrap();
                    ends.push(stepper.time());
                }
                for t in &breaks {
                    let near = ends.iter().any(|end| (end - t).abs() < 1e-12);
                    assert!(near, "{name}, {kind:?}: no step ends at {t}, {} steps", ends.len());
                }
            }
        }
    }
}

#[test]
fn a_run_that_starts_later_goes_on_with_its_drives() {
    // Truth: the run in one piece. Runs of the two parts are off by the errors of both; drives that
    // began anew would change the state by about their size.
    for (k, signal) in signals().into_iter().enumerate() {
        let chain = chain(Boundary::Free, DriveKind::Displacement, signal);
        for (method, setting) in [
            (Method::Collocation, Setting::Tolerance(1e-12)),
            (named("dop853"), Setting::Tolerance(1e-12)),
            (named("strang-linear"), Setting::Steps(400_000)),
        ] {
            // The way of a time from a step to a signal is the same for all signals.
            if !method.adaptive() && k != 3 {
                continue;
            }
            let whole = from_rest(&chain, method, setting).start().unwrap();
            let first = from_rest(&chain, method, setting).until(2.3).unwrap().start().unwrap();
            let mut middle = State::rest(&chain);
            middle.as_mut_slice().copy_from_slice(&first.state);
            let rest = Run::new(chain.clone(), middle).until(END).unwrap().starting_at(2.3).unwrap();
            let rest = rest.method(method).setting(setting).samples(4).unwrap().start().unwrap().complete().unwrap();
            let off = distance(&rest.state, &whole.state) / largest(whole.state.iter().copied());
            assert!(off < 1e-8, "{k}, {}: {off:e}", method.name());
            let times = rest.samples.iter().map(|sample| sample.t);
            assert!(times.eq([0, 1, 2, 3, 4].map(|k| if k == 4 {
                END
            } else {
                2.3 + (END - 2.3) * f64::from(k) / 4.0
            })));
        }
    }
    // Moved beads that are where their drive is at time 0 are refused later, as are other starts.
    let moved = chain(Boundary::Free, DriveKind::Displacement, signals()[0].clone());
    let run = from_rest(&moved, Method::Collocation, Setting::Tolerance(1e-8));
    for (start, words) in
        [(3.0, "a bead that is moved begins where its drive does"), (END, "before its end"), (-1.0, "at least zero")]
    {
        let refused = run.clone().starting_at(start).and_then(|run| run.start()).unwrap_err().to_string();
        assert!(refused.contains(words), "{start}: {refused}");
    }
    let refused = run.starting_at(3.0).unwrap().until(2.0).unwrap_err().to_string();
    assert!(refused.contains("the end of a run is after its start"), "{refused}");
}

#[test]
fn an_event_on_a_break_is_one_event() {
    // Truth: collocation. A bead of speed 1 crosses a gap of 2 and meets the next one at t = 2,
    // where the ramp of a third bead ends.
    let uniform = Chain::<f64>::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 3).unwrap();
    let signal = Signal::new(vec![sine(0.1, 1.0, 0.3)], Envelope::Ramp(2.0));
    let drives = vec![Drive { site: 2, kind: DriveKind::Force, signal }];
    let details = Details { drives, overlap: vec![-2.0, -0.5], ..Details::default() };
    let chain = uniform.with(&details).unwrap();
    let mut state = State::rest(&chain);
    state.u_dot_mut()[0] = 1.0;
    let run = |name: &str, tol: f64| -> Trajectory {
        let run = Run::new(chain.clone(), state.clone()).until(8.0).unwrap().method(named(name));
        run.setting(Setting::Tolerance(tol)).contacts().start().unwrap().complete().unwrap()
    };
    let want = run("collocation", 1e-13);
    for name in ["dop853", "dop853-landed", "dop853-regularised"] {
        let got = run(name, 1e-12);
        let off = distance(&got.state, &want.state);
        assert!(off < 1e-8, "{name}: {off:e}");
        let [got, want] = [&got, &want].map(|run| run.contacts.as_ref().unwrap());
        assert_eq!(got.len(), want.len(), "{name}");
        for (got, want) in got.iter().zip(want) {
            let off = (got.onset.unwrap() - want.onset.unwrap()).abs();
            assert!(got.bond == want.bond && off < 1e-7, "{name}: {got:?} {want:?}");
        }
    }
}

#[test]
fn a_moved_bead_carries_its_kinetic_energy_and_drives_do_that_work() {
    // Truth: E = m s'^2/2 for the moved bead, which touches nobody, and driven = E(t) - E(0), by
    // every method; its position and speed are those of the signal.
    let uniform = Chain::<f64>::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 2).unwrap();
    for envelope in [Envelope::None, Envelope::Ramp(1e-2)] {
        let signal = Signal::new(vec![sine(0.3, 2.0, 0.5), sine(0.1, 5.0, 1.0)], envelope);
        let drives = vec![Drive { site: 0, kind: DriveKind::Displacement, signal: signal.clone() }];
        let details = Details { mass: vec![2.5, 1.0], overlap: vec![-9.0], drives, ..Details::default() };
        let chain = uniform.clone().with(&details).unwrap();
        let kinetic = |t: f64| 0.5 * 2.5 * signal.at(t)[1].powi(2);
        for method in Method::all().into_iter().filter(|method| method.unsupported_reason(&chain).is_none()) {
            let setting = if method.adaptive() { Setting::Tolerance(1e-10) } else { Setting::Steps(900) };
            let end = from_rest(&chain, method, setting).start().unwrap();
            let (energy, ledger) = (end.energy.unwrap(), chain.layout().ledger(&end.state).unwrap());
            let [s, s_dot, _] = signal.at(END);
            let off = [
                end.state[0] - s,
                chain.layout().u_dot(&end.state)[0] - s_dot,
                energy.beads - kinetic(END),
                ledger.driven - (kinetic(END) - kinetic(0.0)),
            ];
            assert!(largest(off) < 1e-14, "{} {envelope:?}: {off:?}", method.name());
        }
    }
}

/// The scene in which the first bead is moved under a ramp much shorter than all else.
fn short_ramp(initial: &str) -> hertzchain::error::Result<Scene> {
    let text = format!(
        "name = \"short-ramp\"\nchain = {{ sites = 3, alpha = 1.5, boundary = \"free\" }}\n\
         drive = [{{ site = 0, kind = \"moved\", amplitude = 0.7, omega = 1.3, phase = 1.0, ramp = 1e-6 }}]\n\
         initial = {initial}\nspan = {{ until = 12.0 }}\n"
    );
    Scene::parse(&text, "short-ramp.toml")
}

#[test]
fn the_work_of_a_drive_in_a_short_ramp_is_that_of_the_contact() {
    // Truth: energy + dissipated - driven is constant, and the position is prescribed. Speeds in
    // the ramp are 10^6; before, DOP853 took their squares into the work of drives.
    let scene = short_ramp("{ kind = \"state\", u_dot = [0, 0, -0.3] }").unwrap();
    for name in ["dop853", "dop853-landed", "dop853-regularised", "collocation"] {
        let end = scene.run().method(named(name)).setting(Setting::Tolerance(1e-12)).start().unwrap();
        let (u, error) = (end.state[0], end.energy_error.unwrap());
        println!("{name}: {u} {error:e}");
        assert!((u - 0.7 * (1.3f64 * 12.0 + 1.0).sin()).abs() < 1e-14, "{name}: {u}");
        assert!(error < 1e-8, "{name}: {error:e}");
    }
}

#[test]
fn steps_that_are_longer_than_a_ramp_or_a_burst_are_said() {
    // Truth: lengths and steps as given. 0.05 is below the step of 0.1, 0.3 is not.
    let burst = |length| Signal { envelope: Envelope::Burst { start: 6.0, length }, ..Signal::sine(0.5, 2.0, 0.0) };
    let said = |signal: Signal, name: &str, setting: Setting| -> Vec<String> {
        let run = from_rest(&chain(Boundary::Free, DriveKind::Force, signal), named(name), setting);
        let warnings = run.records(Records::End).start().unwrap().warnings;
        warnings.iter().filter(|warning| !warning.fatal()).map(ToString::to_string).collect()
    };
    let step = Setting::steps(END / 0.1).unwrap();
    for name in ["verlet", "strang-linear", "aba1064-linear"] {
        let [text] = said(burst(0.05), name, step).try_into().unwrap();
        let words = ["drive 0, of bead 0, has a burst of length 5e-2", "steps of 1e-1"];
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
        let [text] = said(Signal::sine(0.5, 2.0, 0.02), name, step).try_into().unwrap();
        assert!(text.contains("has a ramp of length 2e-2"), "{text}");
        assert!(said(burst(0.3), name, step).is_empty() && said(Signal::sine(0.5, 2.0, 0.0), name, step).is_empty());
    }
    for name in ["dop853", "dop853-regularised", "collocation"] {
        assert!(said(burst(0.05), name, Setting::Tolerance(1e-10)).is_empty());
    }
    assert!(said(burst(0.05), "collocation", Setting::Windows(3, 8)).is_empty());
}

#[test]
fn a_burst_that_times_do_not_resolve_is_refused() {
    let burst = Signal { envelope: Envelope::Burst { start: 50.0, length: 1e-10 }, ..Signal::sine(0.5, 2.0, 0.0) };
    let drives = vec![Drive { site: 0, kind: DriveKind::Force, signal: burst }];
    let alone = Chain::<f64>::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 1).unwrap();
    let message = alone.with(&Details { drives, ..Details::default() }).unwrap_err().to_string();
    assert!(message.contains("drive.length") && message.contains("1e-11 of its start"), "{message}");
}

#[test]
fn a_moved_bead_given_another_start_than_its_drive_is_refused() {
    // With the ramp it begins at rest at zero. Numbers of other beads, zeros, and numbers of the
    // drive itself, with rounding, are taken.
    for (initial, given) in [
        ("{ kind = \"state\", u = [0.1, 0, 0], u_dot = [0, 0, 0] }", "position = 1e-1, velocity = 0e0 at site 0"),
        ("{ kind = \"state\", u_dot = [0.2, 0, 0] }", "velocity = 2e-1 at site 0"),
        ("{ kind = \"single-bead\", site = 0, displacement = 0.0, velocity = 1.0 }", "velocity = 1e0 at site 0"),
    ] {
        let message = short_ramp(initial).unwrap_err().to_string();
        assert!(message.contains(given) && message.contains("begins as its drive does"), "{message}");
    }
    let text = |u: f64, u_dot: f64| {
        format!(
            "name = \"moved\"\nchain = {{ sites = 2, alpha = 1.5, boundary = \"free\" }}\n\
             drive = [{{ site = 1, kind = \"moved\", amplitude = 0.7, omega = 1.3, phase = 1.0 }}]\n\
             initial = {{ kind = \"state\", u = [-0.5, {u:e}], u_dot = [0.1, {u_dot:e}] }}\nspan = {{ until = 1.0 }}\n"
        )
    };
    let [s, s_dot] = [0.7 * 1f64.sin(), 0.7 * 1.3 * 1f64.cos()];
    for (u, u_dot) in [(0.0, 0.0), (s, s_dot), (s * (1.0 + 1e-14), 0.0), (0.0, s_dot)] {
        let scene = Scene::parse(&text(u, u_dot), "moved.toml").unwrap();
        assert!((scene.initial().u()[1] - s).abs() < 1e-15);
        let again = scene.from_state(scene.initial().u().to_vec(), vec![], scene.initial().u_dot().to_vec(), vec![]);
        assert_eq!(again.unwrap().initial(), scene.initial());
    }
    assert!(Scene::parse(&text(s + 1e-3, s_dot), "moved.toml").is_err());
}

#[test]
fn times_that_nearly_coincide_cost_a_spline_no_digits() {
    // Truth: u(10) of u'' = s(t) from rest, with the spline in 60 digits; mirrored times give the
    // mirrored spline.
    let values = [0.0, 1.0, 1.0, -1.0, 0.0, 2.0];
    for (gap, want) in [(1e-9, -0.124342105165), (1e-12, -0.124342105263), (2.3e-16, -0.124342105263)] {
        let times = [0.0, 1.0, 1.0 + gap, 5.0, 9.0, 10.0];
        let spline = Spline::new(times.to_vec(), values.to_vec()).unwrap();
        let [mut u, mut u_dot] = [0.0; 2];
        for (from, to) in times.windows(2).map(|pair| (pair[0], pair[1])) {
            let (h, [value, rate, second]) = (to - from, spline.at(from));
            let third = (spline.at(to.next_down())[2] - second) / h;
            u += h * (u_dot + h * (value / 2.0 + h * (rate / 6.0 + h * (second / 24.0 + h * third / 120.0))));
            u_dot += h * (value + h * (rate / 2.0 + h * (second / 6.0 + h * third / 24.0)));
        }
        assert!((u - want).abs() < 1e-12, "{gap}: {u}");
        let mirrored = Spline::new(times.map(|t| -t).into_iter().rev().collect(), values.into_iter().rev().collect());
        let mirrored = mirrored.unwrap();
        for t in [0.3, 0.9, 3.0, 7.0, 9.9] {
            let (got, same) = (mirrored.at(-t), spline.at(t));
            assert!((got[0] - same[0]).abs() < 4e-15 && (got[1] + same[1]).abs() < 1e-14, "{gap} {t}");
        }
    }
}
