//! One trial step: the twelve stages, the result and its error norm.

use super::tableau::{self, Weights};
use crate::{
    clock::DoubleDouble,
    real::{Kernel, Real},
    system::VectorField,
};

/// Number of components per turn of an inner loop. Arrays are padded to a multiple of it.
const LANES: usize = 8;

/// Number of slopes: stages 1 to 12, the slope at the end, and three more for dense output.
pub(crate) const SLOPES: usize = 16;

/// Weights of slopes in the working precision: `(index, weight)`, indices from 0.
pub(crate) type Row<R> = Vec<(usize, R)>;

/// A row of weights in the working precision.
pub(crate) fn row<R: Real>(weights: &Weights) -> Row<R> {
    weights.iter().map(|&(stage, weight)| (stage - 1, R::decimal(weight))).collect()
}

/// A table of stages in the working precision: nodes `c` and rows `a`.
pub(crate) fn stages<R: Real>(table: &[(&str, &Weights)]) -> Vec<(R, Row<R>)> {
    table.iter().map(|&(c, a)| (R::decimal(c), row(a))).collect()
}

/// A step: its start, its end, and its length to the working precision; and what the formula of
/// order 3 makes of the time of the step, as a share of it: 1 but where time is mapped.
#[derive(Clone, Copy)]
pub(crate) struct Leap<R> {
    pub(crate) from: DoubleDouble<R>,
    pub(crate) to: DoubleDouble<R>,
    pub(crate) h: R,
    pub(crate) share_3: R,
}

/// The larger of two numbers that are not NaN.
#[inline(always)]
fn larger<R: Real>(a: R, b: R) -> R {
    if a > b { a } else { b }
}

/// The twelve-stage step and its arrays.
pub(crate) struct Step<R> {
    dim: usize,
    stages: Vec<(R, Row<R>)>,
    b: Row<R>,
    error_5: Row<R>,
    error_3: Row<R>,
    /// State at the start of a trial; after acceptance, the state reached.
    y: Vec<R>,
    /// Absolute tolerances of the components.
    atol: Vec<R>,
    time_unit: R,
    /// Result of a trial; after acceptance, the state before the step.
    other: Vec<R>,
    /// State of a stage.
    inner: Vec<R>,
    k: [Vec<R>; SLOPES],
}

impl<R: Real> Step<R> {
    /// From `y0`, with an absolute tolerance in units of the components.
    pub(crate) fn new(y0: &[R], atol: R) -> Self {
        let dim = y0.len();
        let zeros = vec![R::zero(); dim.next_multiple_of(LANES)];
        let mut y = zeros.clone();
        y[..dim].copy_from_slice(y0);
        Self {
            dim,
            stages: stages(&tableau::STAGES),
            b: row(tableau::B),
            error_5: row(tableau::ERROR_5),
            error_3: row(tableau::BHH),
            y,
            atol: vec![atol; dim.next_multiple_of(LANES)],
            time_unit: R::one(),
            other: zeros.clone(),
            inner: zeros.clone(),
            k: std::array::from_fn(|_| zeros.clone()),
        }
    }

    /// Takes units of the components, in place of 1, and of time.
    pub(crate) fn in_units(&mut self, units: &[R], time: R) {
        self.atol.iter_mut().zip(units).for_each(|(atol, &unit)| *atol *= unit);
        self.time_unit = time;
    }

    pub(crate) fn time_unit(&self) -> R {
        self.time_unit
    }

    /// The sum of squares of `x` in units of the tolerance at the state reached.
    pub(crate) fn norm(&self, rtol: R, x: impl Iterator<Item = R>) -> R {
        let tolerances = self.y.iter().zip(&self.atol).map(|(y, &atol)| atol + rtol * y.abs());
        tolerances.zip(x).map(|(tolerance, x)| x / tolerance).fold(R::zero(), |sum, share| sum + share * share)
    }

    pub(crate) fn dim(&self) -> usize {
        self.dim
    }

    /// The state reached.
    pub(crate) fn state(&self) -> &[R] {
        &self.y[..self.dim]
    }

    /// The state before the last accepted step.
    pub(crate) fn before(&self) -> &[R] {
        &self.other[..self.dim]
    }

