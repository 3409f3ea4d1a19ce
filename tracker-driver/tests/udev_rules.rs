//! The udev rules say what they mean.

use std::process::Command;

const RULES: &str = include_str!("../udev/70-shisen-trackers.rules");

/// What stands between quotes after `key` in the rule that runs a program.
fn value<'a>(rule: &'a str, key: &str) -> &'a str {
    let (_, rest) = rule.split_once(key).expect("the rule has the key");
    rest.split('"').nth(1).expect("a value in quotes")
}

/// Whether the rule for HID trackers takes a device with this descriptor.
fn is_taken(name: &str, descriptor: &[u8]) -> bool {
    let rule = RULES.lines().find(|line| line.contains("PROGRAM="));
    let rule = rule.expect("a rule that runs a program");
    let path = std::env::temp_dir().join(format!("shisen-udev-{}-{name}", std::process::id()));
    std::fs::write(&path, descriptor).unwrap();
    let program = value(rule, "PROGRAM");
    let line = program.split('\'').nth(1).expect("a shell line");
    let line = line.replace(
        "/sys%p/device/report_descriptor",
        path.to_str().expect("a path that is text"),
    );
    assert!(!line.contains('%'), "{line}");
    let output = Command::new("/bin/sh").args(["-c", &line]).output();
    std::fs::remove_file(&path).unwrap();
    let output = String::from_utf8(output.unwrap().stdout).unwrap();
    // udev takes the line ends off the end and nothing off the front.
    let output = output.trim_end_matches('\n');
    let result = value(rule, "RESULT");
    match result.strip_prefix('*') {
        Some(end) => output.ends_with(end),
        None => output == result,
    }
}

#[test]
fn a_hid_tracker_is_taken_and_a_keyboard_is_not() {
    assert!(is_taken("tracker", &[0x05, 0x12, 0x09, 0x01]));
    assert!(!is_taken("keyboard", &[0x05, 0x01, 0x09, 0x06]));
    assert!(!is_taken("vendor", &[0x06, 0x05, 0x12, 0x09]));
    assert!(!is_taken("empty", &[]));
}
