//! The equations of motion of a chain with details together with their linearisation.
//!
//! | symbol | meaning |
//! |---|---|
//! | `z` | positions and velocities, a state without its ledger |
//! | `W` | columns `dz`, given at the start: `W(t) = dz(t)/dz(0) W(0)` |
//! | `k_b` | stiffness `A_b alpha_b (g_b)_+^{alpha_b - 1}` of a contact |
//!
//! ```text
//! m_n du_n'' = k_n dg_n - k_{n+1} dg_{n+1} - kappa_n (du_n - dv_n) - c_n du_n' - d_n (du_n' - dv_n')
//! rho_n m_n dv_n'' = kappa_n (du_n - dv_n) + d_n (du_n' - dv_n'),     dg_b = du_{b-1} - du_b
//! ```
//!
//! The force is continuous where a contact begins or ends, so `W` is continuous there: no jump
//! matrix is needed. The stiffness begins like `t^{alpha-1}`, one power of time below the force.

use super::{
    super::{Chain, Field, Resonators},
    Parts, Turns,
};
use crate::error::{Error, Result};
use hertzchain_integrators::{
    EventFunctions, Kernel, Real, Regularised, Stepper, VectorField, dop853::Options, regularised::common_power,
};

/// A state and the columns `W` that the linearised flow carries along, in one vector: the state,
/// then `W` row by row.
pub struct Variations<R> {
    chain: Chain<R>,
    field: Field<R>,
    columns: usize,
    /// Change of the overlap of a bond in every column.
    change: Vec<R>,
}

/// A state and columns `W` at the end of a flow.
#[derive(Clone, Debug, PartialEq)]
pub struct Varied<R> {
    /// The state, with its ledger.
    pub state: Vec<R>,
    /// `W`, row by row; a row for each position, then for each velocity.
    pub columns: Vec<R>,
}

impl<R: Real> Variations<R> {
    /// The field of a chain and of `columns` columns. A uniform chain counts as one with details.
    ///
    /// # Errors
    /// A strain ring; contacts that dissipate, or have an exponent of 1 or less: the force or its
    /// derivative jumps there.
    pub fn new(chain: &Chain<R>, columns: usize) -> Result<Self> {
        let chain = match chain.parts() {
            Some(_) => chain.clone(),
            None => chain.clone().with(&super::Details::default())?,
        };
        if chain.dissipative_contacts() {
            let rule = "a tangent map needs contacts that do not dissipate: take drag or dashpots of resonators";
            return Err(Error::parameter("dissipation", "given", rule));
        }
        let parts = parts(&chain);
        if let Some(alpha) = parts.powers().into_iter().find(|alpha| *alpha <= 1.0) {
            return Err(Error::parameter("alpha", alpha, "tangent maps need alpha > 1"));
        }
        Ok(Self { field: Field::new(chain.clone()), change: vec![R::zero(); columns], columns, chain })
    }

    /// Number of rows of `W`: positions and velocities.
    pub fn rows(&self) -> usize {
        2 * self.chain.layout().half()
    }

    /// Integrates the state `start` and the `columns`, given row by row, over a span by regularised
    /// DOP853.
    ///
    /// Tolerance of a step: relative, and absolute in units of the largest entry of the state and
    /// of the drives. It holds for state and columns alike.
    ///
    /// ```
    /// use hertzchain_core::{Boundary, Chain, Params, chain::{Details, Variations}};
    /// // A bead with drag that touches nobody: u' decays, u moves by (1 - e^{-c t})/c of it.
    /// let details = Details { drag: vec![0.5], ..Details::default() };
    /// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Free, 1)?.with(&details)?;
    /// let varied = Variations::flow(&chain, &[0.0, 1.0, 0.0, 0.0, 0.0, 0.0], (0.0, 2.0), &[0.0, 1.0], 1e-12)?;
    /// let decay = (-1.0f64).exp();
    /// assert!((varied.columns[0] - 2.0 * (1.0 - decay)).abs() < 1e-11);
    /// assert!((varied.columns[1] - decay).abs() < 1e-11);
    /// # Ok::<(), hertzchain_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`new`](Self::new); columns whose number of entries is no multiple of the rows; a state
    /// of another length; an integration that fails.
    pub fn flow(chain: &Chain<R>, start: &[R], span: (R, R), columns: &[R], tol: R) -> Result<Varied<R>> {
        let rows = 2 * chain.layout().half();
        if !columns.len().is_multiple_of(rows) {
            let rule = "columns have an entry for each position and velocity";
            return Err(Error::parameter("columns", format!("{} entries for {rows} rows", columns.len()), rule));
        }
        let field = Self::new(chain, columns.len() / rows)?;
        let chain = field.chain.clone();
        let dim = chain.layout().dim();
        if start.len() != dim {
            return Err(Error::parameter("state", format!("{} entries", start.len()), "a state of the chain"));
        }
        let y: Vec<R> = start.iter().chain(columns).copied().collect();
        let largest = start.iter().fold(R::zero(), |largest: R, y| largest.max(y.abs()));
        let size = largest.max(R::of(chain.details().map_or(0.0, super::Details::scale)));
        let atol = if size > R::zero() { tol * size } else { tol };
        // An overlap is rounded by the rounding of its static part.
        let overlaps = chain.overlaps(&vec![R::zero(); chain.sites()]);
        let overlap = overlaps.into_iter().fold(R::zero(), |largest: R, overlap| largest.max(overlap));
        let options = Options { atol: atol.max(R::epsilon() * overlap), ..Options::new(tol) };
        let powers = parts(&chain).powers();
        // With columns the stiffness matters, one power of time below the force.
        let down = if columns.is_empty() { 0.0 } else { 1.0 };
        let powers: Vec<f64> = powers.into_iter().map(|alpha| alpha - down).collect();
        let least = powers.iter().copied().fold(f64::INFINITY, f64::min);
        let least = if least.is_finite() { least } else { 1.0 };
        let events = OfState { turns: Turns::new(chain), dim };
        let mut run = Regularised::new(field, events, (least, common_power(&powers, ORDER)), &y, span, options)?;
        while !run.done() {
            run.step()?;
        }
        let mut end = y;
        run.sample(span.1, &mut end);
        let columns = end.split_off(dim);
        Ok(Varied { state: end, columns })
    }
}