    /// Slope `index`, from 0; index 0 is the start of the step, index 12 its end.
    pub(crate) fn slope(&self, index: usize) -> &[R] {
        &self.k[index][..self.dim]
    }

    /// Computes the slope at the start of the run.
    pub(crate) fn begin<F: VectorField<R>>(&mut self, field: &mut F, t: R) {
        field.eval(t, &self.y[..self.dim], &mut self.k[0][..self.dim]);
    }

    /// Makes an explicit Euler step; its slope is stored as that of the second stage.
    pub(crate) fn euler<F: VectorField<R>>(&mut self, field: &mut F, t: R, h: R) {
        for ((inner, &y), &slope) in self.inner.iter_mut().zip(&self.y).zip(&self.k[0]) {
            *inner = y + h * slope;
        }
        field.eval(t + h, &self.inner[..self.dim], &mut self.k[1][..self.dim]);
    }

    /// Computes slope `index` of the last accepted step, at the inner state `y + h sum a k`.
    pub(crate) fn slope_inside<F: VectorField<R>>(
        &mut self,
        field: &mut F,
        leap: Leap<R>,
        (c, a): (R, &[(usize, R)]),
        index: usize,
    ) {
        R::run(Combine { out: &mut self.inner, base: Some(&self.other), h: leap.h, a, k: &self.k });
        let t = leap.from.value() + c * leap.h;
        field.eval(t, &self.inner[..self.dim], &mut self.k[index][..self.dim]);
    }

    /// `out = h sum a k`; `out` has length [`padded`](Self::padded).
    pub(crate) fn combine(&self, out: &mut [R], h: R, a: &[(usize, R)]) {
        R::run(Combine { out, base: None, h, a, k: &self.k });
    }

    /// Length of the padded arrays.
    pub(crate) fn padded(&self) -> usize {
        self.y.len()
    }

    /// Tries a step: eleven evaluations, as the first slope is known.
    ///
    /// Returns the norm of the error in units of `atol + rtol |y|` (zero without `rtol`), or the
    /// index of a component that is not finite.
    pub(crate) fn attempt<F: VectorField<R>>(
        &mut self,
        field: &mut F,
        leap: Leap<R>,
        rtol: Option<R>,
    ) -> Result<R, usize> {
        let (h, dim) = (leap.h, self.dim);
        for (index, (c, a)) in (1..).zip(&self.stages) {
            R::run(Combine { out: &mut self.inner, base: Some(&self.y), h, a, k: &self.k });
            let t = if index == 11 { leap.to.value() } else { leap.from.value() + *c * h };
            field.eval(t, &self.inner[..dim], &mut self.k[index][..dim]);
        }
        // The slopes of dense output are not in use here and serve as buffers.
        let [slopes @ .., one, two, three] = &mut self.k;
        let [error_5, error_3, zero] = R::run(Finish {
            out: &mut self.other,
            scratch: [one, two, three],
            y: &self.y,
            by: (h, leap.share_3),
            b: &self.b,
            error_5: &self.error_5,
            error_3: &self.error_3,
            atol: &self.atol,
            rtol: rtol.unwrap_or(R::zero()),
            k: slopes,
        });
        if zero != R::zero() {
            return Err(self.culprit());
        }
        if rtol.is_none() {
            return Ok(R::zero());
        }
        let weight = error_5 + R::of(0.01) * error_3;
        if !weight.is_finite() {
            return Err(self.culprit());
        }
        // The inverse of a smaller one may be infinite.
        let weight = if weight >= R::of(f64::MIN_POSITIVE) { weight } else { R::one() };
        Ok(h * error_5 * (R::of(dim as f64) * weight).recip().sqrt())
    }

    /// [`Leap::share_3`] of a step in a variable in which time has this rate.
    pub(crate) fn share_3(&self, leap: Leap<R>, rate: impl Fn(R) -> R) -> R {
        let c = |k: usize| k.checked_sub(1).map_or(R::zero(), |k| self.stages[k].0);
        let rate = |k: usize| rate(leap.from.value() + c(k) * leap.h);
        let time = |row: &Row<R>| row.iter().fold(R::zero(), |time, &(k, weight)| time + weight * rate(k));
        time(&self.error_3) / time(&self.b)
    }

