//! The tracker driver: estimates, and what the decoders' records are made of.

use super::numbers::{Case, Numbers, finite, finite_or_error};
use glam::{Quat, Vec2, Vec3};
use shisen_core::gaze::HeadPose;
use shisen_tracker::clock::{ClockConfig, ClockEstimator};
use shisen_tracker::command::{Session, Watch};
use shisen_tracker::decoder::Event;
use shisen_tracker::estimate::{
    Calibration, EstimatorConfig, Eyes, FallbackConfig, Filter, GazeEstimator, GazePrediction,
    HeadConfig, Measured, Model, OneEuroConfig, PursuitConfig, RoomFromTracker, SaccadeConfig,
    Screen, Target, plane_of,
};
use shisen_tracker::eye::adhawk;
use shisen_tracker::head::axes::Axes;
use shisen_tracker::sample::{Eye, GazeFrame, GazePoint, Head, Pupil, Reading, Sample};
use shisen_tracker::time::{DeviceTime, Micros};

pub(super) const CASES: &[(&str, Case)] = &[
    ("tracker clock::ClockEstimator::stamp", |n| {
        let mut clock = ClockEstimator::new(ClockConfig::default()).expect("the default");
        let sample = a_sample(n);
        assert!(clock.stamp(&sample, &mut |_| {}).time <= sample.arrival);
    }),
    ("tracker command::watch::Watch::on_event", |n| {
        let mut watch = Watch::new();
        watch.on_event(&Event::Sample(a_sample(n)), Micros(5));
        assert_eq!(watch.trouble(Micros(6)), None);
    }),
    ("tracker command::Session::new", |n| {
        let mut session = Session::new(adhawk::start(0xff, n.next(60.0)));
        finite(&session.poll(Micros(1)));
    }),
    ("tracker command::Session::on_event", |n| {
        let mut session = Session::new(adhawk::start(0xff, 60.0));
        session.on_event(&Event::Sample(a_sample(n)));
        finite(&session.poll(Micros(1)));
    }),
    ("tracker estimate::calibration::plane_of", |n| {
        finite(&plane_of(n.vec3([0.1, 0.2, -1.0])));
    }),
    ("tracker estimate::calibration::Calibration::fit", |n| {
        let targets = targets(n);
        for model in [Model::Affine, Model::SecondOrder] {
            if let Some(fitted) = finite_or_error(Calibration::fit(model, &targets)) {
                for target in &targets {
                    is_direction(fitted.direction(target.measured));
                }
            }
        }
    }),
    (
        "tracker estimate::calibration::Calibration::direction",
        |n| {
            let measured = n.vec2([0.1, 0.2]);
            for calibration in calibrations() {
                is_direction(calibration.direction(measured));
            }
        },
    ),
    (
        "tracker estimate::calibration::Calibration::residual_of",
        |n| {
            let targets = targets(n);
            for calibration in calibrations() {
                finite(&calibration.residual_of(&targets));
            }
        },
    ),
    ("tracker estimate::config::Screen::place", |n| {
        let screen = a_screen(n);
        let place = screen.place(n.vec2([0.5, 0.4]));
        if n.within(1.0e18) {
            finite(&place);
        }
    }),
    ("tracker estimate::config::RoomFromTracker::place", |n| {
        let room = room(n);
        let place = room.place(n.vec3([0.1, 0.2, 0.3]));
        if n.within(1.0e9) {
            finite(&place);
        }
    }),
    (
        "tracker estimate::config::RoomFromTracker::orientation",
        |n| {
            let room = room(n);
            let turn = room.orientation(n.quat());
            finite(&turn);
            assert!(turn.is_none_or(|turn| (turn.length() - 1.0).abs() < 1.0e-5));
        },
    ),
    ("tracker estimate::gaze::Measured::of", |n| {
        let config = EstimatorConfig {
            screen: Some(a_screen(n)),
            ..EstimatorConfig::default()
        };
        let sample = a_sample(n);
        let head = a_head_pose(n);
        finite(&Measured::of(&config, &sample, &head));
    }),
    ("tracker estimate::GazeEstimator::new", |n| {
        if let Ok(mut gaze) = GazeEstimator::new(a_config(n)) {
            estimates(&mut gaze, &[Sample::arrived(Micros(1_000))]);
        }
    }),
    ("tracker estimate::GazeEstimator::with_histories", |n| {
        if let Ok(mut gaze) = GazeEstimator::<4, 8>::with_histories(a_config(n)) {
            estimates(&mut gaze, &[Sample::arrived(Micros(1_000))]);
        }
    }),
    ("tracker estimate::GazeEstimator::push", |n| {
        let samples = [a_sample(n), a_sample(n), a_sample(n)];
        let screen = EstimatorConfig {
            screen: Some(SCREEN),
            ..EstimatorConfig::default()
        };
        for config in [EstimatorConfig::default(), screen] {
            let mut gaze = GazeEstimator::new(config).expect("a configuration");
            estimates(&mut gaze, &samples);
        }
    }),
    ("tracker head::axes::Axes::new", |n| {
        finite_or_error(Axes::new(n.quat(), n.quat()));
    }),
    ("tracker head::axes::Axes::position", |n| {
        turns(n, |axes, n| {
            format!("{:?}", axes.position(n.vec3([0.1, 0.2, 0.3])))
        });
    }),
    ("tracker head::axes::Axes::orientation", |n| {
        turns(n, |axes, n| format!("{:?}", axes.orientation(n.quat())));
    }),
    ("tracker head::axes::Axes::device_position", |n| {
        turns(n, |axes, n| {
            format!("{:?}", axes.device_position(n.vec3([0.1, 0.2, 0.3])))
        });
    }),
    ("tracker head::axes::Axes::device_orientation", |n| {
        turns(n, |axes, n| {
            format!("{:?}", axes.device_orientation(n.quat()))
        });
    }),
    // A reading holds what it is given: its maker sees to the number.
    ("tracker sample::Reading::tracked", |n| {
        let value = n.next(1.0);
        let reading = Reading::tracked(value);
        assert!(reading.tracked && reading.value.to_bits() == value.to_bits());
    }),
    ("tracker sample::Reading::held", |n| {
        let value = n.next(1.0);
        let reading = Reading::held(value);
        assert!(!reading.tracked && reading.value.to_bits() == value.to_bits());
    }),
];

