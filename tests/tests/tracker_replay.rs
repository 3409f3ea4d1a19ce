//! `shisen tracker replay --to`: when a recording begins on a line.
#![cfg(unix)]

use super::tracker_command::{Running, SERIAL, lines, start_on_line};
use shisen_tests::command::shisen;
use std::io::{Read, Write};
use std::path::Path;
use std::time::{Duration, Instant};

/// Records a mock in `a.csv`.
fn record(folder: &Path) {
    shisen(folder)
        .args(["tracker", "record", "mock:seed=3", "a.csv"])
        .args(["--frames", "300"])
        .assert()
        .success();
}

/// The recording `a.csv` of a mock, replayed on the line `tracker` in `folder`.
fn replay(folder: &Path, protocol: &str) -> Running {
    let arguments = ["tracker", "replay", "a.csv", "--to", "tracker", "--as"];
    start_on_line(folder, &[&arguments[..], &[protocol]].concat())
}

/// However late a reader comes, the first record is the first that was recorded.
#[test]
fn a_replay_waits_for_its_reader() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    record(folder);
    for protocol in SERIAL {
        // What a mock of the same viewer sends.
        let output = shisen(folder)
            .args(["tracker", "monitor", "--json", "--frames", "1"])
            .arg(format!("mock:seed=3&as={protocol}"))
            .assert()
            .success();
        let expected = lines(&output.get_output().stdout).remove(0);
        let mut replay = replay(folder, protocol);
        std::thread::sleep(Duration::from_millis(300));
        // Whoever looks, and goes, is no reader.
        let looker = std::fs::File::open(folder.join("tracker")).unwrap();
        std::thread::sleep(Duration::from_millis(100));
        drop(looker);
        std::thread::sleep(Duration::from_millis(600));
        let output = shisen(folder)
            .args(["tracker", "monitor", "--json"])
            .args(["--frames", "100", "--seconds", "20"])
            .arg(format!("serial:tracker?protocol={protocol}"))
            .assert()
            .success();
        let records = lines(&output.get_output().stdout);
        assert_eq!(records.len(), 100, "{protocol}");
        for part in [
            "head",
            "left",
            "right",
            "combined",
            "gaze_point",
            "sequence",
        ] {
            assert_eq!(records[0][part], expected[part], "{protocol} {part}");
        }
        assert_eq!(records[99]["held_back"], 0, "{protocol}");
        assert_eq!(records[99]["dropped"], 0, "{protocol}");
        let mut said = String::new();
        let mut stderr = replay.0.stderr.take().unwrap();
        stderr.read_to_string(&mut said).unwrap();
        let waits = said.find("waiting until somebody opens tracker");
        let opened = said.find("tracker was opened");
        let begins = said.find("the recording begins");
        assert!(
            waits.is_some() && waits < opened && opened < begins,
            "{said}"
        );
        assert_eq!(said.contains("is told what to send"), protocol != "asl");
        assert!(replay.0.wait().unwrap().success(), "{said}");
    }
}

/// A reader that says nothing gets the recording all the same, after a while that is said.
#[test]
fn a_replay_does_not_wait_for_a_reader_that_says_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    record(folder);
    let mut replay = replay(folder, "fastrak");
    let mut line = std::fs::File::open(folder.join("tracker")).unwrap();
    let begun = Instant::now();
    let mut first = [0; 3];
    line.read_exact(&mut first).unwrap();
    assert_eq!(&first, b"01 ");
    assert!(begun.elapsed() >= Duration::from_millis(2_900));
    let mut said = String::new();
    replay
        .0
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut said)
        .unwrap();
    assert!(said.contains("nothing is said for 3 s"), "{said}");
    let output = shisen(folder)
        .args(["tracker", "replay", "--help"])
        .assert()
        .success();
    let help = String::from_utf8(output.get_output().stdout.clone()).unwrap();
    let plain: Vec<&str> = help.split_whitespace().collect();
    let plain = plain.join(" ");
    assert!(
        plain.contains("said nothing for 3 s (0.4 s where"),
        "{help}"
    );
}

/// A host that asks for record after record gets the recording, too.
#[test]
fn a_replay_begins_for_a_host_that_polls() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    record(folder);
    for (protocol, poll) in [("fastrak", b"P"), ("liberty", b"P"), ("flock", b"B")] {
        let replay = replay(folder, protocol);
        let line = std::fs::OpenOptions::new()
            .read(true)
            .write(true)
            .open(folder.join("tracker"))
            .unwrap();
        let begun = Instant::now();
        let mut reader = line.try_clone().unwrap();
        let first = std::thread::spawn(move || {
            reader.read_exact(&mut [0; 14]).unwrap();
            begun.elapsed()
        });
        while !first.is_finished() && begun.elapsed() < Duration::from_secs(10) {
            (&line).write_all(poll).unwrap();
            std::thread::sleep(Duration::from_millis(50));
        }
        assert!(first.is_finished(), "{protocol}");
        let waited = first.join().unwrap();
        assert!(
            waited < Duration::from_millis(2_500),
            "{protocol}: {waited:?}"
        );
        drop(replay);
    }
}
