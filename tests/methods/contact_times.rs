//! When contacts begin, are closest and end: the same by every method, also of beads that touch at
//! rest.

use crate::common::largest;
use hertzchain::{
    Run, Scene,
    chain::{Boundary, Chain, Contact, Params, State, TOUCH},
    run::method::{Method, Setting},
    run::{Observables, Records},
};

/// The chain of `sites` beads that touch at rest, shifted, of which the first is struck.
fn struck(alpha: f64, sites: usize, [velocity, shift]: [f64; 2], until: f64) -> Run {
    let chain = Chain::new(Params::new(alpha, 0.0, 0.0).unwrap(), Boundary::Free, sites).unwrap();
    let mut state = State::rest(&chain);
    state.u_mut().fill(shift);
    state.u_dot_mut()[0] = velocity;
    Run::new(chain, state).until(until).unwrap().records(Records::End).contacts()
}

/// The contacts of a run by a method, but those that may be its errors.
fn log(run: &Run, name: &str, setting: Setting) -> Vec<Contact> {
    let run = run.clone().method(Method::named(name).unwrap()).setting(setting);
    let mut log = run.start().and_then(|trajectory| trajectory.complete()).unwrap().contacts.unwrap();
    let largest = log.iter().fold(0.0f64, |largest, contact| largest.max(contact.largest_overlap));
    log.retain(|contact| contact.largest_overlap > 1e-3 * largest);
    log
}

/// The largest differences of two logs: of times of onset, largest overlap and release, of speeds
/// of approach, and of largest overlaps.
fn differences(a: &[Contact], b: &[Contact]) -> [f64; 5] {
    assert_eq!(a.len(), b.len());
    let mut most = [0.0_f64; 5];
    for (a, b) in a.iter().zip(b) {
        let of = |c: &Contact| {
            assert!(c.approach.unwrap() > 0.0 && c.separation.is_none_or(|speed| speed > 0.0), "{c:?}");
            [c.onset, Some(c.t_largest), c.release, c.approach, Some(c.largest_overlap)]
        };
        let level = |overlap: Option<f64>| overlap.map(|overlap| overlap > 0.0);
        assert_eq!((a.bond, level(a.onset_overlap)), (b.bond, level(b.onset_overlap)));
        assert_eq!(level(a.release_overlap), level(b.release_overlap), "{a:?} {b:?}");
        for (k, (a, b)) in of(a).into_iter().zip(of(b)).enumerate() {
            assert_eq!(a.is_some(), b.is_some());
            most[k] = most[k].max((a.unwrap_or(0.0) - b.unwrap_or(0.0)).abs());
        }
    }
    most
}

/// Holds logs of a run by some methods against the true one, to bounds of [`differences`].
fn holds(run: &Run, truth: &[Contact], rows: &[(&str, Setting, [f64; 5])]) {
    for &(name, setting, bounds) in rows {
        let got = differences(&log(run, name, setting), truth);
        println!("{name} {setting:?}: {:?}", got.map(|x| format!("{x:.1e}")));
        let alpha = run.chain().params().alpha;
        assert!(got.iter().zip(bounds).all(|(got, bound)| *got < bound), "{alpha} {name} {setting:?}: {got:?}");
    }
}

