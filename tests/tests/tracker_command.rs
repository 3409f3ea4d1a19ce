//! `shisen tracker` over real pseudo-terminals, and `shisen cave --tracker`.
#![cfg(unix)]

use serde_json::Value;
use shisen_tests::command::shisen;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The protocols that go over a serial line.
pub(super) const SERIAL: [&str; 8] = [
    "link", "fastrak", "liberty", "flock", "hatire", "iscan", "asl", "adhawk",
];

/// A command that runs until it is dropped.
pub(super) struct Running(pub(super) Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

pub(super) fn start(folder: &Path, arguments: &[&str]) -> Running {
    let command = shisen(folder);
    let mut command = Command::new(command.get_program());
    command.current_dir(folder).args(arguments);
    command.stdin(Stdio::null());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    Running(command.spawn().unwrap())
}

/// A mock on the line `tracker` in `folder`.
fn mock(folder: &Path, protocol: &str) -> Running {
    start_on_line(
        folder,
        &["tracker", "mock", "--as", protocol, "--pty", "tracker"],
    )
}

/// A command that makes the line `tracker` in `folder`, once that is there.
pub(super) fn start_on_line(folder: &Path, arguments: &[&str]) -> Running {
    // Who was killed leaves a name behind, which may lead to a line that another test
    // has opened since.
    let _ = std::fs::remove_file(folder.join("tracker"));
    let running = start(folder, arguments);
    let begun = Instant::now();
    while !folder.join("tracker").exists() {
        assert!(begun.elapsed() < Duration::from_secs(10), "{arguments:?}");
        std::thread::sleep(Duration::from_millis(5));
    }
    running
}

/// Reads whatever comes on a line, once it is there, until it is gone.
pub(super) fn reader(folder: &Path, line: &str) -> std::thread::JoinHandle<usize> {
    let path = folder.join(line);
    // What is left of one before leads nowhere.
    let _ = std::fs::remove_file(&path);
    std::thread::spawn(move || {
        let begun = Instant::now();
        let mut file = loop {
            match std::fs::File::open(&path) {
                Ok(file) => break file,
                Err(error) => assert!(begun.elapsed() < Duration::from_secs(20), "{error}"),
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        let (mut buffer, mut read) = ([0; 256], 0);
        while let Ok(count @ 1..) = file.read(&mut buffer) {
            read += count;
        }
        read
    })
}

pub(super) fn lines(output: &[u8]) -> Vec<Value> {
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
        }
        // A blink may hide the gaze for a fifth of them.
        let says = |record: &&Value| {
            record["head"]["orientation"].is_object() || record["gaze_point"].is_object()
        };
        let said = records.iter().filter(says).count();
        assert!(said >= 60, "{protocol}: {said}");
        assert_eq!(records[99]["lost"], 0, "{protocol}");
        // Those that it sent of itself, at 500 Hz.
        let held_back = records[99]["held_back"].as_u64().unwrap();
        assert!(held_back < 500, "{protocol}: {held_back}");
        // What the device sent before it was set up, a third of a second before
        // it is, does not count.
        let arrival = |i: usize| records[i]["arrival_us"].as_u64().unwrap();
        let gap = arrival(5) - arrival(0);
        assert!(gap < 200_000, "{protocol}: {gap} µs");
        // It streams as the line is opened, and is believed within a second of that.
        assert!(arrival(0) < 1_000_000, "{protocol}: {} µs", arrival(0));
    }
}

/// Through the line, as any program would: stopped, it answers, and sends a record
/// for each that is asked for.
#[test]
fn a_mock_answers_on_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let _mock = mock(folder.path(), "fastrak?reset_s=1");
    let line = std::fs::OpenOptions::new()
        .read(true)
        .write(true)
        .open(folder.path().join("tracker"))
        .unwrap();
    let (send, heard) = std::sync::mpsc::channel();
    let mut ear = line.try_clone().unwrap();
    std::thread::spawn(move || {
        let mut buffer = [0; 256];
        while let Ok(count @ 1..) = ear.read(&mut buffer) {
            if send.send(buffer[..count].to_vec()).is_err() {
                return;
            }
        }
    });
    let tell = |bytes: &[u8], wait: u64| {
        (&line).write_all(bytes).unwrap();
        let mut all = Vec::new();
        while let Ok(bytes) = heard.recv_timeout(Duration::from_millis(wait)) {
            all.extend(bytes);
        }
        all
    };
    // It streams of itself.
    assert!(heard.recv_timeout(Duration::from_secs(10)).is_ok());
    tell(b"c", 300);
    assert_eq!(tell(b"", 300), b"");
    let record = tell(b"P", 300);
    assert_eq!((record.len(), &record[..3]), (32, &b"01 "[..]));
    assert_eq!(
        tell(b"O1,999,0\r", 300),
        b"2 E*ERROR*O*ERROR* EC-3*PS3*FL1*ST0\r\n"
    );
    assert!(tell(b"S", 300).starts_with(b"21S3F1    F31  00.00 SHISEN MOCK"));
    // Away for a second; then as it was at first.
    (&line).write_all(b"\x19").unwrap();
    let begun = Instant::now();
    assert!(heard.recv_timeout(Duration::from_secs(20)).is_ok());
    let away = begun.elapsed();
    assert!(away >= Duration::from_millis(850), "{away:?}");
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
        .args(["--json", "--seconds", "2.5"])
        .assert()
        .code(1);
    let output = output.get_output();
    let said = std::str::from_utf8(&output.stderr).unwrap();
    assert!(said.contains("no record among them"), "{said}");
    assert!(said.contains("another baud rate"), "{said}");
    assert!(output.stdout.is_empty());
}

