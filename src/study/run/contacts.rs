//! Reports of contacts.

use crate::{
    chain::{Contact, Overlaps},
    error::Result,
    output::{Array, npz},
    report::{Bar, Raster},
    scene::{Quantity, Scene, Units},
    study::si::Scale,
};
use hertzchain_integrators::EventFunctions;
use serde::Serialize;

/// The columns of the tables, the fields of a [`Contact`], and the kinds of their numbers.
pub const CONTACT_COLUMNS: [(&str, Quantity); Contact::NUMBERS] = [
    ("bond", Quantity::Number),
    ("onset", Quantity::Time),
    ("release", Quantity::Time),
    ("approach", Quantity::Velocity),
    ("separation", Quantity::Velocity),
    ("largest_overlap", Quantity::Length),
    ("impulse", Quantity::Momentum),
    ("t_largest", Quantity::Time),
    ("onset_overlap", Quantity::Length),
    ("release_overlap", Quantity::Length),
    ("force_end", Quantity::Time),
    ("peak_force", Quantity::Force),
    ("t_peak", Quantity::Time),
];

/// Least number of bonds that a pulse runs over, for its speed to be told.
const PULSE: usize = 8;

/// The contacts as CSV, a line for each; `nan` stands for what a contact does not have, such as a
/// release after the end.
pub fn contacts_csv(contacts: &[Contact]) -> Vec<u8> {
    let number = |value: &f64| if value.is_nan() { "nan".to_owned() } else { format!("{value:e}") };
    let mut text = CONTACT_COLUMNS.map(|(name, _)| name).join(",") + "\n";
    for contact in contacts {
        let numbers: Vec<String> = contact.numbers()[1..].iter().map(number).collect();
        text += &format!("{},{}\n", contact.bond, numbers.join(","));
    }
    text.into_bytes()
}

/// The contacts as an NPZ archive, a vector for each column of the CSV, with its name; NaN stands
/// for what a contact does not have.
///
/// # Errors
/// Errors of the archive writer.
pub fn contacts_npz(contacts: &[Contact]) -> Result<Vec<u8>> {
    let column = |k: usize| contacts.iter().map(|contact| contact.numbers()[k]).collect();
    let arrays: Vec<Array<'_>> =
        CONTACT_COLUMNS.iter().enumerate().map(|(k, &(name, _))| Array::vector(name, column(k))).collect();
    npz(&arrays)
}

/// Totals over the contacts of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ContactTotals {
    /// Number of contacts.
    pub contacts: usize,
    /// Number of contacts that began during the run.
    pub onsets: usize,
    /// Number of contacts that ended during the run.
    pub releases: usize,
    /// Number of contacts that had not ended at the end of the run.
    pub open_at_end: usize,
    /// Number of bonds that touched.
    pub bonds: usize,
    /// The largest overlap, if there was a contact.
    pub largest_overlap: Option<f64>,
    /// The longest time between an onset and its release, if any contact has both.
    pub longest: Option<f64>,
    /// The shortest such time.
    pub shortest: Option<f64>,
    /// The sum of all impulses.
    pub impulse: f64,
}

/// Computes the totals over the contacts of a run.
pub fn contact_totals(contacts: &[Contact]) -> ContactTotals {
    let count = |has: fn(&Contact) -> bool| contacts.iter().filter(|contact| has(contact)).count();
    let durations = || contacts.iter().filter_map(|contact| Some(contact.release? - contact.onset?));
    let mut bonds: Vec<usize> = contacts.iter().map(|contact| contact.bond).collect();
    bonds.sort_unstable();
    bonds.dedup();
    ContactTotals {
        contacts: contacts.len(),
        onsets: count(|contact| contact.onset.is_some()),
        releases: count(|contact| contact.release.is_some()),
        open_at_end: count(|contact| contact.release.is_none()),
        bonds: bonds.len(),
        largest_overlap: contacts.iter().map(|contact| contact.largest_overlap).reduce(f64::max),
        longest: durations().reduce(f64::max),
        shortest: durations().reduce(f64::min),
        // An empty sum of floats is -0.
        impulse: contacts.iter().fold(0.0, |sum, contact| sum + contact.impulse),
    }
}

/// What a bond has seen in a run: its contacts, their impulse, and the contact with the largest
/// force.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    contacts: usize,
    impulse: f64,
    strongest: Option<Contact>,
}

/// What the first `bonds` bonds of a chain have seen, by their index.
fn seen(bonds: usize, contacts: &[Contact]) -> Vec<Seen> {
    let mut all = vec![Seen::default(); bonds];
    for contact in contacts {
        let Seen { contacts, impulse, strongest } = &mut all[contact.bond];
        (*contacts, *impulse) = (*contacts + 1, *impulse + contact.impulse);
        if strongest.is_none_or(|other| contact.peak_force > other.peak_force) {
            *strongest = Some(*contact);
        }
    }
    all
}

