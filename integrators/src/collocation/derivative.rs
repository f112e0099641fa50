//! The derivative of a solved window: the changes of the paths by the forces of bonds by those of
//! their linear paths, for [`Tangent`](super::Tangent), see `tangent.rs`.

use super::{
    bond::Bond,
    chain::{Path, beside},
    panel::{Frames, Panel},
    panels::{Panels, Shared},
    series::{dot, product},
};
use crate::{real::Vector, with_narrow};

/// Number of columns that are computed together: one register of the widest vector unit. Timed by
/// `benches/collocation.rs`, `monodromy`.
pub(super) const LANES: usize = 8;
pub(super) type Lanes = [f64; LANES];

/// Paths of the changes of overlaps on each side of every bond, for some columns.
pub(crate) type BondBlock<const S: usize> = Vec<[[Lanes; 4]; S]>;

/// Number of sweeps after which a window is given up; each gains at least a digit where the window
/// itself was solved.
const MOST_SWEEPS: u32 = 100;

/// The rows of one panel in `df = D (dg_lin + T df)`. Matrices are kept by columns, and are
/// multiplied by `G D`.
struct Row<const M: usize> {
    bond: usize,
    /// `D`.
    stiffness: [f64; M],
    /// `G D` times the functions 1, `t + lag`, `cos` and `sin` of a linear path at the nodes, for
    /// each side.
    path: Vec<[f64; M]>,
    /// `G D T` for each other panel that acts on this one, with the index of that panel.
    from: Vec<(usize, [[f64; M]; M])>,
}

/// Replaces the changes of the linear paths of the bonds of a solved window by those of the paths
/// by the bonds' forces. If the sweeps do not converge, a bond and its residual.
#[inline(always)]
pub(crate) fn window<const M: usize, const S: usize>(
    frames: &Frames<'_, M, S>,
    bonds: &[Bond<M, S>],
    columns: &mut [BondBlock<S>],
) -> Result<(), (usize, f64)> {
    let ring = frames.links.ring && bonds.len() > 1;
    let bonds = &laid_out(frames, bonds, ring)[..];
    let (rows, left) = rows(frames, bonds, ring);
    let mut memory = Memory { driven: vec![[[0.0; LANES]; M]; rows.len()], force: vec![[[0.0; LANES]; M]; rows.len()] };
    for bond in columns {
        let path = bond.as_flattened().as_flattened();
        System { rows: &rows, path, memory: &mut memory }.solve()?;
        bond.fill([[[0.0; LANES]; 4]; S]);
        for ((row, left), force) in rows.iter().zip(&left).zip(&memory.force) {
            for (left, force) in left.iter().zip(force) {
                for (sum, &left) in bond[row.bond].as_flattened_mut().iter_mut().zip(left.as_flattened()) {
                    add(sum, left, force);
                }
            }
        }
    }
    Ok(())
}

#[inline(always)]
pub(super) fn add(to: &mut Lanes, by: f64, values: &Lanes) {
    for lane in 0..LANES {
        to[lane] = by.mul_add(values[lane], to[lane]);
    }
}

/// The bonds of a solved window, with the ends of their panels where the contacts of its solution
/// begin and end, and the overlaps at their nodes.
#[inline(always)]
fn laid_out<const M: usize, const S: usize>(
    frames: &Frames<'_, M, S>,
    bonds: &[Bond<M, S>],
    ring: bool,
) -> Vec<Bond<M, S>> {
    let n = bonds.len();
    let mut anew = bonds.to_vec();
    for bond in &mut anew {
        for contact in &mut bond.contacts.found {
            let panels = &bond.panels.list[contact.panels.0..contact.panels.1];
            let (Some(first), Some(last)) = (panels.first(), panels.last()) else { continue };
            // One more step of Newton's method, if it is short: at grazing contacts the slope is
            // near zero.
            let newton = |panel: &Panel<M, S>, end: usize| {
                let by = -dot(&frames.rule.ends[end], &panel.overlap) / contact.slopes[end];
                let reach = 0.1 * (panel.end - panel.start);
                if by.abs() <= reach { by } else { 0.0 }
            };
            let (onset, release) = (newton(first, 0), newton(last, 1));
            if contact.onset >= 0.0 {
                contact.onset = (contact.onset + onset).max(0.0);
            }
            if contact.release <= frames.h {
                contact.release = (contact.release + release).min(frames.h);
            }
        }
    }
    // No closure here: the instruction set would not reach into it.
    let (mut old, mut out) = (Panels::new(), Vec::with_capacity(n));
    for b in 0..n {
        let beside = beside(b, n, ring);
        let mut me = anew[b].clone();
        me.lay_out(&frames.of(b), beside.map(|b| b.map(|b| &anew[b])), &mut old);
        for panel in &mut me.panels.list[..me.panels.len] {
            let at = panel.times();
            let mut g = [0.0; M];
            for (j, g) in g.iter_mut().enumerate() {
                *g = at.along(&me.initial.path, j);
            }
            bonds[b].panels.own_influence_at_nodes(at, -me.initial.own(), &mut g);
            for (k, b) in beside.into_iter().enumerate() {
                if let Some(b) = b {
                    bonds[b].panels.influence_at_nodes(at, Shared::with::<S>(k), 1.0, &mut g);
                }
            }
            if S != 1 && (frames.links.link(b).lags || me.known.is_some()) {
                g = panel.besides(me.known.is_some(), me.initial.path, g);
            }
            panel.overlap = g;
        }
        out.push(me);
    }
    out
}

