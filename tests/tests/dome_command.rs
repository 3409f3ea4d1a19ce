//! `shisen dome` against the reference's tables, and its bad input. The tables in full are
//! beside the designs, in the library's `dome`.

use serde_json::Value;
use shisen_tests::command::{folder, refused, report};
use std::fs;
use std::path::Path;

fn dome(folder: &Path, words: &str) -> Value {
    report(folder, &format!("dome {words}"))
}

fn design(words: &str) -> Value {
    dome(folder().path(), &format!("design {words}"))
}

/// Asserts that a number has the digits of a table, to half a unit of the last place and a
/// thousandth for its own rounding.
fn rounds_to(found: &Value, digits: &str) {
    let exact: f64 = digits.parse().unwrap();
    let places = digits.split_once('.').map_or(0, |(_, places)| places.len());
    let unit = 10f64.powi(-(places as i32));
    let off = (found.as_f64().unwrap() - exact).abs();
    assert!(off <= 0.501 * unit, "{found}: {digits}");
}

#[test]
fn designs_have_the_digits_of_the_optima() {
    // β₁ in degrees, error in % and px, extrema.
    let keys = [
        "c1",
        "b1",
        "d1",
        "p",
        "fov",
        "width",
        "error_percent",
        "error_px_4096",
    ];
    for (words, beta1, digits, extrema) in [
        (
            "--projection parallel --a 1.288",
            "37.8256757635",
            "1.01736579173 0.613261081588 - - - 1.22652216318 0.125440321211 2.56902",
            ["29.6088", "77.0197"],
        ),
        (
            "--projection perspective --a 1",
            "21.6375486636",
            "0.929535036626 0.368733800573 0.347174696379 1.27670973300 93.4498053457 - \
             1.048534935461 21.4740",
            ["29.2151", "77.6608"],
        ),
        (
            "--projection perspective --a 2.35",
            "18.0242195052",
            "2.23467564580 0.309418987958 1.13943050469 3.37410615049 30.3852554105 - \
             0.108741896825 2.22703",
            ["30.2192", "77.4909"],
        ),
    ] {
        let found = design(words);
        let degrees = found["beta1"].as_f64().unwrap().to_degrees();
        rounds_to(&degrees.into(), beta1);
        for (key, digits) in keys.into_iter().zip(digits.split(' ')) {
            match digits {
                "-" => assert!(found[key].is_null(), "{words}: {key}"),
                digits => rounds_to(&found[key], digits),
            }
        }
        rounds_to(&found["extrema"][0], extrema[0]);
        rounds_to(&found["extrema"][1], extrema[1]);
    }
}

#[test]
fn designs_are_the_ones_that_are_asked_for() {
    // The optima beyond the paper's.
    let parallel = design("--projection parallel");
    rounds_to(&parallel["a"], "1.288248331186");
    rounds_to(&parallel["error_percent"], "0.123784174756");
    let perspective = design("--projection perspective");
    rounds_to(&perspective["a"], "4.50414971");
    rounds_to(&perspective["p"], "4.8927036");
    rounds_to(&perspective["error_percent"], "0.105759211320");
    let paper = design("--projection perspective --a 1");
    for (name, like) in [
        ("best-parallel", &parallel),
        ("best", &perspective),
        ("paper-2", &paper),
    ] {
        let named = design(&format!("--config {name}"));
        assert_eq!(named["config"], name);
        for key in ["a", "c1", "b1", "beta1", "error_percent"] {
            let off = named[key].as_f64().unwrap() / like[key].as_f64().unwrap() - 1.0;
            assert!(off.abs() < 1.0e-8, "{name} {key}: {off}");
        }
    }
    // A viewpoint, and the edge that it sees.
    let viewpoint = design("--projection perspective --a 2.35 --p 3.374");
    rounds_to(&viewpoint["p"], "3.37400000000000");
    rounds_to(&viewpoint["error_percent"], "0.10891");
    let edge = |beta1: f64| {
        design(&format!(
            "--projection perspective --a 2.35 --beta1 {beta1}"
        ))
    };
    rounds_to(
        &edge(viewpoint["beta1"].as_f64().unwrap())["p"],
        "3.37400000000",
    );
    // The exact limit: parallel projection, and finite.
    let limit = edge((1.0f64 / 2.35).atan());
    assert!(limit["p"].is_null() && limit["error_percent"].is_number());
    assert_eq!(limit["projection"], "parallel");
}

