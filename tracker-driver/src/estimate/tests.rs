mod blinks;
mod prediction;
mod stuck;

use super::*;
use crate::sample::{Eye, GazeFrame, GazePoint, Reading};
use glam::{Quat, Vec2};
use std::vec::Vec;

/// Returns the usual configuration with a change.
fn with(change: impl FnOnce(&mut EstimatorConfig)) -> EstimatorConfig {
    let mut config = EstimatorConfig::default();
    change(&mut config);
    config
}

fn with_head(mut sample: Sample, turn: Quat) -> Sample {
    sample.head.position = Some(Reading::tracked(Vec3::Y));
    sample.head.orientation = Some(Reading::tracked(turn));
    sample
}

fn looking(direction: Vec3) -> Eye {
    Eye {
        direction: Some(Reading::tracked(direction.normalize())),
        ..Eye::default()
    }
}

/// Head at (0, 1, 0) and both eyes towards `direction`.
fn sample(direction: Vec3) -> Sample {
    let mut sample = with_head(Sample::arrived(Micros(0)), Quat::IDENTITY);
    sample.left = looking(direction);
    sample.right = looking(direction);
    sample
}

/// Returns a steady gaze that is never the same twice.
fn steady(i: u64) -> Sample {
    sample(Vec3::new(0.1 + 1.0e-5 * (i % 7) as f32, 0.0, -1.0))
}

struct Run {
    estimator: GazeEstimator,
    events: Vec<Event>,
    time: u64,
}

impl Run {
    fn new(config: &EstimatorConfig) -> Self {
        Self {
            estimator: GazeEstimator::new(*config).unwrap(),
            events: Vec::new(),
            time: 1_000_000,
        }
    }

    fn push(&mut self, sample: &Sample) {
        let events = &mut self.events;
        let time = Micros(self.time);
        self.estimator.push(sample, time, &mut |e| events.push(e));
    }

    fn estimate(&mut self) -> Estimate {
        let events = &mut self.events;
        let time = Micros(self.time);
        self.estimator.estimate(time, &mut |e| events.push(e))
    }

    /// Returns samples of `make` and estimates, every 5 ms for so long.
    fn run(&mut self, ms: u64, make: &dyn Fn(u64) -> Option<Sample>) -> Estimate {
        let mut last = self.estimate();
        for _ in 0..ms / 5 {
            self.time += 5_000;
            if let Some(sample) = make(self.time / 5_000) {
                self.push(&sample);
            }
            last = self.estimate();
        }
        last
    }

    fn states(&mut self) -> Vec<(State, State)> {
        let states = self.events.iter().filter_map(|event| match event {
            Event::State { from, to, .. } => Some((*from, *to)),
            _ => None,
        });
        let states = states.collect();
        self.events.clear();
        states
    }
}

fn head_only(i: u64) -> Sample {
    let turn = Quat::from_rotation_y(1.0e-6 * (i % 5) as f32);
    with_head(Sample::arrived(Micros(0)), turn)
}

