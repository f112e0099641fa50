//! Periodic orbits of driven, damped chains: fixed points of the stroboscopic map.
//!
//! | symbol | meaning |
//! |---|---|
//! | `omega, T` | fundamental frequency of the drive, and its period `2 pi/omega` |
//! | `P` | stroboscopic map: the flow over `T`, from phase zero of the drive |
//! | `m` | periods of the drive in a period of the orbit |
//! | `q` | displacements of beads that no drive moves, and of resonators |
//! | `z = (q, q'/omega)` | unknowns, at `t = 0` |
//! | `M` | derivative of `P^m` at the orbit; its eigenvalues `lambda` are the multipliers |
//! | `gamma` | `sum (c_n + d_n)/m_n + d_n/(rho_n m_n)`, of drag and dashpots of resonators |
//! | `Gamma` | integral of `sum_b c(g_b) sum_n 1/m_n` over the orbit, contacts that dissipate |
//!
//! The equations are `P^m(z) - z = 0`. There is no free phase: the drive has one. By Liouville
//! `det M = exp(-gamma m T - Gamma)`. The tangent map is that of contact collocation, or of
//! [`Variations`] where contacts dissipate.

use super::{
    eigen::eigen,
    floquet::or_infinite,
    shooting::{Equations, Newton, Orbit},
};
use crate::{
    chain::{Chain, Details, Drive, DriveKind, Envelope, State, Variations, max_norm},
    error::{Error, NOTHING, Result, require},
    interrupt,
    named::named,
    numerics::extremes,
    run::{
        Observables, Run,
        method::{Contacts, Method},
    },
};
use hertzchain_integrators::{collocation::StepControl, law::BondLaw};
use nalgebra::{Complex, DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

named! {
    /// A number of a driven chain that can vary along a branch of orbits.
    #[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
    #[cfg_attr(feature = "cli", value(rename_all = "snake_case"))]
    pub enum DriveParameter {
        /// Amplitude of the first harmonic that has a frequency; other such harmonics keep their
        /// ratio to it.
        Amplitude = "amplitude", "drive amplitude a";
        /// Fundamental frequency; all harmonics keep their ratio to it.
        Omega = "omega", "drive frequency ω";
        /// Common factor of all drags and dashpots, and of the dissipation constants of contacts.
        Damping = "damping", "factor of damping";
    }
    /// The symbol in pictures.
    pub fn symbol
}

impl DriveParameter {
    /// The rule for its values.
    pub fn check(self, value: f64) -> Result<()> {
        let (good, rule) = match self {
            Self::Amplitude => (value != 0.0, "finite, and not zero"),
            Self::Omega => (value > 0.0, "a frequency is finite and positive"),
            Self::Damping => (value >= 0.0, "a factor is finite and at least zero"),
        };
        require(value.is_finite() && good, self.name(), value, rule)
    }
}

/// A driven chain, and the period of its orbit.
#[derive(Clone, Debug)]
pub struct DrivenSetting {
    /// The chain without details.
    bare: Chain<f64>,
    /// Details at the reference values of the parameters; drives have no envelopes.
    details: Details,
    /// Reference values of amplitude and frequency, which `details` has.
    reference: [f64; 2],
    /// Values of amplitude, frequency and factor of damping.
    values: [f64; 3],
    turns: u32,
    /// Entries of a state that are free displacements.
    free: Vec<usize>,
}

/// Largest number of periods of the drive in a period of an orbit.
const MOST_TURNS: u32 = 64;
/// Largest number of contacts.
const MOST_CONTACTS: usize = 256;
/// The fundamental frequency of a drive is its least one divided by a whole number up to this;
/// otherwise the drive does not count as periodic.
const MOST_SUBDIVISIONS: u32 = 64;
/// Largest relative error of a frequency that counts as a multiple of the fundamental one.
const COMMENSURATE: f64 = 1e-9;

/// The largest frequency of which all in `omegas` are multiples; `None` if there is none within
/// [`MOST_SUBDIVISIONS`].
fn fundamental(omegas: &[f64]) -> Option<f64> {
    let least = omegas.iter().copied().filter(|omega| *omega > 0.0).fold(f64::INFINITY, f64::min);
    let multiple = |omega: f64, of: f64| ((omega / of).round() * of - omega).abs() <= COMMENSURATE * omega;
    let candidates = (1..=MOST_SUBDIVISIONS).map(|k| least / f64::from(k));
    candidates.filter(|of| of.is_finite()).find(|of| omegas.iter().all(|&omega| multiple(omega, *of)))
}

impl DrivenSetting {
    /// The orbit of `turns` periods of the drive, on this chain. Ramps are taken at their full
    /// height.
    ///
    /// # Errors
    /// A chain without a drive, or whose drives are bursts, or have frequencies that are no
    /// multiples of one; a strain ring; `alpha <= 1`; more than 256 contacts; `turns` outside 1 to
    /// 64.
    pub fn new(chain: &Chain<f64>, turns: u32) -> Result<Self> {
        let refused = |value: &str| Error::parameter("drive", value, "an orbit needs a periodic drive");
        let Some(details) = chain.details().filter(|details| !details.drives.is_empty()) else {
            return Err(refused(NOTHING));
        };
        require((1..=MOST_TURNS).contains(&turns), "turns", turns, "from 1 to 64 periods of the drive")?;
        let contacts = chain.touching().len();
        require(contacts <= MOST_CONTACTS, "contacts", contacts, "at most 256 contacts for a tangent map")?;
        let mut details = details.clone();
        for drive in &mut details.drives {
            if drive.signal.course.is_some() {
                return Err(refused("a chirp, a steady motion, or values at times"));
            }
            if let Envelope::Burst { .. } | Envelope::HalfSine { .. } = drive.signal.envelope {
                return Err(refused("a burst"));
            }
            drive.signal.envelope = Envelope::None;
        }
        let harmonics = |details: &Details| -> Vec<_> {
            details.drives.iter().flat_map(|drive| drive.signal.harmonics.clone()).collect()
        };
        let all = harmonics(&details);
        let omegas: Vec<f64> = all.iter().map(|harmonic| harmonic.omega).collect();
        let omega = fundamental(&omegas)
            .ok_or_else(|| refused("frequencies that are no multiples of one, as those of noise"))?;
        // Some harmonic has a frequency, since there is a fundamental one.
        let amplitude = all.iter().find(|harmonic| harmonic.omega > 0.0).map_or(0.0, |harmonic| harmonic.amplitude);
        DriveParameter::Amplitude.check(amplitude)?;
        // The overlaps at rest include a uniform precompression, which `bare` does not have.
        let (n, rest) = (chain.sites(), chain.overlaps(&vec![0.0; chain.sites()]));
        details.overlap = chain.touching().map(|bond| rest[bond]).collect();
        let bare = Chain::new(chain.params(), chain.boundary(), n)?;
        let moved =
            |i: usize| details.drives.iter().any(|drive| drive.site == i && drive.kind == DriveKind::Displacement);
        let beads = (0..n).filter(|&i| !moved(i));
        let resonators = (0..n).filter(|&i| chain.resonator_moves(i)).map(|i| n + i);
        let free: Vec<usize> = beads.chain(resonators).collect();
        require(!free.is_empty(), "drive", "moves every bead", "an orbit needs a bead that is free")?;
        let setting =
            Self { bare, details, reference: [amplitude, omega], values: [amplitude, omega, 1.0], turns, free };
        Variations::new(&setting.chain()?, 0)?;
        Ok(setting)
    }

    /// The chain, with its drives at their full height.
    ///
    /// # Errors
    /// A parameter outside its rule.
    pub fn chain(&self) -> Result<Chain<f64>> {
        for parameter in DriveParameter::ALL {
            parameter.check(self.get(parameter))?;
        }
        let mut details = self.details.clone();
        let [amplitude, omega] = [0, 1].map(|k| self.values[k] / self.reference[k]);
        let harmonics = details.drives.iter_mut().flat_map(|Drive { signal, .. }| &mut signal.harmonics);
        for harmonic in harmonics.filter(|harmonic| harmonic.omega > 0.0) {
            harmonic.amplitude *= amplitude;
            harmonic.omega *= omega;
        }
        let contacts = details.dissipation.iter_mut().flat_map(|loss| &mut loss.strength);
        for loss in details.drag.iter_mut().chain(&mut details.dashpot).chain(contacts) {
            *loss *= self.values[2];
        }
        self.bare.clone().with(&details)
    }

    /// The value of a parameter.
    pub fn get(&self, parameter: DriveParameter) -> f64 {
        self.values[parameter as usize]
    }

    /// The setting with another value of a parameter, which is not checked.
    #[must_use]
    pub fn with(&self, parameter: DriveParameter, value: f64) -> Self {
        let mut setting = self.clone();
        setting.values[parameter as usize] = value;
        setting
    }

    /// What the drive does whose amplitude is the parameter: it moves its bead or pushes it.
    pub fn drive_kind(&self) -> DriveKind {
        let varies = |drive: &&Drive| drive.signal.harmonics.iter().any(|harmonic| harmonic.omega > 0.0);
        self.details.drives.iter().find(varies).map_or(DriveKind::Displacement, |drive| drive.kind)
    }

    /// Periods of the drive in a period of the orbit.
    pub fn turns(&self) -> u32 {
        self.turns
    }

    /// The same chain with twice the period of the orbit.
    ///
    /// # Errors
    /// More than 64 periods of the drive.
    pub fn doubled(&self) -> Result<Self> {
        let turns = 2 * self.turns;
        require(turns <= MOST_TURNS, "turns", turns, "from 1 to 64 periods of the drive")?;
        Ok(Self { turns, ..self.clone() })
    }

    /// Fundamental frequency of the drive.
    pub fn omega(&self) -> f64 {
        self.get(DriveParameter::Omega)
    }

    /// Period of the orbit, `m T`.
    pub fn period(&self) -> f64 {
        f64::from(self.turns) * 2.0 * PI / self.omega()
    }

    /// Number of sites, including those of beads that a drive moves.
    pub fn sites(&self) -> usize {
        self.bare.sites()
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        2 * self.free.len()
    }

    /// Beads that no drive moves.
    pub fn free_beads(&self) -> impl Iterator<Item = usize> + '_ {
        self.free.iter().copied().take_while(|&i| i < self.bare.sites())
    }

    /// `gamma`, minus the divergence of the vector field without contacts.
    ///
    /// # Errors
    /// A parameter outside its rule.
    pub fn contraction(&self) -> Result<f64> {
        let chain = self.chain()?;
        let of = |list: &[f64], i: usize| list.get(i).copied().unwrap_or(0.0);
        let details = chain.details().cloned().unwrap_or_default();
        let site = |i: usize| {
            let [mass, resonator] = chain.masses(i);
            let (drag, dashpot) = (of(&details.drag, i), of(&details.dashpot, i));
            let inner = if chain.resonator_moves(i) { dashpot / resonator } else { 0.0 };
            (drag + dashpot) / mass + inner
        };
        Ok(self.free_beads().map(site).sum())
    }

    /// The state at `t = 0` with the given unknowns.
    fn start(&self, chain: &Chain<f64>, z: &[f64]) -> Vec<f64> {
        let (half, omega) = (chain.layout().half(), self.omega());
        let mut state = State::rest(chain).driven(chain).as_slice().to_vec();
        let (q, q_dot) = z.split_at(self.free.len());
        for ((&i, q), q_dot) in self.free.iter().zip(q).zip(q_dot) {
            (state[i], state[half + i]) = (*q, omega * q_dot);
        }
        state
    }

    /// The unknowns of a state.
    fn unknowns_of(&self, chain: &Chain<f64>, state: &[f64]) -> DVector<f64> {
        let (half, omega) = (chain.layout().half(), self.omega());
        let q = self.free.iter().map(|&i| state[i]);
        let q_dot = self.free.iter().map(|&i| state[half + i] / omega);
        DVector::from_iterator(self.unknowns(), q.chain(q_dot))
    }

    /// Unit of residuals: the largest unknown or, if it is larger, [`ROUNDED`] times the largest
    /// static overlap, since rounding errors of overlaps limit the accuracy of positions, or what a
    /// push moves a bead at least, since the state of a large orbit may be nearly zero at `t = 0`.
    pub(super) fn size(&self, z: &[f64]) -> f64 {
        let overlap = self.details.overlap.iter().copied().fold(0.0, f64::max);
        max_norm(z.iter().copied()).max(ROUNDED * overlap).max(self.pushed(z).unwrap_or(0.0))
    }

    /// The largest force of a drive, over the mass of its bead and the square of the fastest rate.
    fn pushed(&self, z: &[f64]) -> Result<f64> {
        let (chain, rate) = (self.chain()?, self.fastest_rate(z)? * 2.0 * PI / self.period());
        let drives = chain.details().into_iter().flat_map(|details| &details.drives);
        let pushes = drives.filter(|drive| drive.kind == DriveKind::Force);
        Ok(max_norm(pushes.map(|drive| drive.signal.size() / (chain.masses(drive.site)[0] * rate * rate))))
    }

    /// Largest residual of an orbit, in units of [`size`](Self::size): [`SOLVED`], or what the
    /// tolerance of the flow allows. With the fastest rate `R`, in units of the frequency of the
    /// orbit, the period has some `2 pi R` steps. Each errs by `tol s` in displacements, where `s`
    /// is the largest of the unknowns, static overlaps and moved beads: these sum to at most
    /// `2 pi R tol s`. Velocities then err by `R omega tol s`, and the unknowns `q'/omega` by
    /// `R tol s`.
    pub(super) fn solved(&self, z: &[f64], tol: f64) -> f64 {
        let overlap = self.details.overlap.iter().copied().fold(0.0, f64::max);
        let state = max_norm(z.iter().copied()).max(overlap).max(self.moved().unwrap_or(0.0));
        let radians = 2.0 * PI * self.fastest_rate(z).unwrap_or(0.0);
        SOLVED.max(tol * radians * state / self.size(z))
    }

    /// Largest displacement of a bead that a drive moves.
    fn moved(&self) -> Result<f64> {
        Ok(self.chain()?.details().map_or(0.0, |details| {
            let moved = details.drives.iter().filter(|drive| drive.kind == DriveKind::Displacement);
            moved.map(|drive| drive.signal.size()).fold(0.0, f64::max)
        }))
    }

    /// A bound of the rates in a chain whose unknowns are as large as `z`, in units of the
    /// frequency of the orbit: frequencies of contacts and resonators, rates of damping, harmonics
    /// of drives.
    pub fn fastest_rate(&self, z: &[f64]) -> Result<f64> {
        let (chain, reach) = (self.chain()?, 2.0 * max_norm(z.iter().copied()).max(self.moved()?));
        let (params, details) = (chain.params(), chain.details().cloned().unwrap_or_default());
        let of = |list: &[f64], i: usize, uniform: f64| list.get(i).copied().unwrap_or(uniform);
        let inverse = |mass: f64| if mass > 0.0 { 1.0 / mass } else { 0.0 };
        let per_mass = max_norm(self.free_beads().map(|i| inverse(chain.masses(i)[0])));
        // By Gershgorin, as a bead has two contacts.
        let contacts = details.overlap.iter().enumerate().map(|(k, &rest)| {
            let law: BondLaw<f64> = details.law(k, params.alpha, rest);
            let further = details.terms.iter().map(|term| term.law::<f64>(k).stiffness(rest + reach)).sum::<f64>();
            let stiffness = law.stiffness(rest + reach) + further + details.joint::<f64>(k).stiffness_within(reach);
            [stiffness, law.resistance(rest + reach)].map(|one| 4.0 * one * per_mass)
        });
        let sites = (0..self.sites()).map(|i| {
            let [bead, both] = [inverse(chain.masses(i)[0]), chain.masses(i).map(inverse).iter().sum()];
            let damping = of(&details.drag, i, 0.0) * bead + of(&details.dashpot, i, 0.0) * both;
            let springs = of(&details.kappa, i, params.kappa) * both + of(&details.onsite, i, 0.0) * bead;
            [springs, damping]
        });
        let largest = |[a, b]: [f64; 2], [x, y]: [f64; 2]| [a.max(x), b.max(y)];
        let (contacts, sites) = (contacts.fold([0.0; 2], largest), sites.fold([0.0; 2], largest));
        let [squared, damping] = [0, 1].map(|k| contacts[k] + sites[k]);
        let harmonics = details.drives.iter().flat_map(|drive| &drive.signal.harmonics).map(|one| one.omega);
        Ok(max_norm(harmonics.chain([squared.sqrt(), damping])) * self.period() / (2.0 * PI))
    }
}

