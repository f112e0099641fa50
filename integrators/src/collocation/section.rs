//! A section: a chain, window by window.

use super::{
    bond::Contact,
    chain::ContactChain,
    kernels::run,
    link::Links,
    open::{Open, Signals},
    sites::{Phases, Site, Sites},
    solver::{Solver, with_nodes},
    window::{Blocks, Left, OWN, Piece, Start, Window, WindowOutcome, group},
};
use crate::{clock::DoubleDouble, kernel};
use std::{ops::Range, sync::Arc};

/// Length of the window in which drives are evaluated at the start of a run.
const AT_ONCE: f64 = 1e-9;

/// A chain in the state at the start of a window, which it solves and is then moved over.
pub(super) struct Section<C, const S: usize = 1> {
    pub(super) held: Arc<Held<C, S>>,
    /// The state at the start of the last window.
    pub(super) state: State<S>,
    /// Made for the first window, and again when the number of nodes changes.
    pub(super) solver: Option<Box<dyn Solver<S>>>,
    /// The results of the last window for each bond, and its length.
    left: Vec<Left<S>>,
    h: f64,
}

/// The constants of a section.
pub(super) struct Held<C, const S: usize> {
    pub(super) chain: C,
    pub(super) links: Links<S>,
    mobility: Vec<f64>,
    blocks: Blocks,
    /// Largest number of threads; `None` for as many as there are.
    threads: Option<usize>,
}

impl<C, const S: usize> Held<C, S> {
    /// Damping and drives, if there are any, with what drives do in the current window.
    fn open<'a>(&'a self, signals: &'a Signals) -> Option<(&'a Open, &'a Signals)> {
        self.links.open.as_ref().map(|open| (open, signals))
    }

    /// The number of threads on which blocks are solved.
    fn threads(&self) -> usize {
        let threads = self.threads.unwrap_or_else(rayon::current_num_threads);
        self.blocks.count().min(threads).max(1)
    }
}

/// The state of a section: sites, the contacts that bonds are in, phases, time and ledger.
#[derive(Clone)]
pub(super) struct State<const S: usize> {
    sites: Vec<Site>,
    ongoing: Vec<Option<Contact>>,
    pub(super) phases: Phases<S>,
    t: DoubleDouble<f64>,
    /// Energies dissipated and driven so far, see [`ContactChain::ledger`].
    ledger: Site,
    /// What drives do in the current window.
    signals: Signals,
    awake: Awake,
}

/// The [groups](group) of a section in which anything moves, and those that may follow.
#[derive(Clone)]
struct Awake {
    /// Whether a site of the group moves or is driven, or a bond is in contact.
    groups: Vec<bool>,
    /// Whether that is so in the group or beside it; always at the two ends, which a ring
    /// joins. Sites of all other groups rest at the origin, and their
    /// bonds have no force in the current window.
    near: Vec<bool>,
}

impl Awake {
    fn new(groups: usize) -> Self {
        Self { groups: vec![false; groups], near: vec![true; groups] }
    }

    fn copy_from(&mut self, other: &Self) {
        self.groups.copy_from_slice(&other.groups);
        self.near.copy_from_slice(&other.near);
    }

    /// The indices, below `count`, in the groups that are near.
    fn near(&self, count: usize) -> impl Iterator<Item = usize> {
        let near = self.near.iter().enumerate().filter(|(_, near)| **near);
        near.flat_map(move |(group, _)| self::group(group, count))
    }

    /// Whether a group is near, or one beside it, whose bonds push its sites.
    fn reached(&self, group: usize) -> bool {
        self.near[group.saturating_sub(1)..self.near.len().min(group + 2)].contains(&true)
    }

    /// Asks each group that is reached whether anything `moves` in it.
    fn update(&mut self, moves: impl Fn(usize) -> bool, mut falls_asleep: impl FnMut(usize)) {
        let count = self.groups.len();
        for group in 0..count {
            self.groups[group] = self.reached(group) && moves(group);
        }
        for group in 0..count {
            let beside = &self.groups[group.saturating_sub(1)..count.min(group + 2)];
            let near = group == 0 || group + 2 >= count || beside.contains(&true);
            if std::mem::replace(&mut self.near[group], near) && !near {
                falls_asleep(group);
            }
        }
    }
}

