//! Linear studies of a chain as it stands on a table: bands, modes, spectra, response.

pub(crate) mod bands;
pub(crate) mod modes;
pub(crate) mod response;

pub use bands::Bands;
pub use modes::Modes;
pub use response::Responses;
