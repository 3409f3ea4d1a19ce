//! `shisen tracker record` and `replay`: what is written, and how it is played.
#![cfg(unix)]

use super::tracker_command::{await_file, reader, record, start};
use serde_json::Value;
use shisen_tests::command::{folder, line, refusal, refused, report, run};
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

#[test]
fn a_recording_is_replayed_onto_a_line() {
    let folder = folder();
    let folder = folder.path();
    for name in ["a.csv", "a.link"] {
        run(
            folder,
            &format!("tracker record mock:seed=3 {name} --frames 100"),
        );
        let recorded = run(folder, &format!("tracker monitor replay:{name} --json")).objects();
        assert_eq!(recorded.len(), 100);
        let _ = fs::remove_file(folder.join("tracker"));
        let _line = start(folder, &format!("tracker serve replay:{name} --to tracker"));
        await_file(&folder.join("tracker"));
        let words = "tracker monitor serial:tracker?protocol=link --json --frames 20";
        for record in run(folder, words).objects() {
            let mut all = recorded.iter();
            let same = all
                .find(|one| one["sequence"] == record["sequence"])
                .expect("it was recorded");
            for field in ["device_us", "head", "left", "right"] {
                assert_eq!(same[field], record[field], "{name} {field}");
            }
        }
    }
}

/// The recording `a.csv` of a mock, and the same in which each sample came later:
/// microseconds, by line from 0.
fn recorded(folder: &Path, name: &str, later: impl Fn(usize) -> u64) {
    record(folder, "mock:seed=3", "a.csv", 300);
    let table = fs::read_to_string(folder.join("a.csv")).unwrap();
    let (header, lines) = table.split_once('\n').unwrap();
    let mut moved = vec![header.to_owned()];
    for (number, line) in lines.lines().enumerate() {
        let (arrival, rest) = line.split_once(',').unwrap();
        let arrival: u64 = arrival.parse().unwrap();
        moved.push(format!("{},{rest}", arrival + later(number)));
    }
    fs::write(folder.join(name), moved.join("\n") + "\n").unwrap();
}

/// Whatever the clock showed when it was recorded.
#[test]
fn a_recording_is_played_from_its_first_sample_on() {
    const LATER: u64 = 1_700_000_000_000_000;
    let folder = folder();
    let folder = folder.path();
    recorded(folder, "late.csv", |_| LATER);
    let replay = |name: &str| {
        let begun = Instant::now();
        let said = run(
            folder,
            &format!("tracker monitor replay:{name} --json --seconds 20"),
        );
        // 0.6 s of a recording, on any machine.
        assert!(begun.elapsed() < Duration::from_secs(15));
        assert_eq!(said.err, "");
        said.objects()
    };
    let (early, late) = (replay("a.csv"), replay("late.csv"));
    assert_eq!((early.len(), late.len()), (300, 300));
    for (early, late) in early.iter().zip(&late) {
        let arrival = |record: &Value| record["arrival_us"].as_u64().unwrap();
        assert_eq!(arrival(early) + LATER, arrival(late));
        assert_eq!(early["head"], late["head"]);
    }
    let small = "--scene grid --size 8 --eyes 1 --view-size 8x6";
    let frames = |name: &str| {
        let words = format!("cave --tracker replay:{name} --frames 6 --lod paper {small}");
        let report = report(folder, &words);
        [0, 1, 2, 3, 4, 5].map(|i| ["state", "head"].map(|key| report["frames"][i][key].clone()))
    };
    let late = frames("late.csv");
    assert_eq!(late[5][0], "fresh");
    assert_eq!(frames("a.csv"), late);
    // Behind a line, too.
    let _line = start(folder, "tracker serve replay:late.csv --to line");
    await_file(&folder.join("line"));
    run(
        folder,
        "tracker monitor serial:line?protocol=link --json --frames 5 --seconds 10",
    );
}

#[test]
fn a_pause_in_a_recording_is_told_and_waited_for() {
    let folder = folder();
    let folder = folder.path();
    recorded(
        folder,
        "pause.csv",
        |line| if line < 100 { 0 } else { 2_100_000 },
    );
    let begun = Instant::now();
    let said = run(folder, "tracker monitor replay:pause.csv --json");
    assert!(begun.elapsed() > Duration::from_millis(2_100));
    assert_eq!(said.objects().len(), 300);
    let expected = "Warning: the recording holds nothing for the next 2.1 s\n";
    assert_eq!(said.err, expected);
    reader(folder);
    let said = run(
        folder,
        "tracker serve replay:pause.csv --to line --frames 10",
    )
    .err;
    assert!(
        said.contains("nothing for 2.1 s, from 0.2 s after"),
        "{said}"
    );
}

/// A line on which nobody speaks.
#[test]
fn a_file_is_kept_until_there_is_something_to_record() {
    use shisen::tracker::pty::Pty;
    let folder = folder();
    let folder = folder.path();
    let _pty = Pty::open(&folder.join("line")).unwrap();
    fs::write(folder.join("old.csv"), "what was there\n").unwrap();
    for name in ["old.csv", "new.csv", "new.link"] {
        let words = format!("tracker record serial:line?protocol=iscan {name} --seconds 0.3");
        refused(folder, 1, &format!("{words} => no sample came in 0.3 s"));
    }
    assert_eq!(
        fs::read_to_string(folder.join("old.csv")).unwrap(),
        "what was there\n"
    );
    assert!(!folder.join("new.csv").exists() && !folder.join("new.link").exists());
    // A device that is told to restart has a while to do so.
    let row = "tracker monitor serial:line?protocol=fastrak&reset=1 --seconds 1 => \
               the device restarts: it says nothing for up to & the device is still restarting";
    refused(folder, 1, row);
}

