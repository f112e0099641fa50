//! Chapter: a perturbation of a wave that grows, for each Bloch wave number of a piece ("Waves" in
//! `README.md`).
//!
//! Unknowns are its coefficients and `lambda`, of which further unknowns are the real and the
//! imaginary part. Along a piece `p = p_0 + h s`, `-1 <= s <= 1`. What depends on it is
//! `u_0 + u_1 s` and a rest.

use super::{
    Refused, System,
    newton::{Place, kronecker, largest, sums},
    of,
    perturbed::{Complex, Equations, Factors, Field, Terms, ZERO, inverse, own_of, plus, scaled, sizes_of, times},
    system::{half_angle, poles},
};
use crate::{
    certificate::{Certificate, Orbit},
    exact::Exact,
    interval::Interval,
    untrusted::choices,
};
use std::fmt::{self, Display, Formatter};

/// `K` and `K'` of this proof for one wave number, and for an interval of them; at most an eighth
/// of that of the certificate, and that.
const SIZES: [[usize; 2]; 2] = [[32, 512], [16, 256]];

/// A perturbation `e^{i p n + lambda t} W(q n - omega t)` of a wave, for each `p` of an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bloch {
    /// The Bloch wave numbers at its ends, as `p/pi`.
    pub p_over_pi: [Exact; 2],
    /// Growth rate and frequency, real and imaginary part of a number near `lambda` in the middle.
    pub rate: [Exact; 2],
    /// By how much this changes from the middle to the end; it is linear in `p`.
    pub change: [Exact; 2],
    /// `lambda` is at most this far from it.
    pub radius: Exact,
}

impl Display for Bloch {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { p_over_pi: [from, to], rate: [re, im], change: [by_re, by_im], radius } = self;
        match from == to {
            true => writeln!(f, "multiplier bloch {from} {re} {im} {radius}"),
            false => writeln!(f, "multiplier bloch {from} {to} {re} {im} {by_re} {by_im} {radius}"),
        }
    }
}

/// The rule of these lines.
pub(crate) fn rule(certificate: &Certificate) -> bool {
    let grows = |it: &Bloch| {
        let [[from, to], [re, im], [by_re, by_im]] =
            [it.p_over_pi, it.rate, it.change].map(|it| it.map(Exact::enclosed));
        let (radius, omega) = (it.radius.enclosed(), certificate.model.omega.enclosed());
        let rates = [re - by_re.abs() - radius, omega - (im.abs() + by_im.abs() + radius), radius];
        (it.p_over_pi[0] == it.p_over_pi[1] || (to - from).is_positive()) && rates.iter().all(|it| it.is_positive())
    };
    let all = &certificate.bloch;
    let joined = all.windows(2).all(|two| two[0].p_over_pi[1] == two[1].p_over_pi[0]);
    all.is_empty() || joined && certificate.to.is_none() && certificate.is_wave() && all.iter().all(grows)
}

/// `[u_0, u_1, rest]`.
type Linear = [Complex; 3];

/// All values along a piece.
fn along(u: Linear) -> Complex {
    plus(plus(u[0], scaled(Interval::ONE.ball(), u[1])), u[2])
}

fn product(u: Linear, v: Linear) -> Linear {
    let square = scaled(Interval::new(0.0, 1.0), times(u[1], v[1]));
    let rest = plus(times(along([u[0], u[1], ZERO]), v[2]), times(u[2], along(v)));
    [times(u[0], v[0]), plus(times(u[0], v[1]), times(u[1], v[0])), plus(square, rest)]
}

/// `1/u = v + (1 - u v)/u` for the linear part `v`.
fn reciprocal(u: Linear) -> Linear {
    let value = inverse(u[0]);
    let slope = scaled(-Interval::ONE, times(u[1], times(value, value)));
    let left = plus([Interval::ONE, Interval::ZERO], scaled(-Interval::ONE, along(product(u, [value, slope, ZERO]))));
    [value, slope, times(left, inverse(along(u)))]
}

