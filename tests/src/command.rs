//! Runs the commands as a person does, each from one line of text.

use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;

/// The output of a command that succeeded.
#[derive(Debug)]
pub struct CommandOutput {
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl CommandOutput {
    /// Reads the JSON objects that it has printed, one in each line.
    pub fn objects(&self) -> Vec<Value> {
        let objects = self.out.lines().map(serde_json::from_str);
        objects.collect::<Result<_, _>>().expect("JSON lines")
    }
}

/// Returns the `shisen` command, with `folder` as its working folder.
pub fn shisen(folder: &Path) -> Command {
    executable("shisen-for-tests", folder)
}

/// Returns the `shisen-evidence` command, with `folder` as its working folder.
pub fn evidence(folder: &Path) -> Command {
    executable("evidence-for-tests", folder)
}

/// Returns a command from a line of words: `shisen-evidence` for its commands, otherwise `shisen`.
pub fn line(folder: &Path, words: &str) -> Command {
    let program = match words.split(' ').next() {
        Some("bench" | "selftest" | "tradeoff") => evidence,
        _ => shisen,
    };
    let mut command = program(folder);
    command.args(words.split_whitespace());
    command
}

/// Runs a command that must succeed.
pub fn succeed(command: &mut Command) -> CommandOutput {
    let output = command.assert().success().get_output().clone();
    let [out, err] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    CommandOutput { out, err }
}

/// Runs a command line that must succeed.
pub fn run(folder: &Path, words: &str) -> CommandOutput {
    succeed(&mut line(folder, words))
}

/// Runs a command line that must succeed, and reads the one JSON object that it prints.
pub fn report(folder: &Path, words: &str) -> Value {
    let said = succeed(line(folder, words).arg("--json"));
    assert_eq!(said.out.lines().count(), 1, "{}", said.out);
    said.objects().remove(0)
}

/// Checks that a report has these values, among others.
#[expect(clippy::needless_pass_by_value, reason = "json! makes one")]
pub fn says(report: &Value, expected: Value) {
    for (key, expected) in expected.as_object().expect("an object") {
        assert_eq!(&report[key], expected, "{key}");
    }
}

/// Returns a number of a report.
pub fn number(report: &Value, key: &str) -> f64 {
    report[key].as_f64().expect("a number")
}

/// Returns a whole number of a report.
pub fn count(report: &Value, key: &str) -> u64 {
    report[key].as_u64().expect("a count")
}

/// Returns a list of a report.
pub fn list<'v>(report: &'v Value, key: &str) -> &'v [Value] {
    report[key].as_array().expect("a list")
}

/// Runs a command that must end with this code and print nothing on standard output; returns the
/// words of its error, with one space between.
pub fn refusal(command: &mut Command, code: i32) -> String {
    let output = command.assert().code(code).get_output().clone();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.stdout.is_empty() && !said.contains("panicked"),
        "{said}"
    );
    let words = said.split(|c: char| c.is_whitespace() || c == '│');
    let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    words.join(" ")
}

/// Checks that command lines end with this code, and that their errors have these words and a
/// remedy: rows of `LINE => WORDS`, or of `LINE => WORDS & WORDS`.
pub fn refused(folder: &Path, code: i32, table: &str) {
    for row in table.lines().filter(|row| !row.trim().is_empty()) {
        let (words, expected) = row.split_once("=>").expect("a line and words");
        let said = refusal(&mut line(folder, words.trim()), code);
        for expected in expected.split(" & ").map(str::trim) {
            assert!(said.contains(expected), "{row}: no {expected:?} in: {said}");
        }
        assert!(said.len() > 60, "no remedy: {said}");
    }
}

/// Returns an example of one of the crates as a command; `cargo test --workspace` builds them.
pub fn example(name: &str, folder: &Path) -> Command {
    executable(&format!("examples/{name}"), folder)
}

/// Returns a working folder for the command, which is deleted when dropped.
pub fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

/// Returns a program as a command: Cargo puts it beside the folder of the test's own program.
fn executable(name: &str, folder: &Path) -> Command {
    let test = std::env::current_exe().expect("the test's own path");
    // TARGET/PROFILE/deps/TEST
    let profile = test.ancestors().nth(2).expect("a profile's folder");
    let path = profile.join(name);
    let mut command = Command::new(path.with_extension(std::env::consts::EXE_EXTENSION));
    command.current_dir(folder).env("SHISEN_CACHE", "off");
    command
}
