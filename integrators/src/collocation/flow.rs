//! The motion of a damped site between contacts, as Taylor series of `exp(A t)`.
//!
//! | symbol | meaning |
//! |---|---|
//! | `y = [r, v, c, s]` | a site at a window's start: position `r + c`, velocity `v + omega s` |
//! | `A` | generator: `y' = A y + b f` under a force `f` |
//! | `b = [0, m, 0, mu/omega]` | what a unit impulse adds to `y` |
//! | `e = [1, 0, 1, 0]` | position: `q = e y` |
//! | `theta = rate t` | scaled time; `rate` bounds the norm of `A` |
//!
//! ```text
//! r'' = -drag m q',   c'' = -omega^2 c - drag mu q' - slip c',   q' = r' + c'
//! q(t) = e exp(A t) y = r + v (t + lag(t)) + c cos(t) + s sin(t)
//! K(t - s) = e exp(A t) exp(-A s) b
//! ```
//!
//! `lag`, `cos` and `sin` are zero, `cos(omega t)` and `sin(omega t)` without damping. The series
//! need no case distinction between weak, critical and strong damping, near which closed forms lose
//! digits by cancellation. Windows are short enough for the series, see [`Flow::longest`].

use super::chain::{Path, Response};
use crate::{
    real::{MOST_LANES, Vector},
    with_narrow,
};

/// The largest `theta` of a window. Chosen: 25 terms are then exact to rounding, and a rounding
/// grows by `e^2` at most.
const LONGEST: f64 = 2.0;
/// Number of terms of a series; for `theta = 2` the terms left out are below 1e-18.
const TERMS: usize = 26;
/// Terms of the series below this are left out.
const ROUNDING: f64 = 1e-17;
/// Largest number of times at which series are summed together, in whole pairs of registers.
const WIDE: usize = 2 * MOST_LANES;

/// Series in `theta` of `N` functions, term by term, since they are summed together.
type Series<const N: usize> = [[f64; N]; TERMS];
/// Series of no functions.
const NO_SERIES: &Series<0> = &[[]; TERMS];

/// The motion of one site with its drag and dashpot, without its contacts.
#[derive(Clone, Debug)]
pub struct Flow {
    /// `A`.
    a: [Path; 4],
    response: Response,
    /// Drag, a force over a velocity.
    drag: f64,
    /// Rate at which the dashpot damps the oscillating part: `c'' = -omega^2 c - slip c'`.
    slip: f64,
    /// `theta/t`.
    rate: f64,
    /// Series of `lag`, `cos` and `sin`.
    position: Series<3>,
    /// Series of the factors of `v`, `c` and `s` in the velocity, and in that of the oscillating
    /// part.
    velocity: Series<3>,
    swing: Series<3>,
    /// Series of `exp(-A t) b`.
    answer: Series<4>,
    /// Series of the functions of [`Ahead`], the last two without their powers of `t`; the end is
    /// zero, and makes whole registers.
    ahead: Series<8>,
    /// `K'`, `K''` and `K'''` at zero.
    slopes: [f64; 3],
    /// For `b` and `A b`, the coefficients of `1` and `h` in
    /// [`curvature_bound`](Self::curvature_bound).
    curvature_bounds: [[f64; 2]; 2],
}

/// What a prediction needs of a site at a time `t`.
#[derive(Clone, Copy, Debug)]
pub struct Ahead {
    /// `lag`, `cos` and `sin`.
    pub(crate) position: [f64; 3],
    /// `K(t)`, and `int_0^t K(t - s) s^k/k! ds` for `k = 0, 1`.
    pub ramps: [f64; 3],
}

fn apply(a: &[Path; 4], y: &Path) -> Path {
    std::array::from_fn(|i| (a[i][0] * y[0] + a[i][1] * y[1]) + (a[i][2] * y[2] + a[i][3] * y[3]))
}

/// `A^k y/k!` for all `k`.
fn powers(a: &[Path; 4], mut y: Path) -> Series<4> {
    let mut out = [[0.0; 4]; TERMS];
    for (k, term) in out.iter_mut().enumerate() {
        *term = y;
        y = apply(a, &y).map(|x| x / (k + 1) as f64);
    }
    out
}

