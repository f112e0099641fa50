//! Section 8: what the paper leaves open, where it has become a number.

use super::{Group, Quantity, Runs};
use crate::{error::Result, paper::figures::limit_wave, study::Wanted};

pub(super) const GROUPS: &[Group] = &[Group::of(waves), Group::of(limits)];

/// Exact travelling waves at the parameters of Sec. 4.
fn waves(_: &Runs) -> Result<Vec<Quantity>> {
    let studies = ["tw-q15", "tw-q45", "tw-rho3"].map(|scene| Wanted::of(scene).study());
    let [first, short, third] = studies;
    let studies = [first?, short?, third?];
    let worst = |of: fn(&crate::study::ExactStudy) -> f64| studies.iter().map(of).fold(0.0, f64::max);
    Ok(vec![("s8-waves-exact", worst(|study| study.wave.residual)), ("s8-waves-near", worst(|study| study.errors[0]))])
}

/// Limits of small waves, as slopes over two decades of `epsilon`.
fn limits(_: &Runs) -> Result<Vec<Quantity>> {
    let [small, large] = [1e-6, 1e-4].map(|epsilon| limit_wave(1.0 / 3.0, epsilon));
    let (small, large) = (small?, large?);
    let slope = |small: f64, large: f64| (large / small).ln() / 100.0_f64.ln();
    Ok(vec![
        ("s8-waves-slope", slope(small.errors[0], large.errors[0])),
        ("s8-modulation", slope(small.apart().abs(), large.apart().abs())),
    ])
}
