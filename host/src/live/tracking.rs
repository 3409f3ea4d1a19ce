//! A tracker that is read while frames are rendered.

mod rhythm;

use super::lock;
use crate::tracker::{ComposedGaze, FeedClock, Notice, Role, Source, Steering, TrackerEvent, Wand};
use hdrhistogram::Histogram;
use rhythm::Rhythm;
use shisen_tracker::decoder::{Counts, Event, Message};
use shisen_tracker::estimate::{self, Estimate};
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

/// A viewer's trackers, each with a thread of its own. Each sample goes into the estimator as it
/// comes: no queue grows. Of a sensor that sends 2,000 samples a second or more, 1,000 to 2,000 are
/// used.
pub struct LiveTracker {
    feed: FeedClock,
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
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
    /// The number of the source that the wand is on.
    wand_source: Option<usize>,
}

struct Following {
    gaze: ComposedGaze,
    sources: Vec<Followed>,
    /// The number of the source whose samples frames wait for: that of the gaze.
    leading: usize,
    passed_over: u64,
    /// What steers the viewer.
    wand: Option<Wand>,
}

/// What is known of a source so far.
struct Followed {
    state: SourceState,
    /// When the newest sample was measured, and when it came.
    newest: Option<(Micros, Micros)>,
    rhythm: Rhythm,
}

/// What hears of a tracker's events.
pub type Report = Box<dyn FnMut(TrackerEvent) + Send>;

