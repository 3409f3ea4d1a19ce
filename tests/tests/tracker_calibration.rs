//! `shisen tracker calibrate`, and what follows a calibration.
#![cfg(unix)]

use crate::tracker_command::{lines, start};
use glam::Vec3;
use serde_json::Value;
use shisen_tests::command::shisen;
use std::fmt::Write;
use std::path::Path;
use std::time::{Duration, Instant};

/// Places on a plane a metre ahead, each looked at for so many seconds.
fn script(folder: &Path, name: &str, places: &[[f32; 2]], seconds: f32) {
    let mut table = String::from("start_s,end_s,x,y,z\n");
    for (i, [x, y]) in places.iter().enumerate() {
        let start = i as f32 * seconds;
        writeln!(table, "{start},{},{x},{y},-1", start + seconds).unwrap();
    }
    std::fs::write(folder.join(name), table).unwrap();
}

const NINE: [[f32; 2]; 9] = [
    [-0.35, 0.25],
    [0.0, 0.25],
    [0.35, 0.25],
    [-0.35, 0.0],
    [0.0, 0.0],
    [0.35, 0.0],
    [-0.35, -0.25],
    [0.0, -0.25],
    [0.35, -0.25],
];

fn json(folder: &Path, arguments: &[&str]) -> Value {
    let output = shisen(folder).args(arguments).arg("--json").assert();
    serde_json::from_slice(&output.success().get_output().stdout).unwrap()
}

/// The angle between a direction in a report and another, degrees.
fn off(found: &Value, expected: Vec3) -> f32 {
    let part = |i: usize| found[i].as_f64().unwrap() as f32;
    let found = Vec3::new(part(0), part(1), part(2));
    found.angle_between(expected).to_degrees()
}

/// Where the viewer of a mock looks in the end, who looks at one place.
fn followed(folder: &Path, tracker: &str, calibration: &str) -> Value {
    let report = json(
        folder,
        &[
            &["cave", "--tracker", tracker, "--calibration", calibration][..],
            &["--frames", "20", "--hz", "60", "--scene", "grid"],
            &["--size", "4", "--eyes", "1", "--view-size", "4x3"],
        ]
        .concat(),
    );
    report["frames"][19].clone()
}

#[test]
fn raw_gaze_becomes_a_line_of_sight() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    script(folder, "nine.csv", &NINE, 1.0);
    script(folder, "one.csv", &[[0.2, -0.15]], 9.0);
    let there = Vec3::new(0.2, -0.15, -1.0);
    for protocol in ["iscan", "asl"] {
        for model in ["affine", "second-order"] {
            let tracker = format!("mock:as={protocol}&still=1&targets=nine.csv");
            let report = json(
                folder,
                &[
                    &["tracker", "calibrate", &tracker, "a.toml"][..],
                    &["--targets", "nine.csv", "--model", model],
                ]
                .concat(),
            );
            assert_eq!(report["device"], protocol);
            assert_eq!(report["model"], model);
            assert!(report["left"].is_null());
            let rms = report["combined"]["rms_deg"].as_f64().unwrap();
            // The mock's eyes wander about a target by microsaccades.
            assert!(rms < 0.4, "{protocol} {model}: {rms}");
            let targets = report["targets"].as_array().unwrap();
            assert_eq!(targets.len(), 9);
            for target in targets {
                assert!(target["samples"].as_u64().unwrap() > 200, "{target}");
                assert!(target["combined"]["residual_deg"].as_f64().unwrap() < 0.8);
            }
            // Of another run, and of a place between the targets.
            let tracker = format!("mock:as={protocol}&still=1&seed=5&targets=one.csv");
            let frame = followed(folder, &tracker, "a.toml");
            assert_eq!(frame["state"], "fresh", "{protocol} {model}");
            let off = off(&frame["gaze"], there);
            assert!(off < 1.0, "{protocol} {model}: {off}°");
        }
    }
    // The last was of ASL.
    let output = shisen(folder)
        .args(["tracker", "monitor", "--calibration", "a.toml", "--json"])
        .args(["mock:as=asl&still=1&targets=one.csv", "--frames", "300"])
        .assert()
        .success();
    let records = lines(&output.get_output().stdout);
    let sight = &records[299]["line_of_sight"];
    assert_eq!(sight["state"], "fresh");
    assert!(off(&sight["direction"], there) < 1.0, "{sight}");
}