/// Order of DOP853.
const ORDER: u32 = 8;

fn parts<R: Real>(chain: &Chain<R>) -> &Parts<R> {
    chain.parts().expect("a chain with details")
}

/// The events of a chain, as functions of a vector that begins with the state.
struct OfState<R> {
    turns: Turns<R>,
    dim: usize,
}

impl<R: Real> EventFunctions<R> for OfState<R> {
    fn count(&self) -> usize {
        self.turns.count()
    }

    fn values(&self, t: R, y: &[R], g: &mut [R]) {
        self.turns.values(t, &y[..self.dim], g);
    }

    fn rates(&self, t: R, y: &[R], dy: &[R], rates: &mut [R]) {
        self.turns.rates(t, &y[..self.dim], &dy[..self.dim], rates);
    }

    fn band(&self, y: &[R]) -> R {
        self.turns.band(&y[..self.dim])
    }
}

impl<R: Real> VectorField<R> for Variations<R> {
    fn dim(&self) -> usize {
        self.chain.layout().dim() + self.rows() * self.columns
    }

    fn eval(&mut self, t: R, y: &[R], dy: &mut [R]) {
        let dim = self.chain.layout().dim();
        let ((state, w), (rates, dw)) = (y.split_at(dim), dy.split_at_mut(dim));
        self.field.eval(t, state, rates);
        if self.columns > 0 {
            R::run(Linearised { chain: &self.chain, state, w, dw, change: &mut self.change });
        }
    }
}

/// `W'` at a state.
struct Linearised<'a, R> {
    chain: &'a Chain<R>,
    state: &'a [R],
    w: &'a [R],
    dw: &'a mut [R],
    change: &'a mut [R],
}

impl<R: Real> Kernel for Linearised<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { chain, state, w, dw, change } = self;
        let (parts, layout, k) = (parts(chain), chain.layout(), change.len());
        let (n, half) = (chain.sites(), layout.half());
        dw[..half * k].copy_from_slice(&w[half * k..]);
        dw[half * k..].fill(R::zero());
        let row = |i: usize| &w[i * k..(i + 1) * k];
        for (i, site) in parts.sites.iter().enumerate() {
            let (u, u_dot) = (row(i), row(half + i));
            let (bead, resonator) = dw[(half + i) * k..].split_at_mut(k);
            accumulate(bead, -site.drag / site.mass, u_dot);
            if site.resonators == Resonators::None {
                continue;
            }
            let (spring, dashpot) = (site.kappa, site.dashpot);
            accumulate(bead, -spring / site.mass, u);
            accumulate(bead, -dashpot / site.mass, u_dot);
            if site.resonators != Resonators::Moving {
                continue;
            }
            let (v, v_dot) = (row(n + i), row(half + n + i));
            accumulate(bead, spring / site.mass, v);
            accumulate(bead, dashpot / site.mass, v_dot);
            let resonator = &mut resonator[(n - 1) * k..n * k];
            let own = site.resonator();
            for (by, [from, to]) in [(spring / own, [u, v]), (dashpot / own, [u_dot, v_dot])] {
                accumulate(resonator, by, from);
                accumulate(resonator, -by, to);
            }
        }
        let u = layout.u(state);
        for bond in chain.touching() {
            let contact = &parts.bonds[bond];
            let g = contact.rest + chain.across(bond, |i| u[i]);
            if g <= R::zero() {
                continue;
            }
            let stiffness = contact.stiffness(g);
            let pushed = chain.topology().pushed(bond);
            change.fill(R::zero());
            // Displacements are in the overlap with minus the weights of the forces on beads.
            for &(site, weight) in pushed.iter() {
                accumulate(change, -R::of(weight), row(site));
            }
            for &(site, weight) in pushed.iter() {
                let by = R::of(weight) * stiffness / parts.sites[site].mass;
                accumulate(&mut dw[(half + site) * k..(half + site + 1) * k], by, change);
            }
        }
        for (i, _) in parts.sites.iter().enumerate().filter(|(_, site)| site.moved) {
            dw[i * k..(i + 1) * k].fill(R::zero());
            dw[(half + i) * k..(half + i + 1) * k].fill(R::zero());
        }
    }
}

/// `to += by from`.
#[inline(always)]
fn accumulate<R: Real>(to: &mut [R], by: R, from: &[R]) {
    for (to, &from) in to.iter_mut().zip(from) {
        *to += by * from;
    }
}
