//! The `shisen` command as a person runs it.

use assert_cmd::Command;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use tempfile::TempDir;

/// The command, with `folder` to work in.
///
/// Cargo builds a test's own package only, so the first call of a process
/// builds the command: beside the test's executable, and in its profile.
///
/// # Panics
/// Where the command cannot be built.
pub fn shisen(folder: &Path) -> Command {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    let built = BUILT.get_or_init(|| build(&["--bin", "shisen"]));
    executable(&built.join("shisen"), folder)
}

/// An example of one of the crates, likewise.
///
/// # Panics
/// Where the examples cannot be built.
pub fn example(name: &str, folder: &Path) -> Command {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    let built = BUILT.get_or_init(|| build(&["--examples"]));
    executable(&built.join("examples").join(name), folder)
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

fn executable(path: &Path, folder: &Path) -> Command {
    let mut command = Command::new(path.with_extension(std::env::consts::EXE_EXTENSION));
    command.current_dir(folder);
    command
}

/// Builds targets, and says in which folder they are.
fn build(targets: &[&str]) -> PathBuf {
    let test = std::env::current_exe().expect("the test's own path");
    // TARGET/PROFILE/deps/TEST
    let folder = test.ancestors().nth(2).expect("a profile's folder");
    let target = folder.parent().expect("a target folder");
    let profile = match folder.file_name().and_then(|name| name.to_str()) {
        // The folder that profiles dev and test share.
        Some("debug") | None => "test",
        Some(name) => name,
    };
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = std::process::Command::new(cargo)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        // A test among the targets, and all packages: else Cargo would leave
        // out the features that tests alone ask for, and compile most
        // libraries a second time.
        .args(["build", "--quiet", "--workspace", "--test", "all"])
        .args(targets)
        .args(["--profile", profile, "--target-dir"])
        .arg(target)
        .status()
        .expect("cargo starts");
    assert!(status.success(), "{targets:?} cannot be built: {status}");
    folder.to_owned()
}
