//! The command line.

mod bench;
#[cfg(test)]
#[path = "../../src/cli/checks.rs"]
mod checks;
mod selftest;
mod tradeoff;

use bench::frames::WithFrames;
use clap::Parser;
use shisen::cli::output::failure::Failure;
use shisen::cli::program::{self, Examples, Program, Schemas, schema};
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
    const SCHEMAS: Schemas = &[
        ("bench rays", schema::<bench::rays::Report>),
        ("bench motion", schema::<bench::motion::Report>),
        ("bench table2", schema::<WithFrames<bench::table2::Report>>),
        ("bench sweep", schema::<WithFrames<bench::sweep::Report>>),
        ("bench fill", schema::<WithFrames<bench::fill::Report>>),
        (
            "bench foveated",
            schema::<WithFrames<bench::foveated::Report>>,
        ),
        ("bench spectrum", schema::<bench::spectrum::Report>),
        ("bench budget", schema::<bench::budget::Report>),
        #[cfg(unix)]
        ("bench latency", schema::<bench::latency::Report>),
        ("selftest", schema::<selftest::Report>),
        ("tradeoff", schema::<tradeoff::Written>),
    ];

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

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn every_command_has_three_examples_that_it_takes() {
        checks::every_command_has_three_examples_that_it_takes::<Evidence>(&[]);
    }

    #[test]
    fn commands_with_json_describe_every_key() {
        checks::commands_with_json_describe_every_key::<Evidence>(&[]);
    }
}
