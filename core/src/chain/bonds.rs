//! A flow of the chain with the kicks of contact-corrected splitting, for both splits.
//!
//! | symbol | meaning |
//! |---|---|
//! | bond `b` | lies to the left of site `b`; all chains have `n + 1` here: the outer two of a free chain never close, on a ring they are the same |
//! | `f, f'` | contact forces and their derivatives by the overlap |
//! | `a` | accelerations of sites by the forces of the kick |
//! | `F` | modified forces `f + c f' s`, `s` the acceleration of the overlap |

use super::{
    Boundary, Chain, ContactLaw, KineticFlow, LinearFlow,
    aligned::Aligned,
    law::{LANES, Lanes},
};
use hertzchain_integrators::{
    Error, Kernel, Real, SplitFlow, Stepper, Twofold,
    collocation::Pace,
    splitting::corrected::{BondFlow, BondPath, BondView, Correction, Side},
};

/// Numbers before the first of an array, so that what lies before it can be loaded too.
const PAD: usize = LANES;
/// Bonds in a word of bits.
const WORD: usize = 64;
/// Nodes of the window that leads back inside a step, and the tolerance where one window does not do.
const INSIDE: usize = 12;
const TOLERANCE: f64 = 1e-13;

/// Sites that the drift of a split moves exactly, one by one.
pub trait SiteFlow: SplitFlow<f64> {
    /// The chain.
    fn chain(&self) -> &Chain<f64>;
    /// Writes positions, and computes forces from them.
    fn survey(&mut self, forces: Forces<'_>);
    /// Position and velocity of a bead.
    fn bead(&self, site: usize) -> (f64, f64);
    /// Velocity of a bead, its part that oscillates with `omega` in the drift, and the velocity of that.
    fn motion(&self, site: usize) -> [f64; 3];
    /// The shares of an impulse on a bead that move freely and that oscillate in the drift, and `omega`.
    fn response(&self) -> (f64, f64, f64);
    /// The force of the spring on a bead, where it is part of the kick, and its rate.
    fn spring(&self, site: usize) -> (f64, f64);
    /// How far a correction moves a bead, now.
    fn shift(&self, correction: &Correction) -> f64;
    /// Gives beads a correction, each so many times as it says.
    fn give(&mut self, beads: &[(usize, f64)], correction: &Correction);
    /// Moves what kicks move beside beads: resonators, where springs are part of the kick. By an impulse over the mass, and a displacement.
    fn give_resonator(&mut self, site: usize, impulse: f64, displacement: f64);
    /// Kicks beads by `kick` times modified forces, and by springs where these kick: `-kappa (d + c d'')`, with the accelerations `a` of beads.
    fn push(&mut self, kick: f64, forces: Modified<'_>, a: &[f64]);
}

/// A split of the chain with the kicks of contact-corrected splitting.
///
/// Arrays are longer than the chain, so that loops over whole registers need no remainder; what is in the rest is not looked at.
pub struct Bonded<F> {
    flow: F,
    sites: usize,
    /// Positions, from `PAD` on, with one of a neighbour on either side.
    q: Aligned<f64>,
    overlap: Aligned<f64>,
    /// Overlaps at the last two surveys before, latest first.
    overlaps_before: [Aligned<f64>; 2],
    /// Forces and derivatives, from `PAD` on, with those of neighbours on either side.
    force: Aligned<f64>,
    slope: Aligned<f64>,
    /// Forces at the survey before.
    force_before: Aligned<f64>,
    /// Which bonds are closed as surveyed, a bit each, and which were when changes were last told.
    closed: Vec<u64>,
    told: Vec<u64>,
    /// Forces of springs on beads, where these kick, from `PAD` on, and those at the survey before.
    spring: Aligned<f64>,
    spring_before: Aligned<f64>,
    /// Modified forces, from `PAD` on.
    modified: Aligned<f64>,
    /// Accelerations of sites, for springs that kick.
    a: Aligned<f64>,
    push: Aligned<f64>,
    /// A step, and [`swung`] of it.
    swung: (f64, f64),
}

impl<F: SiteFlow> Bonded<F> {
    /// Of a flow that holds a state.
    pub fn new(flow: F) -> Self {
        let sites = flow.chain().sites();
        let (_, _, omega) = flow.response();
        let springs = omega == 0.0 && flow.chain().params().omega() > 0.0;
        let padded = || Aligned::zeros(PAD + (sites + 1).next_multiple_of(LANES) + LANES);
        Self {
            flow,
            sites,
            q: padded(),
            overlap: Aligned::zeros(sites + 1),
            overlaps_before: [Aligned::zeros(sites + 1), Aligned::zeros(sites + 1)],
            force: padded(),
            slope: padded(),
            force_before: padded(),
            closed: vec![0; (sites + 1).div_ceil(WORD)],
            told: vec![0; (sites + 1).div_ceil(WORD)],
            spring: if springs { padded() } else { Aligned::zeros(0) },
            spring_before: if springs { padded() } else { Aligned::zeros(0) },
            modified: padded(),
            a: Aligned::zeros(sites),
            push: Aligned::zeros(sites),
            swung: (0.0, 1.0),
        }
    }

    #[inline]
    fn chain(&self) -> &Chain<f64> {
        self.flow.chain()
    }

    #[inline]
    fn strain(&self) -> bool {
        self.chain().boundary() == Boundary::StrainRing
    }

    #[inline]
    fn ring(&self) -> bool {
        matches!(self.chain().boundary(), Boundary::Ring | Boundary::StrainRing)
    }

    /// The bond that number `index` among those that can touch is.
    #[inline]
    fn bond(&self, index: usize) -> usize {
        self.chain().touching().start + index
    }

    /// What stands for forces beyond the ends, so that the accelerations of sites there are those of neighbours, or none.
    fn close(&mut self) {
        let (n, ring) = (self.sites, self.ring());
        let f = &mut self.force[PAD - 1..];
        (f[0], f[n + 2]) = if ring { (f[n], f[2]) } else { (f[1], f[n + 1]) };
    }

    /// Overlaps and forces of a bond and its neighbours, whose sites have moved.
    fn refresh(&mut self, b: usize) {
        let n = self.sites;
        if b <= 3 || b + 3 >= n {
            (self.q[PAD - 1], self.q[PAD + n]) = self.chain().boundary().ghosts(self.q[PAD], self.q[PAD + n - 1]);
            // A ring's first bond is its last.
            for b in [0, 1, n - 1, n] {
                self.refresh_bond(b);
            }
        }
        for b in b.saturating_sub(1)..(b + 2).min(n + 1) {
            self.refresh_bond(b);
        }
        if b <= 3 || b + 3 >= n {
            self.close();
        }
    }

    #[inline]
    fn refresh_bond(&mut self, b: usize) {
        let (law, q) = (self.chain().law(), &self.q[PAD - 1..]);
        let g = if self.strain() { -q[b + 1] } else { self.chain().precompression() + (q[b] - q[b + 1]) };
        self.overlap[b] = g;
        (self.force[PAD + b], self.slope[PAD + b]) = law.force_with_slope(g);
    }

    /// The bonds on the sides of a bond, and how many of its sides are beads.
    #[inline]
    fn neighbours(&self, b: usize) -> ([Option<usize>; 2], f64) {
        let n = self.sites;
        let left = if b > 0 { Some(b - 1) } else { self.ring().then_some(n - 1) };
        let right = (b < n).then_some(b + 1);
        ([left, right], f64::from(u8::from(left.is_some()) + u8::from(right.is_some())))
    }

    /// How forces of neighbours and springs, as given, accelerate the overlap of a bond.
    #[inline]
    fn pull(&self, b: usize, force: &[f64], spring: &[f64]) -> f64 {
        let ([left, right], _) = self.neighbours(b);
        let contacts = left.map_or(0.0, |b| force[PAD + b]) + right.map_or(0.0, |b| force[PAD + b]);
        if spring.is_empty() { contacts } else { contacts + self.chain().across(b, |i| spring[PAD + i]) }
    }

    /// The path of a bond under a pull that was `before` a step `h` ago and is `now`: through its places at both ends of the step, and moved by processing.
    ///
    /// With the mean `s` and the rate `s'` of the pull, what the chord lacks is `s t (t + h)/2 + s' t (t + h)(t + h/2)/6`.
    #[inline]
    fn along(&self, b: usize, [before, now]: [f64; 2], h: f64) -> BondPath {
        let (m, mu, omega) = self.flow.response();
        let [rate, p, p_dot] = self.across(b, |i| self.flow.motion(i));
        let change = if h > 0.0 { (now - before) / h } else { 0.0 };
        let (share, half) = (h * h / 12.0, 0.25 * h * (before + now));
        // Of the chord's rate the bends add s h/2 + s' h^2/12, and processing s' h^2/12.
        let (overlap, bend) = (self.overlap[b] + share * now, 2.0 * share * change);
        if omega == 0.0 {
            return BondPath {
                overlap,
                rate: rate + (half + bend),
                acceleration: [now, 0.0],
                jerk: [change, 0.0],
                omega,
            };
        }
        let swung = mu * (if h == self.swung.0 { self.swung.1 } else { swung(omega, h) } * half + bend);
        let stiffness = omega * omega;
        BondPath {
            overlap,
            rate: rate + (m * (half + bend) + swung),
            acceleration: [m * now, mu * now - stiffness * p],
            jerk: [m * change, mu * change - stiffness * (p_dot + swung)],
            omega,
        }
    }

    /// A difference across a bond, as [`Chain::across`].
    #[inline]
    fn across(&self, b: usize, of: impl Fn(usize) -> [f64; 3]) -> [f64; 3] {
        let n = self.sites;
        let minus = |x: [f64; 3]| [-x[0], -x[1], -x[2]];
        let (before, behind) = match self.chain().boundary() {
            Boundary::StrainRing => return minus(of(b)),
            Boundary::Ring => (if b > 0 { b - 1 } else { n - 1 }, b),
            _ if b == 0 => return minus(of(0)),
            _ if b == n => return of(n - 1),
            _ => (b - 1, b),
        };
        let ([x, x_dot, x_second], y) = (of(before), of(behind));
        [x - y[0], x_dot - y[1], x_second - y[2]]
    }

    /// Accelerations of beads by the kick and their rates, and the same of resonators; bonds that are near an event without rates.
    fn jet(&mut self, sides: &[Side]) -> Vec<[f64; 4]> {
        let n = self.sites;
        self.survey();
        let first = self.chain().touching().start;
        let mut rates = vec![0.0; n + 1];
        for (index, side) in sides.iter().enumerate() {
            if *side != Side::Near {
                let b = first + index;
                rates[b] = self.slope[PAD + b] * self.chain().across(b, |i| self.flow.bead(i).1);
            }
        }
        if self.ring() {
            rates[n] = rates[0];
        }
        let params = self.chain().params();
        let of = |bonds: &[f64], i: usize| {
            let push = bonds[i] - bonds[i + 1];
            if self.strain() { push - (bonds[if i > 0 { i - 1 } else { n - 1 }] - bonds[i]) } else { push }
        };
        (0..n)
            .map(|i| {
                let (spring, spring_rate) = self.flow.spring(i);
                let resonator =
                    |force: f64| if params.rho.is_finite() && force != 0.0 { -force / params.rho } else { 0.0 };
                let (a, da) = (of(&self.force[PAD..], i) + spring, of(&rates, i) + spring_rate);
                [a, da, resonator(spring), resonator(spring_rate)]
            })
            .collect()
    }

    fn shift(&mut self, share: f64, jet: &[[f64; 4]]) {
        for (i, &[a, da, b, db]) in jet.iter().enumerate() {
            let (impulse, displacement) = (-share * da, share * a);
            let now = Correction { impulse, displacement, at: 0.0, rate: 0.0, turn: [0.0, 1.0] };
            self.flow.give(&[(i, 1.0)], &now);
            if b != 0.0 || db != 0.0 {
                self.flow.give_resonator(i, -share * db, share * b);
            }
        }
    }
}

/// `tan(omega h/2)/(omega h/2)`: the rate at the end of a step of the forced oscillation that is zero at both its ends, in units of that without
/// springs. 1 where steps are too long for that.
fn swung(omega: f64, h: f64) -> f64 {
    let turn = 0.5 * omega * h;
    if (1e-4..1.0).contains(&turn) { turn.tan() / turn } else { 1.0 }
}

/// Overlaps, forces and derivatives, and which bonds are closed, from positions.
pub struct Forces<'a> {
    strain: bool,
    rest: f64,
    law: &'a ContactLaw<f64>,
    boundary: Boundary,
    sites: usize,
    /// From `PAD` on; the others from the first bond on.
    q: &'a mut [f64],
    overlap: &'a mut [Lanes<f64>],
    force: &'a mut [Lanes<f64>],
    slope: &'a mut [Lanes<f64>],
    closed: &'a mut [u64],
}

impl Forces<'_> {
    /// After positions are written.
    #[inline(always)]
    fn compute(self) {
        let Self { strain, rest, law, boundary, sites, q, overlap, force, slope, closed } = self;
        (q[PAD - 1], q[PAD + sites]) = boundary.ghosts(q[PAD], q[PAD + sites - 1]);
        let g = overlap.as_flattened_mut();
        if strain {
            reversed(&q[PAD..], g);
        } else {
            overlaps(rest, &q[PAD - 1..], &q[PAD..], g);
        }
        law.forces_with_slopes(overlap, force, slope);
        for (closed, overlaps) in closed.iter_mut().zip(overlap.chunks(WORD / LANES)) {
            *closed = 0;
            for (block, g) in overlaps.iter().enumerate() {
                let mut bits = [0; LANES];
                for k in 0..LANES {
                    bits[k] = ((0.0 - g[k]).to_bits() >> (u64::BITS - 1)) << k;
                }
                *closed |= bits.iter().fold(0, |all, bit| all | bit) << (block * LANES);
            }
        }
    }
}

