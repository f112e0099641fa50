//! Reports of one run.

use super::{
    Condition, Signals,
    checkpoint::FILE as CHECKPOINT,
    contacts::{bond_columns, contact_lines, contact_totals, contacts_csv, contacts_npz, pulse_line, raster},
    crossings::{crossing_lines, crossing_totals, crossings_csv, ended},
};
use crate::{
    chain::{Boundary, Energy, Ledger, Overlaps},
    error::Result,
    number::{format_short, rounded},
    numerics::least_by,
    output::{Folder, NpzWriter, write_csv, write_json},
    report::{Column, Kind, Line, Panel, Panels, Report, SpaceTime},
    run::{Profile, Trajectory},
    scene::{Quantity, Scene, Theory, Units},
    study::{
        scene_caption,
        si::{ALL_IN_SI, Scale},
    },
};
use hertzchain_integrators::Error as Failure;
use serde::{Serialize, Serializer, ser::SerializeMap};
use serde_json::json;
use std::{collections::BTreeMap, fs::File, io, io::Write};

/// The arrays of a state, with names: strains and rates `x, y, vx, vy` on a strain ring, else
/// displacements and momenta `u, v, pu, pv`.
///
/// Arrays of resonators are empty where none moves. `si`: the units of a state in SI units.
pub(in crate::study) fn state_arrays(
    scene: &Scene,
    state: &[f64],
    si: Option<&Units>,
) -> [(&'static str, Vec<f64>); 4] {
    [0, 1, 2, 3].map(|i| state_array(scene, state, i, si))
}

/// The array `i` of [`state_arrays`].
fn state_array(scene: &Scene, state: &[f64], i: usize, si: Option<&Units>) -> (&'static str, Vec<f64>) {
    let (chain, ring) = (scene.chain(), scene.chain().boundary() == Boundary::StrainRing);
    let names = if ring { ["x", "y", "vx", "vy"] } else { ["u", "v", "pu", "pv"] };
    let momentum = |(site, value): (usize, &f64)| match i {
        2 | 3 if !ring => chain.masses(site)[i - 2] * si.map_or(1.0, |si| si.mass_kg) * value,
        _ => *value,
    };
    (names[i], chain.layout().arrays(state)[i].iter().enumerate().map(momentum).collect())
}

/// `(E_x, E_y)` of (eq:relerr_tw) at the end, for waves.
fn wave_errors(scene: &Scene, outcome: &Trajectory) -> Option<(f64, f64)> {
    let layout = scene.chain().layout();
    match (scene.theory(), layout.v(&outcome.state)) {
        (Some(Theory::Wave(wave)), Some(y)) => Some(wave.errors(outcome.t, layout.u(&outcome.state), y)),
        _ => None,
    }
}

fn kinds(energy: &Energy<f64>) -> [(&'static str, f64); 4] {
    let Energy { beads, resonators, springs, contacts, .. } = *energy;
    [("beads", beads), ("resonators", resonators), ("springs", springs), ("contacts", contacts)]
}

/// A run and its result, as reports need them.
///
/// As JSON `energy` and `energy_error` are null where the strain ring has no energy; `reason` and
/// `amplification` are present if they are here, `si` if all numbers are in SI units.
#[derive(Clone, Copy, Debug)]
pub struct RunView<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The integrator.
    pub integrator: &'a str,
    /// Its setting in words.
    pub setting: &'a str,
    /// The reason for the choice of the integrator, see
    /// [`MethodChoice::reason`](super::MethodChoice::reason).
    pub reason: Option<&'a str>,
    /// The result of the run.
    pub outcome: &'a Trajectory,
    /// The factor by which a small change has grown, if it was asked for; see
    /// [`Run::amplification`](crate::run::Run::amplification).
    pub amplification: Option<f64>,
    /// The units that `outcome` is in, if it is in SI units; see [`in_units`](super::in_units).
    pub si: Option<&'a Units>,
    /// What the scene names to be kept in time, in the same units.
    pub signals: Option<&'a Signals>,
    /// The conditions that were looked for; the crossings of `outcome` are by their numbers.
    pub conditions: &'a [Condition],
    /// The names of its files; none before they are written.
    pub files: &'a [&'a str],
}

/// An entry that only some runs have.
fn some<M: SerializeMap>(map: &mut M, name: &str, value: Option<impl Serialize>) -> std::result::Result<(), M::Error> {
    value.map_or(Ok(()), |value| map.serialize_entry(name, &value))
}