/// Settings of the search for a driven orbit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DrivenShooting {
    /// Tolerance of a step of the flow.
    pub tol: f64,
    /// Tolerance of the run by contact collocation that the tangent map follows, of a step of the
    /// tangent map where contacts dissipate, and of a step of [samples](DrivenOrbit::samples).
    pub tangent_tol: f64,
    /// Largest number of steps of Newton's method.
    pub most_steps: usize,
}

impl Default for DrivenShooting {
    fn default() -> Self {
        Self { tol: 1e-14, tangent_tol: 1e-11, most_steps: 30 }
    }
}

/// A periodic orbit of a driven chain, with `z = (q, q'/omega)` and the residual `max |P^m(z) - z|`
/// in units of the largest of: `|z|`, moved beads, a hundredth of the largest static overlap, what
/// pushes move beads at least.
pub type DrivenOrbit = Orbit<DrivenSetting>;

/// Largest residual of an orbit, in its unit, unless [errors of the flow](DrivenSetting::solved)
/// are larger.
const SOLVED: f64 = 1e-11;
/// Share of the largest static overlap that is the least unit of residuals: [`SOLVED`] is then some
/// 450 roundings of the overlap.
const ROUNDED: f64 = 1e-2;
/// Longest step of Newton's method, in the unit of residuals.
const LONGEST_STEP: f64 = 0.5;
/// Tolerance of the second estimate of a monodromy matrix, in units of that of the first.
const FINER: f64 = 1e-2;
/// Error of the eigenvalues' algorithm, in roundings of the largest entry. Chosen, not measured.
const EIGEN: f64 = 4.0;
/// Largest change of the unknowns over a period of an orbit, in units of the largest displacement
/// or scaled velocity, for which the orbit counts as one of that period.
const RETURNED: f64 = 1e-8;
/// Largest rate of contacts, resonators, damping and drives of an orbit in a file, in units of its
/// frequency.
const FASTEST: f64 = 1e5;

