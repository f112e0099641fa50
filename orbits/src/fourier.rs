//! Discrete Fourier transforms of any length.
//!
//! ```text
//! F_k = sum_j f_j e^{-2 pi i j k/n},     j k = (j^2 + k^2 - (k - j)^2)/2
//! ```
//!
//! Powers of two by J. W. Cooley & J. W. Tukey 1965, Math. Comput. 19, 297; other lengths as a
//! convolution of the length of a power of two, by the second equation: L. I. Bluestein 1970, IEEE
//! Trans. Audio Electroacoust. 18, 451.

use nalgebra::Complex;
use std::f64::consts::PI;

/// The transform of some numbers; the error is a few roundings of its size.
///
/// ```
/// use hertzchain_orbits::fourier::fourier;
/// use nalgebra::Complex;
/// let turn = 2.0 * std::f64::consts::PI * 5.0 / 12.0;
/// let wave: Vec<_> = (0..12).map(|j| Complex::from_polar(1.0, turn * j as f64)).collect();
/// let transform = fourier(&wave);
/// assert!((transform[5] - Complex::new(12.0, 0.0)).norm() < 1e-13 && transform[7].norm() < 1e-13);
/// ```
pub fn fourier(values: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let n = values.len();
    if n < 2 || n.is_power_of_two() {
        return of_power_of_two(values.to_vec());
    }
    let size = (2 * n - 1).next_power_of_two();
    // e^{-pi i j^2/n}, whose exponent has the period 2 n in j^2.
    let turn = |j: usize| Complex::from_polar(1.0, -PI * ((j as u128).pow(2) % (2 * n as u128)) as f64 / n as f64);
    let turns: Vec<Complex<f64>> = (0..n).map(turn).collect();
    let (mut signal, mut kernel) = (vec![Complex::default(); size], vec![Complex::default(); size]);
    for (j, (value, turn)) in values.iter().zip(&turns).enumerate() {
        signal[j] = value * turn;
        (kernel[j], kernel[(size - j) % size]) = (turn.conj(), turn.conj());
    }
    let (signal, kernel) = (of_power_of_two(signal), of_power_of_two(kernel));
    // The inverse transform is that of the conjugates, over the length.
    let product = signal.iter().zip(&kernel).map(|(a, b)| (a * b).conj()).collect();
    let sums = of_power_of_two(product);
    sums.into_iter().zip(turns).map(|(sum, turn)| sum.conj() * turn / size as f64).collect()
}

fn of_power_of_two(mut values: Vec<Complex<f64>>) -> Vec<Complex<f64>> {
    let n = values.len();
    for (i, j) in (0..n).map(|i| (i, i.reverse_bits() >> (1 + n.leading_zeros()).min(63))).filter(|(i, j)| i < j) {
        values.swap(i, j);
    }
    let turns: Vec<Complex<f64>> =
        (0..n / 2).map(|k| Complex::from_polar(1.0, -2.0 * PI * k as f64 / n as f64)).collect();
    let mut half = 1;
    while half < n {
        let stride = n / (2 * half);
        for block in values.chunks_exact_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for (k, (a, b)) in low.iter_mut().zip(high).enumerate() {
                let turned = *b * turns[k * stride];
                (*a, *b) = (*a + turned, *a - turned);
            }
        }
        half *= 2;
    }
    values
}
