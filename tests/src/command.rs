//! The commands as a person runs them, each by a line of words.

use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;

/// What a command that succeeded has printed.
#[derive(Debug)]
pub struct Said {
    /// Its standard output.
    pub out: String,
    /// Its standard error.
    pub err: String,
}

impl Said {
    /// The JSON objects that it has printed, one a line.
    pub fn objects(&self) -> Vec<Value> {
        let objects = self.out.lines().map(serde_json::from_str);
        objects.collect::<Result<_, _>>().expect("JSON lines")
    }
}

/// The `shisen` command, with `folder` to work in.
pub fn shisen(folder: &Path) -> Command {
    executable("shisen-for-tests", folder)
}

/// The `shisen-evidence` command, likewise.
pub fn evidence(folder: &Path) -> Command {
    executable("evidence-for-tests", folder)
}

/// A command line, of words between spaces, of whichever of the two has its command.
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
pub fn succeed(command: &mut Command) -> Said {
    let output = command.assert().success().get_output().clone();
    let [out, err] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    Said { out, err }
}

/// Runs a command line that must succeed.
pub fn run(folder: &Path, words: &str) -> Said {
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

/// A number of a report.
pub fn number(report: &Value, key: &str) -> f64 {
    report[key].as_f64().expect("a number")
}

/// A whole number of a report.
pub fn count(report: &Value, key: &str) -> u64 {
    report[key].as_u64().expect("a count")
}

/// A list of a report.
pub fn list<'v>(report: &'v Value, key: &str) -> &'v [Value] {
    report[key].as_array().expect("a list")
}

/// What a command says that must end with this code and without output; its words with one
/// space between.
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

/// Checks that command lines end with this code, and say each of some words, and a remedy: rows
/// of `LINE => WORDS`, or of `LINE => WORDS & WORDS`.
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

/// An example of one of the crates, likewise; `cargo test --workspace` builds them.
pub fn example(name: &str, folder: &Path) -> Command {
    executable(&format!("examples/{name}"), folder)
}

/// A folder for the command to work in, which goes when it is dropped.
pub fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
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
