//! Files that the parts of a run write if no process has the whole state, and how they are joined.
//!
//! After leg `k`, part `p` of `P`, counted from 0, writes `state-k-p-of-P.npz` and, if the leg had
//! profiles, `profiles-k-p-of-P.npz`, into the folder `parts` beside `checkpoint.npz`. Both hold
//! `sites`, the first site of the part and the one after its last, and arrays `u`, `v`, `u_dot`,
//! `v_dot` (strains on a strain ring; `v` and `v_dot` only if resonators move) with a number for
//! each site, in a row for each profile. A checkpoint names the legs whose files count; files that
//! it does not name are removed.

use crate::{
    chain::{Blocks, Layout},
    error::{Error, Result},
    output::{Archive, NpzWriter, read_vectors},
    parts::{Files, Own},
};
use serde::{Deserialize, Serialize};
use std::{
    cell::RefCell,
    fs,
    path::{Path, PathBuf},
};

/// The folder of these files, beside the checkpoint.
pub(super) const FOLDER: &str = "parts";
const ARRAYS: [&str; 4] = ["u", "v", "u_dot", "v_dot"];
/// Most sites that are read together.
const BLOCK: usize = 1 << 16;

/// Writes what parts keep as NPZ archives.
#[derive(Debug)]
pub struct PartFiles;

impl Files for PartFiles {
    fn write(&self, folder: &Path, leg: u64, own: &Own) -> std::result::Result<(), String> {
        let leg = Leg { leg, parts: own.parts(), profiles: own.profiles().len() };
        let keep = |kind, axes: &[u64], rows: &[&[f64]]| {
            let path = folder.join(leg.name(kind, own.part()));
            write(&path, own, axes, rows).map_err(|why| format!("{}: {why}", path.display()))
        };
        fs::create_dir_all(folder).map_err(|why| why.to_string())?;
        let rows: Vec<&[f64]> = own.profiles().iter().map(Vec::as_slice).collect();
        if !rows.is_empty() {
            keep(PROFILES, &[rows.len() as u64], &rows)?;
        }
        keep(STATE, &[], &[own.state()])
    }
}

const STATE: &str = "state";
const PROFILES: &str = "profiles";

/// Writes `rows` as an archive, each with the arrays of the sites of a part, one after the other.
/// `axes` are the lengths of the axes before that of the sites. The file counts only once a
/// checkpoint names it, which is written when all parts have written theirs.
fn write(path: &Path, own: &Own, axes: &[u64], rows: &[&[f64]]) -> std::io::Result<()> {
    let (sites, count) = (own.sites(), own.sites().len());
    let mut file = fs::File::create(path)?;
    let mut archive = NpzWriter::new(&mut file, None)?;
    archive.vector("sites", &[sites.start as f64, sites.end as f64])?;
    let shape = [axes, &[count as u64]].concat();
    for (k, name) in names(own.state().len() / count).into_iter().enumerate() {
        archive.begin(name, &shape)?;
        rows.iter().try_for_each(|row| archive.row(&row[k * count..][..count]))?;
    }
    archive.finish()?;
    file.sync_all()
}

/// Names of the arrays, if the state of a site has this number of numbers.
fn names(numbers: usize) -> Vec<&'static str> {
    if numbers == 4 { ARRAYS.to_vec() } else { vec![ARRAYS[0], ARRAYS[2]] }
}

/// A leg, as parts have written it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Leg {
    /// Its number, from 1.
    pub(super) leg: u64,
    /// Number of parts.
    pub(super) parts: usize,
    /// Number of its profiles.
    pub(super) profiles: usize,
}

impl Leg {
    fn name(self, kind: &str, part: usize) -> String {
        format!("{kind}-{}-{part}-of-{}.npz", self.leg, self.parts)
    }

    fn names(self, kind: &str) -> impl Iterator<Item = String> {
        (0..self.parts).map(move |part| self.name(kind, part))
    }
}

/// The legs of a run whose files count: those with profiles, and the last one.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub(super) struct Legs(pub(super) Vec<Leg>);

