//! The equations of motion of a chain with details, and the rates of its ledger.

use super::{
    super::{Chain, Ledger, Resonators},
    CheckedDetails, DriveKind, Pushing,
};
use hertzchain_integrators::Real;

/// Completes a state at time `t`, integrated by [`rates`] from time `start` on: where beads are
/// that drives move, and the work that goes into their kinetic energy.
pub(crate) fn complete<R: Real>(chain: &Chain<R>, start: R, t: R, y: &mut [R]) {
    if chain.movers().next().is_some() {
        chain.follow(t, y);
        y[chain.layout().dim() - 1] += chain.kinetic_of_moved(t) - chain.kinetic_of_moved(start);
    }
}

/// Writes the derivative of a state, entry by entry. Without `pushing` contacts that dissipate push
/// where the signs of their overlap and of their force say so.
pub(crate) fn rates<R: Real>(
    (chain, parts): (&Chain<R>, &CheckedDetails<R>),
    pushing: Option<&Pushing>,
    t: R,
    y: &[R],
    dy: &mut [R],
    force: &mut [R],
) {
    let (layout, n, half) = (chain.layout(), chain.sites(), chain.layout().half());
    let (u, u_dot) = (layout.u(y), layout.u_dot(y));
    let mut ledger = contacts((chain, parts), pushing, u, u_dot, force);
    dy[..half].copy_from_slice(&y[half..2 * half]);
    for (i, site) in parts.sites.iter().enumerate() {
        let (v, v_dot) = match (layout.v(y), layout.v_dot(y)) {
            (Some(v), Some(v_dot)) if site.resonators == Resonators::Moving => (v[i], v_dot[i]),
            _ => (R::zero(), R::zero()),
        };
        let (stretch, sliding) =
            if site.resonators == Resonators::None { (R::zero(), R::zero()) } else { (u[i] - v, u_dot[i] - v_dot) };
        let pull = site.kappa * stretch + site.dashpot * sliding;
        dy[half + i] = (force[i] - pull - site.onsite * u[i] - site.drag * u_dot[i]) / site.mass;
        if layout.resonators() {
            let moves = site.resonators == Resonators::Moving;
            dy[half + n + i] = if moves { pull / site.resonator() } else { R::zero() };
            dy[n + i] = if moves { v_dot } else { R::zero() };
        }
        ledger.drag += site.drag * u_dot[i] * u_dot[i];
        ledger.dashpots += site.dashpot * sliding * sliding;
    }
    for (i, weight) in parts.weights() {
        dy[half + i] += weight / parts.sites[i].mass;
        ledger.driven += weight * u_dot[i];
    }
    for drive in parts.acting() {
        let (i, [value, first, second]) = (drive.site, drive.at(t));
        match drive.kind {
            DriveKind::Force => {
                dy[half + i] += value / parts.sites[i].mass;
                ledger.driven += value * u_dot[i];
            }
            DriveKind::Displacement => {
                // Without the power that goes into the kinetic energy of the bead, see
                // `Chain::kinetic_of_moved`.
                ledger.driven -= force[i] * first;
                (dy[i], dy[half + i]) = (first, second);
            }
        }
    }
    if layout.has_ledger() {
        dy[2 * half..].copy_from_slice(&ledger.entries());
    }
}

/// Writes the contact forces on sites into `force`; returns the power that contacts dissipate.
fn contacts<R: Real>(
    (chain, parts): (&Chain<R>, &CheckedDetails<R>),
    pushing: Option<&Pushing>,
    u: &[R],
    u_dot: &[R],
    force: &mut [R],
) -> Ledger<R> {
    let zero = R::zero();
    let mut lost = zero;
    force.fill(zero);
    for bond in chain.touching() {
        let contact = &parts.bonds[bond];
        let told = pushing.filter(|_| contact.dissipates()).map(|pushing| pushing.pushes(bond));
        let strain = chain.across(bond, |i| u[i]);
        let (g, joint) = (contact.rest + strain, parts.joint(bond).map_or(zero, |joint| joint.force(strain)));
        if g <= zero && told != Some(true) && joint == zero {
            continue;
        }
        let rate = if contact.dissipates() { chain.across(bond, |i| u_dot[i]) } else { zero };
        let f = match told {
            None => contact.force(g, rate),
            Some(true) => contact.push(g, rate),
            Some(false) => zero,
        };
        if contact.dissipates() {
            lost += (f - contact.elastic(g)) * rate;
        }
        for &(site, weight) in chain.topology().pushed(bond).iter() {
            force[site] += R::of(weight) * (f + joint);
        }
    }
    Ledger { drag: zero, dashpots: zero, contacts: lost, driven: zero }
}
