//! Moving dark breathers as relative periodic orbits of the strain ring (Sec. 8 asks for them).
//!
//! | symbol | meaning |
//! |---|---|
//! | `S, Phi_t` | shift by a site, `(S x)_n = x_{n-1}`; flow |
//! | `T_m` | time in which the kink moves on by a site: `S^{-1} Phi_{T_m} z = z`, `v = 1/T_m` |
//! | `k` | turns: `T_m = (k + 1/2) 2 pi/omega_b` |
//! | `R_1, R_2` | reversals about the bond at the start, and about the next site |
//! | `a_n` | local amplitude: first harmonic of `x_n` over a period about `t = 0` |
//!
//! # The symmetry
//!
//! The background of a dark breather, `x_n = (-1)^n X(t)` with `X(t + T/2) = -X(t)`, returns after
//! a shift by one site and half a period. So a breather that moves by one site in the time `T_m`
//! stands on its background if `T_m` is half a period and `k` whole ones.
//!
//! A moving breather has a phase jump that is not `pi`. On a ring of an odd number of sites the
//! background takes up the difference: its wave number is `pi + delta` with `delta` of the order
//! `1/N`, and it is a travelling wave. The equation `x_{n+1}(t + T_m) = x_n(t)` holds for it if its
//! frequency is `omega_b + delta/T_m`; so `omega_b` is the frequency on a long ring. The
//! ring is odd, since free ends are not invariant under shifts, and since a second kink that moves
//! the other way is not at rest in the moving frame.
//!
//! # The equations
//!
//! The chain is reversible, also after a reflection. `R_1` reflects about the middle bond and
//! reverses rates; `R_2 = S R_1`. A solution that is symmetric under `R_1` at `t = 0` and under
//! `R_2` at `t = T_m/2` is a relative periodic orbit, since `Phi_{T_m} z = R_2 R_1 z = S z`. The
//! unknowns are the `2 N` coordinates of the states `R_1 z = z`. The equations are the `2 N`
//! coordinates of `Phi_{T_m/2} z` that change their sign under `R_2`, and the mean strain far from
//! the kink, which is zero: it removes the null vector `dz/dmean`. One equation follows from the
//! others, since `sum (x' + rho y')` is conserved. Shifts of time, and of the phase of the
//! background against the kink, do not keep the symmetry, so they are no null vectors. Newton's
//! method takes the least-squares solution.
//!
//! # The tail
//!
//! Linear waves on the background have a wave number `p` and a frequency `Omega` relative to it.
//! They keep their phase in the frame of the kink if `p + Omega T_m` is a multiple of `2 pi`. With
//! slow kinks there are such waves, and a kink radiates into them; a relative periodic orbit then
//! has a tail of them (a nanopteron). On a ring the tail depends on the distance of these waves
//! from those that fit the ring. Where one fits, the tail is large and Newton's method finds no
//! solution near the seed.

use super::DarkBreather;
use crate::{
    chain::{Boundary, Chain, Params, max_norm},
    dps::Center,
    error::{Error, Iterate, Result, require},
    interrupt,
    orbits::{Equations, Frame, NewtonStep, Orbit, Shooting, Spectrum, flow, known, least_squares},
    run::state_at,
};
use hertzchain_integrators::collocation::StepControl;
use nalgebra::{Complex, DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Largest number of steps of Newton's method, and the share of a step at which halving ends.
const MOST_STEPS: usize = 20;
const LEAST_SHARE: f64 = 0.03;
/// Longest step, in units of the largest strain.
const LONGEST_STEP: f64 = 0.5;
/// A full step of at most this length, in the same units, is the last.
const LAST_STEP: f64 = 1e-9;
/// Largest residual of an orbit, in the same units.
const SOLVED: f64 = 1e-12;
/// The `twist` of each [seed](MovingBreather::seed): the share of the background that is turned by
/// a quarter of a period.
const TWISTS: [f64; 8] = [0.1, 0.15, 0.21, 0.28, 0.35, 0.45, 0.58, 0.72];
/// Number of seeds that Newton's method starts from, and the tail, in units of the background, at
/// which the search ends.
const TRIES: usize = 3;
const SMALL_TAIL: f64 = 0.01;
/// Intervals of half a period for local amplitudes.
const SAMPLES: usize = 32;
/// Largest number of turns.
const MOST_TURNS: u32 = 100;

/// The numbers that determine a moving dark breather, except for the choice of a branch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MovingBreather {
    /// Exponent, spring constant, mass ratio.
    pub params: Params,
    /// Sites on the ring of strains: an odd number, at least 9.
    pub sites: usize,
    /// Frequency of the background on a long ring, above `omega`.
    pub omega_b: f64,
    /// Whole periods of the background in the time in which the kink moves on by a site.
    pub turns: u32,
}

