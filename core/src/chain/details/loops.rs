//! Loops over the sites of a chain with details, in registers.
//!
//! A *range* is a part of the chain whose sites move by the same formula. Products and sums are
//! those of one site at a time, in the same order, so that all instruction sets, and all ways to
//! divide a chain into ranges, give the same bits.

use super::{
    super::{
        Chain, ContactLaw, Ledger, Resonators,
        bonds::turning,
        law::{Power, with_hertz},
    },
    CheckedDetails,
    propagator::{Class, Propagator},
};
use hertzchain_integrators::{DoubleDouble, Real, Rotation, Vector, with_registers};
use std::ops::Range;

/// Computes a formula for `$count` sites, or bonds: those from `$i` on, as many as `$V` has lanes,
/// then the next.
macro_rules! over {
    ($count:expr, $i:ident, $V:ident<$R:ident> => $formula:expr) => {{
        let count = $count;
        with_registers!($V<$R> => {
            let mut next = 0;
            while next + $V::<$R>::LANES <= count {
                let $i = next;
                $formula;
                next += $V::<$R>::LANES;
            }
            {
                type $V<$R> = $R;
                for $i in next..count {
                    $formula;
                }
            }
        })
    }};
}

/// The formula of a site's drift.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    /// The position is prescribed.
    Given,
    /// `R` moves freely, `P` oscillates.
    Turning,
    /// Bead and resonator, if there is one, move freely.
    Straight,
    /// A site that is damped or has two frequencies, moved by a matrix.
    Damped,
}

/// The constants of sites and contacts for the loops.
#[derive(Debug)]
pub(super) struct Loops<R> {
    /// The ranges of the chain, in order.
    motions: Vec<(Motion, Range<usize>)>,
    /// Shares of an impulse on the bead that go to `z[2]` and `z[3]`, by site.
    shares: [Vec<R>; 2],
    /// Masses of beads.
    pub(super) mass: Vec<R>,
    /// Spring constants, and masses of resonators, infinite where none moves; `None` without
    /// springs.
    pub(super) springs: Option<[Vec<R>; 2]>,
    /// On-site springs beside resonators that move; empty if there are none.
    onsite: Vec<R>,
    /// The law of all contacts, if they have one power with the same exponent.
    law: Option<ContactLaw<R>>,
    /// Constants and static overlaps of contacts.
    contacts: [Vec<R>; 2],
}

/// The motion of each site over a given time.
#[derive(Debug)]
pub(super) struct Drift<R> {
    /// High and low part of the cosine and of the sine, by site; empty if no site of the chain is
    /// of [`Motion::Turning`].
    turns: [Vec<R>; 4],
    /// The propagator of each class.
    propagators: Vec<Propagator<R>>,
}

impl<R: Real> Loops<R> {
    /// The constants of a chain; `class` has for each site the index of its class in `classes`.
    pub(super) fn new(chain: &Chain<R>, parts: &CheckedDetails<R>, classes: &[Class<R>], class: &[u32]) -> Self {
        let of = |i: usize| &classes[class[i] as usize];
        let mut motions: Vec<(Motion, Range<usize>)> = Vec::new();
        for i in 0..class.len() {
            let motion = match of(i) {
                Class::Moved => Motion::Given,
                // Of a bead without resonator P is zero.
                Class::Modes(modes) if modes.mu == R::zero() => Motion::Straight,
                Class::Modes(_) => Motion::Turning,
                Class::Linear { straight: true, .. } => Motion::Straight,
                Class::Linear { .. } => Motion::Damped,
            };
            match motions.last_mut() {
                Some((last, range)) if *last == motion => range.end = i + 1,
                _ => motions.push((motion, i..i + 1)),
            }
        }
        let sites = &parts.sites;
        let with_springs = sites.iter().any(|site| site.resonators != Resonators::None);
        let springs = with_springs.then(|| {
            let kappa =
                sites.iter().map(|site| if site.resonators == Resonators::None { R::zero() } else { site.kappa });
            let moves = |resonators| resonators == Resonators::Moving;
            let masses = sites.iter().map(|site| if moves(site.resonators) { site.resonator() } else { R::infinity() });
            [kappa.collect(), masses.collect()]
        });
        let beside = sites.iter().any(|site| site.onsite > R::zero());
        let contacts = parts.bonds.iter().filter(|bond| bond.constant > R::zero());
        let laws: Vec<ContactLaw<R>> = contacts.map(|bond| bond.power).collect();
        let law = laws.first().copied().unwrap_or(chain.law());
        let same = parts.given.own_law().is_none() && laws.iter().all(|other| other.alpha() == law.alpha());
        Self {
            motions,
            shares: [0, 1].map(|k| (0..class.len()).map(|i| of(i).shares()[k]).collect()),
            mass: sites.iter().map(|site| site.mass).collect(),
            springs,
            onsite: if beside { sites.iter().map(|site| site.onsite).collect() } else { Vec::new() },
            law: same.then_some(law),
            contacts: [
                parts.bonds.iter().map(|bond| bond.constant).collect(),
                parts.bonds.iter().map(|bond| bond.rest).collect(),
            ],
        }
    }

