//! Details of a chain: parameters that differ from bead to bead, damping, dissipation and drives.
//!
//! | symbol | meaning |
//! |---|---|
//! | `m_n, kappa_n, rho_n` | mass of a bead, spring constant, mass of its resonator over `m_n` |
//! | `k_n` | spring between a bead and its place at rest, `-k_n u_n` |
//! | `c_n, d_n` | drag on a bead, `-c_n u_n'`; dashpot beside its spring, `-d_n (u_n' - v_n')` |
//! | `A_b, alpha_b, delta_b` | constant, exponent and static overlap of a contact; it may have a sum of powers, see [`Term`], or a [`Table`] |
//! | `h_b(x)` | linear spring and magnets between two beads, see [`Joint`]; on both sides of zero |
//! | `gamma_b, beta, p` | dissipation of a contact, see [`Dissipation`]; powers of overlap and rate in that of dashpots |
//! | `s(t), F(t)` | motion of a bead that is moved, force on a bead that is pushed |
//! | `a` | acceleration of gravity along the chain, towards its right end |
//!
//! ```text
//! m_n u_n'' = f_n - f_{n+1} - kappa_n (u_n - v_n) - k_n u_n - c_n u_n' - d_n (u_n' - v_n') + m_n a + F_n(t)
//! rho_n m_n v_n'' = kappa_n (u_n - v_n) + d_n (u_n' - v_n'),     g_b = delta_b + u_{b-1} - u_b
//! f_b = h_b(g_b - delta_b) + A_b (g_b)_+^{alpha_b}, the contact's part with dissipation at least zero: beads
//!       never pull, unless they may
//! ```
//!
//! The state of a chain with damping, dissipation, drives or gravity has four more entries at its
//! end, the [`Ledger`](super::Ledger): energies dissipated and work of drives and of gravity since
//! the start. Energy + dissipated - driven is constant.

mod chain;
mod collocation;
mod contact;
mod drive;
mod field;
mod flow;
mod joint;
mod loops;
mod parameter;
mod propagator;
mod pushing;
mod spline;
mod table;

pub use collocation::HeterogeneousChain;
pub use contact::{Dissipation, Kind, Term};
pub use drive::{Course, Drive, DriveKind, Envelope, Harmonic, Signal};
pub use flow::{SitewiseBonds, SitewiseFlow};
pub use joint::Joint;
pub use parameter::Parameter;
pub use spline::Spline;
pub use table::Table;

pub(super) use contact::Bond;
pub(super) use field::{complete, rates};
pub(super) use pushing::{Pushing, Switched};

use super::{Params, Resonators};
use crate::error::{Error, NOTHING, Result, beside, refuse, require};
use contact::entry;
use hertzchain_integrators::{Real, law::BondLaw, regularised::common_power};
use std::{collections::HashMap, sync::Arc};

