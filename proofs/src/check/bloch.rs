//! Chapter: perturbations that grow: of a breather of a ring, and of a wave for each Bloch wave
//! number of a piece ("Multipliers" in `README.md`).
//!
//! Unknowns are the coefficients and `lambda`. Along a piece `p = p_0 + h s`, `-1 <= s <= 1`. What
//! depends on it is `u_0 + u_1 s` and a rest.

use super::{
    Refused, System, doubling,
    newton::{Place, sums},
    of,
    perturbed::{Bent, Complex, Equations, Factors, Field, MIDDLE, Terms, at},
    system::{half_angle, poles},
};
use crate::{
    certificate::{Bloch, Center, Certificate, Multiplier, Orbit},
    exact::Exact,
    interval::Interval,
    untrusted::choices,
};

/// `K` and `K'` of this proof for one wave number, and for an interval of them; at most an eighth
/// of that of the certificate, and that.
const SIZES: [[usize; 2]; 2] = [[32, 512], [16, 256]];
/// `K` of a breather, at most that of the certificate: this, or a share of `K'`.
const BLOCK: [usize; 2] = [8, 32];

const ZERO: Complex = [Interval::ZERO; 2];

fn scaled(by: Interval, of: Complex) -> Complex {
    of.map(|it| by * it)
}

fn plus([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a + c, b + d]
}

fn times([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a * c - b * d, a * d + b * c]
}

fn inverse([a, b]: Complex) -> Complex {
    let size = a.square() + b.square();
    [a / size, -b / size]
}

/// `1/L(s)`, and its first and second derivative.
fn law(poles: &[[Interval; 3]], s: Complex) -> [Complex; 3] {
    poles.iter().fold([ZERO; 3], |sum, &[c, p, r]| {
        let f = inverse(plus(scaled(r, times(s, s)), [p, Interval::ZERO]));
        let first = scaled(-of(2) * r, times(s, times(f, f)));
        let second = plus(scaled(-of(2) * r, times(f, f)), scaled(-of(4) * r, times(s, times(f, first))));
        let term = [f, first, second].map(|it| scaled(c, it));
        [0, 1, 2].map(|i| plus(sum[i], term[i]))
    })
}

/// A perturbation, and the ball of its `lambda`.
pub struct Piece {
    /// Where it begins and ends, of a wave.
    pub p_over_pi: Option<[Exact; 2]>,
    /// `lambda` in the middle, and its change to the end.
    pub rate: [Complex; 2],
    /// How far real and imaginary part may be away; of a breather `lambda` is real.
    pub radius: Interval,
}

impl Piece {
    /// That of a line of a wave.
    pub fn of_wave(it: &Bloch) -> Self {
        let rate = [it.rate, it.change].map(|it| it.map(Exact::enclosed));
        Self { p_over_pi: Some(it.p_over_pi), rate, radius: it.radius.enclosed() }
    }

    /// That of a line of a breather: `lambda` is between these.
    fn of_breather(rates: [Exact; 2]) -> Self {
        let [from, to] = rates.map(Exact::enclosed);
        let middle = Interval::exact(from.hull(to).mid());
        Self { p_over_pi: None, rate: [[middle, Interval::ZERO], ZERO], radius: (middle - from).min(to - middle) }
    }
}

