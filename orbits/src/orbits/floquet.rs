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
//! `M = M(T)` obeys `M^{-1} = R M R`, so `(M + M^{-1})/2 = diag(A, A')`. The eigenvalues of `A` are
//! the `tau = (lambda + 1/lambda)/2`, each for a pair of multipliers, and `A z = tau z` gives the
//! eigenvector `(M - 1/lambda)(z, 0) = ((lambda - 1/lambda)/2 z, C z)` of `lambda`. A real `tau` in
//! `[-1, 1]` is a pair exactly on the circle. The fourfold multiplier 1 of two Jordan blocks is a
//! double `tau = 1` with two eigenvectors, which is not defective.
//!
//! `M` is symplectic, so `G C` and `G C A` are symmetric, and the left eigenvector of `tau` is
//! `G C z`. Hence the condition number of `tau` is `|z| |G C z| / |z^T G C z|`, and the Krein
//! signature of `e^{i theta}`, `0 < theta < pi`, is the sign of `-z^T G C z / sin theta`. Pairs of
//! the same signature stay on the circle when they meet; pairs of opposite signature can leave it.
//!
//! # Two reversals
//!
//! A relative periodic orbit can have one reversal `R_1` at its start and another, `R_2`, after
//! half of its time. With each reversal go coordinates `(Q, P)` in which it is `diag(1, -1)`. In
//! them all of this holds with `Q` for `Z` and `P` for `Z'`: the relative monodromy is
//! `R_1 M_h^{-1} R_2 M_h`. A [`Frame`] holds the metric and the uniform vectors in these
//! coordinates.

use super::eigen::{Eigenpair, eigen, eigenvalues, unless_asked};
use crate::{
    chain::{Boundary, Chain},
    named::named,
    numerics::{leading, least_by},
};
use nalgebra::{Complex, DMatrix, DVector};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::f64::consts::PI;

named! {
    /// Position of a multiplier in the complex plane.
    pub enum Kind {
        /// One of those that equal 1: shift of time and change of frequency; on rings also drift,
        /// and change of the mean strain or of the position.
        Trivial = "trivial",
        /// `exp(+-i omega T)`: the sum of all beads relative to that of all resonators is a linear
        /// oscillator.
        Linear = "linear",
        /// On the unit circle.
        Circle = "circle",
        /// Real and positive.
        Real = "real",
        /// Real and negative, as after a period doubling.
        Negative = "negative",
        /// One of four, neither on the circle nor on the real axis.
        Quartet = "quartet",
    }
}

/// A Floquet multiplier.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Multiplier {
    /// Real part.
    pub re: f64,
    /// Imaginary part.
    pub im: f64,
    /// `|lambda|`.
    pub modulus: f64,
    /// Estimated error of the modulus.
    #[serde(deserialize_with = "or_infinite")]
    pub error: f64,
    /// Position in the complex plane.
    pub kind: Kind,
    /// Krein signature of a multiplier on the circle; 0 elsewhere.
    pub krein: i8,
}

/// Measured errors of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// `max |M^T J M - J| / max |J|`; on a strain ring restricted to strains of sum zero.
    pub symplectic_defect: f64,
    /// `max |A z - tau z| / (|A| |z|)`.
    pub eigen_residual: f64,
    /// `|tau - 1|` of the `tau` that are 1 in theory: two of a ring; one between walls, where the
    /// second entry is 0.
    pub trivial: [f64; 2],
    /// `|tau - cos(omega T)|` of the `tau` that is `cos(omega T)` in theory, on a strain ring.
    pub linear: f64,
    /// Largest relative distance of the multipliers given here from those that the same solver
    /// finds for the whole `M(T)`.
    ///
    /// The fourfold multiplier 1 is left out, since the solver splits it. Not a number if the
    /// solver does not converge.
    #[serde(deserialize_with = "or_nan")]
    pub pairing: f64,
}

/// The multipliers of an orbit. A spectrum that was read from JSON has no eigenvectors.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Spectrum {
    /// All multipliers, the largest modulus first, with conjugates next to each other.
    pub multipliers: Vec<Multiplier>,
    /// All `tau`, in the order of the largest multiplier of each.
    #[serde(with = "complex")]
    pub tau: Vec<Complex<f64>>,
    /// Measured errors.
    pub quality: Quality,
    /// Eigenvector, kind and signature for each `tau`.
    modes: Vec<Vectors>,
}