/// Parameters that differ from bead to bead, damping, dissipation and drives, as input of
/// [`Chain::with`](crate::Chain::with).
///
/// Lists of sites have one number a site, lists of bonds one number for each bond that can touch,
/// from left to right (walls included). A list that is empty stands for the value of the uniform
/// chain: mass 1, the `kappa`, `rho`, `alpha` and precompression of the chain, contact constant 1,
/// and no drag, dashpot, dissipation or drive.
///
/// ```
/// use hertzchain_core::{Boundary, Chain, Params, Run, State, chain::Details};
/// // A heavy bead strikes a light one at rest.
/// let details = Details { mass: vec![2.0, 1.0], ..Details::default() };
/// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Free, 2)?.with(&details)?;
/// let mut state = State::rest(&chain);
/// state.u_dot_mut()[0] = 1.0;
/// let end = Run::new(chain, state).until(20.0)?.start()?;
/// // Elastic collision: (m - M)/(m + M) and 2 m/(m + M).
/// assert!((end.state[2] - 1.0 / 3.0).abs() < 1e-9 && (end.state[3] - 4.0 / 3.0).abs() < 1e-9);
/// # Ok::<(), hertzchain_core::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Details {
    /// Masses of beads, positive.
    pub mass: Vec<f64>,
    /// Spring constants, at least zero.
    pub kappa: Vec<f64>,
    /// Masses of resonators over those of their beads, in `[0, inf]`.
    pub rho: Vec<f64>,
    /// Constants of springs that tie beads to their places at rest, at least zero. Where no
    /// resonator moves, such a spring is one to a resonator of infinite mass.
    pub onsite: Vec<f64>,
    /// Drag on beads, at least zero.
    pub drag: Vec<f64>,
    /// Dashpots between beads and resonators, at least zero.
    pub dashpot: Vec<f64>,
    /// Constants of contacts, at least zero; zero for no contact.
    pub contact: Vec<f64>,
    /// Exponents of contacts, positive.
    pub alpha: Vec<f64>,
    /// Further powers in the forces of contacts, none of which dissipates.
    pub terms: Vec<Term>,
    /// A table, times the constant of the contact, in place of the first power; it does not
    /// dissipate either.
    pub table: Option<Arc<Table>>,
    /// Static overlaps of contacts, finite; negative if there is a gap between the beads.
    pub overlap: Vec<f64>,
    /// Constants of linear springs between beads, relaxed at the static overlap, at least zero.
    pub spring: Vec<f64>,
    /// Forces at rest of magnets on two beads that repel, at least zero; zero for none.
    pub magnet: Vec<f64>,
    /// Distances of these magnets at rest, positive.
    pub distance: Vec<f64>,
    /// Power of the distance with which the force of magnets decays, above 1.
    pub decay: f64,
    /// How contacts dissipate, if they do.
    pub dissipation: Option<Dissipation>,
    /// Power of the overlap in the resistance of dashpots of contacts, `c(g) = gamma g^beta`: at
    /// least zero, and at most `alpha - 1` unless contacts may pull.
    pub beta: f64,
    /// Power of the rate in the force of dashpots of contacts, `gamma g^beta |g'|^p sgn g'`: at
    /// least 1; 1 if left out.
    pub rate_power: Option<f64>,
    /// Whether contacts that dissipate may pull while beads overlap.
    pub pull: bool,
    /// Drives, which move or push beads.
    pub drives: Vec<Drive>,
    /// Acceleration of gravity along the chain, positive towards its right end. Displacements of
    /// resonators are counted from where they hang at rest.
    pub gravity: f64,
}

macro_rules! lists {
    ($of:ident: $($list:ident)*) => {
        vec![$((stringify!($list), &$of.$list)),*]
    };
}

impl Details {
    /// The lists of beads and those of bonds, with their names, which scenes have for them.
    pub fn lists(&self) -> [Vec<(&'static str, &Vec<f64>)>; 2] {
        let bonds = lists!(self: contact alpha overlap spring magnet distance);
        [lists!(self: mass kappa rho onsite drag dashpot), bonds]
    }
}

/// The parameters of a site, in the form that loops over sites need.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SiteData<R> {
    pub(crate) mass: R,
    pub(crate) kappa: R,
    pub(crate) rho: R,
    /// On-site spring of a bead whose resonator moves; else it is part of `kappa`.
    pub(crate) onsite: R,
    pub(crate) drag: R,
    pub(crate) dashpot: R,
    pub(crate) resonators: Resonators,
    /// Whether a drive prescribes its position.
    pub(crate) moved: bool,
}

impl<R: Real> SiteData<R> {
    /// The mass of the resonator; zero if there is none or it is fixed.
    pub(crate) fn resonator(&self) -> R {
        if self.resonators == Resonators::Moving { self.rho * self.mass } else { R::zero() }
    }
}

/// The details of a chain, checked and completed.
#[derive(Debug)]
pub(crate) struct CheckedDetails<R> {
    pub(super) given: Details,
    /// What acts on beads, in the order of the drives.
    acting: Vec<Acting>,
    pub(crate) sites: Vec<SiteData<R>>,
    /// Contacts from bond 0 on; bonds that cannot touch have the constant zero.
    pub(crate) bonds: Vec<Bond<R>>,
    /// Springs and magnets between beads, by bond; empty if there are none.
    joints: Vec<Joint<R>>,
    pub(crate) damped: bool,
    pub(crate) dissipative: bool,
}

