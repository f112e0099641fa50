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
    law::{LANES, Lanes},
};
use hertzchain_integrators::{
    Error, Kernel, Real, SplitFlow, Stepper, Twofold,
    collocation::Pace,
    splitting::corrected::{BondFlow, BondPath, BondView, Correction, Side},
};

/// Numbers before the first of an array, so that what lies before it can be loaded too.
const PAD: usize = LANES;
/// Bonds in a piece that is searched for changes at once.
const PIECE: usize = 16;
/// Nodes of the window that leads back inside a step, and the tolerance where one window does not do.
const INSIDE: usize = 12;
const TOLERANCE: f64 = 1e-13;

/// Sites that the drift of a split moves exactly, one by one.
pub trait SiteFlow: SplitFlow<f64> {
    /// The chain.
    fn chain(&self) -> &Chain<f64>;
    /// Writes the positions of all beads.
    fn positions(&mut self, u: &mut [f64]);
    /// Position and velocity of a bead.
    fn bead(&self, site: usize) -> (f64, f64);
    /// Velocity of a bead, its part that oscillates with `omega` in the drift, and the velocity of that.
    fn motion(&self, site: usize) -> [f64; 3];
    /// The shares of an impulse on a bead that move freely and that oscillate in the drift, and `omega`.
    fn response(&self) -> (f64, f64, f64);
    /// The force of the spring on a bead, where it is part of the kick, and its rate.
    fn spring(&self, site: usize) -> (f64, f64);
    /// Gives beads an impulse and a displacement, each so many times as it says, at a time relative to now.
    fn give(&mut self, beads: &[(usize, f64)], impulse: f64, displacement: f64, at: f64);
    /// Moves what kicks move beside beads: resonators, where springs are part of the kick. By an impulse over the mass, and a displacement.
    fn give_resonator(&mut self, site: usize, impulse: f64, displacement: f64);
    /// Kicks beads by `kick` times `push`, and by springs where these kick: `-kappa (d + c d'')`, with the accelerations `a` of beads.
    fn push(&mut self, kick: f64, c: f64, push: &[f64], a: &[f64]);
}

/// A split of the chain with the kicks of contact-corrected splitting.
///
/// Arrays are longer than the chain, so that loops over whole registers need no remainder; what is in the rest is not looked at.
pub struct Bonded<F> {
    flow: F,
    sites: usize,
    /// Positions, from `PAD` on, with one of a neighbour on either side.
    q: Vec<f64>,
    overlap: Vec<f64>,
    /// Forces and derivatives, from `PAD` on, with those of neighbours on either side.
    force: Vec<f64>,
    slope: Vec<f64>,
    /// Forces at the survey before.
    force_before: Vec<f64>,
    /// `0 - overlap` as surveyed: the sign bit says that a bond is closed. Then the same when changes were last told.
    open: Vec<f64>,
    told: Vec<f64>,
    /// Forces of springs on beads, where these kick, from `PAD` on, and those at the survey before.
    spring: Vec<f64>,
    spring_before: Vec<f64>,
    /// Accelerations of sites, for springs that kick.
    a: Vec<f64>,
    push: Vec<f64>,
    /// A step, and [`swung`] of it.
    swung: (f64, f64),
}

impl<F: SiteFlow> Bonded<F> {
    /// Of a flow that holds a state.
    pub fn new(flow: F) -> Self {
        let sites = flow.chain().sites();
        let (_, _, omega) = flow.response();
        let springs = omega == 0.0 && flow.chain().params().omega() > 0.0;
        let zeros = || vec![0.0; (sites + 1).next_multiple_of(LANES) + LANES];
        let padded = || vec![0.0; PAD + (sites + 1).next_multiple_of(LANES) + LANES];
        Self {
            flow,
            sites,
            q: padded(),
            overlap: zeros(),
            force: padded(),
            slope: padded(),
            force_before: padded(),
            open: zeros(),
            told: zeros(),
            spring: if springs { padded() } else { Vec::new() },
            spring_before: if springs { padded() } else { Vec::new() },
            a: zeros(),
            push: zeros(),
            swung: (0.0, 1.0),
        }
    }

    fn chain(&self) -> &Chain<f64> {
        self.flow.chain()
    }

