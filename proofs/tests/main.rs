//! The tests of the package, in one binary.

mod bounds;
mod branches;
mod interval;
mod moments;
mod multipliers;
mod proofs;
