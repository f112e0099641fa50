//! The log of contacts, from overlaps that are given as functions of time.

use hertzchain_core::{
    Boundary, Chain, Params,
    chain::{Contact, ContactLog, Contacts, TOUCH},
    integrators::{collocation::Piece, events::Curve},
};

fn log() -> ContactLog {
    ContactLog::new(Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 2).unwrap())
}

fn piece(curve: Curve, impulse: f64) -> Piece {
    let largest = curve.largest();
    Piece { bond: 0, onset: None, release: None, impulse, largest, error: 0.0, peak: (0.0, 0.0), curve: Some(curve) }
}

/// The contacts of an overlap that is given in stretches of length `h`: those that end on the way,
/// and the one under way at the end. `rates` are those at its zeros at start and end, if there are
/// any.
fn contacts(g: impl Fn(f64) -> f64, (start, end): (f64, f64), rates: [Option<f64>; 2], h: f64) -> Vec<Contact> {
    let (mut log, count) = (log(), ((end - start) / h).round() as usize);
    for k in 0..count {
        let [from, to] = [k, k + 1].map(|k| start + (end - start) * k as f64 / count as f64);
        let points = (0..8).map(|k| f64::from(k) / 7.0).map(|x| (x, g(from + (to - from) * x)));
        let event = |at: usize, t: f64, rate: Option<f64>| rate.filter(|_| at == k).map(|rate| (t, rate));
        let (onset, release) = (event(0, 0.0, rates[0]), event(count - 1, to - from, rates[1]));
        log.take(&Piece { onset, release, ..piece(Curve::over((0.0, to - from), points), 0.25) }, (from, to));
    }
    let contacts = log.into_contacts();
    let all = if rates[1].is_some() { contacts.ended } else { contacts.list() };
    assert!((all.iter().map(|contact| contact.impulse).sum::<f64>() - 0.25 * count as f64).abs() < 1e-12);
    all
}

#[test]
fn a_contact_that_comes_through_zero_begins_and_ends_there() {
    for h in [0.1, 0.3, 3.0] {
        let [contact] = contacts(|t| t * (3.0 - t), (0.0, 3.0), [Some(3.0), Some(-3.0)], h)[..] else { panic!() };
        let Contact { onset, release, approach, separation, t_largest, .. } = contact;
        assert_eq!([onset, release, approach, separation], [Some(0.0), Some(3.0), Some(3.0), Some(3.0)]);
        assert_eq!([contact.onset_overlap, contact.release_overlap], [Some(0.0); 2]);
        assert!((t_largest - 1.5).abs() < 1e-13 && (contact.largest_overlap - 2.25).abs() < 1e-14);
        assert!(contact.t_peak == t_largest && (contact.peak_force - 3.375).abs() < 3e-14);
    }
}

#[test]
fn beads_that_touch_begin_to_press_at_a_share_of_the_largest_overlap() {
    // Closed form: exp(-cosh t) has its largest value 1/e at 0, and TOUCH of it where cosh t =
    // 1 + ln(1/TOUCH). The times that are given as its zeros do not matter.
    let t = (1.0 - TOUCH.ln()).acosh();
    for (from, to, noise) in [(-6.0, 6.0, 0.0), (-4.0, 5.0, 1e-8), (-5.0, 4.0, -1e-8)] {
        for h in [0.02, 0.1] {
            let got = contacts(|t| f64::exp(-t.cosh()), (from, to), [Some(noise), Some(noise)], h);
            let [contact] = got[..] else { panic!("{got:?}") };
            let (onset, release) = (contact.onset.unwrap(), contact.release.unwrap());
            let bound = if h > 0.05 { 3e-8 } else { 1e-12 };
            assert!((onset + t).abs() < bound && (release - t).abs() < bound, "{h}: {contact:?}");
            assert!((contact.approach.unwrap() - contact.separation.unwrap()).abs() < 10.0 * bound);
            let level = TOUCH * contact.largest_overlap;
            assert_eq!([contact.onset_overlap, contact.release_overlap], [Some(level); 2]);
        }
    }
    // At the end of the run the contact has faded, or not yet; one that is about to open has
    // not.
    let at_end = |end: f64| contacts(|t| f64::exp(-t.cosh()), (-4.0, end), [Some(0.0), None], 0.02)[0];
    assert!((at_end(4.0).release.unwrap() - t).abs() < 1e-12);
    assert_eq!(at_end(t - 0.02).release, None);
    let opens = contacts(|t| t * (3.0 - t), (0.0, 2.9995), [Some(3.0), None], 0.00857);
    assert_eq!(opens[0].release, None);
}

