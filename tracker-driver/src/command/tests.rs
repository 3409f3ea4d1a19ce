use super::*;
use crate::decoder::{DropReason, Dropped, Reply, Text};
use crate::sample::Sample;
use std::format;

const SECOND: Micros = Micros(1_000_000);

fn sample() -> Event {
    Event::Sample(Sample::arrived(Micros(0)))
}

fn reply(to: u32, result: u32) -> Event {
    Event::Message(Message::Reply(Reply { to, result }))
}

fn script() -> Script {
    Script::new()
        .send(b"R")
        .pause(Micros(500))
        .once_only()
        .send(b"c")
        .send(b"C")
        .expect(Awaited::Sample, SECOND)
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
    session.on_event(&Event::Dropped(Dropped {
        bytes: 3,
        reason: DropReason::OutOfStep,
    }));
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
    assert_eq!(failure, Failure::NoAnswer { records: 1 });

    let (failure, ..) = fail(script(), |session| {
        session.on_event(&reply(u32::from(b'O'), 3));
    });
    let refused = Failure::Refused {
        command: u32::from(b'O'),
        result: 3,
    };
    assert_eq!(failure, refused);
    assert!(
        format!("{failure}").contains("'O' with code 3"),
        "{failure}"
    );
    let binary = Failure::Refused {
        command: 0x9C,
        result: 1,
    };
    assert!(format!("{binary}").contains("0x9c"), "{binary}");
}

#[test]
fn a_device_that_answers_late_is_asked_again() {
    let mut session = Session::new(script());
    let mut now = Micros(0);
    let mut starts = 0;
    loop {
        match session.poll(now) {
            Action::Send(b"C") => {
                starts += 1;
                if starts == 3 {
                    session.on_event(&sample());
                }
            }
            Action::Send(_) => {}
            Action::Wait(until) => now = until,
            Action::Done => break,
            other => panic!("{other:?}"),
        }
    }
    assert_eq!((starts, session.tries()), (3, 2));
}

#[test]
fn replies_and_speeds_are_steps() {
    let script = Script::new()
        .send(b"a")
        .expect(Awaited::Reply(7), SECOND)
        .speed(9_600)
        .send(b"b")
        .expect(Awaited::Record, SECOND);
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
        script = script.pause(Micros(1));
    }
    assert!(!script.is_complete());
    let mut session = Session::new(script);
    assert_eq!(session.poll(Micros(0)), Action::Failed(Failure::TooLong));
    let script = Script::new().send(&[0; MOST_SCRIPT_BYTES + 1]);
    assert_eq!(
        Session::new(script).poll(Micros(0)),
        Action::Failed(Failure::TooLong)
    );
    // What ends at once, and what is all waits of no length.
    assert_eq!(Session::new(Script::new()).poll(Micros(0)), Action::Done);
    let mut script = Script::new();
    for _ in 0..MOST_STEPS {
        script = script.expect(Awaited::Sample, Micros(0));
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
    watch.on_event(
        &Event::Dropped(Dropped {
            bytes: 9,
            reason: DropReason::OutOfStep,
        }),
        Micros(1_000_005),
    );
    let wrong_speed = Some(Failure::NoRecord { bytes: 9 });
    assert_eq!(watch.trouble(Micros(1_000_006)), wrong_speed);
    watch.on_event(&sample(), Micros(2_000_000));
    assert_eq!(watch.trouble(Micros(2_999_999)), None);
    assert_eq!(watch.trouble(Micros(3_000_000)), Some(Failure::Silent));
}

/// What a script sends to a device that answers at once.
fn conversation(script: Script, mut answer: impl FnMut(&[u8]) -> Option<Event>) -> Vec<u8, 256> {
    assert!(script.is_complete());
    let mut session = Session::new(script);
    let mut sent = Vec::new();
    for _ in 0..100 {
        let event = match session.poll(Micros(0)) {
            Action::Send(bytes) => {
                sent.extend_from_slice(bytes).unwrap();
                answer(bytes)
            }
            Action::Wait(_) => Some(sample()),
            Action::Done => return sent,
            other => panic!("{other:?}"),
        };
        if let Some(event) = event {
            session.on_event(&event);
        }
    }
    panic!("it does not end");
}

#[test]
fn eye_trackers_are_started_and_stopped() {
    use crate::eye::{adhawk, asl, iscan};
    use crate::link;

    let silent = |_: &[u8]| None;
    assert_eq!(conversation(iscan::start(), silent), [0x80]);
    assert_eq!(conversation(iscan::stop(), silent), [0x81]);
    assert!(conversation(asl::start(), silent).is_empty());

    // The third byte of a request's payload is its type.
    let agreeing = |packet: &[u8]| Some(reply(u32::from(packet[5]), 0));
    let sent = conversation(adhawk::start(0b1010, 250.0), agreeing);
    let expected = [
        0xAA, 5, 0, 1, 0, 0x9C, 1, 1, // on
        0xAA, 9, 0, 2, 0, 0x9B, 14, 10, 0, 0, 0, 1, // fields
        0xAA, 9, 0, 3, 0, 0x9B, 5, 0x0F, 2, 0, 0, 1, // events
    ];
    assert_eq!(sent[..expected.len()], expected);
    let sent = conversation(adhawk::stop(), agreeing);
    assert_eq!(sent, [0xAA, 5, 0, 1, 0, 0x9C, 1, 0]);

    // What the device's end makes of it.
    let heard = |script| {
        let mut commands = std::vec::Vec::new();
        let sent = conversation(script, silent);
        link::Commands::new().feed(&sent, &mut |command| commands.push(command));
        commands
    };
    let rate = link::Command::Rate { hertz: 240 };
    assert_eq!(heard(link::start(Some(240))), [rate, link::Command::Start]);
    assert_eq!(heard(link::start(None)), [link::Command::Start]);
    assert_eq!(heard(link::stop()), [link::Command::Stop]);
}
