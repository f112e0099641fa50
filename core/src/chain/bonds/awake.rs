//! The sites of a long chain that contact forces can push in the next steps, and those that kicks
//! leave out.
//!
//! The columns of the linear split change by kicks only: a site that no force pushes needs no work,
//! and its path is known. Sites whose bonds are open, and stay open over the next [`AHEAD`] steps
//! whatever the phase of their resonators, *sleep*: kicks leave them out. The other sites are
//! *awake*. States, events and turns have the bits of a chain that is awake throughout; only the
//! sign of a zero in a state may be that of the initial state.
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

use super::{CorrectedSplit, LANES, PAD, SiteFlow, WORD};
use std::ops::Range;

/// Steps between two checks of all bonds for sleep. Chosen: a check of 1000 sites takes about as
/// long as 30 steps of a pulse on them.
const AHEAD: usize = 256;
/// Sites on either side of a bond that must be awake when it is corrected. The registers of the
/// bond and of its neighbours are then evaluated again. They were awake before, since a bond that
/// changes its side stirs or was pushed by a bond beside it; and a pass computes the position of
/// the site before a range of registers.
const MARGIN: usize = 5;
/// Shorter chains, in sites, are awake as a whole, and are moved abreast where they are alike. In a
/// trial with AVX-512 (CPU time, least of 25 runs each, a busy machine), rings abreast take 0.53 to
/// 0.67 of the time of each alone with 16 sites, 0.53 to 0.72 with 32, 0.55 to 0.75 with 50, 0.51
/// to 0.88 with 63, 0.68 to 1.18 with 100, by 32 to 512 steps a period.
pub(crate) const FEW: usize = 8 * LANES;
/// The distance of a sleeping overlap from zero, in steps of its motion. A turn counts up to three
/// second differences from zero; these are at most `2 omega h A`, or `h abs(G')` where a bond has
/// just woken.
const SURVEYS: f64 = 8.0;
/// Bound for the rounding error of an overlap, relative to the sizes of the numbers that it is
/// computed from.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// A range of sites that are awake, from `from` up to `to`; both are multiples of the widest
/// register. If `to` is smaller than `from`, the range goes up to the end of the chain and on from
/// site 0 up to `to`. If both are the same, it has all sites.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ActiveRange {
    pub(super) from: usize,
    pub(super) to: usize,
}

impl ActiveRange {
    /// Its bonds as ranges, in a chain with so many.
    #[inline(always)]
    pub(super) fn bonds(self, all: usize) -> [Range<usize>; 2] {
        let Self { from, to } = self;
        if from == to {
            [0..all, 0..0]
        } else if from < to {
            [from..to, 0..0]
        } else {
            [from..all, 0..to]
        }
    }
}

/// Which sites are awake.
#[derive(Debug)]
pub(super) struct Awake {
    /// For each register of sites: whether it is awake.
    registers: Vec<bool>,
    /// Whether all sites are awake.
    whole: bool,
    /// The ranges of sites that are awake.
    pub(super) ranges: Vec<ActiveRange>,
    /// Steps until all bonds are checked again.
    pub(super) left: usize,
    /// Room for the next value of `registers`.
    next: Vec<bool>,
}

