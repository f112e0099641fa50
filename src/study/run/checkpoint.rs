//! Long runs: a sequence of legs with a checkpoint after each, so that a run that was killed can go
//! on and ends with the same bits.
//!
//! | symbol | meaning |
//! |---|---|
//! | `D` | interval: leg `k` goes from `k D` to `(k+1) D`, the last one to the end of the scene |
//!
//! Each leg starts the method anew from the state there. So no file holds internal data of a
//! method, and a run with the same `D` has the same bits whether it was interrupted or not. Runs
//! with different `D` differ by about the error of the method. Fixed steps are as long as asked for
//! or shorter, and every whole leg has the same number of them. A tolerance for the whole run is
//! shared out to the legs by their lengths. Contacts that last beyond the end of a leg are joined.
//!
//! `checkpoint.npz` holds `settings.json` and arrays: `state`, and what was recorded so far,
//! `sample_t`, `energies`, `profile_t`, `profiles`, `contacts`, `extremes`; `largest` is
//! `max |E(t) - E(0)|`. Every member is checked by its CRC-32.

use crate::{
    chain::{Chain, Contact, Contacts, Energy},
    error::{Error, Result, require},
    output::{Archive, FileFormat, Folder, NpzWriter, PROGRAM, SETTINGS, in_memory, to_json},
    run::method::{Method, Setting},
    run::{Profile, Recorder, Records, Run, Sample, Snapshot, Trajectory},
    scene::{Scene, SceneFile, Selection},
};
use hertzchain_integrators::Stats;
use serde::{Deserialize, Serialize};
use std::{
    io,
    path::{Path, PathBuf},
    time::Duration,
};

/// Name of the checkpoint in the folder of a run.
pub(super) const FILE: &str = "checkpoint.npz";
const FORMAT: FileFormat = FileFormat("hertzchain checkpoint", 6);
/// Relative difference of numbers that are the same up to roundings.
const ROUNDED: f64 = 1e-9;
/// Most intervals of a run.
const MOST_LEGS: f64 = 1e6;

/// A run in legs, with the record of those that are done.
#[derive(Clone, Debug)]
pub struct LongRun {
    scene: Scene,
    run: Run,
    method: Method,
    setting: Setting,
    wording: String,
    interval: f64,
    done: u64,
    kept: Snapshot,
}

/// The content of `settings.json`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    format: String,
    version: u64,
    program: String,
    /// The scene as TOML.
    scene: String,
    integrator: String,
    setting: Setting,
    wording: String,
    interval: f64,
    /// Number of legs that are done.
    legs: u64,
    t: f64,
    taken: usize,
    samples: u64,
    profiles: u64,
    /// Number of contacts that have ended; `null` without a log of contacts.
    contacts: Option<u64>,
    /// Length of the array `open_contacts`: what contacts that have not ended have done so far.
    open_contacts: u64,
    steps: u64,
    rejected: u64,
    force_evaluations: u64,
    wall_s: f64,
    /// Absent from files that were written before it was measured.
    #[serde(default)]
    sampling_s: f64,
}

impl LongRun {
    /// A run of a scene in legs of length `interval`, not begun; `wording`: the setting in words.
    ///
    /// # Errors
    /// An interval outside its rule; what [`Run::stepper`] refuses.
    pub fn new(
        scene: Scene,
        method: Method,
        setting: Setting,
        wording: String,
        interval: f64,
        threads: Option<usize>,
    ) -> Result<Self> {
        let rule = "an interval of time, finite and positive";
        require(interval.is_finite() && interval > 0.0, "checkpoint", interval, rule)?;
        let rule = "a run has at most 10^6 intervals";
        require(scene.end() / interval <= MOST_LEGS, "checkpoint", interval, rule)?;
        let run = scene.observed_run(Records::Profiles)?.method(method).setting(setting).threads(threads);
        run.stepper()?;
        let kept = Snapshot::new(&run);
        Ok(Self { scene, run, method, setting, wording, interval, done: 0, kept })
    }

