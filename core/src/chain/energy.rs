//! The energy, by kind and by site.

use super::{Chain, Resonators, details::CheckedDetails};
use hertzchain_integrators::Real;

/// The energy of a state by kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy<R> {
    /// Kinetic energy of the beads, `sum u'^2 / 2`.
    pub beads: R,
    /// Kinetic energy of the resonators, `sum rho v'^2 / 2`.
    pub resonators: R,
    /// Energy of the springs, `sum kappa (u - v)^2 / 2`, and of those on sites and between beads,
    /// and of magnets.
    pub springs: R,
    /// Energy of the contacts, `sum (g)_+^{alpha+1} / (alpha+1)`.
    pub contacts: R,
    /// Energy that drag, dashpots and contacts have dissipated since the start.
    pub dissipated: R,
    /// Work of the drives since the start.
    pub driven: R,
}

impl<R: Real> Energy<R> {
    /// The energy of the state: kinetic energies, springs and contacts.
    pub fn total(&self) -> R {
        self.beads + self.resonators + self.springs + self.contacts
    }

    /// The energy plus the dissipated energy minus the work of the drives: constant along every
    /// motion.
    pub fn balance(&self) -> R {
        self.total() + self.dissipated - self.driven
    }
}

/// Velocities, stretches `u - v` of springs, and overlaps, from which the energy is computed.
struct Motion<R> {
    u_dot: Vec<R>,
    v_dot: Vec<R>,
    stretch: Vec<R>,
    overlaps: Vec<R>,
}

impl<R: Real> Chain<R> {
    /// Whether the state has an energy: always, but on a strain ring, which is Hamiltonian only
    /// where `sum x = sum y` and the mean strain is at rest (up to round-off).
    pub fn has_energy(&self, y: &[R]) -> bool {
        if !self.topology.strains() {
            return true;
        }
        let arrays = self.layout.arrays(y);
        let [u, v, u_dot, v_dot] = arrays.map(|array| array.iter().fold(R::zero(), |a, &b| a + b));
        let of = arrays.map(|array| array.iter().fold(R::zero(), |a, &b| a + b.abs()));
        let balanced = |sum: R, size: R| sum.abs() <= R::of(64.0) * R::epsilon() * size;
        let springs = match self.params.resonators() {
            _ if self.layout.resonators() => balanced(u - v, of[0] + of[1]) && balanced(v_dot, of[3]),
            Resonators::Fixed => balanced(u, of[0]),
            _ => true,
        };
        springs && balanced(u_dot, of[2])
    }

    /// The energy of a state by kind.
    ///
    /// On a strain ring the displacements are those with zero mean; see
    /// [`has_energy`](Self::has_energy).
    pub fn energy(&self, y: &[R]) -> Energy<R> {
        if let Some(parts) = self.parts() {
            return self.detailed_energy(parts, y);
        }
        let (arrays, mut squares) = (self.layout.arrays(y), [R::zero(); 3]);
        let contacts = if self.topology.strains() {
            let (means, mut sum) = (self.means(arrays), [R::zero(); 3]);
            self.each_site(arrays, |k, d| {
                sum[k] += d;
                let value = sum[k] - means[k];
                squares[k] += value * value;
            });
            self.potential(arrays[0].iter().map(|&x| -x))
        } else {
            self.each_site(arrays, |k, d| squares[k] += d * d);
            self.potential(self.between(arrays[0]))
        };
        let ([beads, resonators, springs], half) = (squares, R::of(0.5));
        Energy {
            beads: half * beads,
            resonators: half * R::of(self.params.rho.min(f64::MAX)) * resonators,
            springs: half * R::of(self.params.kappa) * springs,
            contacts,
            dissipated: R::zero(),
            driven: R::zero(),
        }
    }

