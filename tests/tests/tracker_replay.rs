//! `shisen tracker serve replay:FILE`: when a recording begins on a line.
#![cfg(unix)]

use super::tracker_command::{Running, record, start_on_line};
use shisen_tests::command::{folder, run};
use std::io::{Read, Write};
use std::path::Path;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Returns a recording of a mock, replayed on the line `tracker` in `folder`.
fn replay(folder: &Path, protocol: &str) -> Running {
    record(folder, "mock:seed=3", "a.csv", 200);
    start_on_line(
        folder,
        &format!("tracker serve replay:a.csv --to tracker --as {protocol}"),
    )
}

/// Returns what the replay says until its end.
fn said(replay: &mut Running) -> String {
    std::io::read_to_string(replay.0.stderr.take().unwrap()).unwrap()
}

/// However late a reader comes, the first record is the first that was recorded.
#[test]
fn a_replay_waits_for_its_reader() {
    let check = |protocol: &str| {
        let folder = folder();
        let folder = folder.path();
        let mut replay = replay(folder, protocol);
        // What a mock of the same viewer sends.
        let words = format!("tracker monitor --json --frames 1 mock:seed=3&as={protocol}");
        let expected = run(folder, &words).objects().remove(0);
        // A program that opens the line and closes it is no reader.
        let opened = std::fs::File::open(folder.join("tracker")).unwrap();
        sleep(Duration::from_millis(100));
        drop(opened);
        sleep(Duration::from_millis(600));
        let spec = format!("serial:tracker?protocol={protocol}");
        let words = format!("tracker monitor --json --frames 100 --seconds 20 {spec}");
        let records = run(folder, &words).objects();
        assert_eq!(records.len(), 100, "{protocol}");
        for part in ["head", "left", "right", "gaze_point", "sequence"] {
            assert_eq!(records[0][part], expected[part], "{protocol} {part}");
        }
        assert_eq!(records[99]["held_back"], 0, "{protocol}");
        assert_eq!(records[99]["dropped"], 0, "{protocol}");
        let said = said(&mut replay);
        let waits = said.find("waiting until somebody opens tracker");
        let opened = said.find("tracker was opened");
        let begins = said.find("the recording begins");
        assert!(
            waits.is_some() && waits < opened && opened < begins,
            "{said}"
        );
        assert_eq!(said.contains("is told what to send"), protocol != "asl");
        assert!(replay.0.wait().unwrap().success(), "{said}");
    };
    // Nearly all of it is waiting: all at once.
    let each = ["link", "fastrak", "flock", "asl"];
    std::thread::scope(|scope| each.iter().for_each(|one| drop(scope.spawn(|| check(one)))));
}

/// A reader that says nothing gets the recording after a while, which is said.
#[test]
fn a_replay_does_not_wait_for_a_reader_that_says_nothing() {
    let folder = folder();
    let mut replay = replay(folder.path(), "fastrak");
    let mut line = std::fs::File::open(folder.path().join("tracker")).unwrap();
    let begun = Instant::now();
    let mut first = [0; 3];
    line.read_exact(&mut first).unwrap();
    assert_eq!(&first, b"01 ");
    assert!(begun.elapsed() >= Duration::from_millis(2_900));
    let said = said(&mut replay);
    assert!(said.contains("nothing is said for 3 s"), "{said}");
}

/// A host that asks for record after record gets the recording, too.
#[test]
fn a_replay_begins_for_a_host_that_polls() {
    for (protocol, poll) in [("fastrak", b"P"), ("liberty", b"P"), ("flock", b"B")] {
        let folder = folder();
        let _replay = replay(folder.path(), protocol);
        let mut options = std::fs::OpenOptions::new();
        let line = options
            .read(true)
            .write(true)
            .open(folder.path().join("tracker"))
            .unwrap();
        let begun = Instant::now();
        let mut reader = line.try_clone().unwrap();
        let first = std::thread::spawn(move || reader.read_exact(&mut [0; 14]).unwrap());
        while !first.is_finished() {
            assert!(begun.elapsed() < Duration::from_millis(2_500), "{protocol}");
            (&line).write_all(poll).unwrap();
            sleep(Duration::from_millis(50));
        }
        first.join().unwrap();
    }
}