/// A Flock's decoder takes some of what others send for records; that is said
/// all the same, and once.
#[test]
fn records_by_chance_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let _mock = mock(folder.path(), "liberty");
    let spec = "serial:tracker?protocol=flock&format=angles";
    let output = shisen(folder.path())
        .args(["tracker", "monitor", spec, "--json", "--seconds", "4"])
        .assert()
        .success();
    let output = output.get_output();
    assert!(!lines(&output.stdout).is_empty());
    let said = std::str::from_utf8(&output.stderr).unwrap();
    assert_eq!(said.matches("belong to no record").count(), 1, "{said}");
}

/// What is set at one end is asked of the other, or has to be the same there.
#[test]
fn settings_go_over_the_line() {
    let folder = tempfile::tempdir().unwrap();
    let read = |protocol: &str, spec: &str| {
        let _mock = mock(folder.path(), protocol);
        let output = shisen(folder.path())
            .args(["tracker", "monitor", spec, "--json"])
            .args(["--frames", "50", "--seconds", "10"])
            .assert()
            .success();
        lines(&output.get_output().stdout)
    };
    for (protocol, settings) in [
        ("fastrak", "fastrak&items=2,4,1&format=ascii&units=cm"),
        ("fastrak?format=ascii&units=cm", "fastrak"),
        ("liberty?units=cm&model=patriot", "liberty&items=2,7,0"),
        ("flock", "flock&format=position-matrix&group=1"),
        ("flock?range=144", "flock&range=144&format=position-angles"),
        (
            "liberty?size=big&records=any",
            "liberty&size=big&records=any",
        ),
        (
            "flock?letter=q&run=E&half_turn=360&format=position-angles",
            "flock&letter=q&run=E&half_turn=360&format=position-angles",
        ),
    ] {
        let records = read(protocol, &format!("serial:tracker?protocol={settings}"));
        assert_eq!(records.len(), 50, "{protocol} {settings}");
        // What was sent before it was set up belongs to no record.
        let dropped = |i: usize| records[i]["dropped"].as_u64().unwrap();
        assert_eq!(dropped(49), dropped(0), "{protocol} {settings}");
        for record in &records {
            // The mock's head sways by 20 mm.
            for part in record["head"]["position"]["value"].as_array().unwrap() {
                let part = part.as_f64().unwrap().abs();
                assert!(part < 0.1, "{protocol} {settings}: {part} m");
            }
        }
    }
    let outputs = "iscan&outputs=gaze-x,gaze-y,pupil-diameter";
    let records = read(
        "iscan?outputs=gaze-x,gaze-y,pupil-diameter",
        &format!("serial:tracker?protocol={outputs}"),
    );
    assert!(records[49]["gaze_point"].is_object());
}

