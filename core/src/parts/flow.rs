//! The flow of a chain in parts, as part 0 has it.

use super::{
    Carrier, Division, Parts,
    order::Order,
    part::{Part, blocks, numbers, parted},
};
use crate::{
    chain::{Chain, Layout, Split},
    error::Result,
};
use hertzchain_integrators::{SplitFlow, Twofold};
use std::{
    ops::Range,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
};

/// The next number of a flow. One for the process, as flows of several runs may meet at a carrier.
static NEXT: AtomicU64 = AtomicU64::new(0);

/// A chain in parts, on one of its two splits: each kick and drift is made by all parts at once.
///
/// What is loaded and stored is the whole state. The bits are those of [`KineticFlow`] and
/// [`LinearFlow`], for any number of parts.
///
/// [`KineticFlow`]: crate::chain::KineticFlow
/// [`LinearFlow`]: crate::chain::LinearFlow
pub struct Parted {
    carrier: Arc<Mutex<Box<dyn Carrier>>>,
    flow: u64,
    layout: Layout,
    division: Division,
    own: Part,
}

impl Parted {
    /// The chain at rest; load a state into it.
    ///
    /// # Errors
    /// More parts than sites.
    pub fn new(chain: &Chain<f64>, split: Split, parts: &Parts) -> Result<Self> {
        parts.check(chain.sites())?;
        let division = Division::new(chain.topology(), parts.count());
        let flow = NEXT.fetch_add(1, Ordering::Relaxed);
        let carrier = Arc::new(Mutex::new(parts.carrier()));
        let own = Part::new(chain, division, 0, split);
        let parted = Self { carrier, flow, layout: chain.layout(), division, own };
        drop(parted.order(&Order::Begin(flow, split, Box::new(chain.clone()))));
        Ok(parted)
    }

    /// Tells the other parts what to do; the carrier, for what is then sent.
    fn order(&self, order: &Order) -> MutexGuard<'_, Box<dyn Carrier>> {
        let mut carrier = self.carrier.lock().unwrap_or_else(PoisonError::into_inner);
        carrier.broadcast(&mut order.words());
        carrier
    }

    /// The other parts, with the blocks in which their states are sent.
    fn others(&self) -> impl Iterator<Item = (usize, Range<usize>)> + use<> {
        let division = self.division;
        (1..division.parts()).flat_map(move |part| blocks(division.sites(part)).map(move |block| (part, block)))
    }
}

impl SplitFlow<f64> for Parted {
    fn dim(&self) -> usize {
        self.layout.dim()
    }

    fn moved(&self) -> usize {
        self.dim().div_ceil(self.division.parts())
    }

    fn load(&mut self, y: &[f64]) {
        let arrays = self.layout.arrays(y);
        let mut message = Vec::new();
        let mut carrier = self.order(&Order::Load(self.flow));
        for (part, block) in self.others() {
            message.clear();
            within(arrays, &block).into_iter().for_each(|array| message.extend_from_slice(array));
            carrier.send(part, &message);
        }
        drop(carrier);
        self.own.read(within(arrays, &self.own.own()));
    }

    fn store(&self, y: &mut [f64]) {
        let mut message = Vec::new();
        let mut carrier = self.order(&Order::Store(self.flow));
        self.own.write(within_mut(self.layout.arrays_mut(y), &self.own.own()));
        for (part, block) in self.others() {
            message.resize(numbers(self.layout.resonators()) * block.len(), 0.0);
            carrier.receive(part, &mut message);
            let arrays = within_mut(self.layout.arrays_mut(y), &block);
            for (to, from) in arrays.into_iter().zip(parted(&message, block.len())) {
                to.copy_from_slice(from);
            }
        }
    }

    fn duplicate(&self) -> Self {
        let flow = NEXT.fetch_add(1, Ordering::Relaxed);
        drop(self.order(&Order::Duplicate(self.flow, flow)));
        let Self { carrier, layout, division, own, .. } = self;
        Self { carrier: carrier.clone(), flow, layout: *layout, division: *division, own: own.duplicate() }
    }

