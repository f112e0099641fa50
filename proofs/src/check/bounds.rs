//! `Y0` and `Z1` of a system.
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
pub struct Terms<'a> {
    certificate: &'a Certificate,
    /// The equations.
    pub system: System,
    /// `M` and `A`.
    pub block: Block,
    /// `R'` along a piece, by site of the column.
    turned: Vec<Vec<Interval>>,
    /// Moments of the force of each site.
    pub known: Vec<Moments>,
    /// The roots of the sums of `l_k^2` beyond `K`, and of their changes along a piece.
    beyond_block: [Interval; 2],
    /// Tails of the forces beyond `K'`, and of `D` beyond `K' - 2 K`.
    pub tails: Vec<[Interval; 2]>,
    /// What is known of the background of the infinite chain.
    pub far: Option<Far>,
}

/// `B`, with the factors `l_k`, or their changes along a piece.
pub fn b(system: &System, block: &Block, l: &[Interval]) -> Lines {
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
    /// Those of a certificate.
    pub fn new(certificate: &'a Certificate, go_on: &dyn Fn() -> Result<(), Refused>) -> Result<Self, Refused> {
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
    pub fn rows(&self) -> usize {
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
    pub fn y0(&self) -> Vec<Interval> {
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
    pub fn column_of_last(&self) -> Vec<Interval> {
        let Self { certificate, system, block, known, tails, .. } = self;
        let mut column = block.further_columns();
        if system.first.is_some() {
            let beyond = (certificate.block + 1..=certificate.enclosed).map(|k| system.slopes[k] * known[0].force[k]);
            column[0] = column[0] + beyond.map(Interval::abs).sum() + system.tails()[1] * tails[0][0];
        }
        column
    }

    /// A bound of the change of a row of this column in the ball of radius `r`: that of the force.
    pub fn change_of_last(&self, n: usize, r: Interval) -> Interval {
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

    // Y0 and Z1, by site, with weights near Perron's vector of R + R' + t |e|: uniform ones have
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
    let bounds = Bounds { y0: most(&y0).hi(), z1: most(&z1).hi() };
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
