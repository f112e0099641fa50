//! `hertzchain study stability`.

use super::{Exit, args::StabilityChartsArgs, methods, print, progress_bar, scene};
use crate::{
    error::{Error, Result},
    experiments::{Chart, ChartOptions, Problem, charts},
    output::Folder,
    report,
    run::Method,
};
use std::process::ExitCode;

pub(super) fn main(args: &StabilityChartsArgs) -> Exit {
    let problem = match &args.scene {
        Some(name) => Problem::of(&scene(name, &args.set)?)?,
        None => match args.set.set.first() {
            Some(change) => return Err(Error::parameter("set", change, "it changes a scene: name one")),
            None => Problem::built_in(),
        },
    };
    let charted = if args.charts.is_empty() {
        Chart::ALL.to_vec()
    } else {
        args.charts.iter().map(|name| Chart::named(name.trim())).collect::<Result<_>>()?
    };
    let methods = methods(&args.integrators, Method::all)?;
    let StabilityChartsArgs { sites, periods, work, quick, .. } = *args;
    let options = ChartOptions { charts: charted, methods, sites, periods, work, quick };
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    let bar = progress_bar();
    let study = charts(&problem, &options, folder.as_ref(), &|done, total| bar.set_position(1000 * done / total));
    bar.finish_and_clear();
    let study = study?;
    let json = report::charts_json(&study);
    print(&if args.json { json.clone() + "\n" } else { report::charts_table(&study) });
    if let Some(folder) = folder {
        folder.write("stability.json", json.as_bytes())?;
        for (name, csv) in report::charts_csv(&study) {
            folder.write(&name, &csv)?;
        }
        #[cfg(feature = "plot")]
        for (name, png) in report::charts_pictures(&study)? {
            folder.write(&name, &png)?;
        }
        eprintln!("written to {}", folder.path().display());
    }
    Ok(ExitCode::SUCCESS)
}
