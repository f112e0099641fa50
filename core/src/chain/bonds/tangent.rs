//! The tangent map of contact-corrected splitting: columns of derivatives that are moved along with
//! the state.
//!
//! | symbol | meaning |
//! |---|---|
//! | `w` | a column: derivatives of `R0, V, C, S` of every site by one number |
//! | `dq, dg, df` | derivatives of positions, overlaps and forces by the same number; `df = f' dg` |
//! | `dF` | derivatives of modified forces |
//!
//! The drift does not change `R0, V, C, S`, so columns do not change between kicks either. A kick
//! adds the same multiples of force to them as to the state, with
//!
//! ```text
//! dF_b = (1 + c s_b f''/f') df_b + c f'_b (df_{b-1} - 2 df_b + df_{b+1})
//! ```
//!
//! in place of `F`. `dF` of an open bond is zero, and sites without a closed bond are left out.
//!
//! A correction is a function of six numbers of its bond: overlap, rate, the oscillating part of
//! the position and of the velocity, and the pulls at both kicks. Its derivatives by these are
//! central differences of the closed formula, good to 1e-9 of a derivative that is itself of order
//! `h^alpha`.
//!
//! One part is written out in closed form. Where an event meets a kick, the factor `f''` of the
//! modified force's derivative has a pole, and the correction of the two kicks around the event
//! cancels it. The sum of both, with `e = c s`, is the derivative of the force of the processed
//! path, `f'(g + e) (dg + de)`, which has no pole.
//!
//! The processor's midpoint step is differentiated as it is computed. So columns are the derivative
//! of the run as computed, to 1e-9; the tests compare them with differences of runs.

use super::{
    super::{Chain, LinearFlow, aligned::Aligned, law::LANES, topology::Topology},
    CorrectedSplit, PAD, SiteFlow,
};
use hertzchain_integrators::{
    DoubleDouble, Kernel, Real, SplitFlow, Vector,
    splitting::corrected::{BondFlow, BondPath, BondView, Correction, Dependence, Side},
};

/// Count of the numbers of a bond that a correction depends on.
const NUMBERS: usize = 6;

/// The linear split with the kicks of contact-corrected splitting, and derivatives of its state.
///
/// ```
/// use hertzchain_core::{
///     chain::{Boundary, Chain, Params, TangentFlow},
///     integrators::{Stepper, splitting::{Corrected, Parts}},
/// };
///
/// // Two beads that fly at each other: how the end depends on the first one's position.
/// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Free, 2)?;
/// let end = |shift: f64, steps| {
///     let flow = TangentFlow::new(chain.clone(), &[-0.5 + shift, 0.0, 1.0, 0.0], &[1.0, 0.0, 0.0, 0.0]);
///     let mut run = Corrected::new(flow, (0.0, 3.0), steps, Parts::ALL)?;
///     while !run.done() {
///         run.step()?;
///     }
///     let mut y = [0.0; 4];
///     run.sample(3.0, &mut y);
///     Ok::<_, hertzchain_core::Error>((y, run.solution().columns()))
/// };
/// let difference = (end(1e-5, 400)?.0[0] - end(-1e-5, 400)?.0[0]) / 2e-5;
/// assert!((end(0.0, 400)?.1[0] - difference).abs() < 1e-8);
/// # Ok::<(), hertzchain_core::Error>(())
/// ```
pub struct TangentFlow {
    state: CorrectedSplit<LinearFlow<f64>>,
    columns: Columns,
    /// For each correction that [`depends`](BondFlow::depends) was told of: the rows that it adds
    /// to `R0, V, C, S` of a bead. Entries are used again.
    pending: Vec<[Vec<f64>; 4]>,
    /// How many entries of `pending` are filled, and how many of these
    /// [`correct`](BondFlow::correct) has applied.
    told: usize,
    given: usize,
}

/// Derivatives of sites or bonds: a row for each, with one number for each column.
struct Rows {
    width: usize,
    numbers: Aligned<f64>,
}

