//! Reports of one run.

use super::{
    Condition, Signals,
    checkpoint::FILE as CHECKPOINT,
    contacts::{bond_columns, contact_lines, contact_totals, contacts_csv, contacts_npz, pulse_line},
    crossings::{crossing_lines, crossing_totals, crossings_csv, ended},
};
use crate::{
    chain::{Boundary, Energy, Ledger, Overlaps},
    error::Result,
    number::rounded,
    output::{Folder, NpzWriter, csv, write_csv, write_json},
    run::{Profile, Trajectory},
    scene::{Scene, Theory, Units},
    study::si::ALL_IN_SI,
};
#[cfg(feature = "plot")]
use crate::{scene::Quantity, study::si::Scale};
use hertzchain_integrators::Error as Failure;
use serde::{Serialize, Serializer};
use serde_json::{Value, json};
use std::{
    collections::BTreeMap,
    fs::File,
    io::{BufWriter, Write},
};

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
    let (chain, layout) = (scene.chain(), scene.chain().layout());
    let ring = scene.chain().boundary() == Boundary::StrainRing;
    let values = match i {
        0 => layout.u(state),
        1 => layout.v(state).unwrap_or_default(),
        2 => layout.u_dot(state),
        _ => layout.v_dot(state).unwrap_or_default(),
    };
    let names = if ring { ["x", "y", "vx", "vy"] } else { ["u", "v", "pu", "pv"] };
    let momentum = |site: usize, value: f64| match i {
        2 | 3 if !ring => chain.masses(site)[i - 2] * si.map_or(1.0, |si| si.mass_kg) * value,
        _ => value,
    };
    (names[i], values.iter().enumerate().map(|(site, &value)| momentum(site, value)).collect())
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
    [
        ("beads", energy.beads),
        ("resonators", energy.resonators),
        ("springs", energy.springs),
        ("contacts", energy.contacts),
    ]
}

/// A run and its result, as reports need them.
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
}

/// The run as JSON. `energy` and `energy_error` are null where the strain ring has no energy;
/// `reason` and `amplification` are present if those of [`RunView`] are, `si` if all numbers are in
/// SI units.
pub fn run_json(ran: &RunView<'_>) -> Value {
    json!(entries(ran))
}

/// The JSON of a run: names and entries, in the order in which they are written.
struct Entries(Vec<(&'static str, Entry)>);

impl Serialize for Entries {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, entry)| (name, entry)))
    }
}