// Loops over slices that are arguments, so that the compiler knows them to be apart.

#[inline(always)]
fn reversed(q: &[f64], g: &mut [f64]) {
    for (g, q) in g.iter_mut().zip(q) {
        *g = -q;
    }
}

#[inline(always)]
fn overlaps(rest: f64, left: &[f64], right: &[f64], g: &mut [f64]) {
    for ((g, left), right) in g.iter_mut().zip(left).zip(right) {
        *g = rest + (left - right);
    }
}

/// Modified forces `F = f + c f' s` of bonds, and what they give to sites.
pub struct Modified<'a> {
    c: f64,
    strain: bool,
    ring: bool,
    sites: usize,
    /// From `PAD` on, as `springs` and `modified`.
    force: &'a [f64],
    slope: &'a [f64],
    spring: &'a [f64],
    modified: &'a mut [f64],
    /// On sites.
    push: &'a mut [f64],
}

impl Modified<'_> {
    #[inline(always)]
    fn compute(&mut self) {
        let &mut Self { c, strain, ring, sites: n, force, slope, spring, ref mut modified, ref mut push } = self;
        let f = [&force[PAD - 1..][..n + 1], &force[PAD..][..n + 1], &force[PAD + 1..][..n + 1]];
        let (slope, to) = (&slope[PAD..][..n + 1], &mut modified[PAD..][..n + 1]);
        if spring.is_empty() {
            modify(c, f, slope, to);
        } else {
            modify_with_springs(c, strain, f, slope, [&spring[PAD - 1..][..n + 1], &spring[PAD..][..n + 1]], to);
        }
        if ring {
            modified[PAD - 1] = modified[PAD + n - 1];
        }
        if strain {
            on_strains([&modified[PAD - 1..], &modified[PAD..], &modified[PAD + 1..]], push);
        } else {
            on_sites([&modified[PAD..], &modified[PAD + 1..]], push);
        }
    }
}

