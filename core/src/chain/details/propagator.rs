//! The exact motion of one site over a time, without its contacts.
//!
//! | symbol | meaning |
//! |---|---|
//! | `z` | `[u, v, u', v']`, or `[R, P, R', P'/omega]` for the modes of a site without damping |
//! | `s` | a power of two, near the least time of a site's oscillations and dampers |
//! | `E(t)` | `exp(A t)`, with `z' = A z` for `z = [u, v, s u', s v']` |
//! | `Q(t)` | `int_0^t E^T D E ds`: `z^T Q z` is the energy dissipated at the power `z^T D z` |
//!
//! The norm of `A` is thus a rate, and the same motion has the same digits in all units of time.
//! Both are computed for a short time, by Taylor's series and a Gauss rule, and then for the whole
//! time by doubling: `E(2t) = E(t)^2` and `Q(2t) = Q(t) + E(t)^T Q(t) E(t)`. For a time that a run
//! does not repeat, `z` itself is moved by Taylor's series, which costs about a hundredth of that.

use super::{
    super::{Modes, Params, Resonators, Split, gauss::gauss},
    SiteData,
};
use hertzchain_integrators::{DoubleDouble, Real, Rotation};

/// A 4 x 4 matrix, by rows.
type Matrix<R> = [[R; 4]; 4];

/// Norm of `A t` up to which Taylor's series with [`TERMS`] terms is exact to rounding, also in
/// double-double.
const SHORT: f64 = 0.5;
const TERMS: usize = 26;
/// Most short times over which a site is moved one after the other; beyond that, matrices are
/// doubled. Chosen: they cost about the same there.
const MOST_SHORT: f64 = 64.0;

/// A class of sites with the same motion between contacts, and the parameters of this motion.
#[derive(Clone, Copy, Debug)]
pub(super) enum Class<R> {
    /// A site whose position is prescribed.
    Moved,
    /// A site without spring, or with an undamped spring that is part of the drift: `R` moves
    /// freely, `P` oscillates.
    Modes(Modes<R>),
    /// Any other site: `A`, the time `s`, and the coefficients of drag and dashpot over `s^2`;
    /// `straight` if bead and resonator move freely.
    Linear { a: Matrix<R>, unit: R, losses: [R; 2], straight: bool },
}

/// The motion of the sites of a class over a given time.
#[derive(Clone, Debug)]
pub(super) enum Propagator<R> {
    Moved,
    /// The time, and the rotation of `P`.
    Modes(R, Rotation<R>),
    /// `E`, and `Q` of drag and dashpot, of `[u, v, u', v']`.
    Linear(Box<[Matrix<R>; 3]>),
}

impl<R: Real> Class<R> {
    /// The class of a site, with its spring in the drift or in the kick.
    pub(super) fn new(site: &SiteData<R>, split: Split) -> Self {
        let (zero, one) = (R::zero(), R::one());
        if site.moved {
            return Self::Moved;
        }
        let damped = site.drag + site.dashpot > zero;
        let params = Params { alpha: 1.0, kappa: (site.kappa / site.mass).f64(), rho: site.rho.f64() };
        // If springs are part of the kick, bead and resonator move freely: there are no modes.
        let bound = split == Split::Linear || site.resonators == Resonators::None;
        if !damped && bound && site.onsite == zero {
            return Self::Modes(Modes::new(params));
        }
        let drifts = split == Split::Linear && site.resonators != Resonators::None;
        let [spring, onsite] = [site.kappa, site.onsite].map(|spring| if drifts { spring } else { zero });
        let (mut a, dashpot) = ([[zero; 4]; 4], site.dashpot);
        (a[0][2], a[1][3]) = (one, one);
        let force = [-(spring + onsite), spring, -(dashpot + site.drag), dashpot];
        a[2] = force.map(|force| force / site.mass);
        if site.resonators == Resonators::Moving {
            a[3] = [spring, -spring, dashpot, -dashpot].map(|force| force / site.resonator());
        } else {
            (a[1][3], a[2][1], a[2][3]) = (zero, zero, zero);
        }
        let stiffest = a[2][0].abs().max(a[3][1].abs()).f64().sqrt();
        let fastest = stiffest.max(a[2][2].abs().max(a[3][3].abs()).f64());
        let power = if fastest > 0.0 { -(fastest.log2().round() as i32) } else { 0 };
        let unit = R::of(2f64.powi(power));
        for row in &mut a {
            (row[2], row[3]) = (row[2] / unit, row[3] / unit);
        }
        a[2..].iter_mut().flatten().for_each(|entry| *entry *= unit);
        let losses = [site.drag, dashpot].map(|rate| rate / unit / unit);
        Self::Linear { a, unit, losses, straight: !damped && onsite == zero }
    }

