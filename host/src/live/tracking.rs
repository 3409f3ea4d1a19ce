//! A tracker that is listened to while frames are rendered.

mod rhythm;
mod thinning;

use crate::tracker::{Feed, FeedClock, Notice, Trouble};
use rhythm::Rhythm;
use shisen_tracker::clock::{self, ClockEstimator};
use shisen_tracker::decoder::{Counts, Event, Message};
use shisen_tracker::estimate::{self, Estimate, GazeEstimator};
use shisen_tracker::time::Micros;
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use thinning::Thinning;

/// How long a feed that does not wait by itself is left alone.
const PAUSE: Duration = Duration::from_micros(100);

/// Of what a sample makes happen, so much finds room without memory being taken for it.
const HAPPENINGS: usize = 64;

/// How long the thread is waited for at the end.
const PATIENCE: Duration = Duration::from_secs(1);

/// A tracker with a thread of its own. Each sample is put into the estimator as it
/// comes: there is no queue that could grow, and what a tracker sends too fast
/// waits in the system's own buffer, which loses what it has no room for. Of a sensor
/// that sends 2,000 a second or more 1,000 to 2,000 are used, evenly.
pub struct LiveTracker {
    feed: FeedClock,
    shared: Arc<Shared>,
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl fmt::Debug for LiveTracker {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counts = self.counts();
        f.debug_struct("LiveTracker")
            .field("feed", &self.feed)
            .field("counts", &counts)
            .finish_non_exhaustive()
    }
}

/// What the thread and those who ask it have in common.
struct Shared {
    following: Mutex<Following>,
    /// A sample came.
    came: Condvar,
    /// What is taken to be seen before the first.
    home: Estimate,
}

/// What is known of the viewer.
struct Following {
    clock: ClockEstimator,
    estimator: GazeEstimator,
    /// When the newest sample was measured and came.
    newest: Option<(Micros, Micros)>,
    rhythm: Rhythm,
    samples: u64,
    passed_over: u64,
    counts: Counts,
}

/// Something to be told about a tracker.
#[derive(Debug, Clone, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "as of a notice: none of these is to take memory of its own"
)]
pub enum Happening {
    /// The feed's own: a device that comes and goes.
    Feed(Notice),
    /// What a device said then.
    Device(Message, Micros),
    /// What is wrong, and what became of the bytes until then.
    Trouble(Trouble, Counts),
    /// Of the device's clock, for a sample that came then.
    Clock(clock::ClockEvent, Micros),
    /// Of the gaze, for a sample that came then.
    Gaze(estimate::Event, Micros),
    /// From then on one of so many samples is used: there are too many.
    Flood(u64, Micros),
}

/// A gaze that was taken for a frame. Times are on [`LiveTracker::now`]'s clock.
#[derive(Debug, Clone, Copy)]
pub struct Latched {
    /// Where the viewer looks when the frame is shown.
    pub estimate: Estimate,
    /// When the newest sample was measured; `None` before the first.
    pub sample: Option<Micros>,
    /// When it came.
    pub arrive: Option<Micros>,
    /// Whether the gaze follows that sample: it is known, and the tracker has not been
    /// silent for longer than a gaze is held
    /// ([`widen_after`](estimate::FallbackConfig::widen_after)). How late the sample was
    /// when it came does not count: that is the tracker's delay.
    pub follows: bool,
    /// When the gaze was taken.
    pub latch: Micros,
    /// Samples so far.
    pub samples: u64,
    /// Those of them that were not used, as there were too many.
    pub passed_over: u64,
}

