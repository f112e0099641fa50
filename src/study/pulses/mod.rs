//! Pulses in plain chains whose beads differ, without precompression.
//!
//! | study | chain | what is measured |
//! |---|---|---|
//! | [`dimer`] | heavy and light beads in turn | how much of a pulse passes, over the mass ratio |
//! | [`impurity`] | one bead of another mass | energy that passes, is thrown back and stays |
//! | [`taper`] | radii in a geometric sequence | growth of the pulse from bead to bead |
//! | [`disorder`] | masses drawn at random | decay of the energy of the pulse with distance |
//!
//! Except for the dimer, whose pulse is another, all begin with the solitary wave of the plain
//! chain, of speed 1, in [`LEAD`] beads of mass 1 with contacts of constant 1.

mod dimer;
mod disorder;
mod impurity;
mod taper;

pub use dimer::*;
pub use disorder::*;
pub use impurity::*;
pub use taper::*;

use crate::{
    chain::{Boundary, Chain, Details, Params, State},
    error::{Error, Result, require},
    interrupt,
    run::{Method, Run, Setting, state_at},
    waves::LinePulse,
};
use hertzchain_integrators::Stepper;
use std::sync::LazyLock;

/// Exponent of the contacts.
const ALPHA: f64 = 1.5;
/// Method and step. The step is in units of the time in which the solitary wave of speed 1 moves by
/// a bead.
const METHOD: &str = "aba864";
const STEP: f64 = 0.02;
/// Beads of mass 1 before the first that may differ.
const LEAD: usize = 16;
/// The bond where the solitary wave has its crest at the start. Eight bonds away an overlap is
/// below a rounding of the crest.
const CREST: usize = 8;
/// Bonds on either side of the crest of a pulse whose sites count as the pulse.
const HALF_PULSE: usize = 4;

/// The solitary wave of the plain chain.
static LINE: LazyLock<LinePulse> = LazyLock::new(|| LinePulse::new(ALPHA));

/// A plain chain with free ends; lists as in [`Details`].
fn plain(mass: Vec<f64>, contact: Vec<f64>) -> Result<Chain<f64>> {
    let sites = mass.len();
    let details = Details { mass, contact, ..Details::default() };
    Chain::new(Params::new(ALPHA, 0.0, 0.0)?, Boundary::Free, sites)?.with(&details)
}

/// The solitary wave of speed 1 with its crest at bond [`CREST`], the beads before it at rest.
fn solitary_wave(chain: &Chain<f64>) -> State<f64> {
    let mut state = State::rest(chain);
    // g_b = u_{b-1} - u_b = G(b - CREST - t).
    let (mut u, mut u_dot) = (0.0, 0.0);
    for bond in (1..=2 * CREST).rev() {
        let [g, slope] = LINE.at(bond as f64 - CREST as f64);
        u += g.max(0.0);
        u_dot -= slope;
        state.u_mut()[bond - 1] = u;
        state.u_dot_mut()[bond - 1] = u_dot;
    }
    state
}

/// Runs a chain and calls `look` with the time and the state after every step, until it returns
/// `true`.
///
/// # Errors
/// A run that fails; a signal; a run that reaches the time `end` before `look` returns `true`.
fn follow(
    chain: &Chain<f64>,
    state: State<f64>,
    (step, end): (f64, f64),
    look: &mut dyn FnMut(f64, &[f64]) -> bool,
) -> Result<()> {
    let run = Run::new(chain.clone(), state).until(end)?.method(Method::named(METHOD)?);
    let mut stepper = run.setting(Setting::steps(end / step)?).stepper()?;
    while !stepper.done() {
        if interrupt::asked() {
            return Err(Error::Stopped { kept: "nothing of this study".to_owned() });
        }
        stepper.step()?;
        let t = stepper.time();
        if look(t, &state_at(&mut *stepper, t)?) {
            return Ok(());
        }
    }
    let why = format!("the pulse has not passed at t = {end}");
    Err(Error::Point { point: "a pulse".to_owned(), why })
}