/// Eigenvector `z`, `C z`, kind and signature of a `tau`.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Vectors {
    #[serde(skip, default = "no_vector")]
    z: DVector<Complex<f64>>,
    #[serde(skip, default = "no_vector")]
    c_z: DVector<Complex<f64>>,
    kind: Kind,
    krein: i8,
}

fn no_vector() -> DVector<Complex<f64>> {
    DVector::zeros(0)
}

/// A number that JSON has as `null`, which stands for all that are not finite, as infinity.
pub(super) fn or_infinite<'de, D: Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    Option::deserialize(source).map(|value| value.unwrap_or(f64::INFINITY))
}

/// As `or_infinite`, with NaN for `null`.
pub fn or_nan<'de, D: Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    Option::deserialize(source).map(|value| value.unwrap_or(f64::NAN))
}

/// Complex numbers as pairs of real ones.
mod complex {
    use super::{Complex, Deserialize, Deserializer, Serializer};

    pub(super) fn serialize<S: Serializer>(values: &[Complex<f64>], target: S) -> Result<S::Ok, S::Error> {
        target.collect_seq(values.iter().map(|value| [value.re, value.im]))
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(source: D) -> Result<Vec<Complex<f64>>, D::Error> {
        let pairs = Vec::<[f64; 2]>::deserialize(source)?;
        Ok(pairs.into_iter().map(|[re, im]| Complex::new(re, im)).collect())
    }
}

impl Spectrum {
    /// The multipliers of a reversible orbit. `half` is the tangent map over half of its time,
    /// `dim x dim`, in the coordinates of the frame, with errors up to the share `tol` of its
    /// size if these are larger than its roundings; `exact` lists the `tau` that are known in
    /// theory, with their kinds.
    ///
    /// `None` if the eigenvalues of a matrix do not converge, or if `half` is singular.
    pub fn new(frame: &Frame, half: &DMatrix<f64>, tol: f64, exact: &[(f64, Kind)]) -> Option<Self> {
        let n = half.nrows() / 2;
        let monodromy = by_reversal(half)?;
        let a = monodromy.view((0, 0), (n, n)).into_owned();
        let momentum = &frame.metric * monodromy.view((n, 0), (n, n));
        let (c, g) = (monodromy.view((n, 0), (n, n)).map(Complex::from), momentum.map(Complex::from));
        let symplectic_defect = frame.symplectic_defect(&monodromy);
        let pairs = eigen(&a)?;
        let (wide, size) = (a.map(Complex::from), a.norm());
        let residual = |(tau, z): &Eigenpair| (&wide * z - z * *tau).norm() / size;
        let eigen_residual = pairs.iter().map(residual).fold(0.0, f64::max);
        let mut quality =
            Quality { symplectic_defect, eigen_residual, trivial: [0.0; 2], linear: 0.0, pairing: f64::NAN };

        let rounding = size * symplectic_defect.max(eigen_residual).max(f64::EPSILON).max(tol);
        let mut modes: Vec<Mode> = pairs.into_iter().map(|(tau, z)| Mode::new(tau, z, &c, &g, rounding)).collect();
        let mut take = |value: f64, kind: Kind| {
            let apart = |mode: &&mut Mode| (mode.tau - value).norm();
            let free = modes.iter_mut().filter(|mode| mode.kind.is_none());
            least_by(free, apart).map_or(f64::NAN, |mode| {
                let by = apart(&mode);
                (mode.kind, mode.tau) = (Some(kind), Complex::from(value));
                by
            })
        };
        let mut trivial = quality.trivial.iter_mut();
        for &(tau, kind) in exact {
            let by = take(tau, kind);
            match kind {
                Kind::Linear => quality.linear = by,
                _ => trivial.next().into_iter().for_each(|one| *one = by),
            }
        }
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

    /// Every `tau` except those of the kinds `Trivial` and `Linear`, with its signature (of the
    /// form `z^T G C z`).
    pub(super) fn free(&self) -> impl Iterator<Item = (Complex<f64>, i8)> + '_ {
        let exact = |kind: Kind| matches!(kind, Kind::Trivial | Kind::Linear);
        self.tau
            .iter()
            .zip(&self.modes)
            .filter(move |(_, mode)| !exact(mode.kind))
            .map(|(tau, mode)| (*tau, mode.krein))
    }

