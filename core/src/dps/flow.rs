//! The modulation equations as flows: generalised DpS (eq:S1new), (eq:S2new), (eq:S1newS), and DpS
//! (eq:DpSlr).
//!
//! | symbol | meaning |
//! |---|---|
//! | `tau` | slow time `epsilon^{alpha-1} t` |
//! | `A_n` | complex amplitude of site `n` |
//! | `D_n, r_n` | `(delta^- A)_n = A_n - A_{n-1}` and `abs(D_n)` |
//! | `b_n` | `delta^- B_n`, the mean strain of the bond before site `n` |
//! | `C` | the mean force `g_alpha(b_n, r_n)`, the same in every bond |
//! | `sigma` | coupling of a bond: `h_alpha / (2 omega^3)`, or `omega_0 r^{alpha-1}` |
//!
//! Both equations are `i dA/dtau = delta^+ [sigma D]`, and `i dD/dtau = delta^- delta^+ [sigma D]`
//! in the strain form.
//!
//! # Structure
//!
//! The mean potential of a bond,
//! `W(b, r) = 1/(2 pi) int_0^{2 pi} (-b + 2 kappa r cos t)_+^{alpha+1} / (alpha+1) dt`, has the
//! slopes `dW/db = -g_alpha` and `dW/dr = 2 kappa r h_alpha`. For a given `C`, let `E = W + C b` (a
//! Legendre transform: `dE = (C - g) db + 2 kappa r h dr`); for a given `sum b_n`, let `E = W`.
//! Where the `b_n` obey the constraint, `sum E` has the slope `2 kappa r_n h_alpha` in each `r_n`,
//! and derivatives of `b_n` and `C` do not enter. Hence
//!
//! ```text
//! i dA_n/dtau = - dH / d conj(A_n),      H = 1 / (2 kappa omega^3) sum_n E(r_n)
//! ```
//!
//! and `H`, `sum |A_n|^2` (phase) and `sum A_n` (translation) are conserved. `W` is homogeneous of
//! degree `alpha + 1`, so Euler's identity gives `W` without another integral:
//! `(alpha+1) W = 2 kappa r (r h_alpha) - b g_alpha`. DpS has
//! `H = 2 omega_0 / (alpha+1) sum r_n^{alpha+1}`.
//!
//! The factor of (eq:S1new) is `2 i omega^3`; the paper prints `2 i kappa omega^3`, which agrees at
//! `kappa = 1` only.

use super::{Averages, Values};
use crate::{
    chain::{Params, Resonators},
    error::{Error, Result, require},
};
use hertzchain_integrators::VectorField;

/// The condition on the mean strains in addition to `g_alpha(b_n, r_n) = C` for all `n` (eq:S2new).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Constraint {
    /// The mean force `C > 0` is given and constant, as in the paper (eq:g_alpha). With free ends
    /// it is the force on the ends.
    Force(f64),
    /// The mean of the `b_n` over a ring is given; `C` follows from it and changes in time.
    ///
    /// A ring that starts without mean velocity keeps `sum (x_n + rho y_n)`, to leading order
    /// `(1 + rho) epsilon sum b_n`.
    MeanStrain(f64),
}

/// The complex numbers of the state, and how many they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// The `N` amplitudes `A_n` (eq:S1new).
    Displacements,
    /// The strains `D_n` (eq:S1newS): `N` on a ring, from `D_1 = A_1 - A_N` on; `N - 1` between
    /// free ends, from `D_2 = A_2 - A_1` on.
    Strains,
}

/// What is beyond the first and the last site.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// The first and the last site are neighbours.
    Ring,
    /// No oscillating force acts on the ends.
    Free,
}

/// The chain on which a modulation equation is posed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Number of sites, `N >= 2`.
    pub sites: usize,
    /// Ring or free ends.
    pub ends: Ends,
    /// The complex numbers of the state.
    pub form: Form,
}

impl Layout {
    fn bonds(&self) -> usize {
        self.sites - usize::from(self.ends == Ends::Free)
    }

    /// Displacements of all sites with the given strains; their sum is zero.
    pub(super) fn stacked(self, strains: &[f64]) -> Vec<f64> {
        let mut displacements = vec![0.0; self.sites];
        // The first strain of a ring follows from the others.
        let skip = strains.len() + 1 - displacements.len();
        for n in 1..displacements.len() {
            displacements[n] = displacements[n - 1] + strains[n - 1 + skip];
        }
        let mean = displacements.iter().sum::<f64>() / displacements.len() as f64;
        displacements.iter_mut().for_each(|u| *u -= mean);
        displacements
    }

    fn checked(self) -> Result<Self> {
        require(self.sites >= 2, "sites", self.sites, "at least two sites")?;
        Ok(self)
    }
}