/// How one of the trackers does.
#[derive(Debug, Clone)]
pub struct SourceState {
    /// What it is read for.
    pub role: Role,
    /// Samples of its head or gaze; of a wand also changes of buttons and axes.
    pub samples: u64,
    /// Its counts of bytes, samples and faults.
    pub counts: Counts,
    /// From the measurement of a sample to its arrival, microseconds.
    pub delay: Histogram<u64>,
    /// When its newest sample came.
    pub newest: Option<Micros>,
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
    /// Starts to read a viewer's trackers, which is one at least; the times are those of the first.
    /// A source's `Report` gets its events. A wand comes with the number of the source that it is
    /// on.
    ///
    /// # Errors
    /// The system starts no thread.
    pub fn start(
        sources: Vec<(Source, Report)>,
        mut gaze: ComposedGaze,
        wand: Option<(Wand, usize)>,
    ) -> std::io::Result<Self> {
        let first = sources.first().ok_or(std::io::ErrorKind::InvalidInput)?;
        let feed = first.0.feed.clock();
        let (wand, wand_source) = wand.unzip();
        let home = gaze.estimator.estimate(first.0.feed.now(), &mut |_| {});
        let followed = |source: &(Source, Report)| Followed {
            state: SourceState {
                role: source.0.intake.role(),
                samples: 0,
                counts: Counts::new(),
                // From a microsecond to ten seconds, to a hundredth.
                delay: Histogram::new_with_max(10_000_000, 2).unwrap_or_else(|_| unreachable!()),
                newest: None,
            },
            newest: None,
            rhythm: Rhythm::NEW,
        };
        let mut roles = sources.iter().map(|(source, _)| source.intake.role());
        let shared = Arc::new(Shared {
            following: Mutex::new(Following {
                gaze,
                leading: roles
                    .position(|role| matches!(role, Role::All | Role::Gaze))
                    .unwrap_or(0),
                sources: sources.iter().map(followed).collect(),
                passed_over: 0,
                wand,
            }),
            came: Condvar::new(),
            over: AtomicBool::new(false),
            home,
            wand_source,
        });
        let mut tracker = Self {
            feed,
            shared,
            threads: Vec::new(),
        };
        for (number, (source, report)) in sources.into_iter().enumerate() {
            let heard = Arc::clone(&tracker.shared);
            let thread = std::thread::Builder::new()
                .name("tracker".to_owned())
                .spawn(move || listen(number, source, &heard, report))?;
            tracker.threads.push(thread);
        }
        Ok(tracker)
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
        while !following.leading().rhythm.is_last_before(last) {
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
        let estimate = following.gaze.estimator.estimate(shown, &mut |_| {});
        let held = following.gaze.estimator.config().fallback.widen_after;
        let is_recent = |(_, arrive)| latch.since(arrive) <= held;
        let newest = following.leading().newest;
        LatchedGaze {
            follows: newest.is_some_and(is_recent)
                && estimate.state != estimate::State::FullQuality,
            estimate,
            sample: newest.map(|(sample, _)| sample),
            arrive: newest.map(|(_, arrive)| arrive),
            latch,
            samples: following.sources.iter().map(|one| one.state.samples).sum(),
            passed_over: following.passed_over,
        }
    }

    /// Returns where the wand steers the viewer.
    pub fn steering(&self) -> Steering {
        let wand = &lock(&self.shared.following).wand;
        let steering = wand.as_ref().map(Wand::steering);
        steering.unwrap_or_default()
    }

    /// Counts of bytes, samples and faults of all trackers so far.
    pub fn counts(&self) -> Counts {
        let all = lock(&self.shared.following);
        let all = all.sources.iter();
        all.fold(Counts::new(), |sum, one| sum.plus(&one.state.counts))
    }

    /// Returns how each of the trackers does.
    pub fn sources(&self) -> Vec<SourceState> {
        let all = lock(&self.shared.following);
        all.sources.iter().map(|one| one.state.clone()).collect()
    }
}

impl Following {
    fn leading(&self) -> &Followed {
        &self.sources[self.leading]
    }
}

impl Drop for LiveTracker {
    fn drop(&mut self) {
        self.shared.over.store(true, Ordering::SeqCst);
        // A thread that is still busy reporting is left alone.
        let begun = Instant::now();
        for thread in self.threads.drain(..) {
            while !thread.is_finished() && begun.elapsed() < PATIENCE {
                std::thread::sleep(PAUSE);
            }
            if thread.is_finished() {
                // A panic has printed its message.
                let _ = thread.join();
            }
        }
    }
}

fn listen(number: usize, source: Source, shared: &Shared, mut report: Report) {
    let Source {
        mut feed,
        mut intake,
    } = source;
    let is_live = feed.is_live();
    let mut sensors = [Thinning::NEW; 256];
    // Reported after the lock is released: reporting may take long.
    let mut events = Vec::with_capacity(EVENTS);
    while !shared.over.load(Ordering::SeqCst) {
        let now = feed.now();
        let mut troubles = Vec::new();
        feed.poll(now, &mut |notice| {
            let is_wand = intake.role() == Role::Wand;
            let steers = shared.wand_source == Some(number)
                && steer((number, is_wand), &notice, intake.at(now), shared);
            if steers && is_wand {
                return;
            }
            let sample = match &notice {
                Notice::Decoded(Event::Sample(sample)) => *sample,
                Notice::Decoded(Event::Message(message)) => {
                    if !matches!(intake.role(), Role::Head | Role::Wand) {
                        lock(&shared.following)
                            .gaze
                            .estimator
                            .on_message(message, &mut |_| {});
                    }
                    return report(TrackerEvent::Device(*message, now));
                }
                Notice::Decoded(_) => return,
                Notice::Trouble(trouble) => return troubles.push(*trouble),
                Notice::Offset { at, offset } => return intake.set_offset(*at, *offset),
                _ => return report(TrackerEvent::Feed(notice)),
            };
            let arrival = sample.arrival;
            let taken = intake.take(&sample, &mut |event| events.push(event));
            let mut following = lock(&shared.following);
            following.sources[number].state.samples += 1;
            let thinning = &mut sensors[usize::from(sample.sensor)];
            let before = thinning.one_of;
            let is_used = thinning.uses(arrival);
            if before == 1 && thinning.one_of > 1 {
                events.push(TrackerEvent::Flood(thinning.one_of, arrival));
            }
            let taken = taken.filter(|_| is_used);
            if let Some((sample, time)) = &taken {
                let role = intake.role();
                following.gaze.push(role, sample, *time, &mut |event| {
                    events.push(TrackerEvent::Gaze(event, arrival));
                });
                // A simulated sample comes when it is polled.
                let came = if is_live { arrival } else { now.max(arrival) };
                let came = intake.at(came);
                let own = &mut following.sources[number];
                own.newest = Some((*time, came));
                own.rhythm.hear(came);
                own.state.newest = Some(came);
                own.state.delay.saturating_record(came.since(*time).0);
            } else if !is_used {
                following.passed_over += 1;
            }
            drop(following);
            if taken.is_some() {
                shared.came.notify_all();
            }
            events.drain(..).for_each(&mut report);
        });
        let counts = feed.counts();
        for trouble in troubles {
            report(TrackerEvent::Trouble(trouble, counts));
        }
        let following = &mut *lock(&shared.following);
        following.sources[number].state.counts = counts;
        let steers = shared.wand_source == Some(number);
        if let Some(wand) = following.wand.as_mut().filter(|_| steers) {
            wand.is_present = feed.is_present();
        }
        if !is_live {
            std::thread::sleep(PAUSE);
        }
    }
}

/// Hands what a wand's source sends to the wand; returns whether it is an event of a device.
fn steer((number, is_wand): (usize, bool), notice: &Notice, now: Micros, shared: &Shared) -> bool {
    let following = &mut *lock(&shared.following);
    let Some(wand) = &mut following.wand else {
        return false;
    };
    match notice {
        Notice::Decoded(event) => {
            wand.hear(event);
            if is_wand
                && matches!(
                    event,
                    Event::Sample(_) | Event::Message(Message::Control(_))
                )
            {
                let own = &mut following.sources[number].state;
                own.samples += 1;
                own.newest = Some(now);
            }
            true
        }
        Notice::Unplugged { .. } => {
            wand.release();
            false
        }
        _ => false,
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
