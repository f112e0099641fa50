//! A part of a chain by contact collocation: its own bonds and their sites, and those around them
//! that its blocks take along.

use super::{Communicator, Division};
use crate::chain::Chain;
use hertzchain_integrators::collocation::{EDGE, Piece, Section, Share, Window, WindowOutcome, Windows};

/// Most pieces of contacts in one message.
const MESSAGE: usize = 1 << 10;

/// The bonds of a part.
pub(super) struct Bonds {
    section: Section<Chain<f64>>,
    chain: Chain<f64>,
    pub(super) division: Division,
    pub(super) number: usize,
    pub(super) resonators: bool,
    /// Index in the section of the first own site.
    first: usize,
    /// Buffers of the edges that are sent and received.
    edges: [Vec<f64>; 2],
}

impl Bonds {
    /// The bonds of part `number`, at rest. Windows are solved on at most `threads` threads.
    pub(super) fn new(chain: &Chain<f64>, division: Division, number: usize, threads: usize) -> Self {
        let (held, bonds, topology) = (division.held(number), division.bonds(number), chain.topology());
        // On a ring the numbers of held sites may go on beyond the last site: own numbers are then
        // shifted by `around`.
        let around = if held.end > chain.sites() { chain.sites() } else { 0 };
        let section = if division.parts() == 1 {
            Section::at_rest(chain.clone(), Share::whole(bonds.len(), topology.ring()), Some(threads))
        } else {
            let along = |neighbour: Option<usize>| neighbour.map_or(0, |_| EDGE - 1);
            let own = bonds.start + around - held.start..bonds.end + around - held.start;
            let reach = own.start - along(division.before(number))..own.end + along(division.after(number));
            let place = (bonds.start - topology.first(), topology.touching().len());
            Section::at_rest(chain.stretch(held.len()), Share::part(own, reach, place), Some(threads))
        };
        Self {
            section,
            chain: chain.clone(),
            division,
            number,
            resonators: chain.layout().resonators(),
            first: division.sites(number).start + around - held.start,
            edges: [Vec::new(), Vec::new()],
        }
    }

    /// Sets held sites from index `first` on. After the last of them the section begins.
    pub(super) fn read(&mut self, first: usize, arrays: [&[f64]; 4]) {
        for i in 0..arrays[0].len() {
            let state = arrays.map(|array| array.get(i).copied().unwrap_or_default());
            self.section.set(first + i, self.chain.modes().path(state));
        }
        if first + arrays[0].len() == self.section.sites() {
            self.section.begin();
        }
    }

    /// Writes the states of its own sites, from own index `first` on.
    pub(super) fn write(&self, first: usize, mut arrays: [&mut [f64]; 4]) {
        for i in 0..arrays[0].len() {
            let state = self.chain.modes().join(self.section.get(self.first + first + i));
            for (array, value) in arrays.iter_mut().zip(state) {
                array.get_mut(i).into_iter().for_each(|entry| *entry = value);
            }
        }
    }

    /// Solves a window, and exchanges the results of the bonds at the edges with the neighbours.
    pub(super) fn solve(&mut self, window: &Window, carrier: &mut dyn Communicator) -> WindowOutcome {
        let verdict = self.section.solve(window);
        let (before, after) = (self.division.before(self.number), self.division.after(self.number));
        self.pass(carrier, true, after, before);
        self.pass(carrier, false, before, after);
        verdict
    }

    /// Sends the last or the first edge to one neighbour, and receives an edge from the other.
    fn pass(&mut self, carrier: &mut dyn Communicator, last: bool, to: Option<usize>, from: Option<usize>) {
        let [out, into] = &mut self.edges;
        out.clear();
        if to.is_some() {
            self.section.edge(last, out);
        }
        into.resize(Section::<Chain<f64>>::EDGE_NUMBERS, 0.0);
        carrier.pass(to.map(|to| (to, &out[..])), from.map(|from| (from, &mut into[..])));
        if from.is_some() {
            self.section.take_edge(!last, into);
        }
    }

    pub(super) fn advance(&mut self) {
        self.section.advance();
    }

    /// What contacts of its own bonds did in the last window.
    pub(super) fn pieces(&self) -> impl Iterator<Item = &Piece> {
        self.section.pieces()
    }

    /// Sends the [`pieces`](Self::pieces) to part 0.
    pub(super) fn send_pieces(&self, carrier: &mut dyn Communicator) {
        let numbers: Vec<f64> = self.pieces().flat_map(Piece::numbers).collect();
        carrier.send(0, &[numbers.len() as f64]);
        numbers.chunks(MESSAGE * Piece::NUMBERS).for_each(|message| carrier.send(0, message));
    }

    pub(super) fn duplicate(&self) -> Self {
        let Self { section, chain, division, number, resonators, first, .. } = self;
        Self {
            section: section.duplicate(),
            chain: chain.clone(),
            division: *division,
            number: *number,
            resonators: *resonators,
            first: *first,
            edges: [Vec::new(), Vec::new()],
        }
    }

    pub(super) fn copy_from(&mut self, other: &Self) {
        self.section.copy_from(&other.section);
    }
}

/// Receives the pieces of contacts that another part sends, and calls `told` with each.
pub(super) fn receive_pieces(part: usize, carrier: &mut dyn Communicator, told: &mut dyn FnMut(&Piece)) {
    let mut count = [0.0];
    carrier.receive(part, &mut count);
    let (mut left, mut message) = (count[0] as usize, Vec::new());
    while left > 0 {
        message.resize(left.min(MESSAGE * Piece::NUMBERS), 0.0);
        carrier.receive(part, &mut message);
        let (pieces, _) = message.as_chunks();
        pieces.iter().for_each(|numbers| told(&Piece::of_numbers(numbers)));
        left -= message.len();
    }
}
