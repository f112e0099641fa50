//! The panels of a bond in a window, and the displacements that their forces cause.

use super::{
    chain::Path,
    kernels::apart,
    panel::{Origin, Panel, Times, View},
};
use crate::kernel;

/// The panels of a bond in a window, in order of time.
#[derive(Clone, Debug)]
pub(crate) struct Panels<const M: usize, const S: usize> {
    /// The first `len` are in use; the memory of the others is kept.
    pub(crate) list: Vec<Panel<M, S>>,
    pub(crate) len: usize,
    /// Grows whenever panels are laid out, so that an outdated [`View`] of them is recognised.
    pub(crate) version: u64,
    /// The paths by all forces of the bond in the window, on each side of the bond.
    pub(crate) total: [Path; S],
}

/// The site that two neighbouring bonds share, as a side of each: 0 or `S - 1`.
#[derive(Clone, Copy)]
pub(crate) struct Shared {
    pub(super) theirs: usize,
    pub(super) mine: usize,
}

impl Shared {
    /// The site shared with the neighbour before a bond (0) or after it (1).
    #[inline(always)]
    pub(crate) fn with<const S: usize>(neighbour: usize) -> Self {
        if neighbour == 0 { Self { theirs: S - 1, mine: 0 } } else { Self { theirs: 0, mine: S - 1 } }
    }

    /// For the action of a bond on itself: one of its own sides.
    #[inline(always)]
    pub(crate) fn own(side: usize) -> Self {
        Self { theirs: side, mine: side }
    }
}

impl<const M: usize, const S: usize> Panels<M, S> {
    pub(crate) fn new() -> Self {
        Self { list: Vec::new(), len: 0, version: 0, total: [[0.0; 4]; S] }
    }

    #[inline(always)]
    pub(super) fn clear(&mut self) {
        (self.len, self.total) = (0, [[0.0; 4]; S]);
    }

    /// Adds a panel, see [`Panel::span`].
    pub(super) fn push(&mut self, start: f64, end: f64, origin: Origin, q: u32) {
        if self.len == self.list.len() {
            self.list.push(Panel::new());
        }
        self.list[self.len].span(start, end, origin, q);
        self.len += 1;
    }

    /// The largest force at a node of a panel that starts before `t`.
    pub(super) fn largest_force(&self, t: f64) -> f64 {
        let panels = self.as_slice().iter().take_while(|panel| panel.start < t);
        panels.flat_map(|panel| panel.force).fold(0.0, f64::max)
    }

    pub(crate) fn as_slice(&self) -> &[Panel<M, S>] {
        &self.list[..self.len]
    }

    /// The paths by all panels before panel `k`.
    #[inline(always)]
    pub(crate) fn before(&self, k: usize) -> &[Path; S] {
        if k < self.len { &self.list[k].before } else { &self.total }
    }

    /// Writes into `view` where ascending times lie among these panels.
    #[inline(always)]
    fn look(&self, tau: &[f64; M], view: &mut View<M>) {
        view.version = self.version;
        let (first, last) = (tau[0], tau[M - 1]);
        let mut place = -1;
        for (k, panel) in self.as_slice().iter().enumerate() {
            if last < panel.start {
                break;
            }
            if first > panel.end {
                place = 2 * k as i32 + 1;
            } else if first >= panel.start && last <= panel.end {
                place = 2 * k as i32;
                view.x = panel.variable(tau);
                break;
            } else {
                return self.look_one_by_one(k, tau, view);
            }
        }
        view.span = (place, place);
    }

    /// As [`look`](Self::look) for times of different places, the first of them not after panel
    /// `first`.
    #[inline(always)]
    fn look_one_by_one(&self, first: usize, tau: &[f64; M], view: &mut View<M>) {
        view.place = [2.0 * first as f64 - 1.0; M];
        for (k, panel) in self.as_slice().iter().enumerate().skip(first) {
            if tau[M - 1] < panel.start {
                break;
            }
            let place = 2.0 * k as f64;
            for j in 0..M {
                view.place[j] = if tau[j] > panel.end { place + 1.0 } else { view.place[j] };
            }
            if tau[0] <= panel.end {
                let x = panel.variable(tau);
                for j in 0..M {
                    let inside = tau[j] >= panel.start && tau[j] <= panel.end;
                    view.place[j] = if inside { place } else { view.place[j] };
                    view.x[j] = if inside { x[j] } else { view.x[j] };
                }
            }
        }
        view.span = (view.place[0] as i32, view.place[M - 1] as i32);
    }