impl Legs {
    /// Refuses an empty list of legs, legs that do not have `profiles` profiles together, and legs
    /// with no part or with more parts than sites.
    ///
    /// # Errors
    /// The rule.
    pub(super) fn check(&self, profiles: u64, sites: usize) -> std::result::Result<(), String> {
        let count = self.0.iter().try_fold(0usize, |sum, leg| sum.checked_add(leg.profiles));
        match self.0.iter().find(|leg| !(1..=sites).contains(&leg.parts)) {
            Some(leg) => Err(format!("{} parts of {sites} sites", leg.parts)),
            None if self.0.is_empty() => Err("no leg, and a checkpoint has one at least".to_owned()),
            None if count.is_none_or(|count| count as u64 != profiles) => {
                Err(format!("{profiles} profiles, and other numbers of its legs"))
            }
            None => Ok(()),
        }
    }

    /// Adds a leg. Of earlier legs only those with profiles stay, as their states are no longer
    /// needed.
    pub(super) fn push(&mut self, leg: Leg) {
        self.0.retain(|leg| leg.profiles > 0);
        self.0.push(leg);
    }

    /// Removes files of parts, in the folder of a run, that these legs do not need. A file that
    /// cannot be removed is never read.
    pub(super) fn sweep(&self, folder: &Path) {
        let path = folder.join(FOLDER);
        let mut named: Vec<String> =
            self.0.iter().filter(|leg| leg.profiles > 0).flat_map(|leg| leg.names(PROFILES)).collect();
        named.extend(self.0.last().into_iter().flat_map(|leg| leg.names(STATE)));
        for entry in fs::read_dir(&path).into_iter().flatten().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let ours =
                [STATE, PROFILES].iter().any(|kind| name.starts_with(&format!("{kind}-"))) && name.ends_with(".npz");
            if ours && !named.contains(&name) && fs::remove_file(entry.path()).is_ok() {
                // A folder that holds something is not removed.
                let _ = fs::remove_dir(&path);
            }
        }
    }

    /// The whole states at the times of all profiles.
    ///
    /// # Errors
    /// A file that cannot be read, or is not as it was written.
    pub(super) fn profiles(&self, folder: &Path, layout: Layout) -> Result<Vec<Vec<f64>>> {
        let mut all = Vec::new();
        for leg in self.0.iter().filter(|leg| leg.profiles > 0) {
            let mut rows = vec![vec![0.0; layout.dim()]; leg.profiles];
            let mut next = 0;
            for name in leg.names(PROFILES) {
                let path = folder.join(FOLDER).join(name);
                let file = Archive::read(&path)?;
                let end = end_of(&path, next, layout, &file.array("sites", &[2])?)?;
                for (k, name) in names(layout.dim() / layout.sites()).into_iter().enumerate() {
                    let values = file.array(name, &[leg.profiles as u64, (end - next) as u64])?;
                    if let Some(at) = values.iter().position(|value| !value.is_finite()) {
                        return Err(file.refused(name, format!("{} at entry {at}: all are finite", values[at])));
                    }
                    for (row, values) in rows.iter_mut().zip(values.chunks_exact(end - next)) {
                        row[k * layout.sites()..][next..end].copy_from_slice(values);
                    }
                }
                next = end;
            }
            complete(folder, next, layout)?;
            all.append(&mut rows);
        }
        Ok(all)
    }
}

/// The site after the last one in the file of a part. Refuses a file whose first site is not
/// `next`.
fn end_of(path: &Path, next: usize, layout: Layout, sites: &[f64]) -> Result<usize> {
    let [first, end] = [sites[0], sites[1]];
    if first == next as f64 && end.fract() == 0.0 && (first + 1.0..=layout.sites() as f64).contains(&end) {
        return Ok(end as usize);
    }
    let rule = format!("{first} to {end}: the parts make up the chain, and this one begins at site {next}");
    Err(Error::Content { path: path.to_owned(), place: "sites".to_owned(), rule })
}