const SCREEN: Screen = Screen {
    corner: Vec3::new(-0.5, 0.4, -1.0),
    right: Vec3::X,
    down: Vec3::NEG_Y,
    size: Vec2::new(1.0, 0.8),
};

pub(super) fn a_screen(n: &mut Numbers) -> Screen {
    Screen {
        corner: n.vec3(SCREEN.corner.to_array()),
        right: n.vec3(SCREEN.right.to_array()),
        down: n.vec3(SCREEN.down.to_array()),
        size: n.vec2(SCREEN.size.to_array()),
    }
}

fn room(n: &mut Numbers) -> RoomFromTracker {
    RoomFromTracker {
        position: n.vec3([1.0, 2.0, 3.0]),
        orientation: n.quat(),
    }
}

fn a_head_pose(n: &mut Numbers) -> HeadPose {
    HeadPose {
        position: n.vec3([0.0, 1.6, 0.0]),
        orientation: n.quat(),
    }
}

/// A sample with a number in every field that takes one.
pub(super) fn a_sample(n: &mut Numbers) -> Sample {
    let eye = |n: &mut Numbers, raw| Eye {
        origin: Some(Reading::tracked(n.vec3([0.03, 0.0, 0.0]))),
        direction: Some(Reading::tracked(n.vec3([0.0, 0.0, -1.0]))),
        pupil: Some(if raw {
            Pupil::Raw(n.next(40.0))
        } else {
            Pupil::Diameter(n.next(0.004))
        }),
        openness: Some(n.next(1.0)),
    };
    Sample {
        device_time: Some(DeviceTime {
            microseconds: 7,
            wraps_at: 0,
        }),
        sequence: Some(1),
        head: Head {
            position: Some(Reading::tracked(n.vec3([0.1, 0.2, 0.3]))),
            orientation: Some(Reading::tracked(n.quat())),
            angular_velocity: Some(n.vec3([0.0, 0.1, 0.0])),
        },
        gaze_frame: GazeFrame::Head,
        left: eye(n, true),
        right: eye(n, false),
        combined: eye(n, false),
        gaze_point: Some(Reading::tracked(GazePoint::Plane(n.vec2([0.5, 0.4])))),
        ..Sample::arrived(Micros(1_000_000))
    }
}

