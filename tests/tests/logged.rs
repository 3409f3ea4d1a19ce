//! What firmware can log by defmt.

use std::path::{Path, PathBuf};

/// Every Rust file in a folder and the folders in it.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|kind| kind == "rs") {
            found.push(path);
        }
    }
}

/// Firmware has nothing else to print them with.
#[test]
fn every_error_and_event_of_firmware_can_be_logged_by_defmt() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut files = Vec::new();
    sources(&root.join("core/src"), &mut files);
    sources(&root.join("tracker-driver/src"), &mut files);
    // What needs the standard library is in no firmware.
    let host_only = ["serial.rs", "hid/device.rs", "transport/hid.rs"];
    files.retain(|file| !host_only.iter().any(|one| file.ends_with(one)));
    let mut types = 0;
    for path in files {
        let text = std::fs::read_to_string(&path).unwrap();
        // Attributes stand between the end of the item before and the type.
        let mut start = 0;
        let mut at = 0;
        for line in text.lines() {
            at += line.len() + 1;
            let name = line
                .strip_prefix("pub enum ")
                .or_else(|| line.strip_prefix("pub struct "))
                .map(|rest| rest.split(|c: char| !c.is_alphanumeric()).next().unwrap());
            if name.is_some_and(|name| name.ends_with("Error") || name.ends_with("Event")) {
                types += 1;
                assert!(
                    text[start..at].contains("defmt::Format"),
                    "{line} of {}",
                    path.display()
                );
            }
            if line.starts_with('}') || line.ends_with(';') {
                start = at;
            }
        }
    }
    assert!(types > 20, "{types}");
}
