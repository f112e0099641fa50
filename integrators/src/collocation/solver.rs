//! Solves all blocks of a section over one window, behind a trait that hides the number of nodes.

use super::{
    block::Workspace,
    derivative::{self, BondBlock},
    goal::Cuts,
    kernels::run,
    link::Links,
    panel::Frames,
    rule::Rule,
    window::{Left, OWN, Piece, Start, Window, WindowOutcome},
};
use crate::kernel;
use rayon::prelude::*;
use std::any::Any;

/// A solver of windows, with a number of nodes a panel and its memory.
pub(crate) trait Solver<const S: usize>: Send {
    /// Solves one window from `start` and writes the results for the own bonds into `left`.
    fn window(&mut self, start: &Start<S>, window: &Window, left: &mut [Left<S>]) -> WindowOutcome;
    /// Nodes a panel.
    fn nodes(&self) -> usize;
    /// What contacts did in the last window that was logged.
    fn pieces(&self) -> Box<dyn Iterator<Item = &Piece> + '_>;
    /// The tangent map of the last window that was solved, of length `h`, for a chain of one block:
    /// replaces changes of the linear paths of bonds by the changes of the paths by their forces.
    ///
    /// # Errors
    /// A bond and its residual if the sweeps do not converge.
    fn differentiate(
        &self,
        links: &Links<S>,
        h: f64,
        cuts: &Cuts,
        columns: &mut [BondBlock<S>],
    ) -> Result<(), (usize, f64)>;
}

/// A solver with `nodes` nodes a panel, one of [`NODES`](super::rule::NODES), on at most `threads`
/// threads.
///
/// # Panics
/// For `S` other than 1 and 2.
pub(crate) fn with_nodes<const S: usize>(nodes: usize, threads: usize) -> Box<dyn Solver<S>> {
    let solver: Box<dyn Any> = if S == 1 { Box::new(alike(nodes, threads)) } else { Box::new(apart(nodes, threads)) };
    *solver.downcast().expect("bonds see one kind of site, or two")
}

/// Solvers for chains whose sites are alike (`S = 1`), and for others (`S = 2`). Neither function
/// is generic, so that both are compiled with this package.
fn alike(nodes: usize, threads: usize) -> Box<dyn Solver<1>> {
    of_size(nodes, threads)
}

fn apart(nodes: usize, threads: usize) -> Box<dyn Solver<2>> {
    of_size(nodes, threads)
}

fn of_size<const S: usize>(nodes: usize, threads: usize) -> Box<dyn Solver<S>> {
    match nodes {
        ..=4 => Box::new(Nodes::<4, S>::new(threads)),
        5..=8 => Box::new(Nodes::<8, S>::new(threads)),
        _ => Box::new(Nodes::<12, S>::new(threads)),
    }
}

/// The solver with `M` nodes a panel.
struct Nodes<const M: usize, const S: usize> {
    rule: &'static Rule<M>,
    /// One for each thread.
    workspaces: Vec<Workspace<M, S>>,
}

impl<const M: usize, const S: usize> Nodes<M, S> {
    fn new(threads: usize) -> Self {
        Self { rule: Rule::shared(), workspaces: (0..threads).map(|_| Workspace::new()).collect() }
    }
}

impl<const M: usize, const S: usize> Solver<S> for Nodes<M, S> {
    fn window(&mut self, start: &Start<S>, window: &Window, left: &mut [Left<S>]) -> WindowOutcome {
        let Window { h, log, ref goal, .. } = *window;
        let (links, blocks) = (start.links, start.blocks);
        let frames = Frames { rule: self.rule, links, cuts: &goal.cuts, h };
        // Each thread takes consecutive blocks.
        let count = blocks.count();
        let each = count.div_ceil(self.workspaces.len()).max(1);
        let work = |(k, (workspace, left)): (usize, (&mut Workspace<M, S>, &mut [Left<S>]))| {
            workspace.pieces.clear();
            let mut rest = left;
            let mut outcome = WindowOutcome::default();
            for block in k * each..((k + 1) * each).min(count) {
                let own = blocks.own(block);
                let (mine, others) = rest.split_at_mut(own.len());
                outcome = outcome.and(workspace.solve(start, &frames, goal, own, mine, log));
                rest = others;
            }
            outcome
        };
        if self.workspaces.len() == 1 {
            return work((0, (&mut self.workspaces[0], left)));
        }
        let parts: Vec<_> = self.workspaces.iter_mut().zip(left.chunks_mut(each * OWN)).enumerate().collect();
        parts.into_par_iter().map(work).reduce(WindowOutcome::default, WindowOutcome::and)
    }

    fn nodes(&self) -> usize {
        M
    }

    fn pieces(&self) -> Box<dyn Iterator<Item = &Piece> + '_> {
        Box::new(self.workspaces.iter().flat_map(|workspace| &workspace.pieces))
    }

    fn differentiate(
        &self,
        links: &Links<S>,
        h: f64,
        cuts: &Cuts,
        columns: &mut [BondBlock<S>],
    ) -> Result<(), (usize, f64)> {
        let bonds = &self.workspaces[0].bonds[..links.bonds];
        let frames = &Frames { rule: self.rule, links, cuts, h };
        run(kernel!(derivative::window(frames, bonds, columns)))
    }
}
