use super::*;
use crate::live::{Cut, Decision, Look, Quality, RoomPlace};
use glam::{DVec3, Quat, Vec3};
use shisen_core::gaze::HeadPose;

fn setup() -> Setup {
    let picture = |name: &str| RecordedPicture {
        name: name.to_owned(),
        eye: "left".to_owned(),
        size: [40, 70],
    };
    Setup {
        program: "1".to_owned(),
        arguments: vec!["run".to_owned()],
        folder: "/".to_owned(),
        changes: Vec::new(),
        fill: "background".to_owned(),
        scene: "A".to_owned(),
        scene_hash: "00".to_owned(),
        walls: None,
        tile: 32,
        pictures: vec![picture("front"), picture("floor")],
        rungs: Quality::LADDER.to_vec(),
    }
}

fn frame(number: u64) -> RecordedFrame {
    let part = number as f32 * 0.01;
    let wall = |hash: u64| WallHash {
        hash: hash.wrapping_mul(0x9E37_79B9_7F4A_7C15),
        rows: vec![hash as u32, 7, u32::MAX],
    };
    let position = Vec3::new(part, 1.7, -0.0);
    RecordedFrame {
        number,
        shown_us: 16_667 * number,
        time: f64::from(part),
        place: if number.is_multiple_of(3) {
            RoomPlace::START
        } else {
            RoomPlace {
                position: DVec3::new(0.1, -2.0, 1.0e4),
                yaw: 0.5,
            }
        },
        look: Look {
            head: HeadPose {
                position,
                orientation: Quat::from_rotation_y(part),
            },
            position,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            widen: if number.is_multiple_of(2) { 0.0 } else { 0.25 },
        },
        decision: Decision {
            steps: (!number.is_multiple_of(4)).then_some(u64::MAX - number),
            whole_fovea: number.is_multiple_of(5),
            rung: number as usize % 14,
        },
        cuts: (0..number % 4)
            .map(|one| Cut {
                tile: one as u32 * 200,
                kept: 1_024 - one as u32,
            })
            .collect(),
        walls: vec![wall(number), wall(!number)],
    }
}

/// Returns the bytes of a record of frames.
fn record(frames: u64) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record");
    let mut writer = Writer::create(&path).unwrap();
    writer.session(&setup()).unwrap();
    for number in 0..frames {
        writer.frame(&frame(number)).unwrap();
        if number == 3 {
            writer.raw(1, b"bytes").unwrap();
        }
    }
    writer.finish().unwrap();
    std::fs::read(&path).unwrap()
}

fn read(bytes: &[u8]) -> Result<Vec<Result<Entry, Damage>>, Fault> {
    let mut reader = Reader::new(Path::new("record"), bytes)?;
    Ok(std::iter::from_fn(|| reader.entry()).collect())
}

#[test]
fn a_record_is_read_as_it_was_written() {
    let bytes = record(60);
    let entries: Result<Vec<Entry>, _> = read(&bytes).unwrap().into_iter().collect();
    let mut entries = entries.unwrap();
    assert_eq!(entries.remove(0), Entry::Session(Box::new(setup())));
    assert_eq!(entries.remove(4), Entry::Raw(1, b"bytes".to_vec()));
    assert_eq!(entries.pop(), Some(Entry::End));
    let frames = (0..60).map(|number| Entry::Frame(Box::new(frame(number))));
    assert!(entries.into_iter().eq(frames));
    // Besides rows and cuts a frame has at most 64 bytes for each of three walls.
    let one = |number| {
        let mut bytes = Vec::new();
        frame(number).write(&mut bytes);
        bytes.len() + BEFORE + AFTER - 24 - 2 * 8 + 3 * 8
    };
    assert!((0..60).all(|number: u64| number.is_multiple_of(4) || one(number) <= 3 * 64));
}

/// What was cut off is read up to there, and each bit that is another is found in its frame.
#[test]
fn every_bit_that_is_another_is_found_where_it_is() {
    let bytes = record(9);
    let whole = read(&bytes).unwrap();
    let mut ends = Vec::new();
    let mut reader = Reader::new(Path::new("record"), &bytes).unwrap();
    while reader.entry().is_some() {
        ends.push((bytes.len() - reader.rest.len(), reader.frames()));
    }
    for cut in MAGIC.len()..bytes.len() {
        let read = read(&bytes[..cut]).unwrap();
        let count = ends.iter().filter(|(end, _)| *end <= cut).count();
        assert_eq!(read.last(), Some(&Err(Damage::CutOff)), "{cut}");
        assert_eq!(read[..read.len() - 1], whole[..count], "{cut}");
    }
    for bit in 0..8 * bytes.len() {
        let mut other = bytes.clone();
        other[bit / 8] ^= 1 << (bit % 8);
        let Ok(found) = read(&other) else {
            assert!(bit / 8 < MAGIC.len());
            continue;
        };
        let at = ends.iter().position(|(end, _)| bit / 8 < *end).unwrap();
        let (start, before) = at
            .checked_sub(1)
            .map_or((MAGIC.len(), 0), |before| ends[before]);
        assert_eq!(found[..at], whole[..at], "{bit}");
        // An end that is another is no end.
        let is_end = at == ends.len() - 1 && found[at] == Err(Damage::CutOff);
        let damage = if other[start] == FRAME {
            Damage::Frame(before)
        } else {
            Damage::Other(before)
        };
        assert!(is_end || found[at] == Err(damage), "{bit}");
    }
}

#[test]
fn other_versions_and_other_files_are_refused() {
    for (bytes, says) in [
        (&b"shisen record 2\nxyz"[..], "a record of version 2"),
        (b"shisen recor", "no record"),
        (b"", "no record"),
    ] {
        let fault = read(bytes).unwrap_err().to_string();
        assert!(fault.contains(says), "{fault}");
    }
}