impl Rows {
    fn zeros(rows: usize, width: usize) -> Self {
        Self { width, numbers: Aligned::zeros(rows * width) }
    }

    /// Whether there are any.
    #[inline(always)]
    fn any(&self) -> bool {
        !self.numbers.is_empty()
    }

    #[inline(always)]
    fn at(&self, row: usize) -> &[f64] {
        &self.numbers[row * self.width..][..self.width]
    }

    #[inline(always)]
    fn at_mut(&mut self, row: usize) -> &mut [f64] {
        let width = self.width;
        &mut self.numbers[row * width..][..width]
    }
}

/// The columns that go with a state, stored row by row.
struct Columns {
    /// Number of columns; rows are padded to whole registers.
    count: usize,
    topology: Topology,
    /// `dR0, dV, dC, dS` of sites; no rows where the model lacks the motion.
    modes: [Rows; 4],
    /// `df` of bonds at the last survey and the one before, and which of these rows can be other
    /// than zero.
    forces: [Rows; 2],
    closed: [Vec<bool>; 2],
    /// Bonds that have changed their side in this step.
    fresh: Vec<usize>,
    /// Positions of sites, and `dF` of bonds.
    positions: Rows,
    modified: Rows,
    /// Whether the row of positions of a site is up to date.
    placed: Vec<bool>,
}

impl TangentFlow {
    /// The chain in the state `y`, with columns of derivatives of that state: each as long as it.
    ///
    /// # Panics
    /// If the length of `columns` is no multiple of that of `y`, or `y` is not a state of the
    /// chain.
    pub fn new(chain: Chain<f64>, y: &[f64], columns: &[f64]) -> Self {
        let dim = y.len();
        assert_eq!(columns.len() % dim, 0, "columns have as many entries as the state");
        let mut new = Self::zeros(LinearFlow::new(chain.clone()), columns.len() / dim);
        new.state.load(y);
        // The modes of a state are linear in it, and so are those of a column.
        let mut modes = LinearFlow::new(chain);
        for (k, column) in columns.chunks(dim).enumerate() {
            modes.load(column);
            let ([r0, v], [c, s]) = (&modes.centre, &modes.oscillation);
            for (rows, numbers) in new.columns.modes.iter_mut().zip([r0, v, c, s]) {
                for (i, &number) in numbers.iter().enumerate() {
                    rows.at_mut(i)[k] = number;
                }
            }
        }
        new
    }

    fn zeros(flow: LinearFlow<f64>, count: usize) -> Self {
        let (n, width) = (flow.chain.sites(), count.next_multiple_of(LANES));
        let rows = |rows: usize| Rows::zeros(rows, width);
        let [centre, oscillation] = [&flow.centre, &flow.oscillation].map(|modes| modes[0].len());
        let topology = flow.chain.topology();
        let columns = Columns {
            count,
            topology,
            modes: [rows(centre), rows(centre), rows(oscillation), rows(oscillation)],
            forces: [rows(n + 1), rows(n + 1)],
            closed: [vec![false; n + 1], vec![false; n + 1]],
            fresh: Vec::new(),
            positions: rows(n),
            modified: rows(n + 1),
            placed: vec![false; n],
        };
        Self { state: CorrectedSplit::new(flow), columns, pending: Vec::new(), told: 0, given: 0 }
    }

    /// The derivatives of the state, column by column.
    pub fn columns(&self) -> Vec<f64> {
        let (columns, flow) = (&self.columns, &self.state.flow);
        let (n, dim, omega) = (flow.chain.sites(), flow.dim(), flow.omega());
        let ((sin, cos), half) = (flow.phase.sin_cos(), dim / 2);
        let mut out = vec![0.0; dim * columns.count];
        for (k, column) in out.chunks_mut(dim).enumerate() {
            for i in 0..n {
                let [r0, v, c, s] = columns.modes.each_ref().map(|rows| if rows.any() { rows.at(i)[k] } else { 0.0 });
                let (r, p, p_dot) = (r0 + v * flow.tau, c * cos + s * sin, omega * (s * cos - c * sin));
                (column[i], column[half + i]) = (r + p, v + p_dot);
                if flow.chain.layout().resonators() {
                    let rho = flow.chain.params().rho;
                    (column[n + i], column[half + n + i]) = (r - p / rho, v - p_dot / rho);
                }
            }
        }
        out
    }

