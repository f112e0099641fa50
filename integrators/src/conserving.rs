//! The scheme of the discrete gradient (average vector field), which conserves the energy exactly:
//! a rival of the symplectic schemes, the [`DiscreteGradient`].
//!
//! It has order two, also on smooth problems, and is not symplectic; the forces of a step are found
//! by iteration. Springs enter as forces, like contacts: it does not use the exact linear flow.
//!
//! | symbol | meaning |
//! |---|---|
//! | `[r, r', p, p']` | free and oscillating part of the position of a site, and their rates, see [`ContactChain`] |
//! | `m, mu` | shares of an impulse that these two parts take; their masses are `1/m` and `1/mu` |
//! | `g_b, f, V` | overlap of a bond; force `(g)_+^alpha` and potential of the contact law |
//! | `F_i` | contact force on a site |
//!
//! Linear parts are integrated by the midpoint rule. The force of a bond over a step in which its
//! overlap goes from `g_0` to `g_1` is
//!
//! ```text
//! phi = (V(g_1) - V(g_0))/(g_1 - g_0) = int_0^1 f(g_0 + s (g_1 - g_0)) ds
//! ```
//!
//! so that the work `phi (g_1 - g_0)` of the bond is the change of its potential: the energy is
//! conserved whatever the step. `g_1` depends on the `phi` of the bond and its neighbours; bonds
//! are solved one by one, by Newton's method, in sweeps over the chain until nothing changes.
//!
//! R. I. McLachlan, G. R. W. Quispel and N. Robidoux, *Phil. Trans. R. Soc. A* 357 (1999) 1021;
//! G. R. W. Quispel and D. I. McLaren, *J. Phys. A* 41 (2008) 045206.

use crate::{
    clock::DoubleDouble,
    collocation::{ContactChain, Path},
    drive::Stepper,
    error::Error,
    interrupt,
    law::ContactLaw,
    splitting::steps::Steps,
    stats::Stats,
};

/// Most sweeps of a step. They converge where `h^2` times the stiffness of a contact is below one.
const SWEEPS: u32 = 500;
/// Most iterations of Newton's method for one bond. The equation is convex and is approached from
/// one side.
const NEWTON: u32 = 100;
/// Relative change of an overlap below which the quotient of differences is replaced by its series
/// up to the fourth power. The error of the series is then below one rounding; just above, that of
/// the quotient is 100 roundings.
const NEAR: f64 = 1e-2;
/// Largest relative change of a force that may be a rounding error, as quotients have them over a
/// few sweeps.
const ROUNDING: f64 = 1e-12;

/// Sites as `[r, r', p, p']`.
type Sites = Vec<[f64; 4]>;

/// A chain with the constants that all its sites share.
struct Modal<C> {
    chain: C,
    law: ContactLaw<f64>,
    m: f64,
    mu: f64,
    /// `omega^2`.
    stiffness: f64,
    /// Decrease of each bond's overlap if a unit force of this bond displaces each of its sites by
    /// one unit.
    mobility: Vec<f64>,
    /// Overlaps at the start of a step, and at its end without contact forces.
    overlaps: [Vec<f64>; 2],
}

impl<C: ContactChain> Modal<C> {
    fn new(chain: C) -> Self {
        let response = chain.response(0);
        let omega = response.omega.value();
        let mobility = |b| -chain.across(b, |i| chain.push(i, |c| [path(f64::from(u8::from(c == b)))]))[0][0];
        let zeros = || vec![0.0; chain.bonds()];
        Self {
            mobility: (0..chain.bonds()).map(mobility).collect(),
            overlaps: [zeros(), zeros()],
            law: chain.bond(0).power,
            m: response.m,
            mu: response.mu,
            stiffness: omega * omega,
            chain,
        }
    }

    /// Sites of a state.
    fn load(&self, y: &[f64]) -> Sites {
        let omega = self.stiffness.sqrt();
        let site = |i| {
            let [r, r_dot, p, s] = self.chain.path(y, i);
            [r, r_dot, p, if omega > 0.0 { omega * s } else { s }]
        };
        (0..self.chain.sites()).map(site).collect()
    }

