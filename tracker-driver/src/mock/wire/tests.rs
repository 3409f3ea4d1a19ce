use super::*;
use crate::decoder::{Decoder, Event};
use crate::mock::{Tracker, TrackerConfig};
use crate::protocol::Reader;
use crate::rotation::angle;
use std::vec::Vec;

fn tracker() -> Tracker<'static> {
    crate::testing::tracker(TrackerConfig::default(), 3)
}

/// How far each eye tracker's gaze is off, radians; one tenth, or a whole, raw unit.
#[test]
fn a_gaze_comes_through_every_eye_tracker() {
    let until = Micros::from_millis(if cfg!(miri) { 20 } else { 2_000 });
    for (name, most) in [
        ("link", 1e-6),
        ("iscan", 2e-4),
        ("asl", 2e-3),
        ("adhawk", 1e-5),
        ("hid", 1e-5),
    ] {
        let protocol = Protocol::named(name).unwrap();
        let mut decoder = Reader::new(&protocol).unwrap();
        let mut wire = Wire::new(tracker(), protocol);
        let mut sent = tracker();
        let mut found = Vec::new();
        while let Some(chunk) = wire.poll(until) {
            decoder.feed(chunk.bytes(), chunk.arrival, &mut |event| match event {
                Event::Sample(sample) => found.push(sample),
                event => panic!("{name}: {event:?}"),
            });
        }
        assert!(found.len() > 4, "{name}");
        for found in &found {
            let (_, sample) = sent.next_sample();
            let Some(there) = direction(&sample) else {
                let point = found.gaze_point.is_some_and(|point| point.tracked);
                assert!(!point && direction(found).is_none(), "{name}: {found:?}");
                continue;
            };
            let seen = match found.gaze_point.map(|point| point.value) {
                Some(GazePoint::Raw(units)) => {
                    let place = (units - RAW_CENTRE) / RAW_PER_METRE;
                    Vec3::new(place.x, -place.y, -1.0)
                }
                Some(GazePoint::Plane(point)) => {
                    let Protocol::EyeTracker(screen, _) = wire.protocol() else {
                        panic!("{name}");
                    };
                    let from = sample.head.position.unwrap().value;
                    let turn = sample.head.orientation.unwrap().value;
                    rotate(inverse(turn), screen.place(point) - from)
                }
                _ => direction(found).unwrap(),
            };
            let off = angle(normalize(seen).unwrap(), there);
            assert!(off <= most, "{name}: {off}");
        }
    }
}

/// What a head tracker did not measure it does not send as measured.
#[test]
fn a_sample_without_a_head_is_no_pose() {
    let (_, mut sample) = tracker().next_sample();
    sample.head = crate::sample::Head::default();
    for name in Protocol::NAMES {
        let protocol = Protocol::named(name).unwrap();
        let eyes = matches!(name, "link" | "iscan" | "asl" | "adhawk" | "hid");
        assert_eq!(protocol.carries(&sample), eyes, "{name}");
        let says = protocol.says_untracked();
        let mut reader = Reader::new(&protocol).unwrap();
        let mut wire = Wire::new(tracker(), protocol);
        let Some(chunk) = wire.encode(&sample) else {
            assert!(!says, "{name}");
            continue;
        };
        assert!(says, "{name}");
        reader.feed(chunk.bytes(), Micros(0), &mut |event| {
            let Event::Sample(sample) = event else {
                return;
            };
            let head = sample.head;
            assert!(head.position.is_none_or(|place| !place.tracked), "{name}");
            assert!(head.orientation.is_none_or(|turn| !turn.tracked), "{name}");
        });
    }
    let mut eyeless = tracker().next_sample().1;
    (eyeless.left, eyeless.right) = Default::default();
    for name in ["iscan", "asl", "adhawk"] {
        assert!(!Protocol::named(name).unwrap().carries(&eyeless), "{name}");
    }
}
