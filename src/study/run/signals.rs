//! What `[record]` names of a scene: numbers in time, their largest values, and the maxima of
//! forces.
//!
//! | symbol | meaning |
//! |---|---|
//! | `y_k` | a signal: a quantity at a site or a bond, at the time `t_k` |
//! | *maximum* | a `y_k` before and after which the signal is lower by [`FALL`] of its range |
//! | *width* | time around a maximum above the middle between it and `y_0` |
//! | *length* | width times the speed of the largest maximum along the bonds, in bonds |
//!
//! A maximum is the vertex of the parabola through the largest `y_k` and its neighbours; times of
//! the middle are those of straight lines between samples. So errors are those of samples: of third
//! order in the time between them for maxima, of second order for widths. The largest value of a
//! run is that of [`Run::observables`](crate::run::Run::observables), also between samples.

use crate::{
    output::{NpzWriter, csv},
    report::{Kind, Line, Panel, Panels, Short, Table},
    run::{Profile, Trajectory},
    scene::{Quantity, Recorded, Scene, Selection, Units},
    study::si::Scale,
};
use serde_json::{Map, Value, json};
use std::fs::File;

/// Least fall after a maximum and least rise before it, as a share of the range of the signal.
const FALL: f64 = 0.01;
/// Changes of a signal below this share of its size are rounding: it has no maxima.
const ROUNDING: f64 = 1e-12;
/// Most numbers of the CSV file.
const MOST_IN_CSV: usize = 1_000_000;
/// Most lines of a panel.
const LINES: usize = 8;

/// Signals of a run.
#[derive(Clone, Debug)]
pub struct Signals {
    selection: Selection,
    times: Vec<f64>,
    /// A row for each time, in the order of the selection.
    values: Vec<f64>,
    /// Time and value of the largest of each, also between times; empty if nothing is known.
    extremes: Vec<(f64, f64)>,
}

/// A signal by its quantity and its site or bond.
#[derive(Clone, Copy, Debug)]
struct Signal<'a> {
    quantity: Recorded,
    place: usize,
    column: usize,
    of: &'a Signals,
}

/// A maximum of a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Peak {
    t: f64,
    value: f64,
    /// NaN if the signal is not below the middle on both sides.
    width: f64,
}

impl Signals {
    /// The signals that a scene names, without times; none if it names nothing.
    pub fn new(scene: &Scene) -> Option<Self> {
        let selection = scene.selection()?.clone();
        Some(Self { selection, times: Vec::new(), values: Vec::new(), extremes: Vec::new() })
    }

    /// The signals that a scene names, of states that were kept.
    pub fn of(scene: &Scene, states: &[Profile]) -> Option<Self> {
        let mut signals = Self::new(scene)?;
        states.iter().for_each(|profile| signals.take(scene, profile.t, &profile.state));
        Some(signals)
    }

    /// Takes the state at a time.
    pub fn take(&mut self, scene: &Scene, t: f64, y: &[f64]) {
        self.times.push(t);
        self.selection.take(scene.chain(), y, &mut self.values);
    }

    /// The same in the units of a report, with the largest values of a run between its samples.
    #[must_use]
    pub fn reported(mut self, outcome: &Trajectory, si: Option<&Units>) -> Self {
        let told = |kind, value: &mut f64| *value = Scale(si).reported(kind, *value);
        let kinds: Vec<Quantity> = self.all().map(|signal| signal.quantity.quantity()).collect();
        self.extremes.clone_from(&outcome.extremes);
        self.times.iter_mut().for_each(|t| told(Quantity::Time, t));
        self.extremes.iter_mut().zip(&kinds).for_each(|((t, value), kind)| {
            told(Quantity::Time, t);
            told(*kind, value);
        });
        self.values.iter_mut().zip(kinds.iter().cycle()).for_each(|(value, kind)| told(*kind, value));
        self
    }

