//! Plain loops over bonds and over sites, as a yardstick for the speed of the splittings.
//!
//! | loop | a step |
//! |---|---|
//! | Verlet | kick by all forces, drift, kick (velocity Verlet) |
//! | rotation + kick | exact motion of bead and resonator, kick by the contacts, exact motion |
//!
//! Each is also there as Yoshida's composition of order four. The loops have no error control, no
//! output and no checks. They are plain Rust, compiled for the vector instructions of the machine,
//! as a C compiler does with `-march=native`.
//!
//! ```
//! use hertzchain_core::{Boundary, Chain, Params, plain::{Loop, Sites}};
//!
//! let chain = Chain::new(Params::new(1.5, 0.0, 0.0)?, Boundary::Free, 2)?;
//! // One bead flies at another of the same mass, which goes on with its velocity.
//! let mut sites = Sites::new(&chain, &[0.0, 0.0, 1.0, 0.0]);
//! Loop::VERLET.run(&mut sites, 1e-3, 10_000);
//! let end = sites.state();
//! assert!(end[2].abs() < 1e-4 && (end[3] - 1.0).abs() < 1e-4);
//! # Ok::<(), hertzchain_core::Error>(())
//! ```

use crate::chain::{Boundary, Chain, Resonators};
use hertzchain_integrators::{Real, kernel};

/// Sites with contacts and resonators in plain arrays.
#[derive(Clone, Debug)]
pub struct Sites {
    boundary: Boundary,
    alpha: f64,
    kappa: f64,
    rho: f64,
    /// Overlap of a bond at rest.
    rest: f64,
    moving: bool,
    u: Vec<f64>,
    /// Displacements of resonators; zeros without resonators, and for fixed ones.
    v: Vec<f64>,
    u_dot: Vec<f64>,
    v_dot: Vec<f64>,
    /// Forces of bonds, with one more place on either side.
    force: Vec<f64>,
}

impl Sites {
    /// The sites of a chain in the state `y`.
    pub fn new(chain: &Chain<f64>, y: &[f64]) -> Self {
        let (layout, n, params) = (chain.layout(), chain.sites(), chain.params());
        let of = |array: Option<&[f64]>| array.map_or_else(|| vec![0.0; n], <[f64]>::to_vec);
        Self {
            boundary: chain.boundary(),
            alpha: params.alpha,
            kappa: if params.resonators() == Resonators::None { 0.0 } else { params.kappa },
            rho: params.rho,
            rest: chain.precompression(),
            moving: layout.resonators(),
            u: layout.u(y).to_vec(),
            v: of(layout.v(y)),
            u_dot: layout.u_dot(y).to_vec(),
            v_dot: of(layout.v_dot(y)),
            force: vec![0.0; n + 3],
        }
    }

    /// The state, in the layout of the chain.
    pub fn state(self) -> Vec<f64> {
        let Self { u, v, u_dot, v_dot, .. } = self;
        if self.moving { [u, v, u_dot, v_dot].concat() } else { [u, u_dot].concat() }
    }

    /// Sets `force[1 + b]` of the bond to the left of bead `b`.
    #[inline(always)]
    fn forces(&mut self, law: impl Fn(f64) -> f64) {
        let (n, rest) = (self.u.len(), self.rest);
        let (u, f) = (&self.u[..n], &mut self.force[1..n + 2]);
        if self.boundary == Boundary::StrainRing {
            for i in 0..n {
                f[i] = law(-u[i]);
            }
        } else {
            for i in 1..n {
                f[i] = law(rest + (u[i - 1] - u[i]));
            }
        }
        match self.boundary {
            Boundary::Ring => {
                f[0] = law(rest + (u[n - 1] - u[0]));
                f[n] = f[0];
            }
            Boundary::StrainRing => {
                f[n] = f[0];
                self.force[0] = self.force[n];
            }
            open => {
                let [left, right] = open.walls();
                f[0] = if left { law(rest - u[0]) } else { 0.0 };
                f[n] = if right { law(rest + u[n - 1]) } else { 0.0 };
            }
        }
    }

    #[inline(always)]
    fn kick(&mut self, h: f64, springs: bool) {
        if self.alpha == 1.5 {
            self.forces(|overlap| overlap * overlap.max(0.0).sqrt());
        } else {
            let alpha = self.alpha;
            self.forces(|overlap| overlap.max(0.0).powf(alpha));
        }
        if self.boundary == Boundary::StrainRing {
            self.pushed::<true>(h, springs);
        } else {
            self.pushed::<false>(h, springs);
        }
    }

    #[inline(always)]
    fn pushed<const STRAIN: bool>(&mut self, h: f64, springs: bool) {
        let n = self.u.len();
        let (u_dot, v_dot) = (&mut self.u_dot[..n], &mut self.v_dot[..n]);
        let (f0, f1, f2) = (&self.force[..n], &self.force[1..n + 1], &self.force[2..n + 2]);
        for i in 0..n {
            u_dot[i] += h * if STRAIN { (f1[i] - f0[i]) - (f2[i] - f1[i]) } else { f1[i] - f2[i] };
        }
        if springs && self.kappa > 0.0 {
            let (kick, kick_v) = (h * self.kappa, h * self.kappa / self.rho);
            let (u, v) = (&self.u[..n], &self.v[..n]);
            for i in 0..n {
                let d = u[i] - v[i];
                u_dot[i] -= kick * d;
                v_dot[i] += kick_v * d;
            }
        }
    }

