//! What contact collocation may ask of a problem: exact linear paths, and a contact law on a
//! nearest-neighbour chain.

use crate::{clock::Twofold, law::ContactLaw};

/// How a site answers an impulse `j`: `q'` jumps by `j`, of which the share `m` moves on freely and
/// the share `mu` oscillates, so that `q(t) = j K(t)`, `K(t) = m t + mu sin(omega t)/omega`.
#[derive(Clone, Copy, Debug)]
pub struct Response {
    /// Share of the free part.
    pub m: f64,
    /// Share of the oscillating part; `m + mu = 1`.
    pub mu: f64,
    /// Frequency; positive if `mu` is.
    pub omega: Twofold<f64>,
}

/// What leaves a site alone: `q(t) = r + v t + c cos(omega t) + s sin(omega t)`, as `[r, v, c, s]`.
pub type Path = [f64; 4];

/// What the solver of windows knows of a chain, whatever its type.
#[derive(Clone, Debug)]
pub(crate) struct Links {
    pub(crate) bonds: usize,
    pub(crate) ring: bool,
    pub(crate) law: ContactLaw<f64>,
    pub(crate) response: Response,
    /// Whether bonds touch where all sites rest at the origin.
    pub(crate) precompressed: bool,
    /// How strongly the force of each bond opens it: 2 between two sites, 1 at a wall.
    pub(crate) recoil: Vec<f64>,
}

impl Links {
    pub(crate) fn of<C: ContactChain>(chain: &C) -> Self {
        let recoil = |b| -chain.across(b, |i| chain.push(i, |c| [f64::from(u8::from(c == b)); 4]))[0];
        Self {
            recoil: (0..chain.bonds()).map(recoil).collect(),
            bonds: chain.bonds(),
            ring: chain.ring(),
            law: chain.law(),
            response: chain.response(),
            precompressed: chain.rest() > 0.0,
        }
    }
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
/// site with `b - 1` and `b + 1` only, the last with the first on a ring.
pub trait ContactChain: Send + Sync {
    /// Number of components of the state as others see it.
    fn dim(&self) -> usize;
    /// Number of sites.
    fn sites(&self) -> usize;
    /// Number of bonds that can ever touch.
    fn bonds(&self) -> usize;
    /// Whether the last bond and the first share a site.
    fn ring(&self) -> bool;
    /// The law of every bond.
    fn law(&self) -> ContactLaw<f64>;
    /// How a site answers an impulse.
    fn response(&self) -> Response;
    /// The overlap of every bond where all positions are zero.
    fn rest(&self) -> f64;
    /// The part of the overlap of a bond that a quantity of its sites makes: `q_{n-1} - q_n`.
    fn across(&self, bond: usize, quantity: impl Fn(usize) -> Path) -> Path;
    /// What forces in bonds do to a site, the transpose of [`across`](Self::across) but for its
    /// sign: `f_n - f_{n+1}`.
    fn push(&self, site: usize, force: impl Fn(usize) -> Path) -> Path;
    /// The path of a site at `t = 0`, from a state.
    fn path(&self, y: &[f64], site: usize) -> Path;
    /// Writes a site into a state: `[r, r', p, p']`, the free and the oscillating part of its
    /// position and their rates.
    fn place(&self, parts: [f64; 4], site: usize, y: &mut [f64]);
    /// Overlaps up to this are rounding of an overlap whose terms are up to `largest`.
    fn dead_band(&self, largest: f64) -> f64;
}
