//! The bounds `Y0` and `Z1` of a certificate, and the radii that follow.

use super::{check, exact, kink, model, wave};
use hertzchain_proofs::{
    certificate::{Center, Certificate, Model, Orbit},
    check::{Bounds, Moments, NARROWEST, Refused, moments},
    exact::Exact,
    internals::{Block, Derivative, RUNG, System, Terms, matrix, radii},
    interval::{Interval, norm},
    untrusted::solve::{self, Sizes},
};
use std::ops::RangeInclusive;

/// The coefficient of `cos k theta` in `D cos j theta`.
fn stiffness(d: &[Interval], k: usize, j: usize) -> f64 {
    let of = |l: usize| d[l].mid() / if l == 0 { 1.0 } else { 2.0 };
    (of(k.abs_diff(j)) + of(k + j)) / if k == 0 { 2.0 } else { 1.0 }
}

// Truth: derivatives by differences of the frequency, at both ends and in the middle of a wide
// piece, with four times as many harmonics, and their changes with the wave.
#[test]
fn the_column_of_the_frequency_is_bounded() {
    let near = guess(None);
    let model = Model { omega: exact("2.0102"), ..near.model };
    let near = Certificate { first: Some([exact("0.24"); 2]), ..wave(model, ["1/5", "-0.1"], [1, 4], &[0.24]) };
    let found = solve::near(&near, Sizes { block: 3, harmonics: 8, enclosed: 16 }).unwrap();
    let at = |omega: f64, enclosed: usize| {
        let model = Model { omega: Exact::of_double(omega).unwrap(), ..found.model };
        System::new(&Certificate { model, first: None, enclosed, ..found.clone() }).unwrap()
    };
    let model = Model { omega: exact("2.0092"), ..found.model };
    let piece = Certificate { model, to: Some([exact("2.0112"), found.mean]), ..found.clone() };
    let terms = Terms::new(&piece, &|| Ok(())).unwrap();
    let Block { all, inverse, .. } = &terms.block;
    // The column for a change of the force from that of the wave, less it, by row.
    let column = |omega: f64, force: &[f64], unit: f64| -> [f64; 3] {
        let [before, after] = [-1e-6, 1e-6].map(|by| at(omega + by, 64).factors);
        let entry = |k: usize| -1e-3 * (after[k].mid() - before[k].mid()) / 2e-6 * force[k];
        let row = |i: usize| -> f64 {
            let image = all.iter().zip(&inverse[i]).map(|((_, k), a)| a.mid() * entry(*k));
            (if i == all.len() { unit } else { 0.0 } - image.sum::<f64>()).abs()
        };
        let far: f64 = (4..=64).map(|k| entry(k).abs()).sum();
        [(0..all.len()).map(row).sum::<f64>() + far, row(all.len()), far]
    };
    let force = |a: &[Interval]| -> Vec<f64> {
        let found = moments(a, piece.model.alpha, 64, NARROWEST).unwrap();
        found.force.into_iter().map(Interval::mid).collect()
    };
    let (own, ends) = (force(&terms.system.a[0]), [2.0092, 2.0102, 2.0112]);
    // Beyond the block, also beyond the harmonics that are enclosed: 0.4 percent of this.
    let bound = terms.turned(terms.block.column(0), (&terms.contacts(), &[]));
    let beyond = bound[0].hi() - terms.block.column(0)[0].hi();
    let most = ends.map(|omega| column(omega, &own, 1.0)[2]).into_iter().fold(0.0, f64::max);
    assert!(most < beyond && beyond < 1.1 * most, "{most:e} {beyond:e}");
    // The row of the frequency has this column over eta, times eta.
    let bounds = bounds(&piece);
    assert!(bounds.z1 > bound[1].hi(), "{bounds:?}");
    for (n, bound) in bound.into_iter().map(Interval::hi).enumerate() {
        let most = ends.map(|omega| column(omega, &own, 1.0)[n]).into_iter().fold(0.0, f64::max);
        assert!(most < bound && most > 0.5 * bound, "{n}: {most:e} {bound:e}");
        for r in [1e-3, 1e-2] {
            let of = |(j, sign): (usize, f64)| {
                let mut moved = terms.system.a[0].clone();
                moved[j] = moved[j] + Interval::exact(sign * r);
                let change: Vec<f64> = force(&moved).iter().zip(&own).map(|(a, b)| a - b).collect();
                ends.map(|omega| column(omega, &change, 0.0)[n]).into_iter().fold(0.0, f64::max)
            };
            let all = (1..8).flat_map(|j| [(j, 1.0), (j, -1.0)]);
            let force = terms.system.known[0].force_change(piece.model.alpha, Interval::exact(r));
            let (most, bound) = (all.map(of).fold(0.0, f64::max), (terms.contacts()[n][0] * force).hi());
            assert!(most < bound && most > 0.1 * bound, "{n} {r}: {most:e} {bound:e}");
        }
    }
}

