//! Pictures for two eyes, from the command to the file.

use serde_json::Value;
use shisen_tests::command::shisen;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// A file's columns and rows, its pixels, and what is noted in it.
struct Png {
    size: [u32; 2],
    pixels: Vec<u8>,
    notes: Vec<(String, String)>,
}

impl Png {
    fn read(path: &Path) -> Self {
        let file = BufReader::new(File::open(path).expect("a picture"));
        let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
        let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
        reader.next_frame(&mut pixels).expect("pixels");
        let info = reader.info();
        let notes = info.uncompressed_latin1_text.iter();
        Self {
            size: [info.width, info.height],
            pixels,
            notes: notes
                .map(|note| (note.keyword.clone(), note.text.clone()))
                .collect(),
        }
    }

    fn note(&self, key: &str) -> Option<&str> {
        let mut notes = self.notes.iter();
        notes.find_map(|(one, text)| (one == key).then_some(text.as_str()))
    }

    /// A part of each row, from one column to another.
    fn columns(&self, from: u32, to: u32) -> Vec<u8> {
        let row = 3 * self.size[0] as usize;
        let part = 3 * from as usize..3 * to as usize;
        let rows = self.pixels.chunks_exact(row);
        rows.flat_map(|row| &row[part.clone()]).copied().collect()
    }
}

#[test]
fn a_room_s_eyes_are_put_together_left_first() {
    let folder = tempfile::tempdir().expect("a folder");
    let cave = |stereo: &str, out: &str| {
        let mut command = shisen(folder.path());
        let command = command.args([
            "cave",
            "--size",
            "32",
            "--view-size",
            "40x30",
            "--ipd",
            "0.3",
        ]);
        let command = command.args(["--stereo", stereo, "--out", out, "--json"]);
        let output = command.assert().success();
        let report = &output.get_output().stdout;
        serde_json::from_slice::<Value>(report).expect("an object")
    };
    let read = |path: &Value| Png::read(&folder.path().join(path.as_str().expect("a path")));
    assert_eq!(cave("mono", "none")["stereo"], Value::Null);

    let report = cave("sequential", "pair");
    let stereo = &report["stereo"];
    assert_eq!(stereo["format"], "sequential");
    assert_eq!(stereo["eye_order"], serde_json::json!(["left", "right"]));
    let paths = stereo["images"].as_array().expect("paths");
    assert_eq!(paths[0], "pair/stereo-cave-left.png");
    assert_eq!(paths[3], "pair/stereo-viewer-right.png");
    let [left, right, seen_left, seen_right] = [0, 1, 2, 3].map(|at| read(&paths[at]));
    // The left eye's net is the one that there is in any case.
    assert_eq!(left.pixels, read(&report["cave"]).pixels);
    assert_eq!(seen_left.pixels, read(&report["viewer"]).pixels);
    assert_ne!(left.pixels, right.pixels);
    assert_ne!(seen_left.pixels, seen_right.pixels);
    for (png, eye) in [(&left, "left"), (&right, "right"), (&seen_right, "right")] {
        assert_eq!(png.note("Stereo-Format"), Some("sequential"));
        assert_eq!(png.note("Stereo-Eye-Order"), Some("left right"));
        assert_eq!(png.note("Stereo-Eye"), Some(eye));
    }

    let [width, height] = left.size;
    let report = cave("side-by-side", "beside");
    let beside = read(&report["stereo"]["images"][0]);
    assert_eq!(beside.size, [2 * width, height]);
    assert_eq!(beside.columns(0, width), left.pixels);
    assert_eq!(beside.columns(width, 2 * width), right.pixels);
    assert_eq!(beside.note("Stereo-Eye-Order"), Some("left right"));
    assert_eq!(beside.note("Stereo-Eye"), None);

    let report = cave("top-bottom", "above");
    let above = read(&report["stereo"]["images"][1]);
    assert_eq!(above.size, [40, 60]);
    let (top, bottom) = above.pixels.split_at(above.pixels.len() / 2);
    assert_eq!(
        (top, bottom),
        (&seen_left.pixels[..], &seen_right.pixels[..])
    );

    let report = cave("anaglyph", "glasses");
    let glasses = read(&report["stereo"]["images"][0]);
    assert_eq!(
        (glasses.size, glasses.note("Stereo-Format")),
        (left.size, Some("anaglyph"))
    );
    // Where both eyes see the same grey it stays so, to a code.
    let mut same = 0;
    let pairs = left.pixels.chunks(3).zip(right.pixels.chunks(3));
    for ((left, right), both) in pairs.zip(glasses.pixels.chunks(3)) {
        let grey = left.iter().all(|channel| *channel == left[0]);
        if grey && left == right {
            assert!(both.iter().all(|channel| channel.abs_diff(left[0]) <= 1));
            same += 1;
        }
    }
    assert!(same > 500, "{same}");
    assert!(glasses.pixels != left.pixels && glasses.pixels != right.pixels);
}

