//! `hertzchain study order`.

use super::{Exit, args::OrderArgs, print, progress_bar};
use crate::{experiments::order, output::Folder, report};
use std::process::ExitCode;

pub(super) fn main(args: &OrderArgs) -> Exit {
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    let bar = progress_bar();
    let study = order(args.alpha, args.beads, &|share| bar.set_position((1000.0 * share) as u64));
    bar.finish_and_clear();
    let study = study?;
    let json = report::order_json(&study);
    print(&if args.json { json.clone() + "\n" } else { report::order_table(&study) });
    if let Some(folder) = folder {
        folder.write("order.csv", &report::order_csv(&study))?;
        folder.write("order.json", json.as_bytes())?;
        #[cfg(feature = "plot")]
        for (name, png) in report::order_pictures(&study)? {
            folder.write(name, &png)?;
        }
        eprintln!("written to {}", folder.path().display());
    }
    Ok(ExitCode::SUCCESS)
}
