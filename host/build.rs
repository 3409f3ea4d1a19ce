//! Says where the page of `shisen web` is.

use std::path::Path;

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
    if !page.join("index.html").is_file() {
        println!(
            "cargo::error=there is no page in {}: host/web/build makes it",
            page.display()
        );
    }
    println!("cargo::rustc-env=SHISEN_PAGE={}", page.display());
}
