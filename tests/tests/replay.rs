//! `shisen run --record` and `shisen replay`: the same frames again.
#![cfg(unix)]

use shisen_tests::command::{count, folder, line, refusal, report};
use std::fs;
use std::path::Path;

/// Records frames of `words`; returns the report of replaying them with `how`.
fn replayed(folder: &Path, words: &str, how: &str) -> serde_json::Value {
    let view = if words.contains("--view") {
        ""
    } else {
        "--view none"
    };
    let words = format!("run {view} --hz 60 --record record {words}");
    report(folder, &words.replace("  ", " "));
    report(folder, format!("replay record {how}").trim())
}

/// By other threads and another code path, where budgets of time cut frames off wherever they did,
/// and where the viewer moves, looks around and things move.
#[test]
fn recorded_frames_are_the_same_bits_again() {
    let folder = folder();
    let folder = folder.path();
    let spinning = "[materials.red]\ndiffuse = [1, 0.2, 0.2]\n\
                    [meshes.animal]\nbuiltin = \"quadruped\"\n\
                    [[object]]\nname = \"animal\"\nmesh = \"animal\"\nmaterial = \"red\"\n\
                    normalise = true\nposition = [0, 0, -2]\n\
                    [[animation]]\nobject = \"animal\"\nspin = { seconds_per_turn = 2 }\n";
    fs::write(folder.join("spinning.toml"), spinning).expect("a scene");
    let mut cut = 0;
    for (words, how) in [
        (
            "--scene A --size 64 --budget 4ms --frames 12",
            "--threads 1",
        ),
        (
            "--scene gallery --size 48 --budget 90000steps --frames 6",
            "--device portable",
        ),
        (
            "--scene A --size 48 --lod off --samples 4 --budget 60000steps --frames 6",
            "--threads 3",
        ),
        (
            "--scene prism --size 32 --samples 8 --budget off --frames 3",
            "--from 1",
        ),
        (
            "--scene A --size 48 --eyes 1 --view png --fill previous --budget 3ms --frames 8",
            "--frame 7",
        ),
        (
            "--scene spinning.toml --size 32 --budget 2ms --frames 8",
            "--threads 1",
        ),
    ] {
        let replayed = replayed(folder, words, &format!("{how} --verify"));
        let verified = &replayed["verified"];
        assert!(count(verified, "frames") > 0, "{words}: {replayed}");
        assert_eq!(verified["frames"], verified["equal"], "{words}: {replayed}");
        cut += count(&replayed["sessions"][0], "cut_frames");
    }
    // Without any there would be nothing to render again.
    assert!(cut > 10, "{cut} frames were cut off");
}

/// Where a budget leaves one ray to a square, that ray sees objects where they are now.
#[test]
fn what_is_cut_off_shows_things_where_they_have_moved() {
    let folder = folder();
    let folder = folder.path();
    let pictures = |position: &str, animation: &str| {
        let scene = format!(
            "[materials.red]\ndiffuse = [1, 0.2, 0.2]\nemission = [0.5, 0.1, 0.1]\n\
             [[object]]\nname = \"ball\"\nsphere = {{ radius = 1.5 }}\nmaterial = \"red\"\n\
             position = {position}\n{animation}"
        );
        fs::write(folder.join("ball.toml"), scene).expect("a scene");
        let words =
            "--scene ball.toml --lod foveated --size 96 --eyes 1 --budget 1steps --frames 9";
        replayed(folder, words, "--from 8 --verify --out seen");
        fs::remove_file(folder.join("record")).expect("a record");
        fs::read(folder.join("seen/frame-000008.png")).expect("a picture")
    };
    let path = "[[animation]]\nobject = \"ball\"\ntimes = [0, 0.05, 9]\n\
                position = [[0, 0, -4], [2, 0, -3], [2, 0, -3]]\n";
    let [before, after] =
        [("[0, 0, -4]", ""), ("[2, 0, -3]", "")].map(|(at, path)| pictures(at, path));
    assert!(before != after);
    assert!(pictures("[0, 0, -4]", path) == after);
}

#[test]
fn what_would_have_been_is_told_and_shown() {
    let folder = folder();
    let folder = folder.path();
    let words = "--scene A --size 48 --budget off --frames 12";
    let same = replayed(folder, words, "--against portable");
    assert_eq!(same["against"]["equal"], 12, "{same}");
    let how = "replay record --frame 11 --what-if";
    let off = report(folder, &format!("{how} lod=off --out seen"));
    let changed = &off["what_if"];
    for key in ["mean_difference", "seen_difference", "largest"] {
        assert!(changed[key].as_f64() > Some(0.1), "{off}");
    }
    for picture in ["frame-000011-left.png", "other/frame-000011-left.png"] {
        assert!(folder.join("seen").join(picture).is_file(), "{picture}");
    }
    let beside = report(folder, &format!("{how} gaze=+20,0"));
    assert!(
        beside["what_if"]["seen_difference"].as_f64() > Some(0.0),
        "{beside}"
    );
    let cut = report(folder, &format!("{how} budget=20000steps"));
    assert!(cut["what_if"]["steps"].as_f64() < Some(1.0), "{cut}");
}

