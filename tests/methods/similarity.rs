//! The same motion in other units of mass, length and time: every method, law and observable.
//!
//! Units are powers of two, lengths of four, so that numbers in them are the same up to their
//! exponents where a formula has no unit of its own.

use hertzchain::{
    chain::{
        Boundary, Chain, Course, Details, Dissipation, Drive, DriveKind, Envelope, Harmonic, Kind, Params, Signal,
        Spline, State, Table, Term,
    },
    orbits::{
        Branch, DriveParameter, DrivenContinuation, DrivenSetting, DrivenShooting, ModeContinuation, NormalModes,
    },
    run::{Crossed, Method, Observables, Records, Run, Setting, Trajectory},
};
use std::sync::Arc;

/// Exponents of two of the units of mass, length and time.
#[derive(Clone, Copy, Debug)]
struct Units([f64; 3]);

/// Powers of mass, length and time in a quantity.
type Kinds = [f64; 3];

const TIME: Kinds = [0.0, 0.0, 1.0];
const LENGTH: Kinds = [0.0, 1.0, 0.0];
const SPEED: Kinds = [0.0, 1.0, -1.0];
const MASS: Kinds = [1.0, 0.0, 0.0];
const FORCE: Kinds = [1.0, 1.0, -2.0];
const IMPULSE: Kinds = [1.0, 1.0, -1.0];
const ENERGY: Kinds = [1.0, 2.0, -2.0];
const STIFFNESS: Kinds = [1.0, 0.0, -2.0];
const DRAG: Kinds = [1.0, 0.0, -1.0];
const PURE: Kinds = [0.0; 3];

impl Units {
    /// A number in these units.
    fn of(self, kinds: Kinds, x: f64) -> f64 {
        x * (0..3).map(|k| self.0[k] * kinds[k]).sum::<f64>().exp2()
    }

    fn all(self, kinds: Kinds, list: &[f64]) -> Vec<f64> {
        list.iter().map(|&x| self.of(kinds, x)).collect()
    }

    fn contact(self, alpha: f64, x: f64) -> f64 {
        self.of([1.0, 1.0 - alpha, -2.0], x)
    }

    fn signal(self, kind: DriveKind, signal: &Signal) -> Signal {
        let size = if kind == DriveKind::Force { FORCE } else { LENGTH };
        let (per, t) = (|x| self.of([0.0, 0.0, -1.0], x), |x| self.of(TIME, x));
        let harmonic =
            |one: &Harmonic| Harmonic { amplitude: self.of(size, one.amplitude), omega: per(one.omega), ..*one };
        let course = signal.course.as_ref().map(|course| match course {
            Course::Steady { velocity } => Course::Steady { velocity: self.of(SPEED, *velocity) },
            &Course::Chirp { amplitude, omega, phase, start, length } => Course::Chirp {
                amplitude: self.of(size, amplitude),
                omega: omega.map(per),
                phase,
                start: t(start),
                length: t(length),
            },
            Course::Table(spline) => {
                let spline = Spline::new(self.all(TIME, spline.times()), self.all(size, spline.values()));
                Course::Table(Arc::new(spline.unwrap()))
            }
        });
        let envelope = match signal.envelope {
            Envelope::None => Envelope::None,
            Envelope::Ramp(ramp) => Envelope::Ramp(t(ramp)),
            Envelope::Burst { start, length } => Envelope::Burst { start: t(start), length: t(length) },
            Envelope::HalfSine { start, length } => Envelope::HalfSine { start: t(start), length: t(length) },
        };
        Signal { harmonics: signal.harmonics.iter().map(harmonic).collect(), course, envelope }
    }
}

/// A chain of four beads, its state and its name.
#[derive(Clone)]
struct Case {
    name: &'static str,
    boundary: Boundary,
    alpha: f64,
    details: Details,
    u: [f64; 4],
    u_dot: [f64; 4],
}

