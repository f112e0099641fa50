//! Floquet multipliers of a reversible orbit, from its half period.
//!
//! | symbol | meaning |
//! |---|---|
//! | `M_h = M(T/2)` | so `M(T) = R M_h^{-1} R M_h` |
//! | `A, C` | the blocks `dZ(T)/dZ(0)` and `dZ'(T)/dZ(0)` of `M(T)` |
//! | `G` | metric of the momenta: `p = G Z'` is conjugate to `Z` |
//!
//! # Half the size
//!
//! `M = M(T)` obeys `M^{-1} = R M R`, so `(M + M^{-1})/2 = diag(A, A')`: the eigenvalues of `A` are the `tau = (lambda + 1/lambda)/2`, each for
//! a pair of multipliers, and `A z = tau z` gives the eigenvector `(M - 1/lambda)(z, 0) = ((lambda - 1/lambda)/2 z, C z)` of `lambda`. A real `tau`
//! in `[-1, 1]` is a pair exactly on the circle, and the fourfold multiplier 1 of two Jordan blocks is a double `tau = 1` with two
//! eigenvectors: nothing there is defective.
//!
//! `M` is symplectic, so `G C` is symmetric and `G C A` as well: the left eigenvector of `tau` is `G C z`. Hence the condition of `tau`,
//! `|z| |G C z| / |z^T G C z|`, and the Krein signature of `e^{i theta}`, `0 < theta < pi`: the sign of `-z^T G C z / sin theta`. Definite pairs cannot leave the circle when they
//! meet; pairs of opposite signature can.

use super::eigen::{Eigenpair, eigen, schur};
use crate::chain::{Boundary, Chain};
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::PI;

/// Where a multiplier is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// One of the four that are 1: shift of time, of frequency, of the mean strain, and drift.
    Trivial,
    /// `exp(+-i omega T)`: the sum of all beads against that of all resonators, a linear oscillator.
    Linear,
    /// On the unit circle.
    Circle,
    /// Real and positive.
    Real,
    /// Real and negative: beyond a period doubling.
    Negative,
    /// One of four, off the circle and off the axis.
    Quartet,
}

/// A Floquet multiplier.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Multiplier {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// `|lambda|`.
    pub modulus: f64,
    /// Estimated error of the modulus.
    pub error: f64,
    /// Where it is.
    pub kind: Kind,
    /// Krein signature of one on the circle; 0 elsewhere.
    pub krein: i8,
}

/// How good a spectrum is.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Quality {
    /// `max |M^T J M - J| / max |J|`, on strains of sum zero on a strain ring.
    pub symplectic_defect: f64,
    /// `max |A z - tau z| / (|A| |z|)`.
    pub eigen_residual: f64,
    /// `|tau - 1|` of the two that are 1.
    pub trivial: [f64; 2],
    /// `|tau - cos(omega T)|` of the one that is that, on a strain ring.
    pub linear: f64,
    /// Largest relative distance of the multipliers of the whole `M(T)`, by the same solver, from those given here; that of a fourfold 1 which it
    /// splits is left out. Not a number if these did not converge.
    pub pairing: f64,
}

/// The multipliers of an orbit.
#[derive(Clone, Debug)]
pub struct Spectrum {
    /// All of them, the largest modulus first, conjugates side by side.
    pub multipliers: Vec<Multiplier>,
    /// Every `tau`, in the order of the largest of their multipliers.
    pub tau: Vec<Complex<f64>>,
    /// How good they are.
    pub quality: Quality,
    /// For each `tau`.
    modes: Vec<Vectors>,
}

/// What belongs to a `tau`.
#[derive(Clone, Debug)]
struct Vectors {
    z: DVector<Complex<f64>>,
    c_z: DVector<Complex<f64>>,
    kind: Kind,
    krein: i8,
}

