//! Studies of integrators: their order, their errors against run time, drift and stability.

pub(crate) mod charts;
pub(crate) mod compare;
pub(crate) mod drift;
pub(crate) mod order;

pub use charts::{
    BOUNDS, Behaviour, Chart, ChartOptions, ChartPoint, ChartStudy, Charts, Limit, Measured, Problem, Trial, Variant,
    charts,
};
pub use compare::{
    Candidate, Compare, CompareOptions, Comparison, ErrorNorm, Fastest, LeftOut, Reference, Row, compare,
};
pub use drift::*;
pub use order::*;