    fn survey_columns(&mut self) {
        let Self { state, columns, .. } = self;
        f64::run(Survey { columns, state });
    }

    /// Derivatives of accelerations and of their rates, for the processor.
    fn jet_columns(&mut self, sides: &[Side]) -> [Rows; 2] {
        let first = self.state.chain().touching().start;
        let without = |b: usize| b < first || sides.get(b - first).is_none_or(|side| *side == Side::Near);
        self.columns.jet(&self.state, without)
    }
}

/// A survey of columns.
struct Survey<'a> {
    columns: &'a mut Columns,
    state: &'a CorrectedSplit<LinearFlow<f64>>,
}

impl Kernel for Survey<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.columns.survey(self.state);
    }
}

/// A kick of columns.
struct Kick<'a> {
    columns: &'a mut Columns,
    state: &'a CorrectedSplit<LinearFlow<f64>>,
    kick: f64,
    c: f64,
}

impl Kernel for Kick<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.columns.kick(self.state, self.kick, self.c);
    }
}

/// `to += by * from`.
#[inline(always)]
fn add(by: f64, from: &[f64], to: &mut [f64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to += by * from;
    }
}

/// `to = here * own + there * (left + right)`, where neighbours that are `None` count as zero.
#[inline(always)]
fn combine([here, there]: [f64; 2], own: &[f64], beside: [Option<&[f64]>; 2], to: &mut [f64]) {
    match beside {
        [Some(left), Some(right)] => {
            for (to, ((own, left), right)) in to.iter_mut().zip(own.iter().zip(left).zip(right)) {
                *to = here * own + there * (left + right);
            }
        }
        [Some(one), None] | [None, Some(one)] => {
            for (to, (own, one)) in to.iter_mut().zip(own.iter().zip(one)) {
                *to = here * own + there * one;
            }
        }
        [None, None] => {
            for (to, own) in to.iter_mut().zip(own) {
                *to = here * own;
            }
        }
    }
}

/// `f''/f' = (alpha - 1)/g` at the overlap `g` of a bond.
#[inline(always)]
fn bend(state: &CorrectedSplit<LinearFlow<f64>>, b: usize) -> f64 {
    (state.chain().law().alpha() - 1.0) / state.overlap[b].max(f64::MIN_POSITIVE)
}

/// `f'` at an overlap.
fn slope(state: &CorrectedSplit<LinearFlow<f64>>, g: f64) -> f64 {
    state.chain().law().force_with_slope(g).1
}

/// The factors of `R0, V, C, S` in a position, which is the sum of the four products.
#[inline(always)]
fn position(flow: &LinearFlow<f64>) -> [f64; 4] {
    let (sin, cos) = flow.phase.sin_cos();
    [1.0, flow.tau, cos, sin]
}

/// The factors of `R0, V, C, S` in a velocity.
fn velocity(flow: &LinearFlow<f64>) -> [f64; 4] {
    let ((sin, cos), omega) = (flow.phase.sin_cos(), flow.omega());
    [0.0, 1.0, -omega * sin, omega * cos]
}

/// The factors of `R0, V, C, S` in a position a time `h` ago, if no kick came after it.
fn position_before(flow: &LinearFlow<f64>, h: f64) -> [f64; 4] {
    let (sin, cos) = flow.phase.sin_cos_before(DoubleDouble::new(h));
    [1.0, flow.tau - h, cos, sin]
}

