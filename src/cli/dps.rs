//! `hertzchain dps`.

use super::{
    Exit,
    args::{DarkArgs, DpsAction, DpsArgs, HomoclinicArgs, IntegralsArgs, StabilityArgs},
    print, progress_bar,
};
use crate::{
    chain::Params,
    dps::{Averages, DarkProfile, Homoclinic},
    error::{Error, Result},
    experiments::{StabilityOptions, stability},
    output::Folder,
    report,
    scene::{Scene, Theory},
    waves::Shape,
};
use std::{f64::consts::PI, process::ExitCode};

pub(super) fn main(args: &DpsArgs) -> Exit {
    match &args.action {
        DpsAction::Integrals(args) => integrals(args),
        DpsAction::Homoclinic(args) => homoclinic(args),
        DpsAction::Dark(args) => dark(args),
        DpsAction::Stability(args) => wave_stability(args),
    }
}

fn homoclinic(args: &HomoclinicArgs) -> Exit {
    let one = Homoclinic::new(args.alpha, args.center.into())?;
    print(&if args.json { report::homoclinic_json(&one) + "\n" } else { report::homoclinic_table(&one) });
    Ok(ExitCode::SUCCESS)
}

fn dark(args: &DarkArgs) -> Exit {
    let &DarkArgs { sites, alpha, kappa, rho, c, .. } = args;
    let profile = DarkProfile::new(Params { alpha, kappa, rho }, args.center.into(), sites, c)?;
    let omega_b = args.omega_b.unwrap_or(1.005 * profile.params().omega());
    let json = report::dark_json(&profile, omega_b)?;
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    print(&if args.json { json.clone() + "\n" } else { report::dark_table(&profile, omega_b)? });
    if let Some(folder) = folder {
        folder.write("dark.csv", &report::dark_csv(&profile, omega_b)?)?;
        folder.write("dark.json", json.as_bytes())?;
        eprintln!("written to {}", folder.path().display());
    }
    Ok(ExitCode::SUCCESS)
}

fn integrals(args: &IntegralsArgs) -> Exit {
    let (averages, point) = (Averages::new(args.alpha, args.kappa)?, (args.b, args.r));
    let values = averages.checked(args.b, args.r)?;
    let json = || report::averages_json(&averages, point, &values) + "\n";
    print(&if args.json { json() } else { report::averages_table(&values) });
    Ok(ExitCode::SUCCESS)
}

fn wave_stability(args: &StabilityArgs) -> Exit {
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
fn options(args: &StabilityArgs) -> Result<StabilityOptions> {
    let &StabilityArgs { alpha, kappa, rho, a, b, q_over_pi, sites, measure, modes, chart, .. } = args;
    let modes = measure.then_some(modes);
    let Some(name) = &args.scene else {
        let shape = Shape { q: q_over_pi * PI, a, b, phi: 0.0 };
        let (params, epsilons) = (Params { alpha, kappa, rho }, args.epsilon.clone());
        return Ok(StabilityOptions { params, shape, epsilons, sites, modes, chart });
    };
    let scene = Scene::load(name)?;
    let Some(Theory::Wave(wave)) = scene.theory() else {
        return Err(Error::parameter("scene", name, "a scene that starts from a travelling wave"));
    };
    let (params, shape, epsilons) = (wave.params(), wave.shape(), vec![wave.epsilon()]);
    Ok(StabilityOptions { params, shape, epsilons, sites: scene.chain().sites(), modes, chart })
}