#[inline(always)]
fn modify(c: f64, [f0, f1, f2]: [&[f64]; 3], slope: &[f64], to: &mut [f64]) {
    let n = to.len();
    let (f0, f1, f2, slope) = (&f0[..n], &f1[..n], &f2[..n], &slope[..n]);
    for i in 0..n {
        to[i] = f1[i] + c * slope[i] * ((f0[i] - f1[i]) - (f1[i] - f2[i]));
    }
}

/// The springs of a strain ring act on strains, not on sites.
#[inline(always)]
fn modify_with_springs(
    c: f64,
    strain: bool,
    [f0, f1, f2]: [&[f64]; 3],
    slope: &[f64],
    [p0, p1]: [&[f64]; 2],
    to: &mut [f64],
) {
    let n = to.len();
    let (f0, f1, f2, slope, p0, p1) = (&f0[..n], &f1[..n], &f2[..n], &slope[..n], &p0[..n], &p1[..n]);
    for i in 0..n {
        let across = if strain { -p1[i] } else { p0[i] - p1[i] };
        to[i] = f1[i] + c * slope[i] * (((f0[i] - f1[i]) - (f1[i] - f2[i])) + across);
    }
}

#[inline(always)]
fn on_sites([here, after]: [&[f64]; 2], push: &mut [f64]) {
    for ((push, here), after) in push.iter_mut().zip(here).zip(after) {
        *push = here - after;
    }
}

