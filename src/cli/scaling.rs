//! `hertzchain study scaling`.

use super::{Exit, args::ScalingArgs, print, progress_bar};
use crate::{
    experiments::{ScalingOptions, scaling},
    output::Folder,
    report,
};
use std::process::ExitCode;

pub(super) fn main(args: &ScalingArgs) -> Exit {
    let options = ScalingOptions { sites: args.sites.clone(), tol: args.tol, seed: args.seed, max_time: args.max_time };
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    let bar = progress_bar();
    let study = scaling(&options, &|share, what| {
        bar.set_position((1000.0 * share.min(1.0)) as u64);
        bar.set_message(what.to_owned());
    });
    bar.finish_and_clear();
    let study = study?;
    let json = report::scaling_json(&study);
    print(&if args.json { json.clone() + "\n" } else { report::scaling_table(&study) });
    if let Some(folder) = folder {
        folder.write("scaling.csv", &report::scaling_csv(&study))?;
        folder.write("scaling.json", json.as_bytes())?;
        #[cfg(feature = "plot")]
        folder.write("scaling.png", &report::scaling_png(&study)?)?;
        eprintln!("written to {}", folder.path().display());
    }
    Ok(ExitCode::SUCCESS)
}
