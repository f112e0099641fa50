//! The initial state of a scene, kind by kind.

use super::{
    Theory,
    file::{Initial, TrivialSection},
};
use crate::{
    breathers::{BrightBreather, TrivialBreather},
    chain::{Boundary, Chain, DriveKind, Site, State, max_norm},
    dps::Center,
    error::{Error, NOTHING, Result, finite, positive, refuse, require},
    orbits::{Bands, NormalModes},
    waves::{PerturbedWave, Shape, Size, TravellingWave},
};
use std::f64::consts::PI;

/// Least size of the contact forces of a state. Forces below about 1e-250 count as zero; this is
/// far above.
const LEAST_FORCE: f64 = 1e-200;
/// Least energy of a motion.
const LEAST_ENERGY: f64 = 1e-280;
/// Largest energy of a state; beyond it intermediate results would overflow.
const MOST_ENERGY: f64 = 1e300;

const DEFAULT_SEED: u64 = 1;
const NOTHING_DRAWN: &str = "a seed needs a perturbation: give zeta above 0";
const REST: Site<f64> = Site { u: 0.0, v: 0.0, u_dot: 0.0, v_dot: 0.0 };

/// The initial state of a scene, and the theory that it follows.
pub(super) fn initial_state(
    chain: &Chain<f64>,
    initial: &Initial,
    start: Option<f64>,
) -> Result<(State<f64>, Option<Theory>)> {
    match *initial {
        Initial::TravellingWave { q_over_pi, a, b, phi, epsilon, detuning, zeta, seed } => {
            chain.uniform("a travelling wave")?;
            let rule = "a travelling wave lives on a strain-ring";
            require(chain.boundary() == Boundary::StrainRing, "boundary", chain.boundary(), rule)?;
            on_the_ring(chain, q_over_pi, 0.0)?;
            let shape = Shape { q: q_over_pi * PI, a, b, phi };
            let wave = TravellingWave::new(chain.params(), shape, size(epsilon, detuning)?)?;
            travelling_wave(chain, wave, zeta.unwrap_or(0.0), seed)
        }
        Initial::SingleBead { site, displacement, velocity } => {
            let bead = Site { u: displacement, u_dot: velocity, ..REST };
            Ok((single_bead(chain, site, bead)?, None))
        }
        Initial::NormalMode { mode, amplitude } => Ok((normal_mode(chain, mode, amplitude)?, None)),
        Initial::TrivialBreather(ref section) => {
            chain.uniform("a trivial breather")?;
            let breather = trivial_breather(chain, section)?;
            Ok((State::from_fn(chain, |i| breather.site(i, 0.0))?, Some(Theory::Breather(breather))))
        }
        Initial::BrightBreather { center, epsilon } => {
            let breather = bright_breather(chain, center, epsilon)?;
            Ok((by_sites(chain, |i| breather.site(i, 0.0))?, Some(Theory::Bright(breather))))
        }
        Initial::Envelope { q_over_pi, band, amplitude, center } => {
            Ok((envelope(chain, [q_over_pi, amplitude], band, center)?, None))
        }
        Initial::Equilibrium { site, displacement, velocity } => {
            let mut state = equilibrium(chain)?;
            let Some(site) = site else {
                let rule = "`displacement` and `velocity` belong to a `site`";
                require(displacement.is_none() && velocity.is_none(), "initial.site", NOTHING, rule)?;
                return Ok((state, None));
            };
            require(site < chain.sites(), "site", site, "a site of the chain, counted from 0")?;
            state.u_mut()[site] += finite("displacement", displacement.unwrap_or(0.0))?;
            state.u_dot_mut()[site] += finite("velocity", velocity.unwrap_or(0.0))?;
            Ok((driven(chain, state, 0.0)?, None))
        }
        Initial::State { ref u, ref v, ref u_dot, ref v_dot } => {
            let state = driven(chain, given(chain, [u, v, u_dot, v_dot])?, start.unwrap_or(0.0))?;
            // An exact solution begins at time 0.
            let exact = match chain.details() {
                None if start.is_none() => TrivialBreather::of_state(chain, state.as_slice()).map(Theory::Breather),
                _ => None,
            };
            Ok((state, exact))
        }
    }
}

/// The state of a chain from those of its sites, in which drives move their beads.
fn by_sites(chain: &Chain<f64>, site: impl Fn(usize) -> Site<f64>) -> Result<State<f64>> {
    let state = State::from_fn(chain, site)?;
    if chain.details().is_none() { Ok(state) } else { driven(chain, state, 0.0) }
}

