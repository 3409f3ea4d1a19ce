//! What a tracker says of itself, and what happens to its clock and to the gaze, in
//! words.

use super::warn_of_sensors;
use super::with_drops;
use crate::cli::output::warn;
use crate::live::TrackerEvent;
use crate::tracker::Notice;
use shisen_tracker::clock::ClockEvent;
use shisen_tracker::command::Failure;
use shisen_tracker::decoder::{EyeEventKind, Message, Side};
use shisen_tracker::estimate::{Event, HeadPart, Rejection};
use shisen_tracker::time::Micros;
use std::collections::BTreeMap;

/// Kinds that are kept; a device that makes up numbers has no end of them.
const MOST_KINDS: usize = 64;

/// How often one kind of them is said.
const STEP: Micros = Micros::from_millis(1_000);

/// Says each kind at once, and what comes of it within a second after that as a
/// number with the next.
#[derive(Debug, Default)]
pub(in crate::cli) struct Happenings(BTreeMap<Kind, Said>);

/// What it is about, and its number where the device has one.
type Kind = (&'static str, u32);

#[derive(Debug)]
struct Said {
    at: Micros,
    unsaid: u64,
}

impl Happenings {
    /// Says what happened on standard error, if it is to be said.
    pub(in crate::cli) fn tell(&mut self, happening: TrackerEvent) {
        let said = match happening {
            TrackerEvent::Clock(event, at) => self.of_clock(&event, at),
            TrackerEvent::Gaze(event, at) => {
                warn_of_sensors(&event);
                self.of_gaze(&event, at)
            }
            TrackerEvent::Flood(one_of, at) => self.of_flood(one_of, at),
            TrackerEvent::Device(message, at) => self.of_device(&message, at),
            TrackerEvent::Trouble(trouble, counts) => Some(with_drops(&trouble, &counts)),
            TrackerEvent::Feed(notice) => Self::of_feed(&notice),
        };
        if let Some(said) = said {
            warn(&said);
        }
    }

    /// What a device said at `now`, if it is to be said: its faults, states and
    /// texts, commands that it refused, and eyes that it lost or found. What the eyes
    /// do otherwise, and what it does not measure, the records tell.
    pub(in crate::cli) fn of_device(&mut self, message: &Message, now: Micros) -> Option<String> {
        let (kind, what) = match message {
            Message::Fault { code, meaning } => (
                ("fault", *code),
                format!("the device reports fault {code}{}", meant(meaning)),
            ),
            Message::State { code, meaning } => (
                ("state", *code),
                format!("the device is in state {code}{}", meant(meaning)),
            ),
            Message::Text(text) => (
                ("text", 0),
                format!("the device says \"{}\"", text.as_str()),
            ),
            Message::Reply(reply) if reply.result != 0 => (
                ("reply", reply.to),
                Failure::Refused {
                    command: reply.to,
                    result: reply.result,
                    meaning: reply.meaning,
                }
                .to_string(),
            ),
            Message::Eyes(event) => {
                let eye = match event.eye {
                    None => "the eyes",
                    Some(Side::Left) => "the left eye",
                    Some(Side::Right) => "the right eye",
                };
                match event.kind {
                    EyeEventKind::Lost => (("lost", 0), format!("the device has lost {eye}")),
                    EyeEventKind::Found => (("found", 0), format!("the device sees {eye} again")),
                    _ => return None,
                }
            }
            _ => return None,
        };
        self.say(kind, now, &what)
    }

    /// What a feed says of its device, if it is to be said; that it was plugged in is
    /// not.
    pub(in crate::cli) fn of_feed(notice: &Notice) -> Option<String> {
        Some(match notice {
            Notice::Decoded(_) | Notice::Plugged(_) | Notice::Described(_) => return None,
            Notice::Unplugged { path, reason } => {
                format!("{path} is gone ({reason}); waiting for it")
            }
            Notice::Refused(reason) => format!("{reason}; trying again"),
            Notice::Trouble(trouble) => trouble.to_string(),
            Notice::Restarting(most) => format!(
                "the device restarts: it says nothing for up to {:.0} s",
                most.seconds()
            ),
            Notice::Pause(pause) => format!(
                "the recording holds nothing for the next {:.1} s: it goes on then",
                pause.seconds()
            ),
        })
    }

    /// What a clock did at `now`, if it is to be said.
    pub(in crate::cli) fn of_clock(&mut self, event: &ClockEvent, now: Micros) -> Option<String> {
        let (kind, what) = match event {
            ClockEvent::Restarted { jump } => (
                "restarted",
                format!(
                    "the device's clock jumped by {} ms and goes on from there",
                    milliseconds(*jump)
                ),
            ),
            ClockEvent::Outlier { jump } => (
                "outlier",
                format!(
                    "a time of the device's is off by {} ms: it is not used",
                    milliseconds(*jump)
                ),
            ),
            ClockEvent::Frozen { since } => (
                "frozen",
                format!(
                    "the device's clock has stood still for {} ms",
                    since.0 / 1_000
                ),
            ),
            ClockEvent::Thawed { after } => (
                "thawed",
                format!(
                    "the device's clock runs again, after {} ms",
                    after.0 / 1_000
                ),
            ),
            _ => return None,
        };
        self.say((kind, 0), now, &what)
    }

    /// What became of a gaze or a head at `now`, if it is to be said: that it was
    /// not used, or never changes.
    /// The states, blinks and saccades are told by the records.
    pub(in crate::cli) fn of_gaze(&mut self, event: &Event, now: Micros) -> Option<String> {
        let reason = match event {
            Event::Rejected { reason, .. } => reason,
            Event::HeadStill { since, .. } => {
                let what = format!(
                    "the head has not changed by a bit for {} ms, nor before: is it on a stand, \
                     or the tracker stuck?",
                    since.0 / 1_000
                );
                return self.say(("head still", 0), now, &what);
            }
            _ => return None,
        };
        let (kind, what) = match reason {
            Rejection::NotNewer => ("not newer", "it is older than what is known".to_owned()),
            Rejection::Eccentric { angle } => (
                "eccentric",
                format!(
                    "the gaze is {:.0}° from straight ahead, which is farther than eyes turn",
                    angle.to_degrees()
                ),
            ),
            Rejection::Uncalibrated => (
                "uncalibrated",
                "the gaze is a point, and neither a screen nor a calibration says where".to_owned(),
            ),
            Rejection::NotFinite => ("not finite", "a number is not finite".to_owned()),
            Rejection::Stuck { since } => (
                "stuck",
                format!("the gaze has not changed for {} ms", since.0 / 1_000),
            ),
            Rejection::HeadStuck { part, since } => {
                let (kind, part) = match part {
                    HeadPart::Position => ("position stuck", "position"),
                    HeadPart::Orientation => ("orientation stuck", "orientation"),
                };
                let ms = since.0 / 1_000;
                (
                    kind,
                    format!("the head's {part} has not changed for {ms} ms"),
                )
            }
            _ => return None,
        };
        self.say((kind, 0), now, &format!("a sample is not used: {what}"))
    }

    /// That a tracker sends too much from `now` on, if it is to be said.
    fn of_flood(&mut self, one_of: u64, now: Micros) -> Option<String> {
        let what = format!(
            "the tracker sends more than is of use: one of {one_of} samples is taken; set it to \
             1000 a second or fewer"
        );
        self.say(("flood", 0), now, &what)
    }

    fn say(&mut self, kind: Kind, now: Micros, what: &str) -> Option<String> {
        if let Some(said) = self.0.get_mut(&kind)
            && now.since(said.at) < STEP
        {
            said.unsaid += 1;
            return None;
        }
        if self.0.len() >= MOST_KINDS && !self.0.contains_key(&kind) {
            let oldest = self.0.iter().min_by_key(|(_, said)| said.at);
            if let Some(oldest) = oldest.map(|(&kind, _)| kind) {
                self.0.remove(&oldest);
            }
        }
        let said = Said { at: now, unsaid: 0 };
        let unsaid = self.0.insert(kind, said).map_or(0, |said| said.unsaid);
        let at = now.seconds();
        Some(match unsaid {
            0 => format!("at {at:.3} s {what}"),
            count => format!("at {at:.3} s {what} (and {count} times before)"),
        })
    }
}

/// What the manual says, if it says anything.
fn meant(meaning: &str) -> String {
    if meaning.is_empty() {
        String::new()
    } else {
        format!(": {meaning}")
    }
}

fn milliseconds(micros: i64) -> i64 {
    micros / 1_000
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_is_said_at_once_and_then_once_a_second() {
        let mut happenings = Happenings::default();
        let rejected = |reason| Event::Rejected {
            at: Micros(0),
            reason,
        };
        let stuck = rejected(Rejection::Stuck {
            since: Micros(250_000),
        });
        let mut said = Vec::new();
        for step in 0..300 {
            let now = Micros::from_millis(10 * step);
            said.extend(happenings.of_gaze(&stuck, now));
            if step == 50 {
                let jump = ClockEvent::Restarted { jump: -7_000_000 };
                said.extend(happenings.of_clock(&jump, now));
            }
        }
        let stuck = "a sample is not used: the gaze has not changed for 250 ms";
        assert_eq!(
            said,
            [
                format!("at 0.000 s {stuck}"),
                "at 0.500 s the device's clock jumped by -7000 ms and goes on from there".into(),
                format!("at 1.000 s {stuck} (and 99 times before)"),
                format!("at 2.000 s {stuck} (and 99 times before)"),
            ]
        );
        let blink = Event::BlinkStarted { at: Micros(0) };
        assert_eq!(happenings.of_gaze(&blink, Micros(0)), None);
    }

    #[test]
    fn a_device_that_makes_up_numbers_takes_no_more_memory() {
        let mut happenings = Happenings::default();
        for code in 0..10_000 {
            let fault = Message::Fault { code, meaning: "" };
            let now = Micros(u64::from(code));
            assert!(happenings.of_device(&fault, now).is_some());
            assert!(happenings.0.len() <= MOST_KINDS);
        }
        // What was said last is still known.
        let fault = Message::Fault {
            code: 9_999,
            meaning: "",
        };
        assert_eq!(happenings.of_device(&fault, Micros(10_000)), None);
    }

    #[test]
    fn what_a_device_says_is_told_by_kind_and_number() {
        use shisen_tracker::decoder::{EyeEvent, Reply};
        let mut happenings = Happenings::default();
        let fault = |code, meaning| Message::Fault { code, meaning };
        let eyes = |kind| {
            Message::Eyes(EyeEvent {
                kind,
                eye: Some(Side::Left),
                device_time: None,
                duration: None,
            })
        };
        let reply = |to, result, meaning| {
            Message::Reply(Reply {
                to,
                result,
                meaning,
            })
        };
        let mut said = Vec::new();
        for (ms, message) in [
            (0, fault(107, "signal low")),
            (10, fault(107, "signal low")),
            (20, fault(9_007, "")),
            (30, reply(0x9A, 0, "")),
            (40, reply(0x9A, 3, "tracker not ready")),
            (45, reply(u32::from(b'O'), 42, "")),
            (50, eyes(EyeEventKind::Saccade)),
            (60, eyes(EyeEventKind::Lost)),
            (1_000, fault(107, "signal low")),
        ] {
            said.extend(happenings.of_device(&message, Micros::from_millis(ms)));
        }
        assert_eq!(
            said,
            [
                "at 0.000 s the device reports fault 107: signal low",
                "at 0.020 s the device reports fault 9007",
                "at 0.040 s the device refused command 0x9a: tracker not ready (code 3)",
                "at 0.045 s the device refused command 'O' with code 42",
                "at 0.060 s the device has lost the left eye",
                "at 1.000 s the device reports fault 107: signal low (and 1 times before)",
            ]
        );
    }
}
