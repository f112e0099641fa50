//! Enclosures of the Fourier coefficients of contact forces ("Forces" in `README.md`).

use super::{
    newton::{dot, largest},
    of,
};
use crate::{exact::Exact, interval::Interval};
use std::sync::OnceLock;

/// Nodes of the quadrature of a piece.
pub const NODES: usize = 28;
/// Pieces below this share of the half-period are bounded and not integrated.
pub const NARROWEST: f64 = 1.0 / (1_u64 << 34) as f64;
/// The same for pieces of a branch, whose balls are wider by far.
pub const NARROWEST_ALONG: f64 = 1.0 / (1_u64 << 16) as f64;
/// Pieces after which the subdivision is given up.
const MOST_PIECES: usize = 20_000;

/// What is known of `N = (-X)_+^alpha = sum n_k cos k theta` and of its derivative by the overlap,
/// `D = alpha (-X)_+^{alpha-1} = sum d_k cos k theta`.
#[derive(Clone, Debug)]
pub struct Moments {
    /// `n_k`.
    pub force: Vec<Interval>,
    /// `d_k`.
    pub stiffness: Vec<Interval>,
    /// The means of `N^2`, `D^2` and `N'^2`.
    pub squares: [Interval; 3],
    /// Shares of the half-period, and `-X` on them.
    pub pieces: Vec<(Interval, Interval)>,
}

impl Moments {
    /// A bound of `(sum_{k > last} f_k^2)^{1/2}` of a series, by Parseval's equation.
    fn tail(series: &[Interval], square: Interval, last: usize) -> Interval {
        let known: Interval = series[1..=last].iter().map(|f| f.square()).sum();
        (of(2) * (square - series[0].square()) - known).positive_part().sqrt()
    }

    /// That of `D`.
    pub fn stiffness_tail(&self, last: usize) -> Interval {
        Self::tail(&self.stiffness, self.squares[1], last)
    }

    /// That of `N`, also by Parseval's equation for `N'`, which loses fewer digits.
    pub fn force_tail(&self, last: usize) -> Interval {
        let slopes: Vec<Interval> = (0..=last).map(|k| of(k) * self.force[k]).collect();
        Self::tail(&self.force, self.squares[0], last).min(Self::tail(&slopes, self.squares[2], last) / of(last + 1))
    }

    /// An upper bound of the overlap, at least 0.
    pub fn overlap(&self) -> Interval {
        Interval::exact(largest(self.pieces.iter().map(|(_, overlap)| *overlap)).hi())
    }

    /// A bound of `sqrt 2 |D h|_{L2}` over `sqrt 2 |h|_{L2}` and over `sup |h|`: `min(sup D, sqrt 2
    /// |D|_{L2})`.
    pub(super) fn steepest(&self, alpha: Exact) -> Interval {
        stiffness(self.overlap(), alpha).min((of(2) * self.squares[1]).positive_part().sqrt())
    }

    /// An upper bound of `sqrt 2 |N(X + h) - N(X)|_{L2}` for `|h|` and `sqrt 2 |h|_{L2}` up to `r`.
    pub fn force_change(&self, alpha: Exact, r: Interval) -> Interval {
        stiffness(self.overlap() + r, alpha) * r
    }

    /// An upper bound of `sqrt 2` times the root of the mean square of `sup |D(X + h) - D(X)|` over
    /// `|h| <= r`. For `alpha <= 2`, as a function of the overlap, `D` is concave where it is not
    /// 0: it changes most at the smallest overlap, and by its value for the overlap `r` at most.
    /// For `alpha > 2` it is convex, and changes most at the largest overlap.
    pub fn change(&self, alpha: Exact, r: Interval) -> Interval {
        let law = |overlap: Interval| stiffness(overlap, alpha);
        let convex = alpha.less_one().is_some_and(|stiff| stiff.num() > stiff.den());
        let squares = self.pieces.iter().map(|(share, overlap)| {
            let [least, most] = [overlap.lo(), overlap.hi()].map(Interval::exact);
            let change = match () {
                () if convex => law(most + r) - law(most),
                () if (least - r).is_positive() => law(least) - law(least - r),
                () => law(r.min(most + r)),
            };
            *share * change.square()
        });
        (of(2) * squares.sum()).positive_part().sqrt()
    }
}