/// The file that the documentation shows is the mock's screen.
#[test]
fn the_screen_of_the_documentation_is_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let page = include_str!("../../host/doc/trackers.md");
    let (_, file) = page.split_once("```text\n[room_from_tracker]").unwrap();
    let (file, _) = file.split_once("```").unwrap();
    let file = format!("[room_from_tracker]{file}");
    assert!(file.contains("[screen]"), "{file}");
    std::fs::write(folder.join("screen.toml"), file).unwrap();
    let output = shisen(folder)
        .args(["tracker", "monitor", "mock:as=hid", "--json"])
        .args(["--calibration", "screen.toml", "--frames", "1000"])
        .assert()
        .success();
    let text = String::from_utf8(output.get_output().stdout.clone()).unwrap();
    let fresh = text.matches("\"state\":\"fresh\"").count();
    assert!(fresh > 900, "{fresh}");
}

#[test]
fn directions_are_calibrated_with_the_head_that_turns() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    script(folder, "nine.csv", &NINE, 1.0);
    script(folder, "one.csv", &[[0.2, -0.15]], 9.0);
    let tracker = "mock:as=link&targets=nine.csv";
    let arguments = [
        "tracker",
        "calibrate",
        tracker,
        "a.toml",
        "--targets",
        "nine.csv",
    ];
    let report = json(folder, &arguments);
    assert!(report["combined"].is_null());
    for eye in ["left", "right"] {
        // The head sways by 20 mm, a metre from the targets, and the mock's
        // viewer looks at directions: 1°.
        let rms = report[eye]["rms_deg"].as_f64().unwrap();
        assert!(rms < 1.5, "{eye}: {rms}");
    }
    let frame = followed(folder, "mock:as=link&seed=5&targets=one.csv", "a.toml");
    assert!(off(&frame["gaze"], Vec3::new(0.2, -0.15, -1.0)) < 2.5);
}

#[test]
fn a_recording_is_calibrated() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    script(
        folder,
        "four.csv",
        &[NINE[0], NINE[2], NINE[6], NINE[8]],
        0.7,
    );
    let tracker = "mock:as=iscan&still=1&targets=four.csv";
    shisen(folder)
        .args(["tracker", "record", tracker, "a.csv", "--frames", "1500"])
        .assert()
        .success();
    let calibrate = ["tracker", "calibrate", "replay:a.csv", "a.toml"];
    let targets = ["--targets", "four.csv", "--device", "iscan"];
    let report = json(folder, &[&calibrate[..], &targets].concat());
    assert_eq!(report["device"], "iscan");
    assert!(report["combined"]["rms_deg"].as_f64().unwrap() < 0.5);
    // A recording does not say of which device it is, and takes any.
    let frame = followed(folder, "replay:a.csv", "a.toml");
    assert!(off(&frame["gaze"], Vec3::new(0.35, 0.25, -1.0)) < 60.0);
}

