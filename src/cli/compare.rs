//! `hertzchain compare`.

use super::{Exit, args::CompareArgs, default_folder, print, progress_bar, signals};
use crate::{
    error::Result,
    experiments::{CompareOptions, compare},
    output::Folder,
    report,
    run::method::Method,
    scene::Scene,
};
use std::process::ExitCode;

pub(super) fn main(args: &CompareArgs) -> Exit {
    let scene = Scene::load(&args.scene)?;
    let methods = match args.integrators.as_slice() {
        [] => Method::all(),
        names => names.iter().map(|name| Method::named(name.trim())).collect::<Result<_>>()?,
    };
    let folder = match &args.out {
        Some(path) => Some(Folder::create(path)?),
        None if args.json => None,
        None => Some(Folder::create(default_folder("compare", scene.name()))?),
    };
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
