//! The built-in scenes.

/// `(name, TOML)` of each built-in scene, in the order of the list.
pub(super) const BUILTIN: &[(&str, &str)] = &[
    ("tw-q15", include_str!("builtin/tw-q15.toml")),
    ("tw-q45", include_str!("builtin/tw-q45.toml")),
    ("tw-breakdown-q15", include_str!("builtin/tw-breakdown-q15.toml")),
    ("tw-breakdown-q45", include_str!("builtin/tw-breakdown-q45.toml")),
    ("tw-rho3", include_str!("builtin/tw-rho3.toml")),
    ("tw-rho10", include_str!("builtin/tw-rho10.toml")),
    ("tw-rho1000", include_str!("builtin/tw-rho1000.toml")),
    ("impact", include_str!("builtin/impact.toml")),
    ("cradle", include_str!("builtin/cradle.toml")),
    ("precompressed", include_str!("builtin/precompressed.toml")),
    ("bright-breather", include_str!("builtin/bright-breather.toml")),
    ("bright-breather-site", include_str!("builtin/bright-breather-site.toml")),
    ("bright-breather-16", include_str!("builtin/bright-breather-16.toml")),
    ("trivial-breather", include_str!("builtin/trivial-breather.toml")),
    ("dimer", include_str!("builtin/dimer.toml")),
    ("impurity", include_str!("builtin/impurity.toml")),
    ("taper", include_str!("builtin/taper.toml")),
    ("disorder", include_str!("builtin/disorder.toml")),
    ("defect", include_str!("builtin/defect.toml")),
    ("end-driven", include_str!("builtin/end-driven.toml")),
    ("boundary-wave", include_str!("builtin/boundary-wave.toml")),
    ("granular-crystal", include_str!("builtin/granular-crystal.toml")),
];
