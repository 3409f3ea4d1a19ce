//! The udev rules say what they mean.

use std::process::Command;

const RULES: &str = include_str!("../udev/70-shisen-trackers.rules");

/// Returns what stands between quotes after `key` in the rule that runs a program.
fn value<'a>(rule: &'a str, key: &str) -> &'a str {
    let (_, rest) = rule.split_once(key).expect("the rule has the key");
    rest.split('"').nth(1).expect("a value in quotes")
}

/// Returns whether the rule for HID trackers takes a device with this descriptor.
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
    // A shell's patterns are udev's.
    let pattern = value(rule, "RESULT").replace(' ', "\\ ");
    let matching = format!("case $1 in {pattern}) exit 0;; esac; exit 1");
    let matched = Command::new("/bin/sh")
        .args(["-c", &matching, "sh", output])
        .status();
    matched.unwrap().success()
}

/// A mouse or a keyboard.
const POINTER: [u8; 8] = [0x05, 0x01, 0x09, 0x02, 0xA1, 0x01, 0x26, 0x05];

#[test]
fn a_hid_tracker_is_taken_and_a_keyboard_is_not() {
    assert!(is_taken("tracker", &[0x05, 0x12, 0x09, 0x01]));
    assert!(!is_taken("keyboard", &[0x05, 0x01, 0x09, 0x06]));
    assert!(!is_taken("vendor", &[0x06, 0x05, 0x12, 0x09]));
    assert!(!is_taken("empty", &[]));
    // Behind the collection of something else, in the short form and the long one.
    let end = [0xC0];
    let eyes = [0x05, 0x12, 0x09, 0x01, 0xA1, 0x01, 0xC0];
    let heads = [0x06, 0x12, 0x00, 0x09, 0x02, 0xA1, 0x01, 0xC0];
    let mouse = [&POINTER[..], &[0x12], &end].concat();
    assert!(is_taken("second", &[&mouse[..], &eyes].concat()));
    assert!(is_taken("long", &[&mouse[..], &heads].concat()));
    // 0x1205 is a number there.
    assert!(!is_taken("number", &mouse));
    // A descriptor may be as long as 4,096 bytes.
    let padded = [&vec![0xC0; 4_089][..], &eyes].concat();
    assert!(is_taken("longest", &padded[..4_096]));
}