impl Spectrum {
    /// The multipliers of the reversible orbit of period `period` whose half period has the tangent map `half`, `dim x dim`; `None` if the eigenvalues
    /// of a matrix do not converge, or if `half` is singular.
    pub(crate) fn new(chain: &Chain<f64>, half: &DMatrix<f64>, period: f64) -> Option<Self> {
        let n = half.nrows() / 2;
        let monodromy = by_reversal(half)?;
        let a = monodromy.view((0, 0), (n, n)).into_owned();
        let momentum = &metric(chain) * monodromy.view((n, 0), (n, n));
        let (c, g) = (monodromy.view((n, 0), (n, n)).map(Complex::from), momentum.map(Complex::from));
        let symplectic_defect = symplectic_defect(chain, &monodromy);
        let pairs = eigen(&a)?;
        let (wide, size) = (a.map(Complex::from), a.norm());
        let residual = |(tau, z): &Eigenpair| (&wide * z - z * *tau).norm() / size;
        let eigen_residual = pairs.iter().map(residual).fold(0.0, f64::max);
        let omega = chain.params().omega();
        let mut quality =
            Quality { symplectic_defect, eigen_residual, trivial: [0.0; 2], linear: 0.0, pairing: f64::NAN };

        let rounding = size * symplectic_defect.max(eigen_residual).max(f64::EPSILON);
        let mut modes: Vec<Mode> = pairs.into_iter().map(|(tau, z)| Mode::new(tau, z, &c, &g, rounding)).collect();
        let mut take = |value: f64, kind: Kind| {
            let apart = |mode: &&mut Mode| (mode.tau - value).norm();
            let free = modes.iter_mut().filter(|mode| mode.kind.is_none());
            free.min_by(|a, b| apart(a).total_cmp(&apart(b))).map_or(f64::NAN, |mode| {
                let by = apart(&mode);
                (mode.kind, mode.tau) = (Some(kind), Complex::from(value));
                by
            })
        };
        quality.linear = take((omega * period).cos(), Kind::Linear);
        quality.trivial = [take(1.0, Kind::Trivial), take(1.0, Kind::Trivial)];
        let known: Vec<(f64, i8, f64)> = modes.iter().map(|mode| (mode.tau.re, mode.krein, mode.error)).collect();
        for mode in &mut modes {
            mode.classify(&known);
        }
        modes.sort_by(|a, b| b.largest().total_cmp(&a.largest()).then(a.tau.re.total_cmp(&b.tau.re)));
        let multipliers: Vec<Multiplier> = modes.iter().flat_map(Mode::multipliers).collect();
        quality.pairing = pairing(&monodromy, &multipliers);
        let tau = modes.iter().map(|mode| mode.tau).collect();
        let vectors = |Mode { z, c_z, kind, krein, .. }| Vectors { z, c_z, kind: kind.unwrap_or(Kind::Circle), krein };
        let modes = modes.into_iter().map(vectors).collect();
        Some(Self { multipliers, tau, quality, modes })
    }

    /// Every `tau` of no exact multiplier, and the signature of one on the circle.
    pub(super) fn free(&self) -> impl Iterator<Item = (Complex<f64>, i8)> + '_ {
        let exact = |kind: Kind| matches!(kind, Kind::Trivial | Kind::Linear);
        self.tau
            .iter()
            .zip(&self.modes)
            .filter(move |(_, mode)| !exact(mode.kind))
            .map(|(tau, mode)| (*tau, mode.krein))
    }

    /// The strains `z`, `A z = tau z`, of the real `tau` nearest to a value, the largest 1.
    pub(super) fn strains_of(&self, tau: f64) -> Vec<f64> {
        let apart = |k: usize| (self.tau[k] - tau).norm();
        let nearest = (0..self.tau.len()).min_by(|&a, &b| apart(a).total_cmp(&apart(b)));
        nearest.map_or(Vec::new(), |k| scaled_to_one(&self.modes[k].z))
    }

    /// The real part of the eigenvector `(Z, Z')` of multiplier `k`, the largest entry 1: `((lambda - 1/lambda)/2 z, C z)`.
    pub fn direction(&self, k: usize) -> Vec<f64> {
        let Multiplier { re, im, .. } = self.multipliers[k];
        let lambda = Complex::new(re, im);
        let Vectors { z, c_z, .. } = &self.modes[k / 2];
        let half = (lambda - lambda.inv()) * 0.5;
        scaled_to_one(&DVector::from_iterator(2 * z.len(), z.iter().map(|z| z * half).chain(c_z.iter().copied())))
    }

    /// The largest modulus that is not rounding.
    pub fn largest(&self) -> f64 {
        self.multipliers.iter().map(|m| m.modulus).fold(1.0, f64::max)
    }
}

/// One `tau` with its vectors.
struct Mode {
    tau: Complex<f64>,
    z: DVector<Complex<f64>>,
    c_z: DVector<Complex<f64>>,
    /// Sign of `z^T G C z`, of a real `tau`.
    krein: i8,
    /// Estimated error of `tau`.
    error: f64,
    kind: Option<Kind>,
    /// Estimated error of the modulus.
    modulus_error: f64,
}

impl Mode {
    fn new(
        tau: Complex<f64>,
        z: DVector<Complex<f64>>,
        c: &DMatrix<Complex<f64>>,
        momentum: &DMatrix<Complex<f64>>,
        rounding: f64,
    ) -> Self {
        let (c_z, dual) = (c * &z, momentum * &z);
        let form = z.dot(&dual);
        let error = rounding * z.norm() * dual.norm() / form.norm();
        // The vector of a real tau is real but for a factor.
        let krein = if tau.im == 0.0 { z.dotc(&dual).re.signum() as i8 } else { 0 };
        Self { tau, z, c_z, krein, error, kind: None, modulus_error: 0.0 }
    }

    /// Kind and error of the modulus; `known` are all `tau`, their signatures and errors.
    fn classify(&mut self, known: &[(f64, i8, f64)]) {
        if self.kind.is_some() {
            return;
        }
        let Complex { re, im } = self.tau;
        // A pair that its error could have split is on the circle or on the axis.
        if im.abs() <= self.error {
            self.tau.im = 0.0;
        }
        let split = (2.0 * self.error).sqrt();
        let rate = (self.tau * self.tau - 1.0).sqrt().norm();
        self.modulus_error = (self.largest() * self.error / rate).min(split);
        self.kind = Some(if self.tau.im != 0.0 {
            Kind::Quartet
        } else if re > 1.0 {
            Kind::Real
        } else if re < -1.0 {
            Kind::Negative
        } else {
            let meets = |&(tau, krein, error): &(f64, i8, f64)| {
                krein != self.krein && (tau - re).abs() <= error.max(self.error) && tau != re
            };
            if 1.0 - re.abs() > self.error && im == 0.0 && !known.iter().any(meets) {
                self.modulus_error = 0.0;
            }
            Kind::Circle
        });
    }

