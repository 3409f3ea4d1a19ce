//! Levels of detail at the command line: `shisen gaze`, and `shisen cave` with
//! `--lod`.

use assert_cmd::Command;
use serde_json::Value;
use shisen_tests::command::{folder, shisen};
use shisen_tests::meshes::write_ball;
use shisen_tests::rays::Random;
use std::collections::HashSet;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_6, PI};
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::Stdio;
use std::sync::mpsc;
use std::time::Duration;

fn keys(value: &Value) -> Vec<&str> {
    let object = value.as_object().unwrap();
    object.keys().map(String::as_str).collect()
}

/// Runs `shisen gaze` on some directions; returns its lines.
fn gaze(arguments: &[&str], directions: &str) -> Vec<String> {
    let folder = folder();
    let mut command = shisen(folder.path());
    let output = command
        .arg("gaze")
        .args(arguments)
        .write_stdin(directions)
        .assert()
        .success()
        .get_output()
        .clone();
    assert!(output.stderr.is_empty());
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(str::to_owned).collect()
}

/// The same with `--json`.
fn sights(arguments: &[&str], directions: &str) -> Vec<Value> {
    let lines = gaze(&[arguments, &["--json"]].concat(), directions);
    let parsed = lines.iter().map(|line| serde_json::from_str(line));
    parsed.map(Result::unwrap).collect()
}

/// One direction's.
fn sight(arguments: &[&str], direction: &str) -> Value {
    let mut found = sights(arguments, direction);
    assert_eq!(found.len(), 1);
    found.remove(0)
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap()
}

const SIDE: f64 = 5.0 * PI / 9.0;

#[test]
fn directions_have_the_levels_of_the_equations() {
    let below = 7.0 * PI / 18.0;
    for (precision, tolerance) in [(&[][..], 1.0e-6), (&["--f64"], 1.0e-14)] {
        for (direction, [m_alpha, m_beta, big_l, level], zone, bounces, faces) in [
            ("0 0 -1", [0.0, 0.0, SIDE, 1.0], "central", 3, 5804),
            (
                "1 0 -1",
                [FRAC_PI_4, 0.0, SIDE, 55.0 / 70.0],
                "peripheral",
                2,
                4668,
            ),
            (
                "-3,0,-3",
                [FRAC_PI_4, 0.0, SIDE, 55.0 / 70.0],
                "peripheral",
                2,
                4668,
            ),
            (
                "0 0.1 -0.1",
                [0.0, FRAC_PI_4, 2.0 * FRAC_PI_6, 0.5],
                "peripheral",
                1,
                3152,
            ),
            // Half a pair above the fewest: the tie is not worth a test.
            (
                "0 -1e20 -1e20",
                [0.0, -FRAC_PI_4, below, 0.625],
                "peripheral",
                1,
                0,
            ),
            // To the right of the viewer the elevation is 0 by definition.
            (
                "1 0 0",
                [FRAC_PI_2, 0.0, SIDE, 1.0 / 7.0],
                "peripheral",
                0,
                1258,
            ),
            ("0 0 1", [PI, 0.0, SIDE, 0.0], "outside", 0, 500),
            (
                "0 1 0",
                [0.0, FRAC_PI_2, 2.0 * FRAC_PI_6, 0.0],
                "outside",
                0,
                500,
            ),
        ] {
            let found = sight(precision, direction);
            let l = m_alpha.hypot(m_beta);
            for (key, expected) in [
                ("m_alpha", m_alpha),
                ("m_beta", m_beta),
                ("l", l),
                ("big_l", big_l),
                ("level", level),
            ] {
                let off = (number(&found, key) - expected).abs();
                assert!(off <= tolerance, "{direction}: {key} of {found}");
            }
            assert_eq!(found["zone"], zone, "{direction}");
            assert_eq!(found["bounces"], bounces, "{direction}");
            if faces > 0 {
                assert_eq!(found["faces"], faces, "{direction}");
            }
            assert_eq!(
                keys(&found),
                [
                    "big_l", "bounces", "faces", "l", "level", "m_alpha", "m_beta", "zone"
                ]
            );
        }
    }
}