#[test]
fn the_help_has_every_setting() {
    let folder = tempfile::tempdir().unwrap();
    let output = shisen(folder.path())
        .args(["tracker", "--help"])
        .assert()
        .success();
    let help = std::str::from_utf8(&output.get_output().stdout).unwrap();
    let page = include_str!("../../host/doc/trackers.md");
    for key in [
        "items",
        "format",
        "units",
        "stations",
        "reset_s",
        "word_metres",
        "word_degrees",
        "model",
        "range",
        "group",
        "birds",
        "first",
        "inverse",
        "confirm",
        "letter",
        "run",
        "half_turn",
        "records",
        "size",
        "bytes",
        "order",
        "position",
        "frame",
        "sensor",
        "outputs",
        "largest",
        "zero",
        "layout",
        "rate",
        "axes",
        "origin",
    ] {
        assert!(help.contains(&format!("{key}=")), "{key} in the help");
        let named = [format!("`{key}="), format!("`{key}`")];
        let shown = named.iter().any(|name| page.contains(name));
        assert!(shown, "{key} in host/doc/trackers.md");
    }
}

/// What is no tracker at all is a slip of the command line; what is not there
/// is none.
#[test]
fn what_is_no_tracker_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |arguments: &[&str], code: i32, expected: &str| {
        let output = shisen(folder.path()).args(arguments).assert().code(code);
        let said = std::str::from_utf8(&output.get_output().stderr).unwrap();
        assert!(said.contains(expected), "{arguments:?}: {said}");
        assert!(output.get_output().stdout.is_empty());
    };
    for (spec, code, expected) in [
        ("mouse", 2, "serial:/dev/ttyUSB0"),
        ("mock:rate=5", 2, "60 to 10000"),
        ("mock:rate=60&rate=60", 2, "twice"),
        ("serial:?protocol=asl", 2, "names no port"),
        (
            "serial:/dev/nowhere?protocol=asl&units=cm",
            2,
            "layout=numbered",
        ),
        ("mock:as=mouse", 2, "osvr-hdk"),
        ("serial:/dev/nowhere", 2, "?protocol=NAME"),
        ("serial:/dev/nowhere?protocol=asl", 1, "/dev/nowhere"),
        ("serial:/dev/null?protocol=asl", 1, "it is no serial port"),
        ("hid:fffe:fffd", 1, "fffe:fffd"),
        ("replay:nothing.csv", 1, "nothing.csv"),
    ] {
        refused(&["tracker", "monitor", spec], code, expected);
        refused(&["tracker", "record", spec, "a.csv"], code, expected);
        refused(&["cave", "--tracker", spec], code, expected);
    }
    refused(&["tracker", "mock", "--as", "mouse"], 2, "osvr-hdk");
    let replay = ["tracker", "replay", "a", "--to", "b", "--as", "mouse"];
    refused(&replay, 2, "osvr-hdk");
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
            .args(["--view-size", "32x24"])
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