/// A drive that pushes a bead, or all drives that move one.
#[derive(Clone, Debug)]
pub(crate) struct Acting {
    pub(crate) site: usize,
    pub(crate) kind: DriveKind,
    pub(crate) signals: Vec<Signal>,
}

impl Acting {
    fn of(drives: &[Drive]) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        let mut moved = HashMap::new();
        for Drive { site, kind, signal } in drives.iter().cloned() {
            let next = all.len();
            match *moved.entry(site).or_insert(next) {
                first if first < next && kind == DriveKind::Displacement => all[first].signals.push(signal),
                _ => all.push(Self { site, kind, signals: vec![signal] }),
            }
        }
        all
    }

    /// Whether it pushes its bead with a constant force.
    pub(crate) fn pushes_steadily(&self) -> bool {
        self.kind == DriveKind::Force && self.signals.iter().all(Signal::is_constant)
    }

    /// The sum of the signals, with its first and second derivative.
    pub(crate) fn at<R: Real>(&self, t: R) -> [R; 3] {
        let mut sum = self.signals[0].at(t);
        for signal in &self.signals[1..] {
            sum.iter_mut().zip(signal.at(t)).for_each(|(sum, by)| *sum += by);
        }
        sum
    }
}

impl<R: Real> CheckedDetails<R> {
    /// The details of chains abreast: number `i` of member `m` is number `i members + m`.
    pub(crate) fn abreast(members: &[&Self]) -> Self {
        fn mixed<'a, T: Clone + 'a>(lists: impl Iterator<Item = &'a Vec<T>> + Clone) -> Vec<T> {
            let long = lists.clone().map(Vec::len).max().unwrap_or(0);
            (0..long).flat_map(|i| lists.clone().map(move |list| list[i].clone())).collect()
        }
        let own = |(m, one): (usize, &&Self)| {
            let at = move |acting: Acting| Acting { site: acting.site * members.len() + m, ..acting };
            one.acting.clone().into_iter().map(at)
        };
        let all = members.iter();
        Self {
            given: members[0].given.clone(),
            acting: all.clone().enumerate().flat_map(own).collect(),
            sites: mixed(all.clone().map(|one| &one.sites)),
            bonds: mixed(all.clone().map(|one| &one.bonds)),
            joints: mixed(all.clone().map(|one| &one.joints)),
            damped: all.clone().any(|one| one.damped),
            dissipative: all.clone().any(|one| one.dissipative),
        }
    }

    /// What acts on beads, besides gravity.
    pub(crate) fn acting(&self) -> &[Acting] {
        &self.acting
    }