#[test]
fn what_is_asked_for_changes_levels() {
    let near = |arguments: &[&str], direction: &str, level: f64| {
        for precision in [&[][..], &["--f64"]] {
            let found = sight(&[arguments, precision].concat(), direction);
            let off = (number(&found, "level") - level).abs();
            assert!(off < 1.0e-6, "{arguments:?}: {found}");
        }
    };
    for look in ["1,0,0", "0.001,0,0", "right", "90,0"] {
        near(&["--look", look], "1 0 0", 1.0);
        near(&["--look", look], "1 0 1", 55.0 / 70.0);
    }
    // Looking down, up is to the front; looking up, to the back.
    for (look, ahead, above) in [
        ("floor", "0 -1 0", "0 -1 -1"),
        ("0,-3,0", "0 -1 0", "0 -1 -1"),
        ("0,90", "0 1 0", "0 1 1"),
    ] {
        near(&["--look", look], ahead, 1.0);
        near(&["--look", look], above, 0.5);
    }
    // The head lies on its side: what was above is now to the left.
    near(&["--up", "1,0,0"], "0 1 -1", 55.0 / 70.0);
    near(&["--up", "2,0,-2"], "0 1 -1", 55.0 / 70.0);
    near(&["--central", "40"], "1 0 -1", 55.0 / 60.0);
    near(&["--central", "45.01"], "1 0 -1", 1.0);
    near(&["--field-right", "45"], "1 0 -1", 0.0);
    near(&["--field-right", "60"], "1 0 -1", 0.5);
    near(&["--field-left", "60"], "1 0 -1", 55.0 / 70.0);
    near(&["--field-left", "60"], "-1 0 -1", 0.5);
    near(&["--field-up", "80"], "0 1 -1", 35.0 / 50.0);
    near(&["--field-down", "80"], "0 1 -1", 0.5);
    near(&["--field-down", "80"], "0 -1 -1", 35.0 / 50.0);
    let found = sight(&["--reflect-max", "7", "--faces", "10..30"], "1 0 -1");
    assert_eq!(
        (&found["bounces"], &found["faces"]),
        (&5.into(), &26.into())
    );

    // The ellipse lies within the printed curve, and touches it on the axes.
    for precision in [&[][..], &["--f64"]] {
        let of = |boundary: &str, direction: &str| {
            let arguments = [&["--boundary", boundary], precision].concat();
            number(&sight(&arguments, direction), "big_l")
        };
        assert!(of("printed", "1 1 -1") > of("ellipse", "1 1 -1") + 0.1);
        let apart = of("printed", "1 0 -1") - of("ellipse", "1 0 -1");
        assert!(apart.abs() < 1.0e-6);
    }
}

#[test]
fn both_precisions_agree() {
    let mut random = Random::new(0x9A2E);
    let directions: Vec<String> = (0..500)
        .map(|_| {
            let [x, y, z] = random.direction().map(|component| component as f32);
            format!("{x} {y} {z}")
        })
        .collect();
    let input = directions.join("\n");
    let looks = ["--look", "0.3,-0.4,-0.7", "--up", "0.1,1,0.2"];
    let single = sights(&looks, &input);
    let double = sights(&[&looks[..], &["--f64"]].concat(), &input);
    assert_eq!((single.len(), double.len()), (500, 500));
    let mut levels = HashSet::new();
    for ((direction, single), double) in directions.iter().zip(&single).zip(&double) {
        for key in ["m_alpha", "l", "level"] {
            let off = (number(single, key) - number(double, key)).abs();
            assert!(off < 1.0e-5, "{direction}: {key} of {single}, {double}");
        }
        levels.insert(number(single, "level").to_bits());
    }
    assert!(levels.len() > 100);
    // It is another computation, not the same one printed with more digits.
    assert!(single.iter().zip(&double).any(|(a, b)| a["l"] != b["l"]));
}

#[test]
fn people_get_a_table() {
    let input = "# nothing\n\n  0 0 -1\r\n1, 0 ,-1 # to the right\n\t0\t0 1";
    let lines = gaze(&[], input);
    assert_eq!(lines.len(), 4, "{lines:?}");
    let words = |line: &str| -> Vec<String> {
        let words = line.split_whitespace();
        words.map(str::to_owned).collect()
    };
    assert_eq!(
        words(&lines[0]),
        [
            "m_alpha", "m_beta", "l", "L", "level", "zone", "bounces", "faces"
        ]
    );
    assert_eq!(
        words(&lines[2]),
        [
            "45.000°",
            "0.000°",
            "45.000°",
            "100.000°",
            "0.785714",
            "peripheral",
            "2",
            "4668"
        ]
    );
    assert_eq!(lines.iter().map(|line| line.chars().count()).max(), {
        Some(lines[0].chars().count())
    });
    // No directions are no fault.
    assert_eq!(gaze(&["--json"], ""), [""; 0]);
}

