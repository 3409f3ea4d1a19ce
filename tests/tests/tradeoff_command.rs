//! `shisen tradeoff`: what it writes and prints, and its bad input.

use serde_json::Value;
use shisen_tests::command::shisen;
use std::fs;

#[test]
fn a_section_is_measured_and_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = shisen(folder.path());
    let command = command.args(["tradeoff", "--quick", "--only", "capture"]);
    let output = command
        .args(["--out", "report", "--json"])
        .assert()
        .success();
    let output = output.get_output();
    assert!(output.stderr.is_empty(), "{output:?}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let keys: Vec<&str> = report
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect();
    let expected = [
        "build", "csv", "html", "json", "mesh", "quick", "seconds", "sections", "simd", "threads",
        "version",
    ];
    assert_eq!(keys, expected);
    assert_eq!(report["mesh"], "quadruped");
    let read = |key: &str| {
        let path = folder.path().join(report[key].as_str().unwrap());
        fs::read_to_string(path).unwrap()
    };
    let written: Value = serde_json::from_str(&read("json")).unwrap();
    assert_eq!(written, report);

    let [section] = &report["sections"].as_array().unwrap()[..] else {
        panic!("{report}");
    };
    assert_eq!(section["id"], "capture");
    let comparisons = section["comparisons"].as_array().unwrap();
    let ids: Vec<&Value> = comparisons.iter().map(|one| &one["id"]).collect();
    assert_eq!(ids, ["mappings", "sizes", "mirror-sizes", "precision"]);
    assert_eq!(section["choice"], comparisons[0]["choice"]);
    let mut rows = 1;
    for comparison in comparisons {
        let measures = comparison["measures"].as_array().unwrap().len();
        let points = comparison["points"].as_array().unwrap();
        rows += measures * points.len();
        let mut best = 0;
        for point in points {
            assert_eq!(
                point["errors"].as_array().unwrap().len(),
                measures,
                "{point}"
            );
            assert!(point["seconds"].as_f64().unwrap() > 0.0, "{point}");
            assert!(
                !point["settings"].as_object().unwrap().is_empty(),
                "{point}"
            );
            best += u32::from(point["best_by_time"].as_bool().unwrap());
        }
        assert!(best > 0 && measures > 0, "{comparison}");
        let choice = comparison["choice"].as_str().unwrap();
        assert!(choice.to_lowercase().contains("choose "), "{choice}");
    }
    // The numbers are those of `shisen dome nearfield`.
    let points = comparisons[0]["points"].as_array().unwrap();
    let error = |name: &str| {
        let point = points.iter().find(|point| point["name"] == name).unwrap();
        point["errors"][0].as_f64().unwrap()
    };
    assert!((error("paper-1 mirror") - 3.217).abs() < 6e-4);
    assert!((error("paper-2 mirror") - 22.139).abs() < 6e-4);
    assert!((error("paper-3 mirror") - 2.605).abs() < 6e-4);
    assert_eq!(error("true"), 0.0);

    assert_eq!(read("csv").lines().count(), rows);
    let page = read("html");
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"));
    // Error by time and by steps of three, by time of one that has no steps.
    assert_eq!(page.matches("<svg ").count(), 7);
}

#[test]
fn what_cannot_be_measured_is_said() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, code, text) in [
        (&["--only", "colour"][..], 2, "colour"),
        (&["--mesh", "missing.obj"], 1, "missing.obj"),
        (&["--threads", "0"], 2, "threads"),
    ] {
        let mut command = shisen(folder.path());
        let output = command
            .args(["tradeoff", "--quick"])
            .args(arguments)
            .assert();
        let output = output.code(code).get_output().clone();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains(text) && output.stdout.is_empty(), "{said}");
    }
    assert!(!folder.path().join("shisen-out/tradeoff.html").exists());
}