#[test]
fn an_overlap_that_nearly_vanishes_between_two_large_values_is_two_contacts() {
    let two = |least: f64| move |t: f64| f64::exp(-t.cosh()) + f64::exp(-(t - 8.0).cosh()) + least;
    for (least, count) in [(0.0, 2), (1e-6, 2), (1e-4, 1), (1e-3, 1)] {
        let got = contacts(two(least), (-4.0, 12.0), [Some(0.0), Some(0.0)], 0.02);
        assert_eq!(got.len(), count, "{least:e}: {got:?}");
        if let [first, second] = got[..] {
            // Each is the mirror image of the other.
            let mirror = |a: Option<f64>, b: Option<f64>| (a.unwrap() + b.unwrap() - 8.0).abs();
            assert!(mirror(first.onset, second.release) < 1e-11, "{got:?}");
            assert!(mirror(first.release, second.onset) < 1e-11, "{got:?}");
            assert!((first.t_largest + second.t_largest - 8.0).abs() < 1e-12);
        }
    }
    // The least value between the nodes of one long stretch is seen, too.
    let valley = |least: f64| move |t: f64| least + t * t;
    for (least, count) in [(1e-6, 2), (1e-4, 1), (2e-3, 1)] {
        for h in [0.1, 2.0] {
            let got = contacts(valley(least), (-1.0, 1.1), [None, None], h);
            assert_eq!(got.len(), count, "{least:e} {h}: {got:?}");
        }
    }
    // A low contact after a high one: the stretch in which the first ends begins above the
    // level at which the second does, and the second must not begin there.
    let low = |t: f64| f64::exp(-t.cosh()) + 0.02 * f64::exp(-(t - 7.4).cosh());
    let apart = (1.0 - TOUCH.ln()).acosh();
    for h in [0.1, 0.5, 0.8] {
        let [first, second] = contacts(low, (-4.0, 12.0), [Some(0.0), Some(0.0)], h)[..] else { panic!("{h}") };
        let (release, onset) = (first.release.unwrap(), second.onset.unwrap());
        let (early, late) = ((release - apart).abs(), (onset - 7.4 + apart).abs());
        assert!(release < onset && early < 4e-7 && late < 3e-5, "{h}: {early:e} {late:e}");
    }
    // A ripple whose overlap stays above `TOUCH` of its own largest value is no contact.
    let ripple = |t: f64| f64::exp(-t.cosh()) + 1e-5 * (1.2 + (9.0 * t).cos());
    assert_eq!(contacts(ripple, (-5.0, 5.0), [Some(0.0), Some(0.0)], 0.02).len(), 1);
}

#[test]
fn the_stretch_with_the_least_overlap_gives_its_impulse_to_the_larger_side() {
    // An error of a stretch of 1e-9, then a real contact that begins with it.
    let stretch =
        |from: f64, to: f64, values: [f64; 3]| Curve::over((from, to), [0.0, 0.5, 1.0].into_iter().zip(values));
    let mut log = log();
    let first = piece(stretch(0.0, 0.1, [1e-9, 2e-10, 1e-13]), 1e-13);
    log.take(&Piece { onset: Some((0.0, 1.0)), ..first }, (0.0, 100.0));
    assert!(log.ended().is_empty());
    log.take(&piece(stretch(0.1, 5.0, [1e-15, 0.1, 1.0]), 0.4), (0.0, 100.0));
    assert_eq!([log.ended()[0].impulse, log.into_contacts().list()[0].impulse], [1e-13, 0.4]);
}

#[test]
fn what_is_stored_is_read_back() {
    let (mut log, chain) = (log(), Chain::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Free, 2).unwrap());
    for k in 0..75 {
        let from = -4.0 + 0.1 * f64::from(k);
        let points = [0.0, 0.3, 0.7, 1.0].map(|x| (x, f64::exp(-(from + 0.1 * x).cosh())));
        let onset = (k == 0).then_some((0.0, 0.0));
        log.take(&Piece { onset, ..piece(Curve::over((0.0, 0.1), points), 0.1) }, (from, from + 0.1));
        let contacts = log.clone().into_contacts();
        let numbers = contacts.store_open();
        let read = Contacts::restore(&chain, Vec::new(), &numbers).unwrap();
        let shown = |contacts: &Contacts| format!("{:?} {:?}", contacts.store_open(), contacts.list());
        assert_eq!(shown(&read), shown(&contacts));
        for cut in [1, 6, 7, 9, 20, numbers.len() - 1] {
            assert!(Contacts::restore(&chain, Vec::new(), &numbers[..cut]).is_none());
        }
    }
}