#[test]
fn whoever_sends_one_direction_waits_for_one_answer() {
    let folder = folder();
    let program = shisen(folder.path()).get_program().to_owned();
    let mut child = std::process::Command::new(program)
        .args(["gaze", "--json"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let output = BufReader::new(child.stdout.take().unwrap());
    let (send, answers) = mpsc::channel();
    let reader = std::thread::spawn(move || {
        for line in output.lines() {
            send.send(line.unwrap()).unwrap();
        }
    });
    for direction in ["0 0 -1", "0 1 -1", "0 0 1"] {
        writeln!(input, "{direction}").unwrap();
        let answer = answers.recv_timeout(Duration::from_mins(1));
        assert!(answer.expect("an answer").contains("zone"));
    }
    drop(input);
    assert!(child.wait().unwrap().success());
    reader.join().unwrap();
}

#[test]
fn lines_that_are_no_direction_are_named() {
    let folder = folder();
    let long = "1 ".repeat(4000);
    for (line, expected) in [
        (&b"1 2"[..], "2 numbers"),
        (b"1 2 3 4", "4 numbers"),
        (b"1 two 3", "two"),
        (b"1,,3", "comma"),
        (b"0 0 0", "nowhere"),
        (b"0 -0.0 0", "nowhere"),
        (b"nan 0 1", "nan"),
        (b"1 inf 1", "inf"),
        (b"1 1e999 1", "1e999"),
        (b"\xff\xfe 0 1", "no number"),
        (b"1 \0 1", "no number"),
        (long.as_bytes(), "longer than 4096"),
    ] {
        let mut input = b"0 0 -1\n\n# a line\n1 0 -1\n".to_vec();
        input.extend_from_slice(line);
        input.extend_from_slice(b"\n0 0 -1\n");
        for precision in [&["--json"][..], &["--json", "--f64"]] {
            let output = shisen(folder.path())
                .arg("gaze")
                .args(precision)
                .write_stdin(input.clone())
                .assert()
                .code(1)
                .get_output()
                .clone();
            let message = String::from_utf8(output.stderr).unwrap();
            for expected in ["line 5", expected, "three finite numbers"] {
                assert!(message.contains(expected), "{expected}: {message}");
            }
            assert!(!message.contains("panicked") && !message.contains('\0'));
            // What was right before it is not lost.
            let text = String::from_utf8(output.stdout).unwrap();
            assert_eq!(text.lines().count(), 2, "{text}");
        }
    }
}

/// Runs a command that is no usage: exit code 2, and nothing but a message
/// that has `expected` in it.
fn is_no_usage(command: &mut Command, expected: &str) {
    let output = command.assert().code(2).get_output().clone();
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains(expected), "{expected:?}: {message}");
    assert!(!message.contains("panicked") && output.stdout.is_empty());
}

#[test]
fn gazes_that_are_none_are_usage() {
    let folder = folder();
    for (arguments, expected) in [
        (&["--look", "0,0,0"][..], "points nowhere"),
        (&["--look", "nan,0,0"], "nan"),
        (&["--look", "inf,0,0"], "inf"),
        (&["--look", "0,90", "--up", "0,1,0"], "parallel"),
        (&["--look", "aside"], "no direction"),
        (&["--look", "0,3,0", "--up", "0,-2,0"], "parallel"),
        (&["--look", "0,-1e-30,0", "--up", "0,1,0"], "parallel"),
        (&["--look", "1,2,3", "--up", "-2,-4,-6"], "parallel"),
        (&["--up", "0,0,0"], "points nowhere"),
        (&["--up", "0,nan,0"], "nan"),
        (&["--faces", "0..5"], "at least 1"),
        (&["--faces", "9..3"], "exchange"),
        (&["--faces", "5"], "500..5804"),
        (&["--central", "0"], "degrees"),
        (&["--central", "nan"], "degrees"),
        (&["--central", "-30"], "degrees"),
        (&["--field-up", "20"], "--field-up 20.0000 is within"),
        (&["--field-down", "91"], "at most 90 degrees"),
        (&["--central", "0.00001"], "0.0001 degrees or more"),
        (&["--field-up", "95"], "up"),
        (&["--field-left", "181"], "degrees"),
        (&["--boundary", "wavy"], "ellipse"),
        (&["--reflect-max", "256"], "--reflect-max"),
    ] {
        // Whatever comes in.
        for input in ["0 0 -1\n", "no direction\n"] {
            let mut command = shisen(folder.path());
            let command = command.arg("gaze").args(arguments).write_stdin(input);
            is_no_usage(command, expected);
        }
    }
}

/// The report of a small frame of a mesh of few faces.
fn cave(folder: &Path, arguments: &[&str]) -> Value {
    write_ball(folder);
    quadruped_cave(folder, &[&["--mesh", "ball.obj"], arguments].concat())
}

/// The report of a small frame of the command's own mesh.
fn quadruped_cave(folder: &Path, arguments: &[&str]) -> Value {
    let output = shisen(folder)
        .args(["cave", "--size", "48", "--view-size", "32x24", "--json"])
        .args(arguments)
        .assert()
        .success()
        .get_output()
        .clone();
    serde_json::from_slice(&output.stdout).unwrap()
}

const EXTRA_PICTURES: [&str; 3] = ["levels", "polygons", "difference"];

#[test]
fn a_frame_with_levels_of_detail_is_reported() {
    let folder = folder();
    let plain = quadruped_cave(folder.path(), &["--lod", "off"]);
    assert_eq!(plain["lod"], Value::Null);
    let default = quadruped_cave(folder.path(), &[]);
    assert_eq!(plain["frame_hash"], default["frame_hash"]);
    let paper = quadruped_cave(folder.path(), &["--lod", "paper"]);
    let ellipse = quadruped_cave(folder.path(), &["--lod", "paper-ellipse"]);
    let mut hashes = vec![];
    for (name, found) in [("paper", &paper), ("paper-ellipse", &ellipse)] {
        let lod = &found["lod"];
        assert_eq!(lod["mode"], name);
        assert_eq!(
            keys(lod),
            [
                "faces",
                "field",
                "fill",
                "full_rays",
                "full_seconds",
                "full_steps",
                "mode"
            ]
        );
        // The same frame in full, with covers of all levels.
        assert_eq!(lod["full_rays"], plain["rays"]);
        let steps = number(lod, "full_steps") / number(&plain, "steps");
        assert!((1.0..1.001).contains(&steps), "{steps}");
        assert!(number(lod, "full_seconds") > 0.0);
        assert!(number(found, "steps") < number(lod, "full_steps"));
        let faces: Vec<u64> = serde_json::from_value(lod["faces"][0].clone()).unwrap();
        assert_eq!(lod["faces"].as_array().unwrap().len(), 1);
        assert_eq!((faces.len(), faces[0], faces[18]), (19, 5804, 500));
        assert!(faces.is_sorted_by(|a, b| a > b));

        let field = lod["field"].as_array().unwrap();
        let images = found["images"].as_array().unwrap();
        assert_eq!((field.len(), images.len()), (6, 6));
        let mut traced = 0.0;
        for (field, image) in field.iter().zip(images) {
            assert_eq!((&field["wall"], &field["eye"]), {
                (&image["wall"], &image["eye"])
            });
            let [central, peripheral, outside, level, bounces] = [
                "central",
                "peripheral",
                "outside",
                "mean_level",
                "mean_bounces",
            ]
            .map(|key| number(field, key));
            assert!((central + peripheral + outside - 1.0).abs() < 1e-9);
            assert!(central <= level && level <= 1.0 - outside);
            assert!(3.0 * central <= bounces && bounces <= 3.0 * level);
            assert_eq!(central > 0.0, field["wall"] == "front");
            traced += (1.0 - outside) * 48.0 * 48.0;
        }
        assert!((number(&found["rays"], "primary") - traced).abs() < 1e-6);
        hashes.push(&found["frame_hash"]);
    }
    // The printed curve lies outside the ellipse.
    let primary = |report: &Value| number(&report["rays"], "primary");
    assert!(primary(&ellipse) < primary(&paper) && primary(&paper) < primary(&plain));
    hashes.push(&plain["frame_hash"]);
    assert!(hashes[0] != hashes[1] && hashes[1] != hashes[2] && hashes[0] != hashes[2]);
}

#[test]
fn pictures_show_what_levels_of_detail_do() {
    let folder = folder();
    let plain = cave(folder.path(), &["--out", "plain"]);
    let found = cave(folder.path(), &["--lod", "paper", "--out", "lod"]);
    let picture = |report: &Value, key: &str| {
        let path = report[key].as_str().unwrap();
        image::open(folder.path().join(path)).unwrap().into_rgb8()
    };
    let files = |out: &str| fs::read_dir(folder.path().join(out)).unwrap().count();
    assert_eq!((files("plain"), files("lod")), (8, 11));
    let net = picture(&found, "cave");
    for name in EXTRA_PICTURES {
        assert_eq!(plain[name], Value::Null, "{name}");
        assert_eq!(found[name], format!("lod/{name}.png"));
        assert_eq!(picture(&found, name).dimensions(), net.dimensions());
    }
    // Their difference is black where they are equal, and only there.
    let (levels, difference) = (picture(&found, "levels"), picture(&found, "difference"));
    let full = picture(&plain, "cave");
    let (mut same, mut different) = (0, 0);
    for (x, y, seen) in difference.enumerate_pixels() {
        let is_same = net.get_pixel(x, y) == full.get_pixel(x, y);
        if is_same && seen == net.get_pixel(x, y) {
            // Between the walls.
            continue;
        }
        assert_eq!(seen.0 == [0; 3], is_same, "{x} {y}");
        *(if is_same { &mut same } else { &mut different }) += 1;
    }
    assert!(same > 1000 && different > 100, "{same}, {different}");
    // Viridis' yellow where the viewer looks, dark grey outside the field.
    let count = |is: &dyn Fn([u8; 3]) -> bool| levels.pixels().filter(|p| is(p.0)).count();
    let yellow = count(&|[r, g, b]| r > 200 && g > 200 && b < 80);
    let outside = number(&found["lod"]["field"][4], "outside");
    assert!(yellow > 48 * 48 / 8 && outside > 0.5, "{yellow}, {outside}");
    let grey = count(&|[r, g, b]| r == g && g == b && (20..60).contains(&r));
    assert!(grey > 48 * 48 / 2, "{grey}");
    // Nothing but faces changes with the faces.
    let coarse = cave(
        folder.path(),
        &[
            "--lod", "paper", "--faces", "100..300", "--levels", "3", "--out", "coarse",
        ],
    );
    assert!(picture(&coarse, "levels") == levels);
    assert!(picture(&coarse, "polygons") != picture(&found, "polygons"));
}

#[test]
fn faces_and_levels_are_those_asked_for() {
    let folder = folder();
    let mut hashes = HashSet::new();
    for (arguments, expected) in [
        (
            &["--faces", "600..3000", "--levels", "5"][..],
            &[3000, 2400, 1800, 1200, 600][..],
        ),
        (&["--faces", "1000..", "--levels", "2"], &[5804, 1000]),
        (
            &["--faces", "4000..900000", "--levels", "3"],
            &[5804, 4902, 4000],
        ),
        // It has no more than that.
        (&["--faces", "6000.."], &[5804]),
    ] {
        let found = quadruped_cave(folder.path(), &[&["--lod", "paper"], arguments].concat());
        let faces: Vec<i64> = serde_json::from_value(found["lod"]["faces"][0].clone()).unwrap();
        assert_eq!(faces.len(), expected.len(), "{faces:?}");
        for (found, expected) in faces.iter().zip(expected) {
            assert!((found - expected).abs() <= 2, "{faces:?}");
        }
        hashes.insert(found["frame_hash"].to_string());
    }
    assert_eq!(hashes.len(), 4);
}

#[test]
fn the_gaze_decides_the_frame() {
    let folder = folder();
    let mut hashes = HashSet::new();
    let ways: &[&[&str]] = &[
        &[],
        &["--look", "floor"],
        &["--look", "30,-20"],
        &["--up", "1,1,0"],
        &["--fixate", "0,0,-0.5"],
        &["--fixate", "0.2,-0.3,-0.5"],
    ];
    for arguments in ways {
        let found = cave(folder.path(), &[&["--lod", "paper"], *arguments].concat());
        assert!(
            hashes.insert(found["frame_hash"].to_string()),
            "{arguments:?}"
        );
    }
    // Eyes that look at a point so far away have one line of sight.
    let far = cave(folder.path(), &["--lod", "paper", "--fixate", "0,0,-1e9"]);
    assert!(!hashes.insert(far["frame_hash"].to_string()));
}

#[test]
fn a_frame_with_levels_of_detail_is_told_in_words() {
    let folder = folder();
    let output = shisen(folder.path())
        .args(["cave", "--size", "16", "--eyes", "1", "--lod", "paper"])
        .args(["--view-size", "8x8"])
        .assert()
        .success()
        .get_output()
        .clone();
    let text = String::from_utf8(output.stdout).unwrap();
    for expected in [
        "level of detail (paper)",
        "% of the steps of full tracing",
        "levels.png, polygons.png, difference.png",
    ] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
}

#[test]
fn levels_of_detail_that_there_are_not_are_usage() {
    let folder = folder();
    for (arguments, expected) in [
        (&["--faces", "500.."][..], "--lod paper"),
        (&["--lod", "off", "--levels", "4"], "--lod paper"),
        (&["--lod", "paper", "--levels", "1"], "from 2 to 64"),
        (&["--lod", "paper", "--levels", "65"], "from 2 to 64"),
        (&["--lod", "paper", "--faces", "9..3"], "above the most, 3"),
        (&["--lod", "paper", "--faces", "0..3"], "at least 1"),
        (&["--lod", "paper", "--faces", "many"], "500..5804"),
        (&["--lod", "paper", "--up", "0,0,-1"], "parallel"),
        (&["--lod", "paper", "--up", "0,0,0"], "nowhere"),
        (&["--lod", "paper", "--fixate", "0,nan,0"], "no place"),
        (
            &["--lod", "paper", "--eyes", "1", "--fixate", "0,0,0"],
            "points nowhere",
        ),
        (&["--lod", "full"], "paper-ellipse"),
    ] {
        let mut command = shisen(folder.path());
        is_no_usage(command.arg("cave").args(arguments), expected);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

#[test]
fn what_fills_the_rest_is_chosen_and_reported() {
    let folder = folder();
    let filled = |arguments: &[&str]| {
        let mut all = vec!["--lod", "paper"];
        all.extend(arguments);
        cave(folder.path(), &all)
    };
    let background = filled(&[]);
    let fill = &background["lod"]["fill"];
    assert_eq!(
        (&fill["mode"], &fill["capture"]),
        (&"background".into(), &Value::Null)
    );
    assert!(fill["outside_pixels"].as_u64().unwrap() > 1000);
    let captured = filled(&["--fill", "capture", "--fill-size", "64"]);
    let fill = &captured["lod"]["fill"];
    assert_eq!(fill["mode"], "capture");
    assert_eq!(
        keys(&fill["capture"]),
        ["images", "rays", "seconds", "size", "steps"]
    );
    assert_eq!(fill["capture"]["size"], 64);
    for image in fill["capture"]["images"].as_array().unwrap() {
        assert!(
            Path::new(folder.path())
                .join(image.as_str().unwrap())
                .is_file()
        );
    }
    let of = |report: &Value| number(&report["lod"]["fill"], "outside_rms");
    assert!(
        of(&captured) < of(&background),
        "{} {}",
        of(&captured),
        of(&background)
    );
    assert!(number(fill, "outside_psnr") > 10.0);
    let before = filled(&["--fill", "previous", "--previous-look", "10,0"]);
    assert_eq!(before["lod"]["fill"]["mode"], "previous");
    for (arguments, hint) in [
        (&["--lod", "off", "--fill", "capture"][..], "--lod paper"),
        (&["--lod", "paper", "--fill-size", "64"], "--fill capture"),
        (&["--lod", "paper", "--fill", "previous"], "--previous-look"),
        (
            &["--lod", "paper", "--previous-look", "front"],
            "--fill previous",
        ),
        (
            &["--lod", "paper", "--fill", "capture", "--fill-level", "1.5"],
            "from 0 to 1",
        ),
        (
            &["--lod", "paper", "--fill", "capture", "--fill-size", "0"],
            "--fill-size",
        ),
    ] {
        let output = shisen(folder.path())
            .arg("cave")
            .args(arguments)
            .assert()
            .code(2)
            .get_output()
            .clone();
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(error.contains(hint), "{arguments:?}: {error}");
    }
}
