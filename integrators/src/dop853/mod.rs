//! DOP853.
/// placeholder
pub struct Dop853;
