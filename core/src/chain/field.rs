//! The equations of motion as a first-order system, for methods that are not splittings.

use super::{
    Chain,
    aligned::Aligned,
    details::{self, Pushing, Switched},
    sweep::{Sites, sweep},
};
use hertzchain_integrators::{Column, DoubleDouble, Real, Vector, VectorField};

/// The vector field of (eq:Hertz), (eq:HertzS) or (eq:NC).
pub struct Field<R> {
    chain: Chain<R>,
    /// Positions of beads and contact forces on them.
    contacts: [Aligned<R>; 2],
    /// The contacts that push, if the method tells.
    pushing: Option<Pushing>,
}

impl<R: Real> Field<R> {
    /// The field of a chain.
    pub fn new(chain: Chain<R>) -> Self {
        Self { contacts: Aligned::together(chain.sites()), chain, pushing: None }
    }

    /// The field for a method that stops at the events of
    /// [`Overlaps::with_pushes`](super::Overlaps::with_pushes) and tells the field: the forces of
    /// contacts that dissipate are smooth from event to event.
    pub(super) fn from_event_to_event(chain: Chain<R>) -> Self {
        Self { pushing: Some(Pushing::new(&chain)), ..Self::new(chain) }
    }

    /// The contacts that push, if the method tells.
    pub(super) fn pushing(&self) -> Option<&Pushing> {
        self.pushing.as_ref()
    }

    /// Takes the sign of a function of [`Overlaps::with_pushes`](super::Overlaps::with_pushes).
    pub(super) fn told(&mut self, index: usize, positive: bool) -> Option<Switched> {
        self.pushing.as_mut()?.turn(index, positive)
    }
}

impl<R: Real> VectorField<R> for Field<R> {
    fn dim(&self) -> usize {
        self.chain.layout().dim()
    }

    fn breaks(&self) -> Vec<f64> {
        self.chain.breaks()
    }

    fn complete(&self, start: R, t: R, y: &mut [R]) {
        details::complete(&self.chain, start, t, y);
    }

    fn eval(&mut self, t: R, y: &[R], dy: &mut [R]) {
        let Self { chain, contacts: [u, force], pushing } = self;
        if let Some(parts) = chain.parts() {
            return details::rates((chain, parts), pushing.as_ref(), t, y, dy, force);
        }
        let (n, half, params) = (chain.sites(), chain.layout().half(), chain.params());
        let (q_dot, q_ddot) = dy.split_at_mut(half);
        q_dot.copy_from_slice(&y[half..]);
        let (u_ddot, v_ddot) = q_ddot.split_at_mut(n);
        u.copy_from_slice(chain.layout().u(y));
        sweep(chain, Contacts { u: u.column(), force: force.column() }, ());
        u_ddot.copy_from_slice(force);
        let kappa = R::of(params.kappa);
        match (params.resonators(), chain.layout().v(y)) {
            (_, Some(v)) => {
                // This division is accurate to the last digit also in double-double, whose own
                // division is not.
                let per_rho = DoubleDouble::new(kappa).over(DoubleDouble::new(R::of(params.rho))).value();
                for i in 0..n {
                    let d = y[i] - v[i];
                    u_ddot[i] -= kappa * d;
                    v_ddot[i] = per_rho * d;
                }
            }
            (super::Resonators::Fixed, None) => {
                for i in 0..n {
                    u_ddot[i] -= kappa * y[i];
                }
            }
            _ => {}
        }
    }
}

/// Beads at given positions, and the contact forces on them.
struct Contacts<'a, R> {
    u: Column<'a, R>,
    force: Column<'a, R>,
}

impl<R: Real> Sites<R> for Contacts<'_, R> {
    type Moment = ();

    #[inline(always)]
    fn room(&self) -> usize {
        self.u.len().min(self.force.len())
    }

    #[inline(always)]
    unsafe fn positions<V: Vector<R>>(&self, at: usize, _now: &()) -> V {
        // SAFETY: the caller's promise.
        unsafe { self.u.load(at) }
    }

    #[inline(always)]
    unsafe fn advance<V: Vector<R>>(&mut self, at: usize, force: V, now: &(), _next: &()) -> V {
        // SAFETY: the caller's promise.
        unsafe {
            self.force.store(at, force);
            self.positions(at, now)
        }
    }
}
