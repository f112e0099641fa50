//! A chain with details: what it is made from, and what it tells about them.

use super::{
    super::{Chain, Layout, Resonators},
    Acting, Bond, CheckedDetails, Details, DriveKind, Joint, Signal, SiteData,
};
use crate::error::{EQUAL_BEADS, Error, Result, finite, require};
use hertzchain_integrators::{Real, law::BondLaw, regularised::common_power};
use std::sync::Arc;

impl<R: Real> Chain<R> {
    /// The same chain with details; see [`Details`]. Methods that need a uniform, conservative
    /// chain refuse it.
    ///
    /// # Errors
    /// A list of the wrong length, or a value outside its rule; a strain ring, whose unknowns
    /// assume that all beads are equal.
    pub fn with(mut self, details: &Details) -> Result<Self> {
        require(!self.topology.strains(), "boundary", "strain-ring", EQUAL_BEADS)?;
        let (n, touching) = (self.sites(), self.touching());
        details.check(n, touching.len(), self.params.alpha)?;
        details.check_drives(n)?;
        finite("gravity", details.gravity)?;
        let rest = self.precompression.f64();
        let given = (&details.terms[..], details.table.as_ref(), &details.contact[..]);
        let own = |bond: usize| bond.checked_sub(touching.start).filter(|&k| k < touching.len());
        let bond = |bond: usize| match own(bond) {
            Some(k) => Bond::new(details.law(k, self.params.alpha, rest), given, k),
            None => Bond::new(BondLaw::new(0.0, self.params.alpha, 0.0, None), given, 0),
        };
        let sites = (0..n).map(|i| details.site(self.params, i)).collect::<Result<Vec<SiteData<R>>>>()?;
        let bonds: Vec<Bond<R>> = (0..=n).map(bond).collect();
        let joined = details.spring.iter().chain(&details.magnet).any(|&by| by > 0.0);
        let joint = |bond: usize| own(bond).map_or(Joint::none(), |k| details.joint(k));
        let joints = (0..=n).filter(|_| joined).map(joint).collect();
        let damped = sites.iter().any(|site| site.drag + site.dashpot > R::zero());
        let dissipative = bonds.iter().any(|bond| bond.dissipates());
        let moving = sites.iter().any(|site| site.resonators == Resonators::Moving);
        let acting = Acting::of(&details.drives);
        let parts = CheckedDetails { given: details.clone(), acting, sites, bonds, joints, damped, dissipative };
        self.layout = Layout::new(n, moving).with_ledger(parts.open());
        self.precompression = R::zero();
        self.details = Some(Arc::new(parts));
        Ok(self)
    }

    /// The details, if the chain has some.
    pub fn details(&self) -> Option<&Details> {
        self.details.as_deref().map(|parts| &parts.given)
    }

    /// Whether energy is dissipated or driven: the state has a [`Ledger`](crate::chain::Ledger).
    pub fn open(&self) -> bool {
        self.details.as_deref().is_some_and(CheckedDetails::open)
    }

    /// Whether energy is conserved, but for the work of weights and of constant forces.
    pub fn conservative(&self) -> bool {
        let steady = |parts: &CheckedDetails<R>| {
            !(parts.damped || parts.dissipative) && parts.acting.iter().all(Acting::pushes_steadily)
        };
        self.details.as_deref().is_none_or(steady)
    }

    /// Bonds whose contacts dissipate.
    pub(crate) fn lossy(&self) -> Vec<usize> {
        self.touching().filter(|&bond| self.dissipates(bond)).collect()
    }

    /// Whether the contact of a bond dissipates.
    pub(crate) fn dissipates(&self, bond: usize) -> bool {
        self.parts().is_some_and(|parts| parts.bonds[bond].dissipates())
    }

    /// Whether contacts dissipate.
    pub fn dissipative_contacts(&self) -> bool {
        self.details.as_deref().is_some_and(|parts| parts.dissipative)
    }