/// Refuses an orbit from a file whose integration may take too long, by its fastest `rate` in units
/// of its frequency, or that is `off` by too much after a period.
pub fn returns(rate: f64, off: impl FnOnce() -> Result<f64>) -> Result<()> {
    let rule = "contacts, resonators, damping and drives of an orbit are at most 10^5 times as fast as it is";
    require(rate <= FASTEST, "rates", format!("up to {rate:.1e}"), rule)?;
    let off = off()?;
    require(off <= RETURNED, "residual", off, "an orbit returns to 1e-8")
}
/// A run has settled if a period changes the unknowns by at most this, in units of the largest.
const SETTLED: f64 = 1e-8;
/// Tolerance of a step of the run that settles.
const SETTLE_TOL: f64 = 1e-9;
/// Number of samples in a period of the drive.
const SAMPLES: u32 = 64;

impl DrivenShooting {
    /// `P^m(z) - z`, with its derivative if `derivative`.
    pub(super) fn equations(&self, setting: &DrivenSetting, z: &[f64], derivative: bool) -> Result<Equations> {
        let chain = setting.chain()?;
        let start = setting.start(&chain, z);
        let span = (0.0, setting.period());
        let end = Variations::flow(&chain, &start, span, &[], self.tol)?;
        let residual = setting.unknowns_of(&chain, &end.state) - DVector::from_column_slice(z);
        let unknowns = setting.unknowns();
        let jacobian = if derivative {
            self.monodromy(setting, z)?.0 - DMatrix::identity(unknowns, unknowns)
        } else {
            DMatrix::zeros(unknowns, 0)
        };
        Ok(Equations { residual, jacobian })
    }