/// The equations of a piece.
pub(crate) fn equations<'a>(certificate: &'a Certificate, system: &'a System, piece: &Bloch) -> Equations<'a> {
    let [block, enclosed] = SIZES[usize::from(piece.p_over_pi[0] != piece.p_over_pi[1])];
    let sizes = [block.min(certificate.enclosed / 8), enclosed.min(certificate.enclosed)];
    Equations::new(certificate, system, sizes, None)
}

/// `l_k` and `l_{-k}` at `lambda_0 + lambda_1 s`: `u_0`, `u_1` and the rest; their derivatives by
/// `lambda`, and `i` times these, and all values, where `lambda` is at most the radius of the piece
/// away in real and imaginary part.
///
/// `4 sin^2` of half of `a + h s` is `4 sin^2(a/2) + h s 2 sin a`, and a rest of at most `h^2`.
pub fn factors(certificate: &Certificate, system: &System, piece: &Bloch, rate: [Complex; 2]) -> [Factors; 6] {
    let (poles, [from, to]) = (poles(&certificate.model), piece.p_over_pi.map(|p| p.enclosed() * Interval::PI));
    let (quarter, half, near) = ((from + to) / of(4), (to - from) / of(2), [piece.radius.enclosed().ball(); 2]);
    let factor = |k: usize, sign: i128| {
        let turn = Interval::exact(sign as f64) * of(k) * system.omega();
        let Orbit::Wave { q_over_pi } = certificate.orbit else { return [[Interval::exact(f64::NAN); 2]; 6] };
        let [sin, cos] = (quarter + half_angle(q_over_pi, -sign * k as i128)).sin_cos();
        let lattice = [of(4) * sin.square(), of(4) * half * sin * cos, half.square().ball()];
        let lattice = lattice.map(|it| [it, Interval::ZERO]);
        let s = [plus(rate[0], [Interval::ZERO, turn]), rate[1], ZERO];
        let (all, mut value, mut slope) = (plus(along(s), near), [ZERO; 3], ZERO);
        for &[c, p, r] in &poles {
            let [first, second, rest] = product(s, s).map(|it| scaled(r, it));
            let term = reciprocal([plus(first, [p, Interval::ZERO]), second, rest]);
            value = [0, 1, 2].map(|i| plus(value[i], scaled(c, term[i])));
            let term = inverse(plus(scaled(r, times(all, all)), [p, Interval::ZERO]));
            slope = plus(slope, scaled(-of(2) * c * r, times(all, times(term, term))));
        }
        let (value, slope) = (product(lattice, value), times(along(lattice), slope));
        [value[0], value[1], value[2], slope, [-slope[1], slope[0]], plus(along(value), times(slope, near))]
    };
    // Two more than K': by Cauchy's bound in a disc of radius omega derivatives beyond have the
    // tail of l over omega.
    let both = |k: usize| [1, -1].map(|sign| factor(k, sign));
    let all: Vec<[[Complex; 6]; 2]> = (0..=system.factors.len() + 1).map(both).collect();
    [0, 1, 2, 3, 4, 5].map(|i| all.iter().map(|both| both.map(|one| one[i])).collect())
}

