//! Maxima in time of the overlaps of bonds that are closed.

use super::ROUNDING;
use hertzchain_integrators::events::Curve;
use std::{collections::BTreeMap, ops::RangeInclusive};

/// A maximum in time of the overlap of a bond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Maximum {
    /// The bond: `n` lies to the left of site `n`.
    pub bond: usize,
    /// Time.
    pub t: f64,
    /// The overlap.
    pub overlap: f64,
}

/// The maxima of a run so far, and the bonds that are closed.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Maxima {
    /// The least fall after a maximum, and the least rise before it, as a share of the largest
    /// overlap that the bond has had.
    share: f64,
    found: Vec<Maximum>,
    largest: BTreeMap<usize, f64>,
    closed: BTreeMap<usize, Trend>,
}

/// The overlap of a closed bond since its last maximum or minimum.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Trend {
    rises: bool,
    /// Time and value of the largest overlap if it rises, of the least one if it falls.
    extreme: (f64, f64),
}

impl Maxima {
    /// Shares that are accepted: from the rounding errors of overlaps on.
    pub(super) const SHARES: RangeInclusive<f64> = ROUNDING..=0.5;

    pub(super) fn new(share: f64) -> Self {
        Self { share, found: Vec::new(), largest: BTreeMap::new(), closed: BTreeMap::new() }
    }

    /// Takes the next stretch of the overlap of a closed bond, and time and value of its largest
    /// overlap, which may be more exact than the stretch.
    ///
    /// Where it begins, the stretch before has ended, but for errors of the method: of the two
    /// values there, only that of the end counts.
    pub(super) fn press(&mut self, bond: usize, curve: &Curve, exact: (f64, f64)) {
        let start = Trend { rises: false, extreme: (curve.start(), curve.values()[0]) };
        let trend = self.closed.entry(bond).or_insert(start);
        let largest = self.largest.entry(bond).or_insert(0.0);
        let ([end, last, _], rough) = (curve.end(), curve.largest());
        curve.turns(|point| {
            let point = if point.0 == rough.0 { exact } else { point };
            trend.go_on(bond, point, (self.share, largest), &mut self.found);
        });
        trend.go_on(bond, (end, last), (self.share, largest), &mut self.found);
    }

    /// A bond opens: its overlap is zero.
    pub(super) fn part(&mut self, bond: usize, t: f64) {
        if let (Some(mut trend), Some(largest)) = (self.closed.remove(&bond), self.largest.get_mut(&bond)) {
            trend.go_on(bond, (t, 0.0), (self.share, largest), &mut self.found);
        }
    }

    /// The maxima in order of time, then of bonds, but those that are at most the share of the
    /// largest overlap of all bonds.
    pub(super) fn list(&self) -> Vec<Maximum> {
        let least = self.share * self.largest.values().copied().fold(0.0, f64::max);
        let mut list: Vec<Maximum> = self.found.iter().copied().filter(|maximum| maximum.overlap > least).collect();
        list.sort_by(|a, b| a.t.total_cmp(&b.t).then(a.bond.cmp(&b.bond)));
        list
    }
}

impl Trend {
    /// Goes on to a point, between which and the last one the overlap only rises or only falls.
    fn go_on(&mut self, bond: usize, point: (f64, f64), (share, largest): (f64, &mut f64), found: &mut Vec<Maximum>) {
        *largest = largest.max(point.1);
        let ahead = if self.rises { point.1 - self.extreme.1 } else { self.extreme.1 - point.1 };
        if ahead > 0.0 {
            self.extreme = point;
        } else if -ahead > share * *largest {
            if self.rises {
                found.push(Maximum { bond, t: self.extreme.0, overlap: self.extreme.1 });
            }
            *self = Self { rises: !self.rises, extreme: point };
        }
    }
}
