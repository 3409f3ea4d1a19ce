//! The gaze of frames that follow a tracker.

use crate::cli::prelude::*;
use crate::cli::tracker::{Interrupt, Opened, TrackerName};
use crate::live::{LiveTracker, TrackerEvent};
use crate::tracker::Notice;
use shisen_core::gaze::HeadPose;
use shisen_tracker::decoder::Event;
use shisen_tracker::estimate::Estimate;
use shisen_tracker::time::Micros;

#[derive(Debug, Args)]
pub(super) struct TrackerArguments {
    /// Tracker to follow in place of --look and --head-report, whose origin is at --head: mock,
    /// mock:seed=7&rate=200&as=fastrak, serial:PORT?protocol=NAME, hid:VENDOR:PRODUCT or
    /// replay:FILE. Frame k is shown k + 1 refreshes after the start. Ctrl-C ends the command
    /// with the frames that are done
    #[arg(long, value_name = "SPEC",
          conflicts_with_all = ["look", "head_report", "up", "fixate", "fill"])]
    pub(super) tracker: Option<TrackerName>,
    /// File of `shisen tracker calibrate`, or with a [screen]; its [`room_from_tracker`] counts
    /// before --head
    #[arg(long, value_name = "TOML", requires = "tracker")]
    calibration: Option<PathBuf>,
    /// Frames to render
    #[arg(long, value_name = "N", default_value_t = 1, requires = "tracker",
          value_parser = whole::<u64>(1..=100_000))]
    pub(super) frames: u64,
    /// Frames shown per second
    #[arg(long, value_name = "HZ", default_value_t = 60, requires = "tracker",
          value_parser = whole::<u64>(1..=1_000))]
    pub(super) hz: u64,
}

#[derive(Debug, Error, Diagnostic)]
#[error("no sample came from {spec} in {} s", PATIENCE.0 / 1_000_000)]
#[diagnostic(help("see what comes with `shisen tracker monitor '{spec}'`"))]
struct Nothing {
    spec: String,
}

/// Longest wait for the first sample, after a reset if there is one.
const PATIENCE: Micros = Micros::from_millis(5_000);

/// Says where the viewer looks, frame after frame.
pub(super) struct Follower {
    source: Source,
    hz: u64,
    /// When frame 0 is due.
    start: Micros,
}

enum Source {
    /// A device. It is read while frames are traced, so that samples keep their times of arrival.
    Device(LiveTracker),
    /// A simulation or recording, which is read up to any time.
    Given(Box<Opened>),
}

impl Follower {
    /// Opens a tracker whose origin is at `head`, and waits for the first sample of a device.
    pub(super) fn new(
        name: &TrackerName,
        arguments: &TrackerArguments,
        head: HeadPose,
        interrupt: &Interrupt,
    ) -> Result<Self, Failure> {
        let mut given = Opened::new(&name.spec, arguments.calibration.as_deref(), head)?;
        let hz = arguments.hz;
        if !given.feed.is_live() {
            let (start, source) = (given.feed.begin(), Source::Given(Box::new(given)));
            return Ok(Self { source, hz, start });
        }
        let mut since = Micros(0);
        while given.take(Micros(0)) == 0 && !interrupt.came() {
            if given.feed.is_resetting() {
                since = given.feed.now();
            }
            if given.feed.now().since(since) > PATIENCE {
                let spec = name.to_string();
                return Err(Nothing { spec }.into());
            }
        }
        let start = given.feed.now();
        let source = Source::Device(given.listen()?);
        Ok(Self { source, hz, start })
    }

    /// Where the viewer looks when frame `number` is shown, by all samples that came until one
    /// refresh before.
    pub(super) fn frame(&mut self, number: u64) -> Estimate {
        let refresh = |count: u64| Micros(count * 1_000_000 / self.hz);
        let due = self.start.after(refresh(number));
        let shown = self.start.after(refresh(number + 1));
        match &mut self.source {
            Source::Device(tracker) => {
                while tracker.now() < due {
                    std::thread::sleep(Duration::from_micros(200));
                }
                // A frame that begins late is shown late.
                let late = tracker.now().since(due);
                tracker.latch(shown.after(late)).estimate
            }
            Source::Given(given) => {
                while given.take(due) > 0 {}
                given.estimator.estimate(shown, &mut |_| {})
            }
        }
    }
}

impl Opened {
    /// Takes what came until a time; returns the number of samples.
    fn take(&mut self, until: Micros) -> u64 {
        let (feed, clock) = (&mut self.feed, &mut self.clock);
        let (estimator, announcer) = (&mut self.estimator, &mut self.announcer);
        let mut samples = 0;
        let mut troubles = Vec::new();
        let now = feed.now();
        feed.poll(until, &mut |notice| match notice {
            Notice::Decoded(event) => match event {
                Event::Sample(sample) => {
                    let arrival = sample.arrival;
                    let stamp = clock.stamp(&sample, &mut |event| {
                        announcer.announce(TrackerEvent::Clock(event, arrival));
                    });
                    estimator.push(&sample, stamp.time, &mut |event| {
                        announcer.announce(TrackerEvent::Gaze(event, arrival));
                    });
                    samples += 1;
                }
                Event::Message(message) => {
                    estimator.on_message(&message, &mut |_| {});
                    announcer.announce(TrackerEvent::Device(message, now));
                }
                _ => {}
            },
            Notice::Trouble(trouble) => troubles.push(trouble),
            other => announcer.announce(TrackerEvent::Feed(other)),
        });
        let counts = feed.counts();
        for trouble in troubles {
            announcer.announce(TrackerEvent::Trouble(trouble, counts));
        }
        samples
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::tracker::pty::Pty;
    use crate::tracker::serve::{Begin, serve};
    use crate::tracker::{MockSpec, simulated};
    use std::sync::atomic::{AtomicBool, Ordering};

    #[test]
    fn samples_during_a_slow_frame_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line");
        let mut pty = Pty::open(&path).unwrap();
        let over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let source = simulated(&MockSpec::default()).unwrap();
                let (protocol, goes_on) = ("link".parse().unwrap(), &mut |_| {
                    !over.load(Ordering::Relaxed)
                });
                serve(&mut pty, source, &protocol, Begin::AtOnce, goes_on).unwrap();
            });
            let name = format!("serial:{}?protocol=link", path.display());
            let name: TrackerName = name.parse().unwrap();
            let arguments = TrackerArguments {
                tracker: None,
                calibration: None,
                frames: 1,
                hz: 60,
            };
            let (head, interrupt) = (HeadPose::IDENTITY, Interrupt::watched());
            let follower = Follower::new(&name, &arguments, head, &interrupt).unwrap();
            let Source::Device(tracker) = &follower.source else {
                panic!("it is a device");
            };
            let samples = || tracker.latch(tracker.now()).samples;
            let before = samples();
            std::thread::sleep(Duration::from_secs(1));
            assert!(samples() > before + 200);
            over.store(true, Ordering::Relaxed);
        });
    }
}