    /// `z` from a site.
    pub(super) fn split(&self, [u, v, u_dot, v_dot]: [R; 4]) -> [R; 4] {
        match self {
            Self::Modes(modes) => {
                let [r, r_dot, p, s] = modes.path([u, v, u_dot, v_dot]);
                [r, p, r_dot, s]
            }
            _ => [u, v, u_dot, v_dot],
        }
    }

    /// The site from `z`.
    pub(super) fn join(&self, z: [R; 4], resonators: Resonators) -> [R; 4] {
        match self {
            Self::Modes(modes) => {
                let [r, p, r_dot, s] = z;
                let site = modes.join([r, r_dot, p, s * modes.omega.value()]);
                if resonators == Resonators::Moving { site } else { [site[0], R::zero(), site[2], R::zero()] }
            }
            _ => z,
        }
    }

    /// The position and the velocity of the bead.
    #[inline]
    pub(super) fn bead(&self, z: &[R; 4]) -> [R; 2] {
        match self {
            Self::Modes(modes) => [z[0] + z[1], z[2] + z[3] * modes.omega.value()],
            _ => [z[0], z[2]],
        }
    }

    /// The factors by which an impulse on the bead, over its mass, is added to `z[2]` and `z[3]`.
    pub(super) fn shares(&self) -> [R; 2] {
        match self {
            Self::Modes(modes) => [modes.m, modes.mu_over_omega()],
            _ => [R::one(), R::zero()],
        }
    }

    /// Moves a site on by the time `dt`, as [`over`](Self::over) and [`apply`](Propagator::apply)
    /// do up to rounding; returns the energies that drag and dashpot have dissipated.
    pub(super) fn advance(&self, z: &mut [R; 4], dt: DoubleDouble<R>) -> [R; 2] {
        match self {
            Self::Modes(modes) => {
                let angle = (modes.omega * dt).reduced(DoubleDouble::two_pi());
                Propagator::Modes(dt.value(), Rotation::near(angle)).apply(z)
            }
            Self::Linear { a, unit, losses, .. } if short_times(a, dt.value()) <= MOST_SHORT => {
                z[2..].iter_mut().for_each(|rate| *rate *= *unit);
                let lost = along(a, *losses, z, dt.value());
                z[2..].iter_mut().for_each(|rate| *rate /= *unit);
                lost
            }
            _ => self.over(dt).apply(z),
        }
    }

    /// The motion over the time `dt`.
    pub(super) fn over(&self, dt: DoubleDouble<R>) -> Propagator<R> {
        match self {
            Self::Moved => Propagator::Moved,
            Self::Modes(modes) => {
                let angle = (modes.omega * dt).reduced(DoubleDouble::two_pi());
                Propagator::Modes(dt.value(), Rotation::by(angle))
            }
            Self::Linear { a, unit, losses, .. } => {
                let units = [R::one(), R::one(), *unit, *unit];
                let [mut e, mut drag, mut dashpot] = doubled(a, *losses, dt.value());
                for (i, j) in (0..16).map(|k| (k / 4, k % 4)) {
                    e[i][j] *= units[j] / units[i];
                    drag[i][j] *= units[i] * units[j];
                    dashpot[i][j] *= units[i] * units[j];
                }
                Propagator::Linear(Box::new([e, drag, dashpot]))
            }
        }
    }
}

impl<R: Real> Propagator<R> {
    /// Moves a site on; returns the energies that drag and dashpot have dissipated.
    #[inline]
    pub(super) fn apply(&self, z: &mut [R; 4]) -> [R; 2] {
        match self {
            Self::Moved => [R::zero(); 2],
            Self::Modes(dt, Rotation { sin, cos }) => {
                let [r, p, r_dot, s] = *z;
                // The low parts keep the rotation from growing or shrinking over many steps.
                let turned = |a: R, b: R, sin: &DoubleDouble<R>| (cos.hi * a + sin.hi * b) + (cos.lo * a + sin.lo * b);
                *z = [r + *dt * r_dot, turned(p, s, sin), r_dot, turned(s, p, &-*sin)];
                [R::zero(); 2]
            }
            Self::Linear(matrices) => {
                let [e, drag, dashpot] = &**matrices;
                let lost = [form(drag, z), form(dashpot, z)];
                *z = std::array::from_fn(|i| dot(&e[i], z));
                lost
            }
        }
    }
}

fn dot<R: Real>(a: &[R; 4], b: &[R; 4]) -> R {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}

/// `z^T Q z`; zero for a damper that is absent, whose `Q` is zero.
fn form<R: Real>(q: &Matrix<R>, z: &[R; 4]) -> R {
    if q[2][2] == R::zero() {
        return R::zero();
    }
    (0..4).fold(R::zero(), |sum, i| sum + z[i] * dot(&q[i], z))
}

fn product<R: Real>(a: &Matrix<R>, b: &Matrix<R>) -> Matrix<R> {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).fold(R::zero(), |sum, k| sum + a[i][k] * b[k][j])))
}

