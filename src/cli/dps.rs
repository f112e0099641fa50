//! `hertzchain dps`.

use super::{
    Exit,
    args::{DpsAction, DpsArgs, IntegralsArgs},
    print,
};
use crate::{dps::Averages, report};
use std::process::ExitCode;

pub(super) fn main(args: &DpsArgs) -> Exit {
    match &args.action {
        DpsAction::Integrals(args) => integrals(args),
    }
}

fn integrals(args: &IntegralsArgs) -> Exit {
    let values = Averages::new(args.alpha, args.kappa)?.checked(args.b, args.r)?;
    print(&if args.json { report::averages_json(&values) + "\n" } else { report::averages_table(&values) });
    Ok(ExitCode::SUCCESS)
}
