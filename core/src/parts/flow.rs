//! The flow of a chain in parts, used by part 0.

use super::{
    Communicator, Decomposition, Division, Motion,
    bonds::receive_pieces,
    order::Order,
    part::{Part, blocks, numbers, parted},
};
use crate::{
    chain::{Chain, Layout},
    error::Result,
};
use hertzchain_integrators::{
    DoubleDouble, SplitFlow,
    collocation::{Piece, Window, WindowOutcome, Windows},
};
use std::{
    ops::Range,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
};

/// The number of the next flow. All runs of the process share the counter, as flows of several runs
/// may use the same carrier.
static NEXT: AtomicU64 = AtomicU64::new(0);

/// A chain in parts: on one of its two splits, each kick and drift is made by all parts at once; by
/// contact collocation each window is solved by all of them.
///
/// Loading and storing move the whole state. The bits are those of [`KineticFlow`], [`LinearFlow`]
/// and [`Section`], for any number of parts.
///
/// [`KineticFlow`]: crate::chain::KineticFlow
/// [`LinearFlow`]: crate::chain::LinearFlow
/// [`Section`]: hertzchain_integrators::collocation::Section
pub struct Parted {
    carrier: Arc<Mutex<Box<dyn Communicator>>>,
    flow: u64,
    layout: Layout,
    division: Division,
    own: Part,
}

impl Parted {
    /// The chain in the state `y`.
    ///
    /// # Errors
    /// More parts than the chain has.
    pub fn new(chain: &Chain<f64>, motion: Motion, parts: &Decomposition, y: &[f64]) -> Result<Self> {
        parts.check_for(motion, chain.topology())?;
        let division = Division::new(chain.topology(), parts.count(), motion);
        let flow = NEXT.fetch_add(1, Ordering::Relaxed);
        let carrier = Arc::new(Mutex::new(parts.carrier()));
        let threads = locked(&carrier).threads();
        let own = Part::new(chain, division, (0, threads), motion);
        let mut parted = Self { carrier, flow, layout: chain.layout(), division, own };
        drop(parted.order(&Order::Begin(flow, motion, Box::new(chain.clone()))));
        parted.load(y);
        Ok(parted)
    }

    /// Sends an order to the other parts. Returns the carrier, for the messages that follow it.
    fn order(&self, order: &Order) -> MutexGuard<'_, Box<dyn Communicator>> {
        tell(&self.carrier, order)
    }

    /// Sends a state to all parts.
    fn set(&mut self, y: &[f64]) {
        let Self { carrier, flow, layout, division, own, .. } = self;
        let (arrays, mut message) = (layout.arrays(y), Vec::new());
        let mut carrier = tell(carrier, &Order::Load(*flow));
        for part in 0..division.parts() {
            let held = division.held(part);
            for block in blocks(held.clone()) {
                message.clear();
                arrays.iter().flat_map(|array| around(array, &block)).for_each(|run| message.extend_from_slice(run));
                match part {
                    0 => own.read(block.start - held.start, parted(&message, block.len())),
                    _ => carrier.send(part, &message),
                }
            }
        }
    }

    /// Collects the state of all parts in `y`.
    fn get(&self, y: &mut [f64]) {
        let mut message = Vec::new();
        let mut carrier = self.order(&Order::Store(self.flow));
        self.own.write(within(self.layout.arrays_mut(y), &self.own.own()));
        let division = self.division;
        for (part, block) in (1..division.parts()).flat_map(|p| blocks(division.sites(p)).map(move |b| (p, b))) {
            message.resize(numbers(self.layout.resonators()) * block.len(), 0.0);
            carrier.receive(part, &mut message);
            let arrays = within(self.layout.arrays_mut(y), &block);
            for (to, from) in arrays.into_iter().zip(parted(&message, block.len())) {
                to.copy_from_slice(from);
            }
        }
    }

    fn another(&self) -> Self {
        let flow = NEXT.fetch_add(1, Ordering::Relaxed);
        drop(self.order(&Order::Duplicate(self.flow, flow)));
        let Self { carrier, layout, division, own, .. } = self;
        Self { carrier: carrier.clone(), flow, layout: *layout, division: *division, own: own.duplicate() }
    }

    fn follow(&mut self, other: &Self) {
        drop(self.order(&Order::Copy(other.flow, self.flow)));
        self.own.copy_from(&other.own);
    }
}