#[derive(Serialize)]
#[serde(untagged)]
enum Entry {
    /// An array that is as long as the chain. As a `Value` it would take four times the memory.
    Numbers(Vec<f64>),
    /// Several of them, by name.
    Columns(BTreeMap<&'static str, Vec<f64>>),
    Value(Value),
}

fn entries(ran: &RunView<'_>) -> Entries {
    let &RunView { scene, integrator, setting, reason, outcome, amplification, si, signals, conditions } = ran;
    let mut object = Vec::new();
    let mut put = |name, value| object.push((name, Entry::Value(value)));
    put("scene", json!(scene.name()));
    put("integrator", json!(integrator));
    put("setting", json!(setting));
    if let Some(reason) = reason {
        put("reason", json!(reason));
    }
    put("t", json!(outcome.t));
    put("period", json!(period(ran)));
    let arrays = state_arrays(scene, &outcome.state, si);
    object.extend(arrays.map(|(name, values)| (name, Entry::Numbers(values))));
    let mut put = |name, value| object.push((name, Entry::Value(value)));
    put("energy", json!(outcome.energy.map(|energy| energy.total())));
    put("energy_error", json!(outcome.energy_error));
    put(
        "energies",
        outcome.energy.map_or(Value::Null, |energy| json!(kinds(&energy).into_iter().collect::<BTreeMap<_, _>>())),
    );
    if let Some(ledger) = scene.chain().layout().ledger(&outcome.state) {
        let Ledger { drag, dashpots, contacts, driven } = ledger;
        let total = ledger.dissipated();
        put("dissipated", json!({"drag": drag, "dashpots": dashpots, "contacts": contacts, "total": total}));
        put("driven", json!(driven));
    }
    if let Some(units) = scene.units() {
        put("units", json!(units));
        put("si", json!(si.is_some()));
    }
    if let Some((_, speed)) = fastest(ran) {
        put("largest_speed", json!(speed));
    }
    if outcome.contacts.is_some() {
        put("largest_force", json!(largest_force(ran)));
    }
    if let Some((e_x, e_y)) = wave_errors(scene, outcome) {
        put("e_x_final", json!(e_x));
        put("e_y_final", json!(e_y));
    }
    if let Some(contacts) = &outcome.contacts {
        put("contacts", json!(contact_totals(contacts)));
        object.push(("bonds", Entry::Columns(bond_columns(positions(ran).0, contacts).into())));
    }
    let mut put = |name, value| object.push((name, Entry::Value(value)));
    if let Some(signals) = signals {
        put("recorded", signals.summary());
    }
    if !conditions.is_empty() {
        put("crossings", crossing_totals(conditions, outcome));
        put("ended_by", json!(ended(conditions, outcome).map(Condition::text)));
    }
    put("force_evaluations", json!(outcome.stats.force_evaluations));
    put("steps", json!(outcome.stats.steps));
    put("rejected", json!(outcome.stats.rejected));
    put("wall_s", json!(outcome.wall.as_secs_f64()));
    put("sampling_s", json!(outcome.sampling.as_secs_f64()));
    if let Some(factor) = amplification {
        put("amplification", json!(factor));
    }
    put("warnings", json!(warnings(ran).collect::<Vec<_>>()));
    put("failure", json!(outcome.failure.as_ref().map(ToString::to_string)));
    put("scene_file", crate::study::scene_json(scene));
    put("version", json!(env!("CARGO_PKG_VERSION")));
    Entries(object)
}

/// The fastest bead at the end, and its speed; none on a strain ring.
fn fastest(RunView { scene, outcome, .. }: &RunView<'_>) -> Option<(usize, f64)> {
    let speeds = scene.chain().layout().u_dot(&outcome.state).iter().map(|speed| speed.abs()).enumerate();
    let largest = speeds.reduce(|a, b| if b.1 > a.1 { b } else { a });
    largest.filter(|_| scene.chain().boundary() != Boundary::StrainRing)
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
    let t = if si.is_some() { rounded(outcome.t) } else { outcome.t };
    let summary = &scene.file().summary;
    let what = if summary.is_empty() { String::new() } else { format!(" ({summary})") };
    let mut lines = vec![
        format!("scene       {}{what}", scene.name()),
        format!("integrator  {integrator}, {setting}"),
        match scene.has_period() {
            true => format!("reached     t = {t} = {:.6} periods of {period}", t / period),
            false => format!("reached     t = {t}"),
        },
    ];
    match outcome.energy {
        Some(energy) => {
            let parts = kinds(&energy).map(|(kind, value)| format!("{kind} {value:.6e}")).join(", ");
            lines.push(format!("energy      {:.16e} ({parts})", energy.total()));
            lines
                .push(format!("            largest error on the way {:.3e}", outcome.energy_error.unwrap_or(f64::NAN)));
            if scene.chain().open() {
                let words = "of energy + dissipated - driven";
                lines.push(format!(
                    "            {words}: dissipated {:.6e}, driven {:.6e}",
                    energy.dissipated, energy.driven
                ));
            }
        }
        None => lines.push("energy      none on this strain ring: sum x != sum y".to_owned()),
    }
    if let Some(units) = scene.units() {
        lines.push(format!("units       {}", units.words()));
        if si.is_some() {
            lines.push(format!("            {ALL_IN_SI}"));
            lines.extend(
                fastest(ran).map(|(bead, speed)| format!("fastest     {speed:.6e} m/s at the end, bead {bead}")),
            );
            lines.extend(largest_force(ran).map(|force| format!("largest     force of a contact {force:.6e} N")));
        }
    }
    if let Some((e_x, e_y)) = wave_errors(scene, outcome) {
        lines.push(format!("ansatz      E_x = {:.4} %, E_y = {:.4} % (eq:relerr_tw)", 100.0 * e_x, 100.0 * e_y));
    }
    if let Some(contacts) = &outcome.contacts {
        lines.extend(contact_lines(contacts));
        let (positions, unit) = positions(ran);
        lines.extend(pulse_line(&positions, unit, contacts));
    }
    lines.extend(ran.signals.iter().flat_map(|signals| signals.lines(si.is_some())));
    lines.extend(crossing_lines(ran.conditions, outcome));
    let stats = outcome.stats;
    lines.push(format!(
        "work        {} steps, {} rejected, {} force evaluations, {:.3e} s, of which sampling {:.3e} s",
        stats.steps,
        stats.rejected,
        stats.force_evaluations,
        outcome.wall.as_secs_f64(),
        outcome.sampling.as_secs_f64()
    ));
    if let Some(factor) = ran.amplification {
        lines.push(format!("amplified   by {factor:.2e}: that much a small change of the initial state has grown"));
    }
    lines.extend(warnings(ran).map(|warning| format!("WARNING     {warning}")));
    if let Some(failure) = &outcome.failure {
        lines.push(match failure.cause {
            Failure::Stopped { t } => format!("stopped     by a signal at t = {t}"),
            _ => format!("FAILED      {failure}"),
        });
    }
    lines.join("\n") + "\n"
}

/// The JSON of a run with the names of its files.
const SUMMARY: &str = "summary.json";

/// Every file that a run may write, but for the checkpoint.
pub const RUN_FILES: [&str; 23] = [
    SUMMARY,
    "scene.toml",
    "final.csv",
    "energy.csv",
    "profiles.npz",
    "profiles.csv",
    "signals.npz",
    "signals.csv",
    "peaks.csv",
    "contacts.csv",
    "contacts.npz",
    "bonds.csv",
    "crossings.csv",
    "profile.png",
    "profile.svg",
    "spacetime.png",
    "spacetime.svg",
    "energy.png",
    "energy.svg",
    "contacts.png",
    "contacts.svg",
    "signals.png",
    "signals.svg",
];

/// Writes the run: `scene.toml`, `final.csv`, `energy.csv`, `profiles.npz`, `profiles.csv`, or in
/// their place `signals.npz`, `signals.csv` and `peaks.csv`, and the pictures; with a contact log
/// also `contacts.csv`, `contacts.npz` and `bonds.csv`,
/// with conditions `crossings.csv`; last `summary.json`, which is the JSON with the names of all
/// files. Other files of an earlier run are removed, and its checkpoint as well unless this run was
/// `in_legs`. If the parts of the chain keep
/// the states, only `summary.json`, without the state, `scene.toml` and `energy.csv` are written.
///
/// # Errors
/// A file that cannot be written.
pub fn run_files(folder: &Folder, ran: &RunView<'_>, pictures: &[crate::study::File], in_legs: bool) -> Result<()> {
    let &RunView { scene, outcome, si, signals, conditions, .. } = ran;
    let in_csv = signals.and_then(Signals::csv);
    let (logged, compress) = (outcome.contacts.is_some(), scene.file().record.compress == Some(true));
    let written = |name: &str| match name {
        CHECKPOINT => in_legs,
        _ if [".png", ".svg"].iter().any(|end| name.ends_with(end)) => pictures.iter().any(|picture| picture.0 == name),
        "crossings.csv" => !conditions.is_empty(),
        "signals.csv" => in_csv.is_some(),
        "signals.npz" | "peaks.csv" => signals.is_some(),
        _ if name.starts_with("profiles") => signals.is_none(),
        _ => logged || !(name.starts_with("contacts") || name == "bonds.csv"),
    };
    let (files, left): (Vec<&str>, Vec<&str>) =
        RUN_FILES.into_iter().chain([CHECKPOINT]).partition(|name| written(name));
    // The list of files comes last: without it a folder is not all of a run.
    folder.remove(left.into_iter().chain([SUMMARY]))?;
    folder.write("scene.toml", scene.file().to_toml().as_bytes())?;
    folder.write_with("final.csv", |file| buffered(file, |out| last_state(out, ran)))?;
    if let Some(signals) = signals {
        folder.write_with("signals.npz", |file| signals.npz(NpzWriter::new(file, None)?.compress(compress)))?;
        in_csv.map(|text| folder.write("signals.csv", &text)).transpose()?;
        folder.write("peaks.csv", signals.peaks().csv().as_bytes())?;
    } else {
        folder.write_with("profiles.npz", |file| profiles(file, scene, &outcome.profiles, si))?;
        folder.write_with("profiles.csv", |file| strains(file, scene, &outcome.profiles))?;
    }
    let open = scene.chain().open();
    let energies = outcome.samples.iter().filter_map(|sample| {
        let energy = sample.energy?;
        let work = [energy.dissipated, energy.driven].into_iter().take(if open { 2 } else { 0 });
        Some([sample.t].into_iter().chain(kinds(&energy).map(|(_, e)| e)).chain([energy.total()]).chain(work).collect())
    });
    let columns = ["t", "beads", "resonators", "springs", "contacts", "total", "dissipated", "driven"];
    folder.write("energy.csv", &csv(&columns[..if open { 8 } else { 6 }], energies))?;
    if let Some(contacts) = &outcome.contacts {
        folder.write("contacts.csv", &contacts_csv(contacts))?;
        folder.write("contacts.npz", &contacts_npz(contacts)?)?;
        let columns = bond_columns(positions(ran).0, contacts);
        let names: Vec<&str> = ["bond"].into_iter().chain(columns.iter().map(|(name, _)| *name)).collect();
        let row = |bond: usize| [bond as f64].into_iter().chain(columns.iter().map(|(_, all)| all[bond])).collect();
        folder.write("bonds.csv", &csv(&names, (0..=scene.chain().sites()).map(row)))?;
    }
    if !conditions.is_empty() {
        folder.write("crossings.csv", &crossings_csv(outcome))?;
    }
    pictures.iter().try_for_each(|(name, png)| folder.write(name, png).map(drop))?;
    let mut summary = entries(ran);
    summary.0.push(("files", Entry::Value(json!(files))));
    folder.write_with(SUMMARY, |file| buffered(file, |out| write_json(out, &summary))).map(drop)
}

/// Writes to a file through a buffer.
fn buffered(
    file: &mut File,
    write: impl FnOnce(&mut BufWriter<&mut File>) -> std::io::Result<()>,
) -> std::io::Result<()> {
    let mut out = BufWriter::new(file);
    write(&mut out)?;
    out.flush()
}

/// Writes the last state as CSV, a row for each site.
fn last_state(out: impl Write, &RunView { scene, outcome, si, .. }: &RunView<'_>) -> std::io::Result<()> {
    let arrays = state_arrays(scene, &outcome.state, si);
    let present: Vec<_> = arrays.iter().filter(|(_, values)| !values.is_empty()).collect();
    let unit = |name: &str| if name.starts_with('p') { Quantity::Momentum } else { Quantity::Length };
    let heads: Vec<String> = present.iter().map(|(name, _)| Scale(si).label(name, unit(name))).collect();
    let names: Vec<&str> = ["n"].into_iter().chain(heads.iter().map(String::as_str)).collect();
    let row = |n: usize| [n as f64].into_iter().chain(present.iter().map(|(_, values)| values[n])).collect();
    write_csv(out, &names, (0..scene.chain().sites()).map(row))
}

/// Writes the archive of profiles, a row at a time, as the profiles of a long chain may not fit
/// into memory twice.
fn profiles(file: &mut File, scene: &Scene, profiles: &[Profile], si: Option<&Units>) -> std::io::Result<()> {
    let mut archive = NpzWriter::new(file, None)?.compress(scene.file().record.compress == Some(true));
    archive.vector("t", &profiles.iter().map(|profile| profile.t).collect::<Vec<_>>())?;
    let rows = profiles.len() as u64;
    let columns = |row: Option<usize>| [rows, row.unwrap_or(0) as u64];
    archive.begin("strain", &columns(profiles.first().map(|profile| profile.x.len())))?;
    profiles.iter().try_for_each(|profile| archive.row(&profile.x))?;
    let arrays = state_arrays(scene, scene.initial().as_slice(), si);
    for (i, (name, values)) in arrays.iter().enumerate().filter(|(_, (_, values))| !values.is_empty()) {
        archive.begin(name, &columns(profiles.first().map(|_| values.len())))?;
        for profile in profiles {
            archive.row(&state_array(scene, &profile.state, i, si).1)?;
        }
    }
    archive.finish()
}

/// Writes the strains as CSV, a row for each time: `t`, then a column for each bond, named `x` and
/// its number.
fn strains(file: &mut File, scene: &Scene, profiles: &[Profile]) -> std::io::Result<()> {
    let overlaps = Overlaps::new(scene.chain().clone());
    let bonds = profiles.first().map_or(0, |profile| profile.x.len());
    let mut out = BufWriter::new(file);
    let head: String = (0..bonds).map(|bond| format!(",x{}", overlaps.bond(bond))).collect();
    writeln!(out, "t{head}")?;
    for Profile { t, x, .. } in profiles {
        write!(out, "{t:e}")?;
        x.iter().try_for_each(|x| write!(out, ",{x:e}"))?;
        writeln!(out)?;
    }
    out.flush()
}

/// The pictures of a run: the profile at the end, the strain over space and time, the energy error;
/// none if the parts of the chain keep the states.
///
/// # Errors
/// A picture that cannot be drawn.
#[cfg(feature = "plot")]
pub fn run_pictures(ran: &RunView<'_>) -> Result<Vec<crate::study::Drawing>> {
    use crate::figures;
    let &RunView { scene, integrator, setting, outcome, si, .. } = ran;
    let how = format!("Integrator {integrator}, {setting}.").replace(".000000 a period", " a period");
    let caption = |what: &str| format!("{what} {}", crate::study::provenance(scene, &how));
    let mut pictures = vec![("profile.png", figures::panels(&profile_figure(ran, &caption))?)];
    if let Some(last) = outcome.profiles.last() {
        let (range, clips) = strain_range(outcome);
        let clipped = if clips {
            let what = if loaded(scene) { "strains" } else { "gaps" };
            format!("; magenta: {what} beyond {}", crate::number::format_short(range))
        } else {
            String::new()
        };
        let (seen, bonds) = (moving(outcome, range), last.x.len());
        let part = match seen.len() {
            part if part < bonds => {
                format!(" The other bonds of {bonds} move by less than {MOVES} of the largest strain.")
            }
            _ => String::new(),
        };
        let title = format!("{}: strain over space and time", scene.name());
        let map = |profiles: &[Profile], times: (f64, f64)| figures::SpaceTime {
            site_label: "bond n".to_owned(),
            time_label: Scale(si).label("time t", Quantity::Time),
            value_label: Scale(si).label("strain xₙ", Quantity::Length),
            values: profiles.iter().flat_map(|profile| profile.x[seen.clone()].iter().copied()).collect(),
            most: Some(range),
            sites: seen.len(),
            first_site: first_bond(scene) + seen.start as f64,
            times,
            signed: true,
            ..Default::default()
        };
        let (profiles, words) = (&outcome.profiles, format!("{}{clipped}.{part}", strain_words(scene)));
        let period = Scale(si).reported(Quantity::Time, scene.period());
        let each = (period * (profiles.len() - 1) as f64 / last.t).round() as usize;
        let spacetime = if last.t <= LONG * period || each < SEEN {
            let (title, caption) = (title, caption(&words));
            figures::space_time(&figures::SpaceTime { title, caption, ..map(profiles, (0.0, last.t)) })?
        } else {
            // Single oscillations of a long run would be narrower than a pixel.
            let most = |rows: &[Profile], n: usize| rows.iter().map(|row| row.x[n].abs()).fold(0.0, f64::max);
            let largest = |rows: &[Profile]| (0..bonds).map(|n| most(rows, n)).collect();
            let rows: Vec<Profile> =
                profiles.chunks_exact(each).map(|rows| Profile { x: largest(rows), ..rows[0].clone() }).collect();
            let half = 0.5 * each as f64 * last.t / (profiles.len() - 1) as f64;
            let window = &profiles[profiles.len() - (WINDOW * each).min(profiles.len())..];
            let envelope = figures::SpaceTime {
                most: None,
                signed: false,
                value_label: Scale(si).label("largest |xₙ|", Quantity::Length),
                ..map(&rows, (half, (2 * rows.len() - 1) as f64 * half))
            };
            let columns = vec![
                figures::Column::new("largest |xₙ| in each period", [envelope]),
                figures::Column::new(format!("the last {WINDOW} periods"), [map(window, (window[0].t, last.t))]),
            ];
            let caption = caption(&format!("Left: the whole run; right: its end. {words}"));
            figures::panels(&figures::Panels { title, columns, caption })?
        };
        pictures.push(("spacetime.png", spacetime));
    }
    let errors = energy_errors(scene, outcome);
    if !errors.is_empty() {
        let lines = vec![figures::Line { name: integrator.to_owned(), points: errors }];
        let (error, what) = if scene.chain().open() {
            (
                "|B(t) − B(0)| / max E",
                "Error of the balance B, energy + dissipated − driven, over the largest energy; points without error are left out.",
            )
        } else {
            (
                "|E(t) − E(0)| / |E(0)|",
                "Relative error of the total energy at the sample times; points without error are left out.",
            )
        };
        let time = Scale(si).label("time t", Quantity::Time);
        let panel = figures::Panel::new(figures::Kind::LogTime, [time.as_str(), error], lines);
        let title = format!("{}: relative energy error", scene.name());
        pictures.push(("energy.png", figures::panels(&figures::Panels::column(title, vec![panel], caption(what)))?));
    }
    if let Some(signals) = ran.signals {
        let (title, what) = (format!("{}: recorded", scene.name()), "What the scene records, at up to eight places.");
        pictures.push(("signals.png", figures::panels(&signals.panels(title, caption(what), si))?));
    }
    if let Some(contacts) = &outcome.contacts {
        pictures.push(("contacts.png", super::contacts::contacts_picture(scene, &how, outcome.t, contacts, si)?));
    }
    Ok(pictures.into_iter().map(|(name, picture)| (name.to_owned(), picture)).collect())
}

/// A run of more periods has the largest strain of each period over space and time, and its last
/// periods, if each has this many rows.
#[cfg(feature = "plot")]
const LONG: f64 = 40.0;
#[cfg(feature = "plot")]
const WINDOW: usize = 6;
#[cfg(feature = "plot")]
const SEEN: usize = 3;

/// The number of the first bond with a strain. A bond has the number of the site to its right; the
/// first site of a free chain has no bond.
#[cfg(feature = "plot")]
fn first_bond(scene: &Scene) -> f64 {
    Overlaps::new(scene.chain().clone()).bond(0) as f64
}

/// What the sign of a strain means, in words. Beads with static overlaps of their own may be in
/// contact at both signs.
#[cfg(feature = "plot")]
fn strain_words(scene: &Scene) -> &'static str {
    if loaded(scene) {
        "Strain beside the static overlap: negative (blue) presses more, positive (red) less"
    } else {
        "Negative strain (blue) is contact, positive (red) a gap"
    }
}

