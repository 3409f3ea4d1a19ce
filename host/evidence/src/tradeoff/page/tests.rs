use super::super::{Build, Figure, Limit, TilePrice, measure};
use super::*;
use crate::selftest::{Case, Family};
use quick_xml::Reader;
use quick_xml::events::Event;
use shisen::picture::Picture;

static CASE: Case = Family {
    error: "radii",
    reference: "exact",
    naive: "b² − 4ac < 0",
}
.case("sphere-far", "far & away", 1.0, |_| unreachable!());

/// A report with one of everything.
fn report() -> Report {
    let point = |name: &str, error: f64, seconds: f64, steps: u64| {
        let settings = [("depth", 3.into()), ("method", "a & b".into())];
        let mut point = Point::new("one <series>", name, settings);
        point.errors = vec![Some(error), None];
        point.seconds = seconds;
        point.steps = Some(steps);
        point
    };
    let points = vec![
        point("half & half", 0.25, 0.5, 5_000),
        point("\"full\"", 0.0, 1.0, 1_234_567),
        point("worse", 0.5, 0.75, 10_000),
    ];
    let measures = vec![measure("off", "error <°>"), measure("none", "no number")];
    let limit = Limit {
        error: 0.1,
        because: "a bound",
    };
    let comparison = Comparison::new(
        ("first", "First"),
        "About & so on.",
        measures,
        limit,
        points,
    );
    let mut section = Section::new("gaze", "Gaze", "About it.".to_owned(), vec![comparison]);
    section.pictures.push(Figure {
        caption: "A <picture>".to_owned(),
        picture: Picture::new(2, 3).unwrap(),
    });
    section.hard_cases.push(Row {
        group: "spheres",
        case: &CASE,
        passed: true,
        error: 0.5,
        naive_error: f64::INFINITY,
        control: false,
    });
    section.tiles.push(TilePrice {
        picture: 1,
        x: 16,
        y: 32,
        percent: 35,
    });
    Report {
        version: "0",
        quick: true,
        threads: 2,
        simd: "portable".to_owned(),
        build: Build {
            profile: "release, opt-level 3".to_owned(),
            optimised: true,
            commit: Some("1f"),
            cpu_features: vec!["sse2", "avx2"],
        },
        mesh: "a&b.obj".to_owned(),
        seconds: 90.0,
        sections: vec![section],
    }
}

/// The names of all elements, in order; asserts that they are well nested.
fn elements(page: &str) -> Vec<String> {
    let body = page.strip_prefix("<!DOCTYPE html>").unwrap();
    let mut reader = Reader::from_str(body);
    let (mut names, mut depth) = (Vec::new(), 0);
    loop {
        match reader.read_event().unwrap() {
            Event::Start(element) => {
                depth += 1;
                names.push(element.name().as_ref().to_owned());
            }
            Event::Empty(element) => {
                names.push(element.name().as_ref().to_owned());
            }
            Event::End(_) => depth -= 1,
            Event::Eof => break,
            _ => {}
        }
    }
    assert_eq!(depth, 0);
    names
}

#[test]
fn the_page_is_well_formed_and_needs_nothing_else() {
    let page = html(&report()).unwrap();
    let names = elements(&page);
    let count = |name: &str| names.iter().filter(|one| *one == name).count();
    // Error and time, error and steps.
    assert_eq!((count("svg"), count("img"), count("section")), (2, 1, 1));
    assert_eq!(count("script"), 0);
    // Namespaces are names, not places.
    let fetched = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    assert!(!fetched.contains("http"), "something is fetched");
    for text in [
        "half &amp; half",
        "one &lt;series&gt;",
        "a&amp;b.obj",
        "1\u{2009}234\u{2009}567",
        "<td>far &amp; away</td><td class=\"number\">0.500</td>",
        "<td class=\"number\">wrong</td>",
        "profile release, opt-level 3; commit 1f; the processor has sse2, avx2.",
    ] {
        assert!(page.contains(text), "{text}");
    }
    let said = "This build is not optimised.";
    assert!(!page.contains(said));
    let mut report = report();
    report.build.optimised = false;
    assert!(html(&report).unwrap().contains(said));
}

#[test]
fn the_front_is_marked() {
    let page = html(&report()).unwrap();
    let rows: Vec<&str> = page
        .lines()
        .filter(|line| line.contains("<td class=\"best\">"))
        .collect();
    assert_eq!(rows.len(), 3);
    for (row, best) in rows.iter().zip(["●○", "●○", ""]) {
        assert!(
            row.contains(&format!("<td class=\"best\">{best}</td>")),
            "{row}"
        );
        assert_eq!(row.contains("class=\"front\""), !best.is_empty(), "{row}");
    }
}

#[test]
fn points_without_an_error_stand_on_the_lower_edge() {
    let mut comparison = report().sections.remove(0).comparisons.remove(0);
    comparison.logarithmic = true;
    comparison.points[2].errors[0] = Some(50.0);
    let charts = charts_of(&comparison);
    assert_eq!(charts.len(), 2);
    for chart in charts {
        let dots = chart.lines.iter().find(|line| line.dots).unwrap();
        let lowest = chart.y.range.start;
        assert!(lowest > 0.0 && lowest < 0.25);
        assert_eq!(dots.points[1].1, Some(lowest));
        // All three, and those beside the names.
        let circles = chart.svg(CHART).unwrap().matches("<circle").count();
        assert_eq!(circles, chart.circles());
        assert!(circles >= 3);
    }
}

#[test]
fn numbers_are_short() {
    for (number, text) in [
        (0.0, "0"),
        (0.012_345, "0.0123"),
        (1.0, "1.00"),
        (12.345, "12.3"),
        (1_234.5, "1234"),
        (1e-6, "1.0e-6"),
        (-2.5, "-2.50"),
    ] {
        assert_eq!(short(number), text);
    }
    for (number, text) in [(0.01, "0.01"), (1.0, "1"), (100.0, "100"), (1e-6, "1.0e-6")] {
        assert_eq!(brief(number), text);
    }
    for (seconds, text) in [
        (61.0, "1 min 01 s"),
        (1.5, "1.50 s"),
        (0.25, "250 ms"),
        (5e-6, "5.00 µs"),
    ] {
        assert_eq!(time(seconds), text);
    }
    assert_eq!(
        [0, 999, 1_000, 1_234_567].map(grouped).join(" "),
        "0 999 1\u{2009}000 1\u{2009}234\u{2009}567"
    );
}

#[test]
fn numbers_that_no_scale_holds_have_no_axis() {
    for (numbers, logarithmic, has) in [
        (&[1.0, 2.0][..], true, true),
        (&[1.0e-9, 1.0e9], true, true),
        (&[5.0e-324, 1.0], true, false),
        (&[1.0, f64::MAX], true, false),
        (&[0.0, -1.0], true, false),
        (&[0.0, -1.0], false, true),
        (&[f64::MIN, f64::MAX], false, false),
        (&[f64::NAN], false, false),
        (&[], false, false),
    ] {
        let found = axis(numbers, logarithmic);
        assert_eq!(found.is_some(), has, "{numbers:?}: {found:?}");
    }
}
