//! Announces what happens to a tracker, to its clock and to the gaze.

use super::drops::with_drops;
use super::warn_of_sensors;
use crate::cli::output::warn;
use crate::tracker::{Notice, Role, TrackerEvent};
use shisen_tracker::clock::ClockEvent;
use shisen_tracker::command::Failure;
use shisen_tracker::decoder::{EyeEventKind, Message, Side};
use shisen_tracker::estimate::{Event, HeadPart, Rejection};
use shisen_tracker::time::Micros;
use std::collections::BTreeMap;

/// Most kinds that are remembered: a device may make up any number of them.
const MOST_KINDS: usize = 64;

/// Least time between two announcements of one kind.
const STEP: Micros = Micros::from_millis(1_000);

/// Announces each kind of event at once, then at most once a second. An announcement counts the
/// events of its kind that were not announced.
#[derive(Debug, Default)]
pub(in crate::cli) struct Announcer {
    /// What the tracker is read for, where there are several.
    role: Option<&'static str>,
    said: BTreeMap<Kind, Announcement>,
}

/// A name, and a number if the device has one.
type Kind = (&'static str, u32);

#[derive(Debug)]
struct Announcement {
    at: Micros,
    unsaid: u64,
}

impl Announcer {
    /// Announces the events of a tracker that is read for a part.
    pub(in crate::cli) fn of(role: Role) -> Self {
        Self {
            role: role.name(),
            ..Self::default()
        }
    }

    /// Announces an event on standard error.
    pub(in crate::cli) fn announce(&mut self, happening: TrackerEvent) {
        let said = match happening {
            TrackerEvent::Clock(event, at) => self.of_clock(&event, at),
            TrackerEvent::Gaze(event, at) => {
                warn_of_sensors(&event);
                self.of_gaze(&event, at)
            }
            TrackerEvent::Flood(one_of, at) => {
                let text = format!(
                    "the tracker sends more than is of use: one of {one_of} samples is taken; set \
                     it to 1000 a second or fewer"
                );
                self.say(("flood", 0), at, &text)
            }
            TrackerEvent::Device(message, at) => self.of_device(&message, at),
            TrackerEvent::Trouble(trouble, counts) => Some(with_drops(&trouble, &counts)),
            TrackerEvent::Feed(notice) => Self::of_feed(&notice),
        };
        if let Some(said) = said {
            warn(
                &self
                    .role
                    .map_or(said.clone(), |role| format!("{role}: {said}")),
            );
        }
    }

    /// Puts into words what a device said: faults, states, texts, refused commands, and eyes that
    /// it lost or found. The samples tell the rest.
    fn of_device(&mut self, message: &Message, now: Micros) -> Option<String> {
        let mut say = |kind, what: &str| self.say(kind, now, what);
        match message {
            Message::Fault { code, meaning } => {
                let what = format!("the device reports fault {code}{}", meant(meaning));
                say(("fault", *code), &what)
            }
            Message::State { code, meaning } => {
                let what = format!("the device is in state {code}{}", meant(meaning));
                say(("state", *code), &what)
            }
            Message::Text(text) => {
                let what = format!("the device says \"{}\"", text.as_str());
                say(("text", 0), &what)
            }
            Message::Reply(reply) if reply.result != 0 => {
                let refused = Failure::Refused {
                    command: reply.to,
                    result: reply.result,
                    meaning: reply.meaning,
                };
                say(("reply", reply.to), &refused.to_string())
            }
            Message::Eyes(event) => {
                let eye = match event.eye {
                    None => "the eyes",
                    Some(Side::Left) => "the left eye",
                    Some(Side::Right) => "the right eye",
                };
                match event.kind {
                    EyeEventKind::Lost => say(("lost", 0), &format!("the device has lost {eye}")),
                    EyeEventKind::Found => {
                        say(("found", 0), &format!("the device sees {eye} again"))
                    }
                    _ => None,
                }
            }
            _ => None,
        }
    }

    /// Puts into words what a feed says of its device, but not that it was plugged in.
    fn of_feed(notice: &Notice) -> Option<String> {
        Some(match notice {
            Notice::Decoded(_)
            | Notice::Plugged(_)
            | Notice::Described(_)
            | Notice::Offset { .. } => return None,
            Notice::Said(text) => text.clone(),
            Notice::Unplugged { path, reason } => {
                format!("{path} is gone ({reason}); waiting for it to come back")
            }
            Notice::Refused(reason) => format!("{reason}; trying again"),
            Notice::Trouble(trouble) => trouble.to_string(),
            Notice::Restarting(most) => format!(
                "the device restarts: it says nothing for up to {:.0} s",
                most.seconds()
            ),
            Notice::Pause(pause) => {
                let seconds = pause.seconds();
                format!("the recording holds nothing for the next {seconds:.1} s")
            }
        })
    }

    /// Puts into words what a device's clock did.
    fn of_clock(&mut self, event: &ClockEvent, now: Micros) -> Option<String> {
        let mut say = |kind, what: &str| self.say((kind, 0), now, what);
        match event {
            ClockEvent::Restarted { jump } => {
                let ms = jump / 1_000;
                let what = format!("the device's clock jumped by {ms} ms and goes on from there");
                say("restarted", &what)
            }
            ClockEvent::Outlier { jump } => {
                let ms = jump / 1_000;
                let what = format!("a time of the device is off by {ms} ms: it is not used");
                say("outlier", &what)
            }
            ClockEvent::Frozen { since } => {
                let ms = since.0 / 1_000;
                let what = format!("the device's clock has stood still for {ms} ms");
                say("frozen", &what)
            }
            ClockEvent::Thawed { after } => {
                let ms = after.0 / 1_000;
                let what = format!("the device's clock runs again, after {ms} ms");
                say("thawed", &what)
            }
            _ => None,
        }
    }

    /// Puts into words that a gaze or a head was not used, or never changes. The samples tell
    /// states, blinks and saccades.
    fn of_gaze(&mut self, event: &Event, now: Micros) -> Option<String> {
        let reason = match event {
            Event::Rejected { reason, .. } => reason,
            Event::HeadStill { since, .. } => {
                let what = format!(
                    "the head has not changed by a bit for {} ms, nor ever before: is it on a \
                     stand, or is the tracker stuck?",
                    since.0 / 1_000
                );
                return self.say(("head still", 0), now, &what);
            }
            _ => return None,
        };
        let mut say = |kind, what: &str| {
            let what = format!("a sample is not used: {what}");
            self.say((kind, 0), now, &what)
        };
        match reason {
            Rejection::NotNewer => say("not newer", "it is older than the newest one"),
            Rejection::Eccentric { angle } => {
                let angle = angle.to_degrees();
                let what =
                    format!("the gaze is {angle:.0}° from straight ahead, farther than eyes turn");
                say("eccentric", &what)
            }
            Rejection::Uncalibrated => {
                let what = "the gaze is a point, and no screen or calibration says where it is";
                say("uncalibrated", what)
            }
            Rejection::NotFinite => say("not finite", "a number is not finite"),
            Rejection::Stuck { since } => {
                let ms = since.0 / 1_000;
                say("stuck", &format!("the gaze has not changed for {ms} ms"))
            }
            Rejection::HeadStuck { part, since } => {
                let (kind, part) = match part {
                    HeadPart::Position => ("position stuck", "position"),
                    HeadPart::Orientation => ("orientation stuck", "orientation"),
                };
                let ms = since.0 / 1_000;
                say(
                    kind,
                    &format!("the head's {part} has not changed for {ms} ms"),
                )
            }
            _ => None,
        }
    }

    /// Adds the time; `None` if the kind was announced within the last second.
    fn say(&mut self, kind: Kind, now: Micros, what: &str) -> Option<String> {
        if let Some(said) = self.said.get_mut(&kind)
            && now.since(said.at) < STEP
        {
            said.unsaid += 1;
            return None;
        }
        if self.said.len() >= MOST_KINDS && !self.said.contains_key(&kind) {
            let oldest = self.said.iter().min_by_key(|(_, said)| said.at);
            if let Some(oldest) = oldest.map(|(&kind, _)| kind) {
                self.said.remove(&oldest);
            }
        }
        let said = Announcement { at: now, unsaid: 0 };
        let unsaid = self.said.insert(kind, said).map_or(0, |said| said.unsaid);
        let at = now.seconds();
        Some(match unsaid {
            0 => format!("at {at:.3} s {what}"),
            count => format!("at {at:.3} s {what} (and {count} times before)"),
        })
    }
}

/// Returns the meaning that the manual gives, if any.
fn meant(meaning: &str) -> String {
    let mark = if meaning.is_empty() { "" } else { ": " };
    format!("{mark}{meaning}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use shisen_tracker::decoder::{EyeEvent, Reply};

    #[test]
    fn each_kind_is_said_at_once_and_then_once_a_second() {
        let mut announcer = Announcer::default();
        let since = Micros(250_000);
        let stuck = Event::Rejected {
            at: Micros(0),
            reason: Rejection::Stuck { since },
        };
        let mut said = Vec::new();
        for step in 0..300 {
            let now = Micros::from_millis(10 * step);
            said.extend(announcer.of_gaze(&stuck, now));
            if step == 50 {
                let jump = ClockEvent::Restarted { jump: -7_000_000 };
                said.extend(announcer.of_clock(&jump, now));
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
        assert_eq!(announcer.of_gaze(&blink, Micros(0)), None);
    }

    #[test]
    fn a_device_that_makes_up_numbers_takes_no_more_memory() {
        let mut announcer = Announcer::default();
        let fault = |code| Message::Fault { code, meaning: "" };
        for code in 0..10_000 {
            let now = Micros(u64::from(code));
            assert!(announcer.of_device(&fault(code), now).is_some());
            assert!(announcer.said.len() <= MOST_KINDS);
        }
        // The newest kind is remembered.
        assert_eq!(announcer.of_device(&fault(9_999), Micros(10_000)), None);
    }

    #[test]
    fn agreement_and_saccades_are_not_told() {
        let reply = |result| {
            let (to, meaning) = (0x9A, "tracker not ready");
            Message::Reply(Reply {
                to,
                result,
                meaning,
            })
        };
        let eyes = |kind| {
            Message::Eyes(EyeEvent {
                kind,
                eye: Some(Side::Left),
                device_time: None,
                duration: None,
            })
        };
        let (saccade, lost) = (eyes(EyeEventKind::Saccade), eyes(EyeEventKind::Lost));
        let mut announcer = Announcer::default();
        let said = [reply(0), reply(3), saccade, lost];
        let said = said.map(|message| announcer.of_device(&message, Micros(0)));
        let refused = "at 0.000 s the device refused command 0x9a: tracker not ready (code 3)";
        let lost = "at 0.000 s the device has lost the left eye";
        assert_eq!(said, [None, Some(refused.into()), None, Some(lost.into())]);
    }
}
