//! Eigenmodes of modulated waves: initial states with a mode added, and the share of a mode in a
//! state.
//!
//! | symbol | meaning |
//! |---|---|
//! | `w_n` | `U e^{ipn} + conj(V) e^{-ipn}`, see the module `stability` |
//! | `lambda` | eigenvalue of `(U, V)` |
//! | `ell` | left eigenvector, with `ell . (U, V) = 1` for the mode |
//! | `c` | share of the mode in a perturbation: `c = ell . (U, V)` |

use super::{Eigenvalue, Modulation, Shape, TravellingWave};
use crate::{chain::Site, dps::first_order};
use num_complex::Complex64;

/// The mode at a wave number that belongs to the first of [`Modulation::eigenvalues`].
#[derive(Clone, Copy, Debug)]
pub struct Mode {
    modulation: Modulation,
    p: f64,
    lambda: Complex64,
    /// `(U, V)`, of length one, with `U V` real and not negative, so that at `p = pi` the two terms
    /// of `w_n` add up.
    right: [Complex64; 2],
    left: [Complex64; 2],
}

impl Mode {
    /// The mode at wave number `p`; `None` where the eigenvalue is double and has one mode, as at
    /// `p = 0` and at the edge of a band.
    pub fn new(modulation: &Modulation, p: f64) -> Option<Self> {
        let Eigenvalue { growth, frequency } = modulation.eigenvalues(p)[0];
        let lambda = Complex64::new(growth, frequency);
        let [[a, b], [c, d]] = modulation.matrix(p).map(|row| row.map(|x| Complex64::new(0.0, x)));
        // Either row gives the right vector and either column the left vector; one of the two may
        // vanish.
        let right = unit(longer([b, lambda - a], [lambda - d, c]))?;
        let left = unit(longer([c, lambda - a], [lambda - d, b]))?;
        let phase = Complex64::from_polar(1.0, -0.5 * (right[0] * right[1]).arg());
        let right = right.map(|z| z * phase);
        let product = dot(left, right);
        // A product below 1e-6 means an eigenvalue that is double to 1e-12.
        (product.norm() > 1e-6).then(|| Self {
            modulation: *modulation,
            p,
            lambda,
            right,
            left: left.map(|z| z / product),
        })
    }

    /// `w_n` and its derivative by the slow time, at the slow time zero.
    fn perturbation(&self, n: f64) -> [Complex64; 2] {
        let turn = Complex64::from_polar(1.0, self.p * n);
        let [u, v] = self.right;
        let w = |rate: Complex64| rate * u * turn + (rate * v * turn).conj();
        [w(1.0.into()), w(self.lambda)]
    }

    /// `D_n` of the wave plus `size a` times the mode, and its derivative by the slow time, at the
    /// slow time zero.
    pub fn amplitude(&self, size: f64, n: usize) -> [Complex64; 2] {
        let Shape { q, a, phi, .. } = self.modulation.shape();
        let [w, dw] = self.perturbation(n as f64).map(|w| size * a * w);
        let carrier = Complex64::from_polar(1.0, -(q * n as f64 + phi));
        let i_omega = Complex64::new(0.0, self.modulation.slow_frequency());
        [carrier * (a + w), carrier * (i_omega * (a + w) + dw)]
    }

    /// Site `n` of the full chain at `t = 0` for these amplitudes, with
    /// `b_n = b + size a (db/dr) Re w_n`.
    pub fn site(&self, wave: &TravellingWave, size: f64, n: usize) -> Site<f64> {
        let Shape { a, b, .. } = self.modulation.shape();
        let slope = size * a * self.modulation.mean_slope();
        let [w, dw] = self.perturbation(n as f64).map(|w| slope * w.re);
        first_order(wave.params(), wave.epsilon(), 0.0, self.amplitude(size, n), [b + w, dw])
    }

    /// The share `c` of the mode in a perturbation of the `D_n` of a wave: complex, proportional to
    /// `e^{lambda tau}`.
    ///
    /// At `p = pi` the sidebands `U` and `conj(V)` coincide, and each is given half of their sum.
    /// Phase and size of the wave are taken from the given `D_n`: `w_n = a delta_n / D_n`, with the
    /// `D_n` averaged over the ring.
    ///
    /// # Panics
    /// If `wave` and `changed` have different lengths.
    pub fn share(&self, wave: &[Complex64], changed: &[Complex64]) -> Complex64 {
        assert_eq!(wave.len(), changed.len(), "two states of one ring");
        let Shape { q, .. } = self.modulation.shape();
        let turned = |z: &Complex64, n: usize, k: f64| z * Complex64::from_polar(1.0, k * n as f64);
        let carrier: Complex64 = wave.iter().enumerate().map(|(n, z)| turned(z, n, q)).sum();
        let count = if (0.5 * self.p).cos().abs() < 1e-12 { 2.0 } else { 1.0 };
        let side = |p: f64| {
            let differences = wave.iter().zip(changed).enumerate();
            differences.map(|(n, (z, x))| turned(&(x - z), n, q - p)).sum::<Complex64>() / (carrier * count)
        };
        dot(self.left, [side(self.p), side(-self.p).conj()])
    }
}

/// `D_n` of a state of the strain ring at time `t`.
///
/// It follows from the motion of beads relative to resonators,
/// `x - y = 2 kappa epsilon (1 + 1/rho) Re(D e^{i omega t})`, and its rate to first order.
pub fn strains(wave: &TravellingWave, t: f64, [x, y, x_dot, y_dot]: [&[f64]; 4]) -> Vec<Complex64> {
    let (params, omega) = (wave.params(), wave.params().omega());
    let scale =
        Complex64::from_polar(1.0, -omega * t) / (2.0 * params.kappa * wave.epsilon() * (1.0 + params.rho.recip()));
    let site = |n: usize| Complex64::new(x[n] - y[n], -(x_dot[n] - y_dot[n]) / omega) * scale;
    (0..x.len()).map(site).collect()
}

/// `a . b`, without a conjugate.
fn dot(a: [Complex64; 2], b: [Complex64; 2]) -> Complex64 {
    a[0] * b[0] + a[1] * b[1]
}

fn length(z: [Complex64; 2]) -> f64 {
    z[0].norm().hypot(z[1].norm())
}

fn longer(a: [Complex64; 2], b: [Complex64; 2]) -> [Complex64; 2] {
    if length(a) >= length(b) { a } else { b }
}

fn unit(z: [Complex64; 2]) -> Option<[Complex64; 2]> {
    let length = length(z);
    (length > 0.0).then(|| z.map(|z| z / length))
}
