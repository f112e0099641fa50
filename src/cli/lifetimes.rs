//! `hertzchain study lifetimes`.

use super::{Exit, args::LifetimesArgs, print, progress_bar, signals};
use crate::{
    experiments::{LifetimeOptions, lifetimes},
    output::Folder,
    report,
    run::method::Method,
};
use std::process::ExitCode;

/// Of a whole run.
const TOLERANCE: f64 = 1e-9;

pub(super) fn main(args: &LifetimesArgs) -> Exit {
    let options = LifetimeOptions {
        alpha: args.alpha,
        center: args.center,
        criterion: args.criterion,
        epsilons: args.epsilons.clone(),
        rhos: args.rhos.clone(),
        sites: args.sites,
        until: args.until,
        method: Method::Collocation,
        tolerance: TOLERANCE,
    };
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    signals::ask()?;
    let bar = progress_bar();
    let study = lifetimes(&options, folder.as_ref(), &|done, total| bar.set_position(1000 * done / total));
    bar.finish_and_clear();
    let study = study?;
    print(&if args.json { report::lifetimes_json_with_work(&study) + "\n" } else { report::lifetimes_table(&study) });
    if let Some(folder) = folder {
        report::lifetimes_files(&folder, &study)?;
        eprintln!("written to {}", folder.path().display());
    }
    Ok(ExitCode::SUCCESS)
}