    /// Accepts the trial: its result becomes the state reached, and the slope there is computed. If
    /// that slope is not finite, the state does not change.
    pub(crate) fn accept<F: VectorField<R>>(&mut self, field: &mut F, t: R) -> Result<(), usize> {
        field.eval(t, &self.other[..self.dim], &mut self.k[12][..self.dim]);
        self.check(12)?;
        std::mem::swap(&mut self.y, &mut self.other);
        Ok(())
    }

    /// Reverts an accepted step. The first slope is still valid.
    pub(crate) fn undo(&mut self) {
        std::mem::swap(&mut self.y, &mut self.other);
    }

    /// The state reached, to be changed.
    pub(crate) fn state_mut(&mut self) -> &mut [R] {
        &mut self.y[..self.dim]
    }

    /// Sets the state.
    pub(crate) fn load(&mut self, y: &[R]) {
        self.y[..self.dim].copy_from_slice(y);
    }

    /// Ends the last step: the slope at its end becomes the first slope of the next.
    pub(crate) fn advance(&mut self) {
        self.k.swap(0, 12);
    }

    /// Fails with the first component of slope `index` that is not finite.
    pub(crate) fn check(&self, index: usize) -> Result<(), usize> {
        if R::run(Zeros(&self.k[index])) == R::zero() {
            return Ok(());
        }
        self.slope(index).iter().position(|slope| !slope.is_finite()).map_or(Ok(()), Err)
    }

    /// The first component whose slopes or result are not finite; 0 if only sums over components
    /// overflow.
    fn culprit(&self) -> usize {
        let finite = |i: usize| self.other[i].is_finite() && self.k[..12].iter().all(|k| k[i].is_finite());
        (0..self.dim).find(|&i| !finite(i)).unwrap_or(0)
    }
}

/// Weights and slopes of a sum of `M` terms.
#[inline(always)]
fn terms<'a, R: Real, const M: usize>(a: &[(usize, R)], k: &'a [Vec<R>], len: usize) -> ([R; M], [&'a [R]; M]) {
    let mut weights = [R::zero(); M];
    let mut slopes: [&[R]; M] = [&[]; M];
    for m in 0..M {
        weights[m] = a[m].1;
        slopes[m] = &k[a[m].0][..len];
    }
    (weights, slopes)
}

/// `sum a k` for component `i`. The terms are added in the order of the table.
#[inline(always)]
fn sum<R: Real, const M: usize>((a, k): (&[R; M], &[&[R]; M]), i: usize) -> R {
    let mut sum = a[0] * k[0][i];
    for m in 1..M {
        sum += a[m] * k[m][i];
    }
    sum
}

// The loops below are functions, not methods, because their `&mut` arguments tell the compiler that
// nothing else aliases them; otherwise it does not vectorise the loops.

/// `out = base + h sum a k`.
#[inline(always)]
fn step_from<R: Real, const M: usize>(out: &mut [R], base: &[R], h: R, terms: (&[R; M], &[&[R]; M])) {
    let base = &base[..out.len()];
    for i in 0..out.len() {
        out[i] = base[i] + h * sum(terms, i);
    }
}

/// `out = h sum a k`.
#[inline(always)]
fn weigh<R: Real, const M: usize>(out: &mut [R], h: R, terms: (&[R; M], &[&[R]; M])) {
    for (i, out) in out.iter_mut().enumerate() {
        *out = h * sum(terms, i);
    }
}

/// The sum of all components, times `weight`.
#[inline(always)]
fn total<R: Real>(x: &[R], weight: R) -> R {
    let mut lanes = [R::zero(); LANES];
    for block in x.as_chunks::<LANES>().0 {
        for lane in 0..LANES {
            lanes[lane] += block[lane] * weight;
        }
    }
    lanes.into_iter().fold(R::zero(), |sum, lane| sum + lane)
}

/// Zero if all components are finite, otherwise not a number.
struct Zeros<'a, R>(&'a [R]);