    /// The weight of each bead along the chain, with that of the resonator that hangs on it, if
    /// there is gravity; zero of beads that are moved.
    ///
    /// `v` is counted from where a resonator hangs at rest: with `v = w + rho m a/kappa` the spring
    /// `kappa (u - v)` is `kappa (u - w) - rho m a`, so that the weight of the resonator acts on
    /// the bead.
    pub(crate) fn weights(&self) -> impl Iterator<Item = (usize, R)> + '_ {
        let heavy: &[SiteData<R>] = if self.given.gravity == 0.0 { &[] } else { &self.sites };
        let weight = |site: &SiteData<R>| match site.resonators {
            _ if site.moved => R::zero(),
            Resonators::Moving => (site.mass + site.resonator()) * R::of(self.given.gravity),
            Resonators::None | Resonators::Fixed => site.mass * R::of(self.given.gravity),
        };
        heavy.iter().map(weight).enumerate()
    }

    /// Whether the state keeps a ledger.
    pub(crate) fn open(&self) -> bool {
        self.damped || self.dissipative || !self.acting.is_empty() || self.given.gravity != 0.0
    }

    /// The largest static overlap; zero if there are gaps only.
    pub(crate) fn largest_rest(&self) -> f64 {
        self.bonds.iter().fold(0.0, |largest, bond| largest.max(bond.rest.f64()))
    }

    /// Whether springs or magnets join beads.
    pub(crate) fn joined(&self) -> bool {
        !self.joints.is_empty()
    }

    /// The spring and the magnets of a bond.
    pub(crate) fn joint(&self, bond: usize) -> Option<&Joint<R>> {
        self.joints.get(bond)
    }

    /// The laws of all powers of all contacts.
    fn laws(&self) -> impl Iterator<Item = &BondLaw<R>> {
        self.bonds.iter().flat_map(Bond::laws)
    }

    /// The exponents of contacts.
    pub(super) fn exponents(&self) -> impl Iterator<Item = f64> + '_ {
        self.laws().filter_map(BondLaw::elastic_power)
    }

    /// The powers of time with which forces begin and end at events, each once.
    fn powers(&self) -> Vec<f64> {
        let mut powers: Vec<f64> = self.laws().flat_map(BondLaw::powers).collect();
        powers.sort_by(f64::total_cmp);
        powers.dedup();
        powers
    }

    /// For DOP853 of order `p` from event to event: the smallest power of time with which the field
    /// begins at an event, and the power of the map that is used for all events.
    pub(crate) fn map(&self, p: u32) -> (f64, u32) {
        map(&self.powers(), p)
    }

    /// [`map`](Self::map) of the linearised field.
    pub(crate) fn map_of_columns(&self, p: u32) -> (f64, u32) {
        let of = |bond: &BondLaw<R>| {
            bond.elastic_power().map(|alpha| alpha - 1.0).into_iter().chain(bond.power_of_resistance())
        };
        let powers: Vec<f64> = self.laws().flat_map(of).collect();
        map(&powers, p)
    }
}

impl CheckedDetails<f64> {
    /// Whether contact-corrected splitting can run it: contacts of one power, no springs of
    /// sites or of bonds, and no energy is taken or given but by constant forces.
    pub(crate) fn corrects(&self) -> bool {
        let mut exponents = self.exponents();
        let first = exponents.next();
        let same = exponents.all(|alpha| Some(alpha) == first);
        let held = self.joined() || self.sites.iter().any(|site| site.onsite > 0.0);
        let conserves = !self.damped && !self.dissipative && self.acting.iter().all(Acting::pushes_steadily);
        same && self.given.own_law().is_none() && !held && conserves
    }
}

impl<R: Real> CheckedDetails<R> {
    /// The largest frequency of resonators, harmonics of drives and contacts, whose overlaps are
    /// those of [`pressed`](Self::pressed), also by the speed of moved beads.
    pub(crate) fn fast_frequency(&self, ring: bool, strain: f64, speed: f64) -> f64 {
        let of_site = |site: &SiteData<R>| {
            let [kappa, onsite, mass, rho] = [site.kappa, site.onsite, site.mass, site.rho].map(R::f64);
            let inverse = if site.resonators == Resonators::None { 0.0 } else { 1.0 + 1.0 / rho };
            ((inverse * kappa + onsite) / mass).sqrt()
        };
        let of_bond = |(k, per_mass, depth): (usize, f64, Option<f64>)| {
            let spring = self.joint(k).map_or(0.0, |joint| joint.stiffness_within(R::of(strain)).f64() * per_mass);
            let overlap = self.given.table.as_ref().map_or(depth, |table| depth.map(|_| table.end()));
            let stiffness = |g: f64| self.bonds[k].laws().map(|law| law.stiffness(R::of(g)).f64()).sum::<f64>();
            (overlap.map_or(0.0, stiffness) * per_mass + spring).sqrt()
        };
        let of_drives = self.acting.iter().flat_map(|acting| &acting.signals).map(Signal::frequency);
        let speed = self.drives(DriveKind::Displacement).map(Signal::speed).fold(speed, f64::max);
        let bonds = self.pressed(ring, strain, speed).map(of_bond);
        self.sites.iter().map(of_site).chain(bonds).chain(of_drives).fold(0.0, f64::max)
    }

    /// The signals of all drives of a kind.
    pub(crate) fn drives(&self, kind: DriveKind) -> impl Iterator<Item = &Signal> {
        self.acting.iter().filter(move |acting| acting.kind == kind).flat_map(|acting| &acting.signals)
    }