/// The paths by unit forces at the nodes of a panel, after the panel.
type Traces<const M: usize, const S: usize> = [[Path; S]; M];

/// The linear system of a window, with influences computed from unit forces at the nodes, and the
/// paths by these unit forces.
#[inline(always)]
fn rows<const M: usize, const S: usize>(
    frames: &Frames<'_, M, S>,
    bonds: &[Bond<M, S>],
    ring: bool,
) -> (Vec<Row<M>>, Vec<Traces<M, S>>) {
    let n = bonds.len();
    let (mut rows, mut all, mut traces, mut first) = (Vec::new(), Vec::new(), Vec::new(), vec![0]);
    for (b, bond) in bonds.iter().enumerate() {
        for panel in bond.panels.as_slice() {
            let stiffness = panel.stiffness(frames.links.link(b));
            let scaled = |by: &[f64; M]| std::array::from_fn(|j| stiffness[j] * by[j]);
            let side = |k: usize| {
                let free = std::array::from_fn(|j| panel.tau[j] + panel.lag[k][j]);
                [stiffness, scaled(&free), scaled(&panel.cos[k]), scaled(&panel.sin[k])]
            };
            let path = (0..S).flat_map(side).collect();
            rows.push(Row { bond: b, stiffness, path, from: Vec::new() });
            all.push(panel);
        }
        first.push(rows.len());
    }
    let mut source = Panels { list: vec![Panel::new()], len: 1, version: 0, total: [[0.0; 4]; S] };
    for q in 0..rows.len() {
        let b = rows[q].bond;
        source.list[0].clone_from(all[q]);
        source.list[0].before = [[0.0; 4]; S];
        let start = source.list[0].start;
        let [left, right] = beside(b, n, ring);
        // The bond before sees this one as its neighbour after it (1), the bond after as that
        // before it (0).
        let own = (Some(b), None, -bonds[b].initial.own());
        let targets: Vec<(usize, Option<usize>, f64)> = [own, (left, Some(1), 1.0), (right, Some(0), 1.0)]
            .into_iter()
            .filter_map(|(b, seen, weight)| Some((b?, seen, weight)))
            .flat_map(|(b, seen, weight)| (first[b]..first[b + 1]).map(move |p| (p, seen, weight)))
            .filter(|&(p, ..)| all[p].end > start)
            .collect();
        for &(p, ..) in &targets {
            rows[p].from.push((q, [[0.0; M]; M]));
        }
        for l in 0..M {
            source.list[0].force = [0.0; M];
            source.list[0].force[l] = 1.0;
            source.total = source.list[0].integrate(&frames.of(b));
            for &(p, seen, weight) in &targets {
                let (row, times) = (&mut rows[p], all[p].times());
                let mut out = [0.0; M];
                match seen {
                    Some(k) => source.influence_at_nodes(times, Shared::with::<S>(k), weight, &mut out),
                    None => source.own_influence_at_nodes(times, weight, &mut out),
                }
                let Some((_, matrix)) = row.from.last_mut() else { continue };
                for j in 0..M {
                    matrix[l][j] += row.stiffness[j] * out[j];
                }
            }
        }
        traces.push(source.list[0].left);
    }
    for (p, row) in rows.iter_mut().enumerate() {
        let Some(own) = row.from.iter().position(|&(q, _)| q == p) else { continue };
        let answer = answer(row.from.swap_remove(own).1);
        for column in row.path.iter_mut().chain(row.from.iter_mut().flat_map(|(_, matrix)| matrix)) {
            *column = product(&answer, column);
        }
    }
    (rows, traces)
}

/// `(I - A)^{-1}`, by elimination with pivots.
#[inline(always)]
fn answer<const M: usize>(a: [[f64; M]; M]) -> [[f64; M]; M] {
    let unit = |k: usize| std::array::from_fn(|j| f64::from(u8::from(j == k)));
    let mut inverse: [[f64; M]; M] = std::array::from_fn(unit);
    let mut rest: [[f64; M]; M] = std::array::from_fn(|k| std::array::from_fn(|j| inverse[k][j] - a[k][j]));
    // The arrays are columns, so that this eliminates in the transpose; the inverse is the same.
    for k in 0..M {
        let larger = |i: &usize, j: &usize| rest[*i][k].abs().total_cmp(&rest[*j][k].abs());
        let pivot = (k..M).max_by(larger).unwrap_or(k);
        rest.swap(k, pivot);
        inverse.swap(k, pivot);
        let scale = 1.0 / rest[k][k];
        for column in [&mut rest[k], &mut inverse[k]] {
            column.iter_mut().for_each(|entry| *entry *= scale);
        }
        let (rest_k, inverse_k) = (rest[k], inverse[k]);
        for i in (0..M).filter(|&i| i != k) {
            let by = rest[i][k];
            for j in 0..M {
                rest[i][j] -= by * rest_k[j];
                inverse[i][j] -= by * inverse_k[j];
            }
        }
    }
    inverse
}

