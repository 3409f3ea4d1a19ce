//! `shisen-evidence tradeoff`: what it writes and prints, and its bad input.

use serde_json::Value;
use shisen_evidence::selftest::GROUPS;
use shisen_evidence::tradeoff::{Topic, pareto_front};
use shisen_tests::command::evidence;
use shisen_tests::sizes::cases;
use std::fs;

/// What the command writes.
struct Written {
    report: Value,
    rows: Vec<csv::StringRecord>,
    page: String,
}

impl Written {
    /// The only section.
    fn section(&self) -> &Value {
        let [section] = list(&self.report["sections"]) else {
            panic!("{}", self.report);
        };
        section
    }
}

/// Measures by the command, and looks at what is true of every section.
fn measured_with(arguments: &[&str]) -> Written {
    let folder = tempfile::tempdir().unwrap();
    let mut command = evidence(folder.path());
    let command = command.arg("tradeoff").args(arguments);
    let output = command
        .args(["--out", "report", "--json"])
        .assert()
        .success();
    let output = output.get_output();
    assert!(output.stderr.is_empty(), "{output:?}");
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let keys = report.as_object().unwrap().keys();
    let expected = [
        "build", "csv", "html", "json", "mesh", "quick", "seconds", "sections", "simd", "threads",
        "version",
    ];
    assert_eq!(keys.collect::<Vec<_>>(), expected);
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
    let optimised = report["build"]["optimised"] == true;
    let sections = list(&report["sections"]);
    for section in sections {
        for text in ["title", "about", "choice"] {
            assert!(text_of(&section[text]).len() > 5, "{section}");
        }
        for comparison in list(&section["comparisons"]) {
            check_fronts(comparison);
            check_choice(comparison, optimised);
        }
    }
    check_rows(sections, &rows);
    check_page(sections, &page);
    Written { report, rows, page }
}