impl Columns {
    #[inline(always)]
    fn survey(&mut self, state: &CorrectedSplit<LinearFlow<f64>>) {
        self.forces.swap(0, 1);
        self.closed.swap(0, 1);
        self.fresh.clear();
        self.placed.fill(false);
        for b in self.topology.touching() {
            let closed = state.overlap[b] > 0.0;
            if !closed && self.closed[0][b] {
                self.forces[0].at_mut(b).fill(0.0);
            }
            self.closed[0][b] = closed;
            if closed {
                for i in self.topology.ends(b).into_iter().flatten() {
                    if !self.placed[i] {
                        self.placed[i] = true;
                        self.place(&state.flow, i);
                    }
                }
                self.force(state, b);
            }
        }
    }

    /// Computes the row of positions of a site.
    #[inline(always)]
    fn place(&mut self, flow: &LinearFlow<f64>, i: usize) {
        let [_, tau, cos, sin] = position(flow);
        let q = self.positions.at_mut(i);
        let [r0, v, c, s] = &self.modes;
        match (r0.any(), c.any()) {
            (true, true) => {
                let rows = r0.at(i).iter().zip(v.at(i)).zip(c.at(i).iter().zip(s.at(i)));
                for (q, ((r0, v), (c, s))) in q.iter_mut().zip(rows) {
                    *q = (r0 + v * tau) + (c * cos + s * sin);
                }
            }
            (true, false) => {
                for (q, (r0, v)) in q.iter_mut().zip(r0.at(i).iter().zip(v.at(i))) {
                    *q = r0 + v * tau;
                }
            }
            _ => {
                for (q, (c, s)) in q.iter_mut().zip(c.at(i).iter().zip(s.at(i))) {
                    *q = c * cos + s * sin;
                }
            }
        }
    }

    /// Computes the row of forces of a bond, whose sites have rows of positions.
    #[inline(always)]
    fn force(&mut self, state: &CorrectedSplit<LinearFlow<f64>>, b: usize) {
        let slope = state.slope[PAD + b];
        let to = self.forces[0].at_mut(b);
        match self.topology.ends(b) {
            [Some(left), Some(right)] => {
                let (left, right) = (self.positions.at(left), self.positions.at(right));
                for (to, (left, right)) in to.iter_mut().zip(left.iter().zip(right)) {
                    *to = slope * (left - right);
                }
            }
            [left, right] => {
                to.fill(0.0);
                left.iter().for_each(|&i| add(slope, self.positions.at(i), to));
                right.iter().for_each(|&i| add(-slope, self.positions.at(i), to));
            }
        }
    }

    /// Computes the rows of forces of a bond and its neighbours again, after a correction has moved
    /// the sites of the bond.
    fn refresh(&mut self, state: &CorrectedSplit<LinearFlow<f64>>, b: usize) {
        let [before, after] = self.topology.beside(b);
        for b in [before, Some(b), after].into_iter().flatten() {
            self.closed[0][b] = state.overlap[b] > 0.0;
            self.topology.ends(b).into_iter().flatten().for_each(|i| self.place(&state.flow, i));
            self.force(state, b);
        }
    }

    /// `R0 <- R0 + V tau`.
    fn anchor(&mut self, tau: f64) {
        let [r0, v, ..] = &mut self.modes;
        add(tau, &v.numbers, &mut r0.numbers);
    }

