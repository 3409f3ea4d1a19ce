use super::*;
use crate::decoder::{Decoder, Event};
use crate::mock::{Tracker, TrackerConfig};
use crate::protocol::Reader;
use crate::rotation::{angle, to_vector};
use std::vec::Vec;

fn tracker() -> Tracker<'static> {
    crate::testing::tracker(TrackerConfig::default(), 3)
}

/// What each protocol brings across: errors of the head's place (metres) and
/// turn, and of the gaze (radians), at most; `None` where it has none.
fn expected(name: &str) -> [Option<f32>; 3] {
    match name {
        "link" => [Some(0.0), Some(1e-6), Some(1e-6)],
        "fastrak" | "liberty" => [Some(1e-6), Some(1e-6), None],
        // 14 bits of 36 inches and of the quaternion.
        "flock" => [Some(2e-4), Some(5e-4), None],
        "hatire" => [None, Some(1e-5), None],
        "osvr-hdk" => [None, Some(2e-4), None],
        // Tenths of a unit, and whole ones.
        "iscan" => [None, None, Some(2e-4)],
        "asl" => [None, None, Some(2e-3)],
        "adhawk" => [None, Some(1e-5), Some(1e-5)],
        // The direction of the head lacks its roll.
        "hid" => [Some(1e-6), None, Some(1e-5)],
        _ => panic!("{name}"),
    }
}

#[test]
fn samples_come_through_every_protocol() {
    let until = Micros::from_millis(if cfg!(miri) { 20 } else { 10_000 });
    for name in Protocol::NAMES {
        let protocol = Protocol::named(name).unwrap();
        let mut decoder = Reader::new(&protocol).unwrap();
        let mut wire = Wire::new(tracker(), protocol);
        let mut sent = tracker();
        let (mut count, mut gazes, mut worst) = (0, 0, [0f32; 3]);
        let mut found = Vec::new();
        while let Some(chunk) = wire.poll(until) {
            decoder.feed(chunk.bytes(), chunk.arrival, &mut |event| match event {
                Event::Sample(sample) => found.push(sample),
                event => panic!("{name}: {event:?}"),
            });
            count += 1;
        }
        // The last record of some is only whole when the next one starts.
        assert!(
            found.len() + 1 >= count && count > 4,
            "{name}: {}",
            found.len()
        );
        for found in &found {
            let (_, sample) = sent.next_sample();
            if let (Some(found), Some(sent)) = (found.head.position, sample.head.position) {
                worst[0] = worst[0].max((found.value - sent.value).length());
            }
            if let (Some(found), Some(sent)) = (found.head.orientation, sample.head.orientation) {
                let off = to_vector(compose(inverse(sent.value), found.value));
                worst[1] = worst[1].max(off.length());
            }
            let Some(there) = direction(&sample) else {
                let point = found.gaze_point.is_some_and(|point| point.tracked);
                assert!(!point && direction(found).is_none(), "{name}: {found:?}");
                continue;
            };
            let turn = sample.head.orientation.unwrap().value;
            let seen = match found.gaze_point.map(|point| point.value) {
                Some(GazePoint::Raw(units)) => {
                    let place = (units - RAW_CENTRE) / RAW_PER_METRE;
                    Some(Vec3::new(place.x, -place.y, -1.0))
                }
                Some(GazePoint::Plane(point)) => {
                    let Protocol::EyeTracker(screen, _) = wire.protocol() else {
                        panic!("{name}");
                    };
                    let place = screen.corner + screen.right * point.x + screen.down * point.y;
                    let from = sample.head.position.unwrap().value;
                    Some(rotate(inverse(turn), place - from))
                }
                _ => direction(found),
            };
            if let Some(seen) = seen {
                gazes += 1;
                worst[2] = worst[2].max(angle(normalize(seen).unwrap(), there));
            }
        }
        std::println!("{name}: {count} records, {gazes} gazes, errors {worst:?}");
        let [place, turn, gaze] = expected(name);
        for (worst, most) in worst.into_iter().zip([place, turn, gaze]) {
            if let Some(most) = most {
                assert!(worst <= most, "{name}: {worst}");
            }
        }
        let first = found[0];
        assert_eq!(first.head.position.is_some(), place.is_some(), "{name}");
        if name != "hid" {
            assert_eq!(first.head.orientation.is_some(), turn.is_some(), "{name}");
        }
        assert_eq!(gazes > 0, gaze.is_some(), "{name}");
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
