//! The sites of a long chain that contact forces can push in the next steps, and those that kicks
//! leave out.
//!
//! The columns of the flow change by kicks only: a site that no force pushes needs no work, and its
//! path is known. Sites whose bonds are open, and stay open over the next [`AHEAD`] steps whatever
//! the phase of their resonators, *sleep*: kicks leave them out. The other sites are *awake*.
//! States, events and turns have the bits of a chain that is awake throughout; only the sign of a
//! zero in a state may be that of the initial state.
//!
//! | symbol | meaning |
//! |---|---|
//! | `G + G' t` | the part of an overlap that moves freely |
//! | `A` | amplitude of the part that oscillates |
//! | `T, h` | time over which the bond must stay open, [`AHEAD`] steps and eight more; a step |
//!
//! A bond may sleep if it is open, its force was zero at the last two evaluations, and
//! `G + (G')_+ T + A + 8 h (abs(G') + omega A) <= 0`, with room for rounding. The last term keeps
//! the overlaps of three evaluations in a row from looking like a turn near zero, also where the
//! bond wakes between them: a turn counts only if the overlap is below three times its second
//! difference.
//!
//! A bond that closes pushes its sites from then on. So [`MARGIN`] sites on either side of a bond
//! that may not sleep are awake. The sites around a bond that changes its side or is corrected are
//! woken before the next kick.

use super::{
    ActiveRange, Awake, CorrectedSplit, LANES,
    forces::{PAD, WORD},
};
use std::ops::Range;

/// Steps between two checks of all bonds for sleep. Chosen: a check of 1000 sites takes about as
/// long as 30 steps of a pulse on them.
const AHEAD: usize = 256;
/// Sites on either side of a bond that must be awake when it is corrected. The registers of the
/// bond and of its neighbours are then evaluated again. They were awake before, since a bond that
/// changes its side stirs or was pushed by a bond beside it; and a pass computes the position of
/// the site before a range of registers.
const MARGIN: usize = 5;
/// Shorter chains, in sites, are awake as a whole.
const FEW: usize = 8 * LANES;
/// The distance of a sleeping overlap from zero, in steps of its motion. A turn counts up to three
/// second differences from zero; these are at most `2 omega h A`, or `h abs(G')` where a bond has
/// just woken.
const SURVEYS: f64 = 8.0;
/// Bound for the rounding error of an overlap, relative to the sizes of the numbers that it is
/// computed from.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

impl Awake {
    /// Finds the ranges of registers that are awake.
    fn find_ranges(&mut self, ring: bool) {
        let Self { registers, whole, ranges, .. } = self;
        let count = registers.len();
        ranges.clear();
        *whole = !registers.contains(&false);
        if *whole {
            ranges.push(ActiveRange { from: 0, to: 0 });
            return;
        }
        for first in 0..count {
            let before = if ring { registers[(first + count - 1) % count] } else { first > 0 && registers[first - 1] };
            if registers[first] && !before {
                let most = if ring { first + count } else { count };
                let end = (first..most).find(|k| !registers[k % count]).unwrap_or(most);
                ranges.push(ActiveRange { from: first * LANES, to: end % count * LANES });
            }
        }
    }
}

/// The number of sites that kicks work on, in whole registers.
pub fn sites_awake(split: &CorrectedSplit) -> usize {
    LANES * split.awake.registers.iter().filter(|&&awake| awake).count()
}

impl CorrectedSplit {
    /// Lets those parts of the chain sleep in which no bond can close or turn near zero in the next
    /// [`AHEAD`] steps `h`.
    pub(super) fn look_ahead(&mut self, h: f64) {
        if self.sites < FEW {
            self.awake.left = usize::MAX;
            return;
        }
        self.awake.left = AHEAD;
        let mut next = std::mem::take(&mut self.awake.next);
        next.fill(false);
        for b in self.chain().touching().filter(|&b| self.stirs(b, h)) {
            self.around(b).for_each(|site| next[site / LANES] = true);
        }
        self.change(next);
    }

