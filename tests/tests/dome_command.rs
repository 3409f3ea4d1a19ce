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
fn impossible_mirrors_are_usage() {
    let folder = folder();
    refused(folder.path(), 2, "
        dome design --projection perspective --a 0 => ratio is 0: give a number from 0.01 to 100
        dome design --projection perspective --a -1 => ratio is -1: give
        dome design --projection perspective --a 2 --p 1.5 => viewpoint is 1.5 radii
        dome design --projection perspective --a 2 --p 2 => finite number above 2,
        dome design --projection perspective --a 2 --p nan => viewpoint is NaN
        dome design --projection perspective --a 1 --beta1 0.79 => of 0.79 rad: give a number from 0.001 to 0.785398163
        dome design --projection perspective --a 1 --beta1 nan => of NaN rad
        dome design --projection perspective --p 3 => --a <RATIO>
        dome design --projection perspective --a 1 --p 3 --beta1 0.2 => --beta1
        dome design --projection perspective --config best => --config
        dome design --projection parallel --a nan => ratio is NaN: give
        dome design --projection parallel --a 101 => 0.01 to 100
        dome design --projection parallel --a 1 --p 3 => --p is 3
        dome design --projection parallel --a 1 --beta1 0.2 => --beta1 is 0.2
        dome design => --projection
        dome design --config paper-4 => paper-3
        dome map --step 0 => degrees from 0.001 to 90
        dome map --mapping round => exact
        dome nearfield --distance 0.6 => is 0.6 radii
        dome nearfield --distance 1,nan => is NaN radii
        dome nearfield --distance -1 => above 0.61326
        dome nearfield --world-offset 1e7 => 0 to 1e6
        dome curve --points 1 => from 2 to 10000");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}