    /// `M`, and bounds for the errors of its entries: the distance from `M` at a finer tolerance,
    /// that tolerance in units of `|M|`, and a rounding for each radian of the fastest motion;
    /// `Gamma`.
    fn checked_monodromy(&self, setting: &DrivenSetting, z: &[f64]) -> Result<(DMatrix<f64>, DMatrix<f64>, f64)> {
        let (first, contacts) = self.monodromy(setting, z)?;
        let (radians, size) = (2.0 * PI * setting.fastest_rate(z)?, first.norm());
        let fine = Self { tangent_tol: FINER * self.tangent_tol, ..*self };
        let least = (fine.tangent_tol + f64::EPSILON * EIGEN) * size;
        let errors = match fine.monodromy(setting, z) {
            Ok((finer, _)) => first
                .zip_map(&finer, |entry, finer| (entry - finer).abs() + f64::EPSILON * radians * entry.abs() + least),
            Err(_) => first.map(|_| f64::INFINITY),
        };
        Ok((first, errors, contacts))
    }

    /// `M`, the derivative of `P^m` by `z`, and `Gamma`: by [`Variations`] where contacts
    /// dissipate, else by contact collocation.
    fn monodromy(&self, setting: &DrivenSetting, z: &[f64]) -> Result<(DMatrix<f64>, f64)> {
        let chain = setting.chain()?;
        let (half, omega, m) = (chain.layout().half(), setting.omega(), setting.free.len());
        let (start, dim) = (setting.start(&chain, z), chain.layout().dim());
        let span = (0.0, setting.period());
        // Unknown `k` is the displacement `free[k]`; unknown `m + k` its velocity over omega.
        let place = |k: usize| match k.checked_sub(m) {
            None => (setting.free[k], 1.0),
            Some(k) => (half + setting.free[k], omega),
        };
        if chain.dissipative_contacts() || chain.beyond_collocation().is_some() {
            let mut unit = vec![0.0; 2 * half * 2 * m];
            for j in 0..2 * m {
                let (row, per) = place(j);
                unit[row * 2 * m + j] = per;
            }
            let end = Variations::flow(&chain, &start, span, &unit, self.tangent_tol)?;
            let entry = |k: usize, j: usize| {
                let (row, unit) = place(k);
                end.columns[row * 2 * m + j] / unit
            };
            return Ok((DMatrix::from_fn(2 * m, 2 * m, entry), end.contraction));
        }
        let columns = chain.monodromy(&start, span, StepControl::Tolerance(self.tangent_tol))?;
        let entry = |k: usize, j: usize| {
            let ((row, unit), (column, per)) = (place(k), place(j));
            columns[column * dim + row] * per / unit
        };
        Ok((DMatrix::from_fn(2 * m, 2 * m, entry), 0.0))
    }

