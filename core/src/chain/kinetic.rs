//! The split kinetic + potential energy: springs and contacts kick, everything drifts freely.

use super::{
    Chain, Resonators,
    sweep::{Sites, positions_are_u, sweep},
};
use hertzchain_integrators::{Real, SplitFlow, Twofold};

/// A chain split into kinetic and potential energy; Strang's scheme on it is velocity Verlet.
///
/// Its steps must resolve the springs: it is stable for `h omega < 2` only.
pub struct KineticFlow<R> {
    pub(super) chain: Chain<R>,
    pub(super) y: Vec<R>,
}

impl<R: Real> KineticFlow<R> {
    /// The chain at rest; load a state into it.
    pub fn new(chain: Chain<R>) -> Self {
        Self { y: vec![R::zero(); chain.layout().dim()], chain }
    }
}

impl<R: Real> SplitFlow<R> for KineticFlow<R> {
    fn dim(&self) -> usize {
        self.y.len()
    }

    fn load(&mut self, y: &[R]) {
        self.y.copy_from_slice(y);
    }

    fn store(&self, y: &mut [R]) {
        y.copy_from_slice(&self.y);
    }

    fn duplicate(&self) -> Self {
        Self { chain: self.chain.clone(), y: self.y.clone() }
    }

    fn copy_from(&mut self, other: &Self) {
        self.y.copy_from_slice(&other.y);
    }

    fn drift(&mut self, dt: Twofold<R>) {
        let (q, q_dot) = self.y.split_at_mut(self.chain.layout().dim() / 2);
        for (q, &q_dot) in q.iter_mut().zip(q_dot.iter()) {
            *q += dt.value() * q_dot;
        }
    }

    fn kick_drift(&mut self, kick: R, drift: Twofold<R>) {
        let Self { chain, y } = self;
        let (n, params, dt) = (chain.sites(), chain.params(), drift.value());
        let kappa = R::of(params.kappa);
        let (q, q_dot) = y.split_at_mut(chain.layout().dim() / 2);
        match params.resonators() {
            Resonators::None => sweep(chain, &mut Plain { u: q, u_dot: q_dot, kick, dt }),
            Resonators::Fixed => sweep(chain, &mut Cradle { u: q, u_dot: q_dot, kick, dt, kappa }),
            Resonators::Moving => {
                let ((u, v), (u_dot, v_dot)) = (q.split_at_mut(n), q_dot.split_at_mut(n));
                let kick_v = kick * kappa / R::of(params.rho);
                sweep(chain, &mut Resonant { u, v, u_dot, v_dot, kick, dt, kappa, kick_v });
            }
        }
    }
}

struct Plain<'a, R> {
    u: &'a mut [R],
    u_dot: &'a mut [R],
    kick: R,
    dt: R,
}

struct Cradle<'a, R> {
    u: &'a mut [R],
    u_dot: &'a mut [R],
    kick: R,
    dt: R,
    kappa: R,
}

struct Resonant<'a, R> {
    u: &'a mut [R],
    v: &'a mut [R],
    u_dot: &'a mut [R],
    v_dot: &'a mut [R],
    kick: R,
    dt: R,
    kappa: R,
    kick_v: R,
}

impl<R: Real> Sites<R> for Plain<'_, R> {
    positions_are_u!();

    #[inline(always)]
    fn update(&mut self, start: usize, len: usize, force: impl Fn(usize) -> R) {
        let (u, u_dot) = (&mut self.u[start..start + len], &mut self.u_dot[start..start + len]);
        for i in 0..len {
            u_dot[i] += self.kick * force(i);
            u[i] += self.dt * u_dot[i];
        }
    }
}

impl<R: Real> Sites<R> for Cradle<'_, R> {
    positions_are_u!();

    #[inline(always)]
    fn update(&mut self, start: usize, len: usize, force: impl Fn(usize) -> R) {
        let (u, u_dot) = (&mut self.u[start..start + len], &mut self.u_dot[start..start + len]);
        for i in 0..len {
            u_dot[i] += self.kick * (force(i) - self.kappa * u[i]);
            u[i] += self.dt * u_dot[i];
        }
    }
}

impl<R: Real> Sites<R> for Resonant<'_, R> {
    positions_are_u!();

    #[inline(always)]
    fn update(&mut self, start: usize, len: usize, force: impl Fn(usize) -> R) {
        let range = start..start + len;
        let (u, u_dot) = (&mut self.u[range.clone()], &mut self.u_dot[range.clone()]);
        let (v, v_dot) = (&mut self.v[range.clone()], &mut self.v_dot[range]);
        for i in 0..len {
            let d = u[i] - v[i];
            u_dot[i] += self.kick * (force(i) - self.kappa * d);
            v_dot[i] += self.kick_v * d;
            u[i] += self.dt * u_dot[i];
            v[i] += self.dt * v_dot[i];
        }
    }
}
