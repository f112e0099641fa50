//! Gauss collocation of order 2 and 4: symplectic, symmetric, and exact for every quadratic
//! invariant.
//!
//! | symbol | meaning |
//! |---|---|
//! | `k_i` | slope at stage `i`: `k_i = f(t + c_i h, Y_i)`, `Y_i = y + h sum_j a_ij k_j` |
//! | `c_i` | Gauss nodes of `[0, 1]`: `1/2`, or `1/2 -+ s` with `s = sqrt(3)/6` |
//!
//! E. Hairer, C. Lubich and G. Wanner, *Geometric Numerical Integration*, 2nd ed., Springer 2006,
//! sections II.1.3, IV.2.1 and VIII.6.

use crate::{
    clock::DoubleDouble, dop853::check_start, drive::Stepper, error::Error, interrupt, real::Real, stats::Stats,
    system::VectorField,
};

/// Number of stages, which fixes the order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stages {
    /// The implicit midpoint rule, order 2.
    One,
    /// Order 4.
    Two,
}

/// Largest number of sweeps over the stages of a step. Changes that shrink by 3/4 a sweep reach
/// rounding within them.
const MOST: u32 = 130;

/// Gauss collocation of `y' = f(t, y)` in equal steps.
///
/// The stages are iterated to rounding, and sums are compensated. What remains in an invariant that
/// the method conserves is a random walk of rounding errors.
pub struct Gauss<R, F> {
    field: F,
    stages: Stages,
    y: Vec<R>,
    /// Rounding errors of `y` that are still to be added (compensated summation).
    carry: Vec<R>,
    before: Vec<R>,
    slopes: [Vec<R>; 2],
    /// Buffer for the state of a stage; `fresh` is the buffer for its new slope.
    stage: Vec<R>,
    fresh: Vec<R>,
    start: R,
    end: R,
    h: DoubleDouble<R>,
    steps: u64,
    from: R,
    time: R,
    stats: Stats,
}

impl<R: Real, F: VectorField<R>> Gauss<R, F> {
    /// Runs `field` from `y0` at `start` to `end` in `steps` equal steps.
    ///
    /// # Errors
    /// `end < start`, times or a state that are not finite, a state of the wrong length, no step
    /// for a span that is not empty.
    pub fn new(field: F, y0: &[R], (start, end): (R, R), steps: u64, stages: Stages) -> Result<Self, Error> {
        check_start(field.dim(), y0, (start, end))?;
        if steps == 0 && end > start {
            return Err(Error::Argument { name: "steps", value: 0.0, rule: "at least one step" });
        }
        let zero = || vec![R::zero(); y0.len()];
        Ok(Self {
            field,
            stages,
            y: y0.to_vec(),
            carry: zero(),
            before: y0.to_vec(),
            slopes: [zero(), zero()],
            stage: zero(),
            fresh: zero(),
            start,
            end,
            h: (DoubleDouble::new(end) - DoubleDouble::new(start)).over(DoubleDouble::new(R::of(steps.max(1) as f64))),
            steps,
            from: start,
            time: start,
            stats: Stats::default(),
        })
    }

    /// `s`, half the distance of the two nodes.
    fn node() -> R {
        R::decimal("0.28867513459481288225457439025098")
    }

    /// Initial slopes for the iteration: at the start of the run the slope there, later the slopes
    /// of the last step, with two stages extrapolated linearly.
    fn predict(&mut self) {
        let [first, second] = &mut self.slopes;
        if self.stats.steps == 0 {
            self.field.eval(self.start, &self.y, first);
            self.stats.force_evaluations += 1;
            second.copy_from_slice(first);
        } else if self.stages == Stages::Two {
            let reach = R::of(0.5) / Self::node();
            for (first, second) in first.iter_mut().zip(second) {
                let rise = (*second - *first) * reach;
                (*first, *second) = (*first + rise, *second + rise);
            }
        }
    }

    /// Writes the state `Y_i` of a stage.
    ///
    /// Conservation of quadratic invariants needs `a_12 + a_21 = 1/2` to the last bit. Therefore
    /// `s` enters both stages as the same number, with either sign.
    fn place(&mut self, i: usize) {
        let h = self.h.value();
        let (half, quarter, s) = (R::of(0.5) * h, R::of(0.25) * h, Self::node() * h);
        let [first, second] = &self.slopes;
        for (n, stage) in self.stage.iter_mut().enumerate() {
            let (k1, k2) = (first[n], second[n]);
            let increment = match (self.stages, i) {
                (Stages::One, _) => half * k1,
                (Stages::Two, 0) => quarter * (k1 + k2) - s * k2,
                (Stages::Two, _) => quarter * (k1 + k2) + s * k1,
            };
            *stage = self.y[n] + (increment + self.carry[n]);
        }
    }