    /// The law of all contacts.
    ///
    /// # Panics
    /// Contacts of different exponents.
    pub(super) fn one_law(&self) -> &ContactLaw<R> {
        self.law.as_ref().expect("contacts of one exponent")
    }

    /// The motion of all sites over a time.
    pub(super) fn over(&self, dt: DoubleDouble<R>, classes: &[Class<R>], class: &[u32]) -> Drift<R> {
        let propagators: Vec<Propagator<R>> = classes.iter().map(|class| class.over(dt)).collect();
        let turning = self.motions.iter().any(|(motion, _)| *motion == Motion::Turning);
        let parts: [fn(&Rotation<R>) -> R; 4] = [|by| by.cos.hi, |by| by.cos.lo, |by| by.sin.hi, |by| by.sin.lo];
        let turns = parts.map(|part| {
            let by = |&class: &u32| match &propagators[class as usize] {
                Propagator::Modes(_, rotation) => part(rotation),
                _ => R::zero(),
            };
            class.iter().filter(|_| turning).map(by).collect()
        });
        Drift { turns, propagators }
    }

    /// Moves all sites on by the time `dt`, over which `drift` is their motion if it is kept; adds
    /// the energies that drag and dashpots dissipate to the ledger of each member.
    pub(super) fn drift(
        &self,
        z: &mut [Vec<R>; 4],
        (dt, drift): (DoubleDouble<R>, Option<&Drift<R>>),
        (classes, class): (&[Class<R>], &[u32]),
        ledgers: &mut [Ledger<R>],
    ) {
        let members = ledgers.len();
        for (motion, range) in &self.motions {
            let mut z = part(z, range);
            match (motion, drift) {
                (Motion::Given, _) => {}
                // Bead and resonator both move freely.
                (Motion::Straight, _) => {
                    let dt = dt.value();
                    // SAFETY: the slices of `z` have these numbers.
                    over!(range.len(), i, V<R> => unsafe {
                        let [u, v, u_dot, v_dot]: [V<R>; 4] = four(&z, i);
                        store(z[0], i, u + V::<R>::all(dt) * u_dot);
                        store(z[1], i, v + V::<R>::all(dt) * v_dot);
                    });
                }
                (Motion::Turning, Some(drift)) => {
                    let turns = drift.turns.each_ref().map(|by| &by[range.clone()]);
                    let dt = dt.value();
                    // SAFETY: all slices have these numbers.
                    over!(range.len(), i, V<R> => unsafe {
                        let [r, p, r_dot, s]: [V<R>; 4] = four(&z, i);
                        let [cos, cos_low, sin, sin_low]: [V<R>; 4] = four(&turns, i);
                        store(z[0], i, r + V::<R>::all(dt) * r_dot);
                        // The low parts keep the rotation from growing or shrinking over many
                        // steps.
                        store(z[1], i, (cos * p + sin * s) + (cos_low * p + sin_low * s));
                        store(z[3], i, (cos * s - sin * p) + (cos_low * s - sin_low * p));
                    });
                }
                (Motion::Turning | Motion::Damped, _) => {
                    for (k, &class) in class[range.clone()].iter().enumerate() {
                        let mut site = z.each_ref().map(|z| z[k]);
                        let [drag, dashpot] = match drift {
                            Some(drift) => drift.propagators[class as usize].apply(&mut site),
                            None => classes[class as usize].advance(&mut site, dt),
                        };
                        z.iter_mut().zip(site).for_each(|(z, value)| z[k] = value);
                        let ledger = &mut ledgers[(range.start + k) % members];
                        ledger.drag += drag;
                        ledger.dashpots += dashpot;
                    }
                }
            }
        }
    }

