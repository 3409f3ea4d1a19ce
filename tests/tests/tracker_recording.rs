//! `shisen tracker record` and `replay`: what is written, and how it is played.
#![cfg(unix)]

use super::tracker_command::{lines, reader, start};
use serde_json::Value;
use shisen_tests::command::shisen;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

#[test]
fn a_recording_is_replayed_onto_a_line() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.csv", "a.link"] {
        shisen(folder.path())
            .args(["tracker", "record", "mock:seed=3", name, "--frames", "200"])
            .assert()
            .success();
        let output = shisen(folder.path())
            .args(["tracker", "replay", name, "--json"])
            .assert()
            .success();
        let recorded = lines(&output.get_output().stdout);
        assert_eq!(recorded.len(), 200);
        let _ = std::fs::remove_file(folder.path().join("tracker"));
        let _line = start(
            folder.path(),
            &["tracker", "replay", name, "--to", "tracker"],
        );
        let begun = Instant::now();
        while !folder.path().join("tracker").exists() {
            assert!(begun.elapsed() < Duration::from_secs(10));
            std::thread::sleep(Duration::from_millis(2));
        }
        let output = shisen(folder.path())
            .args(["tracker", "monitor", "serial:tracker?protocol=link"])
            .args(["--json", "--frames", "20"])
            .assert()
            .success();
        for record in lines(&output.get_output().stdout) {
            let same = recorded
                .iter()
                .find(|one| one["sequence"] == record["sequence"]);
            let same = same.expect("it was recorded");
            for field in ["device_us", "head", "left", "right"] {
                assert_eq!(same[field], record[field], "{name} {field}");
            }
        }
    }
}

/// A recording of the mock, and the same in which everything from a line on came
/// later: microseconds, by line from 0.
fn recorded(folder: &Path, name: &str, later: impl Fn(usize) -> u64) {
    if !folder.join("a.csv").exists() {
        shisen(folder)
            .args(["tracker", "record", "mock:seed=3", "a.csv"])
            .args(["--frames", "300"])
            .assert()
            .success();
    }
    let table = fs::read_to_string(folder.join("a.csv")).unwrap();
    let moved = table.lines().enumerate().map(|(number, line)| {
        let (arrival, rest) = line.split_once(',').unwrap();
        let Some(number) = number.checked_sub(1) else {
            return line.to_owned();
        };
        let arrival: u64 = arrival.parse().unwrap();
        format!("{},{rest}", arrival + later(number))
    });
    let moved: Vec<String> = moved.collect();
    fs::write(folder.join(name), moved.join("\n") + "\n").unwrap();
}

/// Whatever the clock showed when it was recorded.
#[test]
fn a_recording_is_played_from_its_first_sample_on() {
    const LATER: u64 = 1_700_000_000_000_000;
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    recorded(folder, "late.csv", |_| LATER);
    let replay = |name: &str| {
        let begun = Instant::now();
        let output = shisen(folder)
            .args(["tracker", "replay", name, "--json", "--seconds", "20"])
            .assert()
            .success();
        // 0.6 s of a recording, on any machine.
        assert!(begun.elapsed() < Duration::from_secs(15));
        assert_eq!(output.get_output().stderr, b"");
        lines(&output.get_output().stdout)
    };
    let (early, late) = (replay("a.csv"), replay("late.csv"));
    assert_eq!((early.len(), late.len()), (300, 300));
    for (early, late) in early.iter().zip(&late) {
        let arrival = |record: &Value| record["arrival_us"].as_u64().unwrap();
        assert_eq!(arrival(early) + LATER, arrival(late));
        assert_eq!(early["head"], late["head"]);
    }
    let frames = |name: &str| {
        let spec = format!("replay:{name}");
        let output = shisen(folder)
            .args(["cave", "--tracker", &spec, "--frames", "6", "--json"])
            .args(["--size", "8", "--eyes", "1", "--lod", "paper"])
            .args(["--view-size", "8x6"])
            .assert()
            .success();
        let report: Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
        let frames = report["frames"].as_array().unwrap().clone();
        let of = |frame: &Value| (frame["state"].clone(), frame["head"].clone());
        frames.iter().map(of).collect::<Vec<_>>()
    };
    let late = frames("late.csv");
    assert_eq!(late[5].0, "fresh");
    assert_eq!(frames("a.csv"), late);
    // Behind a line, too.
    let _line = start(folder, &["tracker", "replay", "late.csv", "--to", "line"]);
    let begun = Instant::now();
    while !folder.join("line").exists() {
        assert!(begun.elapsed() < Duration::from_secs(10));
        std::thread::sleep(Duration::from_millis(2));
    }
    shisen(folder)
        .args(["tracker", "monitor", "serial:line?protocol=link"])
        .args(["--json", "--frames", "5", "--seconds", "10"])
        .assert()
        .success();
}

#[test]
fn a_pause_in_a_recording_is_told_and_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    recorded(
        folder,
        "pause.csv",
        |line| {
            if line < 100 { 0 } else { 2_500_000 }
        },
    );
    let begun = Instant::now();
    let output = shisen(folder)
        .args(["tracker", "replay", "pause.csv", "--json"])
        .assert()
        .success();
    assert!(begun.elapsed() > Duration::from_millis(2_500));
    assert_eq!(lines(&output.get_output().stdout).len(), 300);
    let said = String::from_utf8(output.get_output().stderr.clone()).unwrap();
    let expected = "Warning: the recording holds nothing for the next 2.5 s: it goes on then\n";
    assert_eq!(said, expected);
    let _reader = reader(folder, "line");
    let output = shisen(folder)
        .args(["tracker", "replay", "pause.csv", "--to", "line"])
        .args(["--frames", "10"])
        .assert()
        .success();
    let said = String::from_utf8(output.get_output().stderr.clone()).unwrap();
    assert!(
        said.contains("nothing for 2.5 s, from 0.2 s after"),
        "{said}"
    );
}

/// A line on which nobody speaks.
#[test]
fn a_file_is_kept_until_there_is_something_to_record() {
    use shisen::tracker::pty::Pty;
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let _pty = Pty::open(&folder.join("line")).unwrap();
    fs::write(folder.join("old.csv"), "what was there\n").unwrap();
    for name in ["old.csv", "new.csv", "new.link"] {
        let output = shisen(folder)
            .args(["tracker", "record", "serial:line?protocol=iscan", name])
            .args(["--seconds", "1"])
            .assert()
            .code(1);
        let said = String::from_utf8(output.get_output().stderr.clone()).unwrap();
        assert!(said.contains("no sample came in 1 s"), "{said}");
    }
    let old = fs::read_to_string(folder.join("old.csv")).unwrap();
    assert_eq!(old, "what was there\n");
    assert!(!folder.join("new.csv").exists() && !folder.join("new.link").exists());
    // One that is told to restart has a while to do so.
    let output = shisen(folder)
        .args(["tracker", "monitor", "serial:line?protocol=fastrak&reset=1"])
        .args(["--seconds", "1"])
        .assert()
        .code(1);
    let said = String::from_utf8(output.get_output().stderr.clone()).unwrap();
    assert!(
        said.contains("the device restarts: it says nothing for up to"),
        "{said}"
    );
    assert!(said.contains("the device is still restarting"), "{said}");
}