    #[inline(always)]
    fn straight(&mut self, h: f64) {
        for (u, u_dot) in self.u.iter_mut().zip(&self.u_dot) {
            *u += h * u_dot;
        }
        if self.kappa > 0.0 {
            for (v, v_dot) in self.v.iter_mut().zip(&self.v_dot) {
                *v += h * v_dot;
            }
        }
    }

    /// The exact motion of beads with resonators: the centre of mass moves freely, the stretch
    /// oscillates.
    #[inline(always)]
    fn turn(&mut self, h: f64, (sin, cos): (f64, f64), omega: f64) {
        let n = self.u.len();
        // Both shares also hold for fixed resonators, whose mass is infinite.
        let (of_u, of_v) = (1.0 / (1.0 + 1.0 / self.rho), 1.0 / (1.0 + self.rho));
        let (slow, fast) = (sin / omega, omega * sin);
        let (u, v) = (&mut self.u[..n], &mut self.v[..n]);
        let (u_dot, v_dot) = (&mut self.u_dot[..n], &mut self.v_dot[..n]);
        for i in 0..n {
            let (r, r_dot) = (of_v * u[i] + of_u * v[i], of_v * u_dot[i] + of_u * v_dot[i]);
            let (d, d_dot) = (u[i] - v[i], u_dot[i] - v_dot[i]);
            let (d, d_dot, r) = (d * cos + d_dot * slow, d_dot * cos - d * fast, r + h * r_dot);
            (u[i], v[i]) = (r + of_u * d, r - of_v * d);
            (u_dot[i], v_dot[i]) = (r_dot + of_u * d_dot, r_dot - of_v * d_dot);
        }
    }
}

/// `1/(2 - 2^{1/3})` and `1 - 2/(2 - 2^{1/3})`.
const YOSHIDA: [f64; 3] = [1.351_207_191_959_657_6, -1.702_414_383_919_315_3, 1.351_207_191_959_657_6];

/// A plain loop: a composition of Strang steps, on one of the two splits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loop {
    /// Name in tables.
    pub name: &'static str,
    /// Whether bead and resonator move exactly; else their springs are part of the kick.
    turns: bool,
    /// Shares of the Strang steps in a step.
    shares: &'static [f64],
}

impl Loop {
    /// Velocity Verlet.
    pub const VERLET: Self = Self { name: "plain Verlet", turns: false, shares: &[1.0] };
    /// Strang's scheme on the exact motion of bead and resonator.
    pub const ROTATION: Self = Self { name: "plain rotation + kick", turns: true, shares: &[1.0] };
    /// All plain loops.
    pub const ALL: [Self; 4] = [
        Self::VERLET,
        Self::ROTATION,
        Self { name: "plain Yoshida 4", turns: false, shares: &YOSHIDA },
        Self { name: "plain rotation, Yoshida 4", turns: true, shares: &YOSHIDA },
    ];

    /// Kicks a step.
    pub fn kicks(&self) -> usize {
        self.shares.len()
    }

    /// Evaluations of the contact force in `steps` steps.
    pub fn evaluations(&self, steps: u64) -> u64 {
        steps * self.shares.len() as u64 + u64::from(!self.turns)
    }

    /// Makes `steps` steps of length `h`.
    pub fn run(self, sites: &mut Sites, h: f64, steps: u64) {
        f64::run(kernel!(self.steps(sites, h, steps)));
    }

    #[inline(always)]
    fn steps(self, sites: &mut Sites, h: f64, steps: u64) {
        let Self { turns, shares, .. } = self;
        let omega = (sites.kappa * (1.0 + 1.0 / sites.rho)).sqrt();
        let half = 0.5 * h * shares[0];
        // Each share has an outer flow of half its length on either side; where two shares meet,
        // the two halves are one flow.
        let mut joint: Vec<f64> = shares.windows(2).map(|pair| 0.5 * h * (pair[0] + pair[1])).collect();
        joint.push(0.5 * h * (shares[0] + shares[shares.len() - 1]));
        let angle = |dt: f64| (omega * dt).sin_cos();
        let (ends, angles): (_, Vec<(f64, f64)>) = (angle(half), joint.iter().copied().map(angle).collect());
        macro_rules! compose {
            ($outer:ident, $inner:ident) => {
                $outer!(half, ends);
                for step in 0..steps {
                    for (k, share) in shares.iter().enumerate() {
                        $inner!(h * share, ends);
                        if step + 1 < steps || k + 1 < shares.len() {
                            $outer!(joint[k], angles[k]);
                        }
                    }
                }
                $outer!(half, ends);
            };
        }
        macro_rules! turn {
            ($dt:expr, $angle:expr) => {
                sites.turn($dt, $angle, omega)
            };
        }
        macro_rules! straight {
            ($dt:expr, $angle:expr) => {
                sites.straight($dt)
            };
        }
        macro_rules! contacts {
            ($dt:expr, $angle:expr) => {
                sites.kick($dt, false)
            };
        }
        macro_rules! forces {
            ($dt:expr, $angle:expr) => {
                sites.kick($dt, true)
            };
        }
        if !turns {
            compose!(forces, straight);
        } else if sites.kappa > 0.0 {
            compose!(turn, contacts);
        } else {
            compose!(straight, contacts);
        }
    }
}