impl LiveTracker {
    /// Listens to a feed from now on; `tell` hears of what is no sample.
    ///
    /// # Errors
    /// A thread that cannot be had.
    pub fn start(
        feed: Feed,
        clock: ClockEstimator,
        mut estimator: GazeEstimator,
        tell: impl FnMut(Happening) + Send + 'static,
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
            home,
        });
        let over = Arc::new(AtomicBool::new(false));
        let (heard, ended) = (Arc::clone(&shared), Arc::clone(&over));
        let thread = std::thread::Builder::new()
            .name("tracker".to_owned())
            .spawn(move || listen(feed, &heard, &ended, tell))?;
        Ok(Self {
            feed: feed_clock,
            shared,
            over,
            thread: Some(thread),
        })
    }

    /// What the feed's clock shows.
    pub fn now(&self) -> Micros {
        self.at(Instant::now())
    }

    /// A time of the system's clock on this one.
    pub fn at(&self, instant: Instant) -> Micros {
        self.feed.at(instant)
    }

    /// Where the viewer was taken to look before the first sample.
    pub fn home(&self) -> &Estimate {
        &self.shared.home
    }

    /// Waits for the last sample that is expected until then, by how they came of late; or
    /// till then where that does not come, and says false.
    pub fn wait(&self, until: Instant) -> bool {
        let shared = &self.shared;
        let mut following = shared.lock();
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

    /// Where the viewer looks at `display`, by all that has come until now.
    pub fn latch(&self, display: Micros) -> Latched {
        let mut following = self.shared.lock();
        let latch = self.now();
        let estimate = following
            .estimator
            .estimate(display.max(latch), &mut |_| {});
        let held = following.estimator.config().fallback.widen_after;
        let is_recent = |(_, arrive)| latch.since(arrive) <= held;
        Latched {
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

    /// What became of the tracker's bytes so far.
    pub fn counts(&self) -> Counts {
        self.shared.lock().counts
    }
}

impl Drop for LiveTracker {
    fn drop(&mut self) {
        self.over.store(true, Ordering::SeqCst);
        let Some(thread) = self.thread.take() else {
            return;
        };
        // One that is kept by whom it tells something is left to itself.
        let begun = Instant::now();
        while !thread.is_finished() && begun.elapsed() < PATIENCE {
            std::thread::sleep(PAUSE);
        }
        if thread.is_finished() {
            // One that panicked has said so.
            let _ = thread.join();
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Following> {
        self.following
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

/// The thread's life.
fn listen(mut feed: Feed, shared: &Shared, over: &AtomicBool, mut tell: impl FnMut(Happening)) {
    let is_live = feed.is_live();
    let mut sensors = [Thinning::NEW; 256];
    // What is to be told while nobody waits for what is followed: telling may take long.
    let mut happenings = Vec::with_capacity(HAPPENINGS);
    while !over.load(Ordering::SeqCst) {
        let now = feed.now();
        let mut troubles = Vec::new();
        feed.poll(now, &mut |notice| {
            let sample = match &notice {
                Notice::Decoded(Event::Sample(sample)) => *sample,
                Notice::Decoded(Event::Message(message)) => {
                    shared.lock().estimator.on_message(message, &mut |_| {});
                    return tell(Happening::Device(*message, now));
                }
                Notice::Decoded(_) => return,
                Notice::Trouble(trouble) => return troubles.push(*trouble),
                _ => return tell(Happening::Feed(notice)),
            };
            let mut locked = shared.lock();
            let Following {
                clock,
                estimator,
                newest,
                rhythm,
                samples,
                passed_over,
                ..
            } = &mut *locked;
            let arrival = sample.arrival;
            let stamp = clock.stamp(&sample, &mut |event| {
                happenings.push(Happening::Clock(event, arrival));
            });
            *samples += 1;
            let thinning = &mut sensors[usize::from(sample.sensor)];
            let before = thinning.one_of();
            let is_used = thinning.uses(arrival);
            if before == 1 && thinning.one_of() > 1 {
                happenings.push(Happening::Flood(thinning.one_of(), arrival));
            }
            if is_used {
                estimator.push(&sample, stamp.time, &mut |event| {
                    happenings.push(Happening::Gaze(event, arrival));
                });
                // What is simulated is here when it is asked for, not before.
                let came = if is_live { arrival } else { now.max(arrival) };
                *newest = Some((stamp.time, came));
                rhythm.hear(came);
            } else {
                *passed_over += 1;
            }
            drop(locked);
            if is_used {
                shared.came.notify_all();
            }
            happenings.drain(..).for_each(&mut tell);
        });
        let counts = feed.counts();
        for trouble in troubles {
            tell(Happening::Trouble(trouble, counts));
        }
        shared.lock().counts = counts;
        if !is_live {
            std::thread::sleep(PAUSE);
        }
    }
}
