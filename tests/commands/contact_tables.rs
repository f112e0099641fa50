//! Tables of contacts.

use hertzchain::{
    chain::Contact,
    internals::{bond_columns, pulse_line},
    output::Archive,
    study::{CONTACT_COLUMNS, ContactTotals, contact_totals, contacts_csv, contacts_npz},
};
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
        for (k, (name, _)) in CONTACT_COLUMNS.iter().enumerate() {
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
    assert!(line.contains("2.000000e0 m/s from bond 7 to bond 12; largest force 1.000000e0 at the first"), "{line}");
    // The other way round.
    let left = |contact: &Contact| Contact { bond: 15 - contact.bond, ..*contact };
    let back: Vec<_> = contacts.iter().map(left).collect();
    let line = pulse_line(&positions, "m/s", &back).unwrap();
    assert!(line.contains("from bond 7 to bond 3;"), "{line}");
    assert_eq!(pulse_line(&positions, "m/s", &contacts[..7]), None);
    let columns = bond_columns(positions, &contacts);
    assert_eq!(columns.each_ref().map(|(_, column)| column[6])[..5], [6.0, 2.0, 0.5, 0.1, 3.0]);
    assert!(columns.iter().all(|(name, column)| column.len() == 14 && (*name != "t_peak" || column[2].is_nan())));
}
