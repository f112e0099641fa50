//! Flags of what goes through the paper, and of lists.

use clap::{Args, Subcommand};
use std::path::PathBuf;

#[derive(Args)]
pub(crate) struct VerifyArgs {
    /// One section of the paper: 3, 4, 5, 6 or 7 [default: all].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) section: Option<u32>,
    /// Folder for verify.txt, verify.csv and verify.json [default: none is written].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct FiguresArgs {
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', help = figures_help())]
    pub(crate) only: Vec<String>,
    /// Folder for NAME.png, the tables NAME-….csv and NAME.json, which says what made them.
    #[arg(long, value_name = "DIR", default_value = "out/figures")]
    pub(crate) out: PathBuf,
    /// Print JSON instead of the table: name, source, title, files, caption, wall time.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct ReportArgs {
    /// Parts to make: compare, order, theorem, stability, verify, figures [default: all].
    #[arg(long, value_name = "A,B,..", value_delimiter = ',')]
    pub(crate) only: Vec<String>,
    /// Folder for report.html and report.json.
    #[arg(long, value_name = "DIR", default_value = "out/report")]
    pub(crate) out: PathBuf,
    /// Print JSON instead of the table: what was made, wall times, failures.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct ScenesArgs {
    #[command(subcommand)]
    pub(crate) action: Option<ScenesAction>,
    /// Print JSON instead of the table.
    #[arg(long, global = true)]
    pub(crate) json: bool,
}

#[derive(Subcommand)]
pub(crate) enum ScenesAction {
    /// Print the TOML of a scene: a start for your own.
    Show {
        /// Name of a built-in scene, or a TOML file.
        name: String,
    },
}

#[derive(Args)]
pub(crate) struct IntegratorsArgs {
    /// Print JSON instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Names the figures that there are.
fn figures_help() -> String {
    let names: Vec<_> = crate::experiments::PAPER.iter().map(|figure| figure.name).collect();
    format!("Figures, separated by commas, of {} [default: all]", names.join(", "))
}
