//! How an `AdHawk` obeys commands.

use super::{Device, MOST_HEARD};
use crate::decoder::EyeEventKind;
use crate::eye::adhawk::{
    EYE_TRACKING, GET_TRACKER_STATUS, PROPERTY_EVENTS, PROPERTY_FIELDS, PROPERTY_RATE,
    SET_PROPERTY, START_OF_PACKET, SYSTEM_CONTROL, encode_response,
};
use crate::sample::Sample;

const GET_PROPERTY: u8 = 0x9A;
/// Streams by their bits, and how often they are sent.
const PROPERTY_STREAMS: u8 = 2;

/// Results.
const DONE: u8 = 0;
const BAD_ARGUMENT: u8 = 2;
const UNSUPPORTED: u8 = 8;

/// What the host sets and gets.
#[derive(Debug, Clone, Copy)]
pub(super) struct Properties {
    /// Bit 1 is field 1.
    fields: u32,
    events: u32,
    hertz: f32,
}

impl Default for Properties {
    /// Returns all fields, no events, as often as the mock measures.
    fn default() -> Self {
        Self {
            fields: u32::MAX,
            events: 0,
            hertz: 0.0,
        }
    }
}

/// A result and the data behind it.
type Answer = (u8, Option<[u8; 4]>);

impl Device {
    pub(super) fn adhawk(&mut self, first: u8, answer: &mut dyn FnMut(&[u8])) -> Option<usize> {
        if first != START_OF_PACKET {
            return Some(1);
        }
        let &[_, low, high] = self.heard.first_chunk::<3>()?;
        let length = usize::from(u16::from_le_bytes([low, high]));
        if length > MOST_HEARD - 3 {
            return Some(1);
        }
        let payload = self.heard.get(3..3 + length)?;
        if let &[low, high, kind, ref arguments @ ..] = payload {
            let number = u16::from_le_bytes([low, high]);
            let (streams, properties) = (&mut self.streams, &mut self.adhawk);
            let (result, data) = match (kind, arguments) {
                (SYSTEM_CONTROL, &[EYE_TRACKING, on @ (0 | 1)]) => {
                    *streams = on == 1;
                    (DONE, None)
                }
                (GET_TRACKER_STATUS, []) => (DONE, None),
                (GET_PROPERTY, &[property]) => properties.get(property),
                (SET_PROPERTY, &[property, ref value @ ..]) => {
                    let set = properties.set(property, value);
                    self.rate = (properties.hertz >= 1.0).then_some(properties.hertz as u32);
                    (set, None)
                }
                (GET_TRACKER_STATUS | GET_PROPERTY | SET_PROPERTY | SYSTEM_CONTROL, _) => {
                    (BAD_ARGUMENT, None)
                }
                _ => (UNSUPPORTED, None),
            };
            answer(&encode_response(
                number,
                kind,
                result,
                data.as_ref().map_or(&[], |data| data),
            ));
        }
        Some(3 + length)
    }
}

impl Properties {
    /// Returns the value as [`SET_PROPERTY`] takes it; the sources do not say how the device sends
    /// it.
    fn get(&self, property: u8) -> Answer {
        match property {
            PROPERTY_RATE => (DONE, Some(self.hertz.to_le_bytes())),
            PROPERTY_FIELDS => (DONE, Some(self.fields.to_le_bytes())),
            PROPERTY_EVENTS => (DONE, Some(self.events.to_le_bytes())),
            _ => (UNSUPPORTED, None),
        }
    }

    fn set(&mut self, property: u8, value: &[u8]) -> u8 {
        let switch = |bits: &mut u32, mask: u32, on: u8| match on {
            0 => *bits &= !mask,
            _ => *bits |= mask,
        };
        match (property, value) {
            (PROPERTY_RATE, &[a, b, c, d]) | (PROPERTY_STREAMS, &[_, _, _, _, a, b, c, d]) => {
                let hertz = f32::from_le_bytes([a, b, c, d]);
                if !(hertz.is_finite() && hertz >= 0.0) {
                    return BAD_ARGUMENT;
                }
                self.hertz = hertz;
            }
            (PROPERTY_FIELDS, &[a, b, c, d, on @ (0 | 1)]) => {
                switch(&mut self.fields, u32::from_le_bytes([a, b, c, d]), on);
            }
            (PROPERTY_EVENTS, &[a, b, c, d, on @ (0 | 1)]) => {
                switch(&mut self.events, u32::from_le_bytes([a, b, c, d]), on);
            }
            (PROPERTY_RATE | PROPERTY_STREAMS | PROPERTY_FIELDS | PROPERTY_EVENTS, _) => {
                return BAD_ARGUMENT;
            }
            _ => return UNSUPPORTED,
        }
        DONE
    }

    /// Returns whether the host asked for such events.
    pub(super) const fn tells(&self, kind: EyeEventKind) -> bool {
        let bit = match kind {
            EyeEventKind::Blink => 0,
            EyeEventKind::Closed | EyeEventKind::Opened => 1,
            EyeEventKind::Lost | EyeEventKind::Found => 2,
            EyeEventKind::Saccade => 3,
            EyeEventKind::Fixation => 9,
        };
        self.events >> bit & 1 != 0
    }

    /// Takes the fields out of a sample that are not to be sent.
    pub(super) fn leave_out(&self, sample: &mut Sample) {
        let lacks = |field: u32| self.fields & (1 << field) == 0;
        if lacks(1) {
            sample.combined.direction = None;
        }
        for eye in [&mut sample.left, &mut sample.right] {
            if lacks(2) {
                eye.direction = None;
            }
            if lacks(3) {
                eye.origin = None;
            }
            if lacks(5) {
                eye.pupil = None;
            }
        }
        if lacks(7) {
            sample.gaze_point = None;
        }
        if lacks(8) {
            sample.head.orientation = None;
        }
    }
}