    /// Positions of beads.
    pub(super) fn positions(&self, z: &[Vec<R>; 4], u: &mut [R]) {
        u.copy_from_slice(&z[0]);
        for (_, range) in self.motions.iter().filter(|(motion, _)| *motion == Motion::Turning) {
            u[range.clone()].iter_mut().zip(&z[1][range.clone()]).for_each(|(u, &p)| *u += p);
        }
    }

    /// Contact forces on beads at the positions `u`, which have a place more for each member on
    /// either side; `push` has room for a bond more than sites of each.
    pub(super) fn forces(
        &self,
        chain: &Chain<R>,
        parts: &CheckedDetails<R>,
        u: &mut [R],
        push: &mut [R],
        force: &mut [R],
    ) {
        let (n, members, topology) = (force.len(), chain.count(), chain.member(0).topology());
        for m in 0..members {
            (u[m], u[n + members + m]) = topology.ghosts(u[members + m], u[n + m]);
        }
        let (u, push) = (&u[..n + 2 * members], &mut push[..n + members]);
        // The bonds beyond free ends are open, at an infinite distance.
        let strain = |bond: usize| u[bond] - u[bond + members];
        if let Some(law) = &self.law {
            let contacts = self.contacts.each_ref().map(|numbers| &numbers[..n + members]);
            let push = &mut *push;
            // The force `A (delta + u_i - u_{i+1})_+^alpha` of the bond after bead `i`.
            // SAFETY: the slices have a number for each bond, and `u` one more for each member.
            with_hertz!(law, power => over!(n + members, i, V<R> => unsafe {
                let overlap = load::<R, V<R>>(contacts[1], i) + (load::<R, V<R>>(u, i) - load(u, i + members));
                let constant: V<R> = load(contacts[0], i);
                store(push, i, constant * power.raise(law.positive_part(overlap)));
            }));
        } else {
            for (bond, contact) in parts.bonds.iter().enumerate() {
                push[bond] = contact.elastic(contact.rest + strain(bond));
            }
        }
        let touching = topology.touching();
        for bond in (touching.start * members..touching.end * members).filter(|_| parts.joined()) {
            if let Some(joint) = parts.joint(bond) {
                push[bond] += joint.force(strain(bond));
            }
        }
        if topology.ring() {
            let (first, last) = push.split_at_mut(n);
            last.copy_from_slice(&first[..members]);
        }
        let push = &*push;
        // SAFETY: the slices have a number for each site, or for each bond.
        over!(n, i, V<R> => unsafe {
            store(force, i, load::<R, V<R>>(push, i) - load(push, i + members));
        });
    }

