//! The solution of the DpS equation, initial states near it, and runs of the chain from there.

use super::{
    Initial, TheoremOptions, TheoremRun,
    suprema::{Suprema, errors},
};
use crate::{
    chain::{Boundary, Chain, Params, Site, State},
    dps::{Center, Dps, Ends, Form, Homoclinic, Layout},
    error::{Result, require},
    random::uniform,
    run::state_at,
};
use hertzchain_integrators::{Dop853, Stepper, collocation::StepControl, dop853::Options};
use num_complex::Complex64;

/// Sites where a breather is smaller than this share of its largest value are left out.
const TAIL: f64 = 1e-16;
/// A generic profile has this many sites on each side of its middle; it is 1e-11 there.
const GENERIC: i64 = 10;
/// Longest chain.
const MOST_SITES: usize = 1000;
/// Tolerance of the DpS equation: of a step, relative.
const FLOW_TOLERANCE: f64 = 1e-13;
/// Least and largest tolerance of the runs of the chain.
const TOLERANCES: (f64, f64) = (1e-14, 1e-6);

/// `A(0)`, and the departure of the initial state from the ansatz.
pub struct Start {
    /// `A(0)`, site by site.
    pub amplitudes: Vec<Complex64>,
    /// Frequency of a breather; `None` where the DpS equation must be solved.
    pub omega_0: Option<f64>,
    /// The departure for `C_i = 1`, without its powers of `epsilon`.
    pub departure: Vec<Site<f64>>,
}

impl Start {
    /// That of the options.
    pub fn new(options: &TheoremOptions) -> Result<Self> {
        let &TheoremOptions { alpha, initial, .. } = options;
        let seed = options.seed();
        let breather = |center| Homoclinic::new(alpha, center).map(Some);
        let breather = match initial {
            Initial::Site => breather(Center::Site)?,
            Initial::Bond => breather(Center::Bond)?,
            Initial::Generic => None,
        };
        let needed = breather.as_ref().map_or(-GENERIC..=GENERIC, visible);
        let places = places(needed, options.sites)?;
        let mut random = uniform(seed);
        let mut draw = |n: i64| Complex64::new(random(), random()) * bell(n);
        let amplitudes = places.clone().map(|n| match &breather {
            Some(breather) => Complex64::from(breather.a(n)),
            None => draw(n),
        });
        Ok(Self {
            amplitudes: amplitudes.collect(),
            omega_0: breather.as_ref().map(Homoclinic::omega_0),
            // The departure has a seed of its own, so that it does not change A(0).
            departure: departure(places, seed ^ 0x5555_5555),
        })
    }

    /// Number of sites.
    pub fn sites(&self) -> usize {
        self.amplitudes.len()
    }

    /// The chain at one size, from its start to `T epsilon^{1-alpha}`.
    pub(super) fn run(&self, options: &TheoremOptions, epsilon: f64, tell: &dyn Fn(f64)) -> Result<TheoremRun> {
        let &TheoremOptions { alpha, horizon, rho_law, accuracy, .. } = options;
        let (rho, slowness) = (rho_law.rho(alpha, epsilon), epsilon.powf(alpha - 1.0));
        let end = horizon / slowness;
        let chain = Chain::new(Params::new(alpha, 1.0, rho)?, Boundary::Free, self.sites())?;
        let state = self.state(&chain, epsilon, options.c_i)?;
        let control = StepControl::Tolerance((accuracy * slowness).clamp(TOLERANCES.0, TOLERANCES.1));
        let mut run = chain.collocation(state.as_slice(), (0.0, end), control)?;
        let mut solution = self.solution(alpha, horizon)?;
        let (mut found, mut samples, mut before) = (Suprema::default(), 0, 0.0);
        let periods = options.sampling.periods(end, horizon);
        for (k, times) in periods.iter().enumerate() {
            for &t in times {
                found.see(&errors(chain.layout(), &state_at(&mut run, t)?, &solution.at(slowness * t)?, epsilon, t));
                tell(t - before);
                before = t;
            }
            samples += times.len();
            found.close(k + 1 == periods.len());
        }
        let [suprema, sampling_errors] = found.finish();
        Ok(TheoremRun { samples, windows: run.stats().steps, suprema, sampling_errors, ..TheoremRun::default() })
    }

