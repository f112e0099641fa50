//! The equations of motion as a first-order system, for methods that know no splitting.

use super::{
    Chain,
    sweep::{Sites, positions_are_u, sweep},
};
use hertzchain_integrators::{Real, Twofold, VectorField};

/// The vector field of (eq:Hertz), (eq:HertzS) or (eq:NC).
pub struct Field<R> {
    chain: Chain<R>,
}

impl<R: Real> Field<R> {
    /// The field of a chain.
    pub fn new(chain: Chain<R>) -> Self {
        Self { chain }
    }
}

impl<R: Real> VectorField<R> for Field<R> {
    fn dim(&self) -> usize {
        self.chain.layout().dim()
    }

    fn eval(&mut self, _t: R, y: &[R], dy: &mut [R]) {
        let chain = &self.chain;
        let (n, half, params) = (chain.sites(), chain.layout().dim() / 2, chain.params());
        let (q_dot, q_ddot) = dy.split_at_mut(half);
        q_dot.copy_from_slice(&y[half..]);
        let (u_ddot, v_ddot) = q_ddot.split_at_mut(n);
        sweep(chain, &mut Accelerations { u: chain.layout().u(y), u_ddot });
        let kappa = R::of(params.kappa);
        match (params.resonators(), chain.layout().v(y)) {
            (_, Some(v)) => {
                // To the last digit also in double-double, whose own division is not.
                let per_rho = Twofold::new(kappa).over(Twofold::new(R::of(params.rho))).value();
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

struct Accelerations<'a, R> {
    u: &'a [R],
    u_ddot: &'a mut [R],
}

impl<R: Real> Sites<R> for Accelerations<'_, R> {
    positions_are_u!();

    #[inline(always)]
    fn update(&mut self, start: usize, len: usize, force: impl Fn(usize) -> R) {
        for (i, u_ddot) in self.u_ddot[start..start + len].iter_mut().enumerate() {
            *u_ddot = force(i);
        }
    }
}
