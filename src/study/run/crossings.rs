//! Conditions that a run looks for, such as `u[10] > 0.5`, and their crossings.
//!
//! | symbol | meaning |
//! |---|---|
//! | `q[n] > c`, `q[n] < c`, `q[n] = c` | a quantity at site `n` rises through `c`, falls through it, or either |
//! | `q` | `u`, `v`, `u_dot`, `v_dot` of a site, `overlap` of a bond; `u`, `v` are strains on a strain ring |

use super::MethodChoice;
use crate::{
    chain::Chain,
    error::{Error, Result},
    output::csv,
    run::{Crossed, Observables, Run, Trajectory},
    scene::{Quantity, Recorded, Scene},
};
use hertzchain_integrators::Event;
use serde_json::{Value, json};

/// The quantities of conditions.
const QUANTITIES: [Recorded; 5] = [Recorded::U, Recorded::V, Recorded::UDot, Recorded::VDot, Recorded::Overlap];
const RULE: &str = "a quantity, its place, a sign and a number, as in \"u[10] > 0.5\" or \"overlap[3] = 0\"";

/// The flag of conditions that end a run, or do not.
fn flag(ends: bool) -> &'static str {
    if ends { "stop" } else { "crossings" }
}

/// A quantity of a site or bond, a value, and whether to cross it ends the run.
#[derive(Clone, Debug)]
pub struct Condition {
    text: String,
    quantity: Recorded,
    place: usize,
    value: f64,
    rising: Option<bool>,
    ends: bool,
}

impl Condition {
    /// Reads a condition in the units of a scene; bonds are counted so that the first one has the
    /// number `bonds`. `ends`: whether the run ends where it is met, as `stop` does.
    ///
    /// # Errors
    /// A text that is no condition; an unknown quantity; a place that the chain does not have.
    pub fn read(text: &str, scene: &Scene, bonds: usize, ends: bool) -> Result<Self> {
        let refused = |rule| Error::parameter(flag(ends), text, rule);
        let parts = || {
            let (left, right) = text.split_once(['<', '>', '='])?;
            let (name, place) = left.trim().strip_suffix(']')?.split_once('[')?;
            let value = right.trim().parse().ok().filter(|value: &f64| value.is_finite())?;
            Some((name.trim(), place.trim().parse::<usize>().ok()?, value))
        };
        let (name, place, value) = parts().ok_or_else(|| refused(RULE))?;
        let quantity = QUANTITIES.into_iter().find(|one| one.name() == name);
        let quantity = quantity.ok_or_else(|| Error::unknown("quantity", name, QUANTITIES.map(Recorded::name)))?;
        let chain = scene.chain();
        let (what, range, first) = match quantity.of_bonds() {
            true => ("bonds", chain.touching(), bonds),
            false => ("sites", 0..chain.sites(), 0),
        };
        let place = place.saturating_add(range.start - first);
        match quantity {
            _ if range.is_empty() => return Err(refused("no bond can touch here")),
            _ if !range.contains(&place) => {
                let value = format!("{text} of {what} {first} to {}", first + range.len() - 1);
                return Err(Error::parameter(flag(ends), value, "there is no such place"));
            }
            Recorded::V | Recorded::VDot if !chain.resonator_moves(place) => {
                return Err(refused("no resonator moves there"));
            }
            _ => {}
        }
        let rising = [('>', true), ('<', false)].into_iter().find(|(sign, _)| text.contains(*sign)).map(|one| one.1);
        let value = scene.of_file(quantity.quantity(), value);
        Ok(Self { text: text.to_owned(), quantity, place, value, rising, ends })
    }

    /// Refuses an exact solution, in which nothing is looked for.
    ///
    /// # Errors
    /// As [`MethodChoice::logs`].
    pub fn found_by(&self, how: &MethodChoice) -> Result<()> {
        how.logs(flag(self.ends), &self.text)
    }