#[inline(always)]
fn on_strains([before, here, after]: [&[f64]; 3], push: &mut [f64]) {
    for (((push, before), here), after) in push.iter_mut().zip(before).zip(here).zip(after) {
        *push = (here - after) - (before - here);
    }
}

#[inline(always)]
fn add(by: f64, push: &[f64], to: &mut [f64]) {
    for (to, push) in to.iter_mut().zip(push) {
        *to += by * push;
    }
}

impl<F: SiteFlow> SplitFlow<f64> for Bonded<F> {
    fn dim(&self) -> usize {
        self.flow.dim()
    }

    fn load(&mut self, y: &[f64]) {
        self.flow.load(y);
    }

    fn store(&self, y: &mut [f64]) {
        self.flow.store(y);
    }

    fn duplicate(&self) -> Self {
        let mut copy = Self::new(self.flow.duplicate());
        copy.copy_from(self);
        copy
    }

    fn copy_from(&mut self, other: &Self) {
        self.flow.copy_from(&other.flow);
        self.swung = other.swung;
        for (to, from) in [
            (&mut self.q, &other.q),
            (&mut self.overlap, &other.overlap),
            (&mut self.force, &other.force),
            (&mut self.slope, &other.slope),
            (&mut self.force_before, &other.force_before),
            (&mut self.spring, &other.spring),
            (&mut self.spring_before, &other.spring_before),
        ] {
            to.copy_from_slice(from);
        }
        self.closed.copy_from_slice(&other.closed);
        self.told.copy_from_slice(&other.told);
    }

