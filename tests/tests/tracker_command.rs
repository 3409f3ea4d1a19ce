//! `shisen tracker` over real pseudo-terminals, and `shisen cave --tracker`.
#![cfg(unix)]

use serde_json::Value;
use shisen_tests::command::shisen;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The protocols that go over a serial line.
const SERIAL: [&str; 8] = [
    "link", "fastrak", "liberty", "flock", "hatire", "iscan", "asl", "adhawk",
];

/// A command that runs until it is dropped.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn start(folder: &Path, arguments: &[&str]) -> Running {
    let command = shisen(folder);
    let mut command = Command::new(command.get_program());
    command.current_dir(folder).args(arguments);
    command.stdin(Stdio::null());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    Running(command.spawn().unwrap())
}

/// A mock on the line `tracker` in `folder`.
fn mock(folder: &Path, protocol: &str) -> Running {
    let mock = start(
        folder,
        &["tracker", "mock", "--as", protocol, "--pty", "tracker"],
    );
    let begun = Instant::now();
    while !folder.join("tracker").exists() {
        assert!(begun.elapsed() < Duration::from_secs(10), "{protocol}");
        std::thread::sleep(Duration::from_millis(5));
    }
    mock
}

fn lines(output: &[u8]) -> Vec<Value> {
    let text = std::str::from_utf8(output).unwrap();
    let lines = text.lines().map(serde_json::from_str);
    lines.collect::<Result<_, _>>().unwrap()
}

#[test]
fn every_serial_protocol_is_read_from_a_line() {
    let folder = tempfile::tempdir().unwrap();
    for protocol in SERIAL {
        let _mock = mock(folder.path(), protocol);
        let spec = format!("serial:tracker?protocol={protocol}");
        let begun = Instant::now();
        let output = shisen(folder.path())
            .args(["tracker", "monitor", &spec, "--json"])
            .args(["--frames", "100", "--seconds", "20"])
            .assert()
            .success();
        assert!(begun.elapsed() < Duration::from_secs(15), "{protocol}");
        let records = lines(&output.get_output().stdout);
        assert_eq!(records.len(), 100, "{protocol}");
        for (number, record) in records.iter().enumerate() {
            assert_eq!(record["number"], number, "{protocol}");
            let head = &record["head"]["orientation"];
            let point = &record["gaze_point"];
            assert!(head.is_object() || point.is_object(), "{protocol}");
        }
        assert_eq!(records[99]["lost"], 0, "{protocol}");
    }
}

#[test]
fn a_device_that_goes_and_comes_back_is_followed() {
    let folder = tempfile::tempdir().unwrap();
    let first = mock(folder.path(), "hatire");
    let spec = "serial:tracker?protocol=hatire";
    let mut monitor = start(folder.path(), &["tracker", "monitor", spec, "--json"]);
    let mut records = BufReader::new(monitor.0.stdout.take().unwrap()).lines();
    let errors = BufReader::new(monitor.0.stderr.take().unwrap());
    for _ in 0..50 {
        records.next().unwrap().unwrap();
    }
    drop(first);
    let mut errors = errors.lines().map(Result::unwrap);
    assert!(errors.next().unwrap().contains("plugged in"));
    let gone = errors.next().unwrap();
    assert!(gone.contains("tracker is gone"), "{gone}");
    let _second = mock(folder.path(), "hatire");
    let back = errors.next().unwrap();
    assert!(back.contains("plugged in"), "{back}");
    for _ in 0..600 {
        let record: Value = serde_json::from_str(&records.next().unwrap().unwrap()).unwrap();
        assert!(record["head"]["orientation"]["tracked"].as_bool().unwrap());
    }
}

#[test]
fn another_protocol_on_the_line_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let _mock = mock(folder.path(), "hatire");
    let output = shisen(folder.path())
        .args(["tracker", "monitor", "serial:tracker?protocol=adhawk"])
        .args(["--json", "--seconds", "2"])
        .assert()
        .code(1);
    let output = output.get_output();
    let said = std::str::from_utf8(&output.stderr).unwrap();
    assert!(said.contains("no record among them"), "{said}");
    assert!(said.contains("another baud rate"), "{said}");
    assert!(output.stdout.is_empty());
}

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

#[test]
fn what_is_no_tracker_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (spec, expected) in [
        ("mouse", "serial:/dev/ttyUSB0"),
        ("mock:rate=5", "60 to 1000"),
        ("serial:/dev/nowhere?protocol=asl", "/dev/nowhere"),
        ("serial:/dev/nowhere", "?protocol=NAME"),
        ("hid:fffe:fffd", "fffe:fffd"),
        ("replay:nothing.csv", "nothing.csv"),
    ] {
        for command in [
            &["tracker", "monitor", spec][..],
            &["cave", "--tracker", spec],
        ] {
            let output = shisen(folder.path()).args(command).assert().code(1);
            let said = std::str::from_utf8(&output.get_output().stderr).unwrap();
            assert!(said.contains(expected), "{spec}: {said}");
            assert!(output.get_output().stdout.is_empty());
        }
    }
    shisen(folder.path())
        .args(["tracker", "list", "--json"])
        .assert()
        .success();
}

#[test]
fn frames_along_the_mock_are_the_same_each_time() {
    let folder = tempfile::tempdir().unwrap();
    let run = |spec: &str| {
        let output = shisen(folder.path())
            .args(["cave", "--tracker", spec, "--frames", "8", "--json"])
            .args(["--size", "16", "--eyes", "1", "--lod", "paper"])
            .assert()
            .success();
        let report: Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
        report["frames"].as_array().unwrap().clone()
    };
    for (spec, state) in [
        ("mock", "fresh"),
        ("mock:seed=4&as=fastrak", "head direction"),
        ("mock:as=hid", "fresh"),
    ] {
        let frames = run(spec);
        assert_eq!(frames, run(spec), "{spec}");
        assert_eq!(frames.len(), 8);
        assert_eq!(frames[0]["state"], "full quality", "nothing has come yet");
        assert_eq!(frames[7]["state"], state, "{spec}");
        assert_ne!(frames[6]["head"], frames[7]["head"], "{spec}");
        assert!(
            folder
                .path()
                .join(frames[7]["images"][0].as_str().unwrap())
                .exists()
        );
    }
    assert_ne!(run("mock")[7]["gaze"], run("mock:seed=2")[7]["gaze"]);
}
