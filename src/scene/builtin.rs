//! The built-in scenes.

/// `(name, TOML)` of files in the folder `builtin`.
macro_rules! builtin {
    ($($name:literal)*) => {
        &[$(($name, include_str!(concat!("builtin/", $name, ".toml")))),*]
    };
}
pub(crate) use builtin;

/// The built-in scenes, in the order of the list.
pub(super) const BUILTIN: &[(&str, &str)] = builtin! {
    "tw-q15" "tw-q45" "tw-breakdown-q15" "tw-breakdown-q45" "tw-rho3" "tw-rho10" "tw-rho1000"
    "impact" "cradle" "precompressed" "bright-envelope" "bright-breather" "bright-breather-site"
    "bright-breather-16" "trivial-breather" "dimer" "impurity" "taper" "disorder" "defect"
    "end-driven" "dark-ends" "boundary-wave" "granular-crystal" "daraio-2006" "daraio-2006-loaded"
    "boechler-2010" "doney-2006" "rosas-2007" "job-2007" "hong-1999" "boechler-2011" "chong-2014"
    "pozharskiy-2015"
};
