//! The command line: arguments in, one report or one error out.
//!
//! Standard output carries the report, standard error everything else. The
//! exit code is 0 where the command did what it was asked to, 1 where it
//! failed and 2 where it was asked for something that there is not.

mod arguments;
mod bake;
mod bench;
mod cave;
mod completions;
mod dispersion;
mod dome;
mod examples;
mod explain;
mod failure;
mod filling;
#[cfg(unix)]
mod firmware;
mod gaze;
mod inspect;
mod levels;
mod lod;
mod medium;
mod output;
mod picture_files;
mod play;
mod progress;
mod ray_counts;
mod room;
mod run;
mod selftest;
mod source;
mod spectrum;
mod tracing;
mod tracker;
mod tradeoff;

use clap::{Arg, Command, CommandFactory as _, FromArgMatches as _, Parser};
use failure::Failure;
use std::ffi::OsString;
use std::io::{self, IsTerminal};
use std::iter::successors;
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
    #[cfg(unix)]
    #[command(subcommand)]
    Firmware(firmware::Firmware),
    #[command(subcommand)]
    Bench(bench::Bench),
    Selftest(selftest::Arguments),
    Tradeoff(tradeoff::Arguments),
    Completions(completions::Arguments),
}

impl Shisen {
    /// What a command line asks for, and the names of the command, from the outermost on.
    fn read(
        words: impl IntoIterator<Item = impl Into<OsString> + Clone>,
    ) -> clap::error::Result<(Self, Vec<String>)> {
        let mut command = with_negative_numbers(examples::with_examples(Self::command()));
        let matches = command.try_get_matches_from_mut(words)?;
        let asked = Self::from_arg_matches(&matches).map_err(|error| error.format(&mut command))?;
        let names = successors(matches.subcommand(), |(_, rest)| rest.subcommand());
        Ok((asked, names.map(|(name, _)| name.to_owned()).collect()))
    }

    /// Does it.
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
            #[cfg(unix)]
            Self::Firmware(firmware) => firmware::run(firmware),
            Self::Bench(bench) => bench::run(bench),
            Self::Selftest(arguments) => selftest::run(arguments),
            Self::Tradeoff(arguments) => tradeoff::run(arguments),
            Self::Completions(arguments) => completions::run(arguments),
        }
    }
}

/// A command and all within it, whose arguments read a negative number as a value: what is
/// wrong with it is the argument's to say.
fn with_negative_numbers(command: Command) -> Command {
    let reads = |argument: Arg| {
        let has_value = argument.get_action().takes_values();
        argument.allow_negative_numbers(has_value)
    };
    command
        .mut_args(reads)
        .mut_subcommands(with_negative_numbers)
}

/// Runs the command that the process was started with.
pub(crate) fn main() -> ExitCode {
    // Wrapped lines are for people; whoever reads a log searches it.
    let wrap = io::stderr().is_terminal();
    // It fails only where a hook is set already, and none is.
    let _ = miette::set_hook(Box::new(move |_| {
        let options = miette::MietteHandlerOpts::new();
        Box::new(options.wrap_lines(wrap).break_words(false).build())
    }));
    let result = Shisen::read(std::env::args_os())
        .map_err(Failure::from_clap)
        .and_then(|(command, names)| command.run().map_err(|failure| failure.of(&names)));
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.print(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
                let Err(error) = Shisen::read(&line) else {
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
