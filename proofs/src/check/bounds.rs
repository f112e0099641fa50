//! `Y0`, `Z1` and `Z2` of a system.
//!
//! The matrix of the block is `DG`. Its further unknown is the frequency of a piece that fixes
//! `a_1`; the equation of `a_1` has its index.

use super::{
    Bounds, Moments, Proof, Refused, System,
    block::{Block, Lines, Place, dot, largest, perron},
    infinite::Far,
    moments::{NARROWEST, NARROWEST_ALONG, moments},
    multiplier, of, radii,
};
use crate::{
    certificate::Certificate,
    exact::Exact,
    interval::{Interval, norm},
};

/// Largest radius of a ball of a piece with an unknown frequency, over `Y0` of the wave.
const WIDEST: usize = 5;

/// What the bounds are made of, beside the certificate.
struct Terms<'a> {
    certificate: &'a Certificate,
    system: System,
    block: Block,
    /// `R'` along a piece, by site of the column.
    turned: Vec<Vec<Interval>>,
    /// Moments of the force of each site.
    known: Vec<Moments>,
    /// The roots of the sums of `l_k^2` beyond `K`, and of their changes along a piece.
    beyond_block: [Interval; 2],
    /// Tails of the forces beyond `K'`, and of `D` beyond `K' - 2 K`.
    tails: Vec<[Interval; 2]>,
    /// What is known of the background of the infinite chain.
    far: Option<Far>,
}

/// `B`, with the factors `l_k`, or their changes along a piece.
fn b(system: &System, block: &Block, l: &[Interval]) -> Lines {
    block.rows(|(n, k, part)| {
        let all = match (k, system.level(n)) {
            (0, None) => Vec::new(),
            // The mean force of the background is known.
            (0, Some(m)) if system.background.is_none() => vec![(n, 1.0), (m, -1.0)],
            (0, _) => vec![(n, 1.0)],
            _ => system.coupled(n, k),
        };
        all.into_iter().map(|(m, e)| ((m, k, part), Interval::exact(e) * l[k])).collect()
    })
}

impl<'a> Terms<'a> {
    fn new(certificate: &'a Certificate, go_on: &dyn Fn() -> Result<(), Refused>) -> Result<Self, Refused> {
        let system = System::new(certificate)?;
        let (block, enclosed, alpha) = (certificate.block, certificate.enclosed, certificate.model.alpha);
        let [start, end] = certificate.ends();
        let narrowest = if start == end { NARROWEST } else { NARROWEST_ALONG };
        let far = Far::new(certificate, &|| go_on().is_err())?;
        // Those of the background are all the same.
        let known = system.a.iter().take(system.background.map_or(usize::MAX, |first| first + 1)).map(|a| {
            let known = moments(a, alpha, enclosed, narrowest, &|| go_on().is_err());
            go_on()?;
            known.ok_or(Refused::Moments)
        });
        let mut known = known.collect::<Result<Vec<Moments>, _>>()?;
        let beyond =
            |l: &dyn Fn(usize) -> Interval, i: usize| norm((block + 1..=enclosed).map(l).chain([system.tails()[i]]));
        let beyond_block = [beyond(&|k| system.range(k), 0), beyond(&|k| system.slopes[k], 1)];
        let tail = |one: &Moments| [one.force_tail(enclosed), one.stiffness_tail(enclosed - 2 * block)];
        let mut tails: Vec<[Interval; 2]> = known.iter().map(tail).collect();
        if let Some(far) = &far {
            // The background is near its cosine sum, not on it.
            let first = known.len() - 1;
            let (within, changes) = known[first].within(alpha, far.background.radius.into());
            let tail = [0, 1].map(|i| tails[first][i] + changes[i]);
            (known[first], tails[first]) = (within.clone(), tail);
            known.resize(system.a.len(), within);
            tails.resize(system.a.len(), tail);
        }
        let places = (0..system.a.len()).flat_map(|n| (0..=block).map(move |k| (n, k, false)));
        let all: Vec<Place> = places.filter(|(n, k, _)| system.has(*n, *k)).collect();
        let level = all.iter().position(|place| *place == (system.a.len() - 1, 0, false)).unwrap_or(0);
        let plain = |(i, &(n, k, _)): (usize, &Place)| match k {
            0 => system.shares.get(n).map(|share| (level, *share)).into_iter().collect(),
            1 if system.first.is_some() => vec![(i, Interval::ONE), (all.len(), Interval::ONE)],
            _ => vec![(i, Interval::ONE)],
        };
        let turn = |(i, &(n, k, _)): (usize, &Place)| (i, -(system.slopes[k] * known[n].force[k]));
        let column = system.first.map(|_| all.iter().enumerate().skip(1).map(turn).collect());
        let plain = all.iter().enumerate().map(plain).chain(column).collect();
        let mut block = Block::new(all, system.a.len(), 0, plain);
        let b = b(&system, &block, &system.factors);
        block.invert(&b, &known);
        if let Some(far) = &far {
            far.copy_rows(&mut block);
            far.has_no_kernel(&block, &block.matrix(&b, &known))?;
        }
        go_on()?;
        block.multiply(&b);
        let turned = block.reach_of(&block.times(&self::b(&system, &block, &system.slopes)));
        Ok(Self { certificate, system, block, turned, known, beyond_block, tails, far })
    }