    /// The unknowns after a run of `chain`, with its ramps, from `state` at `t = 0`. The run takes
    /// as many periods of the orbit as the longest ramp needs, and `periods` more; it ends earlier
    /// if it has become periodic. `seen` is told the share that is done.
    ///
    /// # Errors
    /// An integration that fails; a signal.
    pub fn settle(
        &self,
        setting: &DrivenSetting,
        chain: &Chain<f64>,
        state: &State<f64>,
        periods: u32,
        seen: impl Fn(f64),
    ) -> Result<Vec<f64>> {
        let period = setting.period();
        let ramps = chain.details().into_iter().flat_map(|details| &details.drives);
        let ramp = ramps.map(|drive| drive.signal.settled()).fold(0.0, f64::max);
        let first = (ramp / period).ceil() as u32;
        let mut y = state.as_slice().to_vec();
        let mut z = setting.unknowns_of(chain, &y);
        for k in 0..first + periods {
            if interrupt::asked() {
                return Err(Error::Stopped { kept: "nothing of this orbit".to_owned() });
            }
            seen(f64::from(k) / f64::from(first + periods));
            let span = (f64::from(k) * period, f64::from(k + 1) * period);
            y = Variations::flow(chain, &y, span, &[], SETTLE_TOL)?.state;
            let next = setting.unknowns_of(chain, &y);
            let settled = k >= first && (&next - &z).amax() <= SETTLED * next.amax();
            z = next;
            if settled {
                break;
            }
        }
        Ok(z.as_slice().to_vec())
    }

