//! The examples of the crates, as their first lines say to run them: each checks what it
//! computed, and here is looked at what it prints and writes.

use shisen_tests::command::example;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// What an example prints, run in a folder.
fn printed_in(folder: &Path, name: &str) -> Vec<u8> {
    let output = example(name, folder)
        .assert()
        .success()
        .get_output()
        .clone();
    assert!(output.stderr.is_empty(), "{name}: {output:?}");
    output.stdout
}

/// What an example that writes no file prints.
fn printed(name: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let printed = printed_in(folder.path(), name);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{name}");
    String::from_utf8(printed).unwrap()
}

#[test]
fn a_ray_and_a_tile() {
    let text = printed("tracer");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "the ball is 2.5 m away");
    let rows = &lines[1..21];
    assert!(rows.iter().all(|row| row.chars().count() == 40), "{text}");
    // The lamp is to the upper left: there it is brightest, and darkest on the other side.
    let at = |shade: char| -> (f64, f64) {
        let places = rows.iter().enumerate().flat_map(|(y, row)| {
            let found = row.char_indices().filter(|(_, one)| *one == shade);
            found.map(move |(x, _)| (x as f64, y as f64))
        });
        let places: Vec<_> = places.collect();
        let mean = |sum: f64| sum / places.len() as f64;
        (
            mean(places.iter().map(|place| place.0).sum()),
            mean(places.iter().map(|place| place.1).sum()),
        )
    };
    let (bright, dark) = (at('@'), at('.'));
    assert!(bright.0 < 15.0 && bright.1 < 9.0, "{bright:?}");
    assert!(dark.0 > 20.0 && dark.1 > 9.0, "{dark:?}");
    assert!(lines[21].starts_with("100 steps at a time, in "), "{text}");
}

#[test]
fn a_wall_by_the_core_alone() {
    let folder = tempfile::tempdir().unwrap();
    let file = printed_in(folder.path(), "off_axis");
    let pixels = file.strip_prefix(b"P5 128 128 255\n").unwrap();
    assert_eq!(pixels.len(), 128 * 128);
    let columns: Vec<usize> = (0..pixels.len())
        .filter(|&pixel| pixels[pixel] > 0)
        .map(|pixel| pixel % 128)
        .collect();
    // From 0.4 m to the left, what is 3 m away and in the middle is seen where the wall,
    // 1.5 m away, is 0.2 m to the left of its middle: half as far away, half as far off.
    let (least, most) = (columns.iter().min().unwrap(), columns.iter().max().unwrap());
    let middle = (least + most) as f64 / 2.0 + 0.5;
    let expected = 64.0 - 0.2 / 3.0 * 128.0;
    assert!((middle - expected).abs() < 1.0, "{middle} {expected}");
}

#[test]
fn a_line_of_sight_from_bytes() {
    assert_eq!(
        printed("gaze_from_bytes"),
        "29 bytes dropped: truncated\n\
         5 bytes dropped: out of step\n\
         59 samples, 34 bytes lost; looking 30.00° to the right\n"
    );
}

#[test]
fn a_firmware_loop() {
    assert_eq!(
        printed("uart_loop"),
        "set up after 301 ms; 323 samples since, 0 bytes dropped\n"
    );
}

/// The same numbers from the same seeds.
#[test]
fn a_simulated_tracker() {
    assert_eq!(
        printed("mock_tracker"),
        "14692 samples, 165 damaged\n\
         off by 0.10° in half of the frames, 2.35° in one of twenty\n"
    );
}

/// A picture's size and pixels as RGB or RGBA.
fn png(path: &Path) -> (u32, u32, Vec<u8>) {
    let decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    (info.width, info.height, pixels)
}

#[test]
fn a_wall_for_two_eyes() {
    let folder = tempfile::tempdir().unwrap();
    let text = printed_in(folder.path(), "wall");
    let text = String::from_utf8(text).unwrap();
    assert!(
        text.starts_with("front-left.png\nfront-right.png\n131072 primary rays, frame "),
        "{text}"
    );
    let [left, right] = ["left", "right"].map(|eye| {
        let (width, height, pixels) = png(&folder.path().join(format!("front-{eye}.png")));
        assert_eq!((width, height), (256, 256));
        let colours: BTreeSet<&[u8]> = pixels.chunks(3).collect();
        assert!(colours.len() > 1_000, "{}", colours.len());
        pixels
    });
    assert_ne!(left, right);
}

#[test]
fn a_dome_master_with_and_without_a_mirror() {
    let folder = tempfile::tempdir().unwrap();
    let text = String::from_utf8(printed_in(folder.path(), "dome_master")).unwrap();
    assert!(
        text.contains("fisheye.png, ") && text.contains("mirror.png, "),
        "{text}"
    );
    for name in ["fisheye.png", "mirror.png"] {
        let (width, height, pixels) = png(&folder.path().join(name));
        assert_eq!((width, height), (256, 256));
        // A disc, transparent around it.
        let opaque = pixels.chunks(4).filter(|pixel| pixel[3] == 255).count() as f64;
        let disc = std::f64::consts::PI / 4.0 * 256.0 * 256.0;
        assert!((opaque / disc - 1.0).abs() < 0.01, "{name}: {opaque}");
    }
}

#[test]
fn frames_within_a_budget() {
    let text = printed("follow_a_tracker");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 6, "{text}");
    let words = |line: &str, after: &str| -> f64 {
        let rest = line.split(after).nth(1).unwrap();
        rest.split([' ', ',', ':']).next().unwrap().parse().unwrap()
    };
    for (number, line) in lines.iter().enumerate() {
        assert_eq!(words(line, "frame "), 10.0 * (number + 1) as f64, "{line}");
    }
    // The whole does not fit: the governor lowers quality until it does.
    for line in &lines {
        assert!(words(line, "quality ") > 0.0, "{text}");
        assert!(line.ends_with(", 0 of 54 tiles unfinished"), "{text}");
    }
    assert_eq!(printed("follow_a_tracker"), text);
}
