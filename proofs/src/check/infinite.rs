//! Chapter: what the proof of a breather of the infinite chain has beside that of a ring: an exact
//! background, an `A` of infinitely many rows, and weights that decay ("The infinite chain" in
//! `README.md`).

use super::{
    Moments, Proof, Refused, System, check_until,
    newton::{Block, kronecker, largest},
    of,
};
use crate::{
    certificate::{Center, Certificate, Orbit},
    exact::Exact,
    interval::Interval,
};

impl Center {
    /// Whether in a strain shifted by half a period a site harmonic `k` has the opposite sign.
    /// Sites are counted from the centre.
    pub(crate) fn turns(self, n: usize, k: usize) -> bool {
        (n + usize::from(self == Self::Bond)) * k % 2 == 1
    }
}

/// The rules of its lines, that it is no piece of a branch, and those of `decay` and `background`.
pub(crate) fn rules(it: &Certificate) -> [bool; 2] {
    let Orbit::Infinite { decay, background, .. } = &it.orbit else { return [true; 2] };
    [it.to.is_none(), decay.num() > 0 && background.len() > it.harmonics()]
}

/// The number of sites from which all constants follow.
pub(crate) fn sites(first: usize, band: usize) -> usize {
    band.saturating_mul(2).saturating_add(first + 4)
}

/// The far part of a breather of the infinite chain.
pub struct Far {
    /// The standing wave.
    pub background: Proof,
    /// `M`.
    first: usize,
    /// `J`.
    band: usize,
    /// `eta`.
    decay: Interval,
}

impl Far {
    /// That of a certificate, if it is of the infinite chain, with the proof of its background.
    pub fn new(certificate: &Certificate, stopped: &dyn Fn() -> bool) -> Result<Option<Self>, Refused> {
        let Orbit::Infinite { decay, band, background, .. } = &certificate.orbit else { return Ok(None) };
        let (orbit, a) = (Orbit::Wave { q_over_pi: Exact::ONE }, vec![background.clone()]);
        let enclosed = certificate.enclosed.max(background.len() - 1);
        let wave = Certificate { orbit, enclosed, a, ..certificate.clone() };
        let background = check_until(&wave, stopped).map_err(|why| match why {
            Refused::Stopped => why,
            _ => Refused::Background(Box::new(why)),
        })?;
        Ok(Some(Self { background, first: certificate.a.len(), band: *band, decay: decay.enclosed() }))
    }

    /// Takes the strains of the background from its cosine sum to the ball of its proof, for the
    /// moments and tails of as many sites.
    pub fn widen(&self, known: &mut Vec<Moments>, tails: [&mut Vec<Interval>; 2], alpha: Exact, sites: usize) {
        let r = Interval::exact(self.background.radius);
        let Some(own) = known.pop() else { return };
        let changes = [own.force_change(alpha, r), own.change(alpha, r)];
        known.resize(sites, own.within(changes, r));
        for (tails, change) in tails.into_iter().zip(changes) {
            let tail = tails.pop().map_or(Interval::exact(f64::NAN), |tail| tail + change);
            tails.resize(sites, tail);
        }
    }

    /// The first row that is copied.
    pub fn last_row(&self) -> usize {
        self.first + self.band + 1
    }

    /// Cuts the rows of `A` off at the distance `J`, and copies the last one.
    pub fn copy_rows(&self, Block { all, inverse, .. }: &mut Block) {
        for (i, &(n, ..)) in all.iter().enumerate() {
            // This site and those before it have all harmonics, if it is a copy.
            let width = all.iter().filter(|place| place.0 == n).count();
            for (j, &(m, ..)) in all.iter().enumerate() {
                if n.abs_diff(m) > self.band {
                    inverse[i][j] = Interval::ZERO;
                } else if n > self.last_row() {
                    inverse[i][j] = inverse[i - width][j - width];
                }
            }
        }
    }

    /// Shows that `A` has no kernel, by `|1 - B A| < 1` on bounded sequences, for a matrix `B` of
    /// any numbers that couple neighbours.
    pub fn has_no_kernel(&self, Block { all, inverse: a, .. }: &Block, b: &[Vec<f64>]) -> Result<(), Refused> {
        let of_row = |i: usize| -> Interval {
            let near: Vec<usize> = (0..a.len()).filter(|l| all[*l].0.abs_diff(all[i].0) <= 1).collect();
            let entry =
                |j: usize| near.iter().fold(kronecker(i == j), |sum, l| sum - Interval::exact(b[i][*l]) * a[*l][j]);
            (0..a.len()).map(|j| entry(j).abs()).sum()
        };
        let most = largest((0..a.len()).filter(|i| all[*i].0 <= self.last_row() + 1).map(of_row));
        if (Interval::ONE - most).is_positive() { Ok(()) } else { Err(Refused::Kernel(most.hi())) }
    }

    /// `W_n`: 1 up to the first site of the background, `e^{-eta (n - M)}` beyond.
    pub fn weights(&self, sites: usize) -> Vec<Interval> {
        let beyond = |n: usize| (-self.decay * of(n.saturating_sub(self.first))).exp();
        (0..sites).map(beyond).collect()
    }

    /// `eta`, and `C` with `|x_n - X| <= C e^{-eta n}`.
    pub fn decay(&self, system: &System, weights: &[Interval], radius: Interval) -> [f64; 2] {
        let of_site = |(n, w): (usize, &Interval)| {
            let own = system.a[n].iter().copied().chain(std::iter::repeat(Interval::ZERO));
            let apart: Interval = system.a[self.first].iter().zip(own).map(|(a, b)| (*a - b).abs()).sum();
            let own = if n < self.first { apart + Interval::exact(self.background.radius) } else { Interval::ZERO };
            // Sites are counted from 0 or 1.
            (own + *w * radius) * (self.decay * of(n + usize::from(system.center == Center::Bond))).exp()
        };
        let most = largest(weights.iter().enumerate().take(self.first + 1).map(of_site));
        [self.decay.lo(), most.hi()]
    }
}

impl Moments {
    /// Those of all strains `X + h`, `h = sum_{k >= 1} h_k cos k theta` with `sum |h_k| <= r`, by
    /// bounds of the changes of `N` and of `D`, `sqrt 2` times the roots of their mean squares.
    fn within(&self, changes: [Interval; 2], r: Interval) -> Self {
        let wider = |series: &[Interval], i: usize| series.iter().map(|one| *one + changes[i].ball()).collect();
        let unknown = Interval::new(0.0, f64::INFINITY);
        let stiffness_square = (self.squares[1].positive_part().sqrt() + changes[1] / of(2).sqrt()).square();
        Self {
            force: wider(&self.force, 0),
            stiffness: wider(&self.stiffness, 1),
            squares: [unknown, stiffness_square, unknown],
            pieces: self.pieces.iter().map(|(share, overlap)| (*share, *overlap + r.ball())).collect(),
        }
    }
}
