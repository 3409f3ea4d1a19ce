//! How an estimator is set up for a tracker.

use super::super::{Senses, Spec};
use super::Calibrated;
use shisen_core::gaze::HeadPose;
use shisen_tracker::estimate::{EstimatorConfig, Eyes, RoomFromTracker, Screen, Sensors};
use shisen_tracker::protocol::Protocol;
use shisen_tracker::time::Micros;

/// How the gaze is estimated from what a tracker says: one whose origin is at
/// `head`, unless its calibration knows better, and a viewer whose head is
/// there as far as no tracker says. An ISCAN's or an ASL's gaze is stuck after 1.5 s
/// where the specification does not say otherwise: it is of whole numbers, which may
/// well stay what they are throughout a fixation.
pub fn estimation(
    spec: &Spec,
    senses: Senses,
    head: HeadPose,
    calibrated: Option<&Calibrated>,
) -> EstimatorConfig {
    let mut config = EstimatorConfig {
        room_from_tracker: RoomFromTracker {
            position: head.position,
            orientation: head.orientation,
        },
        head_tracked: senses.head,
        eyes: if senses.eyes {
            Eyes::Combined
        } else {
            Eyes::HeadOnly
        },
        screen: mock_screen(spec, head),
        sensors: spec.head().map_or(Sensors::First, Sensors::Only),
        ..EstimatorConfig::default()
    };
    if is_coarse(spec) {
        config.stuck_after = Some(COARSE_STUCK_AFTER);
    }
    spec.times().set(&mut config);
    if let Some(calibrated) = calibrated {
        calibrated.file.place(&mut config);
        [config.left, config.right, config.combined] = calibrated.fits;
    }
    config.resting_head = head;
    config
}

/// From when on a gaze of few digits is stuck: the longest fixations are no longer.
const COARSE_STUCK_AFTER: Micros = Micros::from_millis(1_500);

/// Whether a tracker gives whole numbers of its camera's.
fn is_coarse(spec: &Spec) -> bool {
    let protocol = match spec {
        Spec::Serial(spec) => Some(&spec.protocol),
        Spec::Mock(spec) => spec.protocol.as_ref(),
        Spec::Hid(_) | Spec::Replay(_) => None,
    };
    protocol.is_some_and(|spec| matches!(spec.protocol(), Protocol::Asl(_) | Protocol::Iscan(_)))
}

/// The screen in front of the mock.
fn mock_screen(spec: &Spec, head: HeadPose) -> Option<Screen> {
    let Spec::Mock(mock) = spec else {
        return None;
    };
    match mock.protocol.as_ref()?.protocol() {
        Protocol::EyeTracker(screen, _) => Some(Screen {
            corner: head.position + head.orientation * screen.corner,
            right: head.orientation * screen.right,
            down: head.orientation * screen.down,
            ..*screen
        }),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coarse_gaze_is_stuck_later_unless_somebody_says_when() {
        let after = |millis| Some(Micros::from_millis(millis));
        for (spec, stuck_after) in [
            ("mock", after(250)),
            ("mock:as=adhawk", after(250)),
            ("mock:as=iscan", after(1_500)),
            ("mock:as=asl", after(1_500)),
            ("serial:/dev/tty?protocol=asl", after(1_500)),
            ("serial:/dev/tty?protocol=iscan", after(1_500)),
            ("serial:/dev/tty?protocol=link", after(250)),
            ("hid:1532:0b00", after(250)),
            ("replay:a.csv", after(250)),
            ("serial:/dev/tty?protocol=asl&stuck_after=0.3", after(300)),
            ("serial:/dev/tty?protocol=iscan&stuck_after=never", None),
            ("replay:a.csv?stuck_after=2", after(2_000)),
        ] {
            let senses = Senses {
                head: false,
                eyes: true,
            };
            let spec: Spec = spec.parse().unwrap();
            let config = estimation(&spec, senses, HeadPose::IDENTITY, None);
            assert_eq!(config.stuck_after, stuck_after, "{spec:?}");
            assert_eq!(config.check(), Ok(()));
        }
        let spec = "mock:hold_after=0.05&head_full_after=1".parse().unwrap();
        let senses = Senses {
            head: true,
            eyes: true,
        };
        let config = estimation(&spec, senses, HeadPose::IDENTITY, None);
        assert_eq!(config.fallback.hold_after, Micros::from_millis(50));
        assert_eq!(config.fallback.head_full_after, Micros::from_millis(1_000));
    }
}
