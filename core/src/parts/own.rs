//! What a part keeps in a run of which no process has the whole state: its own sites.

use super::{
    Carrier, Division,
    part::{Part, blocks, numbers, parted, parted_mut},
};
use crate::chain::Topology;
use std::{fmt::Debug, ops::Range, path::Path};

/// States of the own sites of a part: the current one, where a leg begins or a sample was taken,
/// and those of profiles.
#[derive(Debug)]
pub struct Own {
    division: Division,
    part: usize,
    resonators: bool,
    /// Arrays `[u, v, u', v']` of its own sites, one after the other.
    state: Vec<f64>,
    profiles: Vec<Vec<f64>>,
}

/// Writes to files what parts keep. Each process of a job has one.
pub trait Files: Debug + Send + Sync {
    /// Writes the state and the profiles of a part at the end of the leg of this number. The error
    /// is a message for people.
    fn write(&self, folder: &Path, leg: u64, own: &Own) -> std::result::Result<(), String>;
}

/// For runs of which no part keeps anything.
#[derive(Debug)]
pub(super) struct NoFiles;

impl Files for NoFiles {
    fn write(&self, _: &Path, _: u64, _: &Own) -> std::result::Result<(), String> {
        Err("nothing is kept in parts".to_owned())
    }
}

impl Own {
    /// The own sites of a part, at rest.
    pub(super) fn new(resonators: bool, division: Division, part: usize) -> Self {
        let state = vec![0.0; numbers(resonators) * division.sites(part).len()];
        Self { division, part, resonators, state, profiles: Vec::new() }
    }

    /// Number of the part, from 0.
    pub fn part(&self) -> usize {
        self.part
    }

    /// Number of parts.
    pub fn parts(&self) -> usize {
        self.division.parts()
    }

    /// Its sites, as the chain counts them.
    pub fn sites(&self) -> Range<usize> {
        self.division.sites(self.part)
    }

    /// The arrays `[u, v, u', v']` of its sites, one after the other; those of resonators only if
    /// they move.
    pub fn state(&self) -> &[f64] {
        &self.state
    }

    /// As [`state`](Self::state), at the times of the profiles that were not written yet.
    pub fn profiles(&self) -> &[Vec<f64>] {
        &self.profiles
    }

    /// Keeps the state as a profile.
    pub(super) fn keep(&mut self) {
        self.profiles.push(self.state.clone());
    }

    /// Marks the state as one that could not be computed.
    pub(super) fn lose(&mut self) {
        self.state.fill(f64::NAN);
    }

    /// Writes state and profiles. Profiles that were written are no longer kept.
    pub(super) fn write(&mut self, files: &dyn Files, folder: &Path, leg: u64) -> std::result::Result<(), String> {
        files.write(folder, leg, self)?;
        self.profiles.clear();
        Ok(())
    }

    /// Takes the state of its sites from a flow.
    pub(super) fn take(&mut self, flow: &Part) {
        let count = self.sites().len();
        flow.write(parted_mut(&mut self.state, count));
    }

    /// The states of some sites, counted from the first own one, as a message.
    pub(super) fn message(&self, sites: Range<usize>) -> Vec<f64> {
        self.arrays().into_iter().flat_map(|array| array.get(sites.clone()).unwrap_or_default()).copied().collect()
    }

    /// Sets some sites, counted from the first own one, to the states of a message.
    pub(super) fn set(&mut self, sites: Range<usize>, message: &[f64]) {
        let count = self.sites().len();
        let arrays = parted_mut(&mut self.state, count);
        for (array, from) in arrays.into_iter().zip(parted(message, sites.len())).filter(|(array, _)| !array.is_empty())
        {
            array[sites.clone()].copy_from_slice(from);
        }
    }

    pub(super) fn arrays(&self) -> [&[f64]; 4] {
        parted(&self.state, self.sites().len())
    }

    /// Receives its state from part 0.
    pub(super) fn receive(&mut self, carrier: &mut dyn Carrier) {
        let mut message = Vec::new();
        for block in blocks(0..self.sites().len()) {
            message.resize(numbers(self.resonators) * block.len(), 0.0);
            carrier.receive(0, &mut message);
            self.set(block, &message);
        }
    }

    /// Sends its state to part 0.
    pub(super) fn send(&self, carrier: &mut dyn Carrier) {
        blocks(0..self.sites().len()).for_each(|block| carrier.send(0, &self.message(block)));
    }

    /// Sets a flow that begins to the kept state. States of sites that the flow needs beyond its
    /// own come from the neighbours, which call this too.
    pub(super) fn give(&self, flow: &mut Part, topology: Topology, carrier: &mut dyn Carrier) {
        let (division, part, own) = (self.division, self.part, self.sites().len());
        let (before, after) = (division.before(part), division.after(part));
        let [to_left, to_right] = [
            before.map(|part| beyond(division, topology, part)[1]),
            after.map(|part| beyond(division, topology, part)[0]),
        ];
        let [left, right] = beyond(division, topology, part);
        let numbers = numbers(self.resonators);
        let mut ends = [left, right].map(|count| vec![0.0; numbers * count]);
        let sent = [self.message(own - to_right.unwrap_or(0)..own), self.message(0..to_left.unwrap_or(0))];
        let [from_left, from_right] = &mut ends;
        carrier.pass(after.map(|to| (to, &sent[0][..])), before.map(|from| (from, &mut from_left[..])));
        carrier.pass(before.map(|to| (to, &sent[1][..])), after.map(|from| (from, &mut from_right[..])));
        let pieces = [(0, parted(from_left, left)), (left, self.arrays()), (left + own, parted(from_right, right))];
        pieces
            .into_iter()
            .filter(|(_, arrays)| !arrays[0].is_empty())
            .for_each(|(first, piece)| flow.read(first, piece));
    }
}

/// Numbers of sites that a part needs at its start, left and right of its own.
fn beyond(division: Division, topology: Topology, part: usize) -> [usize; 2] {
    let (held, own) = (division.held(part), division.sites(part));
    // On a ring the numbers of held sites may go on beyond the last site.
    let around = if held.end > topology.sites() { topology.sites() } else { 0 };
    let left = own.start + around - held.start;
    [left, held.len() - left - own.len()]
}