    #[inline(always)]
    fn kick(&mut self, state: &CorrectedSplit<LinearFlow<f64>>, kick: f64, c: f64) {
        let (topology, flow, f) = (self.topology, &state.flow, &state.force[PAD - 1..]);
        for b in topology.touching() {
            if !self.closed[0][b] {
                self.modified.at_mut(b).fill(0.0);
                continue;
            }
            let pull = (f[b] - f[b + 1]) - (f[b + 1] - f[b + 2]);
            self.modify(state, b, pull, c);
        }
        for k in 0..self.fresh.len() {
            self.kick_fresh(state, self.fresh[k], c);
        }
        let (kick_v, per_omega, (sin, cos)) = (kick * flow.m(), kick * flow.mu_over_omega, flow.phase.sin_cos());
        let by = [[-(kick_v * flow.tau), kick_v], [-(per_omega * sin), per_omega * cos]];
        for i in 0..topology.sites() {
            let [before, after] = topology.bonds(i).map(|b| b.filter(|&b| self.closed[0][b]));
            let rows = |b: Option<usize>| b.map(|b| self.modified.at(b));
            let push = self.positions.at_mut(i);
            if topology.strains() {
                // The push on a strain is twice the force of its own bond less those of the bonds
                // beside.
                let beside = topology.beside(i).map(|b| b.filter(|&b| self.closed[0][b]));
                if !self.closed[0][i] && beside == [None; 2] {
                    continue;
                }
                combine([2.0, -1.0], self.modified.at(i), beside.map(rows), push);
            } else if let Some(own) = rows(before) {
                combine([1.0, -1.0], own, [rows(after), None], push);
            } else if let Some(own) = rows(after) {
                combine([-1.0, 0.0], own, [None; 2], push);
            } else {
                continue;
            }
            let [r0, v, c, s] = &mut self.modes;
            for ([x, y], [by_x, by_y]) in [([r0, v], by[0]), ([c, s], by[1])] {
                if x.any() {
                    let rows = x.at_mut(i).iter_mut().zip(y.at_mut(i)).zip(&*push);
                    for ((x, y), push) in rows {
                        *x += by_x * push;
                        *y += by_y * push;
                    }
                }
            }
        }
    }

    /// Adds the derivative of what the correction of an event gives for the kick before the event:
    /// an impulse at that kick, whose derivative is
    /// `h (f'(g + e) - f'(g)) (dg + de) - h f''(g) e dg`.
    fn kick_before(&mut self, state: &CorrectedSplit<LinearFlow<f64>>, b: usize, h: f64, to: &mut [Vec<f64>; 4]) {
        let (flow, share) = (&state.flow, h * h / 12.0);
        let (g, e) = (state.overlaps_before[0][b], share * state.pull(b, &state.force_before, &[]));
        let (here, there) = (slope(state, g), slope(state, g + e));
        if here == 0.0 && there == 0.0 {
            return;
        }
        let bend = if g > 0.0 { (state.chain().law().alpha() - 1.0) * here / g.max(f64::MIN_POSITIVE) } else { 0.0 };
        let at = position_before(flow, h);
        let lack = self.modified.at_mut(b);
        lack.fill(0.0);
        for (site, sign) in self.topology.ends(b).into_iter().zip([1.0, -1.0]) {
            let Some(site) = site else { continue };
            for (rows, by) in self.modes.iter().zip(at).filter(|(rows, _)| rows.any()) {
                add(sign * by * h * (there - here - bend * e), rows.at(site), lack);
            }
        }
        for side in self.topology.beside(b).into_iter().flatten() {
            add(h * share * (there - here), self.forces[1].at(side), lack);
        }
        let [_, tau, cos, sin] = at;
        let by = [-(flow.m() * tau), flow.m(), -(flow.mu_over_omega * sin), flow.mu_over_omega * cos];
        to.iter_mut().zip(by).for_each(|(to, by)| add(by, lack, to));
    }

    /// Computes the row `dF` of a bond; `pull` is the acceleration `s` of its overlap.
    #[inline(always)]
    fn modify(&mut self, state: &CorrectedSplit<LinearFlow<f64>>, b: usize, pull: f64, c: f64) {
        let there = c * state.slope[PAD + b];
        let here = 1.0 + c * pull * bend(state, b) - self.topology.recoil(b) * there;
        let forces = &self.forces[0];
        let beside = self.topology.beside(b).map(|b| b.map(|b| forces.at(b)));
        combine([here, there], forces.at(b), beside, self.modified.at_mut(b));
    }