/// Moves the sites of some groups over a window.
#[inline(always)]
fn advance<C: ContactChain<S>, const S: usize>(
    chain: &C,
    (sites, groups): (&mut [Site], impl Iterator<Item = Range<usize>>),
    (left, h): (&[Left<S>], f64),
    phases: &Phases<S>,
    open: Option<(&Open, &Signals)>,
) {
    for group in groups {
        for (i, site) in group.clone().zip(&mut sites[group]) {
            let mut push = chain.push(i, |b| left[b].path);
            if S != 1
                && let Some((open, signals)) = open
            {
                open.push(signals, i, &mut push);
                if let Some(flow) = open.damped(i) {
                    site.flow(&push, flow, h);
                    continue;
                }
            }
            if !(site.at_rest() && push == [0.0; 4]) {
                site.advance(&push, h, phases.sin_cos(i));
            }
        }
    }
}

impl<C: ContactChain<S>, const S: usize> Section<C, S> {
    /// The chain in the state `y0` at the time `t`, on at most `threads` threads.
    pub(super) fn new(chain: C, (y0, t): (&[f64], f64), threads: Option<usize>) -> Self {
        let (links, bonds, phases) = (Links::of(&chain), chain.bonds(), Phases::new(&chain));
        let mobility = (0..bonds).map(|b| links.mobility(&chain, b)).collect();
        let mut ledger = Site::default();
        ledger.take(&chain.ledger(y0, t));
        let state = State {
            sites: (0..chain.sites()).map(|i| Site { hi: chain.path(y0, i), lo: [0.0; 4] }).collect(),
            ongoing: vec![None; bonds],
            phases,
            t: DoubleDouble::new(t),
            ledger,
            signals: Signals::default(),
            awake: Awake::new(bonds.max(chain.sites()).div_ceil(OWN)),
        };
        let blocks = Blocks { bonds, ring: chain.ring() };
        let held = Arc::new(Held { chain, links, mobility, blocks, threads });
        let mut section = Self { held, state, solver: None, left: vec![Left::NONE; bonds], h: 0.0 };
        section.begin();
        section
    }

    /// Number of sites.
    fn sites(&self) -> usize {
        self.state.sites.len()
    }

    /// Finds the bonds that are closed when the run begins.
    fn begin(&mut self) {
        self.predict_drives(AT_ONCE, 0.0);
        let (held, State { sites, phases, ongoing, signals, .. }) = (&self.held, &mut self.state);
        let at_start = Sites { chain: &held.chain, sites, phases, open: held.open(signals) };
        for b in 0..held.blocks.bonds {
            let ([overlap, rate], largest) = at_start.now(&held.links, b);
            let closed = overlap > held.chain.dead_band(largest);
            let pushes = S == 1 || held.links.link(b).law.overlap_that_pushes(overlap, rate) > 0.0;
            ongoing[b] = (closed && pushes).then(|| Contact::from_the_start(overlap, rate));
        }
        self.watch();
    }

    /// Finds the groups in which anything moves, and clears the results of bonds that fall asleep.
    fn watch(&mut self) {
        let Self { held, state: State { sites, ongoing, awake, .. }, left, .. } = self;
        let links = &held.links;
        let driven = |i: usize| links.open.as_ref().is_some_and(|open| open.drive(i).is_some());
        let moves = |group: usize| {
            let mut bonds = ongoing[self::group(group, ongoing.len())].iter();
            let moves = |i: usize| !sites[i].at_rest() || S != 1 && driven(i);
            links.precompressed || bonds.any(Option::is_some) || self::group(group, sites.len()).any(moves)
        };
        let bonds = left.len();
        awake.update(moves, |group| left[self::group(group, bonds)].fill(Left::NONE));
    }

    /// The free and the oscillating part of the position of a site, and their rates.
    fn get(&self, site: usize) -> [f64; 4] {
        let [r, v, c, s] = self.state.sites[site].path(self.state.phases.sin_cos(site));
        [r, v, c, self.held.chain.response(site).omega.value() * s]
    }

    /// What contacts did in the last window, in the order of bonds, if that is logged.
    pub(super) fn pieces(&self) -> impl Iterator<Item = &Piece> {
        self.solver.iter().flat_map(|solver| solver.pieces())
    }

    /// Number of components of the state.
    pub(super) fn dim(&self) -> usize {
        self.held.chain.dim()
    }