/// Refuses parts that end before the chain.
fn complete(folder: &Path, end: usize, layout: Layout) -> Result<()> {
    if end == layout.sites() {
        return Ok(());
    }
    let rule = format!("the parts end at site {end} of {}", layout.sites());
    Err(Error::Content { path: folder.join(FOLDER), place: "sites".to_owned(), rule })
}

/// The state that parts have written at the end of a leg, read from the first site to the last.
pub(super) struct Written {
    folder: PathBuf,
    leg: Leg,
    layout: Layout,
    /// The first error of reading. If there is one, the blocks that were seen are not the state.
    failure: RefCell<Option<Error>>,
}

impl Written {
    /// The state at the end of the last of some legs, which were [checked](Legs::check).
    ///
    /// # Panics
    /// No legs.
    pub(super) fn new(folder: &Path, legs: &Legs, layout: Layout) -> Self {
        let leg = *legs.0.last().expect("legs that were checked");
        Self { folder: folder.to_owned(), leg, layout, failure: RefCell::new(None) }
    }

    /// The whole state.
    ///
    /// # Errors
    /// A file that cannot be read, or is not as it was written.
    pub(super) fn whole(self) -> Result<Vec<f64>> {
        let mut y = vec![0.0; self.layout.dim()];
        self.each(&mut |first, arrays| {
            for (to, from) in
                self.layout.arrays_mut(&mut y).into_iter().zip(arrays).filter(|(_, from)| !from.is_empty())
            {
                to[first..][..from.len()].copy_from_slice(from);
            }
        });
        self.read()?;
        Ok(y)
    }

    /// Returns the first error of all readings so far.
    ///
    /// # Errors
    /// A file that cannot be read, or is not as it was written.
    pub(super) fn read(self) -> Result<()> {
        self.failure.into_inner().map_or(Ok(()), Err)
    }

    fn try_each(&self, see: &mut dyn FnMut(usize, [&[f64]; 4])) -> Result<()> {
        let (mut next, names) = (0, names(self.layout.dim() / self.layout.sites()));
        for name in self.leg.names(STATE) {
            let path = self.folder.join(FOLDER).join(name);
            let mut sites = Vec::new();
            read_vectors(&path, &["sites"], 2, 2, &mut |_, vectors| sites.clone_from(&vectors[0]))?;
            let end = end_of(&path, next, self.layout, &sites)?;
            let mut lost = None;
            read_vectors(&path, &names, end - next, BLOCK, &mut |first, vectors| {
                let mut arrays = [&[][..]; 4];
                for (name, vector) in names.iter().zip(vectors) {
                    arrays[ARRAYS.iter().position(|array| array == name).unwrap_or_default()] = &vector[..];
                    if let Some(at) = vector.iter().position(|value| !value.is_finite()) {
                        lost = Some((name, first + at, vector[at]));
                    }
                }
                see(next + first, arrays);
            })?;
            if let Some((name, at, value)) = lost {
                let rule = format!("{value} at entry {at}: all are finite");
                return Err(Error::Content { path, place: (*name).to_owned(), rule });
            }
            next = end;
        }
        complete(&self.folder, next, self.layout)
    }
}

impl Blocks<f64> for Written {
    fn each(&self, see: &mut dyn FnMut(usize, [&[f64]; 4])) {
        let mut seen = 0;
        let read = self.try_each(&mut |first, arrays| {
            seen = first + arrays[0].len();
            see(first, arrays);
        });
        if let Err(why) = read {
            self.failure.borrow_mut().get_or_insert(why);
            // Parts wait for all of their sites: zeros stand for those that could not be read.
            let (sites, zeros) = (self.layout.sites(), vec![0.0; BLOCK]);
            for first in (seen..sites).step_by(BLOCK) {
                let rest = &zeros[..BLOCK.min(sites - first)];
                let moving = if self.layout.resonators() { rest } else { &[] };
                see(first, [rest, moving, rest, moving]);
            }
        }
    }

    fn last(&self) -> f64 {
        let mut last = 0.0;
        self.each(&mut |_, [u, ..]| last = u[u.len() - 1]);
        last
    }
}