    /// The orbit near the unknowns `seed`.
    ///
    /// # Errors
    /// A seed of another length or not finite; a seed whose flow fails; [`Error::Stalled`] with the
    /// best iterate where the residual of Newton's method does not fall to 1e-11 or, if that is
    /// larger, to a step's tolerance for each radian of the fastest motion over the period.
    pub fn solve(&self, setting: &DrivenSetting, seed: &[f64]) -> Result<DrivenOrbit> {
        let rule = "a displacement and a velocity for each free bead and resonator";
        require(seed.len() == setting.unknowns(), "seed", format!("{} numbers", seed.len()), rule)?;
        require(seed.iter().all(|z| z.is_finite()), "seed", "not finite", "a seed is finite")?;
        let drives = setting.moved()?;
        // All these sizes can be zero where the chain is at rest; the unit is then the residual.
        let size = |z: &DVector<f64>, residual: &DVector<f64>| match setting.size(z.as_slice()).max(drives) {
            0.0 => residual.amax().max(f64::MIN_POSITIVE),
            size => size,
        };
        Newton {
            most_steps: self.most_steps,
            longest: LONGEST_STEP,
            equations: &|z, derivative| self.equations(setting, z, derivative),
            size: &size,
            solved: &|z| setting.solved(z, self.tol),
            place: format!("omega = {}, amplitude = {}", setting.omega(), setting.values[0]),
        }
        .solve(setting, seed)
    }
}

