//! A tracker that is read while frames are rendered.

mod rhythm;

use super::lock;
use crate::tracker::{Feed, FeedClock, Notice, Trouble};
use rhythm::Rhythm;
use shisen_tracker::clock::{self, ClockEstimator};
use shisen_tracker::decoder::{Counts, Event, Message};
use shisen_tracker::estimate::{self, Estimate, GazeEstimator};
use shisen_tracker::time::Micros;
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The pause between polls of a feed that does not wait by itself.
const PAUSE: Duration = Duration::from_micros(100);

/// The events that fit without allocating.
const EVENTS: usize = 64;

/// The longest wait for the thread at the end.
const PATIENCE: Duration = Duration::from_secs(1);

/// A tracker with a thread of its own. Each sample goes into the estimator as it comes: no queue
/// grows. Of a sensor that sends 2,000 samples a second or more, 1,000 to 2,000 are used.
pub struct LiveTracker {
    feed: FeedClock,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl fmt::Debug for LiveTracker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LiveTracker").finish_non_exhaustive()
    }
}

struct Shared {
    following: Mutex<Following>,
    came: Condvar,
    over: AtomicBool,
    home: Estimate,
}

struct Following {
    clock: ClockEstimator,
    estimator: GazeEstimator,
    /// When the newest sample was measured, and when it came.
    newest: Option<(Micros, Micros)>,
    rhythm: Rhythm,
    samples: u64,
    passed_over: u64,
    counts: Counts,
}

/// An event of a tracker that is reported to people.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "events must not allocate")]
pub enum TrackerEvent {
    /// A notice of the feed: a device that comes and goes.
    Feed(Notice),
    /// A message of the device, and when it came.
    Device(Message, Micros),
    /// What is wrong, and the counts until then.
    Trouble(Trouble, Counts),
    /// An event of the device's clock, and the arrival of its sample.
    Clock(clock::ClockEvent, Micros),
    /// An event of the gaze, and the arrival of its sample.
    Gaze(estimate::Event, Micros),
    /// Too many samples: from this time on one in this many is used.
    Flood(u64, Micros),
}

/// A gaze that was taken for a frame. Times are on [`LiveTracker::now`]'s clock.
#[derive(Debug, Clone, Copy)]
pub struct LatchedGaze {
    /// The estimate for the time when the frame is shown.
    pub estimate: Estimate,
    /// When the newest sample was measured; `None` before the first.
    pub sample: Option<Micros>,
    /// When that sample came.
    pub arrive: Option<Micros>,
    /// Whether the gaze follows that sample: it is known, and the tracker was not silent for longer
    /// than a gaze is held ([`widen_after`](estimate::FallbackConfig::widen_after)).
    pub follows: bool,
    /// When the gaze was taken.
    pub latch: Micros,
    /// The number of samples so far.
    pub samples: u64,
    /// Samples that were not used because there were too many.
    pub passed_over: u64,
}

impl LiveTracker {
    /// Starts to read a feed; `report` gets its events.
    ///
    /// # Errors
    /// The system starts no thread.
    pub fn start(
        feed: Feed,
        clock: ClockEstimator,
        mut estimator: GazeEstimator,
        report: impl FnMut(TrackerEvent) + Send + 'static,
    ) -> std::io::Result<Self> {
        let feed_clock = feed.clock();
        let home = estimator.estimate(feed.now(), &mut |_| {});
        let shared = Arc::new(Shared {
            following: Mutex::new(Following {
                clock,
                estimator,
                newest: None,
                rhythm: Rhythm::NEW,
                samples: 0,
                passed_over: 0,
                counts: Counts::new(),
            }),
            came: Condvar::new(),
            over: AtomicBool::new(false),
            home,
        });
        let heard = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("tracker".to_owned())
            .spawn(move || listen(feed, &heard, report))?;
        Ok(Self {
            feed: feed_clock,
            shared,
            thread: Some(thread),
        })
    }

    /// Returns the time on the feed's clock.
    pub fn now(&self) -> Micros {
        self.at(Instant::now())
    }

    /// Converts a time of the system's clock to the feed's.
    pub fn at(&self, instant: Instant) -> Micros {
        self.feed.at(instant)
    }

    /// Returns the estimate before the first sample.
    pub fn home(&self) -> &Estimate {
        &self.shared.home
    }

    /// Waits for the last sample that is expected before a time; false where it does not come.
    pub fn wait(&self, until: Instant) -> bool {
        let shared = &self.shared;
        let mut following = lock(&shared.following);
        let last = self.at(until);
        while !following.rhythm.is_last_before(last) {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            let waited = shared.came.wait_timeout(following, left);
            (following, _) = waited.unwrap_or_else(PoisonError::into_inner);
        }
        true
    }

