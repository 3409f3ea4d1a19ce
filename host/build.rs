//! Says where the page of `shisen web` is.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// What the page is made of.
const SOURCES: [&str; 6] = [
    "web/page",
    "web/src",
    "web/Cargo.toml",
    "web/Cargo.lock",
    "web/build",
    "../core/src",
];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if std::env::var_os("CARGO_FEATURE_WEB").is_none() {
        return;
    }
    // TARGET/PROFILE/build/PACKAGE/out
    let out = std::env::var("OUT_DIR").unwrap_or_default();
    let target = Path::new(&out).ancestors().nth(4).unwrap_or(Path::new("."));
    let page = target.join("web");
    println!("cargo::rerun-if-changed={}", page.display());
    for source in SOURCES {
        println!("cargo::rerun-if-changed={source}");
    }
    let page_is = |what: &str| {
        println!(
            "cargo::error={}: {what}: host/web/build makes it",
            page.display()
        );
    };
    match changed(&page.join("index.html")) {
        None => page_is("there is no page"),
        Some(made) => {
            let mut newer = files(SOURCES.map(PathBuf::from).into());
            if let Some(source) = newer.find(|file| changed(file) > Some(made)) {
                page_is(&format!("the page is older than {}", source.display()));
            }
        }
    }
    println!("cargo::rustc-env=SHISEN_PAGE={}", page.display());
}

fn changed(file: &Path) -> Option<SystemTime> {
    file.metadata().ok()?.modified().ok()
}

/// Returns the files among paths, and those in their folders.
fn files(mut paths: Vec<PathBuf>) -> impl Iterator<Item = PathBuf> {
    let mut found = Vec::new();
    while let Some(path) = paths.pop() {
        match path.read_dir() {
            Ok(entries) => paths.extend(entries.flatten().map(|entry| entry.path())),
            Err(_) => found.push(path),
        }
    }
    found.into_iter()
}