#[test]
fn the_ladder_goes_down_rung_by_rung_and_up_at_once() {
    use State::{Fresh, FullQuality, HeadDirection, Hold, Widened};
    let mut run = Run::new(&EstimatorConfig::default());
    assert_eq!(run.estimate().state, FullQuality);
    assert_eq!(run.estimate().widen, core::f32::consts::PI);
    let fresh = run.run(300, &|i| Some(steady(i)));
    assert_eq!((fresh.state, fresh.widen), (Fresh, 0.0));
    assert_eq!(run.states(), [(FullQuality, Fresh)]);
    let forward = fresh.line_of_sight.forward();
    assert!(angle(forward, Vec3::new(0.1, 0.0, -1.0).normalize()) < 1e-4);
    assert_eq!(fresh.line_of_sight.position(), Vec3::Y);
    // The eye tracker falls silent; the head tracker goes on.
    let hold = run.run(100, &|i| Some(head_only(i)));
    assert_eq!((hold.state, hold.widen), (Hold, 0.0));
    assert_eq!(hold.line_of_sight.forward(), forward);
    let widened = run.run(600, &|i| Some(head_only(i)));
    assert_eq!(widened.state, Widened);
    assert!(
        (widened.widen - 0.5 * 0.349_066).abs() < 1e-3,
        "{}",
        widened.widen
    );
    let head = run.run(600, &|i| Some(head_only(i)));
    assert_eq!(
        (head.state, head.movement),
        (HeadDirection, Movement::Unknown)
    );
    assert!(angle(head.line_of_sight.forward(), Vec3::NEG_Z) < 1e-4);
    assert_eq!(run.run(2_000, &|i| Some(head_only(i))).state, FullQuality);
    assert_eq!(
        run.states(),
        [
            (Fresh, Hold),
            (Hold, Widened),
            (Widened, HeadDirection),
            (HeadDirection, FullQuality),
        ]
    );
    assert_eq!(run.run(50, &|i| Some(steady(i))).state, Fresh);
    // Everything falls silent: without a head there is no head's direction.
    assert_eq!(run.run(2_000, &|_| None).state, FullQuality);
    assert_eq!(
        run.states(),
        [
            (FullQuality, Fresh),
            (Fresh, Hold),
            (Hold, Widened),
            (Widened, FullQuality),
        ]
    );
    // Back from each rung.
    for ms in [100, 400, 1_500] {
        run.run(50, &|i| Some(steady(i)));
        run.run(ms, &|i| Some(head_only(i)));
        let (state, _) = (run.estimate().state, run.states());
        assert_ne!(state, Fresh);
        assert_eq!(run.run(50, &|i| Some(steady(i))).state, Fresh);
        assert_eq!(run.states(), [(state, Fresh)]);
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let mut run = Run::new(&EstimatorConfig::default());
    run.run(100, &|i| Some(steady(i)));
    run.events.clear();
    let rejected = |run: &mut Run, sample: &Sample| {
        run.events.clear();
        run.time += 5_000;
        run.push(sample);
        match run.events[..] {
            [Event::Rejected { reason, .. }] => reason,
            ref events => panic!("{events:?}"),
        }
    };
    let behind = rejected(&mut run, &sample(Vec3::Z));
    let half_turn = core::f32::consts::PI;
    assert!(matches!(behind, Rejection::Eccentric { angle } if angle > half_turn - 1e-3));
    let aside = rejected(&mut run, &sample(Vec3::new(1.0, 0.0, -0.2)));
    assert!(matches!(aside, Rejection::Eccentric { .. }));
    let mut bad = steady(1);
    bad.head.orientation = Some(Reading::tracked(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)));
    assert_eq!(rejected(&mut run, &bad), Rejection::NotFinite);
    bad.head.orientation = Some(Reading::tracked(Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0)));
    assert_eq!(rejected(&mut run, &bad), Rejection::NotFinite);
    let mut raw = head_only(1);
    raw.gaze_point = Some(Reading::tracked(GazePoint::Raw(Vec2::ONE)));
    assert_eq!(rejected(&mut run, &raw), Rejection::Uncalibrated);
    // A time before that of the newest gaze.
    run.events.clear();
    run.time -= 5_001;
    run.push(&steady(3));
    let refused = |event: &Event| {
        matches!(event, Event::Rejected { reason, .. }
        if *reason == Rejection::NotNewer)
    };
    assert_eq!(run.events.iter().filter(|e| refused(e)).count(), 3);
    // None of it has moved the gaze.
    let forward = run.estimate().line_of_sight.forward();
    assert!(angle(forward, Vec3::new(0.1, 0.0, -1.0).normalize()) < 0.02);
}

fn forward(config: &EstimatorConfig, sample: &Sample) -> Vec3 {
    let mut run = Run::new(config);
    run.push(sample);
    run.estimate().line_of_sight.forward()
}

