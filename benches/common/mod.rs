//! A clock for benches: medians of repeated runs.

use std::{
    hint::black_box,
    time::{Duration, Instant},
};

/// Runs whose times make a median.
const SAMPLES: usize = 15;
/// Shortest sample: short work is repeated in it.
const SAMPLE: Duration = Duration::from_millis(40);

/// Times what the command line asks for: names that contain its words, once and without a clock under `--test`.
pub(crate) struct Bench {
    words: Vec<String>,
    once: bool,
}

impl Bench {
    /// What the command line asks for.
    pub(crate) fn from_args() -> Self {
        let (flags, words): (Vec<String>, _) = std::env::args().skip(1).partition(|word| word.starts_with("--"));
        Self { words, once: flags.iter().any(|flag| flag == "--test") }
    }

    /// Prints the median time of `work`, its quartiles, and the time of each of its `elements`.
    pub(crate) fn time<T>(&self, name: &str, elements: usize, mut work: impl FnMut() -> T) {
        if !self.words.iter().all(|word| name.contains(word)) {
            return;
        }
        let mut sample = |count: u32| {
            let start = Instant::now();
            (0..count).for_each(|_| drop(black_box(work())));
            start.elapsed()
        };
        let first = sample(1);
        if self.once {
            return println!("{name}: done");
        }
        let count = SAMPLE.div_duration_f64(first.max(Duration::from_nanos(1))).ceil() as u32;
        let mut times: Vec<f64> = (0..SAMPLES).map(|_| sample(count).as_secs_f64() / f64::from(count)).collect();
        times.sort_by(f64::total_cmp);
        let [low, median, high] = [1, 2, 3].map(|quarter| 1e6 * times[quarter * (SAMPLES - 1) / 4]);
        let each = 1e3 * median / elements as f64;
        println!("{name:60} {median:12.2} us ({low:.2} to {high:.2}), {each:10.3} ns each");
    }
}
