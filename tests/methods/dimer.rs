//! Pulses in dimers: the study behind `study dimer`.

use hertzchain::study::{DimerOptions, PUBLISHED, Study, dimer, pulse, pulse_by};

#[test]
fn the_step_of_the_dimer_study_is_short_enough() {
    // Truth: a step of a quarter, whose error is 2^-5 of it and less.
    for ratio in [0.0901, 0.3428, 0.6] {
        let [a, b] = [pulse(ratio, 8), pulse_by(ratio, 8, 0.005)].map(|row| row.unwrap().transmission());
        println!("{ratio}: {:e}", a - b);
        assert!((a - b).abs() < 1e-5, "{ratio}: {:e}", a - b);
    }
}

#[test]
fn solitary_waves_in_dimers_are_where_they_were_found() {
    // Truth: the published mass ratios, to three digits; a pulse that keeps its force there, and
    // loses half of it in between. Equal beads have a solitary wave too.
    for (published, (from, to)) in PUBLISHED[1..].iter().zip([(0.31, 0.38), (0.14, 0.17), (0.083, 0.098)]) {
        let study = dimer(&DimerOptions { from, to, points: 6, cells: 24 }, &|_, _| ()).unwrap();
        let [found] = study.maxima[..] else { panic!("{published}: {:?}", study.maxima) };
        println!("{published}: {} {}", found.ratio, found.transmission());
        assert!((found.ratio - published).abs() < 5e-4, "{published}: {}", found.ratio);
        assert!(found.transmission() > 0.999, "{published}: {}", found.transmission());
    }
    assert!(pulse(0.59, 24).unwrap().transmission() < 0.6);
    assert!(pulse(1.0, 24).unwrap().transmission() > 0.9999);
}

#[test]
fn options_of_the_dimer_study_outside_their_rules_are_refused() {
    let refused = |options: DimerOptions, rule: &str| {
        let message = options.begin().map(|_| ()).unwrap_err().to_string();
        assert!(message.contains(rule), "{message}");
    };
    let own = DimerOptions::default;
    refused(DimerOptions { from: 0.01, ..own() }, "from 0.02 to 1");
    refused(DimerOptions { to: 1.5, ..own() }, "to = 1.5");
    refused(DimerOptions { from: 0.5, to: 0.5, ..own() }, "below the largest");
    refused(DimerOptions { points: 2, ..own() }, "ratios = 2");
    refused(DimerOptions { cells: 3, ..own() }, "cells = 3");
}