impl<R: Real> Kernel for Zeros<'_, R> {
    type Output = R;
    #[inline(always)]
    fn run(self) -> R {
        total(self.0, R::zero())
    }
}

/// `out = base + h sum a k`.
struct Combine<'a, R> {
    out: &'a mut [R],
    base: Option<&'a [R]>,
    h: R,
    a: &'a [(usize, R)],
    k: &'a [Vec<R>],
}

impl<R: Real> Combine<'_, R> {
    #[inline(always)]
    fn of<const M: usize>(self) {
        let (a, k) = terms::<R, M>(self.a, self.k, self.out.len());
        match self.base {
            Some(base) => step_from(self.out, base, self.h, (&a, &k)),
            None => weigh(self.out, self.h, (&a, &k)),
        }
    }
}

impl<R: Real> Kernel for Combine<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        match self.a.len() {
            1 => self.of::<1>(),
            2 => self.of::<2>(),
            3 => self.of::<3>(),
            4 => self.of::<4>(),
            5 => self.of::<5>(),
            6 => self.of::<6>(),
            7 => self.of::<7>(),
            8 => self.of::<8>(),
            9 => self.of::<9>(),
            12 => self.of::<12>(),
            terms => unreachable!("no row of the table has {terms} terms"),
        }
    }
}

/// Computes the result of a trial, the sums of squares of its scaled errors of order 5 and of order
/// 3, and zero if the result and all slopes are finite, otherwise not a number.
struct Finish<'a, R> {
    out: &'a mut [R],
    scratch: [&'a mut [R]; 3],
    y: &'a [R],
    /// The step, and [`Leap::share_3`].
    by: (R, R),
    b: &'a [(usize, R)],
    error_5: &'a [(usize, R)],
    error_3: &'a [(usize, R)],
    atol: &'a [R],
    rtol: R,
    k: &'a [Vec<R>],
}

impl<R: Real> Kernel for Finish<'_, R> {
    type Output = [R; 3];
    #[inline(always)]
    fn run(self) -> [R; 3] {
        let len = self.out.len();
        let [error_5, error_3, all] = self.scratch;
        let (b, slopes) = terms::<R, 8>(self.b, self.k, len);
        weigh(error_3, R::one(), (&b, &slopes));
        let (b, slopes) = terms::<R, 8>(self.error_5, self.k, len);
        weigh(error_5, R::one(), (&b, &slopes));
        let (b, slopes) = terms::<R, 3>(self.error_3, self.k, len);
        // Slopes 2 to 5, which have no weight in the result. They are checked because a field may
        // lose their NaN in the later stages (as `max` does).
        let early = std::array::from_fn(|m| &self.k[m + 1][..len]);
        let tolerance = (&self.atol[..len], self.rtol);
        measure_errors(self.out, [error_5, error_3, all], self.y, self.by, tolerance, (&b, &slopes), early);
        [total(error_5, R::one()), total(error_3, R::one()), total(all, R::zero())]
    }
}

/// Computes the result from `error_3`, which holds the mean slope; then replaces both errors by
/// their squares in units of the tolerance.
///
/// An entry of `all` is finite only if the result and all slopes of the component are.
#[inline(always)]
fn measure_errors<R: Real>(
    out: &mut [R],
    [error_5, error_3, all]: [&mut [R]; 3],
    y: &[R],
    (h, share_3): (R, R),
    (atol, rtol): (&[R], R),
    (b, k): (&[R; 3], &[&[R]; 3]),
    early: [&[R]; 4],
) {
    let len = out.len();
    let (error_5, error_3, all, y) = (&mut error_5[..len], &mut error_3[..len], &mut all[..len], &y[..len]);
    for i in 0..len {
        let slope = error_3[i];
        let new = y[i] + h * slope;
        out[i] = new;
        let scale = atol[i] + rtol * larger(y[i].abs(), new.abs());
        let share_5 = error_5[i] / scale;
        let off_3 = (share_3 * slope - b[0] * k[0][i] - b[1] * k[1][i] - b[2] * k[2][i]) / scale;
        error_5[i] = share_5 * share_5;
        error_3[i] = off_3 * off_3;
        all[i] = new + early[0][i] + early[1][i] + early[2][i] + early[3][i];
    }
}
