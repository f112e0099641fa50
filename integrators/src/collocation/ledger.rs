//! The ledger of a chain: the energies that drag, dashpots and contacts dissipate, and the work of
//! drives, integrated over each window.

use super::{
    bond::Bond,
    chain::Path,
    flow::Flow,
    kernels::apart,
    open::Open,
    panels::Panels,
    rule::Rule,
    series::{dot, product, times},
    sites::Bonds,
};
use crate::kernel;

/// Number of nodes of a quadrature between two ends of panels.
const NODES: usize = 12;

/// While a force acts on the site, windows longer than the share `RESOLVED` of the longest one are
/// cut into `PARTS` parts for the quadrature. Chosen; `methods
/// energy_dissipated_and_driven_balance` measures what it gives.
const RESOLVED: f64 = 0.3;
const PARTS: u32 = 4;

impl Open {
    /// The gains of the ledger in a window, of the sites that are computed with a bond; `next` are
    /// the panels of the bond after it.
    pub(crate) fn gains_beside<const M: usize, const S: usize>(
        &self,
        (bonds, h): (&dyn Bonds<S>, f64),
        bond: &Bond<M, S>,
        next: Option<&Panels<M, S>>,
    ) -> Path {
        let ([behind, before], own) = (self.kept[bond.initial.bond], Some(&bond.panels));
        let mut sum = [0.0; 4];
        for (site, panels) in [(behind, [own, next]), (before, [None, own])] {
            if let Some(site) = site {
                let gains = self.gains(bonds, h, site, panels);
                sum = std::array::from_fn(|k| sum[k] + gains[k]);
            }
        }
        sum
    }

    /// The gains of the ledger in a window of length `h`, of a site with the panels of the bonds
    /// before and after it: by quadrature between the ends of all these panels.
    ///
    /// Where a force begins or ends with a half power of time, the variable of the quadrature is
    /// `x` in `t = a + (b - a) x^2 (3 - 2 x)`, in which the force is smooth at both ends.
    pub(crate) fn gains<const M: usize, const S: usize>(
        &self,
        bonds: &dyn Bonds<S>,
        h: f64,
        site: usize,
        panels: [Option<&Panels<M, S>>; 2],
    ) -> Path {
        apart(kernel!({
            let (mut gains, drive) = ([0.0; 4], self.drive(site).map(|k| &self.drives[k]));
            let (mut y, flow) = (bonds.site(site), self.flows[site].as_deref());
            let panels = panels.map(|panels| panels.map_or(&[][..], Panels::as_slice));
            let Some(flow) = flow else {
                // A site that is moved: its contact forces are given at the nodes of the panels.
                for (panels, sign) in panels.iter().zip([1.0, -1.0]) {
                    for panel in *panels {
                        let [work, lost] = panel.work(Rule::shared(), |t| bonds.signal(site, t)[1]);
                        gains[2] -= sign * lost;
                        gains[3] -= sign * work;
                    }
                }
                return gains;
            };
            let mut from = 0.0;
            while from < h {
                let ends = panels.iter().flat_map(|panels| panels.iter().flat_map(|panel| [panel.start, panel.end]));
                let mut to = ends.filter(|&t| t > from).fold(h, f64::min);
                let middle = 0.5 * (from + to);
                let here = panels.map(|panels| panels.iter().find(|panel| panel.start < middle && middle < panel.end));
                let pushed = drive.is_some() || here.iter().any(Option::is_some);
                if pushed {
                    if h > RESOLVED * self.longest {
                        to = (1..PARTS)
                            .map(|k| h * f64::from(k) / f64::from(PARTS))
                            .filter(|&t| t > from)
                            .fold(to, f64::min);
                    }
                } else if y == [0.0; 4] {
                    from = to;
                    continue;
                }
                let part = (from, to);
                let near = here.iter().flatten().filter(|panel| panel.rates.is_some());
                let piece = match near.min_by(|a, b| a.far(middle).total_cmp(&b.far(middle))) {
                    Some(panel) => Piece::inside(part, panel.map()),
                    None => {
                        let singular = here.iter().flatten().any(|panel| panel.singular());
                        Piece::between(part, singular)
                    }
                };
                let (mut force, mut lost, mut push) = ([0.0; NODES], [0.0; NODES], [0.0; NODES]);
                for (panel, sign) in here.into_iter().zip([1.0, -1.0]) {
                    if let Some(panel) = panel {
                        let [by, by_loss] = panel.forces_at(Rule::shared(), &piece.t);
                        for j in 0..NODES {
                            force[j] += sign * by[j];
                            lost[j] += sign * by_loss[j];
                        }
                    }
                }
                if drive.is_some() {
                    for j in 0..NODES {
                        [push[j], ..] = bonds.signal(site, piece.t[j]);
                    }
                }
                piece.follow(flow, &mut y, ([&force, &lost], &push), pushed, &mut gains);
                from = to;
            }
            gains
        }))
    }
}

