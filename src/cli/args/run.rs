//! Flags of a run.

use crate::{
    cli::formats::Formats,
    study::{Changes, MethodRequest, ResultUnits, options},
};
use std::path::PathBuf;

options! {
    pub(crate) struct RunArgs {
        /// Name of a built-in scene, or a TOML file.
        scene: Option<String> = None, [required_unless_present = "resume"];
        set: Changes = Changes::default();
        method: MethodRequest = MethodRequest::default();
        /// Measure by what factor a small change of the initial state has grown at the end.
        ///
        /// A second run begins from a state that is changed by the tolerance (1e-10 for equal
        /// steps, at least 1e-12), relative to the size of the state. The error at the end is at
        /// most about the tolerance times this factor.
        amplification: bool = false, [hide_short_help = true, conflicts_with_all = ["checkpoint", "resume", "plan"]];
        /// End time, in units of time [default: the scene's].
        ///
        /// In seconds for scenes with `[units]`. From 1e-100 to 1e100.
        until: Option<f64> = None, "T";
        /// Number of sample times [default: the scene's].
        ///
        /// Equally spaced times at which energy and strains are kept, up to 10^6. With 0 they are
        /// kept at the end only.
        samples: Option<usize> = None, "K";
        /// Record every contact, from its onset to its release.
        ///
        /// Onset, release, speeds, largest overlap and largest force with their times, and impulse.
        /// The summary has totals, and the speed and force of the pulse that runs over most bonds,
        /// walls not among them; with --out the contacts are in contacts.csv, contacts.npz and
        /// contacts.png, and a line for each bond in bonds.csv.
        events: bool = false;
        /// Record every crossing of a value, such as "u[10] = 0.5".
        ///
        /// "q[n] > c" is met where q rises through c, "q[n] < c" where it falls, "q[n] = c" at
        /// both. q is u, v, u_dot or v_dot of site n (strains and their rates on a strain ring), or
        /// overlap of bond n, which lies to the left of site n. c is in SI units for scenes with
        /// `[units]`. With
        /// --out the crossings are in crossings.csv. Not with --checkpoint or --resume, nor for an
        /// exact solution.
        crossings: Vec<String> = vec![], "COND", [hide_short_help = true, conflicts_with_all = ["checkpoint", "resume"], value_delimiter = None::<char>];
        /// End the run where this is met, such as "u[10] > 0.5"; as --crossings.
        ///
        /// Also not with --amplification.
        stop: Vec<String> = vec![], "COND", [hide_short_help = true, conflicts_with_all = ["checkpoint", "resume", "amplification"], value_delimiter = None::<char>];
        results: ResultUnits = ResultUnits::default();
        /// Threads that move the chain.
        ///
        /// For splitting schemes and collocation on long chains, with the bits of one thread. By
        /// splitting schemes each moves neighbouring sites; without it they take one thread.
        /// Collocation takes at most so many; without it, all that there are. With --resume any
        /// number, whatever it was before. From 1 to 1024.
        threads: Option<usize> = None, "P";
        /// Say what this scene needs and what is left out, and stop.
        plan: bool = false;
        /// Write the results to this folder.
        ///
        /// Files: summary.json, scene.toml, final.csv, energy.csv, profiles.npz, profiles.csv and
        /// pictures. What an earlier run has left of its files is removed.
        out: Option<PathBuf> = None, "DIR";
        /// Save a checkpoint after every D units of time, as checkpoint.npz.
        ///
        /// Seconds for scenes with `[units]`. The file is in the folder of --out. A run that was
        /// stopped continues with --resume and ends with the same bits. The method starts anew
        /// after every checkpoint. Finite and positive; a run has at most 10^6 checkpoints.
        checkpoint: Option<f64> = None, "D", [requires = "out"];
        /// Go on with what this file, or the file in this folder, has kept.
        ///
        /// A file checkpoint.npz; the results are written beside it. A scene or an integrator given
        /// with it must be its own.
        resume: Option<PathBuf> = None, "PATH", [conflicts_with_all = ["checkpoint", "steps_per_period", "step", "tol", "windows_per_period", "nodes", "until", "samples", "set", "out", "plan"]];
        formats: Formats = Formats::default();
        /// Print JSON instead of text.
        json: bool = false;
    }
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
