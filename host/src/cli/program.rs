//! A program with commands: reads its command line, and completes its help.

use super::output::failure::Failure;
use super::output::{self, terminal_size};
use clap::builder::{Resettable, StyledStr};
use clap::{Arg, ArgAction, Command, Parser};
use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};
use std::env;
use std::ffi::OsString;
use std::io::{self, IsTerminal};
use std::iter::successors;
use std::process::ExitCode;

/// What helps end with. The section of a command begins with a line such as `# shisen cave`. It has
/// examples up to a blank line, then paragraphs for the long help.
pub type Examples = &'static str;

/// The schema of what each command prints with `--json`, by the command's names.
pub type Schemas = &'static [(&'static str, fn() -> Schema)];

/// The argument that prints a schema.
const SCHEMA: &str = "json-schema";

/// The order of a help.
const HELP: &str = "{usage-heading} {usage}\n\n{about-with-newline}\n{all-args}{after-help}";

/// The command line of a program.
pub trait Program: Parser {
    /// Examples for the help of its commands.
    const EXAMPLES: Examples;
    /// Schemas of the commands that print JSON.
    const SCHEMAS: Schemas = &[];

    /// Runs the command.
    fn run(&self) -> Result<(), Failure>;
}

/// What a command line asks for.
#[derive(Debug)]
pub enum Request<P> {
    /// Run a command, which has these names, the outermost first.
    Run(P, Vec<String>),
    /// Print a schema.
    Print(String),
}

/// One of two types, for the schema of a command that prints or writes both.
#[derive(JsonSchema)]
#[serde(untagged)]
#[allow(dead_code, reason = "only its schema is used")]
pub enum Either<A, B> {
    First(Box<A>),
    Second(Box<B>),
}

/// Returns the keys of a type, their types and their documentation.
pub fn schema<T: JsonSchema>() -> Schema {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    settings.into_generator().into_root_schema_for::<T>()
}

/// Reads a command line. The error is what is wrong with it, or the help that it asks for.
pub fn read<P: Program>(
    words: impl IntoIterator<Item = impl Into<OsString> + Clone>,
) -> clap::error::Result<Request<P>> {
    let mut command = with_conventions(with_examples(P::command(), P::EXAMPLES));
    for (names, _) in P::SCHEMAS {
        command = at(command, names, &mut |one| one.arg(schema_argument()));
    }
    let matches = command.try_get_matches_from_mut(words)?;
    let commands = successors(matches.subcommand(), |(_, rest)| rest.subcommand());
    let (names, arguments): (Vec<_>, Vec<_>) =
        commands.map(|(name, rest)| (name.to_owned(), rest)).unzip();
    let last = arguments.last();
    let asks = last.is_some_and(|last| matches!(last.try_get_one(SCHEMA), Ok(Some(true))));
    let path = names.join(" ");
    if let Some((_, schema)) = P::SCHEMAS.iter().find(|(names, _)| asks && *names == path) {
        return Ok(Request::Print(format!("{:#}", schema().as_value())));
    }
    let asked = P::from_arg_matches(&matches).map_err(|error| error.format(&mut command))?;
    Ok(Request::Run(asked, names))
}

/// Runs the command that the process was started with.
pub fn main<P: Program>() -> ExitCode {
    // Lines are wrapped for people; logs are searched.
    let is_terminal = io::stderr().is_terminal();
    let columns = terminal_size().map_or(80, |[columns, _]| columns.into());
    let colours = is_terminal && env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    let languages = ["LC_ALL", "LC_CTYPE", "LANG"];
    let language = languages.into_iter().find_map(|name| env::var(name).ok());
    let language = language.unwrap_or_default().to_uppercase();
    let unicode = language.replace('-', "").ends_with("UTF8");
    // Setting the hook fails only where one is set already, and none is.
    let _ = miette::set_hook(Box::new(move |_| {
        let options = miette::MietteHandlerOpts::new().terminal_links(false);
        let options = options.width(columns).color(colours).unicode(unicode);
        Box::new(options.wrap_lines(is_terminal).break_words(false).build())
    }));
    let result = read::<P>(env::args_os())
        .map_err(|error| Failure::Usage(Box::new(error)))
        .and_then(|request| match request {
            Request::Run(asked, names) => {
                let result = asked.run();
                result.map_err(|failure| failure.with_usage(P::command(), &names))
            }
            Request::Print(text) => output::print_text(&text),
        });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.print(),
    }
}

/// Alone on a command line, it stands for all arguments that the command requires.
fn schema_argument() -> Arg {
    Arg::new(SCHEMA)
        .long(SCHEMA)
        .action(ArgAction::SetTrue)
        .exclusive(true)
        .help("Print what --json prints as a JSON schema: keys, types, meanings")
}

/// Puts the usage first in every help. Lets every argument read a negative number as its value, so
/// that the argument says what is wrong with it.
fn with_conventions(command: Command) -> Command {
    let reads = |argument: Arg| {
        let has_value = argument.get_action().takes_values();
        argument.allow_negative_numbers(has_value)
    };
    let command = command.help_template(HELP).mut_args(reads);
    command.mut_subcommands(with_conventions)
}

/// Ends the help of each command with its section, and with what its long help has besides.
pub fn with_examples(command: Command, examples: Examples) -> Command {
    sections(examples).fold(command, |command, (names, section)| {
        let mut paragraphs = section.trim_end().split("\n\n");
        let text = format!("Examples:\n{}", paragraphs.next().unwrap_or_default());
        let words = |paragraph: &str| paragraph.split_whitespace().collect::<Vec<_>>().join(" ");
        let details: Vec<_> = paragraphs.map(words).collect();
        at(command, names, &mut |one| {
            let shown = |text: Option<&StyledStr>| text.map(ToString::to_string);
            let long = shown(one.get_long_about()).unwrap_or_default();
            let besides = long.split_once("\n\n");
            let besides = besides.map(|(_, besides)| besides.to_owned());
            let after = shown(one.get_after_long_help());
            let parts = [text.clone()].into_iter().chain(details.clone());
            let parts: Vec<_> = parts.chain(besides).chain(after).collect();
            let one = one.after_help(text.clone());
            let one = one.after_long_help(parts.join("\n\n"));
            one.long_about(Resettable::Reset)
        })
    })
}

/// Returns the names of each command that has a section, and the section.
pub fn sections(examples: Examples) -> impl Iterator<Item = (&'static str, &'static str)> {
    let sections = examples.trim_start_matches("# ").split("\n# ");
    let sections = sections.filter_map(|section| section.split_once('\n'));
    sections.map(|(line, text)| (line.split_once(' ').map_or("", |(_, names)| names), text))
}

/// Changes the command of the given names. Leaves out commands that this system does not have.
fn at(command: Command, names: &str, change: &mut dyn FnMut(Command) -> Command) -> Command {
    if names.is_empty() {
        return change(command);
    }
    let (name, rest) = names.split_once(' ').unwrap_or((names, ""));
    if command.find_subcommand(name).is_none() {
        return command;
    }
    command.mut_subcommand(name, |one| at(one, rest, change))
}