impl Case {
    fn chain(&self, units: Units) -> Chain<f64> {
        let (given, alpha) = (&self.details, self.alpha);
        let of_each = |list: &[f64], kinds: &dyn Fn(f64) -> Kinds| -> Vec<f64> {
            let at = |k: usize| given.alpha.get(k).copied().unwrap_or(alpha);
            list.iter().enumerate().map(|(k, &x)| units.of(kinds(at(k)), x)).collect()
        };
        let contact = |alpha: f64| [1.0, 1.0 - alpha, -2.0];
        let bonds = match self.boundary {
            Boundary::Free => 3,
            Boundary::RightWall | Boundary::Ring => 4,
            _ => 5,
        };
        let or = |list: &[f64], count: usize, x: f64| if list.is_empty() { vec![x; count] } else { list.to_vec() };
        let constants = or(&given.contact, bonds, 1.0);
        let details = Details {
            mass: units.all(MASS, &or(&given.mass, 4, 1.0)),
            kappa: units.all(STIFFNESS, &or(&given.kappa, 4, 0.0)),
            rho: or(&given.rho, 4, 0.0),
            onsite: units.all(STIFFNESS, &given.onsite),
            drag: units.all(DRAG, &given.drag),
            dashpot: units.all(DRAG, &given.dashpot),
            // A table is multiplied by its constants.
            contact: if given.table.is_some() { constants } else { of_each(&constants, &contact) },
            terms: given
                .terms
                .iter()
                .map(|term| Term {
                    contact: or(&term.contact, bonds, 1.0).iter().map(|&x| units.contact(term.alpha, x)).collect(),
                    ..*term
                })
                .collect(),
            table: given.table.as_ref().map(|table| {
                let table = Table::new(units.all(LENGTH, table.overlap()), units.all(FORCE, table.force()));
                Arc::new(table.unwrap())
            }),
            overlap: units.all(LENGTH, &given.overlap),
            spring: units.all(STIFFNESS, &given.spring),
            magnet: units.all(FORCE, &given.magnet),
            distance: units.all(LENGTH, &given.distance),
            dissipation: given.dissipation.as_ref().map(|lossy| {
                let power = given.rate_power.unwrap_or(1.0);
                let kinds = match lossy.kind {
                    Kind::Viscoelastic => TIME,
                    Kind::HuntCrossley => [0.0, -1.0, 1.0],
                    Kind::Dashpot => [1.0, 1.0 - given.beta - power, power - 2.0],
                };
                Dissipation { kind: lossy.kind, strength: units.all(kinds, &lossy.strength) }
            }),
            drives: given
                .drives
                .iter()
                .map(|drive| Drive { signal: units.signal(drive.kind, &drive.signal), ..*drive })
                .collect(),
            gravity: units.of([0.0, 1.0, -2.0], given.gravity),
            ..given.clone()
        };
        let moving = given.rho.iter().any(|rho| *rho > 0.0 && rho.is_finite());
        let (kappa, rho) = if moving || !given.kappa.is_empty() { (units.of(STIFFNESS, 1.0), 0.5) } else { (0.0, 0.0) };
        let params = Params::new(alpha, kappa, rho).unwrap();
        Chain::new(params, self.boundary, 4).unwrap().with(&details).unwrap()
    }

    fn run(&self, units: Units, searched: bool) -> Run {
        let chain = self.chain(units);
        let mut state = State::rest(&chain);
        state.u_mut().copy_from_slice(&units.all(LENGTH, &self.u));
        state.u_dot_mut().copy_from_slice(&units.all(SPEED, &self.u_dot));
        let (seen, crossed) = (chain.clone(), chain.clone());
        let observables = Observables::new(move |y, to| {
            let [u, _, u_dot, _] = seen.layout().arrays(y);
            to.extend(u);
            to.extend(u_dot);
            let overlaps = seen.overlaps(u);
            let force = |bond: usize| seen.bond_force(bond, overlaps[bond], seen.across(bond, |n| u_dot[n]));
            to.extend(seen.touching().map(force));
            to.extend(seen.site_energies(y));
        });
        let counts = [4, 4, chain.touching().len(), 4].into_iter().enumerate();
        let kinds: Vec<usize> = counts.flat_map(|(kind, count)| vec![kind; count]).collect();
        let observables = observables.of_kinds(kinds);
        let crossings = Observables::new(move |y, to| to.push(crossed.layout().u(y)[1]));
        let run = Run::new(chain, state).until(units.of(TIME, 4.0)).unwrap().samples(5).unwrap();
        let run = run.records(Records::Energy).observables(observables).contacts();
        // With such a search, contacts are searched for, too.
        if searched { run.crossings(crossings.of_kinds([0]), |_, _| Crossed::Kept) } else { run }
    }
}

