//! Data that stop changing.

use super::*;

/// Returns whether a gaze was refused for being stuck; forgets what happened.
fn said_stuck(run: &mut Run) -> bool {
    let stuck = |event: &Event| {
        matches!(event, Event::Rejected { reason: Rejection::Stuck { since }, .. }
            if *since > Micros(250_000))
    };
    let said = run.events.iter().any(stuck);
    run.events.clear();
    said
}

#[test]
fn a_gaze_that_is_stuck_is_as_old_as_its_last_change() {
    let mut run = Run::new(&EstimatorConfig::default());
    let stuck = |i| {
        let mut stuck = steady(0);
        stuck.head = head_only(i).head;
        Some(stuck)
    };
    assert_eq!(run.run(255, &stuck).state, State::Fresh);
    let stale = run.run(5, &stuck);
    assert_eq!(stale.state, State::Widened);
    assert_eq!(stale.gaze_age, Some(Micros(255_000)));
    assert!(said_stuck(&mut run));
    assert_eq!(run.run(945, &stuck).state, State::HeadDirection);
    // A tracker that says that the eyes are shut holds no gaze that was stuck.
    let shut = |i| {
        let mut shut = head_only(i);
        shut.left.openness = Some(0.0);
        shut.right.openness = Some(0.0);
        Some(shut)
    };
    assert_eq!(run.run(5, &shut).state, State::HeadDirection);
    assert_eq!(run.run(5, &|i| Some(steady(i))).state, State::Fresh);
    let mut trusting = Run::new(&with(|config| config.stuck_after = None));
    assert_eq!(trusting.run(5_000, &stuck).state, State::Fresh);
}

/// Where the gaze is not in the head's axes, what the tracker says is compared.
#[test]
fn a_stuck_gaze_is_known_while_the_head_turns() {
    let turning = |i: u64| {
        let turn = Quat::from_rotation_y(0.3 * libm::sinf(i as f32 * 0.01));
        with_head(Sample::arrived(Micros(0)), turn)
    };
    let on_a_screen = |point: GazePoint| {
        move |i| {
            let mut sample = turning(i);
            sample.gaze_point = Some(Reading::tracked(point));
            Some(sample)
        }
    };
    let in_tracker_axes = |i| {
        let mut sample = turning(i);
        sample.gaze_frame = GazeFrame::Tracker;
        sample.combined = looking(Vec3::new(0.1, 0.0, -1.0));
        Some(sample)
    };
    let one_eye = |i| {
        let mut sample = turning(i);
        sample.right = looking(Vec3::new(0.1, 0.0, -1.0));
        Some(sample)
    };
    let config = EstimatorConfig {
        screen: Some(Screen {
            corner: Vec3::new(-1.0, 2.0, -2.0),
            right: Vec3::X,
            down: Vec3::NEG_Y,
            size: Vec2::splat(2.0),
        }),
        ..EstimatorConfig::default()
    };
    let ways: [&dyn Fn(u64) -> Option<Sample>; 4] = [
        &on_a_screen(GazePoint::Normalized(Vec2::new(0.4, 0.6))),
        &on_a_screen(GazePoint::Plane(Vec2::new(0.4, 0.6))),
        &in_tracker_axes,
        &one_eye,
    ];
    for (i, way) in ways.into_iter().enumerate() {
        let mut run = Run::new(&config);
        assert_eq!(run.run(250, way).state, State::Fresh, "{i}");
        assert!(!said_stuck(&mut run), "{i}");
        assert_eq!(run.run(100, way).state, State::Widened, "{i}");
        assert!(said_stuck(&mut run), "{i}");
    }
}

/// A part that has moved and stops by the bit is stuck; noise is none of that.
#[test]
fn a_head_that_is_stuck_is_as_old_as_its_last_change() {
    let config = with(|config| config.eyes = Eyes::HeadOnly);
    let moving = |i: u64| {
        let mut sample = head_only(i);
        let place = Vec3::Y + Vec3::X * 1.0e-6 * (i % 3) as f32;
        sample.head.position = Some(Reading::tracked(place));
        sample
    };
    let still = moving(3).head;
    for parts in [[true, false], [false, true], [true, true]] {
        let stuck = |i| {
            let mut sample = moving(i);
            if parts[0] {
                sample.head.position = still.position;
            }
            if parts[1] {
                sample.head.orientation = still.orientation;
            }
            Some(sample)
        };
        let mut run = Run::new(&config);
        // On a stand: the last bits tremble.
        let on_a_stand = run.run(5_000, &|i| Some(moving(i)));
        assert_eq!(on_a_stand.state, State::HeadDirection);
        assert_eq!(run.run(500, &stuck).state, State::HeadDirection);
        run.events.clear();
        let lost = run.run(800, &stuck);
        assert_eq!(lost.state, State::FullQuality);
        assert!(lost.for_time.since(lost.head_time.unwrap()) >= Micros(1_295_000));
        let mut counts = [0; 2];
        for event in &run.events {
            let Event::Rejected { reason, .. } = event else {
                continue;
            };
            let Rejection::HeadStuck { part, since } = reason else {
                panic!("{reason:?}");
            };
            assert!(*since > Micros(500_000));
            counts[usize::from(*part == HeadPart::Orientation)] += 1;
        }
        assert_eq!(counts.map(|count| count > 100), parts, "{counts:?}");
        // The last bit of one number brings it back.
        let back = run.run(10, &|i| Some(moving(i)));
        assert_eq!(back.state, State::HeadDirection);
    }
    let stuck = |_| Some(head_only(3));
    let mut trusting = Run::new(&EstimatorConfig {
        head_stuck_after: None,
        ..config
    });
    trusting.run(500, &|i| Some(head_only(i)));
    assert_eq!(trusting.run(5_000, &stuck).state, State::HeadDirection);
}

/// What never moved may be on a stand; a device that reports a turn is not still.
#[test]
fn a_head_that_never_changes_is_believed_and_said_once() {
    let mut run = Run::new(&EstimatorConfig::default());
    let still = |i| Some(with_head(steady(i), Quat::IDENTITY));
    assert_eq!(run.run(5_000, &still).state, State::Fresh);
    let said = run.events.iter().filter_map(|event| match event {
        Event::HeadStill { since, .. } => Some(*since),
        Event::Rejected { reason, .. } => panic!("{reason:?}"),
        _ => None,
    });
    assert_eq!(said.collect::<Vec<_>>(), [Micros(505_000)]);
    let turning = |i: u64| {
        let mut sample = with_head(steady(i), Quat::IDENTITY);
        sample.head.angular_velocity = Some(Vec3::X * 1.0e-6 * (i % 3) as f32);
        Some(sample)
    };
    let mut run = Run::new(&EstimatorConfig::default());
    assert_eq!(run.run(5_000, &turning).state, State::Fresh);
    assert!(matches!(run.events[..], [Event::State { .. }]));
    // Eyes alone say nothing of a head.
    let mut run = Run::new(&EstimatorConfig::default());
    run.run(500, &|i| Some(head_only(i)));
    run.events.clear();
    let eyes = |i| {
        let mut sample = steady(i);
        sample.head = crate::sample::Head::default();
        Some(sample)
    };
    run.run(3_000, &eyes);
    let rejected = |event: &Event| matches!(event, Event::Rejected { .. });
    assert!(!run.events.iter().any(rejected));
}