#[test]
fn beads_that_touch_at_rest_begin_to_press_at_the_same_time_by_every_method() {
    // Truth: the regularised run at 1e-13, of another kind than all others. The first zero that is
    // computed for bond 12 is at t = 4.1 to 14.6, depending on the method; the rule of the log says
    // 18.03. Bounds are twice what was measured: times of onsets and releases have up to 1e4 times
    // the error of the overlap.
    let run = struck(1.5, 30, [0.1, 0.0], 60.0);
    let truth = log(&run, "dop853-regularised", Setting::Tolerance(1e-13));
    assert_eq!(truth.len(), 29);
    for contact in &truth {
        // The first bond closes at the speed of the blow; the others do not come out of a gap.
        let from = if contact.bond == 1 { 0.0 } else { TOUCH * contact.largest_overlap };
        assert_eq!(contact.onset_overlap, Some(from), "{contact:?}");
    }
    holds(
        &run,
        &truth,
        &[
            ("collocation", Setting::Tolerance(1e-13), [3e-10, 2.4e-10, 1.1e-8, 1.1e-11, 8e-13]),
            ("collocation", Setting::Tolerance(1e-10), [3e-7, 4.6e-9, 4.6e-7, 5.8e-10, 5.6e-12]),
            ("collocation", Setting::Tolerance(1e-6), [5.2e-4, 7.6e-6, 1.3e-4, 5e-6, 7e-9]),
            ("dop853", Setting::Tolerance(1e-10), [1.6e-7, 1.4e-7, 4.6e-5, 6.2e-10, 1.6e-9]),
            ("dop853-regularised", Setting::Tolerance(1e-8), [1.8e-6, 1.5e-5, 6.2e-4, 1.3e-8, 2.8e-8]),
            ("corrected", Setting::Steps(6000), [4.8e-9, 2.2e-7, 1.3e-8, 2.2e-9, 2.8e-11]),
            ("strang-linear", Setting::Steps(6000), [1.2e-4, 2e-4, 2.8e-4, 3e-7, 1.7e-6]),
        ],
    );
}

#[test]
fn times_of_largest_overlaps_give_the_speed_of_the_solitary_wave() {
    // Truth: two independent computations, one of them the fixed point of the equation of the
    // wave's Fourier transform. Measured: 2e-13 and 8e-12 of it, which is what the digits given and
    // the distance from the blow leave.
    const SPEED: f64 = 0.905_515_776_419;
    for (name, tol, bonds, bound) in
        [("collocation", 1e-12, [50, 100], 1e-12), ("dop853-regularised", 1e-13, [40, 50], 2e-11)]
    {
        let sites = bonds[1] + 12;
        let log = log(&struck(1.5, sites, [1.0, 0.0], 1.3 * sites as f64), name, Setting::Tolerance(tol));
        let [a, b] = bonds.map(|bond| log.iter().find(|contact| contact.bond == bond).unwrap());
        let speed = (bonds[1] - bonds[0]) as f64 / (b.t_largest - a.t_largest);
        let force = b.largest_overlap.powf(1.5);
        let off = speed / force.powf(1.0 / 6.0) / SPEED - 1.0;
        println!("{name}: speed {speed:.12}, force {force:.12}, off by {off:.1e}");
        assert!(off.abs() < bound, "{name}: {off:e}");
        // From a blow at unit speed; by both methods.
        assert!((speed - 0.840_508_772_85).abs() < 3e-11, "{name}: {speed}");
    }
}

#[test]
fn a_shift_of_the_chain_does_not_change_the_log_of_collocation() {
    // The overlaps, of up to 5e-12, are below 64 roundings of the positions, 1.4e-11, and the times
    // go to 8000. Bounds are twice what was measured.
    let run = |shift| struck(1.5, 12, [1e-14, shift], 1e5);
    let logs = [0.0, 1e3].map(|shift| log(&run(shift), "collocation", Setting::Tolerance(1e-10)));
    let got = differences(&logs[0], &logs[1]);
    println!("{:?}", got.map(|x| format!("{x:.1e}")));
    let bounds = [1.7e-4, 9e-5, 2.4e-6, 2e-22, 1.2e-20];
    assert!(logs[0].len() == 11 && got.iter().zip(bounds).all(|(got, bound)| *got < bound), "{got:?}");
}

