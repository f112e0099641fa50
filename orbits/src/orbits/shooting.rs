//! Newton's method for periodic orbits that start at rest.
//!
//! | symbol | meaning |
//! |---|---|
//! | `Z = (x, y)` | strains at `t = 0`, where all velocities are zero |
//! | `F(Z) = 0` | conditions of periodicity, and the centre `C_x` |
//!
//! The derivative of the flow over a period has two Jordan blocks at the multiplier 1: shift of
//! phase with change of frequency, and uniform strain with uniform drift. Among states at rest only
//! one null vector remains, the derivative by the mean strain; one more equation, for `C_x`, makes
//! the derivative of `F` injective. With the half period, `F` has one equation more than unknowns;
//! since `sum (x' + rho y')` is conserved, the least-squares solution satisfies all of them. So it
//! does those of a symmetry, without which a kink that is wider than a few sites could be shifted
//! for nothing.

use super::{
    flow::{Moment, flow},
    setting::Setting,
};
use crate::{
    chain::{Chain, max_norm},
    dps::Center,
    error::{Error, Iterate, Result, require},
    run::state_at,
};
use hertzchain_integrators::collocation::StepControl;
use nalgebra::{DMatrix, DVector, DVectorView};
use serde::{Deserialize, Serialize};

/// The equations that are solved for `Z`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Formulation {
    /// `Z'(T/2) = 0` and `(x_1(0) + x_1(T/2))/2 = C_x` (`T/4` where the period is doubled): by
    /// reversibility the second half of the period is the first one backwards. With a symmetry of
    /// the orbit, see [`Setting::about`], also that.
    #[default]
    HalfPeriod,
    /// `P_T (Z, 0) = (Z, 0)` with the time average of `x_1` at `C_x` (eq:extra_constraint), as in
    /// the paper.
    FullPeriod,
}

/// Settings of the search for an orbit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shooting {
    /// The equations.
    pub formulation: Formulation,
    /// Tolerance of the flow, relative to the size of the state.
    pub tol: f64,
    /// Largest number of steps of Newton's method.
    pub most_steps: usize,
}

impl Default for Shooting {
    fn default() -> Self {
        Self { formulation: Formulation::HalfPeriod, tol: 1e-13, most_steps: 20 }
    }
}

/// A step of Newton's method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NewtonStep {
    /// `max |F(Z)|` before the step, in units of `max |Z|`; velocities are divided by `omega_b`.
    pub residual: f64,
    /// `max` of the change of `Z`, in units of `max |Z|`.
    pub step: f64,
}

/// A periodic orbit, or a relative one: a solution of shooting equations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Orbit<S = Setting> {
    /// What determines it, except for the choice of a branch; by default chain, frequency and
    /// centre.
    pub setting: S,
    /// What is at `t = 0`; by default `[x(0), y(0)]`.
    pub z: Vec<f64>,
    /// Largest residual of its equations, in their unit; by default `max |F(Z)|` in units of
    /// `max |Z|`.
    pub residual: f64,
    /// Steps of Newton's method.
    pub newton: Vec<NewtonStep>,
}

/// A step of at most this length, in the unit of residuals, is the last: by quadratic convergence
/// the next one would be below rounding.
const LAST_STEP: f64 = 1e-9;
/// Largest residual of an orbit; rounding is near 1e-16.
const SOLVED: f64 = 1e-12;
/// Weight of the symmetry of an orbit: it is to decide only what the other equations leave open.
const SYMMETRY: f64 = 1e-3;
/// Longest step, in units of `max |Z|`; seeds are closer than that.
const LONGEST_STEP: f64 = 1.0;

/// `F` and its derivative by the unknowns.
pub struct Equations {
    /// `F`.
    pub residual: DVector<f64>,
    /// The derivative; without columns if it was not asked for.
    pub jacobian: DMatrix<f64>,
}

impl Shooting {
    /// `F` at `z`; with its Jacobian if `derivative`, else with a Jacobian of no columns, which is
    /// cheaper.
    pub(super) fn equations(&self, setting: &Setting, z: &[f64], derivative: bool) -> Result<Equations> {
        let chain = setting.chain()?;
        let columns = if derivative { z.len() } else { 0 };
        match self.formulation {
            Formulation::HalfPeriod => {
                let to = |t: f64| self.flow(&chain, z, t, columns, |_| {});
                let half = 0.5 * setting.period();
                let end = to(half)?;
                let other = (setting.turns > 1).then(|| to(half / f64::from(setting.turns))).transpose()?;
                Ok(half_period(setting, z, &end, other.as_ref().unwrap_or(&end)))
            }
            Formulation::FullPeriod => {
                let mut slopes = Mean::new(z.len(), columns);
                let end = self.flow(&chain, z, setting.period(), columns, |moment| slopes.add(moment))?;
                Ok(full_period(setting, z, &end, self.mean_strain(&chain, z, setting.period())?, &slopes))
            }
        }
    }

