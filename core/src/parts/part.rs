//! A part of a chain: its own sites, and ghosts on either side.

use super::{Communicator, Division, Motion, bonds::Bonds};
use crate::chain::{Chain, Divisible, KineticFlow, LinearFlow, Split};
use hertzchain_integrators::{DoubleDouble, SplitFlow};
use std::ops::Range;

/// Most sites whose states go into one message.
const BLOCK: usize = 1 << 16;

/// A part of a chain, on one of the two splits or by contact collocation.
pub(super) enum Part {
    Kinetic(Box<Sites<KineticFlow<f64>>>),
    Linear(Box<Sites<LinearFlow<f64>>>),
    Windows(Box<Bonds>),
}

/// Evaluates an expression for the content of a part of any kind.
macro_rules! each {
    ($part:expr, $sites:ident => $what:expr) => {
        match $part {
            Part::Kinetic($sites) => $what,
            Part::Linear($sites) => $what,
            Part::Windows($sites) => $what,
        }
    };
}

const KICKED: &str = "windows are solved, and splits are kicked";

impl Part {
    /// Part `number`, at rest. Windows are solved on at most `threads` threads.
    pub(super) fn new(
        chain: &Chain<f64>,
        division: Division,
        (number, threads): (usize, usize),
        motion: Motion,
    ) -> Self {
        match motion {
            Motion::Kicks(Split::Kinetic) => Self::Kinetic(Box::new(Sites::new(chain, division, number))),
            Motion::Kicks(Split::Linear) => Self::Linear(Box::new(Sites::new(chain, division, number))),
            Motion::Windows => Self::Windows(Box::new(Bonds::new(chain, division, number, threads))),
        }
    }

    /// The sites that are its own, as the chain counts them.
    pub(super) fn own(&self) -> Range<usize> {
        each!(self, sites => sites.division.sites(sites.number))
    }

    /// Sets the sites of [`Division::held`], from index `first` there on, to the states in arrays.
    pub(super) fn read(&mut self, first: usize, arrays: [&[f64]; 4]) {
        each!(self, sites => sites.read(first, arrays));
    }

    /// Writes the states of its own sites into arrays of all of them.
    pub(super) fn write(&self, arrays: [&mut [f64]; 4]) {
        each!(self, sites => sites.write(0, arrays));
    }

    /// Receives the states of the sites of [`Division::held`] from part 0.
    pub(super) fn receive(&mut self, carrier: &mut dyn Communicator) {
        let held = each!(self, sites => sites.division.held(sites.number));
        let resonators = self.resonators();
        let mut buffer = Vec::new();
        for block in blocks(0..held.len()) {
            buffer.resize(numbers(resonators) * block.len(), 0.0);
            carrier.receive(0, &mut buffer);
            self.read(block.start, parted(&buffer, block.len()));
        }
    }

    /// Sends the states of its own sites to part 0.
    pub(super) fn send(&self, carrier: &mut dyn Communicator) {
        let (own, resonators) = (self.own(), self.resonators());
        let mut buffer = Vec::new();
        for block in blocks(0..own.len()) {
            buffer.resize(numbers(resonators) * block.len(), 0.0);
            let arrays = parted_mut(&mut buffer, block.len());
            each!(self, sites => sites.write(block.start, arrays));
            carrier.send(0, &buffer);
        }
    }

    fn resonators(&self) -> bool {
        each!(self, sites => sites.resonators)
    }

    pub(super) fn drift(&mut self, dt: DoubleDouble<f64>) {
        match self {
            Self::Kinetic(sites) => sites.flow.drift(dt),
            Self::Linear(sites) => sites.flow.drift(dt),
            Self::Windows(_) => unreachable!("{KICKED}"),
        }
    }

    /// Kicks and drifts, and exchanges ghosts with the neighbours where these are used up.
    pub(super) fn kick_drifts(&mut self, pairs: &[(f64, DoubleDouble<f64>)], carrier: &mut dyn Communicator) {
        match self {
            Self::Kinetic(sites) => sites.kick_drifts(pairs, carrier),
            Self::Linear(sites) => sites.kick_drifts(pairs, carrier),
            Self::Windows(_) => unreachable!("{KICKED}"),
        }
    }

    /// The bonds of a part for contact collocation.
    pub(super) fn windows(&self) -> &Bonds {
        match self {
            Self::Windows(bonds) => bonds,
            _ => unreachable!("{KICKED}"),
        }
    }

    /// As [`windows`](Self::windows), mutable.
    pub(super) fn windows_mut(&mut self) -> &mut Bonds {
        match self {
            Self::Windows(bonds) => bonds,
            _ => unreachable!("{KICKED}"),
        }
    }

    pub(super) fn duplicate(&self) -> Self {
        match self {
            Self::Kinetic(sites) => Self::Kinetic(Box::new(sites.duplicate())),
            Self::Linear(sites) => Self::Linear(Box::new(sites.duplicate())),
            Self::Windows(bonds) => Self::Windows(Box::new(bonds.duplicate())),
        }
    }

    /// Copies a part of the same chain and motion.
    pub(super) fn copy_from(&mut self, other: &Self) {
        match (self, other) {
            (Self::Kinetic(sites), Self::Kinetic(other)) => sites.copy_from(other),
            (Self::Linear(sites), Self::Linear(other)) => sites.copy_from(other),
            (Self::Windows(bonds), Self::Windows(other)) => bonds.copy_from(other),
            _ => unreachable!("a copy is of the same motion"),
        }
    }
}