#[test]
fn the_eyes_that_are_asked_for_count() {
    let (left, right) = (Vec3::new(-0.2, 0.0, -1.0), Vec3::new(0.3, 0.0, -1.0));
    let mut sample = sample(left);
    sample.right = looking(right);
    let of = |eyes| with(|config| config.eyes = eyes);
    let close = |a: Vec3, b: Vec3| assert!(angle(a, b.normalize()) < 1e-6, "{a} {b}");
    close(forward(&of(Eyes::Left), &sample), left);
    close(forward(&of(Eyes::Right), &sample), right);
    let both = left.normalize() + right.normalize();
    close(forward(&of(Eyes::Combined), &sample), both);
    close(forward(&of(Eyes::HeadOnly), &sample), Vec3::NEG_Z);
    // The one that is seen, and the device's own combination.
    sample.left.direction = None;
    close(forward(&of(Eyes::Combined), &sample), right);
    sample.combined = looking(Vec3::new(0.0, 0.2, -1.0));
    close(
        forward(&of(Eyes::Combined), &sample),
        Vec3::new(0.0, 0.2, -1.0),
    );
    // What the device only guesses is no gaze.
    let mut run = Run::new(&of(Eyes::Right));
    sample.right.direction = Some(Reading::held(right.normalize()));
    run.push(&sample);
    assert_eq!(run.estimate().gaze_time, None);
}

#[test]
fn gaze_gets_into_the_room() {
    let close = |a: Vec3, b: Vec3| assert!(angle(a, b.normalize()) < 1e-5, "{a} {b}");
    // The tracker is turned to the left and the head to the left of that.
    let quarter = Quat::from_rotation_y(0.5);
    let config = EstimatorConfig {
        room_from_tracker: RoomFromTracker {
            position: Vec3::new(0.0, 0.0, 2.0),
            orientation: quarter,
        },
        ..EstimatorConfig::default()
    };
    let mut in_head = sample(Vec3::new(0.1, 0.2, -1.0));
    in_head.head.orientation = Some(Reading::tracked(quarter));
    let expected = quarter * (quarter * Vec3::new(0.1, 0.2, -1.0));
    close(forward(&config, &in_head), expected);
    // A tracker on a desk gives directions in its own axes.
    in_head.gaze_frame = GazeFrame::Tracker;
    let ahead = Vec3::new(-0.4, 0.2, -1.0);
    in_head.left = looking(ahead);
    in_head.right = looking(ahead);
    close(forward(&config, &in_head), quarter * ahead);
    // A point on a screen 2 m ahead, seen from (0, 1, 0).
    let config = EstimatorConfig {
        screen: Some(Screen {
            corner: Vec3::new(-1.0, 2.0, -2.0),
            right: Vec3::X,
            down: Vec3::NEG_Y,
            size: Vec2::new(2.0, 1.0),
        }),
        ..EstimatorConfig::default()
    };
    for point in [
        GazePoint::Plane(Vec2::new(1.5, 0.25)),
        GazePoint::Normalized(Vec2::new(0.75, 0.25)),
    ] {
        let mut sample = head_only(0);
        sample.gaze_point = Some(Reading::tracked(point));
        close(forward(&config, &sample), Vec3::new(0.5, 0.75, -2.0));
    }
    // What was measured, of an eye and of a point, is where its direction
    // meets the plane ahead; a calibration of the screen's points turns that.
    let mut on_screen = head_only(0);
    let point = GazePoint::Plane(Vec2::new(1.5, 0.25));
    on_screen.gaze_point = Some(Reading::tracked(point));
    let head = HeadPose {
        position: Vec3::Y,
        ..HeadPose::IDENTITY
    };
    let seen = Measured::of(&config, &on_screen, &head).combined.unwrap();
    assert!((seen - Vec2::new(0.25, 0.375)).length() < 1e-6, "{seen}");
    let eyes = Measured::of(&config, &sample(Vec3::new(0.2, 0.1, -2.0)), &head);
    assert_eq!(eyes.left, eyes.right);
    assert!((eyes.left.unwrap() - Vec2::new(0.1, 0.05)).length() < 1e-6);
    assert_eq!(eyes.combined, None);
    let double = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| Target {
        measured: Vec2::new(x, y),
        direction: Vec3::new(2.0 * x, 2.0 * y, -1.0),
    });
    let corrected = EstimatorConfig {
        combined: Calibration::fit(Model::Affine, &double).ok(),
        ..config
    };
    close(forward(&corrected, &on_screen), Vec3::new(0.5, 0.75, -1.0));
}