    /// Estimates the gaze at the time `display` from the samples until now.
    pub fn latch(&self, display: Micros) -> LatchedGaze {
        let mut following = lock(&self.shared.following);
        let latch = self.now();
        let shown = display.max(latch);
        let estimate = following.estimator.estimate(shown, &mut |_| {});
        let held = following.estimator.config().fallback.widen_after;
        let is_recent = |(_, arrive)| latch.since(arrive) <= held;
        LatchedGaze {
            follows: following.newest.is_some_and(is_recent)
                && estimate.state != estimate::State::FullQuality,
            estimate,
            sample: following.newest.map(|(sample, _)| sample),
            arrive: following.newest.map(|(_, arrive)| arrive),
            latch,
            samples: following.samples,
            passed_over: following.passed_over,
        }
    }

    /// Counts of bytes, samples and faults so far.
    pub fn counts(&self) -> Counts {
        lock(&self.shared.following).counts
    }
}

impl Drop for LiveTracker {
    fn drop(&mut self) {
        self.shared.over.store(true, Ordering::SeqCst);
        let Some(thread) = self.thread.take() else {
            return;
        };
        // A thread that is still busy reporting is left alone.
        let begun = Instant::now();
        while !thread.is_finished() && begun.elapsed() < PATIENCE {
            std::thread::sleep(PAUSE);
        }
        if thread.is_finished() {
            // A panic has printed its message.
            let _ = thread.join();
        }
    }
}

fn listen(mut feed: Feed, shared: &Shared, mut report: impl FnMut(TrackerEvent)) {
    let is_live = feed.is_live();
    let mut sensors = [Thinning::NEW; 256];
    // Reported after the lock is released: reporting may take long.
    let mut events = Vec::with_capacity(EVENTS);
    while !shared.over.load(Ordering::SeqCst) {
        let now = feed.now();
        let mut troubles = Vec::new();
        feed.poll(now, &mut |notice| {
            let sample = match &notice {
                Notice::Decoded(Event::Sample(sample)) => *sample,
                Notice::Decoded(Event::Message(message)) => {
                    lock(&shared.following)
                        .estimator
                        .on_message(message, &mut |_| {});
                    return report(TrackerEvent::Device(*message, now));
                }
                Notice::Decoded(_) => return,
                Notice::Trouble(trouble) => return troubles.push(*trouble),
                Notice::Offset { at, offset } => {
                    return lock(&shared.following).clock.set_offset(*at, *offset);
                }
                _ => return report(TrackerEvent::Feed(notice)),
            };
            let mut following = lock(&shared.following);
            let arrival = sample.arrival;
            let stamp = following.clock.stamp(&sample, &mut |event| {
                events.push(TrackerEvent::Clock(event, arrival));
            });
            following.samples += 1;
            let thinning = &mut sensors[usize::from(sample.sensor)];
            let before = thinning.one_of;
            let is_used = thinning.uses(arrival);
            if before == 1 && thinning.one_of > 1 {
                events.push(TrackerEvent::Flood(thinning.one_of, arrival));
            }
            if is_used {
                following.estimator.push(&sample, stamp.time, &mut |event| {
                    events.push(TrackerEvent::Gaze(event, arrival));
                });
                // A simulated sample comes when it is polled.
                let came = if is_live { arrival } else { now.max(arrival) };
                following.newest = Some((stamp.time, came));
                following.rhythm.hear(came);
            } else {
                following.passed_over += 1;
            }
            drop(following);
            if is_used {
                shared.came.notify_all();
            }
            events.drain(..).for_each(&mut report);
        });
        let counts = feed.counts();
        for trouble in troubles {
            report(TrackerEvent::Trouble(trouble, counts));
        }
        lock(&shared.following).counts = counts;
        if !is_live {
            std::thread::sleep(PAUSE);
        }
    }
}

/// Samples used per second of a tracker that sends more: at least this many, less than twice it.
const USED: u64 = 1_000;

/// Window over which the rate is measured: long enough that a buffer's samples, which come all at
/// once, do not count as a flood.
const OVER: Micros = Micros::from_millis(250);

/// Chooses the samples to use from a sensor that sends more than the estimator is made for.
#[derive(Clone, Copy)]
struct Thinning {
    since: Option<Micros>,
    counted: u64,
    /// One sample in this many is used.
    one_of: u64,
}

impl Thinning {
    const NEW: Self = Self {
        since: None,
        counted: 0,
        one_of: 1,
    };

    /// Returns whether to use a sample that came at `arrival`.
    fn uses(&mut self, arrival: Micros) -> bool {
        let passed = arrival.since(*self.since.get_or_insert(arrival));
        if passed >= OVER {
            let a_second = 1_000_000 * self.counted / passed.0;
            self.one_of = (a_second / USED).max(1);
            (self.since, self.counted) = (Some(arrival), 0);
        }
        self.counted += 1;
        self.counted.is_multiple_of(self.one_of)
    }
}