    /// Computes the row `dF` of a bond whose correction has replaced the force of the kick by that
    /// of the processed path: `f'(g + e) (dg + de)`, and the share of the modified force that comes
    /// from the bond's own force.
    fn kick_fresh(&mut self, state: &CorrectedSplit<LinearFlow<f64>>, b: usize, c: f64) {
        if self.closed[0][b] {
            self.modify(state, b, -self.topology.recoil(b) * state.force[PAD + b], c);
        }
        let change = slope(state, state.overlap[b] + c * state.pull(b, &state.force, &[])) - state.slope[PAD + b];
        let to = self.modified.at_mut(b);
        for (site, sign) in self.topology.ends(b).into_iter().zip([1.0, -1.0]) {
            let Some(site) = site else { continue };
            for (rows, by) in self.modes.iter().zip(position(&state.flow)).filter(|(rows, _)| rows.any()) {
                add(sign * change * by, rows.at(site), to);
            }
        }
        let beside = self.topology.beside(b);
        beside.into_iter().flatten().for_each(|side| add(c * change, self.forces[0].at(side), to));
        // Only bonds that are marked as closed kick their sites.
        self.closed[0][b] = true;
    }

    /// Derivatives of the accelerations of sites by the forces of the kick, and of the rates of
    /// these; forces of bonds for which `without` is true count without their rates.
    #[inline(always)]
    fn jet(&mut self, state: &CorrectedSplit<LinearFlow<f64>>, without: impl Fn(usize) -> bool) -> [Rows; 2] {
        let (topology, width) = (self.topology, self.positions.width);
        let by = velocity(&state.flow);
        for b in topology.touching().filter(|&b| self.closed[0][b]) {
            let to = self.modified.at_mut(b);
            to.fill(0.0);
            if without(b) {
                continue;
            }
            let rate = state.chain().across(b, |i| state.flow.bead(i).1);
            add(bend(state, b) * rate, self.forces[0].at(b), to);
            for (site, sign) in topology.ends(b).into_iter().zip([1.0, -1.0]) {
                let Some(site) = site else { continue };
                for (rows, by) in self.modes.iter().zip(by).filter(|(rows, _)| rows.any()) {
                    add(sign * state.slope[PAD + b] * by, rows.at(site), to);
                }
            }
        }
        let [mut a, mut da] = [Rows::zeros(topology.sites(), width), Rows::zeros(topology.sites(), width)];
        for b in topology.touching().filter(|&b| self.closed[0][b]) {
            for &(i, weight) in topology.pushed(b).iter() {
                add(weight, self.forces[0].at(b), a.at_mut(i));
                add(weight, self.modified.at(b), da.at_mut(i));
            }
        }
        [a, da]
    }

    /// Moves columns by displacements of `share` times accelerations and impulses of `-share` times
    /// their rates.
    #[inline(always)]
    fn shift(&mut self, state: &CorrectedSplit<LinearFlow<f64>>, share: f64, [a, da]: &[Rows; 2]) {
        let one = |impulse, displacement| {
            state.flow.shares(&Correction { impulse, displacement, at: 0.0, rate: 0.0, turn: [0.0, 1.0] })
        };
        let (by_da, by_a) = (one(-share, 0.0), one(0.0, share));
        for (k, rows) in self.modes.iter_mut().enumerate().filter(|(_, rows)| rows.any()) {
            add(by_da[k], &da.numbers, &mut rows.numbers);
            add(by_a[k], &a.numbers, &mut rows.numbers);
        }
    }
}

impl SplitFlow<f64> for TangentFlow {
    fn dim(&self) -> usize {
        self.state.dim()
    }

    /// The columns keep the derivatives that they have now, for the new state.
    fn load(&mut self, y: &[f64]) {
        *self = Self::new(self.state.chain().clone(), y, &self.columns());
    }

    fn store(&self, y: &mut [f64]) {
        self.state.store(y);
    }

    fn duplicate(&self) -> Self {
        let mut copy = Self::zeros(LinearFlow::new(self.state.chain().clone()), self.columns.count);
        copy.copy_from(self);
        copy
    }

