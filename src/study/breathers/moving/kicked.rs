//! A breather at rest that is kicked: the times at which its kink passes bonds, and its depth
//! there.

use super::Moving;
use crate::{
    breathers::centre,
    error::{Result, require},
    numerics::least_by,
    orbits::{Orbit, Shooting},
    run::state_at,
};
use hertzchain_integrators::collocation::StepControl;
use nalgebra::Complex;

/// Samples a period for local amplitudes.
const SAMPLES: u64 = 16;
const MOST_PERIODS: f64 = 1e5;

/// A kink that passes a bond.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Passage {
    /// Time of the passage.
    pub t: f64,
    /// The bond, between the sites `bond` and `bond + 1`, `n = -N .. N` and on round the ring.
    pub bond: i64,
    /// Two sites over the time between the passages before and after; `None` at the first and last.
    pub velocity: Option<f64>,
    /// Mean local amplitude of the two sites, over the background.
    pub depth: f64,
}

/// A breather at rest that was kicked.
#[derive(Clone, Debug, PartialEq)]
pub struct KickedRun {
    /// Frequency of the breather.
    pub omega_b: f64,
    /// Middles of periods.
    pub times: Vec<f64>,
    /// Position of the kink at these times, in sites `n`.
    pub position: Vec<f64>,
    /// The first passage of each bond, in the direction in which the kink is displaced at the end.
    pub passages: Vec<Passage>,
}

/// Refuses a kick and a time outside their rules.
pub(super) fn check(options: &Moving, period: f64) -> Result<()> {
    let &Moving { until, kick, .. } = options;
    let rule = "0, or from one period of the background to 10^5";
    require((period..=MOST_PERIODS * period).contains(&until), "until", until, rule)?;
    let rule = "a share of the amplitude, not zero and at most 1";
    require(kick.is_finite() && kick != 0.0 && kick.abs() <= 1.0, "kick", kick, rule)?;
    Ok(())
}

/// Position of the kink and local amplitudes over one period. Amplitudes are in units of the
/// background, which is their median.
pub struct Local {
    /// The time.
    pub t: f64,
    /// The position of the kink.
    pub position: f64,
    /// The amplitudes, site by site.
    pub amplitudes: Vec<f64>,
}

impl KickedRun {
    /// The run from the orbit, kicked along the mode that grows most.
    ///
    /// # Errors
    /// An integration that fails, or multipliers that cannot be computed.
    pub(super) fn of(rest: &Orbit, options: &Moving) -> Result<Self> {
        let shooting = Shooting::default();
        let (period, n) = (rest.setting.period(), rest.setting.sites);
        let periods = (options.until / period).floor();
        let along = rest.spectrum(&shooting)?.direction(0);
        let by = options.kick * rest.amplitude();
        let start: Vec<f64> = rest.start().iter().zip(along).map(|(z, along)| z + by * along).collect();
        let (chain, span) = (rest.setting.chain()?, (0.0, periods * period));
        let mut run = chain.collocation(&start, span, StepControl::Tolerance(shooting.tol))?;
        let mut local: Vec<Local> = Vec::new();
        for m in 0..periods as u64 {
            let mut a = vec![Complex::from(0.0); n];
            for k in 0..SAMPLES {
                let turn = k as f64 / SAMPLES as f64;
                let state = state_at(&mut run, (m as f64 + turn) * period)?;
                let turn = Complex::from_polar(2.0 / SAMPLES as f64, 2.0 * std::f64::consts::PI * turn);
                a.iter_mut().zip(&state).for_each(|(a, x)| *a += turn * x);
            }
            let before = local.last().map_or(0.5 * n as f64, |local| local.position);
            local.push(Local::new((m as f64 + 0.5) * period, &a, before));
        }
        // Position 0 of the ring is the site n = -N.
        let first = (n / 2) as f64;
        Ok(Self {
            omega_b: rest.setting.omega_b,
            times: local.iter().map(|one| one.t).collect(),
            position: local.iter().map(|one| one.position - first).collect(),
            passages: passages(&local),
        })
    }

    /// Mean velocity between two times, from the nearest positions; NaN where there is none.
    pub fn mean_velocity(&self, from: f64, to: f64) -> f64 {
        let nearest = |t: f64| least_by(0..self.times.len(), |&k| (self.times[k] - t).abs());
        let (Some(a), Some(b)) = (nearest(from), nearest(to)) else { return f64::NAN };
        (self.position[b] - self.position[a]) / (self.times[b] - self.times[a])
    }
}

impl Local {
    fn new(t: f64, a: &[Complex<f64>], before: f64) -> Self {
        let mut sorted: Vec<f64> = a.iter().map(|a| a.norm()).collect();
        sorted.sort_by(f64::total_cmp);
        let background = sorted[sorted.len() / 2];
        let amplitudes: Vec<f64> = a.iter().map(|a| a.norm() / background).collect();
        Self { t, position: centre(&amplitudes, 1.0, before), amplitudes }
    }

    /// Mean amplitude at the bond between the sites `bond` and `bond + 1`, counted from the first
    /// one on round the ring.
    fn at(&self, bond: i64) -> f64 {
        let n = self.amplitudes.len();
        let site = |k: i64| self.amplitudes[k.rem_euclid(n as i64) as usize];
        0.5 * (site(bond) + site(bond + 1))
    }
}

/// The first passage of each bond, in the direction in which the kink is displaced at the end.
pub fn passages(local: &[Local]) -> Vec<Passage> {
    let Some(n) = local.first().map(|one| one.amplitudes.len()) else { return Vec::new() };
    let start = (n / 2) as i64;
    let way = |one: &Local| one.position - (start as f64 + 0.5);
    let sign = local.last().map_or(1.0, |last| way(last).signum());
    let mut found: Vec<Passage> = Vec::new();
    for pair in local.windows(2) {
        let next = 1.0 + found.len() as f64;
        let [before, now] = [&pair[0], &pair[1]].map(|one| sign * way(one));
        if now >= next && before < next {
            let share = (next - before) / (now - before);
            let bond = start + (sign * next) as i64;
            found.push(Passage {
                t: pair[0].t + share * (pair[1].t - pair[0].t),
                bond: bond - start,
                velocity: None,
                depth: (1.0 - share) * pair[0].at(bond) + share * pair[1].at(bond),
            });
        }
    }
    let times: Vec<f64> = found.iter().map(|one| one.t).collect();
    for (k, times) in times.windows(3).enumerate() {
        found[k + 1].velocity = Some(2.0 / (times[2] - times[0]));
    }
    found
}
