//! The command line: arguments in, one report or one error out.
//!
//! Standard output carries the report, standard error everything else. The
//! exit code is 0 where the command did what it was asked to, 1 where it
//! failed and 2 where the command line is wrong.
//!
//! Nothing else in the library uses this module. It is public for programs with commands of
//! their own that take the same arguments.

#![allow(
    missing_debug_implementations,
    reason = "parts of programs, which nothing prints"
)]

pub mod arguments;
mod bake;
mod cave;
mod completions;
mod dome;
mod examples;
mod explain;
mod gaze;
mod inspect;
mod medium;
pub mod output;
pub mod play;
pub mod program;
mod run;
mod spectrum;
pub mod tracker;

use clap::Parser;
use output::failure::Failure;
use program::{Examples, Program};
use std::iter;
use std::process::ExitCode;

/// Renders what a viewer sees on the walls of a CAVE.
#[derive(Debug, Parser)]
#[command(name = "shisen", version, arg_required_else_help = true)]
enum Shisen {
    Cave(Box<cave::Arguments>),
    Run(Box<run::Arguments>),
    Bake(bake::Arguments),
    Inspect(inspect::Arguments),
    Explain(Box<explain::Arguments>),
    Gaze(gaze::Arguments),
    Medium(medium::Arguments),
    Spectrum(spectrum::Arguments),
    #[command(subcommand)]
    Dome(dome::Dome),
    #[command(subcommand)]
    Tracker(Box<tracker::TrackerCommand>),
    Completions(completions::Arguments),
    /// Measures speed: a command of shisen-evidence
    Bench(Elsewhere),
    /// Tries the tracer on hard cases: a command of shisen-evidence
    Selftest(Elsewhere),
    /// Measures what accuracy costs: a command of shisen-evidence
    Tradeoff(Elsewhere),
    /// Runs the firmware in an emulator: tests/firmware/run
    #[command(subcommand)]
    Firmware(Firmware),
}

#[derive(Debug, clap::Subcommand)]
enum Firmware {
    /// Runs it beside the host: tests/firmware/run
    Run(Elsewhere),
}

/// Words for a command of another program.
#[derive(Debug, clap::Args)]
#[command(disable_help_flag = true)]
struct Elsewhere {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    words: Vec<String>,
}

impl Elsewhere {
    /// Says that another program has this command: `program`, with the words that follow.
    fn run(&self, program: &str) -> Result<(), Failure> {
        let words = self.words.iter().map(String::as_str);
        let command_line: Vec<_> = iter::once(program).chain(words).collect();
        Err(Failure::usage(&format!(
            "this command is elsewhere: {}",
            command_line.join(" ")
        )))
    }
}

impl Program for Shisen {
    const EXAMPLES: Examples = examples::EXAMPLES;

    fn run(&self) -> Result<(), Failure> {
        match self {
            Self::Cave(arguments) => cave::run(arguments),
            Self::Run(arguments) => run::run(arguments),
            Self::Bake(arguments) => bake::run(arguments),
            Self::Inspect(arguments) => inspect::run(arguments),
            Self::Explain(arguments) => explain::run(arguments),
            Self::Gaze(arguments) => gaze::run(arguments),
            Self::Medium(arguments) => medium::run(arguments),
            Self::Spectrum(arguments) => spectrum::run(arguments),
            Self::Dome(dome) => dome::run(dome),
            Self::Tracker(command) => tracker::run(command),
            Self::Completions(arguments) => completions::run(arguments),
            Self::Bench(words) => words.run("cargo run --release -p shisen-evidence -- bench"),
            Self::Selftest(words) => {
                words.run("cargo run --release -p shisen-evidence -- selftest")
            }
            Self::Tradeoff(words) => {
                words.run("cargo run --release -p shisen-evidence -- tradeoff")
            }
            Self::Firmware(Firmware::Run(words)) => words.run("tests/firmware/run"),
        }
    }
}

/// Runs the command that the process was started with.
pub fn main() -> ExitCode {
    program::main::<Shisen>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Arg, Command, CommandFactory as _};

    /// For each argument of a command and of all within it, a line that gives it a value.
    fn lines(command: &Command, names: &[String], value: &str) -> Vec<Vec<String>> {
        let arguments = command.get_arguments();
        let with_value = arguments.filter(|argument| argument.get_action().takes_values());
        let own = with_value.filter_map(Arg::get_long).map(|long| {
            let words = [format!("--{long}"), value.to_owned()];
            [names, &words].concat()
        });
        let within = command.get_subcommands().flat_map(|one| {
            let names = [names, &[one.get_name().to_owned()]].concat();
            lines(one, &names, value)
        });
        own.chain(within).collect()
    }

    #[test]
    fn what_is_wrong_with_a_value_is_said_in_our_own_words() {
        let command = Shisen::command();
        for value in ["abc", "-1"] {
            let lines = lines(&command, &["shisen".to_owned()], value);
            assert!(lines.len() > 150, "{}", lines.len());
            for line in lines {
                let Err(error) = program::read::<Shisen>(&line) else {
                    continue;
                };
                let said = error.to_string();
                for others in ["invalid digit", "invalid float", "unexpected argument"] {
                    assert!(!said.contains(others), "{line:?}: {said}");
                }
            }
        }
    }
}