    fn copy_from(&mut self, other: &Self) {
        self.state.copy_from(&other.state);
        let (to, from) = (&mut self.columns, &other.columns);
        for (to, from) in to.modes.iter_mut().zip(&from.modes).chain(to.forces.iter_mut().zip(&from.forces)) {
            to.numbers.copy_from_slice(&from.numbers);
        }
        to.fresh.clone_from(&from.fresh);
        for (to, from) in to.closed.iter_mut().zip(&from.closed) {
            to.copy_from_slice(from);
        }
    }

    fn drift(&mut self, dt: DoubleDouble<f64>) {
        self.state.drift(dt);
    }

    fn kick_drift(&mut self, kick: f64, drift: DoubleDouble<f64>) {
        self.survey();
        self.kick(kick, 0.0);
        self.drift(drift);
    }
}

impl BondFlow for TangentFlow {
    const CARRIES: bool = true;

    fn prepare(&mut self, h: f64, reach: f64) {
        self.state.prepare(h, reach);
    }

    fn exponent(&self) -> f64 {
        self.state.exponent()
    }

    fn bonds(&self) -> usize {
        self.state.bonds()
    }

    fn survey(&mut self) {
        self.state.survey();
        self.survey_columns();
    }

    fn changed(&mut self, out: &mut Vec<(usize, bool)>) {
        self.state.changed(out);
    }

    fn turned(&self, out: &mut Vec<(usize, bool)>) {
        self.state.turned(out);
    }

    fn force(&self, bond: usize) -> (f64, f64) {
        BondFlow::force(&self.state, bond)
    }

    fn path(&self, bond: usize) -> BondPath {
        BondFlow::path(&self.state, bond)
    }

    #[inline(always)]
    fn views<V: Vector<f64>>(&self, bonds: &[(usize, bool)], h: f64) -> BondView<V> {
        self.state.views(bonds, h)
    }

    fn depends(&mut self, bond: usize, dependence: Dependence<'_>) {
        let b = self.state.bond(bond);
        let slopes = slopes(&self.state, b, &dependence);
        if self.told == self.pending.len() {
            self.pending.push([(); 4].map(|()| vec![0.0; self.columns.positions.width]));
        }
        let Self { state, columns, pending, told, .. } = self;
        let numbers = Numbers::of(state, b);
        for (to, slopes) in pending[*told].iter_mut().zip(&slopes) {
            to.fill(0.0);
            numbers.apply(columns, slopes, to);
        }
        if dependence.kicks {
            columns.fresh.push(b);
            columns.kick_before(state, b, dependence.h, &mut pending[*told]);
        }
        *told += 1;
    }

    fn correct<'a>(&mut self, given: impl Iterator<Item = (usize, &'a Correction)>) {
        for (bond, correction) in given {
            self.state.correct([(bond, correction)].into_iter());
            let Self { state, columns, pending, told, given } = self;
            let b = state.bond(bond);
            for &(site, weight) in columns.topology.pushed(b).iter() {
                for (rows, by) in columns.modes.iter_mut().zip(&pending[*given]).filter(|(rows, _)| rows.any()) {
                    add(weight, by, rows.at_mut(site));
                }
            }
            columns.refresh(state, b);
            *given += 1;
            if given == told {
                (*told, *given) = (0, 0);
            }
        }
    }

    fn kick(&mut self, kick: f64, c: f64) {
        let tau = self.state.flow.tau;
        self.state.kick(kick, c);
        let Self { state, columns, .. } = self;
        if state.flow.tau != tau {
            columns.anchor(tau);
        }
        f64::run(Kick { columns, state, kick, c });
    }

    /// The processor's midpoint step, and its derivative.
    fn process(&mut self, share: f64, sides: &[Side]) {
        let start = self.state.jet(sides);
        self.survey_columns();
        let start_columns = self.jet_columns(sides);
        self.state.shift(0.5 * share, &start);
        self.columns.shift(&self.state, 0.5 * share, &start_columns);
        let middle = self.state.jet(sides);
        self.survey_columns();
        let middle_columns = self.jet_columns(sides);
        self.state.shift(share, &middle);
        self.state.shift(-0.5 * share, &start);
        self.columns.shift(&self.state, share, &middle_columns);
        self.columns.shift(&self.state, -0.5 * share, &start_columns);
    }

    /// Moves the state alone; columns are not changed.
    fn back(&self, y: &mut [f64], by: f64) {
        self.state.back(y, by);
    }
}