/// The radius about `lambda_0 + lambda_1 s` that is needed, at most that of the piece, and `q`: for
/// each `p` there is a `lambda`. The strains of the wave differ by at most `changes` from its
/// cosine sum.
pub fn check(
    certificate: &Certificate,
    piece: &Bloch,
    (system, changes): (&System, &[Interval]),
    go_on: &dyn Fn() -> Result<(), Refused>,
) -> Result<[f64; 2], Refused> {
    let (radius, tail) = (piece.radius.enclosed(), system.tails()[0]);
    let rate = [piece.rate, piece.change].map(|it| it.map(|it| it.enclosed()));
    let [start, slope, rest, steep, turned, all] = factors(certificate, system, piece, rate);
    let own = equations(certificate, system, piece);
    let [p, turn] = choices::eigenvector(&own, [&start, &slope]);
    let entry = |(p, turn): (&Interval, &Interval)| *p + turn.abs().ball();
    let wide: Field = p.iter().zip(&turn).map(|(p, turn)| p.iter().zip(turn).map(entry).collect()).collect();
    let places = own.all(own.last());
    let columns = [&steep, &turned].map(|l| places.iter().map(|place| own.force(l, &wide, *place)).collect());
    let terms = Terms::new(own, all, Some(columns.to_vec()), changes);
    let (Terms { it, block, changed, l, .. }, [_, computed]) = (&terms, terms.it.counts());

    // What one unit of sqrt 2 |g|_{L2} does by way of the derivatives of l.
    let late = |last: usize| it.beyond(&steep, last, tail / system.omega());
    let [_, reach] = block.times(&block.rows(|place| it.forces(&steep, place)));
    let contacts = sums(&reach, &terms.far(late(it.last())));
    let size = vec![largest(sizes_of(&wide)); block.sites];
    let column = |(n, near): (usize, Interval)| {
        let of = |l: &Factors| terms.beyond(n, &|place| it.force(l, &wide, place), (&size, &contacts), late(computed));
        near + of(&steep).max(of(&turned))
    };
    let column: Vec<Interval> = block.further_columns().into_iter().enumerate().map(column).collect();
    let mut derivative = terms.derivative(&column, go_on)?;
    // Strains and coefficients in the ball.
    for (row, contacts) in derivative.entries.iter_mut().zip(&contacts) {
        let stiff = terms.steepest.iter().zip(changed).zip(contacts).map(|((a, b), by)| radius * (*a + *b) * *by);
        row.iter_mut().zip(stiff).for_each(|(entry, by)| *entry = *entry + by);
    }

    // The part without s, that with s, and that with s^2.
    let defect = |place: Place| {
        let first = own_of(&p, place) + it.force(&start, &p, place);
        let second = own_of(&turn, place) + it.force(&start, &turn, place) + it.force(&slope, &p, place);
        let third = Interval::new(0.0, 1.0) * it.force(&slope, &turn, place) + it.force(&rest, &wide, place);
        first + second.abs().ball() + third
    };
    let given = it.pinned.iter().zip(0..).map(|(own, which)| own_of(&wide, *own) - kronecker(which == 0));
    let head: Vec<Interval> = block.all.iter().map(|place| defect(*place)).chain(given).collect();
    let t = it.beyond(l, computed, tail);
    let y0 = block.image(&head, |n| terms.beyond(n, &defect, (&size, &derivative.contacts), t));
    let weight = choices::narrowest(&derivative.within(changed), &column, &y0);
    derivative.weights.push(weight);
    let q = derivative.norm(&derivative.within(changed));
    let needed = weight * derivative.norm(&y0) / (Interval::ONE - q);
    let proved = (Interval::ONE - q).is_positive() && needed.hi() <= radius.lo();
    let [radius, q] = [needed, q].map(Interval::hi);
    if proved { Ok([radius, q]) } else { Err(Refused::Bloch { p_over_pi: piece.p_over_pi[0], radius, q }) }
}

/// Bounds of the growth rates of pieces that are proved, of the largest one, and of frequencies.
pub(super) fn growth(pieces: &[Bloch]) -> Option<[Interval; 3]> {
    let bounds = |it: &Bloch| {
        let [[re, im], [grows, turns]] = [it.rate, it.change].map(|it| it.map(|it| it.enclosed()));
        let near = it.radius.enclosed().ball();
        [re + (near + grows.abs().ball()), re + (near + grows.abs()), im + (near + turns.abs().ball())]
    };
    pieces.iter().map(bounds).reduce(|a, b| [a[0].hull(b[0]), a[1].max(b[1]), a[2].hull(b[2])])
}
