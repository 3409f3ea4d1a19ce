//! The corpus of hard cases, and its command.

use serde_json::Value;
use shisen_core::Simd;
use shisen_evidence::selftest::{Effort, Outcome, run, selected};
use shisen_tests::command::evidence;

/// As much as `SHISEN_HEAVY=1` asks for.
fn effort() -> Effort {
    let full = std::env::var_os("SHISEN_HEAVY").is_some_and(|value| value == "1");
    println!("hard cases: {}", if full { "full" } else { "quick" });
    if full { Effort::Full } else { Effort::Quick }
}

#[test]
fn every_case_is_within_its_bound() {
    let outcomes = run(effort(), "", || ());
    assert!(outcomes.len() >= 40, "{}", outcomes.len());
    let mut broken = 0;
    for Outcome { case, errors } in &outcomes {
        let (ours, naive) = (errors.ours, errors.naive);
        println!("{}: {ours:.3e}, naive {naive:.3e}", case.name);
        broken += usize::from(naive > case.bound);
        assert!(ours <= case.bound, "{}: {ours:e}", case.name);
    }
    // They are hard: on most of them the naive way is beyond the bound.
    assert!(
        broken * 4 >= outcomes.len() * 3,
        "{broken} of {}",
        outcomes.len()
    );
}

#[test]
fn a_report_has_what_its_help_says() {
    let folder = tempfile::tempdir().unwrap();
    let output = evidence(folder.path())
        .args(["selftest", "--quick", "--json", "refraction"])
        .assert()
        .success();
    let text = std::str::from_utf8(&output.get_output().stdout).unwrap();
    let report: Value = serde_json::from_str(text).unwrap();
    assert_eq!(
        (&report["quick"], &report["failed"]),
        (&true.into(), &0.into())
    );
    let cases = report["cases"].as_array().unwrap();
    assert_eq!(report["passed"], cases.len());
    assert_eq!(cases.len(), selected("refraction").count());
    for (case, row) in selected("refraction").zip(cases) {
        assert_eq!(
            (&row["group"], &row["passed"]),
            (&"refraction".into(), &true.into())
        );
        assert_eq!(
            (&row["name"], &row["bound"]),
            (&case.name.into(), &case.bound.into())
        );
        assert!(row["error"].as_f64().unwrap() <= case.bound, "{row}");
        let naive = row["naive_error"].as_f64().unwrap_or(f64::INFINITY);
        assert_eq!(row["control"], naive <= case.bound, "{row}");
        for text in ["hard", "unit", "reference", "naive"] {
            assert!(
                row[text].as_str().is_some_and(|text| text.len() > 3),
                "{row}"
            );
        }
    }
    // A wrong verdict on total reflection has no size.
    assert!(cases[0]["naive_error"].is_null(), "{}", cases[0]);
    assert_eq!(report["simd"], Simd::detect().name());
    assert_eq!(report["paths_compared"], Value::Array(Vec::new()));
    let people = evidence(folder.path())
        .args(["selftest", "--quick", "budget-of-1"])
        .assert()
        .success();
    let people = std::str::from_utf8(&people.get_output().stdout).unwrap();
    assert!(people.contains("budget-of-1-at-a-time"), "{people}");
    assert!(people.ends_with("1 passed, 0 failed\n"), "{people}");
}

#[test]
fn a_processor_without_avx2_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let output = evidence(folder.path())
        .args(["selftest", "--quick", "--json", "frame-on-every-path-glass"])
        .assert()
        .success();
    let output = output.get_output();
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let said = std::str::from_utf8(&output.stderr).unwrap();
    let has_avx2 = Simd::detect().name() == "avx2";
    let paths: &[&str] = if has_avx2 {
        &["portable", "avx2"]
    } else {
        &["portable"]
    };
    assert_eq!(report["paths_compared"], Value::from(paths));
    assert_eq!(said.contains("no AVX2 here"), !has_avx2, "{said}");
}

#[test]
fn a_part_of_no_name_is_a_slip() {
    let folder = tempfile::tempdir().unwrap();
    let output = evidence(folder.path())
        .args(["selftest", "refracton"])
        .assert()
        .code(2);
    let said = std::str::from_utf8(&output.get_output().stderr).unwrap();
    assert!(said.contains("no case has refracton in its name"), "{said}");
}
