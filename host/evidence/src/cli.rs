//! The command line.

mod bench;
mod selftest;
mod tradeoff;

use clap::Parser;
use shisen::cli::output::failure::Failure;
use shisen::cli::program::{self, Examples, Program};
use std::process::ExitCode;

/// Measures Shisen: how fast, how right, and what accuracy costs.
#[derive(Debug, Parser)]
#[command(name = "shisen-evidence", version, arg_required_else_help = true)]
enum Evidence {
    #[command(subcommand)]
    Bench(bench::Bench),
    Selftest(selftest::Arguments),
    Tradeoff(tradeoff::Arguments),
}

impl Program for Evidence {
    const EXAMPLES: Examples = include_str!("cli/examples.txt");

    fn run(&self) -> Result<(), Failure> {
        match self {
            Self::Bench(bench) => bench::run(bench),
            Self::Selftest(arguments) => selftest::run(arguments),
            Self::Tradeoff(arguments) => tradeoff::run(arguments),
        }
    }
}

/// Runs the command that the process was started with.
pub fn main() -> ExitCode {
    program::main::<Evidence>()
}
