//! The command line, its files and its figures. One binary for all of them: what is generic is
//! compiled once.
#![cfg(feature = "cli")]

#[path = "../common/numbers.rs"]
mod numbers;
#[path = "../common/program.rs"]
mod program;

mod archives;
mod bad_files;
mod branch_points;
mod cases;
mod cli;
mod contact_tables;
mod figures;
mod first_use;
mod gallery;
mod golden;
mod guide;
mod help;
mod limits;
mod loads;
mod long_runs;
mod machines;
#[cfg(feature = "mpi")]
mod mpi;
mod pages;
mod paper_figures;
mod paper_points;
mod parts;
#[cfg(feature = "plot")]
mod pictures;
mod plans;
mod proofs;
mod published;
mod records;
mod refusals;
mod scenes;
mod shards;
mod si;
mod studies;
mod tolerances;
