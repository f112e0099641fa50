//! A run of which no process has the whole state: each part keeps that of its own sites.

use super::{
    Carrier, Division, Files, Motion, ONE_PART, Own, Parts,
    order::Order,
    part::{Part, blocks, numbers, parted},
    serve::receive_text,
};
use crate::{
    chain::{Blocks, Chain},
    error::{Error, Result},
};
use std::{
    cell::RefCell,
    fmt,
    ops::Range,
    path::Path,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

/// The parts of one run, each of which keeps the state of its own sites; used by part 0.
///
/// A flow begins from the kept state, and a sample replaces the kept state. Part 0 reads it as
/// [`Blocks`], which the parts send one after the other. So no process has more of the chain than
/// its own part, and sums over sites have the bits of one process.
pub struct Apart {
    pub(super) carrier: Arc<Mutex<Box<dyn Carrier>>>,
    own: Mutex<Own>,
    files: Arc<dyn Files>,
    parts: Parts,
    pub(super) division: Division,
    chain: Chain<f64>,
}

impl Apart {
    /// The parts of a chain in a state that is given in blocks. They write their files by `files`.
    ///
    /// # Errors
    /// More parts than the chain has; a chain with [`Details`](crate::chain::Details).
    pub fn new(
        chain: &Chain<f64>,
        motion: Motion,
        parts: &Parts,
        files: Arc<dyn Files>,
        state: &dyn Blocks<f64>,
    ) -> Result<Self> {
        parts.check_for(motion, chain.topology())?;
        if chain.details().is_some() {
            return Err(Error::parameter("parts", parts.count(), ONE_PART));
        }
        let division = Division::new(chain.topology(), parts.count(), motion);
        let carrier = Arc::new(Mutex::new(parts.carrier(&files)));
        let own = Mutex::new(Own::new(chain.layout().resonators(), division, 0));
        let apart = Self { carrier, own, files, parts: parts.clone(), division, chain: chain.clone() };
        drop(apart.order(&Order::Keep(motion, Box::new(chain.clone()))));
        apart.put(state);
        Ok(apart)
    }

    /// Sends an order to the other parts. Returns the carrier, for the messages that follow it.
    pub(super) fn order(&self, order: &Order) -> MutexGuard<'_, Box<dyn Carrier>> {
        super::flow::tell(&self.carrier, order)
    }

    fn own(&self) -> MutexGuard<'_, Own> {
        self.own.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The threads or processes of its parts.
    pub fn parts(&self) -> &Parts {
        &self.parts
    }

    /// Sends a state to the parts, in blocks that begin with the first own site of each part.
    fn put(&self, state: &dyn Blocks<f64>) {
        let (division, numbers) = (self.division, numbers(self.chain.layout().resonators()));
        let (mut carrier, mut own) = (self.order(&Order::Put), self.own());
        let mut waiting = (0..division.parts())
            .flat_map(|part| blocks(0..division.sites(part).len()).map(move |block| (part, block)));
        let mut current = waiting.next();
        // Sites collected for the current block, a vector for each of `[u, v, u', v']`.
        let mut columns = [const { Vec::new() }; 4];
        state.each(&mut |_, arrays| {
            let mut taken = 0;
            while let Some((part, block)) = current.clone().filter(|_| taken < arrays[0].len()) {
                let count = (block.len() - columns[0].len()).min(arrays[0].len() - taken);
                for (column, array) in columns.iter_mut().zip(arrays).filter(|(_, array)| !array.is_empty()) {
                    column.extend_from_slice(&array[taken..taken + count]);
                }
                taken += count;
                if columns[0].len() == block.len() {
                    let message = columns.concat();
                    debug_assert_eq!(message.len(), numbers * block.len());
                    if part == 0 {
                        own.set(block, &message)
                    } else {
                        carrier.send(part, &message)
                    }
                    columns.iter_mut().for_each(Vec::clear);
                    current = waiting.next();
                }
            }
        });
    }

    /// The kept states of some sites of a part, counted from its first one: the arrays `[u, v, u',
    /// v']`, one after the other.
    fn piece(&self, part: usize, sites: Range<usize>) -> Vec<f64> {
        let (mut carrier, own) = (self.order(&Order::Piece(part, sites.clone())), self.own());
        if part == 0 {
            return own.message(sites);
        }
        let mut message = vec![0.0; numbers(self.chain.layout().resonators()) * sites.len()];
        carrier.receive(part, &mut message);
        message
    }

    /// A function from the number of a site to its state. Sites are fetched in blocks, and one
    /// block is held: callers should ask for neighbours one after the other.
    pub(crate) fn sites(&self) -> impl Fn(usize) -> [f64; 4] {
        let division = self.division;
        let fetched = RefCell::new((0..0, Vec::new()));
        move |site| {
            let mut fetched = fetched.borrow_mut();
            if !fetched.0.contains(&site) {
                let part = (0..division.parts()).find(|&part| division.sites(part).contains(&site));
                let part = part.expect("a site of the chain");
                let own = division.sites(part);
                let block = blocks(0..own.len()).find(|block| block.contains(&(site - own.start)));
                let block = block.expect("blocks of all sites");
                let message = self.piece(part, block.clone());
                *fetched = (own.start + block.start..own.start + block.end, message);
            }
            let (sites, message) = &*fetched;
            let arrays = parted(message, sites.len());
            arrays.map(|array| array.get(site - sites.start).copied().unwrap_or_default())
        }
    }

    /// Has each part take the state of its own sites from a flow.
    pub(super) fn take(&self, flow: u64, part: &Part) {
        drop(self.order(&Order::Take(flow)));
        self.own().take(part);
    }

    /// Has each part set a flow that begins to the kept state.
    pub(super) fn give(&self, flow: u64, part: &mut Part) {
        let (mut carrier, own) = (self.order(&Order::Give(flow)), self.own());
        own.give(part, self.chain.topology(), &mut **carrier);
    }

    /// Marks the state as one that could not be computed.
    pub(super) fn lose(&self) {
        drop(self.order(&Order::Lose));
        self.own().lose();
    }

    /// Has each part keep the state as a profile.
    pub(crate) fn profile(&self) {
        drop(self.order(&Order::Profile));
        self.own().keep();
    }

    /// Has each part write what it keeps: the state at the end of the leg of this number, and the
    /// profiles since the last write. Returns the number of these profiles.
    ///
    /// # Errors
    /// The first part that could not write, and why.
    pub fn write(&self, folder: &Path, leg: u64) -> Result<usize> {
        if folder.to_str().is_none() {
            let rule = "parts tell each other the name of a folder in UTF-8";
            return Err(Error::parameter("out", folder.display(), rule));
        }
        let (mut carrier, mut own) = (self.order(&Order::Write(leg, folder.to_owned())), self.own());
        let profiles = own.profiles().len();
        let said = own.write(&*self.files, folder, leg).err().unwrap_or_default();
        let others = (1..self.division.parts()).map(|part| receive_text(&mut **carrier, part));
        // All answers are received, so that no part waits.
        let all: Vec<String> = [said].into_iter().chain(others).collect();
        match all.iter().position(|said| !said.is_empty()) {
            None => Ok(profiles),
            Some(part) => {
                let source = std::io::Error::other(format!("part {part}: {}", all[part]));
                Err(Error::File { path: folder.to_owned(), source })
            }
        }
    }
}

