//! The static equilibrium under weights, constant forces, static overlaps and walls.
//!
//! | symbol | meaning |
//! |---|---|
//! | `F_n` | load of bead `n`: its weight along the chain, and constant forces of drives |
//! | `f_n, g_n` | force and overlap of the bond to the left of bead `n`: `g_n = (f_n/A_n)^{1/alpha_n}` if it has one power |
//! | *holder* | a wall, or a bead that a drive moves, at its place at time 0 |
//!
//! Forces balance where `f_{n+1} = f_n + F_n`. So between two holders there is one unknown, the
//! force in the first bond. The overlaps add up to the static ones plus the distance by which the
//! holders have come together: an equation whose left side increases with the unknown, solved by
//! Newton's method in a bracket. With one holder the force at the free end is zero, and all others
//! follow. Where no force is left, beads keep their gaps.

use super::{
    Boundary, Chain, Resonators, Site, State,
    details::{Bond, CheckedDetails},
};
use crate::{
    error::{Error, Result, require},
    numerics::least_above,
};
use hertzchain_integrators::law::BondLaw;
use std::ops::Range;

/// Sums of loads below this share of all of them are zero.
const ROUNDING: f64 = 1e-12;
/// Most steps of Newton's method and of bisection.
const MOST_STEPS: usize = 200;

impl State<f64> {
    /// The state at rest in the [`equilibrium`](Chain::equilibrium), where springs are relaxed.
    /// Beads that drives move begin with their drives.
    ///
    /// # Errors
    /// As [`Chain::equilibrium`].
    pub fn equilibrium(chain: &Chain<f64>) -> Result<Self> {
        let u = chain.equilibrium()?;
        let site = |i: usize| Site { u: u[i], v: u[i], u_dot: 0.0, v_dot: 0.0 };
        Ok(Self::from_fn(chain, site)?.driven(chain))
    }
}

impl Chain<f64> {
    /// The displacements of beads at rest under their weights, constant forces, static overlaps and
    /// walls. Drives that vary in time count as zero, beads that are moved are where they begin.
    ///
    /// ```
    /// use hertzchain_core::chain::{Boundary, Chain, Details, Params};
    /// // Two beads of mass 1 stand on the right wall: overlaps of 0.1^(2/3) and 0.2^(2/3).
    /// let details = Details { gravity: 0.1, ..Details::default() };
    /// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::RightWall, 2)?.with(&details)?;
    /// let u = chain.equilibrium()?;
    /// assert!((u[1] - 0.2f64.cbrt().powi(2)).abs() < 1e-15);
    /// assert!((u[0] - u[1] - 0.1f64.cbrt().powi(2)).abs() < 1e-15);
    /// # Ok::<(), hertzchain_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// A load that nothing holds; beads tied by springs to places (`rho = inf`) or to each other; a
    /// strain ring; a ring with beads that are moved or contacts that are left out.
    pub fn equilibrium(&self) -> Result<Vec<f64>> {
        let rule = "an equilibrium of displacements: any other boundary";
        require(self.boundary() != Boundary::StrainRing, "boundary", "strain-ring", rule)?;
        let chain = match self.parts() {
            Some(_) => self.clone(),
            None => self.clone().with(&super::Details::default())?,
        };
        let (n, loads) = (chain.sites(), chain.loads());
        let Some(parts) = chain.parts() else { return Ok(vec![0.0; n]) };
        require(!chain.tied(), "chain", "with springs or magnets that hold beads", "loads are held by contacts alone")?;
        let (mut u, mut holders) = (vec![0.0; n], Vec::new());
        for mover in chain.movers() {
            u[mover.site] = mover.at(0.0)[0];
            holders.push(mover.site);
        }
        holders.sort_unstable();
        let laws = &parts.bonds[..];
        if self.topology.ring() {
            let rule = "on a ring the equilibrium is that of beads that all have contacts and that no drive moves";
            let cut = self.touching().any(|bond| laws[bond].constant == 0.0);
            require(
                holders.is_empty() && !cut,
                "chain",
                "a ring with a bead that is moved or without a contact",
                rule,
            )?;
            ring(&laws[..n], &loads, &mut u)?;
            let mass: f64 = parts.sites.iter().map(|site| site.mass).sum();
            let mean = parts.sites.iter().zip(&u).map(|(site, u)| site.mass * u).sum::<f64>() / mass;
            u.iter_mut().for_each(|u| *u -= mean);
            return Ok(u);
        }
        // Ranges of beads between bonds without a contact, and between holders.
        let [left, right] = self.boundary().walls();
        let (mut start, mut before) = (0, left.then_some(0.0));
        for bond in 0..=n {
            let here = holders.binary_search(&bond).is_ok();
            let apart = laws[bond].constant == 0.0 && bond > 0;
            if bond < n && !here && !apart {
                continue;
            }
            let after = match bond {
                _ if apart => None,
                bond if bond == n => right.then_some(0.0),
                bond => Some(u[bond]),
            };
            // A wall without a contact, too, is none.
            let before_start = before.filter(|_| laws[start].constant > 0.0);
            held(laws, &loads, start..bond, [before_start, after], &mut u)?;
            (start, before) = if here { (bond + 1, Some(u[bond])) } else { (bond, None) };
            if start > n {
                break;
            }
        }
        Ok(u)
    }

