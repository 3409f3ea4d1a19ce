//! Listens to a tracker until the end that is asked for.

use super::Interrupt;
use super::announcer::Announcer;
use super::features::FeatureReport;
use crate::cli::arguments::span;
use crate::cli::prelude::*;
use crate::tracker::{Feed, Notice, TrackerEvent};
use shisen_tracker::decoder::Event;
use shisen_tracker::time::Micros;

#[derive(Debug, Default, Args)]
#[group(id = "tracker-end")]
pub(super) struct EndArguments {
    /// End after N samples
    #[arg(long, value_name = "N", value_parser = whole::<u64>(1..))]
    pub(super) frames: Option<u64>,
    /// End after S seconds
    #[arg(long, value_name = "S", value_parser = span)]
    pub(super) seconds: Option<Duration>,
}

impl EndArguments {
    pub(super) fn span(&self) -> Option<Micros> {
        self.seconds.map(|span| Micros(span.as_micros() as u64))
    }
}

/// Takes events; returns whether it wants more.
pub(super) type Take<'a> = dyn FnMut(&Feed, &Heard) -> Result<bool, Failure> + 'a;

#[derive(Default)]
pub(super) struct Heard {
    pub(super) events: Vec<Event>,
    /// What an eye tracker that was plugged in says of itself.
    pub(super) features: Option<FeatureReport>,
    /// By how many microseconds the device's clock is ahead of the feed's at a time.
    pub(super) offset: Option<(Micros, i64)>,
}

/// Hands all events to `take` until it wants no more, or until the end that is asked for, Ctrl-C,
/// or the end of a recording. Samples are counted of one sensor, or of all. Announces what happens to
/// the device.
pub(super) fn follow(
    feed: &mut Feed,
    end: &EndArguments,
    counted: Option<u8>,
    take: &mut Take<'_>,
) -> Result<(), Failure> {
    let interrupt = Interrupt::watched();
    let last = end.span().map(|span| feed.begin().after(span));
    let mut announcer = Announcer::default();
    let mut samples = 0;
    let mut heard = Heard::default();
    let mut troubles = Vec::new();
    loop {
        let now = feed.now();
        heard.events.clear();
        heard.features = None;
        heard.offset = None;
        let full = |samples| end.frames.is_some_and(|most| samples >= most);
        feed.poll(now, &mut |notice| match notice {
            Notice::Decoded(event) => {
                if !full(samples) {
                    let is_counted = matches!(&event, Event::Sample(sample)
                        if counted.is_none_or(|one| one == sample.sensor));
                    samples += u64::from(is_counted);
                    heard.events.push(event);
                }
            }
            Notice::Plugged(path) => say(&format!("{path} is plugged in")),
            Notice::Described(features) => {
                let features = FeatureReport::from(&*features);
                say(&format!("it says of itself: {features}"));
                heard.features = Some(features);
            }
            Notice::Trouble(trouble) => troubles.push(trouble),
            Notice::Offset { at, offset } => heard.offset = Some((at, offset)),
            other => announcer.announce(TrackerEvent::Feed(other)),
        });
        for trouble in troubles.drain(..) {
            announcer.announce(TrackerEvent::Trouble(trouble, feed.counts()));
        }
        let more = take(feed, &heard)?;
        if !more || full(samples) || feed.is_over() || interrupt.came() {
            return Ok(());
        }
        if let (Some(last), Some(span)) = (last, end.seconds)
            && now >= last
        {
            let (why, help) = match samples {
                0 if feed.is_resetting() => (
                    ": the device is still restarting",
                    "give --seconds more time, or leave reset=1 out",
                ),
                0 if feed.is_live() => ("", "check the device, its protocol and its speed"),
                0 => (
                    ": the recording holds none in that time",
                    "give --seconds more time",
                ),
                _ => return Ok(()),
            };
            let message = format!("no sample came in {} s{why}", span.as_secs_f64());
            return Err(Fault::new(message, help).into());
        }
        if !feed.is_live() {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}
