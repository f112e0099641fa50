//! The exact linear flow of the chain with the kicks of contact-corrected splitting.
//!
//! | symbol | meaning |
//! |---|---|
//! | bond `b` | lies to the left of site `b`; all chains have `n + 1` bonds here: the outer two of a free chain never close, on a ring they are the same |
//! | evaluation | computation of positions, overlaps, forces and `f'` of all bonds at one time, and of which bonds are closed or turn near zero |
//! | turn | an overlap that is larger or smaller than at the evaluations before and after; near zero if it is below `reach` times its second difference |
//! | `f, f'` | contact forces and their derivatives by the overlap |
//! | `F` | modified forces `f + c f' s`, `s` the acceleration of the overlap |

mod awake;
mod flow;
mod forces;
mod fused;
mod linear;

pub use awake::sites_awake;
pub(super) use forces::turning;
use forces::{Forces, PAD, WORD};
use fused::ActiveRange;

use super::{Chain, LinearFlow, aligned::Aligned, law::LANES};
use hertzchain_integrators::splitting::corrected::BondPath;

/// The exact linear flow with the kicks of contact-corrected splitting. Kicks leave resonators
/// alone, since springs are part of the drift.
///
/// Each evaluation exchanges the arrays of the latest evaluations with each other; as they lie
/// behind pointers, that is cheap.
///
/// Arrays are longer than the chain, so that loops over whole registers need no remainder; the
/// numbers beyond the chain are not used.
pub struct CorrectedSplit {
    flow: LinearFlow<f64>,
    sites: usize,
    /// Positions of sites, from `PAD` on, with one position of a neighbour beyond either end.
    q: Aligned<f64>,
    /// Overlaps of bonds at the last evaluation.
    overlap: Box<Aligned<f64>>,
    /// Overlaps at the two evaluations before the last, later one first.
    overlaps_before: [Box<Aligned<f64>>; 2],
    /// Forces `f` of bonds and their derivatives `f'` at the last evaluation, from `PAD` on, with
    /// the force of a neighbour beyond either end.
    force: Box<Aligned<f64>>,
    slope: Box<Aligned<f64>>,
    /// `f` at the evaluation before.
    force_before: Box<Aligned<f64>>,
    /// Modified forces of the last kick that was made in a row, from `PAD` on.
    modified: Aligned<f64>,
    /// A bit for each bond: whether it was closed at the last evaluation, and whether it was closed
    /// at the last call of `changed`.
    closed: Vec<u64>,
    told: Vec<u64>,
    /// A bit for each bond: whether its overlap has turned near zero.
    turning: Vec<u64>,
    /// A turn is near zero if the overlap is smaller than this many times its second difference.
    reach: f64,
    /// The step size, and [`tan_ratio`] of it.
    tan_ratio: (f64, f64),
    /// Registers of bonds whose sites the last corrections have moved; some more than once.
    moved: Vec<usize>,
    /// Which sites are worked on. Other sites have forces of zero, and positions and overlaps that
    /// are out of date.
    awake: Awake,
}

/// Which sites are awake.
#[derive(Debug)]
struct Awake {
    /// For each register of sites: whether it is awake.
    registers: Vec<bool>,
    /// Whether all sites are awake.
    whole: bool,
    /// The ranges of sites that are awake.
    ranges: Vec<ActiveRange>,
    /// Steps until all bonds are checked again.
    left: usize,
    /// Room for the next value of `registers`.
    next: Vec<bool>,
}

impl Awake {
    /// A chain with all sites awake.
    fn all(sites: usize) -> Self {
        let registers = vec![true; sites.div_ceil(LANES)];
        let mut ranges = Vec::with_capacity(registers.len().div_ceil(2));
        ranges.push(ActiveRange { from: 0, to: 0 });
        Self { next: registers.clone(), registers, whole: true, ranges, left: 0 }
    }
}

impl CorrectedSplit {
    /// Adds the kicks to `flow`, which holds a state.
    pub fn new(flow: LinearFlow<f64>) -> Self {
        let (sites, bonds) = (flow.chain().sites(), flow.chain().sites() + 1);
        let zeros = |len| Box::new(Aligned::zeros(len));
        let padded = || zeros(PAD + bonds.next_multiple_of(LANES) + 2 * LANES);
        Self {
            flow,
            sites,
            q: *padded(),
            overlap: zeros(bonds),
            overlaps_before: [zeros(bonds), zeros(bonds)],
            force: padded(),
            slope: padded(),
            force_before: padded(),
            modified: *padded(),
            closed: vec![0; bonds.div_ceil(WORD)],
            told: vec![0; bonds.div_ceil(WORD)],
            turning: vec![0; bonds.div_ceil(WORD)],
            reach: 0.0,
            tan_ratio: (0.0, 1.0),
            moved: Vec::with_capacity(3 * bonds),
            awake: Awake::all(sites),
        }
    }

    #[inline]
    fn chain(&self) -> &Chain<f64> {
        self.flow.chain()
    }

    #[inline]
    fn ring(&self) -> bool {
        self.chain().topology().ring()
    }

