//! `hertzchain study theorem`.

use super::{Exit, args::TheoremArgs, print, progress_bar, signals};
use crate::{
    error::{Error, Result},
    experiments::{Initial, RhoLaw, TheoremOptions, theorem},
    output::Folder,
    report,
};
use std::process::ExitCode;

pub(super) fn main(args: &TheoremArgs) -> Exit {
    let options = options(args)?;
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    signals::ask()?;
    let bar = progress_bar();
    let study = theorem(&options, folder.as_ref(), &|share| bar.set_position((1000.0 * share) as u64));
    bar.finish_and_clear();
    let study = study?;
    if study.missing > 0 {
        eprintln!("stopped by a signal: {} sizes of {} were not run", study.missing, study.missing + study.runs.len());
    }
    print(&if args.json { report::theorem_json(&study) + "\n" } else { report::theorem_table(&study) });
    if let Some(folder) = folder {
        report::theorem_files(&folder, &study)?;
        eprintln!("written to {}", folder.path().display());
    }
    Ok(if study.contradicts() { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

fn options(args: &TheoremArgs) -> Result<TheoremOptions> {
    let &TheoremArgs { alpha, horizon, initial, c_i, sites, .. } = args;
    if let (Some(seed), false) = (args.seed, initial == Initial::Generic || c_i > 0.0) {
        return Err(Error::parameter(
            "seed",
            seed,
            "a seed needs something random: --initial generic, or --c-i above 0",
        ));
    }
    let rho_law = RhoLaw::named(&args.rho_law)?;
    let given = TheoremOptions { alpha, horizon, rho_law, initial, c_i, sites, ..TheoremOptions::default() };
    let epsilons = if args.epsilons.is_empty() { given.epsilons.clone() } else { args.epsilons.clone() };
    Ok(TheoremOptions { epsilons, seed: args.seed.unwrap_or(given.seed), ..given })
}