/// Arrays as long as the chain are made one after the other: as a `serde_json::Value` each would
/// take several times the memory.
impl Serialize for RunView<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> std::result::Result<S::Ok, S::Error> {
        let &RunView { scene, outcome, si, conditions, .. } = self;
        let (contacts, stats, units) = (outcome.contacts.as_deref(), outcome.stats, scene.units());
        let (errors, looked) = (wave_errors(scene, outcome), (!conditions.is_empty()).then_some(conditions));
        let ledger = scene.chain().layout().ledger(&outcome.state);
        let lost = |one: &Ledger<f64>| json!({"drag": one.drag, "dashpots": one.dashpots, "contacts": one.contacts, "total": one.dissipated()});
        let mut map = to.serialize_map(None)?;
        map.serialize_entry("scene", scene.name())?;
        map.serialize_entry("integrator", self.integrator)?;
        map.serialize_entry("setting", self.setting)?;
        some(&mut map, "reason", self.reason)?;
        map.serialize_entry("t", &outcome.t)?;
        map.serialize_entry("period", &period(self))?;
        for (name, values) in (0..4).map(|i| state_array(scene, &outcome.state, i, si)) {
            map.serialize_entry(name, &values)?;
        }
        map.serialize_entry("energy", &outcome.energy.map(|energy| energy.total()))?;
        map.serialize_entry("energy_error", &outcome.energy_error)?;
        map.serialize_entry("energies", &outcome.energy.map(|energy| BTreeMap::from(kinds(&energy))))?;
        some(&mut map, "dissipated", ledger.as_ref().map(lost))?;
        some(&mut map, "driven", ledger.as_ref().map(|one| one.driven))?;
        some(&mut map, "units", units)?;
        some(&mut map, "si", units.map(|_| si.is_some()))?;
        some(&mut map, "largest_speed", fastest(self).map(|one| one.1))?;
        some(&mut map, "largest_force", contacts.map(|_| largest_force(self)))?;
        some(&mut map, "e_x_final", errors.map(|errors| errors.0))?;
        some(&mut map, "e_y_final", errors.map(|errors| errors.1))?;
        some(&mut map, "contacts", contacts.map(contact_totals))?;
        some(&mut map, "bonds", contacts.map(|all| BTreeMap::from(bond_columns(positions(self).0, all))))?;
        some(&mut map, "recorded", self.signals.map(Signals::summary))?;
        some(&mut map, "crossings", looked.map(|all| crossing_totals(all, outcome)))?;
        some(&mut map, "ended_by", looked.map(|all| ended(all, outcome).map(Condition::text)))?;
        map.serialize_entry("force_evaluations", &stats.force_evaluations)?;
        map.serialize_entry("steps", &stats.steps)?;
        map.serialize_entry("rejected", &stats.rejected)?;
        map.serialize_entry("wall_s", &outcome.wall.as_secs_f64())?;
        map.serialize_entry("sampling_s", &outcome.sampling.as_secs_f64())?;
        some(&mut map, "amplification", self.amplification)?;
        map.serialize_entry("warnings", &warnings(self).collect::<Vec<_>>())?;
        map.serialize_entry("failure", &outcome.failure.as_ref().map(ToString::to_string))?;
        map.serialize_entry("scene_file", &crate::study::scene_json(scene))?;
        map.serialize_entry("version", env!("CARGO_PKG_VERSION"))?;
        some(&mut map, "files", Some(self.files).filter(|files| !files.is_empty()))?;
        map.end()
    }
}

/// The fastest bead at the end, and its speed; none on a strain ring.
fn fastest(RunView { scene, outcome, .. }: &RunView<'_>) -> Option<(usize, f64)> {
    let speeds = scene.chain().layout().u_dot(&outcome.state).iter().map(|speed| speed.abs()).enumerate();
    least_by(speeds, |one| -one.1).filter(|_| scene.chain().boundary() != Boundary::StrainRing)
}

fn largest_force(RunView { outcome, .. }: &RunView<'_>) -> Option<f64> {
    outcome.contacts.as_ref()?.iter().map(|contact| contact.peak_force).reduce(f64::max)
}

/// What makes the run doubtful, in words.
fn warnings<'a>(&RunView { scene, outcome, .. }: &RunView<'a>) -> impl Iterator<Item = String> + use<'a> {
    scene.doubts().into_iter().chain(outcome.warnings.iter().map(ToString::to_string))
}

