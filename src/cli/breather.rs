//! `hertzchain breather bright` and `breather trivial`.

use super::{
    Exit,
    args::{BrightArgs, TrivialArgs},
    print, progress_bar,
};
use crate::{
    breathers::BrightBreather,
    chain::Params,
    error::{Error, Result},
    experiments::{BreatherOptions, bright_breather, trivial_breather},
    output::Folder,
    report,
    run::method::Method,
    scene::{ChainSection, Initial, Record, Scene, SceneFile, Span},
};
use std::process::ExitCode;

/// The paper runs for 80 `T`.
const SLOW_PERIODS: f64 = 80.0;

pub(super) fn bright(args: &BrightArgs) -> Exit {
    let scene = bright_scene(args)?;
    let options = BreatherOptions { method: Method::named(&args.integrator)?, tolerance: args.tol };
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    let bar = progress_bar();
    let mut progress = |share: f64| bar.set_position((1000.0 * share) as u64);
    let study = bright_breather(&scene, &options, args.samples_per_period, &mut progress);
    bar.finish_and_clear();
    let study = study?;
    print(&if args.json { report::bright_json(&study) + "\n" } else { report::bright_table(&study) });
    if let Some(folder) = folder {
        report::bright_files(&folder, &study)?;
        eprintln!("written to {}", folder.path().display());
    }
    Ok(ExitCode::SUCCESS)
}

/// The scene that the flags say.
fn bright_scene(args: &BrightArgs) -> Result<Scene> {
    let &BrightArgs { center, boundary, epsilon, rho, alpha, kappa, sites, .. } = args;
    let until = match args.until {
        Some(until) => until,
        None => {
            let params = Params { alpha, kappa, rho };
            SLOW_PERIODS * BrightBreather::new(params, center, epsilon, sites)?.slow_period()
        }
    };
    Scene::build(SceneFile {
        name: "bright-breather".to_owned(),
        summary: "a long-lived bright breather, from a homoclinic solution of the stationary DpS equation".to_owned(),
        chain: ChainSection { sites, alpha, kappa, rho, boundary, precompression: 0.0 },
        initial: Initial::BrightBreather { center, epsilon },
        span: Span { periods: None, until: Some(until), period: None },
        method: None,
        record: Record::of(0),
    })
}

pub(super) fn trivial(args: &TrivialArgs) -> Exit {
    let scene = trivial_scene(args)?;
    let options = BreatherOptions { method: Method::named(&args.integrator)?, tolerance: args.tol };
    let folder = args.out.as_ref().map(Folder::create).transpose()?;
    let bar = progress_bar();
    let study = trivial_breather(&scene, &options, &mut |share| bar.set_position((1000.0 * share) as u64));
    bar.finish_and_clear();
    let study = study?;
    print(&if args.json { report::trivial_json(&study) + "\n" } else { report::trivial_table(&study) });
    if let Some(folder) = folder {
        report::trivial_files(&folder, &study)?;
        eprintln!("written to {}", folder.path().display());
    }
    Ok(ExitCode::SUCCESS)
}

/// The scene with what the flags change: each replaces what the scene says of the same thing in another way.
fn trivial_scene(args: &TrivialArgs) -> Result<Scene> {
    let mut scene = super::scene(&args.scene, &args.set)?;
    let changed = [args.gap, args.phase_step_over_pi].iter().any(Option::is_some)
        || [&args.amplitudes, &args.phases, &args.offsets, &args.means].iter().any(|list| !list.is_empty());
    if changed {
        let mut file = scene.file().clone();
        let Initial::TrivialBreather(section) = &mut file.initial else {
            return Err(Error::parameter("scene", scene.name(), "these flags need a scene of kind trivial-breather"));
        };
        let list = |values: &Vec<f64>| (!values.is_empty()).then(|| values.clone());
        if let Some(amplitudes) = list(&args.amplitudes) {
            file.chain.sites = amplitudes.len();
            (section.center, section.amplitude, section.decay) = (None, None, None);
            section.amplitudes = Some(amplitudes);
        }
        if args.phase_step_over_pi.is_some() || !args.phases.is_empty() {
            (section.phase_step_over_pi, section.phases) = (args.phase_step_over_pi, list(&args.phases));
        }
        if args.gap.is_some() || !args.offsets.is_empty() || !args.means.is_empty() {
            (section.gap, section.d, section.b) = (args.gap, list(&args.offsets), list(&args.means));
        }
        scene = Scene::build(file)?;
    }
    match args.until {
        Some(until) => scene.until(until),
        None => Ok(scene),
    }
}
