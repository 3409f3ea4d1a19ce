//! The README's commands, files and links, as a reader would try them.

use serde_json::Value;
use shisen_tests::command::shisen;
use shisen_tests::meshes::icosphere;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn readme() -> String {
    fs::read_to_string(root().join("README.md")).unwrap()
}

/// Each fenced block of a language, with the text before it.
fn blocks<'a>(text: &'a str, language: &str) -> Vec<(&'a str, &'a str)> {
    let fence = format!("\n```{language}\n");
    text.match_indices(&fence)
        .map(|(start, _)| {
            let block = &text[start + fence.len()..];
            (&text[..start], &block[..=block.find("\n```").unwrap()])
        })
        .collect()
}

/// A mesh and rays that meet it, under the names that the README uses.
fn write_inputs(folder: &Path) {
    let mesh = icosphere(2);
    let mut text = String::new();
    for [x, y, z] in &mesh.positions {
        writeln!(text, "v {x} {y} {z}").unwrap();
    }
    for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|i| i + 1)) {
        writeln!(text, "f {a} {b} {c}").unwrap();
    }
    fs::write(folder.join("cow.obj"), text).unwrap();
    let rays: Vec<u8> = (0..100)
        .flat_map(|i| [0.0, 0.0, 9.0, i as f32 * 1e-4, 0.0, -1.0])
        .flat_map(f32::to_le_bytes)
        .collect();
    fs::write(folder.join("rays.bin"), rays).unwrap();
    fs::write(folder.join("directions.txt"), "0 0 -1\n0.3 -0.5 -1\n").unwrap();
}

#[test]
fn every_command_runs_on_the_files_shown() {
    let text = readme();
    let folder = tempfile::tempdir().unwrap();
    write_inputs(folder.path());
    let files = blocks(&text, "toml");
    assert_eq!(files.len(), 4);
    for (before, file) in files {
        let name = before.rsplit('`').nth(1).unwrap();
        assert!(Path::new(name).extension().is_some_and(|e| e == "toml"));
        fs::write(folder.path().join(name), file).unwrap();
    }
    let commands: Vec<&str> = blocks(&text, "sh")
        .into_iter()
        .flat_map(|(_, block)| block.lines())
        .filter_map(|line| line.strip_prefix("shisen "))
        .collect();
    assert_eq!(commands.len(), 38);
    for command in commands {
        let (command, input) = match command.split_once(" < ") {
            Some((command, file)) => (command, fs::read(folder.path().join(file)).unwrap()),
            None => (command, Vec::new()),
        };
        // What takes minutes as it stands.
        let shorter: &[&str] = match command.split_whitespace().nth(1) {
            Some("table2" | "foveated") => &["--size", "16", "--repeat", "1"],
            Some("spectrum") if command.starts_with("bench") => {
                &["--size", "16", "--samples", "14", "--repeat", "1"]
            }
            _ if command.starts_with("run") => &["--size", "16", "--frames", "30"],
            Some("budget") => &["--size", "16", "--frames", "100"],
            Some("latency") => &["--size", "16", "--rates", "250", "--seconds", "1"],
            Some("sweep") => &["--size", "16", "--repeat", "1", "--directions", "3"],
            Some("fill") => &["--size", "16", "--repeat", "1", "--fill-size", "16"],
            _ if command.starts_with("selftest") => &["--quick"],
            _ if command.starts_with("explain") => &["--size", "16", "--repeat", "1"],
            _ => &[],
        };
        shisen(folder.path())
            .args(command.split_whitespace())
            .args(shorter)
            .write_stdin(input)
            .assert()
            .success();
    }
    let hits = fs::read(folder.path().join("hits.bin")).unwrap();
    assert_eq!(hits.len(), 800);
    for picture in ["frame/cave.png", "gaze/levels.png", "gaze/difference.png"] {
        assert!(folder.path().join(picture).is_file(), "{picture}");
    }
}

#[test]
fn every_key_of_the_report_is_explained() {
    let folder = tempfile::tempdir().unwrap();
    let output = shisen(folder.path())
        .args(["cave", "--size", "8", "--lod", "paper", "--json"])
        .assert()
        .success()
        .get_output()
        .clone();
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let text = readme();
    let section = &text[text.find("### The report of `cave --json`").unwrap()..];
    let section = &section[..section.find("\n## ").unwrap()];
    let lod = &report["lod"];
    for object in [
        &report,
        &report["rays"],
        &report["images"][0],
        lod,
        &lod["field"][0],
        &lod["fill"],
    ] {
        for key in object.as_object().unwrap().keys() {
            assert!(section.contains(&format!("`{key}`")), "{key}");
        }
    }
}