/// What each bond has seen, by its index: the number of its contacts and their impulse; and of the
/// contact with the largest force its onset, this force with its time, and how long it pushed; NaN
/// for what there is not. `positions` are those of the bonds.
pub fn bond_columns(positions: Vec<f64>, contacts: &[Contact]) -> [(&'static str, Vec<f64>); 7] {
    let all = seen(positions.len(), contacts);
    let strongest = |value: fn(&Contact) -> Option<f64>| {
        all.iter().map(|seen| seen.strongest.as_ref().and_then(value).unwrap_or(f64::NAN)).collect()
    };
    [
        ("position", positions),
        ("contacts", all.iter().map(|seen| seen.contacts as f64).collect()),
        ("impulse", all.iter().map(|seen| seen.impulse).collect()),
        ("onset", strongest(|one| one.onset)),
        ("t_peak", strongest(|one| Some(one.t_peak))),
        ("peak_force", strongest(|one| Some(one.peak_force))),
        ("duration", strongest(|one| Some(one.force_end? - one.onset?))),
    ]
}

/// The bonds at which the largest force arrives one after the other, the first and the last: of
/// those that follow each other so the most, and at least [`PULSE`]. A contact that has not ended
/// may have its largest force yet to come and does not count; nor does one at an end of the chain,
/// with a wall, whose force takes another time to rise.
fn pulse(bonds: &[Seen]) -> Option<[usize; 2]> {
    let arrival = |n: usize| bonds[n].strongest.filter(|one| one.release.is_some()).map(|one| one.t_peak);
    let (mut longest, mut starts) = ([0_usize; 2], [1_usize; 2]);
    for n in 2..bonds.len().saturating_sub(1) {
        let later = arrival(n - 1).zip(arrival(n)).map_or(0.0, |(before, here)| here - before);
        for (start, sign) in starts.iter_mut().zip([1.0, -1.0]) {
            if sign * later <= 0.0 {
                *start = n;
            }
            if n - *start > longest[0].abs_diff(longest[1]) {
                longest = if sign > 0.0 { [*start, n] } else { [n, *start] };
            }
        }
    }
    (longest[0].abs_diff(longest[1]) + 1 >= PULSE).then_some(longest)
}

/// The speed and the force of a pulse in the second half of its way, in a line; `unit` is that of
/// the speed.
pub fn pulse_line(positions: &[f64], unit: &str, contacts: &[Contact]) -> Option<String> {
    let bonds = seen(positions.len(), contacts);
    let [first, last] = pulse(&bonds)?;
    let middle = first.midpoint(last);
    let [before, here] = [bonds[middle].strongest?, bonds[last].strongest?];
    let speed = (positions[last] - positions[middle]).abs() / (here.t_peak - before.t_peak);
    Some(format!(
        "pulse       {speed:.6e} {unit} from bond {middle} to bond {last}; largest force {:.6e} at the first, {:.6e} at the last",
        before.peak_force, here.peak_force
    ))
}

/// The [totals](contact_totals) in one or two lines for people.
pub fn contact_lines(contacts: &[Contact]) -> Vec<String> {
    let totals = contact_totals(contacts);
    let ContactTotals { contacts, onsets, releases, open_at_end, bonds, impulse, .. } = totals;
    let Some(overlap) = totals.largest_overlap else { return vec!["contacts    none".to_owned()] };
    let lasted = match totals.shortest.zip(totals.longest) {
        Some((shortest, longest)) => format!("lasted {shortest:.3e} to {longest:.3e}, "),
        None => String::new(),
    };
    vec![
        format!(
            "contacts    {contacts} (bonds {bonds}, onsets {onsets}, releases {releases}, open at the end {open_at_end})"
        ),
        format!("            {lasted}largest overlap {overlap:.6e}, impulse {impulse:.6e}"),
    ]
}

/// The contacts as bars over time, up to the end of the run.
pub(super) fn raster(
    (scene, si): (&Scene, Option<&Units>),
    (time, end): (&str, f64),
    contacts: &[Contact],
    caption: &dyn Fn(&str) -> String,
) -> Raster {
    let bar = |contact: &Contact| {
        let start = contact.onset.unwrap_or(0.0);
        let end = contact.release.unwrap_or(end.max(start));
        Bar { bond: contact.bond as f64, start, end, shade: contact.largest_overlap }
    };
    let overlaps = Overlaps::new(scene.chain().clone());
    let what =
        "A bar is a contact of a bond from its onset to its release, darker where its largest overlap is larger.";
    Raster {
        title: format!("{}: contacts over time", scene.name()),
        bond_label: "bond n".to_owned(),
        time_label: time.to_owned(),
        shade_label: Scale(si).label("largest overlap of the contact", Quantity::Length),
        bars: contacts.iter().map(bar).collect(),
        bonds: (overlaps.bond(0) as f64, overlaps.bond(overlaps.count().saturating_sub(1)) as f64),
        times: (0.0, end),
        caption: caption(what),
    }
}