    /// Of all bonds, from bond 0 on: overlaps times `unit`, forces as the powers of these, and the
    /// derivatives of the powers; for contacts with the same exponent.
    pub(super) fn bonds(
        &self,
        (chain, parts): (&Chain<R>, &CheckedDetails<R>),
        unit: &[R],
        u: &[R],
        [overlap, force, slope]: [&mut [R]; 3],
    ) {
        let (n, law) = (u.len(), self.one_law());
        let [rest, unit_inside] = [&self.contacts[1][1..], &unit[1..]];
        let [g, f, by_g] = [&mut *overlap, &mut *force, &mut *slope].map(|all| &mut all[1..n]);
        // SAFETY: the slices have a number for each bond between beads, and `u` one more.
        with_hertz!(law, power => over!(n - 1, i, V<R> => unsafe {
            let strain = load::<R, V<R>>(u, i) - load(u, i + 1);
            let overlap: V<R> = load::<R, V<R>>(unit_inside, i) * (load::<R, V<R>>(rest, i) + strain);
            let (force, slope) = law.force_and_slope(power, overlap);
            store(g, i, overlap);
            store(f, i, force);
            store(by_g, i, slope);
        }));
        // The first and the last bond, as in `forces`.
        for bond in [0, n].into_iter().filter(|bond| chain.touching().contains(bond)) {
            overlap[bond] = unit[bond] * (parts.bonds[bond].rest + chain.across(bond, |i| u[i]));
            (force[bond], slope[bond]) = law.force_with_slope(overlap[bond]);
        }
        if chain.topology().ring() {
            (overlap[n], force[n], slope[n]) = (overlap[0], force[0], slope[0]);
        }
    }

    /// Of contact forces with these derivatives by overlaps times `unit`, and other forces on
    /// beads: accelerations `a` of beads, forces `f + c f' s` of bonds with the acceleration `s` of
    /// their overlaps, and the contact forces on beads by these.
    pub(super) fn modified(
        &self,
        chain: &Chain<R>,
        (unit, c): (&[R], R),
        [force, slope, others]: [&[R]; 3],
        [a, modified, push]: [&mut [R]; 3],
    ) {
        let n = a.len();
        let (force, slope, unit) = (&force[..=n], &slope[..=n], &unit[..=n]);
        let (mass, others, modified, push) = (&self.mass[..n], &others[..n], &mut modified[..=n], &mut push[..n]);
        let here = &mut *a;
        // SAFETY: the slices have a number for each site, or for each bond and one more.
        over!(n, i, V<R> => unsafe {
            let pull: V<R> = (load::<R, V<R>>(force, i) - load(force, i + 1)) + load(others, i);
            store(here, i, pull / load(mass, i));
        });
        let a = &*a;
        let [f, by_g, unit_inside] = [force, slope, unit].map(|all| &all[1..n]);
        let inside = &mut modified[1..n];
        // SAFETY: as above.
        over!(n - 1, i, V<R> => unsafe {
            let s: V<R> = load::<R, V<R>>(unit_inside, i) * (load::<R, V<R>>(a, i) - load(a, i + 1));
            store(inside, i, load::<R, V<R>>(f, i) + V::<R>::all(c) * load(by_g, i) * s);
        });
        for bond in [0, n] {
            let touches = chain.touching().contains(&bond);
            let s = if touches { unit[bond] * chain.across(bond, |i| a[i]) } else { R::zero() };
            modified[bond] = force[bond] + c * slope[bond] * s;
        }
        if chain.topology().ring() {
            modified[n] = modified[0];
        }
        // SAFETY: as above.
        over!(n, i, V<R> => unsafe {
            store(push, i, load::<R, V<R>>(modified, i) - load(modified, i + 1));
        });
    }

    /// Bits of bonds that are closed or not, against those of `told`, which are replaced: calls
    /// `changed` with each bond whose bit differs, and the new bit.
    pub(super) fn sides(&self, overlap: &[R], told: &mut [u64], mut changed: impl FnMut(usize, bool)) {
        over!(overlap.len(), i, V<R> => {
            // SAFETY: the slice has these numbers.
            let now = unsafe { load::<R, V<R>>(overlap, i) }.positive();
            let (word, first) = (i / 64, i % 64);
            let mut differ = (now ^ told[word] >> first) & (u64::MAX >> (64 - V::<R>::LANES));
            told[word] ^= differ << first;
            while differ != 0 {
                let k = differ.trailing_zeros() as usize;
                differ &= differ - 1;
                changed(i + k, now >> k & 1 == 1);
            }
        });
    }

