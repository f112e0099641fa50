//! The command line of hertzchain.

use std::process::ExitCode;

fn main() -> ExitCode {
    hertzchain::cli::main(std::env::args_os()).into()
}