/// The path of a scene beside the references.
pub(crate) fn reference(name: &str) -> String {
    format!("{}/tests/reference/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

/// The log of a scene, by a method.
fn logged(scene: &str, name: &str, setting: Setting) -> Vec<Contact> {
    let scene = Scene::parse(scene, "a test").or_else(|_| Scene::load(scene)).unwrap();
    let run = scene.run().method(Method::named(name).unwrap()).setting(setting).records(Records::End).contacts();
    run.start().and_then(|trajectory| trajectory.complete()).unwrap().contacts.unwrap()
}

/// Two beads 0.5 apart, of which one comes with speed 1.
fn two_beads(alpha: f64, more: &str) -> String {
    format!(
        "chain = {{ sites = 2, alpha = {alpha:?}, boundary = \"free\" }}\nbonds = {{ overlap = -0.5{more} }}\n\
         initial = {{ kind = \"state\", u_dot = [1.0, 0.0] }}\nspan = {{ until = 10.0 }}\n"
    )
}

const TOLERANCES: [f64; 3] = [1e-6, 1e-10, 1e-13];

/// Exponents, and how long two beads of mass 1 touch that meet with speed 1: `2 G/(alpha + 1)
/// B(1/(alpha + 1), 1/2)`, where `G^{alpha + 1} = (alpha + 1)/4`.
const DURATIONS: [(f64, f64); 9] = [
    (1.1, 2.277_495_272_787_145),
    (1.2, 2.326_420_635_560_581),
    (1.5, 2.438_837_564_705_527),
    (2.0, 2.547_933_978_487_607),
    (2.5, 2.600_325_142_287_543),
    (3.0, 2.622_057_554_292_119),
    (5.0, 2.598_445_371_630_463),
    (8.0, 2.508_750_016_629_099),
    (20.0, 2.303_975_151_183_305),
];

#[test]
fn the_log_of_two_beads_is_the_closed_form_for_every_exponent_method_and_tolerance() {
    // Truth: closed form. For alpha = 20 a release by collocation was late by up to 0.3: there the
    // force is negligible long before the overlap ends.
    for (alpha, duration) in DURATIONS {
        let (scene, most) = (two_beads(alpha, ""), f64::powf((alpha + 1.0) / 4.0, 1.0 / (alpha + 1.0)));
        let check = |name: &str, setting: Setting, [bound, at_largest]: [f64; 2]| {
            let contacts = logged(&scene, name, setting);
            let [c] = contacts[..] else { panic!("{name} {setting:?} {alpha}: {contacts:?}") };
            let ends = [c.onset.unwrap() - 0.5, c.release.unwrap() - 0.5 - duration];
            let speeds = [c.approach.unwrap() - 1.0, c.separation.unwrap() - 1.0, c.impulse - 1.0];
            let off = largest(ends.into_iter().chain(speeds).chain([c.largest_overlap - most]));
            let late = c.t_largest - 0.5 - 0.5 * duration;
            assert!(off < bound && late.abs() < at_largest, "{name} {setting:?} {alpha}: {off:e} {late:e}");
            assert_eq!((c.force_end, c.t_peak), (c.release, c.t_largest));
            let force = c.peak_force / most.powf(alpha) - 1.0;
            assert!(force.abs() < 2.0 * (alpha + 1.0) * bound, "{name} {setting:?} {alpha}: {force:e}");
        };
        for tol in TOLERANCES {
            check("collocation", Setting::Tolerance(tol), [10.0 * tol, 100.0 * tol]);
            check("dop853", Setting::Tolerance(tol), [300.0 * tol, 1000.0 * tol]);
            check("dop853-regularised", Setting::Tolerance(tol), [10.0 * tol, 1000.0 * tol]);
        }
        // Impulses are sums of kicks.
        for name in ["verlet", "strang-linear"] {
            check(name, Setting::Steps(20_000), [5e-6, 1e-6]);
        }
    }
}

#[test]
fn the_force_of_a_dashpot_ends_before_the_overlap_by_every_method() {
    // Truth: closed form. With alpha = 1, g'' = -2 (g + c g'), which pushes until the bracket is
    // zero: omega t = pi - atan(c omega/(1 - c^2)), omega^2 = 2 - c^2. Then beads part freely. The
    // bracket is largest where cot(omega t) = (c + 2 c/(1 - 2 c^2))/omega.
    // Collocation knows the end of the force as well as the impulse needs it.
    let c = 0.3_f64;
    let omega = (2.0 - c * c).sqrt();
    let last = (std::f64::consts::PI - (c * omega / (1.0 - c * c)).atan()) / omega;
    let (sin, cos) = (omega * last).sin_cos();
    let [g, rate] = [sin / omega, cos - c / omega * sin].map(|x| x * (-c * last).exp());
    let ends = [0.5 + last, 0.5 + last - g / rate];
    let peak = (omega / (c + 2.0 * c / (1.0 - 2.0 * c * c))).atan() / omega;
    let (sin, cos) = (omega * peak).sin_cos();
    let force = (sin / omega + c * (cos - c / omega * sin)) * (-c * peak).exp();
    let scene = two_beads(1.0, &format!(", dashpot = {c:?}"));
    for (name, setting, bound) in [
        ("collocation", Setting::Tolerance(1e-12), 1e-8),
        ("dop853-regularised", Setting::Tolerance(1e-12), 2e-11),
        ("dop853", Setting::Tolerance(1e-12), 5e-11),
    ] {
        let contacts = logged(&scene, name, setting);
        let [contact] = contacts[..] else { panic!("{name}: {contacts:?}") };
        let off = [contact.force_end, contact.release].map(Option::unwrap);
        let off = [off[0] - ends[0], off[1] - ends[1]];
        let at_peak = [contact.peak_force - force, contact.t_peak - 0.5 - peak];
        println!("{name}: {off:?} {at_peak:?}");
        assert!(largest(off) < bound, "{name}: {off:?}");
        // The rate is that of the polynomial through eight samples of a step.
        assert!(at_peak[0].abs() < 1e-9 && at_peak[1].abs() < 1e-5, "{name}: {at_peak:?}");
    }
}

/// The force of every bond that can touch.
fn forces(chain: &Chain<f64>, y: &[f64], out: &mut Vec<f64>) {
    let (overlaps, u_dot) = (chain.overlaps(chain.layout().u(y)), chain.layout().u_dot(y));
    let force = |bond: usize| chain.bond_force(bond, overlaps[bond], chain.across(bond, |n| u_dot[n]));
    out.extend(chain.touching().map(force));
}

/// The largest force of every bond, by its contacts and by the search of all steps.
pub(crate) fn largest_forces(run: &Run) -> [Vec<f64>; 2] {
    let chain = run.chain().clone();
    let (first, mut peaks) = (chain.touching().start, vec![0.0; chain.touching().len()]);
    let observed = run.clone().observables(Observables::new(move |y, out| forces(&chain, y, out)));
    let done = observed.start().and_then(|trajectory| trajectory.complete()).unwrap();
    for contact in done.contacts.unwrap() {
        peaks[contact.bond - first] = contact.peak_force.max(peaks[contact.bond - first]);
    }
    [peaks, done.extremes.iter().map(|one| one.1.abs()).collect()]
}

#[test]
fn the_largest_force_of_a_hard_dashpot_is_that_of_its_onset() {
    // Truth: closed form. A bead comes to a wall with speed 1; f = g^{3/2} + g' is 1 at the onset,
    // and falls. By the polynomial of a tiny step it was 1519.8 at 1e-6.
    let scene = "chain = { sites = 1, alpha = 1.5, boundary = \"right-wall\" }\n\
                 bonds = { overlap = -0.3, dashpot = 1.0 }\n\
                 initial = { kind = \"state\", u = [0.0], u_dot = [1.0] }\nspan = { until = 4.0 }\n";
    let scene = Scene::parse(scene, "a test").unwrap();
    for name in ["collocation", "dop853", "dop853-regularised", "dop853-landed"] {
        for tol in [1e-6, 1e-10, 1e-12] {
            let run = scene.run().method(Method::named(name).unwrap()).tolerance(tol).unwrap();
            let off = largest_forces(&run.records(Records::End).contacts()).map(|got| got[0] - 1.0);
            println!("{name} {tol:e}: {off:?}");
            assert!(off.iter().all(|off| off.abs() < 10.0 * tol), "{name} {tol:e}: {off:?}");
        }
    }
}

#[test]
fn the_largest_forces_of_contacts_that_dissipate_are_those_of_states() {
    // Truth: forces at 40 000 states of plain DOP853, which knows no events. The largest one is
    // below the maximum by at most what a force changes in half the time between them: 1e-3 where
    // it jumps. Bonds 7 to 9 had 7.66, 7.72 and 2.33, by the dashpot 0.1 infinity.
    for (law, until) in [
        ("overlap = -0.1, dashpot = 1.0", 20.0),
        ("dashpot = 0.1, beta = 0.1", 15.0),
        ("hunt_crossley = 0.01", 15.0),
        ("viscoelastic = 0.05", 15.0),
    ] {
        let scene = format!(
            "chain = {{ sites = 10, alpha = 1.5, boundary = \"free\" }}\nbonds = {{ {law} }}\n\
             initial = {{ kind = \"single-bead\", site = 0, velocity = 1.0 }}\nspan = {{ until = {until:?} }}\n"
        );
        let run = Scene::parse(&scene, "a test").unwrap().run().records(Records::End).contacts();
        let by = |name: &str, tol: f64| run.clone().method(Method::named(name).unwrap()).tolerance(tol).unwrap();
        let (chain, mut most, mut now) = (run.chain().clone(), vec![0.0f64; 9], Vec::new());
        let mut seen = |_: f64, y: &[f64]| {
            now.clear();
            forces(&chain, y, &mut now);
            most.iter_mut().zip(&now).for_each(|(most, now)| *most = most.max(*now));
        };
        by("dop853", 1e-12).records(Records::Energy).samples(40_000).unwrap().observe(&mut seen, &mut |_| ()).unwrap();
        for (name, tol, bound) in [
            ("collocation", 1e-10, 1e-9),
            ("dop853-regularised", 1e-10, 1e-8),
            ("dop853-landed", 1e-10, 1e-8),
            ("dop853", 1e-10, 1e-6),
        ] {
            let [peaks, searched] = largest_forces(&by(name, tol));
            for (bond, most) in most.iter().enumerate() {
                let (peak, searched) = (peaks[bond], searched[bond]);
                let low = (peak - searched).abs();
                assert!(low < bound, "{law} {name}: bond {}: {peak} {searched}", bond + 1);
                let off = peak - most;
                assert!(-bound < off && off < 1e-3, "{law} {name}: bond {}: {peak} {most}", bond + 1);
            }
        }
    }
}

#[test]
fn beads_that_nearly_part_have_one_contact_by_every_method() {
    // Truth: quadruple precision. The regularised run at 1e-13 had two contacts of bond 3, as its
    // steps are short enough for one to end at the small overlap.
    for (name, tol) in [
        ("collocation", 1e-12),
        ("dop853", 1e-10),
        ("dop853-landed", 1e-12),
        ("dop853-regularised", 1e-8),
        ("dop853-regularised", 1e-13),
    ] {
        let contacts = logged(&reference("nearly-parted"), name, Setting::Tolerance(tol));
        let own: Vec<&Contact> = contacts.iter().filter(|contact| contact.bond == 3).collect();
        let [contact] = own[..] else { panic!("{name} {tol:e}: {own:?}") };
        let off = [contact.onset.unwrap() - 8.141_600_014_006_23, contact.largest_overlap - 0.322_303_405_198_970_44];
        println!("{name} {tol:e}: {off:?}");
        assert!(contacts.len() == 11 && contact.release.is_none(), "{name} {tol:e}: {contacts:?}");
        assert!(
            largest(off) < 1e3 * tol && (contact.t_largest - 22.533_897_262).abs() < 1e-4,
            "{name} {tol:e}: {off:?}"
        );
    }
}

#[test]
fn largest_overlaps_are_those_of_the_solution_not_of_a_polynomial_of_a_panel() {
    // Truth: quadruple precision, bond by bond. The series inside the window of collocation at
    // 1e-12 have errors of 1e-10, so the log has it from parts of the window.
    let truth = [0.282_522_349_294_320_5, 0.358_461_629_423_011_3, 0.141_309_244_506_618_55, 0.278_047_489_560_389_66];
    for (name, tol) in [("collocation", 1e-8), ("collocation", 1e-12), ("dop853-regularised", 1e-12)] {
        let contacts = logged(&reference("pushed-ring"), name, Setting::Tolerance(tol));
        let of = |bond: usize| contacts.iter().find(|contact| contact.bond == bond).unwrap();
        let off =
            largest((0..5).map(|bond| of(bond).largest_overlap - truth.get(bond).unwrap_or(&0.268_587_195_795_719_66)));
        let late = [of(0).t_largest - 4.899_645_350_5, of(1).t_largest - 2.944_550_581_9];
        println!("{name} {tol:e}: {off:e} {late:?}");
        // 1000 tol in the rate of the overlap, by a curvature of 0.1.
        assert!(off < 10.0 * tol && largest(late) < 1e4 * tol, "{name} {tol:e}: {off:e} {late:?}");
    }
}

#[test]
fn impulses_and_ends_of_forces_of_dashpots_are_those_of_another_method_at_every_tolerance() {
    // Truth: two methods that share neither steps nor impulses. Before, collocation left out a
    // panel whose force is largest before the refined zero (1e-3 of an impulse at 1e-6), and
    // regularised DOP853 took the release for the end of the force (off by 3e-3 at 1e-13).
    let log = |name: &str, tol: f64| logged(&reference("nine-beads"), name, Setting::Tolerance(tol));
    let truth = log("collocation", 1e-13);
    assert_eq!(truth.len(), 10);
    // Bounds of impulses and of ends, twice what was measured; of impulses by regularised DOP853 at
    // 1e-13 as many tolerances as at 1e-10. Collocation at 1e-13 is right to 3e-14 there.
    for (name, tol, bounds) in [
        ("collocation", 1e-5, [1.1e-9, 1e-5]),
        ("collocation", 1e-6, [7e-10, 8e-6]),
        ("collocation", 1e-8, [8e-12, 6e-7]),
        ("dop853-regularised", 1e-7, [1.1e-6, 1.4e-6]),
        ("dop853-regularised", 1e-10, [1.8e-9, 4.1e-9]),
        ("dop853-regularised", 1e-13, [1.8e-12, 2.8e-8]),
    ] {
        let contacts = log(name, tol);
        assert!(contacts.iter().map(|one| one.bond).eq(truth.iter().map(|one| one.bond)), "{name} {tol:e}");
        let pairs = || contacts.iter().zip(&truth);
        let off = [
            largest(pairs().map(|(a, b)| a.impulse - b.impulse)),
            largest(pairs().map(|(a, b)| a.force_end.unwrap_or(0.0) - b.force_end.unwrap_or(0.0))),
        ];
        assert!(off[0] < bounds[0] && off[1] < bounds[1], "{name} {tol:e}: {off:?}");
    }
}

#[test]
fn beads_that_touch_and_close_have_their_onset_at_the_start_for_a_steep_force() {
    // Truth: beads 1 and 2 close with speed 0.3 from the start. The log of collocation had an onset
    // at 0.45, when the force began to matter, at an overlap of 0.135.
    let scene = "chain = { sites = 3, alpha = 20.0, boundary = \"fixed\" }\nspan = { until = 6.0 }\n\
                 initial = { kind = \"state\", u_dot = [1.0, 0.0, -0.3] }\n";
    let want = logged(scene, "dop853-regularised", Setting::Tolerance(1e-13));
    for tol in TOLERANCES {
        let got = logged(scene, "collocation", Setting::Tolerance(tol));
        let second = got.iter().find(|contact| contact.bond == 2).unwrap();
        assert_eq!((second.onset, second.onset_overlap), (Some(0.0), Some(0.0)));
        let off = differences(&got, &want);
        assert!(largest(off) < 1e3 * tol, "{tol:e}: {off:?}");
    }
}

#[test]
fn onsets_of_beads_that_touch_follow_the_rule_for_every_exponent_and_tolerance() {
    // Truth: the regularised run. Before, the log of collocation had onsets at which the force
    // began to matter at its tolerance: 8.901 at 1e-6 for bond 9 and alpha = 2.5, where the rule
    // says 9.270; 14.303 at 1e-10 for bond 13 and alpha = 3, where it says 14.625. Largest overlaps
    // were off by 9.2e-10 at 1e-13 for alpha = 1.1. Bounds are about twice what was measured.
    for (alpha, _) in DURATIONS {
        let run = struck(alpha, 16, [1.0, 0.0], 12.0);
        let truth = log(&run, "dop853-regularised", Setting::Tolerance(1e-13));
        let rows = [
            ("collocation", Setting::Tolerance(1e-6), [3e-4, 3e-4, 1e-4, 1e-4, 5e-6]),
            ("collocation", Setting::Tolerance(1e-10), [3e-7, 4e-7, 2e-7, 2e-7, 3e-9]),
            ("collocation", Setting::Tolerance(1e-13), [1.5e-9, 7e-10, 1.4e-8, 1.5e-9, 4e-12]),
            ("dop853", Setting::Tolerance(1e-10), [1.3e-6, 5e-8, 1.2e-6, 3e-8, 5e-9]),
            ("verlet", Setting::Steps(12_000), [1e-5, 2e-5, 2e-5, 3e-6, 2e-5]),
        ];
        // Where errors exceed a thousandth of G/1000, a method may see a zero or none.
        holds(&run, &truth, if alpha < 2.0 { &rows[1..] } else { &rows });
    }
}

#[test]
fn a_gap_that_never_closes_hides_no_contact_of_another_bond() {
    // Truth: the same bead without the second wall. Before, values up to 64 roundings of the gap
    // counted as rounding errors, and methods but collocation logged no contact.
    let scene = |boundary: &str, overlap: &str| {
        format!(
            "chain = {{ sites = 1, alpha = 1.5, boundary = \"{boundary}\" }}\nbonds = {{ overlap = [{overlap}] }}\n\
             initial = {{ kind = \"state\", u_dot = [-1e-7] }}\nspan = {{ until = 200.0 }}\n"
        )
    };
    for (name, setting) in [
        ("dop853-regularised", Setting::Tolerance(1e-10)),
        ("collocation", Setting::Tolerance(1e-10)),
        ("verlet", Setting::Steps(20_000)),
    ] {
        let [got, want] = [("fixed", "-1e-7, -1e9"), ("left-wall", "-1e-7")]
            .map(|(boundary, overlap)| logged(&scene(boundary, overlap), name, setting));
        assert_eq!((got.len(), want.len()), (1, 1), "{name}");
        assert!((got[0].impulse / want[0].impulse - 1.0).abs() < 1e-8, "{name}: {got:?} {want:?}");
    }
}

#[test]
fn a_struck_chain_has_one_contact_in_every_bond_that_the_wave_has_reached() {
    // Truth: the wave has passed or reached 88 bonds by t = 100, and presses bond 88 by 1.0e-9,
    // also by methods without a tolerance. Collocation had 97 contacts at 1e-6 and 93 at 1e-10:
    // behind the wave, beads whose velocities differ by errors only.
    let tolerances = [1e-6, 1e-8, 1e-10, 1e-12, 1e-14].map(|tol| ("collocation", Setting::Tolerance(tol)));
    let others = [
        ("dop853-regularised", Setting::Tolerance(1e-10)),
        ("corrected", Setting::Steps(6400)),
        ("verlet", Setting::Steps(12_800)),
        ("strang-linear", Setting::Steps(12_800)),
    ];
    for (name, setting) in tolerances.into_iter().chain(others) {
        let contacts = logged("impact", name, setting);
        let mut bonds: Vec<usize> = contacts.iter().map(|contact| contact.bond).collect();
        bonds.sort_unstable();
        assert!(bonds.iter().copied().eq(1..=88), "{name} {setting:?}: {bonds:?}");
        // At 1e-6 the force that presses bond 88 is below the tolerance.
        let found = contacts.iter().find(|contact| contact.bond == 88).unwrap().largest_overlap;
        let loose = setting == Setting::Tolerance(1e-6);
        assert!(loose || (found / 1.0076e-9 - 1.0).abs() < 5e-3, "{name} {setting:?}: {found:e}");
    }
}
