//! libFuzzer on the target that the variable SHISEN_FUZZ names. Where none is named,
//! writes each target's seed to its folder in that of SHISEN_CORPUS, prints the targets'
//! names, and ends.

#![no_main]

use std::env::var;
use std::fs;
use std::path::Path;
use std::process::exit;
use std::sync::LazyLock;

static TARGET: LazyLock<String> = LazyLock::new(|| var("SHISEN_FUZZ").expect("a target's name"));

libfuzzer_sys::fuzz_target!(
    init: if var("SHISEN_FUZZ").is_err() {
        let corpus = var("SHISEN_CORPUS").expect("the folder of the corpus");
        for name in shisen_fuzz::targets() {
            println!("{name}");
            fs::create_dir_all(Path::new(&corpus).join(name)).expect("a folder for the seed");
        }
        for (name, bytes) in shisen_fuzz::seeds() {
            fs::write(Path::new(&corpus).join(name).join("seed"), bytes).expect("a seed");
        }
        exit(0)
    },
    |bytes: &[u8]| shisen_fuzz::run(&TARGET, bytes)
);