    fn drift(&mut self, dt: Twofold<f64>) {
        self.flow.drift(dt);
    }

    fn kick_drift(&mut self, kick: f64, drift: Twofold<f64>) {
        self.survey();
        self.kick(kick, 0.0);
        self.flow.drift(drift);
    }
}

impl<F: SiteFlow> BondFlow for Bonded<F> {
    fn prepare(&mut self, h: f64) {
        self.swung = (h, swung(self.flow.response().2, h));
    }

    fn exponent(&self) -> f64 {
        self.chain().law().alpha()
    }

    fn bonds(&self) -> usize {
        self.chain().touching().len()
    }

    fn survey(&mut self) {
        self.overlaps_before.swap(0, 1);
        std::mem::swap(&mut self.overlap, &mut self.overlaps_before[0]);
        std::mem::swap(&mut self.force, &mut self.force_before);
        std::mem::swap(&mut self.spring, &mut self.spring_before);
        let n = self.sites;
        if !self.spring.is_empty() {
            for i in 0..n {
                self.spring[PAD + i] = self.flow.spring(i).0;
            }
            if self.ring() {
                (self.spring[PAD - 1], self.spring[PAD + n]) = (self.spring[PAD + n - 1], self.spring[PAD]);
            }
        }
        let (rest, law, strain) = (self.chain().precompression(), self.chain().law(), self.strain());
        let (boundary, end) = (self.chain().boundary(), self.chain().touching().end);
        let Self { flow, q, overlap, force, slope, closed, .. } = self;
        let overlap = overlap.blocks_mut();
        let bonds = PAD..PAD + overlap.len() * LANES;
        let (force, slope) = (force[bonds.clone()].as_chunks_mut().0, slope[bonds].as_chunks_mut().0);
        flow.survey(Forces { strain, rest, law: &law, boundary, sites: n, q, overlap, force, slope, closed });
        // What lies behind the last bond; on a ring that is the first once more.
        if let Some(word) = closed.get_mut(end / WORD) {
            *word &= (1 << (end % WORD)) - 1;
        }
        self.close();
    }

    #[inline]
    fn changed(&mut self, out: &mut Vec<(usize, bool)>) {
        let first = self.chain().touching().start;
        for (word, (&now, before)) in self.closed.iter().zip(&mut self.told).enumerate() {
            let mut changes = now ^ *before;
            while changes != 0 {
                let k = changes.trailing_zeros() as usize;
                changes &= changes - 1;
                out.push((word * WORD + k - first, now >> k & 1 == 1));
            }
            *before = now;
        }
    }

    #[inline]
    fn turned(&self, reach: f64, out: &mut Vec<(usize, bool)>) {
        let touching = self.chain().touching();
        let [middle, first] = &self.overlaps_before;
        let g = [first, middle, &self.overlap].map(|g| &g[..touching.end]);
        f64::run(Turned { g, first: touching.start, reach, out });
    }

    fn force(&self, bond: usize) -> (f64, f64) {
        let b = self.bond(bond);
        let ((_, mobility), force) = (self.neighbours(b), self.force[PAD + b]);
        (force, self.pull(b, &self.force, &self.spring) - mobility * force)
    }