/// A moving dark breather, which moves to the right: `z` is `[x, y, x', y']` at `t = 0`, when the
/// kink is on the middle bond, sites `n = -N .. N`; the residual is the largest absolute value of
/// the equations, in units of `max |x|`, with rates divided by `omega_b`.
pub type MovingOrbit = Orbit<MovingBreather>;

/// Local amplitudes, at the time when the kink is on the middle bond.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Envelope {
    /// `|a_n|`.
    pub amplitude: Vec<f64>,
    /// Phase of `(-1)^n a_n`, from -pi to pi.
    pub phase: Vec<f64>,
    /// Mean of `x_n` over the period.
    pub mean: Vec<f64>,
    /// Mean of `|a_n|` over the half of the ring that is farther from the kink.
    pub background: f64,
    /// Mean of `|a_n|` of the two sites of the kink, over the background.
    pub depth: f64,
    /// Largest less smallest `|a_n|` of the half of the ring that is farther from the kink, over
    /// the background.
    pub tail: f64,
}

/// Coordinates of states `[x, y, x', y']` for a reversal: first `2 N` rows that the reversal keeps,
/// then `2 N` rows whose sign it changes. A row takes entries `i` and `j` with the weight
/// `2^{-1/2}` and a sign for `j`, or one entry alone if `i = j`.
struct Mirror {
    rows: Vec<(usize, usize, f64)>,
}

impl Mirror {
    /// The reversal that takes site `i` to `sum - i`, sites counted from 0 on the ring.
    fn new(sites: usize, sum: usize) -> Self {
        let (mut even, mut odd) = (Vec::new(), Vec::new());
        for array in 0..4 {
            let (same, other) = if array < 2 { (&mut even, &mut odd) } else { (&mut odd, &mut even) };
            for i in 0..sites {
                let j = (2 * sites + sum - i) % sites;
                let (a, b) = (array * sites + i, array * sites + j);
                if i <= j {
                    same.push((a, b, 1.0));
                }
                if i < j {
                    other.push((a, b, -1.0));
                }
            }
        }
        even.append(&mut odd);
        Self { rows: even }
    }

    /// The orthogonal matrix.
    fn matrix(&self) -> DMatrix<f64> {
        let size = self.rows.len();
        let mut matrix = DMatrix::zeros(size, size);
        for (row, &(i, j, sign)) in self.rows.iter().enumerate() {
            if i == j {
                matrix[(row, i)] = 1.0;
            } else {
                (matrix[(row, i)], matrix[(row, j)]) = (0.5_f64.sqrt(), sign * 0.5_f64.sqrt());
            }
        }
        matrix
    }
}

/// The problem that Newton's method solves: what its equations depend on besides the unknowns.
struct Shot {
    chain: Chain<f64>,
    tol: f64,
    /// `T_m/2`.
    half: f64,
    /// Symmetric states at the start, as columns.
    start: DMatrix<f64>,
    /// Rows that are zero for the state at `T_m/2` of an orbit; rates in units of `omega_b`.
    end: DMatrix<f64>,
    /// Row of the mean strain far from the breather.
    far: DVector<f64>,
}