impl Awake {
    /// A chain with all sites awake.
    pub(super) fn all(sites: usize) -> Self {
        let registers = vec![true; sites.div_ceil(LANES)];
        let mut ranges = Vec::with_capacity(registers.len().div_ceil(2));
        ranges.push(ActiveRange { from: 0, to: 0 });
        Self { next: registers.clone(), registers, whole: true, ranges, left: 0 }
    }

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

impl<F: SiteFlow> CorrectedSplit<F> {
    /// Lets those parts of the chain sleep in which no bond can close or turn near zero in the next
    /// [`AHEAD`] steps `h`.
    pub(super) fn look_ahead(&mut self, h: f64) {
        if !F::RESTS || self.sites < FEW {
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
    fn around(&self, b: usize) -> impl Iterator<Item = usize> + use<F> {
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

#[cfg(test)]
mod tests {
    use super::{
        super::super::{Boundary, Chain, LinearFlow, Params},
        *,
    };
    use hertzchain_integrators::{
        DoubleDouble, SplitFlow, Stepper,
        splitting::corrected::{BondFlow, Corrected, Parts},
    };

    /// A chain in which two beads near the ends move towards them, so that pulses reach the ends,
    /// or pass them on a ring. For `alpha = 2` all beads fly apart as well.
    fn struck(n: usize, boundary: Boundary, rho: f64, alpha: f64) -> (Chain<f64>, Vec<f64>) {
        let chain = Chain::<f64>::new(Params::new(alpha, 1.0, rho).unwrap(), boundary, n).unwrap();
        let mut y = vec![0.0; chain.layout().dim()];
        let velocities = y.len() / 2;
        (y[velocities + n - 12], y[velocities + 5]) = (0.9, -0.4);
        if alpha == 2.0 {
            // A velocity that grows along the chain.
            (0..n).for_each(|i| y[velocities + i] += 1e-3 * i as f64);
        }
        (chain, y)
    }

    /// The chain of [`struck`] with gaps, in which each bead swings against its resonator with a
    /// phase of its own.
    fn swinging(n: usize, boundary: Boundary) -> (Chain<f64>, Vec<f64>) {
        let rho = 1.0 / 3.0;
        let (chain, mut y) = struck(n, boundary, rho, 1.5);
        for i in 0..n {
            let phase = (i * i) as f64;
            let centre = if boundary == Boundary::StrainRing { 0.02 } else { 0.02 * i as f64 };
            let (p, p_dot) = (0.004 * phase.sin(), 0.008 * phase.cos());
            (y[i], y[n + i]) = (centre + p, centre - p / rho);
            y[2 * n + i] += p_dot;
            y[3 * n + i] -= p_dot / rho;
        }
        (chain, y)
    }

    /// A ring without resonators: the 20 bonds after site `first` are closed, the others are open,
    /// and all beads have the same velocity.
    fn cluster(n: usize, first: usize) -> (Chain<f64>, Vec<f64>) {
        let chain = Chain::<f64>::new(Params::new(1.5, 0.0, 0.0).unwrap(), Boundary::Ring, n).unwrap();
        let (mut y, mut u) = (vec![-0.3; 2 * n], 0.0);
        for i in first..first + n {
            y[i % n] = u;
            u += if i < first + 20 { -0.03 } else { 0.6 / (n as f64 - 20.0) };
        }
        (chain, y)
    }

    const STEP: f64 = 0.05;

    #[test]
    fn what_sleeps_changes_no_bit_and_hides_nothing() {
        // Truth: kick, drift and evaluation of all sites, one after the other.
        crate::chain::on_every_set(|set| {
            for boundary in Boundary::ALL {
                let mut chains = [(150, 0.0, 1.5), (128, 1.0 / 3.0, 1.5), (161, 0.0, 2.0), (136, 1000.0, 1.2)]
                    .map(|(n, rho, alpha)| struck(n, boundary, rho, alpha))
                    .to_vec();
                if matches!(boundary, Boundary::Free | Boundary::StrainRing) {
                    chains.push(swinging(160, boundary));
                }
                for (k, (chain, y)) in chains.into_iter().enumerate() {
                    let n = chain.sites();
                    let run = || {
                        let mut flow = CorrectedSplit::new(LinearFlow::new(chain.clone()));
                        flow.load(&y);
                        flow.prepare(STEP, 3.0);
                        // Until no evaluation has zeros before it.
                        (0..3).for_each(|_| flow.evaluate());
                        flow.changed(&mut Vec::new());
                        flow
                    };
                    let (mut row, mut one, pairs) = (run(), run(), [(STEP, DoubleDouble::new(STEP)); 64]);
                    let (mut taken, mut least) = (0, n);
                    while taken < 1200 {
                        let made = row.kicks_and_evaluations(&pairs, 1e-4, true);
                        for _ in 0..made {
                            one.kick(STEP, 1e-4);
                            one.drift(pairs[0].1);
                            one.evaluate();
                        }
                        let awake = row.awake.registers.iter().filter(|&&awake| awake).count();
                        (taken, least) = (taken + made, least.min(LANES * awake));
                        let [mut told, mut want] = [vec![], vec![]];
                        row.changed(&mut told);
                        one.changed(&mut want);
                        assert_eq!(told, want, "{boundary:?} {k} {set}");
                        let [mut told, mut want] = [vec![], vec![]];
                        row.turned(&mut told);
                        one.turned(&mut want);
                        assert_eq!(told, want, "{boundary:?} {k} {set}: turns");
                    }
                    let [got, want] = [&row, &one].map(|flow| {
                        let mut state = y.clone();
                        flow.store(&mut state);
                        state.into_iter().map(f64::to_bits).collect::<Vec<_>>()
                    });
                    assert!(got == want, "{boundary:?} {k} {set}");
                    assert!(2 * least < n, "{boundary:?} {k}: {least} are awake at least");
                }
            }
        });
    }

    #[test]
    fn corrected_runs_have_the_bits_of_steps_that_keep_all_awake() {
        // Truth: one step at a time, which wakes all sites.
        let chains = [
            struck(150, Boundary::Free, 0.0, 1.5),
            struck(128, Boundary::Ring, 1.0 / 3.0, 1.5),
            struck(161, Boundary::StrainRing, 0.0, 1.5),
            cluster(129, 3),
            cluster(128, 1),
            cluster(130, 126),
        ];
        for (k, (chain, y)) in chains.into_iter().enumerate() {
            let run = |in_rows: bool| {
                let mut flow = LinearFlow::new(chain.clone());
                flow.load(&y);
                let mut run = Corrected::new(CorrectedSplit::new(flow), (0.0, 80.0), 1600, Parts::ALL).unwrap();
                let mut states = Vec::new();
                for wanted in [20.0, 41.3, 80.0] {
                    while run.time() < wanted - 1e-9 {
                        // Between steps in rows one by itself.
                        if in_rows && run.stats().steps % 1000 != 700 {
                            run.steps(Some(wanted)).unwrap();
                        } else {
                            run.step().unwrap();
                        }
                    }
                    let mut state = y.clone();
                    run.sample(run.time(), &mut state);
                    states.extend(state.into_iter().map(f64::to_bits));
                }
                states
            };
            let want = run(false);
            crate::chain::on_every_set(|set| assert!(run(true) == want, "{k} {set}"));
        }
    }

    #[test]
    fn ranges_are_the_registers_that_are_awake() {
        // Truth: the flags themselves, all of seven registers.
        for flags in 0u32..128 {
            for ring in [false, true] {
                let (sites, mut awake) = (7 * LANES - 3, Awake::all(7 * LANES - 3));
                (0..7).for_each(|k| awake.registers[k] = flags >> k & 1 == 1);
                awake.find_ranges(ring);
                let mut bonds: Vec<usize> = awake.ranges.iter().flat_map(|s| s.bonds(sites + 1)).flatten().collect();
                bonds.sort_unstable();
                let want: Vec<usize> = (0..=sites).filter(|b| awake.registers[(b / LANES).min(6)]).collect();
                assert_eq!(bonds, want, "{flags:b} {ring}");
            }
        }
    }
}