    fn path(&self, bond: usize) -> BondPath {
        let b = self.bond(bond);
        let pull = self.pull(b, &self.force, &self.spring);
        self.along(b, [pull; 2], 0.0)
    }

    #[inline]
    fn view(&self, bond: usize, h: f64) -> BondView {
        let b = self.bond(bond);
        let (_, mobility) = self.neighbours(b);
        let now = self.pull(b, &self.force, &self.spring);
        let before = self.pull(b, &self.force_before, &self.spring_before);
        BondView { path: self.along(b, [before, now], h), mobility, pull: [before, now] }
    }

    #[inline]
    fn correct(&mut self, bond: usize, correction: &Correction) {
        let (b, n) = (self.bond(bond), self.sites);
        let shift = self.flow.shift(correction);
        let previous = |b: usize| if b > 0 { b - 1 } else { n - 1 };
        let beads: &[(usize, f64)] = match self.chain().boundary() {
            Boundary::StrainRing => &[(b, 2.0), ((b + 1) % n, -1.0), (previous(b), -1.0)],
            Boundary::Fixed if b == 0 => &[(0, 1.0)],
            Boundary::Fixed if b == n => &[(n - 1, -1.0)],
            _ => &[(previous(b), -1.0), (b, 1.0)],
        };
        self.flow.give(beads, correction);
        for &(site, weight) in beads {
            self.q[PAD + site] += weight * shift;
        }
        self.refresh(b);
    }

    fn kick(&mut self, kick: f64, c: f64) {
        let (strain, ring, sites) = (self.strain(), self.ring(), self.sites);
        let Self { flow, force, slope, spring, modified, a, push, .. } = self;
        if !spring.is_empty() {
            // Springs that kick want the accelerations of what they hold.
            let f = |b: usize| force[PAD + b - 1] - force[PAD + b];
            for i in 0..sites {
                a[i] = if strain { f(i + 1) - f(i) } else { f(i + 1) } + spring[PAD + i];
            }
        }
        flow.push(kick, Modified { c, strain, ring, sites, force, slope, spring, modified, push }, a);
    }

    fn process(&mut self, share: f64, sides: &[Side]) {
        let start = self.jet(sides);
        self.shift(0.5 * share, &start);
        let middle = self.jet(sides);
        self.shift(share, &middle);
        self.shift(-0.5 * share, &start);
    }

    /// By contact collocation: the equations are the same backwards, with velocities reversed.
    fn back(&self, y: &mut [f64], by: f64) {
        let half = y.len() / 2;
        let turn = |y: &mut [f64]| y[half..].iter_mut().for_each(|velocity| *velocity = -*velocity);
        turn(y);
        let window = Pace::Windows { windows: 1, nodes: INSIDE, neighbours: true };
        // A window too long for the stiffness of its contacts does not settle; the tolerance makes it shorter.
        let settled = self.run_on(y, by, window).or_else(|_| self.run_on(y, by, Pace::Tolerance(TOLERANCE)));
        if settled.is_err() {
            // No state is better than a wrong one.
            y.fill(f64::NAN);
        }
        turn(y);
    }
}

/// Which overlaps turn near zero.
struct Turned<'a> {
    g: [&'a [f64]; 3],
    first: usize,
    reach: f64,
    out: &'a mut Vec<(usize, bool)>,
}

impl Kernel for Turned<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { g: [g0, g1, g2], first, reach, out } = self;
        let turns = |g0: f64, g1: f64, g2: f64| {
            let (before, after) = (g1 - g0, g2 - g1);
            (before * after < 0.0) & (g1.abs() < reach * (after - before).abs())
        };
        let n = g2.len();
        let (g0, g1) = (&g0[..n], &g1[..n]);
        for start in (0..n).step_by(WORD) {
            let end = (start + WORD).min(n);
            if perhaps(reach, [&g0[start..end], &g1[start..end], &g2[start..end]]) {
                let turned = (start.max(first)..end).filter(|&i| turns(g0[i], g1[i], g2[i]));
                out.extend(turned.map(|i| (i - first, g1[i] > 0.0)));
            }
        }
    }
}