/// A square of nine.
fn targets(n: &mut Numbers) -> Vec<Target> {
    let mut targets = Vec::new();
    for x in [-0.2f32, 0.0, 0.2] {
        for y in [-0.1f32, 0.0, 0.1] {
            targets.push(Target {
                measured: n.vec2([320.0 + 900.0 * x + 30.0 * x * y, 200.0 - 800.0 * y]),
                direction: n.vec3([x, y, -1.0]),
            });
        }
    }
    targets
}

fn calibrations() -> [Calibration; 2] {
    [Model::Affine, Model::SecondOrder].map(|model| {
        let targets = (0..9).map(|i| {
            let (x, y) = ((i % 3) as f32 * 0.2 - 0.2, (i / 3) as f32 * 0.1 - 0.1);
            Target {
                measured: Vec2::new(320.0 + 900.0 * x, 200.0 - 800.0 * y),
                direction: Vec3::new(x, y, -1.0),
            }
        });
        Calibration::fit(model, &targets.collect::<Vec<_>>()).expect("a square")
    })
}

#[track_caller]
fn is_direction(found: Option<Vec3>) {
    assert!(
        found.is_none_or(|v| (v.length() - 1.0).abs() < 1.0e-5),
        "{found:?}"
    );
}

pub(super) fn a_config(n: &mut Numbers) -> EstimatorConfig {
    let default = EstimatorConfig::default();
    let (head, saccades, fallback) = (
        HeadConfig::default(),
        SaccadeConfig::default(),
        FallbackConfig::default(),
    );
    let euro = OneEuroConfig::default();
    let pursuit = PursuitConfig::default();
    EstimatorConfig {
        room_from_tracker: room(n),
        resting_head: a_head_pose(n),
        eyes: Eyes::Combined,
        screen: Some(a_screen(n)),
        most_eccentricity: n.next(default.most_eccentricity),
        least_openness: n.next(default.least_openness),
        filter: Filter::OneEuro(OneEuroConfig {
            least_cutoff: n.next(euro.least_cutoff),
            beta: n.next(euro.beta),
            speed_cutoff: n.next(euro.speed_cutoff),
        }),
        saccades: SaccadeConfig {
            start_speed: n.next(saccades.start_speed),
            end_speed: n.next(saccades.end_speed),
            least_amplitude: n.next(saccades.least_amplitude),
            base_duration: n.next(saccades.base_duration),
            duration_per_amplitude: n.next(saccades.duration_per_amplitude),
            ..saccades
        },
        prediction: Some(GazePrediction {
            pursuit: PursuitConfig {
                least_speed: n.next(pursuit.least_speed),
                ..pursuit
            },
            ..GazePrediction::default()
        }),
        head: HeadConfig {
            least_turn: n.next(head.least_turn),
            least_speed: n.next(head.least_speed),
            ..head
        },
        fallback: FallbackConfig {
            widen_by: n.next(fallback.widen_by),
            ..fallback
        },
        ..default
    }
}

/// These samples and two sound ones after them.
fn estimates<const H: usize, const E: usize>(gaze: &mut GazeEstimator<H, E>, samples: &[Sample]) {
    let sound = |turn: f32| {
        let mut sample = Sample::arrived(Micros(1));
        let way = Vec3::new(turn, 0.0, -1.0).normalize();
        sample.head.orientation = Some(Reading::tracked(Quat::IDENTITY));
        sample.head.position = Some(Reading::tracked(Vec3::ZERO));
        sample.combined.direction = Some(Reading::tracked(way));
        sample
    };
    let all = samples.iter().copied().chain([sound(0.0), sound(0.01)]);
    for (sample, step) in all.zip(1..) {
        gaze.push(&sample, Micros(4_000 * step), &mut |_| {});
        let estimate = gaze.estimate(Micros(4_000 * step + 20_000), &mut |_| {});
        finite(&estimate);
        is_direction(Some(estimate.line_of_sight.forward()));
    }
}

/// What comes of numbers that a decoder lets through, 10⁹ at most.
fn turns(n: &mut Numbers, apply: fn(&Axes, &mut Numbers) -> String) {
    let own = Axes::new(n.quat(), n.quat());
    let printed = [own, Ok(Axes::FORWARD_RIGHT_DOWN)]
        .into_iter()
        .flatten()
        .map(|axes| apply(&axes, n))
        .collect::<Vec<_>>();
    if n.within(1.0e9) {
        for printed in printed {
            assert!(
                !printed.contains("NaN") && !printed.contains("inf"),
                "{printed}"
            );
        }
    }
}
