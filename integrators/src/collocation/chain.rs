//! The interface between contact collocation and a problem: [`ContactChain`], a chain with exact
//! linear paths of its sites and contacts between neighbours.
//!
//! The two sites of a bond may have different kernels. The number `S` of kernels of a bond is known
//! at compile time. It is 1 if all sites are alike and all bonds have one law; else 2, the kernel
//! of the site before the bond and that of the site after it.

use crate::{clock::DoubleDouble, law::BondLaw};

/// The response of a site to an impulse `j`: `q'` jumps by `j/mass`. A part `m j` of this velocity
/// belongs to the free motion and a part `mu j` to the oscillation, so that `q(t) = j K(t)` with
/// `K(t) = m t + mu sin(omega t)/omega`.
#[derive(Clone, Copy, Debug)]
pub struct Response {
    /// Share of the free part.
    pub m: f64,
    /// Share of the oscillating part; `m + mu = 1/mass`, and 1 where all sites are alike.
    pub mu: f64,
    /// Angular frequency of the oscillation; positive if `mu` is.
    pub omega: DoubleDouble<f64>,
}

impl Response {
    /// The response of a wall: zero.
    pub(super) const NONE: Self = Self { m: 0.0, mu: 0.0, omega: DoubleDouble { hi: 0.0, lo: 0.0 } };
}

/// The motion of a site without forces, `q(t) = r + v t + c cos(omega t) + s sin(omega t)`, as
/// `[r, v, c, s]`.
pub type Path = [f64; 4];

/// Phases below this are small: a sine is then bounded by its phase, above by 1. Chosen; held by
/// `methods springs_go_over_into_the_free_flight`.
const SMALL: f64 = 1e-3;

/// A bound of `|sin x|` for `x` up to a phase. With a spring that is weak for the time of a run,
/// `s = v/omega` is far above the displacements `s sin(omega t)` that occur.
#[inline(always)]
pub(crate) fn swing(phase: f64) -> f64 {
    if phase < SMALL { phase } else { 1.0 }
}

/// A drive of a site from outside, see [`ContactChain::signal`].
#[derive(Clone, Debug)]
pub struct Drive {
    /// Index of the site.
    pub site: usize,
    /// Whether the signal is the position of the site; else it is a force on the site.
    pub moved: bool,
    /// A bound of the absolute value of the signal, but where it is linear.
    pub size: f64,
    /// The scale of the time derivative of the signal.
    pub rate: f64,
    /// The scale of the velocities that the drive causes.
    pub speed: f64,
    /// The time from which the position of a site that is moved is linear in time; infinity if it
    /// is not, or is no motion.
    pub linear_from: f64,
    /// Start and end of each ramp and burst of the signal.
    pub varies: Vec<[f64; 2]>,
}

/// The neighbours of bond `b` among `n` bonds in a row, whose ends are neighbours of each other on
/// a ring.
#[inline(always)]
pub(crate) fn beside(b: usize, n: usize, ring: bool) -> [Option<usize>; 2] {
    let (first, last) = if ring { (Some(0), Some(n - 1)) } else { (None, None) };
    [if b > 0 { Some(b - 1) } else { last }, if b + 1 < n { Some(b + 1) } else { first }]
}

/// A chain of sites that move along exact linear paths and push each other in bonds between
/// neighbours.
///
/// The overlap of a bond is `g = rest + across(q)`, a difference of positions; bond `b` shares a
/// site with `b - 1` and `b + 1` only, the last with the first on a ring. Its force is that of its
/// [`BondLaw`].
///
/// `S` is 1 for a chain whose sites are all alike, and whose bonds are: `bond` and `response` then
/// give the same for all of them, with `m + mu = 1`, the constant 1 and no dissipation. `S` is 2
/// for other chains, where quantities of the site before a bond and of the site after it are kept
/// separate.
pub trait ContactChain<const S: usize = 1>: Send + Sync {
    /// Number of components of the state vector `y`.
    fn dim(&self) -> usize;
    /// Number of sites.
    fn sites(&self) -> usize;
    /// Number of bonds that can ever touch.
    fn bonds(&self) -> usize;
    /// Whether the last bond and the first share a site.
    fn ring(&self) -> bool;
    /// The law of a bond, with the overlap where all positions are zero. A viscoelastic one has an
    /// exponent above 1.
    fn bond(&self, bond: usize) -> BondLaw<f64>;
    /// The response of a site to an impulse.
    fn response(&self, site: usize) -> Response;
    /// The sites whose responses count for a bond: any one of its sites, or for `S = 2` the site
    /// before it and the site after it, with `None` for a wall.
    fn ends(&self, bond: usize) -> [Option<usize>; S];
    /// The difference of a quantity over a bond, as the overlap has it: `q_{n-1} - q_n`, or its two
    /// terms `[q_{n-1}, -q_n]` for `S = 2`.
    fn across(&self, bond: usize, quantity: impl Fn(usize) -> Path) -> [Path; S];
    /// The sum of the forces of bonds on a site, `f_n - f_{n+1}`: minus the transpose of
    /// [`across`](Self::across). For `S = 2` a bond has one force for each of its sites, and each
    /// site takes the one that is its own.
    fn push(&self, site: usize, force: impl Fn(usize) -> [Path; S]) -> Path;
    /// The path of a site, from a state at `t = 0`.
    fn path(&self, y: &[f64], site: usize) -> Path;
    /// Writes a site into a state, from the free part of its position, its rate, the oscillating
    /// part, and its rate: `[r, r', p, p']`.
    fn place(&self, parts: [f64; 4], site: usize, y: &mut [f64]);
    /// The rounding error of an overlap whose terms are at most `largest`: overlaps up to it count
    /// as zero.
    fn dead_band(&self, largest: f64) -> f64;
    /// Damping `[drag, slip]` of a site, for `S = 2`: drag, a force over the velocity of the site;
    /// and the rate at which a dashpot damps the oscillating part, `p'' = -omega^2 p - slip p'`.
    fn damping(&self, _site: usize) -> [f64; 2] {
        [0.0; 2]
    }
    /// The drives, one for each driven site, for `S = 2`. A site that is moved has the response
    /// zero and the [`path`](Self::path) zero.
    fn drives(&self) -> Vec<Drive> {
        Vec::new()
    }
    /// The signal of a drive at time `t`, with its first and second derivative: the position of the
    /// site, or a force.
    fn signal(&self, _site: usize, _t: f64) -> [f64; 3] {
        [0.0; 3]
    }
    /// Times at which signals are not smooth.
    fn breaks(&self) -> Vec<f64> {
        Vec::new()
    }
    /// The ledger of a state at a time: energies dissipated by drag, by dashpots and by contacts,
    /// and the work of drives. The work on sites that are moved is without their kinetic energy.
    fn ledger(&self, _y: &[f64], _t: f64) -> Path {
        [0.0; 4]
    }
    /// Writes the ledger, and the sites that are moved, into a state.
    fn complete(&self, _ledger: Path, _t: f64, _y: &mut [f64]) {}
}
