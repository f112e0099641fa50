//! Flags of `scenes` and `integrators`, and examples of `sweep`.

use clap::{Args, Subcommand};

#[derive(Args)]
pub(crate) struct ScenesArgs {
    #[command(subcommand)]
    pub(crate) action: Option<ScenesAction>,
    /// Print JSON instead of text.
    #[arg(long, global = true)]
    pub(crate) json: bool,
}

#[derive(Subcommand)]
pub(crate) enum ScenesAction {
    /// Print the TOML of a scene: a start for your own.
    #[command(after_long_help = "Example:\n  hertzchain scenes show tw-q15 > my-scene.toml")]
    Show {
        /// Name of a built-in scene, or a TOML file.
        name: String,
    },
    /// Print a scene with every key, each explained: a start for your own.
    #[command(after_long_help = "Example:\n  hertzchain scenes template > my-scene.toml")]
    Template,
}

pub(super) const SWEEP_EXAMPLES: &str = "\
Examples:
  hertzchain sweep --template > plan.toml
  hertzchain sweep plan.toml --out out/plan
  hertzchain sweep plan.toml --out out/plan --shard 2/8";

pub(super) const SCENES_EXAMPLES: &str = "\
Examples:
  hertzchain scenes
  hertzchain scenes show tw-q15
  hertzchain scenes template > my-scene.toml";

#[derive(Args)]
pub(crate) struct IntegratorsArgs {
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}
