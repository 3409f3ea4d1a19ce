//! The `shisen` command as a person runs it.

use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;

/// The `shisen` command, with `folder` to work in.
pub fn shisen(folder: &Path) -> Command {
    executable("shisen-for-tests", folder)
}

/// The `shisen-evidence` command, likewise.
pub fn evidence(folder: &Path) -> Command {
    executable("evidence-for-tests", folder)
}

/// A command line of whichever of the two has its command.
pub fn command_line(folder: &Path, arguments: &[&str]) -> Command {
    let is_evidence = |name: &&str| matches!(*name, "bench" | "selftest" | "tradeoff");
    let program = match arguments.first().filter(|name| is_evidence(name)) {
        Some(_) => evidence,
        None => shisen,
    };
    let mut command = program(folder);
    command.args(arguments);
    command
}

/// An example of one of the crates, likewise; `cargo test --workspace` builds them.
pub fn example(name: &str, folder: &Path) -> Command {
    executable(&format!("examples/{name}"), folder)
}

/// A folder for the command to work in, which goes when it is dropped.
///
/// # Panics
/// Where there is none to be had.
pub fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

/// Runs a command that must succeed, and reads the one JSON object that it prints.
///
/// # Panics
/// Where it fails, or prints anything else.
pub fn report(command: &mut Command) -> Value {
    let output = command.arg("--json").assert().success();
    let text = String::from_utf8(output.get_output().stdout.clone()).expect("text");
    assert_eq!(text.lines().count(), 1, "{text}");
    serde_json::from_str(&text).expect("an object")
}

/// A program of the profile's folder, where Cargo has put it beside the test's own.
fn executable(name: &str, folder: &Path) -> Command {
    let test = std::env::current_exe().expect("the test's own path");
    // TARGET/PROFILE/deps/TEST
    let profile = test.ancestors().nth(2).expect("a profile's folder");
    let path = profile.join(name);
    let mut command = Command::new(path.with_extension(std::env::consts::EXE_EXTENSION));
    command.current_dir(folder);
    command
}
