//! The panels of a bond in a window, and what their forces move in its neighbours.

use super::{
    panel::{FOUR, Origin, Panel, View, along, four, four_along, put, summed},
    system::Path,
};
use crate::vector::Vector;

#[derive(Clone, Debug)]
pub(crate) struct Panels<const M: usize> {
    pub(crate) list: Vec<Panel<M>>,
    pub(crate) len: usize,
    /// Changes whenever panels are laid out.
    pub(crate) version: u64,
    /// The path that the whole window leaves behind.
    pub(crate) total: Path,
}

impl<const M: usize> Panels<M> {
    pub(crate) fn new() -> Self {
        Self { list: Vec::new(), len: 0, version: 0, total: [0.0; 4] }
    }

    #[inline(always)]
    pub(super) fn clear(&mut self) {
        (self.len, self.total) = (0, [0.0; 4]);
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

    pub(crate) fn as_slice(&self) -> &[Panel<M>] {
        &self.list[..self.len]
    }

    /// The path left behind when panel `k` starts.
    #[inline(always)]
    pub(crate) fn before(&self, k: usize) -> &Path {
        if k < self.len { &self.list[k].before } else { &self.total }
    }

    /// Where ascending times are among these panels.
    #[inline(always)]
    fn look<V: Vector<f64>>(&self, tau: &[f64; M], view: &mut View<M>) {
        view.version = self.version;
        let (mut first, mut last) = (-1, -1);
        for (k, panel) in self.as_slice().iter().enumerate() {
            let place = |t: f64, before: i32| {
                if t > panel.end {
                    2 * k as i32 + 1
                } else if t >= panel.start {
                    2 * k as i32
                } else {
                    before
                }
            };
            (first, last) = (place(tau[0], first), place(tau[M - 1], last));
        }
        (view.first, view.last) = (first, last);
        if first != last {
            self.look_one_by_one(tau, view);
        } else if first >= 0 && first % 2 == 0 {
            self.list[(first / 2) as usize].variables::<V>(tau, &mut view.x);
        }
    }

    /// The places of times that are not all the same.
    #[inline(never)]
    fn look_one_by_one(&self, tau: &[f64; M], view: &mut View<M>) {
        view.place = [-1.0; M];
        for (k, panel) in self.as_slice().iter().enumerate() {
            let place = 2.0 * k as f64;
            for j in 0..M {
                if tau[j] > panel.end {
                    view.place[j] = place + 1.0;
                } else if tau[j] >= panel.start {
                    view.place[j] = place;
                    [view.x[j]] = panel.variable(&[tau[j]]);
                }
            }
        }
    }

    /// How these panels act on a panel of a neighbour.
    #[inline(always)]
    pub(super) fn act<V: Vector<f64>>(&self, panel: &mut Panel<M>, side: usize) -> Act<'_, M> {
        let Panel { tau, views, .. } = panel;
        let view = &mut views[side];
        if view.version != self.version {
            self.look::<V>(tau, view);
        }
        let k = (view.first / 2) as usize;
        if view.first != view.last {
            Act::Pieces
        } else if view.first < 0 {
            Act::Nothing
        } else if view.first % 2 == 0 {
            Act::Inside(&self.list[k].before, &self.list[k].series)
        } else {
            Act::Along(self.before(k + 1))
        }
    }

    /// Adds `int_0^t K(t - s) f(s) ds` at the nodes of a panel of a neighbour, which are in several
    /// of these panels, or between them. Returns in how many pieces.
    #[inline(always)]
    pub(super) fn add_pieces<V: Vector<f64>>(&self, panel: &Panel<M>, side: usize, out: &mut [f64; M]) -> u64 {
        let view = &panel.views[side];
        let mut pieces = 0;
        for place in view.first.max(0)..=view.last {
            let k = (place / 2) as usize;
            let number = f64::from(place);
            if place % 2 != 0 && !view.place.contains(&number) {
                continue;
            }
            let (path, inside) =
                if place % 2 == 0 { (&self.list[k].before, true) } else { (self.before(k + 1), false) };
            for j in (0..M).step_by(FOUR) {
                let mut value = four_along::<V>(path, four(&panel.tau, j), four(&panel.cos, j), four(&panel.sin, j));
                if inside {
                    value = value + summed(&self.list[k].series, four::<V, M>(&view.x, j));
                }
                let here = four::<V, M>(&view.place, j).equal(number, value);
                put(out, j, four::<V, M>(out, j) + here);
            }
            pieces += 1;
        }
        pieces
    }

    /// Adds `weight int_0^t K(t - s) f(s) ds` at ascending times.
    #[inline(always)]
    pub(crate) fn influence<const L: usize>(
        &self,
        (tau, cos, sin): (&[f64; L], &[f64; L], &[f64; L]),
        weight: f64,
        out: &mut [f64; L],
    ) {
        let (first, last) = (tau[0], tau[L - 1]);
        for k in 0..self.len {
            let panel = &self.list[k];
            if last < panel.start {
                return;
            }
            let next = if k + 1 < self.len { self.list[k + 1].start } else { f64::INFINITY };
            if first >= next {
                continue;
            }
            let after = self.before(k + 1);
            let mut value = [0.0; L];
            for j in 0..L {
                value[j] = along(after, tau[j], cos[j], sin[j]);
            }
            if first <= panel.end {
                let moved = panel.moved(tau);
                for j in 0..L {
                    let inside = along(&panel.before, tau[j], cos[j], sin[j]) + moved[j];
                    value[j] = if tau[j] <= panel.end { inside } else { value[j] };
                }
            }
            for j in 0..L {
                let here = tau[j] >= panel.start && tau[j] < next;
                out[j] += if here { weight * value[j] } else { 0.0 };
            }
        }
    }
}

/// How the forces of a bond act on a panel of a neighbour.
#[derive(Clone, Copy, Debug)]
pub(super) enum Act<'a, const M: usize> {
    /// Not yet.
    Nothing,
    /// By the path that panels before have left behind.
    Along(&'a Path),
    /// By that path, and by the series of the panel that all nodes are in.
    Inside(&'a Path, &'a [f64; M]),
    /// Not in the same way on all nodes.
    Pieces,
}
