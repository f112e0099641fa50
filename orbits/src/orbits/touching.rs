//! How families of orbits begin where beads just touch, so that contacts have no stiffness at rest.
//!
//! | symbol | meaning |
//! |---|---|
//! | `d` | static overlap of every contact that is taken away, from `8 a` to 0 |
//! | `a, xi` | amplitude and shape of an orbit, as in [`normal_modes`](super::normal_modes) |
//! | `a_n, omega_0` | homoclinic solution of the DpS equation about a site or a bond, its frequency |
//! | `k, m, A` | spring and mass of a bead, constant of its contacts |
//!
//! Between walls or on a ring the equations of such beads are invariant under `q(t) -> s
//! q(s^{(alpha-1)/2} t)`: a family has one shape, and frequencies like `a^{(alpha-1)/2}`, or
//! `E^{(alpha-1)/(2(alpha+1))}` in the energy. Its first orbit is that of the chain with the
//! overlap `d`, nearly a linear mode where `d` is large, as `d` falls to zero. Where each bead has
//! a spring, all linear modes have the frequency `(k/m)^{1/2}`. There breathers begin as `u_n = 2
//! epsilon a_n` with the frequency `(k/m)^{1/2} (1 + omega_0 A epsilon^{alpha-1}/k)` (James 2011).

use super::{
    arclength::{self, Solution},
    linear_modes::{LinearMode, NormalModes, loaded},
    shooting::Equations,
};
use crate::{
    chain::Variations,
    dps::{Center, Homoclinic},
    error::{Error, Result},
};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

/// First and last static overlap of a chain whose load is taken away, in units of the amplitude.
const LOADS: [f64; 2] = [8.0, 1e-3];
/// First ratio of an overlap to the one before it; where Newton's corrections do not contract, the
/// root is taken, down to about this share of a change.
const RATIO: f64 = 0.6;
const LEAST_CHANGE: f64 = 1e-3;
/// Largest change of an unknown by Newton's method on this way.
const NEAR: f64 = 0.2;
const LOST: &str = "there is no orbit near that of the chain under a load, as the load is taken away";

/// A breather of the DpS equation as the first orbit of a family.
pub(super) struct Localised {
    pub(super) shape: Vec<f64>,
    /// `omega_0 A/k (2 |a_0|)^{1-alpha}`.
    rate: f64,
    alpha: f64,
}

impl Localised {
    /// `w`, the logarithm of the frequency over that of the linear modes, at an amplitude.
    pub(super) fn w(&self, a: f64) -> f64 {
        (self.rate * a.abs().powf(self.alpha - 1.0)).ln_1p()
    }
}

/// The breather in the middle of the chain, if one begins there.
pub(super) fn localised(modes: &NormalModes) -> Result<Option<Localised>> {
    let Some(center) = modes.center else { return Ok(None) };
    let (chain, n, mode) = (modes.chain(), modes.coordinates(), &modes.linear()[modes.most_localised()]);
    let alpha = chain.params().alpha;
    let profile = Homoclinic::new(alpha, center)?;
    let shape = (0..n).map(|i| profile.a(i as i64 - mode.leading as i64) / profile.a(0)).collect();
    let contact = chain.details().and_then(|details| details.contact.first()).copied().unwrap_or(1.0);
    let spring = mode.omega * mode.omega * chain.masses(mode.leading)[0];
    let rate = profile.omega_0() * contact / spring * (2.0 * profile.a(0).abs()).powf(1.0 - alpha);
    Ok(Some(Localised { shape, rate, alpha }))
}