/// The keys of an object and of whatever is in it.
fn keys_within(value: &Value, keys: &mut BTreeSet<String>) {
    match value {
        Value::Object(object) => {
            keys.extend(object.keys().cloned());
            object.values().for_each(|value| keys_within(value, keys));
        }
        Value::Array(values) => values.iter().for_each(|value| keys_within(value, keys)),
        _ => {}
    }
}

/// The words of a text, with underscores and without anything else that is no letter and
/// no digit.
fn words(text: &str) -> BTreeSet<&str> {
    text.split(|c: char| !c.is_alphanumeric() && c != '_')
        .collect()
}

/// Commands whose help says what is in their report, and what else is read.
const REPORTS: [(&[&str], &str); 13] = [
    (&["cave", "--size", "8", "--lod", "paper"], ""),
    (
        &["cave", "--size", "8", "--tracker", "mock", "--frames", "2"],
        "",
    ),
    (
        &["run", "--size", "8", "--frames", "5", "--record", "f.jsonl"],
        "",
    ),
    (&["bake", "A", "--output", "a.shisen", "--levels", "3"], ""),
    (&["inspect", "a.shisen"], ""),
    (&["explain", "--size", "8", "--repeat", "1"], ""),
    (&["gaze"], "0.3 -0.5 -1\n"),
    (&["medium", "quartz-o"], ""),
    (&["spectrum", "--wavelengths", "7"], ""),
    (&["dome", "design", "--config", "paper-3"], ""),
    (&["dome", "map", "--config", "paper-3"], ""),
    (&["dome", "render", "--size", "8", "--mapping", "exact"], ""),
    (&["bench", "table2", "--size", "8", "--repeat", "1"], ""),
];

/// How many words of a command line are its command's name.
fn names_of(command: &[&str]) -> usize {
    let of_a_group = matches!(command[0], "dome" | "bench");
    1 + usize::from(of_a_group)
}

#[test]
fn every_key_of_a_report_is_explained_by_help() {
    let folder = tempfile::tempdir().unwrap();
    let said = |command: &[&str], argument: &str, input: &str| {
        let mut shisen = shisen(folder.path());
        let output = shisen.args(command).arg(argument).write_stdin(input);
        let output = output.assert().success().get_output().stdout.clone();
        String::from_utf8(output).unwrap()
    };
    for (command, input) in REPORTS {
        let help = said(&command[..names_of(command)], "--help", "");
        let explained = words(&help);
        let report = said(command, "--json", input);
        let mut keys = BTreeSet::new();
        keys_within(&serde_json::from_str(&report).unwrap(), &mut keys);
        // What `run` writes of each frame is explained there, too.
        if let Ok(frames) = fs::read_to_string(folder.path().join("f.jsonl")) {
            let frame = frames.lines().next().unwrap();
            keys_within(&serde_json::from_str(frame).unwrap(), &mut keys);
            fs::remove_file(folder.path().join("f.jsonl")).unwrap();
        }
        assert!(keys.len() > 5, "{command:?}: {report}");
        let missing: Vec<&String> = keys
            .iter()
            .filter(|key| !explained.contains(key.as_str()))
            .collect();
        assert!(missing.is_empty(), "{command:?}: {missing:?} of {help}");
    }
}

#[test]
fn every_link_leads_to_a_file_or_a_heading() {
    let text = readme();
    let slug = |heading: &str| {
        let plain = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
        let words: String = heading.to_lowercase().chars().filter(plain).collect();
        words.trim().replace(' ', "-")
    };
    let headings: Vec<String> = text
        .lines()
        .filter(|line| line.starts_with('#'))
        .map(|line| slug(line.trim_start_matches('#')))
        .collect();
    let links: Vec<&str> = text
        .split("](")
        .skip(1)
        .map(|rest| &rest[..rest.find(')').unwrap()])
        .collect();
    assert!(links.len() >= 4, "{links:?}");
    for link in links {
        let there = match link.strip_prefix('#') {
            Some(heading) => headings.iter().any(|one| one == heading),
            None => root().join(link).is_file(),
        };
        assert!(there, "{link}");
    }
}

#[test]
fn nothing_is_left_to_be_filled_in() {
    let text = readme();
    let places: Vec<&str> = text
        .split_whitespace()
        .filter(|word| word.len() > 2 && word.starts_with('@') && word.ends_with('@'))
        .collect();
    assert_eq!(places, Vec::<&str>::new());
}