/// The state at a time in which beads that drives move are where their drives are.
///
/// # Errors
/// A number other than zero for such a bead that is not that of its drive.
fn driven(chain: &Chain<f64>, state: State<f64>, start: f64) -> Result<State<f64>> {
    let own = state.clone().driven_at(chain, start);
    let mut filled = state.clone();
    filled.as_mut_slice().iter_mut().zip(own.as_slice()).filter(|(y, _)| **y == 0.0).for_each(|(y, own)| *y = *own);
    match chain.follows_drives(filled.as_slice(), start) {
        Ok(()) => Ok(own),
        Err(site) => {
            let [given, drive] = [&state, &own].map(|state| {
                format!("position = {:e}, velocity = {:e}", state.u()[site] + 0.0, state.u_dot()[site] + 0.0)
            });
            let rule = "a bead that is moved begins as its drive does: leave its numbers 0, or give those of the drive";
            Err(Error::parameter("initial", format!("{given} at site {site}, whose drive begins at {drive}"), rule))
        }
    }
}

/// Refuses a wave number outside [-pi, pi], and one with which no whole number of waves, but for
/// `share` of one, fits the ring.
fn on_the_ring(chain: &Chain<f64>, q_over_pi: f64, share: f64) -> Result<()> {
    let rule = "the wave number is from -pi to pi: a lattice knows no other";
    require((-1.0..=1.0).contains(&q_over_pi), "q_over_pi", q_over_pi, rule)?;
    let waves = 0.5 * q_over_pi * chain.sites() as f64 - share;
    if (waves - waves.round()).abs() > 1e-9 * waves.abs().max(1.0) {
        let rule = match share {
            0.0 => "a whole number of waves fits the ring: q sites / (2 pi) is an integer",
            _ => "a dark envelope turns the phase: a whole number of waves and a half fits the ring",
        };
        return Err(Error::parameter("q_over_pi", q_over_pi, rule));
    }
    Ok(())
}

/// A bright or dark envelope on a loaded chain; on a ring its ends meet opposite the centre.
fn envelope(
    chain: &Chain<f64>,
    [q_over_pi, amplitude]: [f64; 2],
    band: usize,
    center: Option<f64>,
) -> Result<State<f64>> {
    let rule = "an envelope is a state of displacements: any other boundary";
    require(chain.boundary() != Boundary::StrainRing, "boundary", "strain-ring", rule)?;
    let rule = "above 0 and at most 1";
    require(q_over_pi > 0.0 && q_over_pi <= 1.0, "q_over_pi", q_over_pi, rule)?;
    let Some((_, all)) = Bands::new(chain).ok().and_then(|bands| bands.envelopes(PI * q_over_pi)) else {
        let rule = "an envelope lives on equal beads that only resonators and contacts under a static load hold: a \
                    precompression, no gravity, no springs of beads";
        return Err(Error::parameter("initial.kind", "envelope", rule));
    };
    let rule = "a band of the chain, the lowest is 1: two with moving resonators, else one";
    require((1..=all.len()).contains(&band), "band", band, rule)?;
    let wave = all[band - 1];
    let soliton = wave.soliton(amplitude)?;
    let (sites, ring) = (chain.sites() as f64, chain.topology().ring());
    let rule = "the envelope is from one site to the length of the chain wide";
    require((1.0..=sites).contains(&soliton.width()), "amplitude", amplitude, rule)?;
    if ring {
        on_the_ring(chain, q_over_pi, if wave.focusing() { 0.0 } else { 0.5 })?;
    }
    let center = center.unwrap_or(0.5 * (sites - 1.0));
    require((0.0..=sites - 1.0).contains(&center), "center", center, "a place in the chain, its sites counted from 0")?;
    by_sites(chain, |i| {
        let n = i as f64 - center;
        soliton.site(if ring { n - sites * (n / sites).round() } else { n }, 0.0)
    })
}

fn size(epsilon: Option<f64>, detuning: Option<f64>) -> Result<Size> {
    match (epsilon, detuning) {
        (Some(epsilon), None) => Ok(Size::Epsilon(epsilon)),
        (None, Some(detuning)) => Ok(Size::Detuning(detuning)),
        _ => Err(Error::parameter("initial", "[initial]", "give exactly one of `epsilon` and `detuning`")),
    }
}