/// Whether beads have static overlaps.
#[cfg(feature = "plot")]
fn loaded(scene: &Scene) -> bool {
    let chain = scene.chain();
    chain.precompression() > 0.0 || chain.details().is_some_and(|details| !details.overlap.is_empty())
}

/// The largest strain of the colour scale, and whether gaps exceed it: the largest strain there is,
/// but the largest overlap if gaps are more than four times as wide, so that contacts are seen.
#[cfg(feature = "plot")]
fn strain_range(outcome: &Trajectory) -> (f64, bool) {
    let strains = || outcome.profiles.iter().flat_map(|profile| profile.x.iter().copied());
    let (overlap, gap) = strains().fold((0.0f64, 0.0f64), |(overlap, gap), x| (overlap.max(-x), gap.max(x)));
    let wide = overlap > 0.0 && gap > 4.0 * overlap;
    let range = if wide { overlap } else { gap.max(overlap).max(f64::MIN_POSITIVE) };
    (range, gap > range)
}

/// Share of the largest strain of the colour scale by which a strain changes in a bond that moves.
#[cfg(feature = "plot")]
const MOVES: f64 = 1e-3;

/// The bonds that are seen over space and time, counted among those with a strain: those that move,
/// with as many on either side, if they are a small part of the chain, and otherwise all.
#[cfg(feature = "plot")]
fn moving(outcome: &Trajectory, range: f64) -> std::ops::Range<usize> {
    let Some(start) = outcome.profiles.first().map(|profile| &profile.x) else { return 0..0 };
    let moves = |bond: &usize| outcome.profiles.iter().any(|one| (one.x[*bond] - start[*bond]).abs() > MOVES * range);
    let (all, ends) = (0..start.len(), [(0..start.len()).find(moves), (0..start.len()).rfind(moves)]);
    let [Some(first), Some(last)] = ends else { return all };
    let room = last - first + 10;
    let seen = first.saturating_sub(room)..(last + 1 + room).min(all.end);
    if 4 * seen.len() < all.end { seen } else { all }
}