/// Whether any overlap of some may turn, by the signs of both conditions: in vector registers.
#[inline(always)]
fn perhaps(reach: f64, [g0, g1, g2]: [&[f64]; 3]) -> bool {
    let mut signs = 0;
    for ((g0, g1), g2) in g0.iter().zip(g1).zip(g2) {
        let (before, after) = (g1 - g0, g2 - g1);
        signs |= (before * after).to_bits() & (g1.abs() - reach * (after - before).abs()).to_bits();
    }
    signs >> (u64::BITS - 1) == 1
}

impl<F: SiteFlow> Bonded<F> {
    /// Moves a state on by contact collocation.
    fn run_on(&self, y: &mut [f64], by: f64, pace: Pace) -> Result<(), Error> {
        let mut run = self.chain().collocation(y, (0.0, by), pace)?;
        while !run.done() {
            run.step()?;
        }
        run.sample(by, y);
        Ok(())
    }
}

impl SiteFlow for LinearFlow<f64> {
    fn chain(&self) -> &Chain<f64> {
        &self.chain
    }

    fn survey(&mut self, forces: Forces<'_>) {
        self.phase = self.theta.sin_cos();
        f64::run(Survey { flow: self, forces });
    }

    fn bead(&self, site: usize) -> (f64, f64) {
        let (r, r_dot, p, p_dot) = self.modes(site, self.phase);
        (r + p, r_dot + p_dot)
    }

    #[inline]
    fn motion(&self, site: usize) -> [f64; 3] {
        let (_, r_dot, p, p_dot) = self.modes(site, self.phase);
        [r_dot + p_dot, p, p_dot]
    }

    fn response(&self) -> (f64, f64, f64) {
        (self.m, self.mu(), self.omega.value())
    }

    fn spring(&self, _site: usize) -> (f64, f64) {
        (0.0, 0.0)
    }

    fn shift(&self, correction: &Correction) -> f64 {
        let &Correction { impulse, displacement, at, turn: [sin, cos], .. } = correction;
        self.m * (displacement - impulse * at)
            + (self.mu() * (displacement * cos) - self.mu_over_omega * (impulse * sin))
    }

    fn give(&mut self, beads: &[(usize, f64)], correction: &Correction) {
        let &Correction { impulse, displacement, at, turn, .. } = correction;
        let (m, mu) = (self.m, self.mu());
        if let [r0, v] = &mut self.centre
            && !v.is_empty()
        {
            let (by_r0, by_v) = (m * (displacement - impulse * (self.tau + at)), m * impulse);
            for &(site, weight) in beads {
                r0[site] += weight * by_r0;
                v[site] += weight * by_v;
            }
        }
        if let [c, s] = &mut self.oscillation
            && !s.is_empty()
        {
            let (sin, cos) = self.phase;
            let [turn_sin, turn_cos] = turn;
            let (sin, cos) = (sin * turn_cos + cos * turn_sin, cos * turn_cos - sin * turn_sin);
            let by_c = mu * (displacement * cos) - self.mu_over_omega * (impulse * sin);
            let by_s = mu * (displacement * sin) + self.mu_over_omega * (impulse * cos);
            for &(site, weight) in beads {
                c[site] += weight * by_c;
                s[site] += weight * by_s;
            }
        }
    }

    fn give_resonator(&mut self, _site: usize, _impulse: f64, _displacement: f64) {}

    fn push(&mut self, kick: f64, forces: Modified<'_>, _a: &[f64]) {
        self.count_kick();
        f64::run(Push { flow: self, kick, forces });
    }
}

struct Survey<'a> {
    flow: &'a LinearFlow<f64>,
    forces: Forces<'a>,
}

impl Kernel for Survey<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { flow, forces } = self;
        let ([r0, v], [c, s]) = (&flow.centre, &flow.oscillation);
        let ((sin, cos), tau) = (flow.phase, flow.tau);
        let u = &mut forces.q[PAD..][..forces.sites];
        match (r0.is_empty(), c.is_empty()) {
            (false, false) => sums_of_four([r0, v, c, s], [tau, cos, sin], u),
            (false, true) => sums_of_two([r0, v], [1.0, tau], u),
            _ => sums_of_two([c, s], [cos, sin], u),
        }
        forces.compute();
    }
}

#[inline(always)]
fn sums_of_four([r0, v, c, s]: [&[f64]; 4], [tau, cos, sin]: [f64; 3], u: &mut [f64]) {
    let n = u.len();
    let (r0, v, c, s) = (&r0[..n], &v[..n], &c[..n], &s[..n]);
    for i in 0..n {
        u[i] = (r0[i] + v[i] * tau) + (c[i] * cos + s[i] * sin);
    }
}

