//! All blocks of a chain over one window, with the number of nodes behind it.

use super::{
    block::{Left, Piece, Start, Verdict, Workspace, blocks, own, run},
    goal::Goal,
    layout::Cuts,
    panel::Frames,
    rule::Rule,
    system::Links,
    tangent,
};
use std::any::Any;

/// What solves windows.
pub(crate) trait Solver<const S: usize>: Send {
    /// Solves one window from `start` and writes what bonds leave behind.
    fn window(&mut self, start: &Start<S>, h: f64, goal: &Goal, left: &mut [Left<S>], log: bool) -> Verdict;
    /// Nodes a panel.
    fn nodes(&self) -> usize;
    /// Another one of its kind.
    fn another(&self, bonds: usize) -> Box<dyn Solver<S>>;
    /// What contacts did in the last window that was logged.
    fn pieces(&self) -> Box<dyn Iterator<Item = &Piece> + '_>;
    /// What changes of the linear paths of bonds leave behind in them, over the last window that
    /// was solved: of length `h`, of a chain of one block. Or bond and residual where that did not
    /// settle.
    fn differentiate(
        &self,
        links: &Links<S>,
        h: f64,
        cuts: &Cuts,
        columns: &mut [tangent::BondBlock<S>],
    ) -> Result<(), (usize, f64)>;
}

/// Numbers of nodes that a panel may have: all loops over nodes are compiled for each. More resolve
/// nothing that shorter windows do not resolve at less cost; `run --windows-per-period N --nodes M`
/// shows both sides.
pub(crate) const NODES: [usize; 5] = [4, 6, 8, 10, MOST_NODES];
pub(crate) const MOST_NODES: usize = 12;

/// A solver with so many nodes a panel, one of [`NODES`], for a chain with so many bonds.
///
/// # Panics
/// For `S` other than 1 and 2.
pub(crate) fn with_nodes<const S: usize>(nodes: usize, bonds: usize) -> Box<dyn Solver<S>> {
    let solver: Box<dyn Any> = if S == 1 { Box::new(alike(nodes, bonds)) } else { Box::new(apart(nodes, bonds)) };
    *solver.downcast().expect("bonds see one kind of site, or two")
}

/// Solvers for chains whose sites are alike, and for others. Neither function is generic, so that
/// both are compiled with this package.
fn alike(nodes: usize, bonds: usize) -> Box<dyn Solver<1>> {
    of_size(nodes, bonds)
}

fn apart(nodes: usize, bonds: usize) -> Box<dyn Solver<2>> {
    of_size(nodes, bonds)
}

fn of_size<const S: usize>(nodes: usize, bonds: usize) -> Box<dyn Solver<S>> {
    match nodes {
        ..=4 => Box::new(Nodes::<4, S>::new(bonds)),
        5..=6 => Box::new(Nodes::<6, S>::new(bonds)),
        7..=8 => Box::new(Nodes::<8, S>::new(bonds)),
        9..=10 => Box::new(Nodes::<10, S>::new(bonds)),
        _ => Box::new(Nodes::<12, S>::new(bonds)),
    }
}

struct Nodes<const M: usize, const S: usize> {
    rule: &'static Rule<M>,
    /// One for each thread.
    workspaces: Vec<Workspace<M, S>>,
}

impl<const M: usize, const S: usize> Nodes<M, S> {
    fn new(bonds: usize) -> Self {
        #[cfg(feature = "parallel")]
        let threads = rayon::current_num_threads();
        #[cfg(not(feature = "parallel"))]
        let threads = 1;
        let count = blocks(bonds).min(threads).max(1);
        Self { rule: Rule::shared(), workspaces: (0..count).map(|_| Workspace::new()).collect() }
    }
}

impl<const M: usize, const S: usize> Solver<S> for Nodes<M, S> {
    fn window(&mut self, start: &Start<S>, h: f64, goal: &Goal, left: &mut [Left<S>], log: bool) -> Verdict {
        let (links, bonds) = (start.links, start.links.bonds);
        let frames = Frames { rule: self.rule, links, cuts: &goal.cuts, h };
        if bonds == 0 {
            return Verdict::default();
        }
        // Each thread takes consecutive blocks.
        let count = blocks(bonds);
        let share = count.div_ceil(self.workspaces.len());
        let size = if count == 1 { bonds.max(1) } else { own(bonds, 0).len() * share };
        let work = |(k, (workspace, left)): (usize, (&mut Workspace<M, S>, &mut [Left<S>]))| {
            workspace.pieces.clear();
            let mut rest = left;
            let mut verdict = Verdict::default();
            for block in k * share..((k + 1) * share).min(count) {
                let own = own(bonds, block);
                let (mine, others) = rest.split_at_mut(own.len());
                verdict = verdict.and(workspace.solve(start, &frames, goal, own, mine, log));
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

    fn another(&self, bonds: usize) -> Box<dyn Solver<S>> {
        Box::new(Self::new(bonds))
    }

    fn pieces(&self) -> Box<dyn Iterator<Item = &Piece> + '_> {
        Box::new(self.workspaces.iter().flat_map(|workspace| &workspace.pieces))
    }

    fn differentiate(
        &self,
        links: &Links<S>,
        h: f64,
        cuts: &Cuts,
        columns: &mut [tangent::BondBlock<S>],
    ) -> Result<(), (usize, f64)> {
        let bonds = &self.workspaces[0].bonds[..links.bonds];
        let frames = &Frames { rule: self.rule, links, cuts, h };
        run::<S, _>(tangent::Window { frames, bonds, columns })
    }
}
