//! Chapter: distances of resonators and velocities ("Resonators and velocities" in `README.md`).

use super::{
    Moments,
    existence::Terms,
    infinite::Far,
    newton::{Equations, Place, dot, largest},
    of,
};
use crate::interval::{Interval, norm};
use std::slice::from_ref;

impl Terms<'_> {
    /// Bounds of velocities by `changes` of the strains; of `y_n` with a factor for each harmonic.
    fn velocity(&self, changes: &[Interval], share: &dyn Fn(usize) -> Interval) -> Interval {
        let (system, enclosed, alpha) = (&self.system, self.certificate.enclosed, self.certificate.model.alpha);
        let root = share(enclosed + 1) * (system.decay[0].square() / of(enclosed)).sqrt();
        let factor = |k: usize| of(k) * share(k);
        let steep = norm((1..=enclosed).map(|k| factor(k) * system.ranges[k]).chain([root]));
        let force = |((one, tail), change): ((&Moments, &Interval), &Interval)| {
            root * *tail + steep * one.force_change(alpha, *change)
        };
        let forces: Vec<Interval> = system.known.iter().zip(&self.tails).zip(changes).map(force).collect();
        let defect = |place: Place| factor(place.1) * system.defect(place, system.ranges[place.1]).abs();
        let defects = |n: usize| system.places(n..n + 1, 1..enclosed + 1).into_iter().map(defect).sum::<Interval>();
        let far = system.far(from_ref(&system.ranges), enclosed, Interval::ONE);
        system.omega() * largest((0..self.rows()).map(|n| defects(n) + dot(&far[n], &forces)))
    }

    /// Bounds of `|x_n - xbar_n|`, `|y_n - ybar_n|` and of their velocities, from those of the
    /// strains of each site; infinite where they are not known. The background of the infinite
    /// chain is as near to its own sum as its proof says.
    pub(super) fn distances(&self, radius: Interval, changes: &[Interval]) -> [f64; 4] {
        let (system, model) = (&self.system, &self.certificate.model);
        let kappa = model.kappa.enclosed();
        let moved = |k: usize| (system.omega() * of(k)).square();
        // |b_k/a_k|; NaN where it is not known to be finite. The mean of a single wave is exact.
        let share =
            |k: usize| model.rho.map_or(Interval::ZERO, |rho| (kappa / (kappa - rho.enclosed() * moved(k))).abs());
        let exact = system.is_wave() && self.certificate.to.is_none();
        let mean = if exact { Interval::ZERO } else { Interval::ONE };
        let most = (1..=self.certificate.enclosed + 1).map(share).fold(mean, Interval::max);
        let velocities = [self.velocity(changes, &|_| Interval::ONE), self.velocity(changes, &share)];
        let own = [radius, radius * most, velocities[0], velocities[1]];
        let background = self.far.as_ref().map_or([0.0; 4], |Far { background: it, .. }| {
            [it.radius, it.radius_y, it.radius_velocity, it.radius_velocity_y]
        });
        // Infinity in place of NaN.
        [0, 1, 2, 3].map(|i| (own[i] + Interval::exact(background[i])).hi().min(f64::INFINITY))
    }
}
