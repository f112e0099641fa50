//! Pieces of Bloch wave numbers, at all of which a perturbation of a wave is proved.

use super::{choices, solve::rounded};
use crate::{
    certificate::{Bloch, Certificate},
    check::{Refused, bloch, check_until, existence::Terms, system::System},
    exact::Exact,
    interval::Interval,
};
use std::rc::Rc;

/// The width of the first piece, in units of pi, and the least one.
const WIDTHS: [f64; 2] = [4e-4, 1e-6];
/// What is aimed at: the radius over the growth rate, and over the largest one.
const AIMS: [f64; 2] = [2e-3, 2e-4];
/// A rate further from the expected one, over the growth rate, is one of another perturbation.
const APART: f64 = 0.2;
/// The first radius over the growth rate, the largest over the least one, and the next one that is
/// tried.
const RADII: [f64; 3] = [1e-5, 1.5, 1.2];
/// Most radii that are tried.
const TRIALS: usize = 6;

/// A Bloch wave number over pi, with growth rate and frequency of a perturbation.
pub type Near = [f64; 3];

/// The pieces that are proved between two wave numbers over pi, from the fastest one of these
/// perturbations on, and from others where these pieces end. They make one interval.
///
/// # Errors
/// What is refused of the wave, and [`Refused::Stopped`].
pub fn pieces(
    certificate: &Certificate,
    ends: [f64; 2],
    near: &[Near],
    stopped: &dyn Fn() -> bool,
) -> Result<Vec<Bloch>, Refused> {
    let go_on = || if stopped() { Err(Refused::Stopped) } else { Ok(()) };
    let radius = Interval::exact(check_until(certificate, stopped)?.radius);
    let system = Terms::new(certificate, &go_on)?.system.perturbed();
    let most = near.iter().filter(|it| (ends[0]..=ends[1]).contains(&it[0])).fold(0.0, |most: f64, it| most.max(it[1]));
    Search { certificate, system, radius, most, go_on: &go_on }.between(ends, near)
}

struct Search<'a> {
    certificate: &'a Certificate,
    system: Rc<System>,
    radius: Interval,
    /// The largest growth rate.
    most: f64,
    go_on: &'a dyn Fn() -> Result<(), Refused>,
}

impl Search<'_> {
    fn between(&self, [from, to]: [f64; 2], near: &[Near]) -> Result<Vec<Bloch>, Refused> {
        let inside = near.iter().filter(|it| (from..=to).contains(&it[0]));
        let Some(fastest) = inside.max_by(|a, b| a[1].total_cmp(&b[1])) else { return Ok(Vec::new()) };
        let others: Vec<Near> = near.iter().copied().filter(|it| it != fastest).collect();
        let ((mut below, start), (above, end)) = (self.along(*fastest, from)?, self.along(*fastest, to)?);
        below.reverse();
        let left = if start > from { self.between([from, start], &others)? } else { Vec::new() };
        let right = if end < to { self.between([end, to], &others)? } else { Vec::new() };
        let is = |p: Exact, end: f64| Exact::of_double(end) == Some(p);
        let left = Some(left).filter(|it| it.last().is_some_and(|last| is(last.p_over_pi[1], start)));
        let right = Some(right).filter(|it| it.first().is_some_and(|first| is(first.p_over_pi[0], end)));
        Ok([left.unwrap_or_default(), below, above, right.unwrap_or_default()].concat())
    }

    /// The pieces from a perturbation on towards this wave number, and where they end.
    fn along(&self, [mut p, growth, frequency]: Near, to: f64) -> Result<(Vec<Bloch>, f64), Refused> {
        let (mut pieces, mut rate, mut slope) = (Vec::new(), [growth, frequency], [0.0; 2]);
        let (mut width, mut radius) = (WIDTHS[0], RADII[0] * growth);
        while p != to && width >= WIDTHS[1] {
            let steps = ((to - p).abs() / width).ceil();
            let end = if steps > 1.0 { (1e9 * (p + (to - p) / steps)).round() / 1e9 } else { to };
            let near = [0, 1].map(|i| rate[i] + slope[i] * 0.5 * (end - p));
            let Some((piece, q)) = self.piece([p.min(end), p.max(end)], near, radius)? else {
                (width, radius) = (0.5 * width, 0.25 * radius);
                continue;
            };
            let [middle, change, [proved, _]] =
                [piece.rate, piece.change, [piece.radius; 2]].map(|it| it.map(|it| it.enclosed().mid()));
            slope = change.map(|it| it / (0.5 * (end - p).abs()));
            rate = [0, 1].map(|i| middle[i] + change[i] * (end - p).signum());
            let aim = (AIMS[0] * middle[0]).min(AIMS[1] * self.most);
            let wider = (2.0 - q).min(0.9 * (aim / proved).sqrt()).clamp(0.5, 1.5);
            (width, radius, p) = (wider * (end - p).abs(), proved * wider * wider, end);
            pieces.push(piece);
        }
        Ok((pieces, p))
    }

    /// The piece between two wave numbers, near this rate, with this radius or a larger one; and
    /// `q`.
    fn piece(&self, ends: [f64; 2], near: [f64; 2], mut radius: f64) -> Result<Option<(Bloch, f64)>, Refused> {
        let exact = |x: [f64; 2]| Some([rounded(x[0])?, rounded(x[1])?]);
        let of = |rate, change, radius| {
            let p_over_pi = [Exact::of_double(ends[0])?, Exact::of_double(ends[1])?];
            let (rate, change) = (exact(rate)?, exact(change)?);
            Some(Bloch { p_over_pi, rate, change, radius: rounded(radius)? })
        };
        let Some(first) = of(near, [0.0; 2], 1e-15) else { return Ok(None) };
        let Some([rate, change]) = choices::rate(self.certificate, &self.system, &first) else { return Ok(None) };
        for _ in 0..TRIALS {
            let apart = (rate[0] - near[0]).hypot(rate[1] - near[1]);
            let grows = rate[0] > change[0].abs() + radius && apart < APART * near[0];
            let Some(piece) = of(rate, change, radius).filter(|_| grows) else { break };
            match bloch::check(self.certificate, &piece, (&self.system, &[self.radius]), self.go_on) {
                Ok([least, q]) if radius < RADII[1] * least => return Ok(Some((piece, q))),
                Ok([needed, _]) => radius = RADII[2] * needed,
                Err(Refused::Bloch { q, radius: needed, .. }) if q < 1.0 => radius = RADII[2] * needed,
                Err(Refused::Bloch { .. }) => radius *= 0.1,
                Err(why) => return Err(why),
            }
        }
        Ok(None)
    }
}