/// Derivatives, by the numbers of a bond, of what its correction adds to `R0, V, C, S` of a bead:
/// central differences.
fn slopes(state: &CorrectedSplit<LinearFlow<f64>>, b: usize, dependence: &Dependence<'_>) -> [[f64; NUMBERS]; 4] {
    let &Dependence { h, change, of, .. } = dependence;
    let (step, omega) = (state.swung.0, state.flow.omega());
    let topology = state.chain().topology();
    let mobility = topology.recoil(b);
    let pulls = [state.pull(b, &state.force_before, &[]), state.pull(b, &state.force, &[])];
    let [rate, p, p_dot] = topology.across(b, |i| state.flow.motion(i));
    let numbers = [state.overlap[b], rate, p, p_dot, pulls[0], pulls[1]];
    // Sizes of changes of the numbers, each of which changes the path within a step about equally.
    let stiffness = omega * omega;
    let speed = rate.abs() + step * (pulls[0].abs() + pulls[1].abs() + stiffness * p.abs());
    let swing = speed / (stiffness * step);
    let scales = [speed * step, speed, swing, swing / step, speed / step, speed / step];
    let mut slopes = [[0.0; NUMBERS]; 4];
    let moving: Vec<usize> = (0..NUMBERS).filter(|&j| scales[j].is_finite() && scales[j] > 0.0).collect();
    let view = |j: usize, by: f64| {
        let mut numbers = numbers;
        numbers[j] += by * scales[j];
        let [g, rate, p, p_dot, before, now] = numbers;
        let pull = [before, now];
        BondView { path: state.path_of((g, [rate, p, p_dot]), pull, h), mobility, pull }
    };
    let views: Vec<BondView> = moving.iter().flat_map(|&j| [view(j, change), view(j, -change)]).collect();
    let mut corrections = Vec::with_capacity(views.len());
    of(&views, &mut corrections);
    for (&j, pair) in moving.iter().zip(corrections.chunks(2)) {
        // Where only one of the two views has a correction, the correction is close to zero.
        let &[Some(ahead), Some(behind)] = pair else { continue };
        let [ahead, behind] = [ahead, behind].map(|correction| state.flow.shares(&correction));
        for k in 0..4 {
            slopes[k][j] = (ahead[k] - behind[k]) / (2.0 * change * scales[j]);
        }
    }
    slopes
}

/// The derivatives of the numbers of a bond: sums over the modes of its sites and the forces of its
/// neighbours.
struct Numbers {
    b: usize,
    position: [f64; 4],
    velocity: [f64; 4],
}

impl Numbers {
    fn of(state: &CorrectedSplit<LinearFlow<f64>>, b: usize) -> Self {
        Self { b, position: position(&state.flow), velocity: velocity(&state.flow) }
    }

    /// Adds to a row the derivatives of the numbers, each times its slope.
    #[inline(always)]
    fn apply(&self, columns: &Columns, slopes: &[f64; NUMBERS], to: &mut [f64]) {
        let &[by_g, by_rate, by_p, by_p_dot, by_before, by_now] = slopes;
        for (site, sign) in columns.topology.ends(self.b).into_iter().zip([1.0, -1.0]) {
            let Some(site) = site else { continue };
            for (k, rows) in columns.modes.iter().enumerate().filter(|(_, rows)| rows.any()) {
                let swing = if k < 2 { 0.0 } else { by_p * self.position[k] + by_p_dot * self.velocity[k] };
                add(sign * (by_g * self.position[k] + by_rate * self.velocity[k] + swing), rows.at(site), to);
            }
        }
        for side in columns.topology.beside(self.b).into_iter().flatten() {
            add(by_before, columns.forces[1].at(side), to);
            add(by_now, columns.forces[0].at(side), to);
        }
    }
}
