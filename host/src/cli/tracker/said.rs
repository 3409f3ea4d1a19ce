//! What a device says beside its samples, for reports.

use serde::Serialize;
use shisen_tracker::decoder::{EyeEventKind, Message, Side};
use std::fmt;

/// Something that a device said.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub(super) enum Said {
    Fault {
        code: u32,
        meaning: &'static str,
    },
    State {
        code: u32,
        meaning: &'static str,
    },
    Text {
        text: String,
    },
    /// The answer to a command; the result is 0 where it agrees.
    Reply {
        command: u32,
        result: u32,
        meaning: &'static str,
    },
    Eyes {
        event: &'static str,
        /// Null where the device does not tell them apart.
        eye: Option<&'static str>,
        device_us: Option<u64>,
        duration_us: Option<u64>,
    },
}

impl Said {
    /// What a message says; `None` of what the samples tell themselves.
    pub(super) fn of(message: &Message) -> Option<Self> {
        Some(match message {
            &Message::Fault { code, meaning } => Self::Fault { code, meaning },
            &Message::State { code, meaning } => Self::State { code, meaning },
            Message::Text(text) => Self::Text {
                text: text.as_str().into(),
            },
            Message::Reply(reply) => Self::Reply {
                command: reply.to,
                result: reply.result,
                meaning: reply.meaning,
            },
            Message::Eyes(event) => Self::Eyes {
                event: match event.kind {
                    EyeEventKind::Blink => "blink",
                    EyeEventKind::Closed => "closed",
                    EyeEventKind::Opened => "opened",
                    EyeEventKind::Lost => "lost",
                    EyeEventKind::Found => "found",
                    EyeEventKind::Saccade => "saccade",
                    EyeEventKind::Fixation => "fixation",
                    _ => return None,
                },
                eye: event.eye.map(|eye| match eye {
                    Side::Left => "left",
                    Side::Right => "right",
                }),
                device_us: event.device_time.map(|time| time.microseconds),
                duration_us: event.duration.map(|duration| duration.0),
            },
            _ => return None,
        })
    }
}

impl fmt::Display for Said {
    /// What happened to the eyes; all else goes to standard error as it comes.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Eyes {
            event,
            eye,
            duration_us,
            ..
        } = self
        else {
            return Ok(());
        };
        f.write_str("  ")?;
        if let Some(eye) = eye {
            write!(f, "{eye} eye ")?;
        }
        f.write_str(event)?;
        match duration_us {
            Some(duration) => write!(f, " of {} ms", duration / 1_000),
            None => Ok(()),
        }
    }
}
