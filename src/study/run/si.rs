//! The result of a run in the units of its report.

use super::CONTACT_COLUMNS;
use crate::{
    chain::{Contact, Energy, Layout},
    error::{Error, Failed},
    run::{Trajectory, Warning},
    scene::{Quantity, Scene, Units},
};
use hertzchain_integrators::Error as Failure;

/// Converts a trajectory of a scene with `[units]` to metres, seconds, joules and the units made of
/// them: times, states with their ledger, strains, energies, contacts, crossings and the
/// numbers of warnings and of a failure. The energy error and [`Trajectory::extremes`], whose
/// quantities are not known, are not converted, and nothing is without units.
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
    outcome.crossings.iter_mut().for_each(|crossing| crossing.t *= units.time_s);
    for warning in &mut outcome.warnings {
        if let Warning::Unresolved { length, step, .. } = warning {
            *length *= units.time_s;
            *step *= units.time_s;
        }
    }
    outcome.failure = outcome.failure.map(|failed| failed_in_si(failed, layout, units));
    outcome
}

/// Converts a state with its ledger: displacements, velocities and energies.
pub fn state_in_si(state: &mut [f64], layout: Layout, units: &Units) {
    state.iter_mut().enumerate().for_each(|(i, entry)| *entry *= unit_of_entry(i, layout, units));
}

fn unit_of_entry(i: usize, layout: Layout, units: &Units) -> f64 {
    match i / layout.half() {
        0 => units.length_m,
        1 => units.velocity_m_per_s,
        _ => units.energy_j,
    }
}

fn failed_in_si(Failed { cause, h, place, largest, .. }: Failed, layout: Layout, units: &Units) -> Failed {
    let largest = largest.map(|one| Box::new((one.0, one.1 * unit_of_entry(one.0, layout, units))));
    Failed { cause: failure_in_si(cause, units), h: h.map(|h| h * units.time_s), place, largest, si: true }
}

fn failure_in_si(mut cause: Failure, units: &Units) -> Failure {
    let (t, h) = match &mut cause {
        Failure::Unstable { quantity, initial, value, t, .. } => {
            let unit = if *quantity == "energy" { units.energy_j } else { 1.0 };
            [initial, value].into_iter().for_each(|energy| *energy *= unit);
            (t, None)
        }
        Failure::NotFinite { t, .. } | Failure::TooManySteps { t, .. } | Failure::Stopped { t } => (t, None),
        Failure::StepUnderflow { t, h } => (t, Some(h)),
        Failure::BeyondLaw { t, overlap, last, .. } => {
            [overlap, last].into_iter().for_each(|length| *length *= units.length_m);
            (t, None)
        }
        Failure::NotSettled { t, h, residual } => {
            *residual *= units.force_n;
            (t, Some(h))
        }
        Failure::NoContraction { t, h, residual, .. } => {
            *residual *= units.to_si(Quantity::Momentum, 1.0);
            (t, Some(h))
        }
        _ => return cause,
    };
    [t].into_iter().chain(h).for_each(|time| *time *= units.time_s);
    cause
}

/// An error of a run of a scene, in the units of its file.
pub(in crate::study) fn error_in_file(error: Error, scene: &Scene) -> Error {
    error_in(error, scene, scene.units())
}

/// An error of a run of a scene, in these units.
pub(in crate::study) fn error_in(error: Error, scene: &Scene, units: Option<&Units>) -> Error {
    match (error, units) {
        (Error::Run(failed), Some(units)) => failed_in_si(failed, scene.chain().layout(), units).into(),
        (Error::Integration(cause), Some(units)) => failure_in_si(cause, units).into(),
        (error, Some(units)) => scene.file().restated(error, units),
        (error, None) => error,
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
    let mut numbers = contact.numbers();
    numbers.iter_mut().zip(CONTACT_COLUMNS).for_each(|(x, (_, kind))| *x = units.to_si(kind, *x));
    Contact::of_numbers(&numbers).unwrap_or(*contact)
}