/// All numbers of a trajectory, in the units of the chain with exponents zero.
fn numbers(run: &Run, units: Units, end: &Trajectory) -> Vec<f64> {
    let mut out = Vec::new();
    let mut push = |kinds: Kinds, x: f64| out.push(units.of(kinds.map(|kind| -kind), x));
    let (n, layout) = (4, run.chain().layout());
    let half = layout.half();
    for (k, &x) in end.state.iter().enumerate() {
        push(
            if k < half {
                LENGTH
            } else if k < 2 * half {
                SPEED
            } else {
                ENERGY
            },
            x,
        );
    }
    for sample in &end.samples {
        push(TIME, sample.t);
        let energy = sample.energy.unwrap();
        for x in [energy.beads, energy.resonators, energy.springs, energy.contacts, energy.dissipated, energy.driven] {
            push(ENERGY, x);
        }
    }
    let observed = [(n, LENGTH), (n, SPEED), (run.chain().touching().len(), FORCE), (n, ENERGY)];
    let kinds = observed.iter().flat_map(|&(count, kinds)| vec![kinds; count]);
    for (kinds, &(t, x)) in kinds.zip(&end.extremes) {
        push(TIME, t);
        push(kinds, x);
    }
    const CONTACT: [Kinds; 13] =
        [PURE, TIME, TIME, SPEED, SPEED, LENGTH, IMPULSE, TIME, LENGTH, LENGTH, TIME, FORCE, TIME];
    for contact in end.contacts.iter().flatten() {
        contact.numbers().into_iter().zip(CONTACT).filter(|(x, _)| !x.is_nan()).for_each(|(x, kinds)| push(kinds, x));
    }
    end.crossings.iter().for_each(|event| push(TIME, event.t));
    // The work differs where a rounding decides on a step.
    push(PURE, end.warnings.len() as f64);
    out.push(end.energy_error.unwrap());
    out
}

fn drive(site: usize, kind: DriveKind, signal: Signal) -> Drive {
    Drive { site, kind, signal }
}

