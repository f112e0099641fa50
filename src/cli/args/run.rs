//! Flags of a run.

use crate::study::{Changes, MethodRequest, ResultUnits};
use clap::Args;
use std::path::PathBuf;

#[derive(Args)]
pub(crate) struct RunArgs {
    /// Name of a built-in scene, or a TOML file.
    #[arg(required_unless_present = "resume")]
    pub(crate) scene: Option<String>,
    #[command(flatten)]
    pub(crate) set: Changes,
    #[command(flatten)]
    pub(crate) method: MethodRequest,
    /// Measure by what factor a small change of the initial state has grown at the end.
    ///
    /// A second run begins from a state that is changed by the tolerance (1e-10 for equal steps, at
    /// least 1e-12), relative to the size of the state. The error at the end is at most about the
    /// tolerance times this factor.
    #[arg(long, hide_short_help = true, conflicts_with_all = ["checkpoint", "resume", "plan"])]
    pub(crate) amplification: bool,
    /// End time, in units of time [default: the scene's].
    ///
    /// In seconds for scenes with `[units]`. From 1e-100 to 1e100.
    #[arg(long, value_name = "T")]
    pub(crate) until: Option<f64>,
    /// Number of sample times [default: the scene's].
    ///
    /// Equally spaced times at which energy and strains are kept, up to 10^6. With 0 they are kept
    /// at the end only.
    #[arg(long, value_name = "K")]
    pub(crate) samples: Option<usize>,
    /// Record every contact, from its onset to its release.
    ///
    /// Onset, release, speeds, largest overlap and largest force with their times, and impulse. The
    /// summary has totals, and the speed and force of the pulse that runs over most bonds, walls
    /// not among them; with --out the contacts are in contacts.csv, contacts.npz and contacts.png,
    /// and a line for each bond in bonds.csv.
    #[arg(long)]
    pub(crate) events: bool,
    /// Record every crossing of a value, such as "u[10] = 0.5".
    ///
    /// "q[n] > c" is met where q rises through c, "q[n] < c" where it falls, "q[n] = c" at both. q
    /// is u, v, u_dot or v_dot of site n (strains and their rates on a strain ring), or overlap of
    /// bond n, which lies to the left of site n. c is in SI units for scenes with `[units]`. With
    /// --out the crossings are in crossings.csv. Not with --checkpoint or --resume, nor for an
    /// exact solution.
    #[arg(long, value_name = "COND", hide_short_help = true, conflicts_with_all = ["checkpoint", "resume"])]
    pub(crate) crossings: Vec<String>,
    /// End the run where this is met, such as "u[10] > 0.5"; as --crossings.
    ///
    /// Also not with --amplification.
    #[arg(long, value_name = "COND", hide_short_help = true, conflicts_with_all = ["checkpoint", "resume", "amplification"])]
    pub(crate) stop: Vec<String>,
    #[command(flatten)]
    pub(crate) results: ResultUnits,
    /// Threads that move the chain.
    ///
    /// For splitting schemes and collocation on long chains, with the bits of one thread. By
    /// splitting schemes each moves neighbouring sites; without it they take one thread. Collocation
    /// takes at most so many; without it, all that there are. With --resume any number, whatever it
    /// was before. From 1 to 1024.
    #[arg(long, value_name = "P")]
    pub(crate) threads: Option<usize>,
    /// Say what this scene needs and what is left out, and stop.
    #[arg(long)]
    pub(crate) plan: bool,
    /// Write the results to this folder.
    ///
    /// Files: summary.json, scene.toml, final.csv, energy.csv, profiles.npz, profiles.csv and
    /// pictures. What an earlier run has left of its files is removed.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Save a checkpoint after every D units of time, as checkpoint.npz.
    ///
    /// Seconds for scenes with `[units]`. The file is in the folder of --out. A run that was
    /// stopped continues with --resume and ends with the same bits. The method starts anew after
    /// every checkpoint. Finite and positive; a run has at most 10^6 checkpoints.
    #[arg(long, value_name = "D", requires = "out")]
    pub(crate) checkpoint: Option<f64>,
    /// Go on with what this file, or the file in this folder, has kept.
    ///
    /// A file checkpoint.npz; the results are written beside it. A scene or an integrator given
    /// with it must be its own.
    #[arg(long, value_name = "PATH", conflicts_with_all = ["checkpoint", "steps_per_period", "step", "tol", "windows_per_period", "nodes", "until", "samples", "set", "out", "plan"])]
    pub(crate) resume: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) formats: super::super::formats::Formats,
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

pub(super) const RUN_EXAMPLES: &str = "\
Examples:
  hertzchain run tw-q15 --tol 1e-9 --out out/tw-q15
  hertzchain run tw-rho3 --set chain.rho=5 --until 100
  hertzchain run cradle --integrator dop853-regularised --events

In legs that are kept, and gone on with:
  hertzchain run tw-q15 --checkpoint 10 --out out/tw
  hertzchain run --resume out/tw

A long chain on two threads:
  hertzchain run impact --set chain.sites=2000000 --integrator verlet --until 1 --threads 2
  hertzchain run impact --set chain.sites=2000000 --tol 1e-6 --until 1 --threads 2";
