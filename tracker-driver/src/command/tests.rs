use super::*;
use crate::decoder::{Decoder, DropReason, Text};
use crate::mock::{Faults, FaultsConfig, Source, Wire};
use crate::protocol::{Protocol, Reader};
use crate::sample::Sample;
use crate::testing::{reply, serial_lines, thrown, tracker};
use std::format;

fn sample() -> Event {
    Event::Sample(Sample::arrived(Micros(0)))
}

fn useless(reason: DropReason) -> Event {
    thrown(32, reason)
}

fn script() -> Script {
    let mut script = Script::sending(b"R");
    script.pause(Micros(500)).once_only();
    script.send(b"c").send(b"C");
    script.expect(Awaited::Sample, PATIENCE);
    script
}

/// Whether samples count at these times of a device that says nothing.
fn believed(setting_up: SettingUp, session: &Session, times: [u64; 3]) -> [bool; 3] {
    times.map(|now| setting_up.is_over(session.has_said_all(), Micros(now)))
}

#[test]
fn a_device_that_takes_long_is_believed_in_the_end() {
    let session = Session::new(script());
    let mut setting_up = SettingUp::new();
    for now in [1_000, 2_000] {
        // The first time counts.
        setting_up.begin(Micros(now));
        let times = [999, 800_999, 801_000];
        assert_eq!(
            believed(setting_up, &session, times),
            [false, false, true],
            "{now}"
        );
    }
    let reset = SettingUp::since(Micros(1_000), Micros::from_millis(10_000));
    assert_eq!(
        believed(reset, &session, [801_000, 10_800_999, 10_801_000]),
        [false, false, true]
    );
}

#[test]
fn a_script_is_played_by_the_callers_clock() {
    let mut session = Session::new(script());
    assert_eq!(session.poll(Micros(10)), Action::Send(b"R"));
    for now in [10, 200, 509] {
        assert_eq!(session.poll(Micros(now)), Action::Wait(Micros(510)));
    }
    assert_eq!(session.poll(Micros(510)), Action::Send(b"c"));
    // A sample of before the last command does not count.
    session.on_event(&sample());
    assert!(!session.has_said_all());
    assert_eq!(session.poll(Micros(510)), Action::Send(b"C"));
    assert!(session.has_said_all());
    assert_eq!(session.poll(Micros(511)), Action::Wait(Micros(1_000_511)));
    session.on_bytes(32);
    session.on_event(&thrown(3, DropReason::OutOfStep));
    assert_eq!(session.poll(Micros(600)), Action::Wait(Micros(1_000_511)));
    session.on_event(&sample());
    assert_eq!(session.poll(Micros(700)), Action::Done);
    assert_eq!(session.poll(Micros(800)), Action::Done);
    assert_eq!(session.tries(), 0);
}

/// Plays a script against a device that answers each command with `answer`.
fn fail(script: Script, mut answer: impl FnMut(&mut Session)) -> (Failure, Micros, usize) {
    let mut session = Session::new(script);
    let mut now = Micros(0);
    let mut sent = 0;
    for _ in 0..100 {
        match session.poll(now) {
            Action::Send(_) => {
                sent += 1;
                answer(&mut session);
            }
            Action::Wait(until) => now = until,
            Action::Failed(failure) => {
                assert_eq!(session.poll(now), Action::Failed(failure));
                return (failure, now, sent);
            }
            other => panic!("{other:?}"),
        }
    }
    panic!("it neither ends nor fails");
}

#[test]
fn failures_say_what_is_wrong() {
    // Three tries of a second each; the reset is sent once.
    let (failure, when, sent) = fail(script(), |_| {});
    assert_eq!(failure, Failure::Silent);
    assert_eq!((when, sent), (Micros(3_000_500), 1 + 3 * 2));

    let (failure, ..) = fail(script(), |session| session.on_bytes(40));
    assert_eq!(failure, Failure::NoRecord { bytes: 40 });
    assert!(format!("{failure}").contains("baud"), "{failure}");

    let text = Event::Message(Message::Text(Text::new(b"HAT")));
    let (failure, ..) = fail(script(), |session| {
        session.on_bytes(30);
        session.on_event(&text);
    });
    let awaited = Awaited::Sample;
    assert_eq!(
        failure,
        Failure::NoAnswer {
            records: 1,
            awaited
        }
    );
    assert!(
        format!("{failure}").contains("none of a sensor"),
        "{failure}"
    );

    // It sends samples and answers nothing.
    let mut asking = Script::sending(b"a");
    asking.expect(Awaited::Reply(0x9C), PATIENCE);
    let (failure, ..) = fail(asking, |session| session.on_event(&sample()));
    let said = format!("{failure}");
    assert!(said.contains("no answer to command 0x9c"), "{said}");
    assert!(!said.contains("items"), "{said}");

    let (failure, ..) = fail(script(), |session| {
        session.on_bytes(40);
        session.on_event(&useless(DropReason::NotUnit));
    });
    let reason = DropReason::NotUnit;
    assert_eq!(failure, Failure::Unusable { records: 1, reason });

    let (failure, ..) = fail(script(), |session| {
        session.on_event(&reply(u32::from(b'O'), 3));
    });
    let refused = Failure::Refused {
        command: u32::from(b'O'),
        result: 3,
        meaning: "",
    };
    assert_eq!(failure, refused);
    assert!(
        format!("{failure}").contains("'O' with code 3"),
        "{failure}"
    );
    let binary = Failure::Refused {
        command: 0x9C,
        result: 1,
        meaning: "failed",
    };
    let said = "the device refused command 0x9c: failed (code 1)";
    assert_eq!(format!("{binary}"), said);
}