/// `(t, |E(t) - E(0)| / |E(0)|)` at samples with a positive error. For a chain that dissipates or
/// is driven, `E(t)` is the balance, and the error is divided by the largest energy of a sample.
#[cfg(feature = "plot")]
fn energy_errors(scene: &Scene, outcome: &Trajectory) -> Vec<(f64, f64)> {
    let totals: Vec<(f64, f64)> =
        outcome.samples.iter().filter_map(|sample| Some((sample.t, sample.energy?.balance()))).collect();
    if scene.chain().open() {
        let energies = outcome.samples.iter().filter_map(|sample| sample.energy);
        let most = energies.fold(0.0f64, |most, energy| most.max(energy.total()));
        let Some(&(_, initial)) = totals.first().filter(|_| most > 0.0) else { return Vec::new() };
        return totals
            .iter()
            .map(|&(t, b)| (t, (b - initial).abs() / most))
            .filter(|(_, error)| *error > 0.0)
            .collect();
    }
    let Some(&(_, initial)) = totals.first().filter(|(_, energy)| *energy != 0.0) else { return Vec::new() };
    totals.iter().map(|&(t, e)| (t, ((e - initial) / initial).abs())).filter(|(_, error)| *error > 0.0).collect()
}

#[cfg(feature = "plot")]
fn profile_figure(
    &RunView { scene, outcome, si, .. }: &RunView<'_>,
    caption: &dyn Fn(&str) -> String,
) -> crate::figures::Panels {
    use crate::figures::{Line, Panel, Panels};
    let layout = scene.chain().layout();
    let ring = scene.chain().boundary() == Boundary::StrainRing;
    let first = first_bond(scene);
    let points =
        |values: &[f64]| values.iter().enumerate().map(|(n, &value)| (first + n as f64, value)).collect::<Vec<_>>();
    let line = |name: &str, values: &[f64]| Line { name: name.to_owned(), points: points(values) };
    let mut panels = vec![("xₙ", "strain xₙ", scene.strains(&outcome.state))];
    if let (true, Some(y)) = (ring, layout.v(&outcome.state)) {
        panels.push(("yₙ", "strain yₙ", y.to_vec()));
    }
    let panels = panels.into_iter().enumerate().map(|(i, (_, strain, values))| {
        let mut lines = vec![line("numerical", &values)];
        if let Some(Theory::Wave(wave)) = scene.theory() {
            let ansatz = |n| {
                let site = wave.site(n, outcome.t);
                if i == 0 { site.u } else { site.v }
            };
            lines.push(line("ansatz", &(0..layout.sites()).map(ansatz).collect::<Vec<_>>()));
        }
        let x_label = if ring { "site n" } else { "bond n" };
        Panel {
            x_label: x_label.to_owned(),
            y_label: Scale(si).label(strain, Quantity::Length),
            lines,
            ..Default::default()
        }
    });
    let title = match si {
        None => format!("{}: strain profile at t = {:.6}", scene.name(), outcome.t),
        Some(_) => format!("{}: strain profile at t = {:.6e} s", scene.name(), outcome.t),
    };
    let caption = caption(match scene.theory() {
        Some(Theory::Wave(_)) => "Strains at the end of the run beside the first-order ansatz.",
        _ => "Strains at the end of the run.",
    });
    Panels::column(title, panels.collect(), caption)
}
