//! Studies of breathers: trivial, bright, dark and moving, and how long they live.

pub(crate) mod barrier;
pub(crate) mod breather;
pub(crate) mod lifetimes;
pub(crate) mod moving;

pub use barrier::*;
pub use breather::*;
pub use lifetimes::*;
pub use moving::*;