    /// Sites whose bounds are those of all sites.
    fn rows(&self) -> usize {
        self.far.as_ref().map_or(self.known.len(), |far| far.last_row() + 1)
    }

    /// `sum_m e_nm n_mk`; of a site of the background less that of the background.
    fn force(&self, n: usize, k: usize) -> Interval {
        let term = |(m, e): (usize, f64)| Interval::exact(e) * self.known[m].force[k];
        self.system.defects(n, k).into_iter().map(term).sum()
    }

    /// `G_nk` for these factors; of a site of the background less that of the background.
    fn defect(&self, (n, k): (usize, usize), l: Interval) -> Interval {
        let (Self { system, known, .. }, is_background) = (self, self.system.is_background(n));
        let own = system.a[n].get(k).copied().filter(|_| !is_background).unwrap_or(Interval::ZERO);
        match (k, system.level(n)) {
            (0, _) if is_background => Interval::ZERO,
            (0, Some(m)) => known[n].force[0] - known[m].force[0],
            (0, None) => {
                system.shares.iter().zip(&system.a).map(|(share, a)| *share * a[0]).sum::<Interval>() - system.mean[0]
            }
            _ => own - l * self.force(n, k),
        }
    }

    /// `Y0` by site. Along a piece the block has the change of `G`, too, at the rate of one half of
    /// the piece.
    fn y0(&self) -> Vec<Interval> {
        let Self { certificate, system, block, .. } = self;
        let residual = |&(n, k, _): &Place| self.defect((n, k), system.factors[k]);
        let rate = |&(n, k, _): &Place| match k {
            0 if system.level(n).is_none() => -system.mean[1],
            _ if system.first.is_some() => Interval::ZERO,
            _ => -(system.slopes[k] * self.force(n, k)),
        };
        let [first, change] = [0, 1].map(|i| system.first.map(|it| it[i]));
        let residual: Vec<Interval> =
            block.all.iter().map(residual).chain(first.map(|first| system.a[0][1] - first)).collect();
        let rates: Vec<Interval> = block.all.iter().map(rate).chain(change.map(|change| -change)).collect();
        let mut y0 = block.by_site(&|i| {
            let row = &block.inverse[i];
            dot(row, &residual).abs() + dot(row, &rates).abs()
        });
        for (n, y0) in y0.iter_mut().enumerate().take(self.known.len()) {
            let beyond = (certificate.block + 1..=certificate.enclosed).filter(|k| system.has(n, *k));
            let middle: Interval = beyond.map(|k| self.defect((n, k), system.range(k)).abs()).sum();
            let tails = system.defects(n, 0).into_iter().map(|(m, e)| Interval::exact(e.abs()) * self.tails[m][0]);
            *y0 = *y0 + middle + system.beyond() * tails.sum();
        }
        y0
    }

    /// The column of an unknown frequency of `I - A DG`, by site, along all of the piece.
    fn column_of_last(&self) -> Vec<Interval> {
        let Self { certificate, system, block, known, tails, .. } = self;
        let mut column = block.further_columns();
        if system.first.is_some() {
            let beyond = (certificate.block + 1..=certificate.enclosed).map(|k| system.slopes[k] * known[0].force[k]);
            column[0] = column[0] + beyond.map(Interval::abs).sum() + system.tails()[1] * tails[0][0];
        }
        column
    }

    /// A bound of the change of a row of this column in the ball of radius `r`: that of the force.
    fn change_of_last(&self, n: usize, r: Interval) -> Interval {
        let turned = self.turned[0][n] + if n == 0 { self.beyond_block[1] } else { Interval::ZERO };
        turned * self.known[0].force_change(self.certificate.model.alpha, r)
    }

