//! `shisen-evidence tradeoff` and `selftest`: what they write and print, and their bad input.

use serde_json::{Value, json};
use shisen_core::Simd;
use shisen_evidence::selftest::GROUPS;
use shisen_tests::command::{folder, line, refused, run, succeed};
use shisen_tests::sizes::cases;
use std::fs;

/// What the command writes.
struct Written {
    report: Value,
    rows: Vec<csv::StringRecord>,
    page: String,
}

impl Written {
    /// Returns the only section.
    fn section(&self) -> &Value {
        let [section] = list(&self.report["sections"]) else {
            panic!("{}", self.report);
        };
        section
    }
}

/// Measures by the command, and looks at what is true of every section.
fn measured_with(words: &str) -> Written {
    let folder = folder();
    let words = format!("tradeoff {words} --out report --json");
    let said = succeed(&mut line(folder.path(), &words));
    assert_eq!(said.err, "");
    let report = said.objects().remove(0);
    assert_eq!(report["mesh"], "quadruped");
    let read = |key: &str| {
        let path = folder.path().join(report[key].as_str().unwrap());
        fs::read_to_string(path).unwrap()
    };
    let written: Value = serde_json::from_str(&read("json")).unwrap();
    assert_eq!(written, report);

    let rows: Vec<csv::StringRecord> = csv::Reader::from_reader(read("csv").as_bytes())
        .records()
        .map(Result::unwrap)
        .collect();
    let page = read("html");
    for section in list(&report["sections"]) {
        for text in ["title", "about", "choice"] {
            assert!(text_of(&section[text]).len() > 5, "{section}");
        }
        for comparison in list(&section["comparisons"]) {
            check(comparison);
        }
    }
    assert!(page.starts_with("<!DOCTYPE html>") && !page.contains("<script"));
    Written { report, rows, page }
}

/// Returns one section, in small.
fn measured(id: &str) -> Written {
    let found = measured_with(&format!("--quick --only {id}"));
    assert_eq!(found.section()["id"], id);
    assert_eq!(found.report["quick"], true);
    found
}

fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap()
}

fn text_of(value: &Value) -> &str {
    value.as_str().unwrap()
}

fn names(of: &Value, key: &str) -> Vec<String> {
    let all = list(of).iter();
    all.map(|one| text_of(&one[key]).to_owned()).collect()
}

/// Returns the first error; what is no number is farther off than anything.
fn error(point: &Value) -> f64 {
    point["errors"][0].as_f64().unwrap_or(f64::INFINITY)
}

/// Returns the error of the point with this name.
fn error_of(comparison: &Value, name: &str) -> f64 {
    let mut points = list(&comparison["points"]).iter();
    error(points.find(|point| point["name"] == name).unwrap())
}

/// Checks that each point has its errors and costs, and the sentence chooses one that is true
/// enough, or says that none is.
fn check(comparison: &Value) {
    let points = list(&comparison["points"]);
    let measures = list(&comparison["measures"]).len();
    assert!(points.len() > 1 && measures > 0, "{comparison}");
    for point in points {
        assert_eq!(list(&point["errors"]).len(), measures, "{point}");
        assert!(point["seconds"].as_f64().unwrap() > 0.0, "{point}");
        assert!(
            !point["settings"].as_object().unwrap().is_empty(),
            "{point}"
        );
    }
    assert!(
        points.iter().any(|point| point["best_by_time"] == true),
        "{comparison}"
    );
    let choice = text_of(&comparison["choice"]);
    assert!(choice.contains("hoose "), "{choice}");
    assert!(
        points.iter().any(|point| ["name", "series"]
            .iter()
            .any(|of| choice.contains(text_of(&point[of])))),
        "{choice}"
    );
}

