//! What a device sends, for the mock and a bridge board.

use super::fields::NOT_MEASURED;
use super::{
    BOTH, Data, EVENTS, EYES, LEFT, LONGEST_PACKET, MILLIMETRE, NANOSECONDS_PER_MICROSECOND,
    OVERHEAD, Packet, RIGHT, START_OF_PACKET, STREAM_BIT, event_layout,
};
use crate::decoder::{EyeEvent, Side};
use crate::sample::{Eye, GazePoint, Pupil, Reading, Sample};
use glam::{Vec2, Vec3};

/// Returns the packet of stream 0x01 that a device sends for a sample, with fields 1, 2, 3, 5, 7
/// and 8 as far as it has them; NaN for what one eye lacks or is not tracked. `None` without
/// fields.
pub fn encode(sample: &Sample) -> Option<Packet> {
    let sides = [(RIGHT, &sample.right), (LEFT, &sample.left)];
    let present = sides.into_iter().filter(|(_, eye)| !eye.is_empty());
    let eyes = present.clone().map(|(side, _)| side).sum();
    let present = present.map(|(_, eye)| eye);
    let microseconds = sample.device_time.map_or(0, |time| time.microseconds);
    let nanoseconds = microseconds.saturating_mul(NANOSECONDS_PER_MICROSECOND);
    let mut payload = Packet::new();
    push(&mut payload, &[EYES]);
    push(&mut payload, &nanoseconds.to_le_bytes());
    // A device that has neither eye still says which it looked at.
    push(&mut payload, &[if eyes == 0 { BOTH } else { eyes }]);
    let before = payload.len();
    if let Some(direction) = sample.combined.direction {
        let [x, y, z] = measured(direction).to_array();
        push_numbers(&mut payload, 1, &[x, y, z, 0.0]);
    }
    for field in [2, 3, 5] {
        let read = |eye: &Eye| match field {
            2 => Some(measured(eye.direction?)),
            3 => Some(measured(eye.origin?) / MILLIMETRE),
            _ => match eye.pupil? {
                Pupil::Diameter(diameter) => Some(Vec3::splat(diameter / MILLIMETRE)),
                Pupil::Raw(_) => None,
            },
        };
        if present.clone().all(|eye| read(eye).is_none()) {
            continue;
        }
        push(&mut payload, &[field]);
        for eye in present.clone() {
            let numbers = read(eye).unwrap_or(Vec3::NAN).to_array();
            let count = if field == 5 { 1 } else { numbers.len() };
            for number in numbers.iter().take(count) {
                push(&mut payload, &bits(*number).to_le_bytes());
            }
        }
    }
    if let Some(point) = sample.gaze_point
        && let GazePoint::Normalized(place) = point.value
    {
        let place = if point.tracked { place } else { Vec2::NAN };
        push_numbers(&mut payload, 7, &place.to_array());
    }
    if let Some(turn) = sample.head.orientation {
        push_numbers(&mut payload, 8, &turn.value.to_array());
    }
    (payload.len() > before).then(|| packet(&payload, true))
}

/// Returns a vector that was measured, or NaN.
fn measured(reading: Reading<Vec3>) -> Vec3 {
    if reading.tracked {
        reading.value
    } else {
        Vec3::NAN
    }
}

/// Returns the packet of stream 0x18 for an event; what follows a duration is zero.
pub fn encode_event(event: &EyeEvent) -> Packet {
    let is_it = |&kind: &u8| event_layout(kind).is_some_and(|(found, ..)| found == event.kind);
    // Every kind of event has a number.
    let kind = (1..=15).find(is_it).unwrap_or_default();
    let seconds = |microseconds: u64| microseconds as f32 * 1.0e-6;
    let time = event.device_time.map_or(0, |time| time.microseconds);
    let mut payload = Packet::new();
    push(&mut payload, &[EVENTS, kind]);
    push(&mut payload, &seconds(time).to_le_bytes());
    match event_layout(kind) {
        Some((_, length, Data::Duration)) => {
            let duration = event.duration.map_or(0, |duration| duration.0);
            push(&mut payload, &seconds(duration).to_le_bytes());
            for _ in 4..length {
                push(&mut payload, &[0]);
            }
        }
        Some((_, _, Data::Eye)) => {
            push(&mut payload, &[u8::from(event.eye == Some(Side::Left))]);
        }
        None => (),
    }
    packet(&payload, true)
}

/// Returns the response to a request of this kind; of `data` what a packet has room for.
pub fn encode_response(number: u16, kind: u8, result: u8, data: &[u8]) -> Packet {
    let [low, high] = number.to_le_bytes();
    let mut payload = Packet::new();
    push(&mut payload, &[low, high, kind, result]);
    let room = LONGEST_PACKET - OVERHEAD - payload.len();
    push(&mut payload, data.get(..room).unwrap_or(data));
    packet(&payload, false)
}

fn push_numbers(payload: &mut Packet, field: u8, numbers: &[f32]) {
    push(payload, &[field]);
    for number in numbers {
        push(payload, &bits(*number).to_le_bytes());
    }
}

/// Returns the bits of a number, the same for every NaN.
const fn bits(number: f32) -> u32 {
    if number.is_nan() {
        NOT_MEASURED
    } else {
        number.to_bits()
    }
}

/// Adds bytes; all fit: the largest payload that is built here has 114.
pub(super) fn push(payload: &mut Packet, bytes: &[u8]) {
    let _ = payload.extend_from_slice(bytes);
}

pub(super) fn packet(payload: &[u8], stream: bool) -> Packet {
    let header = payload.len() as u16 | if stream { STREAM_BIT } else { 0 };
    let mut packet = Packet::new();
    push(&mut packet, &[START_OF_PACKET]);
    push(&mut packet, &header.to_le_bytes());
    push(&mut packet, payload);
    packet
}
