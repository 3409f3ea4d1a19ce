//! `shisen dome` against the reference's tables, and its bad input.

use serde_json::Value;
use shisen_tests::command::{folder, shisen};
use std::fs;
use std::path::Path;

/// What `shisen dome` prints with `--json`.
fn dome(folder: &Path, arguments: &[&str]) -> Value {
    let mut command = shisen(folder);
    let command = command.arg("dome").args(arguments).arg("--json");
    let output = command.assert().success().get_output().clone();
    assert!(output.stderr.is_empty(), "{output:?}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn design(arguments: &[&str]) -> Value {
    dome(folder().path(), &[&["design"], arguments].concat())
}

fn keys(value: &Value) -> Vec<&str> {
    let object = value.as_object().unwrap();
    object.keys().map(String::as_str).collect()
}

/// Asserts that a number has the digits of a table, to half a unit of the last
/// place and a thousandth for its own rounding.
fn rounds_to(found: &Value, digits: &str) {
    has_digits(found, digits, 0.501);
}

/// The same to so many units of the last place.
fn has_digits(found: &Value, digits: &str, units: f64) {
    let exact: f64 = digits.parse().unwrap();
    let places = digits.split_once('.').map_or(0, |(_, places)| places.len());
    let unit = 10f64.powi(-(places as i32));
    let off = (found.as_f64().unwrap() - exact).abs();
    assert!(off <= units * unit, "{found}: {digits}");
}

#[test]
fn designs_have_the_digits_of_the_optima() {
    let parallel = design(&["--projection", "parallel", "--a", "1.288"]);
    assert_eq!(
        keys(&parallel),
        [
            "a",
            "b1",
            "beta1",
            "c1",
            "config",
            "d1",
            "error_percent",
            "error_px_4096",
            "extrema",
            "mapping",
            "p",
            "projection",
            "width"
        ]
    );
    assert!(parallel["p"].is_null() && parallel["d1"].is_null());
    assert!(parallel["config"].is_null() && parallel["projection"] == "parallel");
    let degrees = parallel["beta1"].as_f64().unwrap().to_degrees();
    rounds_to(&degrees.into(), "37.8256757635");
    for (key, digits) in [
        ("a", "1.288"),
        ("c1", "1.01736579173"),
        ("b1", "0.613261081588"),
        ("width", "1.22652216318"),
        ("error_percent", "0.125440321211"),
        ("error_px_4096", "2.56902"),
    ] {
        rounds_to(&parallel[key], digits);
    }
    rounds_to(&parallel["extrema"][0], "29.6088");
    rounds_to(&parallel["extrema"][1], "77.0197");
    // a, β₁ in degrees, c₁, b₁, d₁, p, field of view, error in % and px,
    // extrema.
    let table = "\
        1    21.6375486636 0.929535036626 0.368733800573 0.347174696379 1.27670973300 \
             93.4498053457 1.048534935461 21.4740 29.2151 77.6608
        2.35 18.0242195052 2.23467564580  0.309418987958 1.13943050469  3.37410615049 \
             30.3852554105 0.108741896825 2.22703 30.2192 77.4909";
    for row in table.lines() {
        let digits: Vec<&str> = row.split_whitespace().collect();
        let found = design(&["--projection", "perspective", "--a", digits[0]]);
        assert_eq!(found["projection"], "perspective");
        assert_eq!(
            keys(&found),
            [
                "a",
                "b1",
                "beta1",
                "c1",
                "config",
                "d1",
                "error_percent",
                "error_px_4096",
                "extrema",
                "fov",
                "mapping",
                "p",
                "projection"
            ]
        );
        let degrees = found["beta1"].as_f64().unwrap().to_degrees();
        rounds_to(&degrees.into(), digits[1]);
        for (key, digits) in [
            "c1",
            "b1",
            "d1",
            "p",
            "fov",
            "error_percent",
            "error_px_4096",
        ]
        .into_iter()
        .zip(&digits[2..])
        {
            rounds_to(&found[key], digits);
        }
        rounds_to(&found["extrema"][0], digits[9]);
        rounds_to(&found["extrema"][1], digits[10]);
    }
}

#[test]
fn designs_by_axis_ratio_have_the_digits_of_their_tables() {
    // a, error in %, β₁, c₁, p, extrema in degrees.
    let table = "\
        0.5  1.83419173934  0.612109638831 0.409218825675 0.869316069640 29.173 78.263
        0.8  1.23314386232  0.446935778437 0.721420562949 1.10998065289  29.193 77.795
        1.2  0.934330849829 0.326351847566 1.13666184460  1.44851437131  29.236 77.583
        1.25 0.466524952257 0.674740942224 0.976086011804 inf            65.498
        1.35 0.123931444647 0.619446967098 1.09916954606  16.3480025965  29.807 77.156
        1.5  0.121287430070 0.539282252037 1.28711622070  6.03535744088  29.911 77.245
        1.8  0.114834882866 0.429557609201 1.63647014495  3.78198680932  30.060 77.366
        2.5  0.107945632983 0.293436550073 2.39313882485  3.41087229024  30.246 77.512
        3.0  0.106503289038 0.240103867321 2.91393984023  3.67245183712  30.309 77.560";
    for row in table.lines() {
        let digits: Vec<&str> = row.split_whitespace().collect();
        let found = design(&["--projection", "perspective", "--a", digits[0]]);
        for (key, digits) in ["error_percent", "beta1", "c1"]
            .into_iter()
            .zip(&digits[1..])
        {
            rounds_to(&found[key], digits);
        }
        if digits[4] == "inf" {
            assert!(found["p"].is_null() && found["d1"].is_null());
            assert!(found["projection"] == "parallel" && found["width"].is_number());
        } else {
            rounds_to(&found["p"], digits[4]);
        }
        let extrema = found["extrema"].as_array().unwrap();
        assert_eq!(extrema.len(), digits.len() - 5);
        for (found, digits) in extrema.iter().zip(&digits[5..]) {
            rounds_to(found, digits);
        }
    }
    for (a, error) in [
        ("0.5", "21.41809"),
        ("0.9", "6.33625"),
        ("1.1", "2.48303"),
        ("1.2", "1.05963"),
        ("1.25", "0.466525"),
        ("1.28", "0.183617"),
        ("1.287", "0.132204"),
        ("1.29", "0.139002"),
        ("1.35", "0.72018"),
        ("1.5", "2.03881"),
        ("2.1", "5.16001"),
    ] {
        let found = design(&["--projection", "parallel", "--a", a]);
        rounds_to(&found["error_percent"], error);
    }
}

#[test]
fn designs_are_the_ones_that_are_asked_for() {
    // The optima beyond the paper's.
    let parallel = design(&["--projection", "parallel"]);
    rounds_to(&parallel["a"], "1.288248331186");
    rounds_to(&parallel["error_percent"], "0.123784174756");
    let perspective = design(&["--projection", "perspective"]);
    rounds_to(&perspective["a"], "4.50414971");
    rounds_to(&perspective["p"], "4.8927036");
    rounds_to(&perspective["error_percent"], "0.105759211320");
    for (name, like) in [
        ("best-parallel", &parallel),
        ("best", &perspective),
        (
            "paper-2",
            &design(&["--projection", "perspective", "--a", "1"]),
        ),
    ] {
        let named = design(&["--config", name]);
        assert_eq!(named["config"], name);
        for key in ["a", "c1", "b1", "beta1", "error_percent"] {
            let off = named[key].as_f64().unwrap() / like[key].as_f64().unwrap() - 1.0;
            assert!(off.abs() < 1.0e-8, "{name} {key}: {off}");
        }
    }
    // A viewpoint, and the edge that it sees.
    let with = ["--projection", "perspective", "--a", "2.35"];
    let viewpoint = design(&[&with[..], &["--p", "3.374"]].concat());
    rounds_to(&viewpoint["p"], "3.37400000000000");
    rounds_to(&viewpoint["error_percent"], "0.10891");
    let beta1 = viewpoint["beta1"].to_string();
    let edge = design(&[&with[..], &["--beta1", &beta1]].concat());
    rounds_to(&edge["p"], "3.37400000000");
    // The exact limit: parallel projection, and finite.
    let limit = (1.0f64 / 2.35).atan().to_string();
    let limit = design(&[&with[..], &["--beta1", &limit]].concat());
    assert!(limit["p"].is_null());
    assert_eq!(limit["projection"], "parallel");
    assert!(limit["error_percent"].is_number());
}

#[test]
fn other_mappings_have_no_error() {
    for mapping in ["exact", "true"] {
        let found = design(&["--config", "paper-2", "--mapping", mapping]);
        assert_eq!(found["mapping"], mapping);
        assert_eq!(found["error_percent"], 0.0);
        assert_eq!(found["error_px_4096"], 0.0);
        assert_eq!(found["extrema"].as_array().unwrap().len(), 0);
        let mirror = design(&["--config", "paper-2"]);
        assert_eq!((&found["a"], &found["p"]), (&mirror["a"], &mirror["p"]));
    }
    let folder = folder();
    let curves = ["curve", "--points", "9", "--mapping", "exact"];
    let figures = dome(folder.path(), &curves);
    for (number, zero) in [(0, true), (2, false), (5, true)] {
        let line = figures["figures"][number]["lines"].as_array().unwrap();
        let y = line.last().unwrap()["y"].as_array().unwrap();
        assert_eq!(y.len(), 9);
        assert_eq!(y.iter().all(|y| y.as_f64() == Some(0.0)), zero, "{number}");
    }
    let same = dome(
        folder.path(),
        &["compare", "--mapping", "true", "--size", "64"],
    );
    assert!(same["config"].is_null());
    assert_eq!(same["differing"], 0);
    assert_eq!(same["true_lines"], same["simulated_lines"]);
}

#[test]
fn maps_have_the_digits_of_their_table() {
    // Degrees; (1) to (3), r_d to θ and θ to r_d.
    let table = "\
        10 10.0546147 9.94565578 10.4802735 9.53985706 10.0478572 9.95235156
        30 30.1094626 29.8905251 30.9428089 29.0563541 30.0978608 29.9021466
        50 50.0413445 49.9583935 50.3599418 49.6203930 50.0418729 49.9578999
        70 69.9062785 70.0941825 69.2418652 70.7908020 69.9217200 70.0786438
        90 90 90 90 90 90 90";
    let folder = folder();
    for (number, config) in ["paper-1", "paper-2", "paper-3"].into_iter().enumerate() {
        let double = dome(folder.path(), &["map", "--config", config]);
        let single = dome(folder.path(), &["map", "--config", config, "--f32"]);
        assert_eq!(
            keys(&double),
            [
                "config",
                "f32",
                "mapping",
                "r_d_to_theta",
                "step_deg",
                "theta_to_r_d"
            ]
        );
        for row in table.lines() {
            let digits: Vec<&str> = row.split_whitespace().collect();
            let degrees: f64 = digits[0].parse().unwrap();
            for (key, from, to, column) in [
                ("r_d_to_theta", "r_d_deg", "theta_deg", 1),
                ("theta_to_r_d", "theta_deg", "r_d_deg", 2),
            ] {
                let digits = digits[2 * number + column];
                let row = |table: &Value| {
                    let row = table[key].as_array().unwrap()[degrees as usize / 10].clone();
                    assert_eq!(row[from], degrees);
                    row
                };
                // Nine digits, cut off and not rounded.
                has_digits(&row(&double)[to], digits, 1.0);
                let (double, single) = (row(&double), row(&single));
                let [double, single] = [double, single].map(|row| row[to].as_f64().unwrap());
                assert!((double - single).abs() < 3.0e-5, "{double} {single}");
            }
        }
    }
}

#[test]
fn maps_of_true_dome_masters_change_nothing() {
    let folder = folder();
    for mapping in ["exact", "true"] {
        for precision in [&[][..], &["--f32"]] {
            let arguments = [
                "map",
                "--config",
                "best",
                "--mapping",
                mapping,
                "--step",
                "7.5",
            ];
            let map = dome(folder.path(), &[&arguments, precision].concat());
            assert_eq!(map["mapping"], mapping);
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
}

#[test]
fn near_fields_have_the_digits_of_their_tables() {
    let folder = folder();
    for (config, largest) in [
        ("paper-1", ["92.850", "31.656", "10.655", "3.217", "2.569"]),
        (
            "paper-2",
            ["99.190", "45.461", "28.309", "22.139", "21.474"],
        ),
        ("paper-3", ["48.743", "17.066", "6.355", "2.605", "2.227"]),
    ] {
        let arguments = ["nearfield", "--config", config, "--distance", "1,3,10,100"];
        let found = dome(folder.path(), &arguments);
        let distances = found["distances"].as_array().unwrap();
        for (i, digits) in largest.into_iter().enumerate() {
            has_digits(&distances[i]["max_px"], digits, 0.6);
            assert_eq!(distances[i]["offset"], 0.0);
        }
        assert_eq!(distances[0]["distance"], 1.0);
        assert!(distances[4]["distance"].is_null());
        if config == "paper-1" {
            let rings = "24.84 48.14 68.29 83.54 91.92 91.10 78.21 49.55";
            let found = distances[0]["rings"].as_array().unwrap();
            assert_eq!(found.len(), 8);
            for (i, digits) in rings.split(' ').enumerate() {
                rounds_to(&found[i]["px"], digits);
                assert_eq!(found[i]["ring_deg"], 10.0 * (i + 1) as f64);
            }
        }
    }
}

#[test]
fn the_best_viewpoint_gains_at_every_distance() {
    let folder = folder();
    for config in ["paper-1", "best"] {
        for mapping in ["mirror", "exact"] {
            let arguments = ["nearfield", "--config", config, "--mapping", mapping];
            let screen = dome(folder.path(), &arguments);
            let best = dome(
                folder.path(),
                &[&arguments[..], &["--viewpoint", "best"]].concat(),
            );
            assert_eq!(screen["viewpoints"], best["viewpoints"]);
            for (i, row) in best["viewpoints"].as_array().unwrap().iter().enumerate() {
                let number = |key: &str| row[key].as_f64().unwrap();
                assert!(
                    number("offset") < 0.0 && number("gain") > 1.0,
                    "{config} {row}"
                );
                assert_eq!(number("distance"), [1.0, 2.0, 3.0, 10.0, 100.0][i]);
                // What the rows of distances say is the same.
                let far = best["distances"][5]["max_px"].as_f64().unwrap();
                for (report, key) in [(&screen, "screen_max_px"), (&best, "max_px")] {
                    let near = report["distances"][i]["max_px"].as_f64().unwrap();
                    assert_eq!(near.max(far), number(key), "{config} {row}");
                }
                assert_eq!(best["distances"][i]["offset"], row["offset"]);
            }
        }
    }
}

#[test]
fn a_mirror_of_a_millionth_loses_nothing() {
    let folder = folder();
    for config in ["paper-1", "paper-2", "paper-3", "best-parallel", "best"] {
        let arguments = ["nearfield", "--config", config, "--mapping", "exact"];
        let found = dome(folder.path(), &arguments);
        let sizes = found["sizes"].as_array().unwrap();
        assert_eq!(sizes.len(), 30);
        let number = |row: &Value, key: &str| row[key].as_f64().unwrap();
        let at = |offset: f64, size: f64| {
            let is = |row: &&Value| {
                row["offset"] == offset && (number(row, "size") / size - 1.0).abs() < 1.0e-9
            };
            sizes.iter().find(is).unwrap()
        };
        for offset in [1.0, 1000.0] {
            // Half a unit of the eye's place, seen from the nearest surface.
            let place = f64::from((offset as f32).next_up()) - offset;
            let bound = 1.0e-3 + 2.0 * place * 2048.0 / std::f64::consts::FRAC_PI_2;
            for i in 0..=14 {
                let row = at(offset, 10f64.powf(f64::from(i) / 2.0 - 7.0));
                assert!(number(row, "rounding_px") <= bound, "{config} {row}");
            }
            let tiny = at(offset, 1.0e-6);
            assert!(number(tiny, "near_field_px") <= 1.0e-3, "{config} {tiny}");
            assert!(number(tiny, "rounding_px") <= number(at(offset, 0.1), "rounding_px") * 1.5);
            // As an object of the world such a mirror has no shape left.
            let lost = tiny["world_px"].as_f64().is_none_or(|px| px > 10.0);
            assert!(lost, "{config} {tiny}");
        }
    }
}

#[test]
fn figures_are_files_and_numbers() {
    let folder = folder();
    let curve = dome(
        folder.path(),
        &["curve", "--points", "9", "--out", "curves"],
    );
    let figures = curve["figures"].as_array().unwrap();
    let names: Vec<&str> = figures
        .iter()
        .map(|f| f["name"].as_str().unwrap())
        .collect();
    let expected = [10, 11, 12, 13, 14, 15, 16].map(|n| format!("figure-{n}"));
    assert_eq!(names, expected);
    let near = dome(folder.path(), &["nearfield"]);
    assert_eq!(
        keys(&near),
        [
            "config",
            "distances",
            "figures",
            "mapping",
            "reach",
            "sizes",
            "viewpoint",
            "viewpoints"
        ]
    );
    for figure in figures.iter().chain(near["figures"].as_array().unwrap()) {
        assert_eq!(
            keys(figure),
            ["csv", "lines", "name", "svg", "title", "x", "y"]
        );
        let read = |key: &str| {
            fs::read_to_string(folder.path().join(figure[key].as_str().unwrap())).unwrap()
        };
        let picture = read("svg");
        assert!(picture.starts_with("<svg"));
        let title = figure["title"].as_str().unwrap().replace('\'', "&apos;");
        assert!(picture.contains(&title), "{title}");
        let numbers = read("csv");
        let mut rows = numbers.lines();
        let head = format!("line,{},{}", figure["x"], figure["y"]).replace('"', "");
        assert_eq!(rows.next(), Some(head.as_str()));
        let mut count = 0;
        for line in figure["lines"].as_array().unwrap() {
            let (x, y) = (line["x"].as_array().unwrap(), line["y"].as_array().unwrap());
            assert_eq!(x.len(), y.len());
            count += x.len();
        }
        assert_eq!(rows.count(), count);
    }
    // A mirror is marked where its projection is drawn.
    let arguments = ["curve", "--points", "2", "--config"];
    for (config, marked) in [("best", &[0, 1, 2, 3][..]), ("paper-1", &[5, 6])] {
        let curve = dome(folder.path(), &[&arguments[..], &[config]].concat());
        for number in 0..7 {
            let lines = curve["figures"][number]["lines"].as_array().unwrap();
            let last = lines.last().unwrap();
            assert_eq!(last["name"] == config, marked.contains(&number), "{last}");
        }
    }
    // The ends of figure 10, as designs.
    let best = &figures[0]["lines"][1];
    assert_eq!(best["x"][0], 0.5);
    rounds_to(&best["y"][0], "1.83419173934");
    let parallel = &figures[5]["lines"][0];
    rounds_to(&parallel["y"][8], "5.16001");
}

/// Runs `shisen dome` on what must be refused as usage, with a message that
/// has `expected` in it and no file.
fn refused(command: &[&str], more: &[&str], expected: &str) {
    let folder = folder();
    let mut shisen = shisen(folder.path());
    let assert = shisen.arg("dome").args(command).args(more).assert().code(2);
    let output = assert.get_output();
    let message = String::from_utf8(output.stderr.clone()).unwrap();
    assert!(
        message.contains(expected),
        "{expected:?} is not in: {message}"
    );
    assert!(output.stdout.is_empty());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn what_is_no_mirror_is_usage() {
    let perspective = ["design", "--projection", "perspective"];
    for (more, expected) in [
        (
            &["--a", "0"][..],
            "ratio is 0: give a number from 0.01 to 100",
        ),
        (&["--a", "-1"], "ratio is -1: give"),
        (&["--a", "2", "--p", "1.5"], "viewpoint is 1.5 radii"),
        (&["--a", "2", "--p", "2"], "finite number above 2,"),
        (&["--a", "2", "--p", "nan"], "viewpoint is NaN"),
        (&["--a", "2", "--p", "inf"], "viewpoint is inf"),
        (
            &["--a", "1", "--beta1", "0.79"],
            "of 0.79 rad: give a number from 0.001 to 0.785398163",
        ),
        (&["--a", "1", "--beta1", "nan"], "of NaN rad"),
        (&["--a", "1", "--beta1", "0"], "of 0 rad"),
        (&["--p", "3"], "--a <RATIO>"),
        (&["--a", "1", "--p", "3", "--beta1", "0.2"], "--beta1"),
        (&["--config", "best"], "--config"),
    ] {
        refused(&perspective, more, expected);
    }
    let parallel = ["design", "--projection", "parallel"];
    for (more, expected) in [
        (&["--a", "nan"][..], "ratio is NaN: give"),
        (&["--a", "inf"], "ratio is inf: give"),
        (&["--a", "101"], "0.01 to 100"),
        (&["--a", "1", "--p", "3"], "--p is 3"),
        (&["--a", "1", "--beta1", "0.2"], "--beta1 is 0.2"),
    ] {
        refused(&parallel, more, expected);
    }
}

#[test]
fn what_there_is_not_is_usage() {
    for (command, more, expected) in [
        ("design", &[][..], "--projection"),
        ("design", &["--config", "paper-4"], "paper-3"),
        ("map", &["--step", "0"], "degrees from 0.001 to 90"),
        ("map", &["--mapping", "round"], "exact"),
        ("nearfield", &["--distance", "0.6"], "is 0.6 radii"),
        ("nearfield", &["--distance", "1,nan"], "is NaN radii"),
        ("nearfield", &["--distance", "-1"], "above 0.61326"),
        ("nearfield", &["--world-offset", "1e7"], "0 to 1e6"),
        ("curve", &["--points", "1"], "from 2 to 10000"),
    ] {
        refused(&[command], more, expected);
    }
}

#[test]
fn a_folder_that_is_a_file_is_refused() {
    let folder = folder();
    fs::write(folder.path().join("taken"), "").unwrap();
    for command in ["curve", "nearfield"] {
        let mut shisen = shisen(folder.path());
        let assert = shisen
            .args(["dome", command, "--out", "taken"])
            .assert()
            .code(1);
        let message = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
        assert!(message.contains("--out"), "{message}");
    }
}