/// The first orbit of a chain whose beads just touch, with the number of its linear mode, at the
/// amplitude `a`; `solve` finds the orbit of a setting near a seed.
pub(super) fn unloaded(
    modes: &NormalModes,
    number: usize,
    a: f64,
    solve: impl Fn(&NormalModes, &[f64]) -> Result<Solution>,
) -> Result<Solution> {
    let (linear, [most, least]) = (&modes.linear()[number], LOADS.map(|load| load * a));
    let at = |overlap: f64| NormalModes::held(&loaded(modes.chain(), overlap)?, &[]);
    let first = at(most)?;
    let mode = &first.linear()[number];
    let shape: Vec<f64> = mode.shape.iter().map(|s| s / mode.shape[linear.leading]).collect();
    // The slope of w over ln d; that of linear modes at first.
    let (mut overlap, mut ratio, mut slope) = (most / RATIO, RATIO, 0.5 * (modes.chain().params().alpha - 1.0));
    let mut z = linear.unknowns(&shape, (mode.omega / linear.omega).ln() - slope * ratio.ln());
    loop {
        let next = if overlap < least { 0.0 } else { overlap * ratio };
        let mut setting = if next > 0.0 { at(next)? } else { modes.clone() };
        setting.linear.clone_from(&modes.linear);
        let by = if next > 0.0 { slope * ratio.ln() } else { 0.0 };
        let mut seed = z.clone();
        seed.last_mut().into_iter().for_each(|w| *w += by);
        let near = |found: &Solution| {
            let chord = found.z.iter().zip(&seed).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
            chord <= NEAR && !arclength::strays(0.0, 0.0, &found.newton)
        };
        match solve(&setting, &seed).ok().filter(near) {
            Some(found) if next == 0.0 => return Ok(found),
            Some(found) => {
                slope = (w(&found) - seed[seed.len() - 1] + by) / ratio.ln();
                (z, overlap) = (found.z, next);
                ratio = (ratio * ratio).max(RATIO);
            }
            _ if 1.0 - ratio > LEAST_CHANGE && next > 0.0 => ratio = ratio.sqrt(),
            _ => return Err(Error::parameter("linear_mode", number + 1, LOST)),
        }
    }
}

/// Conditions for the orbits that are symmetric about the centre. Those about a bond have
/// `u_n(t) = -u_{-n}(t)` for sites counted from the centre, those about a site
/// `u_n(t) = -u_{-n}(t + T/2)`. With the reversal of time, `u_n + u_{-n}` and `u_n' - u_{-n}'`
/// vanish, at `T/2` and at `T/4`. Equations without the symmetry would be nearly singular.
pub(super) fn symmetric(
    modes: &NormalModes,
    linear: &LinearMode,
    z: &[f64],
    a: f64,
    derivative: bool,
) -> Result<Equations> {
    let m = modes.coordinates();
    let (shape, omega) = linear.parts(z);
    let share = if modes.center == Some(Center::Site) { 0.5 } else { 1.0 };
    let (start, t) = (modes.start(a, &shape), share * PI / omega);
    let end = Variations::flow(modes.chain(), &start, (0.0, t), &[], 1e-14)?.state;
    let (q, q_dot) = (DVector::from_column_slice(&end[..m]) / a, &end[modes.chain().layout().half()..][..m]);
    let q_dot = DVector::from_column_slice(q_dot) / (a * omega);
    // Rows of these numbers, or of their derivatives, to those of the equations.
    let folded = |q: &DMatrix<f64>, q_dot: &DMatrix<f64>| {
        DMatrix::from_fn(m, q.ncols(), |k, j| match k.checked_sub(m.div_ceil(2)) {
            None => q[(k, j)] + q[(m - 1 - k, j)],
            Some(k) => q_dot[(k, j)] - q_dot[(m - 1 - k, j)],
        })
    };
    let column = |x: &DVector<f64>| DMatrix::from_column_slice(m, 1, x.as_slice());
    let residual = folded(&column(&q), &column(&q_dot)).column(0).into_owned();
    if !derivative {
        return Ok(Equations { residual, jacobian: DMatrix::zeros(m, 0) });
    }
    let others: Vec<usize> = (0..m).filter(|&k| k != linear.leading).collect();
    let (acceleration, _) = modes.linearised(&end)?;
    let tangent = modes.tangent(&start, t, &others)?;
    let by_shape = folded(&tangent.rows(0, m).into_owned(), &(tangent.rows(m, m) / omega));
    let by_w = folded(&column(&(-&q_dot * (t * omega))), &column(&(-acceleration * (t / (a * omega)) - &q_dot)));
    let mut jacobian = by_shape.insert_column(m - 1, 0.0);
    jacobian.set_column(m - 1, &by_w.column(0));
    Ok(Equations { residual, jacobian })
}

/// `w`, the last of the unknowns.
fn w(solution: &Solution) -> f64 {
    solution.z.last().copied().unwrap_or(0.0)
}
