//! `shisen tracker calibrate`, and what follows a calibration.
#![cfg(unix)]

use crate::tracker_command::{record, start_on_line};
use glam::Vec3;
use serde_json::Value;
use shisen_tests::command::{folder, refused, report, run};
use std::fmt::Write;
use std::path::Path;

/// Writes places on a plane a metre ahead, each looked at for its seconds.
fn script(folder: &Path, name: &str, places: &[[f32; 2]], seconds: f32) {
    let mut table = String::from("start_s,end_s,x,y,z\n");
    for (i, [x, y]) in places.iter().enumerate() {
        let start = i as f32 * seconds;
        writeln!(table, "{start},{},{x},{y},-1", start + seconds).unwrap();
    }
    std::fs::write(folder.join(name), table).unwrap();
}

/// Returns three rows of targets, from the upper left one on.
fn nine() -> [[f32; 2]; 9] {
    std::array::from_fn(|i| [[-0.35, 0.0, 0.35][i % 3], [0.25, 0.0, -0.25][i / 3]])
}

/// Between the targets.
const THERE: Vec3 = Vec3::new(0.2, -0.15, -1.0);

/// The targets `nine.csv`, and `one.csv` between them.
fn scripts(folder: &Path) {
    script(folder, "nine.csv", &nine(), 1.0);
    script(folder, "one.csv", &[[THERE.x, THERE.y]], 9.0);
}

/// Returns the angle between a direction in a report and another, degrees.
fn angle(found: &Value, expected: Vec3) -> f32 {
    let found: [f32; 3] = serde_json::from_value(found.clone()).unwrap();
    Vec3::from(found).angle_between(expected).to_degrees()
}

/// Returns the last of some frames along a tracker.
fn followed(folder: &Path, tracker: &str) -> Value {
    let small = "--scene grid --size 4 --eyes 1 --view-size 4x3";
    let words = format!("cave --tracker {tracker} --calibration a.toml --frames 20 {small}");
    report(folder, &words)["frames"][19].clone()
}

#[test]
fn raw_gaze_becomes_a_line_of_sight() {
    let folder = folder();
    let folder = folder.path();
    scripts(folder);
    for (protocol, model) in [
        ("iscan", "affine"),
        ("iscan", "second-order"),
        ("asl", "affine"),
    ] {
        let words = format!(
            "tracker calibrate mock:as={protocol}&still=1&targets=nine.csv a.toml \
             --targets nine.csv --model {model}"
        );
        let report = report(folder, &words);
        assert_eq!(
            (&report["device"], &report["model"]),
            (&protocol.into(), &model.into())
        );
        assert!(report["left"].is_null());
        // The mock's eyes wander about a target by microsaccades.
        let rms = report["combined"]["rms_deg"].as_f64().unwrap();
        assert!(rms < 0.4, "{protocol} {model}: {rms}");
        let targets = report["targets"].as_array().unwrap();
        assert_eq!(targets.len(), 9);
        for target in targets {
            assert!(target["samples"].as_u64().unwrap() > 200, "{target}");
            assert!(target["combined"]["residual_deg"].as_f64().unwrap() < 0.8);
        }
        // By another run.
        let tracker = format!("mock:as={protocol}&still=1&seed=5&targets=one.csv");
        let frame = followed(folder, &tracker);
        assert_eq!(frame["state"], "fresh", "{protocol} {model}");
        let off = angle(&frame["gaze"], THERE);
        assert!(off < 1.0, "{protocol} {model}: {off}°");
    }
    // The last calibration was for ASL.
    let words = "tracker monitor --calibration a.toml --json --frames 300 \
                 mock:as=asl&still=1&targets=one.csv";
    let sight = &run(folder, words).objects()[299]["line_of_sight"];
    assert_eq!(sight["state"], "fresh");
    assert!(angle(&sight["direction"], THERE) < 1.0, "{sight}");
}

#[test]
fn directions_are_calibrated_with_the_head_that_turns() {
    let folder = folder();
    let folder = folder.path();
    scripts(folder);
    let words = "tracker calibrate mock:as=link&targets=nine.csv a.toml --targets nine.csv";
    let report = report(folder, words);
    assert!(report["combined"].is_null());
    for eye in ["left", "right"] {
        // The head sways by 20 mm, a metre from the targets: 1°.
        let rms = report[eye]["rms_deg"].as_f64().unwrap();
        assert!(rms < 1.5, "{eye}: {rms}");
    }
    let frame = followed(folder, "mock:as=link&seed=5&targets=one.csv");
    assert!(angle(&frame["gaze"], THERE) < 2.5);
}

