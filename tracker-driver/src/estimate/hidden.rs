//! Eyes of which the device itself says that it does not see them.

use super::config::Eyes;
use crate::decoder::{EyeEvent, EyeEventKind, Side};
use crate::sample::{Eye, Sample};
use crate::time::Micros;

const LEFT: u8 = 1;
const RIGHT: u8 = 2;
const BOTH: u8 = LEFT | RIGHT;
/// From an eye's bit for shut to that for lost.
const LOST: u32 = 2;

/// Which eyes are shut or lost by the device's events.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Hidden {
    /// When it last said so.
    since: Micros,
    /// The lowest two bits: eyes that are shut; the next two: eyes that are lost.
    bits: u8,
}

impl Hidden {
    /// Takes an event that happened at `time`.
    pub(super) fn hear(&mut self, event: &EyeEvent, time: Micros) {
        let eyes = match event.eye {
            None => BOTH,
            Some(Side::Left) => LEFT,
            Some(Side::Right) => RIGHT,
        };
        match event.kind {
            EyeEventKind::Closed => self.bits |= eyes,
            EyeEventKind::Lost => self.bits |= eyes << LOST,
            EyeEventKind::Opened | EyeEventKind::Blink => self.bits &= !eyes,
            EyeEventKind::Found => self.bits &= !(eyes | eyes << LOST),
            // These it sees.
            EyeEventKind::Saccade | EyeEventKind::Fixation => return,
        }
        if matches!(event.kind, EyeEventKind::Closed | EyeEventKind::Lost) {
            self.since = time;
        }
    }

    /// Shows eyes again whose directions come longer than `most` after they were hidden.
    pub(super) fn look(&mut self, sample: &Sample, time: Micros, most: Micros) {
        if self.bits == 0 || time.since(self.since) <= most {
            return;
        }
        let seen = |eye: &Eye| eye.direction.is_some_and(|direction| direction.tracked);
        let both = seen(&sample.combined) || sample.gaze_point.is_some_and(|p| p.tracked);
        for (bit, eye) in [(LEFT, &sample.left), (RIGHT, &sample.right)] {
            if seen(eye) || both && eye.direction.is_none() {
                self.bits &= !(bit | bit << LOST);
            }
        }
    }

    /// Returns whether the left and the right eye are hidden.
    pub(super) const fn eyes(self) -> [bool; 2] {
        let hidden = self.bits | self.bits >> LOST;
        [hidden & LEFT != 0, hidden & RIGHT != 0]
    }

    /// Returns whether all eyes that count are hidden.
    pub(super) const fn hides(self, eyes: Eyes) -> bool {
        let [left, right] = self.eyes();
        match eyes {
            Eyes::Combined => left && right,
            Eyes::Left => left,
            Eyes::Right => right,
            Eyes::HeadOnly => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(kind: EyeEventKind, eye: Option<Side>) -> EyeEvent {
        EyeEvent {
            kind,
            eye,
            device_time: None,
            duration: None,
        }
    }

    #[test]
    fn each_event_hides_its_eye_until_its_counterpart() {
        use EyeEventKind::{Blink, Closed, Fixation, Found, Lost, Opened, Saccade};
        let (left, right) = (Some(Side::Left), Some(Side::Right));
        let mut hidden = Hidden::default();
        for (kind, eye, expected) in [
            (Saccade, None, [false; 2]),
            (Closed, left, [true, false]),
            (Lost, right, [true, true]),
            (Fixation, None, [true, true]),
            // An eye that opens is not found yet.
            (Opened, right, [true, true]),
            (Opened, left, [false, true]),
            (Found, right, [false; 2]),
            (Closed, None, [true; 2]),
            (Blink, None, [false; 2]),
            (Closed, left, [true, false]),
            (Found, None, [false; 2]),
        ] {
            hidden.hear(&event(kind, eye), Micros(1));
            assert_eq!(hidden.eyes(), expected, "{kind:?} {eye:?}");
            assert_eq!(hidden.hides(Eyes::Left), expected[0]);
            assert_eq!(hidden.hides(Eyes::Right), expected[1]);
            assert_eq!(hidden.hides(Eyes::Combined), expected == [true; 2]);
            assert!(!hidden.hides(Eyes::HeadOnly));
        }
    }
}