fn locked(carrier: &Mutex<Box<dyn Communicator>>) -> MutexGuard<'_, Box<dyn Communicator>> {
    carrier.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Sends an order to the other parts. Returns the carrier, for the messages that follow it.
pub(super) fn tell<'a>(
    carrier: &'a Mutex<Box<dyn Communicator>>,
    order: &Order,
) -> MutexGuard<'a, Box<dyn Communicator>> {
    let mut carrier = locked(carrier);
    carrier.broadcast(&mut order.words());
    carrier
}

impl SplitFlow<f64> for Parted {
    fn dim(&self) -> usize {
        self.layout.dim()
    }

    fn moved(&self) -> usize {
        self.layout.dim().div_ceil(self.division.parts())
    }

    fn load(&mut self, y: &[f64]) {
        self.set(y);
    }

    fn store(&self, y: &mut [f64]) {
        self.get(y);
    }

    fn duplicate(&self) -> Self {
        self.another()
    }

    fn copy_from(&mut self, other: &Self) {
        self.follow(other);
    }

    fn drift(&mut self, dt: DoubleDouble<f64>) {
        drop(self.order(&Order::Drift(self.flow, dt)));
        self.own.drift(dt);
    }

    fn kick_drift(&mut self, kick: f64, drift: DoubleDouble<f64>) {
        self.kick_drifts(&[(kick, drift)]);
    }

    fn kick_drifts(&mut self, pairs: &[(f64, DoubleDouble<f64>)]) {
        let Self { carrier, own, flow, .. } = self;
        let mut carrier = tell(carrier, &Order::Kicks(*flow, pairs.to_vec()));
        own.kick_drifts(pairs, &mut **carrier);
    }
}

impl Windows for Parted {
    fn dim(&self) -> usize {
        self.layout.dim()
    }

    fn solve(&mut self, window: &Window) -> WindowOutcome {
        let Self { carrier, own, flow, division, .. } = self;
        let mut carrier = tell(carrier, &Order::Solve(*flow, *window));
        let own = own.windows_mut().solve(window, &mut **carrier);
        let mut numbers = [0.0; WindowOutcome::NUMBERS];
        (1..division.parts()).fold(own, |all, part| {
            carrier.receive(part, &mut numbers);
            all.and(WindowOutcome::of_numbers(&numbers))
        })
    }

    fn advance(&mut self) {
        drop(self.order(&Order::Advance(self.flow)));
        self.own.windows_mut().advance();
    }

    fn duplicate(&self) -> Self {
        self.another()
    }

    fn copy_from(&mut self, other: &Self) {
        self.follow(other);
    }

    fn store(&self, y: &mut [f64]) {
        self.get(y);
    }

    fn tell(&self, told: &mut dyn FnMut(&Piece)) {
        let mut carrier = self.order(&Order::Tell(self.flow));
        self.own.windows().pieces().for_each(&mut *told);
        (1..self.division.parts()).for_each(|part| receive_pieces(part, &mut **carrier, told));
    }
}

impl Drop for Parted {
    fn drop(&mut self) {
        drop(self.order(&Order::Forget(self.flow)));
    }
}

/// The entries of some sites, of arrays over all sites; empty arrays stay empty.
fn within<'a>(arrays: [&'a mut [f64]; 4], sites: &Range<usize>) -> [&'a mut [f64]; 4] {
    arrays.map(|array| array.get_mut(sites.clone()).unwrap_or_default())
}

