//! What a device sends, for the mock and a bridge board.

use super::{
    BOTH, Data, EVENTS, EYES, LEFT, LONGEST_PACKET, MILLIMETRE, NANOSECONDS_PER_MICROSECOND,
    OVERHEAD, Packet, RIGHT, START_OF_PACKET, STREAM_BIT, event_layout,
};
use crate::decoder::{EyeEvent, EyeEventKind, Side};
use crate::sample::{Eye, GazePoint, Head, Pupil, Sample};

/// The packet of stream 0x01 that a device sends for a sample, with the
/// fields 1, 2, 3, 5, 7 and 8 as far as the sample has them; a field of each
/// eye only where every eye that the sample has anything of has it. `None`
/// where nothing is left.
pub fn encode(sample: &Sample) -> Option<Packet> {
    let mut eyes = 0;
    for (side, eye) in [(RIGHT, &sample.right), (LEFT, &sample.left)] {
        if !eye.is_empty() {
            eyes |= side;
        }
    }
    let microseconds = sample.device_time.map_or(0, |time| time.microseconds);
    let nanoseconds = microseconds.saturating_mul(NANOSECONDS_PER_MICROSECOND);
    let mut payload = Packet::new();
    push(&mut payload, &[EYES]);
    push(&mut payload, &nanoseconds.to_le_bytes());
    // A device that has neither eye still says which it looked at.
    push(&mut payload, &[if eyes == 0 { BOTH } else { eyes }]);
    let before = payload.len();
    if let Some(direction) = sample.combined.direction {
        let [x, y, z] = direction.value.to_array();
        push_numbers(&mut payload, 1, &[x, y, z, 0.0]);
    }
    for field in [2, 3] {
        let read = |eye: &Eye| match field {
            2 => Some(eye.direction?.value),
            _ => Some(eye.origin?.value / MILLIMETRE),
        };
        match present(sample, eyes).map(|eye| eye.and_then(read)) {
            [Some(right), Some(left)] if eyes == BOTH => {
                let [[a, b, c], [d, e, f]] = [right.to_array(), left.to_array()];
                push_numbers(&mut payload, field, &[a, b, c, d, e, f]);
            }
            [Some(one), None] | [None, Some(one)] if eyes != BOTH => {
                push_numbers(&mut payload, field, &one.to_array());
            }
            _ => (),
        }
    }
    let diameter = |eye: &Eye| match eye.pupil? {
        Pupil::Diameter(diameter) => Some(diameter / MILLIMETRE),
        Pupil::Raw(_) => None,
    };
    match present(sample, eyes).map(|eye| eye.and_then(diameter)) {
        [Some(right), Some(left)] if eyes == BOTH => {
            push_numbers(&mut payload, 5, &[right, left]);
        }
        [Some(one), None] | [None, Some(one)] if eyes != BOTH => {
            push_numbers(&mut payload, 5, &[one]);
        }
        _ => (),
    }
    if let Some(GazePoint::Normalized(point)) = sample.gaze_point.map(|point| point.value) {
        push_numbers(&mut payload, 7, &point.to_array());
    }
    if let Head {
        orientation: Some(turn),
        ..
    } = sample.head
    {
        push_numbers(&mut payload, 8, &turn.value.to_array());
    }
    (payload.len() > before).then(|| packet(&payload, true))
}

/// The right and the left eye, where they are among these.
fn present(sample: &Sample, eyes: u8) -> [Option<&Eye>; 2] {
    [
        (eyes & RIGHT != 0).then_some(&sample.right),
        (eyes & LEFT != 0).then_some(&sample.left),
    ]
}

/// The packet of stream 0x18 that a device sends for an event. What follows
/// the duration of a saccade or a fixation is zero.
pub fn encode_event(event: &EyeEvent) -> Packet {
    let kind = match event.kind {
        EyeEventKind::Blink => 1,
        EyeEventKind::Closed => 2,
        EyeEventKind::Opened => 3,
        EyeEventKind::Lost => 4,
        EyeEventKind::Found => 5,
        EyeEventKind::Saccade => 6,
        EyeEventKind::Fixation => 15,
    };
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

/// The response that a device sends to a request of this kind; of `data` what a
/// packet has room for.
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
        push(payload, &number.to_le_bytes());
    }
}

/// No payload that is built here is longer than a packet: the largest has 114
/// bytes.
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