/// The viewer's sensor is the first of two in turn, or the one that SPEC names.
#[test]
fn one_of_several_recorded_sensors_is_calibrated() {
    let folder = folder();
    let folder = folder.path();
    script(folder, "nine.csv", &nine(), 0.8);
    let mock = format!(
        "mock:as=iscan&still=1&targets={}/nine.csv",
        folder.display()
    );
    record(folder, &mock, "one.csv", 3_600);
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
        let words = format!("tracker calibrate replay:{spec} a.toml --targets nine.csv --json");
        let said = run(folder, &format!("{words} --device iscan"));
        let report = &said.objects()[0];
        assert_eq!(report["device"], "iscan");
        (report["targets"].as_array().unwrap().clone(), said.err)
    };
    let (one, said) = calibrate("one.csv");
    assert_eq!(said, "");
    for spec in ["two.csv", "two.csv?head=0"] {
        let (two, said) = calibrate(spec);
        assert_eq!(two, one, "{spec}");
        let expected = "several sensors: 0 is taken for the head, not 1";
        assert_eq!(said.matches(expected).count(), 1, "{said}");
    }
    let (other, said) = calibrate("two.csv?head=1");
    // Sensor 0 speaks first.
    let unheard = "sensor 0 is not the head: SPEC says head=1, which has sent nothing so far";
    assert!(said.contains(unheard), "{said}");
    for (other, one) in other.iter().zip(&one) {
        let x = |target: &Value| target["combined"]["measured"][0].as_f64().unwrap();
        assert!((x(other) + x(one) - 1_700.0).abs() < 0.1, "{other} {one}");
    }
}

#[test]
fn a_device_is_calibrated_while_targets_are_looked_at() {
    let folder = folder();
    let folder = folder.path();
    script(folder, "three.csv", &[0, 2, 7].map(|i| nine()[i]), 1.2);
    let mock = "tracker serve mock:still=1&targets=three.csv --as iscan --to tracker";
    let _mock = start_on_line(folder, mock);
    let calibrate = "tracker calibrate serial:tracker?protocol=iscan a.toml --targets three.csv";
    let said = run(folder, calibrate).err;
    assert!(said.contains("target 3 of 3: 0 -0.25 -1 m"), "{said}");
    let found = std::fs::read_to_string(folder.join("a.toml")).unwrap();
    let found: toml::Table = found.parse().unwrap();
    // The mock's units: 850 straight ahead, 600 a metre, y down.
    let expected = [850.0 - 0.35 * 600.0, 850.0 - 0.25 * 600.0];
    for (axis, expected) in expected.into_iter().enumerate() {
        let found = found["target"][0]["combined"][axis].as_float().unwrap();
        assert!((found - expected).abs() < 15.0, "{found}");
    }
}

#[test]
fn what_makes_no_calibration_is_told() {
    let folder = folder();
    let folder = folder.path();
    script(folder, "nine.csv", &nine(), 0.6);
    script(folder, "two.csv", &nine()[..2], 0.6);
    script(folder, "line.csv", &nine()[..3], 0.6);
    let late = "start_s,end_s,x,y,z\n90,91,0,0,-1\n";
    std::fs::write(folder.join("late.csv"), late).unwrap();
    let mock = "mock:as=iscan&still=1&targets=nine.csv";
    for (code, more, expected) in [
        (1, "--targets two.csv", "3 targets or more and got 2"),
        (1, "--targets line.csv", "they lie on a line"),
        (1, "--targets none.csv", "none.csv"),
        (2, "--targets nine.csv --model cubic", "second-order"),
        (1, "", "--targets CSV"),
    ] {
        let words = format!("tracker calibrate {mock} a.toml {more}");
        refused(folder, code, &format!("{words} => {expected}"));
        assert!(!folder.join("a.toml").exists());
    }
    record(folder, "mock:as=iscan", "short.csv", 50);
    let words = format!("tracker calibrate {mock} a.toml --targets nine.csv");
    report(folder, &words);
    refused(
        folder,
        1,
        "
        tracker calibrate replay:short.csv b.toml --targets late.csv => 0 samples of the eyes came while they looked at target 1
        cave --tracker mock:as=asl --calibration a.toml => is the calibration of iscan, and this is asl
        tracker monitor mock:as=asl --calibration a.toml => is the calibration of iscan, and this is asl",
    );
    for (text, expected) in [
        ("model = \"cubic\"\n", "there is no model \"cubic\""),
        ("[[target]]\ndirection = [0,0,-1]\n", "targets and no model"),
        ("speed = 1\n", "unknown key"),
        ("[screen]\ncorner = [0,0,0]\nsize = [0,1]\n", "width"),
        (
            "[room_from_tracker]\nposition = [0,0,0]\norientation = [0,0,0,2]\n",
            "length 2",
        ),
        (
            "model = \"affine\"\n[[target]]\ndirection = [0,0,1]\ncombined = [1,2]\n",
            "and got 1",
        ),
    ] {
        std::fs::write(folder.join("b.toml"), text).unwrap();
        let words = "cave --tracker mock --calibration b.toml";
        refused(folder, 1, &format!("{words} => {expected}"));
    }
}

/// A HID eye tracker gives points on a screen, whose place is in the file.
#[test]
fn points_are_on_the_screen_of_the_file() {
    let folder = folder();
    let folder = folder.path();
    script(folder, "one.csv", &[[0.2, -0.15]], 9.0);
    for (corner, expected) in [
        ("-1, 0.5, -1", Vec3::new(0.2, -0.15, -1.0)),
        ("-1, 1.0, -1", Vec3::new(0.2, 0.35, -1.0)),
        ("-1, 0.5, -2", Vec3::new(0.2, -0.15, -2.0)),
    ] {
        let screen = format!("[screen]\ncorner = [{corner}]\nsize = [2, 1]\n");
        std::fs::write(folder.join("a.toml"), screen).unwrap();
        let frame = followed(folder, "mock:as=hid&still=1&targets=one.csv");
        assert_eq!(frame["state"], "fresh");
        let off = angle(&frame["gaze"], expected);
        assert!(off < 1.0, "{corner}: {off}°");
    }
}