#[inline(always)]
fn sums_of_two([x, y]: [&[f64]; 2], [by_x, by_y]: [f64; 2], u: &mut [f64]) {
    for ((u, x), y) in u.iter_mut().zip(x).zip(y) {
        *u = x * by_x + y * by_y;
    }
}

struct Push<'a> {
    flow: &'a mut LinearFlow<f64>,
    kick: f64,
    forces: Modified<'a>,
}

impl Kernel for Push<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { flow, kick, mut forces } = self;
        forces.compute();
        let (sin, cos) = flow.phase;
        let (kick_v, per_omega) = (kick * flow.m, kick * flow.mu_over_omega);
        let ([r0, v], [c, s]) = (&mut flow.centre, &mut flow.oscillation);
        add(-(kick_v * flow.tau), forces.push, r0);
        add(kick_v, forces.push, v);
        add(-(per_omega * sin), forces.push, c);
        add(per_omega * cos, forces.push, s);
    }
}

impl SiteFlow for KineticFlow<f64> {
    fn chain(&self) -> &Chain<f64> {
        &self.chain
    }

    fn survey(&mut self, forces: Forces<'_>) {
        forces.q[PAD..][..forces.sites].copy_from_slice(&self.y[..forces.sites]);
        f64::run(forces);
    }

    fn bead(&self, site: usize) -> (f64, f64) {
        (self.y[site], self.y[self.y.len() / 2 + site])
    }

    fn motion(&self, site: usize) -> [f64; 3] {
        [self.y[self.y.len() / 2 + site], 0.0, 0.0]
    }

    fn response(&self) -> (f64, f64, f64) {
        (1.0, 0.0, 0.0)
    }

    fn spring(&self, site: usize) -> (f64, f64) {
        let kappa = self.chain.params().kappa;
        let (d, d_dot) = self.stretch(site);
        (-(kappa * d), -(kappa * d_dot))
    }

    fn shift(&self, correction: &Correction) -> f64 {
        correction.displacement - correction.impulse * correction.at
    }

    fn give(&mut self, beads: &[(usize, f64)], correction: &Correction) {
        let &Correction { impulse, displacement, at, .. } = correction;
        let half = self.y.len() / 2;
        for &(site, weight) in beads {
            self.y[site] += weight * (displacement - impulse * at);
            self.y[half + site] += weight * impulse;
        }
    }

    fn give_resonator(&mut self, site: usize, impulse: f64, displacement: f64) {
        let (n, half) = (self.chain.sites(), self.y.len() / 2);
        if self.chain.layout().resonators() {
            self.y[n + site] += displacement;
            self.y[half + n + site] += impulse;
        }
    }

    #[allow(clippy::needless_range_loop, reason = "a loop over sites reads like the formula")]
    fn push(&mut self, kick: f64, forces: Modified<'_>, a: &[f64]) {
        let (n, half, params, c) = (self.chain.sites(), self.y.len() / 2, self.chain.params(), forces.c);
        f64::run(Kicks { kick, velocities: &mut self.y[half..half + n], forces });
        let moving = self.chain.layout().resonators();
        let per_rho = if moving { params.kappa / params.rho } else { 0.0 };
        if params.omega() == 0.0 {
            return;
        }
        for i in 0..n {
            let d = self.stretch(i).0;
            let d = d + c * (a[i] - per_rho * d);
            self.y[half + i] -= kick * (params.kappa * d);
            if moving {
                self.y[half + n + i] += kick * (per_rho * d);
            }
        }
    }
}

/// Forces times `kick`, added to velocities.
struct Kicks<'a> {
    kick: f64,
    velocities: &'a mut [f64],
    forces: Modified<'a>,
}

impl Kernel for Kicks<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        self.forces.compute();
        add(self.kick, self.forces.push, self.velocities);
    }
}

impl Kernel for Forces<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.compute();
    }
}

impl KineticFlow<f64> {
    /// The stretch of a spring, and its rate; zero without resonators.
    fn stretch(&self, site: usize) -> (f64, f64) {
        let (n, half) = (self.chain.sites(), self.y.len() / 2);
        if self.chain.layout().resonators() {
            (self.y[site] - self.y[n + site], self.y[half + site] - self.y[half + n + site])
        } else if self.chain.params().omega() > 0.0 {
            (self.y[site], self.y[half + site])
        } else {
            (0.0, 0.0)
        }
    }
}
