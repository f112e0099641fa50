//! The tangent map: the derivative of the state after a window by the state before it.
//!
//! | symbol | meaning |
//! |---|---|
//! | `dg, df` | changes of overlaps and forces at the nodes of a window |
//! | `D` | `f'(g)` at the nodes, a diagonal |
//! | `T` | influences: the overlaps at the nodes by forces at the nodes, `int K(t - s) f(s) ds` |
//! | `dg_lin` | change of the overlaps along the linear paths |
//! | `G` | `(I - D T_pp)^{-1}` of one panel `p`: its response to the forces of other panels |
//!
//! A window solves `g = g_lin + T f(g)`, so `df = D (dg_lin + T df)`: a linear system with a block
//! for each pair of panels. The action of a panel on itself is solved once a window, so that a
//! sweep is `df_p = G_p D_p (dg_lin + sum_q T_pq df_q)` over the other panels `q`.
//!
//! The ends of contacts move too; since the force is zero there, this has no effect to first order.
//! An end of a panel that is not where the contact begins or ends does have an effect: an error `t`
//! of its time is an error `t^{alpha+1}` of the impulse, and `t^alpha` of its derivative. So the
//! nodes are laid out anew, from ends that are improved by one more step of Newton's method.
//!
//! Damping is in the paths and influences, see `flow.rs`. Drives do not depend on the state: they
//! are in `g` and not in `dg_lin`, and a site that is moved has no change of its own.

use super::{
    chain::{ContactChain, Path},
    derivative::{BondBlock, LANES, Lanes},
    flow::Flow,
    open::Open,
    section::Section,
    series::product,
    sites::Phases,
    stepper::Collocation,
    window::OWN,
};
use crate::{drive::Stepper, error::Error};

/// `[R0, V, C, S]` of every site, for some columns.
type Block = Vec<[Lanes; 4]>;

fn argument(name: &'static str, value: usize, rule: &'static str) -> Error {
    Error::Argument { name, value: value as f64, rule }
}

/// Columns `w` that move with a run: `w(t) = (d y(t)/d y(t_0)) w(t_0)`, the linearised flow along
/// the trajectory of the run. The entries of sites that are moved, and of a ledger, are zero.
///
/// ```text
/// let mut run = Collocation::new(chain, y0, span, step_control)?;
/// let mut tangent = Tangent::identity(&run)?;
/// while !run.done() {
///     run.step()?;
///     tangent.follow(&run)?;
/// }
/// let monodromy = tangent.matrix(&run)?;
/// ```
///
/// No difference quotients are used: what the nodes of a window resolve is exact to rounding.
/// Forces are smoother than their derivative, so columns need shorter windows than the state does.
/// With [`StepControl::Tolerance`](super::StepControl) expect some ten times the tolerance.
#[derive(Clone, Debug)]
pub struct Tangent<const S: usize = 1> {
    blocks: Vec<Block>,
    columns: usize,
    dim: usize,
    phases: Phases<S>,
    /// Number of windows of the run at the time of the columns.
    windows: u64,
}

