//! The result of a run in the units of its report.

use crate::{
    chain::{Contact, Energy, Layout},
    run::Trajectory,
    scene::Units,
};

/// Converts a trajectory of a scene with `[units]` to metres, seconds, joules and the units made of
/// them: times, states with their ledger, strains, energies, contacts and maxima. The energy error
/// and the text of a failure are not converted, and nothing is without units.
#[must_use]
pub fn in_units(mut outcome: Trajectory, layout: Layout, units: Option<&Units>) -> Trajectory {
    let Some(units) = units else { return outcome };
    let state = |state: &mut [f64]| state_in_si(state, layout, units);
    outcome.t *= units.time_s;
    state(&mut outcome.state);
    outcome.energy = outcome.energy.map(|energy| scaled(energy, units.energy_j));
    for sample in &mut outcome.samples {
        sample.t *= units.time_s;
        sample.energy = sample.energy.map(|energy| scaled(energy, units.energy_j));
    }
    for profile in &mut outcome.profiles {
        profile.t *= units.time_s;
        profile.x.iter_mut().for_each(|x| *x *= units.length_m);
        state(&mut profile.state);
    }
    outcome.contacts.iter_mut().flatten().for_each(|contact| *contact = contact_in_si(contact, units));
    for maximum in outcome.maxima.iter_mut().flatten() {
        maximum.t *= units.time_s;
        maximum.overlap *= units.length_m;
    }
    outcome
}

/// Converts a state with its ledger: displacements, velocities and energies.
pub fn state_in_si(state: &mut [f64], layout: Layout, units: &Units) {
    let half = layout.half();
    for (i, entry) in state.iter_mut().enumerate() {
        *entry *= match i {
            i if i < half => units.length_m,
            i if i < 2 * half => units.velocity_m_per_s,
            _ => units.energy_j,
        };
    }
}

fn scaled(energy: Energy<f64>, by: f64) -> Energy<f64> {
    let Energy { beads, resonators, springs, contacts, dissipated, driven } = energy;
    let [beads, resonators, springs] = [beads, resonators, springs].map(|one| one * by);
    let [contacts, dissipated, driven] = [contacts, dissipated, driven].map(|one| one * by);
    Energy { beads, resonators, springs, contacts, dissipated, driven }
}

/// A contact in SI units.
#[must_use]
pub fn contact_in_si(contact: &Contact, units: &Units) -> Contact {
    let times = |by: f64| move |value: Option<f64>| value.map(|value| value * by);
    let (time, speed, length) = (times(units.time_s), times(units.velocity_m_per_s), times(units.length_m));
    Contact {
        bond: contact.bond,
        onset: time(contact.onset),
        release: time(contact.release),
        approach: speed(contact.approach),
        separation: speed(contact.separation),
        largest_overlap: contact.largest_overlap * units.length_m,
        impulse: contact.impulse * units.force_n * units.time_s,
        t_largest: contact.t_largest * units.time_s,
        onset_overlap: length(contact.onset_overlap),
        release_overlap: length(contact.release_overlap),
        force_end: time(contact.force_end),
        peak_force: contact.peak_force * units.force_n,
        t_peak: contact.t_peak * units.time_s,
    }
}