/// One section, in small.
fn measured(id: &str) -> Written {
    let found = measured_with(&["--quick", "--only", id]);
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

/// Each point's series and name, in their order.
fn settings(comparison: &Value) -> Vec<(String, String)> {
    let points = &comparison["points"];
    let series = names(points, "series");
    series.into_iter().zip(names(points, "name")).collect()
}

/// That a comparison has these points, of a series each, and no others.
fn check_settings(comparison: &Value, expected: &[(&str, &[&str])]) {
    let of = |&(series, names): &(&str, &[&str])| -> Vec<(String, String)> {
        let pair = |name: &&str| (series.to_owned(), (*name).to_owned());
        names.iter().map(pair).collect()
    };
    let mut expected: Vec<_> = expected.iter().flat_map(of).collect();
    let mut found = settings(comparison);
    expected.sort();
    found.sort();
    assert_eq!(found, expected, "{}", comparison["id"]);
}

/// The first error; what is no number is farther off than anything.
fn error(point: &Value) -> f64 {
    point["errors"][0].as_f64().unwrap_or(f64::INFINITY)
}

/// That of the point of a name.
fn error_of(comparison: &Value, name: &str) -> f64 {
    let mut points = list(&comparison["points"]).iter();
    error(points.find(|point| point["name"] == name).unwrap())
}

/// Checks that a comparison has each error and cost, and the fronts of its points;
/// of points that are equal in all but chance one stands for all.
fn check_fronts(comparison: &Value) {
    let points = list(&comparison["points"]);
    let measures = list(&comparison["measures"]).len();
    assert!(points.len() > 1 && measures > 0, "{comparison}");
    for point in points {
        assert_eq!(list(&point["errors"]).len(), measures, "{point}");
        assert!(point["seconds"].as_f64().unwrap() > 0.0, "{point}");
        assert!(point["spread"].as_f64().unwrap() >= 0.0, "{point}");
        assert!(
            !point["settings"].as_object().unwrap().is_empty(),
            "{point}"
        );
    }
    for (cost, best) in [("seconds", "best_by_time"), ("steps", "best_by_steps")] {
        let costs = points
            .iter()
            .map(|point| (error(point), point[cost].as_f64().unwrap_or(f64::NAN)));
        let front = pareto_front(&costs.collect::<Vec<_>>());
        for (number, (point, is_on_it)) in points.iter().zip(&front).enumerate() {
            let twin = |&other: &usize| {
                error(&points[other]) == error(point) && points[other]["steps"] == point["steps"]
            };
            let mut all = (0..points.len()).filter(twin);
            let marked = point[best] == true;
            let twins_front = all.clone().any(|other| front[other]);
            assert!(!marked || twins_front, "{point}");
            let has_mark = all.any(|other| points[other][best] == true);
            assert!(!is_on_it || has_mark, "{number}: {point}");
        }
    }
    let has_steps = points.iter().all(|point| point["steps"].is_u64());
    let is_best = |by: &str| points.iter().any(|point| point[by] == true);
    assert!(is_best("best_by_time"), "{comparison}");
    assert_eq!(is_best("best_by_steps"), has_steps, "{comparison}");
}

/// The sentence follows from the points: what it chooses is one of them, is true enough
/// if anything is, and costs no more steps than what is true enough, too.
fn check_choice(comparison: &Value, optimised: bool) {
    let choice = text_of(&comparison["choice"]);
    let points = list(&comparison["points"]);
    let limit = &comparison["limit"];
    assert!(text_of(&limit["because"]).len() > 5, "{limit}");
    let limit = limit["error"].as_f64().unwrap();
    let enough: Vec<&Value> = points.iter().filter(|one| error(one) <= limit).collect();
    let said = choice.split_once("Choose ");
    let Some((_, after)) = said.or_else(|| choice.split_once("choose ")) else {
        panic!("nothing is chosen: {choice}");
    };
    if after.starts_with("by the times of an optimised build") {
        assert!(!optimised, "{choice}");
        for one in enough {
            assert!(choice.contains(text_of(&one["name"])), "{choice}");
        }
        return;
    }
    let id = text_of(&comparison["id"]);
    if HAVE_THEIR_OWN.iter().any(|own| id.starts_with(own)) {
        let starts_with = |text: &Value| after.starts_with(text_of(text));
        let is_chosen =
            |point: &Value| ["name", "series"].iter().any(|&of| starts_with(&point[of]));
        assert!(points.iter().any(is_chosen), "{choice}");
        if id.starts_with("latency-") {
            assert_eq!(
                enough.is_empty(),
                choice.starts_with("No setting has"),
                "{choice}"
            );
        }
        return;
    }
    // Names may begin with others.
    let named = points.iter().filter(|point| {
        let rest = after.strip_prefix(text_of(&point["name"]));
        rest.is_some_and(|rest| rest.starts_with(", "))
    });
    let Some(chosen) = named.max_by_key(|point| text_of(&point["name"]).len()) else {
        panic!("no point is chosen: {choice}");
    };
    let none = choice.starts_with("No setting has");
    assert_eq!(enough.is_empty(), none, "{choice}");
    if let (Some(steps), false) = (chosen["steps"].as_f64(), none) {
        assert!(error(chosen) <= limit, "{choice}");
        for other in enough {
            // What is within a hundredth costs the same.
            let least = other["steps"].as_f64().unwrap();
            assert!(0.99 * steps <= least, "{other}: {choice}");
        }
    }
}

/// How the names of comparisons begin whose sentences are not by their limits: which mapping
/// is what it is for, which precision is one for both mappings, and which horizon is by the
/// widened frame.
const HAVE_THEIR_OWN: [&str; 3] = ["mappings", "precision", "latency-"];

/// Each error has a row, and behind these each hard case three, each tile one, with the
/// numbers of the report.
fn check_rows(sections: &[Value], rows: &[csv::StringRecord]) {
    let mut left = rows.iter();
    for section in sections {
        for comparison in list(&section["comparisons"]) {
            for point in list(&comparison["points"]) {
                let measures = list(&comparison["measures"]).iter();
                for (measure, error) in measures.zip(list(&point["errors"])) {
                    let row = left.next().unwrap();
                    let expected = [
                        &section["id"],
                        &comparison["id"],
                        &point["series"],
                        &point["name"],
                        &measure["id"],
                    ];
                    let found = [&row[0], &row[1], &row[2], &row[3], &row[5]];
                    assert_eq!(found, expected.map(text_of));
                    assert!(is_number(&row[6], error), "{row:?}");
                    assert!(is_number(&row[7], &point["seconds"]), "{row:?}");
                    assert!(is_number(&row[8], &point["spread"]), "{row:?}");
                    assert!(is_number(&row[9], &point["steps"]), "{row:?}");
                }
            }
        }
    }
    for section in sections {
        let count = 3 * list(&section["hard_cases"]).len() + list(&section["tiles"]).len();
        for number in 0..count {
            let row = left.next().unwrap();
            assert_eq!(section["id"], row[0], "{number}: {row:?}");
        }
    }
    assert_eq!(left.len(), 0);
}

/// Whether a text is the same number, to all digits but the last, or neither is one.
fn is_number(text: &str, value: &Value) -> bool {
    match (text.parse::<f64>().ok(), value.as_f64()) {
        (Some(text), Some(value)) => (text - value).abs() <= 1.0e-15 * value.abs(),
        (text, value) => text.is_none() && value.is_none(),
    }
}

/// The page stands alone, and has a chart for each cost of each comparison, the sentences,
/// and every point's name.
fn check_page(sections: &[Value], page: &str) {
    assert!(page.starts_with("<!DOCTYPE html>") && page.trim_end().ends_with("</html>"));
    assert!(!page.contains("<script"));
    // The bytes of a picture may spell anything.
    let mut lines = page.lines().filter(|line| !line.contains("<img "));
    assert!(!lines.any(|line| line.contains("NaN")));
    let comparisons = || sections.iter().flat_map(|one| list(&one["comparisons"]));
    let costs = comparisons().map(|one| {
        let steps = list(&one["points"])
            .iter()
            .all(|point| point["steps"].is_u64());
        1 + usize::from(steps)
    });
    let charts = page.matches("<svg ").count();
    assert!(charts >= costs.sum(), "{charts}");
    let escaped = |value: &Value| {
        let text = text_of(value).replace('&', "&amp;");
        text.replace('<', "&lt;").replace('>', "&gt;")
    };
    for section in sections {
        assert!(page.contains(&escaped(&section["choice"])), "{section}");
    }
    for comparison in comparisons() {
        assert!(page.contains(&escaped(&comparison["choice"])));
        for point in list(&comparison["points"]) {
            assert!(page.contains(&escaped(&point["name"])), "{point}");
        }
    }
}

#[test]
#[ignore = "takes half a minute: tests/run --all runs it"]
fn the_gaze_has_its_price() {
    let found = measured("gaze");
    let comparisons = &found.section()["comparisons"];
    assert_eq!(names(comparisons, "id"), ["methods", "depths", "samples"]);
    assert!(found.page.contains("<img "));
    let methods: [(&str, &[&str]); 7] = [
        ("all in full", &["full"]),
        (
            "method",
            &[
                "paper",
                "paper-ellipse",
                "rays only",
                "rays and bounces",
                "rays and faces",
            ],
        ),
        (
            "peripheral sampling",
            &[
                "foveated",
                "foveated, the paper's levels",
                "foveated, 2 times as coarse",
                "foveated, 4 times as coarse",
            ],
        ),
        (
            "cut-offs",
            &[
                "full to 5°",
                "full to 15°",
                "full to 45°",
                "border −20°",
                "border +20°",
            ],
        ),
        ("faces", &["from 2000 faces", "4 levels"]),
        ("fewer faces everywhere", &["2000 faces"]),
        ("filled by a capture", &["capture 64²", "capture 128²"]),
    ];
    check_settings(&comparisons[0], &methods);
    let everywhere = [0, 1, 2, 3, 4, 5].map(|depth| format!("depth {depth}"));
    let everywhere = everywhere.each_ref().map(String::as_str);
    let paper = ["paper, depth 1", "paper, depth 3", "paper, depth 5"];
    let depths = [("everywhere", &everywhere[..]), ("paper", &paper[..])];
    check_settings(&comparisons[1], &depths);
    let everywhere = ["1 ray", "2 rays", "4 rays", "8 rays"];
    let paper = everywhere.map(|name| format!("paper, {name}"));
    let paper = paper.each_ref().map(String::as_str);
    let samples = [("everywhere", &everywhere[..]), ("paper", &paper[..])];
    check_settings(&comparisons[2], &samples);
    let measures = ["flip", "psnr", "ssim"].map(|of| {
        let unit = if of == "psnr" { "_db" } else { "" };
        let rings = ["_weighted", "_fovea", "_parafovea", "_periphery", ""];
        rings.map(|ring| format!("{of}{ring}{unit}"))
    });
    for comparison in list(comparisons) {
        assert_eq!(names(&comparison["measures"], "id"), measures.concat());
        // Both verdicts stand in the sentence, each with its limit's reason.
        let limits = [&comparison["limit"], &comparison["other_limit"]];
        let mut errors = limits.map(|limit| limit["error"].as_f64().unwrap());
        errors.sort_by(f64::total_cmp);
        assert_eq!(errors, [0.001, 0.01]);
        let choice = text_of(&comparison["choice"]);
        for limit in limits {
            let because = text_of(&limit["because"]);
            assert!(choice.contains(because), "{choice}");
        }
    }
}

#[test]
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
    let of_sizes = |mapping: &str| -> Vec<String> {
        let mirrors = ["paper-1", "best"].iter();
        let sizes = |mirror| [64, 256, 1024].map(|size| format!("{mirror} {mapping}, {size}²"));
        mirrors.flat_map(sizes).collect()
    };
    let [mirror, exact] = ["mirror", "exact"].map(of_sizes);
    let [mirror, exact] = [&mirror, &exact].map(|of| of.iter().map(String::as_str).collect());
    let [mirror, exact]: [Vec<&str>; 2] = [mirror, exact];
    let all = ["true, 64²", "true, 256²", "true, 1024²"];
    let sizes = [("mirror", &mirror[..]), ("exact", &exact), ("true", &all)];
    check_settings(&comparisons[1], &sizes);
    let parts = ["1e-6", "1e-4", "1e-2", "1e-1"];
    let [mirror, exact] = ["mirror", "exact"].map(|of| parts.map(|part| format!("{of} of {part}")));
    let [mirror, exact] = [&mirror, &exact].map(|of| of.each_ref().map(String::as_str));
    let mirror_sizes = [("mirror", &mirror[..]), ("exact", &exact)];
    check_settings(&comparisons[2], &mirror_sizes);
    // What no size of a mirror tells apart is chosen as in the first table.
    let choice = text_of(&comparisons[1]["choice"]);
    assert!(choice.starts_with("Choose true, 1024², "), "{choice}");
    // Error by time and by steps of three, by time of one that has no steps.
    assert_eq!(found.page.matches("<svg ").count(), 7);
}

