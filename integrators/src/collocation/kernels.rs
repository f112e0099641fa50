//! The instruction sets that kernels of the solver are compiled for: AVX-512 is left out. It gained
//! 4 % at most for `S = 2`, and lost 2 to 4 % for `S = 1` (tolerances from 1e-6 to 1e-11).

use crate::{real::Kernel, with_narrow};

/// Runs a kernel of the solver.
#[inline(always)]
pub(super) fn run<K: Kernel>(kernel: K) -> K::Output {
    with_narrow!(_V => kernel.run())
}

/// Runs a kernel that another kernel calls, for `S = 2`. It is not inlined, so that there is less
/// to compile.
#[inline(never)]
pub(super) fn apart<K: Kernel>(kernel: K) -> K::Output {
    run(kernel)
}