    /// Adds `int_0^t K(t - s) f(s) ds` at the nodes of a panel of a neighbour. The part that is one
    /// path for all nodes goes to `path`, the rest to `out`. Returns the number of places that the
    /// nodes lie in, for the count of work.
    #[inline(always)]
    pub(super) fn act(&self, panel: &mut Panel<M, S>, side: usize, path: &mut [Path; S], out: &mut [f64; M]) -> u64 {
        let Panel { tau, lag, cos, sin, views, .. } = panel;
        let view = &mut views[side];
        if view.version != self.version {
            self.look(tau, view);
        }
        let shared = Shared::with::<S>(side);
        let (first, last) = view.span;
        if first != last {
            let times = Times { tau, lag, cos, sin };
            return if const { S == 1 } {
                self.act_in_pieces(times, view, shared, out)
            } else {
                apart(kernel!(self.act_in_pieces(times, view, shared, out)))
            };
        }
        if first < 0 {
            return 0;
        }
        let k = (first / 2) as usize;
        let inside = first % 2 == 0;
        let before = if inside { &self.list[k].before } else { self.before(k + 1) };
        for i in 0..4 {
            path[shared.mine][i] += before[shared.theirs][i];
        }
        if inside {
            let moved = self.list[k].moved_at(shared.theirs, &view.x);
            for j in 0..M {
                out[j] += moved[j];
            }
        }
        1
    }

    #[inline(always)]
    fn act_in_pieces(&self, times: Times<'_, M, S>, view: &View<M>, shared: Shared, out: &mut [f64; M]) -> u64 {
        let Shared { theirs, mine } = shared;
        let (first, last) = view.span;
        let mut pieces = 0;
        for place in first.max(0)..=last {
            let k = (place / 2) as usize;
            let (path, moved) = if place % 2 == 0 {
                (&self.list[k].before, self.list[k].moved_at(theirs, &view.x))
            } else if view.place.contains(&f64::from(place)) {
                (self.before(k + 1), [0.0; M])
            } else {
                continue;
            };
            for j in 0..M {
                let value = times.along_side(&path[theirs], mine, j) + moved[j];
                out[j] += if view.place[j] == f64::from(place) { value } else { 0.0 };
            }
            pieces += 1;
        }
        pieces
    }

    /// Adds `weight int_0^t K(t - s) f(s) ds` at ascending times.
    #[inline(always)]
    pub(crate) fn influence<const L: usize>(
        &self,
        times: Times<'_, L, S>,
        Shared { theirs, mine }: Shared,
        weight: f64,
        out: &mut [f64; L],
    ) {
        let (first, last) = (times.tau[0], times.tau[L - 1]);
        for k in 0..self.len {
            let panel = &self.list[k];
            if last < panel.start {
                return;
            }
            let next = if k + 1 < self.len { self.list[k + 1].start } else { f64::INFINITY };
            if first >= next {
                continue;
            }
            let after = &self.before(k + 1)[theirs];
            let mut value = [0.0; L];
            for j in 0..L {
                value[j] = times.along_side(after, mine, j);
            }
            if first <= panel.end {
                let moved = panel.moved(theirs, times.tau);
                for j in 0..L {
                    let inside = times.along_side(&panel.before[theirs], mine, j) + moved[j];
                    value[j] = if times.tau[j] <= panel.end { inside } else { value[j] };
                }
            }
            for j in 0..L {
                let here = times.tau[j] >= panel.start && times.tau[j] < next;
                out[j] += if here { weight * value[j] } else { 0.0 };
            }
        }
    }

    /// Adds the displacements by the bond's own forces on all of its sides, times `weight`, at
    /// ascending times.
    #[inline(always)]
    pub(crate) fn own_influence<const L: usize>(&self, times: Times<'_, L, S>, weight: f64, out: &mut [f64; L]) {
        for side in 0..S {
            self.influence(times, Shared::own(side), weight, out);
        }
    }

    /// [`influence`](Self::influence) at the nodes of a panel.
    #[inline(always)]
    pub(crate) fn influence_at_nodes(&self, times: Times<'_, M, S>, shared: Shared, weight: f64, out: &mut [f64; M]) {
        if const { S == 1 } {
            self.influence(times, shared, weight, out);
        } else {
            apart(kernel!(self.influence(times, shared, weight, out)));
        }
    }

    /// [`own_influence`](Self::own_influence) at the nodes of a panel.
    #[inline(always)]
    pub(crate) fn own_influence_at_nodes(&self, times: Times<'_, M, S>, weight: f64, out: &mut [f64; M]) {
        for side in 0..S {
            self.influence_at_nodes(times, Shared::own(side), weight, out);
        }
    }
}