// Truth: factors at both ends of a piece, and sums of squares of 16 times as many.
#[test]
fn factors_of_a_piece_are_bounded() {
    let near = Certificate { enclosed: 16, ..guess(Some(Center::Bond)) };
    let ends = ["2.04", "2.06"].map(|end| Model { omega: exact(end), ..near.model });
    let piece = Certificate { model: ends[0], to: Some([ends[1].omega, near.mean]), ..near.clone() };
    let system = System::new(&piece).unwrap();
    let more = System::new(&Certificate { enclosed: 256, ..piece.clone() }).unwrap();
    for model in ends {
        let truth = System::new(&Certificate { model, enclosed: 256, ..near.clone() }).unwrap().factors;
        assert!((1..=16).all(|k| system.ranges[k].lo() < truth[k].lo() && truth[k].hi() < system.ranges[k].hi()));
        assert!(norm(truth[17..].iter().copied()).hi() < system.tails()[0].hi());
    }
    let [slopes, bound] = [norm(more.slopes[17..].iter().copied()), system.tails()[1]].map(Interval::hi);
    assert!(slopes < bound && bound < 1.1 * slopes, "{slopes:e} {bound:e}");
}

/// Near a wave, or a breather on a ring of 15.
fn guess(center: Option<Center>) -> Certificate {
    match center {
        None => wave(model(["3/2", "1/3", "2.001"]), ["1/5", "0"], [1, 4], &[0.0083]),
        Some(center) => kink(model(["3/2", "1/3", "2.05"]), 15, center, 0.15),
    }
}

/// A breather of the infinite chain with visible defects at its first site, and at its third
/// one, the last before the background.
fn infinite(center: Center) -> Certificate {
    let sizes = Sizes { block: 3, harmonics: 16, enclosed: 16 };
    let ring = solve::near(&guess(Some(center)), sizes).unwrap();
    let mut certificate = solve::unrolled(&ring, sizes).unwrap();
    let Orbit::Infinite { band, decay, .. } = &mut certificate.orbit else { panic!() };
    (*band, *decay) = (2, exact("2"));
    certificate.a.truncate(3);
    certificate.a[0][0] += 1e-3;
    certificate
}

/// Bounds of what is proved, or refused for them.
pub(super) fn bounds(certificate: &Certificate) -> Bounds {
    match check(certificate) {
        Ok(proof) => proof.bounds,
        Err(Refused::Bounds(bounds)) => bounds,
        Err(why) => panic!("{why}"),
    }
}

