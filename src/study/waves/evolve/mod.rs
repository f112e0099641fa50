//! The evolution of an orbit over many periods: its return error, and the position of its kink
//! (Sec. 7).
//!
//! | symbol | meaning |
//! |---|---|
//! | `E_b(m T)` | `max |Z(m T) - Z(0)| / max |Z(0)|` (eq:relerr) |
//! | `r_n` | mean of `(x_n^2 + (x_n'/omega_b)^2)^{1/2}` at `t = m T` and half a period before (after, for `m = 0`): about the amplitude of bond `n`, in any phase, also where strains of both phases differ |
//! | `w_n` | `max(0, 1 - r_n / K_x)^4`: what is missing from the background; ripples of it count for little |
//! | position | of the kink: the angle of `sum w_n e^{2 pi i n/L}` on the ring of `L` sites, in sites, followed continuously |

mod report;

use crate::study::{Progress, Study, Work, fit_line, options::options};
use crate::{
    breathers::centre,
    chain::max_norm,
    error::{Error, Result, require},
    orbits::{Orbit, Pick, Shooting, Spectrum},
    report::Report,
    run::state_at,
};
use hertzchain_integrators::collocation::StepControl;
use nalgebra::Complex;
use std::path::PathBuf;

/// A push along an eigenvector of the monodromy matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kick {
    /// Largest change of an entry of `(Z, Z')`, in units of `max |Z(0)|`; of either sign.
    pub size: f64,
    /// Which multiplier, counted from 0 in the order of the spectrum: the largest modulus first.
    pub mode: usize,
}

options! {
    /// An orbit that is let go, from a file.
    pub struct Evolve {
        /// File dark-breather.npz or branch.npz, with the orbit to start from.
        ///
        /// dark-breather.npz is written by `breather dark`; branch.npz by `breather continue` and
        /// `breather doubled`, and needs --point or --at.
        orbit: PathBuf = PathBuf::new();
        /// Number of the point of the branch, from 0; -1 is the last one.
        point: Option<i64> = None, "K", [conflicts_with = "at"];
        /// Take the point of the branch whose parameter is nearest to this value.
        at: Option<f64> = None, "P", (finite);
        /// End time, in units of time.
        ///
        /// Rounded down to whole periods of the orbit. From one period to 10^6 of them.
        until: f64 = 1200.0, "T";
        /// Size of a kick along one mode, in units of the orbit's amplitude [default: none].
        ///
        /// The largest change of an entry of the initial state; of either sign, not zero, at most
        /// 1 in modulus.
        kick: Option<f64> = None, "SIZE";
        /// Number of the multiplier along whose eigenvector the chain is kicked.
        ///
        /// Counted from 0 in the order of `breather dark --json`: the largest modulus first.
        mode: usize = 0, "K", [requires = "kick"];
        /// Tolerance.
        tol: f64 = 1e-13, "T", (RUN), [long_help = crate::study::OF_WINDOWS];
    }
}

impl Study for Evolve {
    const FILES: &'static str =
        "evolution-x.csv and evolution-y.csv have the largest strains in time, a column a site.";
    const INTERRUPTIBLE: bool = true;

    fn outline() -> Option<Report> {
        Some(report::outline())
    }

    fn begin(&self) -> Result<Work<'_>> {
        self.within_ranges()?;
        let shooting = Shooting { tol: self.tol, ..Shooting::default() };
        let pick = self.point.map(Pick::Point).or(self.at.map(Pick::At));
        let orbit = Orbit::load(&self.orbit, pick)?;
        let kick = self.kick.map(|size| Kick { size, mode: self.mode });
        Ok(Box::new(move |_, progress| Ok(evolve(&orbit, self.until, kick, &shooting, progress)?.report())))
    }
}

/// A straight line through positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// The times it was fitted over.
    pub window: (f64, f64),
    /// Sites per unit of time.
    pub velocity: f64,
    /// Largest distance of a position from the line, in sites.
    pub misfit: f64,
}

/// The run of an orbit, and what was measured on the way.
#[derive(Clone, Debug)]
pub struct Evolution {
    /// The orbit that the run started from, without the kick.
    pub orbit: Orbit,
    /// The kick, and the multiplier it is along.
    pub kick: Option<(Kick, Complex<f64>)>,
    /// Tolerance of the run.
    pub tol: f64,
    /// Times `m T`, from 0.
    pub times: Vec<f64>,
    /// `E_b` at these times.
    pub e_b: Vec<f64>,
    /// Position of the kink at these times, in sites `n`.
    pub position: Vec<f64>,
    /// Straight lines fitted to the second, third and fourth quarter of the run: equal velocities
    /// mean no acceleration.
    pub motion: Vec<Motion>,
    /// `|lambda|^m` of the largest multiplier over the whole run: the factor by which roundings
    /// grow, as long as they are small.
    pub amplification: f64,
    /// Largest strains in time.
    pub swing: Swing,
    /// The state `(Z, Z')` at the last of the times.
    pub end: Vec<f64>,
    /// Why the run ended early; `None` if it did not.
    pub failure: Option<String>,
}

/// Largest strains over space and time, for pictures. Each row covers the same number of periods.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Swing {
    /// Time that a row covers; the first one begins at 0.
    pub span: f64,
    /// Largest `|x_n - C_x|` of 16 samples a period, a row after the other.
    pub x: Vec<f64>,
    /// Largest `|y_n - C_x|`; empty without resonators.
    pub y: Vec<f64>,
}