#[test]
#[ignore = "takes half a minute: tests/run --all runs it"]
fn wavelengths_have_their_price() {
    let found = measured("spectrum");
    let comparisons = &found.section()["comparisons"];
    assert_eq!(names(comparisons, "id"), ["wavelengths", "numbers"]);
    let wavelengths: [(&str, &[&str]); 6] = [
        ("paper", &["paper 1", "paper 7", "paper 14", "paper 40"]),
        ("fixed", &["fixed 7", "fixed 14"]),
        (
            "comb",
            &["comb 1", "comb 4", "comb 7", "comb 14", "comb 40"],
        ),
        ("split", &["split 4", "split 7", "split 14"]),
        ("split, more rays", &["split 14, 128 rays"]),
        (
            "comb, several each",
            &["comb 14, 2 each", "comb 14, 4 each", "comb 14, 7 each"],
        ),
    ];
    check_settings(&comparisons[0], &wavelengths);
    let numbers = [1, 2, 4, 7, 14, 40].map(|count| format!("paper {count}, 8 rays each"));
    let numbers = numbers.each_ref().map(String::as_str);
    check_settings(&comparisons[1], &[("paper, 8 rays for each", &numbers)]);
    // With nothing but their number changed, more wavelengths are nearer.
    let alone = numbers.map(|name| error_of(&comparisons[1], name));
    assert!(alone.is_sorted_by(|more, less| more > less), "{alone:?}");
    let error = |name: &str| error_of(&comparisons[0], name);
    // One wavelength has no colours, few rays have rough edges.
    let nearest = error("split 14, 128 rays");
    assert!(error("comb 1") > 2.0 * nearest && error("split 14") > 2.0 * nearest);
    // What the truth is off by itself is well below what counts as nothing.
    let about = text_of(&found.section()["about"]);
    let own = about.split_once("it is off by ").unwrap().1;
    let own: f64 = own.split_once(' ').unwrap().0.parse().unwrap();
    let limit = comparisons[0]["limit"]["error"].as_f64().unwrap();
    assert!(own > 0.0 && own <= 0.5 * limit, "{own} of {limit}");
}

