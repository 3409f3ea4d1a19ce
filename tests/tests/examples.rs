//! The examples of the crates, as their first lines say to run them: each checks what it
//! computed, and here is looked at what it prints and writes.

use shisen_tests::command::{example, folder};
use shisen_tests::png_file::PngFile;
use std::path::Path;

/// Returns what an example prints, run in a folder.
fn printed(folder: &Path, name: &str) -> Vec<u8> {
    let output = example(name, folder).output().unwrap();
    assert!(
        output.status.success() && output.stderr.is_empty(),
        "{name}: {output:?}"
    );
    output.stdout
}

#[test]
fn each_example_does_what_it_shows() {
    let folder = folder();
    for (name, expected) in [
        ("tracer", "the ball is 2.5 m away"),
        (
            "gaze_from_bytes",
            "59 samples, 34 bytes lost; looking 30.00° to the right",
        ),
        (
            "uart_loop",
            "set up after 301 ms; 323 samples since, 0 bytes dropped",
        ),
        // The same numbers from the same seeds.
        ("mock_tracker", "14692 samples, 165 damaged"),
        // The whole does not fit: the governor lowers quality until it does.
        ("follow_a_tracker", ", 0 of 54 tiles unfinished"),
        ("wall", "131072 primary rays, frame "),
        ("dome_master", "mirror.png, "),
    ] {
        let text = String::from_utf8(printed(folder.path(), name)).unwrap();
        assert!(text.contains(expected), "{name}: {text}");
    }
    let open = |name: &str| PngFile::open(folder.path().join(name)).bytes;
    assert!(open("front-left.png") != open("front-right.png"));
    assert!(open("fisheye.png") != open("mirror.png"));
}

#[test]
fn a_wall_by_the_core_alone() {
    let folder = folder();
    let file = printed(folder.path(), "off_axis");
    let pixels = file.strip_prefix(b"P5 128 128 255\n").unwrap();
    assert_eq!(pixels.len(), 128 * 128);
    let lit = (0..pixels.len()).filter(|&pixel| pixels[pixel] > 0);
    let columns = lit.map(|pixel| pixel % 128);
    // From 0.4 m to the left, what is 3 m away and in the middle is seen where the wall,
    // 1.5 m away, is 0.2 m to the left of its middle: half as far away, half as far off.
    let (least, most) = (columns.clone().min().unwrap(), columns.max().unwrap());
    let middle = (least + most) as f64 / 2.0 + 0.5;
    let expected = 64.0 - 0.2 / 3.0 * 128.0;
    assert!((middle - expected).abs() < 1.0, "{middle} {expected}");
}