#[test]
fn a_calibration_turns_points_and_directions() {
    let close = |a: Vec3, b: Vec3| assert!(angle(a, b.normalize()) < 1e-5, "{a} {b}");
    // Raw units, by a calibration.
    let targets = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(x, y)| Target {
        measured: Vec2::new(100.0 + 50.0 * x, 200.0 - 80.0 * y),
        direction: Vec3::new(0.5 * x, 0.25 * y, -1.0),
    });
    let combined = Calibration::fit(Model::Affine, &targets).ok();
    let config = with(|config| config.combined = combined);
    let mut sample = head_only(0);
    let point = GazePoint::Raw(Vec2::new(125.0, 160.0));
    sample.gaze_point = Some(Reading::tracked(point));
    close(forward(&config, &sample), Vec3::new(0.25, 0.125, -1.0));
    // A calibration turns an eye's directions too.
    let shifted = targets.map(|t| Target {
        measured: plane_of(t.direction + Vec3::X * 0.05).unwrap(),
        ..t
    });
    let left = Calibration::fit(Model::Affine, &shifted).ok();
    let config = EstimatorConfig {
        left,
        eyes: Eyes::Left,
        ..EstimatorConfig::default()
    };
    let seen = self::sample(Vec3::new(0.25, 0.1, -1.0));
    close(forward(&config, &seen), Vec3::new(0.2, 0.1, -1.0));
}

#[test]
fn a_head_that_turns_under_a_steady_gaze_is_no_saccade() {
    // 100°/s, the eyes turning against it.
    let mut run = Run::new(&EstimatorConfig::default());
    let target = Vec3::new(0.05, 0.0, -1.0).normalize();
    let make = |i: u64| {
        let turn = Quat::from_rotation_y(1.745 * 0.005 * ((i % 200) as f32 - 30.0) * 0.5);
        let mut sample = sample(turn.inverse() * target);
        sample.head.orientation = Some(Reading::tracked(turn));
        Some(sample)
    };
    run.time = 5_000 * 200;
    let estimate = run.run(300, &make);
    assert_eq!(estimate.movement, Movement::Fixation);
    assert!(angle(estimate.line_of_sight.forward(), target) < 1e-5);
    assert!(
        !run.events
            .iter()
            .any(|e| matches!(e, Event::SaccadeStarted { .. }))
    );
}

#[test]
fn saccades_are_told_and_land_where_they_do() {
    let mut run = Run::new(&EstimatorConfig::default());
    let amplitude = 0.175f32;
    let duration = 0.021 + 0.126_05 * amplitude;
    let onset = 1_200_000;
    let truth = |time: u64| {
        let u = (time as f32 - onset as f32) * 1.0e-6 / duration;
        let x = amplitude * minimum_jerk(u).0 + 1.0e-5 * (time / 2_000 % 5) as f32;
        along(Vec3::NEG_Z, Vec3::X * x)
    };
    let mut landing = None;
    while run.time < 1_300_000 {
        run.time += 2_000;
        let sample = sample(truth(run.time));
        run.push(&sample);
        let estimate = run.estimate();
        // 20 ms before the end.
        if run.time == 1_222_000 {
            landing = estimate.landing;
            assert_eq!(estimate.movement, Movement::Saccade);
        }
    }
    let landing = landing.unwrap();
    let end = along(Vec3::NEG_Z, Vec3::X * amplitude);
    assert!(angle(landing.direction, end) < 0.02, "{landing:?}");
    assert!(landing.time.0.abs_diff(onset + (duration * 1.0e6) as u64) < 4_000);
    let [start, ended] = run.events[..]
        .iter()
        .filter(|e| matches!(e, Event::SaccadeStarted { .. } | Event::SaccadeEnded { .. }))
        .collect::<Vec<_>>()[..]
    else {
        panic!("{:?}", run.events);
    };
    assert!(matches!(start, Event::SaccadeStarted { at } if at.0 < onset + 16_000));
    let Event::SaccadeEnded { saccade, at } = ended else {
        panic!("{ended:?}");
    };
    assert!(at.0 < onset + 80_000, "{at:?}");
    assert!((saccade.amplitude - amplitude).abs() < 0.004, "{saccade:?}");
    assert!((saccade.duration - duration).abs() < 0.004, "{saccade:?}");
    let peak = 1.875 * amplitude / duration;
    assert!(
        (saccade.peak_speed - peak).abs() < 0.1 * peak,
        "{saccade:?}"
    );
    assert_eq!(run.estimate().movement, Movement::Fixation);
}