/// A multiplier of a driven orbit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DrivenMultiplier {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// Modulus.
    pub modulus: f64,
    /// Bound for the error of the multiplier as an eigenvalue of the linearised flow along the
    /// computed orbit, to first order in the error of the derivative of `P^m`.
    #[serde(deserialize_with = "or_infinite")]
    pub error: f64,
}

/// The multipliers of a driven orbit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DrivenSpectrum {
    /// All of them, the largest modulus first, with conjugates next to each other.
    pub multipliers: Vec<DrivenMultiplier>,
    /// `|ln |det M| + gamma m T + Gamma|`, the error of Liouville's formula: zero in theory.
    #[serde(deserialize_with = "or_infinite")]
    pub liouville: f64,
}

/// Multipliers with a modulus up to `1 + MARGIN` do not count as outside the circle: beads that no
/// contact holds have the multiplier 1, up to roundings.
pub(super) const MARGIN: f64 = 1e-7;

impl DrivenSpectrum {
    /// The multipliers of a matrix with these bounds `E` for the errors of its entries.
    ///
    /// With right and left eigenvectors `x` and `y` an eigenvalue errs by `|y|^T E |x| / |y^H x|`.
    /// Two that meet err by at most `(|M| |E|)^{1/2}`.
    fn new(monodromy: &DMatrix<f64>, errors: &DMatrix<f64>, exponent: f64) -> Option<Self> {
        let (values, vectors): (Vec<_>, Vec<_>) = eigen(monodromy)?.into_iter().unzip();
        let right = DMatrix::from_columns(&vectors);
        let most = (monodromy.norm() * errors.norm()).sqrt();
        let each = right.clone().try_inverse().map(|left| left.map(Complex::norm) * errors * right.map(Complex::norm));
        let error = |k: usize| each.as_ref().map_or(most, |each| each[(k, k)].min(most));
        let of = |(k, value): (usize, Complex<f64>)| DrivenMultiplier {
            re: value.re,
            im: value.im,
            modulus: value.norm(),
            error: error(k),
        };
        let mut multipliers: Vec<DrivenMultiplier> = values.into_iter().enumerate().map(of).collect();
        multipliers
            .sort_by(|a, b| b.modulus.total_cmp(&a.modulus).then(b.re.total_cmp(&a.re)).then(b.im.total_cmp(&a.im)));
        let lu = monodromy.clone().lu();
        let log: f64 = lu.u().diagonal().iter().map(|pivot| pivot.abs().ln()).sum();
        Some(Self { multipliers, liouville: (log + exponent).abs() })
    }

    /// Number of multipliers outside the circle of radius `1 + 10^-7`.
    pub fn unstable(&self) -> usize {
        self.multipliers.iter().filter(|one| one.modulus > 1.0 + MARGIN).count()
    }

    /// The largest modulus.
    pub fn largest(&self) -> f64 {
        self.multipliers.first().map_or(0.0, |one| one.modulus)
    }
}

impl DrivenOrbit {
    /// The state at `t = 0`.
    ///
    /// # Errors
    /// A parameter of the setting outside its rule.
    pub fn start(&self) -> Result<State<f64>> {
        let chain = self.setting.chain()?;
        let mut state = State::rest(&chain);
        state.as_mut_slice().copy_from_slice(&self.setting.start(&chain, &self.z));
        Ok(state)
    }

    /// The multipliers.
    ///
    /// # Errors
    /// An integration that fails, or eigenvalues that do not converge.
    pub fn spectrum(&self, shooting: &DrivenShooting) -> Result<DrivenSpectrum> {
        let (monodromy, errors, contacts) = shooting.checked_monodromy(&self.setting, &self.z)?;
        let exponent = self.setting.contraction()? * self.setting.period() + contacts;
        DrivenSpectrum::new(&monodromy, &errors, exponent).ok_or_else(|| {
            let rule = "no multipliers: the eigenvalues did not converge";
            Error::parameter("omega", self.setting.omega(), rule)
        })
    }

    /// States at 64 equal times of each period of the drive, from `t = 0` to the end of the orbit.
    ///
    /// # Errors
    /// An integration that fails.
    pub fn samples(&self, shooting: &DrivenShooting) -> Result<Vec<Vec<f64>>> {
        let (chain, period) = (self.setting.chain()?, self.setting.period());
        let count = SAMPLES * self.setting.turns;
        let time = |k: u32| period * f64::from(k) / f64::from(count);
        let mut samples = vec![self.setting.start(&chain, &self.z)];
        for k in 0..count {
            let last = &samples[k as usize];
            let next = Variations::flow(&chain, last, (time(k), time(k + 1)), &[], shooting.tangent_tol)?.state;
            samples.push(next);
        }
        Ok(samples)
    }

