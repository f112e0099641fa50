//! `hertzchain study drift`.

use super::{Exit, args::DriftArgs, methods, print, progress_bar, scene};
use crate::{
    experiments::{DriftOptions, drift},
    output::Folder,
    report,
    run::Method,
};
use std::process::ExitCode;

pub(super) fn main(args: &DriftArgs) -> Exit {
    let scene = scene(&args.scene, &args.set)?;
    let methods = methods(&args.integrators, Method::all)?;
    let options = DriftOptions { methods, periods: args.periods, samples: args.samples };
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    let bar = progress_bar();
    let study = drift(&scene, &options, &mut |share, what| {
        bar.set_position((1000.0 * share.min(1.0)) as u64);
        bar.set_message(what.to_owned());
    });
    bar.finish_and_clear();
    let study = study?;
    let json = report::drift_json(&study);
    print(&if args.json { json.clone() + "\n" } else { report::drift_table(&study) });
    if let Some(folder) = folder {
        folder.write("drift.csv", &report::drift_csv(&study))?;
        folder.write("drift.json", json.as_bytes())?;
        #[cfg(feature = "plot")]
        folder.write("drift.png", &report::drift_png(&study)?)?;
        eprintln!("written to {}", folder.path().display());
    }
    Ok(ExitCode::SUCCESS)
}