    /// The flow from `(z, 0)` over the time `t`, with its derivatives by the first `columns`
    /// entries of `z`.
    pub(super) fn flow(
        &self,
        chain: &Chain<f64>,
        z: &[f64],
        t: f64,
        columns: usize,
        seen: impl FnMut(&Moment),
    ) -> Result<Moment> {
        let mut start = z.to_vec();
        start.resize(2 * z.len(), 0.0);
        let columns = DMatrix::identity(start.len(), columns);
        flow(chain, &start, t, columns, self.tol, seen)
    }

    /// The mean of `x_1` over a period by the trapezoidal rule with 64 samples.
    ///
    /// The rule is exact for a constant plus a part that changes its sign after half a period.
    fn mean_strain(&self, chain: &Chain<f64>, z: &[f64], period: f64) -> Result<f64> {
        const SAMPLES: u32 = 64;
        let mut state = z.to_vec();
        state.resize(2 * z.len(), 0.0);
        let mut run = chain.collocation(&state, (0.0, period), StepControl::Tolerance(self.tol))?;
        let mut sum = z[0];
        for k in 1..SAMPLES {
            sum += state_at(&mut run, period * f64::from(k) / f64::from(SAMPLES))?[0];
        }
        Ok(sum / f64::from(SAMPLES))
    }

    /// The orbit near the strains `seed = [x(0), y(0)]`.
    ///
    /// # Errors
    /// A setting outside its rules; a seed of another length, not finite or zero; a seed whose flow
    /// fails; and [`Error::Stalled`] with the best iterate where the residual of Newton's method
    /// does not fall to 1e-12.
    pub fn solve(&self, setting: &Setting, seed: &[f64]) -> Result<Orbit> {
        let rule = "two strains a site: x, then y; one where no resonator moves";
        require(seed.len() == setting.numbers(), "seed", format!("{} numbers", seed.len()), rule)?;
        let size = max_norm(seed.iter().copied());
        let rule = "strains are finite, and not all zero";
        require(size > 0.0 && seed.iter().all(|z| z.is_finite()), "seed", size, rule)?;
        let Setting { omega_b, params, .. } = setting;
        Newton {
            most_steps: self.most_steps,
            longest: LONGEST_STEP,
            equations: &|z, derivative| self.equations(setting, z, derivative),
            size: &|z, _| z.amax(),
            solved: &|_| SOLVED,
            place: format!("omega_b = {omega_b}, rho = {}", params.rho),
        }
        .solve(setting, seed)
    }
}

/// Newton's method for an orbit.
pub(super) struct Newton<'a> {
    /// Largest number of steps.
    pub(super) most_steps: usize,
    /// Longest step, in the unit of residuals.
    pub(super) longest: f64,
    /// The equations; without derivative the Jacobian has no columns.
    pub(super) equations: &'a dyn Fn(&[f64], bool) -> Result<Equations>,
    /// The unit of residuals, from the unknowns and the residuals.
    pub(super) size: &'a dyn Fn(&DVector<f64>, &DVector<f64>) -> f64,
    /// Largest residual of an orbit with these unknowns, in its unit.
    pub(super) solved: &'a dyn Fn(&[f64]) -> f64,
    /// The orbit that is sought, in words.
    pub(super) place: String,
}

impl Newton<'_> {
    /// The orbit near `seed`; [`Error::Stalled`] with the best iterate where there is none.
    pub(super) fn solve<S: Clone>(self, setting: &S, seed: &[f64]) -> Result<Orbit<S>> {
        let Self { equations, size: unit, solved, .. } = self;
        let (mut z, mut newton) = (DVector::from_column_slice(seed), Vec::new());
        let mut best: Option<Orbit<S>> = None;
        let mut keep = |z: &DVector<f64>, residual: f64, newton: &[NewtonStep]| {
            if residual < best.as_ref().map_or(f64::INFINITY, |best| best.residual) {
                let (setting, z, newton) = (setting.clone(), z.as_slice().to_vec(), newton.to_vec());
                best = Some(Orbit { setting, z, residual, newton });
            }
            best.clone()
        };
        for _ in 0..self.most_steps {
            let Ok(Equations { residual, jacobian }) = equations(z.as_slice(), true) else { break };
            let size = unit(&z, &residual);
            let Some(mut by) = least_squares(jacobian, &residual) else { break };
            newton.push(NewtonStep { residual: residual.amax() / size, step: by.amax() / size });
            keep(&z, residual.amax() / size, &newton);
            if z.amax() > 0.0 {
                by *= (self.longest * size / by.amax()).min(1.0);
            }
            z -= &by;
            if by.amax() <= LAST_STEP * size {
                break;
            }
        }
        let last = match equations(z.as_slice(), false) {
            Ok(Equations { residual, .. }) => residual.amax() / unit(&z, &residual),
            Err(error) if newton.is_empty() => return Err(error),
            Err(_) => f64::INFINITY,
        };
        match keep(&z, last, &newton) {
            Some(orbit) if orbit.residual <= solved(&orbit.z) => Ok(Orbit { newton, ..orbit }),
            best => {
                let iterate = |Orbit { z, residual, .. }: Orbit<S>| {
                    Box::new(Iterate { solved: solved(&z), z, residual, place: self.place })
                };
                Err(Error::Stalled { steps: newton.len(), best: best.map(iterate) })
            }
        }
    }
}