/// The moments of `X = sum a_k cos k theta`, with coefficients up to `count`, by pieces that are
/// free of contact, integrated, or narrower than this share of the half-period; `None` if the
/// subdivision does not end.
pub fn moments(a: &[Interval], alpha: Exact, count: usize, narrowest: f64) -> Option<Moments> {
    // Any number of pieces will do.
    let cut = a.len().saturating_sub(1).max(count).next_power_of_two().div_ceil(4);
    let mut sums = Sums::new(a, alpha, count, narrowest);
    let mut pieces: Vec<[f64; 2]> = (0..cut).map(|i| [i, i + 1].map(|i| i as f64 / cut as f64)).collect();
    for _ in 0..MOST_PIECES {
        let Some([from, to]) = pieces.pop() else { return Some(sums.done()) };
        if !sums.add(from, to) {
            // Dyadic fractions: the middle is exact.
            let middle = 0.5 * (from + to);
            pieces.extend([[from, middle], [middle, to]]);
        }
    }
    None
}

/// Integrals over the pieces so far.
pub struct Sums<'a> {
    a: &'a [Interval],
    /// `-k^2 a_k`, the coefficients of `X''`.
    bent: Vec<Interval>,
    alpha: Exact,
    narrowest: f64,
    /// Those of `N` and of `D` times `cos k theta`, and of `N^2`, `D^2` and `N D X''`.
    series: [Vec<Interval>; 5],
    pieces: Vec<(Interval, Interval)>,
}

impl<'a> Sums<'a> {
    /// Without pieces.
    pub fn new(a: &'a [Interval], alpha: Exact, count: usize, narrowest: f64) -> Self {
        let bent = a.iter().enumerate().map(|(k, a)| -of(k).square() * *a).collect();
        let series = [count + 1, count + 1, 1, 1, 1].map(|size| vec![Interval::ZERO; size]);
        Self { a, bent, alpha, narrowest, series, pieces: Vec::new() }
    }

    /// Adds the integrals over a piece, in shares of the half-period; `false` if it must be cut.
    fn add(&mut self, from: f64, to: f64) -> bool {
        let [from, to] = [from, to].map(Interval::exact);
        let [centre, half] = [from + to, to - from].map(|sum| Interval::PI * sum / of(2));
        let [middle, on_piece, on_ellipse, growth] = self.near(centre, half);
        let on_piece = -middle + on_piece.ball();
        let overlap = on_piece.positive_part();
        if (to - from).hi() < self.narrowest && overlap.hi() > 0.0 {
            self.add_errors(overlap, of(2) * half, Interval::ONE);
        } else if overlap.hi() > 0.0 || overlap.is_nan() {
            if !(-middle - on_ellipse).is_positive() {
                return false;
            }
            self.integrated(centre, half);
            // 8 4^{-n}/(1 - 1/4)
            let share = half * Interval::exact(32.0 / (1_u64 << (2 * NODES)) as f64) / of(3);
            self.add_errors(middle.abs() + on_ellipse, share, growth);
        }
        self.pieces.push((to - from, on_piece));
        true
    }

    /// The mean of `X` at both ends of a piece; bounds of the distance of `X` from it on the piece,
    /// and in the ellipse of Bernstein, by the line through both ends; and `e^h` for the height `h`
    /// of the ellipse.
    pub fn near(&self, centre: Interval, half: Interval) -> [Interval; 4] {
        let [from, to] = [-half, half].map(|by| dot(self.a, &cosines(centre + by, self.a.len())));
        let growth = Interval::exact((half * of(15) / of(8)).hi()).exp();
        let apart = |long: Interval, growth: Interval| {
            long * (to - from).abs() / of(2) + most_bent(&self.bent, growth) * (half * long).square() / of(2)
        };
        [(from + to) / of(2), apart(Interval::ONE, Interval::ONE), apart(of(17) / of(8), growth), growth]
    }