#[test]
fn replies_and_speeds_are_steps() {
    let mut script = Script::sending(b"a");
    script
        .expect(Awaited::Reply(7), PATIENCE)
        .speed(9_600)
        .send(b"b")
        .expect(Awaited::Record, PATIENCE);
    let mut session = Session::new(script);
    assert_eq!(session.poll(Micros(0)), Action::Send(b"a"));
    session.on_event(&reply(6, 0));
    assert!(matches!(session.poll(Micros(0)), Action::Wait(_)));
    session.on_event(&reply(7, 2));
    assert!(matches!(session.poll(Micros(0)), Action::Wait(_)));
    session.on_event(&reply(7, 0));
    assert_eq!(session.poll(Micros(0)), Action::Speed(9_600));
    assert_eq!(session.poll(Micros(0)), Action::Send(b"b"));
    session.on_event(&Event::Message(Message::Text(Text::new(b"x"))));
    assert_eq!(session.poll(Micros(0)), Action::Done);
}

#[test]
fn a_script_that_has_no_room_is_refused() {
    let mut script = Script::new();
    for _ in 0..=MOST_STEPS {
        script.pause(Micros(1));
    }
    assert!(!script.is_complete());
    let mut session = Session::new(script);
    assert_eq!(session.poll(Micros(0)), Action::Failed(Failure::TooLong));
    let script = Script::sending(&[0; MOST_SCRIPT_BYTES + 1]);
    assert_eq!(
        Session::new(script).poll(Micros(0)),
        Action::Failed(Failure::TooLong)
    );
    // What ends at once, and what is all waits of no length.
    assert_eq!(Session::new(Script::new()).poll(Micros(0)), Action::Done);
    let mut script = Script::new();
    for _ in 0..MOST_STEPS {
        script.expect(Awaited::Sample, Micros(0));
    }
    let failed = Action::Failed(Failure::Silent);
    assert_eq!(Session::new(script).poll(Micros(0)), failed);
}

#[test]
fn a_watch_notices_silence_and_the_wrong_speed() {
    let mut watch = Watch::new();
    assert_eq!(watch.trouble(Micros(5)), None);
    assert_eq!(watch.trouble(Micros(1_000_004)), None);
    assert_eq!(watch.trouble(Micros(1_000_005)), Some(Failure::Silent));
    watch.on_bytes(9, Micros(1_000_005));
    watch.on_event(&thrown(9, DropReason::OutOfStep), Micros(1_000_005));
    let wrong_speed = Some(Failure::NoRecord { bytes: 9 });
    assert_eq!(watch.trouble(Micros(1_000_006)), wrong_speed);
    watch.on_event(&sample(), Micros(2_000_000));
    assert_eq!(watch.trouble(Micros(2_999_999)), None);
    assert_eq!(watch.trouble(Micros(3_000_000)), Some(Failure::Silent));
}

#[test]
fn a_watch_tells_useless_records_from_a_wrong_speed() {
    let at = |ms| Micros::from_millis(ms);
    let listen = |watch: &mut Watch, event: &Event| {
        let mut said = None;
        for step in 0..150 {
            watch.on_bytes(32, at(10 * step));
            watch.on_event(event, at(10 * step));
            said = watch.trouble(at(10 * step + 5));
        }
        said
    };
    for (reason, words) in [
        (DropReason::NotUnit, "sensor and transmitter"),
        (DropReason::OutOfRange, "list of items"),
        (DropReason::Field, "settings"),
        (DropReason::Unknown, "another version"),
        (DropReason::Duplicate, "repeats itself"),
    ] {
        let said = listen(&mut Watch::new(), &useless(reason)).unwrap();
        assert_eq!(
            said,
            Failure::Unusable {
                records: 150,
                reason
            }
        );
        let said = format!("{said}");
        assert!(
            said.contains(words) && said.contains(reason.name()),
            "{said}"
        );
        assert!(!said.contains("speed"), "{said}");
    }
    // These are signs of a wrong speed, unless the transport delimits reports.
    for reason in [
        DropReason::Checksum,
        DropReason::Length,
        DropReason::Truncated,
    ] {
        let said = listen(&mut Watch::new(), &useless(reason));
        assert_eq!(said, Some(Failure::NoRecord { bytes: 150 * 32 }));
        let said = listen(&mut Watch::of_reports(), &useless(reason));
        assert_eq!(
            said,
            Some(Failure::Unusable {
                records: 150,
                reason
            })
        );
    }
}

