use super::super::{Build, TilePrice, limit, measure};
use super::*;
use crate::selftest::GROUPS;
use shisen::picture::Picture;

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
    let limit = limit(0.1, "a bound");
    let comparison = Comparison::new(
        ("first", "First"),
        "About & so on.",
        measures,
        limit,
        points,
    );
    let mut section = Section::new("gaze", "Gaze", "About it.".to_owned(), vec![comparison]);
    let picture = Picture::new(2, 3).unwrap();
    section.pictures.push(("A <picture>".to_owned(), picture));
    section.hard_cases.push(Row {
        group: "spheres",
        case: &GROUPS[0].1[0],
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

#[test]
fn the_page_has_everything_and_needs_nothing_else() {
    let page = html(&report()).unwrap();
    // Error and time, error and steps.
    let counts = [
        "<svg ",
        "<img ",
        "<section ",
        "<script",
        "<tr class=\"front\">",
    ];
    let counts = counts.map(|tag| page.matches(tag).count());
    assert_eq!(counts, [2, 1, 1, 0, 2]);
    // Namespaces are names, not places.
    let fetched = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    assert!(!fetched.contains("http"), "something is fetched");
    for text in [
        "half &amp; half",
        "one &lt;series&gt;",
        "a&amp;b.obj",
        "1\u{2009}234\u{2009}567",
        "<td>origin a radius away</td><td class=\"number\">0.500</td>",
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