impl Shot {
    fn new(breather: &MovingBreather, tol: f64) -> Result<Self> {
        let (chain, half) = (breather.chain()?, 0.5 * breather.passage());
        let MovingBreather { sites, omega_b, params: Params { rho, .. }, .. } = *breather;
        let [first, second] = mirrors(sites);
        let mut end = second.rows(2 * sites, 2 * sites).into_owned();
        end.columns_mut(2 * sites, 2 * sites).unscale_mut(omega_b);
        // Site 0 is opposite to the breather. The weights of an alternating strain add up to zero.
        let reach = sites / 8;
        let weight = |i: usize| match (i % sites).min(sites - i % sites) {
            d if d < reach => 1.0,
            d if d == reach => 0.5,
            _ => 0.0,
        };
        let arrays = [1.0 / (1.0 + rho), rho / (1.0 + rho), 0.0, 0.0];
        let far = DVector::from_fn(4 * sites, |i, _| arrays[i / sites] * weight(i) / (2 * reach) as f64);
        let start = first.rows(0, 2 * sites).transpose();
        Ok(Self { chain, tol, half, start, end, far })
    }

    fn equations(&self, at: &DVector<f64>, derivative: bool) -> Result<Equations> {
        let z = &self.start * at;
        let columns = if derivative { self.start.clone() } else { DMatrix::zeros(z.len(), 0) };
        let moment = flow(&self.chain, z.as_slice(), self.half, columns, self.tol, |_| {})?;
        let residual = &self.end * DVector::from_vec(moment.state);
        let jacobian = &self.end * moment.columns;
        let rows = jacobian.nrows();
        let mut jacobian = jacobian.insert_row(rows, 0.0);
        if derivative {
            jacobian.set_row(rows, &(self.far.transpose() * &self.start));
        }
        Ok(Equations { residual: residual.push(self.far.dot(&z)), jacobian })
    }

    /// A step of Newton's method from `at` by a share of `-by`, halved until the norm of the
    /// equations falls enough. Returns the share and the coordinates after the step; `None` where
    /// no share above [`LEAST_SHARE`] does.
    fn step(&self, at: &DVector<f64>, by: &DVector<f64>, norm: f64, longest: f64) -> Option<(f64, DVector<f64>)> {
        let mut share = (longest / by.amax()).min(1.0);
        while share > LEAST_SHARE {
            let next = at - by * share;
            let falls = |new: f64| new <= (1.0 - 0.2 * share) * norm || new <= SOLVED * longest;
            if self.equations(&next, false).is_ok_and(|equations| falls(equations.residual.norm())) {
                return Some((share, next));
            }
            share *= 0.5;
        }
        None
    }
}

/// Matrices of the two reversals: the first takes site `i`, counted from 0, to `N - i`; the second
/// one is half a site further.
fn mirrors(sites: usize) -> [DMatrix<f64>; 2] {
    [0, 1].map(|sum| Mirror::new(sites, sum).matrix())
}

/// Largest strain of the contacts.
fn strain(z: &[f64], sites: usize) -> f64 {
    max_norm(z[..sites].iter().copied())
}

impl MovingBreather {
    /// `T_m`, in which the breather moves on by a site.
    pub fn passage(&self) -> f64 {
        (f64::from(self.turns) + 0.5) * 2.0 * PI / self.omega_b
    }

    /// Sites per unit of time, `1/T_m`.
    pub fn velocity(&self) -> f64 {
        self.passage().recip()
    }

    /// The ring, after all numbers are checked.
    ///
    /// # Errors
    /// Numbers that no breather at rest can have; fewer than 9 sites or an even number of them; no
    /// turn or more than 100; `omega_b` not above `omega`.
    pub fn chain(&self) -> Result<Chain<f64>> {
        let Self { params, sites, omega_b, turns } = *self;
        self.at_rest().setting().chain()?;
        require(sites >= 9 && !sites.is_multiple_of(2), "sites", sites, "an odd number, at least 9")?;
        require((1..=MOST_TURNS).contains(&turns), "turns", turns, "from 1 to 100 whole periods")?;
        let value = format!("{omega_b}, where omega = {}", params.omega());
        require(omega_b > params.omega(), "omega_b", value, "a dark breather has a frequency above omega")?;
        Chain::new(params, Boundary::StrainRing, sites)
    }