fn cases() -> Vec<Case> {
    let base = Case {
        name: "struck",
        boundary: Boundary::Fixed,
        alpha: 1.5,
        details: Details::default(),
        u: [0.0, 0.3, 0.25, 0.0],
        u_dot: [1.0, 0.0, -0.4, 0.0],
    };
    let damped = Details {
        mass: vec![1.0, 1.5, 0.7, 1.1],
        kappa: vec![0.7, 0.0, 1.3, 2.0],
        rho: vec![0.4, 0.0, f64::INFINITY, 0.02],
        drag: vec![0.02, 0.1, 0.0, 0.0],
        dashpot: vec![0.0, 0.0, 0.0, 0.05],
        ..Details::default()
    };
    let lossy = |kind, bonds| Some(Dissipation { kind, strength: vec![0.07; bonds] });
    let harmonics =
        vec![Harmonic { amplitude: 0.2, omega: 1.3, phase: 0.4 }, Harmonic { amplitude: 0.1, omega: 0.0, phase: 1.0 }];
    let chirp = Course::Chirp { amplitude: 0.3, omega: [0.5, 2.0], phase: 0.1, start: 1.0, length: 3.0 };
    let spline = Spline::new(vec![0.0, 1.0, 2.5, 4.0, 7.0], vec![0.0, 0.2, -0.1, 0.3, 0.0]).unwrap();
    let signal = |course, envelope| Signal { harmonics: vec![], course, envelope };
    let g: Vec<f64> = (0..9).map(|k| 0.25 * f64::from(k)).collect();
    let table = Table::new(g.clone(), g.iter().map(|g| g * g * (1.0 + g)).collect()).unwrap();
    let details = Details::default;
    vec![
        base.clone(),
        Case { name: "damped", boundary: Boundary::Free, details: damped.clone(), ..base.clone() },
        Case {
            name: "hung",
            boundary: Boundary::RightWall,
            details: Details { gravity: 0.3, onsite: vec![0.5, 0.0, 0.2, 0.0], drag: vec![0.0; 4], ..details() },
            ..base.clone()
        },
        Case {
            name: "exponents",
            boundary: Boundary::Ring,
            details: Details { alpha: vec![1.0, 1.5, 2.0, 2.5], contact: vec![1.0, 0.5, 2.0, 1.5], ..details() },
            ..base.clone()
        },
        Case { name: "alpha = 2", alpha: 2.0, details: damped, ..base.clone() },
        Case { name: "alpha = 3", alpha: 3.0, ..base.clone() },
        Case { name: "alpha = 1", alpha: 1.0, ..base.clone() },
        Case {
            name: "springs and magnets",
            boundary: Boundary::Free,
            details: Details {
                overlap: vec![-0.1, 0.0, -0.2],
                spring: vec![0.2, 0.0, 0.1],
                magnet: vec![0.0, 0.3, 0.0],
                distance: vec![1.0, 2.0, 1.0],
                decay: 4.0,
                ..details()
            },
            ..base.clone()
        },
        Case {
            name: "terms",
            details: Details { terms: vec![Term { contact: vec![], alpha: 2.5 }], ..details() },
            ..base.clone()
        },
        Case { name: "table", details: Details { table: Some(Arc::new(table)), ..details() }, ..base.clone() },
        Case {
            name: "viscoelastic",
            details: Details { dissipation: lossy(Kind::Viscoelastic, 5), ..details() },
            ..base.clone()
        },
        Case {
            name: "hunt-crossley",
            details: Details { dissipation: lossy(Kind::HuntCrossley, 5), pull: true, ..details() },
            ..base.clone()
        },
        Case {
            name: "dashpots",
            boundary: Boundary::Free,
            details: Details { dissipation: lossy(Kind::Dashpot, 3), beta: 0.5, ..details() },
            ..base.clone()
        },
        Case {
            name: "quadratic dashpots",
            details: Details { dissipation: lossy(Kind::Dashpot, 5), beta: 0.5, rate_power: Some(2.0), ..details() },
            ..base.clone()
        },
        Case {
            name: "driven",
            boundary: Boundary::Fixed,
            details: Details {
                drives: vec![
                    drive(0, DriveKind::Displacement, Signal::new(harmonics.clone(), Envelope::Ramp(2.0))),
                    drive(1, DriveKind::Force, Signal::new(harmonics, Envelope::Burst { start: 1.0, length: 2.0 })),
                    drive(2, DriveKind::Force, signal(Some(chirp), Envelope::None)),
                    drive(3, DriveKind::Force, signal(Some(Course::Table(Arc::new(spline))), Envelope::None)),
                ],
                ..details()
            },
            u: [0.0, 0.3, 0.25, 0.2],
            u_dot: [0.0, 0.0, -0.4, 0.0],
            ..base.clone()
        },
        Case {
            name: "piston with a ramp",
            boundary: Boundary::RightWall,
            details: Details {
                drives: vec![drive(
                    0,
                    DriveKind::Displacement,
                    signal(Some(Course::Steady { velocity: 0.5 }), Envelope::Ramp(2.0)),
                )],
                ..details()
            },
            u_dot: [0.0, 0.0, -0.4, 0.0],
            ..base.clone()
        },
        Case {
            name: "piston",
            boundary: Boundary::RightWall,
            details: Details {
                drives: vec![
                    drive(0, DriveKind::Displacement, signal(Some(Course::Steady { velocity: 0.5 }), Envelope::None)),
                    drive(
                        2,
                        DriveKind::Force,
                        Signal::new(Signal::constant(0.5).harmonics, Envelope::HalfSine { start: 1.0, length: 1.5 }),
                    ),
                ],
                ..details()
            },
            u_dot: [0.5, 0.0, -0.4, 0.0],
            ..base
        },
    ]
}

#[test]
fn a_motion_is_the_same_in_all_units() {
    // Truth: the same chain with all units 1; of each unit 2^80, more than 24 decades. Bounds:
    // twice what was measured, of numbers from 1e-2 on: 2.6e-13 by steps; with a tolerance of 1e-6,
    // where a rounding may decide on a window, 2.4e-6.
    let one = Units([0.0; 3]);
    let units = [[40.0, -40.0, 40.0], [-40.0, 40.0, -40.0]].map(Units);
    let settings = [Setting::Steps(60), Setting::Tolerance(1e-6), Setting::Windows(10, 8)];
    let (mut worst, mut runs) = ([0.0f64; 2], 0);
    for (k, case) in cases().iter().enumerate() {
        let plain = case.run(one, k % 3 == 2);
        for (method, setting) in Method::all().into_iter().flat_map(|method| settings.map(|setting| (method, setting)))
        {
            let done = |run: Run, units| {
                let end = run.clone().method(method).setting(setting).start().unwrap().complete().unwrap();
                numbers(&run, units, &end)
            };
            if plain.clone().method(method).setting(setting).stepper().is_err() {
                continue;
            }
            let want = done(plain.clone(), one);
            for units in units {
                let got = done(case.run(units, k % 3 == 2), units);
                let what = format!("{}, {}, {setting:?}, {:?}", case.name, method.name(), units.0);
                assert_eq!(got.len(), want.len(), "{what}");
                for (k, (got, want)) in got.iter().zip(&want).enumerate() {
                    let off = (got - want).abs() / want.abs().max(1e-2);
                    let (adaptive, bound) =
                        if matches!(setting, Setting::Tolerance(_)) { (1, 5e-6) } else { (0, 6e-13) };
                    if off > bound {
                        println!("{what}: number {k} is {got} for {want}");
                    }
                    worst[adaptive] = worst[adaptive].max(off);
                }
                runs += 1;
            }
        }
    }
    println!("{runs} runs; with steps {:.1e}, with a tolerance {:.1e}", worst[0], worst[1]);
    assert!(worst[0] < 6e-13 && worst[1] < 5e-6);
}

