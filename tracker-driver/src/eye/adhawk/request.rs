//! What a host asks of the device.

use super::encode::{packet, push};
use super::{Packet, RESPONSE_TIMEOUT};
use crate::command::{Awaited, PATIENCE, Script};

/// What the host asks of the device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Request {
    /// Start tracking the eyes, or stop.
    Tracking(bool),
    /// Whether it is ready: the result says.
    Status,
    /// Which fields of the stream 0x01 it sends: bit 1 is field 1.
    Fields {
        /// The fields that this is about.
        mask: u32,
        /// Whether they are sent.
        enable: bool,
    },
    /// How often it sends them.
    Rate {
        /// Samples per second.
        hertz: f32,
    },
    /// Which events it sends: bit 0 blinks, 1 eyes that open and close, 2
    /// eyes lost and found, 3 saccades, 9 fixations.
    Events {
        /// The events that this is about.
        mask: u32,
        /// Whether they are sent.
        enable: bool,
    },
}

/// The property numbers of [`SET_PROPERTY`].
pub(crate) const PROPERTY_EVENTS: u8 = 5;
pub(crate) const PROPERTY_RATE: u8 = 13;
pub(crate) const PROPERTY_FIELDS: u8 = 14;
pub(crate) const GET_TRACKER_STATUS: u8 = 0x90;
pub(crate) const SET_PROPERTY: u8 = 0x9B;
pub(crate) const SYSTEM_CONTROL: u8 = 0x9C;
pub(crate) const EYE_TRACKING: u8 = 1;

impl Request {
    /// Returns what the response calls it ([`Reply::to`](crate::decoder::Reply::to)).
    pub const fn kind(&self) -> u8 {
        match self {
            Self::Tracking(_) => SYSTEM_CONTROL,
            Self::Status => GET_TRACKER_STATUS,
            Self::Fields { .. } | Self::Rate { .. } | Self::Events { .. } => SET_PROPERTY,
        }
    }

    /// Returns the packet that asks; `number` comes back in the response.
    pub fn encode(&self, number: u16) -> Packet {
        let mut payload = Packet::new();
        push(&mut payload, &number.to_le_bytes());
        push(&mut payload, &[self.kind()]);
        let mut switch = |property, mask: u32, enable| {
            push(&mut payload, &[property]);
            push(&mut payload, &mask.to_le_bytes());
            push(&mut payload, &[u8::from(enable)]);
        };
        match *self {
            Self::Fields { mask, enable } => switch(PROPERTY_FIELDS, mask, enable),
            Self::Events { mask, enable } => switch(PROPERTY_EVENTS, mask, enable),
            Self::Tracking(on) => push(&mut payload, &[EYE_TRACKING, u8::from(on)]),
            Self::Status => (),
            Self::Rate { hertz } => {
                push(&mut payload, &[PROPERTY_RATE]);
                push(&mut payload, &hertz.to_le_bytes());
            }
        }
        packet(&payload, false)
    }
}

/// The fields that are usually asked for: directions, origins, pupils, the head.
pub const USUAL_FIELDS: u32 = 0b1_0010_1110;

/// Samples per second that are usually asked for.
pub const USUAL_HERTZ: u16 = 250;

/// Makes the device send these fields (bit 1 is field 1) `hertz` times a second, and all events.
pub fn start(fields: u32, hertz: f32) -> Script {
    let requests = [
        Request::Tracking(true),
        Request::Fields {
            mask: fields,
            enable: true,
        },
        Request::Events {
            mask: ALL_EVENTS,
            enable: true,
        },
        Request::Rate { hertz },
    ];
    let mut script = Script::new();
    for (request, number) in requests.iter().zip(1..) {
        let reply = Awaited::Reply(u32::from(request.kind()));
        script
            .send(&request.encode(number))
            .expect(reply, RESPONSE_TIMEOUT);
    }
    script.expect(Awaited::Sample, PATIENCE);
    script
}

/// Returns what makes it stop.
pub fn stop() -> Script {
    let request = Request::Tracking(false);
    let reply = Awaited::Reply(u32::from(request.kind()));
    let mut script = Script::sending(&request.encode(1));
    script.expect(reply, RESPONSE_TIMEOUT);
    script
}

/// The events that [`Request::Events`] numbers.
const ALL_EVENTS: u32 = 0b10_0000_1111;
