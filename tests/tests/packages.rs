//! What would be published of each crate: sources, examples, licences, and nothing else.

use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// A crate, and what its package has beside `src`, its manifest and its lock file.
const PACKAGES: [(&str, &[&str]); 4] = [
    ("shisen-core", &["CHANGELOG.md", "examples/"]),
    ("shisen-tracker", &["CHANGELOG.md", "examples/", "udev/"]),
    ("shisen", &["CHANGELOG.md", "examples/", "build.rs"]),
    (
        "shisen-capi",
        &["CHANGELOG.md", "examples/", "include/", "cbindgen.toml"],
    ),
];

/// In every one.
const COMMON: [&str; 5] = [
    "src/",
    "Cargo.toml",
    "LICENSE-APACHE",
    "LICENSE-MIT",
    "README.md",
];

/// What cargo itself adds.
const OF_CARGO: [&str; 3] = ["Cargo.lock", "Cargo.toml.orig", ".cargo_vcs_info.json"];

/// What cargo prints.
fn cargo(arguments: &[&str]) -> String {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(".."))
        .args(arguments)
        .output()
        .unwrap();
    assert!(output.status.success(), "{arguments:?}: {output:?}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn they_have_what_they_need_and_nothing_else() {
    for (package, own) in PACKAGES {
        let list = cargo(&[
            "package",
            "--list",
            "--allow-dirty",
            "--offline",
            "--package",
            package,
        ]);
        let is_of = |file: &str, place: &str| {
            file == place || (place.ends_with('/') && file.starts_with(place))
        };
        let places: Vec<&str> = COMMON.iter().chain(own).copied().collect();
        for place in &places {
            let there = list.lines().any(|file| is_of(file, place));
            assert!(there, "{package} lacks {place}");
        }
        for file in list.lines() {
            let known = places.iter().any(|place| is_of(file, place));
            assert!(known || OF_CARGO.contains(&file), "{package} has {file}");
            let kind = Path::new(file).extension().and_then(|kind| kind.to_str());
            let data = [
                "png",
                "obj",
                "ply",
                "glb",
                "bin",
                "shisen",
                "proptest-regressions",
            ];
            assert!(
                kind.is_none_or(|kind| !data.contains(&kind)),
                "{package} has {file}"
            );
        }
    }
}

#[test]
fn they_say_what_they_are() {
    let metadata: Value = serde_json::from_str(&cargo(&[
        "metadata",
        "--no-deps",
        "--offline",
        "--format-version",
        "1",
    ]))
    .unwrap();
    for (name, _) in PACKAGES {
        let packages = metadata["packages"].as_array().unwrap();
        let package = packages.iter().find(|one| one["name"] == name).unwrap();
        for key in ["description", "license", "readme", "rust_version"] {
            assert!(package[key].is_string(), "{name}: {key}");
        }
        for key in ["keywords", "categories"] {
            let values = package[key].as_array().unwrap();
            assert!((1..=5).contains(&values.len()), "{name}: {key}");
        }
        // What is to be published says which version of each crate it is for.
        for dependency in package["dependencies"].as_array().unwrap() {
            assert_ne!(dependency["req"], "*", "{name}: {}", dependency["name"]);
        }
    }
}
