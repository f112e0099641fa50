//! The chain, its modulation equations and their solutions. One binary for all of them: what is generic is compiled once.

mod averaged;
mod averages;
mod chain;
mod chain_properties;
mod dark_profiles;
mod dps_flows;
mod homoclinic;
mod modulation;
mod references;
