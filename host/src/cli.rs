//! The command line: arguments in, one report or one error out.
//!
//! Standard output carries the report, standard error everything else. The exit code is 0 for
//! success, 1 for a failure and 2 for a wrong command line.
//!
//! Nothing else in the library uses this module. It is public for programs with commands of
//! their own that take the same arguments.

#![allow(
    missing_debug_implementations,
    missing_docs,
    clippy::missing_errors_doc,
    reason = "parts of programs, whose errors are texts for their users"
)]

pub mod arguments;
mod bake;
mod cave;
#[cfg(test)]
mod checks;
mod completions;
mod dome;
mod explain;
mod gaze;
mod inspect;
mod medium;
pub mod numbers;
pub mod output;
pub mod play;
mod prelude;
pub mod program;
mod replay;
mod room;
mod run;
mod show;
mod spectrum;
mod test_pattern;
pub mod tracker;
mod web;

use crate::live;
use crate::outputs::OutputsReport;
use clap::Parser;
use clap::error::ErrorKind;
use output::failure::Failure;
use program::{Either, Examples, Program, Schemas, schema};
use std::process::ExitCode;

/// Renders what a viewer sees on the walls of a CAVE.
#[derive(Debug, Parser)]
#[command(name = "shisen", version, arg_required_else_help = true)]
enum Shisen {
    Cave(Box<cave::Arguments>),
    Run(Box<run::Arguments>),
    Replay(Box<replay::Arguments>),
    Show(show::Arguments),
    TestPattern(test_pattern::Arguments),
    Bake(bake::Arguments),
    Inspect(inspect::Arguments),
    Explain(Box<explain::Arguments>),
    Gaze(gaze::Arguments),
    Medium(medium::Arguments),
    Spectrum(spectrum::Arguments),
    #[command(subcommand)]
    Dome(dome::Dome),
    #[command(subcommand)]
    Room(room::Room),
    #[command(subcommand)]
    Tracker(Box<tracker::TrackerCommand>),
    Web(web::Arguments),
    Completions(completions::Arguments),
    /// Measures speed: see shisen-evidence
    Bench(Elsewhere),
    /// Tries the tracer on hard cases: see shisen-evidence
    Selftest(Elsewhere),
    /// Measures what accuracy costs: see shisen-evidence
    Tradeoff(Elsewhere),
    /// Runs the firmware in an emulator: see tests/firmware/run
    #[command(subcommand)]
    Firmware(Firmware),
}

#[derive(Debug, clap::Subcommand)]
enum Firmware {
    /// Runs it beside the host: see tests/firmware/run
    Run(Elsewhere),
}

/// Arguments for a command of another program.
#[derive(Debug, clap::Args)]
#[command(disable_help_flag = true)]
struct Elsewhere {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    words: Vec<String>,
}

impl Elsewhere {
    /// Fails with the command line of the program that has this command, and without a usage.
    fn run(&self, program: &str) -> Result<(), Failure> {
        let line = [&[program.to_owned()], &self.words[..]].concat().join(" ");
        let message = format!("another program has this command: {line}\n");
        let error = clap::Error::raw(ErrorKind::InvalidSubcommand, message);
        Err(Failure::Usage(Box::new(error)))
    }
}

