//! Natural units of a motion: its numbers are near 1 in them, whatever the units of the chain.
//!
//! They are powers of 2^8, so that numbers have the same digits in them, and are 1 for a motion
//! whose numbers are near 1 already.

use super::{Chain, DriveKind, details::LEAST_POWER, max_norm};
use crate::numerics::unit;
use hertzchain_integrators::{
    Real,
    law::{BondLaw, Kind},
};

/// Units of a motion, in which absolute tolerances of DOP853 are given.
pub(crate) struct Natural<R> {
    /// Time in which beads cross their overlap; without contacts, that of the fastest motion.
    pub(crate) time: f64,
    /// Greatest overlap; without contacts, the size of the state.
    pub(crate) length: f64,
    /// Mass of a bead, the largest.
    pub(crate) mass: f64,
    /// The size of the state, over the unit of length: its largest displacement, or path of a bead
    /// in the unit of time. At rest that of the drives; 1 without them.
    pub(crate) size: R,
    /// The size of the drives.
    pub(crate) driven: f64,
    /// Powers of contacts and of their derivatives, and the acceleration by an overlap of one unit.
    strengths: Vec<(f64, f64)>,
}

/// Entries of a state at rest, in units of the drives, are at most this: an equilibrium is rest up
/// to rounding.
const AT_REST: f64 = 1e-9;

impl<R: Real> Chain<R> {
    /// The units of the motion from this state.
    pub(crate) fn natural(&self, y: &[R]) -> Natural<R> {
        let (half, ring) = (self.layout.half(), self.topology.ring());
        let largest = |q: &[R]| q.iter().fold(R::zero(), |most: R, q| most.max(q.abs()));
        let strain = max_norm(self.touching().map(|bond| self.across(bond, |i| y[i]).f64()));
        let drives = || self.parts().into_iter().flat_map(|parts| parts.drives(DriveKind::Displacement));
        let moved = |time: f64| max_norm(drives().map(|one| one.reach(time)));
        let strain = strain.max(moved(0.0));
        let speed = largest(self.layout.u_dot(y)).f64();
        // Force by an overlap of 1 over the mass of a bead, exponent, greatest overlap of contacts.
        let contacts: Vec<_> = match self.parts() {
            None => {
                let alpha = self.params.alpha;
                let depth = strain.max((speed * speed * (alpha + 1.0)).powf((alpha + 1.0).recip()));
                vec![(1.0, alpha, depth + self.precompression.f64())]
            }
            Some(parts) => {
                let of = |(k, per_mass, depth): (usize, f64, Option<f64>)| {
                    let laws = parts.bonds[k].laws().filter(move |_| depth.is_some());
                    laws.map(move |law| (0.5 * per_mass * law.constant.f64(), law.alpha().f64(), depth.unwrap_or(0.0)))
                };
                parts.pressed(ring, strain, speed).flat_map(of).collect()
            }
        };
        let other = || match self.parts() {
            None => self.params.omega(),
            Some(parts) => {
                let drag = parts.sites.iter().map(|site| ((site.drag + site.dashpot) / site.mass).f64());
                drag.fold(parts.fast_frequency(ring, strain, speed), f64::max)
            }
        };
        let closed = contacts.iter().filter(|contact| contact.2 > 0.0);
        let rate = closed.map(|(a, alpha, depth)| (a * depth.powf(alpha - 1.0)).sqrt()).fold(0.0, f64::max);
        let time = unit(if rate > 0.0 { rate } else { other() }.recip());
        let driven = self.details().map_or(0.0, |details| details.scale(time));
        let size = R::of(moved(time)).max(largest(&y[..half])).max(R::of(time) * largest(&y[half..2 * half]));
        let size = if size.f64() <= AT_REST * driven { R::of(driven) } else { size };
        let depth = contacts.iter().fold(0.0, |depth: f64, contact| depth.max(contact.2));
        let length = unit(if depth > 0.0 { depth } else { size.f64() });
        let strengths = |&(a, alpha, _): &(f64, f64, f64)| {
            let force = a * length.powf(alpha - 1.0) * time * time;
            [(alpha, force), ((alpha - 1.0).max(LEAST_POWER), alpha * force)]
        };
        Natural {
            time,
            length,
            mass: unit((0..self.sites()).map(|i| self.masses(i)[0].f64()).fold(0.0, f64::max)),
            size: if size > R::zero() { size * R::of(length.recip()) } else { R::one() },
            driven: driven / length,
            strengths: contacts.iter().flat_map(strengths).collect(),
        }
    }
}

impl<R: Real> Natural<R> {
    /// The units of the entries of a state of this chain.
    pub(crate) fn of_state(&self, chain: &Chain<R>) -> Vec<R> {
        let (half, dim, speed) = (chain.layout.half(), chain.layout.dim(), self.length / self.time);
        let of = |k: usize| [self.length, speed, (self.mass * speed * speed).max(1e-280)][(k / half.max(1)).min(2)];
        (0..dim).map(|k| R::of(of(k))).collect()
    }

    /// The unit of overlaps, and the strength of contacts where forces begin with this power; at
    /// least 1.
    pub(crate) fn of_overlaps(&self, alpha: f64) -> (R, R) {
        let strengths = self.strengths.iter().filter(|one| one.0 == alpha);
        (R::of(self.length), R::of(strengths.fold(1.0, |most, one| most.max(one.1))))
    }

    /// The factor that makes a length of what is positive where a contact pushes.
    pub(crate) fn per_push(&self, law: &BondLaw<R>) -> R {
        R::of(match law.loss {
            Some((Kind::Dashpot, _)) => self.length.powf(law.beta.f64()) * self.time * self.time / self.mass,
            Some((Kind::HuntCrossley, _)) => self.length,
            _ => 1.0,
        })
    }
}