    /// All signals: by quantity in the order of the selection, then by place.
    fn all(&self) -> impl Iterator<Item = Signal<'_>> {
        let each = |quantity| self.selection.places(quantity).iter().map(move |place| (quantity, *place));
        let named = self.selection.quantities.iter().flat_map(move |quantity| each(*quantity));
        named.enumerate().map(|(column, (quantity, place))| Signal { quantity, place, column, of: self })
    }

    /// By quantity: its places and the largest value at each, by modulus, with its time; of forces
    /// also width and length, as arrays of JSON.
    pub(super) fn summary(&self) -> Value {
        let mut all = Map::new();
        for &quantity in &self.selection.quantities {
            let signals: Vec<Signal<'_>> = self.all().filter(|signal| signal.quantity == quantity).collect();
            let peaks: Vec<Peak> = signals.iter().map(Signal::largest).collect();
            let numbers = |of: fn(&Peak) -> f64| peaks.iter().map(of).collect::<Vec<_>>();
            let places = self.selection.places(quantity);
            let (largest, t_largest) = (numbers(|peak| peak.value), numbers(|peak| peak.t));
            let mut one = json!({"places": places, "largest": largest, "t_largest": t_largest});
            if quantity.is_force() {
                one["width"] = json!(numbers(|peak| peak.width));
                // From the place before to the place after; at the ends from or to the place
                // itself.
                let length = |k: usize| {
                    let (from, to) = (k.saturating_sub(1), (k + 1).min(peaks.len() - 1));
                    let bonds = signals[to].place.abs_diff(signals[from].place) as f64;
                    let length = peaks[k].width * bonds / (peaks[to].t - peaks[from].t).abs();
                    if length.is_finite() { length } else { f64::NAN }
                };
                one["length"] = json!((0..peaks.len()).map(length).collect::<Vec<_>>());
            }
            all.insert(quantity.name().to_owned(), one);
        }
        Value::Object(all)
    }

    /// A line for each quantity: its largest value of all places.
    pub(super) fn lines(&self, si: bool) -> Vec<String> {
        let line = |quantity: &Recorded| {
            let signals = || self.all().filter(|signal| signal.quantity == *quantity);
            let of = signals().map(|signal| (signal.place, signal.largest()));
            let (place, peak) = of.reduce(|a, b| if b.1.value.abs() > a.1.value.abs() { b } else { a })?;
            let (what, unit) = (if quantity.of_bonds() { "bond" } else { "site" }, quantity.quantity().unit());
            let unit = if si { format!(" {unit}") } else { String::new() };
            let (name, value, t) = (quantity.name(), peak.value, peak.t);
            Some(format!(
                "recorded    {name} ({what}s {}): largest {value:.6e}{unit} at {what} {place}, t = {t:.6e}",
                signals().count()
            ))
        };
        self.selection.quantities.iter().filter_map(line).collect()
    }

    /// The maxima of all forces, a row each: those of a signal in order of time.
    pub(super) fn peaks(&self) -> Table {
        let forces = self.all().filter(|signal| signal.quantity.is_force());
        let rows: Vec<_> =
            forces.flat_map(|one| one.maxima().into_iter().map(move |peak| (one.quantity, one.place, peak))).collect();
        Table::of("peaks", &rows)
            .col("quantity", Short, "", |row| row.0.name())
            .col("place", Short, "", |row| row.1)
            .col("t", Short, "", |row| row.2.t)
            .col("value", Short, "", |row| row.2.value)
            .col("width", Short, "", |row| row.2.width)
            .done()
    }

    /// Writes the archive: `t`, the numbers of `sites` and `bonds`, and an array for each quantity
    /// with a row for each time.
    pub(super) fn npz(&self, mut archive: NpzWriter<&mut File>) -> std::io::Result<()> {
        archive.vector("t", &self.times)?;
        let of = |bonds: bool| self.selection.quantities.iter().find(move |one| one.of_bonds() == bonds);
        for (name, quantity) in [("sites", of(false)), ("bonds", of(true))] {
            if let Some(quantity) = quantity {
                let places = self.selection.places(*quantity);
                archive.vector(name, &places.iter().map(|place| *place as f64).collect::<Vec<_>>())?;
            }
        }
        let (mut first, width) = (0, self.selection.width());
        for &quantity in &self.selection.quantities {
            let places = self.selection.places(quantity).len();
            archive.begin(quantity.name(), &[self.times.len() as u64, places as u64])?;
            self.values.chunks_exact(width).try_for_each(|row| archive.row(&row[first..first + places]))?;
            first += places;
        }
        archive.finish()
    }

    /// The signals as CSV, a column for each; none if they are too many numbers.
    pub(super) fn csv(&self) -> Option<Vec<u8>> {
        let names: Vec<String> = ["t".to_owned()].into_iter().chain(self.all().map(|signal| signal.name())).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let rows = self.times.iter().zip(self.values.chunks_exact(self.selection.width()));
        let rows = rows.map(|(t, row)| [*t].into_iter().chain(row.iter().copied()).collect());
        (self.values.len() <= MOST_IN_CSV).then(|| csv(&names, rows))
    }

    /// Each quantity over time, at up to eight of its places.
    pub(super) fn panels(&self, title: String, caption: String, si: Option<&Units>) -> Panels {
        let scale = Scale(si);
        let time = scale.label("time t", Quantity::Time);
        let panel = |&quantity: &Recorded| {
            let signals: Vec<Signal<'_>> = self.all().filter(|signal| signal.quantity == quantity).collect();
            let every = signals.len().div_ceil(LINES);
            let what = if quantity.of_bonds() { "bond" } else { "site" };
            let line = |one: &Signal<'_>| {
                Line::new(&format!("{what} {}", one.place), self.times.iter().copied().zip(one.values()))
            };
            let label = scale.label(quantity.words(), quantity.quantity());
            Panel::new(Kind::Time, [&time, &label], signals.iter().step_by(every).map(line).collect())
        };
        Panels::column(title, self.selection.quantities.iter().map(panel).collect(), caption)
    }
}

