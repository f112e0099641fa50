//! The averages of a periodically opening contact, (eq:aux1) and (eq:aux2).
//!
//! | symbol | meaning |
//! |---|---|
//! | `b, r` | mean strain and amplitude of the bond `-b + 2 kappa r cos t` |
//! | `t_c` | half the contact time: `cos t_c = b / (2 kappa r)`, `pi` for a bond that never opens |

use std::f64::consts::{FRAC_PI_2, PI};

/// `g_alpha(b, r) = 1/(2 pi) int_0^{2 pi} (-b + 2 kappa r cos t)_+^alpha dt` (eq:aux1), the mean contact force.
///
/// Zero for `b >= 2 kappa r`. Relative error about 1e-14.
pub fn g_alpha(alpha: f64, kappa: f64, b: f64, r: f64) -> f64 {
    average(alpha, kappa, b, r, |_| 1.0)
}

/// `r h_alpha(b, r) = 1/(2 pi) int_0^{2 pi} e^{-it} (-b + 2 kappa r cos t)_+^alpha dt` (eq:aux2), the first harmonic.
///
/// Zero for `b >= 2 kappa r`. Error about 1e-14 relative to `g_alpha`.
///
/// ```
/// // b = 0 has a closed form: h_{3/2}(0, 1) = 2^{1/2} c, c = Gamma(1/2) Gamma(7/4) / (pi Gamma(9/4)).
/// let h = hertzchain::dps::r_h_alpha(1.5, 1.0, 0.0, 1.0);
/// assert!((h - 0.647_223_121_426_055_2).abs() < 1e-14);
/// ```
pub fn r_h_alpha(alpha: f64, kappa: f64, b: f64, r: f64) -> f64 {
    average(alpha, kappa, b, r, f64::cos)
}

/// `1/pi int_0^{t_c} (-b + 2 kappa r cos t)^alpha weight(t) dt`.
fn average(alpha: f64, kappa: f64, b: f64, r: f64, weight: impl Fn(f64) -> f64) -> f64 {
    let swing = 2.0 * kappa * r;
    // 1 - cos t_c, without cancellation where the contact is short.
    let versine = (swing - b) / swing;
    if versine <= 0.0 {
        return 0.0;
    }
    let opens = versine < 2.0;
    let t_c = if opens { 2.0 * (0.5 * versine).sqrt().asin() } else { PI };
    let integral = double_exponential(|rest| {
        let t = t_c * (1.0 - rest);
        let overlap = if opens {
            2.0 * swing * (t_c * (1.0 - 0.5 * rest)).sin() * (0.5 * t_c * rest).sin()
        } else {
            swing * t.cos() - b
        };
        overlap.max(0.0).powf(alpha) * weight(t)
    });
    t_c / PI * integral
}

/// `int_0^1 f(1 - x) dx` by the double exponential rule, which endpoint singularities do not harm.
///
/// `f` gets the distance from the upper end, which keeps its relative accuracy where `1 - x` would lose it.
fn double_exponential(f: impl Fn(f64) -> f64) -> f64 {
    const STEP: f64 = 1.0 / 32.0;
    (-140..=140)
        .map(|k| {
            let s = STEP * f64::from(k);
            let rest = 1.0 / (1.0 + (2.0 * FRAC_PI_2 * s.sinh()).exp());
            let complement = 1.0 / (1.0 + (-2.0 * FRAC_PI_2 * s.sinh()).exp());
            f(rest) * PI * s.cosh() * rest * complement
        })
        .sum::<f64>()
        * STEP
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn quadratic_contacts_have_elementary_averages() {
        // alpha = 2, b = -c <= -2 kappa r (never open): g = c^2 + (2 kappa r)^2 / 2, r h = c (2 kappa r).
        let (kappa, c, r) = (0.7, 3.0, 1.1);
        let swing = 2.0 * kappa * r;
        assert_relative_eq!(g_alpha(2.0, kappa, -c, r), c * c + 0.5 * swing * swing, max_relative = 1e-14);
        assert_relative_eq!(r_h_alpha(2.0, kappa, -c, r), c * swing, max_relative = 1e-14);
        // alpha = 1, b = 0: g = swing / pi, r h = swing / 4.
        assert_relative_eq!(g_alpha(1.0, kappa, 0.0, r), swing / PI, max_relative = 1e-14);
        assert_relative_eq!(r_h_alpha(1.0, kappa, 0.0, r), swing / 4.0, max_relative = 1e-14);
    }

    #[test]
    fn a_bond_that_never_closes_has_no_force() {
        assert_eq!(g_alpha(1.5, 1.0, 2.0, 1.0), 0.0);
        assert_eq!(r_h_alpha(1.5, 1.0, 2.5, 1.0), 0.0);
        // Just below, both vanish like (1 - b/2r)^{alpha+1/2}: the ratio at two distances shows it.
        let at = |d: f64| g_alpha(1.5, 1.0, 2.0 * (1.0 - d), 1.0);
        assert!(((at(2f64.powi(-20)) / at(2f64.powi(-22))).log2() / 2.0 - 2.0).abs() < 1e-5);
    }
}