    /// One sweep over the stages. Returns the largest change `h |k_i - k_i^old|`, `NaN` if a slope
    /// is not a number.
    fn sweep(&mut self) -> R {
        let (h, half) = (self.h.value(), R::of(0.5));
        let (shifts, count) = match self.stages {
            Stages::One => ([R::zero(); 2], 1),
            Stages::Two => ([-Self::node(), Self::node()], 2),
        };
        let mut change = R::zero();
        for (i, &shift) in shifts[..count].iter().enumerate() {
            self.place(i);
            self.field.eval(self.from + (half + shift) * h, &self.stage, &mut self.fresh);
            self.stats.force_evaluations += 1;
            for (old, &new) in self.slopes[i].iter_mut().zip(&self.fresh) {
                let difference = (h * (new - *old)).abs();
                // `max` would lose a NaN.
                if difference > change || difference.is_nan() {
                    change = difference;
                }
                *old = new;
            }
            if change.is_nan() {
                break;
            }
        }
        change
    }

    /// Sweeps until nothing changes, or until changes are of the size of rounding and no longer
    /// decrease. After that, more sweeps do not reduce the error.
    ///
    /// E. Hairer, R. I. McLachlan and A. Razakarivony, *Achieving Brouwer's law with implicit
    /// Runge-Kutta methods*, BIT 48 (2008).
    fn settle(&mut self) -> Result<(), Error> {
        let size = self.y.iter().fold(R::zero(), |size, y| size.max(y.abs()));
        let rounding = R::of(64.0) * crate::dop853::controller::round_off::<R>() * size;
        let mut last = R::infinity();
        for _ in 0..MOST {
            let change = self.sweep();
            if change == R::zero() || (change >= last && change <= rounding) {
                return Ok(());
            }
            last = change;
            if !change.is_finite() {
                break;
            }
        }
        Err(Error::NotSettled { t: self.from.f64(), h: self.h.value().f64(), residual: last.f64() })
    }
}

impl<R: Real, F: VectorField<R>> Stepper<R> for Gauss<R, F> {
    fn dim(&self) -> usize {
        self.y.len()
    }

    fn time(&self) -> R {
        self.time
    }

    fn done(&self) -> bool {
        self.time >= self.end
    }

    /// Makes one step. After an error the state is the one before the step.
    fn step(&mut self) -> Result<(), Error> {
        interrupt::check(self.time.f64())?;
        self.from = self.time;
        self.before.copy_from_slice(&self.y);
        self.predict();
        self.settle()?;
        let (h, half) = (self.h.value(), R::of(0.5));
        let [first, second] = &self.slopes;
        for (n, (y, carry)) in self.y.iter_mut().zip(&mut self.carry).enumerate() {
            let slope = match self.stages {
                Stages::One => first[n],
                Stages::Two => half * (first[n] + second[n]),
            };
            let (old, increment) = (*y, h * slope + *carry);
            *y = old + increment;
            *carry = increment - (*y - old);
        }
        self.stats.steps += 1;
        let taken = DoubleDouble::new(R::of(self.stats.steps as f64));
        self.time = if self.stats.steps == self.steps {
            self.end
        } else {
            (DoubleDouble::new(self.start) + self.h * taken).value()
        };
        Ok(())
    }

    /// Inside the last step the state is that of the collocation polynomial, of degree one or two.
    /// Its error is of the order of the square or the cube of the step.
    fn sample(&mut self, t: R, y: &mut [R]) {
        if t >= self.time || self.stats.steps == 0 {
            y.copy_from_slice(&self.y);
            return self.field.complete(self.start, self.time, y);
        }
        let (h, half, s) = (self.h.value(), R::of(0.5), Self::node());
        let share = ((t - self.from) / h).max(R::zero());
        // Integrals of the Lagrange polynomials of the nodes from 0 to the share.
        let tilt = half * share * (share - R::one()) / (s + s);
        let weights = match self.stages {
            Stages::One => [share, R::zero()],
            Stages::Two => [half * share - tilt, half * share + tilt],
        };
        for (n, y) in y.iter_mut().enumerate() {
            *y = self.before[n] + h * (weights[0] * self.slopes[0][n] + weights[1] * self.slopes[1][n]);
        }
        self.field.complete(self.start, t, y);
    }

    fn stats(&self) -> Stats {
        self.stats
    }
}