    /// Two bounds for the length of the next window: the time until the signal of a drive is not
    /// smooth, and the longest time over which the series of damped sites are resolved.
    pub(super) fn longest(&self) -> [f64; 2] {
        let open = self.held.links.open.as_ref();
        open.map_or([f64::INFINITY; 2], |open| [open.until_break(self.state.t.value()), open.longest()])
    }

    /// Prepares what drives do in the next window, of length `h`. Returns a shorter length if their
    /// series are not resolved to the tolerance `tol`, else infinity.
    pub(super) fn predict_drives(&mut self, h: f64, tol: f64) -> f64 {
        let Self { held, state: State { t, signals, .. }, .. } = self;
        let open = held.links.open.as_ref();
        open.map_or(f64::INFINITY, |open| open.window(&held.chain, (t.value(), h, tol), signals))
    }

    /// Solves the window that begins at the current state; the state stays there.
    pub(super) fn solve(&mut self, window: &Window) -> WindowOutcome {
        let Self { held, state: State { sites, ongoing, phases, signals, awake, .. }, solver, left, h } = self;
        let Held { chain, links, mobility, blocks, .. } = &**held;
        if solver.as_ref().is_none_or(|solver| solver.nodes() != window.nodes) {
            *solver = None;
        }
        let solver = solver.get_or_insert_with(|| with_nodes(window.nodes, held.threads()));
        let bonds = &Sites { chain, sites, phases, open: held.open(signals) };
        let start = Start { links, bonds, ongoing, mobility, blocks: *blocks, near: &awake.near };
        *h = window.h;
        solver.window(&start, window, left)
    }

    /// Moves the state to the end of the window that was solved last.
    pub(super) fn advance(&mut self) {
        let Self { held, state: State { sites, ongoing, phases, t, ledger, signals, awake }, left, h, .. } = self;
        let (chain, h, open) = (&held.chain, *h, held.open(signals));
        if const { S != 1 }
            && let Some((about, _)) = open
        {
            let bonds = &Sites { chain, sites, phases, open };
            about.alone.iter().for_each(|&site| ledger.take(&about.gains::<4, S>(bonds, h, site, [None; 2])));
            awake.near(left.len()).for_each(|bond| ledger.take(&left[bond].ledger));
        }
        let (before, by, count) = (&*phases, &**left, sites.len());
        let reached = (0..awake.near.len()).filter(|&group| awake.reached(group));
        let moving = reached.map(|group| self::group(group, count));
        run(kernel!(advance(chain, (sites, moving), (by, h), before, open)));
        awake.near(left.len()).for_each(|bond| ongoing[bond] = left[bond].ongoing);
        phases.advance(h);
        *t = *t + DoubleDouble::new(h);
        self.watch();
    }

    /// A copy in the same state.
    pub(super) fn duplicate(&self) -> Self {
        let Self { held, state, left, h, .. } = self;
        Self { held: held.clone(), state: state.clone(), solver: None, left: left.clone(), h: *h }
    }

    /// Takes the state of `other`, which is of the same chain, and the window that it solved last.
    pub(super) fn copy_from(&mut self, other: &Self) {
        let [mine, near] = [&self.state.awake, &other.state.awake].map(|awake| &awake.near);
        for group in (0..near.len()).filter(|&group| mine[group] || near[group]) {
            let (sites, bonds) = (self::group(group, other.sites()), self::group(group, other.left.len()));
            self.state.sites[sites.clone()].copy_from_slice(&other.state.sites[sites]);
            self.state.ongoing[bonds.clone()].copy_from_slice(&other.state.ongoing[bonds.clone()]);
            self.left[bonds.clone()].copy_from_slice(&other.left[bonds]);
        }
        self.state.awake.copy_from(&other.state.awake);
        self.state.phases.copy_from(&other.state.phases);
        (self.state.t, self.state.ledger) = (other.state.t, other.state.ledger);
        self.state.signals.clone_from(&other.state.signals);
        self.h = other.h;
    }

    /// Writes the current state into `y`.
    pub(super) fn store(&self, y: &mut [f64]) {
        // Sites that rest at the origin are zeros.
        y.fill(0.0);
        let near = self.state.awake.near(self.sites());
        near.for_each(|i| self.held.chain.place(self.get(i), i, y));
        self.held.chain.complete(self.state.ledger.path((0.0, 1.0)), self.state.t.value(), y);
    }
}