/// The coupling `sigma(r)` of bonds.
enum Coupling {
    Generalised { averages: Box<Averages>, constraint: Constraint, omega: f64 },
    Plain { alpha: f64, omega_0: f64 },
}

/// A modulation equation: a [`VectorField`] in the slow time.
///
/// The state is real, `[Re z_1, .., Re z_M, Im z_1, .., Im z_M]`; [`Form`] says which `M` complex
/// numbers these are.
///
/// ```
/// use hertzchain_core::{chain::Params, dps::{Constraint, Dps, Ends, Form, Layout}};
/// let layout = Layout { sites: 3, ends: Ends::Ring, form: Form::Displacements };
/// let params = Params::new(1.5, 1.0, 1.0 / 3.0)?;
/// let mut dps = Dps::generalised(params, Constraint::Force(1.0), layout)?;
/// // Without oscillation the force g = 1 compresses each bond to b = -1, and H is zero.
/// let rest = [0.3, 0.3, 0.3, 0.1, 0.1, 0.1];
/// assert_eq!(dps.mean_strains(&rest), [-1.0, -1.0, -1.0]);
/// assert_eq!(dps.energy(&rest), 0.0);
/// # Ok::<(), hertzchain_core::Error>(())
/// ```
pub struct Dps {
    coupling: Coupling,
    layout: Layout,
    /// Real and imaginary parts of `D`, later of `sigma D`.
    strains: [Vec<f64>; 2],
    radii: Vec<f64>,
    means: Vec<f64>,
}

impl Dps {
    /// The generalised DpS equations at finite `rho` (eq:S1new), (eq:S2new).
    ///
    /// `2 i omega^3 dA/dtau = delta^+ [h_alpha(b, r) D]` with `g_alpha(b_n, r_n) = C`.
    ///
    /// # Errors
    /// `rho` not in `(0, inf)`; `kappa` not positive; `alpha` outside `(0, 10]`; fewer than two
    /// sites; `C` not finite and positive; a mean strain that is not finite, or one given for free
    /// ends.
    pub fn generalised(params: Params, constraint: Constraint, layout: Layout) -> Result<Self> {
        params.validate()?;
        let rule = "the generalised DpS equations need resonators: 0 < rho < inf, kappa > 0";
        require(params.resonators() == Resonators::Moving, "rho", params.rho, rule)?;
        match constraint {
            Constraint::Force(c) if !(c.is_finite() && c > 0.0) => {
                return Err(Error::parameter("C", c, "the mean force is finite and positive"));
            }
            Constraint::MeanStrain(b) if !b.is_finite() => {
                return Err(Error::parameter("b", b, "the mean strain is finite"));
            }
            Constraint::MeanStrain(b) if layout.ends == Ends::Free => {
                return Err(Error::parameter(
                    "b",
                    b,
                    "only a ring has a given mean strain; free ends have a given force",
                ));
            }
            _ => {}
        }
        let averages = Box::new(Averages::new(params.alpha, params.kappa)?);
        Self::new(Coupling::Generalised { averages, constraint, omega: params.omega() }, layout)
    }

    /// The DpS equation of Newton's cradle (eq:DpSlr):
    /// `i dA/dtau = omega_0 delta^+ [r^{alpha-1} D]`, `B = 0`.
    ///
    /// `omega_0 = h_alpha(0, 1) / (2 kappa^{3/2})`, which is (eq:defom0) times `kappa^{alpha-3/2}`.
    ///
    /// # Errors
    /// `alpha` outside `(0, 10]`, `kappa` not finite and positive, fewer than two sites.
    pub fn plain(alpha: f64, kappa: f64, layout: Layout) -> Result<Self> {
        let omega_0 = Averages::new(alpha, kappa)?.h(0.0, 1.0) / (2.0 * kappa * kappa.sqrt());
        Self::new(Coupling::Plain { alpha, omega_0 }, layout)
    }

    fn new(coupling: Coupling, layout: Layout) -> Result<Self> {
        let zeros = vec![0.0; layout.checked()?.bonds()];
        Ok(Self { coupling, layout, strains: [zeros.clone(), zeros.clone()], radii: zeros.clone(), means: zeros })
    }

    /// Number `M` of complex numbers in the state.
    fn len(&self) -> usize {
        match self.layout.form {
            Form::Displacements => self.layout.sites,
            Form::Strains => self.layout.bonds(),
        }
    }

    /// The mean strains `b_n = delta^- B_n` of all bonds at the state `y`, in the order of the
    /// strains; zeros for DpS.
    ///
    /// Where a given mean strain leaves every bond open (`b >= 2 kappa mean(r_n)`), `C` is zero and
    /// only the bounds `b_n >= 2 kappa r_n` are known; the bounds `2 kappa r_n` are returned.
    ///
    /// # Panics
    /// If `y` is not of length [`dim`](VectorField::dim).
    pub fn mean_strains(&mut self, y: &[f64]) -> &[f64] {
        self.load(y);
        self.close();
        &self.means
    }