    /// Each bond with the inverse mass of its beads and, if it has a contact, its greatest overlap.
    /// Beyond its static one, that is the largest of: `strain`; the greatest overlap of its two
    /// beads if they meet with this `speed` each; the greatest overlap of beads that the largest
    /// driving force, or the weight of the chain, pushes from rest.
    pub(crate) fn pressed(
        &self,
        ring: bool,
        strain: f64,
        speed: f64,
    ) -> impl Iterator<Item = (usize, f64, Option<f64>)> + '_ {
        let weight = self.weights().map(|(_, weight)| weight.f64().abs()).sum();
        let push = self.drives(DriveKind::Force).map(Signal::size).fold(weight, f64::max);
        // A wall, and a bead that is moved, have the inverse mass zero.
        let inverse = |k: usize| self.sites.get(k).filter(|site| !site.moved).map_or(0.0, |site| 1.0 / site.mass.f64());
        self.bonds.iter().enumerate().map(move |(k, bond)| {
            let before = k.checked_sub(1).or(ring.then(|| self.sites.len() - 1));
            let per_mass = before.map_or(0.0, inverse) + inverse(k);
            // Beads overlap by less than if any of the powers were the only one.
            let alone = |law: &BondLaw<R>| {
                let alpha = law.alpha().f64();
                let scale = (alpha + 1.0) / law.constant.f64();
                let met = (scale * 2.0 * speed * speed / per_mass).powf(1.0 / (alpha + 1.0));
                met.max((scale * push).powf(1.0 / alpha))
            };
            let depth = || bond.rest.f64().max(0.0) + strain.max(bond.laws().map(alone).fold(f64::INFINITY, f64::min));
            let contact = bond.elastic_power().is_some() && per_mass > 0.0;
            (k, per_mass, contact.then(depth))
        })
    }
}

/// The least power, and the power of the map that suits all. Jumps need no map.
fn map(powers: &[f64], p: u32) -> (f64, u32) {
    let least = powers.iter().copied().fold(f64::INFINITY, f64::min);
    let smooth: Vec<f64> = powers.iter().copied().filter(|&power| power > 0.0).collect();
    let least = match least {
        0.0 => LEAST_POWER,
        least if least.is_finite() => least,
        _ => 1.0,
    };
    (least, common_power(&smooth, p))
}

/// Power of time that stands for a force that jumps, in the estimate of the error by a moved event.
pub(super) const LEAST_POWER: f64 = 0.01;

/// Refuses a list of a wrong length or with a value outside its rule.
fn checked(
    name: &'static str,
    list: &[f64],
    (count, of): (usize, &str),
    good: impl Fn(f64) -> bool,
    rule: &'static str,
) -> Result<()> {
    if !list.is_empty() && list.len() != count {
        let rule = "a list has one number for each site, or for each bond that can touch";
        return Err(Error::parameter(name, format!("{} numbers for {count} {of}", list.len()), rule));
    }
    let bad = list.iter().position(|&value| !good(value));
    refuse(name, bad.map(|i| format!("{} (entry {i})", list[i])), rule)
}

impl Details {
    /// Bytes that a chain with details takes for each site, at least.
    pub fn site_bytes() -> u64 {
        (size_of::<SiteData<f64>>() + size_of::<Bond<f64>>()) as u64
    }

