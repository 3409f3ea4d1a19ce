//! What firmware can log by defmt.

use std::path::{Path, PathBuf};
use syn::{Attribute, Ident, Item, Meta, Visibility};

/// Of a folder and those in it.
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

/// Public types of a file whose names end in `Error` or `Event`.
fn logged(path: &Path) -> Vec<(Ident, Vec<Attribute>)> {
    let file = syn::parse_file(&std::fs::read_to_string(path).unwrap()).unwrap();
    let types = file.items.into_iter().filter_map(|item| match item {
        Item::Enum(of) => Some((of.vis, of.ident, of.attrs)),
        Item::Struct(of) => Some((of.vis, of.ident, of.attrs)),
        _ => None,
    });
    types
        .filter(|(seen, name, _)| {
            let name = name.to_string();
            matches!(seen, Visibility::Public(_))
                && (name.ends_with("Error") || name.ends_with("Event"))
        })
        .map(|(_, name, attributes)| (name, attributes))
        .collect()
}

/// Firmware has nothing else to print them with.
#[test]
fn every_error_and_event_of_firmware_can_be_logged_by_defmt() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut files = Vec::new();
    for package in ["core", "tracker-driver"] {
        sources(&root.join(package).join("src"), &mut files);
    }
    // What needs the standard library is of no firmware.
    let of_hosts = ["serial.rs", "hid/device.rs"];
    files.retain(|file| !of_hosts.iter().any(|host| file.ends_with(host)));
    let mut count = 0;
    for file in files {
        for (name, attributes) in logged(&file) {
            let is_logged = attributes.iter().any(|attribute| {
                matches!(&attribute.meta, Meta::List(list)
                    if list.path.is_ident("cfg_attr")
                        && list.tokens.to_string().contains("defmt :: Format"))
            });
            let place = file.display();
            assert!(is_logged, "{place}: {name} derives no defmt::Format");
            count += 1;
        }
    }
    assert!(count > 20, "{count}");
}
