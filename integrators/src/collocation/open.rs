//! Damping and drives of a chain, and its ledger: the energies that drag, dashpots and contacts
//! dissipate, and the work of drives.

use super::{
    chain::{ContactChain, Drive, Path},
    flow::Flow,
    prescribed::Driven,
};
use crate::clock::Breaks;
use std::{collections::HashMap, sync::Arc};

/// The sites that are damped, driven, or beside a contact that dissipates.
#[derive(Clone, Debug)]
pub(crate) struct Open {
    /// The motion of each site that is damped or pushed, or beside a contact that dissipates.
    pub(super) flows: Vec<Option<Arc<Flow>>>,
    pub(crate) drives: Vec<Drive>,
    /// Index of the drive of each site.
    driven: Vec<Option<u32>>,
    /// For each bond, the sites whose gains of the ledger are computed with it: the site after it,
    /// and for the first bond of a chain with ends also the site before it.
    pub(super) kept: Vec<[Option<usize>; 2]>,
    /// Sites whose gains of the ledger are computed with no bond.
    pub(crate) alone: Vec<usize>,
    /// Times at which signals are not smooth.
    breaks: Breaks,
    /// The longest window for which the series of all flows are exact to rounding.
    pub(super) longest: f64,
}

impl Open {
    /// The damping and drives of a chain; `None` if it has none, and no contact dissipates.
    pub(crate) fn of<const S: usize, C: ContactChain<S>>(chain: &C) -> Option<Self> {
        let (sites, drives) = (chain.sites(), chain.drives());
        if S == 1 {
            return None;
        }
        let mut rubbed = vec![false; sites];
        for b in (0..chain.bonds()).filter(|&b| chain.bond(b).dissipates()) {
            chain.ends(b).into_iter().flatten().for_each(|i| rubbed[i] = true);
        }
        let still = |i: usize| !rubbed[i] && chain.damping(i) == [0.0; 2];
        if drives.is_empty() && (0..sites).all(still) {
            return None;
        }
        let mut driven = vec![None; sites];
        for (k, drive) in drives.iter().enumerate() {
            driven[drive.site] = Some(k as u32);
        }
        let mut known = HashMap::new();
        let mut flow = |i: usize| {
            let (response, damping) = (chain.response(i), chain.damping(i));
            let pushed = driven[i].is_some_and(|k| !drives[k as usize].moved);
            let moved = driven[i].is_some() && !pushed;
            (pushed || !moved && !still(i)).then(|| {
                let [drag, slip] = damping;
                let kind = [response.m, response.mu, response.omega.value(), drag, slip].map(f64::to_bits);
                Arc::clone(known.entry(kind).or_insert_with(|| Arc::new(Flow::new(response, damping))))
            })
        };
        let flows: Vec<Option<Arc<Flow>>> = (0..sites).map(&mut flow).collect();
        let counts = |i: usize| flows[i].is_some() || driven[i].is_some();
        let (mut kept, mut alone) = (vec![[None; 2]; chain.bonds()], vec![true; sites]);
        for (b, kept) in kept.iter_mut().enumerate() {
            let ends = chain.ends(b);
            let first = if b == 0 && !chain.ring() { ends[0] } else { None };
            *kept = [ends[S - 1], first].map(|site| site.filter(|&i| counts(i)));
            kept.iter().flatten().for_each(|&i| alone[i] = false);
        }
        Some(Self {
            longest: flows.iter().flatten().fold(f64::INFINITY, |most, flow| most.min(flow.longest())),
            alone: (0..sites).filter(|&i| alone[i] && counts(i)).collect(),
            flows,
            drives,
            driven,
            kept,
            breaks: Breaks::new(chain.breaks()),
        })
    }

    /// The motion of a site, if it is damped.
    pub(crate) fn damped(&self, site: usize) -> Option<&Arc<Flow>> {
        self.flows[site].as_ref().filter(|flow| flow.damped())
    }

    /// The longest window for which the series of all flows are exact to rounding.
    pub(crate) fn longest(&self) -> f64 {
        self.longest
    }

    /// The time from `t` to the next one at which a signal is not smooth.
    pub(crate) fn until_break(&self, t: f64) -> f64 {
        self.breaks.after(t) - t
    }

    /// Computes what drives do in a window, given by its start, its length and the tolerance.
    /// Returns the length of a shorter window if series do not resolve the drives in this one, else
    /// infinity.
    pub(crate) fn window<const S: usize, C: ContactChain<S>>(
        &self,
        chain: &C,
        at: (f64, f64, f64),
        window: &mut Signals,
    ) -> f64 {
        window.start = at.0;
        window.driven.clear();
        let mut longest = f64::INFINITY;
        for drive in &self.drives {
            let flow = self.flows[drive.site].as_deref().filter(|_| !drive.moved);
            let signal = &|s: f64| chain.signal(drive.site, at.0 + s);
            let (driven, resolved) = Driven::ahead(drive, flow, signal, at);
            window.driven.push(driven);
            longest = resolved.min(longest);
        }
        longest
    }

    /// Adds to `path` the path by the force of a drive on a site in a window.
    pub(crate) fn push(&self, window: &Signals, site: usize, path: &mut Path) {
        if let Some(k) = self.drive(site) {
            let left = &window.driven[k].left;
            *path = std::array::from_fn(|i| path[i] + left[i]);
        }
    }

    /// Index of the drive of a site.
    pub(crate) fn drive(&self, site: usize) -> Option<usize> {
        self.driven[site].map(|k| k as usize)
    }
}

/// What drives do in a window.
#[derive(Clone, Debug, Default)]
pub(crate) struct Signals {
    /// Start time of the window.
    pub(crate) start: f64,
    /// One for each drive.
    pub(crate) driven: Vec<Driven>,
}