#[test]
fn frames_are_written_for_each_eye_in_turn() {
    let folder = tempfile::tempdir().expect("a folder");
    let frames = |stereo: &str| {
        let steps = ["run", "--budget", "off", "--hz", "200", "--frames", "2"];
        let mut command = shisen(folder.path());
        let command = command.args(steps).args(["--size", "16", "--view", "png"]);
        let command = command.args(["--out", stereo, "--stereo", stereo, "--json"]);
        let output = command.assert().success();
        let report: Value = serde_json::from_slice(&output.get_output().stdout).expect("an object");
        assert_eq!(report["stereo"]["format"], stereo);
        let out = folder.path().join(stereo);
        let mut names: Vec<_> = std::fs::read_dir(out)
            .expect("a folder")
            .map(|entry| {
                entry
                    .expect("a file")
                    .file_name()
                    .into_string()
                    .expect("a name")
            })
            .collect();
        names.sort();
        (names, report)
    };
    let (names, _) = frames("mono");
    assert_eq!(names, ["frame-000000.png", "frame-000001.png"]);
    let one = Png::read(&folder.path().join("mono/frame-000001.png"));
    assert_eq!(one.note("Stereo-Format"), Some("mono"));
    assert_eq!(one.note("Stereo-Eye"), Some("left"));
    let (names, report) = frames("sequential");
    let expected = [
        "frame-000000-left.png",
        "frame-000000-right.png",
        "frame-000001-left.png",
        "frame-000001-right.png",
    ];
    assert_eq!(names, expected);
    let order = serde_json::json!(["left", "right"]);
    assert_eq!(report["stereo"]["eye_order"], order);
    let right = Png::read(&folder.path().join("sequential/frame-000000-right.png"));
    assert_eq!(
        (right.size, right.note("Stereo-Eye")),
        (one.size, Some("right"))
    );
    frames("side-by-side");
    let both = Png::read(&folder.path().join("side-by-side/frame-000000.png"));
    assert_eq!(both.size, [2 * one.size[0], one.size[1]]);
}

#[test]
fn one_eye_is_no_pair() {
    let folder = tempfile::tempdir().expect("a folder");
    let fails = |arguments: &[&str], said: &str| {
        let output = shisen(folder.path()).args(arguments).assert().code(2);
        let stderr = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
        assert!(stderr.contains(said), "{stderr}");
    };
    let eyes = "--stereo anaglyph takes two eyes: leave --eyes 1 out";
    fails(&["cave", "--stereo", "anaglyph", "--eyes", "1"], eyes);
    let run = [
        "run", "--view", "png", "--stereo", "anaglyph", "--eyes", "1",
    ];
    fails(&run, eyes);
    fails(
        &["run", "--stereo", "anaglyph"],
        "is for --view png or window",
    );
    fails(&["cave", "--stereo", "both"], "there is no stereo \"both\"");
}