    /// Writes the state of `sites` into `y`, after a step of length `by` of the discrete gradient
    /// if `by` is not zero.
    fn sample(&mut self, mut sites: Sites, phi: &[f64], by: f64, y: &mut [f64]) {
        if by != 0.0 && self.discrete_gradient(&mut sites, &mut phi.to_vec(), by).is_err() {
            // The iteration failed: the sample is NaN rather than a wrong state.
            y.fill(f64::NAN);
            return;
        }
        sites.iter().enumerate().for_each(|(i, &site)| self.chain.place(site, i, y));
    }

    /// The overlap of a bond where sites are at given positions.
    fn overlap(&self, b: usize, position: impl Fn(usize) -> f64) -> f64 {
        self.chain.bond(b).rest + self.rate(b, position)
    }

    /// The rate of an overlap where sites have given velocities.
    fn rate(&self, b: usize, velocity: impl Fn(usize) -> f64) -> f64 {
        self.chain.across(b, |i| path(velocity(i)))[0][0]
    }

    /// The contact force on a site, from those of bonds.
    fn push(&self, i: usize, force: &[f64]) -> f64 {
        self.chain.push(i, |b| [path(force[b])])[0]
    }

    /// One step from `sites`, with a first guess for the forces. Returns the sweeps that it took,
    /// or the last change of a force if they do not settle.
    fn discrete_gradient(&mut self, sites: &mut Sites, phi: &mut [f64], h: f64) -> Result<u32, f64> {
        let quarter = 0.25 * h * h * self.stiffness;
        let free = |i: usize| {
            let [r, r_dot, p, p_dot] = sites[i];
            (r + h * r_dot) + (p + (h * p_dot - 2.0 * quarter * p) / (1.0 + quarter))
        };
        // Displacement of a bead by a unit force over the step.
        let reach = 0.5 * h * h * (self.m + self.mu / (1.0 + quarter));
        let [mut before, mut loose] = std::mem::take(&mut self.overlaps);
        for b in 0..phi.len() {
            before[b] = self.overlap(b, |i| sites[i][0] + sites[i][2]);
            loose[b] = self.overlap(b, free);
        }
        let sweeps = self.sweeps(phi, [&before, &loose], reach);
        self.overlaps = [before, loose];
        let sweeps = sweeps?;
        for (i, site) in sites.iter_mut().enumerate() {
            let push = self.push(i, phi);
            let [r, r_dot, p, p_dot] = *site;
            // `p` is moved by an increment: the rounding of a factor on `p` would make the energy
            // drift.
            let rise = (h * p_dot - 2.0 * quarter * p + 0.5 * h * h * self.mu * push) / (1.0 + quarter);
            *site = [
                r + h * (r_dot + 0.5 * h * self.m * push),
                r_dot + h * self.m * push,
                p + rise,
                p_dot + h * (self.mu * push - self.stiffness * (p + 0.5 * rise)),
            ];
        }
        Ok(sweeps)
    }

    /// Solves for the forces of a step, from the overlaps at its start and those at its end without
    /// contact forces. A unit force moves a bead by `reach`. Returns as
    /// [`discrete_gradient`](Self::discrete_gradient).
    fn sweeps(&self, phi: &mut [f64], [before, loose]: [&[f64]; 2], reach: f64) -> Result<u32, f64> {
        let mut last = f64::INFINITY;
        for sweep in 1..=SWEEPS {
            let (mut change, mut largest) = (0.0f64, 0.0f64);
            for b in 0..phi.len() {
                let others = |i: usize| self.chain.push(i, |c| [path(if c == b { 0.0 } else { phi[c] })]);
                let aim = loose[b] + reach * self.chain.across(b, others)[0][0];
                let new = force(&self.law, before[b], aim, reach * self.mobility[b]);
                (change, largest) = (change.max((new - phi[b]).abs()), largest.max(new));
                phi[b] = new;
            }
            // Small changes that no longer shrink are rounding errors.
            if change <= 4.0 * f64::EPSILON * largest || (last <= change && change <= ROUNDING * largest) {
                return Ok(sweep);
            }
            last = change;
        }
        Err(last)
    }
}