#[test]
fn steps_have_their_price() {
    let found = measured("budget");
    let comparisons = &found.section()["comparisons"];
    assert_eq!(names(comparisons, "id"), ["budgets"]);
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
    let tiles = list(&found.section()["tiles"]);
    let percent = tiles.iter().map(|tile| tile["percent"].as_u64().unwrap());
    let (least, most) = (percent.clone().min().unwrap(), percent.max().unwrap());
    assert!(least <= 5 && most > 50 && most <= 102, "{least} to {most}");
    let last = &found.rows[found.rows.len() - 1];
    assert_eq!((&last[0], &last[1]), ("budget", "tiles"));
}

#[test]
fn single_precision_has_its_price() {
    let found = measured("precision");
    let comparisons = &found.section()["comparisons"];
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
    // Each effect is seen somewhere, and its pixels are counted.
    for point in &points[1..points.len() - 1] {
        assert!(error(point) > 0.0, "{point}");
        let counted = &list(&point["errors"])[list(&points[0]["errors"]).len() - 2];
        assert!(counted.as_f64().unwrap() > 0.0, "{point}");
    }
    assert!(points.len() > 8, "{}", points.len());
}

#[test]
#[ignore = "takes half a minute: tests/run --all runs it"]
fn prediction_has_its_price() {
    let found = measured("latency");
    let comparisons = &found.section()["comparisons"];
    assert_eq!(names(comparisons, "id"), ["latency-20ms", "latency-50ms"]);
    // What is later is farther off.
    let [soon, late] = [0, 1].map(|number| error_of(&comparisons[number], "no prediction"));
    assert!(soon > 0.0 && late > soon, "{soon} {late}");
    let widening = |point: &Value| point["errors"][7].as_f64().unwrap();
    for comparison in list(comparisons) {
        for point in list(&comparison["points"]) {
            assert!(widening(point) > 0.0, "{point}");
        }
    }
}

