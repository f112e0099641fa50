//! The dissipation of contacts, as input of a chain.

use hertzchain_integrators::law::Loss;
use serde::{Deserialize, Serialize};

/// How contacts dissipate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Viscoelastic spheres, `f = A (g^alpha + gamma d/dt g^alpha)_+` for `g > 0`: Kuwabara & Kono
    /// 1987, Jpn. J. Appl. Phys. 26, 1230; Brilliantov, Spahn, Hertzsch & Poeschel 1996, Phys. Rev.
    /// E 53, 5382. `gamma` is a time.
    Viscoelastic,
    /// A linear dashpot, `f = (A g^alpha + gamma g')_+` for `g > 0`; `gamma` is a force over a
    /// velocity.
    Dashpot,
}

/// The dissipation of contacts.
#[derive(Clone, Debug, PartialEq)]
pub struct Dissipation {
    /// Which law.
    pub kind: Kind,
    /// `gamma`, one number for each bond that can touch.
    pub strength: Vec<f64>,
}

impl Dissipation {
    /// That of the bond with this number among those that can touch.
    pub(crate) fn of(&self, bond: usize) -> Loss<f64> {
        match self.kind {
            Kind::Viscoelastic => Loss::Viscoelastic(self.strength[bond]),
            Kind::Dashpot => Loss::Dashpot(self.strength[bond]),
        }
    }
}