/// Numbers of orbits, of a branch of them, and of a branch of normal modes without what drives and
/// damps them, in the units of the chain with exponents zero.
fn orbits(case: &Case, units: Units) -> Vec<f64> {
    let (shooting, chain) = (DrivenShooting::default(), case.chain(units));
    let (setting, to) = (DrivenSetting::new(&chain, 1).unwrap(), units.of(FORCE, 0.5));
    let continuation =
        DrivenContinuation { parameter: DriveParameter::Amplitude, to, step: 0.5 * to, most_points: 9, shooting };
    let rest = State::rest(&chain).driven(&chain);
    let seed = shooting.settle(&setting, &chain, &rest, 2, |_| ()).unwrap();
    let first = shooting.solve(&setting, &seed).unwrap();
    let mut branch = Branch::new(continuation, setting, first).unwrap();
    branch.extend(|_| ()).unwrap();
    let branch = branch.analysed();
    let mut out = vec![branch.points.len() as f64];
    for point in &branch.points {
        out.extend(point.orbit.z.iter().map(|z| units.of([0.0, -1.0, 0.0], *z)));
        out.extend(point.spectrum.multipliers.iter().flat_map(|one| [one.re, one.im]));
        out.extend([units.of([0.0, -1.0, 0.0], point.measures.amplitude), 1.0 + point.spectrum.liouville]);
    }
    let details = Details { drives: vec![], drag: vec![], dissipation: None, ..case.details.clone() };
    let modes = NormalModes::new(&Case { details, ..case.clone() }.chain(units)).unwrap();
    let branch = ModeContinuation { mode: 1, to: units.of(LENGTH, 0.9), step: units.of(LENGTH, 0.3), most_points: 9 };
    let mut branch = branch.begin(&modes).unwrap();
    branch.extend(|_| ()).unwrap();
    let branch = branch.analysed();
    for point in &branch.points {
        out.extend([units.of(TIME, point.orbit.omega), units.of([0.0, -1.0, 0.0], point.orbit.amplitude)]);
        out.extend(
            point.orbit.shape.iter().chain(point.spectrum.multipliers.iter().flat_map(|one| [&one.re, &one.im])),
        );
    }
    out
}

#[test]
fn orbits_and_modes_are_the_same_in_all_units() {
    // Truth: as above. Before, no orbit was found in times of 2^-40, and one was off by 6e-10 in
    // masses of 2^40.
    let force = Signal::new(vec![Harmonic { amplitude: 0.3, omega: 1.1, phase: 0.0 }], Envelope::None);
    let details = Details {
        overlap: vec![0.5; 5],
        // Multipliers of different moduli, so that their order is no matter of roundings.
        drag: vec![0.1, 0.2, 0.15, 0.05],
        drives: vec![drive(1, DriveKind::Force, force)],
        ..Details::default()
    };
    let lossy = Some(Dissipation { kind: Kind::Viscoelastic, strength: vec![0.05; 5] });
    let mut worst = 0.0f64;
    for dissipation in [None, lossy] {
        let case = Case { details: Details { dissipation, ..details.clone() }, ..cases()[0].clone() };
        let want = orbits(&case, Units([0.0; 3]));
        for units in [[40.0, 0.0, 0.0], [0.0, -40.0, 0.0], [0.0, 0.0, -40.0], [-40.0, 40.0, 40.0]].map(Units) {
            let got = orbits(&case, units);
            assert_eq!(got.len(), want.len(), "{units:?}");
            for (k, (got, want)) in got.iter().zip(&want).enumerate() {
                let off = (got - want).abs() / want.abs().max(1e-2);
                assert!(off < 1e-9, "{units:?}: number {k} is {got} for {want}");
                worst = worst.max(off);
            }
        }
    }
    println!("{worst:.1e}");
}
