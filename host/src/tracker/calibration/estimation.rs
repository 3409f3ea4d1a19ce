//! The set-up of an estimator for a tracker.

use super::Calibrated;
use crate::tracker::feed::Senses;
use crate::tracker::protocol::ProtocolSpec;
use crate::tracker::spec::Spec;
use shisen_core::gaze::HeadPose;
use shisen_tracker::estimate::{EstimatorConfig, Eyes, RoomFromTracker, Screen, Sensors};
use shisen_tracker::protocol::Protocol;
use shisen_tracker::time::Micros;

/// Returns how the gaze is estimated from a tracker's samples. The tracker is at `head` unless
/// its calibration says otherwise, and so is the viewer's head as far as no tracker measures
/// it. The gaze of an ISCAN or ASL is whole numbers that may stay the same throughout a
/// fixation: it counts as stuck after 1.5 s unless the specification says otherwise.
pub(crate) fn estimation(
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
        sensors: spec.head.map_or(Sensors::First, Sensors::Only),
        ..EstimatorConfig::default()
    };
    if is_coarse(spec) {
        config.stuck_after = Some(COARSE_STUCK_AFTER);
    }
    spec.times.set(&mut config);
    if let Some(calibrated) = calibrated {
        calibrated.file.place(&mut config);
        [config.left, config.right, config.combined] = calibrated.fits;
    }
    config.resting_head = head;
    config
}

/// The longest fixation: a coarse gaze that stays the same for longer is stuck.
const COARSE_STUCK_AFTER: Micros = Micros::from_millis(1_500);

/// Returns whether a tracker sends whole numbers of camera pixels.
fn is_coarse(spec: &Spec) -> bool {
    let protocol = spec.protocol().map(ProtocolSpec::protocol);
    matches!(protocol, Some(Protocol::Asl(_) | Protocol::Iscan(_)))
}

fn mock_screen(spec: &Spec, head: HeadPose) -> Option<Screen> {
    match spec.protocol()?.protocol() {
        Protocol::EyeTracker(screen, _) => Some(Screen {
            corner: head.position + head.orientation * screen.corner,
            right: head.orientation * screen.right,
            down: head.orientation * screen.down,
            ..*screen
        }),
        _ => None,
    }
}

/// Returns how the gaze is estimated from two trackers, of which one measures the head: its place,
/// its stuckness and its ages are those of `head`, the rest is that of `gaze`.
pub(crate) const fn composed(head: &EstimatorConfig, gaze: &EstimatorConfig) -> EstimatorConfig {
    let mut config = *gaze;
    config.room_from_tracker = head.room_from_tracker;
    config.head_tracked = true;
    config.fallback.keeps_head = true;
    config.head_stuck_after = head.head_stuck_after;
    config.fallback.head_hold_after = head.fallback.head_hold_after;
    config.fallback.head_widen_after = head.fallback.head_widen_after;
    config.fallback.head_full_after = head.fallback.head_full_after;
    config
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coarse_gaze_is_stuck_later_unless_the_specification_says_when() {
        let after = |millis| Some(Micros::from_millis(millis));
        for (spec, stuck_after) in [
            ("mock:as=adhawk", after(250)),
            ("mock:as=iscan", after(1_500)),
            ("serial:/dev/tty?protocol=asl", after(1_500)),
            ("hid:1532:0b00", after(250)),
            ("serial:/dev/tty?protocol=asl&stuck_after=0.3", after(300)),
            ("serial:/dev/tty?protocol=iscan&stuck_after=never", None),
            ("replay:a.csv?stuck_after=2", after(2_000)),
        ] {
            let (head, eyes) = (false, true);
            let spec: Spec = spec.parse().unwrap();
            let config = estimation(&spec, Senses { head, eyes }, HeadPose::IDENTITY, None);
            assert_eq!(config.stuck_after, stuck_after, "{spec:?}");
            assert_eq!(config.check(), Ok(()));
        }
    }
}
