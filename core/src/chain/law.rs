//! The contact law of the integrators, and the powers and registers that sweeps are compiled for.

pub use hertzchain_integrators::law::ContactLaw;
pub(crate) use hertzchain_integrators::{law::Power, real::MOST_LANES as LANES, with_hertz};

/// Computes `$body` with `$power` bound to the power of a law and `$V` the type of registers: the
/// widest in use for the power 3/2, of at most four numbers for all others. Timed with AVX-512
/// against AVX2 (least of five runs), `strang-linear` and `corrected` gain 1.2 to 2.4 by wider ones
/// with 3/2, 1.2 to 1.75 with 2, 0.93 to 1.09 with 1.4 and 2.5.
macro_rules! with_force {
    ($law:expr, $power:ident, $($V:tt)+) => {
        $crate::chain::law::with_force!(@split $law, $power, () $($V)+)
    };
    (@split $law:expr, $power:ident, ($($V:tt)+) => $body:expr) => {
        if $law.exponent() == hertzchain_integrators::law::Exponent::ThreeHalves {
            let $power = hertzchain_integrators::law::ThreeHalves;
            hertzchain_integrators::with_registers!($($V)+ => $body)
        } else {
            let $power = $law.any_power();
            hertzchain_integrators::with_narrow!($($V)+ => $body)
        }
    };
    (@split $law:expr, $power:ident, ($($V:tt)*) $next:tt $($rest:tt)+) => {
        $crate::chain::law::with_force!(@split $law, $power, ($($V)* $next) $($rest)+)
    };
}
pub(crate) use with_force;
