//! `hertzchain wave`.

use super::{Exit, args::WaveArgs, print, progress_bar};
use crate::{
    error::{Error, Result},
    experiments::{WaveOptions, wave},
    output::Folder,
    report,
    run::method::Method,
    scene::{Scene, Theory},
};
use std::process::ExitCode;

pub(super) fn main(args: &WaveArgs) -> Exit {
    let scene = scene(args)?;
    let options = WaveOptions {
        method: Method::named(&args.integrator)?,
        tolerance: args.tol,
        samples_per_period: args.samples_per_period,
        seeds: args.seeds,
    };
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    let bar = progress_bar();
    let study = wave(&scene, &options, &|done, total| bar.set_position(1000 * done / total));
    bar.finish_and_clear();
    let study = study?;
    print(&if args.json { report::wave_json(&study) + "\n" } else { report::wave_table(&study) });
    if let Some(folder) = folder {
        report::wave_files(&folder, &study)?;
        eprintln!("written to {}", folder.path().display());
    }
    Ok(ExitCode::SUCCESS)
}

/// The scene with what the flags change.
fn scene(args: &WaveArgs) -> Result<Scene> {
    let mut scene = super::scene(args.scene.as_deref().unwrap_or_default(), &args.set)?;
    if let Some(until) = args.until {
        scene = scene.until(until)?;
    }
    if args.zeta.is_none() && args.seed.is_none() {
        return Ok(scene);
    }
    let (zeta, seed) = match scene.theory() {
        Some(Theory::PerturbedWave(own)) => (own.zeta(), Some(own.seed())),
        _ => (0.0, None),
    };
    match (args.zeta, args.seed) {
        (Some(0.0), Some(seed)) => {
            Err(Error::parameter("seed", seed, "a seed needs a perturbation: give zeta above 0"))
        }
        (Some(0.0), None) => scene.perturbed(0.0, None),
        (zeta_given, seed_given) => scene.perturbed(zeta_given.unwrap_or(zeta), seed_given.or(seed)),
    }
}
