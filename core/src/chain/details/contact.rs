//! The dissipation of contacts, as input of a chain.

pub use hertzchain_integrators::law::Kind;

/// The dissipation of contacts.
#[derive(Clone, Debug, PartialEq)]
pub struct Dissipation {
    /// Which law.
    pub kind: Kind,
    /// `gamma`, one number for each bond that can touch.
    pub strength: Vec<f64>,
}
