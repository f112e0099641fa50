//! Contacts that dissipate: the rates of overlaps that their forces depend on. Their laws are those
//! of [`BondLaw`](crate::law::BondLaw).
//!
//! | symbol | meaning |
//! |---|---|
//! | `F(g)` | elastic force, `A (g)_+^alpha` |
//! | `c(g)` | resistance: `gamma F'(g)`, `gamma g^beta` or `gamma F(g)` |
//! | `f = (F(g) + c(g) g')_+` | force of a contact: beads never pull |
//! | `P(g, g')` | positive where a closed contact pushes: `g + gamma alpha g'`, `g (1 + gamma g')`, or `g` less |
//! | | `(-gamma g'/A)_+^{1/(alpha - beta)}`; `g` where beads may pull |
//! | `K'` | velocity of a site by a unit impulse |
//!
//! A panel of such a contact needs `g'` at its nodes, `g_lin'(t) + int K'(t - s) [..] ds`, where
//! `[..]` are the forces on both sites. The part by the forces of neighbours is evaluated from
//! series, as for overlaps. The part by the panel's own forces is solved for: with the matrix `T`
//! of `int K'` at the nodes, `f + c T f = F + c r`, where `r` is the rate without these forces. So
//! sweeps contract like those of elastic contacts, however strong the resistance is.
//!
//! On a panel the force has no `(..)_+`. Where `P` comes to zero the contact ends, with `f = 0` and
//! `g > 0`, and beads overlap without a force until `P` rises through zero or the overlap is zero
//! (`dissipative.rs`). So the force is analytic up to the end. Where beads meet it begins with the
//! power `alpha - 1` of time (viscoelastic), or with a jump (dashpot). Where beads may pull, it
//! ends as it begins.
//!
//! `P` is an overlap. For a dashpot the force itself has the same sign, but with a small `gamma` it
//! ends with next to no slope, and Newton's method for its zero diverges; with a large one that for
//! the zero of `P` does.

use super::{
    bond::Beside,
    chain::Path,
    kernels::apart,
    link::Link,
    motion::Rotation,
    panel::{Frame, Panel, Rates, View},
    panels::{Panels, Shared},
    prescribed::Prescribed,
    rule::Rule,
    series::{dot, product, times, value},
};
use crate::kernel;

impl<const S: usize> Link<S> {
    /// The factors of `v`, `c` and `s` of a path in the velocity of the site on a side, at `L`
    /// times.
    pub(crate) fn velocity<const L: usize>(
        &self,
        side: usize,
        t: &[f64; L],
        cos: &[f64; L],
        sin: &[f64; L],
    ) -> [[f64; L]; 3] {
        if let Some(flow) = self.flow(side) {
            return flow.velocity(t);
        }
        let omega = self.sides[side].omega;
        if omega == 0.0 {
            return [[1.0; L], [0.0; L], [0.0; L]];
        }
        [[1.0; L], sin.map(|sin| -omega * sin), cos.map(|cos| omega * cos)]
    }

    /// `K(t)` on a side: the velocity by a unit force that acts from time 0.
    pub(crate) fn ramp(&self, side: usize, t: f64, turned: Rotation) -> f64 {
        if self.flow(side).is_some() {
            return turned.ramps[0];
        }
        let kernel = &self.sides[side];
        let swing = if kernel.omega == 0.0 { kernel.mu * t } else { kernel.mu_per_omega * turned.sin };
        kernel.m * t + swing
    }
}

impl<const M: usize, const S: usize> Panel<M, S> {
    /// Computes the kernels for rates, after the nodes are placed.
    pub(super) fn place_rates(&mut self, frame: &Frame<'_, M, S>, known: Option<&Prescribed>) {
        apart(kernel!({
            let Frame { rule, link, .. } = frame;
            let mut rates = self.rates.take().unwrap_or_else(|| Box::new(Rates::new()));
            rates.known = known.map_or([0.0; M], |known| known.rates_at(&self.tau));
            (rates.overlap, rates.lost) = ([0.0; M], [0.0; M]);
            for side in 0..S {
                rates.velocity[side] = link.velocity(side, &self.tau, &self.cos[side], &self.sin[side]);
                for k in 0..M {
                    let path = self.left[k][side].map(|part| part / rule.weights[k]);
                    let kernel = std::array::from_fn(|j| rates.along_side(&path, side, j));
                    rates.reaction[side][k] = times(&rule.integral[k], &kernel);
                }
            }
            self.rates = Some(rates);
        }));
    }