    fn strain(&self) -> bool {
        self.chain().boundary() == Boundary::StrainRing
    }

    fn ring(&self) -> bool {
        matches!(self.chain().boundary(), Boundary::Ring | Boundary::StrainRing)
    }

    /// The bond that number `index` among those that can touch is.
    fn bond(&self, index: usize) -> usize {
        self.chain().touching().start + index
    }

    /// What stands for forces beyond the ends, so that the accelerations of sites there are those of neighbours, or none.
    fn close(&mut self) {
        let n = self.sites;
        let (ring, f) = (self.ring(), &mut self.force[PAD - 2..]);
        for (beyond, inside) in [(0, n as isize - 2), (1, n as isize - 1), (n + 3, 1), (n + 4, 2)] {
            let clamped = if beyond < 2 { 0 } else { n };
            f[beyond] = f[2 + if ring { inside.rem_euclid(n as isize) as usize } else { clamped }];
        }
        if ring {
            self.slope[PAD - 1] = self.slope[PAD + n - 1];
        }
    }

    /// What stands for positions beyond the ends.
    fn close_positions(&mut self) {
        let n = self.sites;
        let ghosts = self.chain().boundary().ghosts(self.q[PAD], self.q[PAD + n - 1]);
        (self.q[PAD - 1], self.q[PAD + n]) = ghosts;
    }

    /// Position, overlaps and forces around a site that has moved.
    fn refresh(&mut self, site: usize) {
        let n = self.sites;
        self.q[PAD + site] = self.flow.bead(site).0;
        if site == 0 || site + 1 == n {
            self.close_positions();
        }
        self.refresh_bond(site);
        if !self.strain() {
            self.refresh_bond(site + 1);
        }
        // A ring's first bond is its last.
        if self.ring() && (site == 0 || site + 1 == n) {
            self.refresh_bond(0);
            self.refresh_bond(n);
        }
    }

    fn refresh_bond(&mut self, b: usize) {
        let (law, q) = (self.chain().law(), &self.q[PAD - 1..]);
        let g = if self.strain() { -q[b + 1] } else { self.chain().precompression() + (q[b] - q[b + 1]) };
        self.overlap[b] = g;
        (self.force[PAD + b], self.slope[PAD + b]) = law.force_with_slope(g);
    }

    /// The bonds on the sides of a bond, and how many of its sides are beads.
    fn neighbours(&self, b: usize) -> ([Option<usize>; 2], f64) {
        let n = self.sites;
        let left = if b > 0 { Some(b - 1) } else { self.ring().then_some(n - 1) };
        let right = (b < n).then_some(b + 1);
        ([left, right], f64::from(u8::from(left.is_some()) + u8::from(right.is_some())))
    }

    /// How forces of neighbours and springs, as given, accelerate the overlap of a bond.
    fn pull(&self, b: usize, force: &[f64], spring: &[f64]) -> f64 {
        let ([left, right], _) = self.neighbours(b);
        let contacts = left.map_or(0.0, |b| force[PAD + b]) + right.map_or(0.0, |b| force[PAD + b]);
        if spring.is_empty() { contacts } else { contacts + self.chain().across(b, |i| spring[PAD + i]) }
    }

    /// The path of a bond under a pull that was `before` a step `h` ago and is `now`: through its places at both ends of the step, and moved by processing.
    ///
    /// With the mean `s` and the rate `s'` of the pull, what the chord lacks is `s t (t + h)/2 + s' t (t + h)(t + h/2)/6`.
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
        let (before, behind) = match self.chain().boundary() {
            Boundary::StrainRing => return of(b).map(|x| -x),
            Boundary::Ring => (if b > 0 { b - 1 } else { n - 1 }, b),
            _ if b == 0 => return of(0).map(|x| -x),
            _ if b == n => return of(n - 1),
            _ => (b - 1, b),
        };
        let (x, y) = (of(before), of(behind));
        std::array::from_fn(|k| x[k] - y[k])
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
            self.flow.give(&[(i, 1.0)], -share * da, share * a, 0.0);
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

/// Eight numbers from `i` on.
#[inline(always)]
fn lanes(x: &[f64], i: usize) -> Lanes<f64> {
    let mut out = [0.0; LANES];
    out.copy_from_slice(&x[i..i + LANES]);
    out
}

/// Writes eight numbers, once all are known: the compiler then keeps them in one register.
#[inline(always)]
fn put(x: &mut [f64], i: usize, number: impl Fn(usize) -> f64) {
    let mut out = [0.0; LANES];
    for (k, out) in out.iter_mut().enumerate() {
        *out = number(k);
    }
    x[i..i + LANES].copy_from_slice(&out);
}

/// Overlaps, forces and derivatives from positions, and which bonds are open.
struct Forces<'a> {
    strain: bool,
    rest: f64,
    law: &'a ContactLaw<f64>,
    q: &'a [f64],
    overlap: &'a mut [f64],
    force: &'a mut [f64],
    slope: &'a mut [f64],
    open: &'a mut [f64],
}