/// The blocks in which states of some sites are sent.
pub(super) fn blocks(sites: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let Range { start, end } = sites;
    (start..end).step_by(BLOCK).map(move |first| first..end.min(first + BLOCK))
}

/// How many numbers the state of a site has.
pub(super) fn numbers(resonators: bool) -> usize {
    if resonators { 4 } else { 2 }
}

/// The arrays `[u, v, u', v']` in a message about `sites` sites.
pub(super) fn parted(message: &[f64], sites: usize) -> [&[f64]; 4] {
    let (positions, velocities) = message.split_at(message.len() / 2);
    let ((u, v), (u_dot, v_dot)) = (positions.split_at(sites), velocities.split_at(sites));
    [u, v, u_dot, v_dot]
}

/// As [`parted`], mutable.
pub(super) fn parted_mut(message: &mut [f64], sites: usize) -> [&mut [f64]; 4] {
    let (positions, velocities) = message.split_at_mut(message.len() / 2);
    let ((u, v), (u_dot, v_dot)) = (positions.split_at_mut(sites), velocities.split_at_mut(sites));
    [u, v, u_dot, v_dot]
}

/// The sites of a part that is integrated by kicks on a split.
pub(super) struct Sites<F> {
    flow: F,
    division: Division,
    number: usize,
    resonators: bool,
    /// Number of ghosts on the left.
    left: usize,
    /// Number of further kicks for which the ghosts are valid.
    fresh: usize,
    /// Buffers of the edges that are sent and received.
    edges: [Vec<f64>; 2],
}

impl<F: Divisible<f64>> Sites<F> {
    fn new(chain: &Chain<f64>, division: Division, number: usize) -> Self {
        let side = |neighbour: Option<usize>| neighbour.map_or(0, |_| division.ghosts());
        let (left, right) = (side(division.before(number)), side(division.after(number)));
        let sites = left + division.sites(number).len() + right;
        let cut = if division.parts() == 1 { chain.clone() } else { chain.cut(sites) };
        let resonators = chain.layout().resonators();
        Self { flow: F::rest(cut), division, number, resonators, left, fresh: 0, edges: [Vec::new(), Vec::new()] }
    }

    fn read(&mut self, first: usize, arrays: [&[f64]; 4]) {
        self.flow.read(self.left + first, arrays);
        self.fresh = 0;
    }

    fn write(&self, first: usize, arrays: [&mut [f64]; 4]) {
        self.flow.write(self.left + first, arrays);
    }

    fn kick_drifts(&mut self, pairs: &[(f64, DoubleDouble<f64>)], carrier: &mut dyn Communicator) {
        if self.division.parts() == 1 {
            self.flow.kick_drifts(pairs);
            return;
        }
        let mut rest = pairs;
        while !rest.is_empty() {
            if self.fresh == 0 {
                self.exchange(carrier);
            }
            let (now, later) = rest.split_at(rest.len().min(self.fresh));
            self.flow.kick_drifts(now);
            (self.fresh, rest) = (self.fresh - now.len(), later);
        }
    }

    /// Exchanges ghosts with both neighbours.
    fn exchange(&mut self, carrier: &mut dyn Communicator) {
        let (division, number, left) = (self.division, self.number, self.left);
        let (ghosts, own) = (division.ghosts(), division.sites(number).len());
        let (before, after) = (division.before(number), division.after(number));
        // To the right: the last sites of each part are the first ghosts of the next.
        self.pass(carrier, (after, left + own - ghosts), (before, 0));
        self.pass(carrier, (before, left), (after, left + own));
        self.fresh = ghosts;
    }

    /// Sends own sites, from index `sent` on, to one neighbour, and receives ghosts, from index
    /// `received` on, from the other.
    fn pass(
        &mut self,
        carrier: &mut dyn Communicator,
        (to, sent): (Option<usize>, usize),
        (from, received): (Option<usize>, usize),
    ) {
        let ghosts = self.division.ghosts();
        let [out, into] = &mut self.edges;
        out.clear();
        into.clear();
        for column in self.flow.columns().iter().filter(|column| !column.is_empty()) {
            out.extend_from_slice(column.get(sent..sent + ghosts).filter(|_| to.is_some()).unwrap_or_default());
            into.resize(into.len() + ghosts, 0.0);
        }
        carrier.pass(to.map(|to| (to, &out[..])), from.map(|from| (from, &mut into[..])));
        if from.is_some() {
            let columns = self.flow.columns().into_iter().filter(|column| !column.is_empty());
            for (column, edge) in columns.zip(into.chunks_exact(ghosts)) {
                column[received..][..ghosts].copy_from_slice(edge);
            }
        }
    }

    fn duplicate(&self) -> Self {
        let Self { division, number, resonators, left, fresh, .. } = *self;
        let edges = [Vec::new(), Vec::new()];
        Self { flow: self.flow.duplicate(), division, number, resonators, left, fresh, edges }
    }

    fn copy_from(&mut self, other: &Self) {
        self.flow.copy_from(&other.flow);
        self.fresh = other.fresh;
    }
}