    fn check(&self, sites: usize, bonds: usize, alpha: f64) -> Result<()> {
        let (sites, bonds) = ((sites, "sites"), (bonds, "bonds that can touch"));
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let not_negative = |x: f64| x.is_finite() && x >= 0.0;
        checked("mass", &self.mass, sites, positive, "a mass is finite and positive")?;
        checked("kappa", &self.kappa, sites, not_negative, "a spring constant is finite and at least zero")?;
        checked("rho", &self.rho, sites, |x| x >= 0.0, "a mass ratio is in [0, inf]")?;
        checked("onsite", &self.onsite, sites, not_negative, "a spring constant is finite and at least zero")?;
        checked("drag", &self.drag, sites, not_negative, "a drag is finite and at least zero")?;
        checked("dashpot", &self.dashpot, sites, not_negative, "a dashpot is finite and at least zero")?;
        let (constant, rule) = (
            |x: f64| (0.0..=1e200).contains(&x),
            "a contact constant is from 0 to 1e200, so that its force, which begins at 1e-250 times it, does not jump",
        );
        checked("contact", &self.contact, bonds, constant, rule)?;
        checked("alpha", &self.alpha, bonds, positive, "an exponent is finite and positive")?;
        for Term { contact, alpha } in &self.terms {
            checked("terms.contact", contact, bonds, constant, rule)?;
            require(positive(*alpha), "terms.alpha", alpha, "an exponent is finite and positive")?;
        }
        if self.table.is_some() {
            require(self.alpha.is_empty(), "alpha", beside("table"), "a table is in place of powers of the overlap")?;
        }
        checked("overlap", &self.overlap, bonds, f64::is_finite, "a static overlap is finite; negative for a gap")?;
        checked("spring", &self.spring, bonds, not_negative, "a spring constant is finite and at least zero")?;
        checked(
            "magnet",
            &self.magnet,
            bonds,
            not_negative,
            "the force of magnets at rest is finite and at least zero",
        )?;
        checked("distance", &self.distance, bonds, positive, "a distance of magnets is finite and positive")?;
        if !self.magnet.is_empty() {
            require(!self.distance.is_empty(), "distance", NOTHING, "magnets have a distance at rest")?;
            let good = self.decay.is_finite() && self.decay > 1.0;
            require(good, "decay", self.decay, "the force of magnets decays with a finite power above 1")?;
        }
        if let Some(Dissipation { kind, strength }) = &self.dissipation {
            let rule = "the dissipation of a contact is finite and at least zero";
            checked("dissipation", strength, bonds, not_negative, rule)?;
            require(!strength.is_empty(), "dissipation", "[]", "one number for each bond that can touch")?;
            let (law, rule) = (self.own_law(), "the force of contacts that dissipate has one power of the overlap");
            require(law.is_none(), law.unwrap_or_default(), beside(kind.name()), rule)?;
            let (least, rule) = kind.exponents();
            let alphas = if self.alpha.is_empty() { &[alpha] } else { &self.alpha[..] };
            refuse("alpha", alphas.iter().find(|&&alpha| alpha <= least), rule)?;
            let (beta, alpha) = (self.beta, alphas.iter().copied().fold(f64::INFINITY, f64::min));
            let good = beta.is_finite() && beta >= 0.0 && (self.pull || beta + 1.0 <= alpha.max(1.0));
            let rule = "the power of the overlap in a dashpot is at least zero, and at most alpha - 1 unless contacts may pull";
            require(*kind != Kind::Dashpot || good, "beta", beta, rule)?;
            let (power, rule) = (self.rate_power.unwrap_or(1.0), "of a dashpot: finite and at least 1");
            let good = power.is_finite() && power >= 1.0 && (power == 1.0 || *kind == Kind::Dashpot);
            require(good, "rate_power", power, rule)?;
        }
        Ok(())
    }

    /// The law of the `k`-th bond that can touch, with exponent and static overlap of the chain
    /// where it has none of its own; without [`terms`](Self::terms). In place of a table it is a
    /// linear force that is nowhere smaller or less steep.
    pub fn law<R: Real>(&self, k: usize, alpha: f64, rest: f64) -> BondLaw<R> {
        let loss = self.dissipation.as_ref().map(|Dissipation { kind, strength }| (*kind, strength[k]));
        let of = |list: &[f64], otherwise: f64| entry(list, k, otherwise);
        let (steepest, alpha) = self.table.as_ref().map_or((1.0, alpha), |table| (table.steepest(), 1.0));
        let constant = of(&self.contact, 1.0) * steepest;
        let law = BondLaw::new(constant, of(&self.alpha, alpha), of(&self.overlap, rest), loss);
        let rate_power = R::of(self.rate_power.unwrap_or(1.0));
        BondLaw { beta: R::of(self.beta), rate_power, pulls: self.pull && law.dissipates(), ..law }
    }

