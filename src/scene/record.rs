//! The section `[record]`: what of a run is kept.
//!
//! | symbol | meaning |
//! |---|---|
//! | `f_b` | force of the contact of bond `b`, dissipation included |
//! | `s_n` | sensor: `(f_n + f_{n+1})/2`, of the bonds to the left and to the right of bead `n` |
//! | `p_n, e_n` | momentum `m_n u_n' + rho_n m_n v_n'`, and energy by `Chain::site_energies` |
//!
//! A force sensor within a bead without resonator, between its halves of mass `m/2`, feels the mean
//! of the two contacts of the bead: the acceleration of the bead is `(f_n - f_{n+1})/m`, and each
//! half takes half of the difference.

use super::Quantity;
use crate::{
    chain::{Boundary, Chain},
    error::{Error, NOTHING, Result, refuse, require},
    named::named,
};
use serde::{Deserialize, Serialize};

sections! {
    /// The section `[record]`.
    #[derive(Default)]
    pub struct Record {
        /// Number of equally spaced times at which energy and strains are kept; 0: the end only.
        ///
        /// If left out, a scene takes [`FEWEST_SAMPLES`](Self::FEWEST_SAMPLES), or more where its
        /// period is known; see [`by_default`](Self::by_default).
        samples?: usize,
        /// The beads whose quantities are kept; all, if only quantities are named.
        sites?: Places,
        /// The bonds whose quantities are kept; all, if only quantities are named.
        bonds?: Places,
        /// The quantities; if left out, forces of bonds and velocities of sites that are named.
        quantities?: Vec<Recorded>,
    }

    /// Numbers from `from` to `to`, both included where a step ends there.
    pub struct PlaceRange {
        /// The first number.
        from: usize,
        /// No number is larger.
        to: usize,
        /// From a number to the next, 1 if left out.
        step?: usize,
    }
}

/// Sites or bonds by their numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a list of whole numbers, or { from = 0, to = 100, step = 5 }")]
pub enum Places {
    /// One by one.
    List(Vec<usize>),
    /// Evenly spaced.
    Range(PlaceRange),
}

named! {
    /// A quantity that is recorded in time, at sites or at bonds.
    pub enum Recorded {
        /// Displacement of a bead.
        U = "u", "displacement u";
        /// Displacement of a resonator.
        V = "v", "displacement v";
        /// Velocity of a bead.
        UDot = "u_dot", "velocity u′";
        /// Velocity of a resonator.
        VDot = "v_dot", "velocity v′";
        /// Momentum of a bead with its resonator.
        Momentum = "momentum", "momentum";
        /// Energy of a site with half of its contacts.
        Energy = "energy", "energy";
        /// Mean of the two contact forces of a bead.
        Sensor = "sensor", "force in a bead";
        /// Force of a contact.
        Force = "force", "contact force";
        /// Overlap of a contact.
        Overlap = "overlap", "overlap";
    }
    /// What it is, for labels.
    pub fn words
}

impl Recorded {
    /// Whether bonds have it.
    pub fn of_bonds(self) -> bool {
        matches!(self, Self::Force | Self::Overlap)
    }

    /// Whether it is a force, of which there are pulses.
    pub fn is_force(self) -> bool {
        matches!(self, Self::Force | Self::Sensor)
    }

    /// The kind of its numbers.
    pub fn quantity(self) -> Quantity {
        match self {
            Self::U | Self::V | Self::Overlap => Quantity::Length,
            Self::UDot | Self::VDot => Quantity::Velocity,
            Self::Momentum => Quantity::Momentum,
            Self::Energy => Quantity::Energy,
            Self::Sensor | Self::Force => Quantity::Force,
        }
    }
}

impl Record {
    /// Least default number of samples.
    pub const FEWEST_SAMPLES: usize = 400;
    /// Largest default number of samples.
    pub const MOST_SAMPLES: usize = 10_000;
    /// Default number of samples per period, up to [`MOST_SAMPLES`](Self::MOST_SAMPLES) in all.
    pub const PER_PERIOD: f64 = 16.0;

    /// Records with the given number of samples.
    pub fn of(samples: usize) -> Self {
        Self { samples: Some(samples), ..Self::default() }
    }

    /// The default number of samples, from the length of the run in periods, if a period is known.
    ///
    /// ```
    /// use hertzchain::scene::Record;
    /// assert_eq!(Record::by_default(None), 400);
    /// assert_eq!(Record::by_default(Some(10.0)), 400);
    /// assert_eq!(Record::by_default(Some(100.0)), 1600);
    /// assert_eq!(Record::by_default(Some(1e9)), 10_000);
    /// ```
    pub fn by_default(periods: Option<f64>) -> usize {
        // A rounding of the number of periods is no sample more.
        let wanted = (Self::PER_PERIOD * periods.unwrap_or(0.0) * (1.0 - 1e-12)).ceil().min(Self::MOST_SAMPLES as f64);
        (wanted as usize).max(Self::FEWEST_SAMPLES)
    }

