//! Tells the program how it is built: its reports of times name it.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    for (name, of) in [
        ("SHISEN_PROFILE", "PROFILE"),
        ("SHISEN_OPT_LEVEL", "OPT_LEVEL"),
    ] {
        let value = std::env::var(of).unwrap_or_default();
        println!("cargo:rustc-env={name}={value}");
    }
}
