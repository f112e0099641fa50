//! Numbers that the checker uses and does not trust.

use crate::{
    certificate::{Bloch, Certificate},
    check::{
        factors::{Factors, modulated},
        further::Terms,
        newton::{Block, Equations, Matrix, Place, dot},
        perturbed::{Perturbations, own},
        system::System,
    },
    interval::Interval,
};
use std::rc::Rc;

/// Corrections of an approximate perturbation.
const CORRECTIONS: usize = 3;
/// Ratio of two radii that are tried, and their largest number.
pub const RUNG: f64 = 1.2;
const RUNGS: usize = 200;
/// `K` and `K'` of perturbations of a wave, for one wave number and for an interval of them; at
/// most an eighth of that of the certificate, and that.
const SIZES: [[usize; 2]; 2] = [[32, 512], [16, 256]];
/// `K` of perturbations of a breather, at most that of the certificate: this, or a share of `K'`.
const BLOCK: [usize; 2] = [8, 32];
/// Most steps of Newton's method for the growth rate of a wave.
const RATES: usize = 8;

/// The solutions of linear systems in floating point: Gauss-Jordan elimination with pivots. Rows
/// end with the right-hand sides, rows of the result have solutions.
pub(crate) fn solved(mut rows: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let n = rows.len();
    for step in 0..n {
        let pivot = (step..n).max_by(|&i, &j| rows[i][step].abs().total_cmp(&rows[j][step].abs())).unwrap_or(step);
        rows.swap(step, pivot);
        let scale = rows[step][step];
        let row: Vec<f64> = rows[step].iter().map(|x| x / scale).collect();
        rows[step].clone_from(&row);
        for (_, other) in rows.iter_mut().enumerate().filter(|(i, other)| *i != step && other[step] != 0.0) {
            let factor = other[step];
            other[step..].iter_mut().zip(&row[step..]).for_each(|(x, y)| *x -= factor * y);
        }
    }
    rows.into_iter().map(|row| row[n..].to_vec()).collect()
}

/// A matrix near that of the linear equations of a block, for these factors.
pub fn matrix(block: &Block, l: &[Vec<Interval>]) -> Vec<Vec<f64>> {
    let size = block.plain.len();
    let mut matrix = vec![vec![0.0; size]; size];
    for (row, entries) in matrix.iter_mut().zip(block.rows()) {
        for (column, i, e) in entries {
            let (m, k) = block.all[column];
            block.at(m).for_each(|(j, place)| row[j] += (e * l[i][k] * block.it.entry(m, k, place.1)).mid());
        }
    }
    for (j, column) in block.plain.iter().enumerate() {
        column.iter().for_each(|(i, entry)| matrix[*i][j] += entry.mid());
    }
    matrix
}

/// A matrix near the inverse of this one.
pub(crate) fn inverse(matrix: &[Vec<f64>]) -> Vec<Vec<Interval>> {
    let identity = |i: usize| (0..matrix.len()).map(move |j| f64::from(u8::from(i == j)));
    let rows = matrix.iter().enumerate().map(|(i, row)| row.iter().copied().chain(identity(i)).collect());
    let exact = |row: Vec<f64>| row.into_iter().map(Interval::exact).collect();
    solved(rows.collect()).into_iter().map(exact).collect()
}

/// Weights of sites, at most 1, near Perron's vector of a matrix that is not negative: uniform ones
/// have narrower balls of single orbits, but prove less of branches of doubled period.
pub(crate) fn perron(rows: &[Vec<Interval>]) -> Vec<Interval> {
    let mut vector = vec![1.0; rows.len()];
    for _ in 0..50 {
        let next: Vec<f64> = rows.iter().map(|row| row.iter().zip(&vector).map(|(a, b)| a.mid() * b).sum()).collect();
        let most = next.iter().copied().fold(0.0, f64::max);
        vector = next.into_iter().map(|x| (x / most).clamp(0.01, 1.0)).collect();
    }
    vector.into_iter().map(Interval::exact).collect()
}

/// The weight of further unknowns of which the row is at most half as large as the largest one.
pub(crate) fn lightest(rows: &[Interval]) -> Interval {
    let [sites @ .., own] = rows else { return Interval::ONE };
    let most = sites.iter().map(|row| row.mid()).fold(0.0, f64::max);
    Interval::exact((2.0 * own.hi() / most).clamp(f64::MIN_POSITIVE, f64::MAX))
}

/// Radii of the balls of existence and of uniqueness, at most `most`, by bounds `q` of the
/// derivative on balls.
pub(crate) fn radii(y0: Interval, most: f64, q: &dyn Fn(f64) -> Interval) -> Option<[f64; 2]> {
    let (mut ball, mut unique, mut r) = (None, None, y0.hi());
    for _ in 0..RUNGS {
        let left = Interval::ONE - q(r);
        if !(left.is_positive() && r <= most) {
            break;
        }
        ball = ball.or(Some(r).filter(|r| (y0 / left).hi() <= *r));
        unique = Some(r);
        r *= RUNG;
    }
    Some([ball?, unique?])
}

/// `K` and `K'` of perturbations, and the coefficient of growing ones of breathers that is given:
/// that of the background, which is least near the centre.
pub(crate) fn perturbations(it: &Certificate, system: &System, piece: Option<&Bloch>) -> ([usize; 2], Place) {
    if let Some(piece) = piece {
        let [block, enclosed] = SIZES[usize::from(piece.p_over_pi[0] != piece.p_over_pi[1])];
        return ([block.min(it.enclosed / 8), enclosed.min(it.enclosed)], (0, 0));
    }
    let (block, k) = (it.block.min(BLOCK[0].max(it.enclosed / BLOCK[1])), it.background());
    let size = |n: &usize| it.a[*n].get(k).copied().unwrap_or(0.0).abs();
    let sites = (0..it.a.len()).filter(|n| system.has((*n, k)));
    let least = sites.min_by(|n, m| size(n).total_cmp(&size(m))).unwrap_or(0);
    ([block, it.enclosed], (least, k.min(block)))
}