// Truth: the equations in the strains themselves, which are not shifted by half a period a
// site, with four times as many harmonics, and of the infinite chain on more sites.
#[test]
fn rows_are_those_of_the_equations() {
    let ring = |center: Option<Center>| {
        let (block, enclosed) = if center.is_none() { (6, 64) } else { (3, 16) };
        solve::near(&guess(center), Sizes { block, harmonics: enclosed, enclosed }).unwrap()
    };
    let rings = [None, Some(Center::Site), Some(Center::Bond)].map(ring);
    for certificate in rings.into_iter().chain([Center::Site, Center::Bond].map(infinite)) {
        let (bounds, terms) = (bounds(&certificate), Terms::new(&certificate, &|| Ok(())).unwrap());
        let (block, top, first) = (certificate.block, 4 * certificate.enclosed, certificate.a.len());
        let (center, band, far) = match &certificate.orbit {
            Orbit::Wave { .. } => (None, first, None),
            Orbit::Breather { center, .. } => (Some(*center), first, None),
            Orbit::Infinite { center, band, background, .. } => (Some(*center), *band, Some(background)),
        };
        let (last, bond) = (first + band + 1, usize::from(center == Some(Center::Bond)));
        let sites = if far.is_some() { last + 12 } else { first };
        let sign = |n: usize, k: usize| if far.is_some() && (n + bond) * k % 2 == 1 { -1.0 } else { 1.0 };
        let turned = |n: usize| {
            let far = [&[certificate.mean.enclosed().mid()], &far.unwrap()[1..]].concat();
            far.iter().enumerate().map(|(k, a)| sign(n, k) * a).collect()
        };
        let a: Vec<Vec<f64>> = (0..sites).map(|n| certificate.a.get(n).cloned().unwrap_or_else(|| turned(n))).collect();
        let of_site = |a: &Vec<f64>| {
            let a: Vec<Interval> = a.iter().map(|a| Interval::exact(*a)).collect();
            moments(&a, certificate.model.alpha, 2 * top, NARROWEST).unwrap()
        };
        let known: Vec<Moments> = a.iter().map(of_site).collect();
        let l = System::new(&Certificate { enclosed: top, ..certificate.clone() }).unwrap().factors;
        let has = |n: usize, k: usize| k <= top && !(center == Some(Center::Site) && n == 0 && k % 2 == 1);
        // The second difference, and for k = 0 the force, or its difference.
        let terms_of = |n: usize, k: usize| {
            let odd = if k % 2 == 1 { 1.0 } else { -1.0 };
            let left = if n > 0 { (n - 1, -1.0) } else { [(1, odd), (0, -1.0)][bond] };
            let right = if n + 1 < sites { (n + 1, -1.0) } else { [(n, odd), (n.saturating_sub(1), -1.0)][bond] };
            let all = match (k, center) {
                (0, _) if far.is_some() => vec![(n, -1.0)],
                (0, _) => [(n, -1.0), (n + 1, 1.0)].into_iter().filter(|_| n + 1 < sites).collect(),
                (_, None) => vec![(n, 1.0)],
                _ => vec![(n, 2.0), left, right],
            };
            all.into_iter().map(|(m, e)| (m, if k == 0 { e } else { e * l[k].mid() })).collect::<Vec<_>>()
        };
        let plain = |(i, k): (usize, usize), (m, j): (usize, usize)| match k {
            0 if far.is_none() && i + 1 == sites && j == 0 => terms.system.shares[m].mid(),
            0 => 0.0,
            _ => f64::from((i, k) == (m, j)),
        };
        let weight = |k: usize| if k == 0 { f64::sqrt(2.0) } else { 1.0 };
        // A: its rows from the last one on are copies; for unknowns and equations of means over
        // their weight, but for that of the mean strain.
        let inverse = |n: usize, k: usize, m: usize, j: usize| {
            let back = n.saturating_sub(last);
            let of = |n: usize, k: usize| terms.block.index((n.wrapping_sub(back), k));
            let entry = of(n, k).zip(of(m, j)).map_or(0.0, |(i, c)| terms.block.inverse[i][c].mid());
            let of_mean = far.is_none() && m + 1 == sites;
            sign(n, k) * sign(m, j) * entry / weight(k) * if of_mean { 1.0 } else { weight(j) }
        };
        // |h - A g|_n of vectors that are 0 at other sites than these.
        let size =
            |n: usize, sites: RangeInclusive<usize>, h: &dyn Fn(usize) -> f64, g: &dyn Fn(usize, usize) -> f64| {
                let head = |k: usize| -> f64 {
                    let row = sites.clone().flat_map(|m| (0..=block).map(move |j| (m, j)));
                    row.map(|(m, j)| inverse(n, k, m, j) * g(m, j)).sum()
                };
                let own = (0..=top).filter(|k| has(n, *k));
                own.map(|k| weight(k) * (h(k) - if k <= block { head(k) } else { g(n, k) }).abs()).sum::<f64>()
            };
        let weights = check(&certificate).map(|proof| proof.weights);
        let w = |n: usize| match &far {
            Some(_) => (-2.0 * n.saturating_sub(first) as f64).exp(),
            None => weights.as_ref().unwrap()[n],
        };
        let end = |n: usize| n.min(sites - 1);
        // The largest column of 1 - A DG of each site, by row.
        let z1 = |n: usize| -> f64 {
            let of_site = |m: usize| {
                let near = n.saturating_sub(band).max(m.saturating_sub(1))..=(n + band).min(m + 1);
                let near = if far.is_some() { near } else { 0..=sites - 1 };
                let column = |j: usize| {
                    let of = |i: usize, k: usize| {
                        let entry = |(p, e): (usize, f64)| {
                            if p == m { e * stiffness(&known[m].stiffness, k, j) } else { 0.0 }
                        };
                        let all = || plain((i, k), (m, j)) + terms_of(i, k).into_iter().map(entry).sum::<f64>();
                        if has(i, k) { all() } else { 0.0 }
                    };
                    size(n, near.clone(), &|k| f64::from((n, k) == (m, j)), &of) / weight(j)
                };
                w(m) * (0..=top).filter(|j| has(m, *j)).map(column).fold(0.0, f64::max)
            };
            (n.saturating_sub(band + 1)..=end(n + band + 1)).map(of_site).sum::<f64>() / w(n)
        };
        let rows: Vec<f64> = (0..=end(last + 5)).map(z1).collect();
        let most = rows.iter().copied().fold(0.0, f64::max);
        assert!(most < bounds.z1 && most > 0.9 * bounds.z1, "{center:?}: {most} {bounds:?}");
        if far.is_none() {
            continue;
        }
        let defect = |n: usize, k: usize| {
            let forces: f64 = terms_of(n, k).into_iter().map(|(m, e)| e * known[m].force[k].mid()).sum();
            if k == 0 { -forces - known[first].force[0].mid() } else { a[n].get(k).unwrap_or(&0.0) - forces }
        };
        let y0 = |n: usize| size(n, n.saturating_sub(band)..=n + band, &|_| 0.0, &defect);
        let tails = terms.tails.iter().map(|tail| 4.0 * (terms.system.tails()[0] * *tail).hi());
        let tails = tails.fold(0.0, f64::max);
        for (n, bound) in terms.y0().into_iter().take(first + 2).enumerate() {
            let least = 0.97 * bound.hi() - tails;
            assert!(y0(n) < bound.hi() && y0(n) > least, "{center:?} {n}: {:e} {bound:?}", y0(n));
        }
        let most = (0..=last + 5).map(|n| y0(n) / w(n)).fold(0.0, f64::max);
        assert!(most < bounds.y0 && most > 0.97 * bounds.y0, "{center:?}: {most:e} {bounds:?}");
        // Where rows are copied from: the rest is the error of the background.
        let [before, at] = [last - 1, last].map(y0);
        assert!(terms.rows() == last + 1 && before > 1e-8 && at < 1e-10, "{center:?}: {before:e} {at:e}");
        assert!(rows[last..].iter().all(|row| (row / rows[last] - 1.0).abs() < 1e-9), "{center:?}: {rows:?}");
        let index = |n: usize, k: usize| terms.block.index((n, k)).unwrap();
        let of = |n: usize, k: usize, m: usize, j: usize| terms.block.inverse[index(n, k)][index(m, j)].mid();
        for (k, j) in [(0, 0), (1, 0), (3, 2)] {
            assert!((last..last + 2).all(|n| of(n + 1, k, n, j) == of(n, k, n - 1, j)), "{center:?} {k} {j}");
        }
    }
}

