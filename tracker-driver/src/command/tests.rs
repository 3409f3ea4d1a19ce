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
    assert!(!session.is_complete());
    assert_eq!(session.poll(Micros(510)), Action::Send(b"C"));
    assert!(session.is_complete());
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
    let mut asking = Script::sending(b"a");
    asking.expect(Awaited::Reply(0x9C), PATIENCE);
    let text = Event::Message(Message::Text(Text::new(b"HAT")));
    let useless = useless(DropReason::NotUnit);
    let refusal = reply(u32::from(b'O'), 3);
    for (script, bytes, event, expected) in [
        (script(), 40, None, "40 bytes came in, and no record"),
        (script(), 30, Some(text), "none of a sensor: check"),
        (asking, 32, Some(sample()), "no answer to command 0x9c:"),
        (
            script(),
            40,
            Some(useless),
            "cannot be used (no direction):",
        ),
        (
            script(),
            9,
            Some(refusal),
            "refused command 'O' with code 3",
        ),
    ] {
        let (failure, ..) = fail(script, |session| {
            session.on_bytes(bytes);
            if let Some(event) = &event {
                session.on_event(event);
            }
        });
        let said = format!("{failure}");
        assert!(said.contains(expected), "{said}");
    }
    let (command, result, meaning) = (0x9C, 1, "failed");
    let binary = Failure::Refused {
        command,
        result,
        meaning,
    };
    assert_eq!(
        format!("{binary}"),
        "the device refused command 0x9c: failed (code 1)"
    );
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
    // What is all waits of no length.
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

/// Returns what a watch says after these steps of 10 ms, each with 32 bytes and these events.
fn listen<const N: usize>(
    watch: &mut Watch,
    steps: core::ops::Range<u64>,
    events: impl Fn(u64) -> [Event; N],
) -> Option<Failure> {
    for step in steps.clone() {
        let now = Micros::from_millis(10 * step);
        watch.on_bytes(32, now);
        for event in events(step) {
            watch.on_event(&event, now);
        }
    }
    watch.trouble(Micros::from_millis(10 * steps.end - 5))
}

#[test]
fn a_watch_tells_useless_records_from_a_wrong_speed() {
    let hear = |mut watch, reason| listen(&mut watch, 0..150, |_| [useless(reason)]);
    let unusable = |records, reason| Some(Failure::Unusable { records, reason });
    for (reason, words) in [
        (DropReason::NotUnit, "sensor and transmitter"),
        (DropReason::OutOfRange, "list of items"),
        (DropReason::Field, "settings"),
        (DropReason::Unknown, "another version"),
        (DropReason::Duplicate, "repeats itself"),
    ] {
        let failure = hear(Watch::new(), reason);
        assert_eq!(failure, unusable(150, reason));
        let said = format!("{}", failure.unwrap());
        let says = |words| said.contains(words);
        assert!(
            says(words) && says(reason.name()) && !says("speed"),
            "{said}"
        );
    }
    // These are signs of a wrong speed, unless the transport delimits reports.
    for reason in [
        DropReason::Checksum,
        DropReason::Length,
        DropReason::Truncated,
    ] {
        let wrong_speed = Some(Failure::NoRecord { bytes: 150 * 32 });
        assert_eq!(hear(Watch::new(), reason), wrong_speed);
        assert_eq!(hear(Watch::of_reports(), reason), unusable(150, reason));
    }
    // Every second record is of no use.
    let reason = DropReason::NotUnit;
    let half = [sample(), useless(reason)];
    let said = listen(
        &mut Watch::new(),
        0..300,
        |step| [half[(step % 2) as usize]],
    );
    assert_eq!(said, unusable(50, reason));
}

#[test]
fn a_watch_notices_a_cut_line_and_is_content_again_when_the_line_is() {
    let at = |ms| Micros::from_millis(ms);
    // 200 records, then 9 bytes of one, then nothing.
    let mut watch = Watch::new();
    assert_eq!(listen(&mut watch, 0..200, |_| [sample()]), None);
    watch.on_bytes(9, at(1_995));
    assert_eq!(watch.trouble(at(2_980)), None);
    let cut = watch.trouble(at(2_990)).unwrap();
    assert_eq!(cut, Failure::BrokenOff { bytes: 9 });
    assert!(format!("{cut}").contains("within a record"), "{cut}");
    // More that is no record, and it is no cut.
    watch.on_bytes(7, at(3_000));
    let wrong_speed = Some(Failure::NoRecord { bytes: 16 });
    assert_eq!(watch.trouble(at(3_001)), wrong_speed);

    let mut watch = Watch::new();
    let garbage = thrown(17, DropReason::OutOfStep);
    assert_eq!(listen(&mut watch, 0..100, |_| [sample()]), None);
    let said = listen(&mut watch, 100..200, |_| [garbage, sample()]);
    assert_eq!(said, None, "not before a second is over");
    let (dropped, bytes) = (1_700, 3_200);
    let unlike = Failure::Unlike { dropped, bytes };
    assert_eq!(listen(&mut watch, 200..300, |_| [sample()]), Some(unlike));
    assert_eq!(listen(&mut watch, 300..400, |_| [sample()]), None);
    let words = format!("{unlike}");
    assert!(words.starts_with("1700 of 3200 bytes"), "{words}");

    // What is repeated, or of another version, is no other protocol.
    for reason in [DropReason::Duplicate, DropReason::Unknown] {
        let events = |step| {
            [if step % 10 == 0 {
                sample()
            } else {
                useless(reason)
            }]
        };
        assert_eq!(
            listen(&mut Watch::new(), 0..300, events),
            None,
            "{reason:?}"
        );
    }
}

/// Returns how many of 30 tenths of a second a watch of `heard` finds fault with, and its last
/// words.
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

/// Records alike in all that can be checked: the first byte alone has its highest bit set.
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