#[test]
fn hard_cases_stand_in_the_report() {
    let found = measured("cases");
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
    for (rows, case) in found.rows.chunks(3).zip(list(cases)) {
        for (row, key) in rows.iter().zip(["error", "bound", "naive_error"]) {
            assert!(is_number(&row[6], &case[key]), "{row:?}: {case}");
        }
    }
}

/// The whole report takes minutes on two processors: two small sections stand for it, and
/// with `SHISEN_HEAVY` it is made. (`tests/page/run` has all sections in small.)
#[test]
fn a_report_has_its_sections_in_order() {
    let two = [Topic::Budget, Topic::Precision];
    let short = ["--quick", "--only", "precision,budget"];
    let (arguments, topics) = match cases("sections of the report", two.len(), Topic::ALL.len()) {
        2 => (&short[..], &two[..]),
        _ => (&[][..], &Topic::ALL[..]),
    };
    let found = measured_with(arguments);
    let expected: Vec<&str> = topics.iter().map(|topic| topic.id()).collect();
    let sections = &found.report["sections"];
    assert_eq!(names(sections, "id"), expected);
    assert_eq!(found.report["quick"], arguments.contains(&"--quick"));
    for section in list(sections) {
        let hard_cases = list(&section["hard_cases"]);
        assert!(hard_cases.iter().all(|case| case["passed"] == true));
        let id = text_of(&section["id"]);
        assert_eq!(id == "cases", !hard_cases.is_empty(), "{id}");
        assert_eq!(id == "cases", list(&section["comparisons"]).is_empty());
        assert!(found.page.contains(&format!("<section id=\"{id}\"")));
    }
}

#[test]
fn what_cannot_be_measured_is_said() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, code, text) in [
        (&["--only", "colour"][..], 2, "colour"),
        (&["--mesh", "missing.obj"], 1, "missing.obj"),
        (&["--threads", "0"], 2, "threads"),
    ] {
        let mut command = evidence(folder.path());
        let output = command
            .args(["tradeoff", "--quick"])
            .args(arguments)
            .assert();
        let output = output.code(code).get_output().clone();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(said.contains(text) && output.stdout.is_empty(), "{said}");
    }
    assert!(!folder.path().join("shisen-out").exists());
}