    /// `u = 2 epsilon Re A(0)`, `u' = -2 epsilon Im A(0)`, `v = v' = 0`, and the departure.
    pub fn state(&self, chain: &Chain<f64>, epsilon: f64, c_i: f64) -> Result<State<f64>> {
        let alpha = chain.params().alpha;
        let [first, second] = [alpha, 2.0 * alpha - 1.0].map(|power| c_i * epsilon.powf(power));
        State::from_fn(chain, |n| {
            let (a, off) = (2.0 * epsilon * self.amplitudes[n], self.departure[n]);
            Site {
                u: a.re + first * off.u,
                u_dot: -a.im + first * off.u_dot,
                v: first * off.v,
                v_dot: second * off.v_dot,
            }
        })
    }

    /// The solution of the DpS equation up to a slow time.
    pub fn solution(&self, alpha: f64, horizon: f64) -> Result<Solution> {
        if let Some(omega_0) = self.omega_0 {
            return Ok(Solution::Breather { a: self.amplitudes.clone(), omega_0 });
        }
        let layout = Layout { sites: self.sites(), ends: Ends::Free, form: Form::Displacements };
        let z: Vec<f64> = self.amplitudes.iter().map(|a| a.re).chain(self.amplitudes.iter().map(|a| a.im)).collect();
        let options = Options::new(FLOW_TOLERANCE);
        Ok(Solution::Flow(Box::new(Dop853::new(Dps::plain(alpha, 1.0, layout)?, &z, (0.0, horizon), options)?)))
    }
}

/// `A(tau)`, asked for at times that do not decrease.
pub enum Solution {
    Breather { a: Vec<Complex64>, omega_0: f64 },
    Flow(Box<Dop853<f64, Dps>>),
}

impl Solution {
    pub fn at(&mut self, tau: f64) -> Result<Vec<Complex64>> {
        Ok(match self {
            Self::Breather { a, omega_0 } => {
                let turn = Complex64::from_polar(1.0, *omega_0 * tau);
                a.iter().map(|a| a * turn).collect()
            }
            Self::Flow(run) => {
                let z = state_at(run.as_mut(), tau)?;
                let (re, im) = z.split_at(z.len() / 2);
                re.iter().zip(im).map(|(re, im)| Complex64::new(*re, *im)).collect()
            }
        })
    }
}

fn bell(n: i64) -> f64 {
    (-0.25 * (n * n) as f64).exp()
}

/// The sites where a breather is not below [`TAIL`] of its largest value.
fn visible(breather: &Homoclinic) -> std::ops::RangeInclusive<i64> {
    let largest = breather.a(0).abs();
    let seen = |n: &i64| breather.a(*n).abs() >= TAIL * largest;
    let (first, last) = (breather.sites().find(seen), breather.sites().rev().find(seen));
    first.unwrap_or(0)..=last.unwrap_or(0)
}

/// The sites of the chain: those needed, and on both sides as many more as were asked for.
fn places(needed: std::ops::RangeInclusive<i64>, sites: Option<usize>) -> Result<std::ops::RangeInclusive<i64>> {
    let (first, last) = needed.into_inner();
    let least = (last - first + 1) as usize;
    let sites = sites.unwrap_or(least);
    require(sites <= MOST_SITES, "sites", sites, "at most 1000 sites")?;
    let rule = "the chain holds the profile: as many sites as it takes without --sites, or more";
    require(sites >= least, "sites", sites, rule)?;
    let first = first - ((sites - least) / 2) as i64;
    Ok(first..=first + sites as i64 - 1)
}

/// A departure with `sum |u_n| + |u'_n| = sum |v_n| = sum |v'_n| = 1`: random numbers times a bell.
fn departure(places: std::ops::RangeInclusive<i64>, seed: u64) -> Vec<Site<f64>> {
    let mut random = uniform(seed);
    let mut next = |n| bell(n) * random();
    let drawn: Vec<Site<f64>> =
        places.map(|n| Site { u: next(n), u_dot: next(n), v: next(n), v_dot: next(n) }).collect();
    let sum = |of: fn(&Site<f64>) -> f64| drawn.iter().map(of).sum::<f64>();
    let (u, v, v_dot) =
        (sum(|site| site.u.abs() + site.u_dot.abs()), sum(|site| site.v.abs()), sum(|site| site.v_dot.abs()));
    let scaled =
        |site: &Site<f64>| Site { u: site.u / u, u_dot: site.u_dot / u, v: site.v / v, v_dot: site.v_dot / v_dot };
    drawn.iter().map(scaled).collect()
}
