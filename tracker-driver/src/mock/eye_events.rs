//! The events that a simulated device reports beside its samples: blinks, lost and found eyes.

use super::tracker::LEAST_OPENNESS;
use crate::decoder::{EyeEvent, EyeEventKind, Side};
use crate::sample::{Eye, Sample};
use crate::time::Micros;

/// Most events of one sample: two eyes leave and enter a state, and a blink ends.
pub(super) const MOST_AT_ONCE: usize = 5;

/// The state of an eye.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Sight {
    #[default]
    Seen,
    Shut,
    Lost,
}

/// Finds in samples when eyes close, open, are lost and found, and blink.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct EyeEvents {
    left: Sight,
    right: Sight,
    /// When an eye shut, while one is shut.
    shut: Option<Micros>,
}

impl EyeEvents {
    /// Takes the next sample and hands the events since the one before to `sink`.
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
            // The device does not measure this eye.
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
