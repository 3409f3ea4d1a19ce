//! A program of commands: what its command line asks for is run, and its help has examples.

use super::output::failure::Failure;
use clap::{Arg, Command, Parser};
use std::ffi::OsString;
use std::io::{self, IsTerminal};
use std::iter::successors;
use std::process::ExitCode;

/// For each command, by the names that lead to it, its examples: purposes and command lines.
pub type Examples = &'static [(&'static str, &'static [(&'static str, &'static str)])];

/// The command line of a program.
pub trait Program: Parser {
    /// What the help of its commands ends with.
    const EXAMPLES: Examples;

    /// Does what the command line asks for.
    ///
    /// # Errors
    /// Why it cannot be done.
    fn run(&self) -> Result<(), Failure>;
}

/// Reads a command line: what it asks for, and the names of the command, from the outermost on.
///
/// # Errors
/// What is wrong with it, or the help that it asks for.
pub fn read<P: Program>(
    words: impl IntoIterator<Item = impl Into<OsString> + Clone>,
) -> clap::error::Result<(P, Vec<String>)> {
    let mut command = with_negative_numbers(with_examples(P::command(), P::EXAMPLES));
    let matches = command.try_get_matches_from_mut(words)?;
    let asked = P::from_arg_matches(&matches).map_err(|error| error.format(&mut command))?;
    let names = successors(matches.subcommand(), |(_, rest)| rest.subcommand());
    Ok((asked, names.map(|(name, _)| name.to_owned()).collect()))
}

/// Runs the command that the process was started with.
pub fn main<P: Program>() -> ExitCode {
    // Lines are wrapped for people; logs are searched.
    let wrap = io::stderr().is_terminal();
    // Setting the hook fails only where one is set already, and none is.
    let _ = miette::set_hook(Box::new(move |_| {
        let options = miette::MietteHandlerOpts::new();
        Box::new(options.wrap_lines(wrap).break_words(false).build())
    }));
    let result = read::<P>(std::env::args_os())
        .map_err(Failure::from_clap)
        .and_then(|(asked, names)| {
            let with_usage = |failure: Failure| failure.with_usage(P::command(), &names);
            asked.run().map_err(with_usage)
        });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.print(),
    }
}

/// Lets every argument of a command and of the commands in it read a negative number as a
/// value: what is wrong with it is the argument's to say.
fn with_negative_numbers(command: Command) -> Command {
    let reads = |argument: Arg| {
        let has_value = argument.get_action().takes_values();
        argument.allow_negative_numbers(has_value)
    };
    command
        .mut_args(reads)
        .mut_subcommands(with_negative_numbers)
}

/// Ends the help of each command with its examples.
pub fn with_examples(command: Command, examples: Examples) -> Command {
    examples.iter().fold(command, |command, (path, examples)| {
        let path: Vec<&str> = path.split_whitespace().collect();
        at(command, &path, &text(examples))
    })
}

/// The help of the command at a path ends with a text, after what it ends with already.
/// Commands that this system has not are left out.
fn at(command: Command, path: &[&str], text: &str) -> Command {
    match path.split_first() {
        None => match command.get_after_long_help().map(ToString::to_string) {
            Some(before) => command
                .after_help(text.to_owned())
                .after_long_help(format!("{before}\n\n{text}")),
            None => command.after_help(text.to_owned()),
        },
        Some((name, rest)) if command.find_subcommand(name).is_some() => {
            command.mut_subcommand(*name, |one| at(one, rest, text))
        }
        Some(_) => command,
    }
}

fn text(examples: &[(&str, &str)]) -> String {
    let lines = examples.iter();
    let lines = lines.map(|(purpose, line)| format!("\n  {purpose}:\n    {line}"));
    "Examples:".to_owned() + &lines.collect::<String>()
}