    /// Computes the velocities by the force, as series.
    pub(super) fn integrate_rates(&mut self, rule: &Rule<M>) {
        apart(kernel!(if let Self { rates: Some(rates), force, .. } = self {
            for side in 0..S {
                rates.series[side] = product(&rule.series, &product(&rates.reaction[side], force));
            }
        }));
    }

    /// Computes the forces from the overlaps `g`, with their rates. The first of the paths is the
    /// linear path and those parts by other panels that are one path for all nodes. The second is
    /// the path by earlier panels of the bond, or zero if the first includes it.
    pub(super) fn resist(
        &mut self,
        frame: &Frame<'_, M, S>,
        beside: [Beside<M, S>; 2],
        [path, earlier]: [&[Path; S]; 2],
        g: &[f64; M],
    ) -> [f64; M] {
        apart(kernel!({
            let Self { rates, views, .. } = self;
            let rates = rates.as_deref_mut().expect("a panel of a contact that dissipates has rates");
            let mut rate = rates.along(path);
            for side in 0..S {
                for j in 0..M {
                    rate[j] -= rates.along_side(&earlier[side], side, j);
                }
            }
            for (side, bond) in beside.into_iter().enumerate() {
                if let Some(bond) = bond {
                    bond.panels.move_along(&views[side], rates, Shared::with::<S>(side), &mut rate);
                }
            }
            let elastic = frame.link.forces(g);
            // On a panel, also where the series of neighbours take an overlap below zero.
            let resistance = g.map(|g| frame.link.law.resistance(g));
            let mut own = [[0.0; M]; M];
            for side in 0..S {
                for k in 0..M {
                    for j in 0..M {
                        own[k][j] += rates.reaction[side][k][j];
                    }
                }
            }
            let mut force = [0.0; M];
            for j in 0..M {
                force[j] = resistance[j].mul_add(rate[j], elastic[j]);
            }
            let mut matrix = own;
            for k in 0..M {
                for j in 0..M {
                    matrix[k][j] = resistance[j] * own[k][j];
                }
                matrix[k][k] += 1.0;
            }
            solve(&mut matrix, &mut force);
            let answer = product(&own, &force);
            for j in 0..M {
                rates.overlap[j] = rate[j] - answer[j];
                rates.lost[j] = force[j] - elastic[j];
            }
            force
        }))
    }

    /// `P` at the start (`end = 0`) or the end of the panel, from its values at the nodes, and its
    /// slope there. That of a dashpot has a kink where the rate is zero, so that overlap and rate
    /// are extrapolated instead. Where the resistance changes faster than the elastic force, `P`
    /// goes like a root of the time from its zero, and the force is the function that is nearly
    /// linear: then it is taken, over a stiffness.
    #[inline(never)]
    pub(super) fn pushes(&self, frame: &Frame<'_, M, S>, end: usize) -> (f64, f64) {
        let rates = self.rates.as_deref().expect("a panel of a contact that dissipates has rates");
        let (law, ends) = (&frame.link.law, &frame.rule.ends[end]);
        let from = |k: usize| if end == 0 { k } else { M - 1 - k };
        let chord = |values: &[f64; M]| self.chord(values, from(0), (1..M).map(from));
        let pushes: [f64; M] = std::array::from_fn(|j| law.overlap_that_pushes(self.overlap[j], rates.overlap[j]));
        if !law.kinked() {
            return (dot(ends, &pushes), chord(&pushes));
        }
        let (g, rate) = (dot(ends, &self.overlap), dot(ends, &rates.overlap));
        let resists = law.resistance(g) * chord(&rates.overlap).abs();
        let per = 1.0 / law.stiffness(self.overlap.into_iter().fold(0.0, f64::max));
        if resists > law.stiffness(g) * rate.abs() && per.is_finite() {
            return (dot(ends, &self.force) * per, chord(&self.force) * per);
        }
        (law.overlap_that_pushes(g, rate), chord(&pushes))
    }