    /// Periods of the drive in the least period of the orbit, from [`samples`](Self::samples): less
    /// than `turns` if the orbit has also been solved for as one of a shorter period.
    ///
    /// # Errors
    /// A parameter of the setting outside its rule.
    pub fn least_turns(&self, samples: &[Vec<f64>]) -> Result<u32> {
        let (setting, chain) = (&self.setting, self.setting.chain()?);
        let start = DVector::from_column_slice(&self.z);
        let returns = |turns: &u32| {
            let now = setting.unknowns_of(&chain, &samples[(turns * SAMPLES) as usize]);
            (now - &start).amax() <= RETURNED * setting.size(&self.z)
        };
        let divides = |turns: &u32| setting.turns.is_multiple_of(*turns);
        Ok((1..setting.turns).filter(divides).find(returns).unwrap_or(setting.turns))
    }

    /// Refuses numbers that are not those of an orbit. Rates are checked first, so that the
    /// residual is measured within seconds on a short chain.
    pub(super) fn verify(&self, shooting: &DrivenShooting) -> Result<()> {
        let size = self.setting.size(&self.z).max(self.setting.moved()?);
        returns(self.setting.fastest_rate(&self.z)?, || {
            Ok(shooting.equations(&self.setting, &self.z, false)?.residual.amax() / size)
        })
    }

    /// Unknowns after half of the orbit's periods of the drive (an even number) less those at
    /// `t = 0`.
    pub(super) fn halves_apart(&self, shooting: &DrivenShooting) -> Result<DVector<f64>> {
        let (setting, chain) = (&self.setting, self.setting.chain()?);
        let start = setting.start(&chain, &self.z);
        let middle = f64::from(setting.turns / 2) * setting.period() / f64::from(setting.turns);
        let end = Variations::flow(&chain, &start, (0.0, middle), &[], shooting.tol)?.state;
        Ok(setting.unknowns_of(&chain, &end) - DVector::from_column_slice(&self.z))
    }

    /// Half the range of each bead's displacement over the orbit, moved beads included, and of each
    /// strain between neighbours: of the solution, whose extremes are near those of
    /// [`samples`](Self::samples).
    ///
    /// # Errors
    /// An integration that fails.
    pub fn ranges(&self, samples: &[Vec<f64>], shooting: &DrivenShooting) -> Result<[Vec<f64>; 2]> {
        let n = self.setting.sites();
        let values = move |y: &[f64], k: usize| if k < n { y[k] } else { y[k - n + 1] - y[k - n] };
        let seen = |k: usize| extremes(samples.iter().map(|y| values(y, k)));
        let seen: Vec<(f64, f64)> = (0..2 * n - 1).map(seen).collect();
        // Both ends of what is seen are 1 here: values beyond it are above 1.
        let (width, within) = (|(low, high): (f64, f64)| high - low, seen.clone());
        let observables = Observables::new(move |y, out| {
            for (k, &(low, high)) in within.iter().enumerate().filter(|(_, seen)| width(**seen) > 0.0) {
                let x = (values(y, k) - low) / (high - low);
                out.extend([x, 1.0 - x]);
            }
        });
        let run = Run::new(self.setting.chain()?, self.start()?).until(self.setting.period())?.samples(0)?;
        let run = run.method(Method::Dop853(Contacts::Regularised)).tolerance(shooting.tol)?;
        let mut beyond = run.observables(observables).start()?.complete()?.extremes.into_iter().map(|(_, most)| most);
        let half = |seen| match width(seen) {
            0.0 => 0.0,
            width => 0.5 * width * (beyond.next().unwrap_or(1.0) + beyond.next().unwrap_or(1.0) - 1.0),
        };
        let mut ranges: Vec<f64> = seen.into_iter().map(half).collect();
        let strains = ranges.split_off(n);
        Ok([ranges, strains])
    }

    /// Half the range of the displacement of the free bead that moves most, of these
    /// [`ranges`](Self::ranges) of beads.
    pub fn amplitude(&self, beads: &[f64]) -> f64 {
        max_norm(self.setting.free_beads().map(|i| beads[i]))
    }
}
