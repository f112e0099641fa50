//! Equal chains that are moved together, one in each lane of a register.

use super::{Chain, divisible::Divisible, rows::SHORT};
use hertzchain_integrators::{DoubleDouble, SplitFlow, Vector, with_registers};
use std::cell::RefCell;

/// Equal chains in different states, as many as a register has lanes or fewer.
///
/// A state of it is that of one chain after the other. No lane sees another one, and each number is
/// computed as in a chain alone, so that the bits are the same.
pub struct Batch<F> {
    /// A member.
    chain: Chain<f64>,
    members: usize,
    /// Number `i` of the state of member `m` is number `i lanes + m` of its state.
    flow: F,
    /// A state of `flow`.
    state: RefCell<Vec<f64>>,
}

/// Number of lanes of the instructions in use.
fn lanes() -> usize {
    with_registers!(V => V::LANES)
}

impl<F: Divisible<f64>> Batch<F> {
    /// The largest number of chains that can be moved together: one for a chain with details, or
    /// with so many sites that a batch does not stay in the cache.
    pub fn most(chain: &Chain<f64>) -> usize {
        let lanes = lanes();
        if chain.details().is_none() && chain.sites() * lanes <= SHORT { lanes } else { 1 }
    }

    /// Chains at rest.
    ///
    /// # Panics
    /// More than [`most`](Self::most).
    pub fn new(chain: Chain<f64>, members: usize) -> Self {
        assert!(members <= Self::most(&chain), "more chains than can be moved together");
        let all = chain.abreast(lanes());
        let state = vec![0.0; all.layout().dim()].into();
        Self { chain, members, flow: F::rest(all), state }
    }
}

impl<F: Divisible<f64>> SplitFlow<f64> for Batch<F> {
    fn dim(&self) -> usize {
        self.members * self.chain.layout().dim()
    }

    fn load(&mut self, y: &[f64]) {
        let (dim, state) = (self.chain.layout().dim(), self.state.get_mut());
        let lanes = state.len() / dim;
        for (m, y) in y.chunks(dim).enumerate() {
            state.iter_mut().skip(m).step_by(lanes).zip(y).for_each(|(to, from)| *to = *from);
        }
        self.flow.load(state);
    }

    fn store(&self, y: &mut [f64]) {
        let (dim, mut state) = (self.chain.layout().dim(), self.state.borrow_mut());
        self.flow.store(&mut state);
        let lanes = state.len() / dim;
        for (m, y) in y.chunks_mut(dim).enumerate() {
            y.iter_mut().zip(state.iter().skip(m).step_by(lanes)).for_each(|(to, from)| *to = *from);
        }
    }

    fn duplicate(&self) -> Self {
        let Self { chain, members, flow, state } = self;
        Self { chain: chain.clone(), members: *members, flow: flow.duplicate(), state: state.clone() }
    }

    fn copy_from(&mut self, other: &Self) {
        self.flow.copy_from(&other.flow);
    }

    fn drift(&mut self, dt: DoubleDouble<f64>) {
        self.flow.drift(dt);
    }

    fn kick_drift(&mut self, kick: f64, drift: DoubleDouble<f64>) {
        self.flow.kick_drift(kick, drift);
    }

    fn kick_drifts(&mut self, pairs: &[(f64, DoubleDouble<f64>)]) {
        self.flow.kick_drifts(pairs);
    }
}
