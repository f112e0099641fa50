//! The integrators by themselves: coefficients, kernels, and problems without a chain.

mod collocation;
mod corrected;
mod dop853;
mod events;
mod numbers;
mod order_conditions;
mod regularised;
mod roots;
mod splitting;
mod vector;