    fn integrated(&mut self, centre: Interval, half: Interval) {
        static QUADRATURE: OnceLock<Vec<[Interval; 2]>> = OnceLock::new();
        let harmonics = self.a.len().max(self.series[0].len());
        // Sums of their own for each piece: fewer rounding errors than in those over all nodes.
        let mut own = self.series.each_ref().map(|series| vec![Interval::ZERO; series.len()]);
        for [node, weight] in QUADRATURE.get_or_init(fejer) {
            let cosines = cosines(centre + half * *node, harmonics);
            let all = integrands(-dot(self.a, &cosines), self.alpha, dot(&self.bent, &cosines));
            for (sums, value) in own.iter_mut().zip(all) {
                let value = *weight * value;
                sums.iter_mut().zip(&cosines).for_each(|(sum, cosine)| *sum = *sum + value * *cosine);
            }
        }
        self.series.iter_mut().flatten().zip(own.iter().flatten()).for_each(|(sum, own)| *sum = *sum + half * *own);
    }

    /// Adds errors to the integrals: the bounds of their integrands times `share`, for an overlap
    /// of this modulus and cosines of harmonic `k` up to `growth^k`.
    fn add_errors(&mut self, modulus: Interval, share: Interval, growth: Interval) {
        for (series, most) in self.series.iter_mut().zip(integrands(modulus, self.alpha, most_bent(&self.bent, growth)))
        {
            let mut error = share * most;
            for sum in series {
                (*sum, error) = (*sum + error.ball(), error * growth);
            }
        }
    }

    /// Coefficients and means from the integrals over half a period.
    fn done(self) -> Moments {
        let mean = |(k, sum): (usize, Interval)| of(if k == 0 { 1 } else { 2 }) * sum / Interval::PI;
        let means = self.series.map(|sums| sums.into_iter().enumerate().map(mean).collect::<Vec<_>>());
        let ([force, stiffness, squares @ ..], alpha) = (means, self.alpha.enclosed());
        let [force_square, stiffness_square, bent] = squares.map(|one| one[0]);
        let squares = [force_square, stiffness_square, alpha / (of(2) * alpha - Interval::ONE) * bent];
        Moments { force, stiffness, squares, pieces: self.pieces }
    }
}

/// `N`, `D`, `N^2`, `D^2` and `N D X''` for an overlap and this `X''`.
fn integrands(overlap: Interval, alpha: Exact, bent: Interval) -> [Interval; 5] {
    let (force, stiffness) = (overlap.positive_part().pow(alpha), stiffness(overlap, alpha));
    [force, stiffness, force.square(), stiffness.square(), force * stiffness * bent]
}

/// `D = alpha g_+^{alpha - 1}` for an overlap `g`.
fn stiffness(overlap: Interval, alpha: Exact) -> Interval {
    alpha.less_one().map_or(Interval::exact(f64::NAN), |power| alpha.enclosed() * overlap.positive_part().pow(power))
}

/// A bound of `|X''|` by its coefficients, where harmonic `k` is at most `growth^k`.
fn most_bent(bent: &[Interval], growth: Interval) -> Interval {
    bent.iter().rev().fold(Interval::ZERO, |sum, bent| sum * growth + bent.abs())
}

/// `cos k phase` for `k < count`, by `cos (i + j) t = 2 cos i t cos j t - cos (j - i) t`, `j - i` 0
/// or 1.
fn cosines(phase: Interval, count: usize) -> Vec<Interval> {
    let mut all = vec![Interval::ONE, phase.sin_cos()[1]];
    for k in 2..count {
        let product = all[k / 2] * all[k - k / 2];
        all.push(product + product - all[k % 2]);
    }
    all.truncate(count);
    all
}

/// Nodes `cos t` and weights `(2/n) (1 - sum_k 2 cos 2kt/(4k^2 - 1))`, `1 <= k < n/2`, of Fejér's
/// first quadrature on `[-1, 1]`: that of the polynomial through the nodes. The weights are
/// positive. (L. Fejér 1933.)
pub fn fejer() -> Vec<[Interval; 2]> {
    let of_node = |j: usize| {
        let angle = Interval::PI * of(2 * j + 1) / of(2 * NODES);
        let cos = |k: usize| (of(k) * angle).sin_cos()[1];
        let sum: Interval = (1..NODES.div_ceil(2)).map(|k| of(2) * cos(2 * k) / of(4 * k * k - 1)).sum();
        [cos(1), of(2) / of(NODES) * (Interval::ONE - sum)]
    };
    (0..NODES).map(of_node).collect()
}