/// A part of a window in which the force on a site is smooth except at the ends, with the nodes of
/// a quadrature.
struct Piece {
    /// Times of the nodes.
    t: [f64; NODES],
    /// `dt/dx` at the nodes, and the weights of integrals over `t`.
    rate: [f64; NODES],
    weights: [f64; NODES],
}

impl Piece {
    /// The part from `a` to `b`; with the variable of [`Open::gains`] if the force is singular at
    /// an end.
    #[inline(always)]
    fn between((a, b): (f64, f64), singular: bool) -> Self {
        let (rule, length) = (Rule::<NODES>::shared(), b - a);
        let mut piece = Self { t: [0.0; NODES], rate: [0.0; NODES], weights: [0.0; NODES] };
        for j in 0..NODES {
            let x = 0.5 * (1.0 + rule.nodes[j]);
            let (share, rate) = if singular { (x * x * (3.0 - 2.0 * x), 3.0 * x * (1.0 - x)) } else { (x, 0.5) };
            piece.t[j] = a + length * share;
            piece.rate[j] = length * rate;
            piece.weights[j] = rule.weights[j] * piece.rate[j];
        }
        piece
    }

    /// The part from `a` to `b`, with the variable of a panel, whose origin may lie outside.
    #[inline(always)]
    fn inside((a, b): (f64, f64), (origin, sign, q): (f64, f64, u32)) -> Self {
        let rule = Rule::<NODES>::shared();
        let mut piece = Self { t: [0.0; NODES], rate: [0.0; NODES], weights: [0.0; NODES] };
        let [from, to] = [a, b].map(|t| (sign * (t - origin)).max(0.0).powf(1.0 / f64::from(q)));
        for j in 0..NODES {
            let sigma = 0.5 * (from + to) + 0.5 * (to - from) * rule.nodes[j];
            let lower = sigma.powi(q as i32 - 1);
            piece.t[j] = origin + sign * sigma * lower;
            piece.rate[j] = 0.5 * sign * (to - from) * f64::from(q) * lower;
            piece.weights[j] = rule.weights[j] * piece.rate[j];
        }
        piece
    }

    /// Adds to the path of a site the impulses in this part, and to the ledger the energies
    /// dissipated and the work of a driving force.
    #[inline(always)]
    fn follow(
        &self,
        flow: &Flow,
        y: &mut Path,
        ([contacts, lost], drive): ([&[f64; NODES]; 2], &[f64; NODES]),
        pushed: bool,
        gains: &mut Path,
    ) {
        let rule = Rule::<NODES>::shared();
        let mut now = y.map(|part| [part; NODES]);
        let by = if pushed {
            let mut impulse = [0.0; NODES];
            for j in 0..NODES {
                impulse[j] = self.rate[j] * (contacts[j] + drive[j]);
            }
            let (by, answer) = flow.velocity_and_answer(&self.t);
            for k in 0..4 {
                let part = times(&answer[k], &impulse);
                let moved = product(&rule.integral, &part);
                for j in 0..NODES {
                    now[k][j] += moved[j];
                }
                y[k] += dot(&rule.weights, &part);
            }
            by
        } else {
            flow.velocity(&self.t)
        };
        let [_, v, c, s] = &now;
        let along = |by: [[f64; NODES]; 3]| {
            let mut out = [0.0; NODES];
            for j in 0..NODES {
                out[j] = v[j] * by[0][j] + (c[j] * by[1][j] + s[j] * by[2][j]);
            }
            out
        };
        let velocity = along(by);
        gains[0] += flow.drag() * dot(&self.weights, &times(&velocity, &velocity));
        gains[2] -= dot(&self.weights, &times(lost, &velocity));
        gains[3] += dot(&self.weights, &times(drive, &velocity));
        if flow.dashpot() > 0.0 {
            let swing = along(flow.swing(&self.t));
            gains[1] += flow.dashpot() * dot(&self.weights, &times(&swing, &swing));
        }
    }
}
