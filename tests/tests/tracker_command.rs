//! `shisen tracker` over pseudo-terminals, and `shisen cave --tracker`.
#![cfg(unix)]

use serde_json::{Value, json};
use shisen::tracker::{Feed, Notice, Recorder, Spec};
use shisen_tests::command::{folder, line, refused, report, run, shisen};
use shisen_tracker::time::Micros;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// The protocols that go over a serial line.
const SERIAL: [&str; 8] = [
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

impl Running {
    /// Ends it as Ctrl-C does; returns what it has printed.
    pub(super) fn interrupt(&mut self) -> String {
        let id = self.0.id().to_string();
        let status = Command::new("kill").args(["-INT", &id]).status();
        assert!(status.unwrap().success());
        self.finish()
    }

    /// Waits until it has ended well; returns what it has printed.
    pub(super) fn finish(&mut self) -> String {
        let said = std::io::read_to_string(self.0.stdout.take().unwrap()).unwrap();
        assert!(self.0.wait().unwrap().success(), "{said}");
        said
    }
}

pub(super) fn start(folder: &Path, words: &str) -> Running {
    let mut command = Command::new(shisen(folder).get_program());
    command.current_dir(folder).args(words.split(' '));
    command.stdin(Stdio::null());
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    Running(command.spawn().unwrap())
}

/// Waits until a file is there.
pub(super) fn await_file(path: &Path) {
    let (begun, shown) = (Instant::now(), path.display());
    while !path.exists() {
        assert!(begun.elapsed() < Duration::from_mins(1), "{shown}");
        thread::sleep(Duration::from_millis(2));
    }
}

/// Returns a command that makes the line `tracker` in `folder`, once that is there.
pub(super) fn start_on_line(folder: &Path, words: &str) -> Running {
    // A command that was killed leaves its name behind, which may lead to another test's line.
    let _ = std::fs::remove_file(folder.join("tracker"));
    let running = start(folder, words);
    await_file(&folder.join("tracker"));
    running
}

/// Returns a mock on the line `tracker` in `folder`.
fn mock(folder: &Path, protocol: &str) -> Running {
    start_on_line(
        folder,
        &format!("tracker serve mock --to tracker --as {protocol}"),
    )
}

/// Reads what comes on a line, once it is there, until it is gone.
pub(super) fn reader(folder: &Path) {
    let path = folder.join("line");
    let _ = std::fs::remove_file(&path);
    std::thread::spawn(move || {
        await_file(&path);
        let mut file = std::fs::File::open(&path).unwrap();
        let mut buffer = [0; 256];
        while let Ok(1..) = file.read(&mut buffer) {}
    });
}

/// Records a simulated tracker, without waiting for it.
pub(super) fn record(folder: &Path, spec: &str, file: &str, frames: u64) {
    let spec: Spec = spec.parse().unwrap();
    let mut feed = Feed::open(&spec).unwrap();
    let mut recorder = Recorder::create(&folder.join(file)).unwrap();
    let mut time = Micros(0);
    while feed.counts().samples < frames {
        time = time.after(Micros(100));
        feed.poll(time, &mut |notice| {
            if let Notice::Decoded(event) = notice {
                recorder.push(&event, 0).unwrap();
            }
        });
    }
    recorder.finish().unwrap();
}

/// Returns the samples that `shisen tracker monitor` prints of a mock behind a line.
fn monitored(protocol: &str, spec: &str, frames: usize) -> (Vec<Value>, String) {
    let folder = folder();
    let _mock = mock(folder.path(), protocol);
    let words = format!("tracker monitor serial:tracker?protocol={spec} --json --seconds 20");
    let said = run(folder.path(), &format!("{words} --frames {frames}"));
    let records = said.objects();
    assert_eq!(records.len(), frames, "{protocol}: {spec}");
    // What was sent before the device was set up belongs to no record.
    assert_eq!(
        records[frames - 1]["dropped"],
        records[0]["dropped"],
        "{spec}"
    );
    (records, said.err)
}

#[test]
fn every_serial_protocol_is_read_from_a_line() {
    for protocol in SERIAL {
        let (records, _) = monitored(protocol, protocol, 100);
        for (number, record) in records.iter().enumerate() {
            assert_eq!(record["number"], number, "{protocol}");
        }
        // A blink may hide the gaze for a fifth of them.
        let has_place = |record: &&Value| {
            record["head"]["orientation"].is_object() || record["gaze_point"].is_object()
        };
        let count = records.iter().filter(has_place).count();
        assert!(count >= 60, "{protocol}: {count}");
        assert_eq!(records[99]["lost"], 0, "{protocol}");
        // It streams at 500 Hz before it is set up.
        let held_back = records[99]["held_back"].as_u64().unwrap();
        assert!(held_back < 500, "{protocol}: {held_back}");
        // Samples from before do not count, and those after are believed within a second.
        let arrival = |i: usize| records[i]["arrival_us"].as_u64().unwrap();
        let gap = arrival(5) - arrival(0);
        assert!(
            gap < 200_000 && arrival(0) < 1_000_000,
            "{protocol}: {gap} µs"
        );
    }
}

#[test]
fn a_device_that_goes_and_comes_back_is_followed() {
    let folder = folder();
    let first = mock(folder.path(), "hatire");
    let words = "tracker monitor serial:tracker?protocol=hatire --json";
    let mut monitor = start(folder.path(), words);
    let mut records = BufReader::new(monitor.0.stdout.take().unwrap()).lines();
    let errors = BufReader::new(monitor.0.stderr.take().unwrap());
    records.next().unwrap().unwrap();
    drop(first);
    let mut errors = errors.lines().map(Result::unwrap);
    let mut says = |words: &str| {
        let said = errors.next().unwrap();
        assert!(said.contains(words), "{said}");
    };
    says("plugged in");
    says("tracker is gone");
    let _second = mock(folder.path(), "hatire");
    says("plugged in");
    for _ in 0..400 {
        let record: Value = serde_json::from_str(&records.next().unwrap().unwrap()).unwrap();
        assert_eq!(record["head"]["orientation"]["tracked"], true);
    }
}

/// What a monitor says of streams that are not of its protocol, or not of its settings.
#[test]
fn another_protocol_on_the_line_is_told() {
    let of_outputs = "iscan?outputs=gaze-x,gaze-y,pupil-diameter";
    let no_record = ["no record among them", "another baud rate"];
    for (protocol, spec, expected) in [
        ("hatire", "adhawk", &no_record[..]),
        (
            of_outputs,
            "iscan",
            &[
                "no record among them",
                "list of items, outputs, format",
                "records of 3 outputs seem to come in",
            ],
        ),
        // A Flock's decoder takes some of another protocol's bytes for records.
        ("liberty", "flock&format=angles", &["belong to no record"]),
    ] {
        let folder = folder();
        let _mock = mock(folder.path(), protocol);
        let words = format!("tracker monitor serial:tracker?protocol={spec} --json --seconds 2.5");
        let output = line(folder.path(), &words).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        for expected in expected {
            assert_eq!(said.matches(expected).count(), 1, "{spec}: {said}");
        }
        assert_eq!(output.status.success(), !output.stdout.is_empty(), "{said}");
        if let Some(last) = output.stdout.split(|&byte| byte == b'\n').rev().nth(1) {
            let last: Value = serde_json::from_slice(last).unwrap();
            let by = last["dropped_by"].as_object().unwrap();
            let sum: u64 = by.values().filter_map(Value::as_u64).sum();
            assert!(
                last["dropped"] == sum && by.contains_key("out of step"),
                "{last}"
            );
            assert_eq!(
                (&last["clock"], &last["late_us"]),
                (&json!("none"), &Value::Null)
            );
        }
    }
}

/// What is set at one end is asked of the other, or has to be the same there.
#[test]
fn settings_go_over_the_line() {
    for (protocol, spec) in [
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
        for record in monitored(protocol, spec, 20).0 {
            // The mock's head sways by 20 mm.
            let place: Vec<f64> =
                serde_json::from_value(record["head"]["position"]["value"].clone()).unwrap();
            assert!(
                place.iter().all(|part| part.abs() < 0.1),
                "{spec}: {place:?} m"
            );
        }
    }
    let outputs = "outputs=gaze-x,gaze-y,pupil-diameter";
    let (records, _) = monitored(&format!("iscan?{outputs}"), &format!("iscan&{outputs}"), 50);
    assert!(records[49]["gaze_point"].is_object());
}

#[test]
fn birds_of_a_group_are_sensors_of_their_own() {
    let folder = folder();
    let (on_a_line, _) = monitored("flock?group=1&birds=3", "flock&group=1&birds=3", 60);
    let words = "tracker monitor mock:as=flock&group=1&birds=3 --json --frames 60";
    for records in [on_a_line, run(folder.path(), words).objects()] {
        for sensor in 0..3 {
            let own = records.iter().filter(|record| record["sensor"] == sensor);
            assert_eq!(own.count(), 20, "{sensor}");
        }
    }
    // One that was left in group mode is taken out of it: its second bird is no viewer.
    let (records, _) = monitored("flock?group=1&birds=2", "flock", 100);
    let across = |record: &Value| record["head"]["position"]["value"][0].as_f64().unwrap();
    for pair in records.windows(2) {
        // The birds are 0.1 m apart.
        assert!(
            (across(&pair[1]) - across(&pair[0])).abs() < 0.05,
            "{pair:?}"
        );
    }
}

#[test]
fn unusable_trackers_are_refused() {
    let folder = folder();
    let usage = "mouse => serial:/dev/ttyUSB0
        mock:rate=5 => 60 to 10000
        mock:rate=60&rate=60 => twice
        serial:?protocol=asl => names no port
        serial:/dev/nowhere?protocol=asl&units=cm => layout=numbered
        mock:as=mouse => osvr-hdk
        vrpn:Tracker0 => vrpn:Tracker0@
        lsl:gaze => type=Gaze
        lsl:type=Gaze?camera=1,2,3 => 770,770,800,600
        lsl:type=Gaze?head=1 => lsl has one sensor
        udp:4242 => ?protocol=opentrack
        dtrack:0 => 0.0.0.0 is all
        tcp:localhost => tcp:localhost:7000
        natnet:a?frame=up,up,up => right-handed
        serial:/dev/nowhere => ?protocol=NAME";
    let failure = "serial:/dev/nowhere?protocol=asl => /dev/nowhere
        serial:/dev/null?protocol=asl => it is not a serial port
        hid:fffe:fffd => fffe:fffd
        vrpn:Tracker0@127.0.0.1:9 => cannot reach 127.0.0.1:9
        natnet:127.0.0.1:9 => no NatNet server
        replay:nothing.csv => nothing.csv";
    for (code, rows) in [(2, usage), (1, failure)] {
        for row in rows.lines().map(str::trim) {
            let table = format!("tracker monitor {row}\ncave --tracker {row}");
            refused(folder.path(), code, &table);
        }
    }
    refused(
        folder.path(),
        2,
        "
        tracker serve mock --as mouse => osvr-hdk
        tracker serve replay:a --to b --as mouse => osvr-hdk
        tracker monitor mock --frames -1 => from 1 on
        tracker monitor mock --seconds nan => from 0.001 to 86400
        tracker record mock a.csv --seconds 0 => from 0.001 to 86400
        tracker serve mock:rate=1e12 --to b => 60 to 10000
        tracker serve mock:seed=-1 --to b => a whole number from 0
        tracker serve replay:a.csv --frames 1.5 => from 1 on
        cave --tracker mock --frames 1e9 => from 1 to 100000
        cave --tracker mock --hz inf => from 1 to 1000",
    );
    report(folder.path(), "tracker list");
}

const SMALL: &str = "--scene grid --size 8 --eyes 1 --view-size 8x6";

/// The mock resets for longer than a silent device is waited for.
#[test]
fn frames_wait_for_a_reset() {
    let folder = folder();
    let _mock = mock(folder.path(), "fastrak?reset_s=6");
    let begun = Instant::now();
    let spec = "serial:tracker?protocol=fastrak&reset=1&reset_s=6";
    let found = report(
        folder.path(),
        &format!("cave --tracker {spec} --frames 3 {SMALL}"),
    );
    // The mock is back after nine tenths of the time that it may take.
    assert!(begun.elapsed() >= Duration::from_millis(5_400));
    for frame in 0..3 {
        assert_eq!(found["frames"][frame]["state"], "head direction", "{found}");
    }
}

#[test]
fn an_interrupt_ends_frames_with_a_report() {
    let folder = folder();
    let words = format!("cave --tracker mock --frames 100000 --out frames --json {SMALL}");
    let mut cave = start(folder.path(), &words);
    await_file(&folder.path().join("frames/frame-00003"));
    let report: Value = serde_json::from_str(&cave.interrupt()).unwrap();
    let frames = report["frames"].as_array().unwrap();
    assert!(frames.len() >= 3 && frames.len() < 100_000);
    for frame in frames {
        let image = frame["images"][0].as_str().unwrap();
        assert!(folder.path().join(image).exists(), "{image}");
    }
}

#[test]
fn a_line_in_use_is_not_taken_over() {
    let folder = folder();
    let link = folder.path().join("tracker");
    let first = mock(folder.path(), "hatire");
    let before = std::fs::read_link(&link).unwrap();
    refused(
        folder.path(),
        1,
        "tracker serve mock --as asl --to tracker => in use",
    );
    assert_eq!(std::fs::read_link(&link).unwrap(), before);
    // Killed, it leaves its name behind.
    drop(first);
    assert!(std::fs::read_link(&link).is_ok());
    mock(folder.path(), "asl").interrupt();
    assert!(std::fs::read_link(&link).is_err());
}

/// What a device refuses.
#[test]
fn what_a_device_says_is_told_in_words() {
    let all_said = |records: &[Value]| -> Vec<Value> {
        let said = records
            .iter()
            .map(|record| record["said"].as_array().unwrap());
        said.flatten().cloned().collect()
    };
    // One station more than there are.
    let (records, said) = monitored("fastrak?stations=1", "fastrak&stations=2", 50);
    let refused = "the device refused command 'O': a field is out of range (code 3)";
    assert!(said.contains(refused), "{said}");
    let reply = json!({
        "kind": "reply", "command": 79, "result": 3, "meaning": "a field is out of range"
    });
    assert!(all_said(&records).contains(&reply), "{records:?}");
    // A Flock is asked what was wrong, since it does not say so of itself.
    let (_, said) = monitored("flock", "flock&letter=%", 50);
    let fault = "the device reports fault 6: a command that does not exist";
    assert!(said.contains(fault), "{said}");
}
