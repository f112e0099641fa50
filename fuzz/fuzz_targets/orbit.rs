//! Files of an orbit: any bytes give strains on a ring within its rules, or an error.

#![no_main]

use hertzchain::orbits::Orbit;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    match Orbit::from_json(bytes) {
        Ok(orbit) => {
            orbit.setting.chain().expect("a setting within its rules");
            assert!(orbit.setting.sites % 2 == 1 && orbit.z.len() == 2 * orbit.setting.sites);
            assert!(orbit.z.iter().all(|z| z.is_finite()));
        }
        Err(rule) => assert!(!rule.is_empty() && rule.lines().count() == 1, "{rule}"),
    }
});