/// For each `k`, the largest `theta` for which `k + 1` terms of the series of `exp(theta)` are
/// enough; the terms left out are rounding.
const REACH: [f64; TERMS - 1] = {
    let mut reach = [0.0; TERMS - 1];
    let mut k = 1;
    while k < TERMS - 1 {
        let (mut low, mut high) = (0.0, 2.0 * LONGEST);
        loop {
            let theta = 0.5 * (low + high);
            if theta == low || theta == high {
                break;
            }
            let (mut term, mut i) = (1.0, 1);
            while i <= k {
                term *= theta / i as f64;
                i += 1;
            }
            if term > ROUNDING {
                high = theta;
            } else {
                low = theta;
            }
        }
        reach[k] = low;
        k += 1;
    }
    reach
};

/// `1/k` for `k` from 1 on.
const PER: [f64; TERMS] = {
    let mut per = [1.0; TERMS];
    let mut k = 1;
    while k < TERMS {
        per[k] = 1.0 / (k + 1) as f64;
        k += 1;
    }
    per
};

/// The number of terms that the series of `exp(theta)` needs. To compare `theta` with all of
/// [`REACH`] costs less than terms that are not needed.
#[inline(always)]
fn terms(theta: f64) -> usize {
    REACH.iter().map(|&reach| usize::from(theta > reach)).sum::<usize>() + 1
}

/// Sums series at several times together, by Horner's rule: `N` functions, and `P` more. It is
/// written with vector registers, since compilers would keep this number of sums in memory.
struct Horner<'a, const N: usize, const P: usize> {
    series: (&'a [[f64; N]], &'a [[f64; P]]),
    theta: &'a [f64; WIDE],
    times: usize,
    sums: (&'a mut [[f64; WIDE]; N], &'a mut [[f64; WIDE]; P]),
}

impl<const N: usize, const P: usize> Horner<'_, N, P> {
    fn run(mut self) {
        with_narrow!(V => {
            const { assert!(WIDE.is_multiple_of(2 * V::LANES)) };
            if self.times <= V::LANES {
                return self.sum::<V, 1>(0);
            }
            for at in (0..self.times).step_by(2 * V::LANES) {
                self.sum::<V, 2>(at);
            }
        });
    }

    /// For the times in `R` registers from `at` on.
    #[inline(always)]
    fn sum<V: Vector<f64>, const R: usize>(&mut self, at: usize) {
        // SAFETY: the registers are within `WIDE` numbers.
        let theta: [V; R] = std::array::from_fn(|r| unsafe { V::load(self.theta.as_ptr().add(at + r * V::LANES)) });
        let (mut sums, mut more) = ([[V::all(0.0); R]; N], [[V::all(0.0); R]; P]);
        for (term, next) in self.series.0.iter().zip(self.series.1).rev() {
            for r in 0..R {
                for i in 0..N {
                    sums[i][r] = theta[r].fused(sums[i][r], V::all(term[i]));
                }
                for i in 0..P {
                    more[i][r] = theta[r].fused(more[i][r], V::all(next[i]));
                }
            }
        }
        let all = sums.iter().zip(self.sums.0.iter_mut()).chain(more.iter().zip(self.sums.1.iter_mut()));
        for (sums, out) in all {
            for r in 0..R {
                // SAFETY: as above.
                unsafe { sums[r].store(out.as_mut_ptr().add(at + r * V::LANES)) };
            }
        }
    }
}