/// The entries of some sites, of an array over all sites, in two slices: numbers beyond the last
/// site mean the first sites again. An empty array has none.
fn around<'a>(array: &'a [f64], sites: &Range<usize>) -> [&'a [f64]; 2] {
    if array.is_empty() {
        return [array; 2];
    }
    let (start, len) = (sites.start % array.len(), sites.len());
    let before = len.min(array.len() - start);
    [&array[start..][..before], &array[..len - before]]
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::{
        Boundary, Method, Params, State,
        parts::GHOSTS,
        run::{Records, Run, Setting},
    };

    /// A run that is sampled between its steps, of a chain that moves everywhere.
    pub(in super::super) fn run(boundary: Boundary, (alpha, rho): (f64, f64), sites: usize, name: &str) -> Run {
        let chain = Chain::new(Params::new(alpha, 1.0, rho).unwrap(), boundary, sites).unwrap();
        let chain = chain.clone().precompressed(0.05).unwrap_or(chain);
        let mut state = State::rest(&chain);
        state.as_mut_slice().iter_mut().enumerate().for_each(|(i, y)| *y = 0.3 * (0.7 * (i * i) as f64).sin());
        let run = Run::new(chain, state).until(5.0).unwrap().method(Method::named(name).unwrap());
        run.setting(Setting::Steps(70)).records(Records::Profiles).samples_at(&[0.0, 0.1, 2.003, 2.01, 5.0]).unwrap()
    }

    /// What must not depend on the number of parts.
    fn outcome(run: &Run) -> (Vec<f64>, Vec<Vec<f64>>, String) {
        let end = run.start().unwrap();
        assert!(end.failure.is_none(), "{:?}", end.failure);
        let states = end.profiles.into_iter().map(|profile| profile.state).collect();
        (end.state, states, format!("{:?} {:?} {:?}", end.samples, end.energy_error, end.stats))
    }

    fn holds(run: &Run, counts: &[usize]) {
        let whole = outcome(run);
        for &count in counts {
            let parts = outcome(&run.clone().in_parts(Decomposition::Threads(count)).unwrap());
            let chain = run.chain();
            assert!(parts == whole, "{:?} {:?} {} {count}", chain.boundary(), chain.params(), chain.sites());
        }
    }

    #[test]
    fn parts_have_the_bits_of_the_whole_chain() {
        // Truth: the same run in one thread, to the bit, with samples inside steps and energies.
        // Parts longer than two zones of ghosts, shorter ones, and those of one or two sites.
        for boundary in Boundary::ALL {
            for model in [(1.5, 1.0 / 3.0), (1.5, 0.0), (2.0, f64::INFINITY)] {
                for name in ["verlet", "strang-linear", "aba864-linear", "yoshida4"] {
                    holds(&run(boundary, model, 3 * GHOSTS + 41, name), &[1, 2, 3, 7]);
                    holds(&run(boundary, model, 9, name), &[2, 3, 7, 9]);
                }
            }
        }
        holds(&run(Boundary::Ring, (1.5, 1.0), 2, "verlet"), &[1, 2]);
        holds(&run(Boundary::Free, (1.5, 1.0), 1, "strang-linear"), &[1]);
    }

    #[test]
    fn splitting_schemes_and_collocation_run_in_parts_and_no_other_method_does() {
        for method in Method::all() {
            let name = method.name();
            let run = run(Boundary::Ring, (1.5, 1.0), 40, &name);
            if let Ok(Motion::Kicks(_)) = method.motion() {
                holds(&run, &[3]);
                continue;
            }
            let words = if method == Method::Collocation { "3 > 1" } else { "only splitting schemes" };
            let run = if method.tolerant() { run.tolerance(1e-6).unwrap() } else { run };
            for run in [run.clone(), run.contacts()] {
                let refused = run.in_parts(Decomposition::Threads(3)).unwrap().start().unwrap_err().to_string();
                assert!(refused.contains(words), "{name}: {refused}");
            }
        }
    }

    /// A run by collocation with contacts everywhere, or where a bead is struck.
    pub(in super::super) fn collocation(
        boundary: Boundary,
        model: (f64, f64),
        sites: usize,
        struck: Option<usize>,
    ) -> Run {
        let mut state = run(boundary, model, sites, "collocation").initial().clone();
        if let Some(struck) = struck {
            state.as_mut_slice().fill(0.0);
            state.u_dot_mut()[struck..struck + 2].copy_from_slice(&[-1.0, 0.5]);
        }
        let chain = Chain::new(Params::new(model.0, 1.0, model.1).unwrap(), boundary, sites).unwrap();
        let chain = if struck.is_some() { chain } else { chain.clone().precompressed(0.05).unwrap_or(chain) };
        let end = if struck.is_some() { 8.0 } else { 1.0 };
        let times = [0.0, 0.1, 0.5003 * end, 0.501 * end, end];
        let run = Run::new(chain, state).until(end).unwrap().tolerance(1e-7).unwrap().contacts();
        run.records(Records::Profiles).samples_at(&times).unwrap()
    }

    fn windows_hold(run: &Run, counts: &[usize]) {
        let log = |run: &Run| run.start().unwrap().contacts.unwrap();
        let (whole, several) = (log(run), counts.last().unwrap());
        assert!(whole.len() > 5, "{}", whole.len());
        assert!(
            log(&run.clone().in_parts(Decomposition::Threads(*several)).unwrap()) == whole,
            "{:?}",
            run.chain().boundary()
        );
        holds(run, counts);
    }

    #[test]
    fn windows_in_parts_have_the_bits_of_the_whole_chain() {
        // Truth: the same run in one process, to the bit: states, samples inside windows, energies,
        // counts, contacts. Contacts are everywhere, also in bonds between parts; the last block of
        // 1283 sites is too short to be a part, that of 1300 is not.
        for boundary in Boundary::ALL {
            windows_hold(&collocation(boundary, (1.5, 1.0 / 3.0), 1283, None), &[2, 5]);
            windows_hold(&collocation(boundary, (2.0, 0.0), 1300, None), &[3, 6]);
        }
        let equal = collocation(Boundary::Fixed, (1.5, f64::INFINITY), 600, None);
        windows_hold(&equal.setting(Setting::Windows(20, 6)), &[2]);
    }

    #[test]
    fn pulses_pass_from_part_to_part() {
        // Truth: as above. At first all blocks sleep but one or two.
        for (boundary, struck) in [
            (Boundary::Free, 255),
            (Boundary::Free, 511),
            (Boundary::Fixed, 256),
            (Boundary::Ring, 698),
            (Boundary::Ring, 0),
            (Boundary::StrainRing, 254),
        ] {
            windows_hold(&collocation(boundary, (1.5, 1.0), 700, Some(struck)), &[2, 3]);
        }
    }

    #[test]
    fn contacts_are_found_in_parts() {
        let run = run(Boundary::Fixed, (1.5, 1.0), 20, "strang-linear").contacts();
        let contacts = |run: &Run| run.start().unwrap().contacts.unwrap();
        let whole = contacts(&run);
        assert!(whole.len() > 20);
        assert_eq!(contacts(&run.in_parts(Decomposition::Threads(3)).unwrap()), whole);
    }

    #[test]
    fn a_number_of_parts_outside_its_rule_is_refused() {
        let run = run(Boundary::Free, (1.5, 0.0), 5, "verlet");
        let refused = |count| run.clone().in_parts(Decomposition::Threads(count)).unwrap_err().to_string();
        assert_eq!(refused(0), "threads = 0 is not valid: from 1 to 1024 threads");
        assert_eq!(refused(6), "threads = 6 is not valid: a chain has at most as many parts as sites: ask for fewer");
        assert!(refused(1025).contains("1024"));
        let run = collocation(Boundary::Free, (1.5, 0.0), 525, None);
        let refused = run.in_parts(Decomposition::Threads(3)).unwrap().start().unwrap_err().to_string();
        // 524 bonds: the third block has 12, one too few.
        assert_eq!(
            refused,
            "threads = 3 > 2 is not valid: a part has at least one site, by collocation one block of 256 bonds: ask for fewer"
        );
    }
}