const MOST_PERIODS: f64 = 1e6;
/// Samples a period for the largest strains; a power of two, so that whole periods are among the
/// samples to the bit.
const SAMPLES: u64 = 16;
/// Rows of largest strains at most.
const MOST_ROWS: u64 = 600;

/// Lets an orbit go, for a time `until` rounded down to whole periods.
///
/// # Errors
/// `until` not in `[T, 10^6 T]`; a kick of size zero, not finite or above 1, or along a multiplier
/// that is not there; multipliers that cannot be computed. A run that fails is no error: what was
/// measured so far is returned with the failure.
pub fn evolve(
    orbit: &Orbit,
    until: f64,
    kick: Option<Kick>,
    shooting: &Shooting,
    progress: Progress<'_>,
) -> Result<Evolution> {
    let period = orbit.setting.period();
    let periods = (until / period * (1.0 + 1e-12)).floor();
    require((1.0..=MOST_PERIODS).contains(&periods), "until", until, "from one period of the orbit to 10^6")?;
    let spectrum = orbit.spectrum(shooting)?;
    let mut start = orbit.start();
    let kick = kick.map(|kick| pushed(&mut start, kick, orbit, &spectrum).map(|lambda| (kick, lambda))).transpose()?;
    let chain = orbit.setting.chain()?;
    let mut run = chain.collocation(&start, (0.0, periods * period), StepControl::Tolerance(shooting.tol))?;
    let crate::orbits::Setting { c_x, omega_b, sites, .. } = orbit.setting;
    let (background, middle) = ((orbit.x()[0] - c_x).abs(), (sites / 2) as f64);
    let mut out = Evolution {
        amplification: spectrum.largest().powf(periods),
        kick,
        tol: shooting.tol,
        times: vec![],
        e_b: vec![],
        position: vec![],
        motion: vec![],
        swing: Swing::default(),
        end: vec![],
        failure: None,
        orbit: orbit.clone(),
    };
    let (mut state, mut before) = (start.clone(), Vec::new());
    let a_row = (periods as u64).div_ceil(MOST_ROWS);
    out.swing.span = a_row as f64 * period;
    for k in 0..=periods as u64 * SAMPLES {
        let (t, m) = (k as f64 * period / SAMPLES as f64, k / SAMPLES);
        state = match state_at(&mut run, t) {
            Ok(state) => state,
            Err(why) => {
                out.failure = Some(why.to_string());
                break;
            }
        };
        // The sample at the end of a row belongs to it, not to the next one.
        out.swing.add(&state[..orbit.z.len()], orbit, (k.saturating_sub(1) / (a_row * SAMPLES)) as usize);
        if k % (SAMPLES / 2) > 0 {
            continue;
        }
        let (x, x_dot) = (&state[..], &state[orbit.z.len()..]);
        let now: Vec<f64> = (0..sites).map(|n| (x[n] - c_x).hypot(x_dot[n] / omega_b) / background).collect();
        let pair = std::mem::replace(&mut before, now.clone());
        let amplitudes: Vec<f64> = now.iter().zip(&pair).map(|(a, b)| 0.5 * (a + b)).collect();
        let near = out.position.last().copied().unwrap_or(0.0);
        let position = centre(if k == 0 { &now } else { &amplitudes }, 1.0, near + middle) - middle;
        if k == SAMPLES / 2 {
            out.position[0] = position;
        }
        if k % SAMPLES > 0 {
            continue;
        }
        out.times.push(t);
        out.e_b.push(max_norm(orbit.z.iter().zip(&state).map(|(a, b)| a - b)) / orbit.amplitude());
        out.position.push(position);
        progress(m as f64 / periods, "evolution");
    }
    out.motion = motion(&out.times, &out.position);
    out.end = state;
    Ok(out)
}

impl Swing {
    fn add(&mut self, z: &[f64], Orbit { setting, .. }: &Orbit, row: usize) {
        let (x, y) = z.split_at(setting.sites);
        for (rows, strains) in [(&mut self.x, x), (&mut self.y, y)] {
            rows.resize((row + 1) * strains.len(), 0.0);
            let largest = rows[row * strains.len()..].iter_mut();
            largest.zip(strains).for_each(|(most, strain)| *most = most.max((strain - setting.c_x).abs()));
        }
    }
}

/// Adds the kick to a state, and returns the multiplier whose eigenvector it is along.
fn pushed(start: &mut [f64], kick: Kick, orbit: &Orbit, spectrum: &Spectrum) -> Result<Complex<f64>> {
    let Kick { size, mode } = kick;
    let rule = "a share of the amplitude, not zero and at most 1";
    require(size.is_finite() && size != 0.0 && size.abs() <= 1.0, "kick", size, rule)?;
    let Some(one) = spectrum.multipliers.get(mode) else {
        return Err(Error::parameter(
            "mode",
            mode,
            "the number of a multiplier, counted from 0, the largest modulus first",
        ));
    };
    let by = size * orbit.amplitude();
    start.iter_mut().zip(spectrum.direction(mode)).for_each(|(start, direction)| *start += by * direction);
    Ok(Complex::new(one.re, one.im))
}

/// Lines fitted to the positions in the second, third and fourth quarter.
fn motion(times: &[f64], position: &[f64]) -> Vec<Motion> {
    let quarter = times.len() / 4;
    let window = |k: usize| {
        let points: Vec<(f64, f64)> = (k * quarter..(k + 1) * quarter).map(|i| (times[i], position[i])).collect();
        let (velocity, misfit) = fit_line(&points)?;
        Some(Motion { window: (points[0].0, points[points.len() - 1].0), velocity, misfit })
    };
    (1..4).filter_map(window).collect()
}