    /// The strains `z`, `A z = tau z`, of the computed `tau` nearest to the given value, scaled to
    /// 1 at the first of the largest entries.
    pub(super) fn strains_of(&self, tau: f64) -> Vec<f64> {
        let nearest = least_by(0..self.tau.len(), |&k| (self.tau[k] - tau).norm());
        nearest.map_or(Vec::new(), |k| scaled_to_one(&self.modes[k].z))
    }

    /// The spectrum without its eigenvectors, which take most of its memory.
    pub fn without_vectors(mut self) -> Self {
        self.modes.iter_mut().for_each(|mode| (mode.z, mode.c_z) = (no_vector(), no_vector()));
        self
    }

    /// The real part of the eigenvector `((lambda - 1/lambda)/2 z, C z)` of multiplier `k`, scaled
    /// to 1 at the first of its largest entries. Empty for a spectrum without eigenvectors, such as
    /// that of a point of a branch.
    pub fn direction(&self, k: usize) -> Vec<f64> {
        let Multiplier { re, im, .. } = self.multipliers[k];
        let lambda = Complex::new(re, im);
        let Vectors { z, c_z, .. } = &self.modes[k / 2];
        let half = (lambda - lambda.inv()) * 0.5;
        scaled_to_one(&DVector::from_iterator(2 * z.len(), z.iter().map(|z| z * half).chain(c_z.iter().copied())))
    }

    /// The largest real multiplier above 1; 1 if there is none.
    pub fn largest_real(&self) -> f64 {
        let real = self.multipliers.iter().filter(|one| one.kind == Kind::Real);
        real.map(|one| one.modulus).fold(1.0, f64::max)
    }

    /// The largest modulus, at least 1.
    pub fn largest(&self) -> f64 {
        self.multipliers.iter().map(|m| m.modulus).fold(1.0, f64::max)
    }

    /// Real part, imaginary part and error of the modulus of each multiplier.
    pub(super) fn numbers(&self) -> Vec<[f64; 3]> {
        self.multipliers.iter().map(|one| [one.re, one.im, one.error]).collect()
    }

    /// Number of multipliers that lie outside the unit circle by more than their error.
    pub fn unstable(&self) -> usize {
        self.multipliers.iter().filter(|one| one.modulus - one.error > 1.0).count()
    }
}

/// One `tau` with its vectors.
struct Mode {
    tau: Complex<f64>,
    z: DVector<Complex<f64>>,
    c_z: DVector<Complex<f64>>,
    /// Sign of `z^T G C z` for a real `tau`; 0 otherwise.
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
        // The eigenvector of a real tau is real up to a factor.
        let krein = if tau.im == 0.0 { z.dotc(&dual).re.signum() as i8 } else { 0 };
        Self { tau, z, c_z, krein, error, kind: None, modulus_error: 0.0 }
    }