    /// A bound of the error of velocities over `omega`, by one more use of `a = l N(a)`; of `y_n`
    /// with a factor `share` for each harmonic. `changes` are those of the strains of each site.
    fn velocity(&self, changes: &[Interval], share: &dyn Fn(usize) -> Interval) -> Interval {
        let Self { certificate: Certificate { model, enclosed, .. }, system, known, tails, .. } = self;
        let enclosed = *enclosed;
        let root = share(enclosed + 1) * (system.decay[0].square() / of(enclosed)).sqrt();
        let steep = norm((1..=enclosed).map(|k| of(k) * share(k) * system.range(k)).chain([root]));
        let force = |((one, tail), change): ((&Moments, &[Interval; 2]), &Interval)| {
            root * tail[0] + steep * one.force_change(model.alpha, *change)
        };
        let forces: Vec<Interval> = known.iter().zip(tails).zip(changes).map(force).collect();
        let of_site = |n: usize| {
            let defects = (1..=enclosed)
                .filter(|k| system.has(n, *k))
                .map(|k| of(k) * share(k) * self.defect((n, k), system.range(k)).abs());
            defects.sum::<Interval>() + dot(&system.moduli(n), &forces)
        };
        (0..self.rows()).map(of_site).fold(Interval::ZERO, Interval::max)
    }

    /// What follows from the radii of the ball and of uniqueness, and from the frequency. An
    /// unknown frequency has the last of the weights.
    fn proof(
        &self,
        (bounds, radius, unique): (Bounds, Interval, f64),
        frequency: Interval,
        weights: Vec<Interval>,
        go_on: &dyn Fn() -> Result<(), Refused>,
    ) -> Result<Proof, Refused> {
        let Self { certificate, system, known, far, .. } = self;
        let first: Vec<Interval> = system.a.iter().map(|a| a[1].abs()).collect();
        let amplitude = first.iter().copied().fold(Interval::ZERO, Interval::max);
        if !first.iter().zip(&weights).any(|(first, w)| (*first - *w * radius).is_positive()) {
            return Err(Refused::Rest(radius.hi(), amplitude.lo()));
        }
        let changes: Vec<Interval> = weights.iter().map(|w| *w * radius).collect();
        let multiplier = certificate
            .multiplier
            .as_ref()
            .map(|multiplier| multiplier::check(certificate, multiplier, (known, &changes), go_on));
        let multiplier = multiplier.transpose()?;
        // |b_k/a_k|; NaN where it is not known to be finite. The mean of a single wave is exact.
        let kappa = certificate.model.kappa.enclosed();
        let share = |rho: Exact, k: usize| kappa / (kappa - rho.enclosed() * (system.omega() * of(k)).square());
        let resonator = |k: usize| certificate.model.rho.map_or(Interval::ZERO, |rho| share(rho, k).abs());
        let mean = if system.is_wave() && certificate.to.is_none() { Interval::ZERO } else { Interval::ONE };
        let resonators = (1..=certificate.enclosed + 1).map(resonator).fold(mean, Interval::max);
        let decay = far.as_ref().map(|far| far.decay(system, &weights, radius));
        // The background of the infinite chain is as near to its own sum as its proof says.
        let of_background =
            |of: fn(&Proof) -> f64| far.as_ref().map_or(Interval::ZERO, |far| of(&far.background).into());
        let bound = |own: Interval, background: fn(&Proof) -> f64| {
            let bound = own + of_background(background);
            if bound.is_nan() { f64::INFINITY } else { bound.hi() }
        };
        let velocity = |share: &dyn Fn(usize) -> Interval| system.omega() * self.velocity(&changes, share);
        Ok(Proof {
            radius: bound(radius, |it| it.radius),
            radius_y: bound(radius * resonators, |it| it.radius_y),
            radius_velocity: bound(velocity(&|_| Interval::ONE), |it| it.radius_velocity),
            radius_velocity_y: bound(velocity(&resonator), |it| it.radius_velocity_y),
            uniqueness_radius: unique,
            frequency: [frequency.lo(), frequency.hi()],
            amplitude: amplitude.lo(),
            bounds,
            weights: weights.into_iter().map(Interval::hi).collect(),
            multiplier,
            decay,
        })
    }
}

