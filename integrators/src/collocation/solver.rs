//! All blocks of a chain over one window, with the number of nodes behind it.

use super::{
    block::{Left, Piece, Start, Verdict, Workspace, blocks, own},
    goal::Goal,
    layout::Cuts,
    panel::Frame,
    rule::Rule,
    system::Links,
    tangent,
};
use crate::{real::Real, regularised::power};

/// Order that the variable near an event is chosen for. Chosen;
/// `methods panels_cut_at_events_of_neighbours_restore_the_order` measures what it gives.
const ORDER: u32 = 8;

/// What solves windows.
pub(crate) trait Solver: Send {
    /// Solves one window from `start` and writes what bonds leave behind.
    fn window(&mut self, start: &Start, h: f64, goal: &Goal, left: &mut [Left], log: bool) -> Verdict;
    /// Nodes a panel.
    fn nodes(&self) -> usize;
    /// Another one of its kind.
    fn another(&self, bonds: usize) -> Box<dyn Solver>;
    /// What contacts did in the last window that was logged.
    fn pieces(&self) -> Box<dyn Iterator<Item = &Piece> + '_>;
    /// What changes of the linear paths of bonds leave behind in them, over the last window that
    /// was solved: of length `h`, of a chain of one block. Or bond and residual where that did not
    /// settle.
    fn differentiate(
        &self,
        links: &Links,
        h: f64,
        cuts: Cuts,
        columns: &mut [tangent::Block],
    ) -> Result<(), (usize, f64)>;
}

/// Numbers of nodes that a panel may have: all loops over nodes are compiled for each. More resolve
/// nothing that shorter windows do not resolve at less cost; `run --windows-per-period N --nodes M`
/// shows both sides.
pub(crate) const NODES: [usize; 5] = [4, 6, 8, 10, MOST_NODES];
pub(crate) const MOST_NODES: usize = 12;

/// A solver with so many nodes a panel, one of [`NODES`], for a chain with so many bonds.
pub(crate) fn with_nodes(nodes: usize, bonds: usize) -> Box<dyn Solver> {
    match nodes {
        ..=4 => Box::new(Nodes::<4>::new(bonds)),
        5..=6 => Box::new(Nodes::<6>::new(bonds)),
        7..=8 => Box::new(Nodes::<8>::new(bonds)),
        9..=10 => Box::new(Nodes::<10>::new(bonds)),
        _ => Box::new(Nodes::<12>::new(bonds)),
    }
}

struct Nodes<const M: usize> {
    rule: &'static Rule<M>,
    /// One for each thread.
    workspaces: Vec<Workspace<M>>,
}

impl<const M: usize> Nodes<M> {
    fn new(bonds: usize) -> Self {
        #[cfg(feature = "parallel")]
        let threads = rayon::current_num_threads();
        #[cfg(not(feature = "parallel"))]
        let threads = 1;
        let count = blocks(bonds).min(threads).max(1);
        Self { rule: Rule::shared(), workspaces: (0..count).map(|_| Workspace::new()).collect() }
    }
}

fn frame<'a, const M: usize>(rule: &'a Rule<M>, links: &'a Links, cuts: Cuts, h: f64) -> Frame<'a, M> {
    let response = links.response;
    let omega = if response.mu == 0.0 { 0.0 } else { response.omega.value() };
    let per_omega = if omega == 0.0 { 0.0 } else { 1.0 / omega };
    let (law, q) = (&links.law, power(links.law.alpha(), ORDER));
    Frame {
        rule,
        law,
        cuts,
        h,
        m: response.m,
        mu: response.mu,
        omega,
        per_omega,
        mu_per_omega: response.mu * per_omega,
        q,
    }
}

impl<const M: usize> Solver for Nodes<M> {
    fn window(&mut self, start: &Start, h: f64, goal: &Goal, left: &mut [Left], log: bool) -> Verdict {
        let (frame, bonds) = (frame(self.rule, start.links, goal.cuts, h), start.links.bonds);
        if bonds == 0 {
            return Verdict::default();
        }
        // Each thread takes consecutive blocks.
        let count = blocks(bonds);
        let share = count.div_ceil(self.workspaces.len());
        let size = if count == 1 { bonds.max(1) } else { own(bonds, 0).len() * share };
        let work = |(k, (workspace, left)): (usize, (&mut Workspace<M>, &mut [Left]))| {
            workspace.pieces.clear();
            let mut rest = left;
            let mut verdict = Verdict::default();
            for block in k * share..((k + 1) * share).min(count) {
                let own = own(bonds, block);
                let (mine, others) = rest.split_at_mut(own.len());
                verdict = verdict.and(workspace.solve(start, &frame, goal, own, mine, log));
                rest = others;
            }
            verdict
        };
        if self.workspaces.len() == 1 {
            return work((0, (&mut self.workspaces[0], left)));
        }
        let parts = self.workspaces.iter_mut().zip(left.chunks_mut(size)).enumerate();
        #[cfg(feature = "parallel")]
        {
            use rayon::prelude::*;
            let parts: Vec<_> = parts.collect();
            parts.into_par_iter().map(work).reduce(Verdict::default, Verdict::and)
        }
        #[cfg(not(feature = "parallel"))]
        parts.map(work).fold(Verdict::default(), Verdict::and)
    }

    fn nodes(&self) -> usize {
        M
    }

    fn another(&self, bonds: usize) -> Box<dyn Solver> {
        Box::new(Self::new(bonds))
    }

    fn pieces(&self) -> Box<dyn Iterator<Item = &Piece> + '_> {
        Box::new(self.workspaces.iter().flat_map(|workspace| &workspace.pieces))
    }

    fn differentiate(
        &self,
        links: &Links,
        h: f64,
        cuts: Cuts,
        columns: &mut [tangent::Block],
    ) -> Result<(), (usize, f64)> {
        let bonds = &self.workspaces[0].bonds[..links.bonds];
        let frame = &frame(self.rule, links, cuts, h);
        f64::run(tangent::Window { links, frame, bonds, columns })
    }
}
