//! The machine on which numbers, above all run times, were made.

use hertzchain_integrators::Instructions;
use std::{env::consts, fs, thread};

/// Names and values: `system`, `cores`, `instructions`, and `processor` where `/proc/cpuinfo` names
/// it.
pub fn machine() -> Vec<(&'static str, String)> {
    let cores = thread::available_parallelism().map_or_else(|_| "unknown".to_owned(), |n| n.to_string());
    let about = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let processor = about.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let mut machine = vec![
        ("system", format!("{} on {}", consts::OS, consts::ARCH)),
        ("cores", cores),
        ("instructions", Instructions::used().to_string()),
    ];
    machine.extend(processor.map(|(_, name)| ("processor", name.to_owned())));
    machine
}

/// The entries of [`machine`] as a JSON object.
pub fn machine_json() -> serde_json::Map<String, serde_json::Value> {
    machine().into_iter().map(|(name, value)| (name.to_owned(), value.into())).collect()
}