    /// Calls `turned` with each bond whose overlap has turned near zero, see [`turning`].
    pub(super) fn turns(&self, reach: R, [g2, g1, g0]: [&[R]; 3], mut turned: impl FnMut(usize)) {
        over!(g2.len(), i, V<R> => {
            // SAFETY: the slices have as many numbers.
            let mut bits = turning::<R, V<R>>(reach, unsafe { [load(g0, i), load(g1, i), load(g2, i)] });
            while bits != 0 {
                turned(i + bits.trailing_zeros() as usize);
                bits &= bits - 1;
            }
        });
    }

    /// Adds the pull of springs to the forces on beads, and kicks resonators.
    pub(super) fn springs(&self, z: &mut [Vec<R>; 4], force: &mut [R], kick: R) {
        for (i, onsite) in self.onsite.iter().enumerate() {
            force[i] -= *onsite * z[0][i];
        }
        if let Some(springs) = &self.springs {
            let sites = force.len();
            let (z, springs) = (part(z, &(0..sites)), springs.each_ref().map(|s| &s[..sites]));
            // SAFETY: all slices have a number for each site.
            over!(sites, i, V<R> => unsafe {
                let [u, v, _, v_dot]: [V<R>; 4] = four(&z, i);
                let (kappa, resonator): (V<R>, V<R>) = (load(springs[0], i), load(springs[1], i));
                let pull = kappa * (u - v);
                store(force, i, load::<R, V<R>>(force, i) - pull);
                store(z[3], i, v_dot + V::<R>::all(kick) * (pull / resonator));
            });
        }
    }

    /// Kicks all beads except those that a drive moves.
    pub(super) fn kick(&self, z: &mut [Vec<R>; 4], force: &[R], kick: R) {
        for (_, range) in self.motions.iter().filter(|(motion, _)| *motion != Motion::Given) {
            let (force, mass) = (&force[range.clone()], &self.mass[range.clone()]);
            let shares = self.shares.each_ref().map(|share| &share[range.clone()]);
            let z = part(z, range);
            // SAFETY: all slices have these numbers.
            over!(range.len(), i, V<R> => unsafe {
                let impulse = V::<R>::all(kick) * (load::<R, V<R>>(force, i) / load(mass, i));
                store(z[2], i, load::<R, V<R>>(z[2], i) + load::<R, V<R>>(shares[0], i) * impulse);
                store(z[3], i, load::<R, V<R>>(z[3], i) + load::<R, V<R>>(shares[1], i) * impulse);
            });
        }
    }
}

fn part<'a, R>(z: &'a mut [Vec<R>; 4], range: &Range<usize>) -> [&'a mut [R]; 4] {
    z.each_mut().map(|numbers| &mut numbers[range.clone()])
}

/// The numbers of a slice from `i` on, in a register.
///
/// # Safety
/// The slice has at least `V::LANES` numbers from `i` on.
#[inline(always)]
unsafe fn load<R, V: Vector<R>>(numbers: &[R], i: usize) -> V {
    debug_assert!(i + V::LANES <= numbers.len());
    // SAFETY: the caller's promise.
    unsafe { V::load(numbers.as_ptr().add(i)) }
}

/// The numbers of four slices from `i` on. No closure: it would not be compiled for the registers.
///
/// # Safety
/// Each slice has at least `V::LANES` numbers from `i` on.
#[inline(always)]
unsafe fn four<R, V: Vector<R>>(numbers: &[impl std::ops::Deref<Target = [R]>; 4], i: usize) -> [V; 4] {
    // SAFETY: the caller's promise.
    unsafe { [load(&numbers[0], i), load(&numbers[1], i), load(&numbers[2], i), load(&numbers[3], i)] }
}

/// Writes the numbers of a slice from `i` on.
///
/// # Safety
/// The slice has at least `V::LANES` numbers from `i` on.
#[inline(always)]
unsafe fn store<R, V: Vector<R>>(numbers: &mut [R], i: usize, values: V) {
    debug_assert!(i + V::LANES <= numbers.len());
    // SAFETY: the caller's promise.
    unsafe { values.store(numbers.as_mut_ptr().add(i)) }
}