    /// Whether springs tie beads to places, or springs or magnets to each other.
    pub fn tied(&self) -> bool {
        self.parts().is_some_and(CheckedDetails::joined)
            || (0..self.sites()).any(|i| match self.parts() {
                Some(parts) => parts.sites[i].resonators == Resonators::Fixed || parts.sites[i].onsite > 0.0,
                None => self.params.resonators() == Resonators::Fixed,
            })
    }

    /// The loads of beads: weights along the chain, and constant forces of drives.
    pub(crate) fn loads(&self) -> Vec<f64> {
        let mut loads = vec![0.0; self.sites()];
        if let Some(parts) = self.parts() {
            parts.weights().for_each(|(i, weight)| loads[i] += weight);
            let pushes = parts.acting().iter().filter(|acting| acting.pushes_steadily());
            pushes.for_each(|acting| loads[acting.site] += acting.at(0.0)[0]);
        }
        loads
    }

    /// The work of loads from the places at rest to a state.
    pub fn work_of_loads(&self, y: &[f64]) -> f64 {
        self.loads().iter().zip(self.layout.u(y)).map(|(load, u)| load * u).sum()
    }
}

/// The overlap of a contact that pushes with this force; `None` without a force.
fn overlap(bond: &Bond<f64>, force: f64) -> Option<f64> {
    if force.is_nan() || force <= 0.0 {
        return None;
    }
    let powers = bond.laws().count();
    let under = |law: &BondLaw<f64>| (force / powers as f64 / law.constant).powf(law.alpha().recip());
    // At this overlap no power has more than an equal share of the force.
    let least = bond.laws().map(under).fold(f64::INFINITY, f64::min);
    if bond.one_power() { Some(least) } else { least_above(0.5 * least, |g| bond.elastic(g) >= force) }
}

fn refused(loads: &[f64], beads: Range<usize>, rule: &'static str) -> Error {
    let load: f64 = loads[beads.clone()].iter().sum();
    let value = match beads.len() {
        1 => format!("{load:e} on bead {}", beads.start),
        _ => format!("{load:e} on beads {} to {}", beads.start, beads.end - 1),
    };
    Error::parameter("load", value, rule)
}

