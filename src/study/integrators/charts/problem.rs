//! The problem that is charted, a chain and a state, and its variants.

use crate::{
    chain::Boundary,
    error::{Result, require},
    run::{contact_frequency, overlap_scale},
    scene::{ChainSection, Initial, Quantity, Record, Scene, SceneFile, Span, Units},
    study::integrators::compare::has_energy,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The golden angle in radians: cosines of its multiples are displacements without a pattern.
const ANGLE: f64 = 2.399_963_229_728_653;
/// The longest span of a point, in periods of its fastest motion.
const MOST_PERIODS: f64 = 1e4;

/// What a variant changes; `None`: as in the problem.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Variant {
    /// Mass ratio.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rho: Option<f64>,
    /// Spring constant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kappa: Option<f64>,
    /// Exponent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alpha: Option<f64>,
    /// Amplitude `A`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude: Option<f64>,
    /// Number of beads.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sites: Option<usize>,
    /// Length of the run in contact periods.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub periods: Option<f64>,
}

/// A chain with a state.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Its name: that of the scene.
    pub name: String,
    /// The TOML of the scene, or `built-in`; it identifies the problem in a store.
    pub(super) source: String,
    /// The chain that variants start from.
    pub chain: ChainSection,
    /// `u, v, u', v'` at amplitude 1; `None`: the state of [`built_in`](Self::built_in), which fits
    /// every variant.
    state: Option<[Vec<f64>; 4]>,
    /// The amplitude that variants start from.
    pub amplitude: f64,
    /// The units of the scene, for messages.
    units: Option<Units>,
}

/// A variant ready to run.
#[derive(Clone, Debug)]
pub(super) struct Prepared {
    pub(super) scene: Scene,
    /// The units of messages.
    pub(super) units: Option<Units>,
    /// `Omega_c = sqrt(2 alpha (A + delta_0)^{alpha-1})`.
    pub(super) contact: f64,
    /// `max(omega, Omega_c)`.
    pub(super) fast: f64,
}

impl Default for Problem {
    fn default() -> Self {
        Self::built_in()
    }
}

impl Problem {
    /// Four spheres between walls, `kappa = 1`, `rho = 1/3`, beads displaced by up to `A = 1`
    /// without a pattern. Resonators are so far from their beads that springs hold as much energy
    /// as contacts, so that the energy error shows errors of both. With soft springs they are as
    /// far from them as beads are displaced.
    pub fn built_in() -> Self {
        let (sites, alpha, kappa, rho, precompression) = (4, 1.5, 1.0, 1.0 / 3.0, 0.0);
        let (boundary, gravity, tilt) = (Boundary::Fixed, None, None);
        let chain = ChainSection { sites, alpha, kappa, rho, boundary, precompression, gravity, tilt };
        let (name, source) = ("built-in".to_owned(), "built-in".to_owned());
        Self { name, source, chain, state: None, amplitude: 1.0, units: None }
    }

    /// The chain and the initial state of a scene, with the largest overlap that its strains or its
    /// speeds can make as amplitude.
    ///
    /// # Errors
    /// A chain of beads that differ; a state at rest, or without an energy.
    pub fn of(scene: &Scene) -> Result<Self> {
        let (chain, y) = (scene.chain(), scene.initial().as_slice());
        has_energy(scene)?;
        chain.uniform("a chart of stability")?;
        let amplitude = overlap_scale(chain, y);
        require(amplitude != 0.0, "scene", scene.name(), "a chain at rest has no error to chart")?;
        let (name, source) = (scene.name().to_owned(), scene.file().to_toml());
        let state = Some(chain.layout().arrays(y).map(<[f64]>::to_vec));
        // The file may be in SI units.
        let (kappa, precompression) = (chain.params().kappa, chain.precompression());
        let chain = ChainSection { kappa, precompression, ..scene.file().chain.clone() };
        Ok(Self { name, source, chain, state, amplitude, units: scene.units().copied() })
    }

    /// The problem with its amplitude, spring constant and static overlap in SI units, for reports.
    pub(super) fn in_units(mut self, units: &Units) -> Self {
        for x in [&mut self.amplitude, &mut self.chain.precompression] {
            *x = units.to_si(Quantity::Length, *x);
        }
        self.chain.kappa = units.to_si(Quantity::Stiffness, self.chain.kappa);
        self
    }

    /// The state of a chain at an amplitude: `u, v, u', v'`.
    fn state(&self, chain: &ChainSection, amplitude: f64) -> [Vec<f64>; 4] {
        let sites = chain.sites;
        if let Some(state) = &self.state {
            // A longer chain repeats the sites of the scene, a shorter one has the first of them.
            let scale = amplitude / self.amplitude;
            let fitted = |array: &Vec<f64>| array.iter().cycle().take(sites).map(|value| scale * value).collect();
            let mut state = state.each_ref().map(fitted);
            if chain.kappa == 0.0 || chain.rho == 0.0 || chain.rho.is_infinite() {
                (state[1], state[3]) = (Vec::new(), Vec::new());
            } else if state[1].is_empty() {
                (state[1], state[3]) = (vec![0.0; sites], vec![0.0; sites]);
            }
            return state;
        }
        let shape = |i: usize, phase: f64| (ANGLE * i as f64 + phase).cos();
        let u: Vec<f64> = (0..sites).map(|i| amplitude * shape(i, 0.0)).collect();
        let stretch = amplitude * (amplitude.powf(chain.alpha - 1.0) / chain.kappa).sqrt().min(1.0);
        let v = u.iter().enumerate().map(|(i, u)| u - stretch * shape(i, 1.0)).collect();
        [u, v, Vec::new(), Vec::new()]
    }

    /// A variant as a scene. It runs over as many contact periods as the variant says, or else over
    /// ten, but at most 10^4 periods of the fastest motion.
    pub(super) fn prepare(&self, variant: &Variant) -> Result<Prepared> {
        let mut section = self.chain.clone();
        section.rho = variant.rho.unwrap_or(section.rho);
        section.kappa = variant.kappa.unwrap_or(section.kappa);
        section.alpha = variant.alpha.unwrap_or(section.alpha);
        section.sites = variant.sites.unwrap_or(section.sites);
        let params = section.params();
        params.validate()?;
        let amplitude = variant.amplitude.unwrap_or(self.amplitude);
        section.precompression *= amplitude / self.amplitude;
        let contact = contact_frequency(params.alpha, amplitude + section.precompression);
        let fast = contact.max(params.omega());
        let longest = if variant.periods.is_some() { f64::INFINITY } else { MOST_PERIODS * TAU / fast };
        let span = (variant.periods.unwrap_or(super::PERIODS) * TAU / contact).min(longest);
        let scene = self.scene(section.clone(), self.state(&section, amplitude), span)?;
        Ok(Prepared { scene, units: self.units, contact, fast })
    }

    fn scene(&self, chain: ChainSection, [u, v, u_dot, v_dot]: [Vec<f64>; 4], span: f64) -> Result<Scene> {
        let file = SceneFile {
            name: self.name.clone(),
            summary: String::new(),
            chain,
            beads: None,
            bonds: None,
            drives: Vec::new(),
            units: None,
            initial: Initial::State { u, v, u_dot, v_dot },
            span: Span { periods: None, until: Some(span), period: None },
            method: None,
            record: Record::of(0),
        };
        Scene::build(file.clone()).map_err(|error| match &self.units {
            Some(units) => file.restated(error, units),
            None => error,
        })
    }
}