    /// Why contact collocation cannot follow the chain, and a method that can; `None` if it can.
    pub fn beyond_collocation(&self) -> Option<&'static str> {
        let parts = self.parts()?;
        if parts.sites.iter().any(|site| site.onsite > R::zero()) {
            return Some(
                "its sites have one frequency, and here beads with on-site springs have resonators that move: take \
                 dop853-regularised",
            );
        }
        if parts.dissipative && self.details()?.rate_power.is_some_and(|power| power != 1.0) {
            return Some(
                "its contacts resist in proportion to the rate, and here as a power of it: take dop853-regularised",
            );
        }
        if self.details()?.own_law().is_some() {
            return Some(
                "it needs contacts of one power of the overlap, not of a sum or a table: take dop853-regularised",
            );
        }
        let rule = "between contacts its sites move on their own, and here springs or magnets join beads: take \
                    dop853-regularised";
        parts.joined().then_some(rule)
    }

    /// Refuses a state in which the magnets of two beads have met.
    ///
    /// # Errors
    /// Two beads with magnets that are nearer by their distance at rest, or by more.
    pub fn magnets_apart(&self, y: &[R]) -> Result<()> {
        let strain = |bond: usize| self.across(bond, |i| self.layout.u(y)[i]);
        let joint = |bond: usize| self.parts().and_then(|parts| parts.joint(bond));
        let meets = |joint: &Joint<R>, bond| joint.magnet > R::zero() && strain(bond) >= joint.distance;
        match self.touching().find(|&bond| joint(bond).is_some_and(|joint| meets(joint, bond))) {
            None => Ok(()),
            Some(bond) => {
                let rule = "beads with magnets are nearer, by x, by less than the distance of these at rest";
                Err(Error::parameter("state", format!("x = {:e} at bond {bond}", strain(bond).f64()), rule))
            }
        }
    }

    /// Refuses a chain with details, for methods that assume equal beads without damping,
    /// dissipation and drives. `what` names the method in the error message.
    ///
    /// # Errors
    /// A chain with details.
    pub fn uniform(&self, what: &str) -> Result<()> {
        match &self.details {
            None => Ok(()),
            Some(_) => {
                let rule = "it needs equal beads, without damping or drives";
                Err(Error::parameter("chain", format!("of beads that differ, are damped or driven, for {what},"), rule))
            }
        }
    }

    /// Times at which drives are not smooth: ends of ramps, starts and ends of bursts, times of
    /// tables.
    pub(crate) fn breaks(&self) -> Vec<f64> {
        let acting = self.parts().into_iter().flat_map(CheckedDetails::acting);
        acting.flat_map(|acting| &acting.signals).flat_map(Signal::breaks).collect()
    }

    /// The drives that move their beads, one for each bead.
    pub(crate) fn movers(&self) -> impl Iterator<Item = &Acting> {
        let acting = self.parts().into_iter().flat_map(CheckedDetails::acting);
        acting.filter(|acting| acting.kind == DriveKind::Displacement)
    }

    /// Sets the beads that drives move to their positions and velocities at time `t`.
    pub(crate) fn follow(&self, t: R, y: &mut [R]) {
        for drive in self.movers() {
            let [s, s_dot, _] = drive.at(t);
            (y[drive.site], y[self.layout.half() + drive.site]) = (s, s_dot);
        }
    }

    /// Kinetic energy of the beads that drives move. It is part of the work of drives. Methods
    /// integrate the rest, which is smaller by many orders where a ramp is short.
    pub(crate) fn kinetic_of_moved(&self, t: R) -> R {
        self.movers().fold(R::zero(), |sum, drive| {
            let speed = drive.at(t)[1];
            sum + R::of(0.5) * self.masses(drive.site)[0] * (speed * speed)
        })
    }

    /// For DOP853 of order `p` from event to event: the smallest power of time with which the field
    /// begins at an event, and the power of the map at singular ends.
    pub fn powers_at_events(&self, p: u32) -> (f64, u32) {
        match self.parts() {
            Some(parts) => parts.map(p),
            None => (self.params.alpha, common_power(&[self.params.alpha], p)),
        }
    }

    /// The contact force of a bond at an overlap and its rate, dissipation included.
    pub fn bond_force(&self, bond: usize, g: R, rate: R) -> R {
        match self.parts() {
            Some(parts) => parts.bonds[bond].force(g, rate),
            None => self.law.force(g),
        }
    }

    /// Whether the beads that drives move have the prescribed positions and velocities at time `t`,
    /// to 1e-9 of the drive's reach and speed, of a steady one also in the unit of the motion's
    /// time. The error is a site that has not.
    pub fn follows_drives(&self, y: &[R], t: R) -> std::result::Result<(), usize> {
        let (u, u_dot) = (self.layout.u(y), self.layout.u_dot(y));
        let time = t.f64().max(self.natural(y).time);
        for drive in self.movers() {
            let [s, s_dot, _] = drive.at(t);
            let sum = |of: &dyn Fn(&Signal) -> f64| R::of(drive.signals.iter().map(of).sum::<f64>());
            let scale = sum(&|signal| signal.reach(time)).max(R::of(f64::MIN_POSITIVE));
            let (near, slow) = (R::of(1e-9) * scale, R::of(1e-9) * sum(&Signal::speed));
            if (u[drive.site] - s).abs() > near || (u_dot[drive.site] - s_dot).abs() > slow {
                return Err(drive.site);
            }
        }
        Ok(())
    }
}
