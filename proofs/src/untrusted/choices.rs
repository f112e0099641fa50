//! Numbers that the checker uses and does not trust.

use crate::{
    certificate::{Certificate, Multiplier},
    check::{
        moments::Moments,
        newton::{Block, Lines, Place, dot, product},
        perturbed::{Equations, Factors},
        system::System,
    },
    interval::Interval,
};

/// Corrections of an approximate perturbation.
const CORRECTIONS: usize = 3;

/// The solutions of linear systems in floating point: Gauss-Jordan elimination with pivots. Rows end
/// with the right-hand sides, rows of the result have solutions.
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

/// A matrix near that of the linear equations of a block.
pub fn matrix(block: &Block, b: &Lines, known: &[Moments]) -> Vec<Vec<f64>> {
    let size = block.plain.len();
    let mut matrix = vec![vec![0.0; size]; size];
    for (i, entries) in b.iter().enumerate() {
        for &(column, factor) in entries {
            let (m, k, part) = block.all[column];
            for (j, place) in block.at(m, Some(part)) {
                matrix[i][j] += (factor * product(&known[m].stiffness, k, place.1, (block.odd, part))).mid();
            }
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

/// The coefficients of perturbations that are given: the first one is 1, and of waves its imaginary
/// part is 0. Near the centre of a breather the harmonic of the background is least.
pub(crate) fn pinned(certificate: &Certificate, system: &System, multiplier: &Multiplier, block: usize) -> Vec<Place> {
    match multiplier {
        Multiplier::Growing(_) => {
            let k = certificate.background();
            let own = |n: &usize| certificate.a[*n].get(k).copied().unwrap_or(0.0).abs();
            let sites = (0..certificate.a.len()).filter(|n| system.has(*n, k));
            sites.min_by(|n, m| own(n).total_cmp(&own(m))).map(|n| (n, k.min(block), false)).into_iter().collect()
        }
        Multiplier::Doubling { sine } => vec![(0, 0, *sine)],
        Multiplier::Bloch { .. } => [0, 1].map(|n| (n, 1, false)).to_vec(),
    }
}

impl Certificate {
    /// The harmonic of the background of a breather: 2 if the period is doubled.
    pub fn background(&self) -> usize {
        let most = |k: usize| self.a.iter().filter_map(|a| a.get(k)).fold(0.0, |most: f64, a| most.max(a.abs()));
        1 + usize::from(most(2) > most(1))
    }
}

/// A perturbation near the solution of these equations, at these places, and `g`.
pub(crate) fn perturbation(
    it: &Equations,
    block: &Block,
    l: &Factors,
    (all, last): (&[Place], usize),
) -> [Vec<f64>; 2] {
    let [mut p, mut g] = [vec![0.0; all.len()], vec![0.0; it.pinned.len()]];
    for _ in 0..CORRECTIONS {
        let (field, exact) = (it.field(all, &p, last), g.iter().copied().map(Interval::exact).collect::<Vec<_>>());
        let head = it.head(l, (&field, &exact), &block.all);
        let step = |i: usize| dot(&block.inverse[i], &head).mid();
        let of = |place: &Place| it.defect(l, (&field, &exact), *place).mid();
        let steps = all.iter().map(|place| block.index(*place).map_or_else(|| of(place), step));
        p.iter_mut().zip(steps).for_each(|(p, step)| *p -= step);
        g.iter_mut().zip(block.all.len()..).for_each(|(g, i)| *g -= step(i));
    }
    [p, g]
}