    /// Wakes all sites.
    pub(super) fn wake(&mut self) {
        self.awake.left = 0;
        if !self.awake.whole {
            let mut next = std::mem::take(&mut self.awake.next);
            next.fill(true);
            self.change(next);
        }
    }

    /// Wakes the sites near a bond that is corrected or has closed: they may be pushed next.
    #[inline(always)]
    pub(super) fn rouse(&mut self, b: usize) {
        if !self.awake.whole && self.around(b).any(|site| !self.awake.registers[site / LANES]) {
            let mut next = std::mem::take(&mut self.awake.next);
            next.copy_from_slice(&self.awake.registers);
            self.around(b).for_each(|site| next[site / LANES] = true);
            self.change(next);
        }
    }

    /// The sites near a bond.
    #[inline(always)]
    fn around(&self, b: usize) -> impl Iterator<Item = usize> + use<> {
        let (n, ring) = (self.sites, self.ring());
        (b + n - MARGIN..=b + n + MARGIN)
            .filter(move |site| ring || (n..2 * n).contains(site))
            .map(move |site| site % n)
    }

    /// Whether a bond may push its sites or turn near zero in the next steps.
    fn stirs(&self, b: usize, h: f64) -> bool {
        let bits = [&self.closed, &self.told, &self.turning].map(|bits| bits[b / WORD] >> (b % WORD) & 1);
        if bits != [0; 3] || self.force[PAD + b] != 0.0 || self.force_before[PAD + b] != 0.0 {
            return true;
        }
        let (omega, long) = (self.flow.response().2, (AHEAD as f64 + SURVEYS) * h);
        let ends = self.chain().topology().ends(b).map(|site| site.map_or([0.0; 4], |site| self.flow.rest(site)));
        let size = |[r, v, p, s]: [f64; 4]| r.abs() + v.abs() * long + p.abs() + s.abs();
        let [r, v, p, s] = std::array::from_fn(|k| ends[0][k] - ends[1][k]);
        // Not less than the amplitude.
        let amplitude = p.abs() + s.abs();
        let room = SURVEYS * h * (v.abs() + omega * amplitude) + ROUNDING * (size(ends[0]) + size(ends[1]));
        let most = self.chain().precompression() + r + v.max(0.0) * long + amplitude + room;
        // A bond whose bound is NaN stays awake.
        most > 0.0 || most.is_nan()
    }

    /// Wakes registers of sites or lets them sleep, so that `next` are the flags of all registers.
    #[cold]
    fn change(&mut self, next: Vec<bool>) {
        let last = next.len() - 1;
        for (register, &awake) in next.iter().enumerate() {
            if awake != self.awake.registers[register] {
                let end = if register == last { self.sites + 1 } else { (register + 1) * LANES };
                self.turn_over(register * LANES..end, awake);
            }
        }
        self.awake.next = std::mem::replace(&mut self.awake.registers, next);
        self.awake.find_ranges(self.chain().topology().ring());
    }

    /// Prepares bonds that wake or begin to sleep. Where they wake, their positions and overlaps
    /// are computed for the present time. In both cases the overlaps of the evaluations before are
    /// set to the present ones, so that they show no turn.
    fn turn_over(&mut self, bonds: Range<usize>, awake: bool) {
        if awake {
            for site in bonds.start..bonds.end.min(self.sites) {
                self.q[PAD + site] = self.flow.bead(site).0;
            }
        }
        let touching = self.chain().touching();
        for b in bonds.start.max(touching.start)..bonds.end.min(touching.end) {
            if awake {
                self.overlap[b] = self.chain().precompression() + self.chain().across(b, |i| self.flow.bead(i).0);
            }
            self.overlaps_before.iter_mut().for_each(|before| before[b] = self.overlap[b]);
        }
    }
}
