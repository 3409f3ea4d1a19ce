//! The corpus of hard cases, and its command.

use serde_json::json;
use shisen_core::Simd;
use shisen_evidence::selftest::{Effort, run};
use shisen_tests::command::{folder, refused, run as run_command};
use shisen_tests::sizes::cases;

#[test]
fn every_case_is_within_its_bound() {
    let effort = match cases("hard cases", 0, 1) {
        0 => Effort::Quick,
        _ => Effort::Full,
    };
    let rows = run(effort, "", || ());
    assert!(rows.len() >= 40, "{}", rows.len());
    let mut broken = 0;
    for row in &rows {
        let (case, ours, naive) = (row.case, row.error, row.naive_error);
        println!("{}: {ours:.3e}, naive {naive:.3e}", case.name);
        broken += usize::from(naive > case.bound);
        assert!(ours <= case.bound, "{}: {ours:e}", case.name);
    }
    // They are hard: on most of them the naive way is beyond the bound.
    let count = rows.len();
    assert!(broken * 4 >= count * 3, "{broken} of {count}");
}

#[test]
fn the_command_says_what_it_compared() {
    let folder = folder();
    let words = "selftest --quick --json frame-on-every-path-glass";
    let said = run_command(folder.path(), words);
    let has_avx2 = Simd::detect().name() == "avx2";
    let paths = if has_avx2 {
        json!(["portable", "avx2"])
    } else {
        json!(["portable"])
    };
    assert_eq!(said.objects()[0]["paths_compared"], paths);
    assert_eq!(said.err.contains("no AVX2 here"), !has_avx2, "{}", said.err);
    let unknown = ("selftest refracton", "no case has refracton in its name");
    refused(folder.path(), 2, &[unknown]);
}