    /// The predicted forces at the nodes, from predicted overlaps `g`: these are a path plus a
    /// polynomial with the coefficients of `t^2`, `t^3` and `t^4`, which give their rates.
    #[inline(never)]
    pub(super) fn resist_ahead(
        &self,
        frame: &Frame<'_, M, S>,
        (path, [a, b, c]): (&[Path; S], [f64; 3]),
        g: &[f64; M],
    ) -> [f64; M] {
        let rates = self.rates.as_deref().expect("a panel of a contact that dissipates has rates");
        let along = rates.along(path);
        std::array::from_fn(|j| {
            let t = self.tau[j];
            let driven = t * (2.0 * a + t * (3.0 * b + t * 4.0 * c));
            frame.link.law.force(g[j], along[j] + driven)
        })
    }
}

/// The tangent map, see `tangent.rs`.
impl<const M: usize, const S: usize> Panel<M, S> {
    /// `F'(g)` at the nodes.
    #[inline(always)]
    pub(super) fn stiffness(&self, link: &Link<S>) -> [f64; M] {
        self.overlap.map(|g| if g > 0.0 { link.stiffness(g) } else { 0.0 })
    }
}

/// Solves a linear system by Gauss-Jordan elimination; the matrix is given by columns. There is no
/// pivoting, since the diagonal is at least 1 and other entries are small.
#[inline(always)]
pub fn solve<const M: usize>(columns: &mut [[f64; M]; M], x: &mut [f64; M]) {
    for p in 0..M {
        let per = 1.0 / columns[p][p];
        let mut factor = columns[p].map(|a| a * per);
        factor[p] = 0.0;
        for k in p + 1..M {
            let row = columns[k][p];
            for j in 0..M {
                columns[k][j] = factor[j].mul_add(-row, columns[k][j]);
            }
        }
        let row = x[p];
        for j in 0..M {
            x[j] = factor[j].mul_add(-row, x[j]);
        }
    }
    for p in 0..M {
        x[p] /= columns[p][p];
    }
}

impl<const M: usize, const S: usize> Panels<M, S> {
    /// Adds the velocities by these panels at the nodes of a panel of a neighbour, which sees them
    /// by `view`; without the part that is one path for all nodes.
    #[inline(always)]
    fn move_along(&self, view: &View<M>, of: &Rates<M, S>, Shared { theirs, mine }: Shared, out: &mut [f64; M]) {
        let inside = |k: usize| {
            let rates = self.list[k].rates.as_deref().expect("panels beside contacts that dissipate have rates");
            value(&rates.series[theirs], &view.x)
        };
        let (first, last) = view.span;
        if first == last {
            if first >= 0 && first % 2 == 0 {
                let moved = inside((first / 2) as usize);
                for j in 0..M {
                    out[j] += moved[j];
                }
            }
            return;
        }
        for place in first.max(0)..=last {
            let k = (place / 2) as usize;
            let (path, moved) =
                if place % 2 == 0 { (&self.list[k].before, inside(k)) } else { (self.before(k + 1), [0.0; M]) };
            for j in 0..M {
                let velocity = of.along_side(&path[theirs], mine, j) + moved[j];
                out[j] += if view.place[j] == f64::from(place) { velocity } else { 0.0 };
            }
        }
    }

    /// `int_0^t K'(t - s) f(s) ds` at a time; `velocity` are the factors of `v`, `c` and `s` of a
    /// path in the velocity at that time.
    pub(crate) fn velocity_at(&self, t: f64, velocity: &[[f64; 1]; 3], theirs: usize) -> f64 {
        let along = |path: &Path| path[1] * velocity[0][0] + path[2] * velocity[1][0] + path[3] * velocity[2][0];
        let panels = self.as_slice();
        let begun = panels.partition_point(|panel| panel.start <= t);
        let Some(k) = begun.checked_sub(1) else { return 0.0 };
        if t > panels[k].end {
            return along(&self.before(k + 1)[theirs]);
        }
        let rates = panels[k].rates.as_deref().expect("panels beside contacts that dissipate have rates");
        let [moved] = value(&rates.series[theirs], &panels[k].variable(&[t]));
        along(&panels[k].before[theirs]) + moved
    }
}