impl Kernel for Forces<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { strain, rest, law, q, overlap, force, slope, open } = self;
        let whole = overlap.len() - LANES;
        for i in (0..whole).step_by(LANES) {
            let (left, right) = (lanes(q, i + PAD - 1), lanes(q, i + PAD));
            if strain {
                put(overlap, i, |k| -right[k]);
            } else {
                put(overlap, i, |k| rest + (left[k] - right[k]));
            }
            let g = lanes(overlap, i);
            put(open, i, |k| 0.0 - g[k]);
        }
        let [force, slope] = [force, slope].map(|x| x[PAD..PAD + whole].as_chunks_mut::<LANES>().0);
        law.forces_with_slopes(overlap[..whole].as_chunks::<LANES>().0, force, slope);
    }
}

/// What modified forces give to sites, from forces in one pass: what a load across two stores waits for has long been written.
struct Pushes<'a> {
    c: f64,
    strain: bool,
    force: &'a [f64],
    slope: &'a [f64],
    spring: &'a [f64],
    push: &'a mut [f64],
}

impl Kernel for Pushes<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { c, strain, force, slope, spring, push } = self;
        let zeros = [0.0; LANES];
        for i in (0..push.len() - LANES).step_by(LANES) {
            // From two bonds before to two after.
            let f = |k: usize| lanes(force, i + PAD - 2 + k);
            let stiff = |k: usize| lanes(slope, i + PAD - 2 + k);
            let springs = |k: usize| if spring.is_empty() { zeros } else { lanes(spring, i + PAD - 2 + k) };
            let (f0, f1, f2, f3) = (f(1), f(2), f(3), f(4));
            let (s1, s2) = (stiff(2), stiff(3));
            let (p0, p1, p2) = (springs(1), springs(2), springs(3));
            if strain {
                // The springs of a strain ring act on strains, not on sites.
                let (e, s0) = (f(0), stiff(1));
                put(push, i, |k| {
                    let m0 = f0[k] + c * s0[k] * (((e[k] - f0[k]) - (f0[k] - f1[k])) - p0[k]);
                    let m1 = f1[k] + c * s1[k] * (((f0[k] - f1[k]) - (f1[k] - f2[k])) - p1[k]);
                    let m2 = f2[k] + c * s2[k] * (((f1[k] - f2[k]) - (f2[k] - f3[k])) - p2[k]);
                    (m1 - m2) - (m0 - m1)
                });
            } else {
                put(push, i, |k| {
                    let (a0, a1, a2) = ((f0[k] - f1[k]) + p0[k], (f1[k] - f2[k]) + p1[k], (f2[k] - f3[k]) + p2[k]);
                    (f1[k] + c * s1[k] * (a0 - a1)) - (f2[k] + c * s2[k] * (a1 - a2))
                });
            }
        }
    }
}

/// Whether any bond of a piece has changed its side, as a bit a piece; for 64 pieces at most.
struct Changes<'a> {
    now: &'a [f64],
    before: &'a [f64],
}