// Truth: a background of four times as many harmonics.
#[test]
fn the_background_is_not_its_cosine_sum() {
    let certificate = infinite(Center::Bond);
    let terms = Terms::new(&certificate, &|| Ok(())).unwrap();
    let Orbit::Infinite { background, .. } = &certificate.orbit else { panic!() };
    let sizes = Sizes { block: 3, harmonics: 256, enclosed: 256 };
    let (orbit, a) = (Orbit::Wave { q_over_pi: Exact::ONE }, vec![background.clone()]);
    let finer = solve::near(&Certificate { orbit, a, ..certificate.clone() }, sizes).unwrap();
    let of = |a: &[Interval]| moments(a, certificate.model.alpha, 16, NARROWEST).unwrap();
    let (truth, own) = (of(&System::new(&finer).unwrap().a[0]), of(&terms.system.a[3]));
    for known in &terms.system.known[3..] {
        assert!((0..=16).all(|k| known.force[k].holds(truth.force[k].mid())));
        assert!((0..=16).all(|k| known.stiffness[k].holds(truth.stiffness[k].mid())));
    }
    assert!(!own.force[1].holds(truth.force[1].mid()) && !own.stiffness[1].holds(truth.stiffness[1].mid()));
    assert!(terms.tails[3].hi() > own.force_tail(16).hi());
}