    /// What is selected of a chain; none if nothing is named.
    ///
    /// # Errors
    /// A number that is no site, or no bond that can touch; places without a quantity of theirs, or
    /// the other way round; a strain ring.
    pub(super) fn selection(&self, chain: &Chain<f64>) -> Result<Option<Selection>> {
        let Self { sites, bonds, quantities, .. } = self;
        if sites.is_none() && bonds.is_none() && quantities.is_none() {
            return Ok(None);
        }
        let rule = "a run of strains keeps all of them: leave `sites`, `bonds` and `quantities` out";
        require(chain.boundary() != Boundary::StrainRing, "record", "on a strain ring", rule)?;
        let usual = [Recorded::UDot, Recorded::Force].into_iter();
        let usual = usual.filter(|one| if one.of_bonds() { bonds.is_some() } else { sites.is_some() });
        let quantities = quantities.clone().unwrap_or_else(|| usual.collect());
        let repeated = (1..quantities.len()).find(|&k| quantities[..k].contains(&quantities[k]));
        refuse("record.quantities", repeated.map(|k| quantities[k].name()), "name each quantity once")?;
        let moving = (0..chain.sites()).any(|n| chain.resonator_moves(n));
        let still = quantities.iter().find(|one| !moving && matches!(one, Recorded::V | Recorded::VDot));
        refuse("record.quantities", still.map(|one| one.name()), "no resonator of this chain moves")?;
        let named = |places: &Option<Places>, key, of_bonds: bool, all: std::ops::Range<usize>, rule| {
            let any = quantities.iter().any(|one| one.of_bonds() == of_bonds);
            match places {
                Some(_) if !any => {
                    let rule =
                        if of_bonds { "bonds have force and overlap: name one" } else { "name a quantity of sites" };
                    Err(Error::parameter(key, "places alone", rule))
                }
                Some(places) => places.within(key, &all, rule),
                None => Ok(if any { all.collect() } else { Vec::new() }),
            }
        };
        let sites = named(sites, "record.sites", false, 0..chain.sites(), "sites of the chain, counted from 0")?;
        let rule = "bonds that can touch; bond n lies to the left of site n";
        let bonds = named(bonds, "record.bonds", true, chain.touching(), rule)?;
        let none = quantities.is_empty() || sites.is_empty() && bonds.is_empty();
        require(!none, "record", NOTHING, "name at least one quantity, with a site or a bond")?;
        Ok(Some(Selection { sites, bonds, quantities }))
    }
}

impl Places {
    /// The numbers, if all are `within` and each is there once.
    fn within(&self, key: &'static str, within: &std::ops::Range<usize>, rule: &'static str) -> Result<Vec<usize>> {
        let all: Vec<usize> = match self {
            Self::List(list) => list.clone(),
            Self::Range(PlaceRange { step: Some(0), .. }) => {
                return Err(Error::parameter("step", 0, "at least 1"));
            }
            // Ends of any size, with no more numbers than fit.
            Self::Range(PlaceRange { from, to, step }) => {
                (*from..=*to).step_by(step.unwrap_or(1)).take(within.end + 1).collect()
            }
        };
        refuse(key, all.iter().find(|place| !within.contains(place)), rule)?;
        let odd = all.is_empty() || all.windows(2).any(|two| two[1] <= two[0]);
        refuse(key, odd.then(|| format!("{all:?}")), "at least one number, in ascending order").map(|()| all)
    }
}

/// What is recorded of a chain in time.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    sites: Vec<usize>,
    bonds: Vec<usize>,
    /// The quantities, in the order in which they are named.
    pub quantities: Vec<Recorded>,
}

impl Selection {
    /// The sites or the bonds of a quantity, in ascending order.
    pub fn places(&self, quantity: Recorded) -> &[usize] {
        if quantity.of_bonds() { &self.bonds } else { &self.sites }
    }

    /// How many numbers a time has.
    pub fn width(&self) -> usize {
        self.quantities.iter().map(|one| self.places(*one).len()).sum()
    }

    /// Appends the numbers of a state to `to`: quantity by quantity, each at all of its places.
    pub fn take(&self, chain: &Chain<f64>, y: &[f64], to: &mut Vec<f64>) {
        let [u, v, u_dot, v_dot] = chain.layout().arrays(y);
        let forced = self.quantities.iter().any(|one| one.is_force() || one.of_bonds());
        let overlaps = if forced { chain.overlaps(u) } else { Vec::new() };
        let force = |bond: usize| chain.bond_force(bond, overlaps[bond], chain.across(bond, |n| u_dot[n]));
        let wanted = self.quantities.contains(&Recorded::Energy);
        let energies = if wanted { chain.site_energies(y) } else { Vec::new() };
        for &quantity in &self.quantities {
            to.extend(self.places(quantity).iter().map(|&n| match quantity {
                Recorded::U => u[n],
                Recorded::V => v[n],
                Recorded::UDot => u_dot[n],
                Recorded::VDot => v_dot[n],
                Recorded::Momentum => {
                    let [bead, resonator] = chain.masses(n);
                    bead * u_dot[n] + v_dot.get(n).map_or(0.0, |v_dot| resonator * v_dot)
                }
                Recorded::Energy => energies[n],
                Recorded::Sensor => {
                    let [left, right] = chain.topology().bonds(n);
                    0.5 * [left, right].into_iter().flatten().map(force).sum::<f64>()
                }
                Recorded::Force => force(n),
                Recorded::Overlap => overlaps[n],
            }));
        }
    }
}
