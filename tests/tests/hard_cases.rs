//! The corpus of hard cases, its command, and its table in the README.

use serde_json::Value;
use shisen::selftest::{Effort, GROUPS, Outcome, run, selected};
use shisen_core::Simd;
use shisen_tests::command::shisen;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

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
    let output = shisen(folder.path())
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
    let people = shisen(folder.path())
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
    let output = shisen(folder.path())
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
    let output = shisen(folder.path())
        .args(["selftest", "refracton"])
        .assert()
        .code(2);
    let said = std::str::from_utf8(&output.get_output().stderr).unwrap();
    assert!(said.contains("no case has refracton in its name"), "{said}");
}

const BEGIN: &str = "<!-- hard cases: SHISEN_REWRITE=1 cargo test -p shisen-tests --test all -- \
                     hard_cases -->\n";
const END: &str = "<!-- end of the hard cases -->\n";

fn readme() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md")
}

/// To two digits; what is no number or beyond doubt is a word.
fn number(x: f64) -> String {
    match x {
        0.0 => "0".into(),
        x if !x.is_finite() => "wrong".into(),
        x if (0.1..1000.0).contains(&x) => format!("{x:.1}"),
        x => format!("{x:.1e}"),
    }
}

/// Where the name, the bound and the rest of each row are.
fn rows(table: &str) -> Vec<Vec<&str>> {
    let cells = |line: &str| -> usize { line.matches('|').count() };
    let lines = table.lines().filter(|line| cells(line) == 6);
    lines
        .skip(2)
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect()
}

#[test]
fn the_readmes_table_is_of_these_cases() {
    let text = std::fs::read_to_string(readme()).unwrap();
    let (before, rest) = text.split_once(BEGIN).expect("the table's beginning");
    let (table, after) = rest.split_once(END).expect("the table's end");
    if std::env::var_os("SHISEN_REWRITE").is_some_and(|value| value == "1") {
        let mut table =
            "| Case | What is hard | Ours | Bound | Naive |\n|---|---|---|---|---|\n".to_owned();
        for outcome in run(Effort::Full, "", || ()) {
            let Outcome { case, errors } = &outcome;
            let [ours, bound, mut naive] = [errors.ours, case.bound, errors.naive].map(number);
            if outcome.is_control() {
                naive += " (control)";
            }
            let (name, hard) = (case.name, case.hard);
            writeln!(table, "| {name} | {hard} | {ours} | {bound} | {naive} |").unwrap();
        }
        std::fs::write(readme(), [before, BEGIN, &table, END, after].concat()).unwrap();
        return;
    }
    let all = GROUPS.iter().flat_map(|(_, cases)| *cases);
    let expected: Vec<[String; 3]> = all
        .map(|case| [case.name.into(), case.hard.into(), number(case.bound)])
        .collect();
    let found: Vec<[String; 3]> = rows(table)
        .iter()
        .map(|cells| [cells[0].into(), cells[1].into(), cells[3].into()])
        .collect();
    assert_eq!(found, expected, "write it anew: {BEGIN}");
    // What is printed is of all inputs; a run of fewer finds no more, and, where what
    // is rare does not count alone, something of that size.
    let effort = effort();
    let full = effort == Effort::Full;
    for (cells, outcome) in rows(table).iter().zip(run(effort, "", || ())) {
        let [ours, bound]: [f64; 2] = [cells[2], cells[3]].map(|n| n.parse().unwrap());
        assert!(ours <= bound, "{cells:?}");
        let found = outcome.errors.ours;
        assert!(found <= 1.5 * ours, "{found:e}, {cells:?}");
        assert!(ours <= 10.0 * found, "{found:e}, {cells:?}");
        // The naive way's, too, where it is a number; what is rare in it is rarer in a
        // run of fewer.
        let naive = cells[4].trim_end_matches(" (control)");
        if let Ok(naive) = naive.parse::<f64>() {
            let found = outcome.errors.naive;
            assert!(found <= 1.5 * naive, "{found:e}, {cells:?}");
            let least = if full { 0.5 * naive } else { 1e-3 * naive };
            assert!(found >= least, "{found:e}, {cells:?}");
        } else {
            assert_eq!(naive, "wrong", "{cells:?}");
        }
        // Of fewer inputs the naive way may be within the bound by chance.
        let is_control = cells[4].ends_with("(control)");
        assert!(!is_control || outcome.is_control(), "{cells:?}");
    }
}
