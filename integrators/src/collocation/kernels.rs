//! The instruction sets that kernels of the solver are compiled for.

use crate::{
    real::{Kernel, Real},
    with_narrow,
};

/// Runs a kernel of the solver. For `S = 2` AVX-512 is left out: it would gain 4 % at most (50
/// sites, tolerances from 1e-4 to 1e-11), and take a fifth of the program's time to compile.
#[inline(always)]
pub(super) fn run<const S: usize, K: Kernel>(kernel: K) -> K::Output {
    if const { S == 1 } { f64::run(kernel) } else { with_narrow!(_V => kernel.run()) }
}

/// Runs a kernel that another kernel calls, for `S = 2`. It is not inlined, so that there is less
/// to compile.
#[inline(never)]
pub(super) fn apart<K: Kernel>(kernel: K) -> K::Output {
    with_narrow!(_V => kernel.run())
}
