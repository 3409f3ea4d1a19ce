//! Pictures for two eyes, from the command to the file.

use serde_json::{Value, json};
use shisen_tests::command::{folder, report};
use shisen_tests::meshes::write_ball;
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
        let notes = notes.map(|note| (note.keyword.clone(), note.text.clone()));
        Self {
            size: [info.width, info.height],
            pixels,
            notes: notes.collect(),
        }
    }

    fn note(&self, key: &str) -> Option<&str> {
        let mut notes = self.notes.iter();
        notes.find_map(|(one, text)| (one == key).then_some(text.as_str()))
    }

    /// Returns a part of each row, from one column to another.
    fn columns(&self, from: u32, to: u32) -> Vec<u8> {
        let row = 3 * self.size[0] as usize;
        let part = 3 * from as usize..3 * to as usize;
        let rows = self.pixels.chunks_exact(row);
        rows.flat_map(|row| &row[part.clone()]).copied().collect()
    }
}

#[test]
fn a_room_s_eyes_are_put_together_left_first() {
    let folder = folder();
    write_ball(folder.path());
    let cave = |stereo: &str| {
        let small = "cave --mesh ball.obj --size 32 --view-size 40x30 --ipd 0.3";
        let words = format!("{small} --stereo {stereo} --out {stereo}");
        report(folder.path(), &words)
    };
    let read = |path: &Value| Png::read(&folder.path().join(path.as_str().expect("a path")));
    assert_eq!(cave("mono")["stereo"], Value::Null);

    let report = cave("sequential");
    let stereo = &report["stereo"];
    assert_eq!(stereo["format"], "sequential");
    assert_eq!(stereo["eye_order"], json!(["left", "right"]));
    let paths = &stereo["images"];
    assert_eq!(paths[0], "sequential/stereo-cave-left.png");
    assert_eq!(paths[3], "sequential/stereo-viewer-right.png");
    let [left, right, seen_left, seen_right] = [0, 1, 2, 3].map(|at| read(&paths[at]));
    // The left eye's net is the one that there is in any case.
    assert_eq!(left.pixels, read(&report["cave"]).pixels);
    assert_eq!(seen_left.pixels, read(&report["viewer"]).pixels);
    assert!(left.pixels != right.pixels && seen_left.pixels != seen_right.pixels);
    for (png, eye) in [(&left, "left"), (&right, "right"), (&seen_right, "right")] {
        assert_eq!(png.note("Stereo-Format"), Some("sequential"));
        assert_eq!(png.note("Stereo-Eye-Order"), Some("left right"));
        assert_eq!(png.note("Stereo-Eye"), Some(eye));
    }

    let [width, height] = left.size;
    let beside = read(&cave("side-by-side")["stereo"]["images"][0]);
    assert_eq!(beside.size, [2 * width, height]);
    assert_eq!(beside.columns(0, width), left.pixels);
    assert_eq!(beside.columns(width, 2 * width), right.pixels);
    let above = read(&cave("top-bottom")["stereo"]["images"][1]);
    assert_eq!(above.pixels, [seen_left.pixels, seen_right.pixels].concat());
    let glasses = read(&cave("anaglyph")["stereo"]["images"][0]);
    assert_eq!(glasses.note("Stereo-Format"), Some("anaglyph"));
}

#[test]
fn frames_are_written_for_each_eye_in_turn() {
    let folder = folder();
    let frames = |stereo: &str| {
        let words = "run --scene grid --budget off --hz 200 --frames 2 --size 16 --view png";
        let words = format!("{words} --out {stereo} --stereo {stereo}");
        let report = report(folder.path(), &words);
        assert_eq!(report["stereo"]["format"], stereo);
    };
    let png = |path: &str| Png::read(&folder.path().join(path));
    frames("mono");
    let one = png("mono/frame-000001.png");
    assert_eq!(one.note("Stereo-Eye"), Some("left"));
    frames("sequential");
    for (number, eye) in [(0, "left"), (0, "right"), (1, "left"), (1, "right")] {
        let picture = png(&format!("sequential/frame-{number:06}-{eye}.png"));
        assert_eq!(
            (picture.size, picture.note("Stereo-Eye")),
            (one.size, Some(eye))
        );
    }
    frames("side-by-side");
    let both = png("side-by-side/frame-000000.png");
    assert_eq!(both.size, [2 * one.size[0], one.size[1]]);
}
