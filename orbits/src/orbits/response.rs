//! The linear response of a chain about its static state to a drive at one site.
//!
//! | symbol | meaning |
//! |---|---|
//! | `q` | displacements from the static state, of beads and of resonators that move |
//! | `A, B` | derivatives of the accelerations by `q` and by `q'`: `q'' = A q + B q' + ...` |
//! | `s, F` | displacement of a bead that is moved, force on a bead of mass `m` that is pushed |
//! | `q_hat` | amplitude, `q = Re(q_hat e^{i omega t})`, over that of `s` or `F` |
//!
//! ```text
//! (-omega^2 - i omega B - A) q_hat = e/m                  pushed; e is 1 at the bead, else 0
//! (-omega^2 - i omega B - A) q_hat = A_s + i omega B_s    moved; A_s, B_s are its columns
//! ```
//!
//! `B` has drag, dashpots beside springs, and the resistance of contacts, which is the derivative
//! of their force by the rate of the overlap at the static overlap.

use super::linear_modes::{NormalModes, linearised, steady, with};
use crate::{
    chain::{Chain, Details, DriveKind, State},
    error::{Result, require},
};
use nalgebra::{Complex, DMatrix, DVector};

/// The linear response to a drive at one site.
#[derive(Clone, Debug)]
pub struct Response {
    modes: NormalModes,
    /// `A` and `B` of the coordinates that are free.
    free: [DMatrix<f64>; 2],
    /// `A_s` and `B_s`, or `e/m` and zero.
    drive: [DVector<f64>; 2],
    /// For each bead the number of its coordinate; none for beads that are held.
    beads: Vec<Option<usize>>,
    site: usize,
}

impl Response {
    /// The response of a chain that is driven at a site. The other beads that drives move are held;
    /// its other drives are left out.
    ///
    /// ```
    /// use hertzchain_orbits::{chain::{Boundary, Chain, Details, DriveKind, Params}, orbits::Response};
    /// // One bead between walls: stiffness k = 2 alpha d^(alpha - 1) = 2, and drag c.
    /// let (omega, c) = (1.2, 0.3);
    /// let chain = Chain::new(Params::new(2.0, 0.0, 0.0)?, Boundary::Fixed, 1)?.precompressed(0.5)?;
    /// let chain = chain.with(&Details { drag: vec![c], ..Details::default() })?;
    /// let response = Response::new(&chain, 0, DriveKind::Force)?.at(omega)[0];
    /// // |u/F| = 1/|k - omega^2 + i omega c|.
    /// assert!((response.norm() * (2.0 - omega * omega).hypot(omega * c) - 1.0).abs() < 1e-13);
    /// # Ok::<(), hertzchain_orbits::Error>(())
    /// ```
    ///
    /// # Errors
    /// What [`NormalModes::held`] refuses; a site outside the chain; a force on a bead that is
    /// moved.
    pub fn new(chain: &Chain<f64>, site: usize, kind: DriveKind) -> Result<Self> {
        let n = chain.sites();
        require(site < n, "site", site, "a site of the chain, counted from 0")?;
        let moved = (kind == DriveKind::Displacement).then_some(site);
        let modes = NormalModes::held(chain, moved.as_slice())?;
        let details = chain.details().cloned().unwrap_or_default();
        let drives = steady(&details);
        let chain = with(chain, Details { drives: drives.clone(), ..details.clone() })?;
        let damped = with(&chain, Details { dissipation: None, drives, ..details })?;
        let mut state = State::rest(&damped).as_slice().to_vec();
        state[..modes.rest().len()].copy_from_slice(modes.rest());
        // All coordinates: beads, then resonators that move.
        let all: Vec<usize> = (0..n).chain((0..n).filter(|&i| damped.resonator_moves(i)).map(|i| n + i)).collect();
        let (_, stiffness) = linearised(&damped, &all, &state, false)?;
        let (_, mut damping) = linearised(&damped, &all, &state, true)?;
        resist(&chain, &state, &mut damping);
        let count = modes.coordinates();
        let place = |c: usize| {
            let (bead, resonator) = modes.place(c);
            all.iter().position(|&i| i == if resonator { n + bead } else { bead })
        };
        let places: Vec<usize> = (0..count).filter_map(place).collect();
        let block = |of: &DMatrix<f64>| DMatrix::from_fn(count, count, |i, j| of[(places[i], places[j])]);
        let column = |of: &DMatrix<f64>| DVector::from_fn(count, |i, _| of[(places[i], site)]);
        let beads = (0..n).map(|bead| places.iter().position(|&place| place == bead)).collect::<Vec<_>>();
        let drive = match moved {
            Some(_) => [column(&stiffness), column(&damping)],
            None => {
                require(beads[site].is_some(), "site", site, "a force on a bead that a drive moves does nothing")?;
                let mut push = DVector::zeros(count);
                beads[site].into_iter().for_each(|c| push[c] = 1.0 / chain.masses(site)[0]);
                [push, DVector::zeros(count)]
            }
        };
        Ok(Self { free: [block(&stiffness), block(&damping)], drive, beads, site, modes })
    }

    /// The linear modes of the chain without damping, with the beads that are moved held.
    pub fn modes(&self) -> &NormalModes {
        &self.modes
    }

    /// Amplitudes of all beads at a frequency, over that of the drive; not-a-number at a frequency
    /// of an undamped mode, where there is none.
    pub fn at(&self, omega: f64) -> Vec<Complex<f64>> {
        let [stiffness, damping] = &self.free;
        let turn = Complex::new(0.0, omega);
        let number = |[a, b]: [f64; 2]| turn * b + a;
        let matrix = DMatrix::from_fn(stiffness.nrows(), stiffness.ncols(), |i, j| {
            let diagonal = if i == j { omega * omega } else { 0.0 };
            -number([stiffness[(i, j)] + diagonal, damping[(i, j)]])
        });
        let [push, rate] = &self.drive;
        let push = DVector::from_fn(push.len(), |i, _| number([push[i], rate[i]]));
        let solved = matrix.lu().solve(&push);
        let nothing = Complex::new(f64::NAN, f64::NAN);
        let bead = |(bead, coordinate): (usize, &Option<usize>)| match coordinate {
            Some(c) => solved.as_ref().map_or(nothing, |solved| solved[*c]),
            None if self.site == bead => Complex::new(1.0, 0.0),
            None => Complex::new(0.0, 0.0),
        };
        self.beads.iter().enumerate().map(bead).collect()
    }
}

/// Adds the resistance of contacts at a state of rest to the derivative of accelerations by
/// velocities.
fn resist(chain: &Chain<f64>, state: &[f64], damping: &mut DMatrix<f64>) {
    // A power of the rate above 1 has no derivative at rest.
    if chain.details().and_then(|details| details.rate_power).is_some_and(|power| power != 1.0) {
        return;
    }
    let overlaps = chain.overlaps(chain.layout().u(state));
    for bond in chain.touching() {
        // Forces are linear in rates at which beads approach.
        let [still, closing] = [0.0, 1.0].map(|rate| chain.bond_force(bond, overlaps[bond], rate));
        let ends = chain.topology().ends(bond);
        let signed = || ends.into_iter().zip([-1.0, 1.0]).filter_map(|(site, sign)| Some((site?, sign)));
        for (site, push) in signed() {
            for (other, sign) in signed() {
                // The overlap grows with the site to the left.
                damping[(site, other)] -= push * sign * (closing - still) / chain.masses(site)[0];
            }
        }
    }
}