/// Places the beads of a range, between what holds them on the left and on the right: the place of
/// a wall or of a bead that is moved.
fn held(
    laws: &[Bond<f64>],
    loads: &[f64],
    beads: Range<usize>,
    holders: [Option<f64>; 2],
    u: &mut [f64],
) -> Result<()> {
    let Range { start, end } = beads;
    if beads.is_empty() {
        return Ok(());
    }
    // Force in each bond beyond that of the first, up to the one after the last bead.
    let mut beyond = vec![0.0];
    for &load in &loads[beads.clone()] {
        beyond.push(beyond[beyond.len() - 1] + load);
    }
    let (total, size) = (beyond[end - start], loads[beads.clone()].iter().map(|load| load.abs()).sum::<f64>());
    let rounded = |force: f64| if force.abs() <= ROUNDING * size { 0.0 } else { force };
    if let [Some(from), Some(to)] = holders {
        let laws = &laws[start..=end];
        let overlaps = squeezed(laws, &beyond, laws.iter().map(|law| law.rest).sum::<f64>() + from - to);
        let mut place = from;
        for ((u, law), overlap) in u[beads].iter_mut().zip(laws).zip(overlaps) {
            place += law.rest - overlap;
            *u = place;
        }
        return Ok(());
    }
    let first = if holders[1].is_none() { -total } else { 0.0 };
    if holders == [None, None] && rounded(total) != 0.0 {
        return Err(refused(loads, beads, "no wall and no bead that is moved holds it"));
    }
    let first = if holders == [None, None] { 0.0 } else { first };
    let force: Vec<f64> = beyond.iter().map(|beyond| rounded(first + beyond)).collect();
    // All beads that go: those beyond the bond that would have to pull.
    let pulls = |force: &f64| *force < 0.0;
    match holders[0] {
        Some(_) => force.iter().position(pulls).map_or(Ok(()), |k| {
            let rule = "it pulls away from what is on the left, and nothing holds it on the right";
            Err(refused(loads, start + k..end, rule))
        }),
        None => force.iter().rposition(pulls).map_or(Ok(()), |k| {
            let rule = "it pulls away from what is on the right, and nothing holds it on the left";
            Err(refused(loads, start..start + k, rule))
        }),
    }?;
    // How far a bead is from the one before, beyond their distance without displacements.
    let apart = |k: usize| {
        let law = &laws[start + k];
        law.rest - overlap(law, force[k]).unwrap_or(law.rest.min(0.0))
    };
    let inner = 1..end - start;
    match holders {
        [_, Some(to)] => {
            u[end - 1] = to - apart(end - start);
            inner.rev().for_each(|k| u[start + k - 1] = u[start + k] - apart(k));
        }
        [from, None] => {
            u[start] = from.map_or(0.0, |from| from + apart(0));
            inner.for_each(|k| u[start + k] = u[start + k - 1] + apart(k));
        }
    }
    Ok(())
}

/// Places the beads of a ring, the first one at zero.
fn ring(laws: &[Bond<f64>], loads: &[f64], u: &mut [f64]) -> Result<()> {
    let (total, size) = (loads.iter().sum::<f64>(), loads.iter().map(|load| load.abs()).sum::<f64>());
    if total.abs() > ROUNDING * size {
        return Err(refused(loads, 0..loads.len(), "on a ring nothing holds a sum of loads that is not zero"));
    }
    let mut beyond = vec![0.0];
    for &load in &loads[..loads.len() - 1] {
        beyond.push(beyond[beyond.len() - 1] + load);
    }
    let overlaps = squeezed(laws, &beyond, laws.iter().map(|law| law.rest).sum());
    for k in 1..u.len() {
        u[k] = u[k - 1] + laws[k].rest - overlaps[k];
    }
    Ok(())
}

/// Overlaps with the sum `total`, of bonds whose forces are `phi + beyond_k` with `phi` unknown. If
/// beads have more room than their loads close, the bonds without a force have gaps.
fn squeezed(laws: &[Bond<f64>], beyond: &[f64], total: f64) -> Vec<f64> {
    let least = -beyond.iter().copied().fold(f64::INFINITY, f64::min);
    let at = |phi: f64| -> Vec<f64> {
        let all = laws.iter().zip(beyond);
        all.map(|(law, beyond)| overlap(law, phi + beyond).unwrap_or(0.0)).collect()
    };
    let sum = |phi: f64| at(phi).iter().sum::<f64>();
    let room = total - sum(least);
    if room <= 0.0 {
        let mut overlaps = at(least);
        let loose = || (0..laws.len()).filter(|&k| least + beyond[k] <= 0.0);
        let gaps: f64 = loose().map(|k| laws[k].rest.min(0.0)).sum();
        for (j, k) in loose().enumerate() {
            overlaps[k] = match gaps {
                0.0 if j == 0 => room,
                0.0 => 0.0,
                gaps => room * (laws[k].rest.min(0.0) / gaps),
            };
        }
        return overlaps;
    }
    // One overlap alone is at most the whole sum.
    let alone = laws.iter().zip(beyond).map(|(law, beyond)| law.elastic(total) - beyond);
    let (mut low, mut high) = (least, alone.fold(f64::INFINITY, f64::min).max(least));
    let mut phi = high;
    for _ in 0..MOST_STEPS {
        let (off, slope) =
            (sum(phi) - total, at(phi).iter().zip(laws).map(|(&g, law)| law.stiffness(g).recip()).sum::<f64>());
        if off == 0.0 {
            break;
        }
        *(if off > 0.0 { &mut high } else { &mut low }) = phi;
        let newton = phi - off / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if next == phi || high - low <= f64::EPSILON * high.abs() {
            break;
        }
        phi = next;
    }
    at(phi)
}