impl Program for Shisen {
    const EXAMPLES: Examples = include_str!("cli/help.txt");
    const SCHEMAS: Schemas = &[
        (
            "cave",
            schema::<Either<cave::report::Report, cave::report::TrackedFrames>>,
        ),
        (
            "run",
            schema::<Either<run::report::Report, live::FrameRecord>>,
        ),
        ("replay", schema::<replay::report::Report>),
        ("show", schema::<OutputsReport>),
        (
            "test-pattern",
            schema::<Either<test_pattern::Report, test_pattern::List>>,
        ),
        ("bake", schema::<bake::Report>),
        (
            "inspect",
            schema::<Either<inspect::Report, inspect::Contents>>,
        ),
        ("explain", schema::<explain::report::Report>),
        ("gaze", schema::<gaze::Line<f64>>),
        ("medium", schema::<medium::Report>),
        ("spectrum", schema::<spectrum::Report>),
        ("dome design", schema::<dome::design::Report>),
        ("dome curve", schema::<dome::curve::Report>),
        ("dome map", schema::<dome::map::Report>),
        ("dome nearfield", schema::<dome::nearfield::Report>),
        ("dome render", schema::<dome::render::Report>),
        ("dome compare", schema::<dome::compare::Report>),
        ("dome warp", schema::<dome::warp::Report>),
        ("room measure", schema::<room::measure::Report>),
        ("room show", schema::<room::show::Report>),
        ("room import", schema::<room::import::Report>),
        ("tracker doctor", schema::<tracker::doctor::Report>),
        ("tracker list", schema::<tracker::list::Report>),
        ("tracker monitor", schema::<tracker::sample::Record>),
        ("tracker record", schema::<tracker::record::Report>),
        ("tracker calibrate", schema::<tracker::calibrate::Report>),
    ];

    fn run(&self) -> Result<(), Failure> {
        match self {
            Self::Cave(arguments) => cave::run(arguments),
            Self::Run(arguments) => run::run(arguments),
            Self::Replay(arguments) => replay::run(arguments),
            Self::Show(arguments) => show::run(arguments),
            Self::TestPattern(arguments) => test_pattern::run(arguments),
            Self::Bake(arguments) => bake::run(arguments),
            Self::Inspect(arguments) => inspect::run(arguments),
            Self::Explain(arguments) => explain::run(arguments),
            Self::Gaze(arguments) => gaze::run(arguments),
            Self::Medium(arguments) => medium::run(arguments),
            Self::Spectrum(arguments) => spectrum::run(arguments),
            Self::Dome(dome) => dome::run(dome),
            Self::Room(room) => room::run(room),
            Self::Tracker(command) => tracker::run(command),
            Self::Web(arguments) => web::run(arguments),
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
    use checks::commands;
    use clap::{Arg, CommandFactory as _};
    use program::read;

    /// Commands of other programs.
    const ELSEWHERE: &[&str] = &["bench", "selftest", "tradeoff", "firmware"];

    #[test]
    fn errors_of_values_are_in_our_own_words() {
        let mut count = 0;
        for (names, arguments) in commands(&Shisen::command(), "", ELSEWHERE) {
            let values = arguments
                .iter()
                .filter(|one| one.get_action().takes_values());
            for long in values.filter_map(Arg::get_long) {
                for value in ["abc", "-1"] {
                    count += 1;
                    let line = format!("shisen {names} --{long} {value}");
                    let Err(error) = read::<Shisen>(line.split_whitespace()) else {
                        continue;
                    };
                    let error = error.to_string();
                    for library in ["invalid digit", "invalid float", "unexpected argument"] {
                        assert!(!error.contains(library), "{line}: {error}");
                    }
                }
            }
        }
        assert!(count > 300, "{count}");
    }

    #[cfg(unix)]
    #[test]
    fn every_command_has_three_examples_that_it_takes() {
        checks::every_command_has_three_examples_that_it_takes::<Shisen>(ELSEWHERE);
    }

    #[test]
    fn help_has_usage_options_examples_and_details_in_this_order() {
        let Err(help) = read::<Shisen>(["shisen", "tracker", "--help"]) else {
            panic!("it is no help");
        };
        let help = help.to_string();
        let parts = [
            "Usage:",
            "Eye and head",
            "Options:",
            "Examples:",
            "SPEC names",
            "usual value",
        ];
        let places: Vec<_> = parts.iter().map(|part| help.find(part)).collect();
        assert!(places[0] == Some(0) && places.is_sorted(), "{help}");
    }

    #[test]
    fn commands_with_json_describe_every_key() {
        checks::commands_with_json_describe_every_key::<Shisen>(ELSEWHERE);
    }
}