/// The wave, perturbed by `zeta`.
fn travelling_wave(
    chain: &Chain<f64>,
    wave: TravellingWave,
    zeta: f64,
    seed: Option<u64>,
) -> Result<(State<f64>, Option<Theory>)> {
    if zeta == 0.0 && zeta.is_sign_positive() {
        return match seed {
            Some(seed) => Err(Error::parameter("seed", seed, NOTHING_DRAWN)),
            None => Ok((by_sites(chain, |i| wave.site(i, 0.0))?, Some(Theory::Wave(wave)))),
        };
    }
    let rule = "the share of a perturbation is from 0 (none) to below 1";
    require(zeta > 0.0 && zeta < 1.0, "zeta", zeta, rule)?;
    let perturbed = PerturbedWave::new(wave, chain.sites(), zeta, seed.unwrap_or(DEFAULT_SEED))?;
    let sites = perturbed.initial(perturbed.constraint())?;
    Ok((State::from_fn(chain, |i| sites[i])?, Some(Theory::PerturbedWave(perturbed))))
}

fn single_bead(chain: &Chain<f64>, site: usize, bead: Site<f64>) -> Result<State<f64>> {
    require(site < chain.sites(), "site", site, "a site of the chain, counted from 0")?;
    finite("displacement", bead.u)?;
    finite("velocity", bead.u_dot)?;
    by_sites(chain, |i| if i == site { bead } else { REST })
}

/// A sine mode of a chain between walls, the same for beads and resonators, at rest.
fn normal_mode(chain: &Chain<f64>, mode: u32, amplitude: f64) -> Result<State<f64>> {
    let n = chain.sites();
    require((1..=n).contains(&(mode as usize)), "mode", mode, "from 1 to the number of sites")?;
    finite("amplitude", amplitude)?;
    let shape = |i: usize| amplitude * (PI * f64::from(mode) * (i + 1) as f64 / (n + 1) as f64).sin();
    by_sites(chain, |i| Site { u: shape(i), v: shape(i), ..REST })
}

/// The state at rest under all loads.
fn equilibrium(chain: &Chain<f64>) -> Result<State<f64>> {
    if !chain.tied() {
        return State::equilibrium(chain);
    }
    let (modes, mut state) = (NormalModes::held(chain, &[])?, State::rest(chain));
    let coordinates = 2 * chain.layout().half();
    state.as_mut_slice()[..coordinates].copy_from_slice(&modes.rest()[..coordinates]);
    Ok(state)
}

fn bright_breather(chain: &Chain<f64>, center: Center, epsilon: f64) -> Result<BrightBreather> {
    chain.uniform("a bright breather")?;
    let rule = "a bright breather is a state of displacements: any other boundary";
    require(chain.boundary() != Boundary::StrainRing, "boundary", "strain-ring", rule)?;
    let rule = "a bright breather lives on a chain without precompression";
    require(chain.precompression() <= 0.0, "precompression", chain.precompression(), rule)?;
    BrightBreather::new(chain.params(), center, epsilon, chain.sites())
}

/// The state of four arrays; one that is empty is zero.
fn given(chain: &Chain<f64>, arrays: [&[f64]; 4]) -> Result<State<f64>> {
    let n = chain.sites();
    for (name, array) in ["u", "v", "u_dot", "v_dot"].into_iter().zip(arrays) {
        let rule = "an array of the state has one number a site, or is left out";
        require([0, n].contains(&array.len()), name, numbers_for(array, n), rule)?;
        array.iter().try_for_each(|&value| finite(name, value).map(drop))?;
    }
    let [u, v, u_dot, v_dot] = arrays;
    let (count, rule) = (v.len().max(v_dot.len()), "no resonator moves in this chain: leave `v` and `v_dot` out");
    require(count == 0 || chain.layout().resonators(), "v", format!("{count} numbers"), rule)?;
    for (name, array) in [("v", v), ("v_dot", v_dot)] {
        let still = (0..array.len()).find(|&i| array[i] != 0.0 && !chain.resonator_moves(i));
        let rule = "no resonator moves at this site: its `v` and `v_dot` are 0";
        refuse(name, still.map(|site| format!("{} at site {site}", array[site])), rule)?;
    }
    let at = |array: &[f64], i: usize| array.get(i).copied().unwrap_or(0.0);
    State::from_fn(chain, |i| Site { u: at(u, i), v: at(v, i), u_dot: at(u_dot, i), v_dot: at(v_dot, i) })
}