    fn copy_from(&mut self, other: &Self) {
        drop(self.order(&Order::Copy(other.flow, self.flow)));
        self.own.copy_from(&other.own);
    }

    fn drift(&mut self, dt: Twofold<f64>) {
        drop(self.order(&Order::Drift(self.flow, dt)));
        self.own.drift(dt);
    }

    fn kick_drift(&mut self, kick: f64, drift: Twofold<f64>) {
        self.kick_drifts(&[(kick, drift)]);
    }

    fn kick_drifts(&mut self, pairs: &[(f64, Twofold<f64>)]) {
        let Self { carrier, own, flow, .. } = self;
        let mut carrier = carrier.lock().unwrap_or_else(PoisonError::into_inner);
        carrier.broadcast(&mut Order::Kicks(*flow, pairs.to_vec()).words());
        own.kick_drifts(pairs, &mut **carrier);
    }
}

impl Drop for Parted {
    fn drop(&mut self) {
        drop(self.order(&Order::Forget(self.flow)));
    }
}

/// Some sites of arrays of all; empty arrays stay empty.
fn within<'a>(arrays: [&'a [f64]; 4], sites: &Range<usize>) -> [&'a [f64]; 4] {
    arrays.map(|array| array.get(sites.clone()).unwrap_or_default())
}

/// The same, to be written.
fn within_mut<'a>(arrays: [&'a mut [f64]; 4], sites: &Range<usize>) -> [&'a mut [f64]; 4] {
    arrays.map(|array| array.get_mut(sites.clone()).unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Boundary, Method, Params, State,
        parts::GHOSTS,
        run::{Records, Run, Setting},
    };

    const BOUNDARIES: [Boundary; 4] = [Boundary::Free, Boundary::Fixed, Boundary::Ring, Boundary::StrainRing];

    /// A run that is sampled between its steps, of a chain that moves everywhere.
    fn run(boundary: Boundary, (alpha, rho): (f64, f64), sites: usize, name: &str) -> Run {
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
            let parts = outcome(&run.clone().in_parts(Parts::Threads(count)).unwrap());
            let chain = run.chain();
            assert!(parts == whole, "{:?} {:?} {} {count}", chain.boundary(), chain.params(), chain.sites());
        }
    }

    #[test]
    fn parts_have_the_bits_of_the_whole_chain() {
        // Truth: the same run in one thread, to the bit, with samples inside steps and energies.
        // Parts longer than two zones of ghosts, shorter ones, and those of one or two sites.
        for boundary in BOUNDARIES {
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
    fn all_splitting_schemes_run_in_parts_and_no_other_method_does() {
        for method in Method::all() {
            let name = method.name();
            let run = run(Boundary::Ring, (1.5, 1.0), 40, &name);
            if method.divisible() {
                holds(&run, &[3]);
                continue;
            }
            let run = if method.tolerant() { run.tolerance(1e-6).unwrap() } else { run };
            for run in [run.clone(), run.contacts()] {
                let refused = run.in_parts(Parts::Threads(3)).unwrap().start().unwrap_err().to_string();
                assert!(refused.contains(&name) && refused.contains("only splitting schemes"), "{refused}");
            }
        }
    }

    #[test]
    fn contacts_are_found_in_parts() {
        let run = run(Boundary::Fixed, (1.5, 1.0), 20, "strang-linear").contacts();
        let contacts = |run: &Run| run.start().unwrap().contacts.unwrap();
        let whole = contacts(&run);
        assert!(whole.len() > 20);
        assert_eq!(contacts(&run.in_parts(Parts::Threads(3)).unwrap()), whole);
    }

    #[test]
    fn a_number_of_parts_outside_its_rule_is_refused() {
        let run = run(Boundary::Free, (1.5, 0.0), 5, "verlet");
        let refused = |count| run.clone().in_parts(Parts::Threads(count)).unwrap_err().to_string();
        assert_eq!(refused(0), "threads = 0 is not valid: from 1 to 1024 threads");
        assert_eq!(refused(6), "threads = 6 is not valid: a chain has at most as many parts as sites: ask for fewer");
        assert!(refused(1025).contains("1024"));
    }
}