impl<'a> Signal<'a> {
    /// Its name in tables.
    fn name(&self) -> String {
        format!("{}_{}", self.quantity.name(), self.place)
    }

    /// Its values in time.
    fn values(&self) -> impl ExactSizeIterator<Item = f64> + Clone + use<'a> {
        let of = self.of;
        of.values.iter().skip(self.column).step_by(of.selection.width()).copied()
    }

    /// The largest value by modulus.
    fn largest(&self) -> Peak {
        let values: Vec<f64> = self.values().collect();
        let largest = (0..values.len()).reduce(|a, b| if values[b].abs() > values[a].abs() { b } else { a });
        let sampled = largest.map(|k| (self.peak(&values, k), values[k]));
        let (peak, sample) = sampled.unwrap_or((Peak { t: f64::NAN, value: f64::NAN, width: f64::NAN }, 0.0));
        // What was found also between steps, or a sample that is above it, by the error of the
        // method there.
        let found = self.of.extremes.get(self.column);
        let known = found.zip(largest).map(|(&(t, value), k)| {
            let above = sample.abs() > (1.0 + ROUNDING) * value.abs();
            if above { (self.of.times[k], sample) } else { (t, value) }
        });
        known.map_or(peak, |(t, value)| Peak { t, value, ..peak })
    }

    /// The maxima in order of time.
    fn maxima(&self) -> Vec<Peak> {
        let values: Vec<f64> = self.values().collect();
        let (low, high) = crate::numerics::extremes(values.iter().copied());
        let (mut found, mut rises, mut extreme) = (Vec::new(), false, 0);
        if high - low <= ROUNDING * high.abs().max(low.abs()) {
            return found;
        }
        for k in 1..values.len() {
            let ahead = if rises { values[k] - values[extreme] } else { values[extreme] - values[k] };
            if ahead > 0.0 {
                extreme = k;
            } else if -ahead > FALL * (high - low) {
                if rises {
                    found.push(self.peak(&values, extreme));
                }
                (rises, extreme) = (!rises, k);
            }
        }
        found
    }

    /// The extreme at the sample `k`, between its neighbours.
    fn peak(&self, values: &[f64], k: usize) -> Peak {
        let times = &self.of.times;
        let middle = values[0] + 0.5 * (values[k] - values[0]);
        let sign = if values[k] < middle { -1.0 } else { 1.0 };
        let below = |j: usize| sign * (values[j] - middle) < 0.0;
        // From the sample below the middle to its neighbour above.
        let crossing = |j: usize, above: usize| {
            times[j] + (times[above] - times[j]) * (middle - values[j]) / (values[above] - values[j])
        };
        let before = (0..k).rfind(|&j| below(j)).map(|j| crossing(j, j + 1));
        let after = (k + 1..values.len()).find(|&j| below(j)).map(|j| crossing(j, j - 1));
        let width = before.zip(after).filter(|_| (values[k] - values[0]).abs() > ROUNDING * values[k].abs());
        let width = width.map_or(f64::NAN, |(before, after)| after - before);
        let (mut t, mut value) = (times[k], values[k]);
        if k > 0 && k + 1 < values.len() {
            let (slope, bend) =
                (0.5 * (values[k + 1] - values[k - 1]), values[k + 1] - 2.0 * values[k] + values[k - 1]);
            let shift = -slope / bend;
            if shift.abs() <= 1.0 {
                t += shift * 0.5 * (times[k + 1] - times[k - 1]);
                value += 0.5 * slope * shift;
            }
        }
        Peak { t, value, width }
    }
}