    /// On a strain ring: means of `u'`, `v'` and `u - v`, summed up from their differences.
    fn means(&self, arrays: [&[R]; 4]) -> [R; 3] {
        let (mut sum, mut totals) = ([R::zero(); 3], [R::zero(); 3]);
        self.each_site(arrays, |k, d| {
            sum[k] += d;
            totals[k] += sum[k];
        });
        R::from(self.sites()).map_or(totals, |count| totals.map(|total| total / count))
    }

    /// Calls `take` with `u'`, `v'` and the stretch of the spring of each site, numbered from 0;
    /// all of a site together, since sums over sites wait for their last addition.
    #[inline(always)]
    fn each_site(&self, [u, v, u_dot, v_dot]: [&[R]; 4], mut take: impl FnMut(usize, R)) {
        match self.params.resonators() {
            Resonators::Moving => {
                for ((&u, &v), (&u_dot, &v_dot)) in u.iter().zip(v).zip(u_dot.iter().zip(v_dot)) {
                    take(0, u_dot);
                    take(1, v_dot);
                    take(2, u - v);
                }
            }
            Resonators::Fixed => {
                for (&u, &u_dot) in u.iter().zip(u_dot) {
                    take(0, u_dot);
                    take(2, u);
                }
            }
            Resonators::None => u_dot.iter().for_each(|&u_dot| take(0, u_dot)),
        }
    }

    /// The energy of a chain with details.
    fn detailed_energy(&self, parts: &CheckedDetails<R>, y: &[R]) -> Energy<R> {
        let zero = R::zero();
        let mut energy =
            Energy { beads: zero, resonators: zero, springs: zero, contacts: zero, dissipated: zero, driven: zero };
        for i in 0..self.sites() {
            let [bead, resonator, spring] = self.own_energies(parts, y, i);
            energy.beads += bead;
            energy.resonators += resonator;
            energy.springs += spring;
        }
        let overlaps = self.overlaps(self.layout.u(y));
        energy.springs += self.touching().fold(zero, |sum, bond| sum + self.joint_energy(parts, y, bond));
        energy.contacts = overlaps.iter().zip(&parts.bonds).fold(zero, |sum, (&g, bond)| sum + bond.potential(g));
        if let Some(ledger) = self.layout.ledger(y) {
            (energy.dissipated, energy.driven) = (ledger.dissipated(), ledger.driven);
        }
        energy
    }

    /// Energy of the spring and the magnets of a bond.
    fn joint_energy(&self, parts: &CheckedDetails<R>, y: &[R], bond: usize) -> R {
        parts.joint(bond).map_or(R::zero(), |joint| joint.potential(self.across(bond, |i| self.layout.u(y)[i])))
    }

    /// The energy of magnets where all beads are at their places: a constant of the chain.
    pub fn energy_of_magnets(&self) -> R {
        let at_rest = |parts: &CheckedDetails<R>| {
            let joints = self.touching().filter_map(|bond| parts.joint(bond));
            joints.fold(R::zero(), |sum, joint| sum + joint.potential(R::zero()))
        };
        self.parts().map_or(R::zero(), at_rest)
    }

    /// Energies of bead, resonator and spring of a site of a chain with details.
    fn own_energies(&self, parts: &CheckedDetails<R>, y: &[R], i: usize) -> [R; 3] {
        let (layout, site, half) = (self.layout, &parts.sites[i], R::of(0.5));
        let of = |array: Option<&[R]>| array.map_or(R::zero(), |array| array[i]);
        let (u, u_dot) = (layout.u(y)[i], layout.u_dot(y)[i]);
        let (v, v_dot) = match site.resonators {
            Resonators::Moving => (of(layout.v(y)), of(layout.v_dot(y))),
            _ => (R::zero(), R::zero()),
        };
        let stretch = if site.resonators == Resonators::None { R::zero() } else { u - v };
        let resonator = site.resonator() * v_dot * v_dot;
        let springs = site.kappa * stretch * stretch + site.onsite * u * u;
        [half * site.mass * u_dot * u_dot, half * resonator, half * springs]
    }