fn trivial_breather(chain: &Chain<f64>, section: &TrivialSection) -> Result<TrivialBreather> {
    let rule = "a trivial breather has free ends";
    require(chain.boundary() == Boundary::Free, "boundary", chain.boundary(), rule)?;
    let (params, n) = (chain.params(), chain.sites());
    let (amplitudes, phases) = (amplitudes(n, section)?, phases(n, section)?);
    match (&section.b, &section.d, section.gap) {
        (Some(b), None, None) => TrivialBreather::with_means(params, amplitudes, phases, b.clone()),
        (None, Some(d), None) => TrivialBreather::new(params, amplitudes, phases, d),
        (None, None, gap) => {
            let gap = gap.unwrap_or(0.0);
            require(gap.is_finite() && gap >= 0.0 && gap.is_sign_positive(), "gap", gap, "finite and at least zero")?;
            let even: Vec<f64> = (0..amplitudes.len()).map(|n| gap * n as f64).collect();
            Ok(TrivialBreather::new(params, amplitudes, phases, &even)?.centred())
        }
        _ => Err(Error::parameter("initial", "[initial]", "give at most one of `b`, `d` and `gap`")),
    }
}

fn amplitudes(sites: usize, section: &TrivialSection) -> Result<Vec<f64>> {
    match (&section.amplitudes, section.center, section.amplitude, section.decay) {
        (Some(amplitudes), None, None, None) => site_by_site("amplitudes", amplitudes, sites),
        (None, Some(center), Some(amplitude), Some(decay)) => {
            let decay = positive("decay", decay)?;
            finite("center", center)?;
            finite("amplitude", amplitude)?;
            Ok((0..sites).map(|i| amplitude * (-(i as f64 - center).abs() / decay).exp()).collect())
        }
        _ => Err(Error::parameter("initial", "[initial]", "give `amplitudes`, or `center`, `amplitude` and `decay`")),
    }
}

fn phases(sites: usize, section: &TrivialSection) -> Result<Vec<f64>> {
    match (&section.phases, section.phase_step_over_pi) {
        (Some(phases), None) => site_by_site("phases", phases, sites),
        (None, step) => {
            let step = finite("phase_step_over_pi", step.unwrap_or(1.0))?;
            // Phases are needed up to whole turns only.
            Ok((0..sites).map(|i| PI * (i as f64 * step % 2.0)).collect())
        }
        _ => Err(Error::parameter("initial", "[initial]", "give at most one of `phases` and `phase_step_over_pi`")),
    }
}

fn site_by_site(name: &'static str, values: &[f64], sites: usize) -> Result<Vec<f64>> {
    require(values.len() == sites, name, numbers_for(values, sites), "one number a site")?;
    Ok(values.to_vec())
}

/// How many numbers there are for how many sites.
fn numbers_for(values: &[f64], sites: usize) -> String {
    format!("{} numbers for {sites} sites", values.len())
}

/// Refuses a scene whose contact forces or energy would underflow, or whose energy would overflow.
pub(super) fn within_range(chain: &Chain<f64>, state: &[f64], initial: &Initial) -> Result<()> {
    let (law, alpha, half) = (chain.law(), chain.params().alpha, chain.layout().half());
    let [far, fast] = [&state[..half], &state[half..2 * half]].map(|part| max_norm(part.iter().copied()));
    let details = chain.details();
    let drives = details.into_iter().flat_map(|details| &details.drives);
    let moved =
        drives.filter(|one| one.kind == DriveKind::Displacement).map(|one| one.signal.size()).fold(0.0, f64::max);
    let size = far.max(fast).max(moved);
    let names = match initial {
        Initial::SingleBead { .. } | Initial::Equilibrium { .. } => ["displacement", "velocity"],
        Initial::State { .. } => ["u", "u_dot"],
        _ => ["amplitude"; 2],
    };
    let name = if moved > 0.0 && moved >= far { "drive" } else { names[usize::from(fast > far)] };
    let rest = details.into_iter().flat_map(|details| details.overlap.iter().copied());
    let contact = details.map_or(1.0, |details| max_norm(details.contact.iter().copied()));
    let energy = if chain.has_energy(state) { chain.energy(state).total() } else { size * size };
    // What moves reaches overlaps g with contact g^(alpha + 1) of the order of its energy.
    let deepest = (energy.abs() / if contact > 0.0 { contact } else { 1.0 }).powf((alpha + 1.0).recip());
    let force = law.force(max_norm(rest.chain([far, moved, chain.precompression(), deepest])));
    let lost = force < LEAST_FORCE || fast > 0.0 && energy.abs() < LEAST_ENERGY;
    let rule = "underflow: contact forces, overlap^alpha, below 1e-200 and energies below 1e-280 are lost; scale it up";
    require(size == 0.0 || !lost, name, size, rule)?;
    let most = (size * size).max(law.force(far) * far).max(energy) * chain.sites() as f64;
    let rule = "overflow: u^2, u^(alpha + 1) and the energy, times the sites, are at most 1e300; scale the state down";
    require(most <= MOST_ENERGY, name, size, rule)
}