#[test]
fn a_watch_tells_half_the_records_and_a_cut_line_from_a_wrong_speed() {
    let at = |ms| Micros::from_millis(ms);
    // Every second record is of no use.
    let mut watch = Watch::new();
    for step in 0..300 {
        watch.on_bytes(32, at(10 * step));
        let event = if step % 2 == 0 {
            sample()
        } else {
            useless(DropReason::NotUnit)
        };
        watch.on_event(&event, at(10 * step));
    }
    let reason = DropReason::NotUnit;
    assert_eq!(
        watch.trouble(at(2_995)),
        Some(Failure::Unusable {
            records: 50,
            reason
        })
    );
    // 200 records, then 9 bytes of one, then nothing.
    let mut watch = Watch::new();
    for step in 0..200 {
        watch.on_bytes(32, at(10 * step));
        watch.on_event(&sample(), at(10 * step));
    }
    watch.on_bytes(9, at(1_995));
    assert_eq!(watch.trouble(at(2_980)), None);
    let cut = watch.trouble(at(2_990)).unwrap();
    assert_eq!(cut, Failure::BrokenOff { bytes: 9 });
    assert!(format!("{cut}").contains("within a record"), "{cut}");
    // More that is no record, and it is no cut.
    watch.on_bytes(7, at(3_000));
    assert_eq!(
        watch.trouble(at(3_001)),
        Some(Failure::NoRecord { bytes: 16 })
    );
}
/// What a watch says of a line on which one device speaks and another is
/// listened to: for how many of 30 tenths of a second something was wrong.
fn watched(spoken: &Protocol, heard: &Protocol, corrupt: f32) -> (usize, Option<Failure>) {
    let tracker = tracker(crate::mock::TrackerConfig::default(), 5);
    let faults = FaultsConfig {
        corrupt,
        ..FaultsConfig::default()
    };
    let wire = Wire::new(tracker, spoken.clone());
    let mut line = Faults::new(wire, faults, 5).unwrap();
    let mut reader = Reader::new(heard).unwrap();
    let mut watch = Watch::new();
    let (mut wrong, mut last) = (0, None);
    for tenth in 1..=30 {
        let now = Micros::from_millis(100 * tenth);
        while let Some(chunk) = line.poll(now) {
            watch.on_bytes(chunk.bytes().len(), chunk.arrival);
            reader.feed(chunk.bytes(), chunk.arrival, &mut |event| {
                watch.on_event(&event, chunk.arrival);
            });
        }
        last = watch.trouble(now);
        wrong += usize::from(last.is_some());
    }
    (wrong, last)
}

/// Records alike in all that can be checked: twelve or six bytes, of which the
/// first alone has its highest bit set. What a Flock sends it is told.
const ALIKE: [(&str, &str); 3] = [
    ("asl", "PositionAngles"),
    ("Angles", "Position"),
    ("Position", "Angles"),
];

#[test]
#[cfg_attr(miri, ignore = "minutes")]
fn a_watch_tells_another_protocol_from_damage() {
    let mut silent = std::vec::Vec::new();
    for (spoken, sent) in serial_lines() {
        for (heard, read) in serial_lines() {
            let (wrong, last) = watched(&sent, &read, 0.0);
            if sent == read {
                assert_eq!((wrong, last), (0, None), "{spoken}");
                let damaged = watched(&sent, &read, 0.05);
                assert_eq!(damaged, (0, None), "{spoken}, damaged");
            } else if wrong < 19 || last.is_none() {
                silent.push((spoken.clone(), heard, wrong));
            }
        }
    }
    assert!(
        silent
            .iter()
            .all(|(spoken, heard, _)| ALIKE.contains(&(spoken, heard))),
        "{silent:?}"
    );
    assert_eq!(silent.len(), ALIKE.len());
}

#[test]
fn a_watch_is_content_again_when_the_line_is() {
    let mut watch = Watch::new();
    let mut second = |from: u64, dropped: u32| {
        let mut said = None;
        for step in 0..100 {
            let now = Micros::from_millis(1_000 * from + 10 * step);
            said = watch.trouble(now);
            watch.on_bytes(20, now);
            if dropped > 0 {
                watch.on_event(&thrown(dropped, DropReason::OutOfStep), now);
            }
            watch.on_event(&sample(), now);
        }
        said
    };
    assert_eq!(second(0, 0), None);
    assert_eq!(second(1, 11), None, "not before a second is over");
    let unlike = Failure::Unlike {
        dropped: 1_100,
        bytes: 2_000,
    };
    assert_eq!(second(2, 0), Some(unlike));
    assert_eq!(second(3, 0), None);
    let words = std::format!("{unlike}");
    assert!(
        words.contains("1100 of 2000 bytes") && words.contains("settings"),
        "{words}"
    );
}

#[test]
fn what_is_repeated_or_of_another_version_is_no_other_protocol() {
    for reason in [DropReason::Duplicate, DropReason::Unknown] {
        let mut watch = Watch::new();
        for step in 0..300 {
            let now = Micros::from_millis(10 * step);
            assert_eq!(watch.trouble(now), None, "{reason:?}");
            watch.on_bytes(20, now);
            let event = if step % 10 == 0 {
                sample()
            } else {
                thrown(20, reason)
            };
            watch.on_event(&event, now);
        }
    }
}