    /// `lambda` outside or on the circle, with `Im lambda >= 0` on it.
    fn lambda(&self) -> Complex<f64> {
        let tau = self.tau;
        if tau.im == 0.0 && tau.re.abs() <= 1.0 {
            return Complex::new(tau.re, ((1.0 - tau.re) * (1.0 + tau.re)).sqrt());
        }
        let root = (tau * tau - 1.0).sqrt();
        if (tau + root).norm() >= 1.0 { tau + root } else { tau - root }
    }

    fn largest(&self) -> f64 {
        if self.tau.im == 0.0 && self.tau.re.abs() <= 1.0 { 1.0 } else { self.lambda().norm() }
    }

    /// The two multipliers of this `tau`; its conjugate has the other two of a quartet.
    fn multipliers(&self) -> [Multiplier; 2] {
        let (lambda, kind) = (self.lambda(), self.kind.unwrap_or(Kind::Circle));
        let circle = matches!(kind, Kind::Circle | Kind::Linear | Kind::Trivial);
        let inverse = if circle { lambda.conj() } else { lambda.inv() };
        let krein = if kind == Kind::Circle { -self.krein } else { 0 };
        [(lambda, krein), (inverse, -krein)].map(|(lambda, krein)| {
            let modulus = if circle { 1.0 } else { lambda.norm() };
            Multiplier { re: lambda.re, im: lambda.im, modulus, error: self.modulus_error * modulus, kind, krein }
        })
    }
}

/// The real part of a vector whose largest entry is turned to 1.
fn scaled_to_one(vector: &DVector<Complex<f64>>) -> Vec<f64> {
    let largest = vector.iter().max_by(|a, b| a.norm().total_cmp(&b.norm())).copied().unwrap_or(Complex::ONE);
    vector.iter().map(|z| (z / largest).re).collect()
}

/// `R M_h^{-1} R M_h`.
fn by_reversal(half: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = half.nrows() / 2;
    let reversed = |mut m: DMatrix<f64>| {
        m.rows_mut(n, n).neg_mut();
        m
    };
    half.clone().lu().solve(&reversed(half.clone())).map(reversed)
}

/// `G`: masses; on a strain ring over `-delta^+ delta^-`, inverted on what has mean zero.
fn metric(chain: &Chain<f64>) -> DMatrix<f64> {
    let n = chain.sites();
    let inverse: Vec<f64> = (0..n)
        .map(|d| match chain.boundary() {
            Boundary::StrainRing => {
                let wave = |k: usize| 2.0 * PI * k as f64 / n as f64;
                (1..n).map(|k| (wave(k) * d as f64).cos() / (2.0 - 2.0 * wave(k).cos())).sum::<f64>() / n as f64
            }
            _ => f64::from(u8::from(d == 0)),
        })
        .collect();
    let rho = chain.params().rho;
    DMatrix::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => inverse[(n + i - j) % n],
        (false, false) => rho * inverse[(n + i - j) % n],
        _ => 0.0,
    })
}

/// `max |M^T J M - J| / max |J|` with `J = [0 G; -G 0]`, after a projection on sum zero on a strain ring.
fn symplectic_defect(chain: &Chain<f64>, monodromy: &DMatrix<f64>) -> f64 {
    let (g, n) = (metric(chain), monodromy.nrows() / 2);
    let mut j = DMatrix::zeros(2 * n, 2 * n);
    j.view_mut((0, n), (n, n)).copy_from(&g);
    j.view_mut((n, 0), (n, n)).copy_from(&-&g);
    let mut m = monodromy.clone();
    if chain.boundary() == Boundary::StrainRing {
        let sites = chain.sites();
        for first in (0..2 * n).step_by(sites) {
            let mean = m.columns(first, sites).column_mean();
            m.columns_mut(first, sites).column_iter_mut().for_each(|mut column| column -= &mean);
        }
    }
    (m.transpose() * &j * &m - &j).amax() / j.amax()
}

/// See [`Quality::pairing`].
fn pairing(monodromy: &DMatrix<f64>, multipliers: &[Multiplier]) -> f64 {
    let Some(whole) = schur(monodromy).map(|schur| schur.complex_eigenvalues()) else { return f64::NAN };
    let nearest = |m: &Multiplier| {
        let lambda = Complex::new(m.re, m.im);
        whole.iter().map(|other| (other - lambda).norm() / lambda.norm()).fold(f64::INFINITY, f64::min)
    };
    multipliers.iter().filter(|m| m.kind != Kind::Trivial).map(nearest).fold(0.0, f64::max)
}