/// A device that a recording is to be sends what it has been recorded with.
#[test]
fn a_recording_is_not_made_up() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (file, spec) in [("eye.csv", "mock:as=iscan"), ("head.csv", "mock:as=hatire")] {
        shisen(folder)
            .args(["tracker", "record", spec, file, "--frames", "100"])
            .assert()
            .success();
    }
    for (file, protocol, lacks) in [
        ("eye.csv", "fastrak", "no head's pose"),
        ("eye.csv", "flock", "no head's pose"),
        ("eye.csv", "hatire", "no head's pose"),
        ("head.csv", "iscan", "no gaze"),
        ("head.csv", "asl", "no gaze"),
        ("head.csv", "adhawk", "no gaze"),
        // It turns, and is nowhere.
        ("head.csv", "liberty", "no head's pose"),
    ] {
        let output = shisen(folder)
            .args(["tracker", "replay", file, "--to", "line", "--as", protocol])
            .assert()
            .code(1);
        let said = std::str::from_utf8(&output.get_output().stderr).unwrap();
        let plain: Vec<&str> = said.split_whitespace().collect();
        assert!(plain.join(" ").contains(lacks), "{file} {protocol}: {said}");
        assert!(said.contains("link"), "{said}");
    }
    // For some samples only: they are sent as what they are.
    let table = std::fs::read_to_string(folder.join("head.csv")).unwrap();
    let columns: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let blank = |line: &str| {
        let cells = line.split(',').zip(&columns).map(|(cell, column)| {
            let of_turn = column.starts_with("head_q") || *column == "head_turn_tracked";
            if of_turn { "" } else { cell }
        });
        cells.collect::<Vec<_>>().join(",")
    };
    let both = table.lines().enumerate().map(|(i, line)| {
        if (1..=30).contains(&i) {
            blank(line)
        } else {
            line.into()
        }
    });
    let both: Vec<String> = both.collect();
    std::fs::write(folder.join("both.csv"), both.join("\n")).unwrap();
    let arguments = ["tracker", "replay", "both.csv", "--to", "line", "--as"];
    for (protocol, expected) in [
        (
            "fastrak?items=11,0",
            "30 of 100 samples hold no head's pose with all that its records hold: they are sent as not tracked",
        ),
        ("hatire", "they are left out"),
    ] {
        let _reader = reader(folder, "line");
        let output = shisen(folder)
            .args(arguments)
            .args([protocol, "--frames", "70"])
            .assert()
            .success();
        let said = std::str::from_utf8(&output.get_output().stderr).unwrap();
        assert!(said.contains(expected), "{protocol}: {said}");
    }
}

#[test]
fn a_line_in_use_is_not_taken_over() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("tracker");
    let first = mock(folder.path(), "hatire");
    let line = std::fs::read_link(&link).unwrap();
    let output = shisen(folder.path())
        .args(["tracker", "mock", "--as", "asl", "--pty", "tracker"])
        .assert()
        .code(1);
    let said = std::str::from_utf8(&output.get_output().stderr).unwrap();
    assert!(said.contains("in use"), "{said}");
    assert_eq!(std::fs::read_link(&link).unwrap(), line);
    // Killed, it leaves its name behind.
    drop(first);
    assert!(std::fs::read_link(&link).is_ok());
    let second = mock(folder.path(), "asl");
    assert!(link.exists());
    interrupt(&second);
    let begun = Instant::now();
    while std::fs::read_link(&link).is_ok() {
        assert!(begun.elapsed() < Duration::from_secs(10));
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// As Ctrl-C does.
pub(super) fn interrupt(running: &Running) {
    let status = Command::new("kill")
        .args(["-INT", &running.0.id().to_string()])
        .status();
    assert!(status.unwrap().success());
}

/// A reset takes longer than a device that says nothing is waited for.
#[test]
fn frames_wait_for_a_reset() {
    let folder = tempfile::tempdir().unwrap();
    let _mock = mock(folder.path(), "fastrak?reset_s=7");
    let begun = Instant::now();
    let output = shisen(folder.path())
        .args([
            "cave",
            "--size",
            "8",
            "--eyes",
            "1",
            "--view-size",
            "8x6",
            "--json",
            "--frames",
            "3",
        ])
        .args([
            "--tracker",
            "serial:tracker?protocol=fastrak&reset=1&reset_s=7",
        ])
        .assert()
        .success();
    // The simulated one is back after nine tenths of the time that it may take,
    // and a host goes on where it is.
    assert!(begun.elapsed() >= Duration::from_millis(6_300));
    let report: Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    let frames = report["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 3);
    for frame in frames {
        assert_eq!(frame["state"], "head direction", "{frame}");
    }
}

#[test]
fn frames_end_with_a_report() {
    let folder = tempfile::tempdir().unwrap();
    let mut cave = start(
        folder.path(),
        &[
            "cave",
            "--tracker",
            "mock",
            "--frames",
            "100000",
            "--view-size",
            "8x6",
            "--size",
            "8",
            "--eyes",
            "1",
            "--out",
            "frames",
            "--json",
        ],
    );
    let begun = Instant::now();
    while !folder.path().join("frames/frame-00003").exists() {
        assert!(begun.elapsed() < Duration::from_secs(30));
        std::thread::sleep(Duration::from_millis(5));
    }
    interrupt(&cave);
    let mut said = String::new();
    let mut stdout = cave.0.stdout.take().unwrap();
    stdout.read_to_string(&mut said).unwrap();
    assert!(cave.0.wait().unwrap().success());
    let report: Value = serde_json::from_str(&said).unwrap();
    let frames = report["frames"].as_array().unwrap();
    assert!(frames.len() >= 3 && frames.len() < 100_000);
    for frame in frames {
        let image = frame["images"][0].as_str().unwrap();
        assert!(folder.path().join(image).exists(), "{image}");
    }
}

#[test]
fn numbers_out_of_range_are_told_the_range() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, range) in [
        (
            &["tracker", "monitor", "mock", "--frames", "-1"][..],
            "from 1 on",
        ),
        (
            &["tracker", "monitor", "mock", "--seconds", "nan"],
            "from 0.001 to 86400",
        ),
        (
            &["tracker", "record", "mock", "a.csv", "--seconds", "0"],
            "from 0.001 to 86400",
        ),
        (&["tracker", "mock", "--rate", "1e12"], "from 60 to 10000"),
        (&["tracker", "mock", "--rate", "-5"], "from 60 to 10000"),
        (&["tracker", "mock", "--seed", "-1"], "from 0 on"),
        (
            &["tracker", "replay", "a.csv", "--frames", "1.5"],
            "from 1 on",
        ),
        (
            &["cave", "--tracker", "mock", "--frames", "-1"],
            "from 1 to 100000",
        ),
        (
            &["cave", "--tracker", "mock", "--frames", "1e9"],
            "from 1 to 100000",
        ),
        (
            &["cave", "--tracker", "mock", "--hz", "inf"],
            "from 1 to 1000",
        ),
    ] {
        let output = shisen(folder.path()).args(arguments).assert().code(2);
        let said = std::str::from_utf8(&output.get_output().stderr).unwrap();
        assert!(said.contains(range), "{arguments:?}: {said}");
    }
}