impl Certificate {
    /// The harmonic of the background of a breather: 2 if the period is doubled.
    pub fn background(&self) -> usize {
        let most = |k: usize| self.a.iter().filter_map(|a| a.get(k)).fold(0.0, |most: f64, a| most.max(a.abs()));
        1 + usize::from(most(2) > most(1))
    }
}

/// A perturbation near the solution of these equations, and `g`, by the `A` of these terms; or of
/// those that have something else, too, and 0 as the coefficient that is given.
pub(crate) fn perturbation(
    Terms { it, block, .. }: &Terms,
    l: &Factors,
    forced: Option<&dyn Fn(Place) -> Interval>,
) -> (Matrix, Vec<Interval>) {
    let last = it.counts()[0];
    let mut p = vec![vec![Interval::ZERO; last + 1]; it.functions()];
    let mut g = vec![Interval::ZERO; it.pinned.len()];
    let moved = |x: Interval, step: Interval| Interval::exact(x.mid() - step.mid());
    for _ in 0..CORRECTIONS {
        let forces = it.forces(&p, last);
        let defect = |place: Place| {
            let given: Interval = g.iter().zip(0..).map(|(g, which)| *g * it.column(which, place)).sum();
            own(&p, place) + it.applied(l, &forces, place) + given + forced.map_or(Interval::ZERO, |it| it(place))
        };
        let given = it.given(&p).into_iter().zip(&it.pinned);
        let given = given.map(|(given, place)| if forced.is_some() { own(&p, *place) } else { given });
        let head: Vec<Interval> = block.all.iter().map(|place| defect(*place)).chain(given).collect();
        let step = |i: usize| dot(&block.inverse[i], &head);
        let all = it.places(0..p.len(), 0..last + 1).into_iter();
        let steps: Vec<(Place, Interval)> =
            all.map(|place| (place, block.index(place).map_or_else(|| defect(place), step))).collect();
        g = g.iter().zip(block.all.len()..).map(|(g, i)| moved(*g, step(i))).collect();
        steps.into_iter().for_each(|((n, k), step)| p[n][k] = moved(p[n][k], step));
    }
    (p, g)
}

/// A perturbation of a wave along a piece, and by how much it changes from the middle to the end.
pub(crate) fn eigenvector(it: &Rc<Perturbations>, [l, slope]: [&Factors; 2]) -> [Matrix; 2] {
    let terms = Terms::new(it, l.clone(), &|i, place| it.column(i, place), &[Interval::ZERO]);
    let p = perturbation(&terms, l, None).0;
    let forces = it.forces(&p, it.counts()[0]);
    let turn = perturbation(&terms, l, Some(&|place| it.applied(slope, &forces, place))).0;
    [p, turn]
}

/// The weight of further unknowns, with these rows, this column and these defects, for which the
/// ball is narrowest in them.
pub(crate) fn narrowest(rows: &[Interval], column: &[Interval], y0: &[Interval]) -> Interval {
    let weights = (-4..3).map(|power| lightest(rows).mid() * 2_f64.powi(power));
    let needed = |w: f64| {
        let most = |of: &dyn Fn(usize) -> f64| {
            (0..rows.len()).map(|n| if n + 1 < rows.len() { of(n) } else { of(n) / w }).fold(0.0, f64::max)
        };
        let q = most(&|n| rows[n].hi() + w * column[n].hi());
        if q < 1.0 { w * most(&|n| y0[n].hi()) / (1.0 - q) } else { f64::MAX.min(q * 1e100) }
    };
    Interval::exact(weights.min_by(|a, b| needed(*a).total_cmp(&needed(*b))).unwrap_or(1.0))
}

/// `lambda` in the middle of a piece of Bloch wave numbers, near that of this one, and by how much
/// it changes to the end.
pub fn rate(certificate: &Certificate, system: &Rc<System>, near: &Bloch) -> Option<[[f64; 2]; 2]> {
    let quotient = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a * c + b * d, b * c - a * d].map(|it| it / (c * c + d * d));
    let it = Perturbations::new(certificate, system, None, Some(near));
    let mut rate = near.rate.map(|it| it.enclosed().mid());
    for _ in 0..RATES {
        let [start, slope, _, steep, _] =
            modulated(certificate, system, near, [rate.map(Interval::exact), [Interval::ZERO; 2]]);
        let terms = Terms::new(&it, start.clone(), &|i, place| it.column(i, place), &[Interval::ZERO]);
        let mids = |g: Vec<Interval>| [g[0].mid(), g[1].mid()];
        let (p, left) = perturbation(&terms, &start, None);
        let forces = it.forces(&p, it.counts()[0]);
        let g = |l: &Factors| mids(perturbation(&terms, &start, Some(&|place| it.applied(l, &forces, place))).1);
        let (left, by) = (mids(left), g(&steep));
        let step = quotient(left, by);
        rate = [rate[0] - step[0], rate[1] - step[1]];
        if step.iter().all(|it| it.abs() < 1e-10 * rate[0].abs()) {
            return Some([rate, quotient(g(&slope), by).map(|it| -it)]);
        }
    }
    None
}
