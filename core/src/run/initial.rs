//! The state from which a run begins: in memory, or computed where it is needed.

use crate::{
    chain::{Blocks, Chain, Energy, Site, State, Whole, max_norm},
    error::Result,
};
use std::sync::{Arc, OnceLock};

/// Sites of a block of a state that is computed site by site.
const BLOCK: usize = 1 << 16;

/// A function from the number of a site to its state.
type Sites = Box<dyn Fn(usize) -> Site<f64> + Send + Sync>;

/// The initial state of a run, or a function that computes it site by site. Clones share it.
///
/// A state that is computed takes no memory until the [`whole`](Self::whole) of it is asked for.
#[derive(Clone)]
pub struct Initial(Arc<Inner>);

struct Inner {
    /// The chain, and the function that computes a site of it; `None` if the state was given.
    source: Option<(Chain<f64>, Sites)>,
    whole: OnceLock<Arc<State<f64>>>,
    measure: OnceLock<Measure>,
}

/// Size and energy of the initial state, with which the checks for unstable states compare.
#[derive(Clone, Copy, Debug)]
pub struct Measure {
    /// The largest absolute values of the first and of the second half of the state: of positions
    /// and of velocities.
    pub sizes: [f64; 2],
    /// The energy, if the state has one.
    pub energy: Option<Energy<f64>>,
}

impl Initial {
    /// The state of a chain without [`Details`](crate::chain::Details), which `site` computes site
    /// by site.
    pub fn by_sites(chain: &Chain<f64>, site: impl Fn(usize) -> Site<f64> + Send + Sync + 'static) -> Self {
        Self::of(Some((chain.clone(), Box::new(site))))
    }

    fn of(source: Option<(Chain<f64>, Sites)>) -> Self {
        Self(Arc::new(Inner { source, whole: OnceLock::new(), measure: OnceLock::new() }))
    }

    /// Computes the whole state now.
    ///
    /// # Errors
    /// A value that is not finite, by name and site.
    pub fn make(&self) -> Result<&State<f64>> {
        if let (None, Some((chain, sites))) = (self.made(), &self.0.source) {
            let state = Arc::new(State::from_fn(chain, sites)?);
            return Ok(self.0.whole.get_or_init(|| state));
        }
        Ok(self.whole())
    }

    /// The whole state; the first call computes it, unless it was given.
    ///
    /// # Panics
    /// If a value is not finite: [`make`](Self::make) says which.
    pub fn whole(&self) -> &State<f64> {
        self.0.whole.get_or_init(|| {
            let (chain, sites) = self.0.source.as_ref().expect("a state, or what computes it");
            Arc::new(State::from_fn(chain, sites).expect("a state that was checked"))
        })
    }

    /// The whole state, if it is in memory.
    pub fn made(&self) -> Option<&State<f64>> {
        self.0.whole.get().map(|state| &**state)
    }

    /// Sizes and energy. A state that is not in memory is computed for this in blocks of sites.
    pub fn measure(&self, chain: &Chain<f64>) -> Measure {
        *self.0.measure.get_or_init(|| match self.made() {
            Some(state) => {
                let y = state.as_slice();
                let sizes = [&y[..y.len() / 2], &y[y.len() / 2..]].map(|half| max_norm(half.iter().copied()));
                Measure { sizes, energy: chain.has_energy(y).then(|| chain.energy(y)) }
            }
            None => {
                let mut sizes = [0.0f64; 2];
                self.each(&mut |_, [u, v, u_dot, v_dot]| {
                    for (size, [one, other]) in sizes.iter_mut().zip([[u, v], [u_dot, v_dot]]) {
                        *size = size.max(max_norm(one.iter().chain(other).copied()));
                    }
                });
                Measure { sizes, energy: chain.has_energy_in(self).then(|| chain.energy_in(self)) }
            }
        })
    }
}

impl Blocks<f64> for Initial {
    fn each(&self, see: &mut dyn FnMut(usize, [&[f64]; 4])) {
        let (Some((chain, sites)), None) = (&self.0.source, self.made()) else {
            let state = self.whole();
            return Whole(state.layout(), state.as_slice()).each(see);
        };
        let (n, resonators) = (chain.sites(), chain.layout().resonators());
        let mut columns = [const { Vec::new() }; 4];
        for first in (0..n).step_by(BLOCK) {
            columns.iter_mut().for_each(Vec::clear);
            for site in (first..n.min(first + BLOCK)).map(sites) {
                let values = [site.u, site.v, site.u_dot, site.v_dot];
                let moving = |k: &usize| resonators || k.is_multiple_of(2);
                (0..4).filter(moving).for_each(|k| columns[k].push(values[k]));
            }
            see(first, columns.each_ref().map(Vec::as_slice));
        }
    }

    fn last(&self) -> f64 {
        match (self.made(), &self.0.source) {
            (None, Some((chain, sites))) => sites(chain.sites() - 1).u,
            _ => self.whole().u().last().copied().unwrap_or_default(),
        }
    }
}

impl From<Arc<State<f64>>> for Initial {
    fn from(state: Arc<State<f64>>) -> Self {
        let initial = Self::of(None);
        initial.0.whole.get_or_init(|| state);
        initial
    }
}

impl From<State<f64>> for Initial {
    fn from(state: State<f64>) -> Self {
        Arc::new(state).into()
    }
}

impl std::fmt::Debug for Initial {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.made() {
            Some(state) => state.fmt(f),
            None => f.write_str("a state by sites"),
        }
    }
}
