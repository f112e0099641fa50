//! Runs whose contact law is a table: they fail once an overlap gets beyond its last row.

use super::{Observables, Run, extremes};
use crate::error::Result;
use hertzchain_integrators::{
    Error as Failure, Stepper,
    events::{Search, Searched},
};

/// A stepper of any method.
pub(super) type AnyStepper = Box<dyn Stepper<f64> + Send>;

/// The search of the steps of a run for the largest overlaps.
struct Within {
    overlaps: extremes::Search,
    bonds: Vec<usize>,
    last: f64,
}

/// The stepper of a run, searched if its contacts have a table.
///
/// # Errors
/// A state at the start with an overlap beyond the table.
pub(super) fn within(mut stepper: AnyStepper, run: &Run) -> Result<AnyStepper> {
    let chain = run.chain().clone();
    let Some(table) = chain.details().and_then(|details| details.table.clone()) else { return Ok(stepper) };
    let touches = |bond: &usize| chain.parts().is_some_and(|parts| parts.bonds[*bond].constant > 0.0);
    let bonds: Vec<usize> = chain.touching().filter(touches).collect();
    let searched = bonds.clone();
    let overlaps = Observables::new(move |y, values| {
        let overlaps = chain.overlaps(chain.layout().u(y));
        values.extend(searched.iter().map(|&bond| overlaps[bond].max(0.0)));
    });
    let overlaps = extremes::Search::new(&mut stepper, &overlaps, run.part(), Vec::new());
    let within = Within { overlaps, bonds, last: table.end() };
    within.check()?;
    Ok(Box::new(Searched::by(within, stepper).in_parts(run.part())))
}

impl Within {
    fn check(&self) -> std::result::Result<Option<f64>, Failure> {
        let Within { overlaps, bonds, last } = self;
        match overlaps.largest.iter().zip(bonds).find(|(found, _)| found.1 > *last) {
            Some((&(t, overlap), &bond)) => Err(Failure::BeyondLaw { t, bond, overlap, last: *last }),
            None => Ok(None),
        }
    }
}

impl Search<f64, AnyStepper> for Within {
    fn part(&mut self, stepper: &mut AnyStepper, part: (f64, f64)) -> std::result::Result<Option<f64>, Failure> {
        self.overlaps.search(stepper, part);
        self.check()
    }
}