/// Changes cells of a table in the lines from `first` on, of which the header is 0.
fn change(table: &str, column: &str, mut cell: impl FnMut(usize, &str) -> String) -> String {
    let at = table.lines().next().unwrap().split(',');
    let at = at.clone().position(|name| name == column).unwrap();
    let lines = table.lines().enumerate().map(|(number, line)| {
        let mut cells: Vec<String> = line.split(',').map(String::from).collect();
        if number > 0 {
            cells[at] = cell(number, &cells[at]);
        }
        cells.join(",")
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// A clock that stands still, runs and jumps, and eyes or a head that are frozen.
#[test]
fn what_happens_to_clock_and_gaze_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    shisen(folder)
        .args(["tracker", "record", "mock:seed=2&still=1", "a.csv"])
        .args(["--frames", "2000"])
        .assert()
        .success();
    std::fs::write(folder.join("a.toml"), "head = [0, 0, 0]\n").unwrap();
    let monitor = |file: &str| {
        let spec = format!("replay:{file}");
        let output = shisen(folder)
            .args(["tracker", "monitor", &spec, "--calibration", "a.toml"])
            .arg("--json")
            .assert()
            .success();
        let output = output.get_output();
        let states = lines(&output.stdout).into_iter().map(|record| {
            let state = record["line_of_sight"]["state"].as_str().unwrap();
            state.to_owned()
        });
        let states: Vec<String> = states.collect();
        assert_eq!(states.len(), 2_000);
        (String::from_utf8(output.stderr.clone()).unwrap(), states)
    };
    assert_eq!(monitor("a.csv").0, "");
    let table = std::fs::read_to_string(folder.join("a.csv")).unwrap();
    // 500 Hz: from 1 s to 1.6 s, and from 3 s on.
    let mut still = String::new();
    let clock = change(&table, "device_us", |line, cell| match line {
        500..800 => still.clone(),
        1_500.. => (cell.parse::<u64>().unwrap() + 90_000_000).to_string(),
        _ => {
            still = cell.to_owned();
            cell.to_owned()
        }
    });
    std::fs::write(folder.join("clock.csv"), clock).unwrap();
    let (said, states) = monitor("clock.csv");
    assert_eq!(states[790], "full quality");
    for (expected, count) in [
        ("the device's clock has stood still for 25", 1),
        ("the device's clock runs again, after 60", 1),
        ("the device's clock jumped by 90000 ms", 1),
    ] {
        assert_eq!(said.matches(expected).count(), count, "{said}");
    }
    let mut frozen = table.clone();
    for eye in ["left", "right"] {
        for axis in ["x", "y", "z"] {
            let name = format!("{eye}_direction_{axis}");
            let mut same = String::new();
            frozen = change(&frozen, &name, |line, cell| {
                if same.is_empty() || line < 500 {
                    cell.clone_into(&mut same);
                }
                if cell.is_empty() {
                    String::new()
                } else {
                    same.clone()
                }
            });
        }
    }
    std::fs::write(folder.join("eyes.csv"), frozen).unwrap();
    let (said, _) = monitor("eyes.csv");
    let stuck = "a sample is not used: the gaze has not changed for";
    let count = said.matches(stuck).count();
    assert!((2..=4).contains(&count), "{said}");
    assert!(said.contains("times before)"), "{said}");
    // Frozen from 1 s on, and all the time.
    for first in [500, 0] {
        let mut frozen = table.clone();
        for name in [
            "head_x", "head_y", "head_z", "head_qx", "head_qy", "head_qz", "head_qw",
        ] {
            let mut same = String::new();
            frozen = change(&frozen, name, |line, cell| {
                if same.is_empty() || line < first {
                    cell.clone_into(&mut same);
                }
                same.clone()
            });
        }
        std::fs::write(folder.join("head.csv"), frozen).unwrap();
        let (said, states) = monitor("head.csv");
        let stuck = ["position", "orientation"].map(|part| {
            let said_of = format!("a sample is not used: the head's {part} has not changed for");
            said.matches(&said_of).count()
        });
        let still = said
            .matches("the head has not changed by a bit for 50")
            .count();
        if first == 0 {
            assert_eq!((stuck, still), ([0, 0], 1), "{said}");
            assert_ne!(states[1_999], "full quality");
        } else {
            let few = stuck.iter().all(|stuck| (1..=4).contains(stuck));
            assert!(few && still == 0, "{said}");
            assert_eq!(states[1_999], "full quality");
        }
    }
}

#[test]
fn drops_are_counted_by_reason() {
    let folder = tempfile::tempdir().unwrap();
    let _mock = mock(folder.path(), "flock?format=position-matrix&group=1");
    let output = shisen(folder.path())
        .args([
            "tracker",
            "monitor",
            "serial:tracker?protocol=flock&format=angles",
        ])
        .args(["--json", "--seconds", "2"])
        .assert()
        .success();
    let records = lines(&output.get_output().stdout);
    let last = records.last().unwrap();
    let by = last["dropped_by"].as_object().unwrap();
    let sum: u64 = by.values().map(|count| count.as_u64().unwrap()).sum();
    assert_eq!(last["dropped"], sum);
    assert!(by.contains_key("out of step"), "{by:?}");
    assert_eq!(
        (&last["clock"], &last["late_us"]),
        (&"none".into(), &Value::Null)
    );
}

/// A Flock that was left in group mode is taken out of it: its second bird is no viewer.
#[test]
fn one_bird_is_read_where_one_was_meant() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let _mock = mock(folder, "flock?group=1&birds=2");
    let output = shisen(folder)
        .args(["tracker", "monitor", "serial:tracker?protocol=flock"])
        .args(["--json", "--frames", "200", "--seconds", "20"])
        .assert()
        .success();
    let records = lines(&output.get_output().stdout);
    let across: Vec<f64> = records
        .iter()
        .map(|record| record["head"]["position"]["value"][0].as_f64().unwrap())
        .collect();
    assert_eq!(across.len(), 200);
    for pair in across.windows(2) {
        // The birds are 0.1 m apart.
        assert!((pair[1] - pair[0]).abs() < 0.05, "{pair:?}");
    }
    assert_eq!(records[199]["dropped"], records[0]["dropped"]);
}

/// What a device refuses, and what it says of the eyes, over the line.
#[test]
fn what_a_device_says_is_told_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let monitor = |protocol: &str, spec: &str, frames: &str| {
        let _mock = mock(folder, protocol);
        let output = shisen(folder)
            .args(["tracker", "monitor", spec, "--json", "--frames", frames])
            .args(["--seconds", "20"])
            .assert()
            .success();
        let output = output.get_output();
        let said = String::from_utf8(output.stderr.clone()).unwrap();
        (lines(&output.stdout), said)
    };
    let all_said = |records: &[Value]| -> Vec<Value> {
        let said = records
            .iter()
            .map(|record| record["said"].as_array().unwrap());
        said.flatten().cloned().collect()
    };
    // One station more than there are.
    let (records, said) = monitor(
        "fastrak?stations=1",
        "serial:tracker?protocol=fastrak&stations=2",
        "50",
    );
    let refused = "the device refused command 'O': a field is out of range (code 3)";
    assert!(said.contains(refused), "{said}");
    let reply = serde_json::json!({
        "kind": "reply", "command": 79, "result": 3, "meaning": "a field is out of range"
    });
    assert!(all_said(&records).contains(&reply), "{records:?}");
    // A Flock is asked what was wrong, since it does not say so of itself.
    let (records, said) = monitor("flock", "serial:tracker?protocol=flock&letter=%", "50");
    let fault = "the device reports fault 6: a command that does not exist";
    assert!(said.contains(fault), "{said}");
    assert_eq!(records[49]["dropped_bytes"], records[0]["dropped_bytes"]);
    // Blinks, of which there are 15 a minute.
    for protocol in ["adhawk", "link"] {
        let spec = format!("serial:tracker?protocol={protocol}&rate=250");
        let (records, _) = monitor(protocol, &spec, "3000");
        let said = all_said(&records);
        let of = |event: &str| said.iter().filter(|said| said["event"] == event).count();
        assert!(of("blink") > 0, "{protocol}: {said:?}");
        let (closed, opened) = (of("closed"), of("opened"));
        assert!(closed >= 2 && closed.abs_diff(opened) <= 2, "{said:?}");
        for said in said.iter().filter(|said| said["event"] == "blink") {
            let duration = said["duration_us"].as_u64().unwrap();
            assert!((20_000..900_000).contains(&duration), "{said}");
            assert!(
                said["eye"].is_null() && said["device_us"].is_u64(),
                "{said}"
            );
        }
        assert!(said.iter().any(|said| said["eye"] == "left"), "{said:?}");
    }
}