    /// Adds a log of contacts. A run that has begun without one stays without.
    #[must_use]
    pub fn with_contacts(mut self) -> Self {
        if self.done == 0 {
            self.run = self.run.contacts();
            self.kept = Snapshot::new(&self.run);
        }
        self
    }

    /// Sets the number of [threads](Run::threads). A checkpoint does not depend on it: a run may go
    /// on with any number.
    ///
    /// # Errors
    /// What [`Method::takes`] refuses.
    pub fn threads(mut self, count: usize) -> Result<Self> {
        self.method.takes(Some(count), self.run.chain())?;
        self.run = self.run.threads(count);
        Ok(self)
    }

    /// Whether the run has a log of contacts.
    pub fn has_contacts(&self) -> bool {
        self.kept.contacts.is_some()
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The method.
    pub fn method(&self) -> Method {
        self.method
    }

    /// The setting in words.
    pub fn wording(&self) -> &str {
        &self.wording
    }

    /// End of the last leg that is done; zero if there is none.
    pub fn time(&self) -> f64 {
        self.start_of(self.done)
    }

    fn legs(&self) -> u64 {
        // The factor keeps rounding from adding a leg of no length.
        (self.scene.end() / self.interval * (1.0 - 1e-12)).ceil().max(1.0) as u64
    }

    fn start_of(&self, leg: u64) -> f64 {
        if leg >= self.legs() { self.scene.end() } else { self.interval * leg as f64 }
    }

    /// Runs the remaining legs, and writes `checkpoint.npz` after each. `progress` is told the time
    /// at every sample. A run that fails, or is asked to end, leaves the checkpoint of its last
    /// whole leg.
    ///
    /// # Errors
    /// A leg that cannot start; a checkpoint that cannot be written: the last one then stays.
    pub fn run(mut self, folder: &Folder, progress: &mut dyn FnMut(f64)) -> Result<Trajectory> {
        let mut seen = |t, _: &[f64]| progress(t);
        while self.done < self.legs() {
            let (from, to) = (self.time(), self.start_of(self.done + 1));
            let setting = self.setting.of_leg(self.method, (to - from) / self.scene.end());
            let mut recorder = Recorder::new(&self.run, self.kept, &mut seen);
            let failure = recorder.go_on(self.method, setting, to)?.err();
            if failure.is_some() {
                return Ok(recorder.trajectory(failure));
            }
            self.kept = recorder.kept;
            self.done += 1;
            folder.write_with(FILE, |file| self.write(file))?;
        }
        Ok(Recorder::new(&self.run, self.kept, &mut seen).trajectory(None))
    }

    /// The checkpoint of the run, as bytes.
    ///
    /// # Errors
    /// Errors of the archive writer.
    pub fn npz(&self) -> Result<Vec<u8>> {
        in_memory(|bytes| self.write(bytes))
    }

    /// Writes the checkpoint of the run, with no second copy of the state in memory.
    fn write(&self, to: impl io::Write + io::Seek) -> io::Result<()> {
        let Snapshot { t, ref state, taken, largest, ref samples, ref profiles, ref contacts, .. } = self.kept;
        let Snapshot { ref extremes, stats, wall, sampling, .. } = self.kept;
        let Stats { steps, rejected, force_evaluations } = stats;
        let open = contacts.as_ref().map(Contacts::store_open).unwrap_or_default();
        let FileFormat(format, version) = FORMAT;
        let settings = Settings {
            format: format.to_owned(),
            version,
            program: PROGRAM.to_owned(),
            scene: self.scene.file().to_toml(),
            integrator: self.method.name(),
            setting: self.setting,
            wording: self.wording.clone(),
            interval: self.interval,
            legs: self.done,
            t,
            taken,
            samples: samples.len() as u64,
            profiles: profiles.len() as u64,
            contacts: contacts.as_ref().map(|contacts| contacts.ended.len() as u64),
            open_contacts: open.len() as u64,
            steps,
            rejected,
            force_evaluations,
            wall_s: wall.as_secs_f64(),
            sampling_s: sampling.as_secs_f64(),
        };
        let energies = samples.iter().filter_map(|sample| sample.energy).map(|energy| {
            let Energy { beads, resonators, springs, contacts, dissipated, driven } = energy;
            [beads, resonators, springs, contacts, dissipated, driven]
        });
        let kinds = energy_kinds(self.scene.chain());
        let energies: Vec<f64> = energies.flat_map(|energy| energy.into_iter().take(kinds)).collect();
        let ended = || contacts.iter().flat_map(|contacts| &contacts.ended);
        let mut archive = NpzWriter::new(to, Some((SETTINGS, &to_json(&settings))))?;
        archive.vector("state", state)?;
        archive.vector("largest", &[largest])?;
        archive.vector("sample_t", &samples.iter().map(|sample| sample.t).collect::<Vec<_>>())?;
        archive.vector("energies", &energies)?;
        archive.vector("profile_t", &profiles.iter().map(|profile| profile.t).collect::<Vec<_>>())?;
        archive.begin("profiles", &[profiles.len() as u64, state.len() as u64])?;
        profiles.iter().try_for_each(|profile| archive.row(&profile.state))?;
        archive.begin("contacts", &[ended().count() as u64, Contact::NUMBERS as u64])?;
        ended().try_for_each(|contact| archive.row(&contact.numbers()))?;
        archive.vector("open_contacts", &open)?;
        archive.begin("extremes", &[extremes.len() as u64, 2])?;
        extremes.iter().try_for_each(|&(t, value)| archive.row(&[t, value]))?;
        archive.finish()
    }

    /// Reads a run from its checkpoint, to go on with this number of threads, if one is given.
    /// `path` is the file, or the folder that holds it.
    ///
    /// # Errors
    /// A file that cannot be read; what [`from_archive`](Self::from_archive) refuses.
    pub fn load(path: &Path, threads: Option<usize>) -> Result<Self> {
        let path: PathBuf = if path.is_dir() { path.join(FILE) } else { path.to_owned() };
        Self::from_archive(&Archive::read(&path)?, threads)
    }

    /// The run whose checkpoint is an archive.
    ///
    /// # Errors
    /// [`Error::Content`], with key and rule, for an archive that is not as it was written, is of
    /// another version of the program, or has numbers outside their rules; as
    /// [`threads`](Self::threads).
    pub fn from_archive(file: &Archive, threads: Option<usize>) -> Result<Self> {
        let refused =
            |key: &str, why: &dyn std::fmt::Display| file.refused(&format!("{SETTINGS}, {key}"), why.to_string());
        let settings: Settings = FORMAT.read(file)?;
        if settings.program != PROGRAM {
            let there = settings.program;
            let rule = format!("{there} there and {PROGRAM} here: only the same program goes on with the same bits");
            return Err(refused("program", &rule));
        }
        let scene = SceneFile::parse(&settings.scene, SETTINGS).and_then(Scene::build);
        let scene = scene.map_err(|why| refused("scene", &why))?;
        let method = Method::named(&settings.integrator).map_err(|why| refused("integrator", &why))?;
        // What threads cannot do is not the fault of the file.
        method.takes(threads, scene.chain())?;
        let new = Self::new(scene, method, settings.setting, settings.wording.clone(), settings.interval, threads);
        let new = new.map_err(|why| refused("setting", &why))?;
        let legs = new.legs();
        let kept = kept(file, &settings, &new.scene)?;
        sound(file, &kept, &new.scene)?;
        let run = Self { done: settings.legs, kept, ..new };
        if !(1..=legs).contains(&run.done) {
            return Err(refused("legs", &format!("{} of {legs}: from 1 to all", run.done)));
        }
        if run.kept.t != run.time() {
            return Err(refused("t", &format!("{} after {} legs, which end at {}", run.kept.t, run.done, run.time())));
        }
        Ok(run)
    }

    /// Refuses a scene or a method other than those of the run. Ends of scenes are not compared:
    /// the run goes on to its own end.
    ///
    /// # Errors
    /// [`Error::Content`] that names the one that differs. `path` is the file of the checkpoint.
    pub fn is(&self, path: &Path, scene: Option<&Scene>, method: Option<Method>) -> Result<()> {
        let refused = |key: &str, there: &str, here: &str| {
            let rule = format!("{there} there and {here} here: a checkpoint goes on with its own");
            Err(Error::Content { path: path.to_owned(), place: format!("{SETTINGS}, {key}"), rule })
        };
        let until = |scene: &Scene| scene.clone().until(self.scene.end()).map(|scene| scene.file().clone());
        match (scene, method) {
            (Some(scene), _) if until(scene)? != until(&self.scene)? => {
                let (there, here) = (self.scene.name(), scene.name());
                let other = if there == here { "another of this name" } else { here };
                refused("scene", there, other)
            }
            (_, Some(method)) if method != self.method => refused("integrator", &self.method.name(), &method.name()),
            _ => Ok(()),
        }
    }
}

/// Numbers that a checkpoint has for each energy: four kinds, and for chains that dissipate or are
/// driven the dissipated energy and the work of drives.
fn energy_kinds(chain: &Chain<f64>) -> usize {
    if chain.open() { 6 } else { 4 }
}

/// The log of contacts in a checkpoint, with `count` contacts that have ended.
fn contacts(file: &Archive, settings: &Settings, chain: &Chain<f64>, count: u64) -> Result<Contacts> {
    let numbers = file.array("contacts", &[count, Contact::NUMBERS as u64])?;
    let touching = chain.touching();
    let contact = |(k, row): (usize, &[f64])| {
        let row = row.first_chunk().filter(|row| touching.contains(&(row[0] as usize)));
        let rule = || format!("row {k}: a bond that can close, and times, speeds, overlap and impulse that can be");
        row.and_then(Contact::of_numbers).ok_or_else(|| file.refused("contacts", rule()))
    };
    let ended = numbers.chunks_exact(Contact::NUMBERS).enumerate().map(contact).collect::<Result<_>>()?;
    let open = file.array("open_contacts", &[settings.open_contacts])?;
    let rule = "each is a bond that can close, and what its overlap has done";
    Contacts::restore(chain, ended, &open).ok_or_else(|| file.refused("open_contacts", rule.to_owned()))
}

/// Refuses a record that no run to its time has: samples at other times, energies other than those
/// of the states, contacts after the end.
fn sound(file: &Archive, kept: &Snapshot, scene: &Scene) -> Result<()> {
    let chain = scene.chain();
    let at = |k: usize| scene.end() * (k as f64 / scene.samples() as f64);
    let wrong = kept.samples.iter().enumerate().find(|(k, sample)| sample.t != at(*k) || sample.t > kept.t);
    if let Some((k, sample)) = wrong {
        return Err(file.refused("sample_t", format!("{} at entry {k}: that sample is at {}", sample.t, at(k))));
    }
    let mut samples = kept.samples.iter();
    for (k, profile) in kept.profiles.iter().enumerate() {
        let Some(sample) = samples.find(|sample| sample.t == profile.t) else {
            return Err(file.refused("profile_t", format!("{} at entry {k}: each is the time of a sample", profile.t)));
        };
        let own = sample.energy.map(|_| chain.energy(&profile.state));
        let off = |a: Energy<f64>, b: Energy<f64>| (a.balance() - b.balance()).abs().max((a.total() - b.total()).abs());
        if sample.energy.zip(own).is_some_and(|(a, b)| off(a, b) > ROUNDED * b.total().abs().max(b.dissipated)) {
            return Err(file.refused("energies", format!("row {k}: not the energy of the state at {}", profile.t)));
        }
    }
    if let Some(initial) = scene.initial_energy().map(|energy| energy.balance()) {
        let energies = kept.samples.iter().filter_map(|sample| sample.energy).chain([chain.energy(&kept.state)]);
        let off = energies.map(|energy| (energy.balance() - initial).abs()).fold(0.0, f64::max);
        if off > kept.largest + ROUNDED * initial.abs() {
            return Err(file.refused("largest", format!("{}: an energy is off by {off:e}", kept.largest)));
        }
    }
    let mut contacts = kept.contacts.iter().flat_map(Contacts::all);
    let times = |one: &Contact| [one.onset, one.release, one.force_end, Some(one.t_largest), Some(one.t_peak)];
    let outside = |one: Contact| times(&one).into_iter().flatten().any(|t| !(0.0..=kept.t).contains(&t));
    match contacts.position(outside) {
        Some(k) => Err(file.refused("contacts", format!("row {k}: times are from 0 to that of the checkpoint"))),
        None => Ok(()),
    }
}

/// The record in a checkpoint, checked as far as is possible without running it again.
fn kept(file: &Archive, settings: &Settings, scene: &Scene) -> Result<Snapshot> {
    let &Settings { t, taken, samples, profiles, steps, rejected, force_evaluations, .. } = settings;
    let chain = scene.chain();
    let dim = chain.layout().dim();
    let finite = |name: &str, shape: &[u64]| {
        let values = file.array(name, shape)?;
        match values.iter().position(|value| !value.is_finite()) {
            Some(k) => Err(file.refused(name, format!("{} at entry {k}: all are finite", values[k]))),
            None => Ok(values),
        }
    };
    let duration = |name: &str, seconds: f64| {
        Duration::try_from_secs_f64(seconds)
            .map_err(|why| file.refused(&format!("{SETTINGS}, {name}"), why.to_string()))
    };
    let (wall, sampling) = (duration("wall_s", settings.wall_s)?, duration("sampling_s", settings.sampling_s)?);
    if taken as u64 != samples || taken > scene.samples() + 1 {
        let rule = format!("{taken} taken, {samples} kept, {} asked for", scene.samples());
        return Err(file.refused(&format!("{SETTINGS}, samples"), rule));
    }
    let state = finite("state", &[dim as u64])?;
    let largest = finite("largest", &[1])?[0];
    let sample_t = finite("sample_t", &[samples])?;
    let has_energy = scene.initial_energy().is_some();
    let kinds = energy_kinds(chain);
    let energies = finite("energies", &[if has_energy { kinds as u64 * samples } else { 0 }])?;
    let energy = |k: usize| {
        let row = energies.get(kinds * k..)?;
        let &[beads, resonators, springs, contacts] = row.first_chunk()?;
        let (dissipated, driven) = if chain.open() { (*row.get(4)?, *row.get(5)?) } else { (0.0, 0.0) };
        Some(Energy { beads, resonators, springs, contacts, dissipated, driven })
    };
    let profile_t = finite("profile_t", &[profiles])?;
    let states = finite("profiles", &[profiles, dim as u64])?;
    let profile = |(&t, state): (&f64, &[f64])| Profile { t, x: chain.strains(state), state: state.to_vec() };
    let observables = scene.selection().map_or(0, Selection::width);
    let extremes = finite("extremes", &[observables as u64, 2])?;
    Ok(Snapshot {
        t,
        state,
        taken,
        largest,
        extremes: extremes.chunks_exact(2).map(|one| (one[0], one[1])).collect(),
        samples: sample_t.iter().enumerate().map(|(k, &t)| Sample { t, energy: energy(k) }).collect(),
        profiles: profile_t.iter().zip(states.chunks_exact(dim)).map(profile).collect(),
        contacts: settings.contacts.map(|count| contacts(file, settings, chain, count)).transpose()?,
        stats: Stats { steps, rejected, force_evaluations },
        wall,
        sampling,
    })
}