/// The period of the scene, in the units of the run.
fn period(RunView { scene, si, .. }: &RunView<'_>) -> f64 {
    scene.period() * si.map_or(1.0, |si| si.time_s)
}

/// The positions of the bonds of a chain whose beads just touch, and the unit of a speed along it:
/// in metres in SI units if the radii are known, else in bonds.
fn positions(RunView { scene, si, .. }: &RunView<'_>) -> (Vec<f64>, &'static str) {
    let n = scene.chain().sites();
    let radii = || scene.file().units.as_ref()?.radius.as_ref()?.of("units.radius", n).ok();
    let radii = si.and_then(|_| radii()).filter(|radii| radii.iter().all(|radius| radius.is_finite()));
    let ends = radii.iter().flatten().scan(0.0, |end, radius| {
        *end += 2.0 * radius;
        Some(*end)
    });
    let unit = if si.is_some() { "bonds/s" } else { "bonds per unit of time" };
    match radii {
        None => ((0..=n).map(|bond| bond as f64).collect(), unit),
        Some(_) => ([0.0].into_iter().chain(ends).collect(), "m/s"),
    }
}

/// The run in a few readable lines.
pub fn run_summary(ran: &RunView<'_>) -> String {
    let (&RunView { scene, integrator, setting, outcome, si, .. }, period) = (ran, period(ran));
    let (t, stats) = (si.map_or(outcome.t, |_| rounded(outcome.t)), outcome.stats);
    let line = |head: &str, words: String| format!("{head:<12}{words}");
    let what = Some(&scene.file().summary).filter(|summary| !summary.is_empty());
    let periods = if scene.has_period() { format!(" = {:.6} periods of {period}", t / period) } else { String::new() };
    let mut lines = vec![
        line("scene", scene.name().to_owned() + &what.map_or(String::new(), |summary| format!(" ({summary})"))),
        line("integrator", format!("{integrator}, {setting}")),
        line("reached", format!("t = {t}{periods}")),
    ];
    match outcome.energy {
        Some(energy) => {
            let parts = kinds(&energy).map(|(kind, value)| format!("{kind} {value:.6e}")).join(", ");
            let error = outcome.energy_error.unwrap_or(f64::NAN);
            lines.push(line("energy", format!("{:.16e} ({parts})", energy.total())));
            lines.push(line("", format!("largest error on the way {error:.3e}")));
            if scene.chain().open() {
                let (lost, driven) = (energy.dissipated, energy.driven);
                let words = "of energy + dissipated - driven";
                lines.push(line("", format!("{words}: dissipated {lost:.6e}, driven {driven:.6e}")));
            }
        }
        None => lines.push(line("energy", "none on this strain ring: sum x != sum y".to_owned())),
    }
    lines.extend(scene.units().map(|units| line("units", units.words())));
    if si.is_some() {
        let fastest = fastest(ran).map(|(bead, speed)| format!("{speed:.6e} m/s at the end, bead {bead}"));
        lines.push(line("", ALL_IN_SI.to_owned()));
        lines.extend(fastest.map(|words| line("fastest", words)));
        lines.extend(largest_force(ran).map(|force| line("largest", format!("force of a contact {force:.6e} N"))));
    }
    if let Some((e_x, e_y)) = wave_errors(scene, outcome) {
        let words = format!("E_x = {:.4} %, E_y = {:.4} % (eq:relerr_tw)", 100.0 * e_x, 100.0 * e_y);
        lines.push(line("ansatz", words));
    }
    if let Some(contacts) = &outcome.contacts {
        let (positions, unit) = positions(ran);
        lines.extend(contact_lines(contacts).into_iter().chain(pulse_line(&positions, unit, contacts)));
    }
    lines.extend(ran.signals.iter().flat_map(|signals| signals.lines(si.is_some())));
    lines.extend(crossing_lines(ran.conditions, outcome));
    let [wall, sampling] = [outcome.wall, outcome.sampling].map(|time| time.as_secs_f64());
    let work =
        format!("{} steps, {} rejected, {} force evaluations", stats.steps, stats.rejected, stats.force_evaluations);
    lines.push(line("work", format!("{work}, {wall:.3e} s, of which sampling {sampling:.3e} s")));
    let grown = |factor| format!("by {factor:.2e}: that much a small change of the initial state has grown");
    lines.extend(ran.amplification.map(|factor| line("amplified", grown(factor))));
    lines.extend(warnings(ran).map(|warning| line("WARNING", warning)));
    lines.extend(outcome.failure.as_ref().map(|failure| match failure.cause {
        Failure::Stopped { t } => line("stopped", format!("by a signal at t = {t}")),
        _ => line("FAILED", failure.to_string()),
    }));
    lines.join("\n") + "\n"
}

