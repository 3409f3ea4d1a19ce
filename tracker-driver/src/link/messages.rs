//! The bodies of messages.

use super::body::{Body, write_time};
use super::frame::Content;
use super::{CONTROL, EYES, FAULT, REPLY, STATE, TEXT, UNMEASURED};
use crate::decoder::{
    Control, ControlState, DropReason, EyeEvent, EyeEventKind, MOST_MESSAGE_BYTES, Message, Reply,
    Side, Text,
};
use crate::sample::Parts;
use crate::time::Micros;

const HAS_TIME: u8 = 1 << 0;
const HAS_WRAP: u8 = 1 << 1;
const HAS_DURATION: u8 = 1 << 2;
const IS_AXIS: u8 = 1 << 3;

/// In the order of their numbers.
pub(super) const EYE_EVENTS: [EyeEventKind; 7] = [
    EyeEventKind::Blink,
    EyeEventKind::Closed,
    EyeEventKind::Opened,
    EyeEventKind::Lost,
    EyeEventKind::Found,
    EyeEventKind::Saccade,
    EyeEventKind::Fixation,
];

/// In the order of their numbers.
pub(super) const SIDES: [Option<Side>; 3] = [None, Some(Side::Left), Some(Side::Right)];

/// Adds the body of an eye event.
pub(super) fn write_eye_event(content: &mut Content, event: &EyeEvent) {
    let kind = EYE_EVENTS.iter().position(|&kind| kind == event.kind);
    let side = SIDES.iter().position(|&side| side == event.eye);
    let mut has = 0;
    if let Some(time) = event.device_time {
        has |= HAS_TIME | if time.wraps_at == 0 { 0 } else { HAS_WRAP };
    }
    if event.duration.is_some() {
        has |= HAS_DURATION;
    }
    let number = |place: Option<usize>| place.map_or(u8::MAX, |place| place as u8);
    content.push(&[number(kind), number(side), has]);
    if let Some(time) = event.device_time {
        write_time(content, time);
    }
    if let Some(duration) = event.duration {
        content.push(&duration.0.to_le_bytes());
    }
}

fn read_eye_event(body: &mut Body<'_>) -> Result<EyeEvent, DropReason> {
    let [kind, side, has] = body.take()?;
    if has & !(HAS_TIME | HAS_WRAP | HAS_DURATION) != 0 || has & (HAS_TIME | HAS_WRAP) == HAS_WRAP {
        return Err(DropReason::Field);
    }
    let kind = EYE_EVENTS.get(usize::from(kind));
    let side = SIDES.get(usize::from(side));
    let device_time = if has & HAS_TIME == 0 {
        None
    } else {
        Some(body.time(has & HAS_WRAP != 0)?)
    };
    let duration = if has & HAS_DURATION == 0 {
        None
    } else {
        Some(Micros(body.u64()?))
    };
    Ok(EyeEvent {
        kind: *kind.ok_or(DropReason::Field)?,
        eye: *side.ok_or(DropReason::Field)?,
        device_time,
        duration,
    })
}

/// Adds the body of a control.
pub(super) fn write_control(content: &mut Content, control: &Control) {
    let time = control.device_time;
    let mut has = time.map_or(0, |_| HAS_TIME);
    has |= time.map_or(0, |t| if t.wraps_at == 0 { 0 } else { HAS_WRAP });
    let value = match control.state {
        ControlState::Button(pressed) => f32::from(u8::from(pressed)),
        ControlState::Axis(value) => {
            has |= IS_AXIS;
            value
        }
    };
    content.push(&[control.sensor, control.number, has]);
    content.push(&value.to_le_bytes());
    if let Some(time) = time {
        write_time(content, time);
    }
}

fn read_control(body: &mut Body<'_>) -> Result<Control, DropReason> {
    let [sensor, number, has] = body.take()?;
    if has & !(HAS_TIME | HAS_WRAP | IS_AXIS) != 0 || has & (HAS_TIME | HAS_WRAP) == HAS_WRAP {
        return Err(DropReason::Field);
    }
    let value = body.number()?;
    let state = if has & IS_AXIS != 0 {
        ControlState::Axis(value)
    } else if value == 0.0 || value == 1.0 {
        ControlState::Button(value == 1.0)
    } else {
        return Err(DropReason::Field);
    };
    let time = (has & HAS_TIME != 0).then(|| body.time(has & HAS_WRAP != 0));
    Ok(Control {
        sensor,
        number,
        state,
        device_time: time.transpose()?,
    })
}

/// Returns the message in a body of this kind.
pub(super) fn read_message(kind: u8, body: &[u8]) -> Result<Message, DropReason> {
    let mut body = Body(body);
    let message = match kind {
        TEXT if body.0.len() <= MOST_MESSAGE_BYTES => {
            return Ok(Message::Text(Text::new(body.0)));
        }
        TEXT => return Err(DropReason::Length),
        FAULT => Message::Fault {
            code: body.u32()?,
            meaning: "",
        },
        REPLY => Message::Reply(Reply {
            to: body.u32()?,
            result: body.u32()?,
            meaning: "",
        }),
        STATE => Message::State {
            code: body.u32()?,
            meaning: "",
        },
        CONTROL => Message::Control(read_control(&mut body)?),
        EYES => Message::Eyes(read_eye_event(&mut body)?),
        UNMEASURED => {
            let bits = u16::from_le_bytes(body.take()?);
            Message::Unmeasured(Parts::from_bits(bits).ok_or(DropReason::Field)?)
        }
        // Commands too: they are none of the host's.
        _ => return Err(DropReason::Unknown),
    };
    body.end()?;
    Ok(message)
}