fn transposed<R: Real>(a: &Matrix<R>) -> Matrix<R> {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

fn plus<R: Real>(a: &Matrix<R>, b: &Matrix<R>) -> Matrix<R> {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] + b[i][j]))
}

fn identity<R: Real>() -> Matrix<R> {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { R::one() } else { R::zero() }))
}

/// `exp(A t)` for a short time, by Horner's rule.
fn taylor<R: Real>(a: &Matrix<R>, t: R) -> Matrix<R> {
    let scaled = a.map(|row| row.map(|x| x * t));
    (1..=TERMS).rev().fold(identity(), |sum, k| {
        let per = R::of(k as f64).recip();
        plus(&identity(), &product(&scaled, &sum).map(|row| row.map(|x| x * per)))
    })
}

/// The number of short times that a time of either sign has.
fn short_times<R: Real>(a: &Matrix<R>, dt: R) -> f64 {
    let norm = a.iter().map(|row| row.iter().fold(R::zero(), |sum, x| sum + x.abs()).f64()).fold(0.0, f64::max);
    norm * dt.f64().abs() / SHORT
}

/// Moves `z` on by short times that add up to `dt`, each by Taylor's series `z(t) = sum_k t^k A^k
/// z/k!`. Returns the energies that drag and dashpot dissipate: the integrals of the squares of
/// such series.
fn along<R: Real>(a: &Matrix<R>, [drag, dashpot]: [R; 2], z: &mut [R; 4], dt: R) -> [R; 2] {
    let parts = short_times(a, dt).ceil().max(1.0);
    let short = dt * R::of(parts).recip();
    let mut lost = [R::zero(); 2];
    for _ in 0..parts as usize {
        let (mut terms, mut last) = ([*z; TERMS], 0);
        let largest = |z: &[R; 4]| z.iter().fold(R::zero(), |most, x| most.max(x.abs()));
        let least = R::epsilon() * R::of(SHORT.powi(8)) * largest(z);
        while last + 1 < TERMS && largest(&terms[last]) > least {
            let per = short * R::of((last + 1) as f64).recip();
            terms[last + 1] = std::array::from_fn(|i| per * dot(&a[i], &terms[last]));
            last += 1;
        }
        let terms = &terms[..=last];
        for (lost, (rate, other)) in lost.iter_mut().zip([(drag, None), (dashpot, Some(3))]) {
            if rate > R::zero() {
                *lost += rate * short * square(terms, |z| z[2] - other.map_or(R::zero(), |i: usize| z[i]));
            }
        }
        *z = std::array::from_fn(|i| terms.iter().rev().fold(R::zero(), |sum, term| sum + term[i]));
    }
    lost
}

/// `int_0^1 v^2 ds` of a series `v = sum_k v_k s^k`, up to the power of its last term.
fn square<R: Real>(terms: &[[R; 4]], of: impl Fn(&[R; 4]) -> R) -> R {
    (0..terms.len()).rev().fold(R::zero(), |sum, k| {
        let coefficient = (0..=k).fold(R::zero(), |sum, j| sum + of(&terms[j]) * of(&terms[k - j]));
        sum + coefficient * R::of((k + 1) as f64).recip()
    })
}

/// `E`, and `Q` of drag and dashpot, over a time of either sign.
fn doubled<R: Real>(a: &Matrix<R>, [drag, dashpot]: [R; 2], dt: R) -> [Matrix<R>; 3] {
    let doublings = short_times(a, dt).log2().ceil().max(0.0) as i32;
    let short = dt * R::of(2f64.powi(-doublings));
    let zero = [[R::zero(); 4]; 4];
    let (mut e, mut losses) = (taylor(a, short), [zero; 2]);
    if drag + dashpot > R::zero() {
        losses = [([2, 2], drag), ([2, 3], dashpot)].map(|(rows, rate)| over_short(a, rows, rate, short));
    }
    for _ in 0..doublings {
        losses = losses.map(|q| plus(&q, &product(&transposed(&e), &product(&q, &e))));
        e = product(&e, &e);
    }
    [e, losses[0], losses[1]]
}

/// `Q` over a short time of a damper between two velocities, or of one to the ground if they are
/// the same.
fn over_short<R: Real>(a: &Matrix<R>, [i, j]: [usize; 2], rate: R, short: R) -> Matrix<R> {
    let integrand = |s: R| {
        let e = taylor(a, s);
        let row: [R; 4] = std::array::from_fn(|k| if i == j { e[i][k] } else { e[i][k] - e[j][k] });
        let flat: [R; 16] = std::array::from_fn(|k| rate * row[k / 4] * row[k % 4]);
        flat
    };
    let flat = gauss(integrand, R::zero(), short);
    std::array::from_fn(|i| std::array::from_fn(|j| flat[4 * i + j]))
}