/// A number as a [`Path`], the type that the functions of a chain take.
fn path(value: f64) -> Path {
    [value, 0.0, 0.0, 0.0]
}

/// The force `phi(g_0, g_1)` of a bond whose overlap `g_1` is `aim - c phi`.
fn force(law: &ContactLaw<f64>, g0: f64, aim: f64, c: f64) -> f64 {
    if g0 <= 0.0 && aim <= 0.0 {
        return 0.0;
    }
    let mut g1 = aim;
    for _ in 0..NEWTON {
        let (phi, slope) = quotient(law, g0, g1);
        let change = (aim - c * phi - g1) / (1.0 + c * slope);
        g1 += change;
        if change.abs() <= f64::EPSILON * g1.abs().max(g0.abs()) {
            break;
        }
    }
    quotient(law, g0, g1).0
}

/// `phi(g_0, g_1)` and its derivative by `g_1`.
fn quotient(law: &ContactLaw<f64>, g0: f64, g1: f64) -> (f64, f64) {
    let (middle, change) = (0.5 * (g0 + g1), g1 - g0);
    if change.abs() <= NEAR * middle {
        let (f, slope) = law.force_with_slope(middle);
        let alpha = law.alpha();
        let square = (change / middle).powi(2);
        let bend = alpha * (alpha - 1.0) * square / 24.0;
        let next = bend * (alpha - 2.0) * (alpha - 3.0) * square / 80.0;
        return (f * (1.0 + (bend + next)), 0.5 * slope);
    }
    if change == 0.0 {
        return (0.0, 0.0);
    }
    let phi = (law.potential(g1) - law.potential(g0)) / change;
    (phi, (law.force(g1) - phi) / change)
}

/// The discrete-gradient scheme at work, in equal steps.
pub struct DiscreteGradient<C> {
    chain: Modal<C>,
    sites: Sites,
    /// Forces of bonds over the last step: the first guess for the next.
    phi: Vec<f64>,
    steps: Steps<f64>,
    stats: Stats,
}

impl<C: ContactChain> DiscreteGradient<C> {
    /// Runs `chain` from the state `y0`.
    ///
    /// # Errors
    /// `end < start`, times that are not finite, or no step for a span that is not empty.
    pub fn new(chain: C, y0: &[f64], span: (f64, f64), steps: u64) -> Result<Self, Error> {
        let (steps, chain) = (Steps::new(span, steps)?, Modal::new(chain));
        let (sites, phi) = (chain.load(y0), vec![0.0; chain.mobility.len()]);
        Ok(Self { chain, sites, phi, steps, stats: Stats::default() })
    }
}

impl<C: ContactChain> Stepper<f64> for DiscreteGradient<C> {
    fn dim(&self) -> usize {
        self.chain.chain.dim()
    }

    fn time(&self) -> f64 {
        self.steps.reached().value()
    }

    fn done(&self) -> bool {
        self.steps.done()
    }

    fn step(&mut self) -> Result<(), Error> {
        let h = self.steps.h.value();
        let t = self.time();
        interrupt::check(t)?;
        let sweeps = self
            .chain
            .discrete_gradient(&mut self.sites, &mut self.phi, h)
            .map_err(|residual| Error::NotSettled { t, h, residual })?;
        self.stats.force_evaluations += u64::from(sweeps);
        self.steps.taken += 1;
        self.stats.steps = self.steps.taken;
        Ok(())
    }

    /// Times inside the last step are reached by a shorter one of the same scheme.
    fn sample(&mut self, t: f64, y: &mut [f64]) {
        let inside = self.steps.inside(t);
        let by = if inside { (DoubleDouble::new(t) - self.steps.reached()).value() } else { 0.0 };
        self.chain.sample(self.sites.clone(), &self.phi, by, y);
    }

    fn stats(&self) -> Stats {
        self.stats
    }
}
