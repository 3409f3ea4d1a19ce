//! Levels of detail at the command line: `shisen gaze`.

use serde_json::{Value, json};
use shisen_tests::command::{folder, line, number, refused, says, shisen, succeed};
use shisen_tests::meshes::write_ball;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_6, PI};
use std::io::{BufRead, BufReader, Write};
use std::process::Stdio;

/// Returns what `shisen gaze` says of some directions, a line each.
fn sights(words: &str, directions: &str) -> Vec<Value> {
    let folder = folder();
    let mut command = line(folder.path(), &format!("gaze --json {words}"));
    let said = succeed(command.write_stdin(directions));
    assert_eq!(said.err, "");
    said.objects()
}

#[test]
fn directions_have_the_levels_of_the_equations() {
    const SIDE: f64 = 5.0 * PI / 9.0;
    let (above, below) = (2.0 * FRAC_PI_6, 7.0 * PI / 18.0);
    // The two angles, the boundary and the level; and faces.
    let table = [
        ("0 0 -1", [0.0, 0.0, SIDE, 1.0], 5804),
        ("1 0 -1", [FRAC_PI_4, 0.0, SIDE, 55.0 / 70.0], 4668),
        ("-3,0,-3", [FRAC_PI_4, 0.0, SIDE, 55.0 / 70.0], 4668),
        ("0 0.1 -0.1", [0.0, FRAC_PI_4, above, 0.5], 3152),
        ("0 -1e20 -1e20", [0.0, -FRAC_PI_4, below, 0.625], 3816),
        // To the right of the viewer the elevation is 0 by definition.
        ("1 0 0", [FRAC_PI_2, 0.0, SIDE, 1.0 / 7.0], 1258),
        ("0 0 1", [PI, 0.0, SIDE, 0.0], 500),
        ("0 1 0", [0.0, FRAC_PI_2, above, 0.0], 500),
    ];
    let input = table.map(|row| row.0).join("\n");
    for (words, tolerance) in [("", 1.0e-6), ("--f64", 1.0e-14)] {
        let found = sights(words, &input);
        for ((direction, exact, faces), found) in table.into_iter().zip(found) {
            let [m_alpha, m_beta, big_l, level] = exact;
            for (key, expected) in [
                ("m_alpha", m_alpha),
                ("m_beta", m_beta),
                ("l", m_alpha.hypot(m_beta)),
                ("big_l", big_l),
                ("level", level),
            ] {
                let off = (number(&found, key) - expected).abs();
                assert!(off <= tolerance, "{direction}: {key} of {found}");
            }
            let zone = match level {
                1.0 => "central",
                0.0 => "outside",
                _ => "peripheral",
            };
            // Three bounces where all are made: equation 9.
            let bounces = (3.0 * level) as u8;
            says(&found, json!({ "zone": zone, "bounces": bounces }));
            // Half way between two pairs of faces the nearest is a matter of rounding.
            let off = found["faces"].as_u64().unwrap().abs_diff(faces);
            assert!(
                off == 0 || level == 0.625 && off == 2,
                "{direction}: {found}"
            );
        }
    }
}

#[test]
fn arguments_change_levels() {
    // Looking down, up is to the front; looking up, to the back.
    let mut cases = vec![
        ("--look floor", "0 -1 0", 1.0),
        ("--look floor", "0 -1 -1", 0.5),
        ("--look 0,-3,0", "0 -1 -1", 0.5),
        ("--look 0,90", "0 1 0", 1.0),
        ("--look 0,90", "0 1 1", 0.5),
        // The head lies on its side: what was above is now to the left.
        ("--up 1,0,0", "0 1 -1", 55.0 / 70.0),
        ("--up 2,0,-2", "0 1 -1", 55.0 / 70.0),
        ("--central 40", "1 0 -1", 55.0 / 60.0),
        ("--central 45.01", "1 0 -1", 1.0),
        ("--field-right 45", "1 0 -1", 0.0),
        ("--field-right 60", "1 0 -1", 0.5),
        ("--field-left 60", "1 0 -1", 55.0 / 70.0),
        ("--field-left 60", "-1 0 -1", 0.5),
        ("--field-up 80", "0 1 -1", 35.0 / 50.0),
        ("--field-down 80", "0 1 -1", 0.5),
        ("--field-down 80", "0 -1 -1", 35.0 / 50.0),
    ];
    for look in [
        "--look 1,0,0",
        "--look 0.001,0,0",
        "--look right",
        "--look 90,0",
    ] {
        cases.extend([(look, "1 0 0", 1.0), (look, "1 0 1", 55.0 / 70.0)]);
    }
    for precision in ["", " --f64"] {
        for (words, direction, level) in &cases {
            let found = sights(&format!("{words}{precision}"), direction);
            let off = (number(&found[0], "level") - level).abs();
            assert!(off < 1.0e-6, "{words}: {found:?}");
        }
        // The ellipse lies within the printed curve, and touches it on the axes.
        let [printed, ellipse] = ["printed", "ellipse"].map(|boundary| {
            let found = sights(
                &format!("--boundary {boundary}{precision}"),
                "1 1 -1\n1 0 -1",
            );
            [0, 1].map(|place| number(&found[place], "big_l"))
        });
        assert!(printed[0] > ellipse[0] + 0.1 && (printed[1] - ellipse[1]).abs() < 1.0e-6);
    }
    let found = sights("--reflect-max 7 --faces 10..30", "1 0 -1").remove(0);
    says(&found, json!({ "bounces": 5, "faces": 26 }));
}

