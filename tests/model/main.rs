//! The chain, its modulation equations and their solutions. All tests are in one binary, so that
//! generic code is compiled once.

#[path = "../common/numbers.rs"]
mod numbers;
#[path = "../common/properties.rs"]
mod properties;

mod averages;
mod chain;
mod chain_properties;
mod dark_profiles;
mod dps_flows;
mod homoclinic;
mod modulation;
mod references;