/// The rules of the lines of multipliers: whether they hold, and in words.
pub(crate) fn rules(it: &Certificate) -> [(bool, &'static str); 2] {
    let below = |a: Interval, b: Exact| (b.enclosed() - a).is_positive();
    let multiplies = match (it.multiplier, &it.orbit) {
        (None, _) => true,
        (Some(Multiplier::Growing([from, last])), Orbit::Breather { .. }) => {
            it.to.is_none() && from.num() > 0 && below(from.enclosed(), last)
        }
        (Some(Multiplier::Doubling), Orbit::Breather { center: Center::Bond, .. }) => {
            it.to.is_some() && !it.is_to_zero()
        }
        _ => false,
    };
    let grows = |one: &Bloch| {
        let Piece { rate: [[re, im], [by_re, by_im]], radius, .. } = Piece::of_wave(one);
        let [from, to] = one.p_over_pi;
        let growing = (re - by_re.abs() - radius).is_positive() && radius.is_positive();
        (from == to || below(from.enclosed(), to)) && growing && below(im.abs() + by_im.abs() + radius, it.model.omega)
    };
    let joined = it.bloch.windows(2).all(|two| two[0].p_over_pi[1] == two[1].p_over_pi[0]);
    let modulated = it.bloch.is_empty() || joined && it.to.is_none() && it.is_wave() && it.bloch.iter().all(grows);
    [
        (
            multiplies,
            "a multiplier is growing, of one breather of a ring, at growth rates above 0, the larger one last; or -1, of \
             a piece of a branch of bond-centred ones",
        ),
        (
            modulated,
            "lines bloch are of one wave: each begins where the one before it ends; of p/pi the larger one is last, and \
             radius, growth rate - |change| - radius, and omega - |frequency| - |change| - radius are above 0",
        ),
    ]
}

/// `K` and `K'` of perturbations, for one wave number or an interval of them.
pub(super) fn sizes(certificate: &Certificate, interval: bool) -> [usize; 2] {
    let [block, enclosed] = SIZES[usize::from(interval)];
    match certificate.is_wave() {
        true => [block.min(certificate.enclosed / 8), enclosed.min(certificate.enclosed)],
        false => [certificate.block.min(BLOCK[0].max(certificate.enclosed / BLOCK[1])), certificate.enclosed],
    }
}

/// The equations of a piece: the coefficient of a cosine is given. Those of breathers are real.
pub fn equations<'a>(certificate: &Certificate, system: &'a System, piece: &Piece) -> Equations<'a> {
    let ((n, k), wide) = (choices::pinned(certificate, system), piece.p_over_pi.is_some_and(|[from, to]| from != to));
    let sizes = sizes(certificate, wide);
    let pinned = match certificate.is_wave() {
        true => [0, 1].map(|n| vec![(n, MIDDLE - 1), (n, MIDDLE + 1)]).to_vec(),
        false => vec![vec![(n, MIDDLE + k.min(sizes[0]))]],
    };
    Equations::new(system, certificate.model.alpha, sizes, (!certificate.is_wave(), pinned))
}

/// `l_k` at `lambda_0 + lambda_1 s`, by Taylor's formula `u_0`, `u_1` and the rest, half of the
/// second derivative; its derivatives by `lambda`, and all values, where `lambda` is at most the
/// radius of the piece away in real and imaginary part.
pub fn factors(certificate: &Certificate, system: &System, piece: &Piece) -> [Factors; 5] {
    let (poles, near, all) = (poles(&certificate.model), [piece.radius.ball(); 2], Interval::ONE.ball());
    let [from, to] = piece.p_over_pi.map_or(ZERO, |p| p.map(|p| p.enclosed() * Interval::PI));
    let (h, [rate, change]) = ((to - from) / of(2), piece.rate);
    // 4 sin^2(a/2) with its first and second derivative by a.
    let lattice = |k: i64, s: Interval| {
        let Orbit::Wave { q_over_pi } = certificate.orbit else {
            return [Interval::ONE, Interval::ZERO, Interval::ZERO];
        };
        let half = (from + to) / of(4) + h / of(2) * s + half_angle(q_over_pi, i128::from(-k));
        let [sin, cos] = half.sin_cos();
        [of(4) * sin.square(), of(4) * sin * cos, of(2) * (cos.square() - sin.square())]
    };
    let factor = |k: i64| {
        let turn = [Interval::ZERO, Interval::of_integer(k.into()) * system.omega()];
        let middle = plus(rate, turn);
        let along = plus(middle, scaled(all, change));
        let ([a, b, _], [u, v, _]) = (lattice(k, Interval::ZERO), law(&poles, middle));
        let [value, slope] = [scaled(a, u), plus(scaled(h * b, u), scaled(a, times(change, v)))];
        let ([a, b, c], [u, v, w]) = (lattice(k, all), law(&poles, along));
        let [bent, turned] = [scaled(h * h * c, u), scaled(of(2) * h * b, times(change, v))];
        let bent = plus(plus(bent, turned), scaled(a, times(change, times(change, w))));
        let rest = scaled(Interval::new(0.0, 1.0) / of(2), bent);
        let steep = scaled(a, law(&poles, plus(along, near))[1]);
        let all = plus(plus(value, scaled(all, slope)), plus(rest, times(steep, near)));
        [value, slope, rest, steep, all]
    };
    // Two more than K': by Cauchy's bound in a disc of radius omega derivatives beyond have the
    // tail of l over omega.
    let last = system.factors.len() as i64 + 1;
    let all: Vec<[Complex; 5]> = (-last..=last).map(factor).collect();
    [0, 1, 2, 3, 4].map(|i| all.iter().map(|one| one[i]).collect())
}

