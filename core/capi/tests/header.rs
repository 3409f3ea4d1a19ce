//! Checks that the header is what cbindgen makes from the crate.

use std::fs;
use std::path::Path;

/// Source files in the order of their items in the header.
const SOURCES: [&str; 9] = [
    "status.rs",
    "memory.rs",
    "scene.rs",
    "protocol.rs",
    "tracker.rs",
    "screen.rs",
    "spectrum.rs",
    "dome.rs",
    "frame.rs",
];

#[test]
fn the_header_is_what_cbindgen_makes() {
    let crate_folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(crate_folder.join("cbindgen.toml")).unwrap();
    let mut builder = cbindgen::Builder::new().with_config(config);
    for source in SOURCES {
        builder = builder.with_src(crate_folder.join("src").join(source));
    }
    let mut made = Vec::new();
    builder.generate().unwrap().write(&mut made);
    let made = String::from_utf8(made).unwrap();

    let path = crate_folder.join("include/shisen.h");
    if std::env::var_os("SHISEN_REWRITE").is_some() {
        fs::write(&path, &made).unwrap();
    }
    let kept = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        kept == made,
        "include/shisen.h is not what cbindgen makes of src: rewrite it with\n\
         SHISEN_REWRITE=1 cargo test --package shisen-capi --test header"
    );
}