impl Flow {
    /// The flow of a site with drag, a force over the velocity, and a dashpot that damps the
    /// velocity of the oscillating part at the rate `slip`.
    pub fn new(response: Response, [drag, slip]: [f64; 2]) -> Self {
        let Response { m, mu, omega } = response;
        let omega = if mu == 0.0 { 0.0 } else { omega.value() };
        let per = if mu == 0.0 { 0.0 } else { 1.0 / omega };
        let a = [
            [0.0, 1.0, 0.0, 0.0],
            [0.0, -drag * m, 0.0, -drag * m * omega],
            [0.0, 0.0, 0.0, omega],
            [0.0, -drag * mu * per, -omega, -(drag * mu + slip)],
        ];
        let b = [0.0, m, 0.0, mu * per];
        // Without oscillation and damping any positive rate will do.
        let rate = (omega + 2.0 * drag * (m + mu) + slip).max(1e-100);
        let scaled = a.map(|row| row.map(|x| x / rate));
        let transposed: [Path; 4] = std::array::from_fn(|i| std::array::from_fn(|j| scaled[j][i]));
        let of_path = |of: Path| powers(&transposed, of).map(|[_, v, c, s]| [v, c, s]);
        let mut position = of_path([1.0, 0.0, 1.0, 0.0]);
        position[1][0] = 0.0;
        let kernel = powers(&scaled, b).map(|[r, _, c, _]| r + c);
        let mut ahead = [[0.0; 8]; TERMS];
        for (k, ahead) in ahead.iter_mut().enumerate() {
            let ([lag, cos, sin], x, n) = (position[k], kernel[k], k as f64);
            *ahead = [lag, cos, sin, x, x / (n + 1.0), x / ((n + 1.0) * (n + 2.0)), 0.0, 0.0];
        }
        let mut flow = Self {
            a,
            response,
            drag,
            slip,
            rate,
            position,
            velocity: of_path([0.0, 1.0, 0.0, omega]),
            swing: of_path([0.0, 0.0, 0.0, omega]),
            answer: powers(&scaled.map(|row| row.map(|x| -x)), b),
            ahead,
            slopes: [kernel[1] * rate, 2.0 * kernel[2] * rate.powi(2), 6.0 * kernel[3] * rate.powi(3)],
            curvature_bounds: [[0.0; 2]; 2],
        };
        flow.curvature_bounds = [flow.bound_over(&b), flow.bound_over(&flow.rates(&b))];
        flow
    }

    /// Whether drag or a dashpot acts.
    pub(crate) fn damped(&self) -> bool {
        self.drag + self.slip > 0.0
    }

    /// Whether drag acts, so that `lag` is not zero.
    pub(crate) fn lags(&self) -> bool {
        self.drag > 0.0
    }

    /// Power that drag dissipates, over the square of the velocity.
    pub(crate) fn drag(&self) -> f64 {
        self.drag
    }

    /// Power that the dashpot dissipates, over the square of the velocity of the oscillating part.
    pub(crate) fn dashpot(&self) -> f64 {
        if self.response.mu > 0.0 { self.slip / self.response.mu } else { 0.0 }
    }

    /// The longest window for which the series are exact to rounding.
    pub(crate) fn longest(&self) -> f64 {
        LONGEST / self.rate
    }

    /// `exp(A t) y - y`.
    pub fn moved(&self, y: &Path, t: f64) -> Path {
        let (mut term, mut sum) = (*y, [0.0; 4]);
        for per in &PER[..terms(self.rate * t)] {
            let part = t * per;
            term = self.rates(&term).map(|x| x * part);
            for i in 0..4 {
                sum[i] += term[i];
            }
        }
        sum
    }

    /// `A y`: the path whose position is the velocity along `y`.
    pub fn rates(&self, y: &Path) -> Path {
        apply(&self.a, y)
    }

    /// The sums of some series at `L` times, at most [`WIDE`].
    #[inline(always)]
    fn at<const L: usize, const N: usize, const P: usize>(
        &self,
        (series, more): (&Series<N>, &Series<P>),
        t: &[f64; L],
    ) -> ([[f64; L]; N], [[f64; L]; P]) {
        const { assert!(L <= WIDE) };
        let (mut theta, mut largest) = ([0.0; WIDE], 0.0);
        for j in 0..L {
            theta[j] = self.rate * t[j];
            largest = if theta[j] > largest { theta[j] } else { largest };
        }
        let (mut sums, mut others) = ([[0.0; WIDE]; N], [[0.0; WIDE]; P]);
        let terms = terms(largest);
        let series = (&series[..terms], &more[..terms]);
        Horner { series, theta: &theta, times: L, sums: (&mut sums, &mut others) }.run();
        let short = |sum: [f64; WIDE]| std::array::from_fn(|j| sum[j]);
        (sums.map(short), others.map(short))
    }