/// The JSON of a run with the names of its files.
const SUMMARY: &str = "summary.json";

/// Every file that a run may write, but for the checkpoint.
pub const RUN_FILES: &str = "summary.json scene.toml final.csv energy.csv profiles.npz profiles.csv signals.npz \
    signals.csv peaks.csv contacts.csv contacts.npz bonds.csv crossings.csv profile.png profile.svg spacetime.png \
    spacetime.svg energy.png energy.svg contacts.png contacts.svg signals.png signals.svg";

/// Writes the run: `scene.toml`, `final.csv`, `energy.csv`, `profiles.npz`, `profiles.csv`, or in
/// their place `signals.npz`, `signals.csv` and `peaks.csv`; with a contact log also
/// `contacts.csv`, `contacts.npz` and `bonds.csv`, with conditions `crossings.csv`; the pictures;
/// last `summary.json`, which is the JSON with the names of all files. Files of an earlier run are
/// removed before, and its checkpoint as well unless this run was `in_legs`.
///
/// # Errors
/// A file that cannot be written.
pub fn run_files(folder: &Folder, ran: &RunView<'_>, pictures: &[crate::study::File], in_legs: bool) -> Result<()> {
    let &RunView { scene, outcome, signals, conditions, .. } = ran;
    let checkpoint = [CHECKPOINT].into_iter();
    folder.remove(RUN_FILES.split(' ').chain(checkpoint.clone().filter(|_| !in_legs)))?;
    let mut files = vec![SUMMARY];
    let mut write = |name, content: &dyn Fn(&mut File) -> io::Result<()>| {
        files.push(name);
        folder.write_with(name, content).map(drop)
    };
    write("scene.toml", &|file| file.write_all(scene.file().to_toml().as_bytes()))?;
    write("final.csv", &|file| last_state(file, ran))?;
    write("energy.csv", &|file| energies(file, ran))?;
    match signals {
        Some(signals) => {
            write("signals.npz", &|file| signals.npz(NpzWriter::new(file, None)?))?;
            if let Some(text) = signals.csv() {
                write("signals.csv", &|file| file.write_all(&text))?;
            }
            write("peaks.csv", &|file| file.write_all(signals.peaks().csv().as_bytes()))?;
        }
        None => {
            write("profiles.npz", &|file| profiles(file, ran))?;
            write("profiles.csv", &|file| strains(file, ran))?;
        }
    }
    if let Some(contacts) = &outcome.contacts {
        let columns = bond_columns(positions(ran).0, contacts);
        let names: Vec<&str> = ["bond"].into_iter().chain(columns.iter().map(|(name, _)| *name)).collect();
        let row = |bond: usize| [bond as f64].into_iter().chain(columns.iter().map(|(_, all)| all[bond])).collect();
        let numbers = contacts_npz(contacts)?;
        write("contacts.csv", &|file| file.write_all(&contacts_csv(contacts)))?;
        write("contacts.npz", &|file| file.write_all(&numbers))?;
        write("bonds.csv", &|file| write_csv(file, &names, (0..=scene.chain().sites()).map(row)))?;
    }
    if !conditions.is_empty() {
        write("crossings.csv", &|file| file.write_all(&crossings_csv(outcome)))?;
    }
    pictures.iter().try_for_each(|(name, bytes)| write(name, &|file| file.write_all(bytes)))?;
    files.extend(checkpoint.filter(|_| in_legs));
    // The list of files comes last: without it a folder is not all of a run.
    folder.write_with(SUMMARY, |file| write_json(file, &RunView { files: &files, ..*ran })).map(drop)
}