#[test]
#[ignore = "takes half a minute: tests/run --all runs it"]
fn mirrors_have_their_price() {
    let found = measured("capture");
    let comparisons = &found.section()["comparisons"];
    assert_eq!(
        names(comparisons, "id"),
        ["mappings", "sizes", "mirror-sizes", "precision"]
    );
    assert_eq!(found.section()["choice"], comparisons[0]["choice"]);
    // The numbers are those of `shisen dome nearfield`.
    let error = |name: &str| error_of(&comparisons[0], name);
    assert!((error("paper-1 mirror") - 3.217).abs() < 6e-4);
    assert!((error("paper-2 mirror") - 22.139).abs() < 6e-4);
    assert!((error("paper-3 mirror") - 2.605).abs() < 6e-4);
    assert_eq!(error("true"), 0.0);
    // What no size of a mirror tells apart is chosen as in the first table.
    let choice = text_of(&comparisons[1]["choice"]);
    assert!(choice.starts_with("Choose true, 1024², "), "{choice}");
}

/// Two sections stand for all, of which the whole report takes minutes; `tests/page/run` has
/// each in small.
#[test]
#[ignore = "takes half a minute: tests/run --all runs it"]
fn steps_and_single_precision_have_their_price() {
    let found = measured_with("--quick --only precision,budget");
    let sections = &found.report["sections"];
    // In the report's order, not the arguments'.
    assert_eq!(names(sections, "id"), ["budget", "precision"]);
    for section in list(sections) {
        assert!(list(&section["hard_cases"]).is_empty());
        let id = text_of(&section["id"]);
        assert!(found.page.contains(&format!("<section id=\"{id}\"")));
    }
    let comparisons = &sections[0]["comparisons"];
    let points = list(&comparisons[0]["points"]);
    let steps = |place: usize| points[place]["steps"].as_u64().unwrap();
    for (number, point) in points.iter().enumerate() {
        let allowed = point["settings"]["budget_steps"].as_u64().unwrap();
        assert!(steps(number) <= allowed, "{point}");
        // More steps are never farther from the truth.
        assert!(number == 0 || error(point) <= error(&points[number - 1]));
    }
    assert!(error(&points[0]) > 0.01);
    assert_eq!(error_of(&comparisons[0], "200 %"), 0.0);
    // Tiles pay in the order of their distance from the line of sight: some at once.
    let tiles = list(&sections[0]["tiles"]);
    let percent = tiles.iter().map(|tile| tile["percent"].as_u64().unwrap());
    let (least, most) = (percent.clone().min().unwrap(), percent.max().unwrap());
    assert!(least <= 5 && most > 50 && most <= 102, "{least} to {most}");
    let mut rows = found.rows.iter();
    assert!(rows.any(|row| (&row[0], &row[1]) == ("budget", "tiles")));

    let comparisons = &sections[1]["comparisons"];
    assert_eq!(
        names(comparisons, "id"),
        ["level", "mirror", "intersection", "refraction", "colour"]
    );
    for comparison in list(comparisons) {
        let ways = ["built in, f32", "textbook, f32", "f64"];
        assert_eq!(names(&comparison["points"], "name"), ways);
        let [ours, naive, double] = ways.map(|way| error_of(comparison, way));
        let limit = comparison["limit"]["error"].as_f64().unwrap();
        assert!(ours > 0.0 && ours <= limit, "{comparison}");
        assert!(naive >= ours && double == 0.0, "{comparison}");
    }
}

#[test]
#[ignore = "takes ten seconds: tests/run --all runs it"]
fn effects_have_their_price() {
    let found = measured("effects");
    let comparisons = &found.section()["comparisons"];
    assert_eq!(names(comparisons, "id"), ["effects"]);
    let points = list(&comparisons[0]["points"]);
    assert_eq!(points[0]["name"], "all");
    assert_eq!(error(&points[0]), 0.0);
    let (last, all) = (&points[points.len() - 1], &points[0]["steps"]);
    assert_eq!(last["name"], "none");
    assert!(last["steps"].as_u64() < all.as_u64());
    // Each effect is seen somewhere.
    for point in &points[1..points.len() - 1] {
        assert!(error(point) > 0.0, "{point}");
    }
    assert!(points.len() > 8, "{}", points.len());
}