/// Memory for the solution of a [`System`]: for each panel the changes of forces at its nodes,
/// without the influence of other panels (`driven`) and with it (`force`).
struct Memory<const M: usize> {
    driven: Vec<[Lanes; M]>,
    force: Vec<[Lanes; M]>,
}

/// The numbers of columns from `at` on, in a register.
#[inline(always)]
fn part<V: Vector<f64>>(columns: &Lanes, at: usize) -> V {
    let columns = &columns[at..at + V::LANES];
    // SAFETY: the slice has `V::LANES` numbers.
    unsafe { V::load(columns.as_ptr()) }
}

#[inline(always)]
fn put<V: Vector<f64>>(columns: &mut Lanes, at: usize, values: V) {
    let columns = &mut columns[at..at + V::LANES];
    // SAFETY: the slice has `V::LANES` numbers.
    unsafe { values.store(columns.as_mut_ptr()) }
}

/// For each column, the largest change of a force by a sweep, and the largest force.
struct Progress {
    change: Lanes,
    size: Lanes,
}

/// `df = D (dg_lin + T df)` for some columns.
struct System<'a, const M: usize> {
    rows: &'a [Row<M>],
    /// Changes of the linear paths of all sides of all bonds.
    path: &'a [Lanes],
    memory: &'a mut Memory<M>,
}

impl<const M: usize> System<'_, M> {
    /// Solves the system by sweeps over the panels. If they do not converge, a bond and its
    /// residual. Not inlined, so that it is compiled once for all kinds of windows.
    #[inline(never)]
    fn solve(mut self) -> Result<(), (usize, f64)> {
        with_narrow!(V => self.sweeps::<V>())
    }

    /// Computes the forces of a panel without the influence of other panels.
    #[inline(always)]
    fn drive<V: Vector<f64>>(&mut self, p: usize) {
        let (row, driven) = (&self.rows[p], &mut self.memory.driven[p]);
        let sides = row.path.len();
        let paths = &self.path[row.bond * sides..][..sides];
        for at in (0..LANES).step_by(V::LANES) {
            for j in 0..M {
                let mut sum = V::all(0.0);
                for (function, path) in row.path.iter().zip(paths) {
                    sum = V::all(function[j]).fused(part(path, at), sum);
                }
                put(&mut driven[j], at, sum);
            }
        }
    }

    /// Sweeps over a panel.
    #[inline(always)]
    fn sweep<V: Vector<f64>>(&mut self, p: usize, progress: &mut Progress) {
        let Memory { driven, force } = &mut *self.memory;
        for at in (0..LANES).step_by(V::LANES) {
            // No closures here: the instruction set would not reach into them.
            let mut sums = [V::one(); M];
            for j in 0..M {
                sums[j] = part(&driven[p][j], at);
            }
            for (q, matrix) in &self.rows[p].from {
                for (column, there) in matrix.iter().zip(&force[*q]) {
                    let there = part::<V>(there, at);
                    for j in 0..M {
                        sums[j] = V::all(column[j]).fused(there, sums[j]);
                    }
                }
            }
            let (mut change, mut size): (V, V) = (part(&progress.change, at), part(&progress.size, at));
            for j in 0..M {
                // Not a number counts as large.
                change = (sums[j] - part(&force[p][j], at)).size().larger(change);
                size = size.larger(sums[j].size());
                put(&mut force[p][j], at, sums[j]);
            }
            put(&mut progress.change, at, change);
            put(&mut progress.size, at, size);
        }
    }

    #[inline(always)]
    fn sweeps<V: Vector<f64>>(&mut self) -> Result<(), (usize, f64)> {
        let none = || Progress { change: [0.0; LANES], size: [0.0; LANES] };
        for p in 0..self.rows.len() {
            self.drive::<V>(p);
        }
        self.memory.force.copy_from_slice(&self.memory.driven);
        let mut last = [f64::INFINITY; LANES];
        for _ in 0..MOST_SWEEPS {
            let mut progress = none();
            for p in 0..self.rows.len() {
                self.sweep::<V>(p, &mut progress);
            }
            let Progress { change, size } = progress;
            // By an estimate of the next change: sweeps contract at least as fast as before.
            let settled = |lane: usize| {
                let (by, before) = (change[lane], last[lane]);
                let rounding = f64::EPSILON * size[lane];
                by <= rounding || by * (by / before) <= 0.1 * rounding && before < f64::INFINITY
            };
            if (0..LANES).all(settled) {
                return Ok(());
            }
            last = change;
        }
        // One more sweep, to find the bond with the largest change.
        let mut worst = (0, 0.0);
        for p in 0..self.rows.len() {
            let mut progress = none();
            self.sweep::<V>(p, &mut progress);
            let most = progress.change.iter().fold(0.0, |most: f64, &by| if by <= most { most } else { by });
            if most > worst.1 || most.is_nan() {
                worst = (self.rows[p].bond, most);
            }
        }
        Err(worst)
    }
}