/// Writes the last state as CSV, a row for each site.
fn last_state(file: &mut File, &RunView { scene, outcome, si, .. }: &RunView<'_>) -> io::Result<()> {
    let mut arrays = state_arrays(scene, &outcome.state, si).to_vec();
    arrays.retain(|(_, values)| !values.is_empty());
    let unit = |name: &str| if name.starts_with('p') { Quantity::Momentum } else { Quantity::Length };
    let heads: Vec<String> = arrays.iter().map(|(name, _)| Scale(si).label(name, unit(name))).collect();
    let names: Vec<&str> = ["n"].into_iter().chain(heads.iter().map(String::as_str)).collect();
    let row = |n: usize| [n as f64].into_iter().chain(arrays.iter().map(|(_, values)| values[n])).collect();
    write_csv(file, &names, (0..scene.chain().sites()).map(row))
}

/// Writes the energies of samples as CSV; of a chain that is open also what they have lost and got.
fn energies(file: &mut File, &RunView { scene, outcome, .. }: &RunView<'_>) -> io::Result<()> {
    let columns = ["t", "beads", "resonators", "springs", "contacts", "total", "dissipated", "driven"];
    let count = if scene.chain().open() { 8 } else { 6 };
    let row = |t: f64, energy: Energy<f64>| {
        let more = [energy.total(), energy.dissipated, energy.driven];
        [t].into_iter().chain(kinds(&energy).map(|(_, value)| value)).chain(more).take(count).collect()
    };
    let rows = outcome.samples.iter().filter_map(|sample| Some(row(sample.t, sample.energy?)));
    write_csv(file, &columns[..count], rows)
}

/// Writes the archive of profiles, a row at a time, as the profiles of a long chain may not fit
/// into memory twice.
fn profiles(file: &mut File, &RunView { scene, outcome, si, .. }: &RunView<'_>) -> io::Result<()> {
    let (mut archive, profiles) = (NpzWriter::new(file, None)?, &outcome.profiles);
    archive.vector("t", &profiles.iter().map(|profile| profile.t).collect::<Vec<_>>())?;
    let shape = |columns: usize| [profiles.len() as u64, if profiles.is_empty() { 0 } else { columns as u64 }];
    archive.begin("strain", &shape(profiles.first().map_or(0, |profile| profile.x.len())))?;
    profiles.iter().try_for_each(|profile| archive.row(&profile.x))?;
    let arrays = state_arrays(scene, scene.initial().as_slice(), si);
    for (i, (name, values)) in arrays.iter().enumerate().filter(|(_, (_, values))| !values.is_empty()) {
        archive.begin(name, &shape(values.len()))?;
        profiles.iter().try_for_each(|profile| archive.row(&state_array(scene, &profile.state, i, si).1))?;
    }
    archive.finish()
}

/// Writes the strains as CSV, a row for each time: `t`, then a column for each bond, named `x` and
/// its number.
fn strains(file: &mut File, &RunView { scene, outcome, .. }: &RunView<'_>) -> io::Result<()> {
    let overlaps = Overlaps::new(scene.chain().clone());
    let bonds = outcome.profiles.first().map_or(0, |profile| profile.x.len());
    let names: Vec<String> = (0..bonds).map(|bond| format!("x{}", overlaps.bond(bond))).collect();
    let names: Vec<&str> = ["t"].into_iter().chain(names.iter().map(String::as_str)).collect();
    let row = |profile: &Profile| [profile.t].into_iter().chain(profile.x.iter().copied()).collect();
    write_csv(file, &names, outcome.profiles.iter().map(row))
}

/// The pictures of a run: the profile at the end, the strain over space and time, the energy error,
/// contacts and what the scene records, as far as there are any.
pub fn run_pictures(ran: &RunView<'_>) -> Report {
    let &RunView { scene, integrator, setting, outcome, si, .. } = ran;
    let how = format!("Integrator {integrator}, {setting}.").replace(".000000 a period", " a period");
    let caption = |what: &str| format!("{what} {}", scene_caption(scene, &how));
    let time = Scale(si).label("time t", Quantity::Time);
    let mut report = Report::new("run").picture_named("profile", profile_figure(ran, &caption));
    if !outcome.profiles.is_empty() {
        report = report.picture_named("spacetime", space_time(ran, &time, &caption));
    }
    let errors = energy_errors(outcome);
    if !errors.is_empty() {
        let (error, what) = if scene.chain().open() {
            (
                "largest |B − B(0)| up to t, relative",
                "Error of the balance B, energy + dissipated − driven, over the largest of these three; the largest so far, from a thousandth of the last on.",
            )
        } else {
            (
                "largest |E − E(0)| / |E(0)| up to t",
                "Relative error of the total energy; the largest so far, from a thousandth of the last on.",
            )
        };
        let panel = Panel::new(Kind::LogTime, [&time, error], vec![Line::new(integrator, errors)]);
        let title = format!("{}: relative energy error", scene.name());
        report = report.picture_named("energy", Panels::column(title, vec![panel], caption(what)));
    }
    if let Some(contacts) = &outcome.contacts {
        report = report.picture_named("contacts", raster((scene, si), (&time, outcome.t), contacts, &caption));
    }
    if let Some(signals) = ran.signals {
        let (title, what) = (format!("{}: recorded", scene.name()), "What the scene records, at up to eight places.");
        report = report.picture_named("signals", signals.panels(title, caption(what), si));
    }
    report
}