/// The crest of a pulse at each of some places: the largest maximum of a quantity before it first
/// falls below half of that, from values at equal times.
struct Crests {
    /// The last three values.
    recent: Vec<[f64; 3]>,
    /// The vertex of the parabola through the three values at the largest maximum; 0 before it.
    crest: Vec<f64>,
    passed: Vec<bool>,
}

impl Crests {
    fn new(places: usize) -> Self {
        Self { recent: vec![[0.0; 3]; places], crest: vec![0.0; places], passed: vec![false; places] }
    }

    /// Takes the next values, one a place; `higher` is called with each place that has a new crest.
    fn look(&mut self, values: impl IntoIterator<Item = f64>, mut higher: impl FnMut(usize)) {
        for (k, value) in values.into_iter().enumerate() {
            if self.passed[k] {
                continue;
            }
            let [_, a, b] = self.recent[k];
            self.recent[k] = [a, b, value];
            if b >= a && b > value && b > 0.0 {
                let (slope, bend) = (0.5 * (value - a), a - 2.0 * b + value);
                let crest = b - 0.5 * slope * slope / bend;
                if crest > self.crest[k] {
                    self.crest[k] = crest;
                    higher(k);
                }
            }
            self.passed[k] = self.crest[k] > 0.0 && value < 0.5 * self.crest[k];
        }
    }

    fn all_passed(&self) -> bool {
        self.passed.iter().all(|&passed| passed)
    }
}

/// The energy of the sites about a bond: that of a pulse with its crest there.
fn pulse_energy(chain: &Chain<f64>, y: &[f64], bond: usize) -> f64 {
    let energies = chain.site_energies(y);
    energies[bond.saturating_sub(HALF_PULSE)..(bond + HALF_PULSE).min(energies.len())].iter().sum()
}

/// Refuses a range that is empty.
fn ascending(from: f64, to: f64) -> Result<()> {
    require(from < to, "from", from, "below the largest value, --to")
}

/// Values from `from` to `to`, both included, evenly spaced in their logarithm.
fn geometric(from: f64, to: f64, points: usize) -> Vec<f64> {
    let inner = (0..points - 1).map(|k| from * (to / from).powf(k as f64 / (points - 1) as f64));
    inner.chain([to]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solitary_wave_passes_uniform_beads_unchanged() {
        // Truth: its speed and its shape; the step errs by less.
        let chain = plain(vec![1.0; 40], Vec::new()).unwrap();
        let start = solitary_wave(&chain);
        let energy = pulse_energy(&chain, start.as_slice(), CREST);
        let mut crests = Crests::new(24);
        let mut energies = [0.0; 24];
        let mut times = [0.0; 24];
        follow(&chain, start, (STEP, 40.0), &mut |t, y| {
            let overlaps = chain.overlaps(chain.layout().u(y));
            crests.look(overlaps[CREST + 1..CREST + 25].iter().copied(), |k| {
                energies[k] = pulse_energy(&chain, y, CREST + 1 + k);
                times[k] = t;
            });
            crests.all_passed()
        })
        .unwrap();
        for k in 0..24 {
            assert!((crests.crest[k] / LINE.at(0.0)[0] - 1.0).abs() < 1e-6, "{k}: {}", crests.crest[k]);
            assert!((energies[k] / energy - 1.0).abs() < 1e-5, "{k}: {}", energies[k] / energy);
            // Seen a step late at most.
            assert!((times[k] - (k + 1) as f64).abs() < 2.0 * STEP, "{k}: {}", times[k]);
        }
    }

    #[test]
    fn a_crest_is_the_vertex_of_the_largest_maximum_before_the_half() {
        let mut crests = Crests::new(1);
        // Maxima of 0.9 (vertex 0.98) and 2 (vertex 2 + 0.025^2/4.5), then less than half of it.
        let mut seen = 0;
        [0.0, 0.9, 0.8, 0.85, 2.0, 0.9, 9.0, 0.0].iter().for_each(|&value| crests.look([value], |_| seen += 1));
        assert!((crests.crest[0] - 2.0 - 0.025_f64.powi(2) / 4.5).abs() < 1e-12 && seen == 2, "{}", crests.crest[0]);
    }
}
