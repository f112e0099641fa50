//! `hertzchain wave modulation`.

use super::{Exit, args::ModulationArgs, print, progress_bar};
use crate::{
    chain::Params,
    error::{Error, Result},
    experiments::{StabilityOptions, stability},
    output::Folder,
    report,
    scene::Theory,
    waves::Shape,
};
use std::{f64::consts::PI, process::ExitCode};

pub(super) fn main(args: &ModulationArgs) -> Exit {
    let options = options(args)?;
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    let bar = progress_bar();
    let study = stability(&options, &|share, what| {
        bar.set_position((1000.0 * share.min(1.0)) as u64);
        bar.set_message(what.to_owned());
    });
    bar.finish_and_clear();
    let study = study?;
    let json = report::stability_json(&study);
    print(&if args.json { json.clone() + "\n" } else { report::stability_table(&study) });
    if let Some(folder) = folder {
        folder.write("stability.json", json.as_bytes())?;
        for (name, bytes) in report::stability_tables(&study) {
            folder.write(name, &bytes)?;
        }
        #[cfg(feature = "plot")]
        folder.write("dps-growth.png", &report::stability_png(&study)?)?;
        eprintln!("written to {}", folder.path().display());
    }
    Ok(ExitCode::SUCCESS)
}

/// The wave of a scene, or that of the flags.
fn options(args: &ModulationArgs) -> Result<StabilityOptions> {
    let &ModulationArgs { alpha, kappa, rho, a, b, q_over_pi, sites, measure, modes, chart, .. } = args;
    let modes = measure.then_some(modes);
    let Some(name) = &args.scene else {
        if let Some(change) = args.set.set.first() {
            return Err(Error::parameter("set", change, "it changes a scene: name one"));
        }
        let shape = Shape { q: q_over_pi * PI, a, b, phi: 0.0 };
        let (params, epsilons) = (Params { alpha, kappa, rho }, args.epsilon.clone());
        return Ok(StabilityOptions { params, shape, epsilons, sites, modes, chart });
    };
    let scene = super::scene(name, &args.set)?;
    let Some(Theory::Wave(wave)) = scene.theory() else {
        return Err(Error::parameter("scene", name, "a scene that starts from a travelling wave"));
    };
    let (params, shape, epsilons) = (wave.params(), wave.shape(), vec![wave.epsilon()]);
    Ok(StabilityOptions { params, shape, epsilons, sites: scene.chain().sites(), modes, chart })
}