/// The strain over space and time; of a long run the largest strain of each period, and its last
/// periods.
fn space_time(ran: &RunView<'_>, time: &str, caption: &dyn Fn(&str) -> String) -> Panels {
    let &RunView { scene, outcome, si, .. } = ran;
    let (profiles, last) = (&outcome.profiles, &outcome.profiles[outcome.profiles.len() - 1]);
    let (range, clips) = strain_range(outcome);
    let loaded = scene.chain().precompression() > 0.0
        || scene.chain().details().is_some_and(|details| !details.overlap.is_empty());
    let (what, signs) = match loaded {
        true => ("strains", "Strain beside the static overlap: negative (blue) presses more, positive (red) less"),
        // Beads with static overlaps of their own may be in contact at both signs.
        false => ("gaps", "Negative strain (blue) is contact, positive (red) a gap"),
    };
    let clipped =
        if clips { format!("; {what} beyond {} are off the scale", format_short(range)) } else { String::new() };
    let (seen, bonds) = (moving(outcome, range), last.x.len());
    let part = match seen.len() < bonds {
        true => format!(" The other bonds of {bonds} move by less than {MOVES} of the largest strain."),
        false => String::new(),
    };
    let title = format!("{}: strain over space and time", scene.name());
    let map = |profiles: &[Profile], times: (f64, f64)| SpaceTime {
        site_label: "bond n".to_owned(),
        time_label: time.to_owned(),
        value_label: Scale(si).label("strain xₙ", Quantity::Length),
        values: profiles.iter().flat_map(|profile| profile.x[seen.clone()].iter().copied()).collect(),
        most: Some(range),
        sites: seen.len(),
        first_site: first_bond(scene) + seen.start as f64,
        times,
        signed: true,
    };
    let words = format!("{signs}{clipped}.{part}");
    let period = period(ran);
    let each = (period * (profiles.len() - 1) as f64 / last.t).round() as usize;
    if last.t <= LONG * period || each < SEEN {
        return Panels::column(title, vec![map(profiles, (0.0, last.t))], caption(&words));
    }
    // Single oscillations of a long run would be narrower than a pixel.
    let most = |rows: &[Profile], n: usize| rows.iter().map(|row| row.x[n].abs()).fold(0.0, f64::max);
    let largest = |rows: &[Profile]| (0..bonds).map(|n| most(rows, n)).collect();
    let rows: Vec<Profile> =
        profiles.chunks_exact(each).map(|rows| Profile { x: largest(rows), ..rows[0].clone() }).collect();
    let half = 0.5 * each as f64 * last.t / (profiles.len() - 1) as f64;
    let window = &profiles[profiles.len() - (WINDOW * each).min(profiles.len())..];
    let envelope = SpaceTime {
        signed: false,
        value_label: Scale(si).label("largest |xₙ|", Quantity::Length),
        ..map(&rows, (half, (2 * rows.len() - 1) as f64 * half))
    };
    let columns = vec![
        Column::new("largest |xₙ| in each period", [envelope]),
        Column::new(format!("the last {WINDOW} periods"), [map(window, (window[0].t, last.t))]),
    ];
    Panels { title, columns, caption: caption(&format!("Left: the whole run; right: its end. {words}")) }
}

/// A run of more periods has the largest strain of each period over space and time, and its last
/// periods, if each has this many rows.
const LONG: f64 = 40.0;
const WINDOW: usize = 6;
const SEEN: usize = 3;

/// The number of the first bond with a strain. A bond has the number of the site to its right; the
/// first site of a free chain has no bond.
fn first_bond(scene: &Scene) -> f64 {
    Overlaps::new(scene.chain().clone()).bond(0) as f64
}

