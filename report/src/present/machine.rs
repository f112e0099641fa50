//! The machine on which numbers, above all run times, were made.

use hertzchain_integrators::Instructions;
use std::{collections::HashMap, env::consts, fs, thread, time::SystemTime};

/// Names and values: `date`, `system`, `cores`, `instructions`, and `processor` where `/proc/cpuinfo` names
/// it.
pub fn machine() -> Vec<(&'static str, String)> {
    let cores = thread::available_parallelism().map_or_else(|_| "unknown".to_owned(), |n| n.to_string());
    let about = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let processor = about.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    let mut machine = vec![
        ("date", date(SystemTime::now())),
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

/// When and where runs of this process are timed, for captions.
pub fn timed() -> String {
    let machine: HashMap<_, _> = machine().into_iter().collect();
    let of = |name: &str| machine.get(name).map_or("", String::as_str);
    let processor = if of("processor").is_empty() { of("system") } else { of("processor") };
    format!("Timed {}, one thread, {processor}, {} cores, {}.", of("date"), of("cores"), of("instructions"))
}

/// A time as date and time of day, in UTC.
///
/// Days are counted from 0000-03-01 and years from March, so that the leap day is the last day of a
/// year.
pub fn date(time: SystemTime) -> String {
    let seconds = time.duration_since(SystemTime::UNIX_EPOCH).map_or(0, |since| since.as_secs());
    // Days since 0000-03-01.
    let days = seconds / 86_400 + 719_468;
    let (era, day) = (days / 146_097, days % 146_097);
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let of_year = day - (365 * year + year / 4 - year / 100);
    let from_march = (5 * of_year + 2) / 153;
    let of_month = of_year - (153 * from_march + 2) / 5 + 1;
    let month = if from_march < 10 { from_march + 3 } else { from_march - 9 };
    let year = 400 * era + year + u64::from(month <= 2);
    let (hour, minute) = (seconds / 3600 % 24, seconds / 60 % 60);
    format!("{year}-{month:02}-{of_month:02} {hour:02}:{minute:02} UTC")
}
