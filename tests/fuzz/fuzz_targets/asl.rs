#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| shisen_fuzz::run("asl", bytes));