pub(super) fn check(certificate: &Certificate, stopped: &dyn Fn() -> bool) -> Result<Proof, Refused> {
    let go_on = || if stopped() { Err(Refused::Stopped) } else { Ok(()) };
    let terms = Terms::new(certificate, &go_on)?;
    let Terms { system, known, block, turned, .. } = &terms;
    let (alpha, sites) = (certificate.model.alpha, known.len());

    // The Hölder constant of D: for alpha > 2 in balls up to an eighth of the first harmonic.
    let [stiff, bent] = [alpha.less_one(), alpha.less_one().less_one()];
    let (gamma, hoelder) = if bent.num() > 0 {
        let amplitude = system.a.iter().map(|a| a[1].abs()).fold(Interval::ZERO, Interval::max);
        let overlaps = known.iter().map(|one| Interval::exact(one.overlap.hi()));
        let overlap = overlaps.fold(Interval::ZERO, Interval::max) + amplitude / of(8);
        (Exact::ONE, alpha.enclosed() * stiff.enclosed() * overlap.pow(bent))
    } else {
        (stiff, alpha.enclosed())
    };

    // Y0, Z1 and Z2, by site, with weights near Perron's vector of R + R' + t |e|: uniform ones have
    // narrower balls of single orbits, but prove less of branches of doubled period.
    let beyond = |n: usize| -> Vec<Interval> {
        let turned = turned.iter().map(|turned| turned[n]);
        turned.zip(system.moduli(n)).map(|(turned, e)| turned + terms.beyond_block[0] * e).collect()
    };
    let beyond: Vec<Vec<Interval>> = (0..=sites).map(beyond).collect();
    let contacts = block.contacts(&beyond);
    let (y0, of_last) = (terms.y0(), terms.column_of_last());
    // An unknown frequency has an exact weight with which a ball of the radius eta, a multiple of
    // Y0, has all frequencies of the piece.
    let turn = system.first.map(|_| Interval::exact((system.middle[1] / (of(WIDEST) * y0[0])).mid()));
    let eta = turn.map_or(Interval::ONE, |turn| system.middle[1] / turn);
    let mut weights = terms.far.as_ref().map_or_else(|| perron(&contacts[..sites]), |far| far.weights(sites));
    let powers: Vec<Interval> = weights.iter().map(|w| *w * w.pow(gamma)).collect();
    let z2: Vec<Interval> = contacts.iter().map(|row| hoelder * dot(row, &powers)).collect();
    let steepest: Vec<Interval> = known.iter().zip(&weights).map(|(one, w)| *w * one.steepest(alpha)).collect();
    let z1 = block.z1(&beyond, &steepest, |m| {
        let computed = (0..=certificate.enclosed - certificate.block).filter(|j| system.has(m, *j));
        let places = computed.map(|j| (m, j, false)).collect();
        let columns = go_on().map(|()| block.columns(m, places, &known[m].stiffness, terms.tails[m][1]))?;
        Ok(columns.into_iter().map(|column| column * weights[m]).collect())
    })?;
    weights.push(Interval::ONE / eta);
    let z1: Vec<Interval> = z1.iter().zip(&of_last).map(|(z1, of_last)| *z1 + *of_last / eta).collect();
    // The largest over the sites, and that of the last unknown.
    let most = |all: &[Interval]| {
        let over: Vec<Interval> = all.iter().zip(&weights).map(|(one, w)| *one / *w).collect();
        largest(&over[..terms.rows()]).max(over[sites])
    };
    let bounds = Bounds { y0: most(&y0).hi(), z1: most(&z1).hi(), z2: most(&z2).hi() };
    let rows = |r: f64| -> Vec<Interval> {
        let change = |(one, w): (&Moments, &Interval)| *w * one.change(alpha, *w * r.into());
        let changes: Vec<Interval> = known.iter().zip(&weights).map(change).collect();
        let row = |(n, row): (usize, &Vec<Interval>)| {
            let turned = system.first.map_or(Interval::ZERO, |_| terms.change_of_last(n, r.into()) / eta);
            z1[n] + dot(row, &changes) + turned
        };
        contacts.iter().enumerate().map(row).collect()
    };
    let widest = if turn.is_some() { eta.lo() } else { f64::INFINITY };
    let found = radii(most(&y0), widest, |r| most(&rows(r)));
    let (radius, unique) = found.ok_or(Refused::Bounds(bounds))?;
    // An unknown frequency is nearer than the radius says, by its own row of T.
    let frequency = turn.map_or(system.omega(), |_| {
        let turned = y0[sites] + rows(radius.hi())[sites] * radius;
        system.middle[0] + (system.middle[1] * turned).ball()
    });
    let weights = weights.into_iter().take(sites).chain(turn).collect();
    terms.proof((bounds, radius, unique), frequency, weights, &go_on)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        certificate::{Breather, Center, Model, Orbit, Wave},
        check::block::{product, weight},
        solve::{self, Sizes},
    };

    fn stiffness(d: &[Interval], k: usize, j: usize) -> Interval {
        product(d, k, j, (0, false))
    }

    // Truth: (1 - A DG) h for h of norm 1 with one harmonic at each site, as products in intervals,
    // with four times as many rows and columns as are enclosed.
    #[test]
    fn columns_are_below_z1() {
        for (center, block, enclosed) in [(None, 6, 64), (Some(Center::Site), 3, 16), (Some(Center::Bond), 3, 16)] {
            let sizes = Sizes { block, harmonics: enclosed, enclosed };
            let certificate = solve::near(&guess(center), sizes).unwrap();
            let proof = check(&certificate, &|| false).unwrap();
            let alpha = certificate.model.alpha;
            let known = |system: &System, count: usize| -> Vec<Moments> {
                system.a.iter().map(|a| moments(a, alpha, count, NARROWEST, &|| false).unwrap()).collect()
            };
            let Block { all, inverse, .. } = Terms::new(&certificate, &|| Ok(())).unwrap().block;
            let system = &System::new(&Certificate { enclosed: 4 * enclosed, ..certificate }).unwrap();
            let (known, sites) = (known(system, 8 * enclosed), system.a.len());
            let harmonics = |n: usize| (0..=4 * enclosed).filter(move |k| system.has(n, *k)).map(move |k| (n, k));
            let beyond: Vec<_> = (0..sites).flat_map(harmonics).filter(|(_, k)| *k > block).collect();
            // The rows of one harmonic at one site; they are added and subtracted below.
            let of_h = |(m, j): (usize, usize)| -> Vec<Interval> {
                let h = Interval::exact(proof.weights[m]) / weight(j);
                let own = |n: usize, k: usize| if (n, k) == (m, j) { h } else { Interval::ZERO };
                let force = |n: usize, k: usize| {
                    if n == m { stiffness(&known[m].stiffness, k, j) * h } else { Interval::ZERO }
                };
                let row = |n: usize, k: usize| {
                    let forces = system.coupled(n, k).into_iter().map(|(m, e)| Interval::exact(e) * force(m, k));
                    match k {
                        0 if n + 1 < sites => force(n + 1, 0) - force(n, 0),
                        0 => system.shares[m] * own(m, 0),
                        _ => own(n, k) + system.factors[k] * forces.sum(),
                    }
                };
                let rows: Vec<Interval> = all.iter().map(|&(n, k, _)| row(n, k)).collect();
                let block = all.iter().zip(&inverse);
                let block = block.map(|(&(n, k, _), inverse)| weight(k) * (own(n, k) - dot(inverse, &rows)));
                block.chain(beyond.iter().map(|&(n, k)| own(n, k) - row(n, k))).collect()
            };
            let columns: Vec<Vec<_>> = (0..sites).map(|n| harmonics(n).map(of_h).collect()).collect();
            let norm = |rows: &[Interval]| {
                let mut sums = vec![Interval::ZERO; sites];
                let places = all.iter().map(|one| one.0).chain(beyond.iter().map(|one| one.0));
                places.zip(rows).for_each(|(n, row)| sums[n] = sums[n] + row.abs());
                sums.iter().zip(&proof.weights).map(|(sum, weight)| sum.lo() / weight).fold(0.0, f64::max)
            };
            let mut most = 0.0_f64;
            // A column of each site in turn, with the sign and harmonic that add most.
            for first in 0..sites {
                let (mut sum, mut largest) = (vec![Interval::ZERO; all.len() + beyond.len()], 0.0);
                for n in (first..sites).chain(0..first) {
                    let before = sum.clone();
                    for (column, sign) in columns[n].iter().flat_map(|column| [(column, 1.0), (column, -1.0)]) {
                        let with = |(sum, row): (&Interval, &Interval)| *sum + Interval::exact(sign) * *row;
                        let with: Vec<Interval> = before.iter().zip(column).map(with).collect();
                        let size = norm(&with);
                        if size > largest {
                            (sum, largest) = (with, size);
                        }
                    }
                }
                most = most.max(largest);
            }
            // Measured: 0.97, 0.75 and 0.74 of it.
            let z1 = proof.bounds.z1;
            assert!(most < z1 && most > 0.7 * z1, "{center:?}: {most} {z1}");
        }
    }

    // Truth: derivatives by differences of the frequency, at both ends and in the middle of a wide
    // piece, with four times as many harmonics, and their changes with the wave.
    #[test]
    fn the_column_of_the_frequency_is_bounded() {
        let exact = |text: &str| text.parse::<Exact>().unwrap();
        let near = guess(None);
        let orbit = Orbit::Wave(Wave { q_over_pi: exact("1/5"), a: vec![0.24] });
        let model = Model { omega: exact("2.0102"), ..near.model };
        let near = Certificate { model, mean: exact("-0.1"), first: Some([exact("0.24"); 2]), orbit, ..near };
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
        let column = |omega: f64, force: &[f64], unit: f64| -> [f64; 2] {
            let [before, after] = [-1e-6, 1e-6].map(|by| at(omega + by, 64).factors);
            let entry = |k: usize| -1e-3 * (after[k].mid() - before[k].mid()) / 2e-6 * force[k];
            let row = |i: usize| -> f64 {
                let image = all.iter().zip(&inverse[i]).map(|((_, k, _), a)| a.mid() * entry(*k));
                (if i == all.len() { unit } else { 0.0 } - image.sum::<f64>()).abs()
            };
            [(0..all.len()).map(row).sum::<f64>() + (4..=64).map(|k| entry(k).abs()).sum::<f64>(), row(all.len())]
        };
        let force = |a: &[Interval]| -> Vec<f64> {
            let found = moments(a, piece.model.alpha, 64, NARROWEST, &|| false).unwrap();
            found.force.into_iter().map(Interval::mid).collect()
        };
        let (own, ends) = (force(&terms.system.a[0]), [2.0092, 2.0102, 2.0112]);
        // The row of the frequency has this column over eta, times eta.
        let bounds = match check(&piece, &|| false) {
            Ok(proof) => proof.bounds,
            Err(Refused::Bounds(bounds)) => bounds,
            Err(why) => panic!("{why}"),
        };
        assert!(bounds.z1 > terms.column_of_last()[1].hi(), "{bounds:?}");
        for (n, bound) in terms.column_of_last().into_iter().map(Interval::hi).enumerate() {
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
                let (most, bound) = (all.map(of).fold(0.0, f64::max), terms.change_of_last(n, r.into()).hi());
                assert!(most < bound && most > 0.1 * bound, "{n} {r}: {most:e} {bound:e}");
            }
        }
    }

    // Truth: factors at both ends of a piece, and sums of squares of 16 times as many.
    #[test]
    fn factors_of_a_piece_are_bounded() {
        let near = Certificate { enclosed: 16, ..guess(Some(Center::Bond)) };
        let ends = ["2.04", "2.06"].map(|end| Model { omega: end.parse().unwrap(), ..near.model });
        let piece = Certificate { model: ends[0], to: Some([ends[1].omega, near.mean]), ..near.clone() };
        let system = System::new(&piece).unwrap();
        let more = System::new(&Certificate { enclosed: 256, ..piece.clone() }).unwrap();
        for model in ends {
            let truth = System::new(&Certificate { model, enclosed: 256, ..near.clone() }).unwrap().factors;
            assert!((1..=16).all(|k| system.range(k).lo() < truth[k].lo() && truth[k].hi() < system.range(k).hi()));
            assert!(norm(truth[17..].iter().copied()).hi() < system.beyond().hi());
        }
        let [slopes, bound] = [norm(more.slopes[17..].iter().copied()), system.tails()[1]].map(Interval::hi);
        assert!(slopes < bound && bound < 1.1 * slopes, "{slopes:e} {bound:e}");
    }

    /// Near a wave, or a breather on a ring of 15.
    fn guess(center: Option<Center>) -> Certificate {
        let exact = |text: &str| text.parse::<Exact>().unwrap();
        let (omega, orbit) = match center {
            None => ("2.001", Orbit::Wave(Wave { q_over_pi: exact("1/5"), a: vec![0.0083] })),
            Some(center) => {
                let first = if center == Center::Site { 0.0 } else { 0.5 };
                let row = |i: i32| {
                    let mean = if center == Center::Site && i == 0 { -0.03 } else { 0.0 };
                    vec![mean, 0.15 * (f64::from(i) + first).tanh() * f64::from(1 - 2 * (i % 2))]
                };
                ("2.05", Orbit::Breather(Breather { sites: 15, center, a: (0..8).map(row).collect() }))
            }
        };
        let model = Model { alpha: exact("3/2"), kappa: Exact::ONE, rho: Some(exact("1/3")), omega: exact(omega) };
        Certificate { model, mean: exact("0"), to: None, first: None, block: 1, enclosed: 4, orbit, multiplier: None }
    }

    /// A breather of the infinite chain with visible defects at its first site, and at its third
    /// one, the last before the background.
    fn infinite(center: Center) -> Certificate {
        let sizes = Sizes { block: 3, harmonics: 16, enclosed: 16 };
        let ring = solve::near(&guess(Some(center)), sizes).unwrap();
        let mut certificate = solve::unrolled(&ring, sizes).unwrap();
        let Orbit::Infinite(infinite) = &mut certificate.orbit else { panic!() };
        (infinite.band, infinite.decay) = (2, "2".parse().unwrap());
        infinite.a.truncate(3);
        infinite.a[0][0] += 1e-3;
        certificate
    }

    // Truth: the equations in the strains themselves, which are not shifted by half a period a
    // site, on more sites and with four times as many harmonics.
    #[test]
    fn rows_of_the_infinite_chain_are_those_of_its_equations() {
        for center in [Center::Site, Center::Bond] {
            let certificate = infinite(center);
            let bounds = match check(&certificate, &|| false) {
                Ok(proof) => proof.bounds,
                Err(Refused::Bounds(bounds)) => bounds,
                Err(why) => panic!("{why}"),
            };
            let terms = Terms::new(&certificate, &|| Ok(())).unwrap();
            let Certificate { block, orbit: Orbit::Infinite(it), .. } = &certificate else { panic!() };
            let (first, last, top, bond) =
                (it.a.len(), it.a.len() + it.band + 1, 64, usize::from(center == Center::Bond));
            let sites = last + 12;
            let sign = |n: usize, k: usize| if (n + bond) * k % 2 == 1 { -1.0 } else { 1.0 };
            let far = [&[certificate.mean.enclosed().mid()], it.background.as_slice()].concat();
            let turned = |n: usize| far.iter().enumerate().map(|(k, a)| sign(n, k) * a).collect();
            let a: Vec<Vec<f64>> = (0..sites).map(|n| it.a.get(n).cloned().unwrap_or_else(|| turned(n))).collect();
            let known: Vec<Moments> = a
                .iter()
                .map(|a| {
                    let a: Vec<Interval> = a.iter().map(|a| Interval::exact(*a)).collect();
                    moments(&a, certificate.model.alpha, 2 * top, NARROWEST, &|| false).unwrap()
                })
                .collect();
            let l = System::new(&Certificate { enclosed: top, ..certificate.clone() }).unwrap().factors;
            let has = |n: usize, k: usize| k <= top && !(bond == 0 && n == 0 && k % 2 == 1);
            // The second difference, and for k = 0 the force.
            let terms_of = |n: usize, k: usize| {
                let left = match n {
                    0 if bond == 1 => (0, -1.0),
                    0 => (1, if k % 2 == 1 { 1.0 } else { -1.0 }),
                    _ => (n - 1, -1.0),
                };
                let all = if k == 0 { vec![(n, -1.0)] } else { vec![(n, 2.0), left, (n + 1, -1.0)] };
                all.into_iter().map(|(m, e)| (m, if k == 0 { e } else { e * l[k].mid() })).collect::<Vec<_>>()
            };
            // A: its rows from the last one on are copies.
            let inverse = |n: usize, k: usize, m: usize, j: usize| {
                let back = n.saturating_sub(last);
                let of = |n: usize, k: usize| terms.block.index((n.wrapping_sub(back), k, false));
                let entry = of(n, k).zip(of(m, j)).map_or(0.0, |(i, c)| terms.block.inverse[i][c].mid());
                sign(n, k) * sign(m, j) * entry
            };
            let weight = |k: usize| if k == 0 { f64::sqrt(2.0) } else { 1.0 };
            // |A g|_n of a vector that is 0 at other sites than these.
            let size = |n: usize, g: &dyn Fn(usize, usize) -> f64| -> f64 {
                let near = n.saturating_sub(it.band)..=n + it.band;
                let head = |k: usize| -> f64 {
                    let row = near.clone().flat_map(|m| (0..=*block).map(move |j| (m, j)));
                    row.map(|(m, j)| inverse(n, k, m, j) * g(m, j)).sum::<f64>()
                };
                let own = (0..=top).filter(|k| has(n, *k));
                own.map(|k| weight(k) * if k <= *block { head(k) } else { g(n, k) }.abs()).sum()
            };
            let w = |n: usize| (-2.0 * n.saturating_sub(first) as f64).exp();
            let defect = |n: usize, k: usize| {
                let forces: f64 = terms_of(n, k).into_iter().map(|(m, e)| e * known[m].force[k].mid()).sum();
                if k == 0 { -forces - known[first].force[0].mid() } else { a[n].get(k).unwrap_or(&0.0) - forces }
            };
            let y0 = |n: usize| size(n, &defect);
            let tails = terms.tails.iter().map(|[tail, _]| 4.0 * (terms.system.beyond() * *tail).hi());
            let tails = tails.fold(0.0, f64::max);
            for (n, bound) in terms.y0().into_iter().take(first + 2).enumerate() {
                let least = 0.97 * bound.hi() - tails;
                assert!(y0(n) < bound.hi() && y0(n) > least, "{center:?} {n}: {:e} {bound:?}", y0(n));
            }
            let most = (0..=last + 5).map(|n| y0(n) / w(n)).fold(0.0, f64::max);
            assert!(most < bounds.y0 && most > 0.97 * bounds.y0, "{center:?}: {most:e} {bounds:?}");
            // The largest column of 1 - A DG of each site, by row.
            let z1 = |n: usize| -> f64 {
                let of_site = |m: usize| {
                    let column = |j: usize| {
                        let of = |i: usize, k: usize| {
                            let entry = |(p, e): (usize, f64)| {
                                if p == m { e * stiffness(&known[m].stiffness, k, j).mid() } else { 0.0 }
                            };
                            let plain = f64::from((i, k) == (m, j) && k > 0);
                            if has(i, k) { plain + terms_of(i, k).into_iter().map(entry).sum::<f64>() } else { 0.0 }
                        };
                        let own = |i: usize, k: usize| f64::from((i, k) == (m, j));
                        let row = (0..=top).filter(|k| has(n, *k)).map(|k| {
                            let near = n.saturating_sub(it.band).max(m.saturating_sub(1))..=(n + it.band).min(m + 1);
                            let all = near.flat_map(|i| (0..=*block).map(move |l| (i, l)));
                            let image = if k <= *block {
                                all.map(|(i, l)| inverse(n, k, i, l) * of(i, l)).sum()
                            } else {
                                of(n, k)
                            };
                            weight(k) * (own(n, k) - image).abs()
                        });
                        row.sum::<f64>() / weight(j)
                    };
                    w(m) * (0..=top).filter(|j| has(m, *j)).map(column).fold(0.0, f64::max)
                };
                (n.saturating_sub(it.band + 1)..=n + it.band + 1).map(of_site).sum::<f64>() / w(n)
            };
            let rows: Vec<f64> = (0..=last + 5).map(z1).collect();
            let most = rows.iter().copied().fold(0.0, f64::max);
            assert!(most < bounds.z1 && most > 0.9 * bounds.z1, "{center:?}: {most} {bounds:?}");
            // Where rows are copied from: the rest is the error of the background.
            let [before, at] = [last - 1, last].map(y0);
            assert!(terms.rows() == last + 1 && before > 1e-8 && at < 1e-10, "{center:?}: {before:e} {at:e}");
            assert!(rows[last..].iter().all(|row| (row / rows[last] - 1.0).abs() < 1e-9), "{center:?}: {rows:?}");
            let index = |n: usize, k: usize| terms.block.index((n, k, false)).unwrap();
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
        let Orbit::Infinite(it) = &certificate.orbit else { panic!() };
        let sizes = Sizes { block: 3, harmonics: 256, enclosed: 256 };
        let finer = solve::wave(certificate.model, Exact::ONE, certificate.mean, &it.background, sizes).unwrap();
        let of = |a: &[Interval]| moments(a, certificate.model.alpha, 16, NARROWEST, &|| false).unwrap();
        let (truth, own) = (of(&System::new(&finer).unwrap().a[0]), of(&terms.system.a[3]));
        for known in &terms.known[3..] {
            assert!((0..=16).all(|k| known.force[k].holds(truth.force[k].mid())));
            assert!((0..=16).all(|k| known.stiffness[k].holds(truth.stiffness[k].mid())));
        }
        assert!(!own.force[1].holds(truth.force[1].mid()) && !own.stiffness[1].holds(truth.stiffness[1].mid()));
        assert!(terms.tails[3][0].hi() > own.force_tail(16).hi());
    }

    // Truth: a column of zeros is a kernel.
    #[test]
    fn a_kernel_is_found() {
        let certificate = infinite(Center::Site);
        let mut terms = Terms::new(&certificate, &|| Ok(())).unwrap();
        let b = b(&terms.system, &terms.block, &terms.system.factors);
        let derivative = terms.block.matrix(&b, &terms.known);
        let far = terms.far.unwrap();
        assert_eq!(far.has_no_kernel(&terms.block, &derivative), Ok(()));
        terms.block.inverse.iter_mut().for_each(|row| row[7] = Interval::ZERO);
        let found = far.has_no_kernel(&terms.block, &derivative);
        assert!(matches!(found, Err(Refused::Kernel(bound)) if bound >= 1.0), "{found:?}");
    }
}
