//! Plans of sweeps: any text gives a plan whose points can be asked for, or an error with file and
//! rule on one line, before memory is allocated for what the plan asks for.

#![no_main]

use hertzchain::study::Plan;
use libfuzzer_sys::{Corpus, fuzz_target};
use std::path::Path;

/// Most digits of a number in a text with sites: scenes at the ends of the axes are built, and long
/// chains, or profiles of breathers, take more time and test nothing else.
const DIGITS: usize = 3;

fuzz_target!(|text: &str| -> Corpus {
    let digits = |text: &str| text.split(|c: char| !c.is_ascii_digit()).map(str::len).max().unwrap_or(0);
    if text.contains("bright") || (text.contains("sites") && digits(text) > DIGITS) {
        return Corpus::Reject;
    }
    match Plan::parse(text, Path::new("fuzz.toml")) {
        Ok(plan) => {
            let points = plan.points();
            assert!(points > 0 && (points as u64) < 1 << 32 && !plan.keep.is_empty());
            for number in [0, points / 2, points - 1] {
                assert_eq!(plan.point(number).0.len(), plan.keys().count());
                let _ = plan.scene(&plan.point(number));
            }
        }
        Err(error) => {
            let message = error.to_string();
            assert!(!message.is_empty() && !message.contains(char::is_control), "{message:?}");
        }
    }
    Corpus::Keep
});