impl Kernel for Changes<'_> {
    type Output = u64;

    #[inline(always)]
    fn run(self) -> u64 {
        let pieces = self.now.chunks(PIECE).zip(self.before.chunks(PIECE));
        pieces.enumerate().fold(0, |found, (piece, (now, before))| {
            let bits = now.iter().zip(before).fold(0, |bits, (x, y)| bits | (x.to_bits() ^ y.to_bits()));
            found | (bits >> 63) << piece
        })
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
            (&mut self.open, &other.open),
            (&mut self.told, &other.told),
            (&mut self.spring, &other.spring),
            (&mut self.spring_before, &other.spring_before),
        ] {
            to.copy_from_slice(from);
        }
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
        std::mem::swap(&mut self.force, &mut self.force_before);
        std::mem::swap(&mut self.spring, &mut self.spring_before);
        let n = self.sites;
        self.flow.positions(&mut self.q[PAD..PAD + n]);
        if !self.spring.is_empty() {
            for i in 0..n {
                self.spring[PAD + i] = self.flow.spring(i).0;
            }
            if self.ring() {
                (self.spring[PAD - 1], self.spring[PAD + n]) = (self.spring[PAD + n - 1], self.spring[PAD]);
            }
        }
        self.close_positions();
        let (rest, law, strain) = (self.chain().precompression(), self.chain().law(), self.strain());
        let Self { q, overlap, force, slope, open, .. } = self;
        f64::run(Forces { strain, rest, law: &law, q, overlap, force, slope, open });
    }

    fn changed(&mut self, out: &mut Vec<(usize, bool)>) {
        let touching = self.chain().touching();
        let (now, before) = (&self.open[touching.clone()], &self.told[touching]);
        let stretches = now.chunks(64 * PIECE).zip(before.chunks(64 * PIECE));
        for (stretch, (now, before)) in stretches.enumerate() {
            let mut found = f64::run(Changes { now, before });
            while found != 0 {
                let first = found.trailing_zeros() as usize * PIECE;
                found &= found - 1;
                for i in first..now.len().min(first + PIECE) {
                    if now[i].is_sign_negative() != before[i].is_sign_negative() {
                        out.push((stretch * 64 * PIECE + i, now[i].is_sign_negative()));
                    }
                }
            }
        }
        std::mem::swap(&mut self.open, &mut self.told);
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

    fn view(&self, bond: usize, h: f64) -> BondView {
        let b = self.bond(bond);
        let (_, mobility) = self.neighbours(b);
        let now = self.pull(b, &self.force, &self.spring);
        let before = self.pull(b, &self.force_before, &self.spring_before);
        BondView { path: self.along(b, [before, now], h), mobility }
    }

    fn correct(&mut self, bond: usize, correction: &Correction) {
        let &Correction { impulse, displacement, at, .. } = correction;
        let (b, n) = (self.bond(bond), self.sites);
        let previous = |b: usize| if b > 0 { b - 1 } else { n - 1 };
        let beads: &[(usize, f64)] = match self.chain().boundary() {
            Boundary::StrainRing => &[(b, 2.0), ((b + 1) % n, -1.0), (previous(b), -1.0)],
            Boundary::Fixed if b == 0 => &[(0, 1.0)],
            Boundary::Fixed if b == n => &[(n - 1, -1.0)],
            _ => &[(previous(b), -1.0), (b, 1.0)],
        };
        self.flow.give(beads, impulse, displacement, at);
        for &(site, _) in beads {
            self.refresh(site);
        }
    }

    fn kick(&mut self, kick: f64, c: f64) {
        self.close();
        let (strain, n) = (self.strain(), self.sites);
        let Self { flow, force, slope, spring, a, push, .. } = self;
        f64::run(Pushes { c, strain, force, slope, spring, push });
        if !spring.is_empty() {
            // Springs that kick want the accelerations of what they hold.
            let f = |b: usize| force[PAD + b - 1] - force[PAD + b];
            for i in 0..n {
                a[i] = if strain { f(i + 1) - f(i) } else { f(i + 1) } + spring[PAD + i];
            }
        }
        flow.push(kick, c, &push[..n], a);
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

    fn positions(&mut self, u: &mut [f64]) {
        self.phase = self.theta.sin_cos();
        f64::run(Positions { flow: self, u });
    }

    fn bead(&self, site: usize) -> (f64, f64) {
        let (r, r_dot, p, p_dot) = self.modes(site, self.phase);
        (r + p, r_dot + p_dot)
    }

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

    fn give(&mut self, beads: &[(usize, f64)], impulse: f64, displacement: f64, at: f64) {
        let (m, mu, omega) = self.response();
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
            let (turn_sin, turn_cos) = (omega * at).sin_cos();
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

    fn push(&mut self, kick: f64, _c: f64, push: &[f64], _a: &[f64]) {
        self.count_kick();
        f64::run(Impulses { flow: self, kick, push });
    }
}

struct Positions<'a> {
    flow: &'a LinearFlow<f64>,
    u: &'a mut [f64],
}

impl Kernel for Positions<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { flow, u } = self;
        let ([r0, v], [c, s]) = (&flow.centre, &flow.oscillation);
        let ((sin, cos), tau) = (flow.phase, flow.tau);
        let n = u.len();
        let whole = n - n % LANES;
        // Register by register, then one by one: the same sums.
        if !c.is_empty() && !r0.is_empty() {
            let at = |i: usize| (r0[i] + v[i] * tau) + (c[i] * cos + s[i] * sin);
            for i in (0..whole).step_by(LANES) {
                let (r0, v, c, s) = (lanes(r0, i), lanes(v, i), lanes(c, i), lanes(s, i));
                put(u, i, |k| (r0[k] + v[k] * tau) + (c[k] * cos + s[k] * sin));
            }
            (whole..n).for_each(|i| u[i] = at(i));
        } else {
            let ((x, y), (by_x, by_y)) = if c.is_empty() { ((r0, v), (1.0, tau)) } else { ((c, s), (cos, sin)) };
            for i in (0..whole).step_by(LANES) {
                let (x, y) = (lanes(x, i), lanes(y, i));
                put(u, i, |k| x[k] * by_x + y[k] * by_y);
            }
            (whole..n).for_each(|i| u[i] = x[i] * by_x + y[i] * by_y);
        }
    }
}