    /// The potential of contacts with these overlaps.
    fn potential(&self, overlaps: impl Iterator<Item = R>) -> R {
        // Gaps have no potential and are left out: most bonds of a chain that is mostly at rest.
        overlaps.fold(R::zero(), |sum, g| if g <= R::zero() { sum } else { sum + self.law.potential(g) })
    }

    /// The energy of each site: its own, and half of each of its two bonds (the whole of a bond
    /// with a wall).
    ///
    /// Sums to [`energy`](Self::energy).
    pub fn site_energies(&self, y: &[R]) -> Vec<R> {
        if let Some(parts) = self.parts() {
            let overlaps = self.overlaps(self.layout.u(y));
            let mut bonds: Vec<R> = overlaps.iter().zip(&parts.bonds).map(|(&g, bond)| bond.potential(g)).collect();
            self.touching().for_each(|bond| bonds[bond] += self.joint_energy(parts, y, bond));
            let own = |i| self.own_energies(parts, y, i).into_iter().fold(R::zero(), |a, b| a + b);
            return (0..self.sites()).map(|i| own(i) + self.share(&bonds, i) + self.share(&bonds, i + 1)).collect();
        }
        let motion = self.motion(y);
        let (half, n) = (R::of(0.5), self.sites());
        let (kappa, rho) = (R::of(self.params.kappa), R::of(self.params.rho.min(f64::MAX)));
        let at = |slice: &[R], i: usize| slice.get(i).map_or(R::zero(), |&a| a * a);
        let bonds: Vec<R> = motion.overlaps.iter().map(|&g| self.law.potential(g)).collect();
        (0..n)
            .map(|i| {
                let own = at(&motion.u_dot, i) + rho * at(&motion.v_dot, i) + kappa * at(&motion.stretch, i);
                half * own + self.share(&bonds, i) + self.share(&bonds, i + 1)
            })
            .collect()
    }

    /// The share of a site in the energy of a bond beside it.
    fn share(&self, bonds: &[R], bond: usize) -> R {
        let energy = bonds[bond % bonds.len()];
        if self.topology.at_wall(bond) { energy } else { R::of(0.5) * energy }
    }

    /// The participation number of the site energies `e_n`, `(sum e_n)^2 / sum e_n^2`: the number
    /// of sites that share the energy. It is 1 if one site has all of it, and the number of sites
    /// if all have the same.
    pub fn participation(&self, y: &[R]) -> R {
        let energies = self.site_energies(y);
        let (sum, squares) = energies.iter().fold((R::zero(), R::zero()), |(a, b), &e| (a + e, b + e * e));
        sum * sum / squares
    }

    fn motion(&self, y: &[R]) -> Motion<R> {
        let layout = self.layout;
        let displacement = |strains: &[R]| if self.topology.strains() { unroll(strains) } else { strains.to_vec() };
        let stretch: Vec<R> = match (layout.v(y), self.params.resonators()) {
            (Some(v), _) => layout.u(y).iter().zip(v).map(|(&u, &v)| u - v).collect(),
            (None, Resonators::Fixed) => layout.u(y).to_vec(),
            (None, _) => Vec::new(),
        };
        Motion {
            u_dot: displacement(layout.u_dot(y)),
            v_dot: layout.v_dot(y).map(displacement).unwrap_or_default(),
            stretch: displacement(&stretch),
            overlaps: self.overlaps(layout.u(y)),
        }
    }
}

/// The periodic sequence with zero mean whose differences `d_n - d_{n-1}` are given.
fn unroll<R: Real>(differences: &[R]) -> Vec<R> {
    let mut sum = R::zero();
    let mut values: Vec<R> = differences
        .iter()
        .map(|&d| {
            sum += d;
            sum
        })
        .collect();
    if let Some(count) = R::from(values.len().max(1)) {
        let mean = values.iter().fold(R::zero(), |a, &b| a + b) / count;
        values.iter_mut().for_each(|value| *value -= mean);
    }
    values
}
