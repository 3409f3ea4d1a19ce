//! Checks of a program's help: `shisen` has them, and `shisen-evidence` likewise.

use super::program::{Program, Request, read, sections};
use clap::{Arg, Command};
use serde_json::Value;
use std::iter;

/// Lists the names of all commands but those named in `elsewhere`, with their arguments.
pub(super) fn commands(
    command: &Command,
    names: &str,
    elsewhere: &[&str],
) -> Vec<(String, Vec<Arg>)> {
    let within = command
        .get_subcommands()
        .filter(|one| !elsewhere.contains(&one.get_name()));
    let within = within.flat_map(|one| {
        let names = format!("{names} {}", one.get_name());
        commands(one, names.trim(), elsewhere)
    });
    let own = command.get_arguments().cloned().collect();
    iter::once((names.to_owned(), own)).chain(within).collect()
}

/// Splits a line as a shell does, up to a redirection.
#[cfg(unix)]
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
pub(super) fn every_command_has_three_examples_that_it_takes<P: Program>(elsewhere: &[&str]) {
    let command = P::command();
    let program = command.get_name();
    let mut given: Vec<_> = sections(P::EXAMPLES).collect();
    given.sort_unstable();
    let mut there = commands(&command, "", elsewhere);
    there.sort_unstable_by(|a, b| a.0.cmp(&b.0));
    assert_eq!(given.len(), there.len());
    for ((names, section), (expected, _)) in given.into_iter().zip(there) {
        assert_eq!(names, expected);
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
                line.starts_with(format!("{program} {names}").trim_end()),
                "{line}"
            );
            let parsed = read::<P>(words(line));
            assert!(parsed.is_ok(), "{line}: {}", parsed.err().unwrap());
        }
    }
}

/// Lists all properties of a schema, with what describes them.
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

pub(super) fn commands_with_json_describe_every_key<P: Program>(elsewhere: &[&str]) {
    let command = P::command();
    let program = command.get_name();
    for (names, arguments) in commands(&command, "", elsewhere) {
        let has_json = arguments.iter().any(|one| one.get_long() == Some("json"));
        if !has_json || (cfg!(not(unix)) && names.starts_with("tracker")) {
            continue;
        }
        let line = format!("{program} {names} --json-schema");
        let Ok(Request::Print(text)) = read::<P>(line.split(' ')) else {
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