// Truth: a column of zeros is a kernel.
#[test]
fn a_kernel_is_found() {
    let certificate = infinite(Center::Site);
    let mut terms = Terms::new(&certificate, &|| Ok(())).unwrap();
    let derivative = matrix(&terms.block, std::slice::from_ref(&terms.system.factors));
    let far = terms.far.unwrap();
    assert_eq!(far.has_no_kernel(&terms.block, &derivative), Ok(()));
    terms.block.inverse.iter_mut().for_each(|row| row[7] = Interval::ZERO);
    let found = far.has_no_kernel(&terms.block, &derivative);
    assert!(matches!(found, Err(Refused::Kernel(bound)) if bound >= 1.0), "{found:?}");
}

// Truth: entries of B that couple sites further apart are none, whatever its maker says.
#[test]
fn choices_that_break_a_rule_prove_nothing() {
    let certificate = infinite(Center::Site);
    let terms = Terms::new(&certificate, &|| Ok(())).unwrap();
    let near = matrix(&terms.block, std::slice::from_ref(&terms.system.factors));
    let mut wider = near.clone();
    wider[0][terms.block.all.len() - 1] = 1e9;
    let far = terms.far.unwrap();
    assert_eq!(far.has_no_kernel(&terms.block, &near), far.has_no_kernel(&terms.block, &wider));
    // Weights that are not positive, or missing.
    for weights in [&[1.0, 0.0][..], &[1.0, -1.0], &[1.0, f64::NAN], &[1.0]] {
        let of = weights.iter().copied().map(Interval::exact).collect();
        let derivative = Derivative { entries: Vec::new(), contacts: Vec::new(), weights: of, rows: 1 };
        assert!(derivative.norm(&[0.1, 0.2].map(Interval::exact)).is_nan(), "{weights:?}");
    }
}

// Truth: for q = Z1 + Z2 r the inequality Y0 + q r <= r is quadratic.
#[test]
fn radii_are_the_roots() {
    let radii = |[y0, z1, z2]: [f64; 3], largest: f64| {
        let [y0, z1, z2] = [y0, z1, z2].map(Interval::exact);
        radii(y0, largest, |r| z1 + z2 * Interval::exact(r))
    };
    for [y0, z1, z2] in [[1e-6_f64, 0.5, 1.0], [1e-13, 0.1, 30.0], [0.02, 0.7, 0.4]] {
        let root = 2.0 * y0 / (1.0 - z1 + f64::sqrt((1.0 - z1).powi(2) - 4.0 * z2 * y0));
        let (radius, unique, q) = radii([y0, z1, z2], f64::INFINITY).unwrap();
        assert!(radius.hi() >= y0 / (1.0 - q.hi()) && q.hi() > z1 + z2 * radius.hi(), "{radius:?} {q:?}");
        // One rung of the ladder.
        assert!(radius.hi() >= root && radius.hi() < RUNG * root, "{radius:?} {root:e}");
        let widest = (1.0 - z1) / z2;
        assert!(unique < widest && unique > widest / RUNG / (1.0 + 1e-12), "{unique:e} {widest:e}");
        assert!(radii([y0, z1, z2], 0.9 * root).is_none());
        assert!(radii([y0, z1, z2], 2.0 * root).is_some_and(|(_, unique, _)| unique <= 2.0 * root));
        // Twice the largest Y0 that has a root.
        assert!(radii([0.5 * (1.0 - z1).powi(2) / z2, z1, z2], f64::INFINITY).is_none());
    }
    for wrong in [[f64::NAN, 0.1, 1.0], [0.1, f64::NAN, 1.0], [0.1, 0.1, f64::NAN], [0.0, 1.0, 1.0], [0.0, 1.5, 1.0]] {
        assert!(radii(wrong, f64::INFINITY).is_none(), "{wrong:?}");
    }
}
