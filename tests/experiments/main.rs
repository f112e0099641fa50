//! Studies of the paper, and orbits. One binary for all of them: what is generic is compiled once.

#[path = "../common/mod.rs"]
mod common;

mod branch_files;
mod breathers;
mod charts;
mod lifetimes;
mod orbits;
mod sweep;
mod theorem;
mod verify;
mod waves;