/// What is particular to the gaze, to wavelengths and to latency.
#[test]
#[ignore = "takes a minute: tests/run --all runs it"]
fn gaze_wavelengths_and_prediction_have_their_price() {
    let found = measured("gaze");
    let comparisons = list(&found.section()["comparisons"]);
    assert_eq!(comparisons.len(), 3);
    assert!(found.page.contains("<img "));
    for comparison in comparisons {
        // Both verdicts stand in the sentence, each with its limit's reason.
        for limit in [&comparison["limit"], &comparison["other_limit"]] {
            let choice = text_of(&comparison["choice"]);
            assert!(choice.contains(text_of(&limit["because"])), "{choice}");
        }
    }
    let found = measured("spectrum");
    let comparisons = &found.section()["comparisons"];
    let numbers = [1, 2, 4, 7, 14, 40].map(|count| format!("paper {count}, 8 rays each"));
    // With nothing but their number changed, more wavelengths are nearer.
    let alone = numbers.map(|name| error_of(&comparisons[1], &name));
    assert!(alone.is_sorted_by(|more, less| more > less), "{alone:?}");
    // One wavelength has no colours, few rays have rough edges.
    let nearest = 2.0 * error_of(&comparisons[0], "split 14, 128 rays");
    for poor in ["comb 1", "split 14"] {
        assert!(error_of(&comparisons[0], poor) > nearest, "{poor}");
    }
    let found = measured("latency");
    let comparisons = &found.section()["comparisons"];
    // What is later is farther off.
    let [soon, late] = [0, 1].map(|number| error_of(&comparisons[number], "no prediction"));
    assert!(soon > 0.0 && late > soon, "{soon} {late}");
}

#[test]
#[ignore = "takes half a minute: tests/run --all runs it"]
fn hard_cases_stand_in_the_report() {
    let found = match cases("hard cases", 0, 1) {
        0 => measured("cases"),
        _ => measured_with("--only cases"),
    };
    assert!(list(&found.section()["comparisons"]).is_empty());
    let cases = &found.section()["hard_cases"];
    let all = GROUPS.iter().flat_map(|(_, cases)| *cases);
    let expected: Vec<&str> = all.map(|case| case.name).collect();
    assert_eq!(names(cases, "name"), expected);
    for case in list(cases) {
        assert_eq!(case["passed"], true, "{case}");
        assert!(found.page.contains(text_of(&case["name"])));
    }
    assert_eq!(found.rows.len(), 3 * expected.len());
    // They are hard: on most of them the naive way is beyond the bound.
    let controls = list(cases).iter().filter(|case| case["control"] == true);
    assert!(controls.count() * 4 <= expected.len() && expected.len() >= 40);
}

#[test]
fn the_self_test_says_what_it_compared() {
    let folder = folder();
    let words = "selftest --quick --json frame-on-every-path-glass";
    let said = run(folder.path(), words);
    let has_avx2 = Simd::detect().name() == "avx2";
    let paths = &["portable", "avx2"][..if has_avx2 { 2 } else { 1 }];
    assert_eq!(said.objects()[0]["paths_compared"], json!(paths));
    assert_eq!(said.err.contains("no AVX2 here"), !has_avx2, "{}", said.err);
    let unknown = "selftest refracton => no case has refracton in its name";
    refused(folder.path(), 2, unknown);
}

#[test]
fn what_cannot_be_measured_is_said() {
    let folder = folder();
    refused(
        folder.path(),
        2,
        "
        tradeoff --quick --only colour => colour
        tradeoff --quick --threads 0 => threads",
    );
    refused(
        folder.path(),
        1,
        "tradeoff --quick --mesh missing.obj => missing.obj",
    );
    assert!(!folder.path().join("shisen-out").exists());
}
