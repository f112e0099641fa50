//! The chain as a problem of contact collocation.

use super::{Chain, HeterogeneousChain, Modes};
use hertzchain_integrators::{
    Collocation, Error, Stepper,
    collocation::{ContactChain, Path, Response, StepControl, monodromy},
    interrupt::Token,
    law::BondLaw,
};

/// Nodes of the collocation window by which [`Chain::back`] goes back inside a step. Chosen: the
/// error of the window is far below that of a step.
const INSIDE: usize = 12;
/// Tolerance of the collocation run that takes over where that window does not converge. Chosen in
/// the same way.
const TOLERANCE: f64 = 1e-13;

impl Chain<f64> {
    /// A run of this chain by contact collocation.
    ///
    /// # Errors
    /// A state, a span or a step control outside its rule; a chain with details.
    pub fn collocation(&self, y0: &[f64], span: (f64, f64), control: StepControl) -> Result<Collocation<Self>, Error> {
        self.uniform_sites()?;
        Collocation::new(self.clone(), y0, span, control)
    }

    /// As [`collocation`](Self::collocation), for a chain whose beads differ, are damped or driven.
    ///
    /// ```
    /// use hertzchain_core::chain::{Boundary, Chain, Details, Params};
    /// use hertzchain_core::integrators::{Stepper, collocation::StepControl};
    /// // A heavy bead strikes a light one: (m - M)/(m + M) and 2 m/(m + M).
    /// let details = Details { mass: vec![2.0, 1.0], ..Details::default() };
    /// let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Free, 2)?.with(&details)?;
    /// let mut y = [0.0, 0.0, 1.0, 0.0];
    /// let mut run = chain.heterogeneous_collocation(&y, (0.0, 20.0), StepControl::Tolerance(1e-12))?;
    /// while !run.done() {
    ///     run.step()?;
    /// }
    /// run.sample(20.0, &mut y);
    /// assert!((y[2] - 1.0 / 3.0).abs() < 1e-12 && (y[3] - 4.0 / 3.0).abs() < 1e-12);
    /// # Ok::<(), hertzchain_core::Error>(())
    /// ```
    ///
    /// # Errors
    /// A state, a span or a step control outside its rule; a chain without details.
    pub fn heterogeneous_collocation(
        &self,
        y0: &[f64],
        span: (f64, f64),
        control: StepControl,
    ) -> Result<Collocation<HeterogeneousChain, 2>, Error> {
        Collocation::new(HeterogeneousChain::new(self.clone())?, y0, span, control)
    }

    /// Moves a state of contact-corrected splitting back in time by `by`, forward with velocities
    /// reversed: the equations of motion are reversible.
    pub(super) fn back(&self, y: &mut [f64], by: f64) {
        let half = self.layout().half();
        let turn = |y: &mut [f64]| y[half..2 * half].iter_mut().for_each(|velocity| *velocity = -*velocity);
        turn(y);
        let window = StepControl::Windows { windows: 1, nodes: INSIDE, neighbours: true };
        // The iteration of a window that is too long for the stiffness of its contacts does not
        // converge; a run with a tolerance takes shorter windows.
        // Nor is a state wrong because the run is asked to end.
        let settled = Token::deaf()
            .within(|| run_on(self, y, by, window).or_else(|_| run_on(self, y, by, StepControl::Tolerance(TOLERANCE))));
        if settled.is_err() {
            // The caller gets NaN, not a wrong state.
            y.fill(f64::NAN);
        }
        turn(y);
    }

    /// The derivative of the state at the end of such a run by the state at its start: `dim x dim`,
    /// column by column, see [`monodromy`]. Entries of beads that drives move, and of the ledger,
    /// are zero.
    ///
    /// # Errors
    /// A state, a span or a step control outside its rule; a chain of more than 256 bonds, or with
    /// contacts that dissipate: [`Variations`](super::Variations) has their derivatives.
    pub fn monodromy(&self, y0: &[f64], span: (f64, f64), control: StepControl) -> Result<Vec<f64>, Error> {
        match self.details() {
            None => monodromy(self.clone(), y0, span, control),
            Some(_) => monodromy(HeterogeneousChain::new(self.clone())?, y0, span, control),
        }
    }

    /// [`uniform`](Self::uniform) as an error of an integrator.
    fn uniform_sites(&self) -> Result<(), Error> {
        let (value, rule) =
            (self.sites() as f64, "this run by contact collocation needs equal beads, without damping or drives");
        self.uniform("contact collocation").map_err(|_| Error::Argument { name: "sites with details", value, rule })
    }
}

impl ContactChain for Chain<f64> {
    fn dim(&self) -> usize {
        self.layout.dim()
    }

    fn sites(&self) -> usize {
        self.layout.sites()
    }

    fn bonds(&self) -> usize {
        self.touching().len()
    }

    fn ring(&self) -> bool {
        self.topology.ring()
    }

    #[inline(always)]
    fn bond(&self, _bond: usize) -> BondLaw<f64> {
        BondLaw {
            power: self.law,
            constant: 1.0,
            rest: self.precompression,
            loss: None,
            beta: 0.0,
            rate_power: 1.0,
            pulls: false,
        }
    }

    fn response(&self, _site: usize) -> Response {
        let Modes { m, mu, omega, .. } = self.modes;
        Response { m, mu, omega }
    }

    #[inline(always)]
    fn ends(&self, _bond: usize) -> [Option<usize>; 1] {
        [Some(0)]
    }

    #[inline(always)]
    fn across(&self, bond: usize, quantity: impl Fn(usize) -> Path) -> [Path; 1] {
        [self.topology.across(self.topology.first() + bond, quantity)]
    }

    #[inline(always)]
    fn push(&self, site: usize, force: impl Fn(usize) -> [Path; 1]) -> Path {
        let first = self.topology.first();
        self.topology.push(site, |bond| force(bond - first)[0])
    }

    fn path(&self, y: &[f64], i: usize) -> Path {
        let layout = self.layout;
        let of = |array: Option<&[f64]>| array.map_or(0.0, |array| array[i]);
        self.modes.path([layout.u(y)[i], of(layout.v(y)), layout.u_dot(y)[i], of(layout.v_dot(y))])
    }

    fn place(&self, modes: [f64; 4], i: usize, y: &mut [f64]) {
        let (n, half) = (self.sites(), self.layout.half());
        let [u, v, u_dot, v_dot] = self.modes.join(modes);
        (y[i], y[half + i]) = (u, u_dot);
        if self.layout.resonators() {
            (y[n + i], y[half + n + i]) = (v, v_dot);
        }
    }

    fn dead_band(&self, largest: f64) -> f64 {
        Chain::dead_band(self, std::iter::once(largest))
    }
}

/// Moves a state on by contact collocation.
fn run_on(chain: &Chain<f64>, y: &mut [f64], by: f64, control: StepControl) -> Result<(), Error> {
    fn end(mut run: impl Stepper<f64>, y: &mut [f64], by: f64) -> Result<(), Error> {
        while !run.done() {
            run.step()?;
        }
        run.sample(by, y);
        Ok(())
    }
    match chain.details() {
        None => end(chain.collocation(y, (0.0, by), control)?, y, by),
        Some(_) => end(chain.heterogeneous_collocation(y, (0.0, by), control)?, y, by),
    }
}
