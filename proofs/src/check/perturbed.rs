//! Chapter: the linearised equations of a dark breather or of a wave, with further unknowns
//! ("Multipliers" in `README.md`).
//!
//! The functions are the cosines of all sites, then their sines. For -1 both have equations of
//! their own. Those of a wave are complex: real parts come first, then imaginary parts.

use super::{
    Moments, System,
    newton::{self, Equations, Matrix, Place, kronecker},
};
use crate::{
    certificate::{Bloch, Certificate},
    exact::Exact,
    interval::Interval,
    untrusted::choices,
};
use std::rc::Rc;

/// `K'` over the columns of `1 - A M` that are computed beyond `K`, and over the harmonics of the
/// approximate solution.
pub(super) const SHARE: usize = 4;

/// The coefficient of a place.
pub(crate) fn own(p: &Matrix, (n, k): Place) -> Interval {
    p[n].get(k).copied().unwrap_or(Interval::ZERO)
}

/// The equations of the perturbations.
pub struct Perturbations {
    /// Those of the orbit, or of its perturbations.
    pub system: Rc<System>,
    /// The exponent.
    pub alpha: Exact,
    /// `K` and `K'`.
    pub sizes: [usize; 2],
    /// `sigma`.
    pub odd: usize,
    /// Whether all functions are sines.
    pub sine: bool,
    /// Functions of a site: one, cosine and sine, or real and imaginary parts of these.
    pub parts: usize,
    /// The coefficients that are given: that is 1, and of waves its imaginary part is 0.
    pub pinned: Vec<Place>,
}

impl System {
    /// That of perturbations, which the reflection of a breather maps to their negative.
    pub fn perturbed(&self) -> Rc<Self> {
        Rc::new(Self { parity: if self.is_wave() { 1.0 } else { -1.0 }, ..self.clone() })
    }
}

impl Perturbations {
    /// Those of a wave for a piece; of a breather with the multiplier -1, of sines or not, or with
    /// one that grows.
    pub fn new(it: &Certificate, system: &Rc<System>, doubled: Option<bool>, piece: Option<&Bloch>) -> Rc<Self> {
        let (odd, sine) = (usize::from(doubled.is_some()), doubled == Some(true));
        let parts = if system.is_wave() { 4 } else { 2 - odd };
        let (sizes, least) = choices::perturbations(it, system, piece);
        // For -1 the same one for all pieces, between which g is to be continuous.
        let pinned = match piece {
            Some(_) => vec![(0, 1), (2, 1)],
            None => vec![if odd == 1 { (0, 0) } else { least }],
        };
        Rc::new(Self { system: system.clone(), alpha: it.model.alpha, sizes, odd, sine, parts, pinned })
    }

    fn is_sine(&self, n: usize) -> bool {
        self.sine || n / self.system.a.len() % 2 == 1
    }

    pub(super) fn known(&self, n: usize) -> &Moments {
        &self.system.known[n % self.system.a.len()]
    }

    pub(super) fn tails(&self, last: usize) -> Vec<Interval> {
        (0..self.functions()).map(|n| self.known(n).stiffness_tail(last)).collect()
    }

    /// The harmonics of an approximate solution, and the equations whose defects are computed.
    pub fn counts(&self) -> [usize; 2] {
        let harmonics = self.sizes[1] / SHARE;
        [harmonics, self.sizes[1] - harmonics - 1]
    }

    /// A series as long as approximate solutions are.
    pub fn series(&self, p: &Matrix) -> Matrix {
        let row = |n: usize| (0..=self.counts()[0]).map(|k| own(p, (n, k))).collect();
        (0..self.functions()).map(row).collect()
    }

    /// `D p` up to harmonic `last`.
    pub fn forces(&self, p: &Matrix, last: usize) -> Matrix {
        let mut forces = vec![vec![Interval::ZERO; last + 1]; p.len()];
        for (m, k) in self.places(0..p.len(), 0..last + 1) {
            forces[m][k] = p[m].iter().enumerate().map(|(j, p)| self.entry(m, k, j) * *p).sum();
        }
        forces
    }

    /// The column of the unknown `g`.
    pub fn column(&self, which: usize, place: Place) -> Interval {
        -kronecker(place == self.pinned[which])
    }

    /// The coefficients that are given, less what they are to be.
    pub fn given(&self, p: &Matrix) -> Vec<Interval> {
        self.pinned.iter().zip(0..).map(|(place, which)| own(p, *place) - kronecker(which == 0)).collect()
    }
}

impl Equations for Perturbations {
    fn functions(&self) -> usize {
        self.parts * self.system.a.len()
    }

    fn has(&self, (n, k): Place) -> bool {
        self.system.has((n % self.system.a.len(), k)) && (k + self.odd > 0 || !self.is_sine(n))
    }

    fn entry(&self, m: usize, k: usize, j: usize) -> Interval {
        newton::entry(&self.known(m).stiffness, [k, j], (self.odd, self.is_sine(m)))
    }

    /// Factors are those of `b` between cosines and sines, imaginary between real and imaginary
    /// parts; with a minus in the rows of cosines, and of real parts.
    fn coupled(&self, (n, k): Place) -> Vec<(usize, usize, f64)> {
        let sites = self.system.a.len();
        let of_site = |(m, _, e): (usize, usize, f64)| {
            let of_part = move |part: usize| {
                let i = part ^ (n / sites);
                let minus = (i & part).count_ones() % 2 == 1;
                (m + part * sites, i, if minus { -e } else { e })
            };
            (0..self.parts).map(of_part)
        };
        self.system.differences(n % sites, k).into_iter().flat_map(of_site).collect()
    }
}
