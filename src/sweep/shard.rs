//! Shards: parts of a grid, for processes that do not communicate.

use crate::error::{Error, Result};
use std::{fmt, path::Path, str::FromStr};

/// Part `k` of `n` of a grid, written `k/n` with `1 <= k <= n`.
///
/// Points are dealt to shards in turn, and every round begins one shard later, so that neither rows
/// nor columns of a grid go to one shard: where the cost of a point rises along an axis, all shards
/// get points of all costs.
///
/// ```
/// use hertzchain::sweep::Shard;
/// let shard: Shard = "2/3".parse()?;
/// let points: Vec<usize> = (0..9).filter(|&k| shard.has(k)).collect();
/// assert_eq!(points, [1, 3, 8]);
/// assert!("0/3".parse::<Shard>().is_err() && "4/3".parse::<Shard>().is_err());
/// # Ok::<(), hertzchain::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    k: usize,
    n: usize,
}

impl Shard {
    /// Whether the point of this number in the grid is in the shard.
    pub fn has(self, point: usize) -> bool {
        (point + point / self.n) % self.n == self.k - 1
    }

    /// Refuses a grid in which not every shard has a point.
    pub(super) fn of(self, points: usize) -> Result<Self> {
        if self.n <= points {
            return Ok(self);
        }
        let rule = "more shards than points: give at most as many shards as the grid has points";
        Err(Error::parameter("shard", format!("{self} of a grid of {points} points"), rule))
    }

    /// The name of its store beside the store of the whole grid.
    pub(super) fn name(self, store: &str) -> String {
        format!("{}{}-of-{}{EXTENSION}", stem(store), self.k, self.n)
    }

    /// The names of the stores of shards in a folder, in order.
    pub(super) fn names(folder: &Path, store: &str) -> Vec<String> {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let shard = |name: &String| {
            let (k, n) = name.strip_prefix(&stem(store))?.strip_suffix(EXTENSION)?.split_once("-of-")?;
            format!("{k}/{n}").parse::<Self>().ok()
        };
        let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
        let mut names: Vec<String> = names.filter(|name| shard(name).is_some()).collect();
        names.sort_unstable();
        names
    }
}

const EXTENSION: &str = ".store";

fn stem(store: &str) -> String {
    format!("{}.shard-", store.strip_suffix(EXTENSION).unwrap_or(store))
}

impl FromStr for Shard {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let parsed = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
        match parsed {
            Some((k, n)) if (1..=n).contains(&k) => Ok(Self { k, n }),
            _ => Err(Error::parameter("shard", text, "K/N with whole numbers 1 <= K <= N, as in 2/8")),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.k, self.n)
    }
}