#[test]
fn each_direction_has_its_answer_before_the_next() {
    let input = "# nothing\n\n  0 0 -1\r\n1, 0 ,-1 # to the right\n\t0\t0 1";
    assert_eq!(sights("", input).len(), 3);
    assert!(sights("", "").is_empty());
    let folder = folder();
    let mut child = std::process::Command::new(shisen(folder.path()).get_program())
        .args(["gaze", "--json"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let mut answers = BufReader::new(child.stdout.take().unwrap()).lines();
    for direction in ["0 0 -1", "0 1 -1", "0 0 1"] {
        writeln!(input, "{direction}").unwrap();
        assert!(answers.next().unwrap().unwrap().contains("zone"));
    }
    drop(input);
    assert!(child.wait().unwrap().success());
}

#[test]
fn lines_that_are_no_direction_are_named() {
    let folder = folder();
    let long = "1 ".repeat(4000);
    for (bad, expected) in [
        (&b"1 2"[..], "2 numbers"),
        (b"1 2 3 4", "4 numbers"),
        (b"1 two 3", "two"),
        (b"1,,3", "comma"),
        (b"0 -0.0 0", "nowhere"),
        (b"nan 0 1", "nan"),
        (b"1 1e999 1", "1e999"),
        (b"\xff\xfe 0 1", "no number"),
        (b"1 \0 1", "no number"),
        (long.as_bytes(), "longer than 4096"),
    ] {
        let mut input = b"0 0 -1\n\n# a line\n1 0 -1\n".to_vec();
        input.extend_from_slice(bad);
        input.extend_from_slice(b"\n0 0 -1\n");
        for words in ["gaze --json", "gaze --json --f64"] {
            let mut command = line(folder.path(), words);
            let output = command
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
            assert_eq!(String::from_utf8(output.stdout).unwrap().lines().count(), 2);
        }
    }
}

#[test]
fn impossible_gazes_are_usage() {
    refused(
        folder().path(),
        2,
        "
        gaze --look 0,0,0 => points nowhere
        gaze --look nan,0,0 => nan
        gaze --look 0,90 --up 0,1,0 => parallel
        gaze --look aside => not a direction
        gaze --look 0,3,0 --up 0,-2,0 => parallel
        gaze --look 0,-1e-30,0 --up 0,1,0 => parallel
        gaze --look 1,2,3 --up -2,-4,-6 => parallel
        gaze --up 0,0,0 => points nowhere
        gaze --up 0,nan,0 => nan
        gaze --faces 0..5 => at least 1
        gaze --faces 9..3 => exchange
        gaze --central 0 => degrees
        gaze --central nan => degrees
        gaze --central -30 => degrees
        gaze --field-up 20 => --field-up 20.0000 is within
        gaze --field-down 91 => at most 90 degrees
        gaze --central 0.00001 => 0.0001 degrees or more
        gaze --field-left 181 => degrees
        gaze --boundary wavy => ellipse
        gaze --reflect-max 256 => --reflect-max",
    );
}

#[test]
fn an_acuity_finer_than_a_pixel_is_full_tracing_and_says_so() {
    let folder = folder();
    write_ball(folder.path());
    let cave = |words: &str| {
        let small = "cave --mesh ball.obj --view-size 8x6 --json";
        let said = succeed(&mut line(folder.path(), &format!("{small} {words}")));
        (said.objects().remove(0), said.err)
    };
    let (full, _) = cave("--size 16");
    let (fine, said) = cave("--size 16 --lod foveated --acuity 0,0.0001");
    assert_eq!(fine["frame_hash"], full["frame_hash"]);
    assert!(said.contains("finer than a pixel everywhere"), "{said}");
    says(&fine, json!({ "samples": 1 }));
    let (coarse, said) = cave("--size 64 --lod foveated");
    assert_eq!(said, "");
    says(&coarse, json!({ "samples": 4 }));
    // Rays are counted by wall and eye.
    for kind in ["primary", "shadow", "lit", "leaves"] {
        let of_image = |image: &Value| image["rays"][kind].as_u64().unwrap();
        let of_images: u64 = coarse["images"]
            .as_array()
            .unwrap()
            .iter()
            .map(of_image)
            .sum();
        assert_eq!(Some(of_images), coarse["rays"][kind].as_u64(), "{kind}");
    }
    // Samples are traced in fours.
    let (uneven, said) = cave("--size 64 --lod foveated --samples 5");
    says(&uneven, json!({ "samples": 8 }));
    for said in [
        said,
        cave("--size 16 --lod foveated --samples 5 --tracker mock --frames 1").1,
    ] {
        assert!(said.contains("8 rays a pixel instead of 5"), "{said}");
    }
}