/// A list that is not the device's is told apart from a wrong speed as far as it can be.
#[test]
fn outputs_that_are_not_the_devices_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let _mock = mock(folder, "iscan?outputs=gaze-x,gaze-y,pupil-diameter");
    let output = shisen(folder)
        .args(["tracker", "monitor", "serial:tracker?protocol=iscan"])
        .args(["--json", "--seconds", "2"])
        .assert()
        .code(1);
    let said = String::from_utf8(output.get_output().stderr.clone()).unwrap();
    for expected in [
        "no record among them",
        "another baud rate",
        "list of items, outputs, format",
        "records of 3 outputs seem to come in",
    ] {
        assert!(said.contains(expected), "{expected}: {said}");
    }
}

/// Each bird of a group is a sensor of its own.
#[test]
fn a_group_of_birds_is_heard() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let _mock = mock(folder, "flock?group=1&birds=3");
    let on_a_line = "serial:tracker?protocol=flock&group=1&birds=3";
    for spec in [on_a_line, "mock:as=flock&group=1&birds=3"] {
        let output = shisen(folder)
            .args(["tracker", "monitor", spec, "--json", "--frames", "60"])
            .args(["--seconds", "20"])
            .assert()
            .success();
        let records = lines(&output.get_output().stdout);
        for sensor in 0..3 {
            let of = records.iter().filter(|record| record["sensor"] == sensor);
            assert_eq!(of.count(), 20, "{spec} {sensor}");
        }
        assert_eq!(records[59]["dropped"], records[0]["dropped"], "{spec}");
    }
}