#[test]
fn a_reset_forgets_all() {
    let mut run = Run::new(&EstimatorConfig::default());
    run.run(100, &|i| Some(steady(i)));
    run.estimator.reset();
    let estimate = run.estimate();
    assert_eq!(estimate.state, State::FullQuality);
    assert_eq!((estimate.gaze_time, estimate.head_time), (None, None));
    assert_eq!(run.estimator.state(), State::FullQuality);
    // A target that moved, too: 10° a second.
    let moving = |i: u64| sample(Vec3::new(8.7e-4 * (i % 100) as f32, 0.0, -1.0));
    run.time = 1_000_000;
    run.run(300, &|i| Some(moving(i)));
    assert_ne!(run.estimator.eyes.followed(), Vec3::ZERO);
    run.estimator.reset();
    assert_eq!(run.estimator.eyes.followed(), Vec3::ZERO);
}

/// An estimate is never of the past: what is known is newer.
#[test]
fn a_time_before_the_newest_data_is_theirs() {
    let mut run = Run::new(&EstimatorConfig::default());
    let turning = |i: u64| {
        let turn = Quat::from_rotation_y(0.5e-2 * (i % 1_000) as f32);
        Some(with_head(steady(i), turn))
    };
    let newest = run.run(300, &turning);
    assert_eq!(newest.for_time, Micros(run.time));
    for back in [1, 1_000, 60_000, 100_000, 1_200_000] {
        let past = run.estimator.estimate(Micros(run.time - back), &mut |_| {});
        assert_eq!(past, newest, "{back} µs");
    }
}

#[test]
fn of_several_records_at_one_time_the_newest_counts() {
    let mut bursts = Run::new(&EstimatorConfig::default());
    let mut single = Run::new(&EstimatorConfig::default());
    let looks = |i: u64| {
        let gaze = Vec3::new(0.1 + 1.0e-4 * i as f32, 0.0, -1.0);
        with_head(sample(gaze), Quat::from_rotation_y(1.0e-3 * i as f32))
    };
    for burst in 0..40 {
        for run in [&mut bursts, &mut single] {
            run.time += 20_000;
        }
        for record in 0..4 {
            bursts.push(&looks(4 * burst + record));
        }
        single.push(&looks(4 * burst + 3));
        assert_eq!(bursts.estimate(), single.estimate(), "{burst}");
    }
    let refused = |e: &Event| matches!(e, Event::Rejected { .. });
    assert!(!bursts.events.iter().any(refused), "{:?}", bursts.events);
    // What is older is still refused.
    bursts.time -= 1;
    bursts.push(&looks(0));
    assert!(bursts.events.iter().any(refused));
}

#[test]
fn of_two_stations_one_is_the_viewers_head() {
    let place = |sensor: u8| Vec3::X * f32::from(sensor);
    let config = |sensors| with(|config| config.sensors = sensors);
    for (sensors, taken) in [(Sensors::First, 2), (Sensors::Only(1), 1)] {
        let mut run = Run::new(&config(sensors));
        for i in 0..40 {
            for sensor in [2, 1] {
                run.time += 4_000;
                let mut sample = head_only(i);
                sample.sensor = sensor;
                sample.head.position = Some(Reading::tracked(place(sensor)));
                run.push(&sample);
                // Before the first sample of its own the head is at rest.
                if i > 0 {
                    let head = run.estimate().head.position;
                    assert!((head - place(taken)).length() < 1e-6, "{head}");
                }
            }
        }
        let said = run.events.iter().filter_map(|event| match event {
            Event::OtherSensor { taken, ignored, .. } => Some((*taken, *ignored)),
            _ => None,
        });
        assert_eq!(said.collect::<Vec<_>>(), [(taken, 3 - taken)]);
    }
    let mut all = Run::new(&config(Sensors::All));
    let mut sample = head_only(0);
    sample.sensor = 9;
    all.push(&sample);
    assert_eq!(all.events, []);
}