    /// The orbit near a start `[x, y, x', y']`.
    ///
    /// # Errors
    /// Numbers outside their rules; a start of another length, not finite or zero; one whose flow
    /// fails; [`Error::Stalled`] with the best iterate where the residual does not fall to 1e-12;
    /// [`Error::Stopped`] if the work was asked to end.
    pub fn solve(&self, start: &[f64], tol: f64) -> Result<MovingOrbit> {
        let shot = Shot::new(self, tol)?;
        let Self { sites, omega_b, turns, .. } = *self;
        let rule = "four numbers a site: x, y, x', y'";
        require(start.len() == 4 * sites, "start", format!("{} numbers", start.len()), rule)?;
        let size = strain(start, sites);
        let rule = "strains are finite, and not all zero";
        require(size > 0.0 && start.iter().all(|z| z.is_finite()), "start", size, rule)?;
        let mut at = shot.start.transpose() * DVector::from_column_slice(start);
        // Flows fail when they are asked to end.
        let stopped = || Err(Error::Stopped { kept: "nothing of this breather".to_owned() });
        if interrupt::asked() {
            return stopped();
        }
        let mut now = shot.equations(&at, true)?;
        let mut newton = Vec::new();
        for _ in 0..MOST_STEPS {
            let Some(by) = least_squares(now.jacobian.clone(), &now.residual) else { break };
            newton.push(NewtonStep { residual: now.residual.amax() / size, step: by.amax() / size });
            let Some((share, next)) = shot.step(&at, &by, now.residual.norm(), LONGEST_STEP * size) else { break };
            let last = share == 1.0 && by.amax() <= LAST_STEP * size;
            let Ok(equations) = shot.equations(&next, !last) else { break };
            (at, now) = (next, equations);
            if last {
                break;
            }
        }
        let z = (&shot.start * at).as_slice().to_vec();
        let residual = now.residual.amax() / strain(&z, sites);
        if residual <= SOLVED {
            return Ok(Orbit { setting: *self, z, residual, newton });
        }
        if interrupt::asked() {
            return stopped();
        }
        let place = format!("omega_b = {omega_b}, turns = {turns}");
        let best = Box::new(Iterate { z, residual, solved: SOLVED, place });
        Err(Error::Stalled { steps: newton.len(), best: Some(best) })
    }

    /// The breather at rest of the same frequency, about the middle bond.
    pub fn at_rest(&self) -> DarkBreather {
        let Self { params, sites, omega_b, .. } = *self;
        DarkBreather { params, center: Center::Bond, sites, omega_b, c_x: 0.0 }
    }

    /// A start from the breather at rest, after the dark solitons of the nonlinear Schrödinger
    /// equation: where its amplitude is `a_n`, that of the seed is `((1 - b^2)^{1/2} a_n + i b
    /// (-1)^{n+N} a_{-N}) e^{i delta (n - 1/2)}` with `b = twist`; `delta` closes the ring. The
    /// seed moves to the right, the faster the larger `twist`.
    ///
    /// # Panics
    /// If `rest` has another number of sites.
    pub fn seed(&self, rest: &Orbit, twist: f64) -> Vec<f64> {
        let n = self.sites;
        assert_eq!(rest.setting.sites, n, "a breather on the same ring");
        let (root, delta) = ((1.0 - twist * twist).sqrt(), 2.0 * twist.asin() / n as f64);
        let middle = (n / 2) as f64 + 0.5;
        let mut z = vec![0.0; 4 * n];
        for (array, strains) in [rest.x(), rest.y()].into_iter().enumerate() {
            for (i, strain) in strains.iter().enumerate() {
                let background = if i % 2 == 0 { strains[0] } else { -strains[0] };
                let turn = Complex::from_polar(1.0, delta * (i as f64 - middle));
                let a = Complex::new(root * strain, twist * background) * turn;
                (z[array * n + i], z[(2 + array) * n + i]) = (a.re, self.omega_b * a.im);
            }
        }
        z
    }