#[test]
fn other_mappings_have_no_error() {
    let folder = folder();
    let mirror = design("--config paper-2");
    for mapping in ["exact", "true"] {
        let found = design(&format!("--config paper-2 --mapping {mapping}"));
        assert_eq!(found["mapping"], mapping);
        assert_eq!((&found["a"], &found["p"]), (&mirror["a"], &mirror["p"]));
        assert_eq!(found["error_percent"], 0.0);
        assert_eq!(found["extrema"].as_array().unwrap().len(), 0);
        for precision in ["", "--f32"] {
            let words = format!("map --config best --mapping {mapping} --step 7.5 {precision}");
            let map = dome(folder.path(), &words);
            for key in ["r_d_to_theta", "theta_to_r_d"] {
                let rows = map[key].as_array().unwrap();
                assert_eq!(rows.len(), 13);
                for row in rows {
                    let [theta, r_d, error] =
                        ["theta_deg", "r_d_deg", "error_px"].map(|key| row[key].as_f64().unwrap());
                    assert!(
                        (theta - r_d).abs() < 4.0e-5 && error.abs() <= 1.0e-3,
                        "{row}"
                    );
                }
            }
        }
    }
    let curves = dome(folder.path(), "curve --points 9 --mapping exact");
    for (number, zero) in [(0, true), (2, false), (5, true)] {
        let lines = curves["figures"][number]["lines"].as_array().unwrap();
        let y = lines.last().unwrap()["y"].as_array().unwrap();
        assert_eq!(y.iter().all(|y| y.as_f64() == Some(0.0)), zero, "{number}");
    }
    let same = dome(folder.path(), "compare --mapping true --size 64");
    assert_eq!(same["differing"], 0);
}

#[test]
fn the_best_viewpoint_gains_at_every_distance() {
    let folder = folder();
    for mapping in ["mirror", "exact"] {
        let words = format!("nearfield --config best --mapping {mapping}");
        let screen = dome(folder.path(), &words);
        let best = dome(folder.path(), &format!("{words} --viewpoint best"));
        let far = best["distances"][5]["max_px"].as_f64().unwrap();
        for (i, row) in best["viewpoints"].as_array().unwrap().iter().enumerate() {
            let number = |key: &str| row[key].as_f64().unwrap();
            assert!(number("offset") < 0.0 && number("gain") > 1.0, "{row}");
            for (report, key) in [(&screen, "screen_max_px"), (&best, "max_px")] {
                let near = report["distances"][i]["max_px"].as_f64().unwrap();
                assert_eq!(near.max(far), number(key), "{row}");
            }
        }
    }
}

#[test]
fn a_mirror_of_a_millionth_loses_nothing() {
    let found = dome(
        folder().path(),
        "nearfield --config paper-1 --mapping exact",
    );
    let sizes = found["sizes"].as_array().unwrap();
    assert_eq!(sizes.len(), 30);
    for row in sizes {
        let [offset, size, rounding, near] = ["offset", "size", "rounding_px", "near_field_px"]
            .map(|key| row[key].as_f64().unwrap());
        // Half a unit of the eye's place, seen from the nearest surface.
        let place = f64::from((offset as f32).next_up()) - offset;
        let bound = 1.0e-3 + 2.0 * place * 2048.0 / std::f64::consts::FRAC_PI_2;
        assert!(offset == 0.0 || rounding <= bound, "{row}");
        if (size / 1.0e-6 - 1.0).abs() < 1.0e-9 && offset > 0.0 {
            assert!(near <= 1.0e-3, "{row}");
            // As an object of the world such a mirror has no shape left.
            assert!(row["world_px"].as_f64().is_none_or(|px| px > 10.0), "{row}");
        }
    }
}

#[test]
fn impossible_mirrors_are_usage() {
    let folder = folder();
    for (words, expected) in [
        (
            "perspective --a 0",
            "ratio is 0: give a number from 0.01 to 100",
        ),
        ("perspective --a -1", "ratio is -1: give"),
        ("perspective --a 2 --p 1.5", "viewpoint is 1.5 radii"),
        ("perspective --a 2 --p 2", "finite number above 2,"),
        ("perspective --a 2 --p nan", "viewpoint is NaN"),
        (
            "perspective --a 1 --beta1 0.79",
            "of 0.79 rad: give a number from 0.001 to 0.785398163",
        ),
        ("perspective --a 1 --beta1 nan", "of NaN rad"),
        ("perspective --p 3", "--a <RATIO>"),
        ("perspective --a 1 --p 3 --beta1 0.2", "--beta1"),
        ("perspective --config best", "--config"),
        ("parallel --a nan", "ratio is NaN: give"),
        ("parallel --a 101", "0.01 to 100"),
        ("parallel --a 1 --p 3", "--p is 3"),
        ("parallel --a 1 --beta1 0.2", "--beta1 is 0.2"),
    ] {
        refused(
            folder.path(),
            2,
            &[(&format!("dome design --projection {words}"), expected)],
        );
    }
    refused(
        folder.path(),
        2,
        &[
            ("dome design", "--projection"),
            ("dome design --config paper-4", "paper-3"),
            ("dome map --step 0", "degrees from 0.001 to 90"),
            ("dome map --mapping round", "exact"),
            ("dome nearfield --distance 0.6", "is 0.6 radii"),
            ("dome nearfield --distance 1,nan", "is NaN radii"),
            ("dome nearfield --distance -1", "above 0.61326"),
            ("dome nearfield --world-offset 1e7", "0 to 1e6"),
            ("dome curve --points 1", "from 2 to 10000"),
        ],
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}