    /// The rates `db_n/dtau` of the mean strains at the state `y` with the slope `dy = dy/dtau`;
    /// zeros for DpS.
    ///
    /// They solve the differentiated constraint `dg/db db_n + dg/dr dr_n = dC`, with `dC = 0` for a
    /// given force and `sum db_n = 0` for a given mean strain.
    ///
    /// # Panics
    /// If `y` or `dy` is not of length [`dim`](VectorField::dim).
    pub fn mean_strain_rates(&mut self, y: &[f64], dy: &[f64]) -> Vec<f64> {
        self.load(dy);
        let [re_slope, im_slope] = self.strains.clone();
        self.load(y);
        self.close();
        let Coupling::Generalised { averages, constraint, .. } = &self.coupling else {
            return vec![0.0; self.radii.len()];
        };
        let [re, im] = &self.strains;
        // For each bond: db/dtau at constant force, and db/dC.
        let bonds: Vec<(f64, f64)> = (0..self.radii.len())
            .map(|n| {
                let (r, Values { dg_db, dg_dr, .. }) = (self.radii[n], averages.values(self.means[n], self.radii[n]));
                // The average of a contact that stays open has no slopes, and its rate is zero. g
                // is even in r.
                if dg_db == 0.0 || r == 0.0 {
                    return (0.0, if dg_db == 0.0 { 0.0 } else { dg_db.recip() });
                }
                let r_slope = (re[n] * re_slope[n] + im[n] * im_slope[n]) / r;
                (-dg_dr * r_slope / dg_db, dg_db.recip())
            })
            .collect();
        let (rate, yielding) = bonds.iter().fold((0.0, 0.0), |(a, b), bond| (a + bond.0, b + bond.1));
        let force_rate = match constraint {
            Constraint::MeanStrain(_) if yielding != 0.0 => -rate / yielding,
            _ => 0.0,
        };
        bonds.iter().map(|(own, per_force)| own + force_rate * per_force).collect()
    }

    /// The energy `H` at the state `y`; the flow conserves it.
    ///
    /// For a given force, `H` is zero for the chain at rest:
    /// `(alpha+1) E = 2 kappa r (r h) + alpha C (b + C^{1/alpha})`. For a given mean strain
    /// `E = W`. The section "Structure" of the source file derives both.
    ///
    /// # Panics
    /// If `y` is not of length [`dim`](VectorField::dim).
    pub fn energy(&mut self, y: &[f64]) -> f64 {
        self.load(y);
        self.close();
        match &self.coupling {
            Coupling::Plain { alpha, omega_0 } => {
                let powers: f64 = self.radii.iter().map(|r| r.powf(alpha + 1.0)).sum();
                2.0 * omega_0 / (alpha + 1.0) * powers
            }
            Coupling::Generalised { averages, constraint, omega } => {
                let (alpha, kappa) = (averages.alpha(), averages.kappa());
                let bonds = self.radii.iter().zip(&self.means);
                let energies = bonds.map(|(&r, &b)| {
                    let (g, rh) = averages.force(b, r);
                    let rest = match *constraint {
                        Constraint::Force(c) => alpha * c * (b - averages.mean_strain(c, 0.0)),
                        Constraint::MeanStrain(_) => -b * g,
                    };
                    (2.0 * kappa * r * rh + rest) / (alpha + 1.0)
                });
                energies.sum::<f64>() / (2.0 * kappa * omega.powi(3))
            }
        }
    }

    fn check(&self, y: &[f64]) {
        assert_eq!(y.len(), 2 * self.len(), "the state has two reals for each complex number");
    }

    /// Computes strains and their sizes from the state.
    fn load(&mut self, y: &[f64]) {
        self.check(y);
        for (part, strains) in y.chunks_exact(self.len()).zip(&mut self.strains) {
            match (self.layout.form, self.layout.ends) {
                (Form::Strains, _) => strains.copy_from_slice(part),
                (Form::Displacements, Ends::Ring) => {
                    strains[0] = part[0] - part[part.len() - 1];
                    difference(part, &mut strains[1..]);
                }
                (Form::Displacements, Ends::Free) => difference(part, strains),
            }
        }
        let [re, im] = &self.strains;
        for (r, (re, im)) in self.radii.iter_mut().zip(re.iter().zip(im)) {
            *r = re.hypot(*im);
        }
    }

