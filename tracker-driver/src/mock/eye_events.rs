//! What a device that watches the eyes makes of their movement: events, beside the
//! samples.

use super::tracker::LEAST_OPENNESS;
use crate::decoder::{EyeEvent, EyeEventKind, Side};
use crate::sample::{Eye, Sample};
use crate::time::Micros;

/// Most events of one sample: each eye leaves a state and enters another, and a blink
/// is over.
pub(super) const MOST_AT_ONCE: usize = 5;

/// How it is with an eye.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Sight {
    #[default]
    Seen,
    Shut,
    Lost,
}

/// Finds eyes that close, open, are lost and found, and blinks, in samples.
///
/// Saccades and fixations are not among them: a sample does not say what the eyes do.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct EyeEvents {
    left: Sight,
    right: Sight,
    /// Since when one of them is shut.
    shut: Option<Micros>,
}

impl EyeEvents {
    /// Takes the next sample and hands over what has happened since the one before.
    pub(super) fn see(&mut self, sample: &Sample, sink: &mut dyn FnMut(EyeEvent)) {
        let mut say = |kind, eye, duration| {
            sink(EyeEvent {
                kind,
                eye,
                device_time: sample.device_time,
                duration,
            });
        };
        for (side, before, eye) in [
            (Side::Left, &mut self.left, &sample.left),
            (Side::Right, &mut self.right, &sample.right),
        ] {
            // A device without this eye.
            if eye.is_empty() {
                continue;
            }
            let now = sight(eye);
            let before = core::mem::replace(before, now);
            if before == now {
                continue;
            }
            match before {
                Sight::Seen => {}
                Sight::Shut => say(EyeEventKind::Opened, Some(side), None),
                Sight::Lost => say(EyeEventKind::Found, Some(side), None),
            }
            match now {
                Sight::Seen => {}
                Sight::Shut => say(EyeEventKind::Closed, Some(side), None),
                Sight::Lost => say(EyeEventKind::Lost, Some(side), None),
            }
        }
        if self.left == Sight::Shut || self.right == Sight::Shut {
            self.shut.get_or_insert(sample.arrival);
        } else if let Some(since) = self.shut.take() {
            say(EyeEventKind::Blink, None, Some(sample.arrival.since(since)));
        }
    }
}

fn sight(eye: &Eye) -> Sight {
    if eye.openness.is_some_and(|open| open < LEAST_OPENNESS) {
        Sight::Shut
    } else if eye.direction.is_some_and(|direction| direction.tracked) {
        Sight::Seen
    } else {
        Sight::Lost
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Reading;
    use glam::Vec3;
    use std::vec::Vec;

    /// An eye that is so far open, and is seen or not.
    fn eye(openness: f32, seen: bool) -> Eye {
        Eye {
            direction: seen.then_some(Reading::tracked(Vec3::NEG_Z)),
            openness: Some(openness),
            ..Eye::default()
        }
    }

    #[test]
    fn each_change_is_an_event_and_a_blink_is_one_of_both_eyes() {
        use EyeEventKind::{Blink, Closed, Found, Lost, Opened};
        const LEFT: Option<Side> = Some(Side::Left);
        const RIGHT: Option<Side> = Some(Side::Right);
        let mut events = EyeEvents::default();
        let (open, shut, lost) = (eye(1.0, true), eye(0.1, false), eye(1.0, false));
        for (step, (left, right, expected)) in (0..).zip([
            (open, open, &[][..]),
            (shut, open, &[(Closed, LEFT)]),
            (shut, shut, &[(Closed, RIGHT)]),
            (shut, shut, &[]),
            (open, shut, &[(Opened, LEFT)]),
            (lost, open, &[(Lost, LEFT), (Opened, RIGHT), (Blink, None)]),
            (shut, open, &[(Found, LEFT), (Closed, LEFT)]),
            (open, open, &[(Opened, LEFT), (Blink, None)]),
            // A device without a left eye.
            (Eye::default(), lost, &[(Lost, RIGHT)]),
            (Eye::default(), open, &[(Found, RIGHT)]),
        ]) {
            let mut sample = Sample::arrived(Micros(1_000 * step));
            (sample.left, sample.right) = (left, right);
            let mut found = Vec::new();
            events.see(&sample, &mut |event| {
                found.push((event.kind, event.eye));
                let lasted = match (event.kind, step) {
                    (Blink, 5) => Some(Micros(4_000)),
                    (Blink, _) => Some(Micros(1_000)),
                    _ => None,
                };
                assert_eq!(event.duration, lasted, "{step}");
            });
            assert_eq!(found, expected, "{step}");
        }
    }
}
