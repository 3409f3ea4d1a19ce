//! Listening to a feed until somebody has enough.

use super::Interrupt;
use super::features::FeatureReport;
use super::happenings::Happenings;
use super::sample::{ByReason, by_reason};
use crate::cli::arguments::{span, whole};
use crate::cli::output::failure::Failure;
use crate::cli::output::{say, warn};
use crate::tracker::{Feed, Notice, Trouble};
use clap::Args;
use miette::Diagnostic;
use shisen_tracker::decoder::{Counts, Event};
use shisen_tracker::time::Micros;
use std::time::Duration;
use thiserror::Error;

/// When to end.
#[derive(Debug, Default, Args)]
#[group(id = "tracker-end")]
pub(super) struct EndArguments {
    /// End after so many samples
    #[arg(long, value_name = "N",
          value_parser = whole::<u64>(1..))]
    pub(super) frames: Option<u64>,
    /// End after so many seconds
    #[arg(long, value_name = "S",
          value_parser = span)]
    pub(super) seconds: Option<Duration>,
}

impl EndArguments {
    /// After how long.
    pub(super) fn span(&self) -> Option<Micros> {
        self.seconds.map(|span| Micros(span.as_micros() as u64))
    }
}

/// Nothing came in all the time.
#[derive(Debug, Error, Diagnostic)]
enum NoSample {
    /// And that is wrong.
    #[error("no sample came in {0} s")]
    #[diagnostic(help("check the device, its protocol and its speed, as said above"))]
    Silent(f64),
    /// Since it had no time to.
    #[error("no sample came in {0} s: the device is still restarting")]
    #[diagnostic(help("give --seconds more time, or leave reset=1 out"))]
    Restarting(f64),
    /// Since nothing was recorded then.
    #[error("no sample came in {0} s: the recording holds none in that time")]
    #[diagnostic(help("give --seconds more time"))]
    Pause(f64),
}

/// What events are handed to.
pub(super) type Take<'a> = dyn FnMut(&Feed, &Heard) -> Result<bool, Failure> + 'a;

/// What came at one time.
#[derive(Default)]
pub(super) struct Heard {
    pub(super) events: Vec<Event>,
    /// What an eye tracker says of itself, once it was plugged in.
    pub(super) features: Option<FeatureReport>,
}

/// Hands all events to `take`, none at times, until the end that was asked for, Ctrl-C, or the
/// end of a recording. What happens to the device goes to standard error. `take`
/// says whether it wants more.
pub(super) fn follow(
    feed: &mut Feed,
    end: &EndArguments,
    take: &mut Take<'_>,
) -> Result<(), Failure> {
    let interrupt = Interrupt::watched();
    let last = end.span().map(|span| feed.begin().after(span));
    let mut samples = 0;
    let mut heard = Heard::default();
    let mut troubles = Vec::new();
    loop {
        let now = feed.now();
        heard.events.clear();
        heard.features = None;
        let full = |samples| end.frames.is_some_and(|most| samples >= most);
        feed.poll(now, &mut |notice| match notice {
            Notice::Decoded(event) => {
                if !full(samples) {
                    samples += u64::from(matches!(event, Event::Sample(_)));
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
            other => {
                if let Some(told) = Happenings::of_feed(&other) {
                    warn(&told);
                }
            }
        });
        for trouble in troubles.drain(..) {
            warn(&with_drops(&trouble, &feed.counts()));
        }
        let more = take(feed, &heard)?;
        if !more || full(samples) || feed.is_over() || interrupt.came() {
            return Ok(());
        }
        if let (Some(last), Some(span)) = (last, end.seconds)
            && now >= last
        {
            let seconds = span.as_secs_f64();
            return if samples == 0 {
                Err(if feed.is_resetting() {
                    NoSample::Restarting(seconds)
                } else if feed.is_live() {
                    NoSample::Silent(seconds)
                } else {
                    NoSample::Pause(seconds)
                }
                .into())
            } else {
                Ok(())
            };
        }
        if !feed.is_live() {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// What is wrong, and what became of the bytes so far: of damaged records others are
/// wrong than of a wrong speed.
pub(in crate::cli) fn with_drops(trouble: &Trouble, counts: &Counts) -> String {
    let reasons = by_reason(counts);
    if reasons.is_empty() {
        return trouble.to_string();
    }
    format!("{trouble}; thrown away so far:{}", ByReason(&reasons))
}