impl<const S: usize> Tangent<S> {
    /// The columns of the unit matrix at the present state of a run.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn identity<C: ContactChain<S>>(run: &Collocation<C, S>) -> Result<Self, Error> {
        let dim = run.dim();
        let mut columns = vec![0.0; dim * dim];
        columns.iter_mut().step_by(dim + 1).for_each(|entry| *entry = 1.0);
        Self::new(run, &columns)
    }

    /// Columns, one after the other and each like a state, at the present state of a run.
    ///
    /// # Errors
    /// Not a whole number of columns, an entry that is not finite, or a chain of more than 256
    /// bonds or with contacts that dissipate.
    pub fn new<C: ContactChain<S>>(run: &Collocation<C, S>, columns: &[f64]) -> Result<Self, Error> {
        let (chain, dim) = (&run.section.held.chain, run.dim());
        if chain.bonds() > OWN {
            return Err(argument("bonds", chain.bonds(), "a tangent map is there for at most 256 bonds"));
        }
        if run.section.held.links.lossy() {
            return Err(argument(
                "bonds",
                chain.bonds(),
                "the tangent map of contacts that dissipate is of `Variations`",
            ));
        }
        if !columns.len().is_multiple_of(dim) {
            return Err(argument("columns", columns.len(), "as many entries as whole columns have"));
        }
        if let Some(&value) = columns.iter().find(|value| !value.is_finite()) {
            return Err(Error::Argument { name: "columns", value, rule: "the entries of a column are finite" });
        }
        let mut phases = run.section.state.phases.clone();
        phases.advance(run.h);
        let (count, windows) = (columns.len() / dim, run.stats.steps);
        let mut blocks = vec![vec![[[0.0; LANES]; 4]; chain.sites()]; count.div_ceil(LANES)];
        for (c, column) in columns.chunks_exact(dim).enumerate() {
            for (i, site) in blocks[c / LANES].iter_mut().enumerate() {
                let ([r, v, p, s], (sin, cos)) = (chain.path(column, i), phases.sin_cos(i));
                set(site, c % LANES, [r, v, p * cos - s * sin, p * sin + s * cos]);
            }
        }
        Ok(Self { blocks, columns: count, dim, phases, windows })
    }

    /// Moves the columns over the window that the run has just done.
    ///
    /// # Errors
    /// Not the window after the last one that was followed. Sweeps that do not settle (windows far
    /// too long): the columns are then of no use.
    pub fn follow<C: ContactChain<S>>(&mut self, run: &Collocation<C, S>) -> Result<(), Error> {
        self.check(run)?;
        let (done, h) = (run.stats.steps, run.h);
        if done != self.windows + 1 || h <= 0.0 {
            return Err(argument("window", done as usize, "every window of a run is followed once, when it is done"));
        }
        let (cuts, phases) = (run.control.goal(h).cuts, &run.section.state.phases);
        let chain = &run.section.held.chain;
        let across = |block: &Block| {
            let of = |b| across(chain, b, block, phases);
            (0..chain.bonds()).map(of).collect()
        };
        let mut bonds: Vec<BondBlock<S>> = self.blocks.iter().map(across).collect();
        let Section { held, solver, .. } = &run.section;
        let solver = solver.as_ref().expect("a window was solved");
        let result = solver.differentiate(&held.links, h, &cuts, &mut bonds);
        result.map_err(|(bond, residual)| Error::NoContraction { t: run.t.value(), h, bond, residual })?;
        let flows = flows(held.links.open.as_ref(), chain.sites(), h);
        for (block, left) in self.blocks.iter_mut().zip(&bonds) {
            advance((chain, &flows), left, block, h, phases);
        }
        self.phases.copy_from(phases);
        self.phases.advance(h);
        self.windows = done;
        Ok(())
    }

    /// The columns, one after the other and each like a state, where the last window that was
    /// followed ends.
    ///
    /// # Errors
    /// A run of another chain.
    pub fn matrix<C: ContactChain<S>>(&self, run: &Collocation<C, S>) -> Result<Vec<f64>, Error> {
        self.check(run)?;
        let chain = &run.section.held.chain;
        let mut columns = vec![0.0; self.columns * self.dim];
        for (c, column) in columns.chunks_exact_mut(self.dim).enumerate() {
            for (i, site) in self.blocks[c / LANES].iter().enumerate() {
                let [r, v, c, s] = turned(get(site, c % LANES), self.phases.sin_cos(i));
                chain.place([r, v, c, chain.response(i).omega.value() * s], i, column);
            }
        }
        Ok(columns)
    }

    fn check<C: ContactChain<S>>(&self, run: &Collocation<C, S>) -> Result<(), Error> {
        if run.dim() == self.dim && self.blocks.iter().all(|block| block.len() == run.section.held.chain.sites()) {
            return Ok(());
        }
        Err(argument("dim", run.dim(), "columns follow the run that they were made for"))
    }
}