    /// What gives contacts another force than one power of the overlap, if something does: `table`
    /// or `terms`.
    pub fn own_law(&self) -> Option<&'static str> {
        let terms = (!self.terms.is_empty()).then_some("terms");
        self.table.as_ref().map(|_| "table").or(terms)
    }

    /// The spring and the magnets of the `k`-th bond that can touch.
    pub fn joint<R: Real>(&self, k: usize) -> Joint<R> {
        let [spring, magnet] = [&self.spring, &self.magnet].map(|list| R::of(entry(list, k, 0.0)));
        let none = Joint::none();
        if magnet == R::zero() {
            return Joint { spring, ..none };
        }
        Joint { spring, magnet, distance: R::of(self.distance[k]), decay: R::of(self.decay) }
    }

    /// The largest displacement that a drive prescribes; if no drive moves its bead, what the
    /// largest acceleration by a driving force or by gravity moves one in this time; zero without
    /// these.
    pub(crate) fn scale(&self, time: f64) -> f64 {
        let largest = |kind: DriveKind| {
            let of = |drive: &Drive| match kind {
                DriveKind::Displacement => drive.signal.reach(time),
                DriveKind::Force => drive.signal.size() / entry(&self.mass, drive.site, 1.0),
            };
            self.drives.iter().filter(|drive| drive.kind == kind).map(of).fold(0.0, f64::max)
        };
        match largest(DriveKind::Displacement) {
            0.0 => largest(DriveKind::Force).max(self.gravity.abs()) * time * time,
            size => size,
        }
    }

    /// The parts of site `i` of a chain.
    fn site<R: Real>(&self, params: Params, i: usize) -> Result<SiteData<R>> {
        let (mass, kappa) = (entry(&self.mass, i, 1.0), entry(&self.kappa, i, params.kappa));
        let rho = entry(&self.rho, i, params.rho);
        let own = Params::new(params.alpha, kappa / mass, rho)?;
        let [onsite, drag, dashpot] = [&self.onsite, &self.drag, &self.dashpot].map(|list| entry(list, i, 0.0));
        if dashpot > 0.0 && own.resonators() == Resonators::None {
            let value = format!("{dashpot} at site {i}");
            return Err(Error::parameter("dashpot", value, "a dashpot is beside a spring: kappa and rho are positive"));
        }
        let (kappa, rho, onsite) = match own.resonators() {
            Resonators::None if onsite > 0.0 => (onsite, f64::INFINITY, 0.0),
            Resonators::Fixed => (kappa + onsite, rho, 0.0),
            _ => (kappa, rho, onsite),
        };
        let own = Params::new(params.alpha, kappa / mass, rho)?;
        let moved = self.drives.iter().any(|drive| drive.site == i && drive.kind == DriveKind::Displacement);
        if moved && (own.resonators() != Resonators::None || drag > 0.0) {
            let rule = "a bead that is moved has no resonator, no spring and no drag: kappa or rho, onsite and drag are zero \
                        there, and tau is inf, as by except = [[site, inf]]";
            return Err(Error::parameter("drive", format!("moves site {i}"), rule));
        }
        let [mass, kappa, rho, onsite, drag, dashpot] = [mass, kappa, rho, onsite, drag, dashpot].map(R::of);
        Ok(SiteData { mass, kappa, rho, onsite, drag, dashpot, resonators: own.resonators(), moved })
    }

    fn check_drives(&self, sites: usize) -> Result<()> {
        for (k, drive) in self.drives.iter().enumerate() {
            require(drive.site < sites, "drive.site", drive.site, "a site of the chain, counted from 0")?;
            drive.signal.check(drive.kind)?;
            // A force on a moved bead would have no effect: its position is prescribed.
            let differs = |other: &Drive| other.site == drive.site && other.kind != drive.kind;
            let rule = "a bead that is moved is not pushed: its position is prescribed";
            require(!self.drives[..k].iter().any(differs), "drive.site", drive.site, rule)?;
        }
        Ok(())
    }
}