struct Impulses<'a> {
    flow: &'a mut LinearFlow<f64>,
    kick: f64,
    push: &'a [f64],
}

impl Kernel for Impulses<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { flow, kick, push } = self;
        let (sin, cos) = flow.phase;
        let (kick_v, per_omega) = (kick * flow.m, kick * flow.mu_over_omega);
        let (kick_r0, kick_c, kick_s) = (-(kick_v * flow.tau), -(per_omega * sin), per_omega * cos);
        let [r0, v] = &mut flow.centre;
        add(push, [(r0, kick_r0), (v, kick_v)]);
        let [c, s] = &mut flow.oscillation;
        add(push, [(c, kick_c), (s, kick_s)]);
    }
}

/// Adds multiples of `push` to two arrays, if they are there.
#[inline(always)]
fn add(push: &[f64], [(x, by_x), (y, by_y)]: [(&mut Vec<f64>, f64); 2]) {
    if x.is_empty() {
        return;
    }
    let n = push.len();
    let (x, y) = (&mut x[..n], &mut y[..n]);
    let whole = n - n % LANES;
    for i in (0..whole).step_by(LANES) {
        let (j, x_was, y_was) = (lanes(push, i), lanes(x, i), lanes(y, i));
        put(x, i, |k| x_was[k] + by_x * j[k]);
        put(y, i, |k| y_was[k] + by_y * j[k]);
    }
    for i in whole..n {
        x[i] += by_x * push[i];
        y[i] += by_y * push[i];
    }
}

impl SiteFlow for KineticFlow<f64> {
    fn chain(&self) -> &Chain<f64> {
        &self.chain
    }

    fn positions(&mut self, u: &mut [f64]) {
        u.copy_from_slice(&self.y[..u.len()]);
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

    fn give(&mut self, beads: &[(usize, f64)], impulse: f64, displacement: f64, at: f64) {
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

    fn push(&mut self, kick: f64, c: f64, push: &[f64], a: &[f64]) {
        let (n, half, params) = (self.chain.sites(), self.y.len() / 2, self.chain.params());
        let moving = self.chain.layout().resonators();
        let per_rho = if moving { params.kappa / params.rho } else { 0.0 };
        let springs = params.omega() > 0.0;
        for i in 0..n {
            if !springs {
                self.y[half + i] += kick * push[i];
                continue;
            }
            let d = self.stretch(i).0;
            let d = d + c * (a[i] - per_rho * d);
            self.y[half + i] += kick * (push[i] - params.kappa * d);
            if moving {
                self.y[half + n + i] += kick * (per_rho * d);
            }
        }
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