    /// Computes the mean strains from the constraint.
    fn close(&mut self) {
        let Coupling::Generalised { averages, constraint, .. } = &self.coupling else { return };
        let c = match *constraint {
            Constraint::Force(c) => c,
            Constraint::MeanStrain(b) => mean_force(averages, &self.radii, b),
        };
        for (b, &r) in self.means.iter_mut().zip(&self.radii) {
            *b = averages.mean_strain(c, r);
        }
    }

    /// Replaces `D` by `sigma D`.
    fn couple(&mut self) {
        let [re, im] = &mut self.strains;
        for (n, (re, im)) in re.iter_mut().zip(im).enumerate() {
            let r = self.radii[n];
            let sigma = match &self.coupling {
                // sigma D vanishes with D, also where sigma is infinite.
                _ if r == 0.0 => 0.0,
                Coupling::Generalised { averages, omega, .. } => {
                    averages.force(self.means[n], r).1 / r / (2.0 * omega.powi(3))
                }
                Coupling::Plain { alpha, omega_0 } => omega_0 * r.powf(alpha - 1.0),
            };
            (*re, *im) = (sigma * *re, sigma * *im);
        }
    }
}

/// Writes `z_n - z_{n-1}`.
fn difference(z: &[f64], differences: &mut [f64]) {
    for (difference, pair) in differences.iter_mut().zip(z.windows(2)) {
        *difference = pair[1] - pair[0];
    }
}

/// The `C` at which the `b_n` with `g_alpha(b_n, r_n) = C` have the mean `b`; zero if no contact
/// closes.
///
/// Newton's method for `height = C^{1/alpha}`, in which the `b_n` are nearly linear, with bisection
/// where a step leaves the bracket.
fn mean_force(averages: &Averages, radii: &[f64], b: f64) -> f64 {
    let (alpha, count) = (averages.alpha(), radii.len() as f64);
    let swing = 2.0 * averages.kappa() * radii.iter().sum::<f64>() / count;
    // C^{1/alpha} lies in [-b_n - S_n, -b_n + S_n] with S_n = 2 kappa r_n; take means over bonds.
    let (mut low, mut high) = ((-b - swing).max(0.0), swing - b);
    if high <= 0.0 {
        return 0.0;
    }
    if !high.is_finite() {
        return f64::NAN;
    }
    let close = 2.0 * f64::EPSILON * (swing + b.abs());
    let mut height = 0.5 * (low + high);
    // Bisection alone takes up to 1100 halvings from the widest bracket; Newton's method takes a
    // few steps.
    for _ in 0..1200 {
        let (mut excess, mut slope) = (-b, 0.0);
        for &r in radii {
            let mean = averages.mean_strain(height.powf(alpha), r);
            excess += mean / count;
            slope += alpha * height.powf(alpha - 1.0) / averages.values(mean, r).dg_db / count;
        }
        *(if excess > 0.0 { &mut low } else { &mut high }) = height;
        let step = -excess / slope;
        if (slope.is_finite() && step.abs() <= close) || high - low <= close {
            break;
        }
        let newton = height + step;
        height = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
    }
    height.powf(alpha)
}

impl VectorField<f64> for Dps {
    fn dim(&self) -> usize {
        2 * self.len()
    }

    /// `d Re z = Im (i dz)`, `d Im z = -Re (i dz)`; the equation is autonomous.
    fn eval(&mut self, _: f64, y: &[f64], dy: &mut [f64]) {
        self.load(y);
        self.close();
        self.couple();
        let (re, im) = dy.split_at_mut(self.len());
        let Self { layout, strains, .. } = self;
        layout.shift(&strains[1], re);
        layout.shift(&strains[0], im);
        im.iter_mut().for_each(|im| *im = -*im);
    }
}

impl Layout {
    /// `delta^+ F`, or `delta^- delta^+ F`, of the fluxes `F = sigma D`.
    fn shift(&self, fluxes: &[f64], out: &mut [f64]) {
        // Beyond free ends the flux is zero. Bond n is before site n, so the first bond of a free
        // chain is that of its second site.
        let last = fluxes.len() - 1;
        let (before, after) = match self.ends {
            Ends::Ring => (fluxes[last], fluxes[0]),
            Ends::Free => (0.0, 0.0),
        };
        match (self.form, self.ends) {
            (Form::Displacements, Ends::Ring) => {
                difference(fluxes, out);
                out[last] = after - fluxes[last];
            }
            (Form::Displacements, Ends::Free) => {
                out[0] = fluxes[0];
                difference(fluxes, &mut out[1..]);
                out[last + 1] = -fluxes[last];
            }
            (Form::Strains, _) => {
                for (n, out) in out.iter_mut().enumerate() {
                    let left = if n == 0 { before } else { fluxes[n - 1] };
                    let right = if n == last { after } else { fluxes[n + 1] };
                    *out = (right - fluxes[n]) - (fluxes[n] - left);
                }
            }
        }
    }
}