/// `d y(t_1)/d y(t_0)` along the trajectory from `y0` over `span = (t_0, t_1)`: column by column,
/// `dim^2` entries.
///
/// # Errors
/// As those of [`Collocation::new`], its steps, and [`Tangent`].
pub fn monodromy<C: ContactChain<S>, const S: usize>(
    chain: C,
    y0: &[f64],
    span: (f64, f64),
    step_control: super::StepControl,
) -> Result<Vec<f64>, Error> {
    let mut run = Collocation::new(chain, y0, span, step_control)?;
    let mut tangent = Tangent::identity(&run)?;
    while !run.done() {
        run.step()?;
        tangent.follow(&run)?;
    }
    tangent.matrix(&run)
}

#[inline(always)]
fn get(site: &[Lanes; 4], lane: usize) -> Path {
    [site[0][lane], site[1][lane], site[2][lane], site[3][lane]]
}

#[inline(always)]
fn set(site: &mut [Lanes; 4], lane: usize, path: Path) {
    for k in 0..4 {
        site[k][lane] = path[k];
    }
}

/// The path over a window that starts in phase `(sin, cos)`.
#[inline(always)]
fn turned([r, v, c, s]: Path, (sin, cos): (f64, f64)) -> Path {
    [r, v, c * cos + s * sin, s * cos - c * sin]
}

/// The changes of the linear path of a bond by the changes of its sites; `phases` are those at the
/// start of the window.
#[inline(always)]
fn across<const S: usize, C: ContactChain<S>>(
    chain: &C,
    bond: usize,
    block: &Block,
    phases: &Phases<S>,
) -> [[Lanes; 4]; S] {
    let (mut paths, ends) = ([[[0.0; LANES]; 4]; S], chain.ends(bond));
    for lane in 0..LANES {
        let own = chain.across(bond, |i| get(&block[i], lane));
        for side in 0..S {
            let turn = ends[side].map_or((0.0, 1.0), |site| phases.sin_cos(site));
            set(&mut paths[side], lane, turned(own[side], turn));
        }
    }
    paths
}

/// `exp(A h)` of each damped site, by columns.
fn flows(open: Option<&Open>, sites: usize, h: f64) -> Vec<Option<[Path; 4]>> {
    let column = |flow: &Flow, k: usize| {
        let unit = std::array::from_fn(|i| f64::from(u8::from(i == k)));
        let moved = flow.moved(&unit, h);
        std::array::from_fn(|i| unit[i] + moved[i])
    };
    let of = |i: usize| {
        let flow = open?.damped(i)?;
        Some(std::array::from_fn(|k| column(flow, k)))
    };
    (0..sites).map(of).collect()
}

/// Moves the changes of sites over a window: the derivative of `Section::advance`.
#[inline(always)]
fn advance<const S: usize, C: ContactChain<S>>(
    (chain, flows): (&C, &[Option<[Path; 4]>]),
    left: &BondBlock<S>,
    block: &mut Block,
    h: f64,
    phases: &Phases<S>,
) {
    for ((i, site), flow) in block.iter_mut().enumerate().zip(flows) {
        let (sin, cos) = phases.sin_cos(i);
        for lane in 0..LANES {
            let by = chain.push(i, |b| left[b].each_ref().map(|left| get(left, lane)));
            let [r, v, c, s] = get(site, lane);
            if let Some(columns) = flow {
                let y = [r + by[0], v + by[1], c + by[2], s + by[3]];
                set(site, lane, product(columns, &y));
                continue;
            }
            let v = v + by[1];
            let (c, s) = (c + (by[2] * cos - by[3] * sin), s + (by[2] * sin + by[3] * cos));
            set(site, lane, [(r + by[0]) + v * h, v, c, s]);
        }
    }
}
