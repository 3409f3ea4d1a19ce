//! Eyes that are not seen, as samples and messages say it.

use super::*;
use crate::decoder::{EyeEvent, EyeEventKind, Message, Side};

fn shut(i: u64) -> Sample {
    let mut sample = steady(i);
    for eye in [&mut sample.left, &mut sample.right] {
        eye.direction = None;
        eye.openness = Some(0.0);
    }
    sample
}

#[test]
fn a_blink_holds_and_is_marked() {
    let mut run = Run::new(&EstimatorConfig::default());
    let before = run.run(300, &|i| Some(steady(i)));
    run.events.clear();
    let blink = run.run(300, &|i| Some(shut(i)));
    assert_eq!(
        (blink.state, blink.blink, blink.widen),
        (State::Hold, true, 0.0)
    );
    assert_eq!(
        blink.line_of_sight.forward(),
        before.line_of_sight.forward()
    );
    let after = run.run(20, &|i| Some(steady(i)));
    assert_eq!((after.state, after.blink), (State::Fresh, false));
    let ended = run.events.iter().find_map(|event| match event {
        Event::BlinkEnded { lasted, .. } => Some(*lasted),
        _ => None,
    });
    assert!(matches!(run.events[0], Event::BlinkStarted { .. }));
    assert_eq!(ended, Some(Micros(300_000)));
    // Longer than any blink: on with the ladder.
    run.run(50, &|i| Some(steady(i)));
    assert_eq!(run.run(850, &|i| Some(shut(i))).state, State::Hold);
    assert_eq!(run.run(100, &|i| Some(shut(i))).state, State::Widened);
    assert_eq!(run.run(400, &|i| Some(shut(i))).state, State::HeadDirection);
    // A tracker that falls silent in a blink does not hold it.
    run.run(300, &|i| Some(steady(i)));
    run.run(100, &|i| Some(shut(i)));
    let silent = run.run(400, &|i| Some(head_only(i)));
    assert_eq!(silent.state, State::Widened);
}

/// A tracker of one eye, such as an ISCAN: its points that are not tracked are a blink.
#[test]
fn points_that_are_not_tracked_are_a_blink() {
    // A thousandth of the plane a metre ahead is 1.
    let raw = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE];
    let targets = raw.map(|place| Target {
        measured: place * 1_000.0,
        direction: place.extend(-1.0),
    });
    let config = with(|config| config.combined = Calibration::fit(Model::Affine, &targets).ok());
    let sample = |i: u64, tracked| {
        let mut sample = head_only(i);
        let value = GazePoint::Raw(Vec2::new(100.0 + (i % 3) as f32, 50.0));
        sample.gaze_point = Some(Reading { value, tracked });
        Some(sample)
    };
    let mut run = Run::new(&config);
    let open = run.run(300, &|i| sample(i, true));
    assert_eq!((open.state, open.blink), (State::Fresh, false));
    let shut = run.run(700, &|i| sample(i, false));
    assert_eq!((shut.state, shut.blink), (State::Hold, true));
    let open = run.run(10, &|i| sample(i, true));
    assert_eq!((open.state, open.blink), (State::Fresh, false));
    let ended = |event: &Event| {
        matches!(
            event,
            Event::BlinkEnded {
                lasted: Micros(700_000),
                ..
            }
        )
    };
    assert!(run.events.iter().any(ended), "{:?}", run.events);
}

/// A blink begins with the sample that says so; an old gaze is not held for it.
#[test]
fn a_blink_begins_with_its_sample() {
    let nowhere = || {
        let mut sample = sample(Vec3::NEG_Z);
        for eye in [&mut sample.left, &mut sample.right] {
            eye.direction = Some(Reading::tracked(Vec3::NAN));
        }
        Some(sample)
    };
    for (silent, state) in [(0, State::Fresh), (5_000, State::FullQuality)] {
        let mut run = Run::new(&EstimatorConfig::default());
        run.run(300, &|i| Some(steady(i)));
        run.run(silent, &|i| Some(head_only(i)));
        run.events.clear();
        let begun = run.time + 5_000;
        let found = run.run(50, &|_| nowhere());
        assert_eq!(found.state, state);
        run.run(5, &|i| Some(steady(i)));
        let blinks = run.events.iter().filter_map(|event| match event {
            Event::BlinkStarted { at } => Some((*at, None)),
            Event::BlinkEnded { at, lasted } => Some((*at, Some(*lasted))),
            _ => None,
        });
        let blinks: Vec<_> = blinks.collect();
        let end = (Micros(run.time), Some(Micros(50_000)));
        assert_eq!(blinks, [(Micros(begun), None), end], "{silent}");
    }
}

/// The device says that the eyes are shut or lost, while its samples go on.
#[test]
fn eyes_that_the_device_says_are_shut_or_lost_blink() {
    use EyeEventKind::{Closed, Found, Lost, Opened};
    let say = |run: &mut Run, kind, eye| {
        let events = &mut run.events;
        let message = Message::Eyes(EyeEvent {
            kind,
            eye: Some(eye),
            device_time: None,
            duration: None,
        });
        run.estimator.on_message(&message, &mut |e| events.push(e));
    };
    let (left, right) = (Side::Left, Side::Right);
    let open = |i| Some(steady(i));
    for (begin, end) in [(Closed, Opened), (Lost, Found)] {
        let mut run = Run::new(&EstimatorConfig::default());
        run.run(300, &open);
        run.events.clear();
        // One eye is enough to look with.
        say(&mut run, begin, left);
        let one = run.run(50, &open);
        assert_eq!((one.state, one.blink), (State::Fresh, false));
        let begun = Micros(run.time);
        say(&mut run, begin, right);
        assert_eq!(run.events, [Event::BlinkStarted { at: begun }]);
        let none = run.run(300, &open);
        assert_eq!((none.state, none.blink), (State::Hold, true));
        // The other's counterpart is none.
        say(&mut run, if end == Opened { Found } else { Opened }, left);
        let other = run.run(50, &open);
        assert_eq!(other.blink, end == Found, "a found eye is open, too");
        say(&mut run, end, right);
        let back = run.run(5, &open);
        assert_eq!((back.state, back.blink), (State::Fresh, false));
        let ended = |event: &&Event| matches!(event, Event::BlinkEnded { .. });
        assert_eq!(run.events.iter().filter(ended).count(), 1);
    }
    // The word that they are open went astray: what is measured is believed again
    // after the longest blink.
    let mut run = Run::new(&EstimatorConfig::default());
    run.run(300, &open);
    say(&mut run, Closed, left);
    say(&mut run, Closed, right);
    assert!(run.run(900, &open).blink);
    let back = run.run(5, &open);
    assert_eq!((back.state, back.blink), (State::Fresh, false));
    // Those that do not count are nothing to it; and it forgets them.
    let mut run = Run::new(&with(|config| config.eyes = Eyes::Right));
    run.run(300, &open);
    say(&mut run, Lost, left);
    assert!(!run.run(50, &open).blink);
    say(&mut run, Lost, right);
    assert!(run.estimate().blink);
    run.estimator.reset();
    assert_eq!(run.run(50, &open).state, State::Fresh);
}