/// The vector `x` with the least `|matrix x - right|`; `None` where the matrix does not have full
/// rank.
pub fn least_squares(matrix: DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let (columns, qr) = (matrix.ncols(), matrix.qr());
    let mut right = right.clone();
    qr.q_tr_mul(&mut right);
    let x = qr.r().solve_upper_triangular(&right.rows(0, columns).into_owned())?;
    x.iter().all(|x| x.is_finite()).then_some(x)
}

/// `F = [Z'(T/2) / omega_b, (x_1(0) + x_1(T/(2 turns)))/2 - C_x]`, from the moments `T/2` and
/// `T/(2 turns)`, and the symmetry of the orbit, if it has one.
fn half_period(setting: &Setting, z: &[f64], end: &Moment, turn: &Moment) -> Equations {
    let n = z.len();
    let residual = DVector::from_column_slice(&end.state[n..]) / setting.omega_b;
    let mut jacobian = (end.columns.rows(n, n) / setting.omega_b).insert_row(n, 0.0);
    for j in 0..jacobian.ncols() {
        jacobian[(n, j)] = 0.5 * (turn.columns[(0, j)] + f64::from(u8::from(j == 0)));
    }
    let mut equations = Equations { residual: residual.push(0.5 * (z[0] + turn.state[0]) - setting.c_x), jacobian };
    let Some((about, image)) = setting.mirror() else { return equations };
    let Equations { residual, jacobian } = &mut equations;
    *residual = std::mem::take(residual).resize_vertically(2 * n + 1, 0.0);
    *jacobian = std::mem::take(jacobian).resize_vertically(2 * n + 1, 0.0);
    for k in 0..n {
        let (image, row) = (image(k), n + 1 + k);
        let other = match about {
            Center::Site => end.state[image],
            Center::Bond => z[image],
        };
        residual[row] = SYMMETRY * (other - z[k]);
        if jacobian.ncols() > 0 {
            match about {
                Center::Site => jacobian.set_row(row, &(end.columns.row(image) * SYMMETRY)),
                Center::Bond => jacobian[(row, image)] = SYMMETRY,
            }
            jacobian[(row, k)] -= SYMMETRY;
        }
    }
    equations
}

/// `F = [Z(T) - Z(0), Z'(T) / omega_b, mean x_1 - C_x]`.
fn full_period(setting: &Setting, z: &[f64], end: &Moment, mean: f64, slopes: &Mean) -> Equations {
    let (n, columns) = (z.len(), end.columns.ncols());
    let mut residual = DVector::from_column_slice(&end.state);
    let mut jacobian = end.columns.clone();
    residual.rows_mut(0, n).zip_apply(&DVectorView::from_slice(z, n), |end, z| *end -= z);
    residual.rows_mut(n, n).unscale_mut(setting.omega_b);
    for j in 0..columns {
        jacobian[(j, j)] -= 1.0;
    }
    jacobian.rows_mut(n, n).unscale_mut(setting.omega_b);
    residual = residual.push(mean - setting.c_x);
    jacobian = jacobian.insert_row(2 * n, 0.0);
    for j in 0..columns {
        jacobian[(2 * n, j)] = slopes.sum[j] / end.t;
    }
    Equations { residual, jacobian }
}

/// `int M_1 dt`, the derivatives of `int x_1 dt` by `Z`.
///
/// The trapezoidal rule with its correction by slopes is accurate enough for a Jacobian.
struct Mean {
    /// Index of the velocity of the first site in a state.
    velocity: usize,
    sum: DVector<f64>,
    before: Option<(f64, [DVector<f64>; 2])>,
}

impl Mean {
    fn new(velocity: usize, columns: usize) -> Self {
        Self { velocity, sum: DVector::zeros(columns), before: None }
    }

    fn add(&mut self, moment: &Moment) {
        let now = [0, self.velocity].map(|i| moment.columns.row(i).transpose());
        if let Some((t, [value, slope])) = &self.before {
            let h = moment.t - t;
            self.sum += (value + &now[0]) * (0.5 * h) + (slope - &now[1]) * (h * h / 12.0);
        }
        self.before = Some((moment.t, now));
    }
}
