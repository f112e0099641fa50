//! How much memory a process may still take, and sizes in words.

use std::{fs::read_to_string, path::Path};

/// Bytes that this process may still take, as far as the system says: of the machine with its swap,
/// of its control groups, and of its own limit. `None` where the system says nothing.
pub fn available() -> Option<u64> {
    let mut least = (field("/proc/meminfo", "MemAvailable:").zip(field("/proc/meminfo", "SwapFree:")))
        .map(|(free, swap)| 1024 * (free + swap));
    let mut take = |bytes: Option<u64>| least = [least, bytes].into_iter().flatten().min();
    let groups = read_to_string("/proc/self/cgroup").unwrap_or_default();
    for (own, root, names) in groups.lines().filter_map(|line| {
        let (kind, own) = line.split_once(':')?.1.split_once(':')?;
        match kind {
            "" => Some((own, "/sys/fs/cgroup", ["memory.max", "memory.current", "active_file", "inactive_file"])),
            "memory" => Some((
                own,
                "/sys/fs/cgroup/memory",
                ["memory.limit_in_bytes", "memory.usage_in_bytes", "total_active_file", "total_inactive_file"],
            )),
            _ => None,
        }
    }) {
        // A group is limited by those above it, too.
        for group in Path::new(own.trim_start_matches('/')).ancestors() {
            let at = |name: &str| Path::new(root).join(group).join(name);
            let number = |name| read_to_string(at(name)).ok()?.trim().parse::<u64>().ok();
            let [limit, used, files @ ..] = names;
            // What is kept of files is given up if memory is needed.
            let files = files.map(|name| field(at("memory.stat"), name).unwrap_or(0)).iter().sum();
            take(number(limit).zip(number(used)).map(|(limit, used)| limit.saturating_sub(used.saturating_sub(files))));
        }
    }
    let own = field("/proc/self/limits", "Max address space").zip(field("/proc/self/status", "VmSize:"));
    take(own.map(|(limit, used)| limit.saturating_sub(1024 * used)));
    least
}

/// The whole number after a name that begins a line of a file.
fn field(file: impl AsRef<Path>, name: &str) -> Option<u64> {
    let text = read_to_string(file).ok()?;
    let rest = text.lines().find_map(|line| line.strip_prefix(name))?;
    rest.split_whitespace().next()?.parse().ok()
}

/// A number of bytes with its unit, for people.
pub fn bytes(count: u64) -> String {
    let mut value = count as f64;
    for unit in ["B", "kB", "MB", "GB"] {
        if value < 1000.0 {
            return if unit == "B" { format!("{value} B") } else { format!("{value:.3} {unit}") };
        }
        value /= 1000.0;
    }
    format!("{value:.3} TB")
}

/// What is needed and what is available, in words, if that is too little.
pub fn lacking(needed: u64) -> Option<String> {
    let free = available().filter(|free| *free < needed)?;
    Some(format!("{} of memory where {} are available", bytes(needed), bytes(free)))
}