/// The radius about `lambda_0 + lambda_1 s` that is needed, at most that of the piece, and `q`: for
/// each `p` there is a `lambda`. The strains of the orbit differ by at most `changes` from its
/// cosine sums.
pub fn check(
    certificate: &Certificate,
    piece: &Piece,
    (system, changes): (&System, &[Interval]),
    go_on: &dyn Fn() -> Result<(), Refused>,
) -> Result<[f64; 2], Refused> {
    let (radius, [start, slope, rest, steep, all]) = (piece.radius, factors(certificate, system, piece));
    let turned: Factors = steep.iter().map(|[re, im]| [-*im, *re]).collect();
    let own = equations(certificate, system, piece);
    let [p, turn] = choices::eigenvector(&own, [&start, &slope]);
    let entry = |(p, turn): (&Interval, &Interval)| *p + turn.abs().ball();
    let wide: Field = p.iter().zip(&turn).map(|(p, turn)| p.iter().zip(turn).map(entry).collect()).collect();
    let places = own.all(own.sizes[0]);
    let column = |l: &Factors| places.iter().map(|place| own.force(l, &wide, *place)).collect();
    let columns = [&steep, &turned].into_iter().take(own.pinned.len()).map(column).collect();
    let terms = Terms::new(own, all, Some(columns), changes);
    let (it, block) = (&terms.it, &terms.block);

    let late = |last: usize| it.beyond(&steep, last, system.tails()[0] / system.omega());
    let [_, reach] = block.times(&block.rows(|place| it.forces(&steep, place)), &|_| Interval::ONE);
    let contacts = sums(&reach, &terms.far(late(it.sizes[0])));
    let value = |i: usize, place: Place| it.force([&steep, &turned][i], &wide, place);
    let bent = Bent { value: &value, contacts, late: late(it.counts()[1]) };
    // The part without s, that with s, and that with s^2.
    let defect = |(n, k): Place| {
        let [p, turn] = [&p, &turn].map(|it| (at(&it[n], k).unwrap_or(Interval::ZERO), it));
        let first = p.0 + it.force(&start, p.1, (n, k));
        let second = turn.0 + it.force(&start, turn.1, (n, k)) + it.force(&slope, p.1, (n, k));
        let third = Interval::new(0.0, 1.0) * it.force(&slope, turn.1, (n, k)) + it.force(&rest, &wide, (n, k));
        first + second.abs().ball() + third
    };
    let given = it.given(&p).into_iter().zip(it.given(&turn)).map(|(p, turn)| p + turn.abs().ball());
    let given: Vec<Interval> = given.collect();
    let [needed, q] = terms.solved((&wide, &defect, &given), (&bent, radius), go_on)?;
    let proved = (Interval::ONE - q).is_positive() && needed.hi() <= radius.lo();
    let [radius, q] = [needed, q].map(Interval::hi);
    let p_over_pi = piece.p_over_pi.map(|it| it[0]);
    if proved { Ok([radius, q]) } else { Err(Refused::Perturbation { p_over_pi, radius, q }) }
}

/// What is proved of the multiplier or of the perturbations of a certificate: bounds of the modulus
/// of the multiplier, of -1 those of `g`; and of the growth rates of pieces, of the largest one,
/// and of frequencies.
#[allow(clippy::type_complexity, reason = "two entries of a proof")]
pub(super) fn perturbations(
    certificate: &Certificate,
    (system, changes): (&System, &[Interval]),
    go_on: &dyn Fn() -> Result<(), Refused>,
) -> Result<(Option<[f64; 2]>, Option<[[f64; 2]; 3]>), Refused> {
    let bounds = |it: Interval| [it.lo(), it.hi()];
    let size = |rate: Interval| (rate * of(2) * Interval::PI / system.omega()).exp();
    let growing = |piece: &Piece| check(certificate, piece, (&system.perturbed(), changes), go_on);
    match certificate.multiplier {
        Some(Multiplier::Doubling) => return Ok((Some(doubling::check(certificate, (system, changes), go_on)?), None)),
        Some(Multiplier::Growing(rates)) => {
            growing(&Piece::of_breather(rates))?;
            let [from, to] = rates.map(|rate| size(rate.enclosed()));
            return Ok((Some([from.lo(), to.hi()]), None));
        }
        None => {}
    }
    let of_piece = |it: &Bloch| -> Result<[Interval; 3], Refused> {
        let Piece { rate: [[re, im], [grows, turns]], radius, .. } = Piece::of_wave(it);
        let near = radius.ball();
        growing(&Piece::of_wave(it))?;
        Ok([re + (near + grows.abs().ball()), re + (near + grows.abs()), im + (near + turns.abs().ball())])
    };
    let all = certificate.bloch.iter().map(of_piece).collect::<Result<Vec<_>, _>>()?.into_iter();
    let all = all.reduce(|a, b| [a[0].hull(b[0]), a[1].max(b[1]), a[2].hull(b[2])]);
    Ok((all.map(|[_, largest, _]| bounds(size(largest))), all.map(|all| all.map(bounds))))
}
