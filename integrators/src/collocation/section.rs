//! A section: the bonds of a chain that windows are solved for together, all of them or a part.

use super::{
    bond::Contact,
    chain::{ContactChain, Path},
    link::Links,
    open::{Open, Signals},
    sites::{Bonds, Phases, Site, Sites},
    solver::{Solver, with_nodes},
    window::{ALONG, Left, OWN, Piece, Share, Start, Window, WindowOutcome, Windows},
};
use crate::{clock::DoubleDouble, kernel, real::Real};
use std::{ops::Range, sync::Arc};

/// Length of the window in which drives are evaluated at the start of a run.
const AT_ONCE: f64 = 1e-9;

/// Number of bonds of a block. A part of a chain consists of whole blocks, counted from the first
/// bond of the chain; the last may be shorter.
pub const BLOCK: usize = OWN;
/// Number of bonds at either end of a part whose results its neighbours need: those that the blocks
/// of a neighbour solve for too, and one more, which pushes the outermost site of these.
pub const EDGE: usize = ALONG + 1;

/// The bonds of a chain that windows are solved for in one place, and their sites.
///
/// A section that is a part of a longer chain has more bonds than its own. The results of a window
/// for the bonds beyond its own must come from its neighbours ([`take_edge`](Self::take_edge)),
/// before the section is moved over that window.
pub struct Section<C, const S: usize = 1> {
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
    share: Share,
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
        #[cfg(feature = "parallel")]
        let threads = self.threads.unwrap_or_else(rayon::current_num_threads);
        #[cfg(not(feature = "parallel"))]
        let threads = self.threads.unwrap_or(1);
        self.share.blocks().min(threads).max(1)
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

/// The [groups](Share::group) of a section in which anything moves, and those that may follow.
#[derive(Clone)]
struct Awake {
    /// Whether a site of the group moves or is driven, or a bond is in contact.
    groups: Vec<bool>,
    /// Whether that is so in the group or beside it; always at the two ends, which a ring or a
    /// neighbour of the section joins. Sites of all other groups rest at the origin, and their
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
    fn near(&self, share: &Share, count: usize) -> impl Iterator<Item = usize> {
        let near = self.near.iter().enumerate().filter(|(_, near)| **near);
        near.flat_map(move |(group, _)| share.group(group, count))
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
            let near = group < 2 || group + 2 >= count || beside.contains(&true);
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
    /// A whole chain in the state `y0` at the time `t`, on at most `threads` threads.
    pub(super) fn whole(chain: C, (y0, t): (&[f64], f64), threads: Option<usize>) -> Self {
        let share = Share::whole(chain.bonds(), chain.ring());
        let mut section = Self::at_rest(chain, share, threads);
        (0..section.sites()).for_each(|i| section.set(i, section.held.chain.path(y0, i)));
        section.state.t = DoubleDouble::new(t);
        section.state.ledger.take(&section.held.chain.ledger(y0, t));
        section.begin();
        section
    }

    /// A share of a chain, at rest, on at most `threads` threads. For a part of a longer chain,
    /// `chain` has the sites of the bonds within its reach, and the bonds on both sides of each.
    pub fn at_rest(chain: C, share: Share, threads: Option<usize>) -> Self {
        let (links, bonds, phases) = (Links::of(&chain), chain.bonds(), Phases::new(&chain));
        let mobility = (0..bonds).map(|b| links.mobility(&chain, b)).collect();
        let state = State {
            sites: vec![Site::default(); chain.sites()],
            ongoing: vec![None; bonds],
            phases,
            t: DoubleDouble::new(0.0),
            ledger: Site::default(),
            signals: Signals::default(),
            awake: Awake::new(share.groups(bonds.max(chain.sites()))),
        };
        let held = Arc::new(Held { chain, links, mobility, share, threads });
        Self { held, state, solver: None, left: vec![Left::NONE; bonds], h: 0.0 }
    }

    /// Number of sites.
    pub fn sites(&self) -> usize {
        self.state.sites.len()
    }

    /// Sets the path of a site at the start of the run.
    pub fn set(&mut self, site: usize, path: Path) {
        self.state.sites[site] = Site { hi: path, lo: [0.0; 4] };
    }

    /// Finds the bonds that are closed when the run begins, after all sites are [`set`](Self::set).
    pub fn begin(&mut self) {
        self.predict_drives(AT_ONCE, 0.0);
        let (held, State { sites, phases, ongoing, signals, .. }) = (&self.held, &mut self.state);
        let at_start = Sites { chain: &held.chain, sites, phases, open: held.open(signals) };
        for b in held.share.reach() {
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
        let Held { links, share, .. } = &**held;
        let driven = |i: usize| links.open.as_ref().is_some_and(|open| open.drive(i).is_some());
        let moves = |group: usize| {
            let mut bonds = ongoing[share.group(group, ongoing.len())].iter();
            let moves = |i: usize| !sites[i].at_rest() || S != 1 && driven(i);
            links.precompressed || bonds.any(Option::is_some) || share.group(group, sites.len()).any(moves)
        };
        let bonds = left.len();
        awake.update(moves, |group| left[share.group(group, bonds)].fill(Left::NONE));
    }

    /// The bonds of a chain whose contacts dissipate that are not in a contact and whose beads
    /// touch at the start of the last window; and whether at rest, so that their rate does not part
    /// them in the window.
    pub(super) fn touching(&self) -> Vec<(usize, bool)> {
        let Self { held, state: State { sites, phases, ongoing, signals, .. }, h, .. } = self;
        let at_start = Sites { chain: &held.chain, sites, phases, open: held.open(signals) };
        let bonds = if held.links.lossy() { 0..held.chain.bonds() } else { 0..0 };
        let touching = bonds.filter(|&b| ongoing[b].is_none()).filter_map(|b| {
            let ([overlap, rate], band) = (at_start.now(&held.links, b).0, at_start.free(b, *h).band);
            (overlap.abs() <= band).then_some((b, (rate * h).abs() <= band))
        });
        touching.collect()
    }

    /// The free and the oscillating part of the position of a site, and their rates.
    pub fn get(&self, site: usize) -> [f64; 4] {
        let [r, v, c, s] = self.state.sites[site].path(self.state.phases.sin_cos(site));
        [r, v, c, self.held.chain.response(site).omega.value() * s]
    }

    /// What contacts did in the last window, in the order of bonds, if that is logged.
    pub fn pieces(&self) -> impl Iterator<Item = &Piece> {
        self.solver.iter().flat_map(|solver| solver.pieces())
    }

    /// Bytes of memory for a bond and its site: their state twice, the second time for samples, and
    /// the mobility.
    pub const BYTES: usize =
        2 * (size_of::<Site>() + size_of::<Option<Contact>>() + size_of::<Left<S>>()) + size_of::<f64>();
    /// Number of `f64` values that [`edge`](Self::edge) appends.
    pub const EDGE_NUMBERS: usize = EDGE * Left::<S>::NUMBERS;

    /// Appends the results of the last window for the first or the last [`EDGE`] own bonds.
    pub fn edge(&self, last: bool, numbers: &mut Vec<f64>) {
        let Range { start, end } = self.held.share.own;
        let edge = if last { end - EDGE..end } else { start..start + EDGE };
        self.left[edge].iter().for_each(|left| left.write(numbers));
    }

    /// Takes a neighbour's [`edge`](Self::edge) as the results for the [`EDGE`] bonds before the
    /// first own bond, or after the last one.
    pub fn take_edge(&mut self, behind: bool, numbers: &[f64]) {
        let Range { start, end } = self.held.share.own;
        let edge = if behind { end..end + EDGE } else { start - EDGE..start };
        let bonds = numbers.chunks_exact(Left::<S>::NUMBERS);
        self.left[edge].iter_mut().zip(bonds).for_each(|(left, numbers)| *left = Left::of_numbers(numbers));
    }
}

impl<C: ContactChain<S>, const S: usize> Windows for Section<C, S> {
    fn dim(&self) -> usize {
        self.held.chain.dim()
    }

    fn longest(&self) -> [f64; 2] {
        let open = self.held.links.open.as_ref();
        open.map_or([f64::INFINITY; 2], |open| [open.until_break(self.state.t.value()), open.longest()])
    }

    fn predict_drives(&mut self, h: f64, tol: f64) -> f64 {
        let Self { held, state: State { t, signals, .. }, .. } = self;
        let open = held.links.open.as_ref();
        open.map_or(f64::INFINITY, |open| open.window(&held.chain, (t.value(), h, tol), signals))
    }

    fn solve(&mut self, window: &Window) -> WindowOutcome {
        let Self { held, state: State { sites, ongoing, phases, signals, awake, .. }, solver, left, h } = self;
        let Held { chain, links, mobility, share, .. } = &**held;
        if solver.as_ref().is_none_or(|solver| solver.nodes() != window.nodes) {
            *solver = None;
        }
        let solver = solver.get_or_insert_with(|| with_nodes(window.nodes, held.threads()));
        let bonds = &Sites { chain, sites, phases, open: held.open(signals) };
        let start = Start { links, bonds, ongoing, mobility, share, near: &awake.near };
        *h = window.h;
        solver.window(&start, window, &mut left[share.own.clone()])
    }

    fn advance(&mut self) {
        let Self { held, state: State { sites, ongoing, phases, t, ledger, signals, awake }, left, h, .. } = self;
        let (chain, share, h, open) = (&held.chain, &held.share, *h, held.open(signals));
        if const { S != 1 }
            && let Some((about, _)) = open
        {
            let bonds = &Sites { chain, sites, phases, open };
            about.alone.iter().for_each(|&site| ledger.take(&about.gains::<4, S>(bonds, h, site, [None; 2])));
            awake.near(share, left.len()).for_each(|bond| ledger.take(&left[bond].ledger));
        }
        let (before, by, count) = (&*phases, &**left, sites.len());
        let reached = (0..awake.near.len()).filter(|&group| awake.reached(group));
        let moving = reached.map(|group| share.group(group, count));
        f64::run(kernel!(advance(chain, (sites, moving), (by, h), before, open)));
        awake.near(share, left.len()).for_each(|bond| ongoing[bond] = left[bond].ongoing);
        phases.advance(h);
        *t = *t + DoubleDouble::new(h);
        self.watch();
    }

    fn duplicate(&self) -> Self {
        let Self { held, state, left, h, .. } = self;
        Self { held: held.clone(), state: state.clone(), solver: None, left: left.clone(), h: *h }
    }

    fn copy_from(&mut self, other: &Self) {
        let (share, [mine, near]) =
            (&self.held.share, [&self.state.awake, &other.state.awake].map(|awake| &awake.near));
        for group in (0..near.len()).filter(|&group| mine[group] || near[group]) {
            let (sites, bonds) = (share.group(group, other.sites()), share.group(group, other.left.len()));
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

    fn store(&self, y: &mut [f64]) {
        // Sites that rest at the origin are zeros.
        y.fill(0.0);
        let near = self.state.awake.near(&self.held.share, self.sites());
        near.for_each(|i| self.held.chain.place(self.get(i), i, y));
        self.held.chain.complete(self.state.ledger.path((0.0, 1.0)), self.state.t.value(), y);
    }

    fn tell(&self, told: &mut dyn FnMut(&Piece)) {
        self.pieces().for_each(told);
    }
}