    /// Exchanges the arrays of the latest evaluations as that many evaluations do.
    #[inline]
    fn keep(&mut self, evaluations: usize) {
        for _ in 0..evaluations % 3 {
            self.overlaps_before.swap(0, 1);
            std::mem::swap(&mut self.overlap, &mut self.overlaps_before[0]);
        }
        if evaluations % 2 == 1 {
            std::mem::swap(&mut self.force, &mut self.force_before);
        }
    }

    /// Clears the bits beyond the last bond that can touch, and sets the forces beyond the ends.
    #[inline]
    fn finish(&mut self) {
        // On a ring the first bit to clear is that of bond `n`, which is bond 0 once more.
        let end = self.chain().touching().end;
        for bits in [&mut self.closed, &mut self.turning] {
            if let Some(word) = bits.get_mut(end / WORD) {
                *word &= (1 << (end % WORD)) - 1;
            }
        }
        self.close();
    }

    /// On a ring, copies the positions beyond both ends, and bond 0 to bond `n`.
    #[inline]
    fn join(&mut self) {
        if !self.ring() {
            return;
        }
        let n = self.sites;
        self.join_positions();
        self.overlap[n] = self.overlap[0];
        self.force[PAD + n] = self.force[PAD];
        self.slope[PAD + n] = self.slope[PAD];
    }

    /// On a ring, copies the positions beyond both ends.
    #[inline]
    fn join_positions(&mut self) {
        (self.q[PAD - 1], self.q[PAD + self.sites]) = (self.q[PAD + self.sites - 1], self.q[PAD]);
    }

    /// The bond with number `index` among those that can touch.
    #[inline]
    fn bond(&self, index: usize) -> usize {
        self.chain().touching().start + index
    }

    /// Sets the forces beyond the ends: on a ring those of the neighbours, else copies of the outer
    /// bonds' forces, so that whatever lies beyond an end has no acceleration.
    #[inline]
    fn close(&mut self) {
        let n = self.sites;
        let [before, after] = if self.ring() { [n - 1, 1] } else { [0, n] }.map(|b| self.force[PAD + b]);
        (self.force[PAD - 1], self.force[PAD + n + 1]) = (before, after);
    }

    /// Evaluates the registers of `moved` again.
    #[inline(always)]
    fn refresh(&mut self) {
        let Self { flow, q, overlap, overlaps_before: [latest, first], force, slope, turning, .. } = self;
        let forces = Forces {
            reach: self.reach,
            q: q.column(),
            overlap: overlap.column(),
            force: force.column(),
            slope: slope.column(),
            before: [latest.column(), first.column()],
            closed: &mut [],
            turning,
        };
        forces.refresh(flow.chain(), &self.moved);
    }

    /// The path of a bond under two pulls, one a step `h` ago and one now, between which the pull
    /// is linear in time: through the bond's overlaps at both ends of the step, and moved by
    /// processing. It is linear in its overlap, its [motion](LinearFlow::motion) and the pulls.
    ///
    /// With the mean `s` and the rate `s'` of the pull, the path is the chord plus
    /// `s t (t + h)/2 + s' t (t + h)(t + h/2)/6`.
    #[inline(always)]
    fn path_of(&self, b: usize, [before, now]: [f64; 2], h: f64) -> BondPath {
        let (m, mu, omega) = self.flow.response();
        let [rate, p, p_dot] = self.chain().topology().across(b, |site| self.flow.motion(site));
        let change = if h > 0.0 { (now - before) / h } else { 0.0 };
        let (share, half) = (h * h / 12.0, 0.25 * h * (before + now));
        // To the chord's rate the accelerations add s h/2 + s' h^2/12, and processing adds s'
        // h^2/12.
        let (overlap, by_change) = (self.overlap[b] + share * now, 2.0 * share * change);
        if omega == 0.0 {
            let rate = rate + (half + by_change);
            return BondPath { overlap, rate, acceleration: [now, 0.0], jerk: [change, 0.0], omega };
        }
        let stiffness = omega * omega;
        let tan = if h == self.tan_ratio.0 { self.tan_ratio.1 } else { tan_ratio(omega, h) };
        let oscillating = mu * (tan * half + by_change);
        BondPath {
            overlap,
            rate: rate + (m * (half + by_change) + oscillating),
            acceleration: [m * now, mu * now - stiffness * p],
            jerk: [m * change, mu * change - stiffness * (p_dot + oscillating)],
            omega,
        }
    }

    /// Acceleration of an overlap by given forces of the neighbours of its bond.
    #[inline(always)]
    fn pull(&self, b: usize, force: &[f64]) -> f64 {
        let [before, behind] = self.chain().topology().beside(b).map(|b| b.map_or(0.0, |b| force[PAD + b]));
        before + behind
    }
}

/// `tan(omega h/2)/(omega h/2)`: the rate, at the end of a step, of the oscillation under a
/// constant force that is zero at both ends of the step, in units of that rate without springs. 1
/// where `omega h/2` is below 1e-4, or so large that steps are too long for the formula.
fn tan_ratio(omega: f64, h: f64) -> f64 {
    let turn = 0.5 * omega * h;
    if (1e-4..1.0).contains(&turn) { turn.tan() / turn } else { 1.0 }
}
