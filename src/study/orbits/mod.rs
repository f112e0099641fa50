//! Studies of periodic orbits: branches of orbits, of driven chains and of modes; proofs.

pub(crate) mod branches;
pub(crate) mod conservative;
pub(crate) mod driven;
pub(crate) mod normal_modes;
pub(crate) mod proof;
pub(crate) mod segments;

pub use branches::{
    Begun, BifurcationOptions, BranchOptions, BranchStudy, FollowCommand, Kept, SceneSource, branch_from_archive,
    branch_npz, load_branch,
};
pub(crate) use conservative::KINDS;
pub use conservative::*;
pub use driven::*;
pub use normal_modes::*;
pub use proof::{Prove, Proving};
