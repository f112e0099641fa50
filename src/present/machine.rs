//! What numbers were made on, run times above all.

use hertzchain_integrators::Instructions;
use std::{env::consts, fs, thread};

/// Name and value: `system`, `cores`, `instructions`, and `processor` where the system tells.
pub(crate) fn machine() -> Vec<(&'static str, String)> {
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

/// The same for JSON.
pub(crate) fn machine_json() -> serde_json::Map<String, serde_json::Value> {
    machine().into_iter().map(|(name, value)| (name.to_owned(), value.into())).collect()
}
