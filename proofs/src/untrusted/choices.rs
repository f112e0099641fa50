//! Numbers that the checker uses and does not trust.

use crate::{
    certificate::{Bloch, Certificate, Multiplier},
    check::{
        bloch::{equations, factors},
        moments::Moments,
        newton::{Block, Lines, Place, dot, product},
        of,
        perturbed::{Equations, Factors, Field, Terms, own_of},
        system::System,
    },
    interval::Interval,
};

/// Corrections of an approximate perturbation.
const CORRECTIONS: usize = 3;
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
pub(crate) fn pinned(
    certificate: &Certificate,
    system: &System,
    multiplier: Option<&Multiplier>,
    block: usize,
) -> Vec<Place> {
    match multiplier {
        Some(Multiplier::Growing(_)) => {
            let k = certificate.background();
            let own = |n: &usize| certificate.a[*n].get(k).copied().unwrap_or(0.0).abs();
            let sites = (0..certificate.a.len()).filter(|n| system.has(*n, k));
            sites.min_by(|n, m| own(n).total_cmp(&own(m))).map(|n| (n, k.min(block), false)).into_iter().collect()
        }
        Some(Multiplier::Doubling { sine }) => vec![(0, 0, *sine)],
        None => [0, 1].map(|n| (n, 1, false)).to_vec(),
    }
}

impl Certificate {
    /// The harmonic of the background of a breather: 2 if the period is doubled.
    pub fn background(&self) -> usize {
        let most = |k: usize| self.a.iter().filter_map(|a| a.get(k)).fold(0.0, |most: f64, a| most.max(a.abs()));
        1 + usize::from(most(2) > most(1))
    }
}

/// A perturbation near the solution of these equations, and `g`, by the `A` of these terms; or of
/// those that have `l D p` of another perturbation, too, and 0 as the coefficient that is given.
pub(crate) fn perturbation(
    Terms { it, block, .. }: &Terms,
    l: &Factors,
    forced: Option<(&Factors, &Field)>,
) -> (Field, Vec<Interval>) {
    let last = it.counts()[0];
    let all = it.all(last);
    let [mut p, mut g] = [vec![0.0; all.len()], vec![0.0; it.pinned.len()]];
    let exact = |g: &[f64]| g.iter().copied().map(Interval::exact).collect::<Vec<_>>();
    let force: Vec<Interval> =
        all.iter().map(|place| forced.map_or(Interval::ZERO, |(l, p)| it.force(l, p, *place))).collect();
    for _ in 0..CORRECTIONS {
        let (field, known) = (it.field(&all, &p, last), exact(&g));
        let defects: Vec<Interval> =
            all.iter().zip(&force).map(|(place, force)| it.defect(l, (&field, &known), *place) + *force).collect();
        let given =
            |(which, own): (usize, &Place)| own_of(&field, *own) - of(usize::from(which == 0 && forced.is_none()));
        let own = |place: &Place| all.iter().position(|other| other == place).map_or(Interval::ZERO, |i| defects[i]);
        let head: Vec<Interval> = block.all.iter().map(own).chain(it.pinned.iter().enumerate().map(given)).collect();
        let step = |i: usize| dot(&block.inverse[i], &head).mid();
        let steps = all.iter().zip(&defects).map(|(place, defect)| block.index(*place).map_or(defect.mid(), step));
        p.iter_mut().zip(steps).for_each(|(p, step)| *p -= step);
        g.iter_mut().zip(block.all.len()..).for_each(|(g, i)| *g -= step(i));
    }
    (it.field(&all, &p, last), exact(&g))
}

/// A perturbation of a wave along a piece, and by how much it changes from the middle to the end.
pub(crate) fn eigenvector(it: &Equations, [l, slope]: [&Factors; 2]) -> [Field; 2] {
    let terms = Terms::new(it.clone(), l.clone(), None, &[Interval::ZERO]);
    let p = perturbation(&terms, l, None).0;
    let turn = perturbation(&terms, l, Some((slope, &p))).0;
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
pub fn rate(certificate: &Certificate, system: &System, near: &Bloch) -> Option<[[f64; 2]; 2]> {
    let quotient = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a * c + b * d, b * c - a * d].map(|it| it / (c * c + d * d));
    let mut rate = near.rate.map(|it| it.enclosed().mid());
    for _ in 0..RATES {
        let [start, slope, _, steep, ..] =
            factors(certificate, system, near, [rate.map(Interval::exact), [Interval::ZERO; 2]]);
        let terms = Terms::new(equations(certificate, system, near), start, None, &[Interval::ZERO]);
        let mids = |g: Vec<Interval>| [g[0].mid(), g[1].mid()];
        let (p, left) = perturbation(&terms, &terms.l, None);
        let g = |l: &Factors| mids(perturbation(&terms, &terms.l, Some((l, &p))).1);
        let (left, by) = (mids(left), g(&steep));
        let step = quotient(left, by);
        rate = [rate[0] - step[0], rate[1] - step[1]];
        if step.iter().all(|it| it.abs() < 1e-10 * rate[0].abs()) {
            return Some([rate, quotient(g(&slope), by).map(|it| -it)]);
        }
    }
    None
}
