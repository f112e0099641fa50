//! `hertzchain compare`.

use super::{Exit, args::CompareArgs, methods, print, progress_bar, scene, signals};
use crate::{
    experiments::{CompareOptions, compare},
    output::Folder,
    report,
    run::Method,
};
use std::process::ExitCode;

pub(super) fn main(args: &CompareArgs) -> Exit {
    let scene = scene(&args.scene, &args.set)?;
    let methods = methods(&args.integrators, Method::telling)?;
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    signals::ask()?;
    let bar = progress_bar();
    let options = CompareOptions { methods, max_time: args.max_time };
    let comparison = compare(&scene, &options, &|share, what| {
        bar.set_position((1000.0 * share.min(1.0)) as u64);
        bar.set_message(what.to_owned());
    });
    bar.finish_and_clear();
    let comparison = comparison?;
    let json = report::comparison_json(&comparison);
    // Printed first: what was computed is not lost if a file cannot be written.
    print(&if args.json { json.clone() + "\n" } else { report::comparison_table(&comparison) });
    if let Some(folder) = folder {
        folder.write("compare.csv", &report::comparison_csv(&comparison))?;
        folder.write("compare.json", json.as_bytes())?;
        #[cfg(feature = "plot")]
        folder.write("compare.png", &report::comparison_png(&comparison)?)?;
        eprintln!("written to {}", folder.path().display());
    }
    Ok(ExitCode::SUCCESS)
}