    /// The orbit: of those that Newton's method finds from seeds of several velocities, the one
    /// with the smallest tail. The seeds that are nearest to an orbit come first, and a tail below
    /// 1 % ends the search.
    ///
    /// # Errors
    /// As [`solve`](Self::solve), and those of the breather at rest.
    ///
    /// ```
    /// use hertzchain_orbits::{Params, breathers::MovingBreather};
    /// let params = Params::new(1.5, 1.0, 1.0 / 3.0)?;
    /// let breather = MovingBreather { params, sites: 15, omega_b: 2.1, turns: 8 };
    /// let orbit = breather.orbit(1e-13)?;
    /// // S^{-1} Phi_{T_m} z = z, with the flow over the whole time.
    /// assert!(orbit.return_error(1e-13)? < 1e-10);
    /// # Ok::<(), hertzchain_orbits::Error>(())
    /// ```
    pub fn orbit(&self, tol: f64) -> Result<MovingOrbit> {
        self.chain()?;
        let rest = self.at_rest().orbit(&Shooting::default())?;
        self.from_rest(&rest, tol)
    }

    /// As [`orbit`](Self::orbit), from a breather at rest that is known.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn from_rest(&self, rest: &Orbit, tol: f64) -> Result<MovingOrbit> {
        let shot = Shot::new(self, tol)?;
        let apart = |seed: &[f64]| {
            let at = shot.start.transpose() * DVector::from_column_slice(seed);
            shot.equations(&at, false).map_or(f64::INFINITY, |equations| equations.residual.norm())
        };
        let mut seeds: Vec<(f64, Vec<f64>)> = TWISTS
            .iter()
            .map(|&twist| {
                let seed = self.seed(rest, twist);
                (apart(&seed), seed)
            })
            .collect();
        seeds.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut best, mut why): (Option<(f64, MovingOrbit)>, Option<Error>) = (None, None);
        for (_, seed) in seeds.iter().take(TRIES) {
            match self.solve(seed, tol) {
                Ok(orbit) => {
                    let tail = orbit.envelope(tol)?.tail;
                    if best.as_ref().is_none_or(|(least, _)| tail < *least) {
                        best = Some((tail, orbit));
                    }
                    if tail <= SMALL_TAIL {
                        break;
                    }
                }
                Err(error @ Error::Stalled { .. }) => why = Some(error),
                Err(error) => return Err(error),
            }
        }
        best.map(|(_, orbit)| orbit).ok_or_else(|| why.unwrap_or(Error::Stalled { steps: 0, best: None }))
    }
}

impl MovingOrbit {
    /// `max |S^{-1} Phi_{T_m} z - z|` over strains and rates, in units of the largest strain; rates are
    /// divided by `omega_b`. The flow goes over the whole time, without the symmetry.
    ///
    /// # Errors
    /// An integration that fails.
    pub fn return_error(&self, tol: f64) -> Result<f64> {
        let breather = &self.setting;
        let MovingBreather { sites: n, omega_b, .. } = *breather;
        let columns = DMatrix::zeros(self.z.len(), 0);
        let end = flow(&breather.chain()?, &self.z, breather.passage(), columns, tol, |_| {})?.state;
        let apart = |i: usize| {
            let unit = if i < 2 * n { 1.0 } else { omega_b };
            (end[i / n * n + (i % n + 1) % n] - self.z[i]) / unit
        };
        Ok(max_norm((0..self.z.len()).map(apart)) / strain(&self.z, n))
    }