    /// Sets the kind and the error of the modulus; `known` holds `tau`, signature and error of all
    /// modes.
    fn classify(&mut self, known: &[(f64, i8, f64)]) {
        if self.kind.is_some() {
            return;
        }
        let Complex { re, im } = self.tau;
        // If the error of tau can have made the pair complex, tau counts as real: on the circle or
        // on the axis.
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

    /// The `lambda` outside or on the circle, with `Im lambda >= 0` on the circle.
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

    /// The two multipliers of this `tau`; the other two of a quartet belong to the conjugate `tau`.
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

/// The real part of a vector after its leading entry is scaled to 1.
fn scaled_to_one(vector: &DVector<Complex<f64>>) -> Vec<f64> {
    let leading = leading(vector.iter().map(|entry| entry.norm())).map_or(Complex::ONE, |k| vector[k]);
    vector.iter().map(|z| (z / leading).re).collect()
}

/// `R M_h^{-1} R M_h`.
fn by_reversal(half: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let (rows, half) = (half.nrows(), half.clone());
    let reversed = move |mut m: DMatrix<f64>| {
        m.rows_mut(rows / 2, rows / 2).neg_mut();
        m
    };
    unless_asked(rows, move || half.clone().lu().solve(&reversed(half)).map(reversed))?
}

/// The `tau` that orbits of a chain with equal beads have: `linear`, and two that are 1.
pub fn known(linear: f64) -> [(f64, Kind); 3] {
    [(linear, Kind::Linear), (1.0, Kind::Trivial), (1.0, Kind::Trivial)]
}

/// The metric `G`: masses; on a strain ring times the inverse of `-delta^+ delta^-` on vectors of
/// mean zero.
fn metric(chain: &Chain<f64>) -> DMatrix<f64> {
    let n = chain.sites();
    let inverse: Vec<f64> = (0..n)
        .map(|d| match chain.boundary() {
            Boundary::StrainRing => {
                let wave = |k: usize| 2.0 * PI * k as f64 / n as f64;
                // The same number for d and n - d, so that `G` is symmetric to the last digit.
                let apart = d.min(n - d) as f64;
                (1..n).map(|k| (wave(k) * apart).cos() / (2.0 - 2.0 * wave(k).cos())).sum::<f64>() / n as f64
            }
            _ => f64::from(u8::from(d == 0)),
        })
        .collect();
    let (rho, half) = (chain.params().rho, chain.layout().half());
    DMatrix::from_fn(half, half, |i, j| match (i < n, j < n) {
        (true, true) => inverse[(n + i - j) % n],
        (false, false) => rho * inverse[(n + i - j) % n],
        _ => 0.0,
    })
}

/// Coordinates `(Q, P)` of states in which the reversal is `diag(1, -1)`.
#[derive(Clone, Debug)]
pub struct Frame {
    /// `G`: `G P` is conjugate to `Q`.
    metric: DMatrix<f64>,
    /// Vectors that are projected out before the symplectic defect is measured: on a strain ring
    /// uniform strains and rates.
    uniform: Vec<DVector<f64>>,
}

impl Frame {
    /// `Q = Z`, `P = Z'`.
    pub fn at_rest(chain: &Chain<f64>) -> Self {
        let (metric, sites) = (metric(chain), chain.sites());
        let n = 2 * metric.nrows();
        // These vectors have entries 1, not unit length: the mean of a column is more accurate than
        // its product with a unit vector.
        let ones = |first: usize| DVector::from_fn(n, |i, _| f64::from((first..first + sites).contains(&i)));
        let uniform = match chain.boundary() {
            Boundary::StrainRing => (0..n).step_by(sites).map(ones).collect(),
            _ => Vec::new(),
        };
        Self { metric, uniform }
    }

    /// Displacements and velocities of coordinates with these masses.
    pub fn of_masses(masses: &[f64]) -> Self {
        Self { metric: DMatrix::from_diagonal(&DVector::from_column_slice(masses)), uniform: Vec::new() }
    }

    /// The coordinates `turn (Z, Z')`; `turn` is orthogonal, and the reversal that it belongs to
    /// changes the sign of the symplectic form.
    pub fn turned(chain: &Chain<f64>, turn: &DMatrix<f64>) -> Self {
        let at_rest = Self::at_rest(chain);
        let n = at_rest.metric.nrows();
        let form = turn * at_rest.form() * turn.transpose();
        Self {
            metric: form.view((0, n), (n, n)).into_owned(),
            uniform: at_rest.uniform.iter().map(|uniform| turn * uniform).collect(),
        }
    }

    /// `J = [0 G; -G^T 0]`.
    fn form(&self) -> DMatrix<f64> {
        let n = self.metric.nrows();
        let mut j = DMatrix::zeros(2 * n, 2 * n);
        j.view_mut((0, n), (n, n)).copy_from(&self.metric);
        j.view_mut((n, 0), (n, n)).copy_from(&-self.metric.transpose());
        j
    }

    /// `max |M^T J M - J| / max |J|`, on a strain ring on strains of sum zero.
    fn symplectic_defect(&self, monodromy: &DMatrix<f64>) -> f64 {
        let j = self.form();
        let mut m = monodromy.clone();
        for uniform in &self.uniform {
            m -= (&m * uniform) / uniform.norm_squared() * uniform.transpose();
        }
        (m.transpose() * &j * &m - &j).amax() / j.amax()
    }
}

/// See [`Quality::pairing`].
fn pairing(monodromy: &DMatrix<f64>, multipliers: &[Multiplier]) -> f64 {
    let Some(whole) = eigenvalues(monodromy) else { return f64::NAN };
    let nearest = |m: &Multiplier| {
        let lambda = Complex::new(m.re, m.im);
        whole.iter().map(|other| (other - lambda).norm() / lambda.norm()).fold(f64::INFINITY, f64::min)
    };
    multipliers.iter().filter(|m| m.kind != Kind::Trivial).map(nearest).fold(0.0, f64::max)
}