    /// `lag`, `cos` and `sin` at `L` times.
    #[inline(always)]
    pub fn position<const L: usize>(&self, t: &[f64; L]) -> [[f64; L]; 3] {
        self.at((&self.position, NO_SERIES), t).0
    }

    /// The factors of `v`, `c` and `s` in the velocity `q'`.
    #[inline(always)]
    pub fn velocity<const L: usize>(&self, t: &[f64; L]) -> [[f64; L]; 3] {
        self.at((&self.velocity, NO_SERIES), t).0
    }

    /// The factors of `v`, `c` and `s` in the velocity of the oscillating part.
    #[inline(always)]
    pub fn swing<const L: usize>(&self, t: &[f64; L]) -> [[f64; L]; 3] {
        self.at((&self.swing, NO_SERIES), t).0
    }

    /// [`position`](Self::position), and `exp(-A t) b`: the path by a unit impulse at `t`, after
    /// `t`.
    #[inline(always)]
    pub fn position_and_answer<const L: usize>(&self, t: &[f64; L]) -> ([[f64; L]; 3], [[f64; L]; 4]) {
        self.at((&self.position, &self.answer), t)
    }

    /// [`velocity`](Self::velocity), and `exp(-A t) b`.
    #[inline(always)]
    pub(crate) fn velocity_and_answer<const L: usize>(&self, t: &[f64; L]) -> ([[f64; L]; 3], [[f64; L]; 4]) {
        self.at((&self.velocity, &self.answer), t)
    }

    /// The functions of a prediction at a time.
    #[inline(always)]
    pub fn ahead(&self, t: f64) -> Ahead {
        let (theta, mut sums) = (self.rate * t, [0.0; 8]);
        for term in self.ahead[..terms(theta)].iter().rev() {
            for i in 0..8 {
                sums[i] = theta.mul_add(sums[i], term[i]);
            }
        }
        let [lag, cos, sin, k1, k2, k3, ..] = sums;
        Ahead { position: [lag, cos, sin], ramps: [k1, k2 * t, k3 * t * t] }
    }

    /// Coefficients of `t^2`, `t^3` and `t^4` in `sum_k rates[k] int_0^t K(t - s) s^k/k! ds`.
    pub fn ramped(&self, [f0, f1, f2]: [f64; 3]) -> [f64; 3] {
        let [a, b, c] = self.slopes;
        [a * f0 * 0.5, (a * f1 + b * f0) * (1.0 / 6.0), (a * f2 + b * f1 + c * f0) * (1.0 / 24.0)]
    }

    /// A bound of `q''` over a time `h` along a path.
    ///
    /// The energy `r'^2/m + (c'^2 + omega^2 c^2)/mu` does not grow, so that it bounds the velocity;
    /// drag then adds no more than this to the amplitude of the oscillation.
    pub fn curvature_bound(&self, path: &Path, h: f64) -> f64 {
        let [now, per_time] = self.bound_over(path);
        now + h * per_time
    }

    /// The coefficients of `1` and `h` in [`curvature_bound`](Self::curvature_bound).
    fn bound_over(&self, [_, v, c, s]: &Path) -> [f64; 2] {
        let Self { drag, slip, response: Response { m, mu, .. }, .. } = *self;
        let omega = self.a[2][3];
        let (mut energy, fast) = (0.0, (omega * c).hypot(omega * s));
        if m > 0.0 {
            energy += v * v / m;
        }
        if mu > 0.0 {
            energy += fast * fast / mu;
        }
        let speed = (energy * (m + mu)).sqrt();
        [(omega + slip) * fast + drag * (m + mu) * speed, (omega + slip) * drag * mu * speed]
    }

    /// Bounds of `K''` and `K'''` up to the time `h`.
    pub(crate) fn curvature_bounds(&self, h: f64) -> [f64; 2] {
        self.curvature_bounds.map(|[now, per_time]| now + h * per_time)
    }
}