/// One of two sensors in turn is the viewer's: the first, or the one that SPEC names.
#[test]
fn one_of_several_sensors_is_calibrated() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    script(folder, "nine.csv", &NINE, 0.8);
    let mock = "mock:as=iscan&still=1&targets=nine.csv";
    let record = ["tracker", "record", mock, "one.csv", "--frames", "3600"];
    shisen(folder).args(record).assert().success();
    let table = std::fs::read_to_string(folder.join("one.csv")).unwrap();
    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let at = |name: &str| header.iter().position(|found| *found == name).unwrap();
    let (sensor, x) = (at("sensor"), at("point_x"));
    let mut both = vec![header.join(",")];
    for line in table.lines().skip(1) {
        let mut cells: Vec<String> = line.split(',').map(String::from).collect();
        both.push(line.to_owned());
        cells[sensor] = "1".into();
        // The other looks as far to the left as this one to the right.
        if let Ok(found) = cells[x].parse::<f32>() {
            cells[x] = (1_700.0 - found).to_string();
        }
        both.push(cells.join(","));
    }
    std::fs::write(folder.join("two.csv"), both.join("\n")).unwrap();
    let calibrate = |spec: &str| {
        let output = shisen(folder)
            .args(["tracker", "calibrate", spec, "a.toml", "--json"])
            .args(["--targets", "nine.csv"])
            .assert()
            .success();
        let said = String::from_utf8(output.get_output().stderr.clone()).unwrap();
        let report: Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
        (report["targets"].clone(), said)
    };
    let (one, said) = calibrate("replay:one.csv");
    assert_eq!(said, "");
    for (spec, taken) in [("replay:two.csv", 0), ("replay:two.csv?head=0", 0)] {
        let (two, said) = calibrate(spec);
        assert_eq!(two, one, "{spec}");
        let expected = format!("several sensors: {taken} is taken for the head, not 1");
        assert_eq!(said.matches(&expected).count(), 1, "{said}");
    }
    let (other, said) = calibrate("replay:two.csv?head=1");
    // Sensor 0 speaks first.
    let unheard = "sensor 0 is not the head: SPEC says head=1, which has not been heard of so far";
    assert!(said.contains(unheard), "{said}");
    for (other, one) in other
        .as_array()
        .unwrap()
        .iter()
        .zip(one.as_array().unwrap())
    {
        let x = |target: &Value| target["combined"]["measured"][0].as_f64().unwrap();
        assert!((x(other) + x(one) - 1_700.0).abs() < 0.1, "{other} {one}");
    }
}

#[test]
fn a_device_is_calibrated_while_targets_are_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    script(
        folder.path(),
        "three.csv",
        &[NINE[0], NINE[2], NINE[7]],
        1.2,
    );
    let _mock = start(
        folder.path(),
        &[
            &["tracker", "mock", "--as", "iscan", "--pty", "tracker"][..],
            &["--still", "--targets", "three.csv"],
        ]
        .concat(),
    );
    let begun = Instant::now();
    while !folder.path().join("tracker").exists() {
        assert!(begun.elapsed() < Duration::from_secs(10));
        std::thread::sleep(Duration::from_millis(1));
    }
    let output = shisen(folder.path())
        .args(["tracker", "calibrate", "serial:tracker?protocol=iscan"])
        .args(["a.toml", "--targets", "three.csv"])
        .assert()
        .success();
    let said = std::str::from_utf8(&output.get_output().stderr).unwrap();
    assert!(said.contains("target 3 of 3: 0 -0.25 -1 m"), "{said}");
    let found = std::fs::read_to_string(folder.path().join("a.toml")).unwrap();
    // The mock's units: 850 straight ahead, 600 a metre, y down.
    let first = found.lines().find(|line| line.starts_with("combined"));
    let numbers = first.unwrap().trim_start_matches("combined = [");
    let mut numbers = numbers.split([',', ']']).map(|n| n.trim().parse::<f32>());
    let [x, y] = [850.0 - 0.35 * 600.0, 850.0 - 0.25 * 600.0];
    assert!(
        (numbers.next().unwrap().unwrap() - x).abs() < 15.0,
        "{found}"
    );
    assert!(
        (numbers.next().unwrap().unwrap() - y).abs() < 15.0,
        "{found}"
    );
}

