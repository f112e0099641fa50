//! Orders: messages of part 0 to all other parts, in words of 64 bits.

use crate::{
    chain::{Boundary, Chain, Params, Split},
    parts::Motion,
};
use hertzchain_integrators::{DoubleDouble, collocation::Window};
/// What the other parts are to do next. A part may have several flows, each with a number: the
/// first field of most orders.
#[derive(Debug)]
pub(super) enum Order {
    /// Create a flow of a chain, at rest.
    Begin(u64, Motion, Box<Chain<f64>>),
    /// Receive the state of a flow from part 0.
    Load(u64),
    /// Send the state of a flow to part 0.
    Store(u64),
    Drift(u64, DoubleDouble<f64>),
    Kicks(u64, Vec<(f64, DoubleDouble<f64>)>),
    /// Create a flow, given second, as a copy of the first.
    Duplicate(u64, u64),
    /// Copy the state of the first flow to the second.
    Copy(u64, u64),
    /// Drop a flow.
    Forget(u64),
    /// Solve a window, and send its `WindowOutcome` to part 0.
    Solve(u64, Window),
    /// Advance a flow over the window that was solved last.
    Advance(u64),
    /// Send part 0 the pieces of contacts of the window that was solved last.
    Tell(u64),
    /// Leave the loop of orders.
    End,
}

const MOTIONS: [Motion; 3] = [Motion::Kicks(Split::Kinetic), Motion::Kicks(Split::Linear), Motion::Windows];

fn place<T: PartialEq>(of: &T, all: &[T]) -> u64 {
    all.iter().position(|one| one == of).unwrap_or_default() as u64
}

impl Order {
    /// The order as words; the first word is its kind.
    pub(super) fn words(&self) -> Vec<u64> {
        match self {
            Self::Begin(flow, motion, chain) => about([0, *flow], *motion, chain),
            Self::Load(flow) => vec![1, *flow],
            Self::Store(flow) => vec![2, *flow],
            Self::Drift(flow, dt) => vec![3, *flow, dt.hi.to_bits(), dt.lo.to_bits()],
            Self::Kicks(flow, pairs) => kicks(*flow, pairs),
            Self::Duplicate(from, to) => vec![5, *from, *to],
            Self::Copy(from, to) => vec![6, *from, *to],
            Self::Forget(flow) => vec![7, *flow],
            Self::Solve(flow, window) => [9, *flow].into_iter().chain(window.numbers().map(f64::to_bits)).collect(),
            Self::Advance(flow) => vec![10, *flow],
            Self::Tell(flow) => vec![11, *flow],
            Self::End => vec![8],
        }
    }

    /// The order that the words stand for; `None` if they are no order.
    pub(super) fn of(words: &[u64]) -> Option<Self> {
        Some(match *words {
            [0, flow, ref about @ ..] => chain(about).map(|(motion, chain)| Self::Begin(flow, motion, chain))?,
            [1, flow] => Self::Load(flow),
            [2, flow] => Self::Store(flow),
            [3, flow, hi, lo] => Self::Drift(flow, twofold(hi, lo)),
            [4, flow, ref pairs @ ..] if pairs.len().is_multiple_of(3) => {
                let pair = |words: &[u64]| (f64::from_bits(words[0]), twofold(words[1], words[2]));
                Self::Kicks(flow, pairs.chunks_exact(3).map(pair).collect())
            }
            [5, from, to] => Self::Duplicate(from, to),
            [6, from, to] => Self::Copy(from, to),
            [7, flow] => Self::Forget(flow),
            [9, flow, ref window @ ..] => {
                let window: &[u64; Window::NUMBERS] = window.try_into().ok()?;
                Self::Solve(flow, Window::of_numbers(&window.map(f64::from_bits)))
            }
            [10, flow] => Self::Advance(flow),
            [11, flow] => Self::Tell(flow),
            [8] => Self::End,
            _ => return None,
        })
    }
}

/// The words of [`Order::Begin`].
fn about(head: [u64; 2], motion: Motion, chain: &Chain<f64>) -> Vec<u64> {
    let Params { alpha, kappa, rho } = chain.params();
    let numbers = [alpha, kappa, rho, chain.precompression()].map(f64::to_bits);
    let chain = [place(&motion, &MOTIONS), place(&chain.boundary(), &Boundary::ALL), chain.sites() as u64];
    [&head[..], &chain, &numbers].concat()
}

/// The motion and the chain of that order.
fn chain(words: &[u64]) -> Option<(Motion, Box<Chain<f64>>)> {
    let &[motion, boundary, sites, alpha, kappa, rho, rest] = words else { return None };
    let [alpha, kappa, rho, rest] = [alpha, kappa, rho, rest].map(f64::from_bits);
    let boundary = *Boundary::ALL.get(boundary as usize)?;
    let chain = || Chain::new(Params::new(alpha, kappa, rho)?, boundary, sites as usize)?.precompressed(rest);
    Some((*MOTIONS.get(motion as usize)?, Box::new(chain().ok()?)))
}

/// Kicks and drifts as words.
fn kicks(flow: u64, pairs: &[(f64, DoubleDouble<f64>)]) -> Vec<u64> {
    let head = [4, flow].into_iter();
    head.chain(pairs.iter().flat_map(|(kick, drift)| [*kick, drift.hi, drift.lo].map(f64::to_bits))).collect()
}

fn twofold(hi: u64, lo: u64) -> DoubleDouble<f64> {
    DoubleDouble { hi: f64::from_bits(hi), lo: f64::from_bits(lo) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_order_arrives_as_it_was_given() {
        let third = DoubleDouble::new(1.0).over(DoubleDouble::new(3.0));
        let chain = Chain::new(Params::new(1.5, 1.0, f64::INFINITY).unwrap(), Boundary::Fixed, 9).unwrap();
        let chain = Box::new(chain.precompressed(0.1).unwrap());
        let orders = [
            Order::Begin(3, Motion::Kicks(Split::Linear), chain.clone()),
            Order::Begin(4, Motion::Windows, chain),
            Order::Load(1),
            Order::Store(2),
            Order::Drift(4, third),
            Order::Kicks(5, vec![(0.1, third), (-0.2, DoubleDouble::zero())]),
            Order::Kicks(5, Vec::new()),
            Order::Duplicate(6, 7),
            Order::Copy(8, 9),
            Order::Forget(10),
            Order::Solve(11, Window::of_numbers(&std::array::from_fn(|k| 1.0 / (k + 1) as f64))),
            Order::Solve(12, Window::of_numbers(&[f64::INFINITY; Window::NUMBERS])),
            Order::Advance(13),
            Order::Tell(14),
            Order::End,
        ];
        for order in orders {
            let back = Order::of(&order.words()).unwrap();
            assert_eq!(format!("{order:?}"), format!("{back:?}"));
        }
        assert!(Order::of(&[]).is_none() && Order::of(&[4, 0, 1]).is_none() && Order::of(&[99]).is_none());
    }
}
