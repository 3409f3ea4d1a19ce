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
mod run;
mod spectrum;
pub mod tracker;

use crate::live;
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
        ("bake", schema::<bake::Report>),
        ("inspect", schema::<inspect::Report>),
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
        ("tracker list", schema::<tracker::list::Report>),
        ("tracker monitor", schema::<tracker::sample::Record>),
        ("tracker record", schema::<tracker::record::Report>),
        ("tracker calibrate", schema::<tracker::calibrate::Report>),
        ("tracker mock", schema::<tracker::sample::Record>),
        ("tracker replay", schema::<tracker::sample::Record>),
    ];

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
    use program::{Request, read, sections};
    use serde_json::Value;
    use std::iter;

    /// The names of all commands but those of other programs, with their arguments.
    fn commands(command: &Command, names: &str) -> Vec<(String, Vec<Arg>)> {
        let within = command.get_subcommands().filter(|one| {
            let elsewhere = ["bench", "selftest", "tradeoff", "firmware"];
            !elsewhere.contains(&one.get_name())
        });
        let within = within.flat_map(|one| {
            let names = format!("{names} {}", one.get_name());
            commands(one, names.trim())
        });
        let own = command.get_arguments().cloned().collect();
        iter::once((names.to_owned(), own)).chain(within).collect()
    }

    #[test]
    fn errors_of_values_are_in_our_own_words() {
        let mut count = 0;
        for (names, arguments) in commands(&Shisen::command(), "") {
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

    /// Splits a line as a shell does, up to a redirection.
    fn words(line: &str) -> Vec<&str> {
        let parts = line.split('\'').enumerate();
        let words = parts.flat_map(|(number, part)| match number % 2 {
            1 => vec![part],
            _ => part.split_whitespace().collect(),
        });
        words
            .take_while(|word| !matches!(*word, "<" | ">"))
            .collect()
    }

    #[cfg(unix)]
    #[test]
    fn every_command_has_three_examples_that_it_takes() {
        let mut given: Vec<_> = sections(Shisen::EXAMPLES).collect();
        given.sort_unstable();
        let mut there = commands(&Shisen::command(), "");
        there.sort_unstable_by(|a, b| a.0.cmp(&b.0));
        assert_eq!(given.len(), there.len());
        for ((names, section), (command, _)) in given.into_iter().zip(there) {
            assert_eq!(names, command);
            let lines = section.lines().take_while(|line| !line.is_empty());
            let lines: Vec<_> = lines.collect();
            assert_eq!(lines.len(), 6, "{names}");
            for pair in lines.chunks(2) {
                assert!(
                    pair[0].starts_with("  ") && pair[0].ends_with(':'),
                    "{pair:?}"
                );
                let line = pair[1].trim_start();
                assert!(
                    line.starts_with(format!("shisen {names}").trim_end()),
                    "{line}"
                );
                let parsed = read::<Shisen>(words(line));
                assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
            }
        }
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

    /// All properties of a schema, with what describes them.
    fn properties(schema: &Value, found: &mut Vec<(String, bool)>) {
        if let Some(own) = schema.get("properties").and_then(Value::as_object) {
            for (key, value) in own {
                let is_tag = value.get("const").is_some();
                found.push((key.clone(), is_tag || value.get("description").is_some()));
            }
        }
        match schema {
            Value::Object(all) => all.values().for_each(|one| properties(one, found)),
            Value::Array(all) => all.iter().for_each(|one| properties(one, found)),
            _ => {}
        }
    }

    #[test]
    fn commands_with_json_describe_every_key() {
        for (names, arguments) in commands(&Shisen::command(), "") {
            let has_json = arguments.iter().any(|one| one.get_long() == Some("json"));
            if !has_json || (cfg!(not(unix)) && names.starts_with("tracker")) {
                continue;
            }
            let line = format!("shisen {names} --json-schema");
            let Ok(Request::Print(text)) = read::<Shisen>(line.split(' ')) else {
                panic!("{line}");
            };
            let schema = serde_json::from_str(&text).unwrap();
            let mut found = Vec::new();
            properties(&schema, &mut found);
            assert!(found.len() > 4, "{line}: {text}");
            found.retain(|(_, is_described)| !is_described);
            assert!(found.is_empty(), "{line}: {found:?}");
        }
    }
}
