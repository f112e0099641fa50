//! Chapter: a perturbation of a wave that grows, for each Bloch wave number of a piece ("Waves" in
//! `README.md`).
//!
//! Unknowns are its coefficients and `lambda`, of which further unknowns are the real and the
//! imaginary part. Along a piece `p = p_0 + h s`, `-1 <= s <= 1`.

use super::{
    Refused, System,
    factors::{Factors, modulated},
    further::Terms,
    newton::{Equations, Matrix, Place, sums},
    perturbed::{Perturbations, own},
};
use crate::{certificate::Certificate, exact::Exact, interval::Interval, untrusted::choices};
use std::{
    fmt::{self, Display, Formatter},
    rc::Rc,
};

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

/// The radius about `lambda_0 + lambda_1 s` that is needed, at most that of the piece, and `q`: for
/// each `p` there is a `lambda`. The strains of the wave differ by at most `changes` from its
/// cosine sum.
pub fn check(
    certificate: &Certificate,
    piece: &Bloch,
    (system, changes): (&Rc<System>, &[Interval]),
    go_on: &dyn Fn() -> Result<(), Refused>,
) -> Result<[f64; 2], Refused> {
    let radius = piece.radius.enclosed();
    let rate = [piece.rate, piece.change].map(|it| it.map(|it| it.enclosed()));
    let [start, slope, rest, steep, all] = modulated(certificate, system, piece, rate);
    let turned = [2, 3, 0, 1].map(|i| steep[i].iter().map(|it| if i > 1 { -*it } else { *it }).collect());
    let by_lambda: [Factors; 2] = [steep, turned];
    let it = Perturbations::new(certificate, system, None, Some(piece));
    let [p, turn] = choices::eigenvector(&it, [&start, &slope]).map(|p| it.series(&p));
    let wide = |p: &Matrix, turn: &Matrix| {
        sums(p, &turn.iter().map(|it| it.iter().map(|it| it.abs().ball()).collect()).collect())
    };
    let [first, second] = [&p, &turn].map(|p| it.forces(p, it.counts()[1]));
    let (z, forces) = (wide(&p, &turn), wide(&first, &second));
    let column = |i: usize, place: Place| it.applied(&by_lambda[i], &forces, place);
    let terms = Terms::new(&it, all, &column, changes);

    // What one unit of sqrt 2 |g|_{L2} does by way of the derivatives of l.
    let late = system.tails()[0] / system.omega();
    let [contacts, turned] = by_lambda.each_ref().map(|l| terms.block.contacts(l, late));
    let of_unknown = |i: usize, contacts| {
        let value = |place| column(i, place);
        terms.with((terms.block.column(i), &value, &z), (&by_lambda[i], late, contacts))
    };
    let columns = of_unknown(0, &contacts).into_iter().zip(of_unknown(1, &turned));
    let column: Vec<Interval> = columns.map(|(re, im)| re.max(im)).collect();
    let mut derivative = terms.derivative(go_on)?;
    // Strains and coefficients in the ball. All functions have the same bounds, so that these sums
    // are those of both derivatives.
    for (row, contacts) in derivative.entries.iter_mut().zip(&contacts) {
        let stiff = terms.steepest.iter().zip(&terms.changed).zip(contacts);
        row.iter_mut().zip(stiff).for_each(|(entry, ((a, b), by))| *entry = *entry + radius * (*a + *b) * *by);
    }

    // The part without s, that with s, and that with s^2.
    let defect = |place: Place| {
        let value = own(&p, place) + it.applied(&start, &first, place);
        let by_s = own(&turn, place) + it.applied(&start, &second, place) + it.applied(&slope, &first, place);
        let squares = Interval::new(0.0, 1.0) * it.applied(&slope, &second, place);
        value + by_s.abs().ball() + squares + it.applied(&rest, &forces, place)
    };
    let y0 = terms.y0(&defect, &z, &derivative.contacts);
    let weight = choices::narrowest(&derivative.within(&terms.changed), &column, &y0);
    derivative.push(column, weight);
    let q = derivative.norm(&derivative.within(&terms.changed));
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
