//! What is damped and driven in a chain, and its ledger: what drag and dashpots take and drives
//! put in.

use super::{
    flow::Flow,
    known::Driven,
    panel::{dot, product, times},
    panels::Panels,
    rule::Rule,
    sites::Bonds,
    system::{ContactChain, Drive, Path},
};
use std::{collections::HashMap, sync::Arc};

/// The sites that are damped or driven.
#[derive(Clone, Debug)]
pub(crate) struct Open {
    /// The motion of each site that is damped or pushed.
    flows: Vec<Option<Arc<Flow>>>,
    pub(crate) drives: Vec<Drive>,
    /// The drive of each site.
    driven: Vec<Option<u32>>,
    /// The sites in whose ledger a bond writes: that behind it, and that before it if it is the
    /// first of its bonds.
    kept: Vec<[Option<usize>; 2]>,
    /// Sites that no bond keeps.
    pub(crate) alone: Vec<usize>,
    /// Times at which signals are not smooth, ascending.
    breaks: Vec<f64>,
    /// The longest window for which all flows are resolved.
    longest: f64,
}

impl Open {
    /// That of a chain, if anything is damped or driven.
    pub(crate) fn of<const S: usize, C: ContactChain<S>>(chain: &C) -> Option<Self> {
        let (sites, drives) = (chain.sites(), chain.drives());
        if S == 1 || drives.is_empty() && (0..sites).all(|i| chain.damping(i) == [0.0; 2]) {
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
            (pushed || damping != [0.0; 2]).then(|| {
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
        let mut breaks = chain.breaks();
        breaks.sort_by(f64::total_cmp);
        Some(Self {
            longest: flows.iter().flatten().fold(f64::INFINITY, |most, flow| most.min(flow.longest())),
            alone: (0..sites).filter(|&i| alone[i] && counts(i)).collect(),
            flows,
            drives,
            driven,
            kept,
            breaks,
        })
    }

    /// The motion of a site, if it is damped.
    pub(crate) fn damped(&self, site: usize) -> Option<&Arc<Flow>> {
        self.flows[site].as_ref().filter(|flow| flow.damped())
    }

    /// The longest window in which all flows are resolved.
    pub(crate) fn longest(&self) -> f64 {
        self.longest
    }

    /// The time from `t` to the next one at which a signal is not smooth.
    pub(crate) fn until_break(&self, t: f64) -> f64 {
        let next = self.breaks.partition_point(|&at| at <= t + NEAR * t.abs());
        self.breaks.get(next).map_or(f64::INFINITY, |at| at - t)
    }

    /// What drives do in a window of length `h` that begins at `t`. Returns the length of one in
    /// which series resolve them.
    pub(crate) fn window<const S: usize, C: ContactChain<S>>(
        &self,
        chain: &C,
        at: (f64, f64, f64),
        window: &mut Window,
    ) -> f64 {
        window.start = at.0;
        window.driven.clear();
        let mut longest = f64::INFINITY;
        for drive in &self.drives {
            let flow = self.flows[drive.site].as_deref().filter(|_| !drive.moved);
            let signal = |s: f64| chain.signal(drive.site, at.0 + s);
            let (driven, resolved) = Driven::over(drive, flow, &signal, at);
            window.driven.push(driven);
            longest = resolved.min(longest);
        }
        longest
    }

    /// Adds what a drive pushes a site by in a window.
    pub(crate) fn push(&self, window: &Window, site: usize, path: &mut Path) {
        if let Some(k) = self.drive(site) {
            let left = &window.driven[k].left;
            *path = std::array::from_fn(|i| path[i] + left[i]);
        }
    }

    /// The drive of a site.
    pub(crate) fn drive(&self, site: usize) -> Option<usize> {
        self.driven[site].map(|k| k as usize)
    }

    /// The sites in whose ledger a bond writes, with the panels of the bonds before and behind each:
    /// `own` are its own, `next` those of the bond behind it.
    pub(crate) fn kept<'a, P>(
        &self,
        bond: usize,
        own: &'a P,
        next: Option<&'a P>,
    ) -> impl Iterator<Item = (usize, [Option<&'a P>; 2])> {
        let [behind, before] = self.kept[bond];
        let behind = behind.map(|site| (site, [Some(own), next]));
        behind.into_iter().chain(before.map(|site| (site, [None, Some(own)])))
    }

    /// What the ledger of a site gains in a window of length `h`, from the forces in the bonds before
    /// and behind it: by quadrature, between the ends of all panels.
    ///
    /// There forces, velocities and powers may begin or end with half powers of time, so that the
    /// time is one with a double zero of its rate, `t = a + (b - a) x^2 (3 - 2 x)`.
    pub(crate) fn gains<const M: usize, const S: usize>(
        &self,
        bonds: &dyn Bonds<S>,
        h: f64,
        site: usize,
        panels: [Option<&Panels<M, S>>; 2],
    ) -> Path {
        let (rule, given) = (Rule::<NODES>::shared(), Rule::<M>::shared());
        let (mut gains, drive) = ([0.0; 4], self.drive(site).map(|k| &self.drives[k]));
        let mut y = bonds.site(site);
        let panels = panels.map(|panels| panels.map_or(&[][..], Panels::as_slice));
        let touched = panels.iter().any(|panels| !panels.is_empty());
        if !touched && drive.is_none() && y == [0.0; 4] {
            return gains;
        }
        let mut cuts = vec![0.0, h];
        cuts.extend(panels.iter().flat_map(|panels| panels.iter().flat_map(|panel| [panel.start, panel.end])));
        cuts.sort_by(f64::total_cmp);
        for pair in cuts.windows(2).filter(|pair| pair[1] > pair[0]) {
            let (a, length) = (pair[0], pair[1] - pair[0]);
            let share = rule.nodes.map(|x| 0.5 * (1.0 + x));
            let t = share.map(|x| a + length * (x * x * (3.0 - 2.0 * x)));
            let rate = share.map(|x| length * (3.0 * x * (1.0 - x)));
            let middle = a + 0.5 * length;
            let mut force = [0.0; NODES];
            for (panels, sign) in panels.iter().zip([1.0, -1.0]) {
                if let Some(panel) = panels.iter().find(|panel| panel.start < middle && middle < panel.end) {
                    let by = panel.force_at(given, &t);
                    for j in 0..NODES {
                        force[j] += sign * by[j];
                    }
                }
            }
            let signal = t.map(|t| drive.map_or([0.0; 3], |_| bonds.signal(site, t)));
            let Some(flow) = self.flows[site].as_deref().filter(|_| drive.is_none_or(|drive| !drive.moved)) else {
                gains[3] -= (0..NODES).map(|j| rule.weights[j] * rate[j] * (force[j] * signal[j][1])).sum::<f64>();
                continue;
            };
            for j in 0..NODES {
                force[j] += signal[j][0];
            }
            let impulse = times(&rate, &force);
            let answer = flow.answer(&t).map(|part| times(&part, &impulse));
            let moments = answer.map(|part| product(&rule.integral, &part));
            let now: [Path; NODES] = std::array::from_fn(|j| std::array::from_fn(|k| y[k] + moments[k][j]));
            let ([lag, cos, sin], [by_v, by_c, by_s]) = (flow.position(&t), flow.swing(&t));
            for j in 0..NODES {
                let [_, v, c, s] = flow.rates(&now[j]);
                let [_, v0, c0, s0] = now[j];
                // The position along the rates of a path is the velocity along the path.
                let velocity = v0 + (v * (t[j] + lag[j]) + (c * cos[j] + s * sin[j]));
                let swing = v0 * by_v[j] + (c0 * by_c[j] + s0 * by_s[j]);
                let weight = rule.weights[j] * rate[j];
                gains[0] += weight * (flow.drag() * (velocity * velocity));
                gains[1] += weight * (flow.dashpot() * (swing * swing));
                gains[3] += weight * (signal[j][0] * velocity);
            }
            for k in 0..4 {
                y[k] += dot(&rule.weights, &answer[k]);
            }
        }
        gains
    }
}

/// Nodes of a quadrature between two ends of panels.
const NODES: usize = 12;
/// Share of a time that counts as none.
const NEAR: f64 = 1e-12;

/// What drives do in a window.
#[derive(Clone, Debug, Default)]
pub(crate) struct Window {
    /// When it begins.
    pub(crate) start: f64,
    pub(crate) driven: Vec<Driven>,
}