#[test]
fn what_makes_no_calibration_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    script(folder, "nine.csv", &NINE, 0.6);
    script(folder, "two.csv", &NINE[..2], 0.6);
    script(folder, "line.csv", &NINE[..3], 0.6);
    std::fs::write(
        folder.join("late.csv"),
        "start_s,end_s,x,y,z\n90,91,0,0,-1\n",
    )
    .unwrap();
    let refused = |arguments: &[&str], code: i32, expected: &str| {
        let output = shisen(folder).args(arguments).assert().code(code);
        let said = std::str::from_utf8(&output.get_output().stderr).unwrap();
        let plain: Vec<&str> = said.split_whitespace().collect();
        assert!(plain.join(" ").contains(expected), "{arguments:?}: {said}");
    };
    let mock = "mock:as=iscan&still=1&targets=nine.csv";
    let calibrate = |targets: &str, more: &[&str], code, expected: &str| {
        let all = ["tracker", "calibrate", mock, "a.toml", "--targets", targets];
        refused(&[&all[..], more].concat(), code, expected);
        assert!(!folder.join("a.toml").exists());
    };
    calibrate("two.csv", &[], 1, "2 calibration targets");
    calibrate("line.csv", &[], 1, "they lie on a line");
    calibrate("none.csv", &[], 1, "none.csv");
    calibrate("nine.csv", &["--model", "cubic"], 2, "second-order");
    let second = ["--model", "second-order"];
    calibrate("line.csv", &second, 1, "3 calibration targets");
    refused(
        &["tracker", "calibrate", mock, "a.toml"],
        1,
        "--targets CSV",
    );
    shisen(folder)
        .args(["tracker", "record", mock, "short.csv", "--frames", "50"])
        .assert()
        .success();
    let short = ["tracker", "calibrate", "replay:short.csv", "a.toml"];
    refused(
        &[&short[..], &["--targets", "late.csv"]].concat(),
        1,
        "0 samples of the eyes came while they looked at target 1",
    );
    let head = ["tracker", "calibrate", "mock:as=fastrak", "a.toml"];
    let nine = ["--targets", "nine.csv"];
    refused(&[&head[..], &nine].concat(), 1, "0 samples of the eyes");
    json(
        folder,
        &[
            "tracker",
            "calibrate",
            mock,
            "a.toml",
            "--targets",
            "nine.csv",
        ],
    );
    for command in [
        &[
            "cave",
            "--tracker",
            "mock:as=asl",
            "--calibration",
            "a.toml",
        ][..],
        &[
            "tracker",
            "monitor",
            "mock:as=asl",
            "--calibration",
            "a.toml",
        ],
    ] {
        refused(command, 1, "is the calibration of iscan, and this is asl");
    }
    for (text, expected) in [
        ("model = \"cubic\"\n", "there is no model \"cubic\""),
        ("[[target]]\ndirection = [0,0,-1]\n", "targets and no model"),
        ("speed = 1\n", "unknown field"),
        ("[screen]\ncorner = [0,0,0]\nsize = [0,1]\n", "width"),
        (
            "[room_from_tracker]\nposition = [0,0,0]\norientation = [0,0,0,2]\n",
            "length 2",
        ),
        (
            "model = \"affine\"\n[[target]]\ndirection = [0,0,1]\ncombined = [1,2]\n",
            "1 calibration targets",
        ),
    ] {
        std::fs::write(folder.join("b.toml"), text).unwrap();
        let command = ["cave", "--tracker", "mock", "--calibration", "b.toml"];
        refused(&command, 1, expected);
    }
}

/// A HID eye tracker gives points on a screen: where that is, the file says.
#[test]
fn points_are_on_the_screen_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    script(folder, "one.csv", &[[0.2, -0.15]], 9.0);
    let tracker = "mock:as=hid&still=1&targets=one.csv";
    for (corner, expected) in [
        ("-1, 0.5, -1", Vec3::new(0.2, -0.15, -1.0)),
        ("-1, 1.0, -1", Vec3::new(0.2, 0.35, -1.0)),
        ("-1, 0.5, -2", Vec3::new(0.2, -0.15, -2.0)),
    ] {
        let screen = format!("[screen]\ncorner = [{corner}]\nsize = [2, 1]\n");
        std::fs::write(folder.join("a.toml"), screen).unwrap();
        let frame = followed(folder, tracker, "a.toml");
        assert_eq!(frame["state"], "fresh");
        let off = off(&frame["gaze"], expected);
        assert!(off < 1.0, "{corner}: {off}°");
    }
}