    /// The relative multipliers: eigenvalues of the derivative of `S^{-1} Phi_{T_m}`. Besides those
    /// that are 1 in theory, a pair is near 1: a shift of the background's phase against the kink.
    ///
    /// # Errors
    /// An integration that fails, or eigenvalues that do not converge.
    pub fn spectrum(&self, tol: f64) -> Result<Spectrum> {
        let (breather, size) = (&self.setting, self.z.len());
        let chain = breather.chain()?;
        let columns = DMatrix::identity(size, size);
        let half = flow(&chain, &self.z, 0.5 * breather.passage(), columns, tol, |_| {})?.columns;
        let [first, second] = mirrors(breather.sites);
        let half = second * half * first.transpose();
        let linear = (breather.params.omega() * breather.passage()).cos();
        Spectrum::new(&Frame::turned(&chain, &first), &half, 0.0, &known(linear)).ok_or_else(|| {
            Error::parameter("omega_b", breather.omega_b, "no multipliers: the eigenvalues did not converge")
        })
    }

    /// Local amplitudes over the period `2 pi/omega_b` about `t = 0`.
    ///
    /// # Errors
    /// An integration that fails.
    pub fn envelope(&self, tol: f64) -> Result<Envelope> {
        let (breather, n) = (&self.setting, self.setting.sites);
        let half = PI / breather.omega_b;
        let mut run = breather.chain()?.collocation(&self.z, (0.0, half), StepControl::Tolerance(tol))?;
        let (mut a, mut mean) = (vec![Complex::from(0.0); n], vec![0.0; n]);
        for k in 0..=SAMPLES {
            let t = half * k as f64 / SAMPLES as f64;
            let state = state_at(&mut run, t)?;
            // By symmetry the half period before t = 0 is the reflection of that after it.
            let weight = if k == 0 || k == SAMPLES { 0.25 } else { 0.5 } / SAMPLES as f64;
            let turn = Complex::from_polar(2.0 * weight, breather.omega_b * t);
            for i in 0..n {
                let (x, before) = (state[i], state[(n - i) % n]);
                a[i] += turn * x + turn.conj() * before;
                mean[i] += weight * (x + before);
            }
        }
        Ok(Envelope::new(&a, mean))
    }
}

impl Envelope {
    /// From complex amplitudes `a_n` and means; the kink is on the middle bond.
    fn new(a: &[Complex<f64>], mean: Vec<f64>) -> Self {
        let n = a.len();
        let amplitude: Vec<f64> = a.iter().map(|a| a.norm()).collect();
        let sign = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let phase = a.iter().enumerate().map(|(i, a)| (a * sign(i)).arg()).collect();
        // Sites up to a quarter of the ring from site 0, which is opposite to the kink.
        let far: Vec<f64> = (0..n).filter(|i| 4 * i.min(&(n - i)) <= n).map(|i| amplitude[i]).collect();
        let background = far.iter().sum::<f64>() / far.len() as f64;
        let (least, most) = far.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), &r| (a.min(r), b.max(r)));
        let depth = 0.5 * (amplitude[n / 2] + amplitude[n / 2 + 1]) / background;
        Self { tail: (most - least) / background, amplitude, phase, mean, background, depth }
    }
}

/// Position of a dip of amplitudes on a ring, in sites from the first: the angle of the sum of all
/// sites, weighted by how far their amplitudes lie below `background`. Of the positions that differ
/// by turns round the ring it is the one nearest to `before`.
pub fn centre(amplitudes: &[f64], background: f64, before: f64) -> f64 {
    let length = amplitudes.len() as f64;
    let angle = |i: usize| 2.0 * PI * i as f64 / length;
    let weight = |r: f64| (1.0 - r / background).max(0.0).powi(4);
    let moment: Complex<f64> =
        amplitudes.iter().enumerate().map(|(i, &r)| Complex::from_polar(weight(r), angle(i))).sum();
    let position = moment.arg() / (2.0 * PI) * length;
    position - length * ((position - before) / length).round()
}
