//! Reports of contacts.

use crate::{
    chain::Contact,
    error::Result,
    output::{Array, npz},
};
use serde::Serialize;

/// The columns of the tables: the fields of a [`Contact`].
pub const CONTACT_COLUMNS: [&str; Contact::NUMBERS] = [
    "bond",
    "onset",
    "release",
    "approach",
    "separation",
    "largest_overlap",
    "impulse",
    "t_largest",
    "onset_overlap",
    "release_overlap",
    "force_end",
    "peak_force",
    "t_peak",
];

/// Least number of bonds that a pulse runs over, for its speed to be told.
const PULSE: usize = 8;

/// The contacts as CSV, a line for each; `nan` stands for what a contact does not have, such as a
/// release after the end.
pub fn contacts_csv(contacts: &[Contact]) -> Vec<u8> {
    let number = |value: &f64| if value.is_nan() { "nan".to_owned() } else { format!("{value:e}") };
    let mut text = CONTACT_COLUMNS.join(",") + "\n";
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
        CONTACT_COLUMNS.iter().enumerate().map(|(k, &name)| Array::vector(name, column(k))).collect();
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

/// What a bond has seen in a run: its contacts, their impulse, and the contact with the largest force.
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
pub(in crate::study) fn bond_columns(positions: Vec<f64>, contacts: &[Contact]) -> [(&'static str, Vec<f64>); 7] {
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
/// may have its largest force yet to come and does not count.
fn pulse(bonds: &[Seen]) -> Option<[usize; 2]> {
    let arrival = |n: usize| bonds[n].strongest.filter(|one| one.release.is_some()).map(|one| one.t_peak);
    let (mut longest, mut starts) = ([0_usize; 2], [0_usize; 2]);
    for n in 1..bonds.len() {
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
pub(in crate::study) fn pulse_line(positions: &[f64], unit: &str, contacts: &[Contact]) -> Option<String> {
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

/// The contacts as bars over time, up to `t_end`; `how` tells in a sentence how they were computed.
///
/// # Errors
/// A picture that cannot be drawn.
#[cfg(feature = "plot")]
pub fn contacts_picture(
    scene: &crate::scene::Scene,
    how: &str,
    t_end: f64,
    contacts: &[Contact],
    si: Option<&crate::scene::Units>,
) -> Result<crate::figures::Picture> {
    use crate::{
        chain::Overlaps,
        figures::{Bar, Raster, raster},
    };
    use crate::{scene::Quantity, study::si::Scale};
    use hertzchain_integrators::EventFunctions;
    let bar = |contact: &Contact| {
        let start = contact.onset.unwrap_or(0.0);
        Bar {
            bond: contact.bond as f64,
            start,
            end: contact.release.unwrap_or(t_end.max(start)),
            shade: contact.largest_overlap,
        }
    };
    let overlaps = Overlaps::new(scene.chain().clone());
    let [first, last] = [0, overlaps.count().saturating_sub(1)].map(|index| overlaps.bond(index) as f64);
    let what =
        "A bar is a contact of a bond from its onset to its release, darker where its largest overlap is larger.";
    let figure = Raster {
        title: format!("{}: contacts over time", scene.name()),
        bond_label: "bond n".to_owned(),
        time_label: Scale(si).label("time t", Quantity::Time),
        shade_label: Scale(si).label("largest overlap of the contact", Quantity::Length),
        bars: contacts.iter().map(bar).collect(),
        bonds: (first, last),
        times: (0.0, t_end),
        caption: format!("{what} {}", crate::study::provenance(scene, how)),
    };
    Ok(raster(&figure)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::Archive;
    use std::path::Path;

    /// One contact that was there at the start, one whole, one that lasts to the end.
    fn three() -> [Contact; 3] {
        let whole = Contact {
            bond: 12,
            onset: Some(0.1),
            release: Some(0.4),
            approach: Some(1.0 / 3.0),
            separation: Some(0.3),
            largest_overlap: 2e-5,
            impulse: 0.25,
            t_largest: 0.2,
            onset_overlap: Some(0.0),
            release_overlap: Some(2e-8),
            force_end: Some(0.35),
            peak_force: 4e-6,
            t_peak: 0.15,
        };
        let early = Contact { bond: 3, onset: None, approach: None, release: Some(7.0), impulse: 0.5, ..whole };
        let early = Contact { onset_overlap: None, ..early };
        let late = Contact { release: None, separation: None, largest_overlap: 5e-5, ..whole };
        let late = Contact { release_overlap: None, force_end: None, ..late };
        [early, whole, late]
    }

    #[test]
    fn the_csv_reads_back() {
        let text = String::from_utf8(contacts_csv(&three())).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let columns = "bond,onset,release,approach,separation,largest_overlap,impulse,t_largest";
        assert_eq!(lines[0], format!("{columns},onset_overlap,release_overlap,force_end,peak_force,t_peak"));
        assert_eq!(lines[1], "3,nan,7e0,nan,3e-1,2e-5,5e-1,2e-1,nan,2e-8,3.5e-1,4e-6,1.5e-1");
        assert_eq!(lines.len(), 4);
        for (line, contact) in lines[1..].iter().zip(&three()) {
            let numbers: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            assert_eq!(numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), contact.numbers().map(f64::to_bits));
        }
        assert_eq!(contacts_csv(&[]).iter().filter(|&&byte| byte == b'\n').count(), 1);
    }

    #[test]
    fn the_archive_holds_the_columns() {
        for contacts in [&three()[..], &[]] {
            let archive = Archive::from_bytes(Path::new("contacts.npz"), &contacts_npz(contacts).unwrap()).unwrap();
            for (k, name) in CONTACT_COLUMNS.iter().enumerate() {
                let column = archive.array(name, &[contacts.len() as u64]).unwrap();
                let expected = contacts.iter().map(|contact| contact.numbers()[k].to_bits());
                assert!(column.iter().map(|x| x.to_bits()).eq(expected), "{name}");
            }
        }
    }

    #[test]
    fn the_totals_count_what_there_was() {
        let [_, whole, late] = three();
        let totals = ContactTotals {
            contacts: 3,
            onsets: 2,
            releases: 2,
            open_at_end: 1,
            bonds: 2,
            largest_overlap: Some(5e-5),
            longest: Some(0.4 - 0.1),
            shortest: Some(0.4 - 0.1),
            impulse: 1.0,
        };
        assert_eq!(contact_totals(&three()), totals);
        assert_eq!(contact_totals(&[]), ContactTotals::default());
        assert_eq!(contact_totals(&[late]).longest, None);
        let longer = Contact { release: Some(9.0), ..whole };
        let totals = contact_totals(&[longer, whole]);
        assert_eq!((totals.shortest, totals.longest), (Some(0.4 - 0.1), Some(9.0 - 0.1)));
        let json = serde_json::to_value(contact_totals(&[])).unwrap();
        assert!(json["largest_overlap"].is_null() && json["impulse"] == 0.0 && json["contacts"] == 0);
    }

    #[test]
    fn a_pulse_is_seen_where_the_largest_force_arrives_at_one_bond_after_the_other() {
        let [_, whole, _] = three();
        // A pulse of speed 2 from bond 3 to bond 12 and a weaker one back, which is over before it
        // has come to the last bonds.
        let at = |bond: usize, t_peak: f64, peak_force: f64| Contact { bond, t_peak, peak_force, ..whole };
        let there = (3..=12).map(|n| at(n, n as f64 / 2.0, 1.0));
        let back = (6..=12).map(|n| at(n, 20.0 - n as f64 / 2.0, 0.5));
        let contacts: Vec<_> = there.chain(back).collect();
        let positions: Vec<f64> = (0..=13).map(f64::from).collect();
        let line = pulse_line(&positions, "m/s", &contacts).unwrap();
        assert!(
            line.contains("2.000000e0 m/s from bond 7 to bond 12; largest force 1.000000e0 at the first"),
            "{line}"
        );
        assert_eq!(pulse(&seen(14, &contacts)), Some([3, 12]));
        // The other way round.
        let left = |contact: &Contact| Contact { bond: 15 - contact.bond, ..*contact };
        assert_eq!(pulse(&seen(14, &contacts.iter().map(left).collect::<Vec<_>>())), Some([12, 3]));
        assert_eq!(pulse_line(&positions, "m/s", &contacts[..PULSE - 1]), None);
        let columns = bond_columns(positions, &contacts);
        assert_eq!(columns.each_ref().map(|(_, column)| column[6])[..5], [6.0, 2.0, 0.5, 0.1, 3.0]);
        assert!(columns.iter().all(|(name, column)| column.len() == 14 && (*name != "t_peak" || column[2].is_nan())));
    }

    #[test]
    fn the_lines_are_short() {
        assert_eq!(contact_lines(&[]), ["contacts    none"]);
        assert_eq!(
            contact_lines(&three()),
            [
                "contacts    3 (bonds 2, onsets 2, releases 2, open at the end 1)",
                "            lasted 3.000e-1 to 3.000e-1, largest overlap 5.000000e-5, impulse 1.000000e0",
            ]
        );
        assert!(contact_lines(&three()[2..])[1].trim().starts_with("largest"));
    }

    #[cfg(feature = "plot")]
    #[test]
    fn every_scene_can_show_its_contacts() {
        for (name, _) in crate::scene::Scene::list() {
            let scene = crate::scene::Scene::load(name).unwrap();
            for contacts in [&three()[..], &[]] {
                contacts_picture(&scene, "Integrator verlet.", 1.0, contacts, None).unwrap();
            }
        }
    }
}