/// Changes the cells of some columns; lines are counted from 1, below the header.
fn change(table: &str, columns: &[&str], mut cell: impl FnMut(usize, &str) -> String) -> String {
    let mut table: Vec<Vec<String>> = table
        .lines()
        .map(|line| line.split(',').map(String::from).collect())
        .collect();
    for column in columns {
        let at = table[0].iter().position(|name| name == column).unwrap();
        for (number, cells) in table.iter_mut().enumerate().skip(1) {
            cells[at] = cell(number, &cells[at]);
        }
    }
    let lines: Vec<String> = table.iter().map(|cells| cells.join(",")).collect();
    lines.join("\n") + "\n"
}

/// Holds each of some columns from a line on; empty cells stay.
fn frozen(table: &str, columns: &[&str], first: usize) -> String {
    let mut held = String::new();
    change(table, columns, |line, cell| {
        if line <= first.max(1) {
            cell.clone_into(&mut held);
        }
        held[..if cell.is_empty() { 0 } else { held.len() }].to_owned()
    })
}

/// A replayed device sends what was recorded.
#[test]
fn a_recording_is_not_made_up() {
    let folder = folder();
    let folder = folder.path();
    record(folder, "mock:as=iscan", "eye.csv", 100);
    record(folder, "mock:as=hatire", "head.csv", 100);
    for (file, protocol, lacks) in [
        ("eye.csv", "fastrak", "no head's pose"),
        ("head.csv", "iscan", "no gaze"),
        // It turns, and has no position.
        ("head.csv", "liberty", "no head's pose"),
    ] {
        let words = format!("tracker serve replay:{file} --to line --as {protocol}");
        let said = refusal(&mut line(folder, &words), 1);
        assert!(
            said.contains(lacks) && said.contains("link"),
            "{words}: {said}"
        );
    }
    let table = fs::read_to_string(folder.join("head.csv")).unwrap();
    let turn = [
        "head_qx",
        "head_qy",
        "head_qz",
        "head_qw",
        "head_turn_tracked",
    ];
    let both = change(&table, &turn, |line, cell| {
        cell[..if line <= 30 { 0 } else { cell.len() }].to_owned()
    });
    fs::write(folder.join("both.csv"), both).unwrap();
    for (protocol, expected) in [
        (
            "fastrak?items=11,0",
            "30 of 100 samples hold no head's pose with all that its records hold: they are sent as not tracked",
        ),
        ("hatire", "they are left out"),
    ] {
        reader(folder);
        let words = format!("tracker serve replay:both.csv --to line --frames 70 --as {protocol}");
        let said = run(folder, &words).err;
        assert!(said.contains(expected), "{protocol}: {said}");
    }
}

/// A clock that stands still, runs and jumps, eyes that are frozen, and a head that rests.
#[test]
fn what_happens_to_clock_and_gaze_is_told() {
    let folder = folder();
    let folder = folder.path();
    // 500 Hz.
    record(folder, "mock:seed=2&still=1", "a.csv", 1_000);
    fs::write(folder.join("a.toml"), "head = [0, 0, 0]\n").unwrap();
    let table = fs::read_to_string(folder.join("a.csv")).unwrap();
    let mut still = String::new();
    let clock = change(&table, &["device_us"], |line, cell| match line {
        200..500 => still.clone(),
        800.. => (cell.parse::<u64>().unwrap() + 90_000_000).to_string(),
        _ => {
            cell.clone_into(&mut still);
            cell.to_owned()
        }
    });
    let gaze = ["left", "right"].map(|eye| ["x", "y", "z"].map(|x| format!("{eye}_direction_{x}")));
    let gaze: Vec<&str> = gaze.as_flattened().iter().map(String::as_str).collect();
    let head = [
        "head_x", "head_y", "head_z", "head_qx", "head_qy", "head_qz", "head_qw",
    ];
    let monitor = |name: &str, table: &str| {
        fs::write(folder.join(name), table).unwrap();
        let said = run(
            folder,
            &format!("tracker monitor replay:{name} --calibration a.toml --json"),
        );
        let states = said.objects().into_iter();
        let states = states.map(|record| record["line_of_sight"]["state"].clone());
        let states: Vec<Value> = states.collect();
        assert_eq!(states.len(), 1_000);
        (said.err, states)
    };
    let tables = [
        ("clock.csv", clock),
        ("eyes.csv", frozen(&table, &gaze, 200)),
        ("resting.csv", frozen(&table, &head, 0)),
        ("whole.csv", table),
    ];
    // Each takes as long as it was recorded for: all at once.
    let [clock, eyes, resting, whole] = std::thread::scope(|scope| {
        let each = tables
            .each_ref()
            .map(|(name, table)| scope.spawn(|| monitor(name, table)));
        each.map(|one| one.join().unwrap())
    });
    assert_eq!(whole.0, "");
    assert_eq!(clock.1[490], "full quality");
    for expected in [
        "the device's clock has stood still for 25",
        "the device's clock runs again, after 60",
        "the device's clock jumped by 90000 ms",
    ] {
        assert_eq!(clock.0.matches(expected).count(), 1, "{}", clock.0);
    }
    // Said at once, and again after a second with how often.
    let stuck = "a sample is not used: the gaze has not changed for";
    assert!(
        (2..=4).contains(&eyes.0.matches(stuck).count()),
        "{}",
        eyes.0
    );
    assert!(eyes.0.contains("times before)"), "{}", eyes.0);
    // A head that never moved rests: that is said, and its samples are used.
    let rests = "the head has not changed by a bit for 50";
    assert_eq!(resting.0.matches(rests).count(), 1, "{}", resting.0);
    assert!(!resting.0.contains("is not used"), "{}", resting.0);
    assert_ne!(resting.1[999], "full quality");
}