/// Frames build on those before them by both ways, the walls are the record's, and what another detail
/// has not is left out.
#[test]
fn what_is_rendered_twice_is_of_one_session() {
    let folder = folder();
    let folder = folder.path();
    let walls = "[[wall]]\nname = \"screen\"\nlower_left = [-1, -1, -1]\n\
                 lower_right = [1, -1, -1]\nupper_left = [-1, 1, -1]\n";
    fs::write(folder.join("room.toml"), walls).expect("a room");
    let words =
        "--scene A --walls room.toml --size 48 --view png --fill previous --budget off --frames 8";
    replayed(folder, words, "");
    fs::remove_file(folder.join("room.toml")).expect("a room");
    let again = report(
        folder,
        "replay record --frame 7 --against portable --verify",
    );
    for key in ["against", "verified"] {
        assert_eq!(count(&again[key], "equal"), 1, "{again}");
    }
    let words = "--scene gallery --size 32 --quality 5 --budget 30000steps --frames 3";
    let off = replayed(folder, words, "--frame 2 --what-if lod=off");
    assert_eq!(count(&off["what_if"], "frames"), 1, "{off}");
    // A frame that no budget cut off is what it was where nothing is changed, in full quality more.
    let words = "--scene gallery --size 32 --budget 60000steps --frames 9";
    let same = replayed(folder, words, "--frame 8 --what-if gaze=0,0");
    assert_eq!(count(&same["what_if"], "cut_frames"), 0, "{same}");
    assert_eq!(same["what_if"]["largest"], 0.0, "{same}");
    let whole = report(folder, "replay record --frame 8 --what-if budget=off");
    assert!(whole["what_if"]["steps"].as_f64() > Some(1.5), "{whole}");
    let refused = refusal(&mut line(folder, "replay record --verify --frame 9"), 2);
    assert!(refused.contains("frames 0 to 8"), "{refused}");
}

#[test]
fn damage_and_other_scenes_are_told() {
    let folder = folder();
    let folder = folder.path();
    let ball = "[materials.m]\ndiffuse = [0.2, 0.9, 0.2]\n\
                [[object]]\nsphere = { radius = 1 }\nmaterial = \"m\"\nposition = [0, 0, -3]\n";
    fs::write(folder.join("ball.toml"), ball).expect("a scene");
    let words = "--scene ball.toml --size 16 --budget off --frames 4";
    let whole = replayed(folder, words, "");
    assert_eq!(count(&whole["sessions"][0], "frames"), 4, "{whole}");
    assert_eq!(whole["is_cut_off"], false, "{whole}");
    let bytes = fs::read(folder.join("record")).expect("a record");
    fs::write(folder.join("cut"), &bytes[..bytes.len() - 20]).expect("a record");
    let cut = report(folder, "replay cut");
    assert_eq!(
        (count(&cut["sessions"][0], "frames"), &cut["is_cut_off"]),
        (3, &true.into())
    );
    let mut other = bytes.clone();
    let at = bytes.len() - 40;
    other[at] ^= 4;
    fs::write(folder.join("altered"), other).expect("a record");
    let said = line(folder, "replay altered").output().expect("a run");
    assert_eq!(said.status.code(), Some(1));
    let said = String::from_utf8_lossy(&said.stderr).into_owned();
    assert!(said.contains("frame 3 is not what was recorded"), "{said}");
    // What builds on a frame that is damaged cannot be compared.
    let filled = "--scene ball.toml --lod paper --size 16 --eyes 1 --view png --fill previous --budget off --frames 4";
    fs::remove_file(folder.join("record")).expect("a record");
    replayed(folder, filled, "");
    let mut bytes = fs::read(folder.join("record")).expect("a record");
    let mut second = b"shisen record 1\n".len();
    // Behind the session and a frame.
    for _ in 0..2 {
        let length = bytes[second + 1..second + 5].try_into().expect("a length");
        second += 9 + u32::from_le_bytes(length) as usize;
    }
    bytes[second + 9] ^= 1;
    fs::write(folder.join("altered"), bytes).expect("a record");
    let said = line(folder, "replay altered --verify --json")
        .output()
        .expect("a run");
    let found: serde_json::Value = serde_json::from_slice(&said.stdout).expect("a report");
    assert_eq!(found["damaged_frames"], serde_json::json!([1]), "{found}");
    assert_eq!(found["baseless_frames"], 2, "{found}");
    assert_eq!(
        (&found["verified"]["frames"], &found["verified"]["equal"]),
        (&1.into(), &1.into())
    );
    fs::rename(folder.join("altered"), folder.join("record")).expect("a record");
    let larger = ball.replace("radius = 1", "radius = 1.1");
    fs::write(folder.join("ball.toml"), larger).expect("a scene");
    let refused = refusal(&mut line(folder, "replay record --verify"), 1);
    assert!(refused.contains("what is here is"), "{refused}");
    fs::remove_file(folder.join("ball.toml")).expect("a file");
    let refused = refusal(&mut line(folder, "replay record --verify"), 1);
    assert!(
        refused.contains("--scene FILE says where the scene is now"),
        "{refused}"
    );
}