/// The largest strain of the colour scale, and whether gaps exceed it: the largest strain there is,
/// but the largest overlap if gaps are more than four times as wide, so that contacts are seen.
fn strain_range(outcome: &Trajectory) -> (f64, bool) {
    let strains = || outcome.profiles.iter().flat_map(|profile| profile.x.iter().copied());
    let (overlap, gap) = strains().fold((0.0f64, 0.0f64), |(overlap, gap), x| (overlap.max(-x), gap.max(x)));
    let wide = overlap > 0.0 && gap > 4.0 * overlap;
    let range = if wide { overlap } else { gap.max(overlap).max(f64::MIN_POSITIVE) };
    (range, gap > range)
}

/// Share of the largest strain of the colour scale by which a strain changes in a bond that moves.
const MOVES: f64 = 1e-3;

/// The bonds that are seen over space and time, counted among those with a strain: those that move,
/// with as many on either side, if they are a small part of the chain, and otherwise all.
fn moving(outcome: &Trajectory, range: f64) -> std::ops::Range<usize> {
    let Some(start) = outcome.profiles.first().map(|profile| &profile.x) else { return 0..0 };
    let moves = |bond: &usize| outcome.profiles.iter().any(|one| (one.x[*bond] - start[*bond]).abs() > MOVES * range);
    let (all, ends) = (0..start.len(), [(0..start.len()).find(moves), (0..start.len()).rfind(moves)]);
    let [Some(first), Some(last)] = ends else { return all };
    let room = last - first + 10;
    let seen = first.saturating_sub(room)..(last + 1 + room).min(all.end);
    if 4 * seen.len() < all.end { seen } else { all }
}

/// The largest error of the energy up to each sample, in the unit of [`Trajectory::energy_error`],
/// from a thousandth of its last value on: at first it is a rounding.
fn energy_errors(outcome: &Trajectory) -> Vec<(f64, f64)> {
    let all = outcome.samples.iter().map(|sample| (sample.t, sample.energy)).chain([(outcome.t, outcome.energy)]);
    let balances = all.filter_map(|(t, energy)| Some((t, energy?.balance())));
    let so_far = balances.scan((None, 0.0f64), |(first, most), (t, balance)| {
        *most = most.max((balance - *first.get_or_insert(balance)).abs());
        Some((t, *most))
    });
    let mut errors: Vec<(f64, f64)> = so_far.collect();
    let end = errors.last().map_or(0.0, |last| last.1);
    errors.retain(|(_, error)| *error > 1e-3 * end);
    errors.iter_mut().for_each(|(_, error)| *error *= outcome.energy_error.unwrap_or(0.0) / end);
    errors
}

fn profile_figure(&RunView { scene, outcome, si, .. }: &RunView<'_>, caption: &dyn Fn(&str) -> String) -> Panels {
    let (layout, first) = (scene.chain().layout(), first_bond(scene));
    let ring = scene.chain().boundary() == Boundary::StrainRing;
    let line =
        |name: &str, values: &[f64]| Line::new(name, (0..).map(|n| first + f64::from(n)).zip(values.iter().copied()));
    let mut strains = vec![("strain xₙ", scene.strains(&outcome.state))];
    strains.extend(layout.v(&outcome.state).filter(|_| ring).map(|y| ("strain yₙ", y.to_vec())));
    let panels = strains.into_iter().enumerate().map(|(i, (label, values))| {
        let mut lines = vec![line("numerical", &values)];
        if let Some(Theory::Wave(wave)) = scene.theory() {
            let at = |n| wave.site(n, outcome.t);
            let ansatz: Vec<f64> = (0..layout.sites()).map(|n| if i == 0 { at(n).u } else { at(n).v }).collect();
            lines.push(line("ansatz", &ansatz));
        }
        let labels = [if ring { "site n" } else { "bond n" }, &Scale(si).label(label, Quantity::Length)];
        Panel::new(Kind::Sites, labels, lines)
    });
    let t = si.map_or_else(|| format!("{:.6}", outcome.t), |_| format!("{:.6e} s", outcome.t));
    let caption = caption(match scene.theory() {
        Some(Theory::Wave(_)) => "Strains at the end of the run beside the first-order ansatz.",
        _ => "Strains at the end of the run.",
    });
    Panels::column(format!("{}: strain profile at t = {t}", scene.name()), panels.collect(), caption)
}
