//! The commands of `paper` and their flags.

use crate::{
    cli::runner::{EngineArgs, StudyCommand},
    paper::Verify,
};
use clap::{Args, Subcommand};
use std::path::PathBuf;

#[derive(Args)]
pub(crate) struct PaperArgs {
    #[command(subcommand)]
    pub(crate) action: PaperAction,
}

#[derive(Subcommand)]
pub(crate) enum PaperAction {
    /// Compute the figures of the paper: pictures, and their numbers as CSV.
    ///
    /// Files are what this command is for: without --out they go to out/figures.
    #[command(after_long_help = "\
Examples:
  hertzchain paper figures --only tw-q15,tw-rho3
  hertzchain paper figures --out out/all")]
    Figures(FiguresArgs),
    /// Compare every number in the text of the paper with ours.
    ///
    /// For every number in Sec. 2 to 8: what the paper says, what we get, the verdict, and why if
    /// they differ. Exit code 0: every verdict is the known one, and where the paper is known to
    /// differ our numbers have not changed. Exit code 1: a verdict or such a number is another one,
    /// or a run failed.
    #[command(after_long_help = "Example:\n  hertzchain paper verify --section 3 --out out/verify")]
    Verify(StudyCommand<Verify>),
    /// Run everything in its short form and write one HTML page.
    ///
    /// The page stands alone: tables, pictures, captions, the machine and the version. Files are
    /// what this command is for: without --out they go to out/report.
    #[command(after_long_help = "\
Examples:
  hertzchain paper report --out out/report
  hertzchain paper report --only compare,order")]
    Report(ReportArgs),
}

#[derive(Args)]
pub(crate) struct FiguresArgs {
    #[arg(
        long,
        value_name = "A,B,..",
        value_delimiter = ',',
        help = "Figures to make, separated by commas [default: all]",
        long_help = figures_help()
    )]
    pub(crate) only: Vec<String>,
    #[arg(
        long,
        value_name = "DIR",
        default_value = "out/figures",
        help = OUT_ALWAYS,
        long_help = format!("{OUT_ALWAYS}.\n\nFiles: NAME.png (or .svg, as --format says), the tables NAME-….csv, and NAME.json, which says what made them; figures.store, which keeps every finished figure for the next run.")
    )]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) spread: EngineArgs,
    #[cfg(feature = "plot")]
    #[command(flatten)]
    pub(crate) formats: super::super::formats::Formats,
    /// Print JSON instead of text.
    ///
    /// Name, source, title, files, caption and wall time of every figure.
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args)]
pub(crate) struct ReportArgs {
    /// Parts to make, separated by commas [default: all].
    ///
    /// Of compare, order, theorem, stability, verify, figures.
    #[arg(long, value_name = "A,B,..", value_delimiter = ',')]
    pub(crate) only: Vec<String>,
    #[arg(
        long,
        value_name = "DIR",
        default_value = "out/report",
        help = OUT_ALWAYS,
        long_help = format!("{OUT_ALWAYS}.\n\nFiles: report.html and report.json.")
    )]
    pub(crate) out: PathBuf,
    /// Print JSON instead of text.
    ///
    /// What was made, wall times and failures.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Help of `--out` for commands whose purpose is to write files; they have a default folder.
const OUT_ALWAYS: &str = "Write the results to this folder";

/// Long help of `--only`, with the names of all figures.
fn figures_help() -> String {
    let names: Vec<_> = crate::paper::FIGURES.iter().map(|figure| figure.name).collect();
    format!("Figures to make, separated by commas [default: all].\n\nOf {}.", names.join(", "))
}