impl Blocks<f64> for Apart {
    fn each(&self, see: &mut dyn FnMut(usize, [&[f64]; 4])) {
        let (mut carrier, own) = (self.order(&Order::Show), self.own());
        see(0, own.arrays());
        let (division, numbers) = (self.division, numbers(self.chain.layout().resonators()));
        let mut message = Vec::new();
        for part in 1..division.parts() {
            let sites = division.sites(part);
            for block in blocks(sites) {
                message.resize(numbers * block.len(), 0.0);
                carrier.receive(part, &mut message);
                see(block.start, parted(&message, block.len()));
            }
        }
    }

    fn last(&self) -> f64 {
        let part = self.division.parts() - 1;
        let count = self.division.sites(part).len();
        self.piece(part, count - 1..count)[0]
    }
}

impl fmt::Debug for Apart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} sites, each part with its own of {:?}", self.chain.sites(), self.parts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Boundary, Method, Run,
        parts::flow::tests::{BOUNDARIES, collocation, run},
        run::{Initial, Kept, Recorder, Records},
    };

    /// What parts have written: leg, part, sites, state, profiles.
    type Written = (u64, usize, Range<usize>, Vec<f64>, Vec<Vec<f64>>);

    /// Files in memory.
    #[derive(Debug, Default)]
    struct Memory(Mutex<Vec<Written>>);

    impl Files for Memory {
        fn write(&self, _: &Path, leg: u64, own: &Own) -> std::result::Result<(), String> {
            if leg == REFUSED && own.part() == 1 {
                return Err("disk full".to_owned());
            }
            let written = (leg, own.part(), own.sites(), own.state().to_vec(), own.profiles().to_vec());
            self.0.lock().unwrap().push(written);
            Ok(())
        }
    }

    /// A leg that part 1 does not write.
    const REFUSED: u64 = 99;

    /// The whole state, joined from what parts have written.
    fn joined(layout: crate::chain::Layout, pieces: &[(Range<usize>, &[f64])]) -> Vec<f64> {
        let mut y = vec![f64::NAN; layout.dim()];
        for (sites, piece) in pieces {
            let all = layout.arrays_mut(&mut y);
            for (array, own) in all.into_iter().zip(parted(piece, sites.len())).filter(|(_, own)| !own.is_empty()) {
                array[sites.clone()].copy_from_slice(own);
            }
        }
        y
    }

    /// Runs apart in two legs, from a state that is given site by site, and compares the results
    /// with those of the same legs in one piece.
    fn holds(like: &Run, count: usize) {
        let from = |initial: Initial| {
            let run = Run::new(like.chain().clone(), initial).until(like.end().unwrap()).unwrap();
            run.records(Records::Profiles).samples(7).unwrap()
        };
        let run = &from(like.initial().clone().into());
        let (method, setting) = like.choice().unwrap();
        let (chain, motion) = (run.chain().clone(), method.motion().unwrap());
        let legs = [run.end().unwrap() * 0.4, run.end().unwrap()];
        let mut seen = |_: f64, _: &[f64]| ();
        let mut whole = Recorder::new(run, Kept::new(run), &mut seen);
        for end in legs {
            whole.go_on(method, setting, end).unwrap().unwrap();
        }
        let whole = whole.kept;
        let (arrays, layout) = (run.initial().as_slice().to_vec(), chain.layout());
        let initial = Initial::by_sites(&chain, move |i| {
            let [u, v, u_dot, v_dot] = layout.arrays(&arrays).map(|array| array.get(i).copied().unwrap_or_default());
            crate::chain::Site { u, v, u_dot, v_dot }
        });
        let memory = Arc::new(Memory::default());
        let apart = Apart::new(&chain, motion, &Parts::Threads(count), memory.clone(), &initial).unwrap();
        let apart = Arc::new(apart);
        let run = from(initial.clone()).in_parts(Parts::Apart(apart.clone())).unwrap();
        let mut seen = |_: f64, _: &[f64]| ();
        let mut parts = Recorder::new(&run, Kept::new(&run), &mut seen);
        for (leg, end) in legs.into_iter().enumerate() {
            parts.go_on(method, setting, end).unwrap().unwrap();
            apart.write(Path::new(""), leg as u64).unwrap();
        }
        let what = format!("{:?} {method:?} {count}", chain.boundary());
        assert!(initial.made().is_none() && parts.kept.state.is_empty(), "{what}: no state in one piece");
        assert!(parts.kept.samples == whole.samples && parts.kept.largest == whole.largest, "{what}");
        assert!(parts.kept.stats == whole.stats && parts.kept.profiles.len() == whole.profiles.len(), "{what}");
        let mut written = memory.0.lock().unwrap();
        written.sort_by_key(|(leg, part, ..)| (*leg, *part));
        assert_eq!(written.len(), 2 * count);
        let end: Vec<_> = written[count..].iter().map(|(_, _, sites, state, _)| (sites.clone(), &state[..])).collect();
        assert!(joined(layout, &end) == whole.state, "{what}");
        let profiles = written.chunks(count).flat_map(|leg| {
            (0..leg[0].4.len()).map(|k| {
                let pieces: Vec<_> = leg.iter().map(|(_, _, sites, _, rows)| (sites.clone(), &rows[k][..])).collect();
                joined(layout, &pieces)
            })
        });
        assert!(profiles.eq(whole.profiles.iter().map(|profile| profile.state.clone())), "{what}");
    }

    #[test]
    fn parts_that_keep_their_own_have_the_bits_of_the_whole_chain() {
        // Truth: the same legs in one thread, to the bit: energies, largest errors, counts, states
        // at samples and at the end. Parts longer and shorter than a zone of ghosts. Kicks of a long
        // chain keep a register between two calls, so no other test may choose instructions.
        let _alone = crate::chain::one_set_at_a_time();
        for boundary in BOUNDARIES {
            for model in [(1.5, 1.0 / 3.0), (1.5, 0.0), (2.0, f64::INFINITY)] {
                for (name, sites) in [("verlet", 233), ("strang-linear", 9)] {
                    (1..4).for_each(|count| holds(&run(boundary, model, sites, name), count));
                }
            }
            holds(&collocation(boundary, (1.5, 1.0 / 3.0), 1283, None), 3);
            holds(&collocation(boundary, (1.5, 0.0), 700, Some(255)), 2);
        }
        holds(&run(Boundary::Ring, (1.5, 1.0), 1, "verlet"), 1);
        // More sites in a part than in a message.
        holds(&run(Boundary::Ring, (1.5, 1.0 / 3.0), 140_000, "verlet"), 2);
    }

    #[test]
    fn a_state_that_is_lost_is_lost_in_all_parts() {
        let run = run(Boundary::Ring, (1.5, 1.0), 30, "verlet");
        let (motion, memory) = (Method::named("verlet").unwrap().motion().unwrap(), Arc::new(Memory::default()));
        let initial: Initial = run.initial().clone().into();
        let apart = Apart::new(run.chain(), motion, &Parts::Threads(3), memory, &initial).unwrap();
        apart.lose();
        let mut seen = 0;
        apart.each(&mut |first, arrays| {
            assert!(first == seen && arrays.into_iter().flatten().all(|value| value.is_nan()), "{first}");
            seen += arrays[0].len();
        });
        assert_eq!(seen, 30);
    }

    #[test]
    fn a_part_that_cannot_write_is_named() {
        let run = run(Boundary::Ring, (1.5, 1.0), 30, "verlet");
        let (motion, memory) = (Method::named("verlet").unwrap().motion().unwrap(), Arc::new(Memory::default()));
        let initial: Initial = run.initial().clone().into();
        let apart = Apart::new(run.chain(), motion, &Parts::Threads(3), memory, &initial).unwrap();
        let refused = apart.write(Path::new("there"), REFUSED).unwrap_err().to_string();
        assert!(refused.contains("there") && refused.contains("part 1: disk full"), "{refused}");
        // The others go on.
        assert_eq!(apart.write(Path::new("there"), 1).unwrap(), 0);
        assert_eq!(apart.sites()(29)[0], run.initial().u()[29]);
    }
}