    /// As it was given.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The quantity minus the value, at a state.
    fn excess(&self, chain: &Chain<f64>) -> impl Fn(&[f64]) -> f64 + Send + Sync + use<> {
        let (place, value, layout) = (self.place, self.value, chain.layout());
        let array = [Recorded::U, Recorded::V, Recorded::UDot, Recorded::VDot].iter().position(|q| *q == self.quantity);
        // The overlap of a bond is that of the chain at rest plus the difference of displacements.
        let entries = match array {
            Some(array) => [Some(layout.entry(array, place)), None],
            None => chain.topology().ends(place),
        };
        let rest = if array.is_some() { 0.0 } else { chain.overlaps(&vec![0.0; chain.sites()])[place] };
        move |y| {
            let [plus, minus] = entries.map(|entry| entry.map_or(0.0, |entry| y[entry]));
            rest - value + (plus - minus)
        }
    }
}

/// A run that looks for conditions. `told` is called with each crossing and the state there, and
/// ends the run if it returns true.
pub fn with_conditions(
    run: Run,
    conditions: &[Condition],
    told: impl Fn(&Event<f64>, &[f64]) -> bool + Send + Sync + 'static,
) -> Run {
    if conditions.is_empty() {
        return run;
    }
    let excess: Vec<_> = conditions.iter().map(|one| one.excess(run.chain())).collect();
    let wanted: Vec<_> = conditions.iter().map(|one| (one.rising, one.ends)).collect();
    let functions = Observables::new(move |y, to| to.extend(excess.iter().map(|excess| excess(y))));
    let moves = |one: &Condition| usize::from(one.quantity.quantity() == Quantity::Velocity);
    let functions = functions.of_kinds(conditions.iter().map(moves).collect::<Vec<_>>());
    run.crossings(functions, move |event, y| match wanted[event.index] {
        (Some(rising), _) if rising != event.rising => Crossed::Passed,
        (_, ends) if told(event, y) || ends => Crossed::Ends,
        _ => Crossed::Kept,
    })
}

/// The condition that has ended a run, of one that did not fail.
pub(super) fn ended<'a>(conditions: &'a [Condition], outcome: &Trajectory) -> Option<&'a Condition> {
    let last = outcome.crossings.last().filter(|last| last.t == outcome.t)?;
    Some(&conditions[last.index]).filter(|condition| condition.ends)
}

/// The times at which each condition was met.
fn times<'a>(conditions: &'a [Condition], outcome: &Trajectory) -> impl Iterator<Item = (&'a str, Vec<f64>)> {
    let of = |k: usize| outcome.crossings.iter().filter(move |one| one.index == k).map(|one| one.t);
    conditions.iter().enumerate().map(move |(k, condition)| (condition.text(), of(k).collect()))
}

/// Of each condition its text, the number of its crossings, and the times of the first and the
/// last.
pub(super) fn crossing_totals(conditions: &[Condition], outcome: &Trajectory) -> Value {
    let total = |(text, t): (&str, Vec<f64>)| json!({"condition": text, "count": t.len(), "first": t.first(), "last": t.last()});
    times(conditions, outcome).map(total).collect()
}

pub(super) fn crossing_lines(conditions: &[Condition], outcome: &Trajectory) -> Vec<String> {
    let line = |(text, t): (&str, Vec<f64>)| {
        let first = t.first().map_or(String::new(), |t| format!(", the first at t = {t:.9e}"));
        format!("crossings   {text}: {}{first}", t.len())
    };
    let ended = ended(conditions, outcome).map(|one| format!("ended       by {}", one.text));
    times(conditions, outcome).map(line).chain(ended).collect()
}

/// The crossings as CSV, in order of time.
pub(super) fn crossings_csv(outcome: &Trajectory) -> Vec<u8> {
    let row = |one: &Event<f64>| vec![one.index as f64, one.t, f64::from(u8::from(one.rising))];
    csv(&["condition", "t", "rising"], outcome.crossings.iter().map(row))
}
